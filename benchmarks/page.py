"""Benchmarks of the workbench's page: a real Chromium before a real server, from the move to the frame that shows it.

A time ends after the frame is painted: at the first message that the page gets to handle once the frame's callbacks,
layout and painting are done.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from playwright.sync_api import sync_playwright

from web import MACHINE, ready, server

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "web"))

from browser import FLAGS, chromium

Row = tuple[str, str, str, str]

WINDOW = {"width": 1360, "height": 900}
TRACE = ["disabled-by-default-devtools.timeline.frame", "devtools.timeline.frame"]

PAINTED = """
const painted = () => new Promise((done) => requestAnimationFrame((at) => {
  const { port1, port2 } = new MessageChannel();
  port1.onmessage = () => done([performance.now(), at]);
  port2.postMessage(0);
}));
const rest = (milliseconds) => new Promise((done) => setTimeout(done, milliseconds));
const until = (node, true_) => new Promise((done) => {
  if (true_()) return done();
  const watch = new MutationObserver(() => true_() && (watch.disconnect(), done()));
  watch.observe(node, { attributes: true });
});
const set = (id, value) => {
  const input = document.getElementById(id);
  input.value = value;
  input.dispatchEvent(new Event("input", { bubbles: true }));
};
"""

MOVES = """async ([canvas_, api, id, values, gap]) => {
  /* each move waits for a while after the one before; `gap` 0: one in every frame, as a hand drags */
  const canvas = document.querySelector(canvas_);
  const moves = [];
  performance.clearResourceTimings();
  performance.setResourceTimingBufferSize(2000);
  const first = Number(canvas.dataset.change);
  const frames = [];
  let going = true;
  const watch = (async () => {
    while (going) {
      const [now] = await painted();
      frames.push([now, Number(canvas.dataset.change)]);
    }
  })();
  for (const value of values) {
    if (gap) await rest(gap); else await new Promise(requestAnimationFrame);
    moves.push(performance.now());
    set(id, value);
  }
  await until(canvas, () => Number(canvas.dataset.change) >= first + values.length);
  await rest(100);
  going = false;
  await watch;
  const asked = performance.getEntriesByType("resource").filter(({ name }) => name.endsWith(api));
  const painted_ = moves.map((at, i) => frames.find(([, change]) => change >= first + i + 1)[0] - at);
  return [painted_, asked.map(({ duration }) => duration)];
}"""

RESTED = """async ([id, values]) => {
  const { canvas, found } = { canvas: document.getElementById("machine-stage"), found: { elastic: [], whole: [] } };
  for (const value of values) {
    const before = canvas.dataset.change;
    const begun = performance.now();
    set(id, value);
    await until(canvas, () => canvas.dataset.change !== before && canvas.dataset.modes !== "0");
    found.elastic.push((await painted())[0] - begun);
    await until(canvas, () => canvas.dataset.whole === "true");
    found.whole.push((await painted())[0] - begun);
  }
  return found;
}"""

MAPS = """async ([id, values]) => {
  const canvas = document.getElementById("map");
  const found = { coarse: [], fine: [], curves: [] };
  for (const value of values) {
    await rest(1500);
    const begun = performance.now();
    for (const part of Object.keys(found)) delete canvas.dataset[part];
    set(id, value);
    for (const part of Object.keys(found)) {
      await until(canvas, () => canvas.dataset[part]);
      found[part].push((await painted())[0] - begun);
    }
  }
  return found;
}"""

FRAMES = """(seconds) => new Promise((done) => {
  const found = [];
  const step = (now) => {
    found.push(now);
    if (now - found[0] < 1000 * seconds) requestAnimationFrame(step);
    else done(found);
  };
  requestAnimationFrame(step);
})"""


def opened(browser: Browser, base: str, words: str) -> Page:
    """A page of its own with this view, at rest."""
    page = browser.new_context(viewport=WINDOW).new_page()
    page.goto(f"{base}/#{words}")
    page.wait_for_selector("html[data-ready]")
    page.wait_for_timeout(2000)
    return page


def ran(page: Page, script: str, *given: Any) -> Any:
    """What a script with the helpers above answers."""
    return page.evaluate(f"(given) => {{ {PAINTED} return ({script})(given); }}", *given)


def told(times: list[float]) -> tuple[str, str]:
    """Median and worst in words."""
    return f"{np.median(times):.0f} ms", f"worst {max(times):.0f} ms of {len(times)}, least {min(times):.0f} ms"


def first_paints(browser: Browser, base: str, runs: int = 7) -> list[Row]:
    """Nothing cached, every time: the first paint, and the answer in its headline."""
    paints, answers = [], []
    for _ in range(runs):
        page = browser.new_context(viewport=WINDOW).new_page()
        page.add_init_script(
            """window.answered = new Promise((done) => new MutationObserver((_, watch) => {
              if (!document.querySelector("#headline .figures")) return;
              watch.disconnect();
              requestAnimationFrame(() => setTimeout(() => done(performance.now())));
            }).observe(document, { childList: true, subtree: true }));"""
        )
        page.goto(base)
        answers.append(page.evaluate("window.answered"))
        paints.append(page.evaluate("performance.getEntriesByName('first-contentful-paint')[0].startTime"))
        page.context.close()
    return [
        ("page, first paint", told(paints)[0], "700 ms", told(paints)[1]),
        ("page, answer shown", told(answers)[0], "", told(answers)[1]),
    ]


def moves(browser: Browser, base: str, number: int = 80) -> list[Row]:
    """The slider of the load factor with the drawer of all motions open, which draws most."""
    values = (0.25 + 0.1 * (0.618034 * np.arange(number) % 1.0)).round(4).tolist()
    page = opened(browser, base, f"panel=orbits&machine={MACHINE}")
    rows = moved(page, ["#panel-orbits canvas[data-change]", "/api/quick", "slide-load_factor", values])
    page.context.close()
    return rows


def machine_moves(browser: Browser, base: str, number: int = 80) -> list[Row]:
    """The slider of a port of a machine that switches itself: a rigid piston while it moves, then 32 elastic modes."""
    values = (90.0 + 40.0 * (0.618034 * np.arange(number) % 1.0)).round(1).tolist()
    page = opened(browser, base, "machine=valve-breaker")
    asked = ["#machine-stage", "/api/machine", "slide-load-ports-0-behind", values]
    rows = [(f"machine, {words}", *rest) for words, *rest in moved(page, asked)]
    times = ran(page, RESTED, ["slide-load-ports-0-behind", values[:9]])
    page.context.close()
    for part, name in _LATER:
        middle, beside = told(times[part])
        rows.append((f"machine, {name}", middle, "", f"{beside}; it waits for 220 ms without a move"))
    return rows


_LATER = [
    ("elastic", "slider at rest to the cycle with 32 elastic modes"),
    ("whole", "… to margins and curves over the pressure"),
]


def moved(page: Page, asked: list[Any]) -> list[Row]:
    """The moves of a slider one at a time, and dragged: the canvas, the question, the slider and its values."""
    rows = []
    for words, gap in (("slider move to painted frame, one at a time", 700), ("slider dragged, a move a frame", 0)):
        times, answers = ran(page, MOVES, [*asked, gap])
        beside = f"{told(times)[1]}; the answers took {np.median(answers):.0f} ms"
        rows.append((words, told(times)[0], "50 ms, worst 100 ms", beside))
    return rows


def maps(browser: Browser, base: str, number: int = 9) -> list[Row]:
    """A change of the hammer that makes the whole map another, and the curves over it."""
    page = opened(browser, base, f"machine={MACHINE}")
    values = (300.0 + 50.0 * (0.618034 * np.arange(1, number + 1) % 1.0)).round(1).tolist()
    found = ran(page, MAPS, ["slide-bar-length", values])
    page.context.close()
    names = {"coarse": "map, first coarse view", "fine": "map 200 × 200", "curves": "map, first points of its curves"}
    goals = {"coarse": "100 ms", "fine": "300 ms", "curves": ""}
    return [(names[part], told(times)[0], goals[part], told(times)[1]) for part, times in found.items()]


PLAYED = {
    "N = 32, a blow": "source=start&simulation.modes=32",
    "N = 32, its ringing": "source=start&simulation.modes=32&zoom=12",
    "live": "",
}
"""Simulations with 32 elastic modes: a whole load period, and 12 periods of the first mode after the blow; and the
motion in closed form that goes on for ever."""


def animation(browser: Browser, base: str, seconds: float = 6.0) -> list[Row]:
    """The bar with 32 elastic modes beside its history, both in every frame; and the live motion beside its strip."""
    rows = []
    for name, words in PLAYED.items():
        page = opened(browser, base, f"machine={MACHINE}&{words}")
        page.wait_for_selector("#stage[data-modes='32']" if words else "#stage[data-blows]")
        browser.start_tracing(page=page, categories=TRACE)
        times = np.diff(page.evaluate(FRAMES, seconds))
        events = json.loads(browser.stop_tracing())["traceEvents"]
        dropped = sum(event["name"] == "DroppedFrame" for event in events)
        late = int(np.sum(np.rint(times * 60.0 / 1000.0) - 1.0))
        figure = f"{1000.0 * len(times) / float(np.sum(times)):.1f}/s"
        beside = f"{late} frames late of {len(times)}, {dropped} dropped by the compositor"
        rows.append((f"animation, {name}", figure, "60/s, none dropped", beside))
        page.context.close()
    return rows


def page() -> list[Row]:
    """What the user of the page waits for."""
    program = chromium()  # which asks Playwright, too
    with server() as (base, _, _), sync_playwright() as playwright:
        ready(base)
        browser = playwright.chromium.launch(executable_path=program, args=FLAGS)
        rows = [row for part in (first_paints, moves, machine_moves, maps, animation) for row in part(browser, base)]
        browser.close()
    return rows


if __name__ == "__main__":
    for line in page():
        print(*line, sep=" | ")
