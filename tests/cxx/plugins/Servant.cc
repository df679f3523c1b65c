// Serves many interfaces at once.
#include <assert.h>
#include <stdio.h>
#include <string.h>

#include <gazebo.h>
#include <gazebo/World.hh>
#include <gazebo/WorldFile.hh>
#include <gazebo/ModelFactory.hh>
#include <gazebo/Body.hh>
#include <gazebo/BoxGeom.hh>

#include "check.h"

#define SERVE( type )                                                                                                 \
  this->type = gz_##type##_alloc();                                                                                   \
  if ( gz_##type##_create( this->type, this->world->gz_server, this->GetId(), "Servant", (int) this,                  \
                           (int) this->parent )                                                                       \
       != 0 )                                                                                                         \
    return -1;                                                                                                        \
  CHECK( this->type->data->head.size == sizeof( *this->type->data ) )

#define DISMISS( type )                                                                                               \
  if ( gz_##type##_destroy( this->type ) != 0 )                                                                       \
    return -1;                                                                                                        \
  gz_##type##_free( this->type )

class Servant : public Model
{
  public: Servant( World *world ) : Model( world ), battery( 12.4 ), due( 0 ) {}
  public: virtual ~Servant() { delete this->body; }

  public: virtual int Load( WorldFile *file, WorldFileNode *node )
  {
    this->body = new Body( this->world );
    ( new BoxGeom( this->body, this->modelSpaceId, 0.4, 0.3, 0.2 ) )->SetMass( 4 );
    this->AddBody( this->body, true );
    this->body->SetGravityMode( false );
    this->battery = node->GetDouble( "batteryLevel", this->battery );
    return 0;
  }

  public: virtual int Init( WorldFile *file, WorldFileNode *node )
  {
    SERVE( position );
    SERVE( power );
    SERVE( sonar );
    SERVE( gripper );
    SERVE( gps );
    SERVE( truth );
    SERVE( ptz );
    SERVE( actarray );
    SERVE( ir );
    SERVE( wifi );
    SERVE( joint );
    return 0;
  }

  public: virtual int Fini()
  {
    DISMISS( joint );
    DISMISS( wifi );
    DISMISS( ir );
    DISMISS( actarray );
    DISMISS( ptz );
    DISMISS( truth );
    DISMISS( gps );
    DISMISS( gripper );
    DISMISS( sonar );
    DISMISS( power );
    DISMISS( position );
    return 0;
  }

  public: virtual void Update( double step )
  {
    double now = this->world->GetSimTime(), speed, turn;

    if ( gz_position_lock( this->position, 1 ) == 0 )
    {
      speed = this->position->data->cmd_enable_motors ? this->position->data->cmd_vel_pos[0] : 0;
      turn = this->position->data->cmd_vel_rot[2];
      gz_position_unlock( this->position );
      GzQuatern rot = this->body->GetRotation();
      this->body->SetLinearVel( GzCoordPositionAdd( GzVectorSet( speed, 0, 0 ), GzVectorZero(), rot ) );
      this->body->SetAngularVel( GzVectorSet( 0, 0, turn ) );
    }
    this->battery -= 0.001 * step;
    if ( now < this->due )
      return;
    this->due = now + 0.1;

    gz_position_lock( this->position, 1 );
    this->position->data->time = now;
    this->position->data->pos[0] = this->body->GetPosition().x;
    this->position->data->pos[1] = this->body->GetPosition().y;
    this->position->data->rot[2] = GzQuaternToEuler( this->body->GetRotation() ).z;
    gz_position_unlock( this->position );

    gz_power_lock( this->power, 1 );
    this->power->data->time = now;
    this->power->data->levels[0] = this->battery;
    gz_power_unlock( this->power );

    gz_truth_lock( this->truth, 1 );
    this->truth->data->time = now;
    GzPose pose = this->GetPose();
    memcpy( this->truth->data->pos, &pose.pos, sizeof( pose.pos ) );
    memcpy( this->truth->data->rot, &pose.rot, sizeof( pose.rot ) );
    gz_truth_unlock( this->truth );

    gz_gps_lock( this->gps, 1 );
    this->gps->data->time = now;
    this->gps->data->utc_time = this->world->utcOffset + now;
    this->gps->data->utm_e = this->world->utmOffset.x + pose.pos.x;
    gz_gps_unlock( this->gps );

    gz_sonar_lock( this->sonar, 1 );
    this->sonar->data->sonar_count = 16;
    gz_sonar_unlock( this->sonar );
    gz_ptz_lock( this->ptz, 1 );
    this->ptz->data->pan = this->ptz->data->cmd_pan;
    gz_ptz_unlock( this->ptz );
    gz_position_post( this->position );
  }

  private: Body *body;
  private: double battery, due;
  private: gz_position_t *position;
  private: gz_power_t *power;
  private: gz_sonar_t *sonar;
  private: gz_gripper_t *gripper;
  private: gz_gps_t *gps;
  private: gz_truth_t *truth;
  private: gz_ptz_t *ptz;
  private: gz_actarray_t *actarray;
  private: gz_ir_t *ir;
  private: gz_wifi_t *wifi;
  private: gz_joint_t *joint;
};

GZ_REGISTER_PLUGIN( "Servant", Servant )
