"""Strategies of single operators: whoever follows the file of `reach --policy` attains the answer, against every
opponent. `verify` accepts the file, and refuses it after changes that make it false."""

import copy
import json
import random
from fractions import Fraction

from reference.games import LeftOut
from reference.model import explore
from reference.nested import Nested, TooLarge
from reference.prism import Variable
from tester.nested import MOST_STATES, Draw, Text, compare
from tester.program import Refused, key

AMOUNT, MOST_PAIRS = 3, 3000
CLOSE = Fraction(2, 10**6)
ENDED = "ended"


class Followed:
    """The nodes of a file as a program, whose states are those of the model with the number of the node."""

    def __init__(self, context, strategy):
        self.source, self.players, self.rewards = context.source, context.source.players, context.source.rewards
        self.variables = [*context.source.variables, Variable("node", "int", 0, len(strategy["nodes"]) - 1, 0)]
        states = {key(context.source.named(values)): values for values in context.source.all_states()}
        self.nodes = [(*states[key(node["state"])], at) for at, node in enumerate(strategy["nodes"])]
        self.starts, self.actions = strategy.get("starts", 1), [node["actions"] for node in strategy["nodes"]]

    def initial_states(self):
        return self.nodes[: self.starts]

    def choices(self, state):
        """The choices of the model that a node takes; a node without any ends, and nothing is earned there."""
        known = self.source.choices(state[:-1]) or [("deadlock", [None], {state[:-1]: Fraction(1)})]
        found = []
        for action in self.actions[state[-1]]:
            name, labels, to = known[action["position"]]
            after = {self.nodes[s["node"]]: s["probability"] for s in action["successors"]}
            known_to = {node[:-1]: node for node in after}
            is_same = name == action["action"] and known_to.keys() == to.keys() and len(after) == len(to)
            if not is_same or any(abs(after[known_to[t]] - p) > CLOSE for t, p in to.items()):
                raise ValueError(f"{action} of {state} is not {known[action['position']]}")
            found.append((name, labels, {known_to[t]: p for t, p in to.items()}))
        return found or [(ENDED, [ENDED], {state: Fraction(1)})]

    def reward(self, structure, state, labels):
        return Fraction(0) if labels == [ENDED] else self.source.reward(structure, state[:-1], labels)

    def movers(self, state):
        return self.source.movers(state[:-1])

    def compile(self, text):
        holds = self.source.compile(text)
        return lambda state: holds(state[: len(self.source.variables)])


def attained(context):
    """Some operators whose strategies are written."""
    if context.is_rare() or context.case.kind == "dtmc":
        return
    mdp = explore(context.source, "reachable", 3000)
    if len(mdp.values) > MOST_STATES:
        return
    rng = random.Random(f"attained {context.case.seed}")
    draw, text = Draw(context, rng), Text(context)
    for _ in range(AMOUNT):
        operator = operator_of(draw)
        try:
            values = [Nested(mdp).operator(operator)[s] for s in mdp.initial] if is_known(operator) else None
            followed_by(context, rng, operator, text.operator(operator), values)
        except (TooLarge, OverflowError, LeftOut):
            continue


def operator_of(draw):
    """A probability or reward of paths, over conditions without operators."""
    kind = draw.rng.randrange(3)
    if kind == 2 and not draw.game and draw.structures:
        accumulated = (draw.rng.choice("SC"), None)
        return ("R", None, draw.rng.choice(["max", "min"]), draw.rng.choice(draw.structures), accumulated)
    return draw.reward(1, True) if kind and draw.structures else draw.likely(1)


def is_known(operator):
    """Whether the reference has the value of an operator about all strategies, not only that of one."""
    return operator[0] == "P" or operator[-1][1] is not None


def followed_by(context, rng, operator, written, values):
    """Compares the answer, the value of its strategy, and verdicts about the file."""
    program, file = context.program, context.program.folder / "attained.json"
    file.unlink(missing_ok=True)
    options = ["--policy", file, *program.settings("threads")]
    try:
        report = program.ask("reach", program.model, "--property", written, *options, allowed=(0, 1))
    except Refused as refused:
        if "is not supported" not in str(refused):
            raise
        return
    (answer,) = report["properties"]
    if values:
        compare(context, written, values, answer)
    if not file.exists():  # no strategy has a finite value
        context.same(f"value of {written} without a file", ("min", "inf"), (operator[2], answer["value"]["upper"]))
        return
    context.case.features.add("a strategy of a property")
    document = json.loads(file.read_text())
    found = value_of(context, operator, document["strategies"][0])
    compare(context, f"the strategy of {written}", found, answer)
    status, out, errors = program.run("verify", file, program.model)
    context.same(f"verify of {written}", (0, ""), (status, "" if status == 0 else (out + errors)[-500:]))
    for change in rng.sample(CHANGES, 2):
        changed = copy.deepcopy(document)
        change(context, rng, changed["strategies"][0], operator[2])
        if changed == document or change is other_choice and not is_worse(context, operator, changed, found):
            continue
        file.write_text(json.dumps(changed))
        status, out, errors = program.run("verify", file, program.model)
        context.same(f"status of {change.__name__} of {written}: {json.dumps(changed)}", True, status in (1, 3))


def value_of(context, operator, strategy):
    """The value of a strategy in its starts, against every strategy of the others. These have the only choices left."""
    followed = Followed(context, strategy)
    kind, ours, optimum, *rest = operator
    if kind == "R" and ours is not None and rest[1][0] == "F":
        optimum = {"max": "min", "min": "max"}[optimum]
    mdp = explore(followed, "reachable", MOST_PAIRS)
    values = Nested(mdp).operator((kind, ours, optimum, *rest))
    return [values[s] for s in mdp.initial]


def is_worse(context, operator, changed, before):
    """Whether the changed strategy has a value that its file does not promise."""
    found, best = value_of(context, operator, changed["strategies"][0]), (min if operator[2] == "max" else max)
    return best(found) != best(before) and best(best(found), best(before)) == best(found)


def claim(context, rng, strategy, optimum):
    claimed = strategy["values"][0]
    if claimed != "infinity":
        better = Fraction(1, 1000) * (1 if optimum == "max" else -1)
        strategy["values"][0] = str(Fraction(str(claimed)) + better)


def acting(rng, strategy):
    return rng.choice([node for node in strategy["nodes"] if node["actions"]] or [{"actions": [], "state": {}}])


def other_probability(context, rng, strategy, optimum):
    for action in acting(rng, strategy)["actions"][:1]:
        action["successors"][0]["probability"] /= 2


def unvisited(context, rng, strategy, optimum):
    strategy["nodes"].append(copy.deepcopy(strategy["nodes"][0]))


def other_choice(context, rng, strategy, optimum):
    """Another choice of the model in a node, with the same memory afterwards."""
    node = acting(rng, strategy)
    if node.get("other") or node.get("memory") or node.get("steps") or not node["actions"]:
        return
    place = {key(n["state"]): at for at, n in enumerate(strategy["nodes"]) if not n.get("memory", n.get("steps"))}
    source = context.source
    (state,) = (s for s in source.all_states() if source.named(s) == node["state"])
    choices = source.choices(state)
    position = rng.randrange(len(choices)) if choices else 0
    for name, _, to in choices[position : position + 1]:
        after = [(place.get(key(source.named(t))), float(p)) for t, p in to.items()]
        if all(at is not None for at, _ in after):
            successors = [{"node": at, "probability": p} for at, p in after]
            node["actions"] = [{"action": name, "position": position, "successors": successors}]


CHANGES = (claim, other_probability, unvisited, other_choice)
ALL = {"attained": attained}
