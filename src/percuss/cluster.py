"""The same chunks on an existing dask.distributed cluster, started by ``dask scheduler`` and ``dask worker``.

Workers send their numbers back; they need no common disk, but the same versions of Python, NumPy, Numba and of this
package, so that the numbers are the same to the last bit.
"""

from __future__ import annotations

import asyncio
import logging
import pickle
import queue
import socket
import threading
import time
import uuid
from concurrent.futures import CancelledError
from contextlib import suppress
from functools import lru_cache
from typing import Any

from percuss.errors import PercussError, extra_package
from percuss.explore.jobs.archive_layout import versions
from percuss.explore.jobs.job import Columns, Job
from percuss.explore.jobs.pool import Chunk, packed

_RECOUNT = 5.0  # seconds between two counts of the workers
_LONELY = 60.0  # seconds without any worker after which nothing is expected any more
_CHECK = (
    "check the address, that a firewall lets its port through, that 'dask scheduler' runs there, and that the versions "
    "of Python, dask and percuss are the same on all machines"
)


def pool(address: str, timeout: float = 10.0) -> Cluster:
    """Workers of a cluster.

    Parameters
    ----------
    address
        Of the scheduler, ``tcp://host:port``, as ``dask scheduler`` prints it.
    timeout
        Seconds to wait for the scheduler, and then for a first worker.

    Raises
    ------
    MissingExtraError
        Without the package distributed.
    PercussError
        When the scheduler does not answer, has no workers, or has workers with other versions.
    """
    extra_package("distributed", "cluster")
    whole = address if "://" in address else f"tcp://{address}"
    noise = _Noise()
    try:
        client = _connected(whole, timeout)
    except Exception as error:  # whatever comes of what a stranger answers
        noise.back()
        reason = str(error).partition("\n")[0].rstrip(". ") or type(error).__name__
        raise PercussError(f"no dask scheduler answers at {whole} within {timeout:g} s: {reason}", _CHECK) from None
    try:
        return _with_workers(client, whole, timeout, noise)
    except BaseException:
        client.close(timeout=1)
        noise.back()
        raise


def _connected(address: str, timeout: float) -> Any:
    """A client; in a thread of its own, because it waits without end for a server that is there and says nothing."""
    from distributed import Client

    _reach(address, timeout)
    made: queue.Queue[Any] = queue.Queue()

    def make() -> None:
        client = Client.__new__(Client)
        try:
            connect: Any = Client.__init__
            connect(client, address, timeout=timeout, set_as_default=False, name="percuss")
            made.put(client)
        except Exception as error:
            client.status = "closed"  # or it would try to take leave of nobody, for long
            made.put(error)

    threading.Thread(target=make, daemon=True).start()
    try:
        found = made.get(timeout=timeout + 1.0)
    except queue.Empty:
        raise TimeoutError("something listens there that is not a dask scheduler") from None
    if isinstance(found, Exception):
        raise found
    return found


def _reach(address: str, timeout: float) -> None:
    """A first knock, again and again: a client that finds nobody takes long to be put away."""
    from distributed.comm.addressing import get_address_host_port

    host, port = get_address_host_port(address)
    until = time.monotonic() + timeout
    while True:
        try:
            socket.create_connection((host, port), timeout=timeout).close()
            return
        except ConnectionRefusedError:  # perhaps it is just being started
            if time.monotonic() + 0.2 > until:
                raise
            time.sleep(0.2)


def _with_workers(client: Any, address: str, timeout: float, noise: _Noise) -> Cluster:
    """The pool, when there is somebody in it and all have our versions."""
    try:
        client.wait_for_workers(1, timeout=timeout)
    except TimeoutError:
        remedy = f"start some, on this or other machines: dask worker {address} --nthreads 1"
        raise PercussError(f"the dask scheduler at {address} has no workers", remedy) from None
    for worker, found in client.run(_versions_there, on_error="return").items():
        if isinstance(found, BaseException):
            told = f"the worker {worker} cannot import this package: {found!r}"
            raise PercussError(told, "install percuss in the environment in which 'dask worker' is started")
        _check_versions(worker, found, versions())
    return Cluster(client, address, noise)


class Cluster:
    """Workers of a dask.distributed cluster; a worker that is lost costs its chunk another try, on another worker."""

    def __init__(self, client: Any, address: str, noise: _Noise) -> None:
        self._client = client
        self._noise = noise
        self._address = address
        self._job = b""
        self._name = ""
        self._out: dict[Any, Chunk] = {}
        self._ready: queue.Queue[Any] = queue.Queue()
        self._counted = self._peopled = 0.0
        self._workers = 0
        self._count()

    @property
    def workers(self) -> int:
        """Threads of all workers that are there now."""
        if time.monotonic() - self._counted > _RECOUNT:
            self._count()
        return self._workers

    def begin(self, job: Job) -> None:
        """The chunks that follow are of this job."""
        self._job = packed(job)
        self._name = f"percuss-{uuid.uuid4().hex[:12]}"
        self._out.clear()
        self._ready = queue.Queue()

    def submit(self, chunk: Chunk) -> None:
        """Have a chunk computed, and its numbers sent as soon as they are there, beside those of others."""
        key = f"{self._name}-{chunk.number}"
        arguments = (self._job, versions(), chunk.first, chunk.last)
        future = self._client.submit(_computed, *arguments, key=key, pure=False)
        self._out[future] = chunk

        async def sent() -> list[Columns]:
            numbers: list[Columns] = await self._client.gather([future], asynchronous=True)
            return numbers

        ready = self._ready
        sending = asyncio.run_coroutine_threadsafe(sent(), self._client.loop.asyncio_loop)
        sending.add_done_callback(lambda done: ready.put((future, done)))

    def finished(self, seconds: float) -> list[tuple[Chunk, Columns]]:
        """The chunks that are ready, waiting at most so long for the first."""
        self._check_alive()
        found = []
        with suppress(queue.Empty):
            future, done = self._ready.get(timeout=seconds)
            while True:
                if (chunk := self._out.get(future)) is not None:
                    found.append((chunk, self._numbers(chunk, done)))
                    del self._out[future]
                    future.release()
                future, done = self._ready.get_nowait()
        return found

    def cancel(self) -> None:
        """Forget all chunks; what a worker is at it ends by itself and is dropped."""
        with suppress(Exception):  # the cluster may be what is lost
            self._client.cancel(list(self._out))
        self._out.clear()

    def close(self) -> None:
        """Leave the cluster; its workers stay."""
        self.cancel()
        with suppress(Exception):
            self._client.close(timeout=1)
        self._noise.back()

    def __enter__(self) -> Cluster:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _numbers(self, chunk: Chunk, done: Any) -> Columns:
        from distributed.client import FutureCancelledError
        from distributed.comm.core import CommClosedError
        from distributed.scheduler import KilledWorker

        try:
            columns: Columns = done.result()[0]
            return columns
        except KilledWorker:
            told = f"workers died, one after another, while computing items {chunk.first} to {chunk.last - 1}"
            remedy = "usually they have too little memory: see their logs, give them more or start fewer per machine"
            raise PercussError(told, remedy) from None
        except (FutureCancelledError, CancelledError, CommClosedError) as error:
            raise PercussError(f"the dask scheduler at {self._address} is lost", _CHECK) from error

    def _check_alive(self) -> None:
        if self._client.status not in ("running", "connecting"):
            raise PercussError(f"the dask scheduler at {self._address} is lost", _CHECK)
        if self.workers == 0 and time.monotonic() - self._peopled > _LONELY:
            told = f"the dask scheduler at {self._address} has had no workers for {_LONELY:g} s"
            raise PercussError(told, f"start some: dask worker {self._address} --nthreads 1")

    def _count(self) -> None:
        self._counted = time.monotonic()
        with suppress(OSError, TimeoutError):
            self._workers = sum(self._client.nthreads().values())
        if self._workers:
            self._peopled = self._counted


def _versions_there() -> dict[str, str]:
    return versions()


def _computed(job: bytes, asked: dict[str, str], first: int, last: int) -> Columns:
    """What a worker does; also workers that joined later are asked for their versions."""
    _check_versions("one that joined later", versions(), asked)
    return _job(job).compute(first, last, lambda: False)


@lru_cache(maxsize=2)
def _job(job: bytes) -> Job:
    found: Job = pickle.loads(job)
    return found


def _check_versions(worker: str, there: dict[str, str], here: dict[str, str]) -> None:
    differ = [
        f"{name} {there.get(name)} there, {here[name]} here"
        for name in sorted(here)
        if _exactness(name, there.get(name, "")) != _exactness(name, here[name])
    ]
    if differ:
        told = f"the worker {worker} has other versions: {'; '.join(differ)}"
        raise PercussError(told, "install the same on all machines: the numbers could differ")


def _exactness(name: str, version: str) -> str:
    """3.11.7 and 3.11.9 compute the same."""
    return ".".join(version.split(".")[:2]) if name == "python" else version


class _Noise:
    """What dask logs of lost connections, turned off until `back`: our errors tell of them."""

    def __init__(self) -> None:
        self._logger = logging.getLogger("distributed.client")
        self._before = self._logger.level
        self._logger.setLevel(logging.CRITICAL)

    def back(self) -> None:
        self._logger.setLevel(self._before)
