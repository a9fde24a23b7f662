"""Finds the command, runs it, and turns whatever stops it into a line on stderr and an exit code."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from importlib import import_module
from typing import TYPE_CHECKING, Any

from percuss.cli.waiting import sign, telling
from percuss.errors import Interrupted, PercussError, UsageError
from percuss.short_repr import escape_control

if TYPE_CHECKING:
    from percuss.cli.arguments import Command

# ---- What is printed cannot steer the terminal: titles, keys and commands come from files that anybody may have
# written


@contextmanager
def neutral_streams() -> Iterator[None]:
    """For the time of the block standard output and standard error are neutral; rich draws past them."""
    before = sys.stdout, sys.stderr
    if sys.stdout is not None:
        sys.stdout = _Neutral(sys.stdout)
    if sys.stderr is not None:
        sys.stderr = _Neutral(sys.stderr)
    try:
        yield
    finally:
        sys.stdout, sys.stderr = before


class _Neutral:
    """A stream whose text steers nothing. rich looks for the attribute, and writes its own colours there."""

    def __init__(self, stream: Any) -> None:
        self.rich_proxied_file = getattr(stream, "rich_proxied_file", stream)

    def write(self, text: str) -> int:
        self.rich_proxied_file.write(escape_control(text))
        sign()
        return len(text)

    def writelines(self, lines: Any) -> None:
        for line in lines:
            self.write(line)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.rich_proxied_file, name)


# ---- The commands, and what becomes of whatever stops them

COMMANDS = {
    "steady": "every steady motion of a hammer: blow energy, stability, margins",
    "machine": "a hammer whose piston switches its own valve: blow energy, rate, oil, margins",
    "report": "the report on a hammer as a file: answer, drawing, blow, fatigue, to print and sign",
    "design": "the best hammer within ranges, under limits of any of its figures",
    "compare": "hammers side by side: where they differ, and what that does to their figures",
    "tolerance": "what tolerances do to it: the spread of its figures, what dominates",
    "simulate": "how a hammer moves from a start, impact by impact",
    "orbits": "motions with several impacts in a cycle, stable and unstable",
    "follow": "such a motion followed through a parameter: folds, flips, ends",
    "diagram": "all motions over one parameter: simulated, followed, stable and unstable",
    "blow": "one blow by waves: what tool and rock get, forces, stresses, what comes back",
    "sweep": "quantities over a parameter or a plane: maps",
    "experiment": "random starts, and the share of them that ends in each motion",
    "basins": "a plane of starts, and the motion that each leads to",
    "serve": "the workbench: a page with sliders, to see and hear the hammer",
    "machines": "the catalogue of sample cases",
    "new": "a commented sample case to start from",
    "keys": "the tables of a case file and their keys",
    "paper": "the figures and claims of the 1977 paper, reproduced",
    "show": "what is in an archive, and how complete it is",
    "export": "an archive as one file, NetCDF or CSV",
}

_FILES = {
    "motions": "steady machine simulate report", "orbits": "orbits follow diagram", "blow": "blow",
    "whole_hammers": "design compare tolerance", "serve": "serve",
    "maps": "sweep experiment basins", "catalogue": "machines new keys paper", "long_commands": "show export",
}  # fmt: skip


def command_of(name: str) -> Command:
    """A command, from its file in this folder."""
    file = next(file for file, names in _FILES.items() if name in names.split())
    found: Command = getattr(import_module(f"percuss.cli.{file}"), name)
    return found


_HELP = """\
usage: percuss COMMAND ...
       percuss --help | --version

Impact motions of a bar driven against a wall, steady or simulated: percussive drills, breakers, pile hammers.

commands:
{commands}

A case is a TOML file that describes a hammer, or the name of a machine of the catalogue.

examples:
  percuss machines
  percuss steady hydraulic-drifter
  percuss machine valve-breaker
  percuss new mini-breaker -o breaker.toml
  percuss steady breaker.toml --periods 1..3 --plot breaker.png
  percuss simulate breaker.toml --plot motion.png

'percuss COMMAND --help' tells more.
"""


def run(arguments: Sequence[str]) -> int:
    """Run the command that the arguments name; returns the exit code."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # a terminal without Greek letters is no reason to fail
    with neutral_streams():
        return _run(list(arguments))


def _run(arguments: list[str]) -> int:
    """The command, and an exit code for whatever stops it."""
    try:
        code = _dispatch(arguments)
        if sys.stdout is not None:  # None when it was closed (percuss … >&-)
            sys.stdout.flush()
        return code
    except UsageError as error:
        print(f"percuss: {error}", file=sys.stderr)
        return 2
    except Interrupted as stop:
        print(f"\npercuss: {stop}", file=sys.stderr)
        return 130
    except PercussError as error:
        lines = str(error).splitlines()
        print(*(f"percuss: error: {line}" for line in lines), sep="\n", file=sys.stderr)
        return 2
    except MemoryError:
        print("percuss: error: not enough memory for this computation", file=sys.stderr)
        return 2
    except BrokenPipeError:
        # The reader has seen enough (as in `percuss machines | head -1`): no complaint, also not when Python
        # flushes stdout at its end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:
        print(f"percuss: error: the output cannot be written: {error.strerror or error}", file=sys.stderr)
        return 1


def _dispatch(arguments: list[str]) -> int:
    first = arguments[0] if arguments else "--help"
    if first in ("-h", "--help", "help"):
        if len(arguments) > 1 and arguments[1] in COMMANDS:
            return _dispatch([arguments[1], "--help"])
        print(_HELP.format(commands="\n".join(f"  {name:<12}{what}" for name, what in COMMANDS.items())), end="")
        return 0
    if first in ("-V", "--version"):
        from percuss._version import __version__

        print(f"percuss {__version__}")
        return 0
    if first not in COMMANDS:
        raise UsageError(_unknown(first))
    with nullcontext() if first == "serve" else telling(first):  # the page tells of itself
        return command_of(first)(arguments[1:])


def _unknown(word: str) -> str:
    from percuss.errors import did_you_mean

    if word.startswith("-"):
        hint = did_you_mean(word, ["--help", "--version"]) or "the command comes first: percuss COMMAND …"
        return f"unknown option '{word}' — {hint}"
    hint = did_you_mean(word, COMMANDS)
    if not hint and (word.endswith(".toml") or os.path.exists(word)):
        hint = f"to analyse a case: percuss steady {word}"
    hint = hint or "see 'percuss --help'"
    return f"unknown command '{word}'; the commands are {', '.join(COMMANDS)} — {hint}"
