"""Fixtures: servers of the real `gazebo` command, each under its own TMP and server id."""

from __future__ import annotations

import fcntl
import itertools
import os
import random
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Generator, Iterator
from pathlib import Path

import pytest

# Servers of tests that do not use `wire` have a place of their own, too: what they leave there is seen.
os.environ["TMP"] = tempfile.mkdtemp(prefix="gz", dir="/tmp")
os.environ["USER"] = "tester"
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy: the workers share the cores
os.environ["MESA_SHADER_CACHE_DISABLE"] = "true"  # Mesa would leave files in the user's cache

from libgz.transport.paths import LOCK_FILE
from libgz.transport.semaphores import GZ_SEM_KEY, SemaphoreSet

try:
    from hypothesis import settings
except ModuleNotFoundError:  # the examples' tests need pytest only
    pass
else:
    # The same examples in every run, without a time limit; HYPOTHESIS_PROFILE=random generates new ones.
    settings.register_profile("repeatable", derandomize=True, deadline=None)
    settings.register_profile("random", deadline=None)
    settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))


def pytest_addoption(parser: pytest.Parser) -> None:
    """Options for the order of tests, and for their cost."""
    parser.addoption(
        "--cpu",
        type=int,
        default=0,
        metavar="N",
        help="show the N tests that take most processor time, children included",
    )
    parser.addoption(
        "--shuffle",
        type=int,
        nargs="?",
        const=-1,
        metavar="SEED",
        help="run modules, and the tests of each, in a random order; without a seed: a new one, which is printed",
    )


@pytest.hookimpl(tryfirst=True)
def pytest_configure(config: pytest.Config) -> None:
    """Choose a seed before processes of xdist are started, which have to use the same."""
    if config.option.shuffle == -1:
        config.option.shuffle = random.SystemRandom().randrange(10**6)


def pytest_report_header(config: pytest.Config) -> str | None:
    """The seed of the order."""
    return None if config.option.shuffle is None else f"random order: --shuffle {config.option.shuffle}"


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Shuffle modules, and the tests of each; fixtures of a module are made once all the same."""
    if config.option.shuffle is None:
        return
    order = random.Random(config.option.shuffle)
    modules: dict[Path, list[pytest.Item]] = {}
    for item in items:
        modules.setdefault(item.path, []).append(item)
    groups = list(modules.values())
    order.shuffle(groups)
    for group in groups:
        order.shuffle(group)
    items[:] = itertools.chain.from_iterable(groups)


# Without bytecode each worker would compile all tests, and each process that a test starts the whole library.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

_used = [0.0]  # processor time of this process and its children [s], when the last report was made


def _processor_time() -> float:
    return sum(os.times()[:4])


def pytest_runtest_logstart() -> None:
    """A test begins."""
    _used[0] = _processor_time()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Add the processor time of a set-up, test or teardown to its report."""
    report = yield
    now = _processor_time()
    report.cpu, _used[0] = now - _used[0], now  # type: ignore[attr-defined]
    return report


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """List the tests that took most processor time."""
    costs: dict[str, float] = {}
    for report in itertools.chain.from_iterable(terminalreporter.stats.values()):
        if hasattr(report, "cpu"):
            costs[report.nodeid] = costs.get(report.nodeid, 0.0) + report.cpu
    if config.option.cpu:
        terminalreporter.section(f"processor time: {sum(costs.values()):.0f} s in all tests")
        for cost, name in sorted(((cost, name) for name, cost in costs.items()), reverse=True)[: config.option.cpu]:
            terminalreporter.write_line(f"{cost:6.1f} s  {name}")


_numbers = itertools.count()
START = 30.0  # [s]


def new_server_id() -> int:
    """A server id that no other test uses, in this process or in a parallel one."""
    return 1000 + (os.getpid() * 64 + next(_numbers)) % 100_000_000


class GazeboProcess:
    """A running `gazebo`: its server id, and the environment of its clients."""

    def __init__(self, world: Path, arguments: tuple[str, ...], env: dict[str, str], server_id: int) -> None:
        self.id = server_id
        self.env = env
        self.directory = Path(env["TMP"]) / f"gazebo-{env['USER']}-{server_id}"
        command = [sys.executable, "-m", "libgz.apps.gazebo", "-s", str(server_id), *arguments, str(world)]
        self.process = subprocess.Popen(
            command, env=env, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=env["TMP"]
        )

    def wait_ready(self) -> None:
        """Wait until `sim` is served.

        Raises:
            AssertionError: the process ended, or did not serve it in time.
        """
        end = time.monotonic() + START
        while not (self.directory / "sim.default").exists():
            if self.process.poll() is not None:
                raise AssertionError(f"gazebo ended during its start: {self.process.communicate()}")
            assert time.monotonic() < end, "gazebo did not start"
            select.select([], [], [], 0.02)

    def stop(self, number: int = signal.SIGTERM) -> tuple[int, str, str]:
        """End the process with a signal; returns (exit code, stdout, stderr)."""
        if self.process.poll() is None:
            self.process.send_signal(number)
        out, err = self.process.communicate(timeout=START)
        return self.process.returncode, out, err


_servers = Path(os.environ["TMP"])


def pytest_unconfigure() -> None:
    """Remove the place of servers; the tests have looked at what is in it."""
    shutil.rmtree(_servers, ignore_errors=True)


def _dead(server: Path) -> bool:
    """Whether nobody holds the lock of a server's directory."""
    try:
        with (server / LOCK_FILE).open("rb") as lock:
            fcntl.flock(lock, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return server.is_file()  # a directory is about to begin, or to end
    return True


@pytest.fixture(autouse=True)
def no_dead_servers() -> Iterator[None]:
    """Fail where a test leaves the directory of a server that was killed or did not end as it should."""
    yield
    left = [server for server in _servers.iterdir() if _dead(server)]
    for server in left:
        shutil.rmtree(server, ignore_errors=True)
    assert not left, f"servers were killed, and left {', '.join(server.name for server in left)}"


@pytest.fixture
def wire(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[int]:
    """A server id and a TMP for this test only; the test must remove all its files and semaphores."""
    # Directly under /tmp, because paths of the old library are limited to 127 bytes.
    folder = Path("/tmp") / f"gz{os.getpid()}-{next(_numbers)}"
    folder.mkdir(mode=0o700)
    monkeypatch.setenv("TMP", str(folder))
    monkeypatch.setenv("USER", "tester")
    server_id = new_server_id()
    yield server_id
    left = sorted(path.name for path in folder.rglob("*"))
    try:
        SemaphoreSet.attach(server_id).remove()
        left.append(f"semaphores {GZ_SEM_KEY + server_id:#x}")
    except FileNotFoundError:
        pass
    for path in sorted(folder.rglob("*"), reverse=True):
        if path.is_dir() and not path.is_symlink():
            path.rmdir()
        else:
            path.unlink()
    folder.rmdir()
    assert not left, f"not removed: {left}"


@pytest.fixture
def gazebo(wire: int) -> Iterator[Callable[..., GazeboProcess]]:
    """A function that starts `gazebo WORLD [options]` and waits until it is ready."""
    started: list[GazeboProcess] = []

    def start(world: Path, *arguments: str, ready: bool = True) -> GazeboProcess:
        process = GazeboProcess(world, arguments, dict(os.environ), wire + len(started))
        started.append(process)
        if ready:
            process.wait_ready()
        return process

    yield start
    for process in started:
        process.stop()
