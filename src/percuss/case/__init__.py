"""Case files: one TOML description of a run, the catalogue of sample cases, and the one dispatcher.

A case is read with `Case.read`, answered with `steady_answer` or `simulation_answer`. The names are imported when first
used, so that the catalogue can be listed without loading anything numerical.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from percuss.lazy_names import lazy_names

if TYPE_CHECKING:
    from percuss.case.answers.blows.blow_answer import BlowAnswer, MeasuredGauge, blow_answer, measured_gauge
    from percuss.case.answers.blows.repeated_answer import RepeatedAnswer, repeated_answer
    from percuss.case.answers.blows.valve_waves_answer import ValveWavesAnswer, valve_waves_answer
    from percuss.case.answers.blows.waves_answer import WavesAnswer, waves_answer
    from percuss.case.answers.exploring.best_answer import BestAnswer, best_answer
    from percuss.case.answers.exploring.comparison import Comparison, compare
    from percuss.case.answers.exploring.design import DesignAnswer, DesignPlane, Limit, design
    from percuss.case.answers.exploring.diagram_answer import diagram_answer, diagram_job_of
    from percuss.case.answers.exploring.exploration import basins_job_of, experiment_job_of, sweep_job_of
    from percuss.case.answers.exploring.identify import (
        DataSheetAnswer,
        IdentifyAnswer,
        data_sheet_answer,
        identify,
        parsed_unknown,
    )
    from percuss.case.answers.exploring.orbits_answer import branch_answer, orbits_answer, rest_cycles_answer
    from percuss.case.answers.exploring.point_curves_answer import point_curves_answer
    from percuss.case.answers.exploring.reach_answer import reach_answer
    from percuss.case.answers.exploring.tolerance import (
        ToleranceAnswer,
        standard_tolerances,
        tolerance,
        tolerance_job,
        uncertainty_of,
    )
    from percuss.case.answers.machine_answer import MachineAnswer, machine_answer
    from percuss.case.answers.recorded_answer import RecordedAnswer, recorded_answer
    from percuss.case.answers.simulation_answer import SimulationAnswer, resumed_answer, simulation_answer
    from percuss.case.answers.steady_answer import CaseReach, OrbitAnswer, PeriodAnswer, SteadyAnswer, steady_answer
    from percuss.case.case import Case
    from percuss.case.catalogue.sample_cases import MACHINES, SampleMachine, load_case
    from percuss.case.file_format.reading import CaseErrors
    from percuss.case.file_format.start_and_simulation import Simulation
    from percuss.case.parameters.case_family import CaseFamily
    from percuss.case.parameters.spans import Span, parsed_tolerance

__all__, __getattr__, __dir__ = lazy_names(__name__, __file__)
