"""Functions made into machine code together with what they call."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numba import njit

from percuss import compiled as machine_code
from percuss.compiled import pipelines

PART, WHOLE = pipelines()
UNSEEN: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}


@njit(**UNSEEN, **PART)
def doubled(x):  # type: ignore[no-untyped-def]
    return 2.0 * x


@njit(**UNSEEN, **PART)
def summed(values):  # type: ignore[no-untyped-def]
    total = 0.0
    for i in range(values.shape[0]):
        total += doubled(doubled(values[i]))
    return total


@njit(**WHOLE)
def one_more(values):  # type: ignore[no-untyped-def]
    return summed(values) + doubled(0.5)


@njit(**WHOLE)
def one_less(values):  # type: ignore[no-untyped-def]
    return summed(values) - doubled(0.5)


@njit
def plainly(values):  # type: ignore[no-untyped-def]
    return summed(values)


def visible(function: Any) -> list[str]:
    """Functions in the machine code of one that are seen from outside."""
    [compiled] = function.overloads.values()
    found = compiled.library.get_defined_functions()
    return [each.name for each in found if each.linkage.name != "internal"]


def test_a_whole_does_what_its_parts_do() -> None:
    values = np.array([1.0, 2.5, -4.0])
    assert one_more(values) == -1.0
    assert one_less(values) == -3.0  # takes up the same parts again


def test_numbas_own_functions_may_call_parts() -> None:
    assert plainly(np.array([1.0, 2.5, -4.0])) == -2.0


def test_parts_are_hidden() -> None:
    """Else the first whole that is loaded lends its copies to all others."""
    one_more(np.ones(2))
    names = visible(one_more)
    assert names
    assert all("one_more" in name for name in names)


def test_parts_have_no_machine_code_of_their_own() -> None:
    one_more(np.ones(2))
    [compiled] = doubled.overloads.values()
    assert compiled.library.get_pointer_to_function(compiled.fndesc.llvm_func_name) == 0


def test_a_numba_without_the_names_compiles_as_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine_code, "_KNOWN", (*machine_code._KNOWN, "name_of_another_version"))
    assert pipelines() == ({}, {})
