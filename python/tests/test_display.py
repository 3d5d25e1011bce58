"""The display in notebooks."""

from __future__ import annotations

import re
from base64 import b64decode
from html.parser import HTMLParser
from xml.etree import ElementTree

import pytest

import meliora
from conftest import Engine


class Balanced(HTMLParser):
    """Checks that every opened element is closed."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.seen: list[str] = []
        self.text = ""

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.seen.append(tag)
        if tag != "img":
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


def read(html: str) -> Balanced:
    parser = Balanced()
    parser.feed(html)
    parser.close()
    assert parser.open == []
    return parser


def test_models_show_their_variables(robot: meliora.Model) -> None:
    page = read(robot._repr_html_())
    assert page.seen.count("tr") == 8 and "0..8" in page.text


def test_preferences_show_their_order(wishes: meliora.Preferences) -> None:
    svg = wishes._repr_svg_()
    ElementTree.fromstring(svg)
    assert svg.count("<rect") >= 7 and ">nothing<" in svg
    page = read(wishes._repr_html_())
    assert "img" in page.seen and "F (r=0 & c=0)" in page.text


def pictures(html: str) -> list[ElementTree.Element]:
    """Returns the pictures of a page."""
    return [ElementTree.fromstring(b64decode(data)) for data in re.findall(r'src="data:image/svg\+xml;base64,([^"]*)"', html)]


def test_orders_are_pictures_and_pairs(wishes: meliora.Preferences) -> None:
    assert wishes.to_svg() == wishes._repr_svg_()
    made = meliora.Preferences({name: "F x=1" for name in "ABCDE"}, ["A > B > D", "A > D", "B ~ C"])
    assert made.edges == [("A", "B"), ("A", "C"), ("B", "D"), ("C", "D")]
    names = list(wishes.objectives)
    reached = {(x, y) for x, y in wishes.edges}
    for z in names:
        reached |= {(x, y) for x in names for y in names if (x, z) in reached and (z, y) in reached}
    assert reached == {(x, y) for x in names for y in names if wishes.compare(x, y) == ">"}


def test_pictures_have_their_own_size(found: meliora.Analysis, wishes: meliora.Preferences, engine: Engine) -> None:
    # A picture without a size is as wide as its place: three boxes would fill a notebook.
    small = meliora.Preferences({"A": "F x=1", "B": "F x=2"}, ["A > B"])
    shown = pictures(small._repr_html_()) + pictures(wishes._repr_html_()) + pictures(found._repr_html_())
    assert len(shown) == (4 if engine == "symbolic" else 3)
    for picture in shown:
        width, height = (float(picture.attrib[name]) for name in ("width", "height"))
        assert [0, 0, width, height] == [float(x) for x in picture.attrib["viewBox"].split()]
        assert 80 < width < 640 and 80 < height < 640
    assert float(shown[0].attrib["width"]) < 120


def test_analyses_show_levels_and_maps(found: meliora.Analysis, engine: Engine) -> None:
    page = read(found._repr_html_())
    assert "1,946" in page.text and "1,204" in page.text
    assert page.seen.count("img") == (2 if engine == "symbolic" else 1)


def test_regions_show_where_they_are(found: meliora.Analysis, toy: meliora.Model, engine: Engine) -> None:
    region = found.sasi.regions[0]
    page = read(region._repr_html_())
    assert "768 states" in page.text and "763 more" in page.text and "img" in page.seen
    assert repr(region) == "<Region of 768 states>" and "… and 765 more" in str(region)
    empty = region - region
    assert read(empty._repr_html_()).text == "0 states" and str(empty) == "{}"
    one = toy.explore(engine=engine).initial
    assert "1 state" in read(one._repr_html_()).text and repr(one) == "<Region of 1 state>"


def test_names_of_models_are_no_markup() -> None:
    model = meliora.Model.from_string("mdp module m x : [0..1]; [] true -> true; endmodule", name="<b>&.prism")
    assert "<b>&.prism" in read(model._repr_html_()).text


@pytest.mark.parametrize("name", ["Model", "Preferences", "Analysis", "Region", "Levels", "Strategy", "Exploration", "Play"])
def test_everything_has_a_docstring(name: str) -> None:
    kind = getattr(meliora, name)
    assert kind.__doc__ and kind.__module__ == "meliora"
    for member in vars(kind):
        if not member.startswith("_"):
            assert getattr(kind, member).__doc__, f"{name}.{member}"
