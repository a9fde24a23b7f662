"""A flight of the bar from impact to impact: how its mean and its striking end move, and how many modes that takes."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

import numpy as np

from percuss.halting import look
from percuss.mechanics.flow import phi1, phi2, propagator
from percuss.model import Modes, System
from percuss.model.checks import Array
from percuss.shown import Shown
from percuss.steady.forced import Response, forced_response
from percuss.steady.oscillator import ModalState, free_sum
from percuss.steady.phases import RELEASED_MODES
from percuss.steady.small_divisors import cubic_sum, resolvent_bound


@dataclass(frozen=True)
class Truncation(Shown):
    """The modes kept, those that give 1e-3 and 1e-7 of the stroke, and a bound of the others at the end."""

    modes: int
    few: int
    some: int
    state: ModalState = field(repr=False)
    lost: float | None = None


class Flown:
    """A flight from an impact on: the only one of a steady motion (`Orbit`), or one of several (`Flight`)."""

    if TYPE_CHECKING:

        @property
        def system(self) -> System: ...
        @property
        def phase(self) -> float: ...
        @property
        def periods(self) -> int: ...
        @property
        def period(self) -> float: ...
        @property
        def requested_modes(self) -> int | None: ...
        @property
        def tolerance(self) -> float: ...
        @property
        def rigid_stroke(self) -> float: ...
        @property
        def rigid_rebound(self) -> float: ...
        @property
        def rebound_velocity(self) -> float: ...
        @property
        def impact_velocity(self) -> float: ...
        def modal_state(self, modes: int) -> ModalState: ...

    start_gap = 0.0
    """Where it starts: at the wall."""

    @cached_property
    def response(self) -> Response:
        """The forced response of the bar."""
        return forced_response(self.system)

    @cached_property
    def truncation(self) -> Truncation:
        """The modes kept, and what is known of the others."""
        return _truncation(self)

    @property
    def modes(self) -> int:
        """N, the number of elastic modes in the sums."""
        return self.truncation.modes

    @cached_property
    def error_bound(self) -> float:
        """Bound of the error of the striking end's position that the left-out modes make, relative to the stroke.

        A bound for a uniform bar under a smooth load whose impacts keep the strain, without damping for the first 10¹⁸
        modes, and for other bodies when their damping outlasts small divisors. Else it is an estimate, as with a load
        that jumps and with Kelvin–Voigt's damping: modes beyond the probe are taken to fall off like those inside it.
        """
        lost = self.truncation.lost
        if lost is None:  # a requested number of modes: the forced part is cut as well
            probe = max(4 * self.modes, 2048)
            lost = _forced_cut(self, self.modes, probe) + float(_left_out(self, probe)[self.modes])
        return lost / self.rigid_stroke

    @property
    def state(self) -> ModalState:
        """The elastic modes at the impact from which the flight starts."""
        return self.truncation.state

    @property
    def cut(self) -> bool:
        """Whether the forced part ends with the modes of the sums, too: those of a bar of so many modes."""
        return self.requested_modes is not None

    def rigid_motion(self, t: Array) -> tuple[Array, Array]:
        """Displacement since the impact and velocity of the mean of the bar; each of the shape of `t`."""
        theta, (drift, drift_velocity) = self.phase + t, self._drift(t)
        moved = self.response.rigid_displacement(theta) - self._rigid_start[0]
        return moved + drift, self.response.rigid_velocity(theta) + drift_velocity

    def _drift(self, t: Array) -> tuple[Array, Array]:
        """What the mean load and the impact add to the periodic rigid motion, and its velocity."""
        d, mean = self.system.d, self.system.push
        start = self.rigid_rebound - self._rigid_start[1]
        fade = t * phi1(d * t)
        return mean * t**2 * phi2(d * t) + start * fade, mean * fade + start * np.exp(-d * t)

    @cached_property
    def _rigid_start(self) -> tuple[float, float]:
        """Periodic displacement and velocity of the rigid motion at the impact phase."""
        here = np.array([self.phase])
        return float(self.response.rigid_displacement(here)[0]), float(self.response.rigid_velocity(here)[0])

    def mean_range(self, rebound: float) -> float:
        """Range of the mean motion from a rebound velocity on; of a body that is held that of the contact itself."""
        t, pushed, faded = _looks(self.system.d, self.period, self.periods)
        if not self.system.body.is_free:
            return float(np.ptp(self.end_motion(t, self.modes)[0]))
        drift = self.system.push * pushed + (rebound - self._rigid_start[1]) * faded
        return float(np.ptp(self.response.rigid_displacement(self.phase + t) + drift))

    def transient(self, t: Array) -> tuple[Array, Array]:
        """z_n(t) and z_n'(t), the free part of the elastic modes; each of shape (modes, len(t))."""
        state = self.state
        step = propagator(state.omega[:, None], self._known.damping[:, None], t[None, :])
        z, v = state.z[:, None], state.z_velocity[:, None]
        return step.a * z + step.b * v, step.c * z + step.e * v

    def end_motion(self, t: Array, modes: int) -> tuple[Array, Array]:
        """Gap function and its velocity with the first `modes` modes of the sums only; each of shape (len(t),)."""
        look()
        forced, forced_velocity = self._forced_end(t, modes)
        drift, drift_velocity = self._drift(t)
        rows = self._end_rows[:, :modes]
        z, z_velocity = self._free_sum(t, rows)
        known: dict[int, float] = self.__dict__.setdefault("_starts", {})
        if modes not in known:
            known[modes] = float(self._forced_end(np.zeros(1), modes)[0][0] + rows[0] @ self.state.z[:modes])
        return forced + drift + z[0] + (self.start_gap - known[modes]), forced_velocity + drift_velocity + z_velocity[0]

    def _forced_end(self, t: Array, modes: int) -> tuple[Array, Array]:
        return self.response.end_motion(self.phase + t, modes, cut=self.cut)

    def _free_sum(self, t: Array, rows: Array) -> tuple[Array, Array]:
        state = self.state
        return free_sum(state.omega, self._known.damping, (state.z, state.z_velocity), t, rows)

    @cached_property
    def _known(self) -> Modes:
        return self.system.body.modes(self.modes, self.system.load.at)

    @cached_property
    def _end_rows(self) -> Array:
        """γ_n, by which the modes move the striking end; shape (1, modes)."""
        return self._known.gamma[None, :]


@lru_cache(maxsize=32)
def _looks(d: float, period: float, periods: int) -> tuple[Array, Array, Array]:
    """Times of a flight, and what a unit mean load and a unit start velocity have moved by then."""
    t = np.linspace(0.0, period, 64 * periods + 1)
    looks = t, np.asarray(t**2 * phi2(d * t)), np.asarray(t * phi1(d * t))
    for values in looks:
        values.setflags(write=False)
    return looks


@dataclass(frozen=True)
class Flight(Flown):
    """A flight from any state at the wall; times in radians of the load after the impact that it starts from.

    `period` is its duration, `start` the elastic modes at that impact, `rigid_stroke` the range of the mean motion over
    the whole orbit, the scale of errors; `start_gap` is not 0 where the striking end does not start at the wall.
    """

    system: System
    requested_modes: int
    phase: float
    period: float
    start: ModalState
    rigid_rebound: float
    rebound_velocity: float
    impact_velocity: float
    rigid_stroke: float = 1.0
    start_gap: float = 0.0

    @property
    def periods(self) -> int:
        """The load periods that it takes, rounded up."""
        return max(1, math.ceil(self.period / (2.0 * math.pi)))

    tolerance = 0.0  # nothing is left out

    def modal_state(self, modes: int) -> ModalState:
        """The first elastic modes at the impact that it starts from."""
        return self.start.first(modes)

    def rates(self, t: Array) -> Array:
        """Velocities of the modes 0 … N, shape (N + 1, len(t))."""
        elastic = self.response.modal(self.modes, self.phase + t)[1] + self.transient(t)[1]
        return np.vstack([self.rigid_motion(t)[1], elastic])

    @property
    def depth(self) -> float:
        """How far the striking end goes from the wall, at most."""
        fastest = max(1.0, *self.state.omega[-1:].tolist(), *self.system.load.harmonics[-1:].tolist())
        return deepest(lambda t: self.end_motion(t, self.modes), self.period, fastest)


_LOOKS_PER_WAVE, _HALVINGS = 8, 50


def deepest(gap: Callable[[Array], tuple[Array, Array]], duration: float, fastest: float) -> float:
    """How far a flight goes from the wall, at most: from its gap and velocity, looked at for each wave of a mode."""
    t = np.linspace(0.0, duration, math.ceil(_LOOKS_PER_WAVE * (duration * fastest / math.pi + 1.0)))
    y, v = gap(t)
    turns = np.flatnonzero((v[:-1] < 0.0) & (v[1:] >= 0.0))
    low, high = t[turns], t[turns + 1]
    for _ in range(_HALVINGS if turns.size else 0):
        middle = 0.5 * (low + high)
        falls = gap(middle)[1] < 0.0
        low, high = np.where(falls, middle, low), np.where(falls, high, middle)
    least = float(gap(high)[0].min()) if turns.size else math.inf
    return -min(least, float(y.min()))


# ---- How many elastic modes the sums need, and how much the omitted ones can contribute

_PROBES = (256, 2048, 16384, 65536)
_MOST_MODES = 16384
_VAGUE = 1e-9  # share of the stroke above which the plain bound, which grows like 1/d, gives way to the sharper one
_FEW, _SOME = 1e-3, 1e-7  # shares of the stroke that a first and a second look at the motion may leave out


def _truncation(motion: Flown) -> Truncation:
    """Choose the number of modes that the tolerance asks for, or take the number requested."""
    if motion.requested_modes is not None:
        n = motion.requested_modes
        lost = None if motion.system.body.is_free else 0.0  # a structure has no other modes
        return Truncation(n, n, n, motion.modal_state(n), lost)
    scale = motion.rigid_stroke
    if not motion.system.contact.keeps_strain:  # what its release sets ringing falls off like 1/n²
        return Truncation(RELEASED_MODES, RELEASED_MODES, RELEASED_MODES, motion.modal_state(RELEASED_MODES))
    largest = motion.response.most_modes
    for probe in [p for p in _PROBES if p < largest] + [largest]:
        look()
        left_out = _left_out(motion, probe)
        if left_out[-1] <= 0.5 * motion.tolerance * scale:
            break
    most = min(probe, _MOST_MODES)

    def enough(share: float) -> int:
        found = np.flatnonzero(left_out <= share * scale)
        return min(most, max(8, int(found[0]))) if found.size else most

    modes = enough(motion.tolerance)
    lost = float(left_out[modes])
    return Truncation(modes, enough(_FEW), enough(_SOME), motion.modal_state(modes), lost)


def _left_out(motion: Flown, probe: int) -> Array:
    """Bound of what is lost at the striking end by keeping n = 0 … `probe` modes; shape (probe + 1,)."""
    amplitude = ringing(motion, motion.modal_state(probe).amplitude)
    coupling = np.abs(motion.system.body.modes(probe, motion.system.load.at).gamma)
    lost = np.append(np.cumsum((coupling * amplitude)[::-1])[::-1], 0.0)
    return np.asarray(2.0 * (lost + _beyond(motion, amplitude)))  # at t and, as y(0) = 0 places the wall, at 0


def _forced_cut(motion: Flown, modes: int, probe: int) -> float:
    """Bound of the forced motion of all modes after the first `modes`; inf when the load reaches beyond `probe`."""
    body = motion.system.body
    each = body.coupling_bound * motion.response.modal_bounds(probe)[0]
    floor = body.frequency_floor(probe)
    if floor <= 0.0:
        return math.inf
    beyond = body.coupling_bound * motion.response.displacement_tail(floor) * body.transit_time / (math.pi * floor)
    return 2.0 * (float(each[modes:].sum()) + beyond)  # twice as in _left_out


def ringing(motion: Flown, amplitude: Array) -> Array:
    """Amplitudes after the impact of the first modes, with those after the jumps of a piecewise load added."""
    return amplitude if motion.response.is_smooth else amplitude + motion.response.ringing(amplitude.size)


def _beyond(motion: Flown, amplitude: Array) -> float:
    """Bound of what all modes after the last of `amplitude` add at the striking end, or an estimate of it."""
    system, body, n = motion.system, motion.system.body, amplitude.size
    modes, floor = body.modes(n, system.load.at), body.frequency_floor(n)
    top = slice(n // 2, n)
    shares = modes.damping[top] / modes.omega[top]
    known = system.contact.keeps_strain and floor > 0.0 and shares[-1] <= shares[0]
    last = float(modes.damping[-1])
    each = motion.response.modal_velocity_bound(motion.phase, floor, last) if known else math.inf
    bound = 0.5 * body.coupling_bound * each * body.transit_time / (math.pi * floor**2) if known else math.inf
    if math.isfinite(bound):  # of Σ |f_n'|/ω_n, as |f_n'| ≤ each/ω_n² and ω_{n+j} ≥ floor + jπs
        contact, free = system.contact, not np.any(modes.damping)
        if contact.is_lossless and free:
            return bound  # nothing rings but −f_n'
        damped = resolvent_bound(system, motion.period, floor, last)
        if bound * damped <= _VAGUE * motion.rigid_stroke or (contact.is_lossless and math.isfinite(damped)):
            return bound * damped
        if body.is_harmonic and np.all(modes.damping == last):
            # hardly damped: by how near the modes come to resonance with the impacts
            full, shift = 1.0 / contact.impedance_ratio, last**2 * motion.periods / (8.0 * floor)
            near = cubic_sum(system.s, motion.periods, n, damped / full, shift)
            return float(body.coupling_bound * each / modes.omega[0] ** 3 * full * near)
    order = 3 if motion.response.is_smooth and system.contact.keeps_strain else 2
    numbers = np.arange(1, n + 1)[top]
    return body.coupling_bound * float(np.max(amplitude[top] * numbers**order)) / float((order - 1) * n ** (order - 1))
