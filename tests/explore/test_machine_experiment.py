"""Experiments and basins of machines: which starts run and which stall, by energy, by single motions, however cut."""

import json

import numpy as np
import pytest

from percuss.errors import ParameterError
from percuss.explore import Archive, Basins, basins, experiment
from percuss.explore.attractors.drawn_starts import BLOCK, DISTRIBUTIONS, named, own, speed_scale
from percuss.explore.attractors.experiments import experiment_job, wilson
from percuss.explore.attractors.hammers import MACHINE_COLUMNS
from percuss.model import Chamber, Kept, Machine, Port, Reversed, UniformBar, Valve
from percuss.simulate import STALLS, Start, Starts, Stop, run

PORTS = (Port("power", behind=1.0, side="back"), Port("return", on="impact"))


def machine(stiffness, contact=None, ports=PORTS, body=None):
    valve = Valve({"return": -0.3, "power": 1.0}, ports, chamber=Chamber(0.0, stiffness))
    return Machine(UniformBar(20.0) if body is None else body, valve, Kept(0.5) if contact is None else contact)


GAS = machine(1.2)


# -- which run ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("stiffness", [0.9, 1.2, 1.5])
def test_starts_on_the_wall_run_when_their_energy_takes_them_to_the_port(stiffness):
    """Without drag: v² + 2 a_r S > κS² in the state of return; in that of power the blow comes first, and leaves R²v².

    What has reached the port once gets (a_r + a_p)S there and runs on, if the machine can run at all: at the blow of
    its cycle, w = 2 (a_r + a_p)S/(1 − R²), the same must hold of R²w.
    """
    found = experiment(machine(stiffness), 2000, "wall", seed=3, workers=1)
    speed, state = found.columns["velocity"], found.columns["state"]
    left = speed**2 * np.where(state == 0, 1.0, 0.25)
    can = stiffness < 0.25 * 2.6 / 0.75 + 0.6
    # a start that passes the port strikes with w_1 = v² + 2.6, and that must do for the next stroke too
    expected = (left + 0.6 > stiffness) & can
    runs = np.char.startswith(found.label, "runs")
    edge = np.abs(left + 0.6 - stiffness) < 1e-9
    assert np.array_equal(runs[~edge], expected[~edge])
    assert np.all(np.char.startswith(found.label[~runs], "stalls"))
    if can:
        share, low, high = found.labels["runs 1/1"]
        assert (low, high) == wilson(int(runs.sum()), 2000) and share == runs.mean()
        attractor = next(one for one in found.attractors if one.label == "runs 1/1")
        assert attractor.figures["impact_velocities"] == pytest.approx([np.sqrt(2.6 / 0.75)], rel=1e-7)
        assert attractor.figures["blow_energies"] == pytest.approx([1.3 / 0.75], rel=1e-7)
        assert attractor.figures["energy_lost"] == pytest.approx(1.3, rel=1e-7)


@pytest.mark.parametrize("modes", [0, 3])
def test_every_start_ends_as_its_own_motion(modes):
    stop = Stop(impacts=300)
    found = experiment(GAS, 40, "field", seed=2, modes=modes, stop=stop, workers=1)
    for i, start in enumerate(found.starts):
        motion = run(GAS, start, modes=modes, stop=stop)
        assert (found.label[i], found.columns["impacts"][i]) == (motion.label, motion.impacts)
        period = np.nan if motion.cycle is None else motion.cycle.period
        assert np.array_equal(found.columns["period"][i], period, equal_nan=True)
    counted = {label: (found.label == label).mean() for label in set(found.label.tolist())}
    assert counted == {label: share for label, (share, _, _) in found.labels.items()}


def test_members_of_an_attractor_have_its_label_and_its_period():
    """A machine with long delays has several motions beside each other."""
    late = (Port("power", behind=1.0, side="back", delay=0.9), Port("return", behind=0.1, side="front", delay=0.9))
    twin = Machine(UniformBar(20.0), Valve({"return": -0.3, "power": 1.0}, late), Kept(0.8))
    found = experiment(twin, 300, "field", seed=1, workers=1)
    for attractor in found.attractors:
        members = found.attractor == attractor.number
        assert len(set(found.label[members].tolist())) == 1 and members.sum() == attractor.members
        if (period := attractor.figures["period"]) is not None:
            assert np.ptp(found.columns["period"][members]) < 1e-3 * period
    assert sum(one.members for one in found.attractors) == 300


def test_bounces_that_a_turned_strain_holds_come_to_rest():
    """A bar whose law turns the strain is laid down where a contact would not have ended before the next begins."""
    front = (Port("power", behind=1.0, side="back"), Port("return", behind=0.1, side="front", delay=0.01))
    pressed = machine(0.0, Reversed(0.15), front, UniformBar(20.0))
    start = Start.rigid(0.0, -1e-3).with_valve("power")
    motion = run(pressed, start, modes=0, stop=Stop(impacts=50))
    assert motion.impacts < 50 and len(motion.events.of("rest")) and motion.label.startswith("runs")


# -- starts ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", DISTRIBUTIONS)
def test_starts_are_those_of_the_seed_and_of_the_scale(name):
    whole = named(GAS, name, BLOCK + 300, 5)
    part = named(GAS, name, 200, 5, BLOCK - 50)
    assert np.array_equal(part.velocity, whole.velocity[BLOCK - 50 : BLOCK + 150])
    assert np.array_equal(part.state, whole.state[BLOCK - 50 : BLOCK + 150])
    assert abs(whole.state.mean() - 0.5) < 0.01 and not whole.time.any()
    speed, place = whole.velocity[:, 0] / np.sqrt(2.6), whole.gap
    assert speed_scale(GAS) == pytest.approx(np.sqrt(2.6))
    if name == "field":
        assert -2.0 <= place.min() < -1.99 and place.max() <= 0.0 and abs(speed.std() - 1.0) < 0.02
    else:
        assert not place.any() and speed.max() < 0.0
        assert -speed.min() <= 0.05 if name == "gentle" else abs((speed**2).mean() - 1.0) < 0.03


def test_a_longer_stroke_and_a_stronger_valve_draw_alike():
    """Starts keep their place among the ports and their energy beside the work of the valve."""
    scaled = GAS.with_valve(GAS.valve.scaled(4.0, 0.25))
    for name in DISTRIBUTIONS:
        one, other = (named(which, name, 100, 1) for which in (GAS, scaled))
        assert np.allclose(0.25 * one.gap, other.gap) and np.allclose(one.velocity, other.velocity)


def test_own_starts(tmp_path):
    (tmp_path / "a.csv").write_text("position,velocity,state\n-0.5,0.1,power\n-0.2,0,return\n0,-1,1\n")
    starts = own(GAS, tmp_path / "a.csv", 0)
    assert starts.state.tolist() == [1, 0, 1] and starts.gap.tolist() == [-0.5, -0.2, 0.0]
    np.savez(tmp_path / "m.npz", u_0=[-1.0, -1.0], u_2=[0.1, 0.0], state=[1, 0])
    ringing = own(GAS, tmp_path / "m.npz", 0)
    assert np.allclose(ringing.gap, [-0.8, -1.0]) and ringing.state.tolist() == [1, 0]
    found = experiment(GAS, None, tmp_path / "m.npz", modes=3, workers=1)
    assert len(found) == 2 and found.columns["start_displacement"].shape == (2, 3)
    assert [start.valve_state for start in found.starts] == ["power", "return"]
    usual = own(GAS, Starts.rigid([-0.5, -0.1]), 0)
    assert usual.state.tolist() == [0, 0]
    assert own(GAS, lambda seed: starts, 0) is starts
    many = experiment(GAS, 50, tmp_path / "a.csv", seed=1, workers=1)
    assert set(many.columns["position"]) == {-0.5, -0.2, 0.0} and many.distribution == "a.csv"


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("position,state\n-1,closed\n", "line 2"),
        ("position,state\n-1,2\n", "'return', 'power'"),
        ("position,state\n-1,0.5\n", "row 1"),
        ("position,time\n-1,0\n", "no clock"),
        ("position,phase\n-1,0\n", "state"),
        ("state\n0\n", "no column"),
    ],
)
def test_tables_that_are_no_starts_of_a_machine(tmp_path, text, word):
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(ParameterError, match=word):
        experiment(GAS, None, tmp_path / "a.csv", workers=1)


def test_what_is_refused():
    level = GAS.with_valve(Valve({"a": 1.0, "b": 1.0}, [Port("b", on="impact")]))
    with pytest.raises(ParameterError, match="different forces"):
        experiment_job(level, 10, "wall")
    assert experiment_job(level, 10, "field").size == 10
    with pytest.raises(ParameterError, match="wall, field, gentle"):
        experiment_job(GAS, 10, "wide")
    with pytest.raises(ParameterError, match="states return, shut"):
        experiment_job(GAS, None, Starts.rigid(-1.0).with_valve(0, ("return", "shut")))
    with pytest.raises(ParameterError, match="Machine"):
        experiment(GAS.valve, 10)  # type: ignore[arg-type]
    line = ("velocity", -1.0, 1.0, 3)
    for x, at, word in (
        (("time", 0.0, 1.0, 3), {}, "no clock"),
        (("position", -1.0, 0.5, 3), {}, "0"),
        (("position", -1.0, 0.0, 3), {"state": "shut"}, "'return', 'power'"),
        (("position", -1.0, 0.0, 3), {"state": 2}, "'return', 'power'"),
    ):
        with pytest.raises(ParameterError, match=word):
            basins(GAS, x, line, at=at)
    for state in (2, -1, 0.5, [0, 1]):
        with pytest.raises(ParameterError):
            Starts.rigid(-1.0).with_valve(state, ("return", "power"))


# -- basins and tables ----------------------------------------------------------------------------------------------


def test_basins_are_the_motions_of_their_starts(tmp_path):
    found = basins(
        GAS, ("position", -1.5, -0.1, 5), ("velocity", -2.0, 2.0, 4), at={"state": "power"}, workers=1,
        archive=tmp_path / "b.zarr",
    )  # fmt: skip
    for row, velocity in enumerate(found.y[1]):
        for column, position in enumerate(found.x[1]):
            motion = run(GAS, Start.rigid(position, velocity).with_valve("power"), modes=0)
            assert found.label[row, column] == motion.label
    again = Basins.from_archive(Archive.open(tmp_path / "b.zarr"))
    assert again.at == (("state", 1.0),) and np.array_equal(again.image, found.image)
    assert found.dataset["state"].values.tolist() == np.ones((4, 5), dtype=int).tolist()
    usual = basins(GAS, ("position", [-0.9]), ("velocity", [0.0]), workers=1)
    assert usual.columns["state"].tolist() == [0]


def test_the_table_has_words_units_and_scales():
    from percuss.case import load_case

    found = experiment(load_case("valve-drifter").machine(), 20, "wall", seed=1, stop=Stop(impacts=100), workers=1)
    data = found.dataset
    assert set(MACHINE_COLUMNS) <= set(data) and data.attrs["machine"].startswith("Machine")
    assert data["state"].attrs["words"] == "return, power" and data["stall"].attrs["words"] == ", ".join(STALLS)
    assert data["velocity"].attrs["si_units"] == "m/s" and data["period"].attrs["si_units"] == "s"
    assert data["velocity"].attrs["si_scale"] == pytest.approx(found.system.length_scale)
    first = found.shares[0]
    assert first.label == "runs 1/1" and first.attractor.figures["period"] == pytest.approx(1.0 / 61.2, rel=2e-3)
    assert first.impact_velocities[0] * found.system.speed_scale == pytest.approx(10.92, rel=1e-3)
    json.dumps(found.to_json_dict(), allow_nan=False)
