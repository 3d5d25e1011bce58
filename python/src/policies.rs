//! Policies of files, and the comparison of both engines: reports of the command.

use std::path::PathBuf;
use std::sync::Arc;

use meliora::commands::{GivenPolicy, Kept, PolicyAim, compare};
use meliora::output::policy_report::PolicyRuns;
use meliora::output::{CompareReport, Header, PolicyReport, Report};
use meliora::{Error, Settings, SourceFile};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use serde_json::to_string;

use crate::asking::ended;
use crate::errors::usage;
use crate::model::Model;
use crate::options::{self, ExploreOptions, count};
use crate::preferences;
use crate::region::Space;
use crate::worker::Call;
use crate::{files, values};

/// The arguments about what a policy is for.
type Aim<'a, 'py> = (Option<String>, Option<&'a Bound<'py, PyAny>>, bool);

#[pymethods]
impl Model {
    /// Checks a policy without the code that finds policies, as `meliora verify` does: each state that it visits needs an
    /// enabled action, and it must keep its promise.
    ///
    /// Args:
    ///     policy: What `ask(policy=True)` or `Strategy.policy` returns, or the path of a file that the command or a planner
    ///         has written.
    ///     target: The condition on states that a list of rules reaches; None for the goal of the planning problem.
    ///     preferences: The preferences that a policy with memory is about, or the path of their file.
    ///     strong: Each path of a list of rules must reach the target within a bound, too.
    ///     memory, timeout, progress: As in `explore`.
    ///
    /// Returns:
    ///     The report of `meliora verify --json`: `accepted`, and the `violation` of a policy that is refused.
    ///
    /// Raises:
    ///     InputError: The policy is invalid, or about another model.
    #[pyo3(signature = (policy, *, target=None, preferences=None, strong=false, memory=None, timeout=None, progress=None))]
    #[expect(clippy::too_many_arguments, reason = "they have names in Python")]
    fn verify_policy(
        &self,
        py: Python<'_>,
        policy: &Bound<'_, PyAny>,
        target: Option<String>,
        preferences: Option<&Bound<'_, PyAny>>,
        strong: bool,
        memory: Option<&Bound<'_, PyAny>>,
        timeout: Option<&Bound<'_, PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Py<PyAny>> {
        let call = Call::new(timeout, progress)?;
        self.with_policy(policy, (target, preferences, strong), None, (py, memory, &call))
    }

    /// Runs a policy from the initial states, as `meliora simulate --policy` does.
    ///
    /// Args:
    ///     policy, target, preferences: As in `verify_policy`.
    ///     runs: The number of runs.
    ///     steps: A run is given up after this number of steps.
    ///     seed: The same seed gives the same runs.
    ///     memory, timeout, progress: As in `explore`.
    ///
    /// Returns:
    ///     The report of `meliora simulate --policy --json`; its `runs` count those that kept the promise.
    ///
    /// Raises:
    ///     InputError: The policy is invalid, or about another model.
    #[pyo3(signature = (policy, *, target=None, preferences=None, runs=1000, steps=1000, seed=1, memory=None, timeout=None, progress=None))]
    #[expect(clippy::too_many_arguments, reason = "they have names in Python")]
    fn simulate_policy(
        &self,
        py: Python<'_>,
        policy: &Bound<'_, PyAny>,
        target: Option<String>,
        preferences: Option<&Bound<'_, PyAny>>,
        runs: i128,
        steps: i128,
        seed: i128,
        memory: Option<&Bound<'_, PyAny>>,
        timeout: Option<&Bound<'_, PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Py<PyAny>> {
        let call = Call::new(timeout, progress)?;
        let (runs, limit, seed) = (count("runs", runs)?, count("steps", steps)?, count("seed", seed)?);
        let runs = PolicyRuns { runs, limit, seed, ..PolicyRuns::default() };
        self.with_policy(policy, (target, preferences, false), Some(runs), (py, memory, &call))
    }

    /// Analyses the preferences with both engines and compares the results, as `meliora compare` does.
    ///
    /// Args:
    ///     preferences: A Preferences, or the path of a preference file.
    ///     membership: The maximum number of states for the comparison of each state in each region.
    ///     safety, max_level, scope, memory, order, timeout, progress: As in `check`.
    ///
    /// Returns:
    ///     The report of `meliora compare --json`, without times: `equal`, and the first `difference`.
    #[pyo3(signature = (preferences, *, membership=100_000, scope="reachable", safety="prefix", max_level=None, memory=None, order=None, timeout=None, progress=None))]
    #[expect(clippy::too_many_arguments, reason = "they have names in Python")]
    fn compare(
        &self,
        py: Python<'_>,
        preferences: &Bound<'_, PyAny>,
        membership: i128,
        scope: &str,
        safety: &str,
        max_level: Option<i128>,
        memory: Option<&Bound<'_, PyAny>>,
        order: Option<&Bound<'_, PyAny>>,
        timeout: Option<&Bound<'_, PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Py<PyAny>> {
        let (options, call) = (options::planning(safety, max_level)?, Call::new(timeout, progress)?);
        let source = self.preference_text(py, preferences)?;
        let (membership, inner) = (count("membership", membership)?, self.inner.clone());
        let header = self.header().with_preferences(&source.name, options.safety);
        let explored = ExploreOptions { scope, engine: "symbolic", memory, order };
        let work = move |work: &Kept<CompareReport>, settings: Settings| {
            compare(work, &inner.task(&source)?, options, &settings, (0.0, membership))
        };
        self.reported(CompareReport::new(header), explored, (py, "compare", &call), work)
    }
}

impl Model {
    /// Checks a policy, or runs it.
    fn with_policy(
        &self,
        policy: &Bound<'_, PyAny>,
        (target, preferences, is_strong): Aim<'_, '_>,
        runs: Option<PolicyRuns>,
        (py, memory, call): (Python<'_>, Option<&Bound<'_, PyAny>>, &Call),
    ) -> PyResult<Py<PyAny>> {
        let source = text(policy)?;
        let target = target.map(|text| SourceFile::new("target", text));
        let preferences = preferences.map(|given| self.preference_text(py, given)).transpose()?;
        let aim = PolicyAim { target, preferences, is_strong };
        let report = PolicyReport::of_file(self.header(), &source.name, runs.clone());
        let (inner, phase) = (self.inner.clone(), if runs.is_some() { "simulate" } else { "verify" });
        let work = move |work: &Kept<PolicyReport>, settings: Settings| {
            let given = GivenPolicy::read(work, &source, &aim, |_| Ok(inner), settings)?;
            match &runs {
                Some(runs) => given.run(work, runs),
                None => given.check(work),
            }
        };
        let explored = ExploreOptions { scope: "reachable", engine: "symbolic", memory, order: None };
        self.reported(report, explored, (py, phase, call), work)
    }

    /// Does work that fills a report, and returns the report as a dictionary.
    fn reported<R: Report + Clone + Send + Sync + 'static>(
        &self,
        report: R,
        explored: ExploreOptions<'_, '_>,
        (py, phase, call): (Python<'_>, &'static str, &Call),
        work: impl FnOnce(&Kept<R>, Settings) -> Result<(), Error> + Send + 'static,
    ) -> PyResult<Py<PyAny>> {
        let (settings, _, worker) = explored.settings()?;
        let kept = Arc::new(Kept::new(report, Arc::clone(&settings.sink)));
        let own = Arc::clone(&kept);
        let work = move || match work(&own, settings) {
            Err(Error::Limit(limit)) => Ok(Some(limit)),
            done => done.map(|()| None),
        };
        let limit = worker.phase(py, call, phase, work)?;
        let known = values::plain(py, to_string(&kept.known().0))?;
        let space = Space { worker, names: Arc::clone(&self.names) };
        limit.map_or(Ok(known.clone_ref(py)), |limit| Err(ended(py, &space, limit, ("report", known))))
    }

    fn preference_text(&self, py: Python<'_>, given: &Bound<'_, PyAny>) -> PyResult<Arc<SourceFile>> {
        Ok(Arc::clone(&preferences::given(py, given, self.inner.program())?.get().source))
    }

    fn header(&self) -> Header {
        Header::of_model(&self.inner.program().source.name)
    }
}

/// Returns the text of a policy: a file, or the value of its JSON.
fn text(policy: &Bound<'_, PyAny>) -> PyResult<Arc<SourceFile>> {
    let py = policy.py();
    if policy.is_instance_of::<PyDict>() || policy.is_instance_of::<PyList>() {
        let text: String = py.import("json")?.call_method1("dumps", (policy,))?.extract()?;
        return Ok(SourceFile::new("policy", text));
    }
    let path: PathBuf = policy.extract().map_err(|_| {
        usage(format!("a policy is the path of a file, a dictionary or a list, not {policy}"))
    })?;
    files::open(py, &path)
}
