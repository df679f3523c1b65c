"""The worlds: SDF, the commands that are published while they run, and how far links may be from Gazebo's [m].

A command is (iteration, topic, speed [m/s], turn [rad/s]), as a Pose, or (iteration, topic, text), as a GzString. What
contacts decide is within some millimetres; the rest in docs/classic_cxx.md. All else is within 1e-6 m.
"""

from dataclasses import dataclass, field

STEPS = 2000
EXACT, TOUCHING, TURNING = 1e-6, 2e-3, 0.02  # [m]

GROUND = (
    "<model name='ground'><static>1</static><link name='l'><collision name='c'><geometry><plane><normal>0 0 1</normal>"
    "<size>100 100</size></plane></geometry></collision></link></model>"
)


@dataclass
class Beside:
    """A world.

    Attributes:
        text: SDF.
        commands: while it runs.
        tolerance: [m].
        files: in the folder of models, by their paths.
        links: those that are compared; all without them.
        compiled: whether only the plugin in C++ moves as in Gazebo, and the ready one differs.
    """

    text: str
    commands: tuple = ()
    tolerance: float = EXACT
    files: dict[str, str | bytes] = field(default_factory=dict)
    links: tuple[str, ...] = ()
    compiled: bool = False


def inertia(mass, moment):
    return (
        f"<inertial><mass>{mass}</mass><inertia><ixx>{moment}</ixx><iyy>{moment}</iyy><izz>{moment}</izz></inertia>"
        "</inertial>"
    )


def box_collision(size):
    return f"<collision name='c'><geometry><box><size>{size}</size></box></geometry></collision>"


def plugin(name, inside=""):
    return f"<plugin name='{name}' filename='lib{name}.so'>{inside}</plugin>"


def world(*parts, commands=(), tolerance=EXACT, gravity="0 0 -9.8", solver=""):
    text = (
        f"<sdf version='1.6'><world name='default'><gravity>{gravity}</gravity><physics type='ode'><max_step_size>0.001"
        f"</max_step_size><real_time_update_rate>0</real_time_update_rate><ode><solver>{solver}</solver></ode></physics>"
        f"{''.join(parts)}</world></sdf>"
    )
    return Beside(text, tuple(commands), tolerance)


def wheel(name, x, y, radius=0.1):
    shape = f"<cylinder><radius>{radius}</radius><length>.05</length></cylinder>"
    return (
        f"<link name='{name}w'><pose>{x} {y} {radius} -1.5707963 0 0</pose>{inertia(0.5, 0.002)}<collision name='c'>"
        f"<geometry>{shape}</geometry></collision></link><joint name='{name}' type='revolute'><parent>base</parent>"
        f"<child>{name}w</child><axis><xyz>0 0 1</xyz></axis></joint>"
    )


def base(height=0.15):
    return f"<link name='base'><pose>0 0 {height} 0 0 0</pose>{inertia(5, 0.1)}{box_collision('.5 .3 .1')}</link>"


def two_wheels(height, more=""):
    slippery = "<surface><friction><ode><mu>0</mu><mu2>0</mu2></ode></friction></surface>"
    caster = (
        f"<link name='cw'><pose>-.2 0 .05 0 0 0</pose>{inertia(0.2, 0.001)}<collision name='c'>"
        f"<geometry><sphere><radius>"
        f".05</radius></sphere></geometry>{slippery}</collision></link><joint name='cj' type='ball'><parent>base"
        "</parent><child>cw</child></joint>"
    )
    drive = plugin("DiffDrivePlugin", f"{WHEELS}{more}")
    wheels = wheel("left", 0.1, 0.2) + wheel("right", 0.1, -0.2)
    return f"<model name='dd'><pose>0 0 {height} 0 0 0</pose>{base()}{wheels}{caster}{drive}</model>"


FOUR = {"left_front": (0.2, 0.2), "right_front": (0.2, -0.2), "left_rear": (-0.2, 0.2), "right_rear": (-0.2, -0.2)}


def rover(inside, height=0.0):
    wheels = "".join(wheel(name, *place) for name, place in FOUR.items())
    return f"<model name='rover'><pose>0 0 {height} 0 0 0</pose>{base()}{wheels}{inside}</model>"


def box(name, pose, inside="", link="", mass=1, moment=0.1):
    return (
        f"<model name='{name}'><pose>{pose}</pose><link name='link'>{inertia(mass, moment)}"
        f"{box_collision('.4 .4 .4')}{link}</link>{inside}</model>"
    )


def wing(inside):
    return (
        f"<model name='wing'><pose>0 0 10 0 0 0</pose><link name='link'>{inertia(1, 0.2)}{box_collision('1 .2 .02')}"
        f"</link>{inside}</model>"
    )


def arm(inside="", axis="<dynamics><damping>.1</damping></dynamics>", limits="<lower>-2</lower><upper>2</upper>"):
    links = "".join(
        f"<link name='l{i}'><pose>{0.4 * i} 0 1 0 0 0</pose>{inertia(1, 0.05)}{box_collision('.3 .1 .1')}</link>"
        for i in range(3)
    )
    joints = "".join(
        f"<joint name='j{i}' type='revolute'><pose>-.2 0 0 0 0 0</pose><parent>l{i - 1}</parent><child>l{i}</child>"
        f"<axis><xyz>0 1 0</xyz><limit>{limits}<effort>100</effort></limit>{axis}</axis></joint>"
        for i in (1, 2)
    )
    fixed = "<joint name='fix' type='fixed'><parent>world</parent><child>l0</child></joint>"
    return f"<model name='arm'>{links}{fixed}{joints}{inside}</model>"


def gears(inside):
    wheels = "".join(
        f"<link name='{name}'><pose>0 {y} .5 0 0 0</pose>{inertia(1, 0.05)}</link>"
        f"<joint name='j{name}' type='revolute'>"
        f"<parent>base</parent><child>{name}</child><axis><xyz>0 1 0</xyz></axis></joint>"
        for name, y in (("a", 0), ("b", 0.5))
    )
    return (
        f"<model name='g'><link name='base'>{inertia(1, 0.1)}</link><joint name='f' type='fixed'><parent>world</parent>"
        f"<child>base</child></joint>{wheels}<joint name='gear' type='gearbox'><parent>a</parent><child>b</child>"
        "<gearbox_reference_body>base</gearbox_reference_body><gearbox_ratio>-2</gearbox_ratio><axis><xyz>0 1 0</xyz>"
        f"</axis><axis2><xyz>0 1 0</xyz></axis2></joint>{inside}</model>"
    )


def pid(tag, p, d, limits="<i_min>0</i_min><i_max>0</i_max><cmd_min>-1000</cmd_min><cmd_max>1000</cmd_max>"):
    return f"<{tag}><p>{p}</p><i>0</i><d>{d}</d>{limits}</{tag}>"


WINCH = "~/h/harness/velocity"


def harness(winch, detach="<detach>rope</detach>", commands=(), ground=GROUND):
    rope = (
        "<joint name='rope' type='prismatic'><parent>world</parent><child>link</child><axis><xyz>0 0 1</xyz><dynamics>"
        "<damping>10</damping></dynamics><limit><lower>-1.5</lower><upper>1.5</upper><effort>10000</effort></limit>"
        "</axis></joint>"
    )
    held = plugin("HarnessPlugin", rope + winch + detach)
    return world(
        ground,
        f"<model name='h'><pose>0 0 3 0 0 0</pose><link name='link'>{inertia(2, 0.1)}{box_collision('.3 .3 .3')}</link>"
        f"{held}</model>",
        commands=commands,
    )


def pendulum(joint, pose="0 0 2 0 .3 0"):
    return world(
        f"<model name='p'><link name='a'><pose>{pose}</pose>{inertia(1, 0.05)}</link><joint name='b' {joint}</joint>"
        "</model>"
    )


GIMBAL = (
    f"<model name='gimbal_small_2d'><link name='base'>{inertia(1, 0.1)}</link>"
    "<joint name='f' type='fixed'><parent>world</parent><child>base</child></joint>"
    f"<link name='t'><pose>.2 0 0 0 0 0</pose>{inertia(0.2, 0.001)}</link><joint name='tilt_joint' type='revolute'>"
    "<parent>base</parent><child>t</child><axis><xyz>0 1 0</xyz><limit><lower>-2</lower><upper>2</upper></limit></axis>"
    f"</joint>{plugin('GimbalSmall2dPlugin', '<joint>tilt_joint</joint>')}</model>"
)
WING = (
    "<a0>0.05</a0><cla>4</cla><cda>.1</cda><alpha_stall>.3</alpha_stall><cla_stall>-1</cla_stall>"
    "<cda_stall>.2</cda_stall>"
    "<cp>-.05 0 0</cp><forward>1 0 0</forward><upward>0 0 1</upward><area>.2</area><air_density>1.2</air_density>"
    "<link_name>link</link_name>"
)
ELEVATOR = (
    f"<model name='e'><link name='link'><pose>0 0 .1 0 0 0"
    f"</pose>{inertia(50, 10)}{box_collision('1 1 .1')}</link><joint "
    "name='lift' type='prismatic'><parent>world</parent><child>link</child><axis><xyz>0 0 1</xyz>"
    "<limit><lower>0</lower>"
    f"<upper>10</upper><effort>100000</effort></limit></axis></joint><link name='door'><pose>0 1 .5 0 0 0</pose>"
    f"{inertia(1, 1)}</link><joint name='dj' type='prismatic'><parent>link</parent><child>door</child><axis><xyz>0 1 0"
    "</xyz><limit><lower>0</lower><upper>1</upper><effort>10</effort></limit></axis></joint>"
    + plugin(
        "ElevatorPlugin",
        "<lift_joint>lift</lift_joint><door_joint>dj</door_joint><floor_height>3</floor_height><door_wait_time>5"
        "</door_wait_time><topic>~/elevator</topic>",
    )
    + "</model>"
)
WIND = plugin(
    "WindPlugin",
    "<horizontal><magnitude><time_for_rise>.5</time_for_rise><sin><amplitude_percent>.1</amplitude_percent><period>.4"
    "</period></sin></magnitude><direction><time_for_rise>.3</time_for_rise><sin><amplitude>10</amplitude><period>.5"
    "</period></sin></direction></horizontal><vertical><time_for_rise>.3</time_for_rise></vertical>"
    "<force_approximation_scaling_factor>.8</force_approximation_scaling_factor>",
)
BLOWN = box("a", "0 0 5 0 0 0", link="<enable_wind>true</enable_wind>")
MUD = plugin(
    "MudPlugin",
    "<contact_sensor_name>s</contact_sensor_name><stiffness>10</stiffness><damping>1</damping>"
    "<link_name>f::link</link_name>",
)
FEELING = "<sensor name='s' type='contact'><always_on>1</always_on><contact><collision>c</collision></contact></sensor>"
SLIP = plugin(
    "WheelSlipPlugin",
    "".join(
        f"<wheel link_name='{name}w'><slip_compliance_lateral>.5</slip_compliance_lateral>"
        f"<slip_compliance_longitudinal>.2"
        "</slip_compliance_longitudinal><wheel_normal_force>16</wheel_normal_force></wheel>"
        for name in FOUR
    ),
)
TRACKS = "".join(
    f"<link name='{name}'><pose>0 {y} .1 0 0 0</pose>{inertia(2, 0.05)}{box_collision('.5 .1 .2')}</link><joint name="
    f"'j{name}' type='fixed'><parent>base</parent><child>{name}</child></joint>"
    for name, y in (("lt", 0.2), ("rt", -0.2))
)
TRACKED = plugin(
    "SimpleTrackedVehiclePlugin",
    "<body>base</body><left_track>lt</left_track><right_track>rt</right_track><track_mu>2</track_mu><track_mu2>.5"
    "</track_mu2><tracks_separation>.4</tracks_separation>",
)
BREAKING = (
    f"<link name='b'><pose>1.2 0 1 0 0 0</pose>{inertia(1, 0.05)}</link><joint name='bj' type='revolute'><parent>l2"
    "</parent><child>b</child><axis><xyz>0 1 0</xyz></axis><sensor name='ft' type='force_torque'><always_on>1"
    "</always_on><update_rate>1000</update_rate>"
    + plugin("BreakableJointPlugin", "<breaking_force_N>12</breaking_force_N>")
    + "</sensor></joint>"
)
ACTOR = (
    "<actor name='walker'><pose>0 1 1.2138 1.57 0 0</pose><skin><filename>walk.dae</filename></skin>"
    "<animation name='walking'><filename>walk.dae</filename><interpolate_x>1</interpolate_x></animation>{}</actor>"
)
RAYS = (
    "<ray><scan><horizontal><samples>9</samples><min_angle>-.5</min_angle><max_angle>.5</max_angle></horizontal></scan>"
    "<range><min>.1</min><max>8</max></range></ray>"
)


def measuring(kind, settings, inside):
    """A body that turns without gravity before a wall, or falls, with a sensor."""
    sensor = (
        f"<sensor name='{kind}' type='{kind}'><always_on>1</always_on><update_rate>100</update_rate>{settings}{inside}"
        "</sensor>"
    )
    wall = (
        "<model name='wall'><static>1</static><pose>3 0 5 0 0 0</pose><link name='link'>"
        f"{box_collision('.5 6 6')}</link></model>"
    )
    return (
        f"<model name='a'><pose>0 0 5 0 0 .2</pose><link name='link'><gravity>0</gravity>{inertia(1, 0.1)}{sensor}"
        f"</link></model>{wall}"
    )


FELT = (
    "<joint name='held' type='fixed'><parent>world</parent><child>link</child><sensor name='ft' type='force_torque'>"
    f"<always_on>1</always_on><update_rate>100</update_rate>{plugin('ForceTorquePlugin')}</sensor></joint>"
)
WHEELS = "<left_joint>left</left_joint><right_joint>right</right_joint>"
DRIVE = plugin("DiffDrivePlugin", WHEELS)
DEPTH = (
    "<sensor name='d' type='depth'><always_on>1</always_on><update_rate>20</update_rate><camera><image>"
    "<width>41</width><height>31</height></image><clip><near>.1</near><far>9</far></clip></camera></sensor>"
)
CART = "".join(
    f"<{name}>{joint}</{name}><{name}_pid>30 1 2</{name}_pid><{name}_ilim>-1 1</{name}_ilim><{name}_pos>.3</{name}_pos>"
    f"<{name}_vel>0</{name}_vel><{name}_eff>20</{name}_eff>"
    for name, joint in (("steer", "j1"), ("right", "j2"), ("left", "j2"))
)
FLAPS = ("left_aileron", "left_flap", "right_aileron", "right_flap", "elevators", "rudder", "propeller")
SURFACES = "<propeller_max_rpm>2500</propeller_max_rpm><propeller_p_gain>1</propeller_p_gain>"
SURFACES += "<propeller_d_gain>0</propeller_d_gain><surfaces_p_gain>5</surfaces_p_gain><surfaces_d_gain>.1"
SURFACES += "</surfaces_d_gain>" + "".join(f"<{name}>{name}</{name}>" for name in FLAPS)


def surfaces(inside):
    """An aircraft of one body and seven surfaces, which falls."""
    parts = "".join(
        f"<link name='l{name}'><pose>{0.1 * number - 0.3} .3 0 0 0 0</pose>{inertia(0.1, 0.01)}</link>"
        f"<joint name='{name}' type='revolute'><parent>base</parent><child>l{name}</child><axis><xyz>0 1 .2</xyz>"
        "<limit><lower>-.6</lower><upper>.6</upper></limit><dynamics><damping>.01</damping></dynamics></axis></joint>"
        for number, name in enumerate(FLAPS)
    )
    return f"<model name='plane'><pose>0 0 9 .1 .2 0</pose>{base(0)}{parts}{inside}</model>"


PLANE = (
    "<engine name='e'><joint_name>j1</joint_name><max_torque>10</max_torque><inc_key>49</inc_key><dec_key>50</dec_key>"
    "<inc_val>1</inc_val><max_val>5</max_val><min_val>-5</min_val></engine><thruster name='t'><link_name>l1</link_name>"
    "<inc_key>51</inc_key><dec_key>52</dec_key><inc_val>1 0 0</inc_val><max_val>9 0 0</max_val><min_val>0 0 0</min_val>"
    "</thruster><control name='c'><joint_name>j2</joint_name><inc_key>53</inc_key><dec_key>54</dec_key><inc_val>.1"
    "</inc_val><max_val>1</max_val><min_val>-1</min_val><p>20</p><i>0</i><d>3</d><i_max>0</i_max><i_min>0</i_min>"
    "<cmd_max>50</cmd_max><cmd_min>-50</cmd_min></control>"
)


WHEEL_TRACKS = plugin(
    "WheelTrackedVehiclePlugin",
    "".join(f"<{name.split('_')[0]}_joint>{name}</{name.split('_')[0]}_joint>" for name in FOUR)
    + "<default_wheel_radius>.1</default_wheel_radius><tracks_separation>.4</tracks_separation><track_mu>.8</track_mu>",
)
DRIVEN = ((100, "~/dd/vel_cmd", 0.3, 0.0), (1000, "~/dd/vel_cmd", 0.2, 0.4))
HELD = "<joint>rope</joint>"
LINK = "<parent>world</parent><child>a</child>"
SWUNG = plugin("InitialVelocityPlugin", "<linear>1 2 3</linear><angular>.3 .2 .1</angular>")

WORLDS = {
    "DiffDrive, straight": world(GROUND, two_wheels(0), commands=DRIVEN[:1], tolerance=TOUCHING),
    "DiffDrive, turning": world(GROUND, two_wheels(0), commands=DRIVEN, tolerance=TURNING),
    "DiffDrive, in the air": world(two_wheels(5), commands=DRIVEN, gravity="0 0 0"),
    "DiffDrive with a torque": world(two_wheels(5, "<torque>5</torque>"), commands=DRIVEN, gravity="0 0 0"),
    "SkidSteer": world(
        GROUND, rover(plugin("SkidSteerDrivePlugin")), commands=[(100, "~/rover/vel_cmd", 0.3, 0.0)], tolerance=TOUCHING
    ),
    "SkidSteer, in the air": world(
        rover(plugin("SkidSteerDrivePlugin"), 5), commands=[(100, "~/rover/vel_cmd", 0.3, 0.2)], gravity="0 0 0"
    ),
    "LiftDrag": world(
        wing(
            plugin("InitialVelocityPlugin", "<linear>10 1 0</linear><angular>0 0 .2</angular>"),
        ).replace("</model>", plugin("LiftDragPlugin", WING) + "</model>")
    ),
    "InitialVelocity": world(box("a", "0 0 5 .1 .2 .3", SWUNG)),
    "velocity_decay": world(
        box("a", "0 0 5 0 0 0", SWUNG, "<velocity_decay><linear>.1</linear><angular>.2</angular></velocity_decay>")
    ),
    "RandomVelocity": world(
        box(
            "a",
            "0 0 5 0 0 0",
            plugin(
                "RandomVelocityPlugin",
                "<link>link</link><initial_velocity>1 0 .5</initial_velocity><velocity_factor>0</velocity_factor>"
                "<update_period>100</update_period>",
            ),
        )
    ),
    "Buoyancy": world(
        box(
            "a",
            "0 0 5 .1 .2 .3",
            plugin(
                "BuoyancyPlugin",
                "<fluid_density>20</fluid_density><link name='link'><center_of_volume>.05 0 .1</center_of_volume>"
                "<volume>.04</volume></link>",
            ),
        )
    ),
    "Buoyancy of collisions": world(
        box("a", "0 0 5 .1 .2 .3", plugin("BuoyancyPlugin", "<fluid_density>12</fluid_density>"))
    ),
    "JointControl": world(
        arm(
            plugin(
                "JointControlPlugin",
                "<controller type='position'><joint>j1</joint><target>.6</target><pid_gains>40 2 5</pid_gains>"
                "</controller>"
                "<controller type='velocity'><joint>j2</joint><target>.3</target><pid_gains>5 .1 0</pid_gains>"
                "</controller>",
            )
        )
    ),
    "JointControl, force": world(
        arm(plugin("JointControlPlugin", "<controller type='force'><joint>j1</joint><target>-2</target></controller>"))
    ),
    "JointTrajectory": world(arm(plugin("JointTrajectoryPlugin", "<update_rate>100</update_rate>"))),
    "Actuator": world(
        arm(
            plugin(
                "ActuatorPlugin",
                "<actuator><name>a</name><joint>j1</joint><index>0</index><type>electric_motor</type><power>3</power>"
                "<max_velocity>1</max_velocity><max_torque>4</max_torque></actuator>",
            )
            + plugin("JointControlPlugin", "<controller type='force'><joint>j1</joint><target>-9</target></controller>")
        )
    ),
    "BreakableJoint": world(arm(BREAKING)),
    "springs and friction": world(
        arm(
            axis="<dynamics><damping>.1</damping><spring_stiffness>20</spring_stiffness><spring_reference>.2"
            "</spring_reference><friction>.3</friction></dynamics>"
        )
    ),
    "Harness, both controllers": harness(f"<winch>{HELD}{pid('pos_pid', 300, 20)}{pid('vel_pid', 50, 0)}</winch>"),
    "Harness, position": harness(f"<winch>{HELD}{pid('pos_pid', 300, 20)}</winch>"),
    "Harness, velocity": harness(f"<winch>{HELD}{pid('vel_pid', 50, 0)}</winch>"),
    "Harness, winch down and up": harness(
        f"<winch>{HELD}{pid('pos_pid', 3000, 200)}{pid('vel_pid', 500, 0)}</winch>",
        commands=((300, WINCH, "-0.2"), (900, WINCH, "0.5"), (1500, WINCH, "0")),
    ),
    "Harness, let go": harness(
        f"<winch>{HELD}{pid('pos_pid', 3000, 200)}{pid('vel_pid', 500, 0)}</winch>",
        commands=((300, WINCH, "-0.2"), (1800, "~/h/harness/detach", "true")),
    ),
    "Harness, let go and caught": harness(
        f"<winch>{HELD}{pid('pos_pid', 3000, 200)}{pid('vel_pid', 500, 0)}</winch>",
        commands=((300, "~/h/harness/detach", "true"), (900, "~/h/harness/attach", 0.5, 0.2), (1400, WINCH, "0.2")),
        ground="",
    ),
    "Harness, no detach": harness(f"<winch>{HELD}{pid('pos_pid', 300, 20)}</winch>", ""),
    "GimbalSmall2d": world(GIMBAL),
    "Elevator": world(ELEVATOR),
    "LinearBattery": world(
        box(
            "a",
            "0 0 5 0 0 0",
            plugin(
                "LinearBatteryPlugin",
                "<link_name>link</link_name><battery_name>bat</battery_name><open_circuit_voltage_constant_coef>12"
                "</open_circuit_voltage_constant_coef><open_circuit_voltage_linear_coef>-3"
                "</open_circuit_voltage_linear_coef><initial_charge>1</initial_charge><capacity>1</capacity>"
                "<resistance>.1"
                "</resistance><smooth_current_tau>2</smooth_current_tau>",
            ),
            "<battery name='bat'><voltage>12</voltage></battery>",
        )
    ),
    "Wind": world(BLOWN, "<wind><linear_velocity>3 1 0</linear_velocity></wind>", WIND),
    "Mud": world(
        GROUND,
        box("mud", "0 0 .2 0 0 0", MUD, FEELING, 50, 2),
        box("f", "0 0 .62 0 0 0"),
        tolerance=TOUCHING,
    ),
    "WheelSlip": world(
        GROUND,
        rover(SLIP + plugin("InitialVelocityPlugin", "<linear>.3 .1 0</linear>")),
        tolerance=TOUCHING,
    ),
    "SimpleTrackedVehicle": world(GROUND, f"<model name='t'>{base(0.2)}{TRACKS}{TRACKED}</model>", tolerance=TOUCHING),
    "Actor": world(ACTOR.format(plugin("ActorPlugin", "<target>2 -3 1.2138</target>"))),
    "Actor, around a box": world(
        ACTOR.format(plugin("ActorPlugin", "<target>2 -3 1.2138</target><obstacle_weight>2</obstacle_weight>")),
        "<model name='wall'><static>1</static><pose>1.2 -1 .5 0 0 0</pose><link name='link'>"
        f"{box_collision('.4 .4 1')}</link></model>",
    ),
    "Ray": world(measuring("ray", RAYS, plugin("RayPlugin"))),
    "Sonar": world(
        measuring("sonar", "<sonar><min>.1</min><max>5</max><radius>.3</radius></sonar>", plugin("SonarPlugin"))
    ),
    "ImuSensor": world(measuring("imu", "<imu/>", plugin("ImuSensorPlugin"))),
    "ForceTorque": world(box("a", "0 0 5 0 .3 0", FELT, mass=2)),
    "Contact": world(
        GROUND,
        box("a", "0 0 .3 0 0 0", link=FEELING.replace("</sensor>", plugin("ContactPlugin") + "</sensor>")),
        tolerance=TOUCHING,
    ),
    "Pressure": world(
        GROUND,
        box("a", "0 0 .3 0 0 0", link=FEELING.replace("</sensor>", plugin("PressurePlugin") + "</sensor>")),
        tolerance=TOUCHING,
    ),
    "Touch": world(
        GROUND,
        box(
            "a",
            "0 0 .3 0 0 0",
            plugin(
                "TouchPlugin",
                "<sensor>s</sensor><target>ground</target><namespace>a</namespace><time>.5</time><enabled>1</enabled>",
            ),
            FEELING,
        ),
        tolerance=TOUCHING,
    ),
    "Follower": world(
        two_wheels(5).replace(DRIVE, plugin("FollowerPlugin", WHEELS)).replace("</link>", DEPTH + "</link>", 1),
        "<model name='wall'><static>1</static><pose>2 0 5 0 0 0</pose><link name='link'><visual name='v'><geometry>"
        "<box><size>.5 4 4</size></box></geometry></visual></link></model>",
        gravity="0 0 0",
    ),
    "CartDemo": world(arm(plugin("CartDemoPlugin", CART))),
    "LinearBatteryConsumer": world(
        box(
            "a",
            "0 0 5 0 0 0",
            plugin(
                "LinearBatteryConsumerPlugin",
                "<link_name>link</link_name><battery_name>bat</battery_name><power_load>2</power_load>",
            ),
            "<battery name='bat'><voltage>12</voltage></battery>",
        )
    ),
    "Transporter": world(
        box("a", "0 0 5 0 0 0"),
        plugin(
            "TransporterPlugin",
            "<pad name='one'><destination>two</destination><outgoing><min>-1 -1 0</min><max>1 1 3</max></outgoing>"
            "<incoming><pose>0 0 5 0 0 0</pose></incoming></pad><pad name='two'><destination>one</destination>"
            "<outgoing><min>3 3 0</min><max>4 4 1</max></outgoing><incoming><pose>5 2 9 0 .3 0</pose></incoming></pad>",
        ),
    ),
    "Misalignment": world(
        box("a", "0 0 5 0 0 0"),
        plugin(
            "MisalignmentPlugin",
            "<pose>0 0 1 0 0 0</pose><pose frame='a'>0 0 0 0 0 0</pose><namespace>m</namespace>",
        ),
    ),
    "Cessna": world(surfaces(SWUNG + plugin("CessnaPlugin", SURFACES))),
    "PlaneDemo": world(arm(plugin("PlaneDemoPlugin", PLANE))),
    "KeysToJoints": world(
        arm(
            plugin(
                "KeysToJointsPlugin",
                "<map key='65' joint='j1' scale='.5' type='position' kp='40' kd='5'/><map key='66' joint='j2' scale='1'"
                " type='velocity' kp='3'/>",
            )
        )
    ),
    "WheelTrackedVehicle": world(GROUND, rover(WHEEL_TRACKS), tolerance=TOUCHING),
    "VariableGearbox": world(
        gears(
            plugin(
                "VariableGearboxPlugin",
                "<gearbox_joint_name>gear</gearbox_joint_name><x_y_dydx>-1 -1 .5</x_y_dydx><x_y_dydx>0 0 1</x_y_dydx>"
                "<x_y_dydx>1 1.5 2</x_y_dydx>",
            )
            + plugin(
                "JointControlPlugin", "<controller type='force'><joint>ja</joint><target>.05</target></controller>"
            )
        )
    ),
    "gearbox": world(
        gears(
            plugin("JointControlPlugin", "<controller type='force'><joint>ja</joint><target>.3</target></controller>")
        )
    ),
    "ball": pendulum(f"type='ball'><pose>0 0 .5 0 0 0</pose>{LINK}"),
    "universal": pendulum(
        f"type='universal'><pose>-.5 0 0 0 0 0</pose>{LINK}<axis><xyz>0 1 0</xyz></axis><axis2>"
        f"<xyz>0 0 1</xyz></axis2>",
        ".5 0 2 0 .3 0",
    ),
    "screw": pendulum(f"type='screw'>{LINK}<axis><xyz>0 0 1</xyz></axis><thread_pitch>2</thread_pitch>", "0 0 2 0 0 0"),
    "prismatic": pendulum(
        f"type='prismatic'>{LINK}<axis><xyz>0 0 1</xyz><limit><lower>-.5</lower><upper>.5</upper></limit><dynamics>"
        "<friction>4</friction></dynamics></axis>",
        "0 0 2 0 0 0",
    ),
}
# The ready Follower keeps another distance at another speed; the ready Actor's way is 6 mm beside. Bones are of floats.
for name, tolerance in (("Follower", EXACT), ("Actor", 1e-5), ("Actor, around a box", 1e-5)):
    WORLDS[name].compiled, WORLDS[name].tolerance = True, tolerance
