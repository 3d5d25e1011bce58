//! The strategy that attains the optimum of the outermost operator of a property, and the value of a strategy.
//!
//! A strategy that was found has the value of its nodes in the arena. The value of one of a file is that of the chain that its
//! nodes leave, computed as that of any other model. So it does not depend on how the strategy was found.

use std::sync::Arc;

use meliora_base::error::Result;
use meliora_base::exact::{Ratio, Real};
use meliora_engine::{Engine, ExplicitEngine, Settings};
use meliora_lang::property::Optimum;
use meliora_lang::property::term::{Accumulated, Measure, Measured, Path, Step, Term, TermKind};
use meliora_model::predicate::Predicates;
use meliora_model::temporal::Condition;
use meliora_model::{Program, State};
use meliora_quantities::Interval;
use meliora_quantities::followed::NodeFault;

use super::aims::{Found, target};
use super::chain::{self, Linked, PolicyNode, PolicyNodes};
use super::condition::condition_of;
use super::following::{StrategyFault, StrategyFaultKind};
use super::{Evaluator, Model, Number};
use crate::goal::Target;

/// A strategy for the outermost operator of a property.
#[derive(Debug)]
pub struct PropertyPolicy {
    /// The nodes; those of the initial states come first.
    pub nodes: PolicyNodes,
    /// The number of initial states.
    pub starts: usize,
    /// True if it is the strategy of the opponent.
    pub of_opponent: bool,
    /// The least value of an initial state, or the greatest one where it is to be small.
    pub value: Number,
    /// True if the value is to be great.
    pub is_great: bool,
    /// The optimum of the initial state where it is the worst.
    pub optimum: Interval,
    /// The optima of all initial states.
    pub optima: Vec<Number>,
    /// The program with the monitors that the nodes remember; `None` without monitors.
    pub watched: Option<Arc<Program>>,
}

impl PropertyPolicy {
    /// Returns whether the value is the optimum, up to a precision.
    pub fn is_attained(&self, precision: f64) -> bool {
        let (best, worst) = match self.is_great {
            true => (self.optimum.upper, self.value.interval.lower),
            false => (self.value.interval.upper, self.optimum.lower),
        };
        best == worst || best - worst <= precision * worst.abs().max(1.0) * 2.0
    }
}

/// An operator whose nested conditions are conditions over the variables, with what its strategies look for.
pub struct Played<'t> {
    pub(super) term: &'t Term,
    pub(super) measured: Measured,
    is_game: bool,
    /// The optimum that the strategy looks for.
    optimum: Optimum,
    /// The program with the monitors of the formula, if it needs some.
    pub watched: Option<Arc<Program>>,
    /// The condition on these monitors.
    pub(super) condition: Option<Condition>,
}

impl<E: Engine> Evaluator<'_, '_, E> {
    /// Reads the outermost operator of a property; `of_opponent` asks for the strategy of the other side. Cost: that of the
    /// nested conditions.
    ///
    /// # Errors
    /// The property is not one operator of this kind; the errors of [`Evaluator::answer`].
    pub fn played_by<'t>(&self, term: &'t Term, of_opponent: bool) -> Result<Played<'t>> {
        let TermKind::Operator(measured) = &term.kind else {
            let help =
                "ask for one operator, such as `Pmax=? [ F \"goal\" ]` or `R{\"cost\"}min=? [ F \"goal\" ]`";
            return Err(self.unsupported(term, "only the property of one operator has a strategy", help));
        };
        let mut measured = self.frozen(measured)?;
        let is_game = self.engine.is_game();
        if of_opponent {
            if !is_game {
                return Err(self.wrong(term, "only a game has an opponent").into());
            }
            let own = measured.coalition.clone().unwrap_or_else(|| self.engine.coalition());
            measured.coalition = Some(own.iter().map(|ours| !ours).collect());
            measured.optimum = opposite(measured.optimum);
        }
        let optimum = measured.optimum;
        let (watched, condition) = self.monitors(&measured)?;
        Ok(Played { term, measured, is_game, optimum, watched, condition })
    }

    /// Returns the operator with each nested condition as one over the variables.
    fn frozen(&self, measured: &Measured) -> Result<Measured> {
        let mut measured = measured.clone();
        match &mut measured.measure {
            Measure::LongRun(states)
            | Measure::Reward(_, Accumulated::Anyway(states) | Accumulated::IfReached(states)) => {
                self.freeze(states)?
            }
            Measure::Probability(path) | Measure::Reward(_, Accumulated::Until(path)) => {
                path.nested.iter_mut().try_for_each(|nested| self.freeze(nested))?;
                match path.single.as_mut().map(|single| &mut single.step) {
                    Some(Step::Now(now) | Step::Next(now)) => self.freeze(now)?,
                    Some(Step::Until { left, right, .. }) => {
                        left.iter_mut().try_for_each(|left| self.freeze(left))?;
                        self.freeze(right)?;
                    }
                    None => {}
                }
            }
            Measure::Reward(..) => {}
        }
        Ok(measured)
    }

    fn freeze(&self, term: &mut Term) -> Result<()> {
        if matches!(term.kind, TermKind::State(_)) {
            return Ok(());
        }
        let states = self.at(&self.states(term, &self.engine.all_states())?)?;
        let mut predicates = Predicates::over(self.program);
        let id = condition_of(self.program, predicates.pool(), &states.list);
        term.kind = TermKind::State(predicates.get(id));
        Ok(())
    }

    /// Returns the program with the monitors of the formula, and the condition on them.
    fn monitors(&self, measured: &Measured) -> Result<(Option<Arc<Program>>, Option<Condition>)> {
        let path = match &measured.measure {
            Measure::Probability(path) if path.single.is_none() => Path::clone(path),
            Measure::Reward(_, Accumulated::Until(path)) if target(path).is_none() => {
                self.read_to_the_end(path)
            }
            _ => return Ok((None, None)),
        };
        let own = self.model.goal.is_none().then(|| self.goal_of(&path)).transpose()?;
        let Some(goal) = own.as_ref().or(self.model.goal) else { return Ok((None, None)) };
        let condition = match &goal.target {
            Target::Formula(condition) => Some(condition.clone()),
            Target::States(_) => None,
        };
        Ok((goal.watched.as_ref().map(|watched| Arc::clone(&watched.program)), condition))
    }

    /// Computes a strategy that attains the optimum from the initial states, and its value.
    ///
    /// # Errors
    /// The optimum has no such strategy, or none that is supported; a limit is reached.
    pub fn policy(&self, played: &Played<'_>, of_opponent: bool) -> Result<PropertyPolicy> {
        let mut found = self.attempt(played, of_opponent, self.model.precision)?;
        if !found.is_attained(self.model.precision) {
            let exact = self.attempt(played, of_opponent, 0.0)?;
            if exact.is_attained(self.model.precision) {
                found = exact;
            }
        }
        Ok(found)
    }

    fn attempt(&self, played: &Played<'_>, of_opponent: bool, precision: f64) -> Result<PropertyPolicy> {
        let Found { nodes, optima, values } = self.found(played, precision)?;
        let (starts, is_great) = (values.len(), played.optimum == Optimum::Max);
        let worst = |all: &[Number]| {
            let worst = all.iter().cloned().reduce(|a, b| a.extreme(&b, !is_great));
            worst.unwrap_or_else(|| Number::fraction(&Ratio::default()))
        };
        let (value, optimum) = (worst(&values), worst(&optima).interval);
        let watched = played.watched.clone();
        Ok(PropertyPolicy { nodes, starts, of_opponent, value, is_great, optimum, optima, watched })
    }
}

fn opposite(optimum: Optimum) -> Optimum {
    if optimum == Optimum::Max { Optimum::Min } else { Optimum::Max }
}

impl Played<'_> {
    /// Returns whether the value is to be great.
    pub fn is_great(&self) -> bool {
        self.optimum == Optimum::Max
    }

    /// Returns the value of a strategy in its worst initial state, or its first fault. `program` is the model, and the one
    /// with monitors if the nodes state these. Cost: one step of the model per node, and that of the property for the
    /// chain.
    ///
    /// # Errors
    /// A limit is reached; a command has no meaning in a state.
    pub fn value(
        &self,
        (plain, program): (&Arc<Program>, &Program),
        (nodes, starts): (&[PolicyNode], usize),
        (source, settings): (&Arc<meliora_base::error::SourceFile>, &Settings),
        precision: f64,
    ) -> Result<std::result::Result<Number, StrategyFault>> {
        let structures = Vec::from_iter(self.structure(plain));
        let links = match chain::linked(program, nodes, &structures)? {
            Ok(links) => links,
            Err(fault) => return Ok(Err(fault)),
        };
        let distances = chain::distances(&links, starts);
        let fault = |at: usize, kind| Ok(Err(StrategyFault { state: nodes[at].state.clone(), kind }));
        if let Some(at) = chain::misremembered((nodes, &links, starts), &distances, self.counted_steps()) {
            return fault(at, StrategyFaultKind::Memory);
        }
        // Nodes need not state the memory of monitors.
        let has_memory = self.watched.is_none() || !std::ptr::eq(&**plain, program);
        if let Some(at) = chain::doubled(nodes).filter(|_| has_memory) {
            return fault(at, StrategyFaultKind::Twice);
        }
        let rounds = self.rounds()?;
        if let Some(at) = nodes.iter().position(|node| u64::from(node.round) >= rounds) {
            return fault(at, StrategyFaultKind::Round);
        }
        if let Some(at) = self.misplaced_end(nodes, &distances) {
            return fault(at, StrategyFaultKind::Node(NodeFault::Open));
        }
        self.value_of_chain(plain, (nodes, &links, starts), (source, settings), precision).map(Ok)
    }

    /// Returns the value of the chain of some nodes, in the worst of the first ones.
    fn value_of_chain(
        &self,
        plain: &Arc<Program>,
        chain: (&[PolicyNode], &[Linked], usize),
        (source, settings): (&Arc<meliora_base::error::SourceFile>, &Settings),
        precision: f64,
    ) -> Result<Number> {
        let structures = Vec::from_iter(self.structure(plain));
        let mut measured = self.measured.clone();
        let pool = match &measured.measure {
            Measure::Probability(path) | Measure::Reward(_, Accumulated::Until(path)) => {
                path.predicates.clone().into_pool()
            }
            _ => Arc::clone(&plain.pool),
        };
        let chain = Arc::new(chain::program(plain, pool, chain, &structures));
        if let Measure::Probability(path) | Measure::Reward(_, Accumulated::Until(path)) =
            &mut measured.measure
        {
            path.predicates = Predicates::over(&chain);
        }
        // Against our strategy, the other side looks for the contrary.
        measured.coalition = None;
        if self.is_game {
            measured.optimum = opposite(measured.optimum);
        }
        let build =
            |program: &Arc<Program>| ExplicitEngine::new(Arc::clone(program), settings.clone()).map(Arc::new);
        let engine = build(&chain)?;
        let model = Model::new(&*engine, &chain, &build, precision);
        let term =
            Term { kind: TermKind::Operator(Box::new(measured)), ty: self.term.ty, span: self.term.span };
        Evaluator::new(&model, source).worst(&term, self.is_great())
    }

    /// Returns the reward structure, if the operator asks for a reward.
    pub(super) fn structure(&self, program: &Program) -> Option<usize> {
        match &self.measured.measure {
            Measure::Reward(rewards, _) => rewards.find(program),
            _ => None,
        }
    }

    /// Returns the number of sets that a strategy visits one after the other, at least 1.
    fn rounds(&self) -> Result<u64> {
        let Some(condition) = &self.condition else { return Ok(1) };
        // The least probability is 1 minus the greatest one of the negation.
        let negated = (self.measured.optimum == Optimum::Min).then(|| condition.negated());
        let all = negated.as_ref().unwrap_or(condition).disjuncts()?;
        Ok(all.iter().map(|own| own.again.len() as u64).max().unwrap_or_default().max(1))
    }

    /// Returns the first node that ends where the path is not decided.
    fn misplaced_end(&self, nodes: &[PolicyNode], distances: &[Option<u64>]) -> Option<usize> {
        let ends = (0..nodes.len()).filter(|&at| nodes[at].choices.is_empty());
        let mut steps = ends.filter_map(|at| Some((at, distances[at]?)));
        steps.find(|(at, steps)| !self.is_decided(&nodes[*at].state, *steps)).map(|(at, _)| at)
    }

    /// Returns the number of steps that a bound counts.
    fn counted_steps(&self) -> u64 {
        match &self.measured.measure {
            Measure::Probability(path) => match path.single.as_ref().map(|single| &single.step) {
                Some(Step::Next(_)) => 1,
                Some(Step::Until { least, most, .. }) => most.unwrap_or(*least),
                Some(Step::Now(_)) | None => 0,
            },
            Measure::Reward(_, Accumulated::Within(most) | Accumulated::At(most)) => *most,
            Measure::Reward(..) | Measure::LongRun(_) => 0,
        }
    }

    /// Returns whether a path is decided in a state after at least some steps.
    fn is_decided(&self, state: &State, steps: u64) -> bool {
        use meliora_base::value::Value;
        let holds = |term: &Term| match &term.kind {
            TermKind::State(predicate) => predicate.eval(state) == Ok(Value::Bool(true)),
            _ => false,
        };
        match &self.measured.measure {
            Measure::Probability(path) => match path.single.as_ref().map(|single| &single.step) {
                Some(Step::Now(_)) => true,
                Some(Step::Next(_)) => steps >= 1,
                Some(Step::Until { left, right, least, most }) => {
                    let (left, right) = (left.as_ref().is_none_or(holds), holds(right));
                    right && steps >= *least || !left && !right || most.is_some_and(|most| steps >= most)
                }
                None => false,
            },
            Measure::Reward(_, accumulated) => match accumulated {
                Accumulated::Until(path) => target(path).is_some_and(holds),
                Accumulated::Anyway(target) | Accumulated::IfReached(target) => holds(target),
                Accumulated::Within(most) | Accumulated::At(most) => steps >= *most,
                Accumulated::Total | Accumulated::LongRun => false,
            },
            Measure::LongRun(_) => false,
        }
    }

    /// Returns whether the property holds for a strategy with a value; true if it asks for a number, or about every
    /// strategy.
    pub fn satisfies(&self, value: &Number) -> Option<bool> {
        use meliora_lang::property::Inequality::{Ge, Gt, Le, Lt};
        let Some((comparison, bound)) = &self.measured.bound else { return Some(true) };
        let is_some = match comparison {
            Ge | Gt => self.optimum == Optimum::Max,
            Le | Lt => self.optimum == Optimum::Min,
        };
        if !is_some {
            Some(true)
        } else {
            value.satisfies(super::sign(*comparison), &Number::fraction(bound))
        }
    }
}

impl<E: Engine> Evaluator<'_, '_, E> {
    /// Returns the worst value of an operator in the initial states.
    fn worst(&self, term: &Term, is_great: bool) -> Result<Number> {
        let TermKind::Operator(measured) = &term.kind else {
            return Err(self.wrong(term, "expected an operator").into());
        };
        let at = self.at(&self.engine.initial_states())?;
        let mut found = self.measured(term, measured, &at, false)?;
        if found.iter().any(|x| x.interval.relative_width() > self.model.precision) {
            found = self.measured(term, measured, &at, true)?;
        }
        let worst = found.into_iter().reduce(|a, b| a.extreme(&b, !is_great));
        Ok(worst.unwrap_or_else(|| Number::fraction(&Ratio::default())))
    }
}

/// Returns whether a value is at least as good as a claimed one; `None` if its bounds do not decide it.
pub fn attains(value: &Number, claim: &Real, is_great: bool) -> Option<bool> {
    use meliora_base::exact::Exact;
    use meliora_lang::ast::BinaryOp;
    let claim = Number::of(Exact::Real(claim.clone()));
    value.satisfies(if is_great { BinaryOp::Ge } else { BinaryOp::Le }, &claim)
}
