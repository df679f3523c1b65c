/* Namespaces gazebo::common and gazebo::event: what is plain C++. License: Apache License 2.0. */
#ifndef LIBGZ_COMMON_HH
#define LIBGZ_COMMON_HH
#include "gazebo/libgz/base.hh"

/* Base of what exists once: MyClass::Instance(). */
template <class T>
class SingletonT
{
 public:
  static T *Instance()
  {
    static T one;
    return &one;
  }

 protected:
  SingletonT() {}
  virtual ~SingletonT() {}
};
#define GZ_SINGLETON_DECLARE(visibility, n1, n2, name)

void Base64Encode(const char *bytes, unsigned int length, std::string &result);
std::string Base64Decode(const std::string &text);

#define GZ_SEC_TO_HOUR(seconds) ((seconds) / 3600.0)

namespace gazebo {
namespace msgs {
class Light;
class Model;
}  // namespace msgs
namespace common {

/* Seconds and nanoseconds; both have one sign. */
class GAZEBO_VISIBLE Time
{
 public:
  enum FormatOption { DAYS = 0, HOURS = 1, MINUTES = 2, SECONDS = 3, MILLISECONDS = 4 };
  static const Time Zero, Second, Hour;
  static const int32_t nsInSec = 1000000000, nsInMs = 1000000;

  Time() = default;
  Time(const Time &other) = default;
  Time(const struct timeval &t) : sec(t.tv_sec), nsec(t.tv_usec * 1000) {}
  Time(const struct timespec &t) : sec(t.tv_sec), nsec(t.tv_nsec) {}
  Time(int32_t seconds, int32_t nanoseconds) : sec(seconds), nsec(nanoseconds) { this->Correct(); }
  Time(double seconds) { this->Set(seconds); }

  static Time Maximum() { return Time(std::numeric_limits<int32_t>::max(), nsInSec - 1); }
  static const Time &GetWallTime();
  static const std::string &GetWallTimeAsISOString();
  void SetToWallTime() { *this = GetWallTime(); }
  void Set(int32_t seconds, int32_t nanoseconds) { *this = Time(seconds, nanoseconds); }
  void Set(double seconds)
  {
    this->sec = static_cast<int32_t>(std::floor(seconds));
    this->nsec = static_cast<int32_t>(std::rint((seconds - this->sec) * nsInSec));
    this->Correct();
  }
  double Double() const { return this->sec + this->nsec * 1e-9; }
  float Float() const { return static_cast<float>(this->Double()); }
  std::string FormattedString(FormatOption start = DAYS, FormatOption end = MILLISECONDS) const;
  static Time Sleep(const Time &time);
  static Time MSleep(unsigned int milliseconds) { return Sleep(Time(milliseconds * 1e-3)); }
  static Time NSleep(unsigned int nanoseconds) { return Sleep(Time(0, nanoseconds)); }
  static double SecToNano(double seconds) { return seconds * 1e-9; }
  static double MilToNano(double milliseconds) { return milliseconds * 1e-6; }
  static double MicToNano(double microseconds) { return microseconds * 1e-3; }

  Time &operator=(const Time &other) = default;
  Time &operator=(const struct timeval &t) { return *this = Time(t); }
  Time &operator=(const struct timespec &t) { return *this = Time(t); }
  Time operator+(const Time &t) const { return Time(this->sec + t.sec, this->nsec + t.nsec); }
  Time operator-(const Time &t) const { return Time(this->sec - t.sec, this->nsec - t.nsec); }
  Time operator*(const Time &t) const { return Time(this->Double() * t.Double()); }
  Time operator/(const Time &t) const { return Time(this->Double() / t.Double()); }
  const Time &operator+=(const Time &t) { return *this = *this + t; }
  const Time &operator-=(const Time &t) { return *this = *this - t; }
  const Time &operator*=(const Time &t) { return *this = *this * t; }
  const Time &operator/=(const Time &t) { return *this = *this / t; }
  bool operator==(const Time &t) const { return this->sec == t.sec && this->nsec == t.nsec; }
  bool operator!=(const Time &t) const { return !(*this == t); }
  bool operator<(const Time &t) const { return this->sec < t.sec || (this->sec == t.sec && this->nsec < t.nsec); }
  bool operator<=(const Time &t) const { return !(t < *this); }
  bool operator>(const Time &t) const { return t < *this; }
  bool operator>=(const Time &t) const { return !(*this < t); }
  // Beside those of timeval and timespec, which are converted, classic compares with numbers.
  bool operator==(double t) const { return *this == Time(t); }
  bool operator!=(double t) const { return *this != Time(t); }
  bool operator<(double t) const { return *this < Time(t); }
  bool operator<=(double t) const { return *this <= Time(t); }
  bool operator>(double t) const { return *this > Time(t); }
  bool operator>=(double t) const { return *this >= Time(t); }
  friend std::ostream &operator<<(std::ostream &out, const Time &t) { return out << t.sec << " " << t.nsec; }
  friend std::istream &operator>>(std::istream &in, Time &t)
  {
    in.setf(std::ios_base::skipws);
    return in >> t.sec >> t.nsec;
  }

  int32_t sec = 0, nsec = 0;

 private:
  void Correct()
  {
    if (this->sec > 0 && this->nsec < 0)
    {
      int32_t n = std::abs(this->nsec / nsInSec) + 1;
      this->sec -= n;
      this->nsec += n * nsInSec;
    }
    if (this->sec < 0 && this->nsec > 0)
    {
      int32_t n = std::abs(this->nsec / nsInSec) + 1;
      this->sec += n;
      this->nsec -= n * nsInSec;
    }
    this->sec += this->nsec / nsInSec;
    this->nsec = this->nsec % nsInSec;
  }
};

class GAZEBO_VISIBLE UpdateInfo
{
 public:
  std::string worldName;
  Time simTime, realTime;
};

/* A stopwatch of wall time, or a countdown. */
class GAZEBO_VISIBLE Timer
{
 public:
  Timer() {}
  Timer(const Time &most, const bool countdown = true) : reset(true), countdown(countdown), most(most) {}
  virtual ~Timer() {}
  virtual void Start()
  {
    if (this->reset)
      this->start = Time::GetWallTime();
    this->running = true;
    this->reset = false;
  }
  virtual void Stop()
  {
    this->stop = Time::GetWallTime();
    this->running = false;
  }
  bool GetRunning() const { return this->running; }
  Time GetElapsed() const
  {
    Time gone = this->reset ? Time() : (this->running ? Time::GetWallTime() : this->stop) - this->start;
    if (!this->countdown)
      return gone;
    return gone > this->most ? Time() : this->most - gone;
  }
  void Reset()
  {
    this->running = false;
    this->reset = true;
  }
  friend std::ostream &operator<<(std::ostream &out, const Timer &t) { return out << t.GetElapsed(); }

 private:
  bool reset = true, running = false, countdown = false;
  Time start, stop, most;
};

/* A PID controller; the error is the state minus its target, as in classic. */
class GAZEBO_VISIBLE PID
{
 public:
  PID(double p = 0.0, double i = 0.0, double d = 0.0, double imax = 0.0, double imin = 0.0, double cmdMax = -1.0,
      double cmdMin = 0.0)
  {
    this->Init(p, i, d, imax, imin, cmdMax, cmdMin);
  }
  virtual ~PID() {}
  void Init(double p = 0.0, double i = 0.0, double d = 0.0, double imax = 0.0, double imin = 0.0,
      double cmdMax = -1.0, double cmdMin = 0.0);
  void SetPGain(double value) { this->p = value; }
  void SetIGain(double value) { this->i = value; }
  void SetDGain(double value) { this->d = value; }
  void SetIMax(double value) { this->imax = value; }
  void SetIMin(double value) { this->imin = value; }
  void SetCmdMax(double value) { this->most = value; }
  void SetCmdMin(double value) { this->least = value; }
  double GetPGain() const { return this->p; }
  double GetIGain() const { return this->i; }
  double GetDGain() const { return this->d; }
  double GetIMax() const { return this->imax; }
  double GetIMin() const { return this->imin; }
  double GetCmdMax() const { return this->most; }
  double GetCmdMin() const { return this->least; }
  double Update(double error, Time dt);
  void SetCmd(double value) { this->cmd = value; }
  double GetCmd() { return this->cmd; }
  void GetErrors(double &pe, double &ie, double &de)
  {
    pe = this->pErr;
    ie = this->iErr;
    de = this->dErr;
  }
  void Reset();

 private:
  double pErrLast, pErr, iErr, dErr, p, i, d, imax, imin, cmd, most, least;
};

class GAZEBO_VISIBLE Exception
{
 public:
  Exception() {}
  Exception(const char *file, int line, std::string text);
  virtual ~Exception() {}
  std::string GetErrorFile() const { return this->file; }
  std::string GetErrorStr() const { return this->text; }
  void Print() const;
  friend std::ostream &operator<<(std::ostream &out, const Exception &error)
  {
    return out << error.GetErrorStr();
  }

 private:
  std::string file, text;
  int64_t line = 0;
};
class GAZEBO_VISIBLE InternalError : public Exception
{
 public:
  InternalError() {}
  InternalError(const char *file, int line, const std::string text) : Exception(file, line, text) {}
};
class GAZEBO_VISIBLE AssertionInternalError : public InternalError
{
 public:
  AssertionInternalError(const char *file, int line, const std::string expression, const std::string function,
      const std::string text = "")
      : InternalError(file, line, function + ": assertion " + expression + " failed: " + text)
  {
  }
};
#define gzthrow(text) \
  { \
    std::ostringstream libgz_text; \
    libgz_text << text << std::endl << std::flush; \
    throw gazebo::common::Exception(__FILE__, __LINE__, libgz_text.str()); \
  }
// Classic aborts here; so only the plugin ends.
#define GZ_ASSERT(condition, text) \
  if (!(condition)) \
    throw gazebo::common::AssertionInternalError(__FILE__, __LINE__, #condition, __func__, text)

/* A stream whose lines go to the console and the log, as those of Python plugins. */
class GAZEBO_VISIBLE Logger : public std::ostream
{
 public:
  enum LogType { STDOUT = 0, STDERR = 1 };
  Logger(const std::string &prefix, int color, LogType type);
  ~Logger() override;
  Logger &operator()();
  Logger &operator()(const std::string &file, int line);

 private:
  struct Lines;
  Lines *lines;
};
class GAZEBO_VISIBLE FileLogger : public std::ostream
{
 public:
  FileLogger(const std::string &file = "");
  ~FileLogger() override;
  void Init(const std::string &prefix, const std::string &file);
  FileLogger &operator()();
  FileLogger &operator()(const std::string &file, int line);
  std::string GetLogDirectory() const;

 private:
  Logger own;
};
class GAZEBO_VISIBLE Console
{
 public:
  static void SetQuiet(bool quiet);
  static bool GetQuiet();
  static Logger msg, err, dbg, warn;
  static FileLogger log;
};
#define gzmsg (gazebo::common::Console::msg())
#define gzdbg (gazebo::common::Console::dbg(__FILE__, __LINE__))
#define gzwarn (gazebo::common::Console::warn(__FILE__, __LINE__))
#define gzerr (gazebo::common::Console::err(__FILE__, __LINE__))
#define gzlog (gazebo::common::Console::log())
#define gzLogInit(prefix, name) (gazebo::common::Console::log.Init(prefix, name))
#define gzLogDirectory() (gazebo::common::Console::log.GetLogDirectory())

/* The mean of the last values. */
template <typename T>
class MovingWindowFilter
{
 public:
  MovingWindowFilter() : size(4) {}
  virtual ~MovingWindowFilter() {}
  void Update(T value)
  {
    this->values.push_back(value);
    if (this->values.size() > this->size)
      this->values.pop_front();
  }
  void SetWindowSize(unsigned int n)
  {
    this->size = n;
    this->values.clear();
  }
  unsigned int GetWindowSize() const { return this->size; }
  bool GetWindowFilled() const { return this->values.size() == this->size; }
  T Get()
  {
    T sum = T();
    for (const T &value : this->values)
      sum = sum + value;
    return this->values.empty() ? sum : T(sum / static_cast<double>(this->values.size()));
  }

 private:
  unsigned int size;
  std::deque<T> values;
};

/* A version as 1.2.3-alpha+build. */
class GAZEBO_VISIBLE SemanticVersion
{
 public:
  SemanticVersion() {}
  explicit SemanticVersion(const std::string &text) { this->Parse(text); }
  explicit SemanticVersion(const unsigned int major, const unsigned int minor = 0, const unsigned int patch = 0,
      const std::string &prerelease = "", const std::string &build = "")
      : numbers{major, minor, patch}, pre(prerelease), meta(build)
  {
  }
  bool Parse(const std::string &text);
  std::string Version() const;
  unsigned int Major() const { return this->numbers[0]; }
  unsigned int Minor() const { return this->numbers[1]; }
  unsigned int Patch() const { return this->numbers[2]; }
  std::string Prerelease() const { return this->pre; }
  std::string Build() const { return this->meta; }
  bool operator<(const SemanticVersion &o) const;
  bool operator==(const SemanticVersion &o) const { return this->numbers == o.numbers && this->pre == o.pre; }
  bool operator!=(const SemanticVersion &o) const { return !(*this == o); }
  bool operator<=(const SemanticVersion &o) const { return !(o < *this); }
  bool operator>(const SemanticVersion &o) const { return o < *this; }
  bool operator>=(const SemanticVersion &o) const { return !(*this < o); }

 private:
  std::vector<unsigned int> numbers = {0, 0, 0};
  std::string pre, meta;
};

class GAZEBO_VISIBLE KeyEvent
{
 public:
  enum EventType { NO_EVENT = 0, PRESS = 1, RELEASE = 2 };
  EventType type = NO_EVENT;
  int key = 0;
  std::string text;
  bool control = false, shift = false, alt = false;
};
class GAZEBO_VISIBLE MouseEvent
{
 public:
  enum MouseButton { NO_BUTTON = 0, LEFT = 1, MIDDLE = 2, RIGHT = 4 };
  enum EventType { NO_EVENT = 0, MOVE = 1, PRESS = 2, RELEASE = 3, SCROLL = 4 };
  ignition::math::Vector2i Pos() const { return this->pos; }
  void SetPos(const ignition::math::Vector2i &v) { this->pos = v; }
  void SetPos(const int x, const int y) { this->pos.Set(x, y); }
  ignition::math::Vector2i PrevPos() const { return this->prev; }
  void SetPrevPos(const ignition::math::Vector2i &v) { this->prev = v; }
  void SetPrevPos(const int x, const int y) { this->prev.Set(x, y); }
  ignition::math::Vector2i PressPos() const { return this->press; }
  void SetPressPos(const ignition::math::Vector2i &v) { this->press = v; }
  void SetPressPos(const int x, const int y) { this->press.Set(x, y); }
  ignition::math::Vector2i Scroll() const { return this->scroll; }
  void SetScroll(const ignition::math::Vector2i &v) { this->scroll = v; }
  void SetScroll(const int x, const int y) { this->scroll.Set(x, y); }
  float MoveScale() const { return this->scale; }
  void SetMoveScale(const float v) { this->scale = v; }
  bool Dragging() const { return this->dragging; }
  void SetDragging(const bool v) { this->dragging = v; }
  EventType Type() const { return this->type; }
  void SetType(const EventType v) const { this->type = v; }
  MouseButton Button() const { return this->button; }
  void SetButton(const MouseButton v) const { this->button = v; }
  unsigned int Buttons() const { return this->buttons; }
  void SetButtons(const unsigned int &v) { this->buttons = v; }
  bool Shift() const { return this->shift; }
  void SetShift(const bool v) const { this->shift = v; }
  bool Alt() const { return this->alt; }
  void SetAlt(const bool v) { this->alt = v; }
  bool Control() const { return this->control; }
  void SetControl(const bool v) const { this->control = v; }

 private:
  ignition::math::Vector2i pos, prev, press, scroll;
  float scale = 0.01f;
  unsigned int buttons = 0;
  bool dragging = false, alt = false;
  mutable bool shift = false, control = false;
  mutable EventType type = NO_EVENT;
  mutable MouseButton button = NO_BUTTON;
};

typedef std::map<std::string, std::string> StrStr_M;

/* A function that does nothing once an object is gone. */
template <class F, class P>
std::function<void()> weakBind(F function, const std::shared_ptr<P> &object)
{
  std::weak_ptr<P> weak = object;
  return [function, weak] {
    if (auto alive = weak.lock())
      ((*alive).*function)();
  };
}

void load();
void add_search_path_suffix(const std::string &suffix);
std::string find_file(const std::string &file);
std::string find_file(const std::string &file, bool searchLocalPath);
std::string find_file_path(const std::string &file);
const char *getEnv(const char *name);
std::string cwd();
bool exists(const std::string &path);
bool isDirectory(const std::string &path);
bool isFile(const std::string &path);
std::string absPath(const std::string &path);
bool copyFile(const std::string &from, const std::string &to);
bool copyDir(const boost::filesystem::path &from, const boost::filesystem::path &to);
bool moveFile(const std::string &from, const std::string &to);
void replaceAll(std::string &result, const std::string &text, const std::string &from, const std::string &to);
std::string replaceAll(const std::string &text, const std::string &from, const std::string &to);
std::vector<std::string> split(const std::string &text, const std::string &delimiter);
std::string unique_file_path(const std::string &base, const std::string &extension);
std::string asFullPath(const std::string &uri, const std::string &file);
void convertPosesToSdf16(const sdf::ElementPtr &element);
template <typename T>
std::string get_sha1(const T &data);
}  // namespace common

namespace event {

class GAZEBO_VISIBLE Event
{
 public:
  virtual ~Event() {}
  virtual void Disconnect(int id) = 0;
  bool Signaled() const { return this->signaled; }
  void SetSignaled(const bool value) { this->signaled = value; }

 private:
  bool signaled = false;
};

/* What keeps a callback connected: it ends when nothing refers to this any more. Plugins may call its destructor, and
 * the pointer that owns it then calls it once more.
 */
class GAZEBO_VISIBLE Connection
{
 public:
  Connection() : Connection(nullptr) {}
  explicit Connection(std::function<void()> end, int id = 0) : end(new std::function<void()>(std::move(end))), id(id) {}
  Connection(Event *event, const int id) : Connection([event, id] { event->Disconnect(id); }, id) {}
  Connection(const Connection &) = delete;
  Connection &operator=(const Connection &) = delete;
  ~Connection() { this->End(); }
  void End();
  int Id() const { return this->id; }

 private:
  std::function<void()> *volatile end;  // null once it has ended: volatile, so that a destructor's write is kept
  int id;
};
typedef boost::shared_ptr<Connection> ConnectionPtr;
typedef std::vector<ConnectionPtr> Connection_V;
inline void end(const ConnectionPtr &connection)
{
  if (connection)
    connection->End();
}

/* An event of a plugin's own: callbacks that are called together. */
template <typename T>
class EventT : public Event
{
  struct Shared
  {
    std::recursive_mutex mutex;
    std::map<int, std::function<T>> callbacks;
    int next = 0;
  };

 public:
  EventT() : shared(std::make_shared<Shared>()) {}
  virtual ~EventT() {}
  ConnectionPtr Connect(const std::function<T> &callback)
  {
    std::lock_guard<std::recursive_mutex> hold(this->shared->mutex);
    const int id = this->shared->next++;
    this->shared->callbacks[id] = callback;
    std::weak_ptr<Shared> weak = this->shared;
    return ConnectionPtr(new Connection(
        [weak, id] {
          if (auto alive = weak.lock())
          {
            std::lock_guard<std::recursive_mutex> hold(alive->mutex);
            alive->callbacks.erase(id);
          }
        },
        id));
  }
  void Disconnect(int id) override
  {
    std::lock_guard<std::recursive_mutex> hold(this->shared->mutex);
    this->shared->callbacks.erase(id);
  }
  void Disconnect(ConnectionPtr connection)
  {
    if (connection)
      this->Disconnect(connection->Id());
  }
  unsigned int ConnectionCount() const
  {
    std::lock_guard<std::recursive_mutex> hold(this->shared->mutex);
    return this->shared->callbacks.size();
  }
  template <typename... A>
  void Signal(A &&...values)
  {
    this->SetSignaled(true);
    std::vector<int> ids;
    auto all = this->shared;
    std::lock_guard<std::recursive_mutex> hold(all->mutex);
    for (const auto &one : all->callbacks)
      ids.push_back(one.first);
    for (int id : ids)
    {
      auto found = all->callbacks.find(id);  // an earlier one may have ended it
      if (found != all->callbacks.end())
      {
        auto callback = found->second;
        callback(values...);
      }
    }
  }
  template <typename... A>
  void operator()(A &&...values)
  {
    this->Signal(std::forward<A>(values)...);
  }

 private:
  std::shared_ptr<Shared> shared;
};

/* Connects a callback to an event of the world, by its name. */
ConnectionPtr connect(const char *event, std::function<void(const common::UpdateInfo &)> callback);
ConnectionPtr connect(const char *event, std::function<void()> callback);
ConnectionPtr connect(const char *event, std::function<void(std::string)> callback);
ConnectionPtr connect(const char *event, std::function<void(bool)> callback);
ConnectionPtr connect(const char *event, std::function<void(std::string, std::string)> callback);
ConnectionPtr connect(const char *event,
    std::function<void(sdf::ElementPtr, const std::string &, const std::string &, const uint32_t)> callback);
ConnectionPtr connect(const char *event, std::function<void(int)> callback);
ConnectionPtr connect(const char *event, std::function<void(const msgs::Model &)> callback);
ConnectionPtr connect(const char *event, std::function<void(const msgs::Light &)> callback);
ConnectionPtr connect(
    const char *event, std::function<void(const std::string &, const ignition::math::Vector3d &)> callback);
ConnectionPtr connect(
    const char *event, std::function<void(const std::string &, const ignition::math::Pose3d &, const bool)> callback);
ConnectionPtr connect(
    const char *event, std::function<void(std::string, std::string, std::string, bool, bool)> callback);
void signal(const char *event);
void signal(const char *event, bool value);
void signal(const char *event, int value);
void signal(const char *event, const msgs::Model &value);
void signal(const char *event, const msgs::Light &value);
void signal(const char *event, const std::string &name, const ignition::math::Vector3d &value);
void signal(const char *event, const std::string &name, const ignition::math::Pose3d &pose, bool value);
void signal(const char *event, const std::string &one, const std::string &two, const std::string &three, bool a, bool b);
void signal(const char *event, const std::string &value);
void signal(const char *event, const std::string &one, const std::string &two);
void signal(const char *event, const common::UpdateInfo &info);

/* An event of the world, as plugins of Python have it. */
template <typename T>
class WorldEvent;
template <typename... A>
class WorldEvent<void(A...)>
{
 public:
  explicit WorldEvent(const char *name) : name(name) {}
  ConnectionPtr Connect(const std::function<void(A...)> &callback) { return connect(this->name, callback); }
  void Disconnect(ConnectionPtr connection) { end(connection); }
  void Signal(A... values) { signal(this->name, values...); }
  void operator()(A... values) { signal(this->name, values...); }

 private:
  const char *name;
};

class GAZEBO_VISIBLE Events
{
 public:
#define LIBGZ_EVENT(Name, name, type) \
  static WorldEvent<type> name; \
  template <typename F> \
  static ConnectionPtr Connect##Name(F callback) \
  { \
    return connect(#Name, std::function<type>(callback)); \
  } \
  static void Disconnect##Name(ConnectionPtr connection) { end(connection); }
#define LIBGZ_EVENTS \
  LIBGZ_EVENT(Pause, pause, void(bool)) \
  LIBGZ_EVENT(Step, step, void()) \
  LIBGZ_EVENT(Stop, stop, void()) \
  LIBGZ_EVENT(SigInt, sigInt, void()) \
  LIBGZ_EVENT(WorldCreated, worldCreated, void(std::string)) \
  LIBGZ_EVENT(CreateEntity, entityCreated, void(std::string)) \
  LIBGZ_EVENT(SetSelectedEntity, setSelectedEntity, void(std::string, std::string)) \
  LIBGZ_EVENT(AddEntity, addEntity, void(std::string)) \
  LIBGZ_EVENT(DeleteEntity, deleteEntity, void(std::string)) \
  LIBGZ_EVENT(WorldUpdateBegin, worldUpdateBegin, void(const common::UpdateInfo &)) \
  LIBGZ_EVENT(BeforePhysicsUpdate, beforePhysicsUpdate, void(const common::UpdateInfo &)) \
  LIBGZ_EVENT(WorldUpdateEnd, worldUpdateEnd, void()) \
  LIBGZ_EVENT(WorldReset, worldReset, void()) \
  LIBGZ_EVENT(TimeReset, timeReset, void()) \
  LIBGZ_EVENT(PreRender, preRender, void()) \
  LIBGZ_EVENT(PreRenderEnded, preRenderEnded, void()) \
  LIBGZ_EVENT(Render, render, void()) \
  LIBGZ_EVENT(PostRender, postRender, void()) \
  LIBGZ_EVENT(DiagTimerStart, diagTimerStart, void(std::string)) \
  LIBGZ_EVENT(DiagTimerStop, diagTimerStop, void(std::string)) \
  LIBGZ_EVENT(RemoveSensor, removeSensor, void(std::string)) \
  LIBGZ_EVENT( \
      CreateSensor, createSensor, void(sdf::ElementPtr, const std::string &, const std::string &, const uint32_t))
  LIBGZ_EVENTS
#undef LIBGZ_EVENT
};
}  // namespace event
}  // namespace gazebo

// sdformat reads elements as the types that it knows.
namespace sdf {
inline namespace SDF_VERSION_NAMESPACE {
template <>
inline gazebo::common::Time Element::Get<gazebo::common::Time>(const std::string &key) const
{
  const sdf::Time found = this->Get<sdf::Time>(key);
  return gazebo::common::Time(found.sec, found.nsec);
}
template <>
inline std::pair<gazebo::common::Time, bool> Element::Get<gazebo::common::Time>(
    const std::string &key, const gazebo::common::Time &otherwise) const
{
  const auto found = this->Get<sdf::Time>(key, sdf::Time(otherwise.sec, otherwise.nsec));
  return {gazebo::common::Time(found.first.sec, found.first.nsec), found.second};
}
}  // namespace SDF_VERSION_NAMESPACE
}  // namespace sdf
#endif
