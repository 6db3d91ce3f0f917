"""Frames of a recording's page, rendered by several headless browsers at the same time."""

from __future__ import annotations

import contextlib
import os
import queue
import threading
from collections.abc import Iterator
from pathlib import Path

from wbc.view.browser import new_page
from wbc.view.video_format import VideoFormat

_PAGE_TIMEOUT = 180_000  # ms, for the page to load, which software rendering makes slow
_QUALITY = 92  # JPEG quality, of 100
_AHEAD = 4  # frames that a browser may render before they are asked for
_POLL = 0.5  # s


def usable_cores() -> int:
    """Return the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def rendered_frames(
    page: Path, frames: int, video_format: VideoFormat, browsers: int
) -> Iterator[bytes]:
    """Yield the frames of a recording in order, as JPEG.

    Args:
        page: file of the recording's page.
        frames: number of frames.
        video_format: size, frame rate and camera.
        browsers: number of browsers; browser i renders the frames i, i + n, i + 2 n …

    Raises:
        WbcError: a browser does not start.
        playwright.sync_api.Error: a page cannot be rendered.
    """
    stop = threading.Event()
    renderers = [
        _FrameRenderer(page, range(i, frames, browsers), video_format, stop)
        for i in range(browsers)
    ]
    try:
        for renderer in renderers:
            renderer.start()
        for k in range(frames):
            yield renderers[k % browsers].take()
    finally:
        stop.set()
        for renderer in renderers:
            renderer.join()


class _FrameRenderer(threading.Thread):
    """Renders some frames in a browser of its own; playwright's objects belong to one thread."""

    def __init__(
        self, page: Path, frames: range, video_format: VideoFormat, stop: threading.Event
    ) -> None:
        super().__init__(daemon=True)
        self._page, self._frames, self._format, self._stop_event = page, frames, video_format, stop
        self._rendered: queue.Queue[bytes | BaseException] = queue.Queue(_AHEAD)

    def take(self) -> bytes:
        """Return the next frame; raise what ended the thread."""
        frame = self._rendered.get()
        if isinstance(frame, BaseException):
            raise frame
        return frame

    def run(self) -> None:
        """Render the frames until they are complete or nobody wants them any more."""
        try:
            for frame in self._render():
                self._put(frame)
                if self._stop_event.is_set():
                    return
        except Exception as error:
            self._put(error)

    def _put(self, item: bytes | BaseException) -> None:
        while not self._stop_event.is_set():
            with contextlib.suppress(queue.Full):
                return self._rendered.put(item, timeout=_POLL)
        return None

    def _render(self) -> Iterator[bytes]:
        with new_page(*self._format.size) as page:
            page.set_default_timeout(_PAGE_TIMEOUT)
            page.goto(self._page.as_uri())
            page.wait_for_function("wbc.ready")
            page.evaluate("(camera) => wbc.prepareVideo(camera)", self._format.camera)
            start = page.evaluate("wbc.player.start")
            for k in self._frames:
                page.evaluate("(time) => wbc.drawFrame(time)", start + k / self._format.rate)
                yield page.screenshot(type="jpeg", quality=_QUALITY)
