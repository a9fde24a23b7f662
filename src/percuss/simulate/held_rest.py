"""How a structure lies on the wall: its velocities gone, its shape that of the last impact.

Infinitely many impacts, or one without rebound, take every velocity and leave the shape as it is. The kernels know the
rest of a bar, which is undeformed.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from percuss.model.checks import Array
from percuss.simulate.engine import Stretch
from percuss.simulate.events import CHATTER, IMPACT
from percuss.simulate.kernels.bounds import bounded
from percuss.simulate.kernels.layout import Table
from percuss.simulate.snapshot import Snapshot
from percuss.simulate.spectrum import Spectrum

__all__ = ["laid_down"]


def laid_down(spectrum: Spectrum, table: Table, before: Snapshot, stretch: Stretch) -> Stretch:
    """The end of a stretch of simulation, with the shape and the energies of a structure; that of a bar as it is.

    `before`: where the stretch began. Without rebound there is no chatter, whatever the kernels say (`held_table`).
    """
    system = spectrum.system
    if system.body.is_free or stretch.outcome != "rest":
        return stretch
    snapshot = stretch.snapshot.copy()
    events, states, lost = stretch.events, stretch.states, stretch.events.energy_lost.copy()
    struck = np.flatnonzero(events.code == IMPACT)
    last, left = (int(struck[-1]), 0.0) if struck.size else (-1, 0.0)
    if struck.size:
        left = system.contact.velocity_factor**2 * float(events.kinetic_energy[last])
    shape = _shape(spectrum, before, stretch, last)
    taken, states = float(lost[last + 1 :].sum()), states.copy()
    for i in range(last + 1, len(events)):
        mean = spectrum.mean(int(events.piece[i]))
        states[i, :2] = 0.0
        states[i, 2:] = spectrum.amplitudes(shape, np.zeros_like(shape), float(events.phase[i]), mean).reshape(-1)
        lost[i] = left if i == last + 1 else 0.0
    if last + 1 < len(events):
        snapshot.z[:] = states[-1, 2:].reshape(2, -1)
        bounded(table.bar, table.modes, snapshot.z, snapshot.now[0])
    snapshot.sums["taken"][0] += float(lost[last + 1 :].sum()) - taken
    events = replace(events, energy_lost=lost)
    if not system.contact.rebounds:
        kept = events.code != CHATTER
        events, states = events[kept], states[kept]
        snapshot.count["chatters"] = snapshot.count["mark_chatters"] = 0
    return replace(stretch, events=events, states=states, snapshot=snapshot)


def _shape(spectrum: Spectrum, before: Snapshot, stretch: Stretch, last: int) -> Array:
    """u_n in which the structure lies: of one mode told by the gap, of several as it was struck last."""
    body = spectrum.system.body
    if spectrum.modes == 1:
        return np.array([-body.gap, body.gap / float(spectrum.unit[0])])
    if last >= 0:
        z, phase, piece = stretch.states[last, 2:], stretch.events.phase[last], stretch.events.piece[last]
    else:
        z, phase, piece = before.z, before.now["phase"][0], before.count["piece"][0]
    shape, _ = spectrum.modal(z.reshape(2, -1), 0.0, 0.0, float(phase), spectrum.mean(int(piece)))
    return np.asarray(shape)
