"""The viewer's port: who gets the page, who may control, and what the page may load."""

import asyncio
import json
import urllib.error
import urllib.request

import msgspec.msgpack
import pytest

from libgz.view import gate
from libgz.view.gate import Gate


class Request:
    def __init__(self, path, **headers):
        self.path = path
        self.headers = {"Host": "127.0.0.1:8080"} | {name.replace("_", "-"): text for name, text in headers.items()}


@pytest.fixture
def door():
    return Gate("127.0.0.1", "a <title>", lambda note, page: None)


def test_the_token_is_in_the_address_and_nowhere_else(door):
    answer = door._answer(None, Request(f"/?token={door.token}"))
    assert (answer.status_code, answer.headers["Location"]) == (302, f"/{door.token}/")
    assert door._answer(None, Request("/?token=wrong")).headers["Location"] == "/"
    page = door._answer(None, Request("/"))
    assert page.status_code == 200
    assert door.token.encode() not in page.body
    assert b"libgzControl=false" in page.body
    assert b"libgzControl=true" in door._answer(None, Request(f"/{door.token}/")).body
    assert b"a &lt;title&gt;" in page.body


@pytest.mark.parametrize("path", ["/wrong/", "/../../etc/passwd", "/index.html", "/etc/passwd"])
def test_nothing_else_is_served(door, path):
    assert door._answer(None, Request(path)).status_code == 404


def test_names_that_others_made_point_here_are_refused(door):
    assert door._answer(None, Request("/", Host="evil.example:8080")).status_code == 403
    assert door._answer(None, Request("/", Host="localhost:9000")).status_code == 200  # a forwarded port


def test_pages_of_other_addresses_cannot_connect(door):
    other = Request("/", Upgrade="websocket", Origin="http://evil.example")
    assert door._answer(None, other).status_code == 403
    assert door._answer(None, Request("/", Upgrade="websocket", Origin="http://127.0.0.1:8080")) is None


def test_the_page_loads_nothing_from_elsewhere(door):
    policy = door._answer(None, Request("/")).headers["Content-Security-Policy"]
    assert "default-src 'none'" in policy
    assert "img-src data: blob:" in policy
    assert "http:" not in policy
    assert "https:" not in policy


def test_messages_of_watching_pages_are_dropped():
    messages = [{"type": "GuiButtonUpdate"}, {"type": "ViewerCameraMessage"}, [1], {"type": "CommandTriggerMessage"}]
    raws = [b"\xc1", *map(msgspec.msgpack.encode, messages), msgspec.msgpack.encode({"type": "ViewerCameraMessage"})]

    class Connection:
        async def recv(self):
            return raws.pop(0)

    async def passed():
        watcher = gate._Checked(Connection(), gate.WATCHING.__contains__)
        return [msgspec.msgpack.decode(await watcher.recv())["type"] for _ in range(2)]

    assert asyncio.run(passed()) == ["ViewerCameraMessage"] * 2
    assert not raws


def let_through(*messages, control=True):
    """The types of those messages that a page's connection lets through."""
    raws = [message if isinstance(message, bytes) else msgspec.msgpack.encode(message) for message in messages]

    class Connection:
        request = Request("/")

        async def recv(self):
            if not raws:
                raise EOFError
            return raws.pop(0)

    found = []

    async def handler(connection):
        while True:
            found.append(msgspec.msgpack.decode(await connection.recv())["type"])

    door = Gate("127.0.0.1", "", lambda note, page: None)
    Connection.request = Request(f"/{door.token}/" if control else "/")
    with pytest.raises(EOFError):
        asyncio.run(door._connect(handler, Connection()))
    return found


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), 1e308, -1e10, 2**63])
@pytest.mark.parametrize("control", [True, False])
def test_messages_with_numbers_out_of_range_are_dropped(bad, control):
    good = {"type": "ViewerCameraMessage", "position": [0.0, 1.0, -2.0], "fov": 1.2, "image_width": 800}
    wrong = [{**good, "fov": bad}, {**good, "position": [0.0, bad, 0.0]}, {**good, "more": {"deep": [[bad]]}}]
    assert let_through(*wrong, good, control=control) == ["ViewerCameraMessage"]


def test_messages_that_are_nested_deeply_are_dropped():
    deep = 0
    for _ in range(20):
        deep = [deep]
    deeper = b"\x81\xa1x" + b"\x91" * 100_000 + b"\x00"  # deeper than a decoder can follow
    assert let_through({"type": "GuiUpdateMessage", "value": deep}, deeper, {"type": "end"}) == ["end"]


@pytest.mark.parametrize("kind", ["ShareUrlRequest", "ShareUrlDisconnect"])
def test_no_page_can_make_itself_public(kind):
    assert let_through({"type": kind}, {"type": "end"}) == ["end"]


def test_an_origin_without_the_port_is_another_one(door):
    for origin in ("http://127.0.0.1", "http://127.0.0.1:80801", "null", ""):
        request = Request("/", Upgrade="websocket", Origin=origin)
        assert door._answer(None, request).status_code == 403


def test_notes_are_short_tables():
    notes = []
    door = Gate("127.0.0.1", "", lambda note, page: notes.append(note))
    fits = json.dumps({"key": "x" * (gate.LARGEST_NOTE - len('{"key": ""}'))})
    raws = ["[" * 5000, "{", "[1]", fits, fits.replace("x", "xx", 1), '{"key": 1}']

    class Connection:
        request = Request(f"/{door.token}/notes")

        def __aiter__(self):
            return self

        async def __anext__(self):
            if not raws:
                raise StopAsyncIteration
            return raws.pop(0)

    asyncio.run(door._connect(None, Connection()))
    assert [len(note.get("key", "")) if isinstance(note.get("key", ""), str) else 1 for note in notes] == [4085, 1, 0]
    assert notes[-1] == {"closed": True}


def test_a_viewer_binds_this_machine_and_a_busy_port_moves_on():
    from libgz.view.viewer import Viewer

    with Viewer(Nothing(), port=18380) as first, Viewer(Nothing(), port=18380) as second:
        assert first.watch_url.startswith("http://127.0.0.1:")
        assert first.url != second.url
        assert first.watch_url != second.watch_url
        with urllib.request.urlopen(first.url, timeout=20.0) as answer:
            assert answer.status == 200
            assert answer.geturl().endswith(f"/{first.gate.token}/")
        with pytest.raises(urllib.error.HTTPError):
            urllib.request.urlopen(first.watch_url + second.gate.token + "/", timeout=20.0)


class Nothing:
    """A source without content."""

    alive = True
    scene = json.loads('{"revision": 0, "entities": [], "others": [], "world": "empty", "view": null}')
