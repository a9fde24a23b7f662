"""Case files: one TOML description of a run, the catalogue of sample cases, and the one dispatcher.

A case is read with `Case.read`, answered with `steady_answer` or `simulation_answer`. The names are imported when first
used, so that the catalogue can be listed without loading anything numerical.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from percuss.case.answer import OrbitAnswer, PeriodAnswer, SteadyAnswer, steady_answer
    from percuss.case.case import Case
    from percuss.case.catalogue import MACHINES, Machine, load_case
    from percuss.case.exploring import basins_job_of, experiment_job_of, sweep_job_of
    from percuss.case.family import CaseFamily
    from percuss.case.problems import CaseErrors
    from percuss.case.running import Simulation
    from percuss.case.simulation import SimulationAnswer, resumed_answer, simulation_answer

__all__ = [
    "MACHINES",
    "Case",
    "CaseErrors",
    "CaseFamily",
    "Machine",
    "OrbitAnswer",
    "PeriodAnswer",
    "Simulation",
    "SimulationAnswer",
    "SteadyAnswer",
    "basins_job_of",
    "experiment_job_of",
    "load_case",
    "resumed_answer",
    "simulation_answer",
    "steady_answer",
    "sweep_job_of",
]

_HOME = {
    "MACHINES": "catalogue",
    "Case": "case",
    "CaseErrors": "problems",
    "CaseFamily": "family",
    "Machine": "catalogue",
    "OrbitAnswer": "answer",
    "PeriodAnswer": "answer",
    "Simulation": "running",
    "SimulationAnswer": "simulation",
    "SteadyAnswer": "answer",
    "basins_job_of": "exploring",
    "experiment_job_of": "exploring",
    "load_case": "catalogue",
    "resumed_answer": "simulation",
    "simulation_answer": "simulation",
    "steady_answer": "answer",
    "sweep_job_of": "exploring",
}


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
