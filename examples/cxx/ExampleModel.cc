/* Desc: A box on two driven wheels and a skid, with a position interface
 */

#include <assert.h>
#include <math.h>

#include <gazebo.h>
#include <gazebo/World.hh>
#include <gazebo/WorldFile.hh>
#include <gazebo/ModelFactory.hh>
#include <gazebo/Body.hh>
#include <gazebo/BoxGeom.hh>
#include <gazebo/SphereGeom.hh>
#include <gazebo/WheelGeom.hh>
#include <gazebo/HingeJoint.hh>

#include "ExampleModel.hh"

#define WHEEL_RADIUS 0.08
#define WHEEL_SEP 0.30
#define MAX_TORQUE 2.0


//////////////////////////////////////////////////////////////////////////////
// Register the model
GZ_REGISTER_PLUGIN("ExampleModel", ExampleModel)


//////////////////////////////////////////////////////////////////////////////
// Constructor
ExampleModel::ExampleModel( World *world )
    : Model( world )
{
  int i;

  this->chassis = NULL;
  for (i = 0; i < 2; i++)
  {
    this->wheels[i] = NULL;
    this->joints[i] = NULL;
  }
  this->position = NULL;
}


//////////////////////////////////////////////////////////////////////////////
// Destructor
ExampleModel::~ExampleModel()
{
  int i;

  for (i = 0; i < 2; i++)
  {
    if (this->joints[i])
      delete this->joints[i];
    if (this->wheels[i])
      delete this->wheels[i];
  }
  if (this->chassis)
    delete this->chassis;
}


//////////////////////////////////////////////////////////////////////////////
// Load the model
int ExampleModel::Load( WorldFile *file, WorldFileNode *node )
{
  Geom *geom;

  this->updatePeriod = 1.0 / (node->GetDouble("updateRate", 10.0) + 1e-6);
  this->updateTime = -this->updatePeriod;

  this->chassis = new Body( this->world );
  this->AddBody( this->chassis, true );

  geom = new BoxGeom( this->chassis, this->modelSpaceId, 0.36, 0.24, 0.10 );
  geom->SetRelativePosition( GzVectorSet(-0.08, 0, 0.10) );
  geom->SetMass( 3.0 );
  geom->SetColor( node->GetColor("color", GzColor(0.2, 0.4, 0.9)) );

  geom = new SphereGeom( this->chassis, this->modelSpaceId, 0.03 );
  geom->SetRelativePosition( GzVectorSet(-0.22, 0, 0.03) );
  geom->SetMass( 0.1 );
  geom->SetFriction( 0, 0 );

  this->LoadWheel( 0, +WHEEL_SEP / 2, -M_PI / 2 );
  this->LoadWheel( 1, -WHEEL_SEP / 2, +M_PI / 2 );

  return 0;
}


//////////////////////////////////////////////////////////////////////////////
// Create a wheel and its joint
void ExampleModel::LoadWheel( int i, double y, double roll )
{
  Geom *geom;

  this->wheels[i] = new Body( this->world );
  this->AddBody( this->wheels[i] );

  geom = new WheelGeom( this->wheels[i], this->modelSpaceId, WHEEL_RADIUS, 0.02 );
  geom->SetMass( 0.4 );

  // Wheels turn about their own z axis
  this->wheels[i]->SetPosition( GzVectorSet(0, y, WHEEL_RADIUS) );
  this->wheels[i]->SetRotation( GzQuaternFromAxis(1, 0, 0, roll) );

  this->joints[i] = new HingeJoint( this->world );
  this->joints[i]->Attach( this->wheels[i], this->chassis );
  this->joints[i]->SetAnchor( GzVectorSet(0, y, WHEEL_RADIUS) );
  this->joints[i]->SetAxis( GzVectorSet(0, 1, 0) );
}


//////////////////////////////////////////////////////////////////////////////
// Initialize the model
int ExampleModel::Init( WorldFile *file, WorldFileNode *node )
{
  this->position = gz_position_alloc();
  assert(this->position);
  if (gz_position_create(this->position, this->world->gz_server, this->GetId(), "ExampleModel",
                         (int) this, (int) this->parent) != 0)
    return -1;
  this->position->data->cmd_enable_motors = 1;

  this->odomPose[0] = 0.0;
  this->odomPose[1] = 0.0;
  this->odomPose[2] = 0.0;

  return 0;
}


//////////////////////////////////////////////////////////////////////////////
// Finalize the model
int ExampleModel::Fini()
{
  gz_position_destroy( this->position );
  gz_position_free( this->position );
  this->position = NULL;

  return 0;
}


//////////////////////////////////////////////////////////////////////////////
// Update the model
void ExampleModel::Update( double step )
{
  // Do nothing if paused
  if (step == 0)
    return;

  this->UpdateOdometry( step );

  if (this->world->GetSimTime() - this->updateTime >= this->updatePeriod - 1e-9)
  {
    this->updateTime = this->world->GetSimTime();
    this->UpdatePosition();
  }
}


//////////////////////////////////////////////////////////////////////////////
// Update the odometry
void ExampleModel::UpdateOdometry( double step )
{
  double d1, d2;

  d1 = step * WHEEL_RADIUS * this->joints[0]->GetAngleRate();
  d2 = step * WHEEL_RADIUS * this->joints[1]->GetAngleRate();

  this->odomPose[0] += (d1 + d2) / 2 * cos(this->odomPose[2]);
  this->odomPose[1] += (d1 + d2) / 2 * sin(this->odomPose[2]);
  this->odomPose[2] += (d2 - d1) / WHEEL_SEP;
}


//////////////////////////////////////////////////////////////////////////////
// Take commands, and publish the odometry
void ExampleModel::UpdatePosition()
{
  double v, w;

  if (gz_position_lock( this->position, 1 ) != 0)
    return;

  v = this->position->data->cmd_vel_pos[0];
  w = this->position->data->cmd_vel_rot[2];
  if (!this->position->data->cmd_enable_motors)
    v = w = 0.0;

  this->joints[0]->SetParam( dParamVel, (v - w * WHEEL_SEP / 2) / WHEEL_RADIUS );
  this->joints[0]->SetParam( dParamFMax, MAX_TORQUE );
  this->joints[1]->SetParam( dParamVel, (v + w * WHEEL_SEP / 2) / WHEEL_RADIUS );
  this->joints[1]->SetParam( dParamFMax, MAX_TORQUE );

  this->position->data->time = this->world->GetSimTime();
  this->position->data->pos[0] = this->odomPose[0];
  this->position->data->pos[1] = this->odomPose[1];
  this->position->data->rot[2] = this->odomPose[2];

  gz_position_unlock( this->position );
}
