"""Renders an image of each motion at a characteristic moment.

Every motion is played in MuJoCo with noisy sensors and the estimator and recorded. The page of the
recording is rendered in a headless browser: the robot, the path of its centre of mass, DCM, ZMP,
contact forces and the support polygon.

    python benchmarks/gallery.py                  # docs/motions/*.png and docs/motions.png
    python benchmarks/gallery.py --motion jump    # only this one; keeps the overview
"""

from __future__ import annotations

import argparse
import base64
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import wbc
from wbc.motions import (
    Bow,
    Brace,
    Carry,
    HoldHand,
    Jump,
    Keyframes,
    Look,
    Motion,
    MotionPlayer,
    OneLeg,
    PushCart,
    Reach,
    Sine,
    Squat,
    StepInPlace,
    Sway,
    Wave,
)
from wbc.motions.jumping import JumpController, JumpPhase
from wbc.runtime.loop import RunComplete
from wbc.sim import Cart, Flat, Terrain, Wall
from wbc.trials import MotionRunner
from wbc.view import Recording
from wbc.view.browser import new_page

ROOT = Path(__file__).resolve().parents[1]
SIZE = (480, 600)  # pixels of a picture
COLUMNS, OVERVIEW_WIDTH, GAP = 4, 300, 14
PAGE_TIMEOUT = 240_000  # ms: meshes are rendered in software
MAX_DURATION = 30.0  # s of a run
STATUS_CSS = "#status { max-width: none; left: 8px; top: 8px; padding: 3px 8px; font-size: 11px; }"
#: Moves the camera: turned about the robot, and scaled in distance and height.
MOVE_CAMERA = """([turn, nearer, lower]) => {
  const p = viewer.camera.position, c = Math.cos(turn), s = Math.sin(turn);
  p.set(nearer * (c * p.x + s * p.z), nearer * lower * p.y, nearer * (c * p.z - s * p.x));
  viewer.camera.updateProjectionMatrix();
  viewer.set_dirty();
}"""

_FLAT = Flat()

Moment = Callable[[float, MotionPlayer], bool]


@dataclass(frozen=True)
class Scene:
    """The motion, the moment and the camera of an image.

    Attributes:
        name: Name of the file.
        caption: Caption, one sentence.
        command: Command that plays the motion, without `wbc motion`.
        robot: Name of the robot.
        motion: Motion to play.
        moment: Returns whether to take the image, given the time (s) and the player.
        turn: Angle of the camera about the robot, rad.
        nearer: Distance of the camera relative to the page's default.
        lower: Height of the camera relative to the page's default.
        terrain: Obstacles; see `wbc.sim.Terrain`.
        cart: An object to push.
    """

    name: str
    caption: str
    command: str
    robot: str
    motion: Motion
    moment: Moment
    turn: float = 0.0
    nearer: float = 0.8
    lower: float = 1.0
    terrain: Terrain = _FLAT
    cart: Cart | None = None


def after(seconds: float) -> Moment:
    """Return the moment at a time of the run, s."""
    return lambda time, player: time >= seconds


def at_the_top(time: float, player: MotionPlayer) -> bool:
    """Return whether the robot is in flight and has passed the apex."""
    context = player.context
    if (
        not isinstance(context.override, JumpController)
        or context.override.phase is not JumpPhase.FLIGHT
    ):
        return False
    assert context.state is not None
    return bool(wbc.Kinematics(context.robot, context.state).v_com[2] <= 0.0)


def on_one_leg(time: float, player: MotionPlayer) -> bool:
    """Return whether a foot is lifted and a push has been applied."""
    return player.context.stance.lifted is not None and len(player.context.pushes) > 0


def stepping(time: float, player: MotionPlayer) -> bool:
    """Return whether the third step is half completed."""
    swings = player.telemetry.phase in ("left", "right")
    return player.steps == 2 and swings and player.walker.gait_state.progress > 0.5


SCENES = (
    Scene(
        "sway",
        "The centre of mass follows a figure of eight, or a circle, above the soles.",
        "sway --robot g1 --shape eight",
        "g1",
        Sway(shape="eight"),
        after(6.3),
        turn=0.4,
    ),
    Scene(
        "squat",
        "The hips descend by 20 % of the leg length and rise again, with the CoM above the soles.",
        "squat --robot talos --depth 20",
        "talos",
        Squat(depth=20.0),
        after(3.0),
    ),
    Scene(
        "wave",
        "Both hands wave above the shoulders while the robot walks.",
        "wave --robot talos --walk 0.3",
        "talos",
        Wave(walk=0.3),
        after(4.4),
        nearer=0.92,
    ),
    Scene(
        "reach",
        "Each hand reaches its own target position; the report lists unreachable targets.",
        "reach --robot talos --left 0.55 0.35 1.35 --right 0.5 -0.25 0.85",
        "talos",
        Reach(left=(0.55, 0.35, 1.35), right=(0.5, -0.25, 0.85)),
        after(2.6),
    ),
    Scene(
        "look",
        "Head and trunk rotate together to follow a point.",
        "look --robot talos --radius 0.9",
        "talos",
        Look(radius=0.9),
        after(3.8),
    ),
    Scene(
        "one-leg",
        "The robot stands on each leg for five seconds and receives a push halfway through.",
        "one-leg --robot simple_humanoid --leg left --height 15",
        "simple_humanoid",
        OneLeg(leg="left", height=15.0),
        on_one_leg,
        turn=0.5,
    ),
    Scene(
        "bow",
        "Waist and hips share the angle, and the hips move back.",
        "bow --robot g1 --angle 40",
        "g1",
        Bow(angle=40.0),
        after(2.2),
        turn=0.4,
    ),
    Scene(
        "step-in-place",
        "The walker steps in place, onto the current positions of its feet.",
        "step-in-place --robot romeo",
        "romeo",
        StepInPlace(),
        stepping,
    ),
    Scene(
        "sine",
        "Fifteen joints follow sine waves in a posture task while balance control is active.",
        "sine --robot simple_humanoid",
        "simple_humanoid",
        Sine(),
        after(2.6),
    ),
    Scene(
        "sine-open-loop",
        "Without balance control the same sine waves make the robot fall; the report states when.",
        "sine --robot simple_humanoid --open-loop",
        "simple_humanoid",
        Sine(open_loop=True),
        after(1.55),
        nearer=1.0,
    ),
    Scene(
        "jump",
        "The jump is planned within the torque and velocity limits; the image shows the flight.",
        "jump --robot g1 --clearance 0.08",
        "g1",
        Jump(clearance=0.08),
        at_the_top,
        nearer=0.82,
        lower=0.35,
    ),
    Scene(
        "keyframes",
        "The robot tracks postures and hand positions from a file, which is checked beforehand.",
        "keyframes --robot simple_humanoid --file examples/motions/keyframes/robot_dance.csv",
        "simple_humanoid",
        Keyframes(file=str(ROOT / "examples" / "motions" / "keyframes" / "robot_dance.csv")),
        after(3.0),
    ),
    Scene(
        "brace",
        "A hand feels its way to the wall and presses; the centre of mass leaves the soles.",
        "brace --robot g1 --terrain wall --lean 0.15",
        "g1",
        Brace(lean=0.15),
        after(7.0),
        turn=2.5,
        terrain=Wall(width=0.8),
    ),
    Scene(
        "carry",
        "The robot estimates the mass in its hand, leans the other way and walks with it.",
        "carry --robot g1 --mass 3",
        "g1",
        Carry(mass=3.0),
        after(7.2),
        turn=0.4,
    ),
    Scene(
        "hold-hand",
        "A hand stays at one place of the world while the feet step to and fro.",
        "hold-hand --robot g1",
        "g1",
        HoldHand(),
        after(5.2),
        turn=0.4,
    ),
    Scene(
        "push-cart",
        "Both hands push a cart with a given force, which the balance leans against.",
        "push-cart --robot g1 --terrain cart",
        "g1",
        PushCart(),
        after(9.0),
        turn=2.5,
        cart=Cart(),
    ),
)


def render(scene: Scene, path: Path) -> None:
    """Play a scene up to its moment and render the image."""
    robot = wbc.load(scene.robot)
    player = MotionPlayer(robot, motions=[scene.motion])
    runner = MotionRunner(player)
    recording = Recording(robot, boxes=scene.terrain.boxes())

    def tick(time: float) -> None:
        if scene.moment(time, player):
            raise RunComplete
        runner(time, plant)

    with wbc.sim.Mujoco(robot, seed=1, terrain=scene.terrain, cart=scene.cart) as plant:
        report = wbc.run(player, plant, MAX_DURATION, observers=[recording], before_tick=tick)
        if scene.cart is not None:
            recording.boxes = scene.cart.boxes(plant.cart_position)
    print(f"{scene.name}: {robot.name} at {report.duration_s:.2f} s", file=sys.stderr, flush=True)
    with tempfile.TemporaryDirectory() as folder, new_page(*SIZE) as page:
        page.set_default_timeout(PAGE_TIMEOUT)
        page.goto(recording.save(Path(folder) / "scene.html").as_uri())
        page.wait_for_function("wbc.ready")
        page.evaluate(MOVE_CAMERA, [scene.turn, scene.nearer, scene.lower])
        page.add_style_tag(content=STATUS_CSS)
        page.evaluate("wbc.drawFrame(wbc.player.end)")
        path.parent.mkdir(parents=True, exist_ok=True)
        page.screenshot(path=path)


def write_overview(scenes: Sequence[Scene], folder: Path, path: Path) -> None:
    """Write an overview image of all scenes and their commands."""
    figures = []
    for scene in scenes:
        data = base64.b64encode((folder / f"{scene.name}.png").read_bytes()).decode("ascii")
        figures.append(
            f'<figure><img src="data:image/png;base64,{data}">'
            f"<figcaption>wbc motion {scene.command}</figcaption></figure>"
        )
    width = COLUMNS * OVERVIEW_WIDTH + (COLUMNS + 1) * GAP
    html = f"""<style>
body {{ margin: 0; background: white; width: {width}px; display: grid; gap: {GAP}px;
  padding: {GAP}px; box-sizing: border-box;
  grid-template-columns: repeat({COLUMNS}, minmax(0, 1fr)); }}
figure {{ margin: 0; }} img {{ width: 100%; border-radius: 6px; display: block; }}
figcaption {{ font: 12px/1.35 "DejaVu Sans Mono", monospace; color: #23272f; padding: 5px 2px 0;
  min-height: 32px;
  overflow-wrap: anywhere; }}
</style>{"".join(figures)}"""
    with new_page(width, 400) as page:
        page.set_content(html)
        page.wait_for_function("[...document.images].every((image) => image.complete)")
        page.screenshot(path=path, full_page=True)


def write_page(scenes: Sequence[Scene], path: Path) -> None:
    """Write the gallery in Markdown."""
    lines = [
        "# Motions",
        "",
        "Each image shows a motion in MuJoCo with the robot's torque limits, noisy sensors and the",
        "estimator in the loop, at a characteristic moment. Images and page are made by",
        "`python benchmarks/gallery.py`. `wbc motion --list` names all motions, `wbc motion NAME",
        "--help` lists its parameters, and `wbc motion demo` plays all motions in a row.",
        "To write your own motion, see `examples/motions/13_own_motion.py`.",
        "",
        "Red arrows are contact forces, black is the path of the centre of mass, violet the DCM,",
        "yellow the ZMP, and green the support polygon.",
    ]
    for scene in scenes:
        lines += [
            "",
            f"## {scene.name}",
            "",
            f'<img src="motions/{scene.name}.png" width="360" alt="{scene.caption}">',
            "",
            scene.caption,
            "",
            "```bash",
            f"wbc motion {scene.command}",
            "```",
        ]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def main() -> None:
    """Render the images, and write the overview and the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    names = [scene.name for scene in SCENES]
    parser.add_argument("--motion", action="append", choices=names, help="render only this image")
    parser.add_argument("--docs", type=Path, default=ROOT / "docs", help="folder to write to")
    parser.add_argument("--overview", action="store_true", help="only overview and page")
    options = parser.parse_args()
    folder = options.docs / "motions"
    for scene in SCENES:
        if not options.overview and (not options.motion or scene.name in options.motion):
            render(scene, folder / f"{scene.name}.png")
    if not options.motion:
        write_overview(SCENES, folder, options.docs / "motions.png")
        write_page(SCENES, options.docs / "motions.md")


if __name__ == "__main__":
    main()
