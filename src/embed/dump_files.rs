//! The directory of a dump: regions, values and a certificate.

use std::path::Path;
use std::sync::Arc;

use super::{Analysis as OwnAnalysis, Kept, Task, Work};
use meliora_base::error::{Limit, Result, SourceFile};
use meliora_dump::Dump;
use meliora_dump::directory::{check_directory, complete_directory, sha256, write_regions_first};
use meliora_engine::{Engine, SymbolicEngine};
use meliora_export::bounds::{self, Wanted};
use meliora_export::{DumpContent, Inputs, certify, export};
use meliora_model::region::RegionName;
use meliora_planning::Analysis;
use meliora_quantities::Values;
use meliora_quantities::choose::LEVELS;
use meliora_quantities::cost::Costs;
use meliora_report::{ExportReport, Header};

/// The contents of a dump.
#[derive(Debug, Clone, Copy)]
pub struct DumpOptions<'a> {
    /// The names of the regions, in which `*` stands for any text and `?` for one character; empty for all regions.
    pub regions: &'a [String],
    /// Adds the certificate, which needs all regions.
    pub certificate: bool,
    /// Adds a picture of each region in the language DOT.
    pub dot: bool,
    /// Adds the values of states.
    pub values: Option<DumpValues<'a>>,
}

/// The values in a dump.
#[derive(Debug, Clone, Copy)]
pub struct DumpValues<'a> {
    /// The greatest number of improvements; `None` for the levels found, at most 10.
    pub levels: Option<usize>,
    /// The name of the cost of a step.
    pub reward: &'a str,
    /// The cost of a step.
    pub costs: &'a Costs,
    /// The maximum number of states.
    pub limit: usize,
    /// The largest width of a bound, for the report.
    pub precision: f64,
}

impl OwnAnalysis {
    /// Writes a dump with a certificate into a directory, as `meliora export` does; an older dump there
    /// is replaced. `preferences` is their text. Cost: the analysis once more, with the diagrams and the remembered results
    /// of the symbolic engine, and then one image per layer of each region. The states of an explicit engine are
    /// explored again as diagrams.
    ///
    /// # Errors
    /// See [`write_dump`]; the directory contains something else; an objective is called `nothing`.
    pub fn export(&self, preferences: &Arc<SourceFile>, directory: &Path) -> Result<()> {
        check_directory(directory)?;
        let (program, settings) = (self.exploration().own_program(), self.whole_engine().settings().clone());
        let kept = Kept::new(ExportReport::to_directory(Header::default(), ""), Arc::clone(&settings.sink));
        // Other players than those of the engine's program need a program of their own.
        let engine = match self.whole_engine().symbolic() {
            Some(engine) if Arc::ptr_eq(engine.program(), &program) => Arc::clone(engine),
            _ => Arc::new(SymbolicEngine::new(Arc::clone(&program), settings)?),
        };
        let own = Arc::new(self.preferences().clone());
        let mut analysis = Analysis::new(&engine, &own, self.options());
        analysis.run(&mut |_| ())?;
        let names = (program.source.name.clone(), preferences.name.clone());
        let task = Task { program, preferences: own, source: Arc::clone(preferences), overlap: None };
        let options = DumpOptions { regions: &[], certificate: true, dot: false, values: None };
        write_dump(&kept, (&analysis, &task), names, options, directory)
    }
}

/// Writes the dump of a complete analysis into a directory; an older dump there is replaced. `model` and `preferences` are
/// the names of their files. The report has the regions as soon as they are written. Cost: see [`export`] and [`certify`].
///
/// # Errors
/// The directory cannot be written; a limit is reached, which leaves the regions if it ends the certificate.
pub fn write_dump(
    work: &dyn Work<ExportReport>,
    (analysis, task): (&Analysis<SymbolicEngine>, &Task),
    (model, preferences): (String, String),
    options: DumpOptions<'_>,
    out: &Path,
) -> Result<()> {
    let hash = |text: &str| sha256(text.as_bytes());
    let inputs = Inputs {
        model: (model, hash(task.program.source.original())),
        preferences: (preferences, hash(task.source.original())),
    };
    let all = options.regions.is_empty();
    let named = |name: &String| options.regions.iter().any(|pattern| matches(pattern, name));
    let wanted = |name: &RegionName| all || named(&name.to_string());
    let content = DumpContent { wanted: &wanted, certificate: false };
    let mut dump = work.timed("dump", || export(analysis, &inputs, &content), |_, _| ())?;
    // Before anything is written: if there are no values, an older dump stays as it is.
    let mut width = None;
    if let Some(DumpValues { levels, reward, costs, limit, .. }) = options.values {
        let costs = costs.check(analysis.engine(), &task.program)?;
        let levels = levels.unwrap_or_else(|| Values::levels_found(analysis, LEVELS));
        let wanted = Wanted { levels, reward, costs: &*costs, limit };
        let add = || bounds::add(&mut dump, analysis, &wanted);
        width = Some(work.timed("values", add, |_, _| ())?);
    }
    let certifies = all && options.certificate;
    if certifies {
        certified(work, out, options.dot, analysis, &mut dump)?;
    }
    let sink = work.sink();
    let write = || match certifies {
        true => complete_directory(&mut dump, out, &*sink),
        false => write_regions_first(&mut dump, out, options.dot, &*sink),
    };
    work.timed("write", write, |_, _| ())?;
    let manifest = dump.manifest;
    let peak = analysis.whole_engine().usage().peak_nodes;
    work.update(|r| {
        r.set(&manifest);
        r.set_values(&manifest, width, options.values.map_or(0.0, |values| values.precision));
        r.memory.peak_nodes = peak;
    });
    let open = manifest.certificate.map_or(0, |file| file.uncertified.len());
    if open == 0 {
        return Ok(());
    }
    // The limit has ended a part of this phase.
    work.part("certificate", "");
    Err(Limit::Uncertified(open).into())
}

/// Writes the dump, and then adds its certificate: a limit that ends this leaves the regions.
fn certified(
    work: &dyn Work<ExportReport>,
    out: &Path,
    dot: bool,
    analysis: &Analysis<SymbolicEngine>,
    dump: &mut Dump,
) -> Result<()> {
    // The values come with the certificate, which proves them.
    let values = (dump.values.take(), dump.manifest.values.take());
    let sink = work.sink();
    let write = || write_regions_first(dump, out, dot, &*sink);
    work.timed("write", write, |_, _| ())?;
    work.update(|r| r.set_uncertified(&dump.manifest));
    let add = || certify(dump, analysis, &mut |left| work.share(left));
    work.timed("certificate", add, |_, _| ())?;
    (dump.values, dump.manifest.values) = values;
    Ok(())
}

/// Returns whether a name matches a pattern, in which `*` stands for any text and `?` for one character.
fn matches(pattern: &str, name: &str) -> bool {
    let mut rest = pattern.chars();
    match rest.next() {
        None => name.is_empty(),
        Some('*') => {
            let ends = name.char_indices().map(|(at, _)| at).chain([name.len()]);
            ends.into_iter().any(|at| matches(rest.as_str(), &name[at..]))
        }
        Some(sign) => {
            let mut left = name.chars();
            left.next().is_some_and(|c| sign == '?' || sign == c) && matches(rest.as_str(), left.as_str())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::matches;

    #[test]
    fn patterns_match_whole_names() {
        for (pattern, name) in
            [("sasi:*", "sasi:12"), ("*", ""), ("*:A*", "strategy:almost-sure:A"), ("spi:?", "spi:3")]
        {
            assert!(matches(pattern, name), "{pattern} {name}");
        }
        for (pattern, name) in
            [("sasi:*", "strategy:sasi:1"), ("spi:?", "spi:12"), ("spi:?", "spi:"), ("", "x")]
        {
            assert!(!matches(pattern, name), "{pattern} {name}");
        }
    }
}
