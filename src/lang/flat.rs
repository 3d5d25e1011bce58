//! A flat program as text in the modelling language: the output of `info --flat`.

mod composition;
mod expr;
mod identifiers;
mod merge;

use std::fmt::{self, Display, Formatter, Write as _};
use std::sync::Arc;

use super::names::Names;
use composition::Composition;
use expr::Expressions;
use meliora_base::error::Result;
use meliora_base::value::Type;
use meliora_model::rewards::{Earner, RewardItem, RewardStructure};
use meliora_model::{Command, Program, Variable};

/// A program as a model file; the text is written piece by piece when it is displayed.
#[derive(Clone)]
pub struct Flat(Arc<Program>);

impl Flat {
    /// Prepares a program for output. Constants and formulas are substituted, and renamings are
    /// carried out. A `system` block is added at the end if the modules are not composed in full
    /// parallel.
    ///
    /// The text parses to a program with the same states and choices. The names of actions are the
    /// same too, except for modules that had to be merged, and for names that the language does not
    /// allow. Locations become the numbers of their values, which a comment lists.
    ///
    /// # Errors
    /// Modules that the language cannot express separately have too many commands when merged; a game.
    pub fn new(program: &Arc<Program>) -> Result<Self> {
        let help =
            "the text does not name the players of its commands; `info` without `--flat` shows the model";
        program.refuse_game("the flat program", help)?;
        merge::merged(program).map(identifiers::with_identifiers).map(Flat)
    }
}

/// Returns the text of `Flat::new`.
///
/// # Errors
/// See `Flat::new`.
pub fn flat(program: &Program) -> Result<String> {
    Flat::new(&Arc::new(program.clone())).map(|flat| flat.to_string())
}

impl Display for Flat {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let program = &*self.0;
        writeln!(f, "{}", <&str>::from(program.kind))?;
        for (name, value) in &program.constants {
            write!(f, "\nconst {} {name} = {};", value.ty(), expr::Literal(value.clone()))?;
        }
        let expressions = Expressions::new(program);
        expressions.definitions(f)?;
        for variable in program.variables.iter().filter(|v| v.module.is_none()) {
            write!(f, "\nglobal {}", Declaration(variable))?;
        }
        modules(f, program, &expressions)?;
        if program.variables.iter().any(|v| v.initial.is_none()) {
            writeln!(f, "\ninit {} endinit", expressions.of(program.initial))?;
        }
        let mut names = Names::default();
        for (name, body) in &program.labels {
            write!(f, "\nlabel \"{}\" = {};", names.add(name), expressions.of(*body))?;
        }
        f.write_char('\n')?;
        program.rewards.iter().try_for_each(|structure| write_rewards(f, program, structure, &expressions))
    }
}

/// Writes all modules, and the `system` block if one is needed.
fn modules(f: &mut Formatter<'_>, program: &Program, expressions: &Expressions<'_>) -> fmt::Result {
    let composition = Composition::new(program);
    let mut variables: Vec<&Variable> = program.variables.iter().filter(|v| v.module.is_some()).collect();
    // A stable sort: within a module the order of the declarations stays.
    variables.sort_by_key(|v| v.module);
    let mut variables = variables.into_iter().peekable();
    for (module, name) in program.modules.iter().enumerate() {
        writeln!(f, "\nmodule {name}")?;
        while let Some(variable) = variables.next_if(|v| v.module == Some(module)) {
            writeln!(f, "    {}", Declaration(variable))?;
        }
        for (command, label) in composition.commands(program, module) {
            write!(f, "    [{label}] ")?;
            write_command(f, program, command, expressions)?;
        }
        f.write_str("endmodule\n")?;
    }
    composition.system(program).map_or(Ok(()), |system| writeln!(f, "\n{system}"))
}

fn write_command(
    f: &mut Formatter<'_>,
    program: &Program,
    command: &Command,
    expressions: &Expressions<'_>,
) -> fmt::Result {
    write!(f, "{} -> ", expressions.of(command.guard))?;
    for (i, branch) in command.branches.iter().enumerate() {
        let plus = if i > 0 { " + " } else { "" };
        write!(f, "{plus}{} : ", expressions.of(branch.probability))?;
        if branch.updates.is_empty() {
            f.write_str("true")?;
        }
        for (j, (variable, value)) in branch.updates.iter().enumerate() {
            let and = if j > 0 { " & " } else { "" };
            let name = &program.variables[variable.index()].name;
            write!(f, "{and}({name}' = {})", expressions.of(*value))?;
        }
    }
    f.write_str(";\n")
}

/// Writes a reward structure. The language has no rewards of single commands, which edges of JANI
/// have; a structure with such rewards is left out with a comment.
fn write_rewards(
    f: &mut Formatter<'_>,
    program: &Program,
    structure: &RewardStructure,
    expressions: &Expressions<'_>,
) -> fmt::Result {
    let title = structure.title();
    if structure.items.iter().any(|item| matches!(item.earner, Earner::Command(_))) {
        return writeln!(f, "\n// The rewards {title} are left out: some belong to single commands.");
    }
    if let Some(error) = structure.errors.first() {
        let reason = error.message.escape_debug();
        return writeln!(f, "\n// The rewards {title} are left out: {reason}.");
    }
    f.write_str("\nrewards")?;
    if structure.name.is_some() {
        write!(f, " {title}")?;
    }
    // The language knows only actions that some choice has; items of others never apply.
    let applies = |item: &&RewardItem| match item.earner {
        Earner::Action(Some(action)) => program.synchronisations.iter().any(|s| s.action == Some(action)),
        _ => true,
    };
    for item in structure.items.iter().filter(applies) {
        f.write_str("\n    ")?;
        if let Earner::Action(action) = item.earner {
            write!(f, "[{}] ", action.map_or("", |a| program.actions[a].as_str()))?;
        }
        write!(f, "{} : {};", expressions.of(item.guard), expressions.of(item.value))?;
    }
    f.write_str("\nendrewards\n")
}

/// The declaration of a variable.
struct Declaration<'v>(&'v Variable);

impl Display for Declaration<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let variable = self.0;
        write!(f, "{} : ", variable.name)?;
        match variable.ty {
            Type::Bool => f.write_str("bool")?,
            _ => write!(f, "[{}..{}]", variable.low, variable.high)?,
        }
        match variable.initial {
            Some(value) if variable.ty == Type::Bool => write!(f, " init {}", variable.show(value))?,
            Some(value) => write!(f, " init {value}")?,
            None => {}
        }
        f.write_char(';')?;
        if variable.values.is_empty() {
            return Ok(());
        }
        // A line break in a name must not end the comment.
        write!(f, " // {}", variable.values.join(", ").escape_debug())
    }
}
