"""Random starts: the numbers drawn for one or many of them."""

from __future__ import annotations

import numpy as np

from percuss.model import HeldBody, System
from percuss.model.checks import Array, choice, count, instance
from percuss.simulate.held import state_of
from percuss.simulate.spectrum import units
from percuss.simulate.stop import MAX_MODES

__all__ = ["DEFAULT_RANDOM_MODES", "DISTRIBUTIONS", "drawn"]

DISTRIBUTIONS = ("rigid", "still", "ringing")
"""The named distributions of random starts."""

DEFAULT_RANDOM_MODES = 32
"""Elastic modes that a random start excites."""

_TURN = 2.0 * np.pi
_MOST_STARTS = 10**9


def drawn(system: System, size: int, seed: int, distribution: str, modes: int) -> tuple[Array, Array, Array, Array]:
    """u_n and u_n', each of shape (size, n), gaps and load phases, of shape (size,); see `Starts.random`."""
    instance("system", system, System)
    n, number = count("modes", modes, least=0, most=MAX_MODES), count("size", size, least=1, most=_MOST_STARTS)
    choice("distribution", distribution, *DISTRIBUTIONS)
    draw = np.random.default_rng(count("seed", seed, least=0))
    if isinstance(system.body, HeldBody):
        return _of_structure(system, system.body, system.body.chosen(n or None), number, distribution, draw)
    scale = float(np.abs(system.load.coefficients).sum())
    gap = draw.uniform(-5.0 * scale, 0.0, number)
    mean = draw.uniform(-3.0 * scale, 3.0 * scale, number) * (distribution != "still")
    time = draw.uniform(0.0, _TURN, number)
    if distribution != "ringing":
        return gap[:, None], mean[:, None], gap, time
    k = np.arange(1, n + 1)
    size_of = draw.normal(0.0, 1.0, (number, n)) * scale / (3.0 * k)
    turn = draw.uniform(0.0, _TURN, (number, n))
    elastic = system.body.modes(n, system.load.at)
    u = size_of * np.cos(turn) / elastic.omega
    v = size_of * np.sin(turn)
    first = gap - u @ units(elastic)
    return np.column_stack([first, u]), np.column_stack([mean, v]), gap, time


def _of_structure(
    system: System, body: HeldBody, modes: int, number: int, distribution: str, draw: np.random.Generator
) -> tuple[Array, Array, Array, Array]:
    """The same of a body that is held; its modes give the scales of place and velocity in place of P."""
    elastic, force = body.modes(modes, system.load.at), float(np.abs(system.load.coefficients).sum())
    reach = abs(body.gap) + force * float(np.sum(np.abs(elastic.gamma) / elastic.omega**2))
    pace = force * float(np.sum(np.abs(elastic.gamma) / elastic.omega))
    gap = draw.uniform(-3.0 * reach, 0.0, number)
    speed = draw.uniform(-3.0 * pace, 3.0 * pace, number) * (distribution != "still")
    time = draw.uniform(0.0, _TURN, number)
    u, v = state_of(body, system.load.at, modes, gap[:, None], speed[:, None], gap)
    if distribution == "ringing":
        unit = units(elastic)
        size_of = draw.normal(0.0, 1.0, (number, modes)) * pace / (3.0 * np.arange(1, modes + 1))
        turn = draw.uniform(0.0, _TURN, (number, modes))
        swing = size_of * np.cos(turn) / (elastic.omega * np.abs(unit))
        u[:, 1:] += swing - np.outer(swing @ unit, body.bent(modes, system.load.at))
        v[:, 1:] += size_of * np.sin(turn) / np.abs(unit)
    return u, v, gap, time
