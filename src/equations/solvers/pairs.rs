//! States with what the path has decided about several objectives.

use ahash::AHashMap;
use bitvec::vec::BitVec;
use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use meliora_model::Optimum;
use meliora_space::weighted::Fractions;

use super::components::EndComponents;
use super::groups::unite;
use super::sides::Sides;
use crate::graphs::arena::Arena;
use crate::graphs::choices::Choices;
use crate::graphs::game_graph::Rewards;
use crate::graphs::meter::Meter;

/// A number of a path.
#[derive(Debug, Clone, Copy)]
pub enum Counted<'a> {
    /// 1 if the path visits the set.
    Visit(&'a BitVec),
    /// 1 if the path visits the second set through states of the first one.
    Until(&'a BitVec, &'a BitVec),
    /// 1 if the path visits the set infinitely often.
    Recur(&'a BitVec),
    /// The rewards of all steps.
    Total(&'a Rewards),
    /// The rewards of the first steps.
    Within(&'a Rewards, u32),
    /// The rewards of the steps before the path visits the set; infinite unless it does almost surely.
    Before(&'a Rewards, &'a BitVec),
}

/// A choice of a group, divided by the probability to leave the group.
pub(super) struct Action {
    /// The groups that are entered, with the numbers of the probabilities.
    pub(super) edges: Vec<(u32, u32)>,
    /// The numbers of the gains.
    pub(super) gains: Vec<u32>,
    pub(super) taken: Taken,
}

/// The meaning of an action in the pairs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Taken {
    /// A choice.
    Choice(usize),
    /// To stay in an end component.
    Stay(End),
    /// Nothing: it is the action of pairs that are not entered.
    Nothing,
}

/// An end component in which a path may stay.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct End {
    /// One of its pairs.
    pub(super) pair: u32,
    /// The objectives of [`Counted::Recur`] whose sets are left out, as bits.
    left_out: u32,
    /// The objectives of [`Counted::Recur`] whose sets are visited infinitely often, as bits.
    pub(super) hits: u32,
}

/// The memory that the objectives need of the steps before.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Memory {
    /// The objectives that are decided, as bits.
    pub(super) decided: u32,
    /// The number of steps, as far as it counts.
    pub(super) steps: u32,
}

/// States with memory. The first one is that of the start.
pub(super) struct Pairs {
    pub(super) list: Vec<(u32, Memory)>,
    numbers: AHashMap<(u32, Memory), u32>,
    pub(super) choices: Choices,
    /// The numbers of the probabilities of the successors, and of the gains of each choice.
    weights: Vec<u32>,
    pub(super) gains: Vec<Vec<u32>>,
}

impl Memory {
    /// Returns the reward of a choice for the objective `at`.
    fn earned(self, at: u32, counted: Counted<'_>, choice: usize) -> Ratio {
        let counts = |counts: bool, rewards: &Rewards| match counts {
            true => rewards.choice(choice).clone(),
            false => Ratio::default(),
        };
        match counted {
            Counted::Total(rewards) => counts(true, rewards),
            Counted::Within(rewards, steps) => counts(self.steps < steps, rewards),
            Counted::Before(rewards, _) => counts(self.decided >> at & 1 == 0, rewards),
            _ => Ratio::default(),
        }
    }
}

impl Pairs {
    fn number(&mut self, pair: (u32, Memory)) -> u32 {
        let Pairs { list, numbers, .. } = self;
        *numbers.entry(pair).or_insert_with(|| {
            list.push(pair);
            list.len() as u32 - 1
        })
    }

    /// Explores the pairs that a state reaches.
    pub(super) fn explored(
        arena: &Arena<'_>,
        start: usize,
        objectives: &[(Counted<'_>, Optimum)],
        fractions: &mut Fractions,
        meter: &mut Meter<'_>,
    ) -> Result<Self> {
        let mut pairs = Pairs {
            list: Vec::new(),
            numbers: AHashMap::new(),
            choices: Choices::default(),
            weights: Vec::new(),
            gains: Vec::new(),
        };
        let most = counted_steps(objectives);
        pairs.number((start as u32, Memory { decided: decided(objectives, start).0, steps: 0 }));
        let mut next = 0;
        while let Some(&(state, memory)) = pairs.list.get(next) {
            meter.take(size_of::<(u32, Memory)>() * 4)?;
            next += 1;
            for choice in arena.choices.of(state) {
                let earned = (0..).zip(objectives).map(|(at, own)| memory.earned(at, own.0, choice));
                let mut gains: Vec<Ratio> = earned.collect();
                for (to, weight) in arena.outcomes(choice) {
                    let p = &arena.fractions.list()[weight as usize];
                    let (own, satisfied) = decided(objectives, to as usize);
                    let new = satisfied & !memory.decided;
                    (0..objectives.len()).filter(|at| new >> at & 1 == 1).for_each(|at| gains[at] += p);
                    let steps = most.min(memory.steps + 1);
                    let to = pairs.number((to, Memory { decided: memory.decided | own, steps }));
                    pairs.choices.to.push(to);
                    pairs.weights.push(weight);
                }
                let signed = gains.into_iter().zip(objectives).map(|(gain, own)| signed(gain, own.1));
                pairs.gains.push(signed.map(|gain| fractions.number(gain)).collect());
                pairs.choices.end_choice();
                meter.take(12 * arena.choices.successors(choice).len() + 4 * objectives.len() + 28)?;
            }
            pairs.choices.end_node();
        }
        Ok(pairs)
    }

    /// Returns the end components of the choices that gain nothing for the objectives with some optima.
    pub(super) fn resting(
        &self,
        objectives: &[(Counted<'_>, Optimum)],
        optima: &[Optimum],
        zero: u32,
        meter: &mut Meter<'_>,
    ) -> Result<EndComponents> {
        let is_free = |gains: &Vec<u32>| {
            gains.iter().zip(objectives).all(|(&gain, own)| gain == zero || !optima.contains(&own.1))
        };
        self.choices.end_components_among(self.gains.iter().map(is_free).collect(), meter)
    }

    /// Returns whether a path may stay in the end component of a pair, for the objectives [`Counted::Before`] that are to
    /// be great or small: it visits their targets before.
    fn may_rest(&self, objectives: &[(Counted<'_>, Optimum)], optimum: Optimum, pair: u32) -> bool {
        let memory = self.list[pair as usize].1;
        (0..).zip(objectives).all(|(at, own)| match own.0 {
            Counted::Before(..) => own.1 != optimum || memory.decided >> at & 1 == 1,
            _ => true,
        })
    }

    /// Returns the pairs from which some strategy has finite costs for all objectives: it almost surely stays in an end
    /// component without costs, after it visited all targets of costs.
    pub(super) fn finite(
        &self,
        objectives: &[(Counted<'_>, Optimum)],
        zero: u32,
        meter: &mut Meter<'_>,
    ) -> Result<BitVec> {
        let free = self.resting(objectives, &[Optimum::Min], zero, meter)?;
        let rests = |pair: u32| {
            self.choices.of(pair).any(|choice| free.inside[choice])
                && self.may_rest(objectives, Optimum::Min, pair)
        };
        let target: BitVec = (0..self.list.len() as u32).map(rests).collect();
        let all = BitVec::repeat(true, self.list.len());
        let allowed = BitVec::repeat(true, self.gains.len());
        Sides::new(&self.choices, &all, &allowed, meter)?.almost_sure(&target, &all, meter)
    }

    /// Returns a pair from which a strategy with finite costs gains for all time, or never visits the target of a reward
    /// that is to be great, if there is one.
    pub(super) fn endless(
        &self,
        objectives: &[(Counted<'_>, Optimum)],
        resting: &EndComponents,
        finite: &BitVec,
        zero: u32,
        meter: &mut Meter<'_>,
    ) -> Result<Option<u32>> {
        let is_finite = |&to: &u32| finite[to as usize];
        let stays = |choice: usize| self.choices.successors(choice).iter().all(is_finite);
        let found = self.choices.end_components_among((0..self.gains.len()).map(stays).collect(), meter)?;
        let gains = |choice: usize| {
            let all = self.gains[choice].iter().zip(objectives);
            all.into_iter().any(|(&gain, own)| own.1 == Optimum::Max && gain != zero)
        };
        let is_endless = |pair: u32| {
            let mut inside = self.choices.of(pair).filter(|&choice| found.inside[choice]);
            inside.any(|choice| {
                gains(choice) || resting.inside[choice] && !self.may_rest(objectives, Optimum::Max, pair)
            })
        };
        Ok((0..self.list.len() as u32).filter(is_finite).find(|&pair| is_endless(pair)))
    }

    /// Returns a pair of each end component in which a path may stay, with the objectives of [`Counted::Recur`] that it
    /// satisfies there: all states of the component are visited infinitely often. Some of the sets that are to be avoided
    /// are left out, in all ways.
    pub(super) fn ends(
        &self,
        objectives: &[(Counted<'_>, Optimum)],
        resting: &EndComponents,
        finite: &BitVec,
        meter: &mut Meter<'_>,
    ) -> Result<Vec<End>> {
        let recurs =
            |own: &(Counted<'_>, Optimum)| matches!(own.0, Counted::Recur(_)) && own.1 == Optimum::Min;
        let avoided: Vec<usize> = (0..objectives.len()).filter(|&at| recurs(&objectives[at])).collect();
        let mut ends = Vec::new();
        for subset in 0..1u32 << avoided.len() {
            let left_out = avoided.iter().enumerate().filter(|(bit, _)| subset >> bit & 1 == 1);
            let left_out = left_out.fold(0u32, |bits, (_, at)| bits | 1 << at);
            let parts = self.parts(objectives, &resting.inside, left_out, meter)?;
            let mut hit: AHashMap<u32, (u32, u32)> = AHashMap::new();
            for pair in finite.iter_ones().map(|pair| pair as u32) {
                if self.choices.of(pair).any(|own| parts.inside[own])
                    && self.may_rest(objectives, Optimum::Min, pair)
                {
                    hit.entry(parts.group[pair as usize]).or_insert((pair, 0)).1 |=
                        self.hits(objectives, pair);
                }
            }
            ends.extend(hit.into_values().map(|(pair, hits)| End { pair, left_out, hits }));
        }
        ends.sort_unstable();
        Ok(ends)
    }

    /// Returns the objectives of [`Counted::Recur`] whose sets contain the state of a pair, as bits.
    fn hits(&self, objectives: &[(Counted<'_>, Optimum)], pair: u32) -> u32 {
        let state = self.list[pair as usize].0 as usize;
        let hits = |own: &(Counted<'_>, Optimum)| matches!(own.0, Counted::Recur(set) if set[state]);
        (0..).zip(objectives).fold(0, |bits, (at, own)| bits | u32::from(hits(own)) << at)
    }

    /// Returns the end components of some choices that leave out the sets of some objectives.
    fn parts(
        &self,
        objectives: &[(Counted<'_>, Optimum)],
        inside: &[bool],
        left_out: u32,
        meter: &mut Meter<'_>,
    ) -> Result<EndComponents> {
        let stays = |&pair: &u32| self.hits(objectives, pair) & left_out == 0;
        let keeps = |choice: usize| inside[choice] && self.choices.successors(choice).iter().all(stays);
        self.choices.end_components_among((0..self.gains.len()).map(keeps).collect(), meter)
    }

    /// Returns the choices of the pairs in which a path stays, by pair.
    pub(super) fn staying(
        &self,
        objectives: &[(Counted<'_>, Optimum)],
        inside: &[bool],
        end: End,
        meter: &mut Meter<'_>,
    ) -> Result<Vec<(u32, Vec<usize>)>> {
        let parts = self.parts(objectives, inside, end.left_out, meter)?;
        let own = parts.group[end.pair as usize];
        let members = (0..self.list.len() as u32).filter(|&pair| parts.group[pair as usize] == own);
        let choices = |pair: u32| self.choices.of(pair).filter(|&choice| parts.inside[choice]).collect();
        Ok(members.map(|pair| (pair, choices(pair))).collect())
    }

    /// Returns the number of the probability of each successor of a choice.
    pub(super) fn weights(&self, choice: usize) -> &[u32] {
        &self.weights[self.choices.start[choice] as usize..self.choices.start[choice + 1] as usize]
    }

    /// Returns the action of a choice that leaves its group `own`.
    pub(super) fn action(&self, own: u32, choice: usize, group: &[u32], fractions: &mut Fractions) -> Action {
        let known = |fractions: &Fractions, number: u32| fractions.list()[number as usize].clone();
        let (mut edges, mut leaving): (Vec<(u32, Ratio)>, _) = (Vec::new(), Ratio::default());
        for at in self.choices.start[choice] as usize..self.choices.start[choice + 1] as usize {
            let to = group[self.choices.to[at] as usize];
            if to != own {
                let p = known(fractions, self.weights[at]);
                leaving += &p;
                edges.push((to, p));
            }
        }
        unite(&mut edges);
        let edges = edges.into_iter().map(|(to, p)| (to, fractions.number(p / &leaving))).collect();
        let gains = self.gains[choice].iter();
        let gains = gains.map(|&gain| known(fractions, gain) / &leaving).collect::<Vec<_>>();
        let gains = gains.into_iter().map(|gain| fractions.number(gain)).collect();
        Action { edges, gains, taken: Taken::Choice(choice) }
    }
}

/// Returns the number of first steps that objectives count.
pub fn counted_steps(objectives: &[(Counted<'_>, Optimum)]) -> u32 {
    let within = |own: &(Counted<'_>, Optimum)| if let Counted::Within(_, steps) = own.0 { steps } else { 0 };
    objectives.iter().map(within).max().unwrap_or_default()
}

/// Returns the objectives that a state decides if none of the states before does, and those that it satisfies, as bits.
pub fn decided(objectives: &[(Counted<'_>, Optimum)], state: usize) -> (u32, u32) {
    let (mut decided, mut satisfied) = (0, 0);
    for (at, (counted, _)) in objectives.iter().enumerate() {
        let (left, right, counts) = match counted {
            Counted::Visit(right) => (true, right[state], true),
            Counted::Until(left, right) => (left[state], right[state], true),
            Counted::Before(_, right) => (true, right[state], false),
            Counted::Recur(_) | Counted::Total(_) | Counted::Within(..) => continue,
        };
        satisfied |= u32::from(right && counts) << at;
        decided |= u32::from(right || !left) << at;
    }
    (decided, satisfied)
}

pub(super) fn signed(gain: Ratio, optimum: Optimum) -> Ratio {
    if optimum == Optimum::Max { gain } else { -gain }
}
