"""RosWorld: a world as ROS sees it: its clock, the states of its models and links, and its services."""

from __future__ import annotations

import functools
import logging
import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from libgz.base.law import Number, law, rarely
from libgz.classic.server import attach
from libgz.ros.api import WorldApi
from libgz.ros.api2 import WorldApi2
from libgz.ros.legacy.api import LegacyApi, list_links, list_models
from libgz.ros.legacy.api2 import LegacyApi2
from libgz.ros.legacy.device import Devices
from libgz.ros.metrics import Metrics
from libgz.ros.node_parameters import NodeParameters
from libgz.ros.own_node import OwnNode
from libgz.ros.packed import PackedMessage
from libgz.ros.plugin import Ticks, bounded_rate
from libgz.ros.services import Services
from libgz.ros.session import Session
from libgz.ros.states import Listed, States
from libgz.simulation.companion import Stateless
from libgz.simulation.event import unowned

if TYPE_CHECKING:
    from libgz.classic.sensors import Sensor
    from libgz.front import World
    from libgz.simulation.entity import Entity
    from libgz.simulation.plan import Plan

__all__ = ["RosWorld", "classic_links", "classic_models"]

log = logging.getLogger("libgz.ros")

CLOCK1, CLOCK2 = ("~pub_clock_frequency", 0.0), ("~publish_rate", 10.0)  # parameter, default [Hz]; 0: each iteration
METRICS = "enable_performance_metrics"
STATES_RATE = 100.0  # [Hz] in ROS 2


class RosWorld(Stateless):
    """Publishes /clock, the states of models and links, and the devices of legacy models; serves; delivers messages.

    While nobody listens and nothing has come, steps are made without it.

    Args:
        session: of this process.
        core: the engine's world.
    """

    _hurried = Number()  # whether messages may wait for others

    def __init__(self, session: Session, core: World) -> None:
        self._session, self._core = session, core
        more: dict[str, Any] = {"reliability": "best_effort"} if session.version == 2 else {}
        with unowned():
            self._clock = session.publish(
                "/clock", "rosgraph_msgs/Clock", 1 if more else 10, changed=core.update_rows_changed, **more
            )
        self._ticks = Ticks(0.0)
        self._time = PackedMessage(self._clock, self._clock.kind())
        self._states: list[States] = []
        self._states_ticks = Ticks(0.0)
        self._metrics: Metrics | None = None
        self._parameters: NodeParameters | None = None
        self._services: Services | None = None
        self._devices = Devices(session, core)
        core.companions.append(self)
        session.interrupts.append(core.lock.interrupt)
        session.node.follow_pace(lambda: not core.paced)

    # Companion of the world --------------------------------------------------------------------------------------

    def start(self) -> None:
        """Advertise topics and services; all models are loaded."""
        session, two = self._session, self._session.version == 2
        self._parameters = _own_parameters(session) if two else None
        self._ticks = Ticks(_rate(session, *(CLOCK2 if two else CLOCK1)))
        self._states_ticks = Ticks(STATES_RATE if two else 0.0)
        if session.parameter("~enable_ros_network", True) is False:
            return
        era = _Classic(self._core) if self._core.sdf is not None else _Legacy(self._core)
        with unowned():
            prefix, depth = ("", 1) if two else ("~", 10)
            models = session.publish(f"{prefix}model_states", "gazebo_msgs/ModelStates", depth)
            links = session.publish(f"{prefix}link_states", "gazebo_msgs/LinkStates", depth)
            self._states = [States(self._core, models, era.models), States(self._core, links, era.links)]
            if two or session.parameter("~enable_performance_metrics", True) is not False:
                self._metrics = Metrics(session, f"{prefix}performance_metrics", era.sensors)
            self._services = era.serve(session)

    def model_added(self, model: Entity) -> None:
        """The list of models has changed."""
        self._forget()

    def model_removed(self, model: Entity) -> None:
        """The list of models has changed."""
        self._forget()

    def _forget(self) -> None:
        self._devices.stale = True
        for states in self._states:
            states.forget()

    def returned(self) -> None:
        """Send what native code has published."""
        self._session.flush()

    def idle_until(self) -> float:
        """-inf while states are listened to or something waits; else without end: what comes interrupts the steps."""
        self._hurried = float(not self._core.paced)
        states = any(states.publication.listened for states in self._states)
        jobs = self._services is not None and self._services.jobs
        metrics = self._metrics is not None and self._metrics.listened
        busy = self._session.pending or states or metrics or jobs or self._devices.busy
        return -math.inf if busy else math.inf

    def plan_end(self, plan: Plan) -> None:
        """Add the clock, to be published after those steps that are made without the rest."""
        if self._clock.listened:
            with plan.when(self._clock_is_due):
                plan.call(self._send_clock)
        if self._session.version == 1:
            plan.call(self._send_at_once)

    @law
    def _clock_is_due(self) -> Any:
        return self._ticks.is_due(self._core.clock.sim_time)

    @law
    def _send_clock(self) -> None:
        now = self._core.clock.sim_time
        self._ticks.tick(now)
        self._time.stamp(now, "clock")
        self._time.send()

    @law
    def _send_at_once(self) -> None:
        if rarely((self._session.gathered != 0.0) & (self._hurried == 0.0)):
            self._session.flush()

    def update(self) -> None:
        """Publish the states; apply wrenches and efforts."""
        now = self._core.GetSimTime()
        wanted = [states for states in self._states if states.publication.listened]
        if wanted and self._states_ticks.due(now):
            for states in wanted:
                states.send()
        measured = self._parameters is None or self._parameters.value(METRICS)
        if self._metrics is not None and self._metrics.listened and measured:
            self._metrics.update(now)
        if self._services is not None and self._services.jobs:
            self._services.apply(now)

    def step(self, paused: bool) -> None:
        """Publish the clock and what devices have measured, and deliver what has come."""
        if not paused and self._clock.listened and self._clock_is_due():
            self._send_clock()
        self._devices.step()
        self._session.deliver(self._core.agenda.deferred)
        if self._session.allowance.changes:
            self._core.after_step(self._session.allowance.spend)

    def reset(self) -> None:
        """Forget wrenches and efforts."""
        if self._services is not None:
            self._services.jobs.clear()

    def close(self) -> None:
        """The world ends: so do its topics and services."""
        if self._core.lock.interrupt in self._session.interrupts:
            self._session.interrupts.remove(self._core.lock.interrupt)
            self._session.node.follow_pace(lambda: False)
        for one in (self._services, self._parameters):
            if one is not None:
                one.end()
        self._devices.end()
        self._states, self._metrics, self._services, self._parameters = [], None, None, None


class _Classic:
    """What ROS sees of a world of SDF."""

    def __init__(self, core: World) -> None:
        self._attached = attach(core)
        self._world = self._attached.world

    def models(self) -> Listed:
        """The models."""
        return classic_models(self._world)

    def links(self) -> Listed:
        """The links."""
        return classic_links(self._world)

    def sensors(self) -> Iterable[Sensor]:
        """The sensors."""
        found = self._attached.sensors
        return found.sensors.values() if found is not None else ()

    def serve(self, session: Session) -> Services:
        """Serve its services."""
        return (WorldApi2 if session.version == 2 else WorldApi)(session, self._world)


class _Legacy:
    """What ROS sees of a legacy world."""

    def __init__(self, core: World) -> None:
        self._core = core

    def models(self) -> Listed:
        """The models."""
        return list_models(self._core)

    def links(self) -> Listed:
        """The bodies."""
        return list_links(self._core)

    def sensors(self) -> Iterable[Sensor]:
        """None: those of models are not apart from them."""
        return ()

    def serve(self, session: Session) -> Services:
        """Serve its services."""
        return (LegacyApi2 if session.version == 2 else LegacyApi)(session, self._core)


def classic_models(world: Any) -> Listed:
    """The models of a world of SDF; their frames are not those of their first links."""
    found = [model for model in world.Models() if model.GetLinks()]
    return Listed(
        [model.GetName() for model in found],
        [model.GetLinks()[0].body for model in found],
        [functools.partial(_row_of_pose, model) for model in found],
    )


def classic_links(world: Any) -> Listed:
    """The links of a world of SDF."""
    found = [link for model in world.Models() for link in model.GetLinks()]
    return Listed([link.GetScopedName() for link in found], [link.body for link in found], [])


def _own_parameters(session: Session) -> NodeParameters:
    """Those of the server's node in ROS 2."""
    space, _, name = session.names.name.rpartition("/")
    with unowned():
        found = NodeParameters(session, OwnNode(session.names, space, name), open=True)
    found.declare(CLOCK2[0].lstrip("~"), CLOCK2[1], "of /clock [Hz]; read at the start")
    found.declare(METRICS, True, "publish /performance_metrics")
    return found


def _rate(session: Session, name: str, default: float) -> float:
    """A rate among the parameters [Hz]."""
    value = session.parameter(name, default)
    try:
        return bounded_rate(value if isinstance(value, int) else float(value), f"ROS: parameter {name}")
    except (TypeError, ValueError):
        log.warning("ROS: parameter %s is %r; it must be a number", name, value)
        return default


def _row_of_pose(model: Any) -> tuple[float, ...]:
    pose = model.pose()
    u, x, y, z = pose.rot
    return (*pose.pos, x, y, z, u)
