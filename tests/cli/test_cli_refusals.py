"""What every command says to what it cannot answer: one clear line and its usage, no traceback, and nothing written."""

from __future__ import annotations

import importlib.util
import shlex
from pathlib import Path

import pytest

from case_texts import PLAIN
from cli_cases import CASES

BASINS = "basins hydraulic-drifter --modes 2"
STARTS = f"{BASINS} --x time=0:6:4 --y velocity=-6:-1:3"
SWEEP = "sweep case.toml --x restitution=0:1:3"
FOLLOW = "follow other.toml --along mean=0.5:1"
BEST = "blow laboratory-striker --best efficiency --vary"
DESIGN = "design valve-drifter --vary"

REFUSED = """
stedy                                                   | unknown command 'stedy' | did you mean 'steady'?
machin valve-breaker                                    | did you mean 'machine'?
case.toml                                               | unknown command | percuss steady case.toml
--versoin                                               | unknown option '--versoin' | did you mean '--version'?
steady                                                  | CASE | usage: percuss steady
steady case.toml --jsn                                  | unknown option '--jsn' | did you mean '--json'?
steady case.toml other.toml                             | one argument too many: 'other.toml'
steady case.toml --periods 0                            | --periods | between 1 and 1000
steady case.toml --periods 3..1                         | --periods | smaller number first
steady case.toml --periods 1..1000000                   | --periods | between 1 and 1000
steady case.toml --periods one                          | --periods | 2, 1..4 or 1,3
steady case.toml --modes 1.5                            | --modes | whole number
steady case.toml --starts -1                            | '-1' | from 0 to 1000 ('percuss experiment' follows
steady case.toml --starts 1001                          | '1001' | from 0 to 1000
steady case.toml --plot picture.gif                     | picture.gif | .png, .svg or .pdf
steady case.toml --plot nowhere/picture.png             | there is no folder 'nowhere'
steady case.toml --report report.png                    | --report | .html or .pdf
steady .                                                | .: is a directory | case.toml
steady hammer.toml --starts 0 --reach-of colour         | colour
steady hammer.toml --starts 0 --reach-of ,              | --reach-of | one or more names
steady valve-breaker --periods 2                        | not for a hammer whose piston switches its own valve: it has no load period
machines all                                            | one argument too many: 'all'
new                                                     | MACHINE
new mini-breaker -o .                                   | is a directory
new mini-breaker -o nowhere/case.toml                   | there is no folder 'nowhere'
new mini-breaker -o case.toml                           | 'case.toml' exists | --force
machine mini-breaker                                    | load.kind = '
machine valve-breaker -o x.toml                         | the name must end in .csv
simulate                                                | CASE (or --resume FILE) | usage: percuss simulate
simulate case.toml --impacts -1                         | --impacts | whole number, 0 or greater
simulate case.toml --time nan                           | --time | finite
simulate case.toml --time '2 s'                         | argument --time: '2 s' | only a case in SI takes units
simulate mini-breaker --time '2 kg'                     | argument --time: '2 kg' | unit of mass
simulate case.toml --start nowhere                      | --start | key=value pairs, orbit:K or random
simulate case.toml --start time=1,time=2                | --start | time is given twice
simulate case.toml --start orbit:9                      | start.orbit = 9 | from 1 to 2 | percuss steady case.toml
simulate case.toml --seed 1                             | argument --start: seed = 1 | random
simulate case.toml --events 3                           | --events | all, none or last:K
simulate case.toml -o case.toml                         | -o | is the case itself
simulate case.toml -o a.png --plot a.png                | --plot | different names
simulate case.toml --resume run.nc                      | CASE cannot be used with --resume
simulate --resume run.nc --start random                 | --start cannot be used with --resume
simulate --resume none.nc                               | none.nc: no such file
simulate --resume case.toml                             | case.toml: not a NetCDF 4 file
simulate case.toml --modes 8 --contact waves            | --modes cannot be used with --contact waves
simulate case.toml -o x.nc --contact waves              | --output cannot be used with --contact waves
simulate case.toml --cells 200                          | --cells is for --contact waves
simulate case.toml --quiet                              | --quiet is for --contact waves
simulate case.toml --cells 3 --contact waves            | from 16 to 100000
simulate valve-drifter --start orbit:1                  | start.orbit = 1: expected a start by position and velocity
sweep case.toml                                         | --x
sweep case.toml --x friction=0:1:3                      | restitution, load_factor
sweep case.toml --x load_facto=0:1:3                    | did you mean 'load_factor'
SWEEP --quantity stabil                                 | exists, orbits
SWEEP --quantity ,                                      | one or more names
sweep case.toml --x restitution=0.9:0:3                 | swap the two ends
sweep case.toml --x restitution=0:1                     | FROM:TO:NUMBER
SWEEP --y restitution=0:1:3                             | one axis only
sweep case.toml --x restitution=0:0.9:100000 --y s=1:20:100000 --quantity label | --yes
SWEEP --curves                                          | --y
SWEEP --periods 1..3                                    | m an axis
SWEEP --csv x.txt                                       | --csv | 'x.txt' | must end in .csv
SWEEP --resume                                          | -o
SWEEP -o map.nc                                         | percuss export
SWEEP --workers 0                                       | 1 or greater
SWEEP --overlay curves.json                             | --plot
SWEEP --y d=0:1:2 --plot a.png --overlay case.toml      | curve
sweep case.toml --x 's=1 m:2 m:3'                       | s
sweep valve-breaker --x 'pressure=100:200 bar:3' --quantity runs --y 's=1,2' --curves | s
experiment case.toml --distribution walls               | wall
experiment case.toml --distribution case.toml           | case.toml
experiment case.toml --starts 0                         | --starts: '0' | 1 or greater
experiment valve-breaker --distribution wide            | expected wall, field, gentle, or a file
basins case.toml --x time=0:6:5                         | --y
basins case.toml --x time=0:6:5 --y phase=0:6:5         | position, velocity, time
basins case.toml --x time=0:6:5 --y position=0:1:5      | the wall is at 0
basins case.toml --x time=0:6:5 --y velocity=-1:0:5 --at time=1 | not on an axis
basins case.toml --x time=0:6:5 --y velocity=-1:0:5 --at place=1 | position
basins case.toml --x 'time=0:6 ms:4' --y velocity=-6:-1:3 | units need a case in SI
basins valve-breaker --x time=0:6:2 --y velocity=-6:-1:2 | no clock drives the machine
BASINS --x 'time=0:6 furlongs:4' --y velocity=-6:-1:3   | a unit of length
BASINS --x time=0:6:4 --y 'u_1=-1 mm:1 mm:3'            | only position, velocity, time have units
STARTS --at 'position=-3 s'                             | a unit of time
STARTS --at 'u_1=3 mm'                                  | have units
STARTS --at position=far                                | NAME=NUMBER
diagram possible.toml --along mean=0.6                  | mean
diagram possible.toml --along nothing=0:1               | nothing
diagram possible.toml --along mean=0.6:1 --show colour  | colour
diagram possible.toml --along mean=0.6:1 --starts 0 --runs 0 --searched 0 | searched
diagram possible.toml --along 'mean=5 kN:6 kN'          | mean
orbits other.toml --label 65/1                          | impacts = 65: expected a whole number from 1 to 64
orbits other.toml --label 1/0                           | periods = 0
orbits other.toml --label 2                             | impacts and load periods of a cycle
orbits other.toml --label chatter/0                     | impacts and load periods of a cycle
orbits other.toml --label 1/1 --up-to 65/1              | impacts = 65
orbits other.toml --label 2/1 --up-to 1/1               | --up-to
orbits other.toml --label chatter/1 --up-to 2/1         | --up-to
orbits other.toml --label 3/1 --tries 99999999999       | --tries
orbits other.toml --label 3/1 --tries 0 --motions 0     | tries = 0
orbits pulled.toml --label 2/1                          | the load does not push
orbits flat.toml --label 2/1                            | the load is constant
orbits step.toml --label 2/1                            | two or more phases
orbits driven.toml --label 3/1                          | elastic mode n = 1
FOLLOW --orbit 2/1:0                                    | orbit = 0
FOLLOW --orbit 2/1:99                                   | one of the 2 orbits z=2/1
FOLLOW --orbit 2/1:1:2                                  | P/N:NUMBER
FOLLOW --orbit 2/1:phases=0.4                           | 2 phases
FOLLOW --orbit 2/1:phases=nan,1                         | phases in rad
FOLLOW --orbit 2/1:phases=5,6                           | the nearest has 0.329782, 2.07112
FOLLOW --orbit 3/1:phases=5,4,3                         | phases near those of an orbit, in order of time
follow hammer.toml --along mean=0.5:1 --orbit chatter/1:1 | one of the 0 cycles chatter/1
FOLLOW --orbit rest/1:phases=2                          | chatter/N:NUMBER
FOLLOW --orbit chatter/1 --switch 2                     | nothing branches off a cycle
FOLLOW --switch 17                                      | switch = 17
FOLLOW --curve flip                                     | --over
FOLLOW --curve flop --over restitution=0:0.9            | one of
FOLLOW --curve flip --over restitution=                 | 'restitution=': expected NAME=FROM:TO
follow hammer.toml --along mean=0.6:0.63 --curve flip --over d=1:2 | a range that holds 0
follow hammer.toml --along mean=0.61:0.63 --curve flip:9 --over restitution=0:0.9 | flip:9
follow hammer.toml --along mean=0.61:0.63 --curve flip --over d=0:1 | has no flip, but limit
follow chattering.toml --orbit chatter/1 --along load_factor=0.36:0.38 --curve flip --over restitution=0.01:0.5 | there are: onset
follow other.toml --along mean=0.665:0.665              | two different ends
follow other.toml --along mean=1:0.5                    | smaller end first
follow other.toml --along mean=                         | NAME=
follow other.toml --along mean=0.5:1:5                  | 'mean=0.5:1:5': expected NAME=FROM:TO
follow other.toml --along mean=1e400:1e401              | mean = inf
follow other.toml --along nothing=0:1                   | nothing
follow other.toml --along mean=0.5N:1N                  | unit of the case
follow pulled.toml --along mean=-1:1                    | the load does not push
blow blow.toml --velocity 9                             | unit
blow blow.toml --velocity '-9 m/s'                      | greater than 0
blow blow.toml --velocity '9 m/s' --from-motion         | --from-motion
blow blow.toml --until '0 s'                            | greater than 0
blow blow.toml --until '1e9 s'                          | at most
blow blow.toml --gauge '5 m'                            | a place on the rod, from 0 to 2 m
blow blow.toml -o blow.toml                             | -o
blow blow.toml -o x.toml                                | .nc
blow blow.toml --unit MPa                               | only with --measured
blow blow.toml --measured nowhere.csv                   | no such file
blow wall.toml --gauge '0.1 m'                          | a place on a rod: the target is a wall
blow wall.toml --best rock-energy --vary 'bar.sections[1].length=50:150mm' | [rock]
blow wall.toml --best efficiency --vary 'bar.sections[1].length=50:150mm' | [rock]
blow wall.toml --best incident-energy --vary 'bar.sections[1].length=50:150mm' | [tool]
blow wall.toml --best peak-stress --vary 'bar.sections[1].length=50:150mm' -o wall.toml | is the case itself
blow laboratory-striker --best rock-energy              | say what may vary
blow laboratory-striker --best beauty --vary bar.length=1:2mm | rock-energy, efficiency
blow laboratory-striker --vary bar.length=1:2mm         | only with --best
BEST bar.length=1mm                                     | NAME=LOW:HIGH
BEST bar.length=2:1mm                                   | smaller end first
BEST bar.length=1:2kg                                   | length
BEST length=1:2mm --vary bar.length=1:2mm               | each key once
BEST bar.length=1:2mm --below '3 kg'                    | --below
BEST bar.length=1:2mm --gauge 1m                        | not with --best
BEST restitution=0:1                                    | a key of the case
BEST load.scale=1:2                                     | a key of the case
BEST bar.length=1:2                                     | such as bar.length=1:2mm
BEST bar.length=1:2mm --blows 3                         | 20 or greater
DESIGN bar.diameter=45:50mm --most blow_enrgy           | did you mean 'blow_energy'
DESIGN bar.diameter=45:50mm --below colour=3            | rock_power
DESIGN bar.diameter=45:50mm --below steel.stress=250    | unit
DESIGN bar.diameter=45:50mm --want blow_rate=60Hz       | FIGURE=LOW..HIGH
DESIGN bar.diameter=45:50mm --want 'blow_rate=70..60Hz' | the smaller one first
DESIGN bar.diameter=50:45mm                             | smaller end first
DESIGN bar.diameter=45:50                               | such as bar.diameter=45:50mm
DESIGN colour=45:50mm                                   | a key of the case
DESIGN bar.diameter=45:50mm --most power --least stroke | one figure is looked for
DESIGN bar.diameter=45:50mm --hammers 3                 | 20 or greater
design valve-drifter --most power                       | say what may vary
design heavy-drifter --most flow --vary contact.restitution=0.1:0.2 | a figure that this hammer has
identify valve-breaker                                  | --blows
identify valve-breaker --blows none.csv                 | none.csv: there is no such file
paper fig9 -o x                                         | NAME: 'fig9' | fig6, fig7, fig8, elastic, claims and all
paper claim -o x                                        | did you mean 'claims'
paper fig2                                              | -o
paper fig2 -o case.toml                                 | not a directory
"""  # noqa: E501
SHORT = {"SWEEP": SWEEP, "STARTS": STARTS, "BASINS": BASINS, "FOLLOW": FOLLOW, "BEST": BEST, "DESIGN": DESIGN}
TABLE = [tuple(part.strip() for part in line.split(" | ")) for line in REFUSED.strip().splitlines()]


@pytest.mark.parametrize(("line", "parts"), [(line, parts) for line, *parts in TABLE], ids=[row[0] for row in TABLE])
def test_what_cannot_be_answered_is_refused(percuss, line, parts):
    first, _, rest = line.partition(" ")
    Path("case.toml").write_text(PLAIN, encoding="utf-8")
    words = shlex.split(f"{SHORT.get(first, first)} {rest}")
    for name in {word.removesuffix(".toml") for word in words if word.endswith(".toml")} & set(CASES):
        Path(f"{name}.toml").write_text(CASES[name], encoding="utf-8")
    before = {path: path.read_bytes() for path in Path().iterdir()}
    percuss(*words).refused(*parts)
    assert {path: path.read_bytes() for path in Path().iterdir()} == before


MADE = {
    "machine": "-o --plot --report", "simulate": "-o --plot", "steady": "--plot --report", "blow": "-o --csv --plot",
    "follow": "-o --plot", "sweep": "-o --csv --plot", "experiment": "-o --plot", "basins": "-o --plot",
    "diagram": "-o --csv --netcdf --plot", "export": "-o", "paper": "-o",
}  # fmt: skip
NEEDED = {
    "sweep": "--x restitution=0:1:3", "follow": "--along mean=0:1", "diagram": "--along mean=0:1",
    "basins": "--x position=-1:0:3 --y velocity=0:1:3",
}  # fmt: skip


@pytest.mark.parametrize("command", MADE)
def test_standard_output_is_no_file_to_be_made(percuss, command):
    """Alike for all commands: it has the report; nothing is computed before."""
    for letter in MADE[command].split():
        case = [] if command == "paper" else ["mini-breaker"]
        done = percuss(command, *case, *NEEDED.get(command, "").split(), letter, "-")
        done.refused(f"argument {letter}: '-': standard output has the report; give the name of a file")


@pytest.mark.parametrize(
    ("old", "new", "parts"),
    [
        ("restitution", "restitusion", ["case.toml: system.restitusion = 0.6", "did you mean 'restitution'?"]),
        ("0.9, 0.0", "-0.9, 0.0", ["case.toml: the load does not push", "p_0"]),
        (", [1.0, 0.0]", "", ["case.toml: the load is constant"]),
        ("s = 20.0\nd = 0.0048", "s = 0.15915494309189535\nd = 0.0", ["case.toml: load harmonic k = 1", "n = 2"]),
        ("s = 20.0", "s = 1e300", ["case.toml: system.s"]),
    ],
)
def test_wrong_cases(percuss, old, new, parts):
    assert old in PLAIN
    Path("case.toml").write_text(PLAIN.replace(old, new, 1), encoding="utf-8")
    percuss("steady", "case.toml", "--plot", "picture.png", "--json").refused(*parts)
    assert not Path("picture.png").exists()


@pytest.mark.parametrize("package", ["xarray", "h5netcdf"])
def test_a_missing_extra_is_said_before_anything_is_computed(percuss, monkeypatch, package):
    found = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name, *a: None if name == package else found(name, *a))
    monkeypatch.setattr("percuss.cli.motions._followed", lambda *_: pytest.fail("computed"))
    percuss("simulate", "case.toml", "-o", "run.nc").refused(f"'{package}'", "percuss[io]")


def test_only_a_report_as_pdf_needs_typst(percuss, monkeypatch):
    found = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name, *a: None if name == "typst" else found(name, *a))
    percuss("report", "laboratory-striker", "-o", "page.pdf").refused("'typst'", "percuss[report]")
    percuss("report", "laboratory-striker", "-o", "page.html", "--no-reach").told("report: page.html")
