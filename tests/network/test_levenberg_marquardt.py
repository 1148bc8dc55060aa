"""The trainer against problems with known answers and against scipy."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import least_squares

from deltactl.models.training import levenberg_marquardt
from deltactl.models.training.graph import Activation
from deltactl.models.training.perceptron import Perceptron


def last(problem: Any, start: Any, at_most: int = 500) -> levenberg_marquardt.Step:
    """The step with which the search ends, or the one after `at_most`."""
    step = None
    for step in levenberg_marquardt.steps(lambda p: problem(p)[0], problem, np.array(start)):
        if step.iteration >= at_most:
            break
    assert step is not None
    return step


def rosenbrock(p: Any) -> tuple[Any, Any]:
    x, y = p
    return np.array([10.0 * (y - x * x), 1.0 - x]), np.array([[-20.0 * x, 10.0], [-1.0, 0.0]])


def test_the_banana_valley_is_followed_to_its_end() -> None:
    np.testing.assert_allclose(last(rosenbrock, [-1.2, 1.0]).parameters, [1.0, 1.0], atol=1e-9)


def test_a_linear_problem_ends_where_least_squares_ends() -> None:
    rng = np.random.default_rng(0)
    a, b = rng.normal(size=(40, 6)), rng.normal(size=40)
    found = last(lambda p: (a @ p - b, a), np.zeros(6))
    np.testing.assert_allclose(found.parameters, np.linalg.lstsq(a, b, rcond=None)[0], rtol=1e-6)


def test_every_step_helps_and_damping_falls_when_they_do() -> None:
    search = levenberg_marquardt.steps(
        lambda p: rosenbrock(p)[0], rosenbrock, np.array([-1.2, 1.0])
    )
    found = list(search)
    costs = [step.cost for step in found]
    assert all(later < earlier for earlier, later in pairwise(costs))
    assert found[-1].damping < 1e-2


def test_the_search_ends_by_itself_at_a_minimum() -> None:
    search = levenberg_marquardt.steps(
        lambda p: np.array([p[0] - 2.0, 1.0]),
        lambda p: (np.array([p[0] - 2.0, 1.0]), np.array([[1.0], [0.0]])),
        np.array([2.0]),
    )
    assert list(search) == []


@settings(max_examples=20, deadline=None)
@given(
    seed=st.integers(0, 10_000),
    hidden=st.lists(st.integers(1, 6), max_size=3),
    outputs=st.integers(1, 3),
    activation=st.sampled_from(["tanh", "sigmoid"]),
)
def test_derivatives_by_every_weight_agree_with_differences(
    seed: int, hidden: list[int], outputs: int, activation: Activation
) -> None:
    network, rng = Perceptron((3, *hidden, outputs), activation), np.random.default_rng(seed)
    parameters, inputs = network.start(rng), rng.normal(size=(4, 3))
    values, slope = network.jacobian(parameters, inputs)
    np.testing.assert_array_equal(values, network.values(parameters, inputs))
    assert slope.shape == (4, outputs, network.parameters)
    step = 1e-6
    for index in range(network.parameters):
        shift = np.zeros(network.parameters)
        shift[index] = step
        above, below = (network.values(parameters + s, inputs) for s in (shift, -shift))
        np.testing.assert_allclose(
            slope[:, :, index], (above - below) / (2.0 * step), atol=1e-7, rtol=1e-6
        )


@pytest.mark.study
def test_the_best_of_a_few_starts_is_as_good_as_that_of_scipy() -> None:
    network = Perceptron((3, 6, 1))
    ours, theirs = [], []
    for seed in range(8):
        rng = np.random.default_rng(seed)
        inputs, start = rng.uniform(-1.0, 1.0, (200, 3)), network.start(rng)
        wanted = np.sin(2.0 * inputs[:, 0]) * inputs[:, 1] + inputs[:, 2] ** 2

        def problem(parameters: Any, inputs: Any = inputs, wanted: Any = wanted) -> tuple[Any, Any]:
            values, slope = network.jacobian(parameters, inputs)
            return values[:, 0] - wanted, slope[:, 0]

        def errors(parameters: Any, problem: Any = problem) -> Any:
            return problem(parameters)[0]

        def slopes(parameters: Any, problem: Any = problem) -> Any:
            return problem(parameters)[1]

        ours.append(last(problem, start, at_most=200).cost)
        theirs.append(2.0 * least_squares(errors, start, slopes, method="lm", max_nfev=200).cost)
    # One start may end in a worse valley than the other's, in either direction.
    assert min(ours) < 1.5 * min(theirs)
    assert np.median(ours) < 3.0 * np.median(theirs)


@pytest.mark.parametrize(("sizes", "count"), [((3, 16, 16, 1), 353), ((3, 25, 3), 178)])
def test_parameters_are_counted_as_the_literature_counts(
    sizes: tuple[int, ...], count: int
) -> None:
    network = Perceptron(sizes)
    assert network.parameters == count == network.start(np.random.default_rng(0)).size
