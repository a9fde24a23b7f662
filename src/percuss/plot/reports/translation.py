"""A report in other languages: the lookup of the workbench (`core/words.js`) by its catalogue, and the same rules."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from functools import cache
from importlib import resources
from itertools import pairwise
from typing import NamedTuple

from percuss.model.checks import choice

LANGUAGES = ("en", "de", "sv")
"""Their codes; English is what everything is written in."""

_KEY = re.compile(r"[A-Za-z0-9_[\]]+(\.[A-Za-z0-9_[\]]+)+")
_WORD = "A-Za-z0-9_"
NUMBER = re.compile(
    rf"(?:−|(?<![^\s(=[])-)?(?<![{_WORD}.])[0-9]+(?:\.[0-9]+)?(?:e[+-]?[0-9]+)?(?![{_WORD}.]*\.[0-9])(?:·10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?"
)
"""A number in a text."""

_FILLED = re.compile(r"#([0-9]?)|\{([0-9]?)\}")
_TRIMMED = re.compile(r"(\A\s+|\s+\Z)")
_SENTENCES = [re.compile(marks) for marks in (r"((?<=[.!?])\s+)", r"((?<=;)\s+)", "( — | · | / )", "(: )")]
_END = re.compile(r"([.;:…▸▾?]+\Z)")
_MARK = re.compile(r"(\A[▴●○✓]\s?|\A[0-9]+ (?=[A-ZÄÅÖÜ]))")
_PARTS = re.compile(rf"(, | = | \((?=[{_WORD}.[\]]*\.[{_WORD}.[\]]*\)\Z)| \[(?=[^[\]]*\]\Z)|[)\]]\Z)")
_BETWEEN = re.compile(r"[\s=/:;,()[\]…–]+")
_UNIT = re.compile(
    r"(?:(?:da|[GMkhdcmuµn])?(?:m|g|s|N|Pa|J|W|Hz|l|L|bar|rad|ε|strain)|microstrain|t|atm|sec|min|h|kgf|inch|in|ft|lbf|lbs?|"
    r"kip|psi|ksi|hp|gal|gpm|rpm|bpm|rev|deg|blows?)(?:\^?-?[0-9]+|[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?"
)

_KEPT = 5000  # texts of which the translation is kept


class _Template(NamedTuple):
    """A phrase with words filled in: what stands between them, what is filled in, and its translation."""

    literals: tuple[str, ...]
    kinds: tuple[str, ...]
    target: str


class Translation:
    """What translates texts into one language; what it has no words for stays as it is, and stands in `missed`."""

    def __init__(self, language: str) -> None:
        whole = resources.files("percuss").joinpath("web", "page", "core", "words.json").read_text(encoding="utf-8")
        column = LANGUAGES.index(language) - 1
        self._phrases: dict[str, str] = {key: targets[column] for key, targets in json.loads(whole).items()}
        filled = [key for key in self._phrases if "{}" in key]
        filled.sort(key=lambda key: -len(re.sub(r"[#{}\s]", "", key)))
        self._templates = [_template(key, self._phrases[key]) for key in filled]
        self._done: dict[str, str] = {}
        self.missed: set[str] = set()

    def __call__(self, text: str) -> str:
        """A text in the language."""
        if text not in self._done:
            if len(self._done) > _KEPT:
                self._done.clear()
                self.missed.clear()
            self._done[text] = self._translated(text) if text else text
        return self._done[text]

    def _translated(self, text: str) -> str:
        found = self._known(text)
        if found is not None:
            return found
        for marks in _SENTENCES:
            parts = marks.split(text)
            if len(parts) > 1:
                return "".join(part if i % 2 or not part else self._translated(part) for i, part in enumerate(parts))
        self.missed.add(text)
        return text

    def _known(self, text: str) -> str | None:
        """By the catalogue: as a whole, with its first letter small, or part by part where all are known."""
        whole = self._phrase(text) or self._in_parts(text, _END) or self._filled_in(text)
        if whole is None and _is_wordless(text):
            whole = _with_commas(text)
        if whole is not None:
            return whole
        small = text[0].lower() + text[1:]
        if small != text and (found := self._phrase(small) or self._filled_in(small)) is not None:
            return found[0].upper() + found[1:]
        for marks in (_TRIMMED, *_SENTENCES, _MARK, _PARTS):
            if (found := self._in_parts(text, marks)) is not None:
                return found
        return None

    def _in_parts(self, text: str, marks: re.Pattern[str]) -> str | None:
        """The same of a text with such marks in it, where all that stands between them is known."""
        parts = marks.split(text)
        if len(parts) == 1:
            return None
        told = [part if i % 2 or not part else self._known(part) for i, part in enumerate(parts)]
        return None if None in told else "".join(filter(None, told))

    def _phrase(self, text: str) -> str | None:
        target = self._phrases.get(NUMBER.sub("#", text))
        return None if target is None else _told(target, NUMBER.findall(text), [])

    def _filled_in(self, text: str) -> str | None:
        for literals, kinds, target in self._templates:
            if all(one in text for one in literals) and (found := _pattern(literals, kinds).fullmatch(text)):
                filled = list(zip(kinds, found.groups(), strict=True))
                words = [self._translated(piece) for kind, piece in filled if kind == "{}"]
                return _told(target, [piece for kind, piece in filled if kind == "#"], words)
        return None


@cache
def translation(language: str) -> Callable[[str], str]:
    """What puts the texts of a report into a language, read once; nothing is read for English."""
    choice("language", language, *LANGUAGES)
    return str if language == "en" else Translation(language)


def _template(key: str, target: str) -> _Template:
    return _Template(tuple(re.split(r"#|\{\}", key)), tuple(re.findall(r"#|\{\}", key)), target)


@cache
def _pattern(literals: tuple[str, ...], kinds: tuple[str, ...]) -> re.Pattern[str]:
    gaps = [f"({NUMBER.pattern})" if kind == "#" else "(.+?)" for kind in kinds]
    return re.compile("".join(re.escape(one) + gap for one, gap in zip(literals, [*gaps, ""], strict=True)), re.DOTALL)


def _told(target: str, numbers: list[str], words: list[str]) -> str:
    """A target with its numbers and words in their places: in order, or by number as `#2`, `{1}`."""
    numbers = [_with_commas(number) for number in numbers]
    ordered = {"#": iter(numbers), "{": iter(words)}

    def put(mark: re.Match[str]) -> str:
        number, word = mark[1], mark[2]
        if number or word:
            return numbers[int(number) - 1] if number else words[int(word) - 1]
        return next(ordered[mark[0][0]], "")

    return _FILLED.sub(put, target)


def _with_commas(text: str) -> str:
    return NUMBER.sub(lambda number: re.sub("^-", "−", number[0].replace(".", ",")), text)


def _is_wordless(text: str) -> bool:
    """Whether a text has nothing to translate: numbers, units and symbols."""
    return _KEY.fullmatch(text) is not None or all(map(_is_plain, _BETWEEN.split(text)))


@cache
def _is_plain(word: str) -> bool:
    letters = any(a.isalpha() and b.isalpha() for a, b in pairwise(word))
    return not letters or bool(_KEY.fullmatch(word)) or all(map(_UNIT.fullmatch, re.split("[*·]", word)))
