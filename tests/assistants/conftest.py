"""A folder as an assistant is given it: recordings, robot files, and what is wrong with some."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("mcp", reason="the assistants need the extra 'mcp'")

from tests.assistants.calls import SLIDE, write_slide

OUTSIDE = "a,b\n1,2\n"


@pytest.fixture(scope="session")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder; beside it lies what may not be read, and in it links to that."""
    above = tmp_path_factory.mktemp("above")
    (above / "secret.csv").write_text(OUTSIDE)
    (above / "secret.urdf").write_text("<robot name='secret'/>")
    folder = above / "root"
    (folder / "below").mkdir(parents=True)
    write_slide(folder / "slide.csv", 3)
    write_slide(folder / "below" / "late.csv", 4, 1.0, 0.03)
    rows = (folder / "slide.csv").read_text().splitlines()
    (folder / "short.csv").write_text("\n".join(rows[:6]) + "\n")
    (folder / "still.csv").write_text("\n".join([rows[0], *(f"{n / 50},0,0" for n in range(900))]))
    (folder / "noise.csv").write_bytes(bytes(range(256)) * 40)
    (folder / "torn.mcap").write_bytes(b"\x89MCAP0\r\n" + bytes(200))
    (folder / "empty.csv").write_text("")
    (folder / "slide.yaml").write_text(SLIDE)
    (folder / "wrong.yaml").write_text("kind: servo_axis\nname: x\nmotoin: linear\n")
    arm = "kind: chain\nname: arm\nmodel: {}\njoints: [one]\n"
    (folder / "arm.yaml").write_text(arm.format("../secret.urdf"))
    (folder / "includes.yaml").write_text(arm.format("includes.xml"))
    (folder / "includes.xml").write_text('<mujoco><include file="/etc/hostname"/></mujoco>')
    (folder / "link.csv").symlink_to(above / "secret.csv")
    (folder / "elsewhere").symlink_to(above)
    return folder
