"""The table of the page on simulation, where B77's law is right: its rows, computed again."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from machine_cases import DRIFTER, bar, rod_for, settled
from percuss import Kept, Load, System, Timed, timed_states
from percuss.blow import effective_blow
from percuss.model.body import UniformBar
from percuss.simulate import Start

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
