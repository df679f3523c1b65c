"""Robots with controllers of ros2_control: worlds, robot descriptions and parameters."""

ARM = """<sdf version='1.6'><world name='default'><gravity>0 0 0</gravity><model name='arm'>
  <link name='base'/><link name='tip'><inertial><mass>1</mass></inertial></link>
  <joint name='fix' type='fixed'><parent>world</parent><child>base</child></joint>
  <joint name='elbow' type='revolute'><parent>base</parent><child>tip</child><axis><xyz>0 0 1</xyz>
    <limit><lower>-3</lower><upper>3</upper></limit></axis></joint>
  <plugin name='control' filename='libgazebo_ros2_control.so'><parameters>{file}</parameters></plugin>
  </model></world></sdf>"""
ROBOT = """<robot name='arm'><joint name='elbow' type='revolute'><limit lower='-3' upper='3' effort='50' velocity='10'/>
  </joint><ros2_control name='sim' type='system'><joint name='elbow'><command_interface name='position'/>
  <command_interface name='velocity'/><state_interface name='position'/></joint></ros2_control></robot>"""
CONTROL = """
controller_manager:
  ros__parameters:
    update_rate: 200
    states: {type: joint_state_broadcaster/JointStateBroadcaster}
    mover: {type: forward_command_controller/ForwardCommandController}
    follower: {type: joint_trajectory_controller/JointTrajectoryController}
mover: {ros__parameters: {joints: [elbow], interface_name: velocity}}
follower: {ros__parameters: {joints: [elbow], command_interfaces: [position], state_interfaces: [position]}}
"""

ROUND = "<cylinder><radius>0.1</radius><length>0.05</length></cylinder>"
WHEEL = f"<collision name='c'><geometry>{ROUND}</geometry></collision>"

INERTIA = "<inertial><mass>1</mass><inertia><ixx>.01</ixx><iyy>.01</iyy><izz>.01</izz></inertia></inertial>"


def wheeled(name, places, inside):
    """A base with wheels at places, x and y, by their names."""
    wheels = "".join(
        f"<link name='{one}_wheel'><pose>{place} 0.1 -1.5708 0 0</pose>{INERTIA}{WHEEL}</link>"
        f"<joint name='{one}' type='revolute'><parent>base</parent><child>{one}_wheel</child>"
        "<axis><xyz>0 0 1</xyz></axis></joint>"
        for one, place in places.items()
    )
    base = "<link name='base'><pose>0 0 0.1 0 0 0</pose><inertial><mass>5</mass></inertial></link>"
    return f"<model name='{name}'>{base}{wheels}{inside}</model>"


def wagon(file):
    parts = "".join(
        f"<link name='{side}'><pose>0 {y} 0.1 -1.5708 0 0</pose><inertial><mass>0.5</mass><inertia><ixx>0.01</ixx>"
        f"<iyy>0.01</iyy><izz>0.01</izz></inertia></inertial>{WHEEL}</link><joint name='{side}' type='revolute'>"
        f"<parent>base</parent><child>{side}</child><axis><xyz>0 0 1</xyz></axis></joint>"
        for side, y in (("left", 0.2), ("right", -0.2))
    )
    return f"""<sdf version='1.6'><world name='default'><model name='ground'><static>true</static><link name='l'>
      <collision name='c'><geometry><plane/></geometry></collision></link></model><model name='wagon'>
      <link name='base'><pose>0 0 0.1 0 0 0</pose><inertial><mass>5</mass></inertial></link>{parts}
      <plugin name='control' filename='libgazebo_ros2_control.so'><parameters>{file}</parameters></plugin>
      </model></world></sdf>"""


WAGON = """<robot name='wagon'><joint name='left' type='continuous'/><joint name='right' type='continuous'/>
  <ros2_control name='sim' type='system'>
  <joint name='left'><command_interface name='velocity'/></joint>
  <joint name='right'><command_interface name='velocity'/></joint></ros2_control></robot>"""
DRIVE = """
controller_manager:
  ros__parameters:
    drive: {type: diff_drive_controller/DiffDriveController}
    states: {type: joint_state_broadcaster/JointStateBroadcaster}
states: {ros__parameters: {joints: [right], use_local_topics: true}}
drive:
  ros__parameters:
    left_wheel_names: [left]
    right_wheel_names: [right]
    wheel_separation: 0.4
    wheel_radius: 0.1
    pose_covariance_diagonal: [0.1, 0.2, 0, 0, 0, 0.3]
    publish_limited_velocity: true
    linear.x.has_acceleration_limits: true
    linear.x.max_acceleration: 1.0
    linear: {x: {has_velocity_limits: true, max_velocity: 0.5}}
"""
