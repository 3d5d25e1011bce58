//! A flat program as text, in the words of the modelling language: what the engines work on.
//!
//! Constants, formulas and renamings are gone; each synchronisation says which commands move
//! together.

use std::fmt::Write;

use serde::Serialize;

use super::Style;
use super::report::{Failure, Report};
use crate::model::expr::{Binary, ExprId, ExprPool, Node, Unary};
use crate::model::value::{Type, Value};
use crate::model::{Branch, Command, ModelKind, Program, Variable};

/// Expressions that would be longer are cut: shared parts are written out at every use.
const LONGEST: usize = 2_000;

/// The text of a flat program as a report.
#[derive(Debug, Clone, Default, Serialize)]
pub struct FlatReport(pub String);

impl Report for FlatReport {
    fn fail(&mut self, _: Failure) {}

    fn finish(&mut self, _: f64, _: u64) {}

    fn text(&self, _: Style) -> String {
        self.0.clone()
    }
}

/// The whole program.
pub fn render(program: &Program) -> String {
    let mut out = String::from(match program.kind {
        ModelKind::Mdp => "mdp\n",
        ModelKind::Dtmc => "dtmc\n",
    });
    for (name, value) in &program.constants {
        let _ = writeln!(out, "const {} {name} = {value};", value.ty());
    }
    for variable in program.variables.iter().filter(|v| v.module.is_none()) {
        let _ = writeln!(out, "global {}", declaration(variable));
    }
    for (index, name) in program.modules.iter().enumerate() {
        let _ = write!(out, "\nmodule {name}\n");
        for variable in program.variables.iter().filter(|v| v.module == Some(index)) {
            let _ = writeln!(out, "  {}", declaration(variable));
        }
        for command in program.commands.iter().filter(|c| c.module == index) {
            let _ = writeln!(out, "  {}", self::command(program, command));
        }
        out.push_str("endmodule\n");
    }
    out.push_str(&synchronisations(program));
    if program.variables.iter().any(|v| v.initial.is_none()) {
        let _ = write!(out, "\ninit {} endinit\n", expression(program, program.initial));
    }
    for (name, e) in &program.labels {
        let _ = write!(out, "\nlabel \"{name}\" = {};\n", expression(program, *e));
    }
    out
}

fn declaration(variable: &Variable) -> String {
    let range = match variable.ty {
        Type::Bool => "bool".to_owned(),
        _ => format!("[{}..{}]", variable.low, variable.high),
    };
    let initial = variable.initial.map(|v| format!(" init {}", variable.show(v)));
    format!("{}: {range}{};", variable.name, initial.unwrap_or_default())
}

fn command(program: &Program, command: &Command) -> String {
    let action = command.action.map_or("", |a| program.actions[a].as_str());
    let branch = |b: &Branch| self::branch(program, b, command.branches.len() == 1);
    let branches: Vec<String> = command.branches.iter().map(branch).collect();
    format!("[{action}] {} -> {};", expression(program, command.guard), branches.join(" + "))
}

fn branch(program: &Program, branch: &Branch, only: bool) -> String {
    let update = |(variable, e): &(crate::model::VarId, ExprId)| {
        format!("({}'={})", program.variables[variable.index()].name, expression(program, *e))
    };
    let updates = match branch.updates.as_slice() {
        [] => "true".to_owned(),
        updates => updates.iter().map(update).collect::<Vec<_>>().join(" & "),
    };
    match program.pool.literal(branch.probability) {
        Some(p) if only && p.to_f64() == 1.0 => updates,
        _ => format!("{}: {updates}", expression(program, branch.probability)),
    }
}

/// One comment line for each set of commands that move together.
fn synchronisations(program: &Program) -> String {
    let mut out = String::new();
    for synchronisation in program.synchronisations.iter().filter(|s| s.factors.len() > 1) {
        let action = synchronisation.action.map_or("(hidden)", |a| program.actions[a].as_str());
        let factor = |commands: &Vec<crate::model::CommandId>| {
            let name = |id: &crate::model::CommandId| {
                let command = &program.commands[id.index()];
                format!("{}#{}", program.modules[command.module], command.number)
            };
            commands.iter().map(name).collect::<Vec<_>>().join(" or ")
        };
        let factors: Vec<String> = synchronisation.factors.iter().map(factor).collect();
        let _ = writeln!(out, "// [{action}]: {}", factors.join(" with "));
    }
    if out.is_empty() { out } else { format!("\n// together move\n{out}") }
}

/// An expression with every operation in brackets but the outermost.
pub fn expression(program: &Program, e: ExprId) -> String {
    let mut out = String::new();
    Writer { program, pool: &program.pool }.write(&mut out, e, false);
    out
}

struct Writer<'a> {
    program: &'a Program,
    pool: &'a ExprPool,
}

impl Writer<'_> {
    fn write(&self, out: &mut String, e: ExprId, inner: bool) {
        if out.len() > LONGEST {
            if !out.ends_with('…') {
                out.push('…');
            }
            return;
        }
        match self.pool.node(e) {
            Node::Literal(value) => out.push_str(&literal(value)),
            Node::Var(v) => out.push_str(&self.program.variables[v.index()].name),
            Node::Unary(op, a) => self.unary(out, op, a),
            Node::Binary(op, a, b) => self.binary(out, op, a, b, inner),
            Node::Ite(c, a, b) => self.bracketed(out, inner, |out| {
                self.write(out, c, true);
                out.push_str(" ? ");
                self.write(out, a, true);
                out.push_str(" : ");
                self.write(out, b, true);
            }),
        }
    }

    fn bracketed(&self, out: &mut String, brackets: bool, write: impl FnOnce(&mut String)) {
        if brackets {
            out.push('(');
        }
        write(out);
        if brackets {
            out.push(')');
        }
    }

    fn unary(&self, out: &mut String, op: Unary, a: ExprId) {
        let function = match op {
            Unary::Not => "!",
            Unary::Neg => "-",
            Unary::ToReal => return self.write(out, a, true),
            Unary::Floor => "floor",
            Unary::Ceil => "ceil",
            Unary::Round => "round",
        };
        out.push_str(function);
        let call = function.len() > 1;
        self.bracketed(out, call, |out| self.write(out, a, !call));
    }

    fn binary(&self, out: &mut String, op: Binary, a: ExprId, b: ExprId, inner: bool) {
        let function = match op {
            Binary::Min => "min",
            Binary::Max => "max",
            Binary::Pow => "pow",
            Binary::Mod => "mod",
            Binary::Log => "log",
            _ => {
                return self.bracketed(out, inner, |out| {
                    self.write(out, a, true);
                    out.push_str(infix(op));
                    self.write(out, b, true);
                });
            }
        };
        out.push_str(function);
        self.bracketed(out, true, |out| {
            self.write(out, a, false);
            out.push_str(", ");
            self.write(out, b, false);
        });
    }
}

fn literal(value: Value) -> String {
    let text = value.to_string();
    if text.starts_with('-') { format!("({text})") } else { text }
}

fn infix(op: Binary) -> &'static str {
    match op {
        Binary::And => " & ",
        Binary::Or => " | ",
        Binary::Eq => "=",
        Binary::Lt => "<",
        Binary::Le => "<=",
        Binary::Add => "+",
        Binary::Sub => "-",
        Binary::Mul => "*",
        _ => "/",
    }
}
