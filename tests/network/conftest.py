"""Small networks to test with, and an evaluator that shares no code with the runtime."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tflite

from deltactl.models.network import Box, NetworkFile
from deltactl.models.robot import DeltaRobot, Geometry
from deltactl.models.training.export import Effort, to_file
from deltactl.models.training.graph import Activation, Graph
from deltactl.models.training.perceptron import Perceptron, add_layers
from deltactl.models.training.recipe import Task, Trained

DOMAIN = Box(x_m=(-0.1, 0.1), y_m=(-0.1, 0.1), z_m=(-0.5, -0.4))


@dataclass(frozen=True)
class RandomNetwork:
    """An untrained perceptron in float64 and as what training hands to the export."""

    perceptron: Perceptron
    parameters: Any
    trained: Trained

    def values(self, position_m: Any) -> Any:
        return self.perceptron.values(self.parameters, position_m)


def _delta(name: str = "bench", **changes: Any) -> DeltaRobot:
    geometry: dict[str, Any] = {
        "base_radius_m": 0.325,
        "platform_radius_m": 0.075,
        "upper_arm_m": 0.25,
        "forearm_m": 0.5,
    }
    return DeltaRobot(kind="delta", name=name, geometry=Geometry(**(geometry | changes)))


def _random_network(
    sizes: tuple[int, ...] = (3, 4, 3), activation: Activation = "tanh", seed: int = 0
) -> RandomNetwork:
    network = Perceptron(sizes, activation)
    # A sigmoid passes on a quarter of what comes in: deep ones are constant without this.
    gain = 4.0 if activation == "sigmoid" else 1.0
    parameters = gain * network.start(np.random.default_rng(seed))
    graph = Graph()
    source = graph.input("position_m", (1, sizes[0]))
    result = add_layers(graph, source, network.layers(parameters), activation)
    trained = Trained(graph, source, result, "random", str(sizes), network.parameters, samples=1)
    return RandomNetwork(network, parameters, trained)


@pytest.fixture
def make_robot() -> Callable[..., DeltaRobot]:
    """A robot of Zhao's size unless told otherwise."""
    return _delta


@pytest.fixture
def make_network() -> Callable[..., RandomNetwork]:
    return _random_network


@pytest.fixture
def task() -> Task:
    return Task(_delta(), DOMAIN, seed=3)


@pytest.fixture
def write(tmp_path: Path, task: Task) -> Callable[..., NetworkFile]:
    """Writes a network for the `task`'s robot and reads it back."""

    def to_disk(network: RandomNetwork, name: str = "bench.tflite") -> NetworkFile:
        to_file(tmp_path / name, network.trained, task, Effort(samples=10, rounds=0))
        return NetworkFile.load(tmp_path / name)

    return to_disk


@pytest.fixture
def in_float64() -> Callable[[bytes, Any], Any]:
    """Evaluates a file's graph in numpy: float32 weights, float64 arithmetic."""
    return _evaluate


def _evaluate(content: bytes, position_m: Any) -> Any:
    model = tflite.Model.GetRootAs(content)
    graph = model.Subgraphs(0)
    values: dict[int, Any] = {graph.Inputs(0): np.asarray(position_m, dtype=np.float64)}
    for index in range(graph.TensorsLength()):
        tensor = graph.Tensors(index)
        data = model.Buffers(tensor.Buffer()).DataAsNumpy()
        if not isinstance(data, int):
            kind = "<i4" if tensor.Type() == tflite.TensorType.INT32 else "<f4"
            values[index] = data.view(kind).reshape(tensor.ShapeAsNumpy())
    for number in range(graph.OperatorsLength()):
        operator = graph.Operators(number)
        code = model.OperatorCodes(operator.OpcodeIndex()).BuiltinCode()
        inputs = [values[operator.Inputs(i)] for i in range(operator.InputsLength())]
        values[operator.Outputs(0)] = _OPERATIONS[code](*inputs)
    return values[graph.Outputs(0)]


_OPERATIONS: dict[int, Callable[..., Any]] = {
    tflite.BuiltinOperator.FULLY_CONNECTED: lambda x, w, b: x @ w.astype(float).T + b,
    tflite.BuiltinOperator.TANH: np.tanh,
    tflite.BuiltinOperator.LOGISTIC: lambda x: 1.0 / (1.0 + np.exp(-x)),
    tflite.BuiltinOperator.MUL: np.multiply,
    tflite.BuiltinOperator.RESHAPE: np.reshape,
}
