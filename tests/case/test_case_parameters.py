"""What of a case may be varied: the keys and the dimensionless parameters, their words, their sliders, their moves."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from case_texts import STEPPED, plain_case, si_case
from percuss.case import MACHINES, Case, CaseFamily, load_case, reach_answer, steady_answer
from percuss.case.case import case_of, without_files
from percuss.case.catalogue.sample_cases import STRUCTURES
from percuss.case.file_format.reading import toml_text, value_at, with_value
from percuss.case.parameters.case_keys import KEYS, held, key_of, varied_keys, with_held
from percuss.case.parameters.description import parameters, plain_tables
from percuss.case.parameters.moves import MOVES, RELATIVE, placed
from percuss.errors import CaseError, ParameterError
from percuss.explore import PARAMETERS
from percuss.model import Damping, External, KelvinVoigt, Ratio, SteppedBar

SQUARE = {
    "system": {"s": 20.0, "d": 0.01, "restitution": 0.4},
    "load": {"kind": "square", "amplitude": 1, "kappa": 1.3},
}


def rows(case: Case) -> dict[str, dict[str, Any]]:
    return {row["name"]: row for row in parameters(case)}


def sliders(case: Case) -> list[str]:
    return [name for name, row in rows(case).items() if row["slides"]]


@pytest.mark.parametrize("name", [machine.name for machine in MACHINES if not machine.valve])
def test_every_row_has_its_words_and_a_range_about_its_value(name: str) -> None:
    for case in (load_case(name), case_of(plain_tables(load_case(name)))):
        for row in parameters(case):
            assert row["label"] and row["low"] < row["high"], row
            assert row["value"] is None or row["low"] <= row["value"] <= row["high"] or row["dimensionless"], row
            assert row["dimensionless"] == (row["name"] in PARAMETERS)
            assert row["movable"] or not row["slides"], row


def test_sliders_are_of_what_stands_in_the_case() -> None:
    breaker = load_case("mini-breaker")
    assert {"restitution", "load_factor", "bar.length", "load.frequency"} <= set(sliders(breaker))
    assert not {"s", "d", "damping_ratio", "mean", "amplitude"} & set(sliders(breaker))
    plain = case_of(plain_tables(breaker))
    assert {"restitution", "load_factor", "s"} <= set(sliders(plain))
    assert sliders(case_of(SQUARE)) == ["restitution", "kappa", "s", "d"]  # κ moves the mean of a square load


def test_the_frequency_of_a_recording_is_a_parameter_that_keeps_its_waveform() -> None:
    drifter = load_case("hydraulic-drifter")
    row = rows(drifter)["load.frequency"]
    assert (row["value"], row["unit"]) == (pytest.approx(60.0, rel=1e-3), "Hz")
    assert not row["movable"] and not row["slides"]  # in the case it says where the cycles are cut
    motion = steady_answer(drifter).chosen.orbit
    (reached,) = reach_answer(drifter, motion, ["load.frequency"], modes=0)
    assert "60 Hz: down to 20 Hz and further; up to 180 Hz and further" in str(reached)  # a rigid bar knows none


def test_the_tables_know_nothing_that_is_not_there() -> None:
    assert set(MOVES) == set(PARAMETERS) and set(RELATIVE) < set(MOVES)
    things = {parameter.thing for parameter in PARAMETERS.values()} | set(KEYS)
    for name, key in KEYS.items():
        assert not key.sets or key.sets in things, name
        assert all(name in key_of(other).instead_of for other in key.instead_of), name


def test_a_key_takes_the_place_of_the_others_that_set_the_same() -> None:
    case = load_case("mini-breaker")
    thin = CaseFamily(case, {"bar.area": "cm^2"}).system({"bar.area": 9.0})
    assert thin.bar is not None and thin.bar.pieces[-1].area == pytest.approx(9e-4)
    family = CaseFamily(case, {})
    assert family.key("damping_ratio") == "bar.damping_ratio" and family.key("restitution") == ""
    assert family.system({"damping_ratio": 2e-3}).is_si  # by the key of the bar, which keeps the scales
    dragged = CaseFamily(case.varied({"bar.damping_ratio": None, "bar.drag": "4 N*s/m^2"}), {})
    for one, names in ((dragged, {"damping_ratio": "", "d": ""}), (family, {"load_factor": "", "mean": ""})):
        with pytest.raises(ParameterError, match="sets the same"):
            one.check(names)


def test_a_table_of_a_kind_and_a_value_holds_its_value() -> None:
    given = {"kind": "kelvin_voigt", "value": "2e-9 s"}
    assert held(given) == "2e-9 s" and held("341 mm") == "341 mm" and held(None) is None
    assert with_held(given, "3e-9 s") == {"kind": "kelvin_voigt", "value": "3e-9 s"} and with_held(0.1, 0.2) == 0.2
    assert "bar.damping_ratio" in varied_keys(load_case("mini-breaker"))


# -- damping, and sections --

OTHER_LAWS = [
    (si_case('damping = {kind = "kelvin_voigt", value = "10 ns"}'), "damping_ratio", "vary bar.damping"),
    (si_case('damping = {kind = "kelvin_voigt", value = "10 ns"}'), "bar.drag", "vary bar.damping"),
    (si_case('damping = {kind = "table", value = [1.0, 2.0]}'), "damping_ratio", "no single number"),
    (si_case('damping = {kind = "table", value = [1.0, 2.0]}'), "bar.damping", "one number"),
    (si_case('drag = "40 N*s/m^2"'), "damping_ratio", "vary bar.drag"),
    (si_case('drag = "40 N*s/m^2"'), "bar.damping", "vary bar.drag"),
    (si_case("damping_ratio = 1e-3"), "drag", "vary bar.damping_ratio"),
    (si_case(), "bar.damping", "vary bar.damping_ratio or bar.drag"),
    (plain_case('d = 0\ndamping = {kind = "ratio", value = 0.01}'), "system.d", "vary system.damping"),
    (plain_case('damping = {kind = "table", value = [0.1]}'), "system.damping", "one number"),
    (plain_case(), "system.damping", "vary system.d"),
]


@pytest.mark.parametrize(("text", "name", "remedy"), OTHER_LAWS)
def test_an_axis_of_damping_takes_no_other_law_away(text: str, name: str, remedy: str) -> None:
    with pytest.raises(ParameterError, match=name) as caught:
        CaseFamily(Case.from_text(text), {}).check({name: ""})
    assert remedy in str(caught.value)


@pytest.mark.parametrize(
    ("bar", "name", "unit", "value", "law"),
    [
        ('damping = {kind = "kelvin_voigt", value = "10 ns"}', "bar.damping", "ns", 20.0, KelvinVoigt),
        ('damping = {kind = "kelvin_voigt", value = "0 ns"}', "damping_ratio", "", 0.01, Ratio),
        ('damping = {kind = "ratio", value = 0.002}', "damping_ratio", "", 0.01, Ratio),
        ('damping = {kind = "external", value = 3.0}', "drag", "N*s/m^2", 40.0, External),
        ("damping_ratio = 1e-3", "damping_ratio", "", 0.01, Ratio),
        ("", "drag", "N*s/m^2", 40.0, External),
    ],
)
def test_an_axis_of_damping_varies_the_law_of_the_case(
    bar: str, name: str, unit: str, value: float, law: type[Damping]
) -> None:
    family = CaseFamily(Case.from_text(si_case(bar)), {name: unit} if unit else {})
    family.check({name: unit})
    found, more = (family.system({name: factor * value}).body.damping for factor in (1.0, 2.0))
    assert isinstance(found, law) and isinstance(more, law)
    omega = np.array([1.0, 9.0])
    assert more.of(omega) == pytest.approx(2.0 * found.of(omega), rel=1e-12)


@pytest.mark.parametrize("keys", ["d = 0.3", "damping = {kind = 'external', value = 0.3}"])
def test_either_key_of_an_external_damping_varies_it(keys: str) -> None:
    family = CaseFamily(Case.from_text(plain_case(keys)), {})
    for name in ("d", "system.d") if keys.startswith("d =") else ("d", "system.d", "system.damping"):
        family.check({name: ""})
        assert family.system({name: 0.1}).d == 0.1


def test_the_sizes_of_sections_are_varied() -> None:
    case = Case.from_text(si_case(sizes=STEPPED))
    family = CaseFamily(case, {"sections[0].length": "mm", "bar.sections[1].bore": "mm"})
    family.check({"sections[0].length": "mm", "bar.sections[1].bore": "mm"})
    bar = family.system({"sections[0].length": 150.0, "bar.sections[1].bore": 12.0}).bar
    assert bar is not None and [piece.end - piece.start for piece in bar.pieces] == pytest.approx([0.15, 0.25])
    assert bar.pieces[1].bore == pytest.approx(0.012)
    assert case == Case.from_text(si_case(sizes=STEPPED))
    row = rows(case)["bar.sections[0].length"]
    assert (row["value"], row["unit"], row["slides"]) == (120.0, "mm", False)
    moved = placed(case, {"bar.sections[0].length": 100.0})
    assert moved.to_dict()["bar"]["sections"][0]["length"] == "100.0 mm"
    plain = Case.from_text(plain_case("impedances = [2, 1]\ntransit_times = [1, 2]"))
    assert CaseFamily(plain, {}).system({"impedances[1]": 3.0}).body == SteppedBar(20.0, (2.0, 3.0), (1.0, 2.0))


@pytest.mark.parametrize("name", ["bar.length", "length", "diameter", "bar.sections[7].length", "sections"])
def test_sizes_of_a_bar_of_sections_are_those_of_its_sections(name: str) -> None:
    with pytest.raises(ParameterError) as caught:
        CaseFamily(Case.from_text(si_case(sizes=STEPPED)), {}).key(name)
    assert "bar.sections[i].length" in caught.value.accepted
    assert "counted from 0 at the driven end: bar.sections[0]." in caught.value.remedy


@pytest.mark.parametrize("key", ["bar.sections[2].length", "bar.length.mm", "bar", "load.kind[0]", "bar.sections[-1]"])
def test_a_key_of_nothing_is_not_varied(key: str) -> None:
    with pytest.raises((ParameterError, CaseError)):
        Case.from_text(si_case(sizes=STEPPED)).varied({key: "1 mm"})


@pytest.mark.parametrize("name", [machine.name for machine in MACHINES] + [case.name for case in STRUCTURES])
def test_a_varied_case_is_the_one_that_would_be_read(name: str) -> None:
    """The table of a key is read anew and no other: the same case, and the same refusal, as from a whole text."""
    case = load_case(name)

    def read(values: dict[str, Any]) -> Case:
        ((key, value),) = values.items()
        return Case.from_text(toml_text(with_value(case.to_dict(), key, value)), case.file, case.folder)

    for key in varied_keys(case):
        for value in (value_at(case.to_dict(), key), 0.3, -1, "1 parsec", None) if key != "load.scale" else ():
            told = []
            for make in (case.varied, read):
                try:
                    told.append(make({key: value}).tables)
                except CaseError as error:
                    told.append(str(error))
            assert told[0] == told[1], (key, value)


@pytest.mark.parametrize("name", ["s", "d", "restitution", "kappa", "load_factor", "amplitude"])
def test_a_dimensionless_case_is_moved_to_the_value_itself(name: str) -> None:
    moved = placed(case_of(SQUARE), {name: 0.7})
    assert PARAMETERS[name].get(moved.system()) == pytest.approx(0.7, rel=1e-9)


def test_what_cannot_be_moved_says_so() -> None:
    square, breaker = case_of(SQUARE), load_case("mini-breaker")
    for values in ({"eta": 1e-5}, {"mean": 0.4}, {"nothing": 1.0}, {"bar.length": 300.0}, {"s": float("nan")}):
        with pytest.raises(ParameterError):
            placed(square, values)
    with pytest.raises(CaseError):
        placed(square, {"restitution": 2.0})
    with pytest.raises(ParameterError, match="greater than 0"):
        placed(breaker, {"s": 0.0})


def test_several_moves_of_a_square_load_hold_together() -> None:
    moved = placed(case_of(SQUARE), {"load_factor": 0.4, "restitution": 0.3, "s": 30.0}).system()
    assert moved.load.load_factor == pytest.approx(0.4, abs=1e-12)
    assert (moved.restitution, moved.s) == (0.3, 30.0)


@pytest.mark.parametrize("name", [machine.name for machine in MACHINES if not machine.valve])
def test_every_movable_parameter_moves_to_its_value(name: str) -> None:
    case = without_files(load_case(name))
    for row in parameters(case):
        if row["movable"] and row["name"] != "load.scale":
            value = 1.01 * row["value"]
            found = rows(placed(case, {row["name"]: value}))[row["name"]]
            assert (found["value"], found["unit"]) == (pytest.approx(value, rel=1e-12), row["unit"])
    now = case.system()
    scaled = placed(case, {"load.scale": 2.0}).system().load
    np.testing.assert_allclose(scaled.coefficients, 2.0 * now.load.coefficients, rtol=1e-14)
    moved = placed(case, {"s": 7.5, "restitution": 0.25}).system()  # which leaves all other numbers alone
    assert (moved.s, moved.restitution) == (pytest.approx(7.5, rel=1e-12), 0.25)
    assert moved.d == pytest.approx(now.d, rel=1e-12)
    np.testing.assert_allclose(moved.load.coefficients, now.load.coefficients, rtol=1e-12)


def test_every_parameter_of_the_catalogue_has_a_name_of_its_own() -> None:
    """On an axis or beside a slider no two are called the same, and none by its key."""
    for sample in (*MACHINES, *STRUCTURES):
        labels = [row["label"] for row in parameters(load_case(sample.name)) if not row["dimensionless"]]
        assert len(set(labels)) == len(labels), sample.name
        assert not [label for label in labels if re.search(r"\w\.\w|\[\d", label)], sample.name
    named = {row["name"]: row["label"] for row in parameters(load_case("oil-drifter"))}
    assert named["load.orifices[1].drop"] == "passage rear – tank: drop"
    assert "load.scale" not in named  # a map of oil that flows refuses it
