//! A flat program as text of the modelling language: what `info --flat` shows.

mod composition;
mod merge;

use std::fmt::Write as _;

use ahash::{AHashMap, AHashSet};

use super::ast::{BinaryOp, Expr, ExprKind, Ident, Span};
use super::names::Names;
use crate::error::Result;
use crate::model::expr::{Binary, ExprId, ExprPool, Node, Unary};
use crate::model::value::{Type, Value};
use crate::model::{Command, ModelKind, Program, Variable};
use composition::Composition;

/// An expression that occurs twice gets a name of its own from this many nodes on.
const LARGE: u64 = 40;
/// Expressions of heights that this divides get names too, so that nothing nests too deeply.
const TALL: u32 = 64;

/// The program as a model file: constants and formulas are put in, renamings carried out, and a
/// `system` block stands at its end where the modules are not composed in full parallel. It reads
/// back as a program with the same states and choices, and but for modules that had to be made one the same
/// names of actions. Locations are the numbers of their values, as a comment says.
///
/// # Errors
/// Modules that the language cannot keep apart have too many commands as one.
pub fn flat(program: &Program) -> Result<String> {
    let program = &merge::merged(program)?;
    let mut text = String::new();
    text.push_str(match program.kind {
        ModelKind::Mdp => "mdp\n",
        ModelKind::Dtmc => "dtmc\n",
    });
    for (name, value) in &program.constants {
        let _ = write!(text, "\nconst {} {name} = {};", value.ty(), literal(*value));
    }
    let (printer, composition) = (Printer::new(program), Composition::of(program));
    printer.shared(&mut text);
    for variable in program.variables.iter().filter(|v| v.module.is_none()) {
        let _ = write!(text, "\nglobal {}", declaration(variable));
    }
    for module in 0..program.modules.len() {
        printer.module(module, &composition, &mut text);
    }
    if let Some(system) = composition.system(program) {
        let _ = writeln!(text, "\n{system}");
    }
    if program.variables.iter().any(|v| v.initial.is_none()) {
        let _ = writeln!(text, "\ninit {} endinit", printer.expr(program.initial));
    }
    let mut names = Names::default();
    for (name, body) in &program.labels {
        let _ = write!(text, "\nlabel \"{}\" = {};", names.add(name), printer.expr(*body));
    }
    text.push('\n');
    Ok(text)
}

fn declaration(variable: &Variable) -> String {
    let range = match variable.ty {
        Type::Bool => "bool".to_owned(),
        _ => format!("[{}..{}]", variable.low, variable.high),
    };
    let show = |value: i64| if variable.ty == Type::Bool { variable.show(value) } else { value.to_string() };
    let init = variable.initial.map_or(String::new(), |value| format!(" init {}", show(value)));
    let names = match variable.values.is_empty() {
        true => String::new(),
        // No line end of a name may end the comment.
        false => format!(" // {}", variable.values.join(", ").escape_debug()),
    };
    format!("{} : {range}{init};{names}", variable.name)
}

/// Writes expressions, with names for those that occur again and again.
struct Printer<'a> {
    program: &'a Program,
    /// Expressions with a name, in the order in which they may be defined.
    names: Vec<(ExprId, String)>,
    by_id: AHashMap<ExprId, String>,
}

impl<'a> Printer<'a> {
    fn new(program: &'a Program) -> Self {
        let mut prefix = "e".to_owned();
        let taken = |p: &str| {
            let names =
                program.variables.iter().map(|v| &v.name).chain(program.constants.iter().map(|c| &c.0));
            names.into_iter().any(|n| n.starts_with(p))
        };
        while taken(&format!("{prefix}_")) {
            prefix.push('e');
        }
        let names: Vec<_> = shared_nodes(&program.pool, &roots(program))
            .into_iter()
            .enumerate()
            .map(|(i, id)| (id, format!("{prefix}_{i}")))
            .collect();
        let by_id = names.iter().cloned().collect();
        Printer { program, names, by_id }
    }

    fn shared(&self, text: &mut String) {
        for (id, name) in &self.names {
            let _ = write!(text, "\nformula {name} = {};", self.body(*id));
        }
        text.push('\n');
    }

    fn module(&self, module: usize, composition: &Composition, text: &mut String) {
        let _ = writeln!(text, "\nmodule {}", self.program.modules[module]);
        for variable in self.program.variables.iter().filter(|v| v.module == Some(module)) {
            let _ = writeln!(text, "    {}", declaration(variable));
        }
        for (index, command) in self.program.commands.iter().enumerate() {
            let labels = if command.module == module { composition.labels(index) } else { &[] };
            for label in labels {
                let _ = writeln!(text, "    {}", self.command(command, label));
            }
        }
        text.push_str("endmodule\n");
    }

    fn command(&self, command: &Command, label: &str) -> String {
        let mut text = format!("[{label}] {} -> ", self.expr(command.guard));
        for (i, branch) in command.branches.iter().enumerate() {
            let plus = if i > 0 { " + " } else { "" };
            let _ = write!(text, "{plus}{} : ", self.expr(branch.probability));
            if branch.updates.is_empty() {
                text.push_str("true");
            }
            for (j, (variable, value)) in branch.updates.iter().enumerate() {
                let and = if j > 0 { " & " } else { "" };
                let name = &self.program.variables[variable.index()].name;
                let _ = write!(text, "{and}({name}' = {})", self.expr(*value));
            }
        }
        text.push(';');
        text
    }

    /// An expression, by its name if it has one.
    fn expr(&self, id: ExprId) -> Expr {
        match self.by_id.get(&id) {
            Some(name) => at(ExprKind::Name(name.clone())),
            None => self.body(id),
        }
    }

    fn body(&self, id: ExprId) -> Expr {
        match self.program.pool.node(id) {
            Node::Literal(value) => literal(value),
            Node::Var(v) => at(ExprKind::Name(self.program.variables[v.index()].name.clone())),
            Node::Unary(op, a) => self.unary(op, a),
            Node::Binary(op, a, b) => self.binary(op, a, b),
            Node::Ite(c, a, b) => {
                at(ExprKind::Ite(vec![(self.expr(c), self.expr(a))], Box::new(self.expr(b))))
            }
        }
    }

    fn unary(&self, op: Unary, a: ExprId) -> Expr {
        let a = self.expr(a);
        match op {
            Unary::Not => at(ExprKind::Not(Box::new(a))),
            Unary::Neg => at(ExprKind::Neg(Box::new(a))),
            // Integers become real by themselves where a real is wanted.
            Unary::ToReal => a,
            Unary::Floor => call("floor", vec![a]),
            Unary::Ceil => call("ceil", vec![a]),
            Unary::Round => call("round", vec![a]),
        }
    }

    fn binary(&self, op: Binary, a: ExprId, b: ExprId) -> Expr {
        let (a, b) = (self.expr(a), self.expr(b));
        let op = match op {
            Binary::And => BinaryOp::And,
            Binary::Or => BinaryOp::Or,
            Binary::Eq => BinaryOp::Eq,
            Binary::Lt => BinaryOp::Lt,
            Binary::Le => BinaryOp::Le,
            Binary::Add => BinaryOp::Add,
            Binary::Sub => BinaryOp::Sub,
            Binary::Mul => BinaryOp::Mul,
            Binary::Div => BinaryOp::Div,
            Binary::Min => return call("min", vec![a, b]),
            Binary::Max => return call("max", vec![a, b]),
            Binary::Pow => return call("pow", vec![a, b]),
            Binary::Mod => return call("mod", vec![a, b]),
            Binary::Log => return call("log", vec![a, b]),
        };
        join(a, op, b)
    }
}

/// `a op b`; rows of one associative operator are written without brackets.
fn join(a: Expr, op: BinaryOp, b: Expr) -> Expr {
    let associative = matches!(op, BinaryOp::And | BinaryOp::Or);
    let flatten = |e: Expr| match e.kind {
        ExprKind::Chain(first, rest) if associative && rest.iter().all(|(o, _)| *o == op) => (*first, rest),
        kind => (at(kind), Vec::new()),
    };
    let (first, mut rest) = flatten(a);
    let (second, more) = flatten(b);
    rest.push((op, second));
    rest.extend(more);
    at(ExprKind::Chain(Box::new(first), rest))
}

fn at(kind: ExprKind) -> Expr {
    Expr { kind, span: Span::default() }
}

fn call(name: &str, arguments: Vec<Expr>) -> Expr {
    at(ExprKind::Call(Box::new(Ident { name: name.to_owned(), span: Span::default() }), arguments))
}

fn literal(value: Value) -> Expr {
    let negative = |e: ExprKind| at(ExprKind::Neg(Box::new(at(e))));
    match value {
        Value::Bool(b) => at(ExprKind::Bool(b)),
        Value::Int(i) if i < 0 => negative(ExprKind::Int(i.checked_neg().unwrap_or(i64::MAX))),
        Value::Int(i) => at(ExprKind::Int(i)),
        Value::Real(x) if !x.is_finite() => {
            let over = if x.is_nan() { 0 } else { 1 };
            let quotient = join(at(ExprKind::Int(over)), BinaryOp::Div, at(ExprKind::Int(0)));
            if x < 0.0 { negative(quotient.kind) } else { quotient }
        }
        Value::Real(x) if x.is_sign_negative() => negative(ExprKind::Real(-x)),
        Value::Real(x) => at(ExprKind::Real(x)),
    }
}

/// All expressions that the text shows.
fn roots(program: &Program) -> Vec<ExprId> {
    let mut roots = vec![program.initial];
    for command in &program.commands {
        roots.push(command.guard);
        for branch in &command.branches {
            roots.push(branch.probability);
            roots.extend(branch.updates.iter().map(|u| u.1));
        }
    }
    roots.extend(program.labels.iter().map(|l| l.1));
    roots
}

/// Expressions that get names: large ones that occur more than once, and some of the tall ones.
fn shared_nodes(pool: &ExprPool, roots: &[ExprId]) -> Vec<ExprId> {
    let mut uses: AHashMap<ExprId, u32> = AHashMap::new();
    let (mut pending, mut seen) = (roots.to_vec(), AHashSet::new());
    let mut reachable = Vec::new();
    while let Some(id) = pending.pop() {
        *uses.entry(id).or_default() += 1;
        if seen.insert(id) {
            reachable.push(id);
            pending.extend(operands(pool, id));
        }
    }
    // Operands come before the nodes that use them.
    reachable.sort_unstable();
    let mut sizes: AHashMap<ExprId, (u64, u32)> = AHashMap::new();
    let mut shared = Vec::new();
    for id in reachable {
        let (mut size, mut height) = (1u64, 0u32);
        for (s, h) in operands(pool, id).iter().filter_map(|o| sizes.get(o)) {
            (size, height) = (size.saturating_add(*s), height.max(h + 1));
        }
        let tall = height > 0 && height.is_multiple_of(TALL);
        if tall || (uses[&id] > 1 && size >= LARGE) {
            shared.push(id);
            size = 1;
        }
        sizes.insert(id, (size, height));
    }
    shared
}

fn operands(pool: &ExprPool, id: ExprId) -> Vec<ExprId> {
    match pool.node(id) {
        Node::Literal(_) | Node::Var(_) => Vec::new(),
        Node::Unary(_, a) => vec![a],
        Node::Binary(_, a, b) => vec![a, b],
        Node::Ite(c, a, b) => vec![c, a, b],
    }
}
