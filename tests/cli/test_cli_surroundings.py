"""What stands beside the program: threads of libraries, and robots of any size."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from deltactl.cli.output import decimals, millimetres

ROOT = Path(__file__).parents[2]


def test_no_thread_of_the_arithmetic_spins_beside_the_control_loop() -> None:
    asked = """
from deltactl.cli.main import main
try:
    main()
except SystemExit:
    import numpy
    from threadpoolctl import threadpool_info
    print(max(one["num_threads"] for one in threadpool_info()))
"""
    untold = {k: v for k, v in os.environ.items() if k != "OPENBLAS_NUM_THREADS"}
    done = subprocess.run(
        [sys.executable, "-c", asked, "--version"],
        env=untold, cwd=ROOT, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert done.stdout.splitlines()[-1] == "1"


@pytest.mark.parametrize(
    ("length_m", "shown"),
    [(0.0123, "12.30 mm"), (4.2e-6, "0.0042 mm"), (3.1e-8, "0.000031 mm"), (0.0, "0.00 mm"),
     (float("nan"), "-")],
)  # fmt: skip
def test_lengths_show_two_digits_of_whatever_size(length_m: float, shown: str) -> None:
    assert millimetres(length_m) == shown


def test_one_table_has_one_number_of_decimals() -> None:
    assert decimals([0.0015, 4.4e-5]) == 3
    assert decimals([0.0015, 0.005]) == 2
