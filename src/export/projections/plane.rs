//! The selection of the variables that span a plane.

use meliora_base::error::{Diagnostic, Error, Result, SourceFile};
use meliora_base::value::Type;
use meliora_model::{Program, VarId};

/// Pairs of names that usually mean a row and a column.
const NAMES: [(&str, &str); 7] =
    [("row", "col"), ("row", "column"), ("r", "c"), ("y", "x"), ("lat", "lon"), ("i", "j"), ("posy", "posx")];

/// The maximum number of cells of a plane; each cell is drawn.
const MOST_CELLS: u64 = 1 << 14;

/// The maximum number of variables that are tried as rows.
const MOST_TRIED: usize = 100;

/// The variables that span a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Plane {
    /// The variable that grows from row to row; none for a picture with one row.
    pub row: Option<VarId>,
    /// The variable that grows from column to column.
    pub column: VarId,
}

impl Plane {
    /// Returns the plane that `ROW,COLUMN` or `COLUMN` names.
    ///
    /// # Errors
    /// An unknown name, a repeated variable, or too many cells, with the place in the
    /// text; more than two names.
    pub fn named(program: &Program, text: &str) -> Result<Self> {
        let source = SourceFile::new("the grid", text);
        let mut variables = Vec::new();
        let mut start = 0;
        for part in text.split(',') {
            let span = start..start + part.len();
            start = span.end + 1;
            let wrong = |message: String| {
                let drawn = program.variables.iter().filter(|v| v.low < v.high);
                let known = drawn.map(|v| v.name.as_str()).collect::<Vec<_>>().join(", ");
                let help = format!("a grid has variables with several values: {known}");
                Error::from(Diagnostic::new(&source, span.clone(), message).help(help))
            };
            let name = part.trim();
            let Some(variable) = program.variable(name) else {
                return Err(wrong(format!("unknown variable `{name}`")));
            };
            if variables.contains(&variable) {
                return Err(wrong(format!("`{name}` is named twice")));
            }
            variables.push(variable);
        }
        let plane = match variables[..] {
            [column] => Plane { row: None, column },
            [row, column] => Plane { row: Some(row), column },
            _ => return Err(Error::Usage("a grid has one or two variables: ROW,COLUMN".to_owned())),
        };
        match plane.cells(program) {
            cells if cells > MOST_CELLS => {
                let message = format!("this plane has {cells} cells; at most {MOST_CELLS} can be drawn");
                Err(Diagnostic::new(&source, 0..text.len(), message).into())
            }
            _ => Ok(plane),
        }
    }

    /// Returns the plane that the names of the variables suggest, such as `r` and `c`, `robot_row`
    /// and `robot_col`, or `x1` and `y1`. Otherwise returns the first two integers, or a single
    /// one, whose plane is small enough to be drawn, and Booleans in a model without integers; none if
    /// all are too large. Monitors and variables that say whose turn it is are no axes.
    pub fn guess(program: &Program) -> Option<Self> {
        let small = |plane: &Plane| plane.cells(program) <= MOST_CELLS;
        let named = || pairs(program).next().filter(small);
        named()
            .or_else(|| first(&telling(program, false)).find(small))
            .or_else(|| first(&telling(program, true)).find(small))
    }

    /// Returns the other pairs of variables whose names and ranges suggest positions in the same plane,
    /// such as `r2` and `c2` next to `r1` and `c1`.
    pub fn others(self, program: &Program) -> Vec<Self> {
        let Some(row) = self.row else { return Vec::new() };
        let range = |v: VarId| (program.variables[v.index()].low, program.variables[v.index()].high);
        let fits = |plane: &Plane| {
            let own = |v| v == row || v == self.column;
            let beside = |v: VarId, like: VarId| !own(v) && range(v) == range(like);
            plane.row.is_some_and(|other| beside(other, row)) && beside(plane.column, self.column)
        };
        let mut found: Vec<Plane> = Vec::new();
        for plane in pairs(program).filter(fits) {
            if !found.iter().any(|known| known.row == plane.row) {
                found.push(plane);
            }
        }
        found
    }

    fn cells(self, program: &Program) -> u64 {
        let values = |v: VarId| {
            let variable = &program.variables[v.index()];
            (variable.high.wrapping_sub(variable.low) as u64).saturating_add(1)
        };
        self.row.map_or(1, values).saturating_mul(values(self.column))
    }
}

/// Returns the pairs of integers whose names suggest rows and columns, by [`NAMES`].
fn pairs(program: &Program) -> impl Iterator<Item = Plane> + '_ {
    let named = |name: &str| integers(program).find(|v| program.variables[v.index()].name == name);
    NAMES.iter().flat_map(move |&(row, column)| {
        integers(program).filter_map(move |variable| {
            let partner = partner(&program.variables[variable.index()].name, row, column)?;
            Some(Plane { row: Some(variable), column: named(&partner)? })
        })
    })
}

/// Returns the planes over two of some variables in their order, then those over one.
fn first(variables: &[VarId]) -> impl Iterator<Item = Plane> + '_ {
    let pair = |(at, &row): (usize, &VarId)| {
        variables[at + 1..].iter().map(move |&column| Plane { row: Some(row), column })
    };
    let pairs = variables.iter().enumerate().take(MOST_TRIED).flat_map(pair);
    pairs.chain(variables.iter().map(|&column| Plane { row: None, column }))
}

/// Returns the integers, or the Booleans, that can tell states of different results apart: no monitors, and
/// no variables that say whose turn it is.
fn telling(program: &Program, booleans: bool) -> Vec<VarId> {
    let monitors = program.monitors.as_ref().map(|monitors| monitors.module);
    let is_turn = |name: &str| name.to_ascii_lowercase().split('_').any(|word| word == "turn");
    let tells = |&id: &VarId| {
        let variable = &program.variables[id.index()];
        let is_monitor = monitors.is_some() && variable.module == monitors;
        let is_wanted = (variable.ty == Type::Bool) == booleans && variable.low < variable.high;
        is_wanted && !is_monitor && !is_turn(&variable.name)
    };
    program.variable_ids().filter(tells).collect()
}

/// Returns the integers with more than one value.
fn integers(program: &Program) -> impl Iterator<Item = VarId> + '_ {
    let many = |(_, v): &(usize, &meliora_model::Variable)| v.ty != Type::Bool && v.low < v.high;
    program.variables.iter().enumerate().filter(many).map(|(index, _)| VarId(index as u32))
}

/// Returns the name of the column that matches the name of a row: `c1` for `r1`, `van_col` for
/// `van_row`.
fn partner(name: &str, row: &str, column: &str) -> Option<String> {
    let lower = name.to_ascii_lowercase();
    let is_word = |c: Option<char>| c.is_none_or(|c| !c.is_ascii_alphabetic());
    if lower.starts_with(row) && is_word(name[row.len()..].chars().next()) {
        return Some(like(name, column) + &name[row.len()..]);
    }
    let before = name.len().checked_sub(row.len())?;
    if lower.ends_with(row) && is_word(name[..before].chars().next_back()) {
        return Some(name[..before].to_owned() + &like(&name[before..], column));
    }
    None
}

/// Returns `word`, capitalised if the name is.
fn like(name: &str, word: &str) -> String {
    match name.chars().next() {
        Some(first) if first.is_ascii_uppercase() && name.len() == 1 => word.to_ascii_uppercase(),
        Some(first) if first.is_ascii_uppercase() => word[..1].to_ascii_uppercase() + &word[1..],
        _ => word.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::partner;

    #[test]
    fn names_of_rows_and_columns_are_paired() {
        for (name, row, column, expected) in [
            ("r", "r", "c", Some("c")),
            ("r1", "r", "c", Some("c1")),
            ("robot_row", "row", "col", Some("robot_col")),
            ("Y", "y", "x", Some("X")),
            ("y_2", "y", "x", Some("x_2")),
            ("car", "r", "c", None),
            ("ready", "r", "c", None),
        ] {
            assert_eq!(partner(name, row, column).as_deref(), expected, "{name}");
        }
    }
}
