"""Worlds without plugins: what falls, slides, rolls, swings, and robots of every kind, as worlds of users have them."""

import math
from dataclasses import replace

from beside.worlds import FOUR, GROUND, TOUCHING, box_collision, inertia, plugin, wheel, world

NEAR = 1e-3  # [m]
# Gazebo's contacts creep at rest, sink and turn, because its solver ends before it has converged; libgz's stand: see
# docs/sdf.md, "Motion compared with Gazebo 11.1".
CREEPING = 0.05  # [m]
CREEP = (
    "stack of 5",
    "solver of 200 iterations",
    "slope of 20 degrees, mu 0.5",
    "see-saw",
    "described tricycle",
)


def collision(shape, surface="", pose="0 0 0 0 0 0", name="c"):
    inside = f"<geometry>{shape}</geometry><surface>{surface}</surface>"
    return f"<collision name='{name}'><pose>{pose}</pose>{inside}</collision>"


def a_box(size):
    return f"<box><size>{size}</size></box>"


def a_ball(radius):
    return f"<sphere><radius>{radius}</radius></sphere>"


def a_cylinder(radius, length):
    return f"<cylinder><radius>{radius}</radius><length>{length}</length></cylinder>"


def friction(mu, mu2=None, more=""):
    return f"<friction><ode><mu>{mu}</mu><mu2>{mu if mu2 is None else mu2}</mu2>{more}</ode></friction>"


def body(name, pose, shape, surface="", mass=1, moment=0.05, more="", static=0):
    return (
        f"<model name='{name}'><static>{static}</static><pose>{pose}</pose><link name='link'>{inertia(mass, moment)}"
        f"{collision(shape, surface)}{more}</link></model>"
    )


def link(name, pose, mass=1, moment=0.02, inside=""):
    return f"<link name='{name}'><pose>{pose}</pose>{inertia(mass, moment)}{inside}</link>"


def joint(name, kind, parent, child, axis="0 1 0", limits="", dynamics="<damping>.3</damping>", pose="0 0 0 0 0 0"):
    bounds = f"<limit>{limits}</limit>" if limits else ""
    turning = f"<axis><xyz>{axis}</xyz>{bounds}<dynamics>{dynamics}</dynamics></axis>" if kind not in ("fixed",) else ""
    return (
        f"<joint name='{name}' type='{kind}'><pose>{pose}</pose><parent>{parent}</parent><child>{child}</child>"
        f"{turning}</joint>"
    )


def sloped(degrees, mu, shape, surface=None):
    """A body on a plank that is tilted."""
    angle = math.radians(degrees)
    x, z = 0.15 * math.sin(angle), 0.15 * math.cos(angle)
    plank = body("plank", f"0 0 0 0 {angle:.9f} 0", a_box("8 2 .1"), friction(mu), static=1)
    own = friction(mu) if surface is None else surface
    return world(plank, body("a", f"{x:.9f} 0 {z:.9f} 0 {angle:.9f} 0", shape, own), tolerance=TOUCHING)


def with_settings(beside, old, new):
    return replace(beside, text=beside.text.replace(old, new))


def chain(kind, count, axis="0 1 0", dynamics="<damping>.3</damping>", limits=""):
    """Links side by side that hang from the world."""
    parts = "".join(link(f"l{i}", f"{0.3 * i + 0.15} 0 2 0 0 0") for i in range(count))
    joints = "".join(
        joint(f"j{i}", kind, f"l{i - 1}" if i else "world", f"l{i}", axis, limits, dynamics, "-.15 0 0 0 0 0")
        for i in range(count)
    )
    return f"<model name='chain'>{parts}{joints}</model>"


# Robots --------------------------------------------------------------------------------------------------------------


def an_arm(count, damping=2, start=0.0, limits="<lower>-2</lower><upper>2</upper><effort>200</effort>"):
    """Joints across each other, on a foot that is fixed to the world."""
    axes = ("0 0 1", "0 1 0", "0 1 0", "1 0 0", "0 1 0", "0 0 1", "1 0 0")
    parts = link("l0", "0 0 .1 0 0 0", 4, 0.1, collision(a_cylinder(0.1, 0.2)))
    parts += "<joint name='foot' type='fixed'><parent>world</parent><child>l0</child></joint>"
    for i in range(1, count + 1):
        size = a_box(".06 .06 .18")
        parts += link(f"l{i}", f"{start * i:.6f} 0 {0.2 * i + 0.1} 0 {start:.6f} 0", 1, 0.01, collision(size))
        parts += joint(
            f"j{i}",
            "revolute",
            f"l{i - 1}",
            f"l{i}",
            axes[i % 7],
            limits,
            f"<damping>{damping}</damping>",
            "0 0 -.1 0 0 0",
        )
    return f"<model name='arm'>{parts}</model>"


def a_base(height=0.15):
    return link("base", f"0 0 {height} 0 0 0", 5, 0.1, box_collision(".5 .3 .1"))


def a_caster(x):
    return link("caster", f"{x} 0 .05 0 0 0", 0.2, 0.001, collision(a_ball(0.05), friction(0, 0))) + joint(
        "cj", "ball", "base", "caster", dynamics=""
    )


def rolling(name, inside, pose="0 0 0 0 0 0"):
    return f"<model name='{name}'><pose>{pose}</pose>{inside}</model>"


def ackermann():
    """Two steered wheels in front and two behind."""
    parts = a_base()
    for name, (x, y) in FOUR.items():
        ahead = name.endswith("front")
        if ahead:
            parts += link(f"{name}s", f"{x} {y} .1 0 0 0", 0.3, 0.002)
            parts += joint(f"{name}k", "revolute", "base", f"{name}s", "0 0 1", "<lower>-.5</lower><upper>.5</upper>")
        parts += wheel(name, x, y).replace("<parent>base", f"<parent>{name}s" if ahead else "<parent>base")
    return rolling("car", parts)


def legged(name, places, height=0.5, knees=True, stiffness=300, damping=2):
    """A trunk on legs whose hips and knees have springs."""
    spring = (
        f"<damping>{damping}</damping><spring_stiffness>{stiffness}</spring_stiffness>"
        "<spring_reference>0</spring_reference>"
    )
    parts = link("trunk", f"0 0 {height} 0 0 0", 8, 0.2, box_collision(".6 .3 .12"))
    for number, (x, y) in enumerate(places):
        length = (height - 0.06) / 2 if knees else height - 0.06
        z = height - length / 2
        parts += link(f"thigh{number}", f"{x} {y} {z:.6f} 0 0 0", 0.6, 0.02)
        parts += joint(
            f"hip{number}", "revolute", "trunk", f"thigh{number}", "0 1 0", "", spring, f"0 0 {length / 2:.6f} 0 0 0"
        )
        foot = f"thigh{number}"
        if knees:
            foot = f"shank{number}"
            parts += link(foot, f"{x} {y} {z - length:.6f} 0 0 0", 0.3, 0.02)
            parts += joint(
                f"knee{number}", "revolute", f"thigh{number}", foot, "0 1 0", "", spring, f"0 0 {length / 2:.6f} 0 0 0"
            )
        parts += link(f"foot{number}", f"{x} {y} .05 0 0 0", 0.1, 0.0005, collision(a_ball(0.05), friction(0.9)))
        parts += f"<joint name='sole{number}' type='fixed'><parent>{foot}</parent><child>foot{number}</child></joint>"
    return rolling(name, parts)


CORNERS = ((0.25, 0.15), (0.25, -0.15), (-0.25, 0.15), (-0.25, -0.15))
SIX = (*CORNERS, (0, 0.2), (0, -0.2))


def rotors(count):
    """A body with rotors that spin freely."""
    parts = link("base", "0 0 .2 0 0 0", 1.5, 0.02, collision(a_box(".3 .3 .1"), friction(1)))
    for i in range(count):
        angle = 2 * math.pi * i / count + 0.3
        x, y = 0.3 * math.cos(angle), 0.3 * math.sin(angle)
        parts += link(f"r{i}", f"{x:.6f} {y:.6f} .26 0 0 0", 0.01, 0.0001)
        parts += joint(f"j{i}", "revolute", "base", f"r{i}", "0 0 1", dynamics="<damping>1e-5</damping>")
    return rolling("copter", parts)


EXPLICIT = "<explicit_gyroscopic>true</explicit_gyroscopic>"  # as Gazebo's copy of ODE


def tumbling(*rotors):
    """A body with unequal moments of inertia that turns freely, and thin rotors on it, by their axes."""
    moments = "<ixx>.1</ixx><iyy>.25</iyy><izz>.3</izz><ixy>.01</ixy><ixz>-.02</ixz><iyz>.015</iyz>"
    parts = (
        f"<link name='base'><inertial><pose>.05 -.02 .03 .1 .2 .3</pose><mass>2</mass><inertia>{moments}</inertia>"
        "</inertial></link>"
    )
    for i, axis in enumerate(rotors):
        parts += (
            f"<link name='r{i}'><pose>{i - 0.5} .1 .1 .2 0 {i}</pose><inertial><mass>.05</mass><inertia><ixx>1e-6</ixx>"
            f"<iyy>2.73e-3</iyy><izz>2.73e-3</izz></inertia></inertial></link>"
            f"{joint(f'j{i}', 'revolute', 'base', f'r{i}', axis, dynamics='<damping>1e-4</damping>')}"
        )
    velocity = plugin("InitialVelocityPlugin", "<linear>0 0 .3</linear><angular>3 .2 4</angular>")
    return f"<model name='m'><pose>0 0 5 .3 .2 .1</pose>{parts}{velocity}</model>"


def gripper():
    """Two fingers that springs close around a box."""
    parts = link("palm", "0 0 .8 0 0 0", 2, 0.02)
    parts += "<joint name='held' type='fixed'><parent>world</parent><child>palm</child></joint>"
    for side in (1, -1):
        parts += link(
            f"finger{side}", f"0 {0.06 * side} .7 0 0 0", 0.2, 0.001, collision(a_box(".05 .02 .2"), friction(1))
        )
        spring = "<damping>5</damping><spring_stiffness>400</spring_stiffness>"
        spring += f"<spring_reference>{-0.05 * side}</spring_reference>"
        parts += joint(f"j{side}", "prismatic", "palm", f"finger{side}", "0 1 0", "", spring)
    return rolling("gripper", parts) + body("held", "0 0 .65 0 0 0", a_box(".06 .08 .06"), friction(1), 0.1, 0.0002)


def humanoid():
    """A standing figure: legs, trunk, arms, head; springs hold its joints."""
    legs = legged("figure", ((0, 0.1), (0, -0.1)), 0.8, True, 600, 3).removesuffix("</model>")
    legs = legs.replace(collision(a_ball(0.05), friction(0.9)), collision(a_box(".3 .12 .1"), friction(0.9)))
    parts = link("head", "0 0 1.3 0 0 0", 1, 0.01, collision(a_ball(0.1)))
    parts += joint(
        "neck", "revolute", "trunk", "head", "0 0 1", "<lower>-1</lower><upper>1</upper>", pose="0 0 -.2 0 0 0"
    )
    for side in (1, -1):
        parts += link(f"arm{side}", f"0 {0.3 * side} .7 0 0 0", 1, 0.01)
        parts += joint(f"shoulder{side}", "revolute", "trunk", f"arm{side}", pose="0 0 .2 0 0 0")
    return f"{legs}{parts}</model>"


def urdf(name, links, joints):
    """A robot description."""
    return f"<robot name='{name}'>{links}{joints}</robot>"


def urdf_link(name, mass, moment, shape="", pose="0 0 0"):
    touch = f"<collision><origin xyz='{pose}'/><geometry>{shape}</geometry></collision>" if shape else ""
    return (
        f"<link name='{name}'><inertial><origin xyz='{pose}'/><mass value='{mass}'/><inertia ixx='{moment}' ixy='0' "
        f"ixz='0' iyy='{moment}' iyz='0' izz='{moment}'/></inertial>{touch}</link>"
    )


def urdf_joint(name, kind, parent, child, place, axis="0 1 0", limits="lower='-2' upper='2'", rpy="0 0 0"):
    return (
        f"<joint name='{name}' type='{kind}'><origin xyz='{place}' rpy='{rpy}'/><parent link='{parent}'/><child "
        f"link='{child}'/><axis xyz='{axis}'/><limit {limits} effort='100' velocity='10'/><dynamics damping='1'/>"
        "</joint>"
    )


def urdf_arm(count):
    links = "<link name='world'/>"
    links += "".join(urdf_link(f"l{i}", 1, 0.01, "<box size='.06 .06 .2'/>", "0 0 .1") for i in range(count))
    joints = urdf_joint("foot", "fixed", "world", "l0", "0 0 .1")
    joints += "".join(
        urdf_joint(f"j{i}", "revolute", f"l{i - 1}", f"l{i}", "0 0 .2", ("1 0 0", "0 1 0")[i % 2], rpy="0 .3 0")
        for i in range(1, count)
    )
    return urdf("arm", links, joints)


def urdf_rover(wheels):
    links = urdf_link("base", 5, 0.1, "<box size='.5 .3 .1'/>")
    joints = ""
    for i, (x, y) in enumerate(wheels):
        links += urdf_link(f"w{i}", 0.5, 0.002, "<sphere radius='.1'/>")
        joints += urdf_joint(f"j{i}", "continuous", "base", f"w{i}", f"{x} {y} -.05", limits="lower='0' upper='0'")
    return urdf("rover", links, joints)


CONFIG = "<model><name>robot</name><version>1.0</version><sdf>robot.urdf</sdf></model>"


def described(text, *parts, pose="0 0 0 0 0 0", tolerance=NEAR):
    """A world that includes a robot description."""
    include = f"<include><name>robot</name><uri>model://robot</uri><pose>{pose}</pose></include>"
    return replace(
        world(*parts, include, tolerance=tolerance), files={"robot/model.config": CONFIG, "robot/robot.urdf": text}
    )


THROWN = "<velocity_decay><linear>.01</linear><angular>.02</angular></velocity_decay>"
SOFT = "<contact><ode><kp>{}</kp><kd>{}</kd><max_vel>{}</max_vel><min_depth>{}</min_depth></ode></contact>"
BOUNCE = (
    "<bounce><restitution_coefficient>{}</restitution_coefficient><threshold>.1</threshold></bounce><contact><ode>"
    "<max_vel>100</max_vel><kp>1e6</kp><kd>1e3</kd></ode></contact>"
)
SHAPES = {"box": a_box(".4 .3 .2"), "ball": a_ball(0.2), "cylinder": a_cylinder(0.2, 0.2)}
FALLING = world(GROUND, body("a", "0 0 .5 0 0 0", SHAPES["box"]), tolerance=NEAR)

SCENES = {
    **{
        f"{name} falls": world(GROUND, body("a", "0 0 .5 0 0 .3", shape), tolerance=NEAR)
        for name, shape in SHAPES.items()
    },
    **{
        f"stack of {count}": world(
            GROUND,
            *(body(f"b{i}", f"0 0 {0.1 + 0.2 * i} 0 0 0", a_box(".3 .3 .2")) for i in range(count)),
            tolerance=NEAR,
        )
        for count in (2, 3, 5)
    },
    "pyramid": world(
        GROUND,
        *(
            body(f"b{i}{k}", f"{0.32 * k + 0.16 * i} 0 {0.1 + 0.2 * i} 0 0 0", a_box(".3 .3 .2"))
            for i in range(3)
            for k in range(3 - i)
        ),
        tolerance=NEAR,
    ),
    **{
        f"slope of {angle} degrees, mu {mu}": sloped(angle, mu, SHAPES["box"])
        for angle, mu in ((10, 0.5), (20, 0.5), (30, 0.3), (30, 0.9), (15, 0.1))
    },
    "ball down a slope": sloped(10, 0.8, a_ball(0.1)),
    "frictionless slope": sloped(20, 0, SHAPES["box"]),
    **{
        f"bounce {bounce}": world(
            body("floor", "0 0 -.1 0 0 0", a_box("9 9 .2"), BOUNCE.format(bounce), static=1),
            body("a", "0 0 1 0 0 0", a_ball(0.1), BOUNCE.format(bounce)),
            tolerance=NEAR,
        )
        for bounce in (0.3, 0.8)
    },
    **{
        f"soft ground {kp:g} {kd:g}": world(
            GROUND, body("a", "0 0 .5 0 0 0", SHAPES["box"], SOFT.format(kp, kd, 100, 0)), tolerance=NEAR
        )
        for kp, kd in ((1e4, 100), (1e5, 1000), (1e6, 1))
    },
    "depth and max_vel": world(
        GROUND, body("a", "0 0 .3 0 0 0", SHAPES["box"], SOFT.format(1e12, 1, 0.1, 0.002)), tolerance=NEAR
    ),
    **{f"chain of {count}": world(chain("revolute", count), tolerance=NEAR) for count in (1, 2, 3, 4)},
    "stiff chain": world(chain("revolute", 3, dynamics="<damping>5</damping>"), tolerance=NEAR),
    "chain with friction": world(
        chain("revolute", 2, dynamics="<friction>1</friction><damping>.5</damping>"), tolerance=NEAR
    ),
    "chain with springs": world(
        chain("revolute", 3, dynamics="<damping>1</damping><spring_stiffness>30</spring_stiffness>"), tolerance=NEAR
    ),
    "chain with limits": world(chain("revolute", 2, limits="<lower>-.2</lower><upper>.5</upper>"), tolerance=NEAR),
    "chain of balls": world(chain("ball", 2), tolerance=NEAR),
    "chain of universals": world(
        chain("universal", 2).replace(
            "</axis>", "</axis><axis2><xyz>0 0 1</xyz><dynamics><damping>.3</damping></dynamics></axis2>"
        ),
        tolerance=NEAR,
    ),
    "slider": world(chain("prismatic", 1, "0 0 1", limits="<lower>-.4</lower><upper>.4</upper>"), tolerance=NEAR),
    "slanted slider": world(chain("prismatic", 1, "1 0 1", "<damping>2</damping>"), tolerance=NEAR),
    "spinning": world(
        rolling(
            "top",
            link("a", "0 0 3 .3 0 0", 1, 0.05)
            + link("b", "0 0 3.2 .3 0 0", 0.2, 0.02)
            + joint("j", "revolute", "a", "b", "0 0 1", dynamics=""),
        ),
        gravity="0 0 -1",
        tolerance=NEAR,
    ),
    **{
        f"gravity {gravity}": world(GROUND, body("a", "0 0 .5 0 0 0", SHAPES["box"]), gravity=gravity, tolerance=NEAR)
        for gravity in ("0 0 -1.6", "0 0 -24", "1 0 -9.8")
    },
    "gravity aside": world(GROUND, body("a", "0 0 .101 0 0 0", SHAPES["box"]), gravity="3 0 -9.8", tolerance=TOUCHING),
    "without gravity": world(
        body("a", "0 0 .5 0 0 0", SHAPES["box"], more="<gravity>0</gravity>"),
        body("b", "0 0 .95 0 0 0", a_box(".2 .2 .2")),
        tolerance=TOUCHING,
    ),
    "kinematic": world(
        body("a", "0 0 .5 0 0 0", a_box("2 2 .2"), more="<kinematic>1</kinematic>"),
        body("b", "0 0 .9 0 0 0", a_box(".2 .2 .2")),
        tolerance=NEAR,
    ),
    "velocity decay": world(GROUND, body("a", "0 0 .5 0 0 0", a_ball(0.1), more=THROWN), tolerance=NEAR),
    **{
        f"{what}": with_settings(FALLING, "<max_step_size>0.001", f"<max_step_size>{step}")
        for what, step in (("steps of 2 ms", 0.002), ("steps of 4 ms", 0.004), ("steps of 0.5 ms", 0.0005))
    },
    **{
        f"solver {what}": with_settings(
            world(
                GROUND,
                *(body(f"b{i}", f"0 0 {0.1 + 0.2 * i} 0 0 0", a_box(".3 .3 .2")) for i in range(3)),
                tolerance=NEAR,
            ),
            "<physics type='ode'>",
            f"<physics type='ode'><ode><solver>{solver}</solver><constraints>{constraints}</constraints></ode>",
        )
        for what, solver, constraints in (
            ("of 20 iterations", "<type>quick</type><iters>20</iters>", ""),
            ("of 200 iterations", "<type>quick</type><iters>200</iters>", ""),
            ("with sor 1", "<type>quick</type><sor>1</sor>", ""),
            ("with erp .8", "<type>quick</type>", "<cfm>0</cfm><erp>.8</erp>"),
            ("with cfm", "<type>quick</type>", "<cfm>.001</cfm><erp>.2</erp>"),
            ("world", "<type>world</type>", ""),
        )
    },
    **{
        f"{what} rolls": world(
            GROUND, body("a", f"0 0 .2 {roll} 0 0", SHAPES[what], friction(1)), gravity="1 0 -9.8", tolerance=TOUCHING
        )
        for what, roll in (("ball", 0), ("cylinder", math.pi / 2))
    },
    "slides": world(
        GROUND, body("a", "0 0 .1 0 0 0", SHAPES["box"], friction(0.1)), gravity="3 1 -9.8", tolerance=TOUCHING
    ),
    "two frictions": world(
        GROUND, body("a", "0 0 .1 0 0 0", SHAPES["box"], friction(0.1, 0.2)), gravity="3 3 -9.8", tolerance=TOUCHING
    ),
    "off centre": world(
        GROUND,
        body("a", "0 0 .5 0 0 0", SHAPES["ball"]).replace("<inertial>", "<inertial><pose>.05 .02 -.03 0 0 0</pose>", 1),
        tolerance=TOUCHING,
    ),
    "nested models": world(
        rolling(
            "outer", link("a", "0 0 2 0 0 0") + rolling("inner", link("b", ".3 0 0 0 0 0"), "0 0 2 0 0 0")
        ).removesuffix("</model>")
        + joint("j", "revolute", "world", "a", pose="-.2 0 0 0 0 0")
        + joint("k", "revolute", "a", "inner::b", pose="-.15 0 0 0 0 0")
        + "</model>",
        tolerance=NEAR,
    ),
    "see-saw": world(
        GROUND,
        rolling(
            "saw",
            link("post", "0 0 .2 0 0 0", 5, 1, collision(a_box(".1 .5 .4")))
            + link("plank", "0 0 .45 0 0 0", 2, 0.3, collision(a_box("2 .4 .05")))
            + joint("j", "revolute", "post", "plank", limits="<lower>-.3</lower><upper>.3</upper>"),
        ),
        body("load", "-.8 0 .6 0 0 0", a_box(".2 .2 .2")),
        tolerance=TOUCHING,
    ),
    "door": world(
        rolling(
            "door",
            link("wing", ".5 0 1 0 0 0", 10, 1, collision(a_box("1 .05 2")))
            + joint(
                "hinge",
                "revolute",
                "world",
                "wing",
                "0 .1 1",
                "<lower>-1.5</lower><upper>1.5</upper>",
                "<damping>1</damping>",
                "-.5 0 0 0 0 0",
            ),
        ),
        tolerance=NEAR,
    ),
    "stops with erp and cfm": world(
        chain("revolute", 1, limits="<lower>-.2</lower><upper>.5</upper>").replace(
            "</axis>", "</axis><physics><ode><limit><cfm>.01</cfm><erp>.4</erp></limit></ode></physics>"
        ),
        tolerance=NEAR,
    ),
    "starts beyond its limits": world(
        chain("revolute", 1, limits="<lower>.3</lower><upper>.8</upper>"), tolerance=NEAR
    ),
    "chain beyond its limits": world(chain("revolute", 3, limits="<lower>.1</lower><upper>.8</upper>"), tolerance=NEAR),
    "slider beyond its limits": world(
        chain("prismatic", 1, "0 0 1", limits="<lower>.2</lower><upper>.4</upper>"), tolerance=NEAR
    ),
}

ROBOTS = {
    **{f"arm of {count}": world(an_arm(count, 4, 0.1), tolerance=NEAR) for count in (2, 4, 6, 7)},
    "arm beyond its limits": world(
        an_arm(3, start=0.1, limits="<lower>.2</lower><upper>1</upper><effort>200</effort>"), tolerance=NEAR
    ),
    "two wheels and a caster": world(
        GROUND,
        rolling("dd", a_base() + wheel("left", 0.1, 0.2) + wheel("right", 0.1, -0.2) + a_caster(-0.2)),
        tolerance=NEAR,
    ),
    "four wheels": world(
        GROUND, rolling("skid", a_base() + "".join(wheel(n, *p) for n, p in FOUR.items())), tolerance=NEAR
    ),
    "four wheels on a slope": world(
        body("plank", "0 0 -.0513 0 .1 0", a_box("20 2 .1"), friction(1), static=1),
        rolling("skid", a_base() + "".join(wheel(n, *p) for n, p in FOUR.items()), "0 0 .02 0 .1 0"),
        tolerance=TOUCHING,
    ),
    "ackermann": world(GROUND, ackermann(), tolerance=NEAR),
    "quadruped": world(GROUND, legged("dog", CORNERS), tolerance=TOUCHING),
    "quadruped without knees": world(GROUND, legged("table", CORNERS, 0.4, False), tolerance=TOUCHING),
    "hexapod": world(GROUND, legged("insect", SIX, 0.4), tolerance=TOUCHING),
    "quadrotor": world(GROUND, rotors(4), tolerance=NEAR),
    "hexarotor in the air": world(
        rotors(6).replace("<pose>0 0 0 0 0 0</pose>", "<pose>0 0 9 .2 .1 0</pose>", 1), tolerance=NEAR
    ),
    "tumbling": world(tumbling(), solver=EXPLICIT, tolerance=1e-9),
    "tumbling, exact solver": world(tumbling(), solver=f"<type>world</type>{EXPLICIT}", tolerance=1e-9),
    "tumbling with rotors": world(tumbling(".1 0 1", "0 .2 1"), solver=EXPLICIT, tolerance=1e-5),
    "tumbling with rotors, exact solver": world(
        tumbling(".1 0 1", "0 .2 1"), solver=f"<type>world</type>{EXPLICIT}", tolerance=1e-9
    ),
    "gripper": world(gripper(), tolerance=TOUCHING),
    "humanoid": world(GROUND, humanoid(), tolerance=TOUCHING),
    **{f"described arm of {count}": described(urdf_arm(count)) for count in (2, 4, 6)},
    "described rover": described(urdf_rover(FOUR.values()), GROUND, pose="0 0 .15 0 0 0"),
    "described tricycle": described(urdf_rover(((0.2, 0), (-0.2, 0.2), (-0.2, -0.2))), GROUND, pose="0 0 .15 0 0 0"),
}
for scenes in (SCENES, ROBOTS):
    scenes.update({name: replace(scenes[name], tolerance=CREEPING) for name in CREEP if name in scenes})
