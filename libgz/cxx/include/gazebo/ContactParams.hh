/* Parameters of contacts. License: Apache License 2.0. */

#ifndef LIBGZ_CONTACTPARAMS_HH
#define LIBGZ_CONTACTPARAMS_HH

#include "LibgzObject.hh"

class ContactParams;

/// One parameter: a number, whose changes reach the geom.
class LibgzContactParam
{
  public: LibgzContactParam( ContactParams *params, double number ) : owner( params ), value( number ) {}
  public: operator double() const { return this->value; }
  public: LibgzContactParam &operator=( double number );
  public: LibgzContactParam &operator=( const LibgzContactParam &other ) { return *this = (double) other; }
  public: LibgzContactParam &operator+=( double number ) { return *this = this->value + number; }
  public: LibgzContactParam &operator-=( double number ) { return *this = this->value - number; }
  public: LibgzContactParam &operator*=( double number ) { return *this = this->value * number; }
  public: LibgzContactParam &operator/=( double number ) { return *this = this->value / number; }
  private: LibgzContactParam( const LibgzContactParam & );
  private: ContactParams *owner;
  private: double value;
  friend class ContactParams;
  friend class BaseGeom;
};

/// Parameters of contacts, with the values of new geoms.
class ContactParams
{
  public: ContactParams()
    : kp( this, 10000.0 ), kd( this, 0.0 ), bounce( this, 0.0 ), mu1( this, HUGE_VAL ), mu2( this, HUGE_VAL ),
      slip1( this, 0.01 ), slip2( this, 0.01 ), libgz_handle( 0 ), libgz_changed( false )
    {
    }
  public: ContactParams( const ContactParams &other )
    : kp( this, other.kp ), kd( this, other.kd ), bounce( this, other.bounce ), mu1( this, other.mu1 ),
      mu2( this, other.mu2 ), slip1( this, other.slip1 ), slip2( this, other.slip2 ), libgz_handle( 0 ),
      libgz_changed( true )
    {
    }
  public: ContactParams &operator=( const ContactParams &other )
    {
      this->kp.value = other.kp;
      this->kd.value = other.kd;
      this->bounce.value = other.bounce;
      this->mu1.value = other.mu1;
      this->mu2.value = other.mu2;
      this->slip1.value = other.slip1;
      this->slip2.value = other.slip2;
      this->libgz_send();
      return *this;
    }

  public: LibgzContactParam kp; // [N/m]
  public: LibgzContactParam kd; // [N s/m]
  public: LibgzContactParam bounce;
  public: LibgzContactParam mu1, mu2;
  public: LibgzContactParam slip1, slip2; // stored without effect

  /// These are the parameters of a geom.
  public: void libgz_attach( long handle )
    {
      this->libgz_handle = handle;
      if ( this->libgz_changed )
        this->libgz_send();
    }
  public: void libgz_send()
    {
      this->libgz_changed = true;
      if ( this->libgz_handle == 0 )
        return;
      libgz_bound->BaseGeom_SetContact( this->libgz_handle, this->kp, this->kd, this->bounce, this->mu1, this->mu2 );
      libgz_check();
    }
  private: long libgz_handle;
  private: bool libgz_changed;
};

inline LibgzContactParam &LibgzContactParam::operator=( double number )
{
  this->value = number;
  this->owner->libgz_send();
  return *this;
}

#endif
