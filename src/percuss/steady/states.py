"""All steady motions of a system with one impact every m load periods."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from percuss.errors import LoadError, ParameterError, ResonanceError
from percuss.model import External, HeldBody, System
from percuss.model.checks import Array, count, instance, numbers, positive
from percuss.steady.forced import forced_response
from percuss.steady.multipliers import FoundMotions
from percuss.steady.orbit import Orbit
from percuss.steady.phases import (
    FREE_AMPLITUDE,
    Arcs,
    gap_condition,
    grows,
    level_factor,
    level_of,
    phase_condition,
    ratio_at,
)

MAX_MODES = 4096
MAX_PERIODS = 1000


@dataclass(frozen=True)
class Nearest:
    """The nearest parameters at which a steady motion exists, the others kept.

    Parameters
    ----------
    load_factor
        Greatest load factor p_0/p_k.
    mean
        The mean load that goes with it.
    restitution
        Least coefficient of restitution, or None when even R = 1 is not enough.
    """

    load_factor: float
    mean: float
    restitution: float | None


@dataclass(frozen=True)
class SteadyStates(FoundMotions):
    """The steady motions with one impact every `periods` load periods.

    Parameters
    ----------
    level
        c, the right-hand side of B77 (14); where the contact law changes the strain, less what the mean load adds. Of a
        body that is held the gap g.
    level_max
        max v_f: motions exist while level ≤ level_max. Of a body that is held the greatest of `contact_place`.
    orbits
        Every root of B77 (14) in order of phase, physically possible or not, but for those that `note` tells of.
    nearest
        Where motions would exist, when there are none.
    note
        What else must be known, or "": roots of B77 (14) that are no motion of this bar (with R = 1 and no damping its
        ringing may grow), and a continuum of motions, for which one orbit stands.
    """

    system: System
    periods: int
    level: float
    level_max: float
    orbits: tuple[Orbit, ...]
    nearest: Nearest | None = None
    note: str = ""
    modes: int | None = None

    @property
    def exists(self) -> bool:
        """Whether any steady motion of this kind exists."""
        return bool(self.orbits)

    def rigid_velocity(self, phase: npt.ArrayLike) -> Array:
        """v_f at the given load phases (rad): the curve that meets the level at the roots.

        Where the contact law changes the strain, what that adds is in it.
        """
        if isinstance(self.system.body, HeldBody):
            raise ParameterError(
                "body",
                self.system.body.kind,
                "a free body",
                "a body that is held has no rigid motion: see `contact_place`",
            )
        condition = phase_condition(self.system, self.periods, self.modes)
        return condition.arcs.response.rigid_velocity(numbers("phase", phase))

    def contact_place(self, phase: npt.ArrayLike) -> Array:
        """Where the contact of a body that is held would be at impacts at the given load phases (rad): at the roots g.

        The displacement just before the impact, shape of `phase`.
        """
        body, phases = self.system.body, numbers("phase", phase)
        condition = gap_condition(self.system, self.periods, self.modes or 0) if isinstance(body, HeldBody) else None
        if condition is None:
            raise ParameterError("body", body.kind, "a body that is held, without internal resonance")
        return condition.value(phases)

    def __str__(self) -> str:
        body = "continuous bar" if self.modes is None else f"{self.modes} modes"
        levels = f"level {self.level:.6g}, max {self.level_max:.6g}"
        head = f"z=1/{self.periods}: {levels}, {len(self.orbits)} orbits, {body}"
        return "\n".join([head, *(f"  {orbit}" for orbit in self.orbits)])


def steady_states(
    system: System, periods: int = 1, *, modes: int | None = None, tolerance: float = 1e-10
) -> SteadyStates:
    """Every steady motion with one impact every `periods` load periods (B77 14).

    Parameters
    ----------
    modes
        None for the continuous bar (as many modes as `tolerance` asks for), or N for a bar of modes 0 … N.
    tolerance
        Wanted error of the striking end's position, relative to the stroke (dimensionless).

    Raises
    ------
    LoadError
        When the load does not push (mean ≤ 0) or is constant: there are no steady impacts then.
    ResonanceError
        When an undamped bar is driven exactly at one of its own frequencies.

    References
    ----------
    U. Björkenstam, Impact vibration of a bar, Int. J. Mech. Sci. 19 (1977) 471–481, equations (12)–(14).

    Examples
    --------
    >>> from percuss import Load, System, steady_states
    >>> system = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    >>> for orbit in steady_states(system).orbits:
    ...     print(f"{orbit.phase:.6f} {orbit.impact_velocity:.6f} {orbit.admissible}")
    0.800558 3.535663 True
    2.331435 3.535675 True
    """
    instance("system", system, System)
    m = count("periods", periods, most=MAX_PERIODS)
    n = None if modes is None else count("modes", modes, least=0, most=MAX_MODES)
    wanted = positive("tolerance", tolerance)
    check_pushes(system)
    body, held = system.body, isinstance(system.body, HeldBody)
    n = body.chosen(n) if isinstance(body, HeldBody) else n
    condition = gap_condition(system, m, n or 0) if held else phase_condition(system, m, n)
    if condition is None:
        return SteadyStates(system, m, body.gap, math.nan, (), None, FREE_AMPLITUDE, n)
    phases, folds = condition.roots()
    kept = np.ones(phases.shape, dtype=bool)
    if not held and system.d == 0.0 and system.contact.is_lossless:
        kept = ~grows(system, phases, m, modes=n)
    orbits = tuple(
        Orbit(system, m, float(phase), bool(fold), n, wanted)
        for phase, fold in zip(phases[kept], folds[kept], strict=True)
    )
    level = body.gap if held else condition.level
    nearest = None if phases.size or held else _nearest(system, 2.0 * math.pi * m, condition.highest)
    note = "; ".join(text for text in (_grow_note(phases[~kept]), _continuum_note(orbits)) if text)
    return SteadyStates(system, m, level, condition.highest, orbits, nearest, note, n)


def _continuum_note(orbits: tuple[Orbit, ...]) -> str:
    """What is said of the motions that stand for a continuum of them."""
    return "; ".join(
        f"every impact phase from {orbit.continuum[0]:.6g} to {orbit.continuum[1]:.6g} rad has its steady motion, as "
        f"v_f stays at the level there: the orbit in the middle, {orbit.phase:.6g} rad, stands for this continuum"
        for orbit in orbits
        if orbit.continuum is not None
    )


def _grow_note(phases: Array) -> str:
    """What is said of the phases at which an undamped bar that rebounds fully would strike."""
    if not phases.size:
        return ""
    where = ", ".join(f"{phase:.6g}" for phase in phases)
    return (
        "with R = 1 and no damping nothing takes the energy that this load puts into the elastic modes: the rigid "
        f"motion exists (impact phase {where} rad), but the bar's ringing grows without bound"
    )


def check_pushes(system: System) -> None:
    """Raise LoadError when the system cannot have steady impacts."""
    if system.load.is_constant:
        raise LoadError(
            "the load is constant: there is no load period, hence no steady motion to find",
            "give it an alternating part, or simulate the bouncing bar instead",
        )
    if system.body.is_free and system.load.mean <= 0.0:
        raise LoadError(
            f"the load does not push: its mean is p_0 = {system.load.mean:.6g}, and must be greater than 0",
            "reverse the sign of the force (positive is toward the wall) or add a feed force",
        )


def _nearest(system: System, period: float, highest: float) -> Nearest:
    """B77 (14) solved for the mean load, and for R, at the fold c = max v_f."""
    mean = highest / (period * float(level_factor(system.d * period, system.contact.impedance_ratio)))
    load_factor = system.load.load_factor * mean / system.load.mean
    ratio = ratio_at(system.load.mean, system.d, np.array(highest), period)
    restitution = float(system.contact.restitutions_of(ratio))
    return Nearest(load_factor, mean, restitution if restitution <= 1.0 else None)


# ---- What the damping does to the motion of the bar as a whole: a drag
#
# External damping d is spread along the bar (B77 3). It lets the elastic modes ring down, and it brakes the rigid
# motion with the force c·v: c is d in the units of here, and D·L in N·s/m. Guessed for the ringing it can be a drag
# that no machine has; the other laws of damping leave the rigid motion free.

_HALVINGS = 30


@dataclass(frozen=True)
class Drag:
    """The drag on the rigid motion; dimensionless.

    Attributes
    ----------
    force
        At the striking speed of the rigid motion: d·w_0.
    of_mean
        The same as a fraction of the mean push p_0.
    of_input
        What all the damping takes, as a fraction of what the load puts in; None when it puts nothing in.
    """

    force: float
    of_mean: float
    of_input: float | None


def drag_of(orbit: Orbit) -> Drag:
    """The drag on a steady motion.

    Examples
    --------
    >>> from percuss import Load, System, steady_states
    >>> system = System(s=20.0, d=0.05, restitution=0.6, load=Load.harmonic(0.6, 1.0))
    >>> drag = drag_of(steady_states(system).orbits[1])
    >>> print(f"{drag.of_mean:.3f} of the mean push, {drag.of_input:.2f} of the input")
    0.196 of the mean push, 0.32 of the input
    """
    instance("orbit", orbit, Orbit)
    energy, force = orbit.energy, orbit.system.d * orbit.rigid_velocity
    put_in = energy.input if energy.input > 0.0 else None
    return Drag(force, force / orbit.system.load.mean, None if put_in is None else energy.damping / put_in)


def greatest_drag(system: System, periods: int) -> float | None:
    """The greatest d, below that of the system, with which a steady motion exists, all else kept; None without one.

    Raises
    ------
    LoadError
        When the load does not push or is constant.
    """
    check_pushes(instance("system", system, System))
    period = 2.0 * math.pi * count("periods", periods, most=MAX_PERIODS)

    def exists(d: float) -> bool:
        lighter = System(system.body.damped_by(External(d)), system.load, system.contact)
        try:
            highest = Arcs.of(forced_response(lighter)).highest
        except ResonanceError:
            return False
        return level_of(lighter, period) <= highest

    low, high = 1e-9 * system.d, system.d
    if not low > 0.0 or not exists(low):
        return None
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if exists(middle) else (low, middle)
    return low
