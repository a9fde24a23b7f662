"""The contact: how the bar leaves the wall (B77 10)."""

from __future__ import annotations

from dataclasses import InitVar, dataclass

from percuss.errors import ParameterError
from percuss.model.checks import positive, unit_interval

__all__ = ["Contact"]


@dataclass(frozen=True)
class Contact:
    """Impact with restitution: the whole velocity field turns over, u_t → −R u_t.

    Parameters
    ----------
    restitution
        Coefficient of restitution R, from 0 to 1 (dimensionless).
    receiving_area, area
        Instead of `restitution`: the cross-sectional areas (m², or any one unit) of a long receiving rod of the
        same material and of the bar; then R = (A_s − A)/(A_s + A).

    Raises
    ------
    ParameterError
        When R is outside [0, 1], the receiving rod is thinner than the bar, or neither form is complete.

    Examples
    --------
    >>> print(Contact(receiving_area=32**2, area=22**2))
    Contact: restitution R = 0.3581
    """

    restitution: float = -1.0
    receiving_area: InitVar[float | None] = None
    area: InitVar[float | None] = None

    def __post_init__(self, receiving_area: float | None, area: float | None) -> None:
        restitution: object = self.restitution
        if receiving_area is not None:
            if restitution != -1.0:
                raise ParameterError("receiving_area", receiving_area, "either restitution or receiving_area, not both")
            if area is None:
                raise ParameterError("area", area, "the bar's own area beside receiving_area")
            receiving, own = positive("receiving_area", receiving_area), positive("area", area)
            if receiving < own:
                raise ParameterError(
                    "receiving_area",
                    receiving_area,
                    f"at least the bar's own area, {own:.4g}",
                    "a thinner receiving rod does not throw the bar back; give a restitution instead",
                )
            restitution = (receiving - own) / (receiving + own)
        elif restitution == -1.0:
            raise ParameterError("restitution", None, "a restitution from 0 to 1, or a receiving_area")
        object.__setattr__(self, "restitution", unit_interval("restitution", restitution))

    def __str__(self) -> str:
        return f"Contact: restitution R = {self.restitution:.4g}"


# The areas given only to make the contact are not kept as class attributes, where they would read as None.
for _name in ("receiving_area", "area"):
    delattr(Contact, _name)
