"""``percuss show`` and ``percuss export``: what is in an archive, how far it is, and all of it in one file."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from percuss.cli.arguments import Parser, check_target, need

if TYPE_CHECKING:
    from percuss.case.answers.facts import Grid, Report, Section
    from percuss.explore.jobs.archive import Archive

_SHOW = """\
What is in an archive that 'percuss sweep' or 'percuss experiment' writes: what was asked for, how complete it is,
which versions wrote it, and how to continue it. You can look at an archive while it is being written."""

_SHOW_EXAMPLES = """\
  percuss show map.zarr
  percuss show map.zarr --json"""

_EXPORT = """\
Write what an archive holds into one file: NetCDF with named coordinates and units, or CSV with a line for each item.
Items that an incomplete archive lacks are NaN, or −1 in columns of whole numbers."""

_EXPORT_EXAMPLES = """\
  percuss export map.zarr -o map.nc
  percuss export experiment.zarr -o starts.csv"""

_KINDS = (".nc", ".csv")


def show(arguments: Sequence[str]) -> int:
    """Tell of one archive; returns the exit code."""
    parser = Parser("show", _SHOW, _SHOW_EXAMPLES)
    parser.add_argument("archive", metavar="ARCHIVE", help="the folder that -o created")
    parser.add_argument("--json", action="store_true", help="print all of it as JSON, the whole question included")
    options = parser.parsed(arguments)

    from percuss.cli.report_printing import answered
    from percuss.explore.jobs.archive import Archive

    with Archive.open(options.archive) as archive:
        answered(options, lambda: _json(archive), lambda: archive_report(archive, options.archive), indent=1)
    return 0


def export(arguments: Sequence[str]) -> int:
    """Write one archive into one file; returns the exit code."""
    parser = Parser("export", _EXPORT, _EXPORT_EXAMPLES)
    parser.add_argument("archive", metavar="ARCHIVE", help="the folder that -o created")
    parser.add_argument("-o", "--output", metavar="FILE", required=True, help=f"the file, {' or '.join(_KINDS)}")
    options = parser.parsed(arguments)
    if not options.output.lower().endswith(_KINDS):
        parser.error(f"argument -o: '{options.output}': the name must end in {' or '.join(_KINDS)}")
    check_target(parser, "-o", options.output)
    need("xarray", "io")

    from percuss.explore.jobs.archive import Archive
    from percuss.explore.jobs.archive_export import dataset_of, write_csv, write_netcdf

    with Archive.open(options.archive) as archive:
        write = write_csv if options.output.lower().endswith(".csv") else write_netcdf
        write(dataset_of(archive), options.output)
        print(f"{archive.kind}: {options.output}")
        if archive.missing():
            print(f"percuss: note: {_how_far(archive)}; the rest is empty", file=sys.stderr)
    return 0


def archive_report(archive: Archive, name: str) -> Report:
    """What `percuss show` prints for people."""
    from percuss.case.answers.facts import BAD, GOOD, PLAIN, Report, Section

    complete = not archive.missing()
    sections: list[Section | Grid] = [Section("what was asked for", tuple(_asked(archive)))]
    if axes := _axes(archive):
        sections.append(axes)
    sections += [_columns(archive), Section("how it was made", tuple(_origin(archive)))]
    if not complete:
        last = archive.sessions[-1]["command"]
        again = last if not last or last.endswith(" --resume") else f"{last} --resume"
        how = (
            again
            if again.startswith("percuss ")
            else f"the same command with --resume (resume=True){': ' if again else ''}{last}"
        )
        waits = "wait: a process is writing it" if archive.is_written else how
        sections.append(Section("to continue", (("command", waits),), BAD))
    summary = "complete" if complete else f"{_how_far(archive)}{', being written' if archive.is_written else ''}"
    return Report(f"{name}: {archive.kind}", summary, GOOD if complete else PLAIN, tuple(sections))


def _how_far(archive: Archive) -> str:
    return f"{_percent(archive.fraction)} done: {archive.items_done} of {archive.size} items"


def _percent(fraction: float) -> str:
    """Never 100 % of what is not complete."""
    return f"{int(1000.0 * fraction) / 10.0:g} %"


def _asked(archive: Archive) -> list[tuple[str, str]]:
    """The ask, its short values as they are and the long ones by their size."""
    return list(_rows("", {name: v for name, v in archive.ask.items() if name not in ("kind", "percuss", "axes")}))


def _rows(prefix: str, values: dict[str, Any]) -> Iterator[tuple[str, str]]:
    for name, value in values.items():
        if isinstance(value, dict):
            yield from _rows(f"{prefix}{name}.", value)
        elif value is not None and value != "":
            yield f"{prefix}{name}", _brief(value)


def _brief(value: Any) -> str:
    if isinstance(value, list) and len(value) > 12:
        return f"{len(value)} values, {_brief(value[0])} … {_brief(value[-1])}"
    if isinstance(value, list):
        return ", ".join(_brief(item) for item in value)
    if isinstance(value, dict):
        return "; ".join(f"{name} {_brief(item)}" for name, item in value.items() if item is not None)
    return f"{value:.12g}" if isinstance(value, float) else str(value)


def _axes(archive: Archive) -> Grid | None:
    from percuss.case.answers.facts import Grid

    axes = archive.ask.get("axes")
    if not isinstance(axes, list) or not all(isinstance(axis, dict) and axis.get("values") for axis in axes):
        return None
    rows = [
        (str(axis.get("name")), str(len(axis["values"])), _brief(axis["values"][0]), _brief(axis["values"][-1]))
        for axis in axes
    ]
    units = [str(axis.get("unit") or "") for axis in axes]
    table = tuple((*row, unit) for row, unit in zip(rows, units, strict=True))
    return Grid("axes", ("name", "values", "from", "to", "unit"), table)


def _columns(archive: Archive) -> Section:
    from percuss.case.answers.facts import Section

    rows = []
    for name, column in archive.columns.items():
        kind = column.dtype + (f" × {' × '.join(map(str, column.shape))}" if column.shape else "")
        unit = f", {column.unit}" if column.unit else ""
        rows.append((name, f"{kind}{unit}{': ' if column.meaning else ''}{column.meaning}"))
    return Section("columns", tuple(rows))


def _origin(archive: Archive) -> list[tuple[str, str]]:
    chunks = len(archive.done)
    rows = [
        ("started", archive.created),
        ("versions", ", ".join(f"{name} {number}" for name, number in archive.versions.items())),
        ("chunks", f"{int(archive.done.sum())} of {chunks} done, {archive.chunk} items each"),
        ("asked, SHA-256", archive.sha256),
    ]
    if archive.sessions[0]["command"]:
        rows.append(("command", archive.sessions[0]["command"]))
    if len(archive.sessions) > 1:
        rows.append(("resumed", f"{len(archive.sessions) - 1} times, last {archive.sessions[-1]['started']}"))
    return rows


def _json(archive: Archive) -> dict[str, Any]:
    from percuss.case.answers.numerals import picked

    return {
        **picked(archive, "kind size fraction chunk created sha256 sessions"),
        "done": archive.items_done,
        "complete": not archive.missing(),
        "being_written": archive.is_written,
        "chunks": len(archive.done),
        "chunks_done": int(archive.done.sum()),
        "columns": {name: picked(column, "dtype shape unit meaning") for name, column in archive.columns.items()},
        "ask": _finite(archive.ask),
    }


def _finite(value: Any) -> Any:
    """JSON has no infinity: as text."""
    if isinstance(value, dict):
        return {name: _finite(item) for name, item in value.items()}
    if isinstance(value, list):
        return [_finite(item) for item in value]
    if isinstance(value, float) and value - value != 0.0:
        return str(value)
    return value
