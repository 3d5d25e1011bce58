//! The values of variables that a participant tells apart.
//!
//! A guard such as `x>3` is the same for all x up to 3, and so is the effect of `x'=x+1` unless x is the greatest
//! value. States with equal *classes* of values therefore enable the same commands with the same effects.

use std::collections::{BTreeMap, BTreeSet};

use ahash::AHashSet;

use super::layout::width;
use super::needs::interval;
use super::program::Chances;
use meliora_base::stack;
use meliora_base::value::Value;
use meliora_model::expr::{Binary, ExprId, ExprPool, Node};
use meliora_model::{Command, CommandId, Program, VarId};

/// Maximum number of classes of one participant.
const MOST_CLASSES: usize = 1 << 22;
/// Maximum number of values of a variable that form fewer classes.
const MOST_VALUES: usize = 1 << 16;
/// Maximum number of classes that tell apart all values on which effects depend.
const MOST_STEADY: usize = 1 << 16;
/// Maximum number of values that all participants list with their class, four bytes each.
pub(crate) const MOST_LISTED: usize = 1 << 20;

/// A variable with the classes of its values.
struct Axis {
    variable: usize,
    low: i64,
    /// The class of each value, times `weight`; empty if each value is a class.
    classes: Vec<u32>,
    weight: u32,
}

/// The classes of values of some variables. Each combination of them has a place.
pub(crate) struct ValueClasses {
    axes: Vec<Axis>,
    /// The number of places.
    pub(crate) size: usize,
    /// The commands whose effects also depend on other values.
    unsteady: Vec<CommandId>,
}

impl ValueClasses {
    /// Finds the classes for some commands, given how their probabilities vary. `None` if there are too many, or if more
    /// values are to be listed than `room`, which is reduced by their number.
    pub(crate) fn new(
        program: &Program,
        commands: &[CommandId],
        chances: impl Fn(CommandId) -> Chances,
        room: &mut usize,
    ) -> Option<Self> {
        let mut cuts = Cuts::new(program, ByVariable::new());
        commands.iter().for_each(|&command| cuts.add_command(command, chances(command)));
        let mut found = ValueClasses { axes: Vec::new(), size: 1, unsteady: Vec::new() };
        let Cuts { mut of, loose, .. } = cuts;
        for (command, variable, e) in loose {
            let mut wider = Cuts::new(program, of.clone());
            wider.tell_all(variable);
            wider.add(e);
            if size(program, &wider.of).is_some_and(|size| size <= MOST_STEADY) {
                of = wider.of;
            } else if wider.of != of {
                found.unsteady.push(command);
            }
        }
        if size(program, &of)? > MOST_CLASSES {
            return None;
        }
        of.iter().for_each(|(&variable, cuts)| found.add(program, variable, cuts.as_ref()));
        *room = room.checked_sub(found.listed())?;
        Some(found)
    }

    /// Adds a variable with its cuts.
    fn add(&mut self, program: &Program, variable: VarId, cuts: Option<&BTreeSet<i64>>) {
        let declared = &program.variables[variable.index()];
        let (low, values) = (declared.low, count(program, variable, None).unwrap_or(0));
        let (weight, mut classes, mut class) = (self.size as u32, Vec::new(), 0);
        if let Some(cuts) = cuts.filter(|cuts| values <= MOST_VALUES && cuts.len() + 1 < values) {
            for value in low..=declared.high {
                class += u32::from(cuts.contains(&value)) * weight;
                classes.push(class);
            }
        }
        self.axes.push(Axis { variable: variable.index(), low, classes, weight });
        self.size *= count(program, variable, cuts).unwrap_or(1);
    }

    /// Returns the number of values that are listed with their class.
    fn listed(&self) -> usize {
        self.axes.iter().map(|axis| axis.classes.len()).sum()
    }

    /// Returns whether the effects of a command are the same in all states of a place.
    pub(crate) fn is_steady(&self, command: u32) -> bool {
        self.unsteady.iter().all(|&other| other.0 != command)
    }

    /// Returns the variables on which the place of a state depends.
    pub(crate) fn variables(&self) -> impl Iterator<Item = usize> {
        self.axes.iter().map(|axis| axis.variable)
    }

    /// Returns the place of a state.
    #[inline]
    pub(crate) fn place(&self, values: &[i64]) -> usize {
        let mut place = 0;
        for axis in &self.axes {
            let at = values[axis.variable].wrapping_sub(axis.low) as usize;
            place += axis.classes.get(at).map_or(at * axis.weight as usize, |&class| class as usize);
        }
        place
    }
}

/// The lowest value of each class but the first, by variable; `None` for a variable of which all values differ.
type ByVariable = BTreeMap<VarId, Option<BTreeSet<i64>>>;

/// Returns the number of classes of all variables together; `None` if it is too large for a number.
fn size(program: &Program, of: &ByVariable) -> Option<usize> {
    of.iter().try_fold(1, |all: usize, (&v, cuts)| all.checked_mul(count(program, v, cuts.as_ref())?))
}

/// Returns the number of classes of a variable.
fn count(program: &Program, variable: VarId, cuts: Option<&BTreeSet<i64>>) -> Option<usize> {
    let all = usize::try_from(width(&program.variables[variable.index()])).ok()?.checked_add(1)?;
    Some(cuts.filter(|_| all <= MOST_VALUES).map_or(all, |cuts| cuts.len() + 1))
}

/// The findings while commands are read.
struct Cuts<'p> {
    program: &'p Program,
    seen: AHashSet<ExprId>,
    updates: AHashSet<(CommandId, VarId, ExprId)>,
    of: ByVariable,
    /// The updates whose effect depends on all values of the variable.
    loose: Vec<(CommandId, VarId, ExprId)>,
}

impl<'p> Cuts<'p> {
    fn new(program: &'p Program, of: ByVariable) -> Self {
        Cuts { program, seen: AHashSet::new(), updates: AHashSet::new(), of, loose: Vec::new() }
    }

    fn add_command(&mut self, command: CommandId, chances: Chances) {
        let Command { guard, branches, .. } = &self.program.commands[command.index()];
        self.add(*guard);
        for branch in branches {
            if chances == Chances::Vary {
                self.add(branch.probability);
            }
            branch.updates.iter().for_each(|&(variable, e)| self.add_update(command, variable, e));
        }
    }

    /// Adds the values on which an expression depends.
    fn add(&mut self, e: ExprId) {
        if !self.seen.insert(e) {
            return;
        }
        let pool = &self.program.pool;
        match (interval(pool, e, true), pool.node(e)) {
            (Some((variable, [low, high])), _) => self.cut(variable, low, high),
            (None, Node::Var(variable)) => self.tell_all(variable),
            _ => stack::level(|| pool.operands(e).for_each(|operand| self.add(operand))),
        }
    }

    /// Adds the values on which the effect of an update depends: for `x'=x+1` only the ends of the range of x.
    fn add_update(&mut self, command: CommandId, variable: VarId, e: ExprId) {
        let (pool, declared) = (&self.program.pool, &self.program.variables[variable.index()]);
        if !self.updates.insert((command, variable, e)) {
            return;
        }
        match pool.node(e) {
            Node::Var(same) if same == variable => return,
            Node::Ite(condition, then, otherwise) => {
                self.add(condition);
                let mut add = |e| stack::level(|| self.add_update(command, variable, e));
                return [then, otherwise].into_iter().for_each(&mut add);
            }
            _ => {}
        }
        // A sum of any value is a number if those of both ends are.
        let is_total = |by: &i64| declared.low.checked_add(*by).and(declared.high.checked_add(*by)).is_some();
        let ends = added(pool, variable, e)
            .filter(is_total)
            .and_then(|by| Some((declared.low.checked_sub(by)?, declared.high.checked_sub(by)?)));
        match ends {
            Some((low, high)) => self.cut(variable, low, high),
            None => self.loose.push((command, variable, e)),
        }
    }

    /// Tells the values of an interval apart from lower and from higher ones.
    fn cut(&mut self, variable: VarId, low: i64, high: i64) {
        let declared = &self.program.variables[variable.index()];
        let inside = |cut: &i64| declared.low < *cut && *cut <= declared.high;
        if let Some(cuts) = self.of.entry(variable).or_insert_with(|| Some(BTreeSet::new())) {
            cuts.extend([low, high.saturating_add(1)].into_iter().filter(inside));
        }
    }

    fn tell_all(&mut self, variable: VarId) {
        self.of.insert(variable, None);
    }
}

/// Returns the number that an expression adds to a variable, if it does no more.
fn added(pool: &ExprPool, variable: VarId, e: ExprId) -> Option<i64> {
    let (op, a, b) = match pool.node(e) {
        Node::Binary(op, a, b) => (op, pool.node(a), pool.node(b)),
        _ => return None,
    };
    match (op, a, b) {
        (Binary::Add, Node::Var(v), Node::Literal(Value::Int(c)))
        | (Binary::Add, Node::Literal(Value::Int(c)), Node::Var(v))
            if v == variable =>
        {
            Some(c)
        }
        (Binary::Sub, Node::Var(v), Node::Literal(Value::Int(c))) if v == variable => c.checked_neg(),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meliora_base::error::SourceFile;
    use meliora_lang as lang;

    #[test]
    fn values_that_no_command_tells_apart_have_one_class() {
        let text = "mdp module m x : [0..99]; b : [0..59999]; c : bool; \
            [] b>0 & x<50 -> (x'=x+1) & (b'=c ? 9 : b-1); [] b>0 & x<50 -> (x'=x+1); endmodule";
        let program = lang::load(&SourceFile::new("m", text), &SourceFile::new("c", "")).unwrap().program;
        let both = [CommandId(0), CommandId(1)];
        let of = |mut room: usize| ValueClasses::new(&program, &both, |_| Chances::Sound, &mut room);
        assert!(of(60_000).is_none(), "60,100 values are listed");
        let found = of(60_100).unwrap();
        assert_eq!((found.size, found.is_steady(0), found.is_steady(1)), (12, false, true));
        let place = |x, b, c| found.place(&[x, b, c]);
        assert!(place(0, 1, 0) == place(49, 1, 0) && place(50, 1, 1) == place(98, 1, 1));
        assert!(place(49, 1, 0) != place(50, 1, 0) && place(98, 1, 0) != place(99, 1, 0));
        assert!(place(0, 0, 0) != place(0, 1, 0) && place(0, 1, 0) != place(0, 1, 1));
    }
}
