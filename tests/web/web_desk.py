"""A desk at the workbench for the tests of the page: a real `percuss serve`, a real browser, what both have said."""

from __future__ import annotations

import base64
import json
import os
import re
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Browser, BrowserContext, ConsoleMessage, Error, Page, Response, Route, expect

from percuss.cli import main

PANELS = ("", "orbits", "branches", "blow", "experiment", "hammer", "case", "lessons", "report")
WAIT = int(os.environ.get("PERCUSS_WAIT", "240000"))  # ms; only what fails waits so long
PLAYING = [{"reduced_motion": "no-preference"}]  # else nothing plays by itself, for drawing takes what time there is
STATE = "import('/static/core/state.js').then"
CHANGED = "String((await import('/static/core/state.js')).data.changed)"

expect.set_options(timeout=WAIT)


@contextmanager
def served(*options: str, **environment: str) -> Iterator[str]:
    """The address of a running `percuss serve`, which gives no answer up before a test would."""
    command = [sys.executable, "-m", "percuss", "serve", "--port", "0", "--no-browser", *options]
    command += ["--seconds", str(WAIT // 1000)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env={**os.environ, **environment}) as process:
        assert process.stdout is not None
        line = process.stdout.readline()
        found = re.search(r"http://[^/\s]+/", line)
        threading.Thread(target=process.stdout.read, daemon=True).start()
        try:
            assert found, f"percuss serve said {line!r}"
            yield found[0]
        finally:
            process.terminate()
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()  # else the suite would wait for ever
                raise


def until(page: Page, true: str, timeout: int = WAIT) -> None:
    """Until a JavaScript expression is true; the page's policy stops Playwright's own way of waiting for one.

    The page itself looks again and again: asked from here, each look is a message through three processes.
    """
    end = time.monotonic() + timeout / 1000
    looks = f"""async limit => {{
      for (const end = performance.now() + limit; performance.now() < end; )
        if (await ({true})) return true;
        else await new Promise(done => setTimeout(done, 20));
      return false;
    }}"""
    while True:
        try:
            found = page.evaluate(looks, max(1000.0 * (end - time.monotonic()), 1.0))
        except Error as error:  # the page has gone to another address meanwhile
            if "context was destroyed" not in str(error) and "navigation" not in str(error):
                raise
            found = False
        if found:
            return
        assert time.monotonic() < end, f"never: {true}; busy: {page.evaluate('document.documentElement.dataset.busy')}"


def settled(page: Page, *but: str) -> None:
    """Until nothing is under way on the page but what is named: what it shows is of its present state, but for the map,
    which takes its time."""
    finished(page, "map", "boundaries", *but)


def finished(page: Page, *but: str) -> None:
    """Until nothing at all is under way but what is named."""
    names = "(document.documentElement.dataset.busy ?? '').split(' ')"
    until(page, f"document.documentElement.dataset.ready && {names}.every(one => {['', *but]}.includes(one))")


class Desk:
    """A page with what it did: the addresses it asked for, what the console said."""

    def __init__(self, browser: Browser, server: str, known: BrowserContext | None = None, **context: Any) -> None:
        context = {"viewport": {"width": 1360, "height": 900}, "reduced_motion": "reduce", **context}
        self.context = known or browser.new_context(**context)
        self.page: Page = self.context.new_page()
        self.page.set_default_timeout(WAIT)
        self.server = server
        self.asked: list[str] = []
        self.said: list[str] = []
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.page.on("console", self._heard)
        self.page.on("pageerror", lambda error: self.said.append(str(error)))
        self.failed: list[Response] = []
        self.page.on("response", lambda response: self.failed.append(response) if response.status >= 400 else None)

    def _heard(self, message: ConsoleMessage) -> None:
        ours = "getImageData" in message.text  # a remark on what `ink` does, not on the page
        if message.type in ("error", "warning") and not ours:
            self.said.append(message.text)

    def open(self, words: str) -> Page:
        self.page.goto("about:blank")  # else only the fragment would change
        self.page.goto(f"{self.server}#{words}")
        self.answered()
        return self.page

    def module(self, name: str) -> Page:
        """A module of the page as a document of its own, for what only imports it: a third of what the page takes."""
        self.page.goto(f"{self.server}static/{name}")
        return self.page

    def answered(self) -> None:
        """Until the headline shows the whole answer of the case."""
        until(self.page, "document.documentElement.dataset.ready && document.querySelector('#headline .badge')")
        until(self.page, "document.querySelector('#headline').ariaBusy === 'false'")


def figure(page: Page, name: str) -> str:
    """A figure of the headline by its name."""
    cell = page.locator("#headline .figures div", has=page.locator("dt", has_text=re.compile(f"^{name}$")))
    return cell.locator("dd").inner_text().replace("\u202f", " ")


def slide(page: Page, name: str, value: float) -> None:
    page.locator(f"#slide-{name}").evaluate(
        "(input, value) => { input.value = value; input.dispatchEvent(new Event('input', { bubbles: true })); }", value
    )


def point(page: Page, selector: str, right: float, up: float) -> tuple[float, float]:
    """Where on the screen a point of an element is: shares of its width from the left and of its height from below."""
    page.locator(selector).scroll_into_view_if_needed()
    box = page.locator(selector).bounding_box()
    assert box is not None
    return box["x"] + right * box["width"], box["y"] + (1.0 - up) * box["height"]


def ink(page: Page, selector: str) -> int:
    """How much is drawn on a canvas: a checksum of its pixels."""
    found: int = page.locator(selector).evaluate(
        """canvas => {
          const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
          let sum = 0;
          for (let i = 0; i < data.length; i += 5) sum = (sum * 31 + data[i]) | 0;
          return sum;
        }"""
    )
    return found


def held(page: Page, path: str) -> list[Route]:
    """The questions to a path of the server, each held until the test lets it go."""
    routes: list[Route] = []
    page.route(f"**/api/{path}", lambda route: routes.append(route))
    return routes


def came(page: Page, routes: list[Route]) -> Route:
    """The first question that is held, once it has come."""
    end = time.monotonic() + WAIT / 1000
    while not routes:
        assert time.monotonic() < end, "nothing was asked"
        page.wait_for_timeout(20)
    return routes[0]


def let_go(page: Page, path: str, routes: list[Route]) -> None:
    """The held questions to a path go on, and later ones are not held any more."""
    page.route(f"**/api/{path}", lambda route: route.continue_())  # first: one that comes meanwhile is not forgotten
    for route in routes:
        route.continue_()


def knows(page: Page, name: str) -> Any:
    """What a module of the page exports; it is the page's own, not another copy."""
    module, _, export = name.partition(":")
    return page.evaluate(f"import('/static/{module}').then(module => module.{export})")


def moved(page: Page) -> None:
    """Until the motion of the case as it is now is drawn, and told."""
    settled(page)
    assert page.locator("#stage").get_attribute("data-change") == page.evaluate(f"(async () => {CHANGED})()")


def steady_json(capsys: pytest.CaptureFixture[str], *arguments: str) -> dict[str, Any]:
    assert main(["steady", *arguments, "--json"]) == 0
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    return found


def blown(page: Page) -> str:
    """The sentence of the blow, once it has come."""
    settled(page)
    expect(page.locator("#blow-sentence")).to_contain_text("A blow of")
    return page.locator("#blow-sentence").inner_text()


def driven(page: Page, modes: int = 32) -> None:
    """Until the machine of the case as it is now is drawn and told, with so many modes."""
    settled(page)
    stage = page.locator("#machine-stage")
    assert stage.get_attribute("data-change") == page.evaluate(f"(async () => {CHANGED})()")
    assert stage.get_attribute("data-modes") == str(modes)


def scene(page: Page, lesson: int, number: int) -> None:
    """Open a scene of a lesson, and wait until the page shows it."""
    if page.locator("#panel-lessons").is_hidden():
        page.click("#tab-lessons")
    page.get_by_role("button", name=f"Begin lesson {lesson}").click()
    page.locator("#lesson-strip .try button").nth(number - 1).click()
    settled(page)


BYTES = """samples => {
  /* numbers as text: as a list each would be an object of its own on the way here */
  const bytes = new Uint8Array(samples.buffer);
  let text = "";
  for (let i = 0; i < bytes.length; i += 8192) text += String.fromCharCode(...bytes.subarray(i, i + 8192));
  return btoa(text);
}"""


def sound(text: str) -> Any:
    """The samples of what `BYTES` wrote."""
    return np.frombuffer(base64.b64decode(text), "<f4").astype(float)
