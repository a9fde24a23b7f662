"""Order and times of the events in a cycle of a machine that switches itself: what Newton's method starts from."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

from percuss.errors import ParameterError
from percuss.model import Valve
from percuss.model.checks import count
from percuss.model.load.valve import Orders
from percuss.steady.self_excited.rigid_cycle import RigidCycle

__all__ = ["Rhythm", "Step", "orders_after", "rhythm_of", "steps_of"]


class Step(NamedTuple):
    """An event of a cycle, in its order.

    Attributes
    ----------
    kind
        "port": a port is entered and demands; "due": the state changes; "blow".
    time
        As it was where the order was found.
    source
        The unknown that its time is: the number of the port's passage or of the blow, in their common order; of a
        "due", that of the event that demanded it, −1 for the blow at time 0.
    later
        What is added to that time: the delay of a "due".
    wrapped
        Whether the demand was made in the cycle before.
    port
        Number of the port.
    state
        Of the valve after the event.
    last
        The state that was demanded last, after the event.
    """

    kind: Literal["port", "due", "blow"]
    time: float
    source: int
    later: float
    wrapped: bool
    port: int
    state: str
    last: str


@dataclass(frozen=True)
class Rhythm:
    """When a machine strikes and passes its ports in a cycle, roughly: from a simulation, or from another cycle.

    Parameters
    ----------
    blow_times
        Of the blows after that at time 0; the last one is the period.
    passages
        Time and number of each port that demands, in order of time; blows that do are not among them.
    state, orders
        Of the valve just after the blow at time 0, before that blow demands anything.

    Examples
    --------
    >>> from percuss.model import Port, Valve
    >>> valve = Valve({"return": -0.4, "power": 1.8}, [Port("power", 1.0, "back"), Port("return", on="impact")])
    >>> events = [(1.5, "port", 0), (1.5, "valve", "power"), (3.0, "impact", 2.1)]
    >>> events += [(3.0, "port", 1), (3.0, "valve", "return")]
    >>> again = [(time + 3.0, kind, detail) for time, kind, detail in events]
    >>> Rhythm.of_events(valve, events + again).passages
    ((1.5, 0),)
    """

    blow_times: tuple[float, ...]
    passages: tuple[tuple[float, int], ...]
    state: str
    orders: Orders

    @property
    def period(self) -> float:
        """Duration of the cycle."""
        return self.blow_times[-1]

    @classmethod
    def of_rigid(cls, cycle: RigidCycle) -> Rhythm:
        """That of a rigid piston."""
        passages = tuple((uncovering.time, uncovering.port) for uncovering in cycle.uncoverings)
        return cls(tuple(cycle.blow_times.tolist()), passages, cycle.rebound.state, cycle.rebound.orders)

    @classmethod
    def of_events(cls, valve: Valve, events: Iterable[tuple[float, str, object]], blows: int = 1) -> Rhythm:
        """That of the last blows of a motion.

        Parameters
        ----------
        valve
            Which the motion switched.
        events
            All from the start on, in order: the time, what happened ("port", "valve" or "impact"; others are passed
            over), and the number of the port or the new state.
        blows
            In a cycle.

        Raises
        ------
        ParameterError
            When there are not more blows than in a cycle.
        """
        return rhythm_of(valve, (valve.orders.last, valve.orders), events, count("blows", blows, most=64))


def rhythm_of(
    valve: Valve, begin: tuple[str, Orders], events: Iterable[tuple[float, str, object]], blows: int
) -> Rhythm:
    """As `Rhythm.of_events`, of a motion that began with any state and orders of the valve."""
    (state, orders), heard = begin, list(events)
    struck: list[tuple[int, float, str, Orders]] = []
    for i, (time, kind, detail) in enumerate(heard):
        if kind == "impact":
            struck.append((i, time, state, orders))
        elif kind == "port":
            assert isinstance(detail, int)
            orders = orders.after(time, valve.ports[detail])
        elif kind == "valve":
            state, orders = str(detail), replace(orders, pending=orders.pending[1:])
    if len(struck) <= blows:
        raise ParameterError("events", f"{len(struck)} blows", f"more than the {blows} of a cycle")
    first, start, state, orders = struck[-1 - blows]
    passages = tuple(
        (time - start, detail)
        for time, kind, detail in heard[first : struck[-1][0]]
        if kind == "port" and isinstance(detail, int) and valve.ports[detail].on == "entering"
    )
    pending = tuple((due - start, to) for due, to in orders.pending)
    times = tuple(time - start for _, time, _, _ in struck[-blows:])
    return Rhythm(times, passages, state, replace(orders, pending=pending))


def steps_of(valve: Valve, rhythm: Rhythm) -> tuple[Step, ...] | None:
    """Every event of a cycle, by the rules of the valve; None when the end of the cycle is not its beginning."""
    steps, now = _followed(valve, rhythm)
    return tuple(now.closed(steps)) if now.closes(rhythm) else None


def orders_after(valve: Valve, rhythm: Rhythm) -> Orders:
    """The orders just after the blow that ends a cycle, with times from that blow on."""
    orders = _followed(valve, rhythm)[1].orders
    return replace(orders, pending=tuple((due - rhythm.period, to) for due, to in orders.pending))


def _followed(valve: Valve, rhythm: Rhythm) -> tuple[list[Step], _Now]:
    """The steps of a cycle, and the valve at its end."""
    told = [(time, -1) for time in rhythm.blow_times] + list(rhythm.passages)
    told.sort(key=lambda event: (event[0], event[1] >= 0))
    steps: list[Step] = []
    now = _Now(valve, rhythm)
    now.strike(0.0, -1)
    for number, (time, port) in enumerate(told):
        steps += now.carried_out(time)
        if port < 0:
            steps.append(Step("blow", time, number, 0.0, False, -1, now.state, now.orders.last))
            if number < len(told) - 1:
                now.strike(time, number)
        else:
            now.demand(time, number, port)
            steps.append(Step("port", time, number, 0.0, False, port, now.state, now.orders.last))
    return steps, now


class _Now:
    """The valve on its way through the cycle, and which event demanded each order that is pending."""

    def __init__(self, valve: Valve, rhythm: Rhythm) -> None:
        self.valve, self.state, self.orders = valve, rhythm.state, rhythm.orders
        self.sources: dict[tuple[float, str], tuple[int, float, bool]] = {
            order: (-2 - i, 0.0, True) for i, order in enumerate(rhythm.orders.pending)
        }

    def strike(self, time: float, number: int) -> None:
        for i, port in enumerate(self.valve.ports):
            if port.on == "impact":
                self.demand(time, number, i)

    def demand(self, time: float, number: int, port: int) -> None:
        before, self.orders = self.orders, self.orders.after(time, self.valve.ports[port])
        if self.orders is not before:
            self.sources[self.orders.pending[-1]] = (number, self.valve.ports[port].delay, False)

    def carried_out(self, until: float) -> list[Step]:
        found = []
        while self.orders.pending and self.orders.pending[0][0] < until:
            order, *left = self.orders.pending
            source, later, wrapped = self.sources[order]
            self.state, self.orders = order[1], replace(self.orders, pending=tuple(left))
            found.append(Step("due", order[0], source, later, wrapped, -1, self.state, self.orders.last))
        return found

    def closes(self, rhythm: Rhythm) -> bool:
        """Whether the valve is in the end as it was at the beginning."""
        same = [to for _, to in self.orders.pending] == [to for _, to in rhythm.orders.pending]
        return same and (self.state, self.orders.last) == (rhythm.state, rhythm.orders.last)

    def closed(self, steps: list[Step]) -> list[Step]:
        """The steps, with the orders of the cycle before traced to the events of this one."""
        ends = [self.sources[order] for order in self.orders.pending]

        def traced(step: Step) -> Step:
            if not step.wrapped:
                return step
            source, later, _ = ends[-2 - step.source]
            return step._replace(source=source, later=later)

        return [traced(step) for step in steps]
