"""Single modules of the page in a real browser. `modules/NAME.test.js` imports them as the page does; each function
that it exports is a test, which is called with the checks of `modules/checks.js` and fails by throwing."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

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
