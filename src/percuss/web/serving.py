"""Runs the workbench with uvicorn: the socket, the workers, the browser, and an end without loose threads."""

from __future__ import annotations

import errno
import gc
import multiprocessing
import os
import signal
import socket
import sys
import tempfile
import threading
import time
import webbrowser
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from multiprocessing.connection import wait
from pathlib import Path
from typing import TYPE_CHECKING

import uvicorn

from percuss.errors import PercussError
from percuss.web.settings import Settings, is_loopback

if TYPE_CHECKING:
    from multiprocessing.process import BaseProcess
    from types import FrameType

_GRACE = 1  # seconds that requests under way have to end after the server is told to stop
_REMEDIES: dict[int | None, str] = {
    errno.EADDRINUSE: "--port 0 takes a free port",
    errno.EACCES: "ports below 1024 are reserved for the system: --port 8321, or --port 0 for a free one",
}

_OPEN = """\
percuss: listening on {host}: everyone who can reach this machine and has the token can use it to compute.
percuss: what is sent is not encrypted; in a network that is not yours, put a reverse proxy with TLS in front of it."""

_TICK = 0.1  # seconds between two looks of the supervisor at whether the end is asked for
_TURN = 1e-3
"""Seconds that a long computation goes on while a quick question waits; Python's own 5 ms are a whole answer."""

_TIDY = 0.3  # seconds that threads have to notice the end and to remove their temporary files


def address(settings: Settings) -> str:
    """Where the page is, with the token behind the #, which browsers do not send."""
    host = {"0.0.0.0": "127.0.0.1", "::": "[::1]"}.get(settings.host, settings.host)
    host = f"[{host}]" if ":" in host and not host.startswith("[") else host
    token = f"#token={settings.token}" if settings.token else ""
    return f"http://{host}:{settings.port}/{token}"


def bound(host: str, port: int) -> socket.socket:
    """A socket that listens there; port 0 takes a free one."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    # with its protocol: asyncio turns off the waiting for small packets only where it is said to be TCP
    found = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    try:
        if os.name == "posix":  # elsewhere it would let two servers share the port
            found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        found.bind((host.strip("[]"), port))
        found.listen(1024)
    except (OSError, UnicodeError) as error:
        found.close()
        reason = getattr(error, "strerror", None) or str(error)
        remedy = _REMEDIES.get(getattr(error, "errno", None), "--host takes an address of this machine")
        raise PercussError(f"cannot listen on {host}, port {port}: {reason}", remedy) from None
    found.set_inheritable(True)
    return found


def serve(settings: Settings, workers: int = 1, browser: bool = True) -> None:
    """Serve the workbench until Ctrl-C or SIGTERM.

    Parameters
    ----------
    workers
        Processes; requests are stateless, so that any of them answers any.
    browser
        Whether to open the page, where there is a screen.

    Raises
    ------
    PercussError
        When the address cannot be listened on, or a package is missing.
    """
    listening = bound(settings.host, settings.port)
    settings = replace(settings, port=listening.getsockname()[1])
    if not is_loopback(settings.host):
        print(_OPEN.format(host=settings.host), file=sys.stderr, flush=True)

    with tempfile.TemporaryDirectory(prefix="percuss-") if settings.token else nullcontext("") as folder:

        def tell() -> None:
            print(f"percuss workbench: {address(settings)}  (Ctrl-C ends it)", flush=True)
            if browser and _has_screen():
                webbrowser.open(to_open(settings, folder))

        if workers == 1:
            _run(settings, listening, tell)
        else:
            tell()  # who is early waits in the socket's line
            _supervise(settings, listening, workers)
    if workers == 1:
        _end()


def to_open(settings: Settings, folder: str) -> str:
    """What the browser is told to open: a page in our folder that leads to the address with its token."""
    # Everybody on this machine can read the command line of the browser in the list of processes.
    if not settings.token:
        return address(settings)
    page = Path(folder, "percuss.html")
    page.touch(0o600)
    page.write_text(f'<!doctype html><meta http-equiv="refresh" content="0; url={address(settings)}">', "utf-8")
    return page.as_uri()


def _work(settings: Settings, listening: socket.socket) -> None:
    """What every worker process does."""
    _run(settings, listening)
    _end()


def _run(settings: Settings, listening: socket.socket, ready: Callable[[], None] | None = None) -> None:
    """Serve in this process."""
    from percuss.web.application import create_app
    from percuss.web.connections import protocol

    sys.setswitchinterval(_TURN)
    config = uvicorn.Config(
        create_app(settings),
        http=protocol(settings.limits),
        host=settings.host,
        port=settings.port,
        ws="none",
        access_log=False,
        log_level="warning",
        server_header=False,
        proxy_headers=False,
        timeout_graceful_shutdown=_GRACE,
    )
    server = _Server(config)
    server.ready = ready
    _end_with_parent(server)
    server.run([listening])


def _supervise(settings: Settings, listening: socket.socket, workers: int) -> None:
    """Keep so many worker processes on one socket until the end is asked for."""
    told: list[int] = []  # not an Event: its lock may be held where the signal arrives
    before = {which: signal.signal(which, lambda sig, _: told.append(sig)) for which in (signal.SIGINT, signal.SIGTERM)}
    spawn = multiprocessing.get_context("spawn")

    def begun() -> BaseProcess:
        process = spawn.Process(target=_work, args=(settings, listening))
        with _without_interrupt():
            process.start()
        return process

    crew: list[BaseProcess] = []
    try:
        while not told:
            crew = [process for process in crew if process.is_alive()]
            crew += [begun() for _ in range(workers - len(crew))]
            began = time.monotonic()
            while not told and not wait([process.sentinel for process in crew], _TICK):
                pass
            while not told and time.monotonic() < began + 1.0:  # who cannot even begin is not begun without end
                time.sleep(_TICK)
    finally:
        for process in crew:
            process.terminate()
        for process in crew:
            process.join(3.0 * _GRACE)
            if process.is_alive():
                process.kill()
        for which, handler in before.items():
            signal.signal(which, handler)


class _Server(uvicorn.Server):
    """uvicorn's server; what is being computed is stopped first when the end is asked for."""

    ready: Callable[[], None] | None = None

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Tell who waits that the page answers."""
        await super().startup(sockets)
        if self.ready is not None and self.started:
            self.ready()

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        """The first signal ends in order, the second at once; neither is an error."""
        # Only flags are set, which the loop looks at ten times a second: the locks of the lanes may be held where the
        # signal arrives, and would be waited for without end.
        if self.should_exit and sig == signal.SIGINT:
            self.force_exit = True
        self.should_exit = True

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Stop what is computed, then the rest."""
        gate = getattr(getattr(getattr(self.config.loaded_app, "app", None), "state", None), "gate", None)
        if gate is not None:
            gate.close()
        await super().shutdown(sockets)


@contextmanager
def _without_interrupt() -> Iterator[None]:
    """A process that is begun here never sees Ctrl-C, which a terminal sends to all: it is told to end by this one."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _end_with_parent(server: _Server) -> None:
    """A worker whose supervisor was killed does not stay behind on the socket."""
    parent = multiprocessing.parent_process()
    if parent is None:
        return

    def watch() -> None:
        parent.join()
        server.should_exit = True

    threading.Thread(target=watch, name="percuss-parent", daemon=True).start()


def _end() -> None:
    """Leave, though a thread may still compute: Python would wait for it."""
    until = time.monotonic() + _TIDY
    while _working("percuss-kernels") and time.monotonic() < until:
        time.sleep(0.02)
    if _working():
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(0)
    gc.freeze()  # else Python looks through all of numba for cycles before it leaves, which takes half a second


def _working(*but: str) -> bool:
    """Whether threads of ours go on: those of the lanes, and the one that loads the kernels."""
    names = {thread.name for thread in threading.enumerate()} - {"percuss-parent", *but}
    return any(name.startswith("percuss-") for name in names)


def _has_screen() -> bool:
    if sys.stdout is None or not sys.stdout.isatty():
        return False
    if sys.platform in ("win32", "darwin"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
