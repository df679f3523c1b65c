"""The viewer's port: who gets the page, who may control, what the page may load, and what a page may send."""

import asyncio
import contextlib
import dataclasses
import gzip
import io
import json
import logging
import re
import select
import socket
import struct
import subprocess
import sys
import threading
import time
import urllib.error
import urllib.parse
import urllib.request

import aiohttp
import numpy as np
import pytest
from PIL import Image
from view_sockets import Socket, running

from libgz.apps.view import open_page
from libgz.base.errors import GazeboError, NotFoundError
from libgz.transport.observer import ObservedState
from libgz.view import pages, portraits
from libgz.view.assets import Asset
from libgz.view.protocol import read_message
from libgz.view.viewer import Viewer

TEXTS = {
    "pioneer2at/robot1": "<model:Pioneer2AT><id>robot1</id></model:Pioneer2AT>",
    "model://box": "<model name='box'><plugin name='p' filename='libnone.so'/><link name='l'><visual name='v'>"
    "<geometry><box><size>1 1 1</size></box></geometry></visual></link></model>",
    "TruthWidget": "<model:TruthWidget><id>truth1</id></model:TruthWidget>",
}


class Nothing:
    """A source without content."""

    alive = True
    scene = json.loads('{"revision": 0, "entities": [], "others": [], "world": "<b>", "view": null, "sky": null}')

    def state(self):
        return ObservedState(1, 0, 0, False, 0.0, 0.0, 0.0, np.zeros((0, 16)), np.zeros((0, 4)))

    def reconnect(self, timeout=0.0):
        pass


class Counting:
    """Controls that count what is asked."""

    abilities = frozenset({"pause", "publish", "insert", "catalogue", "write", "describe", "move", "hold", "portrait"})

    def __init__(self):
        self.asked = []

    def ask(self, verb, argument="-", **content):
        self.asked.append((verb, argument, content))
        if verb == "portrait":
            return {"text": TEXTS.get(content["model"], "<model:Nothing/>")}
        return ["box"] if verb == "catalogue" else None

    def interface(self, kind, id):
        raise NotFoundError(f"there is no {kind} {id}")

    def reconnect(self):
        pass


@pytest.fixture
def controls():
    return Counting()


@pytest.fixture
def viewer(controls):
    with running(Nothing(), controls) as found:
        yield found


def get(viewer, path="/", **headers):
    """(status, headers, body) of the response to exactly this path."""
    port = int(re.search(r":(\d+)/", viewer.watch_url)[1])
    lines = [f"GET {path} HTTP/1.1", *(f"{name.replace('_', '-')}: {text}" for name, text in headers.items())]
    if "Host" not in headers:
        lines.append(f"Host: 127.0.0.1:{port}")
    with socket.create_connection(("127.0.0.1", port), 60.0) as connection:
        connection.sendall("\r\n".join([*lines, "Connection: close", "", ""]).encode())
        raw = b"".join(iter(lambda: connection.recv(65536), b""))
    head, _, body = raw.partition(b"\r\n\r\n")
    first, *rest = head.decode().split("\r\n")
    return int(first.split()[1]), dict(line.split(": ", 1) for line in rest), body


def token_of(viewer):
    return viewer.url.partition("token=")[2]


def test_the_token_is_in_the_address_and_nowhere_else(viewer):
    token = token_of(viewer)
    assert get(viewer, f"/?token={token}")[1]["Location"] == f"/{token}/"
    assert get(viewer, "/?token=wrong")[1]["Location"] == "/"
    assert get(viewer, f"/?token={token}&quality=best")[1]["Location"] == f"/{token}/?quality=best"
    for path in ("/", f"/{token}/"):
        status, headers, body = get(viewer, path)
        assert status == 200
        assert token.encode() not in body
        assert headers["Cache-Control"] == "no-store"
        assert headers["Referrer-Policy"] == "no-referrer"


def test_the_address_that_is_opened_in_a_browser_serves_the_first_only(viewer, monkeypatch):
    """Every user of the machine sees the browser's command."""
    opened = []
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr("webbrowser.open", lambda url: opened.append(url) or True)
    assert open_page(viewer.url_for_once())
    [address] = opened
    assert token_of(viewer) not in address
    path = "/" + address.removeprefix(viewer.watch_url)
    assert get(viewer, path)[1]["Location"] == f"/{token_of(viewer)}/"
    assert get(viewer, path)[1]["Location"] == "/"


def test_portraits_of_the_catalogue(viewer):
    own = f"/{token_of(viewer)}/portraits/"
    for name in ("pioneer2at%2Frobot1", "model%3A%2F%2Fbox"):
        status, headers, body = get(viewer, own + name)
        assert (status, headers["Content-Type"]) == (200, "image/jpeg")
        image = np.asarray(Image.open(io.BytesIO(body)).convert("RGB"))
        assert image.shape == (192, 256, 3)
        assert image[60:130, 90:160].std() > 10.0  # something is in its middle
        assert get(viewer, f"/portraits/{name}")[0] == 404
    for name in ("TruthWidget", "unknown", ".."):  # nothing of them is seen
        assert get(viewer, own + name)[0] == 204


def test_a_process_of_portraits_that_dies_is_started_again(monkeypatch):
    command = [sys.executable, "-c", "input(); import os; os.abort()"]
    monkeypatch.setattr(portraits, "start_module", lambda _, **options: subprocess.Popen(command, **options))
    with portraits.Portraits(lambda name: name) as made:
        for _ in range(portraits.MOST_FAILURES):  # each time anew: it may have been the machine
            assert made.get("a") is None
        monkeypatch.setattr(portraits, "start_module", lambda *_, **__: pytest.fail("it was started once more"))
        assert made.get("b") is None


@pytest.mark.parametrize(
    "path",
    [
        "/wrong/",
        "/../../etc/passwd",
        "/index.html",
        "/etc/passwd",
        "/client/../viewer.py",
        "/assets/../viewer.py",
        "/assets/%2e%2e/viewer.py",
        "//etc/passwd",
        "/assets/" + "0" * 40 + ".bin",
    ],
)
def test_nothing_else_is_served(viewer, path):
    assert get(viewer, path)[0] == 404
    base = re.search(rb"/client/\w+/", get(viewer)[2])[0].decode()
    assert get(viewer, base + "app.js")[0] == 200
    assert get(viewer, base + "../../viewer.py")[0] == 404


def test_only_get_is_answered(viewer):
    request = urllib.request.Request(viewer.watch_url, method="POST", data=b"x")
    with pytest.raises(urllib.error.HTTPError, match="405"):
        urllib.request.urlopen(request, timeout=20.0)


def test_names_that_others_made_point_here_are_refused(viewer):
    assert get(viewer, Host="evil.example:8080")[0] == 403
    assert get(viewer, Host="localhost.evil.example:8080")[0] == 403
    assert get(viewer, Host="localhost:9000")[0] == 200  # a forwarded port
    assert get(viewer, Host="[::1]:80")[0] == 200
    for host in ("[::1", "127.0.0.1; script-src *", "127.0.0.1/x", "evil.example@127.0.0.1", "127.0.0.1:x", ""):
        assert get(viewer, Host=host)[0] == 403


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "http://127.0.0.1", "http://127.0.0.1:80801", "http://[::1", "null", ""]
)
def test_pages_of_other_addresses_cannot_connect(viewer, origin):
    with pytest.raises(aiohttp.WSServerHandshakeError, match="403"):
        Socket(viewer.url, Origin=origin)


def test_a_page_of_this_address_connects(viewer):
    with Socket(viewer.url, Origin=viewer.watch_url.rstrip("/")) as page:
        assert page.until("hello")["hello"]["title"] == "<b> - libgz"


def test_the_page_loads_nothing_from_elsewhere_and_runs_no_text(viewer):
    _, headers, body = get(viewer)
    policy = headers["Content-Security-Policy"]
    assert policy.startswith("default-src 'none'; script-src 'self' 'sha256-")
    assert "unsafe" not in policy
    assert "http" not in policy
    assert b"http" not in body
    assert len(re.findall(rb"<script", body)) == 2  # the import map and the module
    assert headers["X-Content-Type-Options"] == "nosniff"


def test_modules_are_kept_by_browsers_and_packed(viewer):
    path = re.search(rb'src="([^"]+app.js)"', get(viewer)[2])[1].decode()
    status, headers, body = get(viewer, path.replace("app.js", "store.js"), Accept_Encoding="gzip")
    assert (status, headers["Content-Encoding"]) == (200, "gzip")
    assert "immutable" in headers["Cache-Control"]
    assert body[:2] == b"\x1f\x8b"


def test_a_page_without_the_token_only_watches(viewer, controls):
    with Socket(viewer.watch_url) as page:
        hello = page.until("hello")
        assert hello["hello"]["reason"] == "This address has no valid token."
        assert hello["control"]["here"] is False
        assert page.ask("pause", "on") == (None, "this page does not control the world")
        assert "no valid token" in page.ask("control", "take")[1]
        page.send({"drive": [1, 0, 0]})
        page.send({"key": 65})
        assert page.ask("describe", name="x") == (None, None)
    assert [verb for verb, _, _ in controls.asked] == ["describe"]


def test_pages_ask_for_nothing_but_the_worlds_requests(viewer, controls):
    with Socket(viewer.url) as page:
        for verb in ("publish", "reload", "abilities", "__class__", "ask", "x" * 5000):
            assert "there is no request" in page.ask(verb)[1]
        assert page.ask("write", file="/tmp/stolen") == (None, None)
        for argument in ("on\nstop -", "", "x" * 300, "a b"):
            assert "not one word" in page.ask("pause", argument)[1]
        for text in ({}, {"text": ""}, {"text": None}):  # an empty one is none
            refused = page.ask("insert", model="/tmp/evil.sdf", **text)[1]
            assert refused == "there is no '/tmp/evil.sdf' in the catalogue"
        for text in ("<sdf><model><plugin/></model></sdf>", "<!DOCTYPE a>", "<a xmlns:Xacro='b'/>", 7):
            assert "inserts no plugins" in page.ask("insert", text=text)[1]
        whole = {"text": "<?xml version='1.0'?><sdf/>", "of_page": True}
        assert page.ask("insert", text=whole["text"]) == (None, None)
        assert page.ask("insert", model="box") == (None, None)
    asked = [(verb, content) for verb, _, content in controls.asked if verb != "catalogue"]
    assert asked == [("write", {}), ("insert", whole), ("insert", {"model": "box"})]


@pytest.mark.parametrize("how", ["closed", "handed over"])
def test_what_a_page_holds_is_released_when_it_does_not_control_any_more(viewer, controls, how):
    with Socket(viewer.url) as page, Socket(viewer.url) if how == "handed over" else contextlib.nullcontext():
        for name in ("box1", "box2"):
            assert page.ask("hold", "on", name=name, pose=[0, 0, 1, 1, 0, 0, 0]) == (None, None)
        if how == "handed over":
            assert page.ask("control", "give") == (None, None)
            wait_for(lambda: released(controls) == {"box1", "box2"})
    wait_for(lambda: released(controls) == {"box1", "box2"})


def released(controls):
    return {content["name"] for verb, argument, content in controls.asked if (verb, argument) == ("hold", "off")}


def wait_for(condition):
    end = time.monotonic() + 60.0
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


@pytest.mark.parametrize("bad", ["NaN", "Infinity", "1e308", "-1e10", str(2**63)])
def test_numbers_out_of_range_are_dropped(bad):
    good = '{"ask": "move", "number": 1, "content": {"pose": [0, 0, 0.5]}}'
    assert read_message(good)
    assert read_message(good.replace("0.5", bad)) is None
    assert read_message(f'{{"drive": [{bad}]}}') is None


@pytest.mark.parametrize("raw", ["[" * 100_000, "{", "[1]", '"x"', "", '{"a":' * 20 + "1" + "}" * 20])
def test_messages_of_no_page_of_ours_are_dropped(viewer, raw):
    assert read_message(raw) is None
    with Socket(viewer.url) as page:
        page.send(raw)
        page.run(page.socket.send_bytes(b"\x00\xff"))
        assert page.ask("pause", "on") == (None, None)


@pytest.mark.parametrize(
    "message",
    [
        {"want": ["images"], "names": []},
        {"want": "images", "names": {"a": 1}},
        {"want": "images", "names": [1, "x" * 10000, None]},
        {"want": "fields", "names": ["laser.x.ranges[99999]", "no.such.thing", "a" * 299]},
        {"visible": [1]},
        {"ask": {"a": 1}, "number": 0},
        {"ask": "pause", "number": "x"},
        {"ask": "parts", "number": 0, "argument": 5},
        {"ask": "steer", "number": 0, "argument": "ptz.a/99", "content": {"value": "x"}},
        {"drive": "far"},
        {"drive": [1, 2]},
        {"robot": ["x"]},
        {"speeds": {"linear": "x", "angular": [1]}},
        {"key": "x"},
        {},
    ],
)
def test_the_viewer_survives_what_pages_send(viewer, message):
    with Socket(viewer.url) as page:
        page.send(message)
        assert page.ask("pause", "on") == (None, None)
    assert viewer.failures == 0


def test_a_message_of_very_many_values_is_dropped_before_it_is_parsed(viewer, monkeypatch):
    """A MiB of them takes most of a second, and all pages wait for it."""
    many = json.dumps({"want": "images", "names": [[]] * pages.MOST_OF_WATCHERS})
    assert read_message(many) is not None
    assert read_message(many, pages.MOST_OF_WATCHERS) is None
    assert read_message(json.dumps({"ask": [1] * (pages.MOST_VALUES + 1)})) is None
    with Socket(viewer.watch_url) as page, Socket(viewer.url) as trusted:
        for one in (page, trusted):
            one.ask("describe")
            one.send(many)
            one.ask("describe")
        wanted = {one.may_control: one.wants for one in viewer._pages}
        assert wanted == {False: {}, True: {"images": []}}


def test_a_message_that_is_too_large_ends_the_page_alone(viewer, caplog):
    caplog.set_level(logging.ERROR, pages.QUIET.name)
    with Socket(viewer.url) as page, Socket(viewer.url) as other:
        other.until("hello")
        with contextlib.suppress(ConnectionError):
            page.send("x" * (pages.LARGEST_MESSAGE + 1))
        end = time.monotonic() + 20.0
        while viewer.pages != 1:
            assert time.monotonic() < end
            time.sleep(0.01)
        assert other.ask("describe") == (None, None)
    assert not caplog.records


def test_connections_are_limited(viewer, monkeypatch):
    monkeypatch.setattr(pages, "MOST_CONNECTIONS", 6)
    monkeypatch.setattr(pages, "MOST_SPARE", 2)
    port = int(re.search(r":(\d+)/", viewer.watch_url)[1])
    crowd = [socket.create_connection(("127.0.0.1", port), 60.0) for _ in range(30)]
    places, end = set(crowd), time.monotonic() + 20.0
    while len(places) > 8 and time.monotonic() < end:
        places -= {one for one in select.select(places, [], [], 1.0)[0] if one.recv(1) == b""}
    assert len(places) == 8
    assert not select.select(places, [], [], 0.3)[0]
    for one in crowd:
        one.close()
    end = time.monotonic() + 20.0
    while True:  # the others have places again
        try:
            assert get(viewer)[0] == 200
            break
        except (OSError, ValueError, IndexError):
            assert time.monotonic() < end


def test_connections_that_send_nothing_are_closed(monkeypatch, controls):
    monkeypatch.setattr(pages, "SILENCE", 0.2)
    with running(Nothing(), controls) as viewer:
        port = int(re.search(r":(\d+)/", viewer.watch_url)[1])
        with socket.create_connection(("127.0.0.1", port), 60.0) as one:
            assert one.recv(1) == b""


class Wide(Nothing):
    """A source with many states, each of 1 MB."""

    count = 0

    def state(self):
        Wide.count += 1
        return ObservedState(Wide.count, 0, 0, False, 0.0, 0.0, 0.0, np.zeros((16384, 16)), np.zeros((0, 4)))


def test_a_page_that_does_not_read_is_closed_and_holds_little(monkeypatch, controls):
    monkeypatch.setattr(pages, "PATIENCE", 0.5)
    with running(Wide(), controls, rate=200.0) as viewer, Socket(viewer.url) as other:
        port = int(re.search(r":(\d+)/", viewer.watch_url)[1])
        with socket.socket() as lazy:
            lazy.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            lazy.connect(("127.0.0.1", port))
            key = "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13"
            lines = (
                f"GET /socket HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n{key}"
            )
            lazy.sendall(f"{lines}\r\n\r\n".encode())
            end = time.monotonic() + 60.0
            seen = 0
            while viewer.pages != 2:
                other.until("state")
                assert time.monotonic() < end
            while viewer.pages == 2:
                other.until("state")  # another page is served meanwhile
                seen += 1
                waiting = [sum(map(len, page._waiting.values())) for page in viewer._pages]
                assert max(waiting) < 4 << 20  # states are dropped, not kept
                assert time.monotonic() < end
        assert seen > 1


@pytest.mark.parametrize("encoding", ["identity", "gzip"])
def test_clients_that_do_not_read_a_file_are_closed_and_hold_no_copy_of_it(viewer, monkeypatch, encoding):
    monkeypatch.setattr(pages, "PATIENCE", 1.0)
    body = np.random.default_rng(1).bytes(16 << 20)
    asset = Asset(body, "application/octet-stream")
    viewer.assets._keep("mesh", "assets/mesh.bin", lambda: asset)
    status, headers, found = get(viewer, "/assets/mesh.bin", Accept_Encoding=encoding)
    assert status == 200
    assert (gzip.decompress(found) if encoding == "gzip" else found) == body
    assert int(headers["Content-Length"]) == len(found)
    port = int(re.search(r":(\d+)/", viewer.watch_url)[1])
    request = f"GET /assets/mesh.bin HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nAccept-Encoding: {encoding}\r\n\r\n"
    with contextlib.ExitStack() as kept:
        held = []
        for _ in range(5):
            one = kept.enter_context(socket.socket())
            one.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            one.connect(("127.0.0.1", port))
            one.sendall(request.encode())
            assert one.recv(1) == b"H"
            held += [c.transport.get_write_buffer_size() for c in list(viewer._pages._connections) if c.transport]
        assert max(held) < 1 << 20
        wait_for(lambda: not viewer._pages._connections)


def test_a_file_is_packed_once(viewer, monkeypatch):
    packed = []
    monkeypatch.setattr("gzip.compress", lambda body, _level: packed.append(1) or body)
    asset = Asset(bytes(4096), "application/octet-stream")
    viewer.assets._keep("mesh", "assets/mesh.bin", lambda: asset)
    for _ in range(3):
        assert get(viewer, "/assets/mesh.bin", Accept_Encoding="gzip")[1]["Content-Encoding"] == "gzip"
    assert packed == [1]


def test_one_page_controls_at_a_time_and_hands_over(viewer, controls):
    with Socket(viewer.url) as one, Socket(viewer.url) as two:
        assert one.until("hello")["control"]["here"] is True
        assert two.until("hello")["control"] == {"here": False, "other": True, "canAsk": True, "asked": ""}
        assert two.ask("pause", "on")[1] == "this page does not control the world"
        assert two.ask("control", "give")[1]
        assert two.ask("control", "ask") == (None, None)
        assert one.until(lambda m: m.get("control", {}).get("asked"))["control"]["asked"] == "page 2"
        assert one.ask("control", "give") == (None, None)
        assert two.until(lambda m: m.get("control", {}).get("here"))
        assert two.ask("pause", "on") == (None, None)
        assert one.ask("pause", "on")[1] == "this page does not control the world"
    with Socket(viewer.url) as three:
        assert three.until("hello")["control"]["here"] is True  # the others were closed
    assert [verb for verb, _, _ in controls.asked] == ["pause"]


def test_the_page_that_is_open_for_longest_controls_when_the_controller_is_closed(viewer):
    with Socket(viewer.url) as one, Socket(viewer.url) as two:
        assert one.until("hello")["control"]["here"]
        with Socket(viewer.url) as three:
            assert not three.until("hello")["control"]["here"]
            assert one.ask("control", "give") == (None, None)
            assert two.until(lambda m: m.get("control", {}).get("here"))
            assert two.ask("control", "give") == (None, None)
            assert one.until(lambda m: m.get("control", {}).get("here"))
            one.run(one.socket.close())
            assert two.until(lambda m: m.get("control", {}).get("here"))


def test_a_controller_that_does_not_answer_hands_over(viewer, monkeypatch):
    monkeypatch.setattr("libgz.view.controllers.PATIENCE", 0.1)
    with Socket(viewer.url) as one, Socket(viewer.url) as two:
        one.until("hello")
        assert two.ask("control", "ask") == (None, None)
        assert two.until(lambda m: m.get("control", {}).get("here"))


def test_a_viewer_binds_this_machine_and_a_busy_port_moves_on():
    with Viewer(Nothing(), port=18380) as first, Viewer(Nothing(), port=18380) as second:
        assert first.watch_url.startswith("http://127.0.0.1:")
        assert first.url != second.url
        assert first.watch_url != second.watch_url
        with urllib.request.urlopen(first.url, timeout=20.0) as answer:
            assert answer.status == 200
            assert answer.geturl().endswith(f"/{token_of(first)}/")
        with pytest.raises(urllib.error.HTTPError):
            urllib.request.urlopen(first.watch_url + token_of(second) + "/", timeout=20.0)


def test_a_state_is_one_message(viewer):
    with Socket(viewer.watch_url) as page:
        raw = page.until("state")["state"]
        assert struct.unpack("<8I", raw[:32]) == (1, 0, 0, 0, 16, 0, 4, 0)


def test_a_viewer_opens_where_a_loop_runs_as_in_notebooks():
    async def cell():
        with Viewer(Nothing(), port=18380) as viewer:
            return viewer.url

    assert asyncio.run(cell()).startswith("http://127.0.0.1:")


def test_an_address_of_another_machine_is_refused():
    with pytest.raises(GazeboError, match=r"192\.0\.2\.1, port 18380, cannot be bound"):
        Viewer(Nothing(), host="192.0.2.1", port=18380)
    assert not [thread for thread in threading.enumerate() if thread.name == "pages"]


def test_a_pace_allows_some_at_once_and_no_more_on_average():
    pace = pages.Pace(10.0, 5.0)
    waits = [pace.next() for _ in range(9)]
    assert waits[:5] == [0.0] * 5
    assert 0.3 < waits[8] <= 0.4


def test_pages_that_watch_do_not_keep_out_one_that_controls(viewer, monkeypatch):
    monkeypatch.setattr(pages, "MOST_CONNECTIONS", 5)
    monkeypatch.setattr(pages, "MOST_TRUSTED", 2)
    monkeypatch.setattr(pages, "MOST_SPARE", 3)
    place = urllib.parse.urlsplit(viewer.url)
    with contextlib.ExitStack() as kept:
        silent = [kept.enter_context(socket.create_connection((place.hostname, place.port))) for _ in range(20)]
        for one in silent[5:17]:
            assert one.recv(1) == b""  # closed for those that came later
        with urllib.request.urlopen(viewer.watch_url, timeout=20.0) as answer:
            assert answer.headers["Connection"] == "close"
        page = kept.enter_context(Socket(viewer.url))
        assert page.ask("pause", "on") == (None, None)
        with pytest.raises(aiohttp.WSServerHandshakeError, match="503"):
            Socket(viewer.watch_url)
        assert page.ask("pause", "off") == (None, None)


def test_pings_and_pongs_count_as_messages_and_pings_are_answered(viewer):
    counted = []

    async def answered():
        where = viewer.watch_url + "socket"
        async with page.session.ws_connect(where, autoping=False) as other:
            await other.ping(b"there?")
            while (found := await other.receive()).type != aiohttp.WSMsgType.PONG:
                pass
            return found.data

    with Socket(viewer.watch_url) as page:
        page.until("state")
        [one] = viewer._pages
        one.pace.next = lambda: counted.append(1) or 0.0
        for _ in range(5):
            page.run(page.socket.ping())
            page.run(page.socket.pong())
        page.ask("describe", name="none")
        assert len(counted) >= 10
        assert page.run(answered()) == b"there?"


class Watching:
    """What is like a page that only watches."""

    may_control, visible = False, True

    def __init__(self, number):
        self.number, self.wants, self.states = number, {}, 0

    def post(self, key, message):
        self.states += key == "state"


def test_many_that_watch_get_states_in_turn():
    with Viewer(Nothing(), port=18960) as viewer:
        crowd = [Watching(-number) for number in range(1, 51)]
        master = Watching(-99)
        master.may_control = True
        for page in (*crowd, master):
            viewer.show_to(page)
        for number in range(50):
            viewer.source.state = lambda number=number: dataclasses.replace(Nothing().state(), number=number)
            viewer.frame()
        assert master.states == 50
        assert {page.states for page in crowd} == {20}


def lazy_page(viewer, path="/"):
    """The socket of a page that reads nothing."""
    place = urllib.parse.urlsplit(viewer.watch_url)
    one = socket.socket()
    one.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    one.connect((place.hostname, place.port))
    key = "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13"
    lines = f"GET {path}socket HTTP/1.1\r\nHost: {place.netloc}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n{key}"
    one.sendall(f"{lines}\r\n\r\n".encode())
    return one


def test_all_pages_that_do_not_read_have_one_bound_and_close_none_that_reads(monkeypatch, controls, caplog):
    monkeypatch.setattr(pages, "LARGEST_UNREAD", 8 << 20)
    with running(Wide(), controls, rate=200.0) as viewer, Socket(viewer.url) as master, Socket(viewer.watch_url) as one:
        with contextlib.ExitStack() as kept:
            for _ in range(16):
                kept.enter_context(lazy_page(viewer))

            def closed():
                one.until("state")
                master.until("state")
                assert viewer._pages._backlogs[False].size <= 8 << 20
                return [line for line in map(logging.LogRecord.getMessage, caplog.records) if "was closed" in line]

            wait_for(closed)
            assert {page.number for page in viewer._pages} >= {1, 2}
        wait_for(lambda: len(viewer._pages) == 2)
    assert [backlog.size for backlog in viewer._pages._backlogs.values()] == [0, 0]
    [line] = [record.getMessage() for record in caplog.records]  # the others are counted
    assert "the one that read least of what waited for all pages" in line


def test_what_a_page_does_not_read_is_held_once(viewer):
    with lazy_page(viewer):
        wait_for(lambda: len(viewer._pages) == 1)
        [page] = viewer._pages
        message = bytes(16 << 20)
        page.post("image a", message)
        wait_for(lambda: page._connection.unsent > 1 << 20)
        wait_for(lambda: sys.getrefcount(message) == 2)  # this function's, and the argument
        assert page._connection.unsent <= viewer._pages._backlogs[False].size < 17 << 20


def test_pages_get_the_last_state_before_the_world_was_paused():
    with Viewer(Nothing(), port=18960) as viewer:
        crowd = [Watching(-number) for number in range(1, 51)]
        for page in crowd:
            viewer.show_to(page)
        for _ in range(3):
            viewer.frame()
        assert {page.states for page in crowd} == {1}
        viewer.frame()
        assert {page.states for page in crowd} == {1}


@pytest.mark.parametrize("trusted", [False, True])
def test_messages_that_do_not_come_whole_have_one_bound(monkeypatch, controls, trusted):
    monkeypatch.setattr(pages, "LARGEST_RECEIVED", 4 << 20)
    monkeypatch.setattr(pages, "LARGEST_OF_ALL_WATCHERS", 4 << 20)
    part = b"\x01\xff" + (900 << 10).to_bytes(8, "big") + bytes(4) + b"x" * (900 << 10)
    with running(Nothing(), controls) as viewer, Socket(viewer.url if trusted else viewer.watch_url) as page:
        page.until("state")
        with contextlib.ExitStack() as kept:
            for _ in range(8):
                one = kept.enter_context(lazy_page(viewer, f"/{token_of(viewer)}/" if trusted else "/"))
                one.sendall(part)
            received = viewer._pages._received[trusted]
            wait_for(lambda: received.size > 3 << 20 and len(viewer._pages) == 5)
            assert received.size <= 4 << 20
            for _ in range(5):
                assert page.ask("describe", name="x" * 100_000)[1] is None
        wait_for(lambda: len(viewer._pages) == 1 and received.size < 4096)  # the request for its socket is left


class Waiting(Counting):
    """Controls that answer a description only when they may."""

    def __init__(self):
        super().__init__()
        self.may = threading.Event()

    def ask(self, verb, argument="-", **content):
        self.may.wait(60.0)
        return super().ask(verb, argument, **content)


def test_the_texts_of_open_requests_have_one_bound(monkeypatch):
    monkeypatch.setattr("libgz.view.viewer.LARGEST_REQUESTS", 5_500_000)
    controls = Waiting()
    with running(Nothing(), controls) as viewer, Socket(viewer.url) as page:
        try:
            for number, text in enumerate(
                ("x" * (2 << 20), [0] * 20000, "x" * (1 << 20)), 1
            ):  # values take more than their text
                message = {"ask": "describe", "number": number, "content": {"names": text}}
                page.send(message)
            refused = page.until(lambda message: "answer" in message)
            assert refused == {"answer": 3, "error": "the server has not answered the requests before; try again later"}
        finally:
            controls.may.set()
        answered = [page.until(lambda message: "answer" in message)["answer"] for _ in range(2)]
        assert answered == [1, 2]
        assert page.ask("describe", name="x" * (4 << 20)) == (None, None)
