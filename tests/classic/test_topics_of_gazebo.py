"""Topics that Gazebo's server has, and libgz's had not; what describes entities."""

import pytest
from plugin_worlds import GROUND, body, collision, keep_to, worlds_of_elements
from topics import Heard

from libgz.base.errors import NotFoundError, ParameterError
from libgz.classic import event, msgs, transport
from libgz.classic.log import LogPlay, LogRecord
from libgz.classic.transport import Publisher


@pytest.fixture(autouse=True)
def own_places(monkeypatch, tmp_path):
    keep_to(tmp_path, monkeypatch)


@pytest.fixture
def run():
    yield from worlds_of_elements()


BOX = "<box><size>1 1 1</size></box>"
IMU = "<sensor name='imu' type='imu'/>"
BUMPER = "<sensor name='bumper' type='contact'><contact><collision>c</collision></contact></sensor>"


def test_a_link_with_an_imu_publishes_its_velocities_in_each_iteration(run):
    core, world = run(body("stone", "0 0 9 0 0 0", link=IMU), body("other"))
    heard, other = Heard("~/stone::link", latching=True), Heard("~/other::link", latching=True)
    world.ModelByName("stone").SetAngularVel((0.0, 0.0, 2.0))
    core.step(100)
    assert len(heard) in (99, 100)
    assert not other
    last = heard[-1]
    assert last.name == "stone::link"
    assert last.linear_velocity.z == pytest.approx(-9.8 * (last.time.nsec * 1e-9), rel=1e-6)
    assert last.angular_velocity.z == pytest.approx(2.0)
    world.RemoveModel("stone")
    core.step(2)
    assert "/gazebo/default/stone::link" not in transport.getAdvertisedTopics()


def test_a_contact_sensor_publishes_the_contacts_of_each_iteration(run):
    core, _ = run(GROUND, body("box", "0 0 0.5 0 0 0", link=collision(BOX) + BUMPER))
    heard = Heard("~/box/link/bumper/contacts", latching=True)
    core.step(50)
    assert len(heard) >= 48
    assert {heard[-1].contact[0].collision1, heard[-1].contact[0].collision2} == {
        "box::link::c", "ground_plane::link::collision",
    }  # fmt: skip


def test_a_world_has_a_gui_topic_and_that_of_skeletons_only_with_actors(run):
    run(body("box"))
    topics = transport.getAdvertisedTopics()
    assert {"/gazebo/default/gui", "/gazebo/world/modify", "/gazebo/default/model/modify"} <= set(topics)
    assert "/gazebo/default/skeleton_pose/info" not in topics


def test_statistics_of_a_played_log_have_its_times(run, tmp_path):
    core, world = run(body("stone", "0 0 9 0 0 0"))
    with LogRecord(world, tmp_path / "state.log"):
        core.step(200)
    with LogPlay(tmp_path / "state.log") as play:
        statistics = play.world.server.topics._periodic[0]._make().log_playback_stats
        begin, end = ((t.sec + 1e-9 * t.nsec) for t in (statistics.start_time, statistics.end_time))
        assert begin < 0.01
        assert end == pytest.approx(0.2, abs=0.01)


def test_user_commands_are_published_for_other_processes(run, monkeypatch):
    core, world = run(body("box"))
    sent, publish = [], Publisher.Publish

    def note(self, message, *values, **options):
        sent.append((self.GetTopic(), type(message), options))
        return publish(self, message, *values, **options)

    monkeypatch.setattr(Publisher, "Publish", note)
    command = msgs.UserCmd(id=1, description="move", type="MOVING")
    model = command.model.add(name="box")
    msgs.Set(model.pose.position, (1.0, 0.0, 0.0))
    model.pose.orientation.w = 1.0
    node = transport.Node()
    node.Init("default")
    kept = node.Advertise(msgs.UserCmd, "~/user_cmd")
    kept.Publish(command)
    core.step(3)
    assert world.ModelByName("box").WorldPose().Pos().X() == pytest.approx(1.0)
    assert [one for one in sent if one[0].endswith("/model/modify")] == [
        ("/gazebo/default/model/modify", msgs.Model, {"here": False})
    ]
    del kept


def test_fill_msg_describes_what_classic_describes(run):
    _, world = run(GROUND, body("box", "0 0 0.5 0 0 0", link=collision(BOX)), "<light name='lamp' type='point'/>")
    box = world.ModelByName("box")
    link, lamp = box.GetLink("link"), world.LightByName("lamp")
    for entity, message in ((box, msgs.Model()), (link, msgs.Link()), (lamp, msgs.Light())):
        entity.FillMsg(message)
        assert message.name == entity.GetScopedName()
    shape = msgs.Collision()
    link.GetCollision("c").FillMsg(shape)
    assert shape.geometry.box.size.x == 1.0
    with pytest.raises(ParameterError, match="no message describes"):
        world.FillMsg(msgs.Model())


def test_a_contact_fills_a_message(run):
    core, world = run(GROUND, body("box", "0 0 0.5 0 0 0", link=collision(BOX)))
    manager = world.Physics().GetContactManager()
    manager.SetNeverDropContacts(True)
    core.step(20)
    (contact,) = manager.GetContacts()
    message = msgs.Contact()
    contact.FillMsg(message)
    assert {message.collision1, message.collision2} == set(contact.names)
    assert (message.world, len(message.position), message.time.nsec) == ("default", contact.count, contact.time.nsec)
    assert abs(sum(one.body_1_wrench.force.z for one in message.wrench)) == pytest.approx(9.8, rel=0.05)
    assert contact.DebugString().count("Depth[") == contact.count > 0
    contact.Reset()
    assert contact.count == 0


def test_an_entity_is_placed_on_another_one(run):
    _, world = run(body("table", "3 1 2 0 0 0", link=collision(BOX)), body("cup", link=collision(BOX)))
    world.ModelByName("cup").PlaceOnEntity("table")
    assert tuple(world.ModelByName("cup").WorldPose().Pos()) == pytest.approx((3.0, 1.0, 3.0))
    with pytest.raises(NotFoundError, match="no entity 'chair'"):
        world.ModelByName("cup").PlaceOnEntity("chair")


def test_events_of_plugins_need_no_name():
    heard, own = [], event.EventT()
    kept = own.Connect(heard.append)
    own(5)
    own.Signal(6)
    assert heard == [5, 6]
    del kept
