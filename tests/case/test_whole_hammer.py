"""The figures of a whole hammer are those of its answers, for every kind of hammer."""

import pytest

from percuss.blow import strike
from percuss.case import CaseFamily, load_case, machine_answer, steady_answer
from percuss.case.answers.whole_hammer import WHOLE_FIGURES, whole_figure
from percuss.errors import ParameterError, UnitError

PUMP = {"load.supply": {"flow": "133 l/min", "accumulator": "2.5 cm^3/bar"}}


@pytest.mark.parametrize(
    ("name", "values", "key", "unit", "value"),
    [
        ("stepped-drifter", {}, "load.frequency", "Hz", 61.0),
        ("valve-drifter", {}, "load.ports[0].behind", "mm", 25.0),
        ("valve-breaker", PUMP, "load.supply.flow", "l/min", 130.0),
    ],
)
@pytest.mark.parametrize("modes", [0, 6])
def test_the_figures_of_a_varied_hammer_are_those_of_its_own_answer(name, values, key, unit, value, modes):
    case = load_case(name).varied(values)
    found = CaseFamily(case, {key: unit}).whole({key: value}, modes=modes)
    varied = case.varied({key: f"{value!r} {unit}"})
    answer = machine_answer(varied, modes) if case.is_machine else steady_answer(varied, modes=modes)
    assert found.runs and answer.whole.runs
    for one in WHOLE_FIGURES:
        own, other = found.value(one), answer.whole.value(one)
        assert own == (other if other is None else pytest.approx(other, rel=1e-9)), one
    blow = strike(found.tool.striker, found.tool.target, found.value("rigid_velocity"), until=found.tool.until)
    sections = [found.value(f"{body}[{i}].stress") for body, i in (("piston", 0), ("steel", 0))]
    steel = len(found.transfer.sections[0])
    assert sections == [max(blow.peaks[i].compression, blow.peaks[i].tension) for i in (0, steel)]
    near = CaseFamily(case, {key: unit}).whole({key: value}, modes=modes, near=answer.whole)
    assert near.value("blow_energy") == pytest.approx(found.value("blow_energy"), rel=1e-9)


def test_figures_are_named_told_and_read_with_their_units():
    power = whole_figure("rock_power")
    assert power.tell(8063.0, True) == "8.063 kW" and power.tell(0.4, False) == "0.4"
    assert power.given("below", "8 kW", True) == 8000.0
    assert (
        whole_figure("flow").tell(0.002, True) == "120 l/min"
        and whole_figure("pressure").tell(1.8e7, True) == "180 bar"
    )
    assert whole_figure("steel[2].stress").label == "peak stress in section 2 of the steel"
    with pytest.raises(ParameterError, match=r"did you mean rock_power|rock_power"):
        whole_figure("rockpower")
    with pytest.raises(UnitError):
        power.given("below", "8 bar", True)
    with pytest.raises(ParameterError, match="sections, counted from 0"):
        CaseFamily(load_case("stepped-drifter"), {}).whole({}).value("steel[7].stress")
