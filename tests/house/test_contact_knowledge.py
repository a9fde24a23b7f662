"""Only the contact room does algebra with R: elsewhere −R, 1 + R, 1 − R² are asked of the law, which may be another."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import percuss

SOURCE = Path(percuss.__file__).parent

PUBLISHED = {"paper/claim_common.py"}
"""The curves that B77 prints, with his R: what the floors below compute is compared with them."""

RESOLVED = {"blow/closed_forms.py", "case/answers/blow_answer.py"}
"""Blows by waves in closed form: R is what comes out of them, and no law."""

COMPILED = {"simulate/kernels/wall.py", "simulate/kernels/motion.py"}
"""Compiled functions see no objects: R comes to them as a number of their record."""


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
    for node in ast.walk(function):
        if not isinstance(node, ast.Assign):
            continue
        for target in node.targets:
            both = isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple)
            pairs = zip(target.elts, node.value.elts, strict=False) if both else [(target, node.value)]  # type: ignore[attr-defined]
            found |= {to.id for to, of in pairs if isinstance(to, ast.Name) and is_restitution(of, found)}
    return found


def algebra(text: str) -> list[int]:
    """The lines of a program on which R is added, multiplied, negated, or compared with a number."""
    return sorted(set(_lines(ast.parse(text))))


def _lines(tree: ast.AST) -> Iterator[int]:
    for function in [n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef)] or [tree]:
        known = aliases(function)
        for node in ast.walk(function):
            match node:
                case ast.BinOp(left=left, right=right) if is_restitution(left, known) or is_restitution(right, known):
                    yield node.lineno
                case ast.UnaryOp(op=ast.USub(), operand=operand) if is_restitution(operand, known):
                    yield node.lineno
                case ast.AugAssign(target=target, value=value) if is_restitution(value, known) or is_restitution(
                    target, known
                ):
                    yield node.lineno
                case ast.Compare(left=ast.Attribute() as left, comparators=[ast.Constant(value=float())]) if (
                    is_restitution(left, known)
                ):
                    yield node.lineno


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
    "speed = contact.velocity_factor * before",
    "beta = contact.velocity_factors(restitution)\nspeed = 1.0 + beta",
    "def f(system):\n    r = system.restitution\n    return curve_at(mean, d, r, period) / 2.0",
    "def f(r):\n    return 1.0 + r",
    "system = system.with_restitution(0.5)",
)


def test_the_algebra_is_seen_and_nothing_else_is() -> None:
    assert [text for text in SEEN if not algebra(text)] == [] == [text for text in LEFT if algebra(text)]


def test_nothing_but_the_contact_room_does_algebra_with_the_restitution() -> None:
    files = [path for path in SOURCE.rglob("*.py") if "model/contact" not in path.as_posix()]
    found = {
        path.relative_to(SOURCE).as_posix(): lines
        for path in files
        if (lines := algebra(path.read_text(encoding="utf-8")))
    }
    assert found.keys() == PUBLISHED | RESOLVED | COMPILED, found
