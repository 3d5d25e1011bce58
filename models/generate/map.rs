//! Grid worlds drawn as text; [`super`] describes the format.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use super::preference;
use super::world::{Cell, Direction, Directions, Lock, Patrol, Place, World};
use meliora_base::error::{Diagnostic, Error, Result, SourceFile};
use meliora_model::preference::{Empty, Statement};

/// The content of a map file.
pub(super) struct Map {
    /// The grid with its contents.
    pub(super) world: World,
    /// The preference statements of the file, if any.
    pub(super) prefer: Option<Vec<Statement>>,
    /// The value of nothing, if the file states it.
    pub(super) empty: Option<Empty>,
}

/// Reads a map file.
///
/// # Errors
/// The first mistake, with its place.
pub(super) fn read(source: &Arc<SourceFile>) -> Result<Map> {
    Reader { source }.map().map_err(|Wrong { span, message, help }| {
        let diagnostic = Diagnostic::new(source, span, message);
        Error::from(help.into_iter().fold(diagnostic, Diagnostic::help))
    })
}

/// A mistake and its place.
struct Wrong {
    span: Range<usize>,
    message: String,
    help: Option<String>,
}

fn wrong<T>(span: Range<usize>, message: impl Into<String>, help: &str) -> Result<T, Wrong> {
    let help = (!help.is_empty()).then(|| help.to_owned());
    Err(Wrong { span, message: message.into(), help })
}

/// A part of the text and its place.
#[derive(Clone)]
struct Word<'a> {
    text: &'a str,
    span: Range<usize>,
}

/// The meaning of a character of the map.
#[derive(Clone, Default)]
struct Legend {
    cell: Cell,
    item: Option<char>,
    start: bool,
}

const EMPTY: &str = "expected one of bottom, gain, incomparable";

struct Reader<'a> {
    source: &'a SourceFile,
}

/// The words of a statement.
type Line<'a> = Vec<Word<'a>>;

impl<'a> Reader<'a> {
    fn map(&self) -> Result<Map, Wrong> {
        let (drawing, statements) = self.split()?;
        let mut legend: BTreeMap<char, Legend> = BTreeMap::new();
        for line in statements.iter().filter(|line| line[0].text == "cell") {
            let (sign, meaning) = cell(line)?;
            legend.insert(sign, meaning);
        }
        let mut map = Map { world: draw(&drawing, &legend)?, prefer: None, empty: None };
        for line in &statements {
            self.statement(line, &mut map)?;
        }
        // All locks are known only after the last statement.
        if let Some(&item) = map.world.unavailable().first() {
            let name = map.world.items[item].name;
            let names =
                |line: &&Line| line[0].text == "open" && line.iter().any(|w| w.text == name.to_string());
            let span = statements.iter().find(names).map_or(0..0, whole);
            return wrong(
                span,
                format!(
                    "item {name} can never be picked up: all items that make it available are unavailable"
                ),
                "",
            );
        }
        if let Some(place) = stuck(&map.world) {
            let row = &drawing[map.world.rows - 1 - place.row];
            let (at, sign) = row.text.char_indices().nth(place.col).unwrap_or_default();
            let span = row.span.start + at;
            return wrong(
                span..span + sign.len_utf8(),
                "no action is enabled in this cell",
                "leave one direction",
            );
        }
        Ok(map)
    }

    /// Splits the text into the rows of the drawing, from the top, and the statements around it.
    fn split(&self) -> Result<(Vec<Word<'a>>, Vec<Line<'a>>), Wrong> {
        let mut drawing: Option<(Range<usize>, Vec<Word>)> = None;
        let mut statements = Vec::new();
        let mut inside = false;
        for line in lines(&self.source.text) {
            let words = words(&line);
            match words.first().map(|word| word.text) {
                Some("end") if inside && words.len() == 1 => inside = false,
                _ if inside => drawing.iter_mut().for_each(|(_, rows)| rows.push(line.clone())),
                None => {}
                Some("map") if drawing.is_some() => {
                    return wrong(words[0].span.clone(), "the file has a second map", "");
                }
                Some("map") if words.len() > 1 => {
                    return wrong(
                        words[1].span.clone(),
                        "the map starts in the next line",
                        "write `map` alone",
                    );
                }
                Some("map") => {
                    inside = true;
                    drawing = Some((words[0].span.clone(), Vec::new()));
                }
                Some(_) => statements.push(words),
            }
        }
        let end = self.source.text.len();
        match drawing {
            None => {
                wrong(end..end, "the file has no map", "write `map`, the rows from north to south, and `end`")
            }
            Some((at, _)) if inside => wrong(at, "this map has no end", "write `end` in a line of its own"),
            Some((at, rows)) if rows.is_empty() || rows[0].text.is_empty() => {
                wrong(at, "this map is empty", "")
            }
            Some((_, rows)) => Ok((rows, statements)),
        }
    }

    fn statement(&self, line: &Line, map: &mut Map) -> Result<(), Wrong> {
        let arguments = &line[1..];
        match line[0].text {
            "cell" => Ok(()),
            "battery" => {
                map.world.battery = battery(line)?;
                Ok(())
            }
            "open" => open(line, &mut map.world),
            "patrol" => {
                let patrol = patrol(line, &map.world)?;
                map.world.patrols.push(patrol);
                Ok(())
            }
            "prefer" => {
                let from = arguments.first().map_or(whole(line).end, |word| word.span.start);
                let text = &self.source.text[from..whole(line).end];
                let statements = preference::parse(text, &map.world);
                let more =
                    statements.or_else(|(at, message)| wrong(from + at..whole(line).end, message, ""))?;
                map.prefer.get_or_insert_default().extend(more);
                preference::check(map.prefer.as_deref().unwrap_or_default(), &map.world)
                    .or_else(|message| wrong(whole(line), message, ""))
            }
            "empty" => {
                let [word] = arguments else { return wrong(whole(line), EMPTY, "") };
                map.empty = Some(word.text.parse().or_else(|_| wrong(whole(line), EMPTY, ""))?);
                Ok(())
            }
            other => wrong(
                line[0].span.clone(),
                format!("`{other}` is not a statement"),
                "the statements are map, cell, battery, open, patrol, prefer, empty",
            ),
        }
    }
}

/// Returns the lines without comments and trailing blanks, each with its place.
fn lines(text: &str) -> impl Iterator<Item = Word<'_>> {
    text.split_inclusive('\n').scan(0, |start, line| {
        let at = *start;
        *start += line.len();
        let line = line.split("//").next().unwrap_or_default().trim_end();
        Some(Word { text: line, span: at..at + line.len() })
    })
}

/// Returns the words of a line, separated by blanks or commas.
fn words<'a>(line: &Word<'a>) -> Vec<Word<'a>> {
    let mut words = Vec::new();
    let mut at = line.span.start;
    for piece in line.text.split_inclusive(|c: char| c.is_whitespace() || c == ',') {
        let text = piece.trim_end_matches(|c: char| c.is_whitespace() || c == ',');
        if !text.is_empty() {
            words.push(Word { text, span: at..at + text.len() });
        }
        at += piece.len();
    }
    words
}

fn whole(line: &Line) -> Range<usize> {
    let end = line.last().map_or(0, |word| word.span.end);
    line.first().map_or(0, |word| word.span.start)..end
}

/// Parses `cell + start no east west`: the character and its meaning.
fn cell(line: &Line) -> Result<(char, Legend), Wrong> {
    let [_, word, kinds @ ..] = &line[..] else {
        return wrong(whole(line), "expected a sign", "write, for example, `cell ~ slip north south`");
    };
    let mut chars = word.text.chars();
    let (Some(sign), None) = (chars.next(), chars.next()) else {
        return wrong(word.span.clone(), "a sign is one character", "");
    };
    Ok((sign, meaning(kinds)?))
}

/// Parses `start no east west`.
fn meaning(kinds: &[Word]) -> Result<Legend, Wrong> {
    let mut rest = kinds.iter().peekable();
    let mut legend = Legend::default();
    while let Some(feature) = rest.next() {
        let mut directions = || {
            let direction = |word: &&Word| word.text.parse::<Direction>().ok();
            let next = std::iter::from_fn(|| rest.next_if(|word| direction(word).is_some()));
            let directions: Directions = next.filter_map(|word| direction(&word)).collect();
            match directions.is_empty() {
                true => {
                    wrong(feature.span.clone(), format!("expected directions after `{}`", feature.text), "")
                }
                false => Ok(directions),
            }
        };
        match feature.text {
            "free" => {}
            "wall" => legend.cell.wall = true,
            "charger" => legend.cell.charger = true,
            "start" => legend.start = true,
            "slip" => legend.cell.slip = directions()?,
            "no" => legend.cell.disabled = directions()?,
            "oneway" => legend.cell.one_way = directions()?.iter().next(),
            "item" => match rest.next().map(|word| (word, word.text.chars().collect::<Vec<_>>())) {
                Some((_, name)) if matches!(name[..], ['A'..='Z']) => legend.item = name.first().copied(),
                _ => return wrong(feature.span.clone(), "the name of an item is a capital letter", ""),
            },
            other => {
                let help = "a cell is free, wall, charger, start, item X, slip/no/oneway with directions";
                return wrong(feature.span.clone(), format!("`{other}` is not a kind of cell"), help);
            }
        }
    }
    Ok(legend)
}

/// Returns the default meaning of a character.
fn built_in(sign: char) -> Option<Legend> {
    let text = match sign {
        '.' | ' ' => "free",
        '#' => "wall",
        '*' => "charger",
        '@' => "start",
        '~' => "slip north south",
        '^' => "oneway north",
        'v' => "oneway south",
        '>' => "oneway east",
        '<' => "oneway west",
        'A'..='Z' => return Some(Legend { item: Some(sign), ..Legend::default() }),
        _ => return None,
    };
    meaning(&words(&Word { text, span: 0..text.len() })).ok()
}

/// Builds the world of the rows, which are listed from north to south.
fn draw(drawing: &[Word], legend: &BTreeMap<char, Legend>) -> Result<World, Wrong> {
    let cols = drawing.iter().map(|row| row.text.chars().count()).max().unwrap_or(0);
    super::check_size(drawing.len(), cols).or_else(|m| wrong(drawing[0].span.clone(), m, ""))?;
    let mut rows: Vec<Vec<Legend>> = Vec::new();
    for row in drawing.iter().rev() {
        let mut line = Vec::new();
        for (at, sign) in row.text.char_indices() {
            let meaning = legend.get(&sign).cloned().or_else(|| built_in(sign));
            let at = row.span.start + at;
            let Some(meaning) = meaning else {
                let help = format!("define it, for example with `cell {sign} slip north`");
                return wrong(at..at + sign.len_utf8(), format!("`{sign}` is not defined"), &help);
            };
            line.push(meaning);
        }
        if line.len() != cols {
            let message = format!("this row has {} cells, the longest has {cols}", line.len());
            return wrong(row.span.clone(), message, "write `.` for free cells at the end of a row");
        }
        rows.push(line);
    }
    assemble(rows, cols, drawing)
}

fn assemble(rows: Vec<Vec<Legend>>, cols: usize, drawing: &[Word]) -> Result<World, Wrong> {
    let mut names: Vec<char> = rows.iter().flatten().filter_map(|meaning| meaning.item).collect();
    names.sort_unstable();
    names.dedup();
    let mut world = World::new(rows.len(), cols, names.iter().copied());
    for (place, meaning) in world.places().zip(rows.into_iter().flatten()) {
        let item = names.iter().position(|&name| Some(name) == meaning.item);
        *world.cell_mut(place) = Cell { item, ..meaning.cell };
        world.starts.extend(meaning.start.then_some(place));
    }
    // Robots are numbered in reading order.
    world.starts.sort_by_key(|place| (std::cmp::Reverse(place.row), place.col));
    let all = drawing[0].span.start..drawing[drawing.len() - 1].span.end;
    match (world.starts.len(), world.items.len()) {
        (0, _) => wrong(all, "no robot starts in this map", "mark a start with `@`"),
        (n, _) if n > super::MOST_ROBOTS => wrong(all, format!("{n} robots are too many"), ""),
        (_, 0) => wrong(all, "this map has no item", "mark items with capital letters"),
        _ => Ok(world),
    }
}

/// Parses `battery 8` or `battery none`.
fn battery(line: &Line) -> Result<Option<u32>, Wrong> {
    let [_, word] = &line[..] else {
        return wrong(whole(line), "expected one number, or none", "");
    };
    match word.text.parse::<u32>() {
        _ if word.text == "none" => Ok(None),
        Ok(full) if (1..=super::LARGEST_BATTERY).contains(&full) => Ok(Some(full)),
        _ => wrong(word.span.clone(), format!("expected none or 1 to {}", super::LARGEST_BATTERY), ""),
    }
}

/// Parses `open A B -> D E charger`.
fn open(line: &Line, world: &mut World) -> Result<(), Wrong> {
    let help = "write, for example, `open A, B -> D, charger`";
    let Some(arrow) =
        line.iter().position(|word| word.text == "->").filter(|&at| at > 1 && at + 1 < line.len())
    else {
        return wrong(
            whole(line),
            "expected items, `->`, and the items or chargers that they make available",
            help,
        );
    };
    let lock = |word: &Word| {
        let number = world.items.iter().position(|item| item.name.to_string() == word.text);
        match number {
            Some(number) => Ok(Lock::Item(number)),
            None if word.text == "charger" => Ok(Lock::Charger),
            None => wrong(word.span.clone(), format!("the map has no item `{}`", word.text), ""),
        }
    };
    let keys = line[1..arrow].iter().map(lock).collect::<Result<Vec<_>, _>>()?;
    let locks = line[arrow + 1..].iter().map(lock).collect::<Result<Vec<_>, _>>()?;
    for (key, word) in keys.iter().zip(&line[1..]) {
        let Lock::Item(item) = *key else {
            return wrong(word.span.clone(), "a charger makes nothing available", help);
        };
        let opens = &mut world.items[item].opens;
        opens.extend(&locks);
        opens.sort_unstable();
        opens.dedup();
    }
    Ok(())
}

/// Parses `patrol 1,0 1,4`: row and column of both ends.
fn patrol(line: &Line, world: &World) -> Result<Patrol, Wrong> {
    let help = "write rows and columns of both ends: `patrol 1,0 1,4`";
    let numbers: Option<Vec<usize>> = line[1..].iter().map(|word| word.text.parse().ok()).collect();
    let Some([r1, c1, r2, c2]) = numbers.as_deref() else {
        return wrong(whole(line), "expected four numbers", help);
    };
    let (from, to) = (Place { row: *r1, col: *c1 }, Place { row: *r2, col: *c2 });
    let patrol = Patrol { from: from.min(to), to: from.max(to) };
    let message = if patrol.to.row >= world.rows || from.col.max(to.col) >= world.cols {
        "this is outside of the map"
    } else if (from.row == to.row) == (from.col == to.col) {
        "a track must be straight and have at least two cells"
    } else if world.places().any(|place| patrol.covers(place) && world.cell(place).wall) {
        "a wall is on the track"
    } else {
        return Ok(patrol);
    };
    wrong(whole(line), message, help)
}

/// Returns a cell in which all four actions are disabled.
fn stuck(world: &World) -> Option<Place> {
    world.places().find(|&place| Direction::ALL.into_iter().all(|d| world.cell(place).disabled.contains(d)))
}
