/* The interfaces, for plugins that are compiled without an installation. */
#include "../../clib/gazebo.h"
