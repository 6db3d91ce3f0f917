"""`wbc robot`: a simulated robot behind the low-level interface of a real one."""

from __future__ import annotations

import math
from json import dumps
from typing import Annotated, Literal

import numpy as np

from wbc.cli.argument_types import Argument, OutputFile, Pushes, Seconds, number
from wbc.cli.exit_code import ExitCode
from wbc.cli.interrupt import exit_on_interrupt, graceful_interrupt


def robot(
    model: Literal["unitree-g1"],
    *,
    interface: Annotated[str, Argument("IFACE")] = "lo",
    seed: int = 0,
    latency: Annotated[float, Argument("S", number)] = 0.0,
    push: Pushes = (),
    duration: Seconds = math.inf,
    json: OutputFile | None = None,
) -> ExitCode:
    """Simulate a robot in real time that is commanded over its low-level interface.

    A stand-in for tests and for users without the robot: in another terminal, run
    wbc walk --hardware unitree --interface lo. The robot hangs in a gantry, which lowers it when
    its joints hold a posture and lets go when they get feed-forward torques. Its joints are
    damped when no command has come for 20 ms.

    Args:
        model: the robot.
        interface: network interface; lo for this computer only.
        seed: seed of sensor noise and start posture.
        latency: further age of a command when it reaches the servos, a multiple of 0.001 s.
        push: push the torso for 0.1 s with an impulse in N·s, in world axes, T s after the gantry
            has let go.
        duration: duration, s (default: until Ctrl-C).
        json: write the changes, the final pose and the timing as JSON.
    """
    with exit_on_interrupt():  # it imports and compiles
        from wbc.hardware.unitree.stand_in import G1StandIn
        from wbc.hardware.unitree.stand_in_server import serve
        from wbc.hardware.unitree.transport import DdsTransport, unitree_network

        stand_in = G1StandIn(seed=seed, latency=latency)
        transport = DdsTransport(unitree_network(interface), robot_side=True)
    for at, impulse in push:
        stand_in.schedule_push(at, impulse)
    changes: list[tuple[float, str]] = []

    def show(time: float, text: str) -> None:
        changes.append((time, text))
        print(f"{time:.3f} s: {text}", flush=True)

    print(f"{model} is on '{interface}'; press Ctrl-C to stop", flush=True)
    with graceful_interrupt() as interrupted:
        clock = serve(stand_in, transport, duration, stop=lambda: interrupted, on_change=show)
    transport.close()
    if json is not None:
        q = stand_in.plant.ground_truth().q
        result = {
            "changes": changes,
            "position_m": q[:3].tolist(),
            "corrupt_commands": stand_in.corrupt,
            "lateness_p99_us": 1e6 * float(np.percentile(clock.lateness, 99)),
            "overruns": clock.overruns,
        }
        json.write_text(dumps(result, indent=2) + "\n", "utf-8")
    return ExitCode.SUCCESS
