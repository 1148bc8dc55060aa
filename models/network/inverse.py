"""Inverse kinematics by a network, in the TFLite interpreter that this Python has."""

from __future__ import annotations

import contextlib
import importlib
import math
import sys
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from deltactl.foundation.errors import LimitExceeded, NetworkError
from deltactl.models.inverse_kinematics import USE_GEOMETRY
from deltactl.models.network.file import NetworkFile
from deltactl.models.network.metadata import NetworkMetadata
from deltactl.models.robot import ARMS, DeltaRobot, FloatArray

RUNTIMES = ("tflite_runtime", "ai_edge_litert")
"""tflite-runtime: Python 3.9 to 3.11, numpy below 2. ai-edge-litert: 3.10 to 3.14."""


class Interpreter(Protocol):
    """The part of both runtimes' interpreter that is used here."""

    def allocate_tensors(self) -> None: ...
    def get_input_details(self) -> list[dict[str, Any]]: ...
    def get_output_details(self) -> list[dict[str, Any]]: ...
    def set_tensor(self, tensor_index: int, value: Any) -> None: ...
    def invoke(self) -> None: ...
    def get_tensor(self, tensor_index: int) -> Any: ...


def runtime_names() -> tuple[str, ...]:
    """The runtimes that can work here, the one meant for this Python first."""
    names = RUNTIMES if sys.version_info < (3, 12) else RUNTIMES[::-1]
    # With numpy 2, tflite-runtime imports and then fails in Interpreter().
    return tuple(
        name for name in names if name != "tflite_runtime" or np.__version__.startswith("1.")
    )


def open_interpreter(content: bytes) -> Interpreter:
    """An interpreter of a checked file's bytes, one thread, tensors allocated.

    Raises NetworkError when no runtime is installed or the runtime refuses the file.
    """
    module = _runtime()
    try:
        # Without delegates: for a few hundred weights the delegate's own cost is most of a
        # call, and the C++ code announces it on standard error.
        interpreter: Interpreter = module.Interpreter(
            model_content=content,
            num_threads=1,
            experimental_op_resolver_type=module.OpResolverType.BUILTIN_WITHOUT_DEFAULT_DELEGATES,
        )
        interpreter.allocate_tensors()
    except (ValueError, RuntimeError) as error:
        reason = str(error).splitlines()[0]
        raise NetworkError(f"the TFLite runtime refuses the network: {reason}") from error
    return interpreter


def load_runtime() -> None:
    """Import the runtime now, where the third of a second it takes does no harm."""
    with contextlib.suppress(NetworkError):
        _runtime()


def _runtime() -> Any:
    for name in runtime_names():
        try:
            return importlib.import_module(f"{name}.interpreter")
        except ImportError:
            continue
    wanted = RUNTIMES[0 if sys.version_info < (3, 12) else 1].replace("_", "-")
    raise NetworkError(
        f"no TFLite runtime for Python {sys.version_info.major}.{sys.version_info.minor} and "
        f"numpy {np.__version__}: install {wanted}, or {USE_GEOMETRY}"
    )


_SHAPE = [1, ARMS]


class InverseNetwork:
    """A loaded network of one robot. Not for two threads at once (the interpreter is not).

    Float32 in and out: angles carry about 1e-6 rad of rounding, a hundredth of a microstep.
    """

    def __init__(self, file: NetworkFile):
        """Load a checked file. Raises NetworkError when it is not (1, 3) to (1, 3) float32."""
        self.file = file
        self._interpreter = open_interpreter(file.content)
        self._input_index = _only_tensor(file, self._interpreter.get_input_details(), "input")
        self._output_index = _only_tensor(file, self._interpreter.get_output_details(), "output")
        self._input = np.zeros((1, ARMS), dtype=np.float32)
        self._contains = file.metadata.domain.contains
        self._low_rad, self._high_rad = map(math.radians, file.metadata.angle_deg)
        # Bound once: a look-up of a method is a noticeable part of a call of 3 us.
        self._set, self._get = self._interpreter.set_tensor, self._interpreter.get_tensor
        self._invoke = self._interpreter.invoke

    @classmethod
    def open(cls, path: Path, robot: DeltaRobot, follow: bool = True) -> InverseNetwork:
        """Load a file for a robot. Raises MissingFile, or NetworkError (also for another robot)."""
        file = NetworkFile.load(path, follow)
        file.check(robot)
        return cls(file)

    @property
    def metadata(self) -> NetworkMetadata:
        """What the file says about itself."""
        return self.file.metadata

    def angles_rad(self, x_m: float, y_m: float, z_m: float) -> tuple[float, float, float]:
        """Commanded arm angles [rad] of one target [m].

        Raises LimitExceeded outside the positions or angles the network was trained with.
        """
        if not self._contains(x_m, y_m, z_m):
            raise self._outside(x_m, y_m, z_m)
        self._input[0] = (x_m, y_m, z_m)
        self._set(self._input_index, self._input)
        self._invoke()
        first, second, third = self._get(self._output_index)[0].tolist()
        low, high = self._low_rad, self._high_rad
        if not (low <= first <= high and low <= second <= high and low <= third <= high):
            raise self._beyond((x_m, y_m, z_m), (first, second, third))
        return first, second, third

    def angles_rad_many(self, position_m: FloatArray) -> FloatArray:
        """Angles [rad] of targets [m], both of shape (n, 3), one call a target.

        One call for all would use other kernels and could round to other counts.
        Raises LimitExceeded at the first target outside the domain.
        """
        targets = np.asarray(position_m, dtype=np.float64).reshape(-1, ARMS).tolist()
        angles = [self.angles_rad(x_m, y_m, z_m) for x_m, y_m, z_m in targets]
        return np.array(angles, dtype=np.float64).reshape(-1, ARMS)

    def raw_rad_many(self, position_m: FloatArray) -> FloatArray:
        """`angles_rad_many` without refusing anything: for measuring errors, not for moving."""
        answers = np.empty((len(position_m), ARMS))
        for row, target in enumerate(np.asarray(position_m, dtype=np.float32)):
            self._set(self._input_index, target[None])
            self._invoke()
            answers[row] = self._get(self._output_index)[0]
        return answers

    def _outside(self, x_m: float, y_m: float, z_m: float) -> LimitExceeded:
        return LimitExceeded(
            f"target ({x_m:.4f}, {y_m:.4f}, {z_m:.4f}) m is outside what {self.file.path.name} "
            f"was trained for ({self.metadata.domain.describe()}); "
            f"move the path inside or {USE_GEOMETRY}"
        )

    def _beyond(
        self, target_m: tuple[float, float, float], angles_rad: tuple[float, float, float]
    ) -> LimitExceeded:
        x_m, y_m, z_m = target_m
        low_deg, high_deg = self.metadata.angle_deg
        answer = ", ".join(f"{math.degrees(angle):.2f}" for angle in angles_rad)
        return LimitExceeded(
            f"target ({x_m:.4f}, {y_m:.4f}, {z_m:.4f}) m needs arm angles ({answer}) deg, outside "
            f"the {low_deg:g} to {high_deg:g} deg {self.file.path.name} was trained with; "
            f"move the path inside or {USE_GEOMETRY}"
        )


def _only_tensor(file: NetworkFile, details: list[dict[str, object]], role: str) -> int:
    index = details[0]["index"] if len(details) == 1 else None
    if not isinstance(index, int) or details[0]["dtype"] is not np.float32:
        raise NetworkError(f"{file.path}: must have one float32 {role}; train it again")
    shape = [int(size) for size in np.asarray(details[0]["shape"])]
    if shape != _SHAPE:
        raise NetworkError(f"{file.path}: its {role} has shape {shape}, not {_SHAPE}")
    return index
