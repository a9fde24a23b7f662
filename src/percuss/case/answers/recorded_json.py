"""A recorded load read as a valve, in plain values with the names that other programs read."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from percuss.case.answers.json_values import number, numbers

if TYPE_CHECKING:
    from percuss.case.answers.told_record import ToldRecord
    from percuss.steady import Reading, RecordedSwitch

__all__ = ["recorded_dict"]


def recorded_dict(answer: ToldRecord) -> dict[str, Any]:
    """The JSON object: that of the machine of the best reading, and with it what was read.

    In SI positions are in m, times in s, speeds in m/s and forces in N; else they are dimensionless.
    """
    read, clock = answer.read, answer.clock
    scales = _scales(answer)
    multiplier = None if clock.multiplier is None else [number(clock.multiplier.real), number(clock.multiplier.imag)]
    return {
        **answer.answer.to_json_dict(),
        "clock": {"exists": clock.exists, "stable": clock.stable, "multiplier": multiplier},
        "recorded": {
            "phase": number(read.phase),
            "phases": numbers(read.phases),
            "period": number(read.period * scales["time"]),
            "speed": number(read.speed * scales["speed"]),
            "stroke": number(read.stroke * scales["length"]),
            "cycles": int(read.cycles),
            "restitution": None if read.restitution is None else numbers(read.restitution),
            "stiffness": numbers(k * scales["force"] / scales["length"] for k in read.stiffness),
            "opposing_share": number(read.opposing_share),
            "switches": [_switch(switch, scales) for switch in read.switches],
            "least_delays": _reading(read.by_ports),
            "longest_delays": _reading(read.by_delays),
        },
    }


def _switch(switch: RecordedSwitch, scales: dict[str, float]) -> dict[str, Any]:
    found = switch.found
    return {
        "to": switch.to,
        "side": switch.side,
        "by_blow": bool(switch.by_blow),
        "time": numbers(t * scales["time"] for t in switch.time),
        "behind": numbers(x * scales["length"] for x in switch.behind),
        "velocity": numbers(v * scales["speed"] for v in switch.velocity),
        "told_apart": bool(found.told_apart),
        "port": numbers(x * scales["length"] for x in found.port),
        "delay": numbers(t * scales["time"] for t in found.delay),
    }


def _reading(reading: Reading) -> dict[str, Any]:
    """One of the extreme readings: its ports, and whether and how it runs."""
    machine, cycle = reading.machine, reading.cycle
    length, time = (machine.length_scale, machine.time_scale) if machine.is_si else (1.0, 1.0)
    ports = [
        {
            "to": port.to,
            "behind": None if port.behind is None else number(port.behind * length),
            "side": port.side,
            "delay": number(port.delay * time),
            "on": port.on,
        }
        for port in machine.valve.ports
    ]
    return {
        "ports": ports,
        "runs": bool(reading.runs),
        "multiplier": None if cycle is None else number(abs(cycle.multiplier)),
    }


def _scales(answer: ToldRecord) -> dict[str, float]:
    machine = answer.read.machine
    if not machine.is_si:
        return dict.fromkeys(("length", "time", "speed", "force"), 1.0)
    return {name: float(getattr(machine, f"{name}_scale")) for name in ("length", "time", "speed", "force")}
