"""Direct simulation: every impact of the bar from any start (B77 section 5; theory §§3, 8)."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from percuss.kernel_cache import ensure_cache

if TYPE_CHECKING:
    from percuss.simulate.engine import Progress
    from percuss.simulate.events import Cycle, Event, Events, SISummary, Summary
    from percuss.simulate.machine.machine_events import (
        MACHINE_OUTCOMES,
        STALLS,
        MachineCycle,
        MachineEvent,
        MachineEvents,
    )
    from percuss.simulate.machine.machine_running import MachineEnsemble, run_machine, simulate_machines
    from percuss.simulate.machine.machine_start import MachineStart, MachineStarts
    from percuss.simulate.machine.machine_trajectory import MachineTrajectory
    from percuss.simulate.machine.mechanism import MachineBalance
    from percuss.simulate.running import run, simulate_many
    from percuss.simulate.simulated_motion import EnergyBalance
    from percuss.simulate.start import DISTRIBUTIONS, Start, Starts
    from percuss.simulate.stop import OUTCOMES, Stop
    from percuss.simulate.trajectory import Ensemble, EnsembleProgress, Trajectory

ensure_cache()  # before anything here is compiled

__all__ = [
    "DISTRIBUTIONS",
    "MACHINE_OUTCOMES",
    "OUTCOMES",
    "STALLS",
    "Cycle",
    "EnergyBalance",
    "Ensemble",
    "EnsembleProgress",
    "Event",
    "Events",
    "MachineBalance",
    "MachineCycle",
    "MachineEnsemble",
    "MachineEvent",
    "MachineEvents",
    "MachineStart",
    "MachineStarts",
    "MachineTrajectory",
    "Progress",
    "SISummary",
    "Start",
    "Starts",
    "Stop",
    "Summary",
    "Trajectory",
    "run",
    "run_machine",
    "simulate_machines",
    "simulate_many",
]

_HOME = {
    "DISTRIBUTIONS": "start",
    "OUTCOMES": "stop",
    "Cycle": "events",
    "Ensemble": "trajectory",
    "EnsembleProgress": "trajectory",
    "Starts": "start",
    "simulate_many": "running",
    "EnergyBalance": "simulated_motion",
    "Event": "events",
    "Events": "events",
    "MACHINE_OUTCOMES": "machine.machine_events",
    "STALLS": "machine.machine_events",
    "MachineBalance": "machine.mechanism",
    "MachineCycle": "machine.machine_events",
    "MachineEnsemble": "machine.machine_running",
    "simulate_machines": "machine.machine_running",
    "MachineEvent": "machine.machine_events",
    "MachineEvents": "machine.machine_events",
    "MachineStart": "machine.machine_start",
    "MachineStarts": "machine.machine_start",
    "MachineTrajectory": "machine.machine_trajectory",
    "run_machine": "machine.machine_running",
    "Progress": "engine",
    "SISummary": "events",
    "Start": "start",
    "Stop": "stop",
    "Summary": "events",
    "Trajectory": "trajectory",
    "run": "running",
}


def __getattr__(name: str) -> object:
    """Each name from its module when it is first used: only `run` loads the compiler."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
