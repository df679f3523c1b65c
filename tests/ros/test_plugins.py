"""The plugins of gazebo_ros_pkgs in a world: topics, frames, rates, values; the services of /gazebo."""

import io
import math
import re
import struct
from itertools import pairwise
from pathlib import Path

import pytest
from PIL import Image
from ros_node import Node
from ros_peers import Talker, open_topic, read_block, wait_for

from libgz import World
from libgz.ros.packing import codec
from libgz.ros.plugin import Ticks, bounded_rate
from libgz.ros.reference import page, plugin_page
from libgz.ros.session import Publication
from libgz.ros.types import message_type, service_type
from libgz.ros.world import RosWorld
from libgz.simulation.problems import Problem
from libgz.simulation.stepping import Stepping

BOX = "<sdf version='1.6'><model name='m'><link name='l'/></model></sdf>"


class Recorder:
    """Counts the calls of a function."""

    def __init__(self, function):
        self.function, self.count = function, 0

    def __call__(self, *values):
        self.count += 1
        return self.function(*values)


@pytest.fixture
def node(master, start):
    return Node(master, *start())


def seconds(message):
    return message.header.stamp.seconds


def test_a_robot_publishes_what_it_would_in_gazebo(node):
    odometry, scan = node.topic("/odom", "nav_msgs/Odometry"), node.topic("/scan", "sensor_msgs/LaserScan")
    imu, truth = node.topic("/robot/imu", "sensor_msgs/Imu"), node.topic("/truth", "nav_msgs/Odometry")
    joints = node.topic("/robot/joint_states", "sensor_msgs/JointState")
    first, second = odometry(), odometry()
    assert [first.header.frame_id, first.child_frame_id] == ["odom", "base"]
    assert first.pose.covariance[::7].tolist() == [1e-5, 1e-5, 1e12, 1e12, 1e12, 1e-3]
    assert not first.twist.covariance.any()
    assert (first.header.seq, second.header.seq) == (0, 1)
    assert 0.032 < seconds(second) - seconds(first) < 0.035  # 30 Hz
    found = scan()
    assert found.header.frame_id == "laser_frame"
    assert len(found.ranges) == len(found.intensities) == 181
    assert found.ranges[90] == pytest.approx(1.95, abs=1e-3)
    assert (found.intensities[90], found.ranges[0]) == (120.0, math.inf)
    assert [round(found.angle_min, 4), round(found.angle_max, 4), round(found.range_max, 4)] == [-1.5708, 1.5708, 5.0]
    measured, after = imu(), imu()
    assert measured.linear_acceleration.z == pytest.approx(9.8, abs=0.05)
    assert measured.header.frame_id == "base"
    assert seconds(after) - seconds(measured) == pytest.approx(0.02)
    place = truth()
    assert [place.header.frame_id, place.child_frame_id] == ["world", "base"]
    assert place.pose.covariance[::7].tolist() == place.twist.covariance[::7].tolist() == pytest.approx([1e-4] * 6)
    states = joints()
    assert states.name == ["left_joint", "right_joint"]
    assert (len(states.velocity), len(states.effort)) == (2, 0)


def test_commands_move_it_and_transforms_follow(node):
    odometry, transforms = node.topic("/odom", "nav_msgs/Odometry"), node.topic("/tf", "tf2_msgs/TFMessage")
    twist = message_type("geometry_msgs/Twist")
    wait_for(lambda: "/cmd_vel" in node.master.subscribers, node.core.Step)
    talker = Talker(node.master, "/cmd_vel", twist.name, twist.md5)
    command = twist()
    command.linear.x, command.angular.z = 0.2, 0.5
    talker.send(codec(twist).pack(command))
    wait_for(lambda: odometry().twist.twist.linear.x > 0.15)
    begin = odometry()
    for _ in range(15):
        end = odometry()
    assert end.twist.twist.linear.x == pytest.approx(0.2, abs=0.03)
    assert end.twist.twist.angular.z == pytest.approx(0.5, abs=0.05)
    assert seconds(end) - seconds(begin) == pytest.approx(0.5, abs=0.002)
    found = {}
    while len(found) < 3:
        (one,) = transforms().transforms
        found[one.header.frame_id, one.child_frame_id] = one
    assert set(found) == {("odom", "base"), ("base", "left_wheel"), ("base", "right_wheel")}
    assert found["base", "left_wheel"].transform.translation.y == pytest.approx(0.12, abs=1e-3)
    command.linear.x = math.nan
    drive = node.core.facade.server.plugins.of_model(node.core.facade.ModelByName("robot"))[0].plugin
    drive.commands._call = seen = Recorder(drive.commands._call)
    talker.send(codec(twist).pack(command))
    wait_for(lambda: seen.count, odometry)
    for _ in range(3):
        end = odometry()
    assert end.twist.twist.linear.x == pytest.approx(0.2, abs=0.03)  # it was not obeyed
    for joint in (*drive.left, *drive.right):
        joint.SetParam("vel", 0, 0.0)  # as another plugin may; the next tick sets the command's speeds again
    for _ in range(10):
        end = odometry()
    assert end.twist.twist.linear.x == pytest.approx(0.2, abs=0.03)
    talker.close()


def test_contacts_and_the_clock(node):
    bumper, clock = node.topic("/bumper", "gazebo_msgs/ContactsState"), node.topic("/clock", "rosgraph_msgs/Clock")
    (state, *_) = wait_for(lambda: bumper().states)
    assert state.collision1_name == "robot::base::caster"
    assert state.collision2_name == "ground::link::c"
    assert state.total_wrench.force.z == pytest.approx(sum(one.force.z for one in state.wrenches))
    assert len(state.contact_positions) == len(state.contact_normals) == len(state.depths) > 0
    times = [clock().clock.seconds for _ in range(20)]
    assert [round((b - a) * 1e3) for a, b in pairwise(times)] == [1] * 19  # each step


def test_the_clock_has_its_frequency(master, start):
    master.parameters["/gazebo/pub_clock_frequency"] = 30
    clock = Node(master, *start("<sdf version='1.6'><world name='default'/></sdf>")).topic(
        "/clock", "rosgraph_msgs/Clock"
    )
    first = clock().clock.seconds
    for _ in range(30):
        last = clock().clock.seconds
    assert last - first == pytest.approx(1.0, abs=1e-3)


def test_a_model_without_joints_has_empty_joint_states(master, start):
    states = "<plugin name='p' filename='libgazebo_ros_joint_state_publisher.so'/>"
    model = f"<model name='m'><link name='l'/>{states}</model>"
    node = Node(master, *start(f"<sdf version='1.6'><world name='default'>{model}</world></sdf>"))
    found = node.topic("/m/joint_states", "sensor_msgs/JointState")()
    assert (len(found.name), len(found.position), len(found.velocity)) == (0, 0, 0)


def test_the_clock_is_at_0_before_sim_time_is(master, start):
    node = Node(master, *start("<sdf version='1.6'><world name='default'/></sdf>"))
    clock = node.topic("/clock", "rosgraph_msgs/Clock")
    clock()
    node.core.set_sim_time(-1.0)
    while (last := clock().clock.seconds) != 0.0:
        pass
    node.core.step(10)
    node.core.set_sim_time(1.0)
    while last < 1.0:
        last = clock().clock.seconds
        assert last == 0.0 or last > 1.0


def test_native_code_makes_the_messages_of_listened_plugins(master, start, monkeypatch):
    world = re.sub("<sensor.*?</sensor>", "", (Path(__file__).parent / "turtle.world").read_text(), flags=re.DOTALL)
    world = re.sub("<gaussianNoise>.*?</gaussianNoise>", "", world)
    master.parameters["/gazebo/pub_clock_frequency"] = 10
    world = world.replace("<publishWheelTF>", "<odometrySource>encoder</odometrySource><publishWheelTF>")
    node = Node(master, *start(world))
    rates = {"/truth": 40, "/odom": 30, "/robot/joint_states": 50, "/clock": 10, "/tf": 30}
    publications = {}
    for name in rates:
        wait_for(lambda name=name: master.publishers.get(name))
        publications[name] = open_topic(master, name)[0], node.ros.node.publication(name)
    wait_for(lambda: all(one.readers for _, one in publications.values()), node.core.Step)
    node.core.step(50)
    stepped, handed = Recorder(Stepping.run_in_python), Recorder(Publication.send_body)
    monkeypatch.setattr(Stepping, "run_in_python", lambda stepping: stepped(stepping))
    monkeypatch.setattr(Publication, "send_body", lambda *values: handed(*values))
    begin = node.core.GetSimTime()
    node.core.step(1000)
    assert max(stepped.count, handed.count) <= 4  # at the end of a look, every so many steps
    for name, rate in rates.items():
        sock, publication = publications[name]
        times, last = set(), 0.0
        while last <= begin + 1.0 - 1.0 / rate + 1e-6:
            message = publication.codec.unpack(read_block(sock))
            one = message.transforms[0] if name == "/tf" else message
            last = (one.clock if name == "/clock" else one.header.stamp).seconds
            times |= {last} if last > begin + 1e-6 else set()
        assert len(times) == rate, name


def test_a_sensor_measures_only_while_somebody_listens(node):
    core = node.core
    sensor = core.facade.server.sensors
    laser = next(one for name, one in sensor.sensors.items() if name.endswith("laser"))
    core.Step()
    assert not laser.IsActive()
    scan = node.topic("/scan", "sensor_msgs/LaserScan")
    scan()
    assert laser.IsActive()
    for sock in node.master.sockets:
        sock.close()
    wait_for(lambda: not laser.IsActive(), core.Step)


def test_states_of_models_and_links(node):
    states = node.topic("/gazebo/model_states", "gazebo_msgs/ModelStates")()
    assert states.name == ["ground", "wall", "robot"]
    assert [round(states.pose[1].position.x, 3), round(states.pose[1].position.z, 3)] == [2.0, 0.5]
    links = node.topic("/gazebo/link_states", "gazebo_msgs/LinkStates")
    found = links()
    assert found.name == ["ground::link", "wall::link", "robot::base", "robot::left_wheel", "robot::right_wheel"]
    node.call("delete_model", model_name="wall")
    wait_for(lambda: links().name == ["ground::link", *found.name[2:]])
    base = node.core.facade.EntityByName("robot::base")
    base.SetAngularVel((0.0, 0.0, 2.0))
    link = wait_for(lambda: next((t for t in links().twist[1:2] if t.angular.z > 1.0), None))
    assert link.angular.z == pytest.approx(2.0, abs=0.5)


def test_services_of_gazebo(node):
    assert node.call("get_world_properties").model_names == ["ground", "wall", "robot"]
    state = node.call("get_model_state", model_name="wall", relative_entity_name="robot")
    assert state.success
    assert state.pose.position.x == pytest.approx(2.0, abs=0.01)
    assert node.call("get_model_state", model_name="wal").status_message == "GetModelState: model does not exist"
    moved = message_type("gazebo_msgs/ModelState")(model_name="robot")
    moved.pose.position.y = 1.0
    assert node.call("set_model_state", model_state=moved).success
    assert node.call("get_model_state", model_name="robot").pose.position.y == pytest.approx(1.0, abs=0.01)
    moved.pose.position.y = math.nan
    assert "not finite" in node.call("set_model_state", model_state=moved).status_message
    node.call("pause_physics")
    assert node.core.paused
    node.call("unpause_physics")
    assert not node.core.paused
    properties = node.call("get_link_properties", link_name="robot::base")
    assert (properties.mass, properties.gravity_mode) == (5.0, True)
    assert node.call("get_joint_properties", joint_name="left_joint").success
    assert node.call("get_physics_properties").ode_config.sor_pgs_iters == 50
    effort = {"joint_name": "left_joint", "effort": 0.01}
    assert node.call("apply_joint_effort", **effort).success
    node.call("clear_joint_forces", joint_name="left_joint")
    wrench = message_type("geometry_msgs/Wrench")()
    wrench.force.x = 20.0
    assert node.call("apply_body_wrench", body_name="robot::base", wrench=wrench).success
    node.call("reset_world")
    assert node.call("get_model_state", model_name="robot").pose.position.y == pytest.approx(0.0, abs=0.01)


URDF = """<?xml version="1.0"?><!-- a box --><robot name="any"><link name="base">
  <inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
  <gazebo><plugin name="truth" filename="libgazebo_ros_p3d.so">
  <bodyName>base</bodyName><topicName>truth</topicName></plugin></gazebo></robot>"""


def test_models_are_spawned_with_pose_and_namespace(node):
    pose = message_type("geometry_msgs/Pose")()
    pose.position.x, pose.position.z, pose.orientation.z, pose.orientation.w = -3.0, 0.1, 1.0, 1.0
    request = {"model_name": "box", "model_xml": URDF, "robot_namespace": "/b1", "initial_pose": pose}
    assert node.call("spawn_urdf_model", **request).success
    assert "already exists" in node.call("spawn_urdf_model", **request).status_message
    found = node.topic("/b1/truth", "nav_msgs/Odometry")().pose.pose
    assert [round(found.position.x, 2), round(found.orientation.z, 3)] == [-3.0, round(math.sqrt(0.5), 3)]
    sdf = "<sdf version='1.6'><model name='m'><pose>1 0 0 0 0 0</pose><static>1</static><link name='l'/></model></sdf>"
    assert node.call("spawn_sdf_model", model_name="n", model_xml=sdf, reference_frame="box").success
    place = node.call("get_model_state", model_name="n").pose.position
    assert [round(place.x, 2), round(place.y, 2)] == [-3.0, 1.0]
    assert not node.call("spawn_sdf_model", model_name="o", model_xml="<a/>").success
    assert not node.call("spawn_sdf_model", model_name="o", model_xml=sdf, reference_frame="none").success
    unknown = URDF.replace("<box size", "<mesh filename='package://no_such_package/a.stl'/><box size")
    answer = node.call("spawn_urdf_model", model_name="o", model_xml=unknown)
    assert "no_such_package" in answer.status_message
    assert node.call("delete_model", model_name="box").success
    wait_for(lambda: not node.master.publishers["/b1/truth"], node.core.Step)


def test_a_spawn_fails_by_its_own_error_only_and_after_any_number_of_others(node):
    (world,) = (one for one in node.core.companions if isinstance(one, RosWorld))
    spawn = world._services.handler("spawn_sdf_model")
    request = service_type("gazebo_msgs/SpawnModel").request(model_name="box", model_xml=BOX)
    with node.core.hold():
        first, second = spawn(request), spawn(request)
        for _ in range(1000):
            node.core.problems.add(Problem("a plugin", "it fails", "", "error"))
        assert first.poll() is second.poll() is None
    assert first.poll().success
    assert "already exists" in second.poll().status_message


def test_without_ros_the_stand_ins_run_and_the_notice_says_so(caplog):
    with World(seed=1) as world:
        world.LoadFile(Path(__file__).parent / "turtle.world")
        world.Initialize()
        world.Step()
    assert "libgz runs them over its own topics" in caplog.text
    assert "gzserver --ros1" in caplog.text


def test_the_pages_are_those_of_the_declarations():
    docs = Path(__file__).parents[2] / "docs"
    text = (docs / "ros.md").read_text()
    assert page(text) == text  # else: python -m libgz.ros.reference
    assert (docs / "ros_plugins.md").read_text() == plugin_page()


CAMERAS = """<sdf version='1.6'><world name='default'>
<model name='wall'><static>1</static><pose>2 0 0 0 0 0</pose><link name='l'>
<visual name='v'><geometry><box><size>0.2 9 9</size></box></geometry></visual></link></model>
<model name='eye'><static>1</static><link name='l'>{}</link></model></world></sdf>"""
CAMERA = """<sensor name='{0}' type='{0}'><update_rate>20</update_rate><camera><horizontal_fov>1.0</horizontal_fov>
<image><width>32</width><height>24</height></image><clip><near>0.1</near><far>10</far></clip></camera>
<plugin name='p' filename='{1}'><cameraName>{0}</cameraName><frameName>optical</frameName>
<hackBaseline>0.1</hackBaseline></plugin></sensor>"""


def test_cameras_publish_images_depths_and_points(master, start):
    rows = (("camera", "libgazebo_ros_camera.so"), ("depth", "libgazebo_ros_openni_kinect.so"))
    node = Node(master, *start(CAMERAS.format("".join(CAMERA.format(*row) for row in rows))))
    image = node.topic("/camera/image_raw", "sensor_msgs/Image")()
    assert (image.encoding, image.width, image.height, image.step) == ("rgb8", 32, 24, 96)
    assert (len(image.data), image.header.frame_id) == (32 * 24 * 3, "optical")
    packed = node.topic("/camera/image_raw/compressed", "sensor_msgs/CompressedImage")()
    assert packed.format == "rgb8; jpeg compressed bgr8"
    assert Image.open(io.BytesIO(bytes(packed.data))).size == (32, 24)
    info = node.topic("/camera/camera_info", "sensor_msgs/CameraInfo")()
    focal = 32 / (2.0 * math.tan(0.5))
    assert info.K.tolist() == pytest.approx([focal, 0, 16.5, 0, focal, 12.5, 0, 0, 1])
    assert info.P[3] == pytest.approx(-focal * 0.1)
    depth = node.topic("/depth/depth/image_raw", "sensor_msgs/Image")()
    assert depth.encoding == "32FC1"
    assert struct.unpack_from("<f", bytes(depth.data), 4 * (12 * 32 + 16))[0] == pytest.approx(1.9, abs=0.01)
    cloud = node.topic("/depth/points", "sensor_msgs/PointCloud2")()
    assert [(field.name, field.offset) for field in cloud.fields] == [("x", 0), ("y", 4), ("z", 8), ("rgb", 16)]
    assert (cloud.point_step, cloud.row_step, cloud.is_dense) == (32, 32 * 32, True)
    x, y, z = struct.unpack_from("<3f", bytes(cloud.data), 0)
    assert (x < 0, y < 0, z) == (True, True, pytest.approx(1.9, abs=0.01))


ALL = """<sdf version='1.6'><world name='default'>
<model name='m'><static>0</static>
<link name='base'><inertial><mass>5</mass></inertial>
{sensors}</link>
<link name='arm'><pose>1 0 0 0 0 0</pose></link>
<joint name='left_front_joint' type='revolute'><parent>base</parent><child>arm</child>
<axis><xyz>0 0 1</xyz></axis></joint>
{plugins}</model></world></sdf>"""
RAYS = """<sensor name='{0}' type='ray'><update_rate>20</update_rate><ray><scan><horizontal><samples>8</samples>
<min_angle>-1</min_angle><max_angle>1</max_angle></horizontal><vertical><samples>2</samples><min_angle>-0.1</min_angle>
<max_angle>0.1</max_angle></vertical></scan><range><min>0.1</min><max>9</max></range></ray>
<plugin name='p' filename='libgazebo_ros_{0}.so'><topicName>/{0}</topicName></plugin></sensor>"""
PLUGIN = "<plugin name='{0}' filename='lib{0}.so'><topicName>/{0}</topicName><bodyName>base</bodyName>{1}</plugin>"
SKID = "".join(f"<{tag}>left_front_joint</{tag}>" for tag in (
    "leftFrontJoint", "leftRearJoint", "rightFrontJoint", "rightRearJoint"))  # fmt: skip
MORE = {
    "gazebo_ros_imu": ("", "/gazebo_ros_imu", "sensor_msgs/Imu"),
    "hector_gazebo_ros_imu": ("", "/hector_gazebo_ros_imu", "sensor_msgs/Imu"),
    "gazebo_ros_f3d": ("", "/gazebo_ros_f3d", "geometry_msgs/WrenchStamped"),
    "gazebo_ros_ft_sensor": (
        "<jointName>left_front_joint</jointName>",
        "/gazebo_ros_ft_sensor",
        "geometry_msgs/WrenchStamped",
    ),
    "gazebo_ros_vacuum_gripper": ("", "/gazebo_ros_vacuum_gripper", "std_msgs/Bool"),
    "gazebo_ros_skid_steer_drive": (SKID + "<odometryTopic>skid</odometryTopic>", "/skid", "nav_msgs/Odometry"),
    "gazebo_ros_planar_move": ("<odometryTopic>planar</odometryTopic>", "/planar", "nav_msgs/Odometry"),
}


STEREO = """<sensor name='pair' type='multicamera'><update_rate>20</update_rate>
<camera name='right'><image><width>16</width><height>12</height></image></camera>
<camera name='left'><image><width>16</width><height>12</height></image></camera>
<plugin name='p' filename='libgazebo_ros_multicamera.so'><cameraName>stereo</cameraName>
<hackBaseline>0.1</hackBaseline></plugin></sensor>"""


def test_a_stereo_pair_has_its_baseline(master, start):
    world = (
        f"<sdf version='1.6'><world name='default'><model name='m'><link name='l'>{STEREO}</link></model></world></sdf>"
    )
    node = Node(master, *start(world))
    assert node.topic("/stereo/left/image_raw", "sensor_msgs/Image")().width == 16
    left, right = (node.topic(f"/stereo/{side}/camera_info", "sensor_msgs/CameraInfo")() for side in ("left", "right"))
    assert (left.P[3], right.P[3]) == (0.0, pytest.approx(-0.1 * right.P[0]))


def test_the_other_plugins_publish(master, start):
    rays = {"block_laser": "sensor_msgs/PointCloud", "velodyne_laser": "sensor_msgs/PointCloud2"}
    rays["range"] = "sensor_msgs/Range"
    plugins = "".join(PLUGIN.format(name, more) for name, (more, *_) in MORE.items())
    plugins += PLUGIN.format("gazebo_ros_force", "") + PLUGIN.format("gazebo_ros_joint_pose_trajectory", "")
    node = Node(master, *start(ALL.format(sensors="".join(map(RAYS.format, rays)), plugins=plugins)))
    wanted = {f"/{name}": kind for name, kind in rays.items()} | {topic: kind for _, topic, kind in MORE.values()}
    found = {topic: node.topic(topic, kind)() for topic, kind in wanted.items()}
    assert (len(found["/block_laser"].points), len(found["/block_laser"].channels[0].values)) == (16, 16)
    assert found["/range"].field_of_view == pytest.approx(0.05)
    assert found["/velodyne_laser"].point_step == 22
    assert found["/skid"].pose.covariance[::7].tolist() == [1e-4, 1e-4, 1e12, 1e12, 1e12, 1e-2]
    assert found["/gazebo_ros_imu"].header.frame_id == "base"
    assert not found["/gazebo_ros_vacuum_gripper"].data
    subscribed = {"/gazebo_ros_force", "/gazebo_ros_joint_pose_trajectory", "/cmd_vel"}
    served = {"/on", "/off", "/default_imu", "/hector_gazebo_ros_imu/calibrate"}
    wait_for(lambda: subscribed <= set(master.subscribers) and served <= set(master.services))


def slider(name, direction, mass, parent):
    return (
        f"<link name='{name}_link'><inertial><mass>{mass}</mass></inertial></link>"
        f"<joint name='{name}' type='prismatic'><parent>{parent}</parent><child>{name}_link</child>"
        f"<axis><xyz>{direction}</xyz><limit><lower>0</lower><upper>10</upper></limit></axis></joint>"
    )


LIFTS = """<sdf version='1.6'><world name='default'>
<model name='house'>{lift}{doors}<plugin name='e' filename='libgazebo_ros_elevator.so'>
<robotNamespace>/block</robotNamespace><lift_joint>lift</lift_joint><door_joint>doors</door_joint>
<lift_pid><p>5000</p><d>2000</d></lift_pid></plugin></model>
<model name='load'><pose>5 0 5 0 0 0</pose><link name='link'><inertial><mass>2</mass></inertial></link>
<plugin name='h' filename='libgazebo_ros_harness.so'><joint name='rope' type='prismatic'><parent>world</parent>
<child>link</child><axis><xyz>0 0 1</xyz><limit><lower>-10</lower><upper>10</upper></limit></axis></joint>
<winch><joint>rope</joint><pos_pid><p>5000</p><d>500</d><cmd_max>1000</cmd_max><cmd_min>-1000</cmd_min></pos_pid>
<vel_pid><p>500</p><cmd_max>1000</cmd_max><cmd_min>-1000</cmd_min></vel_pid></winch>
<detach>rope</detach></plugin></model></world></sdf>"""


def test_an_elevator_and_a_harness_obey_their_topics(master, start, caplog):
    world = LIFTS.format(lift=slider("lift", "0 0 1", 100, "world"), doors=slider("doors", "0 1 0", 5, "lift_link"))
    core, _ = start(world)

    def send(topic, kind, *values):
        wait_for(lambda: topic in master.subscribers, core.Step)
        kind = message_type(kind)
        talker = Talker(master, topic, kind.name, kind.md5)
        for value in values:
            talker.send(codec(kind).pack(kind(data=value)))
        return talker

    load, lift = core.facade.ModelByName("load"), core.facade.ModelByName("house").GetJoint("lift")
    velocity = send("/load/harness/velocity", "std_msgs/Float32", -0.5)
    wait_for(lambda: load.WorldLinearVel().Z() < -0.4, core.Step)
    velocity.send(codec(message_type("std_msgs/Float32")).pack(message_type("std_msgs/Float32")(data=math.nan)))
    talkers = [velocity, send("/block/elevator", "std_msgs/String", "1")]
    wait_for(lambda: abs(lift.Position(0) - 3.0) < 0.02, core.Step)
    assert load.WorldLinearVel().Z() == pytest.approx(-0.54, abs=0.02)
    talkers.append(send("/load/harness/detach", "std_msgs/Bool", True))
    wait_for(lambda: load.WorldLinearVel().Z() < -5.0, core.Step)  # it falls
    talkers.append(send("/block/elevator", "std_msgs/String", "x"))
    wait_for(lambda: "the request 'x' is no number of a floor" in caplog.text, core.Step)
    for talker in talkers:
        talker.close()


def test_a_rate_beyond_all_bounds_ticks_at_each_call():
    for rate in (math.inf, 1e308):
        assert [Ticks(rate).due(now) for now in (0.0, 0.001, 5.0)] == [True] * 3
    assert bounded_rate(10**400, "a parameter") == bounded_rate(math.inf, "a parameter") == 1e9


RATED = """<sdf version='1.6'><world name='default'><model name='m'>
<link name='base'><inertial><mass>5</mass></inertial></link><link name='arm'><pose>1 0 0 0 0 0</pose></link>
<joint name='j' type='revolute'><parent>base</parent><child>arm</child><axis><xyz>0 0 1</xyz></axis></joint>
{}</model></world></sdf>"""
RATES = {"9" * 400: ("inf", "1e+09"), "inf": ("inf", "1e+09"), "nan": ("nan", "0"), "-5": ("-5", "0")}
RATES["1e308"] = ("1e+308", "1e+09")


@pytest.mark.parametrize("text", RATES)
def test_rates_that_cannot_be_kept_are_replaced_and_reported_with_their_lines(master, start, caplog, text):
    names = {"p3d": "updateRate", "imu": "updateRate", "diff_drive": "updateRate", "planar_move": "odometryRate"}
    rows = [
        f"<plugin name='{name}' filename='libgazebo_ros_{name}.so'>\n<{tag}>{text}</{tag}><bodyName>base</bodyName>"
        f"<leftJoint>j</leftJoint><rightJoint>j</rightJoint><topicName>/{name}</topicName></plugin>\n"
        for name, tag in names.items()
    ]
    node = Node(master, *start(RATED.format("".join(rows))))
    place = node.topic("/p3d", "nav_msgs/Odometry")
    assert seconds(place()) + 0.001 == pytest.approx(seconds(place()))  # each iteration
    given, taken = RATES[text]
    for number, tag in enumerate(names.values()):
        assert f"test.world:{5 + 2 * number}: <{tag}> is {given}; {taken} Hz is taken" in caplog.text
