//! Files of policies: the text of planners, `If holds: … Execute: …`, and a list in JSON.
//!
//! Both are lists of rules, of which the first one that holds counts. After the action, ` / position=1` tells apart
//! choices with one name; the kind of the plan and the distance, which planners add, do not count.

use std::ops::Range;
use std::sync::Arc;

use ahash::AHashMap;
use serde::Deserialize;

use meliora_base::error::{Diagnostic, Result, SourceFile};
use meliora_base::value::Type;
use meliora_certify::policy::rules::{Literal, Rules, Taken};
use meliora_model::planning::{Named, plain};
use meliora_model::{Program, VarId};

use super::policy_names::{Condition, Rest};

/// The kinds of plans that planners note after an action: strong cyclic, not strong cyclic, strong, weak.
const KINDS: [&str; 4] = ["SC", "NSC", "S", "W"];

/// An entry in JSON; further fields do not count.
#[derive(Deserialize)]
struct Entry {
    state: Vec<String>,
    action: String,
    position: Option<usize>,
}

/// Reads a policy. A rule holds wherever its conditions do, and the first one that holds counts.
///
/// # Errors
/// The text is wrong, or names another thing than facts, or a name that two facts have; with its place.
pub fn read(source: &Arc<SourceFile>, program: &Program) -> Result<Rules> {
    let mut reader = RuleReader { source, program, facts: facts(program), rules: Rules::new(program) };
    if source.text.trim_start().starts_with('[') {
        reader.json()?;
    } else {
        reader.text()?;
    }
    Ok(reader.rules)
}

/// The facts of a planning problem by their names in small letters; `None` for names that two facts have.
type Facts = AHashMap<String, Option<(VarId, i64)>>;

/// Returns the facts of a planning problem; none for other models.
fn facts(program: &Program) -> Facts {
    let mut facts = Facts::new();
    for fact in program.planning.iter().flat_map(|planning| &planning.facts) {
        let new = Some((fact.variable, fact.value));
        facts.entry(plain(&fact.name)).and_modify(|known| *known = None).or_insert(new);
    }
    facts
}

/// Returns the place of an error in a text.
pub(super) fn place(source: &SourceFile, error: &serde_json::Error) -> Range<usize> {
    let lines = source.text.split_inclusive('\n').take(error.line().saturating_sub(1));
    let at = lines.map(str::len).sum::<usize>() + error.column().saturating_sub(1);
    let at = at.min(source.text.len());
    at..at
}

struct RuleReader<'a> {
    source: &'a Arc<SourceFile>,
    program: &'a Program,
    facts: Facts,
    rules: Rules,
}

impl RuleReader<'_> {
    fn text(&mut self) -> Result<()> {
        let source = Arc::clone(self.source);
        let (mut start, mut open): (usize, Option<Vec<Literal>>) = (0, None);
        for line in source.text.split_inclusive('\n') {
            let span = start..start + line.trim_end().len();
            start += line.len();
            let line = line.trim();
            if let Some(facts) = line.strip_prefix("If holds:") {
                if open.is_some() {
                    return Err(self.wrong(span, "expected `Execute: …` after `If holds: …`").into());
                }
                open = Some(self.conditions(facts, &span)?);
            } else if let Some(action) = line.strip_prefix("Execute:") {
                let Some(conditions) = open.take() else {
                    return Err(self.wrong(span, "expected `If holds: …` before `Execute: …`").into());
                };
                self.rules.add(conditions, self.taken(action, &span)?);
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
        for Entry { state, action, position } in entries {
            let conditions = state.iter().map(|text| self.literal(&mut Rest(text), true, text, &(0..0)));
            let conditions = conditions.collect::<Result<_>>()?;
            self.rules.add(conditions, Taken { action, position });
        }
        Ok(())
    }

    fn wrong(&self, span: Range<usize>, message: impl Into<String>) -> Diagnostic {
        Diagnostic::new(self.source, span, message)
    }

    /// Reads conditions that are separated by slashes. An empty one, as planners write at the end, does not count.
    fn conditions(&self, text: &str, span: &Range<usize>) -> Result<Vec<Literal>> {
        let (mut rest, mut found) = (Rest(text.trim()), Vec::new());
        while !rest.0.trim_start().is_empty() {
            if !rest.skip("/") {
                let shown = rest.0;
                found.push(self.literal(&mut rest, false, shown, span)?);
            }
        }
        Ok(found)
    }

    /// Reads the action, its position, and what planners add: the kind of the plan and the distance.
    fn taken(&self, text: &str, span: &Range<usize>) -> Result<Taken> {
        let mut rest = Rest(text);
        let wrong = |message| self.wrong(span.clone(), message);
        let ends = |rest: &Rest<'_>| rest.0.trim().is_empty() || rest.0.trim_start().starts_with("/ ");
        let name = rest.name(&[" / "]).filter(|(name, in_quotes)| *in_quotes || !name.is_empty());
        let (action, _) = name.filter(|_| ends(&rest)).ok_or_else(|| {
            let help =
                "a name with `/`, `=`, `\"` or outer blanks stands in double quotes, and its own are doubled";
            wrong("expected the name of an action").help(help)
        })?;
        let mut position = None;
        for remark in rest.0.split(" / ").map(str::trim).filter(|remark| !remark.is_empty()) {
            match remark.split_once('=') {
                Some(("position", number)) => {
                    let number = number.parse().map_err(|_| wrong("expected a number after `position=`"))?;
                    position = Some(number);
                }
                Some(("d", _)) => {}
                None if KINDS.contains(&remark) => {}
                _ => {
                    let help = "a name with ` / ` stands in double quotes";
                    return Err(wrong("expected `SC`, `d=8` or `position=0` after the action")
                        .help(help)
                        .into());
                }
            }
        }
        Ok(Taken { action, position })
    }

    /// Reads `at(robot,kitchen)`, `not(at(robot,kitchen))`, or `x=3` in a model of another language.
    fn literal(&self, rest: &mut Rest<'_>, one: bool, text: &str, span: &Range<usize>) -> Result<Literal> {
        let has_values = self.program.planning.is_none();
        let Some(Condition { name, value, negated }) = rest.condition(has_values, one) else {
            let message = format!("`{}` is not a condition", text.trim());
            let help = "expected a fact such as `at(robot,kitchen)`, or `x=3` in a model of another language; a name with `/`, \
                        `=` or `\"` stands in double quotes, and its own are doubled";
            return Err(self.wrong(span.clone(), message).help(help).into());
        };
        let holds = !negated;
        let found = match &value {
            Some((value, in_quotes)) => self.value(&name, value, *in_quotes),
            None => match self.facts.get(&plain(&name)) {
                Some(None) => {
                    let wrong = self.wrong(span.clone(), format!("two facts are called `{name}`"));
                    return Err(wrong.help("rename an object of the problem").into());
                }
                found => found.copied().flatten(),
            },
        };
        if let Some((variable, value)) = found {
            return Ok((variable, value, holds));
        }
        let known = self.program.planning.as_ref().and_then(|planning| planning.named(&name));
        let help = match known {
            Some(Named::Atom(_)) => "it always holds, or rules define it: leave it out",
            Some(Named::Never) => {
                "it never holds, or the goal does not depend on it; with `--target '\"goal\"'`, all facts are kept"
            }
            None => "expected a fact such as `at(robot,kitchen)`, or `x=3` in a model of another language",
        };
        let shown = value.map_or_else(|| name.clone(), |(value, _)| format!("{name}={value}"));
        let message = format!("`{shown}` is not a fact that changes");
        Err(self.wrong(span.clone(), message).help(help).into())
    }

    /// Returns a variable with a value; a value in quotes is a name.
    fn value(&self, name: &str, value: &str, in_quotes: bool) -> Option<(VarId, i64)> {
        let (id, variable) = (0..).map(VarId).zip(&self.program.variables).find(|(_, v)| v.name == name)?;
        let value = match (variable.ty, variable.values.iter().position(|known| known == value)) {
            (_, Some(at)) => variable.low + i64::try_from(at).ok()?,
            _ if in_quotes => return None,
            (Type::Bool, None) => i64::from(value.parse::<bool>().ok()?),
            (_, None) => value.parse().ok()?,
        };
        (variable.low..=variable.high).contains(&value).then_some((id, value))
    }
}
