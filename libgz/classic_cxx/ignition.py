"""IgnitionTransport: joint commands by the library with which Gazebo 11's tools and plugins send them.

Its native part is a shared object of its own, which is built with the library where ignition-transport is installed.
What comes by it is delivered in an iteration ahead of its joint controllers, in the world's thread.
"""

from __future__ import annotations

import atexit
import ctypes
import logging
import os
import re
import threading
from ctypes import CFUNCTYPE, c_char_p, c_int, c_size_t, c_void_p
from pathlib import Path
from typing import TYPE_CHECKING, Any

from libgz.base.errors import LibraryError
from libgz.classic.msgs import message_type
from libgz.classic.physics.model import Model
from libgz.classic.transport.manager import TopicManager
from libgz.classic.transport.topic import Incoming, Topic, sequence
from libgz.simulation.world import World as CoreWorld
from libgz.transport.tally import Tally

if TYPE_CHECKING:
    from libgz.classic.physics import World

__all__ = ["IgnitionTransport"]

log = logging.getLogger("libgz.plugin")

JOINTS = re.compile(r"/gazebo/[^/]+/(.+)/joint_cmd")
PATIENCE = 1.0  # [s] that a request waits for the world's step
COMMAND = CFUNCTYPE(None, c_char_p, c_void_p, c_size_t, c_int)
REQUEST = CFUNCTYPE(c_int, c_char_p, c_char_p, c_void_p)


class IgnitionTransport:
    """Lets the joints of all models be commanded on ``/MODEL/joint_cmd``, and asked for by ``/MODEL/joint_cmd_req``.

    Args:
        library: the native part.

    Raises:
        LibraryError: it cannot be loaded.
    """

    _running: IgnitionTransport | None = None

    def __init__(self, library: Path) -> None:
        try:
            # Without the interpreter's lock: its threads call back.
            self._functions = ctypes.CDLL(str(library), mode=os.RTLD_NOW)
        except OSError as error:
            raise LibraryError(f"ignition-transport cannot be used: {error}") from None
        self._functions.libgz_ignition_open.restype = c_void_p
        self._functions.libgz_ignition_open.argtypes = [c_char_p, COMMAND, REQUEST]
        self._functions.libgz_ignition_close.restype = None
        self._functions.libgz_ignition_close.argtypes = [c_void_p]
        self._functions.libgz_ignition_reply.restype = None
        self._functions.libgz_ignition_reply.argtypes = [c_void_p, c_char_p, c_size_t]
        self._callbacks = COMMAND(self._on_command), REQUEST(self._on_request)
        self._manager = TopicManager.Instance()
        # Topic of classic -> model, and its native object, which one topic of a model has; None if it was refused.
        self._opened: dict[str, tuple[str, int | None]] = {}
        self._lock = threading.Lock()  # of that table; callbacks of ignition-transport must not wait for it
        self._tally = Tally(100)
        self._manager.watch(self._match)
        atexit.register(self.close)

    @classmethod
    def start(cls, library: Path) -> IgnitionTransport:
        """The one of this process; its topics are opened when it is first asked for.

        Raises:
            LibraryError: it cannot be loaded.
        """
        if cls._running is None:
            cls._running = cls(library)
        return cls._running

    def close(self) -> None:
        """Close all topics; those that are subscribed to later are not opened."""
        self._manager.unwatch(self._match)
        with self._lock:
            for topic in list(self._opened):
                self._close(topic)

    def _match(self, topic: Topic) -> None:
        """Open the topic of a model whose commands classic's topics take, or close it."""
        found = JOINTS.fullmatch(topic.name)
        if found is None:
            return
        with self._lock:
            if not topic.subscribers:
                self._close(topic.name)
            elif topic.name not in self._opened:
                self._open(topic.name, found[1])

    def _open(self, topic: str, model: str) -> None:
        joints = None
        if all(model != name for name, _ in self._opened.values()):  # another world may have one of that name
            joints = self._functions.libgz_ignition_open(model.encode(errors="surrogateescape"), *self._callbacks)
            if joints is None:
                log.warning("ignition-transport has no topic /%s/joint_cmd: the name is not allowed there", model)
        self._opened[topic] = model, joints

    def _close(self, topic: str) -> None:
        model, joints = self._opened.pop(topic, (topic, None))
        if joints is None:
            return
        heir = next((name for name, (other, _) in self._opened.items() if other == model), None)
        if heir is not None:
            self._opened[heir] = model, joints
        else:
            self._functions.libgz_ignition_close(joints)

    def _on_command(self, model: bytes, data: int, size: int, inside: int) -> None:
        """Queue a command; threads of ignition-transport call this."""
        if not inside and self._manager.remote is not None and self._manager.remote.watch_only:
            if self._tally.due(model):
                log.warning("this server can only be watched: /%s/joint_cmd is ignored", model.decode(errors="replace"))
            return
        name, text = model.decode(errors="surrogateescape"), ctypes.string_at(data, size)
        spaces = {world.core.topic_space: world for world in _served()}  # worlds of one name share their topics
        for space, world in spaces.items():
            topic = self._manager.topics.get(f"/gazebo/{space}/{name}/joint_cmd")
            if topic is not None:
                message = Incoming(next(sequence), "gazebo.msgs.JointCmd", text, None)
                self._manager.receive(topic, message, world.server.activity.waiting)

    def _on_request(self, model: bytes, joint: bytes, reply: int) -> int:
        """Answer what is set for a joint; threads of ignition-transport call this."""
        name = model.decode(errors="surrogateescape").replace("/", "::")
        for world in _served():
            if not world.core.lock.wait(PATIENCE):  # the step may be closing a topic, and wait for this thread
                return 0
            try:
                found = world.BaseByName(name)
                if isinstance(found, Model):
                    data = _settings(found, joint.decode(errors="surrogateescape"))
                    self._functions.libgz_ignition_reply(reply, data, len(data))
                    return 1
            finally:
                world.core.lock.release()
        return 0


def _served() -> list[World]:
    """The worlds with topics. Others get none here, in a thread that does not hold their locks."""
    return [core.facade for core in CoreWorld.all_running() if core.facade is not None]


def _settings(model: Model, joint: str) -> bytes:
    """What a model's controller has for a joint, as an encoded JointCmd."""
    controller = model.GetJointController()
    message: Any = message_type("JointCmd")(name=joint)
    if joint in controller.GetForces():
        message.force = controller.GetForces()[joint]
    for part, pids, targets in (
        (message.position, controller.GetPositionPIDs(), controller.GetPositions()),
        (message.velocity, controller.GetVelocityPIDs(), controller.GetVelocities()),
    ):
        if joint in targets:
            part.target = targets[joint]
        if joint in pids:
            pid = pids[joint]
            part.p_gain, part.i_gain, part.d_gain = pid.GetPGain(), pid.GetIGain(), pid.GetDGain()
    return bytes(message.SerializeToString())
