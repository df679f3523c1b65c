/* What all classes have in common: the connection to libgz, which plugins need not know. License: Apache License 2.0. */

#ifndef LIBGZ_LIBGZOBJECT_HH
#define LIBGZ_LIBGZOBJECT_HH

#include "Global.hh"
#include "LibgzFrame.h"
#include "LibgzTable.hh"

#include <gazebo.h>

#include <new>

#define LIBGZ_EXPORT extern "C" __attribute__( ( weak, used, visibility( "default" ) ) )
#define LIBGZ_OWN __attribute__( ( weak, visibility( "hidden" ) ) )

#if defined( __EXCEPTIONS ) || defined( __cpp_exceptions )
#define LIBGZ_EXCEPTIONS 1
#endif

/// By this, libgz finds its plugins among other files.
LIBGZ_EXPORT const char libgz_plugin_mark[] = LIBGZ_MARK;

/// The version of the structs of interfaces that it was compiled with.
LIBGZ_EXPORT const int libgz_plugin_wire = LIBGAZEBO_VERSION;

/// The functions of libgz.
LIBGZ_OWN const libgz_table *libgz_bound = NULL;
extern "C" { extern __attribute__( ( weak ) ) const libgz_table *gz_host_table; }

/// Objects at file scope are constructed after this.
LIBGZ_OWN __attribute__( ( constructor( 101 ) ) ) void libgz_bind()
{
  if ( &gz_host_table != NULL )
    libgz_bound = gz_host_table;
}

/// The block of the object that is being created with `new`.
LIBGZ_OWN void *libgz_block = NULL;

/* With -nostartfiles, as old Makefiles link, nothing else destroys objects at file scope when the file is unloaded. */
extern "C"
{
  LIBGZ_OWN void *__dso_handle = &__dso_handle;
  void __cxa_finalize( void * );
}
LIBGZ_OWN __attribute__( ( destructor ) ) void libgz_unload()
{
  __cxa_finalize( __dso_handle );
}

/// The first argument of constructors of objects that stand for one of libgz.
enum libgz_wrapping
{
  LIBGZ_WRAPPING
};

/// Thrown after a function of libgz failed, through the plugin's code.
struct libgz_error
{
};

inline void libgz_check()
{
#ifdef LIBGZ_EXCEPTIONS
  libgz_frame *frame = *libgz_bound->frames();
  if ( frame != NULL && frame->failed )
  {
    frame->failed = 0;
    throw libgz_error();
  }
#endif
}

inline const char *libgz_text( const char *text, const char *def )
{
  libgz_check();
  return text != NULL ? text : def;
}

/// Base of all classes of the old API.
class LibgzObject
{
  public: LibgzObject() : libgz_handle( 0 ), libgz_wraps( false )
    {
      this->libgz_heap = libgz_block == (void *) this;
      if ( this->libgz_heap )
        libgz_block = NULL;
    }
  public: virtual ~LibgzObject()
    {
      if ( this->libgz_handle != 0 && !*libgz_bound->ended )
        libgz_bound->Object_destroyed( this->libgz_handle, this, !this->libgz_wraps );
    }

  public: static void *operator new( size_t size )
    {
      void *block = ::operator new( size );
      libgz_block = block;
      return block;
    }
  public: static void *operator new( size_t, void *place ) { return place; }
  public: static void operator delete( void *block ) { ::operator delete( block ); }

  /// Stand for an object that libgz made.
  protected: void libgz_wrap( long handle )
    {
      this->libgz_handle = handle;
      this->libgz_wraps = true;
    }

  public: long libgz_handle;
  public: bool libgz_wraps;
  public: bool libgz_heap; // made by `new`
  private: LibgzObject( const LibgzObject & );
  private: LibgzObject &operator=( const LibgzObject & );
};

/// The handle of an object of any class; 0 for NULL. LibgzObject is the first base of them all.
inline long libgz_handle_of( const void *object )
{
  return object == NULL ? 0 : ( (const LibgzObject *) object )->libgz_handle;
}

#define LIBGZ_QUATERN( q ) ( q ).u, ( q ).x, ( q ).y, ( q ).z
#define LIBGZ_POSE( p ) ( p ).pos.x, ( p ).pos.y, ( p ).pos.z, LIBGZ_QUATERN( ( p ).rot )

#endif
