"""What the bar strikes, in case files: [tool], [rock], [blow]; messages, the way back, and cases of one blow only."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from case_texts import BAR, BLOW, MOTION, TOOL, refusal
from percuss.blow import Rock, Rod, Wall
from percuss.case import Case
from percuss.case.case import case_of, json_tables
from percuss.case.file_format.bodies import MATERIALS
from percuss.case.parameters.case_family import CaseFamily
from percuss.case.parameters.case_keys import varied_keys
from percuss.case.parameters.description import plain_tables
from percuss.case.parameters.moves import placed
from percuss.errors import CaseError, ParameterError
from percuss.model import Section, SteppedBar, UniformBar
from percuss.model.contact import Timed

PLAIN = """
[system]
s = 20.0
d = 0.0
restitution = 0.6
[tool]
impedance = 3.0
[load]
kind = "harmonic"
mean = 0.5
amplitude = 1.0
"""


def tool_of(text: str) -> Rod | Wall:
    return Case.from_text(text).tool()


# -- what the tables make --


def test_a_blow_needs_no_load_and_no_contact() -> None:
    question = Case.from_text(BAR + TOOL + BLOW).blow_question()
    rod = Rod(
        (Section(1.2, diameter=0.038), Section(0.1, diameter=0.06)),
        "rock",
        bit_mass=3.0,
        rock=Rock(4e8, 0.4, 0.2e-3),
        gap=0.5e-3,
    )
    assert question.target == rod
    assert [piece.diameter for piece in question.striker.pieces] == [0.052, 0.04]  # type: ignore[union-attr]
    assert (question.velocity, question.until, question.load_at) == (9.5, 0.003, 1)
    assert question.load == ((0.0, 4e3), (1e-3, -2e3))


def test_what_only_a_motion_has_is_asked_for_with_the_command_that_works() -> None:
    case = Case.from_text(BAR + TOOL, file="case.toml")
    for ask in (case.system, case.load, case.start, case.simulation, case.timed_law, lambda: case.notes):
        with pytest.raises(CaseError) as caught:
            ask()
        first, second = str(caught.value).splitlines()
        assert first.startswith("case.toml: load: missing — only 'percuss blow' works without it")
        assert second.startswith("case.toml: contact: missing — only 'percuss blow' works without it")
    assert Case.from_text(BAR + TOOL + MOTION).system() == Case.from_text(BAR + MOTION).system()
    with pytest.raises(CaseError, match="load: missing"):
        Case.from_text(PLAIN.partition("[load]")[0]).system()


@pytest.mark.parametrize(
    ("tool", "end"),
    [
        ('[tool]\nsections = [{diameter = "38 mm"}]', "infinite"),
        ('[tool]\nsections = [{length = "1 m", diameter = "38 mm"}, {diameter = "60 mm"}]', "infinite"),
        ('[tool]\nsections = [{length = "1 m", diameter = "38 mm"}]\n[rock]\nstiffness = "1 GN/m"', "rock"),
        ('[tool]\nkind = "rod"\nsections = [{length = "1 m", diameter = "38 mm"}]\nend = "free"', "free"),
        ('[tool]\nsections = [{length = "1 m", diameter = "38 mm"}]\nend = "fixed"', "fixed"),
    ],
)
def test_the_end_of_the_rod(tool: str, end: str) -> None:
    rod = tool_of(BAR + tool)
    assert isinstance(rod, Rod) and rod.end == end
    if rod.rock is not None:
        assert rod.rock == Rock(1e9)  # nothing else is known: it gives everything back


def test_walls() -> None:
    assert tool_of(BAR + '[tool]\nkind = "wall"\ngap = "2 mm"') == Wall(0.002)
    assert tool_of(BAR + MOTION) == Wall()
    assert tool_of(PLAIN.replace("impedance = 3.0", 'kind = "wall"\ngap = 0.1')) == Wall(0.1)
    assert tool_of(PLAIN.replace("[tool]\nimpedance = 3.0\n", "")) == Wall()


def test_a_receiving_area_is_an_endless_rod_of_the_material_of_the_striking_end() -> None:
    bar = '[bar]\nlength = "0.3 m"\ndiameter = "30 mm"\nyoungs_modulus = "114 GPa"\ndensity = "4430 kg/m^3"\n'
    rod = tool_of(bar + MOTION.replace("restitution = 0.2", 'receiving_area = "24 cm^2"'))
    assert rod == Rod((Section(None, area=24e-4, youngs_modulus=114e9, density=4430.0),))
    said = tool_of(bar + MOTION.replace("restitution = 0.2", 'receiving_area = "24 cm^2"') + '[tool]\nkind = "wall"')
    assert said == Wall()


def test_the_tool_has_its_own_material() -> None:
    bar = '[bar]\nlength = "0.3 m"\ndiameter = "30 mm"\nyoungs_modulus = "114 GPa"\ndensity = "4430 kg/m^3"\n'
    sections = '[{length = "1 m", diameter = "38 mm"}, {diameter = "9 cm", material = "bronze"}]'
    rod = tool_of(bar + f"[tool]\nsections = {sections}")
    assert isinstance(rod, Rod)
    found = [(piece.youngs_modulus, piece.density) for piece in rod.pieces]
    assert found == [MATERIALS["steel"], MATERIALS["bronze"]]


@pytest.mark.parametrize("sections", ["", "impedances = [2.0, 1.0]\ntransit_times = [1.0, 2.0]\n"])
def test_a_dimensionless_rod_is_told_by_the_impedance_of_the_last_section(sections: str) -> None:
    question = Case.from_text(PLAIN.replace("[tool]", sections + "[tool]")).blow_question()
    body = question.striker
    assert isinstance(body, SteppedBar if sections else UniformBar)
    # mass 1 = Z₁τ₁ + Z₂τ₂ with τ₁ + τ₂ = 1/s, Z₁ = 2 Z₂, τ₂ = 2 τ₁: Z₂ (2 + 2)/(3 s) = 1
    own = 20.0 * 3.0 / 4.0 if sections else 20.0
    assert isinstance(question.target, Rod)
    assert question.target.end_impedance == pytest.approx(3.0 * own, rel=1e-14)


def test_a_dimensionless_blow() -> None:
    blow = "[blow]\nvelocity = 2\nuntil = 0.5\nload = [[0, 0.4], [0.1, -0.2]]\n"
    question = Case.from_text(PLAIN + blow).blow_question()
    assert (question.velocity, question.until, question.load) == (2.0, 0.5, ((0.0, 0.4), (0.1, -0.2)))
    several = BAR + TOOL + BLOW.replace('"9.5 m/s"', '["9 m/s", "-1 m/s"]')
    assert Case.from_text(several).blow_question().velocity == (9.0, -1.0)


# -- the way back --

lengths = st.floats(1e-3, 50.0).map(lambda x: f"{x!r} m")
sizes = st.floats(0.01, 0.2).map(lambda x: f"{x!r} m")
sections = st.lists(st.fixed_dictionaries({"length": lengths, "diameter": sizes}), min_size=1, max_size=4)
rocks = st.fixed_dictionaries(
    {"stiffness": st.floats(1e3, 1e12).map(lambda k: f"{k!r} N/m")},
    optional={"unloading_ratio": st.floats(0.01, 1.0), "gap": st.floats(0.0, 0.1).map(lambda x: f"{x!r} m")},
)
blows = st.fixed_dictionaries(
    {},
    optional={
        "velocity": st.floats(0.01, 100.0).map(lambda v: f"{v!r} m/s"),
        "until": st.floats(1e-9, 1e3).map(lambda t: f"{t!r} s"),
        "load": st.floats(-1e6, 1e6).map(lambda p: [["0 s", f"{p!r} N"], ["1 ms", "0 N"]]),
    },
)


@given(sections, st.none() | rocks, blows, st.sampled_from(["free", "fixed", None]), st.booleans())
def test_a_tool_reads_back(
    parts: list[dict[str, str]], rock: dict[str, Any] | None, blow: dict[str, Any], end: str | None, motion: bool
) -> None:
    tool: dict[str, Any] = {"sections": parts}
    if rock is None and end is None:
        tool["sections"] = [*parts, {"diameter": "40 mm"}]
    elif rock is None:
        tool["end"] = end
    tables: dict[str, Any] = {"bar": {"length": "0.3 m", "diameter": "40 mm"}, "tool": tool, "blow": blow}
    tables |= {} if rock is None else {"rock": rock}
    if motion:
        load = {"kind": "harmonic", "mean": "4 kN", "amplitude": "9 kN", "frequency": "60 Hz"}
        tables |= {"load": load, "contact": {"restitution": 0.2}}
    case = case_of(tables)
    again = Case.from_text(case.to_toml())
    assert again == case == case_of(json_tables(case))
    assert again.blow_question() == case.blow_question()
    assert again.to_toml() == case.to_toml()


def test_other_keys_keep_the_tool() -> None:
    case = Case.from_text(BAR + TOOL + BLOW + MOTION)
    changed = case.changed(simulation={"impacts": 7}, start={"position": -0.5})
    assert changed.blow_question() == case.blow_question()
    tool = case.varied({"tool.bit_mass": "2 kg", "rock.stiffness": "1 MN/mm", "tool.gap": None}).tool()
    assert isinstance(tool, Rod) and tool.rock is not None
    assert (tool.bit_mass, tool.rock.stiffness, tool.gap) == (2.0, 1e9, 0.0)
    with pytest.raises(CaseError, match=r"rock\.unloading_ratio = 2\.0"):
        case.varied({"rock.unloading_ratio": 2.0})


# -- what is wrong --


@pytest.mark.parametrize("contact", ['restitution = "from the blow"', 'law = "b77-blow"'])
def test_a_contact_by_the_blow_needs_a_tool(contact: str) -> None:
    found = refusal(BAR + MOTION.replace("restitution = 0.2", contact))
    assert "a table [tool]" in found and 'kind = "wall"' in found
    plain = PLAIN.replace("[tool]\nimpedance = 3.0\n", "").replace("restitution = 0.6", 'restitution = "from the blow"')
    assert "system.restitution = 'from the blow': expected a table [tool]" in refusal(plain)


# -- what may be varied --


def test_the_numbers_of_the_tool_may_be_varied() -> None:
    case = Case.from_text(BAR + TOOL + BLOW + MOTION)
    keys = set(varied_keys(case))
    wanted = {"tool.bit_mass", "tool.gap", "rock.stiffness", "rock.unloading_ratio", "rock.gap", "blow.velocity"}
    assert wanted <= keys
    assert not keys & {"tool.kind", "tool.end", "tool.sections", "blow.load", "blow.load_at", "contact.law"}
    assert not any(key.startswith(("tool", "rock", "blow")) for key in varied_keys(Case.from_text(BAR + MOTION)))
    alone = set(varied_keys(Case.from_text(BAR + TOOL)))
    assert "rock.stiffness" in alone and not any(key.startswith("load.") for key in alone)
    family = CaseFamily(case, {"stiffness": "kN/mm", "tool.gap": "mm"})
    assert (family.key("stiffness"), family.key("bit_mass")) == ("rock.stiffness", "tool.bit_mass")
    with pytest.raises(ParameterError, match=re.escape("one of tool.gap and rock.gap")):
        CaseFamily(case, {"gap": "mm"}).key("gap")


def test_the_sizes_of_its_sections_may_be_varied() -> None:
    case = Case.from_text(BAR + TOOL + BLOW + MOTION)
    name = "tool.sections[1].length"
    family = CaseFamily(case, {name: "mm", "tool.sections[0].diameter": "cm", "stiffness": "N/m"})
    assert family.key(name) == name
    tool = case.varied({name: "50 mm", "tool.sections[0].diameter": "3 cm"}).tool()
    assert isinstance(tool, Rod)
    assert [(s.length, s.diameter) for s in tool.sections] == [(1.2, 0.03), (0.05, 0.06)]
    with pytest.raises(
        ParameterError, match=r"sections, counted from 0 at the struck face: tool\.sections\[0\]\.length"
    ):
        family.key("tool.sections[2].length")
    with pytest.raises(ParameterError, match=r"one of bar\.sections.* and tool\.sections"):
        family.key("sections[1].length")
    endless = Case.from_text(BAR + MOTION + '[tool]\nsections = [{diameter = "4 cm"}]\n')
    assert [key for key in varied_keys(endless) if key.startswith("tool.")] == [
        *(f"tool.{key}" for key in ("bit_mass", "gap")),
        *(f"tool.sections[0].{key}" for key in ("diameter", "bore", "youngs_modulus", "density", "attenuation")),
    ]


# -- a law that needs no tool --


@pytest.mark.parametrize("advance", [None, "kept", "pushed back"])
def test_the_law_of_a_uniform_bar(advance: str | None) -> None:
    bar = '[bar]\nlength = "341 mm"\ndiameter = "49 mm"\n'
    said = "" if advance is None else f'\nadvance = "{advance}"'
    case = Case.from_text(bar + MOTION.replace("restitution = 0.2", 'law = "b77-tau"\nrestitution = 0.2' + said))
    law, system = case.timed_law(), case.system()
    assert law == Timed.of_uniform_bar(system.s, 0.2, advance or "kept")
    assert case_of(plain_tables(case)).timed_law() == law
    assert Case.from_text(bar + MOTION).timed_law() is None
    assert placed(case, {"restitution": 0.3}).timed_law() == Timed.of_uniform_bar(system.s, 0.3, advance or "kept")


def test_the_law_of_a_uniform_bar_knows_no_rock() -> None:
    bar = '[bar]\nlength = "341 mm"\ndiameter = "49 mm"\n'
    law = 'law = "b77-tau"\nrestitution = 0.2\nadvance = "residual penetration"'
    case = Case.from_text(bar + MOTION.replace("restitution = 0.2", law), file="case.toml")
    with pytest.raises(CaseError, match=r"contact\.advance = 'residual penetration'.*b77-blow"):
        case.timed_law()


# -- the catalogue --


def test_masses_at_the_steps_of_a_rod():
    """Each with the section before its step: in the rod, on the way back, varied, and refused behind the last."""
    text = BAR + TOOL.replace('diameter = "38 mm"}', 'diameter = "38 mm", joint_mass = "2.5 kg"}') + BLOW
    case = Case.from_text(text)
    rod = case.blow_question().target
    assert rod.joint_masses == ((1, 2.5),)
    plain = Case.from_text(BAR + TOOL + BLOW).blow_question().target
    assert rod == replace(plain, joint_masses=[(1, 2.5)])
    assert case_of(json_tables(case), "<text>") == case
    keys = [key for key in varied_keys(case) if "joint_mass" in key]
    assert keys == ["tool.sections[0].joint_mass"]
    family = CaseFamily(case, {keys[0]: "g"})
    assert family.varied({keys[0]: 700.0}).blow_question().target.joint_masses == ((1, 0.7),)
    assert family.blow({keys[0]: 700.0}).bit_force is not None
    with pytest.raises(CaseError, match=r"sections\[1\].joint_mass.* a mass at the end of the rod is bit_mass"):
        Case.from_text(text.replace('diameter = "60 mm"}', 'diameter = "60 mm", joint_mass = "1 g"}'))
    with pytest.raises(CaseError, match=r"sections\[0\].joint_mass.*0 or greater"):
        Case.from_text(text.replace("2.5 kg", "-1 kg"))
