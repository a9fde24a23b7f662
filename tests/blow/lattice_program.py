"""Blows on a lattice: every section is a whole number of cells, and all that is in it moves by one cell a step.

A second program beside the package, made only to judge it: plain loops and the simplest rule at every node. What
happens between two steps (a gap that closes, a force in the face that ends, a rock that turns) is put off to the next
step; so the errors fall like the step. It is exact where nothing happens between steps.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.linalg import expm

from collisions import Collision

LEAST = 1e-12  # share of the greatest impulse below which a contact is rounding


@dataclass
class Row:
    """A section as two rows of cells: the waves to the right and to the left, next to leave at the right."""

    impedance: float
    right: deque[float]
    left: deque[float]

    @classmethod
    def moving(cls, impedance: float, cells: int, velocity: float) -> Row:
        return cls(impedance, deque([velocity / 2] * cells), deque([velocity / 2] * cells))

    def move(self, at_left: float, at_right: float) -> None:
        """One step: what leaves is forgotten, what the nodes have given enters."""
        self.right.pop()
        self.left.pop()
        self.right.appendleft(at_left)
        self.left.appendleft(at_right)

    def momentum(self, dt: float) -> float:
        return self.impedance * dt * (sum(self.right) + sum(self.left))

    def energy(self, dt: float) -> float:
        return self.impedance * dt * (sum(f * f for f in self.right) + sum(g * g for g in self.left))


@dataclass
class Rock:
    """The bit and the rock before it: where it is, how fast, and how deep it was."""

    k1: float
    gamma: float
    mass: float
    impedance: float
    dt: float
    position: float
    velocity: float = 0.0
    deepest: float = 0.0
    force: float = 0.0
    greatest_force: float = 0.0
    known: dict[float, np.ndarray] = field(default_factory=dict)

    @property
    def residual(self) -> float:
        return (1.0 - self.gamma) * self.deepest

    @property
    def dissipated(self) -> float:
        return 0.5 * (1.0 - self.gamma) * self.k1 * self.deepest**2

    @property
    def work(self) -> float:
        return self.dissipated + (0.0 if self.k1 == 0.0 else 0.5 * self.gamma * self.force**2 / self.k1)

    def met(self, f: float) -> float:
        """The wave that goes back from the incident f: one step of the law that holds at its beginning."""
        stiffness, origin = self._branch(f)
        before = self.position
        if self.mass == 0.0:
            rate = stiffness / self.impedance
            rest = 2.0 * f * self.dt if rate == 0.0 else -math.expm1(-rate * self.dt) * 2.0 * f / rate
            self.position = origin + (before - origin) * math.exp(-rate * self.dt) + rest
        else:
            if stiffness not in self.known:
                z, m = self.impedance, self.mass
                law = np.array([[0.0, 1.0, 0.0], [-stiffness / m, -z / m, 2.0 * z / m], [0.0, 0.0, 0.0]])
                self.known[stiffness] = expm(law * self.dt)
            state = self.known[stiffness] @ np.array([before - origin, self.velocity, f])
            self.position, self.velocity = float(state[0]) + origin, float(state[1])
        self.force = max(0.0, stiffness * (self.position - origin))
        self.greatest_force = max(self.greatest_force, self.force)
        self.deepest = max(self.deepest, self.position)
        return (self.position - before) / self.dt - f

    def _branch(self, f: float) -> tuple[float, float]:
        """Stiffness, and the place where the force is 0."""
        if self.position < self.residual:
            return 0.0, 0.0
        inward = self.velocity if self.mass else 2.0 * f - self.k1 * self.position / self.impedance
        if self.position >= self.deepest and inward > 0.0:
            return self.k1, 0.0
        return self.k1 / self.gamma, self.residual


@dataclass
class Mass:
    """A lumped mass between two sections."""

    mass: float
    velocity: float = 0.0

    def mean_velocity(self, settled: float, impedances: float, dt: float) -> float:
        """During a step in which the speed would settle at a value."""
        if self.mass == 0.0:
            return settled
        decay = impedances * dt / self.mass
        share, off = -math.expm1(-decay), self.velocity - settled
        self.velocity = settled + off * (1.0 - share)
        return settled + off * share / decay


@dataclass
class Found:
    """What the lattice says of the blow; `face` is the force in the face, a number per step."""

    dt: float
    collision: Collision
    momentum_after: float
    striker_energy_after: float
    rod_energy_after: float
    work_through_face: float
    load_work: float
    load_impulse: float
    gap_after: float
    face: np.ndarray
    rock: Rock | None
    peaks: list[tuple[float, float]]

    @property
    def impulse(self) -> float:
        return float(self.face.sum() * self.dt)

    @property
    def velocity_after(self) -> float:
        return self.momentum_after / self.collision.mass

    @property
    def restitution(self) -> float:
        return -self.velocity_after / self.collision.velocity_before

    @property
    def vibration_energy_after(self) -> float:
        return self.striker_energy_after - 0.5 * self.collision.mass * self.velocity_after**2

    @property
    def contacts(self) -> list[tuple[float, float, float, float]]:
        """(start, end, impulse, peak force)."""
        closed = np.concatenate([[False], self.face > 0.0, [False]])
        starts, ends = np.flatnonzero(closed[1:] & ~closed[:-1]), np.flatnonzero(closed[:-1] & ~closed[1:])
        spells = [
            (a * self.dt, b * self.dt, float(self.face[a:b].sum() * self.dt), float(self.face[a:b].max()))
            for a, b in zip(starts, ends, strict=True)
        ]
        least = LEAST * max((one[2] for one in spells), default=0.0)
        return [one for one in spells if one[2] > least]


def cells(case: Collision, dt: float) -> Collision:
    """The collision with every transit time a whole number of steps (at least one), the nearest."""

    def rounded(rows: tuple[tuple[float, float | None], ...]) -> tuple[tuple[float, float | None], ...]:
        return tuple((z, None if tau is None else max(1, round(tau / dt)) * dt) for z, tau in rows)

    return replace(case, striker=rounded(case.striker), rod=case.rod and rounded(case.rod))  # type: ignore[arg-type]


def blow(given: Collision, dt: float, peaks: bool = False) -> Found:
    """The blow with steps of dt."""
    case = cells(given.turned_into(float), dt)
    striker = [Row.moving(z, round(tau / dt), v) for (z, tau), v in zip(case.striker, case.velocity, strict=True)]
    rod = [Row.moving(z, 1 if tau is None else round(tau / dt), 0.0) for z, tau in case.rod or ()]
    masses = dict(case.joint_masses)
    joints = [Mass(masses.get(i, 0.0)) for i in range(1, len(rod))]
    rock = None
    if rod and (case.end == "rock" or case.bit_mass):
        rock = Rock(case.k1, case.gamma, case.bit_mass, rod[-1].impedance, dt, -case.rock_gap)
    still = [Mass(0.0) for _ in striker]
    steps = round(case.until / dt)
    face, gap = np.zeros(steps), case.gap
    work = load_work = load_impulse = endless = 0.0
    extremes = [[0.0, 0.0] for _ in striker]
    for step in range(steps):
        now = step * dt
        force = next((value for start, value in reversed(case.load) if start <= now + 0.5 * dt), 0.0)
        given_striker, speed = _nodes(striker, still, force, case.load_at, dt)
        given_rod, _ = _nodes(rod, joints, 0.0, -1, dt)
        at_face, into_rod, face[step], rate = _face(striker, rod, gap)
        work += face[step] * (into_rod[1] if rod else 0.0) * dt
        load_work, load_impulse = load_work + force * speed * dt, load_impulse + force * dt
        if rod:
            given_rod[0][0] = into_rod[0]
            f = rod[-1].right[-1]
            given_rod[-1][1] = _reflected(case.end, rock, f)
            endless += rod[-1].impedance * f * f * dt if case.end == "infinite" else 0.0
        given_striker[-1][1] = at_face
        gap = max(0.0, gap + rate * dt)
        for one, (at_left, at_right) in zip(striker + rod, given_striker + given_rod, strict=True):
            one.move(at_left, at_right)
        if peaks:
            _look(striker, extremes)
    energy = sum(one.energy(dt) for one in rod) + endless
    return Found(
        dt, case, sum(one.momentum(dt) for one in striker), sum(one.energy(dt) for one in striker), energy, work,
        load_work, load_impulse, gap, face, rock, [(high, low) for high, low in extremes],
    )  # fmt: skip


def _nodes(
    rows: list[Row], joints: list[Mass], force: float, load_at: int, dt: float
) -> tuple[list[list[float]], float]:
    """What enters each section at its left and at its right, ends of the chain left at 0, and the speed at the load."""
    given, speed = [[0.0, 0.0] for _ in rows], 0.0
    if rows and load_at >= 0:  # a striker's driven end
        g = rows[0].left[-1]
        given[0][0] = g + (force if load_at == 0 else 0.0) / rows[0].impedance
        speed = g + given[0][0]
    for i in range(1, len(rows)):
        one, other, pushed = rows[i - 1], rows[i], force if load_at == i else 0.0
        f, g, both = one.right[-1], other.left[-1], one.impedance + other.impedance
        settled = (2.0 * one.impedance * f + 2.0 * other.impedance * g + pushed) / both
        v = joints[i - 1].mean_velocity(settled, both, dt)
        given[i - 1][1], given[i][0] = v - f, v - g
        speed = v if load_at == i else speed
    return given, speed


def _face(striker: list[Row], rod: list[Row], gap: float) -> tuple[float, tuple[float, float], float, float]:
    """The wave back into the striker, that into the rod with the speed of its face, the force, the rate of the gap."""
    z, f = striker[-1].impedance, striker[-1].right[-1]
    g = rod[0].left[-1] if rod else 0.0
    if gap > 0.0 or f <= g:
        return f, (g, 2.0 * g), 0.0, 2.0 * (g - f)
    if not rod:
        return -f, (0.0, 0.0), 2.0 * z * f, 0.0
    other = rod[0].impedance
    v = 2.0 * (z * f + other * g) / (z + other)
    return v - f, (v - g, v), z * (2.0 * f - v), 0.0


def _reflected(end: str, rock: Rock | None, f: float) -> float:
    if rock is not None:
        return rock.met(f)
    return {"infinite": 0.0, "free": f, "fixed": -f}[end]


def _look(rows: list[Row], extremes: list[list[float]]) -> None:
    """The greatest compression and tension of each section so far; every pair of cells that meet is seen once."""
    for one, found in zip(rows, extremes, strict=True):
        forces = one.impedance * (np.array(one.right) - np.array(one.left)[::-1])
        found[0], found[1] = max(found[0], float(forces.max())), max(found[1], float(-forces.min()))
