"""What a parameter is: one number that may be varied, with its words, its range, and how it is read and put."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import Any, Generic, TypeVar

T = TypeVar("T")


def _every(what: object) -> None:
    """The check of a parameter that everything of its kind has."""


@dataclass(frozen=True)
class Parameter(Generic[T]):
    """One number of a thing: of a body, of a law of damping, of a whole system.

    `name` is its word in commands, Python and JSON; `label` stands on an axis or beside a slider, in a few words that
    begin small; `meaning` is one sentence without a full stop. `get` finds its value, None where the thing has no such
    number; `put` gives the thing another value, and `check` refuses a thing that does not have it (ParameterError).
    `span` is from where to where one first looks at it; None for half to one and a half of its value. `sets` is the
    word of what it sets: of two parameters that set the same, one would do nothing. Those with a smaller `turn` are put
    first: a size that is measured by another is put after it.
    """

    name: str
    label: str
    meaning: str
    get: Callable[[T], float | None]
    put: Callable[[T, float], T]
    check: Callable[[T], None] = _every
    span: tuple[float, float] | None = None
    sets: str = ""
    turn: int = 0

    @property
    def thing(self) -> str:
        """The word of what it sets, its own name unless another sets the same."""
        return self.sets or self.name


def of_field(name: str, label: str, meaning: str, span: tuple[float, float] | None = None, field: str = "") -> Any:
    """The parameter of a frozen dataclass that is one of its fields, by default that of the same name."""
    field = field or name
    return Parameter(
        name, label, meaning, attrgetter(field), lambda what, value: replace(what, **{field: value}), span=span
    )
