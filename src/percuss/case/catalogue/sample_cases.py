"""The catalogue: sample cases of real kinds of hammers, and of structures, ready to run and to be changed.

Sizes, rates and blow energies are typical figures of public data sheets; the force histories are synthetic, made so
that the hammer runs at those figures. What most of them strike is described too, with the sources of its sizes. Every
case is a commented TOML file in ``machines/``.
"""

from __future__ import annotations

import os
import tempfile
from cmath import rect
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING

from percuss.atomic_write import write_whole
from percuss.errors import CaseError, ParameterError, did_you_mean

if TYPE_CHECKING:
    from percuss.case.case import Case


# ---- The catalogue: sample cases of real kinds of hammers, and of structures, ready to run and to be changed

HISTORY_FILE = "drifter_pressure.csv"  # the name under which the sample history lies beside its case

MODES_FILE = "beam_modes.csv"  # the name of the sample table of modes beside its case

_FOLDER = "machines"


@dataclass(frozen=True)
class SampleMachine:
    """A sample case and the figures that it is meant to meet: mass in kg, blow rate in Hz, blow energy in J.

    `valve` says that its piston switches the load, for which `percuss machine` answers;
    `from_rest` what else a simulation from rest ends in, where it is not the motion with these figures.
    """

    name: str
    title: str
    mass: float
    blow_rate: float
    blow_energy: float
    valve: bool = False
    from_rest: str = ""

    @property
    def text(self) -> str:
        """The commented case file."""
        return machine_text(self.name)


MACHINES: tuple[SampleMachine, ...] = (
    SampleMachine("hydraulic-drifter", "Hydraulic drifter, measured history", 5.0, 60.0, 310.0),
    SampleMachine("heavy-drifter", "Heavy hydraulic drifter", 6.5, 42.0, 271.0),
    SampleMachine("stepped-drifter", "Hydraulic drifter with a stepped piston", 6.5, 50.0, 300.0),
    SampleMachine("drill-string", "Drill string under its feed: drifter, two rods, bit", 4.85, 60.0, 300.0),
    SampleMachine("mini-breaker", "Hydraulic breaker for a mini excavator", 4.0, 17.5, 180.0),
    SampleMachine("heavy-breaker", "Heavy hydraulic breaker", 140.0, 6.7, 5700.0),
    SampleMachine("dth-4-inch", "4-inch down-the-hole hammer", 7.4, 27.0, 300.0),
    SampleMachine("dth-6-inch", "6-inch down-the-hole hammer", 23.0, 30.0, 1150.0),
    SampleMachine("pneumatic-jackleg", "Pneumatic jackleg drill", 2.0, 33.0, 60.0),
    SampleMachine("pile-hammer", "Hydraulic pile hammer", 9000.0, 1.0, 106e3),
    SampleMachine("laboratory-striker", "Laboratory striker on a long bar", 0.6, 20.0, 7.5, from_rest="chatter/1"),
    SampleMachine("valve-breaker", "Hydraulic breaker with its valve, lossless oil", 88.8, 9.45, 3750.0, valve=True),
    SampleMachine("valve-drifter", "Hydraulic drifter with its valve, lossless oil", 5.05, 61.2, 301.0, valve=True),
    SampleMachine("oil-drifter", "Hydraulic drifter with oil that flows", 5.05, 68.1, 277.0, valve=True),
    SampleMachine("oil-breaker", "Hydraulic breaker with oil that flows", 88.8, 8.99, 3292.0, valve=True),
)


@dataclass(frozen=True)
class SampleStructure:
    """A sample case of a structure that something holds and that strikes a stop."""

    name: str
    title: str

    @property
    def text(self) -> str:
        """The commented case file."""
        return machine_text(self.name)


STRUCTURES: tuple[SampleStructure, ...] = (
    SampleStructure("stopped-oscillator", "Oscillator with a stop, Budd and Dux 1994, dimensionless"),
    SampleStructure("stopped-beam", "Cantilever with a stop, from a table of its modes"),
)


def sample_names() -> list[str]:
    """The names of all machines and structures."""
    return [*(machine.name for machine in MACHINES), *(structure.name for structure in STRUCTURES)]


def is_sample(name: str) -> bool:
    """Whether the catalogue has a machine or a structure of this name."""
    return name in sample_names()


def machine_text(name: str) -> str:
    """The commented case file of a machine, or of a structure."""
    if not isinstance(name, str):
        raise ParameterError("name", name, "the name of a machine, such as 'mini-breaker'", "see MACHINES")
    if not is_sample(name):
        known = sample_names()
        remedy = did_you_mean(name, known) or "see 'percuss machines'"
        raise CaseError(name, "", None, f"no machine of this name; the catalogue has {', '.join(known)}", remedy)
    return _file(f"{name}.toml").read_text(encoding="utf-8")


def _file(name: str) -> Path:
    return Path(str(resources.files("percuss.case.catalogue"))) / _FOLDER / name


def file_beside(name: str) -> str | None:
    """The name of the file that a sample's case names; None for most of them."""
    text = machine_text(name)
    return next((file for file in (HISTORY_FILE, MODES_FILE) if file in text), None)


def uses_history(name: str) -> bool:
    """Whether a machine's case names the sample history."""
    return HISTORY_FILE in machine_text(name)


def load_case(name: str) -> Case:
    """The case of a machine or a structure of the catalogue, with its history made on the way.

    Raises
    ------
    CaseError
        When the catalogue has none of this name.

    Examples
    --------
    >>> load_case("pile-hammer").title
    'Hydraulic pile hammer'
    """
    from percuss.case.case import Case

    text = machine_text(name)
    if not uses_history(name):
        return Case.from_text(text, file=name, folder=_file("") if MODES_FILE in text else Path())
    with tempfile.TemporaryDirectory(prefix="percuss-") as folder:
        write_history(Path(folder) / HISTORY_FILE)
        case = Case.from_text(text, file=name, folder=Path(folder))
        case.system()  # read the history while it is there; the case keeps what it found
    return case


def write_beside(name: str, path: str | os.PathLike[str]) -> None:
    """Write the file that a sample's case names, `file_beside`."""
    if uses_history(name):
        write_history(path)
    else:
        write_whole(path, _file(MODES_FILE).read_text(encoding="utf-8"))


def write_history(path: str | os.PathLike[str]) -> None:
    """Write the sample history of the drifter: 40 cycles of its net pressure at 50 kHz on 6.5 cm², 310 J at 60 Hz."""
    from percuss.case.catalogue.sample_history import write_sample_history  # numpy is for what computes

    shape = (rect(1.0, 0.0), rect(2.6, 0.0), rect(0.5, 1.2), rect(0.25, -1.0))
    write_sample_history(path, pressure_coefficients=[6.197e6 * p for p in shape], frequency=60.0)
