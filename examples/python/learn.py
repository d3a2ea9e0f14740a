"""Trains the policy of the cart of reach.toml, which then drives: `jde run reach.toml --view`.

The policy is a linear one, found by the cross-entropy method (Rubinstein, 1999): it draws policies from a normal
distribution, drives with each, and moves the distribution to the best ones. `reach` is an environment of Gymnasium,
so that any other method can take its place.
"""

import json
import math
from pathlib import Path

import gymnasium
import jde.gym
import numpy as np
from policy import BOUNDS, NEAR, WEIGHTS, decide, seen

GENERATIONS, POLICIES, BEST, EPISODES = 12, 24, 6, 4


def distance(env):
    """Return the distance of the cart to the middle, m."""
    return math.hypot(env.observation[0], env.observation[1])


def reward(env):
    """Return the way towards the middle in this step, m, less a cost of time."""
    before, env.distance = env.distance, distance(env)
    return before - env.distance - 0.01


def prepare(env):
    """Put the cart somewhere on the floor."""
    x, y = env.np_random.uniform(-3.0, 3.0, 2)
    heading = env.np_random.uniform(-180.0, 180.0)
    env.run.edit("robot", place={"x": x, "y": y, "heading_deg": heading})
    env.distance = math.hypot(x, y)


class Seen(gymnasium.ObservationWrapper):
    """The environment as the policy sees it."""

    observation_space = gymnasium.spaces.Box(-np.inf, np.inf, shape=(3,), dtype=np.float32)

    def observation(self, pose):
        """Return what is seen from a pose."""
        return np.array(seen(*pose), dtype=np.float32)


def reach():
    """Return the environment, whose observation is what the policy sees."""
    env = jde.gym.make(
        Path(__file__).with_name("reach.toml"),
        observe=["robot.truth.pose"],
        act=dict(zip(["policy.base.linear.x", "policy.base.angular.z"], BOUNDS)),
        reward=reward,
        terminated=lambda env: distance(env) < NEAR,
        prepare=prepare,
        limit=20.0,
    )
    return Seen(env)


def drive(env, weights, seed):
    """Drive an episode, and return its reward and whether it reached the middle."""
    observation, _ = env.reset(seed=seed)
    total, terminated, truncated = 0.0, False, False
    while not (terminated or truncated):
        action = np.array(decide(weights, observation.tolist()), dtype=np.float32)
        observation, gained, terminated, truncated, _ = env.step(action)
        total += gained
    return total, terminated


def train(env, seed):
    """Return the weights of the best policy: of the speed and the turn rate, each for three inputs and a constant."""
    random = np.random.default_rng(seed)
    mean, spread = np.zeros((2, 4)), np.ones((2, 4))
    for generation in range(GENERATIONS):
        policies = mean + spread * random.normal(size=(POLICIES, 2, 4))
        seeds = random.integers(2**31, size=EPISODES)
        gains = [np.mean([drive(env, policy.tolist(), int(seed))[0] for seed in seeds]) for policy in policies]
        best = policies[np.argsort(gains)[-BEST:]]
        mean, spread = best.mean(axis=0), best.std(axis=0) + 0.05
        print(f"generation {generation + 1:2}: mean reward {np.mean(gains):6.2f}, best {max(gains):6.2f}")
    return mean.tolist()


def main():
    """Train, count in how many new episodes the policy reaches the middle, and keep its weights."""
    env = reach()
    weights = train(env, seed=1)
    reached = sum(drive(env, weights, seed)[1] for seed in range(100, 120))
    print(f"the middle was reached in {reached} of 20 episodes")
    WEIGHTS.write_text(json.dumps(weights))
    env.close()


if __name__ == "__main__":
    main()
