//! Episodes of an agent under a shield.

use std::collections::HashMap;
use std::sync::OnceLock;

use meliora_model::State;
use meliora_planning::{Shield, ShieldNode, ShieldVariable};

/// A shield with indices, to follow episodes. The states of an agent have no monitors.
///
/// ```
/// # use meliora::{Kind, Missed, Model, Options, Position, Settings, Shield, ShieldTable, SourceFile};
/// let text = "mdp module m x : [0..3] init 1; [up] x<3 -> (x'=x+1); [down] x>0 -> (x'=x-1); endmodule";
/// let wishes = SourceFile::new("wishes", "objective A = F x=2; objective B = G x>0; prefer B > A;");
/// let mut found = Model::parse(text, "")?.explore(Settings::default())?.prefer(&wishes, Options::default())?;
/// found.run(&mut |_| ())?;
/// let table = ShieldTable::from(Shield::new(&mut found.strategy(Kind::Sasi)?, 100)?);
/// let start = table.start(&[1]).unwrap();
/// let at = Position { node: Some(start), taken: None };
/// assert_eq!(table.observe(at, &[1], false), Ok(start));
/// assert_eq!(table.observe(at, &[3], false), Err(Missed::Step(None)));
/// let up = table.observe(at, &[2], false).unwrap();
/// assert!(table.is_at(up, &[2]));
/// # Ok::<(), meliora::Error>(())
/// ```
pub struct ShieldTable {
    /// The shield.
    pub shield: Shield,
    starts: HashMap<State, usize>,
    /// For each node, the position of its mask.
    mask_of: Vec<usize>,
    /// The different masks: for each action, true if it is permitted.
    masks: Vec<Vec<bool>>,
    /// For each state, the mask of its nodes; `None` if they have several.
    of_states: OnceLock<HashMap<State, Option<usize>>>,
}

/// The position of an episode.
#[derive(Debug, Clone, Copy, Default)]
pub struct Position {
    /// The node; `None` before the first state.
    pub node: Option<usize>,
    /// The action that was taken in the node.
    pub taken: Option<usize>,
}

/// The reason why an episode cannot continue in a state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Missed {
    /// Episodes do not start in the state.
    Start,
    /// The action, or no action if it is not known, does not lead to the state.
    Step(Option<usize>),
}

impl From<Shield> for ShieldTable {
    fn from(shield: Shield) -> Self {
        let starts = shield.nodes[..shield.starts].iter().enumerate();
        let starts = starts.map(|(at, node)| (node.state.clone(), at)).collect();
        let (mut masks, mut known) = (Vec::new(), HashMap::new());
        let mut mask_of = |node: &ShieldNode| {
            let mask = mask(node, shield.actions.len());
            *known.entry(mask).or_insert_with_key(|mask: &Vec<bool>| {
                masks.push(mask.clone());
                masks.len() - 1
            })
        };
        let mask_of = shield.nodes.iter().map(&mut mask_of).collect();
        ShieldTable { shield, starts, mask_of, masks, of_states: OnceLock::new() }
    }
}

impl ShieldTable {
    /// Returns the different masks: for each action, true if it is permitted.
    pub fn masks(&self) -> &[Vec<bool>] {
        &self.masks
    }

    /// Returns the position of the mask of a node among [`ShieldTable::masks`].
    pub fn mask_of(&self, node: usize) -> usize {
        self.mask_of[node]
    }

    /// Returns the variables that an agent knows: those of the model.
    pub fn variables(&self) -> impl Iterator<Item = &ShieldVariable> {
        self.shield.variables.iter().filter(|variable| variable.monitor.is_none())
    }

    /// Returns the values of a node's state without those of monitors.
    pub fn shown(&self, node: usize) -> impl Iterator<Item = i64> {
        let all = self.shield.variables.iter().zip(&self.shield.nodes[node].state);
        all.filter(|(variable, _)| variable.monitor.is_none()).map(|(_, value)| *value)
    }

    /// Returns the node in which an episode starts.
    ///
    /// # Errors
    /// The state is not the start of an episode.
    pub fn start(&self, values: &[i64]) -> Result<usize, Missed> {
        let mut values = values.iter();
        let of = |variable: &ShieldVariable| variable.monitor.or_else(|| values.next().copied());
        let state: Option<State> = self.shield.variables.iter().map(of).collect();
        state.and_then(|state| self.starts.get(&state).copied()).ok_or(Missed::Start)
    }

    /// Returns the node that an episode is in when it observes a state. `again` says that the present
    /// state is a step, too.
    ///
    /// # Errors
    /// The state does not follow.
    pub fn observe(&self, at: Position, values: &[i64], again: bool) -> Result<usize, Missed> {
        let Some(node) = at.node else { return self.start(values) };
        let stays = at.taken.is_none() && !again;
        if stays && self.is_at(node, values) {
            return Ok(node);
        }
        let actions = &self.shield.nodes[node].actions;
        let possible = actions.iter().filter(|action| at.taken.is_none_or(|taken| action.action == taken));
        let mut next = possible.flat_map(|action| &action.next).copied();
        next.find(|&to| self.is_at(to, values)).ok_or(Missed::Step(at.taken))
    }

    /// Returns whether a node has this state.
    pub fn is_at(&self, node: usize, values: &[i64]) -> bool {
        self.shown(node).eq(values.iter().copied())
    }

    /// Returns the action if it is permitted in a node, else a permitted one that makes progress where there is one.
    pub fn correct(&self, node: usize, action: usize) -> usize {
        let ShieldNode { actions, pick, .. } = &self.shield.nodes[node];
        if self.masks[self.mask_of[node]][action] { action } else { actions[*pick].action }
    }

    /// Returns the position of the mask of all nodes with a state; `None` if no node has it, and `Some(None)` if
    /// their masks differ.
    pub fn mask_of_state(&self, values: &[i64]) -> Option<Option<usize>> {
        let of_states = self.of_states.get_or_init(|| {
            let mut all = HashMap::new();
            for (node, &mask) in self.mask_of.iter().enumerate() {
                let known = all.entry(self.shown(node).collect()).or_insert(Some(mask));
                *known = known.filter(|&known| known == mask);
            }
            all
        });
        of_states.get(values).copied()
    }
}

fn mask(node: &ShieldNode, actions: usize) -> Vec<bool> {
    let mut mask = vec![false; actions];
    node.actions.iter().filter(|action| action.permitted).for_each(|action| mask[action.action] = true);
    mask
}
