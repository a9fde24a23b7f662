"""Events of a motion as columns, whatever drives it: their kinds, one of them, some of them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar, Generic, Self, TypeVar, overload

import numpy as np
import numpy.typing as npt

from percuss.model.checks import choice
from percuss.shown import Shown

__all__ = ["EventColumns"]

One = TypeVar("One")


@dataclass(frozen=True)
class EventColumns(Shown, ABC, Generic[One]):
    """Events in order of time, one array for each quantity, all of shape (n,).

    Parameters
    ----------
    code
        What happened, by its number in `KINDS`.
    """

    KINDS: ClassVar[tuple[str, ...]]

    code: npt.NDArray[np.int8]

    @property
    def kind(self) -> npt.NDArray[np.str_]:
        """The kinds as words; shape (n,)."""
        return np.array(self.KINDS)[self.code]

    def of(self, kind: str) -> Self:
        """The events of one kind.

        Raises
        ------
        ParameterError
            For a kind that there is not.
        """
        choice("kind", kind, *self.KINDS)
        which: npt.NDArray[np.bool_] = self.code == self.KINDS.index(kind)
        return self[which]

    def __str__(self) -> str:
        numbers = np.bincount(self.code, minlength=len(self.KINDS)).tolist()
        kinds = ", ".join(f"{n} {kind}" for n, kind in zip(numbers, self.KINDS, strict=True) if n)
        return f"{type(self).__name__}: {kinds or 'none'}"

    def __len__(self) -> int:
        return int(self.code.size)

    @overload
    def __getitem__(self, which: int | np.integer) -> One: ...
    @overload
    def __getitem__(self, which: slice | npt.NDArray[np.bool_] | npt.NDArray[np.intp]) -> Self: ...
    def __getitem__(self, which: int | np.integer | slice | npt.NDArray[np.bool_] | npt.NDArray[np.intp]) -> One | Self:
        """One event by its number, from the end when negative; the events of a slice, a mask or an array of numbers."""
        if isinstance(which, int | np.integer) and not isinstance(which, bool):
            return self._one(range(len(self))[which])
        return replace(self, **{name: column[which] for name, column in self._columns().items()})

    def __iter__(self) -> Iterator[One]:
        return map(self._one, range(len(self)))

    @abstractmethod
    def _one(self, i: int) -> One:
        """Event number i, from 0."""

    def _columns(self) -> dict[str, Any]:
        """What has an entry for each event."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name: value for name, value in values.items() if isinstance(value, np.ndarray)}

    @classmethod
    def of_all(cls, parts: Sequence[Self]) -> Self:
        """The events of several stretches of one motion, one after the other."""
        first = parts[0]
        if len(parts) == 1:
            return first
        columns = {name: np.concatenate([getattr(part, name) for part in parts]) for name in first._columns()}
        return replace(first, **columns)
