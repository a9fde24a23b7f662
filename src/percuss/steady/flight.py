"""A flight of the bar from impact to impact: how it moves, whether it stays off the wall, what energy goes where."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.halting import check_interrupted
from percuss.mechanics.flow import one_for_all, phi1, phi2, propagator
from percuss.model import Modes, System
from percuss.model.checks import Array
from percuss.short_repr import ShortRepr
from percuss.steady.forced import HarmonicResponse, PiecewiseResponse, Response, forced_response
from percuss.steady.oscillator import ModalState, cubic_sum, free_sum, resolvent_bound
from percuss.steady.phases import RELEASED_MODES


@dataclass(frozen=True)
class Truncation(ShortRepr):
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

    start_gap = 0.0  # where it starts: at the wall

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
        """Bound of the error of the striking end's position that the left-out modes make, relative to the stroke."""
        # A bound for a uniform bar under a smooth load whose impacts keep the strain, without damping for the first
        # 10¹⁸ modes, and for other bodies when their damping outlasts small divisors. Else it is an estimate, as with a
        # load that jumps and with Kelvin–Voigt's damping: modes beyond the probe are taken to fall off like those
        # inside it.
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
        check_interrupted()
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
        check_interrupted()
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


# ---- Does the bar pass through the wall between two impacts? Decided with bounds, not with a scan (theory §4)
#
# For the flight of a steady motion with one impact in a cycle, and for every flight of an orbit with several. A cell
# of time is dropped only when Taylor's theorem, with a bound of the acceleration, proves y < 0 on all of it. The
# first pass uses few modes and a bound of what the others can add; cells that this cannot decide are looked at with
# all.

_TOUCH = 1e-13  # share of the stroke below which a touch cannot be told from a miss
_DEPTH = 1e-9  # relative accuracy of the greatest depth
_ROUNDED = 1e-12  # share of the terms of y below which rounding may have made what is seen
_MOST_DOUBT = 1e-6  # share of the stroke above which a passage is one whatever the modes left out may do
_NARROWEST = 1e-14  # share of the period below which a cell is not split further
_MOST_WORK = 20_000_000  # modes × times


@dataclass(frozen=True)
class Violation(ShortRepr):
    """A passage through the wall between two impacts.

    Parameters
    ----------
    time
        When the striking end first passes the wall's place, in rad of the load after the impact.
    depth
        Greatest penetration during the flight, in bar lengths.
    """

    time: float
    depth: float


class _Bounds(NamedTuple):
    """Bounds of |y''| and |y'''| of the sums with a number of modes."""

    acceleration: float
    jerk: float


@dataclass(frozen=True)
class Contactless:
    """The first passage through the wall between impacts, or None, and whether it is proved: not when work ran out."""

    violation: Violation | None
    proven: bool = True


def flight_check(motion: Flown) -> Contactless:
    """Find the first passage of the striking end through the wall within the flight, or prove that there is none."""
    # A touch within 1e-13 of the stroke counts as none: rounding makes it undecidable. So does one within the error
    # that the modes left out may make, up to 1e-6 of the stroke; the answer is then not proven.
    first, proven, _ = _search(motion, np.inf)
    if not np.isfinite(first):
        return Contactless(None, proven)
    at_once = motion.rebound_velocity > 0.0 and motion.start_gap == 0.0
    answer = Contactless(Violation(0.0 if at_once else first, _depth(motion)), proven)
    doubt = min(motion.error_bound, _MOST_DOUBT) * motion.rigid_stroke if motion.requested_modes is None else 0.0
    return Contactless(None, False) if answer.violation is not None and answer.violation.depth <= doubt else answer


def stays_off(motion: Flown) -> bool:
    """Whether `flight_check` finds no passage: where one is deeper than any doubt, its time and depth are spared."""
    doubt = _MOST_DOUBT * motion.rigid_stroke
    if motion.requested_modes is not None:  # nothing is left out but by rounding
        gamma = motion.system.body.modes(motion.modes, motion.system.load.at).gamma
        doubt = max(_DEPTH * motion.rigid_stroke, _ROUNDED * float(np.abs(gamma) @ motion.state.amplitude))
    first, _, deep = _search(motion, doubt)
    return not deep and (not np.isfinite(first) or flight_check(motion).violation is None)


def a_passage(motion: Flown) -> float:
    """A time at which the bar is seen beyond the wall, inf for none; not always the first one."""
    return _search(motion, 0.0).first


class _Found(NamedTuple):
    """Where the bar is first seen beyond the wall (inf: nowhere), whether that is proved, whether it was `enough`."""

    first: float
    proven: bool
    deep: bool


def _search(motion: Flown, enough: float) -> _Found:
    """The first passage; the search ends at any place that is farther beyond the wall than `enough`."""
    few, touch = motion.truncation.few, _TOUCH * motion.rigid_stroke
    period, full = motion.period, _bounds(motion, motion.modes)
    start, stop = _safe_ends(motion, full)
    if start is None:
        return _Found(0.0, True, False)
    rest, rest_speed = _added_beyond(motion, few)
    acceleration = _bounds(motion, few).acceleration
    cells = 64 * motion.periods
    half = 0.5 * (stop - start) / cells
    centres: Array = np.asarray(start + half * (2.0 * np.arange(cells) + 1.0), dtype=float)
    first, work = np.inf, 0
    while centres.size and half > _NARROWEST * period:
        exact = few == motion.modes or 0.5 * acceleration * half**2 < rest
        work += centres.size * max(motion.modes if exact else few, 1)
        if work > _MOST_WORK:
            break
        y, speed = motion.end_motion(centres, motion.modes if exact else few)
        near_end = np.minimum(centres, period - centres) + half
        margin = 0.0 * y if exact else np.minimum(2.0 * rest, rest_speed * near_end)
        through = y - margin > touch
        if through.any():
            first = min(first, float(centres[through].min()))
            if float((y - margin).max()) > enough:
                return _Found(first, False, True)
        curvature = full.acceleration if exact else acceleration
        safe = y + np.abs(speed) * half + 0.5 * curvature * half**2 + margin < 0.0
        left = centres[~safe & (centres - half < first)]
        half *= 0.5
        centres = np.sort(np.concatenate([left - half, left + half]))
    return _Found(float(first), bool(not centres.size or half <= _NARROWEST * period), False)


def _depth(motion: Flown) -> float:
    """Greatest y of the flight, by branch and bound: cells that cannot beat the best value found are dropped."""
    modes = motion.truncation.some
    acceleration = _bounds(motion, modes).acceleration
    cells = 64 * motion.periods
    half = 0.5 * motion.period / cells
    centres: Array = np.asarray(half * (2.0 * np.arange(cells) + 1.0), dtype=float)
    best, when, work = 0.0, 0.0, 0
    while centres.size and half > _NARROWEST * motion.period and work < _MOST_WORK:
        work += centres.size * max(modes, 1)
        y, speed = motion.end_motion(centres, modes)
        if float(y.max()) > best:
            best, when = float(y.max()), float(centres[np.argmax(y)])
        reach = y + np.abs(speed) * half + 0.5 * acceleration * half**2
        left = centres[reach > best + _DEPTH * best + _TOUCH * motion.rigid_stroke]
        half *= 0.5
        centres = np.sort(np.concatenate([left - half, left + half]))
    return float(motion.end_motion(np.array([when]), motion.modes)[0][0]) if when > 0.0 else best


def tops(motion: Flown, low: float, high: float) -> tuple[Array, float]:
    """The cells of time between two times in which y may be greatest: their centres, and half their width."""
    # By branch and bound, ever more modes the narrower the cells: in the end all of a second look, and cells in which y
    # bends by less than the modes after them could add, or by a millionth of the stroke.
    most = motion.truncation.some
    modes, cells = motion.truncation.few, 64 * motion.periods
    half = 0.5 * (high - low) / cells
    centres: Array = np.asarray(low + half * (2.0 * np.arange(cells) + 1.0), dtype=float)
    while True:
        acceleration, rest = _bounds(motion, modes).acceleration, 2.0 * _added_beyond(motion, modes)[0]
        bend = max(rest if modes < most else 0.0, _MOST_DOUBT * motion.rigid_stroke)
        while True:
            y, speed = motion.end_motion(centres, modes)
            reach = y + np.abs(speed) * half + 0.5 * acceleration * half**2
            centres = centres[reach + 2.0 * rest >= float(y.max())]
            if 0.5 * acceleration * half**2 < bend or half < _NARROWEST * motion.period:
                break
            half *= 0.5
            centres = np.sort(np.concatenate([centres - half, centres + half]))
        if modes >= most:
            return centres, half
        modes = min(4 * modes, most)


def _safe_ends(motion: Flown, bounds: _Bounds) -> tuple[float | None, float]:
    """Times up to which, and from which on, the speeds at the impacts alone keep the bar off the wall."""
    speed = motion.impact_velocity
    start = 0.0 if motion.start_gap else _quotient(-2.0 * motion.rebound_velocity, bounds.acceleration)
    if not motion.system.contact.rebounds and not motion.start_gap:  # it starts from rest: its acceleration decides
        begin = start_acceleration(motion)
        if begin >= 0.0:
            return None, motion.period
        start = max(start, min(_quotient(-3.0 * begin, bounds.jerk), _next_break(motion)))
    stop = motion.period - _quotient(2.0 * speed, bounds.acceleration)
    return min(start, 0.5 * motion.period), max(stop, 0.5 * motion.period)


def _quotient(speed: float, rate: float) -> float:
    """How long a positive speed lasts against a rate of change that bounds its loss; 0 for none."""
    if speed <= 0.0:
        return 0.0
    return speed / rate if rate > 0.0 else np.inf


def start_acceleration(motion: Flown) -> float:
    """y''(0⁺) of the modes kept, when the bar starts from rest (R = 0)."""
    force = float(motion.system.load.value(motion.phase))
    modes, state = motion.system.body.modes(motion.modes, motion.system.load.at), motion.state
    rigid = force if motion.system.body.is_free else 0.0
    return rigid + float(modes.gamma @ (force - state.omega**2 * state.rebound))


def _next_break(motion: Flown) -> float:
    breaks = np.asarray(motion.system.load.breaks)
    if not breaks.size:
        return np.inf
    ahead = np.mod(breaks - motion.phase, 2.0 * np.pi)
    return float(ahead[ahead > 1e-12].min(initial=2.0 * np.pi))


def _bounds(motion: Flown, modes: int) -> _Bounds:
    d, push = motion.system.d, motion.system.push
    speed, force = motion.response.rigid_bounds()
    fastest = speed + push * motion.period + abs(motion.rigid_rebound) + speed
    rigid = force + push + d * fastest
    known = motion.system.body.modes(modes, motion.system.load.at)
    omega, damping = known.omega, known.damping
    swing = np.abs(known.gamma) * ringing(motion, motion.state.amplitude[:modes]) * (omega**2 + damping * omega)
    forced = motion.response.end_rates(modes, cut=motion.cut)
    acceleration = rigid + float(swing.sum()) + forced[0]
    return _Bounds(acceleration, d * rigid + float((swing * (omega + damping)).sum()) + forced[1])


def _added_beyond(motion: Flown, few: int) -> tuple[float, float]:
    """Bounds of the position and the speed that the modes after the first `few` add at the striking end."""
    known = motion.system.body.modes(motion.modes, motion.system.load.at)
    rest = (np.abs(known.gamma) * ringing(motion, motion.state.amplitude))[few:]
    return float(rest.sum()), float(rest @ known.omega[few:])


# ---- Energy over one impact period, term by term in closed form, so that the balance checks the orbit (theory §4)
#
# Input ∮ p u_t(x_p, t) dt, damping Σ d_n ∮ u_n'² dt, and what the contact law takes of kinetic and strain energy at
# the impact. The velocity is split into the forced part f' and the free part z' (for the mean motion: v_f and r); δ =
# z(T) − z(0). What the forced part alone loses is what the load puts into it.


@dataclass(frozen=True)
class Energy(ShortRepr):
    """Energy over one impact period, dimensionless."""

    input: float
    damping: float
    impact: float

    @property
    def imbalance(self) -> float:
        """input − damping − impact; rounding alone makes it differ from 0."""
        return self.input - self.damping - self.impact


def exchange(motion: Flown) -> tuple[float, float]:
    """Energy put in by the load, and taken by the damping, over a flight that takes whole load periods."""
    response = motion.response
    if isinstance(response, PiecewiseResponse):
        return _under_steps(motion, response)
    rigid, elastic = _rigid(motion, response.by_harmonics), _elastic(motion, response.by_harmonics)
    return rigid[0] + elastic[0], rigid[1] + elastic[1]


def _rigid(motion: Flown, response: HarmonicResponse) -> tuple[float, float]:
    d, p0, period = motion.system.d, motion.system.push, motion.period
    k, p, v = response.k, response.p, response.rigid_factor
    if not motion.system.body.is_free:
        return 0.0, 0.0
    turn = np.exp(1j * k * motion.phase)
    v_phi = float((v * turn).real.sum())
    start = motion.rigid_rebound - v_phi
    once, twice = period * float(phi1(d * period)), period**2 * float(phi2(d * period))
    fade = once / (d - 1j * k) * (d * start - p0)  # ∮ exp(ikt) r(t) dt
    half_turns = 0.5 * period
    put_in = half_turns * float((np.conj(p) * v).real.sum()) + float((p * turn * fade).real.sum())
    put_in += p0 * float(motion.rigid_motion(np.array([period]))[0][0])
    end = p0 * once + start * math.exp(-d * period)
    free = p0 * (p0 * twice + start * once) - 0.5 * (end**2 - start**2)
    damped = d * half_turns * float(np.sum(np.abs(v) ** 2)) + 2.0 * d * float((v * turn * fade).real.sum())
    return put_in, damped + free if d > 0.0 else 0.0


def _elastic(motion: Flown, response: HarmonicResponse) -> tuple[float, float]:
    k, p, state, system = response.k, response.p, motion.state, motion.system
    modes, gain = system.body.modes(state.omega.size, system.load.at), response.gains(state.omega.size)
    driven = modes.weight @ gain if motion.cut else response.driven_shape()
    square, weight = state.omega**2, modes.weight
    end, end_velocity = (a[:, 0] for a in motion.transient(np.array([motion.period])))
    jump, jump_velocity = end - state.z, end_velocity - state.z_velocity
    turned = p * np.exp(1j * k * motion.phase)
    work = np.conj(gain) * (square[:, None] * jump[:, None] + 1j * k * jump_velocity[:, None])  # ∮ exp(ikt) z'(t) dt
    put_in = float(weight @ ((work @ turned).real + system.load.mean * jump))
    free = 0.5 * (state.z_velocity**2 - end_velocity**2 + square * (state.z**2 - end**2))
    cross = 2.0 * modes.damping * ((gain * work) @ (1j * k * turned)).real
    damped = float(weight @ np.where(modes.damping > 0.0, free + cross, 0.0))
    forced = float(np.sum(0.5 * motion.period * np.abs(p) ** 2 * (1j * k * driven).real))
    return put_in + forced, damped + forced if np.any(modes.damping) else 0.0


def _under_steps(motion: Flown, response: PiecewiseResponse) -> tuple[float, float]:
    """Between its breaks a piecewise load is constant: every mode is a free oscillator about its static place."""
    ahead = np.mod(response.starts[None, :] - motion.phase, 2.0 * math.pi)
    ahead = (ahead + 2.0 * math.pi * np.arange(motion.periods)[:, None]).reshape(-1)
    knots = np.unique(np.concatenate([[0.0], ahead, [motion.period]]))
    knots = knots[np.append(True, np.diff(knots) > 1e-13)]
    knots[-1] = motion.period
    system, lengths = motion.system, np.diff(knots)
    force = system.load.value(motion.phase + 0.5 * (knots[1:] + knots[:-1]))
    u, v = motion.rigid_motion(knots)
    put_in = float(force @ np.diff(u))
    damped = put_in - 0.5 * float(v[-1] ** 2 - v[0] ** 2) if system.d > 0.0 else 0.0
    f, f_velocity = response.modal(motion.modes, motion.phase + knots)
    f[:, -1], f_velocity[:, -1] = f[:, 0], f_velocity[:, 0]  # a whole number of turns, to the last digit
    z, z_velocity = motion.transient(knots)
    w, w_velocity = f + z, f_velocity + z_velocity
    modes = system.body.modes(motion.modes, system.load.at)
    omega, damping = modes.omega[:, None], modes.damping[:, None]
    put_in += float(modes.weight @ (np.diff(w, axis=1) @ force))
    away = w[:, :-1] - force[None, :] / omega**2
    lost = _dissipated(omega, damping, (away, w_velocity[:, :-1]), lengths[None, :])
    return put_in, damped + float(modes.weight @ lost.sum(axis=1))


def _dissipated(omega: Array, d: npt.ArrayLike, start: tuple[Array, Array], t: Array) -> Array:
    """d ∫₀ᵗ z'² of free oscillators from (z, z'), from z' = Re Z exp((−d/2 + iλ)t); overdamped ones by their loss."""
    z, v = start
    d = one_for_all(d)
    if not np.any(d):
        return np.zeros(np.broadcast_shapes(np.shape(omega), np.shape(z), np.shape(t)))
    ringing = omega > 0.5 * d * (1.0 + 1e-3)
    rate = np.sqrt(np.where(ringing, omega**2 - 0.25 * d**2, 1.0))
    exponent = -0.5 * d + 1j * rate
    amplitude = exponent * (z - 1j * (v + 0.5 * d * z) / rate)
    swing = (amplitude**2 * np.expm1(2.0 * exponent * t) / (2.0 * exponent)).real
    lost = 0.5 * (np.abs(amplitude) ** 2 * -np.expm1(-d * t) + d * swing)
    step = propagator(omega, d, t)
    end, end_v = step.a * z + step.b * v, step.c * z + step.e * v
    fallen = 0.5 * (v**2 - end_v**2 + omega**2 * (z**2 - end**2))
    return np.asarray(np.where(ringing, lost, fallen))


# ---- What damping takes in flights of any duration, which quadrature gives to rounding

_NODES = 12  # of Gauss's rule, in half a period of the fastest that moves


class Stretch(NamedTuple):
    """A flight: the phase of the load at its start, how long it takes, and velocities of the modes 0 … N in it."""

    phase: float
    duration: float
    rates: Callable[[Array], Array]


def damped(system: System, masses: Array, flights: Iterable[Stretch]) -> float:
    """Energy that damping takes in flights, of a body with the modes 0 … N: `masses` are those of their velocities."""
    known, load = system.body.modes(masses.size, system.load.at), system.load
    share = np.append(system.d, known.damping * masses)
    if not share.any():
        return 0.0
    fastest = max(1.0, *known.omega[-1:].tolist(), *load.harmonics[-1:].tolist())
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    found = []
    for phase, duration, rates in flights:
        ahead = np.mod(np.asarray(load.breaks) - phase, 2.0 * math.pi)
        ahead = (ahead[:, None] + 2.0 * math.pi * np.arange(duration // (2.0 * math.pi) + 1)).reshape(-1)
        even = np.linspace(0.0, duration, math.ceil(duration * fastest / math.pi) + 1)
        edges = np.unique(np.concatenate([even, ahead[ahead < duration]]))
        half = 0.5 * np.diff(edges)[:, None]
        t = (edges[:-1, None] + half * (nodes + 1.0)).reshape(-1)
        found.append(float(share @ rates(t) ** 2 @ (half * weights).reshape(-1)))
    return math.fsum(found)
