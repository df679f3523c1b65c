"""The camera models: their optics against formulas, their commands, what they serve and save."""

import itertools
import math
import time

import numpy as np
import pytest
from camera_worlds import LIGHT, ROBOT_WITH_CAMERA, solid, world_of
from PIL import Image

import libgz
from libgz.base.files import installed_worlds
from libgz.base.geometry import GzCoordPoseAdd, GzCoordPoseSub, GzPose, GzQuaternToEuler, GzVector, rotate
from libgz.interfaces.client import Client
from libgz.models import observercam
from libgz.models.observercam import SWITCHES


@pytest.mark.parametrize(("size", "fits"), [("320 240", True), ("640 480", False)])
def test_images_of_0x050_are_small(size, fits):
    cam = f"<model:MonoCam><id>cam</id><imageSize>{size}</imageSize></model:MonoCam>"
    if fits:
        with world_of(cam, wire_version=0x050) as world:
            world.step(10)
            assert world.interface("camera", "cam").image.shape == (240, 320, 3)
    else:
        with pytest.raises(libgz.GazeboError, match=r"model 'cam': imageSize 640 480 is not allowed.* 76800 pixels"):
            world_of(cam, wire_version=0x050)


# Optics ----------------------------------------------------------------------------------------------------------


def assert_corners_match(eye, center, size, turn):
    """The outline of a dark box before the sky is, in 32 directions, where its corners project to."""
    image = eye.image
    rows, columns = np.nonzero(image[:, :, 2] < 100)
    assert len(rows) > 200
    focal, projected = eye.width / (2 * math.tan(eye.hfov / 2)), []
    for signs in itertools.product((-0.5, 0.5), repeat=3):
        corner = GzCoordPoseAdd(
            GzPose(GzVector(*(s * n for s, n in zip(signs, size, strict=True)))), GzPose(center, turn)
        )
        x, y, z = GzCoordPoseSub(corner, eye.GetPose()).pos
        projected.append((eye.width / 2 - focal * y / x, eye.height / 2 - focal * z / x))
    for angle in np.arange(32) * math.pi / 16:
        way = np.array((math.cos(angle), math.sin(angle)))
        # A pixel is rendered if its middle is inside: the edge lies up to one pixel beyond the outermost middle.
        seen = (np.stack([columns + 0.5, rows + 0.5], axis=1) @ way).max() + 0.5 * np.abs(way).sum()
        assert seen == pytest.approx((np.array(projected) @ way).max(), abs=1.0), f"towards {way}"


@pytest.mark.parametrize("hfov", [40, 75])
def test_corners_of_a_box_lie_where_they_project_to(hfov):
    box = solid("3 0.4 -0.2", "0.5 0.6 0.7", "<rpy>0 0 30</rpy>")
    camera = f"<model:MonoCam><id>c</id><xyz>0.2 0.1 0.3</xyz><rpy>5 7 -4</rpy><hfov>{hfov}</hfov></model:MonoCam>"
    with world_of(box + camera) as world:
        world.step(1)
        body = world.body("s")
        eye = world.model("c").camera.eye
        assert math.degrees(eye.hfov) == pytest.approx(hfov)
        center = GzCoordPoseAdd(GzPose(GzVector(0, 0, 0.35)), body.GetPose()).pos
        assert_corners_match(eye, center, (0.5, 0.6, 0.7), body.GetRotation())


def test_corners_of_a_box_seen_by_a_panned_tilted_and_zoomed_head():
    camera = "<model:SonyVID30><id>c</id><enable>true</enable></model:SonyVID30>"
    with world_of(solid("3 1.6 0.6", "0.5 0.5 0.5") + camera) as world:
        world.interface("ptz", "c").command(pan=0.5, tilt=-0.2, zoom=math.radians(40))
        world.run(3.02)
        model, body = world.model("c"), world.body("s")
        eye = model.camera.eye
        assert model.pan.GetAngle() > 0.49
        assert model.tilt.GetAngle() < -0.19
        assert math.degrees(eye.hfov) == pytest.approx(40, abs=0.5)
        center = GzCoordPoseAdd(GzPose(GzVector(0, 0, 0.25)), body.GetPose()).pos
        assert_corners_match(eye, center, (0.5, 0.5, 0.5), body.GetRotation())


def test_the_old_vertical_field_of_view_can_be_had_back():
    camera = "<model:MonoCam><id>c</id><hfov>60</hfov></model:MonoCam>"
    for quirk, focal in (("", 277.128), ("<legacyQuirks>verticalHfov</legacyQuirks>", 207.846)):
        with world_of(camera, quirk) as world:
            world.step()
            assert world.model("c").camera.eye.view.focal == pytest.approx(focal, abs=1e-3)


def test_depth_and_segmentation():
    things = solid("2 0 -0.5", "0.2 1 1") + "<model:SimpleSolid><id>b</id><xyz>4 1 -.5</xyz></model:SimpleSolid>"
    with world_of(
        things + "<model:GroundPlane><height>-1</height></model:GroundPlane><model:MonoCam><id>c</id></model:MonoCam>"
    ) as world:
        world.step()
        eye = world.model("c").camera.eye
        assert eye.depth.dtype == np.float32
        face = world.body("s").GetPosition().x - 0.1
        assert eye.depth[120, 160] == pytest.approx(face, abs=1e-3)
        assert np.ptp(eye.depth[100:140, 140:180]) < 1e-3  # along the line of sight, not from the lens
        assert np.isinf(eye.depth[0, 0])
        below = eye.GetPose().pos.z + 1.0
        row = 220  # the ground: depth = height over tan of the angle below the horizon
        assert eye.depth[row, 5] == pytest.approx(below * eye.view.focal / (row + 0.5 - 120), rel=2e-3)
        ids = eye.segmentation
        assert ids[120, 160] == world.model("s").GetIntId()
        assert set(np.unique(ids)) == {0, world.model("s").GetIntId(), world.model("b").GetIntId()}


# Pan, tilt, zoom -------------------------------------------------------------------------------------------------


def test_commands_are_reached_in_two_seconds_and_limits_hold():
    with world_of("<model:SonyVID30><id>c</id></model:SonyVID30>") as world:
        world.run(0.1)
        ptz, model = world.interface("ptz", "c"), world.model("c")
        half = math.radians(30)
        ptz.command(pan=0.5, tilt=-0.3, zoom=half)
        world.run(2.1)
        assert (ptz.pan, ptz.tilt, ptz.zoom) == pytest.approx((0.5, -0.3, half), abs=0.01)
        assert model.camera.eye.hfov == pytest.approx(half, abs=0.01)
        ptz.command(pan=3.0, tilt=-3.0, zoom=0.0)
        for _ in range(40):
            world.run(0.1)
            assert abs(model.pan.GetAngle()) <= 0.3 * math.pi + 1e-3
            assert abs(model.tilt.GetAngle()) <= 0.5 * math.pi + 1e-3
        assert (ptz.pan, ptz.tilt) == pytest.approx((0.3 * math.pi, -0.5 * math.pi), abs=0.01)
        assert ptz.zoom == pytest.approx(math.radians(6), rel=0.02)  # ten times is the most


# Pan and tilt [rad] of the original server's SonyVID30 on a Pioneer2AT, told to go to 0.5 and -0.3, each 0.1 s after
# the tick at which it took the command. That tick came 0.04 s after the command was written, for its ticks and the
# command had another phase; here the command is written right before a tick, and time counts from the tick in both.
OLD_HEAD = [
    (0.1, -0.059999322), (0.18, -0.107999935), (0.244, -0.146400682), (0.2952, -0.177121104), (0.33616, -0.201697228),
    (0.368928, -0.221357979), (0.3951424, -0.23708649), (0.41611392, -0.249669248), (0.432891136, -0.259735428),
    (0.446312909, -0.267788358), (0.457050327, -0.274230694),
]  # fmt: skip


def test_the_head_moves_as_the_old_servers_did():
    text = "<gz:world xmlns:gz='g' xmlns:model='m'><model:GroundPlane/>" + ROBOT_WITH_CAMERA.format("") + "</gz:world>"
    with libgz.World.from_string(text) as world:
        world.run(1.0)
        world.interface("ptz", "c").command(pan=0.5, tilt=-0.3)
        model = world.model("c")
        for pan, tilt in OLD_HEAD:
            world.step(5)
            assert model.pan.GetAngle() == pytest.approx(pan, abs=0.005)
            assert model.tilt.GetAngle() == pytest.approx(tilt, abs=0.005)


def test_canon_looks_down_from_its_mount_and_not_up():
    with world_of("<model:CanonVCC4><id>c</id></model:CanonVCC4>") as world:
        ptz = world.interface("ptz", "c")
        ptz.command(pan=-2.0, tilt=-2.0)
        world.run(4.0)
        assert (ptz.pan, ptz.tilt) == pytest.approx((-math.pi / 2, -math.pi / 6), abs=0.01)
        assert world.interface("camera", "c").image.shape == (240, 320, 3)


# Stereo ----------------------------------------------------------------------------------------------------------

STEREO = "<model:StereoHead><id>c</id><nearClip>0.2</nearClip><baseline>0.12</baseline>{}</model:StereoHead>"


@pytest.mark.parametrize("distance", [1.0, 2.0, 4.0])
def test_disparity_of_a_textured_wall(distance):
    texture = installed_worlds() / "grid.png"
    wall = (
        f"<model:SimpleSolid><id>s</id><xyz>{distance + 0.1 + 0.025} 0 -2</xyz><size>0.2 4 4</size>"
        f"<textureFile>{texture}</textureFile></model:SimpleSolid>"
    )
    with world_of(LIGHT + wall + STEREO.format("")) as world:
        world.step()
        stereo = world.interface("stereo", "c")
        expected = 320 / (2 * math.tan(math.radians(30))) * 0.12 / distance
        inner = stereo.left_disparity[60:180, 80:240]
        assert np.abs(inner - expected).max() < 0.5
        assert np.abs(stereo.right_disparity[60:180, 80:240] - expected).max() < 0.5
        # The images agree: shifted by it, they fit best.
        left, right = stereo.left_image[60:180].astype(int), stereo.right_image[60:180].astype(int)
        misfits = [np.abs(left[:, 120:200] - right[:, 120 - d : 200 - d]).mean() for d in range(60)]
        assert np.argmin(misfits) == pytest.approx(expected, abs=1.0)
        assert min(misfits) < 0.5 * np.median(misfits)


def test_what_one_eye_does_not_see_has_no_disparity():
    things = "<model:SimpleSolid><xyz>4 0 -3</xyz><size>.1 8 6</size></model:SimpleSolid>" + solid(
        "1 0 -.2", ".1 .4 .4"
    )
    with world_of(LIGHT + things + STEREO.format("<enableDisparityRight>0</enableDisparityRight>")) as world:
        world.step()
        stereo = world.interface("stereo", "c")
        row = stereo.left_disparity[120]
        focal = 277.128
        near, far = focal * 0.12 / (0.95 - 0.025), focal * 0.12 / (3.95 - 0.025)
        values = row[10:310]
        assert set(np.unique(np.round(values[values > 0]))) <= {round(near), round(far)}
        # The left eye sees, left of the box, a strip of wall that the box hides from the right eye.
        hidden = np.flatnonzero(row[60:] == 0) + 60
        assert len(hidden) == pytest.approx(near - far, abs=2.5)
        assert (row[:8] == 0).all()  # outside the right camera's image
        assert stereo.right_disparity.size == 0


def test_a_stereo_head_on_a_moving_head_pans_with_it():
    nested = ROBOT_WITH_CAMERA.format(
        STEREO.format("<parentBody>head</parentBody><xyz>0 0 0.1</xyz>").replace(">c<", ">st<")
    )
    with world_of(nested) as world:
        world.interface("ptz", "c").command(pan=0.5)
        world.run(3.0)
        assert GzQuaternToEuler(world.model("st").GetPose().rot).z == pytest.approx(0.5, abs=0.02)
        eyes = world.model("st").eyes
        ahead = rotate(eyes["left"].GetPose().rot, (1, 0, 0))
        assert math.atan2(ahead.y, ahead.x) == pytest.approx(0.5, abs=0.02)
        apart = np.subtract(tuple(eyes["left"].GetPose().pos), tuple(eyes["right"].GetPose().pos))
        assert np.linalg.norm(apart) == pytest.approx(0.12, abs=1e-6)
        assert world.interface("stereo", "st").left_image.shape == (240, 320, 3)


# Interfaces and files --------------------------------------------------------------------------------------------


def test_images_come_at_the_update_rate_and_over_the_wire(gazebo):
    process = gazebo(installed_worlds() / "ptz.world", "--rate", "4")
    with Client(process.id) as client:
        camera, ptz = client.camera("cam1"), client.ptz("cam1")
        ptz.command(pan=0.4)
        times, end = [], time.monotonic() + 20
        while len(times) < 8 and time.monotonic() < end:
            client.wait(timeout=5)
            with camera.locked() as data:
                if data.image_size and (not times or times[-1] != data.time):
                    times.append(data.time)
                    image = camera.image.copy()
        # A busy machine may make this client miss an image; the server never renders one out of time.
        steps = np.diff(times) / 0.1
        assert len(steps) == 7
        assert steps == pytest.approx(np.round(steps), abs=1e-5)
        assert steps.min() == pytest.approx(1.0)
        assert image.shape == (240, 320, 3)
        sky, grass = image[:20].mean(axis=(0, 1)), image[-20:].mean(axis=(0, 1))
        assert sky[2] > sky[1] > sky[0]
        assert grass[1] > grass[0] > grass[2] * 1.1
        assert client.guicam("observer").image.shape == (480, 640, 3)


def test_saved_frames_are_numbered_and_rows_run_down(tmp_path):
    save = f"<savePath>{tmp_path}/frames</savePath><saveFrames>true</saveFrames>"
    with world_of(f"{solid('3 0 -3', '.5 4 3')}<model:MonoCam><id>c</id>{save}</model:MonoCam>") as world:
        world.step(12)
        latest = world.interface("camera", "c").image.copy()
    names = sorted(path.name for path in (tmp_path / "frames").iterdir())
    assert names == ["0000.pnm", "0001.pnm", "0002.pnm"]
    assert (tmp_path / "frames/0002.pnm").read_bytes().startswith(b"P6\n# Gazebo\n320 240\n255\n")
    with Image.open(tmp_path / "frames/0002.pnm") as saved:
        assert np.array_equal(np.asarray(saved), latest)
    assert latest[0].mean() > 150  # sky above, the dark box below
    assert latest[-1, 160].max() < 60


@pytest.mark.parametrize(
    ("attributes", "complaint"),
    [
        ("<imageSize>800 600</imageSize>", "imageSize 800 600 is not allowed"),
        ("<nearClip>5</nearClip><farClip>2</farClip>", "farClip 2 m is not allowed"),
        ("<hfov>200</hfov>", "hfov"),
    ],
)
def test_impossible_optics_are_refused(attributes, complaint):
    with pytest.raises(libgz.WorldFileError, match=complaint):
        world_of(f"<model:MonoCam><id>c</id>{attributes}</model:MonoCam>")


def saved_frames(folder, threaded):
    """The frames that two cameras save on a driving, panning robot; they are also served."""
    save = f"<savePath>{folder}/{{}}</savePath><saveFrames>1</saveFrames>"
    body = (
        LIGHT + solid("3 0.4 0", "0.5 0.6 0.7") + ROBOT_WITH_CAMERA.format(save.format("c"))
        + f"<model:MonoCam><id>m</id><xyz>-3 0 1</xyz><updateRate>5</updateRate>{save.format('m')}</model:MonoCam>"
    )  # fmt: skip
    with world_of(body) as world:
        world.backdrop.threaded = threaded
        world.interface("ptz", "c").command(pan=0.5, zoom=0.5)
        world.interface("position", "r").command(vx=0.3)
        for step in range(60):
            if step == 33:
                world.body("s").geoms[0].SetColor(libgz.GzColor(0, 1, 0))
            world.step()
            assert world.interface("camera", "c").time >= world.GetSimTime() - (0.22 if threaded else 0.12)
    return {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*.pnm")}


def test_images_of_a_separate_thread_are_the_same_bit_for_bit(tmp_path):
    alone, threaded = saved_frames(tmp_path / "alone", False), saved_frames(tmp_path / "threaded", True)
    assert len(alone) == 12 + 6
    assert len(set(alone.values())) == len(alone)
    assert threaded == alone


# Observer --------------------------------------------------------------------------------------------------------

OBSERVED = LIGHT + solid("4 0 -0.5", "1 1 1") + "<model:ObserverCam><id>o</id>{}</model:ObserverCam>"


def red_center(image):
    rows, columns = np.nonzero((image[:, :, 0] > 60) & (image[:, :, 2] < 60))
    return columns.mean(), rows.mean()


def test_clients_cannot_save_frames_without_limit(tmp_path, monkeypatch, caplog):
    monkeypatch.setattr(observercam, "MOST_FRAMES", 3)
    saved = f"<savePath>{tmp_path}</savePath><imageSize>16 12</imageSize><updateRate>1000</updateRate>"
    with world_of(OBSERVED.format(saved)) as world:
        world.interface("guicam", "o").data.save_frames = 1
        world.step(10)
    assert sorted(path.name for path in tmp_path.glob("*.pnm")) == ["0000.pnm", "0001.pnm", "0002.pnm"]
    assert caplog.text.count("guicam.o: save_frames is 1, but 3 images were saved, and is ignored") == 1


def test_frames_that_the_worldfile_saves_have_no_limit(tmp_path, monkeypatch):
    monkeypatch.setattr(observercam, "MOST_FRAMES", 3)
    saved = f"<savePath>{tmp_path}</savePath><imageSize>16 12</imageSize><updateRate>1000</updateRate>"
    with world_of(OBSERVED.format(f"{saved}<saveFrames>true</saveFrames>")) as world:
        world.step(10)
    assert len(list(tmp_path.glob("*.pnm"))) >= 10


def test_switches_of_an_observer_are_0_or_1(caplog):
    with world_of(OBSERVED.format("<updateRate>1000</updateRate>")) as world:
        guicam = world.interface("guicam", "o")
        data, options = guicam.data, world.model("o").eye.options
        data.display_bbox, data.display_skins, data.roll_lock = 1, 0, 2
        world.step()
        assert (options.displayBBox, options.displaySkins) == (True, False)
        assert (data.display_bbox, data.display_skins, data.roll_lock) == (1, 0, 1)
        data.display_bbox, data.display_skins = -1, 2**31 - 1
        world.step()
        assert (options.displayBBox, options.displaySkins) == (True, False)
        assert (data.display_bbox, data.display_skins) == (1, 0)
    assert [message.partition("guicam.o: ")[2] for message in caplog.messages if "guicam.o" in message] == [
        "roll_lock is 2, neither 0 nor 1, and is ignored",
        "display_bbox is -1, neither 0 nor 1, and is ignored",
        "display_skins is 2147483647, neither 0 nor 1, and is ignored",
    ]


def test_dragging_keeps_what_was_grabbed_under_the_mouse():
    with world_of(OBSERVED.format("")) as world:
        world.step()
        guicam = world.interface("guicam", "o")
        column, row = red_center(guicam.image)
        assert (column, row) == pytest.approx((160, 120), abs=1)
        guicam.drag(0, (160, 120), (220, 90))
        world.step(5)
        assert red_center(guicam.image) == pytest.approx((220, 90), abs=4)  # of the box, now seen from aside
        assert world.model("o").GetPose().pos == GzVector(0, 0, 0)  # the model moves when the mouse lets go
        guicam.release()
        world.step(5)
        place = world.model("o").GetPose().pos
        assert (place.x, place.y, place.z) == pytest.approx((0, 60 * 3.5 / 277.1, -30 * 3.5 / 277.1), abs=0.02)
        assert tuple(guicam.pos) == pytest.approx((place.x, place.y, place.z))
        assert red_center(guicam.image) == pytest.approx((220, 90), abs=4)  # of the box, now seen from aside


def test_dragging_zooms_and_turns():
    with world_of(OBSERVED.format("")) as world:
        world.step()
        guicam, model = world.interface("guicam", "o"), world.model("o")
        guicam.drag(1, (160, 100), (160, 80))  # twice as far from the middle: half as far away
        world.step(5)
        guicam.release()
        world.step(5)
        assert model.GetPose().pos.x == pytest.approx(3.5 / 2, abs=0.02)
        guicam.drag(2, (160, 120), (220, 120))
        world.step(5)
        guicam.release()
        world.step(5)
        yaw = math.atan(60 / 277.128)
        assert GzQuaternToEuler(model.GetPose().rot).z == pytest.approx(yaw, abs=1e-3)


def test_an_observer_stays_level_only_if_it_should():
    for lock, roll in (("true", 0.0), ("false", math.radians(20))):
        with world_of(OBSERVED.format(f"<rpy>20 0 0</rpy><rollLock>{lock}</rollLock>")) as world:
            world.step()
            world.interface("guicam", "o").drag(2, (160, 120), (161, 120))
            world.step(5)
            assert GzQuaternToEuler(world.model("o").eye.GetPose().rot).x == pytest.approx(roll, abs=5e-3)


def test_insane_drags_do_no_harm(caplog):
    with world_of(OBSERVED.format("")) as world:
        guicam = world.interface("guicam", "o")
        for mode in (0, 1, 2, 77):
            data = guicam.data  # as a C program may write
            data.cmd_spot_mode, data.cmd_spot_state = mode, 1
            data.cmd_spot_a[:], data.cmd_spot_b[:] = (math.nan, 1e300), (math.inf, -5)
            world.step(5)
            guicam.release()
            world.step(5)
        assert world.model("o").failed is None
        assert all(math.isfinite(v) for v in world.model("o").GetPose().pos)


def test_observers_watch_while_the_world_is_paused():
    with world_of(OBSERVED.format(""), "<pause>true</pause>") as world:
        guicam = world.interface("guicam", "o")
        world.step(11)
        assert guicam.sim_time == 0.0
        assert guicam.data.pause_time == pytest.approx(0.2)
        assert guicam.image.size


def test_every_display_switch_changes_the_image():
    laser = "<model:SickLMS200><id>l</id><xyz>1.5 0 -.6</xyz></model:SickLMS200>"
    camera = "<model:MonoCam><xyz>1.6 -.4 0</xyz></model:MonoCam>"
    wood = f"<textureFile>{installed_worlds()}/wood.png</textureFile>"
    textured = f"<model:SimpleSolid><xyz>4 1 0</xyz>{wood}</model:SimpleSolid>"
    ball = "<model:SimpleSolid><xyz>4 -1 0</xyz><shape>sphere</shape></model:SimpleSolid>"
    with world_of(OBSERVED.format("<nearClip>.1</nearClip>") + laser + camera + textured + ball) as world:
        world.step(6)
        guicam = world.interface("guicam", "o")
        normal = guicam.image.copy()
        for name in set(SWITCHES) - {"display_skins"}:
            before = getattr(guicam.data, name)
            setattr(guicam.data, name, 1 - before)
            world.step(5)
            assert np.abs(guicam.image.astype(int) - normal).max() > 30, name
            setattr(guicam.data, name, before)
        world.step(5)
        assert np.array_equal(guicam.image, normal)
