"""Several objectives in one path: where a strategy achieves them together, and that its runs do."""

import random

from reference.questions import jointly
from tester.program import Refused, key
from tester.promises import RUNS, STEPS, is_cosafe, opponent_of


def together(context):
    """For some cases, `--kind achieve` with two or three objectives."""
    if len(context.names) < 2 or not context.is_game and context.case.seed % 3 != 2:
        return
    draw, analysis = random.Random(context.case.seed), context.analysis
    members = draw.sample(range(len(context.names)), min(len(context.names), draw.choice([2, 2, 3])))
    asked = ("--kind", "achieve", "--objective", ",".join(context.names[i] for i in members))
    try:
        answers = context.strategy(*asked)
    except Refused as refused:
        # `refusals` compares which objectives a game refuses; several marks that recur are refused together.
        context.same(
            f"refusal of {asked}", True, context.is_game and analysis.play and "is not supported" in str(refused)
        )
        return
    region = jointly(analysis, members)
    if region is None:
        return
    for name, entry in answers.items():
        state = context.relation.one(name)
        if state in analysis.mdp.unsafe:
            continue
        where = f"{asked} in {dict(name)}"
        context.same(f"pursues of {where}", state in region, entry["pursues"] is not None)
        permitted = {a["name"] for a in entry["actions"] if a.get("permitted")}
        staying = {c.name for c in analysis.mdp.choices[state] if c.successors <= region}
        if state in analysis.whole.theirs or state not in region:
            context.same(f"permitted of {where}", set(), permitted)
        elif entry["left"] and analysis.play:
            context.same(f"permitted stays sure of {where}", set(), permitted - staying)
    simulated(context, asked, region, members)


def simulated(context, asked, region, members):
    """Runs from a state where objectives are sure together achieve all of them."""
    options = ["--runs", RUNS, "--steps", STEPS, "--seed", context.case.seed]
    options += ["--opponent", opponent_of(context)] if context.is_game else []
    decided = not context.analysis.play or all(is_cosafe(context.analysis, i) for i in members)
    for play in context.program.about("simulate", *asked, *options)["plays"]:
        state = context.relation.one(key(play["state"]))
        if state in region and decided and not context.is_rare():
            context.same(f"runs of {asked} that achieve all from {play['state']}", RUNS, play["achieved_runs"])


ALL = {"together": together}
