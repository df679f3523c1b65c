"""What plugins share: times, stopwatches, animations, messages, search paths."""

import copy
import io
import logging
import math
import pickle
import sys
from datetime import datetime
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st

from libgz.base.errors import GazeboError, NotFoundError, ParameterError
from libgz.classic.common import (
    PID,
    ConsoleFormatter,
    ConsoleHandler,
    LogFormatter,
    NumericAnimation,
    NumericKeyFrame,
    PoseAnimation,
    SystemPaths,
    Time,
    Timer,
    UpdateInfo,
    endl,
    gzdbg,
    gzerr,
    gzlog,
    gzmsg,
    gzthrow,
    gzwarn,
)
from libgz.classic.math import PID as MATH_PID, Quaterniond, Vector3d
from libgz.sdf.paths import find_uri
from libgz.sdf.value import parse

# Times


def test_a_time_is_normalised_with_one_sign():
    assert (Time(1, 2_500_000_000).sec, Time(1, 2_500_000_000).nsec) == (3, 500_000_000)
    assert (Time(-0.5).sec, Time(-0.5).nsec) == (0, -500_000_000)
    assert (Time(1, -1).sec, Time(1, -1).nsec) == (0, 999_999_999)
    assert (Time(-1.25).sec, Time(-1.25).nsec) == (-1, -250_000_000)
    assert Time(1.5) == Time(1, 500_000_000) == Time(Time(1.5))
    assert Time() == Time.Zero == 0
    for wrong in (math.nan, math.inf):
        with pytest.raises(ParameterError, match="finite"):
            Time(wrong)


def test_a_time_as_numbers_and_texts():
    t = Time(3, 250_000_000)
    assert t.Double() == t.Float() == float(t) == 3.25
    assert str(t) == "3 250000000"
    assert repr(t) == "Time(3, 250000000)"
    assert parse(Time, "3 250000000") == parse(Time, "3.25") == t
    with pytest.raises(ParameterError, match="Time"):
        parse(Time, "1 2 3")
    t.sec = 5
    t.nsec = 1
    assert t == Time(5, 1)
    t.Set(2.0)
    assert t == 2
    assert not Time.Zero
    assert copy.copy(t) == pickle.loads(pickle.dumps(t)) == t


def test_times_add_up_exactly():
    step, now = Time(0.001), Time()
    for _ in range(10_000):
        now += step
    assert now == 10
    assert now.Double() == 10.0
    held = now
    now -= 0.5
    assert (held, now) == (Time(10), Time(9.5))
    assert 10.0 - now == 0.5 + Time.Zero
    assert -now == Time(-9.5)
    assert (Time(3) / Time(2)).Double() == 1.5
    assert Time(3) * 2 == 2 * Time(3) == 6
    assert 3.0 / Time(2) == 1.5
    assert np.float64(2.0) * Time(3) == 6
    assert type(np.float64(2.0) + Time(3)) is Time
    assert Time.Hour == 60 * Time.Minute == 3600 * Time.Second


def test_times_compare_with_numbers():
    t = Time(0.3)
    assert t == 0.1 + 0.2  # to the nanosecond
    assert 0.2 < t <= 0.3
    assert t > Time(0.2)
    assert t < math.inf
    assert t > -math.inf
    assert t != math.nan
    assert not t < math.nan
    assert t != "0.3"
    with pytest.raises(TypeError):
        _ = t < "1"


nanoseconds = st.integers(-(10**18), 10**18)


@given(nanoseconds, nanoseconds)
def test_times_are_integer_nanoseconds(a, b):
    s, t = Time.from_nanoseconds(a), Time.from_nanoseconds(b)
    assert (s + t).nanoseconds == a + b
    assert (s - t).nanoseconds == a - b
    assert (s < t, s == t, s >= t) == (a < b, a == b, a >= b)
    assert s.sec * 10**9 + s.nsec == a
    assert abs(s.nsec) < 10**9
    assert s.sec * s.nsec >= 0
    assert Time(s.sec, s.nsec) == s


@given(st.floats(-1e6, 1e6))
def test_seconds_come_back_to_half_a_nanosecond(seconds):
    assert abs(Time(seconds).Double() - seconds) <= 0.5e-9 + 1e-15 * abs(seconds)


def test_formatted_times():
    t = Time(2 * 86400 + 3 * 3600 + 4 * 60 + 5, 67_000_000)
    assert t.FormattedString() == "02 03:04:05.067"
    assert t.FormattedString(Time.HOURS, Time.SECONDS) == "51:04:05"
    assert t.FormattedString(Time.SECONDS) == "183845.067"
    with pytest.raises(ParameterError, match="FormattedString"):
        t.FormattedString(Time.SECONDS, Time.HOURS)


def test_the_clock_on_the_wall():
    before = Time.GetWallTime()
    later = Time()
    later.SetToWallTime()
    assert 0 <= later - before < 3600
    assert datetime.fromisoformat(Time.GetWallTimeAsISOString()[:26]).year >= 2024
    assert Time.NSleep(1000) == Time.MSleep(1) == Time.Sleep(Time(0.0005)) == 0
    assert (Time.SecToNano(2), Time.MilToNano(2), Time.MicToNano(2)) == (2e9, 2e6, 2e3)


def test_a_stopwatch():
    timer = Timer()
    assert not timer.GetRunning()
    assert timer.GetElapsed() == 0
    timer.Start()
    assert timer.Running()
    Time.MSleep(2)
    timer.Stop()
    halted = timer.GetElapsed()
    assert halted >= 0.002
    assert timer.GetElapsed() == halted
    timer.Start()
    assert timer.GetElapsed() >= halted
    timer.Reset()
    assert timer.GetElapsed() == 0


def test_update_info():
    info = UpdateInfo("default", Time(1.0), Time(2.0))
    assert (info.worldName, info.simTime.Double(), info.realTime.sec) == ("default", 1.0, 2)
    assert UpdateInfo() == UpdateInfo("", Time.Zero, Time.Zero)


def test_a_pid_takes_a_time():
    assert PID is MATH_PID
    assert PID(1.0, 1.0, 0.0, 10.0, -10.0).Update(2.0, Time(0.5)) == -3.0


# Animations


def pose_keys(anim, *keys):
    for time, pos, rpy in keys:
        key = anim.CreateKeyFrame(time)
        key.Translation(Vector3d(*pos))
        key.SetRotation(Quaterniond(*rpy))


def at(anim, time):
    anim.SetTime(time)
    return anim.GetInterpolatedKeyFrame()


def test_the_time_of_an_animation_wraps_or_stops():
    looping, once = PoseAnimation("test", 1.0, True), PoseAnimation("test", 1.0, False)
    looping.SetTime(-0.5)
    once.SetTime(-0.5)
    assert (looping.GetTime(), once.GetTime()) == (0.5, 0.0)
    looping.AddTime(0.75)
    once.AddTime(1.5)
    assert (looping.GetTime(), once.GetTime()) == (0.25, 1.0)
    once.SetLength(10.0)
    assert once.GetLength() == 10.0
    for wrong in (0.0, -1.0, math.inf, math.nan):
        with pytest.raises(ParameterError, match="length"):
            once.SetLength(wrong)


def test_key_frames_are_kept_in_the_order_of_their_times():
    anim = NumericAnimation("n", 10.0, False)
    with pytest.raises(NotFoundError, match="no key frames"):
        anim.GetInterpolatedKeyFrame()
    for time in (5.0, 0.0, 10.0):
        anim.CreateKeyFrame(time).SetValue(time * time)
    assert [anim.GetKeyFrame(i).GetTime() for i in range(anim.GetKeyFrameCount())] == [0.0, 5.0, 10.0]
    again = anim.CreateKeyFrame(5.0)
    assert anim.KeyFrame(1) is again
    assert anim.KeyFrameCount() == 3
    for wrong in (-1, 3):
        with pytest.raises(NotFoundError, match="has 3 key frames"):
            anim.GetKeyFrame(wrong)
    with pytest.raises(ParameterError, match="0 s or later"):
        anim.CreateKeyFrame(-1.0)


def test_numbers_change_in_straight_lines():
    anim = NumericAnimation("numeric_test", 10, False)
    anim.CreateKeyFrame(2.0).SetValue(10.0)
    anim.CreateKeyFrame(10.0).SetValue(30.0)
    assert at(anim, 4.0).GetValue() == 15.0
    assert at(anim, 0.0).Value() == 10.0
    assert at(anim, 10.0).Value() == 30.0
    key = NumericKeyFrame(0.0)
    assert anim.GetInterpolatedKeyFrame(key) is key
    assert (key.GetTime(), key.GetValue()) == (10.0, 30.0)


def test_a_pose_between_two_key_frames_is_classics():
    """The figures are those that Gazebo 11's own test of its animations expects."""
    anim = PoseAnimation("pose_test", 10.0, False)
    pose_keys(anim, (0.0, (0, 0, 0), (0, 0, 0)), (10.0, (10, 20, 30), (0.1, 0.2, 0.3)))
    key = at(anim, 4.0)
    assert key.GetTranslation().Equal((3.76, 7.52, 11.28), 1e-9)
    assert key.GetRotation().Equal(Quaterniond(0.0302776, 0.0785971, 0.109824), 1e-6)


WAY = (
    (1.0, (0, 0, 0), (0, 0, 0)),
    (2.0, (1, 2, 0), (0.5, 0, 1.5)),
    (5.0, (3, 1, 1), (0.5, 1, 3.0)),
    (5.5, (2, 0, 1), (0, 0, -2.5)),
    (9.0, (0, -1, 0), (-1, 0.5, -1.0)),
)


def test_key_frames_are_hit_exactly_and_held_at_the_ends():
    anim = PoseAnimation("way", 10.0, False)
    pose_keys(anim, *WAY)
    for time, pos, rpy in WAY:
        for near in (time, time - 1e-9, time + 1e-9):
            key = at(anim, near)
            assert key.Translation().Equal(pos, 1e-7)
            assert abs(key.Rotation().Dot(Quaterniond(*rpy))) == pytest.approx(1.0, abs=1e-12)
    assert at(anim, 0.0).Translation() == Vector3d(0, 0, 0)
    assert at(anim, 10.0).Translation() == Vector3d(0, -1, 0)
    at(anim, 2.0).Translation().X(50.0)  # a copy
    assert anim.GetKeyFrame(1).Translation().x == 1.0


def velocities(anim, time, h=1e-5):
    """Velocity and angular velocity at a time, by central differences."""
    before, after = at(anim, time - h), at(anim, time + h)
    turn = before.rotation.Inverse() * after.rotation
    turn = -turn if turn.w < 0 else turn
    log = turn.Log()
    return np.array([*(after.translation - before.translation), 2 * log.x, 2 * log.y, 2 * log.z]) / (2 * h)


# (time, position, rotation as w x y z) along WAY, as Gazebo 11.1's own PoseAnimation interpolates it.
ALONG_WAY = (
    (1.25, (0.156250, 0.429688, -0.023438), (0.988937, 0.058084, 0.032713, 0.132515)),
    (3.0, (1.703704, 1.888889, 0.296296), (0.475602, 0.072223, 0.185473, 0.856847)),
    (5.25, (2.750000, 0.500000, 1.125000), (-0.648885, 0.045718, -0.146344, 0.745280)),
    (6.5, (1.443149, -0.314869, 0.758017), (0.396782, 0.055139, 0.062298, -0.914135)),
    (8.0, (0.454810, -0.787172, 0.241983), (0.735687, -0.185960, 0.326835, -0.563349)),
)


@pytest.mark.parametrize(("time", "position", "rotation"), ALONG_WAY)
def test_the_way_between_uneven_key_frames_is_classics(time, position, rotation):
    anim = PoseAnimation("way", 10.0, False)
    pose_keys(anim, *WAY)
    key = at(anim, time)
    assert key.Translation().Equal(position, 1e-6)
    assert abs(key.Rotation().Dot(Quaterniond(*rotation))) == pytest.approx(1.0, abs=1e-6)


def test_a_closed_animation_is_smooth():
    anim = PoseAnimation("round", 4.0, True)
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 0)]
    pose_keys(anim, *((float(i), corner, (0, 0, 0)) for i, corner in enumerate(corners)))
    assert np.abs(velocities(anim, 1e-4) - velocities(anim, 4.0 - 1e-4)).max() < 0.01
    assert velocities(anim, 1e-4)[:2] == pytest.approx([0.5, -0.5], abs=0.01)
    anim.SetTime(3.5)
    anim.AddTime(1.0)
    assert anim.GetTime() == 0.5


@given(st.floats(0.0, 10.0), st.floats(-3.0, 3.0))
def test_a_single_key_frame_is_everywhere(time, x):
    anim = PoseAnimation("one", 10.0, False)
    pose_keys(anim, (5.0, (x, 0, 0), (0, 0, x)))
    assert at(anim, time).Translation() == Vector3d(x, 0, 0)


# Messages


@pytest.fixture
def records():
    gathered = []

    class Gather(logging.Handler):
        def emit(self, record):
            gathered.append(record)

    logger, handler = logging.getLogger("libgz.classic.console"), Gather()
    level, propagate = logger.level, logger.propagate
    logger.addHandler(handler)
    logger.setLevel(logging.DEBUG)
    logger.propagate = False
    yield gathered
    logger.removeHandler(handler)
    logger.setLevel(level)
    logger.propagate = propagate


def test_messages_have_a_level_and_the_callers_line(records):
    gzmsg("one", 1)
    gzdbg("two")
    gzwarn("three\n")
    gzerr("100 % sure")
    gzlog("five")
    levels = [logging.INFO, logging.DEBUG, logging.WARNING, logging.ERROR, logging.INFO]
    assert [record.levelno for record in records] == levels
    assert [record.getMessage() for record in records] == ["one 1", "two", "three", "100 % sure", "five"]
    assert {record.filename for record in records} == {Path(__file__).name}
    assert {record.funcName for record in records} == {"test_messages_have_a_level_and_the_callers_line"}
    assert [record.lineno - records[0].lineno for record in records] == [0, 1, 2, 3, 4]


def test_messages_as_streams(records):
    gzmsg << "x is " << 3 << "\n"
    gzerr << "no end of line"
    gzwarn << "two\nlines" << endl << "and a third" << endl
    texts = [record.getMessage() for record in records]
    assert texts == ["x is 3", "no end of line", "two\nlines", "and a third"]
    assert records[0].filename == Path(__file__).name
    assert records[1].lineno == records[0].lineno + 1
    assert records[1].levelno == logging.ERROR


def test_a_thrown_error_is_logged_too(records):
    with pytest.raises(GazeboError, match="out of range"):
        gzthrow("index out of range")
    assert records[0].getMessage() == "index out of range"
    assert records[0].filename == Path(__file__).name


def record_of(level, name="libgz.classic.console"):
    return logging.LogRecord(name, level, "/somewhere/plugin.py", 12, "text", (), None)


def test_the_form_of_messages():
    plain, colored = ConsoleFormatter(), ConsoleFormatter(color=True)
    assert plain.format(record_of(logging.INFO)) == "[Msg] text"
    assert plain.format(record_of(logging.DEBUG)) == "[Dbg] [plugin.py:12] text"
    assert plain.format(record_of(logging.WARNING)) == "[Wrn] [plugin.py:12] text"
    assert plain.format(record_of(logging.CRITICAL)) == "[Err] [plugin.py:12] text"
    assert colored.format(record_of(logging.ERROR)) == "\x1b[1;31m[Err] [plugin.py:12] text\x1b[0m"
    assert [colored.format(record_of(level))[4:6] for level in (10, 20, 30)] == ["36", "32", "33"]
    record = record_of(logging.ERROR)
    record.created = 12.5
    assert LogFormatter().format(record) == "(12 500000000) [plugin.py:12] text"
    record.levelno = logging.INFO
    assert LogFormatter().format(record) == "(12 500000000) text"


def test_plugins_may_colour_their_messages_and_what_comes_from_outside_commands_no_terminal():
    for name, shown in (("libgz.classic.console", "\x1b[1mtext\nmore"), ("libgz.ros", "\\x1b[1mtext\nmore")):
        record = record_of(logging.INFO, name)
        record.msg = "\x1b[1mtext\nmore"
        assert ConsoleFormatter().format(record) == f"[Msg] {shown}"
        assert LogFormatter().format(record).endswith(f") {shown}")


def test_errors_always_show_and_the_rest_when_verbose(capsys):
    for verbose in (False, True):
        handler = ConsoleHandler(verbose)
        for level in (logging.DEBUG, logging.INFO, logging.WARNING, logging.ERROR):
            if level >= handler.level:
                handler.handle(record_of(level))
        handler.handle(record_of(logging.ERROR, "libgz.classic.console.log"))
        shown = capsys.readouterr()
        assert shown.err == "[Wrn] [plugin.py:12] text\n[Err] [plugin.py:12] text\n"
        assert shown.out == ("[Dbg] [plugin.py:12] text\n[Msg] text\n" if verbose else "")


def test_colours_are_for_terminals(monkeypatch):
    class Terminal(io.StringIO):
        def isatty(self):
            return True

    monkeypatch.setattr(sys, "stderr", Terminal())
    ConsoleHandler().handle(record_of(logging.ERROR))
    assert sys.stderr.getvalue() == "\x1b[1;31m[Err] [plugin.py:12] text\x1b[0m\n"


# Search paths


@pytest.fixture
def system_paths(tmp_path, monkeypatch):
    for name in ("GAZEBO_PLUGIN_PATH", "GAZEBO_MODEL_PATH", "GAZEBO_RESOURCE_PATH", "GAZEBO_LOG_PATH"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    found = SystemPaths.Instance()
    yield found
    found.ClearPluginPaths()
    found.ClearModelPaths()
    found.ClearGazeboPaths()


def test_plugin_paths_are_read_anew_and_added_to(system_paths, monkeypatch):
    assert system_paths is SystemPaths.Instance()
    assert system_paths.GetPluginPaths() == []
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", "/a::/b")
    assert system_paths.GetPluginPaths() == ["/a", "/b"]
    system_paths.AddPluginPaths("/c:/a")
    system_paths.AddPluginPaths("/c")
    assert system_paths.GetPluginPaths() == ["/a", "/b", "/c"]
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", "")
    assert system_paths.GetPluginPaths() == ["/c", "/a"]


def test_variables_are_left_out_and_what_they_list_stays_until_it_is_cleared(system_paths, monkeypatch):
    lists = {
        "plugin": ("GAZEBO_PLUGIN_PATH", "Plugin"),
        "model": ("GAZEBO_MODEL_PATH", "Model"),
        "gazebo": ("GAZEBO_RESOURCE_PATH", "Gazebo"),
    }
    for name, (variable, kind) in lists.items():
        monkeypatch.setenv(variable, "/a")
        folders, attribute = getattr(system_paths, f"Get{kind}Paths"), f"{name}PathsFromEnv"
        assert getattr(system_paths, attribute)
        assert "/a" in folders()
        setattr(system_paths, attribute, False)
        monkeypatch.setenv(variable, "/b")
        getattr(system_paths, f"Add{kind}Paths")("/c")
        assert "/b" not in folders()
        assert [path for path in folders() if path in ("/a", "/c")] == ["/a", "/c"]
        getattr(system_paths, f"Clear{kind}Paths")()
        assert "/a" not in folders()
        setattr(system_paths, attribute, True)
        assert "/b" in folders()


def test_files_and_models_are_found(system_paths, monkeypatch, tmp_path, records):
    models, resources = tmp_path / "m", tmp_path / "r"
    (models / "robot").mkdir(parents=True)
    (resources / "media" / "models").mkdir(parents=True)
    (resources / "arena.world").touch()
    (resources / "media" / "models" / "mesh.stl").touch()
    assert system_paths.FindFileURI("model://robot") == ""
    system_paths.AddModelPaths(str(models))
    assert system_paths.FindFileURI("model://robot") == str(models / "robot")
    assert find_uri("model://robot") == models / "robot"  # what <include> uses
    assert system_paths.GetModelPaths()[0] == str(tmp_path / "home" / ".gazebo" / "models")
    assert system_paths.FindFile("arena.world") == ""
    monkeypatch.setenv("GAZEBO_RESOURCE_PATH", str(resources))
    assert system_paths.FindFile("arena.world") == str(resources / "arena.world")
    assert system_paths.FindFileURI("file://mesh.stl") == str(resources / "media" / "models" / "mesh.stl")
    assert system_paths.GetGazeboPaths() == [str(resources)]
    monkeypatch.chdir(models)
    assert system_paths.FindFile("robot") == str(models / "robot")
    assert system_paths.FindFile("robot", False) == system_paths.FindFile("") == ""
    assert system_paths.FindFile(str(models), False) == str(models)
    warned = [record.getMessage() for record in records]
    assert "Unable to find uri[model://robot]" in warned[0]
    assert warned[-1] == 'File or path does not exist [""] [robot]'


def test_the_folder_of_logs(system_paths, monkeypatch, tmp_path):
    assert system_paths.GetLogPath() == str(tmp_path / "home" / ".gazebo")
    monkeypatch.setenv("GAZEBO_LOG_PATH", "/var/log/gazebo")
    assert system_paths.GetLogPath() == "/var/log/gazebo"
