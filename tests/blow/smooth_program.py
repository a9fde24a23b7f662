"""Blows with rock and lumped masses to ten digits: every wave is a polynomial of degree 24 between two breaks.

A third program beside the package, made only to judge it. It goes from break to break of what arrives anywhere, solves
the nodes on the interval by collocation, looks for the first thing that happens within (by sampling and bisection),
cuts the interval there and solves it again. Slow, and right only where nothing happens twice within a 64th of an
interval; it shares no code with the package.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev, legendre
from scipy.optimize import brentq

from collisions import Collision

DEGREE = 24
NODES = -np.cos(np.pi * np.arange(DEGREE + 1) / DEGREE)
FIT = np.linalg.inv(chebyshev.chebvander(NODES, DEGREE))
SLOPE = chebyshev.chebval(NODES, chebyshev.chebder(FIT, axis=0)).T  # of the values at the nodes
GAUSS = legendre.leggauss(DEGREE + 8)
LOOKS = 64
ORDERS = np.arange(DEGREE + 1)
SAMPLES = chebyshev.chebvander(np.linspace(-1.0, 1.0, LOOKS + 1)[1:], DEGREE) @ FIT
INTEGRALS = chebyshev.chebval(NODES, chebyshev.chebint(FIT, lbnd=-1.0, axis=0)).T
STEEP = 3.0  # rate × duration of an interval at most
SMALL = 1e-13

MOST = 1000  # intervals of a blow that the program is made for

Vector = np.ndarray


class TooMany(Exception):
    """Events so close to each other that the program does not get on."""


@dataclass
class Part:
    """A function on an interval, by its Chebyshev coefficients."""

    start: float
    end: float
    coefficients: Vector

    def at(self, t: Vector | float) -> Vector:
        if self.coefficients.size == 1:
            return np.full(np.shape(t), self.coefficients[0])
        scaled = (2.0 * np.asarray(t) - self.start - self.end) / (self.end - self.start)
        angles = np.arccos(np.clip(scaled, -1.0, 1.0))
        return np.asarray(np.cos(np.multiply.outer(angles, ORDERS)) @ self.coefficients)


def fitted(start: float, end: float, values: Vector) -> Part:
    """Through values at the nodes; of degree 0 where they are all the same."""
    constant = np.ptp(values) <= 2e-16 * abs(values[0])
    return Part(start, end, values[:1] if constant else FIT @ values)


@dataclass
class Way:
    """What runs one way through one section, by the times at which it enters."""

    transit: float | None
    parts: list[Part]

    def breaks(self) -> list[float]:
        return [] if self.transit is None else [part.end + self.transit for part in self.parts]

    def leaving(self, times: Vector) -> Vector:
        """Within one part."""
        if self.transit is None:
            return np.zeros_like(times)
        middle = 0.5 * (times[0] + times[-1]) - self.transit
        part = next(part for part in reversed(self.parts) if part.start <= middle)
        return part.at(times - self.transit)

    def enter(self, start: float, end: float, values: Vector) -> None:
        self.parts.append(fitted(start, end, values))
        while self.transit is not None and self.parts[0].end < start - self.transit:
            self.parts.pop(0)  # it has left

    def integral(self, now: float, power: int) -> float:
        """∫ value^power of what is inside."""
        assert self.transit is not None
        total = 0.0
        for part in self.parts:
            low, high = max(part.start, now - self.transit), min(part.end, now)
            if high > low:
                half = 0.5 * (high - low)
                total += half * float(GAUSS[1] @ part.at(low + half * (GAUSS[0] + 1.0)) ** power)
        return total


@dataclass
class Section:
    impedance: float
    right: Way
    left: Way

    def momentum(self, now: float) -> float:
        return self.impedance * (self.right.integral(now, 1) + self.left.integral(now, 1))

    def energy(self, now: float) -> float:
        return self.impedance * (self.right.integral(now, 2) + self.left.integral(now, 2))


def _section(impedance: float, transit: float | None, velocity: float) -> Section:
    def way() -> Way:
        return Way(transit, [] if transit is None else [Part(-transit, 0.0, np.array([0.5 * velocity]))])

    return Section(impedance, way(), way())


class Law(NamedTuple):
    """What the rock does now: its stiffness, the place of no force, and whether it is deeper than ever."""

    stiffness: float
    origin: float
    deepening: bool


OFF = Law(0.0, 0.0, False)


@dataclass
class Bit:
    """Where the end of the rod is, how fast, and how deep it was."""

    position: float
    velocity: float = 0.0
    deepest: float = 0.0
    force: float = 0.0
    greatest_force: float = 0.0
    work: float = 0.0


@dataclass
class Found:
    collision: Collision
    striker: list[Section]
    rod: list[Section]
    contacts: list[list[float]] = field(default_factory=list)
    touches: list[tuple[float, float]] = field(default_factory=list)  # without force: open or shut, as one likes
    bit: Bit | None = None
    work_through_face: float = 0.0
    load_work: float = 0.0
    endless_energy: float = 0.0
    gap_after: float = 0.0
    intervals: int = 0
    joints: dict[int, float] = field(default_factory=dict)

    @property
    def impulse(self) -> float:
        return sum(one[2] for one in self.contacts)

    @property
    def momentum_after(self) -> float:
        return sum(one.momentum(self.collision.until) for one in self.striker)

    @property
    def restitution(self) -> float:
        return -self.momentum_after / (self.collision.mass * self.collision.velocity_before)

    @property
    def striker_energy_after(self) -> float:
        return sum(one.energy(self.collision.until) for one in self.striker)

    @property
    def rod_energy_after(self) -> float:
        finite = [one for one in self.rod if one.right.transit is not None]
        return self.endless_energy + sum(one.energy(self.collision.until) for one in finite)


def blow(given: Collision) -> Found:
    """The blow."""
    case = given.turned_into(float)
    striker = [_section(z, tau, v) for (z, tau), v in zip(case.striker, case.velocity, strict=True)]
    rod = [_section(z, tau, 0.0) for z, tau in case.rod or ()]
    found = Found(case, striker, rod, joints={step: 0.0 for step, mass in case.joint_masses if mass > 0.0})
    if rod and (case.end == "rock" or case.bit_mass):
        found.bit = Bit(-case.rock_gap)
    found.gap_after = case.gap
    now = 0.0
    while now < case.until * (1.0 - SMALL):
        then = _interval(found, now)
        found.intervals += 1
        if found.intervals > MOST or not then > now:
            raise TooMany
        now = then
    return found


def _nodes(start: float, end: float) -> Vector:
    times = 0.5 * (start + end) + 0.5 * (end - start) * NODES
    times[0], times[-1] = start, end
    return np.asarray(times)


def _next_break(found: Found, now: float) -> float:
    case, least = found.collision, now + SMALL * found.collision.until
    times = [t for one in found.striker + found.rod for way in (one.right, one.left) for t in way.breaks()]
    times += [start for start, _ in case.load] + [case.until]
    return min(t for t in times if t > least)


def _interval(found: Found, now: float) -> float:
    """One interval; its end. Solved as far as the next break, then again as far as the first thing that happens."""
    case, then = found.collision, _next_break(found, now)
    then = min(then, now + STEEP / max(_rates(case), 1e-300))
    closed = _closed_at(found, now, then)
    law = _law_at(found, now, then)
    closing = turning = None
    for _ in range(8):
        times = _nodes(now, then)
        happens = [_face_event(found, times, closed), _rock_event(found, times, law)]
        first = min((t for t in happens if t is not None), default=None)
        if first is None:
            break
        then, (closing, turning) = first, happens
    _go(found, times, closed, law, closing == then, turning == then)
    return then


def _rates(case: Collision) -> float:
    """Of the fastest exponential."""
    rates = [0.0]
    if case.rod and (case.end == "rock" or case.bit_mass):
        z, stiff, mass = case.rod[-1][0], case.k1 / case.gamma, case.bit_mass
        rates.append(z / mass + math.sqrt(stiff / mass) if mass else stiff / z)
    for step, mass in case.joint_masses:
        assert case.rod is not None
        if mass:
            rates.append((case.rod[step - 1][0] + case.rod[step][0]) / mass)
    return max(rates)


# -- the face --


def _waves_at_face(found: Found, times: Vector) -> tuple[Vector, Vector]:
    f = found.striker[-1].right.leaving(times)
    return f, found.rod[0].left.leaving(times) if found.rod else np.zeros_like(times)


def _closed_at(found: Found, now: float, then: float) -> bool:
    if found.gap_after > 0.0:
        return False
    times = _nodes(now, then)
    f, g = _waves_at_face(found, times)
    scale = SMALL * 100.0 * (np.abs(f).max() + np.abs(g).max() + abs(found.collision.velocity_before))
    return bool((f - g)[0] > scale or (abs((f - g)[0]) <= scale and (f - g)[1] > scale))


def _first_root(
    times: Vector, values: Vector, wanted: Callable[[float, float], bool], skipped: float = 1e-9
) -> float | None:
    """The first time at which the sampled function goes through 0 as wanted, after a share of the interval.

    What begins with a zero needs the share; what does not may have its root within it.
    """
    part = Part(times[0], times[-1], FIT @ values)
    where = np.linspace(times[0], times[-1], LOOKS + 1)[1:]
    looks = SAMPLES @ values
    start = times[0] + skipped * (times[-1] - times[0])
    before, value = start, float(part.at(start))
    for t, new in zip(where, looks, strict=True):
        if wanted(value, float(new)):
            ends = float(part.at(before)), float(part.at(t))
            if ends[0] * ends[1] > 0.0:  # a zero at a look, to within rounding
                return before if abs(ends[0]) < abs(ends[1]) else float(t)
            return float(brentq(lambda s: float(part.at(s)), before, t, xtol=1e-16, rtol=1e-15))
        before, value = float(t), float(new)
    return None


def falls(a: float, b: float) -> bool:
    return a > 0.0 >= b


def rises(a: float, b: float) -> bool:
    return a < 0.0 <= b


def _integrated(times: Vector, values: Vector) -> Vector:
    """∫ from the first node to each."""
    return np.asarray(0.5 * (times[-1] - times[0]) * (INTEGRALS @ values))


def _whole(times: Vector, values: Vector) -> float:
    return float(_integrated(times, values)[-1])


def _face_event(found: Found, times: Vector, closed: bool) -> float | None:
    f, g = _waves_at_face(found, times)
    tiny = SMALL * 100.0 * (np.abs(f).max() + np.abs(g).max())
    if closed:
        return None if np.all(f - g > -tiny) else _first_root(times, f - g, falls)
    gap = found.gap_after + _integrated(times, 2.0 * (g - f))
    if found.gap_after == 0.0:  # open and touching: closes when f exceeds g, or after it has opened
        if np.all(np.abs(g - f) <= tiny):
            return None
        return _first_root(times, gap - SMALL * np.abs(gap).max(), falls)
    return _first_root(times, gap, falls, skipped=0.0)


# -- bit and rock --


def _law_at(found: Found, now: float, then: float) -> Law:
    """Just after `now`."""
    bit, case = found.bit, found.collision
    if bit is None:
        return OFF
    z, f = found.rod[-1].impedance, found.rod[-1].right
    ahead = f.leaving(_nodes(now, then))
    residual, k2 = (1.0 - case.gamma) * bit.deepest, case.k1 / case.gamma
    scale = max(bit.deepest, case.velocity_before * case.transit)
    if bit.position >= bit.deepest - 1e-12 * scale:
        force = case.k1 * bit.position if bit.position > 0.0 else 0.0
        inward = _inward(bit, case, z, ahead, force)
        if bit.deepest == 0.0 and inward <= 0.0:
            return OFF
        return Law(case.k1, 0.0, True) if inward > 0.0 else Law(k2, residual, False)
    if bit.position > residual + 1e-12 * scale:
        return Law(k2, residual, False)
    if bit.position < residual - 1e-12 * scale:
        return OFF
    return Law(k2, residual, False) if _inward(bit, case, z, ahead, 0.0) > 0.0 else OFF


def _inward(bit: Bit, case: Collision, z: float, ahead: Vector, force: float) -> float:
    """Speed just after, or where it is 0 the push that makes it."""
    scale = 1e-11 * abs(case.velocity_before)
    if case.bit_mass:
        if abs(bit.velocity) > scale:
            return bit.velocity
        pushes = 2.0 * z * ahead[:2] - force  # a wave through a lumped mass begins with 0
        return float(pushes[0] if abs(pushes[0]) > z * scale else pushes[1])
    speeds = 2.0 * ahead[:2] - force / z
    return float(speeds[0] if abs(speeds[0]) > scale else speeds[1])


def _bit_motion(found: Found, times: Vector, law: Law) -> tuple[Vector, Vector]:
    """Position and velocity at the nodes: collocation of the linear law."""
    bit, case, z = found.bit, found.collision, found.rod[-1].impedance
    assert bit is not None
    (stiffness, origin, _), f = law, found.rod[-1].right.leaving(times)
    n, slope = DEGREE + 1, SLOPE * 2.0 / (times[-1] - times[0])
    pushed = 2.0 * z * f - stiffness * (bit.position - origin)  # were it to stay; solved for how far it goes
    if not case.bit_mass:
        matrix, right = slope + stiffness / z * np.eye(n), pushed / z
        matrix[0], right[0] = np.eye(n)[0], 0.0
        way = np.linalg.solve(matrix, right)
        return bit.position + way, (pushed - stiffness * way) / z
    eye, zero, mass = np.eye(n), np.zeros((n, n)), case.bit_mass
    matrix = np.block([[slope, -eye], [stiffness / mass * eye, slope + z / mass * eye]])
    right = np.concatenate([np.full(n, bit.velocity), (pushed - z * bit.velocity) / mass])
    matrix[0], right[0] = np.concatenate([eye[0], zero[0]]), 0.0
    matrix[n], right[n] = np.concatenate([zero[0], eye[0]]), 0.0
    both = np.linalg.solve(matrix, right)
    return bit.position + both[:n], bit.velocity + both[n:]


def _rock_event(found: Found, times: Vector, law: Law) -> float | None:
    bit, case = found.bit, found.collision
    if bit is None or case.k1 == 0.0:  # a mass on a free end meets no rock
        return None
    position, velocity = _bit_motion(found, times, law)
    residual = (1.0 - case.gamma) * bit.deepest
    if law == OFF:
        return _first_root(times, position - residual, rises)
    if law.deepening:
        tiny = 1e-13 * abs(case.velocity_before)
        if case.gamma == 1.0 and np.all(velocity > -tiny):
            return None
        return _first_root(times, velocity + tiny, falls)
    ends = [_first_root(times, position - bit.deepest, rises), _first_root(times, position - residual, falls)]
    return min((t for t in ends if t is not None), default=None)


# -- one interval that nothing cuts --


def _go(found: Found, times: Vector, closed: bool, law: Law, meets: bool, turns: bool) -> None:
    case, start, end = found.collision, float(times[0]), float(times[-1])
    force = next((value for begun, value in reversed(case.load) if begun <= 0.5 * (start + end)), 0.0)
    g = found.striker[0].left.leaving(times)
    given: list[tuple[Way, Vector]] = []
    pushed = force if case.load_at == 0 else 0.0
    speed = 2.0 * g + pushed / found.striker[0].impedance
    given.append((found.striker[0].right, g + pushed / found.striker[0].impedance))
    for chain, loaded in ((found.striker, True), (found.rod, False)):
        for i in range(1, len(chain)):
            v = _step(found, chain, i, times, force if loaded and i == case.load_at else 0.0, loaded)
            given.append((chain[i - 1].left, v - chain[i - 1].right.leaving(times)))
            given.append((chain[i].right, v - chain[i].left.leaving(times)))
            speed = v if loaded and i == case.load_at else speed
    found.load_work += force * _whole(times, speed)
    given += _face(found, times, closed, meets)
    if found.rod:
        last, f = found.rod[-1], found.rod[-1].right.leaving(times)
        if found.bit is not None:
            given.append((last.left, _rock(found, times, law, turns) - f))
        elif case.end == "infinite":
            entering = next(values for way, values in given if way is last.right)
            found.endless_energy += last.impedance * _whole(times, entering**2)
        else:
            given.append((last.left, f if case.end == "free" else -f))
    for way, values in given:
        way.enter(start, end, values)


def _step(found: Found, chain: list[Section], i: int, times: Vector, pushed: float, striker: bool) -> Vector:
    """The speed at a step, which a lumped mass makes continuous."""
    one, other, both = chain[i - 1], chain[i], chain[i - 1].impedance + chain[i].impedance
    f, g = one.right.leaving(times), other.left.leaving(times)
    settled = (2.0 * one.impedance * f + 2.0 * other.impedance * g + pushed) / both
    mass = 0.0 if striker else dict(found.collision.joint_masses).get(i, 0.0)
    if mass == 0.0:
        return np.asarray(settled)
    matrix = SLOPE * 2.0 / (times[-1] - times[0]) + both / mass * np.eye(DEGREE + 1)
    right = both / mass * settled
    matrix[0], right[0] = np.eye(DEGREE + 1)[0], found.joints[i]
    speed = np.linalg.solve(matrix, right)
    found.joints[i] = float(speed[-1])
    return speed


def _face(found: Found, times: Vector, closed: bool, meets: bool) -> list[tuple[Way, Vector]]:
    f, g = _waves_at_face(found, times)
    striker, rod = found.striker[-1], found.rod[0] if found.rod else None
    tiny = SMALL * 100.0 * (np.abs(f).max() + np.abs(g).max() + abs(found.collision.velocity_before))
    if found.gap_after == 0.0 and abs(f[0] - g[0]) <= tiny:
        start = found.touches.pop()[0] if found.touches and found.touches[-1][1] == times[0] else float(times[0])
        found.touches.append((start, float(times[-1 if np.all(np.abs(f - g) <= tiny) else 0])))
    if not closed:
        if meets:
            found.gap_after = 0.0
        else:
            found.gap_after += _whole(times, 2.0 * (g - f))
            if found.gap_after < SMALL * abs(found.collision.velocity_before) * found.collision.until:
                found.gap_after = 0.0
        return [(striker.left, f), *([(rod.right, g)] if rod else [])]
    z = striker.impedance
    v = np.zeros_like(f) if rod is None else 2.0 * (z * f + rod.impedance * g) / (z + rod.impedance)
    force = z * (2.0 * f - v)
    impulse = _whole(times, force)
    if found.contacts and found.contacts[-1][1] == times[0]:
        last = found.contacts[-1]
        last[1], last[2], last[3] = float(times[-1]), last[2] + impulse, max(last[3], float(force.max()))
    else:
        found.contacts.append([float(times[0]), float(times[-1]), impulse, float(force.max())])
    found.work_through_face += _whole(times, force * v)
    return [(striker.left, v - f), *([(rod.right, v - g)] if rod else [])]


def _rock(found: Found, times: Vector, law: Law, turns: bool) -> Vector:
    """The speed of the bit; what it does to the rock is kept."""
    bit = found.bit
    assert bit is not None
    position, velocity = _bit_motion(found, times, law)
    force = law.stiffness * (position - law.origin)
    bit.work += _whole(times, force * velocity)
    bit.position, bit.velocity, bit.force = float(position[-1]), float(velocity[-1]), float(force[-1])
    bit.greatest_force = max(bit.greatest_force, float(force.max()))
    if turns and law.deepening:
        bit.velocity = 0.0
    elif turns:  # where one law becomes another
        edges = bit.deepest, (1.0 - found.collision.gamma) * bit.deepest
        bit.position = min(edges, key=lambda edge: abs(edge - bit.position))
    bit.deepest = max(bit.deepest, bit.position)
    return velocity
