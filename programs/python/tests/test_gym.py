"""Environments of Gymnasium."""

import importlib
import json
import math
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("gymnasium")

import gymnasium
from gymnasium.utils.env_checker import check_env

import jde.gym
from conftest import Robot

ACT = {"policy.base.linear.x": (0.0, 0.5), "policy.base.angular.z": (-1.0, 1.0)}
POSE = ["robot.truth.pose"]


def make(reach: Path, **arguments: Any) -> jde.gym.Env:
    """Return an environment whose reward is the way to the right."""
    arguments = {"observe": POSE, "act": ACT, "reward": lambda env: env.observation[0], "limit": 5.0, **arguments}
    return jde.gym.make(reach, **arguments)


@pytest.mark.filterwarnings("ignore:.*Box observation space (m|max)[a-z]* value is -?infinity.*")
def test_the_checker_of_gymnasium_accepts_an_environment(reach: Path) -> None:
    check_env(make(reach), skip_render_check=True)


def test_an_episode_is_that_of_its_seed(reach: Path) -> None:
    def episode(seed: int) -> list[Any]:
        env = make(reach, observe=["robot.odometry.pose.pose.position"])
        env.reset(seed=seed)
        return [env.step(np.array([0.5, 0.2], dtype=np.float32))[0].tolist() for _ in range(30)]

    assert episode(1) == episode(1)
    assert episode(1) != episode(2), "wheels of another error"


def test_an_action_is_in_force_for_a_step(reach: Path) -> None:
    env = make(reach, step=0.2)
    env.reset(seed=1)
    begin = env.run.time
    env.step(np.array([0.3, 0.1], dtype=np.float32))
    command = env.run["robot.velocity"]
    assert (command.linear.x, command.angular.z) == (pytest.approx(0.3), pytest.approx(0.1))
    assert env.run.time - begin == pytest.approx(0.2)


def test_an_episode_ends_by_its_limit_or_by_its_condition(reach: Path) -> None:
    forward = np.array([0.5, 0.0], dtype=np.float32)
    env = make(reach, limit=1.0)
    env.reset(seed=1)
    ends = [env.step(forward)[2:4] for _ in range(10)]
    assert ends == [(False, False)] * 9 + [(False, True)]
    env = make(reach, terminated=lambda env: env.observation[0] > 1.5)
    env.reset(seed=1)
    steps = 0
    while not env.step(forward)[2]:
        steps += 1
    assert env.run["robot.truth.pose.x"] > 1.5
    assert steps == pytest.approx(15, abs=4)


def test_a_reset_prepares_the_episode(reach: Path) -> None:
    def prepare(env: jde.gym.Env) -> None:
        x = float(env.np_random.uniform(-3.0, -2.0))
        env.run.edit("robot", place={"x": x, "y": 0.0, "heading_deg": 0.0})

    env = make(reach, prepare=prepare)
    starts = [env.reset(seed=seed)[0][0] for seed in (1, 2, 1)]
    assert starts[0] == starts[2] != starts[1]
    assert all(-3.0 <= start <= -2.0 for start in starts)


def test_observations_are_limited_to_their_bounds(navigation: Path) -> None:
    env = jde.gym.make(
        navigation,
        observe={"pioneer.laser.ranges": (0.0, 2.0), "pioneer.truth.pose.x": (-100.0, 100.0)},
        act={"goon.base.linear.x": (0.0, 0.3)},
        reward=lambda env: 0.0,
    )
    observation, _ = env.reset(seed=3)
    assert observation.shape == (181,)
    ranges = env.run["pioneer.laser"].ranges
    assert (observation[:180] == np.clip(ranges, 0.0, 2.0)).all()
    assert observation.max() > 2.0 >= observation[:180].max()
    assert env.observation_space.contains(observation)


def test_an_action_of_another_shape_is_refused(reach: Path) -> None:
    env = make(reach)
    env.reset(seed=1)
    least = np.array([0.0, -1.0], dtype=np.float32)
    others: list[Any] = [np.append(least, 0.0), least[:-1], np.array([least]), np.float32(0.0)]
    for action in others:
        with pytest.raises(ValueError, match="the shape of an action is"):
            env.step(action)
    env.step(least)


def test_a_wrong_name_is_refused_in_words(reach: Path) -> None:
    cases: list[tuple[dict[str, Any], str]] = [
        ({"observe": ["robot.truth.pse"]}, "has no field `pse`"),
        ({"observe": ["robot.odometry"]}, "`frame_id` is a text"),
        ({"act": {"policy.base.linear": (0.0, 1.0)}}, "it is not one number"),
        ({"act": {"policy.bse.linear.x": (0.0, 1.0)}}, "mocks write policy.base"),
        ({"act": {}}, "names no number"),
        ({"observe": ["robot.imu.angular_velocity"]}, "no value of robot.imu.angular_velocity within"),
    ]
    for arguments, words in cases:
        with pytest.raises((jde.Error, KeyError, ValueError), match=words):
            make(reach, **arguments)


def test_the_policy_of_the_example_is_trained_and_then_drives(
    reach: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(reach.parent, tmp_path, dirs_exist_ok=True)
    before = Robot(tmp_path).jde("run", "reach.toml", "--lockstep", "--for", "1s")
    assert before.status == 2 and "weights.json does not exist: learn.py in its folder writes it" in before.text
    monkeypatch.syspath_prepend(str(tmp_path))
    learn = importlib.import_module("learn")
    env = learn.reach()
    turning = [[0.0, 0.5, 0.0, 0.0], [0.0, 0.0, 1.5, 0.0]]
    gain, reached = learn.drive(env, turning, seed=5)
    assert reached
    assert gain > 0.0
    gain, reached = learn.drive(env, np.zeros((2, 4)).tolist(), seed=5)
    assert not reached
    assert gain == pytest.approx(-2.0), "200 steps at 0.01"
    vars(learn).update(GENERATIONS=1, POLICIES=8, EPISODES=1)
    assert np.shape(learn.train(env, seed=1)) == (2, 4)
    (tmp_path / "weights.json").write_text(json.dumps(turning))
    with jde.run(tmp_path / "reach.toml") as run:
        assert run.until(lambda run: math.hypot(run["robot.truth.pose.x"], run["robot.truth.pose.y"]) < 0.2, within=20)
        assert run.winner("roots") == "policy"


POLICY = """
network = "absent.onnx"
period  = 0.1

[[input]]
field = "truth.pose"
count = 3
range = [-5, 5]
stack = 2

[[input]]
command = "angular.z"

[[output]]
command = "linear.x"
bounds  = [0.0, 0.4]
scale   = "bounds"

[[output]]
command = "angular.z"
bounds  = [-1.0, 1.0]
scale   = "none"
"""


@pytest.fixture
def described(reach: Path, tmp_path: Path) -> Path:
    """Return an application whose policy is described by a file; a network is not there yet."""
    (tmp_path / "policy.toml").write_text(POLICY)
    for name in ["cart.toml", "empty.toml"]:
        shutil.copy(reach.with_name(name), tmp_path)
    text = reach.read_text()
    start = text.index("[schemas.policy]")
    schema = (
        '[schemas.policy]\ntype = "policy/onnx"\nfile = "policy.toml"\n'
        'inputs = { truth = "robot.truth" }\nactuators = { base = "robot.velocity" }\n'
    )
    application = tmp_path / "described.toml"
    application.write_text(text[:start] + schema)
    return application


def of_file(application: Path, **arguments: Any) -> jde.gym.Env:
    """Return the environment of a policy that a file describes."""
    return jde.gym.make(application, policy="policy", reward=lambda env: 0.0, limit=5.0, **arguments)


def test_the_file_of_a_policy_states_what_is_observed_and_commanded(described: Path) -> None:
    env = of_file(described)
    assert env.observation_space.shape == (7,)
    assert env.action_space == gymnasium.spaces.Box(-1.0, 1.0, shape=(2,), dtype=np.float32)
    observation, info = env.reset(seed=1)
    assert info == {}
    pose = env.run["robot.truth.pose"]
    expected = [pose.x / 5, pose.y / 5, pose.theta / 5]
    assert observation.tolist() == pytest.approx([*expected, *expected, 0.0])
    observation, _, _, _, _ = env.step(np.array([0.5, 0.25], dtype=np.float32))
    command = env.run["robot.velocity"]
    assert (command.linear.x, command.angular.z) == (pytest.approx(0.3), pytest.approx(0.25))
    assert env.action_of(command).tolist() == pytest.approx([0.5, 0.25])
    assert observation[:3].tolist() == pytest.approx(expected), "the stack has the value before"
    assert observation[6] == pytest.approx(0.25), "and the last command is observed"


def test_the_file_of_a_policy_that_chooses_has_a_discrete_space(described: Path) -> None:
    file = described.with_name("policy.toml")
    inputs = file.read_text().split("[[output]]")[0]
    commands = "{}, { linear.x = 0.4 }, { linear.x = 0.2, angular.z = -0.5 }"
    file.write_text(f"{inputs}[choices]\ncommands = [{commands}]\n")
    env = of_file(described)
    assert env.action_space == gymnasium.spaces.Discrete(3)
    env.reset(seed=1)
    observation, _, _, _, _ = env.step(np.int64(2))
    command = env.run["robot.velocity"]
    assert (command.linear.x, command.angular.z) == (pytest.approx(0.2), pytest.approx(-0.5))
    assert observation[6] == pytest.approx(-0.5), "the last command is observed, not its number"
    assert env.action_of(command) == 2
    env.step(1)
    assert env.action_of(env.run["robot.velocity"]) == 1
    with pytest.raises(ValueError, match="`policy` chooses one of 3 commands, 0 to 2, and not 3"):
        env.step(3)
    with pytest.raises(ValueError, match="the shape of an action is"):
        env.step(np.array([1]))


@pytest.mark.filterwarnings("ignore:.*Box observation space (m|max)[a-z]* value is -?infinity.*")
def test_the_checker_of_gymnasium_accepts_a_policy_that_chooses(described: Path) -> None:
    file = described.with_name("policy.toml")
    inputs = file.read_text().split("[[output]]")[0]
    file.write_text(inputs + "[choices]\ncommands = [{}, { linear.x = 0.4 }]\n")
    check_env(of_file(described), skip_render_check=True)


def test_the_information_says_whether_an_action_has_authority(described: Path) -> None:
    env = of_file(described, authority=True)
    assert env.reset(seed=1)[1] == {"authority": True}
    env.run.stop("policy")
    action = np.array([0.5, 0.25], dtype=np.float32)
    assert env.step(action)[4]["authority"] is False


def test_a_step_must_be_that_of_the_file(described: Path) -> None:
    with pytest.raises(ValueError, match=r"a step is 0.2 s, and the policy's file states 0.1 s"):
        of_file(described, step=0.2)
    with pytest.raises(ValueError, match="leave out `observe` and `act`"):
        of_file(described, observe=POSE)


def test_a_role_that_the_application_does_not_bind_is_named(described: Path) -> None:
    described.write_text(described.read_text().replace("truth =", "truths ="))
    with pytest.raises(jde.Error, match="binds no variable of this application to `truth`"):
        of_file(described)
