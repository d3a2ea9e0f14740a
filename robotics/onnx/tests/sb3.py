"""Writes networks of Stable-Baselines3 as its page "Exporting models" does, with small layers, and the numbers of onnxruntime.

pip install torch stable-baselines3 sb3-contrib onnx onnxruntime, then run this. Its networks are kept, because no test installs
torch; another version writes other weights.
"""

from pathlib import Path

import gymnasium
import numpy as np
import onnxruntime
import torch
from sb3_contrib import RecurrentPPO
from stable_baselines3 import DQN, PPO, SAC

DATA = Path(__file__).with_name("data")


class OnnxablePolicy(torch.nn.Module):
    """The class of the page for PPO: action, value, and logarithm of the probability; of DQN the action."""

    def __init__(self, policy):
        """Keep the policy, or the actor of SAC."""
        super().__init__()
        self.policy = policy

    def forward(self, observation):
        """Return what the policy does without chance."""
        return self.policy(observation, deterministic=True)


class OnnxableRecurrent(torch.nn.Module):
    """The same with a memory, which the page does not have."""

    def __init__(self, policy):
        """Keep the policy."""
        super().__init__()
        self.policy = policy

    def forward(self, observation, h, c):
        """Return the action, and the memory of the next step."""
        distribution, (h, c) = self.policy.get_distribution(observation, (h, c), torch.zeros(1))
        return distribution.get_actions(deterministic=True), h, c


class Robot(gymnasium.Env):
    """Six numbers in, two speeds out."""

    observation_space = gymnasium.spaces.Box(-1, 1, (6,), np.float32)
    action_space = gymnasium.spaces.Box(-1, 1, (2,), np.float32)

    def reset(self, seed=None, options=None):
        """Begin anywhere."""
        super().reset(seed=seed)
        return self.observation_space.sample(), {}

    def step(self, action):
        """Reward small actions."""
        return self.observation_space.sample(), -float(np.abs(action).sum()), False, False, {}


class Chooser(Robot):
    """Six numbers in, one of four commands out."""

    action_space = gymnasium.spaces.Discrete(4)

    def step(self, action):
        """Reward what the first number asks for."""
        wanted = int((self.seen[0] + 1) * 2)
        self.seen = self.observation_space.sample()
        return self.seen, float(action == wanted), False, False, {}

    def reset(self, seed=None, options=None):
        """Begin anywhere."""
        self.seen, info = super().reset(seed=seed)
        return self.seen, info


def export(file, name, module, **inputs):
    """Keep a network, an input, and what onnxruntime gives."""
    path = DATA / f"{name}.onnx"
    names = list(inputs)
    # The other exporter of torch 2.15 fails at the distributions.
    options = {"opset_version": 17, "input_names": names, "dynamo": False}
    torch.onnx.export(module.eval(), tuple(inputs.values()), path, **options)
    session = onnxruntime.InferenceSession(path, providers=["CPUExecutionProvider"])
    given = session.run(None, {key: value.numpy() for key, value in inputs.items()})
    print("case", name, file=file)
    for key, value in inputs.items():
        print("input", key, *map(float, value.flatten()), file=file)
    for port, value in zip(session.get_outputs(), given):
        print("output", port.name, "x".join(map(str, value.shape)), *map(float, value.flatten()), file=file)


def main():
    """Train a little, and export."""
    torch.manual_seed(1)
    common = {"device": "cpu", "seed": 1}
    layers = [12, 12]
    ppo = PPO("MlpPolicy", Robot(), n_steps=64, policy_kwargs={"net_arch": layers}, **common).learn(128)
    sac = SAC("MlpPolicy", Robot(), learning_starts=50, policy_kwargs={"net_arch": layers}, **common).learn(120)
    memory = {"lstm_hidden_size": 8, "net_arch": layers}
    recurrent = RecurrentPPO("MlpLstmPolicy", Robot(), n_steps=64, policy_kwargs=memory, **common).learn(128)
    dqn = DQN("MlpPolicy", Chooser(), learning_starts=50, policy_kwargs={"net_arch": layers}, **common).learn(2000)
    discrete = PPO("MlpPolicy", Chooser(), n_steps=64, policy_kwargs={"net_arch": layers}, **common).learn(1000)
    seen = torch.randn(1, 6)
    with (DATA / "sb3.txt").open("w") as file:
        export(file, "sb3-ppo", OnnxablePolicy(ppo.policy), input=seen)
        export(file, "sb3-sac", OnnxablePolicy(sac.policy.actor), input=seen)
        export(file, "sb3-dqn", OnnxablePolicy(dqn.policy), input=seen)
        export(file, "sb3-dqn-scores", dqn.q_net, input=seen)
        export(file, "sb3-discrete", OnnxablePolicy(discrete.policy), input=seen)
        h, c = torch.randn(1, 1, 8), torch.randn(1, 1, 8)
        export(file, "sb3-recurrent", OnnxableRecurrent(recurrent.policy), input=seen, h=h, c=c)


if __name__ == "__main__":
    main()
