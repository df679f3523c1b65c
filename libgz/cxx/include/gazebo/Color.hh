/* Colours. License: Apache License 2.0. */

#ifndef LIBGZ_COLOR_HH
#define LIBGZ_COLOR_HH

#include "Global.hh"

/// Red, green, blue and alpha.
class GzColor
{
  public: GzColor() : r( 0 ), g( 0 ), b( 0 ), a( 1 ) {}
  public: GzColor( double red, double green, double blue, double alpha = 1.0 )
    : r( (GLfloat) red ), g( (GLfloat) green ), b( (GLfloat) blue ), a( (GLfloat) alpha )
    {
    }
  public: operator const GLfloat *() { return &this->r; }
  public: GLfloat r, g, b, a;
};

#define GZ_COLOR_COPY( x, y ) x[0] = y.r; x[1] = y.g; x[2] = y.b; x[3] = y.a;

#endif
