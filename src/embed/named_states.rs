//! States that a text names, and lists of states up to a limit.

use std::sync::Arc;

use ahash::AHashSet;
use meliora_base::error::{Diagnostic, Error, Result, SourceFile};
use meliora_engine::{Count, Engine, Scope};
use meliora_lang::{Place, parse_states};
use meliora_model::{Program, State, VarId};
use meliora_question::number::Number;

/// Maximum number of reachable states among which one that is like an unreachable one is looked for.
const COMPARED: usize = 1000;

/// The states that texts name, such as `r=2,c=2`, or `r=2,c=*` where a variable has any value.
pub struct NamedStates(Vec<Named>);

/// A text with its meaning.
struct Named {
    source: Arc<SourceFile>,
    /// The value or values of each variable.
    places: Vec<Place>,
}

impl NamedStates {
    /// Reads the texts, which errors call `name`. Variables that a text leaves out have their initial values.
    ///
    /// # Errors
    /// A state is wrong. All errors of all states are reported together.
    pub fn read(program: &Program, name: &str, texts: &[String]) -> Result<Self> {
        let (mut named, mut wrong) = (Vec::new(), Vec::new());
        for text in texts {
            let source = SourceFile::new(name, text.as_str());
            match parse_states(&source, program) {
                Ok(places) => named.push(Named { source, places }),
                Err(Error::Input(diagnostics)) => wrong.extend(diagnostics),
                Err(error) => return Err(error),
            }
        }
        if wrong.is_empty() { Ok(NamedStates(named)) } else { Err(Error::Input(wrong)) }
    }

    /// Returns true without any text.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns the states. A text with `*` adds as many as the limit allows, without those listed
    /// before; if there are more, `tell` gets a sentence that says so.
    ///
    /// # Errors
    /// A state is not in the scope, or a limit is hit.
    pub fn states<E: Engine>(
        &self,
        engine: &E,
        program: &Program,
        limit: usize,
        tell: &dyn Fn(&str),
    ) -> Result<Vec<State>> {
        let all = engine.all_states();
        let (mut states, mut wrong): (Vec<State>, _) = (Vec::new(), Vec::new());
        for named in &self.0 {
            let found = match named.state() {
                Some(state) if engine.contains(&all, &state)? => vec![state],
                Some(_) => Vec::new(),
                None => {
                    let meant = engine.slice(&named.fixed(Place::value))?;
                    listed(engine, &meant, limit, tell)?.0
                }
            };
            if found.is_empty() {
                wrong.push(named.unreachable(engine, program)?);
            }
            let known: AHashSet<State> = match named.state() {
                Some(_) => AHashSet::new(),
                None => states.iter().cloned().collect(),
            };
            states.extend(found.into_iter().filter(|state| !known.contains(state)));
        }
        if wrong.is_empty() { Ok(states) } else { Err(Error::Input(wrong)) }
    }
}

impl Named {
    /// Returns the state, if the text names a single one.
    fn state(&self) -> Option<State> {
        self.places.iter().map(|place| place.value()).collect()
    }

    /// Returns the variables with a value of some kind.
    fn fixed(&self, value: fn(Place) -> Option<i64>) -> Vec<(VarId, i64)> {
        let places = (0..).zip(&self.places);
        places.filter_map(|(variable, place)| Some((VarId(variable), value(*place)?))).collect()
    }

    /// Describes a state that is not in the scope, and a state of the scope with the given values.
    fn unreachable<E: Engine>(&self, engine: &E, program: &Program) -> Result<Diagnostic> {
        let message = match self.state() {
            Some(state) => format!("no path reaches the state {}", program.show_state(&state)),
            None => "no path reaches a state with these values".to_owned(),
        };
        let diagnostic = Diagnostic::new(&self.source, 0..self.source.text.len(), message);
        // Monitors without a value begin in the state, which then is not reachable itself.
        let is_given = |at: &VarId| self.places[at.index()].given().is_some();
        let monitors = program.monitors.as_ref().map(|monitors| &monitors.variables);
        let help = match (monitors.filter(|all| all.iter().any(is_given)), engine.settings().scope) {
            (Some(monitors), _) => Some(at_the_start(program, monitors)),
            (None, Scope::Reachable) => Some("`--scope all` accepts every valuation as a state".to_owned()),
            (None, Scope::All) => None,
        };
        let diagnostic = self.reachable(engine, program)?.into_iter().fold(diagnostic, Diagnostic::note);
        Ok(help.into_iter().fold(diagnostic, Diagnostic::help))
    }

    /// Names a state of the scope with the values of the text that differs in the fewest others.
    fn reachable<E: Engine>(&self, engine: &E, program: &Program) -> Result<Option<String>> {
        let like = engine.slice(&self.fixed(Place::given))?;
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
        let value = |at: usize, value: i64| program.variables[at].equation(value);
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

/// Returns the advice for a state that no path reaches with these values of the monitors.
fn at_the_start(program: &Program, monitors: &[VarId]) -> String {
    let names =
        monitors.iter().map(|at| format!("`{}`", program.variables[at.index()].name)).collect::<Vec<_>>();
    format!("leave out {}: their values are then those at the start of a path", names.join(", "))
}

/// Lists the states of a set up to a limit, and counts the set; if there are more, `tell` gets a text
/// that says so.
pub fn listed<E: Engine>(
    engine: &E,
    set: &E::States,
    limit: usize,
    tell: &dyn Fn(&str),
) -> Result<(Vec<State>, Count)> {
    let (states, count) = (engine.list_states(set, limit)?, engine.count(set)?);
    if count > Count::from(states.len()) {
        let (listed, all) = (states.len(), Number(count.clone()).grouped());
        tell(&format!("{listed} of {all} states; a larger `--limit` lists more"));
    }
    Ok((states, count))
}
