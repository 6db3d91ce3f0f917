"""What `wbc walk --hardware` asks before its controller takes over."""

from __future__ import annotations

import io

import pytest

from wbc.cli import hardware_run


def test_a_simulated_robot_is_walked_as_soon_as_its_feet_carry_it(capsys) -> None:
    ready = hardware_run._feet()
    assert [ready(load) for load in (0.0, 0.1, 0.9, None)] == [False, False, True, True]
    assert capsys.readouterr().err == "Lower the robot until its feet carry it.\n"


def test_the_operator_s_enter_counts_when_the_feet_carry_the_robot(monkeypatch, capsys) -> None:
    pressed: list[io.StringIO] = []
    monkeypatch.setattr("select.select", lambda *_: (list(pressed), [], []))
    ready = hardware_run._operator_and_feet()
    assert not ready(0.9)
    assert capsys.readouterr().err.endswith("then press Enter.\n")
    monkeypatch.setattr("sys.stdin", io.StringIO("\n"))
    pressed.append(io.StringIO())
    assert not ready(0.2)
    assert "carry 20 % of its weight" in capsys.readouterr().err
    assert ready(0.9)


@pytest.mark.parametrize("load", [None, 0.7])
def test_a_robot_without_joint_torques_is_left_to_the_operator(load, monkeypatch) -> None:
    monkeypatch.setattr("select.select", lambda *_: ([1], [], []))
    assert hardware_run._operator_and_feet()(load)
