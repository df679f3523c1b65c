"""Who may connect over the loopback interface, and what clients of a server may do that can only be watched."""

import contextlib
import errno
import ipaddress
import logging
import os
import re
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest
from classic_wire import Connection, Publication, close_all, new
from gzserver_process import SERVER, new_environment
from master_uri import free_master_uri

import libgz
from libgz.classic.transport import Node, TopicManager, serve
from libgz.transport import peers
from libgz.transport.peers import TABLES, PeerCheck

OTHER = 65534  # nobody
PATIENCE = 20.0  # [s]: a machine under load
WORLD = "<sdf version='1.6'><world name='default'><model name='box'><link name='link'/></model></world></sdf>"
# Connects as another user from a socket of a family; prints what comes in.
CLIENT = """
import os, socket, sys
os.setgid({other}); os.setuid({other})
made = socket.socket({family})
made.settimeout(20)
made.connect(({host!r}, {port}))
{more}
try:
    print(len(made.recv(100)))
except ConnectionError:
    print(0)
"""
needs_root = pytest.mark.skipif(os.getuid() != 0, reason="only root can run a client as another user")


@pytest.fixture
def uri(monkeypatch):
    found = free_master_uri()
    monkeypatch.setenv("GAZEBO_MASTER_URI", found)
    yield found
    close_all()


def own_ports():
    """The TCP ports at which this process listens."""
    inodes = set()
    for entry in Path("/proc/self/fd").iterdir():
        with contextlib.suppress(OSError):
            inodes |= set(re.findall(r"socket:\[(\d+)\]", str(entry.readlink())))
    rows = [row.split() for table in TABLES for row in table.read_text().splitlines()[1:]]
    return {int(row[1].split(":")[1], 16) for row in rows if row[3] == "0A" and row[9] in inodes}


def as_other(host, port, family="socket.AF_INET", more=""):
    """How many bytes another user gets from a port."""
    text = CLIENT.format(other=OTHER, family=family, host=host, port=port, more=more)
    ended = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, timeout=60)
    assert ended.returncode == 0, ended.stderr
    return int(ended.stdout)


@needs_root
def test_another_user_gets_nothing_from_any_port(uri, caplog):
    with serve() as link:
        ports = own_ports()
        assert link.address.port in ports
        assert len(ports) == 2  # the master's and that of the process's topics
        for port in ports:
            assert as_other("127.0.0.1", port) == 0
            assert as_other("::ffff:127.0.0.1", port, "socket.AF_INET6") == 0
        Connection(link.address.port)  # this user is served
    refused = [one.getMessage() for one in caplog.records if "a connection was refused" in one.getMessage()]
    assert refused == [f"a connection was refused: it is of user {OTHER}, not of user 0 or root (reported once)"]


def test_the_own_user_may_use_any_family(uri):
    with serve() as link:
        for family, host in ((socket.AF_INET, "127.0.0.1"), (socket.AF_INET6, "::ffff:127.0.0.1")):
            with socket.socket(family) as made:
                made.settimeout(PATIENCE)
                made.connect((host, link.address.port))
                assert made.recv(8)


def connected(family=socket.AF_INET, host="127.0.0.1", at="127.0.0.1"):
    """A pair of connected sockets: a client's and a server's, who listens at an address."""
    with socket.create_server((at, 0)) as listener:
        client = socket.socket(family)
        client.connect((host, listener.getsockname()[1]))
        server, _ = listener.accept()
    return client, server


def answer_nothing(*_):
    """What becomes of a question where the kernel answers none, or descriptors are missing."""
    raise OSError(errno.EMFILE, "Too many open files")


WAYS = [(socket.AF_INET, "127.0.0.1"), (socket.AF_INET, "127.0.0.9"), (socket.AF_INET6, "::ffff:127.0.0.1")]


@pytest.mark.parametrize("asked", [True, False], ids=["asked", "listed"])
@pytest.mark.parametrize(("family", "host"), WAYS)
def test_a_peer_of_another_user_is_named(monkeypatch, family, host, asked):
    if not asked:
        monkeypatch.setattr(peers, "_asked_for", answer_nothing)
    monkeypatch.setattr(peers.os, "geteuid", lambda: 77)
    monkeypatch.setattr(peers, "ROOT", 78)
    with socket.create_server(("0.0.0.0", 0)) as listener, socket.socket(family) as client:
        client.connect((host, listener.getsockname()[1]))
        server, _ = listener.accept()
        with server:
            check = PeerCheck()
            assert check.refusal(server) == f"it is of user {os.getuid()}, not of user 77 or root"
            monkeypatch.setattr(peers, "ROOT", os.getuid())
            assert check.refusal(server) == ""


@pytest.mark.parametrize(("family", "host"), WAYS)
def test_another_user_of_this_machine_is_refused_at_the_address_for_other_machines_too(monkeypatch, family, host):
    for kind in (ipaddress.IPv4Address, ipaddress.IPv6Address):  # not every machine has another address
        monkeypatch.setattr(kind, "is_loopback", False)
    client, server = connected(family, host, "0.0.0.0")
    with client, server:
        assert PeerCheck().refusal(server) == ""
        monkeypatch.setattr(peers.os, "geteuid", lambda: 77)
        monkeypatch.setattr(peers, "ROOT", 78)
        check = PeerCheck()
        assert check.refusal(server) == f"it is of user {os.getuid()}, not of user 77 or root"
        client.sendall(b"0000")
        client.close()
        assert check.refusal(server) == "its user is unknown: it has closed its socket"
        monkeypatch.setattr(peers, "_asked_for", lambda local, remote: None)  # the socket is on another machine
        assert check.refusal(server) == ""


@pytest.mark.parametrize("asking", [True, False], ids=["asked", "listed"])
def test_a_peer_of_whom_nobody_can_be_asked_is_refused_at_every_address(monkeypatch, tmp_path, asking):
    """A server without descriptors, which clients can bring about, would serve every user."""
    client, server = connected()
    with client, server:
        if not asking:
            monkeypatch.setattr(peers, "_asked_for", answer_nothing)
            monkeypatch.setattr(peers, "TABLES", (tmp_path / "tcp",))
            (tmp_path / "tcp").write_text("the list\n")
        for near_by in (True, False):
            check = PeerCheck()
            assert check.refusal(server) == ("" if asking else "its user is unknown: it has closed its socket")
            with monkeypatch.context() as broken:
                broken.setattr(ipaddress.IPv4Address, "is_loopback", near_by)
                if asking:
                    broken.setattr(peers, "_asked_for", answer_nothing)
                else:
                    broken.setattr(Path, "read_bytes", answer_nothing)
                assert check.refusal(server) == "its user is unknown: [Errno 24] Too many open files"


def link_local_address():
    """A link-local address of this machine; None if it has none."""
    table = Path("/proc/net/if_inet6")
    rows = [row.split() for row in table.read_text().splitlines()] if table.exists() else []
    found = next((row for row in rows if row[0].startswith("fe80")), None)
    return found and f"{ipaddress.IPv6Address(int(found[0], 16))}%{found[5]}"


def test_a_peer_at_a_link_local_address_has_its_user(monkeypatch):
    at = link_local_address()
    if at is None:
        pytest.skip("this machine has no link-local address")
    with socket.socket(socket.AF_INET6) as listener, socket.socket(socket.AF_INET6) as client:
        listener.bind(socket.getaddrinfo(at, 0, type=socket.SOCK_STREAM)[0][4])
        listener.listen()
        client.connect(listener.getsockname())
        server, _ = listener.accept()
        with server:
            assert PeerCheck().refusal(server) == ""
            monkeypatch.setattr(peers.os, "geteuid", lambda: 77)
            monkeypatch.setattr(peers, "ROOT", 78)
            assert PeerCheck().refusal(server) == f"it is of user {os.getuid()}, not of user 77 or root"


def test_who_listens_at_the_port_of_a_peer_is_not_taken_for_it():
    with socket.create_server(("0.0.0.0", 0)) as other:
        far, near = ("192.0.2.77", other.getsockname()[1]), ("192.0.2.78", 11345)
        assert peers._asked_for(far, near) is None


@pytest.mark.parametrize(("family", "host"), WAYS)
def test_one_question_finds_the_user_without_the_lists(monkeypatch, family, host):
    """The lists take milliseconds: with them, few clients could connect in a second."""
    monkeypatch.setattr(PeerCheck, "_tables", property(lambda _: pytest.fail("the lists were read")))
    with socket.create_server(("0.0.0.0", 0)) as listener, socket.socket(family) as client:
        client.connect((host, listener.getsockname()[1]))
        server, _ = listener.accept()
        with server:
            assert PeerCheck().refusal(server) == ""


@pytest.mark.parametrize("asked", [True, False], ids=["asked", "listed"])
def test_a_peer_that_has_closed_its_socket_is_not_taken_for_root(monkeypatch, asked):
    if asked:  # any user can connect and leave at once: reading lists for each would keep the server busy
        monkeypatch.setattr(PeerCheck, "_listed", lambda *_: pytest.fail("the lists were read"))
    else:
        monkeypatch.setattr(peers, "_asked_for", answer_nothing)
    client, server = connected()
    with server:
        assert PeerCheck().refusal(server) == ""
        client.sendall(b"0000")
        client.close()
        assert PeerCheck().refusal(server) == "its user is unknown: it has closed its socket"


def test_where_the_kernel_names_no_users_it_is_said_and_nobody_is_refused(monkeypatch, tmp_path, caplog):
    monkeypatch.setattr(peers, "_asked_for", answer_nothing)
    monkeypatch.setattr(peers, "TABLES", (tmp_path / "tcp",))
    client, server = connected()
    with client, server, caplog.at_level(logging.WARNING):
        assert PeerCheck().refusal(server) == ""
    assert "every user of this machine may connect" in caplog.text


# Watch only -------------------------------------------------------------------------------------------------------


def test_a_server_that_can_only_be_watched_takes_reading_requests_only(uri, caplog):
    with serve(watch_only=True) as link, libgz.World.from_string(WORLD) as world:
        client = Connection(link.address.port)
        received = []
        node = Node()
        node.Init("default")
        watching = node.Subscribe("~/request", received.append)
        requests = Publication(client, "/gazebo/default/request", "Request")
        for name, data in (("entity_delete", "box"), ("made_up", "box"), ("entity_info", "box")):
            requests.publish(new("Request", id=7, request=name, data=data))
        port = socket.create_server(("127.0.0.1", 0))
        with port:
            at = port.getsockname()
            topics = [one for one in TopicManager.Instance().topics.values() if one.live_subscribers()]
            others = {one.name: one.expected_type() for one in topics if not one.name.endswith("/request")}
            assert {f"/gazebo/default/{name}" for name in ("factory", "model/modify", "world_control")} <= others.keys()
            for topic, kind in others.items():
                told = new("Publish", topic=topic, msg_type=kind or "gazebo.msgs.GzString", port=at[1])
                told.host = at[0]
                client.send("advertise", told)
            end = time.monotonic() + PATIENCE
            while not received:
                assert time.monotonic() < end
                world.step(1)
            world.step(100)
            port.settimeout(0.2)
            with pytest.raises(TimeoutError):
                port.accept()  # nobody came for what this client publishes
        assert [one.request for one in received] == ["entity_info"]
        assert "box" in [entity.name for entity in world.entities]
        watching.Unsubscribe()
    assert "this server can only be watched" in caplog.text


def test_pages_and_snapshots_of_such_a_server_only_read(tmp_path):
    environment = new_environment(tmp_path)
    (tmp_path / "box.world").write_text(WORLD)
    server_id = 951_000 + os.getpid() % 1000
    words = ["--watch-only", "--server-id", str(server_id), str(tmp_path / "box.world")]
    run = [sys.executable, "-m", "libgz"]
    with subprocess.Popen([*SERVER, *words], env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as server:
        try:
            end = time.monotonic() + 3 * PATIENCE
            save = [*run, "snapshot", "save", str(tmp_path / "state"), "-s", str(server_id)]
            while subprocess.run(save, env=environment, capture_output=True).returncode:
                assert time.monotonic() < end
            for action in (["restore", str(tmp_path / "state")], ["rewind", "1"]):
                command = [*run, "snapshot", *action, "-s", str(server_id)]
                ended = subprocess.run(command, env=environment, capture_output=True, text=True)
                assert ended.returncode == 1
                assert "this server can only be watched" in ended.stderr
        finally:
            server.terminate()
        server.communicate()
