"""What C++ plugins cost: a call of the old API above the Python method itself, and an empty Update.

Of classic's API: calls that plugins make in every step, by a plugin that measures itself; an empty OnUpdate; what a
differential drive adds to a step.

    python benchmarks/cxx.py [classic]

Processor time of both in turn within one run; the median of their differences.
"""

from __future__ import annotations

import functools
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import libgz
from libgz.classic_cxx import build as classic
from libgz.cxx.build import build

ROUNDS = 100
CALLS = 500  # in an Update
MOST_CALL, MOST_UPDATE = 2.0, 3.0  # [us]
STEPS = 300
# Name, C++, Python.
METHODS = (
    ("Body::GetPose", "this->body->GetPose()", "body.GetPose()"),
    ("Body::GetPosition", "this->body->GetPosition()", "body.GetPosition()"),
    ("Body::SetLinearVel", "this->body->SetLinearVel( v )", "body.SetLinearVel(v)"),
    ("Body::AddForce", "this->body->AddForce( 0, 0, 0 )", "body.AddForce(0, 0, 0)"),
    ("HingeJoint::GetAngleRate", "this->joint1->GetAngleRate()", "joint.GetAngleRate()"),
    ("HingeJoint::SetParam", "this->joint1->SetParam( dParamVel, 1 )", "joint.SetParam(vel, 1)"),
    ("World::GetSimTime", "this->world->GetSimTime()", "world.GetSimTime()"),
    ("Geom::SetMass", "this->geom->SetMass( 1 )", "geom.SetMass(1)"),
    (
        "gz_position_lock, unlock",
        "gz_position_lock( this->iface, 1 ); gz_position_unlock( this->iface )",
        "iface.lock(); iface.unlock()",
    ),
)
SOURCE = """
#include <gazebo.h>
#include <gazebo/World.hh>
#include <gazebo/WorldFile.hh>
#include <gazebo/ModelFactory.hh>
#include <gazebo/SphereGeom.hh>
#include <gazebo/HingeJoint.hh>

class Calls : public Model
{
  public: Calls( World *world ) : Model( world ) {}
  public: int Load( WorldFile *, WorldFileNode *node )
    {
      this->which = node->GetInt( "which", -1 );
      this->body = new Body( this->world );
      this->geom = new SphereGeom( this->body, this->modelSpaceId, 0.1 );
      this->geom->SetMass( 1 );
      this->AddBody( this->body, true );
      Body *other = new Body( this->world );
      ( new SphereGeom( other, this->modelSpaceId, 0.1 ) )->SetMass( 1 );
      this->AddBody( other );
      this->joint1 = new HingeJoint( this->world );
      this->joint1->Attach( other, this->body );
      this->joint1->SetAxis( GzVectorSet( 0, 0, 1 ) );
      return 0;
    }
  public: int Init( WorldFile *, WorldFileNode * )
    {
      this->iface = gz_position_alloc();
      return gz_position_create( this->iface, this->world->gz_server, this->GetId(), "Calls", 1, 0 );
    }
  public: int Fini() { return gz_position_destroy( this->iface ); }
  public: void Update( double )
    {
      GzVector v = { 0, 0, 0 };
      if ( this->which < 0 )
        return;
      for ( int i = 0; i < COUNT; i++ )
        switch ( this->which )
        {
          CASES
        }
    }
  private: int which;
  private: Body *body;
  private: Geom *geom;
  private: HingeJoint *joint1;
  private: gz_position_t *iface;
};
GZ_REGISTER_PLUGIN( "Calls", Calls )
"""
WORLD = """<gz:world xmlns:gz='g' xmlns:model='m'>
<model:Calls><id>m</id><plugin>Calls.so</plugin><which>{}</which></model:Calls></gz:world>"""

# Of classic: a call, and the most that it may cost [us].
READ, APPLY = 0.1, 0.2
CLASSIC = (
    *(
        (call, READ)
        for call in (
            "link->WorldPose()",
            "model->WorldPose()",
            "link->WorldLinearVel()",
            "link->WorldAngularVel()",
            "link->RelativeLinearVel()",
            "link->RelativeAngularVel()",
            "link->WorldCoGPose()",
            "link->WorldCoGLinearVel()",
            "joint->Position(0)",
            "joint->GetVelocity(0)",
            "joint->GetForce(0)",
            'joint->GetParam("vel", 0)',
            "world->SimTime()",
            "joint->SetForce(0, 0.0)",
        )
    ),
    *(
        (call, APPLY)
        for call in (
            "link->AddForce(v)",
            "link->AddTorque(v)",
            "link->AddRelativeForce(v)",
            "link->AddRelativeTorque(v)",
            "link->AddLinkForce(v)",
            "link->AddForceAtWorldPosition(v, v)",
            "link->AddForceAtRelativePosition(v, v)",
            'joint->SetParam("vel", 0, 0.0)',
            'joint->SetParam("fmax", 0, 0.0)',
            'joint->SetParam("friction", 0, 0.0)',
        )
    ),
    ("link->GetName()", 1.0),
)
MOST_EMPTY = 0.3  # [us], of an empty OnUpdate
MOST_DRIVE = 60.0  # [us], of a differential drive in a step
PAIRS, DRIVE_STEPS = 30, 500
CLASSIC_SOURCE = """
#include <gazebo/gazebo.hh>
#include <gazebo/physics/physics.hh>
#include <time.h>

static double Now()
{
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return t.tv_sec * 1e6 + t.tv_nsec * 1e-3;
}
using namespace gazebo;
class Calls : public ModelPlugin
{
 public:
  void Load(physics::ModelPtr _model, sdf::ElementPtr _sdf)
  {
    this->model = _model;
    this->link = _model->GetLink("b");
    this->joint = _model->GetJoint("j");
    this->world = _model->GetWorld();
    this->measures = _sdf->Get<int>("measure") > 0;
    this->connection = event::Events::ConnectWorldUpdateBegin(std::bind(&Calls::OnUpdate, this));
  }
  void OnUpdate()
  {
    if (!this->measures || ++this->updates < 50)
      return;
    ignition::math::Vector3d v;
    double start;
    CASES
    this->connection.reset();
  }
  physics::ModelPtr model;
  physics::LinkPtr link;
  physics::JointPtr joint;
  physics::WorldPtr world;
  event::ConnectionPtr connection;
  bool measures = false;
  int updates = 0;
};
GZ_REGISTER_MODEL_PLUGIN(Calls)
"""
CLASSIC_CASE = """
start = Now();
for (int i = 0; i < COUNT; ++i) CALL;
std::cout << NUMBER << " " << (Now() - start) / COUNT << std::endl;
"""
CLASSIC_WORLD = """<sdf version="1.6"><world name="default"><gravity>0 0 0</gravity><model name="m">
<link name="a"/><link name="b"><pose>0 0 1 0 0 0</pose></link>
<joint name="j" type="revolute"><parent>a</parent><child>b</child><axis><xyz>0 0 1</xyz></axis></joint>
{}</model></world></sdf>"""
PLUGIN = '<plugin name="calls" filename="{}/libcalls.so"><measure>{}</measure></plugin>'


DRIVE_SOURCE = """
#include <gazebo/gazebo.hh>
#include <gazebo/physics/physics.hh>
#include <gazebo/transport/transport.hh>

using namespace gazebo;
class Drive : public ModelPlugin
{
 public:
  void Load(physics::ModelPtr _model, sdf::ElementPtr)
  {
    this->model = _model;
    this->left = _model->GetJoint("left");
    this->right = _model->GetJoint("right");
    this->node = transport::NodePtr(new transport::Node());
    this->node->Init(_model->GetWorld()->Name());
    this->commands = this->node->Subscribe("~/vel_cmd", &Drive::OnCommand, this);
    this->odometry = this->node->Advertise<msgs::Pose>("~/odometry");
    this->connection = event::Events::ConnectWorldUpdateBegin(std::bind(&Drive::OnUpdate, this, std::placeholders::_1));
  }
  void OnCommand(ConstPosePtr &_message)
  {
    std::lock_guard<std::mutex> lock(this->mutex);
    this->speed = _message->position().x();
    this->turn = msgs::ConvertIgn(_message->orientation()).Yaw();
  }
  void OnUpdate(const common::UpdateInfo &_info)
  {
    const double dt = (_info.simTime - this->last).Double(), radius = 0.1, separation = 0.4;
    this->last = _info.simTime;
    std::lock_guard<std::mutex> lock(this->mutex);
    const double v[2] = {this->speed - this->turn * separation / 2, this->speed + this->turn * separation / 2};
    const physics::JointPtr wheels[2] = {this->left, this->right};
    for (int i = 0; i < 2; ++i)
    {
      wheels[i]->SetParam("fmax", 0, 5.0);
      wheels[i]->SetParam("vel", 0, v[i] / radius);
      this->way[i] += wheels[i]->GetVelocity(0) * radius * dt;
    }
    const ignition::math::Pose3d pose = this->model->WorldPose();
    const ignition::math::Vector3d velocity = this->model->WorldLinearVel();
    this->moved += velocity.Length() * dt;
    if ((_info.simTime - this->published).Double() >= 0.02)
    {
      msgs::Pose message;
      msgs::Set(&message, pose);
      this->odometry->Publish(message);
      this->published = _info.simTime;
    }
  }
  physics::ModelPtr model;
  physics::JointPtr left, right;
  transport::NodePtr node;
  transport::SubscriberPtr commands;
  transport::PublisherPtr odometry;
  event::ConnectionPtr connection;
  common::Time last, published;
  std::mutex mutex;
  double speed = 0.2, turn = 0.1, way[2] = {}, moved = 0.0;
};
GZ_REGISTER_MODEL_PLUGIN(Drive)
"""
WHEEL = """<link name="{name}_wheel"><pose>0 {y} 0.1 -1.5708 0 0</pose><inertial><mass>1</mass></inertial>
<collision name="c"><geometry><cylinder><radius>0.1</radius><length>0.05</length></cylinder></geometry>
</collision></link>
<joint name="{name}" type="revolute"><parent>base</parent><child>{name}_wheel</child>
<axis><xyz>0 1 0</xyz><use_parent_model_frame>1</use_parent_model_frame></axis></joint>"""
DRIVE_WORLD = """<sdf version="1.6"><world name="default"><model name="ground"><static>1</static><link name="l">
<collision name="c"><geometry><plane><normal>0 0 1</normal></plane></geometry></collision></link></model>
<model name="robot"><link name="base"><pose>0.05 0 0.1 0 0 0</pose><inertial><mass>5</mass></inertial>
<collision name="c"><pose>0.1 0 -0.05 0 0 0</pose><geometry><sphere><radius>0.05</radius></sphere></geometry>
</collision></link>{wheels}{plugin}</model></world></sdf>"""


def _drive(folder: Path) -> bool:
    """Print what a differential drive adds to a step; whether that exceeds its limit."""
    (folder / "drive.cc").write_text(DRIVE_SOURCE)
    errors = classic.build([folder / "drive.cc"], folder / "libdrive.so")
    if errors:
        print(*errors, sep="\n", file=sys.stderr)
        return True
    wheels = "".join(WHEEL.format(name=name, y=y) for name, y in (("left", 0.2), ("right", -0.2)))
    plugin = f'<plugin name="drive" filename="{folder}/libdrive.so"/>'
    texts = [DRIVE_WORLD.format(wheels=wheels, plugin=text) for text in (plugin, "")]
    with libgz.World.from_string(texts[0]) as driven, libgz.World.from_string(texts[1]) as still:
        for world in (driven, still):
            world.step(DRIVE_STEPS)
        pairs = [
            (_time(lambda: driven.step(DRIVE_STEPS)), _time(lambda: still.step(DRIVE_STEPS))) for _ in range(PAIRS)
        ]
        far = driven.models[1].GetPose().pos.x
    cost = 1e6 * statistics.median(one - other for one, other in pairs) / DRIVE_STEPS
    print(f"{'a differential drive, a step':32} C++ {cost:6.2f} us (at most {MOST_DRIVE:g}), {far:.2f} m")
    return cost > MOST_DRIVE or abs(far) < 0.1


def _classic(folder: Path) -> bool:
    """Print the rows of classic; whether one exceeds its limit."""
    cases = "".join(
        CLASSIC_CASE.replace("CALL", call).replace("NUMBER", str(i)).replace("COUNT", "20000")
        for i, (call, _) in enumerate(CLASSIC)
    )
    (folder / "calls.cc").write_text(CLASSIC_SOURCE.replace("CASES", cases))
    errors = classic.build([folder / "calls.cc"], folder / "libcalls.so")
    if errors:
        print(*errors, sep="\n", file=sys.stderr)
        return True
    (folder / "w.world").write_text(CLASSIC_WORLD.format(PLUGIN.format(folder, 1)))
    program = "import libgz, sys\nwith libgz.World.from_file(sys.argv[1]) as world: world.step(60)"
    done = subprocess.run(
        [sys.executable, "-c", program, str(folder / "w.world")], capture_output=True, text=True, check=True
    )
    failed = False
    for line in done.stdout.splitlines():
        number, cost = line.split()
        call, most = CLASSIC[int(number)]
        failed |= float(cost) > most
        print(f"{call:32} C++ {float(cost):6.3f} us (at most {most:g})")
    with libgz.World.from_string(CLASSIC_WORLD.format(PLUGIN.format(folder, 0))) as world:
        world.step(10)
        (entry,) = world.events["WorldUpdateBegin"].own
        empty = 1e6 * min(_time(entry.callback, CALLS) for _ in range(ROUNDS))
    failed |= empty > MOST_EMPTY
    print(f"{'an empty OnUpdate':32} C++ {empty:6.3f} us (at most {MOST_EMPTY:g})")
    return failed


def _time(work: Callable[[], object], count: int = 1) -> float:
    start = time.process_time()
    for _ in range(count):
        work()
    return (time.process_time() - start) / count


def main() -> int:
    """Print the table; 1 if a figure exceeds its limit."""
    failed = False
    if "classic" in sys.argv[1:]:
        with tempfile.TemporaryDirectory() as name:
            return int(_classic(Path(name)) | _drive(Path(name)))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        cases = "".join(f"case {i}: {code}; break;\n" for i, (_, code, _) in enumerate(METHODS))
        (folder / "Calls.cc").write_text(SOURCE.replace("CASES", cases).replace("COUNT", str(CALLS)))
        errors = build([folder / "Calls.cc"], folder / "Calls.so")
        if errors:
            print(*errors, sep="\n", file=sys.stderr)
            return 2
        for which, (title, _, code) in enumerate(METHODS):
            (folder / "w.world").write_text(WORLD.format(which))
            with libgz.World.from_file(folder / "w.world") as world:
                model = world.models[0]
                names = {
                    "body": model.GetBody(),
                    "geom": model.GetBody().geoms[0],
                    "joint": model.joints[0],
                    "world": world,
                    "iface": world.interface("position", "m"),
                    "vel": libgz.dParamVel,
                    "v": libgz.GzVector(),
                }
                exec(f"def calls():\n    for i in range({CALLS}):\n        {code}", names)
                update = functools.partial(model.Update, 0.02)
                samples = [(_time(update), _time(names["calls"])) for _ in range(ROUNDS)]
            calls = CALLS * code.count("(")
            cxx, python = (1e6 * statistics.median(column) / calls for column in zip(*samples, strict=True))
            difference = 1e6 * statistics.median(one - other for one, other in samples) / calls
            failed |= difference > MOST_CALL
            above = f"{difference:5.2f} us above (at most {MOST_CALL:g})"
            print(f"{title:26} C++ {cxx:5.2f} us, Python {python:5.2f} us: {above}")
        (folder / "w.world").write_text(WORLD.format(-1))
        with libgz.World.from_file(folder / "w.world") as world:
            model = world.models[0]
            update = functools.partial(model.Update, 0.02)
            empty = 1e6 * statistics.median(_time(update, STEPS) for _ in range(ROUNDS))
        failed |= empty > MOST_UPDATE
        print(f"{'an empty Update':26} {empty:5.2f} us (at most {MOST_UPDATE:g})")
        failed |= _classic(folder)
        failed |= _drive(folder)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
