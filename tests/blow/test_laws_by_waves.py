"""The law of a blow that takes time, and the page's table of where B77's law is right, against waves."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from machine_cases import DRIFTER, bar, rod_for, settled
from percuss import Kept, Load, System
from percuss.blow import Blow, Rod, effective_blow, strike
from percuss.model import SteppedBar, Timed, UniformBar
from percuss.simulate import Start
from percuss.steady import timed_states

# -- the law of a blow that takes time, against blows that are resolved by waves under a load


def law_of(blow: Blow, rod: float) -> Timed:
    """The law of a blow on a rod that stays where the blow puts it."""
    assert blow.effective_restitution is not None
    assert blow.contact_duration is not None and blow.force_centroid is not None
    return Timed(blow.effective_restitution, blow.contact_duration, blow.force_centroid, 1.0 / rod)


def pushed(bar: SteppedBar, rod: Rod, load: float) -> Blow:
    """A blow of a bar that a constant load accelerates: mean velocity 1 at the contact's start, force p (1 − m(x))."""
    impedances, transits = np.array(bar.impedances), np.array(bar.transit_times)
    masses = np.append(0.0, np.cumsum(impedances * transits))
    ends = np.append(0.0, np.cumsum(transits))

    def velocity(x: np.ndarray) -> np.ndarray:
        return np.ones_like(x)

    def force(x: np.ndarray) -> np.ndarray:
        return load * (1.0 - np.interp(x, ends / ends[-1], masses / masses[-1]))

    return strike(bar, rod, None, load=[(0.0, load)], field=(velocity, force), until=12.0 / bar.s)


@settings(max_examples=25)
@given(
    impedances=st.lists(st.floats(0.5, 2.0), min_size=1, max_size=3),
    shares=st.lists(st.floats(0.1, 1.0), min_size=3, max_size=3),
    heavier=st.floats(1.5, 20.0),
    load=st.floats(0.01, 2.0),
)
def test_a_load_adds_what_the_law_says_to_the_impulse(
    impedances: list[float], shares: list[float], heavier: float, load: float
) -> None:
    """J = (1 + R)(V − e p) with V at the centroid; exact while the load ends no contact and begins none."""
    bar = SteppedBar(30.0, tuple(impedances), tuple(shares[: len(impedances)]))
    own = np.array(impedances) / np.dot(impedances, bar.transit_times) * sum(bar.transit_times) * bar.s
    impedance = heavier * float(own.max())
    rod = Rod.of_impedance(impedance)
    free = strike(bar, rod, 1.0)
    assume(len(free.contacts) == 1 and free.effective_restitution is not None and free.effective_restitution >= 0.0)
    law = law_of(free, impedance)
    blow = pushed(bar, rod, load)
    assume(blow.contacts[0].end == pytest.approx(law.duration, rel=1e-9))
    at_centroid = 1.0 + load * law.force_centroid
    assert blow.contacts[0].impulse == pytest.approx(law.impulse(at_centroid, load), rel=1e-10)


@pytest.mark.parametrize("s", [5.0, 40.0])
def test_a_uniform_bar_has_the_closed_law(s: float) -> None:
    rod = 4.0 * s  # R = 3/5
    found, closed = law_of(strike(UniformBar(s), Rod.of_impedance(rod), 1.0), rod), Timed.of_uniform_bar(s, 0.6)
    assert (found.restitution, found.duration, found.force_centroid, found.advance_per_impulse) == pytest.approx(
        (closed.restitution, closed.duration, closed.force_centroid, closed.advance_per_impulse), rel=1e-12
    )


def test_from_the_blow_to_the_phase() -> None:
    """The drifter's piston of three sections, from its sections to the phase of the steady motion."""
    bar, rod = SteppedBar(40.0, (1.2566, 1.9635, 0.9503), (0.0731, 0.2187, 0.1493)), 101.13533508847935
    law = law_of(strike(bar, Rod.of_impedance(rod), 1.0), rod)
    orbit = timed_states(System(bar, Load.harmonic(0.66, 1.0), Kept(law.restitution)), law).orbits[1]
    assert orbit.phase == pytest.approx(2.1280786383417226, abs=1e-9)
    assert orbit.phase_b77 == pytest.approx(2.1128830416367776, abs=1e-9)


# -- the table of the page on simulation, where B77's law is right: its rows, computed again


PAGE = (Path(__file__).parents[2] / "docs" / "simulation.md").read_text(encoding="utf-8")


def rows():
    """(striker, R, p_0, s, t_c/T, phase, error of b77, error of b77-blow) of every row; empty cells as above them."""
    text = PAGE.partition("### Where B77's law is right")[2].partition("\n- ")[0]
    above, found = [], []
    for line in re.findall(r"^\|(.*)\|$", text, re.MULTILINE)[2:]:
        cells = [cell.strip() or above[i] for i, cell in enumerate(line.split("|"))]
        above = cells
        found.append((cells[0].split()[0], *(float(cell.replace("−", "-")) for cell in cells[1:])))
    return found


ROWS = rows()


def test_the_table_is_there():
    assert len(ROWS) == 20
    assert {row[3] for row in ROWS} == {5.0, 10.0, 20.0, 40.0, 80.0}


@pytest.mark.parametrize("row", [row for row in ROWS if row[3] in (10.0, 20.0, 40.0)], ids=str)
def test_a_row_is_what_the_package_computes(row):
    """The phase to its last digit; the errors of the laws, of first and of second order in the blow's duration."""
    striker, restitution, mean, s, share, phase, off_b77, off_blow = row
    load = Load.harmonic(mean, 1.0)
    if striker == "uniform":
        system, ratio = System(UniformBar(s), load, Kept(restitution)), (1.0 + restitution) / (1.0 - restitution)
    else:
        system, ratio = bar(s, *DRIFTER, load=load), 4.0
    rod = rod_for(system, ratio)
    blow = effective_blow(system.body, rod)
    law = Timed(blow.restitution, blow.duration, blow.centroid, 1.0 / rod.impedance)
    orbit = timed_states(System(system.body, load, Kept(blow.restitution)), law).orbits[-1]
    assert blow.restitution == pytest.approx(restitution, abs=5e-5)
    assert law.duration / orbit.period == pytest.approx(share, abs=6e-4)
    start = Start.rigid(0.0, orbit.rebound_velocity, orbit.phase)
    motion = settled(system, rod, start, quiet=True, cells=200 if striker == "uniform" else 1600, estimate=False)
    assert motion.phases[0] == pytest.approx(phase, abs=6e-5)
    assert orbit.phase_b77 - motion.phases[0] == pytest.approx(off_b77, abs=5e-4)
    assert abs(orbit.phase - motion.phases[0]) == pytest.approx(off_blow, abs=max(2e-5, 0.2 * off_blow))
