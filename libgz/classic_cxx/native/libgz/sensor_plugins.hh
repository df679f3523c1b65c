/* Plugins of sensors that plugins of users are derived from. License: Apache License 2.0. */
#ifndef LIBGZ_SENSOR_PLUGINS_HH
#define LIBGZ_SENSOR_PLUGINS_HH
#include "gazebo/libgz/gazebo.hh"

namespace gazebo {

/* Gives each image of a camera to OnNewFrame. */
class GAZEBO_VISIBLE CameraPlugin : public SensorPlugin
{
 public:
  void Load(sensors::SensorPtr sensor, sdf::ElementPtr) override
  {
    this->parentSensor = std::dynamic_pointer_cast<sensors::CameraSensor>(sensor);
    if (!this->parentSensor)
      gzthrow("a CameraPlugin belongs to a camera, and its sensor is none");
    this->camera = this->parentSensor->Camera();
    this->width = this->camera->ImageWidth();
    this->height = this->camera->ImageHeight();
    this->depth = this->camera->ImageDepth();
    this->format = this->camera->ImageFormat();
    this->newFrameConnection = this->camera->ConnectNewImageFrame(
        [this](const unsigned char *image, unsigned int w, unsigned int h, unsigned int d, const std::string &f) {
          this->OnNewFrame(image, w, h, d, f);
        });
    this->parentSensor->SetActive(true);
  }
  virtual void OnNewFrame(
      const unsigned char *, unsigned int, unsigned int, unsigned int, const std::string &)
  {
  }

 protected:
  unsigned int width = 0, height = 0, depth = 0;
  std::string format;
  sensors::CameraSensorPtr parentSensor;
  rendering::CameraPtr camera;

 private:
  event::ConnectionPtr newFrameConnection;
};

/* Gives each depth image, cloud of points and image of a depth camera to its methods. */
class GAZEBO_VISIBLE DepthCameraPlugin : public SensorPlugin
{
 public:
  void Load(sensors::SensorPtr sensor, sdf::ElementPtr) override
  {
    this->parentSensor = std::dynamic_pointer_cast<sensors::DepthCameraSensor>(sensor);
    if (!this->parentSensor)
      gzthrow("a DepthCameraPlugin belongs to a depth camera, and its sensor is none");
    this->depthCamera = this->parentSensor->DepthCamera();
    this->width = this->depthCamera->ImageWidth();
    this->height = this->depthCamera->ImageHeight();
    this->depth = this->depthCamera->ImageDepth();
    this->format = this->depthCamera->ImageFormat();
    this->newDepthFrameConnection = this->depthCamera->ConnectNewDepthFrame(
        [this](const float *image, unsigned int w, unsigned int h, unsigned int d, const std::string &f) {
          this->OnNewDepthFrame(image, w, h, d, f);
        });
    this->newRGBPointCloudConnection = this->depthCamera->ConnectNewRGBPointCloud(
        [this](const float *points, unsigned int w, unsigned int h, unsigned int d, const std::string &f) {
          this->OnNewRGBPointCloud(points, w, h, d, f);
        });
    this->newImageFrameConnection = this->depthCamera->ConnectNewImageFrame(
        [this](const unsigned char *image, unsigned int w, unsigned int h, unsigned int d, const std::string &f) {
          this->OnNewImageFrame(image, w, h, d, f);
        });
    this->parentSensor->SetActive(true);
  }
  virtual void OnNewDepthFrame(const float *, unsigned int, unsigned int, unsigned int, const std::string &) {}
  virtual void OnNewRGBPointCloud(const float *, unsigned int, unsigned int, unsigned int, const std::string &) {}
  virtual void OnNewImageFrame(
      const unsigned char *, unsigned int, unsigned int, unsigned int, const std::string &)
  {
  }

 protected:
  unsigned int width = 0, height = 0, depth = 0;
  std::string format;
  sensors::DepthCameraSensorPtr parentSensor;
  rendering::DepthCameraPtr depthCamera;

 private:
  event::ConnectionPtr newDepthFrameConnection, newRGBPointCloudConnection, newImageFrameConnection;
};

/* Calls OnNewLaserScans after each scan of a ray sensor. */
class GAZEBO_VISIBLE RayPlugin : public SensorPlugin
{
 public:
  void Load(sensors::SensorPtr sensor, sdf::ElementPtr) override
  {
    this->parentSensor = std::dynamic_pointer_cast<sensors::RaySensor>(sensor);
    if (!this->parentSensor)
      gzthrow("a RayPlugin belongs to a ray sensor, and its sensor is none");
    this->world = physics::get_world(this->parentSensor->WorldName());
    this->newLaserScansConnection = this->parentSensor->LaserShape()->ConnectNewLaserScans([this] { this->OnNewLaserScans(); });
    this->parentSensor->SetActive(true);
  }
  virtual void OnNewLaserScans() {}

 protected:
  physics::WorldPtr world;
  sensors::RaySensorPtr parentSensor;

 private:
  event::ConnectionPtr newLaserScansConnection;
};

/* Gives each scan of a gpu_ray sensor to OnNewLaserFrame. */
class GAZEBO_VISIBLE GpuRayPlugin : public SensorPlugin
{
 public:
  void Load(sensors::SensorPtr sensor, sdf::ElementPtr) override
  {
    this->parentSensor = std::dynamic_pointer_cast<sensors::GpuRaySensor>(sensor);
    if (!this->parentSensor)
      gzthrow("a GpuRayPlugin belongs to a gpu_ray sensor, and its sensor is none");
    this->newLaserFrameConnection = this->parentSensor->ConnectNewLaserFrame(
        [this](const float *image, unsigned int w, unsigned int h, unsigned int d, const std::string &f) {
          this->OnNewLaserFrame(image, w, h, d, f);
        });
    this->parentSensor->SetActive(true);
  }
  virtual void OnNewLaserFrame(const float *, unsigned int, unsigned int, unsigned int, const std::string &) {}

 protected:
  unsigned int width = 0, height = 0, depth = 0;
  std::string format;
  sensors::GpuRaySensorPtr parentSensor;

 private:
  event::ConnectionPtr newLaserFrameConnection;
};

/* Calls OnUpdate after each measurement of a contact sensor. */
class GAZEBO_VISIBLE ContactPlugin : public SensorPlugin
{
 public:
  void Load(sensors::SensorPtr sensor, sdf::ElementPtr) override
  {
    this->parentSensor = std::dynamic_pointer_cast<sensors::ContactSensor>(sensor);
    if (!this->parentSensor)
      gzthrow("a ContactPlugin belongs to a contact sensor, and its sensor is none");
    this->updateConnection = this->parentSensor->ConnectUpdated([this] { this->OnUpdate(); });
    this->parentSensor->SetActive(true);
  }

 private:
  virtual void OnUpdate() {}

  sensors::ContactSensorPtr parentSensor;
  event::ConnectionPtr updateConnection;
};

/* Gives an imu to OnUpdate after each of its measurements. */
class GAZEBO_VISIBLE ImuSensorPlugin : public SensorPlugin
{
 public:
  void Load(sensors::SensorPtr sensor, sdf::ElementPtr) override
  {
    this->parentSensor = std::dynamic_pointer_cast<sensors::ImuSensor>(sensor);
    if (!this->parentSensor)
      gzthrow("an ImuSensorPlugin belongs to an imu, and its sensor is none");
    this->connection = this->parentSensor->ConnectUpdated([this] { this->OnUpdate(this->parentSensor); });
    this->parentSensor->SetActive(true);
  }

 protected:
  virtual void OnUpdate(sensors::ImuSensorPtr) {}

  sensors::ImuSensorPtr parentSensor;

 private:
  event::ConnectionPtr connection;
};

/* Gives each measurement of a force_torque sensor to OnUpdate. */
class GAZEBO_VISIBLE ForceTorquePlugin : public SensorPlugin
{
 public:
  void Load(sensors::SensorPtr sensor, sdf::ElementPtr) override
  {
    this->parentSensor = std::dynamic_pointer_cast<sensors::ForceTorqueSensor>(sensor);
    if (!this->parentSensor)
      gzthrow("a ForceTorquePlugin belongs to a force_torque sensor, and its sensor is none");
    this->connection =
        this->parentSensor->ConnectUpdate([this](msgs::WrenchStamped message) { this->OnUpdate(message); });
    this->parentSensor->SetActive(true);
  }

 protected:
  virtual void OnUpdate(msgs::WrenchStamped) {}

  sensors::ForceTorqueSensorPtr parentSensor;

 private:
  event::ConnectionPtr connection;
};

/* Gives each measurement of a sonar to OnUpdate. */
class GAZEBO_VISIBLE SonarPlugin : public SensorPlugin
{
 public:
  void Load(sensors::SensorPtr sensor, sdf::ElementPtr) override
  {
    this->parentSensor = std::dynamic_pointer_cast<sensors::SonarSensor>(sensor);
    if (!this->parentSensor)
      gzthrow("a SonarPlugin belongs to a sonar, and its sensor is none");
    this->connection =
        this->parentSensor->ConnectUpdate([this](msgs::SonarStamped message) { this->OnUpdate(message); });
    this->parentSensor->SetActive(true);
  }

 protected:
  virtual void OnUpdate(msgs::SonarStamped) {}

  sensors::SonarSensorPtr parentSensor;

 private:
  event::ConnectionPtr connection;
};
}  // namespace gazebo
#endif
