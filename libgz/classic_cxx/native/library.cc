// What the classes and functions that are declared by hand do. License: Apache License 2.0.
#include <time.h>

#include <boost/archive/iterators/base64_from_binary.hpp>
#include <boost/archive/iterators/binary_from_base64.hpp>
#include <boost/archive/iterators/transform_width.hpp>

#include "bridge.hh"
#include "gazebo/libgz/model_plugins.hh"

namespace libgz {
template <typename T>
Field<T>::operator T() const
{
  Gil gil;
  return From<T>::f(got(static_cast<PyObject *>(this->owner->view), this->name).get());
}
template <typename T>
Field<T> &Field<T>::operator=(const T &value)
{
  Gil gil;
  Ref made(to(value));
  if (PyObject_SetAttr(static_cast<PyObject *>(this->owner->view), interned(this->name), made.get()) != 0)
    raise_python();
  return *this;
}
template class Field<bool>;
template class Field<unsigned int>;
template class Field<double>;
}  // namespace libgz

namespace gazebo {
using libgz::call_function;
static const char *const HELP = "libgz.classic_cxx.values";  // Python's helpers

ReadyPlugin::ReadyPlugin(const char *module, const char *name)
    : ready(libgz::construct((std::string("plugins.") + module).c_str(), name))
{
}
void ReadyPlugin::Load(physics::ModelPtr model, sdf::ElementPtr sdf)
{
  libgz::Call call(&this->ready, "Load");
  (call << model << sdf).run();
}
void ReadyPlugin::Reset() { libgz::Call(&this->ready, "Reset").run(); }
void ElevatorPlugin::MoveToFloor(const int floor)
{
  libgz::Call call(&this->ready, "MoveToFloor");
  (call << floor).run();
}
void HarnessPlugin::SetWinchVelocity(const float velocity)
{
  libgz::Call call(&this->ready, "SetWinchVelocity");
  (call << velocity).run();
}
void HarnessPlugin::Detach() { libgz::Call(&this->ready, "Detach").run(); }
void LinearBatteryPlugin::Load(physics::ModelPtr model, sdf::ElementPtr sdf)
{
  ReadyPlugin::Load(model, sdf);
  this->sdf = sdf;
  this->model = model;
  this->world = model->GetWorld();
  this->physics = this->world->Physics();
  this->link = model->GetLink(sdf->Get<std::string>("link_name"));
  this->battery = this->link->Battery(sdf->Get<std::string>("battery_name"));
}
void WheelSlipPlugin::Load(physics::ModelPtr model, sdf::ElementPtr sdf)
{
  this->model = model;
  ReadyPlugin::Load(model, sdf);
}
void WheelSlipPlugin::GetSlips(std::map<std::string, ignition::math::Vector3d> &slips) const
{
  for (const auto &slip : libgz::Call(&this->ready, "GetSlips").result<std::map<std::string, ignition::math::Vector3d>>())
    slips[slip.first] = slip.second;
}
void WheelSlipPlugin::SetSlipComplianceLateral(std::string wheel, const double compliance)
{
  libgz::Call call(&this->ready, "SetSlipComplianceLateral");
  (call << wheel << compliance).run();
}
void WheelSlipPlugin::SetSlipComplianceLongitudinal(std::string wheel, const double compliance)
{
  libgz::Call call(&this->ready, "SetSlipComplianceLongitudinal");
  (call << wheel << compliance).run();
}

namespace common {

const Time Time::Zero = Time(0, 0), Time::Second = Time(1, 0), Time::Hour = Time(3600, 0);
const Time &Time::GetWallTime()
{
  static thread_local Time now;
  timespec t;
  clock_gettime(CLOCK_REALTIME, &t);
  return now = Time(t);
}
const std::string &Time::GetWallTimeAsISOString()
{
  static thread_local std::string text;
  timespec t;
  clock_gettime(CLOCK_REALTIME, &t);
  tm parts;
  localtime_r(&t.tv_sec, &parts);
  char buffer[64];
  const std::size_t end = strftime(buffer, sizeof buffer, "%Y-%m-%dT%H:%M:%S", &parts);
  snprintf(buffer + end, sizeof buffer - end, ".%09ld", static_cast<long>(t.tv_nsec));
  return text = buffer;
}
Time Time::Sleep(const Time &time)
{
  // C++ code runs without Python's lock.
  timespec wanted{time.sec, time.nsec}, left{0, 0};
  return nanosleep(&wanted, &left) == 0 ? Time() : Time(left);
}
std::string Time::FormattedString(FormatOption start, FormatOption end) const
{
  return call_function<std::string>(HELP, "formatted", *this, int(start), int(end));
}

void PID::Init(double p, double i, double d, double imax, double imin, double cmdMax, double cmdMin)
{
  this->p = p;
  this->i = i;
  this->d = d;
  this->imax = imax;
  this->imin = imin;
  this->most = cmdMax;
  this->least = cmdMin;
  this->Reset();
}
void PID::Reset() { this->pErrLast = this->pErr = this->iErr = this->dErr = this->cmd = 0.0; }
double PID::Update(double error, Time dt)
{
  // As libgz.classic.common.PID does it, in the same order.
  const double step = dt.Double();
  this->pErr = error;
  if (step == 0.0 || !std::isfinite(error))
    return 0.0;
  this->iErr += step * error;
  double iTerm = this->i * this->iErr;
  if (this->imax >= this->imin && !(this->imin <= iTerm && iTerm <= this->imax))
  {
    iTerm = std::clamp(iTerm, this->imin, this->imax);
    if (this->i != 0.0)
      this->iErr = iTerm / this->i;
  }
  this->dErr = (error - this->pErrLast) / step;
  this->pErrLast = error;
  double command = -this->p * error - iTerm - this->d * this->dErr;
  if (this->most >= this->least)
    command = std::clamp(command, this->least, this->most);
  return this->cmd = command;
}

Exception::Exception(const char *file, int line, std::string text) : file(file), text(text), line(line)
{
  this->Print();
}
void Exception::Print() const { Console::err(this->file, static_cast<int>(this->line)) << this->text << std::flush; }

// The console: each line becomes a record of Python's, which decides where it goes.
struct Logger::Lines : public std::streambuf
{
  explicit Lines(const std::string &name) : name(name) {}
  struct State
  {
    std::string text, file;
    int line = 0;
  };
  State &state()
  {
    static thread_local std::map<const Lines *, State> all;
    return all[this];
  }
  int_type overflow(int_type letter) override
  {
    if (letter != traits_type::eof())
      this->Add(static_cast<char>(letter));
    return letter;
  }
  std::streamsize xsputn(const char *text, std::streamsize count) override
  {
    for (std::streamsize i = 0; i < count; ++i)
      this->Add(text[i]);
    return count;
  }
  void Add(char letter)
  {
    if (letter == '\n')
      this->Emit();
    else
      this->state().text += letter;
  }
  void Begin(const std::string &file, int line)
  {
    if (!this->state().text.empty())
      this->Emit();
    this->state().file = file;
    this->state().line = line;
  }
  void Emit()
  {
    State &own = this->state();
    std::string text = std::move(own.text);
    own.text.clear();
    if (Py_IsInitialized())
      call_function<void>(HELP, "say", this->name, text, own.file, own.line);
  }
  std::string name;
};
Logger::Logger(const std::string &prefix, int, LogType) : std::ostream(nullptr), lines(new Lines(prefix))
{
  this->rdbuf(this->lines);
}
Logger::~Logger()
{
  this->rdbuf(nullptr);
  delete this->lines;
}
Logger &Logger::operator()()
{
  this->lines->Begin("", 0);
  return *this;
}
Logger &Logger::operator()(const std::string &file, int line)
{
  this->lines->Begin(file, line);
  return *this;
}
FileLogger::FileLogger(const std::string &) : std::ostream(nullptr), own("gzlog", 0, Logger::STDOUT)
{
  this->rdbuf(this->own.rdbuf());
}
FileLogger::~FileLogger() { this->rdbuf(nullptr); }
void FileLogger::Init(const std::string &, const std::string &) {}
FileLogger &FileLogger::operator()()
{
  this->own();
  return *this;
}
FileLogger &FileLogger::operator()(const std::string &file, int line)
{
  this->own(file, line);
  return *this;
}
std::string FileLogger::GetLogDirectory() const { return SystemPaths::Instance()->GetLogPath(); }
Logger Console::msg("gzmsg", 32, Logger::STDOUT), Console::err("gzerr", 31, Logger::STDERR),
    Console::dbg("gzdbg", 36, Logger::STDOUT), Console::warn("gzwarn", 33, Logger::STDERR);
FileLogger Console::log("gzlog");
void Console::SetQuiet(bool) {}
bool Console::GetQuiet() { return call_function<bool>(HELP, "quiet"); }

bool SemanticVersion::Parse(const std::string &text)
{
  std::string rest = text;
  const std::size_t plus = rest.find('+');
  std::string build = plus == std::string::npos ? "" : rest.substr(plus + 1);
  rest = rest.substr(0, plus);
  const std::size_t dash = rest.find('-');
  std::string prerelease = dash == std::string::npos ? "" : rest.substr(dash + 1);
  std::vector<std::string> parts;
  rest = rest.substr(0, dash);
  boost::split(parts, rest, boost::is_any_of("."));
  if (parts.size() > 3)
    return false;
  std::vector<unsigned int> found;
  for (const std::string &part : parts)
  {
    if (part.empty() || !boost::all(part, boost::is_digit()))
      return false;
    found.push_back(static_cast<unsigned int>(std::stoul(part)));
  }
  found.resize(3);
  this->numbers = found;
  this->pre = prerelease;
  this->meta = build;
  return true;
}
std::string SemanticVersion::Version() const
{
  std::ostringstream text;
  text << this->numbers[0] << "." << this->numbers[1] << "." << this->numbers[2];
  return text.str() + (this->pre.empty() ? "" : "-" + this->pre) + (this->meta.empty() ? "" : "+" + this->meta);
}
bool SemanticVersion::operator<(const SemanticVersion &o) const
{
  if (this->numbers != o.numbers)
    return this->numbers < o.numbers;
  return !this->pre.empty() && (o.pre.empty() || this->pre < o.pre);
}

/* Pixels in memory that the caller deletes. */
static void give_pixels(const Image *image, const char *helper, unsigned char **data, unsigned int &count)
{
  const std::string bytes = call_function<std::string>(HELP, helper, *image);
  count = static_cast<unsigned int>(bytes.size());
  *data = new unsigned char[count];
  std::copy(bytes.begin(), bytes.end(), *data);
}
void Image::GetData(unsigned char **data, unsigned int &count) const { give_pixels(this, "image_bytes", data, count); }
void Image::GetRGBData(unsigned char **data, unsigned int &count) const
{
  give_pixels(this, "image_colors", data, count);
}

/* An array that the caller deletes. As in Gazebo, the one that was there before is deleted here. */
template <class T>
static void give_array(const std::vector<T> &from, T **array)
{
  delete[] *array;
  *array = new T[from.size()];
  std::copy(from.begin(), from.end(), *array);
}
static void give_arrays(const libgz::Object *mesh, float **vertices, int **indices)
{
  auto found = libgz::Call(mesh, "FillArrays").result<std::tuple<std::vector<float>, std::vector<int>>>();
  give_array(std::get<0>(found), vertices);
  give_array(std::get<1>(found), indices);
}
void Mesh::FillArrays(float **vertices, int **indices) const { give_arrays(this, vertices, indices); }
void SubMesh::FillArrays(float **vertices, int **indices) const { give_arrays(this, vertices, indices); }

void load() {}
void add_search_path_suffix(const std::string &suffix) { SystemPaths::Instance()->AddSearchPathSuffix(suffix); }
std::string find_file(const std::string &file) { return find_file(file, true); }
std::string find_file(const std::string &file, bool here) { return SystemPaths::Instance()->FindFile(file, here); }
std::string find_file_path(const std::string &file)
{
  return boost::filesystem::path(find_file(file)).parent_path().string();
}
const char *getEnv(const char *name) { return std::getenv(name); }
std::string cwd() { return boost::filesystem::current_path().string(); }
bool exists(const std::string &path)
{
  boost::system::error_code error;
  return boost::filesystem::exists(path, error);
}
bool isDirectory(const std::string &path)
{
  boost::system::error_code error;
  return boost::filesystem::is_directory(path, error);
}
bool isFile(const std::string &path)
{
  boost::system::error_code error;
  return boost::filesystem::is_regular_file(path, error);
}
std::string absPath(const std::string &path) { return boost::filesystem::absolute(path).string(); }
bool copyFile(const std::string &from, const std::string &to)
{
  std::ifstream in(from, std::ios::binary);
  std::ofstream out(to, std::ios::binary);
  return in && out && (out << in.rdbuf());
}
bool copyDir(const boost::filesystem::path &from, const boost::filesystem::path &to)
{
  boost::system::error_code error;
  boost::filesystem::create_directories(to, error);
  for (boost::filesystem::directory_iterator one(from, error), end; !error && one != end; one.increment(error))
  {
    const boost::filesystem::path target = to / one->path().filename();
    if (isDirectory(one->path().string()) ? !copyDir(one->path(), target)
                                          : !copyFile(one->path().string(), target.string()))
      return false;
  }
  return !error;
}
bool moveFile(const std::string &from, const std::string &to)
{
  return std::rename(from.c_str(), to.c_str()) == 0 || (copyFile(from, to) && std::remove(from.c_str()) == 0);
}
void replaceAll(std::string &result, const std::string &text, const std::string &from, const std::string &to)
{
  result = boost::replace_all_copy(text, from, to);
}
std::string replaceAll(const std::string &text, const std::string &from, const std::string &to)
{
  return boost::replace_all_copy(text, from, to);
}
std::vector<std::string> split(const std::string &text, const std::string &delimiter)
{
  std::vector<std::string> parts;
  std::size_t start = 0, end;
  while ((end = text.find(delimiter, start)) != std::string::npos)
  {
    if (end > start)
      parts.push_back(text.substr(start, end - start));
    start = end + delimiter.size();
  }
  if (start < text.size())
    parts.push_back(text.substr(start));
  return parts;
}
std::string unique_file_path(const std::string &base, const std::string &extension)
{
  std::string found = base + "." + extension;
  for (int i = 1; exists(found); ++i)
    found = base + "(" + std::to_string(i) + ")." + extension;
  return found;
}
std::string asFullPath(const std::string &uri, const std::string &file)
{
  return uri.empty() || uri[0] == '/' || uri.find("://") != std::string::npos
             ? uri
             : (boost::filesystem::path(file).parent_path() / uri).string();
}
void convertPosesToSdf16(const sdf::ElementPtr &) {}
}  // namespace common

namespace msgs {
namespace math = ignition::math;

msgs::Request *CreateRequest(const std::string &request, const std::string &data)
{
  static std::atomic<int> number{1};
  auto *message = new msgs::Request;
  message->set_id(number++);
  message->set_request(request);
  message->set_data(data);
  return message;
}
const google::protobuf::FieldDescriptor *GetFD(google::protobuf::Message &message, const std::string &name)
{
  return message.GetDescriptor()->FindFieldByName(name);
}
msgs::Header *GetHeader(google::protobuf::Message &message)
{
  const auto *field = GetFD(message, "header");
  if (field == nullptr)
    return dynamic_cast<msgs::Header *>(&message);
  return dynamic_cast<msgs::Header *>(message.GetReflection()->MutableMessage(&message, field));
}
void Init(google::protobuf::Message &message, const std::string &id)
{
  if (msgs::Header *header = GetHeader(message))
  {
    if (!id.empty())
      header->set_str_id(id);
    Stamp(header);
  }
}
void Stamp(msgs::Header *header) { Stamp(header->mutable_stamp()); }
void Stamp(msgs::Time *time) { Set(time, common::Time::GetWallTime()); }
std::string Package(const std::string &type, const google::protobuf::Message &message)
{
  msgs::Packet packet;
  Set(packet.mutable_stamp(), common::Time::GetWallTime());
  packet.set_type(type);
  packet.set_serialized_data(message.SerializePartialAsString());
  return packet.SerializePartialAsString();
}

#define LIBGZ_ANY(type, KIND, set) \
  msgs::Any ConvertAny(type value) \
  { \
    msgs::Any any; \
    any.set_type(msgs::Any::KIND); \
    set; \
    return any; \
  }
LIBGZ_ANY(const double, DOUBLE, any.set_double_value(value))
LIBGZ_ANY(const int, INT32, any.set_int_value(value))
LIBGZ_ANY(const std::string &, STRING, any.set_string_value(value))
LIBGZ_ANY(const char *, STRING, any.set_string_value(value))
LIBGZ_ANY(const bool, BOOLEAN, any.set_bool_value(value))
LIBGZ_ANY(const math::Vector3d &, VECTOR3D, Set(any.mutable_vector3d_value(), value))
LIBGZ_ANY(const math::Color &, COLOR, Set(any.mutable_color_value(), value))
LIBGZ_ANY(const math::Pose3d &, POSE3D, Set(any.mutable_pose3d_value(), value))
LIBGZ_ANY(const math::Quaterniond &, QUATERNIOND, Set(any.mutable_quaternion_value(), value))
LIBGZ_ANY(const common::Time &, TIME, Set(any.mutable_time_value(), value))

void Set(msgs::Vector3d *m, const math::Vector3d &v)
{
  m->set_x(v.X());
  m->set_y(v.Y());
  m->set_z(v.Z());
}
void Set(msgs::Vector2d *m, const math::Vector2d &v)
{
  m->set_x(v.X());
  m->set_y(v.Y());
}
void Set(msgs::Quaternion *m, const math::Quaterniond &v)
{
  m->set_w(v.W());
  m->set_x(v.X());
  m->set_y(v.Y());
  m->set_z(v.Z());
}
void Set(msgs::Pose *m, const math::Pose3d &v)
{
  Set(m->mutable_position(), v.Pos());
  Set(m->mutable_orientation(), v.Rot());
}
void Set(msgs::Color *m, const math::Color &v)
{
  m->set_r(v.R());
  m->set_g(v.G());
  m->set_b(v.B());
  m->set_a(v.A());
}
void Set(msgs::Time *m, const common::Time &v)
{
  m->set_sec(v.sec);
  m->set_nsec(v.nsec);
}
void Set(msgs::SphericalCoordinates *m, const common::SphericalCoordinates &v)
{
  m->set_surface_model(msgs::SphericalCoordinates::EARTH_WGS84);
  m->set_latitude_deg(v.LatitudeReference().Degree());
  m->set_longitude_deg(v.LongitudeReference().Degree());
  m->set_elevation(v.GetElevationReference());
  m->set_heading_deg(v.HeadingOffset().Degree());
}
void Set(msgs::Inertial *m, const math::MassMatrix3d &v)
{
  m->set_mass(v.Mass());
  m->set_ixx(v.Ixx());
  m->set_iyy(v.Iyy());
  m->set_izz(v.Izz());
  m->set_ixy(v.Ixy());
  m->set_ixz(v.Ixz());
  m->set_iyz(v.Iyz());
  Set(m->mutable_pose(), math::Pose3d::Zero);
}
void Set(msgs::Inertial *m, const math::Inertiald &v)
{
  Set(m, v.MassMatrix());
  Set(m->mutable_pose(), v.Pose());
}
void Set(msgs::PlaneGeom *m, const math::Planed &v)
{
  Set(m->mutable_normal(), v.Normal());
  Set(m->mutable_size(), v.Size());
  m->set_d(v.Offset());
}
void Set(msgs::Image *message, const common::Image &image)
{
  message->set_width(image.GetWidth());
  message->set_height(image.GetHeight());
  message->set_pixel_format(image.GetPixelFormat());
  message->set_step(image.GetPitch());
  message->set_data(call_function<std::string>(HELP, "image_bytes", image));
}
void Set(common::Image &image, const msgs::Image &message)
{
  image.SetFromData(reinterpret_cast<const unsigned char *>(message.data().data()), message.width(),
      message.height(), common::Image::PixelFormat(message.pixel_format()));
}

#define LIBGZ_CONVERT(Message, type) \
  msgs::Message Convert(const type &value) \
  { \
    msgs::Message message; \
    Set(&message, value); \
    return message; \
  }
LIBGZ_CONVERT(Vector3d, math::Vector3d)
LIBGZ_CONVERT(Vector2d, math::Vector2d)
LIBGZ_CONVERT(Quaternion, math::Quaterniond)
LIBGZ_CONVERT(Pose, math::Pose3d)
LIBGZ_CONVERT(Color, math::Color)
LIBGZ_CONVERT(Time, common::Time)
LIBGZ_CONVERT(Inertial, math::Inertiald)
LIBGZ_CONVERT(Inertial, math::MassMatrix3d)
LIBGZ_CONVERT(PlaneGeom, math::Planed)

math::Vector3d ConvertIgn(const msgs::Vector3d &v) { return {v.x(), v.y(), v.z()}; }
math::Vector2d ConvertIgn(const msgs::Vector2d &v) { return {v.x(), v.y()}; }
math::Quaterniond ConvertIgn(const msgs::Quaternion &v) { return {v.w(), v.x(), v.y(), v.z()}; }
math::Pose3d ConvertIgn(const msgs::Pose &v) { return {ConvertIgn(v.position()), ConvertIgn(v.orientation())}; }
math::Planed ConvertIgn(const msgs::PlaneGeom &v) { return {ConvertIgn(v.normal()), ConvertIgn(v.size()), v.d()}; }
math::Inertiald Convert(const msgs::Inertial &v)
{
  return {math::MassMatrix3d(v.mass(), {v.ixx(), v.iyy(), v.izz()}, {v.ixy(), v.ixz(), v.iyz()}),
      ConvertIgn(v.pose())};
}
math::Color Convert(const msgs::Color &v) { return math::Color(v.r(), v.g(), v.b(), v.a()); }
common::Time Convert(const msgs::Time &v) { return common::Time(v.sec(), v.nsec()); }

/* A word of SDF and a value of an enumeration: their names agree but for capitals. */
static std::string capitals(const std::string &word) { return boost::to_upper_copy(word); }
msgs::Joint::Type ConvertJointType(const std::string &name)
{
  msgs::Joint::Type type = msgs::Joint::REVOLUTE;
  msgs::Joint::Type_Parse(capitals(name), &type);
  return type;
}
std::string ConvertJointType(const msgs::Joint::Type &type)
{
  return boost::to_lower_copy(msgs::Joint::Type_Name(type));
}
msgs::Geometry::Type ConvertGeometryType(const std::string &name)
{
  msgs::Geometry::Type type = msgs::Geometry::BOX;
  msgs::Geometry::Type_Parse(capitals(name), &type);
  return type;
}
std::string ConvertGeometryType(const msgs::Geometry::Type type)
{
  return boost::to_lower_copy(msgs::Geometry::Type_Name(type));
}
msgs::Material::ShaderType ConvertShaderType(const std::string &name)
{
  msgs::Material::ShaderType type = msgs::Material::VERTEX;
  msgs::Material::ShaderType_Parse(
      name == "normal_map_tangent_space" ? "NORMAL_MAP_TANGENT_SPACE" : capitals(name), &type);
  return type;
}
std::string ConvertShaderType(const msgs::Material::ShaderType &type)
{
  return boost::to_lower_copy(msgs::Material::ShaderType_Name(type));
}

#define LIBGZ_DEFINE(name, type) \
  msgs::type name##FromSDF(const sdf::ElementPtr element) \
  { \
    return call_function<msgs::type>("libgz.classic.msgs", #name "FromSDF", element); \
  }
LIBGZ_FROM_SDF(LIBGZ_DEFINE)
#undef LIBGZ_DEFINE
#define LIBGZ_DEFINE(name, type) \
  sdf::ElementPtr name##ToSDF(const msgs::type &message, sdf::ElementPtr) \
  { \
    return call_function<sdf::ElementPtr>("libgz.classic.msgs", #name "ToSDF", message); \
  }
LIBGZ_TO_SDF(LIBGZ_DEFINE)
#undef LIBGZ_DEFINE

static msgs::Link *add_link(msgs::Model &model, const math::MassMatrix3d &mass, const msgs::Geometry &geometry)
{
  AddLinkGeom(model, geometry);
  msgs::Link *link = model.mutable_link(model.link_size() - 1);
  *link->mutable_inertial() = Convert(mass);
  return link;
}
void AddBoxLink(msgs::Model &model, const double mass, const math::Vector3d &size)
{
  math::MassMatrix3d matrix;
  matrix.SetFromBox(mass, size);
  msgs::Geometry geometry;
  geometry.set_type(msgs::Geometry::BOX);
  Set(geometry.mutable_box()->mutable_size(), size);
  add_link(model, matrix, geometry);
}
void AddCylinderLink(msgs::Model &model, const double mass, const double radius, const double length)
{
  math::MassMatrix3d matrix;
  matrix.SetFromCylinderZ(mass, length, radius);
  msgs::Geometry geometry;
  geometry.set_type(msgs::Geometry::CYLINDER);
  geometry.mutable_cylinder()->set_radius(radius);
  geometry.mutable_cylinder()->set_length(length);
  add_link(model, matrix, geometry);
}
void AddSphereLink(msgs::Model &model, const double mass, const double radius)
{
  math::MassMatrix3d matrix;
  matrix.SetFromSphere(mass, radius);
  msgs::Geometry geometry;
  geometry.set_type(msgs::Geometry::SPHERE);
  geometry.mutable_sphere()->set_radius(radius);
  add_link(model, matrix, geometry);
}
void AddLinkGeom(msgs::Model &model, const msgs::Geometry &geometry)
{
  msgs::Link *link = model.add_link();
  const std::string number = std::to_string(model.link_size());
  link->set_name("link_" + number);
  msgs::Collision *collision = link->add_collision();
  collision->set_name("collision_" + number);
  *collision->mutable_geometry() = geometry;
  msgs::Visual *visual = link->add_visual();
  visual->set_name("visual_" + number);
  *visual->mutable_geometry() = geometry;
  visual->mutable_material()->mutable_script()->add_uri("file://media/materials/scripts/gazebo.material");
  visual->mutable_material()->mutable_script()->set_name("Gazebo/Grey");
}

static std::map<std::string, MsgFactoryFn> &factories()
{
  static std::map<std::string, MsgFactoryFn> all;
  return all;
}
void MsgFactory::RegisterMsg(const std::string &type, MsgFactoryFn make) { factories()[type] = make; }
boost::shared_ptr<google::protobuf::Message> MsgFactory::NewMsg(const std::string &type)
{
  using namespace google::protobuf;
  auto known = factories().find(type);
  if (known != factories().end())
    return known->second();
  const std::string full = type.find('.') == std::string::npos ? "gazebo.msgs." + type : type;
  const Descriptor *kind = DescriptorPool::generated_pool()->FindMessageTypeByName(full);
  return boost::shared_ptr<Message>(
      kind ? MessageFactory::generated_factory()->GetPrototype(kind)->New() : nullptr);
}
void MsgFactory::GetMsgTypes(std::vector<std::string> &types)
{
  types = call_function<std::vector<std::string>>("libgz.classic.msgs.declare", "known_types");
}
}  // namespace msgs

namespace transport {
using libgz::Call;

Node::Node() : Object(libgz::construct("transport", "Node")) {}
void Node::Init(const std::string &space)
{
  Call call(this, "Init");
  call << space;
  call.run();
}
bool Node::TryInit(const common::Time &most)
{
  Call call(this, "TryInit");
  call << most;
  return call.result<bool>();
}
bool Node::IsInitialized() const { return Call(this, "IsInitialized").result<bool>(); }
void Node::Fini() { Call(this, "Fini").run(); }
std::string Node::GetTopicNamespace() const { return Call(this, "GetTopicNamespace").result<std::string>(); }
std::string Node::DecodeTopicName(const std::string &topic)
{
  Call call(this, "DecodeTopicName");
  return (call << topic).result<std::string>();
}
std::string Node::EncodeTopicName(const std::string &topic)
{
  Call call(this, "EncodeTopicName");
  return (call << topic).result<std::string>();
}
unsigned int Node::GetId() const { return Call(this, "GetId").result<unsigned int>(); }
std::string Node::GetMsgType(const std::string &topic) const { return getTopicMsgType(topic); }
void Node::Publish(const std::string &topic, const google::protobuf::Message &message)
{
  Call call(this, "Publish");
  call << topic << message;
  call.run();
}
PublisherPtr Node::Advertise(
    const std::string &topic, const std::string &type, unsigned int queueLimit, double hzRate)
{
  Call call(this, "Advertise");
  call << type << topic << queueLimit << hzRate;
  return PublisherPtr(new Publisher(call.result<Publisher>()));
}
PublisherPtr Node::AdvertiseAs(
    const google::protobuf::Message &type, const std::string &topic, unsigned int queueLimit, double hzRate)
{
  libgz::Gil gil;
  libgz::message_type(type);  // Python knows it from now on
  return this->Advertise(topic, type.GetTypeName(), queueLimit, hzRate);
}
SubscriberPtr Node::SubscribeRaw(const std::string &topic, const google::protobuf::Message *type,
    std::function<void(const std::string &)> callback, bool latching)
{
  libgz::Gil gil;
  libgz::Ref kind = type != nullptr ? libgz::Ref(PyUnicode_FromString(type->GetTypeName().c_str())) : libgz::Ref();
  if (type != nullptr)
    libgz::message_type(*type);  // Python knows it from now on
  libgz::Ref function(libgz::callable(
      [callback](PyObject *const *args) -> PyObject * {
        libgz::Ref bytes(PyObject_CallMethodNoArgs(args[0], libgz::interned("SerializePartialToString")));
        if (!bytes)
          libgz::raise_python();
        const std::string data = libgz::text_of(bytes.get());
        {
          libgz::Unlocked unlocked;
          callback(data);
        }
        Py_RETURN_NONE;
      },
      1));
  libgz::Ref made(PyObject_CallMethod(static_cast<PyObject *>(this->view), "Subscribe", "sOOO", topic.c_str(),
      function.get(), latching ? Py_True : Py_False, kind ? kind.get() : Py_None));
  if (!made)
    libgz::raise_python();
  return SubscriberPtr(new Subscriber(libgz::Adopt{made.release()}));
}
bool Publisher::HasConnections() const { return Call(this, "HasConnections").result<bool>(); }
void Publisher::WaitForConnection() const { Call(this, "WaitForConnection").run(); }
bool Publisher::WaitForConnection(const common::Time &timeout) const
{
  Call call(this, "WaitForConnection");
  return (call << timeout).result<bool>();
}
void Publisher::Publish(const google::protobuf::Message &message, bool block)
{
  Call call(this, "Publish");
  call << message << block;
  call.run();
}
unsigned int Publisher::GetOutgoingCount() const { return Call(this, "GetOutgoingCount").result<unsigned int>(); }
std::string Publisher::GetTopic() const { return Call(this, "GetTopic").result<std::string>(); }
std::string Publisher::GetMsgType() const { return Call(this, "GetMsgType").result<std::string>(); }
void Publisher::SendMessage() { Call(this, "SendMessage").run(); }
void Publisher::Fini() { Call(this, "Fini").run(); }
std::string Subscriber::GetTopic() const { return Call(this, "GetTopic").result<std::string>(); }
void Subscriber::Unsubscribe() const { Call(this, "Unsubscribe").run(); }

static const char *const TRANSPORT = "libgz.classic.transport";
void TopicManager::GetTopicNamespaces(std::list<std::string> &names) { get_topic_namespaces(names); }
std::vector<std::string> TopicManager::GetAdvertisedTopics(const std::string &type) const
{
  return call_function<std::vector<std::string>>(HELP, "topics", type);
}
bool init(const std::string &, unsigned int, uint32_t) { return true; }
void run() {}
void stop() {}
void fini() {}
bool is_stopped() { return false; }
void clear_buffers() {}
void pause_incoming(bool) {}
bool get_master_uri(std::string &host, unsigned int &port)
{
  const auto found = call_function<std::vector<std::string>>(HELP, "master");
  host = found.at(0);
  port = static_cast<unsigned int>(std::stoul(found.at(1)));
  return true;
}
void get_topic_namespaces(std::list<std::string> &names)
{
  names = call_function<std::list<std::string>>(HELP, "namespaces");
}
bool waitForNamespaces(const gazebo::common::Time &)
{
  return !call_function<std::list<std::string>>(HELP, "namespaces").empty();
}
boost::shared_ptr<msgs::Response> request(
    const std::string &world, const std::string &request, const std::string &data, const common::Time &timeout)
{
  return boost::shared_ptr<msgs::Response>(
      new msgs::Response(call_function<msgs::Response>(TRANSPORT, "request", world, request, data, timeout.Double())));
}
void requestNoReply(const std::string &world, const std::string &request, const std::string &data)
{
  NodePtr node(new Node);
  node->Init(world);
  requestNoReply(node, request, data);
}
void requestNoReply(NodePtr node, const std::string &request, const std::string &data)
{
  std::unique_ptr<msgs::Request> message(msgs::CreateRequest(request, data));
  node->Advertise<msgs::Request>("~/request")->Publish(*message);
}
std::map<std::string, std::list<std::string>> getAdvertisedTopics()
{
  return call_function<std::map<std::string, std::list<std::string>>>(HELP, "topics_by_type");
}
std::list<std::string> getAdvertisedTopics(const std::string &type)
{
  return call_function<std::list<std::string>>(HELP, "topics", type);
}
std::string getTopicMsgType(const std::string &topic) { return call_function<std::string>(HELP, "type_of", topic); }
static std::atomic<bool> minimal{false};
void setMinimalComms(bool enabled) { minimal = enabled; }
bool getMinimalComms() { return minimal; }
}  // namespace transport

[[noreturn]] static void only_in_programs(const char *what)
{
  throw std::runtime_error(std::string(what) + " is for programs that run a server; this plugin runs in one");
}
void printVersion() { gzmsg << GAZEBO_VERSION_HEADER << std::flush; }
void addPlugin(const std::string &) { only_in_programs("gazebo::addPlugin"); }
bool setupServer(int, char **) { only_in_programs("gazebo::setupServer"); }
bool setupServer(const std::vector<std::string> &) { only_in_programs("gazebo::setupServer"); }
physics::WorldPtr loadWorld(const std::string &) { only_in_programs("gazebo::loadWorld"); }
void runWorld(physics::WorldPtr, unsigned int) { only_in_programs("gazebo::runWorld"); }
bool shutdown()
{
  call_function<void>(HELP, "stop_server");
  return true;
}

namespace physics {
static const char *const PHYSICS = "libgz.classic.physics";
bool load() { return true; }
bool fini() { return true; }
WorldPtr create_world(const std::string &) { only_in_programs("physics::create_world"); }
WorldPtr get_world(const std::string &name) { return call_function<WorldPtr>(PHYSICS, "get_world", name); }
bool has_world(const std::string &name) { return call_function<bool>(PHYSICS, "has_world", name); }
void run_world(WorldPtr, unsigned int) { only_in_programs("physics::run_world"); }
void stop_world(WorldPtr world) { world->Stop(); }
void pause_world(WorldPtr world, bool pause) { world->SetPaused(pause); }
void pause_worlds(bool pause) { call_function<void>(PHYSICS, "pause_worlds", pause); }
void stop_worlds() { shutdown(); }
void run_worlds(unsigned int) { only_in_programs("physics::run_worlds"); }
bool worlds_running() { return true; }
uint32_t getUniqueId() { return call_function<uint32_t>(PHYSICS, "getUniqueId"); }

event::ConnectionPtr libgz_connect(const libgz::Object *object, const char *method, std::function<void()> callback)
{
  libgz::Call call(object, method);
  return (call << callback).result<event::ConnectionPtr>();
}
std::map<std::string, common::SkeletonAnimation *> Actor::SkeletonAnimations() const
{
  return libgz::Call(this, "SkeletonAnimations").result<std::map<std::string, common::SkeletonAnimation *>>();
}
FrictionPyramidPtr SurfaceParams::FrictionPyramid() const
{
  return libgz::Call(this, "FrictionPyramid").result<FrictionPyramidPtr>();
}
// Fields of a surface by their names in messages: those of all surfaces, and of ODE's, as far as libgz has them.
#define LIBGZ_SURFACE(field) \
  field(collide_without_contact, collideWithoutContact) \
  field(collide_without_contact_bitmask, collideWithoutContactBitmask) field(collide_bitmask, collideBitmask)
#define LIBGZ_ODE_SURFACE(field) \
  field(restitution_coefficient, bounce) field(bounce_threshold, bounceThreshold) field(kp, kp) field(kd, kd) \
  field(max_vel, maxVel) field(min_depth, minDepth)
#define LIBGZ_FILL(name, member) message.set_##name(this->member);
#define LIBGZ_PROCESS(name, member) \
  if (message.has_##name()) \
    this->member = message.name();
void SurfaceParams::FillMsg(msgs::Surface &message) { LIBGZ_SURFACE(LIBGZ_FILL) }
void SurfaceParams::ProcessMsg(const msgs::Surface &message) { LIBGZ_SURFACE(LIBGZ_PROCESS) }
void ODESurfaceParams::FillMsg(msgs::Surface &message)
{
  SurfaceParams::FillMsg(message);
  LIBGZ_ODE_SURFACE(LIBGZ_FILL)
  const FrictionPyramidPtr pyramid = this->FrictionPyramid();
  msgs::Friction *friction = message.mutable_friction();
  friction->set_mu(pyramid->MuPrimary());
  friction->set_mu2(pyramid->MuSecondary());
  friction->set_slip1(this->slip1);
  friction->set_slip2(this->slip2);
}
void ODESurfaceParams::ProcessMsg(const msgs::Surface &message)
{
  SurfaceParams::ProcessMsg(message);
  LIBGZ_ODE_SURFACE(LIBGZ_PROCESS)
  const msgs::Friction &friction = message.friction();
  if (friction.has_mu())
    this->FrictionPyramid()->SetMuPrimary(friction.mu());
  if (friction.has_mu2())
    this->FrictionPyramid()->SetMuSecondary(friction.mu2());
  if (friction.has_slip1())
    this->slip1 = friction.slip1();
  if (friction.has_slip2())
    this->slip2 = friction.slip2();
}
#undef LIBGZ_PROCESS
#undef LIBGZ_FILL
#undef LIBGZ_ODE_SURFACE
#undef LIBGZ_SURFACE
/* An inertial is a value: what is made of it changes no link. */
Inertial::Inertial(const Inertial &other) : libgz::Object(libgz::construct("physics", "Inertial", other)) {}
Inertial &Inertial::operator=(const Inertial &other)
{
  if (this->view != other.view)
    (libgz::Call(this, "copy_from") << other).run();
  return *this;
}
Inertial &Inertial::operator=(const ignition::math::Inertiald &other)
{
  (libgz::Call(this, "copy_from") << other).run();
  return *this;
}
const Inertial &Inertial::operator+=(const Inertial &other) { return *this = *this + other; }

template <class M>
static M matching(const M &states, const boost::regex &name)
{
  M found;
  std::copy_if(states.begin(), states.end(), std::inserter(found, found.end()),
      [&name](const auto &state) { return boost::regex_match(state.first, name); });
  return found;
}
LinkState_M ModelState::GetLinkStates(const boost::regex &name) const { return matching(this->GetLinkStates(), name); }
JointState_M ModelState::GetJointStates(const boost::regex &name) const
{
  return matching(this->GetJointStates(), name);
}
ModelState_M WorldState::GetModelStates(const boost::regex &name) const
{
  return matching(this->GetModelStates(), name);
}
/* Contacts as classic has them: numbers that stay until they are asked for again. */
struct Contacts
{
  Contacts() = default;
  Contacts(const Contacts &) = delete;
  ~Contacts() { this->Clear(); }
  void Add(const Contact &contact)
  {
    this->owned.push_back(std::make_unique<Contact>(contact));
    this->all.push_back(this->owned.back().get());
    libgz::count_all(contact.world, 1);
  }
  void Clear()
  {
    for (const Contact *contact : this->all)
      libgz::count_all(contact->world, -1);
    this->all.clear();
    this->owned.clear();
  }
  std::vector<std::unique_ptr<Contact>> owned;
  std::vector<Contact *> all;
};
const std::vector<Contact *> &ContactManager::GetContacts() const
{
  libgz::Call call(this, "GetContacts");
  call.run();
  Contacts &found = call.slot<Contacts>();
  found.Clear();
  for (const Contact &one : call.taken<std::vector<Contact>>())
    found.Add(one);
  return found.all;
}
Contact *ContactManager::GetContact(unsigned int index) const
{
  const std::vector<Contact *> &all = this->GetContacts();
  return index < all.size() ? all[index] : nullptr;
}
boost::recursive_mutex *PhysicsEngine::GetPhysicsUpdateMutex() const
{
  static boost::recursive_mutex mutex;  // plugins do not run beside a step
  return &mutex;
}
void World::InsertModelSDF(const sdf::SDF &text) { this->InsertModelString(text.ToString()); }
Contact &Contact::operator=(const msgs::Contact &message)
{
  this->count = std::min(message.position_size(), MAX_CONTACT_JOINTS);
  for (int i = 0; i < this->count; ++i)
  {
    this->positions[i] = msgs::ConvertIgn(message.position(i));
    this->normals[i] = msgs::ConvertIgn(message.normal(i));
    this->depths[i] = message.depth(i);
  }
  this->time = msgs::Convert(message.time());
  return *this;
}
void Contact::FillMsg(msgs::Contact &message) const
{
  message.set_world(this->world ? this->world->Name() : "");
  message.set_collision1(this->collision1 ? this->collision1->GetScopedName() : "");
  message.set_collision2(this->collision2 ? this->collision2->GetScopedName() : "");
  msgs::Set(message.mutable_time(), this->time);
  for (int i = 0; i < this->count; ++i)
  {
    msgs::Set(message.add_position(), this->positions[i]);
    msgs::Set(message.add_normal(), this->normals[i]);
    message.add_depth(this->depths[i]);
    msgs::JointWrench *wrench = message.add_wrench();
    wrench->set_body_1_name(message.collision1());
    wrench->set_body_2_name(message.collision2());
    msgs::Set(wrench->mutable_body_1_wrench()->mutable_force(), this->wrench[i].body1Force);
    msgs::Set(wrench->mutable_body_1_wrench()->mutable_torque(), this->wrench[i].body1Torque);
    msgs::Set(wrench->mutable_body_2_wrench()->mutable_force(), this->wrench[i].body2Force);
    msgs::Set(wrench->mutable_body_2_wrench()->mutable_torque(), this->wrench[i].body2Torque);
  }
}
std::string Contact::DebugString() const
{
  msgs::Contact message;
  this->FillMsg(message);
  return message.DebugString();
}
}  // namespace physics

namespace sensors {
// A sensor is one of libgz, which Python has, or of a plugin's class: then its numbers and their rules, which are
// Gazebo's, are here, and Python's OwnSensor asks for them.
struct Sensor::Own
{
  SensorCategory category;
  common::Time delay;                 // by which its last update came late
  common::Time again;                 // when it is asked again after a call of UpdateImpl that measured nothing
  event::ConnectionPtr notification;  // of Python
};
#define LIBGZ_ASKED(Result, name) \
  if (!this->own) \
  { \
    libgz::Call call(this, #name); \
    return call.result<Result>(); \
  }
#define LIBGZ_GIVEN(name, values) \
  if (!this->own) \
  { \
    libgz::Call call(this, #name); \
    call values; \
    return call.run(); \
  }
Sensor::Sensor(SensorCategory category)
    : libgz::Object(libgz::construct("sensors.own", "being_made")), sdf(new sdf::Element), node(new transport::Node)
{
  sdf::initFile("sensor.sdf", this->sdf);
  this->own.reset(new Own{category, {}, {}});
  this->own->notification = this->updated.Connect([this] {
    libgz::Call call(this, "updated");
    call.run();
  });
}
void Sensor::Load(const std::string &worldName, sdf::ElementPtr element)
{
  LIBGZ_GIVEN(Load, << worldName << element)
  this->sdf = element;
  this->Load(worldName);
}
void Sensor::Load(const std::string &worldName)
{
  LIBGZ_GIVEN(Load, << worldName)
  if (this->sdf->HasElement("pose"))
    this->pose = this->sdf->Get<ignition::math::Pose3d>("pose");
  if (this->sdf->Get<bool>("always_on", false).first)
    this->SetActive(true);
  this->world = physics::get_world(worldName);
  this->lastUpdateTime = common::Time::Zero;
  this->node->Init(worldName);
}
void Sensor::Init()
{
  LIBGZ_GIVEN(Init, )
  this->SetUpdateRate(this->sdf->Get<double>("update_rate", 0.0).first);
}
void Sensor::Fini()
{
  LIBGZ_GIVEN(Fini, )
  this->active = false;
  this->plugins.clear();
  this->connections.clear();
  for (auto &pair : this->noises)
    pair.second->Fini();
  this->noises.clear();
  this->scene.reset();
  if (this->node)
    this->node->Fini();
}
void Sensor::SetParent(const std::string &name, const uint32_t id)
{
  LIBGZ_GIVEN(SetParent, << name << id)
  this->parentName = name;
  this->parentId = id;
}
std::string Sensor::ParentName() const
{
  LIBGZ_ASKED(std::string, ParentName)
  return this->parentName;
}
uint32_t Sensor::ParentId() const
{
  LIBGZ_ASKED(uint32_t, ParentId)
  return this->parentId;
}
static common::Time now_of(const Sensor *sensor, const physics::WorldPtr &world, const rendering::ScenePtr &scene)
{
  return sensor->Category() == IMAGE && scene ? scene->SimTime() : world->SimTime();
}
bool Sensor::NeedsUpdate()
{
  const common::Time now = now_of(this, this->world, this->scene);
  if (now <= this->lastMeasurementTime)
  {
    this->ResetLastUpdateTime();  // the clock was set back
    return false;
  }
  const common::Time late = this->own ? this->own->delay : common::Time::Zero;
  return now - this->lastMeasurementTime + late >= this->updatePeriod;
}
// How often Gazebo wakes to ask the sensors of a category: as often as the fastest one measures.
static common::Time period_of(const SensorCategory category)
{
  double rate = 0.0;
  for (const auto &sensor : SensorManager::Instance()->GetSensors())
    if (sensor->Category() == category)
      rate = std::max(rate, sensor->UpdateRate());
  return rate > 0.0 ? 1.0 / rate : 0.0;
}
void Sensor::Update(const bool force)
{
  LIBGZ_GIVEN(Update, << force)
  if (!force && !this->IsActive())
    return;
  const common::Time now = now_of(this, this->world, this->scene);
  if (!this->useStrictRate)
  {
    if (!force && now < this->own->again)
      return;
    const common::Time elapsed = now - this->lastUpdateTime + this->own->delay;
    if (!force && (now <= this->lastUpdateTime || elapsed < this->updatePeriod))
      return;
    const common::Time late = std::max(common::Time::Zero, elapsed - this->updatePeriod);
    this->own->delay = late < this->updatePeriod ? late : common::Time::Zero;
  }
  if (!this->UpdateImpl(force))
  {
    this->own->again = now + period_of(this->own->category);
    return;
  }
  if (!this->useStrictRate)
    this->lastUpdateTime = now;
  this->updated();
}
double Sensor::UpdateRate() const
{
  LIBGZ_ASKED(double, UpdateRate)
  return this->updatePeriod == common::Time::Zero ? 0.0 : 1.0 / this->updatePeriod.Double();
}
void Sensor::SetUpdateRate(const double hz)
{
  LIBGZ_GIVEN(SetUpdateRate, << hz)
  this->updatePeriod = hz > 0.0 ? 1.0 / hz : 0.0;
}
ignition::math::Pose3d Sensor::Pose() const
{
  LIBGZ_ASKED(ignition::math::Pose3d, Pose)
  return this->pose;
}
void Sensor::SetPose(const ignition::math::Pose3d &value)
{
  LIBGZ_GIVEN(SetPose, << value)
  this->pose = value;
}
bool Sensor::IsActive() const
{
  LIBGZ_ASKED(bool, IsActive)
  return this->active;
}
void Sensor::SetActive(const bool value)
{
  LIBGZ_GIVEN(SetActive, << value)
  this->active = value;
}
SensorCategory Sensor::Category() const
{
  LIBGZ_ASKED(SensorCategory, Category)
  return this->own->category;
}
std::string Sensor::Topic() const
{
  LIBGZ_ASKED(std::string, Topic)
  return this->sdf->HasElement("topic") ? this->sdf->Get<std::string>("topic") : "";
}
common::Time Sensor::LastUpdateTime() const
{
  LIBGZ_ASKED(common::Time, LastUpdateTime)
  return this->lastUpdateTime;
}
common::Time Sensor::LastMeasurementTime() const
{
  LIBGZ_ASKED(common::Time, LastMeasurementTime)
  return this->lastMeasurementTime;
}
void Sensor::ResetLastUpdateTime()
{
  LIBGZ_GIVEN(ResetLastUpdateTime, )
  this->lastUpdateTime = this->lastMeasurementTime = this->own->delay = this->own->again = common::Time::Zero;
}
NoisePtr Sensor::Noise(const SensorNoiseType type) const
{
  if (!this->own)
  {
    libgz::Call call(this, "Noise");
    call << type;
    return call.result<NoisePtr>();
  }
  const auto found = this->noises.find(type);
  return found == this->noises.end() ? nullptr : found->second;
}
double Sensor::NextRequiredTimestamp() const
{
  LIBGZ_ASKED(double, NextRequiredTimestamp)
  return std::numeric_limits<double>::quiet_NaN();
}
bool Sensor::StrictRate() const
{
  LIBGZ_ASKED(bool, StrictRate)
  return this->useStrictRate;
}
#undef LIBGZ_ASKED
#undef LIBGZ_GIVEN
static int32_t whole(double number)
{
  return static_cast<int32_t>(ignition::math::clamp(number, -2147483647.0, 2147483647.0));
}
void SensorFactory::RegisterSensor(const std::string &type, SensorFactoryFn factory)
{
  libgz::Gil gil;
  libgz::Ref make(libgz::callable(
      [factory, type](PyObject *const *args) -> PyObject * {
        std::shared_ptr<Sensor> own;
        {
          libgz::Unlocked unlocked;
          own.reset(factory());
        }
        if (!own)
          throw std::runtime_error("the factory of sensors of type " + type + " made none");
        libgz::keep(args[0], {boost::shared_ptr<libgz::Object>(own.get(), [own](libgz::Object *) {}), own});
        Sensor *s = own.get();  // which Python deletes after these methods
        libgz::Ref methods(PyDict_New());
        const auto add = [&](const char *name, const auto &method) {
          PyDict_SetItemString(methods.get(), name, libgz::Ref(libgz::to(method)).get());
        };
        add("Load", std::function<void(std::string, uint32_t, sdf::ElementPtr)>(
                        [s](std::string parent, uint32_t number, sdf::ElementPtr element) {
                          s->SetParent(parent, number);
                          s->Load(s->WorldName(), element);
                          s->Init();
                        }));
        add("Fini", std::function<void()>([s] { s->Fini(); }));
        add("Update", std::function<void(bool)>([s](bool force) { s->Update(force); }));
        add("IsActive", std::function<bool()>([s] { return s->IsActive(); }));
        add("SetActive", std::function<void(bool)>([s](bool on) { s->SetActive(on); }));
        add("Category", std::function<int()>([s] { return s->Category(); }));
        add("Topic", std::function<std::string()>([s] { return s->Topic(); }));
        add("Pose", std::function<ignition::math::Pose3d()>([s] { return s->Pose(); }));
        add("SetPose", std::function<void(ignition::math::Pose3d)>([s](auto pose) { s->SetPose(pose); }));
        add("UpdateRate", std::function<double()>([s] { return s->UpdateRate(); }));
        add("SetUpdateRate", std::function<void(double)>([s](double hz) { s->SetUpdateRate(hz); }));
        add("LastUpdateTime", std::function<common::Time()>([s] { return s->LastUpdateTime(); }));
        add("LastMeasurementTime", std::function<common::Time()>([s] { return s->LastMeasurementTime(); }));
        add("ResetLastUpdateTime", std::function<void()>([s] { s->ResetLastUpdateTime(); }));
        add("noises", std::function<std::map<SensorNoiseType, NoisePtr>()>([s] { return s->noises; }));
        add("save", std::function<std::vector<double>()>([s] {
          std::vector<double> numbers = {double(s->active)};
          for (const auto &time :
              {s->updatePeriod, s->lastUpdateTime, s->lastMeasurementTime, s->own->delay, s->own->again})
            numbers.insert(numbers.end(), {double(time.sec), double(time.nsec)});
          const auto &at = s->pose.Pos();
          const auto &turn = s->pose.Rot();
          numbers.insert(numbers.end(), {at.X(), at.Y(), at.Z(), turn.W(), turn.X(), turn.Y(), turn.Z()});
          return numbers;
        }));
        add("load", std::function<void(std::vector<double>)>([s](std::vector<double> n) {
          s->active = n.at(0) != 0.0;
          std::size_t i = 1;
          for (auto *time :
              {&s->updatePeriod, &s->lastUpdateTime, &s->lastMeasurementTime, &s->own->delay, &s->own->again})
          {
            *time = common::Time(whole(n.at(i)), whole(n.at(i + 1)));
            i += 2;
          }
          s->pose.Set({n.at(11), n.at(12), n.at(13)}, {n.at(14), n.at(15), n.at(16), n.at(17)});
        }));
        return methods.release();
      },
      1));
  libgz::Ref kind(libgz::text_py(type));
  PyObject *registering = libgz::attribute("libgz.classic.sensors.own", "register");
  libgz::Ref done(PyObject_CallFunctionObjArgs(registering, kind.get(), make.get(), nullptr));
  if (!done)
    libgz::raise_python();
}
void Noise::Print(std::ostream &out) const
{
  if (auto *gaussian = dynamic_cast<const GaussianNoiseModel *>(this))
    out << "Gaussian noise, mean[" << gaussian->GetMean() << "], stdDev[" << gaussian->GetStdDev() << "] bias["
        << gaussian->GetBias() << "]\n";
  else
    out << "noise of type[" << this->GetNoiseType() << "]\n";
}
static const char *const SENSORS = "libgz.classic.sensors";
bool load() { return true; }
bool init() { return true; }
bool fini() { return true; }
SensorPtr get_sensor(const std::string &name) { return call_function<SensorPtr>(SENSORS, "get_sensor", name); }
std::string create_sensor(sdf::ElementPtr sdf, const std::string &world, const std::string &parent, uint32_t id)
{
  return call_function<std::string>(SENSORS, "create_sensor", sdf, world, parent, id);
}
void remove_sensor(const std::string &name) { call_function<void>(SENSORS, "remove_sensor", name); }
bool remove_sensors() { return call_function<bool>(SENSORS, "remove_sensors"); }
void run_once(bool force) { call_function<void>(SENSORS, "run_once", force); }
void run_threads() {}
void stop() {}
void disable() { call_function<void>(SENSORS, "disable"); }
void enable() { call_function<void>(SENSORS, "enable"); }
bool running() { return true; }
}  // namespace sensors

namespace rendering {
bool load() { return true; }
bool init() { return true; }
bool fini() { return true; }
ScenePtr get_scene(const std::string &name)
{
  return call_function<ScenePtr>("libgz.classic.rendering", "get_scene", name);
}
ScenePtr create_scene(const std::string &name, bool, bool) { return get_scene(name); }
void remove_scene(const std::string &) {}
bool lockstep_enabled() { return true; }
void set_lockstep_enabled(bool) {}
}  // namespace rendering
}  // namespace gazebo

ignition::math::Vector3d libgz::gravity_of(const Object *engine)
{
  return Call(engine, "GetGravity").result<ignition::math::Vector3d>();
}

using namespace boost::archive::iterators;
void Base64Encode(const char *bytes, unsigned int length, std::string &result)
{
  using Encoder = base64_from_binary<transform_width<const char *, 6, 8>>;
  result.append(Encoder(bytes), Encoder(bytes + length));
  result.append((3 - length % 3) % 3, '=');
}
std::string Base64Decode(const std::string &text)
{
  using Decoder = transform_width<binary_from_base64<std::string::const_iterator>, 8, 6>;
  const std::string plain = text.substr(0, text.find('='));
  return std::string(Decoder(plain.begin()), Decoder(plain.end())).substr(0, plain.size() * 3 / 4);
}
