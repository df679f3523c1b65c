// The calls that plugins make in every step, on the engine's own tables. License: Apache License 2.0.
//
// A row is looked up by Python again when bodies or joints came or went. Where a row is stale, or an object has none,
// the method of Python is called, which also says what is wrong.
#include "bridge.hh"

namespace libgz {
/* `tables` of updates.h. */
struct Tables
{
  char *context;
  double step;
  const uintptr_t *bodies;
  const double *body_state;
  const uint8_t *body_fresh;
  int64_t body_size;
  const uintptr_t *joints;
  const double *joint_state;
  const uint8_t *joint_fresh;
  int64_t joint_size;
  const void *marks;
  int64_t touched, changes, done;
};
/* `ClockRecord`. */
struct Clock
{
  double sim_time, pause_time;
  int64_t iterations;
  double start;
};
/* Where an object's numbers are. */
struct Row
{
  const Tables *tables = nullptr;
  const Clock *clock = nullptr;
  int64_t changes = -1, row = -1;
  PyObject *keep = nullptr;  // what owns the tables
  bool framed = false;       // a model: its frame is fixed to that body
  double frame[7] = {};      // position and rotation there
  math::Pose3d pose;         // what WorldPose has returned
};
enum { POSITION = 0, ROTATION = 3, CENTRE = 7, VELOCITY = 10, RATE = 13, BODY = 16, JOINT = 4 };  // columns

static int64_t resting;  // where a context says that all bodies rest
static void (*enable)(uintptr_t);
using Force = void (*)(uintptr_t, double, double, double);
using ForceAt = void (*)(uintptr_t, double, double, double, double, double, double);
static Force add_force, add_torque, add_relative_force, add_relative_torque;
static ForceAt add_force_at, add_force_at_relative;
thread_local const void *locked = nullptr;  // the tables whose world this thread holds, within one callback

void attach_row(Object *object)
{
  if (dynamic_cast<gazebo::physics::Link *>(object) || dynamic_cast<gazebo::physics::Joint *>(object) ||
      dynamic_cast<gazebo::physics::World *>(object) || dynamic_cast<gazebo::physics::Model *>(object))
    object->row = new Row;
}
void drop_row(void *row)
{
  if (row == nullptr)
    return;
  Py_XDECREF(static_cast<Row *>(row)->keep);
  delete static_cast<Row *>(row);
}
static bool look_up(const Object *object, Row *row)
{
  Gil gil;
  Ref found(PyObject_CallOneArg(
      attribute("libgz.classic_cxx.rows", "row_of"), static_cast<PyObject *>(object->view)));
  if (!found)
    raise_python();
  if (found.get() == Py_None)
    return false;
  PyObject *keep = PyTuple_GET_ITEM(found.get(), 0);
  Py_INCREF(keep);
  Py_XDECREF(std::exchange(row->keep, keep));
  row->tables = static_cast<const Tables *>(PyLong_AsVoidPtr(PyTuple_GET_ITEM(found.get(), 1)));
  row->row = PyLong_AsLongLong(PyTuple_GET_ITEM(found.get(), 2));
  row->clock = static_cast<const Clock *>(PyLong_AsVoidPtr(PyTuple_GET_ITEM(found.get(), 3)));
  row->framed = PyTuple_GET_SIZE(found.get()) > 4;
  for (int i = 0; row->framed && i < 7; ++i)
    row->frame[i] = PyFloat_AsDouble(PyTuple_GET_ITEM(PyTuple_GET_ITEM(found.get(), 4), i));
  row->changes = row->tables ? row->tables->changes : 0;
  return true;
}
static inline Row *row_at(const Object *object)
{
  Row *row = static_cast<Row *>(object->row);
  if (row == nullptr)
    return nullptr;
  if (__builtin_expect(row->tables == nullptr || row->tables->changes != row->changes, 0) && !look_up(object, row))
    return nullptr;
  return row->row >= 0 ? row : nullptr;
}
/* The numbers of a body; null if it has none, or they are stale. */
static inline const double *body_of(const Object *object)
{
  const Row *row = row_at(object);
  return row && !row->framed && row->tables->body_fresh[row->row] ? row->tables->body_state + BODY * row->row : nullptr;
}
static inline const double *joint_of(const Object *object)
{
  const Row *row = row_at(object);
  return row && row->tables->joint_fresh[row->row] ? row->tables->joint_state + JOINT * row->row : nullptr;
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

/* A body that this thread may push: it holds the world, and the body moves. */
static inline const Row *pushed(const Object *object)
{
  const Row *row = row_at(object);
  if (row == nullptr || enable == nullptr)
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
static inline uintptr_t woken(const Row *row)
{
  const uintptr_t body = row->tables->bodies[row->row];
  *reinterpret_cast<int64_t *>(row->tables->context + resting) = 0;
  enable(body);
  return body;
}
static inline bool finite(const math::Vector3d &v) { return std::isfinite(v.X() + v.Y() + v.Z()); }
static inline bool push(const Object *object, Force function, const math::Vector3d &v)
{
  const Row *row = finite(v) ? pushed(object) : nullptr;
  if (row == nullptr)
    return false;
  function(woken(row), v.X(), v.Y(), v.Z());
  return true;
}
static inline bool push_at(const Object *object, ForceAt function, const math::Vector3d &v, const math::Vector3d &p)
{
  const Row *row = finite(v) && finite(p) ? pushed(object) : nullptr;
  if (row == nullptr)
    return false;
  function(woken(row), v.X(), v.Y(), v.Z(), p.X(), p.Y(), p.Z());
  return true;
}
gazebo::common::UpdateInfo info_at(const void *clock, const std::string &world)
{
  const Clock *time = static_cast<const Clock *>(clock);
  timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  gazebo::common::UpdateInfo info;
  info.worldName = world;
  info.simTime.Set(time->sim_time);
  info.realTime.Set(static_cast<double>(now.tv_sec) + now.tv_nsec * 1e-9 - time->start);
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
  if (row != nullptr && row->tables->body_fresh[row->row])
  {
    const double *b = row->tables->body_state + BODY * row->row;
    return row->pose = row->framed ? framed(b, row->frame) : Pose3d(vector_at(b), rotation_at(b + ROTATION));
  }
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
LIBGZ_PUSH(AddForce, add_force)
LIBGZ_PUSH(AddTorque, add_torque)
LIBGZ_PUSH(AddRelativeForce, add_relative_force)
LIBGZ_PUSH(AddRelativeTorque, add_relative_torque)
#define LIBGZ_PUSH_AT(Name, function) \
  void Link::Name(const Vector3d &v, const Vector3d &p) \
  { \
    if (push_at(this, function, v, p)) \
      return; \
    libgz::Call call(this, #Name); \
    call << v << p; \
    call.run(); \
  }
LIBGZ_PUSH_AT(AddForceAtWorldPosition, add_force_at)
LIBGZ_PUSH_AT(AddForceAtRelativePosition, add_force_at_relative)
void Link::AddLinkForce(const Vector3d &force, const Vector3d &offset)
{
  if (const double *b = finite(force) && finite(offset) ? body_of(this) : nullptr)
  {
    const double u = b[ROTATION], x = b[ROTATION + 1], y = b[ROTATION + 2], z = b[ROTATION + 3];
    const Vector3d arm = rotated(u, x, y, z, offset);
    const Vector3d point(b[0] + arm.X(), b[1] + arm.Y(), b[2] + arm.Z());
    if (push_at(this, add_force_at, rotated(u, x, y, z, force), point))
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
common::Time World::SimTime() const
{
  Row *row = static_cast<Row *>(this->row);
  if (row != nullptr && (row->clock != nullptr || look_up(this, row)) && row->clock != nullptr)
    return common::Time(row->clock->sim_time);
  return libgz::Call(this, "SimTime").result<common::Time>();
}
}  // namespace physics
}  // namespace gazebo

extern "C" void libgz_hot(void *const *functions, int64_t offset, int64_t tables, int64_t clock)
{
  if (tables != sizeof(Tables) || clock != sizeof(Clock))
    return;  // another engine: Python is called
  resting = offset;
  add_force = reinterpret_cast<Force>(functions[1]);
  add_torque = reinterpret_cast<Force>(functions[2]);
  add_relative_force = reinterpret_cast<Force>(functions[3]);
  add_relative_torque = reinterpret_cast<Force>(functions[4]);
  add_force_at = reinterpret_cast<ForceAt>(functions[5]);
  add_force_at_relative = reinterpret_cast<ForceAt>(functions[6]);
  enable = reinterpret_cast<void (*)(uintptr_t)>(functions[0]);
}
