"""Stepping: what a step of a world consists of, and in which order."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable
from functools import partial
from typing import TYPE_CHECKING

from libgz.base.errors import USER_ERRORS, GazeboError, ParameterError, pass_interrupt
from libgz.simulation.entity import Entity
from libgz.simulation.exchange import Exchange
from libgz.simulation.plan import Plan
from libgz.simulation.plugins import own_traceback
from libgz.simulation.problems import NOTED, note
from libgz.simulation.running_code import names

if TYPE_CHECKING:
    from libgz.simulation.updates import LawCall, UpdateRows
    from libgz.simulation.world import World

__all__ = ["Stepping"]

log = logging.getLogger("libgz.simulation")

FALL_PERIOD = 256  # steps between two looks for bodies that fell
MOST_FREE = 1000  # steps between two looks at what runs beside the world
STEP_TOLERANCE = 1e-6  # steps; so much earlier it is asked, because the sim time is a sum


def _nothing() -> None:
    """What ends steps of which nothing is left."""


class Stepping:
    """The steps of a world: buttons, entities, physics, followers, clock, companions, clients.

    Native code does the rows of a step, and steps that consist of them alone; Python does what is left.

    Args:
        world: the world; whoever steps it holds its lock.
    """

    def __init__(self, world: World) -> None:
        self.world = world
        self._begin, self._contact, self._end = (
            world.events[name] for name in ("WorldUpdateBegin", "BeforePhysicsUpdate", "WorldUpdateEnd")
        )
        self._laws = self._begin.entries  # the callbacks that rows do

    def run(self, count: int, pace: int | None, last: LawCall | None) -> int:
        """One step, and more as long as native code does them alone; how many. The arguments are those of `prepare`."""
        if free := self.prepare(count, last, pace):
            self.world.rows.run_all()
            made, end = self.finish(free)
        else:
            made, end = 1, self.run_in_python()
        end()
        return made

    def prepare(self, count: int, last: LawCall | None, pace: int | None = None) -> int:
        """How many of the next steps native code may do by its job, until a row stops it; then comes `finish`.

        Where it is none, `run_in_python` comes. Both leave to their caller what ends a step: the changes that were
        deferred, which may have to wait for what the agenda's `awaited` has, and its report.

        Args:
            count: at most so many.
            last: a law that is computed after so many; the job's `obeyed` says whether it was.
            pace: when they are due, see `Pacer.pace`.
        """
        rows = self.world.rows
        if not rows.valid or self._laws is not self._begin.entries:
            self._build_rows()
        lock = self.world.lock
        lock.wanted.value = 0
        most = 1 if lock.waiting or self.world.rewinding else count  # one may have begun to wait just before that
        free = min(most, self._free_steps()) if rows.native else 0
        job = rows.job
        job.steps, job.pace, job.obeyed = free, pace, 0
        if free:
            self.world.engine.enter()
            job.law = last.address if last is not None and free == count else None
        return free

    def finish(self, free: int) -> tuple[int, Callable[[], None]]:
        """Do what the job has left of so many steps; how many were made, and what ends the last."""
        rows = self.world.rows
        number, made = rows.job.row, free - rows.job.steps
        if made:
            for companion in self.world.companions:
                companion.skipped()
        if number < rows.count:
            return made + 1, self._continue_natively(number)
        return made, _nothing

    def run_in_python(self) -> Callable[[], None]:
        """Do a step whose parts Python calls, up to what ends it."""
        if self.world.buttons.read():
            return self._pause()
        self.world.agenda.stepping = True
        self._begin_step()
        self._advance()
        return partial(self._end_step, paused=False)

    def _free_steps(self) -> int:
        """How many of the next steps consist of what rows do, and nothing else."""
        if not self.world.physics_enabled:
            return 0
        if self._contact or self._end or not self._begin.obeys_laws:
            return 0
        if not self.world.companions:
            return MOST_FREE
        until = min(companion.idle_until() for companion in self.world.companions)
        free = (until - self.world.clock.sim_time) / self.world.engine.step_time - STEP_TOLERANCE
        return int(max(0.0, min(free, MOST_FREE)))

    def _continue_natively(self, number: int) -> Callable[[], None]:
        """Do in Python a row that the native code cannot do, and then the step where it can, up to what ends it."""
        rows, refused = self.world.rows, number
        if number < rows.begin:
            if number == 0 and self.world.buttons.read():
                return self._pause()
            self.world.agenda.stepping = True
            self._run_own_rows(max(number, 1), rows.begin, refused)
            if not rows.valid:  # a callback has changed what the rows after it depend on
                self._build_rows()
            number, refused = rows.begin, -1
        if number < rows.tail:
            self.world.agenda.stepping = True
            if number < rows.end:
                self._run_rows(number)
                number, refused = rows.end, -1
            # An entity may have connected to an event since; a physics step that went wrong has been made.
            if rows.end == number != refused and not self._free_steps():
                self._advance_physics()
            else:
                self._run_own_rows(number, rows.tail, refused)
            return self._end_natively
        self._run_own_rows(number, rows.count, refused)
        return _nothing

    def _end_natively(self) -> None:
        """End a step, natively where that is possible."""
        rows = self.world.rows
        self._act()
        if not rows.valid or not self._free_steps():  # the interface that the last rows write to may have changed
            self._report(paused=False)
        else:
            self._run_own_rows(rows.tail, rows.count)

    def _run_own_rows(self, begin: int, end: int, refused: int = -1) -> None:
        """Do rows of the world itself; one that native code has refused is not done by it again."""
        rows = self.world.rows
        number = begin if begin == refused or not rows.native else rows.run(begin, end)
        while number < end:
            rows.line(number).twin(self.world.engine.step_time)
            number = rows.after_twin(number)
            number = rows.run(number, end) if rows.native else number

    def _build_rows(self) -> None:
        """Describe a step as rows, and find out which entities have something to do in it."""
        world = self.world
        with world.rows.building() as rows:
            rows.share(lambda _: None, rows.exchange("buttons", world.sim, world.buttons.exchange))
            rows.begin_step(FALL_PERIOD, world.era.counts_at_start, lambda _: self._begin_step())
            self._laws = self._begin.entries
            if self._begin.obeys_laws:
                self._add_laws(rows)
            rows.entities()
            for companion in world.companions:
                plan = Plan()
                companion.plan_update(plan)
                rows.follow(plan)
            rows.advance(lambda _: world.engine.finish())
            if world.followers:
                rows.python(lambda _: self._follow())
            rows.end_physics()
            for companion in world.companions:
                plan = Plan()
                companion.plan_end(plan)
                rows.follow(plan)
            rows.share(lambda _: self._write_times(), rows.exchange("times", world.sim, self._times))
            if world.publication is not None:
                publication = world.publication
                rows.publish(lambda _: publication.publish(paused=False), publication.record)
            rows.post(lambda _: world.gz_server.post())

    def _add_laws(self, rows: UpdateRows) -> None:
        """Rows for the callbacks of the event that begins a step, which are laws."""
        for entry in self._laws:
            plan = Plan()
            plan.call(entry.callback)
            holder = getattr(entry.callback, "__self__", None)
            if hasattr(holder, "_watched"):
                vars(holder).update(_watched=set(), _law_changed=self.world.update_rows_changed)
            plan.lines[0].run = lambda _, entry=entry: self._begin.call((entry,))  # type: ignore[misc]
            try:
                rows.follow(plan)
            except USER_ERRORS as error:  # it cannot be recorded
                pass_interrupt(error)
                self._begin.failed(entry, error)

    def _pause(self) -> Callable[[], None]:
        """What a step does while the world is paused, up to what ends it."""
        self.world.agenda.stepping = True
        self._update_entities(0.0)
        self.world.clock.pause_time += self.world.engine.step_time
        return partial(self._end_step, paused=True)

    def _end_step(self, paused: bool) -> None:
        """End a step in Python."""
        self._act()
        self._report(paused)

    def _act(self) -> None:
        """Make the changes that were deferred to the end of the updates and of physics."""
        if self.world.agenda.deferred:
            self.world.agenda.act()
        self.world.agenda.stepping = False

    def _report(self, paused: bool) -> None:
        """Update companions, and let others know of the step."""
        agenda = self.world.agenda
        agenda.stepping = bool(self.world.companions)
        for companion in self.world.companions:
            companion.step(paused)
        if agenda.deferred:
            agenda.act()
        self._write_times()
        if self.world.publication is not None:
            self.world.publication.publish(paused)
        self.world.gz_server.post()

    def _times(self) -> Exchange:
        """Native code's part of `_write_times`."""
        times, clock = Exchange(self.world.sim), self.world.clock
        if self.world.sim.link.memory:
            for name in ("sim_time", "pause_time"):
                times.assign(times.field(name), times.number(clock, name))
            times.real_time("real_time")
        return times

    def _write_times(self) -> None:
        clock = self.world.clock
        if self.world.sim.lock():
            data = self.world.sim.data
            data.sim_time, data.pause_time, data.real_time = clock.sim_time, clock.pause_time, clock.real_time
            self.world.sim.unlock()

    def _begin_step(self) -> None:
        """Count the step, and look for bodies that fell out of the world now and then."""
        engine, clock = self.world.engine, self.world.clock
        clock.iterations += 1
        if not clock.iterations % FALL_PERIOD:
            self.world.falls.report()
        clock.sim_time += engine.step_time if self.world.era.counts_at_start else 0.0

    def _advance(self) -> None:
        """Advance everything by one step of sim time, and signal the events of a step."""
        if self._begin:
            self._begin(self._update_info() if self._begin.gives else None)
        self._update_entities(self.world.engine.step_time)
        self._advance_physics()

    def _advance_physics(self) -> None:
        """The part of a step after the updates of the entities."""
        engine, clock = self.world.engine, self.world.clock
        clock.sim_time += 0.0 if self.world.era.counts_at_start else engine.step_time
        for companion in self.world.companions:
            companion.prepare()
        rows = self.world.rows
        if not rows.valid:
            self._build_rows()
        if rows.end < rows.physics:
            engine.enter()
            self._run_own_rows(rows.end, rows.physics)
        for companion in self.world.companions:
            companion.update()
        if self._contact:
            engine.collide()
            self._contact(self._update_info() if self._contact.gives else None)
            if self.world.physics_enabled:
                engine.solve()
            else:
                engine.drop_contacts()
        elif self.world.physics_enabled:
            engine.advance()
        elif engine.record_contacts:  # as in Gazebo, what is moved by hand touches, too
            engine.collide()
            engine.drop_contacts()
        self._follow()
        if self._end:
            self._end()

    def _follow(self) -> None:
        """Move the entities that follow their parents without a joint."""
        try:
            for entity in self.world.followers:
                entity.follow()
        except ParameterError as error:
            raise GazeboError(f"{entity._entity_place()}{error}") from error

    def _update_entities(self, step: float) -> None:
        """Update all entities in order. One that raises is reported and stopped; the others are still updated."""
        rows = self.world.rows
        if not rows.valid:
            self._build_rows()
        if rows.native and step > 0.0:
            if rows.begin < rows.end:
                self.world.engine.enter()
                self._run_rows(rows.begin)
            return
        failed = []
        for entity in rows.updating:
            present = rows.valid or entity in self.world.entities
            if present and not self._call(entity, entity.MasterUpdate, step):
                failed.append(entity)
        self._stop_failed(failed)

    def _run_rows(self, number: int) -> None:
        """Do rows of the entities from one on; those that the native code cannot do, by their twins in Python."""
        rows, step, failed = self.world.rows, self.world.engine.step_time, []
        number = rows.run(number, rows.end)
        while number < rows.end:
            entity, twin, _ = rows.line(number)
            done = self._call(entity, twin, step)
            if rows.valid:
                number = rows.run(rows.after_twin(number), rows.end)
                continue
            # What rows depend on has changed: Python does what is left of this entity, and new rows are for the others.
            while done and (number := rows.next_in_python(number)) < rows.end_of(entity):
                done = self._call(entity, rows.line(number).twin, step)
            if not done:
                failed.append(entity)
            following = rows.after(entity)
            self._build_rows()
            number = rows.run(rows.first_of(following), rows.end)
        self._stop_failed(failed)

    @staticmethod
    def _call(entity: Entity, update: Callable[[float], object], step: float) -> bool:
        """Call the update of an entity, or a part of it; whether that succeeded. If not, it is not updated any more."""
        try:
            update(step)
        except USER_ERRORS as error:
            pass_interrupt(error)
            entity.failed = error
            entity.world.update_rows_changed()
            note(f"model {entity.GetId()!r}", "its Update", error)
            log.error(
                "model %r stopped, its motors off: its Update failed with\n%s",
                entity.GetId(),
                own_traceback(error, called=getattr(entity, "Update", None)),
                extra=NOTED,
            )
            return False
        return True

    def _stop_failed(self, entities: Iterable[Entity]) -> None:
        """Switch off the motors of those whose update has just failed."""
        for entity in entities:
            entity.motors_off()
            for interface in self.world.interfaces_of(entity):  # clients would wait for its locks without end
                interface.unlock()

    def _update_info(self) -> object:
        """What the callbacks of update events are given."""
        return type(self.world.events).update_info(
            self.world.name, self.world.clock.sim_time, self.world.clock.real_time
        )


names(Stepping._call, lambda values: f"Update of model {values['entity'].GetId()!r}")
