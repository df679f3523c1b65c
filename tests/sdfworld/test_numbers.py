"""Figures that Gazebo classic's own tests asked for: free fall, contacts, friction, forces, masks."""

import math

import numpy as np
import pytest
from sdf_worlds import GROUND, Loader, collision, friction, inertial, link, model, world

from libgz.base.geometry import GzPose, GzVector, rotate


@pytest.fixture
def load(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.delenv("GAZEBO_MODEL_PATH", raising=False)
    loader = Loader(tmp_path)
    yield loader
    loader.close()


def test_row_2_spawn_drop(load):
    things = [model(s, link("link", collision(s)), pose=f"{3 * i} 0 3 0 0 0") for i, s in enumerate(("box", "sphere"))]
    things.append(model("cylinder", link("link", collision("cylinder")), pose="6 0 3 0 0 0"))
    things.append(model("ghost", link("link"), pose="9 0 3 0 0 0"))
    made = load(world(GROUND, *things))
    made.step()
    for name in ("box", "sphere", "cylinder", "ghost"):
        x, y, z = made.body(name).GetLinearVel()
        assert (x, y) == (0.0, 0.0)
        assert z == pytest.approx(-9.8 * 0.001, rel=0.01)
        assert made.body(name).GetPosition().z == pytest.approx(3.0, abs=0.01)
    hit = math.sqrt(2 * 2.5 / 9.8)
    made.run(hit + 0.5)
    t = made.GetSimTime()
    for name in ("box", "sphere", "cylinder"):
        assert abs(made.body(name).GetLinearVel().z) < 0.01
        assert made.body(name).GetPosition().z == pytest.approx(0.5, abs=0.01)
    assert made.body("ghost").GetPosition().z == pytest.approx(3.0 - 9.8 * t * t / 2, rel=0.01)


REST = {"box": (0.0101, 1e-5), "sphere": (3e-5, 1e-5), "cylinder": (0.011, 1e-4)}


@pytest.mark.parametrize("shape", list(REST))
def test_row_3_drop_stuff(load, shape):
    made = load(world(GROUND, model("thing", link("link", collision(shape)), pose="0 0 10.5 0 0 0"), gravity="0 0 -10"))
    body, z, v = made.body("thing"), 10.5, 0.0
    while z > 0.52:
        made.step()
        v -= 10 * 0.001
        z += v * 0.001
        assert body.GetPosition().z == pytest.approx(z, abs=1e-4)
        assert body.GetLinearVel().z == pytest.approx(v, abs=1e-4)
    made.run(1.0)
    speed, height = REST[shape]
    assert abs(body.GetLinearVel().z) < speed
    assert body.GetPosition().z == pytest.approx(0.5, abs=height)


def test_row_4_inelastic_collision(load):
    made = load(
        world(
            model("box", link("link", collision("box"))),
            model("sphere", link("link", collision("sphere")), pose="2 0 0 0 0 0"),
            gravity="0 0 0",
        )
    )
    box, sphere = made.body("box"), made.body("sphere")
    box.AddForce(1000.0, 0, 0)
    speed = 1000.0 * 0.001
    for _ in range(990):
        made.step()
        assert box.GetLinearVel().x == pytest.approx(speed, abs=1e-9)
        assert tuple(sphere.GetLinearVel()) == (0.0, 0.0, 0.0)
    made.run(1.0)
    for body, x in ((box, 1.0), (sphere, 2.0)):
        assert body.GetLinearVel().x == pytest.approx(speed / 2, abs=0.01)
        assert body.GetPosition().x == pytest.approx(x + (made.GetSimTime() - 1.0) * speed / 2, abs=0.01)


def test_row_6_friction_demo(load):
    coefficients = (0.998, 0.9985, 0.999, 0.9995, 1.0, 1.01)
    low = inertial(pose="0 0 -0.4 0 0 0")
    boxes = [
        model(
            f"b{i}",
            "<allow_auto_disable>false</allow_auto_disable>",
            link("link", low, collision("box", friction(mu))),
            pose=f"{3 * i} 0 0.5 0 0 0",
        )
        for i, mu in enumerate(coefficients)
    ]
    made = load(world(GROUND, *boxes, gravity="0 -1 -1"))
    made.run(10.0)
    for i, mu in enumerate(coefficients):
        x, y, z = made.body(f"b{i}").GetLinearVel()
        assert (x, z) == pytest.approx((0.0, 0.0), abs=1e-3)
        assert y == pytest.approx(min(0.0, mu - 1.0) * 10.0, abs=1e-3)


def test_row_7_friction_cone(load):
    """In the cone model friction slows down along the motion alone, whatever its direction."""
    low, count, mu = inertial(pose="0 0 -0.45 0 0 0"), 16, 0.3
    angles = [2 * math.pi * i / count for i in range(count)]
    boxes = [
        model(
            f"b{i}",
            link("link", low, collision("box", friction(mu))),
            pose=f"{5 * math.cos(a)} {5 * math.sin(a)} 0.5 0 0 0",
        )
        for i, a in enumerate(angles)
    ]
    cone = "<ode><solver><friction_model>cone_model</friction_model></solver></ode>"
    made = load(world(GROUND, *boxes, physics=cone))
    for i, a in enumerate(angles):
        made.body(f"b{i}").SetLinearVel((9 * math.cos(a), 9 * math.sin(a), 0))
    made.run(1.5)
    for i, a in enumerate(angles):
        place = made.body(f"b{i}").GetPosition()
        assert math.remainder(math.atan2(place.y, place.x) - a, 2 * math.pi) == pytest.approx(0.0, abs=1e-2)
        radius = math.hypot(place.x, place.y)
        assert radius > 13.0
        assert radius == pytest.approx(5 + 9 * 1.5 - mu * 9.8 * 1.5**2 / 2, rel=2e-3)


def test_a_force_across_the_motion_moves_what_slides_in_the_cone_model(load):
    """Friction of a constant size opposes the motion: m dv/dt = F - mu m g v / |v|."""
    low, mu, mass = inertial(pose="0 0 -0.45 0 0 0"), 0.3, 1.0
    cone = "<ode><solver><friction_model>cone_model</friction_model></solver></ode>"
    made = load(
        world(GROUND, model("b", link("link", low, collision("box", friction(mu))), pose="0 0 0.5 0 0 0"), physics=cone)
    )
    body, across = made.body("b"), 0.5 * mu * mass * 9.8
    body.SetLinearVel((3, 0, 0))
    x, y = 3.0, 0.0
    for _ in range(400):
        body.AddForce(0.0, across, 0.0)
        made.step()
        for _ in range(10):
            size = math.hypot(x, y)
            x, y = x - 1e-4 * mu * 9.8 * x / size, y + 1e-4 * (across / mass - mu * 9.8 * y / size)
    velocity = body.GetLinearVel()
    assert (velocity.x, velocity.y) == pytest.approx((x, y), rel=0.01)
    for _ in range(1500):
        made.step()
    body.AddForce(0.0, across, 0.0)
    made.step(100)
    assert body.GetLinearVel().y == pytest.approx(0.0, abs=1e-3)  # it sticks


def test_mu_and_mu2_brake_in_proportion_to_the_parts_of_the_velocity_in_the_cone_model(load):
    """Measured in Gazebo 11.1: m dv/dt = -m g (mu2 vx, mu vy) / |v|, mu along y where the normal is upright."""
    low = inertial(pose="0 0 -0.45 0 0 0")
    cone = "<ode><solver><friction_model>cone_model</friction_model></solver></ode>"
    box = model("b", link("link", low, collision("box", friction(0.2, 0.6))), pose="0 0 0.5 0 0 0")
    made = load(world(GROUND, box, physics=cone))
    made.body("b").SetLinearVel((1, 1, 0))
    made.step(900)
    place = made.body("b").GetPosition()
    assert (place.x, place.y) == pytest.approx((0.1554, 0.2928), rel=0.01)


def test_row_7_the_pyramid_turns_what_the_cone_does_not(load):
    low = inertial(pose="0 0 -0.45 0 0 0")
    made = load(world(GROUND, model("b", link("link", low, collision("box", friction(0.3))), pose="0 0 0.5 0 0 0")))
    made.body("b").SetLinearVel((8, 2, 0))
    made.run(0.6)
    velocity = made.body("b").GetLinearVel()
    assert math.atan2(velocity.y, velocity.x) < math.atan2(2, 8) - 0.05


def test_row_7_friction_direction(load):
    """mu 1 along fdir1, none across: velocity only across it."""
    count, low = 12, inertial(pose="0 0 -0.45 0 0 0")
    angles = [math.pi * i / count for i in range(count)]
    boxes = [
        model(
            f"b{i}",
            link(
                "link",
                low,
                collision("box", friction(1, 0, f"<fdir1>{math.cos(a)} {math.sin(a)} 0</fdir1>")),
            ),
            pose=f"{3 * i} 0 0.5 0 0 0",
        )
        for i, a in enumerate(angles)
    ]
    made = load(world(GROUND, *boxes, gravity="0 1 -9.81"))
    made.run(1.5)
    for i, a in enumerate(angles):
        velocity = made.body(f"b{i}").GetLinearVel()
        assert velocity.x * math.cos(a) + velocity.y * math.sin(a) == pytest.approx(0.0, abs=5e-3)
        assert -velocity.x * math.sin(a) + velocity.y * math.cos(a) == pytest.approx(1.5 * math.cos(a), abs=2e-2)


def test_row_7_slip(load):
    """Terminal speed of a sphere that cannot roll: force times slip, over the one contact point."""
    masses, slips = (1.0, 2.0), (0.05, 0.2)
    balls, i = [], 0
    for mass in masses:
        for slip in slips:
            rough = friction(100, more=f"<slip1>{slip}</slip1><slip2>{slip}</slip2>")
            big = inertial(mass, (1e6, 1e6, 1e6))
            balls.append(model(f"b{i}", link("link", big, collision("sphere", rough)), pose=f"{3 * i} 0 0.5 0 0 0"))
            i += 1
    made = load(world(GROUND, *balls, gravity="0 2 -9.81"))
    made.run(3.0)
    for i, (mass, slip) in enumerate((m, s) for m in masses for s in slips):
        assert made.body(f"b{i}").GetLinearVel().y == pytest.approx(2.0 * mass * slip, rel=0.015)


@pytest.mark.parametrize("by_patch", [True, False])
def test_row_8_torsional_friction(load, by_patch):
    """Torque mu 3 pi / 16 a N, with a the patch radius, or sqrt(R depth)."""
    mass, inertia, mu, kp, radius = 1.0, 0.1, 0.5, 1e4, 0.8
    words = f"<use_patch_radius>{str(by_patch).lower()}</use_patch_radius>"
    words += "<patch_radius>0.2</patch_radius>" if by_patch else f"<surface_radius>{radius}</surface_radius>"
    surface = f"<friction><torsional><coefficient>{mu}</coefficient>{words}</torsional></friction>"
    surface += f"<contact><ode><kp>{kp}</kp><kd>100</kd><max_vel>10</max_vel></ode></contact>"
    ball = link("link", inertial(mass, (inertia,) * 3), collision("sphere", surface))
    made = load(world(GROUND, model("ball", ball, pose="0 0 0.499 0 0 0"), gravity="0 0 -9.81"))
    made.engine.record_contacts = True
    body = made.body("ball")
    body.SetAngularVel((0, 0, 20))
    made.run(0.5)
    contact = made.engine.contacts
    assert len(contact) == 1
    force = float((contact["force1"] + contact["force2"])[0, 2])
    depth = float(contact["depth"][0])
    assert force == pytest.approx(mass * 9.81, rel=0.01)
    assert depth == pytest.approx(mass * 9.81 / kp, rel=0.01)
    patch = 0.2 if by_patch else math.sqrt(radius * depth)
    start = body.GetAngularRate().z
    made.run(0.5)
    slowing = (start - body.GetAngularRate().z) / 0.5
    assert slowing == pytest.approx(mu * 3 * math.pi / 16 * patch * mass * 9.81 / inertia, rel=0.01)


def test_row_8_no_torsion_without_a_patch(load):
    made = load(world(GROUND, model("ball", link("link", collision("sphere")), pose="0 0 0.5 0 0 0")))
    made.body("ball").SetAngularVel((0, 0, 5))
    made.run(1.0)
    assert made.body("ball").GetAngularRate().z == pytest.approx(5.0, abs=1e-6)


def test_row_9_add_force(load):
    """A force at a place in the link: what it does to velocities, and nothing one step later."""
    box = link("link", inertial(2.0, (0.3, 0.4, 0.5), "0.1 0 0.2 0 0 0"), collision("box"))
    made = load(world(model("m", box, pose="1 2 3 0.3 0.2 0.7"), gravity="0 0 0"))
    body = made.body("m")
    pose, com = body.GetPose(), body.GetCoMPose().pos
    force, offset = rotate(pose.rot, (3.0, -4.0, 5.0)), rotate(pose.rot, (0.2, -0.1, 0.3))
    place = [p + o for p, o in zip(pose.pos, offset, strict=True)]
    body.AddForceAtPos(*force, *place)
    torque = np.cross(np.array(place) - np.array(com), force)
    assert tuple(body.GetForce()) == pytest.approx(tuple(force))
    assert tuple(body.GetTorque()) == pytest.approx(tuple(torque))
    made.step()
    axes = np.array([rotate(pose.rot, axis) for axis in np.eye(3)]).T
    rate = np.linalg.solve(axes @ np.diag((0.3, 0.4, 0.5)) @ axes.T, torque) * 0.001
    assert tuple(body.GetLinearVel()) == pytest.approx([f * 0.001 / 2.0 for f in force], abs=1e-6)
    assert tuple(body.GetAngularRate()) == pytest.approx(tuple(rate), abs=1e-6)
    assert (tuple(body.GetForce()), tuple(body.GetTorque())) == ((0, 0, 0), (0, 0, 0))
    before = body.GetLinearVel()
    made.step()
    assert tuple(body.GetLinearVel()) == pytest.approx(tuple(before), abs=1e-12)
    body.AddForceAtPos(*(-f for f in force), *place)
    made.step()
    assert tuple(body.GetLinearVel()) == pytest.approx((0, 0, 0), abs=1e-6)


def bits(value, more=""):
    return f"<contact><collide_bitmask>{value}</collide_bitmask>{more}</contact>"


def test_row_22_bitmasks(load):
    """0xff below; 1 and 2 rest on it, 3 on 2, and 0x10000 falls through."""
    ground = model("ground", "<static>true</static>", link("link", collision("<plane/>", bits("0xff"))))
    boxes = [
        model(name, link("link", collision("box", bits(mask))), pose=f"{x} 0 {z} 0 0 0")
        for name, mask, x, z in (
            ("one", 1, 0, 0.5),
            ("two", 2, 0, 0.5),
            ("three", 3, 0, 1.5),
            ("far", "0x10000", 5, 0.5),
        )
    ]
    made = load(world(ground, *boxes))
    made.run(1.0)
    for name, z in (("one", 0.5), ("two", 0.5), ("three", 1.5)):
        assert made.body(name).GetPosition().z == pytest.approx(z, abs=1e-3)
    assert made.body("far").GetPosition().z < -1.0


@pytest.mark.parametrize(("mask", "told"), [(1, True), (2, False)])
def test_row_22_collide_without_contact(load, mask, told):
    ghostly = "<collide_without_contact>true</collide_without_contact>"
    ghostly += f"<collide_without_contact_bitmask>{mask}</collide_without_contact_bitmask>"
    made = load(world(GROUND, model("m", link("link", collision("box", bits(65535, ghostly))), pose="0 0 0.5 0 0 0")))
    made.engine.record_contacts = True
    seen = 0
    for _ in range(200):
        made.step()
        seen += len(made.engine.contacts)
    assert made.body("m").GetPosition().z == pytest.approx(0.5 - 9.8 * 0.2**2 / 2, abs=2e-3)
    assert (seen > 0) == told


def test_contacts_of_a_pair_follow_the_limits_of_world_and_collisions(load):
    many = "<max_contacts>15</max_contacts>"
    none = "<max_contacts>0</max_contacts>"  # no limit, as in Gazebo
    two = "<max_contacts>2</max_contacts>"
    for limit, own, expected in ((20, "", 4), (20, two, 2), (3, many, 3), (0, many, 4), (20, none, 4), (2, none, 2)):
        body = link("link", collision("box", more=own))
        made = load(
            world(
                GROUND,
                model("m", body, pose="0 0 0.499 0 0 0"),
                physics=f"<max_contacts>{limit}</max_contacts>",
            )
        )
        made.step()
        assert made.engine.contact_count == expected


def test_push_out_goes_by_the_last_collision_of_a_link(load):
    def deep(speed):
        return f"<contact><ode><max_vel>{speed}</max_vel></ode></contact>"

    for first, last in ((0.5, 0.02), (0.02, 0.1)):
        two = collision("box", deep(first)) + collision("<sphere><radius>.1</radius></sphere>", deep(last), "d")
        made = load(world(GROUND, model("m", link("link", two), pose="0 0 0.4 0 0 0"), gravity="0 0 0"))
        made.step()
        assert made.body("m").GetLinearVel().z == pytest.approx(last, rel=1e-3)


@pytest.mark.parametrize("other", [True, False])
def test_push_out_of_a_pair_goes_by_the_smaller_limits(load, other):
    def shape(speed, depth):
        limits = f"<max_vel>{speed}</max_vel><min_depth>{depth}</min_depth>"
        return collision("box", f"<contact><ode>{limits}</ode></contact>")

    def body(name, z, *limits):
        return model(name, link("link", shape(*limits)), pose=f"0 0 {z} 0 0 0")

    # A fixed body has no influence: the lower one is pushed out of the ground at its own 0.02 m/s.
    made = load(world(GROUND, body("m", 0.4, 0.02, 0.0), gravity="0 0 0"))
    made.step()
    assert made.body("m").GetLinearVel().z == pytest.approx(0.02, rel=1e-3)
    for one, two, start, speed in (
        ((0.02, 0.0), (0.5, 0.03), 0.9, 0.02),
        ((0.1, 0.05), (0.1, 0.03), 0.96, 0.1),
        ((0.1, 0.05), (0.1, 0.03), 0.975, 0.0),
    ):
        first, second = (one, two) if other else (two, one)
        made = load(world(body("a", 0.0, *first), body("b", start, *second), gravity="0 0 0"))
        made.step()
        found = made.body("b").GetLinearVel().z - made.body("a").GetLinearVel().z
        assert found == pytest.approx(speed, rel=1e-3, abs=1e-9)


def test_a_point_within_min_depth_sinks_beside_one_that_is_set_apart(load):
    """The ends of a slanted capsule, which are one pair of shapes, move as spheres in their places, which are two."""
    springs = "<contact><ode><kp>1e6</kp><kd>1</kd><min_depth>.01</min_depth></ode></contact>"
    slope = math.asin(0.015 / 0.3)
    ends = "".join(
        collision("<sphere><radius>.1</radius></sphere>", springs, name, f"0 0 {z} 0 0 0")
        for name, z in (("a", -0.15), ("b", 0.15))
    )
    capsule = collision("<capsule><radius>.1</radius><length>.3</length></capsule>", springs)
    bodies = [
        model(name, link("link", inertial(1.0, (0.04,) * 3), shapes), pose=f"0 {y} .0875 0 {math.pi / 2 + slope} 0")
        for y, (name, shapes) in enumerate((("capsule", capsule), ("spheres", ends)))
    ]
    made = load(world(GROUND, *bodies))
    made.step()
    one, two = (made.body(name).GetAngularVel().y for name in ("capsule", "spheres"))
    assert one == pytest.approx(two, rel=1e-3)


def test_things_fall_asleep_and_wake(load):
    box = link("link", collision("box"))
    made = load(
        world(
            GROUND,
            model("asleep", box, pose="0 0 0.5 0 0 0"),
            model("awake", "<allow_auto_disable>0</allow_auto_disable>", box, pose="5 0 0.5 0 0 0"),
        )
    )
    asleep, awake = made.body("asleep"), made.body("awake")
    made.run(0.9)
    assert asleep.IsEnabled()
    made.run(0.5)
    assert (asleep.IsEnabled(), awake.IsEnabled()) == (False, True)
    made.step()
    assert made.engine.contact_count == 4
    asleep.AddForce(0, 0, 3000.0)
    made.step()
    assert asleep.IsEnabled()
    assert asleep.GetLinearVel().z > 2.0
    made.run(3.0)
    assert not asleep.IsEnabled()
    made.engine.gravity = (0, 0, 1)
    made.run(1.0)
    assert asleep.GetPosition().z > 0.9


def test_what_sleeps_wakes_when_its_support_goes(load):
    table = model("table", "<static>1</static>", link("link", collision("box")), pose="0 0 0.5 0 0 0")
    other = model("other", "<static>1</static>", link("link", collision("box")), pose="5 0 0.5 0 0 0")
    boxes = [model(f"b{x}", link("link", collision("box")), pose=f"{x} 0 1.5 0 0 0") for x in (0, 5)]
    made = load(world(GROUND, table, other, *boxes))
    made.run(1.5)
    assert not any(made.body(f"b{x}").IsEnabled() for x in (0, 5))
    made.DeleteModel("table")
    made.run(0.3)
    assert made.body("b0").GetPosition().z < 1.2
    assert made.body("b5").GetPosition().z == pytest.approx(1.5, abs=1e-3)
    made.run(1.5)
    made.SetModelPose(made.model("other"), GzPose(GzVector(9, 0, 0.5)))
    made.run(0.3)
    assert made.body("b5").GetPosition().z < 1.2


ELASTIC = (
    "<contact><elastic_modulus>{}</elastic_modulus><poissons_ratio>{}</poissons_ratio><ode><kd>500</kd></ode></contact>"
)


@pytest.mark.parametrize(("below", "nu"), [(2e6, 0.3), (5e6, 0.45)])
def test_an_elastic_ball_is_pressed_in_as_hertz_says(load, below, nu):
    """F = 4/3 E sqrt(R) d^1.5, with 1/E = (1 - nu1^2)/E1 + (1 - nu2^2)/E2."""
    radius, mass, g = 0.5, 20.0, 9.81
    ball = link("link", inertial(mass), collision("sphere", ELASTIC.format(1e6, 0.3)))
    floor = model("floor", link("link", collision("<plane><normal>0 0 1</normal></plane>", ELASTIC.format(below, nu))))
    floor = floor.replace("<pose>", "<static>true</static><pose>", 1)
    made = load(world(floor, model("ball", ball, pose="0 0 0.5 0 0 0"), gravity=f"0 0 {-g}"))
    made.run(3.0)
    modulus = 1.0 / ((1 - 0.3**2) / 1e6 + (1 - nu**2) / below)
    depth = (0.75 * mass * g / (modulus * math.sqrt(radius))) ** (2 / 3)
    assert radius - made.body("ball").GetPose().pos.z == pytest.approx(depth, rel=1e-3)
    assert depth > 1e-4


def test_a_flat_punch_on_its_patch_and_rigid_surfaces(load):
    """k = 2 E a for flat surfaces with a patch radius; without a modulus on both sides nothing changes."""
    torsion = "<friction><torsional><patch_radius>0.3</patch_radius></torsional></friction>"
    soft, plane = ELASTIC.format(1e5, 0.3), "<plane><normal>0 0 1</normal></plane>"
    for surface, stiffness in ((soft, 4 * 2 * 0.3 / (2 * (1 - 0.09) / 1e5)), ("", math.inf)):
        floor = model("floor", link("link", collision(plane, torsion + surface)))
        floor = floor.replace("<pose>", "<static>true</static><pose>", 1)
        box = link("link", inertial(10.0, (2, 2, 2)), collision("box", torsion + soft))
        made = load(world(floor, model("box", box, pose="0 0 0.5 0 0 0")))
        made.run(3.0)
        depth = 10.0 * 9.8 / stiffness
        assert 0.5 - made.body("box").GetPose().pos.z == pytest.approx(depth, rel=1e-3, abs=1e-5)
