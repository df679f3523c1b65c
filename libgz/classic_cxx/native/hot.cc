// The calls that plugins make in every step, on the engine's own tables. License: Apache License 2.0.
//
// A row is looked up by Python again when bodies or joints came or went. Where a row is stale, or an object has none,
// the method of Python is called, which also says what is wrong. shared.hh is made of Python's declarations.
#include "bridge.hh"
#include "shared.hh"

namespace libgz {
/* Where an object's numbers are. */
struct Row : RowRecord
{
  int64_t changes = -1;      // of the tables, when it was looked up
  PyObject *keep = nullptr;  // what owns them
  math::Pose3d pose;         // what WorldPose has returned
};
enum { POSITION = 0, ROTATION = 3, CENTRE = 7, VELOCITY = 10, RATE = 13, BODY = 16, JOINT = 4 };  // columns

static Functions ode;
thread_local const void *locked = nullptr;  // the tables whose world this thread holds, within one Frame

void attach_row(Object *object)
{
  if (dynamic_cast<gazebo::physics::Link *>(object) || dynamic_cast<gazebo::physics::Joint *>(object) ||
      dynamic_cast<gazebo::physics::World *>(object) || dynamic_cast<gazebo::physics::Model *>(object))
    object->row = new Row{};
}
void drop_row(void *row)
{
  if (row == nullptr)
    return;
  Py_XDECREF(static_cast<Row *>(row)->keep);
  delete static_cast<Row *>(row);
}
static void look_up(const Object *object, Row *row)
{
  Gil gil;
  Ref address(PyLong_FromVoidPtr(static_cast<RowRecord *>(row)));
  PyObject *arguments[] = {static_cast<PyObject *>(object->view), address.get()};
  Ref found(PyObject_Vectorcall(attribute("libgz.classic_cxx.rows", "fill"), arguments, 2, nullptr));
  if (!found)
    raise_python();
  Py_XDECREF(std::exchange(row->keep, found.release()));
  row->changes = row->tables ? row->tables->changes : 0;
}
/* The row of an object that has numbers in a table; it may have none of a body or joint. */
static inline Row *looked_up(const Object *object)
{
  Row *row = static_cast<Row *>(object->row);
  if (row == nullptr)
    return nullptr;
  if (__builtin_expect(row->tables == nullptr || row->tables->changes != row->changes, 0))
    look_up(object, row);
  return row->tables != nullptr ? row : nullptr;
}
static inline Row *row_at(const Object *object)
{
  Row *row = looked_up(object);
  return row != nullptr && row->row >= 0 ? row : nullptr;
}
template <class T>
static inline T *array(void *address)
{
  return static_cast<T *>(address);
}
/* The numbers of a body; null if they are stale. */
static inline const double *body_at(const Row *row)
{
  const TableRecord *tables = row->tables;
  return array<uint8_t>(tables->body_fresh)[row->row] ? array<double>(tables->body_state) + BODY * row->row : nullptr;
}
static inline const double *body_of(const Object *object)
{
  const Row *row = row_at(object);
  return row && !row->framed ? body_at(row) : nullptr;
}
static inline const double *joint_at(const Row *row)
{
  const TableRecord *tables = row->tables;
  return array<uint8_t>(tables->joint_fresh)[row->row] ? array<double>(tables->joint_state) + JOINT * row->row
                                                        : nullptr;
}
static inline const double *joint_of(const Object *object)
{
  const Row *row = row_at(object);
  return row ? joint_at(row) : nullptr;
}
static inline math::Vector3d vector_at(const double *p) { return {p[0], p[1], p[2]}; }
static inline math::Quaterniond rotation_at(const double *p) { return {p[0], p[1], p[2], p[3]}; }
/* libgz's rotation of a vector, so that both languages have the same bits. */
static inline math::Vector3d rotated(double u, double x, double y, double z, const math::Vector3d &v, double s = 2.0)
{
  const double tx = s * (y * v.Z() - z * v.Y()), ty = s * (z * v.X() - x * v.Z()), tz = s * (x * v.Y() - y * v.X());
  return {v.X() + u * tx + (y * tz - z * ty), v.Y() + u * ty + (z * tx - x * tz), v.Z() + u * tz + (x * ty - y * tx)};
}
/* libgz's pose of a frame that is fixed to a body. */
static inline math::Pose3d framed(const double *b, const double *f)
{
  const double u = b[ROTATION], x = b[ROTATION + 1], y = b[ROTATION + 2], z = b[ROTATION + 3];
  const math::Vector3d p = rotated(u, x, y, z, vector_at(f));
  const double fu = f[3], fx = f[4], fy = f[5], fz = f[6];
  return math::Pose3d({p.X() + b[0], p.Y() + b[1], p.Z() + b[2]},
      {u * fu - x * fx - y * fy - z * fz, u * fx + x * fu + y * fz - z * fy, u * fy - x * fz + y * fu + z * fx,
          u * fz + x * fy - y * fx + z * fu});
}
static inline math::Vector3d into_frame(const double *b, const math::Vector3d &v)
{
  const double u = b[ROTATION], x = b[ROTATION + 1], y = b[ROTATION + 2], z = b[ROTATION + 3];
  return rotated(u, -x, -y, -z, v, 2.0 / (u * u + x * x + y * y + z * z));
}
static inline math::Vector3d velocity_of_origin(const double *b)
{
  const double ax = b[0] - b[CENTRE], ay = b[1] - b[CENTRE + 1], az = b[2] - b[CENTRE + 2];
  const double *w = b + RATE, *v = b + VELOCITY;
  return {v[0] + (w[1] * az - w[2] * ay), v[1] + (w[2] * ax - w[0] * az), v[2] + (w[0] * ay - w[1] * ax)};
}

/* The row of a body that moves, or of a joint, which this thread may change: it holds the world. */
static inline const Row *pushed(const Object *object)
{
  const Row *row = row_at(object);
  if (row == nullptr)
    return nullptr;
  if (__builtin_expect(locked != row->tables, 0))
  {
    Gil gil;
    Ref owned(PyObject_CallOneArg(attribute("libgz.classic_cxx.rows", "owned"), static_cast<PyObject *>(object->view)));
    if (!owned)
      raise_python();
    if (owned.get() != Py_True)
      return nullptr;
    locked = row->tables;
  }
  return row;
}
static inline void *woken(const Row *row, int64_t body)
{
  void *handle = array<void *>(row->tables->bodies)[body];
  array<StepContext>(row->tables->context)->resting = 0;
  ode.dBodyEnable(handle);
  return handle;
}
static inline bool finite(const math::Vector3d &v) { return std::isfinite(v.X() + v.Y() + v.Z()); }
static inline bool push(
    const Object *object, decltype(Functions::dBodyAddForce) function, const math::Vector3d &v)
{
  const Row *row = finite(v) ? pushed(object) : nullptr;
  if (row == nullptr)
    return false;
  function(woken(row, row->row), v.X(), v.Y(), v.Z());
  return true;
}
static inline bool push_at(const Object *object, decltype(Functions::dBodyAddForceAtPos) function,
    const math::Vector3d &v, const math::Vector3d &p)
{
  const Row *row = finite(v) && finite(p) ? pushed(object) : nullptr;
  if (row == nullptr)
    return false;
  function(woken(row, row->row), v.X(), v.Y(), v.Z(), p.X(), p.Y(), p.Z());
  return true;
}
/* As SdfJoint.add_force does it, with the same bits: a hinge or slider, whose links it wakes. */
static bool add_effort(const Object *joint, unsigned int index, double effort)
{
  const Row *row = index == 0 && std::isfinite(effort) ? pushed(joint) : nullptr;
  void *handle = row ? array<void *>(row->tables->joints)[row->row] : nullptr;
  if (handle == nullptr)
    return false;
  JointRecord *record = row->joint;
  const AxisRecord *axis = record->axes[0];
  if (axis->effort >= 0.0)
    effort = std::max(-axis->effort, std::min(axis->effort, effort));
  if (axis->velocity >= 0.0)
  {
    const double *state = joint_at(row);
    if (state == nullptr)
      return false;
    if (std::fabs(state[2]) > axis->velocity && state[2] * effort > 0.0)
      effort = 0.0;
  }
  const int64_t step = array<StepContext>(row->tables->context)->steps;
  if (record->applied_at != step)
  {
    std::copy(record->applied, record->applied + 2, record->before);
    record->before_at = std::exchange(record->applied_at, step);
    std::fill(record->applied, record->applied + 2, 0.0);
  }
  record->applied[0] += effort;
  for (int64_t body : row->ends)
    if (body >= 0 && ode.dBodyGetAutoDisableFlag(array<void *>(row->tables->bodies)[body]))
      woken(row, body);
  (row->slides ? ode.dJointAddSliderForce : ode.dJointAddHingeTorque)(handle, effort);
  return true;
}
static const Parameter *parameter_of(const std::string &key)
{
  for (const Parameter &one : PARAMETERS)
    if (key == one.key)
      return &one;
  return nullptr;
}
static void put(const Row *row, void *handle, const Parameter *parameter, double value)
{
  value = std::min(std::max(value, parameter->least), parameter->most);
  row->joint->parameters[parameter->place] = value;
  (row->slides ? ode.dJointSetSliderParam : ode.dJointSetHingeParam)(handle, parameter->number, value);
}
/* As SdfJoint.set_param does it. */
static bool set_parameter(const Object *joint, const std::string &key, unsigned int index, const boost::any &given)
{
  double value;
  if (const double *real = boost::any_cast<double>(&given))
    value = *real;
  else if (const int *whole = boost::any_cast<int>(&given))
    value = *whole;
  else if (const float *single = boost::any_cast<float>(&given))
    value = *single;
  else
    return false;
  const Row *row = index == 0 && !std::isnan(value) ? pushed(joint) : nullptr;
  void *handle = row ? array<void *>(row->tables->joints)[row->row] : nullptr;
  if (handle == nullptr)
    return false;
  if (const Parameter *parameter = parameter_of(key))
    put(row, handle, parameter, value);
  else if (key == "friction")
  {
    // A motor with the target velocity zero.
    static const Parameter *const vel = parameter_of("vel"), *const fmax = parameter_of("fmax");
    row->joint->axes[0]->friction = value;
    put(row, handle, vel, 0.0);
    put(row, handle, fmax, value);
  }
  else
    return false;
  return true;
}
static bool get_parameter(const Object *joint, const std::string &key, unsigned int index, double &found)
{
  const Row *row = index == 0 ? pushed(joint) : nullptr;
  void *handle = row ? array<void *>(row->tables->joints)[row->row] : nullptr;
  if (handle == nullptr)
    return false;
  const AxisRecord *axis = row->joint->axes[0];
  if (const Parameter *parameter = parameter_of(key))
    found = (row->slides ? ode.dJointGetSliderParam : ode.dJointGetHingeParam)(handle, parameter->number);
  else if (key == "hi_stop")
    found = axis->upper;
  else if (key == "lo_stop")
    found = axis->lower;
  else if (key == "friction")
    found = axis->friction;
  else
    return false;
  return true;
}
gazebo::common::UpdateInfo info_at(const void *clock, const std::string &world)
{
  const ClockRecord *time = static_cast<const ClockRecord *>(clock);
  timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  gazebo::common::UpdateInfo info;
  info.worldName = world;
  info.simTime.Set(time->sim_time);
  info.realTime.Set(static_cast<double>(now.tv_sec) + now.tv_nsec * 1e-9 - time->_start);
  return info;
}
}  // namespace libgz

using namespace libgz;

namespace gazebo {
namespace physics {
#define LIBGZ_READ(Class, Type, Name, expression) \
  Type Class::Name() const \
  { \
    if (const double *b = body_of(this)) \
      return expression; \
    return libgz::Call(this, #Name).result<Type>(); \
  }
using ignition::math::Pose3d;
using ignition::math::Vector3d;
const Pose3d &Entity::WorldPose() const
{
  Row *row = row_at(this);
  if (const double *b = row != nullptr ? body_at(row) : nullptr)
    return row->pose = row->framed ? framed(b, row->frame) : Pose3d(vector_at(b), rotation_at(b + ROTATION));
  return libgz::Call(this, "WorldPose").kept<Pose3d>();
}
LIBGZ_READ(Link, Vector3d, RelativeLinearVel, into_frame(b, velocity_of_origin(b)))
LIBGZ_READ(Link, Vector3d, RelativeAngularVel, into_frame(b, vector_at(b + RATE)))
LIBGZ_READ(Entity, Vector3d, WorldAngularVel, vector_at(b + RATE))
LIBGZ_READ(Link, Vector3d, WorldLinearVel, velocity_of_origin(b))
LIBGZ_READ(Link, Vector3d, WorldCoGLinearVel, vector_at(b + VELOCITY))
LIBGZ_READ(Link, Pose3d, WorldCoGPose, Pose3d(vector_at(b + CENTRE), rotation_at(b + ROTATION)))

#define LIBGZ_PUSH(Name, function) \
  void Link::Name(const Vector3d &v) \
  { \
    if (push(this, function, v)) \
      return; \
    libgz::Call call(this, #Name); \
    call << v; \
    call.run(); \
  }
LIBGZ_PUSH(AddForce, ode.dBodyAddForce)
LIBGZ_PUSH(AddTorque, ode.dBodyAddTorque)
LIBGZ_PUSH(AddRelativeForce, ode.dBodyAddRelForce)
LIBGZ_PUSH(AddRelativeTorque, ode.dBodyAddRelTorque)
#define LIBGZ_PUSH_AT(Name, function) \
  void Link::Name(const Vector3d &v, const Vector3d &p) \
  { \
    if (push_at(this, function, v, p)) \
      return; \
    libgz::Call call(this, #Name); \
    call << v << p; \
    call.run(); \
  }
LIBGZ_PUSH_AT(AddForceAtWorldPosition, ode.dBodyAddForceAtPos)
LIBGZ_PUSH_AT(AddForceAtRelativePosition, ode.dBodyAddForceAtRelPos)
void Link::AddLinkForce(const Vector3d &force, const Vector3d &offset)
{
  if (const double *b = finite(force) && finite(offset) ? body_of(this) : nullptr)
  {
    const double u = b[ROTATION], x = b[ROTATION + 1], y = b[ROTATION + 2], z = b[ROTATION + 3];
    const Vector3d arm = rotated(u, x, y, z, offset);
    const Vector3d point(b[0] + arm.X(), b[1] + arm.Y(), b[2] + arm.Z());
    if (push_at(this, ode.dBodyAddForceAtPos, rotated(u, x, y, z, force), point))
      return;
  }
  libgz::Call call(this, "AddLinkForce");
  call << force << offset;
  call.run();
}
double Joint::Position(const unsigned int index) const
{
  const double *j = index == 0 ? joint_of(this) : nullptr;
  if (j != nullptr)
    return j[0];
  libgz::Call call(this, "Position");
  return (call << index).result<double>();
}
double Joint::GetVelocity(unsigned int index) const
{
  const double *j = index == 0 ? joint_of(this) : nullptr;
  if (j != nullptr)
    return j[2];
  libgz::Call call(this, "GetVelocity");
  return (call << index).result<double>();
}
void Joint::SetForce(unsigned int index, double effort)
{
  if (libgz::add_effort(this, index, effort))
    return;
  libgz::Call call(this, "SetForce");
  call << index << effort;
  call.run();
}
double Joint::GetForce(unsigned int index)
{
  const Row *row = looked_up(this);
  if (row != nullptr && index < row->joint->dof && row->joint->axes[0] != nullptr)
    return row->joint->applied[index];
  libgz::Call call(this, "GetForce");
  return (call << index).result<double>();
}
bool Joint::SetParam(const std::string &key, unsigned int index, const boost::any &value)
{
  if (libgz::set_parameter(this, key, index, value))
    return true;
  libgz::Call call(this, "SetParam");
  return (call << key << index << value).result<bool>();
}
double Joint::GetParam(const std::string &key, unsigned int index)
{
  double found;
  if (libgz::get_parameter(this, key, index, found))
    return found;
  libgz::Call call(this, "GetParam");
  return (call << key << index).result<double>();
}
common::Time World::SimTime() const
{
  Row *row = static_cast<Row *>(this->row);
  if (row != nullptr && row->clock == nullptr)
    libgz::look_up(this, row);
  if (row != nullptr && row->clock != nullptr)
    return common::Time(row->clock->sim_time);
  return libgz::Call(this, "SimTime").result<common::Time>();
}
}  // namespace physics
}  // namespace gazebo

extern "C" void libgz_hot(const libgz::Functions *functions) { libgz::ode = *functions; }
