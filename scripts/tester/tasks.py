"""Small planning problems in PDDL, drawn from the seed: states, plans and policies against the reference."""

import json
import random

from reference import planning
from tester import policies

MOST = 400
OBJECTS = ("a", "b", "c")
CHANGED = {"p": 0, "q": 1, "at": 2}


class Draw:
    def __init__(self, seed):
        self.random = random.Random(f"task {seed}")

    def atom(self, variables, names=("p", "q", "at", "fixed", "linked")):
        name = self.random.choice(names)
        arity = {**CHANGED, "fixed": 1, "linked": 1}[name]
        return f"({' '.join([name, *self.random.choices([*variables, *OBJECTS], k=arity)])})"

    def condition(self, variables, depth=1):
        kind = self.random.randrange(7 if depth else 3)
        if kind < 2:
            return self.atom(variables)
        if kind == 2:
            return f"(not {self.atom(variables)})"
        parts = [self.condition(variables, depth - 1) for _ in range(2)]
        if kind < 6:
            return f"({('and', 'or', 'imply')[kind - 3]} {' '.join(parts)})"
        inner = self.condition([*variables, "?z"], depth - 1)
        return f"({self.random.choice(('forall', 'exists'))} (?z{self.random.choice((' - s', ''))}) {inner})"

    def effect(self, variables, depth=3):
        kind = self.random.randrange(6 if depth else 2)
        change = self.atom(variables, tuple(CHANGED))
        if kind < 2:
            return change if kind else f"(not {change})"
        inner = lambda: self.effect(variables, depth - 1)
        if kind == 2:
            return f"(and {inner()} {inner()})"
        if kind == 3:
            return f"(oneof {inner()} {self.random.choice((inner(), '(and)'))})"
        if kind == 4:
            return f"(when {self.condition(variables, 0)} {inner()})"
        return f"(forall (?y - s) {self.effect([*variables, '?y'], 0)})"

    def action(self, number):
        variables = ["?v", "?w"][: self.random.randrange(3)]
        types = self.random.choice((" - s", " - (either s t)", ""))
        return (
            f"(:action do{number} :parameters ({' '.join(variables)}{types if variables else ''})\n"
            f"  :precondition (and {self.random.choice(('', '', self.condition(variables)))})\n"
            f"  :effect (and {self.effect(variables)} {self.effect(variables, 1)}))"
        )

    def texts(self):
        actions = "\n".join(self.action(number) for number in range(self.random.randint(2, 5)))
        domain = (
            "(define (domain drawn) (:types s t)\n(:predicates (p) (q ?x) (at ?x ?y) (fixed ?x) (linked ?x))\n"
            "(:derived (linked ?x) (or (q ?x) (exists (?y) (and (at ?x ?y) (linked ?y)))))\n" + actions + ")\n"
        )
        facts = {self.atom((), ("p", "q", "at", "fixed")) for _ in range(self.random.randrange(6))}
        atom = lambda: self.random.choice(("{}", "(not {})")).format(self.atom((), (*CHANGED, "linked")))
        goal = self.random.choice((atom(), f"(and {atom()} {atom()})", self.condition(())))
        problem = (
            "(define (problem drawn) (:domain drawn) (:objects a b - s c - t)\n"
            f"(:init {' '.join(sorted(facts))})\n(:goal {goal}))\n"
        )
        return domain, problem


def tasks(context):
    """The states, the regions of plans, and the policy of a drawn task."""
    if context.case.seed % 3:
        return
    domain, problem = Draw(context.case.seed).texts()
    reference = planning.Problem(domain + problem)
    known = reference.explored(MOST)
    if known is None:
        return
    context.case.features.add("planning problem")
    folder = context.program.folder
    paths = folder / "domain.pddl", folder / "problem.pddl"
    for path, text in zip(paths, (domain, problem)):
        path.write_text(text)
    goal = {state for state in known if reference.is_goal(state)}
    engine = context.program.settings("engine")
    report = context.program.ask("reach", *paths, "--target", '"goal"', "--strong", *engine)
    context.same("states of a task", str(len(known)), report["counts"]["states"])
    context.same("choices of a task", sum(len(s) or 1 for s in known.values()), int(report["counts"]["choices"]))
    context.same("target of a task", str(len(goal)), report["target"])
    cyclic, strong = planning.strong_cyclic(known, goal), planning.strong(known, goal)
    context.same("strong cyclic states of a task", str(len(cyclic)), report["pmax_one"])
    context.same("strong states of a task", str(len(strong)), report["plan"]["strong_states"])
    context.same("a strong plan of a task", reference.initial in strong, report["plan"]["strong"])
    policy = folder / "policy.json"
    report = context.program.ask("reach", *paths, "--policy", policy, *engine, allowed=(0, 1))
    context.same("a strong cyclic plan of a task", reference.initial in cyclic, report["plan"]["strong_cyclic"])
    changing = {fact for state in known for fact in state} - frozenset.intersection(*known)
    atoms = {state: set(map(planning.show, state)) for state in known}
    steps = {state: list(own.items()) or [("deadlock", {state})] for state, own in known.items()}
    world = policies.World([reference.initial], goal, steps, atoms, sorted(map(planning.show, changing)), False)
    if len(known) <= policies.MOST_STATES:
        policies.compare(context, world, paths, ["--target", '"goal"'])
    if reference.initial in cyclic:
        entries = [(entry["state"], entry["action"]) for entry in json.loads(policy.read_text())]
        context.same("the policy of a task is a plan", True, planning.is_plan(reference, entries))
        report = context.program.ask("verify", policy, *paths)
        context.same("the policy of a task is accepted", True, report["accepted"])
        visited = {frozenset(facts) for facts, _ in entries}
        context.same("states of the policy of a task", str(len(visited)), report["states"])
        steps = "--runs", "5", "--steps", "100000"
        runs = context.program.ask("simulate", *paths, "--policy", policy, *steps)["runs"]
        context.same("runs of the policy of a task", 5, runs["reached"])
        policy.unlink()


ALL = {"tasks": tasks}
