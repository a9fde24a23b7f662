"""A hammer in SI drawn to scale: sections and bores of bar and tool, the load where it acts, lengths, as an SVG."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from percuss.model import System

if TYPE_CHECKING:
    from percuss.model import Machine
    from percuss.model.body.uniform import Piece

_ROOM = 60.0  # around the drawing, which is 1000 wide: for the arrow of the load, and the wall
_TEXT = 20.0  # size of letters
_ENDLESS = 0.3  # of all other lengths: what is drawn of an endless section


def bar_outline(hammer: System | Machine, tool: Sequence[Piece] = (), words: Callable[[str], str] = str) -> str:
    """The bar of a hammer in SI, driven end left, and what it strikes: a tool of sections, or a wall.

    Sections are numbered from 0 where there is room, with the lengths of bar and tool below; areas are drawn as round
    ones. ParameterError without sizes.
    """
    length = hammer.length_scale  # which refuses one without sizes
    bar, at = hammer.bar, hammer.load.at if isinstance(hammer, System) else hammer.at
    assert bar is not None
    finite = length + sum(piece.end - piece.start for piece in tool if math.isfinite(piece.end))
    whole = finite + _ENDLESS * finite * any(math.isinf(piece.end) for piece in tool)
    scale = 1000.0 / whole
    half = 0.5 * scale * max(piece.diameter for piece in (*bar.pieces, *tool))
    high = half + 5.0 + 1.2 * _TEXT
    parts = [_section(piece, i, 0.0, scale, scale * whole, words) for i, piece in enumerate(bar.pieces)]
    ends = [(0.0, scale * length, f"bar {1e3 * length:.4g} mm")]
    if tool:
        start = scale * length
        parts += [_section(piece, i, start, scale, 1000.0, words) for i, piece in enumerate(tool)]
        told = "endless tool" if whole > finite else f"tool {1e3 * (finite - length):.4g} mm"
        ends.append((start, 1000.0, told))
        parts.append(f'<line x1="{start:.6g}" x2="{start:.6g}" y1="{-high:.6g}" y2="{high:.6g}" {_STROKE}/>')
    else:
        parts.append(
            f'<rect x="1004" y="{-high:.6g}" width="14" height="{2.0 * high:.6g}" fill="currentColor" opacity="0.5"/>'
        )
    driven = 0.5 * scale * bar.pieces[at].diameter
    parts.append(_load(scale * length * hammer.body.place(at), 0.0 if at == 0 else 0.75 * driven))
    below = high + _TEXT
    parts += [
        _dimension(low, high_, below + (i % 2) * 2.2 * _TEXT, words(text)) for i, (low, high_, text) in enumerate(ends)
    ]
    bottom = below + (2.2 * (len(ends) - 1) + 1.6) * _TEXT
    box = f"{-_ROOM:.6g} {-high:.6g} {1000.0 + 2.0 * _ROOM:.6g} {high + bottom:.6g}"
    right = "the tool" if tool else "wall"
    title = f"The bar to scale, {1e3 * length:.4g} mm long; load from the left, {right} on the right"
    return (
        f'<svg class="outline" role="img" viewBox="{box}" xmlns="http://www.w3.org/2000/svg">'
        f"<title>{words(title)}</title>"
        f"{''.join(parts)}</svg>"
    )


_STROKE = 'stroke="currentColor" stroke-width="3"'


def _section(piece: Piece, number: int, start: float, scale: float, last: float, words: Callable[[str], str]) -> str:
    x = start + scale * piece.start
    width = (last if math.isinf(piece.end) else start + scale * piece.end) - x
    outer, bore = scale * piece.diameter, scale * piece.bore
    told = f"{1e3 * (piece.end - piece.start):.4g} mm, {1e6 * piece.area:.4g} mm²"
    drawn = (
        f'<rect x="{x:.6g}" y="{-0.5 * outer:.6g}" width="{width:.6g}" height="{outer:.6g}" fill="currentColor" '
        f'fill-opacity="0.12" stroke="currentColor" stroke-width="2"><title>{words(told)}</title></rect>'
    )
    for side in (-0.5, 0.5) if bore else ():
        drawn += (
            f'<line x1="{x:.6g}" x2="{x + width:.6g}" y1="{side * bore:.6g}" y2="{side * bore:.6g}" '
            f'stroke="currentColor" stroke-dasharray="8 6"/>'
        )
    if width > 0.7 * _TEXT * len(str(number)) + 4.0:
        drawn += _words(x + 0.5 * width, -0.5 * outer - 5.0, str(number))
    return drawn


def _words(x: float, y: float, text: str) -> str:
    return (
        f'<text x="{x:.6g}" y="{y:.6g}" font-size="{_TEXT:g}" text-anchor="middle" fill="currentColor" '
        f'font-family="sans-serif">{text}</text>'
    )


def _dimension(low: float, high: float, y: float, text: str) -> str:
    """A length between two ends, its text below and inside the drawing."""
    lines = f"M{low:.6g} {y:.6g}H{high:.6g}M{low:.6g} {y - 7.0:.6g}v14M{high:.6g} {y - 7.0:.6g}v14"
    half = 0.3 * _TEXT * len(text)
    middle = min(max(0.5 * (low + high), half - _ROOM), 1000.0 + _ROOM - half)
    drawn = f'<path d="{lines}" fill="none" stroke="currentColor"/>' + _words(middle, y + 1.2 * _TEXT, text)
    return f"<g>{drawn}</g>"


def _load(place: float, off: float) -> str:
    """Arrows at the load's place: one on the axis, or one on either side of it for a shoulder."""
    arrows = ""
    for y in sorted({-off, off}):
        path = f"M{place - 48:.6g} {y:.6g}H{place - 6:.6g}m-12 -7l12 7l-12 7"
        arrows += f'<path d="{path}" fill="none" stroke="currentColor" stroke-width="4"/>'
    return arrows
