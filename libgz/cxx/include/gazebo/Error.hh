/* Messages. License: Apache License 2.0. */

#ifndef LIBGZ_ERROR_HH
#define LIBGZ_ERROR_HH

#include "LibgzObject.hh"

#include <stdarg.h>

#define GZ_ERR_ERR 0
#define GZ_ERR_WARN 1
#define GZ_ERR_MSG 2
#define GZ_ERR_DBG 2

inline void ErrorInit( int, const char * = NULL ) {}
inline void ErrorFini() {}

/// Report a message; called by the macros below.
inline int ErrorPrint( int type, int level, const char *file, int line, const char *format, ... )
  __attribute__( ( format( printf, 5, 6 ) ) );

inline int ErrorPrint( int type, int level, const char *file, int line, const char *format, ... )
{
  char text[4096];
  va_list arguments;
  va_start( arguments, format );
  vsnprintf( text, sizeof text, format, arguments );
  va_end( arguments );
  if ( libgz_bound != NULL )
    libgz_bound->Error_Print( type, level, file, line, text );
  return 0;
}

inline int ErrorPrintGL( const char *, int )
{
  return 0;
}

#define PRINT_ERR( msg ) ErrorPrint( GZ_ERR_ERR, 0, __FILE__, __LINE__, msg "\n" )
#define PRINT_ERR1( msg, a ) ErrorPrint( GZ_ERR_ERR, 0, __FILE__, __LINE__, msg "\n", a )
#define PRINT_ERR2( msg, a, b ) ErrorPrint( GZ_ERR_ERR, 0, __FILE__, __LINE__, msg "\n", a, b )
#define PRINT_ERR3( msg, a, b, c ) ErrorPrint( GZ_ERR_ERR, 0, __FILE__, __LINE__, msg "\n", a, b, c )

#define PRINT_WARN( msg ) ErrorPrint( GZ_ERR_WARN, 0, __FILE__, __LINE__, msg "\n" )
#define PRINT_WARN1( msg, a ) ErrorPrint( GZ_ERR_WARN, 0, __FILE__, __LINE__, msg "\n", a )
#define PRINT_WARN2( msg, a, b ) ErrorPrint( GZ_ERR_WARN, 0, __FILE__, __LINE__, msg "\n", a, b )
#define PRINT_WARN3( msg, a, b, c ) ErrorPrint( GZ_ERR_WARN, 0, __FILE__, __LINE__, msg "\n", a, b, c )

#define PRINT_MSG0( level, msg ) ErrorPrint( GZ_ERR_MSG, level, __FILE__, __LINE__, msg "\n" )
#define PRINT_MSG1( level, msg, a ) ErrorPrint( GZ_ERR_MSG, level, __FILE__, __LINE__, msg "\n", a )
#define PRINT_MSG2( level, msg, a, b ) ErrorPrint( GZ_ERR_MSG, level, __FILE__, __LINE__, msg "\n", a, b )
#define PRINT_MSG3( level, msg, a, b, c ) ErrorPrint( GZ_ERR_MSG, level, __FILE__, __LINE__, msg "\n", a, b, c )
#define PRINT_MSG4( level, msg, a, b, c, d ) ErrorPrint( GZ_ERR_MSG, level, __FILE__, __LINE__, msg "\n", a, b, c, d )
#define PRINT_MSG5( level, msg, a, b, c, d, e )                                                                       \
  ErrorPrint( GZ_ERR_MSG, level, __FILE__, __LINE__, msg "\n", a, b, c, d, e )
#define PRINT_MSG6( level, msg, a, b, c, d, e, f )                                                                    \
  ErrorPrint( GZ_ERR_MSG, level, __FILE__, __LINE__, msg "\n", a, b, c, d, e, f )
#define PRINT_MSG7( level, msg, a, b, c, d, e, f, g )                                                                 \
  ErrorPrint( GZ_ERR_MSG, level, __FILE__, __LINE__, msg "\n", a, b, c, d, e, f, g )

#define PRINT_GL_ERR() ErrorPrintGL( __FILE__, __LINE__ )

#endif
