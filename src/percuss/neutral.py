"""Text that anybody may have written, such as titles, keys and commands of files, with all that steers written out.

Characters that move the cursor of a terminal, colour, ring or turn the line around become ``\\u001b`` and the like:
they can be read in text, in a picture and on a page, and in JSON they mean what they meant.
"""

from __future__ import annotations

import re

__all__ = ["neutral", "one_line"]

# control characters but for tab and line feed, and those that change the direction of writing
_STEERS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069]")
_ALSO_LINES = re.compile(f"[\n\u2028\u2029]|{_STEERS.pattern}")


def neutral(text: str) -> str:
    """The text with all that steers a terminal written out."""
    return _STEERS.sub(_written_out, text)


def one_line(text: str) -> str:
    """A text made harmless as `neutral` does, and without line breaks, for a place inside a line."""
    return _ALSO_LINES.sub(_written_out, text)


def _written_out(found: re.Match[str]) -> str:
    return f"\\u{ord(found[0]):04x}"
