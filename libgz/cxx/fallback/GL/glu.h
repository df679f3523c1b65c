/* The header of this name, or none on machines without it. License: Apache License 2.0. */

#ifndef LIBGZ_FALLBACK_GLU_H
#define LIBGZ_FALLBACK_GLU_H

#if defined( __has_include_next )
#if __has_include_next( <GL/glu.h> )
#define LIBGZ_OWN_HEADER
#endif
#endif

#ifdef LIBGZ_OWN_HEADER
#undef LIBGZ_OWN_HEADER
#include_next <GL/glu.h>
#else

#include <GL/gl.h>

#endif

#endif
