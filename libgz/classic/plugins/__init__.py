"""Ready plugins: Gazebo's own, rewritten, and two that connect the eras. Worlds name them by their old file names.

`libDiffDrivePlugin.so` means `diffdriveplugin.py`: the case of letters does not matter. A plugin of the same name in
GAZEBO_PLUGIN_PATH is preferred. The docstring of each class describes it and the elements that it reads.
"""
