"""Every public callable, walked with wrong objects in every parameter: an error of the package, or what is written."""

from __future__ import annotations

import dataclasses
import importlib
import inspect
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

import percuss
from percuss import (
    Bar,
    Case,
    Kept,
    Load,
    Start,
    Starts,
    Stop,
    System,
    blow,
    explore,
    plot,
    run,
    simulate,
    stability,
    steady,
    steady_states,
    units,
)
from percuss import case as room_of_cases
from percuss.blow import machine
from percuss.errors import ParameterError, PercussError
from percuss.model import (
    Chamber,
    Cushion,
    External,
    KelvinVoigt,
    Machine,
    ModalBody,
    Mounted,
    Port,
    Ratio,
    Reversed,
    Section,
    SectionedBar,
    SizedModes,
    SteppedBar,
    Supply,
    Table,
    Timed,
    UniformBar,
    Valve,
)
from percuss.recordings import read_recording

ROOMS = (
    "recordings", "model", "steady", "stability", "simulate", "blow", "blow.machine", "explore", "case", "plot",
    "units",
)  # fmt: skip


class Anything:
    """A class that takes anything, where a number or an object is meant."""

    def __init__(self, *_: object) -> None: ...


WRONG: dict[str, Any] = {
    "None": None,
    "text": "x",
    "nan": float("nan"),
    "inf": float("inf"),
    "-1": -1,
    "400 digits": 10**400,
    "empty": [],
    "object": object(),
    "complex": 1j,
    "bool": True,
    "bytes": b"x",
    "class": Anything,
    "number in quotes": "1",
    "texts": [1.0, "1"],
    "nones": [None],
    "400 digits in a list": [0.5, 10**400],
    "bools": [True, False],
    "dict": {},
    "other keys": {1: 2},
}

MADE_HERE = "a result, or a part of one: made by the package, not by its users"
NO_DOORS: dict[str, str] = {
    **dict.fromkeys(
        [
            "recordings.HistoryReport",
            "recordings.Recording",
            "model.Section.piece",
            "model.Jump",
            "model.MachineModes",
            "steady.BlankBlow",
            "steady.Drag",
            "steady.ElasticCycle",
            "steady.Energy",
            "steady.Field",
            "case.RecordedAnswer",
            "steady.FoundOrbits",
            "steady.FoundRestCycles",
            "steady.Interval",
            "steady.ModalState",
            "steady.Nearest",
            "steady.Orbit",
            "steady.PeriodicOrbit",
            "steady.PortAndDelay",
            "steady.Reading",
            "steady.RecordedSwitch",
            "steady.RecordedSwitch.port",
            "steady.RecordedValve",
            "steady.Rest",
            "steady.RestCycle",
            "steady.RigidCycle",
            "steady.SelfExcited",
            "steady.Sensitivity",
            "steady.SlowPressure",
            "steady.SIReport",
            "steady.SteadyStates",
            "steady.TimedOrbit",
            "steady.TimedStates",
            "steady.ValveCycle",
            "steady.ValveCycle.position",
            "steady.ValveMargins",
            "steady.Rhythm.of_rigid",
            "steady.Violation",
            "stability.ExactPlane",
            "stability.LinearMap",
            "stability.Multipliers",
            "stability.OrbitMultipliers",
            "stability.Plane",
            "stability.Reduced",
            "stability.Stability",
            "stability.TimedStability",
            "stability.Waveform",
            "simulate.Cycle",
            "simulate.EnergyBalance",
            "simulate.Ensemble",
            "simulate.EnsembleProgress",
            "simulate.Event",
            "simulate.Events",
            "simulate.MachineBalance",
            "simulate.MachineCycle",
            "simulate.MachineEnsemble",
            "simulate.MachineEvent",
            "simulate.MachineEvents",
            "simulate.MachineTrajectory",
            "simulate.Progress",
            "simulate.SISummary",
            "simulate.Summary",
            "simulate.Trajectory",
            "blow.AlongBody",
            "blow.Blow",
            "blow.EffectiveBlow",
            "blow.Energy",
            "blow.Impacts",
            "blow.Impacts.part",
            "blow.Lattice",
            "blow.MachineMotion",
            "blow.MachineProgress",
            "blow.Peak",
            "blow.Pulse",
            "blow.Settled",
            "blow.Spell",
            "blow.StringState",
            "blow.Trace",
            "blow.Trace.around",
            "blow.Trace.product_integral",
            "blow.Trace.scaled",
            "blow.Uncertainty",
            "blow.Waves",
            "explore.Archive",
            "explore.Basins",
            "explore.Boundaries",
            "explore.Branch",
            "explore.Branch.at",
            "explore.Branch.times_at",
            "explore.BranchPoint",
            "explore.PointCurve",
            "explore.PointCurve.at",
            "explore.PointCurve.times_at",
            "explore.Diagram",
            "explore.DiagramBranch",
            "explore.DiagramBranch.at",
            "explore.DiagramBranch.times_at",
            "explore.DiagramBranch.release_at",
            "explore.Doubling",
            "explore.Experiment",
            "explore.JobProgress",
            "explore.Reach",
            "explore.ReachEnd",
            "explore.PlainMotion",
            "explore.SettledMotion",
            "explore.Lyapunov",
            "explore.Share",
            "explore.Sweep",
            "case.CaseErrors",
            "case.CaseReach",
            "case.SampleMachine",
            "case.BestAnswer",
            "case.BlowAnswer",
            "case.MeasuredGauge",
            "case.OrbitAnswer",
            "case.PeriodAnswer",
            "case.Simulation",
            "case.MachineAnswer",
            "case.MachineMotion",
            "case.SimulationAnswer",
            "case.SteadyAnswer",
            "case.StructureAnswer",
            "case.WavesAnswer",
            "steady.ModalState.first",
            "stability.LinearMap.dense",
            "stability.LinearMap.participation",
            "stability.LinearMap.shares",
        ],
        MADE_HERE,
    ),
    **dict.fromkeys(
        [
            "steady.Orbit.end_motion",
            "steady.Orbit.forced_elastic",
            "steady.Orbit.rigid_motion",
            "steady.TimedOrbit.rigid_motion",
            "steady.Orbit.transient",
            "steady.Orbit.modal_state",
            "steady.PeriodicOrbit.modal_state",
        ],
        "takes arrays and counts that other floors have checked, millions of times",
    ),
    **dict.fromkeys(
        [
            "explore.Archive.bounds",
            "explore.Archive.create",
            "explore.Archive.keep",
            "explore.Archive.resume",
            "explore.Archive.write",
            "explore.Basins.from_archive",
            "explore.Basins.of",
            "explore.Diagram.from_archive",
            "explore.Diagram.of",
            "explore.Experiment.from_archive",
            "explore.Experiment.of",
            "explore.Sweep.from_archive",
            "explore.Sweep.shaped",
        ],
        "between the parts of a job that is carried out: its doors are carry_out and Archive.open",
    ),
    **dict.fromkeys(
        ["blow.Outcome", "blow.Ending", "explore.BranchEvent"],
        "a word, made from its sentence",
    ),
    "case.Case": "its tables are pydantic's; the doors are Case.read and Case.from_text",
    "explore.Family": "a protocol",
    "explore.Family.check": "a protocol",
    "explore.Family.system": "a protocol",
    "explore.MachineFamily.system": "refuses whatever it is given: a machine that switches itself is no system",
    "explore.Job": "a protocol",
    "explore.Job.compute": "a protocol",
    "explore.Column": "what one's own job keeps; numpy judges its type",
    **dict.fromkeys(
        ["model.Body", "model.SizedBody", "model.Damping", "model.Contact"],
        "a contract: the doors are its kinds",
    ),
    "steady.recorded_together": "takes readings of records in SI alone: tests/steady/test_recorded_valve.py",
    **dict.fromkeys(
        ["model.Modes", "model.Shape", "model.Result", "steady.Drop", "steady.Obstacle", "steady.Reason"], MADE_HERE
    ),
    "errors.PercussError": "what comes out",
}

# What is no error: a value that has a meaning in this place
OPTIONAL = {"None"}
REAL = {"-1"}
PLACES = {"empty"}
ANY_NUMBERS = REAL | PLACES
TEXT = {"text", "number in quotes"}
NO_KEYS = {"dict"}

SYSTEM = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))
SI_LOAD = Load.harmonic(900.0, 1000.0, frequency=50.0)
SECTIONED = SectionedBar([Section(0.1, 1e-3), Section(0.2, 2e-3)])
SI_SYSTEM = System.from_si(Bar(0.3, 1e-3), SI_LOAD, Kept(0.5))
SHORT = Stop(impacts=3)
VALVE = Valve(
    {"return": -0.4, "power": 1.8}, (Port("power", behind=1.0, side="back"), Port("return", on="impact", delay=0.01))
)
HELD = """
[body]
kind = "mounted"
spring = 0.5
dashpot = 0.1
[system]
restitution = 0.5
[load]
kind = "harmonic"
mean = 0.1
amplitude = 1.0
"""
MODES: dict[str, Any] = {"omega": (1.5,), "delta": (0.1,), "contact": (1.0,), "drive": (1.0,)}
SIGNED = {"contact": {"-1"}, "drive": {"-1"}, "gap": {"-1"}}
STRUCTURE = System(ModalBody(**MODES, gap=0.1), Load.harmonic(0.1, 1.0), Kept(0.5))
MACHINE = Machine(UniformBar(20.0), VALVE, Kept(0.2))
FED_CYCLE = steady.self_excited_motion(
    MACHINE.with_valve(dataclasses.replace(VALVE, supply=Supply(0.7, 15.0))), modes=0
).cycle
PLAIN = """
[system]
s = 20.0
d = 0.0048
restitution = 0.6
[load]
kind = "harmonic"
mean = 0.9
amplitude = 1.0
[simulation]
modes = 0
impacts = 3
"""
RUNNING: dict[str, Any] = {
    "archive": None, "resume": False, "workers": 1, "pool": None, "chunk": 1, "progress": None,
}  # fmt: skip
RUNNING_TAKES = {
    "archive": OPTIONAL | TEXT, "resume": {"bool"}, "workers": OPTIONAL, "pool": OPTIONAL, "chunk": OPTIONAL,
    "progress": OPTIONAL | {"class"},
}  # fmt: skip
"""A class is a callable: here one whose objects are true, which ends a computation."""


SQUARE = Case.from_text(
    '[system]\ns = 50.0\nd = 0.0\nrestitution = 0.2\n[load]\nkind = "square"\namplitude = 1.0\nkappa = 1.2\n'
)
RANGE: dict[str, Any] = {"name": "bar.length", "low": 100.0, "high": 300.0, "unit": "mm"}


class Two:
    """A job of two items."""

    size = 2
    columns: ClassVar = {"square": explore.Column()}
    ask: ClassVar = {"kind": "squares"}

    def compute(self, first: int, last: int, stopped: Callable[[], bool]) -> dict[str, Any]:
        return {"square": np.arange(first, last) ** 2.0}


Entry = tuple[Callable[..., object], dict[str, Any], dict[str, set[str]]]


def table(folder: Path) -> dict[str, Entry]:
    """A valid call of everything public: callable, arguments, and the objects that have a meaning in their places."""
    bar, contact, timed = Bar(0.3, 1e-3), Kept(0.5), Timed.of_uniform_bar(20.0, 0.6)
    load, square = SYSTEM.load, Load.square(1.0, 1.3)
    states = steady_states(SYSTEM)
    orbit, slow = states.orbits[1], steady.timed_states(SYSTEM, timed)
    one_impact = steady.PeriodicOrbit(SYSTEM, 1, (states.orbits[1].phase,), 0)
    followed = explore.follow(one_impact, "mean", (0.89, 0.91), most=2)
    jackleg = room_of_cases.load_case("pneumatic-jackleg")
    to_fold = room_of_cases.branch_answer(jackleg, "1/1:2", "load_factor=0.39:0.45", modes=0)
    fold = to_fold.at(explore.BranchEvent.FOLD)[0]
    curve = explore.follow_point(fold, ("restitution", "load_factor"), ((0.149, 0.151), (0.4, 0.45)), most=2)
    (resting,) = steady.rest_cycles(SYSTEM, modes=0).cycles
    rests = explore.follow_rest_cycle(resting, "mean", (0.89, 0.91), points=2)
    shown = explore.diagram(SYSTEM, "mean=0.85:0.95:2", up_to=None, starts=1, runs=0, modes=0, stop=SHORT, workers=1)
    several = steady.PeriodicOrbit(SYSTEM, 1, (0.8, 2.5), 2)
    machine_motion = simulate.run_machine(MACHINE, modes=0, stop=Stop(impacts=3, periodic=False))
    motion = run(SYSTEM, modes=0, stop=SHORT)
    saved = folder / "motion.nc"
    motion.save(saved)
    machine_saved = folder / "machine.nc"
    machine_motion.save(machine_saved)
    recorded = folder / "recorded.csv"
    rows = (f"{1e-3 * i},{i % 5},{i % 3}" for i in range(100))
    recorded.write_text("\n".join(["time [s],force [N],back [N]", *rows]), encoding="utf-8")
    case = Case.from_text(PLAIN, "plain.toml")
    structure = Case.from_text(HELD, "held.toml")
    answer = room_of_cases.steady_answer(case)
    simulated = room_of_cases.simulation_answer(case)
    by_waves = room_of_cases.waves_answer(case, cells=16)
    drilling = room_of_cases.load_case("valve-drifter").changed(simulation={"modes": 0, "impacts": 3})
    machined = room_of_cases.machine_answer(drilling, modes=0)
    machine_moved = room_of_cases.machine_motion(drilling)
    hammer = room_of_cases.load_case("laboratory-striker")
    one_blow = room_of_cases.blow_answer(hammer)
    by_key = room_of_cases.CaseFamily(hammer, {"bar.length": "mm"})
    clock = np.arange(0.0, one_blow.blow.until, 1e-6)
    pushed = one_blow.waves.incident.at(clock) + one_blow.waves.reflected.at(clock)
    seen = folder / "gauge.csv"
    seen.write_text("t [s],F [N]\n" + "".join(f"{t},{f}\n" for t, f in zip(clock, pushed, strict=True)))
    family = room_of_cases.CaseFamily(case, {})
    machines = room_of_cases.CaseFamily(room_of_cases.load_case("valve-drifter"), {})
    swept = explore.sweep(SYSTEM, "restitution=0.2,0.6", quantities=["orbits"], workers=1)
    ends = explore.experiment(SYSTEM, 4, stop=SHORT, workers=1)
    basin = explore.basins(SYSTEM, ("time", 0.0, 1.0, 2), ("velocity", -1.0, -0.5, 2), stop=SHORT, workers=1)
    edges = explore.boundaries(SYSTEM, ("restitution", [0.3]), ("load_factor", 0.1, 1.0), kinds=("fold",))
    explore.carry_out(Two(), archive=folder / "kept", workers=1)
    time = np.linspace(0.0, 10.0, 500)
    axis = explore.Axis.linear("restitution", 0.2, 0.6, 2)
    struck = blow.strike(bar, blow.Rod([Section(None, 1e-3)]), 1.0)
    t, side = {"t": PLACES}, {"side": "right"}
    plane = {"restitution": PLACES, "load_factor": ANY_NUMBERS}
    sums = {"modes": OPTIONAL, "impacts": OPTIONAL}
    searched = room_of_cases.best_answer(hammer, [room_of_cases.Span(**RANGE)], "efficiency", most=20)
    return {
        # -- model --
        "recordings.read_recording": (
            read_recording,
            {"path": recorded, "column": "force", "unit": "N", "time_column": "time", "sample_rate": "1 kHz"}
            | {"opposing_column": "back", "start": 0.01, "end": 0.08, "sensor": "load"},
            {"unit": OPTIONAL, "time_column": OPTIONAL | {"number in quotes"}, "sample_rate": OPTIONAL}
            | {"opposing_column": OPTIONAL, "start": OPTIONAL | {"-1"}, "end": OPTIONAL},
        ),
        "model.Bar": (
            Bar, {"length": 1.0, "area": 1.0, "youngs_modulus": 1.0, "density": 1.0, "damping": None}
            | {"diameter": None, "damping_ratio": None, "drag": None},
            {"damping": OPTIONAL, "diameter": OPTIONAL, "damping_ratio": OPTIONAL, "drag": OPTIONAL},
        ),
        "model.Bar.body": (bar.body, {"angular_frequency": 2.0}, {}),
        "model.UniformBar": (UniformBar, {"s": 1.0, "damping": External(0.1)}, {}),
        "model.UniformBar.place": (UniformBar(1.0).place, {"number": 0}, {}),
        "model.HeldBody.place": (Mounted(1.0).place, {"number": 0}, {}),
        "model.Mounted.place": (Mounted(1.0).place, {"number": 0}, {}),
        "model.ModalBody.place": (ModalBody(**MODES).place, {"number": 0}, {}),
        "model.Mounted": (
            Mounted, {"stiffness": 1.0, "dashpot": 0.1, "s": 4.0, "damping": External(0.1), "gap": 0.1},
            {"s": {"inf"}, "gap": {"-1"}},
        ),
        "model.ModalBody": (ModalBody, {**MODES, "gap": 0.1}, SIGNED),
        "model.SizedModes": (SizedModes, {**MODES, "gap": 0.1}, SIGNED),
        "model.SizedModes.body": (SizedModes(**MODES).body, {"angular_frequency": 2.0}, {}),
        "model.SizedModes.natural_frequencies": (SizedModes(**MODES).natural_frequencies, {"modes": 1}, {}),
        "model.SteppedBar": (
            SteppedBar, {"s": 1.0, "impedances": (1.0, 2.0), "transit_times": (1.0, 1.0), "damping": External(0.1)}
            | {"lengths": (1.0, 2.0)},
            {"lengths": OPTIONAL},
        ),
        "model.SteppedBar.place": (SteppedBar(1.0, (1.0, 2.0), (1.0, 1.0)).place, {"number": 1}, {}),
        "model.Section": (
            Section, {"length": 0.1, "area": 1e-3, "diameter": None, "bore": 0.01}
            | {"youngs_modulus": 1.0, "density": 1.0},
            {"length": OPTIONAL, "diameter": OPTIONAL},
        ),
        "model.SectionedBar": (SectionedBar, {"sections": [Section(0.1, 1e-3)], "damping": External(0.1)}, {}),
        "model.SectionedBar.body": (SECTIONED.body, {"angular_frequency": 2.0}, {}),
        "model.SectionedBar.natural_frequencies": (SECTIONED.natural_frequencies, {"modes": 2}, {}),
        "model.External": (External, {"d": 0.1}, {}),
        "model.Ratio": (Ratio, {"ratio": 0.1}, {}),
        "model.KelvinVoigt": (KelvinVoigt, {"eta": 0.1}, {}),
        "model.Table": (Table, {"values": (0.1, 0.2)}, {}),
        "model.Bar.natural_frequencies": (bar.natural_frequencies, {"modes": 2}, {}),
        **{
            f"model.{law.__name__}": (
                law, {"restitution": None, "receiving_area": 2.0, "area": 1.0}, {"restitution": OPTIONAL},
            )
            for law in (Kept, Reversed)
        },
        **{
            f"model.{law.__name__}.with_restitution": (law(0.5).with_restitution, {"restitution": 0.2}, {})
            for law in (Kept, Reversed)
        },
        "model.Timed": (
            Timed, {"restitution": 0.5, "duration": 0.1, "force_centroid": 0.04, "advance_per_impulse": 0.01}
            | {"ringing_share": 0.1, "contacts": 1, "law": "b77-blow"},
            {},
        ),
        "model.Timed.of_uniform_bar": (
            Timed.of_uniform_bar, {"s": 20.0, "restitution": 0.5, "advance": "kept"}, {},
        ),
        "model.Timed.velocity": (
            timed.velocity, {"impulse": 1.0, "force": 0.5, "d": 0.1}, {"impulse": REAL, "force": REAL},
        ),
        "model.Timed.impulse": (
            timed.impulse, {"velocity": 1.0, "force": 0.5, "d": 0.1}, {"velocity": REAL, "force": REAL},
        ),
        "model.Timed.steady_impulse": (timed.steady_impulse, {"mean": 0.9, "period": 6.0, "d": 0.1}, {"mean": REAL}),
        "model.Timed.ringing_left": (timed.ringing_left, {"rate": 0.1, "period": 6.0}, {}),
        "model.Chamber": (Chamber, {"force": 0.4, "stiffness": 0.9}, {"force": REAL}),
        "model.Cushion": (
            Cushion,
            {"beyond": 0.1, "force": 1.0, "stiffness": 9.0, "length": 0.2, "returned": 0.1, "area": 1e-3},
            {"length": OPTIONAL, "area": OPTIONAL},
        ),
        "model.Cushion.energy": (Cushion(force=1.0).energy, {"depth": 0.1}, {}),
        "model.Cushion.scaled": (Cushion(force=1.0).scaled, {"force": 2.0, "length": 2.0}, {}),
        "model.Port": (
            Port, {"to": "power", "behind": 1.0, "side": "back", "delay": 0.1, "reads": 0.5, "on": "entering"},
            {"to": TEXT, "reads": set()},
        ),
        "model.Supply": (Supply, {"flow": 0.7, "compliance": 9.0, "start": 1.0}, {}),
        "model.Supply.of_oil": (
            Supply.of_oil, {"flow": 2e-3, "compliance": 1e-8, "pressure": 1e7, "start": None}, {"start": OPTIONAL},
        ),
        "model.Supply.scaled": (Supply(0.7, 9.0).scaled, {"power": 2.0, "energy": 2.0}, {}),
        "model.Valve": (
            Valve, {"states": {"return": -0.4, "power": 1.8}, "ports": VALVE.ports, "start": "power"}
            | {"chamber": Chamber(), "cushion": Cushion(), "supply": Supply(0.7, 9.0)},
            {"start": OPTIONAL, "cushion": OPTIONAL, "supply": OPTIONAL},
        ),
        "model.Valve.at_pressure": (VALVE.at_pressure, {"pressure": 2.0}, {}),
        "model.Valve.scaled": (VALVE.scaled, {"force": 2.0, "length": 2.0, "time": 1.0}, {}),
        "model.Machine": (
            Machine, {"body": UniformBar(20.0), "valve": VALVE, "contact": Kept(0.2), "at": 0, "bar": None}
            | {"pressure": None},
            {"bar": OPTIONAL, "pressure": OPTIONAL},
        ),
        "model.Machine.from_si": (
            Machine.from_si, {"bar": bar, "valve": VALVE, "contact": Kept(0.2), "at": 0, "pressure": None},
            {"pressure": OPTIONAL},
        ),
        "model.Machine.modes": (MACHINE.modes, {"count": 2}, {}),
        "model.Machine.with_valve": (MACHINE.with_valve, {"valve": VALVE}, {}),
        "model.MachineModes.at": (MACHINE.modes(2).at, {"body": UniformBar(20.0), "x": [0.5]}, {"x": PLACES}),
        "model.Valve.force": (VALVE.force, {"state": "power"}, {}),
        "model.Load": (
            Load, {"coefficients": [0.3, 1.0], "frequency": 1.0, "breaks": (), "values": (), "report": None}
            | {"error": 0.1, "at": 0},
            {"coefficients": REAL, "frequency": OPTIONAL, "breaks": PLACES, "values": PLACES}
            | {"report": OPTIONAL, "error": OPTIONAL},
        ),
        "model.Load.acting_at": (load.acting_at, {"number": 1}, {}),
        "model.Load.harmonic": (
            Load.harmonic, {"mean": 0.9, "amplitude": 1.0, "harmonic": 1, "frequency": 1.0},
            {"mean": REAL, "amplitude": REAL, "frequency": OPTIONAL},
        ),
        "model.Load.square": (
            Load.square, {"amplitude": 1.0, "kappa": 1.3, "harmonics": 8, "frequency": 1.0}, {"frequency": OPTIONAL},
        ),
        "model.Load.steps": (
            Load.steps, {"breaks": [0.0, 1.0], "values": [1.0, 0.3], "harmonics": 8, "frequency": 1.0},
            {"frequency": OPTIONAL},
        ),
        "model.Load.fourier": (Load.fourier, {"coefficients": [0.3, 1.0], "frequency": 1.0}, {"frequency": OPTIONAL}),
        "model.Load.from_function": (
            Load.from_function, {"function": np.cos, "harmonics": 2, "tolerance": 1e-3, "frequency": 1.0},
            {"harmonics": OPTIONAL, "frequency": OPTIONAL},
        ),
        "model.Load.history": (
            Load.history, {"time": time, "values": np.sin(2 * np.pi * time) + 0.3, "area": 1.0, "frequency": 1.0}
            | {"harmonics": 3},
            {"area": OPTIONAL, "frequency": OPTIONAL, "harmonics": OPTIONAL},
        ),
        "model.Load.value": (load.value, {"t": 0.1} | side, {"t": ANY_NUMBERS}),
        "model.Load.derivative": (load.derivative, {"t": 0.1} | side, {"t": ANY_NUMBERS}),
        "model.Load.antiderivative": (load.antiderivative, {"t": 0.1}, {"t": ANY_NUMBERS}),
        "model.Load.on_steps": (square.on_steps, {"t": 0.1, "error": 0.0}, {"t": ANY_NUMBERS, "error": ANY_NUMBERS}),
        "model.Load.piece": (square.piece, {"t": 0.1} | side, {"t": ANY_NUMBERS}),
        "model.Load.scaled": (load.scaled, {"factor": 2.0, "frequency": 1.0}, {"factor": REAL, "frequency": OPTIONAL}),
        "model.Load.shifted": (load.shifted, {"phi": 1.0}, {"phi": REAL}),
        "model.Load.with_mean": (load.with_mean, {"mean": 1.0}, {"mean": REAL}),
        "model.System": (
            System, {"s": None, "d": None, "restitution": None, "load": load, "bar": bar, "frequency": 2.0}
            | {"body": UniformBar(1.0), "contact": contact},
            {"s": OPTIONAL, "d": OPTIONAL, "restitution": OPTIONAL},
        ),
        "model.System.with_load": (SYSTEM.with_load, {"load": load}, {}),
        "model.System.uniform": (SYSTEM.uniform, {"s": 1.0, "d": 0.1}, {"s": OPTIONAL, "d": OPTIONAL}),
        "model.System.from_si": (
            System.from_si, {"bar": bar, "load": SI_LOAD, "contact": contact}, {},
        ),
        "model.System.stress": (
            SI_SYSTEM.stress, {"x": [0.5], "strain": [1e-3]}, {},
        ),
        "model.System.with_load_factor": (SYSTEM.with_load_factor, {"load_factor": 0.5}, {"load_factor": REAL}),
        "model.System.with_restitution": (SYSTEM.with_restitution, {"restitution": 0.5}, {}),
        # -- steady --
        "steady.steady_states": (
            steady_states, {"system": SYSTEM, "periods": 1, "modes": 4, "tolerance": 1e-8}, {"modes": OPTIONAL},
        ),
        "steady.timed_states": (
            steady.timed_states, {"system": SYSTEM, "law": timed, "periods": 1, "modes": 4}, {"modes": OPTIONAL},
        ),
        "steady.TimedStates.curve": (slow.curve, {"phase": 1.0}, {"phase": ANY_NUMBERS}),
        "steady.SteadyStates.contact_place": (
            steady_states(STRUCTURE).contact_place, {"phase": 1.0}, {"phase": ANY_NUMBERS}
        ),
        "steady.SteadyStates.rigid_velocity": (states.rigid_velocity, {"phase": 1.0}, {"phase": ANY_NUMBERS}),
        **{
            f"steady.Orbit.{name}": (
                getattr(orbit, name), {"x": 0.5, "t": 1.0}, {"x": PLACES, "t": ANY_NUMBERS},
            )
            for name in ("displacement", "field", "strain", "velocity")
        },
        "steady.Orbit.driven_end": (orbit.driven_end, {"t": 1.0}, {"t": ANY_NUMBERS}),
        "steady.Orbit.end_point": (orbit.end_point, {"t": 1.0}, {"t": ANY_NUMBERS}),
        "steady.Orbit.impact_field": (orbit.impact_field, {"x": 0.5}, {"x": PLACES}),
        "steady.Orbit.impact_history": (orbit.impact_history, {"impacts": 2}, {}),
        "steady.self_excited_motion": (
            steady.self_excited_motion, {"machine": MACHINE, "modes": 1, "room": 9.0, "near": None},
            {"room": OPTIONAL, "near": OPTIONAL},
        ),
        "steady.sensitivities": (
            steady.sensitivities, {"motion": steady.self_excited_motion(MACHINE, modes=0)}, {},
        ),
        **{
            f"steady.{type(cycle).__name__}.position": (
                cycle.position, {"times": 1.0, "place": 0.5}, {"times": ANY_NUMBERS},
            )
            for cycle in (steady.self_excited_motion(MACHINE, modes=n).cycle for n in (0, 1))
        },
        "steady.Rhythm": (
            steady.Rhythm,
            {"blow_times": (3.1,), "passages": ((1.4, 0),), "state": "power", "orders": VALVE.orders},
            {"passages": {"empty"}, "state": TEXT},
        ),
        "steady.Rhythm.of_events": (
            steady.Rhythm.of_events,
            {"valve": VALVE, "events": [(1.0, "impact", 1.0), (3.0, "impact", 1.0)], "blows": 1}, {},
        ),
        "steady.blank_blow": (
            steady.blank_blow,
            {"motion": steady.self_excited_motion(MACHINE, modes=0), "cushion": Cushion(force=10.0)},
            {"cushion": OPTIONAL},
        ),
        "steady.slow_pressure": (steady.slow_pressure, {"cycle": FED_CYCLE}, {}),
        "steady.pressure_over": (
            steady.pressure_over, {"cycle": FED_CYCLE, "times": [0.1, 0.2]}, {"times": ANY_NUMBERS},
        ),
        "steady.valve_margins": (
            steady.valve_margins, {"motion": steady.self_excited_motion(MACHINE, modes=0)}, {},
        ),
        "steady.orbits": (
            steady.orbits,
            {"system": SYSTEM, "impacts": 2, "periods": 1, "modes": 0, "tries": 4, "seed": 1, "near": None,
             "halt": None},
            {"near": OPTIONAL | {"dict"}, "halt": OPTIONAL | {"class"}},
        ),
        "steady.orbit_near": (
            steady.orbit_near, {"system": SYSTEM, "times": [0.8], "periods": 1, "modes": 0}, {"times": REAL},
        ),
        "steady.rest_cycles": (steady.rest_cycles, {"system": SYSTEM, "modes": 0, "most": 2}, {}),
        "steady.FoundRestCycles.labelled": (
            steady.rest_cycles(SYSTEM, modes=0, most=2).labelled, {"label": "chatter/1"}, {"label": TEXT},
        ),
        "steady.parameter_column": (
            steady.parameter_column, {"orbit": several, "family": SYSTEM.with_load_factor, "value": 0.9},
            {"value": REAL},
        ),
        "steady.time_rates": (
            steady.time_rates, {"orbit": several, "family": SYSTEM.with_load_factor, "value": 0.9}, {"value": REAL},
        ),
        "steady.PeriodicOrbit.off": (several.off, {"system": SYSTEM}, {}),
        "steady.PeriodicOrbit.bordered": (several.bordered, {"xi": 1.0} | side, {"xi": REAL | {"complex"}}),
        "steady.PeriodicOrbit.end_point": (several.end_point, {"t": 1.0}, {"t": ANY_NUMBERS}),
        "steady.PeriodicOrbit.linearised": (several.linearised, {"xi": 1.0} | side, {"xi": REAL | {"complex"}}),
        "steady.PeriodicOrbit.modal_determinants": (
            several.modal_determinants, {"xi": 1.0}, {"xi": REAL | {"complex"}},
        ),
        "steady.ForceRecord": (
            steady.ForceRecord,
            {"time": [0.0, 1.0], "force": [1.0, 2.0], "blows": None},
            {"blows": OPTIONAL | {"empty"}},
        ),
        "steady.recorded_valve": (
            steady.recorded_valve,
            {"system": SYSTEM.with_load(Load.square(1.0, 1.3)), "blow": None, "record": None, "longest_delay": None},
            {"blow": OPTIONAL | REAL, "record": OPTIONAL, "longest_delay": OPTIONAL},
        ),
        "steady.rest_on_wall": (steady.rest_on_wall, {"system": SYSTEM}, {}),
        "steady.si_report": (steady.si_report, {"orbit": steady_states(SI_SYSTEM).orbits[1]}, {}),
        "steady.drag_of": (steady.drag_of, {"orbit": orbit}, {}),
        "steady.greatest_drag": (steady.greatest_drag, {"system": SYSTEM, "periods": 1}, {}),
        "steady.grows": (
            steady.grows, {"system": SYSTEM, "phases": [1.0], "periods": 1, "modes": 2, "restitution": 1.0},
            {"phases": ANY_NUMBERS | {"nan"}, "modes": OPTIONAL, "restitution": OPTIONAL},
        ),
        "steady.level": (
            steady.level, {"mean": 1.0, "d": 0.1, "restitution": 0.5, "period": 6.0},
            {"mean": ANY_NUMBERS, "restitution": PLACES},
        ),
        # -- stability --
        "stability.stability_of": (stability.stability_of, {"orbit": orbit, "modes": 4}, {"modes": OPTIONAL}),
        "stability.timed_stability": (stability.timed_stability, {"orbit": slow.orbits[1]}, {}),
        "stability.linear_map": (stability.linear_map, {"orbit": orbit, "modes": 4} | side, {}),
        "stability.floquet_multipliers": (stability.floquet_multipliers, {"orbit": orbit, "modes": 4} | side, {}),
        "stability.characteristic": (
            stability.characteristic, {"orbit": several, "xi": 1.0} | side, {"xi": REAL | {"complex"}},
        ),
        "stability.orbit_map": (stability.orbit_map, {"orbit": several} | side, {}),
        "stability.orbit_multipliers": (stability.orbit_multipliers, {"orbit": several} | side, {}),
        "stability.reduced_criterion": (stability.reduced_criterion, {"orbit": orbit}, {}),
        "stability.waveform_criterion": (stability.waveform_criterion, {"orbit": orbit}, {}),
        "stability.stability_plane": (
            stability.stability_plane, {"system": SYSTEM, "restitution": 0.5, "load_factor": 0.9, "periods": 1}, plane,
        ),
        "stability.exact_plane": (
            stability.exact_plane,
            {"system": SYSTEM, "restitution": 0.5, "load_factor": 0.9, "periods": 1, "modes": 2, "plane": None}
            | {"threads": 1},
            plane | {"plane": OPTIONAL, "threads": OPTIONAL},
        ),
        # -- simulate --
        "simulate.Start": (
            Start, {"displacement": (-1.0,), "velocity": (0.0,), "time": 0.0, "gap": -1.0, "source": None}
            | {"profile": None},
            {"displacement": REAL, "velocity": REAL, "time": REAL, "gap": OPTIONAL | REAL, "source": OPTIONAL}
            | {"profile": OPTIONAL},
        ),
        "simulate.Start.at": (Start.rigid().at, {"time": 1.0}, {"time": REAL}),
        "simulate.Start.field": (
            Start.field, {"displacement": -1.0, "velocity": 0.0, "time": 0.0},
            {"displacement": REAL, "velocity": REAL, "time": REAL},
        ),
        "simulate.Start.modal": (
            Start.modal, {"displacement": -1.0, "velocity": 0.0, "time": 0.0},
            {"displacement": REAL, "velocity": REAL | OPTIONAL, "time": REAL},
        ),
        "simulate.Start.orbit": (
            Start.orbit, {"orbit": orbit, "displacement": 0.0, "velocity": 0.0},
            {"displacement": REAL, "velocity": REAL},
        ),
        "simulate.Start.random": (
            Start.random, {"system": SYSTEM, "seed": 0, "distribution": "rigid", "modes": 4}, {"seed": {"400 digits"}},
        ),
        "simulate.Start.rigid": (
            Start.rigid, {"position": -1.0, "velocity": 0.0, "time": 0.0},
            {"position": REAL, "velocity": REAL, "time": REAL},
        ),
        "simulate.Start.state": (Start.rigid().state, {"modes": 2, "system": SYSTEM}, {"system": OPTIONAL}),
        "simulate.Starts": (
            Starts, {"displacement": [[-1.0]], "velocity": [[0.0]], "gap": [-1.0], "time": [0.0]}, {},
        ),
        "simulate.Starts.of": (
            Starts.of, {"starts": [Start.rigid()], "modes": 0, "systems": ()}, {"systems": PLACES},
        ),
        "simulate.Starts.random": (
            Starts.random, {"system": SYSTEM, "size": 2, "seed": 0, "distribution": "rigid", "modes": 4},
            {"seed": {"400 digits"}},
        ),
        "simulate.Starts.rigid": (
            Starts.rigid, {"position": -1.0, "velocity": 0.0, "time": 0.0},
            {"position": REAL, "velocity": REAL, "time": REAL},
        ),
        "simulate.Stop": (
            Stop, {"impacts": 3, "time": 1.0, "periodic": True, "tolerance": 1e-9},
            {"impacts": OPTIONAL, "time": OPTIONAL, "periodic": {"bool"}},
        ),
        "simulate.run": (
            run, {"system": SYSTEM, "start": Start.rigid(), "modes": 0, "stop": SHORT, "progress": None},
            {"start": OPTIONAL, "stop": OPTIONAL, "progress": OPTIONAL | {"class"}},
        ),
        "simulate.MachineStart": (
            simulate.MachineStart, {"bar": Start.rigid(), "state": "power", "orders": VALVE.orders},
            {"state": OPTIONAL | TEXT, "orders": OPTIONAL},
        ),
        "simulate.MachineStarts": (
            simulate.MachineStarts,
            {"bars": Starts.rigid([-0.2, -0.5]), "state": [0, 1], "states": ("return", "power")},
            {},
        ),
        "simulate.run_machine": (
            simulate.run_machine,
            {"machine": MACHINE, "start": Start.rigid(), "modes": 0, "stop": SHORT, "progress": None},
            {"start": OPTIONAL, "stop": OPTIONAL, "progress": OPTIONAL | {"class"}},
        ),
        "simulate.simulate_machines": (
            simulate.simulate_machines,
            {"machines": MACHINE, "starts": Start.rigid(), "modes": 0, "stop": SHORT, "threads": 1, "progress": None},
            {"stop": OPTIONAL, "threads": OPTIONAL, "progress": OPTIONAL | {"class"}},
        ),
        "simulate.simulate_many": (
            simulate.simulate_many,
            {"systems": SYSTEM, "starts": Start.rigid(), "modes": 0, "stop": SHORT, "keep": 1, "discard": 1}
            | {"threads": 1, "work": 10**6, "progress": None},
            {"stop": OPTIONAL, "discard": OPTIONAL, "threads": OPTIONAL, "work": OPTIONAL}
            | {"progress": OPTIONAL | {"class"}},
        ),
        "simulate.Events.of": (motion.events.of, {"kind": "impact"}, {}),
        "simulate.MachineEvents.of": (machine_motion.events.of, {"kind": "impact"}, {}),
        "simulate.MachineTrajectory.bar_velocity": (
            machine_motion.bar_velocity, {"x": 0.5, "t": 0.1} | side, {"x": PLACES} | t,
        ),
        "simulate.MachineTrajectory.before": (machine_motion.before, {"x": 0.5, "t": 0.1}, {}),
        "simulate.MachineTrajectory.centre": (machine_motion.centre, {"t": 0.1}, t),
        "simulate.MachineTrajectory.continued": (
            machine_motion.continued, {"stop": SHORT, "progress": None},
            {"stop": OPTIONAL, "progress": OPTIONAL | {"class"}},
        ),
        "simulate.MachineTrajectory.load": (simulate.MachineTrajectory.load, {"path": machine_saved}, {}),
        "simulate.MachineTrajectory.save": (machine_motion.save, {"path": folder / "other.nc"}, {"path": TEXT}),
        "simulate.MachineTrajectory.ends": (machine_motion.ends, {"t": 0.1} | side, t),
        "simulate.MachineTrajectory.energy": (machine_motion.energy, {"t": 0.1} | side, t),
        "simulate.MachineTrajectory.energy_balance": (
            machine_motion.energy_balance, {"first": 0.1, "last": 1.2}, {"first": OPTIONAL, "last": OPTIONAL},
        ),
        "simulate.MachineTrajectory.force": (machine_motion.force, {"t": 0.1}, t),
        "simulate.MachineTrajectory.gap": (machine_motion.gap, {"t": 0.1}, t),
        "simulate.MachineTrajectory.modal": (machine_motion.modal, {"t": 0.1} | side, t),
        "simulate.MachineTrajectory.position": (machine_motion.position, {"x": 0.5, "t": 0.1}, {"x": PLACES} | t),
        "simulate.MachineTrajectory.state": (machine_motion.state, {"t": 0.1}, t),
        "simulate.Trajectory.bar_velocity": (motion.bar_velocity, {"x": 0.5, "t": 0.1} | side, {"x": PLACES} | t),
        "simulate.Trajectory.contact_force": (motion.contact_force, {"t": 0.1}, t),
        "simulate.Trajectory.continued": (
            motion.continued, {"stop": Stop(impacts=4), "progress": None},
            {"stop": OPTIONAL, "progress": OPTIONAL | {"class"}},
        ),
        "simulate.Trajectory.energy": (motion.energy, {"t": 0.1} | side, t),
        "simulate.Trajectory.energy_balance": (
            motion.energy_balance, {"first": 0.1, "last": 1.2}, {"first": OPTIONAL, "last": OPTIONAL},
        ),
        "simulate.Trajectory.gap": (motion.gap, {"t": 0.1}, t),
        "simulate.Trajectory.load": (simulate.Trajectory.load, {"path": saved}, {}),
        "simulate.Trajectory.modal": (motion.modal, {"t": 0.1} | side, t),
        "simulate.Trajectory.position": (motion.position, {"x": 0.5, "t": 0.1}, {"x": PLACES} | t),
        "simulate.Trajectory.save": (motion.save, {"path": folder / "again.nc"}, {"path": TEXT}),
        "simulate.Trajectory.strain": (motion.strain, {"x": 0.5, "t": 0.1}, {"x": PLACES} | t),
        # -- blow --
        "blow.Rock": (blow.Rock, {"stiffness": 1e8, "unloading_ratio": 0.5, "gap": 0.0}, {}),
        "blow.Wall": (blow.Wall, {"gap": 0.0}, {}),
        "blow.Rod": (
            blow.Rod,
            {"sections": [Section(1.0, 1e-3), Section(1.0, 2e-3)], "end": "rock", "bit_mass": 1.0, "gap": 0.0}
            | {"joint_masses": [(1, 0.1)], "rock": blow.Rock(1e8), "impedance": None},
            {"joint_masses": {"empty"}, "impedance": OPTIONAL},
        ),
        "blow.Rod.of_impedance": (blow.Rod.of_impedance, {"impedance": 1.0, "gap": 0.0}, {}),
        "blow.strike": (
            blow.strike,
            {"striker": bar, "target": blow.Wall(), "velocity": 1.0, "until": 1e-3, "load": [(0.0, 1.0)], "load_at": 0}
            | {"field": None, "most_pieces": 1000},
            {"velocity": REAL, "until": OPTIONAL, "load": {"empty"}, "field": OPTIONAL},
        ),
        "blow.effective_blow": (
            blow.effective_blow,
            {"striker": UniformBar(1.0), "target": blow.Wall(), "velocity": 1.0, "until": None},
            {"until": OPTIONAL},
        ),
        "blow.Release": (machine.Release, {"gap": 1.0, "velocity": 0.5, "time": 0.0}, {"velocity": REAL, "time": REAL}),
        "blow.Limits": (
            machine.Limits, {"periods": 2, "impacts": 3, "settled": False, "tolerance": 1e-6},
            {"settled": {"bool"}},
        ),
        "blow.machine_motion": (
            machine.machine_motion,
            {"system": SYSTEM, "target": blow.Wall(), "release": machine.Release(), "limits": machine.Limits(periods=1)}
            | {"pushed_back": False, "quiet": False, "cells": 16, "estimate": False, "progress": None},
            {"release": OPTIONAL, "limits": OPTIONAL, "progress": OPTIONAL | {"class"}}
            | {"pushed_back": {"bool"}, "quiet": {"bool"}, "estimate": {"bool"}},
        ),
        "blow.Blow.state_at": (struck.state_at, {"time": 0.0}, {}),
        "blow.Blow.waves_at": (struck.waves_at, {"x": 0.1}, {}),
        "blow.Trace.at": (struck.face_force.at, {"time": 0.0}, {"time": ANY_NUMBERS}),
        "blow.Trace.before": (struck.face_force.before, {"time": 0.0}, {"time": ANY_NUMBERS}),
        "blow.Trace.sampled": (struck.face_force.sampled, {"size": 3}, {}),
        # -- explore --
        "explore.Archive.open": (explore.Archive.open, {"path": folder / "kept"}, {}),
        "explore.Axis": (
            explore.Axis, {"name": "s", "values": [1.0], "unit": ""}, {"name": TEXT, "unit": TEXT},
        ),
        "explore.Axis.linear": (
            explore.Axis.linear, {"name": "s", "first": -2.0, "last": 2.0, "number": 3, "unit": ""},
            {"name": TEXT, "unit": TEXT, "first": REAL, "last": REAL},
        ),
        "explore.Axis.logarithmic": (
            explore.Axis.logarithmic, {"name": "s", "first": 1.0, "last": 2.0, "number": 3, "unit": ""},
            {"name": TEXT, "unit": TEXT},
        ),
        "explore.Axis.parsed": (explore.Axis.parsed, {"text": "s=1:2:3"}, {}),
        "explore.Axis.spanned": (explore.Axis.spanned, {"text": "s=1:2"}, {}),
        "explore.Boundaries.of": (edges.of, {"kind": "fold"}, {}),
        "explore.Boundaries.least": (edges.least, {"kind": "fold"}, {}),
        "explore.Boundaries.greatest": (edges.greatest, {"kind": "fold"}, {}),
        "explore.SystemFamily": (explore.SystemFamily, {"base": SYSTEM}, {}),
        "explore.SystemFamily.check": (
            explore.SystemFamily(SYSTEM).check, {"names": {"s": ""}}, {"names": NO_KEYS},
        ),
        "explore.SystemFamily.system": (
            explore.SystemFamily(SYSTEM).system, {"values": {"s": 2.0}}, {"values": NO_KEYS},
        ),
        "explore.MachineFamily": (explore.MachineFamily, {"base": MACHINE, "limit": 9.0}, {"limit": OPTIONAL}),
        "explore.MachineFamily.check": (
            explore.MachineFamily(MACHINE).check, {"names": {"s": ""}}, {"names": NO_KEYS},
        ),
        "explore.MachineFamily.machine": (
            explore.MachineFamily(MACHINE).machine, {"values": {"s": 2.0}}, {"values": NO_KEYS},
        ),
        "explore.MachineFamily.room": (explore.MachineFamily(MACHINE).room, {"machine": MACHINE}, {}),
        "explore.machine_parameters": (explore.machine_parameters, {"machine": MACHINE}, {}),
        "explore.vary_machine": (
            explore.vary_machine, {"machine": MACHINE, "values": {"s": 2.0}}, {"values": NO_KEYS},
        ),
        "explore.vary": (explore.vary, {"system": SYSTEM, "values": {"s": 2.0}}, {"values": NO_KEYS}),
        "explore.basins": (
            explore.basins,
            {"system": SYSTEM, "x": ("time", 0.0, 1.0, 2), "y": ("velocity", -1.0, -0.5, 2), "at": {"position": -1.0}}
            | {"modes": 0, "stop": SHORT, "distance": 1e-4, "threads": 1}
            | RUNNING,
            {"at": OPTIONAL | NO_KEYS, "stop": OPTIONAL, "threads": OPTIONAL} | RUNNING_TAKES,
        ),
        "explore.boundaries": (
            explore.boundaries,
            {"system": SYSTEM, "x": ("restitution", [0.3]), "y": ("load_factor", 0.1, 1.0), "periods": 1}
            | {"criterion": "reduced", "modes": None, "kinds": ("fold",), "samples": 5, "halt": None, "progress": None},
            {"modes": OPTIONAL, "samples": OPTIONAL, "halt": OPTIONAL | {"class"}, "progress": OPTIONAL | {"class"}},
        ),
        "explore.carry_out": (explore.carry_out, {"job": Two()} | RUNNING, RUNNING_TAKES),
        "explore.estimate": (explore.estimate, {"job": Two()}, {}),
        "explore.diagram": (
            explore.diagram,
            {"what": SYSTEM, "axis": "mean=0.85:0.95:2", "up_to": None, "searched": 1, "switch": 0, "tries": 1}
            | {"starts": 1, "runs": 1, "modes": 0, "stop": SHORT, "seed": 0}
            | RUNNING,
            {"up_to": OPTIONAL, "stop": OPTIONAL, "seed": {"400 digits"}} | RUNNING_TAKES,
        ),
        "explore.experiment": (
            explore.experiment,
            {"system": SYSTEM, "starts": 3, "distribution": "wall", "seed": 0, "modes": 0, "stop": SHORT}
            | {"distance": 1e-4, "threads": 1}
            | RUNNING,
            {"starts": OPTIONAL, "seed": {"400 digits"}, "stop": OPTIONAL, "threads": OPTIONAL} | RUNNING_TAKES,
        ),
        "explore.follow": (
            explore.follow,
            {"orbit": one_impact, "along": "mean", "between": (0.88, 0.92), "family": SYSTEM, "value": 0.9, "switch": 0,
             "most": 2, "halt": None},
            {"between": OPTIONAL, "family": OPTIONAL, "value": OPTIONAL, "halt": OPTIONAL | {"class"}},
        ),
        "explore.follow_rest_cycle": (
            explore.follow_rest_cycle,
            {"cycle": resting, "along": "mean", "between": (0.89, 0.91), "family": SYSTEM, "value": 0.9, "points": 2,
             "halt": None},
            {"between": OPTIONAL, "family": OPTIONAL, "value": OPTIONAL, "halt": OPTIONAL | {"class"}},
        ),
        "explore.follow_point": (
            explore.follow_point,
            {"point": fold, "along": ("restitution", "load_factor"), "between": ((0.149, 0.151), (0.4, 0.45)),
             "family": fold.orbit.system, "values": (0.15, fold.value), "most": 2, "halt": None},
            {"between": OPTIONAL, "family": OPTIONAL, "values": OPTIONAL, "halt": OPTIONAL | {"class"}},
        ),
        "explore.reach": (
            explore.reach,
            {"orbit": one_impact, "along": "mean", "between": (0.88, 0.92), "family": SYSTEM, "value": 0.9,
             "halt": None},
            {"between": OPTIONAL, "family": OPTIONAL, "value": OPTIONAL, "halt": OPTIONAL | {"class"}},
        ),
        "explore.lyapunov_exponent": (
            explore.lyapunov_exponent,
            {"system": SYSTEM, "start": Start.rigid(), "modes": 0, "impacts": 20, "discard": 2},
            {"start": OPTIONAL},
        ),
        "explore.switched_seeds": (
            explore.switched_seeds,
            {"system": SYSTEM, "impacts": 3, "periods": 1, "modes": 4, "reach": 0.01, "tries": 1}, {},
        ),
        "explore.orbit_of": (explore.orbit_of, {"motion": motion}, {}),
        "explore.orbit_seeds": (
            explore.orbit_seeds,
            {"system": SYSTEM, "impacts": 2, "periods": 1, "modes": 0, "motions": 2, "seed": 1, "halt": None},
            {"halt": OPTIONAL | {"class"}},
        ),
        "explore.lyapunov_many": (
            explore.lyapunov_many,
            {"systems": SYSTEM, "starts": Start.rigid(), "modes": 0, "impacts": 20, "discard": 2, "threads": 1},
            {"starts": OPTIONAL, "threads": OPTIONAL},
        ),
        "explore.sweep": (
            lambda what, axes, **more: explore.sweep(what, axes, **more),
            {"what": SYSTEM, "axes": axis, "quantities": ["label"], "periods": 1, "modes": 0, "start": Start.rigid()}
            | {"stop": SHORT, "impacts": 20, "discard": 2, "functions": None}
            | RUNNING,
            {"modes": OPTIONAL, "start": OPTIONAL, "stop": OPTIONAL, "functions": OPTIONAL | NO_KEYS}
            | {"quantities": OPTIONAL} | RUNNING_TAKES,
        ),
        # -- case --
        "case.Case.changed": (
            case.changed, {"start": None, "simulation": {"impacts": 2}},
            {"start": OPTIONAL | NO_KEYS, "simulation": OPTIONAL | NO_KEYS},
        ),
        "case.Case.from_text": (
            Case.from_text, {"text": PLAIN, "file": "x.toml", "folder": folder}, {"file": TEXT, "folder": TEXT},
        ),
        "case.Case.read": (Case.read, {"path": _written(folder / "plain.toml")}, {}),
        "case.Case.start": (case.start, {"modes": 0}, {"modes": OPTIONAL}),
        "case.Case.varied": (case.varied, {"values": {"system.s": 10.0}}, {"values": NO_KEYS}),
        "case.Case.with_load": (case.with_load, {"load": load}, {}),
        "case.CaseFamily": (room_of_cases.CaseFamily, {"case": case, "units": {}}, {"units": NO_KEYS}),
        "case.CaseFamily.check": (family.check, {"names": {"s": ""}}, {"names": NO_KEYS}),
        "case.CaseFamily.key": (family.key, {"name": "s"}, {}),
        "case.CaseFamily.machine": (machines.machine, {"values": {"s": 2.0}}, {"values": NO_KEYS}),
        "case.CaseFamily.room": (machines.room, {"machine": MACHINE}, {}),
        "case.CaseFamily.start": (family.start, {"values": {"s": 2.0}, "modes": 0}, {"values": NO_KEYS}),
        "case.CaseFamily.system": (family.system, {"values": {"s": 2.0}}, {"values": NO_KEYS}),
        "case.SimulationAnswer.to_json_dict": (
            simulated.to_json_dict, {"last": 1}, {"last": OPTIONAL | {"400 digits"}},
        ),
        "case.SimulationAnswer.to_json_text": (
            simulated.to_json_text, {"last": 1}, {"last": OPTIONAL | {"400 digits"}},
        ),
        "case.load_case": (room_of_cases.load_case, {"name": "pile-hammer"}, {}),
        "case.basins_job_of": (
            room_of_cases.basins_job_of,
            {"case": case, "x": explore.Axis.linear("time", 0, 1, 2), "y": explore.Axis.linear("velocity", -2, -1, 2)}
            | {"at": {"position": -1.0}, "modes": 0, "impacts": 2},
            {"at": OPTIONAL | NO_KEYS} | sums,
        ),
        "case.experiment_job_of": (
            room_of_cases.experiment_job_of,
            {"case": case, "starts": 2, "distribution": "wall", "seed": 0, "modes": 0, "impacts": 2},
            {"starts": OPTIONAL, "distribution": OPTIONAL, "seed": {"400 digits"}} | sums,
        ),
        "case.sweep_job_of": (
            room_of_cases.sweep_job_of,
            {"case": case, "axes": [axis], "quantities": ["orbits"], "periods": 1, "modes": 0, "impacts": 2},
            sums | {"quantities": OPTIONAL},
        ),
        "case.resumed_answer": (
            room_of_cases.resumed_answer, {"path": saved, "impacts": 4, "time": 60.0, "progress": None},
            {"impacts": OPTIONAL, "time": OPTIONAL, "progress": OPTIONAL | {"class"}},
        ),
        "case.blow_answer": (
            room_of_cases.blow_answer,
            {"case": hammer, "velocity": 9.0, "until": None, "gauge": 0.1, "whole_field": False, "most_pieces": None},
            {"velocity": OPTIONAL, "until": OPTIONAL, "gauge": OPTIONAL, "most_pieces": OPTIONAL},
        ),
        "case.orbits_answer": (
            room_of_cases.orbits_answer,
            {"case": case, "label": "1/1", "modes": 0, "tries": 2, "seed": 0, "motions": 2, "switch": False}
            | {"halt": None},
            {"modes": OPTIONAL, "switch": {"bool"}, "halt": OPTIONAL | {"class"}},
        ),
        "case.rest_cycles_answer": (
            room_of_cases.rest_cycles_answer, {"case": case, "modes": 0, "most": 2}, {"modes": OPTIONAL},
        ),
        "case.branch_answer": (
            room_of_cases.branch_answer,
            {"case": case, "orbit": "1/1:1", "along": "mean=0.89:0.91", "switch": 0, "modes": 0, "halt": None},
            {"modes": OPTIONAL, "halt": OPTIONAL | {"class"}},
        ),
        "case.rest_branch_answer": (
            room_of_cases.rest_branch_answer,
            {"case": case, "orbit": "chatter/1", "along": "mean=0.899:0.901", "modes": 0, "halt": None},
            {"modes": OPTIONAL, "halt": OPTIONAL | {"class"}},
        ),
        "case.point_curves_answer": (
            room_of_cases.point_curves_answer,
            {"case": jackleg, "branch": to_fold, "which": "fold", "along": "load_factor=0.39:0.45",
             "over": "restitution=0.149:0.151", "halt": None},
            {"halt": OPTIONAL | {"class"}},
        ),
        "case.diagram_answer": (
            room_of_cases.diagram_answer,
            {"case": case, "along": "mean=0.85:0.95:2", "up_to": None, "searched": 1, "switch": 0, "tries": 1}
            | {"starts": 1, "runs": 1, "modes": 0, "impacts": 3, "seed": 0}
            | RUNNING,
            {"up_to": OPTIONAL, "modes": OPTIONAL, "impacts": OPTIONAL, "seed": {"400 digits"}} | RUNNING_TAKES,
        ),
        "case.diagram_job_of": (
            room_of_cases.diagram_job_of,
            {"case": case, "along": "mean=0.85:0.95:2", "up_to": None, "searched": 1, "switch": 0, "tries": 1}
            | {"starts": 1, "runs": 1, "modes": 0, "impacts": 3, "seed": 0},
            {"up_to": OPTIONAL, "modes": OPTIONAL, "impacts": OPTIONAL, "seed": {"400 digits"}},
        ),
        "case.reach_answer": (
            room_of_cases.reach_answer,
            {"case": case, "orbit": states.orbits[1], "names": ["mean"], "modes": 0, "halt": None},
            {"names": OPTIONAL | PLACES, "modes": OPTIONAL, "halt": OPTIONAL | {"class"}},
        ),
        "case.measured_gauge": (
            room_of_cases.measured_gauge,
            {"answer": one_blow, "path": seen, "column": None, "unit": None, "sample_rate": None, "sign": "auto"},
            {"column": OPTIONAL, "unit": OPTIONAL | {"number in quotes"}, "sample_rate": OPTIONAL},
        ),
        "case.Span": (room_of_cases.Span, RANGE, {"name": TEXT, "low": REAL, "unit": TEXT}),
        "case.Span.parsed": (room_of_cases.Span.parsed, {"words": "bar.length=100:300mm"}, {}),
        "case.CaseFamily.varied": (by_key.varied, {"values": {"bar.length": 200.0}}, {"values": NO_KEYS}),
        "case.CaseFamily.blow": (by_key.blow, {"values": {"bar.length": 200.0}}, {"values": NO_KEYS}),
        "case.best_answer": (
            room_of_cases.best_answer,
            {"case": hammer, "spans": [room_of_cases.Span(**RANGE)], "objective": "efficiency", "below": None}
            | {"seed": 0, "most": 20, "progress": None},
            {"below": OPTIONAL, "progress": OPTIONAL | {"class"}},
        ),
        "case.MachineMotion.to_json_dict": (
            machine_moved.to_json_dict, {"last": 1}, {"last": OPTIONAL | {"400 digits"}},
        ),
        "case.MachineMotion.to_json_text": (
            machine_moved.to_json_text, {"last": 1}, {"last": OPTIONAL | {"400 digits"}},
        ),
        "case.machine_motion": (
            room_of_cases.machine_motion, {"case": drilling, "progress": None}, {"progress": OPTIONAL | {"class"}},
        ),
        "case.recorded_answer": (
            room_of_cases.recorded_answer,
            {"case": SQUARE, "modes": 0, "blow": None, "blows": None, "longest_delay": None},
            {"modes": OPTIONAL, "blow": OPTIONAL | REAL, "blows": set(WRONG), "longest_delay": OPTIONAL},
        ),
        "case.machine_answer": (
            room_of_cases.machine_answer, {"case": drilling, "modes": 0},
            {"modes": OPTIONAL},
        ),
        "case.simulation_answer": (
            room_of_cases.simulation_answer, {"case": case, "progress": None}, {"progress": OPTIONAL | {"class"}},
        ),
        "case.WavesAnswer.to_json_dict": (by_waves.to_json_dict, {"last": 1}, {"last": OPTIONAL | {"400 digits"}}),
        "case.WavesAnswer.to_json_text": (by_waves.to_json_text, {"last": 1}, {"last": OPTIONAL | {"400 digits"}}),
        "case.waves_answer": (
            room_of_cases.waves_answer, {"case": case, "progress": None, "quiet": True, "cells": 16},
            {"progress": OPTIONAL | {"class"}, "quiet": {"bool"}},
        ),
        "case.structure_answer": (
            room_of_cases.structure_answer, {"case": structure, "periods": [1], "modes": 4},
            {"periods": PLACES, "modes": OPTIONAL},
        ),
        "case.steady_answer": (
            room_of_cases.steady_answer, {"case": case, "periods": [1], "modes": 4, "starts": 0},
            {"periods": PLACES, "modes": OPTIONAL},
        ),
        # -- units --
        "units.known_dimension": (
            units.known_dimension, {"unit": "mm", "dimensions": units.DIMENSIONS}, {"unit": TEXT},
        ),
        "units.si": (units.si, {"value": "1 mm", "dimension": "length", "name": "length"}, {"name": TEXT}),
        "units.split_header": (units.split_header, {"text": "p [bar]"}, {"text": TEXT}),
        "units.unit_scale": (
            units.unit_scale, {"unit": "bar", "dimensions": ("pressure",), "name": "unit"}, {"name": TEXT},
        ),
        # -- plot --
        "plot.basins": (plot.basins, {"found": basin, "title": ""}, {"title": TEXT}),
        "plot.branch": (plot.branch, {"found": followed, "title": ""}, {"title": TEXT}),
        "plot.curves": (plot.curves, {"found": [curve], "title": ""}, {"title": TEXT}),
        "plot.diagram": (
            plot.diagram, {"found": shown, "title": "", "quantities": ("phase",)}, {"title": TEXT},
        ),
        "plot.experiment": (plot.experiment, {"found": ends, "title": ""}, {"title": TEXT}),
        "plot.rest_branch": (plot.rest_branch, {"found": rests, "title": ""}, {"title": TEXT}),
        "plot.save": (
            plot.save, {"figure": _empty_figure(), "path": folder / "picture.svg"}, {},
        ),
        "plot.best": (plot.best, {"answer": searched}, {}),
        "plot.blow": (plot.blow, {"answer": one_blow}, {}),
        "plot.machine": (plot.machine, {"answer": machined}, {}),
        "plot.machine_motion": (plot.machine_motion, {"motion": machine_motion}, {}),
        "plot.steady": (plot.steady, {"answer": answer}, {}),
        "plot.sweep": (plot.sweep, {"found": swept, "title": "", "curves": ()}, {"title": TEXT, "curves": PLACES}),
        "plot.trajectory": (plot.trajectory, {"motion": motion}, {}),
    }  # fmt: skip


def _written(path: Path) -> Path:
    path.write_text(PLAIN, encoding="utf-8")
    return path


def _empty_figure() -> Any:
    from matplotlib.figure import Figure

    return Figure(figsize=(1.0, 1.0))


def public() -> Iterator[tuple[str, Callable[..., object]]]:
    """Every public callable, and the public methods of every public class, by room and name; each once."""
    seen = set()
    for module in (percuss, *(importlib.import_module(f"percuss.{room}") for room in ROOMS)):
        for name in module.__all__:
            found = getattr(module, name)
            if not callable(found) or not str(found.__module__).startswith("percuss."):
                continue
            key = f"{found.__module__.split('.')[1]}.{found.__qualname__}"
            if key in seen:
                continue
            seen.add(key)
            yield key, found
            for method in vars(found) if inspect.isclass(found) else ():
                thing = getattr(found, method)
                if not method.startswith("_") and callable(thing) and not isinstance(thing, type):
                    yield f"{key}.{method}", thing
            for base in found.__mro__[1:-1] if inspect.isclass(found) else ():
                for method in vars(base) if base.__module__.startswith("percuss.") else ():
                    thing = getattr(found, method)
                    if not method.startswith("_") and inspect.isfunction(thing) and f"{key}.{method}" not in seen:
                        seen.add(f"{key}.{method}")
                        yield f"{key}.{method}", thing


BY_THE_MECHANICS = {
    f"model.{kind}": ("place", "with_restitution", "body", "natural_frequencies")
    for kind in ("Body", "Damping", "Contact", "SizedBody", "Modes")
}
"""Contracts whose methods the mechanics ask, with arrays and counts that other floors have checked, and their doors."""


def asked_by_the_mechanics(name: str) -> bool:
    """Whether it is a method of a body or a law that takes what others have checked."""
    room, _, method = name.partition(".")
    kind, _, method = method.partition(".")
    found = getattr(importlib.import_module("percuss.model"), kind, None) if room == "model" else None
    contracts = [BY_THE_MECHANICS.get(f"model.{base.__name__}") for base in getattr(found, "__mro__", ())]
    doors = [own for own in contracts if own is not None]
    return bool(method and doors) and (method not in doors[0] or f"model.{kind}" in BY_THE_MECHANICS)


def parameters(function: Callable[..., object]) -> set[str]:
    """The names that a caller can give; not what is passed on."""
    try:
        told = inspect.signature(function).parameters
    except (TypeError, ValueError):
        return set()
    unnamed = {"self", "given"}  # the latter are those of `System`, which have names too
    return {name for name, about in told.items() if name not in unnamed and about.kind is not about.VAR_KEYWORD}


DOORS = {
    name: function
    for name, function in public()
    if parameters(function) and name not in NO_DOORS and not asked_by_the_mechanics(name)
}


@pytest.fixture(scope="module")
def calls(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Entry]:
    return table(tmp_path_factory.mktemp("doors"))


def test_every_public_callable_is_in_the_table(calls: dict[str, Entry]) -> None:
    """What is public has a valid call with all of its parameters; no entry and no exception is left over."""
    assert sorted(calls) == sorted(DOORS)
    every = {name for name, _ in public()}
    assert set(NO_DOORS) <= every
    for name, (_, given, takes) in calls.items():
        extra = set(given) - parameters(DOORS[name])
        assert parameters(DOORS[name]) <= set(given), name
        assert not extra or extra == set(RUNNING), name
        assert set(takes) <= set(given) and set().union(*takes.values()) <= set(WRONG), name


@pytest.mark.parametrize("name", DOORS)
def test_wrong_objects_give_errors_of_the_package(
    name: str, calls: dict[str, Entry], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    function, given, takes = calls[name]
    function(**given)
    told = []
    for parameter in given:
        for wrong, value in WRONG.items():
            meant = wrong in takes.get(parameter, ())
            try:
                function(**{**given, parameter: value})
            except PercussError as error:
                if meant and wrong != "class":
                    told.append(f"{parameter}={wrong}: refused: {error}")
                elif len(str(error)) > 600:
                    told.append(f"{parameter}={wrong}: told at length: {len(str(error))}")
            except Exception as error:
                told.append(f"{parameter}={wrong}: {type(error).__name__}: {str(error)[:100]}")
            else:
                if not meant:
                    told.append(f"{parameter}={wrong}: taken without a word")
    assert not told, "\n".join(told)


def test_numbers_of_any_kind_are_taken() -> None:
    """Whole numbers, numpy's and Python's, exact fractions, and whole numbers beyond 64 bits."""
    from fractions import Fraction

    for one in (1, np.float32(1.0), np.int8(1), Fraction(1), 1.0):
        assert Load.fourier([one, one]) == Load.fourier([1.0, 1.0])
        assert Load.steps([0, one], [2 * one, one]) == Load.steps([0.0, 1.0], [2.0, 1.0])
        assert float(SYSTEM.load.value(one)) == float(SYSTEM.load.value(1.0))
    assert Load.fourier([10**30, 1j]).mean == 1e30
    assert Load.fourier([[0.3, 0.0], [1.0, 0.5]]).coefficients.tolist() == [0.3, 1.0 + 0.5j]


def test_what_is_none_of_them_is_told_before_anything_is_computed(tmp_path: Path) -> None:
    """A watcher that cannot be called is no reason to compute first; nor is a path that is a number a file."""
    calls: list[int] = []

    class Counting(Two):
        def compute(self, first: int, last: int, stopped: Callable[[], bool]) -> dict[str, Any]:
            calls.append(first)
            return super().compute(first, last, stopped)

    for wrong in ({"progress": "x"}, {"archive": 5}, {"pool": 5}, {"resume": "yes"}, {"chunk": 0.5}):
        with pytest.raises(ParameterError, match=next(iter(wrong))):
            explore.carry_out(Counting(), workers=1, **wrong)
    assert not calls
    with pytest.raises(ParameterError, match="path"):
        run(SYSTEM, modes=0, stop=SHORT).save(1)  # type: ignore[arg-type]  # the number of an open file


def test_a_start_leaves_the_arrays_of_its_maker_alone() -> None:
    mine = np.array([-1.0])
    starts = Starts(mine[:, None], mine[:, None], mine, mine)
    mine[0] = -2.0
    assert starts.gap[0] == -1.0
    assert not len(Starts(np.empty((0, 1)), np.empty((0, 1)), np.empty(0), np.empty(0)))  # of an archive just begun
