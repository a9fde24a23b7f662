"""From a path to the tables of a TOML file; everything that can be wrong with the file itself."""

from __future__ import annotations

import json
import re
import sys
import tomllib
from collections.abc import Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from pydantic import ValidationError

from percuss.case.file_format.schema import PhysicalCase, missing_tables, table_fields
from percuss.errors import CaseError, ParameterError, did_you_mean

if TYPE_CHECKING:
    from percuss.case.file_format.plain_form import PlainCase

MAX_BYTES = 1_000_000  # the largest case file that is read; a case is a page of text, data belong in a history file


_DATA = 'a case is a page of TOML text; a recording is named in it with kind = "history" and file = "…"'

MAX_KEYS = 1_000  # keys and tables of a case; it has some forty, and each unknown one is a problem to be told

# A key before "=", bare or in quotes, or a table's head; a row of an array, [1.0, 0.0], is neither.
_PART = r"""(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')"""
_KEY = re.compile(rf"(?<![\w-]){_PART}[ \t]*+=|^[ \t]*+\[\[?[^,\[\]\n]*+\]", re.MULTILINE)
_DEEP_KEY = re.compile(rf"(?<![\w-])(?:{_PART}[ \t]*+\.[ \t]*+){{20}}")


def text_of(path: str) -> str:
    """The text of a case file; ``-`` stands for the standard input."""
    try:
        if path == "-":
            data = sys.stdin.buffer.read(MAX_BYTES + 1)
        else:
            with open(path, "rb") as file:
                data = file.read(MAX_BYTES + 1)
    except FileNotFoundError:
        raise CaseError(path, "", None, "no such file") from None
    except IsADirectoryError:
        raise CaseError(path, "", None, "is a directory", _case_in(path)) from None
    except (OSError, ValueError) as error:  # ValueError: a path with a null character
        reason = getattr(error, "strerror", None) or str(error)
        raise CaseError(path, "", None, f"cannot be read: {reason}") from None
    if len(data) > MAX_BYTES:
        raise CaseError(path, "", None, f"larger than {MAX_BYTES // 1_000_000} MB, too large for a case file", _DATA)
    if b"\0" in data:
        raise CaseError(path, "", None, "is a binary file", "a case is TOML text; see 'percuss new' for a sample")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise CaseError(path, "", None, f"is not UTF-8 text (line {line})", "save it as UTF-8") from None


def parsed(text: str, file: str) -> dict[str, Any]:
    """The tables of a TOML text."""
    if _DEEP_KEY.search(text):  # the parser takes the square of the parts of a key in time and in memory
        raise CaseError(file, "", None, "not a case: a key of twenty parts")
    if sum(1 for _ in islice(_KEY.finditer(text), MAX_KEYS + 1)) > MAX_KEYS:
        raise CaseError(file, "", None, f"not a case: more than {MAX_KEYS} keys and tables", _DATA)
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise CaseError(file, "", None, f"not valid TOML: {error}", _syntax_hint(text, str(error))) from None
    except RecursionError:
        raise CaseError(file, "", None, "not valid TOML: brackets nested too deeply") from None
    except ValueError as error:  # tomllib lets a few through, such as a number of 5000 digits
        raise CaseError(file, "", None, f"not valid TOML: {error}") from None


def _case_in(path: str) -> str:
    """A remedy that names the case files lying in a directory."""
    try:
        found = sorted(entry.name for entry in Path(path).glob("*.toml"))[:3]
    except OSError:
        found = []
    return "name a case file in it: " + ", ".join(found) if found else "name a TOML case file"


def _syntax_hint(text: str, message: str) -> str:
    """What to do about the syntax error of `message`, from the line it points at."""
    where = re.search(r"at line (\d+)", message)
    lines = text.splitlines()
    if where is None or int(where[1]) > len(lines):
        return ""
    line = lines[int(where[1]) - 1].strip()
    if re.match(r"^[\w.-]+\s*=\s*[\d.+-]+\s+[A-Za-z]", line):
        return f'text with a unit needs quotes, for example length = "341 mm"; the line reads: {line[:60]}'
    return f"the line reads: {line[:60]}" if line else ""


# ---- Numbers that are known within ±: kept as they are written, and read without it

_UNCERTAIN = re.compile(
    r"\s*([-+−]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([^\s±].*?)??\s*(?:±|\+/?-)\s*(\S.*?)\s*", re.ASCII
)
_LONGEST = 200  # of such a text
_HALF = re.compile(r"((?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*)", re.ASCII)


def without_uncertainty(data: Mapping[str, Any], file: str) -> tuple[dict[str, Any], tuple[tuple[str, str], ...]]:
    """The tables with ``"8.8 cm^2"`` in place of ``"8.8 ± 0.3 cm^2"``, and such texts by their dotted keys."""
    found: dict[str, str] = {}
    nominal = {name: _nominal(value, name, file, found) for name, value in data.items()}
    return nominal, tuple(found.items())


def _nominal(value: Any, key: str, file: str, found: dict[str, str]) -> Any:
    if isinstance(value, Mapping):
        return {name: _nominal(item, f"{key}.{name}", file, found) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [_nominal(item, f"{key}[{i}]", file, found) for i, item in enumerate(value)]
    match = _UNCERTAIN.fullmatch(value) if isinstance(value, str) and "." in key and len(value) <= _LONGEST else None
    if match is None:
        return value
    half = half_width(value)
    if half is None:
        expected = "expected a half width greater than 0 behind ±, in the unit of the number or as a share of it"
        raise CaseError(file, key, value, expected, 'such as "8.8 ± 0.3 cm^2", "160 bar ± 5 %" or "0.15 ± 0.05"')
    found[key] = value
    size, unit = match[1].replace("−", "-"), match[2] or ("" if half[1] == "%" else half[1])
    if unit:
        return f"{size} {unit}"
    return int(size) if re.fullmatch(r"[-+]?\d+", size) else float(size)


def half_width(text: str) -> tuple[float, str] | None:
    """Number and unit behind the ± of a text; a unit of % is a share of the number. None where there is none."""
    match = _UNCERTAIN.fullmatch(text)
    half = None if match is None else _HALF.fullmatch(match[3])
    return (float(half[1]), half[2]) if half is not None and float(half[1]) > 0.0 else None


# ---- Dotted keys of a case, such as ``bar.sections[1].length``: what stands there, and the tables with something else

_STEP = re.compile(r"\[(\d{1,9})\]|\.?([^.\[\]]+)")

Step = str | int


def value_at(tables: Any, key: str) -> Any:
    """What stands under a key; None where there is nothing."""
    for step in _steps(key):
        if isinstance(step, int):
            tables = tables[step] if isinstance(tables, list | tuple) and step < len(tables) else None
        else:
            tables = tables.get(step) if isinstance(tables, Mapping) else None
    return tables


def with_value(tables: Any, key: str, value: Any) -> Any:
    """A copy of the tables with another value under a key; None takes the key away."""
    return _replaced(tables, _steps(key), value)


def _steps(key: str) -> list[Step]:
    return [int(place) if place else name for place, name in _STEP.findall(key)]


def _replaced(held: Any, steps: Sequence[Step], value: Any) -> Any:
    if not steps:
        return value
    step, rest = steps[0], steps[1:]
    if isinstance(step, int):
        if not isinstance(held, list | tuple) or step >= len(held):
            raise LookupError(step)
        return [*held[:step], _replaced(held[step], rest, value), *held[step + 1 :]]
    if not isinstance(held, Mapping):
        raise LookupError(step)
    if value is None and not rest:
        return {name: item for name, item in held.items() if name != step}
    return {**held, step: _replaced(held.get(step, {}), rest, value)}


# ---- Problems of a case file, worded so that they can be fixed: file, key, value, what is accepted, did you mean

_MOST = 100  # problems that are told; a text with thousands is not a case, and each is looked up among the known keys


class CaseErrors(CaseError):
    """Several problems of one case file, one a line.

    Attributes
    ----------
    problems
        The single `CaseError` of each; `file`, `key`, `value` and `accepted` are those of the first.
    """

    def __init__(self, problems: Sequence[CaseError]) -> None:
        first = problems[0]
        super().__init__(first.file, first.key, first.value, first.accepted, first.remedy)
        self.problems = tuple(problems)

    def __str__(self) -> str:
        return "\n".join(str(problem) for problem in self.problems)


def raise_all(problems: Sequence[CaseError]) -> NoReturn:
    raise problems[0] if len(problems) == 1 else CaseErrors(problems)


def from_parameter(error: ParameterError, file: str, table: str, given: Mapping[str, Any]) -> CaseError:
    """The problem of a case file behind an object's refusal; shows the value as the file has it."""
    held = value_at(given, error.name)
    value = error.value if held is None or isinstance(held, list | tuple | dict) else held
    value = list(value) if isinstance(value, tuple) else value  # as a file has it
    return CaseError(file, f"{table}.{error.name}", value, f"expected {error.accepted}", error.remedy)


def from_validation(
    error: ValidationError | None,
    file: str,
    data: Mapping[str, Any],
    fields: Mapping[str, Sequence[str]],
    missing_tables: Sequence[str] = (),
) -> list[CaseError]:
    """The problems that pydantic found in the tables, whose keys are `fields`, and the tables that are missing."""
    found: list[Any] = [] if error is None else error.errors(include_url=False)[:_MOST]
    found += [{"type": "missing", "loc": (name,), "input": data} for name in missing_tables]
    extra = {_key(e["loc"], data): e for e in found if e["type"] == "extra_forbidden"}
    missing = {_key(e["loc"], data) for e in found if e["type"] == "missing"}
    meant: set[str] = set()  # missing keys that a misspelt one stands for are not reported twice
    problems: list[CaseError] = []
    for key, item in extra.items():
        table, _, name = key.rpartition(".")
        known = fields.get(_OF_ITS_KIND.sub("", table), ())
        hint = _MEANT.get(key) or did_you_mean(name, known) or ("" if "." in table else _belongs(name, fields))
        meant.update(m for m in missing if hint and hint == did_you_mean(name, [m.rpartition(".")[2]]))
        hint = hint or _ONLY_IN_SI.get(key, "")
        what = "key" if table else ("table" if isinstance(item["input"], dict) else "key")
        takes = f"[{table}] takes" if table else "a case takes"
        shown = None if isinstance(item["input"], dict) else item["input"]
        problems.append(CaseError(file, key, shown, f"unknown {what}; {takes} {', '.join(known)}", hint))
    for item in found:
        key = _key(item["loc"], data)
        if key not in extra and key not in meant:
            problems.append(_problem(dict(item), key, file))
    return problems


def without_blow(file: str, table: str) -> CaseError:
    """The problem of a case that describes one blow and nothing else, when it is asked for a motion."""
    remedy = f"only 'percuss blow' works without it; add {_how_to_give(table)}"
    return CaseError(file, table, None, "missing", remedy)


_OF_ITS_KIND = re.compile(r"\[\d+\]|(?<=^load\.states)\..*|(?<=^load\.chambers)\..*")
"""What is taken off the name of a table in a list, of a state, or of a chamber of oil: all have the same keys."""


def _key(loc: tuple[int | str, ...], data: Mapping[str, Any]) -> str:
    """``load.coefficients[2]``; steps that are not in the data (pydantic's union tags) are left out."""
    here: Any = data
    text = ""
    for i, step in enumerate(loc):
        last = i == len(loc) - 1
        if isinstance(step, int):
            inside = isinstance(here, list) and step < len(here)
            text += f"[{step}]" if inside or last else ""
            here = here[step] if inside else here
        elif (isinstance(here, dict) and step in here) or (last and isinstance(here, dict)):
            text += f".{step}" if text else step
            here = here.get(step)
    return text


_MEANT = {
    "system.sections": "sections have sizes and stand in [bar]; here give impedances and transit_times",
    "system.damping_ratio": 'here it is damping = {kind = "ratio", value = …}',
    "system.drag": "here it is d, the drag D/(MΩ)",
    "bar.d": "in SI it is the drag, a force per velocity and metre",
    "bar.bore": "a section has a bore: give sections, one or more",
    "bar.material": "a section has a material: give sections, one or more; or youngs_modulus and density",
    "bar.impedances": "in SI give sections, with their sizes",
    "bar.transit_times": "in SI give sections, with their sizes",
}
"""Keys that do not stand here, though one might think so, and what stands for them."""


def _belongs(name: str, fields: Mapping[str, Sequence[str]]) -> str:
    """Which table takes a key that stands in another one; nothing when none does."""
    tables = [table for table, keys in fields.items() if table and name in keys and "." not in table]
    return f"it belongs in {' or '.join(f'[{table}]' for table in tables)}" if tables else ""


_EXPECTED = {
    "float_type": "a plain number without quotes",
    "float_parsing": "a plain number without quotes",
    "int_type": "a whole number without quotes",
    "int_from_float": "a whole number",
    "int_parsing": "a whole number",
    "int_parsing_size": "a smaller whole number",
    "string_type": "text in quotes",
    "bool_type": "true or false",
    "finite_number": "a finite number",
    "model_type": "a table",
    "dict_type": "a table",
    "model_attributes_type": "a table",
}


def _problem(item: dict[str, Any], key: str, file: str) -> CaseError:
    kind, value, context = item["type"], item["input"], item.get("ctx", {})
    cause = context.get("error")
    if isinstance(cause, ParameterError):
        return CaseError(file, key, value, f"expected {cause.accepted}", cause.remedy)
    if kind == "missing":
        return CaseError(file, key, None, "missing", _how_to_give(key))
    if kind == "union_tag_not_found":
        return CaseError(file, f"{key}.kind", None, "missing", f"give kind as one of {_KINDS}")
    if kind == "union_tag_invalid":
        kinds = context["expected_tags"].replace("'", "").split(", ")
        hint = did_you_mean(context["tag"], kinds)
        given = value.get("kind") if isinstance(value, dict) else context["tag"]
        return CaseError(file, f"{key}.kind", given, f"expected one of {', '.join(kinds)}", hint)
    if kind == "greater_than_equal":
        return CaseError(file, key, value, f"expected a whole number, {context['ge']} or greater")
    if kind == "literal_error":
        return CaseError(file, key, value, f"expected {context['expected']}", _near(value, context["expected"]))
    if cause is not None:
        return CaseError(file, key, value, f"expected {cause}")
    return CaseError(file, key, value, f"expected {_EXPECTED.get(kind) or item['msg']}")


def _near(value: object, words: str) -> str:
    """``did you mean …?`` for one of the words of pydantic's ``'rigid' or 'ringing'``."""
    return did_you_mean(value, re.findall(r"'([^']*)'", words))


_ONLY_IN_SI = {
    key: "a dimensionless case knows an endless rod by its impedance, and no rock; describe the bar in SI, with [bar]"
    for key in ("rock", "feed", "drilling", "tool.sections", "tool.end", "tool.bit_mass", "tool.joints")
}
_ONLY_IN_SI["steel"] = "a dimensionless case has no stresses, and so no fatigue; describe the bar in SI, with [bar]"
"""What only a case in SI has, where a dimensionless one is told why."""

_KINDS = "harmonic, square, fourier, history, steps, valve"

_EXAMPLES = {
    "bar": "a table [bar] with length and diameter (or area), or with sections",
    "load": f"a table [load] with its kind: {_KINDS}",
    "contact": "a table [contact] with restitution (0 to 1) or receiving_area",
    "system": "a table [system] with s, d and restitution",
    **{f"{table}.damping.kind": "name the law: ratio, kelvin_voigt, external, table" for table in ("bar", "system")},
    **{f"{table}.damping.value": "give the number of the law, or a list for a table" for table in ("bar", "system")},
    "feed.force": 'give it with its unit, for example force = "8 kN"',
    "drilling.bit_diameter": 'give it with its unit, for example bit_diameter = "64 mm"',
    "rock.stiffness": 'give it with its unit, for example stiffness = "400 kN/mm"',
    "bar.length": 'give it with its unit, for example length = "341 mm"',
    "load.frequency": 'give it with its unit, for example frequency = "60 Hz"',
    "load.file": 'name the file of the recording, for example file = "pressure.csv"',
    "load.unit": 'name the unit of the numbers, for example unit = "kN"',
    "load.coefficients": "give pairs [re, im] from the mean up, for example [[0.9, 0.0], [1.0, 0.0]]",
    "load.mean": "the mean of the load, in SI with its unit",
    "load.amplitude": "the amplitude of the load, in SI with its unit",
    "load.breaks": "give the phases of the jumps in radians, for example [0.0, 2.0]",
    "load.values": "give the load from each phase to the next, for example [1.0, -0.5]",
    "load.states": 'the force of each state, for example states = {return = "-13 kN", power = "12 kN"}',
    "load.ports": 'what demands states, for example [{behind = "130 mm", side = "back", to = "power"}]',
    "load.kappa": "a number between 0 and 2: the load pushes for the phases 0 to kappa times pi",
}


def _how_to_give(key: str) -> str:
    return _EXAMPLES.get(key, "add it")


# ---- The tables of a case file, checked: in SI units or dimensionless, whichever it is meant in


def checked_tables(data: dict[str, Any], file: str) -> PhysicalCase | PlainCase:
    form = _form(data, file)
    missing, found = _missing(form, data), None
    try:
        tables = form.model_validate(data)
        if not missing:
            return tables
    except ValidationError as error:
        found = error
    load = data.get("load")
    kind = load.get("kind") if isinstance(load, dict) else None
    raise_all(from_validation(found, file, data, table_fields(form, kind if isinstance(kind, str) else None), missing))


def case_form(plain: bool) -> type[PhysicalCase] | type[PlainCase]:
    """The SI form, or the dimensionless one, which is made from it when it is first asked for."""
    if not plain:
        return PhysicalCase
    from percuss.case.file_format.plain_form import PlainCase

    return PlainCase


def _missing(form: type[PhysicalCase] | type[PlainCase], data: dict[str, Any]) -> list[str]:
    """The tables that the file lacks: [bar] where nothing else tells of what strikes."""
    near = any(did_you_mean(key, ["bar"]) for key in data if key not in form.model_fields)
    bar = form is PhysicalCase and not {"bar", "body"} & data.keys() and not near
    return [*(["bar"] if bar else []), *missing_tables(form, data)]


def _form(data: dict[str, Any], file: str) -> type[PhysicalCase] | type[PlainCase]:
    """Which of the two forms a file is meant in."""
    physical, plain = {"bar", "contact"} & data.keys(), "system" in data
    if physical and plain:
        names = " and ".join(f"[{name}]" for name in sorted(physical))
        remedy = f"keep [system] for plain numbers, or {names} for SI units"
        raise CaseError(
            file,
            "system",
            None,
            f"a case has either [system] or [bar] and [contact]; this one also has {names}",
            remedy,
        )
    if not physical and not plain:
        plain = any(did_you_mean(key, ["bar", "contact", "system"]) == "did you mean 'system'?" for key in data)
    return case_form(plain)


# ---- The tables of a case as TOML text


def toml_text(tables: Mapping[str, Any]) -> str:
    """TOML text that parses back to the same tables (to the last bit); mappings inside a table take one line."""
    lines = [f"{_toml_key(name)} = {_value(value)}" for name, value in tables.items() if not isinstance(value, Mapping)]
    for name, table in tables.items():
        if isinstance(table, Mapping):
            lines += ["", f"[{_toml_key(name)}]"] if lines else [f"[{_toml_key(name)}]"]
            lines += [f"{_toml_key(key)} = {_value(value)}" for key, value in table.items()]
    return "\n".join(lines) + "\n"


def _toml_key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _text(name)


def _text(value: str) -> str:
    # JSON's escapes are TOML's, but TOML also wants the delete character escaped.
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_value(item) for item in value) + "]"
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_toml_key(key)} = {_value(item)}" for key, item in value.items()) + "}"
    return repr(value)
