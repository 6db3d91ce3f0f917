"""The `wbc` command: exit codes, the report and its files, and one clear line for bad input."""

from __future__ import annotations

import json
import signal
import sys
import time
from pathlib import Path

import pytest
from clitools import QUICK, start

import wbc
from wbc.cli import main
from wbc.log import Log

CHAPTER = Path(__file__).parents[1] / "data" / "chapter_minimal.urdf"
KEYS = {
    *("robot", "survived", "fell_at_s", "steps", "distance_m", "mean_speed_m_s"),
    *("dcm_error_rms_mm", "torque_peak_ratio", "qp_failures", "tick_p50_us", "tick_p99_us"),
    *("tick_max_us", "real_time_factor"),
}


@pytest.fixture
def wbc_command(capsys):
    """Runs the command in this process; returns exit code, stdout, stderr."""

    def run(*arguments: str) -> tuple[int, str, str]:
        code = main(arguments)
        out, err = capsys.readouterr()
        return code, out, err

    return run


def test_walk_ends_with_a_table_and_survives(wbc_command, tmp_path):
    file = tmp_path / "new" / "report.json"
    code, out, err = wbc_command(
        "walk", *QUICK, "--velocity", "0.2", "0", "0", "--duration", "5", "--json", str(file)
    )
    assert code == 0
    for row in ("survived", "steps", "speed", "DCM", "peak torque", "QP failures", "tick"):
        assert row in out
    assert "m/s" in err, "no progress was shown"
    report = json.loads(file.read_text("utf-8"))
    assert set(report) >= KEYS
    assert report["robot"] == "simple_humanoid"
    assert report["survived"] is True
    assert report["fell_at_s"] is None
    assert report["steps"] >= 2
    assert report["distance_m"] > 0.2


def test_html_writes_a_recording(wbc_command, tmp_path):
    html = tmp_path / "walk.html"
    code, out, _ = wbc_command("walk", *QUICK, "--duration", "3", "--html", str(html))
    assert code == 0
    assert str(html) in out
    assert html.read_text("utf-8").lstrip().lower().startswith("<!doctype html>")


def test_a_fall_is_exit_code_1_and_says_when(wbc_command, tmp_path):
    file = tmp_path / "fall.json"
    code, out, _ = wbc_command(
        "stand", *QUICK, "--push", "0.5 0 200 0", "--duration", "3", "--json", str(file)
    )
    assert code == 1
    assert "FELL at" in out
    report = json.loads(file.read_text("utf-8"))
    assert report["survived"] is False
    assert 0.5 < report["fell_at_s"] < 3.0


def test_a_seed_gives_the_same_walk_again(wbc_command, tmp_path):
    reports = []
    for name in ("a", "b"):
        file = tmp_path / name
        wbc_command(
            "stand", *QUICK, "--duration", "0.5", "--seed", "3", "--terrain", "tiles",
            "--json", str(file),
        )  # fmt: skip
        reports.append(json.loads(file.read_text("utf-8")))
    first, second = reports
    assert first["dcm_error_rms_mm"] == second["dcm_error_rms_mm"]
    assert first["torque_peak_ratio"] == second["torque_peak_ratio"]


def test_walk_runs_with_ground_truth_and_another_solver(wbc_command):
    code, out, _ = wbc_command(
        "stand", *QUICK, "--duration", "0.2", "--ground-truth", "--solver", "osqp"
    )
    assert code == 0
    assert "survived" in out


def test_a_clamped_velocity_is_noted_in_one_line(wbc_command):
    code, _, err = wbc_command("walk", *QUICK, "--velocity", "9", "0", "0", "--duration", "0.3")
    notes = [line for line in err.splitlines() if line.startswith("note:")]
    assert code == 0
    assert len(notes) == 1
    assert "clamped" in notes[0]


def test_a_urdf_with_named_feet_needs_no_data_file(wbc_command):
    urdf = wbc.load("simple_humanoid").urdf_path
    code, out, _ = wbc_command(
        "stand", "--robot", str(urdf), "--left-foot", "left_foot", "--right-foot", "right_foot",
        "--no-view", "--duration", "0.2",
    )  # fmt: skip
    assert code == 0
    assert "survived" in out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((), "SUBCOMMAND"),
        (("wlak",), "'walk'"),
        (("walk", "--velocity", "1", "2"), "--velocity"),
        (("walk", "--velocity", "a", "0", "0"), "'a' is not a number"),
        (("walk", "--velocity", "nan", "0", "0"), "not a finite number"),
        (("walk", "--tour", "--velocity", "0", "0", "0"), "--tour"),
        (("walk", "--robot", "tallos", "--no-view"), "did you mean 'talos'"),
        (("walk", "--robot", "nowhere.urdf", "--no-view"), "no file nowhere.urdf"),
        (("walk", "--robot", str(CHAPTER), "--no-view"), "right_thigh"),
        (("walk", "--left-foot", "toe", "--no-view"), "no such link"),
        (("walk", "--srdf", "nowhere.srdf", "--no-view"), "nowhere.srdf"),
        (("walk", "--push", "1 2 3", "--no-view"), "T IX IY IZ"),
        (("walk", "--push", "1 2 3 x", "--no-view"), "'x' is not a number"),
        (("walk", "--push", "-1 2 3 0", "--no-view"), "must not be negative"),
        (("walk", *QUICK, "--push", "99 2 3 0"), "after the end"),
        (("walk", *QUICK, "--solver", "nosuch"), "nosuch"),
        (("walk", "--duration", "0", "--no-view"), "positive"),
        (("walk", "--seed", "-1", "--no-view"), "whole number"),
        (("walk", "--terrain", "hills"), "'tiles'"),
        (("walk", "--json", "/", "--no-view"), "is a folder"),
        (("walk", "--log", "/proc/nowhere.mcap", "--no-view"), "cannot write /proc/nowhere.mcap"),
        (("robots", "--left-foot", "toe"), "need a ROBOT"),
        (("walk", "--html", "/dev/null/x.html", "--no-view"), "/dev/null"),
        (("robots", "nosuch"), "no robot 'nosuch'"),
        (("view", "nosuch"), "no robot 'nosuch'"),
        (("doctor", "nowhere.urdf"), "no file nowhere.urdf"),
    ],
)
def test_bad_input_is_one_line_on_stderr_and_exit_code_2(wbc_command, arguments, words):
    code, out, err = wbc_command(*arguments)
    assert code == 2
    assert out == ""
    assert len(err.splitlines()) == 1
    assert words in err
    assert "Traceback" not in err


def test_a_malformed_urdf_is_one_line_that_names_the_line(wbc_command, tmp_path):
    file = tmp_path / "torn.urdf"
    file.write_text("<robot name='torn'>\n<link name='a'\n</robot>")
    code, _, err = wbc_command("walk", "--robot", str(file), "--no-view")
    assert code == 2
    assert "torn.urdf, line" in err
    assert len(err.splitlines()) == 1


def test_help_lists_subcommands_and_exit_codes_in_100_columns(wbc_command):
    code, out, _ = wbc_command("--help")
    assert code == 0
    for word in ("walk", "stand", "view", "robots", "doctor", "exit code"):
        assert word in out
    assert max(len(line) for line in out.splitlines()) <= 100


def test_version_is_that_of_the_library(wbc_command):
    assert wbc_command("--version")[:2] == (0, f"wbc {wbc.__version__}\n")


def test_robots_lists_what_was_derived_and_what_was_stated(wbc_command):
    code, out, _ = wbc_command("robots")
    assert code == 0
    lines = {line.split()[0]: line for line in out.splitlines() if line.split()}
    for name in ("talos", "g1", "romeo", "simple_humanoid"):
        assert name in lines
    for column in ("dof", "mass", "feet", "derived", "stated"):
        assert column in lines["robot"]
    assert "32" in lines["talos"]
    assert "90.3 kg" in lines["talos"]


def test_robots_by_name_lists_every_property_and_its_source(wbc_command):
    code, out, _ = wbc_command("robots", "talos")
    assert code == 0
    for word in ("left_sole_link", "stated", "derived", "talos.toml"):
        assert word in out


def test_doctor_reports_the_errors_of_a_description(wbc_command):
    code, out, err = wbc_command("doctor", str(CHAPTER))
    assert code == 1
    assert err == ""
    for word in ("right_thigh", "error", "cure:", "singular"):
        assert word in out.lower()


def test_doctor_accepts_a_robot_of_the_library(wbc_command):
    code, out, _ = wbc_command("doctor", "simple_humanoid")
    assert code == 0
    assert "error" not in out


def test_view_writes_a_page(wbc_command, tmp_path):
    page = tmp_path / "robot.html"
    code, out, _ = wbc_command("view", "simple_humanoid", "--html", str(page))
    assert code == 0
    assert out.strip() == str(page)
    assert page.stat().st_size > 100_000


def test_view_serves_a_page_until_its_time_is_over(wbc_command):
    code, out, _ = wbc_command("view", "simple_humanoid", "--duration", "0.3")
    assert code == 0
    assert "http://127.0.0.1:" in out


def test_a_run_is_shown_in_the_browser_without_no_view(wbc_command):
    code, out, _ = wbc_command("stand", "--robot", "simple_humanoid", "--duration", "0.2")
    assert code == 0
    assert out.startswith("Viewer: http://127.0.0.1:")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_and_sigterm_end_with_the_report_and_the_files_so_far(number, tmp_path):
    files = ["--log", str(tmp_path / "run.mcap"), "--html", str(tmp_path / "run.html")]
    process = start("stand", *QUICK, "--duration", "600", *files)
    assert process.stderr is not None
    process.stderr.readline()  # the first line of progress: it runs
    time.sleep(0.2)
    process.send_signal(number)
    out, err = process.communicate(timeout=30)
    assert process.returncode == 128 + number
    assert "interrupted" in out
    assert "Traceback" not in err
    log = Log(tmp_path / "run.mcap")
    assert log.complete
    assert "report" in log.tables
    assert "</html>" in (tmp_path / "run.html").read_text()[-100:]


def test_an_error_in_the_library_has_its_own_exit_code(wbc_command, monkeypatch):
    monkeypatch.setattr("wbc.cli.robots.available", lambda: 1 / 0)
    code, _, err = wbc_command("robots")
    assert code == 70
    assert "ZeroDivisionError" in err
    assert err.splitlines()[-1] == "wbc: this is an error in wbc; please report it"


def test_without_mujoco_the_cure_is_named(wbc_command, monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    code, _, err = wbc_command("walk", *QUICK)
    assert code == 2
    assert "wbc[sim]" in err
