#include <stdlib.h>
#include <string.h>

#include <ode/ode.h>
#include <gazebo/World.hh>
#include <gazebo/WorldFile.hh>
#include <gazebo/ModelFactory.hh>
#include <gazebo/Body.hh>
#include <gazebo/BoxGeom.hh>
#include <gazebo/CylinderGeom.hh>
#include <gazebo/HingeJoint.hh>
#include <gazebo/Hinge2Joint.hh>
#include <gazebo/SliderJoint.hh>
#include <gazebo/BallJoint.hh>
#include <gazebo/UniversalJoint.hh>
#include <gazebo/JointGroup.hh>

#include "Linkage.hh"
#include "check.h"

GZ_REGISTER_PLUGIN( "Linkage", Linkage )

Linkage::Linkage( World *world ) : Model( world )
{
  memset( this->links, 0, sizeof( this->links ) );
  this->hinge = NULL;
  this->axle = NULL;
  this->slider = NULL;
  this->ball = NULL;
  this->universal = NULL;
  this->group = NULL;
  this->updates = 0;
}

Linkage::~Linkage()
{
  int i;
  delete this->hinge;
  delete this->axle;
  delete this->slider;
  delete this->ball;
  delete this->universal;
  delete this->group;
  for ( i = 0; i < COUNT; i++ )
    delete this->links[i];
}

int Linkage::Load( WorldFile *file, WorldFileNode *node )
{
  int i;
  char name[16];
  Geom *geom;

  this->speed = node->GetDouble( "speed", 1.5 );
  for ( i = 0; i < COUNT; i++ )
  {
    snprintf( name, sizeof( name ), "link%d", i );
    this->links[i] = new Body( this->world, name );
    if ( i % 2 )
      geom = new CylinderGeom( this->links[i], this->modelSpaceId, 0.1, 0.2 );
    else
      geom = new BoxGeom( this->links[i], this->modelSpaceId, 0.2, 0.2, 0.2 );
    geom->SetMass( 1.0 + i );
    geom->SetColor( GzColor( i / 6.0, 0.5, 1 - i / 6.0 ) );
    this->links[i]->SetPosition( GzVectorSet( 0.4 * i, 0, 0 ) );
    this->AddBody( this->links[i], i == 0 );
    this->links[i]->SetGravityMode( false );
  }

  this->hinge = new HingeJoint( this->world );
  this->hinge->Attach( this->links[1], this->links[0] );
  this->hinge->SetAnchor( GzVectorSet( 0.2, 0, 0 ) );
  this->hinge->SetAxis( GzVectorSet( 0, 0, 1 ) );
  this->hinge->SetParam( dParamLoStop, DTOR( -20 ) );
  this->hinge->SetParam( dParamHiStop, DTOR( 20 ) );
  this->hinge->SetParam( dParamFMax, 5 );
  CHECK( this->hinge->GetType() == dJointTypeHinge );
  CHECK( NEAR( this->hinge->GetParam( dParamHiStop ), M_PI / 9, 1e-12 ) );

  this->group = new JointGroup();
  this->slider = new SliderJoint( this->world->worldId, this->group );
  this->slider->Attach( this->links[2], this->links[1] );
  this->slider->SetAxis( 1, 0, 0 );
  this->slider->SetParam( dParamHiStop, 0.1 );
  this->slider->SetParam( dParamLoStop, -0.1 );
  this->slider->SetParam( dParamStopERP, 0.6 );
  CHECK( this->slider->GetType() == dJointTypeSlider );
  dVector3 along;
  this->slider->GetAxis( along );
  CHECK( along[0] == 1 && along[1] == 0 && along[2] == 0 );

  this->ball = new BallJoint( this->world );
  this->ball->Attach( this->links[3], this->links[2] );
  this->ball->SetAnchor( GzVectorSet( 1.0, 0, 0 ) );
  CHECK( this->ball->GetType() == dJointTypeBall );
  CHECK( GzVectorMag( GzVectorSub( this->ball->GetAnchor(), GzVectorSet( 1, 0, 0 ) ) ) < 1e-12 );

  this->universal = new UniversalJoint( this->world );
  this->universal->Attach( this->links[4], this->links[3] );
  this->universal->SetAnchor( GzVectorSet( 1.4, 0, 0 ) );
  this->universal->SetAxis1( GzVectorSet( 0, 1, 0 ) );
  this->universal->SetAxis2( GzVectorSet( 0, 0, 1 ) );
  CHECK( this->universal->GetType() == dJointTypeUniversal );

  this->axle = new Hinge2Joint( this->world );
  this->axle->Attach( this->links[4], this->links[5] );
  this->axle->SetAnchor( GzVectorSet( 2.0, 0, 0 ) );
  this->axle->SetAxis1( GzVectorSet( 0, 0, 1 ) );
  this->axle->SetAxis2( GzVectorSet( 0, 1, 0 ) );
  this->axle->SetParam( dParamVel2, this->speed );
  this->axle->SetParam( dParamFMax2, 100 );
  this->axle->SetParam( dParamSuspensionERP, 0.4 );
  this->axle->SetParam( dParamSuspensionCFM, 1e-5 );
  this->axle->SetParam( dParamLoStop, 0 );
  this->axle->SetParam( dParamHiStop, 0 );
  CHECK( this->axle->GetType() == dJointTypeHinge2 );
  CHECK( NEAR( this->axle->GetParam( dParamVel2 ), this->speed, 1e-12 ) );

  for ( i = 0; i + 1 < COUNT; i++ )
    CHECK( this->hinge->AreConnected( this->links[i], this->links[i + 1] ) );
  CHECK( !this->hinge->AreConnected( this->links[0], this->links[5] ) );
  CHECK( this->axle->GetJointBody( 0 ) == this->links[4] && this->axle->GetJointBody( 1 ) == this->links[5] );
  CHECK( strcmp( this->links[0]->bodyName, "canonical" ) == 0 && strcmp( this->links[3]->bodyName, "link3" ) == 0 );
  CHECK( this->GetNumBodies() == COUNT && this->GetBodies()[4] == this->links[4] );
  CHECK( this->bodyCount == COUNT && this->bodies[5] == this->links[5] );
  return 0;
}

int Linkage::Init( WorldFile *file, WorldFileNode *node )
{
  return 0;
}

int Linkage::Fini()
{
  return 0;
}

void Linkage::Update( double step )
{
  Joint *all[5];
  int i;

  if ( step == 0 )
    return;
  this->updates++;
  // A sine at the hinge, a force at the slider, torques at the universal joint.
  this->hinge->SetParam( dParamVel, 2 * cos( 2 * M_PI * this->world->GetSimTime() ) );
  if ( this->slider )
    this->slider->SetSliderForce( this->updates < 100 ? 2 : -2 );
  this->universal->SetTorque( 0.1, -0.1 );
  if ( this->updates == 50 )
  {
    EXPECT( NEAR( this->axle->GetAngle2Rate(), this->speed, 0.2 ) );
    EXPECT( fabs( this->axle->GetAngle1() ) < 0.1 );
    EXPECT( fabs( this->hinge->GetAngle() ) < DTOR( 25 ) && this->hinge->GetAngleRate() != 0 );
    EXPECT( this->slider->GetPosition() != 0 && fabs( this->slider->GetPosition() ) < 0.2 );
    EXPECT( this->universal->GetAngle1() != 0 || this->universal->GetAngle2() != 0 );
  }
  if ( this->updates == 100 )
  {
    // The last body leaves, and the ball becomes a joint with the world.
    this->axle->Detach();
    EXPECT( !this->axle->AreConnected( this->links[4], this->links[5] ) );
    this->ball->Attach( this->links[3], NULL );
    this->ball->SetAnchor( this->links[3]->GetPosition() );
    EXPECT( this->ball->GetJointBody( 1 ) == NULL );
  }
  if ( this->updates == 120 )
  {
    all[0] = this->hinge;
    all[1] = this->slider;
    all[2] = this->ball;
    all[3] = this->universal;
    all[4] = this->axle;
    for ( i = 0; i < 5; i++ )
      all[i]->SetParam( dParamFMax, 0 );
    this->group->Empty(); // the slider's joint
    delete this->slider;
    this->slider = NULL;
  }
  if ( this->updates > 120 )
    EXPECT( !this->hinge->AreConnected( this->links[1], this->links[2] ) );
}
