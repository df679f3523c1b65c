"""docs/ros_plugins.md and lists of docs/ros.md, from declarations: ``python -m libgz.ros.reference`` writes them."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from libgz.ros.api import SERVICES
from libgz.ros.api2 import SERVICES2
from libgz.ros.legacy.api import SERVICES as LEGACY_SERVICES
from libgz.ros.legacy.kinds import KINDS
from libgz.ros.plugin import SAME, Parameter, RosPlugin
from libgz.ros.server import PLUGINS, STAND_INS
from libgz.simulation.plugins import load_plugin

__all__ = ["device_table", "legacy_service_table", "page", "plugin_page", "service_table"]

BEGIN, END = "<!-- {}: made by python -m libgz.ros.reference -->", "<!-- end of {} -->"
SHARED = 5  # parameters of another plugin that are not described again, at least
INTRODUCTION = """\
# The plugins of ROS

[Your ROS robot in libgz](ros.md) says how worlds with these plugins run. Topics, types and parameters are those of
gazebo_ros_pkgs. `<x>` in the name of a topic stands for the value of parameter x; `robotNamespace` comes before names
that do not begin with `/`. Elements may also have their names in ROS 2, such as `update_rate` for `updateRate`.
This page is made by `python -m libgz.ros.reference`.
"""


def _plugins() -> Iterator[tuple[str, type[RosPlugin]]]:
    """(name of its file, class) of each plugin."""
    for path in sorted(PLUGINS.glob("[!_]*.py")):
        for _, one in load_plugin(path).registered:
            if isinstance(one, type) and issubclass(one, RosPlugin):
                yield path.stem, one


def plugin_page() -> str:
    """The page of the plugins with their topics and parameters, in Markdown."""
    parts: list[str] = [INTRODUCTION]
    before: dict[str, tuple[Parameter, ...]] = {}
    for name, plugin in _plugins():
        others = ", ".join(f"`lib{other}.so`" for other, own in STAND_INS.items() if own == name)
        parts += [f"## lib{name}.so", _sentence(plugin) + (f" The same: {others}." if others else "")]
        about = [f"- {one.verb} `{one.name}` {one.kind}" for one in plugin.endpoints]
        about += ["- without `robotNamespace` below `/<model>/`"] if plugin.own_namespace else []
        parts += ["\n".join(about)] if about else []
        parts += _parameters(plugin.parameters, before)
        before[name] = plugin.parameters
    return "\n\n".join(map(str.strip, parts)) + "\n"


def _sentence(plugin: type[RosPlugin]) -> str:
    return " ".join((plugin.__doc__ or "").partition("\n\n")[0].split())


def _parameters(parameters: tuple[Parameter, ...], before: Mapping[str, tuple[Parameter, ...]]) -> Iterator[str]:
    """A table, without those that the most similar of the plugins before has, which are listed."""
    near = max(before, key=lambda name: sum(one in before[name] for one in parameters), default="")
    shared = [one for one in parameters if near and one in before[near]]
    if len(shared) < SHARED:
        shared = []
    own = [one for one in parameters if one not in shared]
    if own:
        yield "\n".join(["| parameter | default | in ROS 2 | |", "|---|---|---|---|", *map(_row, own)])
    if shared:
        listed = ", ".join(f"`{one.name}`" for one in shared)
        yield f"As those of [lib{near}.so](#lib{near}so): {listed}."


def _row(parameter: Parameter) -> str:
    other = "" if parameter.ros2 is SAME else _default(parameter.ros2) or "none"
    row = f"| `{parameter.name}` | {_default(parameter.default)} | {other} | "
    return row + parameter.meaning.replace("|", "\\|") + " |"


def _default(value: Any) -> str:
    if isinstance(value, type):
        return "must be given"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return value
    return f"{value:g}" if isinstance(value, int | float) else ""


def service_table(services: Mapping[str, str]) -> str:
    """A list of services, in Markdown."""
    return ", ".join(f"`{name}` ({kind.removeprefix('gazebo_msgs/')})" for name, kind in services.items())


def device_table() -> str:
    """A table of what the interfaces of legacy models are, in Markdown; topics lie below ``/<id>/``."""
    rows = ["| interface | publishes | takes |", "|---|---|---|"]
    for name, kind in sorted(KINDS.items()):
        given = [f"`{one.topic}` {one.kind}" for one in kind.streams]
        taken = [f"`{one.topic}` {one.kind}" for one in kind.orders]
        taken += ["action `gripper_cmd` control_msgs/GripperCommand"] if kind.grips else []
        taken += [f"service `{one.name}` std_srvs/Empty" for one in kind.switches]
        rows.append(f"| {name}: {kind.about} | {'<br>'.join(given)} | {'<br>'.join(taken)} |")
    return "\n".join(rows)


def legacy_service_table() -> str:
    """A list of the services of /gazebo for legacy worlds, in Markdown."""
    return ", ".join(f"`{name}`" for name in LEGACY_SERVICES)


def _with_table(text: str, name: str, table: str) -> str:
    begin, end = BEGIN.format(name), END.format(name)
    before, _, rest = text.partition(begin)
    _, _, after = rest.partition(end)
    return f"{before}{begin}\n\n{table}\n\n{end}{after}"


def page(text: str) -> str:
    """A page with its tables as they should be."""
    tables = {
        "services": service_table(SERVICES),
        "services2": service_table(SERVICES2),
        "devices": device_table(),
        "legacy services": legacy_service_table(),
    }
    for name, table in tables.items():
        text = _with_table(text, name, table)
    return text


if __name__ == "__main__":
    docs = Path(sys.argv[1] if len(sys.argv) > 1 else "docs")
    guide = docs / "ros.md"
    guide.write_text(page(guide.read_text()))
    (docs / "ros_plugins.md").write_text(plugin_page())
