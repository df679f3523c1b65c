"""RecordControl and PlaybackControl: the topics that control logs."""

from __future__ import annotations

import logging
import math
import time
from collections import deque
from pathlib import Path
from typing import TYPE_CHECKING, Any

from libgz.base.errors import GazeboError
from libgz.classic import log as logs, msgs
from libgz.classic.log.file import log_folder
from libgz.classic.physics.world import World
from libgz.classic.server import attach
from libgz.classic.transport import Node, TopicManager
from libgz.classic.transport.address import publicized_address
from libgz.classic.transport.received import COUNT

if TYPE_CHECKING:
    from libgz.classic.log import LogPlay, LogRecord

__all__ = ["PlaybackControl", "RecordControl"]

log = logging.getLogger("libgz.classic")

STATUS_PERIOD = 1.0  # [s] of real time
UNITS = ("BYTES", "K_BYTES", "M_BYTES", "G_BYTES")


class RecordControl:
    """Starts, pauses and ends logs of a world by ``~/log/control``, and publishes path and size on ``~/log/status``.

    While a log is recorded, that is published once a second of real time, too.
    """

    def __init__(self, world: World, record: LogRecord | None = None) -> None:
        self._world, self.record = world, record
        self._base: Path | None = None  # where a client wants the log; None: in the folder of logs
        self._due = 0.0
        self._node = Node()
        self._node.Init(world.core.topic_space)
        self._status = self._node.Advertise(msgs.LogStatus, "~/log/status")
        self._subscriber = self._node.Subscribe("~/log/control", self._on_control, kind="LogControl")
        self._watch()

    def _watch(self) -> None:
        if self.record is not None:
            self.record.on_step = self._on_step

    def _on_step(self) -> None:
        now = time.monotonic()
        if self.record is not None and now >= self._due and self._status.HasConnections():
            self._publish_status()

    def _on_control(self, message: Any) -> None:
        if message.stop or message.start:
            self._stop()
        if message.start:
            self._base = Path(message.base_path) if message.base_path else None
            path = self._base / "state.log" if self._base is not None else None
            try:
                self.record = logs.LogRecord(self._world, path, encoding=message.encoding or "zlib")
                log.info("recording to [%s]", self.record.path)
                self._watch()
            except GazeboError as error:
                TopicManager.Instance().received.refuse("~/log/control", str(error))
        if message.HasField("paused") and self.record is not None:
            self.record.paused = message.paused
        self._publish_status()

    def _stop(self) -> None:
        record, self.record = self.record, None
        if record is not None and record.running:
            record.Stop()
            log.info("recorded to [%s]", record.path)

    def _publish_status(self) -> None:
        self._due = time.monotonic() + STATUS_PERIOD
        status = msgs.LogStatus()
        msgs.Set(status.sim_time, self._world.SimTime())
        file, size = status.log_file, 0.0
        if self.record is not None and self.record.running:
            path = self.record.path
            file.full_path = str(path)
            size = float(path.stat().st_size) if path.exists() else 0.0
        file.uri, file.base_path, file.record_resources = publicized_address(), f"{self._base or log_folder()}/", False
        power = min(3, max(0, int(math.log10(max(size, 1.0))) // 3))
        file.size, file.size_units = size / 1000.0**power, UNITS[power]
        self._status.Publish(status)

    def close(self) -> None:
        """End the log, and unsubscribe."""
        self._stop()
        self._subscriber.Unsubscribe()
        self._node.Fini()


class PlaybackControl:
    """Controls the playback of a log by ``~/playback_control``: pause, steps, rewind, forward, seek."""

    def __init__(self, play: LogPlay) -> None:
        self._play = play
        self._received: deque[Any] = deque(maxlen=COUNT)
        self._node = Node()
        self._node.Init(play.world.core.topic_space)
        self._subscriber = self._node.Subscribe("~/playback_control", self._received.append, kind="LogPlaybackControl")

    def update(self) -> None:
        """Execute the received commands, between steps: within a step, models are added and removed only at its end.

        Each may take as long as the log: those for which there is no time wait.
        """
        manager = TopicManager.Instance()
        allowance = manager.allowance
        allowance.begin()
        while self._received and allowance.left:
            try:
                self._execute(self._received.popleft())
            except GazeboError as error:
                manager.received.refuse("~/playback_control", str(error))
            allowance.spend()

    def _execute(self, message: Any) -> None:
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
        """Unsubscribe."""
        self._subscriber.Unsubscribe()
        self._node.Fini()
