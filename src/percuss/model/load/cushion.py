"""A cushion at the front end of the stroke, which stops a piston that finds no tool."""

from __future__ import annotations

from dataclasses import dataclass

from percuss.model.checks import non_negative, positive, unit_interval

__all__ = ["Cushion"]


@dataclass(frozen=True)
class Cushion:
    """A cushion beyond the wall, such as oil that the piston traps when it goes forward without the tool.

    At the depth z it pushes a piston that goes in back with `force` + `stiffness` z, and one that comes out with the
    part `returned` of that. It begins at the wall or beyond, so that it takes nothing from a blow on the tool.

    Parameters
    ----------
    beyond
        Distance beyond the wall at which it begins, 0 or greater (dimensionless).
    force
        At its beginning, 0 or greater; dimensionless, as a load is.
    stiffness
        Increase of the force per depth, 0 or greater (dimensionless).
    length
        Depth at which the piston meets the front end of the housing, greater than 0; None for no end.
    returned
        Part of the energy that it gives back, from 0 (oil that is throttled) to 1 (a spring).
    area
        Of the piston's ring that presses on the oil (m²), where its pressure is to be told.

    Raises
    ------
    ParameterError
        When a number is out of range.

    Examples
    --------
    >>> Cushion(beyond=0.02, force=1.0, stiffness=50.0).energy(0.1)
    0.35
    """

    beyond: float = 0.0
    force: float = 0.0
    stiffness: float = 0.0
    length: float | None = None
    returned: float = 0.0
    area: float | None = None

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        for name in ("beyond", "force", "stiffness"):
            set_(self, name, non_negative(name, getattr(self, name)))
        set_(self, "returned", unit_interval("returned", self.returned))
        for name in ("length", "area"):
            if getattr(self, name) is not None:
                set_(self, name, positive(name, getattr(self, name)))

    def energy(self, depth: float) -> float:
        """What it takes from a piston that goes in to a depth, ∫ (force + stiffness z) dz.

        Raises
        ------
        ParameterError
            When the depth is negative.
        """
        depth = non_negative("depth", depth)
        return depth * (self.force + 0.5 * self.stiffness * depth)

    def scaled(self, force: float, length: float) -> Cushion:
        """The same cushion in other units of force and length; the area stays in m².

        Raises
        ------
        ParameterError
            When a number is not greater than 0.
        """
        force, length = positive("force", force), positive("length", length)
        end = None if self.length is None else self.length * length
        more = self.stiffness * force / length
        return Cushion(self.beyond * length, self.force * force, more, end, self.returned, self.area)
