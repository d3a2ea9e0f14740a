"""Trains a policy of the same cart by Stable-Baselines3: `pip install stable-baselines3`, then `python3 ppo.py`."""

from learn import reach
from stable_baselines3 import PPO

STEPS, EPISODES = 20_000, 20


def is_reached(env, policy, seed):
    """Drive an episode, and return whether it reached the middle."""
    observation, _ = env.reset(seed=seed)
    terminated, truncated = False, False
    while not (terminated or truncated):
        action, _ = policy.predict(observation, deterministic=True)
        observation, _, terminated, truncated, _ = env.step(action)
    return terminated


if __name__ == "__main__":
    env = reach()
    policy = PPO("MlpPolicy", env, seed=1, device="cpu").learn(STEPS)
    reached = sum(is_reached(env, policy, seed=1000 + number) for number in range(EPISODES))
    print(f"the middle was reached in {reached} of {EPISODES} new episodes")
    policy.save("reach-ppo")
