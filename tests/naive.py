"""Slow, obvious twins of the steady states and their stability, in many digits.

Nothing here shares a line with the package: the formulas are written down as the theory states them, with 50
digits (an mpmath context of its own, so the global precision is left alone), plain loops and no thought for
speed. ``§`` in the comments are the sections of the theory page; "B77 (n)" are equations of U. Björkenstam,
"Impact vibration of a bar", Int. J. Mech. Sci. 19 (1977) 471-481.

How to read it: a *load* (`Fourier` or `Square`) answers for its value, its mean, the rigid velocity `v_f` and
the periodic response of one oscillator; a `Case` is a load with s, d, R, m; `phases` finds every root of v_f
= c; and `orbit(case, phase, modes)` is the steady state of the bar with modes 0 .. modes, forced part and
transient both cut off after that mode, so that it is an exact steady state of the truncated model and every
check below closes exactly.

Where a textbook formula loses digits for a small damping d it is simply worked out with more of them
(`digits_for`).
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
from numpy.typing import NDArray

Num = Any  # an mpmath number of the context below (or anything it converts)
Pair = tuple[Num, Num]  # (displacement, velocity) of one mode
Matrix = Any  # an mpmath matrix

mp: Any = mpmath.MPContext()
mp.dps = 50
PI: Num = +mp.pi


# ---------------------------------------------------------------- one oscillator: u'' + d u' + w2 u = F


def flow(w2: Num, d: Num, t: Num) -> tuple[Num, Num, Num, Num]:
    """The 2x2 propagator (row by row) of u'' + d u' + w2 u = 0 over the time t; w2 = 0 is the rigid
    motion."""
    if w2 == 0:
        return mp.one, fading(d, t), mp.zero, mp.exp(-d * t)
    decay = mp.exp(-d * t / 2)
    root = mp.sqrt(mp.mpc(w2 - d * d / 4))  # imaginary for an overdamped mode
    cosine = mp.re(mp.cos(root * t))
    sine = t if root == 0 else mp.re(mp.sin(root * t) / root)
    return (decay * (cosine + d / 2 * sine), decay * sine, -w2 * decay * sine, decay * (cosine - d / 2 * sine))


def digits_for(d: Num) -> Any:
    """A `with` block with the digits that differences of 1/d**2 lose."""
    return mp.workdps(mp.dps + (10 if d == 0 else 10 + 3 * max(0, int(-mp.log10(d)))))


def fading(d: Num, t: Num) -> Num:
    """(1 - e^{-dt})/d, and t for d = 0."""
    with digits_for(d):
        return t if d == 0 else (1 - mp.exp(-d * t)) / d


def fading_twice(d: Num, t: Num) -> Num:
    """The integral of `fading` from 0 to t, t**2/2 for d = 0."""
    with digits_for(d):
        return t * t / 2 if d == 0 else (t - (1 - mp.exp(-d * t)) / d) / d


def apply(matrix: tuple[Num, Num, Num, Num], x: Pair) -> Pair:
    return matrix[0] * x[0] + matrix[1] * x[1], matrix[2] * x[0] + matrix[3] * x[1]


def pushed(w2: Num, d: Num, t: Num, force: Num) -> Pair:
    """State at t of the oscillator that starts from rest at 0 under a constant force."""
    if w2 == 0:
        return force * fading_twice(d, t), force * fading(d, t)
    phi = flow(w2, d, t)
    return force * (1 - phi[0]) / w2, force * phi[1]


def solved(a: tuple[Num, Num, Num, Num], b: Pair) -> Pair:
    """The solution of a 2x2 system by Cramer's rule."""
    det = a[0] * a[3] - a[1] * a[2]
    return (b[0] * a[3] - a[1] * b[1]) / det, (a[0] * b[1] - b[0] * a[2]) / det


# ---------------------------------------------------------------- loads (§1, §7)


@dataclass(frozen=True)
class Fourier:
    """p(t) = Re sum p_k e^{ikt}, given by p_0, p_1, ... (§1)."""

    coefficients: tuple[Num, ...]

    @classmethod
    def of(cls, coefficients: Sequence[Any]) -> Fourier:
        """From complex numbers or from pairs [re, im]."""
        return cls(tuple(mp.mpc(*c) if isinstance(c, (list, tuple)) else mp.mpc(c) for c in coefficients))

    @property
    def mean(self) -> Num:
        return mp.re(self.coefficients[0])

    @property
    def breaks(self) -> tuple[Num, ...]:
        return ()

    def harmonics(self) -> list[tuple[int, Num]]:
        return [(k, p) for k, p in enumerate(self.coefficients) if k > 0]

    def sum(self, weight: Callable[[int], Num], t: Num) -> Num:
        """Re sum_{k >= 1} weight(k) p_k e^{ikt}."""
        return mp.re(mp.fsum(weight(k) * p * mp.expj(k * t) for k, p in self.harmonics()))

    def value(self, t: Num, side: str = "right") -> Num:
        return self.mean + self.sum(lambda k: mp.one, t)

    def rigid(self, d: Num, t: Num) -> Pair:
        """(a periodic displacement whose velocity is v_f, v_f) at the phase t (§4)."""
        return self.sum(lambda k: 1 / (1j * k * (d + 1j * k)), t), self.sum(lambda k: 1 / (d + 1j * k), t)

    def response(self, w2: Num, d: Num, t: Num) -> Pair:
        """Periodic response of u'' + d u' + w2 u = p at the phase t (§2)."""

        def transfer(k: int) -> Num:
            return 1 / (w2 + 1j * k * d - k * k)

        return self.mean / w2 + self.sum(transfer, t), self.sum(lambda k: 1j * k * transfer(k), t)

    def rigid_phases(self, d: Num, level: Num) -> list[Num]:
        """All phases in [0, 2 pi) with v_f = level: z = e^{i phase} solves a polynomial of degree 2K (§4)."""
        half = [p / (d + 1j * k) / 2 for k, p in self.harmonics()]
        while half and half[-1] == 0:
            half.pop()
        polynomial = [*reversed(half), -level, *(mp.conj(h) for h in half)]
        return on_the_circle(polynomial)


@dataclass(frozen=True)
class Square:
    """+q for 0 < t < kappa pi, -q for the rest of the period; everything piece by piece, no series (§7)."""

    q: Num
    kappa: Num

    @classmethod
    def of(cls, q: Any, kappa: Any) -> Square:
        return cls(mp.mpf(q), mp.mpf(kappa))

    @property
    def mean(self) -> Num:
        return self.q * (self.kappa - 1)

    @property
    def breaks(self) -> tuple[Num, ...]:
        return mp.zero, self.kappa * PI

    @property
    def pieces(self) -> tuple[Pair, Pair]:
        """(duration, force) of the two pieces."""
        return (self.kappa * mp.pi, self.q), ((2 - self.kappa) * mp.pi, -self.q)

    def fourier(self, harmonics: int) -> Fourier:
        """The truncated series, B77 (34)."""
        angle = [k * self.kappa * PI for k in range(harmonics + 1)]
        terms = [
            2 * self.q / (PI * k) * mp.mpc(mp.sin(angle[k]), mp.cos(angle[k]) - 1) for k in range(1, harmonics + 1)
        ]
        return Fourier((mp.mpc(self.mean), *terms))

    def value(self, t: Num, side: str = "right") -> Num:
        angle = reduced(t)
        if angle in self.breaks:
            return self.q if (angle == 0) == (side == "right") else -self.q
        return self.q if angle < self.kappa * PI else -self.q

    def follow(self, w2: Num, d: Num, start: Pair, offset: Num, t: Num) -> Pair:
        """From `start` at phase 0 to the phase t in [0, 2 pi] under the force p - offset."""
        x = start
        for duration, force in self.pieces:
            step = mp.mpf(min(t, duration))
            push = pushed(w2, d, step, force - offset)
            moved = apply(flow(w2, d, step), x)
            x = moved[0] + push[0], moved[1] + push[1]
            t = t - step
        return x

    def response(self, w2: Num, d: Num, t: Num) -> Pair:
        """Periodic response: the start that comes back after one period, followed to the phase t."""
        push = self.follow(w2, d, (mp.zero, mp.zero), mp.zero, 2 * PI)
        phi = flow(w2, d, 2 * PI)
        start = solved((1 - phi[0], -phi[1], -phi[2], 1 - phi[3]), push)
        return self.follow(w2, d, start, mp.zero, reduced(t))

    def rigid_start(self, d: Num) -> Num:
        """v_f at the phase 0, the lowest value: a triangle for d = 0, arcs of exponentials else."""
        if d == 0:
            return -PI * self.q * self.kappa * (2 - self.kappa) / 2
        with digits_for(d):
            back = self.follow(mp.zero, d, (mp.zero, mp.zero), self.mean, 2 * mp.pi)[1]
            return back / (1 - mp.exp(-2 * mp.pi * d))

    def rigid(self, d: Num, t: Num) -> Pair:
        return self.follow(mp.zero, d, (mp.zero, self.rigid_start(d)), self.mean, reduced(t))

    def rigid_phases(self, d: Num, level: Num) -> list[Num]:
        """v_f rises all through the first piece and falls all through the second: at most one root in
        each."""
        found, begin = [], mp.zero
        for duration, force in self.pieces:
            drive = force - self.mean
            first = self.rigid(d, begin)[1]
            with digits_for(d):
                if d == 0:
                    t = (level - first) / drive
                else:
                    ratio = (level - drive / d) / (first - drive / d)
                    t = -mp.log(ratio) / d if ratio > 0 else -mp.one
            if 0 <= t < duration:
                found.append(begin + t)
            begin = begin + duration
        return found


Load = Fourier | Square


def reduced(t: Num) -> Num:
    return mp.mpf(t) % (2 * PI)


def on_the_circle(polynomial: Sequence[Num]) -> list[Num]:
    """Arguments in [0, 2 pi) of the roots of modulus 1 (highest power first), each counted as often as it
    occurs.

    A double root (a fold) is found to about half the digits, hence the wide tolerance on the modulus.
    """
    roots = mp.polyroots(list(polynomial), maxsteps=2000, extraprec=400, asc=False)
    return sorted(reduced(mp.arg(z)) for z in roots if abs(abs(z) - 1) < mp.mpf(10) ** (-mp.dps // 3))


# ---------------------------------------------------------------- the case and its phases (§4)


@dataclass(frozen=True)
class Case:
    load: Load
    s: Num
    d: Num
    R: Num
    m: int

    @classmethod
    def of(cls, load: Load, s: Any, d: Any, R: Any, m: int) -> Case:
        return cls(load, mp.mpf(s), mp.mpf(d), mp.mpf(R), m)

    @property
    def period(self) -> Num:
        return 2 * mp.pi * self.m

    def stiffness(self, n: int) -> Num:
        return (n * PI * self.s) ** 2


def level(case: Case) -> Num:
    """The right-hand side c of B77 (14), as it stands in the book."""
    p0, d, R, T = case.load.mean, case.d, case.R, case.period
    if d == 0:
        return p0 * T * (1 - R) / (2 * (1 + R))
    with digits_for(d):
        E = mp.exp(-d * T)
        return p0 * T * (1 + R * E) / ((1 + R) * (1 - E)) - p0 / d


def v_f(case: Case, t: Num) -> Num:
    return case.load.rigid(case.d, t)[1]


def v_f_slope(case: Case, t: Num, side: str = "right") -> Num:
    """v_f' from the equation that v_f obeys, v_f' + d v_f = p - p_0."""
    return case.load.value(t, side) - case.load.mean - case.d * v_f(case, t)


@cache
def phases(case: Case) -> tuple[Num, ...]:
    """All phases of steady states, not filtered for admissibility."""
    return tuple(case.load.rigid_phases(case.d, level(case)))


def sign_changes(case: Case, samples: int = 4000) -> int:
    """How often v_f - c changes sign round the circle: the count of simple roots, by looking."""
    t = np.arange(samples) * 2 * np.pi / samples
    if isinstance(case.load, Fourier):
        weights = [complex(p / (case.d + 1j * k)) for k, p in case.load.harmonics()]
        values = sum((np.real(w * np.exp(1j * (k + 1) * t)) for k, w in enumerate(weights)), np.zeros(samples))
    else:
        values = np.array([float(v_f(case, x)) for x in t])
    above = values > float(level(case))
    return int(np.sum(above != np.roll(above, 1)))


# ---------------------------------------------------------------- the N-mode steady state (§4)


@dataclass(frozen=True)
class Orbit:
    case: Case
    phase: Num
    after: tuple[Pair, ...]  # (u_n, u_n') just after the impact, n = 0 .. N
    before: tuple[Pair, ...]  # just before the next one

    @property
    def modes(self) -> int:
        return len(self.after) - 1


def end_weight(n: int) -> int:
    """c_n in y = u(1, t) = sum c_n u_n (§2)."""
    return 1 if n == 0 else 2 * (-1) ** n


def flight(case: Case, n: int, theta: Num, x: Pair, t: Num) -> Pair:
    """Mode n at the time t of a flight that starts at the phase theta with the state x (§2), any x."""
    phi = flow(case.stiffness(n), case.d, t)
    if n == 0:
        begin, end = case.load.rigid(case.d, theta), case.load.rigid(case.d, theta + t)
        free = apply(phi, (x[0], x[1] - begin[1]))
        push = pushed(mp.zero, case.d, t, case.load.mean)
        return end[0] - begin[0] + free[0] + push[0], end[1] + free[1] + push[1]
    begin = case.load.response(case.stiffness(n), case.d, theta)
    end = case.load.response(case.stiffness(n), case.d, theta + t)
    free = apply(phi, (x[0] - begin[0], x[1] - begin[1]))
    return end[0] + free[0], end[1] + free[1]


def elastic_state(case: Case, phase: Num, n: int) -> Pair:
    """(I - D Phi) x = D (I - Phi) f, B77 (12, 13)."""
    R = case.R
    p = flow(case.stiffness(n), case.d, case.period)
    f = case.load.response(case.stiffness(n), case.d, phase)
    right = (1 - p[0]) * f[0] - p[1] * f[1], -R * (-p[2] * f[0] + (1 - p[3]) * f[1])
    return solved((1 - p[0], -p[1], R * p[2], 1 + R * p[3]), right)


def rigid_speed(case: Case, phase: Num) -> Num:
    """w_0, the velocity of mode 0 just before the impact."""
    d, R, T, p0 = case.d, case.R, case.period, case.load.mean
    if d == 0:
        return p0 * T / (1 + R)
    with digits_for(d):
        E = mp.exp(-d * T)
        return (v_f(case, phase) + p0 / d) * (1 - E) / (1 + R * E)


def orbit(case: Case, phase: Num, modes: int) -> Orbit:
    phase = mp.mpf(phase)
    elastic = [elastic_state(case, phase, n) for n in range(1, modes + 1)]
    offset = mp.fsum(end_weight(n) * x[0] for n, x in enumerate(elastic, start=1))
    after = [(-offset, -case.R * rigid_speed(case, phase)), *elastic]  # y(0+) = 0
    before = [flight(case, n, phase, x, case.period) for n, x in enumerate(after)]
    return Orbit(case, phase, tuple(after), tuple(before))


def return_error(o: Orbit) -> Num:
    """How far the state just after the next impact is from the one at the start; 0 for a steady state."""
    changes = (max(abs(b[0] - a[0]), abs(-o.case.R * b[1] - a[1])) for a, b in zip(o.after, o.before, strict=True))
    return max(changes)


def striking_speed(o: Orbit) -> Num:
    """u_t(1, 0-) of the model with modes 0 .. N."""
    return mp.fsum(end_weight(n) * b[1] for n, b in enumerate(o.before))


def forced_end_speed(case: Case, phase: Num) -> Num:
    """u_t(1, phase) of the elastic forced response, all modes (closed form, §2); Fourier loads."""
    return forced_field_closed(case, mp.one, phase)[1]


def striking_speed_closed_forced(o: Orbit) -> Num:
    """As `striking_speed`, but only the transient is cut off after mode N; the forced part has all modes."""
    cut = mp.fsum(
        end_weight(n) * o.case.load.response(o.case.stiffness(n), o.case.d, o.phase)[1] for n in range(1, o.modes + 1)
    )
    return striking_speed(o) - cut + forced_end_speed(o.case, o.phase)


def blow_energy(o: Orbit) -> Num:
    """Kinetic energy just before the impact, 1/2 int u_t**2 dx, in units of M L**3 Omega**2 (§10)."""
    return mp.fsum(abs(end_weight(n)) * b[1] ** 2 for n, b in enumerate(o.before)) / 2


def field(o: Orbit, x: Num, t: Num) -> tuple[Num, Num, Num]:
    """(u, u_t, u_x) at the place x and the time t after the impact, 0 <= t <= T: the sum over the modes
    (§2)."""
    x = mp.mpf(x)
    states = [flight(o.case, n, o.phase, a, mp.mpf(t)) for n, a in enumerate(o.after)]
    weights = [1 if n == 0 else 2 for n in range(len(states))]
    return (
        mp.fsum(w * u * mp.cos(n * PI * x) for n, (w, (u, _)) in enumerate(zip(weights, states, strict=True))),
        mp.fsum(w * v * mp.cos(n * PI * x) for n, (w, (_, v)) in enumerate(zip(weights, states, strict=True))),
        mp.fsum(
            -w * u * n * PI * mp.sin(n * PI * x) for n, (w, (u, _)) in enumerate(zip(weights, states, strict=True))
        ),
    )


# ---------------------------------------------------------------- the forced elastic response (§2)


def forced_field(case: Case, x: Num, t: Num, modes: int) -> tuple[Num, Num, Num]:
    """(u, u_t, u_x) of the periodic elastic response at phase t, modes 1 .. `modes`; mode 0 is left out."""
    x = mp.mpf(x)
    u = v = strain = mp.zero
    for n in range(1, modes + 1):
        a, b = case.load.response(case.stiffness(n), case.d, t)
        u, v = u + 2 * a * mp.cos(n * PI * x), v + 2 * b * mp.cos(n * PI * x)
        strain = strain - 2 * a * n * PI * mp.sin(n * PI * x)
    return u, v, strain


def cosine_sum(j: int, x: Num) -> Num:
    """sum_{n >= 1} cos(n pi x)/(n pi)**(2j) for 0 <= x <= 2, by the Bernoulli polynomials."""
    return (-1) ** (j - 1) * 2 ** (2 * j) * mp.bernpoly(2 * j, x / 2) / (2 * mp.factorial(2 * j))


def elastic_transfer(case: Case, k: int, x: Num, modes: int = 400, terms: int = 6) -> Num:
    """2 sum_n H_nk cos n pi x over *all* modes by summing: the first terms of the expansion of H_nk in
    1/n**2 are summed exactly, the small rest mode by mode. The error falls like modes**-(2 terms + 1)."""
    x, s2 = mp.mpf(x), case.s**2
    z = (k * k - 1j * k * case.d) / s2
    head = mp.fsum(z ** (j - 1) * cosine_sum(j, x) for j in range(1, terms + 1))
    squares = [(n * PI) ** 2 for n in range(1, modes + 1)]
    rest = mp.fsum(z**terms / (a**terms * (a - z)) * mp.cos(mp.sqrt(a) * x) for a in squares)
    return 2 * (head + rest) / s2


def forced_field_closed(case: Case, x: Num, t: Num) -> tuple[Num, Num, Num]:
    """(u, u_t, u_x) of the elastic response of all modes by the closed G_k and the static shape (§2)."""
    load = case.load
    assert isinstance(load, Fourier)
    x, s = mp.mpf(x), case.s
    q = {k: mp.sqrt(mp.mpc(k * k, -k * case.d)) / s for k, _ in load.harmonics()}

    def shape(k: int) -> Num:  # G_k without its mode 0
        return -mp.cos(q[k] * (1 - x)) / (s**2 * q[k] * mp.sin(q[k])) - 1 / mp.mpc(-k * k, k * case.d)

    def slope(k: int) -> Num:
        return -mp.sin(q[k] * (1 - x)) / (s**2 * mp.sin(q[k]))

    return (
        load.mean / s**2 * (mp.mpf(1) / 3 - x + x * x / 2) + load.sum(shape, t),
        load.sum(lambda k: 1j * k * shape(k), t),
        load.mean / s**2 * (x - 1) + load.sum(slope, t),
    )


# ---------------------------------------------------------------- many modes, in doubles


def many_modes(case: Case, phase: Any, modes: int) -> dict[str, NDArray[np.float64]]:
    """The 2x2 systems of modes 1 .. `modes` at once in numpy doubles, for sums of 10**5 modes; Fourier
    loads."""
    load = case.load
    assert isinstance(load, Fourier)
    s, d, R, T, phi = float(case.s), float(case.d), float(case.R), float(case.period), float(phase)
    w2 = (np.arange(1, modes + 1) * np.pi * s) ** 2
    f, g = np.full(modes, float(load.mean)) / w2, np.zeros(modes)
    for k, p in load.harmonics():
        h = complex(p) * np.exp(1j * k * phi) / (w2 + 1j * k * d - k * k)
        f, g = f + np.real(h), g + np.real(1j * k * h)
    root = np.sqrt(w2 - d * d / 4 + 0j)
    decay, cosine, sine = np.exp(-d * T / 2), np.cos(root * T).real, (np.sin(root * T) / root).real
    a, b = decay * (cosine + d / 2 * sine), decay * sine
    c, e = -w2 * b, decay * (cosine - d / 2 * sine)
    r0, r1 = (1 - a) * f - b * g, -R * (-c * f + (1 - e) * g)
    det = (1 - a) * (1 + R * e) + b * R * c
    u, v = (r0 * (1 + R * e) + b * r1) / det, ((1 - a) * r1 - R * c * r0) / det
    before = g + c * (u - f) + e * (v - g)
    return {"u": u, "after": v, "before": before, "forced_u": f, "forced_v": g}


# ---------------------------------------------------------------- the reduced criterion (§5, B77 29-32)


def sigma_closed(case: Case, phase: Num) -> Num:
    """sigma with the sum over n in closed form; Fourier loads."""
    load = case.load
    assert isinstance(load, Fourier)

    def closed(k: int) -> Num:
        q = mp.sqrt(mp.mpc(k * k, -k * case.d)) / case.s
        return (1 / (2 * q**2) - 1 / (2 * q * mp.sin(q))) / case.s**2

    return 2 / (load.mean * case.period) * load.sum(lambda k: 1j * k * closed(k), phase)


def sigma_modes(case: Case, phase: Num, modes: int) -> Num:
    """sigma with the sum over n cut off: sum (-1)**n times the forced velocity of mode n; any load."""
    speeds = ((-1) ** n * case.load.response(case.stiffness(n), case.d, phase)[1] for n in range(1, modes + 1))
    return 2 / (case.load.mean * case.period) * mp.fsum(speeds)


def sigma_sum(case: Case, phase: Num, head: int = 40) -> Num:
    """sigma by the alternating sum over n to infinity: `head` modes one by one, the tail by
    Cohen-Villegas-Zagier."""
    assert isinstance(case.load, Fourier)

    def speed(n: int) -> Num:
        return case.load.response(case.stiffness(n), case.d, phase)[1]

    first = mp.fsum((-1) ** n * speed(n) for n in range(1, head + 1))
    tail = (-1) ** (head + 1) * alternating(lambda j: speed(head + 1 + j))
    return 2 / (case.load.mean * case.period) * (first + tail)


def alternating(term: Callable[[int], Num], count: int = 50) -> Num:
    """sum (-1)**j term(j), j = 0, 1, ..., for smoothly falling terms (algorithm 1 of Cohen, Rodriguez
    Villegas and Zagier, Experimental Mathematics 9 (2000); error about 5.8**-count)."""
    power = (3 + mp.sqrt(8)) ** count
    power = (power + 1 / power) / 2
    b, c, total = -mp.one, -power, mp.zero
    for j in range(count):
        c = b - c
        total = total + c * term(j)
        b = b * (j + count) * (j - count) / ((j + mp.mpf(1) / 2) * (j + 1))
    return total / power


def reduced_coefficients(case: Case, phase: Num, sigma: Num, side: str = "right") -> tuple[Num, Num, Num]:
    """(a_0, a_1, a_2) of B77 (29-31)."""
    d, R, T = case.d, case.R, case.period
    E = mp.exp(-d * T)
    share = fading(d, T) / T  # (1 - E)/(dT)
    a2 = 1 + (1 + R) * sigma
    a1 = (
        -1
        - R**2 * E
        - share * (1 + R) ** 2 * v_f_slope(case, phase, side) / case.load.mean
        - (1 - R * E) * (1 + R) * sigma
    )
    a0 = R * E * (R - (1 + R) * sigma)
    return a0, a1, a2


def schur(a: tuple[Num, Num, Num]) -> Pair:
    return abs(a[0] / a[2]), abs(a[1] / (a[0] + a[2]))


def reduced_moduli(a: tuple[Num, Num, Num]) -> tuple[Num, Num]:
    """Moduli of the roots of a_2 xi**2 + a_1 xi + a_0, larger first."""
    root = mp.sqrt(mp.mpc(a[1] ** 2 - 4 * a[0] * a[2]))
    pair = [abs((-a[1] + root) / (2 * a[2])), abs((-a[1] - root) / (2 * a[2]))]
    return max(pair), min(pair)


def mode_pair(case: Case, n: int) -> tuple[Num, Num]:
    """Moduli of the two roots of mode n >= 1 in the reduced criterion, B77 (32)."""
    trace = flow(case.stiffness(n), case.d, case.period)
    half = (trace[0] + trace[3]) / 2  # e^{-dT/2} cos lambda_n T
    return reduced_moduli((-case.R * mp.exp(-case.d * case.period), -(1 - case.R) * half, mp.one))


# ---------------------------------------------------------------- exact multipliers (§5)


def saltation_jacobian(o: Orbit, side: str = "right") -> Matrix:
    """Jacobian of flight + impact in (theta, u_0, u_0', ..., u_N, u_N'), dense.

    flight of fixed length T, its derivative J; the flight really ends when y = c.u = 0, so dT = -c.J dx/(c.F)
    with F the flow just before the impact; then the reset. It has one eigenvalue more than the map on the
    section y = 0: a zero, whose vector is the flow itself. `side`: which side of a jump of the load is meant.
    """
    case, size = o.case, 2 * o.modes + 3
    d, T, p = case.d, case.period, case.load.value(o.phase, side)
    J, F, c = mp.zeros(size), mp.zeros(size, 1), mp.zeros(1, size)
    J[0, 0], F[0] = mp.one, mp.one
    for n in range(o.modes + 1):
        w2, row = case.stiffness(n), 1 + 2 * n
        phi = flow(w2, d, T)
        J[row, row], J[row, row + 1], J[row + 1, row], J[row + 1, row + 1] = phi
        # derivative of the flight's end to theta: (I - Phi) f', f' the rate of change of the forced state
        if n == 0:
            rate = v_f(case, o.phase), v_f_slope(case, o.phase, side)
        else:
            f = case.load.response(w2, d, o.phase)
            rate = f[1], p - d * f[1] - w2 * f[0]
        moved = apply(phi, rate)
        J[row, 0], J[row + 1, 0] = rate[0] - moved[0], rate[1] - moved[1]
        u, v = o.before[n]
        F[row], F[row + 1] = v, p - d * v - w2 * u
        c[0, row] = mp.mpf(end_weight(n))
    moved_flight = J - F * (c * J) / (c * F)[0]
    for n in range(o.modes + 1):
        for column in range(size):
            moved_flight[2 + 2 * n, column] *= -case.R
    return moved_flight


def impact_map(case: Case, theta: Num, x: Sequence[Pair], guess: Num) -> tuple[Num, list[Pair]]:
    """The nonlinear map itself: fly to the zero of y next to `guess` (Newton, in full precision), turn
    round."""
    t = guess
    for _ in range(60):
        states = [flight(case, n, theta, pair, t) for n, pair in enumerate(x)]
        gap = mp.fsum(end_weight(n) * u for n, (u, _) in enumerate(states))
        step = gap / mp.fsum(end_weight(n) * v for n, (_, v) in enumerate(states))
        t = t - step
        if abs(step) < mp.mpf(10) ** (10 - mp.dps):
            break
    else:
        raise RuntimeError("no impact found near the guess")
    states = [flight(case, n, theta, pair, t) for n, pair in enumerate(x)]
    return theta + t, [(u, -case.R * v) for u, v in states]


def difference_jacobian(o: Orbit, step: str = "1e-14") -> Matrix:
    """The same Jacobian by central differences of `impact_map`, in 50 digits: right to about step**2."""
    size, h = 2 * o.modes + 3, mp.mpf(step)
    base = [o.phase, *(value for pair in o.after for value in pair)]
    result = mp.zeros(size)

    def image(column: int, change: Num) -> list[Num]:
        z = list(base)
        z[column] += change
        pairs = [(z[1 + 2 * n], z[2 + 2 * n]) for n in range(o.modes + 1)]
        theta, after = impact_map(o.case, z[0], pairs, o.case.period)
        return [theta, *(value for pair in after for value in pair)]

    for column in range(size):
        ahead, behind = image(column, h), image(column, -h)
        for row in range(size):
            result[row, column] = (ahead[row] - behind[row]) / (2 * h)
    return result


def largest_first(values: Sequence[Num]) -> list[Num]:
    return sorted(values, key=lambda z: (-abs(z), -mp.re(z), -mp.im(z)))


def without_the_flow(values: Sequence[Num]) -> list[Num]:
    """Largest first, less the one zero that belongs to the flow: 2N + 2 multipliers."""
    return largest_first(values)[:-1]


def multipliers(o: Orbit, side: str = "right") -> NDArray[np.complex128]:
    """The 2N + 2 exact multipliers, largest first: dense eigenvalues (doubles) of the saltation Jacobian."""
    jacobian = np.array(saltation_jacobian(o, side).tolist(), dtype=float)
    return np.array([complex(z) for z in without_the_flow(list(np.linalg.eigvals(jacobian)))])


def multipliers_by_saltation(o: Orbit) -> list[Num]:
    """As `multipliers`, with eigenvalues in 50 digits."""
    return without_the_flow(eigenvalues(saltation_jacobian(o)))


def multipliers_by_difference(o: Orbit) -> list[Num]:
    """The multipliers from differences of the nonlinear map."""
    return without_the_flow(eigenvalues(difference_jacobian(o)))


def eigenvalues(matrix: Matrix) -> list[Num]:
    return list(mp.eig(matrix, left=False, right=False))


# ---------------------------------------------------------------- rest on the wall (§4)


def contact_transfer(case: Case, k: int) -> Num:
    """1/cos q_k by summing the modes cos((n + 1/2) pi x) of the bar that is held at the wall."""

    def term(n: int) -> Num:
        a = (n + mp.mpf(1) / 2) * PI
        return 2 * a * case.s**2 / ((a * case.s) ** 2 + 1j * k * case.d - k * k)

    head = 40
    return mp.fsum((-1) ** n * term(n) for n in range(head)) + (-1) ** head * alternating(lambda j: term(head + j))


def contact_force(case: Case, t: Num) -> Num:
    """f(t) of the bar that lies on the wall; Fourier loads."""
    load = case.load
    assert isinstance(load, Fourier)
    return load.mean + load.sum(lambda k: 1 / mp.cos(mp.sqrt(mp.mpc(k * k, -k * case.d)) / case.s), t)


def least_contact_force(case: Case) -> tuple[Num, Num]:
    """(the least f, its phase): f at every root of f', a trigonometric polynomial; Fourier loads."""
    load = case.load
    assert isinstance(load, Fourier)
    half = [1j * k * p / mp.cos(mp.sqrt(mp.mpc(k * k, -k * case.d)) / case.s) / 2 for k, p in load.harmonics()]
    while half and half[-1] == 0:
        half.pop()
    places = on_the_circle([*reversed(half), mp.zero, *(mp.conj(h) for h in half)]) if half else [mp.zero]
    return min((contact_force(case, t), t) for t in places)


# ---------------------------------------------------------------- energy over one period (§4), gap, ODE


@dataclass(frozen=True)
class Energy:
    input: float
    damping: float
    impact: float


def sampled(o: Orbit, t: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(u_n, u_n') of every mode at an array of times, both of shape (N + 1, len(t)): numpy doubles,
    Fourier loads."""
    load = o.case.load
    assert isinstance(load, Fourier)
    d, p0, phi = float(o.case.d), float(load.mean), float(o.phase)
    us, vs = [], []
    for n, (u0, v0) in enumerate(o.after):
        w2 = float(o.case.stiffness(n))

        def forced(time: NDArray[np.float64], w2: float = w2) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
            f, g = np.zeros_like(time), np.zeros_like(time)
            for k, p in load.harmonics():
                h = complex(p) * np.exp(1j * k * (time + phi)) / (w2 + 1j * k * d - k * k)
                f, g = f + np.real(h), g + np.real(1j * k * h)
            return f, g

        (f, g), (f0, g0) = forced(t), forced(np.zeros(1))
        u, v = float(u0) - f0[0], float(v0) - g0[0]
        if n == 0:
            fade = t if d == 0 else -np.expm1(-d * t) / d
            twice = t**2 / 2 - d * t**3 / 6 if d < 1e-8 else (t - fade) / d
            us.append(f + u + v * fade + p0 * twice)
            vs.append(g + v * np.exp(-d * t) + p0 * fade)
        else:
            u = u - p0 / w2
            root = np.sqrt(w2 - d * d / 4 + 0j)
            decay, cosine, sine = np.exp(-d * t / 2), np.cos(root * t).real, (np.sin(root * t) / root).real
            us.append(f + p0 / w2 + decay * (u * (cosine + d / 2 * sine) + v * sine))
            vs.append(g + decay * (-w2 * u * sine + v * (cosine - d / 2 * sine)))
    return np.array(us), np.array(vs)


def gauss_points(o: Orbit, points: int = 16) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Nodes and weights on [0, T], two panels to every cycle of the highest mode or harmonic."""
    load = o.case.load
    assert isinstance(load, Fourier)
    T = float(o.case.period)
    fastest = max(o.modes * np.pi * float(o.case.s), len(load.coefficients))
    panels = int(np.ceil(2 * fastest * T / (2 * np.pi))) + 1
    node, weight = np.polynomial.legendre.leggauss(points)
    edges = np.linspace(0, T, panels + 1)
    width = np.diff(edges) / 2
    return (edges[:-1, None] + width[:, None] * (1 + node)).ravel(), (width[:, None] * weight).ravel()


def energy(o: Orbit) -> Energy:
    """Work of the load, loss by damping and loss at the impact over one period, by quadrature; Fourier
    loads."""
    load = o.case.load
    assert isinstance(load, Fourier)
    t, w = gauss_points(o)
    _, v = sampled(o, t)
    weights = np.array([1.0] + [2.0] * o.modes)
    p = sum(np.real(complex(c) * np.exp(1j * k * (t + float(o.phase)))) for k, c in enumerate(load.coefficients))
    return Energy(
        input=float(np.sum(w * p * (weights @ v))),
        damping=float(o.case.d) * float(np.sum(w * (weights @ v**2))),
        impact=float((1 - o.case.R**2) * blow_energy(o)),
    )


def highest_gap(o: Orbit, margin: float = 1e-3, samples: int = 200_001) -> tuple[float, float]:
    """(largest y, its time) over margin < t < T - margin, by looking; > 0 means the state is not
    admissible."""
    T = float(o.case.period)
    t = np.linspace(margin, T - margin, samples)
    u, _ = sampled(o, t)
    y = np.array([float(end_weight(n)) for n in range(o.modes + 1)]) @ u
    top = int(np.argmax(y))
    return float(y[top]), float(t[top])


def flight_ode(
    case: Case, theta: Any, after: Sequence[Pair], duration: Any, rtol: float = 1e-12, atol: float = 1e-14
) -> NDArray[np.float64]:
    """States (u_n, u_n'), shape (N + 1, 2), after a flight of a given length: the modal equations B77 (6)
    put into scipy's DOP853 with no thought about their solution; it stops and restarts at the jumps of the
    load."""
    from scipy.integrate import solve_ivp

    count = len(after)
    w2 = np.array([float(case.stiffness(n)) for n in range(count)])
    d, begin = float(case.d), float(theta)
    end = begin + float(duration)
    turns = range(int(end // (2 * np.pi)) + 1)
    jumps = sorted(float(b) + 2 * np.pi * turn for b in case.load.breaks for turn in turns)
    edges = [begin, *(j for j in jumps if begin < j < end), end]
    state = np.array([[float(u) for u, _ in after], [float(v) for _, v in after]]).ravel()
    for left, right in pairwise(edges):
        if isinstance(case.load, Square):
            coefficients = np.array([complex(case.load.value(mp.mpf(left + right) / 2))])  # held in between
        else:
            coefficients = np.array([complex(p) for p in case.load.coefficients])

        def rate(t: float, z: NDArray[np.float64], c: NDArray[Any] = coefficients) -> NDArray[np.float64]:
            u, v = z[:count], z[count:]
            force = np.sum(c * np.exp(1j * t * np.arange(len(c)))).real
            return np.concatenate([v, force - d * v - w2 * u])

        state = solve_ivp(rate, (left, right), state, method="DOP853", rtol=rtol, atol=atol).y[:, -1]
    return np.stack([state[:count], state[count:]], axis=1)


# ---------------------------------------------------------------- the reference numbers


@cache
def reference() -> tuple[dict[str, Any], ...]:
    """The 14 systems of tests/data/steady.json."""
    return tuple(json.loads((Path(__file__).parent / "data" / "steady.json").read_text(encoding="utf-8")))


def reference_case(entry: dict[str, Any]) -> Case:
    return Case.of(Fourier.of(entry["load"]["coefficients"]), entry["s"], entry["d"], entry["R"], entry["m"])
