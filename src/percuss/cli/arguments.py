"""An argument parser that says what was probably meant, and the few kinds of values that the commands take."""

from __future__ import annotations

import argparse
import math
import os
import re
import sys
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NoReturn

from percuss.errors import CaseError, MissingExtraError

if TYPE_CHECKING:
    from percuss.case import Case

MAX_PERIODS = 1000
"""The most load periods per impact, and the most different numbers of them in one question."""

MAX_MODES = 4096
"""The most elastic modes that the command line takes."""


_MADE = ("output", "csv", "netcdf", "plot", "report")
"""The options that name a file to be made."""


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
            from percuss.errors import did_you_mean

            word = unknown[0].partition("=")[0]
            if word.startswith("-"):
                hint = did_you_mean(word, self._options) or f"the options are {', '.join(self._options)}"
                self.error(f"unknown option '{word}' — {hint}")
            self.error(f"one argument too many: '{word}'")
        for option in _MADE:
            if getattr(found, option, None) == "-":
                letter = "-o" if option == "output" else f"--{option}"
                self.error(f"argument {letter}: '-': standard output has the report; give the name of a file")
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


# ---- The kinds of values that only `percuss simulate` takes

_MOST = 10**9


def whole(text: str) -> int:
    """A whole number, 0 or greater.

    Examples
    --------
    >>> whole("2000")
    2000
    """
    return up_to(_MOST)(text)


def up_to(most: int, beyond: str = "") -> Callable[[str], int]:
    """The kind of a whole number from 0 to `most`; `beyond` is said to those who want more.

    Examples
    --------
    >>> up_to(1000)("24")
    24
    """

    def kind(text: str) -> int:
        if not re.fullmatch(r"\d{1,10}", text, re.ASCII) or int(text) > most:
            raise argparse.ArgumentTypeError(f"'{text}': give a whole number from 0 to {most}{beyond}")
        return int(text)

    return kind


def time_or_text(text: str) -> float | str:
    """A number of radians, or text with a unit, which the case looks at.

    Examples
    --------
    >>> time_or_text("6.5"), time_or_text("20 ms")
    (6.5, '20 ms')
    """
    value = _plain(text)
    return text if value is None else value


def events(text: str) -> tuple[int | None]:
    """``all``, ``last:K`` or ``none`` as the number of last events to show, None for all; in a tuple.

    Examples
    --------
    >>> events("all"), events("last:3"), events("none")
    ((None,), (3,), (0,))
    """
    if text == "all":
        return (None,)
    if text == "none":
        return (0,)
    match = re.fullmatch(r"last:(\d{1,10})", text, re.ASCII)
    if match is None:
        raise argparse.ArgumentTypeError(f"'{text}': give all, none or last:K, for example last:20")
    return (int(match[1]),)


def start_keys(text: str) -> dict[str, Any]:
    """``position=-1,time=0.3``, ``orbit:2``, ``random`` or ``random:ringing`` as the keys of [start].

    Examples
    --------
    >>> start_keys("position=-3 cm,time=0.3")
    {'position': '-3 cm', 'time': 0.3}
    >>> start_keys("orbit:2"), start_keys("random")
    ({'orbit': 2}, {'random': 'rigid'})
    """
    found: dict[str, Any] = {}
    for part in re.split(r",(?![^\[]*\])", text):
        name, sign, value = part.strip().partition("=")
        if not sign:
            name, sign, value = name.partition(":")
        if name == "random" and not sign:
            value = "rigid"
        elif not sign or not name.strip():
            raise argparse.ArgumentTypeError(
                f"'{text}': give key=value pairs, orbit:K or random, for example position=-1,velocity=0,time=0.3"
            )
        if name.strip() in found:
            raise argparse.ArgumentTypeError(f"'{text}': {name.strip()} is given twice")
        found[name.strip()] = _value(value.strip())
    return found


def _value(text: str) -> Any:
    if text.startswith("[") and text.endswith("]"):
        return [_value(item.strip()) for item in text[1:-1].split(",") if item.strip()]
    if re.fullmatch(r"[+-]?\d{1,18}", text, re.ASCII):
        return int(text)
    value = _plain(text)
    return text if value is None else value


def _plain(text: str) -> float | None:
    try:
        value = float(text.replace("−", "-"))
    except ValueError:
        return None
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"'{text}': expected a finite number")
    return value


# ---- The files that commands take and make: found, or refused before anything is computed

PICTURES = (".png", ".svg", ".pdf")
"""What a picture can be saved as."""


def check_picture(parser: Parser, path: str) -> None:
    """Refuse what cannot be drawn before anything is computed."""
    if not path.lower().endswith(PICTURES):
        parser.error(f"argument --plot: '{path}': the name must end in {', '.join(PICTURES[:-1])} or {PICTURES[-1]}")
    check_target(parser, "--plot", path)
    need("matplotlib", "plot")


def check_table(parser: Parser, path: str) -> None:
    """Refuse what no table is written to, before anything is computed; other programs know one by its name."""
    if not path.lower().endswith(".csv"):
        parser.error(f"argument --csv: '{path}': give the name of a file that ends in .csv")
    check_target(parser, "--csv", path)
    need("xarray", "io")


def check_csv(parser: Parser, path: str, case: str) -> None:
    """Refuse an -o that is no table, no place for a file, or the case itself."""
    if not path.lower().endswith(".csv"):
        parser.error(f"argument -o: '{path}': the name must end in .csv")
    check_target(parser, "-o", path)
    check_not_the_case(parser, path, case)


def check_target(parser: Parser, option: str, path: str) -> None:
    """Refuse a place where no file can be written."""
    folder = os.path.dirname(path) or "."
    if not os.path.isdir(folder):
        parser.error(f"argument {option}: '{path}': there is no folder '{folder}'")
    if os.path.isdir(path) or not os.path.basename(path):
        parser.error(f"argument {option}: '{path}' is a directory")
    if os.path.exists(path) and not os.path.isfile(path):
        parser.error(f"argument {option}: '{path}' is not a regular file")
    place = os.path.dirname(os.path.realpath(path))  # a file is written beside its place, and then takes it
    if not os.access(place, os.W_OK) or (os.path.exists(path) and not os.access(path, os.W_OK)):
        parser.error(f"argument {option}: '{path}' cannot be written")


def check_not_the_case(parser: Parser, path: str, case: str) -> None:
    """Refuse to write over the case that is asked."""
    if os.path.exists(case) and os.path.exists(path) and os.path.samefile(case, path):
        parser.error(f"argument -o: '{path}' is the case itself")


def need(package: str, extra: str) -> None:
    """Refuse when an optional package is not installed.

    Raises
    ------
    MissingExtraError
        Which says how to install it.
    """
    from importlib.util import find_spec

    if find_spec(package) is None:
        raise MissingExtraError(package, extra)


def tell_made(quietly: bool, **paths: str | None) -> None:
    """One line for every file that was made; `quietly`, when standard output holds JSON, among the messages."""
    for what, path in paths.items():
        if path is not None:
            print(f"{what}: {path}", file=sys.stderr if quietly else sys.stdout)


def named_case(name: str) -> Case:
    """The case in a file, or of a machine of the catalogue; a file goes first.

    Raises
    ------
    CaseError
        When there is neither, or the file is not a case.
    """
    from percuss.case import Case, load_case
    from percuss.case.catalogue.sample_cases import is_sample, sample_names
    from percuss.errors import did_you_mean

    if is_sample(name) and not os.path.isfile(name):
        return load_case(name)
    if name != "-" and not os.path.exists(name):
        near = [entry for entry in _entries(os.path.dirname(name)) if entry.endswith(".toml")]
        remedy = did_you_mean(name, [*near, *sample_names()])
        what = "no such file" if name.endswith(".toml") else "no such file, and no machine of this name"
        raise CaseError(name, "", None, what, remedy or "'percuss machines' lists the machines")
    return Case.read(name)


def _entries(folder: str) -> list[str]:
    try:
        return [os.path.join(folder, entry) for entry in os.listdir(folder or ".")]
    except OSError:
        return []
