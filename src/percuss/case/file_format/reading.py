"""From a path to the tables of a TOML file; everything that can be wrong with the file itself."""

from __future__ import annotations

import re
import sys
import tomllib
from itertools import islice
from pathlib import Path
from typing import Any

from percuss.errors import CaseError

__all__ = ["MAX_BYTES", "MAX_KEYS", "parsed", "text_of"]

MAX_BYTES = 1_000_000
"""The largest case file that is read; a case is a page of text, data belong in a history file."""


_DATA = 'a case is a page of TOML text; a recording is named in it with kind = "history" and file = "…"'

MAX_KEYS = 1_000
"""Keys and tables of a case; it has some forty, and each unknown one is a problem to be told."""

# A key before "=", bare or in quotes, or a table's head; a row of an array, [1.0, 0.0], is neither.
_PART = r"""(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')"""
_KEY = re.compile(rf"(?<![\w-]){_PART}[ \t]*+=|^[ \t]*+\[\[?[^,\[\]\n]*+\]", re.MULTILINE)
_DEEP_KEY = re.compile(rf"(?<![\w-])(?:{_PART}[ \t]*+\.[ \t]*+){{20}}")


def text_of(path: str) -> str:
    """The text of a case file; ``-`` stands for the standard input.

    Raises
    ------
    CaseError
        When the file is missing, a directory, unreadable, too large, binary or not UTF-8.
    """
    try:
        if path == "-":
            data = sys.stdin.buffer.read(MAX_BYTES + 1)
        else:
            with open(path, "rb") as file:
                data = file.read(MAX_BYTES + 1)
    except FileNotFoundError:
        raise CaseError(path, "", None, "no such file") from None
    except IsADirectoryError:
        raise CaseError(path, "", None, "is a directory", _case_in(path)) from None
    except (OSError, ValueError) as error:  # ValueError: a path with a null character
        reason = getattr(error, "strerror", None) or str(error)
        raise CaseError(path, "", None, f"cannot be read: {reason}") from None
    if len(data) > MAX_BYTES:
        raise CaseError(
            path,
            "",
            None,
            f"larger than {MAX_BYTES // 1_000_000} MB, too large for a case file",
            _DATA,
        )
    if b"\0" in data:
        raise CaseError(path, "", None, "is a binary file", "a case is TOML text; see 'percuss new' for a sample")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise CaseError(path, "", None, f"is not UTF-8 text (line {line})", "save it as UTF-8") from None


def parsed(text: str, file: str) -> dict[str, Any]:
    """The tables of a TOML text.

    Raises
    ------
    CaseError
        With line and column when the text is not TOML.
    """
    if _DEEP_KEY.search(text):  # the parser takes the square of the parts of a key in time and in memory
        raise CaseError(file, "", None, "not a case: a key of twenty parts")
    if sum(1 for _ in islice(_KEY.finditer(text), MAX_KEYS + 1)) > MAX_KEYS:
        raise CaseError(file, "", None, f"not a case: more than {MAX_KEYS} keys and tables", _DATA)
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise CaseError(file, "", None, f"not valid TOML: {error}", _syntax_hint(text, str(error))) from None
    except RecursionError:
        raise CaseError(file, "", None, "not valid TOML: brackets nested too deeply") from None
    except ValueError as error:  # tomllib lets a few through, such as a number of 5000 digits
        raise CaseError(file, "", None, f"not valid TOML: {error}") from None


def _case_in(path: str) -> str:
    """A remedy that names the case files lying in a directory."""
    try:
        found = sorted(entry.name for entry in Path(path).glob("*.toml"))[:3]
    except OSError:
        found = []
    return "name a case file in it: " + ", ".join(found) if found else "name a TOML case file"


def _syntax_hint(text: str, message: str) -> str:
    """What to do about the syntax error of `message`, from the line it points at."""
    where = re.search(r"at line (\d+)", message)
    lines = text.splitlines()
    if where is None or int(where[1]) > len(lines):
        return ""
    line = lines[int(where[1]) - 1].strip()
    if re.match(r"^[\w.-]+\s*=\s*[\d.+-]+\s+[A-Za-z]", line):
        return f'text with a unit needs quotes, for example length = "341 mm"; the line reads: {line[:60]}'
    return f"the line reads: {line[:60]}" if line else ""
