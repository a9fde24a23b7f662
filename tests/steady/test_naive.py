"""The oracle itself: it reproduces the reference numbers, and its independent ways agree with each other."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import naive
from naive import Case, Fourier, Square, mp

ENTRIES = naive.reference()
BY_NAME = {entry["name"]: entry for entry in ENTRIES}
STATES = [pytest.param(entry, i, id=f"{entry['name']}-{i}") for entry in ENTRIES for i in range(len(entry["states"]))]


def close(value: Any, expected: Any, tolerance: float) -> bool:
    """Relative above 1, absolute below."""
    value, expected = mp.mpf(value), mp.mpf(expected)
    return bool(abs(value - expected) <= tolerance * max(1, abs(expected)))


def farthest(ours: Any, theirs: Any) -> float:
    """The largest distance of two sets of complex numbers, matched one by one."""
    left, worst = [complex(z) for z in theirs], 0.0
    for z in ours:
        nearest = min(left, key=lambda w, z=complex(z): abs(w - z))  # type: ignore[misc]
        worst = max(worst, abs(nearest - complex(z)))
        left.remove(nearest)
    assert not left
    return worst


# ---------------------------------------------------------------- the reference file


@pytest.mark.parametrize("entry", ENTRIES, ids=lambda entry: entry["name"])
def test_level_and_number_of_phases(entry: dict[str, Any]) -> None:
    case = naive.reference_case(entry)
    assert close(naive.level(case), entry["level_c"], 1e-14)
    assert len(naive.phases(case)) == len(entry["states"]) == naive.sign_changes(case)


@pytest.mark.parametrize(("entry", "i"), STATES)
def test_reduced_numbers(entry: dict[str, Any], i: int) -> None:
    case, state = naive.reference_case(entry), entry["states"][i]
    phase = naive.phases(case)[i]
    sigma = naive.sigma_closed(case, phase)
    a = naive.reduced_coefficients(case, phase, sigma)
    assert close(phase, state["phi"], 1e-14)
    assert abs(sigma - mp.mpf(state["sigma"])) < 1e-16
    assert abs(sigma - naive.sigma_sum(case, phase)) < mp.mpf("1e-35")
    for ours, theirs in zip(reversed(a), state["a"], strict=True):
        assert close(ours, theirs, 1e-14)
    for ours, theirs in zip(naive.schur(a), state["schur"], strict=True):
        assert close(ours, theirs, 1e-14)
    moduli = naive.reduced_moduli(a)
    for ours, theirs in zip(moduli, state["reduced_moduli"], strict=True):
        assert close(ours, theirs, 1e-14)
    assert (moduli[0] < 1) is state["reduced_stable"]


@pytest.mark.parametrize(("entry", "i"), STATES)
def test_striking_speed_with_16_modes(entry: dict[str, Any], i: int) -> None:
    """The reference cuts *both* the forced part and the transient after mode 16."""
    case, state = naive.reference_case(entry), entry["states"][i]
    o = naive.orbit(case, naive.phases(case)[i], 16)
    expected = mp.mpf(state["striking_speed_N16"])
    assert close(naive.striking_speed(o), expected, 2e-15)
    # with the forced part of all modes in closed form it would be another number
    assert abs(naive.striking_speed_closed_forced(o) - expected) > 1e-7


@pytest.mark.parametrize(("entry", "i"), STATES)
def test_exact_moduli_with_8_modes(entry: dict[str, Any], i: int) -> None:
    case, state = naive.reference_case(entry), entry["states"][i]
    values = naive.multipliers(naive.orbit(case, naive.phases(case)[i], 8))
    assert len(values) == 18
    assert np.abs(values[:3]) == pytest.approx(state["exact_moduli_N8_top3"], rel=0, abs=1e-10)


# ---------------------------------------------------------------- the steady state


@pytest.mark.parametrize(("entry", "i"), STATES)
def test_state_returns_and_meets_the_wall(entry: dict[str, Any], i: int) -> None:
    """Independent of (14) and of the 2x2 systems: all modes, the rigid position too, come back after T."""
    case = naive.reference_case(entry)
    o = naive.orbit(case, naive.phases(case)[i], 6)
    assert naive.return_error(o) < mp.mpf("1e-42")
    assert abs(naive.field(o, 1, 0)[0]) < mp.mpf("1e-45")


@pytest.mark.parametrize("d", ["1e-40", "1e-12", "1e-6", "0.3", "40"])
def test_rigid_mode_from_no_damping_to_overdamping(d: str) -> None:
    """The textbook forms have digits enough for any d, and overdamped modes (d = 40, s = 2) close too."""
    case = Case.of(Fourier.of([mp.mpf("1e-3"), 1]), 2, d, "0.6", 1)
    found = naive.phases(case)
    assert len(found) == 2
    for phase in found:
        assert naive.return_error(naive.orbit(case, phase, 8)) < mp.mpf("1e-42")


@pytest.mark.parametrize("name", ["mild", "slow wave", "random-1-3", "random-1-6"])
def test_flight_agrees_with_the_modal_equations_integrated(name: str) -> None:
    case = naive.reference_case(BY_NAME[name])
    o = naive.orbit(case, naive.phases(case)[-1], 4)
    state = naive.flight_ode(case, o.phase, o.after, case.period)
    assert state == pytest.approx(np.array(o.before, dtype=float), rel=0, abs=3e-9)


def test_doubles_agree_with_many_digits() -> None:
    case = naive.reference_case(BY_NAME["random-1-3"])
    phase = naive.phases(case)[0]
    o, fast = naive.orbit(case, phase, 12), naive.many_modes(case, phase, 12)
    assert fast["u"] == pytest.approx([float(u) for u, _ in o.after[1:]], rel=1e-10)
    assert fast["after"] == pytest.approx([float(v) for _, v in o.after[1:]], rel=1e-10)
    assert fast["before"] == pytest.approx([float(v) for _, v in o.before[1:]], rel=1e-10)
    times = np.array([0.0, 0.7, 5.1, float(case.period)])
    u, v = naive.sampled(o, times)
    for j, t in enumerate(times):
        exact = [naive.flight(case, n, phase, x, mp.mpf(t)) for n, x in enumerate(o.after)]
        assert u[:, j] == pytest.approx([float(x) for x, _ in exact], rel=0, abs=1e-11)
        assert v[:, j] == pytest.approx([float(x) for _, x in exact], rel=0, abs=1e-11)


# ---------------------------------------------------------------- fields, energy, rest


@pytest.mark.parametrize("name", ["random-1-2", "random-1-10"])
@pytest.mark.parametrize("x", ["0", "0.37", "1"])
def test_forced_part_summed_mode_by_mode_is_the_closed_form(name: str, x: str) -> None:
    case = naive.reference_case(BY_NAME[name])
    load, t = case.load, mp.mpf("1.3")
    assert isinstance(load, Fourier)
    closed = naive.forced_field_closed(case, mp.mpf(x), t)
    summed = load.mean * 2 * naive.cosine_sum(1, mp.mpf(x)) / case.s**2 + load.sum(
        lambda k: naive.elastic_transfer(case, k, mp.mpf(x)), t
    )
    assert abs(summed - closed[0]) < mp.mpf("1e-28")
    plain = naive.forced_field(case, mp.mpf(x), t, 300)  # and with no help at all
    assert abs(plain[0] - closed[0]) < 2e-3 / case.s**2
    assert abs(plain[1] - closed[1]) < 2e-3 / case.s**2


def test_field_has_its_velocity_and_strain_as_slopes() -> None:
    case = naive.reference_case(BY_NAME["slow wave"])
    o = naive.orbit(case, naive.phases(case)[1], 5)
    x, t, h = mp.mpf("0.3"), mp.mpf("2.1"), mp.mpf("1e-15")
    _, velocity, strain = naive.field(o, x, t)
    along = (naive.field(o, x + h, t)[0] - naive.field(o, x - h, t)[0]) / (2 * h)
    in_time = (naive.field(o, x, t + h)[0] - naive.field(o, x, t - h)[0]) / (2 * h)
    assert abs(along - strain) < mp.mpf("1e-25")
    assert abs(in_time - velocity) < mp.mpf("1e-25")


@pytest.mark.parametrize(("entry", "i"), STATES)
def test_energy_closes(entry: dict[str, Any], i: int) -> None:
    case = naive.reference_case(entry)
    e = naive.energy(naive.orbit(case, naive.phases(case)[i], 8))
    assert e.input == pytest.approx(e.damping + e.impact, rel=3e-12)


@pytest.mark.parametrize("k", [1, 3])
def test_contact_transfer_by_the_held_modes(k: int) -> None:
    case = Case.of(Fourier.of([0.9, 1.0]), 0.7, 0.2, 0.5, 1)
    closed = 1 / mp.cos(mp.sqrt(mp.mpc(k * k, -k * case.d)) / case.s)
    assert abs(naive.contact_transfer(case, k) - closed) < mp.mpf("1e-35")


def test_least_contact_force() -> None:
    case = naive.reference_case(BY_NAME["random-1-10"])
    least, phase = naive.least_contact_force(case)
    seen = min(naive.contact_force(case, mp.mpf(t)) for t in np.linspace(0, 2 * np.pi, 401))
    assert least <= seen < least + 1e-2
    assert abs(naive.contact_force(case, phase) - least) < mp.mpf("1e-40")
    assert abs(naive.least_contact_force(Case.of(Fourier.of([2, 1.0]), 1e12, 0, 0.5, 1))[0] - 1) < 1e-20


# ---------------------------------------------------------------- multipliers


@pytest.mark.parametrize(
    ("name", "i", "modes"),
    [("elastic instability", 1, 8), ("slow wave", 1, 4), ("random-1-2", 1, 3), ("random-1-6", 0, 3)],
)
def test_multipliers_two_ways(name: str, i: int, modes: int) -> None:
    """Saltation against differences of the nonlinear map: entry by entry, and the eigenvalues."""
    case = naive.reference_case(BY_NAME[name])
    o = naive.orbit(case, naive.phases(case)[i], modes)
    derived, differenced = naive.saltation_jacobian(o), naive.difference_jacobian(o)
    assert mp.mnorm(derived - differenced, mp.inf) < mp.mpf("1e-18") * mp.mnorm(derived, mp.inf)
    ours = naive.without_the_flow(naive.eigenvalues(derived))
    theirs = naive.without_the_flow(naive.eigenvalues(differenced))
    assert len(ours) == 2 * modes + 2
    assert farthest(ours, theirs) < 1e-16
    assert farthest(ours, naive.multipliers(o)) < 1e-9


def test_multipliers_of_the_square_two_ways() -> None:
    case = Case.of(Square.of(1, "1.3"), 3, "0.01", "0.5", 1)
    o = naive.orbit(case, naive.phases(case)[0], 3)
    derived, differenced = naive.saltation_jacobian(o), naive.difference_jacobian(o)
    assert mp.mnorm(derived - differenced, mp.inf) < mp.mpf("1e-18") * mp.mnorm(derived, mp.inf)


def test_product_of_the_multipliers() -> None:
    """Liouville: a flight contracts volumes by E for every mode, the reset by R for every mode, and once
    more by R since the wall is left R times as fast as it is met. So the product is R**(N + 2) E**(N + 1),
    whatever the coupling."""
    case = naive.reference_case(BY_NAME["slow wave"])
    o = naive.orbit(case, naive.phases(case)[1], 4)
    product = mp.fprod(naive.multipliers_by_saltation(o))
    pair = naive.mode_pair(case, 1)
    assert abs(pair[0] * pair[1] - case.R * mp.exp(-case.d * case.period)) < mp.mpf("1e-40")
    expected_product = case.R ** (o.modes + 2) * mp.exp(-case.d * case.period * (o.modes + 1))
    assert abs(abs(product) / expected_product - 1) < mp.mpf("1e-30")


# ---------------------------------------------------------------- the square wave, piece by piece


@pytest.mark.parametrize("d", ["0", "0.02"])
def test_square_response_is_periodic_and_obeys_its_equation(d: str) -> None:
    load, damping, w2 = Square.of("0.8", "1.3"), mp.mpf(d), mp.mpf(7)
    begin = load.response(w2, damping, mp.mpf("0.5"))
    back = load.response(w2, damping, mp.mpf("0.5") + 6 * naive.PI)
    assert max(abs(x - y) for x, y in zip(begin, back, strict=True)) < mp.mpf("1e-45")

    state = np.array([float(x) for x in begin])
    edges = [0.5, float(load.kappa * naive.PI), 2 * np.pi, 2 * np.pi + 0.5]
    for (left, right), force in zip(pairwise(edges), [0.8, -0.8, 0.8], strict=True):

        def rate(t: float, z: NDArray[np.float64], force: float = force) -> NDArray[np.float64]:
            return np.array([z[1], force - float(d) * z[1] - 7 * z[0]])

        state = solve_ivp(rate, (left, right), state, method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
    assert state == pytest.approx([float(x) for x in begin], rel=0, abs=1e-10)


def test_square_is_the_limit_of_its_series() -> None:
    """v_f has coefficients like 1/k**2: the truncation costs about 1/K there."""
    square, d, t = Square.of(1, "1.3"), mp.mpf("0.05"), mp.mpf("2.2")
    exact = square.rigid(d, t)[1]
    errors = [abs(square.fourier(K).rigid(d, t)[1] - exact) for K in (50, 400)]
    assert errors[0] < 2e-3
    assert errors[1] < errors[0] / 8
    response = square.response(mp.mpf(40), d, t)
    series = square.fourier(400).response(mp.mpf(40), d, t)
    assert abs(series[0] - response[0]) < 1e-7
    assert abs(series[1] - response[1]) < 1e-5


@pytest.mark.parametrize("d", ["0", "1e-12", "0.01"])
def test_square_states_return(d: str) -> None:
    case = Case.of(Square.of(1, "1.3"), 3, d, "0.5", 1)
    found = naive.phases(case)
    assert len(found) == 2
    for phase in found:
        assert abs(naive.v_f(case, phase) - naive.level(case)) < mp.mpf("1e-42")
        o = naive.orbit(case, phase, 4)
        assert naive.return_error(o) < mp.mpf("1e-42")
        state = naive.flight_ode(case, phase, o.after, case.period)
        assert state == pytest.approx(np.array(o.before, dtype=float), rel=0, abs=1e-8)
