"""Plugins as the ROS 2 branch of gazebo_ros_pkgs has them: names, types, defaults, values; where ROS 1 differs, too."""

import math
import struct

import numpy as np
import pytest
from plugin_worlds import plugin
from ros2_robots import INERTIA, wheeled
from ros_peers import wait_for

from libgz.classic.server import attach
from libgz.ros.types import message_type

GROUND = (
    "<model name='ground'><static>true</static><link name='l'><collision name='c'><geometry><plane/></geometry>"
    "</collision></link></model>"
)


def world(*models):
    return f"<sdf version='1.6'><world name='default'>{GROUND}{''.join(models)}</world></sdf>"


def several(**elements):
    """Elements of a plugin, of which there may be several of one tag."""
    return "".join(f"<{tag}>{one}</{tag}>" for tag, values in elements.items() for one in values)


FOUR = {"left_front": "0.2 0.2", "left_rear": "-0.2 0.3", "right_front": "0.2 -0.2", "right_rear": "-0.2 -0.3"}
PAIRS = several(
    num_wheel_pairs=[2],
    left_joint=["left_front", "left_rear"],
    right_joint=["right_front", "right_rear"],
    wheel_separation=[0.4, 0.6],
    wheel_diameter=[0.2, 0.25],
    publish_odom=["true"],
    covariance_x=[0.1],
    covariance_yaw=[0.3],
)


def test_a_diff_drive_has_a_separation_and_a_diameter_for_each_pair(start_ros2, graph):
    drive = f"<plugin name='drive' filename='libgazebo_ros_diff_drive.so'>{PAIRS}</plugin>"
    server = start_ros2(world(wheeled("robot", FOUR, drive)))
    odometry = server.topic("/odom")
    expected = [0.1, 1e-5, 1e12, 1e12, 1e12, 0.3]
    assert odometry.pose.covariance[::7].tolist() == odometry.twist.covariance[::7].tolist() == pytest.approx(expected)
    twist = message_type("geometry_msgs/Twist", 2)()
    twist.linear.x, twist.angular.z = 0.2, 0.5
    server.send("/cmd_vel", twist.kind.name, linear=twist.linear, angular=twist.angular)
    model = attach(server.core).world.ModelByName("robot")
    front = [(0.2 - 0.5 * 0.2) / 0.1, (0.2 + 0.5 * 0.2) / 0.1]
    rear = [(0.2 - 0.5 * 0.3) / 0.125, (0.2 + 0.5 * 0.3) / 0.125]
    names = ("left_front", "right_front", "left_rear", "right_rear")
    wait_for(lambda: model.GetJoint("left_front").GetParam("vel", 0), server.core.Step)
    assert [model.GetJoint(name).GetParam("vel", 0) for name in names] == pytest.approx([*front, *rear])
    assert "/tf" not in graph.received or not graph.received["/tf"]  # publish_odom_tf is false
    assert (graph.taken["/cmd_vel"]["qos"], graph.declared["/odom"]["qos"]) == ({"depth": 1}, {"depth": 1})


def test_a_planar_move_sets_velocities_at_its_rate_and_publishes_those_of_the_world(start_ros2):
    elements = {"update_rate": 100, "publish_rate": 50, "odometry_frame": "map"}
    box = f"<link name='l'><gravity>0</gravity>{INERTIA}</link>{plugin('gazebo_ros_planar_move', **elements)}"
    server = start_ros2(world(f"<model name='m'><pose>0 0 2 0 0 1.5707963</pose>{box}</model>"))
    twist = message_type("geometry_msgs/Twist", 2)()
    twist.linear.x, twist.angular.z = 0.5, 0.25
    server.send("/cmd_vel", twist.kind.name, linear=twist.linear, angular=twist.angular)
    model = attach(server.core).world.ModelByName("m")
    wait_for(lambda: model.WorldLinearVel().Length() > 0.1, server.core.Step)
    server.core.step(400)
    found = server.topic("/odom")
    assert (found.header.frame_id, found.child_frame_id) == ("map", "base_footprint")
    assert found.pose.pose.position.z == pytest.approx(2.0, abs=1e-6)
    assert (found.twist.twist.linear.x, found.twist.twist.angular.z) == pytest.approx((0.5, 0.25), abs=2e-3)
    assert found.twist.covariance[::7].tolist() == pytest.approx([1e-5, 1e-5, 1e12, 1e12, 1e12, 1e-3])
    begin = server.topic("/odom").header.stamp.seconds
    assert server.topic("/odom").header.stamp.seconds - begin == pytest.approx(0.02, abs=1e-6)
    transform = server.topic("/tf").transforms[0]
    assert (transform.header.frame_id, transform.child_frame_id) == ("map", "base_footprint")
    changes = set()
    for _ in range(20):
        server.core.Step()
        changes.add(round(model.WorldLinearVel().X(), 12))
    assert len(changes) == 3  # 100 Hz of 1000


TRICYCLE = {"fork": "0.4 0", "front": "0.4 0.05", "left": "0 0.2", "right": "0 -0.2"}


@pytest.mark.parametrize("published", [True, False])
def test_a_tricycle_publishes_odometry_if_it_is_asked_for(published, start_ros2, graph):
    joints = {
        "steering": "fork",
        "actuated_wheel": "front",
        "encoder_wheel_left": "left",
        "encoder_wheel_right": "right",
    }
    elements = {f"{part}_joint": name for part, name in joints.items()}
    elements |= {"wheel_separation": 0.4, "publish_wheel_joint_state": "true"}
    elements |= {"publish_odom": "true"} if published else {}
    server = start_ros2(world(wheeled("robot", TRICYCLE, plugin("gazebo_ros_tricycle_drive", **elements))))
    states = server.topic("/joint_states")
    assert states.name == ["fork", "front", "left", "right"]
    assert len(states.position) == len(states.velocity) == len(states.effort) == 4
    assert ("/odom" in graph.declared) == published
    (loaded,) = server.core.facade.server.plugins.of_model(attach(server.core).world.ModelByName("robot"))
    assert loaded.plugin.separation == 0.4


HUNG = """<model name='load'><pose>3 0 1 0 0 0</pose><link name='l'>{inertia}</link>
  <joint name='rail' type='prismatic'><parent>world</parent><child>l</child><axis><xyz>0 0 1</xyz></axis></joint>
  <plugin name='harness' filename='libgazebo_ros_harness.so'><ros><namespace>demo</namespace></ros>
  <joint name='joint1' type='prismatic'><parent>world</parent><child>l</child><axis><xyz>0 0 1</xyz>
  <limit><lower>-1</lower><upper>1</upper></limit></axis></joint><winch><joint>joint1</joint>
  <pos_pid><p>1000</p></pos_pid><vel_pid><p>1000</p></vel_pid></winch><detach>joint1</detach></plugin></model>"""
SENSED = """<model name='sensed'><static>true</static><pose>0 5 1 0 0 0</pose><link name='head'>
  <sensor name='where' type='gps'><update_rate>50</update_rate><gps><position_sensing><horizontal>
  <noise type='gaussian'><stddev>0.5</stddev></noise></horizontal></position_sensing></gps>{gps}</sensor>
  <sensor name='how' type='imu'><update_rate>50</update_rate><imu><angular_velocity><x><noise type='gaussian'>
  <stddev>0.1</stddev></noise></x></angular_velocity><linear_acceleration><z><noise type='gaussian'>
  <stddev>0.2</stddev></noise></z></linear_acceleration></imu>{imu}</sensor>
  <sensor name='around' type='ray'><update_rate>50</update_rate><ray><scan><horizontal><samples>8</samples>
  <min_angle>-1</min_angle><max_angle>1</max_angle></horizontal><vertical><samples>3</samples>
  <min_angle>-0.5</min_angle><max_angle>0.5</max_angle></vertical></scan><range><min>0.1</min><max>9</max></range></ray>
  {scan}{points}{range}</sensor></link></model>"""


def ray_driver(name, **elements):
    return plugin("gazebo_ros_ray_sensor", **elements).replace(
        "<plugin name='gazebo_ros_ray_sensor'", f"<plugin name='{name}'"
    )


DRIVERS = {
    "gps": plugin("gazebo_ros_gps_sensor"),
    "imu": plugin("gazebo_ros_imu_sensor"),
    "scan": ray_driver("scan", output_type="sensor_msgs/LaserScan"),
    "points": ray_driver("points", min_intensity=7),
    "range": ray_driver("range", output_type="sensor_msgs/Range", frame_name="beam"),
}


def test_sensors_have_the_variances_of_their_noises_and_rays_their_messages(start_ros2):
    server = start_ros2(world(SENSED.format(**DRIVERS)))
    fix = server.topic("/gazebo_ros_gps_sensor/out")
    assert fix.position_covariance[::4].tolist() == pytest.approx([0.25, 0.25, 0.0])
    assert (fix.position_covariance_type, fix.status.status, fix.status.service) == (2, 0, 1)
    assert fix.header.frame_id == "head"
    imu = server.topic("/gazebo_ros_imu_sensor/out")
    assert imu.angular_velocity_covariance[::4].tolist() == pytest.approx([0.01, 0.0, 0.0])
    assert imu.linear_acceleration_covariance[::4].tolist() == pytest.approx([0.0, 0.0, 0.04])
    assert not imu.orientation_covariance.any()
    scan = server.topic("/scan/out")
    assert len(scan.ranges) == 8  # the row in the middle, which sees nothing
    assert set(scan.ranges) == {math.inf}
    points = server.topic("/points/out")  # those of the lowest row are on the ground
    found = np.frombuffer(bytes(points.data), "<f4").reshape(-1, 4)
    assert len(found) == points.width > 0
    assert found[:, 2] == pytest.approx([-1.0] * len(found), abs=1e-3)
    assert set(found[:, 3]) == {7.0}
    nearest = server.topic("/range/out")
    assert nearest.range == pytest.approx(1.0 / math.sin(0.5), abs=1e-3)
    assert (nearest.header.frame_id, nearest.radiation_type, nearest.field_of_view) == ("beam", 1, pytest.approx(2.0))


def test_links_have_wrenches_harnesses_a_namespace_and_elevators_floors(start_ros2, graph, caplog):
    weighed = plugin("gazebo_ros_ft_sensor", body_name="l", frame_name="here")
    lift = "".join(
        f"<link name='{name}'>{INERTIA}</link><joint name='{name}_joint' type='prismatic'><parent>{parent}</parent>"
        f"<child>{name}</child><axis><xyz>{axis}</xyz></axis></joint>"
        for name, parent, axis in (("cabin", "world", "0 0 1"), ("door", "cabin", "0 1 0"))
    )
    lift += plugin(
        "gazebo_ros_elevator", lift_joint="cabin_joint", door_joint="door_joint", bottom_floor=0, top_floor=2
    )
    names = several(joint_name=["cabin_joint", "none"])
    states = f"<plugin name='js' filename='libgazebo_ros_joint_state_publisher.so'>{names}</plugin>"
    server = start_ros2(
        world(
            HUNG.format(inertia=INERTIA),
            f"<model name='stone'><pose>0 2 9 0 0 0</pose><link name='l'>{INERTIA}</link>{weighed}</model>",
            f"<model name='lift'><pose>6 0 0 0 0 0</pose>{lift}{states}</model>",
        )
    )
    wrench = server.topic("/wrench")
    assert wrench.header.frame_id == "here"
    assert wrench.wrench.force.z == pytest.approx(-9.8, abs=1e-3)  # it falls
    wait_for(lambda: "/demo/load/harness/velocity" in graph.taken)
    assert graph.taken["/demo/load/harness/detach"]["type"] == "std_msgs/msg/Empty"
    of_model = server.core.facade.server.plugins.of_model
    server.send("/demo/load/harness/detach", "std_msgs/Empty")
    load = attach(server.core).world.ModelByName("load")
    wait_for(lambda: load.GetJoint("joint1") is None, server.core.Step)
    elevator = of_model(attach(server.core).world.ModelByName("lift"))[0].plugin
    server.send("/elevator", "std_msgs/String", data="3")
    wait_for(lambda: "there is no floor 3" in caplog.text, server.core.Step)
    assert not elevator.steps
    for _ in range(50):
        elevator.MoveToFloor(3)
    assert caplog.text.count("there is no floor 3") == 1
    server.send("/elevator", "std_msgs/String", data="2")
    wait_for(lambda: elevator.steps, server.core.Step)
    assert server.topic("/joint_states").name == ["cabin_joint"]
    assert "has no joint 'none'" in caplog.text


SEEN = """<model name='wall'><static>true</static><pose>0 0 0 0 0 0</pose><link name='l'><visual name='v'>
  <pose>2 0.6 1 0 0 0</pose><geometry><box><size>.2 1 4</size></box></geometry></visual></link></model>
  <model name='m'><static>true</static><pose>0 0 1 0 0 0</pose><link name='head'>
  <sensor name='eye' type='depth'><update_rate>10</update_rate><camera><horizontal_fov>1</horizontal_fov><image>
  <width>32</width><height>24</height></image><clip><near>0.1</near><far>50</far></clip></camera>{}</sensor>
  </link></model>"""


@pytest.mark.parametrize(("nearest", "wall"), [(0.4, "seen"), (3.0, "near")])
def test_depths_that_are_not_seen_are_infinite(nearest, wall, start_ros2):
    given = {"min_depth": nearest, "P_fx": 99.0, "Ty": -2.5, "rectification_matrix": "0 1 0 1 0 0 0 0 1"}
    server = start_ros2(world(SEEN.format(plugin("gazebo_ros_camera", **given))))
    deep = server.topic("/eye/depth/image_raw")
    depths = np.frombuffer(bytes(deep.data), "<f4").reshape(24, 32)
    assert depths[2, 30] == math.inf  # the sky
    assert depths[2, 2] == (pytest.approx(1.9, abs=0.01) if wall == "seen" else -math.inf)
    cloud = np.frombuffer(bytes(server.topic("/eye/points").data), "<f4").reshape(24, 32, 8)
    assert cloud[2, 30, :3].tolist() == [math.inf] * 3
    assert cloud[2, 2, 2] == depths[2, 2]
    info = server.topic("/eye/camera_info")
    assert (info.P[0], info.P[5], info.P[7]) == (99.0, pytest.approx(info.K[4]), -2.5)
    assert info.R.tolist() == [0, 1, 0, 1, 0, 0, 0, 0, 1]
    assert struct.unpack_from("<f", bytes(deep.data))[0] == depths[0, 0]


def test_wheels_that_spin_in_the_air_slip_wholly(start_ros2):
    slip = "".join(
        f"<wheel link_name='{name}_wheel'><wheel_normal_force>10</wheel_normal_force></wheel>" for name in ("b", "a")
    )
    slip = f"<plugin name='slip' filename='libgazebo_ros_wheel_slip.so'>{slip}</plugin>"
    model = wheeled("robot", {"a": "0 0.2", "b": "0 -0.2"}, f"<pose>0 0 50 0 0 0</pose>{slip}")
    server = start_ros2(world(model))
    found = attach(server.core).world.ModelByName("robot")
    assert server.topic("/wheel_slip").longitudinal_slip.tolist() == [0.0, 0.0]
    found.GetJoint("a").SetVelocity(0, 5.0)
    slips = server.topic("/wheel_slip")
    assert slips.name == ["a_wheel", "b_wheel"]
    assert slips.longitudinal_slip[0] == pytest.approx(1.0, abs=0.02)


def test_wheels_without_a_tolerance_may_stand(start_ros2):
    slip = "<wheel link_name='a_wheel'><wheel_normal_force>10</wheel_normal_force></wheel>"
    slip = plugin("gazebo_ros_wheel_slip", wheel_spin_tolerance=0).replace("</plugin>", f"{slip}</plugin>")
    server = start_ros2(world(wheeled("robot", {"a": "0 0.2"}, f"<pose>0 0 50 0 0 0</pose>{slip}")))
    assert server.topic("/wheel_slip").longitudinal_slip.tolist() == [0.0]


def test_a_trajectory_holds_the_link_that_is_its_frame(start_ros2):
    arm = (
        f"<link name='base'>{INERTIA}</link><link name='arm'><pose>1 0 0 0 0 0</pose>{INERTIA}</link>"
        "<joint name='j' type='revolute'><parent>base</parent><child>arm</child><axis><xyz>0 0 1</xyz></axis></joint>"
    )
    play = plugin("gazebo_ros_joint_pose_trajectory", update_rate=20)
    server = start_ros2(world(f"<model name='m'><pose>0 0 60 0 0 0</pose>{arm}{play}</model>"))
    kind = message_type("trajectory_msgs/JointTrajectory", 2)
    point = message_type("trajectory_msgs/JointTrajectoryPoint", 2)
    given = {"joint_names": ["j"], "points": [point(positions=[at]) for at in (0.5, 1.0, 1.5)]}
    header = message_type("std_msgs/Header", 2)(frame_id="m::arm")
    server.send("/set_joint_trajectory", kind.name, header=header, **given)
    model = attach(server.core).world.ModelByName("m")
    wait_for(lambda: model.GetJoint("j").Position(0) > 0.4, server.core.Step)
    assert [*model.GetLink("arm").WorldPose().Pos()][:2] == pytest.approx([1.0, 0.0], abs=1e-6)
    assert model.GetLink("base").WorldPose().Rot().Yaw() == pytest.approx(-0.5, abs=1e-3)
    server.core.step(40)
    assert model.GetJoint("j").Position(0) < 0.6  # 20 points a second
    server.core.step(80)
    assert model.GetJoint("j").Position(0) == pytest.approx(1.5, abs=1e-2)


def test_services_of_world_plugins_have_their_namespace_and_remappings(start_ros2, graph, caplog):
    space = "<namespace>/demo</namespace>"
    ros = {
        "properties": f"<ros>{space}<remapping>get_model_properties:=about</remapping></ros>",
        "state": f"<ros>{space}</ros>",
    }
    plugins = "".join(f"<plugin name='{k}' filename='libgazebo_ros_{k}.so'>{v}</plugin>" for k, v in ros.items())
    nothing = f"<model name='m'><link name='l'/>{plugin('gazebo_ros_template')}</model>"
    server = start_ros2(world(plugins, nothing))
    found = server.call("/demo/about", "gazebo_msgs/GetModelProperties", model_name="ground")
    assert (found.success, found.body_names) == (True, ["l"])
    assert graph.declared["/demo/about"]["node"] == ["/demo", "properties"]
    assert server.call("/get_model_properties", "gazebo_msgs/GetModelProperties", model_name="ground").success
    assert server.call("/demo/get_entity_state", "gazebo_msgs/GetEntityState", name="ground").success
    assert not [record for record in caplog.records if record.levelname in ("WARNING", "ERROR")]


def test_of_several_models_in_a_text_the_first_is_spawned(start_ros2, caplog):
    text = "<sdf version='1.6'><light name='lamp' type='point'/>{}</sdf>"
    models = "<model name='a'><link name='first'/></model><model name='b'><link name='second'/></model>"
    server = start_ros2()
    call = "/spawn_entity", "gazebo_msgs/SpawnEntity"
    assert server.call(*call, name="one", xml=text.format(models)).success
    assert attach(server.core).world.ModelByName("one").GetLink("first") is not None
    assert "the first of 3 in the text: a" in caplog.text
    answer = server.call(*call, name="none", xml="<sdf version='1.6'/>")
    assert (answer.success, answer.status_message) == (False, "spawn_entity: the text has no model or light")
