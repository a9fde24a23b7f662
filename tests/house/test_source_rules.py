"""What the source is held to: no circle of imports; who alone does algebra with R, spells modes out, writes files."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

import percuss

PACKAGE = Path(percuss.__file__).parent


@cache
def sources(root: Path = PACKAGE) -> dict[str, tuple[str, ast.Module]]:
    """Text and syntax of every file of a package, by its path in it."""
    texts = {path.relative_to(root).as_posix(): path.read_text(encoding="utf-8") for path in root.rglob("*.py")}
    return {name: (text, ast.parse(text)) for name, text in texts.items()}


# -- imports ----------------------------------------------------------------------------------------------------------


def imported(tree: ast.AST, module: str, is_package: bool, known: set[str]) -> Iterator[str]:
    """The modules of the package that a module names in any import: at its top, for types, and inside functions."""
    for node in ast.walk(tree):
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


@cache
def graph(root: Path = PACKAGE) -> dict[str, set[str]]:
    """Every module of a package and the modules it imports, named from the package's root."""
    names = {
        path: ".".join([root.name, *path.removesuffix(".py").removesuffix("__init__").strip("/").split("/")]).strip(".")
        for path in sources(root)
    }
    known = set(names.values())
    return {
        name: set(imported(sources(root)[path][1], name, path.endswith("__init__.py"), known))
        for path, name in names.items()
    }


def test_there_is_no_way_from_a_module_back_to_itself() -> None:
    """Not even for the name of a type or inside a function: each can be read, and tested, by itself."""
    TopologicalSorter(graph()).prepare()


def test_kernels_import_nothing_of_ours_but_their_room() -> None:
    """Plain functions of numbers, arrays and records, so that they can be compiled for another device."""
    oil = {"percuss.mechanics.oil_records", "percuss.mechanics.oil_series"}  # the law, for every motion
    for name, others in graph().items():
        room, kernels, _ = name.partition(".kernels")
        if kernels or name in oil:
            own = {other for other in others if kernels and other.startswith(room + kernels)}
            assert others - own - oil <= {"percuss.compiled"}, name


@pytest.mark.parametrize(
    "texts",
    [
        {"a": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from box.b import B\n", "b": "import box.a\n"},
        {"a": "import box.b\n", "b": "def f():\n    from box import a\n"},
        {"a": "from .b import x\n", "b": "from . import c\n", "c": "import box.a\n", "d": "import box.a\n"},
    ],
)
def test_circles_of_every_kind_are_seen(tmp_path: Path, texts: dict[str, str]) -> None:
    root = tmp_path / "box"
    root.mkdir()
    for name, text in {"__init__": "", **texts}.items():
        (root / f"{name}.py").write_text(text, encoding="utf-8")
    with pytest.raises(CycleError) as caught:
        TopologicalSorter(graph(root)).prepare()
    assert set(caught.value.args[1]) == {f"box.{name}" for name in texts} - {"box.d"}


# -- algebra with R: elsewhere −R, 1 + R, 1 − R² are asked of the law of the contact, which may be another ------------

WITH_R = {
    "paper/claim_common.py",  # the curves that B77 prints, with his R
    "blow/closed_forms.py", "case/answers/blows/blow_answer.py",  # R is what comes out of a blow by waves, and no law
    "simulate/kernels/wall.py", "simulate/kernels/motion.py",  # to which R comes as a number of their record
}  # fmt: skip


def is_restitution(node: ast.expr, known: set[str]) -> bool:
    """Whether an expression is R: the name, an attribute of that name, a name that stands for it, or some of it."""
    match node:
        case ast.Name(name):
            return name == "restitution" or name in known
        case ast.Attribute(attr=name):
            return name == "restitution"
        case ast.Subscript(value=value) | ast.Starred(value=value):
            return is_restitution(value, known)
        case ast.Call(func=called, args=arguments):
            name = called.attr if isinstance(called, ast.Attribute) else getattr(called, "id", "")
            return name in ("float", "asarray", "array", "reshape") and any(is_restitution(a, known) for a in arguments)
    return False


def aliases(function: ast.AST) -> set[str]:
    """The names that stand for R in a function, or in a whole file."""
    found: set[str] = set()
    for node in (node for node in ast.walk(function) if isinstance(node, ast.Assign)):
        for target in node.targets:
            both = isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple)
            pairs = zip(target.elts, node.value.elts, strict=False) if both else [(target, node.value)]  # type: ignore[attr-defined]
            found |= {to.id for to, of in pairs if isinstance(to, ast.Name) and is_restitution(of, found)}
    return found


def algebra(tree: ast.AST) -> bool:
    """Whether R is added, multiplied, negated, or compared with a number in a program."""
    for function in [n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef)] or [tree]:
        known = aliases(function)
        for node in ast.walk(function):
            match node:
                case ast.BinOp(left=one, right=other) | ast.AugAssign(target=one, value=other):
                    parts = [one, other]
                case ast.UnaryOp(op=ast.USub(), operand=one):
                    parts = [one]
                case ast.Compare(left=ast.Attribute() as one, comparators=[ast.Constant(value=float())]):
                    parts = [one]
                case _:
                    continue
            if any(is_restitution(part, known) for part in parts):
                return True
    return False


SEEN = (
    "taken = (1.0 - system.restitution**2) * energy",
    "def f(system):\n    r, d = system.restitution, system.d\n    return 1.0 + r",
    "def f(system):\n    r = float(system.restitution)\n    return -r * speed",
    "speed *= -bar.restitution",
    "speed *= bar.restitution",
    "def f(restitution):\n    return (1.0 - restitution[cells]) / 2.0",
    "if motion.system.restitution == 0.0: pass",
)
LEFT = (
    "beta = contact.velocity_factors(restitution)\nspeed = 1.0 + beta",
    "def f(system):\n    r = system.restitution\n    return curve_at(mean, d, r, period) / 2.0",
    "def f(r):\n    return 1.0 + r",
    "system = system.with_restitution(0.5)",
)


def test_nothing_but_the_contact_room_does_algebra_with_the_restitution() -> None:
    for texts, seen in ((SEEN, True), (LEFT, False)):
        assert [text for text in texts if algebra(ast.parse(text)) != seen] == []
    asked = {name: tree for name, (text, tree) in sources().items() if "restitution" in text}
    assert {name for name, tree in asked.items() if not name.startswith("model/contact") and algebra(tree)} == WITH_R


# -- the modes of a uniform bar, nπs, (−1)ⁿ and cos nπx, are known to bodies alone ------------------------------------

SPELLINGS = re.compile(
    r"\bpi \* (?:np\.outer\()?(?:\w+\.)*s\b|\b(?:\w+\.)*s \* (?:np|math)\.pi\b|\bnp\.pi \* (?:\w+\.)+s\b"
    r"|cos\((?:np|math)\.pi \*"
    r"|% 2, -?\d\.0, -?\d\.0\)|\(-1(?:\.0)?\) ?\*\* ?"
)


def test_only_bodies_know_their_modes() -> None:
    for text in ("np.pi * s * n", "math.pi * system.s", "np.cos(np.pi * np.outer(n, x))", "np.where(n % 2, -2.0, 2.0)",
                 "(-1.0) ** n"):  # fmt: skip
        assert SPELLINGS.search(text), text
    for text in ("T = 2.0 * math.pi * periods", "np.pi * seconds", "s / (math.pi * k)", "n % 2 == 0"):
        assert not SPELLINGS.search(text), text
    knowing = {name for name, (text, _) in sources().items() if "model/body" not in name and SPELLINGS.search(text)}
    assert knowing == {"steady/resting/rest_on_wall.py"}  # a closed form of that bar alone, echo by echo


# -- files are written by one helper ----------------------------------------------------------------------------------

WRITING = {
    "atomic_write.py",
    "explore/jobs/archive.py",  # records are added to it; its own check sums tell what is whole
    "case/uploads/upload.py",  # in a folder of its own that goes away
    "web/serving.py",  # so too: the page that leads the browser to the address
}


def written(text: str, tree: ast.AST) -> Iterator[int]:
    """The lines that write, rename or save a file, but for what is opened in a block of the helper."""
    lines = text.splitlines()
    for node in (node for node in ast.walk(tree) if isinstance(node, ast.Call)):
        of = node.func.value if isinstance(node.func, ast.Attribute) else None
        called = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        said = [*node.args[1:2], *(word.value for word in node.keywords if word.arg == "mode")]
        modes = [str(one.value) for one in said if isinstance(one, ast.Constant) and isinstance(one.value, str)]
        opened = called == "open" and any(set(mode) & set("wax+") for mode in modes)
        helped = "whole_file(" in lines[node.lineno - 1] or "replaced(" in lines[node.lineno - 1]
        if (
            called in ("write_text", "write_bytes", "to_netcdf", "to_csv", "savetxt", "imsave")
            or (called == "replace" and getattr(of, "id", "") == "os")
            or (opened and not helped)
        ):
            yield node.lineno


def test_every_writer_uses_the_helper() -> None:
    assert {name for name, source in sources().items() if list(written(*source))} <= WRITING


def test_a_module_gives_a_name_one_value() -> None:
    """A constant set a second time, far below, changes what stands above it: no linter says so."""
    for name, (_, tree) in sources().items():
        assigned = [node for node in tree.body if isinstance(node, ast.Assign)]
        given = [target.id for node in assigned for target in node.targets if isinstance(target, ast.Name)]
        assert len(set(given)) == len(given), name
