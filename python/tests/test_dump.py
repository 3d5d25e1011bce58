"""Dumps: written, read without the model, and checked."""

from __future__ import annotations

import pickle
from pathlib import Path

import pytest
from conftest import MODELS, Engine

import meliora


@pytest.mark.parametrize("engine", ["symbolic", "explicit"])
@pytest.mark.parametrize("name", ["toy", "drone", "pond"])
def test_a_dump_has_the_regions_of_its_analysis(tmp_path: Path, name: str, engine: Engine) -> None:
    model = meliora.Model.from_file(MODELS / f"{name}.prism")
    wishes = meliora.Preferences.from_file(MODELS / f"{name}.pref")
    found = model.explore(engine=engine).check(wishes)
    found.export(tmp_path / "dump")
    dump = meliora.Dump(tmp_path / "dump")
    assert set(found.region_names) <= set(dump.regions)
    for region in found.region_names:
        assert dump.count(region) == found.region(region).count(), region
        assert dump.states(region) == found.region(region).states(), region
    assert dump.count("reachable & !initial") == (found.exploration.states - found.exploration.initial).count()
    start = found.exploration.initial.states(1)[0]
    assert dump.contains("initial", start) and dump.manifest["scope"] == "reachable"
    for kind, levels in (("sasi", found.sasi), ("spi", found.spi)):
        if levels.counts and levels.rank(start) == len(levels):
            expected = found.strategy("sasi" if kind == "sasi" else "spi").actions(start)
            assert list(dump.actions(f"strategy:{kind}:{len(levels)}", start)) == expected
    verdict = meliora.verify(tmp_path / "dump", model, wishes)
    assert verdict and verdict.accepted and verdict.violation is None and "reachable" in verdict.checked


def test_a_condition_restricts_a_dump(tmp_path: Path) -> None:
    model = meliora.Model.from_file(MODELS / "drone.prism")
    model.check(MODELS / "drone.pref").export(tmp_path / "dump")
    dump = meliora.Dump(tmp_path / "dump", where="at > 3")
    assert dump.count("reachable") == 3
    assert [state["at"] for state in dump.states("reachable", limit=2)] == [4, 5]
    with pytest.raises(meliora.InputError, match="unknown|no region"):
        dump.count("nowhere")
    with pytest.raises(meliora.UsageError, match="set of states"):
        dump.actions("reachable", model.state())
    with pytest.raises(TypeError, match="open its folder again"):
        pickle.dumps(dump)


def test_another_model_is_refused(tmp_path: Path) -> None:
    model, wishes = meliora.Model.from_file(MODELS / "drone.prism"), MODELS / "drone.pref"
    model.check(wishes).export(tmp_path / "dump")
    other = meliora.Model.from_string(model.text.replace("1/3", "1/4").replace("2/3", "3/4"))
    refused = meliora.verify(tmp_path / "dump", other, wishes)
    assert not refused and refused.violation
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "letter.txt").write_text("mine")
    with pytest.raises(OSError, match="neither empty nor a dump"):
        model.check(wishes).export(tmp_path / "other")
    with pytest.raises(OSError):
        meliora.Dump(tmp_path / "nowhere")


def test_the_states_one_by_one_are_files_of_other_programs() -> None:
    drone = meliora.Model.from_file(MODELS / "drone.prism")
    found = drone.check(MODELS / "drone.pref")
    states = found.counts["states"] if found.counts else 0
    drn = found.explicit_files()
    assert list(drn) == ["model.drn"]
    again = meliora.Model.from_string(drn["model.drn"].decode())
    assert again.explore().states.count() == states
    assert set(found.explicit_files("explicit")) == {"model.tra", "model.sta", "model.lab"}
    umb = found.explicit_files("umb")["model.umb"]
    assert meliora.Model.from_umb(umb).explore().states.count() == states
    induced = found.explicit_files("drn", "sasi:progress")
    assert set(induced) == {"sasi-progress.drn", "sasi-progress.csv"}
    with pytest.raises(meliora.TooLarge):
        found.explicit_files(limit=2)
    for wrong, message in ((("storm", None), "format="), (("drn", "best"), "strategy=")):
        with pytest.raises(meliora.UsageError, match=message):
            found.explicit_files(*wrong)
