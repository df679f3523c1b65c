/* For sources that include <gazebo/gazebo.h>. License: Apache License 2.0. */
#include "../gazebo.h"
