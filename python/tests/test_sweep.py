"""Sweeps over constants: in this process, resumed, and on Dask with workers that are killed."""

from __future__ import annotations

import csv
import itertools
import math
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

import meliora
from conftest import MODELS, ROOT, TOY, WISHES
from meliora import _sweep

CHAIN = (MODELS / "chain.prism", MODELS / "chain.pref")
#: The columns that differ from run to run.
MEASURED = ("seconds", "peak_nodes", "peak_rss_bytes")
#: A counter to N that steps back by K.
MODEL = """mdp
const int N;
const int K;
module m
  x : [0..N] init 0;
  [a] x<N -> 0.5: (x'=x+1) + 0.5: (x'=max(x-K,0));
  [b] x>0 -> (x'=0);
endmodule
"""
PREFERENCES = "objective A = F x=N;\nobjective B = F x=1;\nprefer A > B;\n"


def records(table: Any) -> list[dict[str, Any]]:
    """The rows of a table as dictionaries, without measured values; None for unknown values."""
    rows = table if isinstance(table, list) else table.astype(object).where(table.notna(), None).to_dict("records")
    return [{name: value for name, value in row.items() if name not in MEASURED} for row in rows]


def lines(path: Path) -> list[dict[str, str]]:
    """The rows of a file, without measured values."""
    with path.open(encoding="utf-8", newline="") as file:
        return [{name: cell for name, cell in row.items() if name not in MEASURED} for row in csv.DictReader(file)]


def test_rows_are_direct_analyses() -> None:
    rows = records(meliora.sweep(MODEL, PREFERENCES, N=range(2, 5), K=(1, 2)))
    assert [(row["N"], row["K"]) for row in rows] == [(2, 1), (2, 2), (3, 1), (3, 2), (4, 1), (4, 2)]
    for row in rows:
        constants = {"N": row["N"], "K": row["K"]}
        found = meliora.Model.from_string(MODEL, constants=constants).check(meliora.Preferences.from_string(PREFERENCES))
        assert found.counts is not None
        assert (row["states"], row["choices"]) == (found.counts["states"], found.counts["choices"])
        for kind, levels in (("sasi", found.sasi), ("spi", found.spi)):
            assert levels is not None
            counts = [row.get(f"{kind}_{k}") for k in range(1, 17)]
            assert counts == [*levels.counts, *[None] * (16 - len(levels))]
            assert row[f"{kind}_levels"] == len(levels)
            assert row[f"{kind}_rank"] == levels.rank(found.model.state())
        assert (row["status"], row["reason"]) == ("done", None)


@pytest.mark.parametrize("engine", ["auto", "symbolic", "explicit"])
def test_a_table_of_pandas_and_a_list_have_the_same_rows(engine: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    pandas = pytest.importorskip("pandas")

    def sweep() -> Any:
        return meliora.sweep(*CHAIN, N=[2, 4], engine=engine, safety="action", max_level=3)

    table = sweep()
    assert isinstance(table, pandas.DataFrame) and str(table["sasi_2"].dtype) == "Int64"
    monkeypatch.setitem(sys.modules, "pandas", None)
    plain = sweep()
    assert isinstance(plain, list) and records(plain) == records(table)
    assert [name for name in plain[0] if name.startswith("spi")][:3] == ["spi_1", "spi_2", "spi_unbounded"]


def test_a_table_has_no_columns_without_values() -> None:
    rows = records(meliora.sweep(MODEL, PREFERENCES, N=range(2, 5), K=(1, 2)))
    for name in rows[0]:
        assert name == "reason" or any(row[name] is not None for row in rows), name
    assert "sasi_16" not in rows[0] and "status" in rows[0]


def test_a_sweep_of_properties_has_a_column_for_each() -> None:
    asked = ["Pmax=? [ F x=N ]", "P>=1 [ F x=N ]", 'P=? [ F "nowhere" ]']
    rows = records(meliora.sweep(MODEL, properties=asked, N=[2, 3], K=1))
    for row in rows:
        reached = meliora.Model.from_string(MODEL, constants={"N": row["N"], "K": 1}).explore()
        assert row["states"] == reached.states.count()
        value = reached.reach(asked[0]).value
        assert value is not None and row[asked[0]] == pytest.approx(value[0])
        assert row[asked[1]] is reached.reach(asked[1]).holds
        assert row[asked[2]] == "not answered" and "nowhere" in str(row["reason"])
    named = records(meliora.sweep(MODEL, properties={"best": asked[0]}, N=2, K=1))
    assert named[0]["best"] == rows[0][asked[0]] and list(named[0])[:2] == ["N", "K"]


def test_properties_of_a_sweep_are_those_of_the_command_line(tmp_path: Path) -> None:
    meliora_command = command()
    if meliora_command is None:
        pytest.skip("needs the command, built by cargo")
    (tmp_path / "m.prism").write_text(MODEL, encoding="utf-8")
    asked = ["Pmax=? [ F x=N ]", "P>=1 [ F x=N ]", "Pmin=? [ F x=1 ]"]
    ours, theirs = tmp_path / "ours.csv", tmp_path / "theirs.csv"
    meliora.sweep(tmp_path / "m.prism", properties=asked, csv=ours, N=[2, 3], K=1)
    words = [word for text in asked for word in ("--property", text)]
    arguments = [meliora_command, "reach", str(tmp_path / "m.prism"), *words, "-c", "N={2,3},K=1", "--csv", str(theirs)]
    subprocess.run(arguments, check=False, capture_output=True)
    assert lines(ours) == lines(theirs) and len(lines(ours)) == 2


@pytest.mark.parametrize("asked", ["Pmax=? [ F x=N ]", "Pmax>=1 [ F x=N ]", "P>=1 [ G F x=1 ]", "Pmin=? [ F<=3 x=N ]"])
def test_a_sweep_of_one_property_has_the_file_of_the_command(asked: str, tmp_path: Path) -> None:
    """The command's file has the sizes of the regions, which were missing here: neither continued a file of the other."""
    meliora_command = command()
    if meliora_command is None:
        pytest.skip("needs the command, built by cargo")
    (tmp_path / "m.prism").write_text(MODEL, encoding="utf-8")
    ours, theirs = tmp_path / "ours.csv", tmp_path / "theirs.csv"
    sweep_of = [meliora_command, "reach", str(tmp_path / "m.prism"), "--property", asked]
    subprocess.run([*sweep_of, "-c", "N={2,3},K=1", "--csv", str(theirs)], check=False, capture_output=True)
    meliora.sweep(tmp_path / "m.prism", properties=[asked], csv=ours, N=[2, 3], K=1)
    assert lines(ours) == lines(theirs) and len(lines(ours)) == 2
    meliora.sweep(tmp_path / "m.prism", properties=[asked], csv=theirs, N=[2, 3, 4], K=1, resume=True)
    again = [*sweep_of, "-c", "N={2,3,4},K=1", "--csv", str(ours), "--resume"]
    subprocess.run(again, check=False, capture_output=True)
    assert lines(ours) == lines(theirs) and len(lines(ours)) == 3


def test_fractions_are_exact_values(tmp_path: Path) -> None:
    model = "mdp\nconst double p;\nmodule m\n x : [0..1];\n [] x=0 -> p: (x'=1) + (1-p): true;\nendmodule\n"
    thirds = [Fraction(1, 3), Fraction(2, 3), Fraction(1)]
    rows = records(meliora.sweep(model, properties=["Pmax=? [ F<=1 x=1 ]"], p=thirds, csv=tmp_path / "p.csv"))
    assert [row["p"] for row in rows] == [Fraction(1, 3), Fraction(2, 3), 1]
    assert [row["p"] for row in lines(tmp_path / "p.csv")] == ["1/3", "2/3", "1"]
    assert all(row["status"] == "done" for row in rows)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "needs either preferences or `properties`"),
        ({"preferences": PREFERENCES, "properties": ["P>0 [ F x=1 ]"]}, "needs either preferences or `properties`"),
        ({"properties": "P>0 [ F x=1 ]"}, "a list of properties"),
        ({"properties": []}, "there are no properties"),
        ({"properties": ["P>0 [ F x=1 ]"], "max_level": 2}, "properties have none"),
    ],
)
def test_a_sweep_asks_one_kind_of_question(options: dict[str, Any], message: str) -> None:
    with pytest.raises(meliora.UsageError, match=message):
        meliora.sweep(MODEL, N=2, K=1, **options)


def test_numbers_beyond_64_bits_stay_exact() -> None:
    modules = (f"module m{i}\n x{i} : [0..N];\n [] true -> (x{i}'=0);\nendmodule\n" for i in range(4))
    model = "mdp\nconst int N;\n" + "".join(modules)
    (row,) = records(meliora.sweep(model, "objective A = F x0=0;\n", N=2**20 - 2, scope="all", engine="symbolic"))
    assert row["states"] == (2**20 - 1) ** 4 > 2**64 - 2**48


def command() -> str | None:
    """The command line, if it is built."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    built = [target / kind / "meliora" for kind in ("release", "debug")]
    return next((str(path) for path in built if path.exists()), None)


def test_files_are_those_of_the_command_line(tmp_path: Path) -> None:
    meliora_command = command()
    if meliora_command is None:
        pytest.skip("needs the command, built by cargo")
    (tmp_path / "m.prism").write_text(MODEL, encoding="utf-8")
    (tmp_path / "m.pref").write_text(PREFERENCES, encoding="utf-8")
    model, preferences = tmp_path / "m.prism", tmp_path / "m.pref"
    ours, theirs = tmp_path / "ours.csv", tmp_path / "theirs.csv"
    values: dict[str, Any] = {"N": [2, -1, 3, 20], "K": 1}
    meliora.sweep(model, preferences, csv=ours, **values)
    arguments = [meliora_command, "check", str(model), str(preferences), "-c", "N={2,-1,3,20},K=1", "--csv"]
    subprocess.run([*arguments, str(theirs)], check=True, capture_output=True)
    assert lines(ours) == lines(theirs)
    assert ours.read_text(encoding="utf-8").splitlines()[0] == theirs.read_text(encoding="utf-8").splitlines()[0]
    assert [row["status"] for row in lines(ours)] == ["done", "error", "done", "done"]
    # Each continues the file of the other, and runs nothing again.
    for path in (ours, theirs):
        whole = path.read_text(encoding="utf-8")
        path.write_text("".join(whole.splitlines(keepends=True)[:3]), encoding="utf-8")
        if path == ours:
            subprocess.run([*arguments, str(path), "--resume"], check=True, capture_output=True)
        else:
            meliora.sweep(model, preferences, csv=path, resume=True, **values)
        again = path.read_text(encoding="utf-8")
        assert again.splitlines()[:3] == whole.splitlines()[:3]
        assert again.count("\n") == 5
    assert lines(ours) == lines(theirs)


def test_resuming_cuts_off_an_incomplete_last_row(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "rows.csv"
    ran: list[int] = []
    analyse = _sweep._analyse

    def noted(constants: Any, job: Any) -> Any:
        ran.append(constants["N"])
        return analyse(constants, job)

    def sweep() -> Any:
        return meliora.sweep(*CHAIN, N=[2, 3, 4], csv=path, resume=True)

    monkeypatch.setattr(_sweep, "_analyse", noted)
    table = records(sweep())
    whole, text = lines(path), path.read_text(encoding="utf-8")
    two = sum(map(len, text.splitlines(keepends=True)[:3]))
    # In the header, in the first cells, in a later row, and just before the end of the line.
    for cut in (3, text.index("\n"), two - 1, two + 2, two + 30, len(text) - 1):
        path.write_text(text[:cut], encoding="utf-8")
        ran.clear()
        assert records(sweep()) == table
        assert ran == [2, 3, 4][max(text[:cut].count("\n") - 1, 0) :], cut
        assert lines(path) == whole
    ran.clear()
    done = path.read_text(encoding="utf-8")
    assert records(sweep()) == table and not ran
    assert path.read_text(encoding="utf-8") == done
    # Without `resume`, everything runs again.
    assert records(meliora.sweep(*CHAIN, N=[2, 3, 4], csv=path)) == table and ran == [2, 3, 4]


def test_a_sweep_that_ends_early_keeps_its_rows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "rows.csv"
    analyse = _sweep._analyse

    def interrupted(constants: Any, job: Any) -> Any:
        if constants["N"] == 4:
            assert [row["N"] for row in lines(path)] == ["2", "3"]
            raise KeyboardInterrupt
        return analyse(constants, job)

    monkeypatch.setattr(_sweep, "_analyse", interrupted)
    with pytest.raises(KeyboardInterrupt):
        meliora.sweep(*CHAIN, N=[2, 3, 4, 5], csv=path)
    assert [row["N"] for row in lines(path)] == ["2", "3"]
    assert [entry.name for entry in tmp_path.iterdir()] == ["rows.csv"]


def test_a_limit_or_an_error_ends_its_instance_only(tmp_path: Path) -> None:
    path = tmp_path / "rows.csv"
    values: dict[str, Any] = {"N": [2, -1, 3000, 3], "K": 1}
    table = records(meliora.sweep(MODEL, PREFERENCES, memory="64KiB", engine="explicit", csv=path, **values))
    assert [row["status"] for row in table] == ["done", "error", "limit", "done"]
    assert "the range 0..-1 of `x` is empty" in table[1]["reason"]
    assert "memory" in table[2]["reason"]
    assert [row["status"] for row in lines(path)] == ["done", "error", "limit", "done"]
    resumed = records(meliora.sweep(MODEL, PREFERENCES, csv=path, resume=True, **values))
    assert [row["status"] for row in resumed] == ["done", "error", "limit", "done"]


def test_mistakes_are_told_before_anything_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def never(*_: object) -> None:
        raise AssertionError

    monkeypatch.setattr(_sweep, "_outcomes", never)
    path = tmp_path / "rows.csv"
    sweep: Any = meliora.sweep
    with pytest.raises(meliora.InputError, match="no constant `M`"):
        sweep(*CHAIN, csv=path, N=[2, 3], M=1)
    with pytest.raises(meliora.InputError, match="the constant `N` has no value"):
        sweep(*CHAIN, csv=path)
    with pytest.raises(meliora.InputError, match="the range 0..-2"):
        sweep(MODEL, PREFERENCES, csv=path, N=[-2, -1], K=1)
    with pytest.raises(meliora.InputError):
        sweep(CHAIN[0], "objective = \n", csv=path, N=2)
    with pytest.raises(FileNotFoundError):
        sweep("no.prism", CHAIN[1], N=2)
    mistakes: list[tuple[dict[str, Any], str]] = [
        ({"N": "2"}, "`N` is '2'"),
        ({"N": [2, None]}, "`N` is None"),
        ({"N": []}, "no values for `N`"),
        ({"N": itertools.count()}, "`N` has over 1000000 values"),
        ({"N": range(2000), "K": range(2000)}, "at most 1000000 instances"),
        ({"N": 2, "constants": {"N": 3}}, "`N` has values"),
        ({"N": 2, "engine": "quick"}, '"auto", "symbolic", "explicit"'),
        ({"N": 2, "scope": "some"}, "scope"),
        ({"N": 2, "max_level": 0}, "max_level=0"),
        ({"N": 2, "memory": "none"}, "memory"),
    ]
    for wrong, named in mistakes:
        with pytest.raises(meliora.UsageError, match=named):
            sweep(*CHAIN, **{"csv": path, **wrong})
    assert not path.exists()


def test_a_file_of_something_else_is_not_overwritten(tmp_path: Path) -> None:
    path, model = tmp_path / "rows.csv", tmp_path / "m.prism"
    model.write_text(MODEL, encoding="utf-8")
    with pytest.raises(meliora.UsageError, match="is an input"):
        meliora.sweep(model, PREFERENCES, N=2, K=1, csv=model)
    with pytest.raises(meliora.UsageError, match="resume=True needs `csv`"):
        meliora.sweep(model, PREFERENCES, N=2, K=1, resume=True)
    with pytest.raises(meliora.UsageError, match="regular file"):
        meliora.sweep(model, PREFERENCES, N=2, K=1, csv=tmp_path)
    meliora.sweep(model, PREFERENCES, N=[2, 3], K=1, csv=path)
    text = path.read_text(encoding="utf-8")
    with pytest.raises(meliora.UsageError, match="not the header"):
        meliora.sweep(model, PREFERENCES, K=1, N=2, csv=path, resume=True)
    with pytest.raises(meliora.UsageError, match="line 3: this row does not belong"):
        meliora.sweep(model, PREFERENCES, N=2, K=1, csv=path, resume=True)
    assert (model.read_text(encoding="utf-8"), path.read_text(encoding="utf-8")) == (MODEL, text)
    # The last of two rows was taken without a word.
    path.write_text(text + text.splitlines(keepends=True)[1], encoding="utf-8")
    with pytest.raises(meliora.UsageError, match="line 4: this row has the constants of an earlier row"):
        meliora.sweep(model, PREFERENCES, N=[2, 3], K=1, csv=path, resume=True)


def test_a_spreadsheet_runs_no_name_of_a_column(tmp_path: Path) -> None:
    path, asked = tmp_path / "rows.csv", {"=1+1": "Pmax=? [ F x=N ]"}
    rows = records(meliora.sweep(MODEL, properties=asked, N=2, K=1, csv=path))
    assert "'=1+1" in path.read_text(encoding="utf-8").splitlines()[0] and "=1+1" in rows[0]
    assert records(meliora.sweep(MODEL, properties=asked, N=2, K=1, csv=path, resume=True)) == rows


def test_constants_have_any_values_and_names() -> None:
    model = "mdp\nconst bool b;\nconst double p;\nconst int timeout;\n"
    model += "module m\n x : [0..timeout];\n [] b & x=0 -> p: (x'=1) + 1-p: (x'=2);\nendmodule\n"
    numpy = pytest.importorskip("numpy")
    halves = numpy.array([0.25, 0.5])
    table = meliora.sweep(model, "objective A = F x=1;\n", b=[True, False, True], p=halves, constants={"timeout": 3})
    rows = records(table)
    assert [(row["timeout"], row["b"], row["p"]) for row in rows] == [
        (3, True, 0.25), (3, True, 0.5), (3, False, 0.25), (3, False, 0.5)
    ]
    assert [row["states"] for row in rows] == [3, 3, 1, 1]
    (row,) = records(meliora.sweep(TOY, WISHES, last=numpy.int64(5)))
    assert (row["last"], row["states"]) == (5, 6)


def test_a_cell_is_read_as_it_was_written() -> None:
    for value in (True, False, 0, -3, 10**30, 0.1, 1e-20):
        assert _sweep.value_of(_sweep.cell_of(value)) == value
    for cell, read in {"": None, "unbounded": math.inf, "done": "done"}.items():
        assert _sweep.value_of(cell) == read


# Dask


@pytest.fixture
def client() -> Iterator[Any]:
    """A client of two workers, each a process with one thread. An instance that kills two workers is given up."""
    dask: Any = pytest.importorskip("dask")
    distributed: Any = pytest.importorskip("distributed")
    settings = {"distributed.scheduler.allowed-failures": 1, "distributed.worker.profile.enabled": False}
    with dask.config.set(settings):
        local = distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None)
        with local as cluster, distributed.Client(cluster) as client:
            yield client
            # A cluster must not close while it starts a worker in place of one that was killed.
            client.wait_for_workers(2, timeout=60)


def steps(client: Any, key: str) -> list[str]:
    """The states of a task so far."""
    story = client.run_on_scheduler(lambda dask_scheduler: [step[:3] for step in dask_scheduler.story(key)])
    return [str(after) for name, _, after in story if name == key]


def kill_a_busy_worker(note: Path, over: threading.Event) -> None:
    """Kills the worker that stopped itself, once its note is complete."""
    while not over.is_set():
        if note.exists() and (text := note.read_text()).endswith("\n"):
            os.kill(int(text.split()[0]), signal.SIGKILL)
            return
        time.sleep(0.01)


def test_a_sweep_survives_a_lost_worker(client: Any, tmp_path: Path) -> None:
    distributed: Any = pytest.importorskip("distributed")
    values = [400, 2, 401, 402, -1, 403, 404, 405]
    path, note = tmp_path / "rows.csv", tmp_path / "note"

    class Stop(distributed.WorkerPlugin):  # type: ignore[misc]
        """Stops the first process that begins to compute an instance, so that the instance does not end."""

        def transition(self, key: Any, start: Any, finish: Any, **_: Any) -> None:
            if finish == "executing" and str(key).startswith("meliora-instance"):
                try:
                    with open(note, "x") as file:
                        file.write(f"{os.getpid()} {key}\n")
                except FileExistsError:
                    return
                os.kill(os.getpid(), signal.SIGSTOP)

    client.register_plugin(Stop())
    over = threading.Event()
    killer = threading.Thread(target=kill_a_busy_worker, args=(note, over))
    killer.start()
    try:
        table = meliora.sweep(*CHAIN, client=client, csv=path, N=values)
    finally:
        over.set()
        killer.join()
    process, key = note.read_text().rstrip("\n").split(" ", 1)
    print(f"killed {process} while it ran {key}")
    print(*steps(client, key), sep=" -> ")
    # It was taken from the killed worker and run again.
    assert [step for step in steps(client, key) if step in ("processing", "memory")] == ["processing"] * 2 + ["memory"]
    assert records(table) == records(meliora.sweep(*CHAIN, N=values))
    assert [row["N"] for row in lines(path)] == list(map(str, values))
    assert records(table)[4]["status"] == "error"


def test_an_instance_that_kills_its_workers_has_a_row(client: Any, tmp_path: Path) -> None:
    distributed: Any = pytest.importorskip("distributed")

    class Poison(distributed.WorkerPlugin):  # type: ignore[misc]
        """Ends the process that runs N=3, as the system does if memory runs out."""

        def transition(self, key: Any, start: Any, finish: Any, **_: Any) -> None:
            if finish == "executing" and "-N=3" in str(key):
                os.kill(os.getpid(), signal.SIGKILL)

    client.register_plugin(Poison())
    path = tmp_path / "rows.csv"
    table = records(meliora.sweep(*CHAIN, client=client, csv=path, N=[2, 3, 4]))
    print(table[1]["reason"])
    assert [row["status"] for row in table] == ["done", "error", "done"]
    assert "KilledWorker" in table[1]["reason"] and "N=3" in table[1]["reason"]
    assert [row["status"] for row in lines(path)] == ["done", "error", "done"]


def test_workers_need_no_files_and_share_their_memory(client: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    client.run(os.chdir, "/")
    monkeypatch.chdir(ROOT)
    rows = records(meliora.sweep("models/chain.prism", "models/chain.pref", client=client, N=[2, 4]))
    assert rows == records(meliora.sweep(*CHAIN, N=[2, 4]))
    limit = client.run(lambda dask_worker: dask_worker.memory_manager.memory_limit)
    (half,) = {limit // 2 for limit in limit.values()}
    assert client.submit(_sweep._memory_of_thread).result() == half


def test_columns_may_be_expressions_over_several_operators() -> None:
    asked = {"both": "Pmax>=1 [ F x=N ] & !(P>0 [ F x>N ])", "rest": "1 - Pmax=? [ F x=N ]", "wrong": "Pmax=? [ F y=1 ]"}
    model = "mdp\nconst int N;\nmodule m\n x : [0..9] init 0;\n [] x<9 -> (x'=x+1);\n [] x=9 -> true;\nendmodule\n"
    rows = records(meliora.sweep(model, properties=asked, N=[9, 3]))
    assert [row["both"] for row in rows] == [True, False]
    assert [row["rest"] for row in rows] == [0, 0]
    assert all(row["wrong"] == "not answered" and "wrong" in row["reason"] for row in rows)
