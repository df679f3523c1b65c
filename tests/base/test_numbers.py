"""Whole numbers of texts from anywhere, and their readers: no digits end a load by an exception of Python."""

import pytest

from libgz import GazeboError, World
from libgz.base.numbers import whole_number
from libgz.classic.log.file import LogReader
from libgz.player.configuration import read_configuration
from libgz.sdf.paths import find_model

ODD = ("²", "٣", "9" * 5000, "-1", "+1", "1_0", " 1", "", "1e3", "0x1")


def test_whole_numbers_are_those_of_the_digits_0_to_9_up_to_the_most():
    assert [whole_number(text, 9) for text in ("0", "9", "009", "0" * 5000 + "7")] == [0, 9, 9, 7]
    assert [whole_number(text, 9) for text in ("10", *ODD)] == [None] * (1 + len(ODD))


@pytest.mark.parametrize("odd", ODD[:3])
def test_readers_take_any_digits(odd, tmp_path, monkeypatch):
    monkeypatch.setenv("GAZEBO_MODEL_PATH", str(tmp_path))
    (tmp_path / "box").mkdir()
    (tmp_path / "box" / "model.config").write_text(
        f"<model><sdf version='{odd}'>a.sdf</sdf><sdf version='1.{odd}'>b.sdf</sdf>"
        "<sdf version='1.5'>c.sdf</sdf></model>"
    )
    for name in ("a", "b", "c"):
        (tmp_path / "box" / f"{name}.sdf").write_text(
            "<sdf version='1.5'><model name='m'><link name='l'/></model></sdf>"
        )
    assert find_model("model://box").name == "c.sdf"
    log = tmp_path / "state.log"
    log.write_text(
        f"<gazebo_log><header><log_version>1.0</log_version><rand_seed>{odd}</rand_seed></header></gazebo_log>"
    )
    assert LogReader(log).header.rand_seed == 0
    configuration = tmp_path / "a.cfg"
    provides = f"position:{odd}", f"{odd}:position:1"
    for address in provides:
        configuration.write_text(
            f'driver (name "gz_position" provides ["{address}"] server_id "{odd}" worldfile "{"x" * 999}")'
        )
        with pytest.raises(GazeboError, match=r"declares no device|port"):
            read_configuration(configuration, 6665)
    world = tmp_path / "a.world"
    world.write_text(
        "<gz:world xmlns:gz='g' xmlns:model='m'><model:SickLMS200>"
        f"<rayCount>{odd}</rayCount></model:SickLMS200></gz:world>"
    )
    with pytest.raises(GazeboError, match=r"(?s)rayCount(?!.*please report)"):
        World.from_file(world)
