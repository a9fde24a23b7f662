"""The flow between events: u'' + d u' + ω² u = force + ramp·t of every coordinate, in closed form.

All of it is told as increments, so that short times keep their digits, and broadcasts over coordinates, each with its
own damping, and times; overdamped and critically damped ones are no special case for the caller. `response` and
`series` are compiled as well (`percuss.compiled.twin`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple, overload

import numpy as np
import numpy.typing as npt

from percuss.model import Machine, MachineModes
from percuss.model.checks import Array
from percuss.model.machine import machine_modes

_NEAR = 0.1  # below this the differences in phi2 would lose digits and the series takes over
_SMALL = 0.5  # the series are taken where κt² and dt are no greater, and doubled from there
_SHORT, _TINY = 0.1, 0.01  # … and are shorter where they are no greater than these
_TERMS, _FEW, _FEWER = 16, 11, 8


# ---- Of one oscillator, κ = ω² and d down to 0: after a unit velocity, under a unit force and under a unit ramp


def response(t: float, stiffness: float, drag: float) -> tuple[float, float, float, float]:
    """s′, s, q and w at the time t: velocity and place after a unit velocity, place under unit force and ramp."""
    # A long swing by its circle, all else by power series and by doubling the time: smooth in κ and d, down to 0.
    square = stiffness - 0.25 * drag * drag
    if not (stiffness * t * t > _SMALL and square > 0.5 * stiffness and drag <= stiffness * t):
        return series(t, t, stiffness, drag)
    rate = math.sqrt(square)
    left, more = math.exp(-0.5 * drag * t), 0.5 * drag / rate
    sine, half = math.sin(rate * t), math.sin(0.5 * rate * t)
    s = left * sine / rate
    q = (2.0 * left * half * half - left * more * sine - math.expm1(-0.5 * drag * t)) / stiffness
    return left * (math.cos(rate * t) - more * sine), s, q, (t - s - drag * q) / stiffness


def free(t: float, stiffness: float, drag: float) -> tuple[float, float]:
    """s′ and s alone, of what no force moves: at half the cost."""
    if stiffness == 0.0:
        s = -math.expm1(-drag * t) / drag if drag > 0.0 else t
        return 1.0 - drag * s, s
    square = stiffness - 0.25 * drag * drag
    if not (stiffness * t * t > _SMALL and square > 0.5 * stiffness and drag <= stiffness * t):
        slope, s, _, _ = series(t, t, stiffness, drag)
        return slope, s
    rate = math.sqrt(square)
    left, more = math.exp(-0.5 * drag * t), 0.5 * drag / rate
    sine = left * math.sin(rate * t)
    return left * math.cos(rate * t) - more * sine, sine / rate


def series(t: Any, longest: float, stiffness: float, drag: float) -> tuple[Any, Any, Any, Any]:
    """The same of a time, or of an array of times, the longest of which tells how often it is halved."""
    doublings = 0
    while stiffness * longest * longest > _SMALL or drag * longest > _SMALL:
        longest *= 0.5
        doublings += 1
    t = t * 0.5**doublings
    z, b = stiffness * t * t, drag * t
    far = max(stiffness * longest * longest, drag * longest)
    terms = _TERMS if far > _SHORT else _FEW if far > _TINY else _FEWER if far > 0.0 else 1
    before, now = 0.0 * t, 1.0 + 0.0 * t  # coefficients of the series of s(t)/t, one after the other
    q, w = 0.5 * now, now / 6.0
    for n in range(1, terms):
        before, now = now, -(b * n * now + z * before) / (n * (n + 1))
        q = q + now / (n + 2)
        w = w + now / ((n + 2) * (n + 3))
    s = 1.0 - b * q - z * w
    ds, s, q, w = 1.0 - b * s - z * q, s * t, q * t * t, w * t * t * t
    for _ in range(doublings):
        w, t = 2.0 * w + q * s + (t - stiffness * w) * q, 2.0 * t
        ds, s, q = ds * ds - stiffness * s * s, s * (1.0 - stiffness * q + ds), 2.0 * q + s * s - stiffness * q * q
    return ds, s, q, w


# ---- Of many oscillators and times together: functions that stay exact as d → 0, and the propagator


def phi1(x: npt.ArrayLike) -> Array:
    """(1 − exp(−x))/x, with its limit 1 at x = 0."""
    x = np.asarray(x, dtype=float)
    if not x.any():  # most bars have no drag
        return np.ones(x.shape)
    safe = np.where(x == 0.0, 1.0, x)
    return np.asarray(np.where(x == 0.0, 1.0, -np.expm1(-safe) / safe))


def phi2(x: npt.ArrayLike) -> Array:
    """(exp(−x) − 1 + x)/x², with its limit 1/2 at x = 0."""
    x = np.asarray(x, dtype=float)
    if not x.any():
        return np.full(x.shape, 0.5)
    small = np.abs(x) < _NEAR
    everywhere = bool(small.all())
    y = np.asarray(x if everywhere else np.where(small, x, 0.0), dtype=np.float64)
    series = np.full(y.shape, 1.0 / 11.0)
    for j in range(10, 1, -1):  # 1/2 − x/6 + x²/24 − …, by Horner's rule
        series = (1.0 - y * series) / j
    if everywhere:
        return np.asarray(series)
    safe = np.where(small, 1.0, x)
    return np.asarray(np.where(small, series, (np.expm1(-safe) + safe) / safe**2))


def one_for_all(d: npt.ArrayLike) -> Array:
    """Damping, as a single number where all modes have the same: then it is turned into exponentials only once."""
    d = np.asarray(d, dtype=float)
    return d.reshape(-1)[0] if d.size and np.all(d == d.reshape(-1)[0]) else d


class Propagator(NamedTuple):
    """Φ(t) = [[a, b], [c, e]] of (u, u'), and numbers of it that would cancel if taken from a … e.

    `half` is exp(−dt/2); `versine` is exp(−dt/2)(1 − cos λt).
    """

    a: Array
    b: Array
    c: Array
    e: Array
    half: Array
    versine: Array


def propagator(omega: npt.ArrayLike, d: npt.ArrayLike, t: npt.ArrayLike) -> Propagator:
    """Of oscillators with undamped frequency `omega` > 0 and damping `d` ≥ 0 over t ≥ 0, which all broadcast."""
    omega, t = np.asarray(omega, dtype=float), np.asarray(t, dtype=float)
    half_d = 0.5 * one_for_all(d)
    square = omega**2 - half_d**2
    half = np.exp(-half_d * t)
    if np.all(square > 0.0):
        angle = np.sqrt(square) * t
        cosine, b = half * np.cos(angle), half * t * np.sinc(angle / np.pi)
        versine = half * 2.0 * np.sin(0.5 * angle) ** 2
    else:
        rate = np.sqrt(np.abs(square))
        over = square < 0.0
        angle = np.where(over, 0.0, rate) * t
        # exp(−dt/2) cosh and sinh without overflow: the slow decay is ω²/(d/2 + μ)
        slow = np.exp(-np.where(over, omega**2 / (half_d + rate), 0.0) * t)
        spread = np.where(over, 2.0 * rate, 0.0) * t
        cosine = np.where(over, 0.5 * slow * (1.0 + np.exp(-spread)), half * np.cos(angle))
        b = np.where(over, slow * t * phi1(spread), half * t * np.sinc(angle / np.pi))
        versine = np.where(over, -0.5 * slow * np.expm1(-0.5 * spread) ** 2, half * 2.0 * np.sin(0.5 * angle) ** 2)
    return Propagator(cosine + half_d * b, b, -(omega**2) * b, cosine - half_d * b, half, versine)


@overload
def excess(x: float) -> float: ...
@overload
def excess(x: Array) -> Array: ...
def excess(x: Any) -> Any:
    """The sine of x less x, exact for small x, of a number or an array."""
    one = isinstance(x, float)
    if one and abs(x) >= 1.0:
        return math.sin(x) - x
    small: Any = one or np.abs(x) < 1.0
    if not one and not small.any():
        return np.sin(x) - x
    y = x * x if one else np.where(small, x, 0.0) ** 2
    sum_of = 1.0 + 0.0 * y
    for j in range(19, 3, -2):  # 1 − x²/20 + …, by Horner's rule
        sum_of = 1.0 - y * sum_of / ((j - 1.0) * j)
    short = -x * y / 6.0 * sum_of
    return short if one else np.where(small, short, np.sin(x) - x)


def beyond_time(omega: Array, d: Array, b: Array, t: Array) -> Array:
    """Φ's b − t, without cancellation where the modes ring."""
    half = 0.5 * d
    square = omega**2 - half**2
    rate = np.where(square > 0.0, np.sqrt(np.abs(square)), 1.0)
    exact = np.expm1(-half * t) * b / np.exp(-half * t) + excess(rate * t) / rate
    return np.asarray(np.where((square > 0.0) & (half * t < 1.0), exact, b - t))


# ---- Of the coordinates of a machine, of which the first may be no oscillator

Response = tuple[Array, Array, Array, Array]
"""s′, s, q and w of every coordinate after some times; each of shape (N + 1, times), or (N + 1,) of one."""


def response_of(modes: MachineModes, t: Array) -> Response:
    """s′, s, q and w of every coordinate at the times t; each of shape (N + 1, len(t))."""
    # The motion as a whole is taken from its series, which is exact down to no chamber and no drag.
    ds, s, q, w = np.empty((4, modes.omega.size, t.size))
    ds[0], s[0], q[0], w[0] = _whole(modes, t)
    if modes.size:
        omega, damping = modes.omega[1:, None], modes.damping[1:, None]
        step = propagator(omega, damping, t[None, :])
        one_less = -np.expm1(-0.5 * damping * t) + step.versine - 0.5 * damping * step.b  # 1 − a
        ds[1:], s[1:], q[1:] = step.e, step.b, one_less / omega**2
        w[1:] = (t - s[1:] - damping * q[1:]) / omega**2
    return ds, s, q, w


def _whole(modes: MachineModes, t: Array) -> tuple[Any, Any, Any, Any]:
    square, drag = float(modes.omega[0]) ** 2, float(modes.damping[0])
    one = t.size == 1  # Newton's method asks for one time after the other, which need no arrays
    return response(float(t[0]), square, drag) if one else series(t, float(t.max(initial=0.0)), square, drag)


class StateFlow(NamedTuple):
    """What moves a machine in a state of its valve: the force `held` + `draw` π on its modes.

    The pressure π of a supply obeys c π′ = `supplied` − `draw` u′ of the driven place, with c the `compliance`; a
    constant pressure is part of `held`, with an infinite c. From a place u and a pressure π on the force is

        held + draw π + (draw²/c) u + (draw supplied/c) t

    on modes whose spring is stiffer by draw²/c: a ramp, so that the flow stays closed. `quickening` is of the supply.
    """

    modes: MachineModes
    held: float
    draw: float = 0.0
    supplied: float = 0.0
    compliance: float = math.inf
    quickening: float = 0.0

    @property
    def spring(self) -> float:
        """What the accumulator adds to the stiffness."""
        return self.draw * self.draw / self.compliance

    @property
    def ramp(self) -> float:
        """How the force on these modes grows."""
        return self.draw * self.supplied / self.compliance

    def force(self, u: Array, pressure: float) -> float:
        """On these modes, at the displacements of a beginning."""
        return self.held + self.draw * pressure + self.spring * float(self.modes.driven @ u)

    def rates(self, state: Array, pressure: float) -> tuple[Array, float]:
        """Velocities and accelerations of a state (N + 1, 2), and π′."""
        (u, v), modes, force = state.T, self.modes, self.force(state[:, 0], pressure)
        drawn = self.draw * float(modes.driven @ v)
        rise = (self.supplied - drawn) / self.compliance
        return np.stack([v, force * modes.driven - modes.omega**2 * u - modes.damping * v], axis=1), rise

    def maps(self, response: Response) -> tuple[Array, Array, Array]:
        """What becomes of every coordinate after some times, (…, times) each."""
        # The matrices of its state, (N + 1, 2, 2), where a unit force takes the state 0, and where `held` and the ramp
        # do, (N + 1, 2).
        ds, s, q, w = response
        square, driven = self.modes.omega[:, None] ** 2, self.modes.driven[:, None]
        matrices = np.moveaxis(np.array([[1.0 - square * q, s], [-square * s, ds]]), 2, 0)
        pushed = np.moveaxis(np.array([driven * q, driven * s]), 1, 0)
        fixed = self.held * pushed
        if self.ramp:
            fixed = fixed + self.ramp * np.moveaxis(np.array([driven * w, driven * q]), 1, 0)
        return matrices, pushed, fixed


def state_flows(machine: Machine, elastic: int) -> dict[str, StateFlow]:
    """The flow of a machine with so many elastic modes in each state of its valve."""
    valve, gas = machine.valve, machine.valve.chamber
    supply = valve.supply
    if valve.flows:  # the modes of the body alone, as `percuss.mechanics.oil` moves them
        own = machine_modes(machine.body, machine.at, 0.0, elastic)
        return {name: StateFlow(own, valve.force(name)) for name, _ in valve.pairs}
    if supply is None:
        return {name: StateFlow(machine.modes(elastic), valve.force(name)) for name, _ in valve.pairs}
    found, c = {}, supply.compliance
    for name, draw in valve.pairs:
        modes = machine_modes(machine.body, machine.at, gas.stiffness + draw * draw / c, elastic)
        found[name] = StateFlow(modes, gas.force, draw, supply.flow, c, supply.quickening)
    return found


@dataclass(frozen=True, kw_only=True)
class ModalFlight:
    """A stretch without an event: coordinates under a force towards the wall, which may grow by a ramp.

    `begin` holds displacement and velocity of each coordinate at its start, shape (N + 1, 2).
    """

    modes: MachineModes
    begin: Array
    force: float
    duration: float
    ramp: float = 0.0

    def moved(self, t: Array) -> tuple[Array, Array]:
        """How far the coordinates have moved since its start, and velocities; each of shape (N + 1, len(t))."""
        ds, s, q, w = response_of(self.modes, t)
        v = self.begin[:, 1:]
        pull = (self.force * self.modes.driven - self.modes.omega**2 * self.begin[:, 0])[:, None]
        moved, velocities = v * s + pull * q, v * ds + pull * s
        if self.ramp == 0.0:
            return moved, velocities
        grows = self.ramp * self.modes.driven[:, None]
        return moved + grows * w, velocities + grows * q

    def at(self, t: Array) -> tuple[Array, Array]:
        """Displacements and velocities of the coordinates at times after its start; each of shape (N + 1, len(t))."""
        moved, velocities = self.moved(t)
        return self.begin[:, :1] + moved, velocities

    @property
    def of_rates(self) -> ModalFlight:
        """The flight of the velocities, which move as displacements do."""
        modes, (u, v) = self.modes, self.begin.T
        rates = self.force * modes.driven - modes.omega**2 * u - modes.damping * v
        return ModalFlight(modes=modes, begin=np.stack([v, rates], axis=1), force=self.ramp, duration=self.duration)

    @property
    def end(self) -> Array:
        """The state at its end; shape (N + 1, 2)."""
        return np.stack([one[:, 0] for one in self.at(np.array([self.duration]))], axis=1)
