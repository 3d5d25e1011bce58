//! Derived facts that depend on each other.

use crate::ground::{Ground, GroundAtom};

/// Derived facts that depend on each other, or one that depends on others only.
pub(crate) struct Component {
    pub(crate) members: Vec<u32>,
    /// True if its members depend on each other.
    pub(crate) is_cycle: bool,
    /// True if a member depends on the negation of a member.
    pub(crate) is_negated: bool,
}

/// Returns the components, those that others depend on first (Tarjan's algorithm).
pub(crate) fn components(derived: &[(GroundAtom, Ground)]) -> Vec<Component> {
    let uses: Vec<Vec<(u32, bool)>> = derived.iter().map(|(_, condition)| used(condition)).collect();
    let mut search = Search {
        uses: &uses,
        number: vec![0; derived.len()],
        low: vec![0; derived.len()],
        ..Search::default()
    };
    for start in 0..derived.len() as u32 {
        if search.number[start as usize] == 0 {
            search.visit(start);
        }
    }
    search.found
}

/// Lists the derived facts of a condition, each with its sign.
fn used(condition: &Ground) -> Vec<(u32, bool)> {
    let (mut open, mut all) = (vec![condition], Vec::new());
    while let Some(condition) = open.pop() {
        match condition {
            Ground::Derived(derived, holds) => all.push((*derived, *holds)),
            Ground::And(parts) | Ground::Or(parts) => open.extend(parts),
            Ground::True | Ground::False | Ground::Fact(..) => {}
        }
    }
    all
}

#[derive(Default)]
struct Search<'u> {
    uses: &'u [Vec<(u32, bool)>],
    /// The order of the first visit, from 1; 0 before it, `u32::MAX` once the component is known.
    number: Vec<u32>,
    low: Vec<u32>,
    visited: u32,
    stack: Vec<u32>,
    found: Vec<Component>,
}

impl Search<'_> {
    /// Visits a fact and all that it depends on, with a stack of its own: chains can be long.
    fn visit(&mut self, start: u32) {
        let mut path: Vec<(u32, usize)> = vec![(start, 0)];
        while let Some(&mut (fact, ref mut next)) = path.last_mut() {
            let at = fact as usize;
            if *next == 0 {
                self.visited += 1;
                (self.number[at], self.low[at]) = (self.visited, self.visited);
                self.stack.push(fact);
            }
            let step = *next;
            *next += 1;
            match self.uses[at].get(step) {
                Some(&(used, _)) if self.number[used as usize] == 0 => path.push((used, 0)),
                Some(&(used, _)) if self.number[used as usize] != u32::MAX => {
                    self.low[at] = self.low[at].min(self.number[used as usize]);
                }
                Some(_) => {}
                None => {
                    path.pop();
                    if let Some(&(above, _)) = path.last() {
                        self.low[above as usize] = self.low[above as usize].min(self.low[at]);
                    }
                    self.close(fact);
                }
            }
        }
    }

    /// Takes the component of a fact off the stack, if the fact is its first one.
    fn close(&mut self, fact: u32) {
        if self.low[fact as usize] != self.number[fact as usize] {
            return;
        }
        let from = self.stack.iter().rposition(|&other| other == fact).unwrap_or_default();
        let members = self.stack.split_off(from);
        let inner = || {
            members.iter().flat_map(|&m| &self.uses[m as usize]).filter(|(used, _)| members.contains(used))
        };
        let (is_cycle, is_negated) = (inner().next().is_some(), inner().any(|(_, holds)| !holds));
        members.iter().for_each(|&member| self.number[member as usize] = u32::MAX);
        self.found.push(Component { members, is_cycle, is_negated });
    }
}
