"""Worlds whose messages of ROS 1 the real gazebo_ros_pkgs and libgz both publish, for field by field comparisons."""

from typing import Any, NamedTuple

from libgz.ros.types import message_type

IMAGE, INFO, CLOUD = "sensor_msgs/Image", "sensor_msgs/CameraInfo", "sensor_msgs/PointCloud2"
ODOMETRY, SCAN, IMU, RANGE = "nav_msgs/Odometry", "sensor_msgs/LaserScan", "sensor_msgs/Imu", "sensor_msgs/Range"
JOINTS, TF, WRENCH = "sensor_msgs/JointState", "tf2_msgs/TFMessage", "geometry_msgs/WrenchStamped"
WALL = """<model name="wall"><static>true</static><pose>2 0.3 0.5 0 0 0.3</pose><link name="link">
  <collision name="c"><laser_retro>120</laser_retro><geometry><box><size>0.1 6 1</size></box></geometry></collision>
  <visual name="v"><laser_retro>120</laser_retro><geometry><box><size>0.1 6 1</size></box></geometry></visual>
</link></model>"""


class Scene(NamedTuple):
    """A world, its commands at the begin, and what it publishes.

    Attributes:
        body: the content of <world> beside a plane.
        topics: names of topics -> their types.
        commands: (topic, type, values by the paths of fields): sent before the first step.
        calls: names of services of std_srvs/Empty: called before it.
        seconds: sim time.
        tolerances: parts of `topic:field` -> how far apart numbers may be, and which share of an array may be farther.
    """

    body: str
    topics: dict[str, str]
    commands: tuple[tuple[str, str, dict[str, Any]], ...] = ()
    calls: tuple[str, ...] = ()
    seconds: float = 2.0
    tolerances: dict[str, tuple[float, float]] = {}

    @property
    def text(self) -> str:
        """The world."""
        return f"""<?xml version="1.0"?>
<sdf version="1.6"><world name="default">
<light name="sun" type="directional"><direction>-0.5 0.2 -1</direction></light>
<model name="ground"><static>true</static><link name="link">
  <collision name="c"><geometry><plane><normal>0 0 1</normal><size>50 50</size></plane></geometry></collision>
</link></model>
{self.body}
</world></sdf>
"""


def inertial(mass: float, size: float) -> str:
    """That of a cube."""
    value = mass * size * size / 6.0
    return f"""<inertial><mass>{mass}</mass>
      <inertia><ixx>{value}</ixx><iyy>{value}</iyy><izz>{value}</izz></inertia></inertial>"""


def wheel(name: str, x: float, y: float) -> str:
    """A wheel of radius 0.05 m on a joint whose axis points to the left."""
    return f"""<link name="{name}"><pose>{x} {y} 0.05 -1.5708 0 0</pose>
  <inertial><mass>0.3</mass><inertia><ixx>0.0002</ixx><iyy>0.0002</iyy><izz>0.0004</izz></inertia></inertial>
  <collision name="c"><geometry><cylinder><radius>0.05</radius><length>0.02</length></cylinder></geometry></collision>
</link>
<joint name="{name}_joint" type="revolute"><parent>base</parent><child>{name}</child>
  <axis><xyz>0 0 1</xyz></axis></joint>"""


def chassis(inside: str = "", caster: bool = True) -> str:
    """A box above the ground."""
    ball = """<collision name="caster"><pose>-0.12 0 -0.05 0 0 0</pose><geometry><sphere><radius>0.05</radius></sphere>
      </geometry><surface><friction><ode><mu>0</mu><mu2>0</mu2></ode></friction></surface></collision>"""
    return f"""<link name="base"><pose>0 0 0.1 0 0 0</pose>
  <inertial><mass>5</mass><inertia><ixx>0.05</ixx><iyy>0.05</iyy><izz>0.08</izz></inertia></inertial>
  <collision name="c"><geometry><box><size>0.3 0.2 0.05</size></box></geometry></collision>
  {ball if caster else ""}{inside}</link>"""


def two_wheels(name: str, y: float, plugin: str) -> str:
    """A robot with two wheels."""
    return f"""<model name="{name}"><pose>0 {y} 0 0 0 0.2</pose>{chassis()}{wheel("left", 0.06, 0.12)}
{wheel("right", 0.06, -0.12)}<plugin name="drive" filename="libgazebo_ros_diff_drive.so">
  <leftJoint>left_joint</leftJoint><rightJoint>right_joint</rightJoint><wheelSeparation>0.24</wheelSeparation>
  <wheelDiameter>0.1</wheelDiameter>{plugin}</plugin></model>"""


def tricycle(name: str, y: float, plugin: str) -> str:
    """A robot whose front wheel is steered and driven."""
    front = wheel("front_wheel", 0.12, 0.0).replace("<parent>base</parent>", "<parent>fork</parent>")
    return f"""<model name="{name}"><pose>0 {y} 0 0 0 0.2</pose>{chassis(caster=False)}
<link name="fork"><pose>0.12 0 0.09 0 0 0</pose>{inertial(0.2, 0.1)}</link>
<joint name="front_steering_joint" type="revolute"><parent>base</parent><child>fork</child>
  <axis><xyz>0 0 1</xyz></axis></joint>{front}{wheel("left_wheel", -0.1, 0.14)}{wheel("right_wheel", -0.1, -0.14)}
<plugin name="drive" filename="libgazebo_ros_tricycle_drive.so"><actuatedWheelDiameter>0.1</actuatedWheelDiameter>
  <encoderWheelDiameter>0.1</encoderWheelDiameter><encoderWheelSeparation>0.28</encoderWheelSeparation>
  <wheelTorque>20</wheelTorque>{plugin}</plugin></model>"""


def truth(link: str, topic: str) -> str:
    """The poses of a link."""
    return f"""<plugin name="{topic}" filename="libgazebo_ros_p3d.so"><bodyName>{link}</bodyName>
  <topicName>{topic}</topicName></plugin>"""


def twist(x: float, yaw: float, y: float = 0.0) -> dict[str, float]:
    """The values of a Twist."""
    return {"linear.x": x, "linear.y": y, "angular.z": yaw}


def pendulum(inside: str = "", plugins: str = "", name: str = "pendulum", y: float = 0.0) -> str:
    """A bob that swings from the horizontal, without friction, on a base of the world."""
    return f"""<model name="{name}"><pose>0 {y} 0 0 0 0.3</pose>
<link name="base"><pose>0 0 2 0 0 0</pose>{inertial(5, 0.2)}</link>
<joint name="fixed" type="fixed"><parent>world</parent><child>base</child></joint>
<link name="bob"><pose>0.5 0 2 0.1 0 0</pose>{inertial(1, 0.2)}{inside}</link>
<joint name="hinge" type="revolute"><parent>base</parent><child>bob</child><pose>-0.5 0 0 0 0 0</pose>
  <axis><xyz>0 1 0</xyz></axis></joint>{plugins}</model>"""


def sensor(name: str, kind: str, rate: float, inside: str, plugin: str, elements: str) -> str:
    """A sensor with a plugin."""
    return f"""<sensor name="{name}" type="{kind}"><always_on>1</always_on><update_rate>{rate}</update_rate>{inside}
  <plugin name="{name}_plugin" filename="libgazebo_ros_{plugin}.so">{elements}</plugin></sensor>"""


def stand(inside: str) -> str:
    """A static model with sensors, 0.5 m above the ground."""
    return f"""<model name="stand"><static>true</static><pose>0 0 0.5 0 0 0.1</pose>
<link name="link">{inside}</link></model>"""


def rays(samples: int, angle: float, far: float, rows: int = 1) -> str:
    """A fan of rays."""
    more = f"<vertical><samples>{rows}</samples><min_angle>-0.1</min_angle><max_angle>0.1</max_angle></vertical>"
    return f"""<ray><scan><horizontal><samples>{samples}</samples>
  <min_angle>-{angle}</min_angle><max_angle>{angle}</max_angle></horizontal>{more if rows > 1 else ""}</scan>
  <range><min>0.1</min><max>{far}</max><resolution>0.01</resolution></range></ray>"""


def camera(width: int, height: int, angle: float = 1.2) -> str:
    """A camera's element."""
    return f"""<camera><horizontal_fov>{angle}</horizontal_fov>
  <image><width>{width}</width><height>{height}</height><format>R8G8B8</format></image>
  <clip><near>0.05</near><far>20</far></clip></camera>"""


# With the 50 iterations of the default, friction in turns depends on how a solver comes near its solution.
SOLVED = """<physics type="ode"><ode><solver><type>world</type></solver></ode></physics>"""

LENS = """<distortionK1>0</distortionK1><distortionK2>0</distortionK2><distortionK3>0</distortionK3>
  <distortionT1>0</distortionT1><distortionT2>0</distortionT2>"""

SCENES: dict[str, Scene] = {
    "diff_drive": Scene(
        two_wheels(
            "encoders",
            0.0,
            """<robotNamespace>/encoders</robotNamespace><odometrySource>encoder</odometrySource>
  <updateRate>50</updateRate><robotBaseFrame>base</robotBaseFrame><publishWheelTF>true</publishWheelTF>
  <publishWheelJointState>true</publishWheelJointState><wheelTorque>20</wheelTorque>""",
        )
        + two_wheels("plain", 2.0, ""),
        {
            "/encoders/odom": ODOMETRY,
            "/encoders/joint_states": JOINTS,
            "/plain/odom": ODOMETRY,
            "/tf": TF,
        },
        (
            ("/encoders/cmd_vel", "geometry_msgs/Twist", twist(0.3, 0.4)),
            ("/plain/cmd_vel", "geometry_msgs/Twist", twist(0.3, -0.4)),
        ),
        tolerances={
            "/plain/odom:twist": (0.035, 0.0),
            "/encoders/odom:twist": (0.006, 0.0),
            "/plain": (0.03, 0.0),
            "/encoders": (0.003, 0.0),
            "/tf": (0.03, 0.0),
        },
    ),
    "skid_steer": Scene(
        f"""<model name="skid"><pose>0 0 0 0 0 0.2</pose>{chassis(caster=False)}
{wheel("fl", 0.1, 0.14)}{wheel("fr", 0.1, -0.14)}{wheel("rl", -0.1, 0.14)}{wheel("rr", -0.1, -0.14)}
<plugin name="drive" filename="libgazebo_ros_skid_steer_drive.so"><robotNamespace>/skid</robotNamespace>
  <leftFrontJoint>fl_joint</leftFrontJoint><rightFrontJoint>fr_joint</rightFrontJoint>
  <leftRearJoint>rl_joint</leftRearJoint><rightRearJoint>rr_joint</rightRearJoint>
  <wheelSeparation>0.28</wheelSeparation><wheelDiameter>0.1</wheelDiameter><updateRate>50</updateRate>
  <robotBaseFrame>base</robotBaseFrame><torque>20</torque><broadcastTF>true</broadcastTF></plugin></model>""",
        {"/skid/odom": ODOMETRY, "/tf": TF},
        (("/skid/cmd_vel", "geometry_msgs/Twist", twist(0.3, 0.0)),),
        tolerances={
            "twist.twist.linear.y": (0.005, 0.0),
            "": (0.003, 0.0),
        },
    ),
    "planar_move": Scene(
        f"""<model name="sled"><pose>0 0 0 0 0 0.2</pose><link name="base"><pose>0 0 0.1 0 0 0</pose>{inertial(2, 0.2)}
  <collision name="c"><geometry><box><size>0.2 0.2 0.2</size></box></geometry>
  <surface><friction><ode><mu>0</mu><mu2>0</mu2></ode></friction></surface></collision></link>
<plugin name="drive" filename="libgazebo_ros_planar_move.so"><robotNamespace>/sled</robotNamespace>
  <robotBaseFrame>base</robotBaseFrame><odometryRate>1001</odometryRate></plugin></model>""",
        {"/sled/odom": ODOMETRY, "/tf": TF},
        (("/sled/cmd_vel", "geometry_msgs/Twist", twist(0.3, 0.4, 0.1)),),
        seconds=1.0,
        tolerances={
            "": (0.0005, 0.0),
        },
    ),
    "camera": Scene(
        WALL
        + stand(
            sensor(
                "eye",
                "camera",
                20,
                camera(64, 48),
                "camera",
                f"""<cameraName>eye</cameraName><frameName>eye_frame</frameName><hackBaseline>0.07</hackBaseline>
  <robotNamespace>/bot</robotNamespace>{LENS}""",
            )
            + sensor(
                "plain",
                "camera",
                10,
                camera(40, 30, 1.0),
                "camera",
                f"""<cameraName>plain</cameraName><imageTopicName>image</imageTopicName>
  <cameraInfoTopicName>info</cameraInfoTopicName><Cx>21</Cx><Cy>14</Cy><focalLength>36.6097</focalLength>{LENS}""",
            )
        ),
        {"/bot/eye/image_raw": IMAGE, "/bot/eye/camera_info": INFO, "/plain/image": IMAGE, "/plain/info": INFO},
        tolerances={
            ":data": (2.0, 0.2),
        },
    ),
    "depth": Scene(
        WALL
        + stand(
            sensor(
                "kinect",
                "depth",
                10,
                camera(32, 24),
                "openni_kinect",
                f"""<cameraName>kinect</cameraName><imageTopicName>rgb/image_raw</imageTopicName>
  <cameraInfoTopicName>rgb/camera_info</cameraInfoTopicName><depthImageTopicName>depth/image_raw</depthImageTopicName>
  <depthImageCameraInfoTopicName>depth/camera_info</depthImageCameraInfoTopicName>
  <pointCloudTopicName>depth/points</pointCloudTopicName><frameName>kinect_frame</frameName>
  <pointCloudCutoff>0.3</pointCloudCutoff><pointCloudCutoffMax>2.2</pointCloudCutoffMax>{LENS}""",
            )
        ),
        {
            "/kinect/rgb/image_raw": IMAGE,
            "/kinect/rgb/camera_info": INFO,
            "/kinect/depth/image_raw": IMAGE,
            "/kinect/depth/camera_info": INFO,
            "/kinect/depth/points": CLOUD,
        },
        tolerances={
            "rgb/image_raw:data": (2.0, 0.2),
        },
    ),
    "depth_camera": Scene(
        WALL
        + stand(
            sensor(
                "deep",
                "depth",
                10,
                camera(32, 24),
                "depth_camera",
                f"""<cameraName>deep</cameraName><imageTopicName>rgb/image_raw</imageTopicName>
  <cameraInfoTopicName>rgb/camera_info</cameraInfoTopicName><depthImageTopicName>depth/image_raw</depthImageTopicName>
  <depthImageCameraInfoTopicName>depth/camera_info</depthImageCameraInfoTopicName>
  <pointCloudTopicName>depth/points</pointCloudTopicName><frameName>deep_frame</frameName>
  <pointCloudCutoff>0.3</pointCloudCutoff><pointCloudCutoffMax>3</pointCloudCutoffMax>{LENS}""",
            )
        ),
        {
            "/deep/rgb/image_raw": IMAGE,
            "/deep/depth/image_raw": IMAGE,
            "/deep/depth/points": CLOUD,
        },
        tolerances={
            "rgb/image_raw:data": (2.0, 0.2),
        },
    ),
    "lasers": Scene(
        WALL
        + stand(
            sensor(
                "front",
                "ray",
                10,
                rays(61, 1.2, 4.0),
                "laser",
                "<topicName>scan</topicName><frameName>laser_frame</frameName>",
            )
        ),
        {"/scan": SCAN},
    ),
    "gpu_laser": Scene(
        WALL
        + stand(
            sensor(
                "gpu",
                "gpu_ray",
                20,
                rays(31, 0.8, 10.0),
                "gpu_laser",
                "<robotNamespace>/bot</robotNamespace><topicName>gpu</topicName><frameName>gpu_frame</frameName>",
            )
        ),
        {"/bot/gpu": SCAN},
        tolerances={
            ":ranges": (0.003, 0.1),
        },
    ),
    "block_laser": Scene(
        WALL
        + stand(
            sensor(
                "blocks",
                "ray",
                10,
                rays(21, 0.6, 10.0, 3),
                "block_laser",
                "<topicName>cloud</topicName><frameName>block_frame</frameName><updateRate>10</updateRate>",
            )
        ),
        {"/cloud": "sensor_msgs/PointCloud"},
        tolerances={
            ":points": (0.3, 0.0),
        },
    ),
    "unnamed": Scene(
        WALL
        + stand(
            sensor("front", "ray", 10, rays(7, 1.2, 4.0), "laser", "<topicName>scan</topicName>")
            + sensor("sonar", "ray", 10, rays(7, 0.2, 4.0), "range", "<topicName>sonar</topicName>")
            + sensor("eye", "camera", 10, camera(16, 12), "camera", LENS)
            + sensor("touch", "contact", 10, "<contact><collision>c</collision></contact>", "bumper", "")
            + """<collision name="c"><geometry><box><size>0.01 0.01 0.01</size></box></geometry></collision>"""
        )
        + pendulum(
            sensor("imu", "imu", 50, "", "imu_sensor", "<frameName>f</frameName>"),
            """<plugin name="old" filename="libgazebo_ros_imu.so"><bodyName>bob</bodyName></plugin>
<plugin name="truth" filename="libgazebo_ros_p3d.so"><bodyName>bob</bodyName><topicName>truth</topicName></plugin>
<plugin name="f3d" filename="libgazebo_ros_f3d.so"><bodyName>bob</bodyName><topicName>f3d</topicName></plugin>""",
        ),
        {
            "/scan": SCAN,
            "/sonar": RANGE,
            "/image_raw": IMAGE,
            "/camera_info": INFO,
            "/bumper_states": "gazebo_msgs/ContactsState",
            "/pendulum/imu_data": IMU,
            "/default_imu": IMU,
            "/truth": ODOMETRY,
            "/f3d": WRENCH,
        },
        tolerances={
            ":data": (2.0, 0.2),
            "/pendulum/imu_data:orientation": (0.003, 0.0),
            "/pendulum/imu_data:angular_velocity": (0.025, 0.0),
            "/pendulum/imu_data:linear_acceleration": (0.15, 0.0),
        },
    ),
    "imus": Scene(
        pendulum(
            sensor(
                "imu",
                "imu",
                100,
                "",
                "imu_sensor",
                """<topicName>imu</topicName><frameName>imu_frame</frameName><updateRateHZ>50</updateRateHZ>
  <bodyName>bob</bodyName>""",
            )
            + sensor(
                "relative",
                "imu",
                50,
                "",
                "imu_sensor",
                """<topicName>relative</topicName><frameName>bob</frameName><updateRateHZ>50</updateRateHZ>
  <bodyName>bob</bodyName><initialOrientationAsReference>true</initialOrientationAsReference>
  <rpyOffset>0 0 0.2</rpyOffset>""",
            ),
            """<plugin name="old" filename="libgazebo_ros_imu.so"><bodyName>bob</bodyName><topicName>old</topicName>
  <robotNamespace>/bot</robotNamespace><updateRate>50</updateRate><rpyOffset>0 0.1 0</rpyOffset></plugin>
<plugin name="bare" filename="libgazebo_ros_imu.so"><bodyName>bob</bodyName>
  <serviceName>/calibrate</serviceName></plugin>""",
        ),
        {"/pendulum/imu": IMU, "/pendulum/relative": IMU, "/bot/old": IMU, "/default_imu": IMU},
        tolerances={
            "/pendulum/imu:orientation": (0.003, 0.0),
            "/pendulum/imu:angular_velocity": (0.025, 0.0),
            "/pendulum/imu:linear_acceleration": (0.15, 0.0),
            "/pendulum/relative:orientation": (0.003, 0.0),
            "/pendulum/relative:angular_velocity": (0.025, 0.0),
            "/pendulum/relative:linear_acceleration": (0.15, 0.0),
        },
    ),
    "poses": Scene(
        pendulum(
            plugins="""<plugin name="truth" filename="libgazebo_ros_p3d.so"><bodyName>bob</bodyName>
  <topicName>truth</topicName><updateRate>40</updateRate></plugin>
<plugin name="relative" filename="libgazebo_ros_p3d.so"><bodyName>bob</bodyName><topicName>relative</topicName>
  <frameName>base</frameName><updateRate>50</updateRate><xyzOffset>0.1 0.2 0.3</xyzOffset>
  <rpyOffset>0 0 0.5</rpyOffset><robotNamespace>/bot</robotNamespace></plugin>
<plugin name="all" filename="libgazebo_ros_joint_state_publisher.so"><jointName>hinge</jointName></plugin>
<plugin name="some" filename="libgazebo_ros_joint_state_publisher.so"><robotNamespace>/bot</robotNamespace>
  <jointName>hinge, slide</jointName><updateRate>30</updateRate></plugin>
<link name="slider"><pose>0 1 2 0 0 0</pose>"""
            + inertial(1, 0.2)
            + """</link><joint name="slide" type="prismatic"><parent>base</parent><child>slider</child>
  <axis><xyz>0 1 1</xyz><dynamics><damping>4</damping></dynamics></axis></joint>"""
        ),
        {"/truth": ODOMETRY, "/bot/relative": ODOMETRY, "/pendulum/joint_states": JOINTS, "/bot/joint_states": JOINTS},
        tolerances={
            "/pendulum/joint_states": (0.03, 0.0),
        },
    ),
    "bumper": Scene(
        f"""<model name="ball"><pose>0.5 0.25 0.1 0 0 0.3</pose><link name="link">{inertial(2, 0.2)}
  <collision name="c"><geometry><sphere><radius>0.1</radius></sphere></geometry></collision>"""
        + sensor(
            "bumper",
            "contact",
            20,
            "<contact><collision>c</collision></contact>",
            "bumper",
            "<bumperTopicName>bumper</bumperTopicName><frameName>box_frame</frameName>",
        )
        + """</link></model>
<model name="air"><pose>3 0 5 0 0 0</pose><static>true</static><link name="link"><collision name="c"><geometry><sphere>
  <radius>0.1</radius></sphere></geometry></collision>"""
        + sensor(
            "nothing",
            "contact",
            10,
            "<contact><collision>c</collision></contact>",
            "bumper",
            "<robotNamespace>/bot</robotNamespace>",
        )
        + "</link></model>",
        {"/bumper": "gazebo_msgs/ContactsState", "/bot/bumper_states": "gazebo_msgs/ContactsState"},
        tolerances={".force.z": (0.011, 0.0), ".length": (2.0, 0.0)},
    ),
    "wrenches": Scene(
        f"""<model name="arm"><link name="base"><pose>0 0 2 0 0 0</pose>{inertial(5, 0.2)}</link>
<joint name="fixed" type="fixed"><parent>world</parent><child>base</child></joint>
<link name="bar"><pose>0.5 0 2 0 0.3 0</pose>{inertial(1, 0.2)}</link>
<joint name="wrist" type="revolute"><parent>base</parent><child>bar</child><pose>-0.5 0 0 0 0 0</pose>
  <axis><xyz>0 1 0</xyz><limit><lower>0</lower><upper>0</upper></limit></axis>
  <physics><provide_feedback>true</provide_feedback></physics></joint>
<plugin name="ft" filename="libgazebo_ros_ft_sensor.so"><jointName>wrist</jointName><topicName>ft</topicName>
  <updateRate>50</updateRate></plugin>
<plugin name="f3d" filename="libgazebo_ros_f3d.so"><bodyName>puck</bodyName><topicName>f3d</topicName>
  <frameName>puck_frame</frameName></plugin>
<link name="puck"><pose>3 0 0.1 0 0 0</pose>{inertial(2, 0.2)}<collision name="c"><geometry>
  <box><size>0.2 0.2 0.2</size></box></geometry>
  <surface><friction><ode><mu>0</mu><mu2>0</mu2></ode></friction></surface></collision></link>
<plugin name="force" filename="libgazebo_ros_force.so"><bodyName>puck</bodyName><topicName>push</topicName></plugin>
<plugin name="truth" filename="libgazebo_ros_p3d.so"><bodyName>puck</bodyName><topicName>truth</topicName></plugin>
</model>""",
        {"/ft": WRENCH, "/f3d": WRENCH, "/truth": ODOMETRY},
        (("/push", "geometry_msgs/Wrench", {"force.x": 1.0, "force.y": 0.5, "torque.z": 0.02}),),
        seconds=1.0,
        tolerances={
            "/f3d": (0.001, 0.0),
        },
    ),
    "ranges": Scene(
        WALL
        + stand(
            sensor("sonar", "ray", 10, rays(7, 0.2, 4.0), "range", "<topicName>sonar</topicName>")
            + sensor(
                "infrared",
                "ray",
                20,
                rays(3, 0.05, 1.0),
                "range",
                """<robotNamespace>/bot</robotNamespace><topicName>ir</topicName><frameName>ir_frame</frameName>
  <radiation>infrared</radiation><fov>0.1</fov><updateRate>10</updateRate>""",
            )
        ),
        {"/sonar": RANGE, "/bot/ir": RANGE},
    ),
    "diff_drive_solved": Scene(
        SOLVED + two_wheels("plain", 2.0, ""),
        {"/plain/odom": ODOMETRY, "/tf": TF},
        (("/plain/cmd_vel", "geometry_msgs/Twist", twist(0.3, -0.4)),),
        tolerances={
            "twist": (2e-4, 0.0),
            "": (0.001, 0.0),
        },
    ),
    "tricycle_drive": Scene(
        SOLVED
        + tricycle(
            "encoders",
            0.0,
            """<robotNamespace>/encoders</robotNamespace><odometrySource>encoder</odometrySource>
  <updateRate>50</updateRate><publishWheelTF>true</publishWheelTF>
  <publishWheelJointState>true</publishWheelJointState>""",
        )
        + tricycle("plain", 3.0, "<steeringSpeed>1</steeringSpeed>"),
        {
            "/encoders/odom": ODOMETRY,
            "/encoders/joint_states": JOINTS,
            "/plain/odom": ODOMETRY,
            "/tf": TF,
        },
        (
            ("/encoders/cmd_vel", "geometry_msgs/Twist", twist(0.3, 0.4)),
            ("/plain/cmd_vel", "geometry_msgs/Twist", twist(0.3, 0.4)),
        ),
        tolerances={  # setting the steering's angle at the begin slips the rear wheels
            "/encoders/odom": (0.015, 0.0),
            "/encoders/joint_states:position": (0.25, 0.0),
            "/encoders/joint_states:velocity": (0.002, 0.0),
            "/plain/odom": (0.015, 0.0),
            "/tf:transforms.0.transform": (0.05, 0.0),
        },
    ),
    "vacuum_gripper": Scene(
        f"""<model name="hand"><pose>0 0 1 0 0 0</pose><link name="palm">{inertial(5, 0.2)}</link>
<joint name="fixed" type="fixed"><parent>world</parent><child>palm</child></joint>
<plugin name="vacuum" filename="libgazebo_ros_vacuum_gripper.so"><robotNamespace>/hand</robotNamespace>
  <bodyName>palm</bodyName><topicName>grasping</topicName></plugin></model>
<model name="thing"><pose>0.03 0.01 0.98 0 0 0</pose><link name="link">{inertial(1, 0.1)}</link>
{truth("link", "thing")}</model>
<model name="other"><pose>0.2 0 1 0 0 0</pose><link name="link">{inertial(1, 0.1)}</link>
{truth("link", "other")}</model>""",
        {"/hand/grasping": "std_msgs/Bool", "/thing": ODOMETRY, "/other": ODOMETRY},
        calls=("/hand/on",),
        seconds=1.0,
    ),
    "hand_of_god": Scene(
        f"""<model name="god"><pose>0 0 1 0 0 0.3</pose><link name="hand">{inertial(2, 0.2)}</link>
<plugin name="hog" filename="libgazebo_ros_hand_of_god.so"><linkName>hand</linkName><kl>20</kl><ka>1</ka></plugin>
{truth("hand", "truth")}</model>""",
        {"/tf": TF, "/truth": ODOMETRY},
        (
            (
                "/tf",
                "tf2_msgs/TFMessage",
                {
                    "transforms.0.header.frame_id": "world",
                    "transforms.0.child_frame_id": "hog_desired",
                    "transforms.0.transform.translation.x": 0.5,
                    "transforms.0.transform.translation.z": 1.2,
                    "transforms.0.transform.rotation.z": 0.6,
                    "transforms.0.transform.rotation.w": 0.8,
                },
            ),
        ),
        seconds=1.0,
        tolerances={
            "": (0.0015, 0.0),
        },
    ),
    "multicamera": Scene(
        WALL
        + stand(
            f"""<sensor name="stereo" type="multicamera"><always_on>1</always_on><update_rate>20</update_rate>
  {camera(64, 48).replace("<camera>", '<camera name="left">')}
  {camera(64, 48).replace("<camera>", '<camera name="right"><pose>0 -0.1 0 0 0 0</pose>')}
  <plugin name="p" filename="libgazebo_ros_multicamera.so"><cameraName>stereo</cameraName>
  <frameName>stereo_frame</frameName><imageTopicName>image_raw</imageTopicName>
  <cameraInfoTopicName>camera_info</cameraInfoTopicName><hackBaseline>0.1</hackBaseline>{LENS}</plugin></sensor>"""
        ),
        {
            "/stereo/left/image_raw": IMAGE,
            "/stereo/left/camera_info": INFO,
            "/stereo/right/image_raw": IMAGE,
            "/stereo/right/camera_info": INFO,
        },
        tolerances={
            ":data": (2.0, 0.2),
        },
    ),
    "elevator": Scene(
        f"""<model name="lift"><pose>1 0 0.05 0 0 0</pose><link name="car">{inertial(800, 2.0)}</link>
<joint name="rail" type="prismatic"><parent>world</parent><child>car</child>
  <axis><xyz>0 0 1</xyz><limit><lower>0</lower><upper>10</upper><effort>100000</effort></limit></axis></joint>
<link name="door"><pose>0.5 0 0.5 0 0 0</pose>{inertial(5, 0.5)}</link>
<joint name="slider" type="prismatic"><parent>car</parent><child>door</child>
  <axis><xyz>0 1 0</xyz><limit><lower>0</lower><upper>1</upper><effort>100</effort></limit></axis></joint>
<plugin name="e" filename="libgazebo_ros_elevator.so"><robotNamespace>/bot</robotNamespace><topic>floor</topic>
  <lift_joint>lift::rail</lift_joint><door_joint>lift::slider</door_joint><floor_height>1</floor_height>
  <door_wait_time>0.5</door_wait_time></plugin>{truth("car", "car")}{truth("door", "door")}</model>""",
        {"/car": ODOMETRY, "/door": ODOMETRY},
        (("/bot/floor", "std_msgs/String", {"data": "1"}),),
    ),
    "harness": Scene(
        f"""<model name="load"><pose>0 0 3 0 0 0</pose><link name="link">{inertial(5, 0.3)}</link>
<plugin name="h" filename="libgazebo_ros_harness.so">
  <joint name="winch" type="prismatic"><parent>world</parent><child>link</child>
    <axis><xyz>0 0 1</xyz><limit><lower>-10</lower><upper>10</upper></limit>
    <dynamics><damping>10</damping></dynamics></axis></joint>
  <winch><joint>winch</joint><pos_gain><p>0</p><i>0</i><d>0</d><i_max>0</i_max><i_min>0</i_min></pos_gain>
    <vel_gain><p>10000</p><i>0</i><d>0</d><i_max>0</i_max><i_min>0</i_min><cmd_max>10000</cmd_max>
    <cmd_min>-10000</cmd_min></vel_gain></winch><detach>winch</detach></plugin>{truth("link", "truth")}</model>""",
        {"/truth": ODOMETRY},
        (("/load/harness/velocity", "std_msgs/Float32", {"data": -0.5}),),
    ),
    "joint_pose_trajectory": Scene(
        pendulum(
            plugins="""<plugin name="t" filename="libgazebo_ros_joint_pose_trajectory.so">
  <topicName>/bot/play</topicName></plugin>
<plugin name="all" filename="libgazebo_ros_joint_state_publisher.so"><jointName>hinge</jointName></plugin>"""
        ),
        {"/pendulum/joint_states": JOINTS},
        (
            (
                "/bot/play",
                "trajectory_msgs/JointTrajectory",
                {
                    "header.frame_id": "world",
                    "joint_names": ["hinge"],
                    "points.0.positions": [0.3],
                    "points.0.time_from_start.secs": 1,
                    "points.1.positions": [0.6],
                    "points.1.time_from_start.secs": 1,
                },
            ),
        ),
    ),
    "states": Scene(
        pendulum(),
        {
            "/clock": "rosgraph_msgs/Clock",
            "/gazebo/model_states": "gazebo_msgs/ModelStates",
            "/gazebo/link_states": "gazebo_msgs/LinkStates",
        },
        seconds=1.0,
    ),
}


def values_of(command: dict[str, Any], message: Any) -> Any:
    """Set fields of a message by their paths; a number in a path is that of a message in a list."""
    for path, value in command.items():
        *way, last = path.split(".")
        part, kind = message, message.kind.name
        for name in way:
            if isinstance(part, list):
                part += [message_type(kind)() for _ in range(len(part), int(name) + 1)]
                part = part[int(name)]
            else:
                kind = next((one.kind for one in part.kind.fields if one.name == name), "")
                part = getattr(part, name)
        setattr(part, last, value)
    return message
