"""The page of Player's devices: what each driver reads and writes, and how its messages look, from the declarations."""

from __future__ import annotations

from collections.abc import Iterator

from libgz.player.drivers import DRIVERS, Driver
from libgz.player.messages import Kind, messages_of
from libgz.reference.markdown import NOTE

__all__ = ["player_devices_page"]

SHOWN = ("1.6", "2.0", "2.1")

INTRODUCTION = """\
# Devices of Player

[Player](player.md) explains how they are used. Each section is a driver of configuration files of Player 1.6; those of
Player 2 and 3 name all of them `gazebo`. A request or command that is not listed is refused or ignored.

A cell has the number of the message and its fields, in the order of the wire: `i4` is a whole number of 4 bytes, `u4`
one without a sign, `f8` a floating-point number, `s` a text; `[]` follows what has a count, `[32]` what has that
length, `[*]` the rest; `#ranges` is the number of elements of `ranges`. `*mm` is the unit; without one it is m, rad, s
or V.
"""


def player_devices_page() -> str:
    """The text of the page."""
    lines = [NOTE, INTRODUCTION]
    for driver in DRIVERS:
        lines += _section(driver)
    return "\n".join(lines)


def _section(driver: Driver) -> Iterator[str]:
    key = f", key `{driver.key}`" if driver.key else ""
    of = f"the interface [{driver.source}](structs.md#{driver.source})" if driver.source else "no interface"
    yield f"## {driver.name}{f' {driver.key}' if driver.key else ''}\n"
    yield f"`{driver.kind}`{key}, of {of}. {driver.about}\n"
    yield f"| message | {' | '.join(SHOWN)} |"
    yield f"|---|{'---|' * len(SHOWN)}"
    rows: list[tuple[Kind, str]] = [("data", driver.data)] if driver.data else []
    rows += [("command", name) for name in driver.commands]
    rows += [("request", name) for name in (*driver.requests, *driver.slow)]
    for kind, name in rows:
        cells = [_cell(version, driver.kind, kind, name) for version in SHOWN]
        yield f"| {kind} `{name}` | {' | '.join(cells)} |"
    yield ""


def _cell(version: str, interface: str, kind: Kind, name: str) -> str:
    message = messages_of(version).by_name.get((interface, kind, name))
    if message is None:
        return ""
    number = "" if version == "1.6" and kind != "request" else f"{message.number}: "
    return number + (f"`{message.text}`" if message.text else "no fields")
