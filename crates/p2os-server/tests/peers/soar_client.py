"""Drives a robot with the client of Soar (Snakes on a Robot), and checks that the robot does what it is told.

The argument is the serial line at which the robot is. Soar knows nothing of who serves it.
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
        check_senses(robot)
        robot.send_command(ENABLE, 1)
        before = where(robot)
        robot.send_command(VEL, 200)
        wait_until(lambda: where(robot)[0] - before[0] > 300, "it drives ahead")
        robot.send_command(VEL, 0)
        robot.send_command(RVEL, 40)
        wait_until(lambda: turned(before, where(robot)) > 30, "it turns to the left")
        robot.send_command(STOP)
        wait_until(lambda: robot.standard["L VEL"] == robot.standard["R VEL"] == 0, "it stops")
        print("driven by Soar: %s to %s" % (before, where(robot)))
    finally:
        robot.disconnect()


def check_senses(robot):
    assert 10 < robot.standard["BATTERY"] / 10 < 14, robot.standard["BATTERY"]
    assert any(0 < distance < 5000 for distance in robot.sonars[:16]), robot.sonars


def where(robot):
    """Millimetres and degrees, by the robot's wheels."""
    sip = robot.standard
    return signed(sip["XPOS"]) * MILLIMETRES, signed(sip["YPOS"]) * MILLIMETRES, sip["THPOS"] * DEGREES


def signed(count):
    return count - 65536 if count > 32767 else count


def turned(before, after):
    return (after[2] - before[2] + 180) % 360 - 180


def wait_until(holds, what):
    """The server's own limit of time ends a wait that is in vain."""
    while not holds():
        time.sleep(0.05)
    print("ok: " + what)


main(sys.argv[1])
