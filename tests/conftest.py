"""Hypothesis profiles: `dev` by default, the same examples every time; HYPOTHESIS_PROFILE=thorough for a long
search with new ones."""

import os
import signal
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

settings.register_profile(
    "dev", max_examples=25, deadline=None, derandomize=True, database=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.register_profile("thorough", parent=settings.get_profile("dev"), max_examples=2000, derandomize=False)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "dev"))


def pytest_configure() -> None:
    """Ctrl-C reaches the commands that tests start, also when the suite itself runs in the background of a script."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The longest files, those of the page, first: what comes last is then short, and no core waits for the other."""
    items.sort(key=lambda item: item.get_closest_marker("browser") is None)


@pytest.fixture
def percuss(tmp_path, monkeypatch, capsys):
    """`percuss(*arguments)`: a command in this process, in a folder of its own; cases are written when first named."""
    from cli_cases import CASES, Done
    from percuss.cli import main

    monkeypatch.chdir(tmp_path)

    def command(*arguments: object) -> Done:
        words = [str(word) for word in arguments]
        for name, text in CASES.items():
            if f"{name}.toml" in words and not Path(f"{name}.toml").exists():
                Path(f"{name}.toml").write_text(text, encoding="utf-8")
        try:
            code = main(words)
        except SystemExit as ended:  # --help
            code = int(ended.code or 0)
        return Done(code, *capsys.readouterr())

    return command
