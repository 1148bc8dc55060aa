"""Commands of README and docs that no test types, and why; their options are parsed all the same.

The others are typed: on a clean clone (test_clean_clone.py), or with small files that a test writes
in the reader's place (test_with_a_readers_files.py). A command that stands nowhere fails
test_documented_commands.py.
"""

from __future__ import annotations

UNTYPED: dict[str, tuple[str, ...]] = {
    "needs root on a Raspberry Pi, and changes it": (
        "sudo apt install git make python3-pip python3-venv python3-lgpio",
        "umask 022",
        "sudo install -d -o $USER /opt/deltactl",
        "git clone REPOSITORY /opt/deltactl",
        "cd /opt/deltactl",
        "sudo .venv/bin/deltactl service install --robot config/my-delta.yaml --apply",
        "sudo reboot",
        "sudo cp /opt/deltactl/systemd/deltactl-web.service /etc/systemd/system/",
        "sudo systemctl enable --now deltactl-web",
        "sudo cp /opt/deltactl/systemd/deltactl-checks.service /etc/systemd/system/",
        "sudo systemctl enable --now deltactl-checks",
    ),
    "needs the reader's robot on a Raspberry Pi; the daemon on a modelled one: tests/hil": (
        "deltactl init delta config/my-delta.yaml --wiring",
        "deltactl service install --robot config/my-delta.yaml",
        "deltactl run config/my-delta-circle.yaml",
    ),
    "installs outside the clone; make run installs the same on a clean clone": (
        'pipx install ".[web]" --pip-args="-c $PWD/constraints.txt"',
        'pip install ".[web]" -c constraints.txt',
    ),
    "builds and installs a release, which .ci/run does": ("make release-check", "make site"),
    "runs the tests, of which this is one": ("make test", "make newcomer", "make studies"),
    "checks style and types of all code, which .ci/run does": ("make check", "make test-page"),
    "runs until it is stopped; started and used in tests/web": (
        "deltactl web --simulate",
        "deltactl web --host 0.0.0.0 --users users.yaml --certificate page.pem --key page.key",
        "deltactl web foxglove",
    ),
    "asks for a password; tests/web answers it": ("deltactl web user ada --file users.yaml",),
    "needs a log of ROS 2; tests/recording writes such logs": (
        "deltactl diagnose run.mcap --robot axis.yaml --columns t=/joint_states.header.stamp"
        " --columns position=/joint_states.position.elbow --columns command=/target.data",
    ),
    "is what make demo does, on a clean clone": ("deltactl demo",),
    "surveys for minutes, then diagnoses and trains: as make demo does, on a clean clone": (
        "deltactl run survey.yaml --record survey.mcap",
        "deltactl correct survey.mcap --robot zhao-2023.yaml --out mine.yaml",
    ),
    "surveys for minutes; tests/cli/test_heal.py types it with a short survey": (
        "deltactl heal mine.yaml",
    ),
    "takes hours; a short form of each is in tests/proof, tests/reproduction and tests/training": (
        "deltactl demo prove --repair --cases 104 --seed 2 --networks --out repair-2",
        "deltactl demo prove --machine axis --cases 100 --half even --seed 2000 --out axes-even",
        "deltactl demo prove --machine axis --cases 0 --practice ../shared/recordings/practice_axes"
        " --out practice",
        "deltactl demo prove --cases 3000 --seed 8 --out proof-8 --scheduler tcp://host:8786",
        "deltactl demo prove --cases 1 --ties 0 --more 100 --seed 7 --out proof-7",
        "deltactl demo prove --cases 300 --more 60 --ties 0 --seed 299792458 --out proof-299792458",
        "deltactl demo prove --cases 300 --more 60 --ties 0 --seed 137035999 --out proof-137035999",
        "deltactl network collect --samples 5000 --as-built zhao-2023 --out data",
        "deltactl network train data --recipe zhao --out zhao.tflite",
        "deltactl network evaluate zhao.tflite --data data --as-built zhao-2023",
        "deltactl network reproduce zhao-2023 --out zhao",
        "deltactl network reproduce uzunovic-2013 --out uzunovic",
        "deltactl network reproduce uzunovic-2013",
        "python -m deltactl.reproduction.uzunovic_2013.control --out DIR",
        "python -m deltactl.reproduction.uzunovic_2013.control_blind --out DIR --cases 36",
        "python -m deltactl.proof.micro.checks",
        "python benchmarks/costs/micro.py",
    ),
}
"""Reason -> commands, as they stand in the text."""

WHY = {command: reason for reason, commands in UNTYPED.items() for command in commands}
