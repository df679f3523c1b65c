"""Ready plugins: Gazebo's own, rewritten, and two that join the eras. Worlds name them by their old file names.

`libDiffDrivePlugin.so` is `diffdriveplugin.py` here: the case of letters does not matter. A plugin of the same name in
GAZEBO_PLUGIN_PATH comes first. What each does, and the elements that it reads, stand in its class.
"""
