"""What a blow hands to its pictures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from percuss.blow import Blow, Peak, Rod, Waves
    from percuss.model.body.sized import Piece

__all__ = ["ShownBlow"]


class ShownBlow(Protocol):
    """What an answer hands to its picture: a blow, a gauge on its rod, sections with their sizes, words for values."""

    @property
    def title(self) -> str: ...
    @property
    def blow(self) -> Blow: ...
    @property
    def gauge(self) -> float | None: ...
    @property
    def is_si(self) -> bool: ...
    @property
    def waves(self) -> Waves | None: ...
    @property
    def rod(self) -> Rod | None: ...
    @property
    def pieces(self) -> tuple[tuple[Piece, ...], tuple[Piece, ...]]: ...
    @property
    def peaks(self) -> tuple[tuple[Peak, ...], tuple[Peak, ...]]: ...
    @property
    def units(self) -> Any: ...
    @property
    def measured(self) -> Any: ...
    @property
    def beta(self) -> float | None: ...
