"""The bar of a case in SI drawn to scale: sections and bores, the load where it acts, the wall, as an SVG."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from percuss.model import System
    from percuss.model.body.uniform import Piece

_ROOM = 0.06  # around the bar, as a share of its length: for the arrow of the load, and the wall


def bar_outline(system: System) -> str:
    """A bar in SI, driven end left, as SVG; areas are drawn as round ones. ParameterError without sizes."""
    bar, scale = system.bar, 1000.0 / system.length_scale
    assert bar is not None  # else it has no length
    room, half = 1000.0 * _ROOM, 0.5 * scale * max(piece.diameter for piece in bar.pieces)
    high = half + 20.0
    parts = [_section(piece, scale) for piece in bar.pieces]
    place = 1000.0 * system.body.place(system.load.at)
    driven = 0.5 * scale * bar.pieces[system.load.at].diameter
    parts.append(_load(place, 0.0 if system.load.at == 0 else 0.75 * driven))
    parts.append(
        f'<rect x="1004" y="{-high:.6g}" width="14" height="{2.0 * high:.6g}" fill="currentColor" opacity="0.5"/>'
    )
    box = f"{-room:.6g} {-high:.6g} {1000.0 + 2.0 * room:.6g} {2.0 * high:.6g}"
    return (
        f'<svg class="outline" role="img" viewBox="{box}" xmlns="http://www.w3.org/2000/svg">'
        f"<title>The bar to scale, {1e3 * bar.length:.4g} mm long; load from the left, wall on the right</title>"
        f"{''.join(parts)}</svg>"
    )


def _section(piece: Piece, scale: float) -> str:
    x, width = scale * piece.start, scale * (piece.end - piece.start)
    outer, bore = scale * piece.diameter, scale * piece.bore
    told = f"{1e3 * (piece.end - piece.start):.4g} mm, {1e6 * piece.area:.4g} mm²"
    drawn = (
        f'<rect x="{x:.6g}" y="{-0.5 * outer:.6g}" width="{width:.6g}" height="{outer:.6g}" fill="currentColor" '
        f'fill-opacity="0.12" stroke="currentColor" stroke-width="2"><title>{told}</title></rect>'
    )
    for side in (-0.5, 0.5) if bore else ():
        drawn += (
            f'<line x1="{x:.6g}" x2="{x + width:.6g}" y1="{side * bore:.6g}" y2="{side * bore:.6g}" '
            f'stroke="currentColor" stroke-dasharray="8 6"/>'
        )
    return drawn


def _load(place: float, off: float) -> str:
    """Arrows at the load's place: one on the axis, or one on either side of it for a shoulder."""
    arrows = ""
    for y in sorted({-off, off}):
        path = f"M{place - 48:.6g} {y:.6g}H{place - 6:.6g}m-12 -7l12 7l-12 7"
        arrows += f'<path d="{path}" fill="none" stroke="currentColor" stroke-width="4"/>'
    return arrows
