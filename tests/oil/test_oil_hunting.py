"""A breaker that hunts, and motions of machines whose oil flows that are saved, continued and repeated."""

from pathlib import Path

import numpy as np
import pytest

from oil_cases import case_text, machine_of, named, random_system
from percuss.case import Case, load_case
from percuss.explore import experiment
from percuss.simulate import Start, Stop, Trajectory, run

HUNTS = named("small accumulator: it hunts")
LITRES = 1e-3 / 60.0


def written(flow):
    """The breaker with so much oil (l/min); the reference has a line beside its accumulator that it does not count."""
    system = {**HUNTS, "supply": {**HUNTS["supply"], "pump": {"flow": flow * LITRES}}}
    text = case_text(system, si=True)
    Path("hunts.toml").write_text(text, encoding="utf-8")
    return Case.from_text(text)


@pytest.mark.slow
def test_the_flip_of_a_breaker_that_hunts(percuss):
    machine = written(118.3).machine()
    along = f"load.supply.flow={118 * LITRES} m^3/s:{123 * LITRES} m^3/s"
    told = percuss("follow", "hunts.toml", "--along", along, "--modes", "0", "--json").json
    (flip,) = [point for point in told["points"] if point["type"] == "flip"]
    assert flip["value"] == pytest.approx(120.7 * LITRES, rel=1e-3)
    assert flip["criticality"] == "supercritical"
    found = percuss("orbits", "hunts.toml", "--label", "2/2", "--modes", "0", "--json").json["orbits"]
    assert [one["stable"] for one in found] == [True]
    speeds = sorted(one["speed"] for one in found[0]["impacts"])
    settled = run(machine, Start.rigid(-0.3), modes=0, stop=Stop(impacts=600))
    assert settled.cycle.impacts == 2
    assert sorted(settled.events.impact_velocity[settled.events.code == 0][-2:]) == pytest.approx(speeds, rel=1e-6)


@pytest.mark.parametrize(("flow", "impacts"), [(117.0, 2), (119.5, 2), (122.0, 1)])
def test_blows_alternate_below_the_flip(percuss, flow, impacts):
    machine = written(flow).machine()
    settled = run(machine, Start.rigid(-0.3), modes=0, stop=Stop(impacts=2000))
    assert settled.cycle is not None
    assert settled.cycle.impacts == impacts


@pytest.mark.parametrize("modes", [0, 4])
@pytest.mark.parametrize("sample", ["oil-drifter", "oil-breaker"])
def test_saved_and_continued_is_the_same_motion(tmp_path, sample, modes):
    machine, start = load_case(sample).machine(), Start.rigid(-0.03)
    stop = Stop(impacts=20, periodic=False)
    whole = run(machine, start, modes=modes, stop=stop)
    part = run(machine, start, modes=modes, stop=Stop(impacts=9, periodic=False))
    part.save(tmp_path / "part.nc")
    for again in (part, Trajectory.load(tmp_path / "part.nc")):
        more = again.continued(stop)
        assert np.array_equal(more.states, whole.states)
        assert np.array_equal(more.events.time, whole.events.time)
    balance = whole.energy_balance()
    assert balance.imbalance == pytest.approx(0.0, abs=1e-12 * balance.input)


def test_an_experiment_settles_where_single_motions_do():
    machine = machine_of(random_system(4))
    found = experiment(machine, 6, seed=3, modes=0, stop=Stop(impacts=300), workers=1)
    alone = run(machine, Start.rigid(-0.5), modes=0, stop=Stop(impacts=300))
    (attractor,) = found.attractors
    assert attractor.label == alone.label
    assert alone.cycle is not None
