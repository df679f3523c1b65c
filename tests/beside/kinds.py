"""Worlds in the style of public ones: joints, surfaces, shapes, frames, includes, populations and actors of every kind.

Recorded from Gazebo 11.1 as all of tests/beside are. What is farther than a millimetre, and why, is in docs/sdf.md.
"""

# ruff: noqa: E501 - lines of SDF

import io
import math
from dataclasses import replace

import numpy as np
from PIL import Image

from beside.scenes import NEAR, a_ball, a_box, a_cylinder, body, collision, friction, link, rolling
from beside.worlds import GROUND, Beside, inertia, plugin, world

FIXED = "<joint name='fixed' type='fixed'><parent>world</parent><child>b</child></joint>"
BASE = link("b", "0 0 2 0 0 0") + FIXED
LOOSE = "<model><name>m</name><version>1.0</version><sdf version='1.6'>model.sdf</sdf></model>"  # a model.config


def near(*parts, tolerance=NEAR, version="1.6", files=None, **settings):
    made = world(*parts, tolerance=tolerance, **settings)
    return replace(made, text=made.text.replace("version='1.6'", f"version='{version}'", 1), files=files or {})


def axis(xyz="0 1 0", limits="", dynamics="", number="", more=""):
    bounds = f"<limit>{limits}</limit>" if limits else ""
    turning = f"<dynamics>{dynamics}</dynamics>" if dynamics else ""
    return f"<axis{number}><xyz>{xyz}</xyz>{bounds}{turning}{more}</axis{number}>"


def hinged(name, kind, parent, child, *inside, pose="0 0 0 0 0 0"):
    """A joint with any number of axes."""
    return (
        f"<joint name='{name}' type='{kind}'><pose>{pose}</pose><parent>{parent}</parent><child>{child}</child>"
        f"{''.join(inside)}</joint>"
    )


def between(low, high, more=""):
    return f"<lower>{low}</lower><upper>{high}</upper>{more}"


def damped(damping):
    return f"<damping>{damping}</damping>"


def sprung(stiffness, damping, reference=0):
    return (
        f"<damping>{damping}</damping><spring_stiffness>{stiffness}</spring_stiffness>"
        f"<spring_reference>{reference}</spring_reference>"
    )


def stopped(stiffness, dissipation):
    return f"<stiffness>{stiffness}</stiffness><dissipation>{dissipation}</dissipation>"


def of_ode(inside):
    return f"<physics><ode>{inside}</ode></physics>"


def pushed(model, linear="0 0 0", angular="0 0 0"):
    """A model that begins with velocities."""
    push = plugin("InitialVelocityPlugin", f"<linear>{linear}</linear><angular>{angular}</angular>")
    return model.removesuffix("</model>") + f"{push}</model>"


def centred(part, pose):
    """A link, or a model's first one, whose centre of mass is elsewhere."""
    return part.replace("<inertial>", f"<inertial><pose>{pose}</pose>", 1)


def swinging(kind, *inside, pose=".4 0 2 0 0 0", at="-.4 0 0 0 0 0"):
    """A link on a joint."""
    return near(rolling("m", BASE + link("c", pose) + hinged("j", kind, "b", "c", *inside, pose=at)))


def tilted(version, *axes, kind="revolute", at="-.4 0 0 0 .1 0"):
    """A link on a joint, all of them turned in each other."""
    parts = link("b", "0 0 2 .3 .2 .1") + FIXED + link("c", ".4 0 2 .5 .1 .7")
    model = rolling("m", parts + hinged("j", kind, "b", "c", *axes, pose=at), "0 0 0 .1 .2 .3")
    return near(model, version=version)


def threaded(version, *inside):
    parts = BASE + link("c", ".1 .05 1.8 .2 0 .3") + hinged("j", "screw", "b", "c", *inside)
    return near(rolling("m", parts, "0 0 0 .2 0 .5"), version=version)


def geared(ratio, limits="", pose="0 0 0 0 0 0"):
    """Two weights on hinges, and a gearbox between them."""
    parts = link("b", "0 0 0 0 0 0") + FIXED
    parts += centred(link("a", "0 0 .5 0 0 0", 1, 0.05), ".1 0 0 0 0 0")
    parts += centred(link("g", ".5 0 .5 0 0 0", 1, 0.03), ".05 0 .05 0 0 0")
    parts += hinged("ja", "revolute", "b", "a", axis(limits=limits)) + hinged("jg", "revolute", "b", "g", axis())
    words = f"<gearbox_ratio>{ratio}</gearbox_ratio><gearbox_reference_body>b</gearbox_reference_body>"
    parts += hinged("gear", "gearbox", "a", "g", words, axis(), axis(number="2"))
    return near(rolling("m", parts, pose))


def in_a_row(count, kind, more=""):
    """Links of 0.2 m that hang from the world."""
    parts = "".join(link(f"l{i}", f"{0.2 * i + 0.1:.1f} 0 3 0 0 0", 0.5, 0.005) for i in range(count))
    joints = "".join(
        hinged(f"j{i}", kind, f"l{i - 1}" if i else "world", f"l{i}", more, pose="-.1 0 0 0 0 0") for i in range(count)
    )
    return rolling("m", parts + joints)


BEYOND = link("c", ".4 0 2 0 0 0") + link("d", ".8 0 2 0 0 0", 0.5)
DOUBLE = BASE + BEYOND + hinged("j", "revolute", "b", "c", axis(dynamics=damped(0.5)), pose="-.4 0 0 0 0 0")
DOUBLE += hinged("k", "revolute", "c", "d", axis(), pose="-.2 0 0 0 0 0")
FOUR_BARS = (
    BASE.replace("0 0 2", "0 0 1") + link("p", "0 0 1.25 0 0 0", 1, 0.03) + link("q", ".3 0 1.5 0 0 0", 1, 0.03)
    + link("r", ".6 0 1.25 0 0 0", 1, 0.03) + link("w", ".6 0 1.6 0 0 0", 0.4, 0.004)
    + hinged("j1", "revolute", "b", "p", axis(), pose="0 0 -.25 0 0 0")
    + hinged("j2", "revolute", "p", "q", axis(dynamics=damped(0.1)), pose="-.3 0 0 0 0 0")
    + hinged("j3", "revolute", "q", "r", axis(), pose="0 0 .25 0 0 0")
    + hinged("j4", "revolute", "world", "r", axis(), pose="0 0 -.25 0 0 0") + hinged("jw", "fixed", "q", "w")
)  # fmt: skip
CRANK = (
    BASE.replace("0 0 2", "0 0 1") + link("crank", ".1 0 1 0 0 0", 1, 0.01) + link("rod", ".45 0 1 0 0 0")
    + link("slide", ".7 0 1 0 0 0", 2) + hinged("j1", "revolute", "b", "crank", axis(), pose="-.1 0 0 0 0 0")
    + hinged("j2", "revolute", "crank", "rod", axis(), pose="-.25 0 0 0 0 0")
    + hinged("j3", "revolute", "rod", "slide", axis())
    + hinged("j4", "prismatic", "world", "slide", axis("1 0 0", between(-1, 1)))
)  # fmt: skip
BALLS = (
    link("a", "0 0 2 0 0 0") + link("c", ".4 0 2 0 0 0") + link("d", ".4 .4 2 0 0 0")
    + hinged("j0", "ball", "world", "a") + hinged("j1", "ball", "a", "c", pose="-.2 0 0 0 0 0")
    + hinged("j2", "ball", "c", "d", pose="0 -.2 0 0 0 0") + hinged("j3", "ball", "world", "d")
)  # fmt: skip
RIGID = (
    link("a", "0 0 3 0 0 0", 1, 0.1) + link("b", ".5 .2 3 .3 0 0", 2, 0.05) + link("c", ".5 .2 3.4 .3 .5 0", 0.5)
    + hinged("f1", "fixed", "a", "b") + hinged("f2", "fixed", "b", "c")
)  # fmt: skip
INNERMOST = rolling("ii", link("c", "0 .3 0 0 0 0"), ".8 0 0 0 0 .2")
INNER = rolling(
    "i",
    link("b", ".4 0 0 0 0 0") + link("b2", ".8 0 0 0 0 0", 0.5)
    + hinged("ij", "revolute", "b", "b2", axis(dynamics=damped(0.2)), pose="-.2 0 0 0 0 0") + INNERMOST
    + hinged("iij", "prismatic", "b2", "ii::c", axis("0 1 0", between(-0.1, 0.1), damped(1))),
    "0 0 2 0 0 0",
)  # fmt: skip
NESTED = (
    link("a", "0 0 2 0 0 0") + INNER
    + hinged("w", "revolute", "world", "a", axis(dynamics=damped(0.1)), pose="-.2 0 0 0 0 0")
    + hinged("k", "universal", "a", "i::b", axis(), axis("0 0 1", number="2"), pose="-.2 0 0 0 0 0")
)  # fmt: skip

SLOW = "<physics type='ode'><max_step_size>.001</max_step_size><real_time_update_rate>0</real_time_update_rate><ode><constraints><contact_max_correcting_vel>10</contact_max_correcting_vel></constraints></ode></physics>"
LEG = (
    link("hip", "0 0 2 0 0 0", 1.2, 0.01, "") + link("calf", "0 0 1.8 0 0 0", 0.2, 0.002)
    + hinged("h", "revolute", "trunk", "hip", axis("1 .2 0", between(-1, 1), damped(0.3)), pose="0 0 .1 0 0 0")
    + hinged("k", "revolute", "hip", "calf", axis("0 1 0", between(-2.7, -0.84), damped(0.01)), pose="0 0 .1 0 0 0")
)  # fmt: skip
# Beyond a stop by so much that it would be left faster than contact_max_correcting_vel.
FAR = {
    "hinge far beyond its stop": near(
        rolling(
            "m",
            link("b", "0 0 2 0 0 0")
            + hinged("j", "revolute", "world", "b", axis("0 0 1", between(-3, -0.84), damped(0.01))),
        ),
        tolerance=1e-6,
    ),
    "hinge of the world on a link, far beyond its stop": near(
        rolling(
            "m",
            link("b", "0 0 2 0 0 0")
            + hinged("j", "revolute", "b", "world", axis("0 0 1", between(-3, -0.84), damped(0.01))),
        ),
        tolerance=1e-6,
    ),
    "universal far beyond its stops": near(
        rolling(
            "m",
            link("a", "0 0 2 0 0 0", 5, 0.05)
            + link("b", "0 0 1.8 0 0 0")
            + hinged(
                "j",
                "universal",
                "a",
                "b",
                axis("0 1 0", between(0.84, 2)),
                axis("1 0 0", between(-1.2, -0.7), number="2"),
            ),
            "0 0 30 0 0 0",
        ),
        tolerance=1e-3,
    ),
    "slider far beyond its stop": near(
        rolling(
            "m",
            link("b", "0 0 2 0 0 0")
            + hinged("j", "prismatic", "world", "b", axis("1 1 0", between(0.8, 4), damped(0.1))),
        ),
    ),
    "slider beyond its stop, corrected at 10 m/s": near(
        SLOW,
        rolling(
            "m",
            link("b", "0 0 2 0 0 0")
            + hinged("j", "prismatic", "world", "b", axis("1 0 0", between(0.2, 4), damped(1))),
        ),
        tolerance=1e-5,
    ),
    "leg whose knee is far beyond its stop": near(
        rolling("m", link("trunk", "0 0 2.1 0 0 0", 8, 0.1) + hinged("f", "fixed", "world", "trunk") + LEG)
    ),
    "falling leg whose knee is far beyond its stop": near(
        rolling("m", link("trunk", "0 0 2.1 0 0 0", 8, 0.1) + LEG, "0 0 30 0 0 0")
    ),
}

JOINTS = {
    **FAR,
    "screw with limits": threaded("1.6", axis("0 0 1", between(-1, 0.5)), "<thread_pitch>-8</thread_pitch>"),
    "screw with a spring": threaded("1.6", axis("0 .3 1", dynamics=sprung(5, 0.5, 1)), "<thread_pitch>-8</thread_pitch>"),
    "screw of 1.7": threaded("1.7", axis("0 0 1"), "<thread_pitch>-10</thread_pitch>"),
    **{f"gearbox of {ratio:g}": geared(ratio) for ratio in (1, -1.5, 0.4, 10)},
    "gearbox with limits": geared(-3, between(-0.3, 0.4)),
    "gearbox in a turned model": geared(-2, pose="1 2 3 .4 .3 1"),
    "universal with limits": swinging(
        "universal",
        axis(limits=between(-0.3, 0.3), dynamics=damped(0.2)),
        axis("0 0 1", between(-0.2, 0.2), damped(0.2), "2"),
        pose=".4 .1 2 0 .2 .1",
    ),
    "universal with springs": swinging(
        "universal", axis(dynamics=sprung(10, 0.5)), axis("1 0 0", "", sprung(3, 0.1, 0.2), "2"), at="-.4 0 .1 0 0 0"
    ),
    "universal with friction": swinging(
        "universal", axis(dynamics="<friction>1</friction>"), axis("1 0 0", number="2")
    ),
    "two axes of 1.4": tilted("1.4", axis(), axis("0 0 1", number="2"), kind="universal"),
    "revolute2, damped": swinging("revolute2", axis(dynamics=damped(0.5)), axis("1 0 0", "", damped(0.3), "2")),
    "revolute2, turned": swinging(
        "revolute2",
        axis(dynamics=damped(0.1)),
        axis("0 0 1", number="2"),
        pose=".3 .2 1.9 .4 .5 .6",
        at="-.3 0 .1 .2 0 .1",
    ),
    "revolute2 of 1.7": replace(
        tilted("1.7", axis(dynamics=damped(0.1)), axis("0 0 1", number="2"), kind="revolute2"), tolerance=NEAR
    ),
    "suspension": swinging(
        "revolute2",
        axis("0 0 1", between(-0.5, 0.5)),
        axis(number="2"),
        of_ode("<suspension><cfm>.01</cfm><erp>.3</erp></suspension>"),
    ),
    "ball with limits and damping": swinging("ball", axis(limits=between(-0.1, 0.1), dynamics=damped(0.5))),
    "five balls in a row": near(in_a_row(5, "ball")),
    **{
        f"stop of stiffness {stiffness:g}": swinging(
            "revolute", axis(limits=between(-0.2, 0.3, stopped(stiffness, damping)))
        )
        for stiffness, damping in ((100, 1), (1e5, 1))
    },
    "stop of a slider": swinging("prismatic", axis("0 0 1", between(-0.3, 0.3, stopped(500, 5)))),
    "effort and velocity limits": swinging(
        "revolute", axis(limits=between(-1.6, 1.6, "<effort>.5</effort><velocity>.7</velocity>"), dynamics=damped(0.05))
    ),
    "joint that bounces": swinging("revolute", axis(limits=between(-0.3, 0.5)), of_ode("<bounce>.5</bounce>")),
    "velocity and max_force": swinging(
        "revolute", axis(), of_ode("<velocity>1</velocity><max_force>2</max_force><fudge_factor>.5</fudge_factor>")
    ),
    "cfm_damping": swinging("revolute", axis(dynamics=damped(0.5)), of_ode("<cfm_damping>1</cfm_damping>")),
    "implicit_spring_damper": swinging(
        "revolute", axis(dynamics=sprung(20, 2)), of_ode("<implicit_spring_damper>1</implicit_spring_damper>")
    ),
    "slider on a spring": swinging("prismatic", axis("0 0 1", between(-0.1, 0.4), sprung(50, 1, 0.1))),
    **{
        f"hinge with friction {effort}": swinging("revolute", axis(dynamics=f"<friction>{effort}</friction>"))
        for effort in (5, 1.2)
    },
    "initial_position": swinging("revolute", axis(more="<initial_position>.4</initial_position>")),
    "use_parent_model_frame": tilted("1.6", axis(more="<use_parent_model_frame>1</use_parent_model_frame>")),
    "axis in the child's frame": tilted("1.6", axis()),
    "axis of 1.4": tilted("1.4", axis()),
    "four bars": near(rolling("m", FOUR_BARS)),
    "slider and crank": near(rolling("m", CRANK)),
    "loop of balls": near(rolling("m", BALLS)),
    "fixed joints in the air": near(pushed(rolling("m", RIGID), "1 0 2", "1 .5 .3")),
    "joints across nested models": near(rolling("o", NESTED, "0 0 1 0 0 .3")),
    "links without inertia": near(
        "<model name='m'><link name='a'><pose>0 0 2 0 0 0</pose></link><link name='c'><pose>.3 0 2 0 0 0</pose><inertial>"
        f"<mass>.5</mass></inertial></link>{hinged('w', 'revolute', 'world', 'a', axis(), pose='-.2 0 0 0 0 0')}"
        f"{hinged('k', 'revolute', 'a', 'c', axis(), pose='-.1 0 0 0 0 0')}</model>"
    ),
    "chain with velocity_decay": near(
        rolling(
            "m",
            DOUBLE.replace(
                "<pose>.4 0 2 0 0 0</pose>",
                "<pose>.4 0 2 0 0 0</pose><velocity_decay><linear>.005</linear><angular>.01</angular></velocity_decay>",
            ),
        )
    ),
    "chain whose link has no gravity": near(
        rolling("m", DOUBLE.replace("<pose>.4 0 2 0 0 0</pose>", "<pose>.4 0 2 0 0 0</pose><gravity>0</gravity>"))
    ),
}  # fmt: skip


# Surfaces and shapes -------------------------------------------------------------------------------------------------


def torsional(coefficient, patch, radius, surface):
    inside = f"<coefficient>{coefficient}</coefficient><use_patch_radius>{patch}</use_patch_radius>"
    inside += f"<patch_radius>{radius}</patch_radius><surface_radius>{surface}</surface_radius>"
    return friction(1).replace("</friction>", f"<torsional>{inside}</torsional></friction>")


def of_contact(inside):
    return f"<contact>{inside}</contact>"


def meshed(name, pose, file, scale="1 1 1", surface="", static=0):
    return body(name, pose, f"<mesh><uri>model://m/{file}</uri><scale>{scale}</scale></mesh>", surface, static=static)


def prism(sides, bottom, top, height):
    """An OBJ file of a prism that may narrow."""
    turns = [2 * math.pi * i / sides for i in range(sides)]
    rings = ((bottom, -height / 2), (top, height / 2))
    points = [(r * math.cos(turn), r * math.sin(turn), z) for r, z in rings for turn in turns]
    faces = [range(sides, 0, -1), range(sides + 1, 2 * sides + 1)]
    faces += [(i + 1, (i + 1) % sides + 1, (i + 1) % sides + 1 + sides, i + 1 + sides) for i in range(sides)]
    lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in points] + [f"f {' '.join(map(str, face))}" for face in faces]
    return "\n".join(lines) + "\n"


def ramp():
    """A text STL file of a wedge, 3 m long and 1 m high."""
    corners = ((0, -1, 0), (3, -1, 0), (3, 1, 0), (0, 1, 0), (3, -1, 1), (3, 1, 1))
    faces = ((0, 2, 1), (0, 3, 2), (0, 1, 4), (3, 5, 2), (1, 2, 5), (1, 5, 4), (0, 4, 5), (0, 5, 3))
    loops = ("".join("vertex {} {} {}\n".format(*corners[i]) for i in face) for face in faces)
    facets = "".join(f"facet normal 0 0 0\nouter loop\n{loop}endloop\nendfacet\n" for loop in loops)
    return f"solid ramp\n{facets}endsolid ramp\n"


def hills():
    """A PNG image of 33 x 33 heights."""
    y, x = np.mgrid[:33, :33]
    image = Image.fromarray((60 + 50 * np.sin(0.5 * x) * np.cos(0.4 * y)).astype(np.uint8))
    file = io.BytesIO()
    image.save(file, "PNG")
    return file.getvalue()


MESHES = {
    "m/model.config": LOOSE,
    "m/ramp.stl": ramp(),
    "m/hex.obj": prism(6, 0.2, 0.2, 0.3),
    "m/cone.obj": prism(16, 0.2, 0.05, 0.3),
}
FIELD = "<heightmap><uri>model://t/h.png</uri><size>8 8 1</size><pos>0 0 0</pos></heightmap>"
FIELDS = {"t/model.config": LOOSE, "t/h.png": hills()}
BOX, FLAT, BALL = a_box(".3 .3 .2"), a_box(".6 .6 .2"), a_ball(0.2)
FALLS = body("a", "0 0 .3 0 0 0", BOX)
POLYLINE = "".join(f"<point>{point}</point>" for point in ("-.2 -.2", ".3 -.2", ".2 .2", "-.1 .3"))
V = "<plane><normal>{} 0 .866</normal><size>9 9</size></plane>"
SLOPE = body("p", "0 0 0 .2 0 0", a_box("9 9 .1"), static=1)
FAN = f"{collision(a_box('.4 .2 .1'), friction(0.3))}{collision(a_ball(0.1), friction(1), '0 0 .15 0 0 0', 'd')}"
FINGERS = "".join(link(f"l{i}", f"{0.3 * i:.1f} 0 1 0 0 0", 0.5, 0.01, collision(a_box(".2 .1 .1"))) for i in (1, 2, 3))
FINGERS += "".join(
    hinged(
        f"j{i}", "revolute", f"l{i - 1}" if i > 1 else "b", f"l{i}", axis(dynamics=damped(0.3)), pose="-.15 0 0 0 0 0"
    )
    for i in (1, 2, 3)
)

RESTITUTION = "<bounce><restitution_coefficient>{}</restitution_coefficient><threshold>0</threshold></bounce>"
RESTITUTION += "<contact><ode><max_vel>100</max_vel><min_depth>{}</min_depth></ode></contact>"

SPRUNG = "<contact><ode><kp>{}</kp><kd>{}</kd><min_depth>{}</min_depth></ode></contact>"
SURFACES = {
    **{
        f"ball that bounces by {restitution}, min_depth {depth}": near(
            body("floor", "0 0 -.1 0 0 0", a_box("9 9 .2"), RESTITUTION.format(1, depth), static=1),
            body("a", "0 0 4 0 0 0", BALL, RESTITUTION.format(restitution, depth)),
            tolerance=1e-6,
        )
        for restitution, depth in ((0.7, 0), (0.5, 0.001))
    },
    # In the ground, on springs with dampers, from which Gazebo takes them without velocity, a share of the depth in each step.
    **{
        f"sunk {name} of {mass} kg on springs of {kp:g}, {kd:g}": near(
            GROUND,
            body("a", f"0 0 {high} 0 0 0", shape, SPRUNG.format(kp, kd, depth), mass, 0.0066 * mass),
            tolerance=2e-4,
        )
        for name, shape, high, mass, kp, kd, depth in (
            ("cube", a_box(".2 .2 .2"), 0.08, 1, 1e4, 1e3, 0.0),
            ("ball", a_ball(0.1), 0.08, 1, 1e4, 1e3, 0.0),
            ("lumber", a_box("1.2 .04 .09"), 0.0, 1.5, 1e4, 1e3, 0.001),
        )
    },
    "cube that sinks to its min_depth": near(
        GROUND, body("a", "0 0 .1 0 0 0", a_box(".2 .2 .2"), SPRUNG.format(1e6, 100, 0.03), 2, 0.0132), tolerance=1e-4
    ),
    "links that do not collide": near(GROUND, rolling("m", BASE.replace("0 0 2", "0 0 1") + FINGERS)),
    "groove of two planes": near(
        *(body(f"p{side}", "0 0 0 0 0 0", V.format(side), static=1) for side in (0.5, -0.5)),
        body("a", ".3 0 .8 0 0 0", BALL),
    ),
    **{
        f"torsion of {what}": near(
            GROUND, pushed(body("a", "0 0 .2 0 0 0", BALL, torsional(*values)), angular="0 0 5")
        )
        for what, values in {"a patch": (1, 1, 0.05, 0), "a surface": (0.7, 0, 0, 2), "little": (0.1, 1, 0.02, 0)}.items()
    },
    "box that spins": near(GROUND, pushed(body("a", "0 0 .1 0 0 0", BOX, friction(0.5)), angular="0 0 5")),
    "lying cylinder that spins": near(
        GROUND, pushed(body("a", "0 0 .1 1.5707963 0 0", a_cylinder(0.1, 0.4), friction(0.4)), angular="0 6 0")
    ),
    "ball on a height map": near(rolling("t", f"<static>1</static>{link('l', '0 0 0 0 0 0', inside=collision(FIELD))}"),
                                 body("a", ".4 .3 1.5 0 0 0", a_ball(0.15)), files=FIELDS),
    "ball on a ramp of triangles": near(
        meshed("r", "0 0 0 0 0 0", "ramp.stl", static=1), body("a", "2 0 1.2 0 0 0", a_ball(0.1)), files=MESHES
    ),
    "box on a ramp of triangles": near(
        meshed("r", "0 0 0 0 0 0", "ramp.stl", "1 1 1", friction(0.2), 1),
        body("a", "2 0 1 0 -.32 0", a_box(".2 .2 .1"), friction(0.2)),
        files=MESHES,
    ),
    "scaled mesh": near(GROUND, meshed("a", "0 0 1 0 0 0", "hex.obj", "1 2 .5"), files=MESHES),
    "mirrored mesh": near(GROUND, meshed("a", "0 0 .6 0 0 .3", "hex.obj", "-1 1 1"), files=MESHES),
    "mesh on a box": near(
        body("f", "0 0 .1 0 0 0", a_box("3 3 .2"), static=1), meshed("a", "0 0 .7 0 0 0", "hex.obj"), files=MESHES
    ),
    "cone of triangles": near(GROUND, meshed("a", "0 0 .5 0 0 0", "cone.obj"), files=MESHES),
    "polyline": near(GROUND, body("a", "0 0 .6 0 0 0", f"<polyline>{POLYLINE}<height>.3</height></polyline>")),
    "two collisions": near(
        GROUND, f"<model name='a'><pose>0 0 .5 0 0 0</pose><link name='l'>{inertia(2, 0.05)}{FAN}</link></model>"
    ),
    "collide_bitmask": near(
        GROUND,
        body("a", "0 0 .5 0 0 0", BOX, of_contact("<collide_bitmask>1</collide_bitmask>")),
        body("c", "0 0 1 0 0 0", BOX, of_contact("<collide_bitmask>2</collide_bitmask>")),
    ),
    "category_bitmask": near(
        GROUND,
        body(
            "a", "0 0 .5 0 0 0", BOX, of_contact("<collide_bitmask>6</collide_bitmask><category_bitmask>4</category_bitmask>")
        ),
    ),
    "collide_without_contact": near(
        GROUND, body("a", "0 0 .5 0 0 0", BOX, of_contact("<collide_without_contact>1</collide_without_contact>"))
    ),
    **{
        f"max_contacts {most}": near(
            GROUND, FALLS.replace("<collision name='c'>", f"<collision name='c'><max_contacts>{most}</max_contacts>")
        )
        for most in (0, 1)
    },
    "max_contacts 0 of a world": replace(
        near(GROUND, FALLS),
        text=near(GROUND, FALLS).text.replace("<max_step_size>", "<max_contacts>0</max_contacts><max_step_size>"),
    ),
    "soft_cfm": near(
        GROUND,
        body("a", "0 0 .3 0 0 0", BOX, of_contact("<ode><soft_cfm>.01</soft_cfm><soft_erp>.5</soft_erp></ode>")),
    ),
    "fdir1 along a slope": near(SLOPE, body("a", "0 -.03 .16 .2 0 0", BOX, friction(1, 0.02, "<fdir1>1 0 0</fdir1>"))),
    "fdir1 across a slope": near(SLOPE, body("a", "0 -.03 .16 .2 0 0", BOX, friction(0.02, 1, "<fdir1>0 1 0</fdir1>"))),
    "two balls meet": near(
        pushed(body("a", "-1 0 1 0 0 0", BALL, mass=2), "1 0 0"), body("c", "0 .05 1 0 0 0", BALL), gravity="0 0 0"
    ),
    "two boxes meet": near(
        pushed(body("a", "-1 0 1 0 0 0", a_box(".4 .4 .4"), mass=2), "1 0 0"),
        body("c", "0 0 1 0 0 0", a_box(".4 .4 .4")),
        gravity="0 0 0",
    ),
    "allow_auto_disable": near(
        GROUND,
        FALLS.replace("<pose>", "<allow_auto_disable>1</allow_auto_disable><pose>", 1),
        body("c", "0 0 2.4 0 0 0", a_ball(0.1)).replace("<pose>", "<allow_auto_disable>0</allow_auto_disable><pose>", 1),
    ),
    "static joints": near(
        GROUND,
        rolling(
            "s",
            "<static>1</static>" + link("a", "0 0 .5 0 0 0", inside=collision(a_box(".4 .4 1")))
            + link("d", ".5 0 .5 0 0 0") + hinged("j", "revolute", "a", "d", axis()),
        ),
        body("c", "0 0 1.5 0 0 0", BOX),
    ),
}  # fmt: skip


# Worlds and files ----------------------------------------------------------------------------------------------------

BOXED = f"<link name='link'>{inertia(1, 0.05)}{collision(a_box('.2 .2 .2'))}</link>"
INCLUDED = (
    f"<sdf version='1.6'><model name='mb'>{BOXED}{link('top', '.3 0 0 0 0 0', 1, 0.05)}"
    f"{hinged('j', 'revolute', 'link', 'top', axis())}</model></sdf>"
)
OUTER = (
    f"<sdf version='1.6'><model name='outer'>{link('base', '0 0 .5 0 0 0', 3, 0.1, collision(a_box('.5 .5 .2')))}<include>"
    "<uri>model://mb</uri><name>arm</name><pose>0 0 .8 0 0 .5</pose></include>"
    f"{hinged('k', 'revolute', 'base', 'arm::link', axis('0 0 1', '', damped(0.1)))}</model></sdf>"
)
FOLDERS = {"mb/model.config": LOOSE, "mb/model.sdf": INCLUDED, "outer/model.config": LOOSE, "outer/model.sdf": OUTER}
NEW_FOLDERS = {name: text.replace("sdf version='1.6'><m", "sdf version='1.7'><m") for name, text in FOLDERS.items()}
WITH_OUTER = "<include><uri>model://outer</uri><pose>1 2 0 0 0 .3</pose></include>"
THING = body("a", "0 0 5 0 0 0", a_ball(0.1))
POPULATED = f"<model name='b'><link name='l'>{inertia(1, 0.05)}{collision(a_ball(0.1))}</link></model>"
AROUND = ((0, "0 0 1.2 0 0 0"), (0.3, "1 0 1.2 0 0 1.57"), (0.9, "1 1 1.2 0 0 3.14"), (1.1, "0 1 1.2 0 0 -1.57"))
STATE = (
    "<state world_name='default'><sim_time>3 0</sim_time><model name='a'><pose>1 1 2 0 0 .5</pose><link name='link'>"
    "<pose>1 1 2 0 0 .5</pose><velocity>1 0 0 0 0 1</velocity></link></model></state>"
)
FRAMES = (
    "<frame name='f'><pose>0 0 2 0 .2 0</pose></frame><frame name='g' attached_to='f'><pose>.4 0 0 0 0 .3</pose></frame>"
    f"<link name='b'><pose relative_to='f'/>{inertia(1, 0.05)}</link><link name='c'><pose relative_to='g'>.1 0 0 0 0 0"
    f"</pose>{inertia(1, 0.02)}</link>{FIXED}<joint name='j' type='revolute'><pose relative_to='f'>0 0 .1 0 0 0</pose>"
    "<parent>b</parent><child>c</child><axis><xyz expressed_in='g'>0 1 0</xyz></axis></joint>"
)
OF_A_JOINT = (
    f"{BASE}<link name='c'><pose relative_to='j'>.4 0 0 0 0 0</pose>{inertia(1, 0.02)}</link><joint name='j' "
    "type='universal'><pose relative_to='b'>.1 0 .1 0 .2 0</pose><parent>b</parent><child>c</child><axis><xyz "
    "expressed_in='__model__'>0 1 0</xyz></axis><axis2><xyz expressed_in='b'>1 0 0</xyz></axis2></joint>"
)
OF_THE_WORLD = (
    "<frame name='w'><pose>1 2 3 .1 .2 .3</pose></frame><model name='a'><pose relative_to='w'>.1 .2 .3 0 0 0</pose><link "
    f"name='link'>{inertia(1, 0.05)}</link></model><frame name='v' attached_to='a'><pose>0 0 1 0 0 0</pose></frame><model "
    "name='c' canonical_link='y'><pose relative_to='v'/><link name='x'><pose relative_to='y'>1 0 0 0 0 0</pose>"
    f"{inertia(1, 0.05)}</link><link name='y'><pose>0 1 0 0 0 0</pose>{inertia(1, 0.05)}</link></model>"
)


def populated(kind, more=""):
    """Three models in a turned box, or rows and columns of them."""
    return near(
        GROUND,
        f"<population name='p'>{POPULATED}<pose>1 2 3 .3 .2 .4</pose><box><size>2 1 .5</size></box><model_count>3"
        f"</model_count><distribution><type>{kind}</type>{more}</distribution></population>",
    )


def walking(rows, words="", script="<loop>1</loop>"):
    """An actor on a way; bones are of floats."""
    way = "".join(f"<waypoint><time>{time}</time><pose>{pose}</pose></waypoint>" for time, pose in rows)
    made = near(
        "<actor name='w'><skin><filename>walk.dae</filename></skin><animation name='walking'><filename>walk.dae"
        f"</filename><interpolate_x>1</interpolate_x></animation><script>{script}<trajectory id='0' type='walking' {words}>"
        f"{way}</trajectory></script></actor>",
        tolerance=1e-5,
    )
    return replace(made, links=("w::w_pose",))


def settled(version, physics):
    """A ball that falls, in a world with its own `<physics>`."""
    return Beside(f"<sdf version='{version}'><world name='default'>{physics}{THING}</world></sdf>")


FAST = "<real_time_update_rate>0</real_time_update_rate>"
SOLVED = (
    pushed(body("a", "0 0 .1 0 0 0", BOX, friction(0.2)), "1 .5 0"),
    rolling("m", DOUBLE, "3 0 0 0 0 0"),
)
FILES = {
    "wind without a plugin": near(
        "<wind><linear_velocity>5 2 0</linear_velocity></wind>", THING.replace("<inertial>", "<enable_wind>1</enable_wind><inertial>")
    ),
    "gravity aside, and a magnetic field": near(
        "<magnetic_field>1e-5 2e-5 -4e-5</magnetic_field>", THING, gravity="1 -2 -3"
    ),
    "two kinds of physics": settled(
        "1.6",
        f"<physics name='slow' type='ode'><max_step_size>.002</max_step_size>{FAST}</physics><physics name='fast' default='1' "
        f"type='ode'><max_step_size>.0005</max_step_size>{FAST}</physics>",
    ),
    "gravity of 1.4": settled(
        "1.4", f"<physics type='ode'><gravity>0 0 -2</gravity><max_step_size>.001</max_step_size>{FAST}</physics>"
    ),
    "steps of 1.3": settled("1.3", f"<physics type='ode'><gravity>0 0 -5</gravity><max_contacts>10</max_contacts>{FAST}</physics>"),
    **{f"population along {name}": populated(f"linear-{name}") for name in "xy"},
    "population on a grid": populated("grid", "<rows>2</rows><cols>3</cols><step>.5 .4 0</step>"),
    "two models of a name": near(
        GROUND, body("a", "0 0 1 0 0 0", BOX), body("a", "2 0 1 0 0 0", BALL), body("ground", "4 0 1 0 0 0", BALL)
    ),
    "two kinds of physics of a name": settled(
        "1.6",
        f"<physics name='p' type='ode'><max_step_size>.002</max_step_size>{FAST}</physics><physics name='p' type='ode'>"
        f"<max_step_size>.0005</max_step_size>{FAST}</physics>",
    ),
    "includes": near(
        GROUND,
        "<include><name>one</name><uri>model://mb</uri><pose>0 0 1 0 0 0</pose><static>1</static></include>",
        WITH_OUTER,
        files=FOLDERS,
    ),
    "includes of 1.7": near(GROUND, WITH_OUTER, version="1.7", files=NEW_FOLDERS),
    "frames of a model": near(rolling("m", FRAMES, "1 0 0 0 0 .5"), version="1.7"),
    "frames of a joint": near(rolling("m", OF_A_JOINT, "0 0 0 .2 0 .5"), version="1.7"),
    "frames of the world": near(OF_THE_WORLD, version="1.7"),
    "state of a world": near(GROUND, body("a", "0 0 1 0 0 0", BOX), rolling("m", DOUBLE, "4 0 0 0 0 0"), STATE),
    "actor whose script loops": walking(
        ((0, "0 0 1.2 0 0 0"), (1, "1 0 1.2 0 0 0"), (1.5, "1 1 1.2 0 0 1.57")),
        script="<loop>1</loop><delay_start>.3</delay_start>",
    ),
    "actor whose way is closed": walking((*AROUND, (1.8, "0 0 1.2 0 0 0"))),
    "actor back where it began, turned": walking((*AROUND, (1.8, "0 0 1.2 0 0 .3"))),
    "actor with tension": walking((*AROUND, (1.8, "0 .5 1.2 .1 0 0")), "tension='.6'"),
    "actor whose first time is late": replace(
        walking(((0.5, "0 0 1.2 0 0 0"), (1, "1 0 1.2 0 0 0"), (2.5, "2 1 1.2 0 0 1"))), tolerance=1e-5
    ),
    **{
        f"solver with {what}": near(GROUND, *SOLVED, solver=words)
        for what, words in {
            "sor 1.9": "<type>quick</type><iters>100</iters><sor>1.9</sor>",
            "dynamic moments": "<use_dynamic_moi_rescaling>1</use_dynamic_moi_rescaling>",
            "cones": "<friction_model>cone_model</friction_model>",
        }.items()
    },
}  # fmt: skip

KINDS = {**JOINTS, **SURFACES, **FILES}
