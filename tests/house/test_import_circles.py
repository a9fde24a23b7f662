"""No two modules of the package need each other, not even for the name of a type or inside a function.

A result and its writer are the usual pair: the writer takes what the result is made of, and the result's method hands
it over. Then each can be read, and tested, by itself.
"""

import ast
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[2] / "src" / "percuss"


def imported(text: str, module: str, is_package: bool, known: set[str]) -> Iterator[str]:
    """The modules of the package that a module names in any import: at its top, for types, and inside functions."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            here = module.split(".") if is_package else module.split(".")[:-1]
            base = here[: len(here) - node.level + 1] if node.level else []
            start = ".".join([*base, *([node.module] if node.module else [])])
            inner = [f"{start}.{alias.name}" for alias in node.names]
            names = [name if name in known else start for name in inner]
        else:
            continue
        yield from (name for name in names if name in known and name != module)


def graph(root: Path) -> dict[str, set[str]]:
    """Every module of a package and the modules it imports, named from the package's root."""
    files = {path: path.relative_to(root.parent).with_suffix("").parts for path in root.rglob("*.py")}
    names = {path: ".".join(parts[:-1] if parts[-1] == "__init__" else parts) for path, parts in files.items()}
    known = set(names.values())
    return {
        name: set(imported(path.read_text(encoding="utf-8"), name, path.stem == "__init__", known))
        for path, name in names.items()
    }


@pytest.fixture(scope="module")
def package() -> dict[str, set[str]]:
    return graph(PACKAGE)


def test_there_is_no_way_from_a_module_back_to_itself(package: dict[str, set[str]]) -> None:
    TopologicalSorter(package).prepare()


def test_kernels_import_nothing_of_ours_but_their_room(package: dict[str, set[str]]) -> None:
    """Plain functions of numbers, arrays and records, so that they can be compiled for another device."""
    for name, others in package.items():
        room, kernels, _ = name.partition(".kernels")
        if kernels:
            assert {other for other in others if not other.startswith(room + kernels)} <= {"percuss.compiled"}, name


@pytest.mark.parametrize(
    "texts",
    [
        {"a": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from box.b import B\n", "b": "import box.a\n"},
        {"a": "import box.b\n", "b": "def f():\n    from box import a\n"},
        {"a": "from .b import x\n", "b": "from . import c\n", "c": "import box.a\n", "d": "import box.a\n"},
    ],
)
def test_circles_of_every_kind_are_seen(tmp_path: Path, texts: dict[str, str]) -> None:
    """Two modules that meet for a type or inside a function, and three in a ring by relative imports."""
    root = tmp_path / "box"
    root.mkdir()
    for name, text in {"__init__": "", **texts}.items():
        (root / f"{name}.py").write_text(text, encoding="utf-8")
    with pytest.raises(CycleError) as caught:
        TopologicalSorter(graph(root)).prepare()
    assert set(caught.value.args[1]) == {f"box.{name}" for name in texts} - {"box.d"}
