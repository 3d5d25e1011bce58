"""Types and docstrings of the compiled part, written by `python/stub.py`."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from os import PathLike
from typing import Any, Final, Literal, final, overload

import numpy as np
from numpy.typing import NDArray
from typing_extensions import TypeAlias

from ._answers import Answer
from .reports import (
    CheckReport,
    CompareReport,
    PolicyReport,
    SimulatePlaysCommits,
    SimulatePlaysValue,
    StrategyStatesAttains,
    ValuesStates,
)

_Value: TypeAlias = bool | int | str
_State: TypeAlias = Mapping[str, _Value]
_ShieldState: TypeAlias = Mapping[str, _Value] | Sequence[_Value] | NDArray[Any] | int
_Path: TypeAlias = str | PathLike[str]
_Rank: TypeAlias = int | float
_Timeout: TypeAlias = float | str
_Scope: TypeAlias = Literal["reachable", "all"]
_Storage: TypeAlias = Literal["symbolic", "explicit"]
_Engine: TypeAlias = Literal["auto", "symbolic", "explicit"]
_Safety: TypeAlias = Literal["action", "transition", "prefix"]
_StrategyKind: TypeAlias = Literal["sasi", "spi", "plan", "achieve"]
_Order: TypeAlias = Literal["auto", "declared"] | Sequence[str]
_Choose: TypeAlias = Literal["first", "likely", "cheap"]
_Which: TypeAlias = Literal["permitted", "progress", "chosen", "kept"]
_Empty: TypeAlias = Literal["bottom", "gain", "incomparable"]
_Constants: TypeAlias = dict[str, bool | int | float | Fraction]
_Bounds: TypeAlias = dict[str, tuple[int, int]]
_Successors: TypeAlias = dict[str, list[tuple[float, dict[str, Any]]]]
#: A dictionary as Gymnasium's `P`, an array, or one matrix per action; scipy has no types.
_Transitions: TypeAlias = Any
_States: TypeAlias = int | str | Iterable[Any] | NDArray[Any]
_Progress: TypeAlias = Callable[[Progress], object]

__all__ = ['__version__', 'Action', 'Analysis', 'Dump', 'Explanation', 'Exploration', 'Levels', 'Model', 'Play', 'Preferences', 'Progress', 'Reachability', 'Region', 'RegionIterator', 'Shield', 'Simulation', 'Strategy', 'Successor', 'Variable', 'Verdict', '_Answers', '_Columns', '_Rows', 'verify']

__version__: Final[str]

@final
class Action:
    """An enabled action."""
    @property
    def kept(self) -> bool:
        """True if the safety mode keeps the action; False where the opponent chooses."""
    @property
    def name(self) -> str:
        """Its name."""
    @property
    def permitted(self) -> bool:
        """True if the strategy permits it."""
    @property
    def progress(self) -> bool:
        """True if it comes closer to an improvement, or to the pursued objective, with positive
        probability."""
    @property
    def reason(self) -> str:
        """The reason in a sentence."""
    @property
    def successors(self) -> tuple[Successor, ...]:
        """The possible successors."""
    @property
    def verdict(self) -> str:
        """The reason in one word: `"improves"`, `"may-improve"`, `"approaches"`, `"stays"`,
        `"weakens"`, `"exposes"` (the opponent can weaken afterwards), `"unsafe"`, `"violates"`, `"strays"`,
        `"hopeless"` or `"nothing-ahead"`; while an objective is pursued `"achieves"`, `"may-achieve"`,
        `"nears"`, `"keeps"`, `"forfeits"` or `"unachievable"`; where a rule makes an objective as likely as
        possible `"likeliest"`, `"passed-over"` or `"impossible"`. What an action of the opponent leads to is
        also `"lateral"`."""

@final
class Analysis:
    """The result of `Model.check`: the states from which improvements are possible or sure, and how
    many.

    `sasi` and `spi` are the levels; `target`, `almost_sure` and `positive` are the regions of each
    objective. `classes` are the states with the same most preferred objectives, and `strategy`
    returns the strategies. Several threads may use an analysis: their calls take turns."""
    def __reduce__(self) -> tuple[Any, ...]: ...
    def _repr_html_(self) -> str: ...
    @property
    def almost_sure(self) -> dict[str, Region]:
        """The almost-sure regions by objective: some strategy reaches the target with probability one."""
    @property
    def classes(self) -> dict[tuple[str, ...], Region]:
        """The states of each class. The keys are the most preferred objectives, as tuples of names in
        the order of declaration; () is the class of the states without an almost-sure objective.
        Empty if a limit ended the work before."""
    @property
    def complete(self) -> bool:
        """True if all results are known: no limit ended the work."""
    @property
    def counts(self) -> dict[str, int] | None:
        """The numbers of `states`, `choices`, `transitions`, `deadlocks` and `initial` states. With
        `history = play`, `model_states` is the number of states without monitors; with requirements,
        `unsafe` is the number of states from which they cannot be kept. None if a limit ended the
        work before."""
    @property
    def engine(self) -> _Storage:
        """`"symbolic"` or `"explicit"`."""
    def explicit_files(self, format: Literal['explicit', 'drn', 'umb']='drn', strategy: str | None=None, *, objective: str | None=None, limit: int=1000000, timeout: _Timeout | None=None, progress: _Progress | None=None) -> dict[str, bytes]:
        """Returns the states one by one for other programs, as `meliora export --format` writes them: the content of each
        file by its name.

        Args:
            format: "explicit" (PRISM's `.tra`, `.sta`, `.lab`), "drn" (Storm) or "umb".
            strategy: The strategy whose induced model is written, such as "sasi" or "plan:progress", with a table of its
                actions; None for the model itself.
            objective: The objective of the strategy "achieve".
            limit: Maximum number of states.
            timeout, progress: As in `Model.explore`.

        Raises:
            TooLarge: There are more than `limit` states."""
    @property
    def exploration(self) -> Exploration:
        """The exploration that is analysed. With `history = play` its states have the variables of the
        monitors too."""
    def export(self, folder: _Path, *, timeout: _Timeout | None=None, progress: _Progress | None=None) -> None:
        """Writes all regions and strategies as decision diagrams into a folder, with a certificate, as
        `meliora export` does. `Dump` reads them, and `verify` checks them. An older dump is replaced.

        Raises:
            OSError: The folder contains something else, or cannot be written."""
    @property
    def improvement(self) -> dict[str, int] | None:
        """The sizes of the improvement MDP: `states`, `transitions`, and the number of `dropped`
        transitions of the model. None with `safety="prefix"`, which has no such MDP, and if a limit
        ended the work before."""
    def jointly(self, *, timeout: _Timeout | None=None, progress: _Progress | None=None) -> dict[tuple[str, ...], dict[tuple[str, ...], Region]]:
        """Computes which most preferred objectives of each class one strategy achieves together, in the
        same path, almost surely. The keys are those of `classes`; the values are dictionaries from
        tuples of at least two objectives to the states of the class from which this is possible,
        larger sets first.

        Args:
            timeout, progress: As in `Model.explore`.

        Raises:
            UsageError: A class has more than 10 most preferred objectives, or a limit ended the work
                before the classes were known."""
    @property
    def model(self) -> Model:
        """The model."""
    def most_preferred(self, state: _State) -> tuple[str, ...]:
        """Returns the most preferred objectives of a state, in the order of declaration."""
    @property
    def positive(self) -> dict[str, Region]:
        """The positive regions by objective: some strategy reaches the target with positive
        probability."""
    @property
    def preferences(self) -> Preferences:
        """The preferences."""
    def region(self, name: str) -> Region:
        """Returns the region with this name.

        Raises:
            UsageError: The name is unknown, or the region is not computed yet."""
    @property
    def region_names(self) -> list[str]:
        """The names of all known regions: `target:A`, `almost-sure:A`, `class:A+B`, `sasi:1`, …, as in
        dumps."""
    def resume(self, *, timeout: _Timeout | None=None, progress: _Progress | None=None) -> None:
        """Continues after a limit; does nothing if the analysis is complete."""
    @property
    def safety(self) -> _Safety:
        """`"action"`, `"transition"` or `"prefix"`."""
    @property
    def sasi(self) -> Levels:
        """The levels of almost-sure improvement."""
    @property
    def scope(self) -> _Scope:
        """`"reachable"` or `"all"`."""
    @property
    def spi(self) -> Levels:
        """The levels of positive improvement."""
    def strategy(self, kind: _StrategyKind | None=None, *, objective: str | None=None, choose: _Choose='first', states: Sequence[_State] | None=None, levels: int | None=None, reward: str='steps', timeout: _Timeout | None=None, progress: _Progress | None=None) -> Strategy:
        """Returns a strategy.

        Args:
            kind: "sasi" or "spi" improves; "plan" makes all guaranteed improvements and then achieves a
                most preferred objective; "achieve" achieves one objective, or several together. None for
                "spi" with `choose="likely"`, else "sasi".
            objective: The objective that "achieve" achieves ("C,D": both in one path), and that "plan"
                pursues where it is a most preferred one; None for the first of these.
            choose: The permitted action that the strategy takes: "first" that makes progress; "likely"
                attains the greatest probability of all possible improvements (SPI) or of the objective
                ("achieve"); "cheap" the least expected cost until the last certain one (SASI).
            states: The states where paths may start with `choose="likely"` or "cheap"; None for the
                initial states.
            levels, reward: As in `values`.
            timeout, progress: As in `Model.explore`.

        Raises:
            UsageError: A limit ended the work before the levels of this kind were computed; or the
                options do not fit together."""
    @property
    def target(self) -> dict[str, Region]:
        """The targets of the objectives by name, as far as they are known. The target of a temporal
        objective is the set of states from which its condition can be satisfied from then on,
        almost surely."""
    def to_dict(self) -> CheckReport:
        """Returns the report of `meliora check --json` as a dictionary; its counts are decimal
        strings."""
    def to_html(self, grid: Sequence[str] | None=None, *, timeout: _Timeout | None=None, progress: _Progress | None=None) -> str:
        """Returns an HTML page with interactive maps that loads nothing from elsewhere.

        Args:
            grid: The variables that span the maps: (row, column), or (column,). None for
                those with names that suggest rows and columns. Maps need the symbolic engine.
            timeout, progress: As in `Model.explore`."""
    def to_svg(self, picture: str='hasse', grid: Sequence[str] | None=None, *, timeout: _Timeout | None=None, progress: _Progress | None=None) -> str:
        """Returns a picture as SVG: "hasse" is the preference order; "sasi", "spi" and "classes" are
        maps, which need the symbolic engine. `grid`, `timeout` and `progress` as in `to_html`."""
    def to_text(self) -> str:
        """Returns all tables as text."""
    @property
    def usage(self) -> dict[str, int]:
        """The resources used so far: `peak_nodes`, the largest number of live diagram nodes; `bytes`
        of the engine's own tables; and `peak_rss_bytes`, the largest size of this process."""
    def values(self, states: Sequence[_State] | None=None, *, levels: int | None=None, reward: str='steps', within: int | None=None, exact: bool=False, timeout: _Timeout | None=None, progress: _Progress | None=None) -> list[ValuesStates]:
        """Computes how likely improvements are, how soon they come and at what cost; returns the list
        `states` of `meliora values --json`, with one dictionary per state. An unsafe state has `unsafe`
        and no numbers.

        Args:
            states: States of the scope; None for the initial states.
            levels: Greatest number of improvements; None for the levels found, at most 10.
            reward: Reward structure that is the cost of a step; "steps": each step costs 1.
            within: Compute also the probabilities of success within 0, 1, …, `within` steps.
            exact: Compute with fractions; for small models.
            timeout, progress: As in `Model.explore`.

        Raises:
            UsageError: A state is not in the scope, or the model has no such reward structure.
            InputError: A reward is negative or has no value in some state of the scope."""

@final
class Dump:
    """A dump that `Analysis.export` or `meliora export` wrote: regions and strategies, without the model.

    An expression joins names of `regions` by `&`, `|`, `!` and parentheses: "sasi:1 & !sasi:2".

    Args:
        folder: The folder of the dump.
        where: A condition over its variables and constants that restricts all answers, such as "r > 2".

    Raises:
        Error: The dump is invalid.
        InputError: The condition is invalid.
        OSError: A file cannot be read."""
    def __new__(cls, folder: _Path, where: str | None=None) -> Dump: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    def actions(self, regions: str, state: _State) -> tuple[str, ...]:
        """Returns the actions of a state in an expression with strategies, such as "strategy:sasi:1".

        Raises:
            UsageError: The expression has no strategy: it is a set of states."""
    def contains(self, regions: str, state: _State) -> bool:
        """Returns True if a state is in an expression."""
    def count(self, regions: str) -> int:
        """Returns the number of states of an expression; of a strategy, the number of pairs of a state and
        an action.

        Raises:
            InputError: A name is unknown, or the expression is invalid."""
    @property
    def manifest(self) -> dict[str, Any]:
        """The manifest as a dictionary: variables, constants, the hashes of the texts, and so on."""
    @property
    def regions(self) -> tuple[str, ...]:
        """The names of the regions and strategies."""
    def states(self, regions: str, limit: int=1000) -> list[dict[str, Any]]:
        """Returns up to `limit` states of an expression as dictionaries, in the order of their values."""

@final
class Explanation:
    """A state under a strategy, with every enabled action."""
    @property
    def achieved(self) -> tuple[str, ...]:
        """The objectives that are achieved in the state; empty for strategies that achieve none."""
    @property
    def actions(self) -> tuple[Action, ...]:
        """All enabled actions, in the order of the program."""
    @property
    def commits(self) -> bool:
        """True if the plan commits to the objective that it pursues: kept actions alone do not achieve
        it, and its steps may give up others."""
    @property
    def left(self) -> tuple[str, ...]:
        """The pursued objectives that are not achieved yet: several if they are pursued together."""
    @property
    def most_preferred(self) -> tuple[str, ...]:
        """The most preferred objectives of the state; empty if it is unsafe."""
    @property
    def owner(self) -> str | None:
        """The player of a game that chooses in the state; None for deadlocks and other models."""
    @property
    def progress_action(self) -> str | None:
        """The action of the progress strategy; None where the strategy ends."""
    @property
    def pursues(self) -> str | None:
        """The objective that the strategy pursues, or several as "C and D"; None while it improves, and for
        strategies that achieve none."""
    @property
    def rank(self) -> _Rank:
        """The rank of the state: an int, or `math.inf`; `math.nan` if it is unsafe."""
    @property
    def state(self) -> dict[str, Any]:
        """The state."""
    @property
    def theirs(self) -> bool:
        """True if this is the opponent: then no action is permitted or forbidden, and reasons say what the
        actions lead to."""
    @property
    def unsafe(self) -> bool:
        """True if no strategy keeps the requirements from the state."""

@final
class Exploration:
    """The states of a model's scope, with their choices.

    An exploration answers any number of queries without exploring again. Operators can combine all
    of their regions."""
    def __reduce__(self) -> tuple[Any, ...]: ...
    def check(self, preferences: Preferences | _Path, *, safety: _Safety='prefix', max_level: int | None=None, timeout: _Timeout | None=None, progress: _Progress | None=None) -> Analysis:
        """Analyses the exploration under preferences, as `Model.check` without exploring again. With
        `history = play` the model is explored anew in product with its monitors."""
    @property
    def counts(self) -> dict[str, int]:
        """The numbers of `states`, `choices`, `transitions`, `deadlocks` and `initial` states. With
        `history = play`, `model_states` is the number of states without monitors."""
    @property
    def deadlocks(self) -> Region:
        """The states without an enabled command; their only choice is a self-loop."""
    @property
    def engine(self) -> _Storage:
        """`"symbolic"` or `"explicit"`."""
    @property
    def initial(self) -> Region:
        """The initial states."""
    @property
    def model(self) -> Model:
        """The model."""
    @property
    def order(self) -> list[str] | None:
        """The names of the bits in the order of the diagrams, from the root down; None with the
        explicit engine."""
    def owner(self, state: _State) -> str | None:
        """Returns the player that chooses in a state of a game; None for deadlocks and other models.

        Raises:
            UsageError: The state is not in the scope."""
    @property
    def players(self) -> dict[str, Region]:
        """The players of a game, each with the states in which it chooses; {} for other models. A deadlock
        belongs to nobody."""
    def reach(self, target: Region | str | _State, *, timeout: _Timeout | None=None, progress: _Progress | None=None) -> Reachability:
        """Computes the states from which some strategy, and from which every strategy, reaches a
        target with probability one, and with positive probability. In a game these are the states from
        which we, and from which the opponent can enforce this.

        Args:
            target: A region, a dictionary of values, or a text: a condition in the model's language,
                a temporal formula such as 'G F x = 3', or a property such as 'P>=1 [ F x = 3 ]' or
                'Pmax=? [ F x = 3 ]'; of a game, '<<p1>> P>=1 [ F x = 3 ]'.
                For a temporal formula other than 'F condition', the regions are of the product with
                its monitors, in the states where these begin.

        `Model.reach` can leave out the states behind the target, which are explored here already."""
    @property
    def scope(self) -> _Scope:
        """`"reachable"` or `"all"`."""
    @property
    def states(self) -> Region:
        """All states of the scope."""
    def successors(self, state: _State) -> _Successors:
        """Returns the successors of the enabled actions of a state, whoever chooses there: for each action a
        list of pairs (probability, state). Names are as in `Strategy`.

        Raises:
            UsageError: The state is not in the scope."""
    @property
    def theirs(self) -> Region:
        """The states of a game in which the opponent chooses; empty for other models."""
    def where(self, condition: str | _State | None=None, /, **values: _Value) -> Region:
        """Returns the states that satisfy a condition in the model's language, such as 'x = 3 &
        "goal"', or in which some variables have the values of a dictionary, or of arguments:
        `explored.where(x=3)`.

        Raises:
            InputError: The condition is invalid (the error shows the place), or has no value in
                some state."""

@final
class Levels:
    """The levels of one kind. Level k contains the states from which k improvements can be made,
    almost surely (SASI) or with positive probability (SPI)."""
    @overload
    def __getitem__(self, index: int, /) -> Region:
        """Returns the region of a known level, from level 1 at index 0 on, as `regions` does."""
    @overload
    def __getitem__(self, index: slice, /) -> tuple[Region, ...]: ...
    def __iter__(self) -> Iterator[Region]: ...
    def __len__(self) -> int:
        """The number of known levels."""
    def __reduce__(self) -> tuple[Any, ...]: ...
    def at_least(self, k: int) -> Region:
        """Returns the states of rank k or more; for k = 0 all states but the unsafe ones, which have no
        rank.

        Raises:
            UsageError: The level was not computed."""
    @property
    def complete(self) -> bool:
        """True if all levels are known: neither `max_level` nor a limit ended the search."""
    @property
    def counts(self) -> list[int]:
        """The sizes of the known levels from level 1 on, strictly decreasing; empty if no state can improve,
        or if none is known yet (`complete` is False)."""
    def exactly(self, k: float) -> Region:
        """Returns the states of rank k exactly; `math.inf` for those of unbounded rank.

        Raises:
            UsageError: The levels that determine these states were not computed."""
    @property
    def kind(self) -> Literal['sasi', 'spi']:
        """`"sasi"` or `"spi"`."""
    def rank(self, state: _State) -> _Rank:
        """Returns the rank of a state: the number of possible or sure improvements, an int or
        `math.inf`; `math.nan` for unsafe states, which have none. If `max_level` ended the search,
        the true rank of a state in the last level may be larger; see `complete`.

        Raises:
            UsageError: A variable is missing or unknown."""
    @property
    def regions(self) -> tuple[Region, ...]:
        """The known levels from level 1 on; empty if `counts` is."""
    def strategy(self) -> Strategy:
        """Returns the strategies of this kind."""
    def to_numpy(self, row: str | None, column: str, where: _State | None=None) -> NDArray[np.float64]:
        """Returns the greatest ranks over one or two integer variables. The result is an array of
        floats of shape (rows, columns), or (columns,) if `row` is None, from the smallest values
        on. A cell contains the greatest rank of its states in which the variables of `where` have
        their values; all other variables are free. A cell without states is NaN, and so is one whose
        states are all unsafe; `Analysis.region("unsafe")` tells them apart. An unbounded rank is
        infinity.

        The symbolic engine does not enumerate states for this. Needs NumPy."""
    @property
    def unbounded(self) -> Region | None:
        """The states from which any number of improvements is possible. None if this is unknown,
        because `max_level` or a limit ended the search."""

@final
class Model:
    """A model in PRISM's language or in JANI, or a list of its states: read, checked and flat, but not
    explored.

    Models are immutable values: they can be pickled, and used by several threads."""
    def __reduce__(self) -> tuple[Any, ...]: ...
    def _answers(self, properties: Sequence[str], *, scope: _Scope, engine: _Engine, memory: int | str | None, timeout: _Timeout | None) -> _Answers:
        """Answers the properties of an instance of a sweep."""
    def _repr_html_(self) -> str: ...
    @staticmethod
    def _restore(name: str, text: str, constants: str, bounds: str, archive: bytes | None=None, coalition: Sequence[str] | None=None, beside: tuple[tuple[str, str] | None, tuple[str, str] | None]=..., rewards: Sequence[Any]=...) -> Model: ...
    @property
    def actions(self) -> list[str]:
        """The names of the action labels."""
    @overload
    def ask(self, properties: str, *, file: None=None, constants: None=None, only: None=None, require: Sequence[str] | None=None, stop_at_target: bool=False, precision: float=1e-06, policy: bool=False, opponent_policy: bool=False, strong: bool=False, scope: _Scope='reachable', engine: _Engine='auto', memory: int | str | None=None, order: _Order | None=None, timeout: _Timeout | None=None, progress: _Progress | None=None) -> Answer:
        """Answers properties in the initial states, as `meliora reach --property` does: conditions on states, whose
        operators ask for probabilities, rewards, several objectives at once, filters. Properties share their regions. The
        states are not explored where the answers need only some of them.

        Args:
            properties: A property such as 'Pmax=? [ F "goal" ]', the name of one of the model's, or a list of these. None
                for the goal of a planning problem, or for all that the model names.
            file: A property file in PRISM's language, instead of `properties`.
            constants: Values of the constants that the file leaves undefined, by name.
            only: The name of the only property of the file that is asked for.
            require: Safe formulas such as 'G x < 3' that every strategy must keep.
            stop_at_target: Do not explore the states behind those that decide the question, one property. The answer is
                the same.
            precision: The largest width of the bounds of a number, relative to the number above 1.
            policy: Also return, as `policy`, what `meliora reach --policy` writes: the strategy that attains the answer to
                the only property, the strategies of `multi`, or for `Pmax>=1 [ F … ]` a list of rules. None if there are
                none. `Policy` follows it.
            opponent_policy: Also return, as `opponent_policy`, the strategy of the opponent of a game.
            strong: Also return, as `plan`, whether a strong plan exists: every path reaches the target within a bound.
            engine: "auto" (default): the first way to end has the answer.
            scope, memory, order, timeout, progress: As in `explore`. Of several properties, each has a share of the time.

        Returns:
            The answer as a dictionary, or a list of these. One of several that has no answer has a `reason`.

        Raises:
            InputError: A text is wrong, or the only property cannot be answered.
            LimitError: A limit was reached; its `known["properties"]` has the answers so far."""
    @overload
    def ask(self, properties: list[str] | tuple[str, ...], *, file: None=None, constants: None=None, only: None=None, require: Sequence[str] | None=None, stop_at_target: bool=False, precision: float=1e-06, policy: bool=False, opponent_policy: bool=False, strong: bool=False, scope: _Scope='reachable', engine: _Engine='auto', memory: int | str | None=None, order: _Order | None=None, timeout: _Timeout | None=None, progress: _Progress | None=None) -> list[Answer]: ...
    @overload
    def ask(self, properties: None=None, *, file: _Path | None=None, constants: _Constants | None=None, only: str | None=None, require: Sequence[str] | None=None, stop_at_target: bool=False, precision: float=1e-06, policy: bool=False, opponent_policy: bool=False, strong: bool=False, scope: _Scope='reachable', engine: _Engine='auto', memory: int | str | None=None, order: _Order | None=None, timeout: _Timeout | None=None, progress: _Progress | None=None) -> Any: ...
    def check(self, preferences: Preferences | _Path, *, scope: _Scope='reachable', safety: _Safety='prefix', engine: _Engine='symbolic', max_level: int | None=None, memory: int | str | None=None, order: _Order | None=None, timeout: _Timeout | None=None, progress: _Progress | None=None) -> Analysis:
        """Computes the states from which improvements are possible or sure, and how many. Explores the
        model and computes winning regions, classes, the improvement MDP and the levels of SASI and
        SPI.

        Args:
            preferences: A Preferences, or the path of a preference file.
            safety: How to treat actions that may weaken: "action", "transition" (the paper's
                definition to the letter) or "prefix".
            max_level: The search for levels ends after this level.
            scope, engine, memory, order, timeout, progress: As in `explore`.

        Raises:
            InputError: The preferences are invalid; each problem has its place.
            LimitError: A limit was reached; its `analysis` has the results so far."""
    @property
    def coalition(self) -> tuple[str, ...]:
        """The players that we are; all others are the opponent. Unless `with_coalition` named them, a
        preference file may name others."""
    def compare(self, preferences: Preferences | _Path, *, membership: int=100000, scope: _Scope='reachable', safety: _Safety='prefix', max_level: int | None=None, memory: int | str | None=None, order: _Order | None=None, timeout: _Timeout | None=None, progress: _Progress | None=None) -> CompareReport:
        """Analyses the preferences with both engines and compares the results, as `meliora compare` does.

        Args:
            preferences: A Preferences, or the path of a preference file.
            membership: The maximum number of states for the comparison of each state in each region.
            safety, max_level, scope, memory, order, timeout, progress: As in `check`.

        Returns:
            The report of `meliora compare --json`, without times: `equal`, and the first `difference`."""
    @property
    def constants(self) -> dict[str, bool | int | float]:
        """All constants with their values, in the order of declaration."""
    def explore(self, *, scope: _Scope='reachable', engine: _Engine='symbolic', memory: int | str | None=None, order: _Order | None=None, timeout: _Timeout | None=None, progress: _Progress | None=None) -> Exploration:
        """Explores the states of the scope. `check` does this first; explore once for several queries.

        Args:
            scope: The valuations that are states: "reachable" from the initial states, or "all".
            engine: The storage of states: "symbolic" for decision diagrams, "explicit" for a list,
                "auto" for the first of both to know all states; in `check` and `reach`, the answer.
            memory: Bytes for the tables of the engine, or a text such as "2GiB"; None for half of
                the machine's memory.
            order: The order of the bits in diagrams: "auto", "declared", or names of variables or
                bits from the root down.
            timeout: Seconds, or a text such as "5s", after which the work ends with OutOfTime.
            progress: Called with a Progress at intervals, from the calling thread; an exception
                raised by it ends the work.

        Raises:
            InputError: An expression has no value in some state; the error shows an example.
            LimitError: A limit was reached."""
    @staticmethod
    def from_file(path: _Path, *, constants: _Constants | None=None, bounds: _Bounds | None=None, timeout: _Timeout | None=None, progress: _Progress | None=None) -> Model:
        """Reads a model from a file. The content tells if it is in PRISM's language or in JANI, an archive
        (UMB), or a list of states: DRN, or PRISM's `.tra` with the `.sta` and `.lab` next to it.

        Args:
            path: The file.
            constants: Values of the undefined constants, by name; a `fractions.Fraction` stays exact.
            bounds: (low, high) for integers of a JANI model without bounds, by name.
            timeout: Seconds, or a text such as "5s", after which reading ends with OutOfTime.
            progress: Called with a Progress at intervals.

        Raises:
            InputError: The text is invalid; each problem has its place.
            OSError: The file cannot be read."""
    @staticmethod
    def from_pddl(domain: _Path, problem: _Path, *, timeout: _Timeout | None=None, progress: _Progress | None=None) -> Model:
        """Reads a planning problem in PDDL: two files, in any order. See `ask` for whether a plan exists.

        Args:
            domain, problem: The files.
            timeout, progress: As in `from_file`.

        Raises:
            InputError: A text is invalid, or has something that is not supported.
            OSError: A file cannot be read."""
    @staticmethod
    def from_string(text: str, *, constants: _Constants | None=None, bounds: _Bounds | None=None, name: str='model', timeout: _Timeout | None=None, progress: _Progress | None=None) -> Model:
        """Reads a model from a string, as `from_file` does from a file. Messages call the model
        `name`."""
    @staticmethod
    def from_transitions(transitions: _Transitions, rewards: Mapping[str, Any] | None=None, labels: Mapping[str, _States] | None=None, start: _States | None=None, *, actions: Sequence[str] | None=None, states: Sequence[Any] | None=None, timeout: _Timeout | None=None, progress: _Progress | None=None) -> Model:
        """Reads a model from a table of transitions. The only variable is `state`: the name of the
        state, or its number if states have no names.

        Args:
            transitions: Gymnasium's `env.unwrapped.P`, a dictionary `P[state][action]` of lists of
                tuples (probability, next state, reward, terminated), of dictionaries from next
                states to probabilities, or of a single next state; or a NumPy array of the shape
                (states, actions, states); or one matrix (states, states) per action, of NumPy or
                scipy, as a list, or as a dictionary by the name of the action. Nested lists may
                stand for arrays. The keys of a dictionary of states name them, unless they are the
                numbers from 0 on. An array of the shape (actions, states, states) is read as such if the
                numbers of states and actions differ. An action whose row has only zeros is not available in that
                state. A state that a terminated transition enters is absorbing: each of its
                actions stays there; the label "done" marks these states, unless `labels` has it.
                The rewards of tuples are not used.
            rewards: Reward structures: for each name an array (states) or (states, actions), or a
                dictionary by states, where others earn 0.
            labels: For each name the states that have it: names or numbers, each once, or a Boolean (or
                0.0 and 1.0) for each state. Preferences use them as `F "goal"`.
            start: The initial states: a state, states, a Boolean for each state, or a distribution
                such as `env.unwrapped.initial_state_distrib`; None for all states.
            actions: The names of the actions; None for `a0`, `a1`, …, or the keys if they are names.
            states: The names of the states in their order; None for the keys of a dictionary, unless
                these are the numbers from 0 on.
            timeout, progress: As in `from_file`.

        Raises:
            UsageError: A shape, a sum of probabilities, a state or a name is wrong."""
    @staticmethod
    def from_umb(source: _Path | bytes, *, timeout: _Timeout | None=None, progress: _Progress | None=None) -> Model:
        """Reads a model from an archive in the unified Markov binary format (UMB).

        Args:
            source: The path of the archive, or its bytes.
            timeout, progress: As in `from_file`.

        Raises:
            InputError: The archive has an invalid model, or something that is not supported.
            OSError: The file cannot be read, or is not an archive."""
    @property
    def kind(self) -> Literal['mdp', 'dtmc', 'smg']:
        """`"mdp"`, `"dtmc"` or `"smg"`."""
    @property
    def labels(self) -> list[str]:
        """The names of the labels."""
    @property
    def name(self) -> str:
        """The name in messages: the path of the file."""
    @property
    def players(self) -> tuple[str, ...]:
        """The players of a game, in the order of declaration; () for other models."""
    @property
    def properties(self) -> list[str]:
        """The names of the properties that the model names, for `ask`."""
    def reach(self, target: str, *, stop_at_target: bool=False, scope: _Scope='reachable', engine: _Engine='symbolic', memory: int | str | None=None, order: _Order | None=None, timeout: _Timeout | None=None, progress: _Progress | None=None) -> Reachability:
        """Computes the four qualitative regions of a target: `explore` followed by
        `Exploration.reach`.

        Args:
            target: A condition in the model's language, such as 'x = 3 & "goal"', a temporal formula,
                or a property such as 'P>=1 [ G F x = 3 ]'.
            stop_at_target: Do not explore the states behind those that decide the question. In the initial
                states the answer is the same; the regions are those of the part explored. Only with the
                scope "reachable".
            scope, engine, memory, order, timeout, progress: As in `explore`.

        Raises:
            InputError: The text is wrong; with `stop_at_target`, also if no state decides it, as for `G F`."""
    def shield(self, property: str, threshold: float | None=None, *, relative: bool=False, limit: int=1000000, scope: _Scope='reachable', engine: _Engine='auto', memory: int | str | None=None, order: _Order | None=None, timeout: _Timeout | None=None, progress: _Progress | None=None) -> Shield:
        """Computes how safe each action of each state is, and permits those that are safe enough, as `meliora shield` does.
        The safety of an action is the best probability of the formula after it, for `Pmin` 1 minus it. In a game it holds
        against every strategy of the opponent.

        Args:
            property: `Pmin=? [ … ]` of a bad event or `Pmax=? [ … ]` of a good one, or a shield expression
                `<name, PreSafety, lambda=0.9> Pmax=? [ G !"crash" ]`, which has a threshold of its own.
            threshold: The least safety of a permitted action. Where no action reaches it, those with the best safety are
                permitted.
            relative: The threshold is a factor of the best safety of each state.
            limit: The maximum number of states.
            engine: "auto" (default): the first engine to know all states.
            scope, memory, order, timeout, progress: As in `explore`.

        Raises:
            InputError: The property is wrong or not supported.
            LimitError: A limit was reached."""
    def simulate_policy(self, policy: _Path | dict[str, Any] | list[Any], *, target: str | None=None, preferences: Preferences | _Path | None=None, runs: int=1000, steps: int=1000, seed: int=1, memory: int | str | None=None, timeout: _Timeout | None=None, progress: _Progress | None=None) -> PolicyReport:
        """Runs a policy from the initial states, as `meliora simulate --policy` does.

        Args:
            policy, target, preferences: As in `verify_policy`.
            runs: The number of runs.
            steps: A run is given up after this number of steps.
            seed: The same seed gives the same runs.
            memory, timeout, progress: As in `explore`.

        Returns:
            The report of `meliora simulate --policy --json`; its `runs` count those that kept the promise.

        Raises:
            InputError: The policy is invalid, or about another model."""
    def state(self, **values: _Value) -> dict[str, Any]:
        """Returns a state as a dictionary: the given values, and the initial values of all other
        variables.

        Raises:
            UsageError: An unknown variable, a value of the wrong type or out of range, or a
                variable without a value and without a single initial value."""
    @property
    def text(self) -> str:
        """The text."""
    @property
    def variables(self) -> dict[str, Variable]:
        """The variables by name, in the order of declaration."""
    def verify_policy(self, policy: _Path | dict[str, Any] | list[Any], *, target: str | None=None, preferences: Preferences | _Path | None=None, strong: bool=False, memory: int | str | None=None, timeout: _Timeout | None=None, progress: _Progress | None=None) -> PolicyReport:
        """Checks a policy without the code that finds policies, as `meliora verify` does: each state that it visits needs an
        enabled action, and it must keep its promise.

        Args:
            policy: What `ask(policy=True)` or `Strategy.policy` returns, or the path of a file that the command or a planner
                has written.
            target: The condition on states that a list of rules reaches; None for the goal of the planning problem.
            preferences: The preferences that a policy with memory is about, or the path of their file.
            strong: Each path of a list of rules must reach the target within a bound, too.
            memory, timeout, progress: As in `explore`.

        Returns:
            The report of `meliora verify --json`: `accepted`, and the `violation` of a policy that is refused.

        Raises:
            InputError: The policy is invalid, or about another model."""
    @property
    def warnings(self) -> list[str]:
        """The warnings about the text, each with its place, as text."""
    def with_coalition(self, *players: str | int) -> Model:
        """Returns the game in which we are these players, each given by its name or its number from 1 on; all
        others are the opponent. A preference file does not change this. Without it, we are the players
        that the preference file names, else the first player.

        Raises:
            InputError: The model is not a game, or has no such player."""

@final
class Play:
    """A run under a strategy, step by step: the caller, or an environment, says what happens.

    Must not be used by several threads at once."""
    def __reduce__(self) -> tuple[Any, ...]: ...
    def actions(self, which: _Which='permitted') -> list[str]:
        """Returns the actions of the present state, as `Strategy.actions`."""
    @property
    def ahead(self) -> _Rank:
        """The number of improvements that the strategy still aims for: an int, or `math.inf`; 0 at the
        end of the run."""
    def explain(self) -> Explanation:
        """Explains the present state, as `Strategy.explain`."""
    @property
    def improvements(self) -> int:
        """The number of improvements so far."""
    def mask(self, actions: Sequence[str] | None=None, which: _Which='permitted') -> NDArray[np.bool_]:
        """Returns the action mask of the present state, as `Strategy.mask`."""
    @property
    def over(self) -> bool:
        """True if no improvement is left and no objective is pursued, or if the pursued objective is
        achieved."""
    @property
    def pursues(self) -> str | None:
        """The objective that the run pursues, once no improvement is left, or several as "C and D"; None
        for strategies that achieve none."""
    @property
    def state(self) -> dict[str, Any]:
        """The present state."""
    def step(self, state: _State) -> bool:
        """Moves to the state that a step led to. Returns True if the step was an improvement.

        Raises:
            UsageError: The state is not in the scope, or no enabled action leads to it."""

@final
class Preferences:
    """Objectives with a partial order on them: a preference file, read without a model.

    `Model.check` checks that the formulas fit the model. Preferences are immutable values: they can
    be compared, pickled, and used by several threads.

    Args:
        objectives: The formula of each objective by its name, such as "F (x = 3)" or 'F "goal"'.
        prefer: Statements such as "D, E > A >= B", or pairs (better, worse).
        empty: The value of nothing, for states without an almost-sure objective: "bottom", "gain"
            or "incomparable".
        history: "state", "play", or None for the default of the formulas.
        require: safe formulas that no path may violate, such as `G !"pond"`.

    Raises:
        InputError: The preferences are invalid; each problem has its place in the generated text,
            see `text`."""
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __new__(cls, objectives: dict[str, str], prefer: Sequence[str | tuple[str, str]] | None=None, *, empty: _Empty='bottom', history: Literal['state', 'play'] | None=None, require: Sequence[str] | None=None) -> Preferences: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    def _repr_html_(self) -> str: ...
    def _repr_svg_(self) -> str: ...
    @staticmethod
    def _restore(name: str, text: str, implied: Sequence[tuple[str, str]]=...) -> Preferences: ...
    def compare(self, first: str, second: str) -> Literal['>', '<', '~'] | None:
        """Compares two objectives: `">"` if the first is strictly preferred, `"<"`, `"~"`, or None if
        they are incomparable."""
    @property
    def edges(self) -> list[tuple[str, str]]:
        """The order as pairs (better, worse), without those that follow from others: the lines of the Hasse
        diagram. Objectives that are equally good are in the same pairs."""
    @property
    def empty(self) -> _Empty:
        """The value of nothing, for states without an almost-sure objective: `"bottom"`, `"gain"` or
        `"incomparable"`."""
    @staticmethod
    def from_file(path: _Path, *, model: Model | None=None) -> Preferences:
        """Reads a preference file. With the `model` of a planning problem, the file may name the objectives that
        the problem declares; `Model.check` knows them anyway.

        Raises:
            InputError: The text is invalid; each problem has its place.
            OSError: The file cannot be read."""
    @staticmethod
    def from_string(text: str, *, name: str='preferences', model: Model | None=None) -> Preferences:
        """Reads the text of a preference file. Messages call the preferences `name`. `model` is as in `from_file`."""
    @property
    def history(self) -> Literal['state', 'play']:
        """The part of a path that counts: `"state"` (from the present state on) or `"play"` (the whole
        path)."""
    @property
    def name(self) -> str:
        """The name in messages: the path of the file."""
    @property
    def objectives(self) -> dict[str, str]:
        """The formula of each objective by its name, in the order of declaration."""
    @property
    def requirements(self) -> tuple[str, ...]:
        """The formulas of the requirements, which no path may violate."""
    @property
    def text(self) -> str:
        """The text."""
    def to_svg(self) -> str:
        """Draws the order as a Hasse diagram, the most preferred objectives on top.

        Returns:
            The text of an SVG file."""
    @property
    def warnings(self) -> list[str]:
        """The warnings about the preferences, as text."""

@final
class Progress:
    """The progress of a long call, as received by a `progress` callback."""
    @property
    def detail(self) -> str:
        """The part of the phase, in words; may be empty."""
    @property
    def elapsed(self) -> float:
        """Seconds since the call began."""
    @property
    def phase(self) -> str:
        """The phase: `"model"`, `"preferences"`, `"states"`, `"target"`, `"properties"`, `"counts"`, `"outcomes"`,
        `"improvement"`, `"sasi"`, `"spi"`, `"jointly"`, `"values"`, `"strategy"`, `"plays"`, `"shield"`,
        `"export"`, `"verify"` or `"picture"`."""

@final
class Reachability:
    """The qualitative regions of a target."""
    @property
    def holds(self) -> bool | None:
        """For a property, True if it is true in all initial states; None if it only asks for a number,
        or if the bounds of the number do not decide it."""
    @property
    def pmax_one(self) -> Region:
        """The states from which some strategy reaches the target with probability one."""
    @property
    def pmax_positive(self) -> Region:
        """The states from which some strategy reaches the target with positive probability."""
    @property
    def pmin_one(self) -> Region:
        """The states from which every strategy reaches the target with probability one."""
    @property
    def pmin_positive(self) -> Region:
        """The states from which every strategy reaches the target with positive probability."""
    @property
    def target(self) -> Region:
        """The target; for a temporal formula other than `F condition`, the states from which it can be
        satisfied from then on, almost surely."""
    @property
    def value(self) -> tuple[float, float] | None:
        """For a property about a number, bounds (lower, upper) of the probability or of the expected
        reward in every initial state; else None."""

@final
class Region:
    """A set of states, as an immutable value. Its size is that of its diagram, which does not depend
    on the number of states.

    `a & b`, `a | b`, `a - b`, `a ^ b` and `~a` return new regions. `a <= b` tests inclusion, and
    `state in a` tests membership of a dictionary with a value for every variable. `bool(a)` is
    False for the empty region. Iteration returns the states in the order of their values, first
    variable first. Operators combine regions of one exploration, also from different analyses.
    Regions of different explorations are never equal, and operators refuse them."""
    def __and__(self, other: Region, /) -> Region: ...
    def __rand__(self, other: Region, /) -> Region: ...
    def __bool__(self) -> bool: ...
    def __contains__(self, state: _State, /) -> bool: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ge__(self, other: Region, /) -> bool: ...
    def __gt__(self, other: Region, /) -> bool: ...
    def __invert__(self) -> Region:
        """Returns all other states of the scope."""
    def __iter__(self) -> RegionIterator: ...
    def __le__(self, other: Region, /) -> bool: ...
    def __lt__(self, other: Region, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __or__(self, other: Region, /) -> Region: ...
    def __ror__(self, other: Region, /) -> Region: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    def __sub__(self, other: Region, /) -> Region: ...
    def __rsub__(self, other: Region, /) -> Region: ...
    def __xor__(self, other: Region, /) -> Region: ...
    def __rxor__(self, other: Region, /) -> Region: ...
    def _picture(self) -> tuple[str | None, str, list[list[bool]]] | None:
        """Returns the variables with names that suggest rows and columns, and the projection of the
        region onto them by rows; None if there are none."""
    def _repr_html_(self) -> str: ...
    def count(self) -> int:
        """Returns the exact number of states. (`len` is limited to 2**63 - 1.)"""
    def sample(self, size: int=1, seed: int=0) -> list[dict[str, Any]]:
        """Draws `size` distinct states uniformly at random.

        Equal seeds draw the same states with the same engine and order of bits.

        Raises:
            UsageError: The region has fewer states."""
    def states(self, limit: int=1000) -> list[dict[str, Any]]:
        """Returns up to `limit` states as dictionaries, in the order of their values, first variable
        first."""
    def to_dd(self, manager: Any | None=None) -> Any:
        """Returns the region as a function of the package `dd`, over variables named by bits: `x.2`
        for bit 2 of x.

        Args:
            manager: A BDD manager of `dd`, to which missing bits are added; None for a new one of
                `dd.autoref`. The function's `bdd` is the manager.

        Raises:
            UsageError: The region belongs to the explicit engine, which has no diagrams."""
    def to_dddmp(self) -> str:
        """Returns the diagram of the region in DDDMP 2.0 text, as CUDD and `dd` read it, over the
        names of the bits."""
    def to_dot(self) -> str:
        """Returns a picture of the region's diagram in the language DOT."""
    def to_numpy(self, row: str | None, column: str, where: _State | None=None) -> NDArray[np.bool_]:
        """Returns the projection of the region onto one or two integer variables. The result is a
        Boolean array of shape (rows, columns), or (columns,) if `row` is None, from the smallest
        values on. A cell is True if the region has a state there in which the variables of `where`
        have their values; all other variables are free.

        The symbolic engine does not enumerate states for this. Needs NumPy."""
    def where(self, **values: _Value) -> Region:
        """Returns the states in which some variables have these values: `region.where(b=8, d=True)`."""

@final
class RegionIterator:
    """An iterator over the states of a region."""
    def __iter__(self) -> RegionIterator: ...
    def __next__(self) -> dict[str, Any]: ...

@final
class Shield:
    """The permitted actions of all states, for an agent that acts step by step. A shield needs no
    model, and follows levels, references and monitors.

    Promise: where `secure` is True, no step that follows the shield ever weakens, from there on,
    whatever the environment does, as long as it behaves as the model says. While `ahead` is
    greater than 0, the permitted actions are those of the permissive strategy of the level: for
    "sasi", an agent that takes each of them again and again improves almost surely. Where `secure` is
    False, the permitted actions are those of the strategy or those that the safety mode keeps; if there
    are none, those that keep the requirements, and all in an unsafe state. An action is permitted only
    if all choices with its label are, so the promise holds for each of these. Steps are compared as the
    safety mode says: with "action", with the state before the step; with "prefix", with the reference.

    The shield of a game keeps its promise against every opponent, even one that knows the shield and our
    next action. In a state of the opponent everything is permitted, and the episode follows its steps.

    An episode starts with `reset`, or with the first state. A call with another state than the
    present one is a step; a call with the present state is a step only after `correct`, or after
    `step`. A state is a dictionary, or a sequence of values in the order of the variables (without
    those of monitors), or a number if there is one variable; 0 and 1 are Booleans, too.

    A shield of `Model.shield` is one by value: an action is permitted if the best probability of a formula after it is
    within a threshold, or the best one. `values` has these probabilities, `secure` is True where the permitted
    actions reach the threshold, and `correct` replaces a forbidden action by the best one.

    A shield has one episode, and must not be used by several threads at once; `copy` is cheap."""
    def __copy__(self) -> Shield: ...
    def __deepcopy__(self, _memo: Any) -> Shield: ...
    def __len__(self) -> int:
        """The number of states with memory."""
    def __reduce__(self) -> tuple[Any, ...]:
        """Pickles the table and the position of the episode."""
    @staticmethod
    def _restore(table: bytes, node: int | None, taken: int | None) -> Shield: ...
    def achieved(self, state: _ShieldState) -> bool:
        """Returns True if the pursued objectives are achieved or, for those that no step achieves, kept from
        here on."""
    @property
    def actions(self) -> list[str]:
        """The names of the actions, in the order of masks: the labels of the model, then unlabelled
        commands, and `deadlock` if the model has deadlocks."""
    def ahead(self, state: _ShieldState) -> _Rank:
        """Returns the number of improvements that the shield still aims for in this state: an int, or
        `math.inf`."""
    def allowed(self, state: _ShieldState) -> tuple[str, ...]:
        """Returns the names of the permitted actions."""
    def copy(self) -> Shield:
        """Returns a shield with the same table and an episode of its own, for another environment. The
        episode is where this one is."""
    @overload
    def correct(self, state: _ShieldState, action: str) -> str:
        """Returns the action if it is permitted, else a permitted one that makes progress where there is
        one; a name for a name and a number for a number. The next state is the one that this action
        led to."""
    @overload
    def correct(self, state: _ShieldState, action: int) -> int: ...
    @property
    def kind(self) -> _StrategyKind | Literal['safety']:
        """`"sasi"`, `"spi"`, `"plan"`, `"achieve"`, or `"safety"` for a shield by value."""
    @staticmethod
    def load(folder: _Path) -> Shield:
        """Reads a shield from a folder. Checks the hash, and that the promises follow from the table:
        every step is known, permitted steps of secure states stay in secure states and weaken nothing,
        and permitted steps can make the improvements that are ahead. Nothing occurs twice.

        Raises:
            Error: The table has changed, or the promise does not follow from it.
            OSError: A file cannot be read."""
    def mask(self, state: _ShieldState) -> NDArray[np.bool_]:
        """Returns for each of `actions` if it is permitted: a Boolean array that cannot be written, or a
        list if NumPy is not installed.

        Raises:
            UsageError: The state does not follow the present one."""
    def masks(self, states: Iterable[_ShieldState] | NDArray[Any], memory: Sequence[int] | NDArray[Any] | None=None) -> NDArray[np.bool_]:
        """Returns masks of many states at once, without an episode, such as those of a replay buffer: a
        Boolean array with a row for each state. Needs NumPy.

        Args:
            states: A sequence of states, or an array with a row for each.
            memory: For each state, what `memory` returned when the episode was there. None if the
                permitted actions of these states do not depend on the episode.

        Raises:
            UsageError: The shield does not know a state; without `memory`, the permitted actions of a
                state depend on the episode; with it, a number is not one of its state."""
    def memory(self, state: _ShieldState) -> int:
        """Returns the number of the state with the memory of the episode, for `masks`.

        Raises:
            UsageError: The state does not follow the present one."""
    def most_preferred(self, state: _ShieldState) -> tuple[str, ...]:
        """Returns the most preferred objectives of the present state."""
    def pursues(self, state: _ShieldState) -> tuple[str, ...]:
        """Returns the objectives that the shield pursues in this state, together if there are several: with
        permitted actions they stay sure."""
    def reset(self, state: _ShieldState) -> None:
        """Starts an episode in a state, with fresh monitors.

        Raises:
            UsageError: No episode may start in this state: it is not in the scope."""
    @property
    def rule(self) -> dict[str, Any] | None:
        """The rule of a shield by value: its property, `maximises` for `Pmax`, the threshold, and whether that is `relative` to
        the best action; None for the shield of a strategy."""
    @property
    def safety(self) -> Literal['action', 'prefix']:
        """`"action"` or `"prefix"`."""
    def save(self, folder: _Path) -> None:
        """Writes the shield into a folder: its table, and a manifest with the hash of the table. An older
        shield there is replaced.

        Raises:
            OSError: The folder contains something else, or cannot be written."""
    def secure(self, state: _ShieldState) -> bool:
        """Returns True if no permitted step ever weakens from this state on."""
    def step(self, state: _ShieldState) -> None:
        """Moves to the state that a step led to, also if it is the present state.

        Raises:
            UsageError: No action leads there from the present state."""
    def values(self, state: _ShieldState) -> dict[str, tuple[float, float]]:
        """Returns the bounds of the value of each enabled action in this state, by name: the best probability of the formula
        after it.

        Raises:
            UsageError: The shield is not one by value."""

@final
class Simulation:
    """Random runs under a strategy. Arrays need NumPy."""
    def __len__(self) -> int:
        """The number of runs."""
    @property
    def achieved(self) -> dict[str, NDArray[np.int64]]:
        """For each objective that some run achieved, the number of steps of each run until then: integers
        of shape (runs,), -1 for runs that did not achieve it. Empty for strategies that achieve none."""
    @property
    def achieved_runs(self) -> int | None:
        """The number of runs that ended because they had achieved the objective that they pursued; None
        for strategies that achieve none."""
    @property
    def action_names(self) -> list[str]:
        """The names of the actions taken, indexed by the numbers in `actions`; empty if no run has a step: see
        `reason`."""
    @property
    def actions(self) -> NDArray[np.int64]:
        """The actions of each run by their indices in `action_names`: integers of shape (runs,
        longest), -1 after the end of a run."""
    @property
    def commits(self) -> list[SimulatePlaysCommits]:
        """The commitments of plans: dictionaries with the `objective` that the runs then pursued, the
        objectives that they gave up (`gives_up`), and the number of these `runs`. Empty if no run commits."""
    @property
    def entered_unsafe(self) -> int:
        """The number of runs that entered an unsafe state: 0, because no strategy leads there."""
    @property
    def improvements(self) -> dict[int, int]:
        """The number of runs for each number of improvements."""
    @property
    def improves(self) -> NDArray[np.bool_]:
        """The steps that are improvements: Booleans of shape (runs, longest), False after the end of a
        run."""
    @property
    def kept_runs(self) -> int | None:
        """The number of other runs that kept the objective that they pursued: no step achieves it, and
        the run can go on to satisfy it. None for strategies that achieve none."""
    @property
    def lengths(self) -> NDArray[np.int64]:
        """The number of steps of each run: integers of shape (runs,)."""
    @property
    def moves(self) -> dict[str, int]:
        """The number of steps of all runs that each player of a game chose; {} for other models."""
    @property
    def rank(self) -> _Rank:
        """The rank of the start state: an int, or `math.inf`."""
    @property
    def reason(self) -> str | None:
        """Why no run has a step, so that `actions` and `improves` are empty; None if some run has one."""
    @property
    def settled(self) -> int:
        """The number of runs that ended without a further improvement ahead; the others reached the
        limit on steps."""
    @property
    def states(self) -> NDArray[np.int64]:
        """The states of each run, its start first: integers of shape (runs, longest + 1, variables),
        Booleans as 0 and 1. A run that has ended stays in its last state."""
    @property
    def value(self) -> SimulatePlaysValue | None:
        """The value that the strategy attains, computed and measured: a dictionary with the number of
        `improvements`, bounds of their `probability` and `cost`, `measured_probability`,
        `measured_cost`, their `probability_interval` and `cost_interval` with 99 % `confidence`, and
        `agrees`. None with `choose="first"`."""
    @property
    def variables(self) -> list[str]:
        """The names of the variables, in the order of the last axis of `states`."""
    @property
    def weakened_start(self) -> int:
        """The number of runs with a state that weakens the start state."""
    @property
    def weakened_step(self) -> int:
        """The number of runs with a step that weakens the state before it. Steps after a commitment are
        not counted, here and below."""

@final
class Strategy:
    """A strategy: the strategies of all levels of one kind, a plan, or a strategy that achieves one
    objective.

    Actions are named by their labels. An unlabelled command is `module#k`. If a label has several
    choices in a state, the names distinguish them: `label(m1#2,m2#1)`."""
    def __reduce__(self) -> tuple[Any, ...]: ...
    def actions(self, state: _State, which: _Which='permitted') -> list[str]:
        """Returns the actions of a start state: the permitted ones, the one of the progress strategy,
        the one that the strategy chooses, or those that the safety mode keeps, even if they do not
        lead to an improvement. Empty where there is none, for example at rank 0 or where the opponent
        of a game chooses; `explain` has the reason for each action.

        Args:
            state: A dictionary with a value for every variable.
            which: "permitted", "progress", "chosen" or "kept".

        Raises:
            UsageError: The state is not in the scope."""
    def attains(self, state: _State) -> StrategyStatesAttains | None:
        """Returns the value of the strategy from a state: a dictionary with the number of
        `improvements` that it aims at, bounds of their `probability`, and bounds of the expected
        `cost` (None if they are not certain). None with `choose="first"`, and for unsafe states.

        Raises:
            UsageError: The values of the state were not computed; see `Analysis.strategy`."""
    @property
    def choose(self) -> _Choose:
        """`"first"`, `"likely"` or `"cheap"`: how the strategy chooses among the permitted actions."""
    def explain(self, state: _State) -> Explanation:
        """Explains every enabled action of a start state: if it is permitted, its successors, and the
        reason."""
    @property
    def kind(self) -> _StrategyKind:
        """`"sasi"`, `"spi"`, `"plan"` or `"achieve"`."""
    def mask(self, state: _State, actions: Sequence[str] | None=None, which: _Which='permitted') -> NDArray[np.bool_]:
        """Returns an action mask for reinforcement learning: a Boolean array with an entry for each of
        `actions`; None for the labels of the model in the order of `Model.actions`. Needs NumPy.
        An entry is True if some choice with the label is permitted; a shield wants all of them.

        This is for start states; use `play` to follow a run."""
    def play(self, state: _State) -> Play:
        """Starts a run in a state; it keeps the memory of the strategy."""
    def policy(self, *, picks: Literal['permissive', 'progress']='progress', everywhere: bool=False, limit: int=1000000, timeout: _Timeout | None=None, progress: _Progress | None=None) -> dict[str, Any]:
        """Returns a policy with memory, as `meliora strategy --policy` writes it: a dictionary that `Model.verify_policy`
        checks, and `json.dump` writes. Paths start in the initial states, where it promises what the kind of the
        strategy says.

        Args:
            picks: "progress" for one action in each state, "permissive" for all permitted ones.
            everywhere: Paths may start in all states of the scope from which the strategy does something sure.
            limit: Maximum number of states with memory.
            timeout, progress: As in `Model.explore`.

        Raises:
            UsageError: No policy keeps the promise from the initial states, or the safety mode is "transition".
            TooLarge: There are more than `limit` states with memory."""
    def shield(self, *, limit: int=1000000, timeout: _Timeout | None=None, progress: _Progress | None=None) -> Shield:
        """Returns a shield: a table of the permitted actions of all states of the scope, with the
        memory of the strategy. It needs no model, and answers in microseconds.

        Args:
            limit: Maximum number of states with memory.
            timeout, progress: As in `Model.explore`.

        Raises:
            UsageError: The strategy chooses by value, or the safety mode is "transition", which promises
                nothing about single steps; or choices with one label cannot be permitted together.
            TooLarge: There are more than `limit` states with memory."""
    def simulate(self, state: _State, *, runs: int=1000, steps: int=1000, seed: int=1, picks: Literal['permissive', 'progress']='progress', opponent: Literal['random', 'worst']='random', timeout: _Timeout | None=None, progress: _Progress | None=None) -> Simulation:
        """Simulates random runs from a state, as arrays. The same seed gives the same runs, with any
        engine, on any machine.

        Args:
            state: The start state of the runs.
            runs: Number of runs.
            steps: Maximum number of steps of a run.
            seed: An integer from 0.
            picks: "progress" takes the action that the strategy chooses; "permissive" draws
                uniformly from the permitted actions, which is for `choose="first"` only.
            opponent: How the opponent of a game chooses: "random" draws uniformly from its actions;
                "worst" keeps the next improvement, or the pursued objective, away longest.
            timeout, progress: As in `Model.explore`."""
    def successors(self, state: _State) -> _Successors:
        """Returns the successors of the enabled actions: for each action a list of pairs (probability,
        state)."""

@final
class Successor:
    """A successor of an action."""
    @property
    def change(self) -> Literal['improving', 'weakening', 'lateral']:
        """The kind of the step: `"improving"`, `"weakening"` or `"lateral"`."""
    @property
    def dropped(self) -> bool:
        """True if `safety="transition"` ignores this branch."""
    @property
    def gained(self) -> tuple[str, ...]:
        """The most preferred objectives of the successor that are preferred to one of the state (of the
        reference class under `prefix`)."""
    @property
    def goal(self) -> bool:
        """True if it is an improvement that the strategy counts, or achieves the pursued objective."""
    @property
    def lost(self) -> tuple[str, ...]:
        """The most preferred objectives of the state (of the reference class under `prefix`) that are
        preferred to one of the successor."""
    @property
    def most_preferred(self) -> tuple[str, ...]:
        """The most preferred objectives of this successor; empty if it is unsafe."""
    @property
    def probability(self) -> float:
        """The probability of this successor."""
    @property
    def rank(self) -> _Rank:
        """Its rank: an int, or `math.inf`; `math.nan` if it is unsafe."""
    @property
    def state(self) -> dict[str, Any]:
        """The state."""
    @property
    def unsafe(self) -> bool:
        """True if no strategy keeps the requirements from this successor."""

@final
class Variable:
    """A variable of a model."""
    @property
    def high(self) -> int:
        """The largest value."""
    @property
    def initial(self) -> _Value | None:
        """The value in the initial state; None if the initial states differ in it."""
    @property
    def low(self) -> int:
        """The smallest value."""
    @property
    def name(self) -> str:
        """Its name."""
    @property
    def type(self) -> Literal['int', 'bool']:
        """`"int"` or `"bool"`."""
    @property
    def values(self) -> list[str]:
        """The names of its values from `low` on, if they have names."""

@final
class Verdict:
    """The result of `verify`."""
    def __bool__(self) -> bool: ...
    @property
    def accepted(self) -> bool:
        """True if all conditions hold, and all regions are certified."""
    @property
    def checked(self) -> tuple[str, ...]:
        """The names of the regions that were checked."""
    @property
    def state(self) -> dict[str, Any] | None:
        """A state for which it does not hold; None if there is none."""
    @property
    def uncertified(self) -> tuple[str, ...]:
        """The regions that the certificate does not prove, because a limit ended the export."""
    @property
    def violation(self) -> str | None:
        """The first condition that does not hold; None if there is none."""

@final
class _Answers:
    """The answers to the properties of an instance."""
    def reason(self, names: Sequence[str]) -> str | None:
        """Returns why properties with these names have no answer; None if all have one."""

@final
class _Columns:
    """The columns of a sweep after those of the constants: of an analysis, or of properties with titles."""
    def __new__(cls, max_level: int | None, titles: Sequence[str], has_regions: bool) -> _Columns: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    def cells(self, found: Any, seconds: float, status: str) -> list[str]:
        """Returns the cells of an instance: its results after these seconds, as far as they are known, and its end."""

@final
class _Rows:
    """The rows of a sweep by the positions of their instances, also in a file: each is appended at once."""
    def __new__(cls, constants: Sequence[tuple[str, Sequence[str]]], columns: _Columns) -> _Rows:
        """Creates the rows for each combination of the values of constants."""
    def add(self, position: int, cells: Sequence[str]) -> None:
        """Adds a row: the cells after those of the constants."""
    def finish(self) -> None:
        """Sorts the rows of the file by their instances."""
    @property
    def header(self) -> list[str]:
        """The names of the columns."""
    def missing(self) -> list[int]:
        """Returns the positions of the instances that have no row."""
    def open(self, path: _Path, resume: bool, inputs: Sequence[_Path]) -> None:
        """Opens the file of the rows, with those that it has if it is resumed.

        Raises:
            UsageError: The file is an input, not a regular file, or belongs to another sweep.
            OSError: The file cannot be read or written."""
    def rows(self) -> list[tuple[int, list[str]]]:
        """Returns the rows in the order of their instances, each with its position."""

def verify(folder: _Path, model: Model, preferences: Preferences | _Path, *, timeout: _Timeout | None=None, progress: _Progress | None=None) -> Verdict:
    """Checks the dump in a folder against a model and preferences by one-step conditions, without the code
    that computes fixpoints.

    Args:
        folder: The folder of the dump.
        model: The model that the dump was made from, with the same constants.
        preferences: The preferences, or the path of their file.
        timeout, progress: As in `Model.explore`.

    Raises:
        Error: The dump is invalid, or has no certificate.
        OSError: A file cannot be read."""
