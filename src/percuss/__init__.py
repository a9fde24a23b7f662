"""percuss: steady motions, stability, simulation and SI reports of elastic bars that strike.

>>> import percuss
>>> system = percuss.System(s=20.0, d=0.0048, restitution=0.6, load=percuss.Load.harmonic(0.9, 1.0))
>>> [orbit.admissible for orbit in percuss.steady_states(system).orbits]
[True, True]

Names are imported when they are first used, so that `import percuss` costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from percuss._version import __version__

if TYPE_CHECKING:
    from percuss.case import Case as Case
    from percuss.errors import PercussError as PercussError
    from percuss.model import Bar as Bar
    from percuss.model import Contact as Contact
    from percuss.model import Kept as Kept
    from percuss.model import Load as Load
    from percuss.model import Reversed as Reversed
    from percuss.model import System as System
    from percuss.model import Timed as Timed
    from percuss.simulate import Ensemble as Ensemble
    from percuss.simulate import Start as Start
    from percuss.simulate import Starts as Starts
    from percuss.simulate import Stop as Stop
    from percuss.simulate import Trajectory as Trajectory
    from percuss.simulate import run as run
    from percuss.simulate import simulate_many as simulate_many
    from percuss.stability import Stability as Stability
    from percuss.stability import stability_of as stability_of
    from percuss.stability import timed_stability as timed_stability
    from percuss.steady import Orbit as Orbit
    from percuss.steady import SteadyStates as SteadyStates
    from percuss.steady import rest_on_wall as rest_on_wall
    from percuss.steady import si_report as si_report
    from percuss.steady import steady_states as steady_states
    from percuss.steady import timed_states as timed_states

_ROOMS = {
    "Bar": "percuss.model",
    "Case": "percuss.case",
    "Contact": "percuss.model",
    "Ensemble": "percuss.simulate",
    "Kept": "percuss.model",
    "Load": "percuss.model",
    "Orbit": "percuss.steady",
    "PercussError": "percuss.errors",
    "Stability": "percuss.stability",
    "Reversed": "percuss.model",
    "Start": "percuss.simulate",
    "Starts": "percuss.simulate",
    "SteadyStates": "percuss.steady",
    "Stop": "percuss.simulate",
    "System": "percuss.model",
    "Timed": "percuss.model",
    "Trajectory": "percuss.simulate",
    "rest_on_wall": "percuss.steady",
    "run": "percuss.simulate",
    "si_report": "percuss.steady",
    "simulate_many": "percuss.simulate",
    "stability_of": "percuss.stability",
    "steady_states": "percuss.steady",
    "timed_stability": "percuss.stability",
    "timed_states": "percuss.steady",
}

__all__ = ["__version__", *_ROOMS]


def __getattr__(name: str) -> object:
    if name not in _ROOMS:
        raise AttributeError(f"module 'percuss' has no attribute {name!r}")
    value = getattr(import_module(_ROOMS[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
