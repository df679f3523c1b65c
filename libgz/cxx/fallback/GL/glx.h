/* The header of this name, or its types on machines without it. License: Apache License 2.0. */

#ifndef LIBGZ_FALLBACK_GLX_H
#define LIBGZ_FALLBACK_GLX_H

#if defined( __has_include_next )
#if __has_include_next( <GL/glx.h> )
#define LIBGZ_OWN_HEADER
#endif
#endif

#ifdef LIBGZ_OWN_HEADER
#undef LIBGZ_OWN_HEADER
#include_next <GL/glx.h>
#else

#include <GL/gl.h>
typedef void *GLXContext;

#endif

#endif
