"""The display in notebooks."""

from __future__ import annotations

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
