"""Topics end with their last publisher and subscriber, so that inserts and deletes of new names need no memory."""

import gc

import libgz
from libgz.classic.transport.manager import TopicManager

EMPTY = "<sdf version='1.6'><world name='default'><plugin name='x' filename='libgz_position.so'/></world></sdf>"
MODEL = (
    "<sdf version='1.6'><model name='{}'><link name='link'><sensor name='imu' type='imu'><always_on>1</always_on>"
    "</sensor></link></model></sdf>"
)


def test_inserts_and_deletes_of_new_names_leave_no_topics():
    with libgz.World.from_string(EMPTY) as world:
        counts = []
        for i in range(12):
            world.facade.InsertModelString(MODEL.format(f"new{i}"))
            world.step(2)
            assert any(f"new{i}" in name for name in TopicManager.Instance().topics)
            world.facade.RemoveModel(f"new{i}")
            world.step(2)
            counts.append(len(TopicManager.Instance().topics))
        assert counts[2:] == [counts[2]] * 10


TOUCH = (
    "<sdf version='1.6'><world name='default'><model name='m'><link name='l'/><plugin name='t' "
    "filename='libTouchPlugin.so'><target>x</target><time>1</time><namespace>aside</namespace></plugin></model>"
    "<plugin name='c' filename='libContainPlugin.so'><entity>m</entity><namespace>aside</namespace>"
    "<pose>0 0 0 0 0 0</pose><geometry><box><size>1 1 1</size></box></geometry></plugin></world></sdf>"
)


def test_topics_of_plugins_outside_the_worlds_namespace_end_with_their_world():
    gc.disable()
    try:
        with libgz.World.from_string(TOUCH) as world:
            world.step()
            assert {"/aside/touched", "/aside/contain"} <= set(TopicManager.Instance().AdvertisedTopics())
        assert not [name for name in TopicManager.Instance().topics if name.startswith("/aside/")]
    finally:
        gc.enable()


FILTER = """
from libgz.classic.plugin import GZ_REGISTER_WORLD_PLUGIN, WorldPlugin
class Filter(WorldPlugin):
    def Load(self, world, sdf):
        self.topic = world.Physics().GetContactManager().CreateFilter("some", ["m::l::c"])
GZ_REGISTER_WORLD_PLUGIN(Filter)
"""


def test_a_filter_that_a_plugin_made_outlives_it(tmp_path):
    (tmp_path / "filter.py").write_text(FILTER)
    (tmp_path / "w.world").write_text(
        "<sdf version='1.6'><world name='default'><plugin name='f' filename='filter'/></world></sdf>"
    )
    with libgz.World.from_file(tmp_path / "w.world") as world:
        world.step()
        world.facade.RemovePlugin("f")
        assert world.facade.Physics().GetContactManager().HasFilter("some")
        assert "/gazebo/default/some/contacts" in TopicManager.Instance().AdvertisedTopics()
        world.step()
