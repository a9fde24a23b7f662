"""Direct simulation: every impact of the bar from any start (B77 section 5; theory §§3, 8)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from percuss.lazy_names import lazy_names
from percuss.mechanics.kernel_cache import ensure_cache

if TYPE_CHECKING:
    from percuss.simulate.engine import Progress
    from percuss.simulate.ensemble import Ensemble, EnsembleProgress, simulate_many
    from percuss.simulate.events import STALLS, Event, Events, MotionCycle, SISummary, Summary
    from percuss.simulate.start import DISTRIBUTIONS, Start, Starts
    from percuss.simulate.stop import OUTCOMES, Stop
    from percuss.simulate.trajectory import EnergyBalance, PoincareSection, Trajectory, run

ensure_cache()  # before anything here is compiled

__all__, __getattr__, __dir__ = lazy_names(__name__, __file__)
