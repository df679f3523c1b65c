/* GL contexts of the old server: accepted without effect. License: Apache License 2.0. */

#ifndef LIBGZ_GLCONTEXT_HH
#define LIBGZ_GLCONTEXT_HH

#include "Global.hh"

/// Accepted without effect: libgz has contexts of its own.
class GLContext
{
  public: GLContext() {}
  public: virtual ~GLContext() {}
  public: int Init( int, int, int, int, int, const char *, void * = NULL ) { return 0; }
  public: void Fini() {}
  public: void *GetContext() { return NULL; }
  public: int GetContextIndex() { return 0; }
  public: int MakeCurrent() { return 0; }
};

#endif
