"""The bounds of a flight that stand in a saved state, computed again to see whether they are true."""

from __future__ import annotations

from percuss.simulate.kernels.compiled import entry
from percuss.simulate.kernels.modes import amplitudes


@entry
def bounded(bar, modes, z, now):
    """What is known of the free motion from its amplitudes, into `now`."""
    amplitudes(bar, modes, z, now)
