//! Explanations of permitted and forbidden actions.

use meliora::output::reason::Words;
use meliora::planning::Rank;
use meliora::planning::explain::{Action as Enabled, Explanation as Explained, Successor as Reached};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::values::{Names, rank_of_safe};

/// A state under a strategy, with every enabled action.
#[pyclass(frozen, get_all, module = "meliora")]
pub(crate) struct Explanation {
    /// The state.
    state: Py<PyDict>,
    /// The player of a game that chooses in the state; None for deadlocks and other models.
    owner: Option<String>,
    /// True if this is the opponent: then no action is permitted or forbidden, and reasons say what the
    /// actions lead to.
    theirs: bool,
    /// True if no strategy keeps the requirements from the state.
    r#unsafe: bool,
    /// The most preferred objectives of the state; empty if it is unsafe.
    most_preferred: Py<PyTuple>,
    /// The rank of the state: an int, or `math.inf`; `math.nan` if it is unsafe.
    rank: Py<PyAny>,
    /// The objective that the strategy pursues, or several as "C and D"; None while it improves, and for
    /// strategies that achieve none.
    pursues: Option<String>,
    /// The pursued objectives that are not achieved yet: several if they are pursued together.
    left: Py<PyTuple>,
    /// True if the plan commits to the objective that it pursues: kept actions alone do not achieve
    /// it, and its steps may give up others.
    commits: bool,
    /// The objectives that are achieved in the state; empty for strategies that achieve none.
    achieved: Py<PyTuple>,
    /// The action of the progress strategy; None where the strategy ends.
    progress_action: Option<String>,
    /// All enabled actions, in the order of the program.
    actions: Py<PyTuple>,
}

/// An enabled action.
#[pyclass(frozen, get_all, module = "meliora")]
pub(crate) struct Action {
    /// Its name.
    name: String,
    /// True if the safety mode keeps the action; False where the opponent chooses.
    kept: bool,
    /// True if the strategy permits it.
    permitted: bool,
    /// True if it comes closer to an improvement, or to the pursued objective, with positive
    /// probability.
    progress: bool,
    /// The reason in one word: `"improves"`, `"may-improve"`, `"approaches"`, `"stays"`,
    /// `"weakens"`, `"exposes"` (the opponent can weaken afterwards), `"unsafe"`, `"violates"`, `"strays"`,
    /// `"hopeless"` or `"nothing-ahead"`; while an objective is pursued `"achieves"`, `"may-achieve"`,
    /// `"nears"`, `"keeps"`, `"forfeits"` or `"unachievable"`; where a rule makes an objective as likely as
    /// possible `"likeliest"`, `"passed-over"` or `"impossible"`. What an action of the opponent leads to is
    /// also `"lateral"`.
    verdict: &'static str,
    /// The reason in a sentence.
    reason: String,
    /// The possible successors.
    successors: Py<PyTuple>,
}

/// A successor of an action.
#[pyclass(frozen, get_all, module = "meliora")]
pub(crate) struct Successor {
    /// The state.
    state: Py<PyDict>,
    /// The probability of this successor.
    probability: f64,
    /// True if no strategy keeps the requirements from this successor.
    r#unsafe: bool,
    /// The most preferred objectives of this successor; empty if it is unsafe.
    most_preferred: Py<PyTuple>,
    /// Its rank: an int, or `math.inf`; `math.nan` if it is unsafe.
    rank: Py<PyAny>,
    /// The kind of the step: `"improving"`, `"weakening"` or `"lateral"`.
    change: &'static str,
    /// The most preferred objectives of the successor that are preferred to one of the state (of the
    /// reference class under `prefix`).
    gained: Py<PyTuple>,
    /// The most preferred objectives of the state (of the reference class under `prefix`) that are
    /// preferred to one of the successor.
    lost: Py<PyTuple>,
    /// True if `safety="transition"` ignores this branch.
    dropped: bool,
    /// True if it is an improvement that the strategy counts, or achieves the pursued objective.
    goal: bool,
}

impl Explanation {
    pub(crate) fn new(
        py: Python<'_>,
        names: &Names,
        at: &Explained,
        rank: Rank,
        words: Words<'_>,
    ) -> PyResult<Self> {
        let action = |action| Py::new(py, Action::new(py, names, at, action, words)?);
        let actions = at.actions.iter().map(action).collect::<PyResult<Vec<_>>>()?;
        Ok(Explanation {
            state: names.dict(py, &at.state)?.unbind(),
            owner: words.player(at).map(str::to_owned),
            theirs: at.is_theirs(),
            r#unsafe: at.is_unsafe,
            most_preferred: PyTuple::new(py, words.names(&at.most_preferred))?.unbind(),
            rank: rank_of_safe(py, at.is_unsafe, rank)?.unbind(),
            pursues: words.pursued(at),
            left: PyTuple::new(py, words.names(&at.left))?.unbind(),
            commits: at.commits() && !at.is_achieved(),
            achieved: PyTuple::new(py, words.names(&at.achieved))?.unbind(),
            progress_action: at.pick.map(|pick| at.actions[pick].name.clone()),
            actions: PyTuple::new(py, actions)?.unbind(),
        })
    }
}

impl Action {
    fn new(
        py: Python<'_>,
        names: &Names,
        at: &Explained,
        action: &Enabled,
        words: Words<'_>,
    ) -> PyResult<Self> {
        let successor = |reached| Py::new(py, Successor::new(py, names, reached, words)?);
        let successors = action.successors.iter().map(successor).collect::<PyResult<Vec<_>>>()?;
        Ok(Action {
            name: action.name.clone(),
            // As in JSON: what the opponent does is neither kept nor dropped.
            kept: action.kept && !at.is_theirs(),
            permitted: action.permitted,
            progress: action.progress,
            verdict: action.verdict.name(),
            reason: words.reason(at, action),
            successors: PyTuple::new(py, successors)?.unbind(),
        })
    }
}

impl Successor {
    fn new(py: Python<'_>, names: &Names, reached: &Reached, words: Words<'_>) -> PyResult<Self> {
        Ok(Successor {
            state: names.dict(py, &reached.state)?.unbind(),
            probability: reached.probability,
            r#unsafe: reached.is_unsafe,
            most_preferred: PyTuple::new(py, words.names(&reached.most_preferred))?.unbind(),
            rank: rank_of_safe(py, reached.is_unsafe, reached.rank)?.unbind(),
            change: reached.change.name(),
            gained: PyTuple::new(py, words.names(&reached.gained))?.unbind(),
            lost: PyTuple::new(py, words.names(&reached.lost))?.unbind(),
            dropped: reached.dropped,
            goal: reached.goal,
        })
    }
}

/// Formats a rank: `2 improvements`, or `any number of improvements`.
fn improvements(rank: &Bound<'_, PyAny>) -> PyResult<String> {
    Ok(match rank.extract::<f64>()? {
        f64::INFINITY => "any number of improvements".to_owned(),
        1.0 => "1 improvement".to_owned(),
        _ => format!("{rank} improvements"),
    })
}

#[pymethods]
impl Explanation {
    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let permitted = self.permitted(py)?.join(", ");
        Ok(format!("<Explanation of {}: permitted {permitted}>", self.state.bind(py).repr()?))
    }

    fn __str__(&self, py: Python<'_>) -> PyResult<String> {
        let ahead = match self.r#unsafe {
            true => "unsafe".to_owned(),
            false => format!("{} ahead", improvements(self.rank.bind(py))?),
        };
        let mover = match (&self.owner, self.theirs) {
            (Some(player), true) => format!(", {player} moves (the opponent)"),
            (Some(player), false) => format!(", {player} moves"),
            (None, _) => String::new(),
        };
        let mut text = format!("{}: {ahead}{mover}\n", self.state.bind(py).str()?);
        for action in self.actions.bind(py) {
            let action = action.cast::<Action>()?.get();
            let mark = match (action.permitted, action.progress) {
                (true, true) => "*",
                (true, false) => "+",
                _ => " ",
            };
            text.push_str(&format!("{mark} {}: {}\n", action.name, action.reason));
        }
        Ok(text)
    }
}

impl Explanation {
    fn permitted(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        let mut names = Vec::new();
        for action in self.actions.bind(py) {
            let action = action.cast::<Action>()?.get();
            if action.permitted {
                names.push(action.name.clone());
            }
        }
        Ok(names)
    }
}

#[pymethods]
impl Action {
    fn __repr__(&self) -> String {
        let permitted = if self.permitted { "permitted" } else { "not permitted" };
        format!("<Action {:?}, {permitted}: {}>", self.name, self.reason)
    }
}

#[pymethods]
impl Successor {
    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        Ok(format!("<Successor {} with probability {}>", self.state.bind(py).repr()?, self.probability))
    }
}
