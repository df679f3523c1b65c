"""ROS: the topics, services and plugins of gazebo_ros_pkgs, without an installation of ROS on this computer."""
