"""Configuration files of Player: both syntaxes, what is left out, and what is wrong."""

import pytest

from libgz.base.errors import WorldFileError
from libgz.player.configuration import read_configuration

# Files in the style of their years, and the devices they declare: (port, interface, index, driver, id).
FILES = {
    "1.6": (
        'driver\n(\n  name "gz_position"\n  provides ["position:0"]\n  gz_id "robot1" # the robot\n)\n',
        [(6665, "position2d", 0, "gz_position", "robot1")],
    ),
    "1.6, one word": (
        'driver ( name "gz_laser" provides "laser:2" gz_id "laser1" )',
        [(6665, "laser", 2, "gz_laser", "laser1")],
    ),
    "1.4": (
        'position:0 ( driver "gz_position" gz_id "a" )\nsonar:1 ( driver "gz_sonars" port 6670 gz_id "b" )',
        [(6665, "position2d", 0, "gz_position", "a"), (6670, "sonar", 1, "gz_sonar", "b")],
    ),
    "two robots": (
        'driver ( name "gz_position" provides ["6665:position:0"] gz_id "a" robotname "left" )\n'
        'driver ( name "gz_position" provides ["6666:position:0"] gz_id "b" robotname "right" )',
        [(6665, "position2d", 0, "gz_position", "a"), (6666, "position2d", 0, "gz_position", "b")],
    ),
    "keys": (
        'driver ( name "gz_stereo" gz_id "s" provides ["right::camera:0" "left_disparity::camera:1"] save 1 )',
        [(6665, "camera", 0, "gz_stereo", "s"), (6665, "camera", 1, "gz_stereo", "s")],
    ),
    "macro": (
        'define robot driver ( name "gz_position" gz_id "a" )\nrobot ( provides ["position:3"] gz_id "b" )',
        [(6665, "position2d", 3, "gz_position", "b")],
    ),
    "2": (
        'driver ( name "gazebo" provides ["simulation:0"] plugin "libgazeboplugin" server_id "default" )\n'
        'driver ( name "gazebo" provides ["position2d:0"] gz_id "robot1::position_iface_0" )\n'
        'driver ( name "gazebo" provides ["6665:actarray:0"] gz_id "arm" home_on_subscribe 1 )',
        [
            (6665, "simulation", 0, "gz_sim", "default"),
            (6665, "position2d", 0, "gz_position", "robot1::position_iface_0"),
            (6665, "actarray", 0, "gz_actarray", "arm"),
        ],
    ),
    "2, hosts and keys": (
        'driver ( name "gazebo" provides ["localhost:6667:ptz:0"] gz_id "head" alwayson true )\n'
        'driver ( name "gazebo" provides ["left:::camera:1"] gz_id "eyes" )\n'
        'driver ( name "gazebo" provides ["odometry:localhost:6667:position2d:1"] model_name "robot" )',
        [
            (6667, "ptz", 0, "gz_ptz", "head"),
            (6665, "camera", 1, "gz_stereo", "eyes"),
            (6667, "position2d", 1, "gz_position", "robot"),
        ],
    ),
    "left out": (
        'driver ( name "gz_power" provides ["power:0"] gz_id "robot1" )\n'
        'driver ( name "vfh" provides ["position:1"] requires ["position:0" "laser:0"] cell_size 0.1 )\n'
        'driver ( name "gz_laser" provides ["laser:0"] )\n'
        "window ( size [700 740] scale 0.028 )",
        [(6665, "power", 0, "gz_power", "robot1")],
    ),
    "carriage returns": (
        'driver\r\n(\r\n name "gz_gps"\r\n provides ["gps:0"]\r\n gz_id "gps1"\r\n)\r\n',
        [(6665, "gps", 0, "gz_gps", "gps1")],
    ),
}
# Wrong files, and what is said of each: line and words.
WRONG = {
    'driver ( name "gz_positon" provides ["position:0"] gz_id "a" )': (1, "did you mean 'gz_position'"),
    'driver\n(\n name "gz_laser"\n provides ["lasr:0"]\n gz_id "a"\n)': (4, "'lasr' here; did you mean 'laser'"),
    'driver ( name "gz_laser" provides ["sonar:0"] gz_id "a" )': (1, "provides laser, and no sonar"),
    'driver ( name "gz_laser" provides ["laser"] gz_id "a" )': (1, "write INTERFACE:INDEX"),
    'driver ( name "gz_laser" provides ["70000:laser:0"] gz_id "a" )': (1, "the port '70000'"),
    'driver ( name "gz_stereo" provides ["camera:0"] gz_id "a" )': (1, "left::camera:0"),
    'driver ( name "gz_laser" gz_id "a" )': (1, "must say what it provides"),
    'driver ( provides ["laser:0"] gz_id "a" )': (1, "must have a name"),
    'driver ( name "gz_laser" provides ["laser:0"] gz_id "a/b" )': (1, "must not contain '/'"),
    '\ndriver ( name "gz_laser" provides ["laser:0"] gz_id "a"\n': (2, "no closing )"),
    'driver ( name "gz_laser" provides ["laser:0" gz_id "a" )': (1, "no closing ]"),
    'driver ( name "gz_laser\n provides ["laser:0"] )': (1, "no closing quotation mark"),
    'driver ( name gz_laser )': (1, "has no value"),
    '# nothing\n': (1, "declares no device"),
    '"position:0"': (1, "stands outside a section"),
    'define robot\n': (1, "a macro is written"),
    'include "nowhere.inc"': (1, "cannot include"),
    '{ }': (1, "the character '{'"),
    'driver ( name "gz_gps" provides ["gps:0"] gz_id "a" )\ndriver ( name "gz_gps" provides ["gps:0"] gz_id "b" )': (
        2,
        "is provided in line 1 already",
    ),
}  # fmt: skip


def read(tmp_path, text, port=6665):
    path = tmp_path / "robot.cfg"
    path.write_bytes(text.encode())
    return read_configuration(path, port)


@pytest.mark.parametrize(("text", "devices"), FILES.values(), ids=FILES)
def test_files_of_both_eras(tmp_path, text, devices):
    found = read(tmp_path, text).devices
    assert [(d.port, d.driver.kind, d.index, d.driver.name, d.id) for d in found] == devices


def test_what_is_left_out_is_named(tmp_path):
    said = [str(warning) for warning in read(tmp_path, FILES["left out"][0]).diagnostics.warnings]
    assert [any(words in line for line in said) for words in ("'vfh'", "position:1", "no gz_id", "'window'")] == [
        True
    ] * 4


def test_wrong_files(tmp_path):
    for text, (line, words) in WRONG.items():
        with pytest.raises(WorldFileError) as error:
            read(tmp_path, text)
        assert any(f"robot.cfg:{line}: " in said and words in said for said in str(error.value).splitlines()), (
            text,
            error,
        )


def test_all_errors_are_reported_together(tmp_path):
    text = "\n".join(text.replace("\n", " ") for text in list(WRONG)[:4])
    with pytest.raises(WorldFileError) as error:
        read(tmp_path, text)
    assert [line.split(":")[1] for line in str(error.value).splitlines()] == ["1", "2", "3", "4"]


def test_includes_are_relative_to_their_file_and_bounded(tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "laser.inc").write_text('driver ( name "gz_laser" provides ["laser:0"] gz_id "a" )\n')
    (tmp_path / "parts" / "all.inc").write_text('include "laser.inc"\n')
    assert [d.id for d in read(tmp_path, 'include "parts/all.inc"\n').devices] == ["a"]
    with pytest.raises(WorldFileError, match="more than 20 deep"):
        read(tmp_path, 'include "robot.cfg"\n')
    with pytest.raises(WorldFileError, match="more than 200000 words") as error:
        read(tmp_path, 'include "robot.cfg"\n' * 100)  # 100 ** 20 files
    assert len(str(error.value).splitlines()) < 200_000


@pytest.mark.parametrize("text", ["a(" * 90_000, f"driver({'a(' * 40_000}{')' * 40_000})"])
def test_sections_in_each_other_are_bounded(tmp_path, text):
    with pytest.raises(WorldFileError, match="sections are more than 100 deep in each other"):
        read(tmp_path, text)


def test_a_macro_of_many_fields_stands_in_no_more_sections_than_memory_has_room_for(tmp_path):
    fields = " ".join(f"f{i} 1" for i in range(20_000))
    with pytest.raises(WorldFileError, match="sections have more than 200000 fields of macros"):
        read(tmp_path, f"define many driver({fields})\n" + "many()\n" * 100)


def test_many_devices_are_read_in_linear_time(tmp_path):
    addresses = " ".join(f'"{port}:position2d:0"' for port in range(1, 65536))
    driver = f'driver ( name "gz_position" gz_id "one" provides [{addresses}] )\n'
    assert len(read(tmp_path, driver).ports) == 65535
    with pytest.raises(WorldFileError, match="65535:position2d:0 is provided in line 1 already"):
        read(tmp_path, driver + driver.replace(addresses, '"65535:position2d:0"'))


def test_a_worldfile_whose_name_no_command_can_have_is_an_error_of_its_line(tmp_path):
    start = 'driver ( name "gazebo" provides ["simulation:0"] worldfile "a\0b" )'
    with pytest.raises(WorldFileError, match=r"robot\.cfg:1: .*'a\\x00b' is no name of a file"):
        read(tmp_path, start)


def test_brackets_that_do_not_close_are_read_in_linear_time(tmp_path):
    with pytest.raises(WorldFileError, match="more than 200000 words"):
        read(tmp_path, "a[" * 4_000_000)


def test_simulation(tmp_path):
    start = 'driver ( name "gazebo" provides ["simulation:0"] plugin "libgazeboplugin" {} )'
    assert read(tmp_path, start.format('server_id "3"')).simulation == ("", 3)
    assert read(tmp_path, start.format('worldfile "pioneer2at.world"')).simulation == ("pioneer2at.world", 0)
    (tmp_path / "own.world").touch()
    assert read(tmp_path, start.format('worldfile "own.world"')).simulation == (str(tmp_path / "own.world"), 0)
    odd = read(tmp_path, start.format('server_id "seven"'))
    assert (odd.simulation.server_id, "'seven'" in str(odd.diagnostics.warnings[0])) == (0, True)
