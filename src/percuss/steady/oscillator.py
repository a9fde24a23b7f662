"""The elastic modes of a steady motion: sums of free oscillators, exact resonance, the state at the impact."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from percuss.errors import ResonanceError
from percuss.halting import check_interrupted
from percuss.mechanics.flow import Propagator, one_for_all, propagator
from percuss.model import Body, HeldBody, Load, Modes, System
from percuss.model.checks import Array, ComplexArray
from percuss.model.load import MAX_HARMONICS

_CHUNK = 1 << 20  # modes × times handled at once
_EVEN = 48  # times at one distance from which on products of exponentials are quicker than exponentials
_TURNS = 4.0 * math.pi  # times since a step of the load are as exact as the phases, up to here, that they come from
_MUCH = 1 << 13  # modes × times from which on it is worth while to look whether they are


@lru_cache(maxsize=8)
def flights(body: Body, at: int, period: float, modes: int) -> tuple[Modes, Propagator]:
    """The elastic modes n = 1 … `modes` and their propagators over one period, each of shape (modes,)."""
    # The last few are kept: they are the same for every load at the place number `at`, phase and contact law.
    known = body.modes(modes, at)
    step = propagator(known.omega, known.damping, period)
    for values in step:
        values.setflags(write=False)
    return known, step


def free_sum(omega: Array, d: npt.ArrayLike, start: tuple[Array, Array], t: Array, rows: Array) -> tuple[Array, Array]:
    """Σ_n rows[i, n] z_n(t) and its rate, (ni, nt), of free oscillators that begin at `start` = z_n, z_n'."""
    modes, half_d = rows.shape[1], 0.5 * one_for_all(d)
    half_d = half_d[:modes] if half_d.ndim else half_d
    omega, z, v = omega[:modes], start[0][:modes], start[1][:modes]
    ringing = omega > half_d * (1.0 + 1e-3)  # the others do not oscillate, or nearly so
    if ringing.all():
        both = _ringing_sum(omega, half_d, (z, v), t, rows)
    else:
        half_d = np.broadcast_to(half_d, omega.shape)
        both = _ringing_sum(omega[ringing], half_d[ringing], (z[ringing], v[ringing]), t, rows[:, ringing])
        slow = ~ringing
        both += _creeping_sum(omega[slow], 2.0 * half_d[slow], (z[slow], v[slow]), t, rows[:, slow])
    return both[: rows.shape[0]], both[rows.shape[0] :]


def _ringing_sum(omega: Array, half_d: Array, start: tuple[Array, Array], t: Array, rows: Array) -> Array:
    """`free_sum` of modes that oscillate; the sum and its derivative, shape (2 ni, nt)."""
    z, v = start
    rate = np.sqrt(omega**2 - half_d**2)
    exponent = -half_d + 1j * rate
    turned = rows * (z - 1j * (v + half_d * z) / rate)
    weights = np.concatenate([turned, turned * exponent])
    much = rate.size * t.size >= _MUCH
    return _even_sum(weights, exponent, t) if much and _is_even(t) else _plain_sum(weights, exponent, t)


def _creeping_sum(omega: Array, d: Array, start: tuple[Array, Array], t: Array, rows: Array) -> Array:
    """The same of modes that do not oscillate, or nearly so."""
    z, v = start[0][:, None], start[1][:, None]
    both = np.empty((2 * rows.shape[0], t.size))
    width = max(1, _CHUNK // omega.size)
    for i in range(0, t.size, width):
        check_interrupted()
        step = propagator(omega[:, None], d[:, None], t[None, i : i + width])
        both[: rows.shape[0], i : i + width] = rows @ (step.a * z + step.b * v)
        both[rows.shape[0] :, i : i + width] = rows @ (step.c * z + step.e * v)
    return both


def _plain_sum(weights: ComplexArray, exponent: ComplexArray, t: Array) -> Array:
    """Re Σ_n w_in exp(e_n t), time by time; shape (ni, nt)."""
    both = np.empty((weights.shape[0], t.size))
    width = max(1, _CHUNK // max(1, exponent.size))
    for i in range(0, t.size, width):
        check_interrupted()
        both[:, i : i + width] = (weights @ np.exp(np.outer(exponent, t[i : i + width]))).real
    return both


def _is_even(t: Array) -> bool:
    """Whether so many times follow each other at one distance that `_even_sum` is worth while."""
    if t.size < _EVEN:
        return False
    step = (t[-1] - t[0]) / (t.size - 1)
    off = np.abs(t - (t[0] + step * np.arange(t.size))).max()
    return bool(off <= 4.0 * np.finfo(float).eps * max(abs(float(t[0])), abs(float(t[-1])), _TURNS))


def _even_sum(weights: ComplexArray, exponent: ComplexArray, t: Array) -> Array:
    """`_plain_sum` at times of one distance as a matrix product, exp(e(t + τ)) = exp(et) exp(eτ): 20 times faster."""
    fine = math.isqrt(t.size - 1) + 1
    coarse = -(-t.size // fine)
    step = (t[-1] - t[0]) / (t.size - 1)
    near = np.exp(np.outer(exponent, step * np.arange(fine)))
    both = np.zeros((weights.shape[0], coarse * fine))
    width = max(1, _CHUNK // (weights.shape[0] * coarse))
    for i in range(0, exponent.size, width):
        check_interrupted()
        part = slice(i, i + width)
        far = np.exp(np.outer(t[0] + step * fine * np.arange(coarse), exponent[part]))
        turned = (weights[:, None, part] * far).reshape(-1, far.shape[1])
        # Re of a product, as real products: half the work of the complex one
        both += (turned.real @ near[part].real - turned.imag @ near[part].imag).reshape(both.shape)
    return both[:, : t.size]


# ---- Exact resonance: of an undamped bar with a harmonic that its load contains (B77 16), of a mode with the impacts

IntArray = npt.NDArray[np.int64]

_EXACT = 64.0 * np.finfo(float).eps
_EXACT_BEYOND = 8.0 * np.finfo(float).eps  # for harmonics so high that many of them lie near some frequency
_MODES = 4096  # the most that any sum takes
_TURNED = 4.0 * np.finfo(float).eps  # error of the angle of a mode over a cycle, relative
_CANCELLED = 8.0 * np.finfo(float).eps  # share of the terms of det(ξ − M_n) that is rounding


def comes_back(
    divisor: npt.ArrayLike, terms: npt.ArrayLike, angle: npt.ArrayLike, factor: npt.ArrayLike
) -> npt.NDArray[np.bool_]:
    """Which modes come back after a cycle by themselves, so that their amplitude is free: internal resonance."""
    # `divisor` is det(ξ − M_n) with the map M_n of the mode over a cycle, `terms` what it was found from (how far the
    # flights are from half turns of the mode, |cos − (±1)| and sin²), `angle` ω_n T, which is known to four units in
    # its last place, and det(ξ − M_n) grows from 0 at most by `factor` times the square of a change of the angle.
    turned = 2.0 * np.asarray(factor) * (_TURNED * np.asarray(angle)) ** 2
    return np.asarray(np.abs(divisor) <= _CANCELLED * np.asarray(terms) + turned)


def refuse_resonance(system: System) -> None:
    """ResonanceError when an undamped mode is driven at its own frequency; for a uniform bar s = k/(nπ)."""
    # A load of steps contains harmonics without end: all up to 4096 are looked at, and those that the first 4096 modes
    # could meet, or all of a structure. That the load may act at a node of the mode is not looked at.
    body, load = system.body, system.load
    if system.d > 0.0 or load.is_constant:
        return
    if load.is_piecewise:
        k, exact = _of_steps(body.frequencies(body.most_modes if isinstance(body, HeldBody) else _MODES))
    else:
        k, exact = load.harmonics, np.full(load.harmonics.shape, _EXACT)
    n = body.nearest(k)
    for i in _met(k, body.frequency(n), exact):
        driven = not load.is_piecewise or _contains(load, float(k[i]))
        if driven and body.dampings(int(n[i]))[-1] == 0.0:
            raise ResonanceError(int(k[i]), int(n[i]))


def held_resonance(load: Load, fundamental: float) -> bool:
    """Whether steps contain a frequency (n − ½)ω_1 of an undamped uniform bar whose end is held, as at the wall."""
    k, exact = _of_steps(np.asarray(fundamental * (np.arange(1, _MODES + 1) - 0.5)))
    n = np.maximum(np.rint(k / fundamental + 0.5), 1.0)
    return any(_contains(load, float(k[i])) for i in _met(k, (n - 0.5) * fundamental, exact))


def _of_steps(frequencies: Array) -> tuple[IntArray, Array]:
    """The harmonics of a load of steps that are looked at, and how near each must come to a frequency."""
    k = np.concatenate([np.arange(1, MAX_HARMONICS + 1), np.rint(frequencies).astype(np.int64)])
    k = k[k >= 1]
    return k, np.where(k <= MAX_HARMONICS, _EXACT, _EXACT_BEYOND)


def _met(k: IntArray, frequency: Array, exact: Array) -> list[int]:
    """Which of the harmonics k meet a frequency, by increasing k."""
    met = np.flatnonzero(np.abs(k - frequency) <= exact * frequency)
    return [int(i) for i in met[np.argsort(k[met], kind="stable")]]


def _contains(load: Load, k: float) -> bool:
    """Whether the jumps of steps leave anything of harmonic k but rounding."""
    jumps = load.jumps
    terms = np.array([(jump.after - jump.before) * np.exp(-1j * k * jump.phase) for jump in jumps])
    return bool(abs(terms.sum()) > 8.0 * np.finfo(float).eps * (1.0 + k) * np.abs(terms).sum())


# ---- The state of the elastic modes at the impact of a steady motion (B77 12, 13; theory §4)
#
# With D = diag(α, β) of the contact law, β = −R, and Φ the propagator over the impact period T, the transient just
# after the impact is z = (I − DΦ)⁻¹(D − I) f, and the state just before it x = (I − ΦD)⁻¹(I − Φ) f; with α = 1 the
# velocity is f' det(I − Φ)/det(I − DΦ), and the displacement the same before and after.


@dataclass(frozen=True)
class ModalState:
    """Elastic modes n = 1 … N at the impact; every array of shape (N,), dimensionless.

    Parameters
    ----------
    omega
        Undamped frequencies ω_n.
    displacement, velocity
        u_n and u_n' just before the impact.
    rebound
        u_n just after the impact: the contact law's α times `displacement`.
    z, z_velocity
        Transient part (u_n − f_n, u_n' − f_n') just after the impact.
    forced_velocity
        f_n' at the impact phase.
    divisor
        det(I − DΦ): how near the mode is to resonance with the impacts (0 = resonant).
    """

    omega: Array
    displacement: Array
    velocity: Array
    rebound: Array
    z: Array
    z_velocity: Array
    forced_velocity: Array
    divisor: Array

    @property
    def amplitude(self) -> Array:
        """Bound of |z_n(t)| for all t ≥ 0, because the energy of a free oscillation never grows; shape (N,)."""
        return np.asarray(np.hypot(self.z, self.z_velocity / self.omega))

    def first(self, modes: int) -> ModalState:
        """The first `modes` of the modes; itself when it has no more."""
        if modes >= self.omega.size:
            return self
        return ModalState(*(getattr(self, name)[:modes] for name in self.__dataclass_fields__))


def modal_state(system: System, period: float, forced: tuple[Array, Array]) -> ModalState:
    """Solve the steady condition mode by mode, for impacts every T = `period`, from f_n and f_n' at the impact."""
    (f, f_velocity), contact = forced, system.contact
    alpha, beta, impulse = contact.strain_factor, contact.velocity_factor, contact.impulse
    released = 1.0 - alpha  # 0 for the law that keeps the strain
    modes, step = flights(system.body, system.load.at, period, f.size)
    omega, d = modes.omega, modes.damping
    loss = -np.expm1(-0.5 * d * period)  # 1 − exp(−dT/2)
    half_d_b = 0.5 * d * step.b
    still = loss**2 + 2.0 * step.versine  # det(I − Φ)
    kept = loss * (1.0 - beta * step.half) + (1.0 + beta) * step.versine - impulse * half_d_b  # det(I − DΦ) for α = 1
    divisor = kept + released * (step.a - beta * step.half**2)
    one_minus_a = loss + step.versine - half_d_b
    singular = comes_back(divisor, 0.0, omega * period, 1.0 + beta)  # only without damping
    safe = np.where(singular, 1.0, divisor)
    push = -impulse * f_velocity
    # an undamped mode in exact resonance with the impacts only fixes its velocity
    z = (push * step.b * alpha - released * (1.0 - beta * step.e) * f) / safe
    z = np.where(singular, 0.0, z)
    z_velocity = (push * (one_minus_a + released * step.a) - released * beta * step.c * f) / safe
    z_velocity = np.where(singular, -f_velocity, z_velocity)
    velocity = f_velocity * (still + released * (step.a - step.half**2)) - released * step.c * f
    velocity = np.where(singular, 0.0, velocity / safe)
    displacement = np.where(singular, f, f * (kept / safe) + push * step.b / safe)
    return ModalState(omega, displacement, velocity, f + z, z, z_velocity, f_velocity, divisor)


# ---- What modes beyond the last one kept may add where they are hardly damped: sums over small divisors (theory §4)
#
# Without damping the free motion of mode n is |f_n'|/ω_n times (1 + R)/(1 − R)·|cot(πnα)|, α = πsm, which is large
# where it swings nearly a whole number of times between two impacts. How near nα comes to whole numbers, and how
# rarely, is told by the continued fraction of α: its denominators q_j come nearest, ‖q_jα‖ = η_j, no n < q_{j+1}
# comes nearer, and any two of q_j modes in a row are at least η_{j−1} ≥ 1/(2q_j) apart.

# π to 100 digits, as a fraction: a wave speed is taken as the exact number that it is in binary
PI = Fraction(
    31415926535897932384626433832795028841971693993751058209749445923078164062862089986280348253421170679, 10**100
)
_LAST = 10**18  # modes beyond this one count for nothing


@lru_cache(maxsize=64)
def convergents(s: float, periods: int) -> tuple[tuple[int, float], ...]:
    """Denominators q_j of πsm and ‖q_jα‖, up to the last mode that could count."""
    alpha = PI * Fraction(s) * periods
    whole = alpha.numerator // alpha.denominator
    rest, before, q = alpha - whole, 0, 1
    found = [(1, float(min(rest, 1 - rest)))]
    while rest and q <= _LAST:
        rest = 1 / rest
        whole = rest.numerator // rest.denominator
        rest -= whole
        before, q = q, whole * q + before
        off = q * alpha % 1
        entry = (q, float(min(off, 1 - off)))
        if found[-1][0] == q:
            found[-1] = entry
        else:
            found.append(entry)
    return tuple(found)


@lru_cache(maxsize=256)
def cubic_sum(s: float, periods: int, start: int, most: float = math.inf, shift: float = 0.0) -> float:
    """A bound of Σ n⁻³ min(`most`, 1 + 1/(2(‖nα‖ − `shift`))) over the modes n = `start` + 1 … 10¹⁸, α = πsm."""
    # Damping moves nα by at most `shift`.
    known = convergents(s, periods)
    total = 0.5 / start**2
    for j, (q, eta) in enumerate(known[:-1]):
        end, first = known[j + 1][0], max(start + 1, q)
        if first >= end:
            continue
        near, apart = eta - shift, (known[j - 1][1] if j else 0.5)
        crowd = 4.0 * q * (2.0 + math.log(q)) + 2.0 / apart  # all but the nearest of q modes in a row
        crowd = 0.5 * crowd if shift == 0.0 else crowd if apart > 8.0 * shift else math.inf
        total += _cubes(first, end, q) * min(q * most, crowd)

        def nearest(times: float, near: float = near) -> float:
            return min(most, 0.5 / (times * near) if near > 0.0 else math.inf)

        # the nearest: rη_j among rq_j … (r + 1)q_j in the first half of the block, rη_j from its end in the other
        r = first // q
        for one in range(r, r + 8):
            total += max(one * q, first) ** -3.0 * nearest(one) if one * q < end else 0.0
        if (r + 8) * q < end:
            total += 0.5 * q**-3.0 * (r + 7.0) ** -2.0 * nearest(r + 8.0)
        half = max(first, end // 2)  # from there on ‖nα‖ is about ‖(q_{j+1} − n)α‖
        total += min(_cubes(half, end, q), float(half) ** -3 * (3.0 + math.log1p((end - half) / q))) * nearest(1.0)
    return total


def _cubes(first: int, end: int, step: int) -> float:
    """A bound of the sum of n⁻³ for n = first, first + step, … below `end`."""
    return min(
        float(first) ** -3 + 0.5 / step * float(first) ** -2, math.ceil((end - first) / step) * float(first) ** -3
    )


def resolvent_bound(system: System, period: float, omega: float, d: float) -> float:
    """B with ω_n |z_n| + |z_n'| ≤ B |f_n'| for all modes from `omega`, `d` on, if the strain is kept; inf for d = 0."""
    contact = system.contact
    half = float(np.exp(-0.5 * d * period))
    rate = float(np.sqrt(max(omega**2 - 0.25 * d**2, 0.0)))
    if rate == 0.0:
        return float("inf")
    slip = 0.5 * d / rate * half
    least = -float(np.expm1(-0.5 * d * period)) * (1.0 - contact.velocity_factor * half) - contact.impulse * slip
    if least <= 0.0:
        return float("inf")
    return contact.impulse * (half * omega / rate + 1.0 + half + slip) / least
