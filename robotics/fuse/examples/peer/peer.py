"""An extended Kalman filter of filterpy with the same models, on the measurements that the example writes (see main.rs).

Its derivatives are numerical, and the turn of the wheels is a measurement of the turn rate: it shares no formula with the
crate but the models. It refuses nothing, and takes nothing late.
"""

import math
import sys
import time
from collections import defaultdict

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter

INITIAL = [0.01, 0.01, 0.01, 1, 1, 1, 0.05, 0.02, 0.05, 0.05]
GROWTH = [1e-6, 1e-6, 1e-6, 0.2, 1e-4, 1.0, 1e-8, 0, 0, 0]


def angle(value):
    return math.atan2(math.sin(value), math.cos(value))


def after(s, dt):
    x, y, yaw, vx, vy, rate = s[:6]
    heading = yaw + rate * dt / 2
    n = s.copy()
    n[0] += dt * (vx * math.cos(heading) - vy * math.sin(heading))
    n[1] += dt * (vx * math.sin(heading) + vy * math.cos(heading))
    n[2] = angle(yaw + rate * dt)
    return n


def derivative(f, s):
    columns = []
    for at in range(len(s)):
        step = np.zeros(len(s))
        step[at] = 1e-6
        columns.append((f(s + step) - f(s - step)) / 2e-6)
    return np.array(columns).T


def wheels(s):
    scale = 1 + s[7]
    return np.array([scale * s[3], scale * s[4], (1 + s[8]) * s[5] + s[9] * s[3]])


MODELS = {
    "turn": (lambda s: np.array([s[5] + s[6]]), [0.005]),
    "wheels": (wheels, [0.01, 0.001, 0.02]),
    "stands": (lambda s: s[3:6], [0.002, 0.002, 0.0005]),
    "fix": (lambda s: s[0:2], [0.05, 0.05]),
}


def take(f, kind, z):
    h, deviations = MODELS[kind]
    f.update(np.array(z), lambda s: derivative(h, s), h, R=np.diag(np.square(deviations)))
    f.x[2] = angle(f.x[2])


def run(lines):
    f = ExtendedKalmanFilter(dim_x=10, dim_z=1)
    f.x, f.P = np.zeros(10), np.diag(np.square(INITIAL))
    now = 0.0
    for stamp, kind, numbers in lines:
        if kind == "truth":
            x, y, yaw, bias = numbers
            e = np.array([f.x[0] - x, f.x[1] - y, angle(f.x[2] - yaw)])
            return e[0] ** 2 + e[1] ** 2, e[2] ** 2, (f.x[6] - bias) ** 2, e @ np.linalg.solve(f.P[:3, :3], e)
        dt = stamp - now
        if dt > 0:
            F = derivative(lambda s: after(s, dt), f.x)
            # The noise acts in the middle of the motion.
            half = derivative(lambda s: after(s, dt / 2), f.x)
            f.x = after(f.x, dt)
            f.P = F @ f.P @ F.T + half @ np.diag(GROWTH) @ half.T * dt
            now = stamp
        stands = kind == "wheels" and numbers.pop() > 0
        take(f, kind, numbers)
        if stands:
            take(f, "stands", [0, 0, 0])


def main():
    drives, count = defaultdict(list), 0
    for line in open(sys.argv[1]):
        key, stamp, kind, *numbers = line.split(",")
        drives[key].append((float(stamp), kind, [float(number) for number in numbers]))
        count += 1
    start = time.perf_counter()
    for name, fixes in [("wheels and gyro", False), ("with fixes", True)]:
        means = np.mean([run(lines) for key, lines in drives.items() if key.endswith("f") == fixes], axis=0)
        print(f"{name}: {math.sqrt(means[0]):.3f} m, {math.degrees(math.sqrt(means[1])):.2f} degrees, "
              f"bias {math.degrees(math.sqrt(means[2])):.3f} degrees/s, NEES {means[3]:.2f}")
    print(f"{(time.perf_counter() - start) * 1e6 / count:.0f} us a measurement")


if __name__ == "__main__":
    main()
