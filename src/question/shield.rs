//! Shields by value: the permitted actions of a rule about the probabilities after each action.

use std::sync::Arc;

use ahash::AHashMap;

use crate::evaluate::{ActionValues, Evaluator, Model};
use crate::list;
use crate::race::started;
use meliora_base::decimal;
use meliora_base::error::{Diagnostic, Error, Limit, Result, Severity, SourceFile};
use meliora_base::exact::Ratio;
use meliora_base::interval::{Bounds, Interval};
use meliora_base::number::Weight;
use meliora_engine::{Algebra, AnyEngine, Count, Engine};
use meliora_lang::named::Property;
use meliora_lang::parse_property;
use meliora_lang::property::term::{Term, TermKind};
use meliora_lang::property::{Named, Optimum, ShieldExpression};
use meliora_model::Program;
use meliora_planning::shield::by_value::SAFETY;
use meliora_planning::{Safety, Shield, ShieldAction, ShieldNode, ShieldVariable, ValueRule};
use meliora_quantities::actions::StateActions;

use num_traits::ToPrimitive;

/// The threshold of a shield by value.
#[derive(Debug, Clone, PartialEq)]
pub struct Threshold {
    /// The least safety of a permitted action; a number from 0 to 1.
    pub number: Ratio,
    /// It is a factor of the best safety of the state.
    pub relative: bool,
}

impl Threshold {
    /// Reads a number between 0 and 1, such as `0.9` or `9/10`.
    ///
    /// # Errors
    /// The text is another one.
    pub fn parse(text: &str, relative: bool) -> std::result::Result<Self, String> {
        let number = decimal::read(text.trim()).filter(|x| *x >= Ratio::default() && *x <= Ratio::one());
        let number =
            number.ok_or_else(|| format!("`{text}`: expected a number between 0 and 1, such as 0.9"))?;
        Ok(Threshold { number, relative })
    }
}

/// A shield that is asked for: a property and a threshold.
#[derive(Debug)]
pub struct ShieldQuestion {
    source: Arc<SourceFile>,
    term: Term,
    /// The threshold.
    pub threshold: Threshold,
    /// The name, and whether forbidden actions are replaced, if the property is a shield expression.
    pub expression: Option<(String, bool)>,
}

impl ShieldQuestion {
    /// Reads a property such as `Pmin=? [ F "crash" ]`, or a shield expression
    /// `<name, PreSafety, lambda=0.9> Pmax=? [ G !"crash" ]`, which has a threshold of its own. Messages call the text
    /// `name`.
    ///
    /// # Errors
    /// The text is wrong, each error with its place; the threshold is missing, or given twice.
    pub fn read(
        (program, named): (&Program, &[Property]),
        (name, text): (&str, &str),
        threshold: Option<Threshold>,
    ) -> Result<Self> {
        let usage = |message: &str| Error::Usage(message.to_owned());
        let whole = SourceFile::new(name, text);
        let Some((own, property)) = ShieldExpression::read(&whole)? else {
            let (source, term) = list::stated(program, named, (name, text))?;
            let missing = "a threshold is missing: the least safety of a permitted action, such as 0.9";
            let threshold = threshold.ok_or_else(|| usage(missing))?;
            return Ok(ShieldQuestion { source, term, threshold, expression: None });
        };
        if threshold.is_some() {
            return Err(usage("the shield expression has a threshold of its own; leave out the other one"));
        }
        let term = parse_property(&property)?.term(program, &property, &Named::default())?;
        let wrong = |message: String| Diagnostic::new(&whole, 0..whole.text.len(), message);
        let mut threshold = Threshold::parse(&own.number, own.relative).map_err(wrong)?;
        let minimises = matches!(&term.kind, TermKind::Operator(own) if own.optimum == Optimum::Min);
        if minimises && own.relative {
            let message = "`lambda` of a `Pmin` is not supported: tempest permits values up to (1 + lambda) times the \
                           least one";
            let refused = wrong(message.to_owned()).severity(Severity::Unsupported);
            return Err(refused.help("write `Pmax=? [ G !… ]` for `Pmin=? [ F … ]`").into());
        }
        if minimises {
            // The bound is one on the value.
            threshold.number = Ratio::one() - threshold.number;
        }
        Ok(ShieldQuestion { source: property, term, threshold, expression: Some((own.name, own.post)) })
    }

    /// Returns the text of the property.
    pub fn text(&self) -> String {
        self.source.on_one_line(self.term.span.range())
    }

    /// Computes the shield with an engine that knows all states: from bounds of the values that are at most `precision`
    /// wide, or from fractions where the bounds do not decide.
    ///
    /// # Errors
    /// The property is not supported; there are more than `limit` states; another limit is reached.
    pub fn answer(
        &self,
        engine: &AnyEngine,
        program: &Arc<Program>,
        precision: f64,
        limit: usize,
    ) -> Result<(Shield, Arc<Program>)> {
        let count = engine.count(&engine.all_states())?;
        if count > Count::from(limit) {
            let what = format!("a shield lists the {count} states, more than the {limit} that are wanted");
            return Err(Limit::Size { what }.into());
        }
        let build = |program: &Arc<Program>| {
            started(AnyEngine::new(Arc::clone(program), engine.settings().clone())?, program)
        };
        let model = Model::new(engine, program, &build, precision);
        let evaluator = Evaluator::new(&model, &self.source);
        let mut found = evaluator.actions(&self.term, false)?;
        let mut shield = by_value(&found, &self.text(), &self.threshold, limit)?;
        if shield.is_none() {
            found = evaluator.actions(&self.term, true)?;
            shield = by_value(&found, &self.text(), &self.threshold, limit)?;
        }
        let undecided = || Error::Usage("the values do not decide which actions are permitted".to_owned());
        Ok((shield.ok_or_else(undecided)?, found.program))
    }
}

/// Returns the shield of a rule; `None` if the bounds of the values do not decide which actions are permitted. Fractions
/// always do.
///
/// # Errors
/// There are more than `limit` states.
fn by_value(
    found: &ActionValues,
    property: &str,
    threshold: &Threshold,
    limit: usize,
) -> Result<Option<Shield>> {
    if found.states.len() > limit {
        let what = format!("the shield has more than {limit} states");
        return Err(Limit::Size { what }.into());
    }
    let mut names = Shield::labels(&found.program);
    let mut numbers: AHashMap<String, usize> = names.iter().cloned().zip(0..).collect();
    let mut nodes = Vec::with_capacity(found.states.len());
    for state in &found.states {
        let Some((flags, pick, secure)) = permitted(state, found.optimum, threshold) else { return Ok(None) };
        let actions = state.actions.iter().zip(flags).map(|(action, permitted)| {
            let action_number = *numbers.entry(action.name.clone()).or_insert_with(|| {
                names.push(action.name.clone());
                names.len() - 1
            });
            let interval = action.value.interval;
            let value = Some([interval.lower, interval.upper]);
            ShieldAction { action: action_number, permitted, value, next: action.next.clone() }
        });
        nodes.push(ShieldNode {
            state: state.state.clone(),
            theirs: state.theirs,
            class: Some(0),
            reference: 0,
            ahead: Some(0),
            secure,
            pursues: Vec::new(),
            achieved: false,
            decided: state.decided,
            actions: actions.collect(),
            pick,
        });
    }
    let shield = Shield {
        kind: SAFETY.to_owned(),
        rule: Some(ValueRule {
            property: property.to_owned(),
            maximises: found.optimum == Optimum::Max,
            threshold: threshold.number.to_f64().unwrap_or(1.0),
            relative: threshold.relative,
            horizon: found.horizon,
        }),
        safety: Safety::Action.name().to_owned(),
        variables: ShieldVariable::all(&found.program),
        actions: names,
        classes: vec![Vec::new()],
        weakening: vec![Vec::new()],
        starts: nodes.len(),
        nodes,
    };
    Ok(Some(shield))
}

/// Returns which actions of a state are permitted, the one to pick, and whether these reach the threshold; `None` if the
/// bounds do not decide it.
fn permitted(of: &StateActions, optimum: Optimum, threshold: &Threshold) -> Option<(Vec<bool>, usize, bool)> {
    let all: Vec<Bounds> = of.actions.iter().map(|action| safety(&action.value, optimum)).collect();
    let best =
        (0..all.len()).reduce(|best, other| if is_less(&all[best], &all[other]) { other } else { best })?;
    let least = least(&all[best], threshold);
    if of.theirs {
        let reach = all.iter().map(|own| reaches(own, &least)).collect::<Option<Vec<bool>>>()?;
        return Some((vec![true; all.len()], best, threshold.relative || !reach.contains(&false)));
    }
    // The best action reaches every factor of its safety.
    if threshold.relative || reaches(&all[best], &least)? {
        let flag = |at: usize| if at == best { Some(true) } else { reaches(&all[at], &least) };
        return Some(((0..all.len()).map(flag).collect::<Option<_>>()?, best, true));
    }
    let flag = |at: usize| if at == best { Some(true) } else { reaches(&all[at], &all[best]) };
    Some(((0..all.len()).map(flag).collect::<Option<_>>()?, best, false))
}

/// Returns the safety of a value: for `Pmin`, 1 minus it.
fn safety(value: &Bounds, optimum: Optimum) -> Bounds {
    if optimum == Optimum::Min { value.clone().complement() } else { value.clone() }
}

/// Returns the least safety of a permitted action.
fn least(best: &Bounds, Threshold { number, relative }: &Threshold) -> Bounds {
    let own = Interval::around(number);
    if !relative {
        return Bounds { interval: own, exact: Some(number.clone()) };
    }
    Bounds { interval: best.interval.times(&own), exact: best.exact.as_ref().map(|best| best * number) }
}

/// Returns whether a number is at least another one; `None` if the bounds do not decide it.
fn reaches(own: &Bounds, least: &Bounds) -> Option<bool> {
    match (&own.exact, &least.exact) {
        (Some(own), Some(least)) => Some(own >= least),
        _ if own.interval.lower >= least.interval.upper => Some(true),
        _ => (own.interval.upper < least.interval.lower).then_some(false),
    }
}

/// Returns whether a number is less than another one, as far as the bounds tell.
fn is_less(own: &Bounds, other: &Bounds) -> bool {
    match (&own.exact, &other.exact) {
        (Some(own), Some(other)) => own < other,
        _ => own.interval.lower < other.interval.lower,
    }
}
