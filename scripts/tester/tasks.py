"""Small planning problems in PDDL, drawn from the seed: states, plans and policies against the reference."""

import json
import random

from reference import planning
from tester import policies

MOST = 400
MOST_OUTCOMES = 64
OBJECTS = ("a", "b", "c")
TYPES = (" - s", " - t", " - (either s t)", "")
CHANGED = {"p": 0, "q": 1, "at": 2}
OTHERS = {"fixed": 1, "linked": 1, "both": 2}


class Draw:
    def __init__(self, seed):
        self.random = random.Random(f"task {seed}")

    def atom(self, variables, names=("p", "q", "at", "fixed", "linked", "both")):
        name = self.random.choice(names)
        arity = {**CHANGED, **OTHERS}[name]
        return f"({' '.join([name, *self.random.choices([*variables, *OBJECTS], k=arity)])})"

    def quantifier(self, variables):
        """One or two variables with types, which may hide others, and the variables inside."""
        new = self.random.sample(("?y", "?z", "?v"), k=self.random.choice((1, 1, 1, 2)))
        text = " ".join(f"{name}{self.random.choice(TYPES)}" for name in new)
        return text, [*variables, *new]

    def condition(self, variables, depth=1):
        kind = self.random.randrange(8 if depth else 4)
        if kind < 2:
            return self.atom(variables)
        if kind == 2:
            return f"(not {self.atom(variables)})"
        if kind == 3:
            return f"(= {' '.join(self.random.choices([*variables, *OBJECTS], k=2))})"
        if kind < 6:
            head = self.random.choice(("and", "or", "imply", "not"))
            count = 1 if head == "not" else 2
            return f"({head} {' '.join(self.condition(variables, depth - 1) for _ in range(count))})"
        new, variables = self.quantifier(variables)
        return f"({self.random.choice(('forall', 'exists'))} ({new}) {self.condition(variables, depth - 1)})"

    def effect(self, variables, depth=3):
        kind = self.random.randrange(8 if depth else 2)
        change = self.atom(variables, tuple(CHANGED))
        if kind < 2:
            return change if kind else f"(not {change})"
        inner = lambda: self.effect(variables, depth - 1)
        if kind == 2:
            return f"(and {inner()} {inner()})"
        if kind == 3:
            return f"(oneof {inner()} {self.random.choice((inner(), '(and)'))})"
        if kind == 4:
            return f"(probabilistic 1/2 {inner()}{self.random.choice(('', ' 1/2 (and)', f' 0.25 {inner()}'))})"
        if kind < 7:
            return f"(when {self.condition(variables, self.random.randrange(3))} {inner()})"
        new, variables = self.quantifier(variables)
        return f"(forall ({new}) {self.effect(variables, depth - 1)})"

    def action(self, number):
        variables = ["?v", "?w"][: self.random.randrange(3)]
        types = self.random.choice(TYPES)
        return (
            f"(:action do{number} :parameters ({' '.join(variables)}{types if variables else ''})\n"
            f"  :precondition (and {self.random.choice(('', '', self.condition(variables)))})\n"
            f"  :effect (and {self.effect(variables)} {self.effect(variables, 1)}))"
        )

    def rules(self):
        """Rules of derived predicates, whose heads have types in several forms. A rule that depends on
        its own negation would be refused."""
        typed = "(both ?x - s ?y - (either t s))", "(both ?x ?y - (either s t))", "(both ?x ?y)", "(both ?x - t ?y)"
        positive = self.atom(("?x", "?y"), ("q", "at", "fixed", "linked"))
        other = self.random.choice((positive, f"(not {self.atom(('?x', '?y'), ('q', 'at'))})"))
        return (
            "(:derived (linked ?x) (or (q ?x) (exists (?y) (and (at ?x ?y) (linked ?y)))))\n"
            f"(:derived {self.random.choice(typed)} (and {positive} {other}))\n"
        )

    def texts(self):
        actions = "\n".join(self.action(number) for number in range(self.random.randint(2, 5)))
        domain = (
            "(define (domain drawn) (:types s t)\n"
            "(:predicates (p) (q ?x) (at ?x ?y) (fixed ?x) (linked ?x) (both ?x ?y))\n"
            f"{self.rules()}{actions})\n"
        )
        facts = {self.atom((), ("p", "q", "at", "fixed")) for _ in range(self.random.randrange(6))}
        derived = (*CHANGED, "linked", "both")
        atom = lambda: self.random.choice(("{}", "(not {})")).format(self.atom((), derived))
        goal = self.random.choice((atom(), f"(and {atom()} {atom()})", self.condition((), 2)))
        wishes = f"(preference Wish-1 {self.condition((), 1)}) (preference clean (not {atom()}))"
        goal = self.random.choice((goal, goal, goal, f"(and {goal} {wishes})", f"(and {goal} {wishes})", f"(and {wishes})"))
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
    known = reference.explored(MOST) if reference.breadth() <= MOST_OUTCOMES else None
    if known is None:
        return
    context.case.features.add("planning problem")
    folder = context.program.folder
    paths = folder / "domain.pddl", folder / "problem.pddl"
    for path, text in zip(paths, (domain, problem)):
        path.write_text(text)
    if "(:goal (and (preference" in problem:
        without_goal(context, paths)
        preferences(context, paths, reference, known)
        return
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
    if reference.preferences:
        preferences(context, paths, reference, known)
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


def without_goal(context, paths):
    """A problem with preferences alone has no plan: a policy needs a target of its own."""
    context.case.features.add("preferences alone")
    policy = context.program.folder / "empty.txt"
    policy.write_text("Policy:\n")
    for asked in (["reach", *paths], ["verify", policy, *paths]):
        status, _, errors = context.program.run(*asked)
        is_refused = status == 2 and "no goal" in errors
        context.same(f"`{asked[0]}` without a goal is refused", "", "" if is_refused else errors[-300:] or status)


def preferences(context, paths, reference, known):
    """Preferences are judged where a plan ends; the names in the file have other capitals."""
    file = context.program.folder / "task.pref"
    file.write_text("prefer wish-1 > CLEAN;\n")
    engine = context.program.settings("engine")
    report = context.program.ask("check", *paths, file, *engine)
    for objective in report["objectives"]:
        name = objective["name"].lower()
        is_reached = reference.is_goal if name == "goal" else lambda state: reference.satisfies(state, name)
        target = {state for state in known if is_reached(state)}
        sure, some = planning.strong_cyclic(known, target), planning.possible(known, target)
        counts = [objective[key] for key in ("target", "almost_sure", "positive")]
        context.same(f"states of {name} of a task", [str(len(s)) for s in (target, sure, some)], counts)


ALL = {"tasks": tasks}
