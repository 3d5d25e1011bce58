"""The PRISM language (a subset), read into plain Python functions.

What is understood: `mdp`, `dtmc` and `smg` with players, typed constants (given or not), formulas, labels, modules
with bounded integers and Booleans, module renaming, labelled and unlabelled commands, `init ... endinit`, reward
structures. Anything else raises `InputError`. Numbers that are not whole are exact fractions.
"""

import functools
import itertools
import math
import re
from dataclasses import dataclass, field
from fractions import Fraction

TOKEN = re.compile(
    r'\s+|//[^\n]*|"[^"\n]*"|\d+(?:\.\d+)?(?:[eE][-+]?\d+)?(?![\w.])|\d+|\w+\'?|->|\.\.|=>|<=>|<=|>=|!=|.'
)
FUNCTIONS = {"min": min, "max": max, "floor": math.floor, "ceil": math.ceil, "mod": lambda a, b: a % b, "pow": pow}


class InputError(Exception):
    """The model, the constants or the preferences are wrong."""


@dataclass
class Variable:
    name: str
    kind: str
    low: int
    high: int
    initial: object


@dataclass
class Command:
    module: str
    label: str  # "" for none
    number: int  # from 1, among the module's commands of this label
    guard: object
    branches: list  # of (probability, [(variable index, value)]), functions of a state
    text: str


@dataclass(eq=False)
class Program:
    """A model in PRISM's language. A state is the tuple of the values of its variables."""

    kind: str  # "mdp", "dtmc" or "smg"
    constants: dict
    variables: list
    modules: dict  # name -> list of Command
    labels: dict = field(default_factory=dict)
    compile: object = None  # text of an expression -> function of a state
    init: object = None  # predicate on states, or None
    rewards: dict = field(default_factory=dict)  # name ("" for none) -> list of (action or None, guard, value)
    players: dict = field(default_factory=dict)  # name -> set of modules and of actions in brackets

    def initial_states(self):
        if self.init is None:
            return [tuple(v.initial for v in self.variables)]
        return [s for s in self.all_states() if self.init(s)]

    def all_states(self):
        ranges = [(False, True) if v.kind == "bool" else range(v.low, v.high + 1) for v in self.variables]
        return itertools.product(*ranges)

    def named(self, state):
        return dict(zip((v.name for v in self.variables), state))

    def choices(self, state):
        """Section 1: `(name, labels, {successor: probability})` of every enabled choice."""
        found = [(name, [combo[0].label], self.distribution(state, combo)) for name, combo in self.combinations(state)]
        if self.kind != "dtmc" or len(found) < 2:
            return found
        merged = {}  # A dtmc draws from its enabled choices uniformly.
        for _, _, distribution in found:
            for target, p in distribution.items():
                merged[target] = merged.get(target, 0) + p / len(found)
        return [("+".join(name for name, _, _ in found), [label for _, (label,), _ in found], merged)]

    def combinations(self, state):
        """`(name, commands)` of every command, or combination of commands with one label, that is enabled."""
        enabled = {}
        for module, commands in self.modules.items():
            for command in commands:
                if command.guard(state):
                    enabled.setdefault((command.label, module), []).append(command)
        combos = [(c,) for (label, _), cs in enabled.items() if not label for c in cs]
        for label, members in self.alphabet.items():
            parts = [enabled.get((label, m), []) for m in members]
            combos += itertools.product(*parts)
        labels = [combo[0].label for combo in combos]
        for combo in combos:
            label = combo[0].label
            commands = ",".join(f"{c.module}#{c.number}" for c in combo)
            name = commands if not label else label if labels.count(label) == 1 else f"{label}({commands})"
            yield name, combo

    def movers(self, state):
        """Section 11: the positions of the players that have a choice in a state; None for several of no player."""
        owners = [self.owner(combo[0]) for _, combo in self.combinations(state)]
        return {owner for owner in owners if owner is not None} or ({0} if len(owners) == 1 else set(owners))

    def owner(self, command):
        """The position of the player of a command's label, or of its module if it has none; None without a player."""
        item = f"[{command.label}]" if command.label else command.module
        return next((at for at, items in enumerate(self.players.values()) if item in items), None)

    def named_players(self, names):
        """The positions of some players, each given by its name or by its number from 1 on; without any, the first."""
        known = {**{str(n): n - 1 for n in range(1, len(self.players) + 1)},
                 **{name: at for at, name in enumerate(self.players)}}  # fmt: skip
        if not known.keys() >= set(names):
            raise InputError(f"unknown player among {names}")
        return frozenset(known[name] for name in names) or frozenset([0])

    def __post_init__(self):
        self.alphabet = {}
        for module, commands in self.modules.items():
            for command in commands:
                members = self.alphabet.setdefault(command.label, [])
                if command.label and module not in members:
                    members.append(module)
        self.alphabet.pop("", None)

    def distribution(self, state, combo):
        """The successors with their exact probabilities; a branch whose probability is 0 is not there."""
        options = [self.weighted(command, state) for command in combo]
        found = {}
        for branches in itertools.product(*options):
            weight = math.prod((p for p, _ in branches), start=Fraction(1))
            target = list(state)
            for _, updates in branches:
                for index, value in updates:
                    target[index] = value(state)
            target = self.in_range(tuple(target), state, combo)
            found[target] = found.get(target, 0) + weight
        return found

    def weighted(self, command, state):
        """The branches of a command with a positive probability; a sum that is 1 only after rounding is divided by."""
        values = [Fraction(probability(state)) for probability, _ in command.branches]
        total = sum(values)
        if any(p < 0 or p > 1 for p in values) or abs(total - 1) > Fraction(1, 10**9):
            raise InputError(f"probabilities of `{command.text}` are {values} in {self.show(state)}")
        return [(p / total, updates) for p, (_, updates) in zip(values, command.branches) if p > 0]

    def reward(self, name, state, labels):
        """Section 9: what a step costs; the mean over the commands that a choice of a dtmc draws from."""
        if name == "steps":
            return Fraction(1)
        items = [(action, value(state)) for action, guard, value in self.rewards[name] if guard(state)]
        earned = [sum(Fraction(v) for action, v in items if action is None or action == label) for label in labels]
        return Fraction(sum(earned), len(labels))

    def in_range(self, target, state, combo):
        for value, variable in zip(target, self.variables):
            if type(value) is not (bool if variable.kind == "bool" else int):
                raise InputError(f"`{combo[0].text}` gives {variable.name} the value {value!r}")
            if variable.kind == "int" and not variable.low <= value <= variable.high:
                raise InputError(f"`{combo[0].text}` takes {variable.name} to {value} from {self.show(state)}")
        return target

    def show(self, state):
        return ",".join(f"{v.name}={str(x).lower()}" for v, x in zip(self.variables, state))


class Parser:
    """Recursive descent from tokens to the source text of a Python expression."""

    LEVELS = [["=>"], ["<=>"], ["|"], ["&"], None, ["=", "!="], ["<", "<=", ">", ">="], ["+", "-"], ["*", "/"]]
    PYTHON = {"|": "or", "&": "and", "=": "==", "<=>": "=="}

    def __init__(self, tokens, names):
        self.tokens, self.at, self.names = tokens, 0, names

    def peek(self, ahead=0):
        return self.tokens[self.at + ahead] if self.at + ahead < len(self.tokens) else ""

    def next(self, wanted=None):
        token = self.peek()
        if wanted is not None and token != wanted:
            raise InputError(
                f"expected `{wanted}`, found `{token}` near `{' '.join(self.tokens[self.at - 6 : self.at + 3])}`"
            )
        self.at += 1
        return token

    def accept(self, wanted):
        if self.peek() == wanted:
            self.at += 1
            return True
        return False

    def expression(self):
        condition = self.binary(0)
        if not self.accept("?"):
            return condition
        then = self.expression()
        self.next(":")
        return f"({then} if {condition} else {self.expression()})"

    def binary(self, level):
        if level == len(self.LEVELS):
            return self.unary()
        if self.LEVELS[level] is None:  # `!` binds weaker than comparison
            return f"(not {self.binary(level)})" if self.accept("!") else self.binary(level + 1)
        left = self.binary(level + 1)
        while self.peek() in self.LEVELS[level]:
            operator = self.next()
            if operator == "=>":  # right-associative
                return f"((not {left}) or {self.binary(level)})"
            right = self.binary(level + 1)
            left = f"Fraction({left})" if operator == "/" else left
            left = f"({left} {self.PYTHON.get(operator, operator)} {right})"
        return left

    def unary(self):
        token = self.next()
        if token == "-":
            return f"(-{self.unary()})"
        if token == "!":
            return f"(not {self.unary()})"
        if token == "(":
            inside = self.expression()
            self.next(")")
            return inside
        if token in FUNCTIONS:
            self.next("(")
            arguments = [self.expression()]
            while self.accept(","):
                arguments.append(self.expression())
            self.next(")")
            return f"{token}({', '.join(arguments)})"
        if token in ("true", "false"):
            return token.capitalize()
        if re.fullmatch(r"[\d.]+(?:[eE][-+]?\d+)?", token):
            return token if token.isdigit() else f'Fraction("{token}")'
        if token in self.names:
            return self.names[token]
        raise InputError(f"unknown name `{token}`")


def function_of(source):
    return eval(f"lambda s: {source}", {**FUNCTIONS, "Fraction": Fraction})  # noqa: S307 - our own translation


def tokens_of(text):
    found = (m.group() for m in TOKEN.finditer(text))
    return [t for t in found if not t.isspace() and not t.startswith("//")]


def expand(tokens, formulas, depth=0):
    """Formulas replaced by their bracketed tokens; an action label `[name]` is not a formula's name."""
    if depth > 50:
        raise InputError("formulas refer to each other in a circle")
    tokens = list(tokens)
    for at, token in enumerate(tokens):
        if token in formulas and tokens[max(at - 1, 0) : at] + tokens[at + 1 : at + 2] != ["[", "]"]:
            yield from ["(", *expand(formulas[token], formulas, depth + 1), ")"]
        else:
            yield token


def split_top_level(tokens):
    """Constants, formulas, labels, modules (name -> tokens, or (source, renaming)), init."""
    parser, parts = (
        Parser(tokens, {}),
        {"const": [], "formula": {}, "label": {}, "module": {}, "init": None, "rewards": {}, "player": []},
    )
    parts["kind"] = parser.next()
    if parts["kind"] not in ("mdp", "dtmc", "smg"):
        raise InputError(f"models of the type `{parts['kind']}` are not understood")

    def until(end):
        taken = []
        while parser.peek() != end:
            taken.append(parser.next() or parser.next(end))
        parser.next(end)
        return taken

    while parser.peek():
        word = parser.next()
        if word == "const":
            kind = parser.next() if parser.peek() in ("int", "bool", "double") else "int"
            name, *value = until(";")
            parts["const"].append((kind, name, value[1:]))
        elif word in ("formula", "label"):
            name, _, *value = until(";")
            parts[word][name.strip('"')] = value
        elif word == "player":
            name, *items = until("endplayer")
            parts["player"].append((name, list(filter(None, "".join(items).split(",")))))
        elif word == "init":
            parts["init"] = until("endinit")
        elif word == "rewards":
            name = parser.next().strip('"') if parser.peek().startswith('"') else ""
            parts["rewards"][name] = until("endrewards")
        elif word == "module":
            name = parser.next()
            body = until("endmodule")
            if body and body[0] == "=":
                pairs = " ".join(body[3:-1]).split(",")
                body = (body[1], dict(tuple(x.split(" = ")) for x in map(str.strip, pairs)))
            parts["module"][name] = body
        else:
            raise InputError(f"`{word}` is not understood here")
    return parts


def constants_of(declared, given, formulas):
    values, names = {}, {}
    for kind, name, tokens in declared:
        if tokens and name in given:
            raise InputError(f"constant `{name}` has a value already")
        if not tokens and name not in given:
            raise InputError(f"constant `{name}` has no value")
        tokens = list(expand(tokens, formulas)) or tokens_of(given[name])
        value = function_of(Parser(tokens, names).expression())(())
        values[name] = float(value) if kind == "double" else value
        names[name] = repr(Fraction(value)) if kind == "double" else repr(value)
    unknown = set(given) - set(values)
    if unknown:
        raise InputError(f"unknown constant `{min(unknown)}`")
    return values, names


def module_tokens(parts):
    """Every module's tokens with formulas expanded and renamings carried out."""
    bodies = {}
    for name, body in parts["module"].items():
        if isinstance(body, tuple):
            source, renaming = body
            primed = {f"{a}'": f"{b}'" for a, b in renaming.items()}
            bodies[name] = [{**renaming, **primed}.get(t, t) for t in bodies[source]]
        else:
            bodies[name] = list(expand(body, parts["formula"]))
    return bodies


def read_variables(parser, variables):
    """Declarations at the head of a module, as `Variable`s with constant bounds."""
    while parser.peek(1) == ":":
        name = parser.next()
        parser.next(":")
        if parser.accept("bool"):
            kind, low, high, initial = "bool", 0, 1, False
        else:
            parser.next("[")
            low = function_of(parser.expression())(())
            parser.next("..")
            high = function_of(parser.expression())(())
            parser.next("]")
            kind, initial = "int", low
            if low > high:
                raise InputError(f"range of `{name}` is empty: [{low}..{high}]")
        if parser.accept("init"):
            initial = function_of(parser.expression())(())
        parser.next(";")
        variables.append(Variable(name, kind, low, high, initial))
    return parser.at


def read_commands(module, parser, index):
    commands, counts = [], {}
    while parser.accept("["):
        start = parser.at - 1
        label = "" if parser.peek() == "]" else parser.next()
        parser.next("]")
        guard = function_of(parser.expression())
        parser.next("->")
        branches = []
        while True:
            branches.append(read_branch(parser, index))
            if not parser.accept("+"):
                break
        parser.next(";")
        counts[label] = counts.get(label, 0) + 1
        text = " ".join(parser.tokens[start : parser.at])
        commands.append(Command(module, label, counts[label], guard, branches, text))
    if parser.peek():
        raise InputError(f"expected a command, found `{parser.peek()}` in module `{module}`")
    return commands


def read_branch(parser, index):
    probability, updates = "1", []
    starts_update = parser.peek() == "true" and parser.peek(1) in ("+", ";")
    if not starts_update and not (parser.peek() == "(" and parser.peek(1).endswith("'")):
        probability = parser.expression()
        parser.next(":")
    if not parser.accept("true"):
        while True:
            parser.next("(")
            name = parser.next()[:-1]
            parser.next("=")
            updates.append((index[name], function_of(parser.expression())))
            parser.next(")")
            if not parser.accept("&"):
                break
    return function_of(probability), updates


def read_rewards(tokens, names):
    """The items of a reward structure: action (None for a state reward, "" for no label), guard, value."""
    parser, items = Parser(tokens, names), []
    while parser.peek():
        action = None
        if parser.accept("["):
            action = "" if parser.peek() == "]" else parser.next()
            parser.next("]")
        guard = function_of(parser.expression())
        parser.next(":")
        items.append((action, guard, function_of(parser.expression())))
        parser.next(";")
    return items


def read_program(path, given=()):
    with open(path, encoding="utf-8") as file:
        return program_of(file.read(), dict(given))


def program_of(text, given):
    parts = split_top_level(tokens_of(text))
    constants, names = constants_of(parts["const"], given, parts["formula"])
    bodies = module_tokens(parts)
    variables, starts = [], {}
    for name, tokens in bodies.items():
        starts[name] = read_variables(Parser(tokens, names), variables)
    index = {v.name: i for i, v in enumerate(variables)}
    if len(index) != len(variables):
        raise InputError("a variable is declared twice")
    names = {**names, **{name: f"s[{i}]" for name, i in index.items()}}

    def compile_tokens(tokens):
        parser = Parser(list(expand(tokens, parts["formula"])), names)
        result = function_of(parser.expression())
        if parser.peek():
            raise InputError(f"unexpected `{parser.peek()}`")
        return result

    @functools.lru_cache(maxsize=None)
    def compile_text(text):
        tokens = tokens_of(text)
        quoted = [t[1:-1] if t.startswith('"') else None for t in tokens]
        parts_of = [["(", *parts["label"][q], ")"] if q is not None else [t] for q, t in zip(quoted, tokens)]
        return compile_tokens([t for part in parts_of for t in part])

    modules = {m: read_commands(m, Parser(tokens[starts[m] :], names), index) for m, tokens in bodies.items()}
    program = Program(parts["kind"], constants, variables, modules, parts["label"], compile_text)
    program.init = compile_tokens(parts["init"]) if parts["init"] else None
    for name, tokens in parts["rewards"].items():
        program.rewards[name] = read_rewards(list(expand(tokens, parts["formula"])), names)
    program.players = players_of(parts["player"], program)
    return program


def players_of(declared, program):
    """The players of a game, each with its modules and actions."""
    if bool(declared) != (program.kind == "smg"):
        raise InputError("a game has players, and nothing else has")
    owned = [item for _, items in declared for item in items]
    known = {*program.modules, *(f"[{label}]" for label in program.alphabet)}
    if len(dict(declared)) < len(declared):
        raise InputError("a player is defined twice")
    if not known.issuperset(owned):
        raise InputError("a player owns what there is not")
    if len(set(owned)) < len(owned):
        raise InputError("something belongs to two players")
    return {name: set(items) for name, items in declared}
