"""Texts of cases in both forms, with the keys that a test wants beside them, and what is said of a wrong one."""

from __future__ import annotations

import pytest

from percuss.case import Case
from percuss.errors import CaseError

UNIFORM = 'length = "341 mm"\ndiameter = "49 mm"'
HEAD = '{length = "120 mm", diameter = "52 mm"}'
SHAFT = '{length = "250 mm", diameter = "40 mm", bore = "8 mm", material = "titanium"}'
STEPPED = f"sections = [{HEAD}, {SHAFT}]"

HARMONIC = 'kind = "harmonic"\nmean = 0.9\namplitude = 1.0'
FOURIER = 'kind = "fourier"\ncoefficients = [[0.9, 0.0], [1.0, 0.0]]'
FORCE = 'kind = "harmonic"\nmean = "4 kN"\namplitude = "9 kN"\nfrequency = "60 Hz"'
VALVE = """kind = "valve"
states = {return = -0.3, power = 1.0}
ports = [{behind = 0.6, side = "back", to = "power", delay = 0.1}, {on = "impact", to = "return"}]
chamber = {force = 0.05, stiffness = 0.1}"""
BARE_VALVE = """kind = "valve"
states = {return = -0.4, power = 1.8}
ports = [{behind = 1.0, side = "back", to = "power"}, {on = "impact", to = "return"}]"""
STEPS = 'kind = "steps"\nbreaks = [0.5, 2.0, 4.0]\nvalues = [1.0, -0.5, 0.25]'


def si_case(bar: str = "", load: str = "", contact: str = "", sizes: str = UNIFORM, kind: str = FORCE) -> str:
    """A case in SI: the sizes of its bar, the kind of its load, and more keys of each table."""
    return f"[bar]\n{sizes}\n{bar}\n[load]\n{kind}\n{load}\n[contact]\nrestitution = 0.2\n{contact}\n"


def plain_case(
    system: str = "d = 0.0048", load: str = "", kind: str = HARMONIC, s: float = 20.0, restitution: float = 0.6
) -> str:
    """A dimensionless case: the kind of its load, and more keys of each table."""
    return f"[system]\ns = {s}\n{system}\nrestitution = {restitution}\n[load]\n{kind}\n{load}\n"


SI = 'title = "Hydraulic drifter"\n' + si_case("damping_ratio = 1e-3")
PLAIN = 'title = "B77 scale"\n' + plain_case(kind=FOURIER)
MACHINE = plain_case("d = 0.0", kind=BARE_VALVE, restitution=0.2)
"""A machine without delay, drag and gas, of which all is known in closed form."""

# ---- A stepped bar on a rod with rock at its end, the blow that is asked for, and what a motion needs besides

BAR = """
[bar]
sections = [{length = "120 mm", diameter = "52 mm"}, {length = "250 mm", diameter = "40 mm", bore = "8 mm"}]
"""
TOOL = """
[tool]
sections = [{length = "1.2 m", diameter = "38 mm"}, {length = "0.1 m", diameter = "60 mm"}]
end = "rock"
bit_mass = "3 kg"
gap = "0.5 mm"
[rock]
stiffness = "400 kN/mm"
unloading_ratio = 0.4
gap = "0.2 mm"
"""
BLOW = """
[blow]
velocity = "9.5 m/s"
until = "3 ms"
load = [["0 s", "4 kN"], ["1 ms", "-2 kN"]]
load_at = 1
"""
MOTION = """
[load]
kind = "harmonic"
mean = "4 kN"
amplitude = "9 kN"
frequency = "60 Hz"
[contact]
restitution = 0.2
"""


def refusal(text: str) -> str:
    """The one line that is said of a case that is none."""
    with pytest.raises(CaseError) as caught:
        Case.from_text(text, file="case.toml")
    assert "\n" not in str(caught.value)
    return str(caught.value)
