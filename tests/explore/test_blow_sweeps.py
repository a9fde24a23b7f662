"""Maps of one blow by waves: each cell against the answer for the same case, formulas, refusals, the archive."""

import numpy as np
import pytest

from percuss import Load, System
from percuss.blow.closed_forms import matched_efficiency
from percuss.case import Case, blow_answer, load_case, sweep_job_of
from percuss.errors import ParameterError
from percuss.explore import QUANTITIES, Axis, Sweep, sweep

BLOW = [name for name, quantity in QUANTITIES.items() if quantity.group == "blow"]
NEVER = lambda: False  # noqa: E731
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


def mapped(case, *axes, quantities=BLOW):
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
    found = mapped(case, axis)
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
    found = mapped(case, "rock.stiffness=600 kN/mm:2000 kN/mm:9", quantities=["rock_efficiency", "incident_energy"])
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
    found = mapped(load_case("hydraulic-drifter"), "bar.length=300 mm,340 mm", quantities=["exists", "peak_stress"])
    assert found["exists"].all() and (found["peak_stress"] > 0.0).all()


def test_a_wall_has_no_wave_and_no_rock():
    text = "[system]\ns = 20.0\nd = 0.0\nrestitution = 0.6\n[tool]\nkind = 'wall'\n[blow]\nvelocity = 1.0\n"
    case = Case.from_text(text + "[load]\nkind = 'harmonic'\nmean = 0.9\namplitude = 1.0\n")
    found = mapped(case, "blow.velocity=1,2")
    for name in ("rock_energy", "rock_efficiency", "incident_energy"):
        assert np.isnan(found[name]).all()
    assert found["effective_restitution"] == pytest.approx([1.0, 1.0], abs=1e-12)
    assert found["contact_duration"] == pytest.approx([0.1, 0.1], rel=1e-12)
    assert found["peak_stress"] == pytest.approx([20.0, 40.0], rel=1e-12)
    assert found.columns["peak_stress"].unit == ""


def test_a_cell_without_a_hammer_says_so():
    found = mapped(load_case("laboratory-striker"), "tool.sections[0].length=-1 m,1 m", quantities=["rock_energy"])
    assert found.words["outcome"][found["outcome"][0]] == "no system"
    assert np.isnan(found["rock_energy"][0]) and found["rock_energy"][1] > 0.0


def test_questions_that_no_blow_answers():
    system = System(s=20.0, d=0.0, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    with pytest.raises(ParameterError, match="only a case says what is struck"):
        sweep(system, "restitution=0.2,0.6", quantities=["peak_stress"])
    case = load_case("laboratory-striker")
    with pytest.raises(ParameterError, match="a blow has no load periods"):
        mapped(case, "m=1,2", quantities=["peak_stress"])
    for axis in ("load_factor=0.5,0.6", "load.scale=1,2"):
        with pytest.raises(ParameterError, match=r"for a blow, a key of the case"):
            mapped(case, axis, quantities=["peak_stress"])
