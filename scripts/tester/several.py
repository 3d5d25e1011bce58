"""Two objectives at once, `multi(…)`, on every mdp, under both engines."""

import random
from fractions import Fraction

from reference.model import explore
from reference.several import Infinite, Several, TooLarge
from tester.nested import compare

MOST_STATES = 30
AMOUNT = 3


def condition(context, draw):
    variable = draw.choice(context.source.variables)
    if variable.kind == "bool":
        return variable.name
    return f"{variable.name} {draw.choice(['=', '<=', '!='])} {draw.randint(variable.low, variable.high)}"


def objective(context, draw, mdp, is_bounded):
    """An objective with its text."""
    optimum, structures = draw.choice(["max", "min"]), list(context.source.rewards)
    kind = draw.choice("FG" + "RRR" * bool(structures))
    bound = Fraction(draw.randint(0, 8), 8) if kind != "R" else Fraction(draw.randint(0, 12), 2)
    end = f"{'>=' if optimum == 'max' else '<='}{float(bound)}" if is_bounded else f"{optimum}=?"
    text = condition(context, draw)
    if kind != "R":
        return (kind, optimum, mdp.where(text), bound), f"P{end} [ {kind} ({text}) ]"
    structure, is_total = draw.choice(structures), draw.random() < 0.3
    inside = "C" if is_total else f"F ({text})"
    return (kind, optimum, (structure, None if is_total else mdp.where(text)), bound), f'R{{"{structure}"}}{end} [ {inside} ]'


def several(context):
    """Verdicts and best values of two objectives are those over the means of pure strategies."""
    if context.is_rare() or context.is_game or context.case.kind == "dtmc":
        return
    mdp = explore(context.source, context.case.settings["scope"], 3000)
    if len(mdp.values) > MOST_STATES:
        return
    draw, expected = random.Random(context.case.seed), []
    for at in range(AMOUNT):
        asks_for_number = at % 2 == 0
        first, one = objective(context, draw, mdp, not asks_for_number)
        second, other = objective(context, draw, mdp, True)
        try:
            all_of = [Several(mdp, [first, second], start) for start in mdp.initial]
            answers = [own.best() if asks_for_number else own.achievable() for own in all_of]
        except (TooLarge, Infinite):
            continue
        answer = all(answers) if not asks_for_number else None if None in answers else answers
        expected.append((f"multi({one}, {other})", answer))
    if not expected:
        return
    file = context.program.folder / "several.props"
    file.write_text("".join(f"{written};\n" for written, _ in expected))
    context.case.features.add("several objectives")
    for engine in ("explicit", "symbolic"):
        options = ["--engine", engine, *context.program.settings("scope", "threads")]
        report = context.program.ask(
            "reach", context.program.model, "--properties", file, *options, allowed=(0, 1, 3)
        )
        for (written, answer), entry in zip(expected, report["properties"]):
            reason = entry.get("reason") or ""
            if "rewards that end" in reason:  # an end component may gain and cost
                continue
            if answer is None:
                context.same(f"{written} ({engine})", True, "no strategy satisfies the bounds" in reason)
            else:
                compare(context, f"{written} ({engine})", answer, entry)


ALL = {"several": several}
