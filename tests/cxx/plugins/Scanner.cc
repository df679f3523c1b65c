// Rays of both kinds, with reflectivity and fiducial numbers, and a laser and a fiducial interface.
#include <assert.h>
#include <float.h>
#include <math.h>
#include <string.h>

#include <gazebo.h>
#include <gazebo/World.hh>
#include <gazebo/WorldFile.hh>
#include <gazebo/ModelFactory.hh>
#include <gazebo/Body.hh>
#include <gazebo/CylinderGeom.hh>
#include <gazebo/SphereGeom.hh>
#include <gazebo/RayGeom.hh>
#include <gazebo/RayProximity.hh>

#include "check.h"

class Scanner : public Model
{
  public: Scanner( World *world );
  public: virtual ~Scanner();
  public: int Load( WorldFile *file, WorldFileNode *node );
  public: int Init( WorldFile *file, WorldFileNode *node );
  public: int Fini();
  public: void Update( double step );

  private: void PutData();

  private: int rayCount;
  private: double spread, lastTime;
  private: Body *body, *post;
  private: Geom *target;
  private: RayGeom *pointer;
  private: RayProximity *rays;
  private: gz_laser_t *laser;
  private: gz_fiducial_t *fiducial;
};

GZ_REGISTER_PLUGIN( "Scanner", Scanner )

Scanner::Scanner( World *world )
    : Model( world ), rayCount( 0 ), lastTime( -DBL_MAX ), body( NULL ), post( NULL ), rays( NULL ), laser( NULL ),
      fiducial( NULL )
{
  return;
}

Scanner::~Scanner()
{
  if ( this->rays )
    delete this->rays;
  if ( this->post )
    delete this->post;
  if ( this->body )
    delete this->body;
}

int Scanner::Load( WorldFile *file, WorldFileNode *node )
{
  this->rayCount = node->GetInt( "rayCount", 91 );
  this->spread = node->GetAngle( "spread", DTOR( 90 ) );
  assert( this->rayCount > 1 && this->rayCount <= GZ_LASER_MAX_RANGES );

  this->body = new Body( this->world );
  Geom *geom = new CylinderGeom( this->body, this->modelSpaceId, 0.05, 0.1 );
  geom->SetMass( 0.5 );
  this->AddBody( this->body, true );
  this->body->SetGravityMode( 0 );

  // A post 2 m ahead.
  this->post = new Body( this->world, "post" );
  this->target = new SphereGeom( this->post, this->modelSpaceId, 0.25 );
  this->target->SetRetro( 0.5 );
  this->target->SetFiducial( 7 );
  this->AddBody( this->post );
  this->post->SetPosition( GzVectorSet( 2, 0, 0 ) );
  this->post->SetGravityMode( false );

  this->rays = new RayProximity( this->world, this->body, this->rayCount );
  for ( int i = 0; i < this->rayCount; i++ )
  {
    double angle = this->spread * ( i / ( this->rayCount - 1.0 ) - 0.5 );
    GzVector a = GzVectorSet( 0.1 * cos( angle ), 0.1 * sin( angle ), 0 );
    this->rays->SetRay( i, a, GzVectorMul( 80, a ) );
    CHECK( this->rays->GetRange( i ) == DBL_MAX );
  }

  this->pointer = new RayGeom( this->body, this->modelSpaceId );
  this->pointer->SetLength( 0.5 );
  this->pointer->SetCategoryBits( GZ_LASER_COLLIDE );
  this->pointer->SetCollideBits( ~GZ_LASER_COLLIDE );
  CHECK( this->pointer->GetLength() == 0.5 && !this->pointer->placeableGeom );
  return 0;
}

int Scanner::Init( WorldFile *file, WorldFileNode *node )
{
  this->laser = gz_laser_alloc();
  assert( this->laser );
  if ( gz_laser_create( this->laser, this->world->gz_server, this->GetId(), "Scanner", (int) this, (int) this->parent )
       != 0 )
    return -1;
  this->fiducial = gz_fiducial_alloc();
  if ( gz_fiducial_create( this->fiducial, this->world->gz_server, this->GetId(), "Scanner", (int) this, 0 ) != 0 )
    return -1;
  gz_laser_lock( this->laser, 1 );
  this->laser->data->min_angle = -this->spread / 2;
  this->laser->data->max_angle = +this->spread / 2;
  this->laser->data->range_count = this->rayCount;
  this->laser->data->max_range = 8.0;
  gz_laser_unlock( this->laser );
  return 0;
}

int Scanner::Fini()
{
  gz_fiducial_destroy( this->fiducial );
  gz_fiducial_free( this->fiducial );
  gz_laser_destroy( this->laser );
  gz_laser_free( this->laser );
  return 0;
}

void Scanner::Update( double step )
{
  GzVector pos, dir;
  GzPose pose = this->body->GetPose();

  this->pointer->Set( pose.pos, GzVectorSet( 0, 0, -1 ) );
  this->pointer->Get( &pos, &dir );
  EXPECT( GzVectorMag( GzVectorSub( pos, pose.pos ) ) == 0 && dir.z == -1 );

  if ( this->world->GetSimTime() - this->lastTime < 1 / ( 10 + 1e-6 ) )
    return;
  this->lastTime = this->world->GetSimTime();
  this->rays->Update();
  int middle = this->rayCount / 2;
  this->rays->GetRay( middle, &pos, &dir );
  EXPECT( NEAR( GzVectorDot( dir, dir ), 1, 1e-12 ) );
  EXPECT( this->rays->GetRetro( middle ) == 0.5f && this->rays->GetFiducial( middle ) == 7 );
  EXPECT( NEAR( this->rays->GetRange( middle ), 2 - 0.25 - 0.1, 1e-6 ) );
  EXPECT( this->rays->GetRange( 0 ) == DBL_MAX && this->rays->GetFiducial( 0 ) == -1 );
  this->PutData();
}

void Scanner::PutData()
{
  int i, seen = 0;

  if ( gz_laser_lock( this->laser, 1 ) != 0 )
    return;
  this->laser->data->time = this->world->GetSimTime();
  for ( i = 0; i < this->rayCount; i++ )
  {
    this->laser->data->ranges[i] = Min( this->rays->GetRange( i ) + 0.1, this->laser->data->max_range );
    this->laser->data->intensity[i] = Round( this->rays->GetRetro( i ) );
    if ( this->rays->GetFiducial( i ) >= 0 )
      seen = this->rays->GetFiducial( i );
  }
  gz_laser_unlock( this->laser );
  gz_laser_post( this->laser );

  gz_fiducial_lock( this->fiducial, 1 );
  this->fiducial->data->time = this->world->GetSimTime();
  this->fiducial->data->fid_count = seen ? 1 : 0;
  this->fiducial->data->fids[0].id = seen;
  gz_fiducial_unlock( this->fiducial );
  gz_fiducial_post( this->fiducial );
}
