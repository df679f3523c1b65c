"""The live viewer: what it costs the server and itself, with robots that drive and one client connected.

CPU times of the server per step are compared: with the viewer, with a stopped viewer, and with a stopped viewer beside
a process that has nothing to do with the server and uses as much of a core. What that one costs is the machine's: cores
that share caches and memory. Rounds of all three alternate.

python benchmarks/view.py [ROBOTS] [HZ] [ROUNDS]    (default: 30 Pioneer2ATs with lasers at 30 Hz, their ranges shown,
                                            then 400 at 10 Hz; 10 rounds of 5 s)
python benchmarks/view.py attack            the same with 30 robots while others attack the viewer's port
python benchmarks/view.py page              how long a page takes in headless Chromium until it shows the robot,
                                            a live one and a replay (Debian's chromium; pip install playwright)
python benchmarks/view.py many [MODELS]     the same for a world of 500 SDF models, until its first complete frame
"""

import asyncio
import io
import json
import os
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import aiohttp
import numpy as np
import page_attacks
from laser_robots import ratio_text
from page_attacks import ATTACKS
from PIL import Image

import libgz
from libgz.base.files import installed_worlds
from libgz.recording.capture import Capture
from libgz.transport.server import free_server_id

ROUNDS, SPAN, PAUSE = 10, 1.5, 0.2  # [s]
LOADS = 5  # of a page
FLAGS = ["--headless=new", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"]
SIZE = {"width": 800, "height": 600}
LONGEST = 120.0  # [s]
BUSY = """
import sys, time
import numpy as np
share, rate = float(sys.argv[1]), float(sys.argv[2])
data, text = np.zeros(50_000), "x" * 1000
while True:
    end = time.thread_time() + share / rate
    while time.thread_time() < end:
        data += 1.0
        [text + str(i) for i in range(200)]
    time.sleep((1.0 - share) / rate)
"""
HEAD = (
    '<?xml version="1.0"?><gz:world xmlns:gz="http://playerstage.sourceforge.net/gazebo/xmlschema/#gz" '
    'xmlns:model="http://playerstage.sourceforge.net/gazebo/xmlschema/#model" '
    'xmlns:param="http://playerstage.sourceforge.net/gazebo/xmlschema/#param">'
    "<model:GroundPlane><id>ground</id></model:GroundPlane>"
    "<model:LightSource><id>sun</id><xyz>0 0 20</xyz></model:LightSource>"
)


def world(robots, lasers):
    """A worldfile with robots in rows."""
    parts = [HEAD]
    for i in range(robots):
        laser = f"<model:SickLMS200><id>laser{i}</id><xyz>0.15 0 0.2</xyz></model:SickLMS200>" if lasers else ""
        place = f"<xyz>{2 * (i % 20)} {2 * (i // 20)} 0.2</xyz>"
        parts.append(f"<model:Pioneer2AT><id>robot{i}</id>{place}{laser}</model:Pioneer2AT>")
    return "".join([*parts, "</gz:world>"])


def cpu(process):
    """CPU time of the threads of a process [s], to the nanosecond."""
    return 1e-9 * sum(int(one.read_text().split()[0]) for one in Path(f"/proc/{process}/task").glob("*/schedstat"))


class Page:
    """A client that receives as a browser does; it counts the states."""

    def __init__(self, url, wants=()):
        self.url, self.wants, self.frames, self.bytes, self.ended = url, wants, 0, 0, False

    async def receive(self):
        async with aiohttp.ClientSession() as session:
            async with session.get(self.url) as answer:
                address = f"{answer.url}socket"
            async with session.ws_connect(address, max_msg_size=0) as socket:
                for channel, names in self.wants:
                    await socket.send_str(json.dumps({"want": channel, "names": names}))
                while not self.ended:
                    message = await socket.receive(LONGEST)
                    self.bytes += len(message.data)
                    self.frames += message.type == aiohttp.WSMsgType.BINARY and message.data[0] == 1


def measure(server, viewer, page, observer):
    """(CPU time of the server per step [us], share of a core of the viewer, frames per second)."""
    begin, steps, busy, seen, frames = time.monotonic(), observer.state().steps, cpu(server), cpu(viewer), page.frames
    time.sleep(SPAN)
    span = time.monotonic() - begin
    done = observer.state().steps - steps
    return 1e6 * (cpu(server) - busy) / done, (cpu(viewer) - seen) / span, (page.frames - frames) / span


def run(robots, rate, lasers, rounds=ROUNDS):
    """Measure with a page that is open and, in turn, with a stopped viewer."""
    server_id = free_server_id(400)
    with tempfile.NamedTemporaryFile("w", suffix=".world") as file:
        file.write(world(robots, lasers))
        file.flush()
        command = [sys.executable, "-m", "libgz.apps.gazebo", "-d", "0", "-s", str(server_id), file.name]
        server = subprocess.Popen(command)
        observer = libgz.Observer(server_id, timeout=60.0)
        with libgz.Client(server_id, client_id=-1, timeout=60.0) as client:
            for i in range(robots):
                client.position(f"robot{i}").command(vx=0.2, vyaw=0.2)
        words = [
            sys.executable,
            "-m",
            "libgz",
            "view",
            "-s",
            str(server_id),
            "--view-port",
            "18900",
            "--rate",
            str(rate),
        ]
        viewer = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
        lasers = [("ranges", [f"laser.laser{i}" for i in range(robots)])] if lasers else []
        page = Page(viewer.stdout.readline().split()[-1], lasers)
        try:
            asyncio.run(_measured(server, viewer, page, observer, robots, rate, rounds))
        finally:
            for process in (viewer, server):
                process.terminate()
                process.wait(20.0)
            viewer.stdout.close()


async def _measured(server, viewer, page, observer, robots, rate, rounds):
    receiving = asyncio.create_task(page.receive())
    await asyncio.sleep(4.0)
    pairs, neutral, shares, rates = [], [], [], []
    for i in range(rounds):
        seen, share, frames = await asyncio.to_thread(measure, server.pid, viewer.pid, page, observer)
        shares.append(share)
        rates.append(frames)
        costs = {}
        os.kill(viewer.pid, signal.SIGSTOP)  # the same server without a viewer at work
        for busy in (False, True) if i % 2 else (True, False):
            other = subprocess.Popen([sys.executable, "-c", BUSY, str(share), str(rate)]) if busy else None
            await asyncio.sleep(PAUSE)
            costs[busy], _, _ = await asyncio.to_thread(measure, server.pid, viewer.pid, page, observer)
            if other is not None:
                other.kill()
                other.wait()
        os.kill(viewer.pid, signal.SIGCONT)
        await asyncio.sleep(PAUSE)
        if receiving.done():
            receiving.result()  # raises what ended it
        pairs.append((costs[False], seen))
        neutral.append((costs[False], costs[True]))
    page.ended = True
    await asyncio.gather(receiving, return_exceptions=True)
    alone = statistics.median(cost for cost, _ in pairs)
    print(
        f"{robots} robots, {rate} Hz wanted: {statistics.median(rates):.1f} frames/s, viewer "
        f"{100 * statistics.median(shares):.0f} % of a core, step of the server {alone:.0f} us"
    )
    print(f"  with the viewer:                 {ratio_text(pairs)}")
    print(f"  with a process that is as busy:  {ratio_text(neutral)}", flush=True)


# Pages ---------------------------------------------------------------------------------------------------------------


def shows_robot(page):
    """Whether the middle of a page shows a Pioneer's red body."""
    from playwright.sync_api import Error

    try:
        image = Image.open(io.BytesIO(page.screenshot(timeout=1000.0 * LONGEST))).convert("RGB")
    except Error:  # a page that has not rendered anything yet
        return False
    red, green, blue = np.moveaxis(np.asarray(image)[100:500, 200:600].astype(int), -1, 0)
    return np.count_nonzero((red > 90) & (green < 60) & (blue < 60)) > 15


def load_times(chromium, url):
    """From the request of a page to the image of the robot [s], of some loads; the first one in a new browser."""
    found = []
    for _ in range(LOADS):
        page = chromium.new_page(viewport=SIZE)
        page.set_default_timeout(1000.0 * LONGEST)
        begin = time.monotonic()
        page.goto(url, wait_until="commit")
        while not shows_robot(page) and time.monotonic() - begin < LONGEST:
            pass
        found.append(time.monotonic() - begin)
        page.close()
    return found


def pages():
    """Measure how long pages take to show worlds/pioneer2at.world."""
    from playwright.sync_api import sync_playwright

    file, server_id = installed_worlds() / "pioneer2at.world", free_server_id(400)
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        log, replay = Path(folder, "run.mcap"), Path(folder, "replay.html")
        with libgz.World.from_file(file) as recorded, Capture(recorded, log) as capture:
            for _ in range(200):
                recorded.step()
                capture.take()
        subprocess.run([sys.executable, "-m", "libgz", "play", str(log), "--html", str(replay)], check=True)
        words = ["-d", "0", "-s", str(server_id), "--view", "--view-port", "18900", str(file)]
        server = subprocess.Popen(
            [sys.executable, "-m", "libgz.apps.gazebo", *words], stdout=subprocess.PIPE, text=True
        )
        try:
            live = next(line.split()[1] for line in server.stdout if line.startswith("open "))
            for what, url in (("live page", live), ("replay", replay.as_uri())):
                chromium = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
                first, *others = load_times(chromium, url)
                chromium.close()
                print(f"{what}: the robot after {first:.1f} s in a new browser, then {statistics.median(others):.1f} s")
        finally:
            server.terminate()
            server.wait(20.0)


def many(models):
    """Measure how long a page takes to show a whole SDF world of many models, in one browser."""
    from playwright.sync_api import sync_playwright

    shapes = "<box><size>0.5 0.5 0.5</size></box>", "<sphere><radius>0.3</radius></sphere>"
    shapes += ("<cylinder><radius>0.3</radius><length>0.6</length></cylinder>",)
    text = ""
    for number in range(models):
        shape = f"<geometry>{shapes[number % len(shapes)]}</geometry>"
        look = f"<material><diffuse>{number % 7 / 7} {number % 5 / 5} 0.5 1</diffuse></material>"
        parts = f"<collision name='c'>{shape}</collision><visual name='v'>{shape}{look}</visual>"
        place = f"<pose>{number % 25} {number // 25} 0.3 0 0 0</pose>"
        text += f"<model name='m{number}'>{place}<link name='l'>{parts}</link></model>"
    includes = "".join(f"<include><uri>model://{name}</uri></include>" for name in ("sun", "ground_plane"))
    with tempfile.NamedTemporaryFile("w", suffix=".world") as file, sync_playwright() as playwright:
        file.write(f"<sdf version='1.6'><world name='many'>{includes}{text}</world></sdf>")
        file.flush()
        words = ["--view", "--view-port", "18900", "-u", file.name]
        server = subprocess.Popen(
            [sys.executable, "-m", "libgz.apps.gazebo", *words], stdout=subprocess.PIPE, text=True
        )
        try:
            url = next(line.split()[1] for line in server.stdout if line.startswith("open "))
            chromium = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
            context, found = chromium.new_context(viewport={"width": 1280, "height": 800}), []
            for _ in range(LOADS):
                page = context.new_page()
                begin = time.monotonic()
                page.goto(url, wait_until="commit")
                while not page.evaluate("Boolean(window.libgz?.workplace.stage.ready)"):
                    time.sleep(0.02)
                found.append(time.monotonic() - begin)
                page.close()
            chromium.close()
            first, *others = found
            print(
                f"{models} models: whole after {first:.1f} s in a new browser, then {statistics.median(others):.1f} s"
            )
        finally:
            server.terminate()
            server.wait(20.0)


# Attacks -------------------------------------------------------------------------------------------------------------


def attacks():
    """Measure what a page gets, and what the viewer takes, under each attack."""
    server_id = free_server_id(400)
    with tempfile.NamedTemporaryFile("w", suffix=".world") as file:
        file.write(world(30, True))
        file.flush()
        server = subprocess.Popen(
            [sys.executable, "-m", "libgz.apps.gazebo", "-d", "0", "-s", str(server_id), file.name]
        )
        words = [sys.executable, "-m", "libgz", "view", "-s", str(server_id), "--timeout", "60", "--view-port", "18900"]
        viewer = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
        page = Page(viewer.stdout.readline().split()[-1])
        try:
            with libgz.Observer(server_id) as observer:
                asyncio.run(_attacked(server, viewer, page, observer))
        finally:
            for process in (viewer, server):
                process.terminate()
                process.wait(20.0)
            viewer.stdout.close()


async def _attacked(server, viewer, page, observer):
    receiving = asyncio.create_task(page.receive())
    await asyncio.sleep(4.0)
    port = page.url.split("/")[2].rpartition(":")[2]
    for kind, (what, _) in {"": ("no attack", []), **ATTACKS}.items():
        attacker = subprocess.Popen([sys.executable, page_attacks.__file__, port, kind]) if kind else None
        await asyncio.sleep(1.0)
        step, share, frames = await asyncio.to_thread(measure, server.pid, viewer.pid, page, observer)
        if attacker is not None:
            attacker.kill()
            attacker.wait()
        held = int(Path(f"/proc/{viewer.pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") >> 20
        print(f"{frames:5.1f} frames/s, viewer {100 * share:3.0f} % of a core, {held} MiB, step {step:.0f} us: {what}")
        sys.stdout.flush()
    page.ended = True
    await asyncio.gather(receiving, return_exceptions=True)


if __name__ == "__main__":
    if sys.argv[1:] == ["attack"]:
        attacks()
        raise SystemExit
    if sys.argv[1:2] == ["many"]:
        many(int(sys.argv[2]) if len(sys.argv) > 2 else 500)
        raise SystemExit
    if sys.argv[1:] == ["page"]:
        pages()
        raise SystemExit
    given = [int(word) for word in sys.argv[1:]]
    if given:
        robots, rate, rounds = [*given, *(30, 30, ROUNDS)[len(given) :]]
        run(robots, rate, robots <= 50, rounds)
    else:
        run(30, 30, True)
        run(400, 10, False)
