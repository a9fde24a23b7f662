"""Experiments and basins: starts, shares and intervals, attractors told apart, by energy and by single motions."""

import json
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
import scipy

from percuss import Bar, Kept, Load, Start, Starts, Stop, System, run, stability_of, steady_states
from percuss.errors import ParameterError, PercussError, ResonanceError
from percuss.explore import Archive, Axis, Basins, Experiment, basins, experiment, sweep
from percuss.explore.attractors.basin import basins_job
from percuss.explore.attractors.drawn_starts import BLOCK, DISTRIBUTIONS, drawn, named, own, speed_scale
from percuss.explore.attractors.experiments import experiment_job, wilson
from percuss.explore.attractors.hammers import MACHINE_COLUMNS, ClockedHammer, StartTally, invariants_of
from percuss.explore.jobs.archive_export import dataset_of
from percuss.explore.jobs.carrying_out import carry_out
from percuss.model import Chamber, Machine, Port, Reversed, UniformBar, Valve
from percuss.simulate import STALLS

TURN = 2.0 * np.pi
PNEUMATIC = System(s=20.0, d=0.0, restitution=0.6, load=Load.harmonic(0.7, 1.0))
# two stable motions z=1/1, of one striking speed, at different phases
TWINS = System(s=1e6, d=0.0, restitution=0.6, load=Load.fourier([0.6, 1.0, np.exp(1.0j)]))
ELASTIC = System(s=3.0, d=0.05, restitution=0.6, load=Load.harmonic(0.9, 1.0))
BAR = Bar(length=0.341, diameter=0.049, damping_ratio=1e-3)
IN_SI = System.from_si(BAR, Load.harmonic(5e3, 6e3, frequency=60.0), Kept(restitution=0.6))
PORTS = (Port("power", behind=1.0, side="back"), Port("return", on="impact"))


def machine(stiffness, contact=None, ports=PORTS, body=None):
    valve = Valve({"return": -0.3, "power": 1.0}, ports, chamber=Chamber(0.0, stiffness))
    return Machine(UniformBar(20.0) if body is None else body, valve, Kept(0.5) if contact is None else contact)


GAS = machine(1.2)


def same(one, other):
    assert one.keys() == other.keys()
    for name in one:
        assert one[name].dtype == other[name].dtype and one[name].tobytes() == other[name].tobytes(), name


# -- intervals --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("n", [1, 7, 100, 12345, 10**6])
def test_wilson_beside_scipy(n):
    for k in {0, 1, n // 3, n // 2, n - 1, n}:
        for confidence in (0.8, 0.95, 0.999):
            theirs = scipy.stats.binomtest(k, n).proportion_ci(confidence, method="wilson")
            assert wilson(k, n, confidence) == pytest.approx((theirs.low, theirs.high), rel=1e-10, abs=1e-15)


def test_wilson_at_its_ends():
    assert wilson(0, 0) == (0.0, 1.0)
    assert wilson(0, 10)[0] == 0.0 and wilson(10, 10)[1] == 1.0
    for wrong in ((-1, 3), (4, 3), (1.5, 3)):
        with pytest.raises(ParameterError):
            wilson(*wrong)
    with pytest.raises(ParameterError):
        wilson(1, 3, 1.0)


# -- starts -----------------------------------------------------------------------------------------------------------


def test_the_named_distributions():
    n = 200_000
    scale = TURN * 0.7 / 1.6
    for name in DISTRIBUTIONS:
        starts = named(PNEUMATIC, name, n, 5)
        phase, speed = starts.time, starts.velocity[:, 0]
        assert starts.displacement.shape == starts.velocity.shape == (n, 1)
        assert scipy.stats.kstest(phase / TURN, "uniform").pvalue > 1e-3 and phase.min() >= 0.0 and phase.max() < TURN
        if name == "field":
            assert scipy.stats.kstest(starts.gap / 20.0 + 1.0, "uniform").pvalue > 1e-3
            assert scipy.stats.kstest(speed / 5.0, "norm").pvalue > 1e-3
            assert abs(np.corrcoef(starts.gap, speed)[0, 1]) < 0.01
        else:
            assert not starts.gap.any() and speed.max() < 0.0
        if name == "wall":
            assert scipy.stats.kstest(-speed / scale, "halfnorm").pvalue > 1e-3
        if name == "gentle":
            assert scipy.stats.kstest(-speed / 0.2, "uniform").pvalue > 1e-3 and speed.min() >= -0.2
        assert abs(np.corrcoef(phase, speed)[0, 1]) < 0.01


@pytest.mark.parametrize("hammer", [PNEUMATIC, GAS], ids=["system", "machine"])
@pytest.mark.parametrize("name", DISTRIBUTIONS)
def test_starts_are_those_of_the_seed_in_any_portions(hammer, name):
    whole, other = named(hammer, name, 2 * BLOCK + 10, 3), named(hammer, name, 50, 4)
    fields = ("displacement", "velocity", "gap", *(("time",) if hammer is PNEUMATIC else ("state",)))
    for first, last in ((0, 50), (BLOCK - 3, BLOCK + 3), (BLOCK, 2 * BLOCK), (10, 2 * BLOCK + 10)):
        part = named(hammer, name, last - first, 3, first)
        for field in fields:
            assert np.array_equal(getattr(part, field), getattr(whole, field)[first:last])
    chance = whole.time if hammer is PNEUMATIC else whole.velocity[:, 0]
    assert not np.array_equal(other.velocity, whole.velocity[:50]) or not np.array_equal(other.time, whole.time[:50])
    assert not np.array_equal(chance[:BLOCK], chance[BLOCK : 2 * BLOCK]) and np.unique(chance).size == len(whole)


@pytest.mark.parametrize("name", DISTRIBUTIONS)
def test_starts_of_machines_have_its_scale(name):
    whole = named(GAS, name, BLOCK, 5)
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


def test_a_portion_of_very_many_starts_is_made_alone():
    """10¹² of them would take 30 TB, a plane of 10¹⁰ 400 GB."""
    n, stop = 10**12, Stop(impacts=50)
    for job in (
        experiment_job(PNEUMATIC, n, "wall", 1, stop=stop, modes=0),
        experiment_job(PNEUMATIC, n, Starts.rigid(-1.0, 0.0, [0.0, 1.0, 2.0]), 1, stop=stop, modes=0),
    ):
        last = job.compute(n - 5, n, lambda: False)
        same(job.compute(n - 2, n, lambda: False), {name: values[3:] for name, values in last.items()})
    n = 100_000
    plane = basins_job(ELASTIC, ("time", 0.0, 6.0, n), ("u_2", -0.1, 0.1, n), at={"position": -1.0}, modes=2)
    part = plane.starts(n * n - n - 2, n * n - n + 2)
    assert part.time.tolist() == [plane.x[1][-2], 6.0, 0.0, plane.x[1][1]]
    assert part.displacement[:, 2].tolist() == [plane.y[1][-2]] * 2 + [0.1] * 2
    assert np.allclose(part.displacement @ [1.0, -2.0, 2.0], -1.0)
    for many in (job, plane):
        with pytest.raises(PercussError, match="memory"):
            carry_out(many, workers=1)


def test_drawing_with_replacement_does_not_depend_on_how_many():
    rows = Starts.rigid(-1.0, 0.0, np.arange(7.0))
    whole = drawn(rows, BLOCK + 100, 4)
    assert np.array_equal(drawn(rows, 50, 4).time, whole.time[:50])
    assert np.array_equal(drawn(rows, 60, 4, BLOCK - 30).time, whole.time[BLOCK - 30 : BLOCK + 30])
    assert scipy.stats.chisquare(np.bincount(whole.time.astype(int))).pvalue > 1e-3


def test_files_of_starts(tmp_path):
    table = np.array([[-1.0, 0.5, 0.1], [0.0, -0.2, 3.0], [-2.0, 0.0, 6.0]])
    (tmp_path / "a.csv").write_text("# mine\nposition, velocity, time\n-1,0.5,0.1\n\n0,-0.2,3\n-2,0,6\n")
    (tmp_path / "b.csv").write_text("time;position\n0.1;-1\n3;0\n")
    np.savez(tmp_path / "c.npz", position=table[:, 0], velocity=table[:, 1], time=table[:, 2])
    np.savez(tmp_path / "m.npz", u_0=[-1.0, -1.0], u_2=[0.1, 0.0], v_1=[0.2, 0.3], time=[0.0, 1.0])
    import xarray

    columns = {name: ("start", table[:, i]) for i, name in enumerate(("position", "velocity", "time"))}
    xarray.Dataset(columns).to_netcdf(tmp_path / "d.nc", engine="h5netcdf")
    for name in ("a.csv", "c.npz", "d.nc"):
        starts = own(PNEUMATIC, tmp_path / name)
        assert np.array_equal(np.column_stack([starts.gap, starts.velocity[:, 0], starts.time]), table), name
    assert np.array_equal(own(PNEUMATIC, tmp_path / "b.csv").gap, [-1.0, 0.0])
    modal = own(PNEUMATIC, tmp_path / "m.npz")
    assert modal.displacement.shape == modal.velocity.shape == (2, 3)
    assert np.allclose(modal.gap, [-0.8, -1.0]) and np.array_equal(modal.velocity[:, 1], [0.2, 0.3])
    found = experiment(PNEUMATIC, None, tmp_path / "a.csv", workers=1, modes=0)
    assert len(found) == 3 and found.distribution == "a.csv"
    assert np.array_equal(found.columns["position"], table[:, 0])
    many = experiment(PNEUMATIC, 40, str(tmp_path / "a.csv"), seed=2, workers=1, modes=0)
    assert set(many.columns["position"]) == {-1.0, 0.0, -2.0} and len(many) == 40
    two = experiment(PNEUMATIC, 2, str(tmp_path / "a.csv"), workers=1, modes=0)
    assert np.array_equal(two.columns["position"], table[:2, 0])
    ringing = experiment(PNEUMATIC, None, tmp_path / "m.npz", modes=3, workers=1)
    assert ringing.columns["start_displacement"].shape == (2, 3) and len(ringing.shares) >= 1


def test_files_of_starts_of_machines(tmp_path):
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
    many = experiment(GAS, 50, tmp_path / "a.csv", seed=1, workers=1, modes=0)
    assert set(many.columns["position"]) == {-0.5, -0.2, 0.0} and many.distribution == "a.csv"


@pytest.mark.parametrize(
    ("hammer", "text", "word"),
    [
        (PNEUMATIC, "position,velocity,time\n-1,0,0\n-1,x,0\n", "line 3"),
        (PNEUMATIC, "position,velocity,time\n-1,0\n", "3 numbers"),
        (PNEUMATIC, "place,velocity\n-1,0\n", "place"),
        (PNEUMATIC, "position,u_0\n-1,0\n", "both"),
        (PNEUMATIC, "time\n1\n", "no column"),
        (PNEUMATIC, "position\n0.5\n", "wall"),
        (PNEUMATIC, "u_0,u_1\n0,-1\n", "wall"),
        (PNEUMATIC, "position\nnan\n", "finite"),
        (PNEUMATIC, "position\n", "row"),
        (PNEUMATIC, "", "row"),
        (PNEUMATIC, "position,position\n-1,-1\n", "once"),
        (GAS, "position,state\n-1,closed\n", "line 2"),
        (GAS, "position,state\n-1,2\n", "'return', 'power'"),
        (GAS, "position,state\n-1,0.5\n", "row 1"),
        (GAS, "position,time\n-1,0\n", "no clock"),
        (GAS, "position,phase\n-1,0\n", "state"),
        (GAS, "state\n0\n", "no column"),
    ],
)
def test_tables_that_are_no_starts(tmp_path, hammer, text, word):
    (tmp_path / "starts.csv").write_text(text)
    with pytest.raises(ParameterError, match=word):
        experiment_job(hammer, None, tmp_path / "starts.csv", modes=0)


def test_a_function_of_the_seed():
    def close(seed):
        return Starts.rigid(0.0, -0.01 * (1 + np.arange(5)), float(seed))

    found = experiment(PNEUMATIC, None, close, seed=3, workers=1, modes=0)
    assert len(found) == 5 and set(found.columns["time"]) == {3.0} and "close" in found.distribution
    same = drawn(close(3), 100, 8)
    assert np.array_equal(same.velocity, drawn(close(3), 100, 8).velocity)
    assert not np.array_equal(same.velocity, drawn(close(3), 100, 9).velocity)


# -- what is refused --------------------------------------------------------------------------------------------------


PULLED = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(-0.1, 1.0))
RESONANT = System(s=1.0 / np.pi, d=0.0, restitution=0.5, load=Load.harmonic(0.5, 1.0))
LEVEL = GAS.with_valve(Valve({"a": 1.0, "b": 1.0}, [Port("b", on="impact")]))
RINGING = Starts.random(PNEUMATIC, 5, distribution="ringing", modes=4)
VELOCITY = ("velocity", -1.0, 1.0, 3)


@pytest.mark.parametrize(
    ("hammer", "asked", "word"),
    [
        (PNEUMATIC, {"distribution": "walls"}, "wall, field, gentle"),
        (GAS, {"distribution": "wide"}, "wall, field, gentle"),
        (PNEUMATIC, {"distribution": lambda seed: seed}, "Starts"),
        (GAS, {"distribution": Starts.rigid(-1.0).with_valve(0, ("return", "shut"))}, "states return, shut"),
        (GAS.valve, {}, "Machine"),
        (PULLED, {}, "pushes"),
        (LEVEL, {}, "different forces"),
        (RESONANT, {"modes": 3}, "mode"),
        (PNEUMATIC, {"distribution": RINGING, "modes": 3}, "more modes"),
        *((PNEUMATIC, {name: wrong}, name) for name, wrong in (
            ("starts", 0), ("seed", -1), ("modes", -1), ("stop", 3),
        )),
        (PNEUMATIC, {"stop": Stop(impacts=0)}, "impacts"),
    ],
)  # fmt: skip
def test_experiments_that_are_none(hammer, asked, word):
    with pytest.raises((ParameterError, ResonanceError), match=word):
        experiment_job(hammer, **{"starts": 10, **asked})


def test_what_has_no_wall_may_have_a_field():
    assert len(named(PULLED, "field", 10)) == experiment_job(LEVEL, 10, "field", modes=0).size == 10
    assert experiment_job(RESONANT, 10, modes=0).size == 10
    assert experiment_job(PNEUMATIC, None, RINGING, modes=4).size == 5
    with pytest.raises(ParameterError):
        experiment(PNEUMATIC, 10, distance="x", workers=1, modes=0)
    for state in (2, -1, 0.5, [0, 1]):
        with pytest.raises(ParameterError):
            Starts.rigid(-1.0).with_valve(state, ("return", "power"))


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(ParameterError, match="regular"):
        own(PNEUMATIC, tmp_path)
    for name in ("x.npz", "x.nc"):
        (tmp_path / name).write_bytes(b"no archive")
        with pytest.raises(ParameterError, match="file of numbers"):
            own(PNEUMATIC, tmp_path / name)


@pytest.mark.parametrize(
    ("hammer", "asked", "word"),
    [
        (ELASTIC, {"x": ("speed", 0, 1, 3)}, "position, velocity, time"),
        (ELASTIC, {"x": ("velocity", 0, 1, 3)}, "another"),
        (ELASTIC, {"x": ("position", -1.0, 0.5, 3)}, "wall"),
        (ELASTIC, {"x": ("u_3", -1.0, 0.5, 3)}, "modes"),
        (ELASTIC, {"x": ("u_0", -1.0, 0.5, 3)}, "u_1"),
        (ELASTIC, {"x": "time"}, "NAME=FROM:TO"),
        (ELASTIC, {"x": ("time",)}, "name, first"),
        (ELASTIC, {"at": {"velocity": 1.0}}, "not on an axis"),
        (ELASTIC, {"at": {"place": 1.0}}, "position, velocity, time"),
        (ELASTIC, {"at": {"position": 1.0}}, "wall"),
        (ELASTIC, {"modes": -1}, "modes"),
        (ELASTIC, {"x": Axis.linear("time", 0.0, 6.0, 3, "ms")}, "dimensionless"),
        (ELASTIC, {"stop": Stop(impacts=0)}, "impacts"),
        (GAS, {"x": ("time", 0.0, 1.0, 3), "y": VELOCITY}, "no clock"),
        (GAS, {"x": ("position", -1.0, 0.5, 3), "y": VELOCITY}, "wall"),
        (GAS, {"x": ("position", -1.0, 0.0, 3), "y": VELOCITY, "at": {"state": "shut"}}, "'return', 'power'"),
        (GAS, {"x": ("position", -1.0, 0.0, 3), "y": VELOCITY, "at": {"state": 2}}, "'return', 'power'"),
    ],
)
def test_planes_that_are_none(hammer, asked, word):
    with pytest.raises(ParameterError, match=word):
        basins_job(hammer, **{"x": ("time", 0.0, 6.0, 3), "y": ("velocity", -1.0, 0.0, 3), "modes": 2, **asked})


# -- attractors of systems --------------------------------------------------------------------------------------------


def test_two_motions_of_one_label_are_told_apart():
    stable = [o for o in steady_states(TWINS, modes=0).orbits if o.admissible and stability_of(o, modes=0).stable]
    found = experiment(TWINS, 1500, "wall", 1, workers=1, modes=0)
    twins = [share for share in found.shares if share.label == "z=1/1"]
    assert len(stable) == len(twins) == 2
    assert sorted(share.phases[0] for share in twins) == pytest.approx([o.phase for o in stable], abs=1e-7)
    for share in twins:
        assert share.impact_velocities == pytest.approx((stable[0].impact_velocity,), abs=1e-7)
        assert 0.3 < share.low < share.share < share.high < 0.7
    assert sum(share.members for share in found.shares) == 1500
    assert found.labels["z=1/1"][0] == pytest.approx(sum(share.share for share in twins))
    # every member is where its attractor is
    for share in twins:
        here = found.attractor == share.attractor.number
        assert np.abs(found.columns["phase"][here] - share.phases[0]).max() < 1e-6


def made(cycles, kinds=None, periods=1):
    """Columns of made-up periodic motions: one list of (phase, speed) each."""
    tail = np.full((2, len(cycles), 64), np.nan)
    for i, cycle in enumerate(cycles):
        tail[:, i, 64 - len(cycle) :] = np.array(cycle).T
    count = np.array([len(cycle) for cycle in cycles])
    n = np.full(len(cycles), periods)
    invariants, phase, speed = invariants_of(tail[0], tail[1], count, n, [1])
    return {
        "code": np.full(len(cycles), 3, dtype=np.int8),
        "cycle_impacts": count,
        "cycle_periods": n,
        "cycle_kind": np.zeros(len(cycles), dtype=np.int8) if kinds is None else np.array(kinds, dtype=np.int8),
        "wanders": np.zeros(len(cycles), dtype=bool),
        "invariants": invariants,
        "phase": phase,
        "striking_speed": speed,
    }


def test_the_seam_of_the_phase_and_rounding_split_nothing():
    noise = 1e-8 * np.random.default_rng(1).standard_normal(200)
    assert set(ClockedHammer.matched(made([[(e % TURN, 2.0 + e)] for e in noise]), 1.0)) == {0}


def test_any_impact_of_a_cycle_may_come_first():
    cycle = [(1.0, 2.0), (4.0, 2.0), (6.2, 1.9), (0.1, 2.0)]
    turned = [cycle[i:] + cycle[:i] for i in range(4)] * 5
    columns = made(turned)
    assert set(ClockedHammer.matched(columns, 1.0)) == {0}
    assert set(columns["phase"]) == {0.1}  # of equally fast impacts the one of the least phase


def test_neighbours_are_not_merged():
    cycles = [[(1.0, 2.0)]] * 5 + [[(1.0, 2.001)]] * 3 + [[(1.001, 2.0)]] * 2 + [[(1.0 - 1e-6, 2.0)]] * 4
    assert ClockedHammer.matched(made(cycles), 1.0).tolist() == [0] * 5 + [1] * 3 + [2] * 2 + [0] * 4
    # the same phases and the same speeds, exchanged
    cycles = [[(1.0, 2.0), (4.0, 1.0)]] * 3 + [[(1.0, 1.0), (4.0, 2.0)]] * 2
    assert ClockedHammer.matched(made(cycles), 1.0).tolist() == [0, 0, 0, 1, 1]


def test_a_smallest_impact_of_chatter_more_or_less_splits_nothing():
    bounces = [(2.0 + 0.5 * (1.0 - 0.5**k), 0.5**k) for k in range(20)]
    cycles = [bounces, bounces[:-1], bounces[:-2], [(p + 0.01, v) for p, v in bounces]]
    assert ClockedHammer.matched(made(cycles, [2] * 4), 1.0).tolist() == [0, 0, 0, 1]
    assert ClockedHammer.matched(made(cycles[:3] + cycles[:1], [2, 2, 2, 1]), 1.0).tolist() == [0, 0, 0, 1]


def test_labels_keep_motions_apart():
    columns = made([[(1.0, 2.0)]] * 6, periods=1)
    columns["cycle_periods"] = np.array([1, 2, 1, 0, 0, 0])
    columns["cycle_impacts"] = np.array([1, 1, 1, 0, 0, 0])
    columns["wanders"] = np.array([False, False, False, True, False, True])
    assert ClockedHammer.matched(columns, 1.0).tolist() == [0, 2, 0, 1, 3, 1]


@pytest.mark.parametrize("seed", range(20))
def test_motions_are_counted_alike_in_any_portions(seed):
    """Clouds, chains of small steps and single ones: cut apart all at once, or as they come."""
    random, hammer = np.random.default_rng(seed), ClockedHammer(PNEUMATIC)
    size = int(random.integers(1, 400))
    columns = made([[(1.0, 2.0)]] * size)
    columns["code"][random.random(size) < 0.1] = -1
    centres = random.choice([0.0, 3e-4, 1e-3], (7, 8))[random.integers(0, 7, size)]
    columns["invariants"] = 1.0 + centres + 10.0 ** -random.integers(3, 6) * random.random((size, 8))
    columns["cycle_impacts"] = random.integers(0, 3, size)
    columns["invariants"][columns["cycle_impacts"] == 0] = np.nan
    known = {name: values[columns["code"] >= 0] for name, values in columns.items()}
    number, tally = hammer.matched(known, hammer.speed), StartTally(hammer)
    cuts = np.unique(np.append(random.integers(0, size, 9), [0, size]))
    for i in random.permutation(cuts.size - 1):
        tally.add(int(cuts[i]), {name: values[cuts[i] : cuts[i + 1]] for name, values in columns.items()})
    assert tally.members.tolist() == np.bincount(number).tolist()
    first = [int(np.flatnonzero(number == i)[0]) for i in range(tally.members.size)]
    assert tally.first.tolist() == np.flatnonzero(columns["code"] >= 0)[first].tolist()
    assert np.array_equal(tally.numbers(known), number)
    same(tally.rows, {name: values[first] for name, values in known.items()})


@pytest.mark.parametrize("archived", [False, True])
def test_memory_does_not_grow_with_the_starts(tmp_path, archived):
    def peak(number):
        place = tmp_path / f"{number}.zarr" if archived else None
        tracemalloc.start()
        found = experiment(
            PNEUMATIC, number, seed=2, modes=0, stop=Stop(impacts=2), rows=100, workers=1, chunk=2000, archive=place
        )
        used = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert len(found) == number and found.columns["code"].size == 100
        return used

    peak(2000)  # what is loaded and kept once
    assert peak(80_000) < 1.2 * peak(8000)


def test_starts_without_rows_are_counted(tmp_path):
    asked = {"seed": 2, "modes": 0, "workers": 1, "stop": Stop(impacts=100)}
    whole = experiment(PNEUMATIC, 400, **asked, archive=tmp_path / "a.zarr", chunk=70)
    for few in (
        experiment(PNEUMATIC, 400, **asked, rows=90),
        experiment(PNEUMATIC, 400, **asked, rows=90, archive=tmp_path / "a.zarr", resume=True),
        Experiment.from_archive(Archive.open(tmp_path / "a.zarr"), rows=90),
    ):
        assert few.to_json_dict() == whole.to_json_dict() and len(few) == 400 and few.labels == whole.labels
        assert np.array_equal(few.attractor, whole.attractor[:90]) and len(few.starts) == 90
        assert few.attractors == whole.attractors
        assert few.to_xarray().attrs["starts_without_rows"] == 310
        with pytest.raises(ParameterError, match="rows"):
            few.save(tmp_path / "few.nc")
    assert dataset_of(Archive.open(tmp_path / "a.zarr")).sizes["start"] == 400
    whole.save(tmp_path / "whole.nc")
    assert Experiment.load(tmp_path / "whole.nc").to_json_dict() == whole.to_json_dict()


def test_a_motion_shifted_by_a_load_period_is_the_same_attractor():
    system = System(s=1e6, d=0.0, restitution=0.8, load=Load.harmonic(1.2, 1.0))
    orbit = steady_states(system, 2, modes=0).orbits[1]
    starts = Starts.rigid(0.0, orbit.rebound_velocity * 1.001, orbit.phase + TURN * np.array([0.0, 1.0, 2.0, 7.0]))
    found = experiment(system, None, starts, workers=1, modes=0)
    assert [share.label for share in found.shares] == ["z=1/2"]
    assert found.shares[0].phases == pytest.approx((orbit.phase,), abs=1e-6)


def test_the_true_period_of_the_load_counts():
    once = System(s=1e6, d=0.0, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    twice = System(s=1e6, d=0.0, restitution=0.6, load=Load.harmonic(0.9, 1.0, harmonic=2))
    counts = [len(experiment(system, 400, "wall", 1, workers=1, modes=0).shares) for system in (once, twice)]
    assert counts == [2, 2]


def test_long_cycles_are_told_with_all_their_impacts():
    system = System(s=1e6, d=0.0, restitution=0.97, load=Load.harmonic(0.99, 1.0))
    found = experiment(system, 12, "gentle", 1, stop=Stop(impacts=20_000), workers=1, modes=0)
    share = next(share for share in found.shares if share.label == "chatter/1")
    p = found.columns["cycle_impacts"][share.attractor.first]
    assert p > 256 and len(share.phases) == len(share.impact_velocities) == p
    assert max(share.impact_velocities) == share.impact_velocities[0]
    assert sum(s.label == "chatter/1" for s in found.shares) == 1
    assert np.isfinite(found.columns["invariants"][found.attractor == share.attractor.number]).all()


def test_the_numbers_of_an_attractor_are_those_of_its_motion():
    found = experiment(PNEUMATIC, 300, "wall", 1, workers=1, modes=0)
    assert [share.label for share in found.shares] == ["chatter/1", "z=2/2"]
    for share in found.shares:
        motion = run(PNEUMATIC, found.starts[share.attractor.first], modes=0)
        blows = motion.events.of("impact")
        n = len(share.phases)
        assert motion.label == share.label
        assert sorted(blows.phase[-n:]) == pytest.approx(sorted(share.phases), abs=1e-6)
        rates = found.columns["main_blow_rate"][found.attractor == share.attractor.number]
        assert motion.summary.main_blow_rate == pytest.approx(rates.mean(), rel=1e-6)
    assert share.phases[0] == pytest.approx(found.columns["phase"][share.attractor.first])
    assert share.impact_velocities[0] == pytest.approx(max(share.impact_velocities))


def test_what_is_no_longer_wanted_ends_early():
    job = experiment_job(PNEUMATIC, 200_000, "wall", 1, stop=Stop(impacts=10**6, periodic=False), modes=0)
    calls = []

    def stopped():
        calls.append(1)
        return True

    found = job.compute(0, 200_000, stopped)
    assert len(calls) < 10 and len(found["code"]) < 200


def test_the_ask_tells_all_that_matters():
    asks = [
        experiment_job(*args, **kwargs).ask
        for args, kwargs in [
            ((PNEUMATIC, 10), {}),
            ((TWINS, 10), {}),
            ((PNEUMATIC, 11), {}),
            ((PNEUMATIC, 10, "field"), {}),
            ((PNEUMATIC, 10, "wall", 1), {}),
            ((PNEUMATIC, 10), {"modes": 1}),
            ((PNEUMATIC, 10), {"stop": Stop(impacts=50)}),
            ((PNEUMATIC, 10), {"stop": Stop(tolerance=1e-6)}),
            ((PNEUMATIC, 10, Starts.rigid(-1.0, 0.0, np.arange(10.0))), {}),
            ((PNEUMATIC, 10, Starts.rigid(-2.0, 0.0, np.arange(10.0))), {}),
        ]
    ]
    texts = [json.dumps(ask, sort_keys=True) for ask in asks]
    assert len(set(texts)) == len(texts)
    assert experiment_job(PNEUMATIC, 10, threads=2).ask == asks[0]


def test_motions_that_do_not_repeat_have_no_phases():
    resting = System(s=1e6, d=0.0, restitution=0.5, load=Load.harmonic(1.2, 1.0))
    found = experiment(resting, 50, "gentle", 1, workers=1, modes=0)
    assert found.to_json_dict()["shares"][0]["label"] == "rest"
    assert found.shares[0].phases == () and found.shares[0].share == 1.0
    steps = System(s=1e6, d=0.0, restitution=0.8, load=Load.square(1.0, 1.3))
    lost = experiment(steps, 20, "field", 1, stop=Stop(impacts=200), workers=1, modes=0)
    assert {"aperiodic"} <= set(lost.label) and lost.shares[0].phases == ()


def test_a_cycle_with_rest_of_open_length_has_one_name_in_shares_and_maps():
    """p = 0.34688 + cos t, R = 0.6: released again at the same phase, but rounding decides after how many periods."""
    system = System(20.0, 1e-9, 0.6, Load.harmonic(0.34688, 1.0))
    assert [share.label for share in experiment(system, 3, modes=0).shares] == ["chatter/?"]
    found = sweep(system, Axis("restitution", np.array([0.6, 0.6 + 1e-15])), quantities=["label"], modes=0)
    assert found["label"].tolist() == ["chatter/?", "chatter/?"]


# -- machines: which run ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("stiffness", [0.9, 1.2, 1.5])
def test_starts_on_the_wall_run_when_their_energy_takes_them_to_the_port(stiffness):
    """Without drag: v² + 2 a_r S > κS² in the state of return; in that of power the blow comes first, and leaves R²v².

    What has reached the port once gets (a_r + a_p)S there and runs on, if the machine can run at all: at the blow of
    its cycle, w = 2 (a_r + a_p)S/(1 − R²), the same must hold of R²w.
    """
    found = experiment(machine(stiffness), 2000, "wall", seed=3, workers=1, modes=0)
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


def test_members_of_an_attractor_have_its_label_and_its_period():
    """A machine with long delays has several motions beside each other."""
    late = (Port("power", behind=1.0, side="back", delay=0.9), Port("return", behind=0.1, side="front", delay=0.9))
    twin = Machine(UniformBar(20.0), Valve({"return": -0.3, "power": 1.0}, late), Kept(0.8))
    found = experiment(twin, 300, "field", seed=1, workers=1, modes=0)
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


# -- planes -----------------------------------------------------------------------------------------------------------


def test_the_shares_of_a_box_are_those_of_random_starts_in_it():
    """As many random starts from the box as the image has points: the parts agree within the intervals."""
    n = 70
    grid = basins(
        TWINS,
        ("time", TURN / (2 * n), TURN * (1 - 1 / (2 * n)), n),
        ("velocity", -5.0 * (1 - 1 / (2 * n)), -5.0 / (2 * n), n),
        workers=1,
        modes=0,
    )

    def uniform(seed):
        draw = np.random.default_rng(seed)
        return Starts.rigid(0.0, -5.0 * draw.random(n * n), TURN * draw.random(n * n))

    random = experiment(TWINS, None, uniform, seed=1, workers=1, modes=0)
    assert [a.label for a in grid.attractors[:2]] == ["z=1/1", "z=1/1"]
    for share in grid.shares[:2]:
        twin = min((s for s in random.shares if s.label == "z=1/1"), key=lambda s: abs(s.phases[0] - share.phases[0]))
        assert twin.phases == pytest.approx(share.phases, abs=1e-6)
        middle, half = twin.share, 0.5 * (twin.high - twin.low)
        assert abs(share.share - middle) < 2.0 * half
    assert sum(attractor.members for attractor in grid.attractors) == n * n


def test_modal_amplitudes():
    found = basins(ELASTIC, "u_1=-0.3:0.3:3", Axis.linear("v_2", -0.2, 0.2, 2), at={"position": -1.0}, modes=2)
    for i, v in enumerate((-0.2, 0.2)):
        for j, u in enumerate((-0.3, 0.0, 0.3)):
            start = Start.modal([-1.0 + 2.0 * u, u, 0.0], [0.0, 0.0, v])
            assert found.label[i, j] == run(ELASTIC, start, modes=2).label
    assert found.columns["start_displacement"].shape == (6, 3)
    assert np.allclose(found.columns["position"], -1.0)


def test_what_is_not_done_has_no_number():
    found = basins(TWINS, ("time", 0.0, 6.0, 5), ("velocity", -4.0, -0.5, 4), workers=1, modes=0)
    found.columns["code"][:7] = -1
    part = replace(found)
    assert (part.image.reshape(-1)[:7] == -1).all() and (part.image.reshape(-1)[7:] >= 0).all()
    assert (part.label.reshape(-1)[:7] == "").all() and sum(a.members for a in part.attractors) == 13


def test_machines_start_with_the_valve_as_it_is_said(tmp_path):
    plane, place = (("position", -1.5, -0.1, 5), ("velocity", -2.0, 2.0, 4)), tmp_path / "b.zarr"
    found = basins(GAS, *plane, at={"state": "power"}, workers=1, archive=place, modes=0)
    for i, j in np.ndindex(4, 5):
        start = Start.rigid(found.x[1][j], found.y[1][i]).with_valve("power")
        assert found.label[i, j] == run(GAS, start, modes=0).label
    again = Basins.from_archive(Archive.open(place))
    assert again.at == (("state", 1.0),) and np.array_equal(again.image, found.image)
    assert found.to_xarray()["state"].values.tolist() == np.ones((4, 5), dtype=int).tolist()
    usual = basins(GAS, ("position", [-0.9]), ("velocity", [0.0]), workers=1, modes=0)
    assert usual.columns["state"].tolist() == [0]


# -- what is told -----------------------------------------------------------------------------------------------------


def test_dataset_of_a_plane():
    found = basins(TWINS, ("time", 0.0, 6.0, 5), ("velocity", -4.0, -0.5, 4), at={"position": -0.1}, workers=1, modes=0)
    data = found.to_xarray()
    assert data["attractor_number"].dims == ("velocity", "time") and data["attractor_number"].shape == (4, 5)
    assert data["time"].attrs["units"] == "rad" and data.attrs["at_position"] == -0.1
    assert data["invariants"].dims == ("velocity", "time", "invariant")
    assert np.array_equal(data["attractor_number"], found.image)
    assert "Basins: 5 × 4 starts" in str(found)


def test_a_dataset_says_that_it_is_dimensionless_and_has_the_scales(tmp_path):
    experiment(IN_SI, 30, "wall", 1, workers=1, archive=tmp_path / "e.zarr", modes=0)
    data = Experiment.from_archive(Archive.open(tmp_path / "e.zarr")).to_xarray()
    for name, scale, unit in (
        ("impact_velocity", IN_SI.speed_scale, "m/s"),
        ("blow_energy", IN_SI.energy_scale, "J"),
        ("position", IN_SI.length_scale, "m"),
        ("interval_mean", IN_SI.time_scale, "s"),
    ):
        assert data[name].attrs["si_scale"] == pytest.approx(scale) and data[name].attrs["si_units"] == unit
    assert data["impact_velocity"].attrs["units"] == "1"
    assert data["impact_velocity"].attrs["comment"] == "dimensionless" and "comment" not in data["code"].attrs
    assert data.attrs["frequency_Hz"] == 60.0 and data.attrs["scaling"].startswith("dimensionless")
    found = experiment(PNEUMATIC, 30, "wall", 1, workers=1, modes=0)
    plain = found.to_xarray()
    assert plain.sizes["start"] == 30 and plain["attractor_label"].values.tolist() == [
        one.label for one in found.shares
    ]
    assert plain["velocity"].attrs["units"] == "bar lengths/rad" and plain["phase"].attrs["units"] == "rad"
    assert all("long_name" in plain[name].attrs for name in plain.data_vars)
    assert np.array_equal(plain["attractor_number"], found.attractor) and "Experiment: 30 starts" in str(found)
    assert plain["blow_energy"].attrs["comment"] == "dimensionless" and "si_scale" not in plain["blow_energy"].attrs
    assert "frequency_Hz" not in plain.attrs
    data = basins(IN_SI, ("time", 0.0, 6.0, 3), ("velocity", -4.0, -0.5, 3), workers=1, modes=0).to_xarray()
    assert data["time"].attrs == {"units": "rad", "si_scale": IN_SI.time_scale, "si_units": "s"}
    assert data["velocity"].attrs["si_scale"] == IN_SI.speed_scale
    assert data.attrs["scaling"].startswith("dimensionless")


def test_the_table_has_words_units_and_scales():
    from percuss.case import load_case

    found = experiment(
        load_case("valve-drifter").machine(), 20, "wall", seed=1, stop=Stop(impacts=100), workers=1, modes=0
    )
    data = found.to_xarray()
    assert set(MACHINE_COLUMNS) <= set(data) and data.attrs["machine"].startswith("Machine")
    assert data["state"].attrs["words"] == "return, power" and data["stall"].attrs["words"] == ", ".join(STALLS)
    assert data["velocity"].attrs["si_units"] == "m/s" and data["period"].attrs["si_units"] == "s"
    assert data["velocity"].attrs["si_scale"] == pytest.approx(found.system.length_scale)
    first = found.shares[0]
    assert first.label == "runs 1/1" and first.attractor.figures["period"] == pytest.approx(1.0 / 61.2, rel=2e-3)
    assert first.impact_velocities[0] * found.system.speed_scale == pytest.approx(10.92, rel=1e-3)
    json.dumps(found.to_json_dict(), allow_nan=False)


def test_pictures_of_a_case_in_si_have_axes_in_si():
    from percuss import plot

    bar = Bar(length=0.09, diameter=0.06)
    system = System.from_si(bar, Load.harmonic(mean=900.0, amplitude=1200.0, frequency=33.0), Kept(restitution=0.3))
    speed = 8.0 / system.speed_scale
    found = basins(system, ("time", 0.1, 6.2, 6), ("velocity", -speed, -0.1 * speed, 5), modes=0, workers=1)
    panel = plot.basins(found).axes[0]
    assert panel.get_xlabel().endswith("[ms]") and panel.get_ylabel() == "velocity of the start [m/s]"
    assert panel.get_ylim()[0] == pytest.approx(-8.9) and 30.0 < panel.get_xlim()[1] < 34.0
    starts = plot.experiment(experiment(system, 40, modes=0, workers=1)).axes[1]
    assert starts.get_xlabel().endswith("[ms]") and "[m/s]" in starts.get_ylabel()
    plain = plot.basins(basins(ELASTIC, ("time", 0.1, 6.2, 4), ("position", -3.0, -0.1, 3), modes=0, workers=1)).axes[0]
    assert plain.get_xlabel() == "load phase of the start [rad]" and "[bar lengths]" in plain.get_ylabel()
