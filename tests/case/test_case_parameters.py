"""What of a case may be varied: the keys and the dimensionless parameters, their words, their sliders, their moves."""

from __future__ import annotations

from typing import Any

import pytest

from percuss.case import MACHINES, Case, CaseFamily, load_case
from percuss.case.file_format.plain_tables import case_of
from percuss.case.parameters.case_keys import KEYS, held, key_of, varied_keys, with_held
from percuss.case.parameters.description import plain_tables
from percuss.case.parameters.moved_case import placed
from percuss.case.parameters.moves import MOVES, RELATIVE
from percuss.case.parameters.parameter_list import parameters
from percuss.errors import ParameterError
from percuss.explore import PARAMETERS

SQUARE = {
    "system": {"s": 20.0, "d": 0.01, "restitution": 0.4},
    "load": {"kind": "square", "amplitude": 1, "kappa": 1.3},
}


def rows(case: Case) -> dict[str, dict[str, Any]]:
    return {row["name"]: row for row in parameters(case)}


def sliders(case: Case) -> list[str]:
    return [name for name, row in rows(case).items() if row["slides"]]


@pytest.mark.parametrize("name", [machine.name for machine in MACHINES])
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


@pytest.mark.parametrize("name", ["s", "d", "restitution", "kappa", "load_factor", "amplitude"])
def test_a_dimensionless_case_is_moved_to_the_value_itself(name: str) -> None:
    moved = placed(case_of(SQUARE), {name: 0.7})
    assert PARAMETERS[name].get(moved.system()) == pytest.approx(0.7, rel=1e-9)


def test_what_cannot_be_moved_says_so() -> None:
    for values in ({"eta": 1e-5}, {"mean": 0.4}, {"nothing": 1.0}, {"bar.length": 300.0}, {"s": float("nan")}):
        with pytest.raises(ParameterError):
            placed(case_of(SQUARE), values)
