/* ODE's types and parameters: those of its own header where libode-dev is installed. License: Apache License 2.0. */

#ifndef LIBGZ_ODE_HH
#define LIBGZ_ODE_HH

#include <ode/ode.h>

#endif
