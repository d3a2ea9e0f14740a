"""Writes the networks of the tests, and what onnxruntime computes with them: `pip install onnx onnxruntime`, then run this.

`data/NAME.onnx` is a network, and `expected.txt` has for each one its inputs and outputs. Those of `refused.txt` are
networks that must not run, each with words of the message.
"""

from pathlib import Path

import numpy as np
import onnx
import onnxruntime
from onnx import TensorProto, helper, numpy_helper

DATA = Path(__file__).with_name("data")
RANDOM = np.random.default_rng(7)
expected: list[str] = []
refused: list[str] = []


def numbers(*shape):
    """Return random weights."""
    return RANDOM.normal(scale=0.7, size=shape).astype(np.float32)


def kind(nodes, name):
    """Return the type of an output: places are whole numbers."""
    is_place = any(name in node.output and node.op_type == "ArgMax" for node in nodes)
    return TensorProto.INT64 if is_place else TensorProto.FLOAT


def model(nodes, inputs, outputs, weights=None, opset=17):
    """Return a model; inputs are shapes by name, and outputs are names."""
    stored = [numpy_helper.from_array(np.asarray(value), name) for name, value in (weights or {}).items()]
    graph = helper.make_graph(
        nodes,
        "network",
        [helper.make_tensor_value_info(name, TensorProto.FLOAT, shape) for name, shape in inputs.items()],
        [helper.make_tensor_value_info(name, kind(nodes, name), None) for name in outputs],
        stored,
    )
    return helper.make_model(graph, opset_imports=[helper.make_opsetid("", opset)], ir_version=10)


def case(name, made, scale=1.0):
    """Keep a model and its numbers."""
    onnx.save(made, DATA / f"{name}.onnx")
    options = onnxruntime.SessionOptions()
    options.graph_optimization_level = onnxruntime.GraphOptimizationLevel.ORT_DISABLE_ALL
    session = onnxruntime.InferenceSession(made.SerializeToString(), options)
    given = {}
    for port in session.get_inputs():
        shape = [side if isinstance(side, int) else 1 for side in port.shape]
        given[port.name] = (scale * RANDOM.normal(size=shape)).astype(np.float32)
    results = session.run(None, given)
    expected.append(f"case {name}")
    for key, value in given.items():
        expected.append(" ".join(["input", key, *map(repr, map(float, value.ravel()))]))
    for port, value in zip(session.get_outputs(), results):
        shape = "x".join(map(str, value.shape)) or "-"
        expected.append(" ".join(["output", port.name, shape, *map(repr, map(float, value.ravel()))]))


def refuse(name, made, words):
    """Keep a model that must not run."""
    (DATA / f"{name}.onnx").write_bytes(made if isinstance(made, bytes) else made.SerializeToString())
    refused.append(f"{name}: {words}")


def one(name, operator, shapes, weights=None, opset=17, outputs=1, scale=1.0, **attributes):
    """Keep a model of one node, whose first inputs are those of the network."""
    names = [f"out{index}" for index in range(outputs)]
    inputs = {f"in{index}": shape for index, shape in enumerate(shapes)}
    node = helper.make_node(operator, [*inputs, *(weights or {})], names, name=f"the {operator}", **attributes)
    case(name, model([node], inputs, names, weights, opset), scale)


def whole(*values):
    """Return whole numbers."""
    return np.array(values, dtype=np.int64)


def elementwise():
    """Functions of single numbers."""
    for operator in [
        "Relu",
        "Tanh",
        "Sigmoid",
        "Softplus",
        "Softsign",
        "Exp",
        "Neg",
        "Abs",
        "Sin",
        "Cos",
        "Erf",
        "Floor",
        "Ceil",
        "Identity",
        "Reciprocal",
        "HardSwish",
        "Elu",
        "Selu",
        "LeakyRelu",
        "HardSigmoid",
    ]:
        one(operator.lower(), operator, [[2, 5]], scale=2.0)
    one("elu-alpha", "Elu", [[2, 5]], alpha=0.3)
    one("leakyrelu-alpha", "LeakyRelu", [[2, 5]], alpha=0.3, opset=11)
    one("mish", "Mish", [[2, 5]], opset=18, scale=3.0)
    one("gelu", "Gelu", [[2, 5]], opset=20)
    one("gelu-tanh", "Gelu", [[2, 5]], opset=20, approximate="tanh")
    absolute = helper.make_node("Abs", ["in"], ["abs"])
    for operator in ["Log", "Sqrt"]:
        case(operator.lower(), model([absolute, helper.make_node(operator, ["abs"], ["out"])], {"in": [2, 5]}, ["out"]))
    one("clip", "Clip", [[2, 5]], {"least": np.float32(-0.3), "most": np.float32(0.4)})
    one("clip-9", "Clip", [[2, 5]], opset=9, min=-0.3, max=0.4)
    one("prelu", "PRelu", [[2, 5]], {"slope": numbers(5)})
    one("dropout", "Dropout", [[2, 5]], opset=12)
    one("dropout-9", "Dropout", [[2, 5]], opset=9, ratio=0.4)


def arithmetic():
    """Arithmetic with shapes that fit."""
    for operator in ["Add", "Sub", "Mul", "Div"]:
        one(operator.lower(), operator, [[2, 3, 4], [3, 1]])
    one("add-scalar", "Add", [[2, 3]], {"one": np.float32(1.5)})
    one("add-wider", "Add", [[3]], {"wide": numbers(2, 3)}, opset=24)
    one("pow", "Pow", [[2, 3]], {"two": np.float32(2.0)})
    for operator in ["Min", "Max", "Sum"]:
        one(operator.lower(), operator, [[2, 3], [3], [1, 1]])
    one("matmul", "MatMul", [[2, 3]], {"w": numbers(3, 4)})
    one("matmul-vector", "MatMul", [[3]], {"w": numbers(3, 4)})
    one("matmul-column", "MatMul", [[2, 3]], {"w": numbers(3)})
    one("matmul-batch", "MatMul", [[2, 1, 2, 3], [3, 3, 4]])
    one("gemm", "Gemm", [[2, 11]], {"w": numbers(11, 4), "b": numbers(4)})
    one("gemm-transposed", "Gemm", [[2, 11]], {"w": numbers(4, 11), "b": numbers(2, 1)}, transB=1, alpha=0.5, beta=2.0)
    one("gemm-alone", "Gemm", [[1, 19]], {"w": numbers(4, 19)}, transB=1, opset=13)


def shapes():
    """What moves numbers."""
    one("reshape", "Reshape", [[2, 3, 4]], {"shape": whole(0, -1)})
    one("flatten", "Flatten", [[2, 3, 4]], axis=2)
    one("flatten-9", "Flatten", [[2, 3, 4]], axis=0, opset=9)
    one("squeeze", "Squeeze", [[1, 3, 1]], {"axes": whole(-1)})
    one("squeeze-11", "Squeeze", [[1, 3, 1]], opset=11, axes=[0])
    one("squeeze-all", "Squeeze", [[1, 3, 1]])
    one("unsqueeze", "Unsqueeze", [[3, 2]], {"axes": whole(-1, 0)})
    one("unsqueeze-11", "Unsqueeze", [[3, 2]], opset=11, axes=[1, 3])
    one("transpose", "Transpose", [[2, 3, 4]], perm=[1, 2, 0])
    one("transpose-all", "Transpose", [[2, 3]])
    one("concat", "Concat", [[2, 3, 2], [2, 1, 2]], axis=-2)
    one(
        "slice",
        "Slice",
        [[4, 5]],
        {"starts": whole(-1, 1), "ends": whole(-100, 4), "axes": whole(0, 1), "steps": whole(-2, 2)},
    )
    one("slice-plain", "Slice", [[4, 5]], {"starts": whole(1), "ends": whole(1 << 62)})
    one("slice-9", "Slice", [[4, 5]], opset=9, starts=[0, -3], ends=[2, -1])
    one("split", "Split", [[2, 6]], {"parts": whole(1, 5)}, outputs=2, axis=1)
    one("split-11", "Split", [[2, 6]], outputs=3, axis=1, opset=11)
    one("split-18", "Split", [[2, 7]], outputs=3, axis=1, opset=18, num_outputs=3)
    one("gather", "Gather", [[3, 4]], {"indices": np.array([[2, -1], [0, 0]], dtype=np.int64)}, axis=1)
    one("expand", "Expand", [[3, 1]], {"shape": whole(2, 1, 4)})
    # What PyTorch writes for `view(x.size(0), -1)`.
    nodes = [
        helper.make_node("Shape", ["in"], ["shape"]),
        helper.make_node("Constant", [], ["zero"], value=numpy_helper.from_array(np.int64(0))),
        helper.make_node("Gather", ["shape", "zero"], ["rows"], axis=0),
        helper.make_node("Constant", [], ["axis"], value_ints=[0]),
        helper.make_node("Unsqueeze", ["rows", "axis"], ["row"]),
        helper.make_node("Constant", [], ["rest"], value=numpy_helper.from_array(whole(-1))),
        helper.make_node("Concat", ["row", "rest"], ["sides"], axis=0),
        helper.make_node("Reshape", ["in", "sides"], ["flat"]),
        helper.make_node(
            "ConstantOfShape", ["sides0"], ["ones"], value=numpy_helper.from_array(np.array([2.5], np.float32))
        ),
        helper.make_node("Cast", ["sides0"], ["float"], to=TensorProto.FLOAT),
        helper.make_node("Mul", ["ones", "float"], ["scaled"]),
        helper.make_node("Add", ["flat", "scaled"], ["out"]),
    ]
    case("dynamic", model(nodes, {"in": ["batch", 3, 4]}, ["out"], {"sides0": whole(12)}))


def reductions():
    """What combines numbers."""
    for operator in ["ReduceMean", "ReduceMax", "ReduceMin", "ReduceL2", "ReduceSumSquare"]:
        one(operator.lower(), operator, [[2, 3, 4]], axes=[1, -1], keepdims=0)
        one(f"{operator.lower()}-18", operator, [[2, 3, 4]], {"axes": whole(1)}, opset=20)
    one("reducesum", "ReduceSum", [[2, 3, 4]], {"axes": whole(0, 2)})
    one("reducesum-all", "ReduceSum", [[2, 3]], keepdims=0)
    for operator in ["Softmax", "LogSoftmax"]:
        one(operator.lower(), operator, [[2, 3, 4]], axis=1)
        one(f"{operator.lower()}-11", operator, [[2, 3, 4]], axis=1, opset=11)
    one("layernorm", "LayerNormalization", [[2, 3, 4]], {"scale": numbers(4), "bias": numbers(4)})
    one("layernorm-axis", "LayerNormalization", [[2, 3, 4]], {"scale": numbers(3, 4)}, axis=1, epsilon=1e-3)
    statistics = {"scale": numbers(3), "bias": numbers(3), "mean": numbers(3), "var": np.abs(numbers(3))}
    one("batchnorm", "BatchNormalization", [[2, 3, 4]], statistics, epsilon=1e-3)
    one("batchnorm-9", "BatchNormalization", [[2, 3]], statistics, opset=9, momentum=0.8)


def windows():
    """Convolutions and pools."""
    one("conv", "Conv", [[1, 2, 5, 6]], {"w": numbers(3, 2, 3, 2), "b": numbers(3)}, strides=[2, 1], pads=[1, 0, 1, 1])
    one("conv-groups", "Conv", [[2, 4, 5, 5]], {"w": numbers(6, 2, 2, 2)}, group=2, dilations=[2, 1])
    one("conv-row", "Conv", [[1, 2, 9]], {"w": numbers(3, 2, 3)}, strides=[2], kernel_shape=[3])
    one("conv-same", "Conv", [[1, 1, 5, 6]], {"w": numbers(1, 1, 2, 4)}, auto_pad="SAME_UPPER", strides=[2, 2])
    one("conv-lower", "Conv", [[1, 1, 5, 6]], {"w": numbers(1, 1, 2, 4)}, auto_pad="SAME_LOWER", opset=22)
    one("maxpool", "MaxPool", [[1, 2, 5, 6]], kernel_shape=[2, 3], strides=[2, 2], pads=[1, 1, 0, 1])
    one("averagepool", "AveragePool", [[1, 2, 5, 6]], kernel_shape=[2, 3], strides=[2, 2], pads=[1, 1, 0, 1])
    one("averagepool-pads", "AveragePool", [[1, 2, 6]], kernel_shape=[3], pads=[1, 1], count_include_pad=1)
    one("globalaveragepool", "GlobalAveragePool", [[1, 2, 5, 6]])


def recurrent():
    """Recurrent layers over three times with a state."""

    def layer(name, operator, gates, opset=17, bias=True, cell=False, **attributes):
        weights = {"w": numbers(1, gates * 5, 3), "r": numbers(1, gates * 5, 5)}
        if bias:
            weights["b"] = numbers(1, 2 * gates * 5)
        states = {"h": [1, 2, 5], **({"c": [1, 2, 5]} if cell else {})}
        outputs = ["all", "last", *(["cell"] if cell else [])]
        node = helper.make_node(
            operator, ["x", "w", "r", "b" if bias else "", "", *states], outputs, hidden_size=5, **attributes
        )
        case(name, model([node], {"x": [3, 2, 3], **states}, outputs, weights, opset))

    layer("rnn", "RNN", 1)
    layer("gru", "GRU", 3)
    layer("gru-linear-before-reset", "GRU", 3, linear_before_reset=1)
    layer("gru-9", "GRU", 3, opset=9, bias=False)
    layer("lstm", "LSTM", 4, cell=True, activations=["Sigmoid", "Tanh", "Tanh"], direction="forward")
    layer("lstm-22", "LSTM", 4, opset=22, cell=True)


def whole_networks():
    """Networks as policies have them."""
    layers = [(12, 64), (64, 64), (64, 2)]
    weights, nodes, last = {}, [], "obs"
    for index, (width, height) in enumerate(layers):
        weights |= {f"w{index}": numbers(height, width) / 4, f"b{index}": numbers(height) / 4}
        nodes.append(helper.make_node("Gemm", [last, f"w{index}", f"b{index}"], [f"y{index}"], transB=1))
        nodes.append(helper.make_node("Tanh", [f"y{index}"], [f"z{index}"]))
        last = f"z{index}"
    made = model(nodes, {"obs": ["batch", 12]}, [last], weights)
    case("mlp", made)
    onnx.save(made, DATA / "external.onnx", save_as_external_data=True, location="external.data", size_threshold=0)
    expected.extend(line.replace("case mlp", "case external") for line in expected[-3:])


def choices():
    """The highest of several, and what is at its place."""
    for name, opset, attributes in [
        ("argmax", 17, {"axis": 1, "keepdims": 0}),
        ("argmax-11", 11, {"axis": -1}),
        ("argmax-first", 13, {"axis": 0, "keepdims": 0}),
    ]:
        one(name, "ArgMax", [[2, 5]], opset=opset, **attributes)
    # Equal ones, of which the first or the last is chosen.
    for name, last in [("argmax-equal", 0), ("argmax-last", 1)]:
        nodes = [
            helper.make_node("Mul", ["in", "none"], ["zeros"]),
            helper.make_node("ArgMax", ["zeros"], ["out"], axis=1, select_last_index=last),
        ]
        case(name, model(nodes, {"in": [2, 5]}, ["out"], {"none": np.float32(0.0)}))
    one("reducelogsumexp", "ReduceLogSumExp", [[2, 3, 4]], axes=[1, -1], keepdims=0, scale=40.0)
    one("reducelogsumexp-18", "ReduceLogSumExp", [[2, 3, 4]], {"axes": whole(1)}, opset=20)
    one("gatherelements", "GatherElements", [[2, 3]], {"places": np.array([[2, -1], [0, 0]], np.int64)}, axis=1)
    one("gatherelements-first", "GatherElements", [[2, 3]], {"places": np.array([[1, 0, 1]], np.int64)})
    # What PyTorch writes for the logarithm of the probability of what was chosen.
    nodes = [
        helper.make_node("ArgMax", ["in"], ["best"], axis=1, keepdims=0),
        helper.make_node("Unsqueeze", ["best", "end"], ["column"]),
        helper.make_node("Add", ["column", "zero"], ["places"]),
        helper.make_node("Expand", ["places", "wide"], ["rows"]),
        helper.make_node("Slice", ["rows", "zero", "one", "one"], ["first"]),
        helper.make_node("GatherElements", ["in", "first"], ["out"], axis=-1),
        helper.make_node("Cast", ["places"], ["number"], to=TensorProto.FLOAT),
    ]
    weights = {"end": whole(-1), "zero": whole(0), "one": whole(1), "wide": whole(2, 5)}
    case("chosen", model(nodes, {"in": [2, 5]}, ["out", "number"], weights))


def huge():
    """What takes more than a robot has, by its shapes alone."""

    def filled(name, *sides):
        return helper.make_node("ConstantOfShape", [name], [f"of {name}"]), {name: whole(*sides)}

    left, sides = filled("side", 4096, 4096)
    nodes = [
        left,
        helper.make_node("Add", ["of side", "in"], ["wide"]),
        helper.make_node("MatMul", ["wide", "wide"], ["out"], name="product"),
    ]
    made = model(nodes, {"in": [1, 1]}, ["out"], sides)
    refuse("huge-product", made, "node `product` (MatMul): its result of the shape [4096, 4096] takes 68736253952")
    node = helper.make_node("Conv", ["in", "w"], ["out"], name="window", pads=[1500, 1500, 1500, 1500])
    made = model([node], {"in": [1, 1, 99, 99]}, ["out"], {"w": numbers(1, 1, 99, 99)})
    refuse("huge-window", made, "node `window` (Conv): its result of the shape [1, 1, 3001, 3001] takes")
    node = helper.make_node("RNN", ["in", "w", "r"], ["out"], name="long", hidden_size=96)
    weights = {"w": numbers(1, 96, 64), "r": numbers(1, 96, 96)}
    made = model([node], {"in": [1 << 17, 1, 64]}, ["out"], weights)
    refuse("huge-time", made, "node `long` (RNN): its result of the shape [131072, 1, 1, 96] takes 2214592512")
    wide, sides = filled("side", 1 << 40, 1)
    wide.name = "wide"
    refuse(
        "huge-memory",
        model([wide, helper.make_node("Add", ["of side", "in"], ["out"])], {"in": [1, 1]}, ["out"], sides),
        "node `wide` (ConstantOfShape): a tensor of the shape [1099511627776, 1] is too large",
    )
    made = model([helper.make_node("Relu", ["in"], ["out"])], {"in": [1 << 40, 1]}, ["out"])
    refuse("huge-input", made, "tensor `in`: its numbers and those before it need too much memory")
    # Each is small enough, and all together are not.
    nodes = [
        helper.make_node("Sum", [f"y{index}"] * 64, [f"y{index + 1}"], name=f"sum {index}") for index in range(64)
    ]
    made = model(nodes, {"y0": [1, 1 << 19]}, ["y64"])
    refuse("huge-many", made, "node `sum 4` (Sum): it and the nodes before it take 2642411520 operations, and 2147483648")
    # Each gives one number, and compares many.
    nodes = [
        helper.make_node("ArgMax", ["in"], [f"y{index}"], name=f"best {index}", axis=1, keepdims=0) for index in range(80)
    ]
    made = model(nodes, {"in": [1, 1 << 22]}, ["y79"])
    words = "node `best 64` (ArgMax): it and the nodes before it take 2181038080 operations, and 2147483648"
    refuse("huge-choices", made, words)


def refusals():
    """What must not run."""
    nodes = [
        helper.make_node("ArgMax", ["in"], ["best"], axis=1, keepdims=0),
        helper.make_node("Expand", ["in", "best"], ["out"], name="wider"),
    ]
    words = "node `wider` (Expand): its input 1 is whole numbers that depend on the inputs"
    refuse("chosen-shape", model(nodes, {"in": [1, 2]}, ["out"]), words)
    node = helper.make_node("Cast", ["in"], ["out"], name="rounded", to=TensorProto.INT64)
    words = "node `rounded` (Cast): it makes whole numbers of others that depend on the inputs"
    refuse("whole", model([node], {"in": [1, 2]}, ["out"]), words)
    plain = helper.make_node("Relu", ["in"], ["out"], name="act")
    for opset in [8, 26]:
        refuse(f"opset-{opset}", model([plain], {"in": [1, 2]}, ["out"], opset=opset), f"the network has opset {opset}")
    node = helper.make_node("NonMaxSuppression", ["in", "in"], ["out"], name="boxes")
    refuse(
        "unknown", model([node], {"in": [1, 2]}, ["out"]), "node `boxes` (NonMaxSuppression): this operator is not run"
    )
    node = helper.make_node("Relu", ["in"], ["out"], name="own", domain="com.example")
    refuse("domain", model([node], {"in": [1, 2]}, ["out"]), "node `own` (Relu): operators of `com.example`")
    node = helper.make_node("MaxPool", ["in"], ["out"], name="pool", kernel_shape=[2], ceil_mode=1)
    refuse("ceil-mode", model([node], {"in": [1, 1, 5]}, ["out"]), "node `pool` (MaxPool): `ceil_mode` is 1")
    node = helper.make_node("Relu", ["in"], ["out"], name="act", slope=0.5)
    refuse("attribute", model([node], {"in": [1, 2]}, ["out"]), "node `act` (Relu): its attribute `slope`")
    node = helper.make_node("Gemm", ["in", "w"], ["out"], name="layer")
    refuse("unfit", model([node], {"in": [1, 2]}, ["out"], {"w": numbers(3, 2)}), "node `layer` (Gemm): the matrices")
    refuse(
        "float16",
        model([node], {"in": [1, 2]}, ["out"], {"w": numbers(2, 2).astype(np.float16)}),
        "tensor `w`: its numbers are FLOAT16",
    )
    refuse(
        "double",
        model([node], {"in": [1, 2]}, ["out"], {"w": numbers(2, 2).astype(np.float64)}),
        "tensor `w`: its numbers are DOUBLE",
    )
    quantized = {"w": np.array([[1, 2], [3, 4]], dtype=np.int8), "scale": np.float32(0.1), "zero": np.int8(0)}
    nodes = [
        helper.make_node("DequantizeLinear", ["w", "scale", "zero"], ["weights"], name="wide"),
        helper.make_node("MatMul", ["in", "weights"], ["out"]),
    ]
    refuse("int8", model(nodes, {"in": [1, 2]}, ["out"], quantized), "tensor `w`: its numbers are INT8")
    broken = numbers(2, 2)
    broken[1, 0] = np.nan
    refuse("nan", model([node], {"in": [1, 2]}, ["out"], {"w": broken}), "tensor `w`: number 2 is NaN")
    broken[1, 0] = np.inf
    refuse("infinite", model([node], {"in": [1, 2]}, ["out"], {"w": broken}), "tensor `w`: number 2 is inf")
    weights = {"w": numbers(1, 15, 3), "r": numbers(1, 15, 5)}
    for direction in ["reverse", "bidirectional"]:
        node = helper.make_node("GRU", ["in", "w", "r"], ["out"], name="gru", hidden_size=5, direction=direction)
        refuse(
            direction,
            model([node], {"in": [3, 1, 3]}, ["out"], weights),
            f"node `gru` (GRU): `direction` is `{direction}`",
        )
    node = helper.make_node("GRU", ["in", "w", "r"], ["out"], name="gru", hidden_size=5, activations=["Relu", "Tanh"])
    refuse("activations", model([node], {"in": [3, 1, 3]}, ["out"], weights), "node `gru` (GRU): `activations`")
    sub = helper.make_graph(
        [helper.make_node("Relu", ["in"], ["y"])],
        "then",
        [],
        [helper.make_tensor_value_info("y", TensorProto.FLOAT, None)],
    )
    node = helper.make_node("If", ["c"], ["out"], name="either", then_branch=sub, else_branch=sub)
    refuse("if", model([node], {"in": [1, 2], "c": [1]}, ["out"]), "node `either` (If): this operator is not run")
    node = helper.make_node("Relu", ["elsewhere"], ["out"], name="act")
    refuse("missing", model([node], {"in": [1, 2]}, ["out"]), "node `act` (Relu): it takes `elsewhere`")
    refuse("no-shape", model([plain], {"in": None}, ["out"]), "tensor `in`: this input states no shape")
    refuse("open-width", model([plain], {"in": [1, "width"]}, ["out"]), "tensor `in`: its last dimension has no number")
    made = model([plain], {"in": [1, 2]}, ["out"])
    made.graph.input[0].type.tensor_type.elem_type = TensorProto.FLOAT16
    refuse("float16-input", made, "tensor `in`: its numbers are FLOAT16")
    for name, location, words in [
        ("escape", "../escape.data", "which leaves the network's folder"),
        ("absolute", "/etc/hostname", "which leaves the network's folder"),
        ("absent", "absent.data", "which cannot be read"),
        ("short", "external.data", "ends before its weights"),
    ]:
        made = model(
            [helper.make_node("Gemm", ["in", "w"], ["out"])], {"in": [1, 200]}, ["out"], {"w": numbers(200, 200)}
        )
        tensor = made.graph.initializer[0]
        tensor.ClearField("raw_data")
        tensor.data_location = TensorProto.EXTERNAL
        tensor.external_data.add(key="location", value=location)
        tensor.external_data.add(key="length", value=str(200 * 200 * 4))
        refuse(name, made, words)
    refuse("text", b"this is no network at all", "")
    refuse("empty", b"", "the file has no network")


def main():
    """Write everything."""
    DATA.mkdir(exist_ok=True)
    for old in DATA.iterdir():
        if not old.name.startswith("sb3"):
            old.unlink()
    for family in [elementwise, arithmetic, shapes, reductions, windows, recurrent, whole_networks, choices, huge, refusals]:
        family()
    (DATA / "expected.txt").write_text("\n".join(expected) + "\n")
    (DATA / "refused.txt").write_text("\n".join(refused) + "\n")


if __name__ == "__main__":
    main()
