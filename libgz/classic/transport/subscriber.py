"""Subscriber: the receiving end of a topic."""

from __future__ import annotations

import time as clock
import types
import weakref
from collections.abc import Callable, Collection
from typing import Any

from libgz.base.errors import USER_ERRORS, pass_interrupt
from libgz.classic.msgs.message import Message
from libgz.classic.transport.manager import TopicManager
from libgz.classic.transport.topic import Topic, log, sequence
from libgz.simulation.event import Owner, checked, owner, report_failure

__all__ = ["Subscriber"]

DROPPED_AT_ONCE = 0.001  # [s] a subscription dropped within this was never stored


class Subscriber:
    """A subscription, as returned by Node.Subscribe; it ends when it is dropped.

    A bound method is held weakly: with ``self.sub = self.node.Subscribe("~/topic", self.OnMsg)`` the subscription ends
    with its object. Functions and all other callables are held.

    Attributes:
        owner: the plugin that subscribes, which is stopped when the callback raises; None outside plugins.
        type_name: the full name of the messages' type; empty if the subscriber takes any.

    Raises:
        ParameterError: the callback cannot be called.
    """

    def __init__(
        self, topic: Topic, callback: Callable[[Any], Any], latching: bool = False, type_name: str = ""
    ) -> None:
        checked(callback, f"the callback of {topic.name}")
        self._topic = topic
        self.owner = owner.get()
        self._callback: Callable[[], Callable[[Any], Any] | None]
        if isinstance(callback, types.MethodType):
            self._callback = weakref.WeakMethod(callback)
        else:
            self._callback = lambda: callback
        compiled = isinstance(callback, types.BuiltinFunctionType)  # its name says nothing
        self._what = "a callback" if compiled else f"the callback {getattr(callback, '__qualname__', repr(callback))}"
        self.latching = latching
        self.type_name = type_name
        self.since = next(sequence)
        self._born = clock.monotonic()
        topic.subscribers[id(self)] = weakref.ref(self)
        if self.owner is not None:
            self.owner.connections.add(self)
        manager = TopicManager.Instance()
        manager.refresh(topic)
        if latching:
            manager.latch(topic, self)

    def precede(self, others: Collection[Owner]) -> None:
        """Have the callbacks of this one's plugin called before those of others, on this topic."""
        self._topic.move(self.owner, others)

    def GetTopic(self) -> str:
        """Return the full name of the topic."""
        return self._topic.name

    def Unsubscribe(self) -> None:
        """End the subscription. Allowed at any time, also in the callback."""
        if self._topic.subscribers.pop(id(self), None) is not None:
            TopicManager.Instance().refresh(self._topic)

    Fini = disconnect = Unsubscribe

    def __del__(self) -> None:
        topic = getattr(self, "_topic", None)
        if topic is not None and topic.subscribers.pop(id(self), None) is not None:
            TopicManager.Instance().refresh_later(topic)
            if clock.monotonic() - self._born < DROPPED_AT_ONCE:
                log.warning(
                    "the subscription to %s ended right after it began: keep what Subscribe returns", topic.name
                )

    def take(self, message: Message) -> None:
        """Call the callback. If it raises, report the error, end the subscription, and stop the plugin."""
        if id(self) not in self._topic.subscribers:
            return
        callback = self._callback()
        if callback is None:
            self.Unsubscribe()
            return
        token = owner.set(self.owner)
        try:
            callback(message)
        except USER_ERRORS as error:
            pass_interrupt(error)
            self.Unsubscribe()
            report_failure(self.owner, f"{self._what} of topic {self._topic.name}", error)
        finally:
            owner.reset(token)
