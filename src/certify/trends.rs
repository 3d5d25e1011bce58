//! The engines with the edges of one trend, for layers and rounds whose steps lead into themselves.

use std::collections::BTreeSet;

use super::error::{CheckError, CheckResult};
use meliora_dump::Manifest;
use meliora_dump::manifest::{self, Root};
use meliora_engine::symbolic::SymbolicEngine;
use meliora_model::trend::{Digit, Trend};

/// The engines of the trends that occur in a certificate.
pub(super) struct Trends(Vec<(Trend, SymbolicEngine)>);

impl Trends {
    /// Checks which roots have a trend, and the order of the variables that defines it; builds the
    /// engines.
    pub(super) fn new(engine: &SymbolicEngine, dump: &Manifest) -> CheckResult<Self> {
        let named = ["layers:", "refuted:"];
        let proof = dump.certificate.iter().flat_map(|file| &file.roots);
        let is_proof = |root: &Root| named.iter().any(|start| root.name.starts_with(start));
        let others = dump.regions.roots.iter().chain(proof.clone().filter(|root| !is_proof(root)));
        if let Some(root) = others.clone().find(|root| root.trend.is_some()) {
            let condition = format!("`{}` has no trend: it is neither a layer nor a round", root.name);
            return Err(CheckError::violated(condition, None));
        }
        let used = |trend: &Trend| proof.clone().any(|root| root.trend == Some(*trend));
        let used = Vec::from_iter(Trend::ALL.into_iter().filter(used));
        let order = order(engine, dump, !used.is_empty())?;
        let with = |trend: Trend| Ok((trend, engine.with_trend(&order, trend)?));
        Ok(Trends(used.into_iter().map(with).collect::<CheckResult<_>>()?))
    }

    /// Returns the engine with the edges of a trend.
    pub(super) fn engine(&self, trend: Trend) -> CheckResult<&SymbolicEngine> {
        let found = self.0.iter().find(|(own, _)| *own == trend).map(|(_, engine)| engine);
        found.ok_or_else(|| CheckError::violated("only layers and rounds have a trend", None))
    }
}

/// Returns the order of the variables: each of them once if it is used, else none.
fn order(engine: &SymbolicEngine, dump: &Manifest, is_used: bool) -> CheckResult<Vec<Digit>> {
    let program = engine.program();
    let names = dump.certificate.as_ref().map_or(&[][..], |file| &file.order);
    let digit = |named: &manifest::Digit| {
        Some(Digit { variable: program.variable(&named.variable)?, reversed: named.reversed })
    };
    let order = Vec::from_iter(names.iter().filter_map(digit));
    let all = if is_used { program.variables.len() } else { 0 };
    let distinct = order.iter().map(|digit| digit.variable).collect::<BTreeSet<_>>().len();
    if [names.len(), order.len(), distinct] != [all; 3] || !dump.regions.order.is_empty() {
        let condition = "the certificate orders each variable of the model once if a layer or round has a trend, else none";
        return Err(CheckError::violated(condition, None));
    }
    Ok(order)
}
