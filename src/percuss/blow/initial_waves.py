"""The waves that are in the striker before the blow, from its velocity and the forces in it."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from percuss.blow.kernels.layout import MOST_DEGREE
from percuss.blow.question import Question
from percuss.errors import ParameterError
from percuss.model.checks import Array

__all__ = ["Piece", "initial_waves"]

_ENOUGH = 1e-13  # of the greatest value: last coefficients of a piece that follows a field
_FINEST = 2.0**-30  # share of a section: where a field jumps, its pieces are not made shorter


class Piece(NamedTuple):
    """A share of the time before the blow, from 0 to 1, and the Chebyshev coefficients of what left an end in it."""

    begin: float
    end: float
    values: Array


def initial_waves(question: Question) -> list[list[Piece]]:
    """For each section of the striker the wave to the right and the wave to the left, in the order of their leaving.

    What is at the share y of a section left its start at −y τ to the right, and its end at −(1 − y) τ to the left.

    Raises
    ------
    ParameterError
        For a field whose values are not numbers.
    """
    sections = question.sections
    if question.velocity is not None:
        halves = 0.5 * question.velocity
        return [[Piece(0.0, 1.0, np.array([half]))] for half in halves for _ in range(2)]
    assert question.field is not None
    rows, ends = [], np.cumsum(sections.length) / sections.length.sum()
    starts = np.append(0.0, ends[:-1])
    for z, low, high in zip(sections.impedance, starts, ends, strict=True):
        for side in (1.0, -1.0):
            rows.append(_followed(_wave(question.field, float(z), float(low), float(high), side)))
    return rows


def _wave(
    field: tuple[Callable[[Array], Array], ...], z: float, low: float, high: float, side: float
) -> Callable[[Array], Array]:
    """What leaves an end of a section at the share y of the time before the blow."""

    def at(y: Array) -> Array:
        place = low + (high - low) * (1.0 - y if side > 0.0 else y)
        values = []
        for function in field:
            try:
                found = np.asarray(function(place), dtype=float)
                values.append(np.broadcast_to(found, y.shape))
            except (TypeError, ValueError) as error:
                raise ParameterError("field", function, "functions that give numbers for an array of x") from error
        if not np.isfinite(values).all():
            raise ParameterError("field", field, "functions with finite values from x = 0 to 1")
        return np.asarray(0.5 * (values[0] + side * values[1] / z))

    return at


def _followed(function: Callable[[Array], Array]) -> list[Piece]:
    """A function on [0, 1] as polynomials, each as long as its last coefficients are nothing."""
    n = MOST_DEGREE
    angles = np.pi * (np.arange(n + 1) + 0.5) / (n + 1)
    transform = 2.0 / (n + 1) * np.cos(np.outer(np.arange(n + 1), angles))
    transform[0] *= 0.5
    nodes, found, rest = np.cos(angles), [], [(0.0, 1.0)]
    size = float(abs(function(0.5 + 0.5 * nodes)).max())
    while rest:
        low, high = rest.pop()
        values = transform @ function(low + 0.5 * (high - low) * (1.0 + nodes))
        size = max(size, float(abs(values).max()))
        if abs(values[-3:]).max() > _ENOUGH * size and high - low > _FINEST:
            middle = 0.5 * (low + high)
            rest += [(middle, high), (low, middle)]
            continue
        kept = np.flatnonzero(abs(values) > 1e-16 * size)
        found.append(Piece(low, high, values[: (kept[-1] if kept.size else 0) + 1]))
    return found
