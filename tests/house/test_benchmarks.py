"""The benchmarks are not run by the tests; that what they take from the package is there, is."""

from __future__ import annotations

import ast
import importlib
import importlib.util
from pathlib import Path

import pytest

BENCHMARKS = sorted((Path(__file__).parents[2] / "benchmarks").glob("*.py"))


@pytest.mark.parametrize("path", BENCHMARKS, ids=lambda path: path.stem)
def test_what_a_benchmark_imports_exists(path: Path) -> None:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("percuss"):
            module = importlib.import_module(str(node.module))
            for name in node.names:
                assert hasattr(module, name.name) or importlib.util.find_spec(f"{node.module}.{name.name}"), name.name


def test_what_is_compared_along_a_branch_is_the_same() -> None:
    found = importlib.util.spec_from_file_location("orbits", BENCHMARKS[0].parent / "orbits.py")
    assert found is not None and found.loader is not None
    orbits = importlib.util.module_from_spec(found)
    found.loader.exec_module(orbits)
    orbit = orbits.orbit_near(orbits.hammer(), [0.39, 2.32], modes=2)
    fast, plain = orbits.walked(orbit, 3), orbits.walked_plainly(orbit, 3)
    assert fast.x == pytest.approx(plain.x, abs=1e-10)
    assert fast.tangent == pytest.approx(plain.tangent, abs=1e-6)
