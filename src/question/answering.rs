//! Answers requests with one engine. The regions that they need are computed first, the cheapest of each target before
//! the others, and the numbers last. Therefore a limit leaves as many answers as possible.

use std::cell::RefCell;
use std::sync::Arc;

use ahash::AHashMap;

use crate::answer::{Answer, Computing};
use crate::answers::{Answers, Share};
use crate::asking::Asking;
use crate::evaluate::Number;
use crate::goal::{PathGoal, Target};
use crate::listener::{Listener, Shares};
use crate::plan::{Decision, Request};
use crate::questions::{Options, Questions};
use crate::regions::KnownRegions;
use crate::start::check_start;
use crate::under::Under;
use crate::warnings::{self, Warning};
use meliora_base::error::{Error, Result};
use meliora_engine::regions::{Regions, Which};
use meliora_engine::{Count, Engine, Guided, Usage};
use meliora_lang::refusal::Refusal;
use meliora_model::Program;
use meliora_planning::RegionSearch;
use meliora_planning::result::ModelCounts;

/// The decisions about the requests so far.
pub(crate) type Known = Vec<Option<Decision>>;

/// The answer to a request before all states are known.
pub(crate) struct Judged {
    pub(crate) answer: Answer,
    pub(crate) decision: Decision,
    /// The share of the initial states in each region that was needed.
    pub(crate) initial: Regions<Option<Share>>,
    /// The resources that its engine has used.
    pub(crate) usage: Option<Usage>,
}

/// Answers a request over all valuations.
///
/// # Errors
/// A limit is hit; the target has no value in some state of the engine; the model has no initial state.
pub(crate) fn judge<E: Engine>(
    engine: &E,
    asking: &Asking,
    asked: &Arc<Program>,
    program: &Program,
) -> Result<Judged> {
    check_start(engine, program)?;
    let played = asking.played(engine)?;
    let engine = played.as_ref().unwrap_or(engine);
    let under = Under::new(engine, asked, &asking.goal)?;
    let mut search = asking.goal.search(engine)?;
    let mut initial = Regions::default();
    for which in search.order(&asking.needed()) {
        *initial.get_mut(which) = Some(Share::of_initial(engine, &search.region(which)?)?);
    }
    let answer = under.decided(asking, search.known())?;
    let decision = Decision::of(engine, asking, &answer, search.known(), false)?;
    Ok(Judged { answer, decision, initial, usage: Some(engine.usage()) })
}

/// Returns the answer of a guided search for the region of a request.
pub(crate) fn guided(search: &Guided, asking: &Asking) -> Judged {
    let [all, lost] = search.initial();
    // The search ends with the first initial state that is lost.
    let (share, is_none) = match search.answer() {
        Some(true) => (Some(Share::All), Some(false)),
        Some(false) if lost == all => (Some(Share::None), Some(true)),
        _ => (None, None),
    };
    let inside = Decision { all: search.answer(), none: is_none, is_lost: false };
    let decision = if asking.is_inside() { inside } else { !inside };
    let initial = Regions { pmax_one: share, ..Regions::default() };
    Judged { answer: Answer::of(decision.holds()), decision, initial, usage: None }
}

/// Adds the answer to a request, and the answers that it decides to the properties that need it.
pub(crate) fn add(r: &mut Answers, asked: &Questions, request: usize, answer: &Answer, known: &Known) {
    for &at in &asked.plan.requests[request].properties {
        let property = &asked.plan.properties[at];
        if property.request().is_some() {
            r.answer(property.position, answer);
        } else if let Some(holds) = asked.plan.holds(&asked.program, at, known) {
            r.answer(property.position, &Answer::of(Some(holds)));
        }
    }
}

/// Answers questions, and adds the answers to the report of a job.
pub(crate) struct Answering<'a> {
    pub(crate) listener: &'a dyn Listener,
    pub(crate) options: &'a Options,
    pub(crate) asked: &'a Questions,
    pub(crate) known: RefCell<Known>,
    /// Finds the strategy of the only operator, and the numbers that it asks for in the initial states, if it is asked for.
    pub(crate) optima: Option<&'a dyn Fn() -> Option<Vec<Number>>>,
    /// True if nothing is asked of the engine after the requests.
    pub(crate) is_all: bool,
}

impl<'a> Answering<'a> {
    pub(crate) fn new(
        listener: &'a dyn Listener,
        options: &'a Options,
        asked: &'a Questions,
        known: Known,
    ) -> Self {
        Answering { listener, options, asked, known: RefCell::new(known), optima: None, is_all: false }
    }

    /// Returns the decisions about all requests.
    pub(crate) fn known(self) -> Known {
        self.known.into_inner()
    }

    /// Answers requests about one program; without any, the states are counted. Regions go to `kept`, if there is a list.
    /// Returns the unsafe states under requirements.
    ///
    /// # Errors
    /// A limit is hit, or a request has no answer that leaves the others.
    pub(crate) fn requests<E: Engine>(
        &self,
        engine: &E,
        requests: &[usize],
        kept: &mut Option<KnownRegions<E::States>>,
    ) -> Result<Option<E::States>> {
        let all = &self.asked.plan.requests;
        let Some(&first) = requests.first() else {
            let all = engine.all_states();
            let count = || ModelCounts::within(engine, &all);
            let counts = self.listener.timed(("count", "build"), count)?;
            self.listener.update(|r| r.counts = Some(counts));
            return Ok(None);
        };
        let goal = &all[first].asking.goal;
        let under = Under::new(engine, &self.asked.program, goal)?;
        self.counted(engine, &under, goal)?;
        let parts = by_coalition(all, requests);
        for (part, requests) in (1..).zip(&parts) {
            let played = all[requests[0]].asking.played(engine)?;
            let own = played.as_ref().map(|game| Under::new(game, &self.asked.program, goal)).transpose()?;
            let settles = self.is_all && part == parts.len();
            self.regions(own.as_ref().unwrap_or(&under), requests, kept, settles)?;
        }
        Ok(under.unsafe_states().cloned())
    }

    /// Counts the states, unless another question has done so.
    pub(crate) fn counted<E: Engine>(&self, engine: &E, under: &Under<'_, E>, goal: &PathGoal) -> Result<()> {
        let mut known = false;
        self.listener.update(|r| known = r.counts.is_some());
        if known {
            return Ok(());
        }
        let counts = self.listener.timed(("count", "build"), || under.counts(goal))?;
        let (program, overlap) = (&self.asked.program, self.asked.overlap.as_ref());
        let warnings = warnings::of_states(engine, program, &counts.deadlocks, overlap)?;
        warnings.into_iter().for_each(|warning| self.listener.warn(warning));
        self.listener.update(|r| (r.counts, r.escape) = (Some(counts), under.escape.clone()));
        Ok(())
    }

    /// Answers requests of the same players; the numbers settle the race if nothing else is asked for after them.
    fn regions<E: Engine>(
        &self,
        under: &Under<'_, E>,
        requests: &[usize],
        kept: &mut Option<KnownRegions<E::States>>,
        settles: bool,
    ) -> Result<()> {
        let mut groups = groups(under.engine(), self.asked, requests)?;
        if let ([group], true) = (&mut groups[..], self.options.is_one) {
            self.target(under, group)?;
        }
        for round in 0..Which::ALL.len() {
            for group in &mut groups {
                let Some((which, states)) = self.find(under, group, round)? else { continue };
                if let Some(kept) = kept {
                    kept.extend(group.members.iter().map(|&request| (request, which, states.clone())));
                }
            }
            groups.retain(|group| self.is_left(group) || round + 1 < group.order.len());
        }
        let mut shares = self.shares(&groups);
        groups.iter().try_for_each(|group| self.values(under, group, &mut shares, settles))
    }

    fn asking(&self, request: usize) -> &'a Asking {
        &self.asked.plan.requests[request].asking
    }

    /// Returns whether more than the regions is to be computed for some of the requests.
    fn is_left<E: Engine>(&self, group: &Group<'_, E>) -> bool {
        group.members.iter().any(|&request| self.has_value(request))
    }

    /// Returns whether a request is answered after the regions: one that asks for a number, and the property of a
    /// run with one question.
    fn has_value(&self, request: usize) -> bool {
        let (asking, is_one) = (self.asking(request), self.options.is_one && self.is_alone(request));
        asking.asks_for_number() || is_one && asking.question.is_some()
    }

    /// Returns whether the answer to a request is that of a property.
    fn is_alone(&self, request: usize) -> bool {
        self.asked.plan.alone(request).next().is_some()
    }

    /// Counts the states of the target of one question.
    fn target<E: Engine>(&self, under: &Under<'_, E>, group: &mut Group<'_, E>) -> Result<()> {
        let request = group.members[0];
        if !matches!(self.asking(request).goal.target, Target::States(_)) || !self.is_alone(request) {
            return Ok(());
        }
        let engine = under.engine();
        // The goal has states with monitors that are not fresh, which stand for the same model state.
        let own = engine.intersection(&engine.all_states(), &group.judged)?;
        let size = engine.count(&engine.intersection(&group.search.goal()?, &own)?)?;
        if size == Count::ZERO {
            self.listener.warn(Warning::Text("no state satisfies the target".to_owned()));
        }
        self.listener.update(|r| r.one.iter_mut().for_each(|one| one.target = Some(size.clone().into())));
        Ok(())
    }

    /// Computes the region of a round, and adds it and the decided verdicts to the report. Returns it within
    /// the states that are judged; `None` if no region is left.
    fn find<E: Engine>(
        &self,
        under: &Under<'_, E>,
        group: &mut Group<'_, E>,
        round: usize,
    ) -> Result<Option<(Which, E::States)>> {
        let Some(&which) = group.order.get(round) else { return Ok(None) };
        let region = || group.search.region(which);
        let states = self.listener.timed((which.formula(), which.name()), region)?;
        let engine = under.engine();
        let inside = engine.intersection(&states, &group.judged)?;
        let alone = group.members.iter().flat_map(|&request| self.asked.plan.alone(request));
        let positions: Vec<usize> = alone.map(|at| self.asked.plan.properties[at].position).collect();
        self.size(engine, &positions, (which, &inside))?;
        for &request in &group.members {
            let asking = self.asking(request);
            let decided = under.decided(asking, group.search.known())?;
            self.learn(under, request, &decided, group.search.known())?;
        }
        Ok(Some((which, inside)))
    }

    /// Adds the size of a region of some properties to the report.
    pub(crate) fn size<E: Engine>(
        &self,
        engine: &E,
        positions: &[usize],
        (which, states): (Which, &E::States),
    ) -> Result<()> {
        if positions.is_empty() {
            return Ok(());
        }
        let size = engine.count(states)?;
        let share = self.options.is_one.then(|| Share::of_initial(engine, states)).transpose()?;
        self.listener.update(|r| {
            if let Some(one) = &mut r.one {
                *one.sizes.get_mut(which) = Some(size.clone().into());
                *one.initial.get_mut(which) = share;
            }
            for &position in positions {
                *r.properties[position].sizes.get_mut(which) = Some(size.clone().into());
            }
        });
        Ok(())
    }

    /// Notes the answer to a request, as far as it is known.
    fn learn<E: Engine>(
        &self,
        under: &Under<'_, E>,
        request: usize,
        answer: &Answer,
        known: &Regions<Option<E::States>>,
    ) -> Result<()> {
        let (asking, is_lost) = (self.asking(request), under.escape.is_some());
        let decision = Decision::of(under.engine(), asking, answer, known, is_lost)?;
        self.known.borrow_mut()[request] = Some(decision);
        self.listener.update(|r| {
            add(r, self.asked, request, answer, &self.known.borrow());
        });
        self.listener.used(under.engine().usage());
        Ok(())
    }

    /// Returns the shares of the requests for which the regions are not enough, and of the properties behind them.
    fn shares<E: Engine>(&self, groups: &[Group<'_, E>]) -> Shares<'a> {
        let members = || groups.iter().flat_map(|group| &group.members);
        let values = members().filter(|&&request| self.has_value(request)).count();
        // A formula with monitors is alone, and has its share already.
        let is_plain = members().any(|&request| self.asking(request).goal.watched.is_none());
        let more = self.asked.plan.properties.iter().any(|property| property.request().is_none());
        Shares::of(self.listener, values + usize::from(is_plain && more))
    }

    /// Answers the requests for which the regions are not enough.
    fn values<E: Engine>(
        &self,
        under: &Under<'_, E>,
        group: &Group<'_, E>,
        shares: &mut Shares<'_>,
        settles: bool,
    ) -> Result<()> {
        for &request in group.members.iter().filter(|&&request| self.has_value(request)) {
            let (asking, known, mut partial) = (self.asking(request), group.search.known(), None);
            let answer = || {
                let optima = match self.optima {
                    Some(find) if under.decided(asking, known)?.value.is_none() => find(),
                    _ => None,
                };
                let (optima, precision) = (optima.as_deref(), self.options.precision);
                let computing = Computing { optima, precision, settles };
                let mut answer = under.answer(asking, &self.asked.program, known, &computing)?;
                let end = std::mem::replace(&mut answer.end, Ok(()));
                // A number of a game that is not supported leaves the others.
                let leaves = answer.no_value.is_some() && !self.options.is_one;
                partial = Some(answer);
                if leaves { Ok(()) } else { end }
            };
            let work = || Ok(shares.next(answer));
            let done = self.listener.timed(("value", "value"), work)?;
            if let Some(answer) = &partial {
                self.learn(under, request, answer, known)?;
            }
            let reason = match done {
                Ok(Ok(())) => continue,
                Ok(Err(reason)) => reason,
                // A wrong reward.
                Err(error @ Error::Input(_)) if self.asked.is_list => Refusal::new(&error).reason,
                Err(error) => return Err(error),
            };
            self.listener.update(|r| {
                for at in self.asked.plan.alone(request) {
                    r.properties[self.asked.plan.properties[at].position].reason = Some(reason.clone());
                }
            });
        }
        Ok(())
    }
}

/// Separates the requests of a game by the players who choose.
fn by_coalition(all: &[Request], requests: &[usize]) -> Vec<Vec<usize>> {
    let mut parts: Vec<Vec<usize>> = Vec::new();
    for &request in requests {
        let coalition = |request: usize| &all[request].asking.coalition;
        match parts.iter_mut().find(|own| coalition(own[0]) == coalition(request)) {
            Some(own) => own.push(request),
            None => parts.push(vec![request]),
        }
    }
    parts
}

/// Requests with the same goal.
struct Group<'a, E: Engine> {
    members: Vec<usize>,
    /// The regions that they need.
    order: Vec<Which>,
    search: RegionSearch<'a, E>,
    /// The states whose paths are judged.
    judged: E::States,
}

/// Groups requests by their goals, in the order of the first of each.
fn groups<'a, E: Engine>(
    engine: &'a E,
    asked: &'a Questions,
    requests: &[usize],
) -> Result<Vec<Group<'a, E>>> {
    let asking = |request: usize| &asked.plan.requests[request].asking;
    let same = |a: &Asking, b: &Asking| match (&a.goal.target, &b.goal.target) {
        (Target::States(one), Target::States(other)) => one.is_same(other),
        _ => false,
    };
    let mut groups: Vec<Group<'a, E>> = Vec::new();
    // The groups by the fingerprints of their targets.
    let mut known: AHashMap<u64, Vec<usize>> = AHashMap::new();
    for &request in requests {
        let own = asking(request);
        let alike = match &own.goal.target {
            Target::States(target) => Some(known.entry(target.fingerprint()).or_default()),
            Target::Formula(_) => None,
        };
        let same = |&&group: &&usize| same(asking(groups[group].members[0]), own);
        match alike.as_ref().and_then(|alike| alike.iter().find(same).copied()) {
            Some(group) => groups[group].members.push(request),
            None => {
                alike.into_iter().for_each(|alike| alike.push(groups.len()));
                let (search, judged) = (own.goal.search(engine)?, own.goal.judged(engine)?);
                groups.push(Group { members: vec![request], order: Vec::new(), search, judged });
            }
        }
    }
    for group in &mut groups {
        let needed = group.members.iter().flat_map(|&request| asking(request).needed());
        group.order = group.search.order(&Vec::from_iter(needed));
    }
    Ok(groups)
}
