"""Single modules of the page in a real browser. `modules/NAME.test.js` imports them as the page does; each function
that it exports is a test, which is called with the checks of `modules/checks.js` and fails by throwing."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from percuss.units import _TABLE, DIMENSIONS, unit_scale

if TYPE_CHECKING:
    from playwright.sync_api import Route

    from web_desk import Desk

pytestmark = pytest.mark.browser

MODULES = Path(__file__).parent / "modules"
EXPORTED = re.compile(r"^export (?:async )?function (\w+)", re.MULTILINE)
TESTS = [(file.name, name) for file in sorted(MODULES.glob("*.test.js")) for name in EXPORTED.findall(file.read_text())]
EMPTY = '<!doctype html><html lang="en"><link rel="stylesheet" href="/static/workbench.css"><main></main></html>'


def sent(route: Route) -> None:
    """A file of the tests as if it lay beside the page's own; an empty page by the name of `blank.html`."""
    name = route.request.url.rpartition("/")[2]
    if name == "blank.html":
        route.fulfill(body=EMPTY, content_type="text/html; charset=utf-8")
    else:
        route.fulfill(body=(MODULES / name).read_text(), content_type="text/javascript; charset=utf-8")


@pytest.mark.parametrize(
    ("file", "name"), TESTS, ids=[f"{file.removesuffix('.test.js')}-{name}" for file, name in TESTS]
)
def test_module(desk: Desk, file: str, name: str) -> None:
    desk.page.route("**/static/tests/*", sent)
    desk.page.goto(f"{desk.server}static/tests/blank.html")
    run = """async ([file, name]) => {
      try {
        await (await import(`/static/tests/${file}`))[name](await import("/static/tests/checks.js"));
        return "";
      } catch (error) {
        return error?.stack ?? String(error);
      }
    }"""
    if failed := desk.page.evaluate(run, [file, name]):
        pytest.fail(f"{file}, {name}: {failed}", pytrace=False)


def test_units_of_the_page_are_those_of_the_package(desk: Desk) -> None:
    """Every unit that one of them lists is read by both, with the same factor."""
    page = desk.module("core/units.js")
    kinds = page.evaluate("import('/static/core/units.js').then(({ KINDS }) => KINDS)")
    ours = {"stress": "pressure", "modulus": "pressure", "blow rate": "frequency"}
    # what people type into a field and a case file does not take, as a case file has it
    alike = {"L": "l", "L/min": "l/min", "gpm": "gal/min", "rev/min": "rpm", "‰": "1e-3"}
    rows = [(u, row["SI"], ours.get(kind, kind)) for kind, row in kinds.items() for u in row["units"].split()]
    strange = {"1e^-3", "1e^-6", "10^-3", "10^-6"}
    rows += [(unit, si, d) for d, (si, _, _, units) in _TABLE.items() for unit in units if unit not in strange]
    rows = [(unit, si.replace("um/m", "1"), dimension) for unit, si, dimension in rows if dimension != "angle"]
    assert {dimension for _, _, dimension in rows} == set(DIMENSIONS)
    convert = "rows => import('/static/core/units.js').then(({ converted }) => rows.map(row => converted(1, ...row)))"
    factors = page.evaluate(convert, [row[:2] for row in rows])
    for (unit, _, dimension), factor in zip(rows, factors, strict=True):
        assert factor == pytest.approx(unit_scale(alike.get(unit, unit), (dimension,), unit)[0], rel=1e-14), unit
