"""The stand-in robot in real time on a wire."""

from __future__ import annotations

from collections.abc import Callable

from wbc.hardware.unitree.stand_in import PERIOD, G1StandIn
from wbc.hardware.unitree.transport import Transport
from wbc.robot.fall import fall_reason
from wbc.runtime.clock import Clock
from wbc.runtime.real_time import RealTime, garbage_collection_paused, real_time_thread


def serve(
    stand_in: G1StandIn,
    transport: Transport,
    duration: float,
    *,
    stop: Callable[[], object] = lambda: False,
    on_change: Callable[[float, str], object] = lambda time, text: None,
) -> Clock:
    """Simulate a robot in real time: a state message in every period, commands as they come.

    Args:
        stand_in: the robot.
        transport: the wire.
        duration: s.
        stop: asked in every period whether to end.
        on_change: called with the time, s, when the joints are damped, or commanded again, and
            when the robot has fallen.

    Returns:
        The clock, which knows how late each period began.
    """
    plant, damping, fell = stand_in.plant, True, False
    with garbage_collection_paused(), real_time_thread(RealTime(priority=41)):
        clock = Clock(PERIOD, round(min(duration / PERIOD, 1e6)))
        while plant.time < duration and not stop():
            clock.wait()
            while (data := transport.receive(0.0)) is not None:
                stand_in.take(data)
            stand_in.step()
            transport.send(stand_in.state_message())
            if stand_in.damping != damping:
                damping = stand_in.damping
                why = "no command came" if stand_in.damped else "by command"
                on_change(plant.time, f"damping: {why}" if damping else "commanded")
            if not fell and (reason := fall_reason(stand_in.robot, plant.ground_truth())):
                fell = True
                on_change(plant.time, f"fell: {reason}")
    return clock
