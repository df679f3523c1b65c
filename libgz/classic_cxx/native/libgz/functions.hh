/* Functions of the namespaces. License: Apache License 2.0. */
#ifndef LIBGZ_FUNCTIONS_HH
#define LIBGZ_FUNCTIONS_HH
#include "gazebo/libgz/classes.hh"

namespace gazebo {
namespace physics {
bool load();
bool fini();
WorldPtr create_world(const std::string &name = "");
WorldPtr get_world(const std::string &name = "");
bool has_world(const std::string &name = "");
void run_world(WorldPtr world, unsigned int iterations = 0);
void stop_world(WorldPtr world);
void pause_world(WorldPtr world, bool pause);
void pause_worlds(bool pause);
void stop_worlds();
void run_worlds(unsigned int iterations = 0);
bool worlds_running();
uint32_t getUniqueId();
}  // namespace physics

namespace sensors {
bool load();
bool init();
bool fini();
SensorPtr get_sensor(const std::string &name);
std::string create_sensor(sdf::ElementPtr sdf, const std::string &world, const std::string &parent, uint32_t id);
void remove_sensor(const std::string &name);
bool remove_sensors();
void run_once(bool force = false);
void run_threads();
void stop();
void disable();
void enable();
bool running();
}  // namespace sensors

namespace rendering {
bool load();
bool init();
bool fini();
ScenePtr get_scene(const std::string &name = "");
ScenePtr create_scene(const std::string &name, bool visualizations, bool isServer = false);
void remove_scene(const std::string &name);
bool lockstep_enabled();
void set_lockstep_enabled(bool enabled);
}  // namespace rendering

#if GAZEBO_MAJOR_VERSION < 8
namespace common {
typedef ignition::math::Color Color;
}
namespace msgs {
inline math::Vector3 Convert(const msgs::Vector3d &v) { return ConvertIgn(v); }
inline math::Vector2d Convert(const msgs::Vector2d &v) { return ConvertIgn(v); }
inline math::Quaternion Convert(const msgs::Quaternion &v) { return ConvertIgn(v); }
inline math::Pose Convert(const msgs::Pose &v) { return ConvertIgn(v); }
}  // namespace msgs
#endif
}  // namespace gazebo
#endif
