"""The blow: one impact of a striker on a wall or a rod, resolved by waves (B77 §2; St Venant 1867; Fischer 1959)."""

from __future__ import annotations

from percuss.blow.parts import Outcome, Peak, Pulse, Spell
from percuss.blow.target import Rock, Rod, Target, Wall

__all__ = ["Outcome", "Peak", "Pulse", "Rock", "Rod", "Spell", "Target", "Wall"]
