"""The structure of one mode that has its wall where it rests without force: rest and release of it are those of a bar.

While the wall holds the contact of such a structure it stands still, and has forgotten all that was before. The spring
then presses or pulls as the load does: y = a q − g with q'' + d q' + ω² q = b p(t) is y'' + d y' + ω² y = γ p − ω² g,
γ = a b. The wall feels γ p − ω² g, the structure leaves it where that changes from push to pull, and flies from y = 0
and y' = 0. (C. Budd and F. Dux, Phil. Trans. R. Soc. Lond. A 347 (1994) 365–389.)
"""

from __future__ import annotations

import math

from percuss.errors import ParameterError
from percuss.model.body import HeldBody, ModalBody, Modes
from percuss.model.load import Load
from percuss.model.system import System

__all__ = ["half_swing", "rests", "set_at_wall", "wall_load"]


def rests(system: System, modes: int) -> bool:
    """Whether what rests on the wall stands still, so that the load alone tells when it leaves: a bar, or one mode."""
    return system.body.is_free or modes == 1


def wall_load(system: System, modes: int) -> Load:
    """The load whose pull takes the contact off the wall: that of a bar; of one mode sign(γ) (p − ω² g/γ).

    Raises
    ------
    ParameterError
        For a structure with several modes, which moves on while the wall holds its contact.
    """
    body = system.body
    if not isinstance(body, HeldBody):
        return system.load
    if not rests(system, modes):
        raise ParameterError(
            "modes", modes, "1 for the rest of a structure that is held: of several modes the others move on meanwhile"
        )
    known = body.modes(1, system.load.at)
    gamma, omega = float(known.gamma[0]), float(known.omega[0])
    offset = omega * omega * body.gap / gamma
    if not math.isfinite(offset):
        raise ParameterError("gap", body.gap, "a gap that forces of usual size can close")
    return system.load.with_mean(system.load.mean - offset).scaled(math.copysign(1.0, gamma))


def set_at_wall(system: System, modes: int) -> System:
    """The system whose impacts are those of a structure of one mode, with the wall at 0; a bar as it is.

    Raises
    ------
    ParameterError
        As `wall_load`.
    """
    if system.body.is_free:
        return system
    load = wall_load(system, modes).acting_at(0)
    known = system.body.modes(1, system.load.at)
    contact = 1.0 / math.sqrt(float(known.inertia[0]))
    drive = abs(float(known.gamma[0])) / contact
    body = ModalBody((float(known.omega[0]),), (float(known.damping[0]),), (contact,), (drive,))
    return System(body, load, system.contact)


def half_swing(known: Modes) -> float:
    """How long the first mode goes on the way on which a force of one sign has put it; inf where it is overdamped."""
    half = 0.5 * float(known.damping[0])
    square = (float(known.omega[0]) - half) * (float(known.omega[0]) + half)
    return math.pi / math.sqrt(square) if square > 0.0 else math.inf
