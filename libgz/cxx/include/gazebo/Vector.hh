/* Vectors, quaternions and poses: the same arithmetic, in the same order, as libgz.base.geometry. License: Apache License 2.0. */

#ifndef LIBGZ_VECTOR_HH
#define LIBGZ_VECTOR_HH

#include "Global.hh"

/// A position [m] or direction.
struct GzVector
{
  double x, y, z;
};

/// A rotation, the scalar first.
struct GzQuatern
{
  double u, x, y, z;
};

/// A position [m] and a rotation.
struct GzPose
{
  GzVector pos;
  GzQuatern rot;
};

/// A rotation matrix.
typedef struct
{
  double m[3][3];
} GzHomo;

inline GzVector GzVectorSet( double x, double y, double z )
{
  GzVector v;
  v.x = x;
  v.y = y;
  v.z = z;
  return v;
}

inline GzVector GzVectorZero()
{
  return GzVectorSet( 0, 0, 0 );
}

inline GzVector GzVectorSetQuatern( GzQuatern q )
{
  return GzVectorSet( q.x, q.y, q.z );
}

/// b + a.
inline GzVector GzVectorAdd( GzVector b, GzVector a )
{
  return GzVectorSet( b.x + a.x, b.y + a.y, b.z + a.z );
}

/// b - a.
inline GzVector GzVectorSub( GzVector b, GzVector a )
{
  return GzVectorSet( b.x - a.x, b.y - a.y, b.z - a.z );
}

inline GzVector GzVectorMul( double s, GzVector a )
{
  return GzVectorSet( s * a.x, s * a.y, s * a.z );
}

inline double GzVectorMag( GzVector a )
{
  return sqrt( a.x * a.x + a.y * a.y + a.z * a.z );
}

/// The unit vector along a; of a zero vector, NaN.
inline GzVector GzVectorUnit( GzVector a )
{
  return GzVectorMul( 1.0 / GzVectorMag( a ), a );
}

inline GzVector GzVectorCross( GzVector a, GzVector b )
{
  return GzVectorSet( a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x );
}

inline double GzVectorDot( GzVector a, GzVector b )
{
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

inline bool libgz_finite( double number )
{
  return number - number == 0.0;
}

inline bool GzVectorFinite( GzVector a )
{
  return libgz_finite( a.x ) && libgz_finite( a.y ) && libgz_finite( a.z );
}

inline GzQuatern GzQuaternSet( double u, double x, double y, double z )
{
  GzQuatern q;
  q.u = u;
  q.x = x;
  q.y = y;
  q.z = z;
  return q;
}

inline GzQuatern GzQuaternIdent()
{
  return GzQuaternSet( 1, 0, 0, 0 );
}

/// (0, v).
inline GzQuatern GzQuaternSetVector( GzVector v )
{
  return GzQuaternSet( 0, v.x, v.y, v.z );
}

inline bool GzQuaternFinite( GzQuatern a )
{
  return libgz_finite( a.u ) && libgz_finite( a.x ) && libgz_finite( a.y ) && libgz_finite( a.z );
}

/// The conjugate.
inline GzQuatern GzQuaternInverse( GzQuatern a )
{
  return GzQuaternSet( a.u, -a.x, -a.y, -a.z );
}

inline GzQuatern GzQuaternNormal( GzQuatern a )
{
  double s = sqrt( a.u * a.u + a.x * a.x + a.y * a.y + a.z * a.z );
  return GzQuaternSet( a.u / s, a.x / s, a.y / s, a.z / s );
}

/// A rotation by an angle [rad] about an axis of any length; about a zero axis, none.
inline GzQuatern GzQuaternFromAxis( double x, double y, double z, double angle )
{
  double length = sqrt( x * x + y * y + z * z ), s;
  if ( length == 0.0 )
    return GzQuaternIdent();
  s = sin( angle / 2.0 ) / length;
  return GzQuaternNormal( GzQuaternSet( cos( angle / 2.0 ), s * x, s * y, s * z ) );
}

/// The angle [rad] as u; x, y, z are the vector part, unchanged.
inline GzQuatern GzQuaternToAxis( GzQuatern q )
{
  double u = q.u > -1.0 ? q.u : -1.0;
  return GzQuaternSet( 2.0 * acos( u < 1.0 ? u : 1.0 ), q.x, q.y, q.z );
}

/// qz(yaw) qy(pitch) qx(roll) [rad].
inline GzQuatern GzQuaternFromEuler( double roll, double pitch, double yaw )
{
  double cr = cos( roll / 2.0 ), sr = sin( roll / 2.0 );
  double cp = cos( pitch / 2.0 ), sp = sin( pitch / 2.0 );
  double cy = cos( yaw / 2.0 ), sy = sin( yaw / 2.0 );
  return GzQuaternNormal( GzQuaternSet( cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy,
                                        cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy ) );
}

/// For a steep pitch; the method is that of Bernardes and Viollet, PLoS ONE 17 (2022) e0276302.
inline GzVector libgz_steep_euler( GzQuatern q )
{
  double up = hypot( q.u + q.y, q.x - q.z ), down = hypot( q.u - q.y, q.x + q.z );
  double total = atan2( q.x + q.z, q.u - q.y ), difference = atan2( q.x - q.z, q.u + q.y );
  double pitch = 2.0 * atan2( up, down ) - M_PI / 2.0;
  if ( Min( up, down ) < 1e-10 * Max( up, down ) )
    return GzVectorSet( NORMALIZE( 2.0 * ( up > down ? difference : total ) ), pitch, 0.0 );
  return GzVectorSet( NORMALIZE( total + difference ), pitch, NORMALIZE( total - difference ) );
}

/// Roll, pitch, yaw [rad].
inline GzVector GzQuaternToEuler( GzQuatern q )
{
  double sine = -2.0 * ( q.x * q.z - q.u * q.y ), roll, yaw;
  if ( fabs( sine ) > 0.99 )
    return libgz_steep_euler( q );
  roll = atan2( 2.0 * ( q.y * q.z + q.u * q.x ), q.u * q.u - q.x * q.x - q.y * q.y + q.z * q.z );
  yaw = atan2( 2.0 * ( q.x * q.y + q.u * q.z ), q.u * q.u + q.x * q.x - q.y * q.y - q.z * q.z );
  return GzVectorSet( roll, asin( sine ), yaw );
}

/// The Hamilton product a b: rotate by b, then by a.
inline GzQuatern GzQuaternMul( GzQuatern a, GzQuatern b )
{
  return GzQuaternSet( a.u * b.u - a.x * b.x - a.y * b.y - a.z * b.z, a.u * b.x + a.x * b.u + a.y * b.z - a.z * b.y,
                       a.u * b.y - a.x * b.z + a.y * b.u + a.z * b.x, a.u * b.z + a.x * b.y - a.y * b.x + a.z * b.u );
}

/// The same axis, the angle times s.
inline GzQuatern GzQuaternScale( double s, GzQuatern a )
{
  GzQuatern axis = GzQuaternToAxis( a );
  return GzQuaternFromAxis( axis.x, axis.y, axis.z, s * axis.u );
}

inline GzHomo GzHomoFromQuatern( GzQuatern q )
{
  double u = q.u, x = q.x, y = q.y, z = q.z;
  GzHomo h = { { { 1 - 2 * ( y * y + z * z ), 2 * ( x * y - u * z ), 2 * ( x * z + u * y ) },
                 { 2 * ( x * y + u * z ), 1 - 2 * ( x * x + z * z ), 2 * ( y * z - u * x ) },
                 { 2 * ( x * z - u * y ), 2 * ( y * z + u * x ), 1 - 2 * ( x * x + y * y ) } } };
  return h;
}

/// Stable at every angle (the four-case method of Shepperd, 1978).
inline GzQuatern GzQuaternFromHomo( GzHomo h )
{
  double( *m )[3] = h.m;
  double trace = m[0][0] + m[1][1] + m[2][2];
  double largest = trace;
  int i, which = 0;
  GzQuatern q;
  for ( i = 0; i < 3; i++ )
    if ( m[i][i] > largest )
    {
      largest = m[i][i];
      which = i + 1;
    }
  if ( which == 0 )
    q = GzQuaternSet( 1.0 + trace, m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1] );
  else if ( which == 1 )
    q = GzQuaternSet( m[2][1] - m[1][2], 1.0 + m[0][0] - m[1][1] - m[2][2], m[0][1] + m[1][0], m[0][2] + m[2][0] );
  else if ( which == 2 )
    q = GzQuaternSet( m[0][2] - m[2][0], m[0][1] + m[1][0], 1.0 + m[1][1] - m[0][0] - m[2][2], m[1][2] + m[2][1] );
  else
    q = GzQuaternSet( m[1][0] - m[0][1], m[0][2] + m[2][0], m[1][2] + m[2][1], 1.0 + m[2][2] - m[0][0] - m[1][1] );
  return GzQuaternNormal( q );
}

inline GzHomo GzHomoInverse( GzHomo h )
{
  GzHomo result;
  int i, j;
  for ( i = 0; i < 3; i++ )
    for ( j = 0; j < 3; j++ )
      result.m[i][j] = h.m[j][i];
  return result;
}

inline GzVector GzHomoMul( GzHomo h, GzVector v )
{
  return GzVectorSet( h.m[0][0] * v.x + h.m[0][1] * v.y + h.m[0][2] * v.z,
                      h.m[1][0] * v.x + h.m[1][1] * v.y + h.m[1][2] * v.z,
                      h.m[2][0] * v.x + h.m[2][1] * v.y + h.m[2][2] * v.z );
}

inline GzPose GzPoseSet( GzVector pos, GzQuatern rot )
{
  GzPose pose;
  pose.pos = pos;
  pose.rot = rot;
  return pose;
}

inline bool GzPoseFinite( GzPose a )
{
  return GzVectorFinite( a.pos ) && GzQuaternFinite( a.rot );
}

/// The pose at `pos` whose x axis points towards `at`, and whose z axis is as near to `up` as possible.
inline GzPose GzPosePointAt( GzVector pos, GzVector at, GzVector up )
{
  GzVector x = GzVectorUnit( GzVectorSub( at, pos ) );
  GzVector y = GzVectorUnit( GzVectorCross( up, x ) );
  GzVector z = GzVectorCross( x, y );
  GzHomo h = { { { x.x, y.x, z.x }, { x.y, y.y, z.y }, { x.z, y.z, z.z } } };
  return GzPoseSet( pos, GzQuaternFromHomo( h ) );
}

inline GzVector libgz_rotate( GzQuatern q, GzVector v )
{
  double tx = 2.0 * ( q.y * v.z - q.z * v.y ), ty = 2.0 * ( q.z * v.x - q.x * v.z ), tz = 2.0 * ( q.x * v.y - q.y * v.x );
  return GzVectorSet( v.x + q.u * tx + ( q.y * tz - q.z * ty ), v.y + q.u * ty + ( q.z * tx - q.x * tz ),
                      v.z + q.u * tz + ( q.x * ty - q.y * tx ) );
}

/// A position in the frame (apos, arot), in that frame's outer frame.
inline GzVector GzCoordPositionAdd( GzVector bpos, GzVector apos, GzQuatern arot )
{
  return GzVectorAdd( apos, libgz_rotate( arot, bpos ) );
}

/// A position relative to the frame (apos, arot).
inline GzVector GzCoordPositionSub( GzVector bpos, GzVector apos, GzQuatern arot )
{
  return libgz_rotate( GzQuaternInverse( arot ), GzVectorSub( bpos, apos ) );
}

inline GzQuatern GzCoordRotationAdd( GzQuatern b, GzQuatern a )
{
  return GzQuaternMul( a, b );
}

inline GzQuatern GzCoordRotationSub( GzQuatern b, GzQuatern a )
{
  return GzQuaternMul( GzQuaternInverse( a ), b );
}

/// c = b + a: the pose b, given in frame a, in a's outer frame.
inline GzPose GzCoordPoseAdd( GzPose b, GzPose a )
{
  return GzPoseSet( GzCoordPositionAdd( b.pos, a.pos, a.rot ), GzCoordRotationAdd( b.rot, a.rot ) );
}

/// c = b - a: the pose b relative to a.
inline GzPose GzCoordPoseSub( GzPose b, GzPose a )
{
  return GzPoseSet( GzCoordPositionSub( b.pos, a.pos, a.rot ), GzCoordRotationSub( b.rot, a.rot ) );
}

/// The frame a for which b = ba + a.
inline GzPose GzCoordPoseSolve( GzPose ba, GzPose b )
{
  GzQuatern rot = GzQuaternMul( b.rot, GzQuaternInverse( ba.rot ) );
  return GzPoseSet( GzVectorSub( b.pos, libgz_rotate( rot, ba.pos ) ), rot );
}

#endif
