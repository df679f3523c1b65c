"""Ready plugins of vehicles, mechanisms, places and lights, and those of the ROS era, each against a number."""

import itertools
import json
import math
from pathlib import Path

import pytest
from plugin_worlds import GROUND, body, collision, command, plugin, wheel
from topics import Heard, send

import libgz
from libgz.classic import msgs, transport
from libgz.classic.math import Pose3d

BOX = "<box><size>1 1 1</size></box>"


def slider(name, axis, low=-10, high=10, mass=1.0, parent="world", kind="prismatic"):
    inertia = "<inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia>"
    return (
        f"<link name='{name}_link'><gravity>false</gravity><inertial><mass>{mass}</mass>{inertia}</inertial></link>"
        f"<joint name='{name}' type='{kind}'><parent>{parent}</parent><child>{name}_link</child>"
        f"<axis><xyz>{axis}</xyz><limit><lower>{low}</lower><upper>{high}</upper></limit></axis></joint>"
    )


# Velocities and joints


def test_random_velocity_chooses_one_after_each_period_within_the_limits(run):
    elements = {"link": "link", "initial_velocity": "0.5 0 0", "velocity_factor": 2, "update_period": 1, "max_z": 0}
    core, world = run(body("ball", gravity="false", inside=plugin("RandomVelocityPlugin", min_z=0, **elements)))
    ball = world.ModelByName("ball")
    core.run(1.0)
    assert ball.WorldPose().Pos().X() == pytest.approx(0.5, abs=0.002)
    core.run(0.5)
    first = ball.GetLink("link").WorldLinearVel()
    assert first.Length() <= 2.0 + 1e-9
    assert first.Z() == pytest.approx(0.0, abs=1e-9)
    core.run(1.0)
    assert ball.GetLink("link").WorldLinearVel() != first


@pytest.mark.parametrize(("kind", "target"), [("position", 0.4), ("velocity", 0.7)])
def test_joint_control_reaches_its_targets(kind, target, run):
    inside = f"<controller type='{kind}'><joint>j</joint><target>{target}</target><pid>40 0 20</pid></controller>"
    if kind == "velocity":
        inside = inside.replace("40 0 20", "40 0 0")
    element = f"<plugin name='c' filename='libJointControlPlugin.so'>{inside}</plugin>"
    core, world = run(f"<model name='m'>{slider('j', '1 0 0')}{element}</model>")
    core.run(5.0)
    joint = world.ModelByName("m").GetJoint("j")
    assert (joint.Position(0) if kind == "position" else joint.GetVelocity(0)) == pytest.approx(target, rel=0.01)


def test_joint_control_applies_a_force_in_each_iteration(run):
    inside = "<controller type='force'><joint>j</joint><target>3</target></controller>"
    element = f"<plugin name='c' filename='libJointControlPlugin.so'>{inside}</plugin>"
    core, world = run(f"<model name='m'>{slider('j', '1 0 0', mass=2)}{element}</model>")
    core.run(1.0)
    assert world.ModelByName("m").GetJoint("j").GetVelocity(0) == pytest.approx(3.0 / 2.0 * 1.0, rel=1e-3)


def test_joint_control_takes_several_regular_expressions(run, caplog):
    joints = "<joint>arm_[0-9]</joint><joint>leg</joint><joint>arm</joint><joint>lge</joint><joint>(</joint>"
    inside = f"<controller type='force'>{joints}<target>2</target></controller>"
    element = f"<plugin name='c' filename='libJointControlPlugin.so'>{inside}</plugin>"
    parts = "".join(slider(name, "1 0 0") for name in ("arm_1", "arm_2", "leg", "arm_12", "tail"))
    core, world = run(f"<model name='m'>{parts}{element}</model>")
    core.run(0.5)
    moving = {joint.GetName(): joint.GetVelocity(0) > 0.1 for joint in world.ModelByName("m").GetJoints()}
    assert moving == {"arm_1": True, "arm_2": True, "leg": True, "arm_12": False, "tail": False}
    assert (
        "<joint> 'lge' matches no joint; there are arm_1, arm_2, leg, arm_12, tail; did you mean 'leg'?" in caplog.text
    )
    assert "<joint> '(' matches no joint" in caplog.text


# Ground


def test_wheel_slip_is_proportional_to_the_drag(run, caplog):
    mass, force, compliance, pull = 10.0, 98.0, 0.1, 20.0
    wheel = (
        "<link name='axle'><pose>0 0 0.2 0 0 0</pose><inertial><mass>0.1</mass></inertial></link>"
        "<link name='wheel'><pose>0 0 0.2 -1.5707963267948966 0 0</pose>"
        f"<inertial><mass>{mass}</mass><inertia><ixx>0.5</ixx><iyy>0.5</iyy><izz>0.5</izz></inertia></inertial>"
        "<collision name='c'><geometry><sphere><radius>0.2</radius></sphere></geometry>"
        "<surface><friction><ode><mu>1</mu><mu2>1</mu2><fdir1>0 0 1</fdir1></ode></friction></surface>"
        "</collision></link>"
        "<joint name='spin' type='revolute'><parent>axle</parent><child>wheel</child><axis><xyz>0 0 1</xyz>"
        "</axis></joint>"
        "<joint name='slide' type='prismatic'><parent>world</parent><child>axle</child><axis><xyz>1 0 0</xyz>"
        "</axis></joint>"
    )
    inside = (
        f"<wheel link_name='wheel'><slip_compliance_longitudinal>{compliance}</slip_compliance_longitudinal>"
        f"<wheel_normal_force>{force}</wheel_normal_force></wheel>"
    )
    element = f"<plugin name='s' filename='libWheelSlipPlugin.so'>{inside}</plugin>"
    core, world = run(GROUND, f"<model name='m'>{wheel}{element}</model>")
    model = world.ModelByName("m")
    spin, slide = model.GetJoint("spin"), model.GetJoint("slide")
    spin.SetParam("fmax", 0, 1000.0)
    spin.SetParam("vel", 0, 10.0)
    for _ in range(1500):
        slide.SetForce(0, -pull)
        core.step(1)
    speed, rolled = slide.GetVelocity(0), 10.0 * 0.2
    assert (rolled - speed) / rolled == pytest.approx(compliance * pull / force, rel=0.1)
    slipped = Heard("~/m/wheel_slip/wheel")
    core.step(2)
    assert slipped[-1].x == pytest.approx(speed - rolled, rel=0.1)  # nothing has pulled it in the last step
    assert slipped[-1].z == pytest.approx(rolled, rel=1e-3)
    assert slipped[-1].y == pytest.approx(0.0, abs=1e-3)
    for way, number in (("longitudinal", "0"), ("lateral", "a lot")):
        send(f"~/m/wheel_slip/{way}_compliance", msgs.GzString(data=number))
    core.run(0.5)
    assert slipped[-1].x == pytest.approx(0.0, abs=0.01)
    assert "the lateral compliance 'a lot' is no number" in caplog.text


def test_mud_damps_what_touches_it(run):
    ice = "<surface><friction><ode><mu>0</mu><mu2>0</mu2></ode></friction></surface>"
    floor = (
        "<model name='mud'><static>true</static><link name='link'><collision name='c'><geometry><plane>"
        f"<normal>0 0 1</normal><size>10 10</size></plane></geometry>{ice}</collision></link>"
        f"{plugin('MudPlugin', link_name='block::link', damping=4)}</model>"
    )
    core, world = run(floor, body("block", "0 0 0.5 0 0 0", mass=2.0, link=collision(BOX)))
    block = world.ModelByName("block")
    core.run(0.5)
    block.SetLinearVel((1.0, 0.0, 0.0))
    core.run(0.5)
    assert block.WorldLinearVel().X() == pytest.approx(math.exp(-4.0 / 2.0 * 0.5), rel=0.02)


def car():
    wheels = []
    shape = collision("<sphere><radius>0.3</radius></sphere>")
    for name, x, y in (("fl", 1, 0.6), ("fr", 1, -0.6), ("bl", -1, 0.6), ("br", -1, -0.6)):
        kind = "revolute2" if name[0] == "f" else "revolute"
        axes = (
            "<axis><xyz>0 0 1</xyz><limit><lower>-0.5</lower><upper>0.5</upper></limit></axis><axis2>"
            "<xyz>0 1 0</xyz></axis2>"
        )
        axes = axes if name[0] == "f" else "<axis><xyz>0 1 0</xyz></axis>"
        wheels.append(
            f"<link name='{name}_wheel'><pose>{x} {y} 0.3 0 0 0</pose><inertial><mass>5</mass><inertia><ixx>0.3</ixx>"
            f"<iyy>0.3</iyy><izz>0.3</izz></inertia></inertial>{shape}</link>"
            f"<joint name='{name}' type='{kind}'><parent>chassis</parent><child>{name}_wheel</child>{axes}</joint>"
        )
    chassis = (
        "<link name='chassis'><pose>0 0 0.5 0 0 0</pose><inertial><mass>100</mass><inertia><ixx>20</ixx><iyy>50</iyy>"
        "<izz>50</izz></inertia></inertial></link>"
    )
    pedals = "".join(
        slider(name, "1 0 0", low, high, 0.1, "chassis") for name, low, high in (("gas", 0, 0.05), ("brake", 0, 0.05))
    )
    pedals += slider("steering", "1 0 0", -1, 1, 0.1, "chassis", "revolute")
    drive = plugin(
        "VehiclePlugin",
        front_left_joint="fl",
        front_right_joint="fr",
        back_left_joint="bl",
        back_right_joint="br",
        gas_joint="gas",
        brake_joint="brake",
        steering_joint="steering",
        max_speed=5,
        tire_angle_range=1.0,
    )
    return f"<model name='car'>{chassis}{''.join(wheels)}{pedals}{drive}</model>"


def test_a_vehicle_drives_at_the_commanded_speed_and_steers(run):
    core, world = run(GROUND, car())
    vehicle = world.ModelByName("car")
    kept = command("~/car/vel_cmd", 2.0)
    core.run(4.0)
    assert vehicle.WorldLinearVel().X() == pytest.approx(2.0, rel=0.1)
    turned = command("~/car/vel_cmd", 2.0, 0.2)
    core.run(1.0)
    assert vehicle.GetJoint("fl").Position(0) == pytest.approx(-0.2, abs=0.03)  # of the parent against the child
    assert vehicle.WorldPose().Yaw() > 0.1
    assert kept is not turned


# Mechanisms


def test_an_elevator_comes_opens_waits_and_closes(run):
    lift = slider("lift", "0 0 1", 0, 10, 100.0)
    doors = slider("doors", "0 1 0", 0, 1, 5.0, "lift_link")
    element = plugin(
        "ElevatorPlugin",
        lift_joint="lift",
        door_joint="doors",
        floor_height=2.5,
        door_wait_time=1.0,
        topic="~/elevator",
        lift_pid="<p>5000</p><d>2000</d>",
        door_pid="<p>200</p><d>100</d>",
    )
    core, world = run(f"<model name='house'>{lift}{doors}{element}</model>")
    house = world.ModelByName("house")
    core.run(0.1)
    kept = send("~/elevator", msgs.GzString(data="2"))
    opened = 0.0
    for _ in range(120):
        core.run(0.1)
        opened = max(opened, house.GetJoint("doors").Position(0))
    assert house.GetJoint("lift").Position(0) == pytest.approx(5.0, abs=0.02)
    assert opened == pytest.approx(1.0, abs=0.06)
    assert house.GetJoint("doors").Position(0) == pytest.approx(0.0, abs=0.06)
    assert kept


def test_an_elevator_ignores_requests_while_it_is_busy(run):
    lift, doors = slider("lift", "0 0 1", 0, 10, 100.0), slider("doors", "0 1 0", 0, 1, 5.0, "lift_link")
    element = plugin("ElevatorPlugin", lift_joint="lift", door_joint="doors")
    core, world = run(f"<model name='house'>{lift}{doors}{element}</model>")
    elevator = world.server.plugins.of_model(world.ModelByName("house"))[0].plugin
    for floor in ("9" * 400, "-1000001", "one", *["1"] * 2000, "2"):
        elevator.OnRequest(msgs.GzString(data=floor))
    assert (elevator.wanted, len(elevator.steps)) == (1, 5)
    core.run(0.01)


def test_an_elevator_without_gains_has_those_of_gazebo(run, caplog):
    lift, doors = slider("lift", "0 0 1", 0, 10, 800.0), slider("doors", "0 1 0", 0, 1, 5.0, "lift_link")
    element = plugin("ElevatorPlugin", lift_joint="lift", door_joint="doors", floor_height=1.0)
    core, world = run(f"<model name='house'>{lift}{doors}{element}</model>")
    kept = send("~/elevator", msgs.GzString(data="1"))
    core.run(10.0)
    house = world.ModelByName("house")
    elevator = world.server.plugins.of_model(house)[0].plugin
    assert house.GetJoint("lift").Position(0) == pytest.approx(1.0, abs=1e-3)
    assert (elevator.lift_pid.GetPGain(), elevator.lift_pid.GetDGain()) == (1e5, 1e5)
    assert elevator.door_pid.GetPGain() == 2.0
    assert kept
    assert not caplog.records


def winched():
    joint = (
        "<joint name='rope' type='prismatic'><parent>world</parent><child>link</child><axis><xyz>0 0 1</xyz>"
        "<limit><lower>-10</lower><upper>10</upper></limit></axis></joint>"
    )
    limits = "<cmd_min>-1000</cmd_min><cmd_max>1000</cmd_max>"
    holding, pulling = f"<p>5000</p><d>500</d>{limits}", f"<p>500</p>{limits}"
    winch = f"<winch><joint>rope</joint><pos_pid>{holding}</pos_pid><vel_pid>{pulling}</vel_pid></winch>"
    return f"<plugin name='h' filename='libHarnessPlugin.so'>{joint}{winch}<detach>rope</detach></plugin>"


def test_a_harness_holds_lowers_and_detaches(run):
    core, world = run(body("robot", "0 0 5 0 0 0", mass=2.0, inside=winched()))
    robot = world.ModelByName("robot")
    core.run(2.0)
    assert robot.WorldPose().Pos().Z() == pytest.approx(5.0 - 2.0 * 9.8 / 5000.0, abs=2e-3)
    lowering = send("~/robot/harness/velocity", msgs.GzString(data="-0.5"))
    before = robot.WorldPose().Pos().Z()
    core.run(2.0)
    lag = 2.0 * 9.8 / 500.0  # of a proportional controller
    assert robot.WorldPose().Pos().Z() - before == pytest.approx(-2.0 * (0.5 + lag), abs=0.01)
    loose = send("~/robot/harness/detach", msgs.GzString(data="true"))
    core.run(0.01)
    speed = robot.WorldLinearVel().Z()
    core.run(0.5)
    assert robot.WorldLinearVel().Z() - speed == pytest.approx(-9.8 * 0.5, rel=0.01)
    core.Reset()
    core.run(1.0)
    assert robot.WorldPose().Pos().Z() == pytest.approx(5.0, abs=0.01)
    assert lowering != loose
    held = core.get_state()
    again = send("~/robot/harness/detach", msgs.GzString(data="true"))
    core.run(0.5)
    assert robot.WorldPose().Pos().Z() < 4.0
    core.set_state(held)
    core.run(1.0)
    assert world.ModelByName("robot").WorldPose().Pos().Z() == pytest.approx(5.0, abs=0.01)  # its winch acts again
    assert again is not None


def test_a_harness_is_not_attached_at_an_invalid_pose(run, caplog):
    core, world = run(body("robot", "0 0 5 0 0 0", mass=2.0, inside=winched()))
    robot, kept = world.ModelByName("robot"), [send("~/robot/harness/detach", msgs.GzString(data="true"))]
    core.run(0.1)
    for x in (math.nan, 1e300, 1.0):
        pose = msgs.Pose()
        msgs.Set(pose, Pose3d(0.0, 0.0, 7.0, 0.0, 0.0, 0.0))
        pose.position.x = x
        kept.append(send("~/robot/harness/attach", pose))
        core.run(0.1)
    assert robot.WorldPose().Pos() == pytest.approx((1.0, 0.0, 7.0), abs=0.1)
    assert [record.getMessage()[:28] for record in caplog.records] == ["HarnessPlugin: position [m] "] * 2


# Places


def test_a_region_event_box_publishes_who_enters_and_leaves(run):
    element = plugin("RegionEventBoxPlugin", event="<name>gate</name><type>inclusion</type>")
    visual = f"<visual name='v'><geometry>{BOX}</geometry></visual>"
    gate = (
        f"<model name='gate'><static>true</static><pose>2 0 0 0 0 0.7</pose>"
        f"<link name='link'>{visual}</link>{element}</model>"
    )
    core, world = run(gate, body("ball", gravity="false"))
    heard = Heard("/gazebo/sim_events")
    core.run(0.01)
    world.ModelByName("ball").SetWorldPose(Pose3d(2.6, 0, 0, 0, 0, 0))  # inside only as the box is turned
    core.run(0.01)
    world.ModelByName("ball").SetWorldPose(Pose3d(3, 0, 0, 0, 0, 0))
    core.run(0.01)
    assert [json.loads(event.data)["state"] for event in heard] == ["inside", "outside"]
    assert heard[0].name == "gate"


def test_contain_reports_changes_and_can_be_switched_off(run):
    element = plugin("ContainPlugin", entity="ball", namespace="box", pose="1 0 0 0 0 0", geometry=BOX)
    core, world = run(element, body("ball", gravity="false"))
    heard = Heard("/box/contain")
    for x in (0.0, 1.2, 0.0):
        world.ModelByName("ball").SetWorldPose(Pose3d(x, 0, 0, 0, 0, 0))
        core.run(0.01)
    assert [message.data for message in heard] == [0, 1, 0]
    kept = send("/box/enable", msgs.Int(data=0))
    core.run(0.01)
    world.ModelByName("ball").SetWorldPose(Pose3d(1, 0, 0, 0, 0, 0))
    core.run(0.01)
    assert len(heard) == 3
    assert kept


def test_touch_reports_after_the_time_of_one_touch(run):
    element = plugin("TouchPlugin", target="floor", time=0.5, namespace="touch", enabled="true")
    floor = (
        f"<model name='floor'><static>true</static><pose>0 0 -0.5 0 0 0</pose>"
        f"<link name='l'>{collision(BOX)}</link></model>"
    )
    core, world = run(floor, body("ball", "0 0 0.5 0 0 0", link=collision(BOX), inside=element))
    heard = Heard("/touch/touched")
    core.run(0.45)
    assert not heard
    core.run(0.2)
    assert [message.data for message in heard] == [1]
    core.run(1.0)
    assert len(heard) == 1
    assert world


def test_touch_counts_the_collisions_of_its_contact_sensors(run):
    sensor = "<sensor name='finger' type='contact'><contact><collision>finger</collision></contact></sensor>"
    finger = collision(BOX, "0 0 0.5 0 0 0", "finger")
    element = (
        "<plugin name='t' filename='libTouchPlugin.so'><sensor>finger</sensor><target>lid</target><time>0.1</time>"
        "<namespace>finger</namespace><enabled>true</enabled></plugin>"
    )
    floor, lid = (
        f"<model name='{name}'><static>true</static><pose>0 0 {z} 0 0 0</pose>"
        f"<link name='l'>{collision(BOX)}</link></model>"
        for name, z in (("floor", -0.99), ("lid", 1.49))
    )
    heard = Heard("/finger/touched")
    core, _ = run(floor + lid, body("hand", link=collision(BOX) + finger + sensor, inside=element, gravity="false"))
    core.run(0.3)
    assert [message.data for message in heard] == [1]  # the floor that the other collision touches does not count


def test_touch_names_a_missing_contact_sensor(run, caplog):
    element = plugin("TouchPlugin", sensor="fingr", target="x", time=1, namespace="n")
    sensor = "<sensor name='finger' type='contact'><contact><collision>c</collision></contact></sensor>"
    run(body("hand", link=collision(BOX) + sensor, inside=element))
    assert "<sensor> is 'fingr'; model 'hand' has the contact sensors finger; did you mean 'finger'?" in caplog.text


def test_a_transporter_moves_models_to_the_other_pad(run):
    def pad(name, x, outgoing, activation):
        box = f"<outgoing><min>{x - 0.5} -1 -1</min><max>{x + 0.5} 1 1</max></outgoing>"
        return (
            f"<pad name='{name}'><destination>{outgoing}</destination>{box}<activation>{activation}</activation>"
            f"<incoming><pose>{x} 3 0 0 0 0</pose></incoming></pad>"
        )

    pads = pad("a", 0, "b", "auto") + pad("b", 5, "a", "manual")
    element = (
        "<plugin name='t' filename='libTransporterPlugin.so'><activation_topic>~/go</activation_topic>"
        + pads
        + "</plugin>"
    )
    core, world = run(element, body("ball", gravity="false"))
    ball = world.ModelByName("ball")
    core.run(0.01)
    assert tuple(ball.WorldPose().Pos()) == pytest.approx((5, 3, 0), abs=1e-9)
    ball.SetWorldPose(Pose3d(5, 0, 0, 0, 0, 0))
    core.run(0.01)
    assert ball.WorldPose().Pos().X() == pytest.approx(5)
    core.paused = True
    kept = [send("~/go", msgs.GzString(data=name)) for name in (*"bb", "other")]
    core.step(5)
    assert core.facade.server.plugins.of_world["t"].plugin.called == ["b"]  # however many ask for it
    core.paused = False
    core.run(0.01)
    assert tuple(ball.WorldPose().Pos()) == pytest.approx((0, 3, 0), abs=1e-9)
    assert kept


def test_arrange_moves_models_by_name(run, caplog):
    element = (
        "<plugin name='a' filename='libArrangePlugin.so'><model_name>one</model_name><model_name>two</model_name>"
        "<arrangement name='row'><pose model='one'>1 0 0 0 0 0</pose><pose model='two'>2 0 0 0 0 0</pose></arrangement>"
        "<arrangement name='half'><pose model='one'>7 0 0 0 0 0</pose></arrangement>"
        "<initial_arrangement>row</initial_arrangement></plugin>"
    )
    core, world = run(body("one", gravity="false"), body("two", "0 9 0 0 0 0", gravity="false"), element)

    def places():
        return [round(world.ModelByName(name).WorldPose().Pos().X(), 6) for name in ("one", "two")]

    core.run(0.01)
    assert places() == [1, 2]
    kept = [send("~/arrange", msgs.GzString(data="half"))]
    core.run(0.01)
    assert places() == [7, 0]
    kept.append(send("~/arrange", msgs.GzString(data="hafl")))
    core.run(0.01)
    assert "did you mean 'half'" in caplog.text


def test_stop_world_ends_a_run(run):
    core, world = run(plugin("StopWorldPlugin", time=0.25))
    world.Run(1000)
    assert world.SimTime().Double() == pytest.approx(0.25, abs=0.002)
    assert core.GetSimTime() == pytest.approx(0.25, abs=0.002)


# Lights and lines


def test_a_flash_light_is_on_and_off_in_its_rhythm(run):
    light = "<light name='lamp' type='point'><attenuation><range>7</range></attenuation></light>"
    flash = "<light><id>link/lamp</id><duration>0.3</duration><interval>0.2</interval></light>"
    element = f"<plugin name='f' filename='libFlashLightPlugin.so'>{flash}</plugin>"
    core, world = run(body("post", gravity="false", link=light, inside=element))
    (geom,) = (g for g in world.ModelByName("post").GetLink("link").body.geoms if hasattr(g, "spot"))
    seen = []
    for _ in range(10):
        core.run(0.1)
        seen.append(geom.range)
    assert seen[:2] == [7.0, 7.0]
    assert seen[3] == 0.0
    assert seen[5:7] == [7.0, 7.0]
    assert 3 <= seen.count(0.0) <= 5


def test_a_missing_light_is_named(run, caplog):
    inside = "<light><id>link/lmap</id></light>"
    element = f"<plugin name='f' filename='libFlashLightPlugin.so'>{inside}</plugin>"
    run(body("post", link="<light name='lamp' type='point'/>", inside=element))
    assert "did you mean 'link/lamp'" in caplog.text


def test_leds_glow_with_their_lights(run):
    """Red for 0.2 s, blue for 0.2 s, dark for 0.6 s: the visual glows, the light shines."""
    blocks = (
        "<block><duration>0.2</duration><interval>0</interval><color>1 0 0</color></block>"
        "<block><duration>0.2</duration><interval>0.6</interval><color>0 0 1</color></block>"
    )
    look = "<visual name='led'><geometry><sphere><radius>0.1</radius></sphere></geometry></visual>"
    light = "<light name='led' type='point'><attenuation><range>7</range></attenuation></light>"
    element = plugin("LedPlugin", light=f"<id>link/led</id>{blocks}")
    core, world = run(body("post", gravity="false", link=look + light, inside=element))
    geoms = world.ModelByName("post").GetLink("link").body.geoms
    (lamp,) = (geom for geom in geoms if hasattr(geom, "spot"))
    (led,) = (geom for geom in geoms if not hasattr(geom, "spot"))
    seen = []
    for _ in range(10):
        core.run(0.1)
        glow = led.appearance.emission
        seen.append((lamp.range, (glow.r, glow.g, glow.b)))
    red, blue, dark = (7.0, (1.0, 0.0, 0.0)), (7.0, (0.0, 0.0, 1.0)), (0.0, (0.0, 0.0, 0.0))
    assert [seen[i] for i in (0, 2, 5, 8)] == [red, blue, dark, dark]
    assert set(seen) == {red, blue, dark}


def test_a_led_may_be_a_visual_alone(run, caplog):
    look = "<visual name='led'><geometry><sphere><radius>0.1</radius></sphere></geometry></visual>"
    element = plugin("LedPlugin", light="<id>link/led</id><duration>0.1</duration><interval>9</interval>")
    core, world = run(body("post", gravity="false", link=look, inside=element))
    (led,) = world.ModelByName("post").GetLink("link").body.geoms
    core.run(0.05)
    assert tuple(led.appearance.emission) == tuple(led.appearance.diffuse)
    core.run(0.1)
    assert led.appearance.emission.r == 0.0
    wrong = plugin("LedPlugin", light="<id>link/lad</id>")
    run(body("post", link=look, inside=wrong))
    assert "neither a light nor a visual of this name; did you mean 'link/led'" in caplog.text


def actor(inside, obstacle=""):
    skin = "<skin><filename>walk.dae</filename></skin>"
    animation = "<animation name='walking'><filename>walk.dae</filename><interpolate_x>true</interpolate_x></animation>"
    return f"<actor name='man'><pose>0 1 0.95 1.5707963 0 0</pose>{skin}{animation}{inside}</actor>{obstacle}"


def test_an_actor_walks_to_its_target(run):
    """0.8 m/s times the target weight; the time of its animation grows with the way."""
    element = plugin("ActorPlugin", target="0 -5 0.95", target_weight=1.0, animation_factor=4.5, area="-9 -9 9 9")
    core, world = run(actor(element))
    man = world.ModelByName("man")
    start = man.WorldPose()
    core.run(3.0)  # it turns to its target, and walks
    before, time = man.WorldPose().Pos().Y(), man.ScriptTime()
    core.run(1.0)
    walked = before - man.WorldPose().Pos().Y()
    assert walked == pytest.approx(0.8, abs=0.005)
    assert man.WorldPose().Pos().X() == pytest.approx(0.0, abs=1e-3)
    assert man.WorldPose().Pos().Z() == pytest.approx(0.95)
    assert man.ScriptTime() - time == pytest.approx(4.5 * walked, rel=0.01)
    world.Reset()
    core.step()
    assert man.WorldPose().Pos().Y() == pytest.approx(start.Pos().Y(), abs=0.01)


def test_an_actor_walks_around_models(run):
    element = plugin("ActorPlugin", target="0 -3 0.95", obstacle_weight=0.5, area="-9 -9 9 9")
    coarse = "<physics type='ode'><max_step_size>0.01</max_step_size></physics>"  # the plugin acts each step
    stone = "<model name='stone'><static>1</static><pose>0.1 -1 0.95 0 0 0</pose><link name='l'/></model>"
    core, world = run(coarse, actor(element, stone))
    man, nearest = world.ModelByName("man"), 9.0
    for _ in range(30):
        core.run(0.2)
        nearest = min(nearest, man.WorldPose().Pos().Distance(world.ModelByName("stone").WorldPose().Pos()))
    assert 0.3 < nearest < 2.0


def test_the_actor_plugin_moves_actors_only(run, caplog):
    run(body("box", inside=plugin("ActorPlugin")))
    assert "this plugin moves an <actor>; 'box' is a model" in caplog.text


def test_link_plot_adds_points_where_the_link_was(run):
    from libgz.classic import rendering

    element = plugin("LinkPlot3DPlugin", frequency=10, plot="<link>link</link><pose>0 0 1 0 0 0</pose>")
    core, world = run(body("ball", gravity="false", inside=element))
    world.ModelByName("ball").SetLinearVel((1.0, 0.0, 0.0))
    core.run(1.0)
    (line,) = rendering.get_scene("default").lines
    assert line.PointCount() in (10, 11)
    last = line.Point(line.PointCount() - 1)
    assert (last.X(), last.Z()) == pytest.approx((0.9, 1.0), abs=0.11)


# ROS


def robot(inside):
    ball = (
        "<collision name='b'><pose>0.2 0 -0.1 0 0 0</pose><geometry><sphere><radius>0.05</radius></sphere></geometry>"
    )
    ball += "<surface><friction><ode><mu>0</mu><mu2>0</mu2></ode></friction></surface></collision>"
    back = ball.replace("'b'", "'b2'").replace("0.2 0", "-0.2 0")
    base = f"<link name='base'><pose>0 0 0.15 0 0 0</pose><inertial><mass>5</mass></inertial>{ball}{back}</link>"
    return f"<model name='r2'>{base}{wheel('left', 0, 0.2)}{wheel('right', 0, -0.2)}{inside}</model>"


def test_ros_diff_drive_turns_left_and_publishes_odometry(run, caplog):
    drive = plugin(
        "gazebo_ros_diff_drive",
        leftJoint="left",
        rightJoint="right",
        wheelSeparation=0.4,
        wheelDiameter=0.2,
        torque=20,
        robotNamespace="bot",
    )
    states = plugin("gazebo_ros_joint_state_publisher", jointName="left, right", robotNamespace="bot")
    truth = plugin("gazebo_ros_p3d", bodyName="base", topicName="truth", robotNamespace="bot")
    core, world = run(GROUND, robot(drive + states + truth))
    odometry, joints, poses = Heard("/bot/odom"), Heard("/bot/joint_states"), Heard("/bot/truth")
    core.run(0.1)
    kept = command("/bot/cmd_vel", 0.2, 0.5)
    core.run(2.0)
    model = world.ModelByName("r2")
    assert model.WorldPose().Yaw() == pytest.approx(0.5 * 2.0, abs=0.12)
    assert odometry[-1].pose.orientation.z == pytest.approx(math.sin(model.WorldPose().Yaw() / 2), abs=0.05)
    assert [param.name for param in joints[-1].param] == ["left", "right"]
    assert joints[-1].param[1].value.double_value == pytest.approx(model.GetJoint("right").Position(0), abs=0.1)
    assert poses[-1].pose.position.x == pytest.approx(model.GetLink("base").WorldPose().Pos().X(), abs=0.01)
    assert caplog.text.count("has plugins for ROS") == 1
    assert kept


def test_ros_sensor_plugins_activate_their_sensors(run):
    scan = "<scan><horizontal><samples>5</samples><min_angle>-1</min_angle><max_angle>1</max_angle></horizontal></scan>"
    sensor = (
        "<sensor name='laser' type='ray'><update_rate>10</update_rate><ray>"
        + scan
        + "<range><min>0.1</min><max>5</max>"
        "</range></ray><plugin name='p' filename='libgazebo_ros_laser.so'><topicName>scan</topicName></plugin></sensor>"
    )
    core, world = run(body("post", gravity="false", link=sensor))
    core.run(0.3)
    from libgz.classic import sensors

    assert sensors.get_sensor("laser").Ranges() == [math.inf] * 5
    assert world


def test_ros_imu_measures_gravity_at_rest(run):
    element = plugin("gazebo_ros_imu", bodyName="link", topicName="imu", updateRate=50)
    core, _ = run(GROUND, body("box", "0 0 0.5 0 0 0", link=collision(BOX), inside=element))
    heard = Heard("~/box/imu")
    core.run(2.0)
    assert heard[-1].linear_acceleration.z == pytest.approx(9.8, abs=0.01)


def test_the_robot_of_the_ros_era_drives_and_measures():
    with libgz.World.from_file(EXAMPLES / "ros_robot.world") as core:
        topics = {"truth": "/rover/truth", "imu": "/rover/imu", "states": "/rover/joint_states"}
        heard = {name: Heard(topic) for name, topic in topics.items()}
        scans = Heard("~/rover/base/laser/scan")
        target = msgs.JointCmd(name="rover::shoulder")
        target.position.target, target.position.p_gain, target.position.d_gain = 0.6, 2.0, 0.4
        kept = [command("/rover/cmd_vel", 0.3), send("~/rover/joint_cmd", target)]
        core.run(2.0)
        robot = core.facade.ModelByName("rover")
        x = robot.GetLink("base").WorldPose().X()
        assert x == pytest.approx(0.6, abs=0.06)
        assert len(heard["truth"]) == pytest.approx(100, abs=2)
        assert heard["truth"][-1].pose.position.x == pytest.approx(x, abs=0.3 / 50 + 1e-3)
        assert heard["imu"][-1].linear_acceleration.z == pytest.approx(9.8, abs=0.5)
        assert heard["states"][-1].param[0].value.double_value == pytest.approx(0.6, abs=0.05)
        assert scans[-1].scan.ranges[45] == pytest.approx(2.0 - 0.1 - 0.2 - x, abs=0.04)
        assert kept


def test_an_unknown_plugin_of_ros_is_an_error(run, caplog):
    run(body("box", inside=plugin("gazebo_ros_coffee")))
    assert "Failed to load plugin libgazebo_ros_coffee.so" in caplog.text


EXAMPLES = Path(__file__).parents[3] / "examples" / "plugins" / "ready"


@pytest.mark.parametrize("name", sorted(path.stem for path in EXAMPLES.glob("*.world")))
def test_the_examples_run(name, caplog):
    with libgz.World.from_file(EXAMPLES / f"{name}.world") as world:
        world.step(300)
        assert [error for error in world.errors if error] == []
        assert all(math.isfinite(x) for model in world.models for x in model.GetPose().pos)
    assert [record.getMessage() for record in caplog.records if record.levelname == "ERROR"] == []


# Keys, breaking joints, lights that are carried, frames ---------------------------------------------------------------


def keys(*rows):
    maps = "".join("<map " + " ".join(f"{k}='{v}'" for k, v in row.items()) + "/>" for row in rows)
    return f"<plugin name='keys' filename='libKeysToJointsPlugin.so'>{maps}</plugin>"


def press(core, text):
    node = transport.Node()
    node.Init("default")
    publisher = node.Advertise(msgs.Any, "~/keyboard/keypress")
    for key in text:
        publisher.Publish(msgs.Any(int_value=ord(key)))
        core.step()


def test_keys_move_joints_to_positions_at_velocities_and_by_efforts(run, caplog):
    rows = (
        {"key": 97, "joint": "turn", "type": "position", "scale": 0.2, "kp": 40, "kd": 12},
        {"key": 98, "joint": "roll", "type": "velocity", "scale": 3, "kp": 50},
        {"key": 99, "joint": "lift", "type": "force", "scale": 100},
        {"key": 99, "joint": "turn", "type": "position", "scale": -0.5, "kp": 40, "kd": 12},
        {"key": 100, "joint": "left", "type": "force", "scale": 1},
        {"key": 100, "joint": "turn", "type": "twist", "scale": 1},
        {"key": 100, "joint": "turn", "type": "force"},
    )
    parts = slider("turn", "0 0 1", kind="revolute") + slider("roll", "1 0 0", -1e16, 1e16, kind="revolute")
    core, world = run(f"<model name='m'>{parts}{slider('lift', '0 0 1')}{keys(*rows)}</model>")
    for text in ("no joint 'left'", "type is 'twist'", "attribute 'scale' is missing"):
        assert text in caplog.text
    model = world.ModelByName("m")
    turn, roll, lift = (model.GetJoint(name) for name in ("turn", "roll", "lift"))
    press(core, "abd")
    core.run(4.0)
    assert turn.Position(0) == pytest.approx(0.2, abs=0.005)
    assert roll.GetVelocity(0) == pytest.approx(3.0, abs=0.02)
    press(core, "c")
    core.run(4.0)
    assert lift.GetVelocity(0) == pytest.approx(100.0 * 0.001 / 1.0, abs=1e-6)  # of one iteration, on 1 kg
    assert turn.Position(0) == pytest.approx(-0.3, abs=0.005)


def seam(limit, mass):
    sensor = (
        "<sensor name='ft' type='force_torque'><always_on>1</always_on><update_rate>1000</update_rate>"
        f"{plugin('BreakableJointPlugin', breaking_force_N=limit)}</sensor>"
    )
    joint = f"<joint name='seam' type='fixed'><parent>world</parent><child>link</child>{sensor}</joint>"
    return body(f"m{limit}", "0 0 5 0 0 0", mass, inside=joint)


def test_a_joint_breaks_when_it_bears_more_than_it_can(run, caplog):
    core, world = run(seam(19, 2.0), seam(20, 2.0))
    core.run(0.5)
    assert world.ModelByName("m19").WorldPose().Pos().Z() == pytest.approx(5.0 - 4.9 * 0.5**2, abs=0.05)  # 19.6 N
    assert world.ModelByName("m20").WorldPose().Pos().Z() == pytest.approx(5.0, abs=1e-6)
    core.Reset()
    core.step()
    assert world.ModelByName("m19").WorldPose().Pos().Z() == pytest.approx(5.0, abs=1e-3)
    core.run(0.2)
    assert world.ModelByName("m19").WorldPose().Pos().Z() < 4.9
    run(body("m", link="<sensor name='i' type='imu'><plugin name='b' filename='libBreakableJointPlugin.so'/></sensor>"))
    assert "requires a force_torque sensor, not imu" in caplog.text


def test_a_light_of_the_world_is_carried_by_a_link(run, caplog):
    def carried(name):
        element = f"<light><light_name>{name}</light_name><pose>0 0 1 0 0 0</pose></light>"
        return plugin("AttachLightPlugin", link=f"<link_name>link</link_name>{element}")

    lamp = "<light name='lamp' type='point'><pose>9 9 9 0 0 0</pose></light>"
    core, world = run(lamp, body("m", "1 0 50 0 0 1.5", inside=carried("lamp")), body("n", inside=carried("lump")))
    assert "<light_name> is 'lump'; the world has lamp; did you mean 'lamp'?" in caplog.text
    core.run(1.0)
    core.step()
    height = world.ModelByName("m").WorldPose().Pos().Z()
    assert (*world.Light("lamp").WorldPose().Pos(),) == pytest.approx((1.0, 0.0, height + 1.0), abs=0.02)
    assert height < 46


def test_misalignment_is_the_pose_of_the_target_in_the_reference(run):
    frames = "<pose frame='a'>1 0 0 0 0 0</pose><pose frame='b::link'>0 0 0 0 0 0</pose>"
    text = f"<plugin name='p' filename='libMisalignmentPlugin.so'>{frames}<namespace>n</namespace></plugin>"
    core, _ = run(
        text, body("a", "0 0 0 0 0 1.5707963", gravity="false"), body("b", "0.1 1.5 0 0 0 1.8", gravity="false")
    )
    heard = Heard("/n/misalignment")
    core.step(3)
    pose = msgs.ConvertIgn(heard[-1].pose)
    assert (*pose.Pos(), pose.Yaw()) == pytest.approx((0.5, -0.1, 0.0, 1.8 - math.pi / 2.0), abs=1e-6)
    count = len(heard)
    kept = send("/n/enable", msgs.Int(data=0))
    core.step(5)
    assert len(heard) <= count + 1
    del kept


def test_a_laser_has_noise_that_grows_with_its_range(run, caplog):
    def laser(noise):
        angles = "<samples>40</samples><min_angle>-0.2</min_angle><max_angle>0.2</max_angle>"
        scan = f"<scan><horizontal>{angles}</horizontal></scan><range><min>0.1</min><max>20</max></range>"
        ray = f"<always_on>1</always_on><ray>{scan}{noise}</ray>{plugin('RaySensorNoisePlugin')}"
        return f"<sensor name='s' type='ray'>{ray}</sensor>"

    wall = body("wall", "9.5 0 0 0 0 0", link=collision("<box><size>1 50 50</size></box>"), gravity="false")
    core, _ = run(body("eye", link=laser("<noise><type>custom</type></noise>"), gravity="false"), wall)
    core.step(3)
    from libgz.classic import sensors

    found = sensors.get_sensor("s").Ranges()
    true = [9.0 / math.cos(-0.2 + 0.4 * i / 39) for i in range(40)]
    off = [a / b - 1.0 for a, b in zip(found, true, strict=True)]
    assert 0.001 < max(map(abs, off)) <= 0.005
    assert all(a * b < 0.0 for a, b in itertools.pairwise(off))  # in turn
    run(body("eye", link=laser(""), gravity="false"))
    assert "needs <noise><type>custom</type></noise>" in caplog.text


# Elements of ROS 2 ----------------------------------------------------------------------------------------------------


def test_plugins_of_ros_take_the_elements_of_ros_2(run):
    wheels = "".join(
        wheel(f"{side}_{end}", x, y)
        for side, y in (("left", 0.2), ("right", -0.2))
        for end, x in (("front", 0.2), ("rear", -0.2))
    )
    names = "".join(
        f"<{side}_joint>{side}_{end}</{side}_joint>" for end in ("front", "rear") for side in ("left", "right")
    )
    ros = "<ros><namespace>/r</namespace><remapping>cmd_vel:=go</remapping><remapping>~/odom:=/odo</remapping></ros>"
    drive = (
        f"<plugin name='d' filename='libgazebo_ros_diff_drive.so'>{ros}{names}<num_wheel_pairs>2</num_wheel_pairs>"
        "<wheel_separation>0.4</wheel_separation><wheel_diameter>0.2</wheel_diameter>"
        "<max_wheel_torque>20</max_wheel_torque><update_rate>50</update_rate></plugin>"
    )
    joints = (
        "<plugin name='j' filename='libgazebo_ros_joint_state_publisher.so'><ros><namespace>r</namespace></ros>"
        "<joint_name>left_rear</joint_name><joint_name>right_rear</joint_name><update_rate>10</update_rate></plugin>"
    )
    base = "<link name='base'><pose>0 0 0.15 0 0 0</pose><inertial><mass>5</mass></inertial></link>"
    core, world = run(GROUND, f"<model name='rover'>{base}{wheels}{drive}{joints}</model>")
    states, odometry = Heard("/r/joint_states"), Heard("/odo")
    kept = command("/r/go", 0.5)
    core.run(2.0)
    rover = world.ModelByName("rover")
    assert rover.WorldPose().Pos().X() == pytest.approx(1.0, abs=0.05)
    for name in ("left_front", "left_rear", "right_rear"):
        assert rover.GetJoint(name).GetVelocity(0) == pytest.approx(5.0, abs=0.05)
    assert [param.name for param in states[-1].param] == ["left_rear", "right_rear"]
    assert len(states) == pytest.approx(20, abs=1)
    assert odometry[-1].pose.position.x == pytest.approx(1.0, abs=0.05)
    del kept


def test_elements_that_have_defaults_may_be_left_out(run, caplog):
    joint = "<joint name='h' type='{}'><parent>world</parent><child>link</child><axis><xyz>0 0 1</xyz></axis></joint>"
    held, tied = joint.format("prismatic"), joint.format("fixed")
    harness = plugin("HarnessPlugin", winch="<joint>h</joint>", detach="h").replace("<winch>", f"{held}<winch>")
    tie = plugin("HarnessPlugin", detach="h").replace("<detach>", f"{tied}<detach>")
    flash = plugin("FlashLightPlugin", light="<id>link/l</id><duration>1</duration>")
    core, world = run(  # as in Gazebo 11.1: a winch without controllers does nothing, one without a joint detaches
        body("a", "0 0 3 0 0 0", inside=harness),
        body("b", "2 0 3 0 0 0", inside=tie),
        body("c", link="<light name='l' type='point'/>", inside=flash, gravity="false"),
    )
    core.run(2.0)
    assert [world.ModelByName(name).WorldPose().Pos().Z() for name in "ab"] == pytest.approx([-16.6, -16.6], abs=0.05)
    assert world.ModelByName("b").GetJoint("h") is None
    assert [record.getMessage() for record in caplog.records if record.levelname == "ERROR"] == []


PROBE = """from libgz.classic import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin


class Probe(ModelPlugin):
    STATE = ()

    def Load(self, model, sdf):
        print(model.GetScopedName(), type(model).__name__, sdf.Get(str, "name"))


GZ_REGISTER_MODEL_PLUGIN(Probe)
"""


def test_plugins_of_actors_and_of_includes_at_any_depth_are_loaded(run, tmp_path, monkeypatch, capsys):
    (tmp_path / "probe.py").write_text(PROBE)
    for name, inside in (
        ("walker", "<actor name='walker'><skin><filename>walk.dae</filename></skin></actor>"),
        ("crate", "<model name='crate'><link name='link'/></model>"),
    ):
        (tmp_path / name).mkdir()
        (tmp_path / name / "model.sdf").write_text(f"<sdf version='1.6'>{inside}</sdf>")
        config = f"<model><name>{name}</name><sdf version='1.6'>model.sdf</sdf></model>"
        (tmp_path / name / "model.config").write_text(config)
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", str(tmp_path))
    monkeypatch.setenv("GAZEBO_MODEL_PATH", str(tmp_path))

    def probe(name):
        return f"<plugin name='{name}' filename='libprobe.so'/>"

    def include(name, plugin):
        return f"<include><uri>model://{name}</uri>{probe(plugin)}</include>"

    actor = f"<actor name='own'><skin><filename>stand.dae</filename></skin>{probe('b')}</actor>"
    core, _ = run(
        include("walker", "a"), actor, f"<model name='m'><link name='l'/>{include('crate', 'c')}{probe('d')}</model>"
    )
    core.step(2)
    assert sorted(capsys.readouterr().out.splitlines()) == [
        "m Model c", "m Model d", "own Actor b", "walker Actor a",
    ]  # fmt: skip
