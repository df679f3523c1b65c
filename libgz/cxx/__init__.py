"""C++ plugin models of Gazebo 0.5 to 0.7: headers to compile them with, and the adapter that runs them.

A C++ object of a plugin holds the handle of an object of `libgz.legacy` or `libgz.physics`, and each of its methods
calls a Python function through a table (`table.py`), so that all state stays in one place.

A plugin model is compiled with libgz's headers, and linked with nothing. `wheel->SetParam( dParamVel, 2 )` is inline
code
that calls a function of a table with the object's handle; `table.py` made that function by ctypes, and it calls
`HingeJoint.SetParam`. So there is one set of bodies, tables and rules for both languages.

- A `.so` carries a mark with libgz's version and a hash of the table (`headers.mark`), which is read before it is
  loaded.
- A file is loaded from a copy (`shared_object.py`), for the dynamic linker knows files by their names, and users
  overwrite
them. It is unloaded when nothing in Python refers to its `CxxPlugin`: the classes of its models do, and so their
  worlds.
- `CxxModel` calls the C++ object's `Load`, `Init`, `Update`, `Fini` through functions that the headers put into each
  plugin (`ModelFactory.hh`); these catch exceptions and mark what runs, for the line after a crash (`host.c`).
- When a Python function fails, it keeps its exception, and the C++ method throws `libgz_error` through the plugin's
  code.
- `gz_*` functions are those of the C library, compiled into `_host.so`; for the server of the process (`host.h`) they
  call
  `HostedServer`, so that interfaces are those of the world.
- Handles live as long as C++ objects (`objects.py`). What a model's code left behind is deleted with the model.
- Layouts of structs for 32-bit programs follow from the same declarations (`for_abi` in `libgz/transport/layout.py`); a
  plugin on such a server writes a `Shadow`.
"""

from pathlib import Path

FOLDER = Path(__file__).resolve().parent
