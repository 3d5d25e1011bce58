//! A flat program as a JANI document: one automaton per module, one vector per synchronisation.

use meliora::model::expr::{Binary, ExprId, ExprPool, Node, Unary};
use meliora::model::value::{Type, Value};
use meliora::model::{Branch, Command, ModelKind, Program};
use serde_json::{Value as Json, json};

/// The document. Every factor of every synchronisation gets an action of its own.
pub(crate) fn document(program: &Program) -> Json {
    let mut actions = Vec::new();
    let mut vectors = Vec::new();
    // The edges of each module: command and action.
    let mut edges: Vec<Vec<Json>> = vec![Vec::new(); program.modules.len()];
    for (index, synchronisation) in program.synchronisations.iter().enumerate() {
        let mut places = vec![Json::Null; program.modules.len()];
        for factor in &synchronisation.factors {
            let module = program.commands[factor[0].index()].module;
            let action = synchronisation.action.map(|_| format!("s{index}_{module}"));
            for id in factor {
                edges[module].push(edge(program, &program.commands[id.index()], action.as_deref()));
            }
            if let Some(action) = action {
                actions.push(json!({"name": action.clone()}));
                places[module] = Json::from(action);
            }
        }
        if let Some(action) = synchronisation.action {
            vectors.push(json!({"synchronise": places, "result": program.actions[action]}));
        }
    }
    actions.extend(program.actions.iter().map(|a| json!({"name": a})));
    let automaton = |(module, edges): (usize, Vec<Json>)| {
        json!({"name": program.modules[module], "locations": [{"name": "here"}],
               "initial-locations": ["here"], "edges": edges})
    };
    json!({
        "jani-version": 1, "name": "random", "type": if program.kind == ModelKind::Dtmc { "dtmc" } else { "mdp" },
        "actions": actions,
        "variables": program.variables.iter().map(variable).collect::<Vec<_>>(),
        "restrict-initial": {"exp": expr(program, program.initial)},
        "properties": [],
        "automata": edges.into_iter().enumerate().map(automaton).collect::<Vec<_>>(),
        "system": {"elements": program.modules.iter().map(|m| json!({"automaton": m})).collect::<Vec<_>>(),
                   "syncs": vectors}
    })
}

fn variable(v: &meliora::model::Variable) -> Json {
    let ty = match v.ty {
        Type::Bool => json!("bool"),
        _ => json!({"kind": "bounded", "base": "int", "lower-bound": v.low, "upper-bound": v.high}),
    };
    json!({"name": v.name, "type": ty})
}

fn edge(program: &Program, command: &Command, action: Option<&str>) -> Json {
    let destinations: Vec<Json> = command.branches.iter().map(|b| destination(program, b)).collect();
    let mut edge = json!({"location": "here", "guard": {"exp": expr(program, command.guard)},
                          "destinations": destinations});
    if let Some(action) = action {
        edge["action"] = Json::from(action);
    }
    edge
}

fn destination(program: &Program, branch: &Branch) -> Json {
    let assignment = |(v, e): &(meliora::model::VarId, ExprId)| json!({"ref": program.variables[v.index()].name, "value": expr(program, *e)});
    json!({"location": "here", "probability": {"exp": expr(program, branch.probability)},
           "assignments": branch.updates.iter().map(assignment).collect::<Vec<_>>()})
}

/// An expression.
pub(crate) fn expr(program: &Program, id: ExprId) -> Json {
    let pool: &ExprPool = &program.pool;
    let of = |id| expr(program, id);
    match pool.node(id) {
        Node::Literal(Value::Bool(b)) => json!(b),
        Node::Literal(Value::Int(i)) => json!(i),
        Node::Literal(Value::Real(x)) => json!(x),
        Node::Var(v) => json!(program.variables[v.index()].name),
        Node::Unary(Unary::Not, a) => json!({"op": "¬", "exp": of(a)}),
        Node::Unary(Unary::Neg, a) => json!({"op": "-", "left": 0, "right": of(a)}),
        Node::Unary(Unary::Floor, a) => json!({"op": "floor", "exp": of(a)}),
        Node::Unary(Unary::Ceil, a) => json!({"op": "ceil", "exp": of(a)}),
        Node::Unary(Unary::ToReal, a) => of(a),
        Node::Unary(Unary::Round, _) => unreachable!("the format has no rounding"),
        Node::Binary(op, a, b) => json!({"op": symbol(op), "left": of(a), "right": of(b)}),
        Node::Ite(c, a, b) => json!({"op": "ite", "if": of(c), "then": of(a), "else": of(b)}),
    }
}

fn symbol(op: Binary) -> &'static str {
    match op {
        Binary::And => "∧",
        Binary::Or => "∨",
        Binary::Eq => "=",
        Binary::Lt => "<",
        Binary::Le => "≤",
        Binary::Add => "+",
        Binary::Sub => "-",
        Binary::Mul => "*",
        Binary::Div => "/",
        Binary::Min => "min",
        Binary::Max => "max",
        Binary::Pow => "pow",
        Binary::Mod => "%",
        Binary::Log => "log",
        Binary::Index => unreachable!("only arrays of the format have an index"),
    }
}
