"""What visuals and scenes show beside shapes, visuals that become parts of others, and cameras that track."""

import math

import numpy as np
import pytest
from plugin_worlds import HINGE, body, collision

from libgz.base.errors import NotFoundError, ParameterError
from libgz.classic import rendering
from libgz.classic.math import Pose3d, Vector3d

BOX = "<geometry><box><size>1 1 1</size></box></geometry>"
LOOKS = f"<visual name='look'>{BOX}</visual>" + collision("<box><size>2 2 2</size></box>")


@pytest.fixture
def scene(run):
    run(body("robot", pose="1 2 3 0 0 0", link=LOOKS, gravity="false", inside=HINGE.format(name="h")))
    return rendering.get_scene("default")


def ends(scene):
    found = [lines.ends for lines in scene._lines_for(_View)]
    return np.concatenate(found) if found else np.zeros((0, 3))


class _View:
    class options:
        displayGrid = False


def test_aids_are_lines_where_things_are(scene):
    model = scene.GetVisual("robot")
    model.ShowCollision(True)
    assert ends(scene).max(axis=0) == pytest.approx((2, 3, 4))  # the collision's corner
    model.ShowCollision(False)
    assert len(ends(scene)) == 0
    model.ShowCOM(True)
    assert ends(scene).mean(axis=0) == pytest.approx((1, 2, 3))
    model.ShowCOM(False)
    model.ShowJoints(True)
    assert ends(scene).max(axis=0)[2] == pytest.approx(3.3)  # its axis, 0.3 m along z
    model.ShowJoints(False)
    model.ShowInertia(True)  # 1 kg, 1 kg m^2: a cube of sqrt(6) m
    assert np.ptp(ends(scene), axis=0) == pytest.approx((math.sqrt(6),) * 3, rel=1e-4)
    model.ShowInertia(False)
    model.ShowBoundingBox()
    assert np.ptp(ends(scene), axis=0) == pytest.approx((2, 2, 2), abs=1e-3)


def test_wireframes_are_edges_instead_of_faces(scene):
    visual = scene.GetVisual("robot::link::look")
    scene.SetWireframe(True)
    assert visual.Wireframe()
    assert not visual.geoms[0].appearance.visible
    assert np.ptp(ends(scene), axis=0) == pytest.approx((1, 1, 1), abs=1e-5)
    visual.SetVisible(False)
    assert len(ends(scene)) == 0
    visual.SetVisible(True)
    scene.SetWireframe(False)
    assert visual.geoms[0].appearance.visible
    assert len(ends(scene)) == 0


def test_aids_are_part_of_states(run):
    core, _ = run(body("robot", link=LOOKS, gravity="false"))
    scene = rendering.get_scene("default")
    before = core.get_state()
    scene.ShowLinkFrames(True)
    scene.SetWireframe(True)
    after = core.get_state()
    core.set_state(before)
    assert len(ends(scene)) == 0
    assert scene.GetVisual("robot::link::look").geoms[0].appearance.visible
    core.set_state(after)
    assert scene.GetVisual("robot").aids == ["frame"]
    assert len(ends(scene)) > 6


def test_visuals_of_plugins_become_parts_of_others(scene):
    lamp = rendering.Visual("lamp", scene)
    lamp.AttachMesh("unit_sphere")
    lamp.SetAmbient((1, 0, 0, 1))
    lamp.SetPose(Pose3d(0, 0, 1, 0, 0, 0))
    link = scene.GetVisual("robot::link")
    link.AttachVisual(lamp)
    assert lamp.WorldPose().Pos() == Vector3d(1, 2, 4)
    assert lamp.Ambient().R() == 1.0
    assert (lamp.GetDepth(), lamp.GetNthAncestor(1).Name()) == (3, "robot")
    assert scene.GetVisual("robot").IsAncestorOf(lamp)
    assert lamp.IsDescendantOf(link)
    assert not lamp.IsAncestorOf(link)
    assert lamp.GetMeshName() == "unit_sphere"
    link.DetachVisual("lamp")
    assert lamp.WorldPose().Pos() == Vector3d(0, 0, 1)
    with pytest.raises(ParameterError, match="not made by a plugin"):
        lamp.AttachVisual(link)
    with pytest.raises(NotFoundError, match="has no visual 'lmap'"):
        link.DetachVisual("lmap")
    scene.RemoveVisual("lamp")
    assert scene.GetVisual("lamp") is None


def test_a_line_is_drawn_between_two_points(scene):
    scene.DrawLine((0, 0, 0), (0, 0, 7), "way")
    scene.DrawLine((0, 0, 0), (0, 0, 5), "way")
    assert ends(scene).max() == pytest.approx(5.0)
    assert "way" in scene.PrintSceneGraph()


def test_a_camera_keeps_its_place_or_distance_to_what_it_tracks(run):
    _, world = run(body("robot", link=LOOKS, gravity="false"))
    camera = rendering.Camera(world, "eye", 32, 24)
    camera.SetWorldPose(Pose3d(-3, 0, 0, 0, 0, 0))
    camera.TrackVisual("robot")
    robot = world.ModelByName("robot")
    camera.SetTrackMinDistance(2.0)
    camera.SetTrackMaxDistance(4.0)
    robot.SetWorldPose(Pose3d(7, 0, 0, 0, 0, 0))
    camera.Update()
    assert camera.WorldPosition().X() == pytest.approx(3.0)
    robot.SetWorldPose(Pose3d(4, 0, 0, 0, 0, 0))
    camera.Update()
    assert camera.WorldPosition().X() == pytest.approx(2.0)
    camera.SetTrackIsStatic(True)
    camera.SetTrackInheritYaw(True)
    camera.SetTrackPosition((-5, 0, 3))
    robot.SetWorldPose(Pose3d(0, 0, 0, 0, 0, math.pi / 2))
    camera.Update()
    assert camera.WorldPosition().Equal(Vector3d(0, -5, 3), 1e-6)
    assert camera.Direction().Dot(Vector3d(0, 5, -3).Normalize()) == pytest.approx(1.0)
    camera.SetTrackUseModelFrame(False)
    camera.Update()
    assert camera.WorldPosition() == Vector3d(-5, 0, 3)
    assert camera.IsVisible("robot")
    camera.TrackVisual("")
    camera.Yaw(math.pi)
    assert not camera.IsVisible("robot")
