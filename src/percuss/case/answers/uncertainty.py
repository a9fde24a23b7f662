"""What the ± of the numbers of a case leaves of its figures: linearised, and which number it comes from."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from percuss.case.answers.facts import Fact, Grid, figures, percent, plain_of
from percuss.case.answers.whole_hammer import WHOLE_FIGURES
from percuss.short_repr import ShortRepr

_SPOKEN = ("blow_energy", "blow_rate", "impact_velocity", "rock_power")
_MAIN = ("rock_power", "blow_energy", "impact_velocity")


@dataclass(frozen=True)
class UncertainFigure:
    """A figure of a hammer some of whose numbers are known within ± (base units of SI, or dimensionless).

    Attributes
    ----------
    half
        What its numbers leave it by: the root of the sum of the squares of what each leaves alone.
    shares
        Of that sum, by the keys of the numbers, the greatest first.
    bent
        Whether it is far from linear within the ±, so that `half` is a guess.
    """

    name: str
    value: float
    half: float
    shares: dict[str, float]
    bent: bool

    def tell(self, is_si: bool) -> str:
        """The value with its ±, to two digits of that."""
        factor, unit = WHOLE_FIGURES[self.name].axis(abs(self.value), is_si)
        value, half = self.value * factor, self.half * factor
        places = max(0, 1 - math.floor(math.log10(half))) if half < math.inf else 0
        return f"{value + 0.0:.{places}f} ± {half:.{places}f} {unit}".rstrip()


UNCERTAIN: tuple[Fact[UncertainFigure], ...] = figures(
    """
    name | the figure, as maps have it
    value | what it is, in the base unit of SI, or dimensionless
    half | its ±: the root of the sum of the squares of what the ± of each number makes alone
    shares | of that sum, by the keys of the case, the greatest first
    bent | whether the figure is far from linear within these ranges; then `percuss tolerance` says more
    """
)
"""A figure with its ±."""


@dataclass(frozen=True)
class FigureUncertainty(ShortRepr):
    """The figures of a hammer some of whose numbers are known within ±.

    Attributes
    ----------
    given
        These numbers, by their keys.
    figures
        Those that depend on them.
    stopped
        The ends at which the hammer does not run, and why.
    """

    given: tuple[tuple[str, str], ...]
    figures: tuple[UncertainFigure, ...]
    stopped: tuple[str, ...]
    is_si: bool

    def told(self, name: str) -> str | None:
        """A figure with its ±; None where it has none."""
        return next((one.tell(self.is_si) for one in self.figures if one.name == name), None)

    @property
    def sentence(self) -> str:
        """What is known of the headline figures, and what dominates."""
        rows = {one.name: one for one in self.figures}
        told = [f"{WHOLE_FIGURES[name].label} {rows[name].tell(self.is_si)}" for name in _SPOKEN if name in rows]
        said = f"As its numbers are known: {', '.join(told)}" if told else ""
        main = next((rows[name] for name in _MAIN if name in rows), None)
        if main is not None:
            key, share = next(iter(main.shares.items()))
            said += f"; mostly from {key}" if share < 0.995 and len(self.given) > 1 else f"; from {key}"
        said += "." if said else ""
        if self.stopped:
            said += f" Not all of these hammers run: {self.stopped[0]}."
        return said.strip()

    @property
    def grid(self) -> Grid:
        """The figures as a table of a report."""
        rows = []
        for one in self.figures:
            shares = ", ".join(f"{key} {percent(share)}" for key, share in one.shares.items() if share > 0.005)
            rows.append((WHOLE_FIGURES[one.name].label, one.tell(self.is_si), shares + (" (bent)" if one.bent else "")))
        rows += [("does not run", "", words) for words in self.stopped]
        given = ", ".join(f"{key} ({text})" for key, text in self.given)
        return Grid(f"By the ± of {given}", ("figure", "value", "from (shares of the variance)"), tuple(rows))

    def to_json_dict(self) -> dict[str, Any]:
        """The figures in plain values."""
        return {"figures": [plain_of(one, UNCERTAIN) for one in self.figures], "stopped": list(self.stopped)}
