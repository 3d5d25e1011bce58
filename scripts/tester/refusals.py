"""What games do not have: each command, option and format refuses it by name, says what helps, and writes nothing."""

from reference.games import conditions_in_game
from reference.leaves import cases
from reference.strategies import is_recurrence
from reference.temporal import is_cosafe
from tester.program import Refused

# Arguments after the model and its preferences, the exit status, what the message names, and what helps.
OF_ONE_PLAYER = (
    (["export", "--format", "drn"], 3, "`--format drn`", "`--format umb`"),
    (["check", "--jointly"], 2, "`--jointly`", "the kind `achieve`"),
    (["check", "--safety", "transition"], 2, "`--safety transition`", "`action` and `prefix`"),
)


def refusals(context):
    """One of these for each game, and strategies and dumps of its objectives."""
    if not context.is_game:
        return
    program, seed = context.program, context.case.seed
    (command, *more), status, name, help_ = OF_ONE_PLAYER[seed % len(OF_ONE_PLAYER)]
    settings = ["coalition"] if "--safety" in more else ["coalition", "safety"]
    refused(context, (command, *program.settings(*settings), *more), status, (f"{name} of a game", help_))
    achieving(context)
    if context.analysis.play:
        refused(
            context, ("export", *program.settings("coalition")), 2, ("a dump of a game with temporal", "`--format umb`")
        )


def refused(context, asked, status, said):
    """A command ends with a status and an error that says some texts, and leaves no file."""
    program, (command, *more) = context.program, asked
    out = program.folder / "refused"
    more += ["--out", out] if command in ("export", "report") else []
    got, _, errors = program.run(command, program.model, program.prefs, *more, "--json")
    message = errors.replace('\\"', '"')
    context.same(f"refusal of {more}", (status, [], False), (got, [s for s in said if s not in message], out.exists()))


def achieving(context):
    """A strategy that achieves an objective is refused where the opponent may choose how it is satisfied, and a plan
    where that is so for some objective. A formula that has a simpler one for the same words may be answered."""
    formulas = dict(zip(context.names, context.analysis.formulas))
    may_choose = [name for name, formula in formulas.items() if is_chosen(context, formula)]
    named = context.names[context.case.seed % len(context.names)]
    for kind, options, wrong in (
        ("plan", (), may_choose),
        ("achieve", ("--objective", named), [named] if named in may_choose else []),
    ):
        try:
            context.strategy("--kind", kind, *options)
            said = ""
        except Refused as error:
            said = str(error)
        must = [name for name in wrong if not is_recurrence(context.analysis, conditions_in_game(formulas[name]))]
        fits = not must and not said or any(f"that achieves `{name}` is not supported" in said for name in wrong)
        context.same(f"refusal of {kind} {options}", ("", must), ("" if fits else said or "no error", must))
        context.same(f"help of {kind} {options}", True, not said or "without persistence, such as `F a`" in said)


def is_chosen(context, formula):
    """Whether an opponent with some state may choose how a formula is satisfied: it has persistence, or cases that
    differ in more than co-safe parts."""
    if not context.analysis.play or not context.analysis.whole.theirs:
        return False
    ways = cases(conditions_in_game(formula))
    rests = {frozenset(leaf for leaf in case if not (leaf[0] == "again" and is_cosafe(leaf[1]))) for case in ways}
    return any(kind == "finally" and not is_cosafe(g) for case in ways for kind, g in case) or len(rests) > 1


ALL = {"refusals": refusals}
