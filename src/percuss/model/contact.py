"""The contact: how the bar leaves the wall (B77 10)."""

from __future__ import annotations

from dataclasses import dataclass

from percuss.errors import ParameterError
from percuss.model.checks import positive, unit_interval

__all__ = ["Contact"]


@dataclass(frozen=True, init=False)
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

    restitution: float

    def __init__(
        self,
        restitution: float | None = None,
        *,
        receiving_area: float | None = None,
        area: float | None = None,
    ) -> None:
        if restitution is not None and receiving_area is not None:
            raise ParameterError("receiving_area", receiving_area, "either restitution or receiving_area, not both")
        if receiving_area is not None:
            if area is None:
                raise ParameterError("area", area, "the bar's own area beside receiving_area")
            restitution = _of_areas(positive("receiving_area", receiving_area), positive("area", area))
        elif restitution is None:
            raise ParameterError("restitution", None, "a restitution from 0 to 1, or a receiving_area")
        object.__setattr__(self, "restitution", unit_interval("restitution", restitution))

    def __str__(self) -> str:
        return f"Contact: restitution R = {self.restitution:.4g}"


def _of_areas(receiving: float, own: float) -> float:
    if receiving < own:
        raise ParameterError(
            "receiving_area",
            receiving,
            f"at least the bar's own area, {own:.4g}",
            "a bar does not rebound from a thinner rod; give a restitution instead",
        )
    return (receiving - own) / (receiving + own)
