"""A heat map of ranks: how many improvements are possible from each cell, with a full and a nearly empty battery.

    python heat_map.py ranks.png
"""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import meliora

models = Path(__file__).resolve().parents[2] / "models"
model = meliora.Model.from_file(models / "robot5x5.prism")
found = model.check(models / "robot5x5.pref", scope="all", safety="transition")

figure, axes = plt.subplots(1, 2, layout="constrained")
# The states of the last level have an unbounded rank.
most = len(found.spi)
for axis, battery in zip(axes, (8, 2)):
    ranks = found.spi.to_numpy("r", "c", {"b": battery})
    # Cells without a state (NaN) stay blank.
    ranks = np.where(np.isinf(ranks), most, ranks)
    image = axis.imshow(ranks, origin="lower", vmin=0, vmax=most)
    axis.set(title=f"battery {battery}", xlabel="c", ylabel="r")
bar = figure.colorbar(image, ax=axes, ticks=range(most + 1), label="possible improvements", shrink=0.6)
bar.ax.set_yticklabels([*map(str, range(most)), "any number"])
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "ranks.png")
