"""What a command is told: its table of options, the kinds of values, and the files that it takes and makes."""

from __future__ import annotations

import argparse
import math
import os
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn

from percuss.errors import CaseError, Interrupted, MissingExtraError, PercussError, UsageError

if TYPE_CHECKING:
    from percuss.case import Case

MAX_PERIODS = 1000  # the most load periods per impact, and the most different numbers of them in one question

MAX_MODES = 4096  # the most elastic modes that the command line takes

PICTURES = (".png", ".svg", ".pdf")  # what a picture can be saved as


# ---- A command is a function and a table of options


class Option(NamedTuple):
    """An argument of a command; of a file to be made also how its name may end, and the extra and packages it needs.

    `needs_of` has what files with one ending need besides.
    """

    names: tuple[str, ...]
    settings: dict[str, Any]
    is_made: bool = False
    endings: tuple[str, ...] = ()
    needs: tuple[str, ...] = ()
    needs_of: tuple[tuple[str, tuple[str, ...]], ...] = ()


def option(spec: str, about: str, kind: Callable[[str], Any] | None = None, **settings: Any) -> Option:
    """An option, written as in the help: ``-o, --output FILE``, ``CASE``, or ``--json``, which takes no value."""
    words = spec.replace(",", "").split()
    names = tuple(word for word in words if word.startswith("-"))
    if len(names) < len(words):
        settings["metavar"] = words[-1]
    elif "choices" not in settings:
        settings["action"] = "store_true"
    if kind is not None:
        settings["type"] = kind
    return Option(names or (words[-1].lower(),), {**settings, "help": about})


def made(spec: str, about: str, endings: tuple[str, ...] = (), needs: tuple[str, ...] = (), **settings: Any) -> Option:
    """An option that names what is to be made: a FILE is looked at before anything is computed."""
    return option(spec, about, **settings)._replace(is_made=True, endings=endings, needs=needs)


class Command:
    """A command: its name is that of its function, which is given the parser and the values of the options."""

    def __init__(
        self,
        run: Callable[[Parser, argparse.Namespace], int],
        about: str | Callable[[], str],
        examples: str,
        options: Sequence[Option],
    ) -> None:
        self.examples = examples
        self._run, self._about, self._options = run, about, options

    def parser(self) -> Parser:
        about = self._about if isinstance(self._about, str) else self._about()
        return Parser(self._run.__name__, about, self.examples, self._options)

    def __call__(self, arguments: Sequence[str]) -> int:
        """Run it; returns the exit code."""
        parser = self.parser()
        return self._run(parser, parser.parsed(arguments))


def command(
    about: str | Callable[[], str], examples: str, *options: Option
) -> Callable[[Callable[[Parser, argparse.Namespace], int]], Command]:
    """Make a command of a function; a description that takes time to write is a function itself."""
    return lambda run: Command(run, about, examples, options)


class Parser(argparse.ArgumentParser):
    """`argparse.ArgumentParser` with whole option names only, "did you mean", and no exit of its own on errors."""

    def __init__(self, name: str, description: str, examples: str, options: Sequence[Option] = ()) -> None:
        self._options: list[str] = []
        self._made = [one for one in options if one.is_made]
        self.command = name
        super().__init__(
            prog=f"percuss {name}",
            description=description,
            epilog=f"examples:\n{examples}",
            formatter_class=argparse.RawDescriptionHelpFormatter,
            allow_abbrev=False,
        )
        for one in options:
            self.add_argument(*one.names, **one.settings)

    def add_argument(self, *names: Any, **settings: Any) -> argparse.Action:
        action = super().add_argument(*names, **settings)
        self._options += action.option_strings
        return action

    def parsed(self, arguments: Sequence[str]) -> argparse.Namespace:
        """The values of the arguments; UsageError for unknown, missing or impossible ones."""
        found, unknown = self.parse_known_args(arguments)
        if unknown:
            from percuss.errors import did_you_mean

            word = unknown[0].partition("=")[0]
            if word.startswith("-"):
                hint = did_you_mean(word, self._options) or f"the options are {', '.join(self._options)}"
                self.error(f"unknown option '{word}' — {hint}")
            self.error(f"one argument too many: '{word}'")
        for one in self._made:
            path = getattr(found, one.names[-1].removeprefix("--"))
            if path == "-":
                self.error(f"argument {one.names[0]}: '-': standard output has the report; give the name of a file")
            if path is not None and one.settings["metavar"] == "FILE":
                self.check_file(one.names[0], path, one.endings, getattr(found, "case", None))
                need(*one.needs)
                for ending, needed in one.needs_of:
                    if path.lower().endswith(ending):
                        need(*needed)
        return found

    def error(self, message: str) -> NoReturn:
        raise UsageError(f"{message}\n{self.format_usage().rstrip()}\n'{self.prog} --help' tells more")

    def check_file(self, name: str, path: str, endings: tuple[str, ...] = (), case: str | None = None) -> None:
        """Refuse what is no place for such a file, or the case itself."""
        folder = os.path.dirname(path) or "."
        place = os.path.dirname(os.path.realpath(path))  # a file is written beside its place, and then takes it
        wrong = ""
        if endings and not path.lower().endswith(endings):
            wrong = f": the name must end in {' or '.join(filter(None, [', '.join(endings[:-1]), endings[-1]]))}"
        elif not os.path.isdir(folder):
            wrong = f": there is no folder '{folder}'"
        elif os.path.isdir(path) or not os.path.basename(path):
            wrong = " is a directory"
        elif os.path.exists(path) and not os.path.isfile(path):
            wrong = " is not a regular file"
        elif not os.access(place, os.W_OK) or (os.path.exists(path) and not os.access(path, os.W_OK)):
            wrong = " cannot be written"
        elif case and os.path.exists(case) and os.path.exists(path) and os.path.samefile(case, path):
            wrong = " is the case itself"
        if wrong:
            self.error(f"argument {name}: '{path}'{wrong}")


def need(extra: str = "", *packages: str) -> None:
    """Refuse with a MissingExtraError, which says how to install it, when an optional package is not there."""
    from importlib.util import find_spec

    for package in packages:
        if find_spec(package) is None:
            raise MissingExtraError(package, extra)


# ---- The kinds of values

_MOST = 10**9


def whole(least: int = 0, most: int = _MOST, note: str = "") -> Callable[[str], int]:
    """The kind of a whole number from `least` to `most`; the note is said to those who want others."""

    def kind(text: str) -> int:
        if not re.fullmatch(r"\d{1,10}", text, re.ASCII) or not least <= int(text) <= most:
            told = f", {least} or greater" if most == _MOST else f" from {least} to {most}"
            raise argparse.ArgumentTypeError(f"'{text}': give a whole number{told}{note}")
        return int(text)

    return kind


modes = whole(0, MAX_MODES, "; 0 for a rigid bar")


def names(text: str) -> tuple[str, ...]:
    """Names with commas between them."""
    found = tuple(name.strip() for name in text.split(",") if name.strip())
    if not found:
        raise argparse.ArgumentTypeError(f"'{text}': give one or more names, with commas between them")
    return found


def periods(text: str) -> tuple[int, ...]:
    """``2``, ``1..4`` or ``1,3``: the numbers of load periods per impact, in order and once each."""
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


def time_or_text(text: str) -> float | str:
    """A number of radians, or text with a unit, which the case looks at."""
    value = _plain(text)
    return text if value is None else value


def events(text: str) -> tuple[int | None]:
    """``all``, ``last:K`` or ``none`` as the number of last events to show, None for all; in a tuple."""
    match = re.fullmatch(r"all|none|last:(\d{1,10})", text, re.ASCII)
    if match is None:
        raise argparse.ArgumentTypeError(f"'{text}': give all, none or last:K, for example last:20")
    return (None if text == "all" else int(match[1] or 0),)


def start_keys(text: str) -> dict[str, Any]:
    """``position=-1,time=0.3``, ``orbit:2``, ``random`` or ``random:ringing`` as the keys of [start]."""
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


def key_values(text: str) -> tuple[str, dict[str, Any]]:
    """``KEY=VALUE,KEY=VALUE`` as it was typed, and the values by their keys."""
    found: dict[str, Any] = {}
    for part in re.split(r",(?![^\[]*\])", text):
        key, sign, value = (word.strip() for word in part.partition("="))
        if not key or not sign or not value or key in found:
            raise argparse.ArgumentTypeError(f"'{text}': give KEY=VALUE, each key once: contact.restitution=0.3")
        found[key] = _value(value)
    return text, found


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


def orbit_label(text: str) -> str:
    """P/N, chatter/N or rest/N as it was typed, looked at."""
    from percuss.case.answers.exploring.orbits_answer import is_rest_label, parsed_label
    from percuss.errors import ParameterError

    try:
        if not is_rest_label(text):
            parsed_label(text)
    except ParameterError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    return text


# ---- Options that many commands have

CASE = option("CASE", "a TOML file, '-' for standard input, or a machine's name")
JSON = option("--json", "print the answer as JSON")


def report_options(spec: str = "--report FILE", **settings: Any) -> tuple[Option, ...]:
    """The file of a report, its paper and its language."""
    about = "write figures and pictures into one file: .html, or .pdf to print and sign"
    file = made(spec, about, (".htm", ".html", ".pdf"), ("plot", "matplotlib"), **settings)
    paper = option("--paper SIZE", "of a report as PDF: a4 (default) or letter", choices=("a4", "letter"), default="a4")
    language = option(
        "--language CODE", "of a report: en (default), de or sv", choices=("en", "de", "sv"), default="en"
    )
    return file._replace(needs_of=((".pdf", ("report", "typst")),)), paper, language


NO_PLAUSIBILITY = option("--no-plausibility", "say nothing of figures that no hammer has, such as 30 m/s or 900 bar")


def modes_option(default: str, about: str = "elastic modes, 0 (a rigid bar) to") -> Option:
    return option("--modes N", f"{about} {MAX_MODES} ({default})", modes)


def plot_option(what: str, spec: str = "--plot FILE") -> Option:
    return made(spec, f"draw {what}: {', '.join(PICTURES)}", PICTURES, ("plot", "matplotlib"))


def csv_option(about: str) -> Option:
    return made("--csv FILE", about, (".csv",), ("io", "xarray"))


NETCDF = ("io", "xarray", "h5netcdf")  # what writes and reads NetCDF


# ---- The case


def named_case(name: str) -> Case:
    """The case in a file, or of a machine of the catalogue; a file goes first."""
    from percuss.case import Case, load_case
    from percuss.case.catalogue.sample_cases import is_sample, sample_names
    from percuss.errors import did_you_mean

    if is_sample(name) and not os.path.isfile(name):
        return load_case(name)
    if name != "-" and not os.path.exists(name):
        folder = os.path.dirname(name)
        try:
            near = [os.path.join(folder, entry) for entry in os.listdir(folder or ".") if entry.endswith(".toml")]
        except OSError:
            near = []
        remedy = did_you_mean(name, [*near, *sample_names()])
        what = "no such file" if name.endswith(".toml") else "no such file, and no machine of this name"
        raise CaseError(name, "", None, what, remedy or "'percuss machines' lists the machines")
    return Case.read(name)


def write_case(case: Case, path: str) -> None:
    """Write a case as a file; a recording is named from the folder of the file."""
    from percuss.atomic_write import write_whole

    name = getattr(case.tables.load, "file", None)
    if name is not None and not os.path.isabs(name):
        there = os.path.relpath(case.folder / name, os.path.dirname(path) or ".")
        case = case.varied({"load.file": there.replace(os.sep, "/")})
    write_whole(path, case.to_toml())


@contextmanager
def of_file(case: Case) -> Iterator[None]:
    """Errors of the floors below, which do not know the file, told with it."""
    try:
        yield
    except (CaseError, Interrupted):
        raise
    except PercussError as error:
        raise PercussError(f"{case.file}: {error.message}", error.remedy) from error
