"""Size, frame rate and camera of a video."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wbc.view.errors import ViewerError


@dataclass(frozen=True)
class VideoFormat:
    """Size, frame rate and camera of a video.

    Attributes:
        size: width and height, pixels, even numbers.
        rate: frames per second; a GIF shows 50 at most.
        camera: azimuth from the robot's front to its left, degrees, elevation, degrees, and
            distance from the robot, m; None: the view that a page opens with.

    Raises:
        ViewerError: an attribute is out of range.
    """

    size: tuple[int, int] = (960, 540)
    rate: float = 25.0
    camera: tuple[float, float, float] | None = None

    def __post_init__(self) -> None:
        for name, pixels in zip(("width", "height"), self.size, strict=True):
            if pixels <= 0 or pixels % 2:
                raise ViewerError(f"{name} is {pixels} pixels; a video needs an even number")
        if not 0.0 < self.rate <= 240.0:
            raise ViewerError(f"the rate is {self.rate:g} Hz; a video needs one of 240 at most")
        if self.camera is None:
            return
        _, elevation, distance = self.camera
        if not np.isfinite(self.camera).all() or abs(elevation) > 89.0 or not distance > 0.0:
            raise ViewerError(
                f"the camera is at {self.camera}; it needs an elevation within 89° and a "
                "positive distance"
            )
