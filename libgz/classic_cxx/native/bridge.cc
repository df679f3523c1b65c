// Objects, conversions, calls of Python, and calls of plugins. License: Apache License 2.0.
#include "bridge.hh"

#include <cxxabi.h>
#include <google/protobuf/descriptor.pb.h>
#include <time.h>

#include "gazebo/libgz/frame.h"

namespace libgz {
using namespace gazebo;

// Python's end: objects at file scope and threads may outlive it.
static bool alive()
{
#if PY_VERSION_HEX >= 0x030D0000
  return Py_IsInitialized() && !Py_IsFinalizing();
#else
  return Py_IsInitialized() && !_Py_IsFinalizing();
#endif
}

// What runs --------------------------------------------------------------------------------------------------------

static libgz_frame **(*frames)() = nullptr;  // of libgz's message after a crash
extern thread_local const void *locked;      // hot.cc

/* A plugin as far as its calls and callbacks need it: they keep its shared object in memory. */
struct Context
{
  Context(const char *label, PyObject *shared) : label(label), shared(shared) { Py_INCREF(shared); }
  Context(const Context &) = delete;
  ~Context()
  {
    if (alive())
    {
      Gil gil;
      Py_DECREF(this->shared);
    }
  }
  std::string label;
  PyObject *shared;
  // Of its world, once it is loaded.
  mutable const void *clock = nullptr;
  mutable std::string world;
};
using Plugin = std::shared_ptr<const Context>;

/* Marks what runs of which plugin; which world its thread holds is asked anew. */
class Frame
{
 public:
  Frame(const char *method, Plugin plugin)
  {
    locked = nullptr;
    this->before = current();
    current() = plugin;
    this->plugin = std::move(plugin);
    if (frames == nullptr)
      return;
    libgz_frame **top = frames();
    this->frame = {*top, method, this->plugin ? this->plugin->label.c_str() : "a plugin", 0};
    *top = &this->frame;
  }
  ~Frame()
  {
    locked = nullptr;
    current() = this->before;
    if (frames != nullptr)
      *frames() = this->frame.below;
  }
  static Plugin &current()
  {
    static thread_local Plugin plugin;
    return plugin;
  }

 private:
  Plugin before, plugin;
  libgz_frame frame = {};
};

// Objects ----------------------------------------------------------------------------------------------------------

using Slots = std::unordered_map<const char *, std::pair<const std::type_info *, std::shared_ptr<void>>>;

Object::Object(Adopt adopted) : view(adopted.view) {}
void attach_row(Object *object);  // hot.cc
void drop_row(void *row);
common::UpdateInfo info_at(const void *clock, const std::string &world);

Object::Object(const Object &other) : view(other.view)
{
  Gil gil;
  Py_XINCREF(static_cast<PyObject *>(this->view));
}
Object &Object::operator=(const Object &other)
{
  if (this->view != other.view)
  {
    Gil gil;
    Py_XINCREF(static_cast<PyObject *>(other.view));
    Py_XDECREF(static_cast<PyObject *>(std::exchange(this->view, other.view)));
    drop_row(std::exchange(this->row, nullptr));
  }
  return *this;
}
Object::~Object()
{
  delete static_cast<Slots *>(this->kept);
  if (this->view != nullptr && alive())
  {
    Gil gil;
    drop_row(this->row);
    Py_DECREF(static_cast<PyObject *>(this->view));
  }
}

/* What a view keeps in its dictionary: its C++ object. As long as a pointer of C++ refers to that, Python's collector
 * takes the view to be in use; otherwise both are collected together.
 */
struct Handle
{
  PyObject_HEAD
  Holder *holder;
};
static bool used(const Holder &holder)
{
  // One of the two pointers owns the other's object: they count each other once.
  return holder.boosted.use_count() + holder.standard.use_count() - holder.boosted->inner > 3;
}
static int handle_traverse(PyObject *self, visitproc visit, void *arg)
{
  Py_VISIT(Py_TYPE(self));
  Holder *holder = reinterpret_cast<Handle *>(self)->holder;
  if (holder != nullptr && holder->boosted && !used(*holder))
    Py_VISIT(static_cast<PyObject *>(holder->boosted->view));
  return 0;
}
static int handle_clear(PyObject *self)
{
  delete std::exchange(reinterpret_cast<Handle *>(self)->holder, nullptr);
  return 0;
}
static void handle_dealloc(PyObject *self)
{
  PyTypeObject *type = Py_TYPE(self);
  PyObject_GC_UnTrack(self);
  handle_clear(self);
  type->tp_free(self);
  Py_DECREF(type);
}
static PyTypeObject *handle_type()
{
  static PyType_Slot slots[] = {{Py_tp_traverse, reinterpret_cast<void *>(handle_traverse)},
      {Py_tp_clear, reinterpret_cast<void *>(handle_clear)},
      {Py_tp_dealloc, reinterpret_cast<void *>(handle_dealloc)}, {0, nullptr}};
  static PyType_Spec spec = {"libgz.classic_cxx.Handle", sizeof(Handle), 0,
      Py_TPFLAGS_DEFAULT | Py_TPFLAGS_HAVE_GC | Py_TPFLAGS_DISALLOW_INSTANTIATION, slots};
  static PyTypeObject *type = reinterpret_cast<PyTypeObject *>(PyType_FromSpec(&spec));
  return type;
}

/* The package of a class of libgz.classic, before its name: "physics.Light". */
static std::string qualified(PyTypeObject *type, const std::string &name)
{
  static const std::string root = "libgz.classic.";
  PyObject *module = PyObject_GetAttrString(reinterpret_cast<PyObject *>(type), "__module__");
  const char *text = module && PyUnicode_Check(module) ? PyUnicode_AsUTF8(module) : nullptr;
  std::string package = text ? text : "";
  Py_XDECREF(module);
  PyErr_Clear();
  if (package.compare(0, root.size(), root) != 0)
    return name;
  package = package.substr(root.size());
  return package.substr(0, package.find('.')) + "." + name;
}

static Holder made(PyObject *view)
{
  static const Makers makers = [] {
    Makers all;
    add_makers(all);
    return all;
  }();
  static std::unordered_map<PyTypeObject *, Makers::const_iterator> known;
  PyTypeObject *type = Py_TYPE(view);
  auto found = known.find(type);
  if (found == known.end())
  {
    auto maker = makers.end();
    PyObject *mro = type->tp_mro;
    for (Py_ssize_t i = 0; i < PyTuple_GET_SIZE(mro) && maker == makers.end(); ++i)
    {
      PyTypeObject *one = reinterpret_cast<PyTypeObject *>(PyTuple_GET_ITEM(mro, i));
      const char *dot = std::strrchr(one->tp_name, '.');
      const std::string name = dot ? dot + 1 : one->tp_name;
      maker = makers.find(qualified(one, name));
      maker = maker == makers.end() ? makers.find(name) : maker;
    }
    found = known.emplace(type, maker).first;
    Py_INCREF(type);
  }
  if (found->second == makers.end())
    unsupported(std::string("objects of Python's class ") + type->tp_name);
  Holder holder = found->second->second(view);
  attach_row(holder.boosted.get());
  return holder;
}

/* The object of a view that has no dictionary. */
static Holder wrap_slotted(PyObject *view)
{
  static std::unordered_map<PyObject *, Holder> all;
  static std::size_t most = 1024;
  auto known = all.find(view);
  if (known != all.end())
    return known->second;
  if (all.size() >= most)
  {
    std::vector<Holder> ended;  // their ends change no map
    for (auto one = all.begin(); one != all.end();)
    {
      const bool free = !used(one->second) && Py_REFCNT(one->first) == 1;
      if (free)
        ended.push_back(one->second);
      one = free ? all.erase(one) : std::next(one);
    }
    most = std::max<std::size_t>(1024, 2 * all.size());
  }
  return all[view] = made(view);
}
static PyObject *holder_key()
{
  static PyObject *key = PyUnicode_InternFromString("_cxx");
  return key;
}
void keep(PyObject *view, const Holder &holder)
{
  Ref own(PyObject_GenericGetDict(view, nullptr));
  if (!own)
    raise_python();
  Handle *handle = PyObject_GC_New(Handle, handle_type());
  handle->holder = new Holder(holder);
  PyObject_GC_Track(reinterpret_cast<PyObject *>(handle));
  PyDict_SetItem(own.get(), holder_key(), reinterpret_cast<PyObject *>(handle));
  Py_DECREF(handle);
}
Holder wrap(PyObject *view)
{
  Ref own(PyObject_GenericGetDict(view, nullptr));
  if (!own)
  {
    PyErr_Clear();
    return wrap_slotted(view);
  }
  PyObject *known = PyDict_GetItemWithError(own.get(), holder_key());
  if (known != nullptr && Py_TYPE(known) == handle_type() && reinterpret_cast<Handle *>(known)->holder != nullptr)
    return *reinterpret_cast<Handle *>(known)->holder;
  Holder holder = made(view);
  keep(view, holder);
  return holder;
}

// Errors -----------------------------------------------------------------------------------------------------------

void PythonError::Drop(PyObject *error)
{
  if (error != nullptr && alive())
  {
    Gil gil;
    Py_DECREF(error);
  }
}
void raise_python()
{
  PyObject *type, *value, *traceback;
  PyErr_Fetch(&type, &value, &traceback);
  PyErr_NormalizeException(&type, &value, &traceback);
  if (type == nullptr)
    throw PythonError("a function of libgz failed", nullptr);
  std::string text = reinterpret_cast<PyTypeObject *>(type)->tp_name;
  const std::size_t dot = text.rfind('.');
  text = text.substr(dot == std::string::npos ? 0 : dot + 1);
  Ref words(value ? PyObject_Str(value) : nullptr);
  const char *utf8 = words ? PyUnicode_AsUTF8(words.get()) : nullptr;
  if (utf8 != nullptr && *utf8)
    text += std::string(": ") + utf8;
  PyErr_Clear();
  Py_XDECREF(type);
  Py_XDECREF(traceback);
  throw PythonError(text, value);
}
void unsupported(const std::string &what)
{
  throw PythonError("libgz's C++ API of Gazebo does not have " + what, nullptr);
}

static std::string demangled(const char *name)
{
  int status = 0;
  char *plain = abi::__cxa_demangle(name, nullptr, nullptr, &status);
  std::string text = plain ? plain : name;
  std::free(plain);
  return text;
}

/* What an exception says, as one line: plugins throw null pointers, several lines and megabytes. */
static std::string as_line(const char *text)
{
  const std::size_t most = 2000;
  if (text == nullptr)
    return "(it says nothing)";
  std::string line(text, strnlen(text, most));
  if (text[line.size()] != '\0')
    line += " ...";
  boost::trim(line);
  std::replace_if(line.begin(), line.end(), [](unsigned char one) { return one < ' ' || one == 127; }, ' ');
  return line;
}

bool refused(const PythonError &error)
{
  return error.get() != nullptr &&
         PyErr_GivenExceptionMatches(error.get(), attribute("libgz.base.errors", "GazeboError"));
}

/* Turns what user code threw into an exception of Python. */
static void set_error()
{
  PyObject *kind = attribute("libgz.base.errors", "PluginError");
  try
  {
    throw;
  }
  catch (const PythonError &error)
  {
    PyObject *cause = error.get();
    if (cause != nullptr && !PyErr_GivenExceptionMatches(cause, PyExc_Exception))  // an interrupt
    {
      PyErr_SetObject(reinterpret_cast<PyObject *>(Py_TYPE(cause)), cause);
      return;
    }
    PyErr_SetString(kind, error.what());
  }
  catch (const common::Exception &error)
  {
    PyErr_Format(kind, "it threw gazebo::common::Exception at %s: %s", error.GetErrorFile().c_str(),
        as_line(error.GetErrorStr().c_str()).c_str());
  }
  catch (const std::exception &error)
  {
    PyErr_Format(kind, "it threw %s: %s", demangled(typeid(error).name()).c_str(),
        as_line(error.what()).c_str());
  }
  catch (const std::string &text)
  {
    PyErr_Format(kind, "it threw the text %s", as_line(text.c_str()).c_str());
  }
  catch (const char *text)
  {
    PyErr_Format(kind, "it threw the text %s", as_line(text).c_str());
  }
  catch (...)
  {
    const std::type_info *type = abi::__cxa_current_exception_type();
    PyErr_Format(kind, "it threw %s", type ? demangled(type->name()).c_str() : "something unknown");
  }
}

// Calls ------------------------------------------------------------------------------------------------------------

PyObject *interned(const char *name)
{
  static std::unordered_map<const char *, std::pair<std::string, PyObject *>> all;
  std::pair<std::string, PyObject *> &known = all[name];
  if (known.second == nullptr || known.first != name)  // a plugin's text may lie where that of an unloaded one was
    known = {name, PyUnicode_InternFromString(name)};
  return known.second;
}
PyObject *attribute(const char *module, const char *name)
{
  static std::map<std::pair<std::string, std::string>, PyObject *> all;
  PyObject *&found = all[{module, name}];
  if (found == nullptr)
  {
    Ref imported(PyImport_ImportModule(module));
    if (!imported)
      raise_python();
    found = PyObject_GetAttrString(imported.get(), name);
    if (found == nullptr)
      raise_python();
  }
  return found;
}

Call::Call(const Object *object, const char *name) : self(object), name(name)
{
  if (object == nullptr)
    throw PythonError(std::string("a null pointer: ") + name + " was called on it", nullptr);
  this->arguments[0] = static_cast<PyObject *>(object->view);
  Py_INCREF(this->arguments[0]);
}
Call::Call(const char *space, const char *owner, const char *name) : self(nullptr), name(name)
{
  if (owner == nullptr)
  {
    this->function = attribute(space, name);
    Py_INCREF(this->function);
  }
  else
  {
    const std::string module = std::string("libgz.classic.") + space;
    this->function = PyObject_GetAttr(attribute(module.c_str(), owner), interned(name));
    if (this->function == nullptr)
      raise_python();
  }
}
Call::~Call()
{
  for (int i = 0; i < this->count; ++i)
    Py_XDECREF(this->arguments[i]);
  Py_XDECREF(this->returned);
  Py_XDECREF(this->function);
}
void Call::run()
{
  if (this->self != nullptr)
    this->returned = PyObject_VectorcallMethod(interned(this->name), this->arguments, this->count, nullptr);
  else
    this->returned = PyObject_Vectorcall(
        this->function, this->arguments + 1, (this->count - 1) | PY_VECTORCALL_ARGUMENTS_OFFSET, nullptr);
  if (this->returned == nullptr)
    raise_python();
}
std::pair<const std::type_info *, std::shared_ptr<void>> &Call::Slot()
{
  static Slots shared;  // of functions of classes
  if (this->self == nullptr)
    return shared[this->name];
  if (this->self->kept == nullptr)
    this->self->kept = new Slots;
  return (*static_cast<Slots *>(this->self->kept))[this->name];
}

// The client ---------------------------------------------------------------------------------------------------------

void load_element(void *element, const std::function<void(sdf::ElementPtr)> &load)
{
  sdf::ElementPtr sdf = element_of(static_cast<PyObject *>(element));
  Unlocked unlocked;
  load(sdf);
}

// Values -----------------------------------------------------------------------------------------------------------

PyObject *build(const char *name, std::initializer_list<double> values)
{
  static std::unordered_map<const char *, PyObject *> kinds;
  PyObject *&kind = kinds[name];
  if (kind == nullptr)
    kind = attribute("libgz.classic.math", name);
  PyObject *made[18] = {};
  int count = 1;
  const bool whole = !std::strcmp(name, "Vector2i");
  for (double value : values)
    made[count++] = whole ? PyLong_FromDouble(value) : PyFloat_FromDouble(value);
  PyObject *object = PyObject_Vectorcall(kind, made + 1, (count - 1) | PY_VECTORCALL_ARGUMENTS_OFFSET, nullptr);
  for (int i = 1; i < count; ++i)
    Py_DECREF(made[i]);
  return object;
}
PyObject *text_py(const std::string &text)
{
  return PyUnicode_DecodeUTF8(text.data(), text.size(), "surrogateescape");
}
std::string text_of(PyObject *object)
{
  if (object == Py_None)
    return "";
  if (PyBytes_Check(object))
    return std::string(PyBytes_AS_STRING(object), PyBytes_GET_SIZE(object));
  Ref text(PyUnicode_Check(object) ? Py_NewRef(object) : PyObject_Str(object));
  Ref bytes(text ? PyUnicode_AsEncodedString(text.get(), "utf-8", "surrogateescape") : nullptr);
  if (!bytes)
    raise_python();
  return std::string(PyBytes_AS_STRING(bytes.get()), PyBytes_GET_SIZE(bytes.get()));
}
double number_of(PyObject *object)
{
  if (object == Py_None)
    return 0.0;
  const double number = PyFloat_AsDouble(object);
  if (number == -1.0 && PyErr_Occurred())
    raise_python();
  return number;
}
Ref got(PyObject *object, const char *name)
{
  Ref value(PyObject_GetAttr(object, interned(name)));
  if (!value)
    raise_python();
  return value;
}
double number_at(PyObject *object, const char *name) { return number_of(got(object, name).get()); }
math::Vector3d vector_of(PyObject *o) { return {number_at(o, "x"), number_at(o, "y"), number_at(o, "z")}; }
math::Quaterniond rotation_of(PyObject *o)
{
  return {number_at(o, "u"), number_at(o, "x"), number_at(o, "y"), number_at(o, "z")};
}
static Ref helped(const char *name, PyObject *object)
{
  Ref value(PyObject_CallOneArg(attribute("libgz.classic_cxx.values", name), object));
  if (!value)
    raise_python();
  return value;
}
std::vector<double> numbers_of(PyObject *object) { return list_of<std::vector<double>>(object); }
math::Matrix3d matrix3_of(PyObject *object)
{
  const std::vector<double> v = numbers_of(helped("matrix_numbers", object).get());
  return {v.at(0), v.at(1), v.at(2), v.at(3), v.at(4), v.at(5), v.at(6), v.at(7), v.at(8)};
}
math::Matrix4d matrix4_of(PyObject *object)
{
  const std::vector<double> v = numbers_of(helped("matrix_numbers", object).get());
  return {v.at(0), v.at(1), v.at(2), v.at(3), v.at(4), v.at(5), v.at(6), v.at(7), v.at(8), v.at(9), v.at(10),
      v.at(11), v.at(12), v.at(13), v.at(14), v.at(15)};
}
math::Inertiald inertial_of(PyObject *object)
{
  const std::vector<double> v = numbers_of(helped("inertial_numbers", object).get());
  return math::Inertiald(math::MassMatrix3d(v.at(0), {v.at(1), v.at(2), v.at(3)}, {v.at(4), v.at(5), v.at(6)}),
      math::Pose3d(v.at(7), v.at(8), v.at(9), v.at(10), v.at(11), v.at(12), v.at(13)));
}
PyObject *inertial_py(const math::Inertiald &value)
{
  const auto &mass = value.MassMatrix();
  const auto &pose = value.Pose();
  const std::vector<double> numbers = {mass.Mass(), mass.Ixx(), mass.Iyy(), mass.Izz(), mass.Ixy(), mass.Ixz(),
      mass.Iyz(), pose.Pos().X(), pose.Pos().Y(), pose.Pos().Z(), pose.Rot().W(), pose.Rot().X(), pose.Rot().Y(),
      pose.Rot().Z()};
  return helped("inertial_from", Ref(to(numbers)).get()).release();
}
PyObject *construct_time(const common::Time &time)
{
  return PyObject_CallFunction(attribute("libgz.classic.common", "Time"), "ii", time.sec, time.nsec);
}
common::Time time_of(PyObject *object)
{
  if (PyFloat_Check(object) || PyLong_Check(object))
    return common::Time(PyFloat_AsDouble(object));
  common::Time time;
  time.sec = static_cast<int32_t>(PyLong_AsLong(got(object, "sec").get()));
  time.nsec = static_cast<int32_t>(PyLong_AsLong(got(object, "nsec").get()));
  return time;
}
common::PID pid_of(PyObject *o)
{
  return common::PID(number_at(o, "pGain"), number_at(o, "iGain"), number_at(o, "dGain"), number_at(o, "iMax"),
      number_at(o, "iMin"), number_at(o, "cmdMax"), number_at(o, "cmdMin"));
}
physics::JointWrench wrench_of(PyObject *object)
{
  physics::JointWrench wrench;
  wrench.body1Force = vector_of(got(object, "body1Force").get());
  wrench.body2Force = vector_of(got(object, "body2Force").get());
  wrench.body1Torque = vector_of(got(object, "body1Torque").get());
  wrench.body2Torque = vector_of(got(object, "body2Torque").get());
  return wrench;
}
physics::Contact contact_of(PyObject *object)
{
  physics::Contact contact;
  contact.collision1 = pointer_of<physics::Collision>(got(object, "collision1").get());
  contact.collision2 = pointer_of<physics::Collision>(got(object, "collision2").get());
  const auto positions = list_of<std::vector<math::Vector3d>>(got(object, "positions").get());
  const auto normals = list_of<std::vector<math::Vector3d>>(got(object, "normals").get());
  const auto depths = list_of<std::vector<double>>(got(object, "depths").get());
  Ref wrenches = got(object, "wrench");
  Ref all(PySequence_Fast(wrenches.get(), "wrenches"));
  contact.count = static_cast<int>(std::min<std::size_t>(positions.size(), MAX_CONTACT_JOINTS));
  for (int i = 0; i < contact.count; ++i)
  {
    contact.positions[i] = positions[i];
    contact.normals[i] = normals.at(i);
    contact.depths[i] = depths.at(i);
    if (all && i < PySequence_Fast_GET_SIZE(all.get()))
      contact.wrench[i] = wrench_of(PySequence_Fast_GET_ITEM(all.get(), i));
  }
  contact.time = time_of(got(object, "time").get());
  contact.world = From<physics::WorldPtr>::f(got(object, "world").get());
  return contact;
}
common::UpdateInfo info_of(PyObject *object)
{
  common::UpdateInfo info;
  info.worldName = text_of(got(object, "worldName").get());
  info.simTime = time_of(got(object, "simTime").get());
  info.realTime = time_of(got(object, "realTime").get());
  return info;
}
const unsigned char *bytes_of(PyObject *object)
{
  if (object == Py_None)
    return nullptr;
  Py_buffer buffer;
  if (PyObject_GetBuffer(object, &buffer, PyBUF_SIMPLE) != 0)
    raise_python();
  const void *bytes = buffer.buf;
  PyBuffer_Release(&buffer);
  return static_cast<const unsigned char *>(bytes);
}
PyObject *any_py(const boost::any &value)
{
#define LIBGZ_ANY(type) \
  if (const type *found = boost::any_cast<type>(&value)) \
    return to(*found);
  LIBGZ_ANY(double)
  LIBGZ_ANY(float)
  LIBGZ_ANY(int)
  LIBGZ_ANY(unsigned int)
  LIBGZ_ANY(long)
  LIBGZ_ANY(bool)
  LIBGZ_ANY(std::string)
  LIBGZ_ANY(math::Vector3d)
  if (const char *const *found = boost::any_cast<const char *>(&value))
    return text_py(*found);
  unsupported("values of type " + demangled(value.type().name()) + " in a boost::any");
}
#undef LIBGZ_ANY
boost::any any_of(PyObject *object)
{
  if (PyBool_Check(object))
    return object == Py_True;
  if (PyLong_Check(object))
    return static_cast<int>(PyLong_AsLong(object));
  if (PyFloat_Check(object))
    return PyFloat_AsDouble(object);
  if (PyUnicode_Check(object))
    return text_of(object);
  return vector_of(object);
}

PyObject *trajectory_py(const physics::TrajectoryInfo &info)
{
  return PyObject_CallFunction(attribute("libgz.classic_cxx.values", "trajectory_from"), "IsdddO", info.id,
      info.type.c_str(), info.duration, info.startTime, info.endTime, info.translated ? Py_True : Py_False);
}

// Elements of SDF ----------------------------------------------------------------------------------------------------

sdf::ElementPtr element_of(PyObject *element)
{
  if (element == Py_None)
    return nullptr;
  Ref pair = helped("element_text", element);
  const std::string name = text_of(PyTuple_GET_ITEM(pair.get(), 0));
  static std::map<std::string, sdf::ElementPtr> schemas;
  const bool quiet = sdf::Console::Instance() != nullptr;
  if (quiet)
    sdf::Console::Instance()->SetQuiet(true);
  auto known = schemas.find(name);
  if (known == schemas.end())
  {
    sdf::ElementPtr schema(new sdf::Element);
    if (!sdf::initFile(name + ".sdf", schema))
      schema->SetName(name);
    known = schemas.emplace(name, schema).first;
  }
  sdf::ElementPtr made = known->second->Clone();
  sdf::readString(text_of(PyTuple_GET_ITEM(pair.get(), 1)), made);
  if (quiet)
    sdf::Console::Instance()->SetQuiet(false);
  return made;
}
PyObject *element_py(const sdf::ElementPtr &element)
{
  if (!element)
    Py_RETURN_NONE;
  return helped("element_from", Ref(text_py(element->ToString(""))).get()).release();
}
PyObject *sdf_py(const sdf::SDF &text) { return text_py(text.ToString()); }

// Messages -----------------------------------------------------------------------------------------------------------

PyObject *message_type(const google::protobuf::Message &message)
{
  using namespace google::protobuf;
  static std::unordered_map<const Descriptor *, PyObject *> all;
  const Descriptor *kind = message.GetDescriptor();
  auto known = all.find(kind);
  if (known != all.end())
    return known->second;
  Ref files(PyList_New(0));
  std::set<const FileDescriptor *> seen;
  std::function<void(const FileDescriptor *)> add = [&](const FileDescriptor *file) {
    if (!seen.insert(file).second)
      return;
    for (int i = 0; i < file->dependency_count(); ++i)
      add(file->dependency(i));
    FileDescriptorProto text;
    file->CopyTo(&text);
    const std::string bytes = text.SerializeAsString();
    PyList_Append(files.get(), Ref(PyBytes_FromStringAndSize(bytes.data(), bytes.size())).get());
  };
  add(kind->file());
  PyObject *found = PyObject_CallFunction(attribute("libgz.classic_cxx.values", "message_type_of"), "sO",
      kind->full_name().c_str(), files.get());
  if (found == nullptr)
    raise_python();
  if (google::protobuf::DescriptorPool::generated_pool() == kind->file()->pool())
    all[kind] = found;  // that pool and its kinds never end; those of other pools do
  return found;
}
PyObject *message_py(const google::protobuf::Message &message)
{
  const std::string bytes = message.SerializePartialAsString();
  Ref data(PyBytes_FromStringAndSize(bytes.data(), bytes.size()));
  return PyObject_CallMethodOneArg(message_type(message), interned("FromString"), data.get());
}
void message_of(PyObject *object, google::protobuf::Message &message)
{
  Ref bytes(PyObject_CallMethodNoArgs(object, interned("SerializePartialToString")));
  if (!bytes)
    raise_python();
  message.ParsePartialFromArray(PyBytes_AS_STRING(bytes.get()), static_cast<int>(PyBytes_GET_SIZE(bytes.get())));
}

// Callables ------------------------------------------------------------------------------------------------------------

namespace {
struct Callback
{
  Plugin plugin;  // destroyed last: the function's code is in its shared object
  Function function;
  const char *what;
};
thread_local const char *connecting = "a callback";
PyObject *invoke(PyObject *self, PyObject *const *args, Py_ssize_t)
{
  auto *callback = static_cast<Callback *>(PyCapsule_GetPointer(self, nullptr));
  Frame frame(callback->what, callback->plugin);
  try
  {
    return callback->function(args);
  }
  catch (...)
  {
    set_error();
  }
  return nullptr;
}
void drop(PyObject *capsule) { delete static_cast<Callback *>(PyCapsule_GetPointer(capsule, nullptr)); }
// Python asks a callback how many arguments it takes.
PyMethodDef methods[] = {
    {"cxx", reinterpret_cast<PyCFunction>(invoke), METH_FASTCALL, "cxx($self, /)\n--\n\n"},
    {"cxx", reinterpret_cast<PyCFunction>(invoke), METH_FASTCALL, "cxx($self, a, /)\n--\n\n"},
    {"cxx", reinterpret_cast<PyCFunction>(invoke), METH_FASTCALL, "cxx($self, a, b, /)\n--\n\n"},
    {"cxx", reinterpret_cast<PyCFunction>(invoke), METH_FASTCALL, "cxx($self, a, b, c, /)\n--\n\n"},
    {"cxx", reinterpret_cast<PyCFunction>(invoke), METH_FASTCALL, "cxx($self, a, b, c, d, /)\n--\n\n"},
    {"cxx", reinterpret_cast<PyCFunction>(invoke), METH_FASTCALL, "cxx($self, a, b, c, d, e, /)\n--\n\n"},
    {"cxx", reinterpret_cast<PyCFunction>(invoke), METH_FASTCALL, "cxx($self, a, b, c, d, e, f, /)\n--\n\n"}};
}  // namespace

PyObject *callable(Function function, int count)
{
  Ref capsule(PyCapsule_New(new Callback{Frame::current(), std::move(function), connecting}, nullptr, drop));
  return PyCFunction_New(&methods[count], capsule.get());
}
event::ConnectionPtr connection_of(PyObject *connection)
{
  Py_INCREF(connection);
  return event::ConnectionPtr(new event::Connection([connection] {
    if (!alive())
      return;
    Gil gil;
    Ref done(PyObject_CallMethodNoArgs(connection, interned("disconnect")));
    if (!done)
      PyErr_Clear();
    Py_DECREF(connection);
  }));
}

/* Names what is connected in the marks of what runs. */
struct Connecting
{
  const char *before = std::exchange(connecting, nullptr);
  explicit Connecting(const char *what) { connecting = what; }
  ~Connecting() { connecting = this->before; }
};
template <class F>
static event::ConnectionPtr connect_event(const char *event, const F &callback)
{
  Gil gil;
  static auto &texts = *new std::map<std::string, std::string>;  // which a message after exit() reads
  std::string &text = texts[event];
  text = std::string("a callback of event ") + event;
  Connecting named(text.c_str());
  Ref made(to(callback));
  Ref connection(PyObject_CallFunction(attribute("libgz.classic_cxx.values", "connect"), "sO", event, made.get()));
  if (!connection)
    raise_python();
  return connection_of(connection.get());
}
template <class... A>
static void signal_event(const char *event, const A &...values)
{
  Call call("libgz.classic_cxx.values", nullptr, "signal");
  call << event;
  (call << ... << values);
  call.run();
}
void say_parameter(const std::string &plugin, const std::string &name, const std::string &value, bool found)
{
  if (found)
    gzmsg << plugin << " Plugin <" << name << "> set to <" << value << ">" << std::endl;
  else
    gzmsg << plugin << " Plugin missing <" << name << ">, defaults to <" << value << ">" << std::endl;
}
}  // namespace libgz

namespace gazebo {
namespace event {
void Connection::End()
{
  const std::unique_ptr<std::function<void()>> ending(this->end);
  this->end = nullptr;
  if (ending && *ending)
    (*ending)();
}
ConnectionPtr connect(const char *event, std::function<void(const common::UpdateInfo &)> callback)
{
  const libgz::Plugin &plugin = libgz::Frame::current();
  if (!plugin || plugin->clock == nullptr)
    return libgz::connect_event(event, callback);
  // Without an argument: Python makes none then.
  const libgz::Context *own = plugin.get();
  return libgz::connect_event(
      event, std::function<void()>([callback, own] { callback(libgz::info_at(own->clock, own->world)); }));
}
#define LIBGZ_CONNECT(...) \
  ConnectionPtr connect(const char *event, std::function<__VA_ARGS__> callback) \
  { \
    return libgz::connect_event(event, callback); \
  }
LIBGZ_CONNECT(void())
LIBGZ_CONNECT(void(std::string))
LIBGZ_CONNECT(void(bool))
LIBGZ_CONNECT(void(int))
LIBGZ_CONNECT(void(std::string, std::string))
LIBGZ_CONNECT(void(const msgs::Model &))
LIBGZ_CONNECT(void(const msgs::Light &))
LIBGZ_CONNECT(void(const std::string &, const ignition::math::Vector3d &))
LIBGZ_CONNECT(void(const std::string &, const ignition::math::Pose3d &, const bool))
LIBGZ_CONNECT(void(std::string, std::string, std::string, bool, bool))
LIBGZ_CONNECT(void(sdf::ElementPtr, const std::string &, const std::string &, const uint32_t))
#undef LIBGZ_CONNECT
void signal(const char *event) { libgz::signal_event(event); }
void signal(const char *event, bool value) { libgz::signal_event(event, value); }
void signal(const char *event, int value) { libgz::signal_event(event, value); }
void signal(const char *event, const std::string &value) { libgz::signal_event(event, value); }
void signal(const char *event, const std::string &one, const std::string &two)
{
  libgz::signal_event(event, one, two);
}
void signal(const char *event, const msgs::Model &value) { libgz::signal_event(event, value); }
void signal(const char *event, const msgs::Light &value) { libgz::signal_event(event, value); }
void signal(const char *event, const std::string &name, const ignition::math::Vector3d &value)
{
  libgz::signal_event(event, name, value);
}
void signal(const char *event, const std::string &name, const ignition::math::Pose3d &pose, bool value)
{
  libgz::signal_event(event, name, pose, value);
}
void signal(const char *event, const std::string &one, const std::string &two, const std::string &three, bool a, bool b)
{
  libgz::signal_event(event, one, two, three, a, b);
}
void signal(const char *event, const common::UpdateInfo &info)
{
  libgz::signal_event(event, info.worldName, info.simTime, info.realTime);
}
#define LIBGZ_EVENT(Name, name, type) WorldEvent<type> Events::name(#Name);
LIBGZ_EVENTS
#undef LIBGZ_EVENT
}  // namespace event

/* Notes which world's clock a plugin sees. */
static void note_world(void *holder)
{
  const libgz::Plugin &plugin = libgz::Frame::current();
  libgz::Ref found(PyObject_CallOneArg(
      libgz::attribute("libgz.classic_cxx.rows", "clock_of"), static_cast<PyObject *>(holder)));
  if (!found)
    libgz::raise_python();
  plugin->clock = PyLong_AsVoidPtr(PyTuple_GET_ITEM(found.get(), 0));
  plugin->world = libgz::text_of(PyTuple_GET_ITEM(found.get(), 1));
}
void WorldPlugin::LibgzLoad(void *holder, void *element)
{
  note_world(holder);
  auto world = libgz::From<physics::WorldPtr>::f(static_cast<PyObject *>(holder));
  auto sdf = libgz::element_of(static_cast<PyObject *>(element));
  libgz::Unlocked unlocked;
  this->Load(world, sdf);
}
void ModelPlugin::LibgzLoad(void *holder, void *element)
{
  note_world(holder);
  auto model = libgz::From<physics::ModelPtr>::f(static_cast<PyObject *>(holder));
  auto sdf = libgz::element_of(static_cast<PyObject *>(element));
  libgz::Unlocked unlocked;
  this->Load(model, sdf);
}
void SensorPlugin::LibgzLoad(void *holder, void *element)
{
  note_world(holder);
  auto sensor = libgz::From<sensors::SensorPtr>::f(static_cast<PyObject *>(holder));
  auto sdf = libgz::element_of(static_cast<PyObject *>(element));
  libgz::Unlocked unlocked;
  this->Load(sensor, sdf);
}
void VisualPlugin::LibgzLoad(void *holder, void *element)
{
  auto visual = libgz::From<rendering::VisualPtr>::f(static_cast<PyObject *>(holder));
  auto sdf = libgz::element_of(static_cast<PyObject *>(element));
  libgz::Unlocked unlocked;
  this->Load(visual, sdf);
}
void SystemPlugin::LibgzLoad(void *, void *arguments)
{
  // Plugins may keep pointers to the command line, as in a program.
  auto *words = new std::vector<std::string>(
      libgz::list_of<std::vector<std::string>>(static_cast<PyObject *>(arguments)));
  auto *pointers = new std::vector<char *>;
  for (std::string &word : *words)
    pointers->push_back(&word[0]);
  pointers->push_back(nullptr);
  libgz::Unlocked unlocked;
  this->Load(static_cast<int>(words->size()), pointers->data());
}
}  // namespace gazebo

// What boost calls where a condition of its own fails, such as that a pointer is not null.
namespace boost {
void assertion_failed(char const *expression, char const *function, char const *file, long line)
{
  const std::string place = function;
  const std::size_t start = place.find("T = ");
  if (start != std::string::npos && std::string(expression).find("px") == 0)
    throw std::runtime_error("a null pointer was used: one to a " +
                             place.substr(start + 4, place.find_first_of(";]", start) - start - 4));
  throw std::runtime_error(std::string(expression) + " does not hold in " + place + " (" + file + ":" +
                           std::to_string(line) + ")");
}
void assertion_failed_msg(char const *expression, char const *text, char const *function, char const *, long)
{
  throw std::runtime_error(std::string(text) + ": " + expression + " does not hold in " + function);
}
}  // namespace boost

// What Python calls, by ctypes.PyDLL: with its lock; exceptions are set -------------------------------------------------

struct LibgzPlugin
{
  libgz::PluginRoot *plugin;
  libgz::Plugin context;
};
namespace libgz {
std::shared_ptr<const void> running_plugin() { return Frame::current(); }
PluginRoot *root_of(void *plugin) { return static_cast<LibgzPlugin *>(plugin)->plugin; }
void run_as(const std::shared_ptr<const void> &plugin, const char *what, const std::function<void()> &code)
{
  Frame frame(what, std::static_pointer_cast<const Context>(plugin));
  code();
}
std::shared_ptr<const void> context_of(void *plugin) { return static_cast<LibgzPlugin *>(plugin)->context; }
PyObject *caught()
{
  set_error();
  PyObject *type, *value, *traceback;
  PyErr_Fetch(&type, &value, &traceback);
  PyErr_NormalizeException(&type, &value, &traceback);
  Py_XDECREF(type);
  Py_XDECREF(traceback);
  return value;
}
}  // namespace libgz

extern "C" {
enum { LIBGZ_INIT, LIBGZ_RESET, LIBGZ_DELETE };
void libgz_start(void *frames) { libgz::frames = reinterpret_cast<libgz_frame **(*) ()>(frames); }
void *libgz_create(void *function, const char *file, const char *name, const char *label, PyObject *shared)
{
  auto plugin = std::make_unique<LibgzPlugin>();
  plugin->context = std::make_shared<const libgz::Context>(label, shared);
  libgz::Frame frame("the constructor", plugin->context);
  try
  {
    libgz::Unlocked unlocked;
    plugin->plugin = reinterpret_cast<libgz::PluginRoot *(*) ()>(function)();
    if (plugin->plugin == nullptr)
      throw libgz::PythonError("its RegisterPlugin returned no plugin", nullptr);
    plugin->plugin->filename = file;
    plugin->plugin->handleName = name;
  }
  catch (...)
  {
    libgz::set_error();
    return nullptr;
  }
  return plugin.release();
}
void libgz_load(void *plugin, PyObject *holder, PyObject *element)
{
  auto *one = static_cast<LibgzPlugin *>(plugin);
  libgz::Frame frame("Load", one->context);
  try
  {
    one->plugin->LibgzLoad(holder, element);
  }
  catch (...)
  {
    libgz::set_error();
  }
}
void libgz_call(void *plugin, int what)
{
  auto *one = static_cast<LibgzPlugin *>(plugin);
  static const char *const names[] = {"Init", "Reset", "the destructor"};
  libgz::Frame frame(names[what], one->context);
  try
  {
    libgz::Unlocked unlocked;
    if (what == LIBGZ_INIT)
      one->plugin->LibgzInit();
    else if (what == LIBGZ_RESET)
      one->plugin->LibgzReset();
    else
    {
      libgz::drop_filters(one->context.get());
      delete std::exchange(one->plugin, nullptr);
    }
  }
  catch (...)
  {
    libgz::set_error();
  }
  if (what == LIBGZ_DELETE)
    delete one;
}
}
