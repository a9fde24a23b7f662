"""The door of a room: its names are imported from the modules inside when they are first used; and what rooms lend."""

from __future__ import annotations

import ast
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any


def lazy_names(package: str, file: str) -> tuple[list[str], Callable[[str], object], Callable[[], list[str]]]:
    """``__all__``, ``__getattr__`` and ``__dir__`` of a package, from its imports under ``if TYPE_CHECKING``.

    Parameters
    ----------
    package, file
        ``__name__`` and ``__file__`` of its ``__init__``.
    """
    tree = ast.parse(Path(file).read_text(encoding="utf-8"))
    under = next(node for node in tree.body if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING")
    froms = [node for node in under.body if isinstance(node, ast.ImportFrom)]
    homes = {alias.asname or alias.name: str(node.module) for node in froms for alias in node.names}

    def getattr_(name: str) -> object:
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(import_module(homes[name]), name)

    return sorted(homes), getattr_, lambda: sorted(homes)


_LENT: dict[str, str] = {}


def lend(name: str, room: str) -> None:
    """Whoever knows all rooms says which of them has a function that those below it hand on."""
    _LENT[name] = room


def lent(name: str) -> Callable[..., Any]:
    """The function that a room above lends; it is imported when it is first asked for."""
    found: Callable[..., Any] = getattr(import_module(_LENT[name]), name)
    return found
