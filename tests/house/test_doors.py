"""Every public callable, walked with wrong objects in every parameter: an error of the package, or what is written."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from fnmatch import fnmatchcase
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from doors import (
    LEFT_OUT,
    MEANT,
    NAMED_ELSE,
    NOT_NONE,
    SHORT,
    SYSTEM,
    WRONG,
    Arguments,
    Two,
    doors,
    meant,
    parameters,
    public,
)
from percuss import Load, Starts, explore, run
from percuss.errors import ParameterError, PercussError


@pytest.fixture(scope="module")
def arguments(tmp_path_factory: pytest.TempPathFactory) -> Arguments:
    return Arguments(tmp_path_factory.mktemp("doors"))


def test_every_public_callable_is_in_the_table(arguments: Arguments) -> None:
    """Whatever is public has a valid call with all of its parameters; nothing told of another is left over."""
    every = doors()
    places = {f"{name}.{parameter}" for name, found in every.items() for parameter in parameters(found)}
    assert {name for name, _ in public()} >= LEFT_OUT
    assert places >= NOT_NONE
    for told, patterns in MEANT:
        assert told == "nothing" or set(told.split(", ")) <= set(WRONG)
        assert [one for one in patterns.split() if not any(fnmatchcase(place, one) for place in places)] == []
    assert [one for one in arguments.own if not any(fnmatchcase(name, one) for name in every)] == []
    for name, found in every.items():
        arguments.of(name, found)


def is_named(door: str, parameter: str, error: str, fits: Iterable[str]) -> bool:
    """Whether an error of the physics names what is wrong, by the word that users know, or what it does not fit to."""
    words = [parameter, *NAMED_ELSE.get(parameter, "").split(), *fits]
    far = door.startswith(("case.", "explore.", "plot."))
    return far or any(re.search(rf"\b{word}\b", error) for word in words)


@pytest.mark.parametrize("name", doors())
def test_wrong_objects_give_errors_of_the_package(
    name: str, arguments: Arguments, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    function, given = arguments.of(name, doors()[name])
    function(**given)
    told = []
    for parameter in given:
        takes = meant(name, parameter)
        for wrong, value in WRONG.items():
            try:
                function(**{**given, parameter: value})
            except PercussError as error:
                if wrong in takes and wrong != "class":
                    told.append(f"{parameter}={wrong}: refused: {error}")
                elif len(str(error)) > 700:
                    told.append(f"{parameter}={wrong}: told at length: {len(str(error))}")
                elif not is_named(name, parameter, str(error), given if wrong in ("empty", "-1") else ()):
                    told.append(f"{parameter}={wrong}: told without its name: {error}")
            except Exception as error:
                told.append(f"{parameter}={wrong}: {type(error).__name__}: {str(error)[:100]}")
            else:
                if wrong not in takes:
                    told.append(f"{parameter}={wrong}: taken without a word")
    assert not told, "\n".join(told)


def test_numbers_of_any_kind_are_taken() -> None:
    """Whole numbers, numpy's and Python's, exact fractions, and whole numbers beyond 64 bits."""
    for one in (1, np.float32(1.0), np.int8(1), Fraction(1), 1.0):
        assert Load.fourier([one, one]) == Load.fourier([1.0, 1.0])
        assert Load.steps([0, one], [2 * one, one]) == Load.steps([0.0, 1.0], [2.0, 1.0])
        assert float(SYSTEM.load.value(one)) == float(SYSTEM.load.value(1.0))
    assert Load.fourier([10**30, 1j]).mean == 1e30
    assert Load.fourier([[0.3, 0.0], [1.0, 0.5]]).coefficients.tolist() == [0.3, 1.0 + 0.5j]


def test_what_is_none_of_them_is_told_before_anything_is_computed(tmp_path: Path) -> None:
    """A watcher that cannot be called is no reason to compute first; nor is a path that is a number a file."""
    calls: list[int] = []

    class Counting(Two):
        def compute(self, first: int, last: int, stopped: Callable[[], bool]) -> dict[str, Any]:
            calls.append(first)
            return super().compute(first, last, stopped)

    for wrong in ({"progress": "x"}, {"archive": 5}, {"pool": 5}, {"resume": "yes"}, {"chunk": 0.5}):
        with pytest.raises(ParameterError, match=next(iter(wrong))):
            explore.carry_out(Counting(), workers=1, **wrong)
    assert not calls
    with pytest.raises(ParameterError, match="path"):
        run(SYSTEM, modes=0, stop=SHORT).save(1)  # type: ignore[arg-type]  # the number of an open file


def test_a_start_leaves_the_arrays_of_its_maker_alone() -> None:
    mine = np.array([-1.0])
    starts = Starts(mine[:, None], mine[:, None], mine, mine)
    mine[0] = -2.0
    assert starts.gap[0] == -1.0
    assert not len(Starts(np.empty((0, 1)), np.empty((0, 1)), np.empty(0), np.empty(0)))  # of an archive just begun
