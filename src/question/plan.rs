//! Plans for properties: the requests about the initial states that they need, each once, and how their answers make
//! those of the properties.
//!
//! A request is one operator over a formula without other operators. It can be answered before all states are known,
//! wherever it stands: alone, below `!`, `&` and `|`, or in a filter over the initial states. What else a property
//! asks is evaluated over all states, by [`crate::evaluate`].

use std::ops::Not;
use std::sync::Arc;

use ahash::AHashMap;

use crate::answer::Answer;
use crate::asking::Asking;
use crate::goal::{PathGoal, Required};
use meliora_base::error::{Diagnostic, Error, Result, Severity, SourceFile};
use meliora_base::value::Value;
use meliora_engine::Engine;
use meliora_engine::regions::{Regions, deciding};
use meliora_lang::ast::BinaryOp;
use meliora_lang::property::term::{FilterFunction, Path, Term, TermKind};
use meliora_lang::property::{PropertyKind, Query};
use meliora_model::Program;
use meliora_model::predicate::Predicate;

/// The requests of some properties.
#[derive(Default)]
pub struct Plan {
    /// The requests, in the order of the first property that needs each.
    pub requests: Vec<Request>,
    /// The properties.
    pub properties: Vec<Planned>,
    /// True under requirements.
    is_required: bool,
    /// True if the requirements leave a part of the model itself, for one player, so that properties can be evaluated over
    /// its states.
    pub is_plain: bool,
}

/// A question about the initial states.
pub struct Request {
    /// The question.
    pub asking: Asking,
    /// The properties that need it, by their places in the plan.
    pub properties: Vec<usize>,
    path: Option<Path>,
}

/// A property with its plan.
pub struct Planned {
    /// Its position in the report.
    pub position: usize,
    /// The text.
    pub text: String,
    /// The text that it points into, and the property; `None` for a target.
    pub stated: Option<(Arc<SourceFile>, Term)>,
    /// Its answer as a condition on those of the requests.
    pub shape: Shape,
}

/// A condition on the answers to requests.
#[derive(Debug, Clone)]
pub enum Shape {
    /// The answer to a request.
    Request(usize),
    /// A condition on the variables.
    State(Predicate),
    /// `!φ`
    Not(Box<Shape>),
    /// `φ & ψ & …`
    All(Vec<Shape>),
    /// True in every state if φ holds in all initial states, else false.
    Initial(Box<Shape>),
    /// The answer is evaluated over all states.
    States,
}

/// The knowledge about a condition in the initial states.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Decision {
    /// It holds in all of them.
    pub all: Option<bool>,
    /// It holds in none of them.
    pub none: Option<bool>,
    /// True if no strategy keeps the requirements from some of them.
    pub is_lost: bool,
}

impl Decision {
    /// Returns the decision for a condition with one truth in all initial states.
    pub fn uniform(truth: bool) -> Self {
        Decision { all: Some(truth), none: Some(!truth), is_lost: false }
    }

    /// Returns what the answer to a request says of the condition. Cost: no image.
    ///
    /// # Errors
    /// A limit is reached.
    pub fn of<E: Engine>(
        engine: &E,
        asking: &Asking,
        answer: &Answer,
        known: &Regions<Option<E::States>>,
        is_lost: bool,
    ) -> Result<Self> {
        let mut decision = Decision { all: answer.holds, none: None, is_lost };
        let initial = engine.initial_states();
        decision.none = match &asking.question {
            Some(PropertyKind::Qualitative(strategies, bound)) => {
                let (which, inside) = deciding(*strategies, *bound);
                let outside = |region: &E::States| match inside {
                    true => engine.intersection(&initial, region),
                    false => engine.difference(&initial, region),
                };
                known.get(which).as_ref().map(|region| engine.is_empty(&outside(region)?)).transpose()?
            }
            _ if engine.list_states(&initial, 2)?.len() < 2 => answer.holds.map(bool::not),
            _ => answer.holds.filter(|holds| *holds).map(bool::not),
        };
        Ok(decision)
    }

    /// Returns whether the condition holds in all initial states. Where no strategy keeps the requirements, none does.
    pub fn holds(self) -> Option<bool> {
        if self.is_lost { Some(false) } else { self.all }
    }

    fn and(self, other: Self) -> Self {
        let all = match (self.all, other.all) {
            (Some(false), _) | (_, Some(false)) => Some(false),
            (a, b) => a.and(b),
        };
        let none = match (self, other) {
            (Decision { none: Some(true), .. }, _) | (_, Decision { none: Some(true), .. }) => Some(true),
            (Decision { all: Some(true), .. }, b) => b.none,
            (a, Decision { all: Some(true), .. }) => a.none,
            _ => None,
        };
        Decision { all, none, is_lost: self.is_lost || other.is_lost }
    }
}

impl Not for Decision {
    type Output = Self;

    fn not(self) -> Self {
        Decision { all: self.none, none: self.all, ..self }
    }
}

impl Shape {
    /// Returns what the answers to requests say of the condition; `truth` is that of conditions on the variables.
    fn decided(&self, known: &[Option<Decision>], truth: &dyn Fn(&Predicate) -> Decision) -> Decision {
        match self {
            Shape::Request(at) => known[*at].unwrap_or_default(),
            Shape::State(condition) => truth(condition),
            Shape::Not(a) => !a.decided(known, truth),
            Shape::All(parts) => {
                let parts = parts.iter().map(|part| part.decided(known, truth));
                parts.fold(Decision::uniform(true), Decision::and)
            }
            Shape::Initial(a) => {
                let own = a.decided(known, truth);
                Decision { all: own.all, none: own.all.map(bool::not), ..own }
            }
            Shape::States => Decision::default(),
        }
    }

    fn any(parts: impl IntoIterator<Item = Shape>) -> Self {
        Shape::Not(Box::new(Shape::All(parts.into_iter().map(Shape::negated).collect())))
    }

    fn negated(self) -> Self {
        Shape::Not(Box::new(self))
    }

    /// Returns whether a part of the condition satisfies a test.
    fn has(&self, is_one: &dyn Fn(&Shape) -> bool) -> bool {
        is_one(self)
            || match self {
                Shape::Not(a) | Shape::Initial(a) => a.has(is_one),
                Shape::All(parts) => parts.iter().any(|part| part.has(is_one)),
                Shape::Request(_) | Shape::State(_) | Shape::States => false,
            }
    }
}

impl Planned {
    /// Returns the request whose answer is that of the property, if it is a single one.
    pub fn request(&self) -> Option<usize> {
        match self.shape {
            Shape::Request(at) => Some(at),
            _ => None,
        }
    }
}

impl Plan {
    /// Returns the plan for one question.
    pub fn of(asking: Asking, text: &str) -> Self {
        let request = Request { asking, properties: vec![0], path: None };
        let goal = &request.asking.goal;
        let (is_required, is_plain) = (!goal.requirements.is_empty(), goal.watched.is_none());
        let shape = Shape::Request(0);
        let property = Planned { position: 0, text: text.to_owned(), stated: None, shape };
        Plan { requests: vec![request], properties: vec![property], is_required, is_plain }
    }

    /// Returns whether a property holds in all initial states, as far as the answers to its requests decide it.
    pub fn holds(&self, program: &Program, property: usize, known: &[Option<Decision>]) -> Option<bool> {
        let initial = program.variables.iter().map(|variable| variable.initial);
        // With a condition for the initial states there may be several.
        let initial: Option<Vec<i64>> = initial.collect();
        let truth = |condition: &Predicate| {
            let holds = initial.as_ref().and_then(|state| condition.eval(state).ok());
            holds.map_or_else(Decision::default, |value| Decision::uniform(value == Value::Bool(true)))
        };
        let is_known = |(request, known): (&Request, &Option<Decision>)| {
            known.is_some() && request.properties.contains(&property)
        };
        // Without a safe strategy, no condition holds.
        if self.is_required && !self.requests.iter().zip(known).any(is_known) {
            return None;
        }
        self.properties[property].shape.decided(known, &truth).holds()
    }

    /// Returns whether some answer is a number, or may depend on one.
    pub fn asks_for_numbers(&self) -> bool {
        self.asks_for(Asking::asks_for_number)
    }

    /// Returns whether some answer may depend on rewards.
    pub fn asks_for_rewards(&self) -> bool {
        self.asks_for(Asking::asks_for_reward)
    }

    /// Returns whether some request is of a kind, or unknown.
    fn asks_for(&self, is_such: impl Fn(&Asking) -> bool) -> bool {
        let is_open = |property: &Planned| property.shape.has(&|part| matches!(part, Shape::States));
        self.requests.iter().any(|request| is_such(&request.asking)) || self.properties.iter().any(is_open)
    }

    /// Returns the places of the properties whose answer is that of a request.
    pub fn alone(&self, request: usize) -> impl Iterator<Item = usize> {
        let own = self.requests[request].properties.iter().copied();
        own.filter(move |&property| self.properties[property].request() == Some(request))
    }
}

/// Makes plans for the properties of a program, under requirements.
pub struct Planner<'a> {
    program: &'a Program,
    required: &'a [Required],
    /// The regions of the properties are wanted: each operator is one request, and other properties are sets of states.
    regions: bool,
    plan: Plan,
    /// The requests to reach states, by the fingerprints of these.
    reaching: AHashMap<u64, Vec<usize>>,
    watched: Vec<usize>,
}

impl<'a> Planner<'a> {
    /// Begins without properties.
    ///
    /// # Errors
    /// A requirement is wrong, or not a safe formula.
    pub fn new(program: &'a Program, required: &'a [Required], regions: bool) -> Result<Self> {
        let is_plain = required.is_empty()
            || PathGoal::reach(program, program.predicate(program.initial), required)?.watched.is_none()
                && program.players.is_none();
        let (reaching, watched) = Default::default();
        let plan = Plan { is_required: !required.is_empty(), is_plain, ..Plan::default() };
        Ok(Planner { program, required, regions, plan, reaching, watched })
    }

    /// Adds a property. After an error, the plan is that of the others.
    ///
    /// # Errors
    /// The property is not supported, or not under these requirements.
    pub fn add(&mut self, position: usize, text: &str, source: &Arc<SourceFile>, term: Term) -> Result<()> {
        let before = self.plan.requests.len();
        let shape = self.planned(source, &term).inspect_err(|_| self.take_back(before))?;
        let stated = Some((Arc::clone(source), term));
        self.plan.properties.push(Planned { position, text: text.to_owned(), stated, shape });
        Ok(())
    }

    /// Returns the plan.
    pub fn finish(self) -> Plan {
        self.plan
    }

    fn take_back(&mut self, requests: usize) {
        let own = self.plan.properties.len();
        self.plan.requests.truncate(requests);
        self.plan.requests.iter_mut().for_each(|request| request.properties.retain(|&at| at != own));
        self.watched.retain(|&at| at < requests);
        self.reaching.values_mut().for_each(|all| all.retain(|&at| at < requests));
    }

    fn planned(&mut self, source: &Arc<SourceFile>, term: &Term) -> Result<Shape> {
        let steps = |query: &Query<'_>| query.path.is_bounded();
        let query = term.query(self.program);
        let shape = match query.filter(|query| self.regions || !self.required.is_empty() || !steps(query)) {
            Some(query) => Shape::Request(self.request(source, &query)?),
            None if self.regions => Shape::States,
            None => self.shape(source, term)?,
        };
        if !self.plan.is_plain && shape.has(&|part| matches!(part, Shape::States)) {
            return Err(self.refused(source, term));
        }
        let has_requests = shape.has(&|part| matches!(part, Shape::Request(_)));
        Ok(if has_requests { shape } else { Shape::States })
    }

    fn refused(&self, source: &Arc<SourceFile>, term: &Term) -> Error {
        let message = "under other requirements than `G condition`, and of games under any, a property is made of \
                       operators over formulas without other operators, by `!`, `&` and `|`";
        let wrong = Diagnostic::new(source, term.span.range(), message).severity(Severity::Unsupported);
        wrong.help("leave out `--require`, or ask for each operator alone").into()
    }

    /// Returns the shape of a condition; [`Shape::States`] for a number.
    fn shape(&mut self, source: &Arc<SourceFile>, term: &Term) -> Result<Shape> {
        let program = self.program;
        let mut of = |part: &Term| self.shape(source, part);
        Ok(match &term.kind {
            TermKind::State(condition) if term.is_condition() => Shape::State(condition.clone()),
            TermKind::Not(a) => of(a)?.negated(),
            TermKind::Join(all, parts) => {
                let parts = parts.iter().map(of).collect::<Result<Vec<_>>>()?;
                if *all { Shape::All(parts) } else { Shape::any(parts) }
            }
            TermKind::Binary(BinaryOp::Implies, both) => Shape::any([of(&both[0])?.negated(), of(&both[1])?]),
            TermKind::Binary(BinaryOp::Iff, both) => {
                let (a, b) = (of(&both[0])?, of(&both[1])?);
                let neither = vec![a.clone().negated(), b.clone().negated()];
                Shape::any([Shape::All(vec![a, b]), Shape::All(neither)])
            }
            TermKind::Ite(all) if term.is_condition() => {
                let (c, a, b) = (of(&all[0])?, of(&all[1])?, of(&all[2])?);
                Shape::any([Shape::All(vec![c.clone(), a]), Shape::All(vec![c.negated(), b])])
            }
            TermKind::Filter(filter) => {
                let is_initial = filter.states.as_ref().is_some_and(|states| states.is_initial(program));
                match filter.function {
                    FilterFunction::Forall if is_initial => Shape::Initial(Box::new(of(&filter.of)?)),
                    FilterFunction::Exists if is_initial => {
                        Shape::Initial(Box::new(of(&filter.of)?.negated())).negated()
                    }
                    _ => Shape::States,
                }
            }
            TermKind::Operator(_) => match term.query(self.program).filter(|query| self.can_ask(query)) {
                Some(query) => Shape::Request(self.request(source, &query)?),
                None => Shape::States,
            },
            _ => Shape::States,
        })
    }

    /// Returns whether a part of a property is a request: it is decided without numbers and without steps, or the
    /// model itself does not know the requirements.
    fn can_ask(&self, query: &Query<'_>) -> bool {
        match &query.question {
            PropertyKind::Qualitative(..) => !self.required.is_empty() || !query.path.is_bounded(),
            PropertyKind::Quantity(quantity) => quantity.bound.is_some() && !self.plan.is_plain,
        }
    }

    /// Returns the place of a request, which is added unless it is known.
    fn request(&mut self, source: &Arc<SourceFile>, query: &Query<'_>) -> Result<usize> {
        let own = self.plan.properties.len();
        let same = |request: &Request| {
            let asking = &request.asking;
            asking.question.as_ref() == Some(&query.question)
                && asking.over == query.over
                && asking.coalition.as_ref() == query.coalition
                && request.path.as_ref().is_some_and(|path| path.is_same(query.path))
        };
        let alike = match query.path.target() {
            Some(target) => self.reaching.entry(target.fingerprint()).or_default(),
            None => &mut self.watched,
        };
        if let Some(&known) = alike.iter().find(|&&at| same(&self.plan.requests[at])) {
            let properties = &mut self.plan.requests[known].properties;
            if properties.last() != Some(&own) {
                properties.push(own);
            }
            return Ok(known);
        }
        let asking = Asking::query(self.program, source, query, self.required)?;
        alike.push(self.plan.requests.len());
        let path = Some(query.path.clone());
        self.plan.requests.push(Request { asking, properties: vec![own], path });
        Ok(self.plan.requests.len() - 1)
    }
}
