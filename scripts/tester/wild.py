"""The checks of a case once more, asked about the same model in JANI, whose actions, values and labels have wild names:
with blanks, quotes, commas and signs, or like numbers and keywords."""

import json
import random
from dataclasses import replace
from importlib import import_module

from tester import jani, lists, regions
from tester.context import Context
from tester.names import LABELS, UNQUOTED, WORDS, names_for
from tester.program import Program

# Not all checks can be asked: each case takes some.
GROUPS = "checks promises pursuits induced valued questions tables whole together places dumps pages policies"
AGAIN = {name: check for group in GROUPS.split() for name, check in import_module(f"tester.{group}").ALL.items()}
AGAIN |= {"reach": regions.reach, "jointly": regions.together, "compare": regions.compare}
AGAIN |= {"property_files": lists.property_files}
# So choices without an action, self-loops, and one of several choices with a label are called.
ACTIONS = sorted(WORDS - {"m#1", "deadlock", "a(m#1)"})
FIRST, SOME = ("model", "check", "initial", "policies"), 3


class Wild(Program):
    """The command about the model in JANI."""

    def __init__(self, program, case, document, labels):
        self.binary, self.folder, self.case, self.asked = program.binary, program.folder, case, program.asked
        self.model, self.prefs, self.labels = program.folder / "wild.jani", program.folder / "wild.pref", labels
        self.model.write_text(json.dumps(document))
        self.prefs.write_text(self.text(case.preferences_text()))

    def text(self, formula):
        return jani.in_labels(formula, self.labels)


def wild(context):
    """For some cases, some checks with a model in JANI."""
    case, draw = context.case, random.Random(context.case.seed)
    if context.is_game or context.is_rare() or draw.random() < 0.5:
        return
    other = in_jani(context, draw)
    if other is None:
        return
    case.features.add("wild names")
    some = draw.sample([name for name in AGAIN if name not in FIRST], SOME)
    for name in (*FIRST, *some):
        other.check = f"wild {name}"
        AGAIN[name](other)
        if other.differences:
            break
    context.compared[context.check] = sum(other.compared.values())
    for found in other.differences:
        context.differences.append(replace(found, check="wild", what=f"{found.what} ({found.check})"))


def in_jani(context, draw):
    """The context of the same case in JANI; None if its initial states cannot be written."""
    source = context.source
    # Those of actions may belong to edges that do not know the location.
    of_states = [name for name, items in source.rewards.items() if all(action is None for action, _, _ in items)]
    rewards = {name: form for name, (_, form) in names_for(of_states, draw, LABELS, UNQUOTED).items()}
    settings = {**context.case.settings, "reward": rewards.get(context.case.settings["reward"], "steps")}
    case = replace(context.case, settings=settings, rewards=[], labels=[])
    locations = names_for(range(case.size + 1), draw)
    actions = names_for(source.alphabet, draw, ACTIONS)
    conditions = dict.fromkeys(jani.CONDITION.findall(case.preferences_text()))
    # Rewards and labels are variables in JANI.
    words = names_for(conditions, draw, LABELS, UNQUOTED, rewards.values())
    labels = {condition: name for condition, (name, _) in words.items()}
    raw = {word: name for word, (name, _) in (locations | actions).items()}
    properties = [name for name in labels.values() if draw.random() < 0.3]
    named = {name: f"flag {at}" for at, name in enumerate(properties)}
    holds = {named.get(name, name): source.compile(condition) for condition, name in labels.items()}
    names = [raw[x] for x in range(case.size + 1)], {label: raw[label] for label in actions}, rewards
    document = jani.written(source, names, holds, [jani.reaching(name, flag) for name, flag in named.items()])
    if document is None:
        return None
    program = Wild(context.program, case, document, labels)
    shown = [locations[x][1] for x in range(case.size + 1)], {label: form for label, (_, form) in actions.items()}
    return Context(case, program, jani.renamed(source, *shown, rewards))


ALL = {"wild": wild}
