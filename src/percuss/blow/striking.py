"""One blow of a striker on a target."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from percuss.blow.blow import Blow
from percuss.blow.course import Course
from percuss.blow.ending import is_over, is_spent
from percuss.blow.following import carried_to
from percuss.blow.kernels.layout import ENDLESS, FREE
from percuss.blow.parts import Outcome
from percuss.blow.question import Field, Question
from percuss.blow.striker import Striker
from percuss.blow.tables import Tables, tables
from percuss.blow.target import Target
from percuss.model.checks import count

__all__ = ["MOST_PIECES", "strike"]

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
    course = Course(held, end, float(gap))
    if outcome is None:
        outcome = _ended(course)
    seconds = end * held.problem.tick * held.scales.time
    reached = question.until if question.until is not None and end == held.problem.until else seconds
    return Blow(striker, target, question.velocity, reached, outcome, question, course)


def _followed(held: Tables, gap: float, until_over: bool, most: int) -> tuple[Tables, int, Outcome | None]:
    """The blow to the end of its window; where that is, and the outcome where it is known."""
    problem = held.problem
    transit = round(1.0 / problem.tick)
    ends_early = until_over and (problem.end == FREE or not problem.stiffness > 0.0)
    target, spent = transit if ends_early else problem.until, False
    while True:
        target = min(target, problem.until)
        held, there = carried_to(held, target, most)
        if not there:
            return held, int(held.state.time[: _nodes(held)].min()), Outcome.TOO_MANY_PIECES
        if ends_early and held.state.now[0].noted > 0:
            course = Course(held, target, gap)
            if is_over(course):
                return held, target, Outcome.OVER
            if spent:  # a transit ago; meanwhile faces without a force have parted
                return held, target, Outcome.SPENT
            spent = is_spent(course)
        if target == problem.until:
            return held, target, None
        target += transit


def _nodes(held: Tables) -> int:
    """Number of nodes that anything happens at."""
    size = held.problem.impedance.size
    return size if held.problem.end == ENDLESS else size + 1


def _ended(course: Course) -> Outcome:
    """How a window ended that was not cut short."""
    if is_over(course):
        return Outcome.OVER
    if course.in_contact:
        return Outcome.SPENT if is_spent(course) else Outcome.STILL_IN_CONTACT
    striker = course.striker
    own = course.momentum(0, striker, course.end) / course.mass
    face = course.node_velocity(striker, course.end) if course.has_rod else 0.0
    return Outcome.GAP_CLOSING if own > face else Outcome.WINDOW_ENDED
