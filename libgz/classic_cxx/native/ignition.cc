// Commands of joints by ignition-transport, as Gazebo 11's servers take them. License: Apache License 2.0.
//
// A shared object of its own, which is built where ignition-transport is installed. Messages become those of classic.
#include <functional>
#include <memory>
#include <string>

#include <ignition/msgs/joint_cmd.pb.h>
#include <ignition/msgs/stringmsg.pb.h>
#include <ignition/transport/Node.hh>

#include <gazebo/msgs/joint_cmd.pb.h>

namespace {
using ignition::transport::MessageInfo;

/* A command for a model, as an encoded message of classic; whether it comes from this process. */
typedef void (*Command)(const char *model, const char *data, size_t size, int inside);
/* What is set for a joint: libgz_ignition_reply is called with it. Whether the joint is known. */
typedef int (*Request)(const char *model, const char *joint, void *reply);

void copy(const ignition::msgs::PID &from, gazebo::msgs::PID *to)
{
  if (from.has_target_optional())
    to->set_target(from.target_optional().data());
  if (from.has_p_gain_optional())
    to->set_p_gain(from.p_gain_optional().data());
  if (from.has_i_gain_optional())
    to->set_i_gain(from.i_gain_optional().data());
  if (from.has_d_gain_optional())
    to->set_d_gain(from.d_gain_optional().data());
  if (from.has_i_max_optional())
    to->set_i_max(from.i_max_optional().data());
  if (from.has_i_min_optional())
    to->set_i_min(from.i_min_optional().data());
  if (from.has_limit_optional())
    to->set_limit(from.limit_optional().data());
}

void copy(const gazebo::msgs::PID &from, ignition::msgs::PID *to)
{
  if (from.has_target())
    to->mutable_target_optional()->set_data(from.target());
  if (from.has_p_gain())
    to->mutable_p_gain_optional()->set_data(from.p_gain());
  if (from.has_i_gain())
    to->mutable_i_gain_optional()->set_data(from.i_gain());
  if (from.has_d_gain())
    to->mutable_d_gain_optional()->set_data(from.d_gain());
}

/* The joints of a model: its topic and its service. */
class Joints {
  ignition::transport::Node node;
  std::string model;
  Command command;
  Request request;

  void OnCommand(const ignition::msgs::JointCmd &from, const MessageInfo &info)
  {
    gazebo::msgs::JointCmd to;
    to.set_name(from.name());
    to.set_axis(from.axis());
    if (from.reset())
      to.set_reset(true);
    if (from.has_force_optional())
      to.set_force(from.force_optional().data());
    if (from.has_position())
      copy(from.position(), to.mutable_position());
    if (from.has_velocity())
      copy(from.velocity(), to.mutable_velocity());
    std::string data = to.SerializeAsString();
    command(model.c_str(), data.data(), data.size(), info.IntraProcess());
  }

  bool OnRequest(const ignition::msgs::StringMsg &from, ignition::msgs::JointCmd &to)
  {
    to.set_name(from.data());
    return request(model.c_str(), from.data().c_str(), &to) != 0;
  }

public:
  Joints(const char *name, Command c, Request r) : model(name), command(c), request(r) {}

  bool Open()
  {
    using namespace std::placeholders;
    const std::string topic = "/" + model + "/joint_cmd";
    std::function<void(const ignition::msgs::JointCmd &, const MessageInfo &)> on_command =
        std::bind(&Joints::OnCommand, this, _1, _2);
    std::function<bool(const ignition::msgs::StringMsg &, ignition::msgs::JointCmd &)> on_request =
        std::bind(&Joints::OnRequest, this, _1, _2);
    return node.Subscribe(topic, on_command) && node.Advertise(topic + "_req", on_request);
  }
};
}  // namespace

/* Opens the topic and the service of a model; NULL if ignition-transport refuses its name. */
extern "C" void *libgz_ignition_open(const char *model, Command command, Request request)
{
  auto joints = std::make_unique<Joints>(model, command, request);
  return joints->Open() ? joints.release() : nullptr;
}

extern "C" void libgz_ignition_close(void *joints)
{
  delete static_cast<Joints *>(joints);
}

/* Fills the reply of a request with an encoded message of classic. */
extern "C" void libgz_ignition_reply(void *reply, const char *data, size_t size)
{
  auto *to = static_cast<ignition::msgs::JointCmd *>(reply);
  gazebo::msgs::JointCmd from;
  if (!from.ParseFromArray(data, static_cast<int>(size)))
    return;
  if (from.has_force())
    to->mutable_force_optional()->set_data(from.force());
  if (from.has_position())
    copy(from.position(), to->mutable_position());
  if (from.has_velocity())
    copy(from.velocity(), to->mutable_velocity());
}
