"""The GPS of hector_gazebo_plugins, which Husky and Jackal have: values by the formulas of WGS 84."""

import math

import pytest
from ros_node import Node

from libgz.ros.types import message_type

WORLD = """<sdf version='1.6'><world name='default'><gravity>0 0 0</gravity>
<spherical_coordinates><latitude_deg>10</latitude_deg><longitude_deg>20</longitude_deg><elevation>5</elevation>
<heading_deg>0</heading_deg></spherical_coordinates>
<model name='car'><pose>100 200 3 0 0 0</pose><link name='base'/>
<plugin name='gps' filename='libhector_gazebo_ros_gps.so'><bodyName>base</bodyName>{}</plugin></model></world></sdf>"""


def read(master, start, words):
    node = Node(master, *start(WORLD.format(words)))
    fixes = node.topic("/fix", "sensor_msgs/NavSatFix")
    velocities = node.topic("/fix_velocity", "geometry_msgs/Vector3Stamped")
    return fixes, velocities, node


def degrees(distance, latitude):
    """How many degrees of latitude and of longitude a distance is [m]."""
    square = (2 - 1 / 298.257223563) / 298.257223563
    root = math.sqrt(1 - square * math.sin(math.radians(latitude)) ** 2)
    along = 6378137.0 * (1 - square) / root**3
    return math.degrees(distance / along), math.degrees(
        distance / (6378137.0 / root * math.cos(math.radians(latitude)))
    )


def test_x_is_north_and_y_is_west(master, start):
    words = "<referenceLatitude>45</referenceLatitude><referenceAltitude>7</referenceAltitude><frameId>gps</frameId>"
    words += "<drift>0 0 4</drift><gaussianNoise>3 0 0</gaussianNoise><offset>0 0 0.5</offset>"
    fixes, _, _ = read(master, start, words)
    first, second = fixes(), fixes()
    assert first.header.frame_id == "gps"
    assert second.header.stamp.seconds - first.header.stamp.seconds == pytest.approx(0.25)
    assert first.position_covariance.tolist() == [9, 0, 0, 0, 0, 0, 0, 0, 16]
    assert first.position_covariance_type == 2
    assert first.longitude == pytest.approx(8.9 - degrees(200.0, 45.0)[1], abs=1e-9)
    assert first.latitude == pytest.approx(45.0 + degrees(100.0, 45.0)[0], abs=degrees(20.0, 45.0)[0])
    assert first.altitude == pytest.approx(7.0 + 3.0 + 0.5, abs=25.0)
    assert first.latitude != second.latitude


def test_the_reference_may_be_the_world_s(master, start):
    fixes, velocities, node = read(master, start, "<useWorldSphericalCoordinates>true</useWorldSphericalCoordinates>")
    node.call("set_model_state", model_state=moving())
    for _ in range(2):
        fix, velocity = fixes(), velocities()
    assert fix.altitude == pytest.approx(8.0, abs=1e-3)
    assert fix.longitude == pytest.approx(20.0 + degrees(100.0, 10.0)[1], abs=1e-4)  # x is east
    assert fix.latitude == pytest.approx(10.0 + degrees(200.0, 10.0)[0], abs=1e-4)
    assert (velocity.vector.x, velocity.vector.y) == pytest.approx((2.0, -1.0), abs=1e-6)


def moving():
    state = message_type("gazebo_msgs/ModelState")(model_name="car")
    state.pose.position.x, state.pose.position.y, state.pose.position.z = 100.0, 200.0, 3.0
    state.pose.orientation.w = 1.0
    state.twist.linear.x, state.twist.linear.y = 1.0, 2.0
    return state
