"""Worlds of Gazebo classic: models, links, joints, surfaces and lights of SDF documents on the engine."""
