"""First contacts of stepped bars under every law of damping, against ball arithmetic that shares no code with them."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import flint
import numpy as np
import pytest

from damped_flights import _summit
from interval_oracle import Flight, first_contact, gap, random_flight
from percuss.model import Damping, External, KelvinVoigt, Kept, Load, Modes, Ratio, SteppedBar, System, Table
from percuss.simulate import Start, Stop, run

RESOLUTION = 1e-12 * 2.0 * np.pi
KINDS = ("steady", "ringing", "free", "steps", "damped", "touching")
MANY = 2500
CONTACTS = {"steady": 0.55, "ringing": 0.65, "free": 0.8, "steps": 0.6, "damped": 0.63, "touching": 0.83}
assert MANY * sum(CONTACTS.values()) > 1e4


class Flown(NamedTuple):
    """A flight for the oracle, and the same for the engine."""

    flight: Flight
    horizon: float
    on_wall: bool
    system: System
    modes: Modes


def law_of(rng: np.random.Generator, d: float) -> Damping:
    """A law of damping, among them overdamped modes and modes that are not damped at all."""
    number = 10.0 ** rng.uniform(-5.0, -0.5)
    table = tuple(float(own) for own in rng.choice([0.0, 1e-3, 0.3, 20.0], size=4) * rng.random())
    return (External(d), Ratio(float(number)), KelvinVoigt(float(number**2)), Table(table))[int(rng.integers(4))]


def body_of(rng: np.random.Generator, s: float, law: Damping) -> SteppedBar:
    """One to eight sections, most of them as machines have them, some that differ by six decades."""
    count = int(rng.integers(1, 9))
    spread = 3.0 if rng.random() < 0.1 else 0.5
    impedances, times = 10.0 ** rng.uniform(-spread, spread, (2, count))
    return SteppedBar(s, tuple(impedances.tolist()), tuple(times.tolist()), law)


def stepped_flight(rng: np.random.Generator, kind: str) -> Flown:
    """A flight of the oracle's, made over for a stepped bar with as many modes."""
    if kind == "touching":
        return touching(rng)
    flight, horizon, on_wall = random_flight(rng, kind)
    while len(flight.displacement) == 1:
        flight, horizon, on_wall = random_flight(rng, kind)
    count = len(flight.displacement) - 1
    law = law_of(rng, flight.d)
    body = body_of(rng, flight.s, law)
    at = int(rng.integers(len(body.places)))
    modes = body.modes(count, at)
    u, v = flight.displacement.copy(), flight.velocity.copy()
    v[1:] *= np.minimum(1.0, modes.omega / (np.pi * flight.s * np.arange(1, count + 1)))
    u[0] = -float(modes.gamma @ u[1:])
    if on_wall:
        speed = float(modes.gamma @ v[1:]) + v[0]
        v[0] -= max(0.0, speed + float(rng.uniform(0.1, 1.0)))
    else:
        u[0] -= 10.0 ** rng.uniform(-3.0, 0.0)
    rows = tuple(zip(modes.omega.tolist(), modes.damping.tolist(), modes.gamma.tolist(), strict=True))
    flight = replace(flight, d=law.rigid, displacement=u, velocity=v, modes=rows)
    load = Load.steps(flight.breaks, flight.values) if flight.breaks else Load.fourier(np.asarray(flight.coefficients))
    return Flown(flight, horizon, on_wall, System(body, load.acting_at(at), Kept(0.5)), modes)


def touching(rng: np.random.Generator) -> Flown:
    """A flight that starts away from the wall, moved so that a summit of its gap comes very near the wall."""
    bits, flint.ctx.prec = flint.ctx.prec, 128
    try:
        while True:
            flown = stepped_flight(rng, str(rng.choice(["free", "ringing", "damped"])))
            summit = None if flown.on_wall or flown.flight.breaks else _summit(rng, flown.flight, flown.horizon)
            if summit is None:
                continue
            moved = flown.flight.displacement.copy()
            moved[0] += 10.0 ** rng.uniform(-10.0, -3.0) * float(rng.choice([-1.0, 1.0, 1.0])) - summit
            flight = replace(flown.flight, displacement=moved)
            if gap(flight, 0.0)[0] < -1e-9:
                return flown._replace(flight=flight)
    finally:
        flint.ctx.prec = bits


def scale(flown: Flown) -> float:
    """What rounding errors are measured by: the largest speed, and near a resonance the large parts that cancel."""
    flight, modes = flown.flight, flown.modes
    weight = np.abs(modes.gamma)
    free = weight * (np.abs(flight.velocity[1:]) + modes.omega * np.abs(flight.displacement[1:]))
    k = np.arange(len(flight.coefficients))[1:]
    pk = np.abs(np.asarray(flight.coefficients[1:], dtype=complex))
    forced = weight @ (1.0 / np.abs(modes.stiffness(k))) @ (k * pk) if k.size else 0.0
    push = max(map(abs, flight.values), default=0.0)
    return float(1.0 + abs(flight.velocity[0]) + free.sum() + forced + push * (weight / modes.omega).sum())


def check(flown: Flown) -> str:
    """The engine against the oracle; returns what the oracle found."""
    flight, horizon, on_wall, system, modes = flown
    true = first_contact(flight, horizon, on_wall)
    start = Start(tuple(flight.displacement), tuple(flight.velocity), flight.time, 0.0 if on_wall else None)
    motion = run(system, start, modes=modes.size, stop=Stop(impacts=1, time=horizon, periodic=False))
    where = f"{system}\n{flight}\nhorizon {horizon}, on the wall {on_wall}\noracle {true}, engine {motion.events}"
    error = 1e-14 * scale(flown) * (1.0 + horizon)  # of the gap
    if not len(motion.events):
        assert true.kind == "none" or true.kind == "graze", where
        return true.kind
    first = next(iter(motion.events))
    turns = np.floor(flight.time / (2.0 * np.pi))
    time = (motion.events.period[0] - turns) * 2.0 * np.pi + (first.phase - (flight.time - turns * 2.0 * np.pi))
    if first.kind == "grazing":
        y, rate, curve = gap(flight, float(time), on_wall)
        assert abs(y) < max(1e-13, error) and rate * rate < 4.0 * abs(curve) * max(1e-13, error), where
        return true.kind
    if true.kind == "graze":  # deeper than rounding, but within the oracle's own 1e-13
        return true.kind
    assert (first.kind, true.kind) == ("impact", "contact"), where
    curve = abs(gap(flight, true.time, on_wall)[2])
    late = max(RESOLUTION, error / true.speed)
    if curve > 0.0:
        late = min(late, max(RESOLUTION, np.sqrt(2.0 * error / curve)))
    assert abs(time - true.time) < late, where
    assert abs(first.impact_velocity - true.speed) < 1e-9 * scale(flown) + error * curve / true.speed, where
    return true.kind


@pytest.mark.parametrize("kind", KINDS)
def test_first_contacts(kind: str) -> None:
    rng = np.random.default_rng(1977)
    seen = [check(stepped_flight(rng, kind)) for _ in range(40)]
    assert seen.count("contact") > 15


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_ten_thousand_first_contacts(kind: str) -> None:
    rng = np.random.default_rng(771977)
    seen = [check(stepped_flight(rng, kind)) for _ in range(MANY)]
    assert seen.count("contact") > CONTACTS[kind] * MANY
