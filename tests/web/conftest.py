"""One server and one browser for all tests of the page that one process runs, and a desk for each test."""

from __future__ import annotations

import asyncio
import inspect
import time
from collections.abc import Iterator
from contextlib import ExitStack
from typing import TYPE_CHECKING

import httpx
import pytest

if TYPE_CHECKING:
    from playwright.sync_api import Browser, BrowserContext

    from web_desk import Desk


@pytest.hookimpl(tryfirst=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> bool | None:
    """A test that is a coroutine runs in an event loop of its own."""
    if not inspect.iscoroutinefunction(pyfuncitem.obj):
        return None
    names = pyfuncitem._fixtureinfo.argnames
    asyncio.run(pyfuncitem.obj(**{name: pyfuncitem.funcargs[name] for name in names}))
    return True


@pytest.fixture(scope="session")
def server() -> Iterator[str]:
    """A server whose kernels are compiled; on a fresh machine that takes longer than a test waits for anything else."""
    from web_desk import served

    with served() as address:
        end = time.monotonic() + 300.0
        while not httpx.get(f"{address}api/about").json()["ready"]:
            assert time.monotonic() < end, "the kernels are not compiled"
            time.sleep(0.1)
        yield address


class Opened:
    """The browser of a process; it goes before the first test without one, in whose way its loop would stand."""

    def __init__(self) -> None:
        self.stack = ExitStack()
        self.browser: Browser | None = None
        self.contexts: dict[str, BrowserContext] = {}

    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        if item.get_closest_marker("browser") is None:
            self.pytest_sessionfinish()

    def pytest_sessionfinish(self) -> None:
        self.stack.close()
        self.browser, self.contexts = None, {}


@pytest.fixture
def opened(pytestconfig: pytest.Config) -> Opened:
    from playwright.sync_api import sync_playwright

    from browser import FLAGS, chromium

    opened: Opened | None = pytestconfig.pluginmanager.get_plugin("opened browser")
    if opened is None:
        opened = Opened()
        pytestconfig.pluginmanager.register(opened, "opened browser")
    if opened.browser is None:
        path, playwright = chromium(), opened.stack.enter_context(sync_playwright())
        opened.browser = playwright.chromium.launch(executable_path=path, args=FLAGS)
        opened.stack.callback(opened.browser.close)
    return opened


@pytest.fixture
def browser(opened: Opened) -> Browser:
    assert opened.browser is not None
    return opened.browser


@pytest.fixture
def desk(browser: Browser, opened: Opened, server: str, request: pytest.FixtureRequest) -> Iterator[Desk]:
    """A desk of its own for every test, which must have asked nobody else and said nothing on the console.

    Only what the browser has fetched is kept for the next one on a screen like this.
    """
    from web_desk import Desk

    options = getattr(request, "param", {})
    found = Desk(browser, server, opened.contexts.pop(str(options), None), **options)
    yield found
    foreign = [url for url in found.asked if not url.startswith((server, "about:", "data:", "blob:"))]
    expected = getattr(request.node, "expected_words", ())
    complaints = [line for line in found.said if not any(word in line for word in expected)]
    failed = [(response.url, response.text()) for response in found.failed] if complaints else []
    if found.page.url.startswith(server):
        found.page.evaluate("localStorage.clear()")
        opened.contexts[str(options)] = found.context
        found.page.close()
    else:
        found.context.close()
    assert foreign == []
    assert complaints == [], failed
