//! A program prepared for fast steps: compiled expressions, and commands by factor.

use ahash::AHashMap;

use super::bounds::Bounds;
use super::by_value::ByValue;
use super::compile::Compiler;
use super::guards::{Candidates, Guards};
use super::layout::{self, Field, Layout};
use super::machine::{Code, Entry};
use super::needs::{Way, Ways, of_all};
use super::numbers::Numbers;
use super::value_classes::{MOST_LISTED, ValueClasses};
use meliora_base::error::Result;
use meliora_base::exact::Exact;
use meliora_base::progress::{Poll, ProgressSink};
use meliora_base::rounding::Sum;
use meliora_model::expr::{ExprId, Node};
use meliora_model::{Branch, Command, CommandId, ModelKind, Program, VarId};

/// A program compiled for the codes of one layout.
pub struct Prepared {
    pub(crate) code: Code,
    pub(crate) commands: Vec<Ready>,
    /// The commands of each participant. Participants that occur in several synchronisations are
    /// stored once.
    pub(crate) factors: Vec<Factor>,
    /// For each synchronisation, its factors.
    pub(crate) synchronisations: Vec<Vec<usize>>,
    /// The synchronisations by the values of variables.
    pub(crate) by_value: ByValue,
    /// True if all combinations form a single choice.
    pub(crate) uniform: bool,
    pub(crate) initial: Entry,
    /// True if the expression for the initial states may have no value in some state.
    pub(crate) initial_is_partial: bool,
    /// The variables of monitors.
    pub(crate) monitors: Vec<(usize, Field)>,
    /// The participant that is enabled in deadlocks, if monitors step there.
    pub(crate) alone: Option<usize>,
}

/// The commands of a participant.
pub struct Factor {
    pub(crate) candidates: Candidates,
    /// True if guards and probabilities of all its commands are valid in every state.
    pub(crate) is_sound: bool,
    /// The values of variables that its commands tell apart, unless these are too many.
    pub(crate) classes: Option<ValueClasses>,
    /// The bits of a code on which these classes depend.
    pub(crate) mask: layout::Code,
}

/// A command.
pub struct Ready {
    pub(crate) chances: Chances,
    /// The branches whose probability is not the constant 0.
    pub(crate) branches: Vec<ReadyBranch>,
}

/// The properties of a command's probabilities that are known in advance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Chances {
    /// They are constants and a distribution.
    Sound,
    /// They are constants and sum to 1 only after rounding.
    Rounded,
    /// They are constants and not a distribution.
    Broken,
    /// They depend on the state.
    Vary,
}

/// A branch of a command.
pub struct ReadyBranch {
    /// Its probability, if it depends on the state.
    pub(crate) probability: Option<Entry>,
    pub(crate) updates: Vec<Update>,
}

/// A new value of a variable.
pub struct Update {
    pub(crate) variable: usize,
    pub(crate) field: Field,
    pub(crate) value: Entry,
    /// True if the register contains the value without a computation.
    pub(crate) is_given: bool,
}

impl Prepared {
    /// Compiles all expressions of `program`.
    ///
    /// # Errors
    /// The work is cancelled.
    pub fn new(program: &Program, layout: &Layout, sink: &dyn ProgressSink) -> Result<Self> {
        let mut poll = Poll::new(sink);
        let (mut bounds, mut ways) = (Bounds::new(program, &program.pool), Ways::new(program, &program.pool));
        let (participants, synchronisations) = participants(program);
        let mut read =
            |commands: &&[CommandId]| Guards::new(program, commands, (&mut bounds, &mut ways), &mut poll);
        let guards: Vec<Guards> = participants.iter().map(&mut read).collect::<Result<_>>()?;
        let mut roots = roots(program);
        roots.extend(guards.iter().flat_map(Guards::roots));
        let mut compiler = Compiler::new(program, &program.pool, &roots, &mut poll)?;
        let mut commands: Vec<Ready> = Vec::with_capacity(program.commands.len());
        for command in &program.commands {
            poll.step()?;
            commands.push(ready(program, layout, command, &mut compiler));
        }
        let initial = compiler.condition(program.initial);
        let mut sound = |c: &CommandId| {
            bounds.is_total(program.commands[c.index()].guard)
                && commands[c.index()].chances == Chances::Sound
        };
        let (mut factors, mut room) = (Vec::with_capacity(guards.len()), MOST_LISTED);
        for (guards, own) in guards.iter().zip(&participants) {
            let candidates = guards.compile(&mut compiler, &mut ways, &mut poll)?;
            let chances = |command: CommandId| commands[command.index()].chances;
            let classes = ValueClasses::new(program, own, chances, &mut room);
            let mask = layout.mask(classes.iter().flat_map(ValueClasses::variables));
            factors.push(Factor { candidates, is_sound: own.iter().all(&mut sound), classes, mask });
        }
        let needs = guards.iter().map(|guards| of_all(guards.ways.iter().flatten()));
        let by_value =
            ways.list(&of_synchronisations(&synchronisations, &factors, &needs.collect::<Vec<_>>()));
        let watching = program.monitors.as_ref();
        let field = |v: &VarId| (v.index(), layout.field(v.index()));
        Ok(Prepared {
            monitors: watching.iter().flat_map(|o| o.variables.iter().map(field)).collect(),
            alone: watching
                .and_then(|o| o.deadlock)
                .and(synchronisations.last())
                .and_then(|s| s.first().copied()),
            code: compiler.finish(),
            commands,
            factors,
            synchronisations,
            by_value,
            uniform: program.kind == ModelKind::Dtmc,
            initial,
            initial_is_partial: !bounds.is_total(program.initial),
        })
    }
}

impl Prepared {
    /// Returns whether all combinations form a single choice.
    pub fn is_uniform(&self) -> bool {
        self.uniform
    }

    /// Returns whether monitors step in deadlocks.
    pub fn steps_alone(&self) -> bool {
        self.alone.is_some()
    }
}

/// Returns the commands of each participant, each once, and the participants of each
/// synchronisation.
fn participants(program: &Program) -> (Vec<&[CommandId]>, Vec<Vec<usize>>) {
    let mut known: AHashMap<&[CommandId], usize> = AHashMap::new();
    let (mut all, mut synchronisations) = (Vec::new(), Vec::new());
    for synchronisation in &program.synchronisations {
        let mut own = Vec::new();
        for commands in &synchronisation.factors {
            own.push(*known.entry(commands).or_insert_with(|| {
                all.push(commands.as_slice());
                all.len() - 1
            }));
        }
        synchronisations.push(own);
    }
    (all, synchronisations)
}

/// Returns the needs of each synchronisation: those of its factors. One with a factor that may have a fault is
/// always listed, so that the fault is found.
fn of_synchronisations(synchronisations: &[Vec<usize>], factors: &[Factor], needs: &[Way]) -> Vec<Vec<Way>> {
    let of = |own: &Vec<usize>| match own.iter().all(|&factor| factors[factor].is_sound) {
        true => vec![own.iter().flat_map(|&factor| needs[factor].clone()).collect()],
        false => vec![Way::new()],
    };
    synchronisations.iter().map(of).collect()
}

/// Returns every expression of the branches and that of the initial states, once per use.
fn roots(program: &Program) -> Vec<ExprId> {
    let mut roots = vec![program.initial];
    for command in &program.commands {
        for branch in &command.branches {
            roots.push(branch.probability);
            roots.extend(branch.updates.iter().map(|(_, e)| *e));
        }
    }
    roots
}

fn ready(program: &Program, layout: &Layout, command: &Command, compiler: &mut Compiler<'_>) -> Ready {
    let chances = chances(program, command);
    let mut branches = Vec::new();
    for branch in &command.branches {
        let constant = program.pool.exact_literal(branch.probability).map(Exact::into_real);
        // A sum that depends on the state needs all probabilities, including those that are 0.
        if chances == Chances::Vary || constant.is_some_and(|p| !p.is_zero()) {
            let probability = (chances == Chances::Vary).then(|| compiler.real(branch.probability));
            branches.push(ReadyBranch { probability, updates: updates(program, layout, branch, compiler) });
        }
    }
    Ready { chances, branches }
}

fn updates(program: &Program, layout: &Layout, branch: &Branch, compiler: &mut Compiler<'_>) -> Vec<Update> {
    let mut updates = Vec::new();
    for &(variable, e) in &branch.updates {
        let node = program.pool.node(e);
        if node != Node::Var(variable) {
            let is_given = matches!(node, Node::Literal(_) | Node::Var(_));
            let index = variable.index();
            let value = compiler.value(e);
            updates.push(Update { variable: index, field: layout.field(index), value, is_given });
        }
    }
    updates
}

fn chances(program: &Program, command: &Command) -> Chances {
    let mut numbers = Numbers::default();
    let mut places = Vec::with_capacity(command.branches.len());
    for branch in &command.branches {
        let Some(p) = program.pool.exact_literal(branch.probability) else { return Chances::Vary };
        places.push(numbers.place(p.into_real()));
    }
    match numbers.judge(places) {
        Ok(Sum::One) => Chances::Sound,
        Ok(Sum::Rounded) => Chances::Rounded,
        Ok(Sum::Wrong) | Err(_) => Chances::Broken,
    }
}
