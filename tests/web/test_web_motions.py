"""The workbench in a real browser: motions seen and heard, reports and experiments."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("fastapi")

from playwright.sync_api import Page, expect

from percuss.case import load_case, simulation_answer
from percuss.case.case import case_of
from web_desk import (
    BYTES,
    PLAYING,
    Desk,
    came,
    figure,
    held,
    ink,
    knows,
    let_go,
    moved,
    settled,
    slide,
    sound,
    until,
)

pytestmark = pytest.mark.browser


FRAMES = "async count => { while (count--) await new Promise(requestAnimationFrame); }"


# --- motion


@pytest.mark.parametrize("desk", PLAYING, indirect=True)
def test_the_bar_moves_pauses_scrubs_and_each_blow_is_counted(desk: Desk) -> None:
    page = desk.open("panel=orbits&machine=mini-breaker")
    page.wait_for_selector("#stage[data-label='z=1/1']")
    page.wait_for_selector("#stage[data-blows]")  # it plays by itself
    settled(page)  # which counts as nothing under way
    expect(page.locator("#play")).to_have_attribute("aria-label", "Pause")
    expect(page.locator("#heard")).to_have_text(re.compile(r"8\.08.kHz"))
    page.click("#play")
    expect(page.locator("#play")).to_have_attribute("aria-label", "Play")
    still = ink(page, "#stage")
    page.evaluate(FRAMES, 20)
    assert ink(page, "#stage") == still
    page.locator("#scrub").evaluate("i => { i.value = 500; i.dispatchEvent(new Event('input', { bubbles: true })); }")
    assert ink(page, "#stage") != still
    page.select_option("#zoom-part", "12")  # the ringing after the blow
    expect(page.locator("#slow ~ *, label:has(#slow) output")).to_have_text(re.compile("^1/.* speed$"))
    page.focus("#scrub")
    page.keyboard.press("Space")
    expect(page.locator("#play")).to_have_attribute("aria-label", "Pause")
    page.click("#sound")
    expect(page.locator("#sound")).to_have_attribute("aria-pressed", "true")


def test_a_motion_from_a_chosen_start(desk: Desk) -> None:
    words = "panel=orbits&source=start&window=settled&cycles=8&system.s=20&system.d=0.005&system.restitution=0.8"
    load = "&load.kind=harmonic&load.mean=0.86&load.amplitude=1&simulation.modes=0"
    page = desk.open(f"{words}{load}&start.position=0&start.velocity=-2.4&start.time=2.85")
    page.wait_for_selector("#stage[data-label='z=2/2']")
    slide(page, "load_factor", 1.0)
    page.wait_for_selector("#stage[data-label='z=1/1']")
    page.locator("#portrait").scroll_into_view_if_needed()
    page.wait_for_selector("#portrait[data-drawn]")
    page.click("#portrait", position={"x": 200, "y": 100})  # a point of the phase portrait is a start, too
    expect(page.locator("#window")).to_have_value("start")
    expect(page.locator("#start-velocity")).not_to_have_value("-2.4")
    page.fill("#start-velocity", "-0.5")
    page.keyboard.press("Tab")
    until(page, "location.hash.includes('start.velocity=-0.5')")
    settled(page)  # until then the page may move below the pointer
    with page.expect_download() as waiting:
        page.click("#motion-file")
    assert Path(waiting.value.path()).read_bytes()[:4] == b"\x89HDF"


STARTS: dict[str, tuple[dict[str, str], dict[str, Any]]] = {
    "rest": ({"position": "-20 mm", "time": "1.2 ms"}, {"position": "-20 mm", "time": "1.2 ms"}),
    "moving": ({"velocity": "1.5 m/s"}, {"position": "-20 mm", "velocity": "1.5 m/s", "time": "1.2 ms"}),
    "modal": (
        {"modal_displacement": "-0.1, 0.0005, 0.0001", "modal_velocity": "0 0.001 0"},
        {"modal_displacement": [-0.1, 0.0005, 0.0001], "modal_velocity": [0, 0.001, 0], "time": "1.2 ms"},
    ),
    "orbit": ({"orbit": "1", "velocity": "0.1 m/s"}, {"orbit": 1, "periods": 1, "velocity": "0.1 m/s"}),
    "random": ({"seed": "7"}, {"random": "rigid", "seed": 7}),
}
"""What is typed for each kind of start, and the table [start] that it is."""


def test_every_kind_of_start_of_a_case_can_be_chosen(desk: Desk) -> None:
    page = desk.open("panel=orbits&machine=mini-breaker&source=start&simulation.modes=8")
    for kind, (typed, table) in STARTS.items():
        page.select_option("#start-kind", kind)
        for key, text in typed.items():
            page.fill(f"#start-{key}", text)
            page.keyboard.press("Tab")
        until(page, "document.querySelector('#start-form') !== null")
        moved(page)
        assert knows(page, "core/state.js:data.tables.start") == table
        motion = simulation_answer(load_case("mini-breaker").changed(start=table, simulation={"modes": 8})).motion
        expect(page.locator("#stage")).to_have_attribute("data-label", motion.label)
    page.select_option("#start-random", "ringing")
    moved(page)
    assert knows(page, "core/state.js:data.tables.start.random") == "ringing"


def test_a_wrong_start_is_told_beside_its_field(desk: Desk, request: pytest.FixtureRequest) -> None:
    request.node.expected_words = ("422",)
    page = desk.open("panel=orbits&machine=mini-breaker&source=start")
    page.select_option("#start-kind", "moving")
    page.fill("#start-velocity", "2 kg")
    page.keyboard.press("Tab")
    expect(page.locator("#start-velocity-problem")).to_contain_text("velocity")
    expect(page.locator("#start-velocity")).to_have_attribute("aria-invalid", "true")
    page.fill("#start-velocity", "2 m/s")
    page.keyboard.press("Tab")
    expect(page.locator("#start-velocity-problem")).to_have_text("")
    moved(page)
    late = held(page, "motion")
    page.fill("#start-velocity", "1 m/s")
    page.keyboard.press("Tab")
    came(page, late)
    page.fill("#start-velocity", "2 kg")
    page.keyboard.press("Tab")
    expect(page.locator("#start-velocity-problem")).to_contain_text("velocity")
    let_go(page, "motion", late)
    settled(page)  # the late motion is drawn, and takes nothing back
    expect(page.locator("#start-velocity-problem")).to_contain_text("velocity")
    page.select_option("#start-kind", "orbit")
    page.fill("#start-orbit", "9")
    page.keyboard.press("Tab")
    expect(page.locator("#start-orbit-problem")).to_contain_text("1 to 2")


# --- sound


BLOWS = f"""async ({{ pitches, energies }}) => {{
  const text = {BYTES};
  const {{ limited, ring, strike }} = await import("/static/motion/sound.js");
  const found = [];
  for (const frequency of pitches)
    for (const energy of energies) {{
      const audio = new OfflineAudioContext(1, 44100 * 0.3, 44100);
      strike(audio, limited(audio), {{ at: 0, ...ring({{ frequency, energy, share: 1 }}) }});
      found.push([frequency, energy, text((await audio.startRendering()).getChannelData(0))]);
    }}
  return found;
}}"""


def test_a_blow_sounds_at_the_first_mode_and_louder_with_its_energy(desk: Desk) -> None:
    page = desk.module("motion/sound.js")
    energies = [5.0, 50.0, 500.0, 5000.0]
    levels: dict[float, list[float]] = {}
    for frequency, _, samples in page.evaluate(BLOWS, {"pitches": [1470.0, 8080.0], "energies": energies}):
        wave = sound(samples)
        spectrum = np.abs(np.fft.rfft(wave * np.hanning(len(wave))))
        tones = np.fft.rfftfreq(len(wave), 1 / 44100)
        ringing = tones > 300.0  # above the thud
        assert tones[ringing][np.argmax(spectrum[ringing])] == pytest.approx(frequency, rel=0.01)
        levels.setdefault(frequency, []).append(float(np.sqrt(np.mean(wave**2))))
    for heard in levels.values():
        assert all(b > 1.1 * a for a, b in pairwise(heard))
        assert max(heard) < 1.0


PLAYED = f"""async ({{ blows, length, rate, begin, seconds, frequency, frames }}) => {{
  const text = {BYTES};
  /* the sound of a motion, placed by frames that come at uneven moments, as on a busy page */
  const {{ AHEAD, Track, limited }} = await import("/static/motion/sound.js");
  const audio = new OfflineAudioContext(1, 48000 * seconds, 48000);
  const track = new Track(audio, limited(audio));
  track.load({{ blows, length, frequency }});
  track.from(begin, rate, 0);
  track.ahead(AHEAD);
  for (const moment of frames)
    audio.suspend(moment).then(() => {{
      track.ahead(audio.currentTime + AHEAD);
      audio.resume();
    }});
  return text((await audio.startRendering()).getChannelData(0));
}}"""


def played(page: Page, blows: list[dict[str, Any]], **more: Any) -> tuple[Any, list[Any]]:
    """When blows begin (s) in the sound of a motion, and the sound of each until the next."""
    asked = {"length": 6.25, "rate": 6.25, "begin": 0.7, "seconds": 6, "frequency": 1200.0, **more}
    uneven = np.cumsum(np.random.default_rng(7).uniform(0.008, 0.3, 60))
    frames = [float(moment) for moment in uneven if moment < asked["seconds"] - 0.1]
    wave = sound(page.evaluate(PLAYED, {"blows": blows, "frames": frames, **asked}))
    loud = np.flatnonzero(np.abs(wave) > 1e-6)
    begins = loud[np.concatenate([[True], np.diff(loud) > 240])]  # after 5 ms of silence
    return begins / 48000.0, np.split(wave, begins[1:])


def test_blows_of_a_steady_motion_sound_evenly(desk: Desk) -> None:
    """However unevenly frames come, the blows are where the motion has them: far within 1 ms, over several turns."""
    page = desk.module("motion/sound.js")
    one = [{"time": 1.0, "energy": None, "share": 1.0}]
    begins, _ = played(page, one)
    assert len(begins) == 6 and np.abs(np.diff(begins) - 1.0).max() < 1e-4
    assert begins[0] == pytest.approx(0.3 / 6.25, abs=0.01)  # the limiter looks ahead by some milliseconds
    two = [{"time": time_, "energy": None, "share": share} for time_, share in ((1.0, 1.0), (3.5, 0.97))]
    begins, _ = played(page, two)
    assert np.diff(begins) == pytest.approx(np.resize([0.4, 0.6], len(begins) - 1), abs=1e-3)


@pytest.mark.parametrize("share", [0.3, 0.98])
def test_a_weak_blow_is_heard_as_weak(desk: Desk, share: float) -> None:
    """Of a doubled motion: at least 8 dB softer, in the sound that comes out, and of another pitch."""
    page = desk.module("motion/sound.js")
    blows = [{"time": 1.0, "energy": 500.0, "share": 1.0}, {"time": 4.0, "energy": 500.0 * share, "share": share}]
    _, sounds = played(page, blows)
    strong, weak = sounds[0], sounds[1]
    level = [10.0 * np.log10(np.mean(wave[:12000] ** 2)) for wave in (strong, weak)]
    assert level[0] - level[1] >= 8.0
    tones = []
    for wave in (strong, weak):
        spectrum = np.abs(np.fft.rfft(wave[:12000] * np.hanning(12000)))
        hertz = np.fft.rfftfreq(12000, 1 / 48000)
        spectrum[hertz < 300.0] = 0.0
        tones.append(float(hertz[np.argmax(spectrum)]))
    assert tones[0] == pytest.approx(1200.0, rel=0.01) and tones[1] < 0.8 * tones[0]


def test_a_pitch_that_cannot_be_heard_is_said(desk: Desk) -> None:
    page = desk.module("motion/sound.js")
    heard = (
        "import('/static/motion/sound.js').then(m => [20, 1000, 40000].map(f => m.heardAs({ frequency: f, share: 1 })))"
    )
    low, plain, high = (text.replace("\u202f", " ") for text in page.evaluate(heard))
    assert low == "120 Hz, 50 %; the first mode, 20 Hz, is too low to hear"
    assert plain == "1 kHz, 50 %"
    assert high == "9 kHz, 50 %; the first mode, 40 kHz, is too high to hear"


SCHEDULED = """() => {
  /* every moment of the audio clock for which the page asks a tone */
  window.asked = [];
  const start = OscillatorNode.prototype.start;
  OscillatorNode.prototype.start = function (at) {
    window.asked.push(at);
    return start.call(this, at);
  };
}"""


@pytest.mark.parametrize("desk", PLAYING, indirect=True)
def test_the_page_places_blows_on_the_audio_clock(desk: Desk) -> None:
    page = desk.open("panel=orbits&machine=mini-breaker&slow=0")
    page.wait_for_selector("#stage[data-blows]")
    page.evaluate(SCHEDULED)
    page.click("#sound")
    until(page, "new Set(window.asked).size > 40")
    moments = np.unique(page.evaluate("window.asked"))
    period = 1.0 / load_case("mini-breaker").system().frequency
    even = np.abs(np.diff(moments) - period) < 1e-4
    assert even.mean() > 0.8  # where a busy machine lets the picture stand still the sound begins anew
    page.click("#play")
    still = page.evaluate("window.asked.length")
    page.evaluate(FRAMES, 40)
    assert page.evaluate("window.asked.length") == still


# --- report, experiment


def test_the_report_is_one_file(desk: Desk) -> None:
    """Of every kind of hammer; what stands in it is told by the library."""
    desk.page.route("**/api/report", lambda route: route.fulfill(content_type="text/html", body="<p>180 J"))
    for machine in ("mini-breaker", "valve-breaker", "stopped-beam"):
        page = desk.open(f"panel=report&machine={machine}")
        with page.expect_download() as waiting:
            page.click("#report-download")
        assert Path(waiting.value.path()).read_text(encoding="utf-8") == "<p>180 J"


def test_an_experiment_fills_up_and_its_results_are_kept(desk: Desk) -> None:
    page = desk.open("panel=experiment&machine=mini-breaker")
    page.fill("#experiment-starts", "40")
    page.click("#experiment-run")
    expect(page.locator("#experiment-status")).to_contain_text("all followed")
    shares = page.locator("#experiment-shares .share")
    expect(shares.first).to_have_attribute("data-label", "z=1/1")
    assert page.locator("#experiment-progress").evaluate("bar => bar.value") == 1
    with page.expect_download() as waiting:
        page.get_by_role("button", name="Download CSV").click()
    rows = Path(waiting.value.path()).read_text(encoding="utf-8").strip().splitlines()
    assert len([row for row in rows if not row.startswith("#")]) == 41
    until(page, "location.hash.includes('starts=40')")


def test_where_a_machine_ends_up_is_counted(desk: Desk) -> None:
    page = desk.open("panel=experiment&machine=valve-breaker&starts=30")
    page.click("#experiment-run")
    expect(page.locator("#experiment-status")).to_contain_text("30 starts, all followed")
    expect(page.locator("#experiment-shares .share").first).to_have_attribute("data-label", "runs 1/1")


def test_an_experiment_can_be_interrupted_and_is_bounded(desk: Desk, request: pytest.FixtureRequest) -> None:
    request.node.expected_words = ("422",)
    page = desk.open("panel=experiment&machine=mini-breaker&emodes=16")
    page.fill("#experiment-starts", "20000")
    page.click("#experiment-run")
    until(page, "document.querySelector('#experiment-status').textContent.includes(' of ')")
    page.click("#experiment-cancel")
    expect(page.locator("#experiment-status")).to_contain_text("Cancelled")
    expect(page.locator("#experiment-run")).to_be_enabled()
    done = int(page.locator("#experiment-status").inner_text().split(":")[1].split()[0])
    assert 0 < done < 20000
    with page.expect_download() as waiting:  # what had been followed is kept
        page.get_by_role("button", name="Download CSV").click()
    rows = Path(waiting.value.path()).read_text(encoding="utf-8").strip().splitlines()
    assert len([row for row in rows if not row.startswith("#")]) == done + 1
    page.locator("#experiment-form").evaluate("form => { form.noValidate = true; }")
    page.fill("#experiment-starts", "999999999")
    page.click("#experiment-run")
    expect(page.locator("#experiment-problem")).not_to_have_text("")
    expect(page.locator("#experiment-status")).to_have_text("Not started: no start was followed.")
    expect(page.locator("#experiment-files")).to_be_hidden()


REBOUND = "start.position=0&start.velocity=-2.4&start.time=2.85&simulation.modes=0&simulation.impacts=1500"


def test_the_headline_tells_of_the_motion_that_plays(desk: Desk) -> None:
    """Period doubling, as the server simulates it from a start."""
    meanings = {1.0: "one blow every load period", 0.86: "2 blows in 2 load periods"}
    meanings |= {0.805: "4 blows in 4 load periods", 0.788: "never repeat"}
    for factor, label in zip(meanings, ["z=1/1", "z=2/2", "z=4/4", "aperiodic"], strict=True):
        case = (
            f"system.s=20&system.d=0.005&system.restitution=0.8&load.kind=harmonic&load.mean={factor}&load.amplitude=1"
        )
        page = desk.open(f"source=start&window=settled&cycles=8&{case}&{REBOUND}")
        expect(page.locator("#verdict")).to_have_text(f"Plays: {label}")
        expect(page.locator("#stage")).to_have_attribute("data-label", label)
        expect(page.locator("#reason")).to_contain_text(meanings[factor])
        summary = simulation_answer(case_of(knows(page, "core/state.js:data.tables"), "doubling")).motion.summary
        assert summary.blow_energy is not None
        assert float(figure(page, "mean blow energy")) == pytest.approx(summary.blow_energy, rel=5e-3)
    page.click("#tab-orbits")
    page.get_by_role("button", name="Steady motion").click()
    expect(page.locator("#verdict")).to_have_text("Unstable")


def test_an_unstable_motion_is_not_called_steady_and_a_blow_counts_once(desk: Desk) -> None:
    load = "load.kind=harmonic&load.mean=0.5&load.amplitude=1"
    page = desk.open(f"panel=orbits&system.s=20&system.d=0.005&system.restitution=0.4&{load}")
    moved(page)
    facts = {
        row.locator("dt").inner_text(): row.locator("dd").inner_text()
        for row in page.locator("#motion-facts > div").all()
    }
    assert facts["steady motion"] == "unstable" and "ended by" not in facts
    assert facts["blows in view"] == "1" and facts["shown"].endswith("1 load period")
    expect(page.locator("#motion-status")).to_contain_text("unstable")
    page.select_option("#cycles", "4")
    expect(page.locator("#motion-facts dd").nth(3)).to_have_text("4")
    expect(page.locator("#stage")).to_have_attribute("aria-label", re.compile("4 blows in view"))
    slide(page, "load_factor", 0.65)
    expect(page.locator("#motion-facts dd").nth(1)).to_have_text("stable")
