//! The checks of a manifest: names, ranges, encodings, and the roots of its files.

use std::collections::BTreeSet;

use super::Diagram;
use super::manifest::{CERTIFICATE, File, Manifest, REGIONS, Root, VALUES, Variable};
use meliora_base::error::ensure;
use meliora_base::escape::is_shown;

/// The maximum number of levels with values.
const MOST_LEVELS: usize = 1 << 16;
/// The maximum number of bits for choices.
const MOST_CHOICE_BITS: u32 = 20;

/// Checks a name: not empty, and every character is visible.
fn plain(what: &str, name: &str) -> Result<(), String> {
    let is_plain = !name.is_empty() && !name.contains(char::is_whitespace);
    ensure(is_plain, || format!("`{}` is not a valid name of {what}", name.escape_debug()))?;
    shown(what, name)
}

/// Checks a name that may have blanks, because only its number stands in other files.
fn shown(what: &str, name: &str) -> Result<(), String> {
    let is_shown = name.chars().all(is_shown);
    ensure(is_shown, || format!("`{}` is not a valid name of {what}", name.escape_debug()))
}

impl Variable {
    fn check(&self) -> Result<(), String> {
        let name = &self.name;
        plain("a variable", name)?;
        self.names.iter().try_for_each(|bit| plain("a bit", bit))?;
        self.values.iter().try_for_each(|value| shown("a value", value))?;
        ensure(self.is_bool() || self.ty == "int", || {
            format!("the type of `{name}` is `{}`, neither `bool` nor `int`", self.ty.escape_debug())
        })?;
        let Variable { low, high, bits, .. } = *self;
        ensure(low <= high && (!self.is_bool() || (low, high) == (0, 1)), || {
            format!("the range of `{name}` is {low}..{high}")
        })?;
        let width = u64::BITS - (high.wrapping_sub(low) as u64).leading_zeros();
        ensure(bits == width && self.names.len() == width as usize, || {
            format!("`{name}` needs {width} bits for its range, not {bits}")
        })
    }
}

impl File {
    /// Checks that the roots are those of the diagram, each with its own name, and that the diagram
    /// is ordered.
    pub(super) fn check(&self, diagram: &Diagram) -> Result<(), String> {
        self.check_names(&self.path)?;
        let (path, nodes) = (&self.path, diagram.nodes.len() + 1);
        ensure(diagram.is_ordered(), || {
            format!("`{path}` has an arc to a later node, or to a variable that is not deeper")
        })?;
        ensure(self.nodes == nodes, || format!("`{path}` has {nodes} nodes, not {}", self.nodes))?;
        for &Root { root, node, .. } in &self.roots {
            ensure(diagram.roots.get(root) == Some(&node), || {
                format!("`{path}` has no root {root} that is node {}", node.number())
            })?;
        }
        let positions = self.roots.iter().map(|root| root.root).collect::<BTreeSet<_>>().len();
        let (named, roots) = (self.roots.len(), diagram.roots.len());
        ensure((named, roots) == (positions, positions), || {
            format!("`{path}` has {roots} roots, but the manifest names {named}; each root needs one name")
        })
    }

    /// Checks that the file has the expected name, and that its roots have valid and distinct
    /// names.
    fn check_names(&self, path: &str) -> Result<(), String> {
        ensure(self.path == path, || format!("the file is `{path}`, not `{}`", self.path.escape_debug()))?;
        let mut names = BTreeSet::new();
        self.roots.iter().try_for_each(|Root { name, .. }| {
            plain("a region", name)?;
            ensure(names.insert(name), || format!("the region `{name}` occurs twice"))
        })
    }
}

impl Manifest {
    /// Checks that names are valid and distinct, and that the encodings fit them.
    pub(super) fn check(&self) -> Result<(), String> {
        self.regions.check_names(REGIONS)?;
        if let Some(file) = &self.certificate {
            file.check_names(CERTIFICATE)?;
        }
        if let Some(file) = &self.values {
            ensure(file.path == VALUES, || {
                format!("the file is `{VALUES}`, not `{}`", file.path.escape_debug())
            })?;
            ensure((1..=MOST_LEVELS).contains(&file.levels), || {
                format!("{} levels of values are not between 1 and {MOST_LEVELS}", file.levels)
            })?;
        }
        for region in self.questions.iter().flat_map(|question| &question.regions) {
            ensure(self.regions.root(region).is_some(), || {
                format!("the region `{}` of a question is missing", region.escape_debug())
            })?;
        }
        for name in self.constants.keys().chain(&self.given) {
            plain("a constant", name)?;
        }
        for name in &self.objectives {
            plain("an objective", name)?;
        }
        let mut players = BTreeSet::new();
        for name in &self.players {
            plain("a player", name)?;
            ensure(players.insert(name), || format!("two players are called `{name}`"))?;
        }
        let stranger = self.coalition.iter().find(|name| !players.contains(name));
        if let Some(name) = stranger {
            return Err(format!("`{}` of the coalition is not a player", name.escape_debug()));
        }
        let mut bits = BTreeSet::new();
        for variable in &self.encoding.variables {
            variable.check()?;
            for bit in &variable.names {
                ensure(bits.insert(bit), || format!("the bit `{bit}` occurs twice"))?;
            }
        }
        let ordered: BTreeSet<&String> = self.encoding.order.iter().collect();
        ensure(ordered == bits && self.encoding.order.len() == bits.len(), || {
            "`order` must contain each bit of the variables exactly once".to_owned()
        })?;
        let names: BTreeSet<&String> = self.encoding.variables.iter().map(|v| &v.name).collect();
        ensure(names.len() == self.encoding.variables.len(), || {
            "two variables have the same name".to_owned()
        })?;
        self.check_choices()
    }

    fn check_choices(&self) -> Result<(), String> {
        let (bits, numbers) = (self.choices.order.len(), &self.choices.numbers);
        for choice in numbers {
            let mut names =
                [&choice.name].into_iter().chain(&choice.action).chain(choice.commands.iter().flatten());
            names.try_for_each(|name| shown("a choice", name))?;
        }
        ensure(bits <= MOST_CHOICE_BITS as usize, || {
            format!("{bits} bits for choices are more than {MOST_CHOICE_BITS}")
        })?;
        ensure(numbers.iter().enumerate().all(|(position, n)| n.number == position), || {
            "the choices are not numbered in order".to_owned()
        })?;
        ensure(bits == 0 || numbers.len() <= 1 << bits, || {
            format!("{bits} bits do not number {} choices", numbers.len())
        })
    }
}
