"""The study can be run: its names are right, and heavy crates move less."""

from dataclasses import replace
from pathlib import Path

from libgz.sweep.run import check, simulate
from libgz.sweep.study import Study

STUDY = Study.load(Path(__file__).with_name("push.toml"))


def test_the_study_is_right():
    check(STUDY)
    assert len(STUDY) == 40


def test_heavy_crates_move_less():
    light, heavy = (
        simulate(STUDY, replace(STUDY.run(0), parameters={"crate/mass": mass, "controller/speed": 0.5}), None, len)
        for mass in (5.0, 60.0)
    )
    assert light["distance"] > 2.0 > heavy["distance"]
