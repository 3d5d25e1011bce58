//! Systems whose elements are systems, as Storm writes them for compositions of PRISM: they become one system of automata.
//!
//! The results of the vectors of a system are its actions in the vectors around it. In such a model, an action that no
//! vector mentions happens alone, as in PRISM, and the result `""` is silent. A model without inner systems has the
//! meaning of the format instead: there, such an action never happens.

use ahash::AHashMap;

use super::super::json::{Node, Shape};
use super::model::{Automaton, Element, Model, System, Vector};
use super::reader::Reader;
use super::record::Read;
use super::types::Action;
use crate::ast::Ident;
use crate::combinations::{combinations, product};
use meliora_base::stack;

/// Maximum number of vectors of a system without inner systems.
const MOST_VECTORS: usize = 100_000;

/// An element of a system: an automaton, or a system.
#[derive(Debug, Clone)]
pub(crate) enum Part {
    One(Element),
    Several(Box<System>),
}

impl<'a> Read<'a> for Part {
    fn read(reader: &mut Reader<'a>, node: Node<'a>, what: &str) -> Option<Self> {
        match reader.any(node) {
            Some(Shape::Object(object)) if object.get("elements").is_some() => {
                stack::level(|| System::read(reader, node, what)).map(|inner| Part::Several(Box::new(inner)))
            }
            _ => Element::read(reader, node, what).map(Part::One),
        }
    }
}

impl System {
    /// Returns the automata of a system without inner systems.
    pub(crate) fn automata(&self) -> impl Iterator<Item = &Element> {
        self.parts.iter().filter_map(|part| match part {
            Part::One(element) => Some(element),
            Part::Several(_) => None,
        })
    }
}

impl Model {
    /// Replaces a system of systems by that of all automata. Returns `None` after reporting an error.
    pub(super) fn with_flat_system(mut self, reader: &mut Reader<'_>) -> Option<Self> {
        if self.system.parts.iter().all(|part| matches!(part, Part::One(_))) {
            return Some(self);
        }
        let actions = |automaton: &Automaton| {
            let mut own: Vec<Ident> = Vec::new();
            for action in automaton.edges.iter().filter_map(|edge| edge.action.as_ref()) {
                if own.iter().all(|known| known.name != action.name) {
                    own.push(action.clone());
                }
            }
            (automaton.name.name.clone(), own)
        };
        let actions = self.automata.iter().map(actions).collect();
        let Flat { elements, vectors } = Flat::of(&self.system, &actions, reader)?;
        (self.system.parts, self.system.vectors) =
            (elements.into_iter().map(Part::One).collect(), Some(vectors));
        Some(self)
    }
}

/// A system of automata, or one automaton, with a vector for each of its moves.
struct Flat {
    elements: Vec<Element>,
    vectors: Vec<Vector>,
}

impl Flat {
    /// Returns the system of all automata of a system. `actions` are those of the automata.
    fn of(system: &System, actions: &AHashMap<String, Vec<Ident>>, reader: &mut Reader<'_>) -> Option<Self> {
        let parts: Vec<Flat> = system
            .parts
            .iter()
            .map(|part| match part {
                Part::One(element) => Some(Flat::alone(element, actions)),
                Part::Several(inner) => stack::level(|| Flat::of(inner, actions, reader)),
            })
            .collect::<Option<_>>()?;
        let given = system.vectors.as_deref().unwrap_or_default();
        let mut vectors = Vec::new();
        for Vector { actions, result, span } in given {
            if actions.len() != parts.len() {
                let (has, needs) = (actions.len(), parts.len());
                let message = format!("this vector has {has} places, but the system has {needs} elements");
                return reader.fail(*span, message);
            }
            let ways: Vec<Vec<Vec<Action>>> =
                parts.iter().zip(actions).map(|(part, action)| part.ways(action)).collect();
            if product(&ways).saturating_add(vectors.len()) > MOST_VECTORS {
                let message = format!("the systems inside have more than {MOST_VECTORS} vectors together");
                return reader.fail(*span, message);
            }
            for way in combinations(ways.iter().map(|own| own.iter().collect())) {
                let actions = way.into_iter().flatten().cloned().collect();
                vectors.push(Vector { actions, result: result.clone(), span: *span });
            }
        }
        let total: usize = parts.iter().map(|part| part.elements.len()).sum();
        let mut before = 0;
        for (at, part) in parts.iter().enumerate() {
            let is_named = |name: &Ident| {
                given.iter().any(|v| v.actions[at].0.as_ref().is_some_and(|own| own.name == name.name))
            };
            // Silent moves, and those of actions that no vector mentions, take place alone.
            for vector in part.vectors.iter().filter(|v| !v.result.0.as_ref().is_some_and(is_named)) {
                let mut actions = vec![Action(None); total];
                actions[before..before + part.elements.len()].clone_from_slice(&vector.actions);
                vectors.push(Vector { actions, ..vector.clone() });
            }
            before += part.elements.len();
        }
        Some(Flat { elements: parts.into_iter().flat_map(|part| part.elements).collect(), vectors })
    }

    /// Returns an automaton with a vector for each of its actions.
    fn alone(element: &Element, actions: &AHashMap<String, Vec<Ident>>) -> Self {
        let own = actions.get(&element.automaton.name).map(Vec::as_slice).unwrap_or_default();
        let vector = |name: &Ident| {
            let action = Action(Some(name.clone()));
            Vector { actions: vec![action.clone()], result: action, span: name.span }
        };
        Flat { elements: vec![element.clone()], vectors: own.iter().map(vector).collect() }
    }

    /// Returns the actions of the automata that are together an action of this part, or none.
    fn ways(&self, action: &Action) -> Vec<Vec<Action>> {
        let Some(name) = &action.0 else { return vec![vec![Action(None); self.elements.len()]] };
        let is_it = |v: &&Vector| v.result.0.as_ref().is_some_and(|result| result.name == name.name);
        self.vectors.iter().filter(is_it).map(|vector| vector.actions.clone()).collect()
    }
}
