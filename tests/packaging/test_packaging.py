"""What the package brings, what it needs, and what `import wbc` loads."""

from __future__ import annotations

import ast
import importlib.metadata
import os
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from packaging.requirements import Requirement

import wbc

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
CORE = ("pin", "placo", "qpsolvers", "daqp", "osqp", "meshcat", "example-robot-data", "numpy")


def requirements(*extras: str) -> set[str]:
    """Names of what the project itself asks for, `wbc[…]` followed."""
    found: set[str] = set()
    lists = [PROJECT["dependencies"]]
    lists += [PROJECT["optional-dependencies"][extra] for extra in extras]
    for requirement in (Requirement(text) for texts in lists for text in texts):
        if requirement.name == "wbc":
            found |= requirements(*requirement.extras)
        else:
            found.add(requirement.name)
    return found


def everything_installed_for(names: set[str]) -> set[str]:
    """Names of these distributions and all that they need, as far as installed here."""
    seen: set[str] = set()
    waiting = list(names)
    while waiting:
        name = waiting.pop()
        if name in seen:
            continue
        try:
            needs = importlib.metadata.requires(name) or []
        except importlib.metadata.PackageNotFoundError:
            continue
        seen.add(name)
        for need in map(Requirement, needs):
            if need.marker is None or need.marker.evaluate({"extra": ""}):
                waiting.append(need.name)
    return seen


def test_core_and_extras_require_the_stated_packages():
    assert set(CORE) <= requirements()
    assert "mujoco" not in requirements()
    assert "mujoco" in requirements("sim")
    assert requirements("sim", "plots", "solvers") <= requirements("all")


def imported_packages() -> set[str]:
    """Top-level names of what the library's files import, the standard library left out."""
    found = set()
    for path in (ROOT / "wbc").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.Import):
                found |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
                found.add(node.module.partition(".")[0])
    # `typing_extensions` is only imported for type checkers, who bring it.
    return found - set(sys.stdlib_module_names) - {"wbc", "typing_extensions", "tomllib"}


def test_every_package_that_is_imported_is_declared():
    # Pinocchio's wheels install below a prefix of their own, which the metadata does not map.
    distributions = {name: [name] for name in ("coal", "cmeel", "placo")} | {"pinocchio": ["pin"]}
    distributions |= importlib.metadata.packages_distributions()
    declared = {name.lower().replace("_", "-") for name in requirements("all")}
    for package in imported_packages() - {"tomli"}:
        brought_by = {name.lower().replace("_", "-") for name in distributions[package]}
        assert brought_by & declared, f"{package} comes with {brought_by}: declare one of them"


def test_no_dependency_of_core_or_all_is_under_the_gpl():
    names = everything_installed_for(requirements("all"))
    assert len(names) > len(CORE)
    assert "quadprog" not in names
    for name in names:
        about = importlib.metadata.metadata(name)
        licences = [about.get("License-Expression") or "", (about.get("License") or "")[:80]]
        licences += [c for c in about.get_all("Classifier") or [] if c.startswith("License")]
        for licence in licences:
            # The LGPL lets anything use the library; the GPL does not.
            assert not re.search(r"(?<!L)\bA?GPL|(?<!Lesser )General Public", licence), (
                f"{name} is under {licence}"
            )


def test_licence_of_the_project_is_apache():
    assert PROJECT["license"] == "Apache-2.0"
    text = (ROOT / "LICENSE").read_text("utf-8")
    assert "Apache License" in text
    assert "END OF TERMS AND CONDITIONS" in text


def test_version_is_stated_once_and_the_changelog_begins_with_it_or_unreleased():
    assert "version" in PROJECT["dynamic"]
    changelog = (ROOT / "CHANGELOG.md").read_text("utf-8")
    newest = re.search(r"^## (.+)$", changelog, re.MULTILINE).group(1)
    assert newest.split(" ")[0] in ("Unreleased", wbc.__version__)


HEAVY = (
    *("clarabel", "cyclonedds", "daqp", "llvmlite", "matplotlib", "mcap", "meshcat", "mujoco"),
    *("numba", "osqp", "piqp", "placo", "proxsuite", "qpsolvers", "quadprog", "rosbags"),
    *("scipy", "scs", "tornado", "wbc.walking", "wbc.runtime.loop"),
)


def loaded(code: str) -> set[str]:
    """Which of the heavy modules a fresh Python has loaded after a line of code."""
    code += f"; import sys; print(*[m for m in {HEAVY!r} if m in sys.modules])"
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=True,
    )
    return set(done.stdout.split())


def test_import_wbc_loads_only_core_packages():
    assert loaded("import wbc") == set()


def test_loading_a_robot_imports_no_solver_and_no_controller():
    assert loaded("import wbc; wbc.load('simple_humanoid')") == set()


def test_simulator_imports_no_viewer():
    assert loaded("import wbc; wbc.sim.Mujoco").isdisjoint(
        {"meshcat", "tornado", "wbc.runtime.loop"}
    )


def test_every_public_name_can_be_imported():
    for name in wbc.__all__:
        assert getattr(wbc, name) is not None
    assert set(wbc.__all__) <= set(dir(wbc))
    with pytest.raises(AttributeError, match="nosuch"):
        _ = wbc.nosuch


def test_every_module_named_in_the_readme_is_available_after_import_wbc():
    text = (ROOT / "README.md").read_text("utf-8")
    names = {match.split(".")[1] for match in re.findall(r"wbc\.[a-zA-Z]+", text)}
    names -= {"mcap"}  # a file's ending
    code = f"import wbc; [getattr(wbc, name) for name in {sorted(names)}]"
    subprocess.run([sys.executable, "-c", code], check=True, cwd=ROOT)


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """A wheel of the project, unpacked far from the sources."""
    folder = tmp_path_factory.mktemp("wheel")
    done = subprocess.run(
        [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", folder, ROOT],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    with zipfile.ZipFile(next(folder.glob("wbc-*.whl"))) as archive:
        archive.extractall(folder / "installed")
    return folder / "installed"


def test_wheel_contains_the_page_the_licence_and_the_command(wheel):
    assert list(wheel.glob("wbc/view/page/*.html"))
    assert list(wheel.glob("wbc-*.dist-info/licenses/LICENSE"))
    assert "wbc = wbc.cli:main" in next(wheel.glob("*.dist-info/entry_points.txt")).read_text()
    assert not list(wheel.glob("tests*"))
