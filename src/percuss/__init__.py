"""percuss: steady motions, stability, simulation and SI reports of elastic bars that strike.

>>> import percuss
>>> system = percuss.System(s=20.0, d=0.0048, restitution=0.6, load=percuss.Load.harmonic(0.9, 1.0))
>>> [orbit.admissible for orbit in percuss.steady_states(system).orbits]
[True, True]

Names are imported when they are first used, so that `import percuss` costs nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from percuss.lazy_names import lazy_names, lend

if TYPE_CHECKING:
    from percuss._version import __version__
    from percuss.case import Case
    from percuss.errors import PercussError
    from percuss.model import Bar, Contact, Kept, Load, Reversed, System, Timed
    from percuss.simulate import Ensemble, Start, Starts, Stop, Trajectory, run, simulate_many
    from percuss.stability import Stability, stability_of, timed_stability
    from percuss.steady import Orbit, SteadyStates, rest_on_wall, si_report, steady_states, timed_states

__all__, __getattr__, __dir__ = lazy_names(__name__, __file__)
lend("follow", "percuss.explore")
