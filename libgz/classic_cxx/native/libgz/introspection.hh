/* Values that plugins offer by name. License: Apache License 2.0. */
#ifndef LIBGZ_INTROSPECTION_HH
#define LIBGZ_INTROSPECTION_HH
#include <functional>
#include <mutex>
#include <set>

#include "gazebo/libgz/msgs.hh"

namespace gazebo {
namespace util {

/* The names that plugins have registered. Clients of Gazebo ask for the values by ignition-transport, those of libgz
   do not: so no value is computed, and an update has nothing to send. */
class GAZEBO_VISIBLE IntrospectionManager
{
 public:
  static IntrospectionManager *Instance();
  std::string Id() const { return this->id; }
  template <typename T>
  bool Register(const std::string &item, const std::function<T()> &)
  {
    static_assert(sizeof(msgs::ConvertAny(std::declval<T>())), "an item has a type of msgs::Any");
    return this->Add(item);
  }
  bool Unregister(const std::string &item);
  void Clear();
  std::set<std::string> Items() const;
  void Update() {}
  void NotifyUpdates() {}

 private:
  IntrospectionManager();
  bool Add(const std::string &item);

  std::string id;
  mutable std::mutex mutex;
  std::set<std::string> items;
};

}  // namespace util
}  // namespace gazebo
#endif
