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
found = model.check(models / "robot5x5.pref", safety="transition")

figure, axes = plt.subplots(1, 2, layout="constrained")
for axis, battery in zip(axes, (8, 4)):
    ranks = found.sasi.to_numpy("r", "c", {"b": battery})
    # Cells without a state (NaN) stay blank; an unbounded rank would be drawn as one more than the highest.
    ranks = np.where(np.isinf(ranks), len(found.sasi) + 1, ranks)
    image = axis.imshow(ranks, origin="lower", vmin=0, vmax=len(found.sasi))
    axis.set(title=f"battery {battery}", xlabel="c", ylabel="r")
figure.colorbar(image, ax=axes, ticks=range(len(found.sasi) + 1), label="sure improvements ahead", shrink=0.6)
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "ranks.png")
