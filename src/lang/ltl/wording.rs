//! Readable names for the states of a monitor, such as "waiting for b".

use ahash::AHashMap;

use meliora_ltl::{Decision, DecisionId, Monitor, Settled};
use meliora_model::expr::ExprId;
use meliora_model::temporal::Asks;

/// Conditions with more cases, or with more parts in one case, are not written out.
const MOST_CASES: usize = 3;
const MOST_PARTS: usize = 4;

/// A partial assignment of atoms.
type Cube = Vec<(u32, bool)>;

/// The purpose of a monitor: its acceptance, and whether something is owed at the start.
#[derive(Clone, Copy)]
pub(super) struct Purpose {
    pub(super) asks: Asks,
    pub(super) owes: bool,
}

/// Returns a distinct name for each state.
pub(super) fn wording(
    monitor: &Monitor,
    purpose: Purpose,
    texts: &AHashMap<(ExprId, bool), String>,
) -> Vec<String> {
    let settled = Settled::new(monitor);
    let mut names: Vec<String> = Vec::with_capacity(monitor.states.len());
    for (state, &decision) in monitor.states.iter().enumerate() {
        let wanted = match purpose.asks {
            Asks::Accept if settled.surely[state] => "done".to_owned(),
            Asks::Accept if settled.never[state] => "lost".to_owned(),
            Asks::Avoid if settled.surely[state] => "violated".to_owned(),
            Asks::Avoid if settled.never[state] => "kept for good".to_owned(),
            Asks::Avoid => "kept so far".to_owned(),
            Asks::Again | Asks::Settle if settled.never[state] => "stuck".to_owned(),
            Asks::Again | Asks::Settle if state == 0 && !purpose.owes => "nothing owed".to_owned(),
            Asks::Accept => {
                let good = |next: usize, mark: bool| mark || (next != state && !settled.never[next]);
                waiting(monitor, decision, texts, &good)
            }
            Asks::Again | Asks::Settle => waiting(monitor, decision, texts, &|_, mark| mark),
        };
        names.push(wanted);
    }
    distinct(names)
}

fn distinct(names: Vec<String>) -> Vec<String> {
    let mut seen: AHashMap<String, usize> = AHashMap::new();
    let number = |name: String| {
        let count = seen.entry(name.clone()).or_default();
        *count += 1;
        if *count == 1 { name } else { format!("{name} ({count})") }
    };
    names.into_iter().map(number).collect()
}

/// Returns "waiting for" with the conditions on the next state that lead to a good end.
fn waiting(
    monitor: &Monitor,
    decision: DecisionId,
    texts: &AHashMap<(ExprId, bool), String>,
    good: &dyn Fn(usize, bool) -> bool,
) -> String {
    let mut cases: Vec<Cube> = Vec::new();
    collect(monitor, decision, &mut Vec::new(), good, &mut cases);
    for case in &mut cases {
        // Removes literals that do not matter, negative ones first.
        for sign in [false, true] {
            for literal in case.clone().into_iter().filter(|l| l.1 == sign) {
                let without: Cube = case.iter().copied().filter(|l| *l != literal).collect();
                if surely(monitor, decision, &without, good) {
                    *case = without;
                }
            }
        }
    }
    cases.sort();
    cases.dedup();
    if cases.is_empty()
        || cases.len() > MOST_CASES
        || cases.iter().any(|c| c.len() > MOST_PARTS || c.is_empty())
    {
        return "under way".to_owned();
    }
    let part = |&(atom, positive): &(u32, bool)| text_of(texts, monitor.atoms[atom as usize], positive);
    let case = |c: &Cube| c.iter().map(part).collect::<Vec<_>>().join(" & ");
    format!("waiting for {}", cases.iter().map(case).collect::<Vec<_>>().join(" or "))
}

/// Collects the paths to good ends, until there are too many.
fn collect(
    monitor: &Monitor,
    decision: DecisionId,
    path: &mut Cube,
    good: &dyn Fn(usize, bool) -> bool,
    cases: &mut Vec<Cube>,
) {
    if cases.len() > 4 * MOST_CASES {
        return;
    }
    match monitor.decisions.all[decision] {
        Decision::Go { next, mark } if good(next, mark) => cases.push(path.clone()),
        Decision::Go { .. } => {}
        Decision::Test { atom, no, yes } => {
            for (value, then) in [(true, yes), (false, no)] {
                path.push((atom, value));
                collect(monitor, then, path, good, cases);
                path.pop();
            }
        }
    }
}

/// Returns true if all ends consistent with an assignment are good.
fn surely(monitor: &Monitor, decision: DecisionId, case: &Cube, good: &dyn Fn(usize, bool) -> bool) -> bool {
    let (mut open, mut seen) = (vec![decision], ahash::AHashSet::new());
    while let Some(at) = open.pop() {
        if !seen.insert(at) {
            continue;
        }
        match monitor.decisions.all[at] {
            Decision::Go { next, mark } if good(next, mark) => {}
            Decision::Go { .. } => return false,
            Decision::Test { atom, no, yes } => match case.iter().find(|(a, _)| *a == atom) {
                Some((_, true)) => open.push(yes),
                Some((_, false)) => open.push(no),
                None => open.extend([no, yes]),
            },
        }
    }
    true
}

/// Returns the text of a literal.
pub(super) fn text_of(texts: &AHashMap<(ExprId, bool), String>, e: ExprId, positive: bool) -> String {
    if let Some(text) = texts.get(&(e, positive)) {
        return text.clone();
    }
    let text = texts.get(&(e, !positive)).map_or("?", String::as_str);
    let is_name = text.chars().all(|c| c.is_alphanumeric() || c == '_');
    if is_name { format!("!{text}") } else { format!("!({text})") }
}
