"""What modes beyond the last one kept may add where they are hardly damped: sums over small divisors (theory §4).

Without damping the free motion of mode n is |f_n'|/ω_n times (1 + R)/(1 − R)·|cot(πnα)|, α = πsm, which is large where
it swings nearly a whole number of times between two impacts. How near nα comes to whole numbers, and how rarely, is
told by the continued fraction of α: its denominators q_j come nearest, ‖q_jα‖ = η_j, no n < q_{j+1} comes nearer, and
any two of q_j modes in a row are at least η_{j−1} ≥ 1/(2q_j) apart.
"""

from __future__ import annotations

import math
from fractions import Fraction
from functools import lru_cache

import numpy as np

from percuss.model import System

# π to 100 digits, as a fraction: a wave speed is taken as the exact number that it is in binary
PI = Fraction(
    31415926535897932384626433832795028841971693993751058209749445923078164062862089986280348253421170679,
    10**100,
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
    """A bound of Σ n⁻³ min(`most`, 1 + 1/(2(‖nα‖ − `shift`))) over the modes n = `start` + 1 … 10¹⁸, α = πsm.

    `most` bounds every factor; damping moves nα by at most `shift`.
    """
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
