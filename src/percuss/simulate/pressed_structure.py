"""A structure of several modes while the wall holds its contact: another linear system, until the wall were to pull.

The contact stands still, Σ q_n = g, by a force F of the wall on it; with modal masses m_n of the q_n,

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

from percuss.model import HeldBody, System
from percuss.model.checks import Array, ComplexArray
from percuss.simulate.spectrum import ModalMotion, Spectrum

Modal = tuple[Array, Array]

_TURN = 2.0 * np.pi
_EPS = 2.0**-52
_FADED = 1e-13  # of the force: what is left of the motion that decays no longer matters
_LOOKS = 100_000  # at the force, in one rest


@dataclass(frozen=True)
class Pressed:
    """The linear system of a structure whose contact the wall holds, under one form of its load."""

    spectrum: Spectrum

    @cached_property
    def _basis(self) -> tuple[Array, Array, Array]:
        """√m, the unit direction of the contact, and N − 1 directions across it, in coordinates √m q."""
        root = np.sqrt(self.spectrum.inertia)
        contact = 1.0 / root
        whole, _ = np.linalg.qr(np.column_stack([contact, np.eye(root.size)]))
        return root, contact, whole[:, 1:]

    @cached_property
    def _matrices(self) -> tuple[Array, Array]:
        """Damping and stiffness of the modes that are left, shape (N − 1, N − 1)."""
        *_, across = self._basis
        spectrum = self.spectrum
        return (across.T * spectrum.damping) @ across, (across.T * spectrum.omega**2) @ across

    @cached_property
    def _free(self) -> tuple[ComplexArray, ComplexArray]:
        """Exponents μ of the free motion and their columns (η, η′)."""
        damping, stiffness = self._matrices
        n = len(damping)
        exponents, columns = np.linalg.eig(np.block([[np.zeros((n, n)), np.eye(n)], [-stiffness, -damping]]))
        return exponents.astype(complex), columns.astype(complex)

    @cached_property
    def exponents(self) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Those of its free motion, and the matrices from q_n, q_n′ to their amounts, (2N − 2, N, 2), and back."""
        root, _, across = self._basis
        exponents, columns = self._free
        n, into = root.size, across.T * root
        begins = np.block([[into, np.zeros_like(into)], [np.zeros_like(into), into]])
        out = across / root[:, None]
        ends = np.block([[out, np.zeros_like(out)], [np.zeros_like(out), out]])
        forth = np.linalg.solve(columns, begins.astype(complex)).reshape(-1, 2, n).transpose(0, 2, 1)
        back = (ends @ columns).reshape(2, n, -1).transpose(1, 0, 2)
        return exponents, np.ascontiguousarray(forth), np.ascontiguousarray(back)

    def _still(self, mean: float) -> Array:
        """Where √m q is still under a constant load."""
        root, contact, across = self._basis
        body = self.spectrum.system.body
        assert isinstance(body, HeldBody)
        lies = body.gap * contact / (contact @ contact)
        push = root * self.spectrum.elastic.gamma * mean - self.spectrum.omega**2 * lies
        return np.asarray(lies + across @ np.linalg.solve(self._matrices[1], across.T @ push))

    @cached_property
    def _waves(self) -> ComplexArray:
        """Complex amplitude of √m q under each harmonic of the load; shape (K, N)."""
        root, _, across = self._basis
        (damping, stiffness), spectrum = self._matrices, self.spectrum
        push = across.T @ (root * spectrum.elastic.gamma)
        found = [
            across @ np.linalg.solve(stiffness + 1j * k * damping - k * k * np.eye(len(stiffness)), push * p)
            for k, p in zip(spectrum.k, spectrum.pk, strict=True)
        ]
        return np.array(found, dtype=complex).reshape(spectrum.k.size, spectrum.modes)

    def legs(self, phase: float, piece: int, state: Modal) -> Iterator[tuple[float, float, int, PressedMotion]]:
        """The motion from u_n and u_n′ on, from step to step of the load: begin, length and number of each, and it."""
        load, gone = self.spectrum.system.load, 0.0
        while load.is_piecewise:
            motion, after = self.motion(phase, piece, state), (piece + 1) % len(load.breaks)
            ahead = load.breaks[after] - phase
            ahead += _TURN if after == 0 and ahead < 0.0 else 0.0
            yield gone, ahead, piece, motion
            at = motion.at(np.array([ahead]))
            phase, piece, gone = load.breaks[after], after, gone + ahead
            state = at.displacement[:, 0], at.velocity[:, 0]
        yield gone, math.inf, piece, self.motion(phase, piece, state)

    def after(self, phase: float, piece: int, state: Modal, tau: Array) -> ModalMotion:
        """u_n and u_n′ at the times τ, ascending, after a state."""
        found = []
        for begin, length, _, motion in self.legs(phase, piece, state):
            found.append(motion.at(tau[(tau >= begin) & (tau < begin + length)] - begin))
            if not tau.size or tau[-1] < begin + length:
                break
        return ModalMotion(
            np.concatenate([part.displacement for part in found], axis=1),
            np.concatenate([part.velocity for part in found], axis=1),
        )

    def release(self, phase: float, piece: int, state: Modal, until: float) -> tuple[float, int, Modal]:
        """When the wall lets go, the step of the load then, and the state; as `PressedMotion.lets_go`."""
        slowest = -float(self._free[0].real.max(initial=-math.inf))
        patience = -math.log(_FADED) / slowest + 2.0 * _TURN if slowest > 0.0 else math.inf
        for begin, length, at, motion in self.legs(phase, piece, state):
            wait = motion.lets_go(min(length, until - begin))
            if wait < length or math.isnan(wait) or length == math.inf:
                there = motion.at(np.array([wait if wait < math.inf else 0.0]))
                return begin + wait, at, (there.displacement[:, 0], there.velocity[:, 0])
            if begin > patience:
                break
        return math.inf, piece, state

    def motion(self, phase: float, piece: int, state: Modal) -> PressedMotion:
        """The motion from u_n and u_n′ on, which the wall holds."""
        root, contact, across = self._basis
        spectrum, mean = self.spectrum, self.spectrum.mean(piece)
        still, turned = self._still(mean), np.exp(1j * spectrum.k * phase)
        u, v = (root * spectrum.unit * modes[1:] for modes in state)
        place = across.T @ (u - still - (turned @ self._waves).real)
        rate = across.T @ (v - ((1j * spectrum.k * turned) @ self._waves).real)
        exponents, columns = self._free
        amounts = np.linalg.solve(columns, np.concatenate([place, rate]).astype(complex))
        free = (across @ columns[: place.size]) * amounts  # √m q of each exponent, shape (N, 2N − 2)
        whole = contact @ contact
        pull = -(contact * spectrum.omega**2) / whole
        drag = -(contact * spectrum.damping) / whole
        driven = float(spectrum.elastic.gamma.sum()) / whole
        waves = (
            driven * spectrum.pk + self._waves @ pull + 1j * spectrum.k * (self._waves @ drag)
        ) * turned  # of the force
        return PressedMotion(
            self, turned, still, free, float(driven * mean + pull @ still), waves,
            pull @ free + exponents * (drag @ free),
        )  # fmt: skip


@dataclass(frozen=True)
class PressedMotion:
    """A motion of it from one moment on: √m q and the force of the wall, of a constant, harmonics and exponentials."""

    pressed: Pressed
    turned: ComplexArray
    still: Array
    free: ComplexArray
    steady: float
    waves: ComplexArray
    fading: ComplexArray

    def at(self, tau: Array) -> ModalMotion:
        """u_n and u_n′ at some times."""
        spectrum, (root, *_), (exponents, _) = self.pressed.spectrum, self.pressed._basis, self.pressed._free
        decay, k = np.exp(np.outer(exponents, tau)), spectrum.k
        waves = self.turned[:, None] * np.exp(1j * np.outer(k, tau))
        forced = self.pressed._waves.T
        place = self.still[:, None] + (forced @ waves).real + (self.free @ decay).real
        rate = (forced @ (1j * k[:, None] * waves)).real + (self.free @ (exponents[:, None] * decay)).real
        unit = (root * spectrum.unit)[:, None]
        first = np.full((1, tau.size), -getattr(spectrum.system.body, "gap", 0.0))
        return ModalMotion(np.vstack([first, place / unit]), np.vstack([np.zeros((1, tau.size)), rate / unit]))

    def force(self, tau: float) -> tuple[float, float]:
        """F and its rate."""
        exponents, k = self.pressed._free[0], self.pressed.spectrum.k
        waves, fading = self.waves * np.exp(1j * k * tau), self.fading * np.exp(exponents * tau)
        force = self.steady + float(waves.sum().real + fading.sum().real)
        return force, float((1j * k * waves).sum().real + (exponents * fading).sum().real)

    def lets_go(self, until: float) -> float:
        """When the force first turns to a pull, stepped under a parabola by F″'s bound; inf: never, NaN: open."""
        exponents, k = self.pressed._free[0], self.pressed.spectrum.k
        swing, sizes = float(np.abs(self.waves).sum()), np.abs(self.fading)
        bent, curves = float((k * k * np.abs(self.waves)).sum()), sizes * np.abs(exponents) ** 2
        least = 64.0 * _EPS * (abs(self.steady) + swing + float(sizes.sum()))
        tau, blind, known = 0.0, 1e-9, math.inf
        for _ in range(_LOOKS):
            left = np.exp(exponents.real * tau)
            remains = float(sizes @ left)
            if remains < _FADED * (abs(self.steady) + swing) and known == math.inf:
                known = tau + _TURN  # from then on it repeats itself
            if self.steady - swing > remains or tau > known:
                return math.inf
            if tau >= until:
                return until
            force, rate = self.force(tau)
            if force < -least or (force <= least and rate < 0.0):
                return tau
            if force <= least:  # a touch
                tau, blind = tau + blind, 2.0 * blind
                continue
            root = math.sqrt(rate * rate + 2.0 * (bent + float(curves @ left)) * force)
            step = 2.0 * force / (root - rate) if root > rate else math.inf
            tau, blind = tau + max(min(step, _TURN), _EPS * max(tau, 1.0)), 1e-9
        return math.nan


@lru_cache(maxsize=16)
def pressed(system: System, modes: int) -> Pressed:
    """The held system of a structure, kept for the next rest of it."""
    return Pressed(Spectrum(system, modes))
