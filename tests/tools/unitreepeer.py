"""The controller's side in the maker's message classes; runs in an environment of its own.

python unitreepeer.py serialize    prints the bytes of a command with known values, hexadecimal
python unitreepeer.py exchange     sends commands and prints one state, as JSON, that it receives
"""

import importlib
import importlib.util
import json
import sys
import time
import types
import unittest.mock


def message_classes():
    """Import the SDK's messages by their subpackage: its `__init__` imports what it lacks."""
    root = importlib.util.find_spec("unitree_sdk2py")
    for name in ("unitree_sdk2py", "unitree_sdk2py.idl", "unitree_sdk2py.utils"):
        package = types.ModuleType(name)
        package.__path__ = [root.submodule_search_locations[0] + name[14:].replace(".", "/")]
        sys.modules[name] = package
    return importlib.import_module("unitree_sdk2py.idl.unitree_hg.msg.dds_")


def make_command(dds, count):
    motors = [
        dds.MotorCmd_(1, 0.01 * i + count, -0.02 * i, 0.5 * i, 10.0 + i, 1.0 + i, 0)
        for i in range(35)
    ]
    return dds.LowCmd_(0, 5, motors, [1, 2, 3, 4], 0)


def checksum(message):
    """The SDK's own packing of a message into words, and CRC-32/MPEG-2 over them.

    The CRC is of the library that the SDK's newer source uses: the package lacks its own.
    """
    from fastcrc import crc32

    with unittest.mock.patch("ctypes.CDLL"):
        maker = importlib.import_module("unitree_sdk2py.utils.crc").CRC()
    kind = type(message).__name__.rstrip("_")
    words = getattr(maker, f"_CRC__PackHG{kind}")(message)
    return crc32.mpeg_2(b"".join(word.to_bytes(4, "big") for word in words))


def completed(command):
    command.crc = checksum(command)
    return command


def main():
    dds = message_classes()
    if sys.argv[1] == "serialize":
        print(completed(make_command(dds, 3)).serialize().hex())
        return
    from cyclonedds.domain import Domain, DomainParticipant
    from cyclonedds.pub import DataWriter
    from cyclonedds.sub import DataReader
    from cyclonedds.topic import Topic

    number = int(sys.argv[2])
    domain = Domain(number, sys.argv[3])
    participant = DomainParticipant(number)
    # The SDK gives its endpoints no quality of service of their own.
    writer = DataWriter(participant, Topic(participant, "rt/lowcmd", dds.LowCmd_))
    reader = DataReader(participant, Topic(participant, "rt/lowstate", dds.LowState_))
    assert domain is not None
    end, count, received = time.monotonic() + 20.0, 0, None
    while time.monotonic() < end and (received is None or count < 50):
        writer.write(completed(make_command(dds, count)))
        count += 1
        for state in reader.take(10):
            if state.sample_info.valid_data:
                received = state
        time.sleep(0.02)
    assert received is not None, "no state was received"
    print(
        json.dumps(
            {
                "tick": received.tick,
                "machine": received.mode_machine,
                "crc": received.crc,
                "crc_by_sdk": checksum(received),
                "q": [m.q for m in received.motor_state],
                "tau": [m.tau_est for m in received.motor_state],
                "quaternion": list(received.imu_state.quaternion),
                "accelerometer": list(received.imu_state.accelerometer),
                "bytes": received.serialize().hex(),
            }
        )
    )


main()
