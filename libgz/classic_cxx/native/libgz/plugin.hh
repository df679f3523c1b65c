/* The kinds of plugins but that of the client, and how a file registers its class. License: Apache License 2.0. */
#ifndef LIBGZ_PLUGIN_HH
#define LIBGZ_PLUGIN_HH
#include <dlfcn.h>

#include "gazebo/libgz/types.hh"

namespace gazebo {
enum PluginType { WORLD_PLUGIN, MODEL_PLUGIN, SENSOR_PLUGIN, SYSTEM_PLUGIN, VISUAL_PLUGIN, GUI_PLUGIN };
}  // namespace gazebo

namespace gazebo {
namespace physics {
/* Connects a callback to an event of one object. */
event::ConnectionPtr libgz_connect(const libgz::Object *object, const char *method, std::function<void()> callback);
}  // namespace physics
}  // namespace gazebo

namespace libgz {
/* What the server calls, whatever kind of plugin it is. */
class GAZEBO_VISIBLE PluginRoot
{
 public:
  virtual ~PluginRoot() {}
  virtual void LibgzLoad(void *holder, void *element) = 0;
  virtual void LibgzInit() {}
  virtual void LibgzReset() {}
  std::string GetFilename() const { return this->filename; }
  std::string GetHandle() const { return this->handleName; }
  gazebo::PluginType GetType() const { return this->type; }

  gazebo::PluginType type = gazebo::WORLD_PLUGIN;
  std::string filename, handleName;
};

/* The console's words of LoadParam. */
void say_parameter(const std::string &plugin, const std::string &name, const std::string &value, bool found);
}  // namespace libgz

namespace gazebo {

template <class T>
class PluginT : public libgz::PluginRoot
{
 public:
  typedef boost::shared_ptr<T> TPtr;

 protected:
  template <typename V>
  void LoadParam(const sdf::ElementPtr &element, const std::string &name, V &value, V otherwise) const
  {
    const std::pair<V, bool> found = element->Get<V>(name, otherwise);
    value = found.first;
    std::ostringstream text;
    text << value;
    libgz::say_parameter(this->handleName, name, text.str(), found.second);
  }
  void LoadParam(
      sdf::ElementPtr &element, const std::string &name, std::string &value, const char *otherwise) const
  {
    this->LoadParam<std::string>(element, name, value, otherwise);
  }
};

class GAZEBO_VISIBLE WorldPlugin : public PluginT<WorldPlugin>
{
 public:
  WorldPlugin() { this->type = WORLD_PLUGIN; }
  virtual void Load(physics::WorldPtr world, sdf::ElementPtr sdf) = 0;
  virtual void Init() {}
  virtual void Reset() {}
  void LibgzLoad(void *holder, void *element) override;
  void LibgzInit() override { this->Init(); }
  void LibgzReset() override { this->Reset(); }
};

class GAZEBO_VISIBLE ModelPlugin : public PluginT<ModelPlugin>
{
 public:
  ModelPlugin() { this->type = MODEL_PLUGIN; }
  virtual void Load(physics::ModelPtr model, sdf::ElementPtr sdf) = 0;
  virtual void Init() {}
  virtual void Reset() {}
  void LibgzLoad(void *holder, void *element) override;
  void LibgzInit() override { this->Init(); }
  void LibgzReset() override { this->Reset(); }
};

class GAZEBO_VISIBLE SensorPlugin : public PluginT<SensorPlugin>
{
 public:
  SensorPlugin() { this->type = SENSOR_PLUGIN; }
  virtual void Load(sensors::SensorPtr sensor, sdf::ElementPtr sdf) = 0;
  virtual void Init() {}
  virtual void Reset() {}
  void LibgzLoad(void *holder, void *element) override;
  void LibgzInit() override { this->Init(); }
  void LibgzReset() override { this->Reset(); }
};

class GAZEBO_VISIBLE SystemPlugin : public PluginT<SystemPlugin>
{
 public:
  SystemPlugin() { this->type = SYSTEM_PLUGIN; }
  virtual void Load(int argc = 0, char **argv = nullptr) = 0;
  virtual void Init() {}
  virtual void Reset() {}
  void LibgzLoad(void *holder, void *element) override;
  void LibgzInit() override { this->Init(); }
  void LibgzReset() override { this->Reset(); }
};

class GAZEBO_VISIBLE VisualPlugin : public PluginT<VisualPlugin>
{
 public:
  VisualPlugin() { this->type = VISUAL_PLUGIN; }
  virtual void Load(rendering::VisualPtr visual, sdf::ElementPtr sdf) = 0;
  virtual void Init() {}
  virtual void Reset() {}
  void LibgzLoad(void *holder, void *element) override;
  void LibgzInit() override { this->Init(); }
  void LibgzReset() override { this->Reset(); }
};

typedef boost::shared_ptr<WorldPlugin> WorldPluginPtr;
typedef boost::shared_ptr<ModelPlugin> ModelPluginPtr;
typedef boost::shared_ptr<SensorPlugin> SensorPluginPtr;
typedef boost::shared_ptr<SystemPlugin> SystemPluginPtr;
typedef boost::shared_ptr<VisualPlugin> VisualPluginPtr;
class GUIPlugin;
typedef boost::shared_ptr<GUIPlugin> GUIPluginPtr;
}  // namespace gazebo

// The text is read before the file is loaded: its kind, the library that it needs, and where that is.
#define LIBGZ_REGISTER(Kind, classname) \
  extern "C" GAZEBO_VISIBLE gazebo::Kind##Plugin *RegisterPlugin(); \
  gazebo::Kind##Plugin *RegisterPlugin() \
  { \
    return new classname(); \
  } \
  extern "C" GAZEBO_VISIBLE const char *libgz_classic_plugin(); \
  const char *libgz_classic_plugin() \
  { \
    return "libgz classic plugin: " #Kind "; " LIBGZ_KEY "; " LIBGZ_FOLDER ";"; \
  } \
  extern "C" GAZEBO_VISIBLE libgz::PluginRoot *libgz_new_plugin(); \
  libgz::PluginRoot *libgz_new_plugin() \
  { \
    return RegisterPlugin(); \
  }
#define GZ_REGISTER_WORLD_PLUGIN(classname) LIBGZ_REGISTER(World, classname)
#define GZ_REGISTER_MODEL_PLUGIN(classname) LIBGZ_REGISTER(Model, classname)
#define GZ_REGISTER_SENSOR_PLUGIN(classname) LIBGZ_REGISTER(Sensor, classname)
#define GZ_REGISTER_SYSTEM_PLUGIN(classname) LIBGZ_REGISTER(System, classname)
#define GZ_REGISTER_VISUAL_PLUGIN(classname) LIBGZ_REGISTER(Visual, classname)
#endif
