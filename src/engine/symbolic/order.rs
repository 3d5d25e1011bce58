//! The order of the bits: declared, computed from the structure of the program, or the user's.

use std::ops::Range;
use std::sync::Arc;

use ahash::{AHashMap, AHashSet};

use super::encoding::Bit;
use crate::error::{Diagnostic, Result, SourceFile};
use crate::model::expr::{Binary, ExprId, Node};
use crate::model::value::Type;
use crate::model::{Program, VarId};

/// The variables in the order of declaration, each from its most significant bit down.
pub fn declared(program: &Program) -> Vec<Bit> {
    let variables: Vec<VarId> = (0..program.variables.len() as u32).map(VarId).collect();
    by_variables(program, &variables)
}

/// The bits of the variables in the given order, each from its most significant bit down.
pub fn by_variables(program: &Program, variables: &[VarId]) -> Vec<Bit> {
    let bits = |&variable: &VarId| {
        let count = program.variables[variable.index()].bits();
        (0..count).rev().map(move |index| Bit { variable, index })
    };
    variables.iter().flat_map(bits).collect()
}

/// An order from the structure of the program: modules that interact next to each other, in each
/// module flags up and threshold counters down, positions between them.
///
/// Modules keep their variables together. A chain of modules is laid out by moving each to the
/// mean place of its partners until the total distance of partners stops falling (the FORCE
/// heuristic of Aloul, Markov and Sakallah, on modules instead of variables).
pub fn auto(program: &Program) -> Vec<Bit> {
    let mut places: Vec<usize> = (0..blocks(program).len()).collect();
    let edges = interactions(program);
    let mut best = (span(&edges, &places), places.clone());
    for _ in 0..20 {
        places = moved(&edges, &places);
        let cost = span(&edges, &places);
        if cost >= best.0 {
            break;
        }
        best = (cost, places.clone());
    }
    let mut order: Vec<usize> = (0..best.1.len()).collect();
    order.sort_by_key(|&b| best.1[b]);
    let blocks = blocks(program);
    let counters = thresholds(program);
    let variables: Vec<VarId> =
        order.iter().flat_map(|&b| arranged(program, &blocks[b], &counters)).collect();
    by_variables(program, &variables)
}

/// The variables of each module, and each global by itself, in the order of declaration.
fn blocks(program: &Program) -> Vec<Vec<VarId>> {
    let mut blocks: Vec<Vec<VarId>> = Vec::new();
    let mut of_module: AHashMap<usize, usize> = AHashMap::new();
    for (index, variable) in program.variables.iter().enumerate() {
        let id = VarId(index as u32);
        match variable.module {
            None => blocks.push(vec![id]),
            Some(module) => {
                let block = *of_module.entry(module).or_insert_with(|| {
                    blocks.push(Vec::new());
                    blocks.len() - 1
                });
                blocks[block].push(id);
            }
        }
    }
    blocks
}

/// For each command the blocks that it reads or writes, if there are several.
fn interactions(program: &Program) -> Vec<Vec<usize>> {
    let mut block_of = AHashMap::new();
    for (index, block) in blocks(program).iter().enumerate() {
        block_of.extend(block.iter().map(|&v| (v, index)));
    }
    let mut edges: Vec<Vec<usize>> = Vec::new();
    for command in &program.commands {
        let mut touched = AHashSet::new();
        for e in expressions(command) {
            touched.extend(program.pool.support(e).iter().map(|v| block_of[v]));
        }
        let written = command.branches.iter().flat_map(|b| &b.updates);
        touched.extend(written.map(|(v, _)| block_of[v]));
        let mut edge: Vec<usize> = touched.into_iter().collect();
        edge.sort_unstable();
        if edge.len() > 1 {
            edges.push(edge);
        }
    }
    edges
}

fn expressions(command: &crate::model::Command) -> Vec<ExprId> {
    let mut all = vec![command.guard];
    for branch in &command.branches {
        all.push(branch.probability);
        all.extend(branch.updates.iter().map(|(_, e)| *e));
    }
    all
}

/// The sum of the distances between the first and the last block of each edge.
fn span(edges: &[Vec<usize>], places: &[usize]) -> usize {
    let length = |edge: &Vec<usize>| {
        let at = || edge.iter().map(|&b| places[b]);
        at().max().unwrap_or(0) - at().min().unwrap_or(0)
    };
    edges.iter().map(length).sum()
}

/// Every block at the mean of the centres of its edges.
fn moved(edges: &[Vec<usize>], places: &[usize]) -> Vec<usize> {
    let mut pull = vec![(0.0, 0usize); places.len()];
    for edge in edges {
        let centre = edge.iter().map(|&b| places[b] as f64).sum::<f64>() / edge.len() as f64;
        for &block in edge {
            pull[block] = (pull[block].0 + centre, pull[block].1 + 1);
        }
    }
    let wanted = |b: usize| if pull[b].1 == 0 { places[b] as f64 } else { pull[b].0 / pull[b].1 as f64 };
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by(|&a, &b| wanted(a).total_cmp(&wanted(b)).then(places[a].cmp(&places[b])));
    let mut next = vec![0; places.len()];
    for (place, block) in order.into_iter().enumerate() {
        next[block] = place;
    }
    next
}

/// Flags first, then what is no counter, then threshold counters.
fn arranged(program: &Program, block: &[VarId], counters: &AHashSet<VarId>) -> Vec<VarId> {
    let rank = |v: &VarId| match program.variables[v.index()].bits() {
        0 | 1 => 0,
        _ if counters.contains(v) => 2,
        _ => 1,
    };
    let mut sorted = block.to_vec();
    sorted.sort_by_key(rank);
    sorted
}

/// Integers that are changed by sums and compared by `<` and `<=` with constants only.
fn thresholds(program: &Program) -> AHashSet<VarId> {
    let mut counters: AHashSet<VarId> = AHashSet::new();
    for command in &program.commands {
        for (variable, e) in command.branches.iter().flat_map(|b| &b.updates) {
            if counts(program, *variable, *e) {
                counters.insert(*variable);
            }
        }
    }
    counters.retain(|v| program.variables[v.index()].ty == Type::Int);
    for command in &program.commands {
        let mut stack = vec![command.guard];
        let mut seen = AHashSet::new();
        while let Some(e) = stack.pop() {
            if !seen.insert(e) {
                continue;
            }
            match program.pool.node(e) {
                Node::Binary(Binary::Eq, a, b) if is_inner(program, a, b) => {
                    for v in program.pool.support(e) {
                        counters.remove(&v);
                    }
                }
                Node::Binary(_, a, b) => stack.extend([a, b]),
                Node::Unary(_, a) => stack.push(a),
                Node::Ite(c, a, b) => stack.extend([c, a, b]),
                Node::Literal(_) | Node::Var(_) => {}
            }
        }
    }
    counters
}

/// Whether the expression has a sum or difference of the variable itself.
fn counts(program: &Program, variable: VarId, e: ExprId) -> bool {
    let (mut stack, mut seen) = (vec![e], AHashSet::new());
    while let Some(e) = stack.pop() {
        if !seen.insert(e) {
            continue;
        }
        match program.pool.node(e) {
            Node::Binary(Binary::Add | Binary::Sub, a, b)
                if [a, b].iter().any(|&o| program.pool.node(o) == Node::Var(variable)) =>
            {
                return true;
            }
            Node::Binary(_, a, b) => stack.extend([a, b]),
            Node::Unary(_, a) => stack.push(a),
            Node::Ite(c, a, b) => stack.extend([c, a, b]),
            Node::Literal(_) | Node::Var(_) => {}
        }
    }
    false
}

/// Whether an equation tests a variable for a value inside its range, or two variables with each
/// other: that is not how a counter is used.
fn is_inner(program: &Program, a: ExprId, b: ExprId) -> bool {
    let end = |v: ExprId, c: ExprId| match (program.pool.node(v), program.pool.literal(c)) {
        (Node::Var(v), Some(c)) => {
            let variable = &program.variables[v.index()];
            c.to_f64() == variable.low as f64 || c.to_f64() == variable.high as f64
        }
        _ => false,
    };
    !end(a, b) && !end(b, a)
}

/// An order from text: names of variables or of bits (`x.2`), separated by white space or commas,
/// `//` comments as in models. Every variable must be there, once.
///
/// # Errors
/// Unknown, doubled and missing names, each with its place.
pub fn parse(program: &Program, source: &Arc<SourceFile>) -> Result<Vec<Bit>> {
    let mut order: Vec<Bit> = Vec::new();
    let mut seen: AHashSet<Bit> = AHashSet::new();
    let mut errors = Vec::new();
    for (span, name) in words(&source.text) {
        match named(program, name) {
            None => errors.push(wrong(source, span, format!("`{name}` is no variable or bit of the model"))),
            Some(bits) => {
                for bit in bits {
                    if seen.insert(bit) {
                        order.push(bit);
                    } else {
                        errors.push(wrong(source, span.clone(), format!("`{name}` is in the order twice")));
                        break;
                    }
                }
            }
        }
    }
    let missing: Vec<Bit> = declared(program).into_iter().filter(|b| !seen.contains(b)).collect();
    if let (Some(first), true) = (missing.first(), errors.is_empty()) {
        let name = &program.variables[first.variable.index()].name;
        let end = source.text.len();
        errors.push(wrong(source, end..end, format!("bit {} of `{name}` is not in the order", first.index)));
    }
    if errors.is_empty() { Ok(order) } else { Err(crate::error::Error::Input(errors)) }
}

/// The bits that a word names: all of a variable, or one.
fn named(program: &Program, name: &str) -> Option<Vec<Bit>> {
    if let Some(variable) = program.variable(name) {
        return Some(by_variables(program, &[variable]));
    }
    let (variable, index) = name.rsplit_once('.')?;
    let (variable, index) = (program.variable(variable)?, index.parse().ok()?);
    (index < program.variables[variable.index()].bits()).then(|| vec![Bit { variable, index }])
}

fn words(text: &str) -> Vec<(Range<usize>, &str)> {
    let mut words = Vec::new();
    let mut offset = 0;
    for line in text.split_inclusive('\n') {
        let code = line.split("//").next().unwrap_or_default();
        let separator = |c: char| c.is_whitespace() || c == ',';
        for word in code.split(separator).filter(|w| !w.is_empty()) {
            let start = offset + (word.as_ptr() as usize - line.as_ptr() as usize);
            words.push((start..start + word.len(), word));
        }
        offset += line.len();
    }
    words
}

fn wrong(source: &Arc<SourceFile>, span: Range<usize>, message: String) -> Diagnostic {
    let help = "`meliora info MODEL` prints an order in this format".to_owned();
    Diagnostic { help: Some(help), ..Diagnostic::new(source, span, message) }
}
