"""Colours and what they mean, and how compression and tension are told: one home for the page, reports and pictures.

Every colour comes twice: for a light and for a dark ground; what is printed or saved is light. The kinds are Okabe and
Ito's, the pale ones darkened until a thin line of them is seen on white. What a colour says is said by a shape, a hatch
or a word as well.

Compression is negative and blue, tension positive and orange, whether strain or stress is shown. A quantity stands
before its unit in brackets: ``stress [MPa]``.
"""

from __future__ import annotations

import re
from dataclasses import asdict, dataclass
from typing import Any


@dataclass(frozen=True)
class Colour:
    """A colour as ``#rrggbb``, on a light and on a dark ground."""

    light: str
    dark: str


@dataclass(frozen=True)
class ColourFamily:
    """A family of found motions, with the look that it has in every map.

    Attributes
    ----------
    name
        What a legend says.
    pattern
        A regular expression, the same in Python and JavaScript, that matches the labels of the family from their
        beginning on (`percuss.simulate.Trajectory.label`). A label belongs to the first family that matches.
    colour
        Of its cells.
    hatch
        Of its cells: "" or one of ``/``, ``\\``, ``x``, ``.``, ``-``, as matplotlib has them.
    """

    name: str
    pattern: str
    colour: Colour
    hatch: str


KINDS = (
    Colour("#0072b2", "#5ab4ec"),
    Colour("#d55e00", "#ff8c42"),
    Colour("#009e73", "#3ecfa0"),
    Colour("#b0588a", "#e08fc0"),
    Colour("#b87f00", "#f0b43c"),
    Colour("#3a93c8", "#8fd0f5"),
)
"""Kinds of things, told apart by people with any colour vision: blue, vermilion, green, purple, orange, sky."""

CYCLE = (*(kind.light for kind in KINDS), "#000000")
"""In what order lines of a picture take their colours."""

AREAS = (
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9",
    "#f0e442", "#000000", "#9900ff", "#663300", "#330099", "#00ff99",
)  # fmt: skip
"""Twelve colours of areas, no two of which are near each other, for things that have no meaning of their own."""

FAMILIES = (
    ColourFamily("at rest for good", r"rest$", Colour("#4b5663", "#b6c1cd"), ""),
    ColourFamily("z=1/1, one blow a period", r"z=1/1$", Colour("#0072b2", "#2f8fd0"), ""),
    ColourFamily("other z=1/n", r"z=1/", Colour("#7fc1ea", "#9fd8fa"), "/"),
    ColourFamily("other z=p/n", r"z=", Colour("#eeb33b", "#d99b1f"), "\\"),
    ColourFamily("chatter or rest, released again", r"(chatter|rest)/", Colour("#cc79a7", "#c06a9a"), "x"),
    ColourFamily("aperiodic", r"aperiodic", Colour("#d55e00", "#e0702a"), "."),
    ColourFamily("undecided, or gone from the wall", r"", Colour("#9aa3ad", "#5d6b79"), "-"),
)
"""The seven families of motions that a simulation finds."""

VERDICTS = {
    "none": Colour("#dfe3e8", "#26313c"),
    "unstable": Colour("#e9b48d", "#8a5030"),
    "stable": Colour("#7fc4ae", "#1f7a61"),
}
"""Cells of a map: no steady motion, an unstable one, a stable one."""

STRAIN = (
    Colour("#053061", "#78beff"),
    Colour("#2166ac", "#4896e1"),
    Colour("#4393c3", "#2d6eb4"),
    Colour("#92c5de", "#284e7a"),
    Colour("#dee2e6", "#424a54"),
    Colour("#fdbe78", "#7a4e24"),
    Colour("#e67e22", "#b8681e"),
    Colour("#b9540a", "#ec8a28"),
    Colour("#702e00", "#ffbe6e"),
)
"""From the greatest compression (negative, blue) through nothing to the greatest tension (positive, orange)."""

SIGN = "compression negative"
"""What is said beside every scale of strain or stress."""

STABILITY = (
    Colour("#702e00", "#ffbe6e"),
    Colour("#b9540a", "#ec8a28"),
    Colour("#e67e22", "#b8681e"),
    Colour("#fdbe78", "#7a4e24"),
    Colour("#fbf6e6", "#5d5a4a"),
    Colour("#a5d9c8", "#23584a"),
    Colour("#53b296", "#1f7a61"),
    Colour("#16846a", "#3aa88a"),
    Colour("#004d3b", "#7ae3c3"),
)
"""From the most unstable through the border to the most stable: of margins, and turned round of Lyapunov exponents."""

SHARES = (
    "#00224e", "#123570", "#3b496c", "#575d6d", "#707173", "#8a8678", "#a59c74", "#c3b369", "#e1cc55", "#fee838",
)  # fmt: skip
"""Sizes, from the smallest to the greatest: the ramp cividis."""

BOTH = {"none": "#b8b8b8", "rest": "#f0e442"}
"""On any ground: the hatch of what has no value, and the mark of −∞."""


def family_of(label: str) -> int:
    """The number of the family to which a found motion belongs, in `FAMILIES`.

    Examples
    --------
    >>> [FAMILIES[family_of(label)].name for label in ("rest", "z=1/3", "z=8/8", "chatter/2")]
    ['at rest for good', 'other z=1/n', 'other z=p/n', 'chatter or rest, released again']
    """
    return next(i for i, family in enumerate(FAMILIES) if re.match(family.pattern, label))


def palette_dict() -> dict[str, Any]:
    """The palette in plain values, for the page."""
    return {
        "kinds": [asdict(kind) for kind in KINDS],
        "families": [asdict(family) for family in FAMILIES],
        "verdicts": {name: asdict(colour) for name, colour in VERDICTS.items()},
        "strain": [asdict(stop) for stop in STRAIN],
        "stability": [asdict(stop) for stop in STABILITY],
        "shares": list(SHARES),
        "sign": SIGN,
    }
