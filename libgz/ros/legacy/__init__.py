"""Legacy worlds as ROS sees them: what their interfaces are in messages, and the services of /gazebo for them."""
