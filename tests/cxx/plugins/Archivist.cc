// Reads and writes worldfiles in every way; objects at file scope; containers; messages of all kinds.
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <map>
#include <string>
#include <vector>

#include <gazebo/World.hh>
#include <gazebo/WorldFile.hh>
#include <gazebo/ModelFactory.hh>
#include <gazebo/Body.hh>
#include <gazebo/SphereGeom.hh>
#include <gazebo/Error.hh>
#include <gazebo/Global.hh>

#include "check.h"

using namespace std;

static WorldFile settings; // made before any model
static map<string, int> seen;

class Archivist : public Model
{
  public: Archivist( World *world ) : Model( world ), body( NULL ) {}
  public: virtual ~Archivist() { delete this->body; }
  public: virtual int Load( WorldFile *file, WorldFileNode *node );
  public: virtual int Init( WorldFile *file, WorldFileNode *node );
  public: virtual int Fini() { return 0; }
  public: virtual void Update( double step );

  private: int Walk( WorldFileNode *node, int depth );
  private: int ReadLeniently();
  private: int Write( const char *path );
  private: int Geometry();
  private: void Say();

  private: Body *body;
  private: vector<string> names;
};

GZ_REGISTER_PLUGIN( "Archivist", Archivist )

int Archivist::Load( WorldFile *file, WorldFileNode *node )
{
  this->body = new Body( this->world );
  ( new SphereGeom( this->body, this->modelSpaceId, 0.1 ) )->SetMass( 1 );
  this->AddBody( this->body, true );

  CHECK( this->Walk( file->GetRootNode(), 0 ) > 2 );
  CHECK( seen["Archivist"] == 1 && seen["plugin"] == 1 );
  CHECK( this->names.size() > 2 && this->names[1] == "Archivist" );
  CHECK( strcmp( node->GetNSPrefix(), "model" ) == 0 && node->GetChild( "plugin" )->GetNSPrefix() == NULL );
  CHECK( strstr( file->filename, "Archivist.world" ) != NULL );
  CHECK( settings.LoadString( "<s><speed> 2.5</speed><on>true</on><off>yes</off></s>" ) == 0 );
  CHECK( settings.GetRootNode()->GetDouble( "speed", 0 ) == 2.5 );
  CHECK( settings.GetRootNode()->GetBool( "on", false ) && !settings.GetRootNode()->GetBool( "off", true ) );
  if ( this->ReadLeniently() != 0 || this->Geometry() != 0 )
    return -1;
  this->Say();
  return this->Write( node->GetString( "out", "out.world" ) );
}

int Archivist::Walk( WorldFileNode *node, int depth )
{
  int count = 0;
  for ( ; node != NULL; node = node->GetNext() )
  {
    seen[node->GetName()]++;
    this->names.push_back( node->GetName() );
    count += 1 + this->Walk( node->GetChild(), depth + 1 );
    if ( depth == 0 )
      break;
  }
  return count;
}

int Archivist::ReadLeniently()
{
  WorldFile file;
  CHECK( file.LoadString( "<w><a>12abc</a><b>rubbish</b><c>.5 -0 +10.0</c><d/><e>1 2</e><f>30 0 90</f><g>2 .5</g>"
                          "<a>second</a><color>1 0 0</color><text>  two words </text></w>" )
         == 0 );
  WorldFileNode *node = file.GetRootNode();
  CHECK( node->GetInt( "a", 3 ) == 12 && node->GetDouble( "b", 3 ) == 0 && node->GetInt( "none", 3 ) == 3 );
  CHECK( node->GetTupleDouble( "c", 0, 9 ) == 0.5 && node->GetTupleInt( "c", 2, 9 ) == 10 );
  CHECK( node->GetTupleDouble( "c", 3, 9 ) == 9 && node->GetTupleString( "c", 3, "def" ) == NULL );
  CHECK( NEAR( node->GetTupleAngle( "f", 2, 0 ), M_PI / 2, 1e-12 ) && node->GetTupleAngle( "f", 3, 0.25 ) == 0.25 );
  CHECK( node->GetTupleLength( "e", 1, 0 ) == 2 );
  CHECK( GzVectorMag( GzVectorSub( node->GetPosition( "e", GzVectorSet( 7, 7, 7 ) ), GzVectorSet( 1, 2, 0 ) ) ) == 0 );
  CHECK( node->GetPosition( "d", GzVectorSet( 7, 8, 9 ) ).y == 8 );
  GzVector angles = GzQuaternToEuler( node->GetRotation( "f", GzQuaternIdent() ) );
  CHECK( NEAR( angles.x, DTOR( 30 ), 1e-9 ) && NEAR( angles.z, DTOR( 90 ), 1e-9 ) );
  GzColor color = node->GetColor( "g", GzColor( 1, 1, 1 ) );
  CHECK( color.r == 2 && color.g == 0.5 && color.b == 0 && color.a == 1 );
  const float *numbers = node->GetColor( "none", GzColor( 0.25f, 0, 0 ) );
  CHECK( numbers != NULL );
  CHECK( node->GetChild( "color" )->GetColor( "color", GzColor() ).r == 1 ); // a node's own content
  CHECK( strcmp( node->GetString( "text", "" ), "  two words " ) == 0 );
  CHECK( node->GetString( "none", NULL ) == NULL && node->IsDefined( "text" ) && !node->IsDefined( "none" ) );
  CHECK( node->GetLength( "a", 0 ) == 12 && node->GetTime( "a", 0 ) == 12 );
  CHECK( NEAR( node->GetAngle( "a", 0 ), DTOR( 12 ), 1e-12 ) && node->GetAngle( "none", 0.5 ) == 0.5 );
  CHECK( node->GetInt( "none", 5, 1 ) == -1 || node->GetInt( "none", 5, 1 ) == 5 ); // required: an error message
  CHECK( file.Load( "/no/such/file.world" ) != 0 );
  return 0;
}

int Archivist::Write( const char *path )
{
  FILE *out = fopen( path, "w" );
  if ( out == NULL )
  {
    PRINT_ERR2( "cannot write %s: %s", path, strerror( errno ) );
    return -1;
  }
  fprintf( out, "<!-- kept --><w><xyz>0 0 0</xyz><rpy>0 0 0</rpy><id>old</id></w>" );
  fclose( out );
  WorldFile *file = new WorldFile();
  CHECK( file->Load( path ) == 0 && strcmp( file->filename, path ) == 0 );
  WorldFileNode *node = file->GetRootNode();
  node->SetPosition( "xyz", GzVectorSet( 1.23456, -0.0001, 7 ) );
  node->SetRotation( "rpy", GzQuaternFromEuler( 0, 0, DTOR( 44.7 ) ) );
  node->SetString( "id", "new" );
  node->SetString( "absent", "ignored" );
  CHECK( file->Save( NULL ) == 0 );
  delete file;

  file = new WorldFile;
  CHECK( file->Load( path ) == 0 );
  node = file->GetRootNode();
  CHECK( strcmp( node->GetString( "xyz", "" ), "1.235 0.000 7.000" ) == 0 );
  CHECK( node->GetTupleDouble( "rpy", 2, 0 ) == 44.7 && strcmp( node->GetString( "id", "" ), "new" ) == 0 );
  CHECK( !node->IsDefined( "absent" ) );
  CHECK( file->Save( "/no/such/directory/x.world" ) != 0 );
  delete file;
  return 0;
}

int Archivist::Geometry()
{
  GzPose a = GzPoseSet( GzVectorSet( 1, 2, 3 ), GzQuaternFromEuler( 0.1, -0.2, 2.5 ) );
  GzPose b = { { -1, 0.5, 2 }, { 0.5, 0.5, -0.5, 0.5 } };
  GzPose back = GzCoordPoseSub( GzCoordPoseAdd( b, a ), a );
  CHECK( GzVectorMag( GzVectorSub( back.pos, b.pos ) ) < 1e-12 );
  CHECK( NEAR( GzQuaternMul( back.rot, GzQuaternInverse( b.rot ) ).u, 1, 1e-12 ) );
  CHECK( GzPoseFinite( a ) && !GzVectorFinite( GzVectorUnit( GzVectorZero() ) ) );
  GzVector x = GzCoordPositionAdd( GzVectorSet( 1, 0, 0 ), GzVectorZero(), GzPosePointAt( a.pos, b.pos, GzVectorSet( 0, 0, 1 ) ).rot );
  CHECK( GzVectorMag( GzVectorSub( x, GzVectorUnit( GzVectorSub( b.pos, a.pos ) ) ) ) < 1e-9 );
  GzQuatern axis = GzQuaternToAxis( GzQuaternFromAxis( 0, 0, 3, 1.0 ) );
  CHECK( NEAR( axis.u, 1.0, 1e-12 ) && axis.z > 0 && axis.x == 0 );
  CHECK( NEAR( GzQuaternToEuler( GzQuaternScale( 0.5, GzQuaternFromEuler( 0, 0, 1 ) ) ).z, 0.5, 1e-12 ) );
  CHECK( NEAR( NORMALIZE( 3 * M_PI / 2 ), -M_PI / 2, 1e-12 ) && Round( -2.5 ) == -2 && IsOdd( 3 ) && IsEven( 0 ) );
  CHECK( RTOD( DTOR( 77.0 ) ) > 76.99 && Max( 1, 2.5 ) == 2.5 && Min( -1, 1 ) == -1 );
  uint bits = GZ_ALL_COLLIDE & ~GZ_LASER_COLLIDE;
  uchar small = GZ_RENDER_MAX_PASSES;
  CHECK( bits == 0xFFFFFFFDu && small == 3 && GZ_NONE_COLLIDE == 0 && GZ_LASER_CAMERA == 1 );
  return 0;
}

void Archivist::Say()
{
  PRINT_ERR( "error of the plugin" );
  PRINT_ERR3( "%s, %d, %g", "error", 3, 0.5 );
  PRINT_WARN( "warning of the plugin" );
  PRINT_WARN2( "%d%% of %s", 50, "it" );
  PRINT_MSG0( 0, "important" );
  PRINT_MSG1( 1, "informative %d", 1 );
  PRINT_MSG7( 9, "%d %d %d %d %d %d %d", 1, 2, 3, 4, 5, 6, 7 );
  PRINT_WARN1( "%d", 1 );
  PRINT_WARN3( "%d %d %d", 1, 2, 3 );
  PRINT_ERR1( "%d", 1 );
  PRINT_ERR2( "%d %d", 1, 2 );
  PRINT_MSG2( 2, "%d %d", 1, 2 );
  PRINT_MSG3( 2, "%d %d %d", 1, 2, 3 );
  PRINT_MSG4( 2, "%d %d %d %d", 1, 2, 3, 4 );
  PRINT_MSG5( 2, "%d %d %d %d %d", 1, 2, 3, 4, 5 );
  PRINT_MSG6( 2, "%d %d %d %d %d %d", 1, 2, 3, 4, 5, 6 );
  PRINT_GL_ERR();
}

int Archivist::Init( WorldFile *file, WorldFileNode *node )
{
  CHECK( file->WarnUnused() || true );
  node->Print();
  return 0;
}

void Archivist::Update( double step )
{
  if ( seen["Update"]++ == 0 )
    EXPECT( this->world->Save() == 0 );
}
