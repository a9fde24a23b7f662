"""Commands that need no case: the catalogue, a case to start from, the keys of a case, and the paper's figures."""

from __future__ import annotations

import os
import re
import sys
import textwrap
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from percuss.cli.arguments import Parser, command, made, need, option, whole
from percuss.errors import Interrupted, PercussError

if TYPE_CHECKING:
    import argparse

    from percuss.paper.claim_common import ClaimsProgress


@command(
    """\
The catalogue of sample cases: hammers, with sizes and figures of public data sheets and synthetic force histories, and
structures that strike a stop.""",
    """\
  percuss machines
  percuss steady mini-breaker
  percuss machine valve-breaker
  percuss new mini-breaker -o breaker.toml""",
    option("--json", "print the list as JSON (kg, Hz, J)"),
)
def machines(_: Parser, options: argparse.Namespace) -> int:
    from percuss.case.answers.facts import quantity
    from percuss.case.catalogue.sample_cases import MACHINES, STRUCTURES

    if options.json:
        import json

        none = dict.fromkeys(("mass", "blow_rate", "blow_energy"))
        rows = [asdict(machine) | {"structure": False} for machine in MACHINES]
        rows += [asdict(one) | none | {"valve": False, "structure": True} for one in STRUCTURES]
        print(json.dumps(rows, indent=1))
        return 0
    print(f"{'machine':<20}{'mass':>9}{'blow rate':>11}{'blow energy':>13}   what it is")
    for m in MACHINES:
        figures = f"{f'{m.mass:g} kg':>9}{f'{m.blow_rate:g} Hz':>11}{quantity(m.blow_energy, 'J', 3):>13}"
        started = f"; a simulation from rest ends in {m.from_rest}" if m.from_rest else ""
        print(f"{m.name:<20}{figures}   {m.title}{started}")
    for structure in STRUCTURES:
        print(f"{structure.name:<53}   {structure.title}")
    print("\nRun one with 'percuss steady MACHINE', start from one with 'percuss new MACHINE -o FILE'.")
    valves = ", ".join(f"'percuss machine {m.name}'" for m in MACHINES if m.valve)
    print(f"Those that switch their own valve have a command of their own: {valves}.")
    return 0


# ---- A sample case to start from


@command(
    """\
Print the commented case of a machine or a structure of the catalogue, or write it to a file, together with the
history or the table of modes that the case names, if any.""",
    """\
  percuss new hydraulic-drifter -o drifter.toml
  percuss new pile-hammer
  percuss new stopped-beam -o beam.toml""",
    option("MACHINE", "a name that 'percuss machines' lists"),
    option("-o, --output FILE", "write the case to FILE, and what it names beside it ('-': print it, as without -o)"),
    option("--force", "overwrite existing files"),
)
def new(parser: Parser, options: argparse.Namespace) -> int:
    from percuss.case.catalogue.sample_cases import MACHINES, file_beside, machine_text

    name = options.machine
    text, beside = machine_text(name), file_beside(name)
    if options.output in (None, "-"):
        print(text, end="")
        if beside is not None:
            note = f"note: the case names {beside}; 'percuss new {name} -o FILE' writes it as well"
            print(note, file=sys.stderr)
        return 0
    case = Path(options.output)
    files = [case] if beside is None else [case, case.with_name(beside)]
    _check(parser, files, options.force)
    _write(files, text, name)
    answers = "machine" if any(machine.valve for machine in MACHINES if machine.name == name) else "steady"
    print(f"wrote {' and '.join(str(file) for file in files)}; next: percuss {answers} {case}")
    return 0


def _check(parser: Parser, files: list[Path], force: bool) -> None:
    """Refuse before anything is written."""
    folder = files[0].parent
    if not folder.is_dir():
        parser.error(f"argument -o: '{files[0]}': there is no folder '{folder}'")
    if len(files) == 2 and files[0].name == files[1].name:
        parser.error(f"argument -o: '{files[0]}' is a file that the case names; give the case another name")
    for file in files:
        if file.is_dir():
            parser.error(f"argument -o: '{file}' is a directory; name a file")
        if os.path.lexists(file) and not force:  # also a link to nothing: what it names is not ours to make
            parser.error(f"'{file}' exists; give another name, or use --force to overwrite it")


def _write(files: list[Path], text: str, name: str) -> None:
    """Write what the case names first, so that it never stands without it; leave nothing behind on failure."""
    from percuss.atomic_write import write_whole
    from percuss.case.catalogue.sample_cases import write_beside

    fresh = [file for file in files if not os.path.lexists(file)]
    try:
        if len(files) == 2:
            write_beside(name, files[1])
        write_whole(files[0], text)
    except PercussError:
        for file in fresh:
            with suppress(OSError):
                file.unlink()
        raise


# ---- The keys of a case

_WIDTH = 100


@command(
    "The tables of a case file, or the keys of one: their values, what holds when they are left out, what they mean.",
    """\
  percuss keys
  percuss keys tool
  percuss keys load.valve""",
    option("TABLE", "its name, as 'percuss keys' lists it", nargs="?"),
)
def keys(_: Parser, options: argparse.Namespace) -> int:
    from percuss.case.file_format.key_tables import TABLES, rows_of, table_class

    if options.table is None:
        for name in TABLES:
            about = (table_class(name).__doc__ or "").partition("\n")[0]
            print(f"{name:<25}{about}")
        return 0
    told = []
    for row in rows_of(table_class(options.table)):
        value, without, meaning = (re.sub(r"[`*$]", "", text) for text in row[1:])
        needed = "needed" if without == "needed" else f"when left out: {without}" if without else ""
        head, *body = [f"{row.key} = {value}", *filter(None, [needed]), f"{meaning}."]
        lines = [textwrap.fill(head, _WIDTH, subsequent_indent="    ")]
        lines += [textwrap.fill(line, _WIDTH, initial_indent="    ", subsequent_indent="    ") for line in body]
        told.append("\n".join(lines))
    print("\n\n".join(told))
    return 0


# ---- B77's figures and claims, reproduced

NAMES = ("fig2", "fig3", "fig4", "fig5", "fig6", "fig7", "fig8", "elastic", "claims")
_LOST = "the claim in progress is lost; finished ones are kept, and the same command continues with the next"


@command(
    """\
The figures of B77 (U. Bjoerkenstam, Impact vibration of a bar, 1977) as CSV, SVG and PNG, made from the theory; the
package's own figures of what an elastic bar adds; and the claims of its section 5, tested and judged.

  fig2, fig3   the loads                            fig6   the same, ten load periods to an impact
  fig4         impact phase, pneumatic hammer       fig7   impact phase, hydraulic hammer
  fig5         range of stable motions over R       fig8   range in which motions exist over R
  elastic      how s changes all this                 claims the claims: claims.json and REPORT.md""",
    """\
  percuss paper -o figures
  percuss paper fig4 fig5 -o figures
  percuss paper claims --full --seed 7 -o audit""",
    option("NAME", f"{', '.join(NAMES)} or all (default all)", nargs="*")._replace(names=("names",)),
    made("-o, --output DIR", "directory of the files, created if needed", required=True),
    option("--full", "10^6 starts for each claim; an hour or two, not minutes"),
    option("--seed N", "seed of all random numbers", whole()),
)
def paper(parser: Parser, options: argparse.Namespace) -> int:
    for name in options.names:
        if name not in (*NAMES, "all"):
            from percuss.errors import did_you_mean

            hint = did_you_mean(name, [*NAMES, "all"])
            there_are = f"the names are {', '.join(NAMES)} and all"
            parser.error(f"argument NAME: '{name}': {there_are}{f' — {hint}' if hint else ''}")
    wanted = NAMES if not options.names or "all" in options.names else [name for name in NAMES if name in options.names]
    folder = Path(options.output)
    if folder.exists() and not folder.is_dir():
        parser.error(f"argument -o: '{folder}' is not a directory")
    figures = [name for name in wanted if name != "claims"]
    seed = {} if options.seed is None else {"seed": options.seed}
    if figures:
        need("plot", "matplotlib")
        from percuss.paper import write_figures

        for path in write_figures(figures, folder, **seed):
            print(path, flush=True)
    if "claims" in wanted:
        from percuss.cli.long_commands import JobWatch
        from percuss.paper import claims

        watch, part, done, steps = JobWatch(parser.command), "", 0, 0

        def told(progress: ClaimsProgress) -> bool:
            nonlocal watch, part, done, steps
            if progress.part != part:
                watch.close()
                print(f"trying {progress.part}", file=sys.stderr, flush=True)
                watch = JobWatch(parser.command)
            part, done, steps = progress.part, progress.done, progress.steps
            return watch.share(done / max(steps, 1), f"{part}: step {done} of {steps}")

        try:
            claims.run(folder, full=options.full, progress=told, **seed)
        except (Interrupted, KeyboardInterrupt) as stop:
            raise Interrupted(done, steps, stop.archive if isinstance(stop, Interrupted) else None, _LOST) from None
        finally:
            watch.close()
        for name in ("claims.json", "REPORT.md"):
            print(folder / name)
    return 0
