// A camera, a stereo camera, an image file, and a camera interface.
#include <stdio.h>
#include <string.h>

#include <gazebo.h>
#include <gazebo/World.hh>
#include <gazebo/WorldFile.hh>
#include <gazebo/ModelFactory.hh>
#include <gazebo/Body.hh>
#include <gazebo/BoxGeom.hh>
#include <gazebo/FrustrumGeom.hh>
#include <gazebo/LightGeom.hh>
#include <gazebo/Camera.hh>
#include <gazebo/StereoCamera.hh>
#include <gazebo/Image.hh>
#include <gazebo/GLContext.hh>
#include <gazebo/RenderOptions.hh>

#include "check.h"

class Watcher : public Model
{
  public: Watcher( World *world ) : Model( world ), camera( NULL ), stereo( NULL ), iface( NULL ), count( 0 ) {}
  public: virtual ~Watcher()
  {
    delete this->camera;
    delete this->stereo;
    delete this->body;
  }

  public: virtual int Load( WorldFile *file, WorldFileNode *node )
  {
    this->body = new Body( this->world, "", true );
    this->frustrum = new FrustrumGeom( this->body, this->modelSpaceId, 4.0 / 3, 0.1, 20 );
    this->frustrum->SetFOV( DTOR( 60 ) );
    this->AddBody( this->body, true );

    // A red wall 3 m ahead, and a lamp.
    this->wall = new Body( this->world, "wall", true );
    Geom *geom = new BoxGeom( this->wall, this->modelSpaceId, 0.1, 1, 4 );
    geom->SetColor( GzColor( 1, 0, 0 ) );
    geom->SetEmissionColor( GzColor( 0.5, 0, 0 ) );
    uint8_t white[3] = { 255, 255, 255 };
    CHECK( geom->SetTexture2D( 1, 1, white ) == 0 );
    geom->SetTexture2DSize( GzVectorSet( 1, 1, 0 ) );
    this->wall->SetPosition( GzVectorSet( 3, 0.5, 0 ) );
    this->AddBody( this->wall );
    LightGeom *lamp = new LightGeom( this->body, this->modelSpaceId );
    if ( LightGeom::CheckAvailable() )
      lamp->SetAttenuation( GzVectorSet( 1, 0, 0 ) );

    GLContext context;
    CHECK( context.Init( 320, 240, 24, 8, 16, "GLXP" ) == 0 && context.MakeCurrent() == 0 );
    context.Fini();

    RenderOptions options;
    this->camera = new Camera( this->world );
    this->camera->InitContext( context );
    CHECK( this->camera->Init( 0, 48, 1.0, 0.1, 20, "AUTO", 16 ) == -1 );
    CHECK( this->camera->Init( 64, 48, DTOR( 60 ), 0.1, 20, "AUTO", 16 ) == 0 );
    this->camera->GetRenderOptions( &options );
    options.displaySkins = true;
    options.polygonMode = GL_FILL;
    options.shadeModel = GL_FLAT;
    this->camera->SetRenderOptions( &options );
    memset( &options, 0, sizeof( int ) );
    this->camera->GetRenderOptions( &options );
    CHECK( options.displaySkins && options.displayMaterials && options.shadeModel == GL_FLAT );
    this->camera->SetFOV( 1.0 );
    CHECK( NEAR( this->camera->GetFOV(), 1.0, 1e-12 ) );

    this->stereo = new StereoCamera( this->world );
    CHECK( this->stereo->Init( 64, 48, DTOR( 60 ), -1, 0.1, 20, "AUTO" ) == -1 );
    CHECK( this->stereo->Init( 64, 48, DTOR( 60 ), 0.2, 0.1, 20, "AUTO" ) == 0 );
    this->stereo->EnableImage( 1, false );
    this->stereo->EnableDisparity( 0, true );
    CHECK( NEAR( this->stereo->GetFOV(), DTOR( 60 ), 1e-12 ) );
    return 0;
  }

  public: virtual int Init( WorldFile *file, WorldFileNode *node )
  {
    this->iface = gz_camera_alloc();
    return gz_camera_create( this->iface, this->world->gz_server, this->GetId(), "Watcher", (int) this, (int) this->parent );
  }

  public: virtual int Fini()
  {
    CHECK( this->camera->Fini() == 0 && this->stereo->Fini() == 0 );
    gz_camera_destroy( this->iface );
    gz_camera_free( this->iface );
    return 0;
  }

  public: virtual void Update( double step )
  {
    int w, h;
    if ( ++this->count % 50 != 1 )
      return;
    this->camera->SetPose( this->body->GetPose() );
    this->camera->Update();
    this->camera->GetImageSize( &w, &h );
    EXPECT( w == 64 && h == 48 );
    const unsigned char *image = this->camera->GetImageData();
    const unsigned char *left = image + 3 * ( 24 * w + 20 ), *right = image + 3 * ( 24 * w + 50 );
    EXPECT( left[0] > 100 && left[1] < 50 && right[2] > 100 ); // wall, sky

    double z = this->camera->GetZValue( 20, 24 );
    EXPECT( z > 0 && z < 1 );
    EXPECT( this->camera->GetZValue( 50, 24 ) == 1 );
    GzPose turned = this->camera->CalcCameraDelta( 2, GzVectorSet( 32, 24, z ), GzVectorSet( 40, 24, 0 ) );
    EXPECT( GzQuaternToEuler( turned.rot ).z != 0 && GzVectorMag( turned.pos ) == 0 );

    this->stereo->SetPose( this->camera->GetPose() );
    this->stereo->Update();
    this->stereo->GetSize( &w, &h );
    const float *disparity = this->stereo->GetDisparityData( 0 );
    double expected = w / ( 2 * tan( this->stereo->GetFOV() / 2 ) ) * 0.2 / 2.95;
    EXPECT( NEAR( disparity[24 * w + 20], expected, 0.05 ) );
    EXPECT( this->stereo->GetImageData( 0 )[3 * ( 24 * w + 20 )] > 100 );

    gz_camera_lock( this->iface, 1 );
    this->iface->data->time = this->world->GetSimTime();
    this->iface->data->width = w;
    this->iface->data->height = h;
    this->iface->data->image_size = 3 * w * h;
    for ( int y = 0; y < h; y++ ) // top row first
      memcpy( this->iface->data->image + 3 * w * y, image + 3 * w * ( h - 1 - y ), 3 * w );
    gz_camera_unlock( this->iface );
    gz_camera_post( this->iface );
  }

  private: Body *body, *wall;
  private: FrustrumGeom *frustrum;
  private: Camera *camera;
  private: StereoCamera *stereo;
  private: gz_camera_t *iface;
  private: int count;
};

GZ_REGISTER_PLUGIN( "Watcher", Watcher )
