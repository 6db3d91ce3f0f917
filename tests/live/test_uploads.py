"""Files that pages send: only these and those where wbc was started can be named."""

import asyncio
import io
import zipfile

import pytest

from wbc.live.description_check import examined
from wbc.live.uploads import ROBOT_SUFFIXES, Uploads
from wbc.teleop import CommandRefused

URDF = b"<robot name='r'><link name='base'/></robot>"


@pytest.fixture
def uploads(tmp_path, monkeypatch):
    here, folder = tmp_path / "here", tmp_path / "uploads"
    here.mkdir()
    folder.mkdir()
    (here / "own.csv").write_text("t")
    (here / "pipe.csv").symlink_to("/dev/zero")
    monkeypatch.chdir(here)
    return Uploads(folder)


def archive(**files):
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as target:
        for name, content in files.items():
            target.writestr(name, content)
    return packed.getvalue()


def test_a_file_is_found_by_its_name_and_the_last_one_counts(uploads):
    assert uploads.save("r.urdf", b"<robot/>") == "r.urdf"
    assert uploads.save("r.urdf", URDF) == "r.urdf"
    assert uploads.names == ["own.csv", "r.urdf"]
    assert uploads.find("r.urdf", ROBOT_SUFFIXES).read_bytes() == URDF
    assert uploads.find("own.csv", (".csv",)).read_text() == "t"


@pytest.mark.parametrize("name", ["../own.csv", "/etc/passwd", "pipe.csv", "r.urdf", 3, ""])
def test_no_other_file_can_be_named(uploads, name):
    with pytest.raises(CommandRefused, match="no file"):
        uploads.find(name, (".csv", ".urdf"))


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("../r.urdf", URDF),
        ("r.py", b""),
        (".urdf", URDF),
        ("r.zip", b"no archive"),
        ("r.zip", archive(**{"a.urdf": URDF, "b.urdf": URDF})),
        ("r.zip", archive(**{"mesh.stl": b""})),
        ("r.urdf", b"<robot xmlns:xacro='x'><xacro:property/></robot>"),
    ],
)
def test_what_is_no_single_description_is_refused(uploads, name, content):
    with pytest.raises(CommandRefused):
        uploads.save(name, content)
    assert uploads.names == ["own.csv"]


def test_an_archive_is_unpacked_inside_its_folder_only(uploads, tmp_path):
    content = archive(**{"../../evil.urdf": URDF, "meshes/a.stl": b"mesh"})
    name = uploads.save("robot.zip", content)
    assert uploads.find(name, ROBOT_SUFFIXES).is_relative_to(tmp_path / "uploads" / "1")


def test_the_findings_about_a_description_name_what_is_wrong(tmp_path):
    path = tmp_path / "r.urdf"
    path.write_bytes(URDF)
    findings = asyncio.run(examined(path))
    assert findings[0]["severity"] == "error"
    assert set(findings[0]) == {"severity", "subject", "what", "consequence", "cure"}
