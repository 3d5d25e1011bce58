"""Section 14: policies as lists of rules. In each state the first rule whose conditions all hold gives the action.

A condition is an atom and whether it holds: a fact, or a pair of a variable and the text of its value. A rule is
`(conditions, action, position)`. A world has `starts`, `goal`, `steps(state)`, which lists the name and the successors of
each choice in order, `atoms(state)`, and `same(name, other)` for names of actions.
"""

import json
import re

NAME = r'"(?:[^"]|"")*"|[^/="]*?'


def plain(text):
    text = text.strip()
    return text[1:-1].replace('""', '"') if text[:1] == '"' else text


def condition(text, has_values):
    """Reads `fact`, `x=1`, or the negation of either."""
    found = re.fullmatch(rf"\s*(not\()?\s*({NAME})\s*" + (rf"=\s*({NAME})\s*" if has_values else "") + r"(\))?\s*", text)
    negated, name, *value, end = found.groups()
    if end and not negated:  # the end of a name such as at(a)
        *value, last = [*value, value.pop() if value else name]
        name, value = (name, [last + ")"]) if has_values else (last + ")", [])
    assert not negated or end, text
    return (plain(name), plain(value[0])) if has_values else plain(name), not negated


def read(text, has_values):
    """The rules of a file, a text or a list in JSON."""
    if text.lstrip().startswith("["):
        entries = json.loads(text)
        return [([condition(c, has_values) for c in e["state"]], e["action"], e.get("position")) for e in entries]
    rules = []
    for holds, action in re.findall(r"^If holds:(.*)\n+Execute:(.*)$", text, re.MULTILINE):
        parts = re.findall(r'(?:"(?:[^"]|"")*"|[^/"])+', holds)
        name, rest = re.fullmatch(r'\s*("(?:[^"]|"")*"|.*?)\s*( / .*)?', action).groups()
        position = re.search(r" / position=(\d+)", rest or "")
        conditions = [condition(part, has_values) for part in parts if part.strip()]
        rules.append((conditions, plain(name), int(position[1]) if position else None))
    return rules


def quoted(name):
    is_plain = name.strip() == name and name and not set(name) & set('/="') and not name.startswith("not(")
    return name if is_plain else '"' + name.replace('"', '""') + '"'


def shown(condition):
    atom, holds = condition
    text = quoted(atom) if isinstance(atom, str) else "=".join(map(quoted, atom))
    return text if holds else f"not({text})"


def written(rules, as_json):
    """The rules as a file."""
    if as_json:
        entries = [{"state": list(map(shown, own)), "action": action, "position": at} for own, action, at in rules]
        return json.dumps(entries)
    lines = ["Policy:"]
    for conditions, action, at in rules:
        lines += [f"If holds: {'/'.join(map(shown, conditions))}", f"Execute: {quoted(action)}"]
        lines[-1] += f" / position={at}" if at is not None else ""
    return "\n".join(lines) + "\n"


def taken(world, rules, state):
    """The successors of the choice that the policy takes; None without exactly one choice."""
    atoms = world.atoms(state)
    for conditions, action, at in rules:
        if all((atom in atoms) == holds for atom, holds in conditions):
            named = [(n, to) for n, (name, to) in enumerate(world.steps(state)) if world.same(name, action)]
            fits = [to for n, to in named if at in (None, n)]
            return fits[0] if len(fits) == 1 else None
    return None


def is_plan(world, rules, is_strong=False):
    """Whether every path from the initial states surely reaches the goal, with `is_strong` within a bound."""
    after, todo = {}, list(world.starts)
    while todo:
        state = todo.pop()
        if state not in after and state not in world.goal:
            after[state] = taken(world, rules, state)
            if after[state] is None:
                return False
            todo += after[state]
    near = set(world.goal)
    some_or_all = all if is_strong else any
    while more := {s for s, to in after.items() if s not in near and some_or_all(t in near for t in to)}:
        near |= more
    return near >= after.keys()
