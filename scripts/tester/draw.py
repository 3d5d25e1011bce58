"""The random generator of cases. A feature that is added here is tested together with all others."""

import random
import re
from dataclasses import dataclass, field

SAFETIES = ("action", "transition", "prefix")
EMPTIES = ("bottom", "gain", "incomparable")


@dataclass
class Case:
    """A model, preferences and settings. The lists are what a smaller case may leave out items of."""

    seed: int
    kind: str
    owners: dict  # of a game: module or action -> player; the players are p1, p2, …
    size: int  # x is in 0..size
    flag: bool  # a second module has a Boolean y
    commands: list  # of (module, text)
    starts: list  # of conditions, for `init … endinit`; empty: the initial values
    rewards: list  # items of the structure "cost"
    labels: list  # of (name, condition)
    objectives: list  # of (name, formula)
    preferences: list  # statements
    required: list  # formulas
    coalition: list  # of the preferences: the names of players that we are; empty for the first one
    empty: str
    history: str  # "" for the default
    settings: dict  # scope, safety, engine, threads, order, reward, coalition
    fault: str = ""  # the mistake in the players, if there is one
    unlisted: str = ""  # of a game: the module or action that no player lists, if there is one
    features: set = field(default_factory=set)

    LISTS = ("commands", "starts", "rewards", "labels", "objectives", "preferences", "required")

    @property
    def players(self):
        return [f"p{number}" for number in sorted(set(self.owners.values()))]

    def player_lines(self):
        """The players with their modules, and with the actions that commands have."""
        used = {text[1 : text.index("]")] for _, text in self.commands} | {"m", *("n" if self.flag else "")}
        owned = {name: [] for name in self.players}
        for item, number in self.owners.items():
            if item in used and item != self.unlisted:
                owned[f"p{number}"].append(item if item in "mn" else f"[{item}]")
        first, *_, last = owned.values()
        if self.fault == "two owners":
            last += first[:1]
        elif self.fault == "unknown item":
            last.append("[z]")
        return [f"player {name} {', '.join(items)} endplayer" for name, items in owned.items()]

    def model_text(self, start="0"):
        given = "" if self.starts else f" init {start}", "" if self.starts else " init false"
        lines = [self.kind, *(self.player_lines() if self.owners else []), "", "module m"]
        lines += [f"  x : [0..{self.size}]{given[0]};"]
        lines += [f"  {text}" for module, text in self.commands if module == "m"] + ["endmodule"]
        if self.flag:
            lines += ["", "module n", f"  y : bool{given[1]};"]
            lines += [f"  {text}" for module, text in self.commands if module == "n"] + ["endmodule"]
        if self.rewards:
            lines += ["", 'rewards "cost"', *(f"  {item}" for item in self.rewards), "endrewards"]
        lines += ["", *(f'label "{name}" = {condition};' for name, condition in self.labels)]
        if self.starts:
            lines += ["", f"init {' | '.join(self.starts)} endinit"]
        return "\n".join([*lines, ""])

    def preferences_text(self):
        lines = [f"objective {name} = {formula};" for name, formula in self.objectives]
        lines += self.preferences + [f"require {formula};" for formula in self.required]
        lines += [f"coalition {', '.join(self.coalition)};"] if self.coalition else []
        lines += [f"empty = {self.empty};"] + ([f"history = {self.history};"] if self.history else [])
        return "\n".join([*lines, ""])


class Draw:
    """Draws the parts of one case."""

    def __init__(self, seed):
        self.rng, self.seed, self.features = random.Random(seed), seed, set()

    def chance(self, p):
        return self.rng.random() < p

    def mark(self, *features):
        self.features.update(features)

    def case(self):
        rng = self.rng
        self.forward = self.chance(0.75)  # steps mostly lead to greater x: fates part, and improvements are possible
        self.size = rng.choice([3, 4, 4, 5, 5, 6] if self.forward else [1, 2, 2, 3, 3, 4])
        (kind,) = rng.choices(["mdp", "dtmc", "smg"], [0.5, 0.2, 0.3])
        self.flag, self.play = self.chance(0.3), self.chance(0.3 if kind == "smg" else 0.5)
        self.exact = rng.choice(["zero", "tiny"]) if self.chance(0.3) else None
        self.players(kind)
        commands, objectives, self.better = self.commands(kind), self.objectives(), []
        drawn = len(objectives)
        for here in range(rng.choice([0, 1, 1, 2, 2]) if self.forward else 0):
            self.plant(here, commands, objectives)
        again = kind == "mdp" and self.size > 2 and self.chance(0.15) and self.again(commands, objectives)
        case = Case(
            self.seed, kind, self.owners, self.size, self.flag, commands, self.starts(), self.rewards(commands),
            self.names(), objectives, self.preferences(1 if again else drawn), self.requirements(), self.coalition(0.4),
            again or rng.choice(EMPTIES),
            "play" if self.play else rng.choice(["", "state"]), self.settings(), self.fault(commands),
        )  # fmt: skip
        if self.owners and self.chance(0.2):
            case.unlisted = rng.choice(sorted(self.owners))
            self.mark("a module or action of no player")
        if case.fault == "unknown player":
            case.coalition = ["p1", "p9"]
        self.mark(f"type {kind}", f"empty {case.empty}", f"history {'play' if self.play else 'state'}")
        self.mark(*(f"{key} {case.settings[key]}" for key in ("scope", "safety", "engine", "threads", "reward")))
        case.features = self.features
        return case

    def settings(self):
        rng = self.rng
        return {
            "scope": rng.choice(["reachable", "all"]),
            "safety": rng.choice([mode for mode in SAFETIES if mode != "transition" or not self.owners]),
            "engine": rng.choice(["symbolic", "explicit"]),
            "threads": rng.choice([1, 2]),
            "order": rng.choice(["declared", "auto"]),
            "reward": rng.choice(["steps", "cost"]),
            "coalition": ",".join(self.coalition(0.3)),
        }

    def starts(self):
        """Conditions of which each initial state satisfies one; one value of x at least satisfies the first."""
        if not self.chance(0.3):
            return []
        self.mark("several initial states")
        values = self.rng.sample(range(self.size + 1), min(2, self.size + 1))
        return [self.start(value) for value in values]

    def start(self, x):
        """A condition that holds for a value of x, and perhaps for others."""
        rng, size = self.rng, self.size
        if self.chance(0.5):
            return f"x={x}"
        self.mark("initial states by arithmetic")
        k = rng.randint(0, size)
        found = [f"max(x,{k})={max(x, k)} & x<={x + 1}", f"min(x+{k},{size})-x={min(x + k, size) - x} & x>={x - 1}"]
        found += [f"x+x={x + x}", f"mod(x,3)={x % 3}"]
        if self.flag:
            found += [f"x+(y?1:0)={x + rng.choice([0, 1])}", f"(y | x={x}) & (!y | x<={x})", f"x={x} & y"]
        return rng.choice(found)

    def commands(self, kind):
        rng, found = self.rng, []
        for x in range(self.size + 1):
            ends = self.forward and x > self.size // 2 and self.chance(0.7)
            amounts = [0] if ends else [1, 2, 2, 3] if self.forward else [0, 1, 1, 2, 2, 3]
            for _ in range(min(rng.choice(amounts), 2 - self.chance(0.7) if kind == "dtmc" else 3)):
                guard = f"x={x}" + (f" & {rng.choice(['y', '!y'])}" if self.flag and self.chance(0.2) else "")
                label = rng.choice(self.labels("m", x, ["", "a", "b", "c"]))
                found.append(("m", f"[{label}] {guard} -> {self.update('x', x)};"))
        if self.flag:
            self.mark("several modules")
            for _ in range(rng.choice([1, 2, 2])):
                label, guard = rng.choice(["", "a", "b"]), rng.choice(["true", "y", "!y"])
                guard += self.turn_of(self.owners[label or "n"]) if self.owners else ""
                found.append(("n", f"[{label}] {guard} -> {self.update('y', 0)};"))
                if label:
                    self.mark("synchronisation")
        return found

    def players(self, kind):
        """The players of a game: what each owns, and whose turn it is for each value of x."""
        self.owners, self.turns = {}, []
        if kind != "smg":
            return
        rng, count = self.rng, self.rng.choice([2, 2, 2, 3])
        actions = rng.sample("abcd", 4)
        self.owners = {item: rng.randint(1, count) for item in "mn"}
        # Each player has an action, so it can move in some state.
        self.owners |= {item: at + 1 if at < count else rng.randint(1, count) for at, item in enumerate(actions)}
        self.turns = [rng.randint(1, count) for _ in range(self.size + 1)]
        self.mark(f"{len(set(self.owners.values()))} players")

    def labels(self, module, x, labels):
        """The labels that a command of a module may have for a value of x: those of the player whose turn it is."""
        if not self.owners:
            return labels
        return [label for label in ("", *"abcd") if self.owners[label or module] == self.turns[x]]

    def turn_of(self, player):
        """The part of a guard that says that it is the turn of a player."""
        own = [f"x={x}" for x, turn in enumerate(self.turns) if turn == player]
        return f" & ({' | '.join(own) or 'false'})"

    def coalition(self, p):
        """Some players of a game by name or by number; mostly none, which stands for the first one."""
        if not self.owners or not self.chance(p):
            return []
        players = sorted(set(self.owners.values()))
        self.mark("coalition")
        some = self.rng.sample(players, self.rng.randint(1, max(1, len(players) - self.chance(0.8))))
        return [f"p{player}" if self.chance(0.8) else str(player) for player in some]

    def fault(self, commands):
        """Sometimes something is wrong with the players of a game."""
        if not self.owners or not self.chance(0.08):
            return ""
        fault = self.rng.choice(["two movers"] * 3 + ["two owners", "unknown item", "unknown player"])
        if fault == "two movers":
            x = self.rng.randint(0, self.size)
            others = [item for item in "abcd" if self.owners[item] != self.turns[x]]
            commands.append(("m", f"[{self.rng.choice(others)}] x={x} -> {self.update('x', x)};"))
        self.mark(fault)
        return fault

    def update(self, variable, here):
        """The branches of a command."""
        if variable == "y":
            targets = ["(y'=true)", "(y'=false)", "(y'=!y)"]
        else:
            ahead = range(here + 1 if self.forward and self.chance(0.85) else 0, self.size + 1)
            targets = [f"(x'={value})" for value in ahead if value != here] + ["true"] * self.chance(0.3)
            targets = targets or ["true"]
        rng, count = self.rng, self.rng.choice([1, 2, 2, 2, 3])
        count = min(count, len(targets))
        weights = {1: ["1"], 2: rng.choice([["1/2", "1/2"], ["0.1", "0.9"], ["1/3", "2/3"]]), 3: ["1/4", "0.25", "1/2"]}
        weights = list(weights[count])
        if self.exact and count < len(targets) and self.chance(0.4):
            small = {"zero": "(0.1+0.2-0.3)", "tiny": rng.choice(["1e-400", "(1-(1-1e-17))"])}[self.exact]
            self.mark(f"{self.exact} branch")
            weights = [f"({weights[0]}-{small})", *weights[1:], small]
        branches = [f"{w} : {t}" for w, t in zip(weights, rng.sample(targets, len(weights)))]
        return branches[0].removeprefix("1 : ") if len(branches) == 1 else " + ".join(branches)

    def rewards(self, commands):
        """Items of a structure: always one, so that the structure can be named."""
        rng, items = self.rng, []
        earners = ["", *sorted({text.split("]")[0] + "] " for _, text in commands})]
        for _ in range(rng.choice([1, 2, 3])):
            guard = rng.choice(["true", f"x={rng.randrange(self.size + 1)}", f"x>{rng.randrange(self.size + 1)}"])
            items.append(f"{rng.choice(earners)}{guard} : {rng.choice(['0', '1', '2', '1/3', '0.5'])};")
        if any(item.endswith(" 0;") for item in items):
            self.mark("reward of 0")
        return items

    def names(self):
        """Labels of the model. A strategy's model has some of these names for itself."""
        if not self.chance(0.3):
            return []
        self.mark("labels")
        names = self.rng.sample(["home", "improved", "settled", "achieved", "detour"], 2)
        return [(name, self.condition()) for name in names]

    def condition(self):
        rng, x = self.rng, self.rng.randint(min(1, self.size), self.size)
        others = [f"x<={x}", f"x>={x}", f"x!={x}", *(["y", "!y", f"(x={x} & y)"] if self.flag else [])]
        return f"x={x}" if self.chance(0.7) else rng.choice(others)

    def objectives(self):
        """Between one and four objectives."""
        return [(f"O{i}", self.objective()) for i in range(self.rng.choice([1, 2, 3, 3, 4, 4]))]

    def objective(self):
        if not self.play or self.chance(0.35):
            self.mark("objective reach")
            return f"F ({self.condition()})"
        kinds = ["co-safe", "safe", "recurrence", "persistence", "combination", "bounded"]
        return self.temporal("general" if self.chance(0.25) else self.rng.choice(kinds))

    def temporal(self, kind):
        a, b = self.condition(), self.condition()
        self.mark(f"objective {kind}")
        if kind == "combination":
            first, second = (
                self.temporal(self.rng.choice(["co-safe", "safe", "recurrence", "persistence"])) for _ in "ab"
            )
            forms = "({}) & ({})", "({}) | ({})", "!({}) & ({})", "({}) => ({})"
            return self.rng.choice(forms).format(first, second)
        return self.rng.choice(
            {
                "co-safe": [f"({a}) U ({b})", f"F (({a}) & (F ({b})))", f"X ({a})", f"F (({a}) & (X ({b})))"],
                "safe": [f"G ({a})", f"({a}) W ({b})", f"({a}) R ({b})", f"G (({a}) => (X ({b})))"],
                "recurrence": [f"G (F ({a}))", f"G (({a}) => (F ({b})))"],
                "persistence": [f"F (G ({a}))", f"F (({a}) & (G ({b})))"],
                "general": [
                    f"({a}) U (G ({b}))",
                    f"(F ({a})) W ({b})",
                    f"G (({a}) | (F (G ({b}))))",
                    f"F (({a}) & (G (F ({b}))))",
                    f"({a}) M ({b})",
                    f"G (({a}) => (({b}) U (G !({a}))))",
                    f"F (!({a}) <=> (G ({b})))",
                    f"G<=1 (F (({a}) & (G ({b}))))",
                ],
                "bounded": [f"F<=2 ({a})", f"G<=1 ({a})", f"({a}) U<=2 ({b})", f"F[1,2] ({a})", f"F>=2 ({a})"],
            }[kind]
        )

    def plant(self, here, commands, objectives):
        """A step that parts two fates, each with an objective of its own: whichever comes is an improvement."""
        p, q = self.rng.sample(range(here + 1, self.size + 1), 2)
        if q > here + 1 and self.chance(0.5):
            p = here + 1  # where the next one may be planted
        worse = self.rng.choice(objectives)[0]
        label = self.rng.choice(self.labels("m", here, ["a", "c", ""]))
        commands.insert(0, ("m", f"[{label}] x={here} -> 1/2 : (x'={p}) + 1/2 : (x'={q});"))
        names = [f"O{len(objectives)}", f"O{len(objectives) + 1}"]
        objectives += [(name, f"F (x={target})") for name, target in zip(names, (p, q))]
        self.better.append((names, worse))

    def again(self, commands, objectives):
        """A first gain that can be given up and made again, if chance permits. Returns the value of nothing for which
        this does not weaken."""
        commands[:] = [(module, text) for module, text in commands if not re.search(r"\bx[<>=]*[01]\b.*->", text)]
        back = self.rng.choice(["[b] x=1 -> (x'=0);", "[] x=1 -> 1/2 : (x'=0) + 1/2 : true;"])
        take, miss = "[c] x=1 -> (x'=2);", self.rng.choice(["1/2", "1/3 : true + 1/6"])
        try_it = f"[] x=0 -> 1/2 : (x'=1) + {miss} : (x'={self.size});"
        commands[:0] = [("m", text) for text in (try_it, back, take)]
        objectives[:], self.better = [("O0", "F (x=2)")], []
        self.mark("repeated gain")
        return "gain"

    def preferences(self, count):
        """Statements of every kind. The order of numbers keeps them free of contradictions."""
        rng, found = self.rng, []
        levels = [rng.randrange(4) for _ in range(count)]
        for _ in range(rng.choice([0, 1, 2, 3, 4, 5]) if count > 1 else 0):
            i, j = sorted(rng.sample(range(count), 2), key=lambda k: levels[k])
            if levels[i] < levels[j]:
                kind = rng.choice([">", ">", ">", ">="])
                self.mark("strict preference" if kind == ">" else "weak preference")
                found.append(f"prefer O{j} {kind} O{i};")
            else:
                self.mark("indifference")
                found.append(f"prefer O{j} ~ O{i};")
        for names, worse in self.better:
            if self.chance(0.7):
                self.mark("strict preference")
                found.append(f"prefer {', '.join(names)} > {worse};")
        return found

    def requirements(self):
        if not self.chance(0.65):
            return []
        found = [self.requirement() for _ in range(self.rng.choice([1, 1, 2]))]
        if len(found) > 1:
            self.mark("several requirements")
        return found

    def requirement(self):
        rng, size = self.rng, self.size
        a, b = (f"x={rng.randint(1, size)}" for _ in "ab")
        if not self.play or self.chance(0.25):
            self.mark("requirement on states")
            return rng.choice([f"G !({a})", f"G !({a})", f"G (!({a}) | {self.condition()})"])
        self.mark("temporal requirement")
        kinds = [f"!({a}) W ({b})", f"G (({a}) => (X !({b})))", f"({b}) R !({a})", f"X !({a})", f"G<=2 !({a})"]
        return rng.choice([*kinds, f"G ({self.condition()})"])


def draw(seed):
    return Draw(seed).case()
