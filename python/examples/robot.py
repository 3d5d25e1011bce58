"""The robot of the paper: how many states can improve once, twice, …, and what to do at the start."""

from pathlib import Path

import meliora

models = Path(__file__).resolve().parents[2] / "models"
model = meliora.Model.from_file(models / "robot5x5.prism")
found = model.check(models / "robot5x5.pref", scope="all", safety="transition")
print(*found.sasi.counts)
print(*found.spi.counts)
print(found.strategy("sasi").explain(model.state()))
