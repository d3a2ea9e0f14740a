"""Drives the same motions in both simulators, and prints a table of what the base does in each.

PYTHONPATH=target/python JDE_PYTHON=mj/bin/python mj/bin/python examples/mujoco/motions.py [model ...]
"""

import math
import sys
from pathlib import Path

import numpy as np

import jde

APPLICATION = Path(__file__).with_name("motions.toml")
TYPES = {"sim": "sim/robot", "mujoco": "mujoco/Robot"}
#: Each motion is a list of a time, s, and shares of the greatest speed and turn rate that are commanded in it.
MOTIONS = {
    "step ahead": [(4.0, 0.75, 0.0), (2.0, 0.0, 0.0)],
    "turn on the spot, slowly": [(4.0, 0.0, 0.1), (2.0, 0.0, 0.0)],
    "turn on the spot": [(4.0, 0.0, 0.5), (2.0, 0.0, 0.0)],
    "curve, slowly": [(4.0, 0.25, 0.15), (2.0, 0.0, 0.0)],
    "curve": [(4.0, 0.5, 0.3), (2.0, 0.0, 0.0)],
}
LIMITS = {"turtlebot4": (0.46, 1.9), "jackal": (2.0, 4.0)}


def eight(turn):
    """Return a figure of eight: a circle to the left and one to the right."""
    time = math.tau / turn
    return [(time, 0.3, turn), (time, 0.3, -turn), (2.0, 0.0, 0.0)]


def drive(kind, model, motion):
    """Return time, pose, speeds and odometry every 20 ms."""
    settings = {"robot.type": TYPES[kind], "robot.model": model, "robot.wheel_error": 0.0}
    with jde.run(APPLICATION, seed=1, set=settings, mocks=["driver"]) as run:
        run.until(1.0)
        rows, time = [], 1.0
        for seconds, ahead, turn in motion:
            end = time + seconds
            while time < end - 1e-9:
                run["driver.base"] = {"linear": {"x": ahead}, "angular": {"z": turn}}
                time += 0.02
                run.until(time)
                truth, odometry = run["robot.truth"], run["robot.odometry"].pose2d()
                pose, twist = truth.pose, truth.twist
                rows.append((time - 1.0, pose.x, pose.y, pose.theta, twist.linear.x, twist.angular.z, odometry.theta))
    rows = np.array(rows)
    rows[:, 3], rows[:, 6] = np.unwrap(rows[:, 3]), np.unwrap(rows[:, 6])
    return rows


def figures(motion, rows):
    """Return what the base did, as texts by what they are."""
    (seconds, ahead, turn), result = motion[0], {}
    moving = rows[rows[:, 0] <= seconds + 1e-9]
    steady = moving[moving[:, 0] > seconds / 2]
    if turn == 0.0:
        speeds = moving[:, 4]
        result["time to 90 %"] = f"{moving[np.argmax(speeds >= 0.9 * ahead), 0]:.2f} s"
        result["speed"] = f"{steady[:, 4].mean() / ahead:.3f}"
        result["way to stop"] = f"{rows[:, 1].max() - moving[-1, 1]:.3f} m"
    else:
        result["turn"] = f"{steady[:, 5].mean() / turn:.3f}"
        result["odometry's turn"] = f"{(moving[-1, 6] - moving[0, 6]) / (moving[-1, 3] - moving[0, 3]):.3f}"
    return result


def main():
    """Print the table."""
    for model in sys.argv[1:] or ["turtlebot4", "jackal", "realistic-jackal"]:
        fastest, quickest = LIMITS[model.removeprefix("realistic-")]
        print(f"\n{model}\n| motion | | sim | mujoco |\n|---|---|---|---|")
        for name, shares in MOTIONS.items():
            motion = [(seconds, ahead * fastest, turn * quickest) for seconds, ahead, turn in shares]
            both = [figures(motion, drive(kind, model, motion)) for kind in TYPES]
            for figure in both[0]:
                command = f"{motion[0][1]:.2f} m/s, {motion[0][2]:.2f} rad/s"
                print(f"| {name} ({command}) | {figure} | {both[0][figure]} | {both[1][figure]} |", flush=True)
        motion = eight(0.25 * quickest)
        ends = [drive(kind, model, motion)[-1] for kind in TYPES]
        ends = [f"{math.hypot(end[1], end[2]):.2f} m" for end in ends]
        print(f"| figure of eight | from the start at the end | {ends[0]} | {ends[1]} |", flush=True)


if __name__ == "__main__":
    main()
