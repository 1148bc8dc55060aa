"""What the tests of the reproductions share: the command line, and a small survey."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.rigs.in_process import called

ROOT = Path(__file__).resolve().parents[2]
Cli = Callable[..., "subprocess.CompletedProcess[str]"]
LIMIT = (
    "import resource, signal, sys; signal.signal(signal.SIGXFSZ, signal.SIG_IGN); "
    "resource.setrlimit(resource.RLIMIT_FSIZE, ({0}, {0})); "
)
RUN = "from deltactl.cli.main import main; sys.argv[0] = 'deltactl'; main()"


@pytest.fixture(scope="session")
def cli() -> Cli:
    """Runs deltactl in a process of its own; `disk` is how large a file may grow [bytes]."""

    def run(
        *words: str | Path, disk: int | None = None, cwd: Path | None = None
    ) -> subprocess.CompletedProcess[str]:
        code = ("import sys; " if disk is None else LIMIT.format(disk)) + RUN
        environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "PYTHONPATH": str(ROOT)}
        return subprocess.run(
            [sys.executable, "-c", code, *map(str, words)],
            capture_output=True,
            text=True,
            timeout=110,
            cwd=cwd,
            env=environment,
            check=False,
        )

    return run


@pytest.fixture
def here(capsys: pytest.CaptureFixture[str]) -> Cli:
    """Runs deltactl's entry point in this process."""

    def run(*words: str | Path) -> subprocess.CompletedProcess[str]:
        return called(words, capsys)

    return run


@pytest.fixture(scope="session")
def surveyed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A data set of 120 samples of the as-built robot."""
    pytest.importorskip("mujoco", reason="the as-built robot needs the extra 'proof'")
    from deltactl.firmware_py.named_files import find
    from deltactl.firmware_py.robot_file import load_robot
    from deltactl.reproduction.zhao_2023.as_built import AS_BUILT_FILE, load_as_built
    from deltactl.reproduction.zhao_2023.collecting import collect

    folder = tmp_path_factory.mktemp("survey") / "data"
    robot = load_robot(find("zhao-2023.yaml"))
    collect(folder, robot, load_as_built(AS_BUILT_FILE, robot), 120, 1, lambda done: None)
    return folder
