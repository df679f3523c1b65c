"""Runs every Python program of the documents that the tutorials' test does not run; prints each that fails.

python snippets.py FOLDER

A comment before a block of code says what the program needs:

- `<!-- run with: COMMAND -->`: a running server. The program may be endless: it is ended after some seconds;
- `<!-- run in: WORLD -->`: a loaded world of Gazebo classic, as a plugin has it.

A program that defines tests is run by pytest. Beside each program there are `examples`, and `robot.world`.
"""

import os
import re
import shlex
import signal
import subprocess
import sys
import time
import traceback
from itertools import groupby
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
BLOCK = re.compile(r"(?:<!-- run (with|in): (.*?) -->\n)?^```python\n(.*?)^```", re.S | re.M)
ENDLESS, LONGEST = 3.0, 60.0  # [s]
ROBOT = """<sdf version="1.6"><world name="default">
<include><uri>model://ground_plane</uri></include>
<model name="robot"><pose>0 0 0.5 0 0 0</pose>
<link name="chassis"><inertial><mass>5</mass></inertial>
  <collision name="collision"><geometry><box><size>0.5 0.5 0.2</size></box></geometry></collision>
  <visual name="visual"><geometry><box><size>0.5 0.5 0.2</size></box></geometry></visual>
  <sensor name="laser" type="ray"><always_on>1</always_on><ray><scan><horizontal><samples>5</samples>
  <min_angle>-1</min_angle><max_angle>1</max_angle></horizontal></scan><range><min>0.1</min><max>5</max></range></ray></sensor>
</link>
<link name="wheel"><pose>0 0.3 0 1.5708 0 0</pose>
  <collision name="collision">
    <geometry><cylinder><radius>0.1</radius><length>0.05</length></cylinder></geometry>
  </collision>
</link>
<joint name="wheel" type="revolute"><parent>chassis</parent><child>wheel</child><axis><xyz>0 0 1</xyz></axis></joint>
</model></world></sdf>
"""


def programs():
    """(page:line, server or world that it needs, text) of each program, by what it needs."""
    found = []
    for page in PAGES:
        text = page.read_text()
        for block in BLOCK.finditer(text):
            line = text.count("\n", 0, block.start(3)) + 1
            found.append((f"{page.relative_to(ROOT)}:{line}", (block[1] or "", block[2] or ""), block[3]))
    return sorted(found, key=lambda program: program[1])


def prepare(folder):
    """A folder with what programs may name."""
    folder.mkdir(parents=True)
    (folder / "examples").symlink_to(ROOT / "examples")
    (folder / "robot.world").write_text(ROBOT)
    (folder / "my_program.py").write_text("")
    return folder


def execute(place, code, world, folder):
    """Run a program in a child process of its own; what is wrong, or an empty text."""
    log = folder / "stderr"
    child = os.fork()
    if child == 0:
        try:
            os.chdir(folder)
            out = os.open("stderr", os.O_CREAT | os.O_WRONLY)
            os.dup2(out, 2)
            os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
            names = {"__name__": "__main__"}
            if world:
                import libgz

                names["opened"] = libgz.World.from_file(world)
            exec(compile(code, place, "exec"), names)
            if "opened" in names:
                names["opened"].close()
            sys.stdout.flush()
        except BaseException:  # noqa: BLE001 - whatever a program raises
            traceback.print_exc()
            sys.stderr.flush()
            os._exit(1)
        os._exit(0)
    return await_end(child, log)


def await_end(child, log, endless=False):
    """Wait for a child; what is wrong, or an empty text."""
    end = time.monotonic() + (ENDLESS if endless else LONGEST)
    while (found := os.waitpid(child, os.WNOHANG))[0] == 0 and time.monotonic() < end:
        time.sleep(0.02)
    if found[0] == 0:
        os.kill(child, signal.SIGTERM)
        end = time.monotonic() + LONGEST
        while os.waitpid(child, os.WNOHANG)[0] == 0:  # one that is killed at once would leave its directory
            if time.monotonic() > end:
                os.kill(child, signal.SIGKILL)
            time.sleep(0.02)
    ended = found[0] != 0 or endless
    code = os.waitstatus_to_exitcode(found[1]) if found[0] else 0
    text = log.read_text() if log.exists() else ""
    if not ended:
        return f"did not end in {LONGEST} s"
    return "" if code == 0 and "Traceback" not in text else f"exit code {code}: {text}"


def served(place, code, folder):
    """Run a program beside a server."""
    (folder / "program.py").write_text(code)
    with (folder / "stderr").open("w") as log:
        child = subprocess.Popen([sys.executable, "program.py"], cwd=folder, stdout=subprocess.DEVNULL, stderr=log)
    return await_end(child.pid, folder / "stderr", endless=True)


def main(folder):
    """Run all programs; returns how many there are, and prints what is wrong."""
    import libgz.classic.sensors
    import libgz.front  # noqa: F401 - children need not import it again

    count = 0
    for (how, what), group in groupby(programs(), key=lambda program: program[1]):
        server = None
        if how == "with":
            command = [sys.executable, "-m", f"libgz.apps.{what.split()[0]}", *shlex.split(what)[1:]]
            server = subprocess.Popen(
                command, cwd=prepare(folder / "server"), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
            )
            time.sleep(3.0)
        for place, _, code in group:
            count += 1
            own = prepare(folder / str(count))
            if "\ndef test_" in code:
                (own / "test_program.py").write_text(code)
                command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_program.py"]
                done = subprocess.run(command, cwd=own, capture_output=True, text=True)
                wrong = "" if done.returncode == 0 else done.stdout
            elif server is not None:
                wrong = served(place, code, own)
            else:
                wrong = execute(place, code, what, own)
            if wrong:
                print(f"{place}: {wrong}", file=sys.stderr)
        if server is not None:
            server.terminate()
            wrong = server.communicate(timeout=30)[1].decode()
            if "rror" in wrong:
                print(f"{what}: {wrong}", file=sys.stderr)
            (folder / "server").rename(folder / f"server{count}")
    print(count)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
