"""One damped oscillator, and the functions that stay exact as d → 0: `percuss.steady.oscillator` in plain numbers."""

import math

from percuss.compiled import inner
from percuss.steady.periodic.kernels.layout import CREEPS, HALF_D, RATE, SQUARE

__all__ = ["phi1", "phi2", "phi3", "propagated", "versine"]


@inner
def phi1(x):
    """(1 − exp(−x))/x."""
    return 1.0 if x == 0.0 else -math.expm1(-x) / x


@inner
def phi2(x):
    """(exp(−x) − 1 + x)/x²."""
    if abs(x) >= 0.1:
        return (math.expm1(-x) + x) / (x * x)
    series = 1.0 / 11.0
    for j in range(10, 1, -1):
        series = (1.0 - x * series) / j
    return series


@inner
def phi3(x):
    """(½ − phi2(x))/x."""
    if abs(x) >= 0.3:
        return (0.5 - phi2(x)) / x
    series = 0.0
    for j in range(15, 2, -1):
        series = (1.0 - x * series) / j
    return 0.5 * series


@inner
def propagated(modal, n, t):
    """Φ_n(t) = [[a, b], [c, e]]."""
    half_d, rate = modal[HALF_D, n], modal[RATE, n]
    angle = rate * t
    if modal[CREEPS, n] != 0.0:
        slow = math.exp(-modal[SQUARE, n] / (half_d + rate) * t)
        spread = 2.0 * angle
        cosine, b = 0.5 * slow * (1.0 + math.exp(-spread)), slow * t * phi1(spread)
    else:
        half = math.exp(-half_d * t) if half_d != 0.0 else 1.0
        cosine = half * math.cos(angle)
        b = half * (math.sin(angle) / rate if angle > 1e-12 else t)
    return cosine + half_d * b, b, -modal[SQUARE, n] * b, cosine - half_d * b


@inner
def versine(modal, n, t):
    """exp(−dt/2)(1 − cos λt)."""
    half = math.exp(-modal[HALF_D, n] * t)
    if modal[CREEPS, n] == 0.0:
        sine = math.sin(0.5 * modal[RATE, n] * t)
        return half * 2.0 * sine * sine
    slow = math.exp(-modal[SQUARE, n] / (modal[HALF_D, n] + modal[RATE, n]) * t)
    return half - 0.5 * slow * (1.0 + math.exp(-2.0 * modal[RATE, n] * t))
