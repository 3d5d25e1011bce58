//! Answers the questions of `meliora reach`: a target, or properties.
//!
//! A plan says which requests about the initial states the properties need. A request that is decided without numbers
//! is answered by the first of several ways to end, some of which do not need all states. The others share one engine,
//! and a temporal formula has its own, with its monitors. The rest is evaluated over all states. A limit that one
//! question meets leaves the others as many answers as possible.

use std::sync::Arc;

use meliora_base::error::{Error, Limit};
use meliora_engine::{AnyEngine, Guided, ProgressSink, Selection, SymbolicEngine};
use meliora_lang::property::term::TermKind;
use meliora_lang::property::{Over, Question};
use meliora_model::Program;
use meliora_planning::policy::Policy;
use meliora_quantities::answer::Answer;
use meliora_question::Asking;
use meliora_question::plan::Decision;
use meliora_report::ReachReport;

use super::answers::{self, Answering, Judged};
use super::asked::Asked;
use super::engines::{self, Early, Request};
use super::files::Target;
use super::given::Given;
use super::policy;
use super::regions::{Regions, Shown};
use super::shares::Shares;
use super::supervise::Job;

/// The decisions about the requests so far.
pub(super) type Known = Vec<Option<Decision>>;

/// Answers all questions.
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
    if let Some(out) = &given.out {
        return write_regions(job, given, out, asked);
    }
    let mix = mix(given, asked)?;
    let (known, failed, closed) = (vec![None; asked.plan.requests.len()], Vec::new(), Vec::new());
    let done = vec![false; asked.plan.requests.len()];
    let mut work = Work { job, given, asked, selected, mix, known, done, failed, closed, engine: None };
    work.begin();
    work.early()?;
    work.watched()?;
    work.rest()?;
    work.note_plans();
    job.sink.ended_share()
}

/// Writes the regions of the questions, answered with one engine of diagrams.
fn write_regions(
    job: &Job<ReachReport>,
    given: &Given<'_>,
    out: &Regions<'_>,
    asked: &Asked,
) -> Result<(), Error> {
    Regions::check(asked)?;
    let requests = Vec::from_iter(0..asked.plan.requests.len());
    let first = asked.plan.requests.first();
    let program = first.map_or(&asked.program, |first| first.asking.goal.program(&asked.program));
    let symbolic = |program: &Arc<Program>| {
        job.timed(
            "build",
            || engines::symbolic(program, given.model, &job.sink),
            |r, s| r.time.add("build", s),
        )
    };
    let engine = symbolic(program)?;
    let answering = Answering::new(job, given, asked, vec![None; requests.len()]);
    let mut kept = Some(Vec::new());
    let unsafe_states = answering.requests(&*engine, &requests, &mut kept)?;
    let mut shown = Vec::new();
    for request in requests {
        let asking = &asked.plan.requests[request].asking;
        shown.extend(asked.plan.alone(request).map(|at| (at, Shown::Paths(asking, request))));
    }
    answering.satisfied(&engine, &symbolic, &mut |at, states| shown.push((at, Shown::Satisfied(states))))?;
    let mut named = Vec::new();
    job.update(|r| {
        named.extend(shown.into_iter().map(|(at, shown)| {
            let position = asked.plan.properties[at].position;
            let property = &r.properties[position];
            (position, shown, (property.name.clone(), property.property.clone()))
        }));
    });
    let found = kept.unwrap_or_default();
    let write = || out.write(&engine, asked, named, &found, unsafe_states.as_ref(), &job.sink);
    let written = job.timed("write", write, |_, _| ())?;
    job.update(|r| r.written = Some(written));
    job.sink.ended_share()
}

/// Returns the file of `--policy`, for the strategies of one property `multi(…)`.
///
/// # Errors
/// The options about plans are given, and the only property is another one than an operator.
fn mix<'t>(given: &Given<'t>, asked: &Asked) -> Result<Option<&'t Target>, Error> {
    let Some((plan, target)) = given.plan else { return Ok(None) };
    let Some(only) = asked.plan.properties.first().filter(|only| only.request().is_none()) else {
        return Ok(None);
    };
    let is_mix = matches!(&only.stated, Some((_, term)) if matches!(term.kind, TermKind::Multi(_)));
    match (is_mix && !plan.strong, target) {
        (true, Some(target)) if plan.is_json() || target.is_stdout() => Ok(Some(target)),
        (true, _) => Err(Error::Usage(
            "the strategies of `multi` are written as JSON: give `--policy` a name that ends with .json"
                .to_owned(),
        )),
        (false, _) => Err(Error::Usage(
            "`--strong` and `--policy` are about reaching a target, not about other formulas".to_owned(),
        )),
    }
}

/// The way in which a request was answered.
enum Answered {
    /// By an engine that knows all states, these requests; the answers are in the report. With the strategies of `multi`.
    ByStates(Arc<AnyEngine>, Vec<usize>, Known, Option<String>),
    /// Over all valuations, with the policy that was asked for, if there is one.
    Everywhere(Judged, Option<Box<Option<Policy>>>),
    Guided(Box<Guided>),
}

/// The questions, and the decisions so far.
struct Work<'a> {
    job: &'a Job<ReachReport>,
    given: &'a Given<'a>,
    asked: &'a Asked,
    selected: Selection,
    /// The file for the strategies of `multi`.
    mix: Option<&'a Target>,
    known: Known,
    /// The requests that were answered with all states, as far as limits allow.
    done: Vec<bool>,
    /// The requests that met a limit in their part of the time. They are tried again with all states.
    failed: Vec<(usize, Limit)>,
    /// The properties that are given up.
    closed: Vec<usize>,
    /// The engine of the model, once it knows all states.
    engine: Option<Arc<AnyEngine>>,
}

impl Work<'_> {
    /// Notes the answers that the values of the variables in the initial state decide.
    fn begin(&self) {
        let plan = &self.asked.plan;
        for (at, property) in plan.properties.iter().enumerate() {
            let holds = plan.holds(&self.asked.program, at, &self.known);
            if property.request().is_none() && holds.is_some() {
                self.job.update(|r| r.answer(property.position, &Answer::of(holds)));
            }
        }
    }

    /// Answers the requests about the model itself that are decided without numbers, one after the other, until all
    /// states are known. Each has half of the time that is left, if there is other work.
    fn early(&mut self) -> Result<(), Error> {
        let requests = &self.asked.plan.requests;
        let is_own = |at: &usize| requests[*at].asking.goal.watched.is_none() && self.is_early(*at);
        let mut open: Vec<usize> = (0..requests.len()).filter(is_own).collect();
        let has_more = self.asked.plan.properties.len() > 1 || requests.len() > 1;
        loop {
            open.retain(|&at| self.is_needed(at));
            let (Some(&first), None) = (open.first(), &self.engine) else { return Ok(()) };
            self.job.sink.share(has_more.then_some(1));
            let found = self.race(&self.asked.program, &self.left(), Some(first), false);
            self.job.sink.share(None);
            match found {
                Ok(answered) => self.take(first, answered)?,
                Err(Error::Limit(limit)) if has_more && self.job.sink.stop().is_none() => {
                    self.failed.push((first, limit));
                }
                Err(error) => return Err(error),
            }
            // An early answer may say nothing of some initial states.
            open.retain(|&at| at != first);
        }
    }

    /// Answers the requests about models with monitors.
    fn watched(&mut self) -> Result<(), Error> {
        let plan = &self.asked.plan;
        let is_watched = |at: &usize| plan.requests[*at].asking.goal.watched.is_some();
        let all: Vec<usize> = (0..plan.requests.len()).filter(is_watched).collect();
        let mut shares = Shares::of(&self.job.sink, all.len() + usize::from(self.has_rest()));
        let own = self.engine.take().filter(|_| self.has_rest());
        for at in all {
            let Some(watched) = &plan.requests[at].asking.goal.watched else { continue };
            let is_needed = self.is_needed(at);
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
    fn rest(&mut self) -> Result<(), Error> {
        let requests = self.left();
        let is_done = !self.has_rest() && !self.asked.plan.properties.is_empty();
        if !is_done {
            match &self.engine {
                Some(engine) => {
                    let (known, _) = self.by_states(self.job, engine, &requests, true)?;
                    self.known = known;
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
                let ended = Shares::of(&self.job.sink, 2).next(|| Err::<(), _>(limit.into()))?;
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
        plan.properties[property].request().is_none()
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
            matches!((&asking.question, asking.over), (Some(Question::Qualitative(..)), Over::All));
        let is_plain = asking.goal.requirements.is_empty() && self.asked.overlap.is_none();
        holds_or_not && is_plain && self.given.plan.is_none_or(|(plan, _)| !plan.strong)
    }

    /// Lets the ways to answer some requests race; one of them may have an early answer. With all states, the properties
    /// that are left are answered, too, if `rest` says so.
    fn race(
        &self,
        program: &Arc<Program>,
        requests: &[usize],
        early: Option<usize>,
        rest: bool,
    ) -> Result<Answered, Error> {
        let plan = &self.asked.plan;
        let asks_for_number = |at: &usize| plan.requests[*at].asking.asks_for_number();
        let lists_states = self.left().iter().any(asks_for_number)
            || requests.iter().any(asks_for_number)
            || (0..plan.properties.len()).any(|at| self.is_open(at));
        let alone = early.map(|at| &plan.requests[at].asking);
        let target = alone.filter(|asking| asking.coalition.is_none()).and_then(Asking::reached_surely);
        let over_all = alone.filter(|_| self.given.plan.is_none() || target.is_some()).map(|asking| {
            move |engine: &SymbolicEngine| {
                let judged = answers::judge(engine, asking, &self.asked.program, program)?;
                // It visits reachable states only, whatever the engine knows.
                let policy = target.filter(|_| self.given.plan.is_some());
                let policy = policy.map(|target| policy::found(engine, program, target)).transpose()?;
                Ok(Answered::Everywhere(judged, policy.map(Box::new)))
            }
        });
        let by_search = |search: Guided| Ok(Answered::Guided(Box::new(search)));
        let early_ways = Early {
            everywhere: over_all.as_ref().map(|ask| ask as _),
            guided: target.map(|target| (target, &by_search as _)),
        };
        let by_states = |job: &Job<ReachReport>, engine: &Arc<AnyEngine>| {
            let (known, strategies) = self.by_states(job, engine, requests, rest)?;
            Ok(Answered::ByStates(Arc::clone(engine), requests.to_vec(), known, strategies))
        };
        let (args, selected, answer) = (self.given.model, self.selected.clone(), &by_states as _);
        engines::raced(
            self.job,
            &Request { program, args, selected, lists_states, early: early_ways, answer },
        )
    }

    /// Answers some requests with an engine that knows all states, and then the properties that are left if `rest` says
    /// so. Returns the decisions about all requests, and the strategies of `multi`.
    fn by_states(
        &self,
        job: &Job<ReachReport>,
        engine: &Arc<AnyEngine>,
        requests: &[usize],
        rest: bool,
    ) -> Result<(Known, Option<String>), Error> {
        let answering = Answering::new(job, self.given, self.asked, self.known.clone());
        if !requests.is_empty() || self.asked.plan.properties.is_empty() {
            answering.requests(&**engine, requests, &mut None)?;
        }
        let build = |program: &Arc<Program>| {
            let build = || engines::like(engine, program);
            job.timed("build", build, |r, s| r.time.add("build", s))
        };
        let open =
            Vec::from_iter((0..self.asked.plan.properties.len()).filter(|at| rest && self.is_open(*at)));
        let strategies = answering.rest(engine, &build, &open, self.mix.is_some())?;
        Ok((answering.known(), strategies))
    }

    /// Takes the answer to a request.
    fn take(&mut self, request: usize, answered: Answered) -> Result<(), Error> {
        let (plan, job) = (self.given.plan, self.job);
        let asked = self.asked;
        let asking = asked.plan.requests.get(request).map(|request| &request.asking);
        let alone = asking.map(|asking| (asking, asking.goal.program(&asked.program)));
        match answered {
            Answered::ByStates(engine, requests, known, strategies) => {
                self.known = known;
                requests.into_iter().for_each(|at| self.done[at] = true);
                match (self.mix, strategies) {
                    (Some(target), Some(strategies)) => target.write(&strategies)?,
                    (Some(_), None) => job.sink.warn("no strategies are written: none satisfies the bounds"),
                    _ => {}
                }
                if let (Some((plan, out)), Some((asking, program))) = (plan, alone) {
                    plan.work(job, &*engine, program, asking, out)?;
                }
                self.engine = Some(engine);
            }
            Answered::Everywhere(judged, policy) => {
                job.update(|r| r.over_all_valuations = true);
                self.note(request, judged);
                if let (Some((plan, Some(out))), Some(policy), Some((_, program))) = (plan, policy, alone) {
                    plan.finish(job, *policy, program, out)?;
                }
            }
            Answered::Guided(search) => {
                job.update(|r| r.by_guided_search = true);
                let guided = asking.map(|asking| answers::guided(&search, asking));
                guided.into_iter().for_each(|judged| self.note(request, judged));
                if let (Some((plan, Some(out))), Some((asking, program))) = (plan, alone) {
                    plan.of_search(job, &search, program, asking, out)?;
                }
            }
        }
        Ok(())
    }

    /// Adds an answer that was found before the states were known.
    fn note(&mut self, request: usize, judged: Judged) {
        let Judged { answer, decision, initial, peak_nodes } = judged;
        self.known[request] = Some(decision);
        self.job.update(|r| {
            if let Some(one) = r.one.as_mut().filter(|_| self.asked.plan.alone(request).next().is_some()) {
                one.initial = initial;
            }
            answers::add(r, self.asked, request, &answer, &self.known);
            r.memory.peak_nodes = r.memory.peak_nodes.max(peak_nodes);
        });
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
            self.job.update(|r| {
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
        self.job.update(|r| {
            for &at in &open {
                r.properties[self.asked.plan.properties[at].position].reason = Some(reason.to_owned());
            }
        });
        self.closed.extend(open);
    }
}
