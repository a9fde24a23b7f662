"""All phases at which the rigid velocity meets a level, and the proof that there are no others.

The critical points of v_f cut the circle into arcs on which v_f is monotone, so that each arc holds at most one root,
and holds one exactly when the level lies between the values at its ends. The critical points themselves are roots of a
sum of waves, found with proof (`percuss.steady.trigonometric`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property, lru_cache, partial

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.mechanics.flow import phi1, propagator
from percuss.model import System
from percuss.model.body import need_free
from percuss.model.checks import Array, count, instance, non_negative, numbers, positive
from percuss.model.contact import impedance_ratio, restitutions
from percuss.steady.forced import PiecewiseResponse, Response, forced_response
from percuss.steady.oscillator import modal_state
from percuss.steady.trigonometric import TURN, bounded_roots, on_circle

RELEASED_MODES = 512  # modes of the sums where an impact changes the strain: more of them hardly help

_EPS = np.finfo(float).eps


@dataclass(frozen=True)
class Arcs:
    """The arcs of the circle on which v_f is monotone: their n + 1 increasing ends, and v_f there."""

    ends: Array
    velocities: Array
    response: Response

    @staticmethod
    @lru_cache(maxsize=32)
    def of(response: Response) -> Arcs:
        """Cut the circle at the critical points (or kinks) of the rigid velocity; the last few are kept."""
        ends = response.ends
        ends = np.append(ends, ends[0] + TURN)
        return Arcs(ends, response.rigid_velocity(np.append(ends[:-1], ends[0])), response)

    @property
    def highest(self) -> float:
        """max v_f."""
        return float(self.velocities.max())

    @property
    def tolerance(self) -> float:
        """Differences of v_f below this are rounding."""
        return 32.0 * _EPS * self.response.rigid_bounds()[0]

    @cached_property
    def turning(self) -> npt.NDArray[np.bool_]:
        """At which ends v_f turns round, (n + 1,): critical points, breaks whose kink is one; two motions meet."""
        return self.response.turning(self.velocities)

    def plateaus(self, level: float) -> npt.NDArray[np.intp]:
        """The arcs on which v_f stays at a level: every phase of theirs is a root."""
        return np.flatnonzero(self.response.flat & (np.abs(self.velocities[:-1] - level) <= self.tolerance))

    def folded(self, phase: Array, level: Array) -> npt.NDArray[np.bool_]:
        """Whether two motions meet in a root: the level touches an end of its arc, where v_f turns round."""
        arc = (np.searchsorted(self.ends[:-1], phase, side="right") - 1) % (self.ends.size - 1)
        folded = np.zeros(np.shape(phase), dtype=bool)
        for end in (arc, arc + 1):
            folded |= self.turning[end] & (np.abs(self.velocities[end] - level) <= self.tolerance)
        return folded

    def roots(self, level: float) -> tuple[Array, Array]:
        """All phases in [0, 2π) with v_f = level, increasing, and whether each is a fold, as a plateau's middle is."""
        off = self.velocities - level
        touching = np.abs(off) <= self.tolerance
        knots, folded = self.ends[:-1][touching[:-1]], self.turning[:-1][touching[:-1]]
        flat = self.plateaus(level)
        if flat.size:  # the breaks that bound it belong to it
            beside = np.isin(np.flatnonzero(touching[:-1]), np.concatenate([flat, (flat + 1) % (self.ends.size - 1)]))
            middles = 0.5 * (self.ends[flat] + self.ends[flat + 1])
            knots, folded = np.append(knots[~beside], middles), np.append(folded[~beside], np.ones(flat.size, bool))
        crossed = ((off[:-1] < 0.0) != (off[1:] < 0.0)) & ~touching[:-1] & ~touching[1:]
        index = np.flatnonzero(crossed)
        simple = self._few(index, np.full(index.size, level))
        phases = on_circle(np.concatenate([simple, knots]))
        tangent = np.concatenate([np.zeros(simple.size, bool), folded])
        order = np.argsort(phases)
        return phases[order], tangent[order]

    def phase_on(self, arc: int, level: float) -> float:
        """The phase on one arc where v_f equals one level: `invert` for plain numbers."""
        return float(self._few(np.array([arc]), np.array([level]))[0])

    def _few(self, arc: npt.NDArray[np.intp], level: Array) -> Array:
        return self.response.phases_at(self.ends, self.velocities, arc, level, plain=True)

    def invert(self, arc: npt.NDArray[np.intp], level: Array) -> Array:
        """The phase on arc number `arc` where v_f equals `level`, which must lie between its ends; broadcasts."""
        return self.response.phases_at(self.ends, self.velocities, arc, level)


# ---- The level that the rigid velocity must meet at an impact: the right-hand side of B77 (14)

_SERIES = (1 / 3, -1 / 45, 2 / 945, -1 / 4725, 2 / 93555, -1382 / 638512875, 4 / 18243225, -3617 / 162820783125)
_SMALL = 0.2  # the series with 8 terms is right to 1e-17 relative below this


def langevin(x: npt.ArrayLike) -> Array:
    """coth x − 1/x for x ≥ 0, right to full relative precision down to x = 0, where it is 0."""
    x = np.asarray(x, dtype=float)
    small = x < _SMALL
    y = np.where(small, x, 0.0)
    series = np.zeros_like(y)
    for coefficient in reversed(_SERIES):
        series = coefficient + y**2 * series
    safe = np.where(small, 1.0, x)
    return np.asarray(np.where(small, y * series, 1.0 / np.tanh(safe) - 1.0 / safe))


def level_factor(damping: npt.ArrayLike, ratio: npt.ArrayLike) -> Array:
    """c/(p_0 T): [coth(dT/2) − 2/(dT)]/2 + (1 − R)/(2(1 + R)), both terms positive, so that no digit is lost."""
    return 0.5 * langevin(0.5 * np.asarray(damping, dtype=float)) + 0.5 * np.asarray(ratio, dtype=float)


def level(mean: npt.ArrayLike, d: float, restitution: npt.ArrayLike, period: float) -> Array:
    """c(d, R) of B77 (14) for mean load p_0 and impact period T (all dimensionless); broadcasts over p_0 and R."""
    mean, restitution = numbers("mean", mean), restitutions(restitution)
    try:
        return level_at(mean, non_negative("d", d), impedance_ratio(restitution), positive("period", period))
    except ValueError as error:
        if isinstance(error, ParameterError):
            raise
        raise ParameterError("mean", f"shape {mean.shape}", "numbers in a shape that fits the restitution's") from None


def level_at(mean: npt.ArrayLike, d: float, ratio: npt.ArrayLike, period: float) -> Array:
    """`level` of numbers that have been looked at, for any law, by its `Contact.impedance_ratio`."""
    return np.asarray(mean, dtype=float) * period * level_factor(d * period, ratio)  # B77 (14)


def level_of(system: System, period: float) -> float:
    """c of a system with impacts every T = `period`."""
    need_free(system.body, "the level of B77 (14)")
    return float(level_at(system.load.mean, system.d, system.contact.impedance_ratio, period))


def ratio_at(mean: float, d: float, height: Array, period: float) -> Array:
    """The impedance ratio at which the level has this height, `level_at` backwards; shape of `height`."""
    return np.asarray(2.0 * height / (mean * period) - float(langevin(np.array(0.5 * d * period))))


# ---- Which load phases are impact phases: the roots of v_f = c (B77 14), for every contact law
#
# Over an impact period the bar as a whole comes back to where it was just after the impact. A law that changes the
# strain moves it there by a = Σ γ_n (u_n⁺ − u_n⁻), as the striking end stays at the wall, so that (14) becomes
#
#     v_f(φ) + a(φ) [d/(1 − e^{−dT}) − dR/(1 + R)] = c
#
# where a is linear in the load: under harmonics the left side is a sum of waves again, and all of its roots are found.
# Its size is that of the elastic motion over the rigid one, 1/s².

_STEPS = 60
_ROUNDING = float(np.finfo(float).eps)


@dataclass(frozen=True)
class PhaseCondition:
    """The curve that meets a level at the impact phases: c less what the mean adds, and `still` to its value."""

    arcs: Arcs
    level: float
    still: float = 0.0

    @property
    def highest(self) -> float:
        """Its greatest value: no motion exists beyond."""
        return self.arcs.highest + self.still

    def value(self, phases: Array) -> Array:
        """The curve; shape of `phases`."""
        return np.asarray(self.arcs.response.rigid_velocity(phases) + self.still)

    def roots(self) -> tuple[Array, Array]:
        """All impact phases, increasing, and whether each is a fold."""
        return self.arcs.roots(self.level)


@dataclass(frozen=True)
class _Polished(PhaseCondition):
    """The roots of B77 (14), each followed to the phase that a law which changes the strain asks for."""

    system: System = field(kw_only=True)
    period: float = field(kw_only=True)
    modes: int = field(kw_only=True)

    def roots(self) -> tuple[Array, Array]:
        phases, folds = self.arcs.roots(self.level)
        found = np.array([self._followed(float(phase)) for phase in phases], dtype=float)
        kept = np.isfinite(found)
        order = np.argsort(found[kept])
        return on_circle(found[kept])[order], folds[kept][order]

    def _off(self, phase: float) -> float:
        here = np.array([phase])
        moved = _rebasing(self.system, self.period, self.modes, phase)
        velocity = float(self.arcs.response.rigid_velocity(here)[0])
        return velocity - self.level + moved * _weight(self.system, self.period)

    def _followed(self, phase: float) -> float:
        """By the secant method; NaN where it leads nowhere, as beside a fold."""
        before, off_before = phase, self._off(phase)
        slope = float(np.asarray(forced_response(self.system).rigid_acceleration(np.array([phase])))[0])
        if off_before == 0.0 or slope == 0.0:
            return phase if off_before == 0.0 else math.nan
        now = phase - off_before / slope
        noise = 64.0 * _ROUNDING * (abs(self.level) + self.arcs.response.rigid_bounds()[0])
        for _ in range(_STEPS):
            off = self._off(now)
            if abs(off) <= noise or off == off_before:
                return now if abs(off) <= 1e3 * noise else math.nan
            before, now, off_before = now, now - off * (now - before) / (off - off_before), off
            if not abs(now - phase) < math.pi:
                return math.nan
        return math.nan


def phase_condition(system: System, periods: int, modes: int | None = None) -> PhaseCondition:
    """The condition for impacts once in `periods` load periods, of the bar with `modes` modes or with all of them."""
    period = 2.0 * math.pi * periods
    response = forced_response(system)
    level = level_of(system, period)
    n = RELEASED_MODES if modes is None else modes
    if system.contact.keeps_strain or n == 0:
        return PhaseCondition(Arcs.of(response), level)
    if not response.is_smooth:
        return _Polished(Arcs.of(response), level, system=system, period=period, modes=n)
    curve, raised = _rebased(system, period, n)
    return PhaseCondition(Arcs.of(curve), level - raised)


@lru_cache(maxsize=32)
def _rebased(system: System, period: float, modes: int) -> tuple[Response, float]:
    """The curve under harmonics, and what the mean load adds to it."""
    response = forced_response(system).by_harmonics
    gain, k = response.gains(modes), response.k
    change = system.contact.strain_factor - 1.0
    gamma = system.body.modes(modes, system.load.at).gamma
    # the displacement before the impact per unit of forced displacement, and of forced velocity
    nothing, one = np.zeros(modes), np.ones(modes)
    still = gamma * modal_state(system, period, (one, nothing)).displacement
    moving = gamma * modal_state(system, period, (nothing, one)).displacement
    each = change * _weight(system, period) * (still @ gain + 1j * k * (moving @ gain))
    raised = change * _weight(system, period) * float(still @ (1.0 / system.body.modes(modes).omega ** 2))
    return response.meeting(response.rigid_factor + each * response.p), raised * system.load.mean


def _rebasing(system: System, period: float, modes: int, phase: float) -> float:
    """a(φ), of so many modes."""
    f, velocity = forced_response(system).modal(modes, np.array([phase]))
    state = modal_state(system, period, (f[:, 0], velocity[:, 0]))
    change = system.contact.strain_factor - 1.0
    return change * float(system.body.modes(modes, system.load.at).gamma @ state.displacement)


def _weight(system: System, period: float) -> float:
    """What a unit of a adds to v_f in (14): 1/T without damping."""
    d, contact = system.d, system.contact
    return 1.0 / (period * float(phi1(d * period))) + d * contact.velocity_factor / contact.impulse


# ---- Which load phases are impact phases of a body that is held: the contact reaches the wall there
#
# For impacts every T = 2πm at the phase φ the modes have one state each, and the contact is at
#
#     y(φ) = Σ γ_n [f_n(φ) − (1 + R) c_n f_n'(φ)],    c_n = [(I − DΦ_n(T))⁻¹]_12,
#
# just before an impact; y(φ) = g then says when. Under harmonics this is a sum of waves with those of the load, all of
# whose roots are found, as for the single oscillators of Shaw & Holmes (J. Sound Vib. 90 (1983) 129–155) and of Budd &
# Dux (Phil. Trans. R. Soc. A 347 (1994) 365–389), which it is for one mode. Under steps it is smooth on each of them,
# and bounds of its derivatives leave no root out.

FREE_AMPLITUDE = (
    "a mode comes back by itself after every impact period, so that its amplitude is free (internal resonance): give "
    "it some damping"
)
_NARROWEST = 1e-9  # rad: roots within four times this are one, double
_TOUCH = 1e-13


@lru_cache(maxsize=16)
def gap_condition(system: System, periods: int, modes: int) -> PhaseCondition | SteppedGap | None:
    """The condition for impacts once in `periods` load periods; None in internal resonance."""
    period, response = 2.0 * math.pi * periods, forced_response(system)
    nothing, one = np.zeros(modes), np.ones(modes)
    answer = modal_state(system, period, (nothing, one))
    gamma = system.body.modes(modes, system.load.at).gamma
    if np.any((answer.velocity == 0.0) & (gamma != 0.0)):  # so it is told by `modal_state`
        return None
    moving = gamma * answer.displacement  # γ_n times −(1 + R) c_n
    if isinstance(response, PiecewiseResponse):
        return SteppedGap(response, gamma, moving)
    harmonics = response.by_harmonics
    gains, k = harmonics.gains(modes), harmonics.k
    still = system.load.mean * float(gamma @ (1.0 / answer.omega**2))
    waves = (gamma @ gains + 1j * k * (moving @ gains)) * harmonics.p
    return PhaseCondition(Arcs.of(harmonics.meeting(np.asarray(waves))), system.body.gap - still, still)


@dataclass(frozen=True)
class SteppedGap:
    """The curve under steps: modes that swing about a constant place on each of them."""

    response: PiecewiseResponse
    gamma: Array
    moving: Array

    @property
    def level(self) -> float:
        """The gap."""
        return self.response.system.body.gap

    @property
    def highest(self) -> float:
        """Of 4096 samples."""
        return float(self.value(np.linspace(0.0, 2.0 * math.pi, 4096, endpoint=False)).max())

    def value(self, phases: Array) -> Array:
        f, rate = self.response.modal(self.gamma.size, phases)
        return np.asarray((self.gamma @ f + self.moving @ rate).reshape(np.shape(phases)))

    def roots(self) -> tuple[Array, Array]:
        """All impact phases, increasing, and whether each is a fold: where roots cannot be told apart, or a touch."""
        response, system, n = self.response, self.response.system, self.gamma.size
        known, gamma, moving = system.body.modes(n, system.load.at), np.abs(self.gamma), np.abs(self.moving)
        rise, both = known.omega**2 + known.damping * known.omega, known.omega + known.damping
        phases, folds = [], []
        for i, (start, length) in enumerate(zip(response.starts, response.lengths.tolist(), strict=True)):
            u, v = (row[i] for row in response.knots(n))
            size = np.hypot(u, v / known.omega)  # never grows
            bend = float(np.sum(size * rise * (gamma + moving * both)))
            scale = float(np.sum(size * (gamma + moving * known.omega))) + abs(system.body.gap)
            roots, touches = bounded_roots(partial(self._at, i), length, 64, bend, _TOUCH * scale)
            found = np.sort(np.concatenate([roots, touches]))
            groups = np.split(found, np.flatnonzero(np.diff(found) > 4.0 * _NARROWEST) + 1) if found.size else []
            phases += [float(start + group.mean()) for group in groups]
            folds += [group.size > 1 or group[0] in touches for group in groups]
        order = np.argsort(turned := on_circle(np.array(phases)))
        return turned[order], np.array(folds, dtype=bool)[order]

    def _at(self, i: int, since: Array) -> tuple[Array, Array]:
        """y − g and its derivative on a step, so long after its beginning."""
        n, system = self.gamma.size, self.response.system
        known = system.body.modes(n, system.load.at)
        omega, d = known.omega[:, None], known.damping[:, None]
        step = propagator(omega, d, since[None, :])
        u, v = (row[i][:, None] for row in self.response.knots(n))
        away, rate = step.a * u + step.b * v, step.c * u + step.e * v
        place = away + float(self.response.values[i]) / omega**2
        turn = -d * rate - omega**2 * away
        return self.gamma @ place + self.moving @ rate - system.body.gap, self.gamma @ rate + self.moving @ turn


# ---- R = 1 and no damping: the motions under which the elastic modes would gain energy at every impact (theory §4)
#
# Nothing takes energy then, so that a mode can only be periodic when its forced velocity f_n' vanishes at the impact.
# The exception is a mode that swings a whole number of times between two impacts, ω_n T/(2π) = nπsm whole: it comes
# back by itself, with any f_n'. With c_k = Re[ik p_k exp(ikφ)] the forced velocity is f_n' = Σ c_k/(ω_n² − k²), and for
# the continuous bar under finitely many harmonics all of them vanish only if every c_k does: when the load is symmetric
# in time about the impact.

_DRIVEN = 1e-9  # share of the terms of f_n', and of a turn, below which it is rounding
_MOST = 1 << 14  # modes and periods
_MOST_UNDAMPED = 64  # modes looked at where only some are damped
_WHOLE = 64.0 * np.finfo(float).eps  # relative, as for resonance with the load


def grows(
    system: System,
    phases: npt.ArrayLike,
    periods: int = 1,
    *,
    modes: int | None = None,
    restitution: npt.ArrayLike | None = None,
) -> npt.NDArray[np.bool_]:
    """Where the elastic modes of an undamped bar that rebounds fully would gain energy at every impact.

    Such a root of B77 (14) is a motion of the rigid bar but none of the elastic one. The mean load does not matter.

    Parameters
    ----------
    system
        Gives s, d and the alternating part of the load.
    phases
        Impact phases in rad, of any shape; NaN where there is none.
    modes
        None for the continuous bar, or N for a bar of modes 0 … N.
    restitution
        R of each phase, which broadcasts with them; by default that of the system.

    Returns
    -------
    numpy.ndarray
        False where anything takes energy (R < 1, or every mode is damped), and for a contact law that turns the strain
        over; of the shape of `phases`.

    Examples
    --------
    >>> from percuss import Load, System, steady_states
    >>> system = System(s=20.0, d=0.0, restitution=1.0, load=Load.fourier([0.3, 1.0, 0.5j]))
    >>> motions = [orbit.phase for orbit in steady_states(system, modes=0).orbits]
    >>> grows(system, motions), grows(system, motions, modes=0)
    (array([ True,  True]), array([False, False]))
    """
    instance("system", system, System)
    m = count("periods", periods, most=_MOST)
    n = None if modes is None else count("modes", modes, least=0, most=_MOST)
    phase = numbers("phases", phases, "phases in rad, or NaN", nan=True)
    r = restitutions(system.restitution if restitution is None else restitution)
    try:
        contact, r = system.contact, np.broadcast_to(r, phase.shape)
    except ValueError:
        raise ParameterError("restitution", f"shape {r.shape}", f"numbers in a shape that fits {phase.shape}") from None
    found = np.zeros(phase.shape, dtype=bool)
    asked = (contact.velocity_factors(r) == -1.0) & (system.d == 0.0) & ~np.isnan(phase)
    if n == 0 or not asked.any():
        return found
    asked &= contact.strain_factors(r) == 1.0
    if asked.any():
        here = phase[asked]
        found[asked] = _unsymmetric(system, here, m) if n is None else _driven(system, here, m, n)
    return found


def _lasting(system: System, periods: int, modes: int) -> npt.NDArray[np.bool_]:
    """Which of the elastic modes n = 1 … `modes` are undamped and do not come back by themselves."""
    known = system.body.modes(modes)
    swings = known.omega * periods
    return np.asarray((known.damping == 0.0) & (np.abs(swings - np.rint(swings)) > _WHOLE * swings))


def _driven(system: System, phases: Array, periods: int, modes: int) -> npt.NDArray[np.bool_]:
    """Whether f_n' ≠ 0 for any of the first `modes` modes that do not come back by themselves; shape (len(φ),)."""
    response = forced_response(system)
    rate = response.modal(modes, phases)[1]
    scale = response.modal_bounds(modes)[1]
    driven = np.abs(rate) > _DRIVEN * scale[:, None]
    return np.asarray(driven[_lasting(system, periods, modes)].any(axis=0))


def _unsymmetric(system: System, phases: Array, periods: int) -> npt.NDArray[np.bool_]:
    """Whether any mode gains energy: a smooth load does that when not symmetric about the impact; shape (len(φ),)."""
    load = system.load
    if not system.body.damping.is_zero:
        return _driven(system, phases, periods, _MOST_UNDAMPED)
    if system.body.is_harmonic and not _lasting(system, periods, 1)[0]:  # then every mode comes back
        return np.zeros(phases.shape, dtype=bool)
    if load.is_piecewise:  # f_n' ~ Σ jump_j cos n θ_j: as many n as there are jumps decide about all of them
        return _driven(system, phases, periods, 4 * len(load.breaks))
    k = load.harmonics
    terms = (1j * k * load.coefficients[k] * np.exp(1j * np.outer(phases, k))).real
    return np.asarray((np.abs(terms) > _DRIVEN * np.sum(k * np.abs(load.coefficients[k]))).any(axis=1))
