"""Stepped bars without any of the package's mechanics: transfer matrices in mpmath, and finite elements.

State (u, EA u_x); section of impedance Z and transit time τ at the frequency z, in the units of the load.
"""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st
from mpmath import mp, mpc, mpf
from scipy.linalg import eigh

from percuss.model import SteppedBar
from strategies import decades


def sections(bar: SteppedBar) -> tuple[list[mpf], list[mpf]]:
    """Z_i and τ_i of mass 1 and transit time 1/s."""
    times, impedances = [mpf(t) for t in bar.transit_times], [mpf(z) for z in bar.impedances]
    total = sum(times) * mpf(bar.s)
    times = [t / total for t in times]
    mass = sum(z * t for z, t in zip(impedances, times, strict=True))
    return [z / mass for z in impedances], times


def transfer(bar: SteppedBar, z: mpc, start: mpf, end: mpf):
    """From the time of a wave `start` to `end`, both from the driven end."""
    result, here = mp.eye(2), mpf(0)
    for impedance, time in zip(*sections(bar), strict=True):
        low, high = max(start, here), min(end, here + time)
        if high > low:
            c, s = mp.cos(z * (high - low)), mp.sin(z * (high - low))
            result = mp.matrix([[c, s / (z * impedance)], [-impedance * z * s, c]]) * result
        here += time
    return result


def wave_time(bar: SteppedBar, x: float) -> mpf:
    """Time of a wave from the driven end to x, a point between two of the bar's places."""
    _, times = sections(bar)
    edges, time = [mpf(place) for place in (*bar.places, 1.0)], mpf(0)
    for start, end, own in zip(edges[:-1], edges[1:], times, strict=True):
        if x >= end:
            time += own
        elif x > start:
            time += (mpf(x) - start) / (end - start) * own
    return time


def receptance(bar: SteppedBar, z: complex, x: float, source: float) -> complex:
    """Displacement at x per force at the source, the rigid part −1/z² taken off."""
    z, (low, high) = mpc(z), sorted((wave_time(bar, x), wave_time(bar, source)))
    before, between, behind = transfer(bar, z, mpf(0), low), transfer(bar, z, low, high), None
    behind = transfer(bar, z, high, sum(sections(bar)[1]))
    whole = behind * between
    state = before * mp.matrix([whole[1, 1] / (whole * before)[1, 0], 0])
    state = between * (state - mp.matrix([0, 1]))
    return complex(state[0] + 1 / z**2)


def end_force(bar: SteppedBar, omega: mpf) -> mpf:
    """Force at the striking end of a bar that starts free: 0 at the frequencies."""
    return transfer(bar, omega, mpf(0), sum(sections(bar)[1]))[1, 0]


def finite_elements(bar: SteppedBar, elements: int) -> np.ndarray:
    """Frequencies by quadratic elements, `elements` in each section: always a little too high."""
    impedances, times = sections(bar)
    size = 2 * elements * len(times) + 1
    stiffness, mass = np.zeros((size, size)), np.zeros((size, size))
    own_k = np.array([[7.0, -8.0, 1.0], [-8.0, 16.0, -8.0], [1.0, -8.0, 7.0]]) / 3.0
    own_m = np.array([[4.0, 2.0, -1.0], [2.0, 16.0, 2.0], [-1.0, 2.0, 4.0]]) / 30.0
    first = 0
    for impedance, time in zip(impedances, times, strict=True):
        step = float(time) / elements
        for _ in range(elements):
            at = np.ix_(range(first, first + 3), range(first, first + 3))
            stiffness[at] += own_k * float(impedance) / step
            mass[at] += own_m * float(impedance) * step
            first += 2
    return np.sqrt(np.maximum(eigh(stiffness, mass, eigvals_only=True), 0.0))[1:]


@st.composite
def stepped_bars(draw: st.DrawFn, most: int = 200, spread: float = 6.0, s: float | None = None) -> SteppedBar:
    """1 to `most` sections; transit times lie in 10^±spread, impedances no further apart than neighbours may be."""
    count = draw(st.one_of(st.integers(1, min(most, 6)), st.integers(1, most)))
    own = draw(st.sampled_from([spread, 0.3]))
    one = (st.one_of(decades(-most, most), st.sampled_from([1.0, 10.0**most])) for most in (min(own, 2.9), own))
    impedances, times = (draw(st.lists(each, min_size=count, max_size=count)) for each in one)
    lengths = draw(st.one_of(st.none(), st.just(tuple(times[::-1]))))
    wave_speed = draw(decades(-2.0, 2.0)) if s is None else s
    return SteppedBar(wave_speed, tuple(impedances), tuple(times), lengths=lengths)
