"""A Chromium for the tests of the page: one that is there, else one installed now; it never gives up quietly.

On Debian (and what is made from it) the superuser gets the distribution's package, everybody else Playwright's own.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

__all__ = ["FLAGS", "chromium"]

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")

FLAGS = [
    "--disable-gpu",
    "--disable-dev-shm-usage",
    "--autoplay-policy=no-user-gesture-required",
    *(["--no-sandbox"] if hasattr(os, "geteuid") and os.geteuid() == 0 else []),
]
"""What Chromium needs in a container; the superuser cannot have its sandbox."""


def chromium() -> str | None:
    """The path of a Chromium; None for Playwright's own, which it finds itself.

    Raises
    ------
    RuntimeError
        When there is none and none can be installed, with what was tried.
    """
    tried = []
    with _alone():
        for command in (None, *_commands()):
            if command is not None:
                tried.append(_ran(command))
            found = _installed()
            if found is not None:
                return found or None
    raise RuntimeError(
        "no Chromium for the tests of the page; install one (Debian: apt-get install chromium; elsewhere: "
        f"python -m playwright install chromium). Tried:\n{os.linesep.join(tried)}"
    )


def _installed() -> str | None:
    """The path of a browser; an empty text for Playwright's own; None for none."""
    for name in NAMES:
        path = shutil.which(name)
        if path is not None and _starts(path):
            return path
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        return "" if Path(playwright.chromium.executable_path).exists() else None


def _starts(path: str) -> bool:
    """Whether it is a browser and not a stub that asks for a package."""
    try:
        return subprocess.run([path, "--version"], capture_output=True, timeout=60, check=False).returncode == 0
    except (OSError, subprocess.TimeoutExpired):
        return False


def _commands() -> list[list[str]]:
    debian = Path("/etc/debian_version").exists() and shutil.which("apt-get") is not None
    playwright = [[sys.executable, "-m", "playwright", "install", "chromium"]]
    if debian and os.geteuid() == 0:
        install = ["apt-get", "install", "-y", "--no-install-recommends", "chromium"]
        return [install, ["sh", "-c", f"apt-get update && {' '.join(install)}"], *playwright]
    return playwright


def _ran(command: list[str]) -> str:
    """Run it; what it was and how it ended."""
    environment = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
    print(f"tests: installing Chromium: {' '.join(command)}", file=sys.stderr, flush=True)
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=900, check=False, env=environment)
    except (OSError, subprocess.TimeoutExpired) as error:
        return f"  {' '.join(command)}: {error}"
    last = (done.stderr or done.stdout).strip().splitlines()[-1:] or [""]
    return f"  {' '.join(command)}: exit code {done.returncode}; {last[0]}"


@contextmanager
def _alone() -> Iterator[None]:
    """One process of the suite at a time: two package managers would stand in each other's way."""
    with open(Path(tempfile.gettempdir()) / "percuss-tests-chromium.lock", "w", encoding="utf-8") as lock:
        with suppress(ImportError):  # not on Windows
            import fcntl

            fcntl.flock(lock, fcntl.LOCK_EX)
        yield
