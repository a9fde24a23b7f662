"""What can go wrong, and what to do about it.

::

    PercussError
    ├── ParameterError (also ValueError)   a value that an object cannot have
    │   └── UnitError                      a wrong or missing unit
    ├── CaseError                          a case file: which key, which value, what is accepted
    ├── HistoryError                       a recorded history that cannot be used
    ├── LoadError                          a load without steady impacts: it does not push, or is constant
    ├── ResonanceError                     an undamped bar driven at one of its own frequencies
    ├── ConvergenceError                   a computation that failed its own check
    ├── ArchiveError                       an archive that cannot be read, written or continued
    ├── Interrupted                        a long computation that was told to stop; says how to go on
    └── MissingExtraError                  an optional package that is not installed

Every error says the cause first and the remedy after a dash. A question that merely has no answer (no
orbit exists) is not an error: it is a value.

Whatever takes arguments refuses with a ParameterError, or with a CaseError where a case file says it, what it cannot
take, and every picture needs matplotlib (MissingExtraError): docstrings tell of these only where there is more to say.
"""

from __future__ import annotations

from collections.abc import Iterable
from importlib import import_module
from typing import Any

__all__ = [
    "ArchiveError",
    "CaseError",
    "ConvergenceError",
    "HistoryError",
    "Interrupted",
    "LoadError",
    "MissingExtraError",
    "ParameterError",
    "PercussError",
    "ResonanceError",
    "UnitError",
    "UsageError",
    "did_you_mean",
]


class PercussError(Exception):
    """Base of all errors that this package raises on purpose.

    Parameters
    ----------
    message
        What is wrong.
    remedy
        What to do about it; printed after a dash.
    """

    def __init__(self, message: str, remedy: str = "") -> None:
        self.message = message
        self.remedy = remedy
        super().__init__(message)

    def __str__(self) -> str:
        return f"{self.message} — {self.remedy}" if self.remedy else self.message

    def __reduce__(self) -> tuple[object, ...]:
        """Errors travel between processes with all their attributes, whatever their constructors take."""
        return (_remade, (type(self), self.args, self.__dict__.copy()))


class ParameterError(PercussError, ValueError):
    """A value that an object cannot have.

    Attributes
    ----------
    name, value, accepted
        The parameter, what was given, and what would be accepted.
    """

    def __init__(self, name: str, value: object, accepted: str, remedy: str = "") -> None:
        self.name = name
        self.value = value
        self.accepted = accepted
        super().__init__(f"{name} = {_short(value)}: expected {accepted}", remedy)


class UnitError(ParameterError):
    """A quantity with a wrong or missing unit."""


class CaseError(PercussError):
    """A case file that cannot be used; names the file, the key and the value."""

    def __init__(self, file: str, key: str, value: object, accepted: str, remedy: str = "") -> None:
        self.file = file
        self.key = key
        self.value = value
        self.accepted = accepted
        what = f"{key} = {_short(value)}: " if key and value is not None else f"{key}: " if key else ""
        super().__init__(f"{file}: {what}{accepted}", remedy)


class HistoryError(PercussError):
    """A recorded history that cannot be read or cannot be turned into a load."""

    def __init__(self, message: str, remedy: str = "", file: str | None = None) -> None:
        self.file = file
        super().__init__(f"{file}: {message}" if file else message, remedy)


class LoadError(PercussError):
    """A load under which the bar has no steady impacts: it does not push, or it is constant."""


class ResonanceError(PercussError):
    """An undamped bar is driven at its own frequency (B77 16): harmonic k meets elastic mode n; no bounded response."""

    def __init__(self, harmonic: int, mode: int) -> None:
        self.harmonic = harmonic
        self.mode = mode
        super().__init__(
            f"load harmonic k = {harmonic} coincides with the natural frequency of elastic mode n = {mode} "
            f"(s = k/(n pi)) of an undamped bar: the response grows without bound (B77 16)",
            "give the bar some damping, or change s (length, material or frequency) a little",
        )


class ConvergenceError(PercussError):
    """A computation that failed its own check; please report it with the case."""


class ArchiveError(PercussError):
    """An archive, at `path`, that cannot be read, written or continued."""

    def __init__(self, path: str, message: str, remedy: str = "") -> None:
        self.path = path
        super().__init__(f"{path}: {message}", remedy)


class Interrupted(PercussError):
    """A long computation that was told to stop, by Ctrl-C or by its progress callback.

    Attributes
    ----------
    done, size
        Items that were done, of how many.
    archive
        Where they are kept; None when they are lost.
    partial
        What is known so far, as the computation has its results; None where nothing is.
    """

    def __init__(self, done: int, size: int, archive: str | None, remedy: str = "", partial: object = None) -> None:
        self.done = done
        self.size = size
        self.archive = archive
        self.partial = partial
        kept = f"; the finished ones are in {archive}" if archive else ""
        super().__init__(f"interrupted after {done} of {size} items{kept}", remedy)


class MissingExtraError(PercussError):
    """An optional package that is not installed."""

    def __init__(self, package: str, extra: str) -> None:
        self.package = package
        self.extra = extra
        super().__init__(f"the package '{package}' is needed for this", f"pip install 'percuss[{extra}]'")


def extra_package(package: str, extra: str) -> Any:
    """An optional package, imported when it is first needed; MissingExtraError where it is not installed."""
    try:
        return import_module(package)
    except ImportError:
        raise MissingExtraError(package.partition(".")[0], extra) from None


def _remade(kind: type[PercussError], args: tuple[object, ...], state: dict[str, object]) -> PercussError:
    error = kind.__new__(kind, *args)
    error.args = args
    error.__dict__.update(state)
    return error


def _short(value: object, limit: int = 80) -> str:
    try:
        text = repr(value)
    except ValueError:  # a whole number of thousands of digits
        text = "a huge number"
    return text if len(text) <= limit else text[: limit - 1] + "…"


class UsageError(Exception):
    """Arguments of a command line that do not make a command."""


def did_you_mean(word: object, known: Iterable[str]) -> str:
    """``did you mean 'kappa'?``, or nothing when no known word comes near.

    Examples
    --------
    >>> did_you_mean("kapa", ["amplitude", "kappa"])
    "did you mean 'kappa'?"
    """
    import difflib  # not needed before something is wrong

    names = {name.lower(): name for name in known}
    close = difflib.get_close_matches(str(word).lower(), names, n=1, cutoff=0.6)
    return f"did you mean '{names[close[0]]}'?" if close else ""
