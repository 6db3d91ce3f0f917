"""Output that cannot be written: no traceback, no lost report, no exit code that means a fall."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys

import pytest
from clitools import QUICK, ROOT, environment, run, start

from wbc.cli import main
from wbc.cli.formatting import table

FULL = "/dev/full"
STAND = ("stand", *QUICK, "--duration", "0.1")
FALL = ("stand", *QUICK, "--push", "0.1 0 300 0", "--duration", "3")


@pytest.mark.parametrize(("command", "code"), [(("motion", "--list"), 0), (FALL, 1)])
def test_a_closed_pipe_is_silent_and_keeps_the_exit_code(command, code):
    process = start(*command)
    process.stdout.close()
    err = process.stderr.read()
    assert process.wait(timeout=120) == code
    assert "Traceback" not in err
    assert "wbc:" not in err
    process.stderr.close()


def test_a_full_device_is_an_error_of_its_own_and_files_are_still_written(tmp_path):
    file = tmp_path / "report.json"
    with open(FULL, "w") as full:
        code, _, err = run(*STAND, "--json", str(file), stdout=full)
    assert code == 3
    assert err.splitlines()[-1].startswith("wbc: cannot write to standard output")
    assert "Traceback" not in err
    assert json.loads(file.read_text("utf-8"))["survived"] is True


def test_a_full_standard_error_does_not_end_a_run():
    with open(FULL, "w") as full:
        code, out, _ = run(*STAND, stderr=full)
    assert code == 0
    assert "survived" in out


def test_without_standard_output_a_run_ends_as_usual():
    command = [sys.executable, "-m", "wbc", *STAND]
    done = subprocess.run(
        ["sh", "-c", 'exec "$@" >&-', "sh", *command],
        capture_output=True,
        text=True,
        env=environment(),
    )
    assert done.returncode == 0
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    "variables",
    [
        {"PYTHONIOENCODING": "ascii"},
        {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
    ],
)
def test_a_terminal_without_unicode_gets_the_report_in_ascii(variables):
    code, out, err = run(*STAND, env=environment(**variables))
    assert code == 0
    assert "survived" in out
    assert " us" in out
    assert (out + err).isascii()


def test_a_file_that_cannot_be_written_after_the_run_has_the_exit_code_of_lost_output():
    code, out, err = run(*STAND, "--json", FULL)
    assert code == 3
    assert "survived" in out
    assert err.splitlines()[-1] == f"wbc: cannot write {FULL}: No space left on device"


@pytest.mark.parametrize("option", ["--html", "--json", "--log", "--video"])
def test_a_file_that_cannot_be_written_is_refused_before_the_run(option, capsys):
    assert main((*STAND, option, "/proc/nowhere.mp4")) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert "cannot write /proc/nowhere.mp4" in err
    assert len(err.splitlines()) == 1


@pytest.mark.parametrize("option", ["--html", "--json", "--log", "--video"])
def test_a_full_disk_is_told_before_the_run_and_its_file_kept(
    option, tmp_path, capsys, monkeypatch
):
    kept = tmp_path / "kept.mp4"
    kept.write_text("before")
    usage = shutil.disk_usage(tmp_path)._replace(free=1000)
    monkeypatch.setattr("wbc.cli.argument_types.shutil.disk_usage", lambda folder: usage)
    assert main((*STAND, option, str(kept))) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert f"cannot write {kept}: its disk is full" in err
    assert kept.read_text() == "before"


def test_a_check_whether_a_file_can_be_written_leaves_no_file_and_changes_none(tmp_path, capsys):
    kept = tmp_path / "kept.json"
    kept.write_text("before")
    arguments = ("--robot", "nosuch", "--json", str(kept), "--html", str(tmp_path / "new.html"))
    assert main(("stand", *arguments)) == 2
    assert kept.read_text() == "before"
    assert "nosuch" in capsys.readouterr().err
    assert not (tmp_path / "new.html").exists()


def test_a_table_is_wrapped_to_the_terminal_and_not_otherwise():
    rows = [("talos", "base, soles, nominal posture, torso, imu and more " * 2)]
    wide = table(("robot", "derived"), rows).splitlines()
    assert len(wide) == 3
    narrow = table(("robot", "derived"), rows, width=60).splitlines()
    assert max(map(len, narrow)) <= 60
    assert " ".join(" ".join(narrow[2:]).split()) == " ".join(" ".join(wide[2:]).split())


def test_the_list_of_robots_has_a_line_per_robot_in_a_pipe(capsys):
    assert main(("robots",)) == 0
    out = capsys.readouterr().out
    assert [line.split()[0] for line in out.splitlines()[2:8]] == [
        *("g1", "g1_tour", "icub", "romeo", "simple_humanoid", "talos")
    ]


INTERRUPTED_IMPORT = """
import os, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)

class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == sys.argv[1]:
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Finder())
from wbc.cli import main
sys.exit(main(sys.argv[2:]))
"""


@pytest.mark.parametrize("module", ["wbc.cli.entry", "wbc.cli.stand", "pinocchio", "mujoco"])
def test_ctrl_c_during_an_import_is_silent(module):
    done = subprocess.run(
        [sys.executable, "-c", INTERRUPTED_IMPORT, module, *STAND],
        capture_output=True,
        text=True,
        cwd=ROOT,
        env=environment(),
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "")
