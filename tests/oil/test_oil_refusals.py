# ruff: noqa: E501  # lines of a table of texts
"""What is wrong in the keys of oil that flows is refused by its key, and what does not run says why."""

import json
import re
from pathlib import Path

import pytest

from case_texts import refusal
from oil_cases import case_text, named

DRIFTER, BREAKER = case_text(named("drifter"), si=True), case_text(named("19 to 28"), si=True)
PLAIN = case_text(named("everything"))
IN = r'in = \{drop = "[^"]*", at = "[^"]*"\}'
TWICE = '{chamber = "rear", to = "tank", drop = "1 bar", at = "60 l/min"}'
AREAS = 'states = {return = {front = "3.2 cm^2", rear = "0 cm^2"}, power = {front = "3.2 cm^2", rear = "9 cm^2"}}'


def changed(text, pattern, to):
    found, times = re.subn(pattern, to, text, count=1)
    assert times, pattern
    return found


def without(key):
    return rf"{key} = (\"[^\"]*\"|\{{[^}}]*\}})(, )?", ""


@pytest.mark.parametrize(
    ("text", "change", "said"),
    [
        (DRIFTER, ('chamber = "rear"', 'chamber = "raer"'), "load.orifices[0].chamber = 'raer': .*did you mean 'rear'"),
        (DRIFTER, ('chamber = "rear", to = "tank"', 'chamber = "front", to = "tank"'),
         "load.orifices[0].chamber = 'front': expected a state that joins the chamber 'front' to the tank — join it"),
        (DRIFTER, ('state = "power"', 'state = "pwoer"'), "load.orifices[2].state = 'pwoer': .*did you mean 'power'"),
        (DRIFTER, (r"return = \{rear", "return = {raer"), "load.states.return.raer = 'tank': expected a chamber: front, rear"),
        (DRIFTER, ('rear = "tank"', 'rear = "tnak"'), "load.states.return.rear = 'tnak': expected 'supply' or 'tank'"),
        (DRIFTER, ('side = "rear"', 'side = "rear", zone = 3'), "[load.chambers.rear] takes area, side"),
        (DRIFTER, (r"in = \{", "in = {zone = 3, "), "[load.orifices[0].in] takes area, discharge, drop, at"),
        (PLAIN, (r"in = \{", "in = {area = 1.0, "), "[load.orifices[0].in] takes drop, at"),
        (DRIFTER, ('drop = "[^"]*"', 'drop = "-3 bar"'), "load.orifices[0].in.drop = '-3 bar': .*0 or greater"),
        (DRIFTER, (', at = "[^"]*"', ""), "load.orifices[0].in.at: expected both drop and at"),
        (DRIFTER, (r'drop = "[^"]*", ', ""), "load.orifices[0].in.drop: expected both drop and at"),
        (DRIFTER, ('at = "[^"]*"', 'at = "0 l/min"'), "load.orifices[0].in.at = '0 l/min': expected a flow greater than 0"),
        (DRIFTER, (r"in = \{", 'in = {area = "1 cm^2", '), "in.area = '1 cm^2': expected nothing beside drop and at — leave out"),
        (DRIFTER, (r"in = \{", "in = {discharge = 0.6, "), "in.discharge = 0.6: expected nothing without an area"),
        (DRIFTER, (IN, 'in = {area = "1 cm^2", discharge = 0.0}'), "in.discharge = 0.0: expected a number greater than 0"),
        (DRIFTER, ("orifices = .*", 'orifices = [{chamber = "rear", to = "tank"}]'), "load.orifices[0].area: expected an area, or"),
        (DRIFTER, ("orifices = .*", f"orifices = [{TWICE}, {TWICE}]"),
         "load.orifices[1] = 'rear': expected one orifice of a chamber to a line"),
        (DRIFTER, ("chambers = .*", ""), "load.chambers: expected the chambers that the orifices lead to"),
        (DRIFTER, ('pressure = "[^"]*"', ""), "load.pressure: expected the pressure for which the figures hold"),
        (DRIFTER, ("states = .*", 'states = {return = "-3 kN", power = "8 kN"}'), "load.states.return = '-3 kN': expected chambers"),
        (DRIFTER, ('tank = "[^"]*"', 'tank = "-1 bar"'), "load.oil.tank = '-1 bar': .*0 or greater"),
        (DRIFTER, ('spool = "[^"]*"', 'spool = "-1 ms"'), "load.spool = '-1 ms': .*0 or greater"),
        (DRIFTER, (", exponent = 1.4", ", exponent = 0.9"), "load.supply.accumulator.exponent = 0.9: expected a number from 1 on"),
        (DRIFTER, (", exponent = 1.4", ", exponent = nan"), "load.supply.accumulator.exponent = nan"),
        (DRIFTER, ('precharge = "[^"]*"', 'precharge = "0 bar"'), "load.supply.accumulator.precharge = '0 bar'"),
        (DRIFTER, without("accumulator"), "load.supply.accumulator: expected the accumulator beside a pump"),
        (DRIFTER, (r', flow = "0.00205 m\^3/s"', ""), "load.supply.flow: expected the flow of the pump, beside supply.accumulator"),
        (DRIFTER, (r"supply = \{", 'supply = {slip = {flow = "1 l/min"}, '), "load.supply.slip.at: missing"),
        (DRIFTER, (r"supply = \{", 'supply = {power = "0 kW", '), "load.supply.power = '0 kW': expected a power greater than 0"),
        (DRIFTER, (r"relief = \{[^}]*\}", 'relief = "0 bar"'), "load.supply.relief = '0 bar': expected a pressure greater than 0"),
        (DRIFTER, (', over = "[^"]*"', ""), "load.supply.relief.over: expected both flow and over, or neither"),
        (DRIFTER, ('line = "[^"]*"', 'line = "-1 l"'), "load.supply.line = '-1 l': .*0 or greater"),
        (DRIFTER, (r"accumulator = \{[^}]*\}", 'accumulator = "2.5 cm^3/bar"'), "load.supply.line = .*with gas beside it"),
        (BREAKER, (r'area = "[^"]*", volume = "[^"]*", exponent = 1.3\}', "exponent = 1.3}"), "load.chamber.area: expected area, volume"),
        (BREAKER, (r"exponent = 1.3\}", 'exponent = 1.3, stiffness = "1 N/m"}'), "load.chamber.stiffness = '1 N/m': expected nothing"),
        (PLAIN, ("tank = [0-9.]*", "tank = nan"), "load.oil.tank = nan"),
    ],
)  # fmt: skip
def test_keys_that_are_wrong(text, change, said):
    told = refusal(changed(text, *change))
    assert re.search(re.escape(said).replace(r"\.\*", ".*"), told), told


def answered(percuss, text, *more):
    Path("oil.toml").write_text(text, encoding="utf-8")
    return percuss("machine", "oil.toml", "--modes", "0", "--no-plausibility", *more)


@pytest.mark.parametrize(
    ("text", "change", "said"),
    [
        (BREAKER, (r"relief = \{[^}]*\}", 'relief = "20 bar"'), ("20 bar there, by the relief valve", "needs more than 125.4 bar")),
        (BREAKER, (r'leakage = \{flow = "[^"]*"', 'leakage = {flow = "10 l/min"'), ("13 bar there, by the leakage", "more than 125.4 bar")),
        (changed(DRIFTER, *without("line")), ('precharge = "[^"]*"', 'precharge = "190 bar"'),
         ("no pressure", "empty below its precharge, 190 bar", "no line (supply.line)")),
    ],
)  # fmt: skip
def test_what_does_not_run_says_which_pressure_it_lacks(percuss, text, change, said):
    assert all(word in answered(percuss, changed(text, *change)).out for word in said)


def test_a_precharge_above_the_mean_pressure_is_told(percuss):
    done = answered(percuss, changed(DRIFTER, 'precharge = "[^"]*"', 'precharge = "190 bar"'), "--json")
    assert "the precharge of the accumulator, 190 bar, is above the mean pressure, 172.6 bar" in done.json["warnings"]


def test_areas_of_nothing_stand_beside_losses(percuss):
    text = changed(changed(DRIFTER, "(chambers|orifices) = .*\n", ""), "states = .*", AREAS)
    text = changed(text, "(chambers|orifices) = .*\n", "")
    done = json.loads(answered(percuss, text, "--json").out)
    assert set(done["oil"]["losses"]) >= {"orifice_front of return", "orifice_rear of power", "leakage"}


@pytest.mark.slow
@pytest.mark.parametrize("value", ["1e-300", "1e-12", "1e12", "1e300"])
@pytest.mark.parametrize(
    ("before", "unit"),
    [
        ("drop = ", "Pa"), ("tank = ", "Pa"), ("spool = ", "s"), ("precharge = ", "Pa"), ("opens = ", "Pa"), ("over = ", "Pa"),
        (r"leakage = \{flow = ", "m^3/s"), (", start = ", "Pa"), ("line = ", "m^3"), (r"\}, flow = ", "m^3/s"), ("volume = ", "m^3"),
    ],
)  # fmt: skip
def test_figures_far_from_any_hammer_end_in_an_answer_or_an_error(percuss, before, unit, value):
    text = changed(DRIFTER, f'({before})"[^"]*"', rf'\1"{value} {unit}"')
    Path("oil.toml").write_text(text + "\n[simulation]\nmodes = 0\nimpacts = 20\n", encoding="utf-8")
    done = percuss("simulate", "oil.toml", "--json")
    assert done.code in (0, 2), done
