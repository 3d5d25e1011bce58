//! Derives the manifest of a dump from model, preferences and options, as JSON. The export describes a
//! model by code of its own, so a mistake there is found here.
//!
//! Taken from the engine are the scope, the order of the bits, which may be any, and the numbers of
//! the choices, which `transitions` confirms in some states.

use std::collections::BTreeMap;

use num_rational::BigRational;
use num_traits::{One, Pow, ToPrimitive, Zero};
use serde_json::{Map, Value as Json, json};

use super::Hashes;
use meliora_base::exact::{Exact, Real};
use meliora_base::value::Type;
use meliora_dump::Manifest;
use meliora_dump::manifest::{SCHEMA, SafetyMode, TOOL};
use meliora_engine::symbolic::{Numbered, SymbolicEngine};
use meliora_engine::{Engine, Scope};
use meliora_model::preference::{Empty, History, Preferences};
use meliora_model::{CommandId, Program, Variable};

/// Returns the manifest without its files. The version of the program and the paths of the inputs are
/// those of the dump: nothing proves them.
pub(super) fn expected(
    engine: &SymbolicEngine,
    preferences: &Preferences,
    hashes: Hashes<'_>,
    said: &Manifest,
) -> Json {
    let program = engine.program();
    let [players, coalition] = players(program);
    let exact =
        program.constants.iter().filter_map(|(name, value)| Some((name.clone(), json!(exactly(value)?))));
    let objectives = preferences.objectives.iter().map(|objective| objective.name.as_str());
    let requirements = preferences.requirements.iter().map(|requirement| requirement.text.as_str());
    let mut all = json!({
        "schema": SCHEMA,
        "tool": {"name": TOOL, "version": said.tool.version},
        "model": {"path": said.model.path, "sha256": hashes.model},
        "constants": Map::from_iter(program.constants.iter().map(|(name, value)| (name.clone(), constant(value)))),
        "given": program.given_constants,
        "preferences": {"path": said.preferences.path, "sha256": hashes.preferences},
        "objectives": Vec::from_iter(objectives),
        "empty": match preferences.empty {
            Empty::Bottom => "bottom",
            Empty::Gain => "gain",
            Empty::Incomparable => "incomparable",
        },
        "scope": match engine.settings().scope {
            Scope::Reachable => "reachable",
            Scope::All => "all",
        },
        "safety": match said.safety {
            SafetyMode::Action => "action",
            SafetyMode::Transition => "transition",
            SafetyMode::Prefix => "prefix",
        },
        "max_level": said.max_level,
        "encoding": {
            "variables": Vec::from_iter(program.variables.iter().map(|v| variable(program, v))),
            "order": engine.encoding().names(),
        },
        "choices": choices(program, &engine.numbered_choices()),
        "regions": null,
        "certificate": null,
    });
    let history = (preferences.history == History::Play).then(|| json!("play"));
    let optional = [
        ("exact", some(Map::from_iter(exact), Map::is_empty)),
        ("players", some(players, Vec::is_empty)),
        ("coalition", some(coalition, Vec::is_empty)),
        ("requirements", some(Vec::from_iter(requirements), Vec::is_empty)),
        ("history", history),
    ];
    let present = optional.into_iter().filter_map(|(name, value)| Some((name.to_owned(), value?)));
    all.as_object_mut().into_iter().for_each(|all| all.extend(present.clone()));
    all
}

/// Returns a field that is left out where it is empty.
fn some<T: Into<Json>>(value: T, is_empty: impl Fn(&T) -> bool) -> Option<Json> {
    (!is_empty(&value)).then(|| value.into())
}

/// Returns the names of all players of a game, and of those who we are; none for other models.
pub(super) fn players(program: &Program) -> [Vec<String>; 2] {
    let list = program.players.iter().flat_map(|players| &players.list);
    let ours = list.clone().filter(|player| player.ours);
    [list.map(|player| player.name.clone()).collect(), ours.map(|player| player.name.clone()).collect()]
}

fn variable(program: &Program, variable: &Variable) -> Json {
    let is_truth = variable.ty == Type::Bool;
    // The least number of bits whose patterns are as many as the values.
    let last = i128::from(variable.high) - i128::from(variable.low);
    let bits = (0..).find(|bits| last >> bits == 0).unwrap_or(0u32);
    let bit = |k: u32| if is_truth { variable.name.clone() } else { format!("{}.{k}", variable.name) };
    let mut all = json!({
        "name": variable.name,
        "type": if is_truth { "bool" } else { "int" },
        "low": variable.low,
        "high": variable.high,
        "bits": bits,
        "names": Vec::from_iter((0..bits).map(bit)),
        "initial": variable.initial,
    });
    if !variable.values.is_empty() {
        all["values"] = json!(variable.values);
    }
    let facts = program.facts_of(variable);
    if !facts.is_empty() {
        all["facts"] = json!(facts);
    }
    if program.monitors.as_ref().is_some_and(|monitors| variable.module == Some(monitors.module)) {
        all["observer"] = json!(true);
    }
    all
}

/// Returns the meaning of the numbers of choices. Two numbers never have the same name.
fn choices(program: &Program, numbered: &[Numbered]) -> Json {
    let bits = (0..usize::BITS).find(|bits| (numbered.len() - 1) >> bits == 0).unwrap_or(0);
    let described: Vec<_> = numbered.iter().map(|choice| described(program, choice)).collect();
    let mut uses: BTreeMap<&str, usize> = BTreeMap::new();
    for (label, _) in &described {
        label.iter().for_each(|label| *uses.entry(label).or_default() += 1);
    }
    let number = |(number, (label, commands)): (usize, &(Option<&str>, Vec<Vec<String>>))| {
        let factors: Vec<String> = commands.iter().map(|factor| factor.join("|")).collect();
        let name = match label {
            _ if matches!(numbered[number], Numbered::Uniform) => "uniform".to_owned(),
            _ if commands.is_empty() => "deadlock".to_owned(),
            Some(label) if uses[label] == 1 => (*label).to_owned(),
            Some(label) => format!("{label}({})", factors.join(",")),
            None => factors.join(","),
        };
        json!({"number": number, "name": name, "action": label, "commands": commands})
    };
    json!({
        "order": Vec::from_iter((0..bits).rev().map(|bit| format!("choice@{bit}"))),
        "numbers": Vec::from_iter(described.iter().enumerate().map(number)),
    })
}

/// Returns the label of a choice, and its commands by the modules that take part. Monitors take part
/// in all steps, and are left out; a choice of monitors only is that of a deadlock, without a label.
fn described<'p>(program: &'p Program, choice: &Numbered) -> (Option<&'p str>, Vec<Vec<String>>) {
    let Numbered::Combinations { synchronisation, commands } = choice else { return (None, Vec::new()) };
    let monitors = program.monitors.as_ref().map(|monitors| monitors.module);
    let module = |id: &CommandId| program.commands[id.index()].module;
    let named =
        |id: &CommandId| format!("{}#{}", program.modules[module(id)], program.commands[id.index()].number);
    let own = commands.iter().filter(|factor| factor.iter().all(|id| Some(module(id)) != monitors));
    let own: Vec<Vec<String>> = own.map(|factor| factor.iter().map(named).collect()).collect();
    let action = program.synchronisations[*synchronisation].action.filter(|_| !own.is_empty());
    (action.and_then(|action| program.actions.get(action)).map(String::as_str), own)
}

/// Returns the value of a constant; a real is the nearest double, or a word where JSON has no number.
fn constant(value: &Exact) -> Json {
    let real = match value {
        Exact::Bool(b) => return json!(b),
        Exact::Int(i) => return json!(i),
        Exact::Real(Real::Finite(x)) => nearest(x),
        Exact::Real(Real::Infinite(is_negative)) => {
            if *is_negative {
                f64::NEG_INFINITY
            } else {
                f64::INFINITY
            }
        }
        Exact::Real(Real::Undefined) => f64::NAN,
    };
    if real.is_finite() { json!(real) } else { json!(real.to_string()) }
}

/// Returns the double nearest to a fraction: none of its neighbours is nearer, and of two that are
/// as near, it is the even one.
fn nearest(x: &BigRational) -> f64 {
    let guess = x.to_f64().unwrap_or(f64::NAN);
    let distance =
        |double: &f64| BigRational::from_float(*double).map(|y| if y > *x { y - x } else { x - y });
    let around = [guess.next_down(), guess, guess.next_up()].into_iter().filter(|double| double.is_finite());
    let best = around
        .filter_map(|double| Some((distance(&double)?, double.to_bits() & 1, double)))
        .min_by(|(near, odd, _), (other, other_odd, _)| near.cmp(other).then_with(|| odd.cmp(other_odd)));
    match best {
        // The neighbours of an infinite guess do not say that the number is finite.
        Some((_, _, double)) if guess.is_finite() => double,
        _ => guess,
    }
}

/// Returns the text of a fraction that is not the shortest decimal of the nearest double: such as
/// `25e-2`, and `1/3` where no decimal number is equal.
fn exactly(value: &Exact) -> Option<String> {
    let Exact::Real(Real::Finite(x)) = value else { return None };
    let near = nearest(x);
    if near.is_finite() && shortest(near).as_ref() == Some(x) {
        return None;
    }
    let (mut rest, mut digits, mut scaled) = (x.denom().clone(), 0u32, x.clone());
    for prime in [2u8, 5] {
        while (&rest % prime).is_zero() {
            rest /= prime;
        }
    }
    if !rest.is_one() {
        return Some(format!("{}/{}", x.numer(), x.denom()));
    }
    while !scaled.is_integer() {
        (scaled, digits) = (scaled * BigRational::from_integer(10.into()), digits + 1);
    }
    let sign = if digits == 0 { "" } else { "-" };
    Some(format!("{}e{sign}{digits}", scaled.numer()))
}

/// Returns the shortest decimal number that is nearest to a double.
fn shortest(double: f64) -> Option<BigRational> {
    let text = format!("{double:e}");
    let (mantissa, exponent) = text.split_once('e')?;
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let digits = BigRational::from_integer(format!("{whole}{fraction}").parse().ok()?);
    let exponent = exponent.parse::<i32>().ok()? - i32::try_from(fraction.len()).ok()?;
    Some(digits * Pow::pow(BigRational::from_integer(10.into()), exponent))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ratio(numerator: i64, denominator: i64) -> BigRational {
        BigRational::new(numerator.into(), denominator.into())
    }

    fn exact(x: BigRational) -> Option<String> {
        exactly(&Exact::Real(Real::Finite(x)))
    }

    #[test]
    fn reals_are_nearest_doubles_and_texts_where_these_do_not_say_all() {
        assert_eq!(nearest(&ratio(1, 10)), 0.1);
        assert_eq!(nearest(&ratio(-1, 3)), -1.0 / 3.0);
        assert_eq!(nearest(&ratio((1 << 53) + 1, 1)), 9_007_199_254_740_992.0);
        assert_eq!(exact(ratio(1, 10)), None);
        assert_eq!(exact(ratio(1, 3)).as_deref(), Some("1/3"));
        assert_eq!(exact(ratio((1 << 53) + 1, 1)).as_deref(), Some("9007199254740993e0"));
        let long = ratio(1_000_000_000_000_000_001, 4_000_000_000_000_000_000);
        assert_eq!(exact(long).as_deref(), Some("25000000000000000025e-20"));
        let huge: BigRational = Pow::pow(ratio(10, 1), 400i32);
        assert_eq!(constant(&Exact::Real(Real::Finite(huge.clone()))), json!("inf"));
        assert!(exact(huge).is_some_and(|text| text.ends_with("e0")));
        assert_eq!(constant(&Exact::Real(Real::Undefined)), json!("NaN"));
    }
}
