"""The Python code in the documentation runs as written."""

from __future__ import annotations

import importlib.util
import random
import re
from pathlib import Path
from typing import Any

import pytest
from conftest import ROOT

PAGES = ["docs/python.md", "python/README.md"]


def run(page: str) -> dict[str, Any]:
    """Runs the blocks of a page as one program; returns its names. Blocks that need a package are left out without it."""
    text = (ROOT / page).read_text(encoding="utf-8")
    found = re.findall(r"```python(?: needs=(\w+))?\n(.*?)```", text, flags=re.DOTALL)
    blocks = [block for needs, block in found if not needs or importlib.util.find_spec(needs)]
    assert blocks
    random.seed(1)
    names: dict[str, Any] = {"__name__": "__main__"}
    for block in blocks:
        exec(compile(block, page, "exec"), names)
    return names


@pytest.mark.parametrize("page", PAGES)
def test_the_code_of_a_page_runs_as_written(page: str, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("numpy")
    pytest.importorskip("dd")
    monkeypatch.chdir(ROOT)
    names = run(page)
    # The numbers in comments; those of the README are the paper's.
    shown = {"python/README.md": ([768, 98], [1946, 1477, 1165, 1010, 1004]), "docs/python.md": ([12], [1412])}
    assert (names["found"].sasi.counts, names["found"].spi.counts) == shown[page]


def test_the_code_of_the_recipes_follows_a_strategy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    names = run("docs/recipes.md")
    assert [row["action"] for row in names["rows"]] == ["b", "stay", None, None]
    policy = names["policy"]
    policy.reset()
    assert [policy({"s": 0}), policy({"s": 2}), policy({"s": 2})] == ["b", "stay", None]
    with pytest.raises(KeyError):
        policy({"s": 0})


def test_the_code_of_the_page_on_games_says_what_its_comments_say(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    names = run("docs/games.md")
    page = (ROOT / "docs/games.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"```python\n(.*?)```", page, flags=re.DOTALL)
    for line in block.splitlines():
        code, comment = map(str.strip, line.partition("#")[::2])
        if comment:
            assert comment.startswith(str(eval(code, names))), line


def test_the_sweeps_of_the_page_on_sweeps_have_the_same_rows(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    pandas = pytest.importorskip("pandas")
    (tmp_path / "models").symlink_to(ROOT / "models")
    monkeypatch.chdir(tmp_path)
    run("docs/sweeps.md")
    one, other = (pandas.read_csv(tmp_path / name).filter(regex="^N$|^s|^c|^t") for name in ("chain.csv", "dask.csv"))
    one, other = (table.drop(columns="seconds") for table in (one, other))
    assert len(one) == 20 and one.equals(other)
