"""Blows on a tool that is held, by the command line, against numbers of two other programs."""

import contextlib
import io
import json
import math
from pathlib import Path

import pytest

from percuss.cli import main

FEEDS = json.loads((Path(__file__).parents[1] / "blow" / "reference_feeds.json").read_text(encoding="utf-8"))
ONE_BY_ONE = [case for case in FEEDS if case.get("blows", {}).get("between") != "waves"]
UNITS = {"mass": "kg", "stiffness": "N/m", "damping": "N*s/m", "slack": "m", "force": "N"}


def quoted(values):
    return ", ".join(f'{key} = "{value!r} {UNITS[key]}"' for key, value in values.items())


def sections(rows, attenuation=None):
    found = []
    for i, (length, area, modulus, density) in enumerate(rows):
        keys = [] if length is None else [f'length = "{length!r} m"']
        keys += [f'area = "{area!r} m^2"', f'youngs_modulus = "{modulus!r} Pa"', f'density = "{density!r} kg/m^3"']
        keys += [] if attenuation is None else [f'attenuation = "{attenuation[i]!r} 1/m"']
        found.append("{" + ", ".join(keys) + "}")
    return "[" + ", ".join(found) + "]"


def text(case):
    tool, drilling, blows = case["tool"], case.get("drilling"), case.get("blows", {})
    lines = ["[bar]", f"sections = {sections(case['striker']['sections'])}", "[tool]", f'end = "{tool["end"]}"']
    lines += [f"sections = {sections(tool['sections'], tool.get('attenuation'))}"]
    lines += [f'bit_mass = "{tool["bit_mass"]!r} kg"'] if tool["end"] == "rock" else []
    joints = []
    for one in tool.get("joints", []):
        held = {key: one[key] for key in UNITS if one.get(key) is not None}
        joints.append(f'{{at = {one["step"]}, kind = "{one["kind"]}"{", " * bool(held)}{quoted(held)}}}')
    lines += [f"joints = [{', '.join(joints)}]"] if joints else []
    if "feed" in case:
        held = {key: case["feed"][key] for key in UNITS if key in case["feed"]}
        lines += ["[feed]", f"at = {case['feed'].get('at', 0)}", *quoted(held).split(", ")]
    if "rock" in case:
        lines += ["[rock]", f'stiffness = "{case["rock"]["k1"]!r} N/m"', f"unloading_ratio = {case['rock']['gamma']!r}"]
        lines += [f'crater = "{blows.get("crater", "new")}"']
    lines += ["[blow]", f'velocity = "{case["striker"]["velocity"]!r} m/s"', f'until = "{case["until"]!r} s"']
    lines += [f"number = {blows.get('number', 1)}"]
    if drilling is not None:
        lines.insert(-1, f'rate = "{drilling["blow_rate"]!r} Hz"')
        lines += ["[drilling]", f'bit_diameter = "{drilling["bit_diameter"]!r} m"']
        if "crater_factor" in drilling:
            lines += [f"crater_factor = {drilling['crater_factor']!r}"]
        else:
            lines += [f'specific_energy = "{drilling["specific_energy"]!r} J/m^3"']
    return "\n".join(lines) + "\n"


def answered(path, *options):
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        assert main(["blow", str(path), "--json", *options]) == 0
    return json.loads(out.getvalue())


ELSE = {"rock_dissipated": "rock_work_dissipated"}


def check(found, wanted, case):
    length, area, modulus, density = case["striker"]["sections"][-1]
    v, energy = case["striker"]["velocity"], wanted["energy_before"]
    force, mass = area * math.sqrt(modulus * density) * v, length * area * density
    told = 0
    for key, value in wanted.items():
        ours = found.get(ELSE.get(key, key))
        if isinstance(value, list | dict) or value is None or ours is None:
            continue
        size = abs(value) or 1.0
        if "energy" in key or "work" in key or "loss" in key or "dissipated" in key:
            size = energy
        elif "impulse" in key or "momentum" in key:
            size = 2.0 * mass * v
        elif "force" in key:
            size = force
        elif "penetration" in key or "advance" in key:
            size = 1e-3
        elif "velocity" in key:
            size = v
        if key == "efficiency":
            size = 1.0
        elif "specific" in key or "rate" in key:
            size = abs(value)
        assert abs(ours - value) < case["tolerance"] * size, (key, ours, value)
        told += 1
    for name in ("contacts", "bit_contacts"):
        sizes = (case["until"], case["until"], 2.0 * mass * v, force)
        shown = [one for one in found[name] if one[2] > 1e-6 * mass * v] if name in wanted else []
        for ours, theirs in zip(shown, wanted.get(name, []), strict=False):
            for one, other, size in zip(ours, theirs, sizes, strict=True):
                assert (one is None) == (other is None) and (one is None or abs(one - other) < 1e-9 * size), name
    return told


@pytest.mark.parametrize("case", ONE_BY_ONE, ids=lambda case: case["name"])
def test_blows_of_the_command_line_are_those_of_two_other_programs(case, tmp_path):
    path, expect = tmp_path / "case.toml", case["expect"]
    path.write_text(text(case), encoding="utf-8")
    found = answered(path)
    if "static" in expect:
        for key, value in expect["static"].items():
            assert found["static"][key] == pytest.approx(value, rel=1e-12)
    for key in ("joint_opens", "joint_closes"):
        assert found[key][:2] == pytest.approx(expect.get(key, []), abs=1e-9 * case["until"])
    if "per_blow" in expect:
        assert len(found["per_blow"]) == len(expect["per_blow"])
        for ours, theirs in zip(found["per_blow"], expect["per_blow"], strict=True):
            assert check(ours, theirs, case) > 10
        return
    assert check(found, expect, case) > 15
    starts = [sum(row[0] for row in case["tool"]["sections"][:i]) for i in range(len(case["tool"]["sections"]))]
    force = case["striker"]["velocity"] * 4e4
    for (section, place), high, low in zip(
        case["gauges"], expect["gauge_force_greatest"], expect["gauge_force_least"], strict=True
    ):
        gauge = answered(path, "--gauge", f"{starts[section] + place!r} m")["gauge"]
        assert abs(gauge["force_greatest"] - high) < 1e-9 * force
        assert abs(gauge["force_least"] - low) < 1e-9 * force
