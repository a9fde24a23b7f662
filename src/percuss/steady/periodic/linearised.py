"""The linearised motion through p impacts, as p equations for the shifts of their times (theory: several impacts).

With ρ the change of a mode's state at fixed times and δt_i the shift of impact i, a cycle later ξ times both,

    ρ_{i+1} = D Φ(h_i) ρ_i + s_{i+1} δt_{i+1},   s = Dẋ⁻ − ẋ⁺ = ((α − β) v⁻, (α − β) ω² u⁻ − (1 − β) p),

the saltation (Leine & Nijmeijer, Dynamics and Bifurcations of Non-Smooth Mechanical Systems, 2004, ch. 7). Every mode
is eliminated, one 2×2 solve for each shift; that the striking end comes back to the wall over each flight is then
K(ξ) δt = 0 (of a body that is held: that it is there at each impact). K(1) is the derivative of the equations for the
times, and nothing is divided by the speed of an impact, so that all stays finite where one dies.
"""

from __future__ import annotations

import numpy as np

from percuss.steady.periodic.impact_chain import ImpactChain
from percuss.steady.periodic.passage import Blocks, Numbers, Passage, solved

__all__ = ["bordered", "eliminated"]

_NUMBERS = 1 << 20  # in an array of a sweep


def bordered(chain: ImpactChain, passage: Passage, xi: complex) -> Numbers:
    """K(ξ) with the change of the rigid velocity after the first impact as an unknown more, which comes last.

    The last row says that it is ξ times itself after a cycle. Shape (…, p + 1, p + 1).
    """
    p, beta, is_free = chain.impacts, chain.system.contact.velocity_factor, chain.system.body.is_free
    kind = complex if isinstance(xi, complex) else float
    found: Numbers = np.zeros((*passage.times.shape[:-1], p + 1, p + 1), dtype=kind)
    width = max(1, _NUMBERS // (passage.times.size * p))
    for first in range(0, chain.modes, width):
        found[..., :p, :p] = found[..., :p, :p] + _elastic(chain, passage, xi, slice(first, first + width))
    if not is_free:
        for i in range(p):
            found[..., i, i] += beta * passage.speed[..., i]
        found[..., p, p] = -1.0
        return found
    jump = -chain.system.contact.impulse * passage.force
    rate: Numbers = np.zeros((*passage.times.shape[:-1], p + 1), dtype=kind)  # of the rigid velocity, by each unknown
    rate[..., p] = 1.0
    for i in range(p):
        found[..., i, :] += passage.fade[..., i, None] * rate
        rate = beta * passage.stay[..., i, None] * rate
        to, turned = (i + 1, 1.0) if i + 1 < p else (0, xi)
        rate[..., to] = rate[..., to] + turned * jump[..., to]
        found[..., i, i] -= beta * passage.speed[..., i]
        found[..., i, to] += turned * passage.speed[..., to]
    found[..., p, :] = rate
    found[..., p, p] -= xi
    return found


def eliminated(matrix: Numbers) -> Numbers:
    """K(ξ) itself, shape (…, p, p), of the bordered matrix."""
    corner = matrix[..., -1:, -1:]
    return np.asarray(matrix[..., :-1, :-1] - matrix[..., :-1, -1:] * matrix[..., -1:, :-1] / corner)


def _elastic(chain: ImpactChain, passage: Passage, xi: complex, some: slice) -> Numbers:
    """What some of the elastic modes add to K(ξ): how each flight (row) moves the striking end per shift (column).

    Sweep by sweep with arrays of the shape (…, shifts, modes): first from nothing, then from the state that is ξ times
    itself after a cycle.
    """
    p, contact, known = chain.impacts, chain.system.contact, chain.known
    alpha, beta, gamma = contact.strain_factor, contact.velocity_factor, known.gamma[some]
    kick = (alpha - beta) * passage.velocity[..., some]
    pull = (alpha - beta) * known.omega[some] ** 2 * passage.displacement[..., some]
    kick_rate = pull - contact.impulse * passage.force[..., None]
    shape = (*passage.times.shape[:-1], p, gamma.size)
    u: Numbers = np.zeros(shape, dtype=complex if isinstance(xi, complex) else float)
    v: Numbers
    found: Numbers
    v, found = np.zeros_like(u), np.zeros((*shape[:-1], p), dtype=u.dtype)
    for last in (False, True):
        for i in range(p):
            a, b, c, e = (part[..., i, None, some] for part in passage.step[:4])
            start = u @ gamma if last else 0.0
            u, v = a * u + b * v, c * u + e * v
            if last:
                found[..., i, :] = u @ gamma - start if chain.system.body.is_free else start
            u, v = alpha * u, beta * v
            to, turned = (i + 1, 1.0) if i + 1 < p else (0, xi)
            u[..., to, :] = u[..., to, :] + turned * kick[..., to, :]
            v[..., to, :] = v[..., to, :] + turned * kick_rate[..., to, :]
        if not last:
            u, v = solved(Blocks(*(part[..., None, some] for part in passage.blocks)), xi, u, v)
    return found
