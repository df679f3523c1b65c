"""C++ plugins of Gazebo classic, compiled unmodified: headers, the library behind them, and what runs them.

A method of a C++ object calls the method of the same name of a view of `libgz.classic`, so that plugins of both
languages share one world. `api.tsv` is the table of signatures; `generate.py` makes headers and forwards of it, and
`native/` has what no table says: conversions (`bridge.hh`), calls of plugins (`bridge.cc`), plain values and functions
(`library.cc`), the calls of every step, which read and write the engine's tables (`hot.cc`), and the node of plugins
for ROS (`roscpp.cc`). What native code shares with Python's side, such as records and functions of ODE, it includes as
`shared.hh`, which `layouts.py` makes of the declarations there.

- `library.py` builds `libgazebo.so.11` once on the user's machine; plugins are linked with it by that name, and find it
  because Python has loaded it before.
- A plugin carries a mark: its kind, the key of its library, and where that is. The mark is read before it is loaded.
- An object of Python has one C++ object, which it keeps in its dictionary. Both live while a pointer of C++ refers to
  it; otherwise Python's collector finds them as one circle.
- Code of plugins runs without the interpreter's lock; each call of a method takes it.
- What code of a plugin throws becomes a PluginError, and stops that plugin; what Python raises becomes an exception of
  C++ on its way through the plugin's code.
"""

from pathlib import Path

FOLDER = Path(__file__).resolve().parent
