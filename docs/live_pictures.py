"""Takes the pictures of the live page in the documentation: `python docs/live_pictures.py`.

A robot walks while the page is shown at three sizes, light and dark. It needs chromium and Pillow.
"""

from __future__ import annotations

import argparse
import io
import itertools
import signal
import subprocess
import sys
from pathlib import Path

from PIL import Image
from playwright.sync_api import Page

from wbc.view.browser import new_browser

FOLDER = Path(__file__).parent / "live"
TIMEOUT = 180_000  # ms
SIZES = {"desktop": (1280, 800), "small": (800, 600), "phone": (390, 844)}
SCHEMES = ("light", "dark")
QUALITY = 85  # of WebP, of 100
#: Two frames per second: rendering in software takes the processor from the robot's loop.
FEW_FRAMES = (
    "window.requestAnimationFrame = (draw) => setTimeout(() => draw(performance.now()), 500)"
)


def main() -> None:
    """Start a live session, take the pictures, and end it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robot", default="g1")
    robot = parser.parse_args().robot
    command = [sys.executable, "-m", "wbc", "live", "--robot", robot, "--port", "0"]
    command += ["--priority", "40"]  # the pages take all the processor time that there is
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    )
    assert process.stdout is not None
    FOLDER.mkdir(exist_ok=True)
    try:
        url = process.stdout.readline().removeprefix("Live: ").strip()
        with new_browser() as browser:
            for (name, (width, height)), scheme in itertools.product(SIZES.items(), SCHEMES):
                size = {"width": width, "height": height}
                context = browser.new_context(viewport=size, color_scheme=scheme, bypass_csp=True)
                context.add_init_script(FEW_FRAMES)
                page = context.new_page()
                page.set_default_timeout(TIMEOUT)
                page.goto(url)
                page.wait_for_function("wbc.ready && wbc.live.status && wbc.strips.samples() > 50")
                while (picture := _picture(page)) is None:  # of a busy machine
                    pass
                with Image.open(io.BytesIO(picture)) as image:
                    image.save(FOLDER / f"{name}_{scheme}.webp", quality=QUALITY, method=6)
                page.click("[data-action=reset]")
                context.close()
    finally:
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=120.0)


def _picture(page: Page) -> bytes | None:
    """Return a picture of the walking robot; None if it stopped, as no sign came from the page."""
    page.click("[data-action=walk]")
    page.wait_for_function("wbc.live.status.velocity[0] > 0")
    page.evaluate("wbc.from = wbc.time")
    page.wait_for_function(
        "wbc.time > wbc.from + 4 && (wbc.strips.draw(), true) && !element('error').textContent"
    )
    page.evaluate("element('panel').scrollTop = 0")
    picture = page.screenshot()
    walks = "wbc.live.status.velocity[0] > 0 && !element('error').textContent"
    return picture if page.evaluate(walks) else None


if __name__ == "__main__":
    main()
