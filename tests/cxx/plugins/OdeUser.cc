// Passes the engine's handles to ODE: forces, joints in a group, its own collisions, masses.
#include <math.h>

#include <ode/ode.h>
#include <gazebo/World.hh>
#include <gazebo/WorldFile.hh>
#include <gazebo/ModelFactory.hh>
#include <gazebo/Body.hh>
#include <gazebo/BoxGeom.hh>
#include <gazebo/SphereGeom.hh>
#include <gazebo/HingeJoint.hh>
#include <gazebo/JointGroup.hh>

#include "check.h"

class OdeUser : public Model
{
  public: OdeUser( World *world ) : Model( world ), updates( 0 ), touching( 0 ) {}
  public: virtual ~OdeUser() {}

  public: virtual int Load( WorldFile *file, WorldFileNode *node )
  {
    dMass mass;

    this->base = new Body( this->world, "base" );
    this->baseGeom = new BoxGeom( this->base, this->modelSpaceId, 1, 1, 0.2 );
    this->baseGeom->SetMass( 10 );
    this->AddBody( this->base, true );
    this->base->SetGravityMode( false );
    this->ball = new Body( this->world, "ball" );
    this->ballGeom = new SphereGeom( this->ball, this->modelSpaceId, 0.1 );
    this->ballGeom->SetMass( 1 );
    this->AddBody( this->ball );
    this->ball->SetPosition( GzVectorSet( 0, 0, 0.3 ) );

    CHECK( dBodyGetWorld( this->ball->GetBodyId() ) == this->world->worldId );
    CHECK( dGeomGetBody( this->ballGeom->GetGeomId() ) == this->ball->GetBodyId() );
    CHECK( dGeomGetSpace( this->ballGeom->GetGeomId() ) == this->modelSpaceId );
    dBodyGetMass( this->ball->GetBodyId(), &mass );
    CHECK( NEAR( mass.mass, 1, 1e-12 ) && NEAR( mass.I[0], 0.4 * 0.01, 1e-12 ) );
    dMassSetBox( &mass, 2, 1, 2, 3 );
    CHECK( NEAR( mass.mass, 12, 1e-12 ) );
    const dReal *pos = dBodyGetPosition( this->ball->GetBodyId() );
    CHECK( pos[2] == 0.3 );
    CHECK( dInfinity > 1e300 );
    return 0;
  }

  public: virtual int Init( WorldFile *file, WorldFileNode *node )
  {
    // The base, held by a joint of ODE's own.
    dJointID fixed = dJointCreateFixed( this->world->worldId, this->kept.GetGroupId() );
    dJointAttach( fixed, this->base->GetBodyId(), 0 );
    dJointSetFixed( fixed );
    this->start = this->base->GetPosition().z;
    CHECK( this->kept.GetGroupId() != this->contacts.GetGroupId() );
    return 0;
  }

  public: virtual int Fini()
  {
    this->contacts.Empty();
    return 0;
  }

  // Geoms of one model never touch, but here they shall.
  private: static void Near( void *data, dGeomID one, dGeomID two )
  {
    OdeUser *self = (OdeUser *) data;
    dContact contact[4];
    int i, n = dCollide( one, two, 4, &contact[0].geom, sizeof( dContact ) );

    for ( i = 0; i < n; i++ )
    {
      contact[i].surface.mode = dContactSoftERP | dContactSoftCFM;
      contact[i].surface.mu = dInfinity;
      contact[i].surface.soft_erp = 0.4;
      contact[i].surface.soft_cfm = 1e-5;
      dJointAttach( dJointCreateContact( self->world->worldId, self->contacts.GetGroupId(), contact + i ),
                    dGeomGetBody( one ), dGeomGetBody( two ) );
      self->touching++;
    }
  }

  public: virtual void Update( double step )
  {
    this->contacts.Empty();
    this->touching = 0;
    dSpaceCollide2( this->ballGeom->GetGeomId(), this->baseGeom->GetGeomId(), this, Near );
    dBodyAddForce( this->base->GetBodyId(), 0, 0, 50 );
    if ( ++this->updates < 150 )
      return;
    EXPECT( this->touching == 1 );
    EXPECT( NEAR( this->base->GetPosition().z, this->start, 1e-3 ) );
    EXPECT( NEAR( this->ball->GetPosition().z - this->base->GetPosition().z, 0.2, 0.01 ) );
    EXPECT( dAreConnected( this->ball->GetBodyId(), this->base->GetBodyId() ) );
  }

  private: Body *base, *ball;
  private: Geom *baseGeom, *ballGeom;
  private: JointGroup contacts, kept;
  private: double start;
  private: int updates, touching;
};

GZ_REGISTER_PLUGIN( "OdeUser", OdeUser )
