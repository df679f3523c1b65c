// Publishes the commands of FOLLOW_COMMANDS, lines of "iteration topic x yaw" for a Pose or "iteration topic text" for a
// GzString, at the ends of iterations; after the last one, FOLLOW_STEPS, writes the positions and rotations of all links, and what sensors measure, into FOLLOW_FILE and ends
// the process.
#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <unistd.h>

#include <gazebo/gazebo.hh>
#include <gazebo/physics/physics.hh>
#include <gazebo/sensors/sensors.hh>
#include <gazebo/transport/transport.hh>

using namespace gazebo;

class Follow : public WorldPlugin {
  struct Command {
    int iteration;
    std::string topic, text;
    double x, yaw;
    bool pose;
    transport::PublisherPtr publisher;
  };
  physics::WorldPtr world;
  transport::NodePtr node;
  event::ConnectionPtr connection;
  std::vector<Command> commands;
  int iteration = 0;

public:
  void Load(physics::WorldPtr _world, sdf::ElementPtr) override {
    world = _world;
    node = transport::NodePtr(new transport::Node());
    node->Init(world->Name());
    std::istringstream lines(getenv("FOLLOW_COMMANDS"));
    for (std::string line; std::getline(lines, line);) {
      std::istringstream words(line), numbers;
      Command c;
      words >> c.iteration >> c.topic >> c.text;
      numbers.str(c.text);
      c.pose = numbers >> c.x && words >> c.yaw;
      c.publisher = c.pose ? node->Advertise<msgs::Pose>(c.topic) : node->Advertise<msgs::GzString>(c.topic);
      commands.push_back(c);
    }
    connection = event::Events::ConnectWorldUpdateEnd(std::bind(&Follow::End, this));
  }

  void Write(FILE *file, const std::string &name, std::vector<double> numbers) {
    numbers.resize(7);
    fprintf(file, "%s", name.c_str());
    for (double number : numbers)
      fprintf(file, "\t%.12g", number);
    fprintf(file, "\n");
  }

  void Write(FILE *file, physics::ModelPtr model) {
    for (auto link : model->GetLinks()) {
      auto p = link->WorldPose();
      Write(file, link->GetScopedName(),
            {p.Pos().X(), p.Pos().Y(), p.Pos().Z(), p.Rot().W(), p.Rot().X(), p.Rot().Y(), p.Rot().Z()});
    }
    for (auto nested : model->NestedModels())
      Write(file, nested);
  }

  void Write(FILE *file, sensors::SensorPtr sensor) {
    auto name = "sensor " + sensor->Name();
    if (auto imu = std::dynamic_pointer_cast<sensors::ImuSensor>(sensor)) {
      auto a = imu->LinearAcceleration(), w = imu->AngularVelocity();
      Write(file, name, {a.X(), a.Y(), a.Z(), w.X(), w.Y(), w.Z()});
    } else if (auto torque = std::dynamic_pointer_cast<sensors::ForceTorqueSensor>(sensor)) {
      auto f = torque->Force(), t = torque->Torque();
      Write(file, name, {f.X(), f.Y(), f.Z(), t.X(), t.Y(), t.Z()});
    } else if (auto ray = std::dynamic_pointer_cast<sensors::RaySensor>(sensor)) {
      Write(file, name, {ray->Range(0), ray->Range(1), ray->Range(2), double(ray->RangeCount())});
    } else if (auto sonar = std::dynamic_pointer_cast<sensors::SonarSensor>(sensor)) {
      Write(file, name, {sonar->Range()});
    } else if (auto contact = std::dynamic_pointer_cast<sensors::ContactSensor>(sensor)) {
      Write(file, name, {double(contact->Contacts().contact_size() > 0)});
    }
  }

  void End() {
    for (auto &c : commands)
      if (c.iteration == iteration) {
        msgs::Pose pose;
        msgs::GzString text;
        msgs::Set(&pose, ignition::math::Pose3d(c.x, 0, 0, 0, 0, c.yaw));
        text.set_data(c.text);
        if (c.pose)
          c.publisher->Publish(pose);
        else
          c.publisher->Publish(text);
        usleep(200000); // Gazebo delivers it in another thread
      }
    if (++iteration < atoi(getenv("FOLLOW_STEPS")))
      return;
    FILE *file = fopen(getenv("FOLLOW_FILE"), "w");
    for (auto model : world->Models())
      Write(file, model);
    for (auto sensor : sensors::SensorManager::Instance()->GetSensors())
      Write(file, sensor);
    fclose(file);
    _exit(0);
  }
};
GZ_REGISTER_WORLD_PLUGIN(Follow)
