"""What a server does with logs when it is told to by messages: record a world, or play."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import TYPE_CHECKING, Any

from libgz.classic import msgs
from libgz.classic.log.record import LogRecord
from libgz.classic.server import attach
from libgz.classic.transport import Node
from libgz.errors import GazeboError

if TYPE_CHECKING:
    from libgz.classic.log.play import LogPlay
    from libgz.classic.physics.world import World

__all__ = ["PlaybackControl", "RecordControl"]

log = logging.getLogger("libgz.classic")


class RecordControl:
    """``~/log/control`` of a world: begins and ends logs. ``~/log/status`` tells where the log is."""

    def __init__(self, world: World, record: LogRecord | None = None) -> None:
        self._world, self.record = world, record
        self._node = Node()
        self._node.Init(world.Name())
        self._status = self._node.Advertise(msgs.LogStatus, "~/log/status")
        self._subscriber = self._node.Subscribe("~/log/control", self._on_control)

    def _on_control(self, message: Any) -> None:
        if message.stop or message.start:
            self._stop()
        if message.start:
            path = Path(message.base_path) / "state.log" if message.base_path else None
            try:
                self.record = LogRecord(self._world, path, encoding=message.encoding or "zlib")
                log.info("recording to [%s]", self.record.path)
            except GazeboError as error:
                log.error("~/log/control: %s", error)
        self._tell()

    def _stop(self) -> None:
        record, self.record = self.record, None
        if record is not None and record.running:
            record.Stop()
            log.info("recorded to [%s]", record.path)

    def _tell(self) -> None:
        status = msgs.LogStatus()
        msgs.Set(status.sim_time, self._world.SimTime())
        if self.record is not None and self.record.running:
            path = self.record.path
            status.log_file.uri = status.log_file.full_path = str(path)
            status.log_file.base_path = str(path.parent)
            status.log_file.size = float(path.stat().st_size) if path.exists() else 0.0
        self._status.Publish(status)

    def close(self) -> None:
        """End the log, and listen no more."""
        self._stop()
        self._subscriber.Unsubscribe()
        self._node.Fini()


class PlaybackControl:
    """``~/playback_control`` of a log that is played: pause, steps, rewind, forward, seek."""

    def __init__(self, play: LogPlay) -> None:
        self._play = play
        self._waiting: list[Any] = []
        self._node = Node()
        self._node.Init(play.world.Name())
        self._subscriber = self._node.Subscribe("~/playback_control", self._waiting.append)

    def update(self) -> None:
        """Act on what was told, between steps: within one models come and go only at its end."""
        waiting, self._waiting[:] = list(self._waiting), []
        for message in waiting:
            try:
                self._act(message)
            except GazeboError as error:
                log.error("~/playback_control: %s", error)

    def _act(self, message: Any) -> None:
        play = self._play
        if message.rewind:
            play.Rewind()
        if message.forward:
            play.Forward()
        if message.HasField("seek"):
            play.Seek(msgs.ConvertIgn(message.seek).Double())
        if message.HasField("pause"):
            play.core.paused = message.pause
        if message.multi_step > 0:
            attach(play.core).paused_steps.add(message.multi_step)
        elif message.multi_step < 0:
            play.StepBack(-message.multi_step)

    def close(self) -> None:
        """Listen no more."""
        self._subscriber.Unsubscribe()
        self._node.Fini()
