"""Contacts gathered to impacts, with what each impact did."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from percuss.model import Load
from percuss.model.checks import Array
from percuss.shown import Shown

__all__ = ["ROUND_TRIP", "Impacts", "impacts_of"]

_TURN = 2.0 * math.pi
ROUND_TRIP = 2.0
"""Transit times: contacts nearer than the way of waves there and back belong to one impact."""

_GRAZE = 1e-9  # of the greatest impulse


@dataclass(frozen=True)
class Impacts(Shown):
    """The impacts of a machine, one after another; every array of shape (impacts,), dimensionless.

    Contacts that are less than a wave's way there and back apart are one impact; on a tool that is fed between blows,
    all contacts from one time that it is fed to the next.

    Attributes
    ----------
    start, end
        Of the contact, or of the first and the last contact; radians.
    contacts
        How many contacts.
    impulse
        J = ∫ N dt of all of them.
    centroid
        Time of the centroid of the contact force.
    velocity
        Of the rigid motion at the centroid, as it would be without the contact force (b77-blow's V). It tells little of
        an impact that lasts for a good part of a load period, such as a chatter that ends in rest.
    mean_before, mean_after
        Mean velocity of the striker when the contact starts and when it has ended.
    peak_force
        The greatest N.
    ringing_share
        Elastic energy when the contact has ended, over the striker's energy when it started.
    given
        ∫ N v dt at the struck face: the work done on what is struck.
    rock_work
        Work that the rock has kept by the next impact, ½ (1 − γ) K u_m²; 0 without rock.
    fed
        By how much the tool is fed after the impact; 0 of one that comes back to its place or is not fed.
    """

    start: Array
    end: Array
    contacts: npt.NDArray[np.int64]
    impulse: Array
    centroid: Array
    velocity: Array
    mean_before: Array
    mean_after: Array
    peak_force: Array
    ringing_share: Array
    given: Array
    rock_work: Array
    fed: Array

    @property
    def size(self) -> int:
        """How many impacts."""
        return self.start.size

    @property
    def phase(self) -> Array:
        """Of the load at the centroid, in [0, 2π)."""
        return np.asarray(self.centroid % _TURN % _TURN)

    @property
    def duration(self) -> Array:
        """From the start of the first contact to the end of the last."""
        return self.end - self.start

    @property
    def restitution(self) -> Array:
        """R of each impact, J/V − 1 with V at the centroid; NaN where V is not toward the struck face."""
        moving = self.velocity > 0.0
        return np.where(moving, self.impulse / np.where(moving, self.velocity, 1.0) - 1.0, math.nan)

    def part(self, which: slice | Array) -> Impacts:
        """Some of them."""
        return Impacts(*(getattr(self, one.name)[which] for one in fields(self)))


def impacts_of(
    contacts: npt.NDArray[np.void], load: Load, transit: float, tool: tuple[float, float] | None = None
) -> tuple[Impacts, int]:
    """The impacts that contacts make, and how many grazing contacts were left out.

    `tool`: of one that is fed, the work that the rock has kept at the end and by how much it has been fed by then.
    """
    impulses = contacts["impulse"]
    real = impulses > _GRAZE * impulses.max(initial=0.0)
    kept = contacts[real]
    first = np.ones(kept.size, dtype=bool)
    if tool is None:
        first[1:] = kept["start"][1:] - kept["end"][:-1] >= ROUND_TRIP * transit
    else:
        first[1:] = np.diff(kept["blow"]) > 0
    at = np.flatnonzero(first)
    last = np.append(at[1:], kept.size) - 1 if at.size else at
    summed = {name: _sums(values, at) for name, values in _summands(kept).items()}
    impulse = summed["impulse"]
    centroid = summed["moment"] / impulse
    start, before = kept["start"][at], kept["momentum_before"][at]
    fallen = load.mean * (centroid - start) + load.antiderivative(centroid) - load.antiderivative(start)
    energy, after = kept["energy_before"][at], kept["momentum_after"][last]
    hidden = kept["averaged_after"][last] - kept["averaged_before"][at]  # in cells that fronts divide
    elastic = kept["energy_after"][last] + hidden - 0.5 * after**2
    found = Impacts(
        start=start,
        end=kept["end"][last],
        contacts=last - at + 1,
        impulse=impulse,
        centroid=centroid,
        velocity=before + fallen,
        mean_before=before,
        mean_after=after,
        peak_force=np.maximum.reduceat(kept["peak"], at) if at.size else np.zeros(0),
        ringing_share=np.maximum(elastic, 0.0) / np.where(energy > 0.0, energy, math.inf),
        given=summed["given"],
        rock_work=_between(kept["rock_before"], at, tool and tool[0]),
        fed=_between(kept["advanced_before"], at, tool and tool[1]),
    )
    return found, int(np.count_nonzero(~real))


def _summands(contacts: npt.NDArray[np.void]) -> dict[str, Array]:
    return {
        "impulse": contacts["impulse"],
        "moment": contacts["moment"] + contacts["impulse"] * contacts["start"],
        "given": contacts["given"],
    }


def _between(before: Array, at: npt.NDArray[np.intp], last: float | None) -> Array:
    """By how much a sum grows from each impact to the next, and from the last to the end."""
    return np.diff(before[at], append=last) if last is not None and at.size else np.zeros(at.size)


def _sums(values: Array, at: npt.NDArray[np.intp]) -> Array:
    return np.add.reduceat(values, at) if at.size else np.zeros(0)
