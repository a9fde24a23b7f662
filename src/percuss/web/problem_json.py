"""What goes wrong, as one form of JSON: a list of problems with key, value, message and remedy."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

from starlette.exceptions import HTTPException

from percuss.errors import CaseError, HistoryError, MissingExtraError, ParameterError, PercussError

__all__ = ["Refusal", "problem", "problems_of", "refused"]

_MOST_TEXT = 200
"""Characters of a value or a message that are sent back."""


class Refusal(HTTPException):
    """A request that is not answered: a status and its problems."""

    def __init__(
        self, status: int, problems: Sequence[dict[str, Any]], headers: Mapping[str, str] | None = None
    ) -> None:
        super().__init__(status, "refused", dict(headers) if headers else None)
        self.problems = list(problems)


def refused(
    status: int, message: str, remedy: str = "", key: str = "", value: object = None, *, close: bool = False
) -> Refusal:
    """A `Refusal` with one problem; `close` ends the connection, on which the rest of a body would still come."""
    headers = {429: {"Retry-After": "1"}, 401: {"WWW-Authenticate": "Bearer"}, 503: {"Retry-After": "5"}}.get(
        status, {}
    )
    ending = {"Connection": "close"} if close else {}
    return Refusal(status, [problem(key, value, message, remedy)], {**headers, **ending})


def problem(key: str, value: object, message: str, remedy: str = "") -> dict[str, Any]:
    """One problem, of JSON's types and of bounded size."""
    return {
        "key": key[:_MOST_TEXT],
        "value": _shown(value),
        "message": _cut(message, 1000),
        "remedy": _cut(remedy, 1000),
    }


def problems_of(error: Exception) -> list[dict[str, Any]]:
    """The problems behind an error of the floors below.

    The names of files of this machine, which an error may know, are left out.
    """
    if isinstance(error, CaseError):
        found = getattr(error, "problems", (error,))
        return [problem(e.key, e.value, e.accepted, e.remedy) for e in found]
    if isinstance(error, ParameterError):
        return [problem(error.name, error.value, f"expected {error.accepted}", error.remedy)]
    if isinstance(error, HistoryError):
        message = error.message.removeprefix(f"{error.file}: ") if error.file else error.message
        return [problem("load.file", None, message, error.remedy)]
    if isinstance(error, MissingExtraError):
        return [problem("", None, error.message, error.remedy)]
    if isinstance(error, PercussError):
        return [problem("", None, error.message, error.remedy)]
    if isinstance(error, ArithmeticError):
        return [problem("", None, "sizes so large or small that numbers overflow", "check the units")]
    if isinstance(error, RecursionError):
        return [problem("", None, "nested too deeply", "")]
    if isinstance(error, MemoryError):
        return [problem("", None, "not enough memory for this computation", "ask for less")]
    return [problem("", None, "the server failed on this request; its log has more", "please report it with the case")]


def _shown(value: object) -> Any:
    """A value as JSON has it; what is long or not JSON as the beginning of its text."""
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, int):
        return value if abs(value) < 2**53 else _cut(f"{value:.3e}" if abs(value) < 10**300 else "a huge number")
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    if isinstance(value, str):
        return _cut(value)
    try:
        return _cut(json.dumps(value, ensure_ascii=False, default=str))
    except (TypeError, ValueError, RecursionError):
        return _cut(type(value).__name__)


def _cut(text: str, most: int = _MOST_TEXT) -> str:
    found = text if len(text) <= most else f"{text[: most - 1]}…"
    return found.encode("utf-8", "replace").decode("utf-8")  # half of a surrogate pair cannot be sent
