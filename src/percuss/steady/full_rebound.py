"""R = 1 and no damping: the motions under which the elastic modes would gain energy at every impact (theory §4).

Nothing takes energy then, so that a mode can only be periodic when its forced velocity f_n' vanishes at the impact. The
exception is a mode that swings a whole number of times between two impacts, ω_n T/(2π) = nπsm whole: it comes back by
itself, with any f_n'. With c_k = Re[ik p_k exp(ikφ)] the forced velocity is f_n' = Σ c_k/(ω_n² − k²), and for the
continuous bar under finitely many harmonics all of them vanish only if every c_k does: when the load is symmetric in
time about the impact.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model import System
from percuss.model.checks import Array, count, instance, numbers
from percuss.model.contact import restitutions
from percuss.steady.phases import forced_response

__all__ = ["grows"]

_DRIVEN = 1e-9  # share of the terms of f_n', and of a turn, below which it is rounding
_MOST = 1 << 14  # modes and periods
_MOST_UNDAMPED = 64  # modes looked at where only some are damped
_WHOLE = 64.0 * np.finfo(float).eps  # relative, as for resonance with the load


def grows(
    system: System,
    phases: npt.ArrayLike,
    periods: int = 1,
    *,
    modes: int | None = None,
    restitution: npt.ArrayLike | None = None,
) -> npt.NDArray[np.bool_]:
    """Where the elastic modes of an undamped bar that rebounds fully would gain energy at every impact.

    Such a root of B77 (14) is a motion of the rigid bar but none of the elastic one. The mean load does not matter.

    Parameters
    ----------
    system
        Gives s, d and the alternating part of the load.
    phases
        Impact phases in rad, of any shape; NaN where there is none.
    periods
        m.
    modes
        None for the continuous bar, or N for a bar of modes 0 … N.
    restitution
        R of each phase, which broadcasts with them; by default that of the system.

    Returns
    -------
    numpy.ndarray
        False where anything takes energy (R < 1, or every mode is damped), and for a contact law that turns the strain
        over; of the shape of `phases`.

    Examples
    --------
    >>> from percuss import Load, System, steady_states
    >>> system = System(s=20.0, d=0.0, restitution=1.0, load=Load.fourier([0.3, 1.0, 0.5j]))
    >>> motions = [orbit.phase for orbit in steady_states(system, modes=0).orbits]
    >>> grows(system, motions), grows(system, motions, modes=0)
    (array([ True,  True]), array([False, False]))
    """
    instance("system", system, System)
    m = count("periods", periods, most=_MOST)
    n = None if modes is None else count("modes", modes, least=0, most=_MOST)
    phase = numbers("phases", phases, "phases in rad, or NaN", nan=True)
    r = restitutions(system.restitution if restitution is None else restitution)
    try:
        contact, r = system.contact, np.broadcast_to(r, phase.shape)
    except ValueError:
        raise ParameterError("restitution", f"shape {r.shape}", f"numbers in a shape that fits {phase.shape}") from None
    lossless = (contact.velocity_factors(r) == -1.0) & (contact.strain_factors(r) == 1.0) & (system.d == 0.0)
    found = np.zeros(phase.shape, dtype=bool)
    asked = lossless & ~np.isnan(phase)
    if n != 0 and asked.any():
        here = phase[asked]
        found[asked] = _unsymmetric(system, here, m) if n is None else _driven(system, here, m, n)
    return found


def _lasting(system: System, periods: int, modes: int) -> npt.NDArray[np.bool_]:
    """Which of the elastic modes n = 1 … `modes` are undamped and do not come back by themselves."""
    known = system.body.modes(modes)
    swings = known.omega * periods
    return np.asarray((known.damping == 0.0) & (np.abs(swings - np.rint(swings)) > _WHOLE * swings))


def _driven(system: System, phases: Array, periods: int, modes: int) -> npt.NDArray[np.bool_]:
    """Whether f_n' ≠ 0 for any of the first `modes` modes that do not come back by themselves; shape (len(φ),)."""
    response = forced_response(system)
    rate = response.modal(modes, phases)[1]
    scale = response.modal_bounds(modes)[1]
    driven = np.abs(rate) > _DRIVEN * scale[:, None]
    return np.asarray(driven[_lasting(system, periods, modes)].any(axis=0))


def _unsymmetric(system: System, phases: Array, periods: int) -> npt.NDArray[np.bool_]:
    """Whether any mode gains energy: a smooth load does that when not symmetric about the impact; shape (len(φ),)."""
    load = system.load
    if not system.body.damping.is_zero:
        return _driven(system, phases, periods, _MOST_UNDAMPED)
    if system.body.is_harmonic and not _lasting(system, periods, 1)[0]:  # then every mode comes back
        return np.zeros(phases.shape, dtype=bool)
    if load.is_piecewise:  # f_n' ~ Σ jump_j cos n θ_j: as many n as there are jumps decide about all of them
        return _driven(system, phases, periods, 4 * len(load.breaks))
    k = load.harmonics
    terms = (1j * k * load.coefficients[k] * np.exp(1j * np.outer(phases, k))).real
    return np.asarray((np.abs(terms) > _DRIVEN * np.sum(k * np.abs(load.coefficients[k]))).any(axis=1))
