"""The motion that runs in the browser, against the package's own simulation of a rigid hammer."""

from __future__ import annotations

from typing import Any

import httpx
import numpy as np
import pytest

pytest.importorskip("fastapi")

from playwright.sync_api import Page

from percuss import Start, Stop, Trajectory, run
from percuss.case import load_case, machine_answer, simulation_answer
from percuss.case.case import case_of
from web_desk import BYTES, WAIT, Desk, sound

pytestmark = pytest.mark.browser

RUNS = """async cases => {
  /* each case from its start to its end, in frames of uneven length; and what it is called long after */
  const { Live } = await import("/static/motion/live.js");
  return cases.map(({ motion, start, end, longer = 0 }) => {
    const live = new Live(motion);
    live.place({ gap: start.position, velocity: start.velocity, phase: start.time, ...start.place });
    live.time = start.time;
    const events = [];
    for (let i = 0; live.now < end; i++)
      events.push(...live.advance((end - start.time) * [0.002, 0.11, 0.0003][i % 3]));
    let label = live.label();
    for (let i = 0; i < longer && !label; i++) {
      live.advance((end - start.time) / 20);
      label = live.label();
    }
    return { events, label };
  });
}"""


DOUBLED: dict[str, Any] = {
    "system": {"s": 20.0, "d": 0.005, "restitution": 0.8},
    "load": {"kind": "harmonic", "mean": 0.86, "amplitude": 1.0},
    "start": {"position": 0.0, "velocity": -2.4, "time": 2.85},
}
"""A motion that strikes twice in two periods, by turns hard and softly."""


class Server:
    """The answers of the server that the page is from."""

    def __init__(self, address: str) -> None:
        self.address = address

    def __call__(self, path: str, **asked: Any) -> Any:
        found = httpx.post(f"{self.address}api/{path}", json=asked, timeout=WAIT / 1000)
        assert found.status_code == 200, found.text
        return found.json()

    def law(self, tables: dict[str, Any]) -> dict[str, Any]:
        law: dict[str, Any] = self("case", case=tables)["motion"]
        return law

    def simulated(self, tables: dict[str, Any], impacts: int, **more: Any) -> Any:
        return self("simulate", case=tables, simulation={"modes": 0, "impacts": impacts, **more})


@pytest.fixture
def asked(server: str) -> Server:
    return Server(server)


def told(events: list[dict[str, Any]], *kinds: str) -> list[dict[str, Any]]:
    return [event for event in events if event["kind"] in kinds]


def along(live: list[dict[str, Any]], known: list[dict[str, Any]]) -> list[tuple[dict[str, Any], dict[str, Any]]]:
    """The events of both in pairs; the last bounces before a chatter ends may be more of one than of the other."""
    pairs, i, j = [], 0, 0
    while i < len(live) and j < len(known):
        one, other = live[i]["kind"], known[j]["kind"]
        if one != other:
            assert {one, other} == {"impact", "rest"}, (live[i], known[j])
            i, j = i + (one == "impact"), j + (other == "impact")
            continue
        pairs.append((live[i], known[j]))
        i, j = i + 1, j + 1
    return pairs


def periodic(rng: np.random.Generator, kind: str) -> dict[str, Any]:
    """A load of a kind whose mean pushes, most of the time."""
    if kind == "harmonic":
        return {"kind": kind, "mean": rng.uniform(0.2, 1.2), "amplitude": 1.0}
    if kind == "square":
        return {"kind": kind, "amplitude": 1.0, "kappa": rng.uniform(1.05, 1.7)}
    if kind == "steps":
        size = int(rng.integers(2, 6))
        breaks = np.sort(rng.uniform(0.0, 6.28, size)).tolist()
        return {"kind": kind, "breaks": breaks, "values": rng.uniform(-1.0, 1.8, size).tolist()}
    size = int(rng.integers(1, 64))
    waves = rng.normal(size=(size, 2)) / np.arange(1, size + 1)[:, None] ** 1.2
    return {"kind": kind, "coefficients": [[rng.uniform(0.1, 0.8), 0.0], *waves.tolist()]}


@pytest.mark.parametrize("kind", ["harmonic", "square", "steps", "fourier"])
def test_a_bar_under_a_clock_strikes_when_the_package_says(desk: Desk, asked: Server, kind: str) -> None:
    """As far as neither forgets: within a multiple of what a 1e-13 of the restitution changes."""
    rng = np.random.default_rng(len(kind) + 40)
    cases, known, twins, rebounds = [], [], [], (0.0, 0.15, 0.5, 0.7, 0.95)
    for i in range(15):
        restitution, drag = rebounds[i % 5], float(rng.choice([0.0, rng.uniform(0.0, 0.5)]))
        tables: dict[str, Any] = {
            "system": {"s": 20.0, "d": drag, "restitution": restitution},
            "load": periodic(rng, kind),
            "start": {"position": -rng.uniform(0.1, 2.0), "velocity": rng.normal(), "time": rng.uniform(0.0, 6.28)},
        }
        known.append(asked.simulated(tables, 60, periodic=False))
        other = {**tables["system"], "restitution": restitution * (1.0 - 1e-13)}
        twins.append(asked.simulated({**tables, "system": other}, 60, periodic=False)["events"])
        end = known[-1]["events"][-1]["time"] + 1e-6 if known[-1]["events"] else 20.0
        cases.append({"motion": asked.law(tables), "start": tables["start"], "end": end})
    found = desk.module("motion/live.js").evaluate(RUNS, cases)
    compared = 0
    for live, one, twin in zip(found, known, twins, strict=True):
        assert not told(live["events"], "switch")
        for i, event in enumerate(one["events"][: len(twin)]):
            event["doubt"] = abs(twin[i]["time"] - event["time"]) if twin[i]["kind"] == event["kind"] else 1.0
        for i in range(1, len(one["events"])):  # a rest forgets what came before, not what is compared
            before = one["events"][i - 1].get("doubt", 1.0)
            one["events"][i]["doubt"] = max(one["events"][i].get("doubt", 1.0), before)
        for own, its in along(live["events"], told(one["events"], "impact", "rest", "release")):
            if its["doubt"] > 1e-11:
                break  # chaos has the word
            assert own["time"] == pytest.approx(its["time"], rel=0.0, abs=1e-9 + 1e3 * its["doubt"])
            if own["kind"] == "impact":
                assert own["speed"] == pytest.approx(its["impact_velocity"], abs=1e-9 + 1e3 * its["doubt"])
            compared += 1
    assert compared > 200


def test_the_settled_motion_has_the_name_that_the_package_gives_it(desk: Desk, asked: Server) -> None:
    """Over a grid of restitution and load factor, whatever settles there; with the start of the package."""
    cases, known = [], []
    for restitution in (0.0, 0.1, 0.2, 0.35, 0.5, 0.8):
        for factor in (0.15, 0.25, 0.4, 0.7, 0.84, 1.05):
            tables: dict[str, Any] = {
                "system": {"s": 20.0, "d": 0.02, "restitution": restitution},
                "load": {"kind": "harmonic", "mean": factor, "amplitude": 1.0},
                "start": {"position": -1.0, "velocity": 0.0, "time": 0.0},
            }
            known.append(asked.simulated(tables, 10_000)["label"])
            cases.append({"motion": asked.law(tables), "start": tables["start"], "end": 500.0, "longer": 2000})
    labels = [one["label"] for one in desk.module("motion/live.js").evaluate(RUNS, cases)]
    sure = [(own, its) for own, its in zip(labels, known, strict=True) if its[-1] not in "?cd"]
    assert [own for own, _ in sure] == [its for _, its in sure]
    assert len(sure) > 24 and {its.split("/")[0] for _, its in sure} == {"z=1", "rest", "chatter"}
    wild = [own for own, its in zip(labels, known, strict=True) if its == "aperiodic"]
    assert not any(wild)
    away = {
        "system": {"s": 20.0, "d": 0.0, "restitution": 0.5},
        "load": {"kind": "harmonic", "mean": -0.1, "amplitude": 1.0},
    }
    case = {"motion": asked.law(away), "start": {"position": -1.0, "velocity": 0.0, "time": 0.0}, "end": 100.0}
    doubled = {"motion": asked.law(DOUBLED), "start": DOUBLED["start"], "end": 500.0, "longer": 40}
    assert [one["label"] for one in desk.page.evaluate(RUNS, [case, doubled])] == ["departed", "z=2/2"]


def test_machines_that_switch_themselves_run_as_the_package_says(desk: Desk, asked: Server) -> None:
    rng = np.random.default_rng(5)
    cases, known = [], []
    for i in range(30):
        power: dict[str, Any] = {"to": "power", "side": "back", "behind": rng.uniform(0.5, 1.5)}
        if rng.random() < 0.2:
            power = {"to": "power", "side": "back", "speed": rng.uniform(0.2, 0.9)}
        back = {"to": "return", "on": "impact"} if i % 3 else {"to": "return", "behind": 0.2, "side": "front"}
        for port in (power, back):
            port |= {"delay": rng.uniform(0.01, 0.6)} if rng.random() < 0.6 else {}
        states = {"return": -rng.uniform(0.2, 1.5), "power": rng.uniform(0.5, 2.5)}
        gas = {"chamber": {"force": rng.uniform(0.0, 0.2), "stiffness": rng.uniform(0.0, 0.9)}} if i % 2 else {}
        tables: dict[str, Any] = {
            "system": {"s": 20.0, "d": float(rng.choice([0.0, 0.2])), "restitution": (0.0, 0.2, 0.5, 0.8)[i % 4]},
            "load": {"kind": "valve", "states": states, "ports": [power, back], "start_state": "return", **gas},
            "start": {"position": -rng.uniform(0.1, 1.5), "velocity": 0.3 * rng.normal()},
        }
        known.append(asked.simulated(tables, 60))
        end = known[-1]["events"][-1]["time"] + 1e-6 if known[-1]["events"] else 20.0
        start = {**tables["start"], "time": 0.0}
        cases.append({"motion": asked.law(tables), "start": start, "end": end, "longer": 1000})
    found, compared = desk.module("motion/live.js").evaluate(RUNS, cases), 0
    for live, one in zip(found, known, strict=True):
        wanted = [{**event, "kind": event["kind"].replace("valve", "switch")} for event in one["events"]]
        for own, its in along(live["events"], told(wanted, "impact", "rest", "release", "switch")):
            assert own["time"] == pytest.approx(its["time"], rel=0.0, abs=1e-9)
            if own["kind"] == "impact":
                assert own["speed"] == pytest.approx(its["speed"], abs=1e-9)
            if own["kind"] == "switch":
                assert own["state"] == its["to"]
            compared += 1
        assert live["label"] == one["label"] or one["label"] in ("undecided", "irregular")
    assert compared > 400


@pytest.mark.parametrize("name", ["valve-breaker", "valve-drifter"])
def test_sample_machines_run_on_their_cycle_in_seconds(desk: Desk, asked: Server, name: str) -> None:
    """From 30 cm behind the tool; the cycle is that of the exact equations, which have no part in a simulation."""
    machine = load_case(name).machine()
    cycle = machine_answer(load_case(name), 0).cycle
    assert cycle is not None
    about = httpx.get(f"{asked.address}api/machines/{name}", timeout=WAIT / 1000).json()
    law = about["motion"]
    begin = {"position": -0.3, "velocity": 0.0, "time": 0.0}
    (live,) = desk.module("motion/live.js").evaluate(RUNS, [{"motion": law, "start": begin, "end": 4.0}])
    blows = told(live["events"], "impact")
    assert live["label"] == "runs 1/1"
    assert blows[-1]["time"] - blows[-2]["time"] == pytest.approx(cycle.period, rel=1e-9)
    assert blows[-1]["speed"] == pytest.approx(cycle.blow_speeds[0], rel=1e-9)
    assert law["scales"]["length_m"] == pytest.approx(machine.length_scale)


def begun(motion: Trajectory) -> dict[str, Any]:
    """The q_n and q_n′ at the start of a motion, to be placed."""
    at, unit = motion.modal([motion.begin_time]), motion.spectrum.unit
    return {name: (unit * one[1:, 0]).tolist() for name, one in (("places", at.displacement), ("rates", at.velocity))}


def test_structures_that_are_held_move_as_the_package_says(desk: Desk, asked: Server) -> None:
    """Of one mode and of several, which the wall lets go in another state each time."""
    rng = np.random.default_rng(11)
    cases, known = [], []
    for i in range(24):
        size, steps = (1, 2, 3, 5)[i % 4], rng.uniform(-1.0, 1.2, 3).tolist()
        omega = np.sort(rng.uniform(0.4, 12.0, size))
        body = {
            "kind": "modes",
            "omega": omega.tolist(),
            "damping": (rng.uniform(0.02, 0.2, size) * omega).tolist(),
            "contact": rng.normal(size=size).tolist(),
            "drive": rng.normal(size=size).tolist(),
            "gap": rng.uniform(-0.1, 0.1),
        }
        load = {"kind": "steps", "breaks": [0.4, 2.5, 4.4], "values": steps}
        if i % 3:
            load = {"kind": "harmonic", "mean": rng.uniform(0.0, 0.5), "amplitude": 1.0}
        tables = {"body": body, "system": {"restitution": (0.0, 0.3, 0.6, 0.8)[i // 4 % 4]}, "load": load}
        case = case_of({**tables, "start": {"position": -0.05, "velocity": 0.0}})
        motion = run(case.system(), Start.rigid(position=-0.05), modes=size, stop=Stop(impacts=150))
        begin, unit = motion.modal([0.0]), motion.spectrum.unit
        place = {
            "places": (unit * begin.displacement[1:, 0]).tolist(),
            "rates": (unit * begin.velocity[1:, 0]).tolist(),
        }
        known.append(motion)
        end = float(motion.events.time[-1]) + 1e-6 if len(motion.events) else 20.0
        start = {"position": 0.0, "velocity": 0.0, "time": 0.0, "place": place}
        cases.append({"motion": asked.law(tables), "start": start, "end": end, "longer": 2000})
    found, compared, rests, named = desk.module("motion/live.js").evaluate(RUNS, cases), 0, 0, 0
    for live, motion in zip(found, known, strict=True):
        wanted = [
            {"kind": event.kind, "time": event.time, "speed": event.impact_velocity}
            for event in motion.events
            if event.kind in ("impact", "rest", "release")
        ]
        for own, its in along(live["events"], wanted)[:40]:  # before errors grow
            assert own["time"] == pytest.approx(its["time"], rel=0.0, abs=1e-8)
            assert own["kind"] != "impact" or own["speed"] == pytest.approx(its["speed"], abs=1e-8)
            compared, rests = compared + 1, rests + (own["kind"] == "release")
        if motion.label not in ("undecided", "aperiodic"):
            assert live["label"] == motion.label
            named += 1
    assert compared > 500 and rests > 15 and named > 14


@pytest.mark.parametrize("name", ["stopped-oscillator", "stopped-beam"])
def test_sample_structures_come_to_their_motion(desk: Desk, asked: Server, name: str) -> None:
    motion = simulation_answer(load_case(name)).motion
    law = httpx.get(f"{asked.address}api/machines/{name}", timeout=WAIT / 1000).json()["motion"]
    start = {"position": 0.0, "velocity": 0.0, "time": 0.0, "place": begun(motion)}
    case = {"motion": law, "start": start, "end": 2000.0, "longer": 10}
    (live,) = desk.module("motion/live.js").evaluate(RUNS, [case])
    assert live["label"] == motion.label == "z=1/1"
    last, own = motion.events.of("impact")[-1], told(live["events"], "impact")[-1]
    assert own["speed"] == pytest.approx(last.impact_velocity, rel=1e-6)
    assert own["phase"] == pytest.approx(last.phase, abs=1e-6)
    assert own["energy"] == pytest.approx(last.kinetic_energy, rel=1e-6)


TOUCH = """async ({ motion, offsets }) => {
  const { Live } = await import("/static/motion/live.js");
  return offsets.map(offset => {
    const live = new Live(motion);
    live.place({ gap: -2 + offset, velocity: 0, phase: 0 });
    const events = [];
    for (let i = 0; i < 400; i++) events.push(...live.advance(0.05));
    return events;
  });
}"""


def test_a_touch_is_an_impact_and_a_near_miss_is_none(desk: Desk, asked: Server) -> None:
    """x″ = cos t from rest at x = −2 + ε comes to x = ε at t = π, with the curvature −1 there; and never farther."""
    bar = {
        "system": {"s": 20.0, "d": 0.0, "restitution": 0.5},
        "load": {"kind": "fourier", "coefficients": [[0, 0], [1, 0]]},
    }
    offsets = [1e-6, 1e-10, 1e-13, -1e-13, -1e-10, -1e-6]
    found = desk.module("motion/live.js").evaluate(TOUCH, {"motion": asked.law(bar), "offsets": offsets})
    assert [bool(events) for events in found] == [True, True, True, False, False, False]
    for offset, events in zip(offsets[:3], found, strict=False):
        speed = np.sqrt(2.0 * offset)
        assert events[0]["time"] == pytest.approx(np.pi - speed, abs=1e-3 * speed + 1e-8)
        assert events[0]["speed"] == pytest.approx(speed, rel=0.05)


PORTS = """async ({ far, near }) => {
  const { Live } = await import("/static/motion/live.js");
  const live = new Live(far);
  live.place({ gap: -0.5, velocity: -0.1 });
  const before = live.advance(0.2);
  live.become(near);
  const after = live.advance(0.2);
  return { before, after };
}"""


def test_a_port_that_is_moved_over_the_piston_is_felt(desk: Desk, asked: Server) -> None:
    """It stays uncovered, as if the piston had passed it, and its order comes after its delay."""

    def law(*ports: dict[str, Any]) -> dict[str, Any]:
        states = {"return": -0.5, "power": 1.5}
        load = {"kind": "valve", "states": states, "ports": list(ports), "start_state": "return"}
        return asked.law({"system": {"s": 20.0, "d": 0.0, "restitution": 0.3}, "load": load})

    back = {"to": "return", "on": "impact"}
    power = {"to": "power", "behind": 2.0, "side": "back", "delay": 0.05}
    laws = {"far": law(power, back), "near": law({**power, "behind": 0.4}, back)}
    found = desk.module("motion/live.js").evaluate(PORTS, laws)
    assert found["before"] == []
    (switch,) = found["after"]
    assert switch["state"] == "power" and switch["time"] == pytest.approx(0.25, abs=1e-12)


CYCLE = """async ({ law, cycle, disturbance }) => {
  const { Live } = await import("/static/motion/live.js");
  const { onCycle } = await import("/static/motion/settled.js");
  const live = new Live(law);
  live.place({ ...onCycle(law.valve, law.restitution, cycle), disturbance });
  return live.advance(3.5 * cycle.period);
}"""


@pytest.mark.parametrize("name", ["valve-breaker", "valve-drifter"])
def test_a_machine_is_put_on_its_cycle(desk: Desk, asked: Server, name: str) -> None:
    """With the orders that wait at the blow, which come late in both."""
    cycle = machine_answer(load_case(name), 0).to_json_dict()
    law = httpx.get(f"{asked.address}api/machines/{name}", timeout=WAIT / 1000).json()["motion"]
    sent = {"law": law, "cycle": cycle, "disturbance": 0.0}
    events = desk.module("motion/live.js").evaluate(CYCLE, sent)
    blows = told(events, "impact")
    assert [one["time"] / cycle["period"] for one in blows] == pytest.approx([1.0, 2.0, 3.0], rel=1e-9)
    assert [one["speed"] for one in blows] == pytest.approx([cycle["blows"][-1]["speed"]] * 3, rel=1e-9)
    pushed = told(desk.page.evaluate(CYCLE, {**sent, "disturbance": 1e-3}), "impact")
    assert 1e-7 < abs(pushed[0]["speed"] / blows[0]["speed"] - 1.0) < 1e-3


CHANGED = """async ({ motion, other, scaled }) => {
  const { Live } = await import("/static/motion/live.js");
  const seen = live => [live.gap, live.velocity, live.angle];
  const live = new Live(motion);
  live.place({ gap: -0.5, velocity: 0.2, phase: 1 });
  live.advance(7.3);
  const before = seen(live);
  live.become(other);
  const after = seen(live), unnamed = live.label();
  live.become(motion);
  const back = seen(live);
  const whole = live.advance(0.5).length;
  /* one that is told of more seconds and metres is the same motion in other numbers */
  const small = new Live(scaled.small);
  small.place({ gap: -0.5, velocity: 0.2, phase: 1 });
  small.advance(0.3);
  const own = seen(small);
  small.become(scaled.large);
  return { before, after, back, unnamed, whole, own, large: seen(small) };
}"""


def test_a_law_that_changes_keeps_where_the_bar_is(desk: Desk, asked: Server) -> None:
    tables: dict[str, Any] = {
        "system": {"s": 20.0, "d": 0.1, "restitution": 0.4},
        "load": {"kind": "harmonic", "mean": 0.3, "amplitude": 1.0},
    }
    motion = asked.law(tables)
    other = asked.law(
        {"system": {"s": 5.0, "d": 0.3, "restitution": 0.7}, "load": {"kind": "square", "amplitude": 1.0, "kappa": 1.2}}
    )
    small = {**motion, "scales": {"length_m": 0.5, "time_s": 0.01}}
    large = {**motion, "scales": {"length_m": 1.0, "time_s": 0.02}}
    found = desk.module("motion/live.js").evaluate(
        CHANGED, {"motion": motion, "other": other, "scaled": {"small": small, "large": large}}
    )
    assert found["after"] == pytest.approx(found["before"], abs=1e-14) and found["unnamed"] == ""
    assert found["back"] == pytest.approx(found["before"], abs=1e-14)
    gap, velocity, angle = found["own"]
    assert found["large"] == pytest.approx([0.5 * gap, velocity, angle], abs=1e-14)  # (1 m/0.5 m), (50 m/s)/(50 m/s)


AHEAD = """async ({ motion, orbit }) => {
  const { Live } = await import("/static/motion/live.js");
  const live = new Live(motion);
  live.place({ ...orbit, disturbance: 1e-3 });
  const [foreseen, came] = [[], []];
  for (let i = 0; i < 8000; i++) {
    for (const event of live.ahead(0.5)) {
      const at = live.now + event.after;
      const known = foreseen.some(({ kind, time }) => kind === event.kind && Math.abs(time - at) < 1e-9);
      if (!known) foreseen.push({ ...event, time: at });
    }
    came.push(...live.advance(0.02 + 0.01 * (i % 2)));
  }
  const past = foreseen.filter(({ time }) => time < live.now);
  return { foreseen: past, came, blows: live.blows, label: live.label() };
}"""


def test_what_comes_is_known_ahead_and_what_was_is_kept(desk: Desk, asked: Server) -> None:
    tables: dict[str, Any] = {
        "system": {"s": 20.0, "d": 0.0, "restitution": 0.6},
        "load": {"kind": "harmonic", "mean": 0.9, "amplitude": 1.0},
    }
    (steady,) = [one for one in asked("quick", case=tables)["orbits"] if one["stable"]]
    orbit = {"phase": steady["phase"], "velocity": -0.6 * steady["impact_velocity"]}
    found = desk.module("motion/live.js").evaluate(AHEAD, {"motion": asked.law(tables), "orbit": orbit})
    assert [one["kind"] for one in found["foreseen"]] == [one["kind"] for one in found["came"]]
    for own, its in zip(found["foreseen"], found["came"], strict=True):
        assert own["time"] == pytest.approx(its["time"], abs=1e-9)
    assert found["label"] == "z=1/1" and len(found["blows"]) == 30
    assert found["blows"][-1]["phase"] == pytest.approx(steady["phase"], abs=1e-6)


HEARD = f"""async ({{ motion, other, start, rate, seconds, change, frames }}) => {{
  /* a live motion heard while frames come at uneven moments; at one of them its law becomes another one */
  const text = {BYTES};
  const {{ Live }} = await import("/static/motion/live.js");
  const {{ limited }} = await import("/static/motion/sound.js");
  const {{ LiveTrack }} = await import("/static/motion/sound.js");
  const audio = new OfflineAudioContext(1, 48000 * seconds, 48000);
  const track = new LiveTrack(audio, limited(audio));
  const live = new Live(motion);
  live.place(start);
  const came = [];
  let [now, changed] = [0, false];
  const frame = () => {{
    came.push(...live.advance((audio.currentTime - now) * rate));
    now = audio.currentTime;
    if (!changed && now > change) {{
      live.become(other);
      changed = true;
    }}
    track.follow(live, rate, {{ frequency: 1200 }});
  }};
  frame();
  for (const moment of frames)
    audio.suspend(moment).then(() => {{
      frame();
      audio.resume();
    }});
  const samples = text((await audio.startRendering()).getChannelData(0));
  const times = came.filter(({{ kind }}) => kind === "impact").map(({{ time }}) => time / rate);
  return {{ samples, times, speeds: live.blows.map(({{ speed }}) => speed) }};
}}"""


def heard(page: Page, **asked: Any) -> tuple[Any, Any]:
    """When blows begin in the sound, and when they came (s)."""
    uneven = np.cumsum(np.random.default_rng(7).uniform(0.008, 0.09, 200))
    frames = [float(moment) for moment in uneven if moment < asked["seconds"] - 0.05]
    found = page.evaluate(HEARD, {"frames": frames, **asked})
    loud = np.flatnonzero(np.abs(sound(found["samples"])) > 1e-6)
    begins = loud[np.concatenate([[True], np.diff(loud) > 240])] / 48000.0  # after 5 ms of silence
    return begins, np.array(found["times"])


def test_a_doubled_motion_is_heard_as_evenly_as_it_strikes(desk: Desk, asked: Server) -> None:
    """Long and short in turn, each to 1 ms of what the package has, however unevenly frames come."""
    struck = told(asked.simulated(DOUBLED, 4000)["events"], "impact")[-5:]
    motion, rate = asked.law(DOUBLED), 10.0
    first = struck[0]
    start = {"phase": first["phase"], "velocity": first["rebound_velocity"]}
    page = desk.module("motion/live.js")
    begins, came = heard(page, motion=motion, other=motion, start=start, rate=rate, seconds=8.0, change=99.0)
    gaps = np.diff([one["time"] for one in struck]) / rate
    assert abs(gaps[0] - gaps[1]) > 0.02  # by turns
    assert len(begins) >= 11
    assert np.diff(begins) == pytest.approx(np.resize(gaps[1:3], len(begins) - 1), abs=1e-3)
    assert begins[: len(came)] - came[: len(begins)] == pytest.approx((begins - came[: len(begins)])[0], abs=1e-3)


def test_a_law_that_changes_is_heard_at_once(desk: Desk, asked: Server) -> None:
    """No blow of the old law sounds after the change, and none of the new one is missing."""
    hard = {**DOUBLED, "load": {"kind": "harmonic", "mean": 1.0, "amplitude": 1.0}}
    motion, other = asked.law(hard), asked.law({**hard, "load": {"kind": "harmonic", "mean": 0.4, "amplitude": 1.0}})
    start = {"gap": 0.0, "velocity": -2.5, "phase": 2.8}
    begins, came = heard(
        desk.module("motion/live.js"), motion=motion, other=other, start=start, rate=10.0, seconds=8.0, change=3.02
    )
    apart = came[np.concatenate([[True], np.diff(came) > 0.3])]  # each sound has ended before
    assert np.count_nonzero(came > 3.02) > 2
    near = [np.abs(begins - time).min() for time in apart]
    assert np.max(near) < 0.012 and np.ptp(near) < 2e-3  # the limiter looks ahead by some milliseconds
    assert np.all([np.abs(came - time).min() < 0.012 for time in begins])
