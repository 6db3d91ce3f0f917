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
from wbc.view.browser import find_browser
from wbc.view.errors import ViewerError
from wbc.view.frame_rendering import rendered_frames, usable_cores
from wbc.view.video_format import VideoFormat

if TYPE_CHECKING:
    from wbc.view.recording import Recording

_FRAMES_PER_BROWSER = 50  # fewer are rendered sooner than another browser starts
#: ffmpeg's options by the file's suffix: H.264 with a constant rate factor, at 18 of which losses
#: are hardly visible, or GIF with the 128 colours that represent all of its frames best.
_ENCODINGS = {
    ".mp4": (
        *("-c:v", "libx264", "-pix_fmt", "yuv420p", "-crf", "19"),
        *("-movflags", "+faststart", "-f", "mp4"),
    ),
    ".gif": (
        *("-filter_complex", "split[a][b];[a]palettegen=128[p];[b][p]paletteuse=dither=none"),
        *("-loop", "0", "-f", "gif"),
    ),
}


class Video:
    """Renders recordings offline, with the recording's page in headless browsers.

    One browser for each core of the processor renders every n-th frame.

    Args:
        path: Path of the video, `.mp4` or `.gif`.
        video_format: Size, frame rate and camera.

    Raises:
        MissingExtra: `playwright` or `imageio-ffmpeg` is not installed.
        ViewerError: No browser is installed, or the file is neither MP4 nor GIF.
    """

    def __init__(self, path: str | Path, video_format: VideoFormat | None = None) -> None:
        self.path = Path(path)
        if self.path.suffix.lower() not in _ENCODINGS:
            raise ViewerError(f"{path} is neither .mp4 nor .gif; give the video such a name")
        self.format = VideoFormat() if video_format is None else video_format
        self._encoder = encoder()
        find_browser()

    def render(
        self, recording: Recording, progress: Callable[[int, int], None] | None = None
    ) -> Path:
        """Render the video; without a graphics card a frame takes half a second of a core.

        Args:
            recording: Recording to render.
            progress: Called with the number of rendered frames and of all frames.

        Returns:
            The path of the video.

        Raises:
            ViewerError: Nothing was recorded, or the browser or encoder fails.
        """
        with tempfile.TemporaryDirectory(prefix="wbc-video") as folder:
            page = recording.save(Path(folder) / "recording.html")
            duration = recording.times[-1] - recording.times[0]
            frames = int(duration * self.format.rate + 1e-6) + 1
            count = max(1, min(usable_cores(), frames // _FRAMES_PER_BROWSER))
            with replacing(self.path) as file, self._encoding(file) as frames_in:
                for k, frame in enumerate(rendered_frames(page, frames, self.format, count)):
                    frames_in.write(frame)
                    if progress is not None:
                        progress(k + 1, frames)
        return self.path

    @contextlib.contextmanager
    def _encoding(self, file: Path) -> Iterator[IO[bytes]]:
        """Yield the encoder's input.

        `imageio_ffmpeg.write_frames` does not report that the encoder has failed.
        """
        command = [
            self._encoder,
            *("-y", "-loglevel", "error", "-f", "image2pipe", "-c:v", "mjpeg"),
            *("-framerate", f"{self.format.rate:g}", "-i", "-"),
            *(*_ENCODINGS[self.path.suffix.lower()], str(file)),
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


def encoder() -> str:
    """Return the path of ffmpeg: the system's, or that of the package `imageio-ffmpeg`."""
    found = shutil.which("ffmpeg")
    if found is not None:
        return found
    if importlib.util.find_spec("imageio_ffmpeg") is None:
        raise MissingExtra("imageio-ffmpeg", "video")
    import imageio_ffmpeg

    return str(imageio_ffmpeg.get_ffmpeg_exe())
