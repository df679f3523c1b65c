// Feels its way with a ray in a space of its own, as grippers did, and turns with ODE's functions.
#include <float.h>
#include <ode/ode.h>
#include <gazebo/gazebo.h>
#include <gazebo/World.hh>
#include <gazebo/WorldFile.hh>
#include <gazebo/ModelFactory.hh>
#include <gazebo/Body.hh>
#include <gazebo/BoxGeom.hh>
#include <gazebo/RayGeom.hh>

#include "check.h"

class Feeler : public Model
{
  public: Feeler( World *world ) : Model( world ), depth( 0 ) {}
  public: virtual ~Feeler()
  {
    dSpaceDestroy( this->outer ); // its geoms are the body's
    delete this->rays[0];
    delete this->rays[1];
  }

  public: virtual int Load( WorldFile *file, WorldFileNode *node )
  {
    dMatrix3 turn;
    dQuaternion turned, double_turn;
    dVector3 across, x = { 1, 0, 0 }, y = { 0, 1, 0 };
    dMass mass;

    this->body = new Body( this->world, "hand" );
    this->geom = new BoxGeom( this->body, this->modelSpaceId, 0.1, 0.1, 0.1 );
    this->geom->SetMass( 1 );
    this->AddBody( this->body, true );
    this->body->SetGravityMode( false );
    this->wall = new Body( this->world, "wall" );
    ( new BoxGeom( this->wall, this->modelSpaceId, 0.1, 1, 1 ) )->SetMass( 1 );
    this->wall->SetPosition( GzVectorSet( 2, 0, 0 ) );
    this->wall->SetGravityMode( false );
    this->AddBody( this->wall );

    this->outer = dSimpleSpaceCreate( 0 );
    this->inner = dSimpleSpaceCreate( this->outer );
    dGeomSetCategoryBits( (dGeomID) this->inner, GZ_LASER_COLLIDE );
    dGeomSetCollideBits( (dGeomID) this->inner, ~GZ_LASER_COLLIDE );
    this->rays[0] = new RayGeom( this->body, this->inner );
    this->rays[0]->SetLength( 5 );
    this->rays[1] = new RayGeom( this->body, this->modelSpaceId );
    CHECK( dSpaceGetNumGeoms( this->inner ) == 1 && dGeomGetClass( this->rays[0]->GetGeomId() ) == dRayClass );
    CHECK( dGeomGetSpace( this->rays[1]->GetGeomId() ) == NULL );

    CHECK( this->geom->renderOrder == GZ_RENDER_OPAQUE );
    this->geom->SetTransparency( true );
    CHECK( this->geom->renderOrder == GZ_RENDER_TRANSPARENT );
    this->geom->renderOrder = GZ_RENDER_OPAQUE;
    CHECK( this->geom->GetTransparency() == 0 );

    dRFromAxisAndAngle( turn, 0, 0, 1, M_PI / 2 );
    dRtoQ( turn, turned );
    dQMultiply0( double_turn, turned, turned );
    CHECK( NEAR( turned[0], sqrt( 0.5 ), 1e-12 ) && NEAR( double_turn[3], 1, 1e-12 ) );
    dCROSS( across, =, x, y );
    CHECK( across[2] == 1 && dDOT( x, y ) == 0 );
    dMassSetBoxTotal( &mass, 2, 1, 2, 3 );
    CHECK( NEAR( mass.mass, 2, 1e-12 ) );
    return 0;
  }

  public: virtual int Init( WorldFile *file, WorldFileNode *node ) { return 0; }
  public: virtual int Fini() { return 0; }

  private: static void Near( void *data, dGeomID one, dGeomID two )
  {
    Feeler *self = (Feeler *) data;
    dContactGeom contacts[2];

    if ( dGeomIsSpace( one ) || dGeomIsSpace( two ) )
      dSpaceCollide2( one, two, data, Near );
    else if ( dGeomGetBody( two ) != self->body->GetBodyId() && dCollide( one, two, 2, contacts, sizeof( dContactGeom ) ) > 0 )
      self->depth = Min( self->depth, contacts[0].depth );
  }

  public: virtual void Update( double step )
  {
    this->rays[0]->Set( this->body->GetPosition(), GzVectorSet( 1, 0, 0 ) );
    this->depth = DBL_MAX;
    dSpaceCollide2( (dGeomID) this->outer, (dGeomID) this->world->GetSpaceId(), this, Near );
    EXPECT( NEAR( this->depth, 1.95, 1e-9 ) );
    EXPECT( dBodyGetNumJoints( this->wall->GetBodyId() ) == 0 );
  }

  private: Body *body, *wall;
  private: Geom *geom;
  private: RayGeom *rays[2];
  private: dSpaceID outer, inner;
  private: double depth;
};

GZ_REGISTER_PLUGIN( "Feeler", Feeler )
