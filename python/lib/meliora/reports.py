"""The types of the reports: dictionaries with the fields of `--json`, in which infinite numbers are floats.

A test of the Rust crate `meliora-report` writes this file from the types there.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict, List, Literal, TypedDict, Union

if TYPE_CHECKING:
    from typing_extensions import NotRequired

#: A number, or infinity.
Bound = float
#: An exact number as a decimal string.
Count = str
#: The number of improvements that can be made from a state.
Rank = Union[int, Literal["unbounded"]]
#: The value of each variable.
State = Dict[str, Union[int, bool, str]]


class Report(TypedDict):
    """The fields of most reports."""

    complete: NotRequired[bool]
    """`false`: the run hit a limit or was interrupted, and the object has the results so far; absent in
    complete reports."""
    memory: Memory
    """The memory used."""
    error: NotRequired[ErrorReport]
    """Why the run is not complete; absent in complete reports."""


class ModelReport(Report):
    """The fields of most reports about a model."""

    model: Model
    """The model."""
    scope: Literal["reachable", "all"]
    """The valuations that are states."""


class Bounds(TypedDict):
    """Bounds of a number."""

    lower: Bound
    """The lower bound."""
    upper: Bound
    """The upper bound, infinite if none is known."""
    exact: NotRequired[str]
    """The value as a fraction, such as `1/3`; absent if fractions were not asked for (`--exact`)."""


class Counts(TypedDict):
    """The sizes of a model."""

    states: Count
    """|S|, the number of states of the scope; with monitors, of pairs of a state of the model and states of
    the monitors."""
    model_states: NotRequired[Count]
    """The number of states of the model without monitors; absent if there are no monitors."""
    choices: Count
    """The number of pairs of a state and a choice enabled there."""
    transitions: Count
    """The number of triples (s, a, s')."""
    deadlocks: Count
    """The number of states without an enabled command."""
    initial: Count
    """The number of initial states."""
    unsafe: NotRequired[Count]
    """The number of states from which no strategy keeps the requirements; absent without requirements."""


class Memory(TypedDict):
    """The memory used."""

    peak_nodes: int
    """The largest number of diagram nodes at once; 0 without diagrams."""
    peak_rss_bytes: int
    """The largest resident set of the process, in bytes."""


class ModelVariables(TypedDict):
    """A variable of the model."""

    name: str
    """Its name."""
    type: Literal["int", "bool"]
    """Its type."""
    low: int
    """The smallest value; 0 for `bool`."""
    high: int
    """The largest value; 1 for `bool`."""
    bits: int
    """Number of bits of its encoding."""
    values: NotRequired[List[str]]
    """The names of its values from `low` on; absent without names."""


class Model(TypedDict):
    """The model of a report."""

    path: str
    """The file as the user named it."""
    type: Union[Literal["mdp", "dtmc", "smg"], None]
    """The sort of the model; `null` if unknown."""
    constants: Dict[str, Any]
    """The constants given by `--const`: integers, numbers, Booleans; an infinite value is a string."""
    exact_constants: NotRequired[Dict[str, str]]
    """The exact values of those that the numbers do not give, such as `1/3`; absent if there are none."""
    inexact: NotRequired[str]
    """The first place where a double counts for an exact value, as `FILE:LINE:COLUMN`; absent if all values
    are exact."""
    variables: List[ModelVariables]
    """The variables in the order of declaration, monitors last; empty if unknown."""


class CheckPlayers(TypedDict):
    """A player of a game."""

    name: str
    """Its name."""
    ours: bool
    """It is one of us."""
    states: Count
    """The number of states of the scope in which it chooses."""


class CheckObjectives(TypedDict):
    """The sizes of an objective's regions."""

    name: str
    """Its name."""
    target: Count
    """|F|, the number of states of the target; for an objective about whole paths, of states where it is
    secured. 0 deserves a warning."""
    observer: NotRequired[int]
    """The number of states of its monitor; absent without a monitor."""
    almost_sure: Count
    """|ASWin(F)|, the number of states from which some strategy achieves it with probability 1."""
    positive: Count
    """|PWin(F)|, the number of states from which some strategy achieves it with positive probability."""
    sure: Literal["all", "some", "none"]
    """The share of the initial states from which some strategy achieves it with probability 1; in a game,
    against every opponent."""
    possible: Literal["all", "some", "none"]
    """The share of the initial states from which some strategy achieves it with positive probability."""


class CheckClassesJointly(TypedDict):
    """Objectives that one strategy achieves together, almost surely."""

    objectives: List[str]
    """The outcomes, in the order of declaration."""
    states: Count
    """The number of states of the class from which a strategy achieves all of them almost surely."""


class CheckClasses(TypedDict):
    """The size of a class."""

    most_preferred: List[str]
    """MP of its states: the most preferred outcomes, in the order of declaration; empty for `nothing`."""
    states: Count
    """The number of states with this class."""
    jointly: NotRequired[List[CheckClassesJointly]]
    """The sets of at least two of these outcomes that one path can achieve, larger sets first; empty if no
    path can achieve two; absent if they were not computed (`--jointly`)."""
    jointly_limit: NotRequired[int]
    """The class has more outcomes than this, so `jointly` is not computed for it and its states; absent for
    other classes."""


class CheckImprovement(TypedDict):
    """The sizes of the improvement MDP; `null` with `--safety prefix`, or if unknown."""

    states: Count
    """|V| = 2 |S|: twice the states of the scope, without unsafe ones."""
    transitions: Count
    """The kept transitions over V: twice those of the model."""
    dropped: Count
    """The transitions that the requirements leave and the safety mode does not keep, counted once."""


class CheckSasi(TypedDict):
    """The levels of SASI; `null` if not begun."""

    levels: List[Count]
    """|W_1| > |W_2| > …, the number of states of level 1, 2, …, never 0; the last one repeats `unbounded`
    where that is not 0. Empty if no state can improve, and before level 1 is known: then `unbounded` is
    `null`."""
    unbounded: Union[Count, None]
    """The number of states of unbounded rank; `null` if unknown or cut by `--max-level`."""


class CheckSpi(TypedDict):
    """The levels of SPI; `null` if not begun."""

    levels: List[Count]
    """|W_1| > |W_2| > …, the number of states of level 1, 2, …, never 0; the last one repeats `unbounded`
    where that is not 0. Empty if no state can improve, and before level 1 is known: then `unbounded` is
    `null`."""
    unbounded: Union[Count, None]
    """The number of states of unbounded rank; `null` if unknown or cut by `--max-level`."""


class CheckInitialUnsafePath(TypedDict):
    """A state of a path to a violation."""

    state: State
    """The values of the state."""
    action: Union[str, None]
    """The action that leads on; `null` in the last state, which violates the requirement."""


class CheckInitialUnsafe(TypedDict):
    """The state is unsafe: no strategy keeps the requirements, and the other fields are empty or 0; absent
    for other states."""

    violated: str
    """The requirement that the path violates, as written."""
    path: List[CheckInitialUnsafePath]
    """A shortest path to the violation; from each of its states every action may lead to a violation. Empty
    if the state itself violates it."""


class CheckInitial(TypedDict):
    """The prospects of a state: its most preferred objectives and its plans."""

    state: State
    """The values of the state."""
    owner: NotRequired[str]
    """`opponent`: in this state of a game the opponent chooses, so no actions are listed; absent for other
    states."""
    unsafe: NotRequired[CheckInitialUnsafe]
    """The state is unsafe: no strategy keeps the requirements, and the other fields are empty or 0; absent
    for other states."""
    sure: Union[List[str], None]
    """The objectives that some strategy achieves from the state with probability 1, in the order of
    declaration; `null` if unknown."""
    possible: Union[List[str], None]
    """The objectives that some strategy achieves from the state with positive probability, in the order of
    declaration; those of `sure` are among them; `null` if unknown."""
    most_preferred: List[str]
    """The most preferred outcomes, in the order of declaration."""
    jointly: NotRequired[List[List[str]]]
    """The largest sets of these outcomes that one path can achieve; absent if they were not computed
    (`--jointly`), and if the class has a `jointly_limit`."""
    sasi_rank: Union[Rank, None]
    """The rank by SASI; `null` if unknown."""
    spi_rank: Union[Rank, None]
    """The rank by SPI; `null` if unknown."""
    sasi_actions: Union[List[str], None]
    """The actions of the permissive SASI strategy; empty at rank 0, and where the opponent of a game chooses;
    `null` if unknown."""
    spi_actions: Union[List[str], None]
    """The actions of the permissive SPI strategy; empty at rank 0, and where the opponent of a game chooses;
    `null` if unknown."""
    sasi_gains: NotRequired[List[List[str]]]
    """The objectives that each improvement of the progress SASI strategy gains, of none that is sure in this
    state; absent at rank 0, and if the model has more than 4,096 states."""
    spi_gains: NotRequired[List[List[str]]]
    """The objectives that each improvement of the progress SPI strategy may gain (for an unbounded rank: the
    first one); absent as before."""


class CheckTime(TypedDict):
    """Seconds by phase; a phase that did not end is `null`."""

    parse: Union[float, None]
    """Reading model and preferences; `null` if not finished."""
    build: Union[float, None]
    """Encoding the model and finding the states; `null` if not finished."""
    outcomes: Union[float, None]
    """Winning regions of the objectives; `null` if not finished."""
    improvement: Union[float, None]
    """Classes and improvement MDP; `null` if not finished."""
    sasi: Union[float, None]
    """Levels of SASI; `null` if not finished."""
    spi: Union[float, None]
    """Levels of SPI; `null` if not finished."""
    total: float
    """Seconds of the whole run."""


class CheckReport(ModelReport):
    """A report, in the order of the JSON fields."""

    schema: Literal["meliora.check/1"]
    """The kind and version of the object."""
    engine: NotRequired[Literal["symbolic", "explicit"]]
    """The engine; absent until it is taken."""
    engine_reason: NotRequired[str]
    """Why `--engine auto` has taken this engine; absent with another `--engine`."""
    safety: Literal["action", "transition", "prefix"]
    """The safety mode."""
    empty: Union[Literal["bottom", "gain", "incomparable"], None]
    """The value of nothing: the `empty` statement of the preferences; `null` until they are read."""
    history: NotRequired[str]
    """`play`: objectives are about whole paths; absent with `history = state`."""
    players: NotRequired[List[CheckPlayers]]
    """The players of a game; absent for other models, and if unknown."""
    counts: Union[Counts, None]
    """The sizes of the model; `null` if unknown."""
    objectives: List[CheckObjectives]
    """The objectives in the order of declaration, as far as decided."""
    classes: Union[List[CheckClasses], None]
    """The classes that some state has; `null` if unknown."""
    improvement: Union[CheckImprovement, None]
    """The sizes of the improvement MDP; `null` with `--safety prefix`, or if unknown."""
    sasi: Union[CheckSasi, None]
    """The levels of SASI; `null` if not begun."""
    spi: Union[CheckSpi, None]
    """The levels of SPI; `null` if not begun."""
    initial: List[CheckInitial]
    """The first initial states, at most 16; empty if unknown."""
    time: CheckTime
    """Seconds by phase; a phase that did not end is `null`."""


class CompareEnginesTime(TypedDict):
    """Seconds by phase, as in `check`."""

    parse: Union[float, None]
    """Reading model and preferences; `null` if not finished."""
    build: Union[float, None]
    """Encoding the model and finding the states; `null` if not finished."""
    outcomes: Union[float, None]
    """Winning regions of the objectives; `null` if not finished."""
    improvement: Union[float, None]
    """Classes and improvement MDP; `null` if not finished."""
    sasi: Union[float, None]
    """Levels of SASI; `null` if not finished."""
    spi: Union[float, None]
    """Levels of SPI; `null` if not finished."""
    total: float
    """Seconds of the whole run."""


class CompareEngines(TypedDict):
    """Times and memory of one engine."""

    engine: Literal["symbolic", "explicit"]
    """Its name."""
    time: CompareEnginesTime
    """Seconds by phase, as in `check`."""
    peak_nodes: int
    """The largest number of diagram nodes at once; 0 for `explicit`."""
    table_bytes: int
    """The bytes of its own tables."""


class ComparePrefer(TypedDict):
    """The engine to prefer for this input; `null` if unknown."""

    engine: Literal["symbolic", "explicit"]
    """Its name."""
    reason: str
    """The reason."""


class CompareTime(TypedDict):
    """Seconds by phase; a phase that did not end is `null`."""

    total: float
    """Seconds of the whole run."""


class CompareReport(ModelReport):
    """A report, in the order of the JSON fields."""

    schema: Literal["meliora.compare/1"]
    """The kind and version of the object."""
    safety: Literal["action", "transition", "prefix"]
    """The safety mode."""
    empty: Union[Literal["bottom", "gain", "incomparable"], None]
    """The value of nothing: the `empty` statement of the preferences; `null` until they are read."""
    counts: Union[Counts, None]
    """The sizes of the model; `null` if unknown."""
    equal: Union[bool, None]
    """Both engines give the same results; `null` if unknown."""
    difference: Union[str, None]
    """The first difference; `null` without a difference."""
    compared: int
    """The number of compared values in the reports of `check`."""
    strategies: Union[int, None]
    """The number of states at which the strategies of all kinds were compared: kept, permitted and progress
    actions, reasons and successors; `null` if unknown."""
    membership: Union[Count, None]
    """The number of states that were looked up in every region of both engines; `null` if there are more than
    `--membership`, or if unknown."""
    engines: List[CompareEngines]
    """Time and memory by engine."""
    prefer: Union[ComparePrefer, None]
    """The engine to prefer for this input; `null` if unknown."""
    time: CompareTime
    """Seconds by phase; a phase that did not end is `null`."""


class ErrorReport(TypedDict):
    """An error in JSON."""

    schema: Literal["meliora.error/1"]
    """The kind and version of the object."""
    kind: Literal["input", "resource", "usage", "internal"]
    """The sort of error: in the model, the preferences or a file; a limit or an interruption; in the command
    line; in this program."""
    message: str
    """The problem."""
    file: Union[str, None]
    """The file, or the option, that is wrong; `null` if none."""
    line: Union[int, None]
    """The line, from 1; `null` if the problem has no place."""
    column: Union[int, None]
    """The column in characters, from 1; `null` as `line`."""


class ExportLabels(TypedDict):
    """A label of states."""

    name: str
    """Its name in the files."""
    states: Count
    """The number of states with the label."""


class ExportRegions(TypedDict):
    """A region in a dump."""

    name: str
    """Its name."""
    kind: Literal["states", "choices"]
    """The sort of its members."""
    count: Count
    """The number of members."""
    nodes: int
    """The number of inner nodes."""


class ExportValues(TypedDict):
    """The bounds of `--values`; absent without `--values`."""

    rows: int
    """The number of rows of `values.csv`, or of states in an archive."""
    levels: int
    """The greatest number of improvements."""
    reward: str
    """The reward structure that is the cost of a step, or `steps`."""
    widest: Union[float, None]
    """The greatest width of a bound, absolute for probabilities, relative above 1 for costs; `null` if it is
    infinite."""
    narrow: bool
    """True if no bound is wider than `--precision`."""


class ExportReport(ModelReport):
    """A report, in the order of the JSON fields."""

    schema: Literal["meliora.export/1"]
    """The kind and version of the object."""
    safety: Literal["action", "transition", "prefix"]
    """The safety mode."""
    directory: str
    """The directory as given by `--out`."""
    strategy: NotRequired[Union[str, None]]
    """The strategy whose induced model is written, such as `sasi:progress`; absent in a dump, `null` without
    `--kind`."""
    files: NotRequired[List[str]]
    """The names of the files in the directory; absent in a dump."""
    states: NotRequired[Union[Count, None]]
    """The number of states written; absent in a dump, `null` if not written."""
    choices: NotRequired[Union[Count, None]]
    """The number of their choices; as `states`."""
    transitions: NotRequired[Union[Count, None]]
    """The number of their transitions; as `states`."""
    labels: NotRequired[List[ExportLabels]]
    """The labels of states; absent in a dump."""
    regions: NotRequired[List[ExportRegions]]
    """The regions of the dump, in the order of the roots; empty if not written."""
    nodes: NotRequired[Union[int, None]]
    """The number of nodes of `regions.dddmp`; `null` if not written."""
    certificate_nodes: NotRequired[Union[int, None]]
    """The number of nodes of `certificate.dddmp`; `null` if not written."""
    uncertified: NotRequired[List[str]]
    """The regions that the certificate does not prove, because a limit ended a part of it; none without a
    certificate."""
    values: NotRequired[ExportValues]
    """The bounds of `--values`; absent without `--values`."""
    time: CompareTime
    """Seconds by phase; a phase that did not end is `null`."""


class InfoNodes(TypedDict):
    """The sizes of diagrams; `null` for the explicit engine, or if unknown."""

    transition: int
    """The nodes of all transition relations together."""
    reachable: int
    """The nodes of the set of states."""


class InfoRewards(TypedDict):
    """A reward structure."""

    name: Union[str, None]
    """Its name; `null` without a name."""
    states: int
    """The number of items that states earn."""
    choices: int
    """The number of items that choices earn, by their action or by a command."""
    error: NotRequired[str]
    """The reason why it cannot be used; absent if it can."""


class InfoTime(TypedDict):
    """Seconds by phase; a phase that did not end is `null`."""

    parse: Union[float, None]
    """Reading the model; `null` if not finished."""
    build: Union[float, None]
    """Encoding the model and finding the states; `null` if not finished."""
    count: Union[float, None]
    """Counting; `null` if not finished."""
    total: float
    """Seconds of the whole run."""


class InfoReport(ModelReport):
    """A report, in the order of the JSON fields."""

    schema: Literal["meliora.info/1"]
    """The kind and version of the object."""
    engine: Literal["symbolic", "explicit"]
    """The engine; absent until it is taken."""
    engine_reason: NotRequired[str]
    """Why `--engine auto` has taken this engine; absent with another `--engine`."""
    counts: Union[Counts, None]
    """The sizes of the model; `null` if unknown."""
    order: Union[List[str], None]
    """The variables of the diagrams from the root down: `x.2` is bit 2 of `x`, a Boolean has its name; `null`
    for the explicit engine, or if unknown."""
    nodes: Union[InfoNodes, None]
    """The sizes of diagrams; `null` for the explicit engine, or if unknown."""
    order_reason: NotRequired[str]
    """The reason for the order; absent if it was not computed from the model."""
    rewards: List[InfoRewards]
    """The reward structures; empty if unknown."""
    players: NotRequired[List[CheckPlayers]]
    """The players of a game; absent for other models, and if unknown."""
    time: InfoTime
    """Seconds by phase; a phase that did not end is `null`."""


class PolicyViolation(TypedDict):
    """The first fault; `null` if there is none, or if it is unknown."""

    condition: str
    """The condition."""
    state: Union[State, None]
    """A state for which it fails; `null` if the condition is not about a state."""


class PolicyPromiseStarts(TypedDict):
    """The promise of a policy from a state on."""

    state: State
    """The state."""
    most_preferred: List[str]
    """Its most preferred objectives."""
    improvements: Rank
    """The number of improvements."""
    pursues: List[str]
    """The objectives that it pursues from the start on."""


class PolicyPromise(TypedDict):
    """The promise of a policy with memory; absent for other policies, and before it is read."""

    kind: str
    """Its aim: `sasi`, `spi`, `plan` or `achieve`."""
    safety: str
    """The comparison of steps: `prefix` or `action`."""
    objectives: List[str]
    """The objectives that it achieves, or that a plan pursues where they are most preferred."""
    nodes: int
    """The number of nodes."""
    committed: int
    """The number of nodes in which a plan has committed to an objective, and may give up others."""
    listed: Union[Count, None]
    """The number of states of the model that the check listed; `null` if it did not end, and with `simulate`."""
    start_count: int
    """The number of starts."""
    starts: List[PolicyPromiseStarts]
    """The starts, 16 at most."""


class PolicyStrategiesObjectives(TypedDict):
    """The value of an objective under a strategy."""

    objective: str
    """The text of the objective."""
    claimed: float
    """The value that the file claims."""
    value: NotRequired[Bounds]
    """Bounds of the value of the strategy; absent with `simulate`."""


class PolicyStrategies(TypedDict):
    """The values of a strategy of a property `multi(…)`."""

    share: Union[float, None]
    """The probability with which it is drawn; `null` for a point of a front."""
    nodes: int
    """The number of states that it visits, with its memory."""
    objectives: List[PolicyStrategiesObjectives]
    """The values of the objectives."""


class PolicyRunsObjectives(TypedDict):
    """The values of an objective in the runs of strategies of which one is drawn at the start."""

    objective: str
    """The text of the objective."""
    claimed: float
    """The mean of the values that the strategies claim."""
    measured: Union[float, None]
    """The mean over the runs; `null` if a reward was given up before it ended, or is infinite."""
    interval: Union[List[float], None]
    """The bounds that contain the true mean with a probability of 0.99; `null` if unknown."""
    open: int
    """The runs that were given up before the objective was decided."""


class PolicyRunsDone(TypedDict):
    """The results of the runs of a policy with memory; absent for other policies."""

    mean_improvements: float
    """The mean number of improvements of a run."""
    weakened: int
    """The runs in which a step weakened its reference."""


class PolicyRunsFirst(TypedDict):
    """A step of a run."""

    state: State
    """The state before it."""
    action: str
    """The action."""


class PolicyRuns(TypedDict):
    """The runs of `simulate`; absent with `verify`."""

    runs: int
    """Their number."""
    limit: int
    """The number of steps after which a run is given up."""
    seed: int
    """The seed of the random numbers."""
    reached: int
    """The runs that reached the goal; of a property `multi(…)`, those that decided all objectives; of a
    policy with memory, those that did all that it promises at their start."""
    given_up: int
    """The runs that were given up after `limit` steps."""
    mean_steps: Union[float, None]
    """The mean number of steps of the runs that reached the goal; `null` if none did."""
    most_steps: Union[int, None]
    """The largest number of these steps; `null` if no run reached the goal."""
    objectives: NotRequired[List[PolicyRunsObjectives]]
    """The objectives of a property `multi(…)`; absent for other policies."""
    done: NotRequired[PolicyRunsDone]
    """The results of the runs of a policy with memory; absent for other policies."""
    first: List[PolicyRunsFirst]
    """The steps of the first run; none of a property `multi(…)`."""
    last: Union[State, None]
    """The state in which the first run ends."""


class PolicyTime(TypedDict):
    """Seconds by phase; a phase that did not end is `null`."""

    parse: Union[float, None]
    """Reading the model and the policy; `null` if not finished."""
    answer: Union[float, None]
    """Checking or running the policy; `null` if not finished."""
    total: float
    """Seconds of the whole run."""


class PolicyReport(Report):
    """A report, in the order of the JSON fields."""

    schema: Literal["meliora.policy/1"]
    """The kind and version of the object."""
    model: Model
    """The model."""
    policy: str
    """The file of the policy."""
    accepted: NotRequired[Union[bool, None]]
    """`verify`: the policy reaches the goal surely from all initial states, with `--strong` within a bound,
    or the strategies of a property `multi(…)` have their values; `null` if unknown, absent with `simulate`."""
    states: Union[Count, None]
    """The number of states outside the goal that the policy visits; `null` if unknown, or if it is refused."""
    goal_states: Union[Count, None]
    """The number of states of the goal in which it ends; as `states`."""
    longest: Union[Count, None]
    """The number of steps of the longest path; `null` if no bound exists, or as `states`."""
    violation: Union[PolicyViolation, None]
    """The first fault; `null` if there is none, or if it is unknown."""
    promise: NotRequired[PolicyPromise]
    """The promise of a policy with memory; absent for other policies, and before it is read."""
    strategies: NotRequired[List[PolicyStrategies]]
    """The strategies of a property `multi(…)`, with their values; absent for other policies."""
    runs: NotRequired[PolicyRuns]
    """The runs of `simulate`; absent with `verify`."""
    time: PolicyTime
    """Seconds by phase; a phase that did not end is `null`."""


class QueryContains(TypedDict):
    """A state with the answer whether it is in the selection."""

    state: State
    """The values of the state."""
    contained: bool
    """The state is a member."""
    choices: NotRequired[List[str]]
    """The actions of its choices in the region; absent for a region of states, and for a state that is not a
    member."""


class QueryStates(TypedDict):
    """A state of the selection."""

    state: State
    """The values of the state."""
    choices: NotRequired[List[str]]
    """The actions of its choices in the region; absent for a region of states."""


class QueryReport(Report):
    """A report, in the order of the JSON fields."""

    schema: Literal["meliora.query/1"]
    """The kind and version of the object."""
    directory: str
    """The directory of the dump."""
    region: str
    """The region expression."""
    where: NotRequired[str]
    """The condition of `--where`; absent without it."""
    kind: Union[Literal["states", "choices"], None]
    """The members of the region: `states` or `choices`; `null` if unknown."""
    count: Union[Count, None]
    """The number of members; `null` with `--contains` or `--list`, unless `--count` is given too."""
    contains: NotRequired[List[QueryContains]]
    """The answers to `--contains`; absent without it."""
    states: NotRequired[List[QueryStates]]
    """The states of `--list`; absent without it."""
    time: CompareTime
    """Seconds by phase; a phase that did not end is `null`."""


class ReachUnsafe(TypedDict):
    """An initial state from which no strategy keeps `--require`: no property holds, and no quantity has a
    value; absent without such a state."""

    violated: str
    """The requirement that the path violates, as written."""
    path: List[CheckInitialUnsafePath]
    """A shortest path to the violation; from each of its states every action may lead to a violation. Empty
    if the state itself violates it."""


class ReachInitial(TypedDict):
    """The share of the initial states in each region; absent with several properties."""

    pmax_one: Union[Literal["all", "some", "none"], None]
    """Some strategy reaches T with probability one."""
    pmax_positive: Union[Literal["all", "some", "none"], None]
    """Some strategy reaches T with positive probability."""
    pmin_one: Union[Literal["all", "some", "none"], None]
    """Every strategy reaches T with probability one."""
    pmin_positive: Union[Literal["all", "some", "none"], None]
    """Every strategy reaches T with positive probability."""


class ReachPlan(TypedDict):
    """The plans for the target; absent without `--strong` and `--policy`, if the question is not the goal of
    a planning problem."""

    strong_cyclic: Union[bool, None]
    """A strong cyclic plan exists from all initial states: it reaches the target almost surely if every
    outcome of an action has a positive probability; `null` if unknown."""
    strong: Union[bool, None]
    """A strong plan exists from all initial states: every path reaches the target within a bound; `null`
    without `--strong`, or if unknown."""
    strong_states: Union[Count, None]
    """The number of states with a strong plan; `null` without `--strong`, or if unknown."""
    policy_states: Union[Count, None]
    """The number of states outside the target that the policy of `--policy` visits; `null` without it, and if
    no plan exists."""


class ReachPropertiesValues(TypedDict):
    """The value of a property in a state."""

    state: State
    """The values of its variables."""
    holds: NotRequired[bool]
    """True if the condition holds there; absent for a number."""
    value: NotRequired[Bounds]
    """The number; absent for a condition."""


class ReachProperties(TypedDict):
    """A property with its answer, or the reason for no answer."""

    name: Union[str, None]
    """Its name in the file; `null` without a name."""
    property: str
    """Its text."""
    holds: Union[bool, None]
    """It holds in all initial states; `null` if not answered."""
    value: NotRequired[Union[Bounds, None]]
    """The probability or the expected reward over the initial states: in each of them, the value lies between
    these bounds; for the filter `min` or `max` of a JANI model, bounds of the least or the greatest of them;
    `null` if an initial state is unsafe, absent if not asked for, or unknown."""
    values: NotRequired[List[ReachPropertiesValues]]
    """The values of the states that the filter of the property lists; absent without such a filter."""
    front: NotRequired[List[List[float]]]
    """Points of the Pareto front of several objectives, each with their values: one strategy attains them,
    and no strategy attains values that are better than the means of points by more than the precision; absent
    for other properties."""
    strong_cyclic: NotRequired[bool]
    """A strong cyclic plan exists for the goal of the planning problem, about which the property asks; absent
    if it is about something else, and with one question, which has `plan`."""
    pmax_one: Union[Count, None]
    """Some strategy reaches T with probability one."""
    pmax_positive: Union[Count, None]
    """Some strategy reaches T with positive probability."""
    pmin_one: Union[Count, None]
    """Every strategy reaches T with probability one."""
    pmin_positive: Union[Count, None]
    """Every strategy reaches T with positive probability."""
    reason: NotRequired[str]
    """The reason for no answer, or for no value; absent if there are both."""
    line: NotRequired[int]
    """The line of the file of properties, or of the JANI model, that the reason is about, from 1; absent if
    it is about no place."""
    column: NotRequired[int]
    """The column, from 1; absent if `line` is."""


class ReachWritten(TypedDict):
    """The dump of `--out`; absent without `--out`, and if it was not written."""

    directory: str
    """The directory as given by `--out`."""
    regions: List[ExportRegions]
    """The regions of the dump, in the order of the roots."""
    nodes: int
    """The number of nodes of `regions.dddmp`."""


class ReachTime(TypedDict):
    """Seconds by phase; a phase that did not end is `null`."""

    parse: Union[float, None]
    """Reading model and target; `null` if not finished."""
    build: Union[float, None]
    """Encoding the model and finding the states; `null` if not finished."""
    pmax_positive: Union[float, None]
    """The region of this name; `null` if not finished."""
    pmax_one: Union[float, None]
    """The region of this name; `null` if not finished."""
    pmin_positive: Union[float, None]
    """The region of this name; `null` if not finished."""
    pmin_one: Union[float, None]
    """The region of this name; `null` if not finished."""
    value: Union[float, None]
    """The probability or the reward; `null` if not finished."""
    strong: Union[float, None]
    """The region of `--strong`; `null` if not finished."""
    policy: Union[float, None]
    """Finding and checking the policy of `--policy`; `null` if not finished."""
    total: float
    """Seconds of the whole run."""


class ReachReport(ModelReport):
    """A report, in the order of the JSON fields."""

    schema: Literal["meliora.reach/1"]
    """The kind and version of the object."""
    file: NotRequired[str]
    """The property file as the user named it; absent without one."""
    engine: NotRequired[Literal["symbolic", "explicit"]]
    """The engine; absent until it is taken."""
    engine_reason: NotRequired[str]
    """Why `--engine auto` has taken this engine; absent with another `--engine`."""
    counts: Union[Counts, None]
    """The sizes of the model; `null` if unknown."""
    stops_at_target: NotRequired[bool]
    """The states that decide the question are not left (`--stop-at-target`): all counts are those of the part
    explored; absent otherwise."""
    over_all_valuations: NotRequired[bool]
    """A property, or an operator of one, was decided over all combinations of values, before the reachable
    states were known: the sizes of its regions are `null`, and so is `counts` unless another one needs all
    states; absent otherwise."""
    by_guided_search: NotRequired[bool]
    """A property, or an operator of one, was decided by a guided search, before the reachable states were
    known: the sizes of its regions are `null`, and so is `counts` unless another one needs all states; absent
    otherwise."""
    unsafe: NotRequired[ReachUnsafe]
    """An initial state from which no strategy keeps `--require`: no property holds, and no quantity has a
    value; absent without such a state."""
    target: NotRequired[Union[Count, None]]
    """The number of target states; absent with several properties, `null` if unknown or not a reachability
    question."""
    pmax_one: NotRequired[Union[Count, None]]
    """Some strategy reaches T with probability one."""
    pmax_positive: NotRequired[Union[Count, None]]
    """Some strategy reaches T with positive probability."""
    pmin_one: NotRequired[Union[Count, None]]
    """Every strategy reaches T with probability one."""
    pmin_positive: NotRequired[Union[Count, None]]
    """Every strategy reaches T with positive probability."""
    initial: NotRequired[ReachInitial]
    """The share of the initial states in each region; absent with several properties."""
    holds: NotRequired[bool]
    """The property holds in all initial states; absent with `--target`, with several properties, or if
    unknown."""
    plan: NotRequired[ReachPlan]
    """The plans for the target; absent without `--strong` and `--policy`, if the question is not the goal of
    a planning problem."""
    properties: List[ReachProperties]
    """The questions in their order: the properties, or the target."""
    written: NotRequired[ReachWritten]
    """The dump of `--out`; absent without `--out`, and if it was not written."""
    time: ReachTime
    """Seconds by phase; a phase that did not end is `null`."""


class Written(TypedDict):
    """The file; `null` if not written."""

    path: str
    """The path."""
    format: Literal["html", "svg", "dot"]
    """Its format."""
    bytes: int
    """The size in bytes."""
    grid: List[str]
    """The variables of the maps, rows first; empty without maps."""
    nodes: int
    """The number of nodes of the regions in the page."""
    projected: bool
    """The maps had to be projected, so there are no sliders."""


class ReportReport(Report):
    """The results of `report`."""

    schema: Literal["meliora.report/1"]
    """The kind and version of the object."""
    written: Union[Written, None]
    """The file; `null` if not written."""
    check: CheckReport
    """The object of `check`."""


class ShieldSizes(TypedDict):
    """The sizes of the shield; `null` until it is computed."""

    states: int
    """Number of states."""
    actions: int
    """Number of actions of all states."""
    permitted: int
    """Number of actions that are permitted."""
    below: int
    """Number of states in which no action reaches the threshold, so that those with the best safety are
    permitted."""


class ShieldStatesActions(TypedDict):
    """An action with its value."""

    action: str
    """Its name."""
    value: Bounds
    """The best probability of the formula after it."""
    permitted: bool
    """True if it is permitted."""
    instead: NotRequired[str]
    """The action that is taken instead, if this one is not permitted; absent for others."""


class ShieldStates(TypedDict):
    """A state with its actions."""

    state: State
    """The values of its variables."""
    theirs: NotRequired[bool]
    """`true`: the opponent chooses here, and may do so freely; absent for other states."""
    decided: NotRequired[bool]
    """`true`: the formula is true or false here, whatever follows; absent for other states."""
    secure: bool
    """`true` if the permitted actions reach the threshold."""
    actions: List[ShieldStatesActions]
    """The actions, in the order of the program."""


class ShieldTime(TypedDict):
    """Seconds by phase; a phase that did not end is `null`."""

    parse: Union[float, None]
    """Reading model and property; `null` if not finished."""
    build: Union[float, None]
    """Encoding the model and finding the states; `null` if not finished."""
    values: Union[float, None]
    """Computing the values of all actions; `null` if not finished."""
    write: Union[float, None]
    """Writing the shield; `null` if not finished."""
    total: float
    """Seconds of the whole run."""


class ShieldReport(ModelReport):
    """A report, in the order of the JSON fields."""

    schema: Literal["meliora.shield/1"]
    """The kind and version of the object."""
    engine: NotRequired[Literal["symbolic", "explicit"]]
    """The engine; absent until it is taken."""
    engine_reason: NotRequired[str]
    """Why `--engine auto` has taken this engine; absent with another `--engine`."""
    property: Union[str, None]
    """The property whose values are listed; `null` until it is read."""
    name: NotRequired[str]
    """The name of a shield expression; absent without one."""
    threshold: Union[float, None]
    """The least safety of a permitted action; for `Pmin`, the safety is 1 minus the value."""
    relative: Union[bool, None]
    """True if the threshold is a factor of the best safety of the state."""
    horizon: NotRequired[int]
    """Number of steps that a bounded property looks ahead; absent if it is not bounded."""
    sizes: Union[ShieldSizes, None]
    """The sizes of the shield; `null` until it is computed."""
    states: List[ShieldStates]
    """The first states, with monitors if the property needs some."""
    more: int
    """Number of states that are not listed here."""
    written: NotRequired[str]
    """The directory of the shield (`--out`); absent if none is written."""
    time: ShieldTime
    """Seconds by phase; a phase that did not end is `null`."""


class SimulatePlaysImprovements(TypedDict):
    """A number of improvements."""

    times: int
    """The number."""
    plays: int
    """The paths with this number."""


class SimulatePlaysStepsTo(TypedDict):
    """The number of steps until an event of a run."""

    plays: int
    """The number of paths with this event."""
    least: int
    """The fewest steps."""
    mean: float
    """The mean number of steps over these paths."""
    most: int
    """The most steps."""


class SimulatePlaysAchieved(TypedDict):
    """An objective that runs achieved."""

    objective: str
    """Its name."""
    plays: int
    """The number of paths with this event."""
    least: int
    """The fewest steps."""
    mean: float
    """The mean number of steps over these paths."""
    most: int
    """The most steps."""


class SimulatePlaysPlayers(TypedDict):
    """A player of a game, with the steps that it chose."""

    name: str
    """Its name."""
    ours: bool
    """It is one of us."""
    steps: int
    """The number of steps of all paths that it chose."""


class SimulatePlaysCommits(TypedDict):
    """A commitment of runs."""

    objective: str
    """The objective that the paths then pursued."""
    gives_up: List[str]
    """The other most preferred outcomes that they lost afterwards; empty if they lost none."""
    runs: int
    """The number of paths with this commitment."""


class SimulatePlaysGained(TypedDict):
    """An objective that runs gained over the starting state."""

    objective: str
    """Its name."""
    runs: int
    """The number of paths that gained it."""


class SimulatePlaysValue(TypedDict):
    """The value that the strategy attains, computed and measured; `null` with `first`."""

    objective: NotRequired[str]
    """The objective that it achieves with this probability; absent unless it does nothing else."""
    improvements: int
    """The number of improvements that it aims at."""
    probability: Bounds
    """The probability of these improvements, or of the objective."""
    cost: Union[Bounds, None]
    """The expected cost until the last of them; `null` where the probability is below 1."""
    confidence: float
    """The confidence of the intervals."""
    measured_probability: float
    """The share of the paths with these improvements."""
    probability_interval: Bounds
    """The confidence interval (Wilson); open paths count as failures in `lower`, as successes in `upper`."""
    measured_cost: Union[float, None]
    """The mean cost until the last of these improvements; `null` without `cost`, for fewer than 10 paths, or
    if a path did not make them."""
    cost_interval: Union[Bounds, None]
    """The confidence interval (Student); `null` as `measured_cost`."""
    open: int
    """The paths that were given up, and could still have made these improvements."""
    agrees: bool
    """The computed bounds and the intervals overlap."""


class SimulatePlaysTraceTurns(TypedDict):
    """A step of a run."""

    owner: NotRequired[str]
    """`opponent`: the opponent chose the action; absent otherwise."""
    player: NotRequired[str]
    """The player who chose it; absent if the model is not a game, and in deadlocks."""
    action: str
    """The action taken."""
    state: State
    """The state entered."""
    probability: float
    """The probability of the successor under the action."""
    most_preferred: List[str]
    """The most preferred outcomes of the state entered."""
    rank: Rank
    """Its rank."""
    change: Literal["improving", "weakening", "lateral"]
    """The effect of the step, compared with the reference."""
    improves: bool
    """The step counts as an improvement of the path."""
    gained: List[str]
    """The outcomes that are preferred to one of the reference."""
    lost: List[str]
    """The outcomes of the state before that are preferred to one of the state entered."""
    weakens_step: bool
    """The step weakens the state before, and the path has not committed."""
    weakens_start: bool
    """The step weakens the starting state, and the path has not committed."""
    commits: NotRequired[str]
    """The objective to which the path commits before this step; absent without a new commitment."""
    gives_up: NotRequired[List[str]]
    """The objectives that the step gives up, for the first time since the commitment; absent if there are
    none."""
    achieved: NotRequired[List[str]]
    """The objectives that are achieved for the first time in the state entered; absent if there are none."""


class SimulatePlaysTrace(TypedDict):
    """One path in full: the first that weakened, otherwise the first."""

    play: int
    """Its number, from 1."""
    achieved: NotRequired[List[str]]
    """The objectives that are achieved in the starting state; absent if there are none."""
    turns: List[SimulatePlaysTraceTurns]
    """Its steps; empty if the path ends where it starts."""


class SimulatePlays(TypedDict):
    """The runs from one state."""

    state: State
    """The starting state."""
    unsafe: NotRequired[bool]
    """`true`: no strategy keeps the requirements from it, and its paths have no step; absent for other
    states."""
    rank: Rank
    """Its rank."""
    improvements: List[SimulatePlaysImprovements]
    """The distribution of the number of improvements."""
    steps_to: List[SimulatePlaysStepsTo]
    """The steps from the start to the first, second, … improvement; empty if no path improved."""
    achieved: NotRequired[List[SimulatePlaysAchieved]]
    """The objectives that paths achieved, in the order of declaration; absent for `sasi` and `spi`."""
    achieved_runs: NotRequired[int]
    """The paths that ended because they had achieved the objective that they pursued; absent for `sasi` and
    `spi`."""
    kept_runs: NotRequired[int]
    """The other paths that kept the objective that they pursued: no step achieves it, and the path can go on
    to satisfy it; absent for `sasi` and `spi`."""
    players: NotRequired[List[SimulatePlaysPlayers]]
    """The players, with the steps that they chose; absent if the model is not a game."""
    commits: NotRequired[List[SimulatePlaysCommits]]
    """The commitments of paths: kept actions alone achieved no most preferred outcome; empty if no path
    commits; absent except for `plan`."""
    settled: int
    """The paths that ended where the strategy has nothing left to improve or to achieve, or stays forever."""
    given_up: int
    """The paths that were given up after `steps` steps."""
    undecided: int
    """The paths among them with fewer improvements than the rank."""
    fewer_than_rank: Union[int, None]
    """The paths with fewer improvements than the rank; `null` if the rank is unbounded."""
    weakened_step: int
    """The paths with a step that weakens the state before it; steps after a commitment are not counted, here
    and below."""
    weakened_reference: int
    """The paths that weaken the reference: under `prefix` the start or the last improvement, otherwise the
    state before."""
    weakened_start: int
    """The paths that weaken the starting state."""
    better_than_start: int
    """The paths with a state that improves on the starting state."""
    gained: List[SimulatePlaysGained]
    """The objectives that paths gained over the starting state, in the order of declaration."""
    entered_unsafe: int
    """The paths that entered a state where no strategy keeps the requirements; always 0."""
    value: Union[SimulatePlaysValue, None]
    """The value that the strategy attains, computed and measured; `null` with `first`."""
    trace: SimulatePlaysTrace
    """One path in full: the first that weakened, otherwise the first."""


class SimulateTime(TypedDict):
    """Seconds by phase; a phase that did not end is `null`."""

    parse: Union[float, None]
    """Reading model, preferences and states; `null` if not finished."""
    build: Union[float, None]
    """Encoding the model and finding the states; `null` if not finished."""
    levels: Union[float, None]
    """Winning regions, improvement MDP and levels; `null` if not finished."""
    values: Union[float, None]
    """Computing the values for `choose`; `null` if not finished."""
    answer: Union[float, None]
    """Simulating; `null` if not finished."""
    total: float
    """Seconds of the whole run."""


class SimulateReport(ModelReport):
    """A report, in the order of the JSON fields."""

    schema: Literal["meliora.simulate/1"]
    """The kind and version of the object."""
    engine: NotRequired[Literal["symbolic", "explicit"]]
    """The engine; absent until it is taken."""
    engine_reason: NotRequired[str]
    """Why `--engine auto` has taken this engine; absent with another `--engine`."""
    safety: Literal["action", "transition", "prefix"]
    """The safety mode."""
    empty: Union[Literal["bottom", "gain", "incomparable"], None]
    """The value of nothing: the `empty` statement of the preferences; `null` until they are read."""
    kind: Literal["sasi", "spi", "plan", "achieve"]
    """The kind of the strategy."""
    choose: Literal["first", "likely", "cheap"]
    """The choice among permitted actions."""
    reward: Union[str, None]
    """The cost of a step: `steps`, or the name of a reward structure; `null` with `first`."""
    strategy: Literal["progress", "permissive"]
    """The actions that the paths take."""
    runs: int
    """The number of paths per starting state."""
    steps: int
    """The number of steps after which a path is given up."""
    seed: int
    """The seed of the random numbers."""
    opponent: NotRequired[Literal["random", "worst"]]
    """The choices of the opponent; absent if the model is not a game."""
    plays: List[SimulatePlays]
    """The results, one per starting state; empty before the first ends."""
    time: SimulateTime
    """Seconds by phase; a phase that did not end is `null`."""


class StrategyStatesAttains(TypedDict):
    """The value of the strategy from this state; `null` with `first`, and in an unsafe state."""

    objective: NotRequired[str]
    """The objective that it achieves with this probability; absent unless it does nothing else."""
    improvements: int
    """The number of improvements that it aims at."""
    probability: Bounds
    """The probability of these improvements, or of the objective."""
    cost: Union[Bounds, None]
    """The expected cost until the last of them; `null` where the probability is below 1."""


class StrategyStatesActionsSuccessors(TypedDict):
    """A successor in JSON."""

    state: State
    """The values of the state."""
    probability: float
    """The probability."""
    most_preferred: List[str]
    """The most preferred outcomes."""
    change: Literal["improving", "weakening", "lateral"]
    """The effect of the step, compared with the reference."""
    gained: List[str]
    """Its outcomes that are preferred to one of the reference."""
    lost: List[str]
    """The outcomes of the reference that are preferred to one of its own."""
    rank: Rank
    """The rank of the `kind` asked for."""
    dropped: bool
    """`--safety transition` removes this transition."""
    goal: bool
    """The transition is an improvement that the strategy counts on."""
    unsafe: NotRequired[bool]
    """`true`: no strategy keeps the requirements from it; absent for other states."""
    node: NotRequired[int]
    """The node after this successor; absent without `--all`, and for actions that the strategy does not take."""


class StrategyStatesActions(TypedDict):
    """An action in JSON."""

    name: str
    """Its name."""
    kept: NotRequired[bool]
    """The safety mode keeps it; absent for actions of the opponent."""
    permitted: NotRequired[bool]
    """The permissive strategy permits it; absent for actions of the opponent."""
    progress: NotRequired[bool]
    """It is permitted and comes closer to an improvement with positive probability; absent for actions of the
    opponent."""
    verdict: str
    """The first of the verdicts that applies."""
    reason: str
    """The verdict in words."""
    successors: List[StrategyStatesActionsSuccessors]
    """Its successors."""


class StrategyStatesCycleSteps(TypedDict):
    """A step of a cycle."""

    state: State
    """The values of the state before the step."""
    owner: NotRequired[str]
    """`opponent`: the opponent chooses the action; absent otherwise."""
    action: str
    """The action."""
    to: State
    """The values of the state entered."""
    probability: float
    """The probability of this successor."""
    improves: bool
    """The step is an improvement."""
    gained: List[str]
    """The outcomes that are preferred to one of the reference."""


class StrategyStatesCycle(TypedDict):
    """Steps that improve again and again: the reason for an unbounded rank of the kind of the strategy;
    absent for other ranks, with `--rank` and `--all`, and if there are more than 1000."""

    steps: List[StrategyStatesCycleSteps]
    """The steps, with the successors that come closest to an improvement; at least one of the repeated ones
    improves."""
    repeats_from: int
    """The position of the step, from 0, that comes again after the last one."""


class StrategyStates(TypedDict):
    """A state in JSON."""

    state: State
    """The values of the state."""
    owner: NotRequired[str]
    """`opponent`: in this state of a game the opponent chooses; absent for other states."""
    player: NotRequired[str]
    """The player who chooses in this state of a game; absent for other models, and in deadlocks."""
    most_preferred: List[str]
    """The most preferred outcomes."""
    sasi_rank: Rank
    """The rank by SASI."""
    spi_rank: Rank
    """The rank by SPI."""
    progress_action: NotRequired[Union[str, None]]
    """The first of `actions` with `progress`: the action of the progress strategy; `null` if no action makes
    progress; absent if the opponent chooses."""
    chosen_action: NotRequired[Union[str, None]]
    """The action that the strategy takes: with `first`, and while an objective is pursued, the
    `progress_action`; with `likely` and `cheap`, one with the best value; `null` where the strategy ends:
    nothing is left to improve or to achieve, or the pursued objective is achieved; absent if the opponent
    chooses."""
    attains: Union[StrategyStatesAttains, None]
    """The value of the strategy from this state; `null` with `first`, and in an unsafe state."""
    actions: List[StrategyStatesActions]
    """All enabled actions."""
    longest_play: Union[int, None]
    """The most steps of a path under the progress strategy; `null` if unbounded, at rank 0, with `--rank`, or
    with `--all`."""
    cycle: NotRequired[StrategyStatesCycle]
    """Steps that improve again and again: the reason for an unbounded rank of the kind of the strategy;
    absent for other ranks, with `--rank` and `--all`, and if there are more than 1000."""
    pursues: NotRequired[Union[str, None]]
    """The objective that the strategy pursues, or several as `C and D`; `null` while it improves; absent for
    `sasi` and `spi`."""
    left: NotRequired[List[str]]
    """The pursued objectives that are not achieved yet: several if they are pursued together; absent for
    `sasi` and `spi`."""
    achieved: NotRequired[List[str]]
    """The objectives that are achieved in the state; absent for `sasi` and `spi`."""
    commits: NotRequired[bool]
    """The plan commits to the objective that it pursues: kept actions alone do not achieve it; absent for
    `sasi` and `spi`."""
    gives_up: NotRequired[List[str]]
    """The most preferred outcomes that its next step may then lose; absent for `sasi` and `spi`."""
    unsafe: NotRequired[bool]
    """`true`: no strategy keeps the requirements from it; absent for other states."""
    node: NotRequired[int]
    """The number of this state with its memory, from 0; absent without `--all`."""
    start: NotRequired[bool]
    """The strategy begins here when it begins in this state; absent without `--all`."""
    level: NotRequired[Rank]
    """The number of improvements that are still aimed at, a part of the memory; absent without `--all`."""
    reference: NotRequired[List[str]]
    """The outcomes that steps are compared with, a part of the memory; absent without `--all`."""


class StrategyPolicy(TypedDict):
    """The policy that was written; absent without `--policy`."""

    file: str
    """The file."""
    starts: int
    """The number of nodes where paths may start."""
    nodes: int
    """The number of nodes: states with memory."""


class StrategyTime(TypedDict):
    """Seconds by phase; a phase that did not end is `null`."""

    parse: Union[float, None]
    """Reading model, preferences and states; `null` if not finished."""
    build: Union[float, None]
    """Encoding the model and finding the states; `null` if not finished."""
    levels: Union[float, None]
    """Winning regions, improvement MDP and levels; `null` if not finished."""
    values: Union[float, None]
    """Computing the values for `choose`; `null` if not finished."""
    answer: Union[float, None]
    """Explaining the states; `null` if not finished."""
    total: float
    """Seconds of the whole run."""


class StrategyReport(ModelReport):
    """A report, in the order of the JSON fields."""

    schema: Literal["meliora.strategy/1"]
    """The kind and version of the object."""
    engine: NotRequired[Literal["symbolic", "explicit"]]
    """The engine; absent until it is taken."""
    engine_reason: NotRequired[str]
    """Why `--engine auto` has taken this engine; absent with another `--engine`."""
    safety: Literal["action", "transition", "prefix"]
    """The safety mode."""
    empty: Union[Literal["bottom", "gain", "incomparable"], None]
    """The value of nothing: the `empty` statement of the preferences; `null` until they are read."""
    kind: Literal["sasi", "spi", "plan", "achieve"]
    """The kind of the strategy."""
    choose: Literal["first", "likely", "cheap"]
    """The choice among permitted actions."""
    reward: Union[str, None]
    """The cost of a step: `steps`, or the name of a reward structure; `null` with `first`."""
    asked: Union[Count, None]
    """The number of states that were asked for; `states` may have fewer, because of `--limit`; `null` with
    `--at`, or if unknown."""
    states: List[StrategyStates]
    """The states; empty if `asked` is 0, and before the first is known."""
    policy: NotRequired[StrategyPolicy]
    """The policy that was written; absent without `--policy`."""
    time: StrategyTime
    """Seconds by phase; a phase that did not end is `null`."""


class SweepRuns(TypedDict):
    """An instance of a sweep."""

    constants: Dict[str, Any]
    """The constants of the instance."""
    status: Literal["done", "limit", "error"]
    """The end of the run."""
    result: Union[CheckReport, ReachReport, CompareReport, ErrorReport]
    """The object that the command writes for the instance, an error among them."""


class SweepReport(TypedDict):
    """The results of a sweep."""

    schema: Literal["meliora.sweep/1"]
    """The kind and version of the object."""
    command: Literal["check", "reach", "compare"]
    """The command that writes the report of an instance."""
    ranges: Dict[str, Any]
    """The values of each constant that varies, as a list."""
    runs: List[SweepRuns]
    """The instances in their order."""


class ValuesStatesLevelsActions(TypedDict):
    """The values of an action for one number of improvements."""

    action: str
    """Its name."""
    probability: Bounds
    """The greatest probability of the improvements after this action."""
    cost: Union[Bounds, None]
    """The least expected cost after this action; `null` if the improvements do not stay certain."""


class ValuesStatesLevels(TypedDict):
    """The values of a state for one number of improvements."""

    improvements: int
    """The number of improvements."""
    probability: Bounds
    """The greatest probability of these improvements."""
    cost: Union[Bounds, None]
    """The least expected cost until the last of them; `null` where they are not certain."""
    actions: List[ValuesStatesLevelsActions]
    """The kept actions, best first; empty where no improvement is possible."""
    within: Union[List[float], None]
    """The greatest probability of these improvements within 0, 1, 2, … steps; `null` if steps were not given
    (`--within`)."""


class ValuesStatesByGoal(TypedDict):
    """The probability that the first improvement gains these objectives."""

    gained: List[str]
    """The objectives that are preferred to most preferred ones of the state, and none of which is sure there."""
    probability: Bounds
    """The probability."""


class ValuesStates(TypedDict):
    """The values of a state."""

    state: State
    """The values of its variables."""
    unsafe: NotRequired[bool]
    """`true`: no strategy keeps the requirements from it; absent for other states."""
    most_preferred: List[str]
    """The most preferred objectives that are certain there."""
    sasi_rank: Rank
    """Number of improvements that are certain (SASI rank)."""
    spi_rank: Rank
    """Number of improvements that are possible (SPI rank)."""
    levels: List[ValuesStatesLevels]
    """The values for 1, 2, … improvements; none for an unsafe state."""
    number: Union[Bounds, None]
    """The greatest expected number of improvements; `null` for an unsafe state."""
    within: Union[List[float], None]
    """The greatest probability of an improvement within 0, 1, 2, … steps; `null` if steps were not given
    (`--within`), and for an unsafe state."""
    by_goal: NotRequired[List[ValuesStatesByGoal]]
    """The gains of the first improvement with their probabilities, under the strategy that makes it most
    likely; absent if they were not asked for (`--by-goal`), and for an unsafe state."""


class ValuesTime(TypedDict):
    """Seconds by phase; a phase that did not end is `null`."""

    parse: Union[float, None]
    """Reading model, preferences and states; `null` if not finished."""
    build: Union[float, None]
    """Encoding the model and finding the states; `null` if not finished."""
    levels: Union[float, None]
    """Winning regions, improvement MDP and levels; `null` if not finished."""
    explore: Union[float, None]
    """Finding the states that the values depend on; `null` if not finished."""
    solve: Union[float, None]
    """Computing the values; `null` if not finished."""
    total: float
    """Seconds of the whole run."""


class ValuesReport(ModelReport):
    """A report, in the order of the JSON fields."""

    schema: Literal["meliora.values/1"]
    """The kind and version of the object."""
    engine: NotRequired[Literal["symbolic", "explicit"]]
    """The engine; absent until it is taken."""
    engine_reason: NotRequired[str]
    """Why `--engine auto` has taken this engine; absent with another `--engine`."""
    safety: Literal["action", "transition", "prefix"]
    """The safety mode."""
    empty: Union[Literal["bottom", "gain", "incomparable"], None]
    """The value of nothing: the `empty` statement of the preferences; `null` until they are read."""
    history: NotRequired[str]
    """`play`: objectives are about whole paths; absent with `history = state`."""
    counts: Union[Counts, None]
    """The sizes of the model; `null` if unknown."""
    reward: str
    """The cost of a step: `steps`, or the name of a reward structure."""
    precision: float
    """The largest width of the bounds."""
    states: List[ValuesStates]
    """The states; empty before the levels are known."""
    time: ValuesTime
    """Seconds by phase; a phase that did not end is `null`."""


class VerifyChecked(TypedDict):
    """A region that was checked."""

    region: str
    """Its name."""
    inside: bool
    """True if it was shown to have no state too many."""
    outside: bool
    """True if it was shown to have no state too few."""


class VerifyViolation(TypedDict):
    """The first condition that does not hold; `null` if accepted or unknown."""

    condition: str
    """The condition."""
    state: Union[State, None]
    """A state for which it fails; `null` if the condition is not about a state."""


class VerifyReport(Report):
    """A report, in the order of the JSON fields."""

    schema: Literal["meliora.verify/1"]
    """The kind and version of the object."""
    directory: str
    """The directory of the dump."""
    accepted: Union[bool, None]
    """All conditions hold, and all regions are certified; `null` if unknown."""
    taken: Dict[str, str]
    """The settings that the check took from the dump: `constants`, `scope`, `safety`, `empty`, `history`,
    `max_level`, and for the values `reward` and `levels`. Nobody proves that the user meant these. Empty if
    the dump was not read."""
    checked: List[VerifyChecked]
    """The regions that were found to be right; empty if the check ended before the first."""
    uncertified: List[str]
    """The regions, and `values.csv`, that the certificate does not prove, because a limit ended `export`."""
    unproved: List[str]
    """The fields of the manifest that nothing proves: they inform only. Empty if the check did not end."""
    violation: Union[VerifyViolation, None]
    """The first condition that does not hold; `null` if accepted or unknown."""
    time: CompareTime
    """Seconds by phase; a phase that did not end is `null`."""
