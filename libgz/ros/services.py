"""Services: what those of /gazebo have in common in both eras: refusals, wrenches that last, vectors and poses."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar

from libgz.base.errors import GazeboError
from libgz.classic.math import Pose3d, Quaterniond, Vector3d
from libgz.ros.session import Later, Service, Session, Subscription, finite
from libgz.ros.types import Message, service_type
from libgz.simulation.repeated import repeated

if TYPE_CHECKING:
    from libgz.ros.own_node import OwnNode
    from libgz.simulation.world import World

__all__ = ["INERTIAL", "RefusedError", "Services", "pose_of", "vector"]

log = logging.getLogger("libgz.ros")

INERTIAL = ("", "world", "map", "/map")  # names of the world's frame
MOST_JOBS = 1000


class RefusedError(GazeboError):
    """A request that cannot be granted; its text is the status message."""


class _Job:
    """A wrench or effort that is applied for a time.

    Args:
        name: of its link or joint.
        apply: applies it once.
        begin, duration: when [s]; a negative duration lasts until it is cleared.
    """

    def __init__(self, name: str, apply: Callable[[], object], begin: float, duration: float) -> None:
        self.name, self.apply, self.begin = name, apply, begin
        self.end = math.inf if duration < 0.0 else begin + duration


class Services:
    """Serves services of gazebo_ros: the method ``_name`` of a subclass answers the service ``name``.

    A method gets request and response, and fills the response; it may return a `Later`. In ROS 1 they are below the
    name of the server's node; in ROS 2 in its namespace, but for those that this process serves already.

    Args:
        session: serves them.
        core: the world.
        space: of ROS 2: another namespace.
        node: of ROS 2, whose services they are; None: that of the server.

    Attributes:
        services: their names -> their types.
        topics: of ROS 1, by which the services of the same names can be asked, too -> their types.
        jobs: the wrenches and efforts that are applied.
    """

    services: ClassVar[Mapping[str, str]] = {}
    topics: ClassVar[Mapping[str, str]] = {}

    def __init__(self, session: Session, core: World, space: str = "", node: OwnNode | None = None) -> None:
        self.session, self.core = session, core
        self.jobs: list[_Job] = []
        self._asked: dict[str, int] = {}  # how often the state of each model was asked for
        self._kept: list[Service | Subscription] = []
        for name, kind in self.services.items():
            if session.version == 1:
                self._kept.append(session.serve(f"~{name}", kind, self.handler(name)))
                continue
            full = f"{space}/{name}" if space else name
            if not session.served(full, node):
                self._kept.append(session.serve(full, kind, self.handler(name), node=node))
        if session.version == 1:
            for name, kind in self.topics.items():
                self._kept.append(session.subscribe(f"~{name}", kind, partial(self.set_by_topic, name), 10))

    def end(self) -> None:
        """Serve and subscribe no longer: the world ends."""
        self.jobs.clear()
        for one in self._kept:
            one.end()

    def handler(self, name: str) -> Callable[[Any], Message | Later]:
        """What answers a service; a refusal is a response, too."""
        method, response = getattr(self, f"_{name}"), service_type(self.services[name], self.session.version).response

        def handle(request: Any) -> Message | Later:
            answer = response()
            if not finite(request):
                return self.refuse(answer, f"{name}: the request has a number that is not finite")
            try:
                later = method(request, answer)
            except RefusedError as refusal:
                return self.refuse(answer, str(refusal))
            except GazeboError as error:
                return self.refuse(answer, f"{name}: {error}")
            return later if isinstance(later, Later) else answer

        return handle

    def refuse(self, answer: Any, text: str) -> Message:
        """A response that says why a request is not granted; it is logged, the same one at growing counts only."""
        with repeated(self.session.tally):
            log.error("%s", text)
        if hasattr(answer, "success"):
            answer.success = False
        if hasattr(answer, "status_message"):  # not all of ROS 2 have it
            answer.status_message = text
        return answer  # type: ignore[no-any-return]

    def set_by_topic(self, name: str, state: Any) -> None:
        """Do what the message of a topic asks for, as the service of this name would."""
        request = service_type(self.services[name]).request(**{name.removeprefix("set_"): state})
        answer: Any = self.handler(name)(request)
        if not answer.success:
            self.session.log_refusal(name, answer.status_message)

    # Wrenches and efforts ----------------------------------------------------------------------------------------

    def add_job(self, name: str, apply: Callable[[], object], request: Any) -> None:
        """Apply something from the start of a request on, for its duration.

        Raises:
            RefusedError: there are too many.
        """
        if len(self.jobs) >= MOST_JOBS:
            raise RefusedError(f"there are {MOST_JOBS} wrenches and efforts already; clear some")
        begin = max(request.start_time.seconds, self.core.GetSimTime())
        self.jobs.append(_Job(name, apply, begin, request.duration.seconds))

    def clear(self, name: str) -> None:
        """Apply no more to a link or joint."""
        self.jobs = [job for job in self.jobs if job.name != name]

    def apply(self, now: float) -> None:
        """Apply the wrenches and efforts of sim time `now` [s], and forget those that are over."""
        self.jobs = [job for job in self.jobs if now <= job.end]
        for job in list(self.jobs):
            if job.begin > now:
                continue
            try:
                job.apply()
            except GazeboError as error:  # its link or joint is gone
                log.warning("the effort on %s ends: %s", job.name, error)
                self.jobs.remove(job)


def vector(value: Any) -> Vector3d:
    """A Point or Vector3."""
    return Vector3d(value.x, value.y, value.z)


def pose_of(value: Any) -> Pose3d:
    """A Pose; a quaternion of zeros is no rotation."""
    turn = value.orientation
    numbers = turn.w, turn.x, turn.y, turn.z
    rotation = Quaterniond(*numbers) if any(numbers) else Quaterniond(1.0, 0.0, 0.0, 0.0)
    rotation.Normalize()
    return Pose3d(vector(value.position), rotation)
