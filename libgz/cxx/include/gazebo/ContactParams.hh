/* Parameters of contacts. License: Apache License 2.0. */

#ifndef LIBGZ_CONTACTPARAMS_HH
#define LIBGZ_CONTACTPARAMS_HH

#include "Global.hh"

/// Parameters of contacts, with the values of new geoms.
class ContactParams
{
  public: ContactParams()
    : kp( 10000.0 ), kd( 0.0 ), bounce( 0.0 ), mu1( HUGE_VAL ), mu2( HUGE_VAL ), slip1( 0.01 ), slip2( 0.01 )
    {
    }
  public: double kp; // [N/m]
  public: double kd; // [N s/m]
  public: double bounce;
  public: double mu1, mu2;
  public: double slip1, slip2;
};

#endif
