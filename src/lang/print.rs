//! Printing of the syntax tree, as text that parses to the same tree.

use std::fmt::{self, Display, Formatter, Write as _};

use super::ast::{
    ATOM_LEVEL, Assignment, BinaryOp, Branch, Command, ConstDef, ConstType, Expr, ExprKind, Ident, Item,
    Model, ModelType, Module, NEG_LEVEL, NOT_LEVEL, RenamedModule, Rewards, System, SystemKind, VarDecl,
};

impl Expr {
    /// Returns the precedence level of the outermost operator, `None` for `?:`, which binds least.
    fn level(&self) -> Option<u8> {
        Some(match &self.kind {
            ExprKind::Ite(..) => return None,
            ExprKind::Chain(_, rest) => rest.first().map_or(ATOM_LEVEL, |(op, _)| op.level()),
            ExprKind::Not(_) => NOT_LEVEL,
            ExprKind::Neg(_) => NEG_LEVEL,
            _ => ATOM_LEVEL,
        })
    }

    /// Writes the expression, with brackets unless it binds at least as tightly as `least`.
    fn write_at(&self, f: &mut Formatter<'_>, least: u8) -> fmt::Result {
        if self.level().is_some_and(|level| level >= least) {
            write!(f, "{self}")
        } else {
            write!(f, "({self})")
        }
    }
}

impl Display for Expr {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match &self.kind {
            ExprKind::Bool(b) => write!(f, "{b}"),
            ExprKind::Int(i) => write!(f, "{i}"),
            ExprKind::Real(x) => write!(f, "{x:?}"),
            ExprKind::Name(name) => f.write_str(name),
            ExprKind::Label(name) => write!(f, "\"{name}\""),
            ExprKind::Not(e) => {
                f.write_char('!')?;
                e.write_at(f, NOT_LEVEL)
            }
            ExprKind::Neg(e) => {
                f.write_char('-')?;
                e.write_at(f, NEG_LEVEL)
            }
            ExprKind::Chain(first, rest) => write_chain(f, first, rest),
            ExprKind::Ite(cases, otherwise) => {
                for (condition, then) in cases {
                    condition.write_at(f, 0)?;
                    f.write_str(" ? ")?;
                    then.write_at(f, 0)?;
                    f.write_str(" : ")?;
                }
                otherwise.write_at(f, 0)
            }
            ExprKind::Call(function, arguments) => {
                write!(f, "{}(", function.name)?;
                list(f, arguments, |f, e| write!(f, "{e}"))?;
                f.write_char(')')
            }
        }
    }
}

fn write_chain(f: &mut Formatter<'_>, first: &Expr, rest: &[(BinaryOp, Expr)]) -> fmt::Result {
    // A chain inside a chain of the same level had brackets, on either side.
    let least = rest.first().map_or(0, |(op, _)| op.level() + 1);
    first.write_at(f, least)?;
    for (op, operand) in rest {
        write!(f, " {} ", op.symbol())?;
        operand.write_at(f, least)?;
    }
    Ok(())
}

fn list<T>(
    f: &mut Formatter<'_>,
    items: &[T],
    write: impl Fn(&mut Formatter<'_>, &T) -> fmt::Result,
) -> fmt::Result {
    for (i, item) in items.iter().enumerate() {
        if i > 0 {
            f.write_str(", ")?;
        }
        write(f, item)?;
    }
    Ok(())
}

impl Display for Model {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        if let Some((kind, _)) = self.kind {
            f.write_str(match kind {
                ModelType::Mdp => "mdp\n",
                ModelType::Dtmc => "dtmc\n",
            })?;
        }
        for item in &self.items {
            writeln!(f, "{item}")?;
        }
        Ok(())
    }
}

impl Display for Item {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Item::Const(c) => write!(f, "{c}"),
            Item::Formula(d) => write!(f, "formula {} = {};", d.name.name, d.body),
            Item::Label(d) => write!(f, "label \"{}\" = {};", d.name.name, d.body),
            Item::Global(v) => write!(f, "global {v}"),
            Item::Module(m) => write!(f, "{m}"),
            Item::Renamed(m) => write!(f, "{m}"),
            Item::Rewards(r) => write!(f, "{r}"),
            Item::Init(e) => write!(f, "init {e} endinit"),
            Item::System(s) => write!(f, "system {s} endsystem"),
        }
    }
}

impl Display for ConstDef {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let ty = match self.ty {
            ConstType::Int => "int",
            ConstType::Double => "double",
            ConstType::Bool => "bool",
        };
        write!(f, "const {ty} {}", self.name.name)?;
        if let Some(value) = &self.value {
            write!(f, " = {value}")?;
        }
        f.write_char(';')
    }
}

impl Display for VarDecl {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{} : ", self.name.name)?;
        match &self.range {
            Some((low, high)) => write!(f, "[{low}..{high}]")?,
            None => f.write_str("bool")?,
        }
        if let Some(init) = &self.init {
            write!(f, " init {init}")?;
        }
        f.write_char(';')
    }
}

impl Display for Module {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(f, "module {}", self.name.name)?;
        for variable in &self.variables {
            writeln!(f, "    {variable}")?;
        }
        self.commands.iter().try_for_each(|command| writeln!(f, "    {command}"))?;
        f.write_str("endmodule")
    }
}

impl Display for Command {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let action = self.action.as_ref().map_or("", |a| a.name.as_str());
        write!(f, "[{action}] {} -> ", self.guard)?;
        for (i, branch) in self.branches.iter().enumerate() {
            if i > 0 {
                f.write_str(" + ")?;
            }
            write!(f, "{branch}")?;
        }
        f.write_char(';')
    }
}

impl Display for Branch {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        if let Some(probability) = &self.probability {
            write!(f, "{probability} : ")?;
        }
        if self.updates.is_empty() {
            return f.write_str("true");
        }
        for (i, Assignment { variable, value }) in self.updates.iter().enumerate() {
            let and = if i > 0 { " & " } else { "" };
            write!(f, "{and}({}' = {value})", variable.name)?;
        }
        Ok(())
    }
}

impl Display for RenamedModule {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "module {} = {} [", self.name.name, self.base.name)?;
        list(f, &self.renames, |f, (old, new)| write!(f, "{} = {}", old.name, new.name))?;
        f.write_str("] endmodule")
    }
}

impl Display for Rewards {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str("rewards")?;
        if let Some(name) = &self.name {
            write!(f, " \"{}\"", name.name)?;
        }
        f.write_char('\n')?;
        for item in &self.items {
            f.write_str("    ")?;
            if let Some(action) = &item.action {
                write!(f, "[{}] ", action.as_ref().map_or("", |a| a.name.as_str()))?;
            }
            writeln!(f, "{} : {};", item.guard, item.value)?;
        }
        f.write_str("endrewards")
    }
}

impl Display for System {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match &self.kind {
            SystemKind::Module(name) => f.write_str(name),
            SystemKind::Full(parts) => operands(f, parts, " || "),
            SystemKind::Interleaved(parts) => operands(f, parts, " ||| "),
            SystemKind::Parallel(left, actions, right) => {
                left.write_operand(f)?;
                f.write_str(" |[")?;
                names(f, actions)?;
                f.write_str("]| ")?;
                right.write_operand(f)
            }
            SystemKind::Hide(inner, actions) => {
                inner.write_operand(f)?;
                f.write_str(" / {")?;
                names(f, actions)?;
                f.write_char('}')
            }
            SystemKind::Rename(inner, renames) => {
                inner.write_operand(f)?;
                f.write_str(" {")?;
                list(f, renames, |f, (old, new)| write!(f, "{} <- {}", old.name, new.name))?;
                f.write_char('}')
            }
        }
    }
}

impl System {
    /// Writes the composition, with brackets if it has several parts.
    fn write_operand(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self.kind {
            SystemKind::Module(_) | SystemKind::Hide(..) | SystemKind::Rename(..) => write!(f, "{self}"),
            _ => write!(f, "({self})"),
        }
    }
}

fn operands(f: &mut Formatter<'_>, parts: &[System], join: &str) -> fmt::Result {
    for (i, part) in parts.iter().enumerate() {
        if i > 0 {
            f.write_str(join)?;
        }
        part.write_operand(f)?;
    }
    Ok(())
}

fn names(f: &mut Formatter<'_>, names: &[Ident]) -> fmt::Result {
    list(f, names, |f, name| f.write_str(&name.name))
}
