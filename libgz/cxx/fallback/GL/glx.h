/* For machines without OpenGL's headers. License: Apache License 2.0. */
#ifndef LIBGZ_GLX_H
#define LIBGZ_GLX_H
#include <GL/gl.h>
typedef void *GLXContext;
#endif
