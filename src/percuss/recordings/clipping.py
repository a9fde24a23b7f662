"""Whether a record stays at its highest or lowest value, as where a sensor or a recorder has reached its limit."""

from __future__ import annotations

import numpy as np

from percuss.recordings.arrays import Array

__all__ = ["clipped_share"]

_NEAR = 0.02  # of the range: what a rounded peak passes through …
_LEAST = 0.005  # share of the samples below which clipping is of no account


def clipped_share(values: Array) -> tuple[float, float]:
    """The shares of the samples that lie exactly at the lowest and at the highest value, where these look like limits.

    A rounded peak that is recorded in steps has several equal samples at its top too, but more of them in the steps
    next to it: its width grows with the root of the depth. A limit is therefore told from the samples within 2 % of the
    range (4 steps, if that is more) next to the highest value: where they are fewer than those at it, and those come
    three and more in a row, the record is cut off there. A record of two values only is a square wave, and is not.
    """
    low, high = float(np.min(values)), float(np.max(values))
    levels = np.unique(values)
    if levels.size < 3:
        return 0.0, 0.0
    at = [int(np.count_nonzero(values == limit)) for limit in (low, high)]
    if sum(at) > 0.9 * values.size:
        return 0.0, 0.0
    step = float(np.min(np.diff(levels)))
    width = max(_NEAR * (high - low), 4.0 * step)
    near = [int(np.count_nonzero(near)) for near in (values <= low + width, values >= high - width)]
    shares = [0.0, 0.0]
    for i, limit in enumerate((low, high)):
        runs = np.flatnonzero(np.diff(np.concatenate([[0], (values == limit).astype(int), [0]])))
        lengths = runs[1::2] - runs[::2]
        if at[i] > max(near[i] - at[i], _LEAST * values.size) and np.median(lengths) >= 3:
            shares[i] = at[i] / values.size
    return shares[0], shares[1]
