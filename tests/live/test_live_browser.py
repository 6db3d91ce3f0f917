"""The live page in a real browser: `wbc live` runs, and a robot is driven by its controls."""

import base64
import io
import signal
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from wbc.log import Log, LoggedRun
from wbc.motions.registry import MOTIONS

pytestmark = pytest.mark.browser

# Rendering in software takes most of the time of these tests.
FIVE_FRAMES_A_SECOND = """
window.requestAnimationFrame = (draw) => setTimeout(() => draw(performance.now()), 200);
window.cancelAnimationFrame = clearTimeout;
"""
NO_SHADOWS_AND_ONE_IMAGE_A_SECOND = """() => {
  viewer.renderer.shadowMap.enabled = false;
  viewer.scene.traverse((object) => { if (object.material) object.material.needsUpdate = true; });
  let last = 0;
  viewer.animate = () => {
    requestAnimationFrame(() => viewer.animate());
    viewer.animator.update();
    if (viewer.needs_render && performance.now() > last + 1000) {
      last = performance.now();
      viewer.render();
    }
  };
}"""
PRESS = """(element) => {
  element.scrollIntoView({block: "center", behavior: "instant"});
  const {left, top, width, height} = element.getBoundingClientRect();
  const hit = document.elementFromPoint(left + width / 2, top + height / 2);
  if (element.disabled || !element.contains(hit)) return false;
  element.click();
  return true;
}"""
TOLD_TO_A_SLOW_PAGE = "nothing more came from the page"
TIMEOUT = 120_000  # ms; software rendering on a busy machine is slow
_BETWEEN_SESSIONS = "ERR_CONNECTION_REFUSED"  # until the next one is served


@pytest.fixture(scope="module")
def url(browser, tmp_path_factory):
    """The address of a live session; at its end, its report, log and recording are checked.

    It asks for the browser first: without one every test is skipped and no session starts.
    """
    root = Path(__file__).resolve().parents[2]
    log, html = (tmp_path_factory.mktemp("kept") / name for name in ("live.mcap", "live.html"))
    arguments = ["-m", "wbc", "live", "--robot", "simple_humanoid", "--port", "0"]
    arguments += ["--priority", "40"]  # also where the tests are niced
    arguments += ["--log", str(log), "--html", str(html)]
    process = subprocess.Popen(
        [sys.executable, *arguments], stdout=subprocess.PIPE, text=True, cwd=root
    )
    try:
        yield process.stdout.readline().removeprefix("Live: ").strip()
    finally:
        process.send_signal(signal.SIGINT)
        report, _ = process.communicate(timeout=180.0)
    assert process.returncode == 130
    assert "tick time" in report
    kept = LoggedRun(Log(log))
    assert len(kept) > 1000
    assert (np.diff(kept.stamps) > 0).all()  # resets and all
    assert html.stat().st_size > 100_000


def refusals(page):
    """What the page was refused since it was last asked, but for what only a slow one is told."""
    told = page.evaluate("wbc.live.errors.splice(0)")
    return [text for text in told if not text.startswith(TOLD_TO_A_SLOW_PAGE)]


@contextmanager
def new_page(context, url, ready):
    """A page on which nothing may go wrong."""
    page = context.new_page()
    page.set_default_timeout(TIMEOUT)
    errors = []
    page.on("pageerror", lambda error: errors.append(error))
    page.on(
        "console",
        lambda line: (
            errors.append(line.text)
            if line.type == "error" and _BETWEEN_SESSIONS not in line.text
            else None
        ),
    )
    page.goto(url)
    page.wait_for_function(ready)
    page.evaluate(NO_SHADOWS_AND_ONE_IMAGE_A_SECOND)
    yield page
    refused = refusals(page)
    page.close()
    assert errors == []
    assert refused == []


@pytest.fixture(scope="module")
def shared(browser, url):
    # Waiting for expressions needs the `eval` that the page's policy refuses.
    context = browser.new_context(viewport={"width": 480, "height": 320}, bypass_csp=True)
    context.add_init_script(FIVE_FRAMES_A_SECOND)
    with new_page(context, url, "wbc.ready && wbc.live.status") as page:
        yield page


@pytest.fixture
def page(shared):
    """The page, of a robot that stands."""
    reset(shared)
    return shared


def reset(page):
    run = page.evaluate("wbc.live.status.run")  # what is asked for before the next is forgotten
    press(page, "#tabs >> text=Controls")  # a test that failed may have left another tab open
    press(page, "[data-action=reset]")
    page.wait_for_function(
        f"wbc.live.status.run > {run} && wbc.live.status.mode === 'running'"
        " && wbc.live.status.time > 0.1 && wbc.live.status.velocity.every((x) => x === 0)"
        " && wbc.time < wbc.live.status.time + 0.1"  # frames come later than figures
    )


def names_of(motions):
    return [motion.name for motion in motions]


def turn(page, control, share):
    """Move a slider, 0 to 1, as a hand does."""
    page.locator(f"[data-control='{control}']").evaluate(
        "(slider, share) => { slider.value = share;"
        " slider.dispatchEvent(new Event('input')); slider.dispatchEvent(new Event('change')); }",
        share,
    )


def press(page, selector):
    """A click by a script, once the element can be clicked: enabled, in sight and not covered.

    The browser's own click waits for frames as well, seconds long on a busy machine, and moves the
    focus.
    """
    element = page.locator(selector).first.element_handle()
    page.wait_for_function(PRESS, arg=element)


def silhouette(page):
    """The robot alone, (h, w, 3), as it is drawn now."""
    from PIL import Image

    url = page.evaluate(
        """() => {
          for (const [name, child] of Object.entries(viewer.scene_tree.find(["wbc"]).children)) {
            child.object.visible = name === "robot" || name === "surroundings";
            if (name === "surroundings") for (const part of child.object.children) {
              part.visible = part.isLight === true;
            }
          }
          return viewer.capture_image();
        }"""
    )
    image = Image.open(io.BytesIO(base64.b64decode(url.partition(",")[2])))
    return np.asarray(image.convert("RGB"), dtype=float)


def changed(a, b):
    """Share of the pixels that clearly differ."""
    return float((np.abs(a - b).max(axis=2) > 24).mean())


def pass_time(page, seconds):
    """Wait until so much of the robot's time has been drawn."""
    page.evaluate("wbc.from = wbc.time")
    page.wait_for_function(f"wbc.time > wbc.from + {seconds}")


def watch(page, quantity):
    """Keep the largest value of a quantity from now on, as `wbc.most`; returns the robot's time.

    Of all that the page is told: one that draws slowly is told several things at once.
    """
    return page.evaluate(
        """(quantity) => {
          let now = wbc.live.status;
          wbc.most = 0;
          Object.defineProperty(wbc.live, "status", {configurable: true, get: () => now,
            set: (told) => { now = told; wbc.most = Math.max(wbc.most, told[quantity]); }});
          return now.time;
        }""",
        quantity,
    )


def test_the_robot_moves_when_the_slider_moves(page):
    pass_time(page, 1.0)
    still = silhouette(page)
    pass_time(page, 0.4)
    quiet = changed(still, silhouette(page))
    turn(page, "velocity.forward", 0.85)
    page.wait_for_function("wbc.live.status.velocity[0] > 0.05")
    page.wait_for_function("document.querySelector('[data-action=walk]').className === 'on'")
    pass_time(page, 1.0)
    assert changed(still, silhouette(page)) > max(0.005, 4.0 * quiet)


def test_a_push_makes_the_dcm_jump_and_is_counted(page):
    start = watch(page, "dcm_error")
    page.wait_for_function(f"wbc.live.status.time > {start + 0.4}")
    calm = page.evaluate("wbc.most")
    page.click("[data-action=push]")
    page.wait_for_function("wbc.live.status.pushes === 1")
    assert page.evaluate("wbc.most") > 3.0 * calm > 0.0
    assert page.evaluate("wbc.live.status.survived") == 1
    page.wait_for_function("element('pushes').textContent === 'survived 1 of 1'")


def test_every_motion_has_a_button_that_plays_it(page):
    names = page.locator("[data-action^='motion ']").all_inner_texts()
    assert names == names_of(MOTIONS)
    press(page, "[data-action='motion sway']")
    page.wait_for_function(f"wbc.live.status.playing === {names.index('sway')}")
    page.wait_for_function(
        "document.querySelector('[data-action=\"motion sway\"]').className === 'on'"
    )
    press(page, "[data-action=stand]")
    page.wait_for_function("wbc.live.status.playing < 0")


def test_parameters_of_a_motion_are_below_its_button_with_the_reason_of_a_refusal(page):
    press(page, "[data-more=squat]")
    assert page.locator("form:visible").count() == 1
    offered = page.locator("[data-form=squat] [data-parameter]")
    names = offered.evaluate_all("(inputs) => inputs.map((i) => i.dataset.parameter)")
    assert names == ["squat.depth", "squat.frequency", "squat.times"]
    page.fill("[data-parameter='squat.depth']", "95")
    press(page, "[data-form=squat] >> text=Play")
    shown = "element('error').textContent.includes('cannot go down by 95 %')"
    page.wait_for_function(shown)  # it fades
    assert len(refusals(page)) == 1
    page.fill("[data-parameter='squat.depth']", "4")
    page.press("[data-parameter='squat.depth']", "Enter")
    page.wait_for_function(f"wbc.live.status.playing === {names_of(MOTIONS).index('squat')}")
    press(page, "[data-form=squat] >> text=Reset to defaults")
    page.wait_for_function("document.querySelectorAll('.changed').length === 0")
    press(page, "[data-more=reach]")
    assert page.locator("form:visible").get_attribute("data-form") == "reach"
    press(page, "[data-more=reach]")
    assert page.locator("form:visible").count() == 0


def test_keys_typed_into_a_field_send_no_command(page):
    run, pushes = page.evaluate("[wbc.live.status.run, wbc.live.status.pushes]")
    press(page, "[data-more=keyframes]")
    hold = page.locator("[data-parameter='keyframes.hold']")
    hold.press_sequentially("pr s")
    hold.fill("0.1")
    pass_time(page, 0.2)
    assert page.evaluate("wbc.live.status.mode") == "running"
    assert page.evaluate("[wbc.live.status.run, wbc.live.status.pushes]") == [run, pushes]
    # A file is sent, and played from its name.
    page.locator("[data-form=keyframes] input[type=file]").set_input_files(
        files=[{"name": "up.csv", "mimeType": "text/csv", "buffer": b"not, keyframes"}]
    )
    page.wait_for_function(
        "document.querySelector('[data-parameter=\"keyframes.file\"]').value === 'up.csv'"
    )
    page.press("[data-parameter='keyframes.hold']", "Enter")
    page.wait_for_function("wbc.live.errors.some((text) => text.includes('up.csv'))")
    assert len(refusals(page)) == 1
    press(page, "[data-form=keyframes] >> text=Reset to defaults")
    press(page, "[data-more=keyframes]")


def test_it_waves_while_it_walks(page):
    turn(page, "velocity.forward", 0.7)
    page.wait_for_function("wbc.live.status.velocity[0] > 0.05")
    press(page, "[data-action='motion wave']")
    page.wait_for_function(f"wbc.live.status.playing === {names_of(MOTIONS).index('wave')}")
    pass_time(page, 0.5)
    assert page.evaluate("wbc.live.status.velocity[0]") > 0.05
    press(page, "[data-action=stand]")
    page.wait_for_function("wbc.live.status.velocity[0] === 0")


def test_arrow_keys_drive_and_space_pauses(page):
    page.click("#panel h2 >> nth=0")  # no field has the focus
    for _ in range(3):
        page.keyboard.press("ArrowUp")
    page.keyboard.press("ArrowLeft")
    page.wait_for_function("wbc.live.status.velocity[0] > 0 && wbc.live.status.velocity[2] > 0")
    page.keyboard.press(" ")
    page.wait_for_function("wbc.live.status.mode === 'paused'")
    time = page.evaluate("wbc.live.status.time")
    page.wait_for_timeout(300)
    assert page.evaluate("wbc.live.status.time") == time
    page.keyboard.press(" ")
    page.wait_for_function("wbc.live.status.mode === 'running'")


def test_a_gamepad_drives_stands_and_pauses(page):
    page.evaluate(
        """() => {
          const buttons = Array.from({length: 16}, () => ({pressed: false}));
          wbc.pad = {axes: [-0.5, -1, 0.1, 0], buttons};
          wbc.looks = 0;
          navigator.getGamepads = () => { wbc.looks += 1; return [null, wbc.pad]; };
          wbc.press = (i, pressed) => { wbc.pad.buttons[i] = {pressed}; };
        }"""
    )
    # Forward, and to the left; the right stick is in its dead zone.
    page.wait_for_function("wbc.live.status.velocity[0] > 0 && wbc.live.status.velocity[1] > 0")
    assert page.evaluate("wbc.live.status.velocity[2]") == 0
    page.evaluate("wbc.pad.axes = [0, 0, 0, 0]")
    page.wait_for_function("wbc.live.status.velocity.every((x) => x === 0)")
    for mode in ("paused", "running"):
        page.evaluate("wbc.press(9, true)")
        page.wait_for_function(f"wbc.live.status.mode === '{mode}'")
        page.evaluate("wbc.press(9, false); wbc.looks = 0")
        page.wait_for_function("wbc.looks > 0")  # the page has seen that it was let go
    page.evaluate("delete navigator.getGamepads")


def test_the_tuner_lists_the_tasks_and_a_gain_reaches_every_page(url, page):
    """The other page leaves while its scene is still being loaded, which harms nothing."""
    press(page, "text=Tasks: weights and gains")
    tasks = page.locator("details[open] h3").all_inner_texts()
    assert {"com", "posture"} <= set(tasks)
    assert any("orientation" in task for task in tasks)
    turn(page, "com.weight", 0.8)
    weight = page.evaluate("wbc.live.values['com.weight']")
    there = f"Math.abs(wbc.live.values['com.weight'] / {weight} - 1) < 1e-6"
    with new_page(page.context, url, f"wbc.live.status && {there}") as other:
        turn(other, "com.weight", 0.6)
        page.wait_for_function(f"wbc.live.values['com.weight'] < 0.9 * {weight}")
    pass_time(page, 0.2)
    press(page, "[data-task='angular momentum']")
    page.wait_for_function("wbc.live.values['angular momentum.weight'] === 0")
    page.select_option("[data-choose=frame]", "left_hand")
    press(page, "[data-action='add task']")
    page.wait_for_function("wbc.live.frameTasks.length === 1")
    press(page, ".frame-task button")
    page.wait_for_function("wbc.live.frameTasks.length === 0")
    page.keyboard.press("z")
    page.wait_for_function("wbc.live.frameTasks.length === 1")
    page.keyboard.press("z")
    page.wait_for_function("wbc.live.frameTasks.length === 0")
    weight = page.evaluate("wbc.live.values['com.weight']")
    press(page, "details[open] >> text=Reset to defaults")
    page.wait_for_function("document.querySelector(\"[data-task='angular momentum']\").checked")
    assert page.evaluate("wbc.live.values['com.weight']") == pytest.approx(3000.0)
    page.keyboard.press("z")  # the defaults together
    page.wait_for_function("wbc.live.values['angular momentum.weight'] === 0")
    assert page.evaluate("wbc.live.values['com.weight']") == pytest.approx(weight)


def test_the_robot_walks_on_while_its_page_is_open_and_stops_when_it_is_gone(page):
    turn(page, "velocity.forward", 0.8)
    page.wait_for_function("wbc.live.status.velocity[0] > 0")
    pass_time(page, 1.5)  # three times the silence that ends a velocity
    assert page.evaluate("wbc.live.status.velocity[0]") > 0
    page.reload()  # also the end of a page
    page.wait_for_function("wbc.ready && wbc.live.status && wbc.live.status.velocity[0] === 0")
    page.wait_for_function("wbc.live.values['velocity.forward'] === 0")
    assert page.evaluate("wbc.live.status.mode") == "running"
    pass_time(page, 0.2)


def test_the_shown_objects_can_be_selected(page):
    press(page, "#panel summary >> text=Show")
    visible = "viewer.scene_tree.find(['wbc', 'robot']).object.visible"
    press(page, "[data-shown=robot]")
    pass_time(page, 0.1)
    assert page.evaluate(visible) is False
    press(page, "[data-shown=robot]")
    assert page.evaluate(visible) is True


def test_signals_are_drawn_with_their_past_and_zoomed(page):
    page.wait_for_function("wbc.strips.samples() > 20")
    page.evaluate("localStorage.clear()")
    press(page, "#tabs >> text=Signals")
    press(page, "#add-strip")
    page.locator(".choose").fill("com: z, m")
    page.wait_for_function("wbc.strips.signals().at(-1)[0] === 'com: z, m'")
    shown = "document.querySelector('[data-signal=\"com: z, m\"] output').textContent"
    page.wait_for_function(f"parseFloat({shown}) > 0.5")
    budget = "document.querySelector('[data-signal=\"controller_time, s\"] output').textContent"
    page.wait_for_function(f"{budget}.endsWith('(budget 2000 µs)')")
    page.evaluate("wbc.strips.zoom(0.1, 0.3)")
    assert page.evaluate("wbc.strips.window()") == pytest.approx([0.1, 0.3])
    page.evaluate("wbc.strips.follow()")
    page.select_option("#layout", "Timing")
    page.wait_for_function("wbc.strips.signals().length === 3")
    press(page, "#tabs >> text=Controls")


def test_a_fall_is_unmistakable_stays_in_reach_and_one_key_resets(page):
    largest = page.evaluate("wbc.live.status.run")
    page.wait_for_function("wbc.live.status.time > 2")  # a second before the fall is of this run
    page.locator("[aria-label='size of the push']").evaluate(
        "(slider) => { slider.value = 1; slider.oninput(); }"
    )
    # Pushes at once add up; one after the fall would be refused.
    page.evaluate(
        """() => {
          for (let count = 0; count < 6; ++count)
            document.body.dispatchEvent(new KeyboardEvent("keydown", {key: "p", bubbles: true}));
        }"""
    )
    page.wait_for_function("wbc.live.status.mode === 'fallen'")
    banner = "document.querySelector('#banner').innerText"
    page.wait_for_function(f"{banner}.includes('Robot fell — press Reset (R)')")
    page.wait_for_function("document.querySelector('#banner small').textContent.length > 10")
    fallen = "document.body.classList.contains('fallen')"
    assert page.evaluate(fallen)
    kinds = "wbc.timeline.events().map((event) => event.kind)"
    page.wait_for_function(f"{kinds}.includes('fall') && {kinds}.includes('push')")
    end = page.evaluate("wbc.live.status.session")
    page.evaluate(f"wbc.timeline.review({end} - 1)")
    page.wait_for_function("wbc.time < wbc.live.status.time - 0.9")
    press(page, "#tabs >> text=Signals")
    page.select_option("#stretch", "30")
    press(page, "#save-film")
    page.wait_for_function("wbc.live.saved.endsWith('.html')")
    press(page, "#live")
    page.keyboard.press("r")
    page.wait_for_function(f"wbc.live.status.run > {largest} && !{fallen}")
    # A push that arrives after the fall that the one before made.
    assert set(refusals(page)) <= {"the robot has fallen: reset it first"}
    press(page, "#tabs >> text=Controls")


def drag(page, place, by, done):
    """Drags what is at a place, (x, y) by a script, until a condition holds.

    Robot and camera move, and a mouse that is told where to press comes too late on a busy machine:
    the script that finds the place presses there.
    """
    gesture = """([kind, x, y]) => viewer.renderer.domElement.dispatchEvent(new PointerEvent(kind,
      {clientX: x, clientY: y, button: 0, pointerId: 1, bubbles: true}))"""
    page.evaluate(
        f"""() => {{
          const [x, y] = ({place})(), gesture = {gesture};
          gesture(["pointerdown", x, y]);
          gesture(["pointermove", x + {by[0]}, y + {by[1]}]);
        }}"""
    )
    try:
        page.wait_for_function(done)
    finally:
        page.evaluate(gesture, ["pointerup", 0, 0])


A_LINK = """() => {
  const frame = viewer.renderer.domElement.getBoundingClientRect(), hits = [];
  for (let y = 0.3; y < 0.7; y += 0.04) for (let x = 0.4; x < 0.6; x += 0.01) {
    const at = [frame.left + x * frame.width, frame.top + y * frame.height];
    if (wbc.pointer.linkPoint({clientX: at[0], clientY: at[1]})) hits.push(at);
  }
  return hits[hits.length >> 1];
}"""
THE_RIGHT_HAND = """() => {
  const ball = wbc.pointer.handles.get("right").children[0];
  viewer.camera.updateMatrixWorld();
  ball.updateWorldMatrix(true, false);
  const at = new THREE.Vector3().setFromMatrixPosition(ball.matrixWorld);
  at.project(viewer.camera);
  const frame = viewer.renderer.domElement.getBoundingClientRect();
  return [
    frame.left + (at.x + 1) / 2 * frame.width,
    frame.top + (1 - at.y) / 2 * frame.height,
  ];
}"""


def test_a_clicked_floor_is_walked_to_and_a_link_is_pulled(page):
    page.keyboard.press("w")
    page.evaluate("element('tools').hidden = true")
    box = page.locator("#meshcat-pane canvas").bounding_box()
    page.mouse.click(box["x"] + 0.2 * box["width"], box["y"] + 0.8 * box["height"])
    page.wait_for_function("wbc.live.status.velocity.some((x) => x !== 0)")
    page.keyboard.press("s")
    page.wait_for_function("wbc.live.status.velocity.every((x) => x === 0)")
    page.keyboard.press("d")
    kinds = "wbc.timeline.events().map((event) => event.kind)"
    drag(page, A_LINK, (5, 0), f"{kinds}.includes('pull')")
    page.keyboard.press("h")
    standing = "wbc.live.status.playing === -1"  # no motion, nor on the way back from one
    page.wait_for_function(f"wbc.pointer.handles.size === 2 && wbc.ready && {standing}")
    drag(page, THE_RIGHT_HAND, (0, -10), "wbc.live.status.hands.right.leads")
    page.keyboard.press("s")
    page.wait_for_function("!wbc.live.status.hands.right.leads")
    press(page, "[data-more=sway]")
    page.fill("[data-parameter='sway.rounds']", "100")  # until it is told to stand
    page.press("[data-parameter='sway.rounds']", "Enter")
    page.wait_for_function("wbc.live.status.playing >= 0")
    refusal = "a motion is playing, which leads the hands: press Stand (S) first"
    drag(page, THE_RIGHT_HAND, (0, -10), f"wbc.live.errors.includes('{refusal}')")
    assert refusals(page) == [refusal]
    press(page, "[data-form=sway] >> text=Reset to defaults")
    press(page, "[data-more=sway]")
    page.evaluate("element('tools').hidden = false")
    page.keyboard.press("v")


def test_the_camera_stays_or_follows_and_pictures_are_saved(page):
    page.keyboard.press("f")
    assert page.evaluate("wbc.follows") is False
    page.keyboard.press("f")
    page.keyboard.press("6")
    up = page.evaluate("viewer.camera.position.y / viewer.camera.position.length()")
    assert up > 0.95
    page.keyboard.press("1")
    with page.expect_download():
        page.keyboard.press("c")
    assert page.evaluate("wbc.screenshot").startswith("data:image/png")


def test_changes_of_parameters_are_undone_and_saved_to_a_file(page):
    turn(page, "gait.swing_height", 0.9)
    value = page.evaluate("wbc.live.values['gait.swing_height']")
    with page.expect_download():
        press(page, "[data-action='save gains']")
    assert f'"gait.swing_height" = {value:.6g}' in page.evaluate("wbc.live.gains")
    page.keyboard.press("z")
    assert page.evaluate("wbc.live.values['gait.swing_height']") < value


@pytest.mark.parametrize(("width", "height"), [(390, 844), (800, 600), (1280, 800)])
def test_nothing_overlaps_nor_covers_the_robot_and_no_label_is_cut(page, width, height):
    before = page.viewport_size
    page.set_viewport_size({"width": width, "height": height})
    fits = "(size) => viewer.renderer.domElement[size] === element('meshcat-pane')[size]"
    page.wait_for_function(f"['clientWidth', 'clientHeight'].every({fits})")
    found = page.evaluate(
        """() => {
          element("text").textContent = "falling: the DCM is 0.37 m off the feet, the body is "
            + "tilted by 38° at +153°/s, and the centre of mass is at 93 % of its height";
          const shown = (selector) => [...document.querySelectorAll(selector)]
            .map((e) => [e, e.getBoundingClientRect()]).filter(([, r]) => r.width && r.height);
          const parts = shown("#status, #tools > div, #legend, #panel, #dock, #tabs");
          const overlaps = (a, b) => a.left < b.right - 1 && b.left < a.right - 1
            && a.top < b.bottom - 1 && b.top < a.bottom - 1;
          const faults = [];
          parts.forEach(([e, a], i) => parts.slice(i + 1).forEach(([f, b]) => {
            if (overlaps(a, b)) faults.push(`${e.id || e.className} × ${f.id || f.className}`);
          }));
          const {left, top, width, height} = element("meshcat-pane").getBoundingClientRect();
          const covers = shown("#tools > div, #legend, #panel, #dock, #tabs");
          const robot = viewer.scene_tree.find(["wbc", "robot"]).object;
          robot.traverse((part) => {
            const corners = part.geometry?.getAttribute("position");
            for (let i = 0; i < (corners?.count ?? 0); i++) {
              const point = new THREE.Vector3().fromBufferAttribute(corners, i);
              point.applyMatrix4(part.matrixWorld).project(viewer.camera);
              const [x, y] = [left + (point.x + 1) * width / 2, top + (1 - point.y) * height / 2];
              const isWithin = (r) => x > r.left && x < r.right && y > r.top && y < r.bottom;
              const scene = {left, right: left + width, top, bottom: top + height};
              if (!isWithin(scene)) faults.push("robot outside");
              for (const [e, r] of covers) {
                if (isWithin(r)) faults.push(`robot × ${e.id || e.className}`);
              }
            }
          });
          for (const [e, r] of shown("button, .slider span, .slider output, #status, .signal")) {
            const cut = e.scrollWidth > e.clientWidth + 1 && e.clientWidth;
            const outside = r.right > innerWidth + 1 && !e.closest("#strips");
            if (cut || outside) faults.push(`cut: ${e.textContent}`);
          }
          const strips = element("strips").getBoundingClientRect();
          for (const [, r] of shown(".strip")) {
            const across = r.left < strips.right - 1 && r.right > strips.right + 1;
            const along = r.top < strips.bottom - 1 && r.bottom > strips.bottom + 1;
            if (across || along) faults.push("cut strip");
          }
          return [...new Set(faults)];
        }"""
    )
    page.set_viewport_size(before)
    assert found == []


@pytest.mark.slow
def test_another_session_with_an_uploaded_robot_takes_the_place_of_this_one(page):
    urdf = Path(__file__).resolve().parents[2] / "robots" / "simple_humanoid.urdf"
    press(page, "#panel summary >> text=Session")
    page.locator("#session input[type=file]").set_input_files(urdf)
    page.wait_for_function("element('findings').textContent.includes('doctor')")
    page.select_option("[data-session=terrain]", "ramp")
    page.fill("[data-session=seed]", "3")
    press(page, "[data-action='start session']")
    # The page loads anew.
    page.wait_for_function(
        "window.wbc?.ready && wbc.live.status && wbc.controls.sessions.present.terrain === 'ramp'"
    )
    present = page.evaluate("wbc.controls.sessions.present")
    assert present == {"robot": "simple_humanoid.urdf", "terrain": "ramp", "seed": 3}
    assert page.evaluate("wbc.live.status.mode") == "running"
