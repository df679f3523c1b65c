"""Robots in the style of public ones: arms, hands, legs, wheels with suspensions, loops of joints; SDF and URDF."""

# ruff: noqa: E501 - lines of SDF

import math
from dataclasses import replace

from beside.kinds import FIXED, MESHES, axis, between, damped, hinged, near, pushed, sprung
from beside.scenes import (
    NEAR,
    a_base,
    a_box,
    body,
    collision,
    described,
    friction,
    link,
    rolling,
    urdf,
    urdf_joint,
    urdf_link,
)
from beside.worlds import FOUR, GROUND, plugin, wheel

BOX, BALL = "<box size='.3 .3 .1'/>", "<sphere radius='.1'/>"
WORLD = "<link name='world'/>"


def tagged(reference, words):
    return f"<gazebo reference='{reference}'>{words}</gazebo>"


def turned(description, pose, rpy):
    """A link's inertia elsewhere, and turned."""
    return description.replace("<origin xyz='0 0 0'/><mass", f"<origin xyz='{pose}' rpy='{rpy}'/><mass", 1)


MAST = (
    urdf_link("base", 5, 0.1, "<box size='.4 .3 .1'/>") + urdf_link("mast", 1, 0.02, "<cylinder radius='.03' length='.4'/>")
    + turned(urdf_link("head", 0.5, 0.005, "<sphere radius='.08'/>"), ".01 .02 0", ".1 .2 .3")
    + urdf_link("lidar", 0.2, 0.001) + urdf_link("tail", 0.3, 0.002, "<box size='.2 .02 .02'/>", "-.1 0 0")
    + urdf_joint("a", "fixed", "base", "mast", ".1 0 .25", rpy="0 .2 .1")
    + urdf_joint("b", "fixed", "mast", "head", "0 .05 .2", rpy=".1 0 .3")
    + urdf_joint("c", "fixed", "head", "lidar", "0 0 .1") + urdf_joint("t", "revolute", "base", "tail", "-.2 0 .05")
)  # fmt: skip
PALM = urdf_link("palm", 1, 0.01, BOX) + urdf_joint("w", "fixed", "world", "palm", "0 0 .5") + "".join(
    urdf_link(f"f{side}", 0.1, 0.0005, "<box size='.02 .02 .1'/>", "0 0 -.05")
    + urdf_joint(
        f"j{side}", "prismatic", "palm", f"f{side}", f"0 {0.05 * side} -.05", "0 1 0", f"lower='{low}' upper='{low + 0.04}'"
    )
    for side, low in ((1, 0.0), (-1, -0.04))
)  # fmt: skip
SPUN = urdf_link("base", 2, 0.05, BOX) + urdf_link("arm", 0.5, 0.01, "<box size='.3 .05 .05'/>", ".15 0 0")
SPUN += urdf_joint("j", "continuous", "base", "arm", "0 0 .1", "0 0 1", "lower='0' upper='0'")
GRIP = (
    "<mu1>.8</mu1><mu2>.6</mu2><kp>1e6</kp><kd>10</kd><minDepth>.001</minDepth><maxVel>1</maxVel><fdir1>1 0 0</fdir1>"
)
TAGGED = urdf_link("base", 5, 0.1, "<box size='.5 .3 .1'/>") + "".join(
    urdf_link(f"w{i}", 0.5, 0.002, BALL)
    + urdf_joint(f"j{i}", "continuous", "base", f"w{i}", f"{x} {y} -.05", limits="lower='0' upper='0'")
    + tagged(f"w{i}", GRIP)
    for i, (x, y) in enumerate(FOUR.values())
)  # fmt: skip
TAGGED += tagged("base", "<selfCollide>true</selfCollide><dampingFactor>.001</dampingFactor>")
TAGGED += tagged("j0", "<implicitSpringDamper>1</implicitSpringDamper><provideFeedback>1</provideFeedback>")
TWO = urdf_link("a", 1, 0.02, "", "0 0 .1") + urdf_link("b", 1, 0.02, "", "0 0 .15")
TWO += urdf_joint("j", "revolute", "a", "b", "0 0 .2", limits="lower='-.4' upper='.6'", rpy=".1 .3 0")
SPRINGS = "<springStiffness>20</springStiffness><springReference>.5</springReference><stopCfm>.001</stopCfm>"
KEPT = (
    urdf_link("base", 2, 0.05, BOX) + urdf_link("post", 0.5, 0.01, "<box size='.05 .05 .3'/>", "0 0 .15")
    + urdf_joint("f", "fixed", "base", "post", ".1 0 .05")
    + tagged("f", "<disableFixedJointLumping>true</disableFixedJointLumping>")
    + urdf_link("k", 0.2, 0.002, "<sphere radius='.05'/>") + urdf_joint("g", "fixed", "post", "k", "0 0 .35")
    + tagged("g", "<preserveFixedJoint>true</preserveFixedJoint>")
)  # fmt: skip
MESHED = urdf_link("base", 2, 0.05, "<mesh filename='model://m/hex.obj' scale='1 1 .5'/>")
MESHED += urdf_link("arm", 0.5, 0.01, "<mesh filename='package://m/hex.obj' scale='.3 .3 .3'/>", ".1 0 0")
MESHED += urdf_joint("j", "revolute", "base", "arm", "0 0 .15")
WEIGHTLESS = urdf_link("base", 2, 0.05, BOX) + urdf_link("a", 1, 0.01, BALL, ".3 0 0")
WEIGHTLESS += urdf_joint("j", "revolute", "base", "a", "0 0 .1")
PLACES = ("0 0 .3", ".05 0 .2", "0 0 .4", ".2 0 .05", ".2 0 0")
SIX = "".join(
    turned(urdf_link(f"l{i}", mass, mass / 80), f"{0.02 * i:.2f} .01 .1", f".1 .{i} 0")
    for i, mass in enumerate((8, 6, 4, 2, 1, 0.5))
) + "".join(
    urdf_joint(f"j{i}", "revolute", f"l{i - 1}", f"l{i}", place, turn)
    for i, (place, turn) in enumerate(zip(PLACES, ("0 0 1", "0 1 0", "0 1 0", "1 0 0", "0 1 0"), strict=True), 1)
)  # fmt: skip
SCARA = (
    urdf_link("l0", 5, 0.1, "<box size='.2 .2 .6'/>", "0 0 .3") + urdf_link("l1", 2, 0.03, "<box size='.4 .1 .05'/>", ".2 0 0")
    + urdf_link("l2", 1, 0.01, "<box size='.3 .1 .05'/>", ".15 0 0") + urdf_link("q", 0.3, 0.002, "", "0 0 -.1")
    + urdf_joint("w", "fixed", "world", "l0", "0 0 0") + urdf_joint("a", "revolute", "l0", "l1", "0 0 .65", "0 0 1")
    + urdf_joint("b", "revolute", "l1", "l2", ".4 0 .06", "0 0 1")
    + urdf_joint("z", "prismatic", "l2", "q", ".3 0 0", "0 0 1", "lower='-.2' upper='.1'")
)  # fmt: skip


def on_wheels(*inside, height=0.15, pose="0 0 0 0 0 0"):
    return rolling("car", a_base(height) + "".join(inside), pose)


def rotor(i, x, y):
    """A rotor whose blade lifts."""
    words = (
        "<a0>.3</a0><cla>4.2</cla><cda>.1</cda><cma>0</cma><alpha_stall>1.4</alpha_stall><cla_stall>-3.8</cla_stall>"
    )
    words += (
        "<cda_stall>0</cda_stall><cma_stall>0</cma_stall><area>.002</area><air_density>1.2</air_density><cp>.084 0 0"
    )
    words += f"</cp><forward>0 1 0</forward><upward>0 0 1</upward><link_name>r{i}</link_name>"
    lift = plugin("LiftDragPlugin", words).replace("name='LiftDragPlugin'", f"name='lift{i}'")
    turning = hinged(f"j{i}", "revolute", "base", f"r{i}", axis("0 0 1", "", damped(1e-4)))
    return link(f"r{i}", f"{x} {y} 3.05 0 0 0", 0.05, 0.0005) + turning + lift


def delta():
    """Three arms, three rods and a plate."""
    parts = link("b", "0 0 2 0 0 0", 3, 0.05) + FIXED + link("plate", "0 0 1.4 0 0 0", 0.5, 0.005)
    for i in range(3):
        turn = 2 * math.pi * i / 3
        c, s = math.cos(turn), math.sin(turn)
        parts += link(f"u{i}", f"{0.25 * c:.6f} {0.25 * s:.6f} 2 0 0 {turn:.6f}", 0.3, 0.003)
        parts += hinged(f"m{i}", "revolute", "b", f"u{i}", axis(dynamics=damped(0.5)), pose="-.15 0 0 0 0 0")
        parts += link(f"r{i}", f"{0.25 * c:.6f} {0.25 * s:.6f} 1.7 0 .5 {turn:.6f}", 0.1, 0.002)
        parts += hinged(f"b{i}", "ball", f"u{i}", f"r{i}", pose="-.144 0 .263 0 0 0")
        parts += hinged(f"p{i}", "ball", f"r{i}", "plate", pose=f"{0.1 * c:.6f} {0.1 * s:.6f} 0 0 0 0")
    return rolling("delta", parts)


def snake():
    parts = "".join(link(f"l{i}", f"{0.2 * i:.1f} 0 5 0 0 0", 0.3, 0.002) for i in range(8))
    for i in range(1, 8):
        turning = axis("0 0 1" if i % 2 else "0 1 0", between(-1, 1), sprung(1, 0.05, 0.3))
        parts += hinged(f"j{i}", "revolute", f"l{i - 1}", f"l{i}", turning, pose="-.1 0 0 0 0 0")
    return pushed(rolling("snake", parts), "0 0 5", ".5 .3 1")


def crane():
    """A boom, a rope of ball and universal joints, and a load."""
    parts = link("boom", ".8 0 3 0 0 0", 10, 3)
    parts += hinged("s", "revolute", "world", "boom", axis("0 0 1", "", damped(1)), pose="-.8 0 0 0 0 0")
    for i in range(4):
        parts += link(f"r{i}", f"1.6 0 {2.9 - 0.2 * i:.1f} 0 0 0", 0.1, 0.001)
        axes = axis("1 0 0", "", damped(0.01)) + axis("0 1 0", "", damped(0.01), "2")
        kind, above = ("ball", "universal")[i % 2], f"r{i - 1}" if i else "boom"
        parts += hinged(f"b{i}", kind, above, f"r{i}", axes if i % 2 else "", pose="0 0 .1 0 0 0")
    parts += link("load", "1.6 0 2.1 0 0 0", 5, 0.1) + hinged("l", "fixed", "r3", "load")
    return pushed(rolling("crane", parts), angular="0 0 .5")


SPRUNG = "".join(
    link(f"s{i}", f"{x} {y} .1 0 0 0", 0.5, 0.005)
    + hinged(f"p{i}", "prismatic", "base", f"s{i}", axis("0 0 1", between(-0.05, 0.05), sprung(2000, 60)))
    + wheel(f"w{i}", x, y).replace("<parent>base", f"<parent>s{i}")
    for i, (x, y) in enumerate(FOUR.values())
)
FOUR_WHEELS = "".join(wheel(name, *place) for name, place in FOUR.items())
TRAILER = (
    link("trailer", "-.7 0 .15 0 0 0", 3, 0.05, collision(a_box(".4 .3 .1")))
    + hinged("hitch", "ball", "base", "trailer", pose=".35 0 0 0 0 0")
    + "".join(wheel(f"t{i}", -0.75, y).replace("<parent>base", "<parent>trailer") for i, y in enumerate((0.2, -0.2)))
)
FORKS = (
    link("mast", ".3 0 .4 0 0 0", 3, 0.05) + hinged("m", "fixed", "base", "mast")
    + link("forks", ".45 0 .3 0 0 0", 1, 0.02, collision(a_box(".3 .2 .02"), friction(1)))
    + hinged("lift", "prismatic", "mast", "forks", axis("0 0 1", between(-0.25, 0.5), sprung(200, 40, 0.1)))
)  # fmt: skip
CART = (
    link("cart", "0 0 1 0 0 0", 2, 0.05) + link("pole", "0 0 1.4 0 .05 0", 0.5)
    + hinged("s", "prismatic", "world", "cart", axis("1 0 0", between(-2, 2), damped(0.1)))
    + hinged("p", "revolute", "cart", "pole", axis(dynamics=damped(0.01)), pose="0 0 -.4 0 0 0")
)  # fmt: skip
FINGERS = link("b", "0 0 .3 0 0 0", 1, 0.01) + FIXED + "".join(
    link(f"f{side}", f"0 {0.06 * side} .2 0 0 0", 0.1, 0.0005, collision(a_box(".05 .02 .12"), friction(1.5)))
    + hinged(f"j{side}", "prismatic", "b", f"f{side}", axis(limits=between(-0.1, 0.1), dynamics=sprung(300, 8, -0.04 * side)))
    for side in (1, -1)
)  # fmt: skip
PLACED = ((0.2, 0.2), (-0.2, 0.2), (-0.2, -0.2), (0.2, -0.2))
TORQUES = "".join(f"<controller type='force'><joint>j{i}</joint><target>.02</target></controller>" for i in (0, 2))
DRIVEN = "".join(f"<controller type='force'><joint>{name}</joint><target>.1</target></controller>" for name in FOUR)

MACHINES = {
    "described mast of fixed joints": described(urdf("r", MAST, ""), GROUND, pose="0 0 .3 0 0 .4"),
    "described gripper": described(urdf("r", WORLD, PALM)),
    "described arm that spins": described(urdf("r", SPUN, ""), GROUND, pose="0 0 .4 .1 0 0"),
    "described rover with tags": described(urdf("r", TAGGED, ""), GROUND, pose="0 0 .16 0 0 0"),
    "described springs and stops": described(
        urdf("r", WORLD, TWO + urdf_joint("w", "fixed", "world", "a", "0 0 1") + tagged("j", SPRINGS))
    ),
    "described fixed joints that stay": described(urdf("r", KEPT, ""), GROUND, pose="0 0 .2 0 0 .2"),
    "described meshes": replace(described(urdf("r", MESHED, ""), GROUND, pose="0 0 .6 0 0 0"), tolerance=NEAR),
    "described gravity in words of SDF": described(
        urdf("r", WEIGHTLESS, tagged("a", "<gravity>0</gravity>")), pose="0 0 2 0 0 0"
    ),
    "described robot that stands": described(
        urdf("r", WEIGHTLESS, "<gazebo><static>true</static></gazebo>"), pose="0 0 2 0 0 0"
    ),
    "described six axes": described(urdf("r", WORLD, SIX + urdf_joint("w", "fixed", "world", "l0", "0 0 0"))),
    "described scara": described(urdf("r", WORLD, SCARA)),
    "car with suspension": near(GROUND, on_wheels(SPRUNG, height=0.2, pose="0 0 .02 0 0 0")),
    "car and trailer": near(GROUND, pushed(on_wheels(FOUR_WHEELS, TRAILER), "1 0 0")),
    "forklift": near(
        GROUND,
        on_wheels(FOUR_WHEELS, FORKS).replace("<mass>5</mass>", "<mass>20</mass>"),
        body("crate", ".45 0 .37 0 0 0", a_box(".2 .2 .12"), friction(1), 1, 0.01),
    ),
    "wheels that are driven": near(GROUND, on_wheels(FOUR_WHEELS, plugin("JointControlPlugin", DRIVEN))),
    "crane": near(crane()),
    "cart and pole": near(rolling("c", CART)),
    "two wheels that fall over": near(
        GROUND,
        rolling(
            "s",
            link("base", "0 0 .5 0 .05 0", 5, 0.3, collision(a_box(".2 .3 .6"))) + wheel("l", 0, 0.25) + wheel("r", 0, -0.25),
        ),
    ),
    "delta": near(delta()),
    "rotors that lift": near(
        rolling(
            "q",
            link("base", "0 0 3 0 0 0", 1.5) + "".join(rotor(i, *place) for i, place in enumerate(PLACED))
            + plugin("JointControlPlugin", TORQUES),
        )
    ),
    "snake in the air": near(snake()),
    "fingers that close": near(
        GROUND,
        rolling("g", FINGERS),
        body("cube", "0 0 .03 0 0 0", a_box(".06 .06 .06"), friction(1.5), 0.1, 0.0002),
    ),
}  # fmt: skip
MACHINES["described meshes"].files.update(MESHES)
