"""The program that a server runs with the user's own Python of ROS 2, alone in its folder, which its imports see."""
