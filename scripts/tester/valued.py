"""Whole strategies that choose by value: whoever follows the table attains the value, against every opponent."""

import math
from fractions import Fraction

from reference.equations import Action, greatest, smallest
from reference.model import Choice, Mdp
from reference.questions import into, rewards
from tester.checks import is_near
from tester.context import LEVELS
from tester.program import key

GIVEN_UP = None, 1  # no node, and an improvement that is never made

def valued(context):
    """For some cases, the probability of all improvements that are aimed at, or their cost."""
    if context.is_rare() or context.case.seed % 3:
        return
    for choose, kind, tables in (("likely", "spi", context.probabilities), ("cheap", "sasi", context.costs)):
        options = ["--kind", kind, "--choose", choose, "--levels", LEVELS, "--all"]
        options += context.program.settings("reward") if choose == "cheap" else []
        nodes = context.program.about("strategy", *options)["states"]
        values = values_of(context, choose, nodes)
        for node, entry in enumerate(nodes):
            state = context.relation.one(key(entry["state"]))
            if entry["start"] and state not in context.analysis.mdp.unsafe:
                aimed_at(context, f"{choose} from {entry['state']}", state, tables, (entry["level"], values[node]))


def aimed_at(context, where, state, tables, found):
    """What a strategy that begins in a state aims at, and the value that it attains."""
    own = context.quantities.own(state)
    able = [k for k, (table, _) in enumerate(tables, 1) if table.get(own) or tables is context.costs and own in table]
    level, value = found
    if context.same(f"aim of {where}", max(able, default=0), level) and able:
        expected = tables[level - 1][0][own]
        fits = value != math.inf and is_near(value, expected)
        context.same(f"value of {where}", "" if fits else expected, "" if fits else value)


def values_of(context, choose, nodes):
    """The value from each node on: of as many improvements as its level says."""
    pairs = [(node, entry["level"]) for node, entry in enumerate(nodes)]
    known, moves = {pair: at for at, pair in enumerate(pairs)}, []
    for at, (node, left) in enumerate(pairs):  # grows while we walk it
        own = []
        for choice, after in steps_of(context, nodes[node]) if node is not None and left else []:
            to = {}
            for p, follower, improves in after:
                pair = GIVEN_UP if follower is None else (follower, left - improves)
                if pair not in known:
                    known[pair] = len(pairs)
                    pairs.append(pair)
                to[known[pair]] = to.get(known[pair], 0) + p
            own.append(Choice(choice.name, to, choice.costs))
        stays = Choice("stay", {at: Fraction(1)}, dict.fromkeys(("steps", *context.source.rewards), Fraction(0)))
        moves.append(own or [stays])
    chain = Mdp(context.source, pairs, moves, [], set())
    reached = {at for at, (_, left) in enumerate(pairs) if left == 0}
    if context.is_game:
        return worst_of(moves, reached, context.case.settings["reward"] if choose == "cheap" else None)
    if choose == "cheap":
        return rewards(chain, reached, context.case.settings["reward"])[1]
    return into(chain, reached, {at for at, own in enumerate(moves) if own[0].name == "stay"} - reached)


def worst_of(moves, reached, reward):
    """The least probability to reach some nodes, or the greatest reward until then, over the choices of the opponent."""
    actions = {}
    for at, own in enumerate(moves):
        actions[at] = []
        for choice in own if at not in reached and own[0].name != "stay" else ():
            gain = choice.costs[reward] if reward else sum(p for to, p in choice.to.items() if to in reached)
            edges = [(p, to) for to, p in choice.to.items() if to not in reached]
            actions[at].append(Action(gain, edges, len(edges) < len(choice.to)))
    if reward is None:
        return smallest(actions)
    # The nodes that surely reach the others, whatever the opponent does.
    ends, grows = set(), True
    while grows:
        new = {at for at, own in actions.items() if own and all(a.ends or any(to in ends for _, to in a.edges) for a in own)}
        grows, ends = new | reached != ends, new | reached
    sure = set(ends)
    while True:
        left = {at for at in sure if at in reached or all(to in sure for a in actions[at] for _, to in a.edges)}
        if left == sure:
            break
        sure = left
    return {**dict.fromkeys(actions, math.inf), **greatest({at: actions[at] for at in sure})}


def steps_of(context, entry):
    """The choice that a strategy takes in a node, of the opponent all, and for each successor its probability in the
    reference, the node after it, None for one that is given up, and whether the step improves."""
    relation, whole = context.relation, context.analysis.whole
    state, found = relation.one(key(entry["state"])), []
    names = [a["name"] for a in entry["actions"]] if state in whole.theirs else [entry["chosen_action"]]
    for action in (a for a in entry["actions"] if a["name"] in names):
        (choice,) = (c for c in whole.choices[state] if c.name == action["name"])
        after = {whole.plain(relation.one(key(s["state"]))): s for s in action["successors"]}
        steps = ((p, after[whole.plain(to)]) for to, p in choice.to.items())
        found.append((choice, [(p, s.get("node"), s["goal"]) for p, s in steps]))
    return found


ALL = {"valued": valued}
