// Publishes the commands of FOLLOW_COMMANDS, lines of "iteration topic x yaw", at the ends of iterations; after the last
// one, FOLLOW_STEPS, writes the positions and rotations of all links into FOLLOW_FILE and ends the process.
#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <unistd.h>

#include <gazebo/gazebo.hh>
#include <gazebo/physics/physics.hh>
#include <gazebo/transport/transport.hh>

using namespace gazebo;

class Follow : public WorldPlugin {
  struct Command {
    int iteration;
    std::string topic;
    double x, yaw;
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
    Command c;
    while (lines >> c.iteration >> c.topic >> c.x >> c.yaw) {
      c.publisher = node->Advertise<msgs::Pose>(c.topic);
      commands.push_back(c);
    }
    connection = event::Events::ConnectWorldUpdateEnd(std::bind(&Follow::End, this));
  }

  void Write(FILE *file, physics::ModelPtr model) {
    for (auto link : model->GetLinks()) {
      auto p = link->WorldPose();
      fprintf(file, "%s\t%.12g\t%.12g\t%.12g\t%.12g\t%.12g\t%.12g\t%.12g\n", link->GetScopedName().c_str(), p.Pos().X(),
              p.Pos().Y(), p.Pos().Z(), p.Rot().W(), p.Rot().X(), p.Rot().Y(), p.Rot().Z());
    }
    for (auto nested : model->NestedModels())
      Write(file, nested);
  }

  void End() {
    for (auto &c : commands)
      if (c.iteration == iteration) {
        msgs::Pose message;
        msgs::Set(&message, ignition::math::Pose3d(c.x, 0, 0, 0, 0, c.yaw));
        c.publisher->Publish(message);
        usleep(200000); // Gazebo delivers it in another thread
      }
    if (++iteration < atoi(getenv("FOLLOW_STEPS")))
      return;
    FILE *file = fopen(getenv("FOLLOW_FILE"), "w");
    for (auto model : world->Models())
      Write(file, model);
    fclose(file);
    _exit(0);
  }
};
GZ_REGISTER_WORLD_PLUGIN(Follow)
