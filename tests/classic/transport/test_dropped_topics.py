"""Topics end with their last publisher and subscriber, so that inserts and deletes of new names need no memory."""

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
