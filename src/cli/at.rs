//! `--at`: the states that the user names, and lists of states up to a limit.

use std::sync::Arc;

use meliora_engine::{Count, Engine, Scope};
use meliora_lang::{Place, parse_states};
use meliora_model::error::{Diagnostic, Error, SourceFile};
use meliora_model::expr::ExprId;
use meliora_model::value::{Binary, Type, Value};
use meliora_model::{Program, State, VarId};
use meliora_report::Number;

use super::progress::TerminalSink;

/// Maximum number of reachable states among which one that is like an unreachable one is looked for.
const COMPARED: usize = 1000;

/// The states that `--at` names.
pub(super) struct At(Vec<Named>);

/// The text of one `--at`, with its meaning.
struct Named {
    source: Arc<SourceFile>,
    /// The value or values of each variable.
    places: Vec<Place>,
    /// The states with the values that the text gives.
    like: ExprId,
    /// The states with these values, and those of the variables left out.
    meant: ExprId,
}

impl At {
    /// Reads the texts, and adds conditions for the states to the program.
    ///
    /// # Errors
    /// A state is wrong. All errors of all states are reported together.
    pub(super) fn read(program: &mut Arc<Program>, texts: &[String]) -> Result<Self, Error> {
        let (mut named, mut wrong) = (Vec::new(), Vec::new());
        for text in texts {
            let source = SourceFile::new("--at", text.as_str());
            match parse_states(&source, program) {
                Ok(places) => named.push(Named::of(Arc::make_mut(program), source, places)),
                Err(Error::Input(diagnostics)) => wrong.extend(diagnostics),
                Err(error) => return Err(error),
            }
        }
        if wrong.is_empty() { Ok(At(named)) } else { Err(Error::Input(wrong)) }
    }

    /// Returns true if `--at` is not given.
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns the states, each once, and for a text with `*` as many as the limit allows.
    ///
    /// # Errors
    /// A state is not in the scope, or a limit is hit.
    pub(super) fn states<E: Engine>(
        &self,
        engine: &E,
        program: &Program,
        (scope, limit): (Scope, usize),
        sink: &TerminalSink,
    ) -> Result<Vec<State>, Error> {
        let (mut states, mut wrong) = (Vec::new(), Vec::new());
        for named in &self.0 {
            let meant = engine.intersection(&engine.states_where(named.meant)?, &engine.all_states())?;
            let found = match named.state() {
                Some(_) => engine.list_states(&meant, 1)?,
                None => {
                    let (found, count) = up_to(engine, &meant, limit)?;
                    if let Some(text) = incomplete(found.len(), &count) {
                        sink.warn(&text);
                    }
                    found
                }
            };
            if found.is_empty() {
                wrong.push(named.unreachable(engine, program, scope)?);
            }
            let new = found.into_iter().filter(|state| named.state().is_some() || !states.contains(state));
            states.extend(new.collect::<Vec<_>>());
        }
        if wrong.is_empty() { Ok(states) } else { Err(Error::Input(wrong)) }
    }
}

impl Named {
    fn of(program: &mut Program, source: Arc<SourceFile>, places: Vec<Place>) -> Self {
        let all: Vec<_> = places.iter().copied().enumerate().collect();
        let given = all.iter().filter_map(|&(at, place)| match place {
            Place::Given(value) => Some((at, value)),
            Place::Default(_) | Place::Any => None,
        });
        let left_out = all.iter().filter_map(|&(at, place)| match place {
            Place::Default(value) => Some((at, value)),
            Place::Given(_) | Place::Any => None,
        });
        let like = equal(program, None, given);
        let meant = equal(program, Some(like), left_out);
        Named { source, places, like, meant }
    }

    /// Returns the state, if the text names a single one.
    fn state(&self) -> Option<State> {
        let value = |place: &Place| match place {
            Place::Given(value) | Place::Default(value) => Some(*value),
            Place::Any => None,
        };
        self.places.iter().map(value).collect()
    }

    /// Describes a state that is not in the scope, and a state of the scope with the given values.
    fn unreachable<E: Engine>(
        &self,
        engine: &E,
        program: &Program,
        scope: Scope,
    ) -> Result<Diagnostic, Error> {
        let message = match self.state() {
            Some(state) => format!("no path reaches the state {}", program.show_state(&state)),
            None => "no path reaches a state with these values".to_owned(),
        };
        let diagnostic = Diagnostic::new(&self.source, 0..self.source.text.len(), message);
        let help = match (&program.monitors, scope) {
            (Some(monitors), _) => Some(at_the_start(program, &monitors.variables)),
            (None, Scope::Reachable) => Some("`--scope all` accepts every valuation as a state".to_owned()),
            (None, Scope::All) => None,
        };
        let diagnostic = self.reachable(engine, program)?.into_iter().fold(diagnostic, Diagnostic::note);
        Ok(help.into_iter().fold(diagnostic, Diagnostic::help))
    }

    /// Names a state of the scope with the values of the text that differs in the fewest others.
    fn reachable<E: Engine>(&self, engine: &E, program: &Program) -> Result<Option<String>, Error> {
        let like = engine.intersection(&engine.states_where(self.like)?, &engine.all_states())?;
        let differs = |state: &State| -> Vec<usize> {
            let other = |at: &usize| matches!(self.places[*at], Place::Default(value) if value != state[*at]);
            (0..self.places.len()).filter(other).collect()
        };
        let states = engine.list_states(&like, COMPARED)?;
        let nearest = states.iter().map(differs).min_by_key(Vec::len).unwrap_or_default();
        let Some(state) = states.iter().find(|state| differs(state) == nearest) else { return Ok(None) };
        if nearest.is_empty() {
            return Ok(None);
        }
        let value = |at: usize, value: i64| {
            let variable = &program.variables[at];
            format!("{}={}", variable.name, variable.show(value))
        };
        let defaults: Vec<String> = nearest
            .iter()
            .filter_map(|&at| program.variables[at].initial.map(|initial| value(at, initial)))
            .collect();
        let others: Vec<String> = nearest.iter().map(|&at| value(at, state[at])).collect();
        Ok(Some(format!(
            "variables left out have their initial values ({}); a path reaches the state with {}",
            defaults.join(","),
            others.join(",")
        )))
    }
}

/// Adds the condition that variables have these values, and `before`.
fn equal(
    program: &mut Program,
    before: Option<ExprId>,
    values: impl Iterator<Item = (usize, i64)>,
) -> ExprId {
    let mut all = before.unwrap_or_else(|| program.pool.value(Value::Bool(true)));
    for (at, value) in values {
        let ty = program.variables[at].ty;
        let value = if ty == Type::Bool { Value::Bool(value != 0) } else { Value::Int(value) };
        let (variable, value) = (program.pool.var(VarId(at as u32), ty), program.pool.value(value));
        let same = program.pool.binary(Binary::Eq, variable, value);
        all = program.pool.binary(Binary::And, all, same);
    }
    all
}

/// Returns the advice for a state that no path reaches with these values of the monitors.
fn at_the_start(program: &Program, monitors: &[VarId]) -> String {
    let names =
        monitors.iter().map(|at| format!("`{}`", program.variables[at.index()].name)).collect::<Vec<_>>();
    format!("leave out {}: their values are then those at the start of a path", names.join(", "))
}

/// Lists the states of a set up to a limit, with a note if there are more, and counts the set.
///
/// # Errors
/// A limit of the engine is reached.
pub(super) fn listed<E: Engine>(
    engine: &E,
    set: &E::States,
    limit: usize,
    sink: &TerminalSink,
) -> Result<(Vec<State>, Count), Error> {
    let (states, count) = up_to(engine, set, limit)?;
    if let Some(text) = incomplete(states.len(), &count) {
        sink.note(&text);
    }
    Ok((states, count))
}

/// Lists the states of a set up to a limit, and counts the set.
fn up_to<E: Engine>(engine: &E, set: &E::States, limit: usize) -> Result<(Vec<State>, Count), Error> {
    Ok((engine.list_states(set, limit)?, engine.count(set)?))
}

/// Says that a list has fewer states than there are, if this is so.
fn incomplete(listed: usize, count: &Count) -> Option<String> {
    let text = || {
        let all = Number(count.clone()).grouped();
        format!("{listed} of {all} states; a larger `--limit` lists more")
    };
    (*count > Count::from(listed)).then(text)
}
