"""What is missing where OpenGL does not work, and the packages that contain it."""

import ctypes

import pytest

from libgz.rendering import chain

EGL = chain.CHAINS["egl"]


@pytest.fixture
def machine(monkeypatch, tmp_path):
    """A machine with the libraries that the test names, and without any other."""
    present = {}

    def load(name):
        if name in present:
            return present[name]
        absent = next((needed for whole, needed in present.get("broken", ()) if whole == name), name)
        raise OSError(f"{absent}: cannot open shared object file: No such file or directory")

    monkeypatch.setattr(ctypes, "CDLL", load)
    monkeypatch.setattr(chain, "DRIVER_FOLDERS", (str(tmp_path / "dri"),))
    monkeypatch.setattr(chain, "VENDOR_FOLDERS", (str(tmp_path / "vendors"),))
    monkeypatch.setattr(chain, "_loaded", lambda: "libGLdispatch.so.0")
    for name in ("__EGL_VENDOR_LIBRARY_FILENAMES", "__EGL_VENDOR_LIBRARY_DIRS", "LIBGL_DRIVERS_PATH"):
        monkeypatch.delenv(name, raising=False)
    return present


def test_everything_missing_names_all_packages_once(machine):
    assert chain.advice("egl") == (
        "missing: libEGL.so.1, egl_vendor.d/50_mesa.json, libEGL_mesa.so.0, swrast_dri.so; "
        "install with apt-get install libegl1 libegl-mesa0 libgl1-mesa-dri (Debian, Ubuntu); "
        "dnf install libglvnd-egl mesa-libEGL mesa-dri-drivers (Fedora); pacman -S libglvnd mesa (Arch)"
    )
    assert chain.advice("osmesa") == (
        "missing: libOSMesa.so.8; install with apt-get install libosmesa6 (Debian, Ubuntu); "
        "dnf install mesa-compat-libOSMesa (Fedora); systems with Mesa 25.1 or later have EGL only"
    )


def test_one_missing_link_is_named(machine, tmp_path):
    machine.update({"libEGL.so.1": 1, "libEGL_mesa.so.0": 1})
    (tmp_path / "vendors").mkdir()
    (tmp_path / "vendors" / "50_mesa.json").write_text("{}")
    assert chain.advice("egl").startswith("missing: swrast_dri.so; install with apt-get install libgl1-mesa-dri (Deb")
    driver = tmp_path / "dri" / "swrast_dri.so"
    driver.parent.mkdir()
    driver.write_text("")
    machine["broken"] = [(str(driver), "libLLVM-15.so.1")]
    assert chain.advice("egl").startswith(f"missing: libLLVM-15.so.1, which {driver} needs; install with apt-get")
    machine[str(driver)] = 1
    assert chain.advice("egl") == "all libraries of egl are present"
    (tmp_path / "vendors" / "50_mesa.json").unlink()
    assert chain.advice("egl").startswith(
        "missing: egl_vendor.d/50_mesa.json; install with apt-get install libegl-mesa0"
    )


def test_the_renderer_of_a_newer_mesa_is_a_library(machine, monkeypatch):
    monkeypatch.setattr(chain, "_loaded", lambda: "libgallium-25.0.7.so")
    machine.update({"libEGL.so.1": 1, "libEGL_mesa.so.0": 1})
    assert chain.advice("egl") == "all libraries of egl are present"


def test_a_library_that_needs_another_one_says_so(machine):
    machine["broken"] = [("libOSMesa.so.8", "libglapi.so.0")]
    assert chain.advice("osmesa").startswith("missing: libglapi.so.0, which libOSMesa.so.8 needs; install with")


def test_this_machine_lacks_nothing_that_renders():
    from libgz.rendering.context import CONTEXTS

    for name, kind in CONTEXTS.items():
        kind().close()
        assert chain.advice(name) == f"all libraries of {name} are present"
