"""One blow in bare numbers, as the second programs of these tests take it: impedances and transit times, no lengths."""

from __future__ import annotations

import json
from dataclasses import dataclass, field, replace
from fractions import Fraction
from pathlib import Path
from typing import Any

Number = Any
"""A float, or a Fraction where the arithmetic is to be exact."""


@dataclass(frozen=True)
class Collision:
    """A striker of sections (impedance, transit time) and what it meets: a wall (`rod` None), or a rod of sections.

    The last section of a rod with the end "infinite" has the transit time None. Loads are steps (time, force), each
    held until the next; they act at the driven end (`load_at` 0) or at the step of that number.
    """

    striker: tuple[tuple[Number, Number], ...]
    velocity: tuple[Number, ...]
    until: Number
    rod: tuple[tuple[Number, Number | None], ...] | None = None
    end: str = "infinite"
    gap: Number = 0
    load: tuple[tuple[Number, Number], ...] = ()
    load_at: int = 0
    k1: Number = 0
    gamma: Number = 1
    rock_gap: Number = 0
    bit_mass: Number = 0
    joint_masses: tuple[tuple[int, Number], ...] = ()

    @property
    def mass(self) -> Number:
        return sum(z * tau for z, tau in self.striker)

    @property
    def velocity_before(self) -> Number:
        """The mean one."""
        return sum(z * tau * v for (z, tau), v in zip(self.striker, self.velocity, strict=True)) / self.mass

    @property
    def energy_before(self) -> Number:
        return sum(z * tau * v * v for (z, tau), v in zip(self.striker, self.velocity, strict=True)) / 2

    @property
    def transit(self) -> Number:
        """Of the striker."""
        return sum(tau for _, tau in self.striker)

    def turned_into(self, number: Any) -> Collision:
        """The same with every number of another type, such as Fraction or float."""

        def pairs(rows: Any) -> Any:
            return tuple((number(a), None if b is None else number(b)) for a, b in rows)

        plain = {name: number(getattr(self, name)) for name in ("until", "gap", "k1", "gamma", "rock_gap", "bit_mass")}
        return replace(
            self,
            striker=pairs(self.striker),
            velocity=tuple(map(number, self.velocity)),
            rod=None if self.rod is None else pairs(self.rod),
            load=pairs(self.load),
            joint_masses=tuple((step, number(mass)) for step, mass in self.joint_masses),
            **plain,
        )


@dataclass(frozen=True)
class Reference:
    """A blow with figures from elsewhere, in SI."""

    name: str
    sections: tuple[tuple[float, float, float, float], ...]
    rod_sections: tuple[tuple[float | None, float, float, float], ...]
    collision: Collision
    expected: dict[str, Any]
    table: dict[str, Any] = field(repr=False)


def references() -> list[Reference]:
    """The blows of reference_blows.json."""
    found = json.loads((Path(__file__).parent / "reference_blows.json").read_text(encoding="utf-8"))
    return [_reference(table) for table in found]


def _reference(table: dict[str, Any]) -> Reference:
    sections, target = table["striker"]["sections"], table["target"]
    velocity = table["striker"]["velocity"]
    velocities = velocity if isinstance(velocity, list) else [velocity] * len(sections)
    rock = target.get("rock", {})
    return Reference(
        table["name"],
        tuple(map(tuple, sections)),
        tuple(map(tuple, target.get("sections", ()))),
        Collision(
            striker=tuple(map(_seen_by_waves, sections)),
            velocity=tuple(velocities),
            until=table["until"],
            rod=None if target["kind"] == "wall" else tuple(map(_seen_by_waves, target["sections"])),
            end=target.get("end", "infinite"),
            gap=table["gap"],
            load=tuple(map(tuple, table.get("load", ()))),
            k1=rock.get("k1", 0.0),
            gamma=rock.get("gamma", 1.0),
            rock_gap=rock.get("gap", 0.0),
            bit_mass=target.get("bit_mass", 0.0),
        ),
        table["expect"],
        table,
    )


def _seen_by_waves(section: Any) -> tuple[float, float | None]:
    length, area, modulus, density = section
    time = None if length is None else length * (density / modulus) ** 0.5
    return area * (modulus * density) ** 0.5, time


def simple(value: float) -> Fraction:
    """The fraction that a float of a few digits stands for."""
    return Fraction(value).limit_denominator(10**12)
