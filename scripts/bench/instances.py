"""Collections of models, and the questions about their instances."""

from __future__ import annotations

import hashlib
import json
import math
import re
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import zip_longest
from pathlib import Path
from typing import Any, Callable, Iterator

import harness

HALVES = ("tuned", "held-out")
PLAN = 'Pmax>=1 [ F "goal" ]'
KINDS = ("check", "regions", "property", "states", "plan", "values")
WORD = re.compile(r"[A-Za-z_]\w*")


@dataclass(frozen=True)
class Instance:
    """A question about a model. Its text is a target of `regions`, a formula of `property`, else empty."""

    collection: str
    name: str
    files: tuple[Path, ...]
    kind: str
    text: str = ""
    constants: str = ""
    coalition: str = ""  # of a game: the players that want to reach the target
    expected: tuple[Fraction | float, bool] | None = None  # a known value, and whether it is exact
    source: Path | None = None  # the file that a peer of Boolean networks reads

    @property
    def key(self) -> str:
        """The name of the question in files of results."""
        return f"{self.name} {self.kind} {self.text}".rstrip()

    @property
    def hash(self) -> bytes:
        return hashlib.sha256(self.name.encode()).digest()

    @property
    def half(self) -> str:
        return HALVES[self.hash[0] % 2]


def read(source: str, root: Path | None, folder: Path, meliora: str) -> list[Instance]:
    """The instances of one collection, [NAME=]PATH or [NAME=]grids:SIZES:ITEMS[:SEEDS] or
    [NAME=]family:MODEL:CONSTANT=VALUES. Models that are made are written to a folder."""
    name, _, text = source.rpartition("=") if ":" not in source.partition("=")[0] else ("", "", source)
    if text.startswith("family:") or text.startswith("grids:"):
        make = family if text.startswith("family:") else grids
        return list(make(name or text.partition(":")[0], text.split(":")[1:], folder, meliora))
    path = Path(text)
    name = name or path.stem
    if path.is_dir():
        readers: list[Callable[..., Iterator[Instance]]] = [worlds, networks, problems, benchmark_set]
        return [instance for reader in readers for instance in reader(name, path, folder)]
    return list(listed(name, path, root))


def family(name: str, parts: list[str], _folder: Path, _meliora: str) -> Iterator[Instance]:
    """Models of this family with their preferences, by the values of a constant."""
    model, constant, values = Path(parts[0]), *":".join(parts[1:]).split("=")
    for value in values.split(","):
        yield Instance(name, f"{model.stem} {constant}={value}", (model, model.with_suffix(".pref")), "check", "", f"{constant}={value}")


def grids(name: str, parts: list[str], folder: Path, meliora: str) -> Iterator[Instance]:
    """Random grid worlds."""
    sizes, items, seeds = (harness.integers(part) for part in [*parts, "1"][:3])
    for number in items:
        for size in sizes:
            for seed in seeds:
                world = harness.gridworld(meliora, size, number, seed, folder)
                called = f"{size} x {size}, {number} items" + (f", seed {seed}" if seed != 1 else "")
                yield Instance(name, called, (world.model, world.preferences), "check", world.targets[0])


def worlds(name: str, path: Path, _folder: Path) -> Iterator[Instance]:
    """Models with preferences of the same name, or with a label `goal`."""
    for model in sorted(path.glob("*.prism")):
        preferences = model.with_suffix(".pref")
        if preferences.exists():
            yield Instance(name, model.stem, (model, preferences), "check")
        else:
            yield Instance(name, model.stem, (model,), "property", PLAN)


def networks(name: str, path: Path, folder: Path) -> Iterator[Instance]:
    """Boolean networks. The name is the number in the path, else that of the file."""
    for file in sorted(path.rglob("*.bnet")):
        number = re.search(r"\bid-(\d+)\b", str(file.relative_to(path)))
        called = number[1] if number else file.stem
        text, last = network(file.read_text(encoding="utf-8"))
        if last:
            model = folder / f"network-{called}.prism"
            model.write_text(text, encoding="utf-8")
            yield Instance(name, f"network-{called}", (model,), "states", f"n_{last}", source=file)


def network(text: str) -> tuple[str, str]:
    """A network in PRISM's language, and its last variable. Initially inputs, which are variables without a function,
    have any value, and all others are false. Names get a prefix, so that none of them is a keyword."""
    functions = {}
    for line in text.splitlines():
        target, comma, function = (part.strip() for part in line.partition("#")[0].partition(","))
        if comma and (target, function) != ("targets", "factors"):
            functions[target] = function
    used = {word: None for function in functions.values() for word in WORD.findall(function)}
    inputs = [word for word in used if word not in functions and word not in ("true", "false")]
    renamed = {name: f"n_{name}" for name in [*inputs, *functions]}

    def formula(text: str) -> str:
        text = re.sub(r"(?<!\w)[01](?!\w)", lambda found: {"0": "false", "1": "true"}[found[0]], text)
        return WORD.sub(lambda found: renamed.get(found[0], found[0]), text)

    lines = ["mdp", "module network", *(f"  {name} : bool;" for name in renamed.values())]
    for name, function in functions.items():
        value = formula(function)
        lines.append(f"  [] ({value}) != {renamed[name]} -> ({renamed[name]}'=({value}));")
    first = " & ".join(f"!{renamed[name]}" for name in functions) or "true"
    return "\n".join([*lines, "endmodule", f"init {first} endinit", ""]), next(reversed(functions), "")


def problems(name: str, path: Path, _folder: Path) -> Iterator[Instance]:
    """Planning problems, one folder per domain, as the public collection AI-Planning/fond-domains has them."""
    for domain in sorted({file.parent for file in path.rglob("*.pddl")}):
        for files in paired(domain):
            yield Instance(name, f"{domain.relative_to(path)} {files[-1].stem}", files, "plan")


def paired(folder: Path) -> Iterator[tuple[Path, ...]]:
    """The files of each problem of a folder: its domain and itself, or itself alone. The domain is in the same file, or
    in the one that its name or `(:domain NAME)` tells; a corrected version has `fixed` in its name."""
    texts = {path: re.sub(r";[^\n]*", "", path.read_text(errors="replace")).lower() for path in sorted(folder.glob("*.pddl"))}

    def named(text: str, key: str) -> str | None:
        found = re.search(r"\(\s*" + key + r"\s+([^\s()]+)", text)
        return found[1] if found else None

    domains = {path: called for path, text in texts.items() if (called := named(text, "domain"))}
    for path, text in texts.items():
        if named(text, "problem") and path in domains:
            yield (path,)
        elif named(text, "problem") and domains:
            wanted, own = named(text, ":domain"), re.findall(r"\d+", path.stem)

            def rank(domain: Path) -> tuple[Any, ...]:
                numbers = re.findall(r"\d+", domain.stem)
                near = 0 if numbers == own else 1 if not numbers else 2
                plain = domain.name != "domain.pddl"
                return domains[domain] != wanted, near, "fixed" not in domain.name, plain, len(domain.name), domain.name

            yield min(domains, key=rank), path


def benchmark_set(name: str, path: Path, _folder: Path) -> Iterator[Instance]:
    """The Quantitative Verification Benchmark Set: its properties with a value, in JANI."""
    for index in sorted(path.glob("*/*/index.json")):
        about = json.loads(index.read_text(encoding="utf-8-sig"))
        kinds = {p["name"]: p["type"] for p in about["properties"]}
        for file in about["files"]:
            model = index.parent / file["file"]
            for setting in file.get("open-parameter-values", [{}]) if model.exists() else []:
                constants = ",".join(f"{v['name']}={str(v['value']).lower()}" for v in setting.get("values", []))
                called = model.stem + (f"[{constants}]" if constants else "")
                for result in setting.get("results", file.get("results", [])):
                    expected = reference(result["value"])
                    if expected and kinds.get(result["property"]) in ("prob-reach", "exp-reward"):
                        yield Instance(name, called, (model,), "property", result["property"], constants, "", expected)


def reference(value: Any) -> tuple[Fraction | float, bool] | None:
    """A result and whether it is exact; truth values are not numbers."""
    if isinstance(value, dict) and "num" in value and "den" in value:
        return Fraction(int(value["num"]), int(value["den"])), True
    value = value.get("approx") if isinstance(value, dict) else value
    if value == "inf":
        return math.inf, True
    return None if isinstance(value, bool) or not isinstance(value, (int, float)) else (float(value), False)


def listed(name: str, path: Path, root: Path | None) -> Iterator[Instance]:
    """The instances of a list in JSON: of objects with `id`, `model`, perhaps `constants` and `coalition`, and with
    `target`, `property`, `targets` (of which the last one is asked for), or `preferences`."""
    for entry in harness.read_json(path):
        model, constants = (root or path.parent) / entry["model"], entry.get("constants") or ""
        if "preferences" in entry:
            yield Instance(name, entry["id"], (model, (root or path.parent) / entry["preferences"]), "check", "", constants)
        elif "property" in entry:
            yield Instance(name, entry["id"], (model,), "property", entry["property"], constants)
        else:
            target = entry.get("target") or (entry["targets"][-1]["target"] if entry.get("targets") else "true")
            yield Instance(name, entry["id"], (model,), "regions", target, constants, entry.get("coalition", ""))


def asked(instance: Instance, kind: str, steps: int | None) -> list[Instance]:
    """The instance with another kind of question. A target gives two properties."""
    if not kind or kind == instance.kind:
        return [instance]
    if kind == "property":
        within = "" if steps is None else f"<={steps}"
        texts = [f"{best}=? [ F{within} ({instance.text}) ]" for best in ("Pmax", "Pmin")]
        text = instance.files[0].read_text(encoding="utf-8", errors="replace")
        if steps is not None and (rewards := re.search(r'^\s*rewards\s+"(\w+)"', text, re.MULTILINE)):
            texts.append(f'R{{"{rewards[1]}"}}max=? [ C<={steps} ]')
        return [replace(instance, kind=kind, text=text) for text in texts]
    return [replace(instance, kind=kind, files=instance.files[:1] if kind == "regions" else instance.files)]


def in_turns(collections: list[list[Instance]]) -> list[Instance]:
    """The instances of all collections in turns, each in the order of the hash: every beginning is a random part of all."""
    ordered = (sorted(own, key=lambda instance: instance.hash) for own in collections)
    return [instance for row in zip_longest(*ordered) for instance in row if instance is not None]
