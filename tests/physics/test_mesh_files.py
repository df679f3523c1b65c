"""Mesh files: what a scene instantiates is bounded."""

import numpy as np
import pytest
from sample_files import sample

from libgz.base.errors import GazeboError
from libgz.physics import mesh_files
from libgz.physics.mesh_files import read_mesh

NODE = '<node id="n">'
FAN = "".join(f'<node id="n{i}">{f"""<instance_node url="#n{i + 1}"/>""" * 10}</node>' for i in range(8))


@pytest.fixture
def read(tmp_path):
    def reader(old, new):
        path = tmp_path / "scene.dae"
        path.write_text(sample("dae", 0).decode().replace(old, new))
        return read_mesh(path)

    return reader


def test_a_node_may_be_instantiated_twice(read):
    once, twice = read(NODE, NODE), read('<instance_node url="#n"/>', '<instance_node url="#n"/>' * 2)
    assert sum(len(part.triangles) for part in twice) > sum(len(part.triangles) for part in once)
    assert np.isfinite(np.concatenate([part.vertices for part in twice])).all()


def test_a_node_that_contains_itself_is_an_error(read):
    with pytest.raises(GazeboError, match=r"scene.dae cannot be read: .*node 'n' contains itself"):
        read(NODE, f'{NODE}<node><instance_node url="#n"/></node>')


def test_a_scene_that_grows_by_powers_of_ten_is_an_error(read, monkeypatch):
    monkeypatch.setattr(mesh_files, "MOST_NODES", 1000)
    with pytest.raises(GazeboError, match="its scene has more than 1000 nodes and geometries"):
        read(NODE, f'{FAN}<node id="n8"/><node id="n"><instance_node url="#n0"/>')
