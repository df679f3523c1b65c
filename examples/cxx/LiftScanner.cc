/* Desc: A laser on a mast that a slider lifts: laser and position interfaces
 */

#include <math.h>

#include <gazebo.h>
#include <gazebo/World.hh>
#include <gazebo/WorldFile.hh>
#include <gazebo/ModelFactory.hh>
#include <gazebo/Body.hh>
#include <gazebo/BoxGeom.hh>
#include <gazebo/CylinderGeom.hh>
#include <gazebo/SliderJoint.hh>
#include <gazebo/RayProximity.hh>

#define RAY_COUNT 61
#define MAX_RANGE 5.0
#define STROKE 0.5
#define MAX_FORCE 200.0


class LiftScanner : public Model
{
  public: LiftScanner( World *world ) : Model( world )
    {
      this->base = this->head = NULL;
      this->slider = NULL;
      this->rays = NULL;
    }

  public: virtual ~LiftScanner()
    {
      if (this->rays)
        delete this->rays;
      if (this->slider)
        delete this->slider;
      if (this->head)
        delete this->head;
      if (this->base)
        delete this->base;
    }

  // Load the model
  public: virtual int Load( WorldFile *file, WorldFileNode *node )
    {
      int i;
      double angle, fov;
      Geom *geom;

      this->updatePeriod = 1.0 / (node->GetDouble("scanRate", 10.0) + 1e-6);
      this->updateTime = -this->updatePeriod;

      this->base = new Body( this->world );
      geom = new BoxGeom( this->base, this->modelSpaceId, 0.4, 0.4, 0.1 );
      geom->SetRelativePosition( GzVectorSet(0, 0, 0.05) );
      geom->SetMass( 20.0 );
      this->AddBody( this->base, true );

      this->head = new Body( this->world, "head" );
      geom = new CylinderGeom( this->head, this->modelSpaceId, 0.05, 0.1 );
      geom->SetMass( 2.0 );
      geom->SetColor( GzColor(0.1, 0.1, 0.1) );
      this->AddBody( this->head );
      this->head->SetPosition( GzVectorSet(0, 0, 0.3) );

      this->slider = new SliderJoint( this->world->worldId );
      this->slider->Attach( this->head, this->base );
      this->slider->SetAxis( 0, 0, 1 );
      this->slider->SetParam( dParamLoStop, 0.0 );
      this->slider->SetParam( dParamHiStop, STROKE );

      fov = node->GetAngle( "fov", DTOR(180) );
      this->rays = new RayProximity( this->world, this->head, RAY_COUNT );
      for (i = 0; i < RAY_COUNT; i++)
      {
        angle = fov * i / (RAY_COUNT - 1) - fov / 2;
        this->rays->SetRay( i, GzVectorSet(0.06 * cos(angle), 0.06 * sin(angle), 0),
                            GzVectorSet(MAX_RANGE * cos(angle), MAX_RANGE * sin(angle), 0) );
      }
      this->fov = fov;
      return 0;
    }

  // Initialize the model
  public: virtual int Init( WorldFile *file, WorldFileNode *node )
    {
      this->laser = gz_laser_alloc();
      if (gz_laser_create(this->laser, this->world->gz_server, this->GetId(), "LiftScanner",
                          this->GetIntId(), this->GetParentIntId()) != 0)
        return -1;
      this->position = gz_position_alloc();
      if (gz_position_create(this->position, this->world->gz_server, this->GetId(), "LiftScanner",
                             this->GetIntId(), this->GetParentIntId()) != 0)
        return -1;
      return 0;
    }

  // Finalize the model
  public: virtual int Fini()
    {
      gz_position_destroy( this->position );
      gz_position_free( this->position );
      gz_laser_destroy( this->laser );
      gz_laser_free( this->laser );
      return 0;
    }

  // Update the model
  public: virtual void Update( double step )
    {
      int i;

      if (step == 0 || this->world->GetSimTime() - this->updateTime < this->updatePeriod - 1e-9)
        return;
      this->updateTime = this->world->GetSimTime();

      gz_position_lock( this->position, 1 );
      this->slider->SetParam( dParamVel, this->position->data->cmd_vel_pos[2] );
      this->slider->SetParam( dParamFMax, MAX_FORCE );
      this->position->data->time = this->world->GetSimTime();
      this->position->data->pos[2] = this->slider->GetPosition();
      this->position->data->vel_pos[2] = this->slider->GetPositionRate();
      gz_position_unlock( this->position );

      this->rays->Update();
      gz_laser_lock( this->laser, 1 );
      this->laser->data->time = this->world->GetSimTime();
      this->laser->data->min_angle = -this->fov / 2;
      this->laser->data->max_angle = +this->fov / 2;
      this->laser->data->res_angle = this->fov / (RAY_COUNT - 1);
      this->laser->data->max_range = MAX_RANGE;
      this->laser->data->range_count = RAY_COUNT;
      for (i = 0; i < RAY_COUNT; i++)
      {
        this->laser->data->ranges[i] = Min(0.06 + this->rays->GetRange(i), MAX_RANGE);
        this->laser->data->intensity[i] = (int) this->rays->GetRetro(i);
      }
      gz_laser_unlock( this->laser );
      gz_laser_post( this->laser );
    }

  private: Body *base, *head;
  private: SliderJoint *slider;
  private: RayProximity *rays;
  private: gz_laser_t *laser;
  private: gz_position_t *position;
  private: double updateTime, updatePeriod;
  private: double fov;
};


// Register the model
GZ_REGISTER_PLUGIN("LiftScanner", LiftScanner)
