"""The classes of the old C++ API, each once: from here come the headers, and the functions that they call.

A line of `methods` is a C++ prototype with a comment. A method calls the function `Class_Method` of the table with the
object's handle; its arguments and result are converted by their types. `functions` are further ones of the table, for
the C++ code in `public` and `protected`. A name that ends with `_` makes an overload: `SetAxis_` is another `SetAxis`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

__all__ = ["CLASSES", "FUNCTIONS", "CxxClass"]


@dataclass(frozen=True)
class CxxClass:
    """One class of the old API, which has a header of its own."""

    name: str
    help: str
    methods: str = ""
    base: str = "LibgzObject"
    includes: tuple[str, ...] = ()
    forward: tuple[str, ...] = ()  # classes that are only declared
    public: str = ""  # constructors and data, as C++
    protected: str = ""
    functions: str = ""


def _geom(name: str, help: str, parameters: str, methods: str = "", public: str = "", functions: str = "") -> CxxClass:
    """A kind of geom: its constructor begins with the body and the model's space."""
    passed = "".join(f", {_passed(word)}" for word in parameters.split(",")) if parameters else ""
    listed = f", {parameters}" if parameters else ""
    constructor = f"""\
  public: {name}( Body *body, dSpaceID space{listed} ) : Geom( space )
    {{
      this->body = body;
      this->libgz_handle = libgz_bound->{name}_new( this, libgz_handle_of( body ), space{passed} );
      this->libgz_made();
    }}
"""
    return CxxClass(
        name,
        help,
        methods,
        base="Geom",
        includes=("Geom.hh", "Body.hh"),
        public=constructor + public,
        functions=f"long {name}_new(void *pointer, Body *body, dSpaceID space{listed})\n{functions}",
    )


def _passed(parameter: str) -> str:
    """A constructor's argument as the table takes it."""
    kind, name = parameter.split()
    return f"{name}.x, {name}.y, {name}.z" if kind == "GzVector" else name


def _joint(name: str, help: str, methods: str) -> CxxClass:
    public = "".join(
        f"""\
  public: {name}( {world}, JointGroup *group = NULL )
    {{
      this->libgz_handle = libgz_bound->{name}_new( this, {passed}, libgz_handle_of( group ) );
      this->jointId = (dJointID) libgz_bound->Joint_GetJointId( this->libgz_handle );
      libgz_check();
    }}
"""
        for world, passed in (("World *world", "world ? world->worldId : NULL"), ("dWorldID world", "world"))
    )
    if name == "HingeJoint":  # of which libgz makes some itself
        public += """\
  public: HingeJoint( libgz_wrapping, long handle )
    {
      this->libgz_wrap( handle );
      this->jointId = (dJointID) libgz_bound->Joint_GetJointId( handle );
    }
"""
    return CxxClass(
        name,
        help,
        methods,
        base="Joint",
        includes=("Joint.hh", "JointGroup.hh", "World.hh"),
        public=public + _both_forms(methods),
        functions=f"long {name}_new(void *pointer, dWorldID world, JointGroup *group)\n",
    )


def _both_forms(methods: str) -> str:
    """Overloads for axes and anchors: some versions had them as a GzVector, others as three numbers and a dVector3."""
    code = ""
    for setter in re.findall(r"void (Set\w+)\( GzVector \w+ \)", methods):
        code += f"""
  /// The same by three numbers.
  public: void {setter}( double x, double y, double z ) {{ this->{setter}( GzVectorSet( x, y, z ) ); }}
"""
    for setter in re.findall(r"void (Set\w+)\( double x, double y, double z \)", methods):
        code += f"""
  /// The same by a vector.
  public: void {setter}( GzVector v ) {{ this->{setter}( v.x, v.y, v.z ); }}
"""
    for getter in re.findall(r"GzVector (Get\w+)\(\) const", methods):
        code += f"""
  /// The same by three numbers.
  public: void {getter}( dVector3 result ) const
    {{
      GzVector found = this->{getter}();
      result[0] = found.x;
      result[1] = found.y;
      result[2] = found.z;
    }}
"""
    return code


_JOINT = """
int GetType() const; ODE's number of the kind
Body *GetJointBody( int index ) const; the first (0) or second (1) body; NULL for the world
bool AreConnected( Body *one, Body *two ) const; whether a joint connects two bodies
void SetFixed(); keep the bodies as they are; an error but for fixed joints
void Attach( Body *one, Body *two ); join two bodies; NULL is the world
void Detach(); detach both bodies
virtual void SetAnchor( GzVector anchor ); place the joint [m]
virtual GzVector GetAnchor() const; the anchor [m]
virtual void SetParam( int parameter, double value ); set a parameter such as dParamVel [rad/s or m/s]
virtual double GetParam( int parameter ) const; the value of a parameter
"""

CLASSES = (
    CxxClass(
        "WorldFileNode",
        "An element of the worldfile. An attribute of a model is a child element; its text is the value.",
        """
const char *GetName(); the tag's name without prefix
const char *GetNSPrefix(); the prefix, NULL without one
WorldFileNode *GetNext(); the next element beside this one, or NULL
WorldFileNode *GetChildByNSPrefix( const char *prefix ); the first child with a prefix, or NULL
void Print(); print the element and all in it
bool WarnUnused(); warn of elements that nothing read; whether there are any
bool IsDefined( const char *key ); whether an attribute is present
void SetString( const char *key, const char *value ); change an attribute that is present
int GetInt( const char *key, int def, int require = 0 ); a whole number
double GetDouble( const char *key, double def, int require = 0 ); a number
bool GetBool( const char *key, bool def, int require = 0 ); true or false
double GetLength( const char *key, double def, int require = 0 ); a length [m]
double GetAngle( const char *key, double def, int require = 0 ); an angle: degrees in the file, [rad] here
double GetTime( const char *key, double def, int require = 0 ); a time [s]
GzVector GetPosition( const char *key, GzVector def ); three lengths [m]
void SetPosition( const char *key, GzVector position ); write three lengths [m]
GzQuatern GetRotation( const char *key, GzQuatern def ); roll, pitch, yaw in degrees as a quaternion
void SetRotation( const char *key, GzQuatern rotation ); write a quaternion as roll, pitch, yaw in degrees
GzColor GetColor( const char *key, GzColor def ); red, green, blue, and perhaps alpha
double GetTupleDouble( const char *key, int index, double def ); a number of a tuple
int GetTupleInt( const char *key, int index, int def ); a whole number of a tuple
double GetTupleLength( const char *key, int index, double def ); a length of a tuple [m]
double GetTupleAngle( const char *key, int index, double def ); an angle of a tuple: degrees in the file, [rad] here
""",
        includes=("Vector.hh", "Color.hh"),
        functions="""
WorldFileNode *WorldFileNode_GetChild(WorldFileNode *self, const char *name)
const char *WorldFileNode_GetString(WorldFileNode *self, const char *key, int require)
const char *WorldFileNode_GetFilename(WorldFileNode *self, const char *key, int require)
const char *WorldFileNode_SearchFilename(WorldFileNode *self, const char *key, const char *path, int require)
const char *WorldFileNode_GetTupleString(WorldFileNode *self, const char *key, int index)
""",
        public="""\
  public: WorldFileNode( libgz_wrapping, long handle ) { this->libgz_wrap( handle ); }

  /// The first child, or the first with a name; NULL if there is none.
  public: WorldFileNode *GetChild( const char *name = NULL )
    {
      void *found = libgz_bound->WorldFileNode_GetChild( this->libgz_handle, name );
      libgz_check();
      return (WorldFileNode *) found;
    }

  /// The text of an attribute as written.
  public: const char *GetString( const char *key, const char *def, int require = 0 )
    {
      return libgz_text( libgz_bound->WorldFileNode_GetString( this->libgz_handle, key, require ), def );
    }

  /// A file name, made absolute.
  public: const char *GetFilename( const char *key, const char *def, int require = 0 )
    {
      return libgz_text( libgz_bound->WorldFileNode_GetFilename( this->libgz_handle, key, require ), def );
    }

  /// A file, searched for in the current directory, beside the worldfile, and in a directory, which may be NULL.
  public: const char *SearchFilename( const char *key, const char *path, const char *def, int require = 0 )
    {
      return libgz_text( libgz_bound->WorldFileNode_SearchFilename( this->libgz_handle, key, path, require ), def );
    }

  /// A word of a tuple; the default without the attribute, NULL if it has fewer words.
  public: const char *GetTupleString( const char *key, int index, const char *def )
    {
      if ( !this->IsDefined( key ) )
        return def;
      return libgz_text( libgz_bound->WorldFileNode_GetTupleString( this->libgz_handle, key, index ), NULL );
    }
""",
    ),
    CxxClass(
        "WorldFile",
        "A worldfile.",
        """
bool WarnUnused(); warn of elements that nothing read; whether there are any
WorldFileNode *GetRootNode() const; the outermost element
""",
        includes=("WorldFileNode.hh",),
        functions="""
long WorldFile_new(void *pointer)
int WorldFile_Load(WorldFile *self, const char *filename)
int WorldFile_LoadString(WorldFile *self, const char *text)
int WorldFile_Save(WorldFile *self, const char *filename)
const char *WorldFile_GetFilename(WorldFile *self)
""",
        public="""\
  public: WorldFile() : filename( NULL )
    {
      this->libgz_handle = libgz_bound->WorldFile_new( this );
      libgz_check();
    }
  public: WorldFile( libgz_wrapping, long handle ) : filename( NULL )
    {
      this->libgz_wrap( handle );
      this->filename = (char *) libgz_bound->WorldFile_GetFilename( handle );
    }

  /// Read a file; 0, or -1 after an error message.
  public: int Load( const char *name )
    {
      int result = libgz_bound->WorldFile_Load( this->libgz_handle, name );
      libgz_check();
      this->filename = (char *) libgz_bound->WorldFile_GetFilename( this->libgz_handle );
      return result;
    }

  /// Read a text; 0, or -1 after an error message.
  public: int LoadString( const char *text )
    {
      int result = libgz_bound->WorldFile_LoadString( this->libgz_handle, text );
      libgz_check();
      return result;
    }

  /// Write the file, by default where it was read from; 0, or -1 after an error message.
  public: int Save( const char *name = NULL )
    {
      int result = libgz_bound->WorldFile_Save( this->libgz_handle, name );
      libgz_check();
      return result;
    }

  /// Where it was read from; NULL for a text.
  public: char *filename;
""",
    ),
    CxxClass(
        "Body",
        "A rigid body, or with `dummy` only a pose. Poses are global, velocities those of the centre of mass.",
        """
void UpdateCoM(); compute mass and centre of mass from the geoms again; geoms call this themselves
int GetNumGeoms(); how many geoms there are
void Enable( bool enable ); switch motion on or off
GzPose GetPose() const; global pose of the body frame [m]
GzVector GetPosition() const; global position of the body frame [m]
GzQuatern GetRotation() const; global rotation of the body frame
void SetPose( GzPose pose ); place the body frame [m]
void SetPosition( GzVector position ); move the body frame [m]
void SetRotation( GzQuatern rotation ); turn the body frame
GzPose GetCoMPose() const; global pose of the centre of mass [m]
GzVector GetLinearVel() const; velocity of the centre of mass [m/s], global
GzQuatern GetAngularVel() const; the quaternion's derivative, (0, w/2) q
void SetLinearVel( GzVector velocity ); set the velocity of the centre of mass [m/s], global
void SetAngularVel( GzVector velocity ); set the angular velocity [rad/s], global
void SetGravityMode( bool enable ); whether gravity acts on the body
int GetGravityMode(); 1 if gravity acts on the body
void SetFiniteRotationAxis( double x, double y, double z ); the axis about which mode 1 is exact
void SetFiniteRotationMode( int mode ); 1: integrate rotations exactly
void SetPickId( GLuint id ); set the pick number of all its geoms
GzVector GetForce(); the force of the next step [N]
GzVector GetTorque(); the torque of the next step [N m]
void SetForce( GzVector force ); replace the force of the next step [N], global
void SetTorque( double x, double y, double z ); replace the torque of the next step [N m], global
void AddForce( double x, double y, double z ); add a global force at the centre of mass [N]
void AddTorque( double x, double y, double z ); add a global torque [N m]
void AddRelForce( double x, double y, double z ); add a force along the body's axes [N]
void AddRelTorque( double x, double y, double z ); add a torque about the body's axes [N m]
void AddForceAtPos( double fx, double fy, double fz, double px, double py, double pz ); a force [N] at a point [m]
void AddForceAtRelPos( double fx, double fy, double fz, double px, double py, double pz ); a global force [N] at a point [m] in body axes, from the centre of mass
""",
        includes=("Vector.hh", "Ode.hh", "RenderOptions.hh"),
        forward=("World", "Geom"),
        functions="""
long Body_new(void *pointer, World *world, const char *name, bool dummy)
dBodyID Body_GetBodyId(Body *self)
dSpaceID Body_GetSpaceId(Body *self)
Geom *Body_GetGeom(Body *self, int index)
const char *Body_GetName(Body *self)
dWorldID Body_GetWorldId(Body *self)
""",
        public="""\
  public: Body( const World *world, const char *name = NULL, bool dummy = false ) : bodyName( NULL ), libgz_geoms( NULL )
    {
      this->libgz_handle = libgz_bound->Body_new( this, libgz_handle_of( world ), name, dummy );
      this->libgz_made();
    }
  public: Body( libgz_wrapping, long handle ) : bodyName( NULL ), libgz_geoms( NULL )
    {
      this->libgz_wrap( handle );
      this->libgz_made();
    }
  public: virtual ~Body() { free( this->libgz_geoms ); }

  /// The geoms in order of construction.
  public: Geom **GetGeoms()
    {
      int count = this->GetNumGeoms(), i;
      this->libgz_geoms = (Geom **) realloc( this->libgz_geoms, ( count + 1 ) * sizeof( Geom * ) );
      for ( i = 0; i < count; i++ )
        this->libgz_geoms[i] = (Geom *) libgz_bound->Body_GetGeom( this->libgz_handle, i );
      libgz_check();
      return this->libgz_geoms;
    }

  /// ODE's body; NULL for a dummy.
  public: dBodyID GetBodyId() const
    {
      void *id = libgz_bound->Body_GetBodyId( this->libgz_handle );
      libgz_check();
      return (dBodyID) id;
    }

  /// ODE's space of the model.
  public: dSpaceID GetSpaceId() const
    {
      void *id = libgz_bound->Body_GetSpaceId( this->libgz_handle );
      libgz_check();
      return (dSpaceID) id;
    }

  /// Accepted without effect: geoms are rendered without calls to plugins.
  public: void Render( int, RenderOptions * ) {}

  /// Its name; NULL without one.
  public: char *bodyName;
""",
        protected="""\
  private: void libgz_made()
    {
      libgz_check();
      this->bodyName = (char *) libgz_bound->Body_GetName( this->libgz_handle );
      this->worldId = (dWorldID) libgz_bound->Body_GetWorldId( this->libgz_handle );
      this->bodyId = (dBodyID) libgz_bound->Body_GetBodyId( this->libgz_handle );
    }

  protected: dWorldID worldId;
  protected: dBodyID bodyId;
  private: Geom **libgz_geoms;
""",
    ),
    CxxClass(
        "BaseGeom",
        "The physics of a geom.",
        """
void SetCategoryBits( uint bits ); set the collision category
void SetCollideBits( uint bits ); set the categories it collides with
void SetRelativePosition( GzVector position ); move the geom's centre in the body frame [m]
void SetRelativeRotation( GzQuatern rotation ); turn the geom in the body frame
GzPose GetPose() const; global pose of the geom's centre [m]
double GetBounce() const; the bounce in force
double GetSlip1() const; the value last set
double GetSlip2() const; the value last set
void SetMass( double mass ); set the total mass [kg]
""",
        includes=("Vector.hh", "Ode.hh", "ContactParams.hh"),
        forward=("Body",),
        functions="""
long BaseGeom_new(void *pointer, Body *body, dSpaceID space, dGeomID geom, dMass *mass, bool placeable)
dGeomID BaseGeom_GetGeomId(BaseGeom *self)
dMass *BaseGeom_GetBodyMassMatrix(BaseGeom *self)
bool BaseGeom_GetPlaceable(BaseGeom *self)
Body *BaseGeom_GetBody(BaseGeom *self)
void BaseGeom_SetExtraRotation(BaseGeom *self, GzQuatern rotation)
void BaseGeom_SetContact(BaseGeom *self, double kp, double kd, double bounce, double mu1, double mu2)
void BaseGeom_SetHardness(BaseGeom *self, double kp, double kd)
void BaseGeom_SetFriction(BaseGeom *self, double mu1, double mu2)
void BaseGeom_SetBounce(BaseGeom *self, double bounce)
void BaseGeom_SetSlip1(BaseGeom *self, double slip)
void BaseGeom_SetSlip2(BaseGeom *self, double slip)
void BaseGeom_SetRelativePose(BaseGeom *self, GzPose pose, bool updateCoM)
GzPose BaseGeom_GetRelativePose(BaseGeom *self)
""",
        public="""\
  public: explicit BaseGeom( dSpaceID space )
    : body( NULL ), placeableGeom( true ), spaceId( space ), transId( NULL ), geomId( NULL ), contact( new ContactParams )
    {
    }
  public: virtual ~BaseGeom() { delete this->contact; }

  /// Take a geom of ODE; called by the constructors of kinds of geom. A mass of NULL is none.
  public: void SetGeom( Body *owner, dGeomID geom, dMass *mass, bool placeable )
    {
      this->body = owner;
      this->libgz_handle = libgz_bound->BaseGeom_new( this, libgz_handle_of( owner ), this->spaceId, geom, mass, placeable );
      this->libgz_made();
    }

  /// Place the geom's centre in the body frame [m].
  public: virtual void SetRelativePose( GzPose pose, bool updateCoM = true )
    {
      libgz_bound->BaseGeom_SetRelativePose( this->libgz_handle, LIBGZ_POSE( pose ), updateCoM );
      libgz_check();
    }

  /// The pose in the body frame [m].
  public: virtual GzPose GetRelativePose() const
    {
      GzPose result;
      libgz_bound->BaseGeom_GetRelativePose( this->libgz_handle, &result.pos.x );
      libgz_check();
      return result;
    }

  /// Spring [N/m] and damper [N s/m] of contacts.
  public: void SetHardness( double kp, double kd )
    {
      libgz_bound->BaseGeom_SetHardness( this->libgz_handle, kp, kd );
      libgz_check();
      this->contact->kp.value = kp;
      this->contact->kd.value = kd;
    }

  /// Coulomb coefficients; the smaller one of two geoms applies.
  public: void SetFriction( double mu1, double mu2 )
    {
      libgz_bound->BaseGeom_SetFriction( this->libgz_handle, mu1, mu2 );
      libgz_check();
      this->contact->mu1.value = mu1;
      this->contact->mu2.value = mu2;
    }

  /// Coefficient of restitution, 0 to 1.
  public: void SetBounce( double bounce )
    {
      libgz_bound->BaseGeom_SetBounce( this->libgz_handle, bounce );
      libgz_check();
      this->contact->bounce.value = bounce;
    }

  /// Stored without effect.
  public: void SetSlip1( double slip )
    {
      libgz_bound->BaseGeom_SetSlip1( this->libgz_handle, slip );
      libgz_check();
      this->contact->slip1.value = slip;
    }

  /// Stored without effect.
  public: void SetSlip2( double slip )
    {
      libgz_bound->BaseGeom_SetSlip2( this->libgz_handle, slip );
      libgz_check();
      this->contact->slip2.value = slip;
    }

  /// ODE's geom; NULL if it is only rendered.
  public: dGeomID GetGeomId() const
    {
      void *id = this->libgz_handle == 0 ? NULL : libgz_bound->BaseGeom_GetGeomId( this->libgz_handle );
      libgz_check();
      return (dGeomID) id;
    }
  public: dGeomID GetTransId() const { return this->GetGeomId(); }

  /// The mass matrix in the body frame; NULL without mass.
  public: const dMass *GetBodyMassMatrix()
    {
      void *found = libgz_bound->BaseGeom_GetBodyMassMatrix( this->libgz_handle );
      libgz_check();
      return (const dMass *) found;
    }

  public: Body *body;
  public: bool placeableGeom;
""",
        protected="""\
  /// Constant rotation between ODE's shape and the geom.
  protected: void SetExtraRotation( GzQuatern rotation )
    {
      libgz_bound->BaseGeom_SetExtraRotation( this->libgz_handle, LIBGZ_QUATERN( rotation ) );
      libgz_check();
    }

  /// The C++ object of a geom is complete.
  protected: void libgz_made()
    {
      libgz_check();
      this->geomId = this->transId = (dGeomID) libgz_bound->BaseGeom_GetGeomId( this->libgz_handle );
      this->placeableGeom = libgz_bound->BaseGeom_GetPlaceable( this->libgz_handle ) != 0;
      libgz_check();
      if ( !this->libgz_wraps )
        this->contact->libgz_attach( this->libgz_handle );
    }

  protected: dSpaceID spaceId;
  protected: dGeomID transId, geomId;
  protected: ContactParams *contact;
""",
    ),
    CxxClass(
        "Geom",
        "The appearance of a geom, and how sensors see it.",
        """
void SetColor( const GzColor &color ); the whole material from one colour
void SetAmbientColor( const GzColor &color ); colour in ambient light
void SetDiffuseColor( const GzColor &color ); colour in direct light
void SetSpecularColor( const GzColor &color ); colour of highlights
void SetEmissionColor( const GzColor &color ); colour that the geom emits
void SetShadeModel( const char *mode ); accepted without effect
void SetPolygonMode( const char *mode ); accepted without effect
void SetTransparency( bool enable ); render in the transparent pass
void SetShininess( float exponent ); sharpness of highlights
void SetLaser( float value ); stored; no sensor uses it
void SetRetro( float value ); how much of a laser beam is reflected
void SetFiducial( int id ); the number that fiducial finders report; -1 for none
void SetPickId( GLuint id ); a number by which a user interface finds the geom
int SetTexture2DFile( const char *filename ); cover it with an image; 0, or -1 if there is no such file
void SetTexture2DSize( GzVector size ); metres that one image covers
int SetSkinFile( const char *filename ); render a mesh instead; 0, or -1 if there is no such file
void SetSkinNull( bool enable ); render nothing while skins are shown
void SetSkinPose( GzPose pose ); place the skin relative to the geom's centre [m]
void SetSkinScale( GzVector scale ); scale the skin
bool HasSkin(); whether a skin was set
bool HasSkinNull(); whether nothing is rendered while skins are shown
GzColor GetAmbientColor() const; colour in ambient light
GzColor GetDiffuseColor() const; colour in direct light
GzColor GetSpecularColor() const; colour of highlights
float GetTransparency() const; 1 in the transparent pass, else 0
float GetShininess() const; sharpness of highlights
float GetLaser() const; the value last set
float GetRetro() const; how much of a laser beam is reflected
int GetFiducial() const; the fiducial number
GLuint GetPickId() const; the pick number
""",
        base="BaseGeom",
        includes=("BaseGeom.hh", "Color.hh", "RenderOptions.hh"),
        forward=("GzImage",),
        functions="""
int Geom_SetTexture2D(Geom *self, int width, int height, const void *data)
int Geom_GetRenderOrder(Geom *self)
void Geom_SetRenderOrder(Geom *self, int order)
""",
        public="""\
  public: explicit Geom( dSpaceID space ) : BaseGeom( space ), renderOrder( this ) { this->libgz_look(); }
  public: Geom( libgz_wrapping, long handle ) : BaseGeom( (dSpaceID) NULL ), renderOrder( this )
    {
      this->libgz_look();
      this->libgz_wrap( handle );
      this->body = (Body *) libgz_bound->BaseGeom_GetBody( handle );
      this->libgz_made();
    }

  /// Cover it with an image of packed RGB; 0.
  public: int SetTexture2D( int width, int height, const uint8_t *data )
    {
      int result = libgz_bound->Geom_SetTexture2D( this->libgz_handle, width, height, data );
      libgz_check();
      return result;
    }

  /// Never called: geoms are rendered without calls to plugins.
  public: virtual void PreRender( RenderOptions * ) {}
  public: virtual void Render( RenderOptions * ) {}
  public: virtual void PostRender( RenderOptions * ) {}
  public: void RenderSkin( RenderOptions * ) {}

  /// A pass of rendering: a number, whose changes reach the geom once SetGeom was called.
  public: class LibgzRenderOrder
  {
    public: explicit LibgzRenderOrder( Geom *geom ) : owner( geom ) {}
    public: operator int() const
      {
        if ( this->owner->libgz_handle == 0 )
          return GZ_RENDER_OPAQUE;
        int result = libgz_bound->Geom_GetRenderOrder( this->owner->libgz_handle );
        libgz_check();
        return result;
      }
    public: LibgzRenderOrder &operator=( int order )
      {
        if ( this->owner->libgz_handle != 0 )
        {
          libgz_bound->Geom_SetRenderOrder( this->owner->libgz_handle, order );
          libgz_check();
        }
        return *this;
      }
    public: LibgzRenderOrder &operator=( const LibgzRenderOrder &other ) { return *this = (int) other; }
    private: LibgzRenderOrder( const LibgzRenderOrder & );
    private: Geom *owner;
  };
  public: LibgzRenderOrder renderOrder;
""",
        protected="""\
  protected: void SetList( int, GLuint, RenderOptions ) {}
  protected: void GetList( int, GLuint *list, RenderOptions * ) { *list = 0; }

  // For Render functions, which are never called: the look of a new geom. The getters have the present one.
  protected: bool transparency;
  protected: float laser, retro;
  protected: int fiducial;
  protected: GLfloat colorDiffuse[4], colorAmbient[4], colorSpecular[4], colorEmission[4];
  protected: GLfloat shininess;
  protected: GzImage *textureImage;
  protected: GzVector textureSize;
  protected: int pick;
  protected: bool dirty;

  private: void libgz_look()
    {
      int i;
      this->transparency = false;
      this->laser = 1;
      this->retro = 0;
      this->fiducial = -1;
      for ( i = 0; i < 4; i++ )
      {
        this->colorDiffuse[i] = i < 3 ? 0.8f : 1.0f;
        this->colorAmbient[i] = this->colorSpecular[i] = i < 3 ? 0.2f : 1.0f;
        this->colorEmission[i] = i < 3 ? 0.0f : 1.0f;
      }
      this->shininess = 0;
      this->textureImage = NULL;
      this->textureSize = GzVectorSet( 2, 2, 0 );
      this->pick = 0;
      this->dirty = true;
    }
""",
    ),
    _geom("BoxGeom", "A box of full lengths [m].", "double xDim, double yDim, double zDim"),
    _geom("SphereGeom", "A sphere [m].", "double radius"),
    _geom("CylinderGeom", "A cylinder along z [m].", "double radius, double length"),
    _geom(
        "WheelGeom",
        "A wheel about z: it rolls as a sphere, and looks like a tire [m].",
        "double totalRadius, double tireRadius",
    ),
    _geom(
        "PlaneGeom",
        "An infinite plane, normal . p = altitude [m], which does not follow its body.",
        "double altitude, GzVector normal",
    ),
    _geom(
        "RayGeom",
        "A ray in global terms.",
        "",
        """
void SetLength( double length ); set the length [m]
double GetLength() const; the length [m]
""",
        """\
  public: void Set( GzVector pos, GzVector dir )
    {
      libgz_bound->RayGeom_Set( this->libgz_handle, pos.x, pos.y, pos.z, dir.x, dir.y, dir.z );
      libgz_check();
    }

  /// Start [m] and unit direction.
  public: void Get( GzVector *pos, GzVector *dir )
    {
      double out[6];
      libgz_bound->RayGeom_Get( this->libgz_handle, out );
      libgz_check();
      *pos = GzVectorSet( out[0], out[1], out[2] );
      *dir = GzVectorSet( out[3], out[4], out[5] );
    }

  /// Without effect: a ray has no place on its body.
  public: virtual void SetRelativePose( GzPose, bool = true ) {}
""",
        """
void RayGeom_Set(RayGeom *self, GzVector pos, GzVector dir)
GzTwoVectors RayGeom_Get(RayGeom *self)
""",
    ),
    _geom(
        "LightGeom",
        "A point light where its body is.",
        "",
        """
void SetAttenuation( GzVector factors ); constant, linear [1/m] and quadratic [1/m^2] part of how it fades
""",
        """\
  public: static bool CheckAvailable() { return true; }
""",
    ),
    _geom(
        "FrustrumGeom",
        "The outline of a camera's field of view.",
        "double aspect, double nearClip, double farClip",
        """
void SetFOV( double fov ); horizontal field of view [rad]
""",
    ),
    _geom(
        "DomeGeom",
        "The sky.",
        "int resolution",
        """
void SetDayTime( double seconds ); time since midnight at the start [s]
void SetElapsedTime( double seconds ); time since the start [s]
""",
    ),
    _geom(
        "TerrainGeom",
        "Hilly ground: a triangle mesh.",
        "",
        "",
        """\
  /// Set the mesh: vertices of 12 numbers (texture, colour, normal, position), a strip to render, triangles to collide.
  public: void Load( GLfloat *vertices, uint vertexCount, GLuint *strip, uint stripCount, GLuint *triangles, uint count )
    {
      libgz_bound->TerrainGeom_Load( this->libgz_handle, vertices, vertexCount, strip, stripCount, triangles, count );
      libgz_check();
    }
""",
        """
void TerrainGeom_Load(TerrainGeom *self, const void *vertices, uint vertexCount, const void *strip, uint stripCount, const void *triangles, uint count)
""",
    ),
    _geom(
        "RoadGeom",
        "A road along a smooth track.",
        "",
        """
void SetTrackSpacing( double spacing ); distance of track points [m]
void SetProfileSpacing( double spacing ); distance of profile points [m]
int AddTrackPoint( GzVector point ); a point that the middle of the road passes through [m]; its index
void AddProfilePoint( int index, double pz ); the next height across the road at a track point [m]
void AddSign( GzVector point, const char *text ); a sign with a text
void UpdateMesh( GzVector point ); build the mesh
""",
    ),
    CxxClass(
        "PrismGeom",
        "An upright prism, such as a piece of wall: corners of its base in order, at z = 0, and its height [m].",
        base="Geom",
        includes=("Geom.hh", "Body.hh"),
        public="""\
  public: PrismGeom( Body *owner, dSpaceID space, int count, GzVector *corners, double height ) : Geom( space )
    {
      this->body = owner;
      this->libgz_handle
        = libgz_bound->PrismGeom_new( this, libgz_handle_of( owner ), space, count, corners, height );
      this->libgz_made();
    }
""",
        functions="long PrismGeom_new(void *pointer, Body *body, dSpaceID space, int count, const void *corners, double height)\n",
    ),
    CxxClass(
        "PointSetGeom",
        "Points that are only rendered.",
        base="Geom",
        includes=("Geom.hh", "Body.hh"),
        public="""\
  public: PointSetGeom( Body *owner, dSpaceID space, int count, GzVector *points ) : Geom( space )
    {
      this->body = owner;
      this->libgz_handle = libgz_bound->PointSetGeom_new( this, libgz_handle_of( owner ), space, count, points );
      this->libgz_made();
    }
""",
        functions="long PointSetGeom_new(void *pointer, Body *body, dSpaceID space, int count, const void *points)\n",
    ),
    CxxClass(
        "JointGroup",
        "Joints that are destroyed together.",
        """
dJointGroupID GetGroupId() const; ODE's own group, for joints that are made with functions of ODE
void Empty(); destroy all joints of the group
""",
        includes=("Ode.hh",),
        functions="long JointGroup_new(void *pointer)\n",
        public="""\
  public: JointGroup()
    {
      this->libgz_handle = libgz_bound->JointGroup_new( this );
      libgz_check();
    }
""",
    ),
    CxxClass(
        "Joint",
        "Base of all joints. Anchors and axes are global at the time of the call.",
        _JOINT,
        includes=("Vector.hh", "Ode.hh"),
        forward=("Body", "World"),
        functions="dJointID Joint_GetJointId(Joint *self)\n",
        public=_both_forms(_JOINT),
        protected="""\
  protected: Joint() : jointId( NULL ) {}
  protected: dJointID jointId;
""",
    ),
    _joint(
        "HingeJoint",
        "One axis of rotation.",
        """
void SetAxis( GzVector axis ); set the axis
GzVector GetAxis() const; the axis
double GetAngle() const; the angle [rad]
double GetAngleRate() const; the angular velocity [rad/s]
void SetTorque( double torque ); add a torque for one step [N m]
""",
    ),
    _joint(
        "Hinge2Joint",
        "Two hinges in series; Attach(chassis, wheel).",
        """
void SetAxis1( GzVector axis ); the axis of the first body
void SetAxis2( GzVector axis ); the axis of the second body
GzVector GetAxis1() const; the axis of the first body
GzVector GetAxis2() const; the axis of the second body
GzVector GetAnchor2() const; the anchor on the second body [m]
double GetAngle1() const; the angle about axis 1 [rad]
double GetAngle1Rate() const; the rate about axis 1 [rad/s]
double GetAngle2Rate() const; the rate about axis 2 [rad/s]
void SetTorque( double torque1, double torque2 ); add torques for one step [N m]
""",
    ),
    _joint(
        "UniversalJoint",
        "Two axes of rotation at right angles.",
        """
void SetAxis1( GzVector axis ); the axis of the first body
void SetAxis2( GzVector axis ); the axis of the second body
GzVector GetAxis1() const; the axis of the first body
GzVector GetAxis2() const; the axis of the second body
double GetAngle1() const; the angle about axis 1 [rad]
double GetAngle2() const; the angle about axis 2 [rad]
double GetAngleRate1() const; the rate about axis 1 [rad/s]
double GetAngleRate2() const; the rate about axis 2 [rad/s]
virtual void SetTorque( double torque1, double torque2 ); add torques for one step [N m]
""",
    ),
    _joint("BallJoint", "Three axes of rotation about the anchor.", ""),
    _joint(
        "SliderJoint",
        "One axis of translation.",
        """
void SetAxis( double x, double y, double z ); set the axis
GzVector GetAxis() const; the axis
double GetPosition() const; the position [m]
double GetPositionRate() const; the velocity [m/s]
void SetSliderForce( double force ); add a force for one step [N]
""",
    ),
    CxxClass(
        "Sensor",
        "Base of all sensors.",
        forward=("World",),
        public="  public: Sensor( World *owner ) : world( owner ) {}\n",
        protected="  protected: World *world;\n",
    ),
    CxxClass(
        "RayProximity",
        "Rays from a body into the world.",
        """
double GetRange( int index ); distance from the ray's start [m]; DBL_MAX if it hit nothing
double GetRetro( int index ); how much the geom that was hit reflects
int GetFiducial( int index ); the fiducial number of the geom that was hit; -1 for none
void Update(); cast all rays
""",
        base="Sensor",
        includes=("Sensor.hh", "Body.hh", "World.hh"),
        functions="""
long RayProximity_new(void *pointer, World *world, Body *body, int rayCount)
void RayProximity_SetRay(RayProximity *self, int index, GzVector a, GzVector b)
GzTwoVectors RayProximity_GetRay(RayProximity *self, int index)
""",
        public="""\
  public: RayProximity( World *owner, Body *body, int rayCount ) : Sensor( owner )
    {
      this->libgz_handle = libgz_bound->RayProximity_new( this, libgz_handle_of( owner ), libgz_handle_of( body ), rayCount );
      libgz_check();
    }

  /// Place a ray in the body frame, from a to b [m].
  public: void SetRay( int index, GzVector a, GzVector b )
    {
      libgz_bound->RayProximity_SetRay( this->libgz_handle, index, a.x, a.y, a.z, b.x, b.y, b.z );
      libgz_check();
    }

  /// Start [m] and unit direction of a ray, global.
  public: void GetRay( int index, GzVector *pos, GzVector *dir )
    {
      double out[6];
      libgz_bound->RayProximity_GetRay( this->libgz_handle, index, out );
      libgz_check();
      *pos = GzVectorSet( out[0], out[1], out[2] );
      *dir = GzVectorSet( out[3], out[4], out[5] );
    }
""",
    ),
    CxxClass(
        "Camera",
        "A camera that looks along +x of its pose, z up.",
        """
int Init( int width, int height, double hfov, double minDepth, double maxDepth, const char *method, int zBufferDepth ); 0, or -1 after an error message
int Fini(); release the camera; 0
void Update(); render an image, and save it if that is enabled
void SetPose( GzPose pose ); set the global pose [m]
GzPose GetPose(); the global pose [m]
void SetFOV( double fov ); set the horizontal field of view [rad]
double GetFOV() const; the horizontal field of view [rad]
double GetZValue( int x, int y ); the depth buffer's value at a pixel, 0 to 1; (0, 0) is the top left one
GzPose CalcCameraDelta( int mode, GzVector a, GzVector b ); the change of pose for a drag: 0 move, 1 zoom, 2 turn
void SetSavePath( const char *pathname ); set the directory of saved images
void EnableSaveFrame( bool enable ); save each image
""",
        base="Sensor",
        includes=("Sensor.hh", "Vector.hh", "RenderOptions.hh", "GLContext.hh", "Error.hh", "World.hh"),
        functions="""
long Camera_new(void *pointer, World *world)
GzTwoVectors Camera_GetImageSize(Camera *self)
const void *Camera_GetImageData(Camera *self)
void Camera_SetRenderOptions(Camera *self, int switches, int polygonMode, int shadeModel)
""",
        public="""\
  public: Camera( World *owner ) : Sensor( owner )
    {
      this->libgz_handle = libgz_bound->Camera_new( this, libgz_handle_of( owner ) );
      libgz_check();
      libgz_default_options( &this->libgz_options );
    }

  /// Accepted without effect: libgz has contexts of its own.
  public: void InitContext( GLContext & ) {}

  /// Width and height [px].
  public: void GetImageSize( int *width, int *height )
    {
      double out[6];
      libgz_bound->Camera_GetImageSize( this->libgz_handle, out );
      libgz_check();
      *width = (int) out[0];
      *height = (int) out[1];
    }

  /// The image: packed RGB, bottom row first; NULL before Init. The next Update overwrites it.
  public: const unsigned char *GetImageData() const
    {
      const void *data = libgz_bound->Camera_GetImageData( this->libgz_handle );
      libgz_check();
      return (const unsigned char *) data;
    }

  /// What is rendered: skins, axes and so on.
  public: void SetRenderOptions( const RenderOptions *opt )
    {
      int switches = opt->displayBBox | opt->displayAxes << 1 | opt->displayCoM << 2 | opt->displaySkins << 3
                     | opt->displayRays << 4 | opt->displayFrustrums << 5 | opt->displayMaterials << 6
                     | opt->displayTextures << 7;
      this->libgz_options = *opt;
      libgz_bound->Camera_SetRenderOptions( this->libgz_handle, switches, opt->polygonMode, opt->shadeModel );
      libgz_check();
    }

  /// The options in force.
  public: void GetRenderOptions( RenderOptions *opt ) const { *opt = this->libgz_options; }
""",
        protected="  private: RenderOptions libgz_options;\n",
    ),
    CxxClass(
        "StereoCamera",
        "Two cameras side by side, 0 the left one and 1 the right one, that look along +x of one pose.",
        """
int Init( int width, int height, double hfov, double baseline, double minDepth, double maxDepth, const char *method, int zBufferDepth = 24 ); 0, or -1 after an error message
int Fini(); release both cameras; 0
void Update(); render what is enabled, and save the images if that is enabled
void SetPose( GzPose pose ); set the global pose of the middle between both cameras [m]
GzPose GetPose(); the global pose [m]
double GetFOV() const; the horizontal field of view [rad]
void EnableImage( int camera, bool enable ); whether the images of a camera are wanted; initially they are
void EnableDisparity( int camera, bool enable ); whether the disparities of a camera are wanted; initially they are
const unsigned char *GetImageData( int camera ) const; packed RGB, bottom row first; NULL before Init
const float *GetDisparityData( int camera ) const; disparities [px] in the order of the image, 0 where the other camera does not see the point
void SetSavePath( const char *pathname ); set the directory of saved images, which gets the directories left and right
void EnableSaveFrame( bool enable ); save each image
""",
        base="Sensor",
        includes=("Sensor.hh", "Vector.hh", "World.hh"),
        functions="""
long StereoCamera_new(void *pointer, World *world)
GzTwoVectors StereoCamera_GetSize(StereoCamera *self)
""",
        public="""\
  public: StereoCamera( World *owner ) : Sensor( owner )
    {
      this->libgz_handle = libgz_bound->StereoCamera_new( this, libgz_handle_of( owner ) );
      libgz_check();
    }

  /// Width and height of each image [px].
  public: void GetSize( int *width, int *height )
    {
      double out[6];
      libgz_bound->StereoCamera_GetSize( this->libgz_handle, out );
      libgz_check();
      *width = (int) out[0];
      *height = (int) out[1];
    }
""",
    ),
    CxxClass(
        "Model",
        "Base of all models: what a plugin subclasses.",
        """
GzPose GetPose(); global pose of the canonical body [m]
void SetPose( GzPose pose ); move all bodies as one [m]; velocities become zero
void LogPose(); add the pose to the trail
void Attach(); weld the model to the parent body
void Detach(); take the model off its parent
int GetNumBodies(); how many bodies there are
void SetPickId( GLuint id ); a number by which a user interface finds the model
GLuint GetPickId() const; the pick number, or that of the parent
int GetIntId() const; the model's number in interfaces
int GetParentIntId() const; the parent's number, or 0
int MasterLoad( WorldFile *file, WorldFileNode *node ); read the common attributes, and load the model; 0
void MasterUpdate( double step ); log the pose if that is enabled, and update the model
""",
        includes=("Vector.hh", "Ode.hh", "RenderOptions.hh", "Body.hh"),
        forward=("World", "WorldFile", "WorldFileNode", "HingeJoint"),
        functions="""
long Model_new(void *pointer, void *fields, World *world)
void Model_SetParent(Model *self, Model *parent, Body *body)
void Model_AddBody(Model *self, Body *body, bool canonical)
Body *Model_GetBody(Model *self, const char *name)
Body *Model_GetBodyAt(Model *self, int index)
const char *Model_GetId(Model *self)
void Model_SetId(Model *self, const char *id)
const char *Model_GetName(Model *self)
int Model_Load(Model *self, WorldFile *file, WorldFileNode *node)
int Model_Init(Model *self, WorldFile *file, WorldFileNode *node)
int Model_Fini(Model *self)
void Model_Update(Model *self, double step)
void Model_SetName(Model *self, const char *name)
""",
        public="""\
  public: explicit Model( World *owner )
    : world( owner ), node( NULL ), parent( NULL ), parentBody( NULL ), joint( NULL ), fixed( false ),
      modelSpaceId( NULL ), logPoses( false ), poseCount( 0 ), poseMaxCount( 0 ), poses( NULL ), bodyCount( 0 ),
      bodyMaxCount( 0 ), bodies( NULL )
    {
      this->libgz_handle = libgz_bound->Model_new( this, &this->world, libgz_handle_of( owner ) );
      libgz_check();
    }
  public: Model( World *owner, long handle )
    : world( owner ), node( NULL ), parent( NULL ), parentBody( NULL ), joint( NULL ), fixed( false ),
      modelSpaceId( NULL ), logPoses( false ), poseCount( 0 ), poseMaxCount( 0 ), poses( NULL ), bodyCount( 0 ),
      bodyMaxCount( 0 ), bodies( NULL )
    {
      this->libgz_wrap( handle );
    }
  public: virtual ~Model() { free( this->bodies ); }

  public: virtual int Load( WorldFile *file, WorldFileNode *node ) = 0;
  public: virtual int Init( WorldFile *file, WorldFileNode *node ) = 0;
  public: virtual int Fini() = 0;
  public: virtual void Update( double step ) = 0;

  /// Never called: models are rendered without calls to plugins.
  public: virtual void Render( int, RenderOptions * ) {}

  public: void SetParent( Model *model, Body *body )
    {
      libgz_bound->Model_SetParent( this->libgz_handle, libgz_handle_of( model ), libgz_handle_of( body ) );
      libgz_check();
    }

  /// A body by name; the canonical one without a name. NULL if there is none.
  public: Body *GetBody( const char *name = NULL )
    {
      void *found = libgz_bound->Model_GetBody( this->libgz_handle, name );
      libgz_check();
      return (Body *) found;
    }

  /// All bodies in order.
  public: Body **GetBodies()
    {
      int i;
      this->bodyCount = this->GetNumBodies();
      this->bodies = (Body **) realloc( this->bodies, ( this->bodyCount + 1 ) * sizeof( Body * ) );
      for ( i = 0; i < this->bodyCount; i++ )
        this->bodies[i] = (Body *) libgz_bound->Model_GetBodyAt( this->libgz_handle, i );
      libgz_check();
      return this->bodies;
    }

  public: void SetId( const char *id )
    {
      libgz_bound->Model_SetId( this->libgz_handle, id );
      libgz_check();
    }
  public: const char *GetId() const { return libgz_text( libgz_bound->Model_GetId( this->libgz_handle ), "" ); }
  public: void SetName( const char *name )
    {
      libgz_bound->Model_SetName( this->libgz_handle, name );
      libgz_check();
    }
  public: const char *GetName() { return libgz_text( libgz_bound->Model_GetName( this->libgz_handle ), "" ); }

  // The order of these is known to libgz.
  public: World *world;
  public: WorldFileNode *node;
  public: Model *parent;
  public: Body *parentBody;
  public: GzPose initPose;
  public: HingeJoint *joint;
  public: GzPose relPose;
  public: bool fixed;
  public: dSpaceID modelSpaceId;
  public: bool logPoses;
  public: int poseCount, poseMaxCount;
  public: GzPose *poses;
""",
        protected="""\
  /// Add a body. Exactly one is canonical: its pose is the model's.
  protected: void AddBody( Body *body, bool canonical = false )
    {
      libgz_bound->Model_AddBody( this->libgz_handle, libgz_handle_of( body ), canonical );
      libgz_check();
      this->GetBodies();
      body->bodyName = (char *) libgz_bound->Body_GetName( body->libgz_handle );
    }

  protected: int bodyCount, bodyMaxCount;
  protected: Body **bodies;
""",
    ),
    CxxClass(
        "World",
        "The world.",
        """
void SetModelPose( Model *model, GzPose pose ); move a model, relative to its parent, with all that is attached [m]
void ResetModelPoses(); return all models to their initial poses
int Save(); write the present poses to the worldfile; 0 or -1
int LoadModel( WorldFileNode *node, Model *parent ); build the models of an element; 0 or -1
double GetSimTime(); simulated time [s], pauses excluded
double GetPauseTime(); simulated time spent paused [s]
double GetRealTime(); wall-clock time since the start [s]
double GetWallTime(); Unix time [s]
double GetDayTime(); time since midnight [s]
int GetNumModels() const; how many models there are
int Load( WorldFile *worldFile ); an error: the server loads worlds
int Initialize(); an error: the server starts worlds
int Finalize(); an error: the server ends worlds
void Step(); an error: the server steps worlds, and a plugin runs in a step
""",
        includes=("Geom.hh", "Model.hh", "Sensor.hh"),
        forward=("WorldFile", "WorldFileNode"),
        functions="""
Model *World_GetModel(World *self, int index)
dSpaceID World_GetSpaceId(World *self)
""",
        public="""\
  public: World( libgz_wrapping, long handle ) : libgz_models( NULL ) { this->libgz_wrap( handle ); }
  public: virtual ~World() { free( this->libgz_models ); }

  /// All models in order of the file.
  public: Model **GetModels() const
    {
      int count = this->GetNumModels(), i;
      this->libgz_models = (Model **) realloc( this->libgz_models, ( count + 1 ) * sizeof( Model * ) );
      for ( i = 0; i < count; i++ )
        this->libgz_models[i] = (Model *) libgz_bound->World_GetModel( this->libgz_handle, i );
      libgz_check();
      return this->libgz_models;
    }

  /// ODE's space of all models.
  public: dSpaceID GetSpaceId()
    {
      void *id = libgz_bound->World_GetSpaceId( this->libgz_handle );
      libgz_check();
      return (dSpaceID) id;
    }

  // The order of these is known to libgz.
  public: gz_server_t *gz_server;
  public: dWorldID worldId;
  public: double simSpeed;
  public: double utcOffset;
  public: GzVector utmZone;
  public: GzVector utmOffset;
  public: double fogDensity;
  public: GzColor skyColor;
  public: GzColor fogColor;
  public: int server_id;
  public: bool fogEnable;
""",
        protected="  private: mutable Model **libgz_models;\n",
    ),
)

# Functions of the table that belong to no class.
FUNCTIONS = """
void Object_destroyed(LibgzObject *self, const void *pointer, bool made)
void Factory_RegisterModel(const char *type, const char *classname, void *function)
Model *Factory_NewModel(World *world, const char *classname)
void Error_Print(int type, int level, const char *file, int line, const char *text)
int Image_Load(const char *filename, void *width, void *height, void *components, void *data)
"""
