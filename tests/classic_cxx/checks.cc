// A plugin of each kind; <check> says what it does. A check that fails throws.
#include <gazebo/common/common.hh>
#include <gazebo/gazebo.hh>
#include <gazebo/physics/physics.hh>
#include <gazebo/plugins/CameraPlugin.hh>
#include <gazebo/plugins/DepthCameraPlugin.hh>
#include <gazebo/physics/ode/ODEPhysics.hh>
#include <gazebo/plugins/ElevatorPlugin.hh>
#include <gazebo/plugins/GpuRayPlugin.hh>
#include <gazebo/plugins/HarnessPlugin.hh>
#include <gazebo/plugins/ImuSensorPlugin.hh>
#include <gazebo/plugins/LinearBatteryPlugin.hh>
#include <gazebo/plugins/WheelSlipPlugin.hh>
#include <gazebo/plugins/RayPlugin.hh>
#include <gazebo/rendering/rendering.hh>
#include <gazebo/sensors/sensors.hh>
#include <gazebo/transport/transport.hh>
#include <csignal>
#include <future>
#include <cstdlib>
#include <ignition/common/Profiler.hh>
#include <ignition/math4/ignition/math.hh>
#include <thread>

#define EXPECT(condition) \
  if (!(condition)) \
  gzthrow("it does not hold that " #condition)

using namespace gazebo;

// A class with static variables of inline functions, which each copy of the file has for itself.
inline int &Loads()
{
  static int number = 0;
  return number;
}

// Ways in which a plugin breaks.
struct Failure
{
};
struct Saying : public std::exception
{
  explicit Saying(const char *_text) : text(_text) {}
  const char *what() const noexcept override { return this->text; }
  const char *text;
};
enum class Kind
{
  OTHER
};
struct Failing : public std::exception
{
};
struct Abstract
{
  explicit Abstract(bool calls)
  {
    if (calls)
      this->Through();
  }
  virtual ~Abstract() {}
  void Through() { this->Missing(); }
  virtual void Missing() = 0;
};
struct Concrete : Abstract
{
  Concrete() : Abstract(true) {}
  void Missing() override {}
};
static volatile int depth = 0;
static int Deeper(volatile char *before)
{
  volatile char page[4096];
  page[0] = before ? before[0] : 1;
  ++depth;
  return Deeper(page) + page[0];
}
static void Break(const std::string &how)
{
  if (how == "throw")
    throw std::runtime_error("no luck");
  if (how == "text")
    throw "a plain text";
  if (how == "string")
    throw std::string("a string");
  if (how == "int")
    throw 7;
  if (how == "struct")
    throw Failure();
  if (how == "gzthrow")
    gzthrow("none " << 3);
  if (how == "cast")
    boost::any_cast<int>(boost::any(std::string("text")));
  if (how == "at")
    std::vector<int>().at(3);
  if (how == "memory")
    (void) new char[std::size_t(1) << 62];
  if (how == "silent")
    throw Saying(nullptr);
  if (how == "null text")
    throw static_cast<const char *>(nullptr);
  if (how == "several lines")
    throw Saying("one\n[Err] two\r\x1b[2Jthree");
  if (how == "long")
  {
    static const std::string text(1 << 22, 'a');
    throw Saying(text.c_str());
  }
  if (how == "no text")
    throw Saying("no \xff text");
  if (how == "pointer")
    throw new std::runtime_error("no luck");
  if (how == "enum")
    throw Kind::OTHER;
  if (how == "function")
    std::function<void()>()();
  if (how == "mutex")
    std::unique_lock<std::mutex>().unlock();
  if (how == "promise")
  {
    std::future<int> future = std::promise<int>().get_future();
    future.get();
  }
  if (how == "dynamic cast")
    (void) dynamic_cast<Failing &>(*static_cast<std::exception *>(new Saying("")));
  if (how == "assert")
    GZ_ASSERT(how.empty(), "no luck");
  if (how == "boost null")
    physics::LinkPtr()->WorldPose();
  if (how == "other class")
    (void) std::stod("no number");
  if (how == "exit")
    std::exit(3);
  if (how == "quick_exit")
    std::quick_exit(3);
  if (how == "abort")
    std::abort();
  if (how == "terminate")
    std::terminate();
  if (how == "segv")
    *reinterpret_cast<volatile int *>(8) = 1;
  if (how == "segv with a handler" || how == "segv with an exit" || how == "segv with handlers")
    *reinterpret_cast<volatile int *>(8) = 1;
  if (how == "own event")
  {
    event::EventT<void()> own;
    const auto connection = own.Connect([&own] {
      ++depth;
      own();
    });
    own();
  }
  if (how == "call null")
    (*reinterpret_cast<void (*volatile *)()>(&depth))();
  if (how == "ill")
    __builtin_trap();
  if (how == "fpe")
    std::raise(SIGFPE);
  if (how == "bus")
    std::raise(SIGBUS);
  if (how == "overflow")
    Deeper(nullptr);
  if (how == "double free")
  {
    void *volatile memory = std::malloc(64), *volatile same = memory;
    std::free(memory);
    std::free(same);
  }
  if (how == "heap")
  {
    char *volatile memory = static_cast<char *>(std::malloc(2000));
    std::memset(memory - 8, 255, 8);  // the size that malloc keeps there
    std::free(memory);
  }
  if (how == "pure")
    Concrete();
  if (how == "loop" || how == "deadlock")
    std::cerr << how << " begins" << std::endl;
  if (how == "loop")
    for (volatile int i = 0;; i = i + 1)
      ;
  if (how == "deadlock")
  {
    std::mutex mutex;
    std::unique_lock<std::mutex> lock(mutex);
    std::condition_variable never;
    never.wait(lock, [] { return false; });
  }
  if (how == "thread")
  {
    std::thread running([] { throw std::runtime_error("no luck in a thread"); });
    running.join();
  }
  if (how == "thread segv")
    std::thread([] { *reinterpret_cast<volatile int *>(8) = 1; }).join();
  if (how == "thread exit")
    std::thread([] { std::exit(3); }).join();
  if (how == "joinable")
    std::thread([] { std::this_thread::sleep_for(std::chrono::hours(1)); });
  if (how == "left thread")
    std::thread([] {
      for (volatile int i = 0;; i = i + 1)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }).detach();
}
// A handler of signals, as libraries that print a stack have it.
static void OnSignal(int _number)
{
  (void) !write(STDERR_FILENO, "own words\n", 10);
  std::signal(_number, SIG_DFL);
  std::raise(_number);
}
static void OnSignalExit(int) { std::exit(4); }
// Handlers that hand a signal on to the one that they have found.
static struct sigaction found[2];
static void OnSignalFirst(int _number)
{
  (void) !write(STDERR_FILENO, "first words\n", 12);
  sigaction(_number, &found[0], nullptr);
}
static void OnSignalSecond(int _number)
{
  (void) !write(STDERR_FILENO, "second words\n", 13);
  sigaction(_number, &found[1], nullptr);
}
static void Handle(void (*handler)(int), struct sigaction *before)
{
  struct sigaction now = {};
  now.sa_handler = handler;
  now.sa_flags = SA_NODEFER;
  sigaction(SIGSEGV, &now, before);
}
static void BreakAt(const char *place, const std::string &check)
{
  const std::size_t at = check.find(" in ");
  if (at != std::string::npos && check.substr(at + 4) == place)
    Break(check.substr(0, at));
}

class Checks : public ModelPlugin
{
 public:
  Checks()
  {
    if (const char *check = std::getenv("LIBGZ_TEST_CHECK"))
      BreakAt("constructor", check);
    gzmsg << "made number " << ++Loads() << std::endl;
  }
  ~Checks()
  {
    BreakAt("destructor", this->check);
    this->stop = true;
    if (this->thread.joinable())
      this->thread.join();
    gzmsg << "deleted" << std::endl;
  }

  void Load(physics::ModelPtr _model, sdf::ElementPtr _sdf) override
  {
    this->model = _model;
    this->world = _model->GetWorld();
    this->check = _sdf->Get<std::string>("check");
    EXPECT(this->GetHandle() == "checks");
    EXPECT(_sdf->GetName() == "plugin" && !_sdf->HasElement("nothing"));
    EXPECT(_sdf->Get<int>("nothing", 7).first == 7);
    BreakAt("Load", this->check);
    if (this->check.find("with a handler") != std::string::npos)
      std::signal(SIGSEGV, OnSignal);
    else if (this->check.find("with an exit") != std::string::npos)
      std::signal(SIGSEGV, OnSignalExit);
    else if (this->check.find("with handlers") != std::string::npos)
      Handle(OnSignalFirst, &found[0]);
    if (this->check == "identity")
      this->Identity();
    else if (this->check == "values")
      this->Values(_sdf);
    else if (this->check == "results")
      this->Results();
    else if (this->check == "events")
      this->OwnEvents();
    else if (this->check == "lines")
      this->Lines();
    else if (this->check == "topics" || this->check.find("OnPing") != std::string::npos)
      this->Topics();
    else if (this->check == "threads")
      this->thread = std::thread([this] { this->Publish(); });
    else if (this->check == "null")
      gzmsg << this->model->GetLink("none")->GetName();
    else if (this->check == "libgz")
      this->model->SetWorldPose(ignition::math::Pose3d(NAN, 0, 0, 0, 0, 0));
    this->connection = event::Events::ConnectWorldUpdateBegin(std::bind(&Checks::OnUpdate, this, std::placeholders::_1));
    this->other = event::Events::ConnectWorldUpdateEnd(boost::bind(&Checks::OnEnd, this));
    gzmsg << this->check << " loaded" << std::endl;
  }
  void Init() override
  {
    BreakAt("Init", this->check);
    if (this->check.find("with handlers") != std::string::npos)
      Handle(OnSignalSecond, &found[1]);
    gzmsg << "initialized" << std::endl;
  }
  void Reset() override
  {
    BreakAt("Reset", this->check);
    gzmsg << "reset at " << this->updates << std::endl;
  }

 private:
  void Identity()
  {
    physics::LinkPtr link = this->model->GetLink("arm");
    EXPECT(link && link == this->model->GetLink("arm") && link == this->model->GetChildLink("arm"));
    EXPECT(this->model->shared_from_this() == this->model);
    physics::BasePtr base = link;
    EXPECT(boost::dynamic_pointer_cast<physics::Link>(base) == link);
    EXPECT(boost::dynamic_pointer_cast<physics::Entity>(base));
    EXPECT(!boost::dynamic_pointer_cast<physics::Model>(base));
    EXPECT(link->GetModel() == this->model && link->GetWorld() == this->world);
    EXPECT(base->HasType(physics::Base::LINK) && !base->HasType(physics::Base::MODEL));
    EXPECT(boost::dynamic_pointer_cast<physics::Model>(link->GetParent()) == this->model);
    EXPECT(this->model->GetLinks().size() == 2 && this->model->GetLinks()[1] == link);
    EXPECT(!this->model->GetLink("none"));
    EXPECT(physics::get_world(this->world->Name()) == this->world);
    EXPECT(this->world->ModelByName("robot") == this->model);
    auto shape = link->GetCollision("shape")->GetShape();
    EXPECT(boost::dynamic_pointer_cast<physics::BoxShape>(shape));
    // Through the whole hierarchy, by shared and plain pointers, and back from each level.
    physics::EntityPtr entity = this->model;
    for (physics::BasePtr one : {physics::BasePtr(this->world->ModelByName("robot")), physics::BasePtr(entity)})
    {
      EXPECT(boost::dynamic_pointer_cast<physics::Model>(one) == this->model);
      EXPECT(dynamic_cast<physics::Model *>(one.get()) == this->model.get());
      EXPECT(one->shared_from_this() == this->model);
    }
    for (unsigned int i = 0; i < this->model->GetChildCount(); ++i)
    {
      physics::BasePtr child = this->model->GetChild(i);
      EXPECT(boost::dynamic_pointer_cast<physics::Model>(child->GetParent()) == this->model);
      EXPECT(!boost::dynamic_pointer_cast<physics::Link>(child) || boost::dynamic_pointer_cast<physics::Entity>(child));
    }
    physics::JointPtr hinge = this->model->GetJoint("hinge");
    EXPECT(hinge->GetChild() == link && hinge->shared_from_this() == hinge && typeid(*link) == typeid(physics::Link));
    EXPECT(boost::dynamic_pointer_cast<physics::Joint>(physics::BasePtr(hinge)) == hinge);
    boost::weak_ptr<physics::Link> weak(link);
    EXPECT(weak.lock() == link);
    std::map<physics::LinkPtr, int> numbers{{link, 1}};
    EXPECT(numbers.count(this->model->GetLink("arm")) == 1 && numbers.count(this->model->GetLink("base")) == 0);
    auto surface = boost::dynamic_pointer_cast<physics::ODESurfaceParams>(link->GetCollision("shape")->GetSurface());
    surface->slip1 = 0.25;
    surface->slip1 *= 2;
    surface->collideWithoutContactBitmask |= 4u;
    EXPECT(surface->collideWithoutContactBitmask & 4u);
    EXPECT(surface->slip1 == 0.5 && surface->FrictionPyramid()->MuPrimary() > 0);
    msgs::Surface changed, whole;
    changed.set_kp(1e6);
    changed.mutable_friction()->set_mu2(0.75);
    surface->ProcessMsg(changed);
    surface->FillMsg(whole);
    EXPECT(surface->kp == 1e6 && whole.kp() == 1e6 && whole.friction().mu2() == 0.75 && whole.friction().slip1() == 0.5);
    EXPECT(whole.collide_without_contact_bitmask() & 4u);
    boost::weak_ptr<physics::ODESurfaceParams> weak_surface(surface);  // as WheelSlipPlugin has
    boost::weak_ptr<physics::Shape> weak_shape(link->GetCollision("shape")->GetShape());
    boost::weak_ptr<physics::FrictionPyramid> weak_friction(surface->FrictionPyramid());
    surface.reset();
    EXPECT(weak_surface.lock() && weak_surface.lock()->slip1 == 0.5 && weak_shape.lock() && weak_friction.lock());
    const auto &paths = common::SystemPaths::Instance()->GetPluginPaths();
    EXPECT(&paths == &common::SystemPaths::Instance()->GetPluginPaths() && paths.begin() != paths.end());
    auto engine = boost::dynamic_pointer_cast<physics::ODEPhysics>(this->world->Physics());
    EXPECT(engine->GetFrictionModel() == "pyramid_model" && engine->GetSORPGSIters() == 50);
    engine->SetFrictionModel("cone_model");
    engine->SetSORPGSIters(60);
    EXPECT(engine->GetFrictionModel() == "cone_model" && engine->GetSORPGSIters() == 60);
    physics::LightPtr lamp = this->world->LightByName("lamp");  // rendering has a class Light, too
    EXPECT(lamp && this->world->Lights().front() == lamp && lamp->WorldPose().Pos().Z() == 3);
    physics::WorldState states;  // as members of plugins are, which are loaded later
    physics::ModelState state;
    EXPECT(states.GetModelStateCount() == 0 && state.IsZero());
    states.Load(this->world);
    state.Load(this->model, common::Time(3), common::Time(2), 7);
    EXPECT(states.GetModelStateCount() == 1 && states.GetModelState("robot").Pose() == this->model->WorldPose());
    EXPECT(state.GetIterations() == 7 && state.GetSimTime() == common::Time(2));
    auto sensor = sensors::get_sensor("imu");
    std::vector<std::string> types;
    sensors::SensorFactory::GetSensorTypes(types);
    EXPECT(std::find(types.begin(), types.end(), "imu") != types.end());
    EXPECT(std::dynamic_pointer_cast<sensors::ImuSensor>(sensor) && sensor == sensors::get_sensor("imu"));
    EXPECT(!std::dynamic_pointer_cast<sensors::RaySensor>(sensor));
  }
  void Values(sdf::ElementPtr _sdf)
  {
    IGN_PROFILE("Values");
    IGN_PROFILE_BEGIN("all");
    EXPECT(_sdf->Get<ignition::math::Vector3d>("vector") == ignition::math::Vector3d(1, 2, 3));
    EXPECT(_sdf->GetElement("vector")->GetAttribute("unit")->GetAsString() == "m");
    EXPECT(common::Time(1.5) + common::Time(0, 600000000) == common::Time(2, 100000000));
    EXPECT(GZ_SEC_TO_HOUR(7200) == 2.0);
    common::PID pid(2, 1, 0.5, 1, -1);
    EXPECT(pid.Update(1.0, common::Time(0.1)) == -2.0 - 0.1 - 5.0);
    physics::JointPtr joint = this->model->GetJoint("hinge");
    EXPECT(joint->UpperLimit(0) == 1.5 && joint->GetName() == "hinge" && joint->GetParent() == this->model->GetLink("base"));
    // What the text of an element lacks has the defaults of SDF.
    sdf::ElementPtr described(new sdf::Element);
    EXPECT(sdf::initFile("joint.sdf", described));
    EXPECT(sdf::readString("<sdf version='1.7'><joint name='rope' type='prismatic'><parent>world</parent>"
                           "<child>base</child><axis><xyz>0 0 1</xyz></axis></joint></sdf>", described));
    sdf::ElementPtr noisy(new sdf::Element);
    EXPECT(sdf::initFile("noise.sdf", noisy));
    EXPECT(sdf::readString("<sdf version='1.7'><noise type='gaussian'><mean>1</mean><stddev>2</stddev></noise></sdf>", noisy));
    std::ostringstream said;
    sensors::NoiseFactory::NewNoiseModel(noisy)->Print(said);
    EXPECT(said.str().find("mean[1], stdDev[2]") != std::string::npos);
    physics::JointPtr rope = this->model->CreateJoint(described);
    EXPECT(rope->GetVelocityLimit(0) == -1 && rope->GetEffortLimit(0) == -1 && rope->GetStopStiffness(0) == 1e8);
    EXPECT(this->model->RemoveJoint("rope"));
    this->model->GetJointController()->SetPositionPID(joint->GetScopedName(), pid);
    EXPECT(this->model->GetJointController()->GetPositionPIDs().size() == 1);
    physics::InertialPtr inertial = this->model->GetLink("arm")->GetInertial();
    EXPECT(inertial->Mass() == 2 && inertial->Ign().MassMatrix().Mass() == 2);
    // Inertials are values, and are added and moved as in Gazebo 11.1.
    physics::Inertial heavy(*inertial), given(2.5);
    heavy.SetMass(3);
    heavy.SetInertiaMatrix(1, 2, 2.5, 0.1, 0.2, 0.3);
    heavy.SetCoG(ignition::math::Pose3d(0.1, 0.2, 0.3, 0.4, 0.5, 0.6));
    physics::Inertial light(heavy);
    light.SetMass(1);
    light.SetCoG(-0.5, 0, 1);
    EXPECT(inertial->Mass() == 2 && heavy.Mass() == 3 && given.Mass() == 2.5 && given.IXX() == 1);
    given = heavy + light;
    EXPECT(given.Mass() == 4 && given.CoG() == ignition::math::Vector3d(-0.05, 0.15, 0.475));
    EXPECT(given.PrincipalMoments() == ignition::math::Vector3d(3.66565176401, 4.21975733152, 4.44959090447));
    heavy += light;
    EXPECT(heavy.Mass() == 4 && light.Mass() == 1 && heavy.IXY() == given.IXY());
    EXPECT(light(ignition::math::Vector3d(1, 0, 0)).CoG() == ignition::math::Vector3d(-1.5, 0, 1));
    light = ignition::math::Inertiald({4, {1, 2, 2.5}, {0.1, 0.2, 0.3}}, ignition::math::Pose3d(1, 2, 3, 0, 0, 0.5));
    EXPECT(light.Mass() == 4 && light.IXZ() == 0.2 && light.CoG().Z() == 3);
    EXPECT(physics::Inertial(light.Ign()).IYZ() == 0.3);
    light.Rotate(ignition::math::Quaterniond(0, 0, IGN_PI));
    EXPECT(light.CoG() == ignition::math::Vector3d(-1, -2, 3) && light.IXX() == 1);
    auto box = this->model->GetLink("arm")->GetCollision("shape")->BoundingBox();
    EXPECT(box.Max().X() > box.Min().X());
    EXPECT(this->world->Gravity().Z() < -9 && this->world->Physics()->GetMaxStepSize() == 0.001);
    boost::any step = this->world->Physics()->GetParam("max_step_size");
    EXPECT(physics::PhysicsEngine::any_cast<double>(step) == 0.001);
    EXPECT(physics::PhysicsEngine::any_cast<int>(boost::any(2.5)) == 2);
    EXPECT(physics::PhysicsEngine::any_cast<std::string>(boost::any("text")) == "text");
    const auto place = this->model->WorldPose();
    for (int i = 1; i < 4; ++i)  // == of ignition-math allows for 1e-3
    {
      this->model->SetWorldPose(ignition::math::Pose3d(1e-4 * i, 0, 0, 0, 0, 0));
      EXPECT(this->model->WorldPose().Pos().X() == 1e-4 * i);
    }
    this->model->SetWorldPose(place);
    msgs::Model message;
    this->model->FillMsg(message);
    EXPECT(message.name() == "robot" && message.link_size() == 2);
    EXPECT(msgs::ConvertIgn(msgs::Convert(ignition::math::Vector3d(1, 2, 3))) == ignition::math::Vector3d(1, 2, 3));
    EXPECT(common::SystemPaths::Instance()->GetPluginPaths().size() >= 1);
    boost::recursive_mutex::scoped_lock lock(*this->world->Physics()->GetPhysicsUpdateMutex());
    common::PoseAnimationPtr animation(new common::PoseAnimation("move", 1.0, false));
    animation->CreateKeyFrame(0)->Translation(ignition::math::Vector3d(0, 0, 5));
    EXPECT(animation->GetKeyFrameCount() == 1);
    physics::ModelState state(this->model);
    EXPECT(state.GetLinkState("arm").Pose() == this->model->GetLink("arm")->WorldPose());
    EXPECT(state.GetLinkStates(boost::regex("a.*")).count("arm") == 1);
    EXPECT(state.GetLinkStates(boost::regex("a")).empty() && state.GetJointStates(boost::regex(".*")).size() == 1);
    EXPECT(physics::WorldState(this->world).GetModelStates(boost::regex("ro.ot")).size() == 1);
    physics::JointState turned(joint);
    common::URI uri(this->model->GetLink("arm")->GetCollision("shape")->URI());
    EXPECT(uri.Str() == "data://world/default/model/robot/link/arm/collision/shape" && joint->URI().Valid());
    EXPECT(this->world->URI() == common::URI("data://world/default") && !common::URI::Valid("data:/world"));
    uri.Query().Insert("p", "double/depth");
    EXPECT(uri.Query().Str() == "?p=double/depth" && uri.Path().Contains(this->model->URI().Path()));
    util::IntrospectionManager *offered = util::IntrospectionManager::Instance();
    EXPECT(offered->Register<double>(uri.Str(), [] { return 0.5; }) && offered->Items().count(uri.Str()) == 1);
    EXPECT(offered->Unregister(uri.Str()) && offered->Items().empty());
    const auto seen = this->model->GetLink("base")->Visuals();
    EXPECT(seen.size() == 1 && seen.begin()->second.name() == "robot::base::seen");
    float *corners = nullptr;
    int *order = nullptr;
    const common::Mesh *cube = common::MeshManager::Instance()->GetMesh("unit_box");
    for (int i = 0; i < 2; i++)  // the second time in place of the first arrays
      cube->FillArrays(&corners, &order);
    EXPECT(std::abs(corners[3 * cube->GetVertexCount() - 1]) == 0.5f && order[0] >= 0);
    delete[] corners;
    delete[] order;
    EXPECT(state.HasJointState("hinge") && (turned - turned).IsZero() && (turned + turned).GetName() == "hinge");
  }
  void Lines()
  {
    auto visual = rendering::get_scene(this->world->Name())->WorldVisual();
    rendering::DynamicLines *line = visual->CreateDynamicLine(rendering::RENDERING_LINE_LIST);
    line->AddPoint(ignition::math::Vector3d(0, 0, 1));
    line->AddPoint(1, 2, 3, ignition::math::Color(1, 0, 0));
    GZ_OGRE_SET_MATERIAL_BY_NAME(line, "Gazebo/Purple");
    line->setVisibilityFlags(GZ_VISIBILITY_GUI);
    EXPECT(line->GetPointCount() == 2 && line->Point(1) == ignition::math::Vector3d(1, 2, 3));
    visual->DeleteDynamicLine(line);
  }
  // Results in parameters, and in boost::any.
  void Results()
  {
    boost::any value;
    EXPECT(this->world->Physics()->GetParam("max_step_size", value) && boost::any_cast<double>(value) == 0.001);
    EXPECT(this->world->Physics()->GetParam("iters", value) && boost::any_cast<int>(value) == 50);
    EXPECT(!this->world->Physics()->GetParam("nothing", value));
    EXPECT(boost::any_cast<int>(this->world->Physics()->GetParam("iters")) == 50);
    physics::PresetManagerPtr presets = this->world->PresetMgr();
    EXPECT(presets->GetCurrentProfileParam("real_time_update_rate", value) && boost::any_cast<double>(value) == 1000);
    EXPECT(presets->SetCurrentProfileParam("max_step_size", 0.002));
    EXPECT(presets->GetCurrentProfileParam("max_step_size", value) && boost::any_cast<double>(value) == 0.002);
    EXPECT(this->world->Physics()->GetMaxStepSize() == 0.002);
    double distance = -1;
    std::string name = "?";
    this->model->GetLink("arm")->GetNearestEntityBelow(distance, name);
    EXPECT(distance > 0 && name == "robot::base::c");
    auto ray = boost::dynamic_pointer_cast<physics::RayShape>(
        this->world->Physics()->CreateShape("ray", physics::CollisionPtr()));
    ray->SetPoints(ignition::math::Vector3d(0, 0, 5), ignition::math::Vector3d(0, 0, -5));
    ray->GetIntersection(distance, name);
    EXPECT(distance > 3 && name == "robot::arm::shape");
    ignition::math::Vector3d start, end;
    ray->GlobalPoints(start, end);
    EXPECT(start.Z() == 5 && end.Z() == -5);
    std::vector<std::string> types;
    sensors::SensorManager::Instance()->GetSensorTypes(types);
    EXPECT(std::find(types.begin(), types.end(), "imu") != types.end());
  }
  void OwnEvents()
  {
    event::EventT<void(int)> own;
    int sum = 0;
    event::ConnectionPtr first = own.Connect([&sum](int value) { sum += value; });
    {
      event::ConnectionPtr second = own.Connect([&sum](int value) { sum += 10 * value; });
      own(1);
      EXPECT(sum == 11 && own.ConnectionCount() == 2);
    }
    own(1);
    EXPECT(sum == 12);
    first.reset();
    own(1);
    EXPECT(sum == 12);
    // Plugins of PX4 call a connection's destructor, which its pointer calls again.
    event::ConnectionPtr ended = own.Connect([&sum](int value) { sum += value; });
    ended->~Connection();
    own(1);
    EXPECT(sum == 12 && own.ConnectionCount() == 0);
    event::ConnectionPtr update = event::Events::ConnectWorldUpdateBegin(std::bind(&Checks::OnUpdate, this, std::placeholders::_1));
    update->~Connection();
    update.reset();
    // What is disconnected is not called, however long its pointer lives.
    this->ended = event::Events::ConnectWorldUpdateBegin([](const common::UpdateInfo &) { gzthrow("it is disconnected"); });
    event::Events::DisconnectWorldUpdateBegin(this->ended);
  }
  void Topics()
  {
    this->node = transport::NodePtr(new transport::Node());
    this->node->Init(this->world->Name());
    this->subscriber = this->node->Subscribe("~/ping", &Checks::OnPing, this);
    this->publisher = this->node->Advertise<msgs::Vector3d>("~/pong");
  }
  void OnPing(ConstVector3dPtr &_msg)
  {
    BreakAt("OnPing", this->check);
    msgs::Vector3d answer(*_msg);
    answer.set_x(_msg->x() + 1);
    this->publisher->Publish(answer);
  }
  void Publish()
  {
    transport::NodePtr own(new transport::Node());
    own->Init(this->world->Name());
    auto pub = own->Advertise<msgs::Time>("~/ticks");
    while (!this->stop)
    {
      std::lock_guard<std::mutex> lock(this->mutex);
      pub->Publish(msgs::Convert(this->world->SimTime()));
      this->published++;
    }
  }
  void OnUpdate(const common::UpdateInfo &_info)
  {
    IGN_PROFILE("Checks::OnUpdate");
    ++this->updates;
    BreakAt("OnUpdate", this->check);
    if (this->check == "remove its model" && this->updates == 2)
      this->world->RemoveModel(this->model);
    if (this->check == "fails later" && this->updates == 3)
      this->model->GetLink("none")->GetName();
    if (this->check == "threads")
    {
      std::lock_guard<std::mutex> lock(this->mutex);  // which the thread holds while it calls libgz
    }
    if (this->check == "joints")
      this->Joints();
    if (this->check == "instances")
      for (int i = 0; i < 1000; ++i)
        common::SystemPaths::Instance();
    if (this->check != "step")
      return;
    physics::LinkPtr link = this->model->GetLink("arm");
    EXPECT(_info.simTime == this->world->SimTime() && _info.worldName == this->world->Name());
    link->AddForce(ignition::math::Vector3d(0, 3, 0));
    link->AddRelativeTorque(ignition::math::Vector3d(0, 0.25, 0));
    link->AddLinkForce(ignition::math::Vector3d(1, 0, 0), ignition::math::Vector3d(0, 0.1, 0));
    if (this->updates % 10)
      return;
    std::cout.precision(17);
    physics::JointPtr joint = this->model->GetJoint("hinge");
    const auto pose = link->WorldPose(), frame = this->model->WorldPose(), centre = link->WorldCoGPose();
    const double numbers[] = {pose.Pos().Y(), pose.Rot().W(), frame.Pos().X(), frame.Rot().Z(), centre.Pos().Z(),
        link->WorldLinearVel().Y(), link->WorldCoGLinearVel().X(), link->WorldAngularVel().Z(),
        link->RelativeLinearVel().X(), link->RelativeAngularVel().Y(), joint->Position(0), joint->GetVelocity(0)};
    std::ostringstream line;
    line.precision(17);
    for (double number : numbers)
      line << " " << number;
    gzmsg << "numbers" << line.str() << std::endl;
  }
  // What the twin in Python does, too.
  void Joints()
  {
    const int n = this->updates;
    std::ostringstream line;
    line.precision(17);
    for (const auto &joint : this->model->GetJoints())
    {
      joint->SetForce(0, 0.9 * n * std::pow(-1.0, n / 7));
      joint->SetForce(0, 0.125);
      line << " " << joint->GetForce(0);
      if (n == 20)
        joint->SetEffortLimit(0, 2.5);
      if (n == 30)
        joint->SetVelocityLimit(0, 0.75);
      if (n == 40)
        line << " " << joint->SetParam("fmax", 0, 3.0) << joint->SetParam("vel", 0, -1) << joint->SetParam("vel", 0, 1e9);
      if (n == 45)
        joint->SetParam("vel", 0, -0.4f);
      if (n == 60)
        joint->SetParam("fmax", 0, -1.0);
      if (n == 70)
        joint->SetParam("friction", 0, 0.25);
      if (n == 80)
        joint->SetParam("stop_erp", 0, 0.5);
      if (n == 85)
        joint->SetParam("hi_stop", 0, 0.5);
      for (const char *key : {"fmax", "vel", "friction", "stop_erp", "hi_stop", "lo_stop"})
        line << " " << joint->GetParam(key, 0);
      line << " " << joint->Position(0) << " " << joint->GetVelocity(0);
    }
    gzmsg << "joints" << line.str() << std::endl;
  }
  void OnEnd()
  {
    BreakAt("OnEnd", this->check);
    ++this->ends;
  }

  physics::ModelPtr model;
  physics::WorldPtr world;
  std::string check;
  event::ConnectionPtr connection, other, ended;
  transport::NodePtr node;
  transport::SubscriberPtr subscriber;
  transport::PublisherPtr publisher;
  std::thread thread;
  std::mutex mutex;
  std::atomic<bool> stop{false};
  std::atomic<int> published{0};
  int updates = 0, ends = 0;
};

class Hello : public WorldPlugin
{
 public:
  void Load(physics::WorldPtr _world, sdf::ElementPtr) override { gzmsg << "Hello " << _world->Name() << std::endl; }
};
class Watcher : public ImuSensorPlugin
{
  void OnUpdate(sensors::ImuSensorPtr imu) override
  {
    EXPECT(imu == this->parentSensor);
    gzmsg << "imu " << imu->LinearAcceleration().Z() << std::endl;
  }
};
// A sensor of the plugin's own.
namespace gazebo {
namespace sensors {
class Counter : public Sensor
{
 public:
  Counter() : Sensor(sensors::RAY) { EXPECT(this->sdf && this->node && this->parentName.empty() && !this->active); }
  ~Counter() { gzmsg << this->Name() << " deleted" << std::endl; }
  void Load(const std::string &_world) override
  {
    Sensor::Load(_world);
    EXPECT(this->world == physics::get_world(_world) && this->parentName == this->ParentName() && this->node);
    EXPECT(this->sdf->Get<std::string>("topic") == "~/counts" && this->pose.Pos().X() == 1 && this->Type() == "counter");
    EXPECT(sensors::get_sensor(this->ScopedName()).get() == this && this->Category() == sensors::RAY);
    EXPECT(this->plugins.empty() && !this->scene && !this->useStrictRate && this->parentId == this->ParentId());
    sdf::ElementPtr noise(new sdf::Element);
    sdf::initFile("noise.sdf", noise);
    sdf::readString("<sdf version='1.6'><noise type='gaussian'><mean>0</mean><stddev>1</stddev></noise></sdf>", noise);
    this->noises[sensors::RAY_NOISE] = sensors::NoiseFactory::NewNoiseModel(noise);
    EXPECT(this->Noise(sensors::RAY_NOISE) == this->noises.begin()->second && !this->Noise(sensors::CAMERA_NOISE));
    this->publisher = this->node->Advertise<msgs::Int>(this->Topic());
  }
  void Init() override
  {
    Sensor::Init();
    EXPECT(this->updatePeriod == common::Time(0.01) && this->UpdateRate() == 100);
    gzmsg << "counter of " << this->world->EntityByName(this->ParentName())->GetScopedName() << std::endl;
  }
  void Fini() override
  {
    Sensor::Fini();
    gzmsg << "counter ends" << std::endl;
    throw std::runtime_error("no end");
  }
  std::string Topic() const override { return "~/" + this->Name() + "/counts"; }
  bool IsActive() const override { return Sensor::IsActive() && this->world->SimTime() > 0.045; }

 protected:
  bool UpdateImpl(const bool force) override
  {
    if (++this->count == 2)
      return false;
    EXPECT(this->count > 1 || force || this->NeedsUpdate());
    this->lastMeasurementTime = this->world->SimTime();
    gzmsg << "noise " << this->noises[sensors::RAY_NOISE]->Apply(0) << std::endl;
    msgs::Int message;
    message.set_data(force ? -this->count : this->count);
    this->publisher->Publish(message);
    return true;
  }

 private:
  int count = 0;
  transport::PublisherPtr publisher;
};
GZ_REGISTER_STATIC_SENSOR("counter", Counter)
}  // namespace sensors
}  // namespace gazebo

class System : public SystemPlugin
{
 public:
  void Load(int _argc, char **_argv) override
  {
    gzmsg << "system " << _argc << " " << _argv[_argc - 1] << std::endl;
    sensors::RegisterCounter();
    sensors::SensorFactory::RegisterSensor("nothing", []() -> sensors::Sensor * { return nullptr; });
  }
};
class Look : public VisualPlugin
{
 public:
  void Load(rendering::VisualPtr _visual, sdf::ElementPtr) override { gzmsg << "visual " << _visual->Name() << std::endl; }
};

// Plugins that are derived from plugins of Gazebo.
class Battery : public LinearBatteryPlugin
{
 public:
  void Load(physics::ModelPtr _model, sdf::ElementPtr _sdf) override
  {
    LinearBatteryPlugin::Load(_model, _sdf);
    EXPECT(this->q0 == 0.01 && this->q / this->q0 == 1.0 && this->c == 0.01 && this->r == 0.5 && this->tau == 0.05);
    EXPECT(this->link->GetName() == "arm" && this->battery->InitVoltage() == 12);
    this->consumer = this->battery->AddConsumer();
    this->battery->SetPowerLoad(this->consumer, 12);
    EXPECT(this->battery->PowerLoads().at(this->consumer) == 12);
    this->connection = event::Events::ConnectWorldUpdateEnd([this] {
      gzmsg << "used " << 1e6 * (this->q0 - this->q) << " " << this->ismooth << std::endl;
    });
  }
  uint32_t consumer;
  event::ConnectionPtr connection;
};
class Elevator : public ElevatorPlugin
{
 public:
  void Load(physics::ModelPtr _model, sdf::ElementPtr _sdf) override
  {
    ElevatorPlugin::Load(_model, _sdf);
    this->MoveToFloor(1);
  }
};
class Wheels : public WheelSlipPlugin
{
 public:
  void Load(physics::ModelPtr _model, sdf::ElementPtr _sdf) override
  {
    WheelSlipPlugin::Load(_model, _sdf);
    EXPECT(this->GetParentModel() == _model);
    this->SetSlipComplianceLateral(0.25);
    this->SetSlipComplianceLongitudinal("arm", 0.5);
    std::map<std::string, ignition::math::Vector3d> slips;
    this->GetSlips(slips);
    EXPECT(slips.size() == 1 && slips.at("arm") == ignition::math::Vector3d::Zero);
  }
};
class Winch : public HarnessPlugin
{
 public:
  void Load(physics::ModelPtr _model, sdf::ElementPtr _sdf) override
  {
    HarnessPlugin::Load(_model, _sdf);
    this->SetWinchVelocity(-0.5f);
    EXPECT(this->WinchVelocity() == -0.5);
    this->connection = event::Events::ConnectWorldUpdateEnd([this] {
      if (++this->steps == 1000)
        this->Detach();
    });
  }
  int steps = 0;
  event::ConnectionPtr connection;
};

// Each kind is a file of its own, linked with this one: see conftest.py.
libgz::PluginRoot *NewModel() { return new Checks; }
libgz::PluginRoot *NewWorld() { return new Hello; }
libgz::PluginRoot *NewSensor() { return new Watcher; }
libgz::PluginRoot *NewSystem() { return new System; }
libgz::PluginRoot *NewVisual() { return new Look; }
libgz::PluginRoot *NewBattery() { return new Battery; }
libgz::PluginRoot *NewElevator() { return new Elevator; }
libgz::PluginRoot *NewWheels() { return new Wheels; }
libgz::PluginRoot *NewWinch() { return new Winch; }
