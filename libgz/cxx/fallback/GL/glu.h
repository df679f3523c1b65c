/* For machines without OpenGL's headers. License: Apache License 2.0. */
#include <GL/gl.h>
