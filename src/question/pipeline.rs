//! Answers questions about a model: a target, or properties.
//!
//! A plan says which requests about the initial states the properties need. A request that is decided without numbers
//! is answered by the first of several ways to end, some of which do not need all states. The others share one engine,
//! and a temporal formula has its own, with its monitors. The rest is evaluated over all states. A limit that one
//! question meets leaves the others as many answers as possible.

use std::cell::OnceCell;
use std::sync::Arc;

use crate::answer::Answer;
use crate::answering::{self, Answering, Judged, Known};
use crate::answers::Plan as Plans;
use crate::asking::Asking;
use crate::evaluate::{self, Mix, PropertyPolicy};
use crate::goal::{PathGoal, Target};
use crate::listener::{Listener, Shares};
use crate::number::Number;
use crate::plan::Planned;
use crate::questions::{Options, PolicyKind, Questions, Strategies};
use crate::race::{Early, Job, Raced, started};
use crate::strategies::{self, Optimal};
use crate::warnings::Warning;
use meliora_base::error::{Error, Limit, Result};
use meliora_engine::{
    AnyEngine, Engine, ExplicitEngine, Guided, Selection, Settings, Storage, SymbolicEngine,
};
use meliora_lang::property::{Over, PropertyKind};
use meliora_model::Program;
use meliora_planning::policy::Policy;

/// Answers all questions; the listener has the answers so far.
///
/// # Errors
/// A limit is reached; a question of one, or one that has no meaning for the initial states.
pub fn answer<J: Job + Listener>(job: &J, options: &Options, asked: &Questions) -> Result<Strategies> {
    let requests = asked.plan.requests.len();
    let wants_strategy = asked.wants_optimal(options.strategies);
    let keeps_choices = wants_strategy || asked.plan.asks_for_rewards();
    let keeps_probabilities = wants_strategy || asked.plan.asks_for_numbers();
    let settings = Settings { keeps_choices, keeps_probabilities, ..options.settings.clone() };
    let options = &Options { settings, ..options.clone() };
    let mut work = Work {
        job,
        options,
        asked,
        known: vec![None; requests],
        done: vec![false; requests],
        failed: Vec::new(),
        closed: Vec::new(),
        engine: None,
        strategies: Strategies::default(),
        has_optimal: false,
    };
    work.begin();
    work.early()?;
    work.watched()?;
    work.rest()?;
    work.note_plans();
    work.optimal()?;
    job.ended_share().map_or(Ok(work.strategies), |limit| Err(limit.into()))
}

/// The way in which a request was answered.
enum Answered {
    /// By an engine that knows all states, these requests; the answers are in the report.
    ByStates(Arc<AnyEngine>, Vec<usize>, Box<Found>),
    /// Over all valuations, with the policy that was asked for, if there is one.
    Everywhere(Judged, Option<Box<Policy>>),
    Guided(Box<Guided>),
}

/// The decisions about all requests, and the strategies that were found on the way to them.
struct Found {
    known: Known,
    mix: Option<Mix>,
    optimal: Option<Optimal>,
}

/// The questions, and the decisions so far.
struct Work<'a, J> {
    job: &'a J,
    options: &'a Options,
    asked: &'a Questions,
    known: Known,
    /// The requests that were answered with all states, as far as limits allow.
    done: Vec<bool>,
    /// The requests that met a limit in their part of the time. They are tried again with all states.
    failed: Vec<(usize, Limit)>,
    /// The properties that are given up.
    closed: Vec<usize>,
    /// The engine of the model, once it knows all states.
    engine: Option<Arc<AnyEngine>>,
    strategies: Strategies,
    /// True once the strategies of one operator are known.
    has_optimal: bool,
}

impl<J: Job + Listener> Work<'_, J> {
    fn listener(&self) -> &dyn Listener {
        self.job
    }

    /// Notes the answers that the values of the variables in the initial state decide.
    fn begin(&self) {
        let plan = &self.asked.plan;
        for (at, property) in plan.properties.iter().enumerate() {
            let holds = plan.holds(&self.asked.program, at, &self.known);
            if property.request().is_none() && holds.is_some() {
                self.listener().update(|r| r.answer(property.position, &Answer::of(holds)));
            }
        }
    }

    /// Answers the requests about the model itself that are decided without numbers, one after the other, until all
    /// states are known. Each has half of the time that is left, if there is other work.
    fn early(&mut self) -> Result<()> {
        let requests = &self.asked.plan.requests;
        let is_own = |at: &usize| requests[*at].asking.goal.watched.is_none() && self.is_early(*at);
        let mut open: Vec<usize> = (0..requests.len()).filter(is_own).collect();
        let has_more = self.asked.plan.properties.len() > 1 || requests.len() > 1;
        loop {
            open.retain(|&at| self.is_needed(at));
            let (Some(&first), None) = (open.first(), &self.engine) else { return Ok(()) };
            self.job.share(has_more.then_some(1));
            let found = self.race(&self.asked.program, &self.left(), Some(first), false);
            self.job.share(None);
            match found {
                Ok(answered) => self.take(first, answered)?,
                Err(Error::Limit(limit)) if has_more && Listener::stop(self.job).is_none() => {
                    self.failed.push((first, limit));
                }
                Err(error) => return Err(error),
            }
            // An early answer may say nothing of some initial states.
            open.retain(|&at| at != first);
        }
    }

    /// Answers the requests about models with monitors.
    fn watched(&mut self) -> Result<()> {
        let plan = &self.asked.plan;
        let is_watched = |at: &usize| plan.requests[*at].asking.goal.watched.is_some();
        let all: Vec<usize> = (0..plan.requests.len()).filter(is_watched).collect();
        let mut shares = Shares::of(self.job, all.len() + usize::from(self.has_rest()));
        let own = self.engine.take().filter(|_| self.has_rest());
        for at in all {
            let Some(watched) = &plan.requests[at].asking.goal.watched else { continue };
            let mut needing = plan.requests[at].properties.iter().map(|&at| &plan.properties[at]);
            let is_needed = self.is_needed(at) && !needing.all(|property| self.needs_no_monitors(property));
            let early = self.is_early(at).then_some(at);
            let race = || is_needed.then(|| self.race(&watched.program, &[at], early, false)).transpose();
            match shares.next(race)? {
                Ok(None) => {}
                Ok(Some(answered)) => self.take(at, answered)?,
                Err(reason) => self.give_up(at, &reason),
            }
        }
        self.engine = own;
        Ok(())
    }

    /// Answers the rest with all states.
    fn rest(&mut self) -> Result<()> {
        let requests = self.left();
        let is_done = !self.has_rest() && !self.asked.plan.properties.is_empty();
        if !is_done {
            match &self.engine {
                Some(engine) => {
                    let Found { known, optimal, .. } = self.by_states(self.job, engine, &requests, true)?;
                    self.known = known;
                    self.found_optimal(optimal);
                    requests.into_iter().for_each(|at| self.done[at] = true);
                }
                None => {
                    let answered = self.race(&self.asked.program, &requests, None, true)?;
                    self.take(requests.first().copied().unwrap_or_default(), answered)?;
                }
            }
        }
        for (at, limit) in std::mem::take(&mut self.failed) {
            if self.is_needed(at) {
                let ended = Shares::of(self.job, 2).next(|| Err::<(), _>(limit.into()))?;
                ended.unwrap_or_else(|reason| self.give_up(at, &reason));
            }
        }
        Ok(())
    }

    /// Returns the requests about the model itself that have no answer.
    fn left(&self) -> Vec<usize> {
        let requests = &self.asked.plan.requests;
        let is_own = |at: &usize| requests[*at].asking.goal.watched.is_none();
        (0..requests.len()).filter(|at| is_own(at) && self.is_needed(*at)).collect()
    }

    /// Returns whether some questions need all states.
    fn has_rest(&self) -> bool {
        let plan = &self.asked.plan;
        !self.left().is_empty() || (0..plan.properties.len()).any(|at| self.is_open(at))
    }

    /// Returns whether a property has no answer yet, and is evaluated over all states unless its requests decide it.
    fn is_open(&self, property: usize) -> bool {
        let plan = &self.asked.plan;
        (plan.properties[property].request().is_none() || self.needs_no_monitors(&plan.properties[property]))
            && !self.closed.contains(&property)
            && plan.holds(&self.asked.program, property, &self.known).is_none()
    }

    /// Returns whether the answer to a request is needed: some property has none without it.
    fn is_needed(&self, request: usize) -> bool {
        let plan = &self.asked.plan;
        if self.done[request] {
            return false;
        }
        let is_known = self.known[request].is_some_and(|known| known.holds().is_some());
        let of_property = |at: &usize| match plan.properties[*at].request() {
            Some(_) => !is_known,
            None => self.known[request].is_none() && self.is_open(*at),
        };
        plan.requests[request].properties.iter().any(of_property)
    }

    /// Returns whether a request may be answered before all states are known: it holds or not in the initial states, and
    /// no strong plan is asked for. In a `dtmc`, the states are needed to warn of those in which several choices are merged.
    fn is_early(&self, request: usize) -> bool {
        let asking = &self.asked.plan.requests[request].asking;
        let holds_or_not =
            matches!((&asking.question, asking.over), (Some(PropertyKind::Qualitative(..)), Over::All));
        let is_plain = asking.goal.requirements.is_empty() && self.asked.overlap.is_none();
        holds_or_not && is_plain && !self.options.strategies.strong
    }

    /// Lets the ways to answer some requests race; one of them may have an early answer. With all states, the properties
    /// that are left are answered, too, if `rest` says so.
    fn race(
        &self,
        program: &Arc<Program>,
        requests: &[usize],
        early: Option<usize>,
        rest: bool,
    ) -> Result<Answered> {
        let plan = &self.asked.plan;
        let asks_for_number = |at: &usize| plan.requests[*at].asking.asks_for_number();
        let lists_states = self.left().iter().any(asks_for_number)
            || requests.iter().any(asks_for_number)
            || (0..plan.properties.len()).any(|at| self.is_open(at));
        let alone = early.map(|at| &plan.requests[at].asking);
        let target = alone.filter(|asking| asking.coalition.is_none()).and_then(Asking::reached_surely);
        let wants_policy = self.wants(PolicyKind::Rules);
        let over_all = alone.filter(|_| !wants_policy || target.is_some()).map(|asking| {
            move |engine: &SymbolicEngine| {
                let judged = answering::judge(engine, asking, &self.asked.program, program)?;
                // It visits reachable states only, whatever the engine knows.
                let policy = target.filter(|_| wants_policy);
                let policy = policy.map(|target| strategies::policy(engine, program, target)).transpose()?;
                Ok(Answered::Everywhere(judged, policy.flatten().map(Box::new)))
            }
        });
        let by_search = |search: Guided| Ok(Answered::Guided(Box::new(search)));
        let early = Early {
            everywhere: over_all.as_ref().map(|ask| ask as _),
            guided: target.map(|target| (target, &by_search as _)),
        };
        let by_states = |job: &J, engine: &Arc<AnyEngine>| {
            let found = self.by_states(job, engine, requests, rest)?;
            Ok(Answered::ByStates(Arc::clone(engine), requests.to_vec(), Box::new(found)))
        };
        let (settings, selected) = (&self.options.settings, self.options.selected.clone());
        let raced = |selected: Selection| {
            let early = Early { everywhere: early.everywhere, guided: early.guided };
            Raced { program, settings, selected, lists_states, early, answer: &by_states }.run(self.job)
        };
        if !(selected.is_open && strategies::has_states(self.asked, self.options, requests)) {
            return raced(selected);
        }
        // Only a list of the states has the strategy, too. Where it does not fit, diagrams may have the answer alone.
        let reason = Some("the strategy needs a list of the states".to_owned());
        match raced(Selection { storage: Storage::Explicit, reason, is_open: false }) {
            Err(Error::Limit(_)) if Listener::stop(self.job).is_none() => raced(selected),
            found => found,
        }
    }

    /// Answers some requests with an engine that knows all states, and then the properties that are left if `rest` says
    /// so. A strategy that is asked for is found first, with the numbers of the answer.
    fn by_states(
        &self,
        listener: &dyn Listener,
        engine: &Arc<AnyEngine>,
        requests: &[usize],
        rest: bool,
    ) -> Result<Found> {
        let explicit =
            engine.explicit().filter(|_| strategies::has_states(self.asked, self.options, requests));
        let optimal = OnceCell::new();
        let goal = strategies::watched_goal(self.asked, requests);
        let find = explicit
            .map(|explicit| || optimal.get_or_init(|| self.strategies_on(listener, (explicit, goal))));
        let numbers = find.as_ref().map(|find| || find().as_ref().ok()?.optima.clone());
        let optima = numbers.as_ref().map(|numbers| numbers as &dyn Fn() -> Option<Vec<evaluate::Number>>);
        let answering = Answering::new(listener, self.options, self.asked, self.known.clone());
        let open =
            Vec::from_iter((0..self.asked.plan.properties.len()).filter(|at| rest && self.is_open(*at)));
        let is_all = open.is_empty() && find.is_none();
        let answering = Answering { optima, is_all, ..answering };
        if !requests.is_empty() || self.asked.plan.properties.is_empty() {
            answering.requests(&**engine, requests, &mut None)?;
        }
        let build = |program: &Arc<Program>| {
            let build = || started(AnyEngine::new(Arc::clone(program), engine.settings().clone())?, program);
            listener.timed(("build", "build"), build)
        };
        let mix = answering.rest(engine, &build, &open, self.wants(PolicyKind::Mix))?;
        let known = answering.known();
        // Regions that decide the answer need no numbers, and a limit leaves these.
        find.iter().for_each(|find| _ = find());
        Ok(Found { known, mix, optimal: optimal.into_inner().transpose()? })
    }

    /// Returns whether a policy of some kind is asked for.
    fn wants(&self, kind: PolicyKind) -> bool {
        self.options.strategies.policy && self.asked.policy_kind() == kind
    }

    /// Returns whether a property is answered over the states of the model, although its request has monitors.
    fn needs_no_monitors(&self, property: &Planned) -> bool {
        let requests = &self.asked.plan.requests;
        let is_number = |at: usize| requests[at].asking.is_number() && !self.options.regions;
        (self.asked.wants_optimal(self.options.strategies) || property.request().is_some_and(is_number))
            && strategies::needs_no_monitors(property, requests)
    }

    /// Computes the strategies of one operator that are asked for, unless they are known.
    fn optimal(&mut self) -> Result<()> {
        if !self.asked.wants_optimal(self.options.strategies) || self.has_optimal {
            return Ok(());
        }
        let (program, settings) = (&self.asked.program, &self.options.settings);
        let engine = match self.engine.take() {
            Some(engine) if engine.explicit().is_some() => engine,
            _ => {
                let build = || started(ExplicitEngine::new(Arc::clone(program), settings.clone())?, program);
                let built = self.listener().timed(("build", "build"), build)?;
                Arc::new(AnyEngine::Explicit(built))
            }
        };
        let Some(engine) = engine.explicit() else { return Ok(()) };
        let found = self.strategies_on(self.listener(), (engine, None))?;
        self.found_optimal(Some(found));
        Ok(())
    }

    /// Computes the strategies of one operator with the states of the model, or of the model with the monitors of a goal.
    fn strategies_on(
        &self,
        listener: &dyn Listener,
        states: (&Arc<ExplicitEngine>, Option<&PathGoal>),
    ) -> Result<Optimal> {
        listener.timed(("policy", "policy"), || strategies::optimal(self.asked, states, self.options))
    }

    /// Notes the strategies of one operator.
    fn found_optimal(&mut self, found: Option<Optimal>) {
        let Some(Optimal { both: [own, opponent], .. }) = found else { return };
        self.has_optimal = true;
        let missed = |own: &&PropertyPolicy| !own.is_attained(self.options.precision);
        for own in [&own, &opponent].into_iter().flatten().filter(missed) {
            self.listener().warn(Warning::Text(strategies::missed(own)));
        }
        (self.strategies.optimal, self.strategies.opponent) = (own, opponent);
    }

    /// Takes the answer to a request.
    fn take(&mut self, request: usize, answered: Answered) -> Result<()> {
        let asking = self.asked.plan.requests.get(request).map(|request| &request.asking);
        match answered {
            Answered::ByStates(engine, requests, found) => {
                let Found { known, mix, optimal } = *found;
                self.known = known;
                requests.into_iter().for_each(|at| self.done[at] = true);
                self.strategies.mix = mix;
                self.found_optimal(optimal);
                if let Some(asking) = asking {
                    self.strategies_of(&engine, asking)?;
                }
                self.engine = Some(engine);
            }
            Answered::Everywhere(judged, policy) => {
                self.listener().update(|r| r.over_all_valuations = true);
                self.note(request, judged);
                self.found(policy.map(|policy| *policy));
            }
            Answered::Guided(search) => {
                self.listener().update(|r| r.by_guided_search = true);
                if let Some(asking) = asking {
                    self.note(request, answering::guided(&search, asking));
                    if let (true, Target::States(target)) =
                        (self.wants(PolicyKind::Rules), &asking.goal.target)
                    {
                        let program = asking.goal.program(&self.asked.program);
                        let sink = self.job.sink();
                        let find = || strategies::of_search(&search, program, target, &*sink);
                        let policy = self.listener().timed(("policy", "policy"), find)?;
                        self.found(policy);
                    }
                }
            }
        }
        Ok(())
    }

    /// Computes the strategies that are wanted for a target.
    fn strategies_of(&mut self, engine: &AnyEngine, asking: &Asking) -> Result<()> {
        let Target::States(target) = &asking.goal.target else { return Ok(()) };
        if self.options.strategies.strong {
            let find = || strategies::strong(engine, target);
            let (exists, states) = self.listener().timed(("strong", "strong"), find)?;
            self.plan(|plan| (plan.strong, plan.strong_states) = (Some(exists), Some(states)));
        }
        if self.wants(PolicyKind::Rules) {
            let program = asking.goal.program(&self.asked.program);
            let find = || strategies::policy(engine, program, target);
            let policy = self.listener().timed(("policy", "policy"), find)?;
            self.found(policy);
        }
        Ok(())
    }

    /// Notes a policy, or that there is none, if it was asked for.
    fn found(&mut self, policy: Option<Policy>) {
        if self.wants(PolicyKind::Rules) {
            let states = policy.as_ref().map(|found| Number::from(found.entries.len() as u64));
            self.plan(|plan| {
                (plan.strong_cyclic, plan.policy_states) = (Some(policy.is_some()), states);
            });
            self.strategies.policy = policy;
        }
    }

    fn plan(&self, change: impl FnOnce(&mut Plans)) {
        self.listener().update(|r| {
            if let Some(one) = &mut r.one {
                change(one.plan.get_or_insert_default());
            }
        });
    }

    /// Adds an answer that was found before the states were known.
    fn note(&mut self, request: usize, judged: Judged) {
        let Judged { answer, decision, initial, usage } = judged;
        self.known[request] = Some(decision);
        self.listener().update(|r| {
            if let Some(one) = r.one.as_mut().filter(|_| self.asked.plan.alone(request).next().is_some()) {
                one.initial = initial;
            }
            answering::add(r, self.asked, request, &answer, &self.known);
        });
        usage.into_iter().for_each(|usage| self.job.used(usage));
    }

    /// Says whether a strong cyclic plan exists, wherever this is asked.
    fn note_plans(&self) {
        let (plan, program) = (&self.asked.plan, &self.asked.program);
        let Some((_, goal)) =
            program.labels.iter().find(|(name, _)| program.planning.is_some() && name == "goal")
        else {
            return;
        };
        let goal = program.predicate(*goal);
        for (request, known) in plan.requests.iter().zip(&self.known) {
            let is_goal = request.asking.reached_surely().is_some_and(|target| target.is_same(&goal));
            let known = known.filter(|_| is_goal && request.asking.goal.requirements.is_empty());
            let exists = known.map(|known| if request.asking.is_inside() { known.all } else { known.none });
            let Some(exists) = exists.flatten() else { continue };
            self.listener().update(|r| {
                let positions = request.properties.iter().map(|&at| plan.properties[at].position);
                match &mut r.one {
                    Some(one) => one.plan.get_or_insert_default().strong_cyclic = Some(exists),
                    None => positions.for_each(|at| r.properties[at].strong_cyclic = Some(exists)),
                }
            });
        }
    }

    /// Notes the reason why the properties that need a request have no answer.
    fn give_up(&mut self, request: usize, reason: &str) {
        let needs = self.asked.plan.requests[request].properties.iter().copied();
        let open: Vec<usize> = needs
            .filter(|&at| self.asked.plan.properties[at].request().is_some() || self.is_open(at))
            .collect();
        self.listener().update(|r| {
            for &at in &open {
                r.properties[self.asked.plan.properties[at].position].reason = Some(reason.to_owned());
            }
        });
        self.closed.extend(open);
    }
}
