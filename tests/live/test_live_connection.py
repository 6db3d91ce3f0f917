"""A page of a live session whose server dies and comes back, in a real browser."""

import os
import signal
from types import SimpleNamespace

import pytest

import wbc
from wbc.live import Live
from wbc.motions import MotionPlayer
from wbc.teleop import CommandHandler

pytestmark = pytest.mark.browser

TIMEOUT = 60_000  # ms; software rendering on a busy machine is slow


def test_a_page_tells_a_lost_connection_from_the_end_of_the_run_and_reconnects(browser):
    player = MotionPlayer(wbc.load("simple_humanoid"))
    with CommandHandler(player, SimpleNamespace(dt=player.dt, time=0.0)) as handler:
        page = browser.new_page(viewport={"width": 480, "height": 320})
        page.set_default_timeout(TIMEOUT)
        printed = []
        page.on("console", lambda line: printed.append(line.text))
        with Live(handler, port=0, announce=False, token="") as live:
            page.goto(live.url)
            page.wait_for_selector("#panel")
            os.kill(live.pid, signal.SIGKILL)
            page.wait_for_selector("#lost >> text=Connection lost; trying to reconnect …")
            assert page.is_disabled("[data-action=stand]")
            port = int(live.url.split(":")[2].split("/")[0])
        with Live(handler, port=port, announce=False, token=""):
            page.wait_for_selector("#lost:empty", state="attached")
            page.wait_for_selector("#wait", state="detached")
            assert page.is_enabled("[data-action=stand]")
        page.wait_for_selector("#lost >> text=The run has ended")
        assert not [line for line in printed if "Content Security Policy" in line]
        page.close()
