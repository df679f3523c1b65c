"""Replay pages: what a viewer shows over time as one HTML file, which any browser plays without a server."""

from __future__ import annotations

import base64
import functools
import html
import json
import posixpath
import re
from collections.abc import Iterable, Iterator
from typing import Any

from libgz.view.gate import CLIENT, policy, script_source
from libgz.view.protocol import LONGEST_NAME, MOST_NAMES
from libgz.view.viewer import Viewer

__all__ = ["frame_page", "replay_page"]

CAMERAS, RANGES = ("camera", "guicam", "stereo"), ("laser", "sonar", "ir")
RELATIVE = re.compile(r"""(\bfrom\s*|\bimport\s*)(["'])(\.{1,2}/[^"']+)\2""")
START = "import 'libgz/app.js';"


class _Recorder:
    """A page that keeps what it is sent."""

    number, may_control, visible = 0, False, True

    def __init__(self) -> None:
        self.wants: dict[str, list[str]] = {}
        self.moment: dict[str, str] = {}

    def post(self, key: str, message: bytes | str) -> None:
        """Keep the last message of a key."""
        if key.startswith(("scene", "state", "image ", "ranges", "contacts")):
            text = message if isinstance(message, str) else base64.b64encode(message).decode()
            self.moment.pop(key, None)
            self.moment[key] = text

    def want(self, scene: dict[str, Any], switches: Iterable[str]) -> None:
        """Want what the switches show."""
        names: dict[str, set[str]] = {"images": set(), "ranges": set()}
        for entity in scene["entities"]:
            for served in entity["interfaces"]:
                if served["type"] in CAMERAS:
                    names["images"].add(served["id"])
                elif served["type"] in RANGES:
                    names["ranges"].add(f"{served['type']}.{served['id']}")
            for sensor in entity["sensors"]:
                if "name" in sensor:
                    body = next((body["name"] for body in entity["bodies"] if body["id"] == sensor["body"]), "")
                    name = f"{entity['id']}::{body}::{sensor['name']}"
                    names["images" if sensor.get("cameras") else "ranges"].add(name)
        shown = {"images": "frusta" in switches, "ranges": bool({"lasers", "sonars"} & {*switches})}
        for channel, wanted in names.items():
            if shown.get(channel):
                fitting = [name for name in sorted(wanted) if len(name) <= LONGEST_NAME]
                self.wants[channel] = fitting[:MOST_NAMES]


def replay_page(viewer: Viewer, moments: Iterable[float], title: str, switches: Iterable[str] = ()) -> str:
    """The page of a run.

    Args:
        viewer: of a source that `moments` advances; it waits for answers.
        moments: advances the source with each item, and yields the time of its state [s]; the first one is the start.
        title: of the page.
        switches: what is shown beside the scene: lasers, sonars, frusta, contacts, trails ...
    """
    recorder = _Recorder()
    found: list[Any] = []
    assets: dict[str, str] = {}
    shown = tuple({"joints": "axes"}.get(name, name) for name in switches)
    viewer.show_to(recorder)
    for now in moments:
        if not found:
            viewer.frame(now - 1.0)  # the scene says what there is to want
            recorder.want(viewer.scene, shown)
        viewer.frame(now)
        found.append([round(now, 4), recorder.moment])
        recorder.moment = {}
        assets |= {name: "" for name in viewer.asset_names if name not in assets}
        for name, text in assets.items():
            asset = viewer.assets.get(name) if not text else None
            if asset is not None:
                assets[name] = base64.b64encode(asset.body).decode()
    recording = {"title": title, "switches": shown, "moments": found, "assets": {k: v for k, v in assets.items() if v}}
    text = json.dumps(recording).replace("<", "\\u003c")
    return _page(title, f'<script type="application/json" id="recording">{text}</script>')


@functools.cache
def frame_page(title: str) -> str:
    """A page for a frame, whose messages come over a port from the document around it."""
    return _page(title, '<script type="application/json" id="port"></script>')


def _page(title: str, content: str) -> str:
    """The page as one file: its modules are addresses of data in the import map."""
    imports = {name: _address(text, "text/javascript") for name, text in _modules()}
    scripts = json.dumps({"imports": imports})
    styles = "".join((CLIENT / name).read_text() for name in ("vendor/uplot/uPlot.min.css", "style.css"))
    rules = policy(f"data: {script_source(scripts)} {script_source(START)}", script_source(styles), "'none'")
    rules = rules.replace("'none' data: blob:;", "data: blob:;").replace("'self' data: blob:", "data: blob:")
    icon = _address((CLIENT / "icon.svg").read_text(), "image/svg+xml")
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta http-equiv="Content-Security-Policy" content="{rules}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<title>{html.escape(title)}</title><link rel="icon" href="{icon}"><style>{styles}</style>'
        f'<script type="importmap">{scripts}</script>'
        f"{content}"
        f'<script type="module">{START}</script></head><body></body></html>\n'
    )


def _address(text: str, kind: str) -> str:
    return f"data:{kind};base64,{base64.b64encode(text.encode()).decode()}"


def _modules() -> Iterator[tuple[str, str]]:
    """The page's modules and those that it is made with, by the names that they import each other by."""
    for path in sorted(CLIENT.rglob("*.js")):
        name = path.relative_to(CLIENT).as_posix()
        folder = posixpath.dirname(name)
        text = path.read_text()
        if folder:  # what is not ours names files beside it by relative paths, which data has not
            text = RELATIVE.sub(functools.partial(_absolute, folder), text)
        yield _bare(name), text


def _absolute(folder: str, found: re.Match[str]) -> str:
    return f"{found[1]}{found[2]}{_bare(posixpath.normpath(f'{folder}/{found[3]}'))}{found[2]}"


def _bare(path: str) -> str:
    """The name of a module in the import map."""
    if not path.startswith("vendor/"):
        return f"libgz/{path}"
    known = {"vendor/three/three.module.min.js": "three", "vendor/uplot/uPlot.esm.js": "uplot"}
    return known.get(path) or path.replace("vendor/three/addons/", "three/addons/", 1)
