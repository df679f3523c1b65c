"""The ODE library: its declared functions, and what its absence is reported as."""

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
