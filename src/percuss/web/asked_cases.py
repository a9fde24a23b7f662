"""From a request to its case; a case that was asked for a moment ago is not read again."""

from __future__ import annotations

import json
import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from percuss.case.catalogue.sample_cases import is_sample, load_case
from percuss.case.file_format.plain_tables import case_of
from percuss.case.file_format.reading import parsed
from percuss.errors import CaseError
from percuss.web.problem_json import refused

if TYPE_CHECKING:
    from percuss.case import Case
    from percuss.web.questions import CaseAsked

__all__ = ["MOST_MODES", "Memory", "case_asked", "case_key", "is_known"]

T = TypeVar("T")

MOST_MODES = 256
"""Of a structure that is told by a table of its modes."""


class Memory(Generic[T]):
    """The last few answers, bounded in number and in size; safe for threads.

    Parameters
    ----------
    most
        How many.
    size
        Of all together; what alone is larger is not kept.
    size_of
        The size of one, from its key and itself.
    """

    def __init__(self, most: int, size: float, size_of: Callable[[Any, T], float]) -> None:
        self._most, self._room, self._size_of = most, size, size_of
        self._kept: OrderedDict[Hashable, T] = OrderedDict()
        self._sizes: dict[Hashable, float] = {}
        self._lock = threading.Lock()

    def get(self, key: Hashable, make: Callable[[], T]) -> T:
        """What is kept for a key, else what `make` gives."""
        with self._lock:
            if key in self._kept:
                self._kept.move_to_end(key)
                return self._kept[key]
        made = make()
        self.put(key, made)
        return made

    def put(self, key: Hashable, value: T) -> None:
        """Keep a value, and let the oldest go."""
        with self._lock:
            self._forget(key)
            size = self._size_of(key, value)
            while self._kept and (len(self._kept) >= self._most or size > self._room):
                self._forget(next(iter(self._kept)))
            if size <= self._room:
                self._kept[key], self._sizes[key] = value, size
                self._room -= size

    def _forget(self, key: Hashable) -> None:
        if key in self._kept:
            del self._kept[key]
            self._room += self._sizes.pop(key)

    def find(self, key: Hashable) -> T | None:
        """What is kept for a key."""
        with self._lock:
            return self._kept.get(key)


_cases: Memory[Case] = Memory(64, 1_000_000, lambda key, _: len(key))
"""By the characters of their requests; what is made of these takes some thirty times as many bytes."""


def case_key(asked: CaseAsked) -> str:
    """A text that is the same for two requests when they ask for the same case."""
    if asked.machine is not None:
        return f"machine {asked.machine}"
    if asked.toml is not None:
        return f"toml {asked.toml}"
    return f"case {json.dumps(asked.case, sort_keys=True)}"


def case_asked(asked: CaseAsked, harmonics: int) -> Case:
    """The case of a request.

    Raises
    ------
    Refusal
        When it names none or several.
    CaseError
        When it is not a case.
    """
    given = [name for name in ("case", "toml", "machine") if getattr(asked, name) is not None]
    if len(given) != 1:
        raise refused(422, "expected exactly one of case, toml and machine", "", given[1] if given else "case")
    return _cases.get(case_key(asked), lambda: _made(asked, harmonics))


def is_known(asked: CaseAsked) -> bool:
    """Whether the case of a request was read a moment ago."""
    return _cases.find(case_key(asked)) is not None


def _made(asked: CaseAsked, harmonics: int) -> Case:
    if asked.machine is not None:
        if not is_sample(asked.machine):
            remedy = "GET /api/machines lists them"
            raise CaseError("machine", "machine", asked.machine, "no machine of this name", remedy)
        case = load_case(asked.machine)
    elif asked.toml is not None:
        if "\0" in asked.toml:
            raise CaseError("case", "toml", None, "is not text")
        case = case_of(parsed(asked.toml, "case"), harmonics=harmonics)
    else:
        assert asked.case is not None
        case = case_of(asked.case, harmonics=harmonics)
    table = case.tables.body
    if table is not None and len(table.omega or ()) > MOST_MODES:
        remedy = "leave out the highest, or use the command line"
        raise CaseError(case.file, "body.omega", len(table.omega or ()), f"more than {MOST_MODES} modes", remedy)
    case.machine() if case.is_machine else case.system()
    return case
