"""Files written without TensorFlow compute what numpy computes from the same weights."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from deltactl.models.network import InverseNetwork, NetworkFile
from deltactl.models.network.inverse import open_interpreter
from deltactl.models.training.graph import Graph
from deltactl.models.training.perceptron import Scaling, fold

ZHAO_SIZES = (3, *[50] * 8, 3)
"""Zhao 2023, section 3: eight hidden layers of 50 sigmoid neurons."""
UZUNOVIC_SIZES = (3, 25, 3)
"""Uzunovic 2013, section 3.2: 25 tansig neurons."""


@pytest.mark.parametrize(
    ("sizes", "activation"),
    [(ZHAO_SIZES, "sigmoid"), (UZUNOVIC_SIZES, "tanh"), ((3, 3), "tanh")],
)
def test_the_papers_networks_run_as_written(
    write: Callable[..., NetworkFile],
    make_network: Callable[..., Any],
    in_float64: Callable[[bytes, Any], Any],
    sizes: tuple[int, ...],
    activation: str,
) -> None:
    network = make_network(sizes, activation, seed=5)
    runner = InverseNetwork(write(network))
    position_m = np.random.default_rng(6).uniform(-0.5, 0.5, (200, 3))
    answers = runner.raw_rad_many(position_m)
    np.testing.assert_allclose(answers, network.values(position_m), atol=1e-5, rtol=0.0)
    # The same numbers again, from the weights as they stand in the file.
    reread = in_float64(runner.file.content, position_m)
    np.testing.assert_allclose(answers, reread, atol=5e-6, rtol=0.0)
    assert np.ptp(answers, axis=0).min() > 1e-3, "a constant network would pass as well"


def test_multiply_and_reshape_run_as_written() -> None:
    graph = Graph()
    source = graph.input("position_m", (1, 3))
    weights = np.arange(18, dtype=np.float64).reshape(6, 3)
    first = graph.fully_connected(source, weights, np.ones(6))
    second = graph.fully_connected(source, -weights, np.zeros(6))
    product = graph.reshape(graph.multiply(first, second), (2, 3))
    result = graph.fully_connected(product, [[1.0, 10.0, 100.0]], [0.5])
    interpreter = open_interpreter(graph.to_bytes(source, result, "", b"{}"))
    interpreter.set_tensor(source, np.array([[0.5, -1.0, 2.0]], dtype=np.float32))
    interpreter.invoke()
    once = weights @ [0.5, -1.0, 2.0]
    wanted = (-(once + 1.0) * once).reshape(2, 3) @ [1.0, 10.0, 100.0] + 0.5
    details = interpreter.get_output_details()[0]
    np.testing.assert_allclose(interpreter.get_tensor(details["index"])[:, 0], wanted, rtol=1e-6)


def test_both_scalings_fold_into_the_outer_layers(make_network: Callable[..., Any]) -> None:
    rng = np.random.default_rng(8)
    network = make_network((3, 5, 4, 2))
    into = Scaling(rng.normal(size=3), rng.uniform(0.1, 3.0, 3))
    out = Scaling(rng.normal(size=2), rng.uniform(0.1, 3.0, 2))
    raw = rng.normal(size=(50, 3))
    wanted = network.values(into.apply(raw)) * out.deviation + out.mean
    folded = fold(network.perceptron.layers(network.parameters), into, out)
    flat = np.concatenate([part.ravel() for layer in folded for part in layer])
    np.testing.assert_allclose(network.perceptron.values(flat, raw), wanted, rtol=1e-12)


def test_a_constant_column_cannot_be_scaled() -> None:
    with pytest.raises(ValueError, match="column 1 is constant"):
        Scaling.of(np.array([[0.0, 2.0], [1.0, 2.0]]))


def test_shapes_that_do_not_fit_are_refused_while_building() -> None:
    graph = Graph()
    source = graph.input("position_m", (1, 3))
    wide = graph.fully_connected(source, np.zeros((6, 3)), np.zeros(6))
    with pytest.raises(ValueError, match="do not fit"):
        graph.fully_connected(source, np.zeros((6, 2)), np.zeros(6))
    with pytest.raises(ValueError, match="multiply"):
        graph.multiply(source, wide)
    with pytest.raises(ValueError, match="reshape"):
        graph.reshape(wide, (2, 2))
