//! The states that paths of a model may visit, listed one by one, with the objectives that are sure in them.

use ahash::AHashMap;

use super::graph::{Graph, Set};
use meliora_base::error::{Error, Limit, Result};
use meliora_base::exact::Ratio;
use meliora_base::progress::{Poll, ProgressSink};
use meliora_base::value::Value;
use meliora_model::predicate::Predicate;
use meliora_model::preference::{Goal, ObjectiveSet, Preferences};
use meliora_model::step::Step;
use meliora_model::temporal::{Asks, Condition, Disjunct};
use meliora_model::{Program, State, fault};

/// Maximum number of states that a check of a policy lists: each takes about as much memory as a line of text.
pub(super) const MOST_STATES: usize = 4_000_000;

/// The states that are reachable from some states, whoever chooses.
pub(super) struct Space<'p> {
    program: &'p Program,
    pub(super) graph: Graph<'p>,
    states: Vec<State>,
    number: AHashMap<State, usize>,
}

/// Returns the steps of a state, with exact probabilities, and whether the opponent chooses there.
pub(super) fn steps(program: &Program, state: &[i64]) -> Result<(Vec<Step<Ratio>>, bool)> {
    let steps = program.exact_steps(state).map_err(|f| fault::error(program, &f, state))?;
    let player = steps.first().and_then(|step| program.player_of_choice(&step.choice));
    let ours = player.zip(program.players.as_ref()).is_none_or(|(player, all)| all.list[player].ours);
    Ok((steps, !ours))
}

/// Returns whether a condition is true in a state.
pub(super) fn holds(program: &Program, condition: &Predicate, state: &[i64]) -> Result<bool> {
    match condition.eval(state) {
        Ok(value) => Ok(value == Value::Bool(true)),
        Err(_) => Err(fault::in_predicate(program, condition, state)),
    }
}

impl<'p> Space<'p> {
    /// Lists the states that are reachable from some states.
    ///
    /// # Errors
    /// A limit; a command has no meaning in a state.
    pub(super) fn explore<'n>(
        program: &'p Program,
        starts: impl Iterator<Item = &'n State>,
        sink: &'p dyn ProgressSink,
    ) -> Result<Self> {
        let (graph, states, number) = (Graph::new(sink), Vec::new(), AHashMap::new());
        let mut space = Space { program, graph, states, number };
        for state in starts {
            space.enter(state)?;
        }
        let mut poll = Poll::new(sink);
        while space.graph.len() < space.states.len() {
            poll.step()?;
            let (steps, theirs) = steps(program, &space.states[space.graph.len()])?;
            let mut choices = Vec::with_capacity(steps.len());
            for step in steps {
                let to = step.successors.iter().map(|(state, _)| space.enter(state));
                choices.push(to.collect::<Result<Vec<_>>>()?);
            }
            space.graph.add(theirs, choices);
        }
        Ok(space)
    }

    fn enter(&mut self, state: &State) -> Result<usize> {
        if let Some(&known) = self.number.get(state) {
            return Ok(known);
        }
        let new = self.states.len();
        if new == MOST_STATES {
            let what = format!(
                "more than {MOST_STATES} states are reachable, and the check of a policy lists all of them"
            );
            return Err(Limit::Size { what }.into());
        }
        self.number.insert(state.clone(), new);
        self.states.push(state.clone());
        Ok(new)
    }

    fn mask(&self, condition: &Predicate) -> Result<Set> {
        self.states.iter().map(|state| holds(self.program, condition, state)).collect()
    }

    /// Leaves only the states from which we keep all requirements, and the choices that stay in them; returns these
    /// states.
    pub(super) fn require(&mut self, preferences: &Preferences) -> Result<Set> {
        let mut kept = vec![true; self.states.len()];
        for requirement in &preferences.requirements {
            let own = self.mask(&requirement.kept)?;
            kept.iter_mut().zip(own).for_each(|(kept, own)| *kept &= own);
        }
        let kept = self.graph.staying(kept)?;
        self.graph.restrict(&kept);
        Ok(kept)
    }

    /// Returns MP(s) of some states, among those that are left.
    pub(super) fn most_preferred(
        &self,
        preferences: &Preferences,
        states: &[usize],
    ) -> Result<Vec<ObjectiveSet>> {
        let mut sure = vec![ObjectiveSet::new(); states.len()];
        for (number, objective) in preferences.objectives.iter().enumerate() {
            let own = self.sure(&objective.goal)?;
            for (set, &state) in sure.iter_mut().zip(states) {
                if own[state] {
                    set.insert(number);
                }
            }
        }
        Ok(sure.iter().map(|set| preferences.most_preferred(set)).collect())
    }

    pub(super) fn number(&self, state: &State) -> Option<usize> {
        self.number.get(state).copied()
    }

    /// Returns the states from which we achieve a goal almost surely, against every opponent.
    fn sure(&self, goal: &Goal) -> Result<Set> {
        match goal {
            Goal::Reach(target) => Ok(self.graph.almost_surely(&self.mask(target)?)?),
            Goal::Satisfy { condition, .. } if self.graph.is_game() => self.won(condition),
            Goal::Satisfy { condition, .. } => {
                let mut secured = vec![false; self.states.len()];
                for disjunct in &self.disjuncts(condition)? {
                    let components = self.graph.end_components(&disjunct.always)?;
                    let accepted = components.iter().filter(|own| disjunct.accepts(own));
                    accepted.flatten().for_each(|&state| secured[state] = true);
                }
                Ok(self.graph.almost_surely(&secured)?)
            }
        }
    }

    fn disjuncts(&self, condition: &Condition) -> Result<Vec<Accepting>> {
        disjuncts(condition, self.states.len(), |mark| self.mask(mark))
    }

    /// Returns the states from which we satisfy a condition against an opponent: once the marks of co-safe and safe
    /// formulas do not change any more, one mark is left, which recurs or not.
    fn won(&self, condition: &Condition) -> Result<Set> {
        let marked = match condition.undecided().as_slice() {
            [] => vec![false; self.states.len()],
            [mark] => self.mask(mark)?,
            _ => {
                let message = "a formula of a game that needs several recurring marks is not supported";
                return Err(Error::Usage(message.to_owned()));
            }
        };
        let fixed = |recurs: bool| self.holding(condition, recurs);
        let (if_not, if_recurs) = (fixed(false)?, fixed(true)?);
        let all = 0..self.states.len();
        let again: Set = all.clone().map(|s| if_recurs[s] && (if_not[s] || marked[s])).collect();
        let settled: Set = all.map(|s| if_not[s] && !marked[s]).collect();
        Ok(self.graph.again_or_settled(&again, &settled)?)
    }

    /// Returns the states whose marks satisfy a condition if the marks of recurrence and persistence recur or not.
    fn holding(&self, condition: &Condition, recurs: bool) -> Result<Set> {
        let mut masks = Vec::new();
        for mark in condition.marks() {
            let set = self.mask(&mark)?;
            masks.push((mark, set));
        }
        let marked = |mark: &Predicate, state: usize| {
            masks.iter().find(|(own, _)| own == mark).is_some_and(|(_, set)| set[state])
        };
        let leaf = |state: usize| {
            move |asks: Asks, mark: &Predicate| match asks {
                Asks::Accept => marked(mark, state),
                Asks::Avoid => !marked(mark, state),
                Asks::Again => recurs,
                Asks::Settle => !recurs,
            }
        };
        Ok((0..self.states.len()).map(|state| condition.holds(&leaf(state))).collect())
    }
}

/// A disjunct of a condition over the nodes of a graph.
pub(super) struct Accepting {
    /// The nodes that a path may visit infinitely often.
    pub(super) always: Set,
    /// The sets of which each is visited infinitely often.
    pub(super) again: Vec<Set>,
}

impl Accepting {
    /// Returns whether paths that visit exactly these nodes infinitely often are accepted.
    pub(super) fn accepts(&self, nodes: &[usize]) -> bool {
        let meets = |set: &Set| nodes.iter().any(|&node| set[node]);
        nodes.iter().all(|&node| self.always[node]) && self.again.iter().all(meets)
    }
}

/// Returns the disjuncts of a condition over some nodes, given the nodes of each mark.
pub(super) fn disjuncts(
    condition: &Condition,
    nodes: usize,
    mask: impl Fn(&Predicate) -> Result<Set>,
) -> Result<Vec<Accepting>> {
    let accepting = |disjunct: Disjunct| {
        let mut always = vec![true; nodes];
        for (mark, sign) in &disjunct.always {
            let own = mask(mark)?;
            always.iter_mut().zip(own).for_each(|(always, own)| *always &= own == *sign);
        }
        let again = disjunct.again.iter().map(&mask).collect::<Result<_>>()?;
        Ok(Accepting { always, again })
    };
    condition.disjuncts()?.into_iter().map(accepting).collect()
}
