"""A motion that is told event by event, or impact by impact, as JSON."""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from typing import Any, ClassVar

from percuss.model.checks import count
from percuss.shown import Shown

__all__ = ["ToldMotion"]


class ToldMotion(Shown, ABC):
    """A motion that is told event by event, or impact by impact."""

    ROWS: ClassVar[str] = "events"
    """The key of the list."""

    @abstractmethod
    def _told(self, last: int | None) -> dict[str, Any]:
        """The JSON object, with so many last rows or all of them."""

    def to_json_dict(self, last: int | None = None) -> dict[str, Any]:
        """The answer in plain values, as `percuss simulate --json` prints it.

        Parameters
        ----------
        last
            The number of last events to keep, by waves of impacts; all by default.

        Raises
        ------
        ParameterError
            When `last` is no such number.
        """
        return self._told(None if last is None else count("last", last, least=0))

    def to_json_text(self, last: int | None = None) -> str:
        """The same as text, one line for each event or impact."""
        tree = self.to_json_dict(last)
        rows = [json.dumps(row, allow_nan=False) for row in tree[self.ROWS]]
        text = json.dumps({**tree, self.ROWS: []}, indent=1, allow_nan=False)
        if not rows:
            return text
        key = f'\n "{self.ROWS}": ['  # keys of objects within stand further in, and no text has a line break
        return text.replace(key + "]", key + "\n  " + ",\n  ".join(rows) + "\n ]")
