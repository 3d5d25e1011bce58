//! The page as a whole.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::super::header::{Header, ModelSummary};
use super::super::simulate::TurnReport;
use super::super::simulate_text::{committed, weakened};
use super::super::{ranks, text};
use super::axes::Sizes;
use super::paint::Paint;
use super::sentence::sentence;
use super::{Content, Picture, ShownRun, bars, cycle, data, game, hasse, map, words};
use meliora_base::value::Type;
use meliora_model::Variable;
use meliora_model::preference::Empty;
use meliora_planning::result::{Plan, Prospects};
use meliora_planning::{Opponent, Rank, Scheduler, StrategyKind};
use meliora_quantities::Choose;
use meliora_quantities::all_states::MOST_STATES;
use meliora_quantities::outlook::{LISTED, Promise};

/// Controls of more variables than this are folded at first.
const FOLDED: usize = 6;

/// Runs of more steps than this are folded at first.
const LONG: usize = 60;

/// The page.
pub(super) fn page(content: &Content<'_>) -> String {
    let check = content.check;
    let paint = content.projections.map(|projections| Paint::new(content, projections));
    let title = format!("{} · Meliora", file_name(check.header.path()));
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (title) }
                style { (PreEscaped(include_str!("page.css"))) (PreEscaped(include_str!("picture.css"))) }
            }
            body {
                (header(content))
                main {
                    (verdict(content))
                    @if let Some(paint) = &paint { (maps(content, paint)) } @else { (no_maps()) }
                    (cycle::section(check))
                    div.halves {
                        @if let Some(run) = content.run { (shown_run(run)) }
                        div { (preferences(content)) @if content.run.is_some() { (levels(content)) } }
                        @if content.run.is_none() { div { (levels(content)) } }
                    }
                    (tables(content))
                }
                (footer(content))
                @if let Some(paint) = &paint {
                    script #data type="application/json" { (PreEscaped(data::script(content, paint))) }
                    script {
                        (PreEscaped(include_str!("diagram.js")))
                        (PreEscaped(include_str!("page.js")))
                    }
                }
            }
        }
    };
    page.into_string()
}

fn file_name(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or(path)
}

fn header(content: &Content<'_>) -> Markup {
    let check = content.check;
    let constants = check.header.model.as_ref().map(ModelSummary::constants).unwrap_or_default();
    let preferences = check.header.preferences.as_deref().unwrap_or_default();
    let own = Header { engine: None, history: None, ..check.header.clone() };
    let settings = own.settings().into_iter().map(|(name, value)| format!("{name} {value}"));
    html! {
        header {
            h1 { (file_name(check.header.path())) span { " with " (file_name(preferences)) } }
            p.hint {
                @if !constants.is_empty() { (constants) " · " }
                @if let Some(counts) = &check.result.counts { (text::grouped(&counts.states)) @if counts.states.to_string() == "1" { " state · " } @else { " states · " } }
                (settings.collect::<Vec<_>>().join(" · "))
                @if let Some(engine) = check.header.engine { " · engine " (engine) }
            }
        }
    }
}

/// Renders the verdict on the initial states.
fn verdict(content: &Content<'_>) -> Markup {
    let initial = &content.check.initial;
    let more = content.check.result.counts.as_ref().map(|c| text::grouped(&c.initial)).unwrap_or_default();
    html! {
        section.verdict #verdict {
            @for (index, state) in initial.iter().enumerate() {
                @if index < LISTED {
                    (card(content, state, content.outlook.and_then(|outlook| outlook.promises.get(index)?.as_ref())))
                    @if let Some(note) = ranks::differing(state, content.check.by_step.get(index)) { p.hint { (with_code(&note)) } }
                }
            }
            @if let Some(promise) = game::promise(&content.check.players) { p.hint { (promise) } }
            @if initial.len() > LISTED { p.hint { "… " (more) " initial states in total." } }
        }
    }
}

fn card(content: &Content<'_>, initial: &Prospects, promise: Option<&Promise>) -> Markup {
    let promise = promise.filter(|_| initial.escape.is_none());
    let headline = promise.map_or_else(|| words::verdict(initial), sentence);
    html! {
        div.card {
            p.headline { (headline) }
            div.figures {
                div.figure {
                    span.number.text {
                        @if initial.escape.is_some() { "unsafe" } @else { (text::either(&initial.most_preferred)) }
                    }
                    span.label { @if initial.escape.is_none() { "most preferred " } "in the initial state" span.begin { (state(content, initial)) } }
                }
                @if let Some(first) = promise.map(|promise| &promise.first[..]).filter(|first| !first.is_empty()) {
                    div.figure {
                        span.number.text { (text::either(first)) }
                        span.label { @if first.len() == 1 { "is the best first action" } @else { "are equally good first actions" } }
                    }
                }
                @if initial.escape.is_none() {
                    (figure("guaranteed", "sure", initial.sasi.as_ref()))
                    (figure("possible", "possible", initial.spi.as_ref()))
                }
            }
        }
    }
}

/// Renders an initial state: `x=1,y=2`, or the facts of a planning problem that hold.
fn state(content: &Content<'_>, initial: &Prospects) -> Markup {
    let Some(projections) = content.projections.filter(|p| p.facts.iter().any(|facts| !facts.is_empty()))
    else {
        return values(&initial.values.to_string());
    };
    let variables = projections.variables.iter().zip(&projections.facts);
    let reading = |((variable, facts), cell): ((&Variable, &Vec<String>), String)| {
        let value = match variable.values.iter().position(|name| *name == cell) {
            Some(at) => variable.low + at as i64,
            None => cell.parse().unwrap_or(i64::from(cell == "true")),
        };
        (facts.is_empty() || variable.ty != Type::Bool || value != 0).then(|| variable.reading(facts, value))
    };
    let holds = variables.zip(initial.values.cells()).filter_map(reading);
    values(&holds.collect::<Vec<_>>().join(", "))
}

/// Renders a text whose options stand in backticks.
fn with_code(text: &str) -> Markup {
    html! {
        @for (at, part) in text.split('`').enumerate() { @if at % 2 == 1 { code { (part) } } @else { (part) } }
    }
}

/// Renders values of variables; a narrow page may break them after commas.
fn values(text: &str) -> Markup {
    html! {
        code { @for value in text.split_inclusive(',') { (value) wbr; } }
    }
}

fn figure(label: &str, class: &str, plan: Option<&Plan>) -> Markup {
    let actions = plan.map(|plan| plan.actions.join(", ")).unwrap_or_default();
    let noun =
        if plan.is_some_and(|plan| plan.rank == Rank::Finite(1)) { "improvement" } else { "improvements" };
    html! {
        div.figure {
            span.number.(class) { (ranks::mark(plan.map(|plan| plan.rank))) }
            span.label {
                (noun) " " (label)
                @if !actions.is_empty() { span.begin { "permitted: " b { (actions) } } }
            }
        }
    }
}

fn maps(content: &Content<'_>, paint: &Paint<'_>) -> Markup {
    let (projections, opening) = (paint.projections, &paint.opening);
    let open = opening.iter().any(Option::is_none);
    let inside = |index: usize| {
        projections.plane.row.is_some_and(|v| v.index() == index) || projections.plane.column.index() == index
    };
    let others =
        projections.variables.iter().enumerate().filter(|(index, v)| !inside(*index) && v.low < v.high);
    let others: Vec<(usize, &Variable)> = others.collect();
    let controlled = !others.is_empty() && !projections.projected;
    let sentence = html! { span #view.hint aria-live="polite" data-open=(open) { (view_sentence(paint)) } };
    html! {
        section #maps {
            div.tools {
                h2 { "Maps" }
                @if content.run.is_some() { (stepper(!content.check.players.is_empty())) }
                @if controlled {
                    button #to-start type="button" { "start values" }
                    button #to-any type="button" { "any values" }
                }
            }
            @if controlled {
                details.others open[others.len() <= FOLDED] {
                    summary { b { "Sliders" } " " (sentence) }
                    form.controls autocomplete="off" {
                        @for (index, variable) in &others { (control(variable, opening[*index], projections.at[*index])) }
                    }
                }
            } @else { p.others { (sentence) } }
            div.maps style=(format!("--least:{:.0}px", Sizes::new(projections).least)) {
                @for picture in Picture::MAPS { (map::part(content, paint, picture)) }
                @if let Some(heat) = content.heat() { (map::values(content, paint, &heat)) }
            }
            @if !content.check.players.is_empty() { (game::key(&content.check.players, paint)) }
            @if content.heat().is_none() {
                p.hint { "Values are left out: the model has more than " (text::grouped(MOST_STATES)) " states. "
                    code { "meliora values" } " computes them." }
            }
            (map::key(paint))
            div #cell.card.detail aria-live="polite" { "Select a cell with the mouse or the arrow keys to see its results." }
        }
    }
}

fn view_sentence(paint: &Paint<'_>) -> String {
    let (projections, view) = (paint.projections, &paint.opening);
    let values = map::view_text(projections, view);
    let pale = match paint.cells.iter().flatten().any(|found| found.elsewhere) {
        true => " Faded cells are unreachable with these values; they show the best over all others.",
        false => "",
    };
    match (projections.projected, values.is_empty(), view.iter().any(Option::is_none)) {
        (_, true, _) => String::new(),
        (true, ..) => {
            format!("For {values}: each cell shows the best of these. The regions are too large for sliders.")
        }
        (_, _, true) => format!("For {values}: each cell shows the best of these.{pale}"),
        _ => format!("For {values}.{pale}"),
    }
}

/// Renders a slider or a choice between false and true, with a box for any value.
fn control(variable: &Variable, value: Option<i64>, at: i64) -> Markup {
    let id = format!("var-{}", variable.name);
    let shown = value.unwrap_or(at);
    let any = format!("any value of {}", variable.name);
    html! {
        div.control data-variable=(variable.name) {
            label for=(id) title=(variable.name) { (variable.name) }
            @if variable.ty == Type::Bool || !variable.values.is_empty() {
                select id=(id) {
                    @for option in variable.low..=variable.high {
                        option value=(option) selected[shown == option] { (variable.show(option)) }
                    }
                }
            } @else {
                input id=(id) type="range" min=(variable.low) max=(variable.high) value=(shown);
                output for=(id) { (shown) }
            }
            label.any { input type="checkbox" aria-label=(any) checked[value.is_none()]; "any" }
        }
    }
}

fn no_maps() -> Markup {
    html! {
        section #maps { h2 { "Maps" } p.hint {
            "No map can be drawn: the model needs one or two integer variables of suitable range. "
            "The option " code { "--grid ROW,COLUMN" } " selects them."
        } }
    }
}

/// Renders buttons to step through the run; the script shows them.
fn stepper(is_game: bool) -> Markup {
    html! {
        div.stepper hidden {
            b { "Run" }
            button type="button" data-step="first" title="to the start" aria-label="to the start of the run" { "start" }
            button type="button" data-step="back" title="one step back" aria-label="one step back" { "←" }
            output #step aria-live="polite" { "start" }
            @if is_game { span #turn {} }
            button type="button" data-step="on" title="one step forward" aria-label="one step forward" { "→" }
            button type="button" data-step="last" title="to the end" aria-label="to the end of the run" { "end" }
        }
    }
}

/// Renders a run, step by step.
fn shown_run(run: &ShownRun) -> Markup {
    let (turns, is_game) = (&run.trace.turns, run.opponent.is_some());
    html! {
        section #play {
            h2 { "A run" }
            p.hint {
                "Run " (run.trace.run) " with seed " (run.seed) " under the " (run.scheduler.name()) " "
                (strategy_name(run.kind)) ", which selects "
                @match (run.scheduler, run.choose) {
                    (Scheduler::Permissive, _) => "each permitted action with the same probability. ",
                    (_, Choose::First) => "the first permitted action that comes closer to its goal. ",
                    (_, Choose::Likely) => "the permitted action with the greatest probability of success. ",
                    (_, Choose::Cheap) => "the permitted action with the fewest expected steps. ",
                }
                @match run.opponent {
                    None => {}
                    Some(Opponent::Random) => "The opponent takes each of its actions with the same probability. ",
                    Some(Opponent::Worst) => "The opponent takes the action that keeps the goal away longest. ",
                }
                b { (words::outcome(run)) }
                " It was selected from at most " (run.tried) " runs: the first with all these improvements that weakens nothing, "
                "or else one with the most improvements."
            }
            details open[turns.len() <= LONG] { summary.hint { "All steps" } div.scroll { table.turns {
                thead { tr {
                    th.n { "step" } @if is_game { th { "who" } } th { "action" } th { "to" } th.n { "chance" } th { "most preferred" } th { "rank" } th {}
                } }
                tbody {
                    tr data-turn="0" { td.n { "0" } @if is_game { td {} } td { "start" } td {} td {} td {} td {} td {} }
                    @for (index, turn) in turns.iter().enumerate() { (turn_row(index + 1, turn, is_game)) }
                }
            } } }
        }
    }
}

/// Returns the name of a strategy in a sentence.
fn strategy_name(kind: StrategyKind) -> &'static str {
    match kind {
        StrategyKind::Sasi => "SASI strategy",
        StrategyKind::Spi => "SPI strategy",
        StrategyKind::Plan => "plan (first improve, then achieve a most preferred objective)",
        StrategyKind::Achieve => "strategy that achieves the named objectives",
    }
}

/// Renders a step; in a game, with the player that takes it.
fn turn_row(step: usize, turn: &TurnReport, is_game: bool) -> Markup {
    let ours = turn.owner.is_none();
    let side = turn.player.as_ref().map(|_| game::side(ours));
    let improves = turn.improves.then(|| format!("improves: {} gained", text::either(&turn.gained)));
    let notes = [("good", improves), ("bad", weakened(turn)), ("hint", committed(turn))];
    let notes: Vec<_> = notes.into_iter().filter_map(|(class, note)| Some((class, note?))).collect();
    html! {
        tr class=[side] data-turn=(step) {
            td.n { (step) }
            @if is_game { td { @if let Some(player) = &turn.player { (game::who(player, ours)) } } }
            td { b { (turn.action) } } td data-name="to" { (values(&turn.changed)) }
            td.n data-name="chance" {
                (format!("{:.3}", turn.probability).trim_end_matches('0').trim_end_matches('.'))
            }
            td data-name="most preferred" { (text::either(&turn.most_preferred)) }
            td data-name="rank" { (ranks::mark(Some(turn.rank))) }
            td { @for (class, note) in &notes { span class=(class) { (note) } " " } }
        }
    }
}

fn preferences(content: &Content<'_>) -> Markup {
    let empty = match content.preferences.empty {
        Empty::Bottom => {
            "Achieving nothing is worse than every objective: gaining a first objective improves, losing the last one weakens."
        }
        Empty::Gain => "Gaining a first objective improves; losing the last one does not weaken.",
        Empty::Incomparable => "Achieving nothing is incomparable to every objective.",
    };
    html! {
        section #preferences {
            h2 { "Preference order" }
            div.scroll { (hasse::svg(&content.order(), false)) }
            p.hint {
                "The most preferred objectives are on top. Objectives in one box are equally good; objectives "
                "without a path up or down between them are incomparable. " (empty)
            }
        }
    }
}

fn levels(content: &Content<'_>) -> Markup {
    let result = &content.check.result;
    html! {
        section #levels { h2 { "States by number of improvements" } div.scroll { (bars::levels(result)) } }
        section #objectives { h2 { "Objectives" } div.scroll { (bars::objectives(result)) } }
    }
}

fn tables(content: &Content<'_>) -> Markup {
    let (check, result) = (content.check, &content.check.result);
    html! {
        div.columns {
            section #classes {
                h2 { "Classes" }
                p.hint { "States by their most preferred almost-sure objectives." }
                div.scroll { (bars::classes(result)) }
            }
            div {
                section #sizes { h2 { "Sizes" } (bars::sizes(check)) }
                section #times { h2 { "Time" } (bars::times(check)) }
            }
        }
    }
}

fn footer(content: &Content<'_>) -> Markup {
    html! {
        footer { p.hint {
            "Meliora " (env!("CARGO_PKG_VERSION")) " · " code { (content.check.header.path()) } " · "
            code { (content.check.header.preferences.as_deref().unwrap_or_default()) }
            " · Shares and bars refer to all states of the scope."
        } }
    }
}
