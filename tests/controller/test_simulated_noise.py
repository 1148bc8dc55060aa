"""Noise of simulated sensors: a robot repeats its own, and no two robots have the same."""

from __future__ import annotations

from deltactl.firmware_py.named_files import CONFIG_FOLDER
from deltactl.firmware_py.robot_file import AsBuilt, RobotFile, SensorNoise, load_robot
from deltactl.firmware_py.simulation.sensors import range_noise, with_seed

ZHAO = load_robot(CONFIG_FOLDER / "zhao-2023.yaml")


def errors_m(robot: RobotFile) -> list[float]:
    source = range_noise(robot).source()
    return [source.next_m() for _ in range(50)]


def named(name: str, noise: SensorNoise) -> RobotFile:
    return ZHAO.model_copy(update={"name": name, "as_built": AsBuilt(noise=noise)})


def test_robots_of_other_names_scatter_otherwise_and_each_repeats_itself() -> None:
    drawn = SensorNoise()
    mine, yours = named("my-delta", drawn), named("your-delta", drawn)
    assert errors_m(mine) == errors_m(named("my-delta", drawn))
    assert errors_m(mine) != errors_m(yours)


def test_a_seed_that_is_given_holds_for_whatever_name() -> None:
    given = SensorNoise(seed=7)
    assert errors_m(named("my-delta", given)) == errors_m(named("your-delta", given))
    assert errors_m(named("my-delta", given)) != errors_m(named("my-delta", SensorNoise(seed=8)))


def test_a_run_may_have_a_seed_of_its_own() -> None:
    mine = named("my-delta", SensorNoise(sigma_m=0.002))
    assert errors_m(with_seed(mine, None)) == errors_m(mine)
    assert errors_m(with_seed(mine, 2)) != errors_m(mine)
    assert with_seed(mine, 2).as_built.noise == SensorNoise(sigma_m=0.002, seed=2)
