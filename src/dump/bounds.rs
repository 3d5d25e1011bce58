//! `values.csv`: bounds of quantities that one step per state confirms.
//!
//! One row per state, and under `prefix` per state and arena. The columns are `arena` (the class
//! that improvements are measured against; only under `prefix`), the variables of the model as
//! integers (names with commas are quoted), and for k = 1, 2, … first `p_k_lower`, `p_k_upper`, `p_k_rank` and then `c_k_lower`,
//! `c_k_upper`, `c_k_rank`, which are empty for models without a cost.
//!
//! A number is `n/d`, an exact fraction; or `inf`; or a decimal number, which stands for the double
//! nearest to it.

use std::borrow::Cow;
use std::io::{self, BufRead, Write};

pub use meliora_base::bound::Bound;
/// The name of a bound in version 1.0.
pub use meliora_base::bound::Bound as Number;
use meliora_base::error::{Error, Result};
use meliora_base::escape;
use meliora_model::State;

/// The largest number of bytes of a row.
const LONGEST: u64 = 64 << 20;

/// The bounds of one quantity of a state.
#[derive(Debug, Clone, PartialEq)]
pub struct Bounds {
    /// The lower bound.
    pub lower: Bound,
    /// The upper bound.
    pub upper: Bound,
    /// The rank: some choice that confirms the bound enters a smaller rank with positive
    /// probability. It proves the lower bound of a probability, and the upper one of a cost.
    pub rank: u32,
}

/// The values of a state in an arena.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// The class of the arena under `prefix`, as in `safe:C`; else empty.
    pub arena: String,
    /// The values of the variables.
    pub state: State,
    /// P_1, P_2, …
    pub probabilities: Vec<Bounds>,
    /// C_1, C_2, …; `None` where the probability is less than 1.
    pub costs: Vec<Option<Bounds>>,
}

/// The columns of a table.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Layout {
    /// True if each row names an arena.
    pub arenas: bool,
    /// The names of the variables.
    pub variables: Vec<String>,
    /// The greatest number of improvements.
    pub levels: usize,
}

impl Layout {
    fn columns(&self) -> usize {
        usize::from(self.arenas) + self.variables.len() + 6 * self.levels
    }

    fn header(&self) -> String {
        self.header_of(cell)
    }

    /// Returns the header as it was written before names with commas were quoted.
    fn old_header(&self) -> String {
        self.header_of(Cow::Borrowed)
    }

    fn header_of<'l>(&'l self, cell: impl Fn(&'l str) -> Cow<'l, str>) -> String {
        let mut names: Vec<String> = Vec::with_capacity(self.columns());
        names.extend(self.arenas.then(|| "arena".to_owned()));
        names.extend(self.variables.iter().map(|name| cell(name).into_owned()));
        for k in 1..=self.levels {
            for quantity in ["p", "c"] {
                names.extend(["lower", "upper", "rank"].map(|what| format!("{quantity}_{k}_{what}")));
            }
        }
        names.join(",")
    }
}

/// Returns a cell; one with a comma or quotes, such as `lnk(a,b)`, is quoted.
fn cell(text: &str) -> Cow<'_, str> {
    match text.contains([',', '"', '\n', '\r']) {
        true => Cow::Owned(escape::quoted(text)),
        false => Cow::Borrowed(text),
    }
}

/// Writes a table.
///
/// # Errors
/// Writing fails.
pub fn write(layout: &Layout, rows: &[Row], out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "{}", layout.header())?;
    for row in rows {
        let mut cells: Vec<String> = Vec::with_capacity(layout.columns());
        cells.extend(layout.arenas.then(|| row.arena.clone()));
        cells.extend(row.state.iter().map(i64::to_string));
        for (probability, cost) in row.probabilities.iter().zip(&row.costs) {
            for bounds in [Some(probability), cost.as_ref()] {
                match bounds {
                    Some(b) => cells.extend([b.lower.to_string(), b.upper.to_string(), b.rank.to_string()]),
                    None => cells.extend([const { String::new() }; 3]),
                }
            }
        }
        writeln!(out, "{}", cells.join(","))?;
    }
    Ok(())
}

/// Reads a table.
///
/// # Errors
/// [`Error::Dump`] with the line, if the text is not a table with this layout; reading fails.
pub fn read(name: &str, layout: &Layout, input: &mut impl BufRead) -> Result<Vec<Row>> {
    let wrong = |line: usize, message: String| Error::Dump { file: name.to_owned(), line, message };
    let mut lines = Lines { input, name, line: 0, text: String::new() };
    let headers = [layout.header(), layout.old_header()];
    if !lines.next()?.is_some_and(|found| headers.iter().any(|header| header == found)) {
        return Err(wrong(1, format!("expected the columns {}", headers[0].escape_debug())));
    }
    let mut rows = Vec::new();
    while let Some(text) = lines.next()? {
        let row = row(layout, text);
        rows.push(row.map_err(|message| wrong(rows.len() + 2, message))?);
    }
    Ok(rows)
}

/// The lines of a text, each of bounded length.
struct Lines<'a, R> {
    input: &'a mut R,
    name: &'a str,
    line: usize,
    text: String,
}

impl<R: BufRead> Lines<'_, R> {
    fn next(&mut self) -> Result<Option<&str>> {
        self.text.clear();
        self.line += 1;
        let read = io::Read::take(&mut *self.input, LONGEST).read_line(&mut self.text);
        let failed = |e: io::Error| Error::Io { path: self.name.to_owned(), message: e.to_string() };
        if read.map_err(failed)? == 0 {
            return Ok(None);
        }
        self.text.strip_suffix('\n').map(Some).ok_or_else(|| {
            let message = "the line is too long, or does not end".to_owned();
            Error::Dump { file: self.name.to_owned(), line: self.line, message }
        })
    }
}

/// Returns a wrong cell for a message.
fn shown(text: &str) -> String {
    escape::shortened(text).escape_debug().to_string()
}

fn row(layout: &Layout, text: &str) -> std::result::Result<Row, String> {
    let cells: Vec<&str> = text.split(',').collect();
    if cells.len() != layout.columns() {
        return Err(format!("{} columns instead of {}", cells.len(), layout.columns()));
    }
    let mut cells = cells.into_iter();
    let arena = if layout.arenas { cells.next().unwrap_or_default().to_owned() } else { String::new() };
    let mut state = State::with_capacity(layout.variables.len());
    for text in cells.by_ref().take(layout.variables.len()) {
        state.push(text.parse().map_err(|_| format!("`{}` is not an integer", shown(text)))?);
    }
    let (mut probabilities, mut costs) = (Vec::new(), Vec::new());
    while let (Some(lower), Some(upper), Some(rank)) = (cells.next(), cells.next(), cells.next()) {
        let is_cost = probabilities.len() > costs.len();
        if is_cost && [lower, upper, rank] == [""; 3] {
            costs.push(None);
            continue;
        }
        let number =
            |text: &str| Bound::parse(text).ok_or_else(|| format!("`{}` is not a bound", shown(text)));
        let rank = rank.parse().map_err(|_| format!("`{}` is not a rank", shown(rank)))?;
        let bounds = Bounds { lower: number(lower)?, upper: number(upper)?, rank };
        if is_cost { costs.push(Some(bounds)) } else { probabilities.push(bounds) }
    }
    Ok(Row { arena, state, probabilities, costs })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(text: &str) -> Bound {
        Bound::parse(text).unwrap()
    }

    #[test]
    fn a_table_is_read_as_it_was_written() {
        let bounds = |lower, upper, rank| Bounds { lower: number(lower), upper: number(upper), rank };
        let layout = Layout { arenas: true, variables: vec!["x".to_owned(), "y".to_owned()], levels: 2 };
        let probabilities = vec![bounds("0.1", "1/3", 2), bounds("0", "1e-300", 0)];
        let costs = vec![Some(bounds("5", "inf", 7)), None];
        let row = Row { arena: "A+B".to_owned(), state: vec![-1, 3], probabilities, costs };
        let (rows, mut text) = (vec![row.clone(), row], Vec::new());
        write(&layout, &rows, &mut text).unwrap();
        assert_eq!(read("v", &layout, &mut &text[..]).unwrap(), rows);
        for changed in ["\n", "x,", "inf,7", ",-1,3", "1/3"] {
            let text = String::from_utf8(text.clone()).unwrap().replacen(changed, "-", 1);
            assert!(read("v", &layout, &mut text.as_bytes()).is_err(), "{changed:?}");
        }
    }

    #[test]
    fn names_with_commas_are_quoted_in_the_header() {
        let layout =
            Layout { arenas: false, variables: vec!["lnk(a,b)".to_owned(), "x".to_owned()], levels: 0 };
        let mut text = Vec::new();
        write(&layout, &[], &mut text).unwrap();
        assert_eq!(text, b"\"lnk(a,b)\",x\n");
        for header in ["\"lnk(a,b)\",x\n", "lnk(a,b),x\n"] {
            assert_eq!(read("v", &layout, &mut header.as_bytes()).unwrap(), [], "{header}");
        }
    }

    #[test]
    fn a_wrong_number_of_a_million_digits_is_shortened_in_the_message() {
        let layout = Layout { arenas: false, variables: vec!["x".to_owned()], levels: 1 };
        let long = "1".repeat(1_000_000);
        for row in [format!("{long},0,1,0,,,"), format!("0,{long}/1,1,0,,,"), format!("0,0,1,{long},,,")] {
            let text = format!("{}\n{row}\n", layout.header());
            let error = read("v", &layout, &mut text.as_bytes()).unwrap_err().to_string();
            assert!(error.len() < 200 && error.contains("…"), "{} bytes", error.len());
        }
    }
}
