"""Frames of joints' axes, and axes that are missing: where Gazebo 11.1 has a swinging link after 200 iterations."""

import pytest
from plugin_worlds import worlds_of_elements

AXES = {
    "X": "<axis><xyz>1 0 0</xyz></axis>",
    "Y": "<axis2><xyz>0 1 0</xyz></axis2>",
    "U": "<axis><xyz>1 0 0</xyz><use_parent_model_frame>true</use_parent_model_frame></axis>",
    "V": "<axis2><xyz>0 1 0</xyz><use_parent_model_frame>true</use_parent_model_frame></axis2>",
    "S": "<axis><xyz>0 0.5 1</xyz></axis>",
    "T": "<axis><xyz>0 0.5 1</xyz><use_parent_model_frame>true</use_parent_model_frame></axis>",
    "0": "<axis><xyz>0 0 0</xyz></axis>",
}
# In a model whose pose is 0 0 0 0.3 0.2 0.5; kind, axes, and the pose of the link.
MEASURED = [
    ("revolute2", "XY", (0.633621972, -0.173361996, 1.488554495, 0.821666468, 0.461758403, 0.331928502, -0.038299641)),
    ("revolute2", "UV", (0.653586674, -0.174200295, 1.490891428, 0.862221768, 0.425700702, 0.264387388, 0.073836606)),
    ("universal", "", (0.579424532, -0.130228945, 1.537373094, 0.661740997, 0.559029127, 0.468054635, 0.174671536)),
    ("universal", "XY", (0.661348959, -0.166679548, 1.497557615, 0.862246545, 0.431458714, 0.231882685, 0.128859202)),
    ("universal", "UV", (0.633621972, -0.173361996, 1.488554495, 0.821666468, 0.461758403, 0.331928502, -0.038299641)),
    ("screw", "S", (0.695423236, -0.124769940, 1.566414675, 0.614806973, 0.778806358, 0.124243744, 0.006044401)),
    ("screw", "T", (0.619712219, -0.083359631, 1.525348119, 0.527561236, 0.680593528, 0.399291654, -0.314702666)),
    ("revolute", "", (0.668230497, -0.161970170, 1.503166953, 0.863487426, 0.429457954, 0.200709406, 0.172252911)),
    ("prismatic", "", (0.689038392, -0.087180515, 1.573153097, 0.592052138, 0.761261410, 0.255533801, 0.068248130)),
    ("universal", "X", (0.619499503, -0.319416378, 1.487015162, 0.637287847, -0.255436439, 0.544617021, 0.481672842)),
    ("revolute2", "X", (0.665300102, -0.162303357, 1.501879305, 0.862860409, 0.423657684, 0.210303242, 0.178209504)),
    ("revolute", "S", (0.619065209, -0.131243567, 1.524217297, 0.565074815, 0.636612372, 0.417668863, -0.317754405)),
    ("prismatic", "S", (0.642810184, -0.075623934, 1.575419627, 0.592052138, 0.761261410, 0.255533801, 0.068248130)),
    ("revolute", "0", (0.655379755, -0.179690460, 1.488285460, 0.848926701, 0.457567619, 0.261342608, -0.040686263)),
    ("prismatic", "0", (0.655379755, -0.105568313, 1.580927800, 0.592052138, 0.761261410, 0.255533801, 0.068248130)),
]  # fmt: skip
SOLVER = (
    "<physics type='ode'><max_step_size>0.001</max_step_size><ode><solver><type>world</type></solver></ode></physics>"
)


@pytest.fixture
def load():
    yield from worlds_of_elements()


@pytest.mark.parametrize(("kind", "axes", "expected"), MEASURED, ids=[f"{kind}-{axes}" for kind, axes, _ in MEASURED])
def test_a_link_swings_as_in_gazebo(load, kind, axes, expected):
    """`revolute2` and `screw` take their axes in the parent's model frame; ODE's defaults replace missing ones."""
    inside = "".join(AXES[axis] for axis in axes) + ("<thread_pitch>-20</thread_pitch>" if kind == "screw" else "")
    world, view = load(
        SOLVER,
        f"""<model name='m'><pose>0 0 0 0.3 0.2 0.5</pose><link name='b'><pose>0 0 2 0.2 0.1 0.3</pose></link>
        <joint name='f' type='fixed'><parent>world</parent><child>b</child></joint>
        <link name='c'><pose>0.2 0.1 1.7 1.5708 0 0</pose><inertial><mass>1</mass>
        <inertia><ixx>0.01</ixx><iyy>0.01</iyy><izz>0.01</izz></inertia></inertial></link>
        <joint name='j' type='{kind}'><pose>-0.1 0.05 0.1 0 0 0.3</pose><parent>b</parent>
        <child>c</child>{inside}</joint>
        </model>""",
    )
    world.step(200)
    pose = view.ModelByName("m").GetLink("c").WorldPose()
    tolerance = {"screw": 3e-5}.get(kind, 1e-6)  # a screw is a coupling of its own, which Debian's ODE does not have
    found = (*pose.pos, pose.rot.u, pose.rot.x, pose.rot.y, pose.rot.z)
    assert found == pytest.approx(expected, abs=tolerance)
