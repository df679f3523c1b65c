/* Namespace gazebo::msgs: the functions beside the messages. License: Apache License 2.0. */
#ifndef LIBGZ_MSGS_HH
#define LIBGZ_MSGS_HH
#include "gazebo/libgz/common.hh"
#include "gazebo/libgz/messages.hh"

namespace gazebo {
namespace common {
class Image;
class SphericalCoordinates;
}  // namespace common
namespace msgs {

msgs::Request *CreateRequest(const std::string &request, const std::string &data = "");
void Init(google::protobuf::Message &message, const std::string &id = "");
void Stamp(msgs::Header *header);
void Stamp(msgs::Time *time);
std::string Package(const std::string &type, const google::protobuf::Message &message);
msgs::Header *GetHeader(google::protobuf::Message &message);
const google::protobuf::FieldDescriptor *GetFD(google::protobuf::Message &message, const std::string &name);

msgs::Any ConvertAny(const double value);
msgs::Any ConvertAny(const int value);
msgs::Any ConvertAny(const std::string &value);
msgs::Any ConvertAny(const char *value);
msgs::Any ConvertAny(const bool value);
msgs::Any ConvertAny(const ignition::math::Vector3d &value);
msgs::Any ConvertAny(const ignition::math::Color &value);
msgs::Any ConvertAny(const ignition::math::Pose3d &value);
msgs::Any ConvertAny(const ignition::math::Quaterniond &value);
msgs::Any ConvertAny(const common::Time &value);

msgs::Vector3d Convert(const ignition::math::Vector3d &value);
msgs::Vector2d Convert(const ignition::math::Vector2d &value);
msgs::Quaternion Convert(const ignition::math::Quaterniond &value);
msgs::Pose Convert(const ignition::math::Pose3d &value);
msgs::Color Convert(const ignition::math::Color &value);
msgs::Time Convert(const common::Time &value);
msgs::Inertial Convert(const ignition::math::Inertiald &value);
msgs::Inertial Convert(const ignition::math::MassMatrix3d &value);
msgs::PlaneGeom Convert(const ignition::math::Planed &value);
msgs::Joint::Type ConvertJointType(const std::string &name);
std::string ConvertJointType(const msgs::Joint::Type &type);
msgs::Geometry::Type ConvertGeometryType(const std::string &name);
std::string ConvertGeometryType(const msgs::Geometry::Type type);
msgs::Material::ShaderType ConvertShaderType(const std::string &name);
std::string ConvertShaderType(const msgs::Material::ShaderType &type);
ignition::math::Vector3d ConvertIgn(const msgs::Vector3d &value);
ignition::math::Vector2d ConvertIgn(const msgs::Vector2d &value);
ignition::math::Quaterniond ConvertIgn(const msgs::Quaternion &value);
ignition::math::Pose3d ConvertIgn(const msgs::Pose &value);
ignition::math::Planed ConvertIgn(const msgs::PlaneGeom &value);
ignition::math::Inertiald Convert(const msgs::Inertial &value);
ignition::math::Color Convert(const msgs::Color &value);
common::Time Convert(const msgs::Time &value);

void Set(common::Image &image, const msgs::Image &message);
void Set(msgs::Image *message, const common::Image &image);
void Set(msgs::Vector3d *message, const ignition::math::Vector3d &value);
void Set(msgs::Vector2d *message, const ignition::math::Vector2d &value);
void Set(msgs::Quaternion *message, const ignition::math::Quaterniond &value);
void Set(msgs::Pose *message, const ignition::math::Pose3d &value);
void Set(msgs::Color *message, const ignition::math::Color &value);
void Set(msgs::Time *message, const common::Time &value);
void Set(msgs::SphericalCoordinates *message, const common::SphericalCoordinates &value);
void Set(msgs::Inertial *message, const ignition::math::Inertiald &value);
void Set(msgs::Inertial *message, const ignition::math::MassMatrix3d &value);
void Set(msgs::PlaneGeom *message, const ignition::math::Planed &value);

/* What an element of SDF says, as a message, and back. */
#define LIBGZ_FROM_SDF(make) \
  make(TrackVisual, TrackVisual) make(GUI, GUI) make(Light, Light) make(Mesh, MeshGeom) make(Geometry, Geometry) \
  make(Visual, Visual) make(Collision, Collision) make(Surface, Surface) make(Friction, Friction) make(Axis, Axis) \
  make(Joint, Joint) make(Plugin, Plugin) make(Fog, Fog) make(Scene, Scene) make(Sensor, Sensor) \
  make(CameraSensor, CameraSensor) make(RaySensor, RaySensor) make(ContactSensor, ContactSensor) \
  make(GPSSensor, GPSSensor) make(SensorNoise, SensorNoise) make(IMUSensor, IMUSensor) \
  make(LogicalCameraSensor, LogicalCameraSensor)
#define LIBGZ_TO_SDF(make) \
  make(Visual, Visual) make(Material, Material) make(Light, Light) make(CameraSensor, CameraSensor) \
  make(Plugin, Plugin) make(Collision, Collision) make(Link, Link) make(Inertial, Inertial) make(Surface, Surface) \
  make(Geometry, Geometry) make(Mesh, MeshGeom) make(Model, Model) make(Joint, Joint) \
  make(LogicalCameraSensor, LogicalCameraSensor) make(IMUSensor, IMUSensor) make(SensorNoise, SensorNoise) \
  make(GPSSensor, GPSSensor)
#define LIBGZ_DECLARE(name, type) msgs::type name##FromSDF(const sdf::ElementPtr element);
LIBGZ_FROM_SDF(LIBGZ_DECLARE)
#undef LIBGZ_DECLARE
#define LIBGZ_DECLARE(name, type) \
  sdf::ElementPtr name##ToSDF(const msgs::type &message, sdf::ElementPtr element = sdf::ElementPtr());
LIBGZ_TO_SDF(LIBGZ_DECLARE)
#undef LIBGZ_DECLARE

void AddBoxLink(msgs::Model &model, const double mass, const ignition::math::Vector3d &size);
void AddCylinderLink(msgs::Model &model, const double mass, const double radius, const double length);
void AddSphereLink(msgs::Model &model, const double mass, const double radius);
void AddLinkGeom(msgs::Model &model, const msgs::Geometry &geometry);

typedef boost::shared_ptr<google::protobuf::Message> (*MsgFactoryFn)();
class GAZEBO_VISIBLE MsgFactory
{
 public:
  static void RegisterAll() {}
  static void RegisterMsg(const std::string &type, MsgFactoryFn make);
  static boost::shared_ptr<google::protobuf::Message> NewMsg(const std::string &type);
  static void GetMsgTypes(std::vector<std::string> &types);
};
#define GZ_REGISTER_STATIC_MSG(name, type)
}  // namespace msgs
}  // namespace gazebo

// Gazebo's messages as those of ignition with the same fields, and back, where ignition's are installed.
#if __has_include(<ignition/msgs/material.pb.h>)
#include <ignition/msgs/color.pb.h>
#include <ignition/msgs/material.pb.h>
namespace libgz {
template <class To, class From>
To same_color(const From &color)
{
  To made;
  made.set_r(color.r());
  made.set_g(color.g());
  made.set_b(color.b());
  made.set_a(color.a());
  return made;
}
template <class To, class From>
To same_script(const From &script)
{
  To made;
  made.set_name(script.name());
  for (const std::string &uri : script.uri())
    made.add_uri(uri);
  return made;
}
}  // namespace libgz
namespace gazebo {
namespace msgs {
inline ignition::msgs::Color ConvertIgnMsg(const Color &color)
{
  return libgz::same_color<ignition::msgs::Color>(color);
}
inline Color ConvertIgnMsg(const ignition::msgs::Color &color) { return libgz::same_color<Color>(color); }
inline ignition::msgs::Material::Script ConvertIgnMsg(const Material::Script &script)
{
  return libgz::same_script<ignition::msgs::Material::Script>(script);
}
inline Material::Script ConvertIgnMsg(const ignition::msgs::Material::Script &script)
{
  return libgz::same_script<Material::Script>(script);
}
inline ignition::msgs::Material::ShaderType ConvertIgnMsg(const Material::ShaderType &type)
{
  return static_cast<ignition::msgs::Material::ShaderType>(type - Material::VERTEX);
}
inline Material::ShaderType ConvertIgnMsg(const ignition::msgs::Material::ShaderType &type)
{
  return static_cast<Material::ShaderType>(type + Material::VERTEX);
}
}  // namespace msgs
}  // namespace gazebo
namespace libgz {
template <class To, class From>
To same_material(const From &material)
{
  using gazebo::msgs::ConvertIgnMsg;
  To made;
  made.set_shader_type(ConvertIgnMsg(material.shader_type()));
  made.set_lighting(material.lighting());
  if (!material.normal_map().empty())
    made.set_normal_map(material.normal_map());
  if (material.has_script())
    *made.mutable_script() = ConvertIgnMsg(material.script());
  if (material.has_ambient())
    *made.mutable_ambient() = ConvertIgnMsg(material.ambient());
  if (material.has_diffuse())
    *made.mutable_diffuse() = ConvertIgnMsg(material.diffuse());
  if (material.has_specular())
    *made.mutable_specular() = ConvertIgnMsg(material.specular());
  if (material.has_emissive())
    *made.mutable_emissive() = ConvertIgnMsg(material.emissive());
  return made;
}
}  // namespace libgz
namespace gazebo {
namespace msgs {
inline ignition::msgs::Material ConvertIgnMsg(const Material &material)
{
  return libgz::same_material<ignition::msgs::Material>(material);
}
inline Material ConvertIgnMsg(const ignition::msgs::Material &material)
{
  return libgz::same_material<Material>(material);
}
}  // namespace msgs
}  // namespace gazebo
#endif
#endif
