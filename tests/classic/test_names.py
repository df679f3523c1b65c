"""Whatever takes a name says so when it is given an object: every method and function of the classic API."""

import inspect
import pkgutil
from importlib import import_module

import pytest
from sensor_worlds import box, world_of

import libgz
import libgz.classic
from libgz.classic.names import takes_names

PACKAGES = ("common", "gui", "physics", "rendering", "sensors", "transport", "sdf")


def modules():
    for name in PACKAGES:
        package = import_module(f"libgz.classic.{name}")
        yield package
        for found in pkgutil.iter_modules(getattr(package, "__path__", ()), f"{package.__name__}."):
            yield import_module(found.name)


def public_calls():
    """(title, function) of all methods with capitals, and of what the packages export."""
    found = {}
    for module in modules():
        for name in dir(module):
            value = getattr(module, name)
            if inspect.isclass(value) and value.__module__ == module.__name__ and not name.startswith("_"):
                for method, function in vars(value).items():
                    if inspect.isfunction(function) and not method.startswith("_") and not method.islower():
                        found[f"{name}.{method}"] = function
            elif inspect.isfunction(value) and module.__name__.count(".") == 2 and name in module.__all__:
                found[name] = value
    return found


CALLS = public_calls()


def names_of(function):
    """The parameters that are names: those of files may be paths, and items of a sequence are looked at later."""
    for parameter in inspect.signature(function).parameters.values():
        kinds = str(parameter.annotation).split(" | ")
        if (
            "str" in kinds
            and "[" not in str(parameter.annotation)
            and not any(word in parameter.name.lower() for word in ("file", "path"))
        ):
            yield parameter.name


CASES = [(title, name) for title, function in CALLS.items() for name in names_of(function)]


class Thing:
    def GetName(self):
        return "arm"


def test_there_are_such_parameters():
    assert len(CASES) > 120
    assert ("JointController.SetPositionPID", "jointName") in CASES


@pytest.mark.parametrize(("title", "name"), CASES, ids=lambda value: value)
def test_an_object_for_a_name_is_an_error(title, name):
    with pytest.raises(libgz.ParameterError, match=rf"{name} must be a string.*; its name is 'arm'$"):
        CALLS[title](**{name: Thing()})


def test_the_sentence_names_method_parameter_and_object():
    with world_of(box("crate", "0 0 1")):
        model = libgz.classic.physics.get_world().ModelByName("crate")
        with pytest.raises(
            libgz.ParameterError, match=r"^Model.GetLink: name must be a string, not a Link; its name is 'link'$"
        ):
            model.GetLink(model.GetLink())
        with pytest.raises(libgz.ParameterError, match=r"ModelByName: name must be a string, not None$"):
            model.GetWorld().ModelByName(None)


def test_what_is_allowed_besides_a_name_passes():
    @takes_names
    class Shelf:
        def Get(self, which: "int | str | Thing | None" = None):
            return which

    shelf, thing = Shelf(), Thing()
    assert [shelf.Get(), shelf.Get(2), shelf.Get("a"), shelf.Get(which=thing)] == [None, 2, "a", thing]
    with pytest.raises(libgz.ParameterError, match=r"a string or an int or a Thing or None, not a float$"):
        shelf.Get(1.5)
