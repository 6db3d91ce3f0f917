"""`Video`: a recording, rendered frame by frame into a video."""

from __future__ import annotations

import contextlib
import importlib.util
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, TYPE_CHECKING

from wbc.errors import MissingExtra
from wbc.view.browser import check_browser, new_page
from wbc.view.errors import ViewerError

if TYPE_CHECKING:
    from wbc.view.recording import Recording

_PATIENCE = 180_000  # ms, for the page to be complete; software rendering takes its time
_QUALITY = 92  # of the pictures on their way to the encoder, of 100
_RATE_FACTOR = 19  # of H.264: 18 is nearly without visible loss


class Video:
    """Renders recordings offline, by the recording's own page in a browser without a window.

    Args:
        path: of the video, `.mp4`.
        width: pixels, even.
        height: pixels, even.

    Raises:
        MissingExtra: `playwright` or `imageio-ffmpeg` is not installed.
        ViewerError: there is no browser, or the size is odd or not positive.
    """

    def __init__(self, path: str | Path, width: int = 1280, height: int = 720) -> None:
        for name, pixels in (("width", width), ("height", height)):
            if pixels <= 0 or pixels % 2:
                raise ViewerError(f"{name} is {pixels} pixels; a video needs an even number")
        self.path = Path(path)
        self._size = (width, height)
        self._encoder = _encoder()
        check_browser()

    def render(
        self, recording: Recording, progress: Callable[[int, int], None] | None = None
    ) -> Path:
        """Make the video; a frame takes a good part of a second without a graphics card.

        Args:
            recording: what to show, at its own rate.
            progress: called with the number of frames that are done, and of all.

        Returns:
            The path of the video.

        Raises:
            ViewerError: nothing was recorded, or browser or encoder fail.
        """
        with tempfile.TemporaryDirectory(prefix="wbc-video") as folder:
            page_path = recording.save(Path(folder) / "recording.html")
            with new_page(*self._size) as page, self._encoding(recording.rate) as frames_in:
                page.set_default_timeout(_PATIENCE)
                page.goto(page_path.as_uri())
                page.wait_for_function("wbc.ready")
                frames = int(page.evaluate("wbc.videoMode()") * recording.rate + 1e-6) + 1
                for k in range(frames):
                    page.evaluate("(time) => wbc.seek(time)", k / recording.rate)
                    frames_in.write(page.screenshot(type="jpeg", quality=_QUALITY))
                    if progress is not None:
                        progress(k + 1, frames)
        return self.path

    @contextlib.contextmanager
    def _encoding(self, rate: float) -> Iterator[IO[bytes]]:
        """The encoder's input; the file is there when this ends well, and not otherwise."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        command = [
            self._encoder,
            *("-y", "-loglevel", "error", "-f", "image2pipe", "-c:v", "mjpeg"),
            *("-framerate", f"{rate:g}", "-i", "-"),
            *("-c:v", "libx264", "-pix_fmt", "yuv420p", "-crf", str(_RATE_FACTOR)),
            *("-movflags", "+faststart", "-f", "mp4", str(self.path)),
        ]
        encoder = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE)
        assert encoder.stdin is not None
        assert encoder.stderr is not None
        try:
            yield encoder.stdin
            encoder.stdin.close()
        except BrokenPipeError:
            pass  # it has ended before its time: below it says why
        except BaseException:
            encoder.kill()
            encoder.wait()
            self.path.unlink(missing_ok=True)
            raise
        said = encoder.stderr.read().decode("utf-8", "replace").strip()
        if encoder.wait() != 0:
            self.path.unlink(missing_ok=True)
            raise ViewerError(f"the video {self.path} cannot be made: {said.splitlines()[-1:]}")


def _encoder() -> str:
    """Path of ffmpeg: the system's, or that of the package that brings one."""
    found = shutil.which("ffmpeg")
    if found is not None:
        return found
    if importlib.util.find_spec("imageio_ffmpeg") is None:
        raise MissingExtra("imageio-ffmpeg", "video")
    import imageio_ffmpeg

    return str(imageio_ffmpeg.get_ffmpeg_exe())
