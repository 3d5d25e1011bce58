"""Names that PRISM's language cannot have: shown by every command, written in every format, and read back."""

import csv
import gzip
import io
import json
import random
import re
import tarfile
from struct import pack, unpack

from tester.exchange import by_labels
from tester.program import cell

# Characters that terminals do not display, as they are shown.
HIDDEN = {
    "\x1b": "\\u{1b}",
    "\n": "\\n",
    "\r": "\\r",
    "\t": "\\t",
    "\x07": "\\u{7}",
    "\x9b": "\\u{9b}",
    "\u202e": "\\u{202e}",
    "\u2066": "\\u{2066}",
    "\u2028": "\\u{2028}",
    "\ufeff": "\\u{feff}",
    "\U000e0041": "\\u{e0041}",
}
# Names that could be mistaken for something else.
WORDS = {"1", "0", "-1", "007", "1e3", "0.5", "true", "false", "null", "nan", "init", "deadlock", "module", "F", "*"}
WORDS |= {"x=1", "m#1", "unbounded", "settled", "uniform", "a|b", "a+b", "a(m#1)", "#", "//", "/* */", "é", "状態"}
LABELS = sorted(WORDS - {"init", "deadlock"})  # these mean something else in properties
PARTS = [*HIDDEN, *" =-+@'\"},%[]\\éa1", "[2J", "<b>", "%20", "go"]
# A name in quotes in preferences has none, and is displayed.
UNQUOTED = [part for part in PARTS if part not in HIDDEN and part != '"']


def outside(context):
    """The actions of a model get other names. Everything else stays, and no name is an order to a terminal."""
    if context.case.kind == "dtmc":
        return
    program, draw = context.program, random.Random(context.case.seed)
    sources = {"umb": renamed_archive, "explicit": renamed_text, "drn": renamed_drn}
    source = list(sources)[context.case.seed % (2 if context.is_game else 3)]
    suffix = {"explicit": "tra"}.get(source, source)
    report = program.about("export", "--format", source, "--out", program.folder / "plain")
    counts = {label["name"]: label["states"] for label in report["labels"]}
    own, prefs = program.folder / "own.pref", program.folder / "names.pref"
    own.write_text(by_labels(context, counts))
    named = names_for((name for name in counts if name != "deadlock"), draw, LABELS, UNQUOTED)
    labels = {name: form for name, (_, form) in named.items()}
    prefs.write_text(re.sub(r'"(\w+)"', lambda found: f'"{labels[found[1]]}"', own.read_text()))
    plain, wild = program.folder / "plain" / f"model.{suffix}", program.folder / f"wild.{suffix}"
    names = sources[source](plain, wild, draw, labels)
    options = program.settings("scope", "safety", "coalition")
    before, found = (program.ask("check", *paths, *options) for paths in ((plain, own), (wild, prefs)))
    expected = said(before, names)
    context.same(f"actions of {source} with other names", expected, said(found, {}))
    for what in ("counts", "classes", "sasi", "spi"):
        context.same(f"{what} of {source} with other names", before[what], found[what])
    read_back(context, wild, prefs, options, expected, found["counts"])
    dumped(context, wild, prefs, options)
    shown(context, wild, prefs, options, set(names.values()))


def fresh(words, draw, parts=PARTS, others=()):
    """Names for some words, none of which is among the others, each with the form in which it is shown."""
    names, taken = {}, set(others)
    for word in words:
        name, form = "", ""
        while not name or form in taken:
            name = "".join(draw.choices(parts, k=draw.randint(1, 5)))
            form = "".join(HIDDEN.get(c, c) for c in name)
        taken.add(form)
        names[word] = (name, form)
    return names


def names_for(words, draw, like=tuple(sorted(WORDS)), parts=PARTS, others=()):
    """Different names for some words, none of which is among the others, each with the form in which it is shown."""
    words = list(words)
    found = fresh(words, draw, parts, others)
    plain = draw.sample(like, min(len(words), len(like)))
    taken = {form for _, form in found.values()} | set(others)
    for word, name in zip(words, plain):
        if name not in taken and draw.random() < 0.5:
            found[word] = (name, name)
    return found


def encoded(name):
    """A name as a word of PRISM's and Storm's explicit formats."""
    breaks = HIDDEN.keys() | set(" %[]")
    return "".join("".join(f"%{b:02X}" for b in c.encode()) if c in breaks else c for c in name)


def renamed_text(plain, wild, draw, labels):
    first, *lines = plain.read_text().splitlines()
    rows = [line.rsplit(" ", 1) for line in lines]
    names = fresh(dict.fromkeys(word for _, word in rows), draw)
    wild.write_text("\n".join([first, *(f"{row} {encoded(names[word][0])}" for row, word in rows)]) + "\n")
    wild.with_suffix(".sta").write_text(plain.with_suffix(".sta").read_text())
    first, rest = plain.with_suffix(".lab").read_text().split("\n", 1)
    first = re.sub(r'"(\w+)"', lambda found: f'"{labels.get(found[1], found[1])}"', first)
    wild.with_suffix(".lab").write_text(f"{first}\n{rest}")
    return {word: form for word, (_, form) in names.items()}


def renamed_drn(plain, wild, draw, labels):
    lines = [line.split(" ", 2) if line.startswith("\taction ") else [line] for line in plain.read_text().splitlines()]
    names = fresh(dict.fromkeys(line[1] for line in lines if len(line) > 1), draw)
    named = (" ".join([line[0], *(encoded(names[word][0]) for word in line[1:2]), *line[2:]]) for line in lines)
    wild.write_text("\n".join(with_labels(line, labels) for line in named) + "\n")
    return {word: form for word, (_, form) in names.items()}


def with_labels(line, labels):
    """A line of a DRN file with other labels."""
    if not line.startswith("state "):
        return line
    return " ".join(f'"{labels[word]}"' if word in labels else word for word in line.split(" "))


def renamed_archive(plain, wild, draw, labels):
    mapping, strings = "actions/choices/string-mapping.bin", "actions/choices/strings.bin"
    with tarfile.open(plain) as tar:
        files = {member.name: tar.extractfile(member).read() for member in tar.getmembers()}
    index = json.loads(files["index.json"])
    for proposition in index["annotations"]["aps"].values():
        proposition["alias"] = labels.get(proposition["alias"], proposition["alias"])
    files["index.json"] = json.dumps(index).encode()
    ends = unpack(f"<{len(files[mapping]) // 8}Q", files[mapping])
    words = [files[strings][a:b].decode() for a, b in zip(ends, ends[1:])]
    names = fresh(words, draw)
    texts = [names[word][0].encode() for word in words]
    files[strings] = b"".join(texts)
    files[mapping] = pack(f"<{len(ends)}Q", *(sum(map(len, texts[:at])) for at in range(len(ends))))
    with gzip.open(wild, "wb") as packed, tarfile.open(fileobj=packed, mode="w") as tar:
        for name, content in files.items():
            member = tarfile.TarInfo(name)
            member.size = len(content)
            tar.addfile(member, io.BytesIO(content))
    return {word: form for word, (_, form) in names.items()}


def said(report, names):
    """The permitted actions of the initial states."""
    kinds = ("sasi_actions", "spi_actions")
    safe = [entry for entry in report["initial"] if "unsafe" not in entry]
    return sorted([sorted(names.get(a, a) for a in entry[kind]) for kind in kinds] for entry in safe)


def read_back(context, wild, prefs, options, expected, counts):
    """Files that are written have the names and the choices."""
    program = context.program
    for written, suffix in (("explicit", "tra"), ("umb", "umb"), *([] if context.is_game else [("drn", "drn")])):
        folder = program.folder / f"again_{written}"
        report = program.ask("export", wild, prefs, *options, "--format", written, "--out", folder)
        context.same(f"choices of {written}", counts["choices"], report["choices"])
        labels = program.folder / "again.pref"
        labels.write_text(by_labels(context, {label["name"]: label["states"] for label in report["labels"]}))
        again = program.ask("check", folder / f"model.{suffix}", labels, *options)
        context.same(f"actions read back from {written}", expected, said(again, {}))


def dumped(context, wild, prefs, options):
    """A dump is accepted by `verify` and `query`."""
    program, folder = context.program, context.program.folder / "wild_dump"
    program.ask("export", wild, prefs, *options, "--out", folder)
    listed = program.ask("query", folder, "choices", "--list", "5")
    context.same("choices of a dump with other names", True, bool(listed["states"]))
    checked = program.ask("verify", folder, wild, prefs, *program.settings("coalition"))
    context.same("the check of a dump with other names", True, checked["accepted"])


def shown(context, wild, prefs, options, forms):
    """No command writes a hidden character, and no cell of a table is run by a spreadsheet."""
    program = context.program
    kind = ("--kind", "spi")
    dump = program.folder / "wild_dump"
    commands = [
        ("check", wild, prefs, *options),
        ("strategy", wild, prefs, *options, *kind),
        ("simulate", wild, prefs, *options, *kind, "--runs", "10"),
        ("info", wild),
        ("query", dump, "choices", "--list", "5"),
        ("query", dump, "choices", "--csv", "-"),
        *([] if context.is_game else [("values", wild, prefs, *options)]),
    ]
    for command in commands:
        for more in ((), ("--color", "always")):
            status, out, errors = program.run(*command, *more)
            text = out + errors
            for colour in ("0", "1", "2", "32", "1;33", "1;31", "33", "94", "96"):
                text = text.replace(f"\x1b[{colour}m", "")
            hidden = {c for c in text if c != "\n" and c in HIDDEN}
            context.same(f"hidden characters of `{command[0]}` with status {status}", (0, set()), (status, hidden))
    _, out, _ = program.run("strategy", wild, prefs, *options, *kind, "--csv", "-")
    cells = {row["action"] for row in csv.DictReader(io.StringIO(out))}
    context.same("actions of a table with other names", set(), cells - set(map(cell, forms)) - {"deadlock"})


ALL = {"names": outside}
