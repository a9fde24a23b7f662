"""Warnings about a strong drag, and about elastic modes near resonance with the load or with the impacts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from percuss.steady.motion import Motion

__all__ = ["drag_warnings", "resonance_warnings"]

_STRONG_DRAG = 0.2  # part of the mean push from which on the drag at the striking speed is warned of
_AMPLIFIED = 10.0  # a mode that moves this many times its static (or typical) share is near resonance
_NOTICEABLE = 1e-3  # share of the stroke below which nobody needs to know
_UNAVOIDABLE = 1e-4  # share of the stroke that nobody is warned of where an impact changes the strain
_MOST = 5


def drag_warnings(motion: Motion) -> tuple[str, ...]:
    """A sentence where the drag at the striking speed is more than 20 % of the mean push."""
    if motion.system.d == 0.0:
        return ()
    share = motion.system.d * motion.rigid_velocity / motion.system.load.mean
    if share <= _STRONG_DRAG:
        return ()
    return (
        f"at the striking speed the damping drags the whole bar with {100.0 * share:.3g} % of the mean push; unless "
        "the machine really has such a drag, take less damping",
    )


def resonance_warnings(motion: Motion, stroke: float, proven: bool) -> tuple[str, ...]:
    """Sentences about modes that ring strongly, the strongest first, and about a tolerance that was not reached."""
    found = _load_resonances(motion, stroke) + _impact_resonances(motion, stroke)
    found.sort(key=lambda pair: -pair[0])
    texts = []
    if not proven:
        texts.append("whether the bar touches the wall between the impacts could not be proved within the work allowed")
    # what the release of strain sets ringing falls off so slowly that no number of modes reaches a fine tolerance
    least = 0.0 if motion.system.contact.keeps_strain else _UNAVOIDABLE
    if motion.requested_modes is None and motion.error_bound > max(motion.tolerance, least):
        texts.append(
            f"{motion.modes} modes leave a position error of up to {motion.error_bound:.1e} of the stroke "
            f"({motion.tolerance:.0e} was asked for)"
        )
    return (*texts, *(text for _, text in found[:_MOST]))


def _load_resonances(motion: Motion, stroke: float) -> list[tuple[float, str]]:
    load, body = motion.system.load, motion.system.body
    k = load.harmonics
    if not k.size:
        return []
    nearest = body.nearest(k)
    modes = body.modes(int(nearest.max()), load.at)
    omega, damping, coupling = (x[nearest - 1] for x in (modes.omega, modes.damping, np.abs(modes.gamma)))
    gain = omega**2 / np.abs(omega**2 - k**2 + 1j * k * damping)
    share = coupling * gain * np.abs(load.coefficients[k]) / omega**2 / stroke
    return [
        (
            float(share[i]),
            f"load harmonic k = {k[i]} lies {100 * (k[i] / omega[i] - 1):+.2g} % from elastic mode n = "
            f"{int(nearest[i])}: the mode's motion is amplified {gain[i]:.3g} times, "
            f"to {100 * share[i]:.2g} % of the stroke",
        )
        for i in np.flatnonzero((gain > _AMPLIFIED) & (share > _NOTICEABLE))
    ]


def _impact_resonances(motion: Motion, stroke: float) -> list[tuple[float, str]]:
    state, system = motion.state, motion.system
    modes = system.body.modes(state.omega.size, system.load.at)
    share = np.abs(modes.gamma) * state.amplitude / stroke
    typical = system.contact.impulse * np.abs(state.forced_velocity) / state.omega
    with np.errstate(divide="ignore", invalid="ignore"):
        gain = np.where(typical > 0.0, state.amplitude / typical, 0.0)
    rate = np.sqrt(np.maximum(state.omega**2 - 0.25 * modes.damping**2, 0.0)) * motion.periods
    found = [
        (
            float(share[i]),
            f"elastic mode n = {i + 1} rings near {int(np.rint(rate[i]))} times the blow rate: "
            f"amplified {gain[i]:.3g} times, to {100 * share[i]:.2g} % of the stroke",
        )
        for i in np.flatnonzero((gain > _AMPLIFIED) & (share > _NOTICEABLE))
    ]
    stuck = np.flatnonzero(state.divisor == 0.0)
    if stuck.size and not system.contact.is_lossless:
        text = f"elastic mode n = {stuck[0] + 1} is in exact resonance with the impacts: its amplitude is undetermined"
        found.append((np.inf, text))
    return found
