// The window of GUI plugins with widgets: a part of its own, which is built where Qt is installed. All of it runs in the
// client's main thread, which calls by ctypes.PyDLL: with Python's lock. License: Apache License 2.0.
#include "bridge.hh"
#include "gazebo/libgz/gui.hh"

namespace libgz {
using namespace gazebo;

/* A plugin with widgets. */
struct Overlay
{
  Running context;
  QWidget *widget;
  Ref failed;  // is called with what the plugin throws
};

class Application : public QApplication
{
 public:
  using QApplication::QApplication;
  // What a plugin throws must not pass through Qt's event loop.
  bool notify(QObject *receiver, QEvent *event) override
  {
    if (QThread::currentThread() != this->thread())
      return QApplication::notify(receiver, event);
    const Running running = this->Of(receiver);
    bool done = true;
    try
    {
      run_as(running, "an event of Qt", [&] { done = QApplication::notify(receiver, event); });
    }
    catch (...)
    {
      Gil gil;
      Ref error(caught());
      PyObject *failed = this->failed.get();
      for (const Overlay &one : this->overlays)
        if (one.context == running)
          failed = one.failed.get();
      Ref result(PyObject_CallOneArg(failed, error.get()));
      if (!result)
        PyErr_WriteUnraisable(nullptr);
    }
    return done;
  }
  std::list<Overlay> overlays;
  Ref failed;  // of what belongs to no plugin

 private:
  /* The plugin whose widget an object is, or belongs to. */
  Running Of(QObject *object) const
  {
    for (; object != nullptr; object = object->parent())
      for (const Overlay &one : this->overlays)
        if (one.widget == object)
          return one.context;
    return nullptr;
  }
};

/* What lies below the widgets: it asks the filters of plugins about keys and the mouse. */
class Ground : public gui::GLWidget
{
 public:
  explicit Ground(QWidget *parent) : GLWidget(parent)
  {
    this->setObjectName("GLWidget");
    this->setFocusPolicy(Qt::StrongFocus);
    this->setMouseTracking(true);
  }

 protected:
  void paintEvent(QPaintEvent *) override { QPainter(this).fillRect(this->rect(), QColor(70, 70, 70)); }
  void keyPressEvent(QKeyEvent *event) override { this->Key(event, common::KeyEvent::PRESS); }
  void keyReleaseEvent(QKeyEvent *event) override { this->Key(event, common::KeyEvent::RELEASE); }
  void mousePressEvent(QMouseEvent *event) override
  {
    this->mouse.SetPressPos(event->x(), event->y());
    gui::MouseEventHandler::Instance()->HandlePress(this->Mouse(event, common::MouseEvent::PRESS));
  }
  void mouseReleaseEvent(QMouseEvent *event) override
  {
    gui::MouseEventHandler::Instance()->HandleRelease(this->Mouse(event, common::MouseEvent::RELEASE));
  }
  void mouseMoveEvent(QMouseEvent *event) override
  {
    gui::MouseEventHandler::Instance()->HandleMove(this->Mouse(event, common::MouseEvent::MOVE));
  }
  void mouseDoubleClickEvent(QMouseEvent *event) override
  {
    gui::MouseEventHandler::Instance()->HandleDoubleClick(this->Mouse(event, common::MouseEvent::PRESS));
  }

 private:
  void Key(QKeyEvent *event, common::KeyEvent::EventType type)
  {
    event->ignore();  // the widget that holds this may have filters, too
    auto *handler = gui::KeyEventHandler::Instance();
    if (event->isAutoRepeat() && !handler->AutoRepeat())
      return;
    common::KeyEvent key;
    key.type = type;
    key.key = event->key();
    key.text = event->text().toStdString();
    key.control = event->modifiers() & Qt::ControlModifier;
    key.shift = event->modifiers() & Qt::ShiftModifier;
    key.alt = event->modifiers() & Qt::AltModifier;
    if (type == common::KeyEvent::RELEASE)
      handler->HandleRelease(key);
    else if (!handler->HandlePress(key))
      gui::Events::keyPress(key.text);
  }
  common::MouseEvent Mouse(QMouseEvent *event, common::MouseEvent::EventType type)
  {
    common::MouseEvent &mouse = this->mouse;
    mouse.SetPrevPos(mouse.Pos());
    mouse.SetPos(event->x(), event->y());
    mouse.SetType(type);
    // Qt's numbers are those of X, in which the right button comes second.
    auto number = [](int buttons) {
      return (buttons & Qt::LeftButton ? common::MouseEvent::LEFT : 0) |
             (buttons & Qt::MiddleButton ? common::MouseEvent::MIDDLE : 0) |
             (buttons & Qt::RightButton ? common::MouseEvent::RIGHT : 0);
    };
    mouse.SetButton(static_cast<common::MouseEvent::MouseButton>(number(event->button())));
    mouse.SetButtons(number(event->buttons()));
    mouse.SetDragging(type == common::MouseEvent::MOVE && event->buttons() != Qt::NoButton);
    mouse.SetControl(event->modifiers() & Qt::ControlModifier);
    mouse.SetShift(event->modifiers() & Qt::ShiftModifier);
    mouse.SetAlt(event->modifiers() & Qt::AltModifier);
    return mouse;
  }
  common::MouseEvent mouse;
};

class Window : public gui::MainWindow
{
 public:
  Window(int width, int height)
  {
    this->setWindowTitle("Gazebo");
    auto *center = new gui::RenderWidget;
    auto *layout = new QVBoxLayout(center);
    layout->setContentsMargins(0, 0, 0, 0);
    this->ground = new Ground(center);
    layout->addWidget(this->ground);
    this->setCentralWidget(center);
    this->resize(width, height);
    this->ground->setFocus();
  }
  Ground *ground;
  bool open = true;

 protected:
  void closeEvent(QCloseEvent *) override { this->open = false; }
};

static Application *application = nullptr;
static Window *window = nullptr;
static PyObject *tick = nullptr;
}  // namespace libgz

// What Python calls ---------------------------------------------------------------------------------------------------

extern "C" {
/* platform: of Qt. failed: is called with errors that belong to no plugin. nested: is called at a rate while a plugin waits
 * for a dialog in an event of Qt.
 */
void libgz_qt_open(const char *platform, int width, int height, PyObject *failed, PyObject *nested)
{
  using namespace libgz;
  static std::string words[3];
  static char *argv[4];
  static int argc;
  argc = 0;  // Qt removes words from it
  for (const char *word : {"gzclient", "-platform", platform})
  {
    words[argc] = word;
    argv[argc] = &words[argc][0];
    ++argc;
  }
  {
    Unlocked unlocked;
    application = new Application(argc, argv);
    application->setQuitOnLastWindowClosed(false);
    window = new Window(width, height);
    main_window = static_cast<gui::MainWindow *>(window);
    window->show();
    auto *timer = new QTimer(application);
    QObject::connect(timer, &QTimer::timeout, [] {
      if (QThread::currentThread()->loopLevel() < 2)
        return;
      Gil gil;
      Ref result(PyObject_CallNoArgs(tick));
      if (!result)
        PyErr_WriteUnraisable(nullptr);
    });
    timer->start(16);
  }
  application->failed = Ref(Py_NewRef(failed));
  tick = Py_NewRef(nested);
}
/* Put a plugin's widget into the window. widget_of: the function of its file. */
void libgz_qt_add(void *plugin, void *widget_of, PyObject *failed)
{
  using namespace libgz;
  QWidget *widget = reinterpret_cast<QWidget *(*)(PluginRoot *)>(widget_of)(root_of(plugin));
  application->overlays.push_back({context_of(plugin), widget, Ref(Py_NewRef(failed))});
  Unlocked unlocked;
  widget->setParent(window->ground);
  QObject::connect(widget, &QObject::destroyed, [widget] {
    Gil gil;
    if (application != nullptr)
      application->overlays.remove_if([&](const Overlay &one) { return one.widget == widget; });
  });
}
void libgz_qt_show(void *plugin, void *widget_of, int shown)
{
  using namespace libgz;
  QWidget *widget = reinterpret_cast<QWidget *(*)(PluginRoot *)>(widget_of)(root_of(plugin));
  Unlocked unlocked;
  widget->setVisible(shown);
}
void libgz_qt_full_screen(int on)
{
  libgz::Unlocked unlocked;
  on ? libgz::window->showFullScreen() : libgz::window->showNormal();
}
void libgz_qt_left_pane(int on)
{
  libgz::Unlocked unlocked;
  libgz::window->SetLeftPaneVisibility(on);
}
/* Let Qt handle events for a time [s]; whether the window is still open, and no plugin has called QCoreApplication::quit:
 * no loop of Qt runs after that.
 */
int libgz_qt_turn(double seconds)
{
  using namespace libgz;
  bool over = false;
  {
    Unlocked unlocked;
    QEventLoop loop;
    QTimer::singleShot(static_cast<int>(1e3 * seconds), &loop, [&] {
      over = true;
      loop.quit();
    });
    loop.exec();
  }
  return window->open && over;
}
/* End what waits in an event of Qt. */
void libgz_qt_leave() { QCoreApplication::exit(); }
void libgz_qt_close()
{
  using namespace libgz;
  {
    Unlocked unlocked;
    for (const Overlay &one : application->overlays)
      one.widget->setParent(nullptr);  // it belongs to its plugin
    main_window = nullptr;
    delete std::exchange(window, nullptr);
  }
  Application *ended = std::exchange(application, nullptr);
  ended->overlays.clear();
  ended->failed = Ref();
  Py_CLEAR(tick);
  Unlocked unlocked;
  delete ended;
}
}
