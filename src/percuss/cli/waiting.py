"""What a person is told at a terminal while a command is silent: what it is at, whatever the command.

A thread looks at where the command is. Commands need not say it themselves, and none can forget to.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import threading

PATIENCE = 2.0  # seconds of silence that need no word; later ones may be longer, by a share of what has gone by
_SHARE = 0.3
_LOOKS = 0.25  # seconds between two looks
COMPILING = "compiling the kernels once, about 20 s; later runs take them from a cache"
_COMPILED = 1.0  # seconds after which that is said

_OTHERWISE = "computing"

_ROOMS = {
    "recordings": "reading the recording",
    "steady/recorded": "reading the valve out of the record",
    "steady/self_excited": "following the machine's cycle",
    "steady/periodic": "looking for orbits",
    "steady/resting": "looking for cycles with rest",
    "steady": "solving for steady motions",
    "stability": "judging stability",
    "simulate": "simulating",
    "blow": "following the waves of a blow",
    "explore": "going through the parameters",
    "plot": "drawing",
}
"""What the rooms do; one in another goes first."""

_HOUSE = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))
_last_sign = 0.0


def sign() -> None:
    """Something was shown: the silence begins anew."""
    global _last_sign
    _last_sign = time.monotonic()


@contextmanager
def telling(command: str) -> Iterator[None]:
    """A block after whose silences a person is told what goes on; nothing is told where nobody sits at a terminal."""
    if sys.stderr is None or not sys.stderr.isatty():
        yield
        return
    import threading

    ended = threading.Event()
    sign()
    teller = threading.Thread(target=_tell, args=(command, threading.get_ident(), ended), daemon=True)
    teller.start()
    try:
        yield
    finally:
        ended.set()
        teller.join()


def _tell(command: str, thread: int, ended: threading.Event) -> None:
    """Each thing once, until the end."""
    begun, told = time.monotonic(), set[str]()
    while not ended.wait(min(_LOOKS, PATIENCE)):
        now = time.monotonic()
        silent, patience = now - _last_sign, max(PATIENCE, _SHARE * (now - begun) if told else 0.0)
        if silent < min(_COMPILED, PATIENCE):
            continue
        what = doing(thread)
        if silent < patience and (what != COMPILING or what in told):
            continue
        if what not in told:
            told.add(what)
            print(f"percuss: {command}: {what}", file=sys.stderr, flush=True)
        sign()


def doing(thread: int) -> str:
    """What a thread is at, by the functions that it is in."""
    frame: FrameType | None = sys._current_frames().get(thread)
    found = ""
    while frame is not None:
        file = frame.f_code.co_filename
        if file.startswith(_HOUSE):
            room = file[len(_HOUSE) + 1 :].replace("\\", "/")
            if room == "compiled.py" and frame.f_code.co_name == "compile_extra":
                return COMPILING
            found = found or next((what for name, what in _ROOMS.items() if room.startswith(f"{name}/")), "")
        frame = frame.f_back
    return found or _OTHERWISE
