"""The cases that commands are asked, and what is looked at in what they print."""

from __future__ import annotations

import json
import math
from typing import Any, NamedTuple

import pytest

from case_texts import PLAIN, plain_case

_STARTED = "[start]\nposition = -0.5\ntime = 0.3\n[simulation]\nmodes = 4\nimpacts = 30\nperiodic = false\n"
_STEPS = "kind = 'steps'\nbreaks = {0}\nvalues = {1}"


def hammer(mean: float, s: float = 5.0, restitution: float = 0.5, modes: int = 0) -> str:
    """A hammer under a harmonic load, by default a rigid one."""
    kind = f'kind = "harmonic"\nmean = {mean}\namplitude = 1.0'
    return plain_case("d = 0.0", kind=kind, s=s, restitution=restitution) + f"[simulation]\nmodes = {modes}\n"


WAVES = """
[bar]
length = "500 mm"
area = "10 cm^2"
youngs_modulus = "200 GPa"
density = "8000 kg/m^3"
[tool]
sections = [{length = "2 m", area = "10 cm^2", youngs_modulus = "200 GPa", density = "8000 kg/m^3"}]
end = "rock"
[rock]
stiffness = "251286241.725234 N/m"
unloading_ratio = 0.25
[blow]
velocity = "10 m/s"
until = "0.8 ms"
"""

CASES = {
    "case": PLAIN,  # B77's
    "tables": PLAIN + _STARTED,
    "light": PLAIN + "[simulation]\nmodes = 2\nimpacts = 200\n",
    "hammer": hammer(0.62),
    "other": hammer(0.665),
    "possible": hammer(0.7),
    "resting": hammer(0.8),
    "chattering": hammer(0.37, restitution=0.05),
    "full": hammer(0.3, restitution=1.0),
    "pulled": hammer(-0.3),
    "driven": hammer(0.3, s=1.0 / math.pi),
    "ringing": hammer(0.3, s=2.0 / math.pi, modes=3),
    "step": plain_case("d = 0.0", kind=_STEPS.format("[0.0]", "[1.0]"), s=5.0, restitution=0.5),
    "flat": plain_case("d = 0.0", kind=_STEPS.format("[0.0, 2.0]", "[1.0, 1.0]"), s=5.0, restitution=0.5),
    "si": """
[bar]
length = "0.4 m"
diameter = "50 mm"
[contact]
restitution = 0.5
[load]
kind = "harmonic"
mean = "8 kN"
amplitude = "10 kN"
frequency = "50 Hz"
[simulation]
modes = 0
""",
    "blow": WAVES,
    "wall": """
[bar]
sections = [{length = "0.3 m", diameter = "40 mm"}, {length = "0.1 m", diameter = "30 mm"}]
[blow]
velocity = "10 m/s"
""",
}


class Done(NamedTuple):
    """What a command has printed, and its exit code."""

    code: int
    out: str
    err: str

    @property
    def json(self) -> Any:
        """The answer as JSON, of a command that has ended well or was interrupted."""
        assert self.code in (0, 130), self.err
        return json.loads(self.out, parse_constant=lambda name: pytest.fail(f"{name} in JSON"))

    def __contains__(self, part: object) -> bool:
        return str(part) in self.out

    def told(self, *parts: str) -> None:
        """It has ended well, and its report says all of this."""
        assert self.code == 0, self.err
        for part in parts:
            assert part in self.out, (part, self.out)

    def refused(self, *parts: str) -> None:
        """It was refused, with all of this on the standard error and nothing else anywhere."""
        assert (self.code, self.out) == (2, ""), self
        assert "Traceback" not in self.err
        for part in parts:
            assert part in " ".join(self.err.split()), self.err
