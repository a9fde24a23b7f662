"""Where random starts end, in words: the same for the terminal and for a report."""

from __future__ import annotations

from typing import TYPE_CHECKING

from percuss.case.answers.numerals import counted, number, quantity

if TYPE_CHECKING:
    from percuss.case.answers.ends import End, Ends
    from percuss.model import System

__all__ = ["does", "ends_sentence", "power"]


def ends_sentence(ends: Ends, running: set[str], system: System) -> str:
    """The sentence of a summary; `running` holds the labels of the steady motions that can be sustained."""
    if not ends.followed:
        return ""
    there = sum(end.starts for end in ends.ends if end.label in running)
    others = [end for end in ends.ends if end.label not in running]
    many = "The random start" if ends.followed == 1 else f"All {ends.followed} random starts"
    where = "in this motion" if len(running) == 1 else "in one of these motions"
    if running and not others:
        return f"{many} {'ends' if ends.followed == 1 else 'end'} {where}."
    told = [f"{end.starts} {does(end.label, end.starts, _delivered(end, system))}" for end in others]
    if running:
        there_first = [f"{there or 'none'} {'ends' if there == 1 else 'end'} {where}"]
        return f"Of {_starts(ends.followed)}, {', '.join([*there_first, *told])}."
    found = f"Of {_starts(ends.followed)}, {', '.join(told)}."
    if len(others) == 1:
        found = f"{many} {does(others[0].label, ends.followed)}"
        return f"{found}{_with_power(others[0], system)}."
    return found


def _starts(size: int) -> str:
    return counted(size, "random start")


def _with_power(end: End, system: System) -> str:
    text = power(end, system)
    return f": {text}" if text else ""


def power(end: End, system: System) -> str:
    """Power that the impacts take, and main blows, where there are any."""
    if end.delivered_power is None or end.blow_rate is None or not end.delivered_power > 0.0:
        return ""
    if system.is_si and system.frequency is not None:
        return f"{_delivered(end, system)}, {number(end.blow_rate * system.frequency)} main blows/s"
    return f"{_delivered(end, system)}, {number(end.blow_rate)} main blows per load period"


def _delivered(end: End, system: System) -> str:
    """``10.7 kW taken by the impacts``, where anything is."""
    if not end.delivered_power:
        return ""
    if not system.is_si:
        return f"{number(end.delivered_power)} taken by the impacts"
    return f"{quantity(end.delivered_power * system.power_scale, 'W')} taken by the impacts"


def does(label: str, many: int, more: str = "") -> str:
    """``settle on one blow every load period``; the verb agrees with `many`, and `more` follows the label."""
    s = "s" if many == 1 else ""
    named = f"({label}, {more})" if more else f"({label})"
    name, _, numbers = label.replace("z=", "z/", 1).partition("/")
    if name == "z":
        p, n = (int(x) for x in numbers.split("/"))
        blows = "one blow" if p == 1 else f"{p} blows"
        return f"settle{s} on {blows} {_in_periods(n)} {named}"
    if name in ("chatter", "rest") and numbers:
        how = f"chatter{s} to rest" if name == "chatter" else f"strike{s} and come{s} to rest"
        return f"{how} once {_in_periods(int(numbers))} {named}"
    return {
        "rest": f"come{s} to rest on the wall for good",
        "departed": f"leave{s} the wall for good",
        "aperiodic": f"find{s} no rhythm {named}",
    }.get(label, f"{'has' if many == 1 else 'have'} not settled {named}")


def _in_periods(n: int) -> str:
    return "every load period" if n == 1 else f"in {n} load periods"
