"""What bodies, loads, laws, valves and machines refuse, each by the name of what is wrong: one table."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import Any

import numpy as np
import pytest

from percuss import Bar, Kept, Load, System
from percuss.errors import ParameterError
from percuss.model import (
    Chamber,
    External,
    KelvinVoigt,
    Machine,
    Port,
    Ratio,
    Reversed,
    Section,
    SectionedBar,
    SteppedBar,
    Table,
    Timed,
    UniformBar,
    Valve,
)
from percuss.model.contact import restitutions

Refusal = tuple[Callable[[], Any], str]
NONSENSE = [math.nan, math.inf, -math.inf, "1", [1.0, 2.0], 1j, True, {"no": "number"}]
NOTHING = [*NONSENSE, None]
LOAD = Load.fourier([0.9, 1.0, 0.2 - 0.3j])
NEWTONS = Load.harmonic(1.0, 1.0, frequency=60.0)
BAR = Bar(length=0.341, diameter=0.049, damping_ratio=1e-3)
SYSTEM = System(s=20.0, d=0.0048, restitution=0.6, load=LOAD)
PLAIN = {"s": 5.0, "d": 0.1, "restitution": 0.5, "load": LOAD}
SIZES = {"length": 0.3, "area": 1e-3}
ROD, ROUND = {"length": 0.1, "area": 1e-3}, {"length": 0.1, "diameter": 0.03}
STEPPED = {"s": 5.0, "impedances": (1.0, 2.0), "transit_times": (1.0, 1.0)}
PISTON = SectionedBar([Section(0.12, diameter=0.052), Section(0.25, diameter=0.04, bore=0.01)], Ratio(1e-3))
PORTS = (Port("power", behind=1.0, side="back"), Port("return", on="impact"))
VALVE = Valve({"return": -0.4, "power": 1.8}, PORTS)
MACHINE = Machine(UniformBar(20.0), VALVE, Kept(0.2))


def each(make: Callable[..., Any], good: dict[str, Any], names: str, values: Iterable[Any]) -> Iterator[Refusal]:
    """Every value in the place of every name: told by that name."""
    for name in names.split():
        for value in values:
            yield partial(make, **{**good, name: value}), f"^{name}"


def named(make: Callable[..., Any], good: dict[str, Any], *changes: tuple[str, dict[str, Any]]) -> Iterator[Refusal]:
    """Each change of something good, told by a name."""
    for name, change in changes:
        yield partial(make, **{**good, **change}), f"^{re.escape(name)} = "


REFUSED: list[Refusal] = [
    *each(Bar, SIZES, "length area youngs_modulus density", [*NOTHING, 0.0, -1.0]),
    *each(Bar, SIZES, "damping damping_ratio", [*NONSENSE, -1e-9]),
    *each(Bar, {"length": 0.3}, "diameter", [*NONSENSE, -1e-9]),
    (lambda: Bar(0.3), "area"),
    (lambda: Bar(0.3, 1e-3, diameter=0.03), "area"),
    (lambda: Bar(**SIZES, damping=1.0, damping_ratio=0.1), "damping"),
    (lambda: Bar(0.3, diameter=0.03, damping_ratio=1.1), r"damping_ratio.*critical damping, 0 to 1"),
    *each(System, PLAIN, "s", [*NOTHING, 0.0, -1.0]),
    *each(System, PLAIN, "d", [*NOTHING, -1e-300]),
    *each(System, PLAIN, "restitution", [*NOTHING, -1e-300, 1.0 + 1e-15]),
    *each(SYSTEM.with_restitution, {}, "restitution", [*NOTHING, -1e-300, 1.0 + 1e-15]),
    *each(Kept, {}, "restitution", [*NONSENSE, -1e-300, 1.0 + 1e-15, -1.0]),
    *each(System, PLAIN, "load", [None, 1.0, "load", [0.9, 1.0]]),
    # half an SI side
    (lambda: System(**{**PLAIN, "load": NEWTONS}), "expected"),
    (lambda: System(**PLAIN, bar=BAR), "expected"),
    (lambda: System(**PLAIN, frequency=60.0), "expected"),
    (lambda: System.from_si(BAR, Load.harmonic(1.0, 1.0), Kept(0.5)), "^frequency"),
    # one of two ways to make a system
    (lambda: System(body=UniformBar(1.0), load=LOAD, contact=Kept(0.2), restitution=0.3), "expected"),
    (lambda: System(body=UniformBar(1.0), load=LOAD), "expected"),
    (lambda: System(s=1.0, load=LOAD), "expected"),
    (lambda: System(load=LOAD, contact=Kept(0.2)), "expected"),
    (lambda: System(UniformBar(1.0), LOAD, Kept(0.2), None), "expected"),
    (lambda: System(1.0, 0.0, 0.2, LOAD, s=1.0), "not two"),
    (lambda: System(s=1.0, d=0.0, restitution=0.5, load=LOAD.acting_at(1)), "no steps"),
    *(
        (partial(System, 1.0, 0.0, 0.5, load), "check the scales")
        for tiny in (5e-324, 1e-310)
        for load in (Load.harmonic(tiny, 1.0), Load.harmonic(0.0, tiny))
    ),
    # loads
    *each(Load.harmonic, {"mean": 1.0, "amplitude": 2.0}, "mean amplitude", NOTHING),
    *each(Load.harmonic, {"mean": 1.0, "amplitude": 2.0}, "harmonic", [*NOTHING, 0, -1, 1.5, 5000]),
    *each(Load.harmonic, {"mean": 1.0, "amplitude": 2.0}, "frequency", [*NONSENSE, 0.0, -60.0]),
    *each(Load.square, {"amplitude": 1.0, "kappa": 1.2}, "harmonics", [*NOTHING, 0, -1, 1.5, 5000]),
    *each(Load.square, {"amplitude": 1.0}, "kappa", [*NOTHING, 0.0, 2.0, -0.1, 2.1]),
    *each(Load.fourier, {}, "coefficients", [[], [math.nan], [1.0, math.inf], [1.0, complex(0, math.nan)], [1j, 1.0]]),
    *each(Load.fourier, {}, "coefficients", [["a"], "abc", None, [[1, 2, 3]], [[1.0], [1.0, 2.0]], [None, 1.0]]),
    *each(Load.fourier, {}, "coefficients", [{"a": 1}, [[1.0, 0.5], [1.0, 0.0]], np.ones(4098)]),
    *each(Load.steps, {"values": [1.0, 2.0]}, "breaks", [[1.0, 0.5], [1.0, 1.0], [0.0, 7.0], [-0.1, 1.0]]),
    *each(Load.steps, {"values": [1.0, 2.0]}, "breaks", [[0.0, math.nan], ["0", 1.0]]),
    *each(Load.steps, {"breaks": [0.0, 1.0]}, "values", [[1.0, math.inf]]),
    (lambda: Load.steps([0.0], [1.0]), "^(breaks|values)"),
    (lambda: Load.steps([0.0, 1.0], [1.0]), "^(breaks|values)"),
    *(
        (partial(change, value), "expected")
        for value in NONSENSE
        for load in (LOAD, Load.square(1.5, 1.3))
        for change in (load.shifted, load.scaled, load.with_mean, SYSTEM.with_load_factor)
    ),
    (lambda: dataclasses.replace(SYSTEM, load=Load.fourier([1.0])).with_load_factor(0.5), "expected"),
    *each(partial(Load.from_function, np.cos), {}, "tolerance", [0.0, math.nan]),
    *each(partial(Load.from_function, np.cos), {}, "harmonics", [0, 5000]),
    # laws of the contact
    *(
        (partial(Kept, **given), "expected")
        for given in (
            {},
            {"receiving_area": 1.0},
            {"restitution": 0.5, "receiving_area": 1.0, "area": 0.5},
            {"receiving_area": -1.0, "area": 0.5},
            {"receiving_area": math.nan, "area": 0.5},
            {"receiving_area": 1.0, "area": 0.0},
        )
    ),
    (lambda: Kept(receiving_area=0.4, area=0.5), "restitution instead"),
    *((partial(restitutions, wrong), "0 to 1") for wrong in ([0.5, 1.1], -0.1, np.nan, "soft")),
    (lambda: System(SteppedBar(1.0, (2.0, 1.9999), (1.0, 1.0)), LOAD, Reversed(0.2)), "kept"),
    (lambda: Timed(-0.2, 0.1, 0.05), "in steps that never end"),
    (lambda: Timed(1.2, 0.1, 0.05), "0 to 1"),
    (lambda: Timed.of_uniform_bar(20.0, 0.6, "residual penetration"), "expected"),  # type: ignore[arg-type]
    *named(
        Timed,
        {"restitution": 0.5},
        ("duration", {"duration": -0.1}),
        ("force_centroid", {"duration": 0.1, "force_centroid": 0.2}),
        ("advance_per_impulse", {"advance_per_impulse": -1.0}),
        ("ringing_share", {"ringing_share": 1.5}),
        ("contacts", {"contacts": 0}),
        ("law", {"law": "b77"}),
    ),
    # dampings, sections and stepped bars
    *(
        (make, "expected")
        for make in (lambda: Ratio(-0.1), lambda: Ratio(1.1), lambda: KelvinVoigt(-1.0), lambda: Table(()))
    ),
    *(
        refusal
        for name, sizes in (
            ("length", {**ROD, "length": 0.0}),
            ("length", {**ROD, "length": math.nan}),
            ("area", {**ROD, "area": -1e-3}),
            ("area", {"length": 0.1}),
            ("area", {**ROD, **ROUND}),
            ("diameter", {**ROUND, "diameter": 0.0}),
            ("bore", {**ROUND, "bore": 0.03}),
            ("bore", {**ROUND, "bore": -0.01}),
            ("youngs_modulus", {**ROD, "youngs_modulus": 0.0}),
            ("density", {**ROD, "density": -1.0}),
        )
        for refusal in (
            (partial(Section, **sizes), f"^{name} = "),
            (partial(SectionedBar, [ROD, sizes]), rf"^sections\[1\]\.{name} = "),
        )
    ),
    *named(
        SectionedBar,
        {},
        ("sections", {"sections": []}),
        ("sections", {"sections": [Section(0.1, 1e-3)] * 201}),
        ("sections", {"sections": "two"}),
        ("sections[0]", {"sections": [0.1]}),
        ("sections[1]", {"sections": [Section(0.1, 1e-3), {"length": 0.1, "width": 0.2}]}),
        ("sections[0]", {"sections": [{"area": 0.1}]}),
    ),
    *(
        (partial(SectionedBar, tuple(Section(0.1, area) for area in areas)), rf"sections\[{at}\].area.*neighbour")
        for areas, at in (((1e-3, 0.9e-9), 1), ((1e-9, 1e-3), 1), ((1e-3, 2e-3, 1e-9), 2))
    ),
    *(
        (partial(SteppedBar, 5.0, z, (1.0,) * len(z)), rf"impedances\[{len(z) - 1}\].*neighbour")
        for z in ((1.0, 1e6), (1e7, 1.0), (2.0, 1.0, 1e-6))
    ),
    (lambda: System.from_si(PISTON, NEWTONS, Reversed(0.3)), "uniform bar"),
    (lambda: System.from_si(PISTON, NEWTONS.acting_at(2), Kept(0.3)), r"0 .the driven end. to 1"),
    *named(
        SteppedBar,
        STEPPED,
        ("impedances[1]", {"impedances": (1.0, 0.0)}),
        ("impedances[1]", {"impedances": (1.0, -2.0)}),
        ("impedances", {"impedances": (1.0, math.nan)}),
        ("impedances", {"impedances": (1.0, math.inf)}),
        ("impedances", {"impedances": ()}),
        ("impedances", {"impedances": (1.0,) * 201, "transit_times": (1.0,) * 201}),
        ("impedances", {"impedances": (1.0, 1e16)}),
        ("impedances", {"impedances": "12"}),
        ("transit_times[1]", {"transit_times": (1.0, 0.0)}),
        ("transit_times", {"transit_times": (1.0,)}),
        ("lengths[1]", {"lengths": (1.0, -1.0)}),
        ("lengths", {"lengths": (1.0, 1.0, 1.0)}),
        ("s", {"s": 0.0}),
        ("s", {"s": math.nan}),
        ("damping", {"damping": 0.1}),
        ("d", {"damping": External(1e7)}),
    ),
    # machines: forces that no number can follow, of a state or of the chamber, too
    (lambda: Machine(UniformBar(20.0), VALVE, Kept(0.2), pressure=1e7), "from_si"),
    (lambda: MACHINE.length_scale, "from_si"),
    (lambda: Machine(UniformBar(20.0), VALVE, Kept(0.2), at=1), "at"),
    (lambda: Machine(UniformBar(20.0), 3.0, Kept(0.2)), "valve"),  # type: ignore[arg-type]
    (lambda: VALVE.scaled(1.0, 0.0), "length"),
    *(
        (make, "0, or a size from 1e-100")
        for tiny in (5e-324, 1e-310, -1e-150)
        for make in (partial(Valve, {"return": -1.0, "power": tiny}, PORTS), partial(Chamber, tiny))
    ),
]


@pytest.mark.parametrize(("make", "says"), REFUSED, ids=lambda told: told if isinstance(told, str) else "")
def test_what_is_wrong_is_told(make: Callable[[], Any], says: str) -> None:
    with pytest.raises(ParameterError, match=says) as caught:
        make()
    assert caught.value.name and caught.value.accepted


def test_what_is_just_possible_is_taken() -> None:
    assert SteppedBar(5.0, (1.0, 1e4, 1e8), (1.0, 1.0, 1.0)).modes(8).inertia.min() > 0.0  # gradually
    for impedances in ((1.0, 1e6), (1e7, 1.0), (2.0, 1.0, 1e-6)):
        SteppedBar(5.0, tuple(z**0.8 for z in impedances), (1.0,) * len(impedances))
    SectionedBar((Section(0.1, 1e-3), Section(0.1, 1.1e-9)))
    assert restitutions([0, 1]).tolist() == [0.0, 1.0]
    assert Load.fourier([1.0]).is_constant and Load.fourier([1.0]).load_factor == math.inf
