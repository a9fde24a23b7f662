"""The command in this process, in a folder of its own with the cases of `cli_cases`."""

from pathlib import Path

import pytest

from cli_cases import CASES, Done
from percuss.cli import main


@pytest.fixture
def percuss(tmp_path, monkeypatch, capsys):
    """`percuss(*arguments)`; a case is written when it is first named."""
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
