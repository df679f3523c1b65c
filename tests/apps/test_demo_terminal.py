"""`libgz demo` in a terminal: it opens its page, waits for it, and drives until Ctrl-C."""

import asyncio
import os
import pty
import re
import signal
import subprocess
import sys
import time
import urllib.request

import pytest

aiohttp = pytest.importorskip("aiohttp")


def read_until(terminal, said, word):
    end = time.monotonic() + 120.0
    while word not in said:
        assert time.monotonic() < end, said
        said += os.read(terminal, 4096)
    return said


async def open_page(address):
    """Connect as a page does."""
    async with aiohttp.ClientSession() as session, session.ws_connect(address) as socket:
        await socket.receive(timeout=30.0)


@pytest.mark.parametrize("seconds", [[], ["--seconds", "2"]])
def test_in_a_terminal_the_demo_opens_its_page_waits_for_it_and_serves_until_ctrl_c(seconds, tmp_path):
    seen = tmp_path / "seen"
    browser = tmp_path / "browser"
    browser.write_text(f'#!/bin/sh\necho "$1" > {seen}\n')
    browser.chmod(0o755)
    ours, its = pty.openpty()
    words = [sys.executable, "-m", "libgz", "demo", "--view-port", "18680", *seconds]
    environment = {**os.environ, "DISPLAY": ":99", "BROWSER": str(browser)}
    with subprocess.Popen(words, stdin=its, stdout=its, stderr=its, start_new_session=True, env=environment) as demo:
        os.close(its)
        said = read_until(ours, b"", b"waits for the page")
        url = re.search(r"open (http://127\.0\.0\.1:18\d+/)\?token=(\S+)", said.decode())
        end = time.monotonic() + 60.0
        while not (seen.exists() and seen.read_text()):
            assert time.monotonic() < end
            time.sleep(0.01)
        address = seen.read_text().strip()
        assert url[2] not in address  # every user sees a browser's command
        with urllib.request.urlopen(address) as page:
            assert page.url == f"{url[1]}{url[2]}/"
        asyncio.run(open_page(f"{url[1].replace('http', 'ws', 1)}{url[2]}/socket"))
        said = read_until(ours, said, b"until Ctrl-C")
        assert sum(line.strip()[:1].isdigit() for line in said.decode().splitlines()) >= 8  # the table
        assert (b"it drives on" in said) == (not seconds)
        assert demo.poll() is None
        os.killpg(demo.pid, signal.SIGINT)
        assert demo.wait(30.0) == 0
    os.close(ours)
