//! Answers the questions of `meliora reach`: a target, or properties.
//!
//! All reachability properties share one engine. A temporal formula has its own, with its monitors.
//! The regions that the properties need are computed first, the cheapest of each target before the
//! others, and the numbers last. Therefore a limit leaves as many answers as possible.

use std::sync::Arc;

use ahash::AHashMap;
use meliora::reach::{self, Asking, Under};
use meliora_base::error::Error;
use meliora_engine::regions::Which;
use meliora_engine::{AnyEngine, Count, Engine, Guided, Selection, SymbolicEngine};
use meliora_lang::refusal::Refusal;
use meliora_model::Program;
use meliora_planning::RegionSearch;
use meliora_planning::policy::Policy;
use meliora_planning::result::ModelCounts;
use meliora_report::ReachReport;
use meliora_report::reach::Share;

use super::asked::Asked;
use super::engines::{self, Early, Request};
use super::given::Given;
use super::judging::{self, Judged};
use super::regions::{Found, Regions, Shown};
use super::shares::Shares;
use super::supervise::Job;
use super::{policy, terms};

/// Answers the reachability properties with one engine, then each formula with its own, and then the
/// expressions over states.
///
/// # Errors
/// A limit is hit, or a question has no meaning for the initial states.
pub(super) fn work(job: &Job<ReachReport>, given: &Given<'_>, asked: &Asked) -> Result<(), Error> {
    let selected = match given.out {
        Some(_) => given.engine.diagrams("`--out` writes diagrams"),
        None => given.engine.select(given.model),
    };
    job.update(|r| {
        r.header.read(&asked.program);
        r.header.select(&selected);
    });
    let all = || asked.questions.iter().map(|q| (&q.asking, q.position));
    if let Some(out) = &given.out {
        return write_regions(job, given, out, asked, &Vec::from_iter(all()));
    }
    let plain: Vec<_> = all().filter(|(q, _)| q.goal.watched.is_none()).collect();
    if !plain.is_empty() || (asked.questions.is_empty() && asked.terms.is_empty()) {
        run_engine(job, given, &selected, asked, &asked.program, &plain)?;
    }
    let mut shares = Shares::of(&job.sink, later(asked));
    for question in all() {
        if let Some(watched) = &question.0.goal.watched {
            let work = || run_engine(job, given, &selected, asked, &watched.program, &[question]);
            if let Err(reason) = shares.next(work)? {
                job.update(|r| r.properties[question.1].reason = Some(reason));
            }
        }
    }
    terms::work(job, given, &selected, asked)?;
    job.sink.ended_share()
}

/// Answers properties with one engine of diagrams, and writes their regions.
fn write_regions(
    job: &Job<ReachReport>,
    given: &Given<'_>,
    out: &Regions<'_>,
    asked: &Asked,
    questions: &[(&Asking, usize)],
) -> Result<(), Error> {
    Regions::check(asked)?;
    let program = questions.first().map_or(&asked.program, |(first, _)| first.goal.program(&asked.program));
    let engine = job.timed(
        "build",
        || engines::symbolic(program, given.model, &job.sink),
        |r, s| r.time.add("build", s),
    )?;
    let mut kept = Some(Vec::new());
    let unsafe_states = answer(job, &*engine, asked, questions, given, &mut kept)?;
    let found = kept.unwrap_or_default();
    let satisfied = terms::satisfied(job, given, &engine, asked)?;
    let mut named = Vec::new();
    job.update(|r| {
        let name = |at: usize| (r.properties[at].name.clone(), r.properties[at].property.clone());
        named.extend(questions.iter().map(|&(asking, at)| (at, Shown::Paths(asking), name(at))));
        named.extend(satisfied.into_iter().map(|(at, states)| (at, Shown::Satisfied(states), name(at))));
    });
    let write = || out.write(&engine, asked, named, &found, unsafe_states.as_ref(), &job.sink);
    let written = job.timed("write", write, |_, _| ())?;
    job.update(|r| r.written = Some(written));
    job.sink.ended_share()
}

fn run_engine(
    job: &Job<ReachReport>,
    given: &Given<'_>,
    selected: &Selection,
    asked: &Asked,
    program: &Arc<Program>,
    questions: &[(&Asking, usize)],
) -> Result<(), Error> {
    let lists_states = questions.iter().any(|(asking, _)| asking.asks_for_number());
    let alone = judging::without_counts(given, asked, questions);
    let target = alone.and_then(judging::target);
    let over_all = alone.filter(|_| given.plan.is_none() || target.is_some()).map(|asking| {
        move |engine: &SymbolicEngine| {
            let judged = judging::judge(engine, asking, &asked.program, program)?;
            // It visits reachable states only, whatever the engine knows.
            let policy = target.filter(|_| given.plan.is_some());
            let policy = policy.map(|target| policy::found(engine, program, target)).transpose()?;
            Ok(Answered::Everywhere(judged, policy.map(Box::new)))
        }
    });
    let by_search = |search: Guided| Ok(Answered::Guided(Box::new(search)));
    let early = Early {
        everywhere: over_all.as_ref().map(|ask| ask as _),
        guided: target.map(|target| (target, &by_search as _)),
    };
    let by_states = |job: &Job<ReachReport>, engine: &Arc<AnyEngine>| {
        answer(job, &**engine, asked, questions, given, &mut None)?;
        Ok(Answered::ByStates(Arc::clone(engine)))
    };
    let (selected, answer) = (selected.clone(), &by_states as _);
    let request = Request { program, args: given.model, selected, lists_states, early, answer };
    match (engines::raced(job, &request)?, given.plan, questions) {
        (Answered::ByStates(engine), Some((plan, out)), [(asking, _)]) => {
            plan.work(job, &*engine, program, asking, out)
        }
        (Answered::ByStates(_), ..) => Ok(()),
        (Answered::Everywhere(judged, policy), plan, _) => {
            job.update(|r| r.over_all_valuations = true);
            without_states(job, questions, judged);
            match (plan, policy) {
                (Some((plan, Some(out))), Some(policy)) => plan.finish(job, *policy, program, out),
                _ => Ok(()),
            }
        }
        (Answered::Guided(search), plan, _) => {
            job.update(|r| r.by_guided_search = true);
            without_states(job, questions, judging::guided(&search));
            match (plan, questions) {
                (Some((plan, Some(out))), [(asking, _)]) => {
                    plan.of_search(job, &search, program, asking, out)
                }
                _ => Ok(()),
            }
        }
    }
}

/// The way in which questions were answered.
enum Answered {
    /// By an engine that knows all states; the answers are in the report.
    ByStates(Arc<AnyEngine>),
    /// Over all valuations, with the policy that was asked for, if there is one.
    Everywhere(Judged, Option<Box<Option<Policy>>>),
    Guided(Box<Guided>),
}

/// Adds an answer that was found before the states were known.
fn without_states(job: &Job<ReachReport>, questions: &[(&Asking, usize)], judged: Judged) {
    let Judged { answer, initial, peak_nodes } = judged;
    job.update(|r| {
        questions.iter().for_each(|&(_, position)| r.answer(position, &answer));
        if let Some(one) = &mut r.one {
            one.initial = initial;
        }
        r.memory.peak_nodes = r.memory.peak_nodes.max(peak_nodes);
    });
}

/// Answers properties of one program. Regions go to `kept`, if there is a list. Returns the unsafe states
/// under requirements.
fn answer<E: Engine>(
    job: &Job<ReachReport>,
    engine: &E,
    asked: &Asked,
    questions: &[(&Asking, usize)],
    given: &Given<'_>,
    kept: &mut Option<Found<E::States>>,
) -> Result<Option<E::States>, Error> {
    let Some((first, _)) = questions.first() else {
        let all = engine.all_states();
        let counts =
            job.timed("count", || ModelCounts::within(engine, &all), |r, s| r.time.add("build", s))?;
        job.update(|r| r.counts = Some(counts));
        return Ok(None);
    };
    let under = Under::new(engine, &asked.program, &first.goal)?;
    let counts = job.timed("count", || under.counts(&first.goal), |r, s| r.time.add("build", s))?;
    let mut known = false;
    job.update(|r| known = r.counts.is_some());
    if !known {
        engines::warn_of_states(
            &job.sink,
            engine,
            &asked.program,
            &counts.deadlocks,
            asked.overlap.as_ref(),
        )?;
        job.update(|r| (r.counts, r.escape) = (Some(counts), under.escape.clone()));
    }
    for questions in by_coalition(questions) {
        let (first, _) = questions[0];
        let played = first.played(engine)?;
        let own = played.as_ref().map(|game| Under::new(game, &asked.program, &first.goal)).transpose()?;
        let answering = Answering { job, given, under: own.as_ref().unwrap_or(&under), asked };
        answering.all(&questions, kept)?;
    }
    Ok(under.unsafe_states().cloned())
}

/// Separates the properties of a game by the players who choose.
fn by_coalition<'a>(questions: &[(&'a Asking, usize)]) -> Vec<Vec<(&'a Asking, usize)>> {
    let mut all: Vec<Vec<(&Asking, usize)>> = Vec::new();
    for &question in questions {
        match all.iter_mut().find(|own| own[0].0.coalition == question.0.coalition) {
            Some(own) => own.push(question),
            None => all.push(vec![question]),
        }
    }
    all
}

/// Properties with the same goal.
struct Group<'a, E: Engine> {
    /// The properties, with their positions in the report.
    members: Vec<(&'a Asking, usize)>,
    /// The regions that they need.
    order: Vec<Which>,
    search: RegionSearch<'a, E>,
    /// The states whose paths are judged.
    judged: E::States,
}

/// Groups properties by their goals, in the order of the first of each.
fn groups<'a, E: Engine>(
    engine: &'a E,
    program: &Arc<Program>,
    questions: &[(&'a Asking, usize)],
) -> Result<Vec<Group<'a, E>>, Error> {
    let same = |a: &Asking, b: &Asking| match (&a.goal.target, &b.goal.target) {
        (reach::Target::States(one), reach::Target::States(other)) => one.is_same(other),
        _ => false,
    };
    let mut groups: Vec<Group<'a, E>> = Vec::new();
    // The groups by the fingerprints of their targets.
    let mut known: AHashMap<u64, Vec<usize>> = AHashMap::new();
    for &(asking, position) in questions {
        let alike = match &asking.goal.target {
            reach::Target::States(target) => Some(known.entry(target.fingerprint()).or_default()),
            _ => None,
        };
        let same = |&&group: &&usize| same(groups[group].members[0].0, asking);
        match alike.as_ref().and_then(|alike| alike.iter().find(same).copied()) {
            Some(group) => groups[group].members.push((asking, position)),
            None => {
                alike.into_iter().for_each(|alike| alike.push(groups.len()));
                let (search, judged) = (asking.goal.search(engine)?, asking.goal.judged(engine)?);
                groups.push(Group { members: vec![(asking, position)], order: Vec::new(), search, judged });
            }
        }
    }
    for group in &mut groups {
        let needed: Vec<Which> = group.members.iter().flat_map(|(q, _)| q.needed(program)).collect();
        group.order = group.search.order(&needed);
    }
    Ok(groups)
}

struct Answering<'a, E: Engine> {
    job: &'a Job<ReachReport>,
    given: &'a Given<'a>,
    under: &'a Under<'a, E>,
    asked: &'a Asked,
}

impl<E: Engine> Answering<'_, E> {
    /// Answers properties of the same players. Regions go to `kept`, if there is a list.
    fn all(&self, questions: &[(&Asking, usize)], kept: &mut Option<Found<E::States>>) -> Result<(), Error> {
        let mut groups = groups(self.under.engine(), &self.asked.program, questions)?;
        if let ([group], true) = (&mut groups[..], self.given.is_one) {
            self.target(group)?;
        }
        for round in 0..Which::ALL.len() {
            for group in &mut groups {
                let Some((which, states)) = self.find(group, round)? else { continue };
                if let Some(kept) = kept {
                    let found = |(_, position): &(_, usize)| (*position, which, states.clone());
                    kept.extend(group.members.iter().map(found));
                }
            }
            groups.retain(|group| self.is_left(group) || round + 1 < group.order.len());
        }
        let mut shares = self.shares(&groups);
        groups.iter().try_for_each(|group| self.values(group, &mut shares))
    }

    /// Returns whether more than the regions is to be computed for some of the properties.
    fn is_left(&self, group: &Group<'_, E>) -> bool {
        group.members.iter().any(|(asking, _)| self.has_value(asking))
    }

    /// Returns whether a question is answered after the regions: one that asks for a number, and the property of a
    /// run with one question.
    fn has_value(&self, asking: &Asking) -> bool {
        asking.asks_for_number() || self.given.is_one && asking.question.is_some()
    }

    /// Counts the states of the target of one question.
    fn target(&self, group: &mut Group<'_, E>) -> Result<(), Error> {
        if !matches!(group.members[0].0.goal.target, reach::Target::States(_)) {
            return Ok(());
        }
        let engine = self.under.engine();
        // The goal has states with monitors that are not fresh, which stand for the same model state.
        let own = engine.intersection(&engine.all_states(), &group.judged)?;
        let size = engine.count(&engine.intersection(&group.search.goal()?, &own)?)?;
        if size == Count::ZERO {
            self.job.sink.warn("no state satisfies the target");
        }
        self.job.update(|r| r.one.iter_mut().for_each(|one| one.target = Some(size.clone().into())));
        Ok(())
    }

    /// Computes the region of a round, and adds it and the decided verdicts to the report. Returns it within
    /// the states that are judged; `None` if no region is left.
    fn find(&self, group: &mut Group<'_, E>, round: usize) -> Result<Option<(Which, E::States)>, Error> {
        let Some(&which) = group.order.get(round) else { return Ok(None) };
        let region = || group.search.region(which);
        let states = self.job.timed(which.formula(), region, |r, s| r.time.add(which.name(), s))?;
        let engine = self.under.engine();
        let inside = engine.intersection(&states, &group.judged)?;
        let size = engine.count(&inside)?;
        let share = self.given.is_one.then(|| Share::of_initial(engine, &inside)).transpose()?;
        self.job.update(|r| {
            if let Some(one) = &mut r.one {
                *one.sizes.get_mut(which) = Some(size.clone().into());
                *one.initial.get_mut(which) = share;
            }
        });
        for &(asking, position) in &group.members {
            let decided = self.under.decided(asking, &self.asked.program, group.search.known())?;
            self.job.update(|r| {
                r.answer(position, &decided);
                *r.properties[position].sizes.get_mut(which) = Some(size.clone().into());
                r.used(engine.usage());
            });
        }
        Ok(Some((which, inside)))
    }

    /// Returns the shares of the properties for which the regions are not enough, and of what follows them.
    fn shares(&self, groups: &[Group<'_, E>]) -> Shares<'_> {
        let members = groups.iter().flat_map(|group| &group.members);
        let values = members.filter(|(asking, _)| self.has_value(asking)).count();
        // A formula with monitors is alone, and has its share already.
        let is_plain = groups.iter().any(|group| group.members.iter().any(|(q, _)| q.goal.watched.is_none()));
        Shares::of(&self.job.sink, values + if is_plain { later(self.asked) } else { 0 })
    }

    /// Answers the properties for which the regions are not enough.
    fn values(&self, group: &Group<'_, E>, shares: &mut Shares<'_>) -> Result<(), Error> {
        for &(asking, position) in group.members.iter().filter(|(asking, _)| self.has_value(asking)) {
            let (program, known, mut partial) = (&self.asked.program, group.search.known(), None);
            let answer = || {
                let mut answer = self.under.answer(asking, program, known, self.given.precision)?;
                let end = std::mem::replace(&mut answer.end, Ok(()));
                // A number of a game that is not supported leaves the others.
                let leaves = answer.no_value.is_some() && !self.given.is_one;
                partial = Some(answer);
                if leaves { Ok(()) } else { end }
            };
            let work = || Ok(shares.next(answer));
            let done = self.job.timed("value", work, |r, s| r.time.add("value", s))?;
            self.job.update(|r| {
                partial.iter().for_each(|answer| r.answer(position, answer));
                r.used(self.under.engine().usage());
            });
            let reason = match done {
                Ok(Ok(())) => continue,
                Ok(Err(reason)) => reason,
                // A wrong reward.
                Err(error @ Error::Input(_)) if self.asked.is_list => Refusal::of(&error).reason,
                Err(error) => return Err(error),
            };
            self.job.update(|r| r.properties[position].reason = Some(reason));
        }
        Ok(())
    }
}

/// Returns the number of shares of what follows the properties without monitors.
fn later(asked: &Asked) -> usize {
    let watched = asked.questions.iter().filter(|q| q.asking.goal.watched.is_some()).count();
    watched + usize::from(!asked.terms.is_empty())
}
