//! The preference order over the items: read, drawn, checked and written.

use super::world::{Lock, World};
use crate::random::Draw;

/// How two items compare.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Relation {
    /// `>`: strictly preferred.
    Strict,
    /// `>=`: at least as good.
    Weak,
    /// `~`: indifferent.
    Indifferent,
}

impl Relation {
    /// The sign for it in preference files.
    pub(super) fn symbol(self) -> &'static str {
        match self {
            Relation::Strict => ">",
            Relation::Weak => ">=",
            Relation::Indifferent => "~",
        }
    }
}

/// What it is worth to be able to achieve nothing: the statement `empty = …`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Empty {
    /// Below every objective.
    #[default]
    Bottom,
    /// To gain the first objective improves, to lose the last one does not weaken.
    Gain,
    /// Compares with nothing.
    Incomparable,
}

impl Empty {
    /// All values, the default first.
    pub const ALL: [Empty; 3] = [Empty::Bottom, Empty::Gain, Empty::Incomparable];

    /// The word for it.
    pub fn name(self) -> &'static str {
        match self {
            Empty::Bottom => "bottom",
            Empty::Gain => "gain",
            Empty::Incomparable => "incomparable",
        }
    }
}

/// One statement: an item, the relation, another item; by their numbers.
pub(super) type Statement = (usize, Relation, usize);

/// Reads `D>A, E>=A, A~B, X>Y>Z`: statements with commas between them, each a chain.
///
/// # Errors
/// What is wrong, in words, with the byte offset in `text`.
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
                    statements.push((item, relation, right));
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
            Err((0, format!("`{}` is compared with nothing: write such as `D>A`", text.trim())))
        }
        _ => Err((text.trim_end().len(), "expected the name of an item at the end".to_owned())),
    }
}

/// A strict statement must not be turned round by the others.
pub(super) fn check(statements: &[Statement], world: &World) -> Result<(), String> {
    let count = world.items.len();
    let mut better = vec![vec![false; count]; count];
    for &(a, relation, b) in statements {
        better[a][b] = true;
        better[b][a] |= relation == Relation::Indifferent;
    }
    for middle in 0..count {
        let row = better[middle].clone();
        for line in better.iter_mut().filter(|line| line[middle]) {
            line.iter_mut().zip(&row).for_each(|(to, &from)| *to |= from);
        }
    }
    let name = |i: usize| world.items[i].name;
    match statements
        .iter()
        .find(|&&(a, relation, b)| relation == Relation::Strict && (a == b || better[b][a]))
    {
        Some(&(a, _, b)) => Err(format!(
            "`{0}>{1}` contradicts the other statements, by which {1} is at least as good as {0}",
            name(a),
            name(b)
        )),
        None => Ok(()),
    }
}

/// A random order in which every locked item is preferred to one or two others, and an item that is
/// always there to another one now and then: so the better things are the harder ones, and much
/// stays incomparable. The two items of a fork (the last ones, `forks` pairs) are preferred to all that
/// is before it.
pub(super) fn random(world: &World, forks: usize, draw: &mut Draw) -> Vec<Statement> {
    let scattered = world.items.len() - 2 * forks;
    let (locked, mut order): (Vec<usize>, Vec<usize>) =
        (0..scattered).partition(|&i| world.is_locked(Lock::Item(i)));
    draw.shuffle(&mut order);
    let mut statements = Vec::new();
    for at in 1..order.len() {
        if draw.below(3) == 0 {
            statements.push((order[at], Relation::Strict, order[draw.below(at)]));
        }
    }
    for item in locked {
        let mut worse = order.clone();
        draw.shuffle(&mut worse);
        worse.truncate(1 + draw.below(2));
        worse.sort_unstable();
        statements.extend(worse.into_iter().map(|w| (item, Relation::Strict, w)));
        order.push(item);
    }
    statements.sort_by_key(|&(a, _, b)| (a, b));
    for (level, better) in (scattered..world.items.len()).step_by(2).enumerate() {
        let worse = if level == 0 { 0..scattered } else { better - 2..better };
        let pairs = [better, better + 1]
            .into_iter()
            .flat_map(|b| worse.clone().map(move |w| (b, Relation::Strict, w)));
        statements.extend(pairs);
    }
    statements
}

/// The preference file.
pub(super) fn write(world: &World, statements: &[Statement], empty: Empty, title: &str) -> String {
    let mut text = format!("// {title}\n");
    for item in &world.items {
        text += &format!("objective {0} = F \"at_{0}\";\n", item.name);
    }
    if !statements.is_empty() {
        text.push('\n');
    }
    let mut rest = statements.to_vec();
    while let Some(&(item, relation, _)) = rest.first() {
        let same = |s: &mut Statement| s.0 == item && s.1 == relation;
        let names: Vec<String> =
            rest.extract_if(.., same).map(|(.., worse)| world.items[worse].name.to_string()).collect();
        text += &format!("prefer {} {} {};\n", world.items[item].name, relation.symbol(), names.join(", "));
    }
    text + &format!("\nempty = {};\n", empty.name())
}
