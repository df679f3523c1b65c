// Joints as plugins of 2005 made them: from ODE's world, with anchors and axes as three numbers.
#include <ode/ode.h>
#include <gazebo/World.hh>
#include <gazebo/WorldFile.hh>
#include <gazebo/ModelFactory.hh>
#include <gazebo/BoxGeom.hh>
#include <gazebo/HingeJoint.hh>
#include <gazebo/Hinge2Joint.hh>
#include <gazebo/SliderJoint.hh>
#include <gazebo/BallJoint.hh>
#include <gazebo/UniversalJoint.hh>
#include <gazebo/JointGroup.hh>

#include "check.h"

class Earlier : public Model
{
  public: Earlier( World *world ) : Model( world ) {}
  public: int Load( WorldFile *file, WorldFileNode *node );
  public: int Init( WorldFile *file, WorldFileNode *node ) { return 0; }
  public: int Fini() { return 0; }
  public: void Update( double step );

  private: Body *links[6];
  private: HingeJoint *hinge;
  private: JointGroup group;
};

GZ_REGISTER_PLUGIN( "Earlier", Earlier )

static bool same( dVector3 a, double x, double y, double z )
{
  return NEAR( a[0], x, 1e-12 ) && NEAR( a[1], y, 1e-12 ) && NEAR( a[2], z, 1e-12 );
}

int Earlier::Load( WorldFile *file, WorldFileNode *node )
{
  dVector3 v;
  for ( int i = 0; i < 6; i++ )
  {
    this->links[i] = new Body( this->world, NULL, i == 0 );
    Geom *geom = new BoxGeom( this->links[i], this->modelSpaceId, 0.2, 0.1, 0.1 );
    geom->SetMass( 1 );
    geom->SetFriction( dInfinity, dInfinity );
    this->AddBody( this->links[i], i == 0 );
    this->links[i]->SetPosition( GzVectorSet( 0.3 * i, 0, 0 ) );
    this->links[i]->SetGravityMode( false );
  }
  dGeomSetCategoryBits( (dGeomID) this->modelSpaceId, GZ_FIXED_COLLIDE );
  dGeomSetCollideBits( (dGeomID) this->modelSpaceId, ~GZ_FIXED_COLLIDE );

  this->hinge = new HingeJoint( this->world->worldId );
  this->hinge->Attach( this->links[1], this->links[0] );
  this->hinge->SetAnchor( 0.3, 0, 0 );
  this->hinge->SetAxis( 0, 0, 1 );
  this->hinge->SetParam( dParamFMax, 10 );
  this->hinge->GetAnchor( v );
  CHECK( same( v, 0.3, 0, 0 ) );
  this->hinge->GetAxis( v );
  CHECK( same( v, 0, 0, 1 ) );

  Hinge2Joint *axle = new Hinge2Joint( this->world->worldId );
  axle->Attach( this->links[1], this->links[2] );
  axle->SetAnchor( 0.6, 0, 0 );
  axle->SetAxis1( 0, 0, 1 );
  axle->SetAxis2( 0, 1, 0 );
  axle->GetAxis1( v );
  CHECK( same( v, 0, 0, 1 ) );
  axle->GetAxis2( v );
  CHECK( same( v, 0, 1, 0 ) );
  axle->GetAnchor2( v );
  CHECK( same( v, 0.6, 0, 0 ) );

  UniversalJoint *cross = new UniversalJoint( this->world->worldId, &this->group );
  cross->Attach( this->links[3], this->links[2] );
  cross->SetAnchor( 0.9, 0, 0 );
  cross->SetAxis1( 0, 1, 0 );
  cross->SetAxis2( 0, 0, 1 );
  cross->GetAxis2( v );
  CHECK( same( v, 0, 0, 1 ) );

  BallJoint *ball = new BallJoint( this->world->worldId, &this->group );
  ball->Attach( this->links[4], this->links[3] );
  ball->SetAnchor( 1.2, 0, 0 );

  SliderJoint *slider = new SliderJoint( this->world, &this->group );
  slider->Attach( this->links[5], this->links[4] );
  slider->SetAxis( GzVectorSet( 1, 0, 0 ) );
  CHECK( slider->GetAxis().x == 1 );

  CHECK( this->hinge->AreConnected( this->links[3], this->links[4] ) );
  this->group.Empty();
  CHECK( !this->hinge->AreConnected( this->links[3], this->links[4] ) );
  return 0;
}

void Earlier::Update( double step )
{
  this->hinge->SetParam( dParamVel, 0.5 ); // about the dummy body: it does not move
  if ( this->world->GetSimTime() > 2 )
  {
    EXPECT( NEAR( this->hinge->GetAngle(), 0.5 * this->world->GetSimTime(), 0.05 ) );
    EXPECT( NEAR( this->links[1]->GetPosition().x, 1 + 0.3, 0.01 ) );
  }
}
