//! The text of a state under a strategy.

use std::fmt::Write;

use super::reason::Words;
use super::simulate_text::commitment;
use super::state::{Place, StateReport};
use super::text::{self, Probability, columns};
use super::{Style, ranks};
use meliora_model::preference::Change;
use meliora_model::valuation::Valuation;
use meliora_planning::explain::{Action, Successor, Verdict};
use meliora_planning::induced_model::Node;
use meliora_planning::{InducedModel, Kind, Rank, StrategyKind};
use meliora_quantities::Choose;

/// Renders a state.
pub(super) fn render(state: &StateReport<'_>, style: Style) -> String {
    let (words, at, [sasi, spi]) = (state.words, &state.at, state.ranks);
    let valuation = Valuation::new(words.program, &at.state);
    let mut out = format!("\n{}", text::state_heading("State", &valuation, style));
    if let Some(Place { node, is_start, .. }) = &state.place {
        let (level, reference) = (ranks::cell(at.memory.level), words.either(&at.reference));
        let start = if *is_start { "; paths start here" } else { "" };
        let _ = writeln!(out, "  Node {node}: level {level}, compared with {reference}{start}");
    }
    if let Some(player) = words.player(at) {
        let side = if at.is_theirs() { "opponent" } else { "ours" };
        let _ = writeln!(out, "  To move: {player} ({side})");
    }
    if at.is_unsafe {
        let _ = writeln!(out, "  {}", style.bad("Unsafe: no strategy keeps the requirements"));
    } else {
        let _ = writeln!(out, "  Most preferred: {}", words.either(&at.most_preferred));
        let _ = writeln!(out, "  {}", ranks::both(sasi, spi));
        if let Some(advice) = advice(state) {
            let _ = writeln!(out, "  {advice}");
        }
        if let Some(name) = words.pursued(at) {
            let text = match at.memory.pursuit {
                _ if at.is_achieved() => "Achieved",
                Some(_) => "Achieves almost surely",
                None => "Makes as likely as possible",
            };
            let _ = writeln!(out, "  {text}: {name}");
            if state.commits() {
                let commitment = commitment(&name, &words.names(&state.gives_up()));
                let _ = writeln!(out, "  The plan {commitment}: kept actions do not achieve {name}");
            }
        }
        if let Some(attains) = &state.attains {
            let _ = writeln!(out, "  Attains: {}", attains.line(state.choosing.cost()));
        }
    }
    for action in &at.actions {
        out += &action_text(state, action, style);
    }
    if let Some(cycle) = &state.cycle {
        out += &cycle.text(style);
    }
    if let Some(unfolded) = &state.unfolded {
        out += &paths_text(words, state.choosing.choose, unfolded, style);
    }
    out
}

/// Advises on a state where a strategy does nothing.
fn advice(state: &StateReport<'_>) -> Option<String> {
    let (words, at, [sasi, spi]) = (state.words, &state.at, state.ranks);
    let only_possible = sasi == Rank::Finite(0) && spi != Rank::Finite(0);
    match words.kind {
        StrategyKind::Achieve if at.memory.pursuit.is_none() => {
            let fact = "No strategy achieves this almost surely from here";
            Some(match state.choosing.choose {
                Choose::First => format!("{fact}.\n  `--choose likely` makes it as likely as possible."),
                _ => format!("{fact}."),
            })
        }
        StrategyKind::Sasi | StrategyKind::Spi if spi == Rank::Finite(0) && !at.most_preferred.is_empty() => {
            Some(format!("`--kind plan` shows how to achieve {}.", words.either(&at.most_preferred)))
        }
        StrategyKind::Sasi if state.is_only_kept() => Some(
            "Guaranteed only if no dropped branch happens; `--choose likely` has a value here, and `first` follows \
             the levels."
                .to_owned(),
        ),
        StrategyKind::Sasi if only_possible => Some(
            "No improvement is guaranteed here; `--kind spi` shows how to try the possible ones.".to_owned(),
        ),
        StrategyKind::Plan if only_possible && words.levels == Kind::Sasi => {
            Some("No improvement is guaranteed here; `--choose likely` tries the possible ones.".to_owned())
        }
        _ => None,
    }
}

fn action_text(state: &StateReport<'_>, action: &Action, style: Style) -> String {
    let words = state.words;
    let picked = state.picked_action().is_some_and(|picked| picked.name == action.name);
    let verdict = match (action.permitted, picked) {
        (true, true) => style.good(&format!("permitted, {}", picked_name(state))),
        (true, false) => style.good("permitted"),
        (false, _) => style.dim("not permitted"),
    };
    let reason = match picked && action.verdict == Verdict::Stays {
        true => "stays in the level, and has the best value".to_owned(),
        false => state.reason(action),
    };
    let name = style.bold(&action.name);
    let mut out = match state.at.is_theirs() {
        true => format!("\n  {name}: {reason}\n"),
        false => format!("\n  {name}  {verdict}: {reason}\n"),
    };
    let row = |s: &Successor| {
        vec![
            Probability(s.probability).to_string(),
            words.changed(&state.at.state, &s.state),
            words.preferred(s.is_unsafe, &s.most_preferred),
            change(words, s),
            format!("{} rank {}", words.levels, ranks::cell(s.rank)),
        ]
    };
    let rows: Vec<Vec<String>> = action.successors.iter().map(row).collect();
    for line in columns(&rows) {
        let _ = writeln!(out, "       {line}");
    }
    out
}

/// Returns the name of the action that the strategy takes.
fn picked_name(state: &StateReport<'_>) -> &'static str {
    match state.choosing.choose {
        _ if state.at.memory.pursuit.is_some() => "progress action",
        Choose::Likely if state.words.kind == StrategyKind::Achieve => "most likely",
        Choose::First => "progress action",
        Choose::Likely => "most likely to improve",
        Choose::Cheap => "cheapest",
    }
}

/// Describes a step, with its gains and losses.
fn change(words: Words<'_>, s: &Successor) -> String {
    let mut text = s.change.name().to_owned();
    if s.change != Change::Lateral {
        for (set, what) in [(&s.gained, "gained"), (&s.lost, "lost")] {
            if !set.is_empty() {
                let _ = write!(text, ", {} {what}", words.list(set));
            }
        }
    }
    if s.dropped {
        text.push_str(" (dropped)");
    }
    text
}

/// Formats the actions and successors as `W to 3, 4 (B gained) or 5 (C gained)`.
fn then(words: Words<'_>, node: &Node) -> String {
    let mut played = Vec::new();
    for (action, next) in node.at.actions.iter().zip(&node.next) {
        let mut goes = Vec::new();
        for (successor, to) in action.successors.iter().zip(next) {
            let Some(to) = to else { continue };
            let gives_up = node.at.gives_up(successor);
            let note = match (successor.improves, successor.dropped) {
                (true, _) => format!(" ({} gained)", words.either(&successor.gained)),
                _ if !gives_up.is_empty() => format!(" (gives up {})", words.list(&gives_up)),
                (_, true) => format!(" ({} lost)", words.list(&successor.lost)),
                _ => String::new(),
            };
            goes.push(format!("{}{note}", to + 1));
        }
        if let Some(last) = goes.pop() {
            let to = if goes.is_empty() { last } else { format!("{} or {last}", goes.join(", ")) };
            played.push(format!("{} to {to}", action.name));
        }
    }
    match (played.is_empty(), node.at.pick) {
        (false, _) => played.join("; "),
        (true, None) if node.at.is_achieved() => "achieved".to_owned(),
        (true, None) if !node.at.is_theirs() || node.at.is_over() => "end".to_owned(),
        (true, _) => "…".to_owned(),
    }
}

/// Formats the level, or the pursued objective as `to A`.
fn level(words: Words<'_>, node: &Node) -> String {
    match words.pursued(&node.at) {
        Some(_) => format!("to {}", words.left(&node.at)),
        None => ranks::cell(node.at.memory.level),
    }
}

/// Renders the paths under the progress strategy, one line per node.
fn paths_text(words: Words<'_>, choose: Choose, unfolded: &InducedModel, style: Style) -> String {
    let is_game = words.program.players.is_some();
    let by: &[&str] = if is_game { &["to move"] } else { &[] };
    let heading = [&["", "state", "most preferred", "level"], by, &["next"]].concat();
    let mut rows = vec![heading.into_iter().map(str::to_owned).collect::<Vec<_>>()];
    for (index, node) in unfolded.nodes.iter().enumerate() {
        let mut row = vec![
            (index + 1).to_string(),
            match index {
                0 => "start".to_owned(),
                _ => words.changed(&unfolded.nodes[0].at.state, &node.at.state),
            },
            words.either(&node.at.most_preferred),
            level(words, node),
        ];
        row.extend(is_game.then(|| words.player(&node.at).unwrap_or("nobody").to_owned()));
        row.push(then(words, node));
        rows.push(row);
    }
    let name = match choose {
        Choose::First if words.kind == StrategyKind::Plan => "plan",
        Choose::First if words.kind == StrategyKind::Achieve => "strategy",
        Choose::First => "progress strategy",
        Choose::Likely if words.kind == StrategyKind::Achieve => "most likely strategy",
        Choose::Likely => "strategy that is most likely to improve",
        Choose::Cheap => "cheapest strategy",
    };
    let mut out = format!("\n  {}\n", style.bold(&format!("Paths under the {name}")));
    out += &text::listed(&rows, style);
    if let Some(steps) = unfolded.longest_path() {
        let _ = writeln!(out, "    Every such path ends after at most {}.", text::plural(steps, "step"));
    }
    out
}
