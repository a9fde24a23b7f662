"""The blow: one impact of a striker on a wall or a rod, resolved by waves (B77 §2; St Venant 1867; Fischer 1959)."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from percuss.kernel_cache import ensure_cache

if TYPE_CHECKING:
    from percuss.blow.blow import Blow
    from percuss.blow.bodies import Rock, Rod, Target, Wall
    from percuss.blow.gauges import GaugeWaves
    from percuss.blow.parts import BlowOutcome, ContactInterval, Peak, Pulse
    from percuss.blow.stresses import AlongBody, StringState
    from percuss.blow.striking import EffectiveBlow, effective_blow, strike
    from percuss.blow.wave_history import Trace

ensure_cache()  # before anything here is compiled

__all__ = [
    "AlongBody",
    "Blow",
    "BlowOutcome",
    "ContactInterval",
    "EffectiveBlow",
    "GaugeWaves",
    "Peak",
    "Pulse",
    "Rock",
    "Rod",
    "StringState",
    "Target",
    "Trace",
    "Wall",
    "effective_blow",
    "strike",
]

_HOME = {
    "AlongBody": "stresses",
    "Blow": "blow",
    "EffectiveBlow": "striking",
    "BlowOutcome": "parts",
    "Peak": "parts",
    "Pulse": "parts",
    "Rock": "bodies",
    "Rod": "bodies",
    "ContactInterval": "parts",
    "StringState": "stresses",
    "Target": "bodies",
    "Trace": "wave_history",
    "Wall": "bodies",
    "GaugeWaves": "gauges",
    "effective_blow": "striking",
    "strike": "striking",
}


def __getattr__(name: str) -> object:
    """Each name from its module when it is first used: only `strike` loads the compiler."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
