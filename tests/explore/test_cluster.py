"""Chunks on a real dask.distributed cluster of processes here: workers lost, wrong versions, nobody there."""

from __future__ import annotations

import contextlib
import os
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from jobs import Kills, Raises, Sines, same, whole
from percuss.cli.arguments import Parser
from percuss.cli.long_commands import CARRYING, carried
from percuss.errors import Interrupted, MissingExtraError, PercussError
from percuss.explore.jobs.archive import Archive
from percuss.explore.jobs.carrying_out import carry_out

if find_spec("distributed") is None:  # not imported: that takes a second in each process of the suite
    pytest.skip("needs distributed", allow_module_level=True)

from percuss import cluster

HERE = Path(__file__).resolve().parent
PATHS = os.pathsep.join(filter(None, [str(HERE), os.environ.get("PYTHONPATH")]))
"""Where other processes find the jobs, and the package where these tests find it."""


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        return int(server.getsockname()[1])


class Dask:
    """A scheduler and workers, as their commands start them."""

    def __init__(self, folder: Path) -> None:
        self.port, self.folder = free_port(), folder
        self.address = f"tcp://127.0.0.1:{self.port}"
        self.workers: list[subprocess.Popen[bytes]] = []
        self.scheduler = self._started("scheduler", "--host", "127.0.0.1", "--port", str(self.port), "--no-dashboard")

    def worker(self, **environment: str) -> subprocess.Popen[bytes]:
        options = ("--nthreads", "1", "--no-nanny", "--no-dashboard", "--host", "127.0.0.1")
        place = self.folder / f"worker{len(self.workers)}"
        self.workers.append(
            self._started("worker", self.address, *options, "--local-directory", str(place), **environment)
        )
        return self.workers[-1]

    def _started(self, *arguments: str, **environment: str) -> subprocess.Popen[bytes]:
        env = {**os.environ, "PYTHONPATH": PATHS, "OPENBLAS_NUM_THREADS": "1", **environment}
        with open(self.folder / "dask.log", "ab") as log:
            return subprocess.Popen([sys.executable, "-m", "dask", *arguments], env=env, stdout=log, stderr=log)

    def end(self) -> None:
        for process in [*self.workers, self.scheduler]:
            process.kill()
            process.wait()


@pytest.fixture(scope="module")
def dask(tmp_path_factory) -> Iterator[Dask]:
    """Two workers, for tests that leave them as they are."""
    found = Dask(tmp_path_factory.mktemp("dask"))
    try:
        found.worker()
        found.worker()
        yield found
    finally:
        found.end()


@contextlib.contextmanager
def cluster_of(found: Dask, workers: int) -> Iterator[Any]:
    with cluster.pool(found.address, timeout=30) as pool:
        pool._client.wait_for_workers(workers, timeout=30)
        pool._count()
        yield pool


def test_the_same_numbers(dask, tmp_path):
    job = Sines(100, sleep=0.002)
    with cluster_of(dask, 2) as pool:
        assert pool.workers == 2
        for chunk in (7, 50):
            assert same(carry_out(job, pool=pool, chunk=chunk), whole(job))
        assert same(carry_out(job, pool=pool, chunk=9, archive=tmp_path / "a.zarr"), whole(job))
        assert same(carry_out(Sines(40), pool=pool), whole(Sines(40)))
    assert same(Archive.open(tmp_path / "a.zarr").read(), whole(job))


@pytest.mark.slow
def test_a_worker_is_killed_in_the_middle(tmp_path):
    """Its chunks go to the other; identical to the local result."""
    found = Dask(tmp_path)
    try:
        victim, _ = found.worker(), found.worker()
        job, killed = Sines(300, sleep=0.01), []
        local = carry_out(job, workers=1)
        with cluster_of(found, 2) as pool:

            def watch(progress: Any) -> None:
                if progress.done >= 80 and not killed:
                    victim.kill()
                    killed.append(progress.done)

            remote = carry_out(job, pool=pool, chunk=10, archive=tmp_path / "a.zarr", progress=watch)
        assert killed and killed[0] < 200
        assert same(remote, local)
        assert same(Archive.open(tmp_path / "a.zarr").read(), local)
    finally:
        found.end()


@pytest.mark.slow
def test_a_worker_that_joins_later_helps(tmp_path, monkeypatch):
    monkeypatch.setattr(cluster, "_RECOUNT", 0.2)
    found = Dask(tmp_path)
    try:
        found.worker()
        with cluster_of(found, 1) as pool:
            threading.Timer(0.3, found.worker).start()
            assert same(carry_out(Sines(400, sleep=0.02), pool=pool, chunk=5), whole(Sines(400)))
            assert pool.workers == 2
    finally:
        found.end()


@pytest.mark.slow
def test_the_scheduler_is_lost(tmp_path):
    """What was done is kept, and gone on with here."""
    found = Dask(tmp_path)
    job = Sines(400, sleep=0.01)
    try:
        found.worker()
        with cluster_of(found, 1) as pool:

            def watch(progress: Any) -> None:
                if progress.done >= 40:
                    found.scheduler.kill()

            with pytest.raises(PercussError, match=r"the dask scheduler at tcp://127\.0\.0\.1:\d+ is lost — check"):
                carry_out(job, pool=pool, chunk=10, archive=tmp_path / "a.zarr", progress=watch)
    finally:
        found.end()
    with Archive.open(tmp_path / "a.zarr") as archive:
        assert archive.items_done >= 40
    assert same(carry_out(job, archive=tmp_path / "a.zarr", resume=True, workers=1), whole(job))


@pytest.mark.slow
def test_all_workers_are_lost(tmp_path, monkeypatch):
    monkeypatch.setattr(cluster, "_RECOUNT", 0.2)
    monkeypatch.setattr(cluster, "_LONELY", 1.0)
    found = Dask(tmp_path)
    try:
        victim = found.worker()
        with cluster_of(found, 1) as pool, pytest.raises(PercussError, match="has had no workers for 1 s"):
            carry_out(Sines(500, sleep=0.01), pool=pool, chunk=5, progress=lambda p: p.done > 20 and victim.kill())
    finally:
        found.end()


def test_a_watcher_ends_it(dask, tmp_path):
    begin = []

    def watch(progress: Any) -> bool:
        if progress.done > 20 and not begin:
            begin.append(time.monotonic())
        return bool(begin)

    with cluster_of(dask, 2) as pool:
        with pytest.raises(Interrupted) as stop:
            carry_out(Sines(2000, sleep=0.01), pool=pool, chunk=5, archive=tmp_path / "a.zarr", progress=watch)
        assert time.monotonic() - begin[0] < 2.0
        assert "--resume" in str(stop.value)
        assert same(carry_out(Sines(40), pool=pool, chunk=5), whole(Sines(40)))


def test_an_item_that_raises(dask):
    with cluster_of(dask, 2) as pool, pytest.raises(ZeroDivisionError, match="item 50"):
        carry_out(Raises(100), pool=pool, chunk=10)


@pytest.mark.slow
def test_an_item_that_kills_workers(tmp_path):
    """After some tries it is told, and not tried on all workers of the cluster."""
    found = Dask(tmp_path)
    try:
        for _ in range(5):
            found.worker()
        with cluster_of(found, 5) as pool, pytest.raises(PercussError, match="while computing items 0 to 9"):
            carry_out(Kills(10, bad=5), pool=pool, chunk=10)
    finally:
        found.end()


# -- versions --


def test_workers_with_another_version(tmp_path):
    """The package of another version, as a worker finds it first."""
    found = Dask(tmp_path)
    fake = tmp_path / "fake"
    fake.mkdir()
    (fake / "sitecustomize.py").write_text("import percuss._version as v\nv.__version__ = '0.0.1'\n")
    try:
        found.worker(PYTHONPATH=f"{fake}{os.pathsep}{PATHS}")
        with pytest.raises(PercussError, match=r"has other versions: percuss 0\.0\.1 there") as error:
            cluster.pool(found.address, timeout=30)
        assert "install the same" in str(error.value)
    finally:
        found.end()


def test_a_worker_with_another_version_that_joins_later(dask, monkeypatch):
    with cluster_of(dask, 2) as pool:
        monkeypatch.setattr(cluster, "versions", lambda: {"percuss": "99.0"})
        with pytest.raises(PercussError, match="other versions: percuss"):
            carry_out(Sines(100), pool=pool, chunk=10)


def test_versions_that_are_alike():
    here = {"percuss": "1.0", "python": "3.11.7"}
    cluster._check_versions("a", {"percuss": "1.0", "python": "3.11.9"}, here)
    for there in ({"percuss": "1.0", "python": "3.12.7"}, {"percuss": "1.0.1", "python": "3.11.7"}, {}):
        with pytest.raises(PercussError, match="other versions"):
            cluster._check_versions("a", there, here)


# -- nobody there --


def test_nobody_answers():
    begin = time.monotonic()
    with pytest.raises(PercussError, match="no dask scheduler answers") as error:
        cluster.pool(f"127.0.0.1:{free_port()}", timeout=1)
    assert time.monotonic() - begin < 5
    for text in ("address", "firewall", "dask scheduler", "versions"):
        assert text in error.value.remedy


def test_something_that_says_nothing_listens():
    with socket.create_server(("127.0.0.1", 0)) as server:
        begin = time.monotonic()
        with pytest.raises(PercussError, match="not a dask scheduler"):
            cluster.pool(f"tcp://127.0.0.1:{server.getsockname()[1]}", timeout=1)
        assert time.monotonic() - begin < 5


@pytest.mark.parametrize("address", ["nonsense", "carrier-pigeon://roof:1", "tcp://no.such.host.invalid:8786", ""])
def test_no_address(address):
    with pytest.raises(PercussError, match="no dask scheduler answers"):
        cluster.pool(address, timeout=1)


def test_a_scheduler_without_workers(tmp_path):
    found = Dask(tmp_path)
    try:
        cluster._reach(found.address, 30.0)
        with pytest.raises(PercussError, match="has no workers") as error:
            cluster.pool(found.address, timeout=2)
        assert f"dask worker {found.address}" in error.value.remedy
    finally:
        found.end()


def test_no_dask(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(MissingExtraError, match="distributed"):
        cluster.pool("tcp://127.0.0.1:1")


# -- the command line's share --


def test_scheduler_option(dask, tmp_path):
    parser = Parser("sweep", "", "", CARRYING)
    options = parser.parsed(["--scheduler", dask.address, "-o", str(tmp_path / "a.zarr")])
    assert same(carried(parser, options, Sines(50, sleep=0.01)), whole(Sines(50)))
