"""Fatigue of striker and rod by blows like one: cycles of stress by rainflow, S–N line, mean stress, damage."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from percuss.blow.blow import Blow
from percuss.blow.bodies import Rod
from percuss.errors import ParameterError, extra_package
from percuss.model import SizedBody
from percuss.model.checks import Array, count, finite, instance, mapping, numbers, positive

# ---- The S–N line of a steel, mean stress and notch, and the damage of a history that repeats

_LIMIT = 0.40
"""Fatigue limit of forged and case-hardened steel in tension and compression, over its strength (FKM guideline)."""
_AT_THOUSAND = 0.75
"""Amplitude that steel bears a thousand times in tension and compression, over its strength (Juvinall 1967)."""
KNEE = 1e6
"""Cycles at which the line reaches the fatigue limit (FKM guideline, Shigley)."""


@dataclass(frozen=True)
class Steel:
    """What a steel bears: its S–N line for amplitudes about 0, of an unnotched rod in tension and compression.

    The line is N = knee (fatigue_limit/σ)^slope above the fatigue limit. Below it, in a history that exceeds it
    elsewhere, the slope is 2 slope − 1 (Haibach 1970).

    Parameters
    ----------
    ultimate
        Tensile strength, Pa.
    fatigue_limit
        Amplitude, Pa, below the strength; None for 0.40 of it, as the FKM guideline has it for forged steel.
    slope
        Dimensionless, at least 1; None for the line from 0.75 of the strength at 1000 cycles (Juvinall 1967).
    knee
        Cycles at which the line reaches the limit, more than 1000.

    Examples
    --------
    >>> steel = Steel(900e6)
    >>> steel.fatigue_limit, round(steel.slope, 2)
    (360000000.0, 10.99)
    >>> steel.equivalent(np.array([300e6, 300e6]), np.array([450e6, -450e6])).tolist()
    [600000000.0, 300000000.0]
    """

    ultimate: float
    fatigue_limit: float = None  # type: ignore[assignment]  # a number from the beginning on
    slope: float = None  # type: ignore[assignment]
    knee: float = KNEE

    def __post_init__(self) -> None:
        ultimate, knee = positive("ultimate", self.ultimate), _at_least("knee", self.knee, 1001.0)
        limit = _LIMIT * ultimate if self.fatigue_limit is None else positive("fatigue_limit", self.fatigue_limit)
        if limit >= ultimate:
            raise ParameterError("fatigue_limit", limit, f"an amplitude below the tensile strength, {ultimate:g} Pa")
        if self.slope is not None:
            slope = _at_least("slope", self.slope, 1.0)
        elif limit < _AT_THOUSAND * ultimate:
            slope = max(1.0, math.log(knee / 1e3) / math.log(_AT_THOUSAND * ultimate / limit))
        else:
            raise ParameterError("slope", None, "a slope beside a fatigue limit so near the tensile strength")
        for name, value in (("ultimate", ultimate), ("fatigue_limit", limit), ("slope", slope), ("knee", knee)):
            object.__setattr__(self, name, value)

    def equivalent(self, amplitude: Array, mean: Array) -> Array:
        """Amplitudes about 0 that do as much (Goodman), Pa; a mean in compression is no help. Tension is positive."""
        left = 1.0 - np.clip(mean, 0.0, None) / self.ultimate
        with np.errstate(divide="ignore"):
            return np.asarray(np.where(left > 0.0, amplitude / np.clip(left, 0.0, None), np.inf))

    def damage(self, amplitude: Array, counts: Array) -> float:
        """Share of the life (Miner) that cycles of amplitudes about 0 take; 0 where none is above the limit."""
        over = amplitude / self.fatigue_limit
        if not over.max(initial=0.0) > 1.0:
            return 0.0
        if np.isinf(over).any():
            return math.inf
        return float(np.sum(counts / self.knee * over ** np.where(over > 1.0, self.slope, 2.0 * self.slope - 1.0)))


def cycles_of(history: npt.ArrayLike) -> Array:
    """Cycles of a history that repeats, by rainflow from its greatest value on (ASTM E1049-85, 5.4.5).

    Parameters
    ----------
    history
        Values in turn, shape (n,); what lies between turning points changes nothing.

    Returns
    -------
    Array
        Range, mean and count (a half or one) of each cycle, shape (cycles, 3), in the unit of the history.

    Raises
    ------
    MissingExtraError
        Without the package `rainflow`, of the extra `io`.

    Examples
    --------
    >>> cycles_of([-2.0, 1.0, -3.0, 5.0, -1.0, 3.0, -4.0, 4.0]).tolist()  # the example of the standard
    [[4.0, 1.0, 1.0], [3.0, -0.5, 1.0], [7.0, 0.5, 1.0], [9.0, 0.5, 0.5], [9.0, 0.5, 0.5]]
    """
    values = numbers("history", history)
    if values.ndim != 1 or not values.size:
        raise ParameterError("history", f"shape {values.shape}", "a list of one number or more")
    rainflow = extra_package("rainflow", "io")
    first = int(np.argmax(values))
    closed = np.concatenate([values[first:], values[: first + 1]])
    found = [cycle[:3] for cycle in rainflow.extract_cycles(closed.tolist()) if cycle[0] > 0.0]
    return np.array(found).reshape(-1, 3)


# ---- Fatigue of every section of a blow


@dataclass(frozen=True, eq=False)
class SectionFatigue:
    """Fatigue of one section, at the place of it that is worst.

    Attributes
    ----------
    body, number
        "striker" or "rod", and the number of the section in it, from 0.
    notch
        The factor on all stresses, dimensionless.
    place
        From the driven end or the struck face, m.
    range, mean
        Of the cycle there that does most, with the notch, Pa; tension is positive.
    over
        Cycles of one blow there that are above the fatigue limit.
    amplitude
        The amplitude about 0 that does as much as this cycle (Goodman), Pa.
    factor
        Fatigue limit over this amplitude, dimensionless; infinite without a stress.
    damage
        Share of the life that one blow takes (Miner); 0 where no cycle is above the limit.
    places, factors
        Where it was looked at, m, in turn, and the factor there; shape (n,).
    """

    body: str
    number: int
    notch: float
    place: float
    range: float
    mean: float
    over: float
    amplitude: float
    factor: float
    damage: float
    places: Array = field(repr=False)
    factors: Array = field(repr=False)

    @property
    def name(self) -> str:
        """As reports and `notch` have it."""
        return f"{self.body} {self.number}"

    @property
    def blows(self) -> float | None:
        """Blows to failure; None where no cycle is above the limit."""
        return 1.0 / self.damage if self.damage > 0.0 else None


@dataclass(frozen=True, eq=False)
class Fatigue:
    """Fatigue of the sections of striker and rod, in turn; made by `fatigue`. `steels`: of the striker, of the rod."""

    sections: tuple[SectionFatigue, ...]
    steels: tuple[Steel, Steel]

    @property
    def governing(self) -> SectionFatigue:
        """The section that fails first, or that has the least factor."""
        return max(self.sections, key=lambda one: (one.damage, -one.factor))


def fatigue(
    blow: Blow,
    steel: Steel,
    rod_steel: Steel | None = None,
    *,
    notches: Mapping[str, float] | None = None,
    size: int = 24,
) -> Fatigue:
    """Fatigue of striker and rod by blows like this one, each of which finds them without stress.

    The force at a place is the sum of two waves known in pieces, so its turning points are exact. Places are about
    `size` of each body, and those of the exact greatest compression and tension of each section.

    Parameters
    ----------
    blow
        Of a striker with sizes.
    steel, rod_steel
        Of the striker, and of the rod if it is another one.
    notches
        Fatigue notch factors by section, such as ``{"rod 0": 1.8}``, at least 1, dimensionless; 1 for all others.
        They hold for amplitude and mean.
    size
        Places along striker and along rod.

    Raises
    ------
    ParameterError
        For a dimensionless striker, and a notch of a section that there is not.
    MissingExtraError
        Without the package `rainflow`, of the extra `io`.

    Examples
    --------
    >>> from percuss.blow import Rod, strike
    >>> from percuss.model import Bar, Section
    >>> blow = strike(Bar(0.5, 1e-3), Rod([Section(None, area=1e-3)]), 10.0)  # a pulse of ρ c v/2
    >>> found = fatigue(blow, Steel(900e6)).governing
    >>> found.name, round(found.range / 1e6), round(found.mean / 1e6), round(found.factor, 2)
    ('striker 0', 203, -102, 3.55)
    """
    instance("blow", blow, Blow)
    steels = instance("steel", steel, Steel), instance("rod_steel", steel if rod_steel is None else rod_steel, Steel)
    size = count("size", size, 1, 10_000)
    if not isinstance(blow.striker, SizedBody):
        raise ParameterError("blow", blow, "the blow of a striker with sizes", "a dimensionless one has no stresses")
    rod = blow.target.pieces if isinstance(blow.target, Rod) and blow.target.impedance is None else ()
    bodies = {"striker": blow.striker.pieces, "rod": rod}
    names = [f"{body} {i}" for body, pieces in bodies.items() for i in range(len(pieces))]
    factors = dict(mapping("notches", {} if notches is None else notches, "factors by section"))
    for name, factor in factors.items():
        if name not in names:
            raise ParameterError("notches", name, f"sections of striker and rod: {', '.join(names)}")
        _at_least("notches", factor, 1.0)
    found: list[SectionFatigue] = []
    for own, (body, pieces) in zip(steels, bodies.items(), strict=True):
        long = sum(piece.end - piece.start for piece in pieces if math.isfinite(piece.end))
        for i, piece in enumerate(pieces):
            length, peak, shares = piece.end - piece.start, blow.peaks[len(found)], np.zeros(1)
            if math.isfinite(length):  # all places of an endless section see the same
                exact = [x for x in (peak.compression_place, peak.tension_place) if x is not None]
                even = np.linspace(0.0, 1.0, max(2, round(size * length / long)) + 1)
                shares = np.unique(np.clip(np.append(even, (np.array(exact) - piece.start) / length), 0.0, 1.0))
            places = piece.start + (shares * length if math.isfinite(length) else shares)
            notch = float(factors.get(f"{body} {i}", 1.0))
            turns = blow.force_turns(len(found), shares)
            stresses = [-notch / piece.area * force for force in turns]
            found.append(_section(own, body, i, notch, places, stresses))
    return Fatigue(tuple(found), steels)


def _section(
    steel: Steel, body: str, number: int, notch: float, places: Array, stresses: list[Array]
) -> SectionFatigue:
    """The worst of the places of a section, by the stresses there with the notch; beyond the window they are 0."""
    worst, rated = [], []
    for stress in stresses:
        cycles = cycles_of(np.concatenate([[0.0], stress, [0.0]]))
        cycles = cycles if cycles.size else np.zeros((1, 3))
        amplitude = steel.equivalent(0.5 * cycles[:, 0], cycles[:, 1])
        k = int(np.argmax(amplitude))
        over = cycles[amplitude > steel.fatigue_limit, 2].sum()
        worst.append((float(cycles[k, 0]), float(cycles[k, 1]), float(over), float(amplitude[k])))
        rated.append(steel.damage(amplitude, cycles[:, 2]))
    amplitudes = np.array([one[3] for one in worst])
    with np.errstate(divide="ignore"):
        factors = np.where(amplitudes > 0.0, steel.fatigue_limit / amplitudes, np.inf)
    k = max(range(len(worst)), key=lambda i: (rated[i], amplitudes[i]))
    return SectionFatigue(
        body, number, notch, float(places[k]), *worst[k], float(factors[k]), rated[k], places, factors
    )


def _at_least(name: str, value: object, least: float) -> float:
    accepted = f"a number of at least {least:g}"
    if (number := finite(name, value, accepted)) < least:
        raise ParameterError(name, value, accepted)
    return number
