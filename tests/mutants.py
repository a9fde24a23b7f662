"""Whether tests still prove what they proved: small faults are put into a copy of the source, and the tests must fail.

Before a file of tests is cut, and after it, with the same seed (the same faults, as long as the source is the same)::

    .venv/bin/python tests/mutants.py src/percuss/model/system.py --count 20 --save before.json -- tests/model
    .venv/bin/python tests/mutants.py src/percuss/model/system.py --count 20 --against before.json -- tests/model

Whatever died before must die again; the second command names what does not, and fails. What follows ``--`` goes to
pytest. A fault is a sign, a constant, a comparison, an index or an ``and``/``or`` turned, in code alone. After a fault
in a kernel all of them are compiled again; with ``NUMBA_DISABLE_JIT=1`` in the environment they run as Python.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TURNED = {
    ast.Add: "-", ast.Sub: "+", ast.Mult: "/", ast.Div: "*", ast.Pow: "*",
    ast.Lt: "<=", ast.LtE: "<", ast.Gt: ">=", ast.GtE: ">", ast.Eq: "!=", ast.NotEq: "==",
    ast.And: "or", ast.Or: "and", ast.Is: "is not", ast.IsNot: "is", ast.In: "not in", ast.NotIn: "in",
}  # fmt: skip

Fault = tuple[int, int, int, str]
"""Where a text begins and ends in the bytes of a file, the line, and what stands there instead."""


def faults(source: bytes) -> Iterator[Fault]:
    """Every fault that can be put into a source, annotations and texts aside."""
    starts = [0]
    for line in source.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))

    def begin(node: ast.AST) -> int:
        return starts[node.lineno - 1] + node.col_offset  # type: ignore[attr-defined]

    def end(node: ast.AST) -> int:
        return starts[node.end_lineno - 1] + node.end_col_offset  # type: ignore[attr-defined]

    def between(left: ast.expr, right: ast.expr, kind: ast.AST) -> Iterator[Fault]:
        first, last = end(left), begin(right)
        gap = source[first:last].decode()
        word = gap.strip(" ()\n\\")
        if type(kind) in TURNED and word and gap.count(word) == 1:
            yield first, last, left.lineno, gap.replace(word, TURNED[type(kind)])

    def inside(node: ast.AST) -> Iterator[Fault]:
        match node:
            case ast.BinOp(left=left, op=kind, right=right):
                yield from between(left, right, kind)
            case ast.Compare(left=left, ops=[kind], comparators=[right]):
                yield from between(left, right, kind)
            case ast.BoolOp(op=kind, values=[left, right, *_]):
                yield from between(left, right, kind)
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                yield begin(node), begin(operand), node.lineno, ""
            case ast.UnaryOp(op=ast.Not(), operand=operand):
                yield begin(node), begin(operand), node.lineno, ""
            case ast.Constant(value=bool() as value):
                yield begin(node), end(node), node.lineno, str(not value)
            case ast.Constant(value=int() | float() as value):
                yield begin(node), end(node), node.lineno, f"({value + 1!r})"
        for name, field in ast.iter_fields(node):
            if name in ("annotation", "returns", "decorator_list"):
                continue
            for child in field if isinstance(field, list) else [field]:
                if isinstance(child, ast.AST):
                    yield from inside(child)

    yield from inside(ast.parse(source))


def dies(file: Path, text: bytes, pytest: list[str], seconds: float) -> bool:
    """Whether the tests fail when a file of the package has another text."""
    compiled = (
        "kernels" in str(file) or b"percuss.compiled" in text
    )  # then what is compiled already is not of this text
    with tempfile.TemporaryDirectory() as folder:
        left = shutil.ignore_patterns(*(["*.nbc", "*.nbi"] if compiled else []))
        shutil.copytree(ROOT / "src", Path(folder, "src"), ignore=left)
        Path(folder, file.relative_to(ROOT)).write_bytes(text)
        path = os.pathsep.join([str(Path(folder, "src")), os.environ.get("PYTHONPATH", "")])
        command = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", "-m", "not slow", *pytest]
        told = {**os.environ, "PYTHONPATH": path, "PYTHONDONTWRITEBYTECODE": "1", "OPENBLAS_NUM_THREADS": "1"}
        try:
            done = subprocess.run(command, cwd=ROOT, env=told, capture_output=True, text=True, timeout=seconds)
        except subprocess.TimeoutExpired:
            return True
    if done.returncode > 2:
        raise SystemExit(f"pytest could not run:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done.returncode != 0


def main() -> None:
    about, _, pytest = " ".join(sys.argv[1:]).partition(" -- ")
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", type=Path)
    parser.add_argument("--count", type=int, default=20, help="faults in each file")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=300.0, help="a run that takes longer has failed")
    parser.add_argument("--save", type=Path, help="keep what died")
    parser.add_argument("--against", type=Path, help="what died before; only that is tried again")
    given = parser.parse_args(about.split())
    before = json.loads(given.against.read_text()) if given.against else None
    died: dict[str, bool] = {}
    for file in (path.resolve() for path in given.files):
        source = file.read_bytes()
        if dies(file, source, pytest.split(), given.seconds):
            raise SystemExit("the tests fail as they are")
        every = list(faults(source))
        for first, last, line, put in random.Random(given.seed).sample(every, min(given.count, len(every))):
            name = f"{file.relative_to(ROOT)}:{line}:{first}: {source[first:last].decode()!r} -> {put!r}"
            if before is None or before.get(name):
                died[name] = dies(file, source[:first] + put.encode() + source[last:], pytest.split(), given.seconds)
                print("died " if died[name] else "LIVES", name, flush=True)
    print(f"{sum(died.values())} of {len(died)} died")
    if given.save:
        given.save.write_text(json.dumps(died, indent=1))
    if before is not None and not all(died.values()):
        raise SystemExit("the tests see less than before")


if __name__ == "__main__":
    main()
