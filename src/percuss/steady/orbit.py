"""One steady motion with one impact every m load periods, as a value: is it possible, what does it carry?"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from percuss.model import System
from percuss.model.checks import DEFAULT_MODES, Array, array, choice, count
from percuss.model.load import Side
from percuss.steady.flight import Contactless, Energy, Flown, Violation, exchange, flight_check
from percuss.steady.forced import Field
from percuss.steady.multipliers import (
    MAX_MODES,
    LinearMap,
    Multipliers,
    Reason,
    Repeating,
    map_at_impact,
    multipliers_of,
)
from percuss.steady.oscillator import ModalState, modal_state

_MOST_IMPACTS = 10**7


@dataclass(frozen=True)
class Orbit(Flown, Repeating):
    """A steady motion with one impact every `periods` load periods; made by `steady_states`.

    Times are in radians of the load's fundamental **after the impact**, from 0 to `period`; positions are
    fractions of the length. All quantities are dimensionless (theory §1); `si_report` gives them in SI.

    Parameters
    ----------
    phase
        φ, the phase of the load at the impact, in [0, 2π).
    fold
        Whether the phase is a double root of B77 (14): two steady motions meet here.
    requested_modes
        None: the continuous bar; the forced part is summed over all modes and the transient part over as many as
        `tolerance` asks for. A number N: the bar of modes 0 … N, forced part included, exactly as a simulation with N
        modes moves.
    tolerance
        Wanted error of the striking end's position, relative to the stroke.
    """

    system: System
    periods: int
    phase: float
    fold: bool = False
    requested_modes: int | None = None
    tolerance: float = 1e-10

    # -- how it is computed --

    def modal_state(self, modes: int) -> ModalState:
        """The elastic modes 1 … `modes` at the impact, however many the sums use."""
        known: ModalState | None = self.__dict__.get("_longest")
        if known is None or known.omega.size < modes:
            f, velocity = self.response.modal(modes, np.array([self.phase]))
            known = modal_state(self.system, self.period, (f[:, 0], velocity[:, 0]))
            self.__dict__["_longest"] = known
        return known.first(modes)

    @property
    def continuum(self) -> tuple[float, float] | None:
        """First and last of the phases (rad) that are all impact phases, where v_f stays at the level; or None.

        That is so under a load of steps where one step just keeps up v_f. Every phase between has its motion.
        """
        return self.response.plateau(self.phase) if self.fold else None

    # -- as every orbit --

    @property
    def impacts(self) -> int:
        """p = 1."""
        return 1

    @property
    def times(self) -> tuple[float, ...]:
        """When the impact is, in rad of the load."""
        return (self.phase,)

    @property
    def label(self) -> str:
        """z=1/m."""
        return f"z=1/{self.periods}"

    # -- speeds and energies --

    @property
    def period(self) -> float:
        """T = 2πm, from impact to impact."""
        return 2.0 * math.pi * self.periods

    @cached_property
    def rebasing(self) -> float:
        """How far an impact moves the bar as a whole against its striking end, dimensionless.

        By Σ γ_n (u_n⁺ − u_n⁻), as the striking end stays at the wall; 0 when the strain is kept.
        """
        if self.system.contact.keeps_strain:
            return 0.0
        return (self.system.contact.strain_factor - 1.0) * float(self._end_rows[0] @ self.state.displacement)

    @property
    def rigid_velocity(self) -> float:
        """Mean velocity of the bar just before the impact: w_0 = p_0 T/(1 + R) whatever the damping (B77)."""
        system = self.system
        dragged = system.d * self.rebasing if system.d > 0.0 else 0.0  # over the period the bar moves as far
        return (system.push * self.period - dragged) / system.contact.impulse

    @property
    def rigid_rebound(self) -> float:
        """Mean velocity of the bar just after the impact."""
        return self.system.contact.velocity_factor * self.rigid_velocity

    @cached_property
    def impact_velocity(self) -> float:
        """Striking speed u_t(1, 0⁻) of the striking end."""
        forced = self.response.end_velocity(self.phase, self.modes, cut=self.cut)
        free = self.state.velocity - self.state.forced_velocity
        return self.rigid_velocity + forced + float(self._end_rows[0] @ free)

    @property
    def rebound_velocity(self) -> float:
        """Velocity u_t(1, 0⁺) = −R u_t(1, 0⁻) of the striking end just after the impact."""
        return self.system.contact.velocity_factor * self.impact_velocity

    @cached_property
    def blow_energy(self) -> float:
        """Kinetic energy ½ ∫ u_t² dx just before the impact, all modes."""
        return 0.5 * self.rigid_velocity**2 + float(np.sum(0.5 * self._known.weight * self.state.velocity**2))

    @cached_property
    def strain_energy(self) -> float:
        """Strain energy just before the impact, of the modes of the sums."""
        return float(np.sum(0.5 * self._known.weight * (self.state.omega * self.state.displacement) ** 2))

    @property
    def delivered_energy(self) -> float:
        """What the impact takes: (1 − R²) times the blow energy, and of the strain energy if it changes the strain."""
        return self.system.contact.energy_taken(self.blow_energy, self.strain_energy)

    @cached_property
    def rigid_stroke(self) -> float:
        """Range of the mean motion over the impact period: the scale of all relative errors."""
        contact = self.system.contact
        return self.mean_range(contact.velocity_factor * (self.system.push * self.period / contact.impulse)) or 1.0

    # -- motion --

    def position(self, x: npt.ArrayLike, t: npt.ArrayLike) -> Array:
        """u(x, t), with the wall at u = 0; shape (len(x), len(t))."""
        return self.field(x, t).displacement

    def velocity(self, x: npt.ArrayLike, t: npt.ArrayLike) -> Array:
        """u_t(x, t); after the impact at t = 0, before the next one at t = T. Shape (len(x), len(t))."""
        return self.field(x, t).velocity

    def strain(self, x: npt.ArrayLike, t: npt.ArrayLike) -> Array:
        """u_x(x, t), negative in compression; shape (len(x), len(t))."""
        return self.field(x, t).strain

    def motion(self, t: npt.ArrayLike) -> Array:
        """Gap function y(t) = u(1, t): 0 at the impacts, negative between them. Shape (len(t),)."""
        return np.asarray(self.position(1.0, t)[0])

    def driven_end(self, t: npt.ArrayLike) -> Array:
        """u(0, t), shape (len(t),)."""
        return np.asarray(self.position(0.0, t)[0])

    def impact_field(self, x: npt.ArrayLike) -> Array:
        """u_t(x, 0⁻), the velocity along the bar just before the impact; shape (len(x),)."""
        positions = array("x", x, 0.0, 1.0)
        rows = self.system.body.driven_shapes(positions, self.modes, self.system.load.at).displacement
        forced = self.forced_elastic(positions, np.array([self.phase])).velocity[:, 0]
        transient = self.state.velocity - self.state.forced_velocity
        return np.asarray(self.rigid_velocity + forced + rows @ transient)

    def field(self, x: npt.ArrayLike, t: npt.ArrayLike) -> Field:
        """Displacement, velocity and strain together; each of shape (len(x), len(t))."""
        positions, given = array("x", x, 0.0, 1.0), array("t", t, -np.inf, np.inf)
        times = np.mod(given, self.period)
        times = np.where((given != 0.0) & (times == 0.0), self.period, times)
        rigid, rigid_velocity = self.rigid_motion(times)
        forced = self.forced_elastic(positions, self.phase + times)
        rows = np.concatenate(self.system.body.driven_shapes(positions, self.modes, self.system.load.at))
        z, z_velocity = self._free_sum(times, rows)
        n = positions.size
        return Field(
            self._offset + rigid + forced.displacement + z[:n],
            rigid_velocity + forced.velocity + z_velocity[:n],
            forced.strain + z[n:],
        )

    def forced_elastic(self, x: Array, theta: Array) -> Field:
        """Elastic part of the forced motion at load phases `theta`; each of shape (len(x), len(θ))."""
        return self.response.elastic(x, theta, self.modes, cut=self.cut)

    @cached_property
    def _offset(self) -> float:
        """Where the wall stands: B77's arbitrary constant, from y(0⁺) = 0."""
        forced = self.forced_elastic(np.array([1.0]), np.array([self.phase])).displacement[0, 0]
        return -float(forced + (self._end_rows @ self.state.z)[0])

    # -- what is asked of it --

    @cached_property
    def energy(self) -> Energy:
        """Energy over one impact period: put in by the load, taken by damping and by the impact."""
        return Energy(*exchange(self), self.delivered_energy)

    def impact_history(self, impacts: int) -> Array:
        """The first `impacts` impacts from load time φ on: one row each of absolute time (rad of the load), load phase,
        striking speed and rebound velocity of the striking end; shape (impacts, 4), dimensionless.
        """
        n = np.arange(count("impacts", impacts, most=_MOST_IMPACTS))
        row = [self.phase, self.phase, self.impact_velocity, self.rebound_velocity]
        return np.asarray(np.tile(row, (n.size, 1)) + np.outer(n, [self.period, 0.0, 0.0, 0.0]))

    # -- is it stable --

    def linear_map(self, modes: int, side: Side = "right") -> LinearMap:
        """The linearised map from impact to impact, with modes 0 … `modes`.

        The orbit is that of the bar with so many modes: its forced part is cut there as well. Where the load jumps at
        the impact, `side` chooses its value.
        """
        modes = count("modes", modes, least=0, most=MAX_MODES)
        choice("side", side, "left", "right")
        state, system = self.modal_state(modes), self.system
        gamma = system.body.modes(modes, system.load.at).gamma
        # what the load gives in a period, less what drag takes as the bar returns to where the impact moves it from
        bent = (1.0 - system.contact.strain_factor) * float(gamma @ state.displacement) if system.d else 0.0
        rigid = (system.push * self.period + system.d * bent) / system.contact.impulse
        force = float(system.load.value(self.phase, side))
        return map_at_impact(system, self.period, force, state.displacement, np.append(rigid, state.velocity))

    def multipliers(self, modes: int | None = None, *, side: Side = "right") -> Multipliers:
        """All multipliers, exact for the bar with modes 0 … N; see `percuss.stability.floquet_multipliers`."""
        n = DEFAULT_MODES if modes is None and self.requested_modes is None else modes
        n = count("modes", self.requested_modes if n is None else n, least=0, most=MAX_MODES)

        def fewer(few: int) -> Multipliers:
            return self.multipliers(few, side=side)

        return multipliers_of(self.label, self.system, self.linear_map(self.system.body.chosen(n), side), fewer)

    @property
    def verdict(self) -> Reason:
        """What the multipliers say; the worse side of a jump of the load decides."""
        return Reason.FOLD if self.fold else super().verdict

    # -- is it real --

    @cached_property
    def _flight(self) -> Contactless:
        return flight_check(self)

    @property
    def violation(self) -> Violation | None:
        """Where the bar would pass through the wall between two impacts, or None."""
        return self._flight.violation

    @property
    def proven(self) -> bool:
        """Whether the absence of a touch between the impacts, or the first one, is proved."""
        return self._flight.proven

    @property
    def obstacle(self) -> Reason | None:
        """Why the motion is not physical: `Reason.NO_BLOW` or `Reason.THROUGH_WALL`; None for one that is."""
        if not self.impact_velocity > 0.0:
            return Reason.NO_BLOW
        return None if self.violation is None else Reason.THROUGH_WALL

    @property
    def admissible(self) -> bool:
        """Whether the motion is physical: it strikes forward, and y(t) < 0 for 0 < t < T."""
        return self.obstacle is None

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """A strong drag, near-resonances of the load or the impacts with elastic modes, a tolerance not reached."""
        return (*drag_warnings(self), *resonance_warnings(self, self.stroke, self.proven))

    @cached_property
    def stroke(self) -> float:
        """Range of the striking end's position over the impact period."""
        top = 0.0 if self.violation is None else self.highest[1]  # y ≤ 0 = y(0) unless it passes the wall
        return top - self.lowest[1]

    @cached_property
    def highest(self) -> tuple[float, float]:
        """Time and value of the greatest y over the period; 0 at the impact when the orbit is admissible."""
        return self._extreme(1.0)

    @cached_property
    def lowest(self) -> tuple[float, float]:
        """Time and value of the least y over the period."""
        return self._extreme(-1.0)

    @cached_property
    def _coarse(self) -> tuple[Array, Array]:
        detail = min(max(4, 2 * int(self.system.load.harmonics.max(initial=1))), 128)
        t = np.linspace(0.0, self.period, 16 * self.periods * detail + 1)
        return t, self.end_motion(t, self.truncation.few)[0]

    def _extreme(self, sign: float) -> tuple[float, float]:
        """A first look with few modes, two closer ones with more, and the place where the speed vanishes with all."""
        t, y = self._coarse
        for points in (33, 17):
            best = int(np.argmax(sign * y))
            t = np.linspace(t[max(best - 1, 0)], t[min(best + 1, t.size - 1)], points)
            y, speed = self.end_motion(t, self.truncation.some)
        best = int(np.argmax(sign * y))
        other = min(max(best + (1 if sign * speed[best] > 0.0 else -1), 0), t.size - 1)
        turn = t[best]
        if speed[best] * speed[other] < 0.0:
            turn += (t[other] - t[best]) * speed[best] / (speed[best] - speed[other])
        times = np.array([t[best], turn])
        values = self.end_motion(times, self.modes)[0]
        last = int(np.argmax(sign * values))
        return float(times[last]), float(values[last])

    def __str__(self) -> str:
        where = "admissible" if self.admissible else "not admissible"
        return (
            f"Orbit {self.label}: phase {self.phase:.6f} rad, striking speed {self.impact_velocity:.6g}, "
            f"{where}, {self.modes} mode{'s' if self.modes != 1 else ''} (error {self.error_bound:.1e} of the stroke)"
        )


# ---- Warnings about a strong drag, and about elastic modes near resonance with the load or with the impacts

_STRONG_DRAG = 0.2  # part of the mean push from which on the drag at the striking speed is warned of
_AMPLIFIED = 10.0  # a mode that moves this many times its static (or typical) share is near resonance
_NOTICEABLE = 1e-3  # share of the stroke below which nobody needs to know
_UNAVOIDABLE = 1e-4  # share of the stroke that nobody is warned of where an impact changes the strain
_MOST = 5


def drag_warnings(motion: Orbit) -> tuple[str, ...]:
    """A sentence where the drag at the striking speed is more than 20 % of the mean push."""
    if motion.system.d == 0.0:
        return ()
    share = motion.system.d * motion.rigid_velocity / motion.system.load.mean
    if share <= _STRONG_DRAG:
        return ()
    return (
        f"at the striking speed the damping drags the whole bar with {100.0 * share:.3g} % of the mean push; unless "
        "the machine really has such a drag, take less damping",
    )


def resonance_warnings(motion: Orbit, stroke: float, proven: bool) -> tuple[str, ...]:
    """Sentences about modes that ring strongly, the strongest first, and about a tolerance that was not reached."""
    found = _load_resonances(motion, stroke) + _impact_resonances(motion, stroke)
    found.sort(key=lambda pair: -pair[0])
    texts = []
    if not proven:
        texts.append("whether the bar touches the wall between the impacts could not be proved within the work allowed")
    # what the release of strain sets ringing falls off so slowly that no number of modes reaches a fine tolerance
    least = 0.0 if motion.system.contact.keeps_strain else _UNAVOIDABLE
    if motion.requested_modes is None and motion.error_bound > max(motion.tolerance, least):
        texts.append(
            f"{motion.modes} modes leave a position error of up to {motion.error_bound:.1e} of the stroke "
            f"({motion.tolerance:.0e} was asked for)"
        )
    return (*texts, *(text for _, text in found[:_MOST]))


def _load_resonances(motion: Orbit, stroke: float) -> list[tuple[float, str]]:
    load, body = motion.system.load, motion.system.body
    k = load.harmonics
    if not k.size:
        return []
    nearest = body.nearest(k)
    modes = body.modes(int(nearest.max()), load.at)
    omega, damping, coupling = (x[nearest - 1] for x in (modes.omega, modes.damping, np.abs(modes.gamma)))
    gain = omega**2 / np.abs(omega**2 - k**2 + 1j * k * damping)
    share = coupling * gain * np.abs(load.coefficients[k]) / omega**2 / stroke
    return [
        (
            float(share[i]),
            f"load harmonic k = {k[i]} lies {100 * (k[i] / omega[i] - 1):+.2g} % from elastic mode n = "
            f"{int(nearest[i])}: the mode's motion is amplified {gain[i]:.3g} times, "
            f"to {100 * share[i]:.2g} % of the stroke",
        )
        for i in np.flatnonzero((gain > _AMPLIFIED) & (share > _NOTICEABLE))
    ]


def _impact_resonances(motion: Orbit, stroke: float) -> list[tuple[float, str]]:
    state, system = motion.state, motion.system
    modes = system.body.modes(state.omega.size, system.load.at)
    share = np.abs(modes.gamma) * state.amplitude / stroke
    typical = system.contact.impulse * np.abs(state.forced_velocity) / state.omega
    with np.errstate(divide="ignore", invalid="ignore"):
        gain = np.where(typical > 0.0, state.amplitude / typical, 0.0)
    rate = np.sqrt(np.maximum(state.omega**2 - 0.25 * modes.damping**2, 0.0)) * motion.periods
    found = [
        (
            float(share[i]),
            f"elastic mode n = {i + 1} rings near {int(np.rint(rate[i]))} times the blow rate: "
            f"amplified {gain[i]:.3g} times, to {100 * share[i]:.2g} % of the stroke",
        )
        for i in np.flatnonzero((gain > _AMPLIFIED) & (share > _NOTICEABLE))
    ]
    stuck = np.flatnonzero(state.divisor == 0.0)
    if stuck.size and not system.contact.is_lossless:
        text = f"elastic mode n = {stuck[0] + 1} is in exact resonance with the impacts: its amplitude is undetermined"
        found.append((np.inf, text))
    return found
