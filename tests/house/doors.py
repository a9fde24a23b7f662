"""Valid arguments for every public callable: by the name of a parameter, by the type it is annotated with, or its own.

A new public callable needs nothing here when its parameters have the names and types of others.
"""

from __future__ import annotations

import dataclasses
import functools
import importlib
import inspect
import re
from collections.abc import Callable, Iterator
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

import percuss
from percuss import Bar, Case, Kept, Load, Reversed, Start, Starts, Stop, System, blow, explore, run, steady
from percuss import case as cases
from percuss.model import (
    Chamber,
    Cushion,
    External,
    GasAccumulator,
    Machine,
    ModalBody,
    Mounted,
    Oil,
    OilChamber,
    Port,
    Relief,
    Section,
    SectionedBar,
    SizedModes,
    SteppedBar,
    Supply,
    Timed,
    UniformBar,
    Valve,
)  # fmt: skip
from percuss.recordings import BlowRecord

ROOMS = (
    "recordings", "model", "steady", "stability", "simulate", "blow", "blow.periods", "explore", "case", "plot",
    "units",
)  # fmt: skip


class Anything:
    """A class that takes anything, where a number or an object is meant."""

    def __init__(self, *_: object) -> None: ...


CONSTRUCTED = {"model.Bar", "model.Kept", "model.Reversed", "model.System", "steady.ForceRecord"}
"""Classes that check their parts elsewhere than at construction, and are made by users all the same."""

WRONG: dict[str, Any] = {
    "None": None, "text": "x", "nan": float("nan"), "inf": float("inf"), "-1": -1, "400 digits": 10**400, "empty": [],
    "object": object(), "complex": 1j, "bool": True, "bytes": b"x", "class": Anything, "number in quotes": "1",
    "texts": [1.0, "1"], "nones": [None], "400 digits in a list": [0.5, 10**400], "bools": [True, False], "dict": {},
    "other keys": {1: 2},
}  # fmt: skip

NO_DOORS = {
    "a word, made from its sentence": "blow.BlowOutcome explore.BranchEvent steady.Obstacle steady.Reason",
    "its tables are pydantic's; the doors are Case.read and Case.from_text": "case.Case",
    "what comes out": "errors.PercussError case.CaseErrors",
    "a protocol, or a contract whose doors are its kinds": "explore.Family explore.Job model.Body model.SizedBody "
    "model.Damping model.Contact explore.Family.check explore.Family.system explore.Job.compute",
    "refuses whatever it is given: a system is no machine that switches itself": "explore.SystemFamily.machine",
    "asked of a motion of a machine alone": "simulate.Trajectory.force simulate.Trajectory.pressure "
    "simulate.Trajectory.state",
    "takes the blow as a function of the rod: tests/blow/test_held_tool.py": "blow.blows_one_by_one",
    "takes readings of records in SI alone: tests/steady/test_recorded_valve.py": "steady.recorded_together",
    "takes arrays and counts that other floors have checked, millions of times": "steady.Orbit.end_motion "
    "steady.Orbit.forced_elastic steady.Orbit.rigid_motion steady.TimedOrbit.rigid_motion steady.Orbit.transient "
    "steady.Orbit.modal_state steady.PeriodicOrbit.modal_state",
    "between the parts of a job that is carried out: its doors are carry_out and Archive.open": "explore.Archive "
    "explore.Archive.bounds explore.Archive.create explore.Archive.keep explore.Archive.resume explore.Archive.write "
    "explore.Basins.from_archive explore.Diagram.from_archive explore.Diagram.of "
    "explore.Experiment.from_archive explore.Experiment.of_done explore.Shares.from_archive explore.Shares.of "
    "explore.Sweep.from_archive explore.Sweep.shaped",
    "the same as explore.follow": "steady.Orbit.follow steady.PeriodicOrbit.follow steady.RestCycle.follow "
    "steady.ValveCycle.follow steady.TimedOrbit.follow",
    "what a file holds: the doors are save and load": "explore.Branch.from_json "
    "explore.BranchPoint.from_json explore.Boundaries.from_json explore.Diagram.from_json explore.Shares.from_json "
    "explore.Branch.recording explore.PointCurve.recording explore.PointCurve.releases_at "
    "explore.PointCurve.save",
    "asked by the package, of a result or a part of one": "model.Section.piece model.Oil.areas model.Oil.losses "
    "model.Oil.drag model.Oil.joined model.Oil.scaled model.Oil.at_pressure model.Supply.capacity "
    "model.GasAccumulator.compliance steady.RecordedSwitch.port "
    "steady.ValveCycle.position blow.Impacts.part blow.Trace.around blow.Trace.degrees_at "
    "blow.Steel.damage blow.Steel.equivalent "
    "blow.Trace.product_integral blow.Trace.scaled explore.Branch.at explore.PointCurve.at "
    "explore.Branch.times_at explore.PointCurve.times_at explore.Branch.speeds_at explore.PointCurve.speeds_at "
    "steady.Orbit.mean_range "
    "explore.Branch.releases_at "
    "steady.ModalState.first steady.PeriodicOrbit.outside steady.LinearMap.dense steady.LinearMap.participation "
    "steady.LinearMap.secular steady.LinearMap.shares steady.CycleMap.dense steady.CycleMap.participation "
    "steady.CycleMap.shares",
}
LEFT_OUT = {name for names in NO_DOORS.values() for name in names.split()}

# -- what is no error: a wrong object that has a meaning in this place -------------------------------------------------

MEANT = (
    ("empty", "blow.Blow.*_over_time.times steady.CycleTimes.lying steady.CycleTimes.pressures"),
    ("empty", "blow.Blow.force_turns.shares"),
    ("None", "blow.Steel.fatigue_limit blow.Steel.slope"),
    (
        "nothing",
        """
        case.CaseFamily.key.name case.load_case.name units.unit_scale.unit recordings.read_recording.unit
        blow.Blow.*.* explore.basins.x explore.boundaries.x case.basins_job_of.x
        model.System.stress.x blow.effective_blow.velocity case.blow_answer.velocity
        case.repeated_answer.velocity blow.bit_contacts.blow
        blow.joint_turns.blow blow.strike_again.blow simulate.Starts.displacement
        simulate.Starts.velocity simulate.Starts.time simulate.Stop.time model.Load.history.time
        steady.ForceRecord.time case.resumed_answer.time model.Valve.scaled.time steady.orbits.seed
        explore.orbit_seeds.seed model.Valve.states case.blow_answer.whole_field simulate.Trajectory.start_at.t
        simulate.Trajectory.section.displacement simulate.Trajectory.section.velocity
        case.orbits_answer.seed case.best_answer.seed case.design.seed case.tolerance*.seed blow.fatigue.blow
        """,
    ),
    (
        "-1",
        """
        model.Load.coefficients model.Load.harmonic.amplitude explore.Axis.linear.first explore.Axis.linear.last
        model.Timed.velocity.force model.Timed.impulse.force model.Chamber.force model.Mounted.gap model.*Mod*.gap
        model.ModalBody.contact model.SizedModes.contact steady.parameter_column.value steady.time_rates.value
        model.*.mean model.System.*.load_factor steady.orbit_near.times recordings.read_recording.start
        simulate.Start.gap *.drive *.displacement *.velocity *.position *.blow *.factor *.impulse *.low *.phi
        """,
    ),
    (
        "empty",
        """
        simulate.*Trajectory.*.t model.Load.breaks model.Load.values steady.ForceRecord.blows blow.strike.load
        case.reach_answer.names case.steady_answer.periods steady.level.restitution
        stability.*_plane.restitution simulate.Starts.of.systems *.x *.curves *.joint_masses *.passages
        case.tolerance*.tolerances case.tolerance*.figures blow.Rod.joints blow.Rod.attenuation
        """,
    ),
    ("-1, empty, nan", "steady.grows.phases"),
    ("None, empty, dict", "simulate.Starts.states"),
    ("empty", "case.compare.names case.design.limits"),
    (", ".join(set(WRONG) - {"None"}), "case.recorded_answer.blows"),  # of a machine without a record
    ("-1", "simulate.Trajectory.section.phase"),
    ("-1, empty", "blow.Trace.*.time model.Load.on_steps.error *.t *.phase *.times *.mean *.load_factor"),
    ("-1", "*.time"),
    (
        "text, number in quotes",
        """
        simulate.*.save.path units.split_header.text model.Port.to steady.CycleTimes.state
        simulate.Start.with_valve.state simulate.Start.valve_state
        steady.FoundRestCycles.labelled.label *.title *.name *.file *.folder *.archive
        """,
    ),
    ("number in quotes", "recordings.read_recording.time_column case.measured_gauge.unit"),
    ("text, number in quotes", "*.unit"),
    ("400 digits", "case.*.to_json_*.last *.seed"),
    ("-1, complex", "*.xi"),
    ("inf", "model.Mounted.s"),
    ("class", "*.progress"),
    ("-1", "model.Oil.force blow.Drilling.advance.*"),
    ("empty, dict", "model.Oil.joins"),
    ("empty", "model.Oil.chambers"),
    ("None", "model.Relief.slope"),
    ("text, number in quotes", "model.OilChamber.name model.Join.chamber"),
)
"""Wrong objects, and the parameters that take them: the first line that names one; None, True and {} by their types."""

NOT_NONE = {
    "recordings.read_recording.column", "model.Bar.area", "model.Section.area", "model.Kept.receiving_area",
    "model.Kept.area", "model.Reversed.receiving_area", "model.Reversed.area", "model.Port.behind", "model.Port.side",
    "model.System.load", "model.System.bar", "model.System.frequency", "model.System.body", "model.System.contact",
    "blow.Drilling.crater_factor", "blow.Rod.rock", "simulate.Trajectory.section.phase",
}  # fmt: skip
"""What can be left out only when something else is given, which is not in the call here."""

NAMED_ELSE = {
    "gap": "position", "start": "from", "end": "to", "number": "at", "count": "modes", "path": "file",
    "starts": "start", "value": "s", "displacement": "modal_displacement", "velocity": "modal_velocity",
}  # fmt: skip
"""What an error calls a parameter when not by its own name."""

# -- the objects -------------------------------------------------------------------------------------------------------

SYSTEM = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))
SI_LOAD = Load.harmonic(900.0, 1000.0, frequency=50.0)
SHORT = Stop(impacts=3)
VALVE = Valve(
    {"return": -0.4, "power": 1.8}, (Port("power", behind=1.0, side="back"), Port("return", on="impact", delay=0.01))
)
OIL = Oil([OilChamber("rear", 2.2, "rear"), OilChamber("front", 0.4, "front")], {})
MACHINE = Machine(UniformBar(20.0), VALVE, Kept(0.2))
BLOWS = BlowRecord(np.arange(40) / 61.2 + 1e-5 * (np.arange(40) % 3))
MODES: dict[str, Any] = {"omega": (1.5,), "delta": (0.1,), "contact": (1.0,), "drive": (1.0,)}
RUNNING: dict[str, Any] = {
    "archive": None, "resume": False, "workers": 1, "pool": None, "chunk": 1, "progress": None,
}  # fmt: skip
HELD = """[body]
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
PLAIN = """[system]
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
SQUARE = '[system]\ns = 50.0\nd = 0.0\nrestitution = 0.2\n[load]\nkind = "square"\namplitude = 1.0\nkappa = 1.2\n'


class Two:
    """A job of two items."""

    size = 2
    columns: ClassVar = {"square": explore.Column()}
    ask: ClassVar = {"kind": "squares"}

    def compute(self, first: int, last: int, stopped: Callable[[], bool]) -> dict[str, Any]:
        return {"square": np.arange(first, last) ** 2.0}


CHEAP: dict[str, Any] = {
    "modes": 0, "impacts": 2, "tries": 1, "starts": 1, "runs": 1, "motions": 2, "most": 2, "points": 2, "stop": SHORT,
    "up_to": None, "switch": 0, "searched": 1, "cells": 16, "discard": 1, "samples": 5, "harmonics": 8,
    "most_pieces": 1000, "work": 10**6, "keep": 1, "start": Start.rigid(), "between": (0.89, 0.91), **RUNNING,
}  # fmt: skip
"""Of parameters with or without a default, so that a call takes milliseconds."""

NAMED: dict[str, Any] = {
    "along": "mean", "amplitude": 1.0, "angular_frequency": 2.0, "area": 1e-3, "at": {"position": -1.0},
    "axes": "s=2:3:2", "axis": "mean=0.85:0.95:2", "behind": 1.0, "blow_times": (3.1,), "blows": 1,
    "breaks": [0.0, 1.0], "coefficients": [0.3, 1.0], "compliance": 9.0, "contact": Kept(0.2), "count": 2, "d": 0.1,
    "depth": 0.1, "dimension": "length", "displacement": -1.0, "energy": 2.0, "error": 0.1, "eta": 0.1,
    "events": [(1.0, "impact", 1.0), (3.0, "impact", 1.0)], "factor": 2.0, "family": SYSTEM.with_load_factor,
    "flight": 0, "first": 1.0, "flow": 0.7, "force": 2.0, "frequency": 1.0, "function": np.cos, "gap": 0.0,
    "gauge": 0.1, "high": 300.0, "impedance": 1.0, "impulse": 1.0, "kappa": 1.3, "last": 2.0, "length": 1.0,
    "load_factor": 0.9, "low": 100.0, "mean": 0.9, "name": "s", "names": {"s": ""}, "number": 0,
    "objective": "efficiency", "passages": ((1.4, 0),), "period": 6.0, "periods": 1, "phase": 1.0, "phases": [1.0],
    "phi": 1.0, "place": 0.5, "power": 2.0, "pressure": 2.0, "quantities": ["label"], "rate": 0.1, "ratio": 0.1,
    "reach": 0.01, "restitution": 0.5, "s": 1.0, "seed": 1, "size": 2, "state": "power", "states": VALVE.states,
    "stiffness": 9.0, "strain": [1e-3], "t": 0.1, "time": 0.0, "times": 1.0, "unit": "mm", "units": {}, "value": 0.9,
    "values": {"s": 2.0}, "velocity": 1.0, "x": 0.5, "xi": 1.0,
}  # fmt: skip
"""Of parameters without a default, by their names."""


REPEATED = """
[bar]
length = "0.3 m"
area = "10 cm^2"
[tool]
sections = [{length = "1 m", area = "10 cm^2"}]
end = "fixed"
[blow]
velocity = "9 m/s"
number = 2
rate = "500 Hz"
between = "waves"
"""


class Arguments:
    """What every public callable takes, in one folder for the files among it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        explore.carry_out(Two(), archive=folder / "kept", workers=1)
        (folder / "plain.toml").write_text(PLAIN, encoding="utf-8")
        rows = (f"{1e-3 * i},{i % 5},{i % 3}" for i in range(100))
        blows = [f"{t:.6f},{10.9 + 0.01 * (i % 3)}" for i, t in enumerate(BLOWS.time)]
        (folder / "blows.csv").write_text("\n".join(["time [s],striking speed [m/s]", *blows]), encoding="utf-8")
        (folder / "recorded.csv").write_text("\n".join(["time [s],force [N],back [N]", *rows]), encoding="utf-8")
        self.si = System.from_si(Bar(0.3, 1e-3), SI_LOAD, Kept(0.5))
        self.objects = dict(self._objects())
        self.own = self._own()

    def _objects(self) -> Iterator[tuple[str, Any]]:
        """One of every class, by its name: what its methods are asked of, and what parameters of that type take."""
        case, hammer = Case.from_text(PLAIN, "plain.toml"), cases.load_case("laboratory-striker")
        drilling = cases.load_case("valve-drifter").changed(simulation={"modes": 0, "impacts": 3})
        states, timed = steady.steady_states(SYSTEM), Timed.of_uniform_bar(20.0, 0.6)
        one_impact = steady.PeriodicOrbit(SYSTEM, 1, (states.orbits[1].phase,), 0)
        rests = steady.rest_cycles(SYSTEM, modes=0, most=2)
        few: dict[str, Any] = {"stop": SHORT, "workers": 1}
        ranges = [cases.Span("bar.density", 7e3, 8e3, "kg/m^3"), cases.Span("contact.restitution", 0.1, 0.2)]
        designed = cases.design(drilling, ranges, "power", modes=0, most=20)
        found = [
            Bar(0.3, 1e-3), Section(0.1, 1e-3), SectionedBar([Section(0.1, 1e-3)]), External(0.1), UniformBar(1.0),
            Mounted(1.0), ModalBody(**MODES), SizedModes(**MODES), SteppedBar(1.0, (1.0, 2.0), (1.0, 1.0)), Kept(0.5),
            Reversed(0.5), timed, SYSTEM.load, SYSTEM, Chamber(), Cushion(force=1.0), VALVE.ports[0], Supply(0.7, 9.0),
            Relief(2.0, 0.5), GasAccumulator(0.5, 1.7), OIL, OIL.chambers[0],
            VALVE, VALVE.orders, MACHINE, MACHINE.modes(2), states, states.orbits[1],
            steady.PeriodicOrbit(SYSTEM, 1, (0.8, 2.5), 2), steady.timed_states(SYSTEM, timed),
            steady.timed_states(SYSTEM, timed).orbits[1], rests, rests.orbits[0],
            steady.self_excited_motion(MACHINE, modes=0), steady.self_excited_motion(MACHINE, modes=1).cycle,
            steady.self_excited_motion(MACHINE, modes=0).cycle, Start.rigid(), Starts.rigid([-0.2, -0.5]), SHORT,
            run(SYSTEM, modes=0, stop=SHORT), run(SYSTEM, modes=0, stop=SHORT).events,
            blow.Wall(), blow.Rock(1e8), blow.Steel(900e6),
            blow.Rod([Section(None, 1e-3)]),
            blow.strike(Bar(0.3, 1e-3), blow.Rod([Section(None, 1e-3)]), 1.0),
            explore.SystemFamily(SYSTEM),
            explore.Axis.linear("restitution", 0.2, 0.6, 2), Two(),
            explore.basins(SYSTEM, ("time", 0.0, 1.0, 2), ("velocity", -1.0, -0.5, 2), **few),
            explore.boundaries(SYSTEM, ("restitution", [0.3]), ("load_factor", 0.1, 1.0), kinds=("fold",)),
            explore.follow(one_impact, "mean", (0.89, 0.91), most=2),
            explore.follow(rests.orbits[0], "mean", (0.89, 0.91), points=2),
            explore.diagram(SYSTEM, "mean=0.85:0.95:2", up_to=None, starts=1, runs=0, modes=0, **few),
            explore.experiment(SYSTEM, 4, **few), explore.shares(SYSTEM, "restitution=0.2,0.6", 4, **few),
            explore.sweep(SYSTEM, "restitution=0.2,0.6", quantities=["orbits"]),
            case, cases.CaseFamily(case, {}), cases.steady_answer(case), cases.simulation_answer(case),
            cases.waves_answer(case, cells=16), cases.machine_answer(drilling, modes=0),
            cases.valve_waves_answer(drilling, cells=16), cases.repeated_answer(Case.from_text(REPEATED), cells=16),
            cases.repeated_answer(Case.from_text(REPEATED), cells=16).train,
            cases.compare([drilling, drilling], modes=0),
            cases.tolerance(drilling, figures=["blow_energy"], samples=64, modes=0, workers=1),
            BLOWS, cases.identify(drilling, BLOWS, [cases.Span("load.pressure", 150.0, 190.0, "bar")], modes=0),
            cases.blow_answer(hammer), cases.Span("bar.length", 100.0, 300.0, "mm"),
            cases.best_answer(hammer, [cases.Span("bar.length", 100.0, 300.0, "mm")], "efficiency", most=20),
            designed, designed.plane(2),
            cases.Limit("power", 1.0),
        ]  # fmt: skip
        for one in found:
            yield type(one).__name__, one
        yield "Trace", next(one for one in found if isinstance(one, blow.Blow)).face_force
        yield "Figure", _empty_figure()

    def _own(self) -> dict[str, dict[str, Any]]:
        """Where the name of a parameter, and the type, do not say enough: by a pattern of callables."""
        of, folder = self.objects, self.folder
        hammer, jackleg = cases.load_case("laboratory-striker"), cases.load_case("pneumatic-jackleg")
        drilling = cases.load_case("valve-drifter").changed(simulation={"modes": 0, "impacts": 3})
        branch = cases.branch_answer(jackleg, "1/1:2", "load_factor=0.39:0.45", modes=0)
        fold = branch.at(explore.BranchEvent.FOLD)[0]
        to_fold: dict[str, Any] = {"between": ((0.149, 0.151), (0.4, 0.45)), "values": (0.15, fold.value)}
        along_two = ("restitution", "load_factor")
        curve = explore.follow_point(fold, along_two, to_fold["between"], most=2)
        motion = folder / "motion.nc"
        of["Trajectory"].save(motion)
        clock = np.arange(0.0, of["BlowAnswer"].blow.until, 1e-6)
        waves = of["BlowAnswer"].waves
        pushed = waves.incident.at(clock) + waves.reflected.at(clock)
        seen = "t [s],F [N]\n" + "".join(f"{t},{f}\n" for t, f in zip(clock, pushed, strict=True))
        (folder / "gauge.csv").write_text(seen, encoding="utf-8")
        time = np.linspace(0.0, 10.0, 500)
        one_impact = steady.PeriodicOrbit(SYSTEM, 1, (of["Orbit"].phase,), 0)
        fed = MACHINE.with_valve(dataclasses.replace(VALVE, supply=Supply(0.7, 15.0)))
        supplied_cycle = steady.self_excited_motion(fed, modes=0).cycle
        range_: dict[str, Any] = {"name": "bar.length", "low": 100.0, "high": 300.0, "unit": "mm"}
        return {
            "recordings.read_blows": {"path": folder / "blows.csv"},
            "recordings.read_recording": {
                "path": folder / "recorded.csv", "column": "force", "unit": "N", "time_column": "time",
                "sample_rate": "1 kHz", "opposing_column": "back", "start": 0.01, "end": 0.08,
            },
            "model.Bar": {"area": 1.0},
            "model.Kept": {"restitution": None, "receiving_area": 2.0, "area": 1.0},
            "model.Reversed": {"restitution": None, "receiving_area": 2.0, "area": 1.0},
            "model.*Mod*": MODES,
            "model.SteppedBar": {"impedances": (1.0, 2.0), "transit_times": (1.0, 1.0), "lengths": (1.0, 2.0)},
            "model.Section": {"length": 0.1, "area": 1e-3},
            "model.SectionedBar": {"sections": [Section(0.1, 1e-3)]},
            "model.Timed": {"duration": 0.1, "force_centroid": 0.04, "advance_per_impulse": 0.01},
            "model.Supply": {"start": 1.0},
            "model.GasAccumulator": {"precharge": 0.5, "volume": 1.7},
            "model.OilChamber": {"area": 2.2, "side": "rear"},
            "model.Join": {"chamber": "rear", "to": "tank"},
            "model.Oil": {"chambers": OIL.chambers, "joins": {}},
            "case.data_sheet_answer": {
                "case": drilling, "pressure": 170e5, "flow": 1e-3, "rate": 61.0, "energy": 250.0,
            },
            "model.*.natural_frequencies": {"modes": 1},
            "stability.stability_of": {"orbit": of["Orbit"]},
            "stability.floquet_multipliers": {"orbit": of["Orbit"]},
            "steady.*.multipliers": {"modes": None},
            "steady.*.judged": {"modes": None},
            "model.Supply.of_oil": {"start": None, "flow": 2e-3, "compliance": 1e-8, "pressure": 1e7},
            "model.Port": {"to": "power", "side": "back", "delay": 0.1, "reads": 0.5, "behind": 1.0},
            "model.Valve": {"ports": VALVE.ports, "start": "power", "supply": of["Supply"], "cushion": Cushion()},
            "model.Machine": {"body": UniformBar(20.0)},
            "model.Machine.from_si": {"bar": Bar(0.3, 1e-3)},
            "model.MachineModes.at": {"body": UniformBar(20.0), "x": [0.5]},
            "model.Load.steps": {"values": [1.0, 0.3]},
            "model.Load.history": {"time": time, "values": np.sin(2 * np.pi * time) + 0.3, "harmonics": 3},
            "model.System": {"load": SYSTEM.load, "bar": Bar(0.3, 1e-3), "frequency": 2.0, "body": UniformBar(1.0)}
            | {"contact": Kept(0.5)},
            "model.System.from_si": {"load": SI_LOAD, "bar": Bar(0.3, 1e-3), "contact": Kept(0.5)},
            "steady.blank_blow": {"cushion": Cushion(force=10.0)},
            "steady.slow_pressure": {"cycle": supplied_cycle},
            "steady.pressure_over": {"cycle": supplied_cycle, "times": [0.1, 0.2]},
            "steady.FoundRestCycles.labelled": {"label": "chatter/1"},
            "steady.parameter_column": {"orbit": of["PeriodicOrbit"]},
            "steady.time_rates": {"orbit": of["PeriodicOrbit"]},
            "steady.ForceRecord": {"time": [0.0, 1.0], "force": [1.0, 2.0]},
            "steady.recorded_valve": {"system": SYSTEM.with_load(Load.square(1.0, 1.3))},
            "steady.si_report": {"orbit": steady.steady_states(self.si).orbits[1]},
            "stability.timed_stability": {"orbit": of["TimedOrbit"]},
            "simulate.Start": {"displacement": (-1.0,), "velocity": (0.0,), "gap": -1.0},
            "simulate.Start.orbit": {"orbit": of["Orbit"], "displacement": 0.0},
            "simulate.Starts": {"displacement": [[-1.0]], "velocity": [[0.0]], "gap": [-1.0], "time": [0.0]},
            "simulate.Starts.of": {"starts": [Start.rigid()]},
            "simulate.Stop": {"impacts": 3, "time": 1.0},
            "simulate.Start.with_valve": {"state": "power", "orders": VALVE.orders},
            "simulate.Starts.with_valve": {"state": [0, 1], "states": ("return", "power")},
            "simulate.simulate_m*": {"machines": MACHINE, "systems": SYSTEM, "starts": Start.rigid()},
            "simulate.*Events.of": {"kind": "impact"},
            "simulate.Trajectory.continued": {"stop": Stop(impacts=4)},
            "simulate.Trajectory.section": {"phase": 0.5},
            "simulate.Trajectory.load": {"path": motion},
            "simulate.*Trajectory.save": {"path": folder / "other.nc"},
            "explore.*.save": {"path": folder / "other.csv"},
            "blow.Rod": {"sections": [Section(1.0, 1e-3), Section(1.0, 2e-3)], "end": "rock", "bit_mass": 1.0}
            | {"joint_masses": [(1, 0.1)], "rock": of["Rock"]},
            "blow.Joint": {"at": 1, "mass": 1.0},
            "blow.Drilling.advance": {"residual": 1e-3, "dissipated": 100.0},
            "blow.Drilling": {"bit_diameter": 0.05, "crater_factor": 0.3},
            "blow.strike": {"striker": Bar(0.3, 1e-3), "target": blow.Wall(), "until": 1e-3, "load": [(0.0, 1.0)]}
            | {"velocity": 1.0},
            "blow.strike_again": {"blow": blow.strike(Bar(0.3, 1e-3), of["Rod"], 1.0, until=1e-3)},
            "blow.effective_blow": {"striker": UniformBar(1.0), "target": blow.Wall()},
            "blow.strike_repeatedly": {"striker": Bar(0.3, 1e-3), "target": blow.Rod([Section(1.0, 1e-3)], "fixed")}
            | {"velocity": 5.0, "period": 1e-3, "number": 1},
            "blow.run_valve_by_waves": {"target": blow.Rod([Section(1.0, 1e-3)], "fixed"), "gap": 0.01, "blows": 1}
            | {"machine": drilling.machine()},
            "blow.RepeatedBlows.mean": {"figure": "impulse"},
            "blow.run_by_waves": {"target": blow.Wall(), "stop": Stop(time=1.0)},
            "blow.Blow.waves_at": {"x": 0.1},
            "blow.Blow.force_turns": {"section": 0, "shares": [0.5]},
            "blow.Steel": {"ultimate": 900e6, "fatigue_limit": 360e6, "slope": 6.0},
            "blow.cycles_of": {"history": [0.0, 1.0, 0.5]},
            "blow.fatigue": {"steel": blow.Steel(900e6), "rod_steel": None, "notches": None},
            "explore.Archive.open": {"path": folder / "kept"},
            "explore.Axis": {"values": [1.0]},
            "explore.Axis.l*": {"number": 3},
            "explore.Axis.linear": {"first": -2.0},
            "explore.Axis.parsed": {"text": "s=1:2:3"},
            "explore.Axis.spanned": {"text": "s=1:2"},
            "explore.Boundaries.*": {"kind": "fold"},
            "explore.SystemFamily": {"base": SYSTEM},
            "explore.vary": {"hammer": SYSTEM},
            "explore.basins": {"x": ("time", 0.0, 1.0, 2), "y": ("velocity", -1.0, -0.5, 2)},
            "explore.experiment": {"chunk": 1000},  # of the 10 000 starts that None means
            "explore.boundaries": {"x": ("restitution", [0.3]), "y": ("load_factor", 0.1, 1.0), "kinds": ("fold",)},
            "explore.diagram": {"along": "mean=0.85:0.95:2"},
            "explore.shares": {"along": "restitution=0.3,0.4"},
            "explore.carry_out": {"job": Two()},
            "explore.estimate": {"job": Two()},
            "explore.sweep": {"what": SYSTEM, "axes": of["Axis"], "quantities": ["label"], "impacts": 20, "discard": 2},
            "explore.follow": {"orbit": one_impact, "family": SYSTEM, "value": 0.9},
            "explore.reach": {"orbit": one_impact, "family": SYSTEM, "value": 0.9},
            "explore.follow_point": {"point": fold, "along": along_two, "family": fold.orbit.system, **to_fold},
            "explore.lyapunov*": {"systems": SYSTEM, "starts": Start.rigid(), "impacts": 20, "discard": 2},
            "case.Case.changed": {"start": None, "simulation": {"impacts": 2}},
            "case.Case.from_text": {"text": PLAIN, "file": "x.toml", "folder": folder},
            "case.Case.read": {"path": folder / "plain.toml"},
            "case.Case.varied": {"values": {"system.s": 10.0}},
            "case.CaseFamily.varied": {"values": {"bar.length": 200.0}},
            "case.CaseFamily.blow": {"values": {"bar.length": 200.0}},
            "case.CaseFamily.whole": {"values": {"restitution": 0.3}},
            "case.load_case": {"name": "pile-hammer"},
            "case.compare": {"cases": [hammer, hammer], "names": ["A", "B"], "modes": 0},
            "case.basins_job_of": {
                "x": explore.Axis.linear("time", 0, 1, 2), "y": explore.Axis.linear("velocity", -2, -1, 2),
            },
            "case.sweep_job_of": {"axes": [of["Axis"]], "quantities": ["orbits"]},
            "case.resumed_answer": {"path": motion, "impacts": 4, "time": 60.0},
            "case.blow_answer": {"case": hammer, "velocity": 9.0},
            "case.orbits_answer": {"label": "1/1", "switch": False},
            "case.branch_answer": {"orbit": "1/1:1", "along": "mean=0.89:0.91"},
            "case.point_curves_answer": {"case": jackleg, "branch": branch, "which": "fold"}
            | {"along": "load_factor=0.39:0.45", "over": "restitution=0.149:0.151"},
            "case.diagram_*": {"along": "mean=0.85:0.95:2"},
            "case.reach_answer": {"names": ["mean"]},
            "case.measured_gauge": {"answer": of["BlowAnswer"], "path": folder / "gauge.csv"},
            "case.Span": range_,
            "case.Span.parsed": {"words": "bar.length=100:300mm"},
            "case.parsed_tolerance": {"words": "load.pressure=±10bar", "case": drilling},
            "case.tolerance*": {
                "case": drilling, "tolerances": [cases.Span("load.pressure", 150.0, 170.0, "bar")],
                "figures": ["blow_energy"], "samples": 64, "modes": 0,
            },
            "case.standard_tolerances": {"case": drilling},
            "case.parsed_unknown": {"words": "load.pressure", "case": drilling},
            "case.identify": {
                "case": drilling, "record": BLOWS, "vary": [cases.Span("load.pressure", 150.0, 190.0, "bar")],
                "given": [cases.Span("bar.diameter", 48.9, 49.1, "mm")], "modes": 0,
            },
            "case.uncertainty_of": {"case": drilling.varied({"load.pressure": "160 ± 5 bar"}), "modes": 0},
            "case.best_answer": {"case": hammer, "spans": [cases.Span(**range_)], "most": 20},
            "case.design": {"case": drilling, "spans": [cases.Span("bar.density", 7e3, 8e3, "kg/m^3")]}
            | {"figure": "power", "limits": [cases.Limit("power", 1.0)], "modes": 0, "most": 20},
            "case.Limit": {"figure": "power", "low": 1.0, "high": 2.0},
            "case.Limit.parsed": {"words": "power=1 W", "sense": "above", "is_si": True},
            "case.machine_*": {"case": drilling},
            "case.valve_waves_answer": {"case": drilling},
            "case.repeated_answer": {"case": Case.from_text(REPEATED)},
            "case.recorded_answer": {"case": Case.from_text(SQUARE)},
            "case.steady_answer": {"periods": [1], "modes": 4, "starts": 0},
            "units.known_dimension": {"unit": "mm"},
            "units.si": {"value": "1 mm"},
            "units.split_header": {"text": "p [bar]"},
            "units.unit_scale": {"unit": "bar", "dimensions": ("pressure",)},
            "plot.branch": {"found": branch},
            "plot.curves": {"found": [curve]},
            "plot.machine_motion": {"motion": run(MACHINE, modes=0, stop=SHORT)},
            "plot.diagram": {"quantities": ("phase",)},
            **{f"plot.{name.lower()}": {"found": of[name]} for name in ("Basins", "Experiment", "Sweep")},
            **{f"plot.{name.lower()}": {"answer": of[f"{name}Answer"]} for name in ("Best", "Blow", "Machine")},
            "plot.save": {"figure": _empty_figure(), "path": folder / "picture.svg"},
        }  # fmt: skip

    def subject(self, owner: type, kind: str, method: str) -> Any:
        """What a method is asked of: the class, or the object of it, here and there another one."""
        if isinstance(inspect.getattr_static(owner, method), classmethod | staticmethod):
            return owner
        match kind, method:
            case "System", "stress":
                return self.si
            case "Load", "on_steps" | "piece":
                return Load.square(1.0, 1.3)
            case "SteadyStates", "contact_place":
                return steady.steady_states(System(ModalBody(**MODES, gap=0.1), Load.harmonic(0.1, 1.0), Kept(0.5)))
            case "CaseFamily", "machine" | "room" | "whole":
                return cases.CaseFamily(cases.load_case("valve-drifter"), {})
            case "CaseFamily", "varied" | "blow":
                return cases.CaseFamily(cases.load_case("laboratory-striker"), {"bar.length": "mm"})
            case "Drilling", _:
                return blow.Drilling(0.05, crater_factor=0.3)
            case "HeldBody", _:
                return self.objects["Mounted"]
        return self.objects[kind]

    def of(self, door: str, function: Callable[..., object]) -> tuple[Callable[..., object], dict[str, Any]]:
        """A callable, bound to its object when it is a method, and a valid call of it."""
        owner, _, method = door.rpartition(".")
        known = dict(public())
        bound = getattr(self.subject(known[owner], owner.split(".")[1], method), method) if owner in known else function
        own = {
            key: value
            for pattern, some in self.own.items()
            if fnmatchcase(door, pattern)
            for key, value in some.items()
        }
        given = {name: self._one(door, name, about, own) for name, about in parameters(function).items()}
        return by_names(bound), given

    def _one(self, door: str, name: str, about: inspect.Parameter, own: dict[str, Any]) -> Any:
        """A valid value of one parameter."""
        for known in (own, CHEAP):
            if name in known:
                return known[name]
        if about.default is not about.empty:
            return about.default
        if name in NAMED:
            return NAMED[name]
        for word in re.findall(r"\w+", str(about.annotation)):
            if word in self.objects:
                return self.objects[word]
        raise LookupError(f"{door}: no value is known for {name}: {about.annotation}")


def meant(door: str, name: str) -> set[str]:
    """The wrong objects that have a meaning in a parameter."""
    words = set(re.findall(r"\w+", str(parameters(doors()[door])[name].annotation)))
    place = f"{door}.{name}"
    line = next((told for told, places in MEANT if any(fnmatchcase(place, one) for one in places.split())), "nothing")
    if line == "nothing" and any(place in places.split() for _, places in MEANT):
        words &= {"None"}
    found = set(line.split(", ")) - {"nothing"}
    found |= {"None"} if "None" in words and place not in NOT_NONE else set()
    found |= {"bool"} if "bool" in words and "Callable" not in words else set()
    return found | ({"dict"} if words & {"dict", "Mapping"} else set())


def modules() -> list[Any]:
    """The rooms with public names."""
    return [percuss, *(importlib.import_module(f"percuss.{room}") for room in ROOMS)]


def parameters(function: Callable[..., object]) -> dict[str, inspect.Parameter]:
    """What a caller can give; how a job is carried out, too, where that is passed on."""
    try:
        told = dict(inspect.signature(function).parameters)
    except (TypeError, ValueError):
        return {}
    if "running" in told:
        told = told | dict(inspect.signature(explore.carry_out).parameters)
    unnamed = {
        "self",
        "given",
        "running",
        *({"job"} if "running" in told else ()),
    }  # `given` of `System` have names too
    return {name: about for name, about in told.items() if name not in unnamed and about.kind is not about.VAR_KEYWORD}


def by_names(function: Callable[..., object]) -> Callable[..., object]:
    """The same, with one of what it takes any number of, by its name too."""
    told = inspect.signature(function).parameters
    star = next((place for place, about in enumerate(told.values()) if about.kind is about.VAR_POSITIONAL), None)
    if star is None:
        return function
    before = list(told)[: star + 1]
    return lambda **given: function(*map(given.get, before), **{k: v for k, v in given.items() if k not in before})


def public() -> Iterator[tuple[str, Callable[..., object]]]:
    """Every public callable, and the public methods of every public class, by room and name; each once."""
    seen = set()
    for module in modules():
        for name in module.__all__:
            found = getattr(module, name)
            if not callable(found) or not str(found.__module__).startswith("percuss."):
                continue
            key = f"{found.__module__.split('.')[1]}.{found.__qualname__}"
            if key in seen:
                continue
            seen.add(key)
            yield key, found
            for base in found.__mro__[:-1] if inspect.isclass(found) else ():
                for method in vars(base) if base.__module__.startswith("percuss.") else ():
                    thing = getattr(found, method)
                    own = inspect.isroutine(thing) if base is found else inspect.isfunction(thing)
                    if not method.startswith("_") and own and f"{key}.{method}" not in seen:
                        seen.add(f"{key}.{method}")
                        yield f"{key}.{method}", thing


def is_door(name: str, found: Callable[..., object]) -> bool:
    """Whether users call it with objects of their own.

    Not so the classes that check nothing at construction: those are results, and parts of them, made by the package.
    Nor the methods of bodies and laws that the mechanics ask, but their doors.
    """
    if name in LEFT_OUT or not parameters(found):
        return False
    if inspect.isclass(found):
        checks = "__init__" if not dataclasses.is_dataclass(found) else "__post_init__"
        ours = [base for base in found.__mro__[:-1] if base.__module__.startswith("percuss.")]
        return name in CONSTRUCTED or any(checks in vars(base) for base in ours)
    room, _, method = name.partition(".")
    kind, _, method = method.partition(".")
    owner = getattr(importlib.import_module("percuss.model"), kind, None) if room == "model" and method else None
    contracts = {"Body", "Damping", "Contact", "SizedBody", "Modes"}
    if not contracts & {base.__name__ for base in getattr(owner, "__mro__", ())}:
        return True
    return kind not in contracts and method in ("place", "with_restitution", "body", "natural_frequencies")


@functools.cache
def doors() -> dict[str, Callable[..., object]]:
    """Every public callable that meets what users give."""
    return {name: found for name, found in public() if is_door(name, found)}


def _empty_figure() -> Any:
    from matplotlib.figure import Figure

    return Figure(figsize=(1.0, 1.0))
