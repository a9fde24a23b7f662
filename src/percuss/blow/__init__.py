"""The blow: one impact of a striker on a wall or a rod, resolved by waves (B77 §2; St Venant 1867; Fischer 1959)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from percuss.lazy_names import lazy_names
from percuss.mechanics.kernel_cache import ensure_cache

if TYPE_CHECKING:
    from percuss.blow.blow import Blow, BlowBalance
    from percuss.blow.bodies import Feed, Joint, Rock, Rod, Target, Wall
    from percuss.blow.drilling import BlowsOneByOne, Drilling, JointTurns, bit_contacts, blows_one_by_one, joint_turns
    from percuss.blow.fields import AlongBody, CellsOverTime, EnergyOverTime, ForceEnvelope, StringState
    from percuss.blow.figures import BlowOutcome, ContactInterval, Fineness, Peak, Pulse
    from percuss.blow.gauges import GaugeWaves
    from percuss.blow.steel_fatigue import Fatigue, SectionFatigue, Steel, cycles_of, fatigue
    from percuss.blow.striking import EffectiveBlow, effective_blow, strike, strike_again
    from percuss.blow.wave_history import Trace

ensure_cache()  # before anything here is compiled

__all__, __getattr__, __dir__ = lazy_names(__name__, __file__)
