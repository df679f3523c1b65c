"""What plugins of Gazebo classic share: times, PID controllers, animations, messages, search paths, the globe."""

from __future__ import annotations

from libgz.classic.common.time import Time
from libgz.classic.common.timer import Timer
from libgz.classic.common.update_info import UpdateInfo
from libgz.classic.math.color import Color
from libgz.classic.math.pid import PID

__all__ = ["PID", "Color", "Time", "Timer", "UpdateInfo"]
