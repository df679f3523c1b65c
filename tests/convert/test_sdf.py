"""libgz convert: the SDF agrees with the engine."""

import math
from pathlib import Path

import numpy as np
import pytest
from commands import run_libgz
from lxml import etree

import libgz
from libgz import (
    BallJoint,
    Body,
    BoxGeom,
    CapsuleGeom,
    GzPose,
    GzQuaternFromAxis,
    GzVector,
    Hinge2Joint,
    HingeJoint,
    Model,
    SliderJoint,
    TriMeshGeom,
    UniversalJoint,
)
from libgz.base.errors import ParameterError
from libgz.base.files import installed_worlds
from libgz.base.geometry import GzHomoFromQuatern, GzQuaternNormal
from libgz.convert.element import name_of, number, pose
from libgz.convert.joints import ends_of
from libgz.convert.sdf import convert
from libgz.convert.shapes import is_shape
from libgz.legacy.factory import GZ_REGISTER_STATIC
from libgz.models import MODELS
from libgz.physics.geoms import HeightfieldGeom, PlaneGeom
from libgz.reference.catalogue import entry

ROOT = Path(__file__).parents[2]
WORLDS = sorted(installed_worlds().glob("*.world"))


def loaded(text):
    world = libgz.World()
    file = libgz.WorldFile()
    file.LoadString(text)
    world.Load(file)
    return world


def body_world(body):
    return (
        '<gz:world xmlns:gz="g" xmlns:model="m" xmlns:param="p"><model:GroundPlane><id>ground</id></model:GroundPlane>'
        f"{body}</gz:world>"
    )


def matrix_of(values):
    """4 x 4 matrix of SDF's x y z roll pitch yaw."""
    x, y, z, roll, pitch, yaw = values
    (ca, sa), (cb, sb), (cc, sc) = ((math.cos(a), math.sin(a)) for a in (roll, pitch, yaw))
    rx = np.array([[1, 0, 0], [0, ca, -sa], [0, sa, ca]])
    ry = np.array([[cb, 0, sb], [0, 1, 0], [-sb, 0, cb]])
    rz = np.array([[cc, -sc, 0], [sc, cc, 0], [0, 0, 1]])
    result = np.eye(4)
    result[:3, :3], result[:3, 3] = rz @ ry @ rx, (x, y, z)
    return result


def matrix_of_engine(place):
    result = np.eye(4)
    result[:3, :3] = np.array(GzHomoFromQuatern(GzQuaternNormal(place.rot)).m)[:3, :3]
    result[:3, 3] = list(place.pos)
    return result


def floats(element, path):
    return [float(word) for word in element.findtext(path).split()]


def place_of(element):
    return matrix_of(floats(element, "pose"))


def links_of(world, root):
    """(body, model element, link element) of all links, by the order in which they were made."""
    elements = iter(root.find("world").iterfind("model"))
    for top in (model for model in world.models if model.parent is None):
        members, queue = [], [top]
        while queue:
            members.append(queue.pop(0))
            queue[:0] = members[-1].children
        bodies = [b for m in members for b in m.bodies if not b.dummy or any(is_shape(g) for g in b.geoms)]
        if not bodies:
            continue
        bodies.sort(key=lambda body: body is not top.GetBody())
        element = next(elements)
        for body, link in zip(bodies, element.iterfind("link"), strict=True):
            yield body, element, link
    assert next(elements, None) is None


def check_links(world, root):
    count = 0
    for body, model, link in links_of(world, root):
        count += 1
        np.testing.assert_allclose(place_of(model) @ place_of(link), matrix_of_engine(body.GetPose()), atol=1e-9)
        if not body.dummy:
            check_inertia(body, place_of(model) @ place_of(link), link.find("inertial"))
        geoms = [geom for geom in body.geoms if is_shape(geom)]
        collisions = [c for c in link.iterfind("collision") if "_end" not in c.get("name")]
        assert len(geoms) == len(collisions)
        for geom, collision in zip(geoms, collisions, strict=True):
            if not isinstance(geom, PlaneGeom):
                place = place_of(model) @ place_of(link) @ place_of(collision)
                np.testing.assert_allclose(place, matrix_of_engine(geom.GetPose()), atol=1e-9)
    return count


def check_inertia(body, place, inertial):
    mass = body.GetMass()
    assert float(inertial.findtext("mass")) == pytest.approx(mass.mass, rel=1e-12)
    values = [float(inertial.findtext(f"inertia/{tag}")) for tag in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")]
    xx, xy, xz, yy, yz, zz = values
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    np.testing.assert_allclose(tensor, np.array(mass.I).reshape(3, 4)[:, :3], rtol=1e-12, atol=1e-15)
    moments = np.linalg.eigvalsh(tensor)
    assert (moments > 0.0).all()
    assert moments[2] <= moments[0] + moments[1] + 1e-12  # the triangle inequality of real bodies
    np.testing.assert_allclose((place @ place_of(inertial))[:3, 3], list(body.GetCoMPose().pos), atol=1e-9)


def check_names(root):
    for scope in [root.find("world"), *root.iter("model"), *root.iter("link")]:
        names = [child.get("name") for child in scope if child.get("name") and child.tag != "physics"]
        assert len(names) == len(set(names)), names


def sdf_of(world, **options):
    converted = convert(world, **options)
    root = etree.fromstring(converted.sdf)
    assert (root.tag, root.get("version")) == ("sdf", "1.6")
    assert not [element.tag for element in root.iter() if element.text and {"nan", "inf"} & set(element.text.split())]
    check_names(root)
    return converted, root


@pytest.mark.parametrize("path", WORLDS, ids=lambda path: path.stem)
def test_links_are_the_engines_bodies(path):
    world = libgz.World()
    world.Load(libgz.WorldFile.from_file(path))
    _, root = sdf_of(world)
    assert check_links(world, root) >= 2
    world.close()


@pytest.mark.parametrize("name", sorted(MODELS))
def test_all_models_can_be_converted(name):
    with loaded(entry(name).example) as world:
        _, root = sdf_of(world)
        assert check_links(world, root) >= 1


class Machine(Model):
    """One joint of each kind, on bodies that are turned."""

    def Load(self, file, node):
        self.base = self.part("base", (0, 0, 1), True)
        self.made = {}
        for i, (name, kind) in enumerate(
            {
                "hinge": HingeJoint, "slider": SliderJoint, "ball": BallJoint, "universal": UniversalJoint,
                "wheel": Hinge2Joint, "post": HingeJoint, "lid": SliderJoint,
            }.items()
        ):  # fmt: skip
            part = self.part(name, (0.5 * (i + 1), 0.3, 1.2))
            part.SetRotation(GzQuaternFromAxis(0.6, 0.0, 0.8, 0.7 * i))
            joint = kind(self.world, name=name)
            if name == "post":
                joint.Attach(None, part)
            elif kind is Hinge2Joint:
                joint.Attach(self.base, part)
            else:
                joint.Attach(part, self.base)
            joint.SetAnchor((0.5 * i, 0.1, 1.1))
            if kind is HingeJoint:
                joint.SetAxis((0.0, 0.6, 0.8))
            elif kind is SliderJoint:
                joint.SetAxis(0.0, 0.6, 0.8)
            elif kind is not BallJoint:
                joint.SetAxis1((0.0, 0.0, 1.0))
                joint.SetAxis2((0.0, 1.0, 0.0))
            self.made[name] = (joint, part)
        self.made["lid"][0].SetParam(libgz.dParamLoStop, 0.0)
        self.made["lid"][0].SetParam(libgz.dParamHiStop, 0.0)
        self.made["hinge"][0].SetParam(libgz.dParamLoStop, -0.5)
        self.made["hinge"][0].SetParam(libgz.dParamHiStop, 0.75)

    def part(self, name, place, canonical=False):
        body = Body(self.world, name)
        self.AddBody(body, canonical)
        box = BoxGeom(body, self.modelSpaceId, 0.1, 0.2, 0.3)
        box.SetRelativePose(GzPose(GzVector(0.05, 0.0, 0.02), GzQuaternFromAxis(0.0, 1.0, 0.0, math.pi / 2.0)))
        box.SetMass(2.0)
        body.SetPosition(place)
        return body


class Shapes(Model):
    """Shapes that SDF has no word for."""

    def Load(self, file, node):
        self.fixed = True
        body = Body(self.world, dummy=True)
        self.AddBody(body, True)
        corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
        TriMeshGeom(body, self.modelSpaceId, corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])
        HeightfieldGeom(body, self.modelSpaceId, [[0.0, 0.1, 0.2], [0.3, 0.4, 0.5]], 4.0, 2.0)
        CapsuleGeom(body, self.modelSpaceId, 0.2, 1.0)


GZ_REGISTER_STATIC("ConvertedMachine", Machine)
GZ_REGISTER_STATIC("ConvertedShapes", Shapes)


@pytest.fixture
def machine():
    with loaded(
        body_world("<model:ConvertedMachine><xyz>3 2 1</xyz><rpy>10 20 30</rpy></model:ConvertedMachine>")
    ) as w:
        yield w, next(model for model in w.models if isinstance(model, Machine))


def test_joints_have_the_poses_of_the_engine(machine):
    world, model = machine
    converted, root = sdf_of(world)
    assert check_links(world, root) == 9
    element = root.find("world/model[@name='ConvertedMachine']")
    places = {link.get("name"): place_of(element) @ place_of(link) for link in element.iterfind("link")}
    kinds = {"hinge": "revolute", "slider": "prismatic", "ball": "ball", "universal": "universal",
             "wheel": "universal", "post": "revolute", "lid": "fixed"}  # fmt: skip
    for name, (joint, part) in model.made.items():
        found = next(j for j in element.iterfind("joint") if j.findtext("child").startswith(name))
        assert found.get("type") == kinds[name]
        assert found.findtext("parent") == ("world" if name == "post" else "canonical")
        place = places[found.findtext("child")]
        if name not in ("slider", "lid"):
            np.testing.assert_allclose((place @ place_of(found))[:3, 3], list(joint.GetAnchor()), atol=1e-9)
        assert ends_of(joint)[0] is part
        for axis in (axis for axis in (found.find("axis"), found.find("axis2")) if axis is not None):
            direction = place[:3, :3] @ floats(axis, "xyz")
            assert np.linalg.norm(direction) == pytest.approx(1.0)
            assert_child_moves_along(name, joint, part, direction)
    limit = element.find("joint[@type='revolute']/axis/limit")
    assert (float(limit.findtext("lower")), float(limit.findtext("upper"))) == pytest.approx((-0.5, 0.75))
    assert any("joint wheel" in note or "suspension" in note for note in converted.notes)


def assert_child_moves_along(name, joint, part, direction):
    """A child that moves by +1 along SDF's axis has a rate of +1 in the engine."""
    part.SetLinearVel((0, 0, 0))
    part.SetAngularVel((0, 0, 0))
    if name == "slider":
        part.SetLinearVel(direction)
        rates = [joint.GetPositionRate()]
    else:
        part.SetAngularVel(direction)
        rates = [joint.GetAngleRate()] if isinstance(joint, HingeJoint) else []
        if isinstance(joint, Hinge2Joint):
            rates = [joint.GetAngle1Rate(), joint.GetAngle2Rate()]
        if isinstance(joint, UniversalJoint):
            rates = [joint.GetAngleRate1(), joint.GetAngleRate2()]
    assert max(rates) == pytest.approx(1.0, abs=1e-9), (name, rates)


def test_attached_models_are_links_with_fixed_joints():
    robot = (
        "<model:Pioneer2AT><id>robot</id><xyz>1 2 0</xyz><rpy>0 0 40</rpy><model:SickLMS200><id>laser</id>"
        "<xyz>.1 0 .31</xyz><model:SonyVID30><id>eye</id><xyz>0 0 .2</xyz></model:SonyVID30></model:SickLMS200>"
        "</model:Pioneer2AT>"
    )
    with loaded(body_world(robot)) as world:
        _, root = sdf_of(world)
        assert check_links(world, root) == 1 + 5 + 1 + 3
        model = root.find("world/model[@name='robot']")
        held = {(j.findtext("parent"), j.findtext("child")) for j in model.iterfind("joint[@type='fixed']")}
        assert held == {("canonical", "laser_canonical"), ("laser_canonical", "eye_canonical")}
        names = [joint.get("name") for joint in model.iterfind("joint")]
        assert names[:2] == ["left_front_joint", "right_front_joint"]
        assert {"laser_canonical_weld", "eye_pan_joint"} <= set(names)
        children = [joint.findtext("child") for joint in model.iterfind("joint")]
        assert len(children) == len(set(children)) == 8  # a tree
        assert model.find("static") is None
        assert root.find("world/model[@name='ground']/static").text == "true"


def test_sensors():
    robot = (
        "<model:Pioneer2DX><id>robot</id><model:SickLMS200><id>laser</id><rangeCount>361</rangeCount>"
        "<minAngle>-45</minAngle><scanRate>5</scanRate></model:SickLMS200>"
        "<model:MonoCam><id>eye</id><hfov>50</hfov><imageSize>64 48</imageSize></model:MonoCam></model:Pioneer2DX>"
    )
    with loaded(body_world(robot)) as world:
        converted, root = sdf_of(world)
        laser = root.find(".//sensor[@name='laser']")
        assert laser.get("type") == "ray"
        assert laser.findtext("update_rate") == "5"
        scan = laser.find("ray/scan/horizontal")
        assert scan.findtext("samples") == "361"
        assert float(scan.findtext("min_angle")) == pytest.approx(math.radians(-45))
        assert floats(laser, "pose")[2] == pytest.approx(0.07)
        sonars = [s for s in root.iter("sensor") if "_sonar" in s.get("name")]
        assert len(sonars) == 16
        assert floats(sonars[0], "pose")[5] == pytest.approx(math.pi / 2)
        camera = root.find(".//sensor[@name='eye']/camera")
        assert float(camera.findtext("horizontal_fov")) == pytest.approx(math.radians(50))
        assert (camera.findtext("image/width"), camera.findtext("image/height")) == ("64", "48")
        notes = "\n".join(converted.notes)
        assert "<model:Pioneer2DX> 'robot': interfaces without a counterpart: position, power" in notes
        assert "<model:SickLMS200> 'laser': interfaces without a counterpart: fiducial" in notes
        _, root = sdf_of(world, rays="gpu_ray")
        assert root.find(".//sensor[@name='laser']").get("type") == "gpu_ray"
        with pytest.raises(ParameterError, match="must be ray or gpu_ray"):
            convert(world, rays="laser")


@pytest.mark.parametrize("name", ["pioneer2at", "gripper", "simplesolids", "terrain"])
def test_models_rest_in_the_converted_world_too(tmp_path, name):
    """Soft wheels above all: by SDF's own defaults contacts push out at 1 cm/s, and robots sink."""
    with libgz.World.from_file(installed_worlds() / f"{name}.world") as world:
        converted = convert(world, meshes="m")
        for file, data in converted.meshes.items():
            (tmp_path / file).parent.mkdir(exist_ok=True)
            (tmp_path / file).write_bytes(data)
        path = tmp_path / "a.sdf"
        path.write_bytes(converted.sdf)
        with libgz.World.from_file(path) as other:
            world.run(1.0)
            other.run(1.0)
            before = {model.GetId(): model.GetBody().GetCoMPose().pos for model in world.models if model.parent is None}
            after = {model.GetId(): model.GetBody().GetCoMPose().pos for model in other.models}
            both = before.keys() & after.keys()
            assert len(both) >= 3
            for name in both:
                assert tuple(after[name]) == pytest.approx(tuple(before[name]), abs=0.02), name


def test_bounce_needs_two_in_sdf():
    with loaded(body_world("<model:SimpleSolid><id>ball</id><shape>sphere</shape></model:SimpleSolid>")) as world:
        world.model("ball").GetBody().geoms[0].SetBounce(0.7)
        converted, root = sdf_of(world)
        bounce = root.find("world/model[@name='ball']/link/collision/surface/bounce")
        assert [float(bounce.findtext(tag)) for tag in ("restitution_coefficient", "threshold")] == [0.7, 0.0]
        assert any("'ball': bounces only off surfaces that bounce, too" in note for note in converted.notes)


def test_surfaces_materials_lights_and_notes_on_losses(tmp_path):
    (tmp_path / "a.png").write_bytes(b"")
    body = (
        "<param:Global><stepTime>0.01</stepTime><gravity>0 0 -3.7</gravity><skyColor>0.1 0.2 0.3</skyColor>"
        "</param:Global>"
        "<model:LightSource><id>sun</id><xyz>1 2 3</xyz><attenuation>1 0.5 0.25</attenuation></model:LightSource>"
        "<model:ObserverCam><xyz>0 0 5</xyz><rpy>0 90 0</rpy></model:ObserverCam>"
        "<model:ObserverCam><id>two</id></model:ObserverCam>"
        "<model:SimpleSolid><id>box</id><color>1 0 0 0.25</color><transparent>1</transparent><retro>1</retro>"
        f"<fiducial>7</fiducial><textureFile>{tmp_path / 'a.png'}</textureFile>"
        "<surfaceFriction>0.3 0.3</surfaceFriction>"
        "<surfaceHardness>1e5 20</surfaceHardness></model:SimpleSolid>"
        "<model:SimpleSolid><id>box</id><gravity>false</gravity></model:SimpleSolid><model:Robby/>"
    )
    with loaded(body_world(body)) as world:
        converted, root = sdf_of(world)
        found = root.find("world")
        assert found.findtext("gravity") == "0 0 -3.7"
        assert found.findtext("physics/max_step_size") == "0.01"
        assert found.findtext("scene/background") == "0.1 0.2 0.3 1"
        assert found.findtext("scene/ambient") == "0.2 0.2 0.2 1"
        light = found.find("light[@name='sun']")
        assert floats(light, "pose") == [1, 2, 3, 0, 0, 0]
        assert [light.findtext(f"attenuation/{t}") for t in ("constant", "linear", "quadratic")] == ["1", "0.5", "0.25"]
        assert floats(found.find("gui/camera"), "pose") == pytest.approx([0, 0, 5, 0, math.pi / 2, 0])
        box = found.find("model[@name='box']/link")
        assert box.findtext("collision/surface/friction/ode/mu") == "0.3"
        assert box.findtext("collision/surface/contact/ode/kp") == "100000"
        assert box.findtext("collision/surface/contact/ode/kd") == "20"
        assert float(box.findtext("collision/surface/contact/ode/max_vel")) == 100.0
        assert box.findtext("collision/laser_retro") == "1"
        assert box.findtext("visual/transparency") == "0.75"
        assert box.findtext("visual/material/diffuse") == "1 0 0 1"
        assert found.find("model[@name='box_2']/link").findtext("gravity") == "false"
        notes = "\n".join(converted.notes)
        lost = (
            "texture a.png",
            "fiducial 7",
            "'two': is omitted",
            "view of the simulator's own window",
            "<model:Robby>: unknown",
        )
        for note in lost:
            assert note in notes


def test_meshes_are_written_beside():
    with loaded(body_world("<model:ConvertedShapes><id>s</id></model:ConvertedShapes>")) as world:
        converted, root = sdf_of(world, meshes="m")
        uris = [uri.text for uri in root.iter("uri")]
        assert sorted(set(uris)) == sorted(converted.meshes) == ["m/s_canonical_0.stl", "m/s_canonical_1.stl"]
        assert [int.from_bytes(converted.meshes[name][80:84], "little") for name in sorted(converted.meshes)] == [4, 4]
        field = np.frombuffer(
            converted.meshes["m/s_canonical_1.stl"][84:], dtype=[("n", "<f4", 3), ("c", "<f4", (3, 3)), ("u", "<u2")]
        )
        assert (field["n"][:, 2] > 0.0).all()  # the ground looks up
        assert field["c"].reshape(-1, 3).min(axis=0) == pytest.approx([-2, -1, 0])
        assert field["c"].reshape(-1, 3).max(axis=0) == pytest.approx([2, 1, 0.5])
        assert [c.get("name") for c in root.iter("collision")][-2:] == [
            "s_canonical_2_end1_collision",
            "s_canonical_2_end2_collision",
        ]


def test_a_plane_has_its_place_of_the_engine():
    with loaded('<gz:world xmlns:gz="g" xmlns:model="m"><model:GroundPlane><height>2</height><normal>0 3 4</normal>'
                "</model:GroundPlane></gz:world>") as world:  # fmt: skip
        _, root = sdf_of(world)
        collision = root.find(".//collision")
        assert floats(collision, "geometry/plane/normal") == pytest.approx([0, 0.6, 0.8])
        assert floats(collision, "pose")[:3] == pytest.approx([0, 1.2, 1.6])


def test_numbers_names_and_straight_poses():
    assert number(-0.0) == "0"
    assert number(1e-9) == "1e-09"
    taken = set()
    assert [name_of(n, taken) for n in ("a", "a", "x::y", "world", "__z__", " ")] == [
        "a", "a_2", "x_y", "world_", "z", "unnamed",
    ]  # fmt: skip
    for pitch in (math.pi / 2, -math.pi / 2):
        turned = GzPose(GzVector(), GzQuaternFromAxis(0.0, 1.0, 0.0, pitch))
        np.testing.assert_allclose(matrix_of(pose(turned)), matrix_of_engine(turned), atol=1e-9)


def test_the_command(tmp_path):
    world = installed_worlds() / "pioneer2at.world"
    target, report = tmp_path / "new.sdf", tmp_path / "report.txt"
    done = run_libgz("convert", world, "-o", target, "--report", report)
    assert done.returncode == 0, done.stderr
    assert etree.parse(target).getroot().get("version") == "1.6"
    lines = report.read_text().splitlines()
    assert lines
    assert done.stderr.splitlines() == lines
    assert all(line.startswith(f"{world}:") for line in lines)
    assert run_libgz("convert", world).returncode == 2
    assert "cannot write" in run_libgz("convert", world, "-o", tmp_path / "no" / "new.sdf").stderr
    broken = tmp_path / "broken.world"
    broken.write_text(body_world("<model:SimpleSolid><shape>blob</shape></model:SimpleSolid>"))
    wrong = run_libgz("convert", broken, "-o", target)
    assert wrong.returncode == 1
    assert "'blob' is not allowed" in wrong.stderr


@pytest.mark.parametrize(
    ("model", "lost"),
    [
        ("SegwayRMP", "its behaviour is lost: balancing (it falls over)"),
        ("Blimp", "its behaviour is lost: thrust, drag, and the torque that keeps it upright"),
        ("Pioneer2DX", "its behaviour is lost: motors that drive and hold its wheels"),
        ("Bandit", "motors of joints are lost, which turn freely: HEAD, L_SHOULDER"),
        ("SonyVID30", "motors of joints are lost, which turn freely: pan, tilt"),
        ("Factory", "its behaviour is lost: adding and removing models on request"),
        (
            "SimpleSolid><enable>false</enable><id>robot</id></model:SimpleSolid><model:LightSource",
            "moves from the start",
        ),
    ],
)
def test_behaviour_that_is_lost_is_named(model, lost):
    with loaded(body_world(f"<model:{model}><id>robot</id></model:{model.split(':')[-1]}>")) as world:
        assert any(f"'robot': {lost}" in note for note in sdf_of(world)[0].notes)


def test_every_model_that_acts_by_itself_has_a_word_for_it():
    """Those without an Update beyond sensors and interfaces have none."""
    without = {name for name in MODELS if not entry(name).kind.behaviour}
    assert without == {
        *("AvatarHeli", "GarminGPS", "GroundPlane", "LightSource", "MapExtruder", "MonoCam", "ObserverCam"),
        *("Pioneer2Sonars", "Road", "SickLMS200", "SimpleSolid", "SkyDome", "StereoHead", "Terrain", "WiFi"),
    }


def test_what_code_of_users_does_is_named():
    class Pusher(Model):
        def Load(self, file, node):
            self.AddBody(Body(self.world), True)
            self.GetBody().set_damping(0.1, 0.1)

        def Update(self, step):
            self.GetBody().AddForce(1, 0, 0)

    GZ_REGISTER_STATIC("Pusher", Pusher)
    with loaded(body_world("<model:Pusher><id>p</id></model:Pusher>")) as world:
        notes = "\n".join(sdf_of(world)[0].notes)
    assert "'p': what Pusher.Update does is lost" in notes
    assert "'p': the damping of its bodies is lost" in notes
