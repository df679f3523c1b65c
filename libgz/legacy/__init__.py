"""Gazebo 0.4 to 0.7: models of worldfiles, their factory, their plugins and the world's settings."""
