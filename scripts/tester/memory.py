"""Policies with memory: `strategy --policy` writes, `verify` accepts and `simulate` runs them; lies are refused."""

import copy
import json
import random

from reference.memory import keeps
from reference.questions import jointly

MOST_NODES, LIES, RUNS, STEPS = 400, 8, 30, 2000
KINDS = ("sasi", "spi", "plan", "achieve")


def memory(context):
    """A policy of a drawn kind, and some lies about it."""
    draw, program = random.Random(f"memory {context.case.seed}"), context.program
    kind, names = draw.choice(KINDS), context.names
    named = kind == "achieve" or kind == "plan" and draw.random() < 0.5
    objective = ",".join(draw.sample(names, min(len(names), draw.choice((1, 1, 2)) if kind == "achieve" else 1)))
    file = program.folder / "memory.json"
    asked = ["--kind", kind, *(["--objective", objective] if named else []), "--policy", file]
    asked += ["--all"] if draw.random() < 0.5 else []
    asked += ["--scheduler", draw.choice(("progress", "permissive"))]
    known = ["scope", "safety", "threads", "coalition", "engine"]
    status, out, errors = program.run("strategy", program.model, program.prefs, *program.settings(*known), *asked)
    expected = exists(context, kind, objective.split(","))
    refused = "is not supported" in errors
    if refused or context.case.settings["safety"] == "transition":
        context.same("refusal", True, status != 0 and (refused or "--safety transition" in errors))
        return
    if expected is None:
        return
    if not context.same("a policy is written", expected, file.exists() and status == 0) or not expected:
        return
    honest = json.loads(file.read_text())
    if len(honest["nodes"]) > MOST_NODES:
        return
    context.case.features.add(f"a policy of {kind}")
    judge(context, file, honest, "honest policy", True)
    if not context.is_rare():
        simulated(context, file, honest)
    for _ in range(LIES):
        told = copy.deepcopy(honest)
        what = draw.choice(CHANGES)(told, draw, names)
        if told != honest:
            file.write_text(json.dumps(told))
            judge(context, file, told, what, False)


def exists(context, kind, objectives):
    """Whether a policy of a kind can be written: its initial states are safe, and the objectives are sure in them."""
    analysis = context.analysis
    sure = set(analysis.whole.states)
    if kind == "achieve":
        numbers = [context.names.index(name) for name in objectives]
        sure = analysis.sure[numbers[0]] if len(numbers) == 1 else jointly(analysis, numbers)
    return None if sure is None else set(analysis.whole.initial) <= sure - analysis.mdp.unsafe


def judge(context, file, told, what, is_honest):
    """Compares the verdict about a file. Accepted files must be true, and written files accepted."""
    program, asked = context.program, ["verify", file, context.program.model, context.program.prefs]
    status, out, errors = program.run(*asked, *program.settings("coalition"))
    lie = keeps(told, context.analysis, context.relation.of)
    if is_honest:
        context.same(f"truth of the {what}", "", lie)
        context.same(f"verdict of the {what}", 0, status if status == 0 else (out + errors)[-700:])
        return
    context.case.features.add("an accepted change" if status == 0 else "a refused lie")
    context.same(f"status of the {what}", True, status in (0, 1, 3))
    if lie:
        context.same(f"verdict of the {what}: {lie}, {json.dumps(told)}", True, status in (1, 3))


def simulated(context, file, told):
    """Runs weaken nothing, and those of sure promises keep them, or are given up."""
    options = ["--policy", file, "--runs", RUNS, "--steps", STEPS, "--seed", context.case.seed]
    known = context.program.settings("coalition")
    report = context.program.ask("simulate", context.program.model, context.program.prefs, *known, *options)
    runs = report["runs"]
    context.same("runs that weaken", 0, runs["done"]["weakened"])
    if told["promise"]["kind"] != "spi":
        context.same("runs that keep the promise, or are given up", True, runs["reached"] + runs["given_up"] >= RUNS)


def a_node(told, draw):
    return draw.choice(told["nodes"])


def an_action(told, draw):
    nodes = [node for node in told["nodes"] if node["actions"]]
    return draw.choice(draw.choice(nodes)["actions"]) if nodes else {"next": [0]}


def other_action(told, draw, names):
    every = sorted({a["action"] for node in told["nodes"] for a in node["actions"]})
    if every:
        an_action(told, draw)["action"] = draw.choice(every)
    return "policy with another action"


def moved_actions(told, draw, names):
    nodes = draw.sample(told["nodes"], min(2, len(told["nodes"])))
    nodes[0]["actions"] = copy.deepcopy(nodes[-1]["actions"])
    return "policy with the actions of another node"


def fewer_actions(told, draw, names):
    node = a_node(told, draw)
    node["actions"] = draw.sample(node["actions"], draw.randrange(len(node["actions"]) + 1))
    return "policy with fewer actions"


def without_node(told, draw, names):
    at = draw.randrange(len(told["nodes"]))
    told["nodes"].pop(at)
    for node in told["nodes"]:
        for action in node["actions"]:
            action["next"] = [to - (to > at) for to in action["next"] if to != at]
    return "policy without a node"


def other_memory(told, draw, names):
    action = an_action(told, draw)
    at = draw.randrange(len(action["next"]))
    state = told["nodes"][action["next"][at]]["state"]
    same = [n for n, node in enumerate(told["nodes"]) if node["state"] == state]
    action["next"][at] = draw.choice(same if draw.random() < 0.7 else range(len(told["nodes"])))
    return "policy with another memory after an action"


def other_kind(told, draw, names):
    told["promise"]["kind"] = draw.choice(KINDS)
    return "policy of another kind"


def other_safety(told, draw, names):
    told["promise"]["safety"] = draw.choice(("prefix", "action", "transition"))
    return "policy of another safety"


def other_objective(told, draw, names):
    to = draw.choice(names)
    told["promise"]["objectives"] = [to]
    for node in told["nodes"] if draw.random() < 0.7 else ():
        if "pursues" in node:
            node["pursues"] = [to]
    return "policy of another objective"


def other_aim(told, draw, names):
    a_node(told, draw)["pursues"] = draw.sample(names, 1)
    return "policy with another pursuit"


def more_ahead(told, draw, names):
    for node in told["nodes"] if draw.random() < 0.5 else [a_node(told, draw)]:
        node["ahead"] = draw.choice((1, 2, "unbounded"))
    return "policy that promises more"


def other_class(told, draw, names):
    a_node(told, draw)["most_preferred"] = draw.sample(names, draw.randrange(len(names) + 1))
    return "policy with another class"


def other_reference(told, draw, names):
    node = a_node(told, draw)
    node["reference"] = draw.choice(told["nodes"])["most_preferred"]
    return "policy that compares with another class"


def without_reference(told, draw, names):
    for node in told["nodes"]:
        node.pop("reference", None)
    return "policy that compares with each state"


def committed(told, draw, names):
    for node in told["nodes"] if draw.random() < 0.5 else [a_node(told, draw)]:
        node["commits"] = True
    return "policy that commits"


def fewer_starts(told, draw, names):
    told["starts"] = draw.randrange(1, len(told["nodes"]) + 1)
    return "policy with other starts"


CHANGES = (
    *(other_action, moved_actions, fewer_actions, without_node, other_memory, other_kind, other_safety),
    *(other_objective, other_aim, more_ahead, other_class, other_reference, without_reference, committed, fewer_starts),
)
ALL = {"memory": memory}
