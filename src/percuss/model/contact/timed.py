"""The law of a blow that takes time: what one blow computed by waves means for the bar as a whole."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from percuss.errors import ParameterError
from percuss.model.checks import choice, count, finite, non_negative, positive, unit_interval

Advance = Literal["kept", "pushed back", "residual penetration"]

ADVANCES: tuple[Advance, ...] = ("kept", "pushed back", "residual penetration")
"""Where the impact plane is at the next blow: where the blow put the rod, where it was, or deeper by what the rock does
not give back."""

_MOST_CONTACTS = 10**6
_ONE_BLOW = (
    "a striker that still moves forward after the blow catches up with the rod again: on an endless rod in steps that "
    "never end, with the velocity falling like (−R)^n; such a blow has no duration. Take a rod of greater impedance "
    "than the striker's, or resolve the contacts by waves"
)


@dataclass(frozen=True)
class Timed:
    """A blow of one contact, begun without ringing, told by its restitution, its duration and its force's centroid.

    B77's law lets the blow take no time. To first order in its duration over the load's period three numbers of the
    blow are missing there: when its force acts on average, how far the load pushes meanwhile, and how far the plane of
    impact moves on from blow to blow. With the instant of the impact at the force's centroid, the impulse J and the
    mean velocity V of the striker that would be reached there without the blow,

        J = (1 + R) (V − e p),    e = 2 t_J − t_c,    a = A J,

    as a load p adds p (t_c − t_J) to the impulse per 1 + R, and p t_J to the velocity at the contact's start; a drag
    multiplies 1 + R by 1 + δ. The rest is the flight of a rigid bar. Not covered: several contacts, and a ringing that
    is left at the next blow.

    Parameters
    ----------
    restitution
        R, 0 to 1: mean velocity of the striker after the blow over that before it, its sign turned (dimensionless).
    duration, force_centroid
        t_c and t_J, from the start of the contact to its end and to the centroid of its force, in radians of the load.
    advance_per_impulse
        A, by which the plane of impact moves on from blow to blow per unit of impulse, dimensionless: 1/Z_rod for an
        endless rod that stays where the blow puts it, 0 for a wall or a tool that is pushed back.
    ringing_share
        Share of the kinetic energy before the blow that is left in the striker as ringing, 0 to 1.
    contacts, law
        Contacts of the blow, of which the law holds for one; ``"b77-blow"``, or ``"b77-tau"`` of a uniform bar.

    Raises
    ------
    ParameterError
        For numbers out of range; for R < 0 with the reason why there is no such law.

    Examples
    --------
    >>> law = Timed.of_uniform_bar(s=20.0, restitution=0.6)
    >>> law.duration, law.force_centroid, round(law.advance_per_impulse, 6), law.arm
    (0.1, 0.05, 0.0125, 0.0)
    >>> drifter = Timed(0.4153, duration=0.06692, force_centroid=0.02808, advance_per_impulse=1.0 / 101.1)
    >>> print(f"{drifter.arm:.5f}")
    -0.01076
    """

    restitution: float
    duration: float = 0.0
    force_centroid: float = 0.0
    advance_per_impulse: float = 0.0
    ringing_share: float = 0.0
    contacts: int = 1
    law: str = "b77-blow"

    def __post_init__(self) -> None:
        accepted = "a number from 0 to 1: a blow gives −1 to 1, and no law of one contact holds below 0"
        r = finite("restitution", self.restitution, accepted)
        if r < 0.0:
            raise ParameterError("restitution", self.restitution, accepted, _ONE_BLOW)
        duration = non_negative("duration", self.duration)
        centroid = non_negative("force_centroid", self.force_centroid)
        if centroid > duration:
            raise ParameterError("force_centroid", centroid, f"a time during the contact, 0 to {duration:.6g}")
        checked = {
            "restitution": unit_interval("restitution", r),
            "duration": duration,
            "force_centroid": centroid,
            "advance_per_impulse": non_negative("advance_per_impulse", self.advance_per_impulse),
            "ringing_share": unit_interval("ringing_share", self.ringing_share),
            "contacts": count("contacts", self.contacts, most=_MOST_CONTACTS),
        }
        choice("law", self.law, "b77-tau", "b77-blow")
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    @classmethod
    def of_uniform_bar(cls, s: float, restitution: float, advance: str = "kept") -> Timed:
        """The law ``b77-tau``: the blow of a uniform bar, one round trip of its waves, on a rod or a wall.

        The force is constant for 2/s, nothing rings, and a rod that gives the restitution R has 1/Z = (1 − R)/((1 + R)
        s), so that it moves on by (1 − R) V/s (St Venant 1867; Fischer 1959). Advance ``"kept"``: the rod stays where
        the blow puts it; ``"pushed back"``: it returns before the next one. ParameterError for values out of range, and
        for what a uniform bar on a rod cannot tell: a residual penetration.
        """
        s, r = positive("s", s), unit_interval("restitution", restitution)
        choice("advance", advance, "kept", "pushed back")
        mobility = (1.0 - r) / ((1.0 + r) * s) if advance == "kept" else 0.0
        return cls(r, 2.0 / s, 1.0 / s, mobility, law="b77-tau")

    @property
    def arm(self) -> float:
        """e = 2 t_J − t_c: what a unit load during the contact takes from the blow, as a velocity; in radians."""
        return 2.0 * self.force_centroid - self.duration

    @property
    def after_centroid(self) -> float:
        """t_c − t_J: from the centroid of the force to the end of the contact, in radians."""
        return self.duration - self.force_centroid

    def velocity(self, impulse: float, force: float, d: float = 0.0) -> float:
        """V at the force's centroid of a blow with this impulse under the load `force`: J/[(1 + R)(1 + δ)] + e p."""
        return finite("impulse", impulse) / self._momentum(d) + self.arm * finite("force", force)

    def impulse(self, velocity: float, force: float, d: float = 0.0) -> float:
        """J of a blow with V at the force's centroid under the load `force`: (1 + R)(1 + δ)(V − e p)."""
        return self._momentum(d) * (finite("velocity", velocity) - self.arm * finite("force", force))

    def _momentum(self, d: float) -> float:
        """(1 + R)(1 + δ), with what the drag changes during the contact, when the bar is slow."""
        # External damping lets every wave fade by exp(−dt/2). To first order a uniform bar on a rod or a wall has δ =
        # (1 + R) d t_J/4, which stands for others, too.
        momentum = 1.0 + self.restitution
        return momentum * (1.0 + 0.25 * momentum * non_negative("d", d) * self.force_centroid)

    def steady_impulse(self, mean: float, period: float, d: float) -> float:
        """J of a steady motion: p_0 T, less what the drag d takes over the advance, d A J."""
        given = finite("mean", mean) * positive("period", period)
        return given / (1.0 + non_negative("d", d) * self.advance_per_impulse)

    @property
    def delivered_share(self) -> float:
        """Share of the kinetic energy before the blow that goes into what is struck: all but rebound and ringing."""
        return max(0.0, 1.0 - self.restitution**2 - self.ringing_share)

    def ringing_left(self, rate: float, period: float) -> float:
        """Ringing at the next blow, as a speed over that of the blow: √share times exp(−rate T).

        `rate`: by which the slowest elastic mode dies out, d_1/2, per radian; `period`: T, in radians.
        """
        return math.sqrt(self.ringing_share) * math.exp(-non_negative("rate", rate) * positive("period", period))

    def __str__(self) -> str:
        return (
            f"{self.law}: restitution R = {self.restitution:.4g}, contact {self.duration:.4g} rad, centroid of the "
            f"force after {self.force_centroid:.4g} rad, advance {self.advance_per_impulse:.4g} per impulse"
        )
