"""Elements that occur again, although SDF's description allows one: no warning where all of them act."""

import pytest

from libgz.sdf.reader import SdfFile

MODEL = "<sdf version='1.6'><model name='m'><link name='l'>{}</link></model></sdf>"
CAMERA = "<camera><image><width>8</width><height>8</height></image></camera>"
OUTLINE = "<polyline><point>0 0</point><point>{0} 0</point><point>0 {0}</point><height>1</height></polyline>"
SENSOR = "<sensor name='s' type='{}'>{}</sensor>"


def warnings(text):
    return [str(warning) for warning in SdfFile.from_string(text).diagnostics.warnings]


@pytest.mark.parametrize(
    "text",
    [
        MODEL.format(SENSOR.format("multicamera", 2 * CAMERA)),
        MODEL.format(SENSOR.format("contact", "<contact><collision>a</collision><collision>b</collision></contact>")),
        MODEL.format(f"<visual name='v'><geometry>{OUTLINE.format(2)}{OUTLINE.format(1)}</geometry></visual>"),
        MODEL.format(
            "<visual name='v'><geometry><box/></geometry><material><script><uri>a</uri><uri>b</uri><name>c</name>"
            "</script></material></visual>"
        ),
        *(
            f"<sdf version='{version}'><world name='w'><physics name='a' type='ode'/><physics name='b' type='ode'/>"
            "</world></sdf>"
            for version in ("1.4", "1.5", "1.6")
        ),
    ],
)
def test_what_acts_more_than_once_is_no_warning(text):
    assert not [warning for warning in warnings(text) if "more than once" in warning]


@pytest.mark.parametrize("kind", ["camera", "depth"])
def test_a_second_camera_of_another_sensor_is_a_warning(kind):
    (found,) = warnings(MODEL.format(SENSOR.format(kind, 2 * CAMERA)))
    assert "<camera>: occurs more than once in <sensor>; only the first one has an effect" in found
