"""Trains the policy of apps/policy.toml, which then drives: `jde run ../../apps/policy.toml --view`.

The policy imitates the planner of that application: the planner drives, and now and then random commands lead it astray for
less than a second, so that it shows the way back. In further rounds the policy so far does that instead of the random
commands (as HG-DAgger: Kelly et al., 2019). Five networks of other samples are the ensemble whose spread is the doubt.
What they see and command is stated by apps/policy/local.toml alone.

    pip install numpy gymnasium onnx
    python3 examples/python/local.py                 # half a minute of one core
"""

import argparse
import re
import time
from pathlib import Path

import jde.gym
import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

ROOT = Path(__file__).resolve().parents[2]
APPLICATION, NETWORK = ROOT / "apps/policy.toml", ROOT / "apps/policy/local.onnx"
#: Worlds of the BARN data set, from which those for training are drawn, and the experiment whose worlds are left out.
WORLDS = [number for number in range(300) if number % 6]
EXPERIMENT = ROOT / "experiments/policy.toml"
MEMBERS, HIDDEN, EPOCHS = 5, 64, 40
#: Steps of 0.1 s for which the planner drives, and the policy at most; and the longest drive.
PLANNER, POLICY, LONGEST = 12, 8, 300
#: The numbers of an observation by the file: rays, three points, speed and turn rate.
RAYS, LEFT = 36, [37, 39, 41, 43]


class Ensemble:
    """Networks of three layers that are trained at once."""

    def __init__(self, inputs, outputs, random):
        """Draw the weights."""
        sizes = [inputs, HIDDEN, HIDDEN, outputs]
        self.layers = [
            [random.normal(size=(MEMBERS, width, height)) / np.sqrt(width), np.zeros((MEMBERS, 1, height))]
            for width, height in zip(sizes, sizes[1:])
        ]
        self.random = random

    def forward(self, observations):
        """Return what each layer gives, of each member: members, samples, numbers."""
        values = [np.broadcast_to(observations, (MEMBERS, *observations.shape[-2:]))]
        for weights, bias in self.layers:
            values.append(np.tanh(values[-1] @ weights + bias))
        return values

    def act(self, observation):
        """Return the mean of the members."""
        return self.forward(observation[None, :])[-1].mean(axis=0)[0].astype(np.float32)

    def fit(self, observations, actions, epochs, batch=256, rate=2e-3):
        """Train each member by its own four fifths of the samples (Adam: Kingma and Ba, 2015)."""
        count = len(observations)
        own = [self.random.permutation(count)[: count * 4 // 5] for _ in range(MEMBERS)]
        moments = [[[np.zeros_like(part), np.zeros_like(part)] for part in layer] for layer in self.layers]
        steps = 0
        for epoch in range(epochs):
            orders = np.stack([self.random.permutation(part) for part in own])
            slow = rate * 0.5 * (1 + np.cos(np.pi * epoch / epochs))
            loss = []
            for start in range(0, orders.shape[1] - batch + 1, batch):
                chosen = orders[:, start : start + batch]
                values = self.forward(observations[chosen])
                error = values[-1] - actions[chosen]
                loss.append(np.mean(error**2))
                slope, steps = error / batch, steps + 1
                for index in reversed(range(len(self.layers))):
                    slope = slope * (1 - values[index + 1] ** 2)
                    slopes = [values[index].transpose(0, 2, 1) @ slope, slope.sum(axis=1, keepdims=True)]
                    slope = slope @ self.layers[index][0].transpose(0, 2, 1)
                    for part, (number, own_slope) in enumerate(zip(self.layers[index], slopes)):
                        first, second = moments[index][part]
                        first += 0.1 * (own_slope - first)
                        second += 0.001 * (own_slope**2 - second)
                        scale = np.sqrt(second / (1 - 0.999**steps)) + 1e-8
                        number -= slow * first / (1 - 0.9**steps) / scale
        return float(np.mean(loss))

    def save(self, path):
        """Write the ensemble, its members and their mean."""
        weights, nodes, last = {}, [], "obs"
        for index, (matrix, bias) in enumerate(self.layers):
            weights |= {f"w{index}": matrix.astype(np.float32), f"b{index}": bias.astype(np.float32)}
            out = "members" if index == len(self.layers) - 1 else f"z{index}"
            nodes += [
                helper.make_node("MatMul", [last, f"w{index}"], [f"x{index}"]),
                helper.make_node("Add", [f"x{index}", f"b{index}"], [f"y{index}"]),
                helper.make_node("Tanh", [f"y{index}"], [out]),
            ]
            last = out
        nodes.append(helper.make_node("ReduceMean", ["members"], ["action"], axes=[0], keepdims=0))
        width, height = self.layers[0][0].shape[1], self.layers[-1][0].shape[2]
        floats = TensorProto.FLOAT
        graph = helper.make_graph(
            nodes,
            "local",
            [helper.make_tensor_value_info("obs", floats, [1, width])],
            [
                helper.make_tensor_value_info("action", floats, [1, height]),
                helper.make_tensor_value_info("members", floats, [MEMBERS, 1, height]),
            ],
            [numpy_helper.from_array(value, name) for name, value in weights.items()],
        )
        model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
        onnx.checker.check_model(model)
        onnx.save(model, path)


def mirrored(observations, actions):
    """Return the samples and the same with left and right exchanged."""
    others, turns = observations.copy(), actions.copy()
    others[:, :RAYS] = observations[:, RAYS - 1 :: -1]
    others[:, LEFT] *= -1
    turns[:, 1] *= -1
    return np.concatenate([observations, others]), np.concatenate([actions, turns])


def drive(world, seed, ensemble, random):
    """Let the planner and the policy drive by turns, and return what the planner did where: observations and actions."""
    env = jde.gym.make(
        APPLICATION,
        policy="policy",
        reward=lambda env: 0.0,
        limit=LONGEST * 0.1,
        set={"robot.world": str(ROOT / f"worlds/barn/{world:03}.toml"), "map.period": 0.2, "plan.period": 0.4},
    )
    observation, info = env.reset(seed=seed)
    observations, actions = [], []
    is_planner, left, noise = True, PLANNER, np.zeros(2)
    env.run.force("planner")
    ended = False
    while not ended:
        before, was_lacking = observation, "lacks" in info
        action = noise if ensemble is None else ensemble.act(observation) + noise
        action = np.clip(action, env.action_space.low, env.action_space.high).astype(np.float32)
        observation, _, terminated, truncated, info = env.step(action)
        twist = env.run["robot.velocity"]
        drives = env.run.winner("drive/all") == "planner" and env.run.winner("navigate/base") == "drive"
        if is_planner and drives and twist is not None and not was_lacking:
            observations.append(before)
            actions.append(env.action_of(twist))
        left -= 1
        if left == 0:
            is_planner = not is_planner
            left = PLANNER if is_planner else int(random.integers(3, POLICY + 1))
            noise = random.normal(scale=[0.3, 0.5] if ensemble is None else [0.1, 0.15])
            if is_planner:
                env.run.force("planner")
            else:
                env.run.release("planner")
        ended = terminated or truncated
    env.close()
    return observations, actions


def main():
    """Collect, train, collect with what was trained, and so on."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=1, help="how often is collected and trained")
    parser.add_argument("--worlds", type=int, default=12, help="worlds in a round")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=NETWORK)
    options = parser.parse_args()
    random = np.random.default_rng(options.seed)
    judged = {int(number) for number in re.findall(r"barn/(\d+)\.toml", EXPERIMENT.read_text())}
    worlds = [world for world in random.permutation(WORLDS).tolist() if world not in judged]
    observations, actions, ensemble, begin = [], [], None, time.process_time()
    for number in range(options.rounds):
        for world in worlds[number * options.worlds :][: options.worlds]:
            seen, done = drive(world, int(random.integers(2**31)), ensemble, random)
            observations += seen
            actions += done
        ensemble = Ensemble(len(observations[0]), len(actions[0]), random)
        loss = ensemble.fit(*mirrored(np.array(observations, float), np.array(actions, float)), EPOCHS)
        ensemble.save(options.out)
        print(
            f"round {number + 1}: {len(observations)} samples, loss {loss:.4f}, {time.process_time() - begin:.0f} s",
            flush=True,
        )


if __name__ == "__main__":
    main()
