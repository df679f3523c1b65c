/* Values of ignition-math as Eigen's, for plugins that use the library DART beside the engine.
 * License: Apache License 2.0.
 */
#ifndef LIBGZ_DART_HH
#define LIBGZ_DART_HH
#include <Eigen/Geometry>

#include "gazebo/libgz/gazebo.hh"

namespace gazebo {
namespace physics {
class DARTTypes
{
 public:
  static Eigen::Vector3d ConvVec3(const ignition::math::Vector3d &v) { return {v.X(), v.Y(), v.Z()}; }
  static ignition::math::Vector3d ConvVec3Ign(const Eigen::Vector3d &v) { return {v.x(), v.y(), v.z()}; }
  static Eigen::Quaterniond ConvQuat(const ignition::math::Quaterniond &q) { return {q.W(), q.X(), q.Y(), q.Z()}; }
  static ignition::math::Quaterniond ConvQuatIgn(const Eigen::Quaterniond &q) { return {q.w(), q.x(), q.y(), q.z()}; }
  static Eigen::Isometry3d ConvPose(const ignition::math::Pose3d &pose)
  {
    return Eigen::Translation3d(ConvVec3(pose.Pos())) * ConvQuat(pose.Rot());
  }
  static ignition::math::Pose3d ConvPoseIgn(const Eigen::Isometry3d &pose)
  {
    return {ConvVec3Ign(pose.translation()), ConvQuatIgn(Eigen::Quaterniond(pose.linear()))};
  }
};
}  // namespace physics
}  // namespace gazebo
#endif
