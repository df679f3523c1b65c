"""Gazebo classic's API on SDF worlds."""
