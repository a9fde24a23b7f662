"""No contact is missed and none invented: the engine against ball arithmetic that shares no code with it."""

import math

import mpmath
import numpy as np
import pytest

from interval_oracle import KINDS, Flight, first_contact, gap, random_flight
from percuss.model import Load, System
from percuss.simulate import Start, Stop, Trajectory, run
from percuss.simulate.events import IMPACT

RESOLUTION = 1e-12 * 2.0 * np.pi


def simulated(flight: Flight, horizon: float, restitution: float = 0.5) -> tuple[str, float, float]:
    """Kind, time and speed of the first event of the engine."""
    steps = bool(flight.breaks)
    load = Load.steps(flight.breaks, flight.values) if steps else Load.fourier(np.asarray(flight.coefficients))
    system = System(s=flight.s, d=flight.d, restitution=restitution, load=load)
    start = Start.modal(flight.displacement, flight.velocity, flight.time)
    stop = Stop(impacts=1, time=horizon, periodic=False)
    motion = run(system, start, modes=len(flight.displacement) - 1, stop=stop)
    if len(motion.events) == 0:
        assert motion.outcome in ("time", "departed")
        return "none", horizon, np.nan
    first = next(iter(motion.events))
    turns = np.floor(flight.time / (2.0 * np.pi))
    time = (motion.events.period[0] - turns) * 2.0 * np.pi + (first.phase - (flight.time - turns * 2.0 * np.pi))
    return {"impact": "contact", "grazing": "graze"}.get(first.kind, first.kind), float(time), first.impact_velocity


def scale(flight: Flight) -> float:
    """What rounding errors are measured by: the largest speed, and near a resonance the large parts that cancel."""
    omega = np.pi * flight.s * np.arange(len(flight.displacement))
    fast = np.abs(flight.velocity).sum() + omega @ np.abs(flight.displacement)
    k = np.arange(len(flight.coefficients))[1:, None]
    pk = np.abs(np.asarray(flight.coefficients[1:], dtype=complex))[:, None]
    forced = pk / np.abs(omega**2 - k**2 + 1j * k * flight.d) if k.size else np.zeros(1)
    return float(1.0 + fast + (k * forced).sum())


def check(flight: Flight, horizon: float, on_wall: bool) -> str:
    """The engine against the oracle; returns what both found."""
    true = first_contact(flight, horizon, on_wall)
    kind, time, speed = simulated(flight, horizon)
    where = f"{flight}\nhorizon {horizon}, on the wall {on_wall}\noracle {true}, engine {kind} at {time}"
    error = 1e-14 * scale(flight) * (1.0 + horizon)  # of the gap
    if kind == "graze":
        y, rate, curve = gap(flight, time, on_wall)
        assert abs(y) < max(1e-13, error) and rate * rate < 4.0 * abs(curve) * max(1e-13, error), where
        return kind
    if true.kind == "graze":
        return kind  # deeper than rounding, but within the oracle's own 1e-13
    assert kind == true.kind, where
    if kind == "contact":
        # a contact of speed v is known to 1e-12 of the load period, or as well as rounding lets the gap be known
        assert abs(time - true.time) < max(RESOLUTION, error / true.speed), where
        assert (
            abs(speed - true.speed)
            < 1e-9 * scale(flight) + error * abs(gap(flight, true.time, on_wall)[2]) / true.speed
        )
    return kind


@pytest.mark.parametrize("flights", [150, pytest.param(2100, marks=pytest.mark.slow)])
@pytest.mark.parametrize("kind", KINDS)
def test_first_contacts(kind, flights):
    """With `make slow` more than ten thousand flights in all, every day the first of them."""
    rng = np.random.default_rng(20260)
    seen = [check(*random_flight(rng, kind)) for _ in range(flights)]
    assert seen.count("contact") > 5


def repeating(motion: Trajectory) -> list[int]:
    """The impacts that come at nearly the load phase of the one, two or four before: their flights are tried first."""
    struck = motion.events.of("impact").phase
    near = []
    for i in range(5, len(struck) - 1):
        turn = np.abs(struck[i] - struck[[i - 1, i - 2, i - 4]])
        if np.minimum(turn, 2.0 * np.pi - turn).min() < 0.01:
            near.append(i)
    return near


@pytest.mark.parametrize("modes", [0, 1, 8, 32])
def test_contacts_of_motions_that_nearly_repeat(modes):
    """The short cut for a flight like one before it neither misses a contact nor invents one."""
    rng = np.random.default_rng(7 + modes)
    tried = 0
    for _ in range(150):
        s, d, r = (
            float(np.exp(rng.uniform(-1.0, 4.0))),
            float(rng.choice([0.0, 0.01, 0.3])),
            float(rng.uniform(0, 0.95)),
        )
        harmonics = rng.normal(size=(int(rng.integers(1, 4)), 2)) @ [1.0, 1.0j]
        load = Load.fourier([float(rng.uniform(0.2, 1.2)) * np.abs(harmonics).sum(), *harmonics])
        stop = Stop(impacts=60, periodic=False)
        start = Start.rigid(-float(rng.uniform(0.1, 5.0)), time=float(rng.uniform(0.0, 6.0)))
        motion = run(System(s=s, d=d, restitution=r, load=load), start, modes=modes, stop=stop)
        events = motion.events
        rows = np.flatnonzero(events.code == IMPACT)
        near = repeating(motion)
        for i in rng.choice(near, min(3, len(near)), replace=False) if near else ():
            row, after = rows[i], rows[i] + 1
            if events.code[after] != IMPACT or not events.rebound_velocity[row] < -1e-6:
                continue
            coefficients = tuple(complex(c) for c in load.coefficients)
            flight = Flight(
                s, d, coefficients, (), (), events.phase[row], motion.displacement[row], motion.velocity[row]
            )
            length = (events.period[after] - events.period[row]) * 2.0 * np.pi + events.phase[after] - events.phase[row]
            true = first_contact(flight, length + 1.0, on_wall=True)
            error = 1e-14 * scale(flight) * (1.0 + length)
            assert true.kind == "contact", f"{flight}\n{true}, engine {length}"
            assert abs(length - true.time) < max(RESOLUTION, error / true.speed), f"{flight}\n{true}, engine {length}"
            tried += 1
    assert tried > 100


# -- bars that the load pulls off the wall -----------------------------------------------------------------------------


mp = mpmath.MPContext()
mp.dps = 40


def released(coefficients, d, phase, after):
    """y and y' of a rigid bar `after` its release: its forced motion and the free one, in 40 digits."""
    p, d = [mp.mpc(complex(c)) for c in coefficients], mp.mpf(d)
    t0, t = mp.mpf(phase), mp.mpf(phase) + mp.mpf(after)
    shape = [p[k] / (1j * k * d - k * k) for k in range(1, len(p))]

    def forced(at):
        turns = [c * mp.exp(1j * (k + 1) * at) for k, c in enumerate(shape)]
        return mp.re(mp.fsum(turns)), mp.re(mp.fsum(1j * (k + 1) * c for k, c in enumerate(turns)))

    mean, gone = mp.re(p[0]), mp.mpf(after)
    first = -mp.expm1(-d * gone) / d if d else gone
    second = (gone - first) / d if d else gone * gone / 2
    (y0, v0), (y1, v1) = forced(t0), forced(t)
    return float(y1 - y0 - v0 * first + mean * second), float(v1 - v0 * (1 - d * first) + mean * first)


def onset(coefficients):
    """A phase at which a Fourier series turns from push to pull, rounded, or None; and how long it pulls at least."""
    k = np.arange(len(coefficients))

    def force(t):
        return float(np.real(np.exp(1j * k * t) @ coefficients))

    t = np.linspace(0.0, 2.0 * math.pi, 721)
    p = np.array([force(x) for x in t])
    falls = np.flatnonzero((p[:-1] > 0.0) & (p[1:] <= 0.0))
    if not falls.size or p[(falls[0] + 12) % 720] >= 0.0:
        return None
    low, high = (mp.mpf(float(t[falls[0]])), mp.mpf(float(t[falls[0] + 1])))
    exact = [mp.mpc(complex(c)) for c in coefficients]
    for _ in range(120):
        middle = (low + high) / 2
        value = mp.re(mp.fsum(c * mp.exp(1j * n * middle) for n, c in enumerate(exact)))
        low, high = (middle, high) if value > 0 else (low, middle)
    return float(low)


@pytest.mark.parametrize("starts", [40, pytest.param(600, marks=pytest.mark.slow)])
def test_released_within_ulps(starts):
    """The flight is that of a bar released where the load begins to pull, on whichever side the bar is laid down."""
    rng, seen = np.random.default_rng(872), 0
    while seen < starts:
        count = int(rng.integers(1, 4))
        parts = (rng.normal(size=count) + 1j * rng.normal(size=count)) / np.arange(1, count + 1)
        coefficients = np.array([float(rng.uniform(-1.0, 1.0)), *parts])
        d = 0.0 if rng.random() < 0.4 else float(10.0 ** rng.uniform(-3, 4))
        phase = onset(coefficients)
        if phase is None:
            continue
        y, v = released(coefficients, d, phase, 0.05)
        if not y < -1e-12:
            continue
        flight = Flight(1.0, d, tuple(map(complex, coefficients)), (), (), phase + 0.05, np.array([y]), np.array([v]))
        horizon = 60.0
        true = first_contact(flight, horizon)
        system, stop = System(1.0, d, 0.7, Load.fourier(coefficients)), Stop(impacts=1, time=horizon, periodic=False)
        seen += 1
        for ulps in (0, *(int(k) for k in rng.integers(-12, 13, 4))):
            motion = run(system, Start.rigid(0.0, 0.0, phase + ulps * np.spacing(phase)), modes=0, stop=stop)
            struck = motion.events.of("impact")
            where = f"{coefficients}, d = {d}, {ulps} ulps: {true}, {motion.events.kind} at {motion.events.time}"
            if true.kind == "contact":
                assert len(struck) == 1, where
                error = 1e-9 if true.speed < 1e-6 else 1e-11 / true.speed
                assert abs(struck.time[0] - (phase + 0.05 + true.time)) < 1e-12 + error, where
            elif true.kind == "none":
                assert len(struck) == 0 or struck.time[0] > phase + horizon - 0.1, where
