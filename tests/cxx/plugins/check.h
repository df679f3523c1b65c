// What all of these plugins use to check what they see.
#ifndef CHECK_H
#define CHECK_H

#include <math.h>
#include <gazebo/Error.hh>

#define CHECK( condition )                                                                                            \
  if ( !( condition ) )                                                                                               \
  {                                                                                                                   \
    PRINT_ERR1( "this is not so: %s", #condition );                                                                   \
    return -1;                                                                                                        \
  }

// In Update, which returns nothing.
#define EXPECT( condition )                                                                                           \
  if ( !( condition ) )                                                                                               \
    throw #condition

#define NEAR( a, b, most ) ( fabs( ( a ) - ( b ) ) <= ( most ) )

#endif
