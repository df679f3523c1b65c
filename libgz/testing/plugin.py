"""The pytest plugin: the fixture `libgz_world`, and the option --libgz-record. pytest finds it as an entry point.

PYTEST_DONT_REWRITE
"""

from __future__ import annotations

import contextlib
from collections.abc import Generator, Iterator
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:  # imported when a test uses the fixture: other tests do not pay for it
    from libgz.testing.record import Record
    from libgz.testing.worlds import Worlds

__all__ = ["libgz_world", "pytest_addoption", "pytest_runtest_makereport"]

_worlds: pytest.StashKey[Worlds] = pytest.StashKey()
_record: pytest.StashKey[Record] = pytest.StashKey()


def pytest_addoption(parser: pytest.Parser) -> None:
    """The options --libgz-record and --libgz-record-dir."""
    add = parser.getgroup("libgz").addoption
    add("--libgz-record", action="store_true", help="keep images of the worlds of failing tests, and what libgz logged")
    add("--libgz-record-dir", default="libgz-record", metavar="DIR", help="the folder for them (default libgz-record)")


@pytest.fixture
def libgz_world(request: pytest.FixtureRequest) -> Iterator[Worlds]:
    """Start worlds: `world = libgz_world("my.world")` is strict, has a free server id, and ends with the test."""
    from libgz.testing.worlds import Worlds

    worlds = request.node.stash[_worlds] = Worlds(request.path.parent)
    if not request.config.option.libgz_record:
        yield worlds
        worlds.close()
        return
    from libgz.testing.record import Record

    with contextlib.closing(Record()) as record:
        request.node.stash[_record] = record
        yield worlds
        worlds.close()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Keep images and logs of a test that failed; its worlds still exist."""
    report = yield
    record = item.stash.get(_record, None)
    if report.failed and record is not None:
        folder = item.config.rootpath / item.config.option.libgz_record_dir
        try:
            place = record.save(folder, item.nodeid, str(report.longrepr), item.stash[_worlds].started)
            report.sections.append(("libgz", f"images and log are in {place}"))
        except OSError as error:
            report.sections.append(("libgz", f"images and log cannot be kept: {error}"))
    return report
