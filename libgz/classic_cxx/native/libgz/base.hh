/* What all headers of Gazebo classic's C++ API stand on. License: Apache License 2.0. */
#ifndef LIBGZ_BASE_HH
#define LIBGZ_BASE_HH
#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/types.h>
#include <unistd.h>
#include <algorithm>
#include <any>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <fstream>
#include <functional>
#include <iomanip>
#include <iostream>
#include <limits>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>
#ifndef BOOST_BIND_GLOBAL_PLACEHOLDERS
#define BOOST_BIND_GLOBAL_PLACEHOLDERS  // plugins write boost::bind(&Push::OnUpdate, this, _1)
#endif
#ifndef BOOST_ENABLE_ASSERT_HANDLER
#define BOOST_ENABLE_ASSERT_HANDLER  // a null pointer throws, and ends one plugin, where classic aborts
#endif
#include <boost/algorithm/string.hpp>
#include <boost/any.hpp>
#include <boost/assert.hpp>
#include <boost/bind.hpp>
#include <boost/enable_shared_from_this.hpp>
#include <boost/filesystem.hpp>
#include <boost/function.hpp>
#include <boost/lexical_cast.hpp>
#include <boost/make_shared.hpp>
#include <boost/pointer_cast.hpp>
#include <boost/regex.hpp>
#include <boost/scoped_ptr.hpp>
#include <boost/shared_ptr.hpp>
#include <boost/thread.hpp>
#include <boost/weak_ptr.hpp>
#include <google/protobuf/message.h>
#include <ignition/math.hh>
#include <sdf/sdf.hh>

#include "gazebo/libgz/config.hh"

#define GAZEBO_VISIBLE __attribute__((visibility("default")))
#define GAZEBO_HIDDEN __attribute__((visibility("hidden")))
#define GZ_COMMON_VISIBLE GAZEBO_VISIBLE
#define GZ_COMMON_HIDDEN GAZEBO_HIDDEN
#define GZ_GUI_VISIBLE GAZEBO_VISIBLE
#define GZ_GUI_HIDDEN GAZEBO_HIDDEN
#define GZ_MATH_VISIBLE GAZEBO_VISIBLE
#define GZ_MATH_HIDDEN GAZEBO_HIDDEN
#define GZ_MSGS_VISIBLE GAZEBO_VISIBLE
#define GZ_MSGS_HIDDEN GAZEBO_HIDDEN
#define GZ_PHYSICS_VISIBLE GAZEBO_VISIBLE
#define GZ_PHYSICS_HIDDEN GAZEBO_HIDDEN
#define GZ_PLUGIN_VISIBLE GAZEBO_VISIBLE
#define GZ_PLUGIN_HIDDEN GAZEBO_HIDDEN
#define GZ_RENDERING_VISIBLE GAZEBO_VISIBLE
#define GZ_RENDERING_HIDDEN GAZEBO_HIDDEN
#define GZ_SENSORS_VISIBLE GAZEBO_VISIBLE
#define GZ_SENSORS_HIDDEN GAZEBO_HIDDEN
#define GZ_TRANSPORT_VISIBLE GAZEBO_VISIBLE
#define GZ_TRANSPORT_HIDDEN GAZEBO_HIDDEN
#define GZ_UTIL_VISIBLE GAZEBO_VISIBLE
#define GZ_UTIL_HIDDEN GAZEBO_HIDDEN
#define GAZEBO_DEPRECATED(version)
#define GAZEBO_FORCEINLINE inline __attribute__((always_inline))

#define GZ_ALL_COLLIDE 0x0FFFFFFF
#define GZ_NONE_COLLIDE 0x00000000
#define GZ_FIXED_COLLIDE 0x00000001
#define GZ_SENSOR_COLLIDE 0x00000002
#define GZ_GHOST_COLLIDE 0x10000000
#define GZ_VISIBILITY_ALL 0x0FFFFFFF
#define GZ_VISIBILITY_SELECTION 0x10000000
#define GZ_VISIBILITY_GUI 0x00000001
#define GZ_VISIBILITY_SELECTABLE 0x00000002
#define GZ_MODEL_MANIFEST_FILENAME "model.config"
#define GZ_MODEL_DB_MANIFEST_FILENAME "database.config"
#define GZ_LOG_VERSION "1.0"
#define GZ_OGRE_SET_MATERIAL_BY_NAME(object, material) ((object)->setMaterial(material))

namespace libgz {
/* What a C++ object stands for: an object of Python, a new reference. */
struct Adopt
{
  void *view;
};

/* Base of all classes whose methods call libgz's Python: holds the object of Python that does the work. */
class GAZEBO_VISIBLE Object
{
 public:
  explicit Object(Adopt view);
  Object(const Object &other);
  Object &operator=(const Object &other);
  virtual ~Object();
  friend bool operator==(const Object &one, const Object &other) { return one.view == other.view; }

  void *view;         // the object of Python
  void *row = nullptr;  // where the engine keeps its numbers, for the calls that plugins make in every step
  mutable void *kept = nullptr;  // results that methods return as references
  mutable int inner = 0;         // pointers to this in what objects keep
};

/* One number or text of an object of Python, which C++ code uses like a field. */
template <typename T>
class Field
{
 public:
  Field(Object *owner, const char *name) : owner(owner), name(name) {}
  operator T() const;
  Field &operator=(const T &value);
  Field &operator=(const Field &other) { return *this = static_cast<T>(other); }
  template <class U> Field &operator+=(const U &value) { return *this = static_cast<T>(*this) + value; }
  template <class U> Field &operator-=(const U &value) { return *this = static_cast<T>(*this) - value; }
  template <class U> Field &operator*=(const U &value) { return *this = static_cast<T>(*this) * value; }
  template <class U> Field &operator/=(const U &value) { return *this = static_cast<T>(*this) / value; }
  template <class U> Field &operator|=(const U &value) { return *this = static_cast<T>(*this) | value; }
  template <class U> Field &operator&=(const U &value) { return *this = static_cast<T>(*this) & value; }

 private:
  Object *owner;
  const char *name;
};

/* The gravity of a physics engine [m/s^2], which Gazebo 7 had there. */
ignition::math::Vector3d gravity_of(const Object *engine);
}  // namespace libgz
#endif
