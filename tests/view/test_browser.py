"""What a real browser shows: the live page and a recording, by their pixels."""

import base64
import io
import itertools
import re
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

import wbc
from wbc.command import Status
from wbc.telemetry import ContactPlan, Footstep, Telemetry
from wbc.view import Meshcat, Recording, Snapshot

pytestmark = pytest.mark.browser

times = itertools.count(1)  # s: each snapshot has its own time, by which the page identifies it
TIMEOUT = 60_000  # ms; software rendering on a busy machine is slow, completeness is what counts


@contextmanager
def new_page(browser, **options):
    """Yield a new page; check at the end that no script of it failed."""
    size = {"width": 360, "height": 280}
    context = browser.new_context(viewport=size, bypass_csp=True, **options)
    page = context.new_page()
    page.set_default_timeout(TIMEOUT)
    errors = []
    page.on("pageerror", lambda error: errors.append(error))
    yield page
    context.close()
    assert errors == []


@pytest.fixture
def page(browser):
    with new_page(browser) as page:
        yield page


@pytest.fixture(scope="module")
def robot():
    return wbc.load("simple_humanoid")


@pytest.fixture(scope="module")
def live(robot, browser):
    """A viewer and its page, used by several tests: opening one takes seconds."""
    with Meshcat(robot, port=0, announce=False) as viewer, new_page(browser) as page:
        page.goto(viewer.url)
        yield viewer, page


def rendered_image(page):
    """Render the canvas and return its pixels, (h, w, 3)."""
    from PIL import Image

    url = page.evaluate("viewer.capture_image()")
    image = Image.open(io.BytesIO(base64.b64decode(url.partition(",")[2])))
    return np.asarray(image.convert("RGB"), dtype=float)


def changed_share(a, b):
    """Return the share of the pixels that clearly differ."""
    return float((np.abs(a - b).max(axis=2) > 24).mean())


def hide(page, name, hidden=True):
    page.evaluate(
        f"viewer.scene_tree.find(['wbc', '{name}']).object.visible = {str(not hidden).lower()}"
    )


def show_and_wait(page, viewer, snapshot):
    """Show a snapshot and wait until the page has drawn it."""
    snapshot = replace(snapshot, time=float(next(times)))
    viewer.show(snapshot)
    page.wait_for_function(f"wbc.ready && wbc.time === {snapshot.time}")


def raised_arm(robot):
    v = np.zeros(robot.nv)
    for i, name in enumerate(robot.joint_names):
        if "shoulder_roll" in name:
            v[6 + i] = 1.2 if name.startswith("left") else -1.2
    return pin.integrate(robot.model, robot.q_nominal, v)


def full_snapshot(robot, time=0.0, q=None, status=Status.OK):
    """Return a snapshot with all optional content."""
    weight = 9.81 * robot.mass
    x, y = 0.3, 0.15
    telemetry = Telemetry(
        dcm=np.array([0.05, 0.03, 0.0]),
        dcm_reference=np.array([0.06, 0.02, 0.0]),
        zmp=np.array([-0.05, 0.0, 0.0]),
        phase="double",
    )
    plan = ContactPlan(
        support=np.array([[-x, -y, 0], [x, -y, 0], [x, y, 0], [-x, y, 0.0]]),
        footsteps=(
            Footstep("left", np.array([0.5, 0.1, 0]), 0.1),
            Footstep("right", np.array([0.7, -0.1, 0]), 0.2),
        ),
        swing_path=np.array([[0, -0.1, 0], [0.3, -0.1, 0.2], [0.6, -0.1, 0.0]]),
    )
    wrenches = {sole.name: np.array([0, 0, 0.5 * weight, 0, 0, 0]) for sole in robot.soles}
    q = robot.q_nominal if q is None else q
    return Snapshot(time, q, wrenches, telemetry, plan, status, "all is well")


def test_page_shows_the_robot_and_every_marker(robot, live):
    viewer, page = live
    show_and_wait(page, viewer, full_snapshot(robot))
    full = rendered_image(page)
    for name, least in (
        ("robot", 0.02),
        ("forces", 0.0005),
        ("balance", 0.0003),
        ("support", 0.001),
        ("footsteps", 0.001),
        ("swing", 0.0002),
        ("status_light", 0.0002),
    ):
        hide(page, name)
        assert changed_share(full, rendered_image(page)) > least, name
        hide(page, name, hidden=False)
    assert changed_share(full, rendered_image(page)) == 0.0
    assert page.inner_text("#text") == "all is well"
    assert "support polygon" in page.text_content("#legend")


def test_the_page_follows_the_configuration_and_the_status(robot, live):
    viewer, page = live
    show_and_wait(page, viewer, full_snapshot(robot))
    before = rendered_image(page)
    assert page.evaluate("element('status-light').title") == "ok"
    show_and_wait(page, viewer, full_snapshot(robot, q=raised_arm(robot), status=Status.FAILED))
    assert changed_share(before, rendered_image(page)) > 0.003
    assert page.evaluate("element('status-light').title") == "failed"


def test_camera_of_the_page_follows_the_robot(robot, live):
    viewer, page = live
    hidden = ("surroundings", "trail")
    show_and_wait(page, viewer, Snapshot(0.0, robot.q_nominal))
    for name in hidden:
        hide(page, name)
    here = rendered_image(page)
    far = robot.q_nominal.copy()
    far[:2] += (40.0, -25.0)
    show_and_wait(page, viewer, Snapshot(0.0, far))
    for name in hidden:
        hide(page, name)
    assert changed_share(here, rendered_image(page)) < 0.01


def test_a_page_opened_again_shows_the_present_state(robot, live):
    viewer, page = live
    snapshot = full_snapshot(robot, 1e6)
    viewer.show(snapshot)
    page.reload()
    page.wait_for_function("wbc.ready && wbc.time === 1e6")


def test_meshes_arrive_complete_at_the_page(page):
    robot = wbc.load("romeo")
    with Meshcat(robot, port=0, announce=False) as viewer:
        page.goto(viewer.url)
        show_and_wait(page, viewer, Snapshot(0.0, robot.q_nominal))
        meshes = page.evaluate(
            "(() => { let n = 0; viewer.scene_tree.find(['wbc', 'robot']).object.traverse("
            "(o) => { n += o.isMesh ? 1 : 0; }); return n; })()"
        )
        assert meshes >= len(robot.visual_model.geometryObjects)
        full = rendered_image(page)
        hide(page, "robot")
        assert changed_share(full, rendered_image(page)) > 0.04


def test_a_robot_without_shapes_is_visible(robot, page, tmp_path):
    text = robot.urdf_path.read_text()
    text = re.sub(r"<visual.*?</visual>", "", text, flags=re.S)
    bare = tmp_path / "bare.urdf"
    bare.write_text(text)
    other = wbc.load(bare, left_foot="left_foot", right_foot="right_foot")
    with Meshcat(other, port=0, announce=False) as viewer:
        page.goto(viewer.url)
        show_and_wait(page, viewer, Snapshot(0.0, other.q_nominal))
        full = rendered_image(page)
        hide(page, "robot")
        assert changed_share(full, rendered_image(page)) > 0.02
        assert "collision shapes" in page.inner_text("#text")


def test_a_recording_opens_offline_plays_by_itself_and_moves(robot, browser, tmp_path):
    recording = Recording(robot)
    start, end = robot.q_nominal, raised_arm(robot)
    for k in range(91):
        q = pin.interpolate(robot.model, start, end, k / 90)
        q[0] = k / 90
        status = Status.FAILED if k >= 60 else Status.OK
        recording.show(full_snapshot(robot, 5.0 + k / 30, q, status))
    path = recording.save(tmp_path / "run.html")
    assert path.stat().st_size < 4e6

    asked = []
    with new_page(browser, offline=True) as page:
        page.on("request", lambda request: asked.append(request.url))
        page.goto(path.as_uri())
        page.wait_for_function("wbc.ready")
        assert page.evaluate("wbc.player.playing")
        assert page.evaluate("wbc.player.end - wbc.player.start") == pytest.approx(3.0, abs=1e-3)
        page.wait_for_function("wbc.time > 5.2")  # it goes by itself

        def at(time):
            page.evaluate(f"element('seek').value = {5.0 + time}; element('seek').oninput()")
            page.wait_for_function(f"Math.abs(wbc.time - {5.0 + time}) < 0.04")
            return rendered_image(page)

        first, last = at(0.0), at(2.9)
        assert changed_share(first, last) > 0.003
        assert page.evaluate("element('status-light').title") == "failed"
        at(3.0)
        root = robot.model.names[1]
        x = page.evaluate(f"viewer.scene_tree.find(['wbc', 'robot', '{root}']).object.position.x")
        assert x == pytest.approx(1.0, abs=1e-3)  # it ends where the run ended
        hide(page, "forces")
        assert changed_share(last, rendered_image(page)) > 0.0005
        page.click("#play")
        page.wait_for_function("wbc.player.playing")
        page.wait_for_function("wbc.time < 5.5")  # it goes round
        assert all(url.startswith(("file:", "data:", "blob:")) for url in asked)
