"""The names of Gazebo classic (1-11), as thin views on the engine."""
