"""Takes the pictures of the live page in the documentation: `python docs/live_pictures.py`.

A robot walks while the page is shown at three sizes, light and dark. It needs chromium.
"""

from __future__ import annotations

import argparse
import signal
import subprocess
import sys
from pathlib import Path

from wbc.view.browser import new_browser

HERE = Path(__file__).parent
TIMEOUT = 180_000  # ms
#: Name of the file, width, height, colour scheme.
PICTURES = (
    ("live.png", 1280, 800, "light"),
    ("live_small_dark.png", 800, 600, "dark"),
    ("live_phone_dark.png", 390, 844, "dark"),
)


def main() -> None:
    """Start a live session, take the pictures, and end it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robot", default="g1")
    robot = parser.parse_args().robot
    command = [sys.executable, "-m", "wbc", "live", "--robot", robot, "--port", "0"]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    )
    assert process.stdout is not None
    try:
        url = process.stdout.readline().removeprefix("Live: ").strip()
        with new_browser() as browser:
            for name, width, height, scheme in PICTURES:
                size = {"width": width, "height": height}
                context = browser.new_context(viewport=size, color_scheme=scheme, bypass_csp=True)
                page = context.new_page()
                page.set_default_timeout(TIMEOUT)
                page.goto(url)
                page.wait_for_function("wbc.ready && wbc.live.status && wbc.strips.samples() > 50")
                page.click("[data-action=walk]")
                page.wait_for_function("wbc.live.status.velocity[0] > 0")
                page.evaluate("wbc.from = wbc.time")
                page.wait_for_function("wbc.time > wbc.from + 4 && (wbc.strips.draw(), true)")
                page.evaluate("element('panel').scrollTop = 0")
                page.screenshot(path=HERE / name)
                context.close()
    finally:
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=120.0)


if __name__ == "__main__":
    main()
