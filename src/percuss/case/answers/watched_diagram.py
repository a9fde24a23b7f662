"""A diagram that is watched: what is settled on so far while it goes on, the same numbers at its end."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from percuss.explore import Diagram
    from percuss.explore.diagrams.diagram_job import DiagramJob

__all__ = ["watched_diagram"]


def watched_diagram(job: DiagramJob, stopped: Callable[[], bool]) -> Iterator[Diagram]:
    """Carry out a diagram item by item; the last one yielded is whole.

    Parameters
    ----------
    job
        The diagram.
    stopped
        Asked now and then; when it says so nothing more is yielded.

    Examples
    --------
    >>> from percuss.case import diagram_job_of, load_case
    >>> sizes = {"up_to": None, "starts": 2, "runs": 0, "modes": 0}
    >>> job = diagram_job_of(load_case("pneumatic-jackleg"), "load_factor=0.38:0.4:3", **sizes)
    >>> [look.done for look in watched_diagram(job, lambda: False)]
    [0.5, 1.0]
    """
    from percuss.explore import Diagram

    columns = {
        name: np.full((job.size, *column.shape), column.empty, dtype=column.dtype)
        for name, column in job.columns.items()
    }
    columns["branch_bytes"][...] = -1  # not done
    for i in range(job.size):
        row = job.compute(i, i + 1, stopped)
        if stopped():
            return
        for name, values in row.items():
            columns[name][i] = values[0]
        yield Diagram.of(job, columns)
