"""Replay pages: what a viewer shows over time as one HTML file, which any browser plays without a server."""

from __future__ import annotations

import html
from collections.abc import Iterable

from libgz.view.gate import LEAN_SCRIPT, POLICY
from libgz.view.viewer import Viewer

__all__ = ["replay_page"]


def replay_page(viewer: Viewer, moments: Iterable[float], title: str) -> str:
    """The page of a run.

    Args:
        viewer: of a source that `moments` advances; it waits for answers.
        moments: advances the source with each item, and yields the time of its state [s]; the first one is the start.
        title: of the page.
    """
    recording, before = None, 0.0
    for now in moments:
        if recording is not None:
            recording.insert_sleep(max(now - before, 0.0))
        viewer.frame(now)
        if recording is None:
            recording = viewer.page.get_scene_serializer()
        before = now
    if recording is None:
        viewer.frame()
        recording = viewer.page.get_scene_serializer()
    policy = f'<meta http-equiv="Content-Security-Policy" content="{POLICY.format(socket="")}">'
    script = f"<script>{LEAN_SCRIPT.read_text()}</script>"
    text = recording.as_html().replace("<title>Viser</title>", f"<title>{html.escape(title)}</title>", 1)
    return text.replace("<head>", f"<head>{policy}{script}", 1)
