"""Bodies: modes, damping and shapes of uniform bars, and bars of sections in SI."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from percuss import steady_states
from percuss.errors import Interrupted, ParameterError
from percuss.halting import halting, interruptible
from percuss.model import (
    Bar,
    Chamber,
    Damping,
    External,
    KelvinVoigt,
    Kept,
    Load,
    Machine,
    Modes,
    Port,
    Ratio,
    Reversed,
    Section,
    SectionedBar,
    SteppedBar,
    System,
    Table,
    UniformBar,
    Valve,
)
from percuss.model.body.body import Body
from percuss.model.described import describe_system, system_from
from percuss.plot.canvas import stress_of

# -- bodies and the laws of their damping ----------------------------------------------------------------------------


MANY = 40_000
LAWS = [External(0.0), External(0.3), Ratio(1e-3), Ratio(0.4), Ratio(1.0), KelvinVoigt(1e-3), Table((0.1, 0.4, 0.2))]
PLACES = st.floats(0.0, 1.0)


def summed(bar: UniformBar, k: np.ndarray, x: np.ndarray, source: float) -> np.ndarray:
    """Σ φ_n(x) φ_n(source)/(ω² + ik d − k²) as it stands, and the sum of 1/ω² beyond the last mode."""
    n = np.arange(1, MANY + 1)
    omega = math.pi * bar.s * n
    rows = 2.0 * np.cos(math.pi * np.outer(x, n)) * np.cos(math.pi * n * source)
    gains = 1.0 / (omega[:, None] ** 2 + 1j * k * bar.damping.of(omega)[:, None] - k**2)
    return (rows @ gains).T


@pytest.mark.parametrize("law", LAWS, ids=str)
@pytest.mark.parametrize("source", [0.0, 0.35, 1.0])
def test_the_receptance_is_the_sum_of_the_modes(law: Damping, source: float) -> None:
    """To the rest of the sum, which falls off like 1/MANY."""
    x, k = np.array([0.0, 0.2, 0.35, 0.8, 1.0]), np.array([1.0, 2.0, 7.0])
    for s in (0.7, 20.0):
        bar = Somewhere(s, law, source)
        found = bar.receptance(k, x, 1).displacement
        scale = 2.0 / (math.pi * s) ** 2
        assert np.abs(found - summed(bar, k, x, source)).max() <= 1.2 * scale / MANY


@pytest.mark.parametrize("law", LAWS, ids=str)
def test_strain_is_the_slope_of_the_displacement(law: Damping) -> None:
    bar, k, step = Somewhere(1.3, law, 0.35), np.array([1.0, 3.0]), 1e-5
    for x in (0.1, 0.5, 0.9):
        sides = bar.receptance(k, np.array([x - step, x + step]), 1).displacement
        slope = bar.receptance(k, np.array([x]), 1).strain[:, 0]
        assert slope == pytest.approx((sides[:, 1] - sides[:, 0]) / (2.0 * step), rel=1e-6, abs=1e-7)
        still = bar.static(np.array([x - step, x + step]), 1).displacement
        assert bar.static(np.array([x]), 1).strain[0] == pytest.approx((still[1] - still[0]) / (2.0 * step), abs=1e-7)


class Somewhere(UniformBar):
    """A uniform bar with a second place for a load."""

    def __init__(self, s: float, damping: Damping, source: float) -> None:
        super().__init__(s, damping)
        object.__setattr__(self, "source", source)

    @property
    def places(self) -> tuple[float, ...]:
        return (0.0, self.source)  # type: ignore[attr-defined]

    __hash__ = object.__hash__


class Plain(Somewhere):
    """The same without closed forms: what follows from the contract alone."""

    lossless_receptance = Body.lossless_receptance


@pytest.mark.parametrize("law", LAWS, ids=str)
def test_what_follows_by_itself_is_the_closed_form(law: Damping) -> None:
    x, k = np.linspace(0.0, 1.0, 7), np.array([1.0, 5.0])
    closed, sums = Somewhere(3.0, law, 0.2), Plain(3.0, law, 0.2)
    for at in (0, 1):
        whole, plain = closed.receptance(k, x, at), sums.receptance(k, x, at)
        assert np.abs(whole.displacement - plain.displacement).max() <= 1e-12
        assert np.abs(whole.strain - plain.strain).max() <= 1e-8  # sums of 1/n³


@pytest.mark.parametrize("law", LAWS, ids=str)
@pytest.mark.parametrize("k", [1.0, 2.0, 9.0])
def test_the_lossless_bar_stands_for_the_damped_one(law: Damping, k: float) -> None:
    """For every mode where the law says so, else for those in resonance or with an error that is worked out apart."""
    omega = np.array([0.3, 1.0, k, 2.5 * k, 100.0])
    found = law.lossless(np.array([k]))
    assert found.z[0].imag <= 0.0
    stiff = omega**2 + 1j * k * law.of(omega) - k**2
    other = (omega**2 - found.z**2) / found.factor
    if found.exact:
        assert np.abs(stiff - other).max() <= 1e-12 * np.abs(stiff).max()
    elif isinstance(law, Ratio):
        assert abs(stiff[2] - other[2]) <= 1e-14 * k**2


@pytest.mark.parametrize("law", LAWS, ids=str)
def test_time_in_seconds_and_in_radians(law: Damping) -> None:
    """d_n is a rate: ω and d_n scale together."""
    omega, turn = np.array([3.0, 5.0, 8.0, 13.0]), 7.0
    assert law.per_radian(turn).of(omega / turn) == pytest.approx(law.of(omega) / turn, rel=1e-14)
    assert law.per_radian(turn).rigid == pytest.approx(law.rigid / turn, rel=1e-14)
    assert law.is_zero == (not law.of(omega).any() and law.rigid == 0.0)


def test_only_external_damping_drags_the_whole_bar() -> None:
    assert [law.rigid for law in LAWS] == [0.0, 0.3, 0.0, 0.0, 0.0, 0.0, 0.0]


def test_modes_beyond_a_table_keep_the_ratio_of_its_last() -> None:
    omega = np.array([1.0, 2.0, 4.0, 8.0])
    assert Table((0.1, 0.4)).of(omega).tolist() == [0.1, 0.4, 0.8, 1.6]
    assert Table((0.1, 0.4, 0.2, 0.3, 0.5)).of(omega).tolist() == [0.1, 0.4, 0.2, 0.3]


def test_modes_of_the_uniform_bar() -> None:
    """B77's numbers to the last bit: nπs, 2(−1)ⁿ, and the weight 2."""
    modes = UniformBar(20.0, External(0.1)).modes(6)
    assert isinstance(modes, Modes)
    assert modes.omega.tolist() == (np.pi * 20.0 * np.arange(1, 7)).tolist()
    assert modes.gamma.tolist() == [-2.0, 2.0] * 3 and modes.weight.tolist() == [2.0] * 6
    assert modes.damping.tolist() == [0.1] * 6 and modes.end == pytest.approx([math.sqrt(2.0)] * 6)
    with pytest.raises(ValueError, match="read-only"):
        modes.omega[0] = 1.0


@given(s=st.floats(0.01, 100.0), at=st.floats(0.01, 500.0))
def test_the_nearest_mode(s: float, at: float) -> None:
    n = UniformBar(s).nearest(at)
    assert abs(n - max(1, at / (math.pi * s))) <= 0.5 * (1.0 + 1e-12)


@given(s=st.floats(0.05, 100.0))
def test_nearest_modes_by_search_and_in_closed_form(s: float) -> None:
    bar, wanted = UniformBar(s), np.array([0.01, 0.6, 1.49, 1.51, 7.3, 40.2]) * math.pi * s
    assert bar.nearest(wanted).tolist() == Body.nearest(bar, wanted).tolist() == [1, 1, 1, 2, 7, 40]
    n = bar.nearest(wanted)
    assert bar.frequency(n) == pytest.approx(Body.frequency(bar, n), rel=1e-15)


@pytest.mark.parametrize("law", LAWS, ids=str)
def test_the_held_bar_by_receptances_and_in_closed_form(law: Damping) -> None:
    bar, k = Somewhere(1.3, law, 0.35), np.array([1.0, 2.0, 5.0])
    for at in (0, 1):
        assert np.abs(bar.held_transfer(k, at) - Body.held_transfer(bar, k, at)).max() <= 1e-10
    resonant = UniformBar(4.0 / (3.0 * math.pi))  # k = 2 is 3/2 of the first frequency
    assert np.isinf(resonant.held_transfer(k)).tolist() == [False, True, False]


def test_the_same_body_with_another_damping() -> None:
    assert UniformBar(2.0, Ratio(0.1)).damped_by(External(0.5)) == UniformBar(2.0, External(0.5))


def test_the_bar_in_si_and_its_body() -> None:
    bar = Bar(length=0.3, diameter=0.05, damping=Ratio(0.01))
    body = bar.body(100.0)
    assert body.s == pytest.approx(bar.wave_speed / 30.0, rel=1e-15) and body.damping == Ratio(0.01)
    assert bar.contact_duration == pytest.approx(2.0 * 0.3 / bar.wave_speed, rel=1e-15)
    assert bar.youngs_modulus_at(np.array([0.0, 0.5, 1.0])).tolist() == [210e9] * 3
    assert bar.rigid_drag == 0.0 and Bar(length=0.3, diameter=0.05, drag=40.0).rigid_drag == pytest.approx(12.0)


# -- stepped bars in si ----------------------------------------------------------------------------------------------


FIGURES = json.loads((Path(__file__).parents[1] / "data" / "blow.json").read_text(encoding="utf-8"))
MODES = next(case for case in FIGURES if case["kind"] == "modes")
PISTON = SectionedBar([Section(0.12, diameter=0.052), Section(0.25, diameter=0.04, bore=0.01)], Ratio(1e-3))
LOAD = Load.fourier([900.0, 1000.0], frequency=60.0)


def test_modes_of_three_sections_and_two_materials() -> None:
    bar = SectionedBar(
        [Section(length, area, youngs_modulus=e, density=rho) for length, area, e, rho in MODES["sections"]]
    )
    wanted = {key: np.array(value, dtype=float) for key, value in MODES["expect"].items()}
    assert bar.mass == pytest.approx(wanted["mass"], rel=1e-14)
    assert bar.transit_time == pytest.approx(wanted["transit_time"], rel=1e-14)
    assert 2.0 * np.pi * bar.natural_frequencies(12) == pytest.approx(wanted["angular_frequency"], rel=1e-12)
    body = bar.body(100.0)
    end = body.modes(12).end
    driven = body.shapes(np.array([0.0]), 12).displacement[0]
    sign = np.sign(driven)  # the reference has the driven end positive
    assert sign * driven * end == pytest.approx(wanted["phi_driven_end"], rel=1e-12)
    assert sign * end == pytest.approx(wanted["phi_striking_end"], rel=1e-12)


def test_equal_sections_are_the_uniform_bar() -> None:
    bar, parts = Bar(0.4, 1e-3), SectionedBar([Section(0.1, 1e-3), Section(0.3, 1e-3)])
    for name in ("length", "mass", "transit_time", "wave_speed", "impedance", "contact_duration"):
        assert getattr(parts, name) == pytest.approx(getattr(bar, name), rel=1e-14)
    assert parts.natural_frequencies(5) == pytest.approx(bar.natural_frequencies(5), rel=1e-13)
    one, other = (System.from_si(own, LOAD, Kept(0.5)) for own in (bar, parts))
    assert other.load.coefficients == pytest.approx(one.load.coefficients, rel=1e-13)
    assert other.force_scale == pytest.approx(one.force_scale, rel=1e-13)


def test_a_section_with_a_bore_is_a_tube() -> None:
    hollow, plain = PISTON.pieces[1], PISTON.pieces[0]
    assert hollow.area == pytest.approx(math.pi / 4.0 * (0.04**2 - 0.01**2), rel=1e-14)
    assert (hollow.diameter, hollow.bore, plain.bore) == (0.04, 0.01, 0.0)
    by_area = SectionedBar([Section(0.1, area=2e-3, bore=0.01)]).pieces[0]
    assert math.pi / 4.0 * (by_area.diameter**2 - 0.01**2) == pytest.approx(2e-3, rel=1e-14)


def test_steps_lie_where_the_sections_meet() -> None:
    body = PISTON.body(377.0)
    assert body.places == (0.0, pytest.approx(0.12 / 0.37, rel=1e-15))
    soft = SectionedBar([Section(0.1, 1e-3, youngs_modulus=70e9), Section(0.2, 1e-3)])
    at = np.array([0.0, *soft.body(1.0).places[1:], 1.0])
    assert soft.youngs_modulus_at(at).tolist() == [70e9, 210e9, 210e9]


def test_the_stress_is_that_of_the_material_at_each_place() -> None:
    parts = [Section(0.1, 1e-3, youngs_modulus=70e9, density=2700.0), Section(0.2, 1e-3)]
    system = System.from_si(SectionedBar(parts, Ratio(0.05)), LOAD, Kept(0.6))
    orbit = steady_states(system).orbits[0]
    step, t = system.body.place(1), np.array([1.0, 3.0])
    at = np.array([step - 1e-9, step + 1e-9])
    strain = orbit.strain(at, t)
    before, after = system.stress(at, strain)
    assert np.abs(strain[0] / strain[1]) == pytest.approx(3.0, rel=1e-2)
    assert before == pytest.approx(after, rel=1e-2)  # equal areas: the same force, the same stress
    assert system.stress(at, strain[:, 0]) == pytest.approx([before[0], after[0]])
    assert stress_of(system, at, strain)[0] == pytest.approx(before / 1e6)
    plain = System(s=5.0, d=0.0, restitution=0.3, load=Load.harmonic(0.5, 1.0))
    assert stress_of(plain, at, strain) is strain
    with pytest.raises(ParameterError, match="from_si"):
        plain.stress(at, strain)
    with pytest.raises(ParameterError, match="a row for each of 3"):
        system.stress([0.0, 0.5, 1.0], strain)


def test_a_system_of_it_goes_through_json() -> None:
    system = System.from_si(PISTON, LOAD.acting_at(1), Kept(0.3))
    again = system_from(json.loads(json.dumps(describe_system(system))))
    assert again.body == system.body and again.bar == PISTON and again.load.at == 1
    assert isinstance(again.body, SteppedBar) and again.frequency == 60.0


def test_areas_that_jump_by_nearly_a_million() -> None:
    bar = SectionedBar([Section(0.2, 1.1e-6), Section(0.2, 1.0), Section(0.2, 1.1e-6)])
    assert np.all(np.diff(bar.natural_frequencies(20)) > 0.0)
    assert bar.body(1.0).modes(20).inertia.min() > 0.0


# -- the machine that switches its own valve ---------------------------------------------------------------------------


PORTS = (Port("power", behind=0.13, side="back", delay=5e-3), Port("return", behind=0.004, side="front", delay=5e-4))


def valve(stiffness: float = 0.0) -> Valve:
    return Valve({"return": -0.4, "power": 1.8}, PORTS, chamber=Chamber(0.1, stiffness))


@given(s=st.floats(0.5, 100.0), stiffness=st.floats(1e-6, 1e3), modes=st.integers(0, 40), reads=st.floats(0.0, 1.0))
def test_modes_solve_the_equations_of_the_bars_own_coordinates(
    s: float, stiffness: float, modes: int, reads: float
) -> None:
    """r'' + ω² r + κ e eᵀ r = e p in the own coordinates r = V m."""
    body = UniformBar(s, External(0.01))
    machine = Machine(body, valve(stiffness), Kept(0.2))
    found, n = machine.modes(modes), np.arange(modes + 1)
    root = np.where(n == 0, 1.0, np.sqrt(2.0))
    driven = root * np.where(n % 2, -1.0, 1.0)  # where the striking end moves the same way in every mode
    stiff = np.diag((n * np.pi * s) ** 2) + stiffness * np.outer(driven, driven)
    assert found.mixing @ np.diag(found.omega**2) @ found.mixing.T == pytest.approx(stiff, abs=1e-12 * stiff.max())
    assert found.mixing @ found.mixing.T == pytest.approx(np.eye(modes + 1), abs=1e-12)
    assert found.mixing @ found.driven == pytest.approx(driven, abs=1e-11)
    assert found.mixing @ found.end == pytest.approx(root, abs=1e-11)
    assert found.mixing @ found.centre == pytest.approx(np.eye(modes + 1)[0], abs=1e-12)
    assert np.all(found.damping == 0.01)
    shapes = found.at(body, np.array([0.0, reads, 1.0]))
    wave = driven * np.cos(n * np.pi * reads)
    assert shapes == pytest.approx(np.array([driven, wave, root]) @ found.mixing, abs=1e-9)


def test_modes_come_to_the_bar_on_a_spring() -> None:
    """θ tan θ = κ/s² of the continuous bar, θ = ω/s."""
    s, stiffness = 2.0, 3.0
    found = Machine(UniformBar(s), valve(stiffness), Kept(0.2)).modes(400)
    for i in range(3):
        low, high = i * np.pi + 1e-9, (i + 0.5) * np.pi - 1e-9
        theta = brentq(lambda t: t * np.tan(t) - stiffness / s**2, low, high, xtol=1e-15)
        assert found.omega[i] == pytest.approx(s * theta, rel=1e-3)


@pytest.mark.parametrize("body", [UniformBar(20.0, Ratio(1e-3)), SteppedBar(20.0, (1.0, 3.0), (0.4, 0.6))])
def test_without_a_chamber_they_are_the_bodys_own(body: UniformBar | SteppedBar) -> None:
    found, own = Machine(body, valve(), Kept(0.2)).modes(5), body.modes(5)
    assert found.omega[0] == found.damping[0] == 0.0
    assert np.array_equal(found.omega[1:], own.omega) and np.array_equal(found.damping[1:], own.damping)
    assert found.end[1:] * found.driven[1:] == pytest.approx(own.gamma, rel=1e-14)
    assert np.array_equal(found.mixing, np.eye(6))


def test_one_free_motion_less_stiff_goes_over_into_the_rigid_one() -> None:
    soft = Machine(UniformBar(20.0), valve(1e-9), Kept(0.2)).modes(4)
    free = Machine(UniformBar(20.0), valve(), Kept(0.2)).modes(4)
    assert soft.omega == pytest.approx(free.omega, abs=1e-4) and soft.end == pytest.approx(free.end, abs=1e-9)


def test_si_numbers_are_those_of_one_kilogram_and_one_second() -> None:
    oil = Valve({"return": -13120.0, "power": 12480.0}, PORTS, chamber=Chamber(9000.0, 20000.0))
    bar = Bar(length=1.25, diameter=0.12)
    machine = Machine.from_si(bar, oil, Reversed(0.15), pressure=160e5)
    assert machine.valve.force("power") * machine.force_scale == pytest.approx(21480.0)
    assert machine.valve.ports[0].behind == pytest.approx(0.13 / 1.25)
    assert machine.valve.ports[0].delay == 5e-3
    gas = machine.valve.chamber.stiffness * machine.force_scale / machine.length_scale
    assert gas == pytest.approx(20000.0)
    assert machine.body.s == pytest.approx(np.sqrt(2.1e11 / 7850.0) / 1.25)
    assert machine.energy_scale == pytest.approx(bar.mass * 1.25**2)
    assert "power" in str(machine)


def test_many_modes_on_gas_are_given_up_at_once():
    """Their matrix is one long call into LAPACK; one mode fewer or more than what is waited for by itself agree."""
    chamber = Chamber(0.1, 2.0)
    ports = [Port("power", behind=1.0, side="back"), Port("return", on="impact")]
    machine = Machine(UniformBar(20.0), Valve({"return": -0.4, "power": 1.8}, ports, chamber=chamber), Kept(0.2))
    few, many = machine.modes(299), machine.modes(300)
    assert few.omega[:100] == pytest.approx(many.omega[:100], rel=1e-6)
    with pytest.raises(Interrupted), halting(lambda: True):
        machine.modes(1500)
    with pytest.raises(ZeroDivisionError):
        interruptible(lambda: 1 // 0)
    assert interruptible(lambda: 5) == 5
