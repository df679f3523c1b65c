/* The physics engine by ODE's names of its parameters, and the factory of sensors. License: Apache License 2.0. */
#ifndef LIBGZ_ODE_HH
#define LIBGZ_ODE_HH
#include "gazebo/libgz/classes.hh"

namespace gazebo {
namespace physics {

class GAZEBO_VISIBLE ODEPhysics : public PhysicsEngine
{
 public:
  explicit ODEPhysics(libgz::Adopt view) : PhysicsEngine(view) {}
  virtual double GetWorldCFM() { return this->Number<double>("cfm"); }
  virtual double GetWorldERP() { return this->Number<double>("erp"); }
  virtual int GetSORPGSPreconIters() { return this->Number<int>("precon_iters"); }
  virtual int GetSORPGSIters() { return this->Number<int>("iters"); }
  virtual double GetSORPGSW() { return this->Number<double>("sor"); }
  virtual double GetContactMaxCorrectingVel() { return this->Number<double>("contact_max_correcting_vel"); }
  virtual double GetContactSurfaceLayer() { return this->Number<double>("contact_surface_layer"); }
  virtual unsigned int GetMaxContacts() { return this->Number<unsigned int>("max_contacts"); }
  virtual std::string GetFrictionModel() const { return this->Number<std::string>("friction_model"); }
  virtual std::string GetWorldStepSolverType() const { return this->Number<std::string>("world_step_solver"); }
  virtual std::string GetStepType() const { return this->Number<std::string>("solver_type"); }
  virtual void SetWorldCFM(double value) { this->SetParam("cfm", value); }
  virtual void SetWorldERP(double value) { this->SetParam("erp", value); }
  virtual void SetSORPGSPreconIters(unsigned int value) { this->SetParam("precon_iters", static_cast<int>(value)); }
  virtual void SetSORPGSIters(unsigned int value) { this->SetParam("iters", static_cast<int>(value)); }
  virtual void SetSORPGSW(double value) { this->SetParam("sor", value); }
  virtual void SetContactMaxCorrectingVel(double value) { this->SetParam("contact_max_correcting_vel", value); }
  virtual void SetContactSurfaceLayer(double value) { this->SetParam("contact_surface_layer", value); }
  virtual void SetMaxContacts(unsigned int value) { this->SetParam("max_contacts", static_cast<int>(value)); }
  virtual void SetFrictionModel(const std::string &name) { this->SetParam("friction_model", name); }
  virtual void SetWorldStepSolverType(const std::string &name) { this->SetParam("world_step_solver", name); }
  virtual void SetStepType(const std::string &name) { this->SetParam("solver_type", name); }

 private:
  template <typename T>
  T Number(const std::string &name) const
  {
    return PhysicsEngine::any_cast<T>(this->GetParam(name));
  }
};
typedef boost::shared_ptr<ODEPhysics> ODEPhysicsPtr;
}  // namespace physics

namespace sensors {
typedef Sensor *(*SensorFactoryFn)();
class GAZEBO_VISIBLE SensorFactory
{
 public:
  /* Let worlds that are loaded from now on make sensors of a type: classes that are derived from Sensor. */
  static void RegisterSensor(const std::string &type, SensorFactoryFn factory);
  static void GetSensorTypes(std::vector<std::string> &types) { SensorManager::Instance()->GetSensorTypes(types); }
};
}  // namespace sensors
}  // namespace gazebo

#define GZ_REGISTER_STATIC_SENSOR(type, classname) \
  GAZEBO_VISIBLE gazebo::sensors::Sensor *New##classname() { return new gazebo::sensors::classname(); } \
  GAZEBO_VISIBLE void Register##classname() \
  { \
    gazebo::sensors::SensorFactory::RegisterSensor(type, New##classname); \
  }
#endif
