"""With what, and by which command, numbers were made."""

from __future__ import annotations

import os
import platform
import shlex
from collections.abc import Sequence
from importlib import metadata

from percuss._version import __version__

__all__ = ["command", "versions"]

_LIBRARIES = ("numpy", "numba")


def versions() -> dict[str, str]:
    """Of this package, Python, and the libraries on which the last bits of a number may depend.

    Examples
    --------
    >>> sorted(versions())
    ['numba', 'numpy', 'percuss', 'python']
    """
    found = {"percuss": __version__, "python": platform.python_version()}
    for name in _LIBRARIES:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            found[name] = "none"
    return found


def command(arguments: Sequence[str]) -> str:
    """How a process was started, from its `sys.argv`; empty when nobody typed it.

    Examples
    --------
    >>> command(["/usr/bin/percuss", "sweep", "my case.toml"]), command(["study.py", "3"]), command([""])
    ("percuss sweep 'my case.toml'", 'python study.py 3', '')
    """
    if not arguments or not arguments[0] or arguments[0] in ("-c", "-"):
        return ""
    program, *rest = arguments
    name = os.path.basename(program)
    if name == "ipykernel_launcher.py":  # a notebook: its temporary connection file tells nobody anything
        return ""
    if name == "__main__.py":
        name = os.path.basename(os.path.dirname(program))
    elif name.endswith(".py"):
        name = f"python {shlex.quote(program)}"
    return " ".join([name.removesuffix(".exe"), *(shlex.quote(word) for word in rest)])
