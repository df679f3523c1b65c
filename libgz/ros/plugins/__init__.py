"""Plugins of gazebo_ros_pkgs, with the topics, parameters and defaults of the originals."""
