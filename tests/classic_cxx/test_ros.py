"""Plugins for ROS 1 get the node that they expect; a library with roscpp's functions stands in for it."""

import logging
import socket
import subprocess

import libgz
from libgz.cxx.build import compiler

ROSCPP = """
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <map>
#include <string>
#include <thread>
static std::atomic<int> inits, starts, spins;
static std::string node;
namespace ros {
void init(const std::map<std::string, std::string> &, const std::string &name, uint32_t options)
{
  node = name + " " + std::to_string(options);
  ++inits;
}
bool isInitialized() { return inits > 0; }
void start() { ++starts; }
void spin() { ++spins; std::this_thread::sleep_for(std::chrono::hours(1)); }
}
extern "C" const char *said()
{
  static std::string text;
  while (starts && !spins)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  return (text = node + " " + std::to_string(inits) + std::to_string(starts) + std::to_string(spins)).c_str();
}
"""
PLUGIN = """
#include <string>
extern "C" const char *said();
extern "C" void *libgz_new_plugin() {{ throw std::string(said()); }}
extern "C" const char *libgz_classic_plugin() {{ return "libgz classic plugin: World; {key}; {folder};"; }}
"""
WORLD = """<sdf version="1.6"><world name="default">
<plugin name="one" filename="libone.so"/><plugin name="two" filename="libtwo.so"/></world></sdf>"""


def test_a_plugin_for_ros_gets_a_node_if_there_is_a_master(place, library, caplog, monkeypatch):
    def build(output, source, *options):
        (place / "source.cc").write_text(source)
        command = [*compiler(), "-shared", "-fPIC", "-o", place / output, place / "source.cc", *options]
        subprocess.run(command, check=True)

    build("libroscpp.so.1", ROSCPP, "-Wl,-soname,libroscpp.so.1", "-pthread")
    for name in ("one", "two"):
        text = PLUGIN.format(key=library.key, folder=library.lib)
        build(f"lib{name}.so", text, f"-L{place}", "-l:libroscpp.so.1", "-Wl,-rpath,$ORIGIN")

    def messages():
        with libgz.World.from_string(WORLD):
            return [record.getMessage() for record in caplog.records if record.levelno >= logging.WARNING]

    with socket.create_server(("127.0.0.1", 0)) as master:
        port = master.getsockname()[1]
    monkeypatch.setenv("ROS_MASTER_URI", f"http://127.0.0.1:{port}")
    found = messages()
    assert f"uses ROS 1, and no master answers at http://127.0.0.1:{port}: start roscore first" in found[0]
    caplog.clear()
    for name in ("one", "two"):
        (place / f"lib{name}.so").write_bytes((place / f"lib{name}.so").read_bytes())  # as if built again
    with socket.create_server(("127.0.0.1", 0)) as master:
        monkeypatch.setenv("ROS_MASTER_URI", f"http://127.0.0.1:{master.getsockname()[1]}")
        found = messages()
    assert len(found) == 2
    assert all("it threw the text gazebo_plugins 1 111" in text for text in found)
