"""Fixtures for several test modules."""

import os
import signal

import pytest
from c_programs import config
from commands import kept_logging
from sdf_worlds import Loader

from libgz.transport.server import Server

# A shell starts jobs in the background with an ignored SIGINT, which programs under test would inherit.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(autouse=True, scope="session")
def own_data(tmp_path_factory):
    """What installations note for the user is noted elsewhere."""
    before = os.environ.get("XDG_DATA_HOME")
    os.environ["XDG_DATA_HOME"] = str(tmp_path_factory.mktemp("data"))
    yield
    os.environ.pop("XDG_DATA_HOME")
    if before is not None:
        os.environ["XDG_DATA_HOME"] = before


@pytest.fixture(autouse=True)
def own_logging():
    """Restore the library's logger after each test: some call a command's `main`."""
    with kept_logging():
        yield


@pytest.fixture
def server(wire):
    """A running server without interfaces."""
    running = Server(wire)
    running.start()
    yield running
    running.stop()


@pytest.fixture(scope="module")
def flags(tmp_path_factory):
    """The options of a C compiler for programs that use the library."""
    done = config("--cflags", "--libs", XDG_CACHE_HOME=str(tmp_path_factory.mktemp("cache")))
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


@pytest.fixture
def load(tmp_path, monkeypatch):
    """Loads SDF worlds from text; files are found beside them only."""
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.delenv("GAZEBO_MODEL_PATH", raising=False)
    monkeypatch.delenv("GAZEBO_RESOURCE_PATH", raising=False)
    loader = Loader(tmp_path)
    yield loader
    loader.close()
