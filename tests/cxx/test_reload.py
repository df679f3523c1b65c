"""C++ models that are compiled again while their world runs."""

import pytest
from cxx_plugins import compiled, load, needs_cxx

from libgz.base.errors import PluginError
from libgz.cxx.headers import mark

pytestmark = needs_cxx

# What a model does is chosen by a file, so that one compilation serves for several versions.
LIFT = "this->body->SetLinearVel( GzVectorSet( SPEED, 0, 0 ) );"
FAILS = 'if ( getenv( "TESTER_FAILS" ) ) throw std::runtime_error( "no motor" );'
INCLUDES = "#include <stdexcept>\n#include <stdlib.h>\n"


@pytest.fixture(scope="module")
def versions(tmp_path_factory):
    """Two versions of a model: their files."""
    from cxx_plugins import source

    folder, files = tmp_path_factory.mktemp("versions"), []
    for speed in ("1.0", "-3.0"):
        (folder / speed).mkdir()
        text = INCLUDES + source(load=FAILS, update=LIFT.replace("SPEED", speed))
        files.append(compiled(folder / speed, text=text).read_bytes())
    return files


@pytest.fixture
def world(tmp_path, versions):
    (tmp_path / "Tester.so").write_bytes(versions[0])
    with load(tmp_path, ("Tester", "<xyz>0 0 9</xyz>"), ("Tester", "<xyz>0 5 9</xyz>")) as made:
        made.step(5)
        yield made


def speeds(world):
    world.step(2)
    return [model.GetBody().GetLinearVel().x for model in world.models]


@pytest.mark.parametrize("name", ["m0", "Tester", "Tester.so"])
def test_a_model_that_was_compiled_again_takes_the_place_of_the_former_one(world, tmp_path, versions, name):
    assert speeds(world) == pytest.approx([1.0, 1.0])
    places = [tuple(model.GetPose().pos) for model in world.models]
    new = tmp_path / "next.so"
    new.write_bytes(versions[1])
    new.replace(tmp_path / "Tester.so")
    assert world.reload_plugin(name) == ["model m0 (Tester)", "model m1 (Tester)"]
    assert [tuple(model.GetPose().pos) for model in world.models] == places
    assert speeds(world) == pytest.approx([-3.0, -3.0])


def test_a_file_that_is_overwritten_in_place_is_loaded_again(world, tmp_path, versions):
    (tmp_path / "Tester.so").write_bytes(versions[1])
    world.reload_plugin("Tester")
    assert speeds(world) == pytest.approx([-3.0, -3.0])


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (lambda data: b"\x7fELF" + bytes(100), r"is no C\+\+ plugin of libgz"),
        (
            lambda data: data.replace(mark().encode(), mark().encode().replace(b"libgz 0.", b"libgz 9.")),
            "needs libgz 9",
        ),
        (lambda data: data[: len(data) // 3], "the file is truncated"),
        (None, "No such file or directory"),
    ],
    ids=["no plugin", "for another libgz", "cut", "deleted"],
)
def test_what_cannot_be_loaded_is_refused_and_the_former_models_run_on(world, tmp_path, versions, damage, said):
    path = tmp_path / "Tester.so"
    if damage is None:
        path.unlink()
    else:
        path.write_bytes(damage(versions[1]))
    with pytest.raises(PluginError, match=said):
        world.reload_plugin("Tester")
    assert speeds(world) == pytest.approx([1.0, 1.0])


def test_a_load_that_throws_keeps_the_former_models(world, tmp_path, versions, monkeypatch):
    (tmp_path / "Tester.so").write_bytes(versions[1])
    monkeypatch.setenv("TESTER_FAILS", "1")
    with pytest.raises(PluginError, match="Load of model 'm0' threw std::runtime_error: no motor"):
        world.reload_plugin("Tester")
    assert speeds(world) == pytest.approx([1.0, 1.0])
