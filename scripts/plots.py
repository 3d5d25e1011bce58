"""The pictures that the scripts draw."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any, Mapping, Sequence

import harness

Points = Sequence[tuple[float, float]]


def require() -> None:
    """Ends the script where matplotlib is missing: before the long work, not after it."""
    if importlib.util.find_spec("matplotlib") is None:
        harness.stop("the Python package matplotlib is missing: `pip install matplotlib`, or leave out --plot")


def _pyplot() -> Any:
    import matplotlib

    matplotlib.use("Agg")
    # One and the same picture for one and the same data.
    matplotlib.rcParams["svg.hashsalt"] = "meliora"
    from matplotlib import pyplot

    return pyplot


def _save(figure: Any, path: Path) -> None:
    metadata = {"Date": None} if path.suffix == ".svg" else None
    figure.savefig(path, metadata=metadata, bbox_inches="tight", dpi=150)


def scatter(path: Path, panels: Mapping[str, Mapping[str, Points]], floor: float, ceiling: float) -> None:
    """Seconds of Meliora (across) against seconds of a peer (up), one panel per phase; above the line Meliora is faster."""
    pyplot = _pyplot()
    figure, axes = pyplot.subplots(1, len(panels), figsize=(5 * len(panels), 5), squeeze=False)
    ends = [floor / 1.5, ceiling * 1.5]
    for axis, (phase, peers) in zip(axes[0], panels.items()):
        for marker, (peer, points) in zip("ox^s", peers.items()):
            axis.plot(*zip(*points), marker, label=peer, alpha=0.7) if points else None
        for factor, style in ((1, "-"), (10, "--"), (100, ":")):
            axis.plot(ends, [end * factor for end in ends], style, color="grey", linewidth=0.8)
        axis.set(xscale="log", yscale="log", xlim=ends, ylim=ends, title=phase)
        axis.set(xlabel="meliora, seconds", ylabel="peer, seconds (lines: 1, 10 and 100 times)")
        axis.legend(loc="lower right")
    _save(figure, path)


def crossover(path: Path, panels: Mapping[str, Mapping[str, Points]], title: str) -> None:
    """States (across) against a quantity (up), one panel per quantity; both axes logarithmic.

    A line is named `engine, series`: its style says which engine, its colour which series.
    """
    pyplot = _pyplot()
    figure, axes = pyplot.subplots(1, len(panels), figsize=(6 * len(panels), 4.5), squeeze=False)
    for axis, (quantity, series) in zip(axes[0], panels.items()):
        colours: dict[str, str] = {}
        for name, points in series.items():
            colour = colours.setdefault(name.partition(", ")[2], f"C{len(colours)}")
            style = "o--" if name.startswith("explicit") else "s-"
            axis.plot(*zip(*sorted(points)), style, color=colour, label=name)
        axis.set(xscale="log", yscale="log", xlabel="states", ylabel=quantity)
        axis.grid(True, which="major", linewidth=0.4)
        axis.legend(fontsize="small")
    figure.suptitle(title)
    _save(figure, path)
