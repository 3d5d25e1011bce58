"""What plans and strategies that achieve an objective say in each state."""

from reference.equations import Action, against, greatest
from reference.strategies import pursued, pursuing, pursuit
from tester.promises import claims, done_in

OF_PURSUIT = ("pursues", "commits", "gives_up")


def pursues(context):
    """The objective that a plan takes, with and without a name, and the actions of plans and of `achieve`."""
    number = context.case.seed % len(context.names)
    name = ("--objective", context.names[number])
    for named, options in ((None, ()), (number, name)):
        for at_state, state, entry in safe_entries(context, "--kind", "plan", *options):
            planned_at(context, named, at_state, state, entry)
    for at_state, state, entry in safe_entries(context, "--kind", "achieve", *name):
        taken = (number, None) if state in context.analysis.sure[number] else None
        pursues_at(context, taken, at_state, state, entry)


def likeliest(context):
    """The probability to achieve an objective: to reach the states where it is sure, against an opponent if there is one."""
    if context.is_rare():
        return
    number, mdp = context.case.seed % len(context.names), context.analysis.mdp
    sure, actions = context.analysis.sure[number], {}
    for state, own in enumerate(mdp.choices):
        actions[state] = []
        for choice in own if state not in sure else ():
            now = sum(p for to, p in choice.to.items() if to in sure)
            actions[state].append(Action(now, [(p, to) for to, p in choice.to.items() if to not in sure], now > 0))
    values = against(actions, mdp.theirs) if context.is_game else greatest(actions)
    options = ("--kind", "achieve", "--objective", context.names[number], "--choose", "likely")
    for where, state, entry in safe_entries(context, *options):
        found = entry["attains"]["probability"] if entry["attains"] else None
        context.within(f"probability of {where}", 1 if state in sure else values[state], found)


def safe_entries(context, *options):
    """What `strategy` says in each safe state, with the state of the reference."""
    for name, entry in context.strategy(*options).items():
        state = context.relation.one(name)
        if state not in context.analysis.mdp.unsafe:
            yield f"{options} in {dict(name)}", state, entry


def planned_at(context, named, where, state, entry):
    """A plan improves as SASI does, then takes an objective, and may commit to it."""
    analysis = context.analysis
    levels = analysis.levels("sasi")
    if levels.rank(state) != 0:
        for what in ("permitted", "progress"):
            expected = sorted(c.name for c in getattr(levels, what)(state))
            context.same(f"{what} of {where}", expected, sorted(a["name"] for a in entry["actions"] if a.get(what)))
        context.same(f"pursues of {where}", (None, False, []), tuple(map(entry.get, OF_PURSUIT)))
        return
    found = pursued(analysis, state, named)
    reference = analysis.classes[state] if found and not found[1] else None
    pursues_at(context, found and (found[0], reference), where, state, entry, bool(found and found[1]))


def pursues_at(context, taken, where, state, entry, commits=False):
    """The objective that is pursued, by all choices or by those that never weaken a class, and how."""
    analysis = context.analysis
    done = done_in(context, where, state, entry["achieved"], set())
    objective, reference = taken or (None, None)
    commits = commits and objective not in done
    if state in analysis.whole.theirs:
        expected = (taken and context.names[objective], commits)
        context.same(f"pursues of {where}", expected, tuple(map(entry.get, OF_PURSUIT[:2])))
        return
    taken_action = [a for a in entry["actions"] if a["name"] == entry["chosen_action"]]
    given_up = {name for a in taken_action for s in a["successors"] for name in s["lost"]} if commits else set()
    expected = (taken and context.names[objective], commits, [n for n in context.names if n in given_up])
    context.same(f"pursues of {where}", expected, tuple(map(entry.get, OF_PURSUIT)))
    if taken:
        actions_at(context, objective, pursuit(analysis, objective, reference), where, state, entry)
        if not analysis.play and state not in analysis.targets[objective]:
            choices = {choice.name: choice for choice in analysis.whole.choices[state]}
            verdicts = {name: pursuing(analysis, objective, reference, state, c) for name, c in choices.items()}
            context.same(f"verdicts of {where}", verdicts, {a["name"]: a["verdict"] for a in entry["actions"]})


def actions_at(context, objective, way, where, state, entry):
    """The permitted actions and those that make progress. The regions of a formula bring strategies of their own: these
    must stay where it is sure."""
    staying, closer = ([c.name for c in found] for found in (way.staying(state), way.closer(state)))
    permitted, progress = ([a["name"] for a in entry["actions"] if a[what]] for what in ("permitted", "progress"))
    if context.analysis.play:
        context.same(f"permitted stays sure of {where}", set(), set(permitted) - set(staying))
        done = claims(context.analysis, objective, state)
        context.same(f"an action achieves, {where}", True, done or entry["progress_action"] is not None)
        return
    context.same(f"permitted of {where}", sorted(staying), sorted(permitted))
    if state not in way.target:
        context.same(f"progress of {where}", sorted(closer), sorted(progress))


ALL = {"pursue": pursues, "likeliest": likeliest}
