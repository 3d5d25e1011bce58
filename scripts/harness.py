"""Helpers shared by the scripts: running a program, finding Meliora, naming the machine, making grid worlds."""

from __future__ import annotations

import json
import os
import platform
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, NoReturn, Sequence

ROOT = Path(__file__).resolve().parent.parent
OBJECTIVE = re.compile(r"^\s*objective\s+\w+\s*=\s*F\s*(.+?)\s*;", re.MULTILINE | re.DOTALL)
OUT_OF_RESOURCES = 4


def stop(message: str) -> NoReturn:
    """Ends the script with a usage error."""
    print(f"{Path(sys.argv[0]).name}: {message}", file=sys.stderr)
    sys.exit(2)


@dataclass(frozen=True)
class Finished:
    """A process that has ended or was ended."""

    status: int
    stdout: str
    stderr: str
    seconds: float
    # User and system time of the process and of those it waited for: means something on a busy machine, too.
    cpu_seconds: float
    peak_bytes: int
    timed_out: bool


def run(command: Sequence[str], timeout: float) -> Finished:
    """Runs a command as a process group of its own; kills the group after `timeout` seconds."""
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
        start = time.perf_counter()
        child = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=out, stderr=err, text=True, start_new_session=True
        )
        expired = threading.Event()
        timer = threading.Timer(timeout, _end, (child.pid, expired))
        timer.start()
        try:
            _, wait_status, usage = os.wait4(child.pid, 0)
        except BaseException:
            _end(child.pid, expired)
            raise
        finally:
            timer.cancel()
        child.returncode = os.waitstatus_to_exitcode(wait_status)
        seconds = time.perf_counter() - start
        scale = 1 if sys.platform == "darwin" else 1024
        peak_bytes, cpu = usage.ru_maxrss * scale, usage.ru_utime + usage.ru_stime
        return Finished(child.returncode, _read(out), _read(err), seconds, cpu, peak_bytes, expired.is_set())


def _end(group: int, expired: threading.Event) -> None:
    expired.set()
    try:
        os.killpg(group, signal.SIGKILL)
    except ProcessLookupError:
        pass


def _read(file: IO[str]) -> str:
    file.seek(0)
    return file.read()


def find_meliora(named: str | None) -> str:
    """The binary: the one named, else the release build of this checkout, else the one on the path."""
    built = ROOT / "target" / "release" / "meliora"
    found = shutil.which(named or (str(built) if built.exists() else "meliora"))
    if found is None:
        stop("no meliora binary: build it with `cargo build --release`, or name one with --meliora")
    return found


def version(meliora: str) -> str:
    """The output of `meliora --version`, with the commit of the checkout that the script is in."""
    said = ", ".join(run([meliora, "--version"], 10.0).stdout.split("\n")).strip(", ") or "unknown"
    try:
        commit = run(["git", "-C", str(ROOT), "describe", "--always", "--dirty"], 10.0).stdout.strip()
    except FileNotFoundError:
        commit = ""
    return f"{said} ({commit})" if commit else said


def machine() -> str:
    """Processor, cores and memory in one line."""
    gib = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    return f"{_processor()}, {os.cpu_count()} cores, {gib:.0f} GiB, {platform.system()}"


def _processor() -> str:
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    except OSError:
        return platform.processor() or platform.machine()
    found = re.search(r"^model name\s*:\s*(.+)$", text, re.MULTILINE)
    return found[1] if found else platform.machine()


def json_object(text: str) -> dict[str, Any] | None:
    """Returns the JSON object that a program wrote; None if it wrote none."""
    try:
        read = json.loads(text)
    except json.JSONDecodeError:
        return None
    return read if isinstance(read, dict) else None


def complaint(finished: Finished) -> str:
    """Returns the reason for the failure of a run, in one line."""
    if finished.timed_out:
        return f"stopped after {finished.seconds:.0f} s"
    read = json_object(finished.stdout) or {}
    error = read.get("error") or read
    if isinstance(error, dict) and "message" in error:
        return str(error["message"]).splitlines()[0]
    lines = finished.stderr.strip().splitlines()
    said = next((line for line in lines if line.startswith("error")), lines[-1] if lines else "no message")
    return f"exit status {finished.status}: {said}"


def read_json(path: Path) -> Any:
    """A JSON file of the corpus."""
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        stop(f"cannot read {path}: {error.strerror}")
    except json.JSONDecodeError as error:
        stop(f"{path}:{error.lineno}:{error.colno}: {error.msg}")


def integers(text: str) -> list[int]:
    """An option's value such as 16,32,64."""
    return [int(part) for part in text.split(",")]


@dataclass(frozen=True)
class World:
    """One member of the family of grid worlds."""

    size: int
    items: int
    model: Path
    preferences: Path
    targets: tuple[str, ...]

    @property
    def name(self) -> str:
        return f"gridworld {self.size}x{self.size}, {self.items} items"


def gridworld(meliora: str, size: int, items: int, seed: int, folder: Path) -> World:
    """Lets Meliora write a grid world into a folder of its own."""
    home = folder / f"gridworld-{size}-{items}-{seed}"
    home.mkdir(parents=True, exist_ok=True)
    numbers = {"--rows": size, "--cols": size, "--items": items, "--seed": seed}
    options = [text for name, value in numbers.items() for text in (name, str(value))]
    finished = run([meliora, "generate", "gridworld", *options, "--force", "--out", str(home / "world")], 60.0)
    if finished.status != 0:
        stop(f"`meliora generate gridworld` failed: {complaint(finished)}")
    model, preferences = (_only(home, suffix) for suffix in (".prism", ".pref"))
    targets = OBJECTIVE.findall(preferences.read_text(encoding="utf-8"))
    return World(size, items, model, preferences, tuple(targets))


def _only(folder: Path, suffix: str) -> Path:
    found = sorted(folder.rglob(f"*{suffix}"))
    if len(found) != 1:
        stop(f"expected one {suffix} file of `meliora generate gridworld` in {folder}, found {len(found)}")
    return found[0]
