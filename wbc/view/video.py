"""`Video`: a recording rendered to a video frame by frame."""

from __future__ import annotations

import contextlib
import importlib.util
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, TYPE_CHECKING

from wbc.atomic_file import replacing
from wbc.errors import MissingExtra
from wbc.view.browser import find_browser, new_page
from wbc.view.errors import ViewerError

if TYPE_CHECKING:
    from wbc.view.recording import Recording

_PAGE_TIMEOUT = 180_000  # ms, for the page to load, which software rendering makes slow
_QUALITY = 92  # JPEG quality of the frames sent to the encoder, of 100
_RATE_FACTOR = 19  # constant rate factor of H.264; at 18 losses are hardly visible


class Video:
    """Renders recordings offline, with the recording's page in a headless browser.

    Args:
        path: Path of the video, `.mp4`.
        width: Width, pixels, even.
        height: Height, pixels, even.

    Raises:
        MissingExtra: `playwright` or `imageio-ffmpeg` is not installed.
        ViewerError: No browser is installed, or the size is odd or not positive.
    """

    def __init__(self, path: str | Path, width: int = 1280, height: int = 720) -> None:
        for name, pixels in (("width", width), ("height", height)):
            if pixels <= 0 or pixels % 2:
                raise ViewerError(f"{name} is {pixels} pixels; a video needs an even number")
        self.path = Path(path)
        self._size = (width, height)
        self._encoder = _encoder()
        find_browser()

    def render(
        self, recording: Recording, progress: Callable[[int, int], None] | None = None
    ) -> Path:
        """Render the video; without a graphics card a frame takes up to a second.

        Args:
            recording: Recording to render, at its frame rate.
            progress: Called with the number of rendered frames and of all frames.

        Returns:
            The path of the video.

        Raises:
            ViewerError: Nothing was recorded, or the browser or encoder fails.
        """
        with tempfile.TemporaryDirectory(prefix="wbc-video") as folder:
            page_path = recording.save(Path(folder) / "recording.html")
            with (
                new_page(*self._size) as page,
                replacing(self.path) as file,
                self._encoding(recording.rate, file) as frames_in,
            ):
                page.set_default_timeout(_PAGE_TIMEOUT)
                page.goto(page_path.as_uri())
                page.wait_for_function("wbc.ready")
                start, end = page.evaluate("[wbc.player.start, wbc.player.end]")
                frames = int((end - start) * recording.rate + 1e-6) + 1
                for k in range(frames):
                    page.evaluate("(time) => wbc.drawFrame(time)", start + k / recording.rate)
                    frames_in.write(page.screenshot(type="jpeg", quality=_QUALITY))
                    if progress is not None:
                        progress(k + 1, frames)
        return self.path

    @contextlib.contextmanager
    def _encoding(self, rate: float, file: Path) -> Iterator[IO[bytes]]:
        """Yield the encoder's input.

        `imageio_ffmpeg.write_frames` does not report that the encoder has failed.
        """
        command = [
            self._encoder,
            *("-y", "-loglevel", "error", "-f", "image2pipe", "-c:v", "mjpeg"),
            *("-framerate", f"{rate:g}", "-i", "-"),
            *("-c:v", "libx264", "-pix_fmt", "yuv420p", "-crf", str(_RATE_FACTOR)),
            *("-movflags", "+faststart", "-f", "mp4", str(file)),
        ]
        encoder = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE)
        assert encoder.stdin is not None
        assert encoder.stderr is not None
        try:
            yield encoder.stdin
            encoder.stdin.close()
        except BrokenPipeError:
            pass  # the encoder has ended early; its output below states why
        except BaseException:
            encoder.kill()
            encoder.wait()
            raise
        said = encoder.stderr.read().decode("utf-8", "replace").strip()
        if encoder.wait() != 0:
            raise ViewerError(f"the video {self.path} cannot be encoded: {said.splitlines()[-1:]}")


def _encoder() -> str:
    """Return the path of ffmpeg: the system's, or that of the package `imageio-ffmpeg`."""
    found = shutil.which("ffmpeg")
    if found is not None:
        return found
    if importlib.util.find_spec("imageio_ffmpeg") is None:
        raise MissingExtra("imageio-ffmpeg", "video")
    import imageio_ffmpeg

    return str(imageio_ffmpeg.get_ffmpeg_exe())
