"""The tables of docs/ros.md, made from what plugins declare: ``python -m libgz.ros.reference`` writes them."""

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

__all__ = ["device_table", "legacy_service_table", "page", "plugin_table", "service_table"]

BEGIN, END = "<!-- {}: made by python -m libgz.ros.reference -->", "<!-- end of {} -->"


def _plugins() -> Iterator[tuple[str, type[RosPlugin]]]:
    """(name of its file, class) of each plugin."""
    for path in sorted(PLUGINS.glob("[!_]*.py")):
        for _, one in load_plugin(path).registered:
            if isinstance(one, type) and issubclass(one, RosPlugin):
                yield path.stem, one


def plugin_table() -> str:
    """A table of the plugins with their topics and parameters, in Markdown."""
    rows = ["| plugin | topics and services | parameters |", "|---|---|---|"]
    for name, plugin in _plugins():
        others = [other for other, own in STAND_INS.items() if own == name]
        names = ", ".join(f"`lib{one}.so`" for one in (name, *others))
        about = "<br>".join(f"{one.verb} `{one.name}` {one.kind}" for one in plugin.endpoints)
        about += "<br>without `robotNamespace` below `/<model>/`" if plugin.own_namespace else ""
        rows.append(f"| {names} | {about} | {'<br>'.join(map(_described, plugin.parameters))} |")
    return "\n".join(rows)


def _described(parameter: Parameter) -> str:
    text = f"`{parameter.name}`{_default(parameter.default)} {parameter.meaning}"
    if parameter.ros2 is not SAME:
        text += f"; in ROS 2{_default(parameter.ros2).rstrip(':') or ' empty'}"
    return text.replace("|", "\\|")


def _default(value: Any) -> str:
    if isinstance(value, type):
        return " (required):"
    if isinstance(value, bool):
        return f" ({str(value).lower()}):"
    if isinstance(value, str | int | float):
        return f" ({value if isinstance(value, str) else f'{value:g}'}):" if value != "" else ":"
    return ":"


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
        "plugins": plugin_table(),
        "services": service_table(SERVICES),
        "services2": service_table(SERVICES2),
        "devices": device_table(),
        "legacy services": legacy_service_table(),
    }
    for name, table in tables.items():
        text = _with_table(text, name, table)
    return text


if __name__ == "__main__":
    path = Path(sys.argv[1] if len(sys.argv) > 1 else "docs/ros.md")
    path.write_text(page(path.read_text()))
