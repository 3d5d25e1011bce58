"""Games in the Python package: players, refusals, and environments of Gymnasium, in which the opponent moves."""

import importlib.util
import random

from tester.program import key
from tester.shields import label, shares_labels

EPISODES, TURNS, PATIENCE = 3, 10, 6


def game(context, meliora, model, analysis):
    """Who chooses, what a game does not have, and episodes with and without a shield."""
    space, draw = analysis.exploration, random.Random(context.case.seed)
    owners(context, space)
    refused(context, meliora, model, analysis)
    if importlib.util.find_spec("gymnasium") is None:
        return
    from meliora.gym import ModelEnv, ShieldedEnv

    goal = space.where(f"x={draw.randint(0, context.case.size)}") if draw.random() < 0.5 else None
    labels = {label(c.name) for own in context.analysis.whole.choices for c in own}
    more = {"goal": goal, "opponent": draw.choice(["random", opponent(context)]), "patience": PATIENCE}
    for _ in range(EPISODES):
        episode(context, ModelEnv(space, actions=sorted(labels), **more), draw, goal)
    kind = draw.choice(["sasi", "spi"])
    if not shares_labels(context):
        shield = analysis.strategy(kind).shield()
        inside = ModelEnv(space, actions=shield.actions, **more)
        for _ in range(EPISODES):
            shielded(context, (ShieldedEnv(inside, shield), inside, shield), draw, goal)


def owners(context, space):
    """The players' states, the owner of each state, and its successors."""
    relation, whole, names = context.relation, context.analysis.whole, [*context.source.players]
    of = {name: {n for n in relation.of if whole.owners[relation.one(n)] == at} for at, name in enumerate(names)}
    listed = {name: {key(state) for state in region.states(4000)} for name, region in space.players.items()}
    context.same("players of the exploration", of, listed)
    theirs = {key(state) for state in space.theirs.states(4000)}
    context.same("theirs", {n for n in relation.of if relation.one(n) in whole.theirs}, theirs)
    for name, entry in context.strategy("--kind", "sasi").items():
        at = whole.owners[relation.one(name)]
        context.same(f"owner of {dict(name)}", None if at is None else names[at], space.owner(dict(name)))
        expected = {
            a["name"]: sorted((key(s["state"]), s["probability"]) for s in a["successors"]) for a in entry["actions"]
        }
        got = {a: sorted((key(to), p) for p, to in found) for a, found in space.successors(dict(name)).items()}
        context.same(f"successors of {dict(name)}", expected, got)


def refused(context, meliora, model, analysis):
    """What a game does not have is refused by name."""
    asked = {
        "jointly": analysis.jointly,
        "transition": lambda: model.check(analysis.preferences, safety="transition"),
    }
    for what, ask in asked.items():
        try:
            said = f"no error: {ask()}"
        except (meliora.InputError, meliora.UsageError) as error:
            said = str(error)
        context.same(f"{what} is refused", "", "" if what in said and "of a game is not supported" in said else said)


def opponent(context):
    """An opponent that takes the last of its actions, and compares those that it is offered."""

    def last(state, actions):
        choices = context.analysis.whole.choices[context.relation.one(key(state))]
        context.same(f"actions of the opponent in {state}", {c.name for c in choices}, set(actions))
        return max(actions)

    return last


class Follower:
    """The reference's view of an episode."""

    def __init__(self, context, env, goal):
        self.context, self.env, self.goal, self.plain = context, env, goal, None
        self.whole, self.names = context.analysis.whole, [*context.source.players]

    def one(self, state):
        return self.context.relation.one(key(state))

    @property
    def state(self):
        return self.one(self.plain)

    def is_over(self):
        """Whether an episode ends in the present state."""
        return self.state in self.whole.deadlocks or self.goal is not None and self.plain in self.goal

    def enabled(self):
        """The choices by label that we have in the present state."""
        found = {}
        for choice in self.whole.choices[self.state] if not self.is_over() and not self.waits() else ():
            found.setdefault(label(choice.name), []).append(choice)
        return found

    def waits(self):
        return self.state in self.whole.theirs

    def moved(self, moves, action):
        """Follows an action of ours, None at the start, and the opponent's answers. Returns the states on the way."""
        context, way = self.context, [self.state]
        for number, (player, name, to) in enumerate(moves):
            at = self.whole.owners[self.state]
            ours = action is not None and number == 0
            where = f"move {name} in {self.plain}"
            context.same(f"player of {where}", None if at is None else self.names[at], player)
            context.same(f"turn of {where}", not ours, self.waits())
            context.same(f"label of {where}", True, not ours or label(name) == action)
            steps = context.relation.steps(key(self.plain), key(to))
            if not context.same(f"step of {where}", True, name in {choice.name for choice in steps}):
                return way
            self.plain = to
            way.append(self.state)
        return way

    def looked(self, observation, info, ended):
        """What the environment says of the present state: its values, the end, and the reward."""
        over, cut, reward = ended
        same, where = self.context.same, self.plain
        same(f"state {where}", where, info["state"])
        width = self.context.relation.width
        same(f"observation of {where}", [int(v) for v in list(where.values())[:width]], list(observation)[:width])
        entered = self.goal is not None and where in self.goal
        same(
            f"end in {where}",
            (self.is_over(), not self.is_over() and self.waits(), float(entered)),
            (over, cut, reward),
        )


def episode(context, env, draw, goal):
    """An episode without a shield: we take actions that have one choice."""
    follower = Follower(context, env, goal)
    observation, info = started(context, follower, env, draw)
    for _ in range(TURNS):
        enabled = follower.enabled()
        context.same(f"mask in {follower.plain}", [a in enabled for a in env.actions], info["action_mask"].tolist())
        alone = sorted(name for name, own in enabled.items() if len(own) == 1)
        if not alone:
            return
        action = draw.choice(alone)
        observation, reward, over, cut, info = env.step(env.actions.index(action))
        follower.moved(info["moves"], action)
        follower.looked(observation, info, (over, cut, reward))
        if over or cut:
            return


def started(context, follower, env, draw):
    """Begins an episode in an initial state, where the opponent may move first."""
    start = dict(draw.choice(sorted(name for name in context.relation.of if is_initial(context, name))))
    follower.plain = start
    observation, info = env.reset(seed=draw.randrange(1000), options={"state": start})
    follower.moved(info["moves"], None)
    context.same(f"start in {start}", (start, follower.plain), (info["start"], info["state"]))
    return observation, info


def is_initial(context, name):
    return context.relation.one(name) in context.analysis.whole.initial


def shielded(context, environments, draw, goal):
    """An episode with a shield: it takes permitted actions, and nothing weakens once the shield is secure."""
    env, inside, shield = environments
    analysis, follower = context.analysis, Follower(context, inside, goal)
    observation, info = started(context, follower, env, draw)
    for _ in range(TURNS):
        if follower.is_over() or follower.waits():
            return
        where, secure, enabled = follower.plain, shield.secure(observation), follower.enabled()
        allowed = [name for name, may in zip(shield.actions, info["action_mask"]) if may]
        context.same(
            f"the shield permits enabled actions in {where}", True, bool(allowed) and enabled.keys() >= set(allowed)
        )
        asked = draw.choice(shield.actions)
        observation, reward, over, cut, info = env.step(shield.actions.index(asked))
        taken = label(info["moves"][0][1])
        context.same(
            f"action taken for {asked} in {where}", (True, taken != asked), (taken in allowed, info["corrected"])
        )
        context.same(f"{asked} in {where} is corrected", asked not in allowed, info["corrected"])
        way = follower.moved(info["moves"], taken)
        follower.looked(observation, info, (over, cut, reward))
        classes = [analysis.classes[state] for state in way]
        if secure and analysis.safety == "action":
            weak = [
                i for i, (old, new) in enumerate(zip(classes, classes[1:])) if analysis.preferences.weakens(old, new)
            ]
            context.same(f"steps that weaken from {where}", [], weak)
        context.same(
            f"most preferred in {follower.plain}", tuple(context.named(classes[-1])), shield.most_preferred(observation)
        )
