"""No two modules of the package need each other, not even for the name of a type or inside a function.

A result and its writer are the usual pair: the writer takes what the result is made of, and the result's method hands
it over. Then each can be read, and tested, by itself.
"""

import ast
from collections.abc import Iterator
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


def pairs(found: dict[str, set[str]]) -> set[frozenset[str]]:
    """The pairs of modules that import each other."""
    return {frozenset({a, b}) for a, others in found.items() for b in others if a in found[b]}


def circles(found: dict[str, set[str]]) -> list[set[str]]:
    """The largest sets of modules in which each leads to all others (Tarjan's strongly connected components)."""
    order: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    out: list[set[str]] = []

    def visit(name: str) -> None:
        order[name] = low[name] = len(order)
        stack.append(name)
        for other in found[name]:
            if other not in order:
                visit(other)
            if other in stack:
                low[name] = min(low[name], low[other])
        if low[name] == order[name]:
            at = stack.index(name)
            out.append(set(stack[at:]))
            del stack[at:]

    for name in found:
        if name not in order:
            visit(name)
    return [circle for circle in out if len(circle) > 1]


def short(names: set[str] | frozenset[str]) -> frozenset[str]:
    return frozenset(name.removeprefix("percuss.") for name in names)


@pytest.fixture(scope="module")
def package() -> dict[str, set[str]]:
    return graph(PACKAGE)


def test_no_two_modules_import_each_other(package: dict[str, set[str]]) -> None:
    assert {short(pair) for pair in pairs(package)} == set()


def test_no_longer_circle_of_imports_either(package: dict[str, set[str]]) -> None:
    """There is no way from a module back to itself."""
    assert [sorted(short(circle)) for circle in circles(package)] == []


def test_kernels_import_nothing_of_ours_but_their_room(package: dict[str, set[str]]) -> None:
    """Plain functions of numbers, arrays and records, so that they can be compiled for another device."""
    for name, others in package.items():
        room, kernels, _ = name.partition(".kernels")
        if kernels:
            assert {other for other in others if not other.startswith(room + kernels)} <= {"percuss.compiled"}, name


def test_circles_of_every_kind_are_seen(tmp_path: Path) -> None:
    """Two modules that meet for a type and inside a function, and three in a ring by relative imports."""
    root = tmp_path / "box"
    root.mkdir()
    texts = {
        "__init__": "",
        "a": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from box.b import B\n",
        "b": "def f():\n    from box import a\n",
        "c": "from .d import x\n",
        "d": "from . import e\n",
        "e": "import box.c\n",
        "f": "import box.a\n",
    }
    for name, text in texts.items():
        (root / f"{name}.py").write_text(text, encoding="utf-8")
    found = graph(root)
    assert pairs(found) == {frozenset({"box.a", "box.b"})}
    assert sorted(sorted(circle) for circle in circles(found)) == [["box.a", "box.b"], ["box.c", "box.d", "box.e"]]
