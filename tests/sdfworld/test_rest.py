"""Rest under the quick solver: what rests does not shake, whatever the step, and robots turn as before."""

import math

import numpy as np
import pytest
from sdf_worlds import GROUND, Loader, collision, friction, inertial, joint, link, model, world

from libgz.sdf.reader import SdfFile
from libgz.sdfworld.world import SdfWorld

STEPS = (0.001, 0.002, 0.01, 0.02)
SHAKING = 1e-2  # [m/s^2] and [rad/s^2], at most
AWAKE = "<allow_auto_disable>0</allow_auto_disable>"


@pytest.fixture
def load(tmp_path):
    loader = Loader(tmp_path)
    yield loader
    loader.close()


def physics(step=0.001, **solver):
    settings = "".join(f"<{key}>{value}</{key}>" for key, value in solver.items())
    return f"<max_step_size>{step}</max_step_size><ode><solver>{settings}</solver></ode>"


def block(name, size, place, mass=1.0, surface="", more=AWAKE):
    x, y, z = size
    moments = tuple(mass / 12.0 * (a * a + b * b) for a, b in ((y, z), (x, z), (x, y)))
    geometry = f"<box><size>{x} {y} {z}</size></box>"
    place = " ".join(map(str, place)) + " 0 0 0"
    return model(name, more, link("link", inertial(mass, moments), collision(geometry, surface)), pose=place)


def stack(count, mass=1.0, size=0.5):
    return "".join(block(f"b{i}", (size,) * 3, (0, 0, size / 2 + size * i), mass) for i in range(count))


def wheel(name, x, y, radius=0.11, surface=""):
    shape = f"<cylinder><radius>{radius}</radius><length>0.05</length></cylinder>"
    part = link(
        name, inertial(1.0, (0.004, 0.004, 0.006)), collision(shape, surface), pose=f"{x} {y} {radius} -1.5708 0 0"
    )
    return part + joint(f"{name}_joint", "revolute", "base", name, "0 0 1")


def robot(name="robot", place="5 5 0 0 0 0"):
    """Two wheels and a caster."""
    base = link(
        "base",
        inertial(5.0, (0.07, 0.08, 0.1)),
        collision("<box><size>0.44 0.28 0.17</size></box>"),
        collision("<sphere><radius>0.04</radius></sphere>", friction(0), name="caster", pose="-0.2 0 -0.12 0 0 0"),
        pose="0 0 0.16 0 0 0",
    )
    return model(name, base, wheel("left", 0.1, 0.17), wheel("right", 0.1, -0.17), pose=place)


def accelerations(made, seconds=0.3):
    """The largest change of any velocity per time in a while [m/s^2 or rad/s^2]."""
    engine, worst = made.engine, 0.0
    before = engine.states[:, 10:16].copy()
    for _ in range(round(seconds / engine.step_time)):
        made.step()
        now = engine.states[:, 10:16].copy()
        worst = max(worst, float(np.abs(now - before).max()) / engine.step_time)
        before = now
    return worst


@pytest.mark.parametrize("step", STEPS)
@pytest.mark.parametrize(
    "scene",
    [
        block("cube", (1, 1, 1), (0, 0, 0.5)),
        block("pillar", (0.1, 0.1, 1), (0, 0, 0.5)),
        robot(),
        stack(10),
        stack(3, 1e-3),
        block("light", (1, 1, 1), (0, 0, 0.5)) + block("heavy", (1, 1, 1), (0, 0, 1.5), 1000.0),
    ],
    ids=["cube", "pillar", "robot", "stack", "light stack", "1000 kg on 1 kg"],
)
def test_what_rests_does_not_accelerate(load, scene, step):
    made = load(world(GROUND, scene, physics=physics(step)))
    made.run(1.0)
    heights = made.engine.states[:, 9].copy()
    assert accelerations(made) < SHAKING
    assert made.engine.states[:, 9] == pytest.approx(heights, abs=2e-4)


@pytest.mark.parametrize("step", [0.01, 0.02])
@pytest.mark.parametrize(("size", "mass"), [(0.3, 1.0), (0.3, 20.0), (1.0, 20.0), (0.1, 0.1)])
def test_stacks_whose_places_are_rounded_rest_from_the_first_step(load, size, mass, step):
    made = load(world(GROUND, stack(10, mass, size), physics=physics(step)))
    for _ in range(2):
        made.step()
        assert made.engine.contact_count >= 38  # a box that stands on the ground to the bit may lack a corner
        assert np.abs(made.engine.states[:, 10:16]).max() < 1e-3  # [m/s]; free fall of a step is 0.1
        made.run(0.6)
        assert accelerations(made, 0.1) < SHAKING
        made.Reset()


def test_a_stack_of_forty_in_any_order_rests(load):
    shuffled = [f"b{7 * i % 40}" for i in range(40)]
    boxes = [block(name, (0.5,) * 3, (0, 0, 0.25 + 0.5 * int(name[1:]))) for name in shuffled]
    made = load(world(GROUND, *boxes, physics=physics(0.01)))
    made.run(0.5)
    assert accelerations(made, 0.1) < SHAKING


def test_contacts_that_hold_on_a_slope_do_not_creep_and_others_slide(load):
    """By the friction cone: a block stays where mu > tan(slope), else it slides at g (sin - mu cos)."""
    slope = 0.3
    plane = model(
        "slope",
        "<static>1</static>",
        link("link", collision("<box><size>9 9 1</size></box>", friction(10))),
        pose=f"0 0 {-0.5 / math.cos(slope)} 0 {slope} 0",
    )
    normal = (math.sin(slope), 0.0, math.cos(slope))

    def on_slope(name, y, mu):
        text = block(name, (0.4, 0.4, 0.1), (0.05 * normal[0], y, 0.05 * normal[2]), surface=friction(mu))
        return text.replace(" 0 0 0</pose>", f" 0 {slope} 0</pose>", 1)

    made = load(world(plane, on_slope("holds", -2, 0.4), on_slope("slides", 2, 0.2), physics=physics()))
    made.run(0.2)
    before = made.body("holds").GetPosition()
    made.run(1.0)
    after = made.body("holds").GetPosition()
    assert math.dist((before.x, before.y, before.z), (after.x, after.y, after.z)) < 1e-7
    speed = made.body("slides").GetLinearVel()
    assert math.hypot(*speed) == pytest.approx(1.2 * 9.8 * (math.sin(slope) - 0.2 * math.cos(slope)), rel=0.02)


def sliding(load, speed):
    """Two boxes apart and two stacked ones, with a velocity."""
    size = (0.4, 0.4, 0.2)
    boxes = [
        ("rough", (0, 0, 0.1), 0.5),
        ("smooth", (0, 2, 0.1), 0.1),
        ("low", (0, 6, 0.1), 0.3),
        ("high", (0, 6, 0.3), 0.3),
    ]
    made = load(
        world(GROUND, *(block(name, size, at, surface=friction(mu)) for name, at, mu in boxes), physics=physics())
    )
    made.step(5)
    for name, _, _ in boxes:
        made.body(name).SetLinearVel((speed, 0, 0))
    return made


def test_boxes_that_slide_to_a_stop_rest_where_friction_stops_them(load):
    """At v^2 / (2 mu g), less what friction takes within the first step."""

    def run():
        made = sliding(load, 0.09)
        made.run(0.15)
        assert accelerations(made, 0.01) < 1e-6
        return made.engine.states.tolist()

    states = run()
    for row, mu in zip(states, (0.5, 0.1, 0.3, 0.3), strict=True):
        step, slowing = 0.001, mu * 9.8
        assert row[0] == pytest.approx(0.09**2 / (2 * slowing) - 0.09 * step / 2, abs=2e-6), mu


def test_contacts_of_a_resting_stack_carry_what_is_above_them(load):
    made = load(world(GROUND, stack(3), physics=physics(0.01)))
    made.engine.record_contacts = True
    made.run(0.3)
    contacts = made.engine.contacts
    lifted = [float(contact["force1"][2]) for contact in contacts]
    heights = contacts["position"][:, 2]
    for level, above in ((0.0, 3), (0.5, 2), (1.0, 1)):
        carried = sum(abs(force) for force, height in zip(lifted, heights, strict=True) if abs(height - level) < 0.01)
        assert carried == pytest.approx(above * 9.8, rel=1e-6)


def test_solids_are_set_down_by_less_than_a_micrometre_on_what_they_stand_on(load):
    high = block("high", (0.3, 0.3, 0.3), (3, 0, 0.15 + 2e-6))
    sill = model(
        "sill", "<static>1</static>", link("link", collision("<box><size>1 1 0.7</size></box>")), pose="6 0 .35 0 0 0"
    )
    text = world(
        GROUND, stack(3, size=0.3), high, sill, block("on", (0.3, 0.3, 0.3), (6, 0, 0.85 + 1e-8)), physics=physics()
    )
    made = load(text)
    found = {name: made.body(name).GetPosition().z for name in ("b0", "b1", "b2", "high", "on")}
    assert found == pytest.approx({"b0": 0.15, "b1": 0.45, "b2": 0.75, "high": 0.15 + 2e-6, "on": 0.85}, abs=1e-7)
    assert found["high"] == 0.15 + 2e-6
    late = f"<sdf version='1.6'>{block('late', (0.3, 0.3, 0.3), (0, 0, 1.05 + 5e-8))}</sdf>"
    made.extension(SdfWorld).insert(SdfFile.from_string(late))
    assert made.body("late").GetPosition().z < 1.05
    made.step()
    assert made.engine.contact_count >= 19


def test_a_loose_plane_is_loaded_beside_solids(load):
    plane = model("loose", link("link", collision("<plane><normal>0 0 1</normal></plane>")))
    made = load(world(plane, stack(2), physics=physics()))
    made.step()
    assert made.body("b1").GetPosition().z == pytest.approx(1.5 * 0.5, abs=0.3)


def test_geoms_near_a_place_are_found_also_in_spaces(load):
    made = load(world(GROUND, stack(3), physics=physics()))
    near = made.engine.geoms_near((-0.1, -0.1, 0.6), (0.1, 0.1, 0.9))
    assert [geom.body.model.GetId() for geom in near] == ["b1"]
    assert {geom.body.model.GetId() for geom in made.engine.geoms_near((-1, -1, -1), (1, 1, math.inf))} == {
        *("b0", "b1", "b2", "ground_plane")
    }


def test_ten_boxes_by_the_exact_solver_do_not_creep(load):
    made = load(world(GROUND, stack(10), physics=physics(0.002, type="world")))
    made.run(1.0)
    before = made.engine.states[:, 7:10].copy()
    made.run(5.0)
    assert np.abs(made.engine.states[:, 7:10] - before).max() < 1e-5  # [m]; 60 s were 126 mm without honest rest


def test_a_resting_body_keeps_its_contacts_and_a_depth_of_three_micrometres(load):
    made = load(world(GROUND, block("b", (0.3, 0.3, 1), (0, 0, 0.5)), physics=physics()))
    made.run(0.5)
    for _ in range(50):
        made.step()
        assert made.engine.contact_count == 4
    assert made.engine.states[0, 9] == pytest.approx(0.5 - 3e-6, abs=2e-7)


def test_exact_rest_can_be_switched_off(load):
    text = world(GROUND, block("b", (0.1, 0.1, 1), (0, 0, 0.5)), physics=physics(exact_rest="false"))
    made = load(text)
    assert not made.engine.exact_rest
    made.run(1.0)
    assert accelerations(made) > 1.0  # as under ODE's own rule
    assert load(text.replace("false", "true")).engine.exact_rest


def test_soft_springs_are_what_they_were(load):
    """A spring that the step can follow gets no damper and no depth."""
    soft = "<contact><ode><kp>1000</kp><kd>1</kd><max_vel>100</max_vel></ode></contact>"
    made = [
        load(
            world(
                GROUND, block("b", (1, 1, 1), (0, 0, 0.51), surface=soft), physics=physics(type="world", exact_rest=on)
            )
        )
        for on in ("true", "false")
    ]
    for each in made:
        each.run(0.5)
    assert made[0].engine.states.tolist() == made[1].engine.states.tolist()


MIXED = (
    GROUND,
    robot("fast", "0 0 0 0 0 0"),
    robot("calm", "3 0 0 0 0 0"),
    block("sleeper", (1, 1, 1), (6, 0, 0.5), more=""),
    block("below", (0.4, 0.4, 0.4), (9, 0, 0.2), more=""),
    block("above", (0.4, 0.4, 0.4), (9.05, 0, 0.9), more=""),
)


def run_mixed(load, steps):
    made = load(world(*MIXED, physics=physics()))
    for name, speed in (("left", 8.0), ("right", 6.0)):
        made.model("fast").sdf_joints[f"{name}_joint"].add_force(0.0)
        hinge = made.model("fast").sdf_joints[f"{name}_joint"]
        hinge.set_param("fmax", 5.0)
        hinge.set_param("vel", speed)
    made.step(steps)
    return made


def test_bodies_fall_asleep_while_others_move(load):
    made = run_mixed(load, 1100)
    awake = {body.model.GetId(): body.IsEnabled() for body in made.engine.bodies.values()}
    assert awake["fast"]
    assert awake["calm"]  # a model with joints never sleeps
    assert not awake["sleeper"]


def test_a_state_in_the_midst_of_it_goes_on_to_the_bit(load):
    made = run_mixed(load, 700)
    state = made.engine.get_state()
    made.step(600)
    first = made.engine.states.tolist(), [body.IsEnabled() for body in made.engine.bodies.values()]
    made.engine.set_state(state)
    made.step(600)
    assert (made.engine.states.tolist(), [b.IsEnabled() for b in made.engine.bodies.values()]) == first
    made.engine.exact_rest = False
    made.engine.set_state(state)
    assert made.engine.exact_rest


@pytest.mark.parametrize(
    ("length", "width", "mu", "spin", "expected"), [(0.2, 0.4, 1.0, 1.0, 0.808), (0.2, 0.4, 0.5, 5.0, 0.7)]
)
def test_a_skid_steering_robot_turns_as_with_1000_iterations(load, length, width, mu, spin, expected):
    """The yaw rate in units of that of wheels that do not slip; with 50 iterations it was 0.775 in the first case."""
    base = link("base", inertial(10.0, (0.2, 0.2, 0.3)), pose="0 0 0.15 0 0 0")
    places = [(x * length / 2, y * width / 2) for x in (1, -1) for y in (1, -1)]
    wheels = [wheel(f"w{i}", x, y, 0.1, friction(mu)) for i, (x, y) in enumerate(places)]
    made = load(world(GROUND, model("rover", base, *wheels), physics=physics()))
    made.run(0.5)
    for i in range(4):
        hinge = made.model("rover").sdf_joints[f"w{i}_joint"]
        hinge.set_param("fmax", 5.0)
        hinge.set_param("vel", -spin if i % 2 == 0 else spin)
    yaw, body = 0.0, made.body("rover", "base")
    for _ in range(1500):
        made.step()
        yaw += body.GetAngularRate().z * 0.001
    assert yaw / (1.5 * spin * 0.1 / (width / 2)) == pytest.approx(expected, abs=0.03)
