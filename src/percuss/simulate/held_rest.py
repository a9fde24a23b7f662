"""How a structure lies on the wall where its simulation ends: its velocities gone, its shape that of the last impact.

Infinitely many impacts, or one without rebound, take every velocity and leave the shape as it is. The kernels know the
rest of a bar, which is undeformed.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from percuss.simulate.engine import Stretch
from percuss.simulate.events import CHATTER, IMPACT
from percuss.simulate.spectrum import Spectrum

__all__ = ["laid_down"]


def laid_down(spectrum: Spectrum, stretch: Stretch) -> Stretch:
    """The end of a stretch of simulation, with the shape and the energies of a structure; that of a bar as it is."""
    events = stretch.events
    struck = np.flatnonzero(events.code == IMPACT)
    if spectrum.system.body.is_free or stretch.outcome != "rest" or not struck.size:
        return stretch
    last, n = int(struck[-1]), spectrum.modes
    states, lost = stretch.states.copy(), events.energy_lost.copy()
    row = states[last]
    z = np.stack([row[2 : 2 + n], row[2 + n :]])
    at = float(events.phase[last])
    shape, _ = spectrum.modal(z, 0.0, 0.0, at, spectrum.mean(int(events.piece[last])))
    left = spectrum.system.contact.velocity_factor**2 * float(events.kinetic_energy[last])
    before = float(lost[last + 1 :].sum())
    for i in range(last + 1, len(events)):
        mean = spectrum.mean(int(events.piece[i]))
        states[i, :2] = 0.0
        states[i, 2:] = spectrum.amplitudes(shape, np.zeros_like(shape), float(events.phase[i]), mean).reshape(-1)
        lost[i] = left if events.code[i] == CHATTER or i == last + 1 else 0.0
    snapshot = stretch.snapshot.copy()
    snapshot.sums["taken"][0] += float(lost[last + 1 :].sum()) - before
    return replace(stretch, events=replace(events, energy_lost=lost), states=states, snapshot=snapshot)
