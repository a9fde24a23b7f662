"""Direct simulation: every impact of the bar from any start (B77 section 5; theory §§3, 8)."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from percuss.kernel_cache import ensure_cache

if TYPE_CHECKING:
    from percuss.simulate.balance import EnergyBalance
    from percuss.simulate.drawn import DISTRIBUTIONS
    from percuss.simulate.engine import Progress
    from percuss.simulate.ensemble import Ensemble, EnsembleProgress
    from percuss.simulate.events import Event, Events
    from percuss.simulate.machine.fed_trajectory import FedTrajectory
    from percuss.simulate.machine.machine_balance import MachineBalance
    from percuss.simulate.machine.machine_ensemble import MachineEnsemble, simulate_machines
    from percuss.simulate.machine.machine_events import MachineEvent, MachineEvents
    from percuss.simulate.machine.machine_running import run_machine
    from percuss.simulate.machine.machine_start import MachineStart
    from percuss.simulate.machine.machine_starts import MachineStarts
    from percuss.simulate.machine.machine_summary import MACHINE_OUTCOMES, STALLS, MachineCycle
    from percuss.simulate.machine.machine_trajectory import MachineTrajectory
    from percuss.simulate.many import simulate_many
    from percuss.simulate.running import run
    from percuss.simulate.start import Start
    from percuss.simulate.starts import Starts
    from percuss.simulate.stop import OUTCOMES, Stop
    from percuss.simulate.summary import Cycle, SISummary, Summary
    from percuss.simulate.trajectory import Trajectory

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
    "FedTrajectory",
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
    "DISTRIBUTIONS": "drawn",
    "OUTCOMES": "stop",
    "Cycle": "summary",
    "Ensemble": "ensemble",
    "EnsembleProgress": "ensemble",
    "Starts": "starts",
    "simulate_many": "many",
    "EnergyBalance": "balance",
    "Event": "events",
    "Events": "events",
    "MACHINE_OUTCOMES": "machine.machine_summary",
    "STALLS": "machine.machine_summary",
    "FedTrajectory": "machine.fed_trajectory",
    "MachineBalance": "machine.machine_balance",
    "MachineCycle": "machine.machine_summary",
    "MachineEnsemble": "machine.machine_ensemble",
    "simulate_machines": "machine.machine_ensemble",
    "MachineEvent": "machine.machine_events",
    "MachineEvents": "machine.machine_events",
    "MachineStart": "machine.machine_start",
    "MachineStarts": "machine.machine_starts",
    "MachineTrajectory": "machine.machine_trajectory",
    "run_machine": "machine.machine_running",
    "Progress": "engine",
    "SISummary": "summary",
    "Start": "start",
    "Stop": "stop",
    "Summary": "summary",
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
