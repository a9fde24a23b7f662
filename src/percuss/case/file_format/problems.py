"""Problems of a case file, worded so that they can be fixed: file, key, value, what is accepted, did you mean."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any, NoReturn

from pydantic import ValidationError

from percuss.case.file_format.dotted_keys import value_at
from percuss.case.file_format.suggest import did_you_mean
from percuss.errors import CaseError, ParameterError

__all__ = ["CaseErrors", "from_parameter", "from_validation", "raise_all", "without_blow"]


_MOST = 100
"""Problems that are told; a text with thousands is not a case, and each is looked up among the known keys."""


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
    """Raise the one problem, or all of them as one `CaseErrors`."""
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
    """The problems that pydantic found in the tables of a case, and the tables that are missing.

    Parameters
    ----------
    error
        What pydantic says; None when nothing but tables are missing.
    data
        The tables as parsed.
    fields
        The keys that each table takes; '' stands for the top of the file.
    missing_tables
        Tables that this file needs, though another may do without.
    """
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


_OF_ITS_KIND = re.compile(r"\[\d+\]|(?<=^load\.states)\..*")
"""What is taken off the name of a table in a list, or of a state: it has the keys of every other."""


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
    for key in ("rock", "tool.sections", "tool.end", "tool.bit_mass")
}
"""What only a case in SI has, where a dimensionless one is told why."""

_KINDS = "harmonic, square, fourier, history, steps, valve"

_EXAMPLES = {
    "bar": "a table [bar] with length and diameter (or area), or with sections",
    "load": f"a table [load] with its kind: {_KINDS}",
    "contact": "a table [contact] with restitution (0 to 1) or receiving_area",
    "system": "a table [system] with s, d and restitution",
    **{f"{table}.damping.kind": "name the law: ratio, kelvin_voigt, external, table" for table in ("bar", "system")},
    **{f"{table}.damping.value": "give the number of the law, or a list for a table" for table in ("bar", "system")},
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
