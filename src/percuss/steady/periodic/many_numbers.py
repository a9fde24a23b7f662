"""det K(ξ) for many ξ at once: every mode is a pole of K(ξ) of rank two, which needs to be looked at only once.

With M_n the map of mode n through the cycle, r_j what the shift of impact j leaves of it a cycle later and R_i how its
state after the first impact moves the striking end over flight i, K(ξ) is A_0 + ξA_1 + Σ R_i (ξ − M_n)⁻¹ r_j, the
column of the first impact ξ times; and (ξ − M)⁻¹ = (ξ + adj)/det(ξ − M) for a 2×2 matrix.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from percuss.model.checks import Array, ComplexArray
from percuss.steady.periodic.impact_chain import ImpactChain
from percuss.steady.periodic.linearised import bordered
from percuss.steady.periodic.passage import Blocks, Passage

__all__ = ["ManyNumbers"]

_AWAY = 2.0  # a ξ that no mode has for an eigenvalue


class ManyNumbers(NamedTuple):
    """K(ξ) of one motion as a rational function of ξ, with the rigid velocity as an unknown more.

    Parameters
    ----------
    steady, turned
        A_0 and A_1; shapes (p + 1, p + 1).
    first, second
        γ_n R_i r_j and γ_n R_i adj(−M_n) r_j; shapes (N, p, p).
    blocks
        M_n.
    """

    steady: Array
    turned: Array
    first: Array
    second: Array
    blocks: Blocks

    @staticmethod
    def of(chain: ImpactChain, passage: Passage) -> ManyNumbers:
        """Of a motion whose times have the shape (p,)."""
        rows, columns, blocks = _rows(chain, passage), _columns(chain, passage), passage.blocks
        gamma = chain.known.gamma
        first = np.einsum("kin,kjn,n->nij", rows, columns, gamma)
        turned = np.stack(
            [-blocks.e * columns[0] + blocks.b * columns[1], blocks.c * columns[0] - blocks.a * columns[1]]
        )
        second = np.einsum("kin,kjn,n->nij", rows, turned, gamma)
        none = np.zeros((chain.impacts + 1, chain.impacts + 1))
        modes = ManyNumbers(none, none, first, second, blocks)
        ends = [bordered(chain, passage, xi) - modes.matrices(np.array([xi]))[0].real for xi in (_AWAY, -_AWAY)]
        return modes._replace(steady=0.5 * (ends[0] + ends[1]), turned=(ends[0] - ends[1]) / (2.0 * _AWAY))

    def matrices(self, xi: ComplexArray | Array) -> ComplexArray:
        """K(ξ) for an array of ξ, shape (m,); shape (m, p + 1, p + 1)."""
        xi = np.asarray(xi, dtype=complex)
        a, b, c, e = self.blocks
        weight = 1.0 / ((xi[:, None] - a) * (xi[:, None] - e) - b * c)
        p = self.steady.shape[0] - 1
        found: ComplexArray = np.asarray(self.steady + xi[:, None, None] * self.turned, dtype=complex)
        elastic = (xi[:, None] * weight) @ self.first.reshape(-1, p * p) + weight @ self.second.reshape(-1, p * p)
        elastic = elastic.reshape(-1, p, p)
        elastic[:, :, 0] *= xi[:, None]
        found[:, :p, :p] += elastic
        return found

    def directions(self, xi: ComplexArray | Array) -> ComplexArray:
        """det K(ξ) over its modulus; shape (m,)."""
        return np.asarray(np.linalg.slogdet(self.matrices(xi))[0])

    @property
    def poles(self) -> ComplexArray:
        """The eigenvalues of all M_n; shape (2N,)."""
        half = 0.5 * (self.blocks.a + self.blocks.e)
        root = np.sqrt((half**2 - (self.blocks.a * self.blocks.e - self.blocks.b * self.blocks.c)).astype(complex))
        return np.concatenate([half + root, half - root])


def _rows(chain: ImpactChain, passage: Passage) -> Array:
    """R_i: how u_n and u_n' after the first impact move the striking end over each flight; shape (2, p, N)."""
    alpha, beta = chain.system.contact.strain_factor, chain.system.contact.velocity_factor
    one, none = np.ones(chain.modes), np.zeros(chain.modes)
    u, v, found = (one, none), (none, one), np.empty((2, chain.impacts, chain.modes))
    for i in range(chain.impacts):
        a, b, c, e = (part[i] for part in passage.step[:4])
        for k in range(2):
            moved = a * u[k] + b * v[k]
            found[k, i] = moved - u[k] if chain.system.body.is_free else u[k]
        u, v = (
            tuple(alpha * (a * u[k] + b * v[k]) for k in range(2)),
            tuple(beta * (c * u[k] + e * v[k]) for k in range(2)),
        )
    return found


def _columns(chain: ImpactChain, passage: Passage) -> Array:
    """r_j: what the shift of each impact leaves of u_n and u_n' at the end of the cycle; shape (2, p, N)."""
    contact, known = chain.system.contact, chain.known
    alpha, beta = contact.strain_factor, contact.velocity_factor
    kick = (alpha - beta) * passage.velocity
    pull = (alpha - beta) * known.omega**2 * passage.displacement
    found = np.stack([kick, pull - contact.impulse * passage.force[:, None]])
    for i in range(1, chain.impacts):
        a, b, c, e = (part[i] for part in passage.step[:4])
        u, v = found[0, 1 : i + 1], found[1, 1 : i + 1]
        found[0, 1 : i + 1], found[1, 1 : i + 1] = alpha * (a * u + b * v), beta * (c * u + e * v)
    return found
