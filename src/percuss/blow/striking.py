"""One blow of a striker on a target."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from percuss.blow.blow import Blow
from percuss.blow.bodies import Rod, Striker, Target, Wall, striker_sections
from percuss.blow.kernels.nodes import go_on
from percuss.blow.kernels.wave_records import ENDLESS, FREE, FULL, REACHED
from percuss.blow.parts import BlowOutcome
from percuss.blow.question import BlowTables, Field, Question, enlarged, tables
from percuss.blow.wave_history import WaveHistory, is_over, is_spent
from percuss.errors import ConvergenceError, ParameterError
from percuss.halting import look
from percuss.model.checks import count, positive

# ---- A blow carried on: as far as asked, or until no further contact is possible

_AT_ONCE = 1 << 14  # steps between two looks whether anybody still waits


def carried_to(held: BlowTables, target: int, most_pieces: int) -> tuple[BlowTables, bool]:
    """The blow with every node at least at the tick `target`; whether it got there."""
    while True:
        code = go_on(held.problem, held.waves, held.state, target, _AT_ONCE)
        if code == REACHED:
            return held, True
        if held.waves.pieces.sum() > most_pieces:
            return held, False
        if code == FULL:
            held = enlarged(held)
        look()


# ---- One blow of a striker on a target

MOST_PIECES = 4_000_000
"""Pieces of waves of one blow, unless told otherwise: half a gigabyte."""


def strike(
    striker: Striker,
    target: Target,
    velocity: Any = None,
    *,
    until: float | None = None,
    load: Iterable[tuple[float, float]] = (),
    load_at: int = 0,
    field: Field | None = None,
    most_pieces: int = MOST_PIECES,
) -> Blow:
    """One blow, resolved by one-dimensional waves, exactly but for rounding (St Venant 1867; Fischer 1959).

    Striker and rod are chains of sections without damping. Their faces push each other and never pull. There is no
    lattice: sections may have any lengths.

    Parameters
    ----------
    striker
        A bar with sizes (`Bar`, `SectionedBar`), then all numbers are SI; or a dimensionless one (`UniformBar`,
        `SteppedBar`), then mass, length and angular frequency are 1.
    target
        A `Wall` or a `Rod`, at rest.
    velocity
        Of the striker toward the target, one number or one for each section; the striker is free of stress. None
        with `field`.
    until
        End of the window. None: until no further contact is possible, where that can be proved, or nothing is left;
        at most 20 transit times of the striker, and once through the rod and back.
    load
        Steps (time, force): the force on the striker toward the target from each time on.
    load_at
        The place of that force: 0 the driven end, i the step after the i-th section.
    field
        Velocity and compressive force in the striker at the start, functions of x, an array from 0 to 1.
    most_pieces
        Pieces of waves after which the window is cut short.

    Returns
    -------
    Blow
        Whose `outcome` says how its window ended.

    Raises
    ------
    ParameterError
        For values out of range, and parts that do not go together.
    Interrupted
        When the computation was told to stop.

    Examples
    --------
    >>> from percuss.blow import Rod, strike
    >>> from percuss.model import Bar, Section
    >>> blow = strike(Bar(0.5, 1e-3), Rod([Section(None, area=4e-3)]), 10.0)
    >>> print(f"R = {blow.effective_restitution:.6f}, {len(blow.contacts)} contact, {blow.outcome.name}")
    R = 0.600000, 1 contact, OVER
    """
    most = count("most_pieces", most_pieces, 1, 1 << 40)
    question = Question.checked(striker, target, velocity, field, load, load_at, until)
    held = tables(question)
    gap = held.state.now[0].gap
    held, end, outcome = _followed(held, float(gap), question.until is None, most)
    course = WaveHistory(held, end, float(gap))
    if outcome is None:
        outcome = _ended(course)
    seconds = end * held.problem.tick * held.scales.time
    reached = question.until if question.until is not None and end == held.problem.until else seconds
    return Blow(striker, target, question.velocity, reached, outcome, question, course)


def _followed(held: BlowTables, gap: float, until_over: bool, most: int) -> tuple[BlowTables, int, BlowOutcome | None]:
    """The blow to the end of its window; where that is, and the outcome where it is known."""
    problem = held.problem
    transit = round(1.0 / problem.tick)
    ends_early = until_over and (problem.end == FREE or not problem.stiffness > 0.0)
    target, spent = transit if ends_early else problem.until, False
    while True:
        target = min(target, problem.until)
        held, there = carried_to(held, target, most)
        if not there:
            return held, int(held.state.time[: _nodes(held)].min()), BlowOutcome.TOO_MANY_PIECES
        if ends_early and held.state.now[0].noted > 0:
            course = WaveHistory(held, target, gap)
            if is_over(course):
                return held, target, BlowOutcome.OVER
            if spent:  # a transit ago; meanwhile faces without a force have parted
                return held, target, BlowOutcome.SPENT
            spent = is_spent(course)
        if target == problem.until:
            return held, target, None
        target += transit


def _nodes(held: BlowTables) -> int:
    """Number of nodes that anything happens at."""
    size = held.problem.impedance.size
    return size if held.problem.end == ENDLESS else size + 1


def _ended(course: WaveHistory) -> BlowOutcome:
    """How a window ended that was not cut short."""
    if is_over(course):
        return BlowOutcome.OVER
    if course.in_contact:
        return BlowOutcome.SPENT if is_spent(course) else BlowOutcome.STILL_IN_CONTACT
    striker = course.striker
    own = course.momentum(0, striker, course.end) / course.mass
    face = course.node_velocity(striker, course.end) if course.has_rod else 0.0
    return BlowOutcome.GAP_CLOSING if own > face else BlowOutcome.WINDOW_ENDED


# ---- What the instantaneous laws need of a blow: restitution, duration, force centroid, advance; computed once, kept


@dataclass(frozen=True)
class EffectiveBlow:
    """One load-free blow of a striker without stress, by the few numbers that a law of contact needs.

    Parameters
    ----------
    restitution
        R_eff = −V_1/V_0; below 0 where the striker goes on.
    duration, centroid
        t_c and t_J from the start of the first contact; None where the contact never ends.
    advance
        How far the plane of impact moves in the blow, per speed of the striker, in s: J/Z of an endless rod that stays
        where it is left, the residual penetration of a rod on rock, 0 of a wall and of any other rod, which is pushed
        back.
    ringing
        Share of the energy before that rings in the striker afterwards.
    contacts
        How many there were.
    outcome
        How the window ended.
    """

    restitution: float
    duration: float | None
    centroid: float | None
    advance: float
    ringing: float
    contacts: int
    outcome: BlowOutcome


def effective_blow(
    striker: Striker, target: Target, velocity: float = 1.0, *, until: float | None = None
) -> EffectiveBlow:
    """The blow of a striker on a target from rest, with the last 256 questions kept.

    Without gaps no time and no ratio depends on the velocity; the rock's law is homogeneous as well. The window ends as
    that of `strike` does, or with `until`.

    Raises
    ------
    ParameterError
        For anything that `strike` refuses.
    ConvergenceError
        When the blow has too many pieces of waves to be followed.

    Examples
    --------
    >>> from percuss.blow import Rod
    >>> from percuss.model import UniformBar
    >>> found = effective_blow(UniformBar(20.0), Rod.of_impedance(80.0))
    >>> round(found.restitution, 12), round(found.duration, 12), round(found.centroid, 12)
    (0.6, 0.1, 0.05)
    """
    striker_sections(striker)
    if not isinstance(target, Wall | Rod):
        raise ParameterError("target", target, "a Wall or a Rod")
    end = None if until is None else positive("until", until)
    return _known(striker, target, positive("velocity", velocity), end)


@lru_cache(maxsize=256)
def _known(striker: Striker, target: Target, velocity: float, until: float | None) -> EffectiveBlow:
    blow = strike(striker, target, velocity, until=until)
    if blow.outcome is BlowOutcome.TOO_MANY_PIECES:
        raise ConvergenceError("the waves of this blow have too many pieces", "leave the shortest sections out")
    return EffectiveBlow(
        restitution=float(blow.effective_restitution or 0.0),
        duration=blow.contact_duration,
        centroid=blow.force_centroid,
        advance=_advance(blow) / velocity,
        ringing=blow.vibration_energy_after / blow.energy_before,
        contacts=len(blow.contacts),
        outcome=blow.outcome,
    )


def _advance(blow: Blow) -> float:
    if blow.residual_penetration is not None:
        return blow.residual_penetration
    if isinstance(blow.target, Rod) and blow.target.end == "infinite":
        return blow.impulse / blow.target.end_impedance
    return 0.0
