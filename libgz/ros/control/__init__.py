"""Controllers of ros_control: the robot's joints as hardware, controllers, and the services that manage them."""
