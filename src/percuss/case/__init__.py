"""Case files: one TOML description of a run, the catalogue of sample cases, and the one dispatcher.

A case is read with `Case.read`, answered with `steady_answer` or `simulation_answer`. The names are imported when first
used, so that the catalogue can be listed without loading anything numerical.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from percuss.case.answers.best_answer import BestAnswer, Span, best_answer
    from percuss.case.answers.blow_answer import BlowAnswer, MeasuredGauge, blow_answer
    from percuss.case.answers.diagram_answer import diagram_answer, diagram_job_of
    from percuss.case.answers.exploration import basins_job_of, experiment_job_of
    from percuss.case.answers.machine_answer import MachineAnswer, machine_answer
    from percuss.case.answers.measured_gauge import measured_gauge
    from percuss.case.answers.orbits_answer import branch_answer, orbits_answer, rest_branch_answer, rest_cycles_answer
    from percuss.case.answers.point_curves_answer import point_curves_answer
    from percuss.case.answers.reach_answer import reach_answer
    from percuss.case.answers.reach_in_words import CaseReach
    from percuss.case.answers.recorded_answer import RecordedAnswer, recorded_answer
    from percuss.case.answers.simulation_answer import (
        MachineMotion,
        SimulationAnswer,
        machine_motion,
        resumed_answer,
        simulation_answer,
    )
    from percuss.case.answers.steady_answer import OrbitAnswer, PeriodAnswer, SteadyAnswer, steady_answer
    from percuss.case.answers.structure_answer import StructureAnswer, structure_answer
    from percuss.case.answers.sweep_jobs import sweep_job_of
    from percuss.case.answers.waves_answer import WavesAnswer, waves_answer
    from percuss.case.case import Case
    from percuss.case.catalogue.sample_cases import MACHINES, SampleMachine, load_case
    from percuss.case.file_format.reading import CaseErrors
    from percuss.case.file_format.start_and_simulation import Simulation
    from percuss.case.parameters.case_family import CaseFamily

__all__ = [
    "MACHINES",
    "BestAnswer",
    "BlowAnswer",
    "Case",
    "CaseErrors",
    "CaseFamily",
    "CaseReach",
    "MachineAnswer",
    "MachineMotion",
    "MeasuredGauge",
    "OrbitAnswer",
    "PeriodAnswer",
    "RecordedAnswer",
    "SampleMachine",
    "Simulation",
    "SimulationAnswer",
    "Span",
    "SteadyAnswer",
    "StructureAnswer",
    "WavesAnswer",
    "basins_job_of",
    "best_answer",
    "blow_answer",
    "branch_answer",
    "diagram_answer",
    "diagram_job_of",
    "experiment_job_of",
    "load_case",
    "machine_answer",
    "machine_motion",
    "measured_gauge",
    "orbits_answer",
    "point_curves_answer",
    "reach_answer",
    "recorded_answer",
    "rest_branch_answer",
    "rest_cycles_answer",
    "resumed_answer",
    "simulation_answer",
    "steady_answer",
    "structure_answer",
    "sweep_job_of",
    "waves_answer",
]

_HOME = {
    "MACHINES": "catalogue.sample_cases",
    "BestAnswer": "answers.best_answer",
    "BlowAnswer": "answers.blow_answer",
    "Case": "case",
    "CaseErrors": "file_format.reading",
    "CaseFamily": "parameters.case_family",
    "CaseReach": "answers.reach_in_words",
    "SampleMachine": "catalogue.sample_cases",
    "MachineAnswer": "answers.machine_answer",
    "MachineMotion": "answers.simulation_answer",
    "MeasuredGauge": "answers.blow_answer",
    "OrbitAnswer": "answers.steady_answer",
    "PeriodAnswer": "answers.steady_answer",
    "RecordedAnswer": "answers.recorded_answer",
    "Simulation": "file_format.start_and_simulation",
    "SimulationAnswer": "answers.simulation_answer",
    "Span": "answers.best_answer",
    "SteadyAnswer": "answers.steady_answer",
    "StructureAnswer": "answers.structure_answer",
    "WavesAnswer": "answers.waves_answer",
    "basins_job_of": "answers.exploration",
    "best_answer": "answers.best_answer",
    "blow_answer": "answers.blow_answer",
    "branch_answer": "answers.orbits_answer",
    "diagram_answer": "answers.diagram_answer",
    "diagram_job_of": "answers.diagram_answer",
    "experiment_job_of": "answers.exploration",
    "load_case": "catalogue.sample_cases",
    "machine_answer": "answers.machine_answer",
    "machine_motion": "answers.simulation_answer",
    "measured_gauge": "answers.measured_gauge",
    "orbits_answer": "answers.orbits_answer",
    "point_curves_answer": "answers.point_curves_answer",
    "reach_answer": "answers.reach_answer",
    "recorded_answer": "answers.recorded_answer",
    "rest_branch_answer": "answers.orbits_answer",
    "rest_cycles_answer": "answers.orbits_answer",
    "resumed_answer": "answers.simulation_answer",
    "simulation_answer": "answers.simulation_answer",
    "steady_answer": "answers.steady_answer",
    "structure_answer": "answers.structure_answer",
    "sweep_job_of": "answers.sweep_jobs",
    "waves_answer": "answers.waves_answer",
}


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
