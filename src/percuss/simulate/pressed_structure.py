"""When a structure of several modes, whose contact the wall holds, leaves it: where the wall would have to pull."""

from __future__ import annotations

import math

import numpy as np

from percuss.mechanics.held_structure import HeldMotion, HeldStructure, Modal

_TURN = 2.0 * np.pi
_EPS = 2.0**-52
_FADED = 1e-13  # of the force: what is left of the motion that decays no longer matters
_LOOKS = 100_000  # at the force, in one rest


def release(held: HeldStructure, phase: float, piece: int, state: Modal, until: float) -> tuple[float, int, Modal]:
    """When the wall lets go, the step of the load then, and the state; as `_lets_go`."""
    slowest = -float(held.free[0].real.max(initial=-math.inf))
    patience = -math.log(_FADED) / slowest + 2.0 * _TURN if slowest > 0.0 else math.inf
    for begin, length, at, motion in held.legs(phase, piece, state):
        wait = _lets_go(motion, min(length, until - begin))
        if wait < length or math.isnan(wait) or length == math.inf:
            u, v = motion.at(np.array([wait if wait < math.inf else 0.0]))
            return begin + wait, at, (u[:, 0], v[:, 0])
        if begin > patience:
            break
    return math.inf, piece, state


def _lets_go(motion: HeldMotion, until: float) -> float:
    """When the force first turns to a pull, stepped under a parabola by F″'s bound; inf: never, NaN: open."""
    exponents, (k, _) = motion.held.free[0], motion.held.waves
    swing, sizes = float(np.abs(motion.waves).sum()), np.abs(motion.fading)
    bent, curves = float((k * k * np.abs(motion.waves)).sum()), sizes * np.abs(exponents) ** 2
    least = 64.0 * _EPS * (abs(motion.steady) + swing + float(sizes.sum()))
    tau, blind, known = 0.0, 1e-9, math.inf
    for _ in range(_LOOKS):
        left = np.exp(exponents.real * tau)
        remains = float(sizes @ left)
        if remains < _FADED * (abs(motion.steady) + swing) and known == math.inf:
            known = tau + _TURN  # from then on it repeats itself
        if motion.steady - swing > remains or tau > known:
            return math.inf
        if tau >= until:
            return until
        force, rate = (float(one[0]) for one in motion.force(np.array([tau])))
        if force < -least or (force <= least and rate < 0.0):
            return tau
        if force <= least:  # a touch
            tau, blind = tau + blind, 2.0 * blind
            continue
        root = math.sqrt(rate * rate + 2.0 * (bent + float(curves @ left)) * force)
        step = 2.0 * force / (root - rate) if root > rate else math.inf
        tau, blind = tau + max(min(step, _TURN), _EPS * max(tau, 1.0)), 1e-9
    return math.nan
