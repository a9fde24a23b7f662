"""Parameters that a load has one of for each harmonic or step: amplitude2, phase2, step1, break2 …"""

from __future__ import annotations

import cmath
import math
import re
from collections.abc import Sequence
from dataclasses import replace

from percuss.errors import ParameterError
from percuss.model import Load, System
from percuss.model.parameter import Parameter

__all__ = ["LOAD_PARAMETERS", "load_parameter"]

_NAME = re.compile(r"(amplitude|phase|step|break)([1-9]\d{0,3})", re.ASCII)

LOAD_PARAMETERS = {
    "amplitude": "amplitude of harmonic K of the load",
    "phase": "phase of harmonic K of the load in rad: it is amplitude·cos(Kt + phase)",
    "step": "value of the load's step K, counted from phase 0 on",
    "break": "phase in rad at which the load's step K begins",
}
"""What they are, by the word before the number K."""

_LABELS = {"amplitude": "amplitude |p{0}|", "phase": "phase of harmonic {0}", "step": "step {0}", "break": "break {0}"}


def load_parameter(name: str, turn: int) -> Parameter[System] | None:
    """The parameter of a harmonic or of a step; None for a name that is none of them.

    Parameters
    ----------
    name
        A word and a number.
    turn
        See `percuss.model.parameter.Parameter`.
    """
    found = _NAME.fullmatch(name)
    if found is None:
        return None
    word, number = found[1], int(found[2])
    has, value, changed, needed = _OF[word]

    def get(system: System) -> float | None:
        return value(system.load, number) if has(system.load, number) else None

    def check(system: System) -> None:
        if not has(system.load, number):
            raise ParameterError(name, str(system.load), f"a load of {needed}, {number} or more")

    def put(system: System, new: float) -> System:
        check(system)
        return replace(system, load=changed(system.load, number, new))

    meaning = LOAD_PARAMETERS[word].replace("K", str(number))
    return Parameter(name, _LABELS[word].format(number), meaning, get, put, check, turn=turn)


def _has_harmonic(load: Load, number: int) -> bool:
    return not load.is_piecewise and number < load.coefficients.size


def _has_phase(load: Load, number: int) -> bool:
    return _has_harmonic(load, number) and load.coefficients[number] != 0.0


def _has_step(load: Load, number: int) -> bool:
    return number <= len(load.values)


def _amplitude(load: Load, number: int) -> float:
    return abs(complex(load.coefficients[number]))


def _with_amplitude(load: Load, number: int, value: float) -> Load:
    """An amplitude below 0 is that of the opposite phase, so that a branch goes through 0."""
    one = complex(load.coefficients[number])
    return _with_harmonic(load, number, value * (one / abs(one) if one else 1.0))


def _phase(load: Load, number: int) -> float:
    return cmath.phase(complex(load.coefficients[number]))


def _with_phase(load: Load, number: int, value: float) -> Load:
    return _with_harmonic(load, number, cmath.rect(_amplitude(load, number), value))


def _with_harmonic(load: Load, number: int, value: complex) -> Load:
    coefficients = load.coefficients.copy()
    coefficients[number] = value
    return replace(load, coefficients=coefficients)


def _step(load: Load, number: int) -> float:
    return float(load.values[number - 1])


def _with_step(load: Load, number: int, value: float) -> Load:
    values = (*load.values[: number - 1], value, *load.values[number:])
    return _with_steps(load, load.breaks, values)


def _break(load: Load, number: int) -> float:
    return float(load.breaks[number - 1])


def _with_break(load: Load, number: int, value: float) -> Load:
    """A break stays between its neighbours."""
    low, high = (0.0, *load.breaks)[number - 1], (*load.breaks, 2.0 * math.pi)[number]
    if not low <= value < high or (number > 1 and value == low):
        raise ParameterError(f"break{number}", value, f"a phase between {low:.9g} and {high:.9g}")
    return _with_steps(load, (*load.breaks[: number - 1], value, *load.breaks[number:]), load.values)


def _with_steps(load: Load, breaks: Sequence[float], values: Sequence[float]) -> Load:
    made = Load.steps(breaks, values, load.coefficients.size - 1, frequency=load.frequency)
    return replace(made, at=load.at)


_OF = {
    "amplitude": (_has_harmonic, _amplitude, _with_amplitude, "harmonics"),
    "phase": (_has_phase, _phase, _with_phase, "harmonics"),
    "step": (_has_step, _step, _with_step, "steps"),
    "break": (_has_step, _break, _with_break, "steps"),
}
