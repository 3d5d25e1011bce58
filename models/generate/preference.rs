//! The preference order over the items: parsed, drawn, checked and written.

use super::world::{Lock, World};
use meliora_base::random::Draw;
use meliora_model::preference::{Empty, Preorder, Relation, Statement};

/// Parses `D>A, E>=A, A~B, X>Y>Z`: chains of statements, separated by commas.
///
/// # Errors
/// A message with the byte offset in `text`.
pub(super) fn parse(text: &str, world: &World) -> Result<Vec<Statement>, (usize, String)> {
    let mut statements = Vec::new();
    let mut start = 0;
    for chain in text.split(',') {
        if !chain.trim().is_empty() {
            parse_chain(chain, world, &mut statements).map_err(|(at, message)| (start + at, message))?;
        }
        start += chain.len() + 1;
    }
    check(&statements, world).map_err(|message| (0, message))?;
    Ok(statements)
}

fn parse_chain(text: &str, world: &World, statements: &mut Vec<Statement>) -> Result<(), (usize, String)> {
    let mut left: Option<(usize, Option<Relation>)> = None;
    let mut chars = text.char_indices().filter(|(_, c)| !c.is_whitespace()).peekable();
    while let Some((at, c)) = chars.next() {
        left = match (left, c) {
            (Some((item, None)), '~') => Some((item, Some(Relation::Indifferent))),
            (Some((item, None)), '>') => match chars.next_if(|(_, next)| *next == '=') {
                Some(_) => Some((item, Some(Relation::Weak))),
                None => Some((item, Some(Relation::Strict))),
            },
            (None | Some((_, Some(_))), name) => {
                let known = world.items.iter().position(|item| item.name == name);
                let right =
                    known.ok_or_else(|| (at, format!("expected the name of an item, found `{name}`")))?;
                if let Some((item, Some(relation))) = left {
                    statements.push(Statement { left: item, relation, right });
                }
                Some((right, None))
            }
            (Some((_, None)), other) => {
                return Err((at, format!("expected `>`, `>=` or `~`, found `{other}`")));
            }
        };
    }
    match left {
        Some((_, None)) if text.trim().chars().count() > 1 => Ok(()),
        Some((_, None)) => {
            Err((0, format!("`{}` is not compared with anything; write, for example, `D>A`", text.trim())))
        }
        _ => Err((text.trim_end().len(), "expected the name of an item at the end".to_owned())),
    }
}

/// Checks that no strict statement is reversed by the others.
pub(super) fn check(statements: &[Statement], world: &World) -> Result<(), String> {
    let Err(found) = Preorder::new(world.items.len(), statements) else { return Ok(()) };
    let strict = found.statements.first().and_then(|&s| statements.get(s));
    let name = |i: usize| world.items[i].name;
    strict.map_or(Ok(()), |s| {
        Err(format!(
            "`{0}>{1}` contradicts the other statements, by which {1} is at least as good as {0}",
            name(s.left),
            name(s.right)
        ))
    })
}

/// Draws a random order. Every locked item is preferred to one or two others, and an item that is
/// always available sometimes to another one. So better items are harder to get, and many pairs
/// stay incomparable. The two items of a fork (the last ones, `forks` pairs) are preferred to all
/// items before it.
pub(super) fn random(world: &World, forks: usize, draw: &mut Draw) -> Vec<Statement> {
    let scattered = world.items.len() - 2 * forks;
    let (locked, mut order): (Vec<usize>, Vec<usize>) =
        (0..scattered).partition(|&i| world.is_locked(Lock::Item(i)));
    draw.shuffle(&mut order);
    let better = |left, right| Statement { left, relation: Relation::Strict, right };
    let mut statements = Vec::new();
    for at in 1..order.len() {
        if draw.below(3) == 0 {
            statements.push(better(order[at], order[draw.below(at)]));
        }
    }
    for item in locked {
        let mut worse = order.clone();
        draw.shuffle(&mut worse);
        worse.truncate(1 + draw.below(2));
        worse.sort_unstable();
        statements.extend(worse.into_iter().map(|w| better(item, w)));
        order.push(item);
    }
    statements.sort_by_key(|s| (s.left, s.right));
    for (level, first) in (scattered..world.items.len()).step_by(2).enumerate() {
        let worse = if level == 0 { 0..scattered } else { first - 2..first };
        let pairs = [first, first + 1].into_iter().flat_map(|b| worse.clone().map(move |w| better(b, w)));
        statements.extend(pairs);
    }
    statements
}

/// Returns the text of the preference file.
pub(super) fn write(world: &World, statements: &[Statement], empty: Empty, title: &str) -> String {
    let mut text = format!("// {title}\n");
    for item in &world.items {
        text += &format!("objective {0} = F \"at_{0}\";\n", item.name);
    }
    if !statements.is_empty() {
        text.push('\n');
    }
    let mut rest = statements.to_vec();
    while let Some(&Statement { left, relation, .. }) = rest.first() {
        let same = |s: &mut Statement| s.left == left && s.relation == relation;
        let names: Vec<String> =
            rest.extract_if(.., same).map(|s| world.items[s.right].name.to_string()).collect();
        text += &format!("prefer {} {relation} {};\n", world.items[left].name, names.join(", "));
    }
    text + &format!("\nempty = {};\n", empty.name())
}
