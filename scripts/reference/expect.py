"""The `// EXPECT:` lines of a model file: see models/README.md for their syntax."""

import os
import re
import shlex

from reference.preferences import read_preferences
from reference.prism import InputError, read_program
from reference.reports import check, info, reach

HEAD = re.compile(r"//\s*EXPECT:\s*(.*)")
MORE = re.compile(r"//\s{4,}(\S.*)")


def expectations(lines):
    """`(first line number, last line number, text)` of each expectation, continuation lines joined."""
    found = []
    for number, line in enumerate(lines):
        head, more = HEAD.match(line.strip()), MORE.match(line.strip())
        if head:
            found.append([number, number, head.group(1)])
        elif more and found and found[-1][1] == number - 1:
            found[-1][1:] = number, f"{found[-1][2]} {more.group(1)}"
    return found


def parse(text):
    """`check a=b c=d: p=v q=w` as `(command, options, facts)`."""
    words, colon = shlex.split(text), None
    for colon, word in enumerate(words):
        if word.endswith(":"):
            break
    words[colon] = words[colon][:-1]
    pairs = [word.partition("=")[::2] for word in words]
    return words[0], dict(pairs[1 : colon + 1]), pairs[colon + 1 :]


def look_up(value, path):
    """A step is a key, an index, an objective's name or a class's members joined by `+`."""
    for step in path.split("."):
        if isinstance(value, list):
            if not step.isdigit():
                names = ["+".join(e.get("most_preferred", [e.get("name", "")])) or "nothing" for e in value]
                step = names.index(step)
            value = value[int(step)]
        else:
            value = value[step]
    if isinstance(value, list):
        return ",".join(map(str, value)) or "-"
    words = {None: "null", True: "true", False: "false"}
    return words[value] if value is None or isinstance(value, bool) else str(value)


def formula_of(text):
    """The formula of `P>=1 [ formula ]`."""
    return text[text.index("[") + 1 : text.rindex("]")]


class Runner:
    """Runs the expectations of one model file."""

    def __init__(self, path, limit):
        self.path, self.limit, self.programs = path, limit, {}

    def run(self, command, options):
        constants = dict(p.split("=") for p in options.get("const", "").split(",") if p)
        scope = options.get("scope", "reachable")
        if options.get("const") not in self.programs:
            self.programs[options.get("const")] = read_program(self.path, constants)
        program = self.programs[options.get("const")]
        if command == "info":
            return info(program, scope, self.limit)
        if command == "reach":
            formula = formula_of(options["property"]) if "property" in options else None
            return reach(program, scope, options.get("target"), formula, self.limit)
        preferences = read_preferences(os.path.join(os.path.dirname(self.path), options["prefs"]))
        preferences.empty = options.get("empty", preferences.empty)
        return check(program, preferences, scope, options.get("safety", "prefix"), self.limit)


def run_expectations(paths, fill=False, limit=200_000):
    """Returns 0 if every line that could be run holds, else 1."""
    passed, failed, skipped = 0, 0, 0
    for path in paths:
        with open(path, encoding="utf-8") as file:
            lines = file.read().split("\n")
        runner = Runner(path, limit)
        for first, last, text in expectations(lines):
            command, options, facts = parse(text)
            # Too large for states one by one.
            if options.get("engine") == "symbolic":
                skipped += 1
                continue
            try:
                result = runner.run(command, options)
            except OverflowError:
                print(f"{path}:{first + 1}: skipped, more than {limit} states")
                skipped += 1
                continue
            except InputError as error:
                result = {"error": str(error)}
            for key, value in facts:
                try:
                    found = look_up(result, key)
                except (KeyError, ValueError, IndexError) as problem:
                    found = f"nothing ({problem!r}); {result.get('error', '')}"
                if value == "?" and fill:
                    for n in range(first, last + 1):
                        lines[n] = re.sub(rf"(?<=\s){re.escape(key)}=\?(?=\s|$)", lambda _: f"{key}={found}", lines[n])
                    passed += 1
                elif value == found or key == "error" and value in found:
                    passed += 1
                else:
                    failed += 1
                    print(f"{path}:{first + 1}: {text.split(':')[0]}: {key} is {found}, not {value}")
        if fill:
            with open(path, "w", encoding="utf-8") as file:
                file.write("\n".join(lines))
    print(f"{passed} passed, {failed} failed, {skipped} skipped")
    return 1 if failed else 0
