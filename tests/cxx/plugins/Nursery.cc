// One file with several models, which makes and moves others.
#include <string.h>

#include <gazebo/World.hh>
#include <gazebo/WorldFile.hh>
#include <gazebo/ModelFactory.hh>
#include <gazebo/Body.hh>
#include <gazebo/BoxGeom.hh>
#include <gazebo/SphereGeom.hh>
#include <gazebo/HingeJoint.hh>

#include "check.h"

class Child : public Model
{
  public: static int alive;
  public: Child( World *world ) : Model( world ) { alive++; }
  public: virtual ~Child() { alive--; }
  public: virtual int Load( WorldFile *file, WorldFileNode *node )
  {
    Body *body = new Body( this->world );
    ( new SphereGeom( body, this->modelSpaceId, node->GetLength( "radius", 0.1 ) ) )->SetMass( 0.5 );
    this->AddBody( body, true );
    this->logPoses = true;
    return 0;
  }
  public: virtual int Init( WorldFile *file, WorldFileNode *node )
  {
    CHECK( file != NULL && node == this->node );
    return 0;
  }
  public: virtual int Fini() { return 0; }
  public: virtual void Update( double step ) {}
};

int Child::alive = 0;

GZ_REGISTER_STATIC( "Child", Child )

class Late : public Child
{
  public: Late( World *world ) : Child( world ) {}
};

GZ_REGISTER_STATIC( "Late", Late )

class Nursery : public Model
{
  public: Nursery( World *world ) : Model( world ), updates( 0 ) {}
  public: virtual ~Nursery() {}

  public: virtual int Load( WorldFile *file, WorldFileNode *node )
  {
    Body *body = new Body( this->world, "crib" );
    ( new BoxGeom( body, this->modelSpaceId, 0.5, 0.5, 0.1 ) )->SetMass( 5 );
    this->AddBody( body, true );
    body->SetGravityMode( false );
    CHECK( strcmp( this->GetName(), "Nursery" ) == 0 && strcmp( this->GetId(), "m0" ) == 0 );
    CHECK( this->GetIntId() > 0 && this->GetParentIntId() == 0 && this->parent == NULL );
    ModelFactory::RegisterModel( "static", "Late", NewLate );
    return 0;
  }

  public: virtual int Init( WorldFile *file, WorldFileNode *node )
  {
    CHECK( this->young.LoadString(
             "<n xmlns:model='m'><model:Child><id>c1</id><xyz>0 0 1</xyz></model:Child>"
             "<model:Late><id>c2</id><xyz>5 0 1</xyz><radius>0.2</radius></model:Late></n>" )
           == 0 );
    WorldFileNode *each = this->young.GetRootNode()->GetChild();
    this->before = this->world->GetNumModels();
    CHECK( this->world->LoadModel( each, this ) == 0 );
    CHECK( this->world->LoadModel( each->GetNext(), NULL ) == 0 );
    return 0;
  }

  public: virtual int Fini() { return 0; }

  public: virtual void Update( double step )
  {
    Model *first, *second, **all;

    if ( ++this->updates != 10 && this->updates != 60 )
      return;
    EXPECT( this->world->GetNumModels() == this->before + 2 && Child::alive == 2 );
    all = this->world->GetModels();
    first = all[this->before];
    second = all[this->before + 1];
    EXPECT( strcmp( first->GetId(), "c1" ) == 0 && strcmp( second->GetName(), "Late" ) == 0 );
    EXPECT( first->parent == this && first->parentBody == this->GetBody() && first->joint != NULL );
    EXPECT( first->GetParentIntId() == this->GetIntId() && second->parent == NULL );
    EXPECT( NEAR( first->GetPose().pos.z - this->GetPose().pos.z, 1, 0.02 ) && first->initPose.pos.z == 1 );
    if ( this->updates == 10 )
    {
      EXPECT( fabs( first->joint->GetAngle() ) < 0.01 );
      GzPose there = GzPoseSet( GzVectorSet( 3, 0, 2 ), GzQuaternFromEuler( 0, 0, 1 ) );
      this->world->SetModelPose( this, there ); // the child moves along
      EXPECT( NEAR( first->GetPose().pos.x, 3, 1e-9 ) && NEAR( first->GetPose().pos.z, 3, 0.02 ) );
      second->GetBody()->SetLinearVel( GzVectorSet( 0, 5, 0 ) );
    }
    else
    {
      EXPECT( second->GetPose().pos.y > 1 );
      EXPECT( ( (Child *) second )->poseCount >= 2 );
      first->Detach();
      EXPECT( first->joint == NULL );
      second->SetPose( GzPoseSet( GzVectorSet( 0, 9, 0 ), GzQuaternIdent() ) );
      EXPECT( GzVectorMag( second->GetBody()->GetLinearVel() ) == 0 );
      EXPECT( ModelFactory::NewModel( this->world, "Nothing" ) == NULL );
      this->world->ResetModelPoses();
      EXPECT( NEAR( second->GetPose().pos.x, 5, 1e-9 ) && NEAR( second->GetPose().pos.z, 1, 1e-9 ) );
      GzPose home = this->GetPose();
      EXPECT( GzVectorMag( GzVectorSub( home.pos, this->initPose.pos ) ) < 1e-9 );
    }
  }

  private: WorldFile young;
  private: int before, updates;
};

GZ_REGISTER_STATIC( "Nursery", Nursery )

extern "C" int gazebo_plugin_init( void )
{
  RegisterNursery();
  RegisterChild();
  return 0;
}
