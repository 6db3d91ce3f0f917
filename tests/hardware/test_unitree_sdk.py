"""The maker's own SDK exchanges both topics with this library.

It needs an environment of its own, whose interpreter `WBC_UNITREE_PYTHON` names:

    python -m venv sdk
    sdk/bin/pip install --no-deps unitree-sdk2 'cyclonedds>=11,<12' rich-click
    sdk/bin/pip install fastcrc
"""

from __future__ import annotations

import json
import os
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest

from wbc.hardware.unitree.messages import LOW_COMMAND, LOW_STATE, MessageBuffer
from wbc.hardware.unitree.transport import DdsTransport
from wbc.ros.network import Network

PYTHON = os.environ.get("WBC_UNITREE_PYTHON", "")
PEER = Path(__file__).resolve().parents[1] / "tools" / "unitreepeer.py"
pytestmark = pytest.mark.skipif(
    not PYTHON, reason="WBC_UNITREE_PYTHON names no interpreter with the maker's SDK"
)


def known_command(count: int) -> bytes:
    buffer = MessageBuffer(LOW_COMMAND)
    fields, i = buffer.fields, np.arange(35)
    fields["mode_machine"], fields["reserve"] = 5, (1, 2, 3, 4)
    motors = fields["motor_cmd"][0]
    motors["mode"], motors["q"], motors["dq"] = 1, 0.01 * i + count, -0.02 * i
    motors["tau"], motors["kp"], motors["kd"] = 0.5 * i, 10.0 + i, 1.0 + i
    return buffer.encode()


def decoded(data: bytes) -> bytes:
    """Return a received command with its padding, which may hold anything, cleared."""
    buffer = MessageBuffer(LOW_COMMAND)
    assert buffer.decode(data)
    return buffer.encode()


def test_a_command_has_the_same_bytes_and_checksum_as_the_sdk_s() -> None:
    done = subprocess.run(
        [PYTHON, str(PEER), "serialize"], capture_output=True, text=True, timeout=60, check=True
    )
    theirs = bytes.fromhex(done.stdout)
    assert decoded(theirs) == known_command(3)


def test_the_sdk_receives_states_and_its_commands_are_received() -> None:
    network = Network(111)
    transport = DdsTransport(network, robot_side=True)
    state = MessageBuffer(LOW_STATE)
    fields = state.fields
    fields["mode_machine"], fields["tick"] = 5, 4321
    fields["motor_state"]["q"][0] = np.arange(35)
    fields["motor_state"]["tau_est"][0] = -np.arange(35)
    fields["imu_state"]["quaternion"][0] = (1.0, 0.5, 0.25, 0.125)
    fields["imu_state"]["accelerometer"][0] = (1.0, 2.0, 3.0)
    sent = state.encode()
    xml = network.xml()
    peer = subprocess.Popen(
        [PYTHON, str(PEER), "exchange", "111", xml], stdout=subprocess.PIPE, text=True
    )
    received, end = [], time.monotonic() + 30.0
    while peer.poll() is None and time.monotonic() < end:
        transport.send(sent)
        if (data := transport.receive(0.02)) is not None:
            received.append(data)
    output = peer.communicate(timeout=10.0)[0]
    transport.close()
    theirs = json.loads(output)
    again = MessageBuffer(LOW_STATE)
    assert again.decode(bytes.fromhex(theirs["bytes"]))
    assert again.encode() == sent
    assert theirs["crc"] == theirs["crc_by_sdk"] == int(fields["crc"][0])
    assert (theirs["tick"], theirs["machine"]) == (4321, 5)
    assert theirs["q"] == list(range(35))
    assert theirs["tau"] == [-i for i in range(35)]
    assert theirs["quaternion"] == [1.0, 0.5, 0.25, 0.125]
    assert theirs["accelerometer"] == [1.0, 2.0, 3.0]
    assert len(received) >= 10
    commands = [decoded(data) for data in received]
    counts = [round(float(np.frombuffer(data, "<f4", 1, 8)[0])) for data in commands]
    assert commands == [known_command(count) for count in counts]
