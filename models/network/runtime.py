"""Picks the TFLite interpreter this Python has."""

from __future__ import annotations

import contextlib
import importlib
import sys
from typing import Any, Protocol

import numpy as np

from deltactl.foundation.errors import NetworkError
from deltactl.models.inverse_kinematics import USE_GEOMETRY

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
