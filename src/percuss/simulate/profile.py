"""Displacements and velocities along the bar, and the modes of which they are made."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model.body import Body
from percuss.model.checks import Array, numbers

__all__ = ["Profile", "modal_parts", "number_tuple", "sampled", "values_at"]

Profile = npt.ArrayLike | Callable[[Array], npt.ArrayLike]
"""A function of an array of x, or values at equal steps from x = 0 to 1, straight between them."""


def number_tuple(name: str, values: object) -> tuple[float, ...]:
    """One or more finite numbers, as they are kept in a start."""
    if isinstance(values, tuple) and len(values) == 1 and type(values[0]) is float and math.isfinite(values[0]):
        return values  # of an undeformed bar
    array = numbers(name, values, "one or more finite numbers").reshape(-1)
    if not array.size:
        raise ParameterError(name, values, "one or more finite numbers")
    return tuple(array.tolist())


def sampled(name: str, profile: Profile) -> Profile:
    """A profile that is looked at: a function as it is, a number as two equal samples."""
    if callable(profile):
        return profile
    values = np.atleast_1d(np.asarray(number_tuple(name, profile)))
    return tuple((np.repeat(values, 2) if values.size == 1 else values).tolist())


def values_at(profile: Profile, x: Array) -> Array:
    """A profile at some places; shape (len(x),)."""
    if callable(profile):
        accepted = "finite values on 0 ≤ x ≤ 1, as many as x or one"
        found = numbers("displacement or velocity", profile(x), accepted)
        if found.shape not in ((), (1,), x.shape):
            raise ParameterError("displacement or velocity", f"shape {found.shape}", accepted)
        return np.broadcast_to(found, x.shape)
    samples = np.asarray(profile, dtype=float)
    return np.asarray(np.interp(x, np.linspace(0.0, 1.0, samples.size), samples))


def modal_parts(profile: Profile, body: Body, unit: Array) -> Array:
    """u_n of a profile, n = 0 … N, with q_n = unit u_n at the striking end; shape (N+1,).

    A uniform bar's are its integrals with the modes. Of other bodies they are those that fit it best along the bar,
    every place counted by its mass: in this sense the modes are orthogonal, and the rigid velocity is the momentum.
    """
    if body.is_uniform:
        integrals = _integrals(profile, body, unit.size)
        return np.append(integrals[0], integrals[1:] / (body.inertia(unit.size) * unit))
    x, mass = _masses(body, max(16, 2 * (unit.size + 1)))
    shapes = np.column_stack([np.ones(x.size), body.shapes(x, unit.size).displacement * unit])
    root = np.sqrt(mass)
    return np.asarray(np.linalg.lstsq(shapes * root[:, None], _finite_at(profile, x) * root)[0], dtype=float)


def _integrals(profile: Profile, bar: Body, count: int) -> Array:
    """∫₀¹ u(x) φ_n(x)/φ_n(1) dx, n = 0 … `count`: exact for straight lines between samples, else by Gauss's rule.

    φ'' = −(ω/s)² φ and φ' = 0 at both ends, so that ∫ u φ dx = (s/ω)² ∫ u' φ' dx, and u' is constant between samples.
    The rule is refined until nothing changes.
    """
    if not callable(profile):
        u = np.asarray(profile, dtype=float)
        x = np.linspace(0.0, 1.0, u.size)
        slope = np.diff(u) / np.diff(x)
        rises = np.diff(bar.shapes(x, count).displacement, axis=0)
        return np.append(np.trapezoid(u, x), (bar.s / bar.frequencies(count)) ** 2 * (slope @ rises))
    last, panels = np.full(count + 1, np.inf), max(8, count + 1)
    while True:
        x, w = _gauss(np.linspace(0.0, 1.0, panels + 1))
        values = _finite_at(profile, x)
        found = np.append(w @ values, (w * values) @ bar.shapes(x, count).displacement)
        if float(np.abs(found - last).max()) <= 1e-14 * float(np.abs(values).max()) or panels > 16384:
            return np.asarray(found)
        last, panels = found, 2 * panels


def _finite_at(profile: Profile, x: Array) -> Array:
    values = np.asarray(values_at(profile, x), dtype=float)
    if not np.all(np.isfinite(values)):
        raise ParameterError("displacement or velocity", "a function", "finite values on 0 ≤ x ≤ 1")
    return values


def _masses(body: Body, panels: int) -> tuple[Array, Array]:
    """Places along the bar and the masses that stand for it there, in sum 1: Gauss's, and the point masses of the ends.

    Between the edges of the panels, of which each step of the bar is one, the mass is taken for evenly spread.
    """
    edges = np.union1d(np.linspace(0.0, 1.0, panels + 1), body.places)
    before = body.mass_before(edges)
    x, w = _gauss(edges)
    density = np.diff(before) / np.diff(edges)
    mass = w * np.repeat(density, w.size // density.size)
    return np.concatenate([[0.0], x, [1.0]]), np.concatenate([before[:1], mass, np.maximum(1.0 - before[-1:], 0.0)])


def _gauss(edges: Array, points: int = 8) -> tuple[Array, Array]:
    """Points and weights of Gauss's rule on the panels between edges."""
    t, w = np.polynomial.legendre.leggauss(points)
    left, width = edges[:-1, None], np.diff(edges)[:, None]
    return (left + 0.5 * (t + 1.0) * width).reshape(-1), (0.5 * w * width).reshape(-1)
