"""What several modules of tests need running: a real browser, a robot as a ROS 2 node."""

from __future__ import annotations

import gc
import importlib
import os
from collections.abc import Callable, Iterator
from typing import Any

# Before numpy is imported: several processes that each use all cores wait for one another.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest
from compile_kernels import compile_kernels
from hypothesis import HealthCheck, settings
from needs import need_browser

from wbc.qp import load_qp_kernels
from wbc.view.browser import SOFTWARE, new_browser

# Times vary on a shared machine: no deadline, and no complaint about slow generation. Examples
# are drawn from a fixed seed, on a developer's machine as in CI.
settings.register_profile(
    "calm", deadline=None, suppress_health_check=list(HealthCheck), derandomize=True
)
settings.load_profile("calm")


def pytest_configure(config: pytest.Config) -> None:
    """Compile the kernels once, before there are several workers that would all compile them."""
    if config.getoption("numprocesses", None) and not hasattr(config, "workerinput"):
        compile_kernels()


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Distribute files, but for those with pages: a worker runs them one after the other.

    Browsers and robots in real time take each other's processor time and wait for it. The motions'
    default buttons share nothing, and take longer than all other slow files.
    """
    from xdist.scheduler import LoadFileScheduling

    class Scheduling(LoadFileScheduling):
        def _split_scope(self, nodeid: str) -> str:
            file: str = super()._split_scope(nodeid)
            if file.startswith(("tests/live/", "tests/view/")):
                return "pages"
            return nodeid if file == "tests/motions/test_default_motions.py" else file

    return Scheduling(config, log)


@pytest.fixture(scope="session", autouse=True)
def kernels() -> None:
    """Load the kernels before the first test, outside of its time and output."""
    load_qp_kernels()
    importlib.import_module("wbc.walking.kernels")


@pytest.fixture(scope="session", autouse=True)
def frozen_objects(kernels: None) -> None:
    """Have each run of the loop collect garbage among what is new, not all that was imported."""
    gc.collect()
    gc.freeze()


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    need_browser()
    with new_browser(SOFTWARE) as browser:
        yield browser


@pytest.fixture(scope="module")
def domain() -> int:
    """DDS domain that only this module uses."""
    from rostools import unused_domain

    return unused_domain()


@pytest.fixture(scope="module")
def walking_robot(domain: int) -> Iterator[Any]:
    """Process of a simulated robot that ROS 2 nodes can command."""
    from rostools import PeerProcess

    arguments = ("--robot", "simple_humanoid", "--duration", "3000", "--as-fast-as-possible")
    with PeerProcess.start_wbc(domain, "ros2", "walk", *arguments) as peer:
        yield peer


@pytest.fixture(scope="module")
def client_node(walking_robot: Any, domain: int) -> Iterator[Any]:
    """Node that observes and commands the robot."""
    from rostools import node

    with node("client_node", domain) as made:
        yield made


@pytest.fixture(scope="module")
def try_parameter(client_node: Any) -> Callable[..., Any]:
    """Sets a parameter of the robot's node to a bool, float or list; returns the result."""
    from rostools import TIMEOUT

    from wbc.messages import message_type

    client = client_node.create_client("rcl_interfaces/srv/SetParameters", "/wbc/set_parameters")
    parameter_type = message_type("rcl_interfaces/msg/ParameterType")
    parameter = message_type("rcl_interfaces/msg/Parameter")
    parameter_value = message_type("rcl_interfaces/msg/ParameterValue")
    type_names = {bool: "bool", float: "double", list: "double_array"}

    def call(name: str, value: Any) -> Any:
        kind = type_names[type(value)]
        number = getattr(parameter_type, f"PARAMETER_{kind.upper()}")
        message = parameter_value(**{"type": number, f"{kind}_value": value})
        request = client.request_type(parameters=[parameter(name=name, value=message)])
        return client.call(request, TIMEOUT).results[0]

    return call


@pytest.fixture(scope="module")
def set_parameter(try_parameter: Callable[..., Any]) -> Callable[..., None]:
    """Sets a parameter of the robot's node; the test fails if the value is refused."""

    def call(name: str, value: Any) -> None:
        result = try_parameter(name, value)
        assert result.successful, result.reason

    return call
