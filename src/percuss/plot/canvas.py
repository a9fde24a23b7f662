"""The canvas of all pictures: figure, style, colours, saving. The only door to matplotlib."""

from __future__ import annotations

import io
import os
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING

from percuss.errors import MissingExtraError, ParameterError, PercussError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["COLOURS", "INK", "SUFFIXES", "new_figure", "save"]

SUFFIXES = (".png", ".svg", ".pdf")
"""What a picture can be saved as."""

INK = "#333333"

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
"""Okabe and Ito's palette, which people with any colour vision can tell apart."""

_STYLE = {
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "lines.linewidth": 1.4,
    "legend.edgecolor": "none",
    "legend.framealpha": 0.75,
    "mathtext.fontset": "dejavusans",
    "legend.fontsize": 7.5,
    "svg.fonttype": "none",
    "svg.hashsalt": "percuss",
    "path.simplify_threshold": 0.3,
}


def new_figure(width: float, height: float) -> Figure:
    """An empty figure of the given size in inches, without any global state (no pyplot).

    Raises
    ------
    MissingExtraError
        When matplotlib is not installed.
    """
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise MissingExtraError("matplotlib", "plot") from None
    return Figure(figsize=(width, height), layout="constrained")


def style() -> AbstractContextManager[None]:
    """A context in which things are drawn and saved in this package's style."""
    from matplotlib import rc_context

    return rc_context(_STYLE)  # type: ignore[arg-type]  # its keys are a long list of literals


def save(figure: Figure, path: str | os.PathLike[str]) -> Path:
    """Write a picture; the suffix says what it is: .png, .svg or .pdf.

    Returns
    -------
    Path
        Where it was written. The file is written in one go: nothing is left behind when drawing fails.

    Raises
    ------
    ParameterError
        For any other suffix.
    PercussError
        When the file cannot be written.
    """
    target = Path(path)
    suffix = target.suffix.lower()
    if suffix not in SUFFIXES:
        raise ParameterError("path", str(path), f"a name that ends in {', '.join(SUFFIXES)}")
    undated = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}, ".png": {}}[suffix]  # same answer, same bytes
    buffer = io.BytesIO()
    with style():
        figure.savefig(buffer, format=suffix[1:], dpi=150, metadata=undated)
    try:
        target.write_bytes(buffer.getvalue())
    except OSError as error:
        raise PercussError(f"{target}: cannot be written: {error.strerror or error}") from None
    return target
