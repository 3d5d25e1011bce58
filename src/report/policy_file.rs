//! Files of policies: the text of planners, `If holds: … Execute: …`, and a list in JSON.

use std::ops::Range;
use std::sync::Arc;

use ahash::AHashMap;
use serde::Deserialize;

use meliora_base::error::{Diagnostic, Result, SourceFile};
use meliora_base::value::Type;
use meliora_model::planning::{Named, plain};
use meliora_model::{Program, State, VarId};
use meliora_planning::rules::{Literal, Rules};

/// An entry in JSON; further fields do not count.
#[derive(Deserialize)]
struct Entry {
    state: Vec<String>,
    action: String,
}

/// Reads a policy. A rule that names all facts of a state is about this state; others hold wherever their
/// facts do, the first one first.
///
/// # Errors
/// The text is wrong, or names another thing than facts; with its place.
pub fn read(source: &Arc<SourceFile>, program: &Program) -> Result<Rules> {
    let mut reader = Reader { source, program, facts: facts(program), rules: Rules::default() };
    if source.text.trim_start().starts_with('[') {
        reader.json()?;
    } else {
        reader.text()?;
    }
    Ok(reader.rules)
}

/// Returns the facts of a planning problem by their names in small letters; none for other models.
fn facts(program: &Program) -> AHashMap<String, (VarId, i64)> {
    let facts = program.planning.iter().flat_map(|planning| &planning.facts);
    facts.map(|fact| (plain(&fact.name), (fact.variable, fact.value))).collect()
}

/// Returns the place of an error in a text.
pub(super) fn place(source: &SourceFile, error: &serde_json::Error) -> Range<usize> {
    let lines = source.text.split_inclusive('\n').take(error.line().saturating_sub(1));
    let at = lines.map(str::len).sum::<usize>() + error.column().saturating_sub(1);
    let at = at.min(source.text.len());
    at..at
}

struct Reader<'a> {
    source: &'a Arc<SourceFile>,
    program: &'a Program,
    facts: AHashMap<String, (VarId, i64)>,
    rules: Rules,
}

impl Reader<'_> {
    fn text(&mut self) -> Result<()> {
        let source = Arc::clone(self.source);
        let (mut start, mut open): (usize, Option<Vec<Literal>>) = (0, None);
        for line in source.text.split_inclusive('\n') {
            let span = start..start + line.trim_end().len();
            start += line.len();
            let line = line.trim();
            if let Some(facts) = line.strip_prefix("If holds:") {
                open = Some(self.conditions(facts.trim().split('/'), &span)?);
            } else if let Some(action) = line.strip_prefix("Execute:") {
                let Some(conditions) = open.take() else {
                    return Err(self.wrong(span, "expected `If holds: …` before `Execute: …`").into());
                };
                // After the action stand the kind of the plan and the distance.
                self.add(conditions, action.split(" / ").next().unwrap_or_default().trim());
            } else if !line.is_empty() && line != "Policy:" {
                let wrong = self.wrong(span, "expected `If holds: fact/fact/…` or `Execute: action`");
                return Err(wrong.help("`meliora reach --policy FILE` writes such a file").into());
            }
        }
        match open {
            Some(_) => Err(self.wrong(start..start, "expected `Execute: action`").into()),
            None => Ok(()),
        }
    }

    fn json(&mut self) -> Result<()> {
        let entries: Vec<Entry> = serde_json::from_str(&self.source.text).map_err(|error| {
            let wrong = self.wrong(place(self.source, &error), error.to_string());
            wrong.help("expected a list of `{\"state\": [\"fact\", …], \"action\": \"name\"}`")
        })?;
        for Entry { state, action } in entries {
            let conditions = self.conditions(state.iter().map(String::as_str), &(0..0))?;
            self.add(conditions, &action);
        }
        Ok(())
    }

    fn wrong(&self, span: Range<usize>, message: impl Into<String>) -> Diagnostic {
        Diagnostic::new(self.source, span, message)
    }

    fn conditions<'t>(
        &self,
        facts: impl Iterator<Item = &'t str>,
        span: &Range<usize>,
    ) -> Result<Vec<Literal>> {
        let named = facts.map(str::trim).filter(|text| !text.is_empty());
        named.map(|text| self.literal(text, span)).collect()
    }

    /// Reads `at(robot,kitchen)`, `not(at(robot,kitchen))`, or `x=3` in a model of another language.
    fn literal(&self, text: &str, span: &Range<usize>) -> Result<Literal> {
        let negated = text.strip_prefix("not(").and_then(|rest| rest.strip_suffix(')'));
        let (name, holds) = (negated.unwrap_or(text), negated.is_none());
        let found = match &self.program.planning {
            Some(_) => self.facts.get(&plain(name)).copied(),
            None => self.value(name),
        };
        if let Some((variable, value)) = found {
            return Ok((variable, value, holds));
        }
        let known = self.program.planning.as_ref().and_then(|planning| planning.named(name));
        let help = match known {
            Some(Named::Atom(_)) => "it always holds, or rules define it: leave it out",
            Some(Named::Never) => {
                "it never holds, or the goal does not depend on it; with `--target '\"goal\"'`, all facts are kept"
            }
            None => "expected a fact such as `at(robot,kitchen)`, or `x=3` in a model of another language",
        };
        let message = format!("`{name}` is not a fact that changes");
        Err(self.wrong(span.clone(), message).help(help).into())
    }

    fn value(&self, text: &str) -> Option<(VarId, i64)> {
        let (name, value) = text.rsplit_once('=')?;
        let (id, variable) = (0..).map(VarId).zip(&self.program.variables).find(|(_, v)| v.name == name)?;
        let named = variable.values.iter().position(|known| known == value.trim_matches('"'));
        let value = match (named, variable.ty) {
            (Some(at), _) => variable.low + i64::try_from(at).ok()?,
            (None, Type::Bool) => i64::from(value.parse::<bool>().ok()?),
            (None, _) => value.parse().ok()?,
        };
        (variable.low..=variable.high).contains(&value).then_some((id, value))
    }

    fn add(&mut self, conditions: Vec<Literal>, action: &str) {
        if let Some(state) = self.state(&conditions) {
            self.rules.add_state(state, action);
        }
        self.rules.add_condition(conditions, action);
    }

    /// Returns the state in which no other facts hold; `None` if there is none.
    fn state(&self, conditions: &[Literal]) -> Option<State> {
        let mut state: Vec<Option<i64>> = vec![None; self.program.variables.len()];
        for &(variable, value, _) in conditions.iter().filter(|(_, _, holds)| *holds) {
            let known = state[variable.index()].get_or_insert(value);
            if *known != value {
                return None;
            }
        }
        if self.program.planning.is_none() {
            return state.into_iter().collect();
        }
        let mut facts: Vec<i64> = vec![0; state.len()];
        self.facts.values().for_each(|(variable, _)| facts[variable.index()] += 1);
        // A variable has one value more than facts if none of them may hold.
        let without = |(at, value): (usize, Option<i64>)| {
            let variable = &self.program.variables[at];
            let none = if variable.ty == Type::Bool { variable.low } else { variable.high };
            value.or((facts[at] <= variable.high - variable.low).then_some(none))
        };
        state.into_iter().enumerate().map(without).collect()
    }
}
