/* The surface of a collision, whose fields are those of an object of Python. License: Apache License 2.0. */
#ifndef LIBGZ_SURFACE_HH
#define LIBGZ_SURFACE_HH
#include "gazebo/libgz/classes.hh"

namespace gazebo {
namespace physics {

using libgz::Field;

class GAZEBO_VISIBLE SurfaceParams : public libgz::Object
{
 public:
  explicit SurfaceParams(libgz::Adopt view) : Object(view) {}
  virtual ~SurfaceParams() {}
  virtual FrictionPyramidPtr FrictionPyramid() const;
  virtual void FillMsg(msgs::Surface &message);
  virtual void ProcessMsg(const msgs::Surface &message);
#if GAZEBO_MAJOR_VERSION < 8
  FrictionPyramidPtr GetFrictionPyramid() const { return this->FrictionPyramid(); }
#endif
  Field<bool> collideWithoutContact{this, "collideWithoutContact"};
  Field<unsigned int> collideWithoutContactBitmask{this, "collideWithoutContactBitmask"};
  Field<unsigned int> collideBitmask{this, "collideBitmask"};
};

class GAZEBO_VISIBLE ODESurfaceParams : public SurfaceParams
{
 public:
  explicit ODESurfaceParams(libgz::Adopt view) : SurfaceParams(view) {}
  void FillMsg(msgs::Surface &message) override;
  void ProcessMsg(const msgs::Surface &message) override;
  Field<double> bounce{this, "bounce"}, bounceThreshold{this, "bounceThreshold"}, kp{this, "kp"}, kd{this, "kd"};
  Field<double> cfm{this, "cfm"}, erp{this, "erp"}, maxVel{this, "maxVel"}, minDepth{this, "minDepth"};
  Field<double> slip1{this, "slip1"}, slip2{this, "slip2"};
};
typedef boost::shared_ptr<ODESurfaceParams> ODESurfaceParamsPtr;
}  // namespace physics
}  // namespace gazebo
#endif
