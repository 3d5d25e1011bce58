"""The Python code in the documentation runs as written."""

from __future__ import annotations

import random
import re
from typing import Any

import pytest
from conftest import ROOT

PAGES = ["docs/python.md", "python/README.md"]


@pytest.mark.parametrize("page", PAGES)
def test_the_code_of_a_page_runs_as_written(page: str, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("numpy")
    pytest.importorskip("dd")
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(encoding="utf-8"), flags=re.DOTALL)
    assert blocks
    monkeypatch.chdir(ROOT)
    random.seed(1)
    names: dict[str, Any] = {}
    for block in blocks:
        exec(compile(block, page, "exec"), names)
    # The numbers in comments; those of the README are the paper's.
    shown = {"python/README.md": ([768, 98], [1946, 1477, 1165, 1010, 1004]), "docs/python.md": ([12], [1412])}
    assert (names["found"].sasi.counts, names["found"].spi.counts) == shown[page]
