/* What of gazebo::physics is plain numbers. License: Apache License 2.0. */
#ifndef LIBGZ_VALUES_HH
#define LIBGZ_VALUES_HH
#include "gazebo/libgz/types.hh"
#if GAZEBO_MAJOR_VERSION < 8
#include "gazebo/libgz/old_math.hh"
#endif

#define MAX_COLLIDE_RETURNS 250
#define MAX_CONTACT_JOINTS 250

namespace gazebo {
namespace physics {

#if GAZEBO_MAJOR_VERSION < 8
typedef math::Vector3 WrenchVector;  // three doubles in both
#else
typedef ignition::math::Vector3d WrenchVector;
#endif

class GAZEBO_VISIBLE JointWrench
{
 public:
  JointWrench &operator+(const JointWrench &other)
  {
    this->body1Force += other.body1Force;
    this->body2Force += other.body2Force;
    this->body1Torque += other.body1Torque;
    this->body2Torque += other.body2Torque;
    return *this;
  }
  JointWrench &operator-(const JointWrench &other)
  {
    this->body1Force -= other.body1Force;
    this->body2Force -= other.body2Force;
    this->body1Torque -= other.body1Torque;
    this->body2Torque -= other.body2Torque;
    return *this;
  }
  WrenchVector body1Force, body2Force, body1Torque, body2Torque;
};

class GAZEBO_VISIBLE Contact
{
 public:
  Contact() {}
  virtual ~Contact() {}
  Contact(const Contact &) = default;
  Contact &operator=(const Contact &) = default;
  Contact &operator=(const msgs::Contact &message);
  void FillMsg(msgs::Contact &message) const;
  std::string DebugString() const;
  void Reset() { this->count = 0; }
  Collision *collision1 = nullptr, *collision2 = nullptr;
  JointWrench wrench[MAX_CONTACT_JOINTS];
  WrenchVector positions[MAX_CONTACT_JOINTS], normals[MAX_CONTACT_JOINTS];
  double depths[MAX_CONTACT_JOINTS] = {};
  int count = 0;
  common::Time time;
  WorldPtr world;
};

class GAZEBO_VISIBLE TrajectoryInfo
{
 public:
  unsigned int id = 0;
  std::string type;
  double duration = 0.0, startTime = 0.0, endTime = 0.0;
  bool translated = false;
};
}  // namespace physics
}  // namespace gazebo
#endif
