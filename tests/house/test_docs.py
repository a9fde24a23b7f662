"""The documentation: examples run, links resolve, and no file names a machine or an address of packages."""

import contextlib
import doctest
import importlib
import io
import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest

from percuss.case import Case

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "docs" / "_ext"))
cells = importlib.import_module("cells")  # what the kernels of the built pages use

PAGES = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    ROOT / "CHANGELOG.md",
    *sorted((ROOT / "design").glob("*.md")),
    *sorted((ROOT / "docs").rglob("*.md")),
]

OPTIONS = doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS

FENCE = re.compile(r"^(`{3,})(\S*)[^\n]*\n(.*?)^\1[ \t]*$", re.MULTILINE | re.DOTALL)
CELL = re.compile(r"^(`{3,})\{code-cell\}[^\n]*\n(.*?)^\1[ \t]*$", re.MULTILINE | re.DOTALL)
NOTEBOOKS = [page for page in PAGES if CELL.search(page.read_text(encoding="utf-8"))]
GALLERY = sorted((ROOT / "docs" / "gallery").glob("plot_*.py"))

LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)(?:\s+\"[^\"]*\")?\)|<(?:img|source)\b[^>]*?\b(?:src|srcset)=\"([^\"]+)\"")


def name(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def tracked_files() -> list[Path]:
    """The files that git knows or would add; outside a git checkout, none."""
    done = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard"], capture_output=True, text=True, cwd=ROOT
    )
    return [path for line in done.stdout.splitlines() if (path := ROOT / line).is_file()]


def output_of(block: str, namespace: dict[str, object]) -> str:
    """What a block of Python prints."""
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        exec(compile(block, "<example>", "exec"), namespace)
    return out.getvalue()


def output_of_command(line: str) -> str:
    """What ``percuss …`` prints; ``> FILE`` writes it there instead. Every documented command succeeds."""
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        cells.command(line)
    return out.getvalue()


def check(want: str, got: str, where: str) -> None:
    """Compare as doctest does: white space aside, and ``...`` stands for anything."""
    same = doctest.OutputChecker().check_output(want, got, OPTIONS)
    assert same, f"{where}\nexpected:\n{want}\ngot:\n{got}"


LONG = ("maps.md", "literature.md", "simulation.md", "plot_16_which_starts_run.py")
"""Whose examples take ten seconds or more."""


def examples(paths: list[Path]) -> list[Any]:
    return [pytest.param(path, marks=[pytest.mark.slow] * (path.name in LONG), id=name(path)) for path in paths]


@pytest.mark.parametrize("page", examples([page for page in PAGES if page.name != "CONTRIBUTING.md"]))
def test_examples_run(page, tmp_path, monkeypatch):
    """Blocks in order: python runs, a text block after it is what it prints, percuss commands run."""
    monkeypatch.chdir(tmp_path)
    namespace: dict[str, object] = {"__name__": "example"}
    printed = None
    for _, language, block in FENCE.findall(page.read_text(encoding="utf-8")):
        if language == "text" and printed is not None:
            check(block, printed, name(page))
        printed = output_of(block, namespace) if language == "python" else None
        if language == "console":
            for command, want in re.findall(r"^\$ (.+)\n((?:(?!\$ ).*\n)*)", block, re.MULTILINE):
                if command.startswith("percuss "):
                    got = output_of_command(command)
                    if want.strip():
                        check(want, got, f"{name(page)}: {command}")
        if language == "toml":
            Case.from_text(block, file=name(page))


def cells_of(page: Path) -> list[tuple[set[str], str]]:
    """Tags and code of the cells of a page; the options are the lines ``:key: value`` at the top of a cell."""
    found = []
    for _, block in CELL.findall(page.read_text(encoding="utf-8")):
        options, code = re.fullmatch(r"((?::[\w-]+:[^\n]*\n)*)(.*)", block, re.DOTALL).groups()
        assert not code.startswith("---"), f"{name(page)}: give the options of a cell as lines ':key: value'"
        tags = re.search(r"^:tags: \[(.*)\]$", options, re.MULTILINE)
        found.append(({tag.strip() for tag in tags[1].split(",")} if tags else set(), code))
    return found


@pytest.fixture
def elsewhere(tmp_path, monkeypatch):
    """An empty folder to run in, and pictures that nobody sees."""
    import matplotlib.pyplot as plt

    monkeypatch.chdir(tmp_path)
    plt.switch_backend("agg")
    yield tmp_path
    plt.close("all")


@pytest.mark.parametrize("page", NOTEBOOKS, ids=name)
def test_cells_run(page, elsewhere):
    """The cells of a page in order, in one namespace: as in the kernel of the built documentation."""
    text = page.read_text(encoding="utf-8")
    assert re.match(r"---\n(?:.*\n)*?file_format: mystnb\n(?:.*\n)*?---\n", text), "cells run only with this key"
    namespace: dict[str, object] = {"__name__": "__main__"}
    for tags, code in cells_of(page):
        if "skip-execution" in tags:
            continue
        failing = pytest.raises(Exception) if "raises-exception" in tags else contextlib.nullcontext()
        with failing:
            output_of(cells.python_of(code), namespace)


@pytest.mark.parametrize("script", examples(GALLERY))
def test_gallery_scripts_draw(script, elsewhere):
    import matplotlib.pyplot as plt

    output_of(script.read_text(encoding="utf-8"), {"__name__": "__main__"})
    figures = [plt.figure(number) for number in plt.get_fignums()]
    assert len(figures) == 1, "one figure, one idea"
    for axes in figures[0].axes:
        drawn = axes.has_data() and axes.axison
        assert not drawn or (axes.get_xlabel() + axes.get_ylabel()).strip(), "axes without a name"


def test_what_only_a_notebook_understands_is_refused():
    assert cells.python_of("x = 1\n!percuss --version\n").count("percuss --version") == 1
    for line in ("!ls", "%timeit 1", "%%bash\nls"):
        with pytest.raises(ValueError, match="nothing else"):
            cells.python_of(line)


def test_a_command_that_fails_is_an_error_of_its_page(elsewhere):
    with pytest.raises(cells.CommandError, match=r"exit code 2\n.*no-such-machine"):
        cells.command("percuss steady no-such-machine")
    cells.command("percuss --version > version.txt")
    assert (elsewhere / "version.txt").read_text(encoding="utf-8").startswith("percuss ")


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_links_resolve(page):
    text = FENCE.sub("", page.read_text(encoding="utf-8"))
    targets = [a or b for a, b in LINK.findall(text)]
    missing = []
    for target in targets:
        if re.match(r"[a-z]+:", target) or target.startswith("#"):
            continue
        if not (page.parent / target.partition("#")[0]).exists():
            missing.append(target)
    assert missing == []


def test_every_design_note_is_in_the_documentation():
    page = (ROOT / "docs" / "design.md").read_text(encoding="utf-8")
    notes = [name(path) for path in (ROOT / "design").glob("*.md")]
    assert [note for note in notes if f"../{note}" not in page] == []


def test_no_file_names_a_machine_or_an_address_of_packages():
    # The words are put together here, so that this file does not find itself.
    forbidden = re.compile(
        r"(?<![\w.])/(?:" + "|".join(["home", "root", "work", "Users", "tmp"]) + r")/\w"
        r"|(?:" + "|".join(["index", "extra-index", "find-links"]) + r")-?url\s*="
        r"|" + "simple" + r"/?\s*--hash"
    )
    found = []
    for path in tracked_files():
        try:
            text = path.read_text(encoding="utf-8")
        except UnicodeDecodeError:
            continue
        found += [f"{name(path)}: {match[0]!r}" for match in forbidden.finditer(text)]
    assert found == []


@pytest.mark.parametrize("pins", sorted((ROOT / "requirements").glob("*.txt")), ids=name)
def test_pins_are_names_versions_and_hashes_only(pins):
    """Each name with its version and a hash of every file; no address, no option."""
    pin = re.compile(
        r"[a-z0-9][a-z0-9._-]*==[0-9][0-9a-z.+!]*( ; [\w .'<>=!()]+)?"
        r"( \\\n    --hash=sha256:[0-9a-f]{64})+\n"
    )
    assert pin.sub("", pins.read_text()) == ""


def test_everything_is_installed_with_its_hash():
    """In a recipe of the Makefile a package comes from a file of pins, or from this folder."""
    recipes = re.findall(r"\$\(PIP\) install (.*)", (ROOT / "Makefile").read_text())
    assert len(recipes) == 5
    for recipe in recipes:
        pinned = re.fullmatch(r"--require-hashes -r requirements/(\w+)\.txt", recipe)
        assert recipe == "--no-deps --no-build-isolation -e ." or pinned, recipe


def test_what_checks_the_page_is_installed_with_its_hash():
    """The packages of npm: exact versions, a hash of each and no address."""
    named = json.loads((ROOT / "requirements" / "package.json").read_text())["dependencies"]
    lock = (ROOT / "requirements" / "package-lock.json").read_text()
    locked = {name.partition("/")[2]: one for name, one in json.loads(lock)["packages"].items() if name}
    assert {name: one["version"] for name, one in locked.items()} == named
    assert all(one["integrity"].startswith("sha512-") for one in locked.values())
    assert "://" not in lock


def test_pins_cover_the_dependencies_and_agree():
    def versions(file: str) -> dict[str, str]:
        lines = (ROOT / "requirements" / file).read_text().splitlines()
        return dict(line.partition(" ")[0].split("==") for line in lines if "==" in line)

    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    needed = [*project["dependencies"], *extras["plot"], *extras["io"]]
    run, dev, build = versions("run.txt"), versions("dev.txt"), versions("build.txt")
    assert {re.split(r"[<>=\[]", item)[0].lower() for item in needed} <= run.keys()
    assert run.items() <= dev.items()
    assert {"pip", "setuptools", "hatchling"} <= build.keys()
    assert all(dev[item] == build[item] for item in dev.keys() & build.keys())
