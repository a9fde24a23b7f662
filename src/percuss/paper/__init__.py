"""B77's figures and claims, reproduced: thin scripts over the floors below."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from percuss.errors import ParameterError

if TYPE_CHECKING:
    from percuss.paper.figure import PaperFigure

__all__ = ["CLAIMS", "FIGURES", "NAMES", "figures", "write_figures"]

FIGURES = ("fig2", "fig3", "fig4", "fig5", "fig6", "fig7", "fig8", "elastic")  # the figures

CLAIMS = "claims"  # the numerical experiments on what B77 claims; `percuss.paper.claims` runs them

NAMES = (*FIGURES, CLAIMS)  # all that can be made


def figures(name: str, seed: int = 1977) -> tuple[PaperFigure, ...]:
    """Compute one of the figures, which may be several pictures.

    Parameters
    ----------
    name
        One of `FIGURES`.
    seed
        Of the random numbers, where a figure needs some.

    Examples
    --------
    >>> from percuss.paper import figures
    >>> figure, = figures("fig5")
    >>> list(figure.columns), figure.rows
    (['restitution', 'lower', 'upper', 'lower_damped', 'upper_damped'], 100)
    """
    if name not in FIGURES:
        raise ParameterError("name", name, f"one of {', '.join(FIGURES)}")
    from percuss.paper import published_figures

    if name == "elastic":
        return published_figures.elastic(seed)
    return (getattr(published_figures, name)(seed),)


def write_figures(names: Sequence[str], directory: str | Path, seed: int = 1977) -> Iterator[Path]:
    """Compute figures and write each as CSV, SVG and PNG; yields every file when it is there.

    Parameters
    ----------
    names
        Some of `FIGURES`.

    Raises
    ------
    MissingExtraError
        When matplotlib is not installed.
    PercussError
        When a file cannot be written.
    """
    for name in names:
        for figure in figures(name, seed):
            yield from figure.write(directory)
