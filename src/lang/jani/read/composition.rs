//! Systems whose elements are systems, as Storm writes them: they become one system of automata.
//!
//! The results of the vectors of an inner system are its actions in the vectors around it. Its vectors without a result are
//! silent there, and take place alone.

use super::super::json::{Node, Shape};
use super::model::{Element, System, Vector};
use super::reader::Reader;
use super::record::Read;
use super::types::Action;
use crate::combinations::{combinations, product};
use crate::jani::read::record::records;
use meliora_base::stack;

/// Maximum number of vectors of a system without inner systems.
const MOST_VECTORS: usize = 100_000;

records! {
    Composition = "the system" {
        "elements" => parts: Vec<Part>,
        "syncs" => vectors: Option<Vec<Vector>> = None,
    }
    at span;
}

/// An element of a system, or a system in the place of one.
#[derive(Debug, Clone)]
pub(crate) enum Part {
    One(Element),
    Several(System),
}

impl<'a> Read<'a> for Part {
    fn read(reader: &mut Reader<'a>, node: Node<'a>, what: &str) -> Option<Self> {
        match reader.any(node) {
            Some(Shape::Object(object)) if object.get("elements").is_some() => {
                stack::level(|| System::read(reader, node, what)).map(Part::Several)
            }
            _ => Element::read(reader, node, what).map(Part::One),
        }
    }
}

impl<'a> Read<'a> for System {
    fn read(reader: &mut Reader<'a>, node: Node<'a>, what: &str) -> Option<Self> {
        Composition::read(reader, node, what)?.flat(reader)
    }
}

impl Part {
    /// Returns the number of automata.
    fn size(&self) -> usize {
        match self {
            Part::One(_) => 1,
            Part::Several(system) => system.elements.len(),
        }
    }

    /// Returns the actions of its automata that are together an action of this part, or none.
    fn ways(&self, action: &Action) -> Vec<Vec<Action>> {
        let Part::Several(System { elements, vectors, .. }) = self else { return vec![vec![action.clone()]] };
        match (action, vectors) {
            (Action(None), _) => vec![vec![Action(None); elements.len()]],
            // The actions of one automaton need no vector.
            (_, None) if elements.len() == 1 => vec![vec![action.clone()]],
            (_, None) => Vec::new(),
            (Action(Some(name)), Some(vectors)) => {
                let is_it = |v: &&Vector| v.result.0.as_ref().is_some_and(|result| result.name == name.name);
                vectors.iter().filter(is_it).map(|v| v.actions.clone()).collect()
            }
        }
    }
}

impl Composition {
    /// Returns the system of all automata.
    fn flat(self, reader: &mut Reader<'_>) -> Option<System> {
        let Composition { parts, vectors, span } = self;
        if let ([Part::Several(only)], None) = (&parts[..], &vectors) {
            return Some(only.clone());
        }
        let is_nested = parts.iter().any(|part| matches!(part, Part::Several(_)));
        let vectors = if is_nested {
            Some(flat_vectors(reader, &parts, vectors.unwrap_or_default())?)
        } else {
            vectors
        };
        let elements = parts.into_iter().flat_map(|part| match part {
            Part::One(element) => vec![element],
            Part::Several(system) => system.elements,
        });
        Some(System { elements: elements.collect(), vectors, span })
    }
}

/// Returns the vectors over all automata: those of the outer system, and the silent ones of the inner systems.
fn flat_vectors(reader: &mut Reader<'_>, parts: &[Part], outer: Vec<Vector>) -> Option<Vec<Vector>> {
    let mut all = Vec::new();
    for Vector { actions, result, span } in outer {
        if actions.len() != parts.len() {
            let (has, needs) = (actions.len(), parts.len());
            let message = format!("this vector has {has} places, but the system has {needs} elements");
            return reader.fail(span, message);
        }
        let ways: Vec<Vec<Vec<Action>>> = parts.iter().zip(&actions).map(|(part, a)| part.ways(a)).collect();
        if product(&ways).saturating_add(all.len()) > MOST_VECTORS {
            return reader
                .fail(span, format!("the systems inside have more than {MOST_VECTORS} vectors together"));
        }
        let ways = ways.iter().map(|own| own.iter().collect());
        let joined = combinations(ways).into_iter().map(|way| way.into_iter().flatten().cloned().collect());
        all.extend(joined.map(|actions| Vector { actions, result: result.clone(), span }));
    }
    let total: usize = parts.iter().map(Part::size).sum();
    let mut before = 0;
    for part in parts {
        if let Part::Several(System { vectors: Some(vectors), .. }) = part {
            for vector in vectors.iter().filter(|vector| vector.result.0.is_none()) {
                let mut actions = vec![Action(None); total];
                actions[before..before + part.size()].clone_from_slice(&vector.actions);
                all.push(Vector { actions, ..vector.clone() });
            }
        }
        before += part.size();
    }
    Some(all)
}
