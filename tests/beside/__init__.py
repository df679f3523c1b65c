"""Worlds that were run beside the real Gazebo 11.1, and where their links were after 2,000 iterations there."""
