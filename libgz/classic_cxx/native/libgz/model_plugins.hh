/* Plugins of models that plugins of users are derived from: libgz's ready ones do the work. License: Apache License 2.0. */
#ifndef LIBGZ_MODEL_PLUGINS_HH
#define LIBGZ_MODEL_PLUGINS_HH
#include "gazebo/libgz/gazebo.hh"

namespace gazebo {
/* In the library their symbols differ from those of plugins with a class of the same name, which are not to be replaced by them. */
inline namespace ready {

/* A plugin whose work a class of Python does. */
class GAZEBO_VISIBLE ReadyPlugin : public ModelPlugin
{
 public:
  void Load(physics::ModelPtr model, sdf::ElementPtr sdf) override;
  void Reset() override;

 protected:
  ReadyPlugin(const char *module, const char *name);
  libgz::Object ready;  // the plugin of Python
};

/* Brings an elevator to a floor. */
class GAZEBO_VISIBLE ElevatorPlugin : public ReadyPlugin
{
 public:
  ElevatorPlugin() : ReadyPlugin("_elevator", "ElevatorPlugin") {}
  void MoveToFloor(const int floor);
};

/* Holds a model by joints to the world, and lowers it by a winch. */
class GAZEBO_VISIBLE HarnessPlugin : public ReadyPlugin
{
 public:
  HarnessPlugin() : ReadyPlugin("_harness", "HarnessPlugin") {}
  void SetWinchVelocity(const float velocity);
  double WinchVelocity() const { return this->velocity; }
  void Detach();

 private:
  libgz::Field<double> velocity{&this->ready, "velocity"};
};

/* Computes the voltage of a battery from the loads on it; its numbers have the names of their formula. */
class GAZEBO_VISIBLE LinearBatteryPlugin : public ReadyPlugin
{
 public:
  LinearBatteryPlugin() : ReadyPlugin("_linear_battery", "LinearBatteryPlugin") {}
  void Load(physics::ModelPtr model, sdf::ElementPtr sdf) override;

 protected:
  physics::WorldPtr world;
  physics::PhysicsEnginePtr physics;
  physics::ModelPtr model;
  physics::LinkPtr link;
  common::BatteryPtr battery;
  sdf::ElementPtr sdf;
  libgz::Field<double> e0{&this->ready, "e0"}, e1{&this->ready, "e1"}, q0{&this->ready, "initial"};
  libgz::Field<double> c{&this->ready, "capacity"}, r{&this->ready, "resistance"}, tau{&this->ready, "tau"};
  libgz::Field<double> ismooth{&this->ready, "current"}, q{&this->ready, "charge"};
};

/* Lets wheels slip in proportion to force. */
class GAZEBO_VISIBLE WheelSlipPlugin : public ReadyPlugin
{
 public:
  WheelSlipPlugin() : ReadyPlugin("_wheelslip", "WheelSlipPlugin") {}
  void Load(physics::ModelPtr model, sdf::ElementPtr sdf) override;
  virtual void Fini() {}
  physics::ModelPtr GetParentModel() const { return this->model; }
  void GetSlips(std::map<std::string, ignition::math::Vector3d> &slips) const;
  void SetSlipComplianceLateral(const double compliance) { this->SetSlipComplianceLateral("", compliance); }
  void SetSlipComplianceLateral(std::string wheel, const double compliance);
  void SetSlipComplianceLongitudinal(const double compliance) { this->SetSlipComplianceLongitudinal("", compliance); }
  void SetSlipComplianceLongitudinal(std::string wheel, const double compliance);

 private:
  physics::ModelPtr model;
};
}  // namespace ready
}  // namespace gazebo
#endif
