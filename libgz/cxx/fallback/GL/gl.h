/* OpenGL's header, or its types and constants on machines without it (Debian: libgl-dev). License: Apache License 2.0. */

#ifndef LIBGZ_FALLBACK_GL_H
#define LIBGZ_FALLBACK_GL_H

#if defined( __has_include_next )
#if __has_include_next( <GL/gl.h> )
#define LIBGZ_OWN_HEADER
#endif
#endif

#ifdef LIBGZ_OWN_HEADER
#undef LIBGZ_OWN_HEADER
#include_next <GL/gl.h>
#else

typedef unsigned int GLenum;
typedef unsigned char GLboolean;
typedef unsigned int GLbitfield;
typedef void GLvoid;
typedef signed char GLbyte;
typedef short GLshort;
typedef int GLint;
typedef unsigned char GLubyte;
typedef unsigned short GLushort;
typedef unsigned int GLuint;
typedef int GLsizei;
typedef float GLfloat;
typedef float GLclampf;
typedef double GLdouble;
typedef double GLclampd;

#define GL_FALSE 0
#define GL_TRUE 1
#define GL_LINE 0x1B01
#define GL_FILL 0x1B02
#define GL_FLAT 0x1D00
#define GL_SMOOTH 0x1D01
#define GL_UNSIGNED_BYTE 0x1401
#define GL_FLOAT 0x1406
#define GL_RGB 0x1907
#define GL_RGBA 0x1908
#define GL_LUMINANCE 0x1909
#define GL_LUMINANCE_ALPHA 0x190A

#endif

#endif
