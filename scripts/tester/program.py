"""Runs the program on a case, and relates its states to those of the reference."""

import json
import re
import subprocess


SMALLEST = "smg player p m endplayer module m x : bool init false; [] true -> (x'=true); endmodule"
PLAYING = {}  # by binary and command


class Refused(Exception):
    """The program did not answer."""


class Program:
    """The command, the files of a case, and the settings that all commands share."""

    def __init__(self, binary, folder, case):
        self.binary, self.folder, self.case, self.asked = binary, folder, case, []
        self.model, self.prefs = folder / "case.prism", folder / "case.pref"
        self.model.write_text(case.model_text())
        self.prefs.write_text(case.preferences_text())

    def text(self, formula):
        """A formula in the names of the model."""
        return formula

    def settings(self, *names):
        given = {name: self.case.settings[name] for name in names}
        return [text for name, value in given.items() if value != "" for text in (f"--{name}", str(value))]

    def run(self, *arguments):
        """Returns the exit status, standard output and standard error."""
        command = [self.binary, *map(str, arguments)]
        self.asked.append(command)
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=60)
        except subprocess.TimeoutExpired:
            raise Refused("no answer after 60 s") from None
        return done.returncode, done.stdout, done.stderr

    def plays(self, command):
        """Whether a command answers about the model: not all of them honour the players of a game."""
        known = (self.binary, command)
        if self.case.kind == "smg" and known not in PLAYING:
            model, prefs = self.folder / "smallest.prism", self.folder / "smallest.pref"
            model.write_text(SMALLEST)
            prefs.write_text("objective A = F x;")
            more = ["--out", self.folder / "smallest"] if command in ("export", "report") else []
            _, _, errors = self.run(command, model, prefs, *more)
            PLAYING[known] = f"`{command}` of a game is not supported" not in errors
        return self.case.kind != "smg" or PLAYING[known]

    def ask(self, *arguments, allowed=(0,)):
        """Returns the JSON object of a command."""
        status, out, errors = self.run(*arguments, "--json")
        if status not in allowed:
            raise Refused(f"status {status}: {(errors[errors.find('error:') :] or out)[:600]}")
        return json.loads(out)

    def about(self, command, *more, allowed=(0,)):
        """Asks about the model with its preferences."""
        names = ["scope", "safety", "threads", "coalition"]
        names += [] if command in ("compare", "export") else ["engine"]
        names += ["order"] if command in ("compare", "export") or self.case.settings["engine"] == "symbolic" else []
        return self.ask(command, self.model, self.prefs, *self.settings(*names), *more, allowed=allowed)


def key(state):
    return tuple(state.items())


def at(state):
    """A state as a value of `--at`; names of values stand in quotes, in which quotes are doubled."""
    return ",".join(f"{name}={quoted(value)}" for name, value in state.items())


def quoted(value):
    return '"' + value.replace('"', '""') + '"' if isinstance(value, str) else shown(value)


def in_state(value):
    """A value as it stands in a state. A name has quotes where it could be read as something else."""
    if not isinstance(value, str):
        return shown(value)
    begins = value[:1].isalpha() or value[:1] == "_"
    is_plain = begins and value == value.rstrip() and not re.search('[,"]|//', value) and value not in ("true", "false")
    return value if is_plain else quoted(value)


def shown(value):
    return str(value).lower() if isinstance(value, bool) else str(value)


def cell(value):
    """A value of a state in a table. A name that a spreadsheet would take for a formula begins with `'`."""
    text = shown(value)
    return f"'{text}" if isinstance(value, str) and is_formula(text) else text


def uncell(text):
    """The text of a cell."""
    return text[1:] if text.startswith("'") and is_formula(text) else text


def is_formula(text):
    return text.lstrip("'")[:1] in tuple("=+-@") and not is_number(text)


def is_number(text):
    return text.lstrip("+-").isdecimal() and text.isascii() and not text[1:].startswith(("+", "-"))


def rounded(value):
    """Numbers with nine digits, 0 below 1e-300: the order of the states may move the last bit of a sum."""
    if isinstance(value, float):
        return 0.0 if abs(value) < 1e-300 else float(f"{value:.9g}")
    if isinstance(value, dict):
        return {name: rounded(part) for name, part in value.items()}
    return [rounded(part) for part in value] if isinstance(value, list) else value


class Named:
    """Which states of the reference a state of the program stands for, if there are no monitors: those with its values.
    `wrong` lists what does not fit."""

    def __init__(self, analysis):
        self.analysis, self.wrong = analysis, []
        self.width, whole = len(analysis.program.variables), analysis.whole
        self.of = {key(analysis.program.named(whole.plain(state))): [state] for state in whole.states}

    def fresh(self):
        """The states from which the scope is explored."""
        whole = self.analysis.whole
        if self.analysis.scope == "reachable" or not self.analysis.play:
            return whole.initial if self.analysis.scope == "reachable" else whole.states
        starts = tuple(monitor.start for monitor in self.analysis.product.monitors)
        return [s for s, values in enumerate(whole.values) if values[self.width :] == starts]

    def one(self, name):
        """The state of the reference that stands for a state of the program."""
        return self.of[name][0]

    def steps(self, name, to):
        """The choices that lead from a state of the program to another one. Each may stand for several states."""
        choices = (choice for state in self.of[name] for choice in self.analysis.whole.choices[state])
        return [choice for choice in choices if not choice.successors.isdisjoint(self.of.get(to, ()))]

    def count(self, states):
        """The number of states of the program that stand for states of a set."""
        return str(sum(self.one(name) in states for name in self.of))


class Relation(Named):
    """Which states of the reference a state of the program stands for: they are reached by the same paths.

    `of[k]` lists the states of the reference for a state of the program, `wrong` what does not fit.
    """

    def __init__(self, analysis, entries, initial):
        self.analysis, self.entries, self.of, self.wrong = analysis, entries, {}, []
        self.width = len(analysis.program.variables)
        monitors = list(initial.items())[self.width :]
        whole, fresh = analysis.whole, self.fresh()
        self.todo = []
        for state in fresh:
            plain = list(analysis.program.named(whole.plain(state)).items())
            self.relate(tuple(plain + monitors), state)
        while self.todo:
            self.follow(*self.todo.pop())
        missing = entries.keys() - self.of.keys()
        if missing:
            self.wrong.append(f"not reachable by the reference: {dict(next(iter(missing)))}")

    def relate(self, name, state):
        found = self.of.setdefault(name, [])
        if state not in found:
            found.append(state)
            self.todo.append((name, state))

    def follow(self, name, state):
        entry = self.entries.get(name)
        if entry is None:
            self.wrong.append(f"not a state of the program: {dict(name)}")
            return
        actions = {action["name"]: action for action in entry["actions"]}
        choices = {choice.name: choice for choice in self.analysis.whole.choices[state]}
        if actions.keys() != choices.keys() or len(actions) < len(entry["actions"]):
            self.wrong.append(f"actions of {dict(name)}: {sorted(actions)}, not {sorted(choices)}")
            return
        for action, choice in choices.items():
            successors = {key(s["state"])[: self.width]: s for s in actions[action]["successors"]}
            expected = {tuple(self.analysis.program.named(self.analysis.whole.plain(t)).items()): t for t in choice.to}
            if successors.keys() != expected.keys() or len(successors) < len(actions[action]["successors"]):
                self.wrong.append(
                    f"successors of {dict(name)} by {action}: {sorted(successors)}, not {sorted(expected)}"
                )
                continue
            for plain, successor in successors.items():
                self.relate(key(successor["state"]), expected[plain])
