"""An argument parser that says what was probably meant, and the few kinds of values that the commands take."""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence
from typing import Any, NoReturn

__all__ = ["MAX_MODES", "MAX_PERIODS", "Parser", "UsageError", "modes", "periods"]

MAX_PERIODS = 1000
"""The most load periods per impact, and the most different numbers of them in one question."""

MAX_MODES = 4096
"""The most elastic modes that the command line takes."""


class UsageError(Exception):
    """Arguments that do not make a command."""


class Parser(argparse.ArgumentParser):
    """`argparse.ArgumentParser` with whole option names only, "did you mean", and no exit of its own on errors."""

    def __init__(self, command: str, description: str, examples: str) -> None:
        self._options: list[str] = []
        super().__init__(
            prog=f"percuss {command}",
            description=description,
            epilog=f"examples:\n{examples}",
            formatter_class=argparse.RawDescriptionHelpFormatter,
            allow_abbrev=False,
        )

    def add_argument(self, *names: Any, **settings: Any) -> argparse.Action:
        action = super().add_argument(*names, **settings)
        self._options += action.option_strings
        return action

    def parsed(self, arguments: Sequence[str]) -> argparse.Namespace:
        """The values of the arguments.

        Raises
        ------
        UsageError
            For unknown, missing or impossible arguments.
        """
        found, unknown = self.parse_known_args(arguments)
        if unknown:
            from percuss.case.file_format.suggest import did_you_mean

            word = unknown[0].partition("=")[0]
            if word.startswith("-"):
                hint = did_you_mean(word, self._options) or f"the options are {', '.join(self._options)}"
                self.error(f"unknown option '{word}' — {hint}")
            self.error(f"one argument too many: '{word}'")
        return found

    def error(self, message: str) -> NoReturn:
        raise UsageError(f"{message}\n{self.format_usage().rstrip()}\n'{self.prog} --help' tells more")


def periods(text: str) -> tuple[int, ...]:
    """``2``, ``1..4`` or ``1,3``: the numbers of load periods per impact, in order and once each.

    Examples
    --------
    >>> periods("1..3,7")
    (1, 2, 3, 7)
    """
    found: set[int] = set()
    for part in text.split(","):
        match = re.fullmatch(r"\s*(\d{1,9})\s*(?:(?:\.\.|-)\s*(\d{1,9})\s*)?", part, re.ASCII)
        if match is None:
            raise argparse.ArgumentTypeError(f"'{text}': give a number, a range or a list: 2, 1..4 or 1,3")
        first, last = int(match[1]), int(match[2] or match[1])
        if not 1 <= first <= MAX_PERIODS or not 1 <= last <= MAX_PERIODS:
            raise argparse.ArgumentTypeError(f"'{text}': the numbers must lie between 1 and {MAX_PERIODS}")
        if last < first:
            raise argparse.ArgumentTypeError(f"'{text}': give the smaller number first, {last}..{first}")
        found.update(range(first, last + 1))
    return tuple(sorted(found))


def modes(text: str) -> int:
    """A number of elastic modes."""
    if not re.fullmatch(r"\d{1,9}", text, re.ASCII) or not 0 <= int(text) <= MAX_MODES:
        raise argparse.ArgumentTypeError(f"'{text}': give a whole number from 0 (a rigid bar) to {MAX_MODES}")
    return int(text)
