// Six bodies in a row, with a joint of another kind between any two.
#ifndef LINKAGE_HH
#define LINKAGE_HH

#include <gazebo/Model.hh>

class Body;
class Joint;
class HingeJoint;
class Hinge2Joint;
class SliderJoint;
class BallJoint;
class UniversalJoint;
class JointGroup;

class Linkage : public Model
{
  public: Linkage( World *world );
  public: virtual ~Linkage();
  public: virtual int Load( WorldFile *file, WorldFileNode *node );
  public: virtual int Init( WorldFile *file, WorldFileNode *node );
  public: virtual int Fini();
  public: virtual void Update( double step );

  private: enum { COUNT = 6 };
  private: Body *links[COUNT];
  private: HingeJoint *hinge;
  private: Hinge2Joint *axle;
  private: SliderJoint *slider;
  private: BallJoint *ball;
  private: UniversalJoint *universal;
  private: JointGroup *group;
  private: double speed;
  private: int updates;
};

#endif
