// Ground of all kinds, geoms of the plugin's own, and what contacts are made of.
#include <math.h>
#include <string.h>

#include <ode/ode.h>
#include <GL/gl.h>
#include <gazebo/World.hh>
#include <gazebo/WorldFile.hh>
#include <gazebo/ModelFactory.hh>
#include <gazebo/Body.hh>
#include <gazebo/BoxGeom.hh>
#include <gazebo/ContactParams.hh>
#include <gazebo/PlaneGeom.hh>
#include <gazebo/PointSetGeom.hh>
#include <gazebo/PrismGeom.hh>
#include <gazebo/RoadGeom.hh>
#include <gazebo/SphereGeom.hh>
#include <gazebo/TerrainGeom.hh>
#include <gazebo/WheelGeom.hh>

#include "check.h"

// A pill: ODE's capsule, which the old API had no class for, lying along y.
class PillGeom : public Geom
{
  public: PillGeom( Body *body, const dSpaceID space, double radius, double length ) : Geom( space )
  {
    dMass mass;

    dMassSetCapsule( &mass, 1.0, 3, radius, length );
    this->SetGeom( body, dCreateCapsule( 0, radius, length ), &mass, true );
    this->SetExtraRotation( GzQuaternFromAxis( 1, 0, 0, M_PI / 2 ) );
    this->contact->kp = 5e4;
    this->contact->mu1 = this->contact->mu2 = 0.25;
    this->contact->kd += 10;
    this->contact->slip1 = this->contact->slip2 = 0.02; // without effect
  }

  // As drawn in 2005.
  public: virtual void Render( RenderOptions *opt )
  {
    GLuint list;
    RenderOptions listOpt;

    this->GetList( opt->cameraIndex, &list, &listOpt );
    if ( this->dirty )
    {
      list = glGenLists( 1 );
      glNewList( list, GL_COMPILE );
      glMaterialfv( GL_FRONT, GL_DIFFUSE, this->colorDiffuse );
      glMaterialf( GL_FRONT, GL_SHININESS, this->shininess );
      glBegin( GL_LINES );
      glVertex3f( 0, -1, 0 );
      glVertex3f( 0, +1, 0 );
      glEnd();
      glEndList();
      this->SetList( opt->cameraIndex, list, *opt );
      this->dirty = false;
    }
    glCallList( list );
  }

  public: ContactParams *GetContact() { return this->contact; }
};

class Ground : public Model
{
  public: Ground( World *world ) : Model( world ) { this->updates = 0; }
  public: virtual ~Ground() {}

  public: virtual int Load( WorldFile *file, WorldFileNode *node )
  {
    int i, j;

    this->ground = new Body( this->world, NULL, true );
    this->AddBody( this->ground, true );
    this->fixed = true;
    Geom *plane = new PlaneGeom( this->ground, this->modelSpaceId, -5, GzVectorSet( 0, 0, 2 ) );
    plane->SetHardness( dInfinity, 0 );
    plane->SetFriction( dInfinity, dInfinity );
    plane->SetRelativePose( GzPoseSet( GzVectorSet( 1, 2, 3 ), GzQuaternIdent() ) );
    CHECK( !plane->placeableGeom && plane->GetBodyMassMatrix() == NULL );
    CHECK( plane->GetRelativePose().pos.y == 2 );
    dGeomSetCategoryBits( (dGeomID) this->modelSpaceId, GZ_FIXED_COLLIDE );
    dGeomSetCollideBits( (dGeomID) this->modelSpaceId, ~GZ_FIXED_COLLIDE );

    // A flat terrain of 5 x 5 vertices, 4 m wide, at z = 0.5.
    static GLfloat vertices[25][12];
    GLuint triangles[2 * 16 * 3], *corner = triangles;
    for ( i = 0; i < 25; i++ )
    {
      vertices[i][8] = 1;
      vertices[i][9] = i % 5 - 2.0f;
      vertices[i][10] = i / 5 - 2.0f;
      vertices[i][11] = 0.5f;
    }
    for ( i = 0; i < 4; i++ )
      for ( j = 0; j < 4; j++ )
      {
        GLuint at = 5 * i + j;
        *corner++ = at, *corner++ = at + 1, *corner++ = at + 6;
        *corner++ = at, *corner++ = at + 6, *corner++ = at + 5;
      }
    TerrainGeom *terrain = new TerrainGeom( this->ground, this->modelSpaceId );
    terrain->Load( &vertices[0][0], 25, triangles, 6, triangles, 96 );
    CHECK( terrain->GetGeomId() != 0 && terrain->SetTexture2DFile( NULL ) == 0 );

    RoadGeom *road = new RoadGeom( this->ground, this->modelSpaceId );
    road->SetTrackSpacing( 10 );
    road->SetProfileSpacing( 2 );
    for ( i = 0; i < 5; i++ )
    {
      int index = road->AddTrackPoint( GzVectorSet( 10 * i, 30, 0 ) );
      CHECK( index == i );
      for ( j = 0; j < 9; j++ )
        road->AddProfilePoint( index, 0.02 * j );
    }
    road->AddSign( GzVectorSet( 0, 28, 0 ), "road" );
    road->UpdateMesh( GzVectorZero() );

    GzVector corners[4]
      = { GzVectorSet( 3, 0, 0 ), GzVectorSet( 5, 0, 0 ), GzVectorSet( 5, 0.2, 0 ), GzVectorSet( 3, 0.2, 0 ) };
    this->wall = new PrismGeom( this->ground, this->modelSpaceId, 4, corners, 1.5 );
    this->wall->SetMass( 6 );
    const dMass *mass = this->wall->GetBodyMassMatrix();
    CHECK( NEAR( mass->mass, 6, 1e-9 ) && NEAR( mass->c[0], 4, 1e-9 ) && NEAR( mass->c[2], 0.75, 1e-9 ) );

    PointSetGeom *points = new PointSetGeom( this->ground, this->modelSpaceId, 4, corners );
    CHECK( points->GetGeomId() == NULL );

    // What falls on it.
    this->pill = new Body( this->world, "pill" );
    this->pillGeom = new PillGeom( this->pill, this->modelSpaceId, 0.1, 0.4 );
    this->pillGeom->SetMass( 2 );
    CHECK( this->pillGeom->body == this->pill && this->pillGeom->GetContact()->kp == 5e4 );
    // About y it is slim.
    const dReal *inertia = this->pillGeom->GetBodyMassMatrix()->I;
    CHECK( inertia[5] < inertia[0] || inertia[10] < inertia[0] );
    this->pillGeom->SetBounce( 0.5 );
    CHECK( this->pillGeom->GetContact()->bounce == 0.5 );
    this->pillGeom->SetBounce( 0 );
    this->pill->SetPosition( GzVectorSet( 0, 0, 1 ) );
    this->AddBody( this->pill );
    return 0;
  }

  public: virtual int Init( WorldFile *file, WorldFileNode *node ) { return 0; }
  public: virtual int Fini() { return 0; }

  public: virtual void Update( double step )
  {
    if ( ++this->updates < 150 )
      return;
    // Geoms of one model never touch: it has fallen through the terrain.
    EXPECT( this->pill->GetPosition().z < 0.3 );
    EXPECT( NEAR( this->wall->GetPose().pos.z, this->ground->GetPosition().z, 1e-9 ) );
  }

  private: Body *ground, *pill;
  private: PrismGeom *wall;
  private: PillGeom *pillGeom;
  private: int updates;
};

GZ_REGISTER_PLUGIN( "Ground", Ground )
