"""Pages of the viewer in headless Chromium, for tests."""

import contextlib
import io
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

ROOT = Path(__file__).parent.parent
FLAGS = ["--headless=new", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"]
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
PATIENCE = 240.0  # [s] software rendering on a loaded machine

needs_chromium = pytest.mark.skipif(CHROMIUM is None, reason="Debian's chromium is not installed")


def wait_for(condition, what, patience=PATIENCE):
    """The first value of `condition()` that counts as true."""
    end = time.monotonic() + patience
    while True:
        value = condition()
        if value:
            return value
        assert time.monotonic() < end, f"{what} did not happen within {patience:g} s"
        time.sleep(0.05)


@contextlib.contextmanager
def served(*words, program="gazebo", viewer=True):
    """A server with --view: (process, address)."""
    command = [sys.executable, "-m", f"libgz.apps.{program}" if program != "libgz" else "libgz", *map(str, words)]
    if viewer:
        command += ["--view", "--view-port", "18080"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=ROOT) as process:
        try:
            yield process, address_of(process) if viewer else None
        finally:
            process.terminate()
            process.wait(PATIENCE)  # one that is killed would leave its directory


def address_of(process):
    lines = []
    for line in process.stdout:
        lines.append(line)
        found = re.match(r"open (http://\S+)", line)
        if found:
            return found[1]
    raise AssertionError("no address was printed: " + "".join(lines))


@contextlib.contextmanager
def browser():
    """Headless Chromium."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        try:
            yield chromium
        finally:
            chromium.close()


def opened(chromium, url, size=(1000, 640)):
    """A page that shows a world; its errors are in `page.errors`, requests to elsewhere in `page.fetched`."""
    page = chromium.new_page(viewport={"width": size[0], "height": size[1]})
    page.errors, page.fetched = [], []
    page.on("pageerror", lambda error: page.errors.append(str(error)))
    page.on("console", lambda line: page.errors.append(line.text) if is_error(line) else None)
    page.on("request", lambda request: page.fetched.append(request.url))
    page.set_default_timeout(1000.0 * PATIENCE)
    page.goto(url)
    until(page, "window.libgz?.workplace.stage.ready")
    until(page, "performance.getEntriesByName('first-contentful-paint').length")  # what is pressed before it is lost
    return page


def is_error(line):
    """Whether a line of a browser's console is an error of the page; that a server has ended is none."""
    return line.type == "error" and "WebSocket connection to" not in line.text


def until(page, condition, argument=None):
    """Wait for a condition in the page, which its policy does not let Playwright do itself."""
    test = condition if "=>" in condition.split("(")[0] else f"Boolean({condition})"
    return wait_for(lambda: page.evaluate(test, argument), condition)


def status(page):
    """What the page says of the run: sim time [s], and its state with what a banner says."""
    sim_time = page.evaluate("libgz.store.connected && libgz.store.state ? libgz.store.state.simTime : null")
    banner = page.locator("#banner")
    return sim_time, page.inner_text("#run-state") + (f" {banner.inner_text()}" if banner.is_visible() else "")


def picture(page):
    """The image of the page's view, shape (height, width, 3), and 0 where other things are before it."""
    image = page.locator("#stage canvas").first.screenshot(timeout=1000.0 * PATIENCE)
    return np.asarray(Image.open(io.BytesIO(image)).convert("RGB")).astype(int)


def reddish(image):
    """The pixels of a Pioneer's red body: their rows and columns."""
    red, green, blue = (image[..., i] for i in range(3))
    return np.argwhere((red > 90) & (green < 60) & (blue < 60) & (red > 2.5 * green))


def row(page, name):
    """The row of a model in the page's tree."""
    return page.get_by_role("treeitem", name=name)


def button(page, name):
    """A button of the page."""
    return page.get_by_role("button", name=name, exact=True)
