"""A headless browser that renders the pages of recordings."""

from __future__ import annotations

import contextlib
import importlib.util
import os
import shutil
from collections.abc import Iterator, Sequence
from typing import Any

from wbc.errors import MissingExtra
from wbc.view.errors import ViewerError

_NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
#: Software rendering without a graphics card, and no network access beyond this machine.
_FLAGS = (
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
    "--no-sandbox",
    "--disable-dev-shm-usage",
    "--disable-background-networking",
    "--host-resolver-rules=MAP * ~NOTFOUND , EXCLUDE 127.0.0.1 , EXCLUDE localhost",
)

#: Software rendering without a search for a graphics card, which takes seconds. Only WebGL needs a
#: simulated one; text and plots, drawn by it as well, would keep a page from answering for seconds.
SOFTWARE = (
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--disable-accelerated-2d-canvas",
    "--disable-gpu-rasterization",
)


def find_browser() -> str:
    """Return the path of the system's browser, or of the one that playwright has installed.

    Raises:
        MissingExtra: `playwright` is not installed.
        ViewerError: No browser is installed.
    """
    if importlib.util.find_spec("playwright") is None:
        raise MissingExtra("playwright", "video")
    from playwright.sync_api import sync_playwright

    for found in filter(None, map(shutil.which, _NAMES)):
        return found
    with sync_playwright() as playwright:
        own = playwright.chromium.executable_path
    if os.path.isfile(own):
        return str(own)
    raise ViewerError(
        "there is no chromium to render with; run  playwright install chromium,  or your "
        "system's  apt install chromium"
    )


@contextlib.contextmanager
def new_browser(flags: Sequence[str] = ()) -> Iterator[Any]:
    """Yield a headless browser, playwright's `Browser`.

    Args:
        flags: Additional command line flags.

    Raises:
        MissingExtra: `playwright` is not installed.
        ViewerError: No browser is installed, or it does not start.
    """
    executable = find_browser()
    from playwright.sync_api import Error, sync_playwright

    with sync_playwright() as playwright:
        try:
            browser = playwright.chromium.launch(executable_path=executable, args=[*_FLAGS, *flags])
        except Error as error:
            reason = str(error).strip().splitlines()[0]
            raise ViewerError(f"the browser does not start: {reason}") from error
        try:
            yield browser
        finally:
            browser.close()


@contextlib.contextmanager
def new_page(width: int, height: int) -> Iterator[Any]:
    """Yield a page of a size in pixels in a new browser, playwright's `Page`.

    Raises:
        MissingExtra: `playwright` is not installed.
        ViewerError: No browser is installed, or it does not start.
    """
    with new_browser() as browser:
        # Waiting for expressions needs the `eval` that the policy of served pages refuses.
        size = {"width": width, "height": height}
        yield browser.new_page(viewport=size, bypass_csp=True)
