"""What the viewer needs to know of a sole."""

from __future__ import annotations

from typing import Protocol


class SoleShape(Protocol):
    """A foot's rectangle; `wbc.robot.Sole` is one."""

    @property
    def name(self) -> str:
        """Name of its frame in the model."""

    @property
    def side(self) -> str:
        """`left` or `right`."""

    @property
    def frame_id(self) -> int:
        """Index of its frame in the model."""

    @property
    def half_length(self) -> float:
        """Along its x, m."""

    @property
    def half_width(self) -> float:
        """Along its y, m."""
