"""The pressure of a supply over a flight of the piston that draws from it."""

from __future__ import annotations

from percuss.steady.self_excited.piston_records import Piston, Segment
from percuss.steady.self_excited.pressed_flight import PressedFlight

__all__ = ["lowest_pressure", "pressure_at", "pressure_extremes", "pressure_integral"]


def pressure_at(segment: Segment, piston: Piston, t: float) -> float:
    """The pressure at a time after the begin of a segment."""
    supply = piston.valve.supply
    assert supply is not None
    came = segment.flight.at(t)[0] - segment.flight.x
    return segment.pressure + (supply.flow * t + piston.drawing(segment.state) * came) / supply.compliance


def pressure_extremes(segment: Segment, piston: Piston) -> tuple[float, float]:
    """The least and the greatest pressure of a segment: at its ends, or where the piston draws what the pump gives."""
    times = [0.0, segment.duration]
    drawing, supply = piston.drawing(segment.state), piston.valve.supply
    assert supply is not None
    if isinstance(segment.flight, PressedFlight):
        for time in segment.flight.times_at_speed(-supply.flow / drawing):
            if time >= segment.duration:
                break
            times.append(time)
    found = [pressure_at(segment, piston, t) for t in times]
    return min(found), max(found)


def lowest_pressure(segment: Segment, piston: Piston) -> float:
    """The least pressure of a segment; a lower bound of it where that is above 0."""
    supply, drawing = piston.valve.supply, piston.drawing(segment.state)
    assert supply is not None
    if not isinstance(segment.flight, PressedFlight):
        return segment.pressure
    way = segment.flight.x if drawing > 0.0 else segment.duration * segment.flight.fastest
    least = segment.pressure - abs(drawing) * way / supply.compliance
    return least if least > 0.0 else pressure_extremes(segment, piston)[0]


def pressure_integral(segment: Segment, piston: Piston) -> float:
    """The integral of the pressure over a segment, by that of the equation of motion."""
    supply, t, flight = piston.valve.supply, segment.duration, segment.flight
    assert supply is not None
    found = segment.pressure * t + 0.5 * supply.flow * t * t / supply.compliance
    if not isinstance(flight, PressedFlight):
        return found
    came, faster = segment.behind - flight.x, segment.velocity - flight.v
    way = (flight.acceleration * t + 0.5 * flight.ramp * t * t - faster - flight.drag * came) / flight.stiffness
    return found + piston.drawing(segment.state) / supply.compliance * way
