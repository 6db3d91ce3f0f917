"""What several modules of tests need running: a real browser, a robot as a ROS 2 node."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator
from typing import Any

import pytest
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


@pytest.fixture(scope="session", autouse=True)
def kernels() -> None:
    """Compiled before the first test: in no test's time or output, nor in a process's it starts."""
    load_qp_kernels()
    importlib.import_module("wbc.walking.kernels")


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    need_browser()
    with new_browser(SOFTWARE) as browser:
        yield browser


@pytest.fixture(scope="module")
def domain() -> int:
    """A DDS domain of the module's own."""
    from rostools import new_domain

    return new_domain()


@pytest.fixture(scope="module")
def walking(domain: int) -> Iterator[Any]:
    """The process of a robot that a ROS 2 system drives."""
    from rostools import Peer

    arguments = ("--robot", "simple_humanoid", "--duration", "3000", "--as-fast-as-possible")
    with Peer.wbc(domain, "ros2", "walk", *arguments) as peer:
        yield peer


@pytest.fixture(scope="module")
def driver(walking: Any, domain: int) -> Iterator[Any]:
    """A node beside it."""
    from rostools import node

    with node("driver", domain) as made:
        yield made


@pytest.fixture(scope="module")
def try_parameter(driver: Any) -> Callable[..., Any]:
    """Asks the robot's node for a parameter's value; returns what it answers."""
    from rostools import PATIENCE

    from wbc.messages import message_type

    client = driver.create_client("rcl_interfaces/srv/SetParameters", "/wbc/set_parameters")
    parameter = message_type("rcl_interfaces/msg/Parameter")
    value = message_type("rcl_interfaces/msg/ParameterValue")

    def ask(name: str, **fields: Any) -> Any:
        request = client.request_type(parameters=[parameter(name=name, value=value(**fields))])
        return client.call(request, PATIENCE).results[0]

    return ask


@pytest.fixture(scope="module")
def set_parameter(try_parameter: Callable[..., Any]) -> Callable[..., None]:
    def set_one(name: str, **fields: Any) -> None:
        result = try_parameter(name, **fields)
        assert result.successful, result.reason

    return set_one
