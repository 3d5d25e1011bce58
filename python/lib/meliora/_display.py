"""The display of models, preferences, regions and analyses in notebooks, as HTML.

Pictures are those of the report. They are embedded as separate images, so that their styles do not mix with the page's.
"""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterable, Sequence
from html import escape
from typing import TYPE_CHECKING

from .errors import Error

if TYPE_CHECKING:
    from ._native import Analysis, Model, Preferences, Region

#: The maximum number of displayed rows of a table.
_ROWS = 10
#: The maximum number of displayed states of a region.
_STATES = 5
#: The maximum number of cells in a picture of a region.
_CELLS = 128 * 128


def model(model: Model) -> str:
    """Returns the HTML of a model: its variables with their ranges."""
    variables = list(model.variables.values())
    rows = [(v.name, v.type if v.type == "bool" else f"{v.low}..{v.high}", _value(v.initial)) for v in variables[:_ROWS]]
    title = f"{model.name}: {model.kind}, {len(variables)} variables, {len(model.actions)} actions"
    return _title(title) + _table(("variable", "range", "initially"), rows, len(variables))


def preferences(preferences: Preferences) -> str:
    """Returns the HTML of preferences: their objectives, and the order as a Hasse diagram."""
    objectives = list(preferences.objectives.items())
    table = _table(("objective", "formula"), objectives[:_ROWS], len(objectives))
    title = f"{preferences.name}: empty = {preferences.empty}, history = {preferences.history}"
    return _title(title) + _image(preferences.to_svg(), "the preference order") + table


def region(region: Region) -> str:
    """Returns the HTML of a region: the number of its states, the first ones, and a map."""
    count, states = region.count(), region.states(_STATES)
    title = f"{count:,} {'state' if count == 1 else 'states'}"
    if not states:
        return _title(title)
    table = _table(tuple(states[0]), [tuple(map(_value, state.values())) for state in states], count)
    return _title(title) + _map(region) + table


def analysis(analysis: Analysis) -> str:
    """Returns the HTML of an analysis: the levels, the preference order, a map of sure improvements, the objectives."""
    title = f"{analysis.model.name} with {analysis.preferences.name}"
    settings = f"engine {analysis.engine} · scope {analysis.scope} · safety {analysis.safety}"
    parts = [_title(title), f"<div>{escape(settings)}{'' if analysis.complete else ' · unfinished'}</div>"]
    parts += [_picture(analysis, "hasse", "the preference order"), _picture(analysis, "sasi", "guaranteed improvements")]
    counts = analysis.sasi.counts, analysis.spi.counts
    steps = range(max(map(len, counts)))
    levels = [(f"{k + 1} or more", *(_number(c[k]) if k < len(c) else "0" for c in counts)) for k in steps]
    parts.append(_table(("improvements", "SASI, almost surely", "SPI, possibly"), levels, len(levels)))
    positive = analysis.positive
    sure = [(name, _number(region.count()), _number(positive[name].count())) for name, region in analysis.almost_sure.items()]
    parts.append(_table(("objective", "almost surely", "possibly"), sure[:_ROWS], len(sure)))
    return "".join(parts)


def _picture(analysis: Analysis, picture: str, what: str) -> str:
    try:
        return _image(analysis.to_svg(picture), what)
    except Error:
        # The model has no plane to draw over, or the engine no diagrams.
        return ""


def _map(region: Region) -> str:
    """Returns a map of the region over the variables that look like rows and columns, larger rows above."""
    found = region._picture()
    if found is None:
        return ""
    row, column, cells = found
    height, width = len(cells), len(cells[0])
    if height * width > _CELLS:
        return ""
    size = max(2, min(16, 320 // max(height, width)))
    marks = "".join(
        f'<rect x="{x * size}" y="{(height - 1 - y) * size}" width="{size}" height="{size}"/>'
        for y, line in enumerate(cells)
        for x, there in enumerate(line)
        if there
    )
    box = f'width="{width * size}" height="{height * size}"'
    svg = f'<svg xmlns="http://www.w3.org/2000/svg" {box}><rect {box} fill="#eceae4"/><g fill="#225ea8">{marks}</g></svg>'
    axes = f"over {column}" if row is None else f"over {row} (upwards) and {column}"
    return _image(svg, f"the region {axes}") + f"<div><small>{escape(axes)}</small></div>"


def _image(svg: str, what: str) -> str:
    data = b64encode(svg.encode()).decode()
    return f'<img alt="{escape(what)}" style="max-width:min(100%,40em)" src="data:image/svg+xml;base64,{data}">'


def _title(text: str) -> str:
    return f"<div><b>{escape(text)}</b></div>"


def _table(head: Sequence[str], rows: Iterable[Sequence[str]], count: int) -> str:
    rows = list(rows)
    cells = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    more = f"<div><small>… and {count - len(rows):,} more</small></div>" if count > len(rows) else ""
    names = "".join(f"<th>{escape(name)}</th>" for name in head)
    return f"<table><thead><tr>{names}</tr></thead><tbody>{cells}</tbody></table>{more}"


def _number(count: int) -> str:
    return f"{count:,}"


def _value(value: object) -> str:
    if value is None:
        return ""
    return str(value).lower() if isinstance(value, bool) else str(value)
