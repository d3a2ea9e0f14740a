"""Environments of Gymnasium: an application in which a policy takes the place of a schema.

Needs the packages gymnasium and numpy.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import gymnasium
import numpy as np

from jde import _jde
from jde.runs import Application, Run

Array = np.ndarray[Any, np.dtype[np.float32]]
Bounds = tuple[float, float]

#: The longest time until all observed variables have a value, s.
PATIENCE = 10.0
#: A step ends an instant before the next one begins, s.
BEFORE = 1e-9


class Env(gymnasium.Env[Array, Any]):
    """An application as an environment; `make` explains the arguments. `run` is the run of the present episode."""

    def __init__(
        self,
        application: str | os.PathLike[str],
        *,
        observe: Sequence[str] | Mapping[str, Bounds] = (),
        act: Mapping[str, Bounds] | None = None,
        policy: str | None = None,
        reward: Callable[[Env], float],
        terminated: Callable[[Env], bool] | None = None,
        prepare: Callable[[Env], None] | None = None,
        step: float | None = None,
        limit: float = 60.0,
        set: Mapping[str, Any] | None = None,
        records: bool = False,
        authority: bool = False,
    ) -> None:
        """Load the application, and run it until the size of an observation is known."""
        act = act or {}
        if policy is not None and (observe or act):
            raise ValueError("the file of a policy states what it observes and commands; leave out `observe` and `act`")
        mocks = [policy] if policy is not None else list(dict.fromkeys(name.split(".")[0] for name in act))
        if not mocks:
            raise ValueError("`act` names no number; give {'policy.base.linear.x': (0.0, 0.5)}, for example")
        self._application = Application(application, set=set, mocks=mocks)
        self._observed, self._acted, self._schema = list(observe), list(act), policy
        self._says_authority_of = mocks[0] if authority else None
        self._reward, self._terminated, self._prepare = reward, terminated, prepare
        self._limit, self._records = limit, records
        self.run: Run
        self.observation: Array
        self.action: Any
        self.action_space: gymnasium.spaces.Space[Any]
        self._start(0)
        self._step = float(self.run[f"{mocks[0]}.period"]) if step is None else step
        #: Steps since the start of the application, and those at which the episode is over.
        self._steps = self._last = 0
        self._bounds: tuple[Array, Array] | None = None
        if isinstance(self._policy, _jde.PolicyFile):
            self._check_step(policy)
            low, high = np.array(self._policy.observation_bounds(), dtype=np.float32).T
            choices = self._policy.choices
            if choices is None:
                least, most = np.array(self._policy.action_bounds(), dtype=np.float32).T
                self.action_space = gymnasium.spaces.Box(least, most, dtype=np.float32)
            else:
                self.action_space = gymnasium.spaces.Discrete(choices)
            self.observation_space = gymnasium.spaces.Box(low, high, dtype=np.float32)
            return
        least, most = np.array(list(act.values()), dtype=np.float32).T
        self.action_space = gymnasium.spaces.Box(least, most, dtype=np.float32)
        bounds = list(observe.values()) if isinstance(observe, Mapping) else [(-np.inf, np.inf)] * len(observe)
        low, high = np.repeat(np.array(bounds, dtype=np.float32), self._policy.counts(), axis=0).T
        self.observation_space = gymnasium.spaces.Box(low, high, dtype=np.float32)
        if isinstance(observe, Mapping):
            self._bounds = (low, high)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """Start the application again, with a seed that follows from that of the environment."""
        super().reset(seed=seed, options=options)
        self._start(int(self.np_random.integers(2**31)))
        self.action = np.zeros(self.action_space.shape or (), dtype=self.action_space.dtype)
        if self._prepare is not None:
            self._prepare(self)
        # The schema iterates at the beginning of each step.
        self._steps = math.floor(self.run.time / self._step + 1)
        self._last = self._steps + round(self._limit / self._step)
        self.run.until(self._end_of_step())
        if isinstance(self._policy, _jde.PolicyFile):
            self._policy.reset()
        self.observation = self._read()
        return self.observation, self._info()

    def step(self, action: Any) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Command the action for the time of a step."""
        # Numbers beyond those that are commanded would have no effect, and missing ones no value.
        if np.shape(action) != self.action_space.shape:
            names = ", ".join(self._acted) or f"the outputs of the file of `{self._schema}`"
            raise ValueError(
                f"the shape of an action is {self.action_space.shape}, for {names}; this one has {np.shape(action)}"
            )
        space = self.action_space
        if isinstance(space, gymnasium.spaces.Discrete) and not space.contains(np.asarray(action)[()]):
            raise ValueError(
                f"`{self._schema}` chooses one of {space.n} commands, 0 to {space.n - 1}, and not {action}"
            )
        self.action = action
        self._steps += 1
        goes_on = self._policy.act(np.ravel(action).tolist(), self._end_of_step())
        self.observation = self._read()
        terminated = not goes_on or (self._terminated is not None and bool(self._terminated(self)))
        truncated = self._steps >= self._last
        info = self._info() if goes_on else {"outcome": self.run.outcome}
        return self.observation, float(self._reward(self)), terminated, truncated, info

    def close(self) -> None:
        """Bring the application to rest."""
        self.run.close()

    def _start(self, seed: int) -> None:
        if hasattr(self, "run"):
            self.run.close()
        self.run = self._application.run(seed=seed, records=self._records)
        self._policy: _jde.Policy | _jde.PolicyFile
        if self._schema is not None:
            self._policy = self._of_file(self._schema)
            return
        self._policy = _jde.Policy(self.run._native, self._observed, self._acted)
        while self._policy.observe() is None:
            if self.run.time > PATIENCE or not self.run.step():
                missing = ", ".join(self._policy.missing())
                raise _jde.Error(f"no value of {missing} within {PATIENCE} s; is its schema awake?")

    def _of_file(self, schema: str) -> _jde.PolicyFile:
        """Return the policy of the file that a schema names, as soon as it sees all."""
        policy = _jde.PolicyFile(self.run._native, schema)
        while True:
            policy.observe()
            if policy.lacks is None:
                return policy
            if self.run.time > PATIENCE or not self.run.step():
                raise _jde.Error(f"within {PATIENCE} s the policy sees not all: {policy.lacks}")

    def _check_step(self, schema: str | None) -> None:
        """Refuse a step that is not that of the policy's file."""
        assert isinstance(self._policy, _jde.PolicyFile)
        if abs(self._step - self._policy.period) > BEFORE:
            raise ValueError(
                f"a step is {self._step} s, and the policy's file states {self._policy.period} s; "
                f"state the same `period` of schema `{schema}`"
            )

    def action_of(self, twist: Any) -> Any:
        """Return the action of the policy of a file that would have commanded a velocity, to imitate who drove.

        Of a policy that chooses it is the number of the command that is nearest to the velocity.
        """
        if not isinstance(self._policy, _jde.PolicyFile):
            raise TypeError("only the policy of a file knows the action of a velocity")
        command = (twist.linear.x, twist.linear.y, twist.angular.z)
        numbers = np.array(self._policy.action_of(command), dtype=self.action_space.dtype)
        return numbers.reshape(self.action_space.shape or ())[()]

    def _info(self) -> dict[str, Any]:
        lacks = self._policy.lacks if isinstance(self._policy, _jde.PolicyFile) else None
        info: dict[str, Any] = {} if lacks is None else {"lacks": lacks}
        if self._says_authority_of is not None:
            info["authority"] = self.run.has_authority(self._says_authority_of)
        return info

    def _end_of_step(self) -> float:
        return self._steps * self._step - BEFORE

    def _read(self) -> Array:
        numbers = self._policy.observe()
        observation: Array = np.frombuffer(numbers, dtype=np.float32)  # type: ignore[arg-type]
        if self._bounds is None:
            return observation
        return np.clip(observation, *self._bounds, out=observation)


def make(application: str | os.PathLike[str], **arguments: Any) -> Env:
    """Return an application as an environment.

    `act` names the numbers that a policy commands, with their bounds: `{"policy.base.linear.x": (0.0, 0.5)}`. The
    policy takes the place of the schema before the first dot, which is always ready; all others run as ever.
    Or `policy` names a schema of type `policy/onnx`: its text file states what it observes and commands, so that what
    is trained here drives there. An observation is what goes into the network, and an action what comes out: numbers, or
    the number of a command if the file lists `[choices]`, which is a space `Discrete`. A step that
    lacks a value commands nothing, and `info["lacks"]` says what is missing.

    `observe` names variables or parts of them, such as `"robot.scan.ranges"`, or states bounds for each, to which
    its numbers are limited. A sequence has as many numbers as at first; NaN is observed as 0.

    `reward` and `terminated` are functions of the environment: of `env.run`, `env.observation` and `env.action`.
    `prepare` is called in each reset before the first step, to place a robot, for example. A step lasts `step`
    seconds, by default the period of the schema, and an episode `limit` seconds. `set` is that of `jde.run`. With
    `records`, `env.run` keeps records and traces.

    With `authority`, `info["authority"]` is whether the schema has it: while another one has won, its actions have no
    effect (R7). That costs half of a step of a small application.

    An action is in force from the next iteration of the schema on. An observation is what variables were just
    before that iteration.
    """
    return Env(application, **arguments)
