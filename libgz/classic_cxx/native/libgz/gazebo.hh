/* The whole API; each header of classic includes this. License: Apache License 2.0. */
#ifndef LIBGZ_GAZEBO_HH
#define LIBGZ_GAZEBO_HH
#include "gazebo/libgz/classes.hh"
#include "gazebo/libgz/functions.hh"
#include "gazebo/libgz/ode.hh"
#include "gazebo/libgz/surface.hh"
#endif
