"""The ODE library: its declared functions, and what its absence is reported as."""

import ctypes
from pathlib import Path

import pytest

import libgz
from libgz.ode import lib
from libgz.ode.lib import ode


def test_undeclared_and_absent_functions_explain_themselves(monkeypatch):
    library = ode()
    with pytest.raises(AttributeError, match="did you mean 'dWorldStep'"):
        _ = library.dWorldStepp
    monkeypatch.setitem(library._declared, "dNoSuchFunction", (None, []))
    with pytest.raises(libgz.LibraryError, match="has no function dNoSuchFunction"):
        library.dNoSuchFunction()


def test_all_declared_functions_exist():
    library = ode()
    missing = [name for name in library._declared if not hasattr(library._shared, name)]
    assert missing == []


def test_a_missing_library_says_how_to_install_it(monkeypatch):
    monkeypatch.setenv("LIBGZ_ODE", "libnothere.so.1")
    with pytest.raises(libgz.LibraryError, match="apt-get install libode8"):
        lib.OdeLibrary()


def test_a_second_library_keeps_the_handlers_of_the_first():
    """The native step has one of its own, by which it survives failed assertions."""
    before = lib.ode().dGetDebugHandler()
    assert before
    lib.OdeLibrary()
    assert lib.ode().dGetDebugHandler() == before


def system_library():
    """The file of the system's library."""
    _ = ode()
    maps = Path("/proc/self/maps").read_text().splitlines()
    return Path(next(line.split()[-1] for line in maps if "libode.so" in line))


@pytest.fixture
def bundled(monkeypatch, tmp_path):
    """A library that is bundled as in a wheel."""
    path = tmp_path / "libode.so.8"
    path.symlink_to(system_library())
    monkeypatch.setattr(lib, "bundled_path", lambda: path)
    monkeypatch.delenv("LIBGZ_ODE", raising=False)
    return path


def test_the_order_of_libraries(bundled, monkeypatch, tmp_path, caplog):
    assert (lib.OdeLibrary().path, lib.OdeLibrary().origin) == ("libode.so.8", "of the system")
    monkeypatch.setenv("LIBGZ_ODE", "bundled")
    chosen = lib.OdeLibrary()
    assert (chosen.path, chosen.origin) == (str(bundled), "bundled, chosen by LIBGZ_ODE=bundled")
    named = tmp_path / "my_ode.so"
    named.symlink_to(system_library())
    monkeypatch.setenv("LIBGZ_ODE", str(named))
    assert (lib.OdeLibrary().path, lib.OdeLibrary().origin) == (str(named), "named by LIBGZ_ODE")
    monkeypatch.delenv("LIBGZ_ODE")
    monkeypatch.setattr(lib, "LIBRARY", "libnothere.so.8")
    with caplog.at_level("DEBUG"):
        assert (lib.OdeLibrary().path, lib.OdeLibrary().origin) == (str(bundled), "bundled")
    assert not caplog.records  # as it is meant to be with a wheel: gzserver --verbose has nothing to say of it


def test_a_library_of_single_precision_is_passed_over(bundled, monkeypatch, caplog):
    real = ctypes.PyDLL

    def load(name):
        library = real(name)
        if name == "libode.so.8":
            library.dCheckConfiguration = lambda token: 0
        return library

    monkeypatch.setattr(ctypes, "PyDLL", load)
    with caplog.at_level("DEBUG"):
        assert lib.OdeLibrary().origin == "bundled"
    assert "libode.so.8 is built for single precision; libgz needs doubles" in caplog.text
    monkeypatch.setattr(lib, "bundled_path", lambda: None)
    with pytest.raises(libgz.LibraryError, match=r"single precision; libgz needs doubles; apt-get install libode8"):
        lib.OdeLibrary()


def test_a_checkout_has_no_bundled_library(monkeypatch):
    monkeypatch.setattr(lib, "bundled_path", lambda: None)
    monkeypatch.setenv("LIBGZ_ODE", "bundled")
    with pytest.raises(libgz.LibraryError, match="LIBGZ_ODE=bundled, but this installation contains no ODE library"):
        lib.OdeLibrary()
