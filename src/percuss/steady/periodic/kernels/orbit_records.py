"""Where numbers stand in the arrays of the kernels."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

MEAN, PUSH, DRAG, ALPHA, BETA, FREE, GAP = range(7)
"""Of a system, first: p_0, and what of it pushes the body as a whole; d of that; α and β of the contact; whether the
body is free (1) or held (0), so that it has no motion as a whole; and the gap of one that is held."""
HEAD = 7
"""After these follow ω_n, d_n and γ_n, n = 1 … N, then k, Re p_k and Im p_k of K harmonics, or P breaks and values."""

# rows of `modal`: ω_n, d_n, γ_n, d_n/2, |ω_n² − d_n²/4|^½, whether it creeps, ω_n², and p_0/ω_n²
OMEGA, DAMPING, GAMMA, HALF_D, RATE, CREEPS, SQUARE, STATIC = range(8)
MODAL_ROWS = 8

# rows of `waves`: k, p_k, and what multiplies exp(ikt) in v_f and in its antiderivative
K, P_RE, P_IM, V_RE, V_IM, U_RE, U_IM = range(7)
WAVE_ROWS = 7

# rows of `steps`: where a piece begins, the force on it, its length, the force less the mean, v_f and its
# antiderivative at its begin
START, VALUE, LENGTH, PULL, KNOT_V, KNOT_U = range(6)
STEP_ROWS = 6

# rows of `impacts`: t_i, h_i, p(t_i), v_f and its antiderivative there, (1 − E_i)/d, E_i, the velocity of the bar as a
# whole just before and just after, the speed, and F_i
TIME, FLIGHT, FORCE, V_FORCED, U_FORCED, FADE, STAY, RIGID, REBOUND, SPEED, OFF = range(11)
IMPACT_ROWS = 11

# of each mode and impact: Φ_n(h_i), the state just before the impact, and the forced one
A, B, C, E, U, V, F, F_RATE = range(8)
CARRIED_ROWS = 8

# what holds for the motion as a whole
CLOSURE, RESONANCE = range(2)
WHOLE_ROWS = 2

GIVEN, RETURNING, BEST = range(3)
"""The mean velocity after the first impact: given; that which comes back; that which fits the wall best."""


class Room(NamedTuple):
    """The arrays in which one motion is computed; N modes, K harmonics or P steps, p impacts."""

    modal: npt.NDArray[np.float64]
    waves: npt.NDArray[np.float64]
    gains: npt.NDArray[np.float64]
    steps: npt.NDArray[np.float64]
    knots: npt.NDArray[np.float64]
    impacts: npt.NDArray[np.float64]
    carried: npt.NDArray[np.float64]
    turned: npt.NDArray[np.float64]
    numbers: npt.NDArray[np.float64]
    whole: npt.NDArray[np.float64]
    matrix: npt.NDArray[np.float64]
    solving: npt.NDArray[np.float64]
    rows: npt.NDArray[np.float64]
    now: npt.NDArray[np.float64]
    moved: npt.NDArray[np.float64]
    free: npt.NDArray[np.float64]
    spun: npt.NDArray[np.float64]
    stretch: npt.NDArray[np.float64]


def room_for(modes: int, waves: int, steps: int, impacts: int) -> Room:
    """Arrays of the sizes that are needed."""
    size, length = impacts + 2, HEAD + 3 * modes + (3 * waves or 2 * steps)
    return Room(
        modal=np.empty((MODAL_ROWS, modes)),
        waves=np.empty((WAVE_ROWS, waves)),
        gains=np.empty((2, modes, waves)),
        steps=np.empty((STEP_ROWS, steps)),
        knots=np.empty((2, modes, steps)),
        impacts=np.empty((IMPACT_ROWS, impacts)),
        carried=np.empty((CARRIED_ROWS, modes, impacts)),
        turned=np.empty((2, impacts, max(waves, 1))),
        numbers=np.empty(HEAD),
        whole=np.empty(WHOLE_ROWS),
        matrix=np.empty((size, size)),
        solving=np.empty((size, size + 1)),
        rows=np.empty((1, size)),
        now=np.empty(length),
        moved=np.empty(length),
        free=np.empty((8, modes)),
        spun=np.empty((6, waves)),
        stretch=np.empty(7),
    )
