"""Push a robot with two controllers, and compare what they survive."""

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import wbc
from wbc.trials import (
    ControllerSpec,
    Grid,
    RobotCases,
    compare,
    local_workers,
    run_grid,
    survival_rates,
)
from wbc.walking.gains import WalkerGains


def upright_walker(robot: wbc.Robot, dt: float) -> wbc.Walker:
    """A controller factory: the walker with a stiffer trunk."""
    return wbc.Walker(robot, dt, gains=replace(WalkerGains(), trunk_weight=60.0))


if __name__ == "__main__":  # worker processes import this file
    grid = Grid(
        robots=(RobotCases("simple_humanoid"),),  # standing; velocities=(0.3,) to walk
        sizes=(0.2, 0.4),
        phases=1,
        directions=("forward", "left"),
        duration=1.0,
    )
    results = {}
    with TemporaryDirectory() as folder, local_workers() as workers:
        for spec in (ControllerSpec(), ControllerSpec("upright", f"{__name__}:upright_walker")):
            output = Path(folder, f"{spec.name}.parquet")
            results[spec.name] = run_grid(replace(grid, controllers=(spec,)), output, workers)
    for name, result in results.items():
        for cell in survival_rates(result.trials):
            print(f"{name}: {cell.direction:.0f}°, {cell.largest_survived():g} N·s/kg survived")
    print("upright against walker:", compare(*results.values()).verdict.value)
