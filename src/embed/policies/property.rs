//! The strategy of one operator: what `reach --policy` writes for a property that asks for a number, or has a bound.

use std::sync::Arc;

use super::mix::measured;
use crate::embed::Work;
use meliora_base::decimal::readable;
use meliora_base::error::{Error, Result, SourceFile};
use meliora_base::exact::Real;
use meliora_base::random::Draw;
use meliora_engine::{ExplicitEngine, Settings};
use meliora_lang::parse_property;
use meliora_lang::property::{Named, Term};
use meliora_model::{Program, State};
use meliora_planning::Sample;
use meliora_quantities::PRECISION;
use meliora_quantities::state_values::Bound;
use meliora_question::evaluate::{Evaluator, Model, Number, Played, attains};
use meliora_question::strategies::MOST_STATES;
use meliora_report::PolicyReport;
use meliora_report::mix::File;
use meliora_report::policy_report::{ObjectiveValue, PolicyRuns, StrategyValues};
use meliora_report::property_policy::ReadPolicy;
use meliora_space::initial::initial_states;

/// A strategy with its model.
pub(super) struct OfProperty {
    program: Arc<Program>,
    source: Arc<SourceFile>,
    /// The property, in a text of its own.
    property: Arc<SourceFile>,
    term: Term,
    file: File,
    settings: Settings,
}

/// Reads the property of a file.
///
/// # Errors
/// It is none of the model.
pub(super) fn property(
    source: &SourceFile,
    file: &File,
    program: &Program,
) -> Result<(Arc<SourceFile>, Term)> {
    let property = SourceFile::new(format!("the property of {}", source.name), file.property.clone());
    let term = parse_property(&property)?.term(program, &property, &Named::default())?;
    Ok((property, term))
}

impl OfProperty {
    pub(super) fn new(
        source: &Arc<SourceFile>,
        file: File,
        (property, term): (Arc<SourceFile>, Term),
        program: Program,
        settings: Settings,
    ) -> Self {
        let (program, source) = (Arc::new(program), Arc::clone(source));
        OfProperty { program, source, property, term, file, settings }
    }

    /// Checks that the strategy attains the value that it claims, or runs it.
    ///
    /// # Errors
    /// The file is wrong, or about another model; a limit.
    pub(super) fn work(&self, work: &dyn Work<PolicyReport>, runs: Option<&PolicyRuns>) -> Result<()> {
        let OfProperty { program, source, property, term, file, settings } = self;
        let build =
            |program: &Arc<Program>| ExplicitEngine::new(Arc::clone(program), settings.clone()).map(Arc::new);
        let engine = build(program)?;
        let model = Model::new(&*engine, program, &build, PRECISION);
        let played = Evaluator::new(&model, property).played_by(term, file.is_of_opponent())?;
        let read = file.policy(source, program, played.watched.as_deref())?;
        if let Some(state) = self.missing_start(&read)? {
            let what = "no node starts in an initial state, or one in another state";
            work.update(|r| r.refuse(program, what, Some(&state)));
            return Ok(());
        }
        match runs {
            Some(runs) => self.run(work, &played, &read, runs),
            None => self.check(work, &played, &read),
        }
    }

    /// Returns the program whose states the nodes state: with monitors, if they remember these.
    fn of_nodes<'p>(&'p self, played: &'p Played<'_>, read: &ReadPolicy) -> &'p Arc<Program> {
        played.watched.as_ref().filter(|_| read.is_watched).unwrap_or(&self.program)
    }

    fn check(&self, work: &dyn Work<PolicyReport>, played: &Played<'_>, read: &ReadPolicy) -> Result<()> {
        let OfProperty { program, property, settings, .. } = self;
        let (watched, nodes) = (self.of_nodes(played, read), (&read.nodes[..], read.starts));
        let value = |precision| played.value((program, watched), nodes, (property, settings), precision);
        let mut found = match value(PRECISION)? {
            Ok(found) => found,
            Err(fault) => {
                work.update(|r| r.refuse(program, &fault.kind.to_string(), Some(&fault.state)));
                return Ok(());
            }
        };
        let claim = claimed(read);
        let decides = |found: &Number| attains(found, &claim, played.is_great()).zip(played.satisfies(found));
        if decides(&found).is_none()
            && let Ok(exact) = value(0.0)?
        {
            found = exact;
        }
        let shown = self.shown(read, Some(found.interval.into()));
        work.update(|r| r.strategies = vec![shown]);
        let refuse = |what: &str| work.update(|r| r.refuse(program, what, None));
        match decides(&found) {
            Some((true, true)) => work.update(|r| r.accepted = Some(Some(true))),
            Some((false, _)) => {
                let worse = if played.is_great() { "less" } else { "more" };
                let value = readable(found.interval.middle());
                let claim = readable(claim.to_f64());
                refuse(&format!("the strategy attains {value}, {worse} than the {claim} that it claims"));
            }
            Some((_, false)) => refuse("the strategy does not satisfy the property"),
            None => {
                let what = "the bounds of the value do not decide whether the strategy attains its claim";
                return Err(Error::Usage(what.to_owned()));
            }
        }
        Ok(())
    }

    /// Returns the strategy as the report shows it.
    fn shown(&self, read: &ReadPolicy, value: Option<Bound>) -> StrategyValues {
        let objective = self.file.property.clone();
        let objective = ObjectiveValue { objective, claimed: claimed(read).to_f64(), value };
        StrategyValues { share: Some(1.0), nodes: read.nodes.len() as u64, objectives: vec![objective] }
    }

    /// Runs the strategy, and measures its value.
    fn run(
        &self,
        work: &dyn Work<PolicyReport>,
        played: &Played<'_>,
        read: &ReadPolicy,
        runs: &PolicyRuns,
    ) -> Result<()> {
        let program = &self.program;
        let prepared = match played.runs(program, self.of_nodes(played, read), (&read.nodes, read.starts))? {
            Ok(prepared) => prepared,
            Err(fault) => {
                work.update(|r| r.refuse(program, &fault.kind.to_string(), Some(&fault.state)));
                return Ok(());
            }
        };
        work.update(|r| r.strategies = vec![self.shown(read, None)]);
        let (mut sample, mut endless, mut decided) = (Sample::new(1), false, 0);
        for number in 0..runs.runs {
            work.check()?;
            let run = prepared.run(runs.limit, &mut Draw::numbered(runs.seed, number));
            if number == 0 {
                let steps = run.steps.iter().map(|&step| {
                    let (node, position) = prepared.taken(step);
                    let names = program.choices(&node.state).unwrap_or_default();
                    let name = names.into_iter().nth(position).map(|(_, name)| name);
                    (node.state.clone(), name.unwrap_or_default())
                });
                let (steps, last) = (steps.collect(), &read.nodes[run.last].state);
                work.update(|r| r.show_run(program, steps, last));
            }
            endless |= run.value == Some(f64::INFINITY);
            decided += u64::from(run.value.is_some());
            match run.value {
                None => sample.miss(true),
                Some(0.0) if played.is_probability() => sample.miss(false),
                Some(value) => sample.reach(value),
            }
        }
        let (objective, claim) = (self.file.property.clone(), claimed(read).to_f64());
        let found = measured(objective, claim, &sample, played.is_probability(), endless);
        work.update(|r| {
            if let Some(runs) = &mut r.runs {
                (runs.reached, runs.given_up) = (decided, runs.runs - decided);
                runs.objectives = vec![found];
            }
        });
        Ok(())
    }

    /// Returns an initial state in which no node starts, or the state of a start that is not initial.
    fn missing_start(&self, read: &ReadPolicy) -> Result<Option<State>> {
        let mut initial = initial_states(&self.program, MOST_STATES, &*self.settings.sink)?;
        let mut starts: Vec<State> =
            read.nodes[..read.starts].iter().map(|node| node.state.clone()).collect();
        initial.sort_unstable();
        starts.sort_unstable();
        let differs = initial.iter().zip(&starts).find(|(initial, start)| initial != start);
        let missing = initial.get(starts.len()).or_else(|| starts.get(initial.len()));
        Ok(differs.map(|(initial, _)| initial).or(missing).cloned())
    }
}

fn claimed(read: &ReadPolicy) -> Real {
    read.value.clone().map_or(Real::Infinite(false), Real::Finite)
}
