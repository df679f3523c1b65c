// What plugins ask of the client, without its window, which qt.cc has. License: Apache License 2.0.
#include "bridge.hh"
#include "gazebo/libgz/gui.hh"

namespace libgz {
static const char *const CLIENT = "libgz.classic_cxx.client";
void *main_window = nullptr;  // a gazebo::gui::MainWindow, once a plugin has widgets

void no_window(const char *name)
{
  throw std::runtime_error(std::string(name) + " is of Gazebo's own window, which libgz does not have");
}
void pause_world(bool pause) { call_function<void>(CLIENT, "pause", pause); }
bool find_property(const std::string &key, std::string &value)
{
  Call call(CLIENT, nullptr, "find_property");
  call << key;
  return give(call, value);
}
void set_property(const std::string &key, const std::string &value)
{
  call_function<void>(CLIENT, "set_property", key, value);
}
void drop_filters(const void *plugin)
{
  gazebo::gui::KeyEventHandler::Instance()->Drop(plugin);
  gazebo::gui::MouseEventHandler::Instance()->Drop(plugin);
}
}  // namespace libgz

namespace gazebo {
namespace gui {
using libgz::CLIENT;
static const char *const GUI = "libgz.classic.gui";

bool load() { only_in_programs("gui::load"); }
void init() { only_in_programs("gui::init"); }
bool run(int, char **) { only_in_programs("gui::run"); }
void stop() { only_in_programs("gui::stop"); }
void set_world(const std::string &) { only_in_programs("gui::set_world"); }
std::string get_world() { return call_function<std::string>(GUI, "get_world"); }
void set_active_camera(rendering::UserCameraPtr camera) { call_function<void>(GUI, "set_active_camera", camera); }
rendering::UserCameraPtr get_active_camera()
{
  return call_function<rendering::UserCameraPtr>(GUI, "get_active_camera");
}
void clear_active_camera() { set_active_camera(nullptr); }
MainWindow *get_main_window() { return static_cast<MainWindow *>(libgz::main_window); }
unsigned int get_entity_id(const std::string &name)
{
  return call_function<unsigned int>(CLIENT, "entity_id", name);
}
bool has_entity_name(const std::string &name) { return get_entity_id(name) != 0; }
#define LIBGZ_GUI_EVENT(Name, name, type) event::WorldEvent<type> Events::name("gui." #Name);
LIBGZ_GUI_EVENTS
#undef LIBGZ_GUI_EVENT

template <typename E>
void Filters<E>::Add(const std::string &name, Function function)
{
  this->Remove(name);
  this->all.push_back({name, std::move(function), libgz::running_plugin()});
}
template <typename E>
void Filters<E>::Remove(const std::string &name)
{
  this->all.remove_if([&](const One &one) { return one.name == name; });
}
template <typename E>
void Filters<E>::Drop(const void *plugin)
{
  this->all.remove_if([&](const One &one) { return one.plugin.get() == plugin; });
}
template <typename E>
bool Filters<E>::Handle(const E &event)
{
  bool handled = false;
  const std::list<One> now = this->all;  // a filter may remove itself
  for (auto one = now.begin(); one != now.end() && !handled; ++one)
    libgz::run_as(one->plugin, "an event filter", [&] { handled = one->function(event); });
  return handled;
}
template class Filters<common::KeyEvent>;
template class Filters<common::MouseEvent>;
KeyEventHandler *KeyEventHandler::Instance() { return SingletonT<KeyEventHandler>::Instance(); }
void KeyEventHandler::Drop(const void *plugin)
{
  for (auto *filters : {&this->press, &this->release})
    filters->Drop(plugin);
}
MouseEventHandler *MouseEventHandler::Instance() { return SingletonT<MouseEventHandler>::Instance(); }
void MouseEventHandler::Drop(const void *plugin)
{
  for (auto *filters : {&this->press, &this->release, &this->move, &this->twice})
    filters->Drop(plugin);
}
}  // namespace gui
}  // namespace gazebo
