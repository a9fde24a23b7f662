"""Steady motions whose blows take time: all of them, against quadrature, scans, limits and waves."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import strategies
from percuss import Kept, Load, Reversed, System, Timed, steady_states, timed_states
from percuss.errors import LoadError, ParameterError
from percuss.model import External, Ratio, SteppedBar, UniformBar
from percuss.stability import timed_stability
from percuss.steady import TimedOrbit, TimedStates
from percuss.steady.figures import FIGURES
from percuss.steady.phases import phase_condition
from timed_oracle import flight

# a drifter's piston of three sections on a thick rod, every blow resolved by waves (two programs that agree)
_SUM = 0.0731 + 0.2187 + 0.1493
DRIFTER = System(
    SteppedBar(40.0, (1.2566, 1.9635, 0.9503), (0.0731 / _SUM, 0.2187 / _SUM, 0.1493 / _SUM)),
    Load.harmonic(0.66, 1.0),
    Kept(0.41528390670042886),
)
DRIFTER_BLOW = Timed(0.41528390670042886, 0.066923600090682378, 0.02807555306396961, 1.0 / 101.13533508847935)


@st.composite
def laws(draw: st.DrawFn, restitution: float, arm: bool = True) -> Timed:
    """A blow of up to a tenth of a radian."""
    duration = draw(st.floats(1e-3, 0.1))
    centroid = draw(st.floats(0.2, 0.8)) if arm else 0.5
    return Timed(restitution, duration, centroid * duration, draw(st.one_of(st.just(0.0), st.floats(0.0, 0.05))))


def test_the_drifter() -> None:
    states = timed_states(DRIFTER, DRIFTER_BLOW)
    orbit = states.orbits[1]
    assert states.b77.level == pytest.approx(0.85663395954431398, abs=1e-9)
    assert orbit.phase_b77 == pytest.approx(2.1128830416367776, abs=1e-9)
    assert orbit.phase == pytest.approx(2.1280786383417226, abs=1e-9)
    assert orbit.rigid_velocity == pytest.approx(2.9286726394273677, abs=1e-9)
    assert orbit.advance == pytest.approx(0.041003495950357655, abs=1e-9)
    assert orbit.phase == pytest.approx(2.12777, abs=4e-4)  # by waves
    assert orbit.impulse == pytest.approx(0.66 * math.tau, rel=1e-15)
    assert orbit.admissible and states.b77.orbits[1] is orbit.b77


@given(drawn=st.one_of(strategies.fourier_systems(), strategies.square_systems()))
def test_a_blow_without_duration_is_that_of_b77(drawn: strategies.Drawn) -> None:
    assume(not strategies.resonant(drawn.system))
    system, m = drawn
    states = timed_states(system, Timed(system.restitution), m)
    phases, folds = phase_condition(system, m).roots()
    assert [orbit.phase for orbit in states.orbits] == pytest.approx(phases.tolist(), abs=1e-12)
    assert [orbit.fold for orbit in states.orbits] == folds.tolist()
    for orbit in states.orbits:
        if orbit.b77 is not None:
            assert orbit.rigid_velocity == pytest.approx(orbit.b77.rigid_velocity, rel=1e-12)
    if system.d > 0.0 or system.restitution < 1.0:  # else B77's ringing may grow
        assert all(orbit.b77 is not None or orbit.fold for orbit in states.orbits)


@settings(max_examples=30)
@given(data=st.data(), drawn=st.one_of(strategies.fourier_systems(6), strategies.square_systems()))
def test_every_motion_repeats_itself(data: st.DataObject, drawn: strategies.Drawn) -> None:
    """A flight by quadrature from one blow to the next one, whatever the load and the drag."""
    assume(not strategies.resonant(drawn.system) and drawn.system.d < 3.0)
    system, m = drawn
    law = data.draw(laws(system.restitution))
    for orbit in timed_states(system, law, m).orbits:
        arm = 2.0 * law.force_centroid - law.duration
        impulse = (1.0 + law.restitution) * (orbit.rigid_velocity - arm * orbit.force)
        impulse *= 1.0 + 0.25 * (1.0 + law.restitution) * system.d * law.force_centroid
        assert impulse == pytest.approx(orbit.impulse, rel=1e-11)
        start = orbit.phase if not orbit.straddles else float(np.nextafter(orbit.phase, 10.0))
        moved, arrival = flight(system.load, system.d, start, orbit.rigid_velocity - impulse, start + orbit.period)
        speed = orbit.impulse + float(np.abs(system.load.coefficients).sum())
        assert arrival == pytest.approx(orbit.rigid_velocity, abs=1e-9 * speed)
        assert moved == pytest.approx(law.advance_per_impulse * impulse, abs=1e-9 * speed * orbit.period)


@settings(max_examples=30)
@given(data=st.data(), drawn=st.one_of(strategies.fourier_systems(), strategies.square_systems()))
def test_no_motion_is_missed(data: st.DataObject, drawn: strategies.Drawn) -> None:
    assume(not strategies.resonant(drawn.system))
    system, m = drawn
    states = timed_states(system, data.draw(laws(system.restitution)), m)
    scan = np.linspace(0.0, math.tau, 5001)
    off = states.curve(scan[:-1]) - states.level
    found = np.array([orbit.phase for orbit in states.orbits])
    for i in np.flatnonzero(np.sign(off) * np.sign(np.roll(off, -1)) < 0.0):
        assert np.any((found >= scan[i] - 1e-9) & (found <= scan[i + 1] + 1e-9) | (found + math.tau <= scan[i + 1]))
    assert states.level_max >= float(off.max()) + states.level - 1e-12 * abs(states.level_max)
    assert bool(found.size) == (states.level <= states.level_max and system.load.mean > 0.0) or not found.size


@given(data=st.data(), drawn=strategies.fourier_systems(6), shift=st.floats(0.0, math.tau))
def test_a_shift_of_the_load_shifts_the_phases(data: st.DataObject, drawn: strategies.Drawn, shift: float) -> None:
    assume(not strategies.resonant(drawn.system))
    system, m = drawn
    law = data.draw(laws(system.restitution))
    here = timed_states(system, law, m).orbits
    moved = timed_states(system.with_load(system.load.shifted(shift)), law, m).orbits
    assume(not any(orbit.fold for orbit in here))
    assert len(here) == len(moved)
    phases = np.exp(1j * np.array([orbit.phase for orbit in here]))
    for orbit in moved:
        away = np.abs(phases - np.exp(1j * (orbit.phase + shift)))
        assert away.min() < 1e-5  # near a fold a rounding moves the phase by its root
        assert orbit.rigid_velocity == pytest.approx(here[int(away.argmin())].rigid_velocity, rel=1e-5)


@given(drawn=strategies.fourier_systems())
def test_a_uniform_bar_on_a_rod_that_stays_meets_a_lower_level(drawn: strategies.Drawn) -> None:
    system, m = drawn
    assume(not strategies.resonant(drawn.system) and system.s * m > 1.0)
    states = timed_states(system.uniform(d=0.0), Timed.of_uniform_bar(system.s, system.restitution), m)
    level = states.b77.level
    assert states.level == pytest.approx(level * (1.0 - 1.0 / (math.pi * m * system.s)), abs=1e-14 + 1e-13 * level)


def test_of_two_motions_each_continues_its_own() -> None:
    for amplitude in (0.7, 1.0, 2.0):
        states = timed_states(DRIFTER.with_load(Load.harmonic(0.66, amplitude)), DRIFTER_BLOW)
        for orbit in states.orbits:
            assert orbit.b77 is not None and orbit.phase_shift is not None and abs(orbit.phase_shift) < 0.1
        assert states.ended == ()


@settings(max_examples=20)
@given(data=st.data(), drawn=strategies.fourier_systems(4))
def test_a_motion_is_continued_through_all_laws_between(data: st.DataObject, drawn: strategies.Drawn) -> None:
    """In small steps from B77's law to the other one, from root to nearest root, as long as their number stays."""
    assume(not strategies.resonant(drawn.system) and drawn.system.restitution < 1.0)
    system, m = drawn
    law = data.draw(laws(system.restitution))
    states = timed_states(system, law, m)
    before = np.array([orbit.phase for orbit in states.b77.orbits])
    start = before
    for share in np.linspace(0.0, 1.0, 101)[1:]:
        between = Timed(
            law.restitution, share * law.duration, share * law.force_centroid, share * law.advance_per_impulse
        )
        now = np.array([orbit.phase for orbit in timed_states(system, between, m).orbits])
        assume(now.size == before.size)
        away = np.abs(np.exp(1j * now)[:, None] - np.exp(1j * before))
        nearest = away.argmin(axis=1)
        assume(now.size == 0 or (away.min(axis=1).max() < 0.02 and np.unique(nearest).size == now.size))
        before, start = now, start[nearest]
    assert [orbit.phase_b77 for orbit in states.orbits] == pytest.approx(start.tolist())


def test_a_jump_of_the_load_is_a_steep_slope() -> None:
    """A blow during which the load jumps strikes as under a staircase of many small steps."""
    law = Timed(0.5, 0.1, 0.02)  # e = −0.06
    jump, width, n = 1.71 * math.pi, 1e-4, 40
    square = Load.square(1.0, 1.71)  # near the fold, so that the level is near the greatest v_f, at the jump
    stairs = Load.steps([0.0, *(jump + width * np.linspace(-0.5, 0.5, n))], [1.0, *np.linspace(1.0, -1.0, n + 1)[1:]])
    between = []
    for factor in np.linspace(0.97, 1.12, 9):
        one, other = (
            [
                orbit
                for orbit in timed_states(System(40.0, 0.0, 0.5, load.with_mean(factor * square.mean)), law).orbits
                if abs(orbit.phase - jump) < 1.0  # the other break is a jump of both loads
            ]
            for load in (square, stairs)
        )
        between += [orbit for orbit in one if orbit.straddles]
        assert len(one) == len(other)
        for sharp, steep in zip(one, other, strict=True):
            assert sharp.phase == pytest.approx(steep.phase, abs=2.0 * width)
            assert sharp.force == pytest.approx(steep.force, abs=0.06)
            assert sharp.rigid_velocity == pytest.approx(steep.rigid_velocity, abs=0.004)
    assert len(between) > 3 and all(-1.1 < orbit.force < 1.1 for orbit in between)


def test_they_answer_what_every_motion_is_asked() -> None:
    system = System(20.0, 0.0048, 0.6, Load.harmonic(0.9, 1.0))
    law = Timed.of_uniform_bar(20.0, 0.6)
    for orbit in timed_states(system, law).orbits:
        judged = timed_stability(orbit)
        assert tuple(orbit.multipliers().values) == judged.multipliers and orbit.stable == judged.stable
        assert orbit.verdict is judged.kind and (orbit.label, orbit.times) == ("z=1/1", (orbit.phase,))
        assert set(orbit.figures) == set(FIGURES) and orbit.figures["impulse"] == orbit.impulse
        t = np.linspace(0.0, orbit.period, 2001)
        assert -orbit.motion(t).min() == pytest.approx(orbit.stroke, rel=1e-3) and orbit.motion(t).max() < 1e-3
        assert orbit.motion([0.0, orbit.period]).tolist() == [0.0, 0.0]
        with pytest.raises(ParameterError, match="modes"):
            orbit.multipliers(3)


def _scanned(orbit: TimedOrbit) -> float:
    """The greatest place beyond the plane of the next blow, by looking."""
    start, stop = orbit.law.duration - orbit.law.force_centroid, orbit.period - orbit.law.force_centroid
    t = np.linspace(start, stop, 4001 * orbit.periods)
    place = orbit.rigid_motion(t)[0]
    return float((place - place[-1]).max())


@settings(max_examples=30)
@given(data=st.data(), drawn=st.one_of(strategies.fourier_systems(8), strategies.square_systems()))
def test_passages_are_found(data: st.DataObject, drawn: strategies.Drawn) -> None:
    assume(not strategies.resonant(drawn.system))
    system, m = drawn
    law = data.draw(laws(system.restitution))
    for orbit in timed_states(system, law, m).orbits:
        deep = _scanned(orbit)
        force = float(np.abs(system.load.value(np.linspace(0.0, math.tau, 2001))).max())
        if orbit.violation is None:
            bound = float(np.abs(system.load.coefficients).sum()) + (0.0 if not system.load.is_piecewise else force)
            assert deep <= 0.5 * bound * law.duration**2 + 1e-9
        else:
            assert orbit.violation.depth >= deep * (1.0 - 1e-5) and not orbit.admissible
            assert orbit.violation.depth <= deep * 1.001 + 1e-9


def test_the_drag_lowers_the_level_by_more_than_the_advance_over_the_period() -> None:
    """Against the limit without drag from both sides: the formula has no seam at d = 0."""
    law = Timed(0.5, 0.1, 0.03, 0.02)
    load = Load.harmonic(0.4, 1.0)
    levels = [timed_states(System(20.0, d, 0.5, load), law).level for d in (0.0, 1e-14, 1e-9, 1e-6)]
    assert levels == pytest.approx([levels[0]] * 4, rel=1e-5)
    assert levels[0] == pytest.approx(0.4 * math.tau * 0.5 / 3.0 - 0.02 * 0.4, rel=1e-14)


def _states(body: object, law: Timed, load: Load | None = None) -> TimedStates:
    return timed_states(System(body, load or Load.harmonic(0.5, 1.0), Kept(0.5)), law)  # type: ignore[call-overload,no-any-return]


def test_what_the_law_does_not_cover_is_said() -> None:
    free, braked = UniformBar(40.0), UniformBar(40.0, Ratio(5e-3))
    ringing = Timed(0.5, 0.05, 0.02, ringing_share=0.25)
    assert "50 %" in _states(free, ringing).orbits[0].warnings[0]
    assert _states(braked, ringing).orbits[0].ringing_left == pytest.approx(
        0.5 * math.exp(-5e-3 * 40.0 * math.pi * math.tau)
    )
    assert _states(UniformBar(40.0, Ratio(0.02)), ringing).orbits[0].warnings == ()
    assert "2 contacts" in _states(free, Timed(0.5, 0.05, 0.02, contacts=2)).orbits[0].warnings[0]
    assert "% of the load period" in _states(free, Timed(0.5, 0.5, 0.2)).orbits[0].warnings[0]
    # overdamped modes die out slowly
    drowned = _states(UniformBar(0.01, External(5.0)), ringing).orbits
    slow = 0.5 * (5.0 - math.sqrt(25.0 - 4.0 * (0.01 * math.pi) ** 2))
    assert all(orbit.ringing_left == pytest.approx(0.5 * math.exp(-slow * math.tau), rel=1e-9) for orbit in drowned)


def test_the_restitution_is_that_of_the_law() -> None:
    system = System(40.0, 0.0, 0.2, Load.harmonic(0.5, 1.0))
    states = timed_states(system, Timed(0.5, 0.05, 0.02))
    assert states.system.restitution == 0.5
    assert states.b77.orbits[0].phase == steady_states(system.with_restitution(0.5)).orbits[0].phase
    reversed_ = System(UniformBar(40.0), Load.harmonic(0.5, 1.0), Reversed(0.5))
    assert all(orbit.b77 is not None for orbit in timed_states(reversed_, Timed.of_uniform_bar(40.0, 0.5)).orbits)


def test_no_motion_and_no_flight() -> None:
    law = Timed.of_uniform_bar(20.0, 0.2)
    heavy = timed_states(System(20.0, 0.0, 0.2, Load.harmonic(2.0, 1.0)), law)
    assert heavy.orbits == () and heavy.level > heavy.level_max and not heavy.exists
    with pytest.raises(LoadError):
        timed_states(System(20.0, 0.0, 0.2, Load.harmonic(-1.0, 1.0)), law)
    with pytest.raises(ParameterError, match="blow to blow"):
        timed_states(System(20.0, 0.0, 0.2, Load.harmonic(0.1, 1.0)), Timed(0.2, 6.5, 3.0))


# -- against a uniform bar whose waves are followed on a lattice -------------------------------------------------------


CELLS = 64


class Waves:
    """A uniform bar of impedance s before a rod of impedance `rod` that stays where it is pushed; mass 1, length 1.

    Waves move by a cell in a step. A cell in which the contact begins is shared in proportion, and one that ends a
    contact is not, so that a phase is right to about a cell.
    """

    def __init__(self, system: System, rod: float, phase: float, velocity: float) -> None:
        self.system, self.rod, self.time = system, rod, phase
        self.ahead, self.back = np.full(CELLS, 0.5 * velocity), np.full(CELLS, 0.5 * velocity)
        self.gap, self.step = 0.0, 1.0 / (system.s * CELLS)

    def followed(self, blows: int) -> np.ndarray:
        """The phases of the force's centroid of so many blows."""
        phases, impulse, moment = [], 0.0, 0.0
        while len(phases) < blows:
            push = self._push()
            middle = self.time + 0.5 * self.step
            impulse, moment = impulse + push, moment + push * middle
            if push == 0.0 and impulse > 0.0:
                phases.append(moment / impulse)
                impulse = moment = 0.0
            self.time += self.step
        return np.mod(phases, math.tau)

    def _push(self) -> float:
        """One step; the impulse on the bar in it."""
        s, coming = self.system.s, float(self.ahead[-1])
        load = float(self.system.load.value(self.time + 0.5 * self.step))
        closed = 1.0 if self.gap == 0.0 and coming > 0.0 else 0.0
        left = self.gap - 2.0 * coming * self.step
        if not closed:
            if self.gap > 0.0 and left <= 0.0:
                closed = 1.0 - self.gap / (2.0 * coming * self.step)
            self.gap = max(left, 0.0)
        face = 2.0 * s * coming / (s + self.rod)
        returned = closed * (face - coming) + (1.0 - closed) * coming
        driven = float(self.back[0]) + load / s
        self.ahead = np.append(driven, self.ahead[:-1])
        self.back = np.append(self.back[1:], returned)
        velocity, strain = self.ahead + self.back, self.ahead - self.back
        velocity = velocity * math.exp(-self.system.d * self.step)
        self.ahead, self.back = 0.5 * (velocity + strain), 0.5 * (velocity - strain)
        return closed * s * (2.0 * coming - face) * self.step


def settled(system: System, orbit: TimedOrbit) -> float:
    """How much later than the law says the blows come, on average over the last ones, in radians."""
    ratio = (1.0 - system.restitution) / (1.0 + system.restitution)
    rod = system.s / ratio if ratio else 1e12 * system.s
    waves = Waves(system, rod, orbit.phase + 1.0 / system.s, orbit.rebound_velocity)
    return float(np.mean(waves.followed(22)[10:]) - orbit.phase)


@pytest.mark.parametrize(
    ("r", "mean", "d", "apart"),
    [(0.6, 0.9, 0.0, 0.04), (0.3, 0.5, 0.0, 0.06), (0.6, 0.5, 0.3, 0.1), (0.6, 0.35, 0.6, 0.1)],
)
def test_the_waves_in_a_uniform_bar_strike_when_the_law_says(r: float, mean: float, d: float, apart: float) -> None:
    """At s = 5, where the phase is off by far more when the duration or the drag during the contact is left out."""
    system = System(5.0, d, r, Load.harmonic(mean, 1.0))
    orbit = timed_states(system, Timed.of_uniform_bar(5.0, r)).orbits[-1]
    assert orbit.phase_shift is not None and orbit.phase_shift > apart
    assert settled(system, orbit) == pytest.approx(0.0, abs=0.015)


def test_the_drag_counts_during_a_contact_with_a_wall() -> None:
    system = System(5.0, 0.3, 1.0, Load.harmonic(0.9, 1.0))
    orbit = timed_states(system, Timed.of_uniform_bar(5.0, 1.0)).orbits[-1]
    assert orbit.phase_shift is not None and orbit.phase_shift > 0.1
    assert settled(system, orbit) == pytest.approx(0.0, abs=0.02)
