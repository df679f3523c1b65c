/* How libgz creates and calls the models of a plugin. License: Apache License 2.0. */

#ifndef LIBGZ_MODELFACTORY_HH
#define LIBGZ_MODELFACTORY_HH

#include "Body.hh"
#include "Error.hh"
#include "Geom.hh"
#include "HingeJoint.hh"
#include "Model.hh"
#include "World.hh"
#include "WorldFile.hh"

#ifdef LIBGZ_EXCEPTIONS
#include <cxxabi.h>
#include <exception>
#endif

/// Creates a model of a class.
typedef Model *( *ModelFactoryFn )( World * );

/// The classes of models by the names that worldfiles give them.
class ModelFactory
{
  public: static void RegisterAll() {}

  public: static void RegisterModel( const char *type, const char *classname, ModelFactoryFn create )
    {
      libgz_bound->Factory_RegisterModel( type, classname, (void *) create );
    }

  /// A new model; NULL if the name is unknown.
  public: static Model *NewModel( World *world, const char *classname )
    {
      void *model = libgz_bound->Factory_NewModel( libgz_handle_of( world ), classname );
      libgz_check();
      return (Model *) model;
    }
};

#define GZ_REGISTER_STATIC( name, classname )                                                                         \
  Model *New##classname( World *world )                                                                               \
  {                                                                                                                   \
    return new classname( world );                                                                                    \
  }                                                                                                                   \
  void Register##classname()                                                                                          \
  {                                                                                                                   \
    ModelFactory::RegisterModel( "static", name, New##classname );                                                    \
  }

#define GZ_REGISTER_PLUGIN( name, classname )                                                                         \
  Model *New##classname( World *world )                                                                               \
  {                                                                                                                   \
    return new classname( world );                                                                                    \
  }                                                                                                                   \
  extern "C" {                                                                                                        \
    __attribute__( ( visibility( "default" ) ) ) int gazebo_plugin_init( void )                                       \
    {                                                                                                                 \
      ModelFactory::RegisterModel( "plugin", name, New##classname );                                                  \
      return 0;                                                                                                       \
    }                                                                                                                 \
  }

/// A model of libgz, or of another plugin.
class LibgzModel : public Model
{
  public: LibgzModel( World *owner, long handle ) : Model( owner, handle ) {}
  public: virtual int Load( WorldFile *file, WorldFileNode *element )
    {
      int result
        = libgz_bound->Model_Load( this->libgz_handle, libgz_handle_of( file ), libgz_handle_of( element ) );
      libgz_check();
      return result;
    }
  public: virtual int Init( WorldFile *file, WorldFileNode *element )
    {
      int result
        = libgz_bound->Model_Init( this->libgz_handle, libgz_handle_of( file ), libgz_handle_of( element ) );
      libgz_check();
      return result;
    }
  public: virtual int Fini()
    {
      int result = libgz_bound->Model_Fini( this->libgz_handle );
      libgz_check();
      return result;
    }
  public: virtual void Update( double step )
    {
      libgz_bound->Model_Update( this->libgz_handle, step );
      libgz_check();
    }
};

/// Marks what runs on this thread, for the message after a crash.
class LibgzRunning
{
  public: LibgzRunning( const char *method, const char *label ) : top( libgz_bound->frames() )
    {
      this->frame.below = *this->top;
      this->frame.method = method;
      this->frame.label = label;
      this->frame.failed = 0;
      *this->top = &this->frame;
    }
  public: ~LibgzRunning() { *this->top = this->frame.below; }
  private: libgz_frame **top;
  private: libgz_frame frame;
};

enum { LIBGZ_DONE, LIBGZ_RETURNED, LIBGZ_FAILED, LIBGZ_THREW };
enum { LIBGZ_LOAD, LIBGZ_INIT, LIBGZ_FINI };

#ifdef LIBGZ_EXCEPTIONS
/// Describe the exception that is being handled.
inline int libgz_describe( char *text, size_t size, const char *what )
{
  const std::type_info *type = abi::__cxa_current_exception_type();
  int status = -1;
  char *name = type != NULL ? abi::__cxa_demangle( type->name(), NULL, NULL, &status ) : NULL;
  snprintf( text, size, "%s%s%s", name != NULL ? name : "an exception of unknown type", what != NULL ? ": " : "",
            what != NULL ? what : "" );
  free( name );
  return LIBGZ_THREW;
}

#define LIBGZ_TRY try {
#define LIBGZ_CATCH                                                                                                   \
  }                                                                                                                   \
  catch ( const libgz_error & )                                                                                       \
  {                                                                                                                   \
    return LIBGZ_FAILED;                                                                                              \
  }                                                                                                                   \
  catch ( const std::exception &error )                                                                               \
  {                                                                                                                   \
    return libgz_describe( text, size, error.what() );                                                                \
  }                                                                                                                   \
  catch ( const char *message )                                                                                       \
  {                                                                                                                   \
    return libgz_describe( text, size, message );                                                                     \
  }                                                                                                                   \
  catch ( const abi::__forced_unwind & )                                                                              \
  {                                                                                                                   \
    throw;                                                                                                            \
  }                                                                                                                   \
  catch ( ... )                                                                                                       \
  {                                                                                                                   \
    return libgz_describe( text, size, NULL );                                                                        \
  }
#else
#define LIBGZ_TRY
#define LIBGZ_CATCH
#endif

LIBGZ_EXPORT int libgz_plugin_create( ModelFactoryFn create, World *world, const char *label, void **model, char *text,
                                      size_t size )
{
  LibgzRunning running( "the constructor", label );
  (void) text;
  (void) size;
  LIBGZ_TRY
  *model = create( world );
  LIBGZ_CATCH
  return LIBGZ_DONE;
}

LIBGZ_EXPORT int libgz_plugin_call( Model *model, int method, WorldFile *file, WorldFileNode *node, const char *label,
                                    int *result, char *text, size_t size )
{
  static const char *const names[] = { "Load", "Init", "Fini" };
  LibgzRunning running( names[method], label );
  (void) text;
  (void) size;
  LIBGZ_TRY
  *result = method == LIBGZ_LOAD ? model->Load( file, node ) : method == LIBGZ_INIT ? model->Init( file, node ) : model->Fini();
  LIBGZ_CATCH
  return *result == 0 ? LIBGZ_DONE : LIBGZ_RETURNED;
}

LIBGZ_EXPORT int libgz_plugin_update( Model *model, double step, const char *label, char *text, size_t size )
{
  LibgzRunning running( "Update", label );
  (void) text;
  (void) size;
  LIBGZ_TRY
  model->Update( step );
  LIBGZ_CATCH
  return LIBGZ_DONE;
}

LIBGZ_EXPORT int libgz_plugin_delete( LibgzObject *object, const char *label, char *text, size_t size )
{
  LibgzRunning running( "the destructor", label );
  (void) text;
  (void) size;
  LIBGZ_TRY
  delete object;
  LIBGZ_CATCH
  return LIBGZ_DONE;
}

/// An object that stands for one of libgz.
LIBGZ_EXPORT void *libgz_plugin_wrap( const char *kind, long handle, World *world )
{
  if ( strcmp( kind, "World" ) == 0 )
    return new World( LIBGZ_WRAPPING, handle );
  if ( strcmp( kind, "Model" ) == 0 )
    return new LibgzModel( world, handle );
  if ( strcmp( kind, "Body" ) == 0 )
    return new Body( LIBGZ_WRAPPING, handle );
  if ( strcmp( kind, "Geom" ) == 0 )
    return new Geom( LIBGZ_WRAPPING, handle );
  if ( strcmp( kind, "HingeJoint" ) == 0 )
    return new HingeJoint( LIBGZ_WRAPPING, handle );
  if ( strcmp( kind, "WorldFile" ) == 0 )
    return new WorldFile( LIBGZ_WRAPPING, handle );
  if ( strcmp( kind, "WorldFileNode" ) == 0 )
    return new WorldFileNode( LIBGZ_WRAPPING, handle );
  return NULL;
}

LIBGZ_EXPORT void *libgz_plugin_fields( LibgzObject *object )
{
  return &static_cast<World *>( object )->gz_server;
}

LIBGZ_EXPORT int libgz_plugin_on_heap( const LibgzObject *object )
{
  return object->libgz_heap;
}

#endif
