"""GUI plugins with widgets of Qt: built with its moc, shown in a window, and run by gzclient."""

import os
import signal
import subprocess
import sys
import threading

import numpy as np
import pytest
from master_uri import free_master_uri
from PIL import Image

from libgz.base.errors import LibraryError
from libgz.classic_cxx import qt as qt_module
from libgz.classic_cxx.build import build, check
from libgz.classic_cxx.library import QT, package_flags

PATIENCE = 120.0  # [s]: a machine under load
HEADER = """\
#include <gazebo/common/Plugin.hh>
#include <gazebo/gui/GuiPlugin.hh>
#ifndef Q_MOC_RUN
#include <gazebo/transport/transport.hh>
#include <gazebo/gui/gui.hh>
#endif
namespace gazebo {
class GAZEBO_VISIBLE Overlay : public GUIPlugin
{
  Q_OBJECT
 public:
  Overlay();
  virtual ~Overlay();
  void Load(sdf::ElementPtr sdf) override;
 signals:
  void SetTime(QString text);
 protected slots:
  void OnButton();
 private:
  void OnStats(ConstWorldStatisticsPtr &message);
  void OnModel(ConstModelPtr &message);
  bool OnKey(const common::KeyEvent &event);
  std::string task;
  int stats = 0;
  QPushButton *button;
  QDialog *dialog = nullptr;
  transport::NodePtr node;
  transport::PublisherPtr factory;
  transport::SubscriberPtr statistics, models;
  event::ConnectionPtr ready, entities;
  std::vector<event::ConnectionPtr> modes;
};
}
"""
SOURCE = """\
#include "overlay.hh"
using namespace gazebo;
GZ_REGISTER_GUI_PLUGIN(Overlay)

Overlay::Overlay() : GUIPlugin()
{
  this->setStyleSheet("QFrame { background-color : rgb(10, 200, 30); }");
  auto *frame = new QFrame;
  auto *inner = new QVBoxLayout(frame), *outer = new QVBoxLayout(this);
  outer->setContentsMargins(0, 0, 0, 0);
  auto *time = new QLabel("no time");
  this->button = new QPushButton("Spawn");
  inner->addWidget(time);
  inner->addWidget(this->button);
  outer->addWidget(frame);
  connect(this, SIGNAL(SetTime(QString)), time, SLOT(setText(QString)), Qt::QueuedConnection);
  connect(this->button, SIGNAL(clicked()), this, SLOT(OnButton()));
  this->move(300, 40);
  this->resize(200, 100);
}
Overlay::~Overlay()
{
  printf("%s deleted\\n", this->task.c_str());
  fflush(stdout);
}
void Overlay::Load(sdf::ElementPtr sdf)
{
  gui::setINIProperty("overlay.shown", std::string("true"));
  if (!gui::getINIProperty<bool>("overlay.shown", false) || gui::getINIProperty<int>("overlay.shown", 3) != 3)
    throw std::runtime_error("properties");
  this->task = sdf->Get<std::string>("task");
  this->node.reset(new transport::Node);
  this->node->Init(gui::get_world());
  this->factory = this->node->Advertise<msgs::Factory>("~/factory");
  this->statistics = this->node->Subscribe("~/world_stats", &Overlay::OnStats, this);
  this->models = this->node->Subscribe("~/model/info", &Overlay::OnModel, this);
  this->ready = gui::Events::ConnectMainWindowReady([this] { std::cout << this->task << " ready" << std::endl; });
  this->entities = gui::Events::ConnectModelUpdate([this](const msgs::Model &model) {
    std::cout << this->task << " model " << model.name() << std::endl;
    gui::Events::follow("ball");
    gui::Events::fullScreen(gui::get_main_window() == nullptr);
    gui::Events::alignMode("x", "min", "first", true, false);
    gui::Events::moveEntity(model.name(), msgs::ConvertIgn(model.pose()), true);
    gui::Events::scaleEntity(model.name(), ignition::math::Vector3d::One);
    gui::Events::inputStepSize(3);
  });
  this->modes = {gui::Events::ConnectAlignMode([this](std::string axis, std::string, std::string, bool, bool inverted) {
                   std::cout << this->task << " align " << axis << inverted << std::endl;
                 }),
      gui::Events::ConnectMoveEntity([this](const std::string &name, const ignition::math::Pose3d &pose, bool on) {
        std::cout << this->task << " move " << name << on << pose.Pos().X() << std::endl;
      }),
      gui::Events::ConnectScaleEntity([](const std::string &, const ignition::math::Vector3d &) {}),
      gui::Events::ConnectLightUpdate([](const msgs::Light &) {}), gui::Events::ConnectInputStepSize([this](int steps) {
        std::cout << this->task << " steps " << steps << std::endl;
      })};
  gui::KeyEventHandler::Instance()->AddPressFilter(this->task, [this](const common::KeyEvent &key) {
    return this->OnKey(key); });
}
bool Overlay::OnKey(const common::KeyEvent &event)
{
  std::cout << this->task << " key " << event.text << std::endl;
  return this->task == "spawn" && event.text == "x";
}
void Overlay::OnStats(ConstWorldStatisticsPtr &message)
{
  emit SetTime(QString::number(message->sim_time().sec()));
  if (getenv("QUIT"))
    QCoreApplication::quit();
  if (this->dialog)
    this->dialog->accept();  // stops OnButton's wait
  else if (++this->stats == 3)
    QTimer::singleShot(0, this->button, SLOT(click()));
}
void Overlay::OnButton()
{
  if (this->task == "fail")
    throw std::runtime_error("no such button");
  if (this->task == "wait")
  {
    this->dialog = new QDialog(this);
    const int result = this->dialog->exec();  // others print meanwhile
    std::cout << "dialog " << result << std::endl;
    gui::get_main_window()->Pause();
    for (char key : {'x', 'y'})
      QCoreApplication::postEvent(gui::get_main_window()->findChild<QWidget *>("GLWidget"),
          new QKeyEvent(QEvent::KeyPress, key, Qt::NoModifier, QString(key)));
    return;
  }
  msgs::Model model;
  model.set_name("ball");
  msgs::Set(model.mutable_pose(), ignition::math::Pose3d(0, 0, 1.5, 0, 0, 0));
  msgs::AddSphereLink(model, 1.0, 0.5);
  msgs::Factory message;
  message.set_sdf("<sdf version='" SDF_VERSION "'>" + msgs::ModelToSDF(model)->ToString("") + "</sdf>");
  this->factory->Publish(message);
}
void Overlay::OnModel(ConstModelPtr &message)
{
  if (this->task != "spawn" || message->name() != "ball")
    return;
  gui::get_main_window()->grab().save("window.png");
  std::cout << "the ball is there" << std::endl;
}
"""
WORLD = """\
<sdf version="1.6"><world name="default"><gui>
  <plugin name="good" filename="liboverlay.so"><task>spawn</task></plugin>
  <plugin name="bad" filename="liboverlay.so"><task>fail</task></plugin>
  <plugin name="slow" filename="liboverlay.so"><task>wait</task></plugin>
  <plugin name="plain" filename="libplain.so"/>
</gui><model name="stone"><static>true</static><link name="l"/></model></world></sdf>
"""
WITHOUT = """\
#include <gazebo/gui/GuiPlugin.hh>
class Plain : public gazebo::GUIPlugin
{{
  void Load(sdf::ElementPtr) override {{ gzerr << "plain loaded" << std::endl; }}
  {}
}};
GZ_REGISTER_GUI_PLUGIN(Plain)
"""
with_qt = pytest.mark.skipif(not package_flags("--cflags", QT), reason="Qt is not installed")


def write(folder):
    (folder / "overlay.hh").write_text(HEADER)
    source = folder / "overlay.cc"
    source.write_text(SOURCE)
    return source


def command(name, *words):
    return [
        sys.executable,
        "-c",
        f"import sys; from libgz.apps.{name} import main; sys.exit(main(sys.argv[1:]))",
        *words,
    ]


@with_qt
def test_widgets_in_the_window_of_gzclient(library, tmp_path, monkeypatch):
    source = write(tmp_path)
    assert build([source], tmp_path / "liboverlay.so") == []
    plain = tmp_path / "plain.cc"
    plain.write_text(WITHOUT.format(""))
    with monkeypatch.context() as patch:
        patch.setattr(qt_module, "package_flags", lambda *_words: [])
        assert build([plain], tmp_path / "libplain.so") == []
    world = tmp_path / "overlay.world"
    world.write_text(WORLD)
    for name in ("DISPLAY", "QT_QPA_PLATFORM"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("GAZEBO_MASTER_URI", free_master_uri())
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", str(tmp_path))
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    environment = {**os.environ, "XDG_CACHE_HOME": str(library.folder.parents[2])}
    with subprocess.Popen(command("gzserver", str(world)), cwd=tmp_path) as server:
        client = subprocess.Popen(
            command("gzclient", "--no-view"),
            cwd=tmp_path,
            env=environment,
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        patience = threading.Timer(PATIENCE, client.kill)
        patience.start()
        try:
            said = []
            for line in client.stdout:
                said.append(line.strip())
                if {"the ball is there", "dialog 1", "spawn key y"} <= set(said):
                    client.send_signal(signal.SIGTERM)
            errors = client.communicate(timeout=PATIENCE)[1]
            quitting = subprocess.run(client.args, env={**environment, "QUIT": "1"}, timeout=PATIENCE, check=False)
        finally:
            patience.cancel()
            client.kill()
            server.terminate()
    assert client.returncode == 0, (said, errors)
    assert quitting.returncode == 0
    monkeypatch.setenv("GAZEBO_MASTER_URI", free_master_uri())
    both = subprocess.run(
        command("gazebo", str(world), "--view-port", "18080", "--iters", "60000", "--verbose"),
        cwd=tmp_path,
        env={**environment, "GAZEBO_MASTER_URI": os.environ["GAZEBO_MASTER_URI"], "QUIT": "1"},
        text=True,
        capture_output=True,
        timeout=PATIENCE,
        check=False,
    )
    assert both.returncode == 0, both.stderr
    assert "The client has ended; the server ends with it." in both.stdout
    assert "spawn deleted" in both.stdout
    assert said.count("the ball is there") == 1
    assert {"spawn model stone", "spawn align x0", "spawn move stone10", "wait steps 3"} <= set(said)
    assert errors.count("gui::Events::ConnectAlignMode: only plugins signal this event here") == 1
    assert "ConnectModelUpdate: only plugins" not in errors
    assert {"spawn ready", "fail ready", "wait ready", "spawn key x", "wait key y"} <= set(said)
    assert "wait key x" not in said  # the filter ahead of it has handled that
    assert {f"{task} deleted" for task in ("spawn", "fail", "wait")} <= set(said)
    assert "they run unseen, by Qt's platform offscreen" in errors
    assert "Exception occured in an event of Qt of plugin with name[bad]" in errors
    assert "std::runtime_error: no such button" in errors
    assert "plain loaded" in errors
    pixels = np.asarray(Image.open(tmp_path / "window.png").convert("RGB"))
    assert pixels.shape == (600, 800, 3)
    assert tuple(pixels[42, 302]) == (10, 200, 30)  # where the plugin has moved its widget
    assert tuple(pixels[20, 302]) != (10, 200, 30)


@with_qt
def test_moc_that_fails_is_said(library, tmp_path):
    source = write(tmp_path)
    (tmp_path / "overlay.hh").write_text(HEADER.replace("signals:", "signals: int;;; class {"))
    with pytest.raises(LibraryError, match=r"Qt's moc failed: .*overlay\.hh"):
        build([source], tmp_path / "liboverlay.so")


SLOT = """\
#include <gazebo/gui/GuiPlugin.hh>
class {0} : public QObject
{{
  Q_OBJECT
 public slots:
  void Press() {{}}
}};
"""


@with_qt
def test_headers_of_one_name_have_files_of_moc_of_their_own(library, tmp_path):
    for name in ("first", "second"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "button.hh").write_text(SLOT.format(f"{name}Button"))
    source = tmp_path / "both.cc"
    # A header that is named by two paths is one file.
    source.write_text(
        '#include "first/button.hh"\n#include "second/button.hh"\n#if 0\n#include "second/../first/button.hh"\n#endif\n'
        "class Both : public gazebo::GUIPlugin { firstButton one; secondButton two; };\nGZ_REGISTER_GUI_PLUGIN(Both)\n"
    )
    assert build([source], tmp_path / "libboth.so", options=["-Wl,--no-undefined"]) == []
    (tmp_path / "made").mkdir()
    qt = qt_module.QtSources([source], [])
    assert len(set(qt.make(tmp_path / "made"))) == 2
    for name in ("first", "second"):
        (tmp_path / name / "part.cc").write_text(SLOT.format(f"{name}Part") + '#include "part.moc"\n')
    with pytest.raises(LibraryError, match=r"both need a file part\.moc of Qt's moc; rename one of them"):
        build([tmp_path / "first" / "part.cc", tmp_path / "second" / "part.cc"], tmp_path / "libpart.so")


@pytest.fixture
def without_qt(monkeypatch):
    """As where Qt is not installed."""
    monkeypatch.setattr(qt_module, "package_flags", lambda *_words: [])


def test_without_qt_a_plugin_without_widgets_compiles(library, tmp_path, without_qt):
    source = tmp_path / "plain.cc"
    source.write_text(WITHOUT.format(""))
    assert check([source]) == []
    source.write_text(WITHOUT.format("; Q_OBJECT"))
    (error, *_) = check([source])
    assert "plugins with widgets need Qt: apt-get install qtbase5-dev" in error.message
    source.write_text(WITHOUT.format("\n  Q_OBJECT\n"))
    with pytest.raises(LibraryError, match="apt-get install qtbase5-dev"):
        check([source])
