"""The table of parameters: what is put comes back, whatever the body, its damping and the contact law."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from percuss import Load, System
from percuss.errors import ParameterError
from percuss.explore import PARAMETERS, SystemFamily, vary
from percuss.explore.parameters import PERIODS, label_of
from percuss.model import Kept
from percuss.model.body import (
    BODIES,
    DAMPINGS,
    UNDAMPED,
    Body,
    Damping,
    External,
    KelvinVoigt,
    Ratio,
    Shape,
    Table,
    UniformBar,
)
from percuss.model.checks import Array
from percuss.model.contact import LAWS
from percuss.model.parameter import Parameter

LOADS = {
    "harmonic": Load.harmonic(0.9, 1.0),
    "square": Load.square(1.0, 1.3, 8),
    "fourier": Load.fourier([0.6, 0.5 - 0.2j, 0.3j]),
}
DAMPED = {"external": External(0.01), "ratio": Ratio(1e-3), "kelvin_voigt": KelvinVoigt(1e-5), "table": Table((1e-3,))}
VALUES = {
    "restitution": 0.35,
    "load_factor": 0.72,
    "kappa": 0.9,
    "s": 7.5,
    "d": 0.02,
    "damping_ratio": 2e-3,
    "eta": 3e-5,
    "mean": 0.41,
    "amplitude": 1.7,
}
OF_STRUCTURES = ("stiffness", "dashpot", "gap")
"""Those that a free bar does not have; see `tests/steady/test_structures.py`."""


@dataclass(frozen=True)
class Twice(Body):
    """Another kind of body: the modes of a uniform bar of s = 3, and no number of its own that may be varied."""

    kind: ClassVar[str] = "twice"
    parameters: ClassVar[tuple[Parameter[Any], ...]] = ()
    s: float = 3.0
    damping: Damping = UNDAMPED

    @property
    def _bar(self) -> UniformBar:
        return UniformBar(self.s, self.damping)

    def frequencies(self, count: int) -> Array:
        return self._bar.frequencies(count)

    def inertia(self, count: int) -> Array:
        return self._bar.inertia(count)

    def shapes(self, x: Array, count: int) -> Shape:
        return self._bar.shapes(x, count)

    def static_shape(self, x: Array, source: float = 0.0) -> Shape:
        return self._bar.static_shape(x, source)

    def frequency_floor(self, n: int) -> float:
        return self._bar.frequency_floor(n)

    @property
    def coupling_bound(self) -> float:
        return 2.0


def a_system(load: str, damping: str, law: str) -> System:
    return System(UniformBar(20.0, DAMPED[damping]), LOADS[load], LAWS[law](0.6))


def test_every_number_of_bodies_and_dampings_is_in_the_table() -> None:
    named = {own.name for body in BODIES.values() for own in body.parameters}
    named |= {law.parameter.name for law in DAMPINGS.values() if law.parameter is not None}
    assert named <= set(PARAMETERS) == {*VALUES, *OF_STRUCTURES}
    for name, parameter in PARAMETERS.items():
        assert parameter.name == name and parameter.label == label_of(name) and parameter.meaning
        assert parameter.span is None or parameter.span[0] < parameter.span[1]
    assert label_of(PERIODS) == "load periods m" and label_of("bar.length") == "bar.length"


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("damping", DAMPED)
@pytest.mark.parametrize("load", LOADS)
def test_what_is_put_comes_back_and_all_else_stays(load: str, damping: str, law: str) -> None:
    system = a_system(load, damping, law)
    had = {name: parameter.get(system) for name, parameter in PARAMETERS.items()}
    with_it = {"kappa": load == "square", "d": damping == "external", "eta": damping == "kelvin_voigt"}
    with_it["damping_ratio"] = damping == "ratio"
    for name, value in VALUES.items():
        if not with_it.get(name, True):
            with pytest.raises(ParameterError):
                SystemFamily(system).check({name: ""})
            with pytest.raises(ParameterError):
                vary(system, {name: value})
            continue
        SystemFamily(system).check({name: ""})
        moved = vary(system, {name: value})
        assert PARAMETERS[name].get(moved) == pytest.approx(value, rel=1e-12)
        assert moved.contact == (LAWS[law](value) if name == "restitution" else system.contact)
        if PARAMETERS[name].sets != "damping":
            assert moved.body.damping == system.body.damping
        of_load = {"load_factor", "kappa", "mean", "amplitude"}
        for other in set(VALUES) - {name} - (of_load if name in of_load else set()):
            assert PARAMETERS[other].get(moved) == had[other], (name, other)


@given(st.permutations(["restitution", "load_factor", "s", "amplitude", "damping_ratio"]))
def test_the_order_of_the_names_does_not_matter(order: list[str]) -> None:
    system = a_system("fourier", "ratio", "kept")
    first = vary(system, {name: VALUES[name] for name in sorted(order)})
    assert vary(system, {name: VALUES[name] for name in order}) == first


def test_a_body_without_damping_takes_every_law_and_a_damped_one_its_own() -> None:
    free = System(UniformBar(20.0), LOADS["harmonic"], Kept(0.6))
    for name, kind in (("d", External), ("damping_ratio", Ratio), ("eta", KelvinVoigt)):
        assert vary(free, {name: VALUES[name]}).body.damping == kind(VALUES[name])
        assert PARAMETERS[name].get(free) == 0.0
    with pytest.raises(ParameterError, match="without damping"):
        vary(a_system("harmonic", "ratio", "kept"), {"d": 0.1})
    with pytest.raises(ParameterError, match="sets the same"):
        SystemFamily(free).check({"d": "", "eta": ""})


def test_a_body_that_has_no_such_number_says_which_ones_have() -> None:
    other = System(Twice(), LOADS["harmonic"], Kept(0.6))
    assert PARAMETERS["s"].get(other) is None
    for ask in (lambda: SystemFamily(other).check({"s": ""}), lambda: vary(other, {"s": 4.0})):
        with pytest.raises(ParameterError, match="uniform"):
            ask()
    moved = vary(other, {"d": 0.1, "restitution": 0.2})  # an external damping is that of any body
    assert moved.body == Twice(damping=External(0.1)) and moved.restitution == 0.2


def test_kappa_keeps_the_place_of_the_load_and_its_sign() -> None:
    load = Load.square(1.0, 1.3, 8).scaled(-1.0)
    moved = vary(System(UniformBar(20.0), load, Kept(0.6)), {"kappa": 0.9})
    assert moved.load.at == load.at and moved.load.values[0] == -1.0
    assert moved.load.breaks[1] == pytest.approx(0.9 * math.pi) and np.isclose(moved.load.mean, 0.1)


def test_the_manual_names_every_parameter() -> None:
    manual = (Path(__file__).parents[2] / "docs" / "maps.md").read_text(encoding="utf-8")
    assert [name for name in (*PARAMETERS, PERIODS) if f"`{name}`" not in manual] == []
