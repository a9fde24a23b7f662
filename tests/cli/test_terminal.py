"""Nothing that comes from a file steers the terminal: titles, keys, names of files, and what an archive says."""

from __future__ import annotations

import json
import re
import sys
import threading
import time
from functools import partial
from pathlib import Path

import pytest

from case_texts import plain_case
from percuss.case.answers.facts import Grid, Report, ReportSection
from percuss.cli import app, main, waiting
from percuss.cli.report_printing import show as show_report
from percuss.short_repr import escape_control, one_line

EVIL = "a\x1b[2J\x1b]0;x\x07\x9b31m\u202eb\rc\x7f"
STEERS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")

CASE = "title = {title}\n" + plain_case() + "{more}\n"


@pytest.fixture
def run(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def run(*arguments: str) -> tuple[int, str, str]:
        code = main(list(arguments))
        out, err = capsys.readouterr()
        assert not STEERS.search(out) and not STEERS.search(err), (out, err)
        return code, out, err

    return run


@pytest.mark.parametrize("command", [["steady"], ["steady", "--json"], ["simulate", "--modes", "0"]])
def test_titles(run, tmp_path, command):
    title = json.dumps(EVIL + "\npercuss: error: no").replace("\x7f", "\\u007f")
    (tmp_path / "case.toml").write_text(CASE.format(title=title, more=""))
    first, *rest = command
    code, out, _ = run(first, "case.toml", *rest)
    assert code == 0 and "\npercuss: error: no" not in out
    if "--json" in command:
        assert json.loads(out)["title"].startswith(EVIL)


def test_keys_and_names_of_files(run, tmp_path):
    (tmp_path / "case.toml").write_text(CASE.format(title='"x"', more='"\\u001b[2J\\u009b" = 1\n'))
    assert run("steady", "case.toml")[0] == 2
    name = "\x1b[31mx.toml"
    (tmp_path / name).write_text(CASE.format(title='"x"', more=""))
    assert run("steady", name)[0] == 0
    assert run("steady", "\x1b[2Jnone")[0] == 2
    assert run("\x1b[2J")[0] == 2


def test_what_an_archive_says(run, tmp_path):
    from percuss.explore.jobs.archive_layout import checked

    assert run("sweep", "mini-breaker", "--x", "restitution=0:0.9:4", "-o", "a.zarr")[0] == 0
    file = tmp_path / "a.zarr" / "zarr.json"
    about = json.loads(file.read_text())
    about["attributes"]["sessions"][0]["command"] = f"percuss {EVIL}"
    about["attributes"]["created"] = EVIL
    about["attributes"] = checked(about["attributes"])
    file.write_text(json.dumps(about))
    for command in (["show", "a.zarr"], ["show", "a.zarr", "--json"]):
        code, out, _ = run(*command)
        assert code == 0 and "u001b" in out


def test_a_report_at_a_terminal(monkeypatch, capsys):
    """Colours are the program's own, what they colour is neutral."""
    report = Report(EVIL, EVIL, "good", (ReportSection(EVIL, ((EVIL, EVIL),)), Grid(EVIL, (EVIL,), ((EVIL,),))))
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True, raising=False)
    show_report(report)
    out = capsys.readouterr().out
    assert not STEERS.search(re.sub(r"\x1b\[[0-9;]*m", "", out))
    assert "[2J" in out and "\x1b[2J" not in out


def test_neutral():
    assert escape_control("tab\tand\nline") == "tab\tand\nline"
    assert one_line("a\nb") == "a\\u000ab"
    assert json.loads(f'"{escape_control(chr(0x9B))}"') == "\x9b"
    assert escape_control("Ωμ é 𝄞") == "Ωμ é 𝄞"


@pytest.mark.parametrize("seen", [True, False])
def test_no_command_is_silent_for_long(monkeypatch, capsys, seen):
    """Whatever it does: a person is told once; a file of messages is not."""
    monkeypatch.setattr(sys.stderr, "isatty", lambda: seen, raising=False)
    monkeypatch.setattr(waiting, "PATIENCE", 0.05)
    monkeypatch.setattr(waiting, "_SHARE", 0.0)
    monkeypatch.setattr(app, "command_of", lambda name: lambda arguments: time.sleep(0.5) or 0)
    assert main(["steady"]) == 0
    assert capsys.readouterr().err == ("percuss: steady: computing\n" if seen else "")


def test_what_a_command_is_at():
    """By the file whose function it is in, the inner room first; while kernels are compiled, by that alone."""

    def within(file, inner, name="f"):
        scope = {"inner": inner}
        exec(compile(f"def {name}():\n    return inner()", str(Path(waiting._HOUSE, file)), "exec"), scope)
        return scope[name]

    here = partial(waiting.doing, threading.get_ident())
    assert within("cli/app.py", here)() == "computing"
    assert within("steady/phases.py", here)() == "solving for steady motions"
    assert within("steady/periodic/search.py", here)() == "looking for orbits"
    assert within("explore/sweep.py", within("simulate/trajectory.py", here))() == "simulating"
    assert within("simulate/trajectory.py", within("compiled.py", here, "compile_extra"))() == waiting.COMPILING
    assert "def compile_extra(" in Path(waiting._HOUSE, "compiled.py").read_text(encoding="utf-8")
