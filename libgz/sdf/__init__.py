"""SDF, the world and model format of Gazebo classic: elements with the defaults of their version."""
