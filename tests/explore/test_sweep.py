"""Maps: every cell against the question asked of one system, by arrays, one by one, and in any portions."""

from dataclasses import replace

import numpy as np
import pytest

from percuss import Load, Start, Stop, System, rest_on_wall, run, si_report, stability_of, steady_states
from percuss.blow.closed_forms import matched_efficiency
from percuss.case import Case, CaseFamily, blow_answer, load_case, machine_answer, sweep_job_of
from percuss.errors import CaseError, ParameterError, UnitError
from percuss.explore import (
    MACHINE_QUANTITIES,
    QUANTITIES,
    REASONS,
    STALLS,
    Axis,
    Sweep,
    SystemFamily,
    boundaries,
    carry_out,
    sweep,
    vary,
)
from percuss.explore.cells import fits_plane, label_text
from percuss.explore.sweeps import sweep_job, true_ranges
from percuss.model import Chamber, External, Kept, Machine, Port, Reversed, UniformBar, Valve
from percuss.steady import self_excited_motion
from random_hammers import random_hammer

PNEUMATIC = System(s=20.0, d=0.0, restitution=0.6, load=Load.harmonic(0.9, 1.0))
SQUARE = System(s=20.0, d=0.0048, restitution=0.6, load=Load.square(1.0, 1.3))
NEVER = lambda: False  # noqa: E731


def best(system, periods=1, modes=8):
    orbits = steady_states(system, periods, modes=modes).orbits
    verdicts = [stability_of(orbit, modes=modes) for orbit in orbits]
    at = int(np.argmax([verdict.margin for verdict in verdicts]))
    return orbits, verdicts, at


# -- the cells --------------------------------------------------------------------------------------------------------

CLOSED = ["exists", "orbits", "phases", "phase", "reduced_stable", "reduced_margin", "stable", "margin"]


@pytest.mark.parametrize("system", [PNEUMATIC, SQUARE], ids=["harmonic", "square"])
def test_planes_agree_with_single_cells(system):
    axes = ("restitution=0.1:0.9:5", "load_factor=0.1:1:5", "m=1,2")
    whole = sweep(system, *axes, quantities=CLOSED, modes=8, workers=1)
    job = sweep_job(system, *axes, quantities=[*CLOSED, "rest"], modes=8)
    assert not fits_plane(job.family, ["restitution"], job.quantities)  # rest is asked of each cell by itself
    single = job.compute(0, job.size, NEVER)
    for name in CLOSED:
        a, b = whole[name].reshape(single[name].shape), single[name]
        if a.dtype == bool or a.dtype.kind in "iu":
            assert np.array_equal(a, b), name
        else:
            np.testing.assert_allclose(a, b, rtol=0.0, atol=1e-8, err_msg=name)
    assert whole["exists"].any() and not whole["exists"].all()


def test_cells_are_what_a_system_says():
    names = [name for name, quantity in QUANTITIES.items() if quantity.group not in ("lyapunov", "blow", "transfer")]
    found = sweep(PNEUMATIC, "restitution=0.2,0.6,0.8", "s=3,20", quantities=names, modes=8, workers=1)
    for i, r in enumerate((0.2, 0.6, 0.8)):
        for j, s in enumerate((3.0, 20.0)):
            system = System(s=s, d=0.0, restitution=r, load=Load.harmonic(0.9, 1.0))
            assert found["rest"][i, j] == rest_on_wall(system).possible
            motion = run(system, Start.rigid(), modes=8)
            assert found["label"][i, j] == motion.label
            if steady_states(system).orbits:
                orbits, verdicts, at = best(system)
                assert found["phase"][i, j] == orbits[at].phase
                assert found["margin"][i, j] == verdicts[at].margin
                assert found["stable"][i, j] == any(verdict.stable for verdict in verdicts)
                assert found["admissible"][i, j] == orbits[at].admissible
                assert found["impact_velocity"][i, j] == orbits[at].impact_velocity
                assert found["power"][i, j] == orbits[at].blow_energy / (2.0 * np.pi)
                stable = REASONS[found["reason"][i, j]] == "stable"
                assert stable == verdicts[at].stable
            else:
                assert not found["exists"][i, j] and np.isnan(found["phase"][i, j])


@pytest.mark.parametrize("modes", [None, 0, 5])
def test_every_figure_of_a_cell_is_of_one_bar(modes):
    """That of `modes`, or of the continuous one, as in a single answer; soft enough for them to differ."""
    system = System(s=1.0, d=0.02, restitution=0.3, load=Load.fourier([0.25, 1.0, 0.4j]))
    names = ["admissible", "impact_velocity", "blow_energy", "power", "margin", "reason"]
    found = sweep(system, "restitution=0.3", quantities=names, modes=modes, workers=1)
    orbits, verdicts, at = best(system, modes=modes)
    assert found["admissible"][0] == orbits[at].admissible == (modes == 0)
    assert found["impact_velocity"][0] == orbits[at].impact_velocity
    assert found["blow_energy"][0] == orbits[at].blow_energy
    assert found["margin"][0] == verdicts[at].margin
    other = sweep(system, "restitution=0.3", quantities=names, modes=8, workers=1)
    assert other["impact_velocity"][0] != found["impact_velocity"][0] and other.ask != found.ask


@pytest.mark.parametrize("seed", range(12))
def test_a_cell_is_the_same_however_it_is_asked_for(seed):
    """On threads, in strips, and alone or beside what takes a proof: to the bit, for hammers of all kinds."""
    system, modes = random_hammer(seed)
    figures = ["blow_energy", "power", "margin_rhythm"]
    for names, beside in ((CLOSED, CLOSED), (figures, [*figures, "admissible"]), (["label"], ["label"])):
        options = {"modes": modes, "stop": Stop(impacts=60)}
        axes = ("restitution=0,0.3,0.8,1", "load_factor=0.05:1:5")
        job, other = (sweep_job(system, *axes, quantities=asked, **options) for asked in (names, beside))
        whole, with_proof = job.compute(0, job.size, NEVER), other.compute(0, job.size, NEVER)
        strips = [job.compute(first, first + 5, NEVER) for first in range(0, job.size, 5)]
        threads = replace(job, workers=3).compute(0, job.size, NEVER)
        proved = with_proof["outcome"] == whole["outcome"]  # a proof may fail
        for name, values in whole.items():
            np.testing.assert_array_equal(values, np.concatenate([strip[name] for strip in strips]), name)
            np.testing.assert_array_equal(values, threads[name], name)
            np.testing.assert_array_equal(values[proved], with_proof[name][proved], name)


def test_a_case_that_names_the_modes_of_its_simulation_says_nothing_of_its_steady_motions():
    text = "[system]\ns = 1.0\nd = 0.02\nrestitution = 0.3\n[load]\nkind = 'fourier'\n"
    text += "coefficients = [[0.25, 0.0], [1.0, 0.0], [0.0, 0.4]]\n[simulation]\nmodes = 2\nimpacts = 100\n"
    case, axes = Case.from_text(text), [Axis.parsed("restitution=0.3,0.6")]
    job = sweep_job_of(case, axes, ["margin", "impact_velocity", "label"])
    found = job.compute(0, 2, NEVER)
    orbits, verdicts, at = best(case.system(), modes=None)
    assert found["margin"][0] == verdicts[at].margin and verdicts[at].multipliers.modes == 32
    assert found["impact_velocity"][0] == orbits[at].impact_velocity
    assert label_text(found)[0] == run(case.system(), case.start(2), modes=2, stop=Stop(impacts=100)).label
    assert (job.ask["modes"], job.ask["simulated"]) == (32, 2)


def test_full_restitution_without_damping_has_the_motions_of_a_single_answer():
    """Nothing takes what this load puts into the elastic modes: whatever else is asked, there is no motion."""
    system = System(20.0, 0.0, 1.0, Load.fourier([0.3, 1.0, 0.5j]))
    answer = steady_states(system)
    assert not answer.orbits and "without bound" in answer.note
    for names in (["orbits", "exists", "phase", "margin"], ["orbits", "exists", "phase", "margin", "reason"]):
        found = sweep(system, "restitution=0.9,1", "load_factor=0.1,0.3", quantities=names, modes=8, workers=1)
        assert found["orbits"].tolist() == [[2, 2], [0, 0]] and not found["exists"][1].any(), names
        assert np.isnan(found["phase"][1]).all() and np.isnan(found["margin"][1]).all()
    rigid = sweep(System(1e7, 0.0, 1.0, Load.harmonic(0.3, 1.0)), "load_factor=0.3", quantities=["orbits"], workers=1)
    assert rigid["orbits"][0] == len(steady_states(System(1e7, 0.0, 1.0, Load.harmonic(0.3, 1.0))).orbits)


def test_scales_go_with_the_case():
    case = load_case("mini-breaker")
    family = CaseFamily(case, {"frequency": "Hz"})
    found = sweep(family, "frequency=10 Hz:30 Hz:3", quantities=["blow_energy", "impact_velocity", "power"], workers=1)
    for i, frequency in enumerate((10.0, 20.0, 30.0)):
        orbits, _, at = best(case.varied({"load.frequency": f"{frequency} Hz"}).system(), modes=None)
        system = orbits[at].system
        assert found["blow_energy"][i] == pytest.approx(orbits[at].blow_energy * system.energy_scale, rel=1e-13)
        assert found["impact_velocity"][i] == pytest.approx(orbits[at].impact_velocity * system.speed_scale, rel=1e-13)
        assert found["power"][i] == pytest.approx(found["blow_energy"][i] * frequency, rel=1e-12)
    data = found.to_xarray()
    assert data.frequency.attrs["units"] == "Hz" and data.blow_energy.attrs["units"] == "J"


def test_what_a_blow_comes_to():
    """As the SI report of the same motion has it, and without units for a dimensionless case."""
    case = load_case("mini-breaker")
    names = ["stroke", "stress", "delivered", "efficiency", "impact_velocity"]
    found = sweep(CaseFamily(case, {}), "restitution=0.02,0.1", quantities=names, workers=1)
    orbits, _, at = best(case.system().with_restitution(0.1), modes=None)
    report = si_report(orbits[at])
    assert found["stroke"][1] == pytest.approx(1e-3 * report.stroke_mm, rel=1e-12)
    assert found["stress"][1] == pytest.approx(1e6 * report.peak_stress_MPa, rel=1e-12)
    assert found["delivered"][1] == pytest.approx(report.delivered_energy_J, rel=1e-12)
    assert found["efficiency"][1] == pytest.approx(report.efficiency, rel=1e-12)
    assert [found.columns[name].unit for name in names] == ["m", "Pa", "J", "", "m/s"]
    plain = sweep(case.system().with_restitution(0.1), "restitution=0.1", quantities=names, workers=1)
    assert plain["efficiency"][0] == pytest.approx(report.efficiency, rel=1e-12)
    young = case.system().bar.youngs_modulus
    dimensionless = System(PNEUMATIC.s, 0.0, 0.6, PNEUMATIC.load)
    one = sweep(dimensionless, "restitution=0.6", quantities=names, workers=1)
    assert one["stress"][0] == pytest.approx(0.5 * 1.6 * one["impact_velocity"][0] / 20.0, rel=1e-14)
    assert report.peak_stress_MPa * 1e6 / young < 0.01


def test_nothing_put_in_has_no_efficiency():
    lossless = System(1e7, 0.0, 1.0, Load.harmonic(0.3, 1.0))
    found = sweep(lossless, "load_factor=0.3", quantities=["efficiency", "delivered"], modes=0, workers=1)
    assert np.isnan(found["efficiency"][0]) and found["delivered"][0] == 0.0


def test_ranges_along_an_axis_end_at_the_boundaries():
    """B77's pneumatic hammer at R = 0.5: the flip and the fold in closed form (theory §6); a gap in another's range."""
    rigid = System(s=1e7, d=0.0, restitution=0.5, load=Load.harmonic(0.9, 1.0))
    job = sweep_job(rigid, "load_factor=0.1:1.2:12", quantities=["reduced_stable", "exists", "margin"])
    found = Sweep.shaped(job, job.compute(0, job.size, NEVER))
    (part,) = true_ranges(job, found, "reduced_stable")
    flip = 2.25 / np.sqrt(4.0 * 1.25**2 + (0.75 * np.pi) ** 2)
    assert part.opens and part.closes
    assert (part.first, part.last) == pytest.approx((flip, 3.0 / np.pi), abs=3e-9)
    (part,) = true_ranges(job, found, "exists")
    assert part.first == 0.1 and not part.opens and part.last == pytest.approx(3.0 / np.pi, abs=3e-9)
    with pytest.raises(ParameterError, match="yes or no"):
        true_ranges(job, found, "margin")
    plane = sweep_job(rigid, "load_factor=0.1:1.2:3", "restitution=0.1,0.5", quantities=["exists"])
    with pytest.raises(ParameterError, match="one axis"):
        true_ranges(plane, Sweep.shaped(plane, plane.compute(0, plane.size, NEVER)), "exists")


def test_a_recording_keeps_its_waveform():
    case = load_case("hydraulic-drifter")
    family = CaseFamily(case, {"frequency": "Hz", "length": "mm"})
    other = family.system({"frequency": 40.0, "load.scale": 1.1})
    assert other.frequency == 40.0
    ratio = other.load.coefficients / case.system().load.coefficients
    np.testing.assert_allclose(ratio, 1.1 * (case.system().frequency / 40.0) ** 2, rtol=1e-12)
    assert family.system({"length": 300.0}).bar.length == pytest.approx(0.3)


def test_failures_are_values():
    resonant = 1.0 / np.pi
    axis = Axis("s", np.array([resonant, 1.0]))
    found = sweep(PNEUMATIC, axis, quantities=["exists", "label", "margin"], modes=4, workers=1)
    words = found.words["outcome"]
    assert [words[code] for code in found["outcome"]] == ["resonance", "ok"]
    assert found["label"][0] == "" and found["label"][1] != ""
    found = sweep(SQUARE, "kappa=0.5,1.3,2.5", quantities=["exists", "margin"], modes=4, workers=1)
    assert [words[code] for code in found["outcome"]] == ["does not push", "ok", "no system"]
    assert found["exists"].tolist() == [False, True, False] and np.isnan(found["margin"][[0, 2]]).all()


def test_lyapunov_exponents_of_what_the_simulation_finds():
    system = System(s=1e4, d=0.0, restitution=0.8, load=Load.harmonic(0.9, 1.0))
    start = Start.rigid(0.0, -4.0, 2.3)
    found = sweep(system, "load_factor=0.79,0.95", "restitution=0.7,0.8", quantities=["lyapunov", "label"], modes=0,
                  start=start, workers=1)  # fmt: skip
    # at 0.79 and 0.8 it rests after 21 periods, or after 18 or 13 as R moves by 1e-15
    assert found["label"].tolist() == [["z=1/2", "chatter/?"], ["z=1/1", "chatter/1"]]
    one = best(System(s=1e4, d=0.0, restitution=0.7, load=Load.harmonic(0.95, 1.0)), modes=0)
    largest = one[1][one[2]].multipliers.largest
    assert found["lyapunov"][1, 0] == pytest.approx(np.log(largest), rel=1e-4)
    assert found["lyapunov"][0, 1] == -np.inf and found["lyapunov"][1, 1] == -np.inf


def flight_time(system):
    """2π over the speed scale, for one."""
    return 2.0 * np.pi / system.load.mean


def test_functions_of_ones_own():
    axes = ("restitution=0.2,0.6", "mean=0,0.5,1")
    found = sweep(PNEUMATIC, *axes, quantities=["exists"], functions={"flight": flight_time}, workers=1)
    assert found["flight"][:, 1:].tolist() == [[4.0 * np.pi, 2.0 * np.pi]] * 2
    assert np.isnan(found["flight"][:, 0]).all()
    assert found.to_xarray()["flight"].attrs["long_name"].endswith("test_sweep.flight_time")
    alone = sweep(PNEUMATIC, *axes, quantities=[], functions={"flight": flight_time}, workers=2, chunk=2)
    assert np.array_equal(alone["flight"], found["flight"], equal_nan=True)
    for name, function in (("exists", flight_time), ("two words", flight_time), ("flight", 3.0)):
        with pytest.raises(ParameterError):
            sweep(PNEUMATIC, *axes, functions={name: function}, workers=1)


# -- the question -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("restitution", "restitution=0:0.9:200"),
        ("restitution=", "NAME="),
        ("restitution=0:0.9", "FROM:TO:NUMBER"),
        ("restitution=0.9:0:10", "swap the two ends"),
        ("restitution=0.5:0.5:10", "two different ends"),
        ("restitution=0:0.9:0", "1"),
        ("restitution=0:0.9:many", "FROM:TO:NUMBER"),
        ("s=0:10:5:log", "greater than 0"),
        ("s=1:10:5:lin", "FROM:TO:NUMBER"),
        ("s=1,1", "each once"),
        ("s=nan:1:3", "a number"),
        ("frequency=20 Hz:80 kHz:3", "one unit"),
        ("s=1:2:100000000000", "10000000"),
    ],
)
def test_axes_that_are_none(text, says):
    with pytest.raises(ParameterError) as refused:
        Axis.parsed(text)
    assert says in str(refused.value)


def test_axes():
    np.testing.assert_allclose(Axis.parsed("s=0.4:100:3:log").values, [0.4, np.sqrt(40.0), 100.0])
    assert Axis.parsed("m=1,2,3").values.tolist() == [1.0, 2.0, 3.0]
    assert Axis.parsed(" length = 0.2 m : 0.4 : 3 ").unit == "m"


@pytest.mark.parametrize(
    ("what", "axes", "quantities", "says"),
    [
        (PNEUMATIC, ["friction=0:1:3"], ["exists"], "restitution, load_factor, kappa"),
        (PNEUMATIC, ["restitution=0:1:3"], ["stability"], "one of exists, orbits"),
        (PNEUMATIC, ["restitution=0:1:3"], [], "one or more"),
        (PNEUMATIC, [], ["exists"], "one or more axes"),
        (PNEUMATIC, ["s=1:2:3", "s=1:2:3"], ["exists"], "one axis only"),
        (PNEUMATIC, ["kappa=1.1:1.9:3"], ["exists"], "a square load"),
        (PNEUMATIC, ["s=1 m:2 m:3"], ["exists"], "dimensionless"),
        (PNEUMATIC, ["m=0.5,1"], ["exists"], "whole numbers"),
        (PNEUMATIC, ["m=0,1"], ["exists"], "whole numbers"),
        (PNEUMATIC, ["restitution=1.5,2"], ["rest"], "0 to 1"),
        (System(s=1.0, d=0.1, restitution=0.5, load=Load.fourier([1.0])), ["load_factor=1,2"], ["rest"], "alternating"),
    ],
)
def test_questions_that_have_no_answer(what, axes, quantities, says):
    with pytest.raises(ParameterError) as refused:
        sweep(what, *axes, quantities=quantities, workers=1)
    assert says in str(refused.value)


def test_keys_of_a_case():
    case = load_case("mini-breaker")
    with pytest.raises(ParameterError, match=r"did you mean 'length'"):
        sweep(CaseFamily(case, {"lenght": "m"}), "lenght=0.2 m:0.4 m:3", quantities=["exists"], workers=1)
    with pytest.raises((CaseError, UnitError), match=r"bar\.length"):
        sweep(CaseFamily(case, {"length": "kg"}), "length=1 kg:2 kg:3", quantities=["exists"], workers=1)
    plain = Case.from_text(
        "[system]\ns = 20.0\nd = 0.0\nrestitution = 0.6\n[load]\nkind = 'harmonic'\nmean = 0.9\namplitude = 1.0\n"
    )
    family = CaseFamily(plain, {})
    assert family.system({"s": 3.0, "load.mean": 0.5}).load.mean == 0.5
    assert family.system({"load_factor": 0.7}).load.mean == 0.7
    assert SystemFamily(PNEUMATIC).system({"amplitude": 2.0}).load.load_factor == 0.45


# -- what a review found ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("units", "axes"),
    [
        ({"frequency": "Hz", "load.frequency": "Hz"}, ["frequency=15 Hz,20 Hz", "load.frequency=15 Hz,20 Hz"]),
        ({"receiving_area": "cm^2"}, ["restitution=0.08,0.1", "receiving_area=19 cm^2,20 cm^2"]),
        ({"diameter": "mm", "bar.area": "cm^2"}, ["diameter=40 mm,45 mm", "bar.area=15 cm^2,16 cm^2"]),
        ({}, ["mean=0.1,0.2", "load_factor=0.3,0.4"]),
        ({}, ["contact.restitution=0.1,0.2", "restitution=0.1,0.2"]),
    ],
)
def test_two_axes_that_set_the_same(units, axes):
    with pytest.raises(ParameterError, match="sets the same"):
        sweep(CaseFamily(load_case("mini-breaker"), units), *axes, quantities=["exists"], workers=1)
    if not units and "mean" in axes[0]:
        with pytest.raises(ParameterError, match="sets the same"):
            sweep(PNEUMATIC, *axes, quantities=["exists"], workers=1)


@pytest.mark.parametrize("machine", ["mini-breaker", "hydraulic-drifter"])
def test_starts_in_the_scales_of_each_cell(machine):
    case = load_case(machine).changed(start={"position": "-30 mm", "velocity": "2 m/s"})
    family = CaseFamily(case, {"frequency": "Hz"})
    for frequency in (30.0, 60.0, 90.0):
        values = {"frequency": frequency}
        start, system = family.start(values, 0), family.system(values)
        assert start.velocity[0] * system.speed_scale == pytest.approx(2.0, rel=1e-12)
        assert start.displacement[0] * system.length_scale == pytest.approx(-0.03, rel=1e-12)


def test_a_recording_of_the_catalogue_under_another_area():
    case = load_case("hydraulic-drifter")
    found = sweep(
        CaseFamily(case, {"load.area": "cm^2"}), "load.area=5 cm^2:6.5 cm^2:4", quantities=["orbits"], workers=1
    )
    assert (found["outcome"] == 0).all()
    family = CaseFamily(case, {"load.area": "cm^2"})
    other, given = family.system({"load.area": 5.0}).load.mean, case.system().load.mean
    assert other == pytest.approx(given * 5.0 / 6.5, rel=1e-12)


def test_a_start_that_does_not_exist_spares_the_steady_quantities():
    case = load_case("mini-breaker").changed(start={"orbit": 1}, simulation={"modes": 0, "impacts": 50})
    found = sweep(CaseFamily(case, {}), "restitution=0.02,0.1", "load_factor=0.3,0.9", quantities=["orbits", "label"],
                  modes=0, workers=1)  # fmt: skip
    words = [[found.words["outcome"][code] for code in row] for row in found["outcome"]]
    for i, j in np.argwhere(found["orbits"] == 0):
        assert words[i][j] == "no start" and found["label"][i, j] == ""
    assert (found["orbits"] >= 0).all() and "no start" in np.array(words) and "ok" in np.array(words)


def test_some_cells_without_a_system_are_no_reason_to_refuse():
    found = sweep(SQUARE, "kappa=0:2:5", quantities=["orbits"], workers=1)
    assert found.words["outcome"][found["outcome"][0]] == "no system"
    assert (found["outcome"][1:4] <= 1).all()


@pytest.mark.parametrize(
    ("key", "unit", "values"),
    [("bar.damping_ratio", "", [0.0, 1.0, 2.0]), ("bar.sections[0].length", "mm", [-50.0, 50.0, 150.0])],
)
def test_a_key_that_makes_no_case_makes_no_system(key, unit, values):
    family = CaseFamily(load_case("stepped-drifter"), {key: unit} if unit else {})
    found = sweep(family, Axis(key, values, unit), quantities=["exists"], workers=1)
    words = [found.words["outcome"][code] for code in found["outcome"]]
    assert sorted(words) == ["no system", "ok", "ok"] and words[1] == "ok"


def test_whole_numbers_of_harmonics():
    text = "[system]\ns = 20.0\nd = 0.0\nrestitution = 0.6\n[load]\nkind = 'square'\namplitude = 1.0\nkappa = 1.3\n"
    family = CaseFamily(Case.from_text(text), {})
    assert family.system({"load.harmonics": 4.0}).load.coefficients.size == 5
    found = sweep(family, "load.harmonics=1:4:3", quantities=["exists"], workers=1)
    assert [found.words["outcome"][code] for code in found["outcome"]] == ["ok", "no system", "ok"]


def test_neutral_is_not_stable_whatever_else_is_asked():
    system = System(s=1.517, d=0.0, restitution=0.6, load=Load.square(1.0, 1.3))
    axes = ("restitution=1", "load_factor=1.2", "m=1,3")
    plane = sweep(system, *axes, quantities=["reduced_stable"], workers=1)
    single = sweep(system, *axes, quantities=["reduced_stable", "admissible"], workers=1)
    assert np.array_equal(plane["reduced_stable"], single["reduced_stable"])


def test_curves_of_stability_separate_stable_from_unstable():
    """Undamped and elastic, where a pair of multipliers leaves the circle before the flip."""
    axes = ("restitution=0.45:0.95:11", "load_factor=0.3:1.2:19")
    found = sweep(PNEUMATIC, *axes, quantities=["stable"], modes=4, workers=1)
    x = Axis.parsed(axes[0])
    curves = boundaries(PNEUMATIC, x, ("load_factor", 0.2, 1.3), criterion="exact", modes=4,
                        kinds=("fold", "flip", "neimark-sacker"))  # fmt: skip
    y = np.array([curve.y for curve in curves.of_stability])
    values = Axis.parsed(axes[1]).values
    changes = 0
    for i in range(len(x)):
        for j in np.flatnonzero(found["stable"][i, 1:] != found["stable"][i, :-1]):
            changes += 1
            assert np.any((y[:, i] >= values[j]) & (y[:, i] <= values[j + 1])), (x.values[i], values[j])
    assert changes > 8
    assert any(curve.kind == "neimark-sacker" for curve in curves.of_stability)


def test_a_case_of_coefficients():
    text = "[system]\ns = 20.0\nd = 0.0\nrestitution = 0.6\n"
    text += "[load]\nkind = 'fourier'\ncoefficients = [[0.9, 0.0], [1.0, 0.0]]\n"
    case = Case.from_text(text)
    assert case.varied({"system.s": 3.0}).system().s == 3.0
    found = sweep(CaseFamily(case, {}), "system.s=3,20", quantities=["phase"], workers=1)
    direct = sweep(PNEUMATIC, "s=3,20", quantities=["phase"], workers=1)
    assert np.array_equal(found["phase"], direct["phase"])


# -- machines that switch their own valves -----------------------------------------------------------------------------


ALL = [name for name, quantity in MACHINE_QUANTITIES.items() if quantity.group == "machine"]
PORTS = [Port("power", behind=1.0, side="back", delay=0.05), Port("return", on="impact")]
VALVE = Valve({"return": -0.4, "power": 1.8}, PORTS, chamber=Chamber(0.05, 0.1))
MACHINE = Machine(UniformBar(20.0, External(0.01)), VALVE, Reversed(0.2))


def swept(what, *axes, quantities=ALL, modes=0):
    job = sweep_job(what, *axes, quantities=quantities, modes=modes)
    return Sweep.shaped(job, job.compute(0, job.size, NEVER))


def mapped(case, *axes, quantities=None, modes=0):
    job = sweep_job_of(case, [Axis.parsed(axis) for axis in axes], quantities, modes=modes)
    return Sweep.shaped(job, job.compute(0, job.size, NEVER))


@pytest.mark.parametrize("modes", [0, 3])
def test_a_cell_is_the_motion_of_its_machine(modes):
    found = swept(MACHINE, "pressure=0.1,0.8,1.3", "ports[0].behind=0.4,1.1", modes=modes)
    for i, pressure in enumerate((0.1, 0.8, 1.3)):
        for j, behind in enumerate((0.4, 1.1)):
            machine = vary(MACHINE, {"pressure": pressure, "ports[0].behind": behind})
            motion = self_excited_motion(machine, modes=modes)
            here = {name: found[name][i, j] for name in ALL}
            assert STALLS[here["stall"]] == ("runs" if motion.runs else motion.obstacle.value)
            assert here["runs"] == motion.runs and here["starts"] == motion.starts_from_rest
            if motion.runs:
                cycle = motion.cycle
                wanted = {
                    "blow_energy": cycle.main_energy,
                    "rate": 1.0 / cycle.period,
                    "speed": cycle.blow_speed,
                    "stroke": cycle.stroke,
                    "power": cycle.taken / cycle.period,
                    "flow": cycle.swept_length / cycle.period,
                    "efficiency": cycle.taken / cycle.work,
                    "duty": cycle.duty,
                    "multiplier": abs(cycle.multiplier),
                }
                for name, value in wanted.items():
                    assert here[name] == pytest.approx(value, rel=1e-11), name
            else:
                assert np.isnan([here[name] for name in ("blow_energy", "rate", "flow", "duty")]).all()
    assert not found["outcome"].any()
    assert {"runs", "stays on the wall"} <= {STALLS[number] for number in found["stall"].ravel()}


def test_a_machine_in_si_has_the_figures_of_its_report():
    case = load_case("valve-breaker")
    figures = machine_answer(case, 0).to_json_dict()["si"]
    found = mapped(case, "pressure=80 bar,160 bar", quantities=ALL)
    assert found.words["stall"][found["stall"][0]] == "stays on the wall"
    for name, key, scale in (
        ("blow_energy", "blow_energy_J", 1.0),
        ("rate", "blow_rate_Hz", 1.0),
        ("stroke", "stroke_m", 1.0),
        ("speed", "impact_velocity_m_s", 1.0),
        ("power", "delivered_power_kW", 1e3),
        ("flow", "oil_flow_l_per_min", 1.0 / 6e4),
        ("efficiency", "efficiency", 1.0),
    ):
        assert found[name][1] == pytest.approx(scale * figures[key], rel=1e-9)
    assert found["blow_energy"][1] == pytest.approx(3751.0, abs=0.5)
    assert found["flow"][1] == pytest.approx(132.0 / 6e4, rel=2e-3)
    assert (found.columns["flow"].unit, found.columns["stroke"].unit) == ("m³/s", "m")


SIZES = """
[bar]
length = "1 m"
diameter = "120 mm"
[contact]
restitution = 0.15
[load]
kind = "valve"
states = {return = "-13.12 kN", power = "12.48 kN"}
chamber = {force = "9 kN", stiffness = "20 kN/m"}
ports = [{behind = "130 mm", side = "back", to = "power", delay = "5 ms"},
         {behind = "4 mm", side = "front", to = "return", delay = "0.5 ms"}]
room = "250 mm"
"""


@pytest.mark.parametrize(
    ("axis", "key", "text"),
    [
        ("ports[0].behind=100 mm,140 mm", "load.ports[0].behind", "140 mm"),
        ("ports[1].delay=0.1 ms,0.9 ms", "load.ports[1].delay", "0.9 ms"),
        ("states.power=11 kN,12 kN", "load.states.power", "12 kN"),
        ("chamber.force=8 kN,10 kN", "load.chamber.force", "10 kN"),
        ("chamber.stiffness=10 N/mm,25 N/mm", "load.chamber.stiffness", "25 N/mm"),
        ("bar.length=0.9 m,1.1 m", "bar.length", "1.1 m"),
        ("restitution=0.1,0.3", "contact.restitution", 0.3),
        ("bar.drag=0 N s/m^2,30 N s/m^2", "bar.drag", "30 N s/m^2"),
    ],
)
def test_a_key_of_the_case_is_that_of_another_file(axis, key, text):
    case = Case.from_text(SIZES)
    found = mapped(case, axis, quantities=["stall", "blow_energy", "rate", "stroke", "speed"])
    other = case.varied({key: text})
    motion = self_excited_motion(other.machine(), modes=0, room=other.room())
    assert motion.runs and not found["stall"].any()
    machine = other.machine()
    assert found["blow_energy"][1] == pytest.approx(motion.cycle.main_energy * machine.energy_scale, rel=1e-10)
    assert found["rate"][1] == pytest.approx(1.0 / motion.cycle.period, rel=1e-10)
    assert found["stroke"][1] == pytest.approx(motion.cycle.stroke * machine.length_scale, rel=1e-10)


def test_the_pressure_is_that_of_all_forces_but_the_gas():
    case = load_case("valve-breaker")
    family = CaseFamily(case, {"pressure": "bar"})
    machine = family.machine({"pressure": 200.0})
    assert machine.pressure == pytest.approx(200e5, rel=1e-15)
    for (name, force), (_, before) in zip(machine.valve.pairs, case.machine().valve.pairs, strict=True):
        assert force == pytest.approx(1.25 * before, rel=1e-15), name
    assert machine.valve.chamber == case.machine().valve.chamber
    assert CaseFamily(case, {}).machine({"load.scale": 1.25}).valve == machine.valve
    area = CaseFamily(case, {"states.power.rear": "cm^2"}).machine({"states.power.rear": 20.0})
    assert area.valve.force("power") * area.force_scale == pytest.approx(160e5 * 11.8e-4 + 9e3, rel=1e-12)


def test_the_room_is_that_of_the_case_in_every_cell():
    found = mapped(Case.from_text(SIZES), "ports[0].behind=130 mm,230 mm", "bar.length=1 m,2 m")
    assert [[STALLS[i] for i in row] for row in found["stall"]][1][0] == "no room"
    assert STALLS[found["stall"][0, 0]] == "runs"
    assert SystemFamily(MACHINE, 0.5).room(MACHINE) == 0.5


def test_where_a_machine_runs_along_a_parameter():
    """Undamped, without delay: from rest 2 a_r S > κ S², so it starts with κ < 2 a_r/S; it runs while w' stays > 0."""
    ports = [Port("power", behind=1.0, side="back"), Port("return", on="impact")]
    machine = Machine(UniformBar(20.0), Valve({"return": -0.3, "power": 1.0}, ports), Kept(0.5))
    job = sweep_job(machine, "chamber.stiffness=0:2:9", quantities=["runs", "starts"], modes=0)
    found = Sweep.shaped(job, job.compute(0, job.size, NEVER))
    (runs,), (starts,) = true_ranges(job, found, "runs"), true_ranges(job, found, "starts")
    assert starts.last == pytest.approx(0.6, abs=1e-8)
    # R² w + 2 a_r S = κ S² with w = 2 (a_r + a_p) S/(1 − R²)
    assert runs.last == pytest.approx(0.6 + 0.25 * 2.0 * 1.3 / 0.75, abs=1e-8)


def test_a_cell_without_a_machine_says_so():
    found = swept(MACHINE, "ports[0].behind=-1,1", "restitution=0.5,1.5")
    words = [[found.words["outcome"][i] for i in row] for row in found["outcome"]]
    assert words == [["no system", "no system"], ["ok", "no system"]]
    assert found["stall"][0, 0] == -1 and found["blow_energy"][1, 0] > 0.0


def double_speed(machine):
    return 2.0 * machine.body.s


def test_functions_of_machines_are_quantities_of_their_own():
    found = sweep(MACHINE, "s=5,10", functions={"twice": double_speed}, modes=0, workers=1)
    assert found["twice"].tolist() == [10.0, 20.0] and found.quantities[0] == "stall"
    assert found.to_xarray()["stall"].attrs["words"].startswith("runs, ") and found.words["stall"] == STALLS


def test_what_machines_do_not_have_is_refused():
    case = load_case("valve-breaker")
    with pytest.raises(ParameterError, match="one of stall, runs, starts"):
        mapped(case, "pressure=120:200 bar:3", quantities=["exists"])
    with pytest.raises(ParameterError, match="a load that keeps time"):
        mapped(case, "m=1,2")
    with pytest.raises(ParameterError, match="ports"):
        sweep(MACHINE, "ports[5].behind=0.1,0.2")
    with pytest.raises(UnitError, match="a pressure with its unit"):
        mapped(case, "pressure=120:200:3")
    with pytest.raises(ParameterError, match="sets the same"):
        mapped(case, "pressure=120:200 bar:3", "load.scale=1,2")
    with pytest.raises(ParameterError, match="sets the same"):
        mapped(Case.from_text(SIZES), "pressure=0.9:1.1:3", "load.scale=1,2")
    with pytest.raises(ParameterError, match="needs no pressure"):
        mapped(Case.from_text(SIZES), "ports[0].behind=100 mm,120 mm", quantities=["flow"])
    with pytest.raises(ParameterError, match="keeps time by itself"):
        SystemFamily(MACHINE).system({})
    with pytest.raises(CaseError, match="keeps time by itself"):
        CaseFamily(case, {}).system({})
    with pytest.raises(ParameterError, match="expected"):
        vary(MACHINE, {"pressure": 0.0})


def test_the_job_of_a_small_map_is_small():
    job = sweep_job(MACHINE, "pressure=0.5:1.5:6", modes=0)
    assert 0.0 < job.rough_seconds < 0.01
    assert carry_out(job, workers=1)["stall"].shape == (6,)


# -- one blow by waves -------------------------------------------------------------------------------------------------


BLOW = [name for name, quantity in QUANTITIES.items() if quantity.group == "blow"]
MATCHED = """
[bar]
length = "300 mm"
area = "11 cm^2"
[tool]
sections = [{length = "1.5 m", area = "11 cm^2"}]
[rock]
stiffness = "500 kN/mm"
unloading_ratio = 0.3
[blow]
velocity = "10 m/s"
until = "0.7 ms"
"""


def blow_map(case, *axes, quantities=BLOW):
    job = sweep_job_of(case, [Axis.parsed(axis) for axis in axes], quantities)
    return Sweep.shaped(job, job.compute(0, job.size, NEVER))


@pytest.mark.parametrize(
    ("axis", "key", "text"),
    [
        ("tool.sections[0].length=0.8 m,1.1 m", "tool.sections[0].length", "1.1 m"),
        ("bar.diameter=20 mm,24 mm", "bar.diameter", "24 mm"),
        ("rock.stiffness=100 kN/mm,300 kN/mm", "rock.stiffness", "300 kN/mm"),
        ("rock.unloading_ratio=0.2,0.7", "rock.unloading_ratio", 0.7),
        ("blow.velocity=10 m/s,12 m/s", "blow.velocity", "12 m/s"),
        ("tool.bit_mass=0.1 kg,2 kg", "tool.bit_mass", "2 kg"),
    ],
)
def test_a_cell_is_the_answer_for_its_case(axis, key, text):
    case = load_case("laboratory-striker")
    found = blow_map(case, axis)
    blow = blow_answer(case.varied({key: text} | ({"bar.area": None} if key == "bar.diameter" else {}))).blow
    assert not found["outcome"].any()
    assert found["effective_restitution"][1] == blow.effective_restitution
    assert found["rock_energy"][1] == blow.rock_work
    assert found["rock_efficiency"][1] == blow.efficiency
    assert found["contact_duration"][1] == blow.contact_duration
    assert found["peak_stress"][1] == max(max(peak.compression, peak.tension) for peak in blow.peaks)
    assert found["incident_energy"][1] == blow.first_pulse.energy
    assert found["ringing"][1] == blow.vibration_energy_after / blow.energy_before
    assert found.columns["peak_stress"].unit == "Pa" and found.columns["rock_energy"].unit == "J"


def test_a_case_of_one_blow_alone_has_lundbergs_curve():
    """The first wave of a matched hammer: 2 (1 − γ)(1 − e^−β)²/β of its energy, β = 2 K L/(AE) (Lundberg 1973)."""
    case = Case.from_text(MATCHED)
    found = blow_map(case, "rock.stiffness=600 kN/mm:2000 kN/mm:9", quantities=["rock_efficiency", "incident_energy"])
    bar = case.blow_question().striker
    stiffness = np.linspace(6e8, 2e9, 9)
    betas = 2.0 * stiffness * bar.length / (11e-4 * bar.youngs_modulus)
    wanted = [matched_efficiency(beta, 0.3) for beta in betas]
    # the window ends with the rock unloaded, before the reflected wave has come back to it
    np.testing.assert_allclose(found["rock_efficiency"], wanted, rtol=1e-6)
    energy = 0.5 * bar.mass * 10.0**2
    np.testing.assert_allclose(found["incident_energy"], energy, rtol=1e-12)


@pytest.mark.parametrize(
    ("machine", "axis", "speed"),
    [
        ("valve-drifter", "load.pressure=120 bar,160 bar,200 bar", "speed"),
        ("valve-drifter", "bar.density=7000 kg/m^3,7850 kg/m^3", "speed"),
        ("mini-breaker", "load.frequency=17 Hz,18 Hz", "impact_velocity"),
    ],
)
def test_a_blow_has_the_speed_of_its_own_cell(machine, axis, speed):
    """Waves are linear in the speed: the energy of the first wave is that of a unit speed times its square."""
    case = load_case(machine)
    name = axis.partition("=")[0]
    job = sweep_job_of(case, [Axis.parsed(axis)], [speed, "incident_energy", "rock_energy"], modes=0)
    found = Sweep.shaped(job, job.compute(0, job.size, NEVER))
    texts = axis.partition("=")[2].split(",")
    assert not found["outcome"].any() and np.ptp(found[speed]) > 0.02 * found[speed].max()
    for text, own, incident, rock in zip(
        texts, found[speed], found["incident_energy"], found["rock_energy"], strict=True
    ):
        one = blow_answer(case.varied({name: text}), float(own)).blow
        assert (one.first_pulse.energy, one.rock_work) == pytest.approx((incident, rock), rel=1e-9)


def test_a_blow_of_a_cell_that_does_not_run_is_refused():
    axis = Axis.parsed("load.ports[1].delay=20 ms,0.5 ms")
    job = sweep_job_of(load_case("valve-drifter"), [axis], ["rock_energy", "runs"])
    found = Sweep.shaped(job, job.compute(0, job.size, NEVER))
    assert found["runs"].tolist() == [False, True] and np.isfinite(found["rock_energy"]).tolist() == [False, True]


def test_blow_and_motion_stand_beside_each_other():
    found = blow_map(load_case("hydraulic-drifter"), "bar.length=300 mm,340 mm", quantities=["exists", "peak_stress"])
    assert found["exists"].all() and (found["peak_stress"] > 0.0).all()


def test_a_wall_has_no_wave_and_no_rock():
    text = "[system]\ns = 20.0\nd = 0.0\nrestitution = 0.6\n[tool]\nkind = 'wall'\n[blow]\nvelocity = 1.0\n"
    case = Case.from_text(text + "[load]\nkind = 'harmonic'\nmean = 0.9\namplitude = 1.0\n")
    found = blow_map(case, "blow.velocity=1,2")
    for name in ("rock_energy", "rock_efficiency", "incident_energy"):
        assert np.isnan(found[name]).all()
    assert found["effective_restitution"] == pytest.approx([1.0, 1.0], abs=1e-12)
    assert found["contact_duration"] == pytest.approx([0.1, 0.1], rel=1e-12)
    assert found["peak_stress"] == pytest.approx([20.0, 40.0], rel=1e-12)
    assert found.columns["peak_stress"].unit == ""


def test_a_cell_without_a_hammer_says_so():
    found = blow_map(load_case("laboratory-striker"), "tool.sections[0].length=-1 m,1 m", quantities=["rock_energy"])
    assert found.words["outcome"][found["outcome"][0]] == "no system"
    assert np.isnan(found["rock_energy"][0]) and found["rock_energy"][1] > 0.0


def test_questions_that_no_blow_answers():
    system = System(s=20.0, d=0.0, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    with pytest.raises(ParameterError, match="only a case says what is struck"):
        sweep(system, "restitution=0.2,0.6", quantities=["peak_stress"])
    case = load_case("laboratory-striker")
    with pytest.raises(ParameterError, match="a blow has no load periods"):
        blow_map(case, "m=1,2", quantities=["peak_stress"])
    for axis in ("load_factor=0.5,0.6", "load.scale=1,2"):
        with pytest.raises(ParameterError, match=r"for a blow, a key of the case"):
            blow_map(case, axis, quantities=["peak_stress"])
