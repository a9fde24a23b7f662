"""Experiments: starts, shares and their intervals, attractors told apart, the same bits however the work is cut."""

import json

import numpy as np
import pytest
from scipy import stats

from percuss import Bar, Kept, Load, Start, Starts, Stop, System, run, stability_of, steady_states
from percuss.errors import ParameterError, PercussError, ResonanceError
from percuss.explore import Axis, sweep
from percuss.explore.attractors.drawn_starts import BLOCK, DISTRIBUTIONS, drawn, named, own
from percuss.explore.attractors.experiments import Experiment, experiment, experiment_job, wilson
from percuss.explore.attractors.hammers import ClockedHammer, invariants_of
from percuss.explore.jobs.archive import Archive
from percuss.explore.jobs.carrying_out import carry_out

TURN = 2.0 * np.pi
PNEUMATIC = System(s=20.0, d=0.0, restitution=0.6, load=Load.harmonic(0.7, 1.0))
# two stable motions z=1/1, of one striking speed, at different phases
TWINS = System(s=1e6, d=0.0, restitution=0.6, load=Load.fourier([0.6, 1.0, np.exp(1.0j)]))


# -- intervals ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("n", [1, 7, 100, 12345, 10**6])
def test_wilson_beside_scipy(n):
    for k in {0, 1, n // 3, n // 2, n - 1, n}:
        for confidence in (0.8, 0.95, 0.999):
            theirs = stats.binomtest(k, n).proportion_ci(confidence, method="wilson")
            assert wilson(k, n, confidence) == pytest.approx((theirs.low, theirs.high), rel=1e-10, abs=1e-15)


def test_wilson_at_its_ends():
    assert wilson(0, 0) == (0.0, 1.0)
    assert wilson(0, 10)[0] == 0.0 and wilson(10, 10)[1] == 1.0
    for wrong in ((-1, 3), (4, 3), (1.5, 3)):
        with pytest.raises(ParameterError):
            wilson(*wrong)
    with pytest.raises(ParameterError):
        wilson(1, 3, 1.0)


# -- starts ---------------------------------------------------------------------------------------------------------


def test_the_named_distributions():
    n = 200_000
    scale = TURN * 0.7 / 1.6
    for name in DISTRIBUTIONS:
        starts = named(PNEUMATIC, name, n, 5)
        phase, speed = starts.time, starts.velocity[:, 0]
        assert starts.displacement.shape == starts.velocity.shape == (n, 1)
        assert stats.kstest(phase / TURN, "uniform").pvalue > 1e-3 and phase.min() >= 0.0 and phase.max() < TURN
        if name == "field":
            assert stats.kstest(starts.gap / 20.0 + 1.0, "uniform").pvalue > 1e-3
            assert stats.kstest(speed / 5.0, "norm").pvalue > 1e-3
            assert abs(np.corrcoef(starts.gap, speed)[0, 1]) < 0.01
        else:
            assert not starts.gap.any() and speed.max() < 0.0
        if name == "wall":
            assert stats.kstest(-speed / scale, "halfnorm").pvalue > 1e-3
        if name == "gentle":
            assert stats.kstest(-speed / 0.2, "uniform").pvalue > 1e-3 and speed.min() >= -0.2
        assert abs(np.corrcoef(phase, speed)[0, 1]) < 0.01


@pytest.mark.parametrize("name", DISTRIBUTIONS)
def test_starts_are_those_of_the_seed(name):
    one, more, other = (named(PNEUMATIC, name, n, seed) for n, seed in ((50, 3), (500, 3), (50, 4)))
    for field in ("displacement", "velocity", "gap", "time"):
        assert np.array_equal(getattr(one, field), getattr(more, field)[:50])
    assert not np.array_equal(one.time, other.time)


@pytest.mark.parametrize("name", DISTRIBUTIONS)
def test_portions_of_starts_are_those_of_the_whole(name):
    whole = named(PNEUMATIC, name, 2 * BLOCK + 10, 3)
    for first, last in ((0, 1), (BLOCK - 3, BLOCK + 3), (BLOCK, 2 * BLOCK), (10, 2 * BLOCK + 10)):
        part = named(PNEUMATIC, name, last - first, 3, first)
        for field in ("displacement", "velocity", "gap", "time"):
            assert np.array_equal(getattr(part, field), getattr(whole, field)[first:last])
    assert not np.array_equal(whole.time[:BLOCK], whole.time[BLOCK : 2 * BLOCK])
    assert np.unique(whole.time).size == len(whole)


def test_a_portion_of_very_many_starts_is_drawn_alone():
    """10¹² of them would take 30 TB."""
    n = 10**12
    for job in (
        experiment_job(PNEUMATIC, n, "wall", 1, stop=Stop(impacts=50)),
        experiment_job(PNEUMATIC, n, Starts.rigid(-1.0, 0.0, [0.0, 1.0, 2.0]), 1, stop=Stop(impacts=50)),
    ):
        last = job.compute(n - 5, n, lambda: False)
        same(job.compute(n - 2, n, lambda: False), {name: values[3:] for name, values in last.items()})
    with pytest.raises(PercussError, match="memory"):
        carry_out(job, workers=1)


def test_drawing_with_replacement_does_not_depend_on_how_many():
    rows = Starts.rigid(-1.0, 0.0, np.arange(7.0))
    whole = drawn(rows, BLOCK + 100, 4)
    assert np.array_equal(drawn(rows, 50, 4).time, whole.time[:50])
    assert np.array_equal(drawn(rows, 60, 4, BLOCK - 30).time, whole.time[BLOCK - 30 : BLOCK + 30])
    assert stats.chisquare(np.bincount(whole.time.astype(int))).pvalue > 1e-3


def test_wall_needs_a_load_that_pushes():
    pulled = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(-0.1, 1.0))
    with pytest.raises(ParameterError, match="pushes"):
        named(pulled, "wall", 10)
    assert len(named(pulled, "field", 10)) == 10


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
    found = experiment(PNEUMATIC, None, tmp_path / "a.csv", workers=1)
    assert len(found) == 3 and found.distribution == "a.csv"
    assert np.array_equal(found.columns["position"], table[:, 0])
    many = experiment(PNEUMATIC, 40, str(tmp_path / "a.csv"), seed=2, workers=1)
    assert set(many.columns["position"]) == {-1.0, 0.0, -2.0} and len(many) == 40
    two = experiment(PNEUMATIC, 2, str(tmp_path / "a.csv"), workers=1)
    assert np.array_equal(two.columns["position"], table[:2, 0])
    ringing = experiment(PNEUMATIC, None, tmp_path / "m.npz", modes=3, workers=1)
    assert ringing.columns["start_displacement"].shape == (2, 3) and len(ringing.shares) >= 1


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("position,velocity,time\n-1,0,0\n-1,x,0\n", "line 3"),
        ("position,velocity,time\n-1,0\n", "3 numbers"),
        ("place,velocity\n-1,0\n", "place"),
        ("position,u_0\n-1,0\n", "both"),
        ("time\n1\n", "no column"),
        ("position\n0.5\n", "wall"),
        ("u_0,u_1\n0,-1\n", "wall"),
        ("position\nnan\n", "finite"),
        ("position\n", "row"),
        ("", "row"),
        ("position,position\n-1,-1\n", "once"),
    ],
)
def test_bad_files(tmp_path, text, word):
    path = tmp_path / "starts.csv"
    path.write_text(text)
    with pytest.raises(ParameterError, match=word):
        own(PNEUMATIC, path)


def test_no_such_distribution(tmp_path):
    with pytest.raises(ParameterError, match="wall, field, gentle"):
        experiment(PNEUMATIC, 10, "walls", workers=1)
    with pytest.raises(ParameterError, match="regular"):
        own(PNEUMATIC, tmp_path)
    (tmp_path / "x.npz").write_bytes(b"no archive")
    (tmp_path / "x.nc").write_bytes(b"no archive")
    for name in ("x.npz", "x.nc"):
        with pytest.raises(ParameterError, match="file of numbers"):
            own(PNEUMATIC, tmp_path / name)
    with pytest.raises(ParameterError, match="Starts"):
        own(PNEUMATIC, lambda seed: seed)
    for wrong in (
        {"starts": 0}, {"seed": -1}, {"modes": -1}, {"stop": 3}, {"distance": "x"}, {"stop": Stop(impacts=0)}
    ):  # fmt: skip
        with pytest.raises(ParameterError):
            experiment(PNEUMATIC, **{"starts": 10, **wrong}, workers=1)


def test_what_cannot_be_followed_is_refused_at_once():
    resonant = System(s=1.0 / np.pi, d=0.0, restitution=0.5, load=Load.harmonic(0.5, 1.0))
    with pytest.raises(ResonanceError):
        experiment_job(resonant, 10, modes=3)
    assert experiment_job(resonant, 10, modes=0).size == 10
    ringing = Starts.random(PNEUMATIC, 5, distribution="ringing", modes=4)
    with pytest.raises(ParameterError, match="more modes"):
        experiment_job(PNEUMATIC, None, ringing, modes=3)
    assert experiment_job(PNEUMATIC, None, ringing, modes=4).size == 5


def test_a_function_of_the_seed():
    def close(seed):
        return Starts.rigid(0.0, -0.01 * (1 + np.arange(5)), float(seed))

    found = experiment(PNEUMATIC, None, close, seed=3, workers=1)
    assert len(found) == 5 and set(found.columns["time"]) == {3.0} and "close" in found.distribution
    same = drawn(close(3), 100, 8)
    assert np.array_equal(same.velocity, drawn(close(3), 100, 8).velocity)
    assert not np.array_equal(same.velocity, drawn(close(3), 100, 9).velocity)


# -- attractors -----------------------------------------------------------------------------------------------------


def test_two_motions_of_one_label_are_told_apart():
    stable = [o for o in steady_states(TWINS, modes=0).orbits if o.admissible and stability_of(o, modes=0).stable]
    found = experiment(TWINS, 1500, "wall", 1, workers=1)
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


def test_a_motion_shifted_by_a_load_period_is_the_same_attractor():
    system = System(s=1e6, d=0.0, restitution=0.8, load=Load.harmonic(1.2, 1.0))
    orbit = steady_states(system, 2, modes=0).orbits[1]
    starts = Starts.rigid(0.0, orbit.rebound_velocity * 1.001, orbit.phase + TURN * np.array([0.0, 1.0, 2.0, 7.0]))
    found = experiment(system, None, starts, workers=1)
    assert [share.label for share in found.shares] == ["z=1/2"]
    assert found.shares[0].phases == pytest.approx((orbit.phase,), abs=1e-6)


def test_the_true_period_of_the_load_counts():
    once = System(s=1e6, d=0.0, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    twice = System(s=1e6, d=0.0, restitution=0.6, load=Load.harmonic(0.9, 1.0, harmonic=2))
    counts = [len(experiment(system, 400, "wall", 1, workers=1).shares) for system in (once, twice)]
    assert counts == [2, 2]


def test_long_cycles_are_told_with_all_their_impacts():
    system = System(s=1e6, d=0.0, restitution=0.97, load=Load.harmonic(0.99, 1.0))
    found = experiment(system, 12, "gentle", 1, stop=Stop(impacts=20_000), workers=1)
    share = next(share for share in found.shares if share.label == "chatter/1")
    p = found.columns["cycle_impacts"][share.attractor.first]
    assert p > 256 and len(share.phases) == len(share.impact_velocities) == p
    assert max(share.impact_velocities) == share.impact_velocities[0]
    assert sum(s.label == "chatter/1" for s in found.shares) == 1
    assert np.isfinite(found.columns["invariants"][found.attractor == share.attractor.number]).all()


def test_the_numbers_of_an_attractor_are_those_of_its_motion():
    found = experiment(PNEUMATIC, 300, "wall", 1, workers=1)
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


# -- the same bits --------------------------------------------------------------------------------------------------


def same(one, other):
    assert one.keys() == other.keys()
    for name in one:
        assert one[name].dtype == other[name].dtype and one[name].tobytes() == other[name].tobytes(), name


def test_what_is_no_longer_wanted_ends_early():
    job = experiment_job(PNEUMATIC, 200_000, "wall", 1, stop=Stop(impacts=10**6, periodic=False))
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


# -- what is told ---------------------------------------------------------------------------------------------------


def test_json():
    found = experiment(PNEUMATIC, 200, "wall", 7, workers=1)
    tree = json.loads(json.dumps(found.to_json_dict(), allow_nan=False))
    assert tree.keys() == {"starts", "seed", "distribution", "modes", "shares"}
    assert (tree["starts"], tree["seed"], tree["distribution"]) == (200, 7, "wall")
    for share in tree["shares"]:
        assert share.keys() == {"label", "share", "low", "high", "phases", "impact_velocities"}
        assert 0.0 <= share["low"] <= share["share"] <= share["high"] <= 1.0
        assert len(share["phases"]) == len(share["impact_velocities"]) > 0
    parts = [share["share"] for share in tree["shares"]]
    assert parts == sorted(parts, reverse=True) and sum(parts) == pytest.approx(1.0)


def test_motions_that_do_not_repeat_have_no_phases():
    resting = System(s=1e6, d=0.0, restitution=0.5, load=Load.harmonic(1.2, 1.0))
    found = experiment(resting, 50, "gentle", 1, workers=1)
    assert found.to_json_dict()["shares"][0]["label"] == "rest"
    assert found.shares[0].phases == () and found.shares[0].share == 1.0
    steps = System(s=1e6, d=0.0, restitution=0.8, load=Load.square(1.0, 1.3))
    lost = experiment(steps, 20, "field", 1, stop=Stop(impacts=200), workers=1)
    assert {"aperiodic"} <= set(lost.label) and lost.shares[0].phases == ()


def test_dataset():
    found = experiment(PNEUMATIC, 60, "wall", 1, workers=1)
    data = found.dataset
    assert data.sizes["start"] == 60 and data.sizes["attractor"] == len(found.shares)
    assert data["velocity"].attrs["units"] == "bar lengths/rad" and data["phase"].attrs["units"] == "rad"
    assert all("long_name" in data[name].attrs for name in data.data_vars)
    assert data["attractor_label"].values.tolist() == [share.label for share in found.shares]
    assert np.array_equal(data["attractor_number"], found.attractor)
    assert "Experiment: 60 starts" in str(found) and "%" in str(found)


def test_a_dataset_says_that_it_is_dimensionless_and_has_the_scales(tmp_path):
    bar = Bar(length=0.341, diameter=0.049, damping_ratio=1e-3)
    system = System.from_si(bar, Load.harmonic(5e3, 6e3, frequency=60.0), Kept(restitution=0.6))
    experiment(system, 30, "wall", 1, workers=1, archive=tmp_path / "e.zarr")
    data = Experiment.from_archive(Archive.open(tmp_path / "e.zarr")).dataset
    for name, scale, unit in (
        ("impact_velocity", system.speed_scale, "m/s"),
        ("blow_energy", system.energy_scale, "J"),
        ("position", system.length_scale, "m"),
        ("interval_mean", system.time_scale, "s"),
    ):
        assert data[name].attrs["si_scale"] == pytest.approx(scale) and data[name].attrs["si_units"] == unit
    assert data["impact_velocity"].attrs["units"] == "1"
    assert data["impact_velocity"].attrs["comment"] == "dimensionless" and "comment" not in data["code"].attrs
    assert data.attrs["frequency_Hz"] == 60.0 and data.attrs["scaling"].startswith("dimensionless")
    plain = experiment(PNEUMATIC, 30, "wall", 1, workers=1).dataset
    assert plain["blow_energy"].attrs["comment"] == "dimensionless" and "si_scale" not in plain["blow_energy"].attrs
    assert "frequency_Hz" not in plain.attrs


def test_shares_beside_single_motions():
    starts = named(PNEUMATIC, "wall", 40, 9)
    found = experiment(PNEUMATIC, 40, "wall", 9, workers=1)
    alone = [run(PNEUMATIC, Start.rigid(0.0, s.velocity[0], s.time), modes=0).label for s in starts]
    assert found.label.tolist() == alone


def test_a_cycle_with_rest_of_open_length_has_one_name_in_shares_and_maps():
    """p = 0.34688 + cos t, R = 0.6: released again at the same phase, but rounding decides after how many periods."""
    system = System(20.0, 1e-9, 0.6, Load.harmonic(0.34688, 1.0))
    assert [share.label for share in experiment(system, 3, modes=0).shares] == ["chatter/?"]
    found = sweep(system, Axis("restitution", np.array([0.6, 0.6 + 1e-15])), quantities=["label"], modes=0)
    assert found["label"].tolist() == ["chatter/?", "chatter/?"]
