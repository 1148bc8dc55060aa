"""Every mistake is one line on standard error and exit status 2."""

from __future__ import annotations

from pathlib import Path

import pytest

from deltactl.firmware_py.named_files import CONFIG_FOLDER

CIRCLE = (CONFIG_FOLDER / "circle.yaml").read_text()

MISTAKES: dict[str, tuple[str, str, str]] = {
    "unknown key": ("radius_m", "raduis_m", "did you mean 'radius_m'?"),
    "wrong type": ("radius_m: 0.1", "radius_m: wide", "radius_m"),
    "out of bounds": ("t_pwm_s: 0.006", "t_pwm_s: 0.00001", "t_pwm_s"),
    "unreachable": ("radius_m: 0.1", "radius_m: 0.9", "out of reach"),
    "no such robot": ("zhao-2023.yaml", "zhoa-2023.yaml", "zhao-2023.yaml"),
    "another robot's network": (
        "{kind: geometry}",
        "{kind: network, file: uzunovic-2013.tflite}",
        "uzunovic-2013",
    ),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_in_a_job_is_one_line(deltactl, tmp_path: Path, name: str) -> None:
    old, new, expected = MISTAKES[name]
    assert old in CIRCLE
    (tmp_path / "bad.yaml").write_text(CIRCLE.replace(old, new))
    for command in ("check", "run"):
        done = deltactl(command, "bad.yaml", status=2)
        *notes, line = done.stderr.splitlines()
        assert line.startswith("deltactl: ")
        assert expected in line
        assert all("running the simulated robot" in note for note in notes)
    assert not list(tmp_path.rglob("*.mcap"))


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (("run", "nothing.yaml"), "no such file"),
        (("report", "nothing.mcap"), "nothing.mcap"),
        (("status",), "daemon"),
        (("run", "circle.yaml", "--record", "circle.csv"), "ends in .mcap"),
        (("status", "sensors", "--calibrate", "q=1"), "z=0.412"),
        (("export", "nothing.mcap", "x.csv"), "nothing.mcap"),
        (("diagnose", "a.csv", "--robot", "axiss.yaml"), "deltactl init"),
    ],
)
def test_a_wrong_call_is_one_line(deltactl, arguments: tuple[str, ...], expected: str) -> None:
    done = deltactl(*arguments, status=2)
    lines = [line for line in done.stderr.splitlines() if line.startswith("deltactl: ")]
    assert len(lines) == 1
    assert expected in lines[0]


def test_a_recording_that_is_none_is_one_line(deltactl, tmp_path: Path) -> None:
    (tmp_path / "x.mcap").write_bytes(b"not a recording at all")
    done = deltactl("report", "x.mcap", status=2)
    assert "x.mcap" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_mistyped_recording_has_the_nearest_name_beside_it(deltactl, tmp_path: Path) -> None:
    (tmp_path / "circle.csv").write_text("t\n0\n")
    done = deltactl("diagnose", "cirlce.csv", "--robot", "zhao-2023.yaml", status=2)
    assert done.stderr.splitlines() == [
        "deltactl: cirlce.csv: no such file; did you mean 'circle.csv'?"
    ]


def test_what_breaks_a_limit_names_the_job_file_and_not_only_the_job(
    deltactl, tmp_path: Path
) -> None:
    (tmp_path / "large.yaml").write_text(CIRCLE.replace("radius_m: 0.1", "radius_m: 0.9"))
    for command in (("check", "large.yaml"), ("run", "large.yaml", "--simulate")):
        assert "deltactl: large.yaml: circle" in deltactl(*command, status=2).stderr


def test_a_job_in_mm_is_told_in_one_line_what_to_write(deltactl, tmp_path: Path) -> None:
    in_mm = CIRCLE.split("path:")[0] + (
        "path: {shape: circle, centre_m: [0, 0, -350], radius_m: 60}\n"
        "timing: {mode: accelerated, speed_mps: 100}\ninverse_kinematics: {kind: geometry}\n"
    )
    (tmp_path / "mm.yaml").write_text(in_mm)
    (line,) = deltactl("check", "mm.yaml", status=2).stderr.splitlines()
    assert "path.centre_m.2: this is in metres or m/s, not in mm: write -0.35 (and 0.06 for" in line
    assert "0.1 for timing.speed_mps)" in line


@pytest.mark.parametrize(
    ("place", "says"),
    [
        (("0", "0", "-900"), "goto: 0 0 -900 mm: out of reach"),
        (("260", "0", "-300"), "goto: 260 0 -300 mm: arm 1 would be at"),
    ],
)
def test_goto_names_the_place_as_it_was_typed(deltactl, place: tuple[str, ...], says: str) -> None:
    words = ("goto", *place, "--robot", "zhao-2023.yaml", "--simulate")
    (line,) = deltactl(*words, status=2).stderr.splitlines()
    assert says in line
    assert "repeat" not in line
    assert "that is" not in line
    assert "in m," not in line


def test_a_job_is_proposed_where_a_job_is_asked_for(deltactl, tmp_path: Path) -> None:
    """And a robot file where that is; the other has the name that is nearer."""
    (tmp_path / "stage.yaml").write_text("kind: delta\nname: stage\n")
    (tmp_path / "stages.yaml").write_text(CIRCLE)
    said = deltactl("check", "stag.yaml", status=2).stderr
    assert "did you mean 'stages.yaml'?" in said
    words = ("check", "stages.yaml", "--robot", "stagee.yaml")
    assert "did you mean 'stage.yaml'?" in deltactl(*words, status=2).stderr


def test_a_job_without_repeats_is_not_told_of_them(deltactl, tmp_path: Path) -> None:
    for radius_m, says in (("0.9", "point 0: target"), ("0.34", "deg")):
        (tmp_path / "far.yaml").write_text(CIRCLE.replace("radius_m: 0.1", f"radius_m: {radius_m}"))
        said = deltactl("check", "far.yaml", status=2).stderr
        assert says in said
        assert "repeat" not in said


def test_a_unit_that_people_write_is_recognised(deltactl, tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("t,q\n0,1\n1,2\n")
    (tmp_path / "axis.yaml").write_text("kind: servo_axis\nname: a\nmotion: rotary\n")
    words = ("diagnose", "log.csv", "--robot", "axis.yaml", "--set")
    said = deltactl(*words, "position=q[degs]", status=2).stderr
    assert "unknown unit 'degs'; did you mean 'deg'?" in said
    assert "unit must be one of" in deltactl(*words, "position=q[furlong]", status=2).stderr
