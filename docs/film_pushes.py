"""Films robots that are pushed, for the README: `python docs/film_pushes.py`.

Needs `pip install 'wbc[all]'` and a chromium; writes docs/pushes.gif.
"""

from __future__ import annotations

import subprocess
import tempfile
from pathlib import Path

import wbc
from wbc.sim import Mujoco
from wbc.view import Recording, Video, VideoFormat
from wbc.view.video import encoder

HERE = Path(__file__).parent
RATE = 10.0  # Hz
SIZE = (360, 320)  # pixels
DISTANCES = {"g1": 3.4, "talos": 4.6}  # m, of the camera
#: Robot, time of each push, s, and its impulse in N·s per kg of the robot.
PUSHES = {
    "g1": ((1.5, (0.0, 0.7, 0.0)), (4.0, (0.8, 0.0, 0.0))),
    "talos": ((1.5, (0.0, -0.5, 0.0)), (4.0, (0.8, 0.0, 0.0))),
}
DURATION = 6.5  # s


def film(name: str, path: Path) -> None:
    """Render a walk with pushes."""
    robot = wbc.load(name)
    plant, walker, recording = Mujoco(robot), wbc.Walker(robot), Recording(robot, rate=RATE)
    for time, per_mass in PUSHES[name]:
        plant.schedule_push(time, [robot.mass * value for value in per_mass])
    walker.velocity = (0.3, 0.0, 0.0)
    report = wbc.run(walker, plant, DURATION, observers=[recording])
    if not report.survived:
        raise SystemExit(f"{name} fell: {report.fell_why}")
    video_format = VideoFormat(SIZE, RATE, camera=(-35.0, 12.0, DISTANCES[name]))
    Video(path, video_format).render(recording, lambda k, n: print(f"{name}: frame {k} of {n}"))


def main() -> None:
    """Film all robots, side by side."""
    with tempfile.TemporaryDirectory() as folder:
        films = [Path(folder) / f"{name}.mp4" for name in PUSHES]
        for name, path in zip(PUSHES, films, strict=True):
            film(name, path)
        inputs = [argument for path in films for argument in ("-i", str(path))]
        chain = "hstack,split[a][b];[a]palettegen=48[p];[b][p]paletteuse=dither=none"
        command = [encoder(), "-y", "-loglevel", "error", *inputs, "-filter_complex", chain]
        subprocess.run([*command, "-loop", "0", str(HERE / "pushes.gif")], check=True)


if __name__ == "__main__":
    main()
