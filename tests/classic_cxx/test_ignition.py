"""Joint commands of ignition-transport: by its library where it is installed, and by a stand-in for the rest."""

import ctypes
import subprocess
import threading

import pytest

import libgz
from libgz.classic import msgs
from libgz.classic.commands import Commands
from libgz.classic.server import attach
from libgz.classic.transport.manager import TopicManager
from libgz.classic_cxx.ignition import IgnitionTransport
from libgz.cxx.build import compiler

WORLD = """\
<sdf version="1.6"><world name="{name}"><model name="arm"><link name="base"/><link name="hand"/>
  <joint name="hinge" type="revolute"><parent>base</parent><child>hand</child><axis><xyz>0 0 1</xyz></axis></joint>
  <model name="inner"><link name="one"/><link name="two"/>
    <joint name="slide" type="prismatic"><parent>one</parent><child>two</child><axis><xyz>0 0 1</xyz></axis></joint>
  </model></model></world></sdf>
"""
# What the native part does, without ignition-transport.
STAND_IN = """\
#include <cstring>
#include <map>
#include <string>
typedef void (*Command)(const char *, const char *, size_t, int);
typedef int (*Request)(const char *, const char *, void *);
static std::map<std::string, int> models;
static Command command;
static Request request;
static std::string said;
extern "C" void *libgz_ignition_open(const char *model, Command c, Request r)
{
  command = c;
  request = r;
  return strchr(model, ' ') ? nullptr : new std::string((++models[model], model));
}
extern "C" void libgz_ignition_close(void *joints)
{
  auto *model = static_cast<std::string *>(joints);
  --models[*model];
  delete model;
}
extern "C" void libgz_ignition_reply(void *reply, const char *data, size_t size)
{
  static_cast<std::string *>(reply)->assign(data, size);
}
extern "C" int opened(const char *model) { return models[model]; }
extern "C" void send(const char *model, const char *data, size_t size, int inside)
{
  command(model, data, size, inside);
}
extern "C" const char *ask(const char *model, const char *joint, size_t *size)
{
  *size = request(model, joint, &said) ? said.size() : -1;
  return said.data();
}
"""


@pytest.fixture
def ignition(tmp_path):
    """The class's one object, with a stand-in for its native part; afterwards all topics are closed."""
    (tmp_path / "stand_in.cc").write_text(STAND_IN)
    library = tmp_path / "libstand_in.so"
    subprocess.run([*compiler(), "-shared", "-fPIC", "-o", library, tmp_path / "stand_in.cc"], check=True)
    transport = IgnitionTransport(library)
    functions = ctypes.CDLL(str(library))
    functions.ask.restype = ctypes.c_void_p
    functions.send.argtypes = [ctypes.c_char_p, ctypes.c_char_p, ctypes.c_size_t, ctypes.c_int]
    functions.ask.argtypes = [ctypes.c_char_p, ctypes.c_char_p, ctypes.POINTER(ctypes.c_size_t)]
    yield functions
    transport.close()


def send(ignition, model, inside=1, **fields):
    """Send a command, as a thread of ignition-transport does."""
    data = msgs.JointCmd(**fields).SerializeToString()
    thread = threading.Thread(target=ignition.send, args=(model, data, len(data), inside))
    thread.start()
    thread.join()


def asked(ignition, model, joint):
    size = ctypes.c_size_t()
    found = []

    def ask():
        data = ignition.ask(model, joint, ctypes.byref(size))
        none = size.value == ctypes.c_size_t(-1).value
        found.append(None if none else msgs.JointCmd.FromString(ctypes.string_at(data, size.value)))

    thread = threading.Thread(target=ask)
    thread.start()
    thread.join()
    return found[0]


def test_models_are_commanded_and_asked_while_they_are_there(ignition, caplog):
    with libgz.World.from_string(WORLD.format(name="one")) as world:
        arm = attach(world).world.ModelByName("arm")
        world.step()
        assert (ignition.opened(b"arm"), ignition.opened(b"arm/inner")) == (1, 1)
        with libgz.World.from_string(WORLD.format(name="two")) as other:  # of one name, all obey, as in one Gazebo
            attach(other)
            other.step()
            assert ignition.opened(b"arm") == 1
            send(ignition, b"arm", name="arm::hinge", force=0.25)
            other.step()
            assert attach(other).world.ModelByName("arm").GetJointController().GetForces() == {"arm::hinge": 0.25}
        assert ignition.opened(b"arm") == 1
        controller = arm.GetJointController()
        assert controller.GetForces() == {}
        assert world.models[0].sdf_joints["hinge"].position() == 0.0
        world.step()  # commands are obeyed in the next iteration
        assert controller.GetForces() == {"arm::hinge": 0.25}
        assert world.models[0].sdf_joints["hinge"].position() > 0.0
        send(ignition, b"arm", name="arm::hinge", position=msgs.PID(target=0.5, p_gain=7.0))
        send(ignition, b"arm/inner", name="arm::inner::slide", velocity=msgs.PID(target=-1.0))
        world.step()
        found = asked(ignition, b"arm", b"arm::hinge")
        assert (found.force, found.position.target, found.position.p_gain) == (0.25, 0.5, 7.0)
        assert not found.velocity.HasField("target")
        send(ignition, b"arm", name="arm::hinge", reset=True)
        world.step()
        assert asked(ignition, b"arm", b"arm::hinge").position.HasField("target") is False
        assert asked(ignition, b"arm", b"arm::hinge").position.p_gain == 7.0  # gains stay, and other joints' targets
        assert asked(ignition, b"arm/inner", b"arm::inner::slide").velocity.target == -1.0
        assert asked(ignition, b"leg", b"knee") is None
        send(ignition, b"arm", name="arm::none", force=1.0)
        world.step()
        assert "there is no joint 'arm::none'" in caplog.text
        world.facade.RemoveModel("arm")
        world.step()
        assert (ignition.opened(b"arm"), ignition.opened(b"arm/inner")) == (0, 0)


def test_a_world_that_steps_without_pause_answers(ignition):
    with libgz.World.from_string(WORLD.format(name="one")) as world:
        attach(world)
        world.step()
        done = threading.Event()
        stepping = threading.Thread(target=lambda: [world.step(1000) for _ in iter(done.is_set, True)])
        stepping.start()
        try:
            assert all(asked(ignition, b"arm", b"arm::hinge") is not None for _ in range(20))
        finally:
            done.set()
            stepping.join()


def test_a_server_that_is_only_watched_obeys_its_own_plugins_alone(ignition, monkeypatch, caplog):
    class Watched:
        client, watch_only = False, True

        def __getattr__(self, name):
            return lambda *_values: {} if name == "advertised" else []

    with libgz.World.from_string(WORLD.format(name="one")) as world:
        arm = attach(world).world.ModelByName("arm")
        monkeypatch.setattr(TopicManager.Instance(), "remote", Watched())
        send(ignition, b"arm", 0, name="arm::hinge", force=1.0)
        send(ignition, b"arm", 1, name="arm::hinge", force=2.0)
        world.step()
        assert arm.GetJointController().GetForces() == {"arm::hinge": 2.0}
        assert "this server can only be watched: /arm/joint_cmd is ignored" in caplog.text
        monkeypatch.setattr(TopicManager.Instance(), "remote", None)


def test_a_name_that_ignition_refuses(ignition, caplog):
    with libgz.World.from_string(WORLD.format(name="one").replace('"arm"', '"an arm"')) as world:
        attach(world)
        assert "ignition-transport has no topic /an arm/joint_cmd" in caplog.text


def test_worlds_of_one_name_obey_once_and_others_are_not_touched(ignition, monkeypatch):
    heard = []
    monkeypatch.setattr(Commands, "joint", lambda commands, message: heard.append((commands, message.force)))
    text = WORLD.format(name="one")
    with (
        libgz.World.from_string(text) as one,
        libgz.World.from_string(text) as other,
        libgz.World.from_string(text) as plain,
    ):
        for world in (one, other):
            attach(world)
        send(ignition, b"arm", name="arm::hinge", force=0.25)
        for world in (one, other):
            world.step()
        assert [force for _, force in heard] == [0.25, 0.25]
        assert len({commands for commands, _ in heard}) == 2
        assert plain.facade is None


def test_commands_that_a_closed_world_has_not_obeyed_take_no_room(ignition):
    received = TopicManager.Instance().received
    before = received.size
    with libgz.World.from_string(WORLD.format(name="one")) as world:
        attach(world)
        send(ignition, b"arm", name="arm::hinge", force=0.25)
        assert received.size > before
    assert received.size == before
