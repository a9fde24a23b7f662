"""Direct simulation: every impact of the bar from any start (B77 section 5; theory §§3, 8)."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from percuss.kernel_cache import ensure_cache

if TYPE_CHECKING:
    from percuss.simulate.engine import Progress
    from percuss.simulate.ensemble import Ensemble, EnsembleProgress, simulate_many
    from percuss.simulate.events import STALLS, Cycle, Event, Events, SISummary, Summary
    from percuss.simulate.simulated_motion import EnergyBalance
    from percuss.simulate.start import DISTRIBUTIONS, Start, Starts
    from percuss.simulate.stop import OUTCOMES, Stop
    from percuss.simulate.trajectory import Trajectory, run

ensure_cache()  # before anything here is compiled

__all__ = [
    "DISTRIBUTIONS",
    "OUTCOMES",
    "STALLS",
    "Cycle",
    "EnergyBalance",
    "Ensemble",
    "EnsembleProgress",
    "Event",
    "Events",
    "Progress",
    "SISummary",
    "Start",
    "Starts",
    "Stop",
    "Summary",
    "Trajectory",
    "run",
    "simulate_many",
]

_HOME = {
    "DISTRIBUTIONS": "start",
    "OUTCOMES": "stop",
    "STALLS": "events",
    "Cycle": "events",
    "EnergyBalance": "simulated_motion",
    "Ensemble": "ensemble",
    "EnsembleProgress": "ensemble",
    "Event": "events",
    "Events": "events",
    "Progress": "engine",
    "SISummary": "events",
    "Start": "start",
    "Starts": "start",
    "Stop": "stop",
    "Summary": "events",
    "Trajectory": "trajectory",
    "run": "trajectory",
    "simulate_many": "ensemble",
}


def __getattr__(name: str) -> object:
    """Each name from its module when it is first used: only `run` loads the compiler."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
