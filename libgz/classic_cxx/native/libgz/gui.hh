/* The client: its plugins, which are widgets where Qt's headers are found, and what they ask of its window.
 * License: Apache License 2.0.
 */
#ifndef LIBGZ_GUI_HH
#define LIBGZ_GUI_HH
#include "gazebo/libgz/gazebo.hh"

#ifndef Q_MOC_RUN
#if __has_include(<QtWidgets/QtWidgets>)
#define LIBGZ_HAS_QT
#include <QtWidgets/QtWidgets>
#else
#define Q_OBJECT \
  static_assert(sizeof(char) == 0, "plugins with widgets need Qt: apt-get install qtbase5-dev, and name its folders, " \
                                   "in CMakeLists.txt by find_package(Qt5 COMPONENTS Widgets REQUIRED)");
#endif

namespace libgz {
/* Calls a plugin's Load with an element that Python has. */
void load_element(void *element, const std::function<void(sdf::ElementPtr)> &load);
[[noreturn]] void no_window(const char *name);
void pause_world(bool pause);
bool find_property(const std::string &key, std::string &value);
void set_property(const std::string &key, const std::string &value);
}  // namespace libgz

namespace gazebo {
namespace gui {
class MainWindow;
bool load();
void init();
bool run(int argc, char **argv);
void stop();
void set_world(const std::string &name);
std::string get_world();
void set_active_camera(rendering::UserCameraPtr camera);
rendering::UserCameraPtr get_active_camera();
void clear_active_camera();
MainWindow *get_main_window();
unsigned int get_entity_id(const std::string &name);
bool has_entity_name(const std::string &name);
template <typename T>
T getINIProperty(const std::string &key, const T &otherwise)
{
  std::string text;
  T value;
  if (!libgz::find_property(key, text))
    return otherwise;
  if constexpr (std::is_same<T, bool>::value)
  {
    if (text == "true" || text == "false")
      return text == "true";
  }
  return boost::conversion::try_lexical_convert(text, value) ? value : otherwise;
}
template <typename T>
bool setINIProperty(const std::string &key, const T &value)
{
  libgz::set_property(key, boost::lexical_cast<std::string>(value));
  return true;
}

class GAZEBO_VISIBLE Events
{
 public:
#define LIBGZ_GUI_EVENT(Name, name, type) \
  static event::WorldEvent<type> name; \
  template <typename F> \
  static event::ConnectionPtr Connect##Name(F callback) \
  { \
    return event::connect("gui." #Name, std::function<type>(callback)); \
  } \
  static void Disconnect##Name(event::ConnectionPtr connection) { event::end(connection); }
#define LIBGZ_GUI_EVENTS \
  LIBGZ_GUI_EVENT(MainWindowReady, mainWindowReady, void()) \
  LIBGZ_GUI_EVENT(KeyPress, keyPress, void(std::string)) \
  LIBGZ_GUI_EVENT(MoveMode, moveMode, void(bool)) \
  LIBGZ_GUI_EVENT(ManipMode, manipMode, void(std::string)) \
  LIBGZ_GUI_EVENT(FullScreen, fullScreen, void(bool)) \
  LIBGZ_GUI_EVENT(Follow, follow, void(std::string)) \
  LIBGZ_GUI_EVENT(WindowMode, windowMode, void(std::string)) \
  LIBGZ_GUI_EVENT(CreateEntity, createEntity, void(std::string, std::string)) \
  LIBGZ_GUI_EVENT(LeftPaneVisibility, leftPaneVisibility, void(bool)) \
  LIBGZ_GUI_EVENT(ShowToolbars, showToolbars, void(bool)) \
  LIBGZ_GUI_EVENT(FPS, fps, void()) \
  LIBGZ_GUI_EVENT(Orbit, orbit, void()) \
  LIBGZ_GUI_EVENT(EditModel, editModel, void(std::string)) \
  LIBGZ_GUI_EVENT(AlignMode, alignMode, void(std::string, std::string, std::string, bool, bool)) \
  LIBGZ_GUI_EVENT(ModelUpdate, modelUpdate, void(const msgs::Model &)) \
  LIBGZ_GUI_EVENT(LightUpdate, lightUpdate, void(const msgs::Light &)) \
  LIBGZ_GUI_EVENT(InputStepSize, inputStepSize, void(int)) \
  LIBGZ_GUI_EVENT(ScaleEntity, scaleEntity, void(const std::string &, const ignition::math::Vector3d &)) \
  LIBGZ_GUI_EVENT( \
      MoveEntity, moveEntity, void(const std::string &, const ignition::math::Pose3d &, const bool))
  LIBGZ_GUI_EVENTS
#undef LIBGZ_GUI_EVENT
};

/* Functions by names, which are asked one by one what to do with an event until one returns true. They end with the
 * plugin that added them.
 */
template <typename E>
class Filters
{
 public:
  typedef boost::function<bool(const E &event)> Function;
  void Add(const std::string &name, Function function);
  void Remove(const std::string &name);
  bool Handle(const E &event);
  void Drop(const void *plugin);

 private:
  struct One
  {
    std::string name;
    Function function;
    std::shared_ptr<const void> plugin;
  };
  std::list<One> all;
};
class GAZEBO_VISIBLE KeyEventHandler : public SingletonT<KeyEventHandler>
{
 public:
  typedef Filters<common::KeyEvent>::Function KeyEventFilter;
  static KeyEventHandler *Instance();
  void AddPressFilter(const std::string &name, KeyEventFilter filter) { this->press.Add(name, filter); }
  void AddReleaseFilter(const std::string &name, KeyEventFilter filter) { this->release.Add(name, filter); }
  void RemovePressFilter(const std::string &name) { this->press.Remove(name); }
  void RemoveReleaseFilter(const std::string &name) { this->release.Remove(name); }
  bool HandlePress(const common::KeyEvent &event) { return this->press.Handle(event); }
  bool HandleRelease(const common::KeyEvent &event) { return this->release.Handle(event); }
  bool AutoRepeat() const { return this->repeat; }
  void SetAutoRepeat(const bool value) { this->repeat = value; }
  void Drop(const void *plugin);

 private:
  Filters<common::KeyEvent> press, release;
  bool repeat = false;
};
class GAZEBO_VISIBLE MouseEventHandler : public SingletonT<MouseEventHandler>
{
 public:
  typedef Filters<common::MouseEvent>::Function MouseEventFilter;
  static MouseEventHandler *Instance();
  void AddPressFilter(const std::string &name, MouseEventFilter filter) { this->press.Add(name, filter); }
  void AddReleaseFilter(const std::string &name, MouseEventFilter filter) { this->release.Add(name, filter); }
  void AddMoveFilter(const std::string &name, MouseEventFilter filter) { this->move.Add(name, filter); }
  void AddDoubleClickFilter(const std::string &name, MouseEventFilter filter) { this->twice.Add(name, filter); }
  void RemovePressFilter(const std::string &name) { this->press.Remove(name); }
  void RemoveReleaseFilter(const std::string &name) { this->release.Remove(name); }
  void RemoveMoveFilter(const std::string &name) { this->move.Remove(name); }
  void RemoveDoubleClickFilter(const std::string &name) { this->twice.Remove(name); }
  void HandlePress(const common::MouseEvent &event) { this->press.Handle(event); }
  void HandleRelease(const common::MouseEvent &event) { this->release.Handle(event); }
  void HandleMove(const common::MouseEvent &event) { this->move.Handle(event); }
  void HandleDoubleClick(const common::MouseEvent &event) { this->twice.Handle(event); }
  void Drop(const void *plugin);

 private:
  Filters<common::MouseEvent> press, release, move, twice;
};

#ifdef LIBGZ_HAS_QT
/* What lies below the plugins' widgets. */
class GAZEBO_VISIBLE GLWidget : public QWidget
{
 public:
  explicit GLWidget(QWidget *parent = nullptr) : QWidget(parent) {}
  rendering::UserCameraPtr Camera() const { return get_active_camera(); }
  rendering::ScenePtr Scene() const { return rendering::get_scene(); }
  std::vector<rendering::VisualPtr> SelectedVisuals() const { libgz::no_window("GLWidget::SelectedVisuals"); }
};
class GAZEBO_VISIBLE RenderWidget : public QWidget
{
 public:
  explicit RenderWidget(QWidget *parent = nullptr) : QWidget(parent) {}
};
class GAZEBO_VISIBLE MainWindow : public QMainWindow
{
 public:
  gui::RenderWidget *RenderWidget() const { return static_cast<gui::RenderWidget *>(this->centralWidget()); }
  gui::RenderWidget *GetRenderWidget() const { return this->RenderWidget(); }
  void AddMenu(QMenu *menu) { this->menuBar()->addMenu(menu); }
  void AddToLeftColumn(const std::string &name, QWidget *widget)
  {
    if (this->left == nullptr)
    {
      this->left = new QDockWidget(this);
      this->left->setWidget(new QStackedWidget);
      this->addDockWidget(Qt::LeftDockWidgetArea, this->left);
    }
    widget->setObjectName(QString::fromStdString(name));
    static_cast<QStackedWidget *>(this->left->widget())->addWidget(widget);
  }
  void ShowLeftColumnWidget(const std::string &name = "default")
  {
    QWidget *widget = this->left ? this->left->findChild<QWidget *>(QString::fromStdString(name)) : nullptr;
    if (widget != nullptr)
      static_cast<QStackedWidget *>(this->left->widget())->setCurrentWidget(widget);
  }
  void SetLeftPaneVisibility(bool on)
  {
    if (this->left != nullptr)
      this->left->setVisible(on);
  }
  void Play() { libgz::pause_world(false); }
  void Pause() { libgz::pause_world(true); }
  bool IsPaused() const { libgz::no_window("MainWindow::IsPaused"); }
  unsigned int EntityId(const std::string &name) { return get_entity_id(name); }
  bool HasEntityName(const std::string &name) { return has_entity_name(name); }

 private:
  QDockWidget *left = nullptr;
};
class GAZEBO_VISIBLE Conversions
{
 public:
  static QColor Convert(const ignition::math::Color &v) { return QColor::fromRgbF(v.R(), v.G(), v.B(), v.A()); }
  static ignition::math::Color Convert(const QColor &v)
  {
    return ignition::math::Color(v.redF(), v.greenF(), v.blueF(), v.alphaF());
  }
  static QPointF Convert(const ignition::math::Vector2d &v) { return QPointF(v.X(), v.Y()); }
  static ignition::math::Vector2d Convert(const QPointF &v) { return ignition::math::Vector2d(v.x(), v.y()); }
  static QVector3D Convert(const ignition::math::Vector3d &v) { return QVector3D(v.X(), v.Y(), v.Z()); }
  static ignition::math::Vector3d Convert(const QVector3D &v) { return ignition::math::Vector3d(v.x(), v.y(), v.z()); }
};
#endif
}  // namespace gui

/* A plugin of the client. All of it is in the plugin's own file, and nothing of it in the library: plugins with and without
 * widgets can be loaded together.
 */
#ifdef LIBGZ_HAS_QT
class GAZEBO_VISIBLE GUIPlugin : public QWidget, public PluginT<GUIPlugin>
#else
class GAZEBO_VISIBLE GUIPlugin : public PluginT<GUIPlugin>
#endif
{
 public:
  GUIPlugin() { this->type = GUI_PLUGIN; }
  virtual void Load(sdf::ElementPtr) {}
  void LibgzLoad(void *, void *element) override
  {
    libgz::load_element(element, [this](sdf::ElementPtr sdf) { this->Load(sdf); });
  }
#ifdef LIBGZ_HAS_QT
  void paintEvent(QPaintEvent *) override
  {
    // A widget of a class of one's own shows its style sheet if it paints that itself.
    QStyleOption option;
    option.initFrom(this);
    QPainter painter(this);
    this->style()->drawPrimitive(QStyle::PE_Widget, &option, &painter, this);
  }
#endif
};
}  // namespace gazebo

#ifdef LIBGZ_HAS_QT
#define GZ_REGISTER_GUI_PLUGIN(classname) \
  LIBGZ_REGISTER(GUI, classname) \
  extern "C" GAZEBO_VISIBLE QWidget *libgz_widget_of(libgz::PluginRoot *plugin); \
  QWidget *libgz_widget_of(libgz::PluginRoot *plugin) \
  { \
    return static_cast<gazebo::GUIPlugin *>(plugin); \
  }
#else
#define GZ_REGISTER_GUI_PLUGIN(classname) LIBGZ_REGISTER(GUI, classname)
#endif
#endif
#endif
