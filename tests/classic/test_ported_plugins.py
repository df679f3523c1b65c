"""Ten plugins as their authors would port them from C++, line by line, with names of either generation of Gazebo."""

import math

import pytest
from plugin_worlds import GROUND, HINGE, body, collision, plugin

from libgz.classic import msgs, transport
from libgz.classic.math import Vector3d

HEAD = "from libgz.classic import *\nfrom libgz.classic.event import Events\n\n\n"
BOX = "<box><size>1 1 1</size></box>"

SINE = """
class SineMove(ModelPlugin):
    def Load(self, _parent, _sdf):
        self.model = _parent
        self.amplitude = _sdf.GetElement("amplitude").GetValueDouble()
        self.start = self.model.GetWorldPose()
        self.updateConnection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def OnUpdate(self, _info):
        t = self.model.GetWorld().GetSimTime().Double()
        pose = math.Pose(self.start.pos + math.Vector3(0, 0, self.amplitude * math.sin(t)), self.start.rot)
        self.model.SetWorldPose(pose)


GZ_REGISTER_MODEL_PLUGIN(SineMove)
"""

LOGGER = """
class ImuLogger(SensorPlugin):
    def Load(self, _sensor, _sdf):
        self.parentSensor = sensors.get_sensor(_sensor.ScopedName())
        self.file = _sdf.Get(str, "file")
        self.updateConnection = self.parentSensor.ConnectUpdated(self.OnUpdate)
        self.parentSensor.SetActive(True)

    def OnUpdate(self):
        a = self.parentSensor.LinearAcceleration()
        with open(self.file, "a") as file:
            file.write(f"{self.parentSensor.LastMeasurementTime().Double():.3f} {a.Z():.3f}\\n")


GZ_REGISTER_SENSOR_PLUGIN(ImuLogger)
"""

KEYS = """
class KeyMove(ModelPlugin):
    def Load(self, _model, _sdf):
        self.model = _model
        self.vel = math.Vector3d.Zero
        self.node = transport.Node()
        self.node.Init(_model.GetWorld().Name())
        self.keySub = self.node.Subscribe("~/keyboard/keypress", self.OnKeyPress)
        self.conn = Events.ConnectWorldUpdateBegin(lambda: self.model.SetLinearVel(self.vel))

    def OnKeyPress(self, _msg):
        key = _msg.int_value
        if key == ord("w"):
            self.vel.X(1.5)
        elif key == ord("s"):
            self.vel.Set(0, 0, 0)


GZ_REGISTER_MODEL_PLUGIN(KeyMove)
"""

PID = """
class PidCommander(ModelPlugin):
    def Load(self, _model, _sdf):
        if _model.GetJointCount() == 0:
            gzerr << "Invalid joint count, plugin not loaded" << endl
            return
        self.joint = _model.GetJoints()[0]
        self.pid = common.PID(20, 0, 4)
        controller = _model.GetJointController()
        controller.SetPositionPID(self.joint.GetScopedName(), self.pid)
        controller.SetPositionTarget(self.joint.GetScopedName(), _sdf.Get(float, "target", 1.0)[0])


GZ_REGISTER_MODEL_PLUGIN(PidCommander)
"""

LIGHTS = """
class LightAnimator(WorldPlugin):
    def Load(self, _world, _sdf):
        self.world = _world
        self.node = transport.Node()
        self.node.Init(_world.Name())
        self.pub = self.node.Advertise(msgs.Light, "~/light/modify")
        self.conn = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def OnUpdate(self, info):
        msg = msgs.Light()
        msg.name = "lamp"
        msg.range = 5 + info.simTime.Double()
        msgs.Set(msg.diffuse, common.Color(info.simTime.Double() % 1.0, 0, 0, 1))
        self.pub.Publish(msg)


GZ_REGISTER_WORLD_PLUGIN(LightAnimator)
"""

CONTACTS = """
class ContactCounter(WorldPlugin):
    def Load(self, _world, _sdf):
        self.world, self.count = _world, 0
        self.manager = _world.Physics().GetContactManager()
        self.manager.SetNeverDropContacts(True)
        self.conn = Events.ConnectWorldUpdateEnd(self.OnUpdate)

    def OnUpdate(self):
        self.count = 0
        for i in range(self.manager.GetContactCount()):
            contact = self.manager.GetContact(i)
            shape = contact.collision1.GetShape()
            if shape.HasType(physics.Base.BOX_SHAPE) or contact.collision2.GetShape().HasType(physics.Base.BOX_SHAPE):
                self.count += contact.count
        msg = msgs.GzString(data=str(self.count))
        self.node = transport.Node()
        self.node.Init(self.world.Name())
        self.node.Publish("~/contact_count", msg)


GZ_REGISTER_WORLD_PLUGIN(ContactCounter)
"""

BATTERY = """
class Consumer(ModelPlugin):
    def Load(self, _model, _sdf):
        self.link = _model.GetLink("link")
        self.battery = self.link.Battery("cell")
        if self.battery is None:
            gzthrow("no battery")
        self.charge = _sdf.Get(float, "charge")
        self.consumerId = self.battery.AddConsumer()
        self.battery.SetPowerLoad(self.consumerId, _sdf.Get(float, "load"))
        self.battery.SetUpdateFunc(self.OnUpdateVoltage)

    def OnUpdateVoltage(self, _battery):
        dt = self.link.GetWorld().Physics().GetMaxStepSize()
        total = sum(_battery.PowerLoads().values())
        self.charge -= total / _battery.Voltage() * dt / 3600.0
        return _battery.InitVoltage() * self.charge


GZ_REGISTER_MODEL_PLUGIN(Consumer)
"""

FIELD = """
class ForceField(WorldPlugin):
    def Load(self, _world, _sdf):
        self.world = _world
        self.box = math.OrientedBoxd(_sdf.Get(math.Vector3d, "size"), _sdf.Get(math.Pose3d, "pose"))
        self.force = _sdf.Get(math.Vector3d, "force")
        self.conn = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def OnUpdate(self):
        with self.world.Physics().GetPhysicsUpdateMutex():
            for model in self.world.Models():
                for link in model.GetLinks():
                    if not model.IsStatic() and self.box.Contains(link.WorldCoGPose().Pos()):
                        link.AddForce(self.force)


GZ_REGISTER_WORLD_PLUGIN(ForceField)
"""

SPAWNER = """
class Spawner(WorldPlugin):
    def Load(self, _world, _sdf):
        self.world, self.next = _world, common.Time(0.1)
        self.conn = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def OnUpdate(self, info):
        if info.simTime < self.next or self.world.ModelCount() >= 3:
            return
        self.next = info.simTime + common.Time(0.1)
        doc = sdf.SDF()
        doc.SetFromString("<sdf version='1.5'><model name='ball'><link name='l'/></model></sdf>")
        model = doc.Root().GetElement("model")
        model.GetAttribute("name").SetFromString(self.world.UniqueModelName("ball"))
        self.world.InsertModelSDF(doc)


GZ_REGISTER_WORLD_PLUGIN(Spawner)
"""

SAVER = """
class FrameSaver(SensorPlugin):
    def Load(self, _sensor, _sdf):
        self.camera = _sensor.Camera()
        self.folder, self.count = _sdf.Get(str, "folder"), 0
        self.newFrameConnection = self.camera.ConnectNewImageFrame(self.OnNewFrame)
        _sensor.SetActive(True)

    def OnNewFrame(self, _image, _width, _height, _depth, _format):
        image = common.Image()
        image.SetFromData(_image, _width, _height, common.Image.RGB_INT8)
        image.SavePNG(f"{self.folder}/frame-{self.count:03d}.png")
        self.count += 1


GZ_REGISTER_SENSOR_PLUGIN(FrameSaver)
"""


@pytest.fixture
def port(tmp_path, run):
    """Writes a plugin's file, and makes a world of elements: (engine's world, view)."""

    def start(name, text, *elements):
        (tmp_path / f"{name}.py").write_text(HEAD + text)
        return run(*elements)

    return start


def test_a_model_moves_by_a_sine(port):
    moved = body("box", pose="0 0 2 0 0 0", gravity="false", inside=plugin("sine", amplitude=0.5))
    core, world = port("sine", SINE, moved)
    core.run(1.0)
    assert world.ModelByName("box").WorldPose().Pos().Z() == pytest.approx(2.0 + 0.5 * math.sin(1.0), abs=1e-3)


def test_a_sensor_is_logged(port, tmp_path):
    log = tmp_path / "imu.txt"
    sensor = f"<sensor name='imu' type='imu'><update_rate>10</update_rate>{plugin('imu_log', file=log)}</sensor>"
    core, _ = port("imu_log", LOGGER, body("box", pose="0 0 .5 0 0 0", link=sensor + collision(BOX)), GROUND)
    core.run(1.0)
    rows = [tuple(map(float, line.split())) for line in log.read_text().splitlines()]
    assert len(rows) in (10, 11)
    assert rows[-1] == pytest.approx((rows[0][0] + 0.1 * (len(rows) - 1), 9.8), abs=0.01)


def test_a_keyboard_moves_a_model(port):
    core, world = port("keys", KEYS, body("box", gravity="false", inside=plugin("keys")))
    node = transport.Node()
    node.Init("default")
    keys = node.Advertise(msgs.Any, "~/keyboard/keypress")
    for key, way in (("w", 1.5), ("s", 1.5)):
        keys.Publish(msgs.Any(type=msgs.Any.INT32, int_value=ord(key)))
        core.step()
        core.run(1.0)
        assert world.ModelByName("box").WorldPose().Pos().X() == pytest.approx(way, abs=0.01)


def test_a_joint_is_held_by_a_pid(port):
    inside = HINGE.format(name="h") + plugin("pid", target=0.7)
    core, world = port("pid", PID, body("arm", gravity="false", inside=inside))
    core.run(5.0)
    assert world.ModelByName("arm").GetJoint("h").Position(0) == pytest.approx(0.7, abs=0.01)


def test_a_light_is_animated_by_its_topic(port):
    lamp = "<light name='lamp' type='point'><attenuation><range>5</range></attenuation></light>"
    core, world = port("lights", LIGHTS, lamp, body("box", gravity="false"), plugin("lights"))
    core.run(0.5)
    assert world.LightByName("lamp").DiffuseColor().R() == pytest.approx(0.5, abs=0.01)
    assert world.LightByName("lamp").Range() == pytest.approx(5.5, abs=0.01)


def test_contacts_of_boxes_are_counted(port):
    node, seen = transport.Node(), []
    box = body("box", pose="0 0 0.5 0 0 0", link=collision(BOX))
    ball = body("ball", pose="5 0 0.5 0 0 0", link=collision("<sphere><radius>0.5</radius></sphere>"))
    core, _ = port("contacts", CONTACTS, box, ball, GROUND, plugin("contacts"))
    node.Init("default")
    kept = node.Subscribe("~/contact_count", lambda message: seen.append(int(message.data)))
    core.run(0.2)
    assert seen[-1] == 4
    del kept


def test_a_battery_is_discharged(port):
    cell = "<battery name='cell'><voltage>12</voltage></battery>"
    core, world = port("eat", BATTERY, body("box", link=cell, inside=plugin("eat", charge=1.0, load=43200)))
    core.run(0.1)  # 12 V times 1 Ah: 43.2 kW empty it within a second
    assert world.ModelByName("box").GetLink().Battery(0).Voltage() == pytest.approx(12.0 * 0.894, abs=0.1)


def test_a_force_field_pushes_what_is_in_it(port):
    field = plugin("field", size="2 2 2", pose="0 0 0 0 0 0", force="0 3 0")
    bodies = (body("inside", gravity="false"), body("outside", pose="5 0 0 0 0 0", gravity="false"))
    core, world = port("field", FIELD, *bodies, field)
    core.run(0.5)
    assert world.ModelByName("inside").WorldLinearVel().Y() == pytest.approx(1.5, abs=0.01)
    assert world.ModelByName("outside").WorldLinearVel() == Vector3d()


def test_models_are_spawned_with_new_names(port):
    core, world = port("spawn", SPAWNER, plugin("spawn"))
    core.run(1.0)
    assert sorted(model.GetName() for model in world.Models()) == ["ball", "ball_0", "ball_1"]


def test_images_of_a_camera_are_saved(port, tmp_path):
    image = "<image><width>16</width><height>8</height></image>"
    camera = f"<camera>{image}</camera><update_rate>10</update_rate>{plugin('saver', folder=tmp_path)}"
    sensor = f"<sensor name='eye' type='camera'>{camera}</sensor>"
    core, _ = port("saver", SAVER, body("box", gravity="false", link=sensor))
    core.run(0.5)
    assert len(list(tmp_path.glob("frame-*.png"))) in (4, 5, 6)
