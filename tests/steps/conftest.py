"""The contract says what differs when one of its tests fails, as a test file does."""

from __future__ import annotations

import pytest

pytest.register_assert_rewrite("tests.steps.step_contract", "tests.steps.step_rig")
