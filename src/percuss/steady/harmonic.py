"""Forced response to a load given by harmonics: sums over all modes as the body has them (theory §4)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from percuss.halting import look
from percuss.mechanics.flow import phi1, phi2
from percuss.model import Body, System
from percuss.model.checks import Array, ComplexArray
from percuss.shown import Shown
from percuss.steady.oscillator import dissipated, refuse_resonance
from percuss.steady.trigonometric import phases_of_waves, turns_of_waves

if TYPE_CHECKING:
    from percuss.steady.oscillator import ModalState


# ---- Energy over one impact period, term by term in closed form, so that the balance checks the orbit (theory §4)
#
# Input ∮ p u_t(x_p, t) dt, damping Σ d_n ∮ u_n'² dt, and what the contact law takes of kinetic and strain energy at the
# impact. The velocity is split into the forced part f' and the free part z' (for the mean motion: v_f and r);
# δ = z(T) − z(0). What the forced part alone loses is what the load puts into it.


@dataclass(frozen=True)
class Energy(Shown):
    """Energy over one impact period, dimensionless.

    Parameters
    ----------
    input
        Put in by the load.
    damping
        Taken by the damping.
    impact
        Taken by the impact.
    """

    input: float
    damping: float
    impact: float

    @property
    def imbalance(self) -> float:
        """input − damping − impact; rounding alone makes it differ from 0."""
        return self.input - self.damping - self.impact


class Waves(NamedTuple):
    """The forced response to harmonics k = 1, 2, …, per harmonic.

    Parameters
    ----------
    k, p
        Number and complex amplitude of each harmonic of the load; shape (K,).
    rigid_velocity
        That of the rigid motion; shape (K,).
    gains
        Motion of the elastic modes 1 … N per amplitude; shape (N, K).
    driven
        Elastic motion of the place where the load acts per amplitude; shape (K,).
    """

    k: Array
    p: ComplexArray
    rigid_velocity: ComplexArray
    gains: ComplexArray
    driven: ComplexArray


class Balanced(Protocol):
    """What the energy balance needs of a motion; `percuss.steady.orbit.Motion` has it."""

    @property
    def system(self) -> System: ...
    @property
    def periods(self) -> int: ...
    @property
    def period(self) -> float: ...
    @property
    def phase(self) -> float: ...
    @property
    def cut(self) -> bool: ...
    @property
    def modes(self) -> int: ...
    @property
    def state(self) -> ModalState: ...
    @property
    def rigid_velocity(self) -> float: ...
    def rigid_motion(self, t: Array) -> tuple[Array, Array]: ...
    def transient(self, t: Array) -> tuple[Array, Array]: ...


def harmonic_exchange(motion: Balanced, waves: Waves) -> tuple[float, float]:
    """Energy put in by harmonics, and taken by the damping."""
    rigid, elastic = _rigid_harmonic(motion, waves), _elastic_harmonic(motion, waves)
    return rigid[0] + elastic[0], rigid[1] + elastic[1]


def _rigid_harmonic(motion: Balanced, waves: Waves) -> tuple[float, float]:
    d, p0, period = motion.system.d, motion.system.push, motion.period
    k, p, v = waves.k, waves.p, waves.rigid_velocity
    if not motion.system.body.is_free:
        return 0.0, 0.0
    turn = np.exp(1j * k * motion.phase)
    v_phi = float((v * turn).real.sum())
    start = motion.system.contact.velocity_factor * motion.rigid_velocity - v_phi
    once, twice = period * float(phi1(d * period)), period**2 * float(phi2(d * period))
    fade = once / (d - 1j * k) * (d * start - p0)  # ∮ exp(ikt) r(t) dt
    half_turns = 0.5 * period
    put_in = half_turns * float((np.conj(p) * v).real.sum()) + float((p * turn * fade).real.sum())
    put_in += p0 * float(motion.rigid_motion(np.array([period]))[0][0])
    end = p0 * once + start * math.exp(-d * period)
    free = p0 * (p0 * twice + start * once) - 0.5 * (end**2 - start**2)
    damped = d * half_turns * float(np.sum(np.abs(v) ** 2)) + 2.0 * d * float((v * turn * fade).real.sum())
    return put_in, damped + free if d > 0.0 else 0.0


def _elastic_harmonic(motion: Balanced, waves: Waves) -> tuple[float, float]:
    k, p, gain, state, system = waves.k, waves.p, waves.gains, motion.state, motion.system
    modes = system.body.modes(state.omega.size, system.load.at)
    square, weight = state.omega**2, modes.weight
    end, end_velocity = (a[:, 0] for a in motion.transient(np.array([motion.period])))
    jump, jump_velocity = end - state.z, end_velocity - state.z_velocity
    turned = p * np.exp(1j * k * motion.phase)
    work = np.conj(gain) * (square[:, None] * jump[:, None] + 1j * k * jump_velocity[:, None])  # ∮ exp(ikt) z'(t) dt
    put_in = float(weight @ ((work @ turned).real + system.load.mean * jump))
    free = 0.5 * (state.z_velocity**2 - end_velocity**2 + square * (state.z**2 - end**2))
    cross = 2.0 * modes.damping * ((gain * work) @ (1j * k * turned)).real
    damped = float(weight @ np.where(modes.damping > 0.0, free + cross, 0.0))
    forced = float(np.sum(0.5 * motion.period * np.abs(p) ** 2 * (1j * k * waves.driven).real))
    return put_in + forced, damped + forced if np.any(modes.damping) else 0.0


def piecewise_exchange(
    motion: Balanced, starts: Array, modal: Callable[[int, Array], tuple[Array, Array]]
) -> tuple[float, float]:
    """Energy put in by steps that begin at `starts`, and taken by the damping; `modal` gives (f_n, f_n') of the modes.

    Between its breaks a piecewise load is constant: every mode is a free oscillator about its static place.
    """
    ahead = np.mod(starts[None, :] - motion.phase, 2.0 * math.pi)
    ahead = (ahead + 2.0 * math.pi * np.arange(motion.periods)[:, None]).reshape(-1)
    knots = np.unique(np.concatenate([[0.0], ahead, [motion.period]]))
    knots = knots[np.append(True, np.diff(knots) > 1e-13)]
    knots[-1] = motion.period
    system, lengths = motion.system, np.diff(knots)
    force = system.load.value(motion.phase + 0.5 * (knots[1:] + knots[:-1]))
    u, v = motion.rigid_motion(knots)
    put_in = float(force @ np.diff(u))
    damped = put_in - 0.5 * float(v[-1] ** 2 - v[0] ** 2) if system.d > 0.0 else 0.0
    f, f_velocity = modal(motion.modes, motion.phase + knots)
    f[:, -1], f_velocity[:, -1] = f[:, 0], f_velocity[:, 0]  # a whole number of turns, to the last digit
    z, z_velocity = motion.transient(knots)
    w, w_velocity = f + z, f_velocity + z_velocity
    modes = system.body.modes(motion.modes, system.load.at)
    omega, damping = modes.omega[:, None], modes.damping[:, None]
    put_in += float(modes.weight @ (np.diff(w, axis=1) @ force))
    away = w[:, :-1] - force[None, :] / omega**2
    lost = dissipated(omega, damping, (away, w_velocity[:, :-1]), lengths[None, :])
    return put_in, damped + float(modes.weight @ lost.sum(axis=1))


# ---- Forced response to a load given by harmonics: sums over all modes as the body has them (theory §4)

_AT_ONCE = 1 << 20  # harmonics × times
_KEPT_GAINS = 1 << 14  # numbers, modes × harmonics, of the tables that are kept
_LARGEST_MATRIX = 1 << 21  # harmonics × modes of one probe
_FEWEST, _MOST = 1024, 65536  # modes of a probe


class Field(NamedTuple):
    """Displacement, velocity and strain; equal shapes, dimensionless."""

    displacement: Array
    velocity: Array
    strain: Array


class HarmonicResponse:
    """Periodic motion of the bar under its harmonics p_k, without rigid drift; a `Response`.

    Parameters
    ----------
    system
        Only the body and the coefficients of the load are used, also when the load is piecewise.

    Raises
    ------
    ResonanceError
        When an undamped bar is driven at one of its own frequencies (B77 16).
    """

    is_smooth = True

    def __init__(self, system: System) -> None:
        self.system = system
        self.k = system.load.harmonics.astype(float)
        self.p: ComplexArray = system.load.coefficients[system.load.harmonics]
        free = 1.0 if system.body.is_free else 0.0  # else there is no rigid motion
        self.rigid_factor: ComplexArray = free * self.p / (system.d + 1j * self.k)
        self._end: dict[int | None, tuple[ComplexArray, ComplexArray]] = {}
        refuse_resonance(system)

    @property
    def by_harmonics(self) -> HarmonicResponse:
        """Itself."""
        return self

    # -- rigid part --

    def rigid_velocity(self, theta: Array) -> Array:
        """v_f(θ), the periodic rigid velocity (theory §4); shape of `theta`."""
        return self._waves(theta, self.rigid_factor)

    def rigid_acceleration(self, theta: Array) -> Array:
        """v_f'(θ)."""
        return self._waves(theta, 1j * self.k * self.rigid_factor)

    def rigid_displacement(self, theta: Array) -> Array:
        """The periodic antiderivative of v_f with mean zero."""
        return self._waves(theta, self.rigid_factor / (1j * self.k))

    def rigid_bounds(self) -> tuple[float, float]:
        """Bounds of |v_f| and of the alternating force."""
        if not self.system.body.is_free:
            return 0.0, 0.0
        return float(np.abs(self.rigid_factor).sum()), float(np.abs(self.p).sum())

    def force(self, theta: Array) -> Array:
        """p(θ) with its mean."""
        return self.system.load.mean + self._waves(theta, self.p)

    # -- where it meets a level --

    @cached_property
    def ends(self) -> Array:
        """The critical points of v_f, increasing."""
        return turns_of_waves(self.k, self.rigid_factor)

    @property
    def flat(self) -> npt.NDArray[np.bool_]:
        """A sum of waves is flat nowhere."""
        return np.zeros(self.ends.shape, dtype=bool)

    def turning(self, velocities: Array) -> npt.NDArray[np.bool_]:
        """All critical points count."""
        return np.ones(velocities.shape, dtype=bool)

    def phases_at(
        self, ends: Array, velocities: Array, arc: npt.NDArray[np.intp], level: Array, plain: bool = False
    ) -> Array:
        """The phase on each arc where v_f equals a level between its ends."""
        return phases_of_waves(self.k, self.rigid_factor, ends, velocities, arc, level, plain)

    def slope_on(self, arc: int, theta: Array) -> Array:
        """v_f'(θ), the same on every arc."""
        return self.rigid_acceleration(theta)

    def plateau(self, phase: float) -> tuple[float, float] | None:
        """None."""
        return None

    # -- elastic part --

    def shapes(self, x: Array, modes: int | None = None) -> tuple[ComplexArray, ComplexArray]:
        """g_k(x), the motion per harmonic of the load, and its slope, of all modes or the first; shapes (K, len(x))."""
        found = self.system.body.receptance(self.k, x, self.system.load.at, modes)
        return found.displacement, found.strain

    def end_shape(self, modes: int | None = None) -> ComplexArray:
        """g_k(1) of all modes, or of the first ones; shape (K,). Not to be written into."""
        if modes is None:
            return _end_shape(self.system.body, self.system.load.at, self.k.tobytes())
        return self.system.body.modes(modes, self.system.load.at).gamma @ self.gains(modes)

    def driven_shape(self) -> ComplexArray:
        """The motion of the place where the load acts, per harmonic, of all modes; shape (K,)."""
        body, at = self.system.body, self.system.load.at
        return self.shapes(np.array([body.place(at)]))[0][:, 0]

    def gains(self, modes: int) -> ComplexArray:
        """1/(ω_n² + ik d_n − k²) of the modes n = 1 … `modes`; shape (modes, K). Not to be written into."""
        made = _known_gains if modes * self.k.size <= _KEPT_GAINS else _gains
        return made(self.system.body, self.k.tobytes(), modes)

    def elastic(self, x: Array, theta: Array, modes: int = 0, *, cut: bool = False) -> Field:
        """Elastic part of the forced motion, with the static shape of the mean; shapes (len(x), len(θ)).

        All modes, or if `cut` the first `modes`.
        """
        kept = modes if cut else None
        shape, slope = self.shapes(x, kept)
        waves = self.p[:, None] * np.exp(1j * np.outer(self.k, theta))
        rise, bend = self.system.body.static(np.asarray(x, dtype=float), self.system.load.at, kept)
        mean = self.system.load.mean
        return Field(
            (shape.T @ waves).real + mean * rise[:, None],
            ((shape * (1j * self.k)[:, None]).T @ waves).real,
            (slope.T @ waves).real + mean * bend[:, None],
        )

    def end_motion(self, theta: Array, modes: int = 0, *, cut: bool = False) -> tuple[Array, Array]:
        """Forced displacement (but for a constant) and velocity of the striking end, rigid part and elastic part."""
        both, size = np.empty((theta.size, 2)), max(1, _AT_ONCE // self.k.size)
        multiplied = self._at_end(modes if cut else None)[0]
        for i in range(0, theta.size, size):  # else a thousand harmonics at all times would fill the memory
            look()
            waves = np.exp(1j * np.outer(theta[i : i + size], self.k))
            both[i : i + size] = (waves @ multiplied).real
        return both[:, 0], both[:, 1]

    def end_velocity(self, theta: float, modes: int = 0, *, cut: bool = False) -> float:
        """Elastic part of the forced velocity of the striking end at one load phase; all modes, or the first ones."""
        return float((np.exp(1j * theta * self.k) @ self._at_end(modes if cut else None)[1]).real)

    def end_rates(self, modes: int = 0, *, cut: bool = False) -> tuple[float, float]:
        """Bounds of the second and third derivative of the striking end's forced elastic motion."""
        shapes, forced = np.abs(self.end_shape(modes if cut else None)), self.k**2 * np.abs(self.p)
        slope = float((self.k * np.abs(self.p)).sum())
        return float(forced @ shapes), float((self.k * forced) @ shapes) + slope

    def _at_end(self, modes: int | None) -> tuple[ComplexArray, ComplexArray]:
        """What multiplies exp(ikθ) there: in displacement and velocity, shape (K, 2); in elastic velocity, (K,)."""
        if modes not in self._end:
            elastic = self.p * self.end_shape(modes)
            whole = elastic + self.rigid_factor / (1j * self.k)
            self._end[modes] = np.stack([whole, 1j * self.k * whole], axis=1), 1j * self.k * elastic
        return self._end[modes]

    # -- one mode at a time --

    def modal(self, modes: int, theta: Array) -> tuple[Array, Array]:
        """(f_n, f_n') of the elastic modes n = 1 … `modes`, each of shape (modes, len(θ))."""
        gain = self.gains(modes)
        waves = self.p[:, None] * np.exp(1j * np.outer(self.k, theta))
        mean = self.system.load.mean / self.system.body.modes(modes).omega ** 2
        return (gain @ waves).real + mean[:, None], ((gain * (1j * self.k)) @ waves).real

    def modal_apart(self, modes: int, theta: Array) -> tuple[Array, Array]:
        """As `modal`, term by term in real numbers: the same bits for a phase alone and in a row.

        A matrix product does not give them, nor is it faster for a load of few harmonics at many phases.
        """
        gain = self.gains(modes)
        waves = self.p[:, None] * np.exp(1j * np.outer(self.k, theta))
        both = np.stack([waves, 1j * self.k[:, None] * waves], axis=1)  # displacement and velocity; (K, 2, len(θ))
        total = np.zeros((2, modes, waves.shape[1]))
        total[0] = (self.system.load.mean / self.system.body.modes(modes).omega ** 2)[:, None]
        for column, pair in zip(gain.T, both, strict=True):
            total += column.real[:, None] * pair.real[:, None, :]
            total -= column.imag[:, None] * pair.imag[:, None, :]
        return total[0], total[1]

    def modal_bounds(self, modes: int) -> tuple[Array, Array]:
        """Bounds over all phases of |f_n| and of |f_n'|; each of shape (modes,)."""
        gain, size = np.abs(self.gains(modes)), np.abs(self.p)
        still = abs(self.system.load.mean) / self.system.body.modes(modes).omega ** 2
        return still + gain @ size, gain @ (self.k * size)

    def displacement_tail(self, omega: float) -> float:
        """P with |f_n| ≤ P/ω_n² for every mode with ω_n ≥ `omega`; inf when that is too low."""
        room = 1.0 - float(np.abs(self.k * (self.k - 1j * self.system.d)).max()) / omega**2
        greatest = abs(self.system.load.mean) + float(np.abs(self.p).sum())
        return greatest / room if room > 0.0 else math.inf

    def modal_velocity_bound(self, theta: float, omega: float, damping: float) -> float:
        """P such that |f_n'(θ)| ≤ P/ω_n² for every mode with ω_n ≥ `omega`; inf when `omega` is too low for one.

        f_n' = p'/ω² + Re Σ ik p_k exp(ikθ) (k² − ikd) H_nk/ω², where d_n grows no faster than ω_n² from `damping` on.
        """
        shift = np.abs(self.k * (self.k - 1j * damping))
        room = omega**2 - shift
        if np.any(room <= 0.0):
            return math.inf
        slope = abs(float((1j * self.k * self.p * np.exp(1j * self.k * theta)).real.sum()))
        return slope + float(np.sum(self.k * np.abs(self.p) * shift / room))

    def ringing(self, modes: int) -> Array:
        """Nothing rings."""
        return np.zeros(modes)

    @property
    def most_modes(self) -> int:
        """As many as make a matrix of a bearable size."""
        return max(_FEWEST, min(_MOST, _LARGEST_MATRIX // max(1, self.k.size)))

    def exchange(self, motion: Balanced) -> tuple[float, float]:
        """Energy put in by the load and taken by the damping over an impact period of a motion."""
        kept = motion.state.omega.size
        gains, weight = self.gains(kept), self.system.body.modes(kept, self.system.load.at).weight
        driven = weight @ gains if motion.cut else self.driven_shape()
        return harmonic_exchange(motion, Waves(self.k, self.p, self.rigid_factor, gains, driven))

    def _waves(self, theta: Array, factor: ComplexArray) -> Array:
        theta = np.asarray(theta, dtype=float)
        flat = np.exp(1j * np.outer(theta.reshape(-1), self.k)) @ factor
        return np.asarray(flat.real.reshape(theta.shape))


@lru_cache(maxsize=32)
def _end_shape(body: Body, at: int, k: bytes) -> ComplexArray:
    """g_k(1), which stays while R and the load's strength are moved; shape (K,)."""
    found = body.receptance(np.frombuffer(k), np.array([1.0]), at).displacement[:, 0]
    found.setflags(write=False)
    return found


def _gains(body: Body, k: bytes, modes: int) -> ComplexArray:
    found = np.asarray(1.0 / body.modes(modes).stiffness(np.frombuffer(k)), dtype=complex)
    found.setflags(write=False)
    return found


_known_gains = lru_cache(maxsize=16)(_gains)  # the same for every mean load, phase and contact law


# ---- What a forced response answers, whatever form the load has: the questions that steady motions ask of one


class Response(Protocol):
    """Periodic motion of the bar under its load, without rigid drift.

    Where a response is asked for `modes`, these are the modes of those of its sums that have no closed form; `cut`
    ends the others there too.
    """

    system: System

    @property
    def is_smooth(self) -> bool:
        """Whether its modes fall off so fast, like 1/n³, that nothing rings: the load does not jump."""
        ...

    @property
    def by_harmonics(self) -> HarmonicResponse:
        """The response to the harmonics that the load keeps; itself when there is nothing else."""
        ...

    def __hash__(self) -> int: ...

    # -- rigid part --

    def rigid_velocity(self, theta: Array) -> Array:
        """v_f(θ) (theory §4); shape of `theta`."""
        ...

    def rigid_bounds(self) -> tuple[float, float]:
        """Bounds of |v_f| and of the alternating force."""
        ...

    def rigid_acceleration(self, theta: Array) -> Array:
        """v_f'(θ), right-sided at a jump."""
        ...

    def slope_on(self, arc: int, theta: Array) -> Array:
        """v_f'(θ) on arc number `arc`, at its ends too; shape of `theta`."""
        ...

    def rigid_displacement(self, theta: Array) -> Array:
        """The periodic antiderivative of v_f with mean zero."""
        ...

    def force(self, theta: Array) -> Array:
        """p(θ) with its mean, right-sided at a jump."""
        ...

    def plateau(self, phase: float) -> tuple[float, float] | None:
        """First and last phase of the arc around `phase` if v_f is flat there, or None."""
        ...

    # -- where v_f meets a level --

    @property
    def ends(self) -> Array:
        """The phases in [0, 2π), increasing, between which v_f is monotone."""
        ...

    @property
    def flat(self) -> npt.NDArray[np.bool_]:
        """On which of the arcs that begin there v_f does not change but for rounding; shape of `ends`."""
        ...

    def turning(self, velocities: Array) -> npt.NDArray[np.bool_]:
        """At which ends v_f turns round, from v_f at the ends and a turn later at the first one; that shape."""
        ...

    def phases_at(
        self, ends: Array, velocities: Array, arc: npt.NDArray[np.intp], level: Array, plain: bool = False
    ) -> Array:
        """The phase on each arc where v_f equals a level between its ends, for `percuss.steady.phases.Arcs`.

        With `plain` in plain numbers where those are faster, which round otherwise than rows of them.
        """
        ...

    # -- elastic part --

    def elastic(self, x: Array, theta: Array, modes: int, *, cut: bool = False) -> Field:
        """Elastic part of the forced motion, with the static shape of the mean; shapes (len(x), len(θ))."""
        ...

    def end_motion(self, theta: Array, modes: int, *, cut: bool = False) -> tuple[Array, Array]:
        """Forced displacement (but for a constant) and velocity of the striking end, rigid part and elastic part."""
        ...

    def end_velocity(self, theta: float, modes: int, *, cut: bool = False) -> float:
        """Elastic part of the forced velocity of the striking end at one load phase."""
        ...

    def end_rates(self, modes: int, *, cut: bool = False) -> tuple[float, float]:
        """Bounds of the second and third derivative of the striking end's forced elastic motion that is no ringing."""
        ...

    # -- mode by mode --

    def modal(self, modes: int, theta: Array) -> tuple[Array, Array]:
        """(f_n, f_n') of the elastic modes n = 1 … `modes`, each of shape (modes, len(θ))."""
        ...

    def modal_apart(self, modes: int, theta: Array) -> tuple[Array, Array]:
        """As `modal`, with the same bits for a phase alone and in a row."""
        ...

    def modal_bounds(self, modes: int) -> tuple[Array, Array]:
        """Bounds over all phases of |f_n|, but for what rings, and of |f_n'|; each of shape (modes,)."""
        ...

    def displacement_tail(self, omega: float) -> float:
        """P with |f_n| ≤ P/ω_n², but for what rings, for every mode with ω_n ≥ `omega`; inf when that is too low."""
        ...

    def modal_velocity_bound(self, theta: float, omega: float, damping: float) -> float:
        """P with |f_n'(θ)| ≤ P/ω_n² for every mode with ω_n ≥ `omega`, d_n ≥ `damping`; inf for none."""
        ...

    def ringing(self, modes: int) -> Array:
        """Greatest amplitudes of free motion in the forced response, after the jumps of the load; shape (modes,)."""
        ...

    @property
    def most_modes(self) -> int:
        """So many modes are looked at when it is decided how many to keep."""
        ...

    def exchange(self, motion: Balanced) -> tuple[float, float]:
        """Energy put in by the load and taken by the damping over an impact period of a motion (theory §4)."""
        ...
