"""Laws of damping, the law of the contact, the place of a load, loads of steps: keys, messages, and the way back."""

from __future__ import annotations

import json
import math
from typing import get_args

import pytest
from hypothesis import given
from hypothesis import strategies as st

from case_texts import STEPS, plain_case, refusal, si_case
from percuss import Start, Stop, run
from percuss.case import Case, steady_answer
from percuss.case.case import case_of, json_tables
from percuss.case.file_format.bodies import DampingTable, damping_law, damping_table
from percuss.case.file_format.values import Strain
from percuss.case.parameters.description import case_dict
from percuss.case.parameters.moves import placed
from percuss.errors import CaseError
from percuss.model import Bar, Damping, External, KelvinVoigt, Kept, Ratio, Reversed, System, Table
from percuss.model.body import DAMPINGS
from percuss.model.contact import LAWS

MASS_PER_LENGTH = 7850.0 * math.pi / 4.0 * 0.049**2
OMEGA = 2.0 * math.pi * 60.0


def system_of(text: str) -> System:
    return Case.from_text(text).system()


# -- damping --


@pytest.mark.parametrize(
    ("key", "law"),
    [
        ('damping = {kind = "ratio", value = 2e-3}', Ratio(2e-3)),
        ('damping = {kind = "ratio", value = 0}', Ratio(0.0)),
        ('damping = {kind = "kelvin_voigt", value = "10 ns"}', KelvinVoigt(1e-8 * OMEGA)),
        ('damping = {kind = "kelvin_voigt", value = 1e-8}', KelvinVoigt(1e-8 * OMEGA)),
        ('damping = {kind = "external", value = 3.0}', External(3.0 / OMEGA)),
        ('damping = {kind = "external", value = "40 N*s/m^2"}', External(40.0 / MASS_PER_LENGTH / OMEGA)),
        ('drag = "40 N*s/m^2"', External(40.0 / MASS_PER_LENGTH / OMEGA)),
        ('damping = {kind = "table", value = [1.0, 20]}', Table((1.0 / OMEGA, 20.0 / OMEGA))),
    ],
)
def test_a_law_of_damping_in_si(key: str, law: Damping) -> None:
    found = system_of(si_case(key)).body.damping
    assert type(found) is type(law)
    (own,), (wanted,) = vars(found).values(), vars(law).values()
    assert own == pytest.approx(wanted, rel=1e-14)


@pytest.mark.parametrize(
    ("keys", "law"),
    [
        ("d = 0.01", External(0.01)),
        ('damping = {kind = "ratio", value = 2e-3}', Ratio(2e-3)),
        ('d = 0\ndamping = {kind = "ratio", value = 2e-3}', Ratio(2e-3)),
        ('damping = {kind = "kelvin_voigt", value = 1e-6}', KelvinVoigt(1e-6)),
        ('damping = {kind = "external", value = 0.3}', External(0.3)),
        ('d = 0.3\ndamping = {kind = "external", value = 0.3}', External(0.3)),
        ('damping = {kind = "table", value = [0.1, 0]}', Table((0.1, 0.0))),
    ],
)
def test_a_law_of_damping_in_plain_numbers(keys: str, law: Damping) -> None:
    system = system_of(plain_case(keys))
    assert (system.s, system.d, system.body.damping) == (20.0, law.rigid, law)


def test_the_laws_of_a_case_are_those_of_the_model() -> None:
    assert set(get_args(DampingTable.model_fields["kind"].annotation)) == DAMPINGS.keys()
    assert set(get_args(Strain)) == LAWS.keys()


sizes = st.floats(0.0, 1.0)


@given(
    sizes.map(Ratio) | sizes.map(KelvinVoigt) | sizes.map(External) | st.lists(sizes, min_size=1).map(tuple).map(Table)
)
def test_the_table_of_a_law_reads_back(law: Damping) -> None:
    table = json.loads(json.dumps(damping_table(law)))
    assert damping_law(DampingTable(**table), units=False) == law


# -- the contact, and where the load acts --


@pytest.mark.parametrize(("word", "law"), [("kept", Kept), ("reversed", Reversed)])
def test_the_law_of_the_contact(word: str, law: type) -> None:
    assert system_of(si_case(contact=f'strain = "{word}"')).contact == law(0.2)
    assert system_of(plain_case(f'd = 0.01\nstrain = "{word}"')).contact == law(0.6)
    by_area = si_case(contact=f'strain = "{word}"').replace("restitution = 0.2", 'receiving_area = "24 cm^2"')
    assert system_of(by_area).contact == law(receiving_area=24e-4, area=math.pi / 4 * 0.049**2)


def test_a_dimensionless_case_keeps_the_strain() -> None:
    assert system_of(plain_case()).contact == Kept(0.6)
    assert system_of(plain_case()) == System(s=20.0, d=0.0048, restitution=0.6, load=system_of(plain_case()).load)


def test_the_place_of_the_load() -> None:
    assert system_of(si_case(load="at = 0")) == system_of(si_case())
    for text in (si_case(load="at = 1"), plain_case(load="at = 1")):
        assert "load.at = 1: expected 0: this bar has no steps" in refusal(text)
    assert "load.at = -1: expected a whole number" in refusal(si_case(load="at = -1"))
    assert "load.at = 1.5" in refusal(si_case(load="at = 1.5"))


# -- loads of steps --


def steps_case(extra: str = "") -> str:
    return plain_case(load=extra, kind=STEPS)


def test_a_load_of_steps() -> None:
    load = system_of(steps_case("harmonics = 16")).load
    assert (load.breaks, load.values, load.coefficients.size) == ((0.5, 2.0, 4.0), (1.0, -0.5, 0.25), 17)
    text = si_case(load='unit = "kN"\nfrequency = "60 Hz"', kind=STEPS)
    system = system_of(text)
    assert [value * system.force_scale for value in system.load.values] == pytest.approx([1e3, -500.0, 250.0])
    on_a_face = text.replace('unit = "kN"', 'unit = "bar"\narea = "10 cm^2"')
    assert system_of(on_a_face).load.values == pytest.approx([0.1 * value for value in system.load.values])


def test_steps_in_si_want_the_unit_of_their_values() -> None:
    found = refusal(si_case(load='frequency = "60 Hz"', kind=STEPS))
    assert "load.unit: missing" in found and "unit of the numbers" in found and "coefficients" not in found


def test_steps_that_come_as_tables_are_limited() -> None:
    tables = json_tables(Case.from_text(steps_case()))
    tables["load"]["breaks"], tables["load"]["values"] = [0.001 * i for i in range(1030)], [1.0] * 1030
    with pytest.raises(CaseError, match=r"load\.breaks = '1030 phases': expected at most 1024 phases"):
        case_of(tables)


@pytest.mark.parametrize(("name", "value"), [("mean", 0.2), ("amplitude", 2.0), ("load_factor", 0.3)])
def test_a_load_of_steps_is_moved(name: str, value: float) -> None:
    """By its numbers: the load stays one of steps."""
    case = Case.from_text(steps_case())
    moved = placed(case, {name: value}).system().load
    assert moved.breaks == case.system().load.breaks
    found = {"mean": moved.mean, "amplitude": abs(complex(moved.coefficients[1])), "load_factor": moved.load_factor}
    assert found[name] == pytest.approx(value, rel=1e-12)
    twice = placed(case, {"load.scale": 2.0}).system().load
    assert twice.values == pytest.approx([2.0, -1.0, 0.5])


# -- there and back --

CASES = [
    si_case(),
    si_case('damping = {kind = "kelvin_voigt", value = "10 ns"}', contact='strain = "reversed"'),
    si_case('drag = "40 N*s/m^2"'),
    si_case('damping = {kind = "table", value = [1.0, 20]}', "at = 0"),
    plain_case('damping = {kind = "ratio", value = 2e-3}\nstrain = "reversed"'),
    plain_case(),
    steps_case(),
]


# -- JSON --


@pytest.mark.parametrize("text", CASES)
def test_json_tells_of_body_and_contact(text: str) -> None:
    system = system_of(text)
    for found in (steady_answer(Case.from_text(text)).to_json_dict(), case_dict(Case.from_text(text))):
        body = found["body"]
        n = range(1, 9)
        assert body["kind"] == "uniform"
        assert body["frequencies"] == pytest.approx([math.pi * k * system.s for k in n], rel=1e-14)
        assert body["gamma"] == pytest.approx([2.0 * (-1) ** k for k in n], rel=1e-14)
        assert body["damping"] == pytest.approx(system.body.modes(8).damping.tolist(), rel=1e-14)
        assert ("frequencies_Hz" in body) == system.is_si
        assert found["contact"] == {"law": "b77", "strain": system.contact.kind}
        assert json.loads(json.dumps(found, allow_nan=False))["body"] == body
    if system.is_si:
        hertz = case_dict(Case.from_text(text))["body"]["frequencies_Hz"]
        bar = Bar(length=0.341, diameter=0.049)
        assert hertz == pytest.approx(bar.natural_frequencies(8).tolist(), rel=1e-12)


def test_a_mode_with_a_node_at_the_load_is_told_so() -> None:
    """Equal sections are a uniform bar: γ_n = 2 (−1)ⁿ cos nπx."""
    for times, at in (((1, 1), 1), ((1, 5), 1), ((1, 2, 1), 2), ((3, 1), 1)):
        keys = f"impedances = {[1.7] * len(times)}\ntransit_times = {[0.1 * time for time in times]}"
        found = case_dict(Case.from_text(plain_case(keys, f"at = {at}")))["body"]["gamma"]
        x = sum(times[:at]) / sum(times)
        wanted = [2.0 * (-1) ** n * math.cos(n * math.pi * x) for n in range(1, 9)]
        assert found == pytest.approx(wanted, rel=1e-13, abs=1e-13)
        nodes = [n for n, own in enumerate(wanted) if abs(own) < 1e-13]
        assert nodes and [n for n, own in enumerate(found) if own == 0.0] == nodes


# -- reports --


@pytest.mark.parametrize(
    ("strain", "mean", "noted"), [("reversed", 1.5, True), ("kept", 1.5, False), ("reversed", 0.5, False)]
)
def test_a_rest_that_a_falling_bar_need_not_come_to_is_told(strain: str, mean: float, noted: bool) -> None:
    """A bar that keeps its strain comes to rest in a chatter; one that turns it over bounces on (R = 0.8, s = 20)."""
    from percuss.case.answers.steady_report import steady_report

    text = plain_case(f'd = 0\nstrain = "{strain}"', restitution=0.8).replace("mean = 0.9", f"mean = {mean}")
    case = Case.from_text(text)
    answer = steady_answer(case, starts=0)
    told = "bounce on without end" in answer.to_json_dict()["rest"]["note"]
    rows = {label: text for section in steady_report(answer).sections for label, text in getattr(section, "rows", ())}
    assert told == noted == ("bounce on without end" in rows["rest"])
    if mean > 1.0:
        found = run(case.system(), Start.rigid(-0.01), modes=8, stop=Stop(impacts=500))
        assert (found.outcome == "rest") is not noted


def test_reports_name_both_laws() -> None:
    from percuss.case.answers.steady_report import steady_report

    for keys, damping, contact in (
        ("d = 0", "none", "keeps the strain (B77)"),
        ("d = 0.01", "d = 0.01: every motion is braked alike", "keeps the strain (B77)"),
        ('damping = {kind = "ratio", value = 0.01}\nstrain = "reversed"', "damping ratio 0.01: ", "strain over"),
    ):
        rows = dict(steady_report(steady_answer(Case.from_text(plain_case(keys)))).sections[0].rows)
        assert rows["damping"].startswith(damping)
        assert contact in rows["contact"]
        laws = case_dict(Case.from_text(plain_case(keys)))["laws"]
        assert laws == {"damping": rows["damping"], "contact": rows["contact"]}


def test_a_report_in_si_tells_the_drag_of_a_damping_that_drags() -> None:
    from percuss.case.answers.heading import system_section

    rows = dict(system_section("case", system_of(si_case('drag = "400 N*s/m^2"')), ()).rows)
    assert rows["damping"].endswith("c = 136.4 N·s/m")
    assert "c = " not in dict(system_section("case", system_of(si_case()), ()).rows)["damping"]
