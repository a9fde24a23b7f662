"""Closed-form steady motions: all phases, the orbit and its fields, admissibility, energy, rest, SI figures."""

from __future__ import annotations

from typing import TYPE_CHECKING

from percuss.lazy_names import lazy_names

if TYPE_CHECKING:
    from percuss.steady.figures import SIReport, si_report
    from percuss.steady.flight import Energy, Violation
    from percuss.steady.forced import Field
    from percuss.steady.multipliers import Reason
    from percuss.steady.orbit import Orbit
    from percuss.steady.oscillator import ModalState
    from percuss.steady.periodic.found_orbits import Drop, FoundOrbits
    from percuss.steady.periodic.periodic_orbit import PeriodicOrbit, parameter_column, time_rates
    from percuss.steady.periodic.search import orbit_near, orbits
    from percuss.steady.phases import grows, level
    from percuss.steady.recorded.force_record import ForceRecord
    from percuss.steady.recorded.recorded_valve import (
        Interval,
        PortAndDelay,
        Reading,
        RecordedSwitch,
        RecordedValve,
        recorded_together,
        recorded_valve,
    )
    from percuss.steady.resting.rest_cycles import FoundRestCycles, RestCycle, rest_cycles
    from percuss.steady.resting.rest_on_wall import Rest, rest_on_wall
    from percuss.steady.self_excited.blank_blow import BlankBlow, blank_blow
    from percuss.steady.self_excited.cycle_times import CycleTimes
    from percuss.steady.self_excited.margins import (
        Sensitivity,
        SlowPressure,
        ValveMargins,
        pressure_over,
        sensitivities,
        slow_pressure,
        valve_margins,
    )
    from percuss.steady.self_excited.self_switching import Obstacle, SelfExcited, self_excited_motion
    from percuss.steady.self_excited.valve_cycle import ValveCycle
    from percuss.steady.states import Drag, Nearest, SteadyStates, drag_of, greatest_drag, steady_states
    from percuss.steady.timed import TimedOrbit, TimedStates, timed_states

__all__, __getattr__, __dir__ = lazy_names(__name__, __file__)
