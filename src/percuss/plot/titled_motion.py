"""What a picture of a motion is given: the motion, or the answer that holds it with the title of its case."""

from __future__ import annotations

from typing import Protocol, TypeVar, cast

from percuss.model.checks import having

__all__ = ["TitledMotion", "titled_motion"]

M = TypeVar("M")
M_co = TypeVar("M_co", covariant=True)


class TitledMotion(Protocol[M_co]):
    """An answer: a motion with the title of its case."""

    @property
    def motion(self) -> M_co: ...
    @property
    def title(self) -> str: ...


def titled_motion(shown: object, kind: type[M]) -> tuple[str, M]:
    """The title, "" for a motion alone, and the motion.

    Raises
    ------
    ParameterError
        When it is neither a motion of this kind nor an answer that holds one.
    """
    if isinstance(shown, kind):
        return "", shown
    having("motion", shown, ("title", "motion"), f"a {kind.__name__}, or the answer that holds one")
    answer = cast("TitledMotion[M]", shown)
    return answer.title, answer.motion
