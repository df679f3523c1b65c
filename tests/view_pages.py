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
PANEL = 290  # [px] width of the page's panel

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
            try:
                process.wait(10.0)
            except subprocess.TimeoutExpired:
                process.kill()


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


def opened(chromium, url, size=(800, 600)):
    """A page that shows a world; its errors are in `page.errors`, requests to elsewhere in `page.fetched`."""
    page = chromium.new_page(viewport={"width": size[0], "height": size[1]})
    page.errors, page.fetched = [], []
    page.on("pageerror", lambda error: page.errors.append(str(error)))
    page.on("request", lambda request: page.fetched.append(request.url))
    page.set_default_timeout(1000.0 * PATIENCE)
    page.goto(url)
    page.wait_for_selector("#libgz-status b")
    return page


def status(page):
    """What the page says of the run: sim time [s], and the whole text."""
    text = " ".join(page.inner_text("#libgz-status").split())
    found = re.search(r"sim time ([0-9.]+)", text)
    return (float(found[1]) if found else None), text


def picture(page):
    """The page's image, shape (height, width, 3)."""
    return np.asarray(Image.open(io.BytesIO(page.screenshot(timeout=1000.0 * PATIENCE))).convert("RGB")).astype(int)


def reddish(image):
    """The pixels of a Pioneer's red body, left of the panel: their rows and columns."""
    red, green, blue = (image[:, :-PANEL, i] for i in range(3))
    return np.argwhere((red > 90) & (green < 45) & (blue < 45))
