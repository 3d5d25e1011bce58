//! A second opinion on the transition relation. The engine that rebuilds it shares its evaluation of
//! expressions with the program that wrote the dump, so a mistake there would be accepted. Here, all
//! operations on constants are computed again, and the choices and successors of some states.
//!
//! The states are all states of a small model. Otherwise they are the ones in which a probability
//! that depends on the state is 0 or least; a state for each number of a choice; and a state of each
//! set of the dump.

use std::collections::BTreeSet;

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use super::checker::Checker;
use super::condition::Condition;
use super::error::{CheckError, CheckResult};
use super::evaluation::{Evaluation, agrees};
use super::sample;
use meliora_engine::symbolic::{Numbered, SymbolicEngine};
use meliora_engine::{Algebra, Count, Engine};
use meliora_model::expr::ExprPool;
use meliora_model::predicate::Predicate;
use meliora_model::step::Choice;
use meliora_model::{Branch, CommandId, ModelKind, Program, State};

/// Largest deviation of a sum of probabilities from 1, in billionths: 1e-5, and a margin for doubles.
const TOLERATED: i64 = 10_001;

/// Maximum number of choices of a state that is looked at.
const MOST_CHOICES: usize = 1 << 10;

/// Checks the transition relation of the engine.
pub(super) fn check(checker: &Checker<'_>) -> CheckResult {
    let program = checker.engine.program();
    let conditions = checker.preferences.predicates().map(Predicate::pool);
    let mut pools: Vec<&ExprPool> = std::iter::once(&*program.pool).chain(conditions).collect();
    pools.dedup_by(|a, b| std::ptr::eq(*a, *b));
    pools.into_iter().try_for_each(constants)?;
    let sets = checker.regions.all_states().chain(checker.proof.all_states()).map(|(_, x)| x);
    let numbered = checker.engine.numbered_choices();
    for state in sample::states(&checker.engine, sets)? {
        if let Some(limit) = checker.engine.settings().sink.stop() {
            return Err(CheckError::Error(limit.into()));
        }
        step(&checker.engine, &numbered, program, &state)?;
    }
    Ok(())
}

/// Checks that each operation on constants has the value with which the model was read.
fn constants(pool: &ExprPool) -> CheckResult {
    match pool.folds().all(|(operation, literal)| agrees(pool, operation, literal)) {
        true => Ok(()),
        false => Err(CheckError::violated(Condition::Constants, None)),
    }
}

/// Checks the choices of a state and their successors, unless the second evaluation has no value for
/// some expression. `numbered` are the numbered choices of the engine.
fn step(engine: &SymbolicEngine, numbered: &[Numbered], program: &Program, state: &State) -> CheckResult {
    let Some(expected) = Stepper::new(program, state).choices()? else { return Ok(()) };
    let wrong = |condition| Err(CheckError::violated(condition, Some(state.clone())));
    let here = engine.choices_in(&engine.all_choices(), &engine.singleton(state)?)?;
    if engine.count(&here)? != Count::from(expected.len()) {
        return wrong(Condition::StateChoices);
    }
    if !has_owner(engine, state, expected.iter().map(|(choice, _)| choice))? {
        return wrong(Condition::StateOwner);
    }
    for (choice, successors) in expected {
        let enabled = engine.contains_choice(&here, state, &choice)?;
        let number = numbered.iter().position(|numbered| stands_for(numbered, &choice));
        let Some(number) = number.filter(|_| enabled) else {
            return wrong(Condition::StateChoices);
        };
        let next = engine.post(&engine.intersection(&here, &engine.only(number))?)?;
        let next = engine.list_states(&next, successors.len() + 1)?;
        if next.into_iter().collect::<BTreeSet<State>>() != successors {
            return wrong(Condition::Branches);
        }
    }
    Ok(())
}

/// Returns whether a state of a game belongs to the player of these choices, its only ones, and to the
/// opponent if that player is not one of us. A deadlock belongs to nobody.
fn has_owner<'c>(
    engine: &SymbolicEngine,
    state: &State,
    choices: impl Iterator<Item = &'c Choice>,
) -> CheckResult<bool> {
    let program = engine.program();
    let Some(players) = &program.players else { return Ok(true) };
    // A choice that no player lists has the owner of the other choices; alone, it is the first player's.
    let mut unlisted = 0;
    let owner = |choice: &Choice| {
        let Choice::Combination { synchronisation, commands } = choice else { return Some(None) };
        let action = program.synchronisations[*synchronisation].action;
        let command = &program.commands[commands.first()?.index()];
        unlisted += usize::from(command.unlisted.is_some());
        // An action without an owner belongs to the module that has it, as in games state by state.
        let listed = action.and_then(|action| *players.of_action.get(action)?);
        command.unlisted.is_none().then(|| listed.or_else(|| *players.of_module.get(command.module)?))
    };
    let mut owners: BTreeSet<Option<usize>> = choices.filter_map(owner).collect();
    if unlisted == 1 && owners.is_empty() {
        owners.insert(Some(0));
    }
    let mut right = owners.len() == 1;
    for (number, states) in engine.player_states().iter().enumerate() {
        right &= engine.contains(states, state)? == owners.contains(&Some(number));
    }
    let is_theirs = engine.theirs().map_or(Ok(false), |theirs| engine.contains(&theirs, state))?;
    let ours = |owner: &Option<usize>| owner.is_none_or(|number| players.list[number].ours);
    Ok(right && is_theirs != owners.iter().all(ours))
}

fn stands_for(numbered: &Numbered, choice: &Choice) -> bool {
    match (numbered, choice) {
        (Numbered::Uniform, Choice::Uniform) | (Numbered::Deadlock, Choice::Deadlock) => true,
        (
            Numbered::Combinations { synchronisation, commands },
            Choice::Combination { synchronisation: own, commands: taken },
        ) => own == synchronisation && commands.iter().zip(taken).all(|(factor, id)| factor.contains(id)),
        _ => false,
    }
}

/// The steps of a state, by the definition.
struct Stepper<'p> {
    program: &'p Program,
    state: &'p State,
    evaluation: Evaluation<'p>,
}

/// The choices of a state with their successors; `None` if an expression has no value, or there are
/// too many.
type Choices = Option<Vec<(Choice, BTreeSet<State>)>>;

impl<'p> Stepper<'p> {
    fn new(program: &'p Program, state: &'p State) -> Self {
        Stepper { program, state, evaluation: Evaluation::new(&program.pool, state) }
    }

    fn choices(&mut self) -> CheckResult<Choices> {
        let mut all = Vec::new();
        for (synchronisation, definition) in self.program.synchronisations.iter().enumerate() {
            let Some(combinations) = self.combinations(&definition.factors) else { return Ok(None) };
            for commands in combinations {
                let Some(successors) = self.successors(&commands)? else { return Ok(None) };
                all.push((Choice::Combination { synchronisation, commands }, successors));
            }
            if all.len() > MOST_CHOICES {
                return Ok(None);
            }
        }
        if all.is_empty() {
            return Ok(Some(vec![(Choice::Deadlock, BTreeSet::from([self.state.clone()]))]));
        }
        Ok(Some(match self.program.kind {
            ModelKind::Mdp | ModelKind::Smg => all,
            ModelKind::Dtmc => {
                vec![(Choice::Uniform, all.into_iter().flat_map(|(_, successors)| successors).collect())]
            }
        }))
    }

    /// Returns the combinations of enabled commands, one of each factor.
    fn combinations(&mut self, factors: &[Vec<CommandId>]) -> Option<Vec<Vec<CommandId>>> {
        let mut combinations = vec![Vec::new()];
        for factor in factors {
            let mut longer = Vec::new();
            for &id in factor {
                if self.evaluation.truth(self.program.commands[id.index()].guard)? {
                    let with = |shorter: &Vec<CommandId>| shorter.iter().copied().chain([id]).collect();
                    longer.extend(combinations.iter().map(with));
                }
            }
            combinations = longer;
            if combinations.len() > MOST_CHOICES {
                return None;
            }
        }
        Some(combinations)
    }

    /// Returns the states after commands that are executed together.
    fn successors(&mut self, commands: &[CommandId]) -> CheckResult<Option<BTreeSet<State>>> {
        let mut reached = BTreeSet::from([self.state.clone()]);
        for &id in commands {
            let Some(branches) = self.branches(id)? else { return Ok(None) };
            let mut next = BTreeSet::new();
            for branch in branches {
                for from in &reached {
                    let Some(to) = self.updated(branch, from) else { return Ok(None) };
                    next.insert(to);
                }
            }
            reached = next;
        }
        Ok(Some(reached))
    }

    /// Returns the branches of positive probability of an enabled command. The probabilities must
    /// sum to 1.
    fn branches(&mut self, id: CommandId) -> CheckResult<Option<Vec<&'p Branch>>> {
        let program: &'p Program = self.program;
        let (mut taken, mut sum) = (Vec::new(), BigRational::zero());
        for branch in &program.commands[id.index()].branches {
            let Some(p) = self.evaluation.number(branch.probability) else { return Ok(None) };
            if p.is_positive() {
                taken.push(branch);
            }
            sum = if p.is_negative() { -BigRational::one() } else { sum + p };
        }
        if (sum - BigRational::one()).abs() > BigRational::new(TOLERATED.into(), 1_000_000_000.into()) {
            return Err(CheckError::violated(Condition::Distribution, Some(self.state.clone())));
        }
        Ok(Some(taken))
    }

    /// Returns a state with the new values of a branch.
    fn updated(&mut self, branch: &Branch, from: &State) -> Option<State> {
        let mut to = from.clone();
        for &(variable, e) in &branch.updates {
            let value = self.evaluation.number(e).filter(BigRational::is_integer)?;
            to[variable.index()] = value.to_integer().try_into().ok()?;
        }
        Some(to)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::evaluation::Value;
    use super::*;
    use meliora_base::error::SourceFile;
    use meliora_base::exact::Exact;
    use meliora_base::value;
    use meliora_engine::Settings;
    use meliora_lang as lang;
    use meliora_model::expr::{Binary, Node};

    fn program(commands: &str) -> Program {
        let text = format!("mdp const double p = 1/3; module m x:[0..5] init 0; {commands} endmodule");
        lang::load(&SourceFile::new("model", text), &SourceFile::new("constants", "")).unwrap().program
    }

    /// Returns the condition that the relation of one model violates for another one.
    fn violated(truth: &str, other: &str) -> Option<Condition> {
        let (truth, other) = (program(truth), Arc::new(program(other)));
        let engine = SymbolicEngine::new(other, Settings::default()).unwrap();
        let numbered = engine.numbered_choices();
        let states = sample::states(&engine, [].into_iter()).unwrap_or_default();
        assert!(!states.is_empty());
        states.iter().find_map(|state| match step(&engine, &numbered, &truth, state) {
            Err(CheckError::Violation(violation)) => Some(violation.condition),
            Err(CheckError::Error(error)) => panic!("{error}"),
            Ok(()) => None,
        })
    }

    #[test]
    fn a_branch_too_many_or_too_few_is_found_however_small_its_probability() {
        let with = |p: &str| format!("[a] x=0 -> {p}:(x'=1) + 1-({p}):(x'=2); [b] x>0 -> true;");
        for (truth, other) in [
            ("0.1+0.2-0.3", "1e-400"),
            ("1e-400", "0"),
            ("1-(1-1e-30)", "0"),
            ("p-1/3", "0.5"),
            ("(x+1)*p-1/3", "x+1e-300"),
            ("x=0 ? 1e-400 : 0.5", "0.1*x"),
            ("pow(0.1,400)", "0"),
            ("mod(x+5,3)-2", "0.1"),
        ] {
            let (truth, other) = (with(truth), with(other));
            assert_eq!(violated(&truth, &other), Some(Condition::Branches), "{truth} {other}");
            assert_eq!(violated(&truth, &truth), None, "{truth}");
            assert_eq!(violated(&other, &other), None, "{other}");
        }
    }

    #[test]
    fn choices_too_many_or_too_few_are_found() {
        let guarded = |guard: &str| format!("[a] {guard} -> (x'=2); [b] x>0 & x<4 -> (x'=x+1);");
        for guard in ["0.1+0.2>0.3", "0.1*3!=0.3", "ceil(x*0.1)=2", "min(x,2)>x"] {
            let (truth, other) = (guarded(guard), guarded("true"));
            assert_eq!(violated(&truth, &other), Some(Condition::StateChoices), "{guard}");
            assert_eq!(violated(&other, &truth), Some(Condition::StateChoices), "{guard}");
            assert_eq!(violated(&truth, &truth), None, "{guard}");
        }
    }

    #[test]
    fn probabilities_that_do_not_sum_to_1_are_found() {
        let with = |p: &str| format!("[a] x=0 -> 0.5:(x'=1) + {p}:(x'=2); [b] x>0 -> true;");
        assert_eq!(violated(&with("0.499"), &with("0.5")), Some(Condition::Distribution));
        assert_eq!(violated(&with("0.4999999"), &with("0.5")), None);
    }

    #[test]
    fn all_expressions_have_the_same_value_by_both_evaluations() {
        let program = program(
            "[a] x<5 & !(x=3) | x=4 -> (x=2 ? 0.3 : x/7):(x'=min(x+1,5)) + 1-(x=2 ? 0.3 : x/7):(x'=max(x-1,0));
             [b] floor(x/2)=1 & round(x*0.5)<=2 | ceil(-x/3)<0 -> pow(p,x):(x'=mod(x+4,6)) + 1-pow(p,x):true;
             [c] pow(x,2)>=4 & pow(2,-1.0*x)<0.3 => x!=1 -> 1/3:true + p:(x'=0) + p:(x'=5-x);",
        );
        let mut compared = 0;
        for state in (0..=5).map(|x| vec![x]) {
            let mut evaluation = Evaluation::new(&program.pool, &state);
            for id in program.pool.ids() {
                let (Ok(known), Some(own)) = (program.pool.exact(id, &state), evaluation.value(id)) else {
                    continue;
                };
                let known = match known {
                    Exact::Bool(b) => Value::Truth(b),
                    known => Value::Number(known.into_real().finite().unwrap().clone()),
                };
                assert_eq!(own, known, "{:?} in {state:?}", program.pool.node(id));
                compared += 1;
            }
        }
        assert!(compared > 300, "{compared}");
        assert!(program.pool.folds().count() > 2);
        assert!(constants(&program.pool).is_ok());
    }

    #[test]
    fn a_constant_that_was_folded_wrongly_is_found() {
        let program = program("[a] x=0 -> (0.1+0.2):(x'=1) + 0.7:true;");
        let mut pool = ExprPool::over(&program.pool);
        let [a, b, sum, near] = [0.1, 0.2, 0.3, 0.1 + 0.2].map(|x| pool.value(value::Value::Real(x)));
        let operation = Node::Binary(Binary::Add, a, b);
        assert!(pool.folds().any(|fold| fold == (operation, sum)));
        assert!(agrees(&pool, operation, sum));
        assert!(!agrees(&pool, operation, near));
    }
}
