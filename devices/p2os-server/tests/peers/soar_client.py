"""Drives a robot with the client of Soar (Snakes on a Robot), and checks the robot's motions.

The argument is the serial line of the robot. Soar does not know which program serves it.
"""

import sys
import time

from soar.robot.arcos import ARCOSClient, ENABLE, RVEL, STOP, VEL

# Units of position and angle of a Pioneer P3-DX.
MILLIMETRES = 0.485
DEGREES = 360 / 4096


def main(port):
    robot = ARCOSClient(timeout=1.0)
    robot.connect(forced_ports=[port])
    try:
        check_sensors(robot)
        robot.send_command(ENABLE, 1)
        before = position(robot)
        robot.send_command(VEL, 200)
        wait_until(lambda: position(robot)[0] - before[0] > 300, "the robot drives ahead")
        robot.send_command(VEL, 0)
        robot.send_command(RVEL, 40)
        wait_until(lambda: turned(before, position(robot)) > 30, "the robot turns to the left")
        robot.send_command(STOP)
        wait_until(lambda: robot.standard["L VEL"] == robot.standard["R VEL"] == 0, "the robot stops")
        print("driven by Soar: %s to %s" % (before, position(robot)))
    finally:
        robot.disconnect()


def check_sensors(robot):
    assert 10 < robot.standard["BATTERY"] / 10 < 14, robot.standard["BATTERY"]
    assert any(0 < distance < 5000 for distance in robot.sonars[:16]), robot.sonars


def position(robot):
    """Millimetres and degrees, by the robot's wheels."""
    sip = robot.standard
    return signed(sip["XPOS"]) * MILLIMETRES, signed(sip["YPOS"]) * MILLIMETRES, sip["THPOS"] * DEGREES


def signed(count):
    return count - 65536 if count > 32767 else count


def turned(before, after):
    return (after[2] - before[2] + 180) % 360 - 180


def wait_until(condition, expected):
    """Waits without a limit: the server's own time limit ends a wait that fails."""
    while not condition():
        time.sleep(0.05)
    print("ok: " + expected)


main(sys.argv[1])
