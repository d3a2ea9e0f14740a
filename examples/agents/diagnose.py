"""An agent's part, written down: it finds why the robot of a recording stood, and proves a remedy in the simulator.

    pip install mcp
    python diagnose.py JDE RECORDING

JDE is the executable, RECORDING a file beside this one. The server has no `--operate`: no robot moves.
"""

import asyncio
import os
import pathlib
import sys

from mcp import Client, StdioServerParameters

FOLDER = pathlib.Path(__file__).resolve().parent
REMEDY = "remedy.toml"


class Refused(Exception):
    """A call that was refused, or failed."""


async def ask(client, tool, **arguments):
    """Calls a tool, and returns its data."""
    result = await client.call_tool(tool, arguments)
    if result.is_error:
        raise Refused(f"{tool}: {result.content[0].text}")
    return result.structured_content["data"]


def experiment(values):
    """An experiment that drives the night again with each value of `stop.half_width`, ten times with other noise."""
    return f"""name = "remedy"
application = "night.toml"
for = "120s"
[axes]
seeds = "1..10"
set."stop.half_width" = {values!r}
[must."no collision"]
never = "collisions > 0"
[must."the robot keeps 10 cm from everything"]
always = "clearance > 0.1"
[measure]
time = "time"
nearest = "clearance"
"""


async def main(jde, recording):
    server = StdioServerParameters(
        command=jde, args=["mcp", "--folder", str(FOLDER)], env=dict(os.environ)
    )
    async with Client(server) as client:
        tools = [tool.name for tool in (await client.list_tools()).tools]
        print("tools:", ", ".join(tools))

        info = await ask(client, "recording", recording=recording)
        print(f"{info['application']}: {info['seconds']:.0f} s")
        report = await ask(client, "report", recording=recording)
        print("the last takeovers:", *report["takeovers"][-3:], sep="\n  ")

        why = await ask(
            client, "why", recording=recording, question=f"at {int(info['seconds'])}s in round/base"
        )
        decision = why["selection"]["decision"]
        ready = [candidate["name"] for candidate in decision["candidates"] if candidate["ready"]]
        print(f"since {decision['time_s']:.1f} s {decision['choice']} acts: {decision['reason']}")
        print("ready then:", ", ".join(ready))
        if decision["choice"] != "stop":
            raise Refused("it is not `stop` that holds the robot")

        checked = await ask(client, "check", file="night.toml")
        settings = [line for line in checked["application"].splitlines() if "half_width" in line]
        print("what the file states:", *settings, sep="\n  ")

        # The gate is 1.4 m wide, and `stop` watches 1.5 m. The robot is 0.5 m wide.
        (FOLDER / REMEDY).write_text(experiment(["0.75 m", "0.3 m"]))
        proof = await ask(client, "experiment", file=REMEDY)
        print(proof["comparison"])
        passed = sum(
            drive["outcome"] == "passed" and "0.3" in str(drive["stop.half_width"])
            for drive in proof["listed"]
        )
        print(f"with `half_width = 0.3` in [schemas.stop], {passed} of 10 drives passed")


try:
    asyncio.run(main(*sys.argv[1:]))
except* Refused as refused:
    while isinstance(refused, ExceptionGroup):
        refused = refused.exceptions[0]
    sys.exit(str(refused))
