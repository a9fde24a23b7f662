"""The hammers that differ from a case in some of its keys: the systems over which a map of a machine is computed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from percuss.case.case import Case, checked_case, json_tables
from percuss.case.file_format.loads import HistoryLoad
from percuss.case.file_format.reading import value_at
from percuss.case.file_format.start_and_simulation import start_of
from percuss.case.parameters.case_keys import (
    DAMPING,
    FREQUENCY,
    LOAD_AREA,
    LOAD_SCALE,
    check_same_law,
    is_of_machine,
    key_of,
    of_machine,
    unknown_parameter,
    varied_keys,
    with_generic_places,
    with_held,
)
from percuss.errors import ParameterError
from percuss.explore.parameters import PARAMETERS, parameters_of, refuse_twice, vary
from percuss.model import Machine, System
from percuss.model.checks import count, finite, instance, mapping, text
from percuss.model.described import describe_system
from percuss.units import si

if TYPE_CHECKING:
    from percuss.blow import Blow
    from percuss.case.answers.whole_hammer import WholeHammer
    from percuss.model.parameter import Parameter
    from percuss.simulate import Start

_STRUCK = ("bar", "tool", "rock", "blow")  # the tables that say what a blow is, but for its speed


@dataclass(frozen=True)
class CaseFamily:
    """The systems of a case with other values of its keys, in their units, or of dimensionless parameters.

    A parameter is a key of the case, ``bar.length`` or in short ``length``, which takes the unit of the axis; or
    ``load.scale``, a factor on the whole load; or one of the dimensionless parameters of any system
    (`percuss.explore.PARAMETERS`), which are put last. A recording keeps its waveform under another ``frequency``.

    Parameters
    ----------
    units
        Of the keys that are varied, by name; none for plain numbers.

    Examples
    --------
    >>> from percuss.case import CaseFamily, load_case
    >>> family = CaseFamily(load_case("mini-breaker"), {"frequency": "Hz"})
    >>> family.system({"frequency": 30.0}).frequency
    30.0
    """

    case: Case
    units: Mapping[str, str]

    def __post_init__(self) -> None:
        checked_case(self.case)
        units = mapping("units", self.units, "units of parameters by name, such as {'frequency': 'Hz'}")
        object.__setattr__(self, "units", {name: text("units", unit) for name, unit in units.items()})

    def key(self, name: str) -> str:
        """The dotted key that a name stands for; "" for a dimensionless parameter.

        Raises
        ------
        ParameterError
            For a name that the case does not have, with those it has.
        """
        text("parameter", name, "the name of a parameter or a key")
        known = self.keys
        own = {f"bar.{name}", *([f"load.{name}"] if self.is_machine else [])}  # which keep the scales to SI
        if name in self._plain and not self.units.get(name) and own.isdisjoint(known):
            return ""
        if name in known:
            return name
        found = self._short.get(name, [])
        if len(found) == 1:
            return found[0]
        if found:
            raise ParameterError("parameter", name, f"one of {' and '.join(found)}")
        raise unknown_parameter(name, known, list(self._plain))

    @property
    def _plain(self) -> Mapping[str, Parameter[Any]]:
        return parameters_of(self.case.machine()) if self.is_machine else PARAMETERS

    @cached_property
    def keys(self) -> list[str]:
        """Keys of the case that hold one number."""
        return varied_keys(self.case)

    @cached_property
    def _short(self) -> dict[str, list[str]]:
        found: dict[str, list[str]] = {}
        for key in self.keys:
            found.setdefault(key.partition(".")[2], []).append(key)
        return found

    def check(self, names: Mapping[str, str]) -> None:
        """ParameterError for a name or a unit that does not go with the case."""
        keys = {name: self.key(name) for name in mapping("names", names, "parameters and their units")}
        refuse_twice({n: (key_of(key).sets or key) if key else self._plain[n].thing for n, key in keys.items()})
        for name, unit in names.items():
            if self.units.get(name, "") != unit:
                raise ParameterError(name, unit, f"the unit of the family: {self.units.get(name) or 'a plain number'}")
            if not (key := keys[name]):
                self._plain[name].check(self.case.hammer)
            elif key == LOAD_SCALE and unit:
                raise ParameterError(name, unit, "a plain number: a factor on the load")
            elif key_of(key).sets == DAMPING:
                check_same_law(self.case, name, key)

    def system(self, values: Mapping[str, float]) -> System:
        """The system of the case with these values."""
        keys, plain = self._split(values)
        return vary(self._scaled(keys), plain)

    def _split(self, values: Mapping[str, float]) -> tuple[dict[str, tuple[float, str]], dict[str, float]]:
        """The values of the keys with their units, and those of the dimensionless parameters."""
        given = {name: finite(name, v) for name, v in mapping("values", values, "values of parameters by name").items()}
        found = {name: self.key(name) for name in given}
        keys = {key: (given[name], self.units.get(name, "")) for name, key in found.items() if key}
        return keys, {name: given[name] for name, key in found.items() if not key}

    @property
    def is_machine(self) -> bool:
        """Whether the piston of the case switches its load, so that it has machines in place of systems."""
        return self.case.is_machine

    def machine(self, values: Mapping[str, float]) -> Machine:
        """The machine of the case with these values."""
        keys, plain = self._split(values)
        case = self._varied(
            {key: value for key, value in keys.items() if not is_of_machine(key, self.case.tables.load)}
        )
        put = of_machine(case, {key: value for key, value in keys.items() if is_of_machine(key, self.case.tables.load)})
        return vary(case.machine(), put | plain)

    def room(self, machine: Machine) -> float | None:
        """How far behind the wall the piston of one of its machines can go, in bar lengths; None without a limit."""
        instance("machine", machine, Machine)
        room = self.case.room()
        scale = self.case.machine().length_scale / machine.length_scale if machine.is_si else 1.0
        return None if room is None else room * scale

    @property
    def is_si(self) -> bool:
        """Whether the case is in SI."""
        return self.case.is_si

    def varied(self, values: Mapping[str, float]) -> Case:
        """The case with these values of its keys, in the units of the family.

        Raises
        ------
        CaseError
            When there is no such hammer.
        ParameterError
            For anything but a key of the case: a dimensionless parameter is none, nor is a factor on the load, nor are
            the frequency and the area of a recording.
        """
        keys: dict[str, tuple[float, str]] = {}
        recorded = isinstance(self.case.tables.load, HistoryLoad)
        for name, value in mapping("values", values, "values of parameters by name").items():
            key = self.key(name)
            if not key or key == LOAD_SCALE or (recorded and key in (FREQUENCY, LOAD_AREA)):
                known = [key for key in with_generic_places(self.keys) if key != LOAD_SCALE]
                raise ParameterError("parameter", name, f"for a blow, a key of the case: {', '.join(known)}")
            keys[key] = (finite(name, value), self.units.get(name, ""))
        return self._varied(keys)

    def blow(self, values: Mapping[str, float]) -> Blow:
        """One blow of the case with these values of its keys; see `percuss.case.blow_answer`.

        The speed in [blow] is that of the case as it stands: where a value changes the load or the contact, or the bar
        of a machine that switches its own valve, the blow has the speed of the motion that results.
        """
        from percuss.case.answers.blows.blow_answer import blow_answer, own_speed

        case, keys = self.varied(values), {self.key(name) for name in values}
        free = {"tool", "rock", "blow"} if self.is_machine else {"bar", "tool", "rock", "blow"}
        moved = any(key.partition(".")[0] not in free for key in keys)
        return blow_answer(case, own_speed(case) if moved and "blow.velocity" not in keys else None).blow

    def whole(
        self,
        values: Mapping[str, float],
        periods: int = 1,
        modes: int | None = None,
        near: WholeHammer | None = None,
    ) -> WholeHammer:
        """The hammer with these values in its steady motion, with what it strikes.

        Under a clock in the possible motion with the greatest margin of stability. The cycle of a machine with elastic
        modes is looked for `near` that of another one first, which is quicker.
        """
        from percuss.case.answers.blows.transfer import tool_of
        from percuss.case.answers.whole_hammer import WholeHammer, whole_machine, whole_system
        from percuss.steady import Orbit
        from percuss.steady.states import MAX_PERIODS

        keys, _ = self._split(values)
        periods = count("periods", periods, most=MAX_PERIODS)
        kept = None if modes is None else count("modes", modes, least=0)
        tool = tool_of(self._varied({key: keys[key] for key in keys if key.partition(".")[0] in _STRUCK}))
        if self.is_machine:
            machine = self.machine(values)
            found = None if near is None else instance("near", near, WholeHammer).motion
            return whole_machine(machine, tool, self.room(machine), kept, None if isinstance(found, Orbit) else found)
        return whole_system(self.system(values), tool, periods, kept)

    def _scaled(self, keys: dict[str, tuple[float, str]]) -> System:
        """The system with the values of the keys, before the dimensionless parameters."""
        if not keys:
            return self.case.system()
        scale, _ = keys.pop(LOAD_SCALE, (1.0, ""))
        table = self.case.tables.load
        frequency = None
        if isinstance(table, HistoryLoad):  # analysed once, and kept by all
            frequency = keys.pop(FREQUENCY, None)
            if LOAD_AREA in keys and table.area is not None:
                scale *= si(_text(*keys.pop(LOAD_AREA)), "area", "area") / si(table.area, "area", "area")
        case = self._varied(keys)
        if scale == 1.0 and frequency is None:
            return case.system()
        load = case.load()
        if frequency is not None:
            load = replace(load, frequency=si(_text(*frequency), "frequency", "frequency"))
        return case.with_load(load.scaled(scale, frequency=load.frequency))

    def _varied(self, keys: Mapping[str, tuple[float, str]]) -> Case:
        if not keys:
            return self.case
        if isinstance(self.case.tables.load, HistoryLoad):
            self.case.load()  # read once, and kept by all
        values: dict[str, Any] = {
            key: self._held(key, _text(value, unit) if unit else _whole(key, value) if key_of(key).whole else value)
            for key, (value, unit) in keys.items()
        }
        for key in keys:
            for other in key_of(key).instead_of:
                if other != key and other in self.keys:
                    values.setdefault(other, None)
        return self.case.varied(values)

    def _held(self, key: str, value: Any) -> Any:
        """A value as it stands under a key; of a table such as {kind, value} only the number is another."""
        return with_held(value_at(self._tables, key), value)

    @cached_property
    def _tables(self) -> dict[str, Any]:
        return json_tables(self.case)

    def start(self, values: Mapping[str, float], modes: int) -> Start:
        """The start that the case's table [start] describes, in the scales, and on the orbits, of these values."""
        from percuss.simulate.stop import MAX_MODES

        kept = count("modes", modes, least=0, most=MAX_MODES)
        return start_of(
            self.case.tables.start,
            (self.machine if self.case.is_machine else self.system)(values),
            kept,
            self.case.file,
        )

    def describe(self) -> dict[str, Any]:
        """The case, and the load of its recording."""
        tables = {key: table for key, table in self.case.to_dict().items() if key not in ("title", "simulation")}
        about: dict[str, Any] = {"case": tables, "units": dict(self.units)}
        if isinstance(self.case.tables.load, HistoryLoad):
            about["recording"] = describe_system(self.case.system())
        return about


def _whole(key: str, value: float) -> int:
    if value != int(value):
        raise ParameterError(key, value, "whole numbers")
    return int(value)


def _text(value: float, unit: str) -> str:
    return f"{value!r} {unit}"
