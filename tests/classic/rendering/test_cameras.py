"""Camera sensors of SDF worlds: Gazebo's acceptance figures, rates, noise, files, topics."""

import math

import numpy as np
import pytest
from PIL import Image

import libgz
from libgz.classic import physics, sensors
from libgz.classic.math import Pose3d

SCENE = (
    "<scene><ambient>1 1 1 1</ambient><background>0.5 0.5 0.5 1</background><shadows>0</shadows></scene>"
    "<light name='sun' type='directional'><direction>0.5 0.1 -0.9</direction><diffuse>0.8 0.8 0.8 1</diffuse>"
    "<specular>0 0 0 1</specular></light>"
)
BOX = (
    "<model name='box'><static>1</static><pose>3 0 0.5 0 0 0</pose><link name='link'>"
    "<collision name='c'><geometry><box><size>1 1 1</size></box></geometry></collision>"
    "<visual name='v'><geometry><box><size>1 1 1</size></box></geometry>"
    "<material><ambient>0.1 0.1 0.1 1</ambient><diffuse>0.1 0.1 0.1 1</diffuse></material></visual></link></model>"
)


def camera(kind="camera", name="eye", rate=0, image="", content="", size=(320, 240), clip=(0.1, 10), on=1, more=""):
    return (
        f"<sensor name='{name}' type='{kind}'><always_on>{on}</always_on><update_rate>{rate}</update_rate><camera>"
        f"<horizontal_fov>1.0</horizontal_fov><image><width>{size[0]}</width><height>{size[1]}</height>{image}</image>"
        f"<clip><near>{clip[0]}</near><far>{clip[1]}</far></clip>{content}</camera>{more}</sensor>"
    )


def world_of(sensor, scene=BOX, **options):
    mount = f"<model name='m'><static>1</static><pose>0 0 0.5 0 0 0</pose><link name='link'>{sensor}</link></model>"
    text = f"<sdf version='1.6'><world name='default'>{SCENE}{scene}{mount}</world></sdf>"
    return libgz.World.from_string(text, **options)


def get(name="eye"):
    found = sensors.get_sensor(name)
    assert found is not None
    return found


def pixels(sensor):
    data = np.frombuffer(sensor.ImageData(), dtype=np.uint8)
    return data.reshape(sensor.ImageHeight(), sensor.ImageWidth(), 3).astype(float)


def test_row_19_a_depth_camera_before_a_box():
    with world_of(camera("depth")) as world:
        depths, clouds = [], []
        view = get().DepthCamera()
        kept = [
            view.ConnectNewDepthFrame(lambda *values: depths.append(values)),
            view.ConnectNewRGBPointCloud(lambda *values: clouds.append(values)),
        ]
        world.step(1)
        data, width, height, depth, layout = depths[0]
        assert (width, height, depth, layout) == (320, 240, 1, "FLOAT32")
        image = np.array(data).reshape(240, 320)
        assert image[120, 160] == pytest.approx(2.5, abs=1e-4)
        assert image[0, 0] == image[120, 0] == image[120, 319] == image[239, 319] == math.inf
        points = np.array(clouds[0][0]).reshape(240, 320, 4)
        for row, column in ((110, 150), (110, 170), (130, 150), (130, 170)):
            x, y, z = points[row, column, :3]
            assert z == pytest.approx(2.5, abs=1e-4)
            assert (x > 0) == (column > 159)  # to the right
            assert (y > 0) == (row > 119)  # down
        assert np.array(get().DepthData())[120 * 320 + 160] == pytest.approx(2.5, abs=1e-4)
        physics.get_world().ModelByName("box").SetWorldPose(Pose3d(30, 0, 0.5, 0, 0, 0))
        world.step(1)
        assert np.all(np.isposinf(np.array(get().DepthData())))
        assert len(kept) == 2


def test_row_20_ten_images_a_second_also_after_a_reset():
    with world_of(camera(rate=10, size=(16, 12))) as world:
        images = []
        kept = get().Camera().ConnectNewImageFrame(lambda *values: images.append(values))
        world.step(1000)
        assert len(images) == 10
        data, width, height, depth, layout = images[-1]
        assert (len(data), width, height, depth, layout) == (16 * 12 * 3, 16, 12, 3, "R8G8B8")
        physics.get_world().Reset()
        world.step(1000)
        assert len(images) == 20
        assert get().LastUpdateTime().Double() == pytest.approx(1.0)
        assert kept.connected


def test_row_20_a_box_is_darker_than_the_background():
    with world_of(camera(size=(64, 48))) as world:
        world.step(1)
        image = pixels(get())
        background = image[2, 2].mean()
        assert background == pytest.approx(0.5 * 255, abs=1.0)
        assert np.ptp(image[:4, :4]) == 0.0
        assert image[24, 32].mean() < 0.75 * background


def test_row_20_noise_moves_the_mean_by_its_own():
    noise = "<noise><type>gaussian</type><mean>0.1</mean><stddev>0.02</stddev></noise>"
    both = camera(name="clean", size=(64, 48)) + camera(name="noisy", size=(64, 48), content=noise)
    with world_of(both, scene="") as world:
        world.step(1)
        change = (pixels(get("noisy")) - pixels(get("clean"))) / 255.0
        assert change.mean() == pytest.approx(0.1, abs=3 * 0.02 / math.sqrt(change.size) + 0.5 / 255)
        assert change.std() == pytest.approx(0.02, rel=0.1)
        assert get("noisy").Noise(sensors.CAMERA_NOISE).GetMean() == 0.1


def test_row_20_images_of_sixteen_bits():
    one = camera(name="gray", size=(8, 6), image="<format>L_INT16</format>")
    with world_of(one + camera(name="color", size=(8, 6), image="<format>RGB_INT16</format>"), scene="") as world:
        world.step(1)
        gray = np.frombuffer(get("gray").ImageData(), dtype=np.uint16)
        color = np.frombuffer(get("color").ImageData(), dtype=np.uint16)
        assert (gray.size, color.size) == (48, 144)
        assert gray[0] / 65535 == pytest.approx(0.5, abs=0.005)
        assert color[0] / 65535 == pytest.approx(0.5, abs=0.005)


def test_row_20_a_light_that_turns_green_by_its_topic():
    from libgz.classic import msgs, transport

    dark = SCENE.replace("<ambient>1 1 1 1", "<ambient>0 0 0 1")
    mount = f"<model name='m'><static>1</static><link name='link'>{camera(size=(64, 48))}</link></model>"
    white = BOX.replace("0.1 0.1 0.1 1", "1 1 1 1").replace("3 0 0.5", "3 0 0")
    with libgz.World.from_string(
        f"<sdf version='1.6'><world name='default'>{dark}{white}{mount}</world></sdf>"
    ) as world:
        node = transport.Node()
        node.Init("default")
        publisher = node.Advertise(msgs.Light, "~/light/modify")
        world.step(2)
        red, green, blue = pixels(get())[24, 32]
        assert red == green == blue > 50
        light = msgs.Light(name="sun")
        msgs.Set(light.diffuse, (0, 1, 0, 1))
        publisher.Publish(light)
        world.step(2)
        red, green, blue = pixels(get())[24, 32]
        assert red == blue == 0.0
        assert green > 50


def test_a_stereo_pair_takes_its_images_together():
    def eye(name, y):
        return (
            f"<camera name='{name}'><pose>0 {y} 0 0 0 0</pose><horizontal_fov>1</horizontal_fov>"
            "<image><width>64</width><height>48</height></image><clip><near>0.1</near><far>10</far></clip></camera>"
        )

    pair = (
        f"<sensor name='eye' type='multicamera'><always_on>1</always_on>{eye('left', 0.2)}{eye('right', -0.2)}</sensor>"
    )
    with world_of(pair) as world:
        world.step(1)
        one = get()
        assert one.CameraCount() == 2
        assert one.Camera(0).Name() == "m::link::eye::left"
        left, right = (
            np.frombuffer(one.ImageData(i), dtype=np.uint8).reshape(48, 64, 3)[24, :, 0].astype(float) for i in (0, 1)
        )
        middles = [np.flatnonzero(row < 0.75 * row[0]).mean() for row in (left, right)]
        # The box's front, 2.5 m away, moves by focal * base / distance.
        focal = 32 / math.tan(0.5)
        assert middles[0] - middles[1] == pytest.approx(focal * 0.4 / 2.5, abs=1.5)


def test_images_go_to_files_and_to_listeners(tmp_path):
    from libgz.classic import transport

    save = f"<save enabled='true'><path>{tmp_path}</path></save>"
    with world_of(camera(rate=10, size=(16, 12), content=save, on=0)) as world:
        got = []
        node = transport.Node()
        node.Init("default")
        world.step(200)
        assert not list(tmp_path.iterdir())
        kept = node.Subscribe("~/m/link/eye/image", got.append)
        world.step(300)
        transport.TopicManager.Instance().ProcessNodes()
        assert len(got) == 3
        assert (got[0].image.width, got[0].image.height, got[0].image.step) == (16, 12, 48)
        assert got[0].image.pixel_format == 3
        assert len(got[0].image.data) == 16 * 12 * 3
        assert len(list(tmp_path.iterdir())) == 3
        assert get().SaveFrame(str(tmp_path / "one.png"))
        with Image.open(tmp_path / "one.png") as image:
            assert image.size == (16, 12)
        kept.Unsubscribe()


def test_a_camera_goes_with_its_link():
    with world_of(camera(size=(64, 48))) as world:
        world.step(1)
        assert pixels(get())[24, 32].mean() < 100
        physics.get_world().ModelByName("m").SetWorldPose(Pose3d(0, 0, 0.5, 0, 0, math.pi))
        world.step(1)
        assert pixels(get())[24, 32].mean() == pytest.approx(0.5 * 255, abs=1.0)
        physics.get_world().RemoveModel("m")
        world.step(1)
        assert sensors.get_sensor("eye") is None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (camera(size=(0, 10)), "<width>: is 0; it must be at least 1"),
        (camera(clip=(2, 1)), "<far>: is 1 m; it must be beyond <near>, 2 m"),
        (camera().replace(">1.0<", ">4<"), "<horizontal_fov>: is 4 rad"),
    ],
)
def test_wrong_values_are_replaced_with_a_warning(text, message, caplog):
    with world_of(text) as world:
        world.step(2)
        assert sensors.get_sensor("eye") is not None
    assert message in caplog.text


def test_the_distortion_of_a_file_bends_images(caplog):
    shown = []
    for content in ("", "<distortion><k1>0.5</k1></distortion>"):
        with world_of(camera(size=(64, 48), content=content)) as world:
            world.step(2)
            shown.append(pixels(get()).copy())
    assert (shown[0] != shown[1]).any()
    assert "distortion" not in caplog.text
