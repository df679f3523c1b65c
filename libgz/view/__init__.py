"""The live viewer: a running world in a browser. `libgz view` starts it; the extra ``view`` installs what it needs."""
