"""A structure while the wall holds its contact: another linear system, as long as the wall has to push.

The contact stands still, Σ q_n = g, by a force F of the wall on it; with modal masses m_n of the q_n, each of which is
what mode n moves the contact by,

    q_n″ + d_n q_n′ + ω_n² q_n = γ_n p(t) − F/m_n,    F = Σ (γ_n p − d_n q_n′ − ω_n² q_n) / Σ 1/m_n.

What is left is a system of N − 1 modes, those of the structure with its contact held; they begin at rest in the shape
in which the impacts have left it, and the structure leaves where F turns from push to pull.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from percuss.model import HeldBody, Modes, System
from percuss.model.checks import Array, ComplexArray

Modal = tuple[Array, Array]
"""q_n and q_n′ of all modes, (N,) each, or (N, times)."""

_TURN = 2.0 * np.pi


@dataclass(frozen=True)
class HeldStructure:
    """The linear system of a structure of N modes whose contact the wall holds, under its load."""

    system: System
    modes: int

    @cached_property
    def known(self) -> Modes:
        """The modes of the structure itself."""
        return self.system.body.modes(self.modes, self.system.load.at)

    @cached_property
    def waves(self) -> tuple[Array, ComplexArray]:
        """Numbers k and amplitudes of the harmonics of the load; none of steps."""
        load = self.system.load
        k = load.harmonics[:0] if load.is_piecewise else load.harmonics
        return k.astype(float), np.asarray(load.coefficients[k])

    @cached_property
    def basis(self) -> tuple[Array, Array, Array]:
        """√m, the unit direction of the contact, and N − 1 directions across it, in coordinates √m q."""
        root = np.sqrt(self.known.inertia)
        contact = 1.0 / root
        whole, _ = np.linalg.qr(np.column_stack([contact, np.eye(root.size)]))
        return root, contact, whole[:, 1:]

    @cached_property
    def _matrices(self) -> tuple[Array, Array]:
        """Damping and stiffness of the modes that are left, shape (N − 1, N − 1)."""
        *_, across = self.basis
        return (across.T * self.known.damping) @ across, (across.T * self.known.omega**2) @ across

    @cached_property
    def free(self) -> tuple[ComplexArray, ComplexArray]:
        """Exponents μ of the free motion and their columns (η, η′)."""
        damping, stiffness = self._matrices
        n = len(damping)
        exponents, columns = np.linalg.eig(np.block([[np.zeros((n, n)), np.eye(n)], [-stiffness, -damping]]))
        return exponents.astype(complex), columns.astype(complex)

    @cached_property
    def exponents(self) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Those of its free motion, and the matrices from q_n, q_n′ to their amounts, (2N − 2, N, 2), and back."""
        root, _, across = self.basis
        exponents, columns = self.free
        n, into = root.size, across.T * root
        begins = np.block([[into, np.zeros_like(into)], [np.zeros_like(into), into]])
        out = across / root[:, None]
        ends = np.block([[out, np.zeros_like(out)], [np.zeros_like(out), out]])
        forth = np.linalg.solve(columns, begins.astype(complex)).reshape(-1, 2, n).transpose(0, 2, 1)
        back = (ends @ columns).reshape(2, n, -1).transpose(1, 0, 2)
        return exponents, np.ascontiguousarray(forth), np.ascontiguousarray(back)

    def lies(self, moved: Array) -> Array:
        """The q_n with the contact at the wall, and so much of √m q across it."""
        root, contact, across = self.basis
        body = self.system.body
        assert isinstance(body, HeldBody)
        return np.asarray((body.gap * contact / (contact @ contact) + across @ moved) / root)

    def still(self, mean: float) -> Array:
        """Where √m q is still under a constant load."""
        root, _, across = self.basis
        lies = root * self.lies(np.zeros(root.size - 1))
        push = root * self.known.gamma * mean - self.known.omega**2 * lies
        return np.asarray(lies + across @ np.linalg.solve(self._matrices[1], across.T @ push))

    @cached_property
    def response(self) -> ComplexArray:
        """Complex amplitude of √m q under each harmonic of the load; shape (K, N)."""
        root, _, across = self.basis
        damping, stiffness = self._matrices
        push = across.T @ (root * self.known.gamma)
        found = [
            across @ np.linalg.solve(stiffness + 1j * k * damping - k * k * np.eye(len(stiffness)), push * p)
            for k, p in zip(*self.waves, strict=True)
        ]
        return np.array(found, dtype=complex).reshape(-1, root.size)

    def legs(self, phase: float, piece: int, state: Modal) -> Iterator[tuple[float, float, int, HeldMotion]]:
        """The motion from a state on, from step to step of the load: begin, length and number of each, and it."""
        load, gone = self.system.load, 0.0
        while load.is_piecewise:
            motion, after = self.motion(phase, load.values[piece], state), (piece + 1) % len(load.breaks)
            ahead = load.breaks[after] - phase
            ahead += _TURN if after == 0 and ahead < 0.0 else 0.0
            yield gone, ahead, piece, motion
            u, v = motion.at(np.array([ahead]))
            phase, piece, gone, state = load.breaks[after], after, gone + ahead, (u[:, 0], v[:, 0])
        yield gone, math.inf, piece, self.motion(phase, load.mean, state)

    def after(self, phase: float, piece: int, state: Modal, tau: Array) -> Modal:
        """The motion at the times τ, ascending, after a state."""
        places, rates = [], []
        for begin, length, _, motion in self.legs(phase, piece, state):
            place, rate = motion.at(tau[(tau >= begin) & (tau < begin + length)] - begin)
            places.append(place)
            rates.append(rate)
            if not tau.size or tau[-1] < begin + length:
                break
        return np.concatenate(places, axis=1), np.concatenate(rates, axis=1)

    def motion(self, phase: float, mean: float, state: Modal) -> HeldMotion:
        """The motion from a state on, under the harmonics of the load about a mean, or a step of it."""
        root, contact, across = self.basis
        (k, p), known, still = self.waves, self.known, self.still(mean)
        turned = np.exp(1j * k * phase)
        u, v = (root * one for one in state)
        place = across.T @ (u - still - (turned @ self.response).real)
        rate = across.T @ (v - ((1j * k * turned) @ self.response).real)
        exponents, columns = self.free
        amounts = np.linalg.solve(columns, np.concatenate([place, rate]).astype(complex))
        free = (across @ columns[: place.size]) * amounts  # √m q of each exponent, shape (N, 2N − 2)
        whole = contact @ contact
        pull = -(contact * known.omega**2) / whole
        drag = -(contact * known.damping) / whole
        driven = float(known.gamma.sum()) / whole
        waves = (driven * p + self.response @ pull + 1j * k * (self.response @ drag)) * turned  # of the force
        return HeldMotion(
            self, turned, still, free, float(driven * mean + pull @ still), waves,
            pull @ free + exponents * (drag @ free),
        )  # fmt: skip


@dataclass(frozen=True)
class HeldMotion:
    """A motion of it from one moment on: √m q and the force of the wall, of a constant, harmonics and exponentials."""

    held: HeldStructure
    turned: ComplexArray
    lies: Array
    free: ComplexArray
    steady: float
    waves: ComplexArray
    fading: ComplexArray

    def at(self, tau: Array) -> Modal:
        """The motion at some times since."""
        (root, *_), (exponents, _), (k, _) = self.held.basis, self.held.free, self.held.waves
        decay = np.exp(np.outer(exponents, tau))
        waves = self.turned[:, None] * np.exp(1j * np.outer(k, tau))
        forced = self.held.response.T
        place = self.lies[:, None] + (forced @ waves).real + (self.free @ decay).real
        rate = (forced @ (1j * k[:, None] * waves)).real + (self.free @ (exponents[:, None] * decay)).real
        return place / root[:, None], rate / root[:, None]

    def force(self, tau: Array) -> tuple[Array, Array]:
        """F and its rate."""
        exponents, (k, _) = self.held.free[0], self.held.waves
        waves = self.waves[:, None] * np.exp(1j * np.outer(k, tau))
        fading = self.fading[:, None] * np.exp(np.outer(exponents, tau))
        rate = (1j * k) @ waves + exponents @ fading
        return self.steady + (waves.sum(axis=0) + fading.sum(axis=0)).real, rate.real


@lru_cache(maxsize=16)
def held_structure(system: System, modes: int) -> HeldStructure:
    """That of a system, kept for the next rest of it."""
    return HeldStructure(system, modes)
