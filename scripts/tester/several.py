"""Two objectives at once, `multi(…)`, on every mdp, under both engines."""

import json
import math
import random
from fractions import Fraction

from reference.model import explore
from reference.several import Infinite, Several, TooLarge
from tester import mixed
from tester.nested import answered, compare
from tester.program import Refused, key

MOST_STATES = 30
AMOUNT = 3
CLOSE = Fraction(1, 10**6)


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
        if answer and len(all_of) == 1:
            mixes(context, all_of[0], expected[-1])
    if not expected:
        return
    file = context.program.folder / "several.props"
    file.write_text("".join(f"{written};\n" for written, _ in expected))
    context.case.features.add("several objectives")
    for what, answer, entry in answered(context, file, expected, (0, 1, 3)):
        reason = entry.get("reason") or ""
        if "rewards that end" in reason:  # an end component may gain and cost
            continue
        if answer is None:
            context.same(what, True, "no strategy satisfies the bounds" in reason)
        else:
            compare(context, what, answer, entry)


def mixes(context, known, question):
    """Each strategy of the file of `--policy` attains the values that it claims, and their mix the answer."""
    written, answer = question
    file = context.program.folder / "mix.json"
    file.unlink(missing_ok=True)
    options = ["--policy", file, *context.program.settings("scope", "threads", "engine")]
    try:
        context.program.ask("reach", context.program.model, "--property", written, *options, allowed=(0, 1))
    except Refused as error:
        if "rewards that end" not in str(error):
            raise
        return
    found = mixed.read(file.read_text())["strategies"] if file.exists() else []
    if answer in (True, [math.inf]) and not found:
        context.same(f"strategies of {written}", answer, [math.inf])
        return
    context.case.features.add("a mix of strategies" if len(found) > 1 else "one of several strategies")
    mdp, means = known.mdp, [0, 0]
    numbers = {key(context.source.named(values)): state for state, values in enumerate(mdp.values)}
    followed = []
    for strategy in found:
        nodes = [nodes_of(context, mdp, numbers, strategy["nodes"], node) for node in strategy["nodes"]]
        values = known.followed(nodes)
        followed.append((values, [state for state, _ in nodes]))
        for at, (value, claimed) in enumerate(zip(values, strategy["values"])):
            kept = known.sign(at) * value >= known.sign(at) * Fraction(claimed)
            context.same(f"value {at} of a strategy of {written}", "", "" if kept else f"{value} for {claimed}")
            means[at] += value * Fraction(strategy["share"])
    if found:
        from_file(context, file, written, means)
        mixed.changed(context, known, file, followed, answer is True)
    context.same(f"shares of {written}", 1, sum(Fraction(s["share"]) for s in found))
    bounds = [known.objectives[0][3] if answer is True else answer[0], known.objectives[1][3]]
    for at, (mean, bound) in enumerate(zip(means, bounds)):
        reached = known.sign(at) * mean >= known.sign(at) * bound - 2 * CLOSE
        context.same(f"mean {at} of the strategies of {written}", "", "" if reached else f"{mean} for {bound}")


def from_file(context, file, written, means):
    """`verify` accepts the file, but no greater claim; `simulate` measures what the mix claims."""
    program = context.program
    status, out, errors = program.run("verify", file, program.model, "--json")
    context.same(f"verify of {written}", (0, ""), (status, "" if status == 0 else (out + errors)[-500:]))
    runs = program.ask("simulate", program.model, "--policy", file, "--runs", "300")["runs"]
    for mean, own in zip(means, runs["objectives"]):
        if own["interval"]:
            low, high = own["interval"]
            near = 2 * low - high - 0.01 <= mean <= 2 * high - low + 0.01
            context.same(f"{own['objective']} in runs of {written}", "", "" if near else (float(mean), own))
    text = json.loads(file.read_text())
    for at, sign in enumerate((1 if "max=?" in o or ">=" in o.split("[")[0] else -1) for o in objectives_of(runs)):
        wrong = json.loads(json.dumps(text))
        claims = wrong["strategies"][0]["values"]
        claims[at] = str(Fraction(claims[at]) + sign * Fraction(1, 1000))
        other = file.with_name("wrong.json")
        other.write_text(json.dumps(wrong))
        status, out, _ = program.run("verify", other, program.model, "--json")
        context.same(f"verify of a false value {at} of {written}", (1, True), (status, "does not attain" in out))


def objectives_of(runs):
    return [own["objective"] for own in runs["objectives"]]


def nodes_of(context, mdp, numbers, nodes, node):
    """The state of a node, and its actions as choices of the reference."""
    state, actions = numbers[key(node["state"])], []
    for action in node["actions"]:
        to = {s["node"]: s["probability"] for s in action["successors"]}
        named = [c for c in mdp.choices[state] if c.name == action["action"]]
        after = {numbers[key(nodes[n]["state"])]: (n, p) for n, p in to.items()}
        same = [c for c in named if c.to.keys() == after.keys() and all(abs(c.to[t] - after[t][1]) < CLOSE for t in after)]
        if context.same(f"an action of {node['state']} is one of the model", True, bool(same)):
            actions.append((same[0], {after[t][0]: p for t, p in same[0].to.items()}))
    return state, actions


ALL = {"several": several}
