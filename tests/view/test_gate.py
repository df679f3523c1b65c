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
        watcher = gate._Watcher(Connection(), gate.WATCHING.__contains__)
        return [msgspec.msgpack.decode(await watcher.recv())["type"] for _ in range(2)]

    assert asyncio.run(passed()) == ["ViewerCameraMessage"] * 2
    assert not raws


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
