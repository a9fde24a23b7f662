"""Maps of machines that switch their own valves: each cell against the motion of its machine, refusals, the archive."""

import numpy as np
import pytest

from percuss.case import Case, CaseFamily, load_case, machine_answer, sweep_job_of
from percuss.errors import CaseError, ParameterError, UnitError
from percuss.explore import MACHINE_QUANTITIES, STALLS, Axis, Sweep, SystemFamily, carry_out, sweep, vary
from percuss.explore.sweeps import sweep_job, true_ranges
from percuss.model import Chamber, External, Kept, Machine, Port, Reversed, UniformBar, Valve
from percuss.steady import self_excited_motion

ALL = [name for name, quantity in MACHINE_QUANTITIES.items() if quantity.group == "machine"]
NEVER = lambda: False  # noqa: E731
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
