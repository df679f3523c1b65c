"""Models inside models: built-in ones, Python plugins and C++ plugins, each as parent and as child of each."""

import itertools
import logging
import shutil

import pytest
from cxx_plugins import MODEL, compiled, needs_cxx

import libgz

pytestmark = needs_cxx

INIT = """
  this->position = gz_position_alloc();
  if ( gz_position_create( this->position, this->world->gz_server, this->GetId(), "Tester", (int) (long) this,
                           (int) (long) this->parent ) != 0 ) return -1;
  if ( this->parent != NULL )
    printf( "child %s parent %s number %d of %d body %s z %.6f\\n", this->GetId(), this->parent->GetId(),
            this->GetParentIntId(), this->parent->GetIntId(),
            this->parentBody->bodyName ? this->parentBody->bodyName : "(none)", this->parentBody->GetPose().pos.z );
  fflush( stdout );
"""
PYTHON = """
from libgz import GZ_REGISTER_PLUGIN, Body, Model, SphereGeom, gz_position_alloc, gz_position_create

class Snake(Model):
    STATE = ()

    def Load(self, file, node):
        body = Body(self.world)
        SphereGeom(body, self.modelSpaceId, 0.1).SetMass(1.0)
        self.AddBody(body, True)

    def Init(self, file, node):
        self.position, server = gz_position_alloc(), self.world.gz_server
        gz_position_create(self.position, server, self.GetId(), "Snake", self.GetIntId(), self.GetParentIntId())

GZ_REGISTER_PLUGIN("Snake", Snake)
"""
KINDS = {
    "built-in": "<model:{other}><id>{id}</id><xyz>{at}</xyz>{inside}</model:{other}>",
    "python": "<model:Snake><id>{id}</id><plugin>Snake.so</plugin><xyz>{at}</xyz>{inside}</model:Snake>",
    "c++": "<model:Tester><id>{id}</id><plugin>Tester.so</plugin><xyz>{at}</xyz>{inside}</model:Tester>",
}
PAIRS = list(itertools.product(KINDS, KINDS))


@pytest.fixture(scope="module")
def plugins(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pairs")
    declared = "public: gz_position_t *position; public: int steps;"
    text = MODEL.replace("public: int steps;", declared).replace("NAME", "Tester").replace("LOAD", "")
    text = text.replace("INIT", INIT).replace("FINI", "gz_position_destroy( this->position );").replace("UPDATE", "")
    compiled(folder, "Tester", text=text.replace("#include <gazebo.h>", "#include <stdio.h>\n#include <gazebo.h>"))
    (folder / "Snake.py").write_text(PYTHON)
    return folder


def pair(parent, child, name, x):
    """A model with another one 0.5 m above its place."""
    inside = KINDS[child].format(id=f"{name}_child", at="0 0 0.5", inside="", other="Pioneer2DX")
    return KINDS[parent].format(id=f"{name}_parent", at=f"{x} 0 1", inside=inside, other="Pioneer2AT")


def number_in(interface):
    return interface.data.head.model_id, interface.data.head.parent_model_id


@pytest.mark.parametrize("order", ["before", "after"])
@pytest.mark.parametrize(("parent", "child"), PAIRS, ids=["-".join(one) for one in PAIRS])
def test_names_numbers_and_poses_are_right(plugins, tmp_path, parent, child, order, capfd, caplog):
    """Beside a pair of the same kinds the other way round, loaded before or after it."""
    for file in plugins.iterdir():
        shutil.copy(file, tmp_path)
    both = [pair(parent, child, "one", 0), pair(child, parent, "two", 9)]
    both = both if order == "before" else both[::-1]
    path = tmp_path / "w.world"
    path.write_text(f"<gz:world xmlns:gz='g' xmlns:model='m'>{''.join(both)}</gz:world>")
    with caplog.at_level(logging.WARNING), libgz.World.from_file(path) as world:
        world.step(3)
        lines = [line.split() for line in capfd.readouterr().out.splitlines() if line.startswith("child ")]
        seen = {line[1]: line for line in lines}
        for name, kind in (("one", child), ("two", parent)):
            outer, inner = world.model(f"{name}_parent"), world.model(f"{name}_child")
            numbers = inner.GetIntId(), outer.GetIntId()
            assert inner.parent is outer
            assert inner.GetParentIntId() == numbers[1]
            assert number_in(world.interface("position", f"{name}_child")) == numbers
            apart = inner.GetPose().pos.z - outer.GetPose().pos.z
            assert apart == pytest.approx(0.5, abs=1e-3)
            if kind == "c++":
                body = outer.GetBody()
                expected = [str(numbers[1]), "of", str(numbers[1]), "body", body.bodyName or "(none)"]
                assert seen[f"{name}_child"][3:4] == [f"{name}_parent"]
                assert seen[f"{name}_child"][5:10] == expected
                assert float(seen[f"{name}_child"][-1]) == pytest.approx(body.GetPose().pos.z, abs=0.05)
    assert [record.getMessage() for record in caplog.records if record.levelno >= logging.ERROR] == []
