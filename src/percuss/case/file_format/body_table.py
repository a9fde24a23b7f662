"""The table [body] of a case: a structure that something holds, in place of a free bar."""

from __future__ import annotations

from typing import Literal

from percuss.case.file_format.values import Mass, NumberOrDashpot, NumberOrLength, NumberOrStiffness, Numbers, Table

__all__ = ["BodyTable"]


class BodyTable(Table):
    kind: Literal["modes", "mounted"]
    """`"modes"`: a structure told by a table of its modes. `"mounted"`: a bar, or a rigid mass, on a spring and a
    dashpot at its driven end."""
    gap: NumberOrLength | None = None
    """Distance from the contact to the wall without any force; negative where the wall presses. With its unit in SI.
    When left out: no gap."""
    file: str | None = None
    """With `"modes"`: the file of the table, CSV with the columns `omega`, `damping`, `contact` and `drive`, looked for
    in the folder of the case. When left out: the four columns are given here."""
    omega: Numbers | None = None
    r"""With `"modes"`: frequencies $\omega_n$ in rad/s, or per radian of the load. Allowed: positive ones. When left
    out: `file` is needed."""
    damping: Numbers | None = None
    r"""With `"modes"`: $\delta_n = 2\zeta_n\omega_n$ in 1/s, or per radian of the load. Allowed: none of them negative.
    When left out: `file` is needed."""
    contact: Numbers | None = None
    r"""With `"modes"`: $a_n$, each mode where the structure strikes, normalised to the modal mass 1 kg, or 1. When left
    out: `file` is needed."""
    drive: Numbers | None = None
    """With `"modes"`: $b_n$, each mode where the load acts. When left out: `file` is needed."""
    spring: NumberOrStiffness | None = None
    r"""With `"mounted"`: the stiffness $k$ of the spring in N/m, or $k/(M\Omega^2)$. Allowed: greater than 0."""
    dashpot: NumberOrDashpot | None = None
    r"""With `"mounted"`: the force per velocity $c$ of the dashpot in N·s/m, or $c/(M\Omega)$. Allowed: 0 or greater.
    When left out: no dashpot."""
    mass: Mass | None = None
    """With `"mounted"` in SI, without `[bar]`: the rigid mass. When left out: `[bar]` is needed."""
