"""Multipliers of every body, damping and contact law: against plain flights, dense eigenvalues and what must hold."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from percuss import Load, System, stability_of, steady_states
from percuss.errors import ParameterError
from percuss.model import External, KelvinVoigt, Kept, Ratio, Reversed, Table, UniformBar
from percuss.model.body import Damping, Shape
from percuss.model.contact import Contact, Result
from percuss.stability import (
    LinearMap,
    exact_plane,
    floquet_multipliers,
    reduced_criterion,
    stability_plane,
    waveform_criterion,
)
from percuss.stability.plane import OUTCOMES
from percuss.stability.verdict import elastic_feedback
from percuss.steady import Orbit
from percuss.steady.multipliers import map_at_impact
from secular_roots import farthest, roots_of_poles, secular_roots

Array = NDArray[np.float64]
CASES = json.loads((Path(__file__).parent.parent / "data" / "blow.json").read_text(encoding="utf-8"))
DAMPINGS = [
    External(0.0),
    External(0.02),
    External(9.0),
    Ratio(2e-3),
    Ratio(0.3),
    KelvinVoigt(1e-4),
    KelvinVoigt(0.2),
    Table((0.3, 0.01, 40.0)),
]
"""None, little and more than critical (External(9), KelvinVoigt(0.2), the third of the table)."""


@dataclass(frozen=True)
class Drawn(UniformBar):
    """A bar whose modes are given: frequencies per s, γ_n, and 1/φ_n(1)²."""

    stretch: tuple[float, ...] = (1.0,)
    coupling: tuple[float, ...] = (-2.0,)

    kind = "drawn"

    def frequencies(self, count: int) -> Array:
        return np.asarray(np.pi * self.s * np.cumsum(np.resize(self.stretch, count)))

    def inertia(self, count: int) -> Array:
        return np.full(count, 0.4)

    def shapes(self, x: Array, count: int) -> Shape:
        """Only the ends are asked for."""
        there = np.resize(self.coupling, count) * self.inertia(count)
        rows = np.where(np.asarray(x)[:, None] == 0.0, there, 1.0)
        return Shape(rows, np.zeros_like(rows))


def system_of(damping: Damping, contact: Contact, s: float = 1.3, load: Load | None = None) -> System:
    return System(UniformBar(s, damping), load or Load.fourier([0.05, 1.0, 0.3j]), contact)


# ---------------------------------------------------------------- by plain flights


class Flights:
    """The map from impact to impact of (u_1 … u_N, u_0' … u_N', impact time), by integrating every mode."""

    def __init__(self, orbit: Orbit, modes: int) -> None:
        self.system, self.period, self.n = orbit.system, orbit.period, modes
        known = orbit.system.body.modes(modes, orbit.system.load.at)
        self.square = np.append(0.0, known.omega**2)
        self.damping = np.append(orbit.system.d, known.damping)
        self.gamma = np.append(1.0, known.gamma)
        self.coefficients = orbit.system.load.coefficients
        state = linear_start(orbit, modes)
        self.start = np.concatenate([state, [orbit.phase]])[:, None]

    def force(self, t: Array) -> Array:
        waves = np.exp(1j * np.outer(np.arange(self.coefficients.size), t))
        return np.asarray((self.coefficients @ waves).real)

    def fly(self, x: Array, start: Array, length: Array) -> Array:
        """Many states, one a column, each from its time on for its own length, as one system of equations."""
        n, shape = self.n + 1, x.shape

        def rate(part: float, flat: Array) -> Array:
            u, v = flat.reshape(shape)[:n], flat.reshape(shape)[n:]
            pull = self.force(start + part * length) - self.damping[:, None] * v - self.square[:, None] * u
            return np.concatenate([v, pull]).reshape(-1) * np.tile(length, 2 * n)

        flown = solve_ivp(rate, (0.0, 1.0), x.reshape(-1), "DOP853", rtol=1e-12, atol=1e-14)
        return np.asarray(flown.y[:, -1]).reshape(shape)

    def __call__(self, given: Array) -> Array:
        """From just after an impact to just after the next one, a period later or nearly so; one start a column."""
        u, v, begun = given[: self.n], given[self.n : -1], given[-1]
        x = np.concatenate([-self.gamma[None, 1:] @ u, u, v])
        length = np.full(begun.shape, self.period)
        now, x = begun + length, self.fly(x, begun, length)
        for _ in range(4):
            length = -(self.gamma @ x[: self.n + 1]) / (self.gamma @ x[self.n + 1 :])
            now, x = now + length, self.fly(x, now, length)
        law = self.system.contact
        after, turned = law.after(x[1 : self.n + 1], x[self.n + 1 :])
        return np.concatenate([after, turned, now[None] - self.period])

    def jacobian(self, step: float = 5e-6) -> Array:
        h = step * np.eye(self.start.size)
        return (self(self.start + h) - self(self.start - h)) / (2.0 * step)


def linear_start(orbit: Orbit, modes: int) -> Array:
    """u_n and u_n' just after the impact, from what the linear map was made of."""
    state, matrix = orbit.modal_state(modes), orbit.linear_map(modes)
    rigid = matrix.speed - float(matrix.blocks.gamma[1:] @ state.velocity)
    after, turned = orbit.system.contact.after(state.displacement, np.append(rigid, state.velocity))
    return np.concatenate([after, turned])


@pytest.mark.slow
@pytest.mark.parametrize("contact", [Kept(0.6), Reversed(0.6)], ids=["kept", "reversed"])
@pytest.mark.parametrize("damping", DAMPINGS, ids=str)
def test_multipliers_by_differences_of_plain_flights(damping: Damping, contact: Contact) -> None:
    load, s = (Load.fourier([0.2, 20.0]), 1.3) if damping.rigid > 1.0 else (Load.fourier([0.3, 1.0, 0.3j]), 1.9)
    orbit = max(steady_states(system_of(damping, contact, s, load), modes=2).orbits, key=lambda o: o.impact_velocity)
    assert orbit.impact_velocity > 0.2
    flights = Flights(orbit, 2)
    assert flights(flights.start) == pytest.approx(flights.start, abs=1e-9)
    expected = np.linalg.eigvals(flights.jacobian())
    assert farthest(floquet_multipliers(orbit, 2).values, expected) < 5e-6 * max(1.0, float(np.abs(expected).max()))


@pytest.mark.parametrize("contact", [Kept(0.0), Reversed(0.0), Kept(1.0), Reversed(1.0), Kept(0.3)], ids=str)
def test_other_modes_and_full_or_no_rebound_by_differences_of_plain_flights(contact: Contact) -> None:
    """Frequencies and γ_n of no uniform bar; R = 0 and R = 1."""
    if isinstance(contact, Reversed):
        system = system_of(Ratio(2e-3), contact, 1.9, Load.fourier([0.2, 1.0, 0.3j]))
    else:
        body = Drawn(1.9, Ratio(2e-3), stretch=(1.0, 0.7), coupling=(-1.4, 2.6))
        system = System(body, Load.fourier([0.2, 1.0, 0.3j]), contact)
    orbit = steady_states(system, modes=2).orbits[-1]
    flights = Flights(orbit, 2)
    assert flights(flights.start) == pytest.approx(flights.start, abs=1e-9)
    expected = np.linalg.eigvals(flights.jacobian())
    assert farthest(floquet_multipliers(orbit, 2).values, expected) < 5e-6


def test_a_mode_that_the_load_does_not_drive_stands_by_itself() -> None:
    damping = Ratio(5e-3)
    body = Drawn(2.0, damping, coupling=(-1.4, 0.0, 2.6, -2.0))
    orbit = steady_states(System(body, Load.harmonic(0.3, 1.0), Kept(0.4)), modes=6).orbits[0]
    values = floquet_multipliers(orbit, 6).values
    known, t = body.modes(6), orbit.period
    for n in (1, 5):  # modes 2 and 6
        half, rate = (
            math.exp(-0.5 * known.damping[n] * t),
            math.sqrt(known.omega[n] ** 2 - 0.25 * known.damping[n] ** 2),
        )
        lag = half * 0.5 * known.damping[n] * math.sin(rate * t) / rate
        a, e = half * math.cos(rate * t) + lag, half * math.cos(rate * t) - lag
        for root in np.roots([1.0, -(a - 0.4 * e), -0.4 * half**2]):
            assert np.abs(values - root).min() < 1e-12


# ---------------------------------------------------------------- the reference


def of_kind(kind: str) -> list[dict[str, Any]]:
    return [case for case in CASES if case["kind"] == kind]


def load_of(case: dict[str, Any]) -> Load:
    return Load.fourier([complex(float(re), float(im)) for re, im in case["load"]])


@pytest.mark.parametrize("case", of_kind("strain"), ids=lambda case: case["name"])
def test_reference_of_the_strain_at_the_impact(case: dict[str, Any]) -> None:
    r, modes = float(case["restitution"]), case["modes"]
    for law in (Kept(r), Reversed(r)):
        body = UniformBar(float(case["s"]), External(float(case["d"])))
        orbit = steady_states(System(body, load_of(case), law), case["m"], modes=modes).orbits[-1]
        expected = case["expect"][f"moduli_strain_{law.kind}_top3"]
        assert floquet_multipliers(orbit, modes).moduli[:3] == pytest.approx(expected, abs=case["tolerance"])


@pytest.mark.parametrize("case", of_kind("steady"), ids=lambda case: case["name"])
def test_reference_of_stepped_bars(case: dict[str, Any]) -> None:
    """The same from the sections, and the bar turned round: reciprocity leaves all of it as it is."""
    stepped = pytest.importorskip("percuss.model.body.stepped")
    value, r = float(case["damping"]["value"]), float(case["restitution"])
    damping = External(value) if case["damping"]["kind"] == "external" else Ratio(value)
    sections = [tuple(float(x) for x in case[name]) for name in ("impedances", "transit_times")]
    for turn in (1, -1):
        body = stepped.SteppedBar(float(case["s"]), *(part[::turn] for part in sections), damping=damping)
        found = steady_states(System(body, load_of(case), Kept(r)), case["m"]).orbits
        assert len(found) == len(case["expect"]["states"])
        for orbit, state in zip(found, case["expect"]["states"], strict=True):
            assert orbit.phase == pytest.approx(float(state["phi"]), abs=1e-9)
            reduced = reduced_criterion(orbit)
            if "sigma" in state:
                assert reduced.sigma == pytest.approx(float(state["sigma"]), rel=1e-9)
                assert reduced.a[::-1] == pytest.approx([float(a) for a in state["a"]], rel=1e-9)
                assert reduced.moduli == pytest.approx([float(x) for x in state["reduced_moduli"]], rel=1e-9)
            else:  # of eight modes; the others add a little
                assert reduced.sigma == pytest.approx(float(state["sigma_N8"]), rel=0.05)
                assert reduced.moduli == pytest.approx([float(x) for x in state["reduced_moduli"]], rel=1e-4)
            exact = [float(x) for x in state["exact_moduli_N8_top3"]]
            assert floquet_multipliers(orbit, 8).moduli[:3] == pytest.approx(exact, rel=1e-9)


# ---------------------------------------------------------------- the structure of the map


maps = st.builds(
    lambda s, damping, turned, r, coupling, stretch: (
        System(UniformBar(s, damping), Load.harmonic(0.3, 1.0), Reversed(r))
        if turned
        else System(
            Drawn(s, damping, stretch=tuple(stretch), coupling=tuple(coupling)), Load.harmonic(0.3, 1.0), Kept(r)
        )
    ),
    s=st.floats(0.2, 60.0),
    damping=st.sampled_from([*DAMPINGS, Ratio(1e-4), KelvinVoigt(1e-6)]),
    turned=st.booleans(),
    r=st.one_of(st.sampled_from([0.0, 1e-9, 1.0]), st.floats(0.0, 1.0)),
    coupling=st.lists(st.one_of(st.just(0.0), st.floats(-3.0, 3.0)), min_size=1, max_size=5),
    stretch=st.lists(st.floats(0.3, 2.0), min_size=1, max_size=4),
)


def map_of(system: System, modes: int, seed: int, periods: int = 1) -> LinearMap:
    """The map at some state before the impact; it need not be steady."""
    rng = np.random.default_rng(seed)
    size = 0.02 / (1.0 + np.arange(modes)) ** 2
    rise, speed = size * rng.normal(size=modes), np.append(1.0, size * rng.normal(size=modes))
    return map_at_impact(system, 2.0 * math.pi * periods, float(rng.uniform(-1.5, 1.5)), rise, speed)


@settings(max_examples=40, deadline=None)
@given(maps, st.sampled_from([0, 1, 3, 20, 45, 90]), st.integers(0, 2**32 - 1), st.integers(1, 3))
def test_secular_roots_are_the_dense_eigenvalues(system: System, modes: int, seed: int, periods: int) -> None:
    matrix = map_of(system, modes, seed, periods)
    whole = matrix.dense()
    roots = secular_roots(matrix)
    dense = np.linalg.eigvals(whole)
    noise = np.random.default_rng(0).normal(size=whole.shape) / math.sqrt(dense.size)
    doubt = farthest(dense, np.linalg.eigvals(whole + 1e-15 * np.linalg.norm(whole, 2) * noise))
    assert farthest(roots, dense) <= 1e-8 * max(1.0, float(np.abs(dense).max())) + 1e3 * doubt


@settings(max_examples=30, deadline=None)
@given(
    s=st.floats(0.3, 60.0),
    d=st.sampled_from([0.0, 0.01, 0.2]),
    r=st.floats(0.05, 1.0),
    modes=st.integers(0, 12),
    seed=st.integers(0, 2**32 - 1),
)
def test_multipliers_of_the_reversed_strain_are_mirrored_in_a_circle(
    s: float, d: float, r: float, modes: int, seed: int
) -> None:
    """The map is symplectic but for the factor R² exp(−dT): beside μ, R² exp(−dT)/μ is a multiplier too."""
    matrix = map_of(System(UniformBar(s, External(d)), Load.harmonic(0.3, 1.0), Reversed(r)), modes, seed)
    values = np.linalg.eigvals(matrix.dense())
    mirrored = r**2 * math.exp(-2.0 * math.pi * d) / values
    assert farthest(values, mirrored) <= 1e-6 * float(np.abs(mirrored).max())


@pytest.mark.parametrize(("s", "m"), [(5.0, 2), (7.2, 2)])
def test_elastic_multipliers_of_the_reversed_strain_have_the_modulus_r(s: float, m: int) -> None:
    """Exactly, until two of them or one and a rigid one meet; what leaves the circle then does so by some per cent."""
    for orbit in steady_states(System(UniformBar(s), Load.harmonic(0.9, 1.0), Reversed(0.8)), m).orbits:
        found = floquet_multipliers(orbit, 8)
        assert np.delete(found.moduli, found.rigid) == pytest.approx(np.full(16, 0.8), rel=1e-9)
        more = floquet_multipliers(orbit, 60)
        elastic = np.delete(more.moduli, more.rigid)
        assert elastic == pytest.approx(np.full(120, 0.8), rel=0.03)
        assert np.count_nonzero(np.abs(elastic - 0.8) < 1e-9) >= 112


@pytest.mark.parametrize("n", [1, 2, 40, 300])
def test_roots_beside_poles_in_the_plane(n: int) -> None:
    """Against the eigenvalues of diag(poles) minus a matrix of rank one."""
    rng = np.random.default_rng(n)
    poles = 0.6 * np.exp(1j * rng.uniform(-math.pi, math.pi, n))
    residues = (rng.normal(size=n) + 1j * rng.normal(size=n)) / n
    dense = np.linalg.eigvals(np.diag(poles) - np.outer(np.ones(n), residues))
    assert farthest(roots_of_poles(poles, residues), dense) < 1e-9


@pytest.mark.parametrize("damping", [External(0.0), External(0.0048), Ratio(1e-3), KelvinVoigt(1e-6)], ids=str)
def test_very_many_modes_of_the_reversed_strain(damping: Damping) -> None:
    orbit = steady_states(system_of(damping, Reversed(0.6), 20.0, Load.harmonic(0.9, 1.0))).orbits[-1]
    many = floquet_multipliers(orbit, 600)
    assert complex(many.values.sum()) == pytest.approx(np.trace(orbit.linear_map(600).dense()), abs=1e-9)
    assert many.rhythm == pytest.approx(floquet_multipliers(orbit, 40).rhythm, rel=0.03)


# ---------------------------------------------------------------- planes


@pytest.mark.parametrize("law", [Kept(0.5), Reversed(0.5)], ids=["kept", "reversed"])
@pytest.mark.parametrize("damping", [*DAMPINGS, Ratio(1.0)], ids=str)
def test_planes_are_single_orbits_under_every_law(damping: Damping, law: Contact) -> None:
    r, factor = np.array([[0.0], [0.05], [0.6], [1.0]]), np.array([0.003, 0.2, 0.5])
    for s, modes, load in ((0.7, 5, Load.harmonic(1.0, 1.0)), (9.0, 16, Load.fourier([1.0, 1.0, 0.4 - 0.2j]))):
        system = System(UniformBar(s, damping), load, law)
        found = exact_plane(system, r, factor, modes=modes, threads=1)
        assert not np.any(found.outcome == OUTCOMES.index("unsolved"))
        for place in map(tuple, np.argwhere(found.outcome == OUTCOMES.index("done"))):
            value, mean = float(r[place[1], 0]), float(factor[place[2]])
            here = replace(system, contact=law.with_restitution(value), load=system.load.with_mean(mean))
            single = floquet_multipliers(Orbit(here, 1, float(found.plane.phase[place])), modes)
            assert found.largest[place] == pytest.approx(single.largest, rel=1e-8)


@pytest.mark.parametrize("damping", [External(0.0), External(0.05), Ratio(1e-2)], ids=str)
def test_the_phases_of_a_plane_are_those_of_steady_motions(damping: Damping) -> None:
    system = system_of(damping, Reversed(0.5), 2.0)
    r, factor = np.array([[0.1], [0.6], [0.95]]), np.array([0.01, 0.1, 0.5, 3.0])
    plane = stability_plane(system, r, factor)
    for cell in np.ndindex(3, 4):
        alone = steady_states(system.with_restitution(float(r[cell[0], 0])).with_load_factor(float(factor[cell[1]])))
        phases = plane.phase[(slice(None), *cell)]
        assert np.sort(phases[~np.isnan(phases)]) == pytest.approx([orbit.phase for orbit in alone.orbits], abs=1e-9)


# ---------------------------------------------------------------- which criterion holds for which law


def test_the_feedback_of_the_reduced_criterion_holds_where_the_strain_is_kept() -> None:
    """For the other law B77's criterion is that of the rigid bar, which the multipliers come to as s grows."""
    off = []
    for s in (20.0, 200.0, 2000.0):
        orbit = steady_states(system_of(External(0.0), Reversed(0.6), s, Load.harmonic(0.9, 1.0))).orbits[0]
        reduced = reduced_criterion(orbit)
        assert reduced.sigma == 0.0
        with pytest.raises(ParameterError, match="feedback"):
            elastic_feedback(orbit)
        off.append(abs(floquet_multipliers(orbit, 64).rhythm / reduced.moduli[0] - 1.0))
    assert off[0] < 0.03 and off[1] < 0.005 and off[2] < 0.0005
    kept = steady_states(system_of(External(0.0), Kept(0.6), 20.0, Load.harmonic(0.9, 1.0))).orbits[0]
    assert reduced_criterion(kept).sigma == elastic_feedback(kept) != 0.0


@settings(max_examples=20, deadline=None)
@given(st.floats(0.05, 0.9), st.floats(0.0, 1.0), st.floats(-0.5, 0.5))
def test_the_waveform_criterion_is_exact_for_the_rigid_bar_under_both_laws(mean: float, r: float, more: float) -> None:
    for law in (Kept(r), Reversed(r)):
        for orbit in steady_states(
            system_of(External(0.0), law, 30.0, Load.fourier([mean, 1.0, more])), modes=0
        ).orbits:
            waveform, exact = waveform_criterion(orbit), floquet_multipliers(orbit, 0)
            assume(min(abs(waveform.ratio - waveform.lower), abs(waveform.ratio - waveform.upper)) > 1e-7 and r < 0.999)
            assert waveform.stable == (exact.largest < 1.0)
    assert Reversed(r).holds(Result.WAVEFORM) and not Reversed(r).holds(Result.FEEDBACK)


def test_growth_of_elastic_modes_is_laid_to_the_law_that_keeps_the_strain() -> None:
    load = Load.harmonic(0.9, 1.0)
    kept, turned = (
        stability_of(steady_states(System(UniformBar(5.0), load, law), 2).orbits[1], modes=8)
        for law in (Kept(0.8), Reversed(0.8))
    )
    assert not kept.stable and "elastic mode" in kept.reason and "not of bars" in kept.reason
    assert turned.stable and "not of bars" not in turned.reason
    assert turned.margin == pytest.approx(0.2, abs=1e-9)
