/* How methods of C++ objects call Python: conversions of arguments and results, and the call itself.
 * License: Apache License 2.0.
 */
#ifndef LIBGZ_BRIDGE_HH
#define LIBGZ_BRIDGE_HH
#define PY_SSIZE_T_CLEAN
#include <Python.h>

#include <any>
#include <list>
#include <map>
#include <string>
#include <type_traits>
#include <typeinfo>
#include <vector>

#include "gazebo/libgz/gazebo.hh"

namespace libgz {
namespace math = ignition::math;

/* The interpreter's lock, which user code runs without. */
struct Gil
{
  PyGILState_STATE state = PyGILState_Ensure();
  Gil() {}
  Gil(const Gil &) = delete;
  ~Gil() { PyGILState_Release(this->state); }
};

/* A reference that is counted. */
class Ref
{
 public:
  explicit Ref(PyObject *object = nullptr) : object(object) {}
  Ref(Ref &&other) : object(other.object) { other.object = nullptr; }
  Ref(const Ref &) = delete;
  Ref &operator=(Ref &&other)
  {
    std::swap(this->object, other.object);
    return *this;
  }
  ~Ref() { Py_XDECREF(this->object); }
  PyObject *get() const { return this->object; }
  PyObject *release() { return std::exchange(this->object, nullptr); }
  explicit operator bool() const { return this->object != nullptr; }

 private:
  PyObject *object;
};

/* What Python raised, on its way through a plugin's code. */
class PythonError : public std::runtime_error
{
 public:
  PythonError(const std::string &text, PyObject *error) : std::runtime_error(text), error(error, &PythonError::Drop) {}
  PyObject *get() const { return this->error.get(); }

 private:
  static void Drop(PyObject *error);
  std::shared_ptr<PyObject> error;
};
[[noreturn]] void raise_python();  // what Python has raised
[[noreturn]] void unsupported(const std::string &what);

/* The two pointers that C++ code may have to an object: classic has boost's for physics, std's for sensors. */
struct Holder
{
  boost::shared_ptr<Object> boosted;
  std::shared_ptr<Object> standard;
};
using Makers = std::map<std::string, Holder (*)(PyObject *)>;
void add_makers(Makers &makers);
template <class X>
Holder make(PyObject *view)
{
  Py_INCREF(view);
  if constexpr (std::is_base_of_v<gazebo::sensors::Sensor, X> || std::is_base_of_v<gazebo::rendering::Visual, X> ||
                std::is_base_of_v<gazebo::sensors::Noise, X> || std::is_base_of_v<gazebo::common::Battery, X>)
  {
    std::shared_ptr<X> standard(new X(Adopt{view}));
    return {boost::shared_ptr<Object>(standard.get(), [standard](Object *) {}), standard};
  }
  else
  {
    boost::shared_ptr<X> boosted(new X(Adopt{view}));
    return {boosted, std::shared_ptr<Object>(boosted.get(), [boosted](Object *) {})};
  }
}
Holder wrap(PyObject *view);  // the one C++ object of an object of Python
void keep(PyObject *view, const Holder &holder);  // that this is its C++ object

PyObject *attribute(const char *module, const char *name);  // borrowed
PyObject *interned(const char *name);                       // borrowed, kept by the text's address
PyObject *build(const char *name, std::initializer_list<double> values);  // a value of libgz.classic.math
PyObject *text_py(const std::string &text);
std::string text_of(PyObject *object);
double number_of(PyObject *object);
double number_at(PyObject *object, const char *name);
Ref got(PyObject *object, const char *name);
sdf::ElementPtr element_of(PyObject *element);
PyObject *element_py(const sdf::ElementPtr &element);
PyObject *message_type(const google::protobuf::Message &message);
PyObject *message_py(const google::protobuf::Message &message);
void message_of(PyObject *object, google::protobuf::Message &message);
PyObject *any_py(const boost::any &value);
boost::any any_of(PyObject *object);
gazebo::event::ConnectionPtr connection_of(PyObject *connection);
PyObject *construct_time(const gazebo::common::Time &time);
gazebo::common::Time time_of(PyObject *object);
gazebo::physics::Contact contact_of(PyObject *object);
const unsigned char *bytes_of(PyObject *object);
/* A callable of Python that calls C++ with its arguments, of which there are `count`. */
using Function = std::function<PyObject *(PyObject *const *)>;
PyObject *callable(Function function, int count);

// For what calls plugins beside events and Load; a plugin as a pointer is what libgz_create has returned.
using Running = std::shared_ptr<const void>;  // a plugin as far as its callbacks need it
Running running_plugin();
Running context_of(void *plugin);
PluginRoot *root_of(void *plugin);
void run_as(const Running &plugin, const char *what, const std::function<void()> &code);  // under the plugin's name
PyObject *caught();  // what is being handled, as an exception of Python: a new reference
void drop_filters(const void *plugin);
extern void *main_window;

/* User code runs without the interpreter's lock, so that its threads can call libgz while it waits for them. */
struct Unlocked
{
  PyThreadState *state = PyEval_SaveThread();
  ~Unlocked() { PyEval_RestoreThread(this->state); }
};

// To Python: new references ------------------------------------------------------------------------------------------

template <class T>
constexpr bool is_object = std::is_base_of_v<Object, T>;
template <class T>
constexpr bool is_message = std::is_base_of_v<google::protobuf::Message, T>;

template <class T, class = void>
struct To
{
  static PyObject *f(const T &) { unsupported(std::string("arguments of type ") + typeid(T).name()); }
};
template <class T>
PyObject *to(const T &value)
{
  return To<std::decay_t<T>>::f(value);
}
template <class T>
struct To<T, std::enable_if_t<std::is_arithmetic_v<T> || std::is_enum_v<T>>>
{
  static PyObject *f(T v)
  {
    if constexpr (std::is_same_v<T, bool>)
      return PyBool_FromLong(v);
    else if constexpr (std::is_floating_point_v<T>)
      return PyFloat_FromDouble(v);
    else if constexpr (std::is_unsigned_v<T>)
      return PyLong_FromUnsignedLongLong(v);
    else
      return PyLong_FromLongLong(static_cast<long long>(v));
  }
};
#define LIBGZ_TO(type, expression) \
  template <> \
  struct To<type> \
  { \
    static PyObject *f(const type &v) { return expression; } \
  };
LIBGZ_TO(std::string, text_py(v))
template <>
struct To<const char *>
{
  static PyObject *f(const char *v) { return text_py(v); }
};
template <>
struct To<char *>
{
  static PyObject *f(const char *v) { return text_py(v); }
};
LIBGZ_TO(math::Vector3d, build("Vector3d", {v.X(), v.Y(), v.Z()}))
LIBGZ_TO(math::Vector2d, build("Vector2d", {v.X(), v.Y()}))
LIBGZ_TO(math::Vector2i, build("Vector2i", {double(v.X()), double(v.Y())}))
LIBGZ_TO(math::Quaterniond, build("Quaterniond", {v.W(), v.X(), v.Y(), v.Z()}))
LIBGZ_TO(math::Pose3d,
    build("Pose3d", {v.Pos().X(), v.Pos().Y(), v.Pos().Z(), v.Rot().W(), v.Rot().X(), v.Rot().Y(), v.Rot().Z()}))
LIBGZ_TO(math::Color, build("Color", {v.R(), v.G(), v.B(), v.A()}))
LIBGZ_TO(math::Angle, build("Angle", {v.Radian()}))
LIBGZ_TO(math::AxisAlignedBox,
    build("AxisAlignedBox", {v.Min().X(), v.Min().Y(), v.Min().Z(), v.Max().X(), v.Max().Y(), v.Max().Z()}))
LIBGZ_TO(math::Matrix3d,
    build("Matrix3d", {v(0, 0), v(0, 1), v(0, 2), v(1, 0), v(1, 1), v(1, 2), v(2, 0), v(2, 1), v(2, 2)}))
LIBGZ_TO(math::Matrix4d, build("Matrix4d", {v(0, 0), v(0, 1), v(0, 2), v(0, 3), v(1, 0), v(1, 1), v(1, 2), v(1, 3),
                                            v(2, 0), v(2, 1), v(2, 2), v(2, 3), v(3, 0), v(3, 1), v(3, 2), v(3, 3)}))
LIBGZ_TO(gazebo::common::Time, construct_time(v))
LIBGZ_TO(gazebo::common::PID, build("PID", {v.GetPGain(), v.GetIGain(), v.GetDGain(), v.GetIMax(), v.GetIMin(),
                                            v.GetCmdMax(), v.GetCmdMin()}))
PyObject *inertial_py(const math::Inertiald &value);
LIBGZ_TO(math::Inertiald, inertial_py(v))
LIBGZ_TO(sdf::ElementPtr, element_py(v))
PyObject *sdf_py(const sdf::SDF &sdf);
LIBGZ_TO(sdf::SDF, sdf_py(v))
LIBGZ_TO(boost::any, any_py(v))
LIBGZ_TO(boost::filesystem::path, text_py(v.string()))
PyObject *trajectory_py(const gazebo::physics::TrajectoryInfo &info);
template <>
struct To<gazebo::physics::TrajectoryInfoPtr>
{
  static PyObject *f(const gazebo::physics::TrajectoryInfoPtr &v) { return trajectory_py(*v); }
};
template <class T>
struct To<T, std::enable_if_t<is_object<T>>>
{
  static PyObject *f(const T &v)
  {
    Py_INCREF(static_cast<PyObject *>(v.view));
    return static_cast<PyObject *>(v.view);
  }
};
inline PyObject *view_of(const Object *object)
{
  PyObject *view = object ? static_cast<PyObject *>(object->view) : Py_None;
  Py_INCREF(view);
  return view;
}
template <class T>
struct To<T *, std::enable_if_t<is_object<std::remove_const_t<T>>>>
{
  static PyObject *f(const T *v) { return view_of(v); }
};
template <class T>
struct To<boost::shared_ptr<T>, std::enable_if_t<is_object<std::remove_const_t<T>>>>
{
  static PyObject *f(const boost::shared_ptr<T> &v) { return view_of(v.get()); }
};
template <class T>
struct To<std::shared_ptr<T>, std::enable_if_t<is_object<std::remove_const_t<T>>>>
{
  static PyObject *f(const std::shared_ptr<T> &v) { return view_of(v.get()); }
};
template <class T>
struct To<boost::shared_ptr<T>, std::enable_if_t<is_message<std::remove_const_t<T>>>>
{
  static PyObject *f(const boost::shared_ptr<T> &v) { return message_py(*v); }
};
template <class T>
struct To<T, std::enable_if_t<is_message<T>>>
{
  static PyObject *f(const T &v) { return message_py(v); }
};
template <class L>
PyObject *list_py(const L &values)
{
  Ref list(PyList_New(0));
  for (const auto &value : values)
    PyList_Append(list.get(), Ref(to(value)).get());
  return list.release();
}
template <class T>
struct To<std::vector<T>>
{
  static PyObject *f(const std::vector<T> &v) { return list_py(v); }
};
template <class T>
struct To<std::list<T>>
{
  static PyObject *f(const std::list<T> &v) { return list_py(v); }
};
template <class T>
struct To<std::set<T>>
{
  static PyObject *f(const std::set<T> &v) { return list_py(v); }
};
template <class K, class T>
struct To<std::map<K, T>>
{
  static PyObject *f(const std::map<K, T> &v)
  {
    Ref map(PyDict_New());
    for (const auto &pair : v)
      PyDict_SetItem(map.get(), Ref(to(pair.first)).get(), Ref(to(pair.second)).get());
    return map.release();
  }
};

// From Python: borrowed references ------------------------------------------------------------------------------------

template <class T, class = void>
struct From
{
  static T f(PyObject *) { unsupported(std::string("results of type ") + typeid(T).name()); }
};
template <class T>
struct From<T, std::enable_if_t<std::is_arithmetic_v<T> || std::is_enum_v<T>>>
{
  static T f(PyObject *o)
  {
    if constexpr (std::is_same_v<T, bool>)
      return PyObject_IsTrue(o) == 1;
    else if constexpr (std::is_floating_point_v<T>)
      return static_cast<T>(number_of(o));
    else if constexpr (std::is_unsigned_v<T>)
      return PyFloat_Check(o) ? static_cast<T>(PyFloat_AsDouble(o)) : static_cast<T>(PyLong_AsUnsignedLongLongMask(o));
    else
      return static_cast<T>(PyFloat_Check(o) ? static_cast<long long>(PyFloat_AsDouble(o)) : PyLong_AsLongLong(o));
  }
};
#define LIBGZ_FROM(type, expression) \
  template <> \
  struct From<type> \
  { \
    static type f(PyObject *o) { return expression; } \
  };
LIBGZ_FROM(std::string, text_of(o))
math::Vector3d vector_of(PyObject *object);
LIBGZ_FROM(math::Vector3d, vector_of(o))
LIBGZ_FROM(math::Vector2d, math::Vector2d(number_at(o, "x"), number_at(o, "y")))
LIBGZ_FROM(math::Vector2i, math::Vector2i(int(number_at(o, "x")), int(number_at(o, "y"))))
math::Quaterniond rotation_of(PyObject *object);
LIBGZ_FROM(math::Quaterniond, rotation_of(o))
LIBGZ_FROM(math::Pose3d, math::Pose3d(vector_of(got(o, "pos").get()), rotation_of(got(o, "rot").get())))
LIBGZ_FROM(math::Color, math::Color(number_at(o, "r"), number_at(o, "g"), number_at(o, "b"), number_at(o, "a")))
LIBGZ_FROM(math::Angle, math::Angle(number_of(o)))
LIBGZ_FROM(math::AxisAlignedBox, math::AxisAlignedBox(vector_of(got(o, "min").get()), vector_of(got(o, "max").get())))
std::vector<double> numbers_of(PyObject *object);
math::Matrix3d matrix3_of(PyObject *object);
math::Matrix4d matrix4_of(PyObject *object);
math::Inertiald inertial_of(PyObject *object);
LIBGZ_FROM(math::Matrix3d, matrix3_of(o))
LIBGZ_FROM(math::Matrix4d, matrix4_of(o))
LIBGZ_FROM(math::Inertiald, inertial_of(o))
LIBGZ_FROM(gazebo::common::Time, time_of(o))
gazebo::common::PID pid_of(PyObject *object);
LIBGZ_FROM(gazebo::common::PID, pid_of(o))
LIBGZ_FROM(sdf::ElementPtr, element_of(o))
gazebo::physics::JointWrench wrench_of(PyObject *object);
LIBGZ_FROM(gazebo::physics::JointWrench, wrench_of(o))
LIBGZ_FROM(gazebo::physics::Contact, contact_of(o))
LIBGZ_FROM(gazebo::event::ConnectionPtr, connection_of(o))
LIBGZ_FROM(boost::any, any_of(o))
LIBGZ_FROM(const unsigned char *, bytes_of(o))
template <>
struct From<unsigned char *>
{
  static unsigned char *f(PyObject *o) { return const_cast<unsigned char *>(bytes_of(o)); }
};
template <>
struct From<const float *>
{
  static const float *f(PyObject *o) { return reinterpret_cast<const float *>(bytes_of(o)); }
};
template <>
struct From<float *>
{
  static float *f(PyObject *o) { return reinterpret_cast<float *>(const_cast<unsigned char *>(bytes_of(o))); }
};
gazebo::common::UpdateInfo info_of(PyObject *object);
LIBGZ_FROM(gazebo::common::UpdateInfo, info_of(o))
template <class T>
T *pointer_of(PyObject *o)
{
  if (o == Py_None)
    return nullptr;
  T *found = dynamic_cast<T *>(wrap(o).boosted.get());
  if (found == nullptr)
    unsupported(std::string("a ") + Py_TYPE(o)->tp_name + " in place of a " + typeid(T).name());
  return found;
}
template <class T>
struct From<T *, std::enable_if_t<is_object<std::remove_const_t<T>>>>
{
  static T *f(PyObject *o) { return pointer_of<std::remove_const_t<T>>(o); }
};
template <class T>
struct From<boost::shared_ptr<T>, std::enable_if_t<is_object<std::remove_const_t<T>>>>
{
  static boost::shared_ptr<T> f(PyObject *o)
  {
    return o == Py_None ? boost::shared_ptr<T>() : boost::dynamic_pointer_cast<T>(wrap(o).boosted);
  }
};
template <class T>
struct From<std::shared_ptr<T>, std::enable_if_t<is_object<std::remove_const_t<T>>>>
{
  static std::shared_ptr<T> f(PyObject *o)
  {
    return o == Py_None ? std::shared_ptr<T>() : std::dynamic_pointer_cast<T>(wrap(o).standard);
  }
};
template <class T>
struct From<T &, std::enable_if_t<is_object<T>>>
{
  static T &f(PyObject *o)
  {
    T *found = pointer_of<T>(o);
    if (found == nullptr)
      unsupported("nothing in place of an object");
    return *found;
  }
};
template <class T>
struct From<T, std::enable_if_t<is_object<T>>>
{
  static T f(PyObject *o)
  {
    Py_INCREF(o);
    return T(Adopt{o});
  }
};
template <class T>
struct From<T, std::enable_if_t<is_message<T>>>
{
  static T f(PyObject *o)
  {
    T message;
    message_of(o, message);
    return message;
  }
};
template <class L>
L list_of(PyObject *o)
{
  using T = typename L::value_type;
  L list;
  Ref items(PySequence_Fast(o, "libgz expected a list"));
  if (!items)
    raise_python();
  for (Py_ssize_t i = 0; i < PySequence_Fast_GET_SIZE(items.get()); ++i)
    list.insert(list.end(), From<T>::f(PySequence_Fast_GET_ITEM(items.get(), i)));
  return list;
}
template <class T>
struct From<std::vector<T>>
{
  static std::vector<T> f(PyObject *o) { return list_of<std::vector<T>>(o); }
};
template <class T>
struct From<std::list<T>>
{
  static std::list<T> f(PyObject *o) { return list_of<std::list<T>>(o); }
};
template <class T>
struct From<std::set<T>>
{
  static std::set<T> f(PyObject *o) { return list_of<std::set<T>>(o); }
};
template <class... T>
struct From<std::tuple<T...>>
{
  static std::tuple<T...> f(PyObject *o)
  {
    if (!PyTuple_Check(o) || PyTuple_GET_SIZE(o) != sizeof...(T))
      unsupported("a " + std::string(Py_TYPE(o)->tp_name) + " in place of several results");
    return At(o, std::index_sequence_for<T...>());
  }

 private:
  template <std::size_t... I>
  static std::tuple<T...> At(PyObject *o, std::index_sequence<I...>)
  {
    return {From<T>::f(PyTuple_GET_ITEM(o, I))...};
  }
};
template <class K, class T>
struct From<std::map<K, T>>
{
  static std::map<K, T> f(PyObject *o)
  {
    std::map<K, T> map;
    Ref items(PyMapping_Items(o));
    if (!items)
      raise_python();
    for (Py_ssize_t i = 0; i < PyList_GET_SIZE(items.get()); ++i)
    {
      PyObject *pair = PyList_GET_ITEM(items.get(), i);
      map.insert({From<K>::f(PyTuple_GET_ITEM(pair, 0)), From<T>::f(PyTuple_GET_ITEM(pair, 1))});
    }
    return map;
  }
};

// Functions of C++ as callables of Python -----------------------------------------------------------------------------

template <class T>
using Plain = std::remove_const_t<std::remove_reference_t<T>>;
template <class R, class... A, std::size_t... I>
PyObject *apply(const std::function<R(A...)> &function, [[maybe_unused]] PyObject *const *args, std::index_sequence<I...>)
{
  std::tuple<Plain<A>...> values{From<Plain<A>>::f(args[I])...};
  if (PyErr_Occurred())
    raise_python();
  if constexpr (std::is_void_v<R>)
  {
    Unlocked unlocked;
    function(std::get<I>(values)...);
  }
  else
  {
    auto result = [&] {
      Unlocked unlocked;
      return function(std::get<I>(values)...);
    }();
    return to(result);
  }
  Py_RETURN_NONE;
}
template <class R, class... A>
struct To<std::function<R(A...)>>
{
  static PyObject *f(const std::function<R(A...)> &function)
  {
    return callable(
        [function](PyObject *const *args) { return apply(function, args, std::index_sequence_for<A...>()); },
        sizeof...(A));
  }
};
template <class R, class... A>
struct To<boost::function<R(A...)>>
{
  static PyObject *f(const boost::function<R(A...)> &function) { return to(std::function<R(A...)>(function)); }
};

// Calls ---------------------------------------------------------------------------------------------------------------

/* Counts the pointers to objects in a value: those that objects keep for each other must not keep the world alive. */
inline void count_inner(const Object *object, int by)
{
  if (object != nullptr)
    object->inner += by;
}
template <class T>
void count_all(const T &value, int by)
{
  (void) value;
  (void) by;
}
template <class T>
void count_all(const boost::shared_ptr<T> &value, int by)
{
  if constexpr (is_object<std::remove_const_t<T>>)
    count_inner(value.get(), by);
}
template <class T>
void count_all(const std::shared_ptr<T> &value, int by)
{
  if constexpr (is_object<std::remove_const_t<T>>)
    count_inner(value.get(), by);
}
template <class T>
void count_all(const std::vector<T> &values, int by)
{
  for (const auto &value : values)
    count_all(value, by);
}
template <class K, class T>
void count_all(const std::map<K, T> &values, int by)
{
  for (const auto &pair : values)
    count_all(pair.second, by);
}
/* A result that an object keeps, because its method returns a reference. */
template <class R>
struct Kept
{
  R value{};
  Kept() = default;
  Kept(const Kept &) = delete;
  ~Kept() { count_all(this->value, -1); }
  void Set(R &&other)
  {
    count_all(other, 1);
    std::swap(this->value, other);
    count_all(other, -1);
  }
};

/* Whether == of a type says that values are the same; that of ignition-math allows for 1e-3. */
template <class T>
struct is_exact : std::is_arithmetic<T>
{
};
template <>
struct is_exact<std::string> : std::true_type
{
};
template <class T>
struct is_exact<std::shared_ptr<T>> : std::true_type
{
};
template <class T>
struct is_exact<boost::shared_ptr<T>> : std::true_type
{
};
template <class T>
struct is_exact<std::vector<T>> : is_exact<T>
{
};
template <class T>
struct is_exact<std::list<T>> : is_exact<T>
{
};
template <class K, class V>
struct is_exact<std::map<K, V>> : std::conjunction<is_exact<K>, is_exact<V>>
{
};

/* One call of a method of Python: arguments go in by <<. */
class Call
{
 public:
  Call(const Object *self, const char *name);
  Call(const char *space, const char *owner, const char *name);  // of a class, or of a module if owner is null
  Call(const Call &) = delete;
  ~Call();
  template <class T>
  Call &operator<<(const T &value)
  {
    PyObject *made = to(value);
    if (made == nullptr)
      raise_python();
    this->arguments[this->count++] = made;
    return *this;
  }
  void run();
  PyObject *get() const { return this->returned; }
  template <class R>
  R result()
  {
    this->run();
    return this->taken<R>();
  }
  /* What the call has returned. */
  template <class R>
  R taken()
  {
    R value = From<R>::f(this->returned);
    if (PyErr_Occurred())
      raise_python();
    return value;
  }
  /* A result that is a reference: it lives as long as the object, and stays as it is while it has the same value. */
  template <class R>
  const R &kept()
  {
    return this->Keep<R>(this->result<R>());
  }
  /* What the object keeps under the method's name. */
  template <class T>
  T &slot()
  {
    auto &slot = this->Slot();
    if (slot.first != &typeid(T))
      slot = {&typeid(T), std::make_shared<T>()};
    return *static_cast<T *>(slot.second.get());
  }
  /* Takes what a method changed in a message that it was given. */
  template <class T>
  void back(int number, T &value)
  {
    if constexpr (is_message<T>)
      message_of(this->arguments[number + 1], value);
  }

 private:
  template <class R>
  const R &Keep(R &&value)
  {
    Kept<R> &kept = this->slot<Kept<R>>();
    if constexpr (is_exact<R>::value)
    {
      if (kept.value == value)
        return kept.value;
    }
    kept.Set(std::move(value));
    return kept.value;
  }
  std::pair<const std::type_info *, std::shared_ptr<void>> &Slot();

  Gil gil;
  const Object *self;
  const char *name;
  PyObject *function = nullptr;  // of a class or module
  PyObject *arguments[12] = {};
  int count = 1;
  PyObject *returned = nullptr;
};

/* Results in parameters: Python returns them, several as a tuple; None where there are none. */
template <class... T>
bool give(Call &call, T &...results)
{
  call.run();
  if (call.get() == Py_None)
    return false;
  if constexpr (sizeof...(T) == 1)
    ((results = call.taken<T>()), ...);
  else
    std::tie(results...) = call.taken<std::tuple<T...>>();
  return true;
}
/* The same of methods that return whether there are results: what libgz refuses is no result, too. */
bool refused(const PythonError &error);
template <class... T>
bool try_give(Call &call, T &...results)
{
  try
  {
    return give(call, results...);
  }
  catch (const PythonError &error)
  {
    if (refused(error))
      return false;
    throw;
  }
}

template <class... A>
Adopt construct(const char *space, const char *owner, const A &...values)
{
  Gil gil;
  PyObject *made[] = {nullptr, to(values)...};
  PyObject *kind = attribute((std::string("libgz.classic.") + space).c_str(), owner);
  PyObject *object = PyObject_Vectorcall(kind, made + 1, sizeof...(A) | PY_VECTORCALL_ARGUMENTS_OFFSET, nullptr);
  for (std::size_t i = 1; i <= sizeof...(A); ++i)
    Py_DECREF(made[i]);
  if (object == nullptr)
    raise_python();
  return Adopt{object};
}
template <class R, class... A>
R call_function(const char *module, const char *name, const A &...values)
{
  Call call(module, nullptr, name);
  (call << ... << values);
  if constexpr (std::is_void_v<R>)
    call.run();
  else
    return call.result<R>();
}
}  // namespace libgz
#endif
