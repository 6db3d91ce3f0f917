"""`wbc report`: a run as one page."""

import base64
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from logtools import StreamedLog, random_tick, robot, telemetry
from needs import need_browser

from wbc.cli import main
from wbc.command import Status
from wbc.errors import MissingExtra
from wbc.log import LogError, LoggedRun
from wbc.log.report import key_figures, report_page, save_report
from wbc.runtime.event import RunEvent


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A run with a fall, an unsolved tick, and an event with a text that HTML must escape."""
    humanoid, rng = robot(), np.random.default_rng(7)
    path = tmp_path_factory.mktemp("report") / "fall.mcap"
    with StreamedLog(path, humanoid) as log:
        log.stream.begin_run()
        log.begin()
        for k in range(50):
            tick = random_tick(humanoid, rng, 0.002 * k)
            status = Status.INFEASIBLE if k == 20 else Status.OK
            command = replace(tick.command, status=status)
            log.record(replace(tick, command=command, telemetry=telemetry(rng)))
        value = '{"text": "<script>bad()"}'
        log.log.on_event(RunEvent(0.01, "command", "page", 1, "note", value, "accepted"))
        log.log.on_event(RunEvent(0.05, "fall", reason="the pelvis is below 0.4 m"))
    return LoggedRun.read(path)


@pytest.fixture(scope="module")
def page(run):
    return report_page(run, film=b"film")


def test_figures_say_how_long_and_what_failed(run):
    figures = {figure.name: figure for figure in key_figures(run)}
    assert figures["duration"].value == "0.1 s"
    assert figures["duration"].note == "50 ticks at 500 Hz"
    assert (figures["falls"].value, figures["falls"].poor) == ("1", True)
    assert figures["falls"].note == "first at 0.05 s: the pelvis is below 0.4 m"
    assert (figures["QP failures"].value, figures["QP failures"].note) == ("1", "first at 0.040 s")
    share = np.abs(run["tau"]) / run.robot_info.tau_max
    assert figures["largest joint torque"].value == f"{100 * share.max():.0f} % of the limit"


def test_the_page_has_everything_and_loads_nothing(page):
    pictures = re.findall(r'src="data:image/png;base64,([^"]+)"', page)
    assert len(pictures) == 6
    assert all(base64.b64decode(picture).startswith(b"\x89PNG") for picture in pictures)
    assert base64.b64encode(b"film").decode() in page
    assert not re.search(r'(src|href)="(?!data:|#)', page), "it opens offline"
    assert "the pelvis is below 0.4 m" in page
    assert "pin" in page, "the versions of packages"


def test_texts_of_a_log_are_not_markup(page):
    assert "&lt;script&gt;bad()" in page
    assert "<script" not in page


def test_wbc_report_writes_a_part_of_a_run_beside_the_log(run, capsys):
    assert main(["report", str(run.log.path), "--from", "0.02", "--to", "0.06"]) == 0
    path = run.log.path.with_suffix(".html")
    assert str(path) in capsys.readouterr().out
    page = path.read_text("utf-8")
    assert "This is the part from 0.02 s to 0.06 s." in page
    assert "21 ticks at 500 Hz" in page


def test_a_report_that_cannot_be_written_names_its_path(run, tmp_path, monkeypatch):
    monkeypatch.setattr("wbc.log.report.page.report_page", lambda *_: "page")
    (tmp_path / "file").touch()
    with pytest.raises(LogError, match="give another path"):
        save_report(run, tmp_path / "file" / "report.html")


def test_a_missing_package_is_named_with_its_extra(run, monkeypatch):
    monkeypatch.setattr(
        "wbc.log.report.page.importlib.util.find_spec", lambda name: name != "jinja2" or None
    )
    with pytest.raises(MissingExtra, match=re.escape("wbc[report]")):
        report_page(run)


@pytest.mark.browser
@pytest.mark.parametrize("width", [390, 1280])
def test_the_page_fits_the_width_of_the_screen(run, page, tmp_path: Path, width):
    need_browser()
    from wbc.view.browser import new_page

    path = tmp_path / "report.html"
    path.write_text(page, "utf-8")
    with new_page(width, 800) as shown:
        shown.goto(path.as_uri())
        assert shown.evaluate("document.documentElement.scrollWidth") <= width
        assert shown.evaluate("[...document.images].every((i) => i.complete && i.naturalWidth)")
