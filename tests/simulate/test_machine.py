"""The simulated machine that switches its own valve: known numbers, energy, rest, stalls, labels, ensembles."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from percuss.errors import ParameterError, PercussError
from percuss.model import Chamber, External, Kept, Machine, Port, Reversed, SteppedBar, Supply, UniformBar, Valve
from percuss.model.body import KelvinVoigt, Ratio, Table
from percuss.model.load.valve import Orders
from percuss.simulate import Start, Starts, Stop, Trajectory, run, simulate_many
from percuss.steady import self_excited_motion

CASES = json.loads((Path(__file__).parents[1] / "data" / "valve.json").read_text(encoding="utf-8"))


def machine_of(case: dict) -> tuple[Machine, list[str]]:
    system, valve = case["system"], case["valve"]
    names = [f"state {i}" for i in range(len(valve["forces"]))]
    ports = []
    for port in valve["ports"]:
        to, delay = names[port["to"]], float(port["delay"])
        if port.get("on") == "impact":
            ports.append(Port(to, on="impact", delay=delay))
        else:
            ports.append(Port(to, -float(port["position"]), port["side"], delay, port["at"]))
    forces = dict(zip(names, map(float, valve["forces"]), strict=True))
    body = UniformBar(system["s"], External(system["d"]))
    return Machine(body, Valve(forces, ports, chamber=Chamber(0.0, system["chamber"])), Kept(system["R"])), names


def numbers(values: list) -> np.ndarray:
    found = np.array(values, dtype=float)
    return np.where(np.abs(found) < 1e-30, 0.0, found)


@pytest.mark.parametrize("case", [c for c in CASES if c["kind"] == "run"], ids=lambda c: c["name"])
def test_a_known_run_comes_event_by_event(case: dict) -> None:
    machine, names = machine_of(case)
    start = case["start"]
    bar = Start.modal(numbers(start["u"]), numbers(start["v"]))
    stop = Stop(time=case["until"], periodic=False)
    motion = run(machine, bar.with_valve(names[start["state"]]), modes=case["system"]["N"], stop=stop)
    wanted, state = [], start["state"]
    for event in case["expect"].get("events", []):
        if event["kind"] != "valve" or event["to"] != state:  # an order for the state that stands is no event here
            wanted.append(event)
        state = event["to"] if event["kind"] == "valve" else state
    found = [event for event in motion.events if event.kind != "chatter"]
    resting = any(event["kind"] == "rest" for event in wanted)
    if resting:  # of the infinitely many blows the first are listed
        blows = sum(event["kind"] == "impact" for event in wanted)
        last = [i for i, event in enumerate(found) if event.kind == "impact"]
        until = next(i for i, event in enumerate(found) if event.kind == "rest")
        found = found[: last[blows - 1] + 1] + found[until : until + len(wanted)]
    else:
        assert len(found) == len(wanted)
    for event, want in zip(found, wanted, strict=False):
        assert event.kind == want["kind"]
        assert event.time == pytest.approx(float(want["time"]), abs=1e-11)
        if "speed" in want:
            assert event.impact_velocity == pytest.approx(float(want["speed"]), abs=1e-11)
        if "port" in want:
            assert event.port == want["port"]
        if "to" in want:
            assert event.state == names[want["to"]]
    if "end" in case["expect"]:
        end = case["expect"]["end"]
        at = motion.modal([case["until"]])
        assert at.displacement[:, 0] == pytest.approx(numbers(end["u"]), abs=1e-11)
        assert at.velocity[:, 0] == pytest.approx(numbers(end["v"]), abs=1e-11)
        assert motion.state([case["until"]])[0] == end["state"]


@pytest.mark.parametrize("case", [c for c in CASES if c["kind"] == "orbit"], ids=lambda c: c["name"])
def test_a_known_cycle_comes_back(case: dict) -> None:
    machine, names = machine_of(case)
    wanted, modes = case["expect"], case["system"]["N"]
    period, speed = float(wanted["period"]), float(wanted["blows"][-1]["speed"])
    pending = tuple((float(order["due"]), names[order["to"]]) for order in wanted["pending_after_blow"])
    last = pending[-1][1] if pending else names[wanted["state_after_blow"]]
    bar = Start.modal(numbers(wanted["after_blow"]["u"]), numbers(wanted["after_blow"]["v"]))
    start = bar.with_valve(names[wanted["state_after_blow"]], Orders(last, pending))
    motion = run(machine, start, modes=modes, stop=Stop(time=1.0001 * period, periodic=False))
    blows = motion.events.of("impact")
    assert blows.time == pytest.approx([float(blow["time"]) for blow in wanted["blows"]], abs=1e-9 * period)
    assert blows.impact_velocity == pytest.approx([float(blow["speed"]) for blow in wanted["blows"]], abs=1e-9 * speed)
    energies = [float(blow["kinetic_energy"]) for blow in wanted["blows"]]
    assert blows.kinetic_energy == pytest.approx(energies, rel=1e-9)
    own = [e for e in motion.events.of("port") if machine.valve.ports[e.port].on == "entering" and e.time <= period]
    assert [event.port for event in own] == [port["port"] for port in wanted["ports"]]
    assert [e.time for e in own] == pytest.approx([float(p["time"]) for p in wanted["ports"]], abs=1e-9 * period)
    assert [e.impact_velocity for e in own] == pytest.approx(
        [float(p["speed"]) for p in wanted["ports"]], abs=1e-9 * speed
    )
    changes = [e for e in motion.events.of("valve") if e.time <= period * (1.0 - 1e-12)]
    due = [(float(change["time"]), names[change["to"]]) for change in wanted["valve"]]
    assert [e.time for e in changes] == pytest.approx([time for time, _ in due], abs=1e-9 * period)
    assert [e.state for e in changes] == [to for _, to in due]
    after = motion.modal([blows.time[-1]])
    assert after.displacement[:, 0] == pytest.approx(numbers(wanted["after_blow"]["u"]), abs=1e-10)
    assert after.velocity[:, 0] == pytest.approx(numbers(wanted["after_blow"]["v"]), abs=1e-9)
    balance = motion.energy_balance(0.0, blows.time[-1])
    assert balance.input == pytest.approx(float(wanted["work_per_cycle"]), rel=1e-9)
    assert balance.imbalance == pytest.approx(0.0, abs=1e-10)


def two_force(
    back: float = 0.5, power: float = 1.0, R: float = 0.3, *, body=None, late: float = 0.0, kappa: float = 0.0,
    law=Kept, reads="centre", front: float | None = None,
) -> Machine:  # fmt: skip
    rear = Port("power", 1.0, "back", 0.1, reads)
    returning = Port("return", on="impact", delay=late) if front is None else Port("return", front, "front", late)
    valve = Valve({"return": -back, "power": power}, (rear, returning), chamber=Chamber(0.0, kappa))
    return Machine(body or UniformBar(5.0, External(0.02)), valve, law(R))


BODIES = {
    "none": UniformBar(5.0),
    "external": UniformBar(5.0, External(0.3)),
    "overdamped": UniformBar(5.0, External(50.0)),
    "ratio": UniformBar(5.0, Ratio(0.02)),
    "critical": UniformBar(5.0, Ratio(1.0)),
    "material": UniformBar(5.0, KelvinVoigt(0.05)),
    "table": UniformBar(5.0, Table((0.1, 40.0, 1.0))),
    "stepped": SteppedBar(5.0, (0.5, 0.5), (1.0, 0.5), Ratio(0.01)),
}


@pytest.mark.parametrize("kappa", [0.0, 0.2])
@pytest.mark.parametrize("name", BODIES)
def test_energy_closes(name: str, kappa: float) -> None:
    machine = two_force(1.5, 4.0, body=BODIES[name], kappa=kappa, reads=0.0, late=0.05)
    start = Start((-0.4, 0.02, -0.01), (0.3, 0.1, 0.2)).with_valve("power")
    motion = run(machine, start, modes=6, stop=Stop(time=9.0, periodic=False))
    assert motion.impacts >= 1
    balance = motion.energy_balance()
    assert balance.imbalance == pytest.approx(0.0, abs=1e-10)
    assert balance.impacts > 0.0
    part = motion.energy_balance(1.0, 5.0)
    assert part.imbalance == pytest.approx(0.0, abs=1e-10)


@pytest.mark.parametrize("kappa", [0.0, 0.4])
def test_the_law_that_turns_the_strain_takes_what_it_says(kappa: float) -> None:
    machine = two_force(R=0.3, kappa=kappa, law=Reversed, late=0.05)
    motion = run(machine, modes=5, stop=Stop(impacts=6, periodic=False))
    for event in motion.events.of("impact"):
        before, after = motion.energy([event.time], "left")[0], motion.energy([event.time])[0]
        assert before - after == pytest.approx(event.energy_lost, abs=1e-11)
    assert motion.gap(motion.blow_times) == pytest.approx(0.0, abs=1e-12)


def test_the_work_theorem_gives_the_blow_speed() -> None:
    """v² = 2 Σ Δ x/(1 − R²) without drag, whatever the chamber and the number of states."""
    ports = (Port("fast", 1.0, "back"), Port("slow", 0.4, "front"), Port("return", on="impact"))
    valve = Valve({"return": -0.6, "fast": 2.0, "slow": 0.7}, ports, chamber=Chamber(0.1, 0.3))
    start = Start.rigid(0.0).with_valve(orders=Orders("return"))  # the second port is uncovered, and was before
    motion = run(Machine(UniformBar(5.0), valve, Kept(0.4)), start, modes=0)
    wanted = 2.0 * (2.6 * 1.0 - 1.3 * 0.4) / (1.0 - 0.16)
    assert motion.label == "runs 1/1"
    assert motion.cycle is not None
    assert motion.cycle.blow_speed**2 == pytest.approx(wanted, rel=1e-8)
    assert motion.cycle.energy_lost == pytest.approx(0.5 * (1.0 - 0.16) * wanted, rel=1e-8)


def test_the_end_of_the_chatter_is_exact() -> None:
    """Under a constant push the bounces add up to 2Rv/(p(1 − R)) (theory §8.2)."""
    machine = two_force(0.5, 1.0, 0.6, body=UniformBar(5.0), late=9.0)
    start = Start.rigid(-0.3).with_valve("power", Orders("return", ((20.0, "return"),)))
    motion = run(machine, start, modes=0, stop=Stop(time=25.0, periodic=False))
    struck = motion.blow_times[0]
    rest = motion.events.of("rest").time[0]
    assert rest == pytest.approx(struck + 2.0 * 0.6 * math.sqrt(0.6) / 0.4, abs=1e-12)
    release = motion.events.of("release").time[0]
    assert release == 20.0
    assert motion.gap([rest, 0.5 * (rest + release), release]) == pytest.approx(0.0, abs=0.0)
    assert motion.gap([release + 0.5])[0] == pytest.approx(-0.5 * 0.5 * 0.25, abs=1e-14)


STALLS = {
    "stalls (on the tool)": (Valve({"hold": 0.2, "power": 1.0}, (Port("power", 1.0, "back"),)), Start.rigid(-0.5)),
    "stalls (leaves)": (Valve({"return": -0.2, "power": 1.0}, (Port("power", 0.1, "front"),)), Start.rigid(-0.5)),
    "stalls (in the chamber)": (
        Valve({"return": -0.2, "power": 1.0}, (Port("power", 1.0, "back"),), chamber=Chamber(0.0, 0.9)),
        Start.rigid(0.0),
    ),
}


@pytest.mark.parametrize("modes", [0, 6])
@pytest.mark.parametrize("label", STALLS)
def test_a_stall_is_proved(label: str, modes: int) -> None:
    valve, start = STALLS[label]
    motion = run(Machine(UniformBar(5.0, External(0.01)), valve, Kept(0.5)), start, modes=modes)
    assert (motion.label, motion.outcome) == (label, "stalls")
    assert label.removeprefix("stalls (").removesuffix(")") in ("on the tool", "leaves", "in the chamber")


def test_ever_weaker_blows_from_the_chamber_are_a_stall() -> None:
    valve = Valve({"return": -0.3, "power": 1.0}, (Port("power", 1.0, "back"), Port("return", on="impact")),
                  chamber=Chamber(0.0, 0.7))  # fmt: skip
    machine = Machine(UniformBar(20.0), valve, Kept(0.5))
    stalled = run(machine, Start.rigid(-0.75), modes=0)
    assert stalled.label == "stalls (in the chamber)"
    runs = run(machine, Start.rigid(-1.2).with_valve("power"), modes=0)
    assert runs.label == "runs 1/1"
    watched = run(machine, Start.rigid(-0.75), modes=0, stop=Stop(time=300.0, periodic=False))
    assert watched.label == "stalls (in the chamber)"
    assert watched.blow_speeds[1:12] == pytest.approx(0.5 * watched.blow_speeds[:11], rel=1e-6)


STALLING = Valve({"return": -0.3, "power": 0.8}, (Port("power", 1.0, "back"), Port("return", on="impact")),
                 chamber=Chamber(0.0, 1.15))  # fmt: skip


def test_the_last_blow_of_a_stalled_machine_is_followed() -> None:
    """From the rebound on y″ + d y′ + κy is the force, whose closed form is looked at closely."""
    machine, start = Machine(UniformBar(5.0, External(0.12)), STALLING, Kept(0.45)), Start.rigid(-0.8, 0.3)
    motion = run(machine, start.with_valve("power"), modes=0, stop=Stop(time=70.0))
    assert (motion.outcome, motion.label, motion.end_time) == ("stalls", "stalls (in the chamber)", 70.0)
    half, still = 0.06, -0.3 / 1.15
    turn = math.sqrt(1.15 - half * half)
    first, second = motion.blow_times
    t = np.linspace(first + 1e-6, 70.0, 40_000) - first
    v = -0.45 * motion.blow_speeds[0]
    wave = -still * np.cos(turn * t) + (v - half * still) / turn * np.sin(turn * t)
    struck = t[np.flatnonzero(still + np.exp(-half * t) * wave >= 0.0)[0]]
    assert second - first == pytest.approx(struck, abs=2e-3)
    assert (second, motion.blow_speeds[1]) == pytest.approx((4.7278, 0.4341), abs=1e-4)


@pytest.mark.parametrize("supplied", [False, True])
def test_an_order_for_the_state_that_stands_is_no_change(supplied: bool) -> None:
    """It came in place of a slower order, on the way back from the wall: the valve stays, and nothing is told."""
    ports = (Port("power", 0.3, "back", 2.0), Port("return", 0.6, "back", 0.1), Port("power", 1.0, "back"),
             Port("return", on="impact"))  # fmt: skip
    supply = Supply(0.3, 50.0) if supplied else None
    valve = Valve({"return": -0.3, "power": 1.0}, ports, chamber=Chamber(0.0, 0.5), supply=supply)
    start = Start.rigid(-0.1, -0.5).with_valve("return")
    motion = run(Machine(UniformBar(5.0), valve, Kept(0.3)), start, modes=0, stop=Stop(time=30.0))
    state, changes = "return", 0
    for event in motion.events:
        if event.kind == "valve":
            assert event.state != state
            state, changes = event.state, changes + 1
    demands = sum(event.kind == "port" for event in motion.events)
    assert 2 <= changes <= demands - 2


def test_a_valve_that_switches_without_end_at_a_port_stalls() -> None:
    """Two regions that overlap, each of which calls for the other's state: pushed out of both, into both."""
    ports = (Port("power", 1.0, "back"), Port("return", 1.0, "front"))
    machine = Machine(UniformBar(5.0, External(3.0)), Valve({"return": -1.0, "power": 1.0}, ports), Kept(0.5))
    motion = run(machine, Start.rigid(-0.95), modes=0, stop=Stop(time=1e6))
    assert motion.outcome in ("stalls", "periodic")
    assert motion.label in ("stalls (on a port)", "cycles without blow")
    assert motion.impacts == 0


def test_labels() -> None:
    free = UniformBar(20.0)
    labels = [run(two_force(0.3, 1.0, 0.2, body=free, late=late), modes=0).label for late in (0.2, 0.6, 1.5)]
    assert labels == ["runs 1/1", "double blow 2/1", "runs chatter/1"]
    ports = (Port("power", 1.0, "back"), Port("return", 0.9, "front"))
    idle = Machine(UniformBar(20.0, External(0.5)), Valve({"return": -1.0, "power": 0.5}, ports), Kept(0.2))
    assert run(idle, Start.rigid(-0.95), modes=0).label == "cycles without blow"
    wild = run(two_force(3.0, 1.0, 0.8, body=free, late=1.15), modes=0)
    assert wild.label == "irregular"


def test_orders_that_a_later_demand_overtakes_are_dropped() -> None:
    ports = (Port("power", 1.0, "back"), Port("return", 0.02, "front", 0.95))
    machine = Machine(UniformBar(5.0), Valve({"return": -3.0, "power": 1.0}, ports), Kept(0.8))
    motion = run(machine, Start.rigid(-0.3).with_valve("power"), modes=0)
    assert motion.label == "double blow 2/1" or motion.cycle is not None
    assert np.abs(motion.gap(np.linspace(0.0, motion.end_time, 500))).max() < 5.0


def test_time_may_begin_anywhere() -> None:
    machine = two_force(reads=0.0, late=0.05)
    stop = Stop(impacts=30, periodic=False)
    first = run(machine, Start.rigid(-0.4, time=0.0).with_valve("power"), modes=5, stop=stop)
    second = run(machine, Start.rigid(-0.4, time=1e3).with_valve("power"), modes=5, stop=stop)
    assert np.array_equal(first.states, second.states)
    assert second.events.time - 1e3 == pytest.approx(first.events.time, abs=1e-12 * 1e3)
    assert second.begin_time == 1e3


@pytest.mark.parametrize("factor", [2.0**-20, 2.0**12])
def test_the_unit_of_time_is_free(factor: float) -> None:
    """Powers of two change nothing but exponents."""
    machine = two_force(late=0.05, kappa=0.1)
    body = UniformBar(5.0 / factor, External(0.02 / factor))
    other = Machine(body, machine.valve.scaled(factor**-2, 1.0, factor), machine.contact)
    stop = Stop(impacts=40, periodic=False)
    one, two = (run(m, modes=4, stop=stop) for m in (machine, other))
    assert np.array_equal(one.events.code, two.events.code)
    assert np.array_equal(one.events.time * factor, two.events.time)
    assert np.array_equal(one.blow_speeds, two.blow_speeds * factor)


def first_blows(machine: Machine, modes: int) -> np.ndarray:
    return run(machine, modes=modes, stop=Stop(impacts=4, periodic=False)).blow_times


def test_soft_gas_short_delays_and_stiff_bars_are_limits() -> None:
    none, some = first_blows(two_force(), 4), first_blows(two_force(kappa=1e-9), 4)
    assert some == pytest.approx(none, abs=1e-7)
    late = [two_force(front=0.1, late=delay) for delay in (0.0, 1e-9)]
    assert first_blows(late[1], 4) == pytest.approx(first_blows(late[0], 4), abs=1e-7)
    rigid = first_blows(two_force(body=UniformBar(5e4)), 0)
    assert first_blows(two_force(body=UniformBar(5e4)), 4) == pytest.approx(rigid, abs=2e-3)
    assert first_blows(two_force(kappa=1e-250), 2) == pytest.approx(first_blows(two_force(), 2), abs=1e-12)


def test_a_port_sees_what_it_reads() -> None:
    machine = two_force(reads=0.0, front=0.15)
    motion = run(machine, modes=8, stop=Stop(impacts=10, periodic=False))
    for event in motion.events.of("port"):
        port = machine.valve.ports[event.port]
        at = 0.0 if port.reads == 0.0 else None
        where = motion.centre([event.time]) if at is None else motion.position(at, [event.time])[0]
        assert where[0] == pytest.approx(-port.behind, abs=1e-12)
        speed = motion.bar_velocity(0.0, [event.time], "left")[0, 0] if at == 0.0 else None
        assert speed is None or event.impact_velocity == pytest.approx(speed, abs=1e-11)


def test_force_and_state_over_time() -> None:
    machine = two_force(kappa=0.2)
    motion = run(machine, modes=3, stop=Stop(time=8.0, periodic=False))
    t = np.linspace(0.0, 8.0, 200)
    levels = np.array([machine.valve.force(name) for name, _ in machine.valve.pairs])[motion.state(t)]
    assert motion.force(t) == pytest.approx(levels - 0.2 * motion.position(0.0, t)[0], abs=1e-13)
    steps = np.diff(motion.gap(t))
    assert np.abs(steps).max() < 0.2  # it does not jump
    assert motion.gap(t[t > 0.4]).max() <= 1e-12  # no longer the ripple of three modes after the release
    with pytest.raises(ParameterError, match="simulate for longer"):
        motion.gap([9.0])


def test_many_are_as_one_by_one() -> None:
    machine = two_force(0.3, 1.0, 0.5, body=UniformBar(20.0), kappa=0.7)
    rng = np.random.default_rng(5)
    starts = [Start.rigid(-rng.uniform(0.0, 2.0)).with_valve(str(rng.choice(["return", "power"]))) for _ in range(90)]
    many = simulate_many(machine, starts, modes=0, workers=2)
    again = simulate_many(machine, starts, modes=0, workers=1)
    single = [run(machine, start, modes=0) for start in starts]
    assert many.label.tolist() == [motion.label for motion in single] == again.label.tolist()
    assert set(many.shares) == {"runs 1/1", "stalls (in the chamber)"}
    assert np.array_equal(many.period, again.period, equal_nan=True)
    wanted = [math.nan if motion.cycle is None else motion.cycle.period for motion in single]
    assert np.array_equal(many.period, wanted, equal_nan=True)
    assert np.array_equal(many.runs, many.label == "runs 1/1")
    assert many.impacts.tolist() == [motion.impacts for motion in single]
    several = simulate_many([machine, two_force(kappa=0.1)], Start.rigid(-1.2), modes=2)
    assert len(several) == 2


def test_an_ensemble_stops_when_told() -> None:
    machine = two_force(body=UniformBar(20.0))
    many = simulate_many(machine, [Start.rigid(-0.5)] * 400, modes=0, progress=lambda _: True)
    assert len(many) == 400
    assert set(many.outcome) <= {"periodic", "interrupted"}


def test_what_does_not_fit_is_refused() -> None:
    machine = two_force()
    with pytest.raises(ParameterError, match="state"):
        run(machine, Start.rigid(0.0).with_valve("neutral"))
    with pytest.raises(ParameterError, match="orders"):
        Start.rigid(0.0).with_valve(orders=Orders("power", ((2.0, "power"), (1.0, "return"))))
    with pytest.raises(ParameterError, match="start"):
        run(machine, Starts.rigid())  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="position"):
        run(machine, Start.rigid(0.1))
    with pytest.raises(ParameterError, match="amplitudes"):
        run(machine, Start.modal([-1.0, 0.1, 0.1]), modes=1)
    with pytest.raises(ParameterError, match="as many starts"):
        simulate_many([machine] * 2, [Start.rigid(-0.5)] * 3)


def test_a_motion_shows_itself() -> None:
    motion = run(two_force(), modes=2, stop=Stop(impacts=3, periodic=False))
    assert isinstance(motion, Trajectory)
    assert "3 impacts" in str(motion)
    assert "3 impact" in str(motion.events)
    assert motion.events[0].kind == motion.events.kind[0]
    assert len(motion.events[:2]) == 2
    cancelled = run(two_force(), modes=0, stop=Stop(impacts=10**6, periodic=False), progress=lambda _: True)
    assert cancelled.outcome == "interrupted"


# -- orders of the valve that wait -------------------------------------------------------------------------------------


LATE = 600.0
BOUNCING = Machine(
    UniformBar(20.0),
    Valve(
        {"power": 1.0, "return": 0.5},
        [Port("return", on="impact", delay=LATE), Port("power", behind=0.3, side="back", delay=LATE)],
    ),
    Kept(1.0),
)
"""Bounces for ever, and demands twice in each flight what is done much later."""


def test_every_order_of_hundreds_is_carried_out():
    stop = Stop(impacts=100_000, time=1.4 * LATE, periodic=False)
    motion = run(BOUNCING, Start.rigid(-1.0), modes=0, stop=stop)
    events, names = motion.events, BOUNCING.valve.pairs
    demands, changes = events.port >= 0, events.kind == "valve"
    due = events.time[demands] + LATE
    done = due < stop.time
    assert np.count_nonzero(due < 2.0 * LATE) > 400 and np.count_nonzero(done) > 150  # so many wait at once
    assert np.allclose(events.time[changes], due[done], rtol=0.0, atol=1e-9)
    demanded = [("return", "power")[port] for port in events.port[demands][done]]
    assert [names[state][0] for state in events.piece[changes]] == demanded
    many = simulate_many(BOUNCING, Start.rigid(-1.0), modes=0, stop=stop)
    assert many.outcome[0] == motion.outcome == "time" and many.impacts[0] == motion.impacts


def test_a_start_may_have_as_many_orders_as_it_likes():
    pending = tuple((0.5 + 0.01 * i, ("return", "power")[i % 2]) for i in range(700))
    start = Start.rigid(-1.0).with_valve("power", Orders("power", pending))
    motion = run(BOUNCING, start, modes=0, stop=Stop(impacts=100_000, time=8.0, periodic=False))
    times = motion.events.time[motion.events.kind == "valve"]
    assert np.allclose(times, [time for time, _ in pending], rtol=0.0, atol=1e-9)


DELAYED = (Port("power", 1.0, "back", 0.1), Port("return", on="impact", delay=0.3))
FAST = (Port("power", 0.6, "back", 0.05), Port("return", speed=0.5, side="front"))
FORCES = {"return": -0.4, "power": 1.8}
ENSEMBLES = {
    "gas": Machine(UniformBar(5.0), Valve(FORCES, DELAYED, chamber=Chamber(0.05, 1.2)), Kept(0.5)),
    "speed": Machine(UniformBar(9.0, Ratio(0.5)), Valve(FORCES, FAST, chamber=Chamber(0.04, 0.3)), Kept(0.8)),
    "pump": Machine(UniformBar(20.0, External(0.1)), Valve(FORCES, DELAYED, supply=Supply(0.8, 3.0)), Kept(0.6)),
    "pump, strain": Machine(
        SteppedBar(5.0, (0.5, 0.5), (1.0, 0.5)), Valve(FORCES, FAST, supply=Supply(0.5, 5.0)), Reversed(0.4)
    ),
    "late": BOUNCING,
}


@pytest.mark.parametrize("name", ENSEMBLES)
@pytest.mark.parametrize("modes", [0, 3])
def test_members_are_single_motions_to_the_bit(name: str, modes: int) -> None:
    machine, rng = ENSEMBLES[name], np.random.default_rng(7)
    stop = Stop(impacts=300, time=LATE) if name == "late" else Stop(impacts=60, time=60.0)
    many_orders = tuple((0.5 + 0.01 * i, ("return", "power")[i % 2]) for i in range(300))
    starts: list[Start] = []
    for i in range(20):
        u, v = rng.normal(0.0, 0.02, (2, modes + 1))
        bars = (Start.rigid(-rng.uniform(0.0, 2.0)), Start.modal([-1.5, *u[1:]], v), Start.rigid(0.0))
        orders = (None, Orders("power", ((0.1, "return"), (0.4, "power"))), Orders("power", many_orders))[i % 7 % 3]
        starts.append(bars[i % 3].with_valve(("return", "power")[i % 2], orders))
    columns = Starts(*rng.normal(0.0, 0.02, (2, 20, 3)), -rng.uniform(0.0, 2.0, 20), np.zeros(20))
    columns = columns.with_valve(np.arange(20) % 2, ("return", "power"))
    for given in (starts, columns):
        single = [run(machine, start, modes=modes, stop=stop) for start in given]
        for workers, systems in ((1, machine), (2, machine), (2, [machine] * 20)):
            many = simulate_many(systems, given, modes=modes, stop=stop, workers=workers)
            assert many.outcome.tolist() == [motion.outcome for motion in single]
            assert many.label.tolist() == [motion.label for motion in single]
            assert many.impacts.tolist() == [motion.impacts for motion in single]
            last = [motion.snapshot["valve_now"]["time"][0] * motion.mechanism.unit for motion in single]
            assert many.end_time.tolist() == last
            for column, field in (("period", "period"), ("blow_speed", "blow_speed"), ("first", "first")):
                none = -1 if field == "first" else math.nan
                wanted = [none if motion.cycle is None else getattr(motion.cycle, field) for motion in single]
                assert np.array_equal(getattr(many, column), wanted, equal_nan=True)


def test_a_motion_with_hundreds_of_orders_is_broken_off_and_goes_on():
    stop = Stop(impacts=100_000, time=1.1 * LATE, periodic=False)
    whole = run(BOUNCING, Start.rigid(-1.0), modes=0, stop=stop)
    part = run(BOUNCING, Start.rigid(-1.0), modes=0, stop=Stop(impacts=100_000, time=0.9 * LATE, periodic=False))
    again = part.continued(stop)
    assert len(part.events) < len(whole.events)
    assert np.array_equal(again.events.time, whole.events.time) and np.array_equal(again.states, whole.states)


# -- rests on the wall -------------------------------------------------------------------------------------------------


def late(law: type, R: float, delay: float, kappa: float = 0.0, d: float = 0.05, force: float = 0.1) -> Machine:
    ports = (Port("power", 1.0, "back", 0.1), Port("return", on="impact", delay=delay))
    valve = Valve({"return": -0.6, "power": 1.2}, ports, chamber=Chamber(force, kappa))
    return Machine(UniformBar(5.0, External(d)), valve, law(R))


@pytest.mark.parametrize("law", [Kept, Reversed])
@pytest.mark.parametrize("kappa", [0.0, 0.2])
@pytest.mark.parametrize("R", [0.0, 0.1])
def test_the_energy_of_rests_closes_and_is_that_of_the_cycle(law: type, kappa: float, R: float) -> None:
    machine = late(law, R, 2.5, kappa)
    motion = run(machine, modes=4, stop=Stop(impacts=60))
    rests = motion.events.of("rest")
    assert motion.label in ("runs rest/1", "runs chatter/1") and len(rests) > 1
    balance = motion.energy_balance(motion.begin_time, motion.events.time[-1])
    assert balance.imbalance == pytest.approx(0.0, abs=1e-9 * balance.input)
    last = motion.energy_balance(rests.time[-2], rests.time[-1])
    assert last.imbalance == pytest.approx(0.0, abs=1e-9 * last.input)
    assert 0.0 <= last.rests <= last.impacts
    if law is Kept:
        assert last.rests > 1e-8 * last.input
    if R == 0.0:
        cycle = self_excited_motion(machine, modes=4).cycle
        assert cycle.rests
        assert last.rests == pytest.approx(cycle.taken_by_rest, rel=1e-7, abs=1e-12)
        assert last.impacts == pytest.approx(cycle.taken + cycle.taken_by_rest, rel=1e-7)
        assert last.input == pytest.approx(cycle.work, rel=1e-7)


@pytest.mark.parametrize("modes", [1, 3, 8])
@pytest.mark.parametrize("d", [0.0, 0.05])
def test_a_bar_that_forgets_everything_and_reaches_no_port_stalls(modes: int, d: float) -> None:
    """The law that turns strain over leaves nothing at R = 0: each release begins the same swing on the gas anew."""
    ports = (Port("power", 1.0, "back", 0.1), Port("return", on="impact"))
    valve = Valve({"return": -0.3, "power": 1.0}, ports, chamber=Chamber(0.0, 1.0))
    motion = run(Machine(UniformBar(5.0, External(d)), valve, Reversed(0.0)), modes=modes, stop=Stop(impacts=200))
    assert motion.label == "stalls (in the chamber)"
    assert not len(motion.events.of("valve"))
    assert not len(motion.blow_times) or motion.impacts == 200
    runs = Machine(
        UniformBar(5.0, External(d)), Valve(dict(valve.pairs), ports, chamber=Chamber(0.0, 0.3)), Reversed(0.0)
    )
    assert run(runs, modes=modes).label == "runs rest/1"


# -- fed by a pump and an accumulator ----------------------------------------------------------------------------------


PORTS = (Port("power", 1.0, "back", 0.1), Port("return", on="impact"))


def machine(valve: Valve, R: float = 0.3, drag: float = 0.0) -> Machine:
    return Machine(UniformBar(20.0, External(drag)), valve, Kept(R))


def fed_valve(supply: Supply, back: float = 0.4, power: float = 1.8, chamber: Chamber | None = None) -> Valve:
    return Valve({"return": -back, "power": power}, PORTS, None, chamber or Chamber(), supply=supply)


def test_the_motion_settles_on_the_steady_cycle() -> None:
    made = machine(fed_valve(Supply(1.0, 5.0), chamber=Chamber(0.05, 0.1)), 0.4, 0.05)
    cycle = self_excited_motion(made, modes=0).cycle
    motion = run(made, modes=0, stop=Stop(tolerance=1e-11))
    assert motion.label == "runs 1/1"
    assert motion.cycle.period == pytest.approx(cycle.period, rel=1e-10)
    assert motion.blow_speeds[-1] == pytest.approx(cycle.blow_speed, rel=1e-9)
    assert motion.pressure(motion.blow_times[-1:])[0] == pytest.approx(cycle.rebound.pressure, rel=1e-9)
    times = np.linspace(motion.blow_times[-2], motion.blow_times[-1], 50)
    assert motion.position(1.0, times)[0] == pytest.approx(cycle.position(times - times[0]), abs=1e-8)


def test_a_growing_pressure_lifts_the_piston_off_the_wall() -> None:
    """The pump begins at no pressure: the piston lies until the return force overcomes the gas."""
    valve = fed_valve(Supply(0.8, 3.0, start=0.0), chamber=Chamber(0.3, 0.0))
    motion = run(machine(valve), modes=0, stop=Stop(impacts=60))
    release = motion.events.of("release")[0]
    assert release.time == pytest.approx(3.0 * (0.3 / 0.4) / 0.8, rel=1e-12)
    assert motion.pressure([release.time])[0] == pytest.approx(0.75, rel=1e-12)
    assert motion.resting and motion.impacts > 0
    assert motion.force([0.5 * release.time])[0] > 0.0


def test_an_accumulator_runs_empty() -> None:
    motion = run(machine(fed_valve(Supply(0.02, 0.2))), modes=0)
    assert (motion.outcome, motion.label) == ("stalls", "stalls (without pressure)")
    assert motion.pressure([motion.end_time])[0] == pytest.approx(0.0, abs=1e-12)


def test_stalls() -> None:
    pushing = Valve({"power": 1.0}, (Port("power", on="impact"),), supply=Supply(1.0, 2.0))
    assert run(machine(pushing), modes=0).label == "stalls (on the tool)"
    leaving = Valve({"return": -1.0}, (Port("return", 0.5, "back"),), supply=Supply(1.0, 2.0))
    assert run(machine(leaving, drag=2.0), modes=0).label == "stalls (leaves)"


def test_a_great_accumulator_is_a_constant_pressure() -> None:
    constant = Valve({"return": -0.4, "power": 1.8}, PORTS)
    start, stop = Start.rigid(-0.3), Stop(impacts=6, periodic=False)
    fed = run(machine(fed_valve(Supply(1.0, 1e9))), start, modes=0, stop=stop)
    plain = run(machine(constant), start, modes=0, stop=stop)
    assert fed.blow_times == pytest.approx(plain.blow_times, rel=1e-7)
    assert fed.blow_speeds == pytest.approx(plain.blow_speeds, rel=1e-7)


def test_refusals() -> None:
    made = machine(fed_valve(Supply(1.0, 5.0)))
    with pytest.raises(PercussError, match="without a supply"):
        run(machine(Valve({"return": -0.4, "power": 1.8}, PORTS)), modes=0, stop=Stop(impacts=1)).pressure([0.0])
    with pytest.raises(ParameterError):
        run(made, modes=0, stop=Stop(impacts=3)).pressure([math.inf])
