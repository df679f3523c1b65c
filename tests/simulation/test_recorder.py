"""Laws: native code gives what Python gives, to the bit; what cannot be recorded is an error that names the line."""

import inspect
import math

import numpy as np
import pytest

import libgz
from libgz.base.law import (
    LawError,
    Number,
    acos,
    asin,
    atan,
    atan2,
    clamp,
    copysign,
    cos,
    ends,
    floor,
    fmod,
    hypot,
    largest,
    law,
    least,
    possible,
    rarely,
    same,
    sin,
    sqrt,
    tan,
    usually,
    where,
    whole,
)
from libgz.base.records import Kind, numbers
from libgz.legacy.model import Model
from libgz.simulation.recorder import recorded_as

HEAD = "<gz:world xmlns:gz='g' xmlns:model='m'>"
VALUES = (0.0, -0.0, 1.0, -1.0, 0.3, -2.7, 1e300, 5e-324, math.pi, math.inf, -math.inf, math.nan)


class Computing(Model):
    """Computes one law in each step."""

    STATE = ()
    x, y = Number(), Number()

    def Load(self, file, node):
        self.AddBody(libgz.Body(self.world, dummy=True), True)
        self.results, self.array = numbers(64)(), np.arange(5.0)

    def plan_update(self, plan):
        plan.call(self.compute)


def world_of(compute, **members):
    """A world with a model that computes a law."""
    kind = type("Own", (Computing,), {"STATE": (), "compute": compute, **members})
    world, file = libgz.World(), libgz.WorldFile()
    world.factory.RegisterModel("plugin", "Own", kind)
    file.LoadString(f"{HEAD}<model:Own><id>own</id></model:Own></gz:world>")
    world.Load(file)
    world.Initialize()
    return world


def expressions(x, y):
    """All that can be computed of two numbers, whatever they are."""
    return (
        *(x + y, x - y, x * y, -x, abs(x), +x, 2.0 - x, 3.0 * x, x + 1),
        *(least(x, y), largest(x, y), clamp(x, 0.7), atan(x), atan2(x, y), hypot(x, y)),
        *(where(x < y, 1.0, 2.0), where(x <= y, x, y), where(x > y, x, 0), where(x >= 1, x, y), where(x == y, 1, 2)),
        *(where(x != y, 1.0, 2.0), where((x > 0.0) & (y > 0.0), x, y), where((x > 0.0) | (y > 0.0), x, y)),
        *(where(same(x, y), 1.0, 0.0), copysign(x, y), copysign(1.0, x)),
    )


def partial_ones(x, y):
    """What Python refuses for some numbers."""
    return x / y, sqrt(abs(x)), cos(x), sin(x), tan(x), fmod(x, y)


def bits(values):
    return np.array([float(value) for value in values]).tobytes()


@law
def total(self):
    for i, value in enumerate(expressions(self.x, self.y)):
        self.results[i] = value


@law
def refusing(self):
    for i, value in enumerate(partial_ones(self.x, self.y)):
        self.results[i] = value


def test_all_functions_give_the_bits_of_python():
    with world_of(total) as world:
        own = world.model("own")
        assert sum(row.kind == Kind.LAW for row in world.rows._rows) == 0, "they are built in the first step"
        for x in VALUES:
            for y in VALUES:
                own.x, own.y = x, y
                world.step()
                assert own.failed is None
                expected = expressions(x, y)
                assert bits(own.results[: len(expected)]) == bits(expected), (x, y)
        assert all(row.kind != Kind.PYTHON for row in world.rows._rows)


@pytest.mark.parametrize("x", VALUES)
@pytest.mark.parametrize("y", VALUES)
def test_what_python_refuses_is_refused(x, y):
    try:
        expected = partial_ones(x, y)
    except (ValueError, ZeroDivisionError) as error:
        expected = error
    with world_of(refusing) as world:
        own = world.model("own")
        own.x, own.y = x, y
        world.step()
        if isinstance(expected, Exception):
            assert type(own.failed) is type(expected)
        else:
            assert own.failed is None
            assert bits(own.results[: len(expected)]) == bits(expected)


def test_domains_of_asin_and_of_whole_numbers():
    @law
    def compute(self):
        self.results[0], self.results[1], self.results[2] = asin(self.x), floor(self.y), whole(self.y)
        self.results[3] = acos(self.x)

    with world_of(compute) as world:
        own = world.model("own")
        for x, y in ((0.3, 2.7), (-1.0, -2.7), (1.0, 1e9)):
            own.x, own.y = x, y
            world.step()
            assert own.results[:4] == [math.asin(x), math.floor(y), int(y), math.acos(x)]
        own.x = 1.5
        world.step()
        assert isinstance(own.failed, ValueError)


def test_what_a_law_set_it_reads():
    """In the order of Python, though native code sets all at the end; also elements of arrays and parts of them."""

    @law
    def compute(self):
        before = self.x
        self.x = self.y
        self.y = before
        self.x += 1.0
        self.array[1] = self.x
        self.array[2:4] = self.array[0:2]
        total = self.array * 2.0
        self.results[:5] = total
        self.array[:] = (self.array[4], *[self.array[i] for i in range(4)])

    with world_of(compute) as world, world_of(compute) as twin:
        twin.rows.enabled = False
        for one in (world, twin):
            one.model("own").x, one.model("own").y = 3.0, 5.0
        for _ in range(4):
            for one in (world, twin):
                one.step()
            ours, theirs = world.model("own"), twin.model("own")
            assert (ours.x, ours.y) == (theirs.x, theirs.y)
            assert ours.array.tolist() == theirs.array.tolist()
            assert list(ours.results) == list(theirs.results)
        assert all(row.kind != Kind.PYTHON for row in world.rows._rows)


def test_a_law_may_end_before_it_sets_anything():
    @law
    def compute(self):
        if ends(self.x < 0.0):
            return
        limited = self.y > 1.0
        if possible(limited):
            self.results[1] = where(limited, 1.0, self.y)
        self.results[0] += sqrt(self.x)

    with world_of(compute) as world:
        own = world.model("own")
        for x, y, expected in ((4.0, 2.0, [2.0, 1.0]), (-4.0, 0.5, [2.0, 1.0]), (9.0, 0.5, [5.0, 0.5])):
            own.x, own.y = x, y
            world.step()
            assert own.results[:2] == expected
        assert own.failed is None
        assert all(row.kind != Kind.PYTHON for row in world.rows._rows)


def late(self):
    self.results[0] = 1.0
    if ends(self.x < 0.0):
        return


@law
def part_that_ends(self):
    if ends(self.x < 0.0):
        return


@pytest.mark.parametrize(
    ("compute", "message"),
    [(law(late), "ends after it has set something"), (law(lambda self: self.part()), "ends in a part of a law")],
)
def test_a_law_ends_nowhere_else(compute, message):
    with world_of(compute, part=part_that_ends) as world:
        world.step()
        assert isinstance(world.model("own").failed, LawError)
        assert message in str(world.model("own").failed)


def test_numpy_and_arrays():
    indices = np.array([4, 0, 0])

    @law
    def compute(self):
        near = np.minimum(self.array, self.x) + 1.0
        chosen = near[indices]
        self.results[:3] = np.where(np.abs(chosen - 2.0) < 1.5, chosen / 2.0, -chosen)

    with world_of(compute) as world:
        own = world.model("own")
        own.x = 3.5
        world.step()
        near = (np.minimum(np.arange(5.0), 3.5) + 1.0)[indices]
        assert own.failed is None
        assert own.results[:3] == np.where(np.abs(near - 2.0) < 1.5, near / 2.0, -near).tolist()
        assert all(row.kind != Kind.PYTHON for row in world.rows._rows)


def test_steps_that_are_not_usual_are_pythons():
    calls = []

    @law
    def compute(self):
        if not usually(self.x >= 0.0) or rarely(self.x > 10.0):
            calls.append(self.x)
            return
        self.y += 1.0

    with world_of(compute) as world:
        own = world.model("own")
        for x in (1.0, -1.0, 5.0, 11.0, math.nan):
            own.x = x
            world.step()
        assert own.y == 2.0
        assert calls[:2] == [-1.0, 11.0]
        assert math.isnan(calls[2])


def test_numbers_of_bytes_keep_the_last_bits_of_integers():
    letters, memory = "dfiIHB", np.zeros(48, np.uint8)

    def record(recorder, own, value):
        for place, letter in enumerate(letters):
            recorder.put(memory, 8 * place, letter, value)

    @recorded_as(record)
    def put(self, value):
        raise AssertionError

    @law
    def compute(self):
        self.put(self.x)

    with world_of(compute, put=put) as world:
        for value in (*VALUES, -3.9, 1e10, -1e10, 2.0**62, 2.0**80):
            world.model("own").x = value
            world.step()
            found = [memory[8 * i :].view(letter)[0] for i, letter in enumerate(letters[:-1])] + [memory[40]]
            number = int(value) if abs(value) < 2.0**63 else 0
            expected = [number % 2**bits for bits in (32, 32, 16, 8)]
            with np.errstate(over="ignore"):
                assert bits(found[:2]) == bits([value, float(np.float32(value))])
            assert [int(one) % 2**32 for one in found[2:]] == expected


def test_bytes_are_appended_where_there_is_room():
    data, box, full = np.arange(3, dtype=np.uint8) + 1, np.zeros(8, np.uint8), []

    def record(recorder, own):
        used = recorder.get(own, "x")
        recorder.append(data, box, used)
        recorder.set(own, "x", used + 3.0)

    @recorded_as(record)
    def append(self):
        full.append(self.x)

    @law
    def compute(self):
        self.append()

    with world_of(compute, append=append) as world:
        own = world.model("own")
        for _ in range(3):
            world.step()
        assert (own.x, full) == (6.0, [6.0])
        assert box.tolist() == [1, 2, 3, 1, 2, 3, 0, 0]


def untraceable(reason):
    """Mark a law with what the error says."""

    def mark(function):
        function.reason = reason
        return law(function)

    return mark


@untraceable("decides by a number; use where")
def deciding(self):
    if self.x > 1.0:
        self.y = 1.0


@untraceable("gives a number to a function that cannot be recorded")
def foreign(self):
    self.y = math.cos(self.x)


@untraceable("sets count, which is no number of native code")
def counting(self):
    self.count = self.x


@untraceable("uses Own.helper, which is no law; mark it with @law")
def helped(self):
    self.y = self.helper()


@untraceable("calls numpy.arctan")
def by_numpy(self):
    self.results[0] = np.arctan(self.array)[0]


@untraceable("computes with 'text', which is no number")
def by_text(self):
    self.y = self.x + "text"


@untraceable("uses %, whose sign is Python's own")
def by_remainder(self):
    self.y = self.x % 2.0


@untraceable("computes with arrays of the sizes 2, 3")
def by_sizes(self):
    self.results[:2] = self.array[:2] + self.array[:3]


@pytest.mark.parametrize(
    "compute",
    [deciding, foreign, counting, helped, by_numpy, by_text, by_remainder, by_sizes],
    ids=lambda f: f.__name__,
)
def test_what_cannot_be_recorded_is_an_error_with_its_line(compute):
    with world_of(compute, helper=lambda self: 1.0) as world:
        world.step()
        error = world.model("own").failed
        assert isinstance(error, LawError)
        lines, first = inspect.getsourcelines(compute)
        file, line, _ = str(error).split(":", 2)
        assert file == __file__
        assert first + 2 <= int(line) < first + len(lines)
        assert compute.reason in str(error)
        assert compute.__name__ in str(error)


def test_a_method_that_replaces_a_law_is_pythons():
    calls = []

    @law
    def compute(self):
        self.y = self.part()

    @law
    def part(self):
        return self.x

    base = type("Base", (Computing,), {"STATE": (), "compute": compute, "part": part})
    replacing = {"part": lambda self: calls.append(1) or base.part(self)}
    kind = type("Own", (base,), {"STATE": (), **replacing})
    world, file = libgz.World(), libgz.WorldFile()
    world.factory.RegisterModel("plugin", "Own", kind)
    file.LoadString(f"{HEAD}<model:Own><id>own</id></model:Own></gz:world>")
    world.Load(file)
    world.Initialize()
    with world:
        world.model("own").x = 4.0
        world.step(3)
        assert world.model("own").y == 4.0
        assert calls == [1, 1, 1]
