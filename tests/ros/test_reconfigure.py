"""What tools of dynamic_reconfigure read and set: cameras, wheels that slip, physics."""

import pytest
from ros_node import Node
from ros_peers import wait_for

from libgz.classic.plugins._wheelslip import MOST_SLIP
from libgz.classic.server import attach
from libgz.ros.reconfigure import Knob
from libgz.ros.types import message_type

CONFIG = message_type("dynamic_reconfigure/Config")
WORLD = """<sdf version='1.6'><world name='default'><model name='m'><static>1</static><link name='l'>
<sensor name='eye' type='camera'><update_rate>30</update_rate>
<camera><image><width>16</width><height>12</height></image></camera>
<plugin name='p' filename='libgazebo_ros_camera.so'><robotNamespace>/r</robotNamespace><cameraName>eye</cameraName>
</plugin></sensor></link></model>
<model name='car'><pose>0 5 0.5 0 0 0</pose><link name='body'/>
<link name='wheel'><collision name='c'><geometry><sphere><radius>0.5</radius></sphere></geometry></collision></link>
<joint name='j' type='revolute'><parent>body</parent><child>wheel</child><axis><xyz>0 1 0</xyz></axis></joint>
<plugin name='slip' filename='libgazebo_ros_wheel_slip.so'><wheel link_name='wheel'>
<slip_compliance_lateral>inf</slip_compliance_lateral><slip_compliance_longitudinal>0.3</slip_compliance_longitudinal>
<wheel_normal_force>10</wheel_normal_force></wheel></plugin></model></world></sdf>"""


def doubles(**values):
    kind = message_type("dynamic_reconfigure/DoubleParameter")
    return CONFIG(doubles=[kind(name=name, value=value) for name, value in values.items()])


def values_of(config):
    return {one.name: one.value for part in ("bools", "ints", "doubles") for one in getattr(config, part)}


def reconfigure(node, space, config):
    return values_of(node.ask(f"{space}/set_parameters", "dynamic_reconfigure/Reconfigure", config=config).config)


@pytest.fixture
def node(master, start):
    return Node(master, *start(WORLD))


def test_the_rate_of_a_camera(node):
    about = node.topic("/r/eye/parameter_descriptions", "dynamic_reconfigure/ConfigDescription")()
    (group,) = about.groups
    assert [(one.name, one.type, one.level) for one in group.parameters] == [("imager_rate", "double", 3)]
    limits = (values_of(one)["imager_rate"] for one in (about.min, about.dflt, about.max))
    assert list(limits) == [1.0, 2.0, 50.0]
    assert [(one.name, one.state) for one in about.max.groups] == [("Default", True)]
    images = node.topic("/r/eye/camera_info", "sensor_msgs/CameraInfo")
    first, second = images(), images()
    assert second.header.stamp.seconds - first.header.stamp.seconds == pytest.approx(1 / 30, abs=1e-3)
    assert reconfigure(node, "/r/eye", doubles(imager_rate=20.0)) == {"imager_rate": 20.0}
    for _ in range(3):
        first, second = second, images()
    assert second.header.stamp.seconds - first.header.stamp.seconds == pytest.approx(0.05)
    wait_for(lambda: node.master.parameters.get("/r/eye/imager_rate") == 20.0)
    updates = node.topic("/r/eye/parameter_updates", "dynamic_reconfigure/Config")
    assert values_of(updates()) == {"imager_rate": 20.0}  # latched
    assert reconfigure(node, "/r/eye", doubles(imager_rate=1e9)) == {"imager_rate": 50.0}


def test_what_cannot_be_set_is_refused_with_its_reason(node, caplog):
    assert reconfigure(node, "/r/eye", doubles(imager_rate=float("nan"), other=1.0)) == {"imager_rate": 2.0}
    assert "imager_rate is nan; it must be a number" in caplog.text
    assert "there is no float 'other'; there are imager_rate" in caplog.text


def test_slips_begin_with_the_parameters_and_an_infinite_one_is_no_friction(master, start, caplog):
    master.parameters["/car/wheel_slip/slip_compliance_unitless_longitudinal"] = 2
    node = Node(master, *start(WORLD))
    car = attach(node.core).world.ModelByName("car")
    surface = car.GetLink("wheel").GetCollisions()[0].GetSurface()

    def slips(speed):
        car.GetJoint("j").SetVelocity(0, speed)
        node.core.Step()
        return surface.slip1, surface.slip2

    assert slips(0.0) == (0.0, 0.0)
    assert slips(4.0) == (MOST_SLIP, pytest.approx(0.4, rel=0.01))  # 2 * 0.5 m * 4 rad/s / 10 N
    doubled = doubles(slip_compliance_unitless_lateral=1, slip_compliance_unitless_longitudinal=4)
    reconfigure(node, "/car/wheel_slip", doubled)
    assert slips(4.0) == pytest.approx((0.2, 0.8), rel=0.02)
    assert "Traceback" not in caplog.text


def test_physics_are_those_of_the_world_at_first(node):
    found = reconfigure(node, "/gazebo", CONFIG())
    assert (found["time_step"], found["sor_pgs_iters"], found["auto_disable_bodies"]) == (0.001, 50, False)
    changed = doubles(gravity_z=-1.6, time_step=0.002)
    changed.ints = [message_type("dynamic_reconfigure/IntParameter")(name="sor_pgs_iters", value=70)]
    assert reconfigure(node, "/gazebo", changed)["sor_pgs_iters"] == 70
    properties = node.call("get_physics_properties")
    assert (properties.gravity.z, properties.time_step, properties.ode_config.sor_pgs_iters) == (-1.6, 0.002, 70)
    assert reconfigure(node, "/gazebo", doubles(time_step=0.0))["time_step"] == 0.002  # ODE needs one


def test_values_have_the_types_of_their_defaults():
    assert Knob("n", 3, 0, 10, "").limited(20.7) == 10
    assert Knob("x", 0.0, -1.0, 1.0, "").limited(10**400) == 1.0
    assert Knob("on", False, False, True, "").limited(1) is True
