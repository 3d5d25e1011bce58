"""Long calls: progress, time, memory, Ctrl-C, threads, processes."""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

import meliora
from conftest import MODELS, Engine


def test_progress_is_told(robot: meliora.Model, wishes: meliora.Preferences, engine: Engine) -> None:
    heard: list[meliora.Progress] = []
    robot.check(wishes, engine=engine, progress=heard.append)
    phases = [step.phase for step in heard]
    assert [phase for i, phase in enumerate(phases) if phase not in phases[:i]] == [
        "states",
        "preferences",
        "counts",
        "outcomes",
        "improvement",
        "sasi",
        "spi",
    ]
    assert any(step.detail.startswith("objective 3 of 6") for step in heard)
    times = [step.elapsed for step in heard]
    assert times == sorted(times) and times[0] >= 0
    assert "phase=" in repr(heard[0]) and "states" in str(heard[0])


def test_what_a_callback_raises_ends_the_work(endless: meliora.Model, engine: Engine) -> None:
    heard: list[meliora.Progress] = []

    def complain(step: meliora.Progress) -> None:
        heard.append(step)
        if len(heard) == 3:
            raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        endless.explore(engine=engine, progress=complain)


def test_a_callback_cannot_use_what_is_at_work(robot: meliora.Model, wishes: meliora.Preferences) -> None:
    explored = robot.explore()
    with pytest.raises(RuntimeError, match="cannot use what it interrupts"):
        explored.check(wishes, progress=lambda step: explored.states.count())
    assert explored.states.count() == 294


def test_time_runs_out(endless: meliora.Model, engine: Engine) -> None:
    start = time.monotonic()
    with pytest.raises(meliora.OutOfTime, match="out of time after 0.3 s") as caught:
        endless.explore(engine=engine, timeout=0.3)
    assert time.monotonic() - start >= 0.3
    error = caught.value
    assert isinstance(error, TimeoutError) and isinstance(error, meliora.LimitError)
    assert error.phase == "states" and error.analysis is None and error.known is None
    assert "`timeout`" in str(error) and "--timeout" not in str(error)
    for wrong in (-1.0, float("nan"), "soon", "0s", "5 apples", [1]):
        with pytest.raises(meliora.UsageError, match="timeout="):
            endless.explore(timeout=wrong)  # type: ignore[arg-type]


def test_a_time_limit_may_have_a_unit(endless: meliora.Model, robot: meliora.Model) -> None:
    with pytest.raises(meliora.OutOfTime, match="out of time after 0.2 s"):
        endless.explore(timeout="200ms")
    assert robot.explore(timeout="1h 30m").states.count() == robot.explore(timeout=5400).states.count()


def test_every_long_call_of_an_analysis_has_a_time_limit(robot: meliora.Model) -> None:
    found = robot.check(MODELS / "robot5x5.pref")
    calls: list[Callable[..., Any]] = [
        found.values,
        found.jointly,
        lambda **limits: found.strategy(choose="likely", **limits),
        found.to_html,
        lambda **limits: found.to_svg("sasi", **limits),
        found.strategy("sasi").shield,
    ]
    for number, call in enumerate(calls):
        with pytest.raises(meliora.OutOfTime):
            call(timeout=0)
        with pytest.raises(meliora.UsageError, match="timeout="):
            call(timeout="soon")
        # The time that was up is not that of the next call.
        assert call(timeout="1h", progress=lambda step: None) is not None, number


def test_what_is_known_stays_when_time_runs_out(engine: Engine) -> None:
    model = meliora.Model.from_file(MODELS / "patrol.prism", constants={"N": 40 if engine == "symbolic" else 14})
    wishes = meliora.Preferences.from_file(MODELS / "patrol.pref")
    timeout = 1.0

    def wait_until_time_is_up(step: meliora.Progress) -> None:
        if step.phase == "improvement":
            time.sleep(max(0.0, timeout - step.elapsed))

    while True:
        with pytest.raises(meliora.OutOfTime) as raised:
            model.check(wishes, engine=engine, timeout=timeout, progress=wait_until_time_is_up)
        caught = raised.value
        if caught.analysis is not None:
            break
        # On a slow machine the states take longer.
        timeout *= 2
    known, analysis = caught.known, caught.analysis
    assert known is not None and known["complete"] is False and caught.phase is not None
    assert known["counts"] is None or int(known["counts"]["states"]) > 0
    assert not analysis.complete and "unfinished" in repr(analysis)
    if known["spi"] is None:
        with pytest.raises(meliora.UsageError, match="resume"):
            analysis.strategy("spi")
    again = pickle.loads(pickle.dumps(caught))
    assert (again.known, again.analysis, str(again)) == (known, None, str(caught))
    with pytest.raises(meliora.OutOfTime):
        analysis.resume(timeout=0)
    analysis.resume()
    assert analysis.complete and analysis.spi.counts == model.check(wishes, engine=engine).spi.counts
    analysis.resume()


def test_memory_runs_out(endless: meliora.Model, engine: Engine) -> None:
    with pytest.raises(meliora.OutOfMemory) as caught:
        endless.explore(engine=engine, memory="2MiB" if engine == "symbolic" else "32MiB", timeout=60)
    assert isinstance(caught.value, MemoryError) and "`memory`" in str(caught.value)
    for wrong in (0, -1, "many", "3 apples", 1.5):
        with pytest.raises(meliora.UsageError, match="memory"):
            endless.explore(memory=wrong)  # type: ignore[arg-type]


def test_other_limits_have_their_exception() -> None:
    model = meliora.Model.from_string("mdp module m x : [0..100000]; y : [0..100000]; [] true -> (x'=y); endmodule")
    with pytest.raises(meliora.TooLarge, match="cells"):
        model.explore().states.to_numpy("x", "y")


@pytest.fixture
def interruptible() -> Iterator[None]:
    """Makes Ctrl-C raise even if the tests run in the background of a shell, which ignores it there."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def interrupted(after: float) -> threading.Timer:
    timer = threading.Timer(after, os.kill, [os.getpid(), signal.SIGINT])
    timer.start()
    return timer


@pytest.mark.skipif(sys.platform == "win32", reason="signals are those of Unix")
@pytest.mark.usefixtures("interruptible")
def test_ctrl_c_ends_long_work(endless: meliora.Model, engine: Engine) -> None:
    timer = interrupted(0.3)
    with pytest.raises(KeyboardInterrupt):
        endless.explore(engine=engine)
    timer.join()


@pytest.mark.skipif(sys.platform == "win32", reason="signals are those of Unix")
@pytest.mark.usefixtures("interruptible")
def test_an_exploration_is_of_use_after_ctrl_c(robot: meliora.Model, wishes: meliora.Preferences, engine: Engine) -> None:
    def interrupt(step: meliora.Progress) -> None:
        if step.phase == "outcomes":
            os.kill(os.getpid(), signal.SIGINT)

    explored = robot.explore(engine=engine)
    with pytest.raises(KeyboardInterrupt):
        explored.check(wishes, progress=interrupt)
    assert explored.states.count() == 294
    assert explored.check(wishes).sasi.counts == robot.check(wishes).sasi.counts


def test_other_threads_run_meanwhile(endless: meliora.Model) -> None:
    turns = 0
    stop = threading.Event()

    class Enough(Exception):
        pass

    def count() -> None:
        nonlocal turns
        while not stop.is_set():
            turns += 1
            time.sleep(0.001)

    def wait_for_turns(step: meliora.Progress) -> None:
        if turns > 50:
            raise Enough

    thread = threading.Thread(target=count)
    thread.start()
    try:
        with pytest.raises(Enough):
            endless.explore(progress=wait_for_turns)
    finally:
        stop.set()
        thread.join()


def test_threads_take_turns_at_an_analysis(found: meliora.Analysis, robot: meliora.Model) -> None:
    explored = found.exploration
    start, low = robot.state(), explored.where("r < 2")
    strategy = found.strategy("spi")
    failures: list[BaseException] = []

    def work(number: int) -> None:
        try:
            for round in range(5):
                assert found.sasi.rank(start) == 2
                assert (low | found.sasi.regions[0]).count() == (found.sasi.regions[0] | low).count()
                assert strategy.actions(start) == ["N", "S"]
                assert explored.reach({"r": number}).target.count() == 720
                assert len(list(low.where(c=number, b=round))) == 32
                assert len(low.sample(3, seed=number)) == 3
        except BaseException as failure:
            failures.append(failure)

    threads = [threading.Thread(target=work, args=(number,)) for number in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert failures == []


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork here")
def test_a_forked_process_is_told_to_explore_anew() -> None:
    script = f"""
import os, meliora
model = meliora.Model.from_file({str(MODELS / "robot5x5.prism")!r})
explored = model.explore()
child = os.fork()
if child == 0:
    try:
        explored.states.count()
        os._exit(1)
    except RuntimeError as error:
        os._exit(0 if "forked" in str(error) and model.explore().states.count() == 294 else 2)
assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
assert explored.states.count() == 294
"""
    subprocess.run([sys.executable, "-W", "ignore", "-c", script], check=True, timeout=60)


@pytest.mark.skipif(not os.path.exists("/proc/self/statm"), reason="the size of the process is told by Linux")
def test_a_thousand_analyses_leave_nothing_behind(toy: meliora.Model, toy_wishes: meliora.Preferences, engine: Engine) -> None:
    def resident() -> int:
        with open("/proc/self/statm") as statm:
            return int(statm.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")

    start = toy.state()

    def analyse() -> None:
        found = toy.check(toy_wishes, engine=engine, memory="64MiB", progress=lambda step: None)
        assert found.sasi.rank(start) == 1 and found.strategy("sasi").actions(start) == ["b", "c"]
        assert len(list(found.sasi.regions[0])) == 1

    for _ in range(100):
        analyse()
    before = resident()
    for _ in range(1000):
        analyse()
    grown = resident() - before
    assert grown < 8 << 20, f"{grown / 1000:.0f} bytes an analysis"
