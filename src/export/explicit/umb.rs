//! The writer of UMB archives.
//!
//! Probabilities and rewards are exact fractions. Labels and regions become atomic propositions,
//! ranks numbers of states (-1 if unbounded), permissive strategies sets of choices, and quantities
//! intervals of doubles.

use std::collections::{BTreeMap, BTreeSet};

use num_traits::Zero;

use super::exact::{Exact, Rewards, exact};
use super::graph::{Column, Graph};
use super::quantities::{Quantities, Quantity};
use meliora_base::error::{Error, Result};
use meliora_base::exact::Ratio;
use meliora_base::progress::ProgressSink;
use meliora_engine::Engine;
use meliora_formats::umb::archive::pack;
use meliora_formats::umb::binary::{bits, rational_bits, rationals, strings, words};
use meliora_formats::umb::index::{
    Annotation, Annotations, Base, Class, Field, FileData, Index, TransitionSystem, Type, Valuations,
    Variable,
};
use meliora_formats::umb::{
    self, ACTION_NAMES, ACTION_OF_CHOICE, BRANCH_TO_PROBABILITY, BRANCH_TO_TARGET, CHOICE_TO_BRANCHES, INDEX,
    STATE_IS_INITIAL, STATE_TO_CHOICES, STATE_TO_PLAYER, STATE_VALUATIONS,
};
use meliora_model::{Program, fault};
use meliora_planning::levels::{Level, Rank};
use meliora_planning::strategy::permitted_at_start;
use meliora_planning::{Analysis, Kind};

/// The rank of states in which any number of improvements can be made.
const UNBOUNDED: i64 = -1;

/// Writes a graph of an analysis as an archive, perhaps with the quantities of its states.
///
/// # Errors
/// The program has no meaning in a state; a limit is reached.
pub fn umb<E: Engine>(
    graph: &Graph,
    analysis: &Analysis<E>,
    program: &Program,
    quantities: Option<&Quantities>,
) -> Result<Vec<u8>> {
    archive(graph, Some(analysis), program, (quantities, &*analysis.engine().settings().sink))
}

/// Writes a graph without an analysis as an archive. Cost: one step of the program per state.
///
/// # Errors
/// The program has no meaning in a state; a limit is reached.
pub fn umb_of_chain(graph: &Graph, program: &Program, sink: &dyn ProgressSink) -> Result<Vec<u8>> {
    archive::<meliora_engine::ExplicitEngine>(graph, None, program, (None, sink))
}

fn archive<E: Engine>(
    graph: &Graph,
    analysis: Option<&Analysis<E>>,
    program: &Program,
    (quantities, sink): (Option<&Quantities>, &dyn ProgressSink),
) -> Result<Vec<u8>> {
    let numbers = exact(graph, program, sink)?;
    let mut writer = Writer { graph, files: Vec::new(), annotations: BTreeMap::new() };
    writer.transitions(&numbers);
    writer.players();
    let actions = if graph.is_dtmc { 0 } else { writer.actions() };
    for (name, states) in &graph.labels {
        writer.members("aps", name, "states", states);
    }
    for rewards in &numbers.rewards {
        writer.rewards(rewards);
    }
    for (analysis, &kind) in
        analysis.iter().flat_map(|analysis| Kind::ALL.iter().map(move |kind| (analysis, kind)))
    {
        writer.ranks(analysis, program, kind)?;
        // An induced model has the choices of one strategy only.
        if graph.columns.len() == program.variables.len() {
            let permitted = permitted(graph, analysis, program, kind)?;
            writer.members("strategies", kind.name(), "choices", &permitted);
        }
    }
    for quantity in quantities.iter().flat_map(|q| &q.list) {
        writer.quantity(quantity);
    }
    let valuations = writer.valuations();
    let index = Index {
        format_version: 1,
        format_revision: 0,
        file_data: Some(FileData {
            tool: Some("Meliora".to_owned()),
            tool_version: Some(env!("CARGO_PKG_VERSION").to_owned()),
        }),
        transition_system: system(graph, actions, rational_bits(&numbers.probabilities)),
        annotations: std::mem::take(&mut writer.annotations),
        valuations: BTreeMap::from([("states".to_owned(), valuations)]),
    };
    writer.pack(&index)
}

fn system(graph: &Graph, actions: usize, probability_bits: u32) -> TransitionSystem {
    TransitionSystem {
        time: "discrete".to_owned(),
        players: match &graph.players {
            Some(players) => u32::try_from(players.names.len()).unwrap_or(u32::MAX).max(2),
            None => u32::from(!graph.is_dtmc),
        },
        states: graph.states.len() as u64,
        initial_states: graph.initial.len() as u64,
        choices: graph.choices() as u64,
        choice_actions: u32::try_from(actions).unwrap_or(u32::MAX),
        branches: graph.transitions() as u64,
        branch_actions: 0,
        observations: 0,
        branch_probability_type: Some(Type::sized(Base::Rational, probability_bits)),
        player_names: graph.players.as_ref().map(|players| two_names(&players.names)),
    }
}

/// Returns the names of at least two players: a game of one player gets another one without states.
fn two_names(names: &[String]) -> Vec<String> {
    let mut names = names.to_vec();
    if let [only] = names.as_slice() {
        let other = format!("not_{only}");
        names.push(other);
    }
    names
}

/// Returns the numbers of the choices that the permissive strategy of a kind allows when planning
/// starts in their states. A strategy of a game chooses in our states only.
fn permitted<E: Engine>(
    graph: &Graph,
    analysis: &Analysis<E>,
    program: &Program,
    kind: Kind,
) -> Result<Vec<usize>> {
    let (engine, levels) = (analysis.engine(), analysis.levels(kind));
    let (Some(classes), Some(improvement)) = (analysis.classes(), analysis.improvement()) else {
        return Ok(Vec::new());
    };
    let of_level = |level: &Level<E>| permitted_at_start(engine, kind, classes, improvement, level);
    let finite = levels.found.iter().map(of_level).collect::<Result<Vec<_>>>()?;
    let unbounded = levels.unbounded().map(of_level).transpose()?;
    let is_ours = |state: usize| match (&graph.players, &program.players) {
        (Some(graph), Some(players)) => players.list[graph.owners[state]].ours,
        _ => true,
    };
    let (mut members, mut number) = (Vec::new(), 0);
    for (at, (state, rows)) in graph.states.iter().zip(&graph.rows).enumerate() {
        let allowed = match levels.rank(engine, state)? {
            Rank::Finite(k) | Rank::AtLeast(k) => k.checked_sub(1).and_then(|k| finite.get(k)),
            Rank::Unbounded => unbounded.as_ref(),
        };
        let choices = program.choices(state).map_err(|e| fault::error(program, &e, state))?;
        for (_, (choice, _)) in rows.iter().zip(&choices) {
            if let Some(allowed) = allowed
                && is_ours(at)
                && engine.contains_choice(allowed, state, choice)?
            {
                members.push(number);
            }
            number += 1;
        }
    }
    Ok(members)
}

/// The files of an archive under construction.
struct Writer<'g> {
    graph: &'g Graph,
    files: Vec<(String, Vec<u8>)>,
    annotations: BTreeMap<String, Annotations>,
}

impl Writer<'_> {
    fn add(&mut self, path: impl Into<String>, content: Vec<u8>) {
        self.files.push((path.into(), content));
    }

    fn transitions(&mut self, numbers: &Exact) {
        let graph = self.graph;
        self.add(STATE_TO_CHOICES, words(ends(graph.rows.iter().map(Vec::len))));
        self.add(STATE_IS_INITIAL, bits(graph.initial.iter().copied(), graph.states.len()));
        let rows = || graph.rows.iter().flatten();
        self.add(CHOICE_TO_BRANCHES, words(ends(rows().map(|row| row.successors.len()))));
        self.add(BRANCH_TO_TARGET, words(rows().flat_map(|row| row.successors.iter().map(|s| s.0))));
        let size = rational_bits(&numbers.probabilities);
        self.add(BRANCH_TO_PROBABILITY, rationals(&numbers.probabilities, size));
    }

    /// Writes the player of each state of a game.
    fn players(&mut self) {
        if let Some(players) = &self.graph.players {
            let number = |&owner: &usize| u32::try_from(owner).unwrap_or(u32::MAX).to_le_bytes();
            self.add(STATE_TO_PLAYER, players.owners.iter().flat_map(number).collect());
        }
    }

    /// Writes the actions of choices. Returns their number.
    fn actions(&mut self) -> usize {
        let graph = self.graph;
        let rows = || graph.rows.iter().flatten().map(|row| row.action.as_str());
        let names: Vec<&str> = rows().collect::<BTreeSet<_>>().into_iter().collect();
        let number = |name: &str| names.partition_point(|other| *other < name);
        let numbers = rows().flat_map(|name| u32::try_from(number(name)).unwrap_or(u32::MAX).to_le_bytes());
        self.add(ACTION_OF_CHOICE, numbers.collect());
        let [mapping, texts] = strings(names.iter().copied());
        self.add(format!("{ACTION_NAMES}/string-mapping.bin"), mapping);
        self.add(format!("{ACTION_NAMES}/strings.bin"), texts);
        names.len()
    }

    /// Adds an annotation to the index. Returns the folder of its values for states and for choices.
    fn annotation(&mut self, group: &str, name: &str, of: &[&str], ty: Type) -> Vec<String> {
        let group_of = &mut self.annotations.entry(group.to_owned()).or_default().0;
        let wanted: String = name.to_lowercase().chars().map(|c| if is_plain(c) { c } else { '_' }).collect();
        let (mut id, mut number) = (wanted.clone(), 2);
        while group_of.contains_key(&id) {
            id = format!("{wanted}_{number}");
            number += 1;
        }
        let applies_to = of.iter().map(|of| (*of).to_owned()).collect();
        let alias = Some(name.to_owned());
        let annotation = Annotation { alias, description: None, applies_to, ty, probability_type: None };
        group_of.insert(id.clone(), annotation);
        of.iter().map(|of| umb::annotation(group, &id, of) + "/values.bin").collect()
    }

    /// Adds a set of states or choices.
    fn members(&mut self, group: &str, name: &str, of: &str, members: &[usize]) {
        let n = if of == "states" { self.graph.states.len() } else { self.graph.choices() };
        for path in self.annotation(group, name, &[of], Type::sized(Base::Bool, 1)) {
            self.add(path, bits(members.iter().copied(), n));
        }
    }

    fn rewards(&mut self, rewards: &Rewards) {
        let both: [(&str, &[Ratio]); 2] = [("states", &rewards.states), ("choices", &rewards.choices)];
        let used: Vec<_> = both
            .into_iter()
            .filter(|(of, all)| *of == "choices" || !all.iter().all(Ratio::is_zero))
            .collect();
        let size = rational_bits(used.iter().flat_map(|(_, all)| all.iter()));
        let of: Vec<&str> = used.iter().map(|(of, _)| *of).collect();
        let paths = self.annotation("rewards", &rewards.name, &of, Type::sized(Base::Rational, size));
        for (path, (_, all)) in paths.into_iter().zip(used) {
            self.add(path, rationals(all, size));
        }
    }

    fn ranks<E: Engine>(&mut self, analysis: &Analysis<E>, program: &Program, kind: Kind) -> Result<()> {
        let mut ranks = Vec::new();
        for state in &self.graph.states {
            let rank = match analysis.rank(kind, &state[..program.variables.len()])? {
                Rank::Finite(k) | Rank::AtLeast(k) => i64::try_from(k).unwrap_or(i64::MAX),
                Rank::Unbounded => UNBOUNDED,
            };
            ranks.extend(rank.to_le_bytes());
        }
        for path in self.annotation("ranks", kind.name(), &["states"], Type::sized(Base::Int, 64)) {
            self.add(path, ranks.clone());
        }
        Ok(())
    }

    /// Adds the bounds of a quantity.
    fn quantity(&mut self, quantity: &Quantity) {
        let ty = Type::sized(Base::DoubleInterval, 128);
        for path in self.annotation("values", &quantity.name, &["states"], ty) {
            self.add(path, quantity.bounds.iter().flatten().flat_map(|x| x.to_le_bytes()).collect());
        }
        let group = self.annotations.get_mut("values");
        if let Some(annotation) = group.and_then(|group| group.0.get_mut(&quantity.name)) {
            annotation.description = Some(quantity.description.clone());
        }
    }

    /// Writes the values of states. Returns their description.
    fn valuations(&mut self) -> Valuations {
        let graph = self.graph;
        let fields: Vec<Variable> =
            graph.columns.iter().enumerate().map(|(i, c)| field(graph, i, c)).collect();
        let mut bytes = Vec::new();
        for state in &graph.states {
            for (value, field) in state.iter().zip(&fields) {
                bytes.extend(&value.to_le_bytes()[..field.ty.bits() as usize / 8]);
            }
        }
        self.add(format!("{STATE_VALUATIONS}/valuations.bin"), bytes);
        let variables = fields.into_iter().map(Field::Variable).collect();
        Valuations { unique: true, strings: None, classes: vec![Class { variables }] }
    }

    /// Packs the files, the index first.
    fn pack(mut self, index: &Index) -> Result<Vec<u8>> {
        let failed = |message: String| Error::Usage(format!("the archive cannot be written: {message}"));
        let text = serde_json::to_vec_pretty(index).map_err(|e| failed(e.to_string()))?;
        self.files.insert(0, (INDEX.to_owned(), text));
        pack(&self.files).map_err(|e| failed(e.to_string()))
    }
}

fn is_plain(c: char) -> bool {
    matches!(c, 'a'..='z' | '0'..='9' | '_' | '-')
}

/// Returns 0 and the partial sums.
fn ends(sizes: impl Iterator<Item = usize>) -> Vec<usize> {
    let sum = |end: &mut usize, size: usize| {
        *end += size;
        Some(*end)
    };
    std::iter::once(0).chain(sizes.scan(0, sum)).collect()
}

/// Returns the description of a variable: whole bytes, as few as its range needs.
fn field(graph: &Graph, position: usize, column: &Column) -> Variable {
    let values = || graph.states.iter().map(|state| state[position]);
    let found = || (values().min().unwrap_or_default(), values().max().unwrap_or_default());
    let (low, high) = column.range.unwrap_or_else(found);
    let fits = |bits: u32| low >= i64::MIN >> (64 - bits) && high <= i64::MAX >> (64 - bits);
    let bits = [8, 16, 32].into_iter().find(|bits| fits(*bits)).unwrap_or(64);
    let is_int = !column.is_bool;
    Variable {
        name: column.name.clone(),
        is_optional: false,
        ty: if is_int { Type::sized(Base::Int, bits) } else { Type::sized(Base::Bool, 8) },
        lower: is_int.then_some(low),
        upper: is_int.then_some(high),
        offset: None,
    }
}
