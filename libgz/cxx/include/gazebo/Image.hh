/* Images. License: Apache License 2.0. */

#ifndef LIBGZ_IMAGE_HH
#define LIBGZ_IMAGE_HH

#include "LibgzObject.hh"

#define MAP_IDX( mf, i, j ) ( ( mf->size_x ) * ( j ) + ( i ) )

/// An image of one to four components a pixel.
class GzImage
{
  public: GzImage() : width( 0 ), height( 0 ), components( 0 ), format( 0 ), type( 0 ), size( 0 ), data( NULL ) {}
  public: virtual ~GzImage() { free( this->data ); }

  /// Take an image of packed RGB, top row first; 0.
  public: int Set( int w, int h, const uint8_t *rgb )
    {
      this->libgz_take( w, h, 3, rgb );
      return 0;
    }

  /// Read a file; 0, or -1 after an error message.
  public: int Load( const char *filename )
    {
      int w = 0, h = 0, count = 0;
      const uint8_t *pixels = NULL;
      if ( libgz_bound->Image_Load( filename, &w, &h, &count, &pixels ) != 0 )
        return -1;
      this->libgz_take( w, h, count, pixels );
      return 0;
    }

  private: void libgz_take( int w, int h, int count, const uint8_t *pixels )
    {
      static const int formats[] = { GL_LUMINANCE, GL_LUMINANCE_ALPHA, GL_RGB, GL_RGBA };
      this->width = w;
      this->height = h;
      this->components = count;
      this->format = formats[count - 1];
      this->type = GL_UNSIGNED_BYTE;
      this->size = w * h * count;
      free( this->data );
      this->data = (uint8_t *) malloc( this->size + 1 );
      memcpy( this->data, pixels, this->size );
    }

  public: int width, height;
  public: int components;
  public: int format;
  public: int type;
  public: int size;
  public: uint8_t *data;
  private: GzImage( const GzImage & );
  private: GzImage &operator=( const GzImage & );
};

#endif
