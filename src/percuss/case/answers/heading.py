"""What an answer begins with: the hammer and its load as they were understood, in words and in plain values."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, Literal

from percuss.case.answers.facts import (
    ReportSection,
    Teller,
    counted,
    json_number,
    measured,
    number,
    numbers,
    ordinal,
    percent,
    picked,
    plain,
    quantity,
)
from percuss.model.machine import Machine, switching_of
from percuss.steady.figures import FIGURES

if TYPE_CHECKING:
    from percuss.model import Load, Oil, SizedBody, Supply, System, Timed
    from percuss.model.body import Modes
    from percuss.model.checks import Array
    from percuss.recordings.history import HistoryReport
    from percuss.steady import Orbit
    from percuss.steady.self_excited.valve_cycle import ValveCycle


# ---- What must be said of a load that switches as a valve does: here it keeps time by itself


Clocked = Literal["no motion", "unstable", "near the fold"]  # why a verdict turns on the clock of the load
NEAR_FOLD = 0.02
"""Distance of the level from the greatest v_f, as a part of it, below which a motion counts as near the fold."""

CLOCKED = (
    "This verdict is for a load that keeps time by itself, whatever the piston does. If the piston works the valve, "
    "the phase, speed and energy of a motion hold, but its existence and stability do not follow from "
    'here: describe the valve instead (load kind = "valve").'
)
"""What the first lines say of a verdict that turns on the clock."""


def clock_note(load: Load) -> str:
    """The sentence for a load that switches, or ""."""
    found = switching_of(load)
    if found is None:
        return ""
    unit = "" if load.frequency is None else " N"
    return (
        f"the load switches between two levels, {found.high:.4g}{unit} and {found.low:.4g}{unit}, as a valve does: it "
        f"is at one of them for {100.0 * found.share:.0f} % of the time. Stability is judged as if the load kept time "
        "by itself; a valve operated by the piston would re-time it after every blow, so such a machine can run "
        "steadily where no stable motion is found here"
    )


def clock_in_short(load: Load) -> str:
    """The shorter sentence that the first lines of an answer have for a recorded load that switches; else ""."""
    if load.report is None or switching_of(load) is None:
        return ""
    return (
        "The recorded load switches as a valve does: stability is judged as if it kept time by itself, and a valve "
        "would re-time it (see the note)."
    )


def clocked_because(
    load: Load, levels: Iterable[tuple[float, float]], motions: Iterable[tuple[bool, bool]]
) -> Clocked | None:
    """Why the verdict on a load turns on its clock; None where it does not."""
    # It does for a recording or a load of steps without a stable motion, or within 2 % of the fold; and for one that
    # switches as a valve does also when another possible motion is unstable, as that one may be the machine's. `levels`
    # has of each number of load periods the level and the greatest v_f, `motions` of each motion whether it is
    # possible, and whether it is stable.
    if load.report is None and not load.is_piecewise:
        return None
    stable = [steady for possible, steady in motions if possible]
    if not stable:
        return "no motion"
    if not any(stable) or (not all(stable) and switching_of(load) is not None):
        return "unstable"
    return "near the fold" if any(abs(highest - level) < NEAR_FOLD * highest for level, highest in levels) else None


# ---- The hammer in plain values


def heading_dict(name: str, title: str, system: System, notes: Sequence[str]) -> dict[str, Any]:
    """What the answer to any question begins with: the case, the system, its recording, what was assumed."""
    history = system.load.report
    return {
        "case": name,
        "title": title,
        "system": system_dict(system),
        "body": body_dict(system),
        "contact": contact_dict(system),
        "history": None if history is None else plain(asdict(history)),
        "notes": list(notes),
    }


def system_dict(system: System) -> dict[str, Any]:
    """The system in plain values."""
    free = system.body.is_free
    return {
        "s": json_number(system.s) if free else None,
        "d": json_number(system.d) if free else None,
        **({} if free else {"gap": json_number(system.body.gap)}),
        "restitution": json_number(system.restitution),
        "coefficients": [[json_number(p.real), json_number(p.imag)] for p in system.load.coefficients.tolist()],
        "load_factor": json_number(system.load.load_factor),
    }


SHOWN_MODES = 8  # elastic modes that are told of a body


def body_dict(system: System) -> dict[str, Any]:
    """The body in plain values: its first elastic modes under the load, per radian of it, and in SI in Hz, too."""
    modes = system.body.modes(SHOWN_MODES, system.load.at)
    found: dict[str, Any] = {
        "kind": system.body.kind,
        "frequencies": numbers(modes.omega),
        "gamma": numbers(_without_rounding(modes, system) if system.body.is_free else modes.gamma),
        "damping": numbers(modes.damping),
    }
    if system.frequency is not None:
        found["frequencies_Hz"] = numbers(modes.omega * system.frequency)
    return found


_ROUNDING = 8.0 * sys.float_info.epsilon
"""Of the shape of a mode, per radian of its wave; nodes at the load have been seen within a seventh of it."""


def _without_rounding(modes: Modes, system: System) -> Array:
    """γ_n, and 0 where it is rounding: |φ_n(x_p)| at most 8 ε (1 + ω_n/s) times the greatest |φ_n| along the bar."""
    import numpy as np  # what only writes numbers has no need of it

    along = np.abs(system.body.shapes(np.linspace(0.0, 1.0, 65), modes.size).displacement).max(axis=0)
    rounding = _ROUNDING * (1.0 + modes.omega / system.s) * along
    return np.asarray(np.where(np.abs(modes.at_load) > rounding, modes.gamma, 0.0))


def motion_dict(hammer: System | Machine) -> dict[str, Any] | None:
    """The hammer as one rigid mass, or a structure by its modes, for what follows its motion in closed form.

    Modes q_n, what each moves the striking end by, in q_n″ + d_n q_n′ + ω_n² q_n = γ_n p, and the wall at Σ q_n = gap.
    The load is a Fourier series or exact steps, or the `valve` switches it: forces of its states with the gas at the
    wall, whose stiffness is ω². `lying` is the motion of several modes while the wall holds their contact: exponents,
    and the complex numbers that turn q_n and q_n′ into their amounts and back. None where the oil has a pressure, or a
    gas a curve of its own: there is no closed form.
    """
    arrays: dict[str, Any] = {"damping": [json_number(hammer.body.damping.rigid)], "drive": [1.0], "inertia": [1.0]}
    found: dict[str, Any] = {"gap": 0.0, "coefficients": [], "breaks": [], "values": [], "valve": None, "lying": None}
    if not isinstance(hammer, Machine):
        load = hammer.load
        arrays["omega"] = [0.0]
        found["coefficients"] = [[json_number(p.real), json_number(p.imag)] for p in load.coefficients.tolist()]
        found |= {"breaks": list(load.breaks), "values": list(load.values)}
        if not hammer.body.is_free:
            known = hammer.body.modes(hammer.body.kept(SHOWN_MODES), load.at)
            columns = {"omega": known.omega, "damping": known.damping, "drive": known.gamma, "inertia": known.inertia}
            arrays |= {name: numbers(column) for name, column in columns.items()}
            found |= {"gap": json_number(hammer.body.gap), "lying": _lying(hammer, known.size)}
    else:
        valve = hammer.valve
        if valve.flows or valve.supply is not None:
            return None
        arrays["omega"] = [math.sqrt(valve.chamber.stiffness)]
        states = {name: json_number(valve.force(name)) for name, _ in valve.pairs}
        ports = [picked(port, "to behind side delay reads on speed") for port in valve.ports]
        found["valve"] = {"states": states, "ports": ports, "start": valve.start}
    found["restitution"] = json_number(hammer.contact.restitution)
    scales = {"length_m": hammer.length_scale, "time_s": hammer.time_scale} if hammer.is_si else None
    return arrays | found | {"scales": scales}


def _lying(system: System, modes: int) -> dict[str, Any] | None:
    """Exponents, amounts of each q_n and q_n′ in each, and back; real and imaginary parts in turn."""
    if modes < 2:
        return None
    import numpy as np

    from percuss.mechanics.held_structure import held_structure

    exponents, forth, back = held_structure(system, modes).exponents
    return {
        "exponents": numbers(exponents.view(float)),
        "forth": numbers(forth.ravel().view(float)),
        "back": numbers(np.ascontiguousarray(back.transpose(2, 0, 1)).ravel().view(float)),
    }


def contact_dict(system: System | Machine) -> dict[str, str]:
    """The contact law in plain values."""
    return {"law": system.contact.law, "strain": system.contact.kind}


# ---- What was understood of a hammer, the first section of its reports

_FEW = 8  # sections of a bar that are told one by one


def system_section(name: str, system: System, notes: tuple[str, ...], law: Timed | None = None) -> ReportSection:
    """What was understood of the hammer: bar, dimensionless numbers, load, recording."""
    rows: list[tuple[str, str]] = [("case", name)]
    bar, history = system.bar, system.load.report
    if not system.body.is_free:
        rows += [*_structure_rows(system), ("load", _load_text(system)), *(("note", note) for note in notes)]
        return ReportSection("Structure", tuple(rows))
    if bar is not None:
        first = float(bar.natural_frequencies(1)[0])
        rows.append(
            (
                "the bar",
                f"{quantity(bar.length, 'm')} long, {_areas(bar)}, {number(bar.mass)} kg, "
                f"wave speed {number(bar.wave_speed)} m/s, first mode {quantity(first, 'Hz')}",
            )
        )
    rows.append(
        (
            "dimensionless",
            f"s = {number(system.s, 6)}, d = {number(system.d, 6)}, restitution R = {number(system.restitution)}",
        )
    )
    rows.append(("damping", _damping_text(system)))
    rows.append(("contact", system.contact.sentence))
    if law is not None:
        rows.append(("blow", law_sentence(law, system)))
    rows.append(("load", _load_text(system)))
    if history is not None:
        rows.append(("history", _history_text(history)))
        rows += [("warning", warning) for warning in history.warnings]
    rows += [("note", note) for note in notes]
    return ReportSection("Hammer", tuple(rows))


def _structure_rows(system: System) -> list[tuple[str, str]]:
    body, bar = system.body, system.bar
    rows = [("structure", str(body) if bar is None else str(bar))]
    known = body.modes(body.kept(4), system.load.at)
    told = ", ".join(number(omega, 6) for omega in known.omega)
    rows.append(("modes", f"ω = {told} per radian of the load, damped by {', '.join(map(number, known.damping))}"))
    if bar is not None and system.frequency is not None:
        rows.append(("frequencies", ", ".join(quantity(f, "Hz") for f in bar.natural_frequencies(known.size).tolist())))
    gap = Teller.of(system)(body.gap, "length")
    rows.append(("gap", f"{gap}, restitution R = {number(system.restitution)}"))
    return rows


def _areas(bar: SizedBody) -> str:
    """The cross-section of a bar, or those of its sections from the driven end on."""
    areas = [number(1e4 * piece.area) for piece in bar.pieces]
    if len(areas) == 1:
        return f"{areas[0]} cm²"
    told = areas if len(areas) <= _FEW else [*areas[: _FEW - 1], "…", areas[-1]]
    return f"{len(areas)} sections of {', '.join(told)} cm²"


def _damping_text(system: System) -> str:
    """The law of damping in words; in SI with the drag of one that brakes the bar as a whole."""
    words = system.body.damping.words
    if system.bar is None or not system.bar.rigid_drag:
        return words
    return f"{words}; c = {number(system.bar.rigid_drag)} N·s/m"


def _load_text(system: System) -> str:
    load = system.load
    size, last = load.harmonics.size, int(load.harmonics.max(initial=0))
    shape = counted(size, "harmonic")
    shape += f" up to the {ordinal(last)}" if last > size else ""
    if load.is_piecewise:
        shape = f"{len(load.values)} exact steps (and {shape})"
    factor = f"mean / first harmonic = {number(load.load_factor)}"
    if not system.is_si or system.frequency is None:
        return f"mean {number(load.mean)}, {shape}, {factor}"
    return f"mean {quantity(load.mean * system.force_scale, 'N')}, {shape}, {factor}, {number(system.frequency)} Hz"


def _history_text(report: HistoryReport) -> str:
    found = "given" if report.frequency_given else "found"
    return (
        f"{counted(report.cycles, 'cycle')}, {report.samples} samples at {quantity(report.sample_rate, 'Hz')}; "
        f"{number(report.frequency, 5)} Hz ({found}), period varies by {percent(report.jitter)}; cycles scatter "
        f"{percent(report.scatter)} about their mean, drift {percent(report.drift)}; the harmonics "
        f"do not capture {percent(report.residual)}"
    )


def law_sentence(law: Timed, system: System) -> str:
    tell = Teller.of(system)
    lasts, centroid = (tell(time, "time", 3, plain=4) for time in (law.duration, law.force_centroid))
    text = (
        f"{law.law}: restitution {number(law.restitution)}, contact {lasts}, centroid of its force after {centroid}; "
    )
    text += "the impact plane moves on from blow to blow" if law.advance_per_impulse else "the impact plane stays"
    text += f"; ringing takes {percent(law.ringing_share)} of the energy before the blow" if law.ringing_share else ""
    return f"{text}; {law.contacts} contacts, where the law holds for one" if law.contacts > 1 else text


# -- the machine ------------------------------------------------------------------------------------------------------


def machine_section(name: str, machine: Machine, notes: tuple[str, ...], room: float) -> ReportSection:
    """What was understood of the machine: bar, valve, ports, gas."""
    rows: list[tuple[str, str]] = [("case", name)]
    valve, bar, tell = machine.valve, machine.bar, Teller.of(machine)
    if bar is not None:
        rows.append(("piston", f"{quantity(bar.length, 'm')} long, {number(bar.mass)} kg"))
    rows.append(("contact", f"restitution R = {number(machine.contact.restitution)}; {machine.contact.sentence}"))
    drag = machine.drag
    rows.append(("drag", f"D/M = {number(drag)}{' per second' if bar is not None else ''}" if drag else "none"))
    gas = valve.chamber
    if gas.force or gas.stiffness:
        at_wall = tell(gas.force, "force")
        growth = gas.stiffness * (1.0 if bar is None else machine.force_scale / machine.length_scale)
        more = number(growth) if bar is None else f"{quantity(growth, 'N')}/m"
        bent = "" if gas.exponent is None else f" at first, with the power {number(gas.exponent)} of its volume"
        rows.append(("gas", f"{at_wall} at the wall, and {more} more on the way back{bent}"))
    if machine.pressure is not None:
        held = "" if valve.supply is None else ", for which the forces below hold"
        rows.append(("supply", f"{number(machine.pressure / 1e5)} bar{held}"))
    if valve.supply is not None:
        rows.append(("pump", _pump_text(machine, valve.supply)))
    if valve.oil is not None:
        rows += _oil_rows(machine, valve.oil)
    with_gas = " with the gas at the wall" if gas.force else ""
    for state, _ in valve.pairs:
        begins = ", the state at the start" if state == valve.start else ""
        force = valve.force(state)
        where = "toward the wall" if force >= 0.0 else "away from the wall"
        rows.append((state, f"{tell(abs(force), 'force')} {where}{with_gas}{begins}"))
    for i in range(len(valve.ports)):
        rows.append((f"ports[{i}]", _port_text(machine, i)))
    if math.isfinite(room):
        rows.append(("room", f"{tell(room, 'length')} behind the wall"))
    rows += [("note", note) for note in notes]
    return ReportSection("Machine", tuple(rows))


def _pump_text(machine: Machine, supply: Supply) -> str:
    unit, varied = machine.pressure, ""
    if supply.quickening:
        varied = f"; delays over 1 + {number(supply.quickening)} (P/P0 − 1), P0 the pressure for which they hold"
    if unit is None:
        held = "pressure 1 for the forces below"
        return f"flow {number(supply.flow)}, accumulator {number(supply.compliance)}, {held}{varied}"
    flow = supply.flow * machine.power_scale / unit
    volume, gas = supply.compliance * machine.energy_scale / unit**2, supply.gas
    held = f"{number(1e11 * volume)} cm³/bar"
    if gas is not None:
        litres = 1e3 * gas.volume * machine.energy_scale / unit
        held = f"{number(litres)} l at {number(gas.precharge * unit / 1e5)} bar, n = {number(gas.exponent)}"
    text = f"{number(6e4 * flow)} l/min into an accumulator of {held}"
    text += f"; {number(supply.start * unit / 1e5)} bar at the start"
    if supply.power is not None:
        text += f"; at most {quantity(supply.power * machine.power_scale, 'W')}"
    if supply.slip:
        text += f"; {number(6e4 * supply.slip * machine.power_scale / unit)} l/min less at {number(unit / 1e5)} bar"
    if supply.relief is not None:
        what = "is held" if supply.relief.slope is None else "opens the relief valve"
        text += f"; {number(supply.relief.pressure * unit / 1e5)} bar {what}"
    return text + varied


def _oil_rows(machine: Machine, oil: Oil) -> list[tuple[str, str]]:
    """What the oil loses: passages, the line to the tank, leakage, the spool."""
    tell, unit, rows = Teller.of(machine), machine.pressure, list[tuple[str, str]]()
    known, seen = {one.name: one for one in oil.chambers}, set[object]()
    for state, joins in oil.pairs:
        for join in joins:
            if join in seen or not (join.inward or join.outward):
                continue
            seen.add(join)
            at = known[join.chamber].area  # a flow at unit speed of the piston
            drops = [zeta * at * at for zeta in dict.fromkeys((join.inward, join.outward))]
            if unit is None:
                told = " and ".join(number(drop) for drop in drops)
            else:
                fast = 10.0 / machine.speed_scale
                told = " and ".join(f"{number(drop * fast * fast * unit / 1e5)} bar" for drop in drops)
                told += " at 10 m/s of the piston"
            way = "" if len(drops) == 1 else ", in and out"
            rows.append(("passage", f"{join.chamber} chamber and {join.to} ({state}): {told}{way}"))
    if oil.tank:
        rows.append(("tank", f"{supply_pressure(machine, oil.tank)} in the line"))
    if oil.leakage:
        flow = oil.leakage if unit is None else 6e4 * oil.leakage * machine.power_scale / unit
        text = number(flow) if unit is None else f"{number(flow)} l/min at {number(unit / 1e5)} bar"
        rows.append(("leakage", text))
    if oil.spool:
        rows.append(("spool", f"{tell(oil.spool, 'time')} from one state to the next"))
    return rows


def _port_text(machine: Machine, number_of: int) -> str:
    port, tell = machine.valve.ports[number_of], Teller.of(machine)
    delay = f" after {tell(port.delay, 'time')}" if port.delay else ""
    if port.on == "impact":
        return f"every blow: {port.to}{delay}"
    where = "farther than" if port.side == "back" else "nearer than"
    whose = "" if port.reads == "centre" else f", read at x = {number(float(port.reads))} of the bar"
    if port.behind is None:
        way = "away from" if port.side == "back" else "toward"
        return f"faster than {tell(abs(port.level), 'speed')} {way} the wall: {port.to}{delay}{whose}"
    return f"{where} {tell(port.behind, 'length')} behind the wall: {port.to}{delay}{whose}"


def figures_in_short(machine: Machine, energy: float, speed: float, blows: int, period: float) -> str:
    """Energy and speed of a blow, and the rate of the blows of a cycle."""
    tell, rate = Teller.of(machine), blows / period
    if not tell.is_si:
        return f"striking speed {number(speed, 5)}, period {number(period, 5)}"
    return (
        f"{tell(energy, 'energy')} at {tell.given(rate, 'Hz')} ({tell.given(rate, 'per_min')}), {tell(speed, 'speed')}"
    )


def supply_pressure(machine: Machine, pressure: float) -> str:
    """The pressure of a supply, as a multiple of the one for which the forces hold where that is not known."""
    return number(pressure) if machine.pressure is None else f"{number(pressure * machine.pressure / 1e5)} bar"


# ---- Figures that no hammer has: a slip of a unit or a digit gives an answer that is right, and absurd


def _half_wave(motion: Orbit | ValveCycle) -> float:
    """ρ c v/2 of the section that strikes."""
    bar = motion.system.bar
    assert bar is not None
    return 0.5 * bar.pieces[-1].impedance / bar.pieces[-1].area * (_SPEED(motion) or 0.0)


def _strokes(motion: Orbit | ValveCycle) -> float | None:
    """The stroke over the way to the farthest port."""
    valve = getattr(motion.system, "valve", None)
    edges = [] if valve is None else [abs(port.behind) for port in valve.ports if port.behind]
    return float(motion.stroke / max(edges)) if edges else None


def _bar(motion: Any) -> float | None:
    """The mean pressure of the oil, in bar."""
    pressure = getattr(motion.system, "pressure", None)
    return None if pressure is None else float(pressure * motion.mean_pressure / 1e5)


_SPEED, _RATE = FIGURES["impact_velocity"].in_si, FIGURES["blow_rate"].in_si
_RULES: tuple[tuple[Callable[[Any], float | None], float, str, str], ...] = (
    (_SPEED, 20.0, "it strikes at {}, where percussive machines strike at 5 to 12 m/s", "m/s"),
    (_half_wave, 1e9, "ρ c v/2 = {} is beyond the yield stress of hardened steel, about 1 GPa", "Pa"),
    (_strokes, 10.0, "its stroke is {} times the way to its farthest port", ""),
    (_bar, 500.0, "the pressure of its oil is {} bar, where hydraulic hammers have 100 to 250 bar", ""),
    (lambda one: one.system.bar.mass * _RATE(one), 6e4,
     "mass times blow rate is {} kg/s, as of a piston of a tonne at 60 Hz", ""),
)  # fmt: skip
"""Figures of a cycle in SI, the most that is taken without a word, and what is said of more."""


def doubts(motion: Orbit | ValveCycle | None) -> tuple[str, ...]:
    """What of a cycle in SI no hammer has, one sentence each."""
    if motion is None or not motion.impact_velocity > 0.0:
        return ()
    if not (motion.system.is_si and motion.system.bar is not None and motion.system.body.is_free):
        return ()
    found = ((value(motion), most, text, unit) for value, most, text, unit in _RULES)
    told = [text.format(measured(value, unit)) for value, most, text, unit in found if value and value > most]
    return tuple(f"hardly a hammer: {text}; check sizes and units" for text in told)
