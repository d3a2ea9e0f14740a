#!/usr/bin/env python3
"""Trains a policy that drives the cart of reach.toml to the middle of the floor, and shows what it does.

The policy is a linear one, found by the cross-entropy method (Rubinstein, 1999): it draws policies from a normal
distribution, drives with each, and moves the distribution to the best ones. `reach` is an environment of Gymnasium,
so that any other method can take its place; with Stable-Baselines3:

    model = stable_baselines3.PPO("MlpPolicy", reach()).learn(200_000)
"""

from pathlib import Path

import gymnasium
import jde.gym
import numpy as np

#: The reach of the goal, m.
NEAR = 0.2
GENERATIONS, POLICIES, BEST, EPISODES = 12, 24, 6, 4


def distance(env):
    """Return the distance of the cart to the middle, m."""
    return float(np.hypot(env.observation[0], env.observation[1]))


def reward(env):
    """Return the way towards the middle in this step, m, less a cost of time."""
    before, env.distance = env.distance, distance(env)
    return before - env.distance - 0.01


def prepare(env):
    """Put the cart somewhere on the floor."""
    x, y = env.np_random.uniform(-3.0, 3.0, 2)
    heading = env.np_random.uniform(-180.0, 180.0)
    env.run.edit("robot", place={"x": float(x), "y": float(y), "heading_deg": float(heading)})
    env.distance = float(np.hypot(x, y))


def seen_from_cart(observation):
    """Return the distance to the middle, m, and the cosine and sine of the angle to it."""
    x, y, heading = observation
    bearing = np.arctan2(-y, -x) - heading
    return np.array([np.hypot(x, y), np.cos(bearing), np.sin(bearing)], dtype=np.float32)


def reach():
    """Return the environment."""
    env = jde.gym.make(
        Path(__file__).with_name("reach.toml"),
        observe=["robot.truth.pose"],
        act={"policy.base.linear.x": (0.0, 0.5), "policy.base.angular.z": (-1.5, 1.5)},
        reward=reward,
        terminated=lambda env: distance(env) < NEAR,
        prepare=prepare,
        limit=20.0,
    )
    space = gymnasium.spaces.Box(-np.inf, np.inf, shape=(3,), dtype=np.float32)
    return gymnasium.wrappers.TransformObservation(env, seen_from_cart, space)


def drive(env, weights, seed):
    """Drive an episode, and return its reward and whether it reached the middle."""
    observation, _ = env.reset(seed=seed)
    total, terminated, truncated = 0.0, False, False
    while not (terminated or truncated):
        action = weights.reshape(2, 4) @ np.append(observation, 1.0)
        action = np.clip(action, env.action_space.low, env.action_space.high)
        observation, gained, terminated, truncated, _ = env.step(action)
        total += gained
    return total, terminated


def train(env, seed):
    """Return the weights of the best policy: of the speed and the turn, each for three inputs and a constant."""
    random = np.random.default_rng(seed)
    mean, spread = np.zeros(8), np.ones(8)
    for generation in range(GENERATIONS):
        policies = mean + spread * random.normal(size=(POLICIES, 8))
        seeds = random.integers(2**31, size=EPISODES)
        gains = [np.mean([drive(env, policy, int(seed))[0] for seed in seeds]) for policy in policies]
        best = policies[np.argsort(gains)[-BEST:]]
        mean, spread = best.mean(axis=0), best.std(axis=0) + 0.05
        print(f"generation {generation + 1:2}: mean reward {np.mean(gains):6.2f}, best {max(gains):6.2f}")
    return mean


def main():
    """Train, and count in how many new episodes the policy reaches the middle."""
    env = reach()
    weights = train(env, seed=1)
    reached = sum(drive(env, weights, seed)[1] for seed in range(100, 120))
    print(f"the middle was reached in {reached} of 20 episodes")
    env.close()


if __name__ == "__main__":
    main()
