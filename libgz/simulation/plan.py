"""Plan: what an entity does in a step, in order; Python can run it, and `UpdateRows` lets native code do what it can.

Both call the same methods: laws are recorded, the rest is Python in any case.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeVar

from libgz.base.errors import ParameterError
from libgz.base.law import is_law, law
from libgz.physics.rays import RayProximity
from libgz.simulation.exchange import Exchange
from libgz.simulation.rate import UpdateRate
from libgz.transport.interface import Interface

__all__ = ["Line", "Plan", "handler", "overrides"]

F = TypeVar("F", bound=Callable[..., Any])


def overrides(thing: object, kind: type, *names: str) -> bool:
    """Whether an object has other methods of these names than the class `kind`, by a subclass or by itself."""
    own = vars(thing)
    return any(name in own or getattr(type(thing), name) is not getattr(kind, name) for name in names)


def handler(function: F) -> F:
    """Mark a method that does an exchange in Python; native code may do it while the conditions of the line hold."""
    function.is_handler = True  # type: ignore[attr-defined]
    return function


@dataclass(eq=False, repr=False)
class Line:
    """One thing to do in a step.

    Attributes:
        run: does it in Python; its argument is the length of the step [s].
        law: a method that does it, and may be recorded: with the step's length if `stepped`, and `arguments`.
        interface: the one that the law is called with, under the lock.
        unless: adds the conditions under which there is nothing to do but the law.
        bundle: the rays to cast.
        post: the server whose clients are woken.
        rate: when the lines up to `end` are due.
        conditional: whether they are done only if what the line returns holds.
    """

    run: Callable[[float], object]
    law: Callable[..., Any] | None = None
    stepped: bool = False
    arguments: tuple[Any, ...] = ()
    interface: Interface[Any] | None = None
    unless: Callable[[Exchange], None] | None = None
    bundle: RayProximity | None = None
    post: Any = None
    rate: UpdateRate | None = None
    conditional: bool = False
    end: int = 0


class Plan:
    """What is done in a step, line by line."""

    def __init__(self) -> None:
        self.lines: list[Line] = []

    def do(self, method: Callable[[float], object]) -> None:
        """Call a method with the length of the step [s]; natively if it is a law."""
        self.lines.append(Line(method, law=method if _is_law(method) else None, stepped=True))

    def call(self, method: Callable[..., object], *arguments: Any) -> None:
        """Call a method with arguments that stay the same; natively if it is a law."""
        law_ = method if _is_law(method) else None
        self.lines.append(Line(lambda _: method(*arguments), law=law_, arguments=arguments))

    @contextlib.contextmanager
    def due(self, rate: UpdateRate) -> Iterator[None]:
        """What is added inside is done only when a rate is due.

        Raises:
            ParameterError: it is no rate.
        """
        if not hasattr(rate, "due"):
            raise ParameterError(f"the rate of a plan is {rate!r}; it must be an UpdateRate")
        line = Line(_nothing, rate=rate)
        self.lines.append(line)
        yield
        line.end = len(self.lines)

    @contextlib.contextmanager
    def when(self, law_: Callable[[], Any]) -> Iterator[None]:
        """What is added inside is done only when a law says so."""
        line = Line(lambda _: law_(), law=law_, conditional=True)
        self.lines.append(line)
        yield
        line.end = len(self.lines)

    def exchange(
        self,
        interface: Interface[Any],
        write: Callable[..., object] | None,
        *arguments: Any,
        unless: Callable[[Exchange], None] | None = None,
        otherwise: Callable[[], object] | None = None,
    ) -> None:
        """Exchange numbers with an interface under its lock; natively if `write` is a law.

        While a client keeps the lock, it is left out.

        Args:
            interface: to lock.
            write: is called with the interface's data and the arguments; None: nothing is written.
            arguments: the same in each step.
            unless: adds the conditions under which native code may do it, such as that no client wrote a new command.
            otherwise: a `handler`, which does all in Python, the lock included; by default `write` under the lock.
        """
        handled = otherwise is None or getattr(getattr(otherwise, "__func__", None), "is_handler", False)
        law_ = (write or _write_nothing) if handled and (write is None or _is_law(write)) else None
        run = (lambda _: otherwise()) if otherwise else partial(_write, interface, write, arguments)
        self.lines.append(Line(run, law=law_, arguments=arguments, interface=interface, unless=unless))

    def cast(self, find: Callable[[], RayProximity]) -> None:
        """Cast rays from where their body is; a function finds them, for a line before this one may replace them."""
        bundle = find()
        native = not (bundle.body.dummy or overrides(bundle, RayProximity, "Update"))
        self.lines.append(Line(lambda _: find().Update(), bundle=bundle if native else None))

    def post(self, interface: Interface[Any]) -> None:
        """Wake the clients of an interface."""
        self.lines.append(Line(lambda _: interface.post(), post=interface.server))

    def run(self, step: float, now: float) -> None:
        """Do it in Python, in a step of a length [s] at a sim time [s]."""
        number = 0
        while number < len(self.lines):
            line = self.lines[number]
            if line.rate is not None and not line.rate.due(now):
                number = line.end
                continue
            holds = line.run(step)
            number = line.end if line.conditional and not holds else number + 1


def _is_law(method: Any) -> bool:
    return is_law(getattr(method, "__func__", None))


def _nothing(_step: float) -> None:
    """What is done when a rate is due."""


@law
def _write_nothing(_data: Any) -> None:
    """What is written where there is nothing to do but to look for commands."""


def _write(interface: Interface[Any], write: Callable[..., object] | None, arguments: Any, _step: float) -> None:
    if interface.lock():
        if write is not None:
            write(interface.data, *arguments)
        interface.unlock()
