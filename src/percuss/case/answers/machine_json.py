"""The answer for a machine that switches itself in plain values, with the names that other programs read."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from percuss.case.answers.json_values import number, numbers, plain
from percuss.case.answers.machine_figures import machine_figures

if TYPE_CHECKING:
    from percuss.case.answers.told_machine import ToldMachine
    from percuss.model import Machine
    from percuss.steady.self_excited import Ringing, SelfExcited, ValveCycle

__all__ = ["SHOWN_MULTIPLIERS", "cycle_dict", "machine_dict", "machine_numbers"]

SHOWN_MULTIPLIERS = 16
"""The greatest multipliers, which are told."""


def machine_dict(answer: ToldMachine) -> dict[str, Any]:
    """The JSON object of an answer: a tree of dict, list, str, bool, int, finite float and None."""
    motion, machine = answer.motion, answer.machine
    return {
        **cycle_dict(answer),
        "starts_from_rest": bool(motion.starts_from_rest),
        "margins": _margins(answer),
        "supply": _supply(answer),
        "sensitivities": [
            {
                "parameter": one.parameter,
                "energy": number(one.energy),
                "rate": number(one.rate),
                "stops": list(one.stops),
            }
            for one in answer.sensitivities
        ],
        "pressure_curve": [plain(asdict(one)) for one in answer.curve],
        "blank_blow": None if answer.blank is None else answer.blank.to_json_dict(),
        "rigid": None if answer.rigid is motion else _cycle(answer.rigid),
        "rigid_si": None if answer.rigid is motion else _si(machine, answer.rigid.cycle),
        "warnings": list(answer.warnings),
    }


def cycle_dict(answer: ToldMachine) -> dict[str, Any]:
    """What of it tells of the cycle itself."""
    motion, machine = answer.motion, answer.machine
    return {
        "case": answer.name,
        "title": answer.title,
        "machine": machine_numbers(machine),
        "modes": motion.modes,
        "outcome": answer.outcome,
        "label": answer.label,
        **_cycle(motion),
        "failed_condition": _condition(motion),
        "stable": None if motion.cycle is None else bool(motion.cycle.stable),
        "si": _si(machine, motion.cycle),
        "notes": list(answer.notes),
    }


def machine_numbers(machine: Machine) -> dict[str, Any]:
    """The numbers of a machine: its body, its valve and its gas, dimensionless."""
    valve = machine.valve
    ports = [
        {
            "to": port.to,
            "behind": number(port.behind),
            "side": port.side,
            "delay": number(port.delay),
            "reads": port.reads if port.reads == "centre" else number(port.reads),
            "on": port.on,
        }
        for port in valve.ports
    ]
    return {
        "s": number(machine.body.s),
        "d": number(machine.drag),
        "restitution": number(machine.contact.restitution),
        "states": {name: number(force) for name, force in valve.pairs},
        "chamber": {"force": number(valve.chamber.force), "stiffness": number(valve.chamber.stiffness)},
        "supply": None if valve.supply is None else plain(asdict(valve.supply)),
        "ports": ports,
        "start_state": valve.start,
    }


def _cycle(motion: SelfExcited) -> dict[str, Any]:
    cycle = motion.cycle
    if cycle is None:
        return dict.fromkeys(("period", "stroke", "duty", "work_per_cycle"), None) | {
            name: [] for name in ("blows", "ports", "valve", "multipliers")
        }
    blows = zip(numbers(cycle.blow_times), numbers(cycle.blow_speeds), numbers(cycle.blow_energies), strict=True)
    return {
        "period": number(cycle.period),
        "blows": [{"time": time, "speed": speed, "energy": energy} for time, speed, energy in blows],
        "ports": [
            {"port": one.port, "time": number(one.time), "speed": number(-one.velocity)} for one in cycle.uncoverings
        ],
        "valve": [
            {
                "time": number(one.time),
                "to": one.to,
                "behind": number(one.behind),
                "speed": number(-one.velocity),
                "work": number(one.work),
            }
            for one in cycle.switches
        ],
        "stroke": number(cycle.stroke),
        "duty": number(cycle.duty),
        "work_per_cycle": number(cycle.work),
        "multipliers": [[number(z.real), number(z.imag)] for z in cycle.multipliers[:SHOWN_MULTIPLIERS].tolist()],
    }


def _condition(motion: SelfExcited) -> dict[str, Any] | None:
    obstacle = motion.obstacle
    if obstacle is None:
        return None
    return {
        "condition": obstacle.value,
        "words": obstacle.words,
        "remedy": obstacle.remedy,
        "found": number(motion.found),
        "needed": number(motion.needed),
    }


def _margins(answer: ToldMachine) -> dict[str, Any] | None:
    margins, cycle = answer.margins, answer.cycle
    if margins is None or cycle is None:
        return None
    rigid, own, ringing = answer.rigid.cycle, cycle.rhythm_multiplier, cycle.ringing
    rhythm = rigid.multiplier if own is None and rigid is not None else own
    return {
        "margin": number(1.0 - abs(cycle.multiplier)),
        "margin_rhythm": None if rhythm is None else number(1.0 - abs(rhythm)),
        "rhythm_of": "rigid" if own is None else "machine",
        "margin_ringing": None if ringing is None else number(1.0 - abs(ringing.multiplier)),
        "ringing": None if ringing is None else _ringing(ringing),
        "return_time": number(margins.return_time),
        "latest_return": number(margins.latest_return),
        "beyond": None if margins.beyond is None else margins.beyond.value,
        "chamber_to_run": number(margins.chamber_to_run),
        "chamber_to_start": number(margins.chamber_to_start),
        "flow_to_run": number(margins.flow_to_run),
        "accumulator_to_run": number(margins.accumulator_to_run),
    }


def _supply(answer: ToldMachine) -> dict[str, Any] | None:
    """The pressure over the cycle; in Pa where that of the states is known."""
    found, unit = answer.pressure, answer.machine.pressure or 1.0
    if found is None:
        return None
    z = found.multiplier
    return {
        **{name: number(getattr(found, name) * unit) for name in ("at_blow", "mean", "least", "greatest")},
        "ripple": number(found.ripple),
        "multiplier": [number(z.real), number(z.imag)],
        "slow_multiplier": number(found.slow_multiplier),
        "memory": number(found.memory),
    }


def _ringing(ringing: Ringing) -> dict[str, Any]:
    return {
        "multiplier": [number(ringing.multiplier.real), number(ringing.multiplier.imag)],
        "decay_cycles": number(ringing.decay),
        "modes": [{"mode": one.mode, "share": number(one.share)} for one in ringing.told],
    }


def _si(machine: Machine, cycle: ValveCycle | None) -> dict[str, Any] | None:
    return plain(asdict(machine_figures(machine, cycle))) if machine.is_si and cycle is not None else None
