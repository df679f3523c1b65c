/* Types, constants and macros of the old C++ API. License: Apache License 2.0. */

#ifndef LIBGZ_GLOBAL_HH
#define LIBGZ_GLOBAL_HH

/* Old sources rely on what the old headers included. */
#include <assert.h>
#include <errno.h>
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/time.h>
#include <sys/types.h>
#include <time.h>
#include <unistd.h>

#include <GL/gl.h>

typedef unsigned char uchar;
typedef unsigned short ushort;
typedef unsigned int uint;
typedef unsigned long ulong;
typedef int ( *gz_plugin_init_fn_t )( void );

typedef struct gz_server gz_server_t;
typedef struct gz_sim gz_sim_t;

#define GZ_ALL_COLLIDE 0xFFFFFFFF
#define GZ_NONE_COLLIDE 0x00000000
#define GZ_FIXED_COLLIDE 0x00000001
#define GZ_LASER_COLLIDE 0x00000002

#define GZ_ALL_CAMERA 0xFFFFFFFF
#define GZ_LASER_CAMERA 0x00000001
#define GZ_GUIDATA_CAMERA 0x00000002

#define GZ_RENDER_MAX_PASSES 3
#define GZ_RENDER_LIGHT 0
#define GZ_RENDER_OPAQUE 1
#define GZ_RENDER_TRANSPARENT 2

#ifndef M_PI
#define M_PI 3.14159265358979323846
#endif

#define RTOD( r ) ( ( r ) *180 / M_PI )
#define DTOR( d ) ( ( d ) *M_PI / 180 )
#define NORMALIZE( a ) ( atan2( sin( a ), cos( a ) ) )
#define IsEven( x ) ( ( ( x ) % 2 ) == 0 )
#define IsOdd( x ) ( ( ( x ) % 2 ) != 0 )
#define Max( x, y ) ( ( x ) > ( y ) ? ( x ) : ( y ) )
#define Min( x, y ) ( ( x ) < ( y ) ? ( x ) : ( y ) )
#define Round( x ) ( (int) ( floor( ( x ) + 0.5 ) ) )

#ifndef GAZEBO_TEXTURES_PATH
#define GAZEBO_TEXTURES_PATH "."
#endif
#ifndef GAZEBO_SKINS_PATH
#define GAZEBO_SKINS_PATH "."
#endif

#endif
