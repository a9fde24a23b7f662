"""The map of the house in CONTRIBUTING.md shows every room there is, in the order of the import contracts."""

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "src" / "percuss"
DOORS = {"__main__", "__init__", "_version"}


def mapped() -> list[str]:
    """The rooms of the map, top to bottom: folders with a slash at the end, modules without."""
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    table = text.split("| floor | room |", 1)[1].split("\n\n", 1)[0]
    cells = [line.split("|")[2] for line in table.splitlines()[2:]]
    return [name for cell in cells for name in re.findall(r"`([a-z_/]+)`", cell)]


def floors() -> dict[str, int]:
    """The floor of each room in the import contracts, counted from the roof."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    layers = next(c for c in settings["tool"]["importlinter"]["contracts"] if c["id"] == "floors")["layers"]
    return {name: floor for floor, layer in enumerate(layers) for name in re.findall(r"\w+", layer)}


def test_the_map_shows_every_room_and_no_other():
    folders = {f"{path.parent.relative_to(PACKAGE).as_posix()}/" for path in PACKAGE.rglob("__init__.py")} - {"./"}
    modules = {path.stem for path in PACKAGE.glob("*.py")} - DOORS
    shown = mapped()
    assert len(shown) == len(set(shown))
    assert set(shown) == folders | modules


def test_the_map_has_the_order_of_the_floors():
    floor = floors()
    found = [floor[name.partition("/")[0]] for name in mapped()]
    assert found == sorted(found)
