//! The engines with the edges of one trend, for layers and rounds whose steps lead into themselves.

use std::collections::BTreeSet;

use super::condition::Condition;
use super::error::{CheckError, CheckResult};
use meliora_dump::Manifest;
use meliora_dump::manifest::{self, File, Root};
use meliora_engine::symbolic::SymbolicEngine;
use meliora_model::Variable;
use meliora_model::region::RegionName;
use meliora_model::trend::{Digit, Trend};

/// The engines of the trends that occur in a certificate.
pub(super) struct Trends {
    /// The engines of layers, and of rounds that have no order of their own.
    shared: Engines,
    /// The engines of rounds that have one.
    of_rounds: Option<Engines>,
}

type Engines = Vec<(Trend, SymbolicEngine)>;

impl Trends {
    /// Checks which roots have a trend, and the orders of the variables that define the trends; builds
    /// the engines.
    pub(super) fn new(engine: &SymbolicEngine, dump: &Manifest) -> CheckResult<Self> {
        let none = File::default();
        let file = dump.certificate.as_ref().unwrap_or(&none);
        let name = |root: &Root| RegionName::from(root.name.as_str());
        let is_round = |root: &Root| name(root).is_round();
        let is_proof = |root: &Root| is_round(root) || matches!(name(root), RegionName::Layer(..));
        let mut others = dump.regions.roots.iter().chain(file.roots.iter().filter(|root| !is_proof(root)));
        if let Some(root) = others.find(|root| root.trend.is_some()) {
            let condition = Condition::NoTrend { name: root.name.clone() };
            return Err(CheckError::violated(condition, None));
        }
        let used = |is_meant: &dyn Fn(&Root) -> bool| {
            let has =
                |trend: &Trend| file.roots.iter().any(|root| root.trend == Some(*trend) && is_meant(root));
            Vec::from_iter(Trend::ALL.into_iter().filter(has))
        };
        let has_own = !file.order_of_rounds.is_empty();
        let in_rounds = used(&is_round);
        let shared = used(&|root| !(has_own && is_round(root)));

        let is_used = !shared.is_empty() || !in_rounds.is_empty();
        let order = checked(engine, &file.order, is_used, Condition::OrderOfVariables)?;
        let is_used = has_own && !in_rounds.is_empty();
        let own = checked(engine, &file.order_of_rounds, is_used, Condition::OrderOfRounds)?;
        if !dump.regions.order.is_empty() || !dump.regions.order_of_rounds.is_empty() {
            return Err(CheckError::violated(Condition::OrderInCertificate, None));
        }
        let of_rounds = has_own.then(|| engines(engine, &own, &in_rounds)).transpose()?;
        Ok(Trends { shared: engines(engine, &order, &shared)?, of_rounds })
    }

    /// Returns the engine with the edges of a trend of a layer.
    pub(super) fn of_layer(&self, trend: Trend) -> CheckResult<&SymbolicEngine> {
        find(&self.shared, trend)
    }

    /// Returns the engine with the edges of a trend of a round.
    pub(super) fn of_round(&self, trend: Trend) -> CheckResult<&SymbolicEngine> {
        find(self.of_rounds.as_ref().unwrap_or(&self.shared), trend)
    }
}

fn find(engines: &Engines, trend: Trend) -> CheckResult<&SymbolicEngine> {
    let found = engines.iter().find(|(own, _)| *own == trend).map(|(_, engine)| engine);
    found.ok_or_else(|| CheckError::violated(Condition::TrendOfProof, None))
}

fn engines(engine: &SymbolicEngine, order: &[Digit], used: &[Trend]) -> CheckResult<Engines> {
    used.iter().map(|&trend| Ok((trend, engine.with_trend(order, trend)?))).collect()
}

/// Returns an order of the variables: each of them once if it is used, else none.
fn checked(
    engine: &SymbolicEngine,
    names: &[manifest::Digit],
    is_used: bool,
    condition: Condition,
) -> CheckResult<Vec<Digit>> {
    let program = engine.program();
    let digit = |named: &manifest::Digit| {
        let variable = program.variable(&named.variable)?;
        let low = program.variables[variable.index()].low;
        let values = named.values.iter().map(|value| value.wrapping_sub(low) as u64).collect();
        Some(Digit { variable, reversed: named.reversed, steady: named.steady, values })
    };
    let order = Vec::from_iter(names.iter().filter_map(digit));
    let all = if is_used { program.variables.len() } else { 0 };
    let distinct = order.iter().map(|digit| digit.variable).collect::<BTreeSet<_>>().len();
    if [names.len(), order.len(), distinct] != [all; 3] {
        return Err(CheckError::violated(condition, None));
    }
    for (digit, named) in order.iter().zip(names) {
        orders_values(&program.variables[digit.variable.index()], &named.values)?;
    }
    Ok(order)
}

/// Checks that an order of the values of a variable, if there is one, has each of them once.
fn orders_values(variable: &Variable, values: &[i64]) -> CheckResult {
    let is_value = |value: &i64| (variable.low..=variable.high).contains(value);
    let distinct = BTreeSet::from_iter(values).len();
    let all = i128::from(variable.high) - i128::from(variable.low) + 1;
    let has_all = values.iter().all(is_value) && distinct == values.len() && distinct as i128 == all;
    if values.is_empty() || has_all {
        return Ok(());
    }
    let condition = Condition::OrderOfValues { variable: variable.name.clone() };
    Err(CheckError::violated(condition, None))
}
