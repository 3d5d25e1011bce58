//! Strategies for several objectives: what `reach --policy` writes for a property `multi(…)`.

use std::sync::Arc;

use crate::embed::Work;
use meliora_base::error::{Error, Result, SourceFile};
use meliora_base::exact::{Ratio, Real};
use meliora_base::random::Draw;
use meliora_engine::{ExplicitEngine, Settings};
use meliora_equations::several::Node;
use meliora_lang::parse_property;
use meliora_lang::property::Named;
use meliora_lang::property::term::TermKind;
use meliora_model::Program;
use meliora_planning::Sample;
use meliora_quantities::PRECISION;
use meliora_question::evaluate::{Evaluator, Following, Model, Objectives};
use meliora_report::PolicyReport;
use meliora_report::mix::{File, ReadStrategy};
use meliora_report::policy_report::{MeasuredObjective, ObjectiveValue, PolicyRuns, StrategyValues};

/// Strategies with their model.
pub(super) struct Mix {
    program: Arc<Program>,
    source: Arc<SourceFile>,
    strategies: Vec<ReadStrategy>,
    settings: Settings,
}

impl Mix {
    /// Reads strategies.
    ///
    /// # Errors
    /// The text is wrong, or about another model; the model is a game.
    pub(super) fn new(
        source: &Arc<SourceFile>,
        file: File,
        program: Program,
        settings: Settings,
    ) -> Result<Self> {
        if program.players.is_some() {
            let message =
                "this checks strategies of `multi` for models with one player, and this model is a game";
            return Err(Error::Usage(message.to_owned()));
        }
        let property = file.property.clone();
        let strategies = file.mix(source, &program)?;
        let source = SourceFile::new(format!("the property of {}", source.name), property);
        Ok(Mix { program: Arc::new(program), source, strategies, settings })
    }

    /// Checks the strategies, or runs them.
    ///
    /// # Errors
    /// The property is wrong, or none with several objectives; a limit.
    pub(super) fn work(&self, work: &dyn Work<PolicyReport>, runs: Option<&PolicyRuns>) -> Result<()> {
        let build = |program: &Arc<Program>| {
            ExplicitEngine::new(Arc::clone(program), self.settings.clone()).map(Arc::new)
        };
        let term = parse_property(&self.source)?.term(&self.program, &self.source, &Named::default())?;
        if !matches!(term.kind, TermKind::Multi(_)) {
            return Err(Error::Usage("the property of the file has no objectives".to_owned()));
        }
        let engine = build(&self.program)?;
        let model = Model::new(&*engine, &self.program, &build, PRECISION);
        let evaluator = Evaluator::new(&model, &self.source);
        let objectives = evaluator.objectives(&term)?;
        let count = objectives.texts().len();
        if self.strategies.iter().any(|own| own.values.len() != count) {
            let message = format!("each strategy needs one value for each of the {count} objectives");
            return Err(Error::Usage(message));
        }
        let mut nodes = Vec::new();
        for strategy in &self.strategies {
            match objectives.nodes(&strategy.nodes) {
                Ok(found) => nodes.push(found),
                Err(fault) => {
                    let (kind, state) = (fault.kind.to_string(), &fault.state);
                    work.update(|r| r.refuse(&self.program, &kind, Some(state)));
                    return Ok(());
                }
            }
        }
        match runs {
            Some(runs) => self.simulate(work, &objectives, &nodes, runs),
            None => self.check(work, &objectives, &nodes),
        }
    }

    /// Returns a strategy with the values that it claims.
    fn claims(&self, at: usize, objectives: &Objectives<'_>) -> StrategyValues {
        let own = &self.strategies[at];
        let objective = |(text, claimed): (&String, &Ratio)| ObjectiveValue {
            objective: text.clone(),
            claimed: double(claimed),
            value: None,
        };
        let objectives = objectives.texts().iter().zip(&own.values).map(objective).collect();
        StrategyValues { share: own.share.as_ref().map(double), nodes: own.nodes.len() as u64, objectives }
    }

    /// Follows all strategies; `None` if one has a fault, which the report has then.
    fn followed<'m>(
        &self,
        work: &dyn Work<PolicyReport>,
        objectives: &'m Objectives<'m>,
        nodes: &'m [Vec<Node>],
    ) -> Result<Option<Vec<Following<'m>>>> {
        let mut all = Vec::new();
        for nodes in nodes {
            match objectives.follow(nodes)? {
                Ok(found) => all.push(found),
                Err(fault) => {
                    let kind = fault.kind.to_string();
                    work.update(|r| r.refuse(&self.program, &kind, Some(&fault.state)));
                    return Ok(None);
                }
            }
        }
        Ok(Some(all))
    }

    /// Checks that each strategy has the values that it claims, and that their mean satisfies the bounds.
    fn check(
        &self,
        work: &dyn Work<PolicyReport>,
        objectives: &Objectives<'_>,
        nodes: &[Vec<Node>],
    ) -> Result<()> {
        let Some(all) = self.followed(work, objectives, nodes)? else { return Ok(()) };
        for (at, following) in all.iter().enumerate() {
            work.check()?;
            let mut shown = self.claims(at, objectives);
            let mut wrong = None;
            for (index, own) in shown.objectives.iter_mut().enumerate() {
                let (found, holds) = following.attains(index, &self.strategies[at].values[index])?;
                own.value = Some(found.into());
                if !holds {
                    wrong.get_or_insert_with(|| {
                        format!(
                            "strategy {} does not attain the value {} of `{}`",
                            at + 1,
                            own.claimed,
                            own.objective
                        )
                    });
                }
            }
            work.update(|r| {
                r.strategies.push(shown);
                wrong.iter().for_each(|wrong| r.refuse(&self.program, wrong, None));
            });
        }
        let missed = self.missed(objectives, &all)?;
        if objectives.are_open() {
            work.say("the values of these strategies are checked, not that no others are better: a front may be incomplete");
        }
        work.update(|r| {
            missed.iter().for_each(|condition| r.refuse(&self.program, condition, None));
            r.accepted = Some(Some(r.violation.is_none()));
        });
        Ok(())
    }

    /// Returns the bound that the strategies together do not satisfy, if there is one.
    fn missed(&self, objectives: &Objectives<'_>, all: &[Following<'_>]) -> Result<Option<String>> {
        let shares = self.strategies.iter().map(|own| own.share.clone()).collect::<Option<Vec<_>>>();
        let Some(shares) = shares else {
            let message = "the strategies have no shares, so no mean satisfies the bounds of the property";
            return Ok(objectives.have_bounds().then(|| message.to_owned()));
        };
        let drawn: Vec<_> = shares.into_iter().zip(all).collect();
        for (at, text) in objectives.texts().iter().enumerate() {
            if !objectives.is_satisfied(at, &drawn)? {
                return Ok(Some(format!("the strategies together do not satisfy `{text}`")));
            }
        }
        Ok(None)
    }

    /// Runs strategies, each drawn with its share, and measures the objectives.
    fn simulate(
        &self,
        work: &dyn Work<PolicyReport>,
        objectives: &Objectives<'_>,
        nodes: &[Vec<Node>],
        runs: &PolicyRuns,
    ) -> Result<()> {
        let shares: Option<Vec<f64>> =
            self.strategies.iter().map(|own| own.share.as_ref().map(double)).collect();
        let Some(shares) = shares else {
            let message = "the strategies of a front have no shares, so none is drawn: ask for bounds, as in `multi(Pmax=? [ F a ], P>=0.5 [ F b ])`";
            return Err(Error::Usage(message.to_owned()));
        };
        let Some(following) = self.followed(work, objectives, nodes)? else { return Ok(()) };
        let prepared = following.iter().map(|own| own.runs()).collect::<Result<Vec<_>>>()?;
        work.update(|r| r.strategies = (0..nodes.len()).map(|at| self.claims(at, objectives)).collect());
        let count = objectives.texts().len();
        let (mut samples, mut decided) = (vec![Sample::new(1); count], 0);
        let mut endless = vec![false; count];
        for number in 0..runs.runs {
            work.check()?;
            let mut draw = Draw::numbered(runs.seed, number);
            let strategy = draw.by_probability(shares.iter().copied());
            let found = prepared[strategy].run(runs.limit, &mut draw);
            decided += u64::from(found.iter().all(Option::is_some));
            for (at, value) in found.into_iter().enumerate() {
                endless[at] |= value == Some(f64::INFINITY);
                match value {
                    None => samples[at].miss(true),
                    Some(0.0) if objectives.is_probability(at) => samples[at].miss(false),
                    Some(value) => samples[at].reach(value),
                }
            }
        }
        let measured = |at: usize| {
            let means =
                self.strategies.iter().zip(&shares).map(|(own, share)| double(&own.values[at]) * share);
            let (objective, claimed) = (objectives.texts()[at].clone(), means.sum());
            let of_probability = objectives.is_probability(at);
            measured(objective, claimed, &samples[at], of_probability, endless[at])
        };
        work.update(|r| {
            if let Some(runs) = &mut r.runs {
                runs.reached = decided;
                runs.given_up = runs.runs - decided;
                runs.objectives = (0..count).map(measured).collect();
            }
        });
        Ok(())
    }
}

fn double(x: &Ratio) -> f64 {
    Real::Finite(x.clone()).to_f64()
}

/// Returns what the runs measured of an objective.
pub(super) fn measured(
    objective: String,
    claimed: f64,
    sample: &Sample,
    of_probability: bool,
    is_endless: bool,
) -> MeasuredObjective {
    let open = sample.open;
    let (measured, interval) = match of_probability {
        true => (Some(sample.share()), Some(sample.probability())),
        false if open > 0 || is_endless => (None, None),
        false => (Some(sample.mean_cost), sample.cost()),
    };
    let interval = interval.map(|(lower, upper)| [lower, upper]);
    MeasuredObjective { objective, claimed, measured, interval, open }
}
