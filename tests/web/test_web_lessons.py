"""The nine lessons in a real browser, each done by its own targets; what they say of numbers, from the library."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from typing import Any

import pytest

pytest.importorskip("fastapi")

from playwright.sync_api import Page, expect

from percuss import Load, Start, Stop, System, run, stability_of, steady_states
from percuss.case import load_case, machine_answer
from percuss.case.case import case_of
from percuss.explore import follow
from percuss.steady import orbits
from web_desk import Desk, driven, figure, scene, settled, until

pytestmark = pytest.mark.browser

LATER = ("follow", "steady")  # which no lesson waits for
SMALL = [{"viewport": {"width": 1366, "height": 650}}]

# Pictures play so many times as fast: their clock is that of the frames.
HASTE = "{ const raf = requestAnimationFrame; window.requestAnimationFrame = (f) => raf((t) => f(8 * t)); }"

BOXES = """() => {
  /* where everything stands, and by how much the strip's words are longer than the strip */
  const places = ["#top", "#headline", "#controls", "#lesson-strip", "#stage-place", ".stage", "#map-place", "#map",
    "#strip-place", "#why-place", "#drawer", "#drawers"];
  const strip = document.querySelector("#lesson-strip").getBoundingClientRect();
  const over = ["#lesson-look", "#lesson-ask", "#lesson-head"].map((one) => {
    const box = document.querySelector(one).getBoundingClientRect();
    return Math.max(0, Math.ceil(box.bottom - strip.bottom), Math.ceil(box.right - strip.right));
  });
  return [over, places.map((one) => {
    const { left, top, width, height } = document.querySelector(one).getBoundingClientRect();
    return `${one}: ${[left, top, width, height].map(Math.round)}`;
  })];
}"""


def typed(**values: float) -> Callable[[Page], None]:
    def go(page: Page) -> None:
        for name, value in values.items():
            field = page.locator(f"#slide-{name.replace('__', '-')}-value")
            field.fill(str(value))
            field.press("Enter")

    return go


def played(then: Callable[[Page], None]) -> Callable[[Page], None]:
    """With the motion going on."""

    def go(page: Page) -> None:
        if page.locator("#play").get_attribute("aria-label") == "Play":
            page.click("#play")
        then(page)

    return go


def slowly(page: Page) -> None:
    """From 0.86 to 0.81 in steps of 1 %, each for a few blows."""
    for _ in range(6):
        blows = int(page.locator("#stage").get_attribute("data-blows") or 0)
        page.locator("#slide-load_factor").press("ArrowDown")
        until(page, f"Number(document.querySelector('#stage').dataset.blows) >= {blows + 4}")


def other_motion(page: Page) -> None:
    page.get_by_role("button", name=re.compile("Motion 1 of 2")).click()


def half_as_often(page: Page) -> None:
    if not page.locator("#periods").is_visible():
        page.locator("#more-sliders summary").press("Enter")
    page.locator("#periods").fill("2")


def sized(key: str) -> Callable[[Page], None]:
    return lambda page: page.locator("#blow-slide-bar-diameter").press(key)


WALK: list[list[Callable[[Page], None]]] = [
    [typed(load_factor=0.75), typed(restitution=0.6, load_factor=1.05)],
    [other_motion, typed(load_factor=0.53), typed(restitution=0.2, load_factor=0.43)],
    [played(typed(load_factor=0.9)), played(slowly), played(typed(load_factor=0.788))],
    [half_as_often, lambda page: page.locator("#experiment-run").press("Enter")],
    [played(typed(load_factor=1.05)), played(typed(load_factor=0.97))],
    [typed(kappa=1.6), typed(restitution=0.5)],
    [sized("End"), sized("Home")],
    [other_motion, typed(system__restitution=0.2), typed(load__ports__1__delay=1.95), typed(load__pressure=80)],
    [typed(load_factor=0.9), typed(load_factor=0.8133), typed(load_factor=0.788)],
]

SAYS = """import("/static/lessons/lessons.js").then(({ LESSONS, questionOf }) => LESSONS.map((lesson) => ({
  title: lesson.title, words: JSON.stringify(lesson), question: questionOf(lesson.question), end: lesson.question,
  scenes: lesson.scenes.map((one) => ({ ...JSON.parse(JSON.stringify(one)), question: questionOf(one.predict) })),
})))"""


@pytest.mark.parametrize("desk", SMALL, indirect=True)
@pytest.mark.parametrize("number", range(1, 10))
def test_a_lesson_is_done_by_its_targets(desk: Desk, number: int) -> None:
    """Predict, look, one question: every target is reached by doing what it says, and no box on the screen moves."""
    desk.page.add_init_script(HASTE)
    page = desk.open("panel=lessons")
    said = page.evaluate(SAYS)[number - 1]
    assert len(WALK[number - 1]) == len(said["scenes"])
    page.get_by_role("button", name=f"Begin lesson {number}").click()
    target, ask = page.locator("#lesson-target"), page.locator("#lesson-ask")
    for index, (one, do) in enumerate(zip(said["scenes"], WALK[number - 1], strict=True)):
        settled(page, *LATER)
        expect(page.locator("#lesson-words")).to_have_text(one["say"])
        expect(target).to_have_text(f"○ {one['target']}")
        over, boxes = page.evaluate(BOXES)
        assert over == [0, 0, 0]
        question = one["question"]
        wrong = (question["right"] + 1) % len(question["choices"])
        ask.get_by_role("button", name=question["choices"][wrong], exact=True).click()
        expect(ask).to_contain_text("Now look")
        assert target.get_attribute("data-reached") == "false"
        do(page)
        expect(target).to_have_text(f"✓ {one['target']}")
        expect(ask).to_contain_text(f"No: {question['choices'][question['right']]}. {question['why']}")
        settled(page, *LATER)
        over, now = page.evaluate(BOXES)
        assert (over, [box for box in now if box not in boxes]) == ([0, 0, 0], []), one["show"]
        if index + 1 < len(said["scenes"]):
            page.click("#lesson-next")
    page.click("#lesson-question")
    ask.get_by_role("button", name=said["question"]["choices"][said["question"]["right"]], exact=True).click()
    expect(ask).to_contain_text(f"Right. {said['question']['why']}")
    assert page.evaluate(BOXES) == [[0, 0, 0], boxes]
    page.get_by_role("button", name="Leave the lesson").click()
    done = page.locator(".lesson").nth(number - 1).locator(".done")
    expect(done).to_have_text("✓ done")
    until(page, "location.hash.includes('panel=lessons')")
    page.reload()  # the learner's progress is kept
    expect(done).to_have_text("✓ done")


def test_each_question_has_one_right_choice_and_each_scene_one_sentence_or_two(desk: Desk) -> None:
    page = desk.module("lessons/lessons.js")
    lessons = page.evaluate(SAYS)
    assert len(lessons) == 9
    for lesson in lessons:
        for text in (lesson["end"], *(one["predict"] for one in lesson["scenes"])):
            _, *choices, _ = text.split(" | ")
            assert 2 <= len(choices) == len(set(choices)) <= 3
            assert [choice[0] for choice in choices].count("*") == 1 == text.count("*"), text
        for one in lesson["scenes"]:
            assert one["say"].count(". ") <= 1 or one["show"] in ("Chatter", "Two by two"), one["say"]
            case = case_of(one["case"]) if "case" in one else load_case(one["machine"])
            assert case.is_machine or case.system().load.load_factor > 0.0


def test_the_keyboard_alone_does_a_lesson(desk: Desk) -> None:
    page = desk.open("panel=lessons")
    settled(page)

    def here() -> str:
        one = "document.activeElement"
        words: str = page.evaluate(f"{one}.id || {one}.ariaLabel || {one}.textContent")
        return words

    def to(place: str, key: str = "Tab") -> None:
        for _ in range(80):
            if here() == place:
                return
            page.keyboard.press(key)
        raise AssertionError(f"no {place}; at last {here()}")

    to("Begin lesson 1")
    page.keyboard.press("Enter")
    expect(page.locator("#lesson-ask button").first).to_be_focused()
    to("meet and vanish")
    page.keyboard.press("Enter")
    to("slide-load_factor", "Shift+Tab")
    for _ in range(3):
        page.keyboard.press("Shift+ArrowUp")
    expect(page.locator("#lesson-target")).to_contain_text("✓")
    expect(page.locator("#lesson-told")).to_contain_text("Right.")
    to("lesson-next")
    page.keyboard.press("Enter")
    expect(page.locator("#lesson-target")).to_contain_text("○ Find")
    to("slide-restitution", "Shift+Tab")
    for _ in range(5):
        page.keyboard.press("Shift+ArrowRight")
    to("slide-load_factor")
    for _ in range(4):
        page.keyboard.press("Shift+ArrowRight")
    expect(page.locator("#lesson-target")).to_contain_text("✓")
    to("lesson-question")
    page.keyboard.press("Enter")
    expect(page.locator("#lesson-ask button").first).to_be_focused()
    to("both motions at once")
    page.keyboard.press("Enter")
    expect(page.locator("#lesson-told")).to_contain_text("Right.")


def test_a_projector_shows_verdict_stage_map_and_the_sentence(desk: Desk) -> None:
    page = desk.open("lesson=2")
    expect(page.locator("#lesson-words")).to_contain_text("Press a scene")
    page.get_by_role("button", name="The strip").click()
    settled(page, *LATER)
    size = "parseFloat(getComputedStyle(document.querySelector('#lesson-words')).fontSize)"
    before, map_ = page.evaluate(size), page.locator("#map").bounding_box()
    page.click("#projector")
    for place in ("#headline", "#stage", "#map", "#lesson-words", "#lesson-target"):
        expect(page.locator(place)).to_be_visible()
    for place in ("#top", "#controls", "#strip-place", "#why-place", "#drawers", "#drawer"):
        expect(page.locator(place)).to_be_hidden()
    assert page.evaluate(size) >= 1.25 * before
    now = page.locator("#map").bounding_box()
    assert map_ and now and now["width"] * now["height"] > 1.5 * map_["width"] * map_["height"]
    assert page.evaluate("document.documentElement.scrollHeight <= innerHeight")
    until(page, "location.hash.includes('projector=1')")
    link = page.url.partition("#")[2]
    page.keyboard.press("Escape")
    expect(page.locator("#controls")).to_be_visible()
    expect(page.locator("#projector")).to_be_focused()
    desk.open(link)  # a link comes back to the scene, as large
    expect(page.locator("#lesson-words")).to_contain_text("stable hammers lie between")
    expect(page.locator("#controls")).to_be_hidden()


def test_the_contact_is_magnified(desk: Desk) -> None:
    """Each bounce before the rest is R times as long as the one before, and R² times as high."""
    desk.page.add_init_script(HASTE)
    page = desk.open("lesson=5")
    expect(page.locator("#contact-inset")).to_be_hidden()
    page.get_by_role("button", name="Chatter", exact=True).click()
    settled(page, *LATER)
    expect(page.locator("#contact-inset")).to_be_visible()
    page.click("#play")
    until(page, "Number(document.querySelector('#contact-inset').dataset.bounces) >= 4")
    page.get_by_role("button", name="Leave the lesson").click()
    expect(page.locator("#contact-inset")).to_be_hidden()


def test_the_fields_of_an_experiment_follow_a_lesson(desk: Desk) -> None:
    page = desk.open("panel=experiment&machine=mini-breaker&starts=40&seed=7")
    expect(page.locator("#experiment-starts")).to_have_value("40")
    scene(page, 4, 2)
    expect(page.locator("#experiment-starts")).to_have_value("300")
    expect(page.locator("#experiment-seed")).to_have_value("1")


def test_the_lesson_of_the_valve_compares_like_with_like(desk: Desk) -> None:
    page = desk.open("panel=lessons")
    scene(page, 8, 1)
    expect(page.locator("#verdict")).to_have_text("Unstable")
    speed = float(figure(page, "striking speed"))
    scene(page, 8, 2)
    expect(page.locator("#verdict")).to_have_text("Runs")
    driven(page)
    assert float(figure(page, "striking speed")) == pytest.approx(speed, rel=5e-3)
    assert float(figure(page, "period")) == pytest.approx(2.0 * math.pi, rel=5e-3)
    expect(page.locator("#reason")).to_contain_text(re.compile("a disturbance settles to 1 % in (5|6) cycles"))


# --- what the lessons say of numbers


def hammer(factor: float, restitution: float) -> System:
    return System(s=20.0, d=0.005, restitution=restitution, load=Load.harmonic(factor, 1.0))


def stable(factor: float, restitution: float) -> bool:
    return any(stability_of(orbit).stable for orbit in steady_states(hammer(factor, restitution)).orbits)


def test_the_numbers_of_the_lessons_are_those_of_the_library(desk: Desk) -> None:
    words = [lesson["words"] for lesson in desk.module("lessons/lessons.js").evaluate(SAYS)]
    fold = steady_states(hammer(0.8, 0.4)).nearest.load_factor
    assert fold is not None and f"At {fold:.3f} they meet" in words[0]
    assert math.isclose(fold, 1.4 / (math.pi * 0.6), rel_tol=0.02)
    assert "At 0.551 the blow leaves the band" in words[1] and not stable(0.55, 0.4) and stable(0.552, 0.4)
    assert "0.55–0.73 at R = 0.4 to 0.39–0.47 at R = 0.2" in words[1]
    assert [stable(factor, 0.2) for factor in (0.38, 0.395, 0.465, 0.48)] == [False, True, True, False]

    branch = follow(orbits(hammer(0.95, 0.8), 1, modes=0).orbits[1], "load_factor", (0.78, 0.96), switch=4)
    flips = [f"{row.value:.4f}" for row in branch.cascade]
    assert f"Flips at {', '.join(flips)}: divide" in words[8] and len(flips) == 5
    ratios = ", ".join(f"{row.ratio:.1f}" for row in branch.cascade if row.ratio)
    assert f"The ratios {ratios} … tend to" in words[8]
    assert all(f"below {float(flips[0]):.3f}" in text for text in (words[2], words[8]))
    assert f"at {float(flips[1]):.3f}: four unequal blows" in words[2]

    labels = {"two": (0.86, "z=2/2"), "four": (0.805, "z=4/4"), "never": (0.788, "aperiodic")}
    rebound = Start.rigid(position=0.0, velocity=-2.4, time=2.85)
    for factor, label in labels.values():
        assert run(hammer(factor, 0.8), rebound, modes=0, stop=Stop(impacts=1500)).label == label
    for factor, restitution, label in ((0.9, 0.2, "chatter/1"), (1.05, 0.2, "rest"), (1.1, 0.5, "rest")):
        assert run(hammer(factor, restitution), Start.rigid(), modes=0, stop=Stop(impacts=300)).label == label

    once, twice = (steady_states(hammer(0.945, 0.8), m).orbits[1] for m in (1, 2))
    assert twice.blow_energy == pytest.approx(4.0 * once.blow_energy, rel=0.05) and stability_of(twice).stable
    drifter = load_case("hydraulic-drifter")
    for restitution, good in ((0.3, True), (0.4, False)):
        found = steady_states(drifter.varied({"contact.restitution": restitution}).system()).orbits
        assert any(stability_of(orbit).stable for orbit in found) is good
    assert "near 0.35 the blow is outside" in words[5]
    at = [stability_of(orbit) for orbit in steady_states(drifter.system()).orbits]
    assert "At 0.25 of the mean" in words[5]
    assert [f"{one.waveform.ratio:.2f}" for one in at if one.stable] == ["0.25"]

    scenes = json.loads(words[7])["scenes"]
    for delay, outcome in ((1.8, "runs"), (1.95, "double blow")):
        late: dict[str, Any] = scenes[2]["case"]
        late["load"]["ports"][1]["delay"] = delay
        assert machine_answer(case_of(late)).to_json_dict()["outcome"] == outcome
    half = machine_answer(load_case("valve-breaker").varied({"load.pressure": "80 bar"}))
    assert half.to_json_dict()["outcome"] == "stalls"
