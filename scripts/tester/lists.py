"""Lists of properties, some of which have mistakes: property files, and properties of JANI models with filters. Each
property has the answer of the reference, or a reason for none; the status is that of the answers."""

import json
import random
from fractions import Fraction

from reference.model import explore
from reference.questions import chances
from tester.names import fresh
from tester.questions import COMPARE, decimal, near
from tester.regions import value_of

SIGNS = {"≥": ">=", ">": ">", "≤": "<=", "<": "<"}
MISTAKES = (
    "P>=1 [ F nowhere = 1 ]",
    'Pmax=? [ F "nowhere" ]',
    "P>0 [ F x = ]",
    "S=? [ x + 1 ]",
    "P>=2 [ F x = 1 ]",
    'R{"none"}max=? [ F x = 1 ]',
)
MOST_STATES = 60


def property_files(context):
    """A file with definitions, of which some need a constant that is not given, and properties."""
    if context.is_game:
        return
    draw, program, size = random.Random(context.case.seed), context.program, context.case.size
    is_prism, x = program.model.suffix == ".prism", context.source.variables[0].name
    model, file = program.folder / f"listed{program.model.suffix}", program.folder / "listed.props"
    model.write_text(program.model.read_text() + ('label "base" = x = 0;\n' if is_prism else ""))
    whole = explore(context.source, context.case.settings["scope"], 3000)
    given = draw.choice([None, *range(size)])
    conditions = {"near": "x <= 1"} | ({"base": "x = 0"} if is_prism else {})
    conditions |= {} if given is None else {"far": f"x > {given + 1}"}
    lines = ["const int k;", "const int K = k + 1;", f"formula beyond = {x} > K;"]
    lines += ['label "far" = beyond;', f'label "near" = {x} <= 1;']
    if is_prism and draw.random() < 0.1:
        defined_twice(context, model, file, lines)
        return
    expected = []
    for _ in range(draw.randint(1, 5)):
        text, answer = listed(draw, whole, conditions)
        lines.append(f"{text};")
        expected.append((text, answer))
    file.write_text("\n".join([*lines, ""]))
    options = program.settings("scope", "engine", "threads") + ([] if given is None else ["-c", f"k={given}"])
    compare(context, expected, "reach", model, "--properties", file, *options)
    if any(answer is None for _, answer in expected):
        context.case.features.add("property with a mistake")


def listed(draw, whole, conditions):
    """A property of a file, with its answer; None without one."""
    if draw.random() < 0.35:
        return draw.choice(MISTAKES), None
    label = draw.choice([*conditions, "far"])
    operator = draw.choice(["P>=1", "Pmax>0", "Pmax=?", "Pmin=?"])
    text = f'{operator} [ F "{label}" ]'
    function = draw.choice([None, None, "forall", "range", "max"])
    answer = None
    if label in conditions:
        most, least = chances(whole, whole.where(conditions[label]))
        values = {"P>=1": least, "Pmax>0": most, "Pmax=?": most, "Pmin=?": least}[operator]
        values = [values[state] for state in whole.initial]
        verdicts = {"P>=1": all(v == 1 for v in values), "Pmax>0": all(v > 0 for v in values)}
        answer = verdicts.get(operator, values)
    if function is None:
        return text, answer
    if function == "max" and operator.endswith("?"):
        return f'filter(max, {text}, "init")', None if answer is None else [max(answer)]
    fits = function == ("range" if operator.endswith("?") else "forall")
    return f'filter({function}, {text}, "init")', answer if fits else None


def defined_twice(context, model, file, lines):
    """A name that the model defines is refused with both places."""
    number = len(model.read_text().splitlines())
    for line, at in (('label "base" = x = 1;', (number, 7)), ("const int x = 1;", (4 + len(context.case.players), 3))):
        file.write_text("\n".join([*lines, line, "Pmax=? [ F x = 1 ];", ""]))
        status, _, errors = context.program.run("reach", model, "--properties", file)
        places = f"listed.props:{len(lines) + 1}:", f"listed.prism:{at[0]}:{at[1]}"
        context.same(f"refusal of {line}", (3, []), (status, [place for place in places if place not in errors]))
    context.case.features.add("name defined twice")


# The functions of filters: whether they are over verdicts, and their answers.
AMONG = {
    "∀": (True, all),
    "∃": (True, any),
    "count": (True, lambda verdicts: [sum(verdicts)]),
    "min": (False, lambda values: [min(values)]),
    "max": (False, lambda values: [max(values)]),
    "sum": (False, lambda values: [sum(values)]),
    "avg": (False, lambda values: [sum(values) / len(values)]),
}


def jani_filters(context):
    """Properties of a JANI model with filters over some of its states."""
    whole = None if context.is_game or context.is_rare() else explore(context.source, "reachable", 3000)
    if whole is None or len(whole.values) > MOST_STATES:
        return
    draw, path = random.Random(context.case.seed), context.program.folder / "listed.jani"
    target = {state for state in whole.states if draw.random() < 0.3}
    properties, expected = [], []
    for name, _ in fresh(range(draw.randint(1, 6)), draw).values():
        expression, answer = filtered(draw, whole, target)
        properties.append({"name": name, "expression": expression})
        expected.append((f"{name}: {json.dumps(expression, ensure_ascii=False)}", answer))
    if len(properties) > 2 and draw.random() < 0.2:
        properties[1]["name"] = properties[0]["name"]
        expected[:2] = [(text, None) for text, _ in expected[:2]]
    model = jani_of(whole, properties)
    if len(whole.initial) == 1 and draw.random() < 0.4:
        model = with_array(model, next(iter(whole.initial)))
        context.case.features.add("JANI array")
    path.write_text(json.dumps(model))
    compare(context, expected, "reach", path, "--all-properties", *context.program.settings("engine", "threads"))
    context.case.features.add("JANI filter")


def filtered(draw, whole, target):
    """A filter over some states, with its answer; None where the program has none."""
    goal = {"op": "F", "exp": one_of(target)}
    if draw.random() < 0.2:
        sure = {"op": "≥", "left": {"op": "Pmin", "exp": goal}, "right": 1}
        target = {state for state, least in chances(whole, target)[1].items() if least == 1}
        goal = {"op": "F", "exp": sure}
    most, least = chances(whole, target)
    kind, values = draw.choice([("Pmax", most), ("Pmin", least)])
    expression, is_verdict = {"op": kind, "exp": goal}, draw.random() < 0.5
    if draw.random() < 0.2:
        expression = {"op": "-", "left": 1, "right": expression}
        values = {state: 1 - value for state, value in values.items()}
    if is_verdict:
        sign = draw.choice([*SIGNS])
        bound = draw.choice([Fraction(0), Fraction(1), near(draw.choice([*values.values()])), Fraction(draw.randint(1, 9), 10)])
        number = int(bound) if bound in (0, 1) else float(decimal(bound))
        expression = {"op": sign, "left": expression, "right": number}
        values = {state: COMPARE[SIGNS[sign]](value, bound) for state, value in values.items()}
    some = set(draw.sample([*whole.states], draw.randint(1, len(whole.states))))
    fun = draw.choice([*AMONG, "exists"])
    states, chosen = draw.choice([({"op": "initial"}, whole.initial), (True, whole.states), (one_of(some), some)])
    found = {"op": "filter", "fun": fun, "values": expression, "states": states}
    if draw.random() < 0.1:
        found["condition"] = True  # no key of the format
        return found, None
    if fun not in AMONG or AMONG[fun][0] is not is_verdict:
        return found, None
    return found, AMONG[fun][1]([values[state] for state in chosen])


def one_of(states, is_now=lambda state: equal("s", state)):
    """The condition that the state is one of some states."""
    found = False
    for state in sorted(states):
        now = is_now(state)
        found = {"op": "∨", "left": found, "right": now} if found else now
    return found


def equal(what, value):
    return {"op": "=", "left": what, "right": value}


def element(index):
    return {"op": "aa", "exp": "a", "index": index}


def in_array(state):
    """The condition that the elements of the array `a` are the digits of a state; for an even state, the place of the
    second one is computed from the first one."""
    place = 1 if state % 2 else {"op": "-", "left": 1, "right": element(0)}
    return {"op": "∧", "left": equal(element(0), state % 2), "right": equal(element(place), state // 2)}


def with_array(document, start):
    """The same model over an array, whose elements are the digits of the number of the state."""
    if isinstance(document, dict):
        if document.get("op") == "=" and document.get("left") == "s":
            return in_array(document["right"])
        if "assignments" in document:
            state = document["assignments"][0]["value"]
            digits = [{"ref": element(at), "value": digit} for at, digit in enumerate((state % 2, state // 2))]
            return document | {"assignments": digits}
        document = {key: with_array(value, start) for key, value in document.items() if key != "restrict-initial"}
        if document.get("name") == "s":
            document["name"] = "a"
            document["type"] = {"kind": "array", "base": document["type"]}
            document["initial-value"] = {"op": "av", "elements": [start % 2, start // 2]}
        return document | ({"features": ["derived-operators", "arrays"]} if "features" in document else {})
    return [with_array(item, start) for item in document] if isinstance(document, list) else document


def jani_of(whole, properties):
    """A model with one variable, the number of the state."""

    def edge(state, choice):
        to = [
            {
                "location": "l",
                "probability": {"exp": {"op": "/", "left": p.numerator, "right": p.denominator}},
                "assignments": [{"ref": "s", "value": successor}],
            }
            for successor, p in choice.to.items()
        ]
        return {"location": "l", "guard": {"exp": {"op": "=", "left": "s", "right": state}}, "destinations": to}

    edges = [edge(state, choice) for state in whole.states for choice in whole.choices[state]]
    high = max(1, len(whole.values) - 1)
    numbers = {"kind": "bounded", "base": "int", "lower-bound": 0, "upper-bound": high}
    return {
        "jani-version": 1,
        "name": "listed",
        "type": "mdp",
        "features": ["derived-operators"],
        "variables": [{"name": "s", "type": numbers}],
        "restrict-initial": {"exp": one_of(whole.initial)},
        "properties": properties,
        "automata": [{"name": "m", "locations": [{"name": "l"}], "initial-locations": ["l"], "edges": edges}],
        "system": {"elements": [{"automaton": "m"}]},
    }


def compare(context, expected, *command):
    """Compares the answers of a command, and its status. An answer is a verdict, or the values of initial states."""
    status, out, errors = context.program.run(*command, "--json")
    entries = json.loads(out)["properties"] if out else []
    if not context.same(f"properties of {command[0]}", (len(expected), ""), (len(entries), "" if out else errors)):
        return
    for (text, answer), entry in zip(expected, entries):
        is_open = entry["holds"] is None and "value" not in entry
        context.same(f"a reason against {text}", answer is None, is_open and bool(entry.get("reason")))
        if isinstance(answer, bool):
            context.same(f"holds of {text}", answer, entry["holds"])
        elif answer is not None and "value" in entry:
            value_of(context, text, answer, entry["value"])
    answers = [answer for _, answer in expected]
    is_no, is_unread = any(answer is False for answer in answers), all(answer is None for answer in answers)
    context.same("status of the properties", 1 if is_no else 3 if is_unread else 0, status)


ALL = {"property_files": property_files, "jani_filters": jani_filters}
