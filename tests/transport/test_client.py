"""Clients: the old functions, the Pythonic client, and what they open."""

import pwd
from pathlib import Path

import numpy as np
import pytest
from served import serve

import libgz
from libgz.interfaces.laser import Laser
from libgz.interfaces.sim import Sim
from libgz.transport import paths
from libgz.transport.control import ask


def test_the_old_functions(server, caplog):
    robot = serve(server)
    client = libgz.gz_client_alloc()
    assert libgz.gz_client_query(client, server.server_id) == 0
    assert libgz.gz_client_connect(client, server.server_id) == 0
    position = libgz.gz_position_alloc()
    assert libgz.gz_position_open(position, client, "robot1") == 0
    assert libgz.gz_position_lock(position, 1) == 0
    position.data.cmd_vel_pos[0] = 0.2
    libgz.gz_position_unlock(position)
    assert robot.data.cmd_vel_pos[0] == 0.2
    assert libgz.gz_position_close(position) == 0
    assert libgz.gz_position_open(libgz.gz_position_alloc(), client, "nobody") == -1
    assert "nobody" in libgz.gz_error_str()
    assert "nobody" in caplog.text
    assert libgz.gz_client_connect_wait(client, server.server_id, 16) == -1
    assert libgz.gz_client_connect_wait(client, server.server_id + 1, 0) == -1
    assert "does not appear to be running" in libgz.gz_error_str()
    assert libgz.gz_client_query(client, server.server_id + 1) == 1
    assert libgz.gz_client_connect_wait(client, server.server_id, 3) == 0
    server.post()
    assert libgz.gz_client_wait(client) == 0
    assert libgz.gz_client_disconnect(client) == 0


def test_a_directory_of_another_user_is_not_trusted(server, monkeypatch):
    """Anybody can make one in /tmp that has the name of this user's server, and put links into it."""
    serve(server)
    serve(server, Sim, "default")
    opened = [
        lambda: libgz.Client(server.server_id).position("robot1"),
        lambda: libgz.Observer(server.server_id),
        lambda: ask(server.server_id, "save"),
    ]
    owner = Path(server.path).stat().st_uid
    monkeypatch.setattr(paths.os, "geteuid", lambda: owner + 1)
    monkeypatch.setattr(paths, "ROOT", owner + 2)
    for one in opened:
        with pytest.raises(libgz.GazeboError, match=f"belongs to another user .uid {owner}."):
            one()
    monkeypatch.setattr(paths, "ROOT", owner + 1)  # as root, from a shell of the server's user
    monkeypatch.setenv("USER", pwd.getpwuid(owner).pw_name)
    assert paths.check_owner(server.path) is None
    monkeypatch.setenv("USER", "of nobody")
    with pytest.raises(PermissionError):
        paths.check_owner(server.path)


def test_links_are_not_followed(server, tmp_path):
    robot = serve(server)
    serve(server, Sim, "default")
    kept = tmp_path / "kept"
    kept.write_bytes(bytes(robot.size))
    (Path(server.path) / "position.link").symlink_to(kept)
    with libgz.Client(server.server_id) as client, pytest.raises(libgz.GazeboError, match="symbolic links"):
        client.position("link")
    (tmp_path / "server").symlink_to(server.path)
    with pytest.raises(NotADirectoryError):
        paths.check_owner(str(tmp_path / "server"))


def test_the_pythonic_client(server):
    robot = serve(server)
    serve(server, Sim, "default")
    robot.data.pos[0] = 1.5
    with libgz.Client(server.server_id) as client:
        view = client.position("robot1")
        assert client.position("robot1") is view
        assert isinstance(view.pos, np.ndarray)
        robot.data.pos[1] = 2.5
        assert view.pos.tolist() == [1.5, 2.5, 0.0]  # a view, not a copy
        view.command(vx=0.2, vyaw=0.1)
        assert robot.data.cmd_vel_rot[2] == 0.1
        view.cmd_vel_pos[0] = 9.0
        assert robot.data.cmd_vel_pos[0] == 9.0
        kept = view.pos
        assert client.interfaces() == [("position", "robot1"), ("sim", "default")]
        assert repr(client) == f"<Client of server {server.server_id}: position.robot1>"
    with pytest.raises(libgz.ClosedError):
        _ = view.data
    assert kept[0] == 1.5  # memory lives as long as a view of it does


def test_an_interface_that_was_created_again_is_opened_again(server):
    first = serve(server)
    serve(server, Sim, "default")
    with libgz.Client(server.server_id) as client:
        old = client.position("robot1")
        first.destroy()
        assert client.position("robot1") is old  # there is no new one yet
        second = serve(server)
        new = client.position("robot1")
        new.command(vx=1.0)
        assert second.data.cmd_vel_pos[0] == 1.0
        assert old.cmd_vel_pos[0] == 0.0
        assert client.position("robot1") is new


def test_an_id_too_long_for_c_programs_is_reported(server, caplog):
    longest = 127 - len(f"{server.path}/position.")
    serve(server, name="a" * longest)
    assert not caplog.records
    serve(server, name="b" * (longest + 1))
    assert "C programs cannot open" in caplog.text


def test_a_client_without_a_server(wire):
    with pytest.raises(libgz.ServerError, match=f"server {wire} does not appear to be running"):
        libgz.Client(wire, timeout=0.05)


def test_the_error_for_a_missing_interface_names_similar_ones(server):
    serve(server)
    serve(server, Sim, "default")
    with libgz.Client(server.server_id) as client:
        with pytest.raises(libgz.InterfaceError, match="its position interfaces are 'robot1'; did you mean 'robot1'"):
            client.position("robt1")
        with pytest.raises(libgz.InterfaceError, match="serves no laser interface"):
            client.laser("laser1")
        with pytest.raises(libgz.ParameterError, match="'position' is no interface object, such as Position"):
            client.open("position", "robot1")  # type: ignore[type-var]


def test_a_file_that_is_too_short_is_refused(server):
    serve(server, Sim, "default")
    (Path(server.path) / "laser.short").write_bytes(bytes(100))
    with libgz.Client(server.server_id) as client, pytest.raises(libgz.InterfaceError, match="expected file size"):
        client.laser("short")
    (Path(server.path) / "laser.old").write_bytes(bytes(Laser().size))
    with libgz.Client(server.server_id) as client, pytest.raises(libgz.InterfaceError, match="expected file size"):
        client.laser("old")
