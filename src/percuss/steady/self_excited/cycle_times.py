"""What a valve does on its way, and the order and times of the events in a cycle of a machine that switches itself."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple, cast

import numpy as np

from percuss.errors import ParameterError
from percuss.model import Valve
from percuss.model.checks import count, finite, flag, instance, numbers, several, text
from percuss.model.load.valve import MOST_PORTS, Orders, port_at


class Switching:
    """The valve on its way: its state, and the orders that wait; `sources` tells by what each of them was demanded."""

    def __init__(self, valve: Valve, state: str, orders: Orders) -> None:
        self.valve, self.state, self.orders = valve, state, orders
        self.sources: dict[tuple[float, str], Any] = {}

    @property
    def due(self) -> float:
        """When the next order is due; infinite for never."""
        return self.orders.pending[0][0] if self.orders.pending else np.inf

    def demand(self, time: float, port: int, source: Any = None, pressure: float = 1.0) -> bool:
        """A port demands its state at a pressure of the supply; whether that is a new order."""
        before, self.orders = self.orders, self.orders.after(time, port_at(self.valve, port, pressure))
        if self.orders is not before:
            self.sources[self.orders.pending[-1]] = source
        return self.orders is not before

    def blow_demands(self) -> list[int]:
        """The ports by which a blow demands."""
        return [i for i, port in enumerate(self.valve.ports) if port.on == "impact"]

    def carry_out(self) -> tuple[float, str]:
        """The next order changes the state."""
        order, *left = self.orders.pending
        self.state, self.orders = order[1], replace(self.orders, pending=tuple(left))
        return order

    def pending_after(self, time: float) -> Orders:
        """The orders, with their times from a time on."""
        return replace(self.orders, pending=tuple((due - time, to) for due, to in self.orders.pending))


@dataclass(frozen=True)
class CycleTimes:
    """When a machine strikes and passes its ports in a cycle, roughly: from a simulation, or from another cycle.

    Parameters
    ----------
    blow_times
        Of the blows after that at time 0; the last one is the period.
    passages
        Time and number of each port that demands, in order of time; blows that do are not among them.
    state, orders
        Of the valve just after the blow at time 0, before that blow demands anything.
    lying
        Numbers of the blows after which the bar lies on the wall, undeformed, for as long as the valve presses it
        there; the last one is that at time 0.
    sticking
        Whether it does so after all blows at which the valve presses: without restitution.
    pressures
        Where delays follow the pressure of a supply, time and pressure of the events, the last one after a period.

    Examples
    --------
    >>> from percuss.model import Port, Valve
    >>> valve = Valve({"return": -0.4, "power": 1.8}, [Port("power", 1.0, "back"), Port("return", on="impact")])
    >>> events = [(1.5, "port", 0), (1.5, "valve", "power"), (3.0, "impact", 2.1)]
    >>> events += [(3.0, "port", 1), (3.0, "valve", "return")]
    >>> again = [(time + 3.0, kind, detail) for time, kind, detail in events]
    >>> CycleTimes.of_events(valve, events + again).passages
    ((1.5, 0),)
    """

    blow_times: tuple[float, ...]
    passages: tuple[tuple[float, int], ...]
    state: str
    orders: Orders
    lying: tuple[int, ...] = ()
    sticking: bool = False
    pressures: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        times = numbers("blow_times", self.blow_times, "times after 0, in order").reshape(-1)
        if not times.size or times[0] <= 0.0 or np.any(np.diff(times) <= 0.0):
            raise ParameterError("blow_times", self.blow_times, "times after 0, in order")
        object.__setattr__(self, "blow_times", tuple(times.tolist()))
        object.__setattr__(self, "passages", _passages(self.passages))
        text("state", self.state, "the name of a state")
        instance("orders", self.orders, Orders)
        lying = [count("lying", one, least=0) for one in several("lying", self.lying, "numbers of blows")]
        object.__setattr__(self, "lying", tuple(lying))
        flag("sticking", self.sticking)
        told = several("pressures", self.pressures, "time and pressure of the events")
        if any(not isinstance(pair, tuple | list) or len(pair) != 2 for pair in told):
            raise ParameterError("pressures", self.pressures, "time and pressure of the events")
        fed = tuple((finite("pressures", time), finite("pressures", pressure)) for time, pressure in told)
        object.__setattr__(self, "pressures", fed)

    @property
    def period(self) -> float:
        """Duration of the cycle."""
        return self.blow_times[-1]

    @property
    def guarded(self) -> list[tuple[float, int]]:
        """Times of blows and passages in order, with the number of the port, −1 for a blow, which comes first."""
        told = [*((time, -1) for time in self.blow_times), *self.passages]
        return sorted(told, key=lambda one: (one[0], one[1] >= 0))

    @classmethod
    def of_events(cls, valve: Valve, events: Iterable[tuple[float, str, object]], blows: int = 1) -> CycleTimes:
        """That of the last blows of a motion.

        Parameters
        ----------
        events
            All from the start on, in order: the time, what happened ("port", "valve", "impact" or "rest"; others are
            passed over), and the number of the port or the new state.

        Raises
        ------
        ParameterError
            When there are not more blows than in a cycle.
        """
        instance("valve", valve, Valve)
        begin = Switching(valve, valve.orders.last, valve.orders)
        return rhythm_of(begin, events, count("blows", blows, most=64))


def under(rhythm: CycleTimes, pressure: float) -> CycleTimes:
    """The same with delays at a constant pressure of the supply."""
    return replace(rhythm, pressures=((rhythm.period, pressure),))


def rhythm_of(
    now: Switching,
    events: Iterable[tuple[float, str, object]],
    blows: int,
    pressures: Sequence[tuple[float, float]] = (),
) -> CycleTimes:
    """As `CycleTimes.of_events`, of a motion that began with any state and orders of the valve."""
    heard = _events(now.valve, events)
    struck: list[tuple[int, float, str, Orders]] = []
    lying = set[int]()
    for i, (time, kind, detail) in enumerate(heard):
        while now.due < time:  # one that changed nothing may not be told
            now.carry_out()
        if kind == "impact":
            struck.append((i, time, now.state, now.pending_after(time)))
        elif kind == "rest":
            lying.add(len(struck) - 1)
        elif kind == "port":
            now.demand(time, cast("int", detail), pressure=_pressure_at(pressures, time, math.inf))
        elif kind == "valve" and now.state != detail:
            now.state, now.orders = str(detail), replace(now.orders, pending=now.orders.pending[1:])
    if len(struck) <= blows:
        raise ParameterError("events", f"{len(struck)} blows", f"more than the {blows} of a cycle")
    first, start, state, orders = struck[-1 - blows]
    passages = tuple(
        (time - start, detail)
        for time, kind, detail in heard[first : struck[-1][0]]
        if kind == "port" and isinstance(detail, int) and now.valve.ports[detail].on == "entering"
    )
    rests = {number - len(struck) + blows for number in lying if number >= len(struck) - blows}
    rests |= {blows - 1} if len(struck) - 1 - blows in lying else set()
    fed = tuple((time - start, pressure) for time, pressure in pressures if start <= time <= struck[-1][1])
    return CycleTimes(
        tuple(time - start for _, time, _, _ in struck[-blows:]), passages, state, orders, tuple(sorted(rests)),
        pressures=fed,
    )  # fmt: skip


def _pressure_at(pressures: Sequence[tuple[float, float]], time: float, period: float) -> float:
    """That of the event nearest in time, which repeats itself; 1 where none is told."""
    if not pressures:
        return 1.0
    return min(pressures, key=lambda one: abs(math.remainder(one[0] - time, period)))[1]


_EVENT = "a time, what happened, and a port's number or a state"


def _passages(given: object) -> tuple[tuple[float, int], ...]:
    accepted = "the time and the number of each port"
    pairs = several("passages", cast("Iterable[Any]", given), accepted)
    if any(not isinstance(pair, tuple | list) or len(pair) != 2 for pair in pairs):
        raise ParameterError("passages", given, accepted)
    return tuple((finite("passages", time), count("passages", port, least=0, most=MOST_PORTS)) for time, port in pairs)


def _events(valve: Valve, given: Iterable[tuple[float, str, object]]) -> list[tuple[float, str, object]]:
    """The events, checked."""
    found: list[tuple[float, str, object]] = []
    for event in several("events", given, _EVENT):
        if not isinstance(event, tuple | list) or len(event) != 3:
            raise ParameterError("events", event, _EVENT)
        time, kind, detail = event
        if kind == "port":
            detail = count("events", detail, least=0, most=len(valve.ports) - 1)
        elif kind == "valve":
            valve.force(str(detail))
        found.append((finite("events", time), str(kind), detail))
    return found


def valve_after(valve: Valve, rhythm: CycleTimes, blow: int = -1) -> Switching:
    """The valve just after a blow of a cycle, the last one by default; its orders have times from that blow on."""
    time = rhythm.blow_times[blow]
    times = tuple(one for one in rhythm.blow_times if one <= time)
    part = replace(rhythm, blow_times=times, passages=tuple(one for one in rhythm.passages if one[0] <= time))
    now = followed(valve, part)[1]
    now.orders = now.pending_after(time)
    return now


class Step(NamedTuple):
    """A `SequenceEvent` as the valve tells it, but `source` is the number of an order if `wrapped`."""

    kind: Literal["port", "due", "blow"]
    time: float
    port: int
    source: int
    wrapped: bool
    state: str
    last: str


def followed(valve: Valve, rhythm: CycleTimes) -> tuple[list[Step], Switching]:
    """The steps of a cycle, and the valve at its end."""
    # A source: number of the event among ports and blows, the port that demanded, whether before; of orders from
    # before: that of the order.
    steps: list[Step] = []
    now = Switching(valve, rhythm.state, rhythm.orders)
    now.sources = {order: (i, -1, True) for i, order in enumerate(rhythm.orders.pending)}
    told, fed = rhythm.guarded, rhythm.pressures

    for number, (time, port) in enumerate([(0.0, -1), *told], start=-1):
        while number >= 0 and now.due < time:
            due, state = now.carry_out()
            source, by, wrapped = now.sources[due, state]
            steps.append(Step("due", due, by, source, wrapped, state, now.orders.last))
        pressure = _pressure_at(fed, time, fed[-1][0]) if fed else 1.0
        if port >= 0:
            now.demand(time, port, (number, port, False), pressure)
        if number >= 0:
            steps.append(Step("port" if port >= 0 else "blow", time, port, number, False, now.state, now.orders.last))
        if port < 0 and number < len(told) - 1:
            for one in now.blow_demands():
                now.demand(time, one, (number, one, False), pressure)
    return steps, now
