//! The explored part of a model: states with their choices, their standing, and a policy.

use super::estimate::Estimate;
use meliora_base::error::Result;
use meliora_space::index::{Index, NOBODY};
use meliora_space::meter::{Array, Meter};

/// The known properties of a state.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Standing {
    /// It is in the target.
    pub(super) is_target: bool,
    /// The target is not reached almost surely by any strategy.
    pub(super) is_lost: bool,
    /// Its choices are listed.
    pub(super) is_expanded: bool,
    /// The rules by which the distance was estimated last; see [`super::Guide::age`].
    pub(super) age: u32,
}

/// A state of the policy: its choice, and a successor that is closer to the target.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step {
    pub(super) choice: u32,
    pub(super) next: u32,
    /// Larger than that of the successor; 0 for the target.
    pub(super) level: u32,
}

/// A choice that is added.
#[derive(Debug, Clone, Copy)]
pub(super) struct Taken {
    /// See [`Part::command_of`].
    pub(super) command: u32,
    /// See [`Part::place_of`].
    pub(super) place: [u32; 2],
    /// The estimate suggests it.
    pub(super) is_helpful: bool,
    /// It is never taken.
    pub(super) is_fatal: bool,
}

const NO_STEP: Step = Step { choice: NOBODY, next: NOBODY, level: 0 };

/// The explored part.
pub(super) struct Part {
    pub(super) index: Index,
    pub(super) standing: Array<Standing>,
    /// The estimated distance of each state.
    pub(super) estimate: Array<Estimate>,
    steps: Array<Step>,
    /// For each state the first choice, and the number of choices; for its choices the number of those that may be taken.
    choices: Array<[u32; 2]>,
    left: Array<u32>,
    /// For each choice the state, the end of its edges, whether it may be taken, and whether an estimate suggests it.
    owner: Array<u32>,
    ends: Array<u32>,
    is_open: Array<bool>,
    is_helpful: Array<bool>,
    /// For each choice its command, if it is of one alone, else [`NOBODY`]; the synchronisation, and the number among
    /// its choices in the state.
    commands: Array<u32>,
    places: Array<[u32; 2]>,
    /// For each edge the successor, the choice, and the previous edge into the same successor.
    to: Array<u32>,
    choice_of: Array<u32>,
    before: Array<u32>,
    /// For each state the last edge into it.
    into: Array<u32>,
    /// The states that lost their place in the policy.
    pub(super) detached: Vec<u32>,
}

impl Part {
    pub(super) fn new(words: usize, meter: &Meter) -> Self {
        Part {
            index: Index::new(words, meter),
            standing: Array::new(meter),
            estimate: Array::new(meter),
            steps: Array::new(meter),
            choices: Array::new(meter),
            left: Array::new(meter),
            owner: Array::new(meter),
            ends: Array::new(meter),
            is_open: Array::new(meter),
            is_helpful: Array::new(meter),
            commands: Array::new(meter),
            places: Array::new(meter),
            to: Array::new(meter),
            choice_of: Array::new(meter),
            before: Array::new(meter),
            into: Array::new(meter),
            detached: Vec::new(),
        }
    }

    /// Returns the number of a state, and whether it is new.
    ///
    /// # Errors
    /// The memory limit.
    pub(super) fn number(&mut self, code: &[u64]) -> Result<(u32, bool)> {
        let state = self.index.intern(code)?;
        if (state as usize) < self.standing.len() {
            return Ok((state, false));
        }
        self.standing.push(Standing::default())?;
        self.estimate.push(Estimate::default())?;
        self.steps.push(NO_STEP)?;
        self.choices.push([0, 0])?;
        self.left.push(0)?;
        self.into.push(NOBODY)?;
        Ok((state, true))
    }

    /// Begins the list of the choices of a state.
    pub(super) fn begin(&mut self, state: u32) {
        self.choices[state as usize] = [self.owner.len() as u32, 0];
        self.standing[state as usize].is_expanded = true;
    }

    /// Adds a choice to the state that was begun last.
    ///
    /// # Errors
    /// The memory limit.
    pub(super) fn add(&mut self, state: u32, successors: &[u32], taken: Taken) -> Result<()> {
        let choice = self.owner.len() as u32;
        // A choice that stays never leads to the target.
        let mut is_open = !taken.is_fatal && successors.iter().any(|&to| to != state);
        for &to in successors {
            let edge = self.to.len() as u32;
            self.to.push(to)?;
            self.choice_of.push(choice)?;
            self.before.push(self.into[to as usize])?;
            self.into[to as usize] = edge;
            is_open &= !self.standing[to as usize].is_lost;
        }
        self.owner.push(state)?;
        self.ends.push(self.to.len() as u32)?;
        self.is_open.push(is_open)?;
        self.is_helpful.push(taken.is_helpful)?;
        self.commands.push(taken.command)?;
        self.places.push(taken.place)?;
        self.choices[state as usize][1] += 1;
        self.left[state as usize] += u32::from(is_open);
        Ok(())
    }

    /// Ends the list of the choices of a state, which is lost if none may be taken.
    pub(super) fn end(&mut self, state: u32) {
        if self.left[state as usize] == 0 {
            self.lose(vec![state]);
        }
    }

    /// Returns the choices of a state.
    pub(super) fn choices_of(&self, state: u32) -> std::ops::Range<u32> {
        let [first, count] = self.choices[state as usize];
        first..first + count
    }

    /// Returns the edges of a choice.
    pub(super) fn edges_of(&self, choice: u32) -> std::ops::Range<u32> {
        let start = choice.checked_sub(1).map_or(0, |before| self.ends[before as usize]);
        start..self.ends[choice as usize]
    }

    /// Returns the successor of an edge.
    pub(super) fn successor(&self, edge: u32) -> u32 {
        self.to[edge as usize]
    }

    /// Returns the choice and the state of an edge.
    pub(super) fn source(&self, edge: u32) -> (u32, u32) {
        let choice = self.choice_of[edge as usize];
        (choice, self.owner[choice as usize])
    }

    /// Returns whether a choice has no successor that is lost.
    pub(super) fn is_open(&self, choice: u32) -> bool {
        self.is_open[choice as usize]
    }

    /// Returns whether the last estimate in its state suggests a choice.
    pub(super) fn is_helpful(&self, choice: u32) -> bool {
        self.is_helpful[choice as usize]
    }

    pub(super) fn suggest(&mut self, choice: u32, is_helpful: bool) {
        self.is_helpful[choice as usize] = is_helpful;
    }

    /// Returns the command of a choice; [`NOBODY`] if it has several.
    pub(super) fn command_of(&self, choice: u32) -> u32 {
        self.commands[choice as usize]
    }

    /// Returns the synchronisation of a choice, and its number among the choices of that in its state. Choices of fatal
    /// commands need not be listed, so the number among all of them would not tell.
    pub(super) fn place_of(&self, choice: u32) -> [usize; 2] {
        self.places[choice as usize].map(|number| number as usize)
    }

    /// Returns the step of the policy in a state.
    pub(super) fn step(&self, state: u32) -> Option<Step> {
        Some(self.steps[state as usize]).filter(|step| step.choice != NOBODY)
    }

    /// Returns whether the policy leads from a state to the target, or the state is in it.
    pub(super) fn leads_on(&self, state: u32) -> bool {
        self.standing[state as usize].is_target || self.steps[state as usize].choice != NOBODY
    }

    /// Takes a choice into the policy, with a successor from which this leads to the target.
    pub(super) fn attach(&mut self, state: u32, choice: u32, next: u32) {
        let level = self.steps[next as usize].level.saturating_add(1);
        self.steps[state as usize] = Step { choice, next, level };
    }

    /// Marks states as lost, and those that are lost with them: a choice that may step into a lost state is not taken,
    /// and a state without a choice is lost. The policy loses the states that led to the target by these.
    pub(super) fn lose(&mut self, mut lost: Vec<u32>) {
        lost.retain(|&state| !self.standing[state as usize].is_lost);
        lost.iter().for_each(|&state| self.standing[state as usize].is_lost = true);
        self.spread(lost, Vec::new());
    }

    /// Gives up a choice, and the states that are lost by this.
    pub(super) fn close(&mut self, choice: u32) {
        let (mut lost, mut detached) = (Vec::new(), Vec::new());
        self.shut(choice, &mut lost, &mut detached);
        self.spread(lost, detached);
    }

    /// Marks the states that are lost with some that are marked, and removes from the policy what does not lead on.
    fn spread(&mut self, mut lost: Vec<u32>, mut detached: Vec<u32>) {
        while let Some(state) = lost.pop() {
            detached.extend(self.step(state).map(|_| state));
            let mut edge = self.into[state as usize];
            while edge != NOBODY {
                let (choice, _) = self.source(edge);
                edge = self.before[edge as usize];
                self.shut(choice, &mut lost, &mut detached);
            }
        }
        self.detach(detached);
    }

    /// Marks a choice as one that is not taken. Adds its state to the lost ones if it has no other, and to the detached
    /// ones if the policy has this one.
    fn shut(&mut self, choice: u32, lost: &mut Vec<u32>, detached: &mut Vec<u32>) {
        if !std::mem::replace(&mut self.is_open[choice as usize], false) {
            return;
        }
        let owner = self.owner[choice as usize];
        self.left[owner as usize] -= 1;
        if self.steps[owner as usize].choice == choice {
            detached.push(owner);
        }
        let standing = &mut self.standing[owner as usize];
        if self.left[owner as usize] == 0 && !standing.is_lost && !standing.is_target {
            standing.is_lost = true;
            lost.push(owner);
        }
    }

    /// Removes states from the policy, and those that led to the target only by these.
    fn detach(&mut self, mut detached: Vec<u32>) {
        while let Some(state) = detached.pop() {
            if self.step(state).is_none() {
                continue;
            }
            self.steps[state as usize] = NO_STEP;
            self.detached.push(state);
            let mut edge = self.into[state as usize];
            while edge != NOBODY {
                let (choice, owner) = self.source(edge);
                edge = self.before[edge as usize];
                let Step { choice: taken, next, level } = self.steps[owner as usize];
                if taken != choice || next != state {
                    continue;
                }
                let lower = |&edge: &u32| {
                    let to = self.successor(edge);
                    self.leads_on(to) && self.steps[to as usize].level < level
                };
                match self.edges_of(choice).find(lower) {
                    Some(edge) => self.steps[owner as usize].next = self.successor(edge),
                    None => detached.push(owner),
                }
            }
        }
    }
}
