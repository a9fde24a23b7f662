"""Bodies that are held, in the terms of the kernels, which know a bar that moves as a whole.

The rigid motion of the kernels has no force, no speed and so no motion here: u_0 = −g for ever. The load reaches the
modes alone; the constant part of the load, which would push the bar as a whole, is taken into the place about which the
modes swing. Kernels use those places where a motion is put in and where it comes to rest. The first is made up for by a
shift of the start (`shifted`). At rest (the wall holds the contact, by complete chatter or an impact without rebound) a
structure of several modes goes on to move in ways that no law of impact says: a simulation ends there. One of one mode
stands still, and is let go by `held_release`. So that the kernels end both, the load that they see at the wall never
pulls. Whether a structure that does not rebound stays at the wall, they then ask its acceleration: they do so for any
rebound that is not exactly 0.
"""

from __future__ import annotations

import numpy as np

from percuss.model import HeldBody, System
from percuss.model.checks import Array
from percuss.simulate.kernels.layout import Table
from percuss.simulate.spectrum import units

__all__ = ["held_table", "shifted", "state_of"]

_FAINT = 2.0**-400  # what of the steps the rigid motion feels
_NO_REBOUND = 2.0**-1000
_RIPPLE = 1e-3  # of a radian of the one mode: how soon it is looked at again after a release


def held_table(table: Table, system: System) -> Table:
    """The table of a structure, from that of its modes; its `bar` is changed."""
    bar, load, harmonics = table.bar, system.load, table.harmonics
    bar["mean"], bar["pushing"], bar["force"] = 0.0, np.inf, abs(load.mean) + float(bar["force"])
    if table.modes.omega.size == 1:
        bar["damping"] = table.modes.damping[0]  # of no rigid motion, but by which a chatter ends
        bar["ripple"] = _RIPPLE / (1.0 + float(table.modes.omega[0]))
    silent = np.zeros_like(harmonics.load_re)
    quiet = harmonics._replace(load_re=silent, load_im=silent.copy())
    if not load.is_piecewise:
        return table._replace(harmonics=quiet)
    if not system.contact.rebounds:
        bar["restitution"] = _NO_REBOUND
    values = np.array(load.values)
    bar["force"] = float(np.abs(values).max())
    modes = table.modes._replace(statics=table.modes.statics / _FAINT)
    steps = _FAINT * (values + _lift(system))
    return table._replace(modes=modes, harmonics=quiet, breaks=np.array(load.breaks), values=steps)


def _lift(system: System) -> float:
    """What is added to steps so that the kernels see none that pulls."""
    return 2.0 * float(np.abs(system.load.values).max()) + 1.0


def shifted(system: System, modes: int, displacement: Array) -> Array:
    """u_n of starts as the kernels take them, whose places of rest are others; shape (starts, n)."""
    if system.body.is_free:
        return displacement
    elastic = system.body.modes(modes, system.load.at)
    still = elastic.gamma / (elastic.omega**2 * units(elastic))
    by = _lift(system) if system.load.is_piecewise else -system.load.mean
    found = np.zeros((displacement.shape[0], modes + 1))
    found[:, : displacement.shape[1]] = displacement[:, : modes + 1]
    found[:, 1:] += by * still
    return found


def state_of(body: HeldBody, at: int, modes: int, u: Array, v: Array, gap: Array) -> tuple[Array, Array]:
    """u_n and u_n', n = 0 … N, of starts of a structure; each of shape (starts, N + 1), u_0 = −g and u_0' = 0.

    Parameters
    ----------
    body, at, modes
        What moves, where the load acts, and N.
    u, v
        Given: rows of the modes 0 … N, of which the first numbers do not count; or rows of one number, for which the
        structure is bent by a force at its contact until this is at `gap` and moves with the speed v.
    gap
        Place of the contact, 0 at the wall, shape (starts,).
    """
    found = np.zeros((2, gap.size, modes + 1))
    if u.shape[1] == 1:
        shape = body.bent(modes, at)
        found[0, :, 1:] = (gap + body.gap)[:, None] * shape
        found[1, :, 1:] = v[:, :1] * shape
    else:
        for rows, given in zip(found, (u, v), strict=True):
            size = min(given.shape[1], modes + 1)
            rows[:, 1:size] = given[:, 1:size]
    found[0, :, 0] = -body.gap
    return found[0], found[1]
