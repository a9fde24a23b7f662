"""Figures that no hammer has: a slip of a unit or a digit gives an answer that is right, and absurd."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

from percuss.case.answers.facts import measured

if TYPE_CHECKING:
    from percuss.model import Machine, System
    from percuss.steady import Orbit
    from percuss.steady.self_excited.valve_cycle import ValveCycle


class _Rule(NamedTuple):
    value: Callable[[Any, Any], float | None]  # of the hammer and its cycle, in SI; None where there is none
    most: float
    sentence: str
    unit: str = ""


def _rate(hammer: Any, motion: Any) -> float:
    return float(motion.impacts / (motion.period * hammer.time_scale))


def _stress(hammer: Any, motion: Any) -> float:
    struck = hammer.bar.pieces[-1]
    return float(0.5 * struck.impedance / struck.area * motion.impact_velocity * hammer.speed_scale)


def _strokes(hammer: Any, motion: Any) -> float | None:
    valve = getattr(hammer, "valve", None)
    edges = [] if valve is None else [abs(port.behind) for port in valve.ports if port.behind]
    return float(motion.stroke / max(edges)) if edges else None


def _pressure(hammer: Any, motion: Any) -> float | None:
    pressure = getattr(hammer, "pressure", None)
    return None if pressure is None else float(pressure * motion.mean_pressure / 1e5)


_RULES = (
    _Rule(lambda hammer, motion: float(motion.impact_velocity * hammer.speed_scale), 20.0,
          "it strikes at {}, where percussive machines strike at 5 to 12 m/s", "m/s"),
    _Rule(_stress, 1e9, "ρ c v/2 = {} is beyond the yield stress of hardened steel, about 1 GPa", "Pa"),
    _Rule(_strokes, 10.0, "its stroke is {} times the way to its farthest port"),
    _Rule(_pressure, 500.0, "the pressure of its oil is {} bar, where hydraulic hammers have 100 to 250 bar"),
    _Rule(lambda hammer, motion: hammer.bar.mass * _rate(hammer, motion), 6e4,
          "mass times blow rate is {} kg/s, as of a piston of a tonne at 60 Hz"),
)  # fmt: skip
"""What no hammer has, by the most that is taken without a word."""


def doubts(hammer: System | Machine, motion: Orbit | ValveCycle | None) -> tuple[str, ...]:
    """What of a cycle in SI no hammer has, one sentence each."""
    built = hammer.is_si and hammer.bar is not None and hammer.body.is_free
    if motion is None or not built or not motion.impact_velocity > 0.0:
        return ()
    told = []
    for rule in _RULES:
        value = rule.value(hammer, motion)
        if value is not None and value > rule.most:
            told.append(rule.sentence.format(measured(value, rule.unit)))
    return tuple(f"hardly a hammer: {text}; check sizes and units" for text in told)
