"""Maps: every cell against the question asked of one system, by arrays, one by one, and in any portions."""

import numpy as np
import pytest

from percuss import Load, Start, Stop, System, rest_on_wall, run, si_report, stability_of, steady_states
from percuss.case import Case, CaseFamily, load_case, sweep_job_of
from percuss.errors import CaseError, ParameterError, UnitError
from percuss.explore import QUANTITIES, REASONS, Axis, Sweep, SystemFamily, boundaries, sweep
from percuss.explore.cells import fits_plane, label_text
from percuss.explore.sweeps import sweep_job, true_ranges

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
    names = [name for name, quantity in QUANTITIES.items() if quantity.group not in ("lyapunov", "blow")]
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
