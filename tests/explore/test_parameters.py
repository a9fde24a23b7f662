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

from hammers import HAMMERS
from orbit_cases import Made
from percuss import Load, System
from percuss.errors import ParameterError, PercussError
from percuss.explore import PARAMETERS, BranchEvent, SystemFamily, follow, parameters_of, sweep, vary
from percuss.explore.continuation.orbit_curve import ParameterRows, SolutionCurve, turning
from percuss.explore.continuation.walk import CorrectorFailed
from percuss.explore.parameters import PERIODS, label_of
from percuss.model import KelvinVoigt, Kept, Machine, Mounted, Ratio, SteppedBar, UniformBar
from percuss.model.body import BODIES, DAMPINGS, UNDAMPED, Body, Damping, External, Shape, Table
from percuss.model.checks import Array
from percuss.model.contact import LAWS
from percuss.model.parameter import Parameter
from percuss.steady import orbit_near, orbits, parameter_column
from percuss.steady.periodic.impact_chain import numbers_of

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
    assert label_of("phase2") == "phase of harmonic 2"
    assert PARAMETERS["break2"].meaning == "phase in rad at which the load's step 2 begins"


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


@pytest.mark.parametrize("what", [one.what for one in HAMMERS.values()], ids=HAMMERS)
def test_every_parameter_of_a_hammer_is_read_and_put(what: System | Machine) -> None:
    for name, parameter in parameters_of(what).items():
        try:
            parameter.check(what)
        except ParameterError:
            continue
        value = parameter.get(what)
        if math.isinf(value):  # s of a mass that does not ring
            continue
        again = vary(what, {name: value})
        assert again == what or (parameter.sets == "damping" and again.body.damping.is_zero), name
        if name not in ("pressure", "restitution"):
            assert parameter.get(vary(what, {name: value + 0.25})) == pytest.approx(value + 0.25, rel=1e-15), name


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


# -- of one harmonic or step of a load: put, swept and followed -------------------------------------------------------

FOURIER = System(s=5.0, d=0.02, restitution=0.5, load=Load.fourier([0.6, 1.0, 0.3j]))
SQUARE = System(s=5.0, d=0.0, restitution=0.5, load=Load.square(1.0, 1.65))
STEPS = System(s=5.0, d=0.0, restitution=0.5, load=Load.steps([0.2, 1.0, 3.0], [1.5, -0.3, 0.1]))


@given(st.integers(1, 2), st.floats(1e-3, 5.0), st.floats(-3.1, 3.1))
def test_amplitude_and_phase_of_a_harmonic_come_back(number: int, amplitude: float, phase: float) -> None:
    names = f"amplitude{number}", f"phase{number}"
    system = vary(FOURIER, {names[1]: phase, names[0]: amplitude})
    assert PARAMETERS[names[0]].get(system) == pytest.approx(amplitude, rel=1e-14)
    assert PARAMETERS[names[1]].get(system) == pytest.approx(phase, abs=1e-14)
    t = np.linspace(0.0, 6.0, 7)
    change = amplitude * np.cos(number * t + phase) - np.real(
        FOURIER.load.coefficients[number] * np.exp(1j * number * t)
    )
    assert system.load.value(t) == pytest.approx(FOURIER.load.value(t) + change, abs=1e-13)


@given(st.floats(-5.0, 5.0), st.floats(0.21, 2.9))
def test_steps_and_breaks_come_back(value: float, place: float) -> None:
    system = vary(STEPS, {"step3": value, "break2": place})
    assert system.load.values == (1.5, -0.3, value)
    assert system.load.breaks == (0.2, place, 3.0)
    assert system.load.at == STEPS.load.at


@pytest.mark.parametrize("name", ["amplitude3", "phase3", "step1", "break1"])
def test_a_load_without_it_is_refused(name: str) -> None:
    assert PARAMETERS[name].get(FOURIER) is None
    with pytest.raises(ParameterError, match=name):
        vary(FOURIER, {name: 0.1})
    with pytest.raises(ParameterError, match=name):
        SystemFamily(FOURIER).check({name: ""})


@pytest.mark.parametrize("place", [0.2, 3.0, -1.0])
def test_a_break_stays_between_its_neighbours(place: float) -> None:
    with pytest.raises(ParameterError, match="break2"):
        vary(STEPS, {"break2": place})


@pytest.mark.parametrize("name", ["amplitude0", "phase", "amplitude01", "step-1", "Amplitude1"])
def test_other_names_are_none(name: str) -> None:
    assert name not in PARAMETERS
    with pytest.raises(KeyError):
        PARAMETERS[name]


def test_an_orbit_moves_with_the_phase_of_the_only_harmonic() -> None:
    """Nothing else happens: the whole load is shifted."""
    system = System(s=5.0, d=0.02, restitution=0.5, load=Load.harmonic(0.8, 1.0))
    branch = follow(orbits(system, 1, 1, modes=2).orbits[-1], "phase1", (-0.5, 0.5))
    assert [point.kind for point in branch.points] == [BranchEvent.LIMIT] * 2
    shifted = branch.times[:, 0] + branch.values
    assert shifted == pytest.approx(np.full(shifted.shape, shifted[0]), abs=1e-12)


def test_a_break_is_kappa() -> None:
    start = orbits(SQUARE, 1, 1, modes=0).orbits[-1]
    by_kappa, by_break = follow(start, "kappa", (1.64, 1.75)), follow(start, "break2", (1.64 * math.pi, 1.75 * math.pi))
    assert [point.kind for point in by_break.points] == [point.kind for point in by_kappa.points]
    expected = [math.pi * point.value for point in by_kappa.points]
    assert [point.value for point in by_break.points] == pytest.approx(expected, rel=0, abs=1e-10)


def test_an_amplitude_is_followed_and_swept() -> None:
    start = orbits(FOURIER, 1, 1, modes=0).orbits[-1]
    branch = follow(start, "amplitude2", (0.1, 0.5))
    assert branch.values.max() <= 0.5
    found = sweep(FOURIER, "amplitude2=0.1,0.3", quantities=["phase"], workers=1)
    at_start = found["phase"][1]
    assert np.mod(np.mod(at_start, 2.0 * math.pi) - start.phase + 1.0, 2.0 * math.pi) == pytest.approx(1.0, abs=1e-9)


# -- Systems over a parameter as rows of numbers, and the way back to a branch with them, beside the plain form --------


HAMMER = System(s=5.0, d=0.0048, restitution=0.5, load=Load.harmonic(0.62, 1.0))
SQUARES = System(s=5.0, d=0.0048, restitution=0.5, load=Load.square(1.0, 1.55, harmonics=15))
MOUNTED = System(Mounted(stiffness=0.15, dashpot=0.05, gap=0.2), Load.harmonic(0.1, 0.5), Kept(0.6))


def turned(value: float) -> System:
    """A load whose harmonics turn with the parameter: no even change."""
    return System(s=5.0, d=0.0048, restitution=0.5, load=Load.fourier([0.62, np.exp(1j * value), 0.1]))


def plain_matrix(curve: SolutionCurve, x: Array) -> Array:
    motion, matrix = curve.motion(x), np.empty((x.size - 1, x.size))
    matrix[:, :-1] = motion.bordered().real
    matrix[:, 0] -= turning(motion) * matrix[:, -2]
    matrix[:, -1] = parameter_column(motion, curve.system, curve.value(x)) * curve.unit
    return matrix


def plainly(curve: SolutionCurve, x: Array, normal: Array) -> tuple[Array, Array]:
    """Newton's method in a plane with the plain equations, and the tangent."""
    for _ in range(12):
        matrix = plain_matrix(curve, x)
        x = x - np.linalg.solve(np.vstack([matrix, normal]), np.append(curve.motion(x).residuals, 0.0))
    tangent = np.linalg.solve(np.vstack([matrix, normal]), np.append(np.zeros(x.size - 1), 1.0))
    return x, tangent / np.linalg.norm(tangent)


@pytest.mark.parametrize(
    ("system", "times", "modes", "name", "value"),
    [
        (HAMMER, [0.39, 2.32], 0, "mean", 0.62),
        (HAMMER, [0.39, 2.32], 0, "load_factor", 0.62),
        (HAMMER, [0.39, 2.32], 8, "amplitude", 1.0),
        (HAMMER, [0.39, 2.32], 8, "s", 5.0),
        (HAMMER, [0.39, 2.32], 8, "d", 0.0048),
        (HAMMER, [0.39, 2.32], 64, "restitution", 0.5),
        (SQUARES, None, 0, "kappa", 1.55),
        (SQUARES, None, 4, "mean", SQUARES.load.mean),
        (MOUNTED, None, 1, "stiffness", 0.15),
        (MOUNTED, None, 1, "gap", 0.2),
    ],
)
def test_points_of_a_branch_are_those_of_the_plain_equations(
    system: System, times: list[float] | None, modes: int, name: str, value: float
) -> None:
    orbit = orbits(system, 1, modes=modes).orbits[0] if times is None else orbit_near(system, times, modes=modes)
    assert orbit is not None
    check_points(SolutionCurve(SystemFamily(system), name, orbit.impacts, 1, modes, 0.25), orbit, value)


def test_numbers_that_change_unevenly_are_followed_as_well() -> None:
    orbit = orbits(turned(0.0), 1, modes=3).orbits[0]
    curve = SolutionCurve(Made(lambda angle: turned(angle)), "angle", 1, 1, 3, 1.0)
    check_points(curve, orbit, 0.0)
    assert curve.rows.near(0.3)[0] == 0.3  # the row is that of the value itself


def check_points(curve: SolutionCurve, orbit: object, value: float) -> None:
    here = curve.corrected(curve.unknowns(orbit, value), curve.level)
    for size in (1e-3, 0.02):
        start = here.x + size * here.tangent
        start[-2] += size  # the rigid velocity is found again, too: of a body that is held it is none
        found = curve.corrected(start, here.tangent)
        x, tangent = plainly(curve, start, here.tangent)
        assert found.x == pytest.approx(x, rel=0, abs=2e-12)
        assert found.tangent == pytest.approx(
            tangent, rel=0, abs=1e-5
        )  # the column of the parameter is that of a step before
        matrix, off = curve.linearised(found.x)
        motion = curve.motion(found.x)
        assert off == pytest.approx(motion.residuals, rel=0, abs=1e-12)
        plain = plain_matrix(curve, found.x)
        assert matrix == pytest.approx(plain, rel=1e-7, abs=1e-8 * float(np.abs(plain).max()))


@pytest.mark.parametrize(("name", "value"), [("restitution", 1.0), ("restitution", 0.0), ("d", 0.0)])
def test_rates_at_the_end_of_a_range_are_taken_from_inside(name: str, value: float) -> None:
    rows = ParameterRows(lambda at: numbers_of(SystemFamily(HAMMER).system({name: at}), 4), 0.25)
    rate = rows.rate(value)
    inside = 0.01 if value == 0.0 else 0.99
    far = numbers_of(SystemFamily(HAMMER).system({name: inside}), 4).row
    assert rows.at(value).row + (inside - value) * rate == pytest.approx(far, rel=1e-12, abs=1e-14)
    assert rows.near(inside)[0] == value  # even numbers: one row tells all
    with pytest.raises(PercussError):
        rows.at(value + 0.1 if value else -0.1)


def test_a_system_that_is_none_is_an_error_of_the_family() -> None:
    curve = SolutionCurve(SystemFamily(HAMMER), "restitution", 1, 1, 0, 0.25)
    with pytest.raises(ParameterError):
        curve.rows.at(1.5)
    with pytest.raises(CorrectorFailed):
        curve.corrected(np.array([2.3, -1.0, 6.0]), curve.level)


@given(
    values=st.lists(st.floats(0.3, 1.2), min_size=2, max_size=2, unique=True),
    modes=st.sampled_from([0, 3, 16]),
    name=st.sampled_from(["mean", "s", "restitution", "eta"]),
)
def test_rows_of_straight_lines_are_those_of_the_systems(values: list[float], modes: int, name: str) -> None:
    """From one value to the other by the rate, and the row itself, agree wherever it is said that they do."""
    base, value = values
    family = SystemFamily(HAMMER)
    if name == "eta":
        family = SystemFamily(System(UniformBar(5.0, KelvinVoigt(1e-3)), HAMMER.load, HAMMER.contact))
    if name == "restitution":
        base, value = base / 1.2, value / 1.2
    rows = ParameterRows(lambda at: numbers_of(family.system({name: at}), modes), 0.25)
    rate, row = rows.rate(base), rows.at(base).row
    here = numbers_of(family.system({name: value}), modes).row
    if rows.fits(base, rate, value):
        assert here == pytest.approx(row + (value - base) * rate, rel=1e-13, abs=1e-13)
    else:
        assert not np.allclose(here, row + (value - base) * rate, rtol=1e-15, atol=0.0)


def test_modes_that_are_searched_for_are_followed_too() -> None:
    """A stepped bar, whose frequencies do not change evenly with its wave speed."""
    body = SteppedBar(5.0, impedances=(2.0, 1.0), transit_times=(1.0, 2.0), damping=Ratio(1e-3))
    orbit = orbits(System(body, HAMMER.load, HAMMER.contact), 1, modes=3).orbits[0]
    check_points(SolutionCurve(SystemFamily(orbit.system), "s", 1, 1, 3, 1.0), orbit, 5.0)
