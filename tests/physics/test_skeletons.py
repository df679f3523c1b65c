"""Skeletons of COLLADA files: bones, animations and skins against what their matrices say."""

import math
from pathlib import Path

import numpy as np
import pytest
from bone_files import two_bones

import libgz
from libgz.base.errors import GazeboError, ParameterError
from libgz.base.geometry import GzPose, GzQuatern, GzVector
from libgz.physics.body import Body
from libgz.physics.geoms import SkinGeom
from libgz.physics.mesh_files import read_mesh
from libgz.physics.skeletons import read_figure, turn_matrices

WALK = Path(libgz.__file__).parent / "sdf/media/models/walk.dae"


@pytest.fixture
def engine():
    """A world, for bodies."""
    with libgz.World() as world:
        yield world


@pytest.fixture
def figure_of(tmp_path):
    """The figure of a text."""

    def read(text):
        path = tmp_path / f"{len(list(tmp_path.iterdir()))}.dae"
        path.write_text(text)
        return read_figure(path)

    return read


def bent(figure, time, engine):
    """The vertices of a figure's skin at a time of its animation, with the root at the origin."""
    places, turns = figure.world(np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]), *figure.animations[0].at(time))
    bones = []
    for place, turn in zip(places.tolist(), turns.tolist(), strict=True):
        body = Body(engine, dummy=True)
        body.SetPose(GzPose(GzVector(*place), GzQuatern(*turn)))
        bones.append(body)
    skin = SkinGeom(Body(engine, dummy=True), figure.skin[0], bones)
    return skin.vertices


def test_bones_bend_their_skin(figure_of, engine):
    figure = figure_of(two_bones())
    assert figure.names == ("shoulder", "elbow")
    assert figure.parents == (-1, 0)
    rest, half, whole = (bent(figure, time, engine) for time in (0.0, 1.0, 2.0))
    np.testing.assert_allclose(rest, figure.skin[0].vertices, atol=1e-12)
    # the far end turns about the elbow at (1, 0, 0), a vertex at the elbow by linear blending
    for vertices, angle in ((half, math.pi / 4), (whole, math.pi / 2)):
        c, s = math.cos(angle), math.sin(angle)
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        far = rest[8:] - (1.0, 0.0, 0.0)
        np.testing.assert_allclose(vertices[8:], far @ turn.T + (1.0, 0.0, 0.0), atol=1e-9)
        near = rest[4:8] - (1.0, 0.0, 0.0)
        np.testing.assert_allclose(vertices[4:8], 0.5 * (near + near @ turn.T) + (1.0, 0.0, 0.0), atol=1e-9)
        np.testing.assert_allclose(vertices[:4], rest[:4], atol=1e-12)


@pytest.mark.parametrize(
    "options",
    [{"unit": 0.01}, {"armature": "<scale>2 2 2</scale>", "unit": 2.0}, {"target": "elbow/turn(3)"}],
)
def test_units_and_scales_leave_bones_of_one_metre(figure_of, engine, options):
    plain = bent(figure_of(two_bones()), 1.3, engine)
    figure = figure_of(two_bones(**options))
    if "armature" not in options:
        np.testing.assert_allclose(bent(figure, 1.3, engine), plain, atol=1e-9)
    else:
        assert figure.positions[1][0] == pytest.approx(2.0)


def test_a_whole_matrix_may_be_animated(figure_of, engine):
    keys = [np.eye(4), turn_matrices(np.array([[math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)]]))[0]]
    for key in keys:
        key[0, 3] = 1.0
    text = two_bones(target="elbow/m", angles=np.stack(keys)).replace(
        '<translate sid="place">1.0 0 0</translate>\n        <rotate sid="turn">0 0 1 0</rotate>',
        '<matrix sid="m">1 0 0 1 0 1 0 0 0 0 1 0 0 0 0 1</matrix>',
    )
    np.testing.assert_allclose(bent(figure_of(text), 1.3, engine), bent(figure_of(two_bones()), 1.3, engine), atol=1e-9)


def test_an_animation_begins_again_at_its_end(figure_of):
    motion = figure_of(two_bones()).animations[0]
    assert motion.length == 2.0
    for one, other in zip(motion.at(0.5), motion.at(4.5), strict=True):
        np.testing.assert_allclose(one, other)
    np.testing.assert_allclose(motion.at(9.0, loop=False)[1], motion.at(2.0)[1])


def test_the_way_along_x_chooses_the_pose():
    motion = read_figure(WALK).animations[0]
    step = float(motion.positions[-1, 0, 0])
    for share in (0.1, 0.55, 0.9):
        positions, _ = motion.at_x(share * step)
        assert positions[0][0] == pytest.approx(share * step)
        again, _ = motion.at_x(share * step + 3.0 * step)
        np.testing.assert_allclose(again, positions, atol=1e-9)


def test_the_walker_stands_on_the_ground():
    figure = read_figure(WALK)
    for time in (0.0, 0.31, 0.77, 1.2):
        positions, turns = figure.animations[0].at(time)
        places, rotations = figure.world(positions[0], turns[0], positions, turns)
        frames = turn_matrices(rotations)
        frames[:, :3, 3] = places
        low = high = 1.0
        for part in figure.skin:
            moved = (frames @ part.inverse_binds)[:, :3]
            points = np.concatenate([part.vertices, np.ones((len(part.vertices), 1))], axis=1)
            shown = np.einsum("nj,njab,nb->na", part.weights, moved[part.bones], points)
            low, high = min(low, shown[:, 2].min()), max(high, shown[:, 2].max())
        assert low == pytest.approx(0.0, abs=0.02)
        assert high == pytest.approx(1.7, abs=0.1)


def test_a_skinned_file_is_a_mesh_too():
    vertices = np.concatenate([part.vertices for part in read_mesh(WALK)])
    assert vertices[:, 2].min() == pytest.approx(0.0, abs=0.02)
    assert vertices[:, 2].max() == pytest.approx(1.7, abs=0.1)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (two_bones(names="shoulder knee"), "joint 'knee'"),
        (two_bones().replace("<vcount>1 ", "<vcount>7 "), "<vcount> and <v>"),
        (two_bones().replace('sid="shoulder" type="JOINT"', "").replace("JOINT", "NODE"), "JOINT"),
        (two_bones(angles=(0.0, math.nan)), "not finite"),
        (two_bones(skin=False).replace('type="JOINT"', ""), "has no skeleton"),
    ],
)
def test_damaged_files_are_errors_with_a_reason(figure_of, text, message):
    with pytest.raises(GazeboError, match=message):
        figure_of(text)


def test_bones_are_placed_by_those_before_them():
    figure = read_figure(WALK)
    positions, turns = figure.animations[0].at(0.3)
    root = turn_matrices(np.array([0.6, 0.0, 0.8, 0.0]))
    local = turn_matrices(turns)
    local[:, :3, 3] = positions
    expected = [root]
    for bone, parent in enumerate(figure.parents[1:], start=1):
        expected.append(expected[parent] @ local[bone])
    places, rotations = figure.world(np.zeros(3), np.array([0.6, 0.0, 0.8, 0.0]), positions, turns)
    found = turn_matrices(rotations)
    found[:, :3, 3] = places
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-14)


def test_a_pose_of_another_skeleton_is_refused(figure_of):
    figure = figure_of(two_bones())
    with pytest.raises(ParameterError, match="of 2 bones cannot have the pose of one of 1"):
        figure.world(np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]), figure.positions[:1], figure.turns)
