"""Compares the filter and one of filterpy on a recorded drive: a Husky with wheels, a gyro and a satellite receiver (the bag
test/test1.bag of the project robot_localization, which is not part of this one).

    cargo build --release -p jde-fuse --example recorded
    pip install filterpy rosbags && python3 robotics/fuse/examples/recorded/recorded.py test1.bag target/release/examples/recorded
"""

import math
import subprocess
import sys
from pathlib import Path

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter
from rosbags.highlevel import AnyReader

sys.path.insert(0, str(Path(__file__).parent.parent / "peer"))
from peer import MODELS, after, angle, derivative

# The defaults of `fuse/ekf`.
INITIAL = [0, 0, 0, 1, 1, 1, 0.02, 0.02, 0.1, 0.05]
GROWTH = [1e-6, 1e-6, 1e-7, 0.5, 0.01, 0.2, 1e-7, 0, 0, 0]
# The receiver states 0.8 m, and leaps by 5 m.
FIX = 2.0


def read(bag):
    log, origin, still = [], None, None
    with AnyReader([Path(bag)]) as reader:
        for connection, _, raw in reader.messages():
            m = reader.deserialize(raw, connection.msgtype)
            t = m.header.stamp.sec + m.header.stamp.nanosec * 1e-9
            if connection.topic == "/imu/data":
                # The axis y of the unit is up.
                log.append((t, "turn", [m.angular_velocity.y, m.angular_velocity_covariance[4]]))
            elif connection.topic == "/fix":
                origin = origin or (m.latitude, m.longitude)
                east = math.radians(m.longitude - origin[1]) * 6378137 * math.cos(math.radians(origin[0]))
                log.append((t, "fix", [east, math.radians(m.latitude - origin[0]) * 6368000, FIX**2]))
            else:
                twist, c = m.twist.twist, m.twist.covariance
                ahead, rate = twist.linear.x, twist.angular.z
                still = (still or t) if abs(ahead) < 1e-3 and abs(rate) < 1e-3 else None
                stands = int(still is not None and t - still >= 0.5)
                log.append((t, "wheels", [ahead, twist.linear.y, rate, stands, c[0], c[35]]))
    log.sort(key=lambda line: line[0])
    return [(t - log[0][0], kind, n) for t, kind, n in log]


def by_wheels(log, until=math.inf):
    pose, twist, last, places = np.zeros(3), np.zeros(2), 0.0, {}
    for t, kind, n in log:
        if t > until:
            break
        heading = pose[2] + twist[1] * (t - last) / 2
        pose += (t - last) * np.array([twist[0] * math.cos(heading), twist[0] * math.sin(heading), twist[1]])
        last = t
        if kind == "wheels":
            twist = np.array([n[0], n[2]])
        elif kind == "fix":
            places[t] = pose[:2].copy()
    return places


def laid_on(places, truth):
    """The rigid motion that lays places on the true ones."""
    a, b = (np.array([some[t][:2] for t in places]) for some in (places, truth))
    p, q = a - a.mean(0), b - b.mean(0)
    turn = math.atan2((p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]).sum(), (p * q).sum())
    c, s = math.cos(turn), math.sin(turn)
    rotation = np.array([[c, -s], [s, c]])
    return turn, rotation, b.mean(0) - rotation @ a.mean(0)


def of_crate(program, log):
    lines = "\n".join(",".join([repr(t), kind, *(repr(float(x)) for x in n)]) for t, kind, n in log)
    out = subprocess.run([program], input=lines, capture_output=True, text=True, check=True).stdout
    rows = [[float(x) for x in line.split(",")] for line in out.splitlines() if not line.startswith("constants")]
    # The times of the program are in whole nanoseconds.
    times = [t for t, kind, _ in log if kind == "check"]
    return {t: row[1:] for t, row in zip(times, rows)}


def of_filterpy(log):
    f, now, places = ExtendedKalmanFilter(dim_x=10, dim_z=1), 0.0, {}
    for t, kind, n in log:
        if kind == "start":
            f.x, f.P = np.array([*n[:3], *[0.0] * 7]), np.diag(np.square([n[3], n[3], n[4], *INITIAL[3:]]))
            continue
        if (dt := t - now) > 0:
            F, half = (derivative(lambda s, d=d: after(s, d), f.x) for d in (dt, dt / 2))
            f.x, f.P, now = after(f.x, dt), F @ f.P @ F.T + half @ np.diag(GROWTH) @ half.T * dt, t
        if kind == "check":
            places[t] = [*f.x[:3], f.P[0, 0], f.P[0, 1], f.P[1, 1]]
            continue
        z, variances = {"turn": (n[:1], n[1:]), "fix": (n[:2], n[2:] * 2)}.get(kind) or (n[:3], [n[4], 1e-4, n[5]])
        updates = [(kind, z, variances)]
        if kind == "wheels" and n[3]:
            updates.append(("stands", [0, 0, 0], np.square(MODELS["stands"][1])))
        for name, z, variances in updates:
            h = MODELS[name][0]
            f.update(np.array(z), lambda s, h=h: derivative(h, s), h, R=np.diag(variances))
            f.x[2] = angle(f.x[2])
    return places


def main():
    log = read(sys.argv[1])
    fixes = {t: n for t, kind, n in log if kind == "fix"}
    turn, _, origin = laid_on(by_wheels(log, until=20), fixes)
    start = (0.0, "start", [*origin, turn, 0.5, 0.1])
    for name, is_used in [("without fixes", lambda t: False), ("10 s with fixes, 10 s without", lambda t: t % 20 < 10)]:
        lines = [start, *((t, "check" if kind == "fix" and not is_used(t) else kind, n) for t, kind, n in log)]
        for whose, places in [("jde-fuse", of_crate(sys.argv[2], lines)), ("filterpy", of_filterpy(lines))]:
            _, rotation, shift = laid_on(places, fixes)
            errors = {t: np.array(p[:2]) - fixes[t][:2] for t, p in places.items() if t > 20}
            shape = [rotation @ p[:2] + shift - fixes[t][:2] for t, p in places.items()]
            nis = [e @ np.linalg.solve([[places[t][3] + FIX**2, places[t][4]], [places[t][4], places[t][5] + FIX**2]], e)
                   for t, e in errors.items()]
            rms = [math.sqrt(np.mean(np.sum(np.square(list(some)), axis=1))) for some in (errors.values(), shape)]
            print(f"{name}, {whose}: {rms[0]:.2f} m, laid on the fixes {rms[1]:.2f} m, NIS {np.mean(nis):.2f}")
    places = by_wheels(log)
    _, rotation, shift = laid_on(places, fixes)
    errors = [rotation @ p + shift - fixes[t][:2] for t, p in places.items()]
    print(f"wheels alone, laid on the fixes: {math.sqrt(np.mean(np.sum(np.square(errors), axis=1))):.2f} m")


if __name__ == "__main__":
    main()
