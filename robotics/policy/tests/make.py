"""Writes the networks of the tests of policies: `pip install onnx`, then run this. Their text files are written by hand."""

from pathlib import Path

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

DATA = Path(__file__).with_name("data")
#: Networks of experiments/policy-hostile.toml.
HOSTILE = Path(__file__).parents[3] / "experiments/hostile"


def save(name, nodes, inputs, outputs, weights, folder=DATA):
    """Keep a network; inputs and outputs are shapes by name."""
    ports = [
        [helper.make_tensor_value_info(port, TensorProto.FLOAT, shape) for port, shape in ports.items()]
        for ports in (inputs, outputs)
    ]
    stored = [numpy_helper.from_array(np.asarray(value), key) for key, value in weights.items()]
    graph = helper.make_graph(nodes, name, *ports, stored)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=10)
    onnx.checker.check_model(model)
    onnx.save(model, folder / f"{name}.onnx")


def main():
    """Write all networks."""
    eye = np.eye(2, dtype=np.float32)
    obs, action = {"obs": ["batch", 2]}, {"action": ["batch", 2]}
    # Gives what it sees.
    save("same", [helper.make_node("MatMul", ["obs", "w"], ["action"])], obs, action, {"w": eye})
    # NaN where it sees less than 0.
    save("log", [helper.make_node("Log", ["obs"], ["action"])], obs, action, {})
    # Adds up what it saw.
    nodes = [helper.make_node("Add", ["obs", "sum"], ["action"]), helper.make_node("Identity", ["action"], ["next"])]
    save("sum", nodes, {**obs, "sum": [1, 2]}, {**action, "next": [1, 2]}, {})
    # Three members: they agree where the second number is 0.
    nodes = [
        helper.make_node("Mul", ["obs", "factors"], ["scaled"]),
        helper.make_node("Unsqueeze", ["scaled", "front"], ["members"]),
        helper.make_node("ReduceMean", ["members"], ["action"], axes=[1], keepdims=0),
        helper.make_node("ReduceMax", ["obs"], ["value"], axes=[1], keepdims=0),
    ]
    factors = np.array([[1, -1], [1, 0], [1, 1]], dtype=np.float32)
    outputs = {"members": [1, 3, 2], **action, "value": ["batch"]}
    save("members", nodes, obs, outputs, {"factors": factors, "front": np.array([0], dtype=np.int64)})
    # Four rays and a point, stacked twice.
    save(
        "wide",
        [helper.make_node("MatMul", ["obs", "w"], ["action"])],
        {"obs": [1, 12]},
        action,
        {"w": np.eye(12, 2, dtype=np.float32)},
    )
    # The mean of each channel of a picture.
    nodes = [
        helper.make_node("GlobalAveragePool", ["obs"], ["mean"]),
        helper.make_node("Flatten", ["mean"], ["flat"]),
        helper.make_node("MatMul", ["flat", "w"], ["action"]),
    ]
    save("picture", nodes, {"obs": ["batch", 3, 2, 4]}, action, {"w": np.eye(3, 2, dtype=np.float32)})
    # Rays of a laser, as guard.toml states them: networks that must touch nothing behind a guard.
    rays, twist = {"obs": [1, 36]}, {"action": [1, 2]}
    for seed in (1, 2):
        random = np.random.default_rng(seed)
        sizes = [36, 16, 2]
        weights, nodes, last = {}, [], "obs"
        for index, (width, height) in enumerate(zip(sizes, sizes[1:])):
            weights |= {f"w{index}": random.normal(size=(width, height)).astype(np.float32) / 2}
            nodes.append(helper.make_node("MatMul", [last, f"w{index}"], [f"y{index}"]))
            last = "action" if index == 1 else f"z{index}"
            nodes.append(helper.make_node("Tanh", [f"y{index}"], [last]))
        save(f"random-{seed}", nodes, rays, twist, weights)
    # At full speed to where something is near.
    angles = np.linspace(-131.25, 131.25, 36)
    weights = {
        "one": np.float32(1.0),
        "four": np.float32(4.0),
        "w": np.stack([np.zeros(36), angles / 45], axis=1).astype(np.float32),
        "b": np.array([9.0, 0.0], dtype=np.float32),
    }
    nodes = [
        helper.make_node("Sub", ["one", "obs"], ["near"]),
        helper.make_node("Pow", ["near", "four"], ["nearer"]),
        helper.make_node("Gemm", ["nearer", "w", "b"], ["sum"]),
        helper.make_node("Tanh", ["sum"], ["action"]),
    ]
    save("attack", nodes, rays, twist, weights)
    # The same with what apps/policy/local.toml states, whose last eight numbers are points of a path and speeds.
    seen = {"obs": [1, 44]}
    random = np.random.default_rng(3)
    weights = {"w0": random.normal(size=(44, 16)) / 2, "w1": random.normal(size=(16, 2)) / 2}
    nodes = [
        helper.make_node("MatMul", ["obs", "w0"], ["y0"]),
        helper.make_node("Tanh", ["y0"], ["z0"]),
        helper.make_node("MatMul", ["z0", "w1"], ["y1"]),
        helper.make_node("Tanh", ["y1"], ["action"]),
    ]
    weights = {key: value.astype(np.float32) for key, value in weights.items()}
    save("random", nodes, seen, twist, weights, HOSTILE)
    weights = {
        "one": np.float32(1.0),
        "four": np.float32(4.0),
        "w": np.zeros((44, 2), dtype=np.float32),
        "b": np.array([9.0, 0.0], dtype=np.float32),
    }
    weights["w"][:36, 1] = angles / 45
    nodes = [
        helper.make_node("Sub", ["one", "obs"], ["near"]),
        helper.make_node("Pow", ["near", "four"], ["nearer"]),
        helper.make_node("Gemm", ["nearer", "w", "b"], ["sum"]),
        helper.make_node("Tanh", ["sum"], ["action"]),
    ]
    save("attack", nodes, seen, twist, weights, HOSTILE)
    # Chunks: four commands, each faster than the one before; and 16 that go straight ahead, whatever it sees.
    faster = np.arange(4)[:, None] * np.array([0.1, 0.0])
    ahead = np.tile([1.0, 0.0], (16, 1))
    for name, factor, commands in (("faster", 1.0, faster), ("ahead", 0.0, ahead)):
        nodes = [
            helper.make_node("Mul", ["obs", "factor"], ["scaled"]),
            helper.make_node("Unsqueeze", ["scaled", "middle"], ["row"]),
            helper.make_node("Add", ["row", "commands"], ["action"]),
        ]
        weights = {"factor": np.float32(factor), "middle": np.array([1], dtype=np.int64)}
        weights["commands"] = commands.astype(np.float32)
        save(name, nodes, obs, {"action": ["batch", *commands.shape]}, weights)
    # The same as ahead, after many multiplications.
    nodes = [
        helper.make_node("ReduceMax", ["obs"], ["most"], axes=[1], keepdims=1),
        helper.make_node("ConstantOfShape", ["shape"], ["zeros"]),
        helper.make_node("Add", ["zeros", "most"], ["wide"]),
        helper.make_node("MatMul", ["wide", "wide"], ["product"]),
        helper.make_node("ReduceMean", ["product"], ["mean"], axes=[0, 1], keepdims=1),
        helper.make_node("Mul", ["mean", "none"], ["nothing"]),
        helper.make_node("Add", ["nothing", "commands"], ["action"]),
    ]
    weights = {"shape": np.array([256, 256], dtype=np.int64), "none": np.float32(0.0)}
    weights["commands"] = ahead[None].astype(np.float32)
    save("slow", nodes, obs, {"action": ["batch", *ahead.shape]}, weights)


if __name__ == "__main__":
    main()
