"""Hypothesis strategies of blows, and the bridge from their bare numbers to the package.

`exact_collisions` has commensurable times and small fractions, without rock: the rational program computes those.
`collisions` has anything: incommensurable times, sections of very different size, rocks from soft to stiff, bits with
and without mass, gaps, loads that push or pull, sections with speeds of opposite sign.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

from hypothesis import strategies as st

from collisions import Collision
from percuss.blow import Rock, Rod, Wall, strike
from percuss.model import Section, SectionedBar
from strategies import decades

MIDDLING = decades(-1.0, 1.0)
TIMES = decades(-0.5, 0.5)  # of ordinary machines; shorter ones make pieces by the million


def section(impedance: Any, transit: Any) -> Section:
    """With E = ρ = 1 the length is the transit time, and the area the impedance."""
    length = None if transit is None else float(transit)
    return Section(length, area=float(impedance), youngs_modulus=1.0, density=1.0)


def bodies(case: Collision) -> tuple[SectionedBar, Wall | Rod]:
    """Striker and target of the package."""
    striker = SectionedBar([section(z, tau) for z, tau in case.striker])
    if case.rod is None:
        return striker, Wall(float(case.gap))
    rock = Rock(float(case.k1), float(case.gamma), float(case.rock_gap)) if case.end == "rock" else None
    rod = Rod(
        [section(z, tau) for z, tau in case.rod],
        case.end,  # type: ignore[arg-type]
        bit_mass=float(case.bit_mass),
        joint_masses=[(step, float(mass)) for step, mass in case.joint_masses],  # type: ignore[arg-type]
        rock=rock,
        gap=float(case.gap),
    )
    return striker, rod


def struck(case: Collision, **options: Any) -> Any:
    """The blow by the package."""
    striker, target = bodies(case)
    return strike(
        striker,
        target,
        [float(v) for v in case.velocity],
        until=float(case.until),
        load=[(float(t), float(force)) for t, force in case.load],
        load_at=case.load_at,
        **options,
    )


fractions = st.builds(Fraction, st.integers(1, 12), st.sampled_from([1, 2, 3, 4]))
signed = st.builds(Fraction, st.integers(-8, 8), st.sampled_from([1, 2, 3]))


@st.composite
def exact_collisions(draw: st.DrawFn, transits: int = 6) -> Collision:
    """Without rock and lumped masses; the last section of the striker moves toward the target."""
    count = draw(st.integers(1, 4))
    striker = [(draw(fractions), Fraction(draw(st.integers(1, 6)))) for _ in range(count)]
    speeds = [draw(st.one_of(st.just(Fraction(1)), signed)) for _ in range(count)]
    rod, end = None, "infinite"
    if draw(st.booleans()):
        end = draw(st.sampled_from(["infinite", "free", "fixed"]))
        sections = [(draw(fractions), Fraction(draw(st.integers(1, 6)))) for _ in range(draw(st.integers(1, 3)))]
        rod = [*sections[:-1], (sections[-1][0], None)] if end == "infinite" else sections
    case = Collision(
        tuple(striker), tuple(speeds), Fraction(0), None if rod is None else tuple(rod), end,
        load=draw(exact_loads()), load_at=draw(st.integers(0, count - 1)),
    )  # fmt: skip
    case = _approaching(case)
    share = draw(st.sampled_from([Fraction(0), Fraction(0), Fraction(1, 3), Fraction(1), Fraction(7, 5)]))
    return _lasting(replace(case, gap=share * case.velocity_before * case.transit), transits)


@st.composite
def exact_loads(draw: st.DrawFn) -> tuple[tuple[Fraction, Fraction], ...]:
    if draw(st.booleans()):
        return ()
    times = sorted(draw(st.sets(st.integers(0, 20), min_size=1, max_size=3)))
    return tuple((Fraction(t), draw(signed)) for t in times)


def _approaching(case: Collision) -> Collision:
    """With a mean velocity toward the target: all are turned round, or moved, where it is not."""
    mean = case.velocity_before
    scale = max(map(abs, case.velocity), default=1) or 1
    if mean < 0:
        case = replace(case, velocity=tuple(-v for v in case.velocity))
    if 10 * abs(mean) < scale or scale * 10 < 1:
        case = replace(case, velocity=tuple(v + scale for v in case.velocity))
    return case if case.velocity_before > 0 else replace(case, velocity=tuple(v + 1 for v in case.velocity))


def _lasting(case: Collision, transits: int) -> Collision:
    """Until so many transits after the faces could first have met."""
    return replace(case, until=transits * case.transit + case.gap / case.velocity_before)


@st.composite
def collisions(
    draw: st.DrawFn,
    *,
    sections: int = 3,
    transits: float = 4.0,
    rock: bool | None = None,
    times: st.SearchStrategy[float] = TIMES,
    impedances: st.SearchStrategy[float] = MIDDLING,
    gaps: bool = True,
    loads: bool = True,
) -> Collision:
    """Anything; `rock` True: always, False: never."""
    count = draw(st.integers(1, sections))
    striker = tuple((draw(impedances), draw(times)) for _ in range(count))
    speeds = tuple(draw(st.one_of(st.just(1.0), st.floats(-1.5, 1.5).map(lambda v: round(v, 2)))) for _ in range(count))
    extra: dict[str, Any] = {"load_at": draw(st.integers(0, count - 1))}
    ends = ["rock"] if rock else ["wall", "infinite", "free", "fixed"] + ([] if rock is False else ["rock", "rock"])
    end = draw(st.sampled_from(ends))
    rod = None
    if end != "wall":
        rod = [(draw(impedances), draw(times)) for _ in range(draw(st.integers(1, 2)))]
        if end == "infinite":
            rod[-1] = (rod[-1][0], None)  # type: ignore[assignment]
        if len(rod) > 1 and draw(st.booleans()):
            extra["joint_masses"] = ((draw(st.integers(1, len(rod) - 1)), draw(MIDDLING)),)
        if end in ("rock", "free"):
            extra["bit_mass"] = draw(st.one_of(st.just(0.0), MIDDLING))
    if end == "rock":
        extra |= {"k1": draw(decades(-1.5, 1.5)), "gamma": draw(st.one_of(st.just(1.0), st.floats(0.05, 1.0)))}
        extra["rock_gap"] = draw(st.one_of(st.just(0.0), MIDDLING)) if gaps else 0.0
    if gaps:
        extra["gap"] = draw(st.one_of(st.just(0.0), st.floats(0.01, 2.0)))  # turned into a length below
    if loads and draw(st.booleans()):
        moments = sorted(draw(st.sets(st.floats(0.0, 20.0).map(lambda t: round(t, 3)), min_size=1, max_size=3)))
        extra["load"] = tuple((t, round(draw(st.floats(-1.0, 1.0)), 3)) for t in moments)
    ended = "infinite" if end == "wall" else end
    case = Collision(striker, speeds, 0.0, None if rod is None else tuple(rod), ended, **extra)
    case = _approaching(case)
    case = replace(case, gap=case.gap * case.velocity_before * case.transit)
    return _lasting(case, transits)  # type: ignore[arg-type]
