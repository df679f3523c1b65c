"""What a world's messages say of it: sensors, actors, roads, windows, surfaces, lights; and edits by messages."""

import math
from pathlib import Path

import pytest

import libgz
from libgz.classic import msgs, physics, transport
from libgz.classic.math import Pose3d

WORLD = """
<gui fullscreen='0'><camera name='eye'><pose>1 2 3 0 0.5 0</pose>
  <track_visual><name>box</name></track_visual></camera>
  <plugin name='p' filename='libp.so'><size>3</size></plugin></gui>
<road name='street'><width>7</width><point>0 0 0</point><point>10 5 0</point></road>
<road name='lane'><width>2</width><point>1 0 0</point><point>1 9 0</point></road>
<model name='box'><link name='link'>
  <collision name='c'><geometry><box><size>1 2 3</size></box></geometry><surface><friction><ode><mu>0.4</mu>
    <mu2>0.5</mu2>
    <slip1>0.1</slip1></ode></friction><contact><ode><kp>5e5</kp></ode></contact></surface></collision>
  <light name='lamp' type='spot'><pose>0 0 1 0 0 0</pose><diffuse>1 0 0 1</diffuse>
    <spot><inner_angle>0.2</inner_angle><outer_angle>0.6</outer_angle><falloff>2</falloff></spot></light>
  <battery name='cell'><voltage>12</voltage></battery>
  <sensor name='laser' type='ray'><visualize>1</visualize><ray><scan><horizontal><samples>9</samples>
    <min_angle>-1</min_angle>
    <max_angle>1</max_angle></horizontal></scan><range><min>0.1</min><max>8</max></range></ray></sensor>
  <sensor name='who' type='logical_camera'><logical_camera><near>0.5</near><far>4</far>
    <horizontal_fov>1.2</horizontal_fov>
    <aspect_ratio>1.5</aspect_ratio></logical_camera></sensor>
</link></model>
<model name='arm'><link name='a'/><link name='b'/><joint name='j' type='screw'><parent>a</parent><child>b</child>
  <pose>0 0 0.3 0 0 0</pose><thread_pitch>0.25</thread_pitch><axis><xyz>0 0 1</xyz><dynamics><friction>0.7</friction>
  </dynamics></axis></joint></model>
"""


@pytest.fixture
def core(monkeypatch, tmp_path):
    monkeypatch.setenv("HOME", str(tmp_path))
    with libgz.World.from_string(f"<sdf version='1.6'><world name='described'>{WORLD}</world></sdf>") as world:
        yield world


@pytest.fixture
def node(core):
    node = transport.Node()
    node.Init("described")
    yield node
    node.Fini()


def heard(core, node, topic, steps=2):
    """What a late, latching subscriber receives."""
    received = []
    kept = node.Subscribe(topic, received.append, True)
    core.step(steps)
    kept.Unsubscribe()
    return received


NESTED = """<sdf version='1.6'><model name='outer'><static>1</static><pose>0 5 1 0 0 0</pose><link name='l'/>
  <model name='inner'><link name='l'/></model></model></sdf>"""


def ask(core, node, request, data=""):
    answers = []
    kept = node.Subscribe("~/response", answers.append)
    node.Publish("~/request", msgs.Request(id=1, request=request, data=data))
    core.step(2)
    kept.Unsubscribe()
    return answers[0]


@pytest.fixture
def send(node, core):
    def publish(topic, message):
        node.Publish(topic, message)
        core.step(2)

    return publish


def test_sensors_are_described_to_latching_subscribers_and_in_their_links(core, node):
    laser, who = heard(core, node, "~/sensor")
    assert (laser.name, laser.type, laser.parent) == ("laser", "ray", "box::link")
    assert (laser.topic, laser.visualize) == ("~/box/link/laser/scan", True)
    assert (laser.ray.horizontal_samples, laser.ray.range_max) == (9, 8.0)
    assert laser.ray.horizontal_min_angle == pytest.approx(-1.0)
    seen = who.logical_camera
    assert (seen.near_clip, seen.far_clip, seen.horizontal_fov, seen.aspect_ratio) == (0.5, 4.0, 1.2, 1.5)
    link = msgs.Model.FromString(ask(core, node, "entity_info", "box").serialized_data).link[0]
    assert [sensor.topic for sensor in link.sensor] == [laser.topic, who.topic]
    assert link.id == laser.parent_id
    numbers = [link.id, *(part.id for part in (*link.collision, *link.sensor))]
    assert len({*numbers}) == len(numbers)


def test_roads_and_the_window_are_kept_for_late_subscribers(core, node):
    roads = heard(core, node, "~/roads")
    assert [(road.name, road.width, len(road.point)) for road in roads] == [("street", 7.0, 2), ("lane", 2.0, 2)]
    assert roads[0].point[1].x == 10.0
    (gui,) = heard(core, node, "~/gui")
    assert (gui.camera.name, gui.camera.pose.position.z, gui.camera.track.name) == ("eye", 3.0, "box")
    assert (gui.plugin[0].filename, "<size>3</size>" in gui.plugin[0].innerxml) == ("libp.so", True)


def test_links_collisions_and_joints_are_described_whole(core, node):
    link = msgs.Model.FromString(ask(core, node, "entity_info", "box").serialized_data).link[0]
    assert (link.canonical, link.battery[0].name, link.battery[0].voltage) == (True, "cell", 12.0)
    lamp = link.light[0]
    assert (lamp.name, lamp.type, lamp.pose.position.z) == ("box::link::lamp", msgs.Light.SPOT, 1.0)
    assert (lamp.spot_inner_angle, lamp.spot_falloff) == (pytest.approx(0.2), 2.0)
    surface = link.collision[0].surface
    assert (surface.friction.mu, surface.friction.mu2, surface.friction.slip1) == (0.4, 0.5, 0.1)
    assert surface.kp == 5e5
    # What contacts do not use is described, too, with the defaults of SDF.
    assert (surface.soft_cfm, surface.soft_erp, surface.HasField("elastic_modulus")) == (0.0, 0.2, True)
    assert surface.friction.torsional.ode.HasField("slip")
    own, shown = link.collision[0].visual
    assert (own.name, own.id) == (link.collision[0].name, link.collision[0].id)
    assert (shown.type, shown.geometry.box.size.z, shown.parent_id) == (msgs.Visual.COLLISION, 3.0, link.id)
    joint = msgs.Model.FromString(ask(core, node, "entity_info", "arm").serialized_data).joint[0]
    assert (joint.screw.thread_pitch, joint.pose.position.z) == (0.25, pytest.approx(0.3))
    assert joint.axis1.friction == 0.7


def test_the_answer_on_physics_has_all_parameters(core, node):
    answer = msgs.Physics.FromString(ask(core, node, "physics_info").serialized_data)
    assert (answer.type, answer.min_step_size, answer.contact_surface_layer) == (msgs.Physics.ODE, 0.0001, 0.001)


def test_a_model_is_modified_in_depth(core, send):
    view = physics.get_world("described")
    message = msgs.Model(name="box", self_collide=True)
    link = message.link.add(name="box::link")
    link.inertial.mass, link.inertial.ixx = 3.0, 2.0
    collision = link.collision.add(name="box::link::c", laser_retro=0.5)
    collision.surface.friction.mu, collision.surface.restitution_coefficient = -1.0, 0.9
    collision.surface.collide_bitmask = 6
    send("~/model/modify", message)
    box = view.ModelByName("box")
    inertial, part = box.GetLink("link").GetInertial(), box.GetLink("link").GetCollision("c")
    assert (inertial.Mass(), inertial.IXX(), inertial.IYY()) == (3.0, 2.0, 1.0)
    assert part.GetSurface().FrictionPyramid().MuPrimary() == math.inf
    assert part.GetSurface().FrictionPyramid().MuSecondary() == 0.5
    assert (part.GetSurface().bounce, part.GetSurface().collideBitmask, part.GetLaserRetro()) == (0.9, 6, 0.5)
    assert box.GetSelfCollide()


def test_a_message_with_the_number_of_another_model_is_refused(core, send, caplog):
    view = physics.get_world("described")
    number = view.ModelByName("arm").GetId()
    send("~/model/modify", msgs.Model(name="box", id=number, pose=msgs.Convert(Pose3d(5, 0, 0, 0, 0, 0))))
    assert f"not {number}" in caplog.text
    assert view.ModelByName("box").WorldPose().X() == 0.0


def edit(inside):
    return f"<sdf version='1.6'>{inside}</sdf>"


def test_the_factory_edits_an_entity_in_its_place(core, send):
    view = physics.get_world("described")
    view.ModelByName("box").SetWorldPose(Pose3d(4, 0, 9, 0, 0, 0))
    ball = (
        "<model name='any'><link name='l'><gravity>0</gravity><collision name='s'><geometry><sphere><radius>2</radius>"
    )
    send(
        "~/factory",
        msgs.Factory(edit_name="box", sdf=edit(ball + "</sphere></geometry></collision></link></model>")),
    )
    box = view.ModelByName("box")
    assert box.GetLink("l").GetCollision("s").GetShape().GetRadius() == 2.0
    assert box.WorldPose().X() == pytest.approx(4.0)
    assert view.ModelCount() == 2


def test_an_edit_that_fails_keeps_the_entity(core, send, caplog):
    view = physics.get_world("described")
    for inside in ("<light name='l' type='point'/>", "<model name='x'><link/></model>"):  # the link has no name
        send("~/factory", msgs.Factory(edit_name="box", sdf=edit(inside)))
        assert view.ModelByName("box").GetLink("link") is not None
    assert "cannot replace 'box'" in caplog.text


def test_what_a_server_cannot_do_is_reported(core, send, caplog):
    send("/gazebo/server/control", msgs.ServerControl(open_filename="other.world"))
    assert "neither opens, makes nor clones worlds" in caplog.text


def test_a_heightmap_is_sent_as_numbers(tmp_path):
    from PIL import Image

    path = tmp_path / "hill.png"
    image = Image.new("L", (3, 3))
    image.putpixel((2, 0), 255)  # at +x, +y
    image.save(path)
    text = f"""<model name='m'><static>1</static><link name='l'><collision name='c'><geometry><heightmap><uri>file://{path}</uri>
        <size>4 4 2</size></heightmap></geometry></collision></link></model>"""
    with libgz.World.from_string(f"<sdf version='1.6'><world name='described'>{text}</world></sdf>") as world:
        world.attach_era()
        node = transport.Node()
        node.Init("described")
        answer = ask(world, node, "heightmap_data")
        assert answer.type == "gazebo.msgs.Geometry"
        found = msgs.Geometry.FromString(answer.serialized_data).heightmap
        assert (found.width, found.height) == (5, 5)
        assert list(found.heights)[24] == pytest.approx(2.0)
        assert sum(found.heights) == pytest.approx(4.5)  # half and a quarter of it around
        assert found.size.x == 4.0


def test_clients_are_sent_all_that_shows_a_visual():
    text = """<scene><sky><clouds><speed>3</speed><humidity>0.2</humidity></clouds></sky></scene>
      <model name='m'><link name='l'>
      <visual name='v'><geometry><heightmap><uri>file://h.png</uri><size>4 4 2</size><texture><diffuse>d.png</diffuse>
        <normal>n.png</normal><size>3</size></texture><blend><min_height>1</min_height><fade_dist>2</fade_dist></blend>
        </heightmap></geometry>
        <material><shader type='normal_map_tangent_space'><normal_map>n.png</normal_map></shader></material>
        <meta><layer>2</layer></meta><plugin name='p' filename='libp.so'><period>2</period></plugin></visual>
      </link></model>"""
    with libgz.World.from_string(f"<sdf version='1.6'><world name='described'>{text}</world></sdf>") as world:
        world.attach_era()
        node = transport.Node()
        node.Init("described")
        scene = msgs.Scene.FromString(ask(world, node, "scene_info").serialized_data)
        visual = next(one for one in scene.model[0].link[0].visual if one.name == "m::l::v")
        [texture], [blend] = visual.geometry.heightmap.texture, visual.geometry.heightmap.blend
        assert (texture.diffuse, texture.normal, texture.size) == ("d.png", "n.png", 3.0)
        assert (blend.min_height, blend.fade_dist) == (1.0, 2.0)
        assert (visual.material.shader_type, visual.material.normal_map, visual.meta.layer) == (4, "n.png", 2)
        assert visual.plugin[0].innerxml.strip() == "<period>2</period>"
        assert (scene.sky.wind_speed, scene.sky.humidity) == (3.0, 0.2)


def test_an_actor_publishes_its_bones(tmp_path):
    path = Path(__file__).parents[3] / "examples" / "plugins" / "ready" / "actor.world"
    text = path.read_text().replace("ActorPlugin", "unused").split("<plugin")[0] + "</actor></world></sdf>"
    script = "<script><trajectory id='0' type='walking'><waypoint><time>0</time><pose>0 1 0.95 0 0 0</pose></waypoint>"
    script += "<waypoint><time>2</time><pose>2 1 0.95 0 0 0</pose></waypoint></trajectory></script></actor>"
    with libgz.World.from_string(text.replace("</actor>", script)) as world:
        world.attach_era()
        node, received = transport.Node(), []
        node.Init("default")
        kept = node.Subscribe("~/skeleton_pose/info", received.append)
        world.step(100)
        actor = physics.get_world("default").ModelByName("walker")
        assert 2 <= len(received) <= 5
        last = received[-1]
        poses = {pose.name: pose for pose in last.pose}
        links = [link for link in actor.GetLinks() if link.GetScopedName() in poses]
        assert len(links) > 5
        assert len(last.pose) == 2 * len(links) + 1
        assert poses["walker"].id == last.model_id == actor.GetId()
        assert poses["walker"].position.x == pytest.approx(actor.WorldPose().X(), abs=0.05)
        name = links[-1].GetScopedName()
        assert poses[name].id == links[-1].GetId()
        assert poses[name].position.z == pytest.approx(links[-1].RelativePose().Z(), abs=0.02)
        kept.Unsubscribe()


def test_a_nested_model_is_placed_globally_by_its_name_and_relative_within_its_parent(core, node, send):
    view = physics.get_world("described")
    view.InsertModelString(NESTED)
    core.step(1)
    inner = view.ModelByName("outer::inner")
    message = msgs.Model(name="outer::inner")
    msgs.Set(message.pose, Pose3d(4, 0, 1, 0, 0, 0))
    message.pose.orientation.w = 0.0  # four zeros are no rotation, as in Gazebo
    send("~/model/modify", message)
    assert inner.WorldPose().Equal(Pose3d(4, 0, 1, 0, 0, 0), 1e-9)
    message = msgs.Model(name="outer")
    msgs.Set(message.model.add(name="outer::inner").pose, Pose3d(2, 0, 0, 0, 0, 0))
    send("~/model/modify", message)
    assert inner.WorldPose().Equal(Pose3d(2, 5, 1, 0, 0, 0), 1e-9)
    seen = msgs.Model.FromString(ask(core, node, "entity_info", "outer").serialized_data)
    assert [link.inertial.mass for link in (seen.link[0], seen.model[0].link[0])] == [0.0, 0.0]
    assert seen.link[0].enabled
    view.RemoveModel("outer")
