"""Forces and waves of a blow over time, as a dataset for files."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.errors import MissingExtraError

if TYPE_CHECKING:
    import xarray

    from percuss.blow import Trace
    from percuss.case.answers.blow_answer import BlowAnswer

__all__ = ["POINTS", "blow_dataset"]

POINTS = 4001
"""Equal steps of the window, less one."""


def blow_dataset(answer: BlowAnswer) -> xarray.Dataset:
    """Forces, waves and penetration at equal steps of the window; at a jump the later value.

    Raises
    ------
    MissingExtraError
        Without xarray.
    """
    try:
        import xarray
    except ImportError:
        raise MissingExtraError("xarray", "io") from None
    blow, waves, si = answer.blow, answer.waves, answer.is_si
    time = np.linspace(0.0, blow.until, POINTS)
    force = "N" if si else "1"
    traces: dict[str, tuple[Trace, str, str]] = {"face_force": (blow.face_force, force, "force between the faces")}
    if waves is not None:
        traces["incident"] = (waves.incident, force, "force of the wave from the face, at the gauge")
        traces["reflected"] = (waves.reflected, force, "force of the wave that comes back, at the gauge")
    if blow.bit_force is not None and blow.penetration is not None:
        traces["bit_force"] = (blow.bit_force, force, "force on the rock")
        traces["penetration"] = (blow.penetration, "m" if si else "1", "place of the bit, from the rock's surface")
    variables: dict[str, Any] = {
        name: ("time", trace.at(time), {"units": unit, "long_name": meaning})
        for name, (trace, unit, meaning) in traces.items()
    }
    about = {"units": "s" if si else "1", "long_name": "time from the start of the window"}
    attributes = {"title": answer.title, "answer": json.dumps(answer.to_json_dict(), allow_nan=False)}
    return xarray.Dataset(variables, {"time": ("time", time, about)}, attributes)
