"""All pairs of impacts of a rigid bar: the arithmetic against fractions, the enclosures against many digits."""

from __future__ import annotations

import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orbit_cases import ENTRIES, system_of
from percuss import Load, System
from percuss.steady import orbits
from percuss.steady.periodic import search as search_module
from percuss.steady.periodic.pair_proof import Ball, PairEquations, exactly
from random_hammers import random_hammer

TURN = 2.0 * math.pi
mp = mpmath.mp.clone()
mp.dps = 40
COSINE = Load.harmonic(0.62, 1.0)
LOADS = [
    COSINE,
    Load.fourier([0.4, 1.0, 0.3j, -0.2]),
    Load.square(1.0, 1.3),
    Load.steps([0.2, 1, 3], [1.5, -0.3, -0.4]),
]


# -- the arithmetic ---------------------------------------------------------------------------------------------------

plain = st.floats(-1e6, 1e6).filter(lambda x: x == 0.0 or abs(x) > 1e-60)
inside = st.floats(-1.0, 1.0)


@given(plain, st.floats(0.0, 10.0), plain, st.floats(0.0, 10.0), inside, inside)
def test_a_ball_holds_whatever_its_parts_may_give(a: float, r: float, b: float, s: float, x: float, y: float) -> None:
    one, other = Ball(np.array(a), np.array(r)), Ball(np.array(b), np.array(s))
    p, q = Fraction(a) + Fraction(r) * Fraction(x), Fraction(b) + Fraction(s) * Fraction(y)
    exact = {"+": p + q, "-": p - q, "*": p * q}
    found = {"+": one + other, "-": one - other, "*": one * other}
    if abs(b) > s * 1.01:
        exact["/"], found["/"] = p / q, one.over(other)
    for sign, value in exact.items():
        ball = found[sign]
        assert abs(value - Fraction(float(ball.mid))) <= Fraction(float(ball.rad))
        assert abs(value) <= Fraction(float(ball.most))
        if value == 0:
            assert ball.may_vanish


def test_what_cannot_be_divided_says_nothing() -> None:
    assert exactly(1.0).over(Ball(np.array(1.0), np.array(1.0))).rad == math.inf


# -- the equations, in forty digits -----------------------------------------------------------------------------------


def forced(system: System, t) -> tuple:
    """U_f and v_f of a rigid bar: sums, or by quadrature of each step from the state that comes back."""
    load, d = system.load, mp.mpf(system.d)
    if not load.is_piecewise:
        waves = [(k, mp.mpc(load.coefficients[k])) for k in load.harmonics.tolist()]
        v = sum(p / (d + 1j * k) * mp.expj(k * t) for k, p in waves)
        return sum(p / (d + 1j * k) / (1j * k) * mp.expj(k * t) for k, p in waves).real, v.real
    turn = mp.mpf(TURN)
    breaks = [mp.mpf(b) for b in load.breaks]
    lengths = [after - before for before, after in zip(breaks, [*breaks[1:], breaks[0] + turn], strict=True)]
    mean = sum(mp.mpf(v) * h for v, h in zip(load.values, lengths, strict=True)) / turn
    forces = [mp.mpf(v) - mean for v in load.values]

    def moved(u, v, force, h):
        if d == 0:
            return u + v * h + force * h**2 / 2, v + force * h
        fade = -mp.expm1(-d * h) / d
        return u + v * fade + force * (h - fade) / d, v * mp.exp(-d * h) + force * fade

    u = v = mp.mpf(0)
    for force, h in zip(forces, lengths, strict=True):
        u, v = moved(u, v, force, h)
    # without drag v is any; with it v comes back: v(1 - e^{-d turn}) = what a turn from rest gives
    start = v / -mp.expm1(-d * turn) if d else mp.mpf(0)
    if not d:
        u = v = mp.mpf(0)
        area = mp.mpf(0)
        for force, h in zip(forces, lengths, strict=True):
            area += v * h + force * h**2 / 2
            v += force * h
        start = -area / turn
    u, v, since = mp.mpf(0), start, mp.fmod(t - breaks[0], turn)
    if since < 0:
        since += turn
    for force, h in zip(forces, lengths, strict=True):
        if since <= h:
            return moved(u, v, force, since)
        u, v = moved(u, v, force, h)
        since -= h
    return u, v


def equations(system: System, periods: int, t, h) -> tuple:
    """F_1 and F_2, by the motion itself: two flights, two impacts, and a velocity that comes back."""
    d, r = mp.mpf(system.d), mp.mpf(system.restitution)
    t, h = mp.mpf(t), mp.mpf(h)
    rest = mp.mpf(TURN) * periods - h
    mean = mp.mpf(system.load.mean)
    (u, v), (u_2, v_2) = forced(system, t), forced(system, t + h)

    def flight(velocity, begin, end, force_free, length):
        fade = -mp.expm1(-d * length) / d if d else length
        twice = (length - fade) / d if d else length**2 / 2
        advance = (velocity - begin[1]) * fade + mean * twice + end[0] - begin[0]
        return advance, (velocity - begin[1]) * mp.exp(-d * length) + end[1] + mean * fade

    def cycle(velocity):
        first, before = flight(velocity, (u, v), (u_2, v_2), None, h)
        second, again = flight(-r * before, (u_2, v_2), (u, v), None, rest)
        return first, second, -r * again

    none, one = cycle(mp.mpf(0))[2], cycle(mp.mpf(1))[2]
    first, second, back = cycle(none / (1 - (one - none)))
    assert abs(back - none / (1 - (one - none))) < 1e-30
    return first, second


@st.composite
def boxes(draw: st.DrawFn):
    """A system, n, a box of times, and a place in it."""
    d = draw(st.sampled_from([0.0, 1e-9, 0.003, 0.4, 5.0]))
    system = System(s=5.0, d=d, restitution=draw(st.sampled_from([0.0, 0.3, 0.9])), load=draw(st.sampled_from(LOADS)))
    n = draw(st.integers(1, 2))
    t, h = draw(st.floats(0.0, TURN)), draw(st.floats(0.02, TURN * n - 0.02))
    size = draw(st.sampled_from([0.0, 1e-6, 1e-3, 0.1, 0.5]))
    rads = size * draw(st.floats(0.1, 1.0)), min(size * draw(st.floats(0.1, 1.0)), h, TURN * n - h)
    place = t + 0.999 * rads[0] * draw(inside), h + 0.999 * rads[1] * draw(inside)
    return system, n, (t, h), rads, place


@settings(max_examples=30, deadline=None)
@given(boxes())
def test_the_equations_are_enclosed_over_boxes(drawn) -> None:
    system, n, (t, h), rads, place = drawn
    found = PairEquations(system, n).over(
        *(Ball(np.array([x]), np.array([r])) for x, r in zip((t, h), rads, strict=True))
    )
    exact = equations(system, n, *place)
    room = 1e-13 * (1.0 + (TURN * n) ** 2)  # the mean load of steps is a double
    for ball, value in zip(found[:2], exact, strict=True):
        assert abs(float(value - mp.mpf(float(ball.mid[0])))) <= float(ball.rad[0]) + room
    at = np.array(system.load.breaks) if system.load.is_piecewise else np.empty(0)
    near = [np.abs(np.mod(time - at + 0.5, TURN) - 0.5).min(initial=1.0) for time in (place[0], sum(place))]
    if min(near) < 1e-6:
        return
    step = mp.mpf(10) ** -10
    for balls, move in ((found.by_t, (step, 0)), (found.by_h, (0, step))):
        ends = [equations(system, n, place[0] + sign * move[0], place[1] + sign * move[1]) for sign in (1, -1)]
        for i, ball in enumerate(balls):
            slope = (ends[0][i] - ends[1][i]) / (2 * step)
            assert abs(float(slope - mp.mpf(float(ball.mid[0])))) <= float(ball.rad[0]) + room
    r = mp.mpf(system.restitution)
    per_flight = exact[0] / (
        -mp.expm1(-mp.mpf(system.d) * place[1]) / mp.mpf(system.d) if system.d else mp.mpf(place[1])
    )
    per_flight = per_flight if r else per_flight / place[1]
    ball = found.per_flight
    assert abs(float(per_flight - mp.mpf(float(ball.mid[0])))) <= float(ball.rad[0]) + room / place[1]


# -- the list ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(0, 24, 3))
def test_nothing_that_a_search_finds_is_missing(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    system = random_hammer(seed).system
    proved = [orbits(system, 2, n, modes=0) for n in (1, 2)]
    monkeypatch.setattr(search_module, "proved_pairs", lambda *_: None)
    for one in proved:
        assert one.complete is not (system.restitution == 1.0 and system.d < 1e-4)
        searched = orbits(system, 2, one.periods, modes=0, tries=60)
        for name in ("orbits", "impossible"):
            listed = np.array([orbit.times for orbit in getattr(one, name)]).reshape(-1, 2)
            for orbit in getattr(searched, name):
                assert np.abs(listed - orbit.times).max(axis=1).min() < 1e-9


def test_a_complete_list_has_no_tries() -> None:
    found = orbits(System(s=5.0, d=0.0, restitution=0.5, load=COSINE), 2, 2, modes=0)
    assert found.complete
    assert (found.tries, found.unseen) == (0, 0.0)
    assert str(found).startswith("z=2/2: 1 orbit with 0 modes, complete (proved)")
    assert {reason.value: number for reason, number in found.dropped.items()} == {"repeats a shorter orbit": 2}


def test_a_fold_is_not_proved() -> None:
    """Two orbits within rounding of each other are no roots that a box could tell apart."""
    entry = ENTRIES["branch_21"]
    fold = next(float(point["value"]) for point in entry["points"] if point["type"] == "fold")
    assert not orbits(system_of(entry, fold), 2, modes=0, tries=10).complete
    assert orbits(system_of(entry, fold - 1e-5), 2, modes=0).complete
    beyond = orbits(system_of(entry, fold + 1e-5), 2, modes=0)
    assert beyond.complete
    assert not beyond.orbits
