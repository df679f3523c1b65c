/* Desc: A box on two driven wheels and a skid
 */

#ifndef EXAMPLEMODEL_HH
#define EXAMPLEMODEL_HH

#include <gazebo/Model.hh>

// Forward declarations
class Body;
class HingeJoint;
typedef struct gz_position gz_position_t;


class ExampleModel : public Model
{
  // Constructor, destructor
  public: ExampleModel( World *world );
  public: virtual ~ExampleModel();

  // Load the model
  public: virtual int Load( WorldFile *file, WorldFileNode *node );

  // Initialize and finalize the model
  public: virtual int Init( WorldFile *file, WorldFileNode *node );
  public: virtual int Fini();

  // Update the model state
  public: virtual void Update( double step );

  // Create a wheel and its joint
  private: void LoadWheel( int i, double y, double roll );

  // Odometry, and the exchange of data with clients
  private: void UpdateOdometry( double step );
  private: void UpdatePosition();

  // ODE objects
  private: Body *chassis;
  private: Body *wheels[2];
  private: HingeJoint *joints[2];

  // Interface
  private: gz_position_t *position;

  // Time of the last update, and between updates
  private: double updateTime, updatePeriod;

  // Odometric pose
  private: double odomPose[3];
};

#endif
