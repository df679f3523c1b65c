"""Each group of the old API's methods: a C++ plugin and a Python model do the same, and see the same numbers."""

import math
import sys

import pytest
from cxx_plugins import HEADERS, compiled, needs_cxx, world_text

import libgz
from libgz import (
    BallJoint,
    Body,
    BoxGeom,
    CylinderGeom,
    DomeGeom,
    FrustrumGeom,
    GzHomo,
    GzPose,
    GzQuatern,
    GzVector,
    Hinge2Joint,
    HingeJoint,
    JointGroup,
    LightGeom,
    PlaneGeom,
    PointSetGeom,
    PrismGeom,
    RayGeom,
    RayProximity,
    RoadGeom,
    SliderJoint,
    SphereGeom,
    TerrainGeom,
    UniversalJoint,
    WheelGeom,
)
from libgz.worldfile.file import WorldFile

pytestmark = needs_cxx

MORE_HEADERS = "".join(
    f"#include <gazebo/{name}.hh>\n"
    for name in [
        "BallJoint",
        "Camera",
        "CylinderGeom",
        "DomeGeom",
        "FrustrumGeom",
        "GLContext",
        "Hinge2Joint",
        "Image",
        "JointGroup",
        "LightGeom",
        "PlaneGeom",
        "PointSetGeom",
        "PrismGeom",
        "RayGeom",
        "RayProximity",
        "RoadGeom",
        "SliderJoint",
        "TerrainGeom",
        "UniversalJoint",
        "WheelGeom",
    ]
)
PROBE = (
    HEADERS
    + MORE_HEADERS
    + """
static FILE *out;
static void P( double number ) { fprintf( out, "%a\\n", number ); }
static void P( int number ) { P( (double) number ); }
static void P( bool number ) { P( (double) number ); }
static void P( unsigned number ) { P( (double) number ); }
static void P( float number ) { P( (double) number ); }
static void P( const char *text ) { fprintf( out, "%s\\n", text ? text : "None" ); }
static void P( GzVector v ) { P( v.x ); P( v.y ); P( v.z ); }
static void P( GzQuatern q ) { P( q.u ); P( q.x ); P( q.y ); P( q.z ); }
static void P( GzPose p ) { P( p.pos ); P( p.rot ); }
static void P( GzColor c ) { P( c.r ); P( c.g ); P( c.b ); P( c.a ); }
static void P( GzHomo h ) { for ( int i = 0; i < 9; i++ ) P( h.m[i / 3][i % 3] ); }
#define V GzVectorSet
#define Q GzQuaternFromEuler

class Probe : public Model
{
  public: Probe( World *world ) : Model( world ) {}
  public: Body *Make( const char *name, double x, double y, double z )
    {
      Body *body = new Body( this->world, name );
      Geom *geom = new BoxGeom( body, this->modelSpaceId, 0.2, 0.3, 0.4 );
      geom->SetRelativePosition( V( 0.05, 0, 0 ) );
      geom->SetMass( 2.0 );
      this->AddBody( body, name == NULL );
      body->SetPosition( V( x, y, z ) );
      return body;
    }
  GROUPS
  public: int Load( WorldFile *file, WorldFileNode *node )
    {
      const char *group = node->GetString( "group", "none" );
      out = fopen( node->GetString( "out", "none" ), "w" );
      Body *a = this->Make( NULL, 0, 0, 1 ), *b = this->Make( "b", 0.5, 0.1, 1.2 );
      CALLS
      fclose( out );
      out = NULL;
      return 0;
    }
  public: int Init( WorldFile *file, WorldFileNode *node ) { return 0; }
  public: int Fini() { return 0; }
  public: void Update( double step ) {}
};
GZ_REGISTER_PLUGIN( "Probe", Probe )
"""
)


class PyProbe(libgz.Model):
    """The same model in Python; `group` does what the C++ group does, and `out` gets the numbers."""

    group = None
    out = None

    def make(self, name, x, y, z):
        body = Body(self.world, name)
        geom = BoxGeom(body, self.modelSpaceId, 0.2, 0.3, 0.4)
        geom.SetRelativePosition((0.05, 0, 0))
        geom.SetMass(2.0)
        self.AddBody(body, name is None)
        body.SetPosition((x, y, z))
        return body

    def Load(self, file, node):
        a, b = self.make(None, 0, 0, 1), self.make("b", 0.5, 0.1, 1.2)
        type(self).group(self, a, b, file, node)

    def P(self, value):
        """Keep a value as its numbers."""
        if isinstance(value, GzPose):
            self.P(value.pos)
            self.P(value.rot)
        elif isinstance(value, GzHomo):
            for row in value.m:
                self.P(tuple(row))
        elif isinstance(value, str) or value is None:
            self.out.append(str(value))
        elif isinstance(value, bool | int | float):
            self.out.append(float(value))
        else:
            for number in value:
                self.P(float(number))


GROUPS = {}


def group(code):
    """Register a group: its C++ code, and the Python function that does the same."""

    def register(function):
        GROUPS[function.__name__] = code, function
        return function

    return register


def V(x, y, z):
    return GzVector(x, y, z)


def Q(r, p, y):
    return libgz.GzQuaternFromEuler(r, p, y)


@group("""
  GzVector v = V( 0.1, -2.3, 4.7 ), w = V( 1.9, 0.3, -0.7 );
  GzQuatern q = Q( 0.3, -0.4, 2.1 ), r = Q( -1.3, 0.2, 0.5 ), s = Q( 0.2, 1.5699, 0.3 );
  P( GzVectorZero() ); P( GzVectorAdd( v, w ) ); P( GzVectorSub( v, w ) ); P( GzVectorMul( 1.7, v ) );
  P( GzVectorMag( v ) ); P( GzVectorUnit( v ) ); P( GzVectorCross( v, w ) ); P( GzVectorDot( v, w ) );
  P( GzVectorFinite( v ) ); P( GzVectorFinite( V( 0, HUGE_VAL, 0 ) ) ); P( GzVectorFinite( GzVectorUnit( V( 0, 0, 0 ) ) ) );
  P( GzVectorSetQuatern( q ) ); P( GzQuaternIdent() ); P( GzQuaternSet( 1, 2, 3, 4 ) ); P( GzQuaternSetVector( v ) );
  P( GzQuaternInverse( q ) ); P( GzQuaternNormal( GzQuaternSet( 1, 2, 3, 4 ) ) ); P( GzQuaternFromAxis( 1, 2, 3, 0.7 ) );
  P( GzQuaternFromAxis( 0, 0, 0, 0.7 ) ); P( GzQuaternToAxis( q ) ); P( q ); P( GzQuaternToEuler( q ) );
  P( GzQuaternToEuler( s ) ); P( GzQuaternMul( q, r ) ); P( GzQuaternScale( 0.3, q ) ); P( GzQuaternFinite( q ) );
  P( GzHomoFromQuatern( q ) ); P( GzQuaternFromHomo( GzHomoFromQuatern( r ) ) ); P( GzHomoInverse( GzHomoFromQuatern( q ) ) );
  P( GzQuaternFromHomo( GzHomoFromQuatern( Q( M_PI, 0.1, 0 ) ) ) ); P( GzQuaternFromHomo( GzHomoFromQuatern( Q( 0, M_PI, 0 ) ) ) );
  P( GzHomoMul( GzHomoFromQuatern( q ), v ) ); P( GzPosePointAt( v, w, V( 0, 0, 1 ) ) );
  GzPose a1 = GzPoseSet( v, q ), b1 = GzPoseSet( w, r );
  P( GzPoseFinite( a1 ) ); P( GzCoordPoseAdd( a1, b1 ) ); P( GzCoordPoseSub( a1, b1 ) ); P( GzCoordPoseSolve( a1, b1 ) );
  P( GzCoordPositionAdd( v, w, q ) ); P( GzCoordPositionSub( v, w, q ) ); P( GzCoordRotationAdd( q, r ) );
  P( GzCoordRotationSub( q, r ) ); P( RTOD( 1.1 ) ); P( DTOR( 33.0 ) ); P( NORMALIZE( 7.0 ) ); P( Round( 2.6 ) );
  P( Max( 1, 2 ) ); P( Min( 1, 2 ) ); P( IsEven( 4 ) ); P( IsOdd( 4 ) );
  P( dParamLoStop ); P( dParamHiStop ); P( dParamVel ); P( dParamFMax ); P( dParamFudgeFactor ); P( dParamBounce );
  P( dParamCFM ); P( dParamStopERP ); P( dParamStopCFM ); P( dParamSuspensionERP ); P( dParamSuspensionCFM );
  P( dParamVel2 ); P( dParamFMax2 ); P( dParamSuspensionCFM2 ); P( GZ_FIXED_COLLIDE ); P( GZ_RENDER_TRANSPARENT );
""")
def geometry(self, a, b, file, node):
    P, g = self.P, libgz
    v, w = V(0.1, -2.3, 4.7), V(1.9, 0.3, -0.7)
    q, r, s = Q(0.3, -0.4, 2.1), Q(-1.3, 0.2, 0.5), Q(0.2, 1.5699, 0.3)
    values = [g.GzVectorZero(), g.GzVectorAdd(v, w), g.GzVectorSub(v, w), g.GzVectorMul(1.7, v)]
    values += [g.GzVectorMag(v), g.GzVectorUnit(v), g.GzVectorCross(v, w), g.GzVectorDot(v, w)]
    values += [g.GzVectorFinite(v), g.GzVectorFinite((0, math.inf, 0)), g.GzVectorFinite(g.GzVectorUnit((0, 0, 0)))]
    values += [g.GzVectorSetQuatern(q), g.GzQuaternIdent(), g.GzQuaternSet(1, 2, 3, 4), g.GzQuaternSetVector(v)]
    values += [g.GzQuaternInverse(q), g.GzQuaternNormal((1, 2, 3, 4)), g.GzQuaternFromAxis(1, 2, 3, 0.7)]
    values += [g.GzQuaternFromAxis(0, 0, 0, 0.7), g.GzQuaternToAxis(q), q, g.GzQuaternToEuler(q)]
    values += [g.GzQuaternToEuler(s), g.GzQuaternMul(q, r), g.GzQuaternScale(0.3, q), g.GzQuaternFinite(q)]
    homo = g.GzHomoFromQuatern(q)
    values += [homo, g.GzQuaternFromHomo(g.GzHomoFromQuatern(r)), g.GzHomoInverse(homo)]
    values += [g.GzQuaternFromHomo(g.GzHomoFromQuatern(Q(*e))) for e in ((math.pi, 0.1, 0), (0, math.pi, 0))]
    values += [g.GzHomoMul(homo, v), g.GzPosePointAt(v, w, (0, 0, 1))]
    a1, b1 = g.GzPoseSet(v, q), g.GzPoseSet(w, r)
    values += [g.GzPoseFinite(a1), g.GzCoordPoseAdd(a1, b1), g.GzCoordPoseSub(a1, b1), g.GzCoordPoseSolve(a1, b1)]
    values += [g.GzCoordPositionAdd(v, w, q), g.GzCoordPositionSub(v, w, q), g.GzCoordRotationAdd(q, r)]
    values += [g.GzCoordRotationSub(q, r), g.RTOD(1.1), g.DTOR(33.0), g.NORMALIZE(7.0), 3, 2, 1, 1, 0]
    names = "LoStop HiStop Vel FMax FudgeFactor Bounce CFM StopERP StopCFM SuspensionERP SuspensionCFM Vel2 FMax2"
    values += [getattr(g, f"dParam{name}") for name in (*names.split(), "SuspensionCFM2")]
    for value in (*values, 1, 2):
        P(value)


@group("""
  P( b->GetPose() ); P( b->GetCoMPose() ); P( b->GetNumGeoms() ); P( b->bodyName ); P( a->bodyName );
  b->SetRotation( Q( 0.1, 0.2, 0.3 ) ); P( b->GetPosition() ); P( b->GetRotation() );
  b->SetPose( GzPoseSet( V( 1, 2, 3 ), Q( 1, 0.5, 0.2 ) ) ); P( b->GetPose() ); P( b->GetCoMPose() );
  b->SetLinearVel( V( 1, 0, -1 ) ); b->SetAngularVel( V( 0.3, 0.1, 2 ) ); P( b->GetLinearVel() ); P( b->GetAngularVel() );
  b->SetGravityMode( false ); P( b->GetGravityMode() ); b->SetFiniteRotationMode( 1 ); b->SetFiniteRotationAxis( 0, 0, 1 );
  b->SetForce( V( 1, 2, 3 ) ); b->AddForce( 0.1, 0, 0 ); b->AddRelForce( 0, 1, 0 ); P( b->GetForce() );
  b->SetTorque( 1, 0, 0 ); b->AddTorque( 0, 1, 0 ); b->AddRelTorque( 0, 0, 1 ); P( b->GetTorque() );
  b->AddForceAtPos( 1, 0, 0, 0, 2, 0 ); b->AddForceAtRelPos( 0, 0, 1, 0.1, 0, 0 ); P( b->GetForce() ); P( b->GetTorque() );
  b->Enable( false ); b->Enable( true ); b->UpdateCoM(); b->SetPickId( 7 );
  P( b->GetGeoms()[0]->GetPickId() ); P( b->GetGeoms()[0]->body == b ); P( b->GetBodyId() != NULL );
  P( b->GetSpaceId() == this->modelSpaceId );
  Body *d = new Body( this->world, "d", true ); d->SetPosition( V( 3, 2, 1 ) ); P( d->GetPose() ); P( d->GetLinearVel() );
  P( d->GetBodyId() == NULL ); this->AddBody( d );
  dBodySetPosition( b->GetBodyId(), 4, 4, 4 ); P( b->GetCoMPose().pos );
""")
def body(self, a, b, file, node):
    P = self.P
    for value in (b.GetPose(), b.GetCoMPose(), b.GetNumGeoms(), "b", "canonical"):
        P(value)
    b.SetRotation(Q(0.1, 0.2, 0.3))
    P(b.GetPosition())
    P(b.GetRotation())
    b.SetPose(GzPose(V(1, 2, 3), Q(1, 0.5, 0.2)))
    P(b.GetPose())
    P(b.GetCoMPose())
    b.SetLinearVel((1, 0, -1))
    b.SetAngularVel((0.3, 0.1, 2))
    P(b.GetLinearVel())
    P(b.GetAngularVel())
    b.SetGravityMode(False)
    P(b.GetGravityMode())
    b.SetForce((1, 2, 3))
    b.AddForce(0.1, 0, 0)
    b.AddRelForce(0, 1, 0)
    P(b.GetForce())
    b.SetTorque(1, 0, 0)
    b.AddTorque(0, 1, 0)
    b.AddRelTorque(0, 0, 1)
    P(b.GetTorque())
    b.AddForceAtPos(1, 0, 0, 0, 2, 0)
    b.AddForceAtRelPos(0, 0, 1, 0.1, 0, 0)
    P(b.GetForce())
    P(b.GetTorque())
    for value in (7, 1, 1, 1, V(3, 2, 1), GzQuatern(), V(0, 0, 0), 1, V(4, 4, 4)):
        P(value)


@group("""
  Geom *g = new SphereGeom( b, this->modelSpaceId, 0.1 );
  g->SetRelativePose( GzPoseSet( V( 0.1, 0, 0.2 ), Q( 0, 0.5, 0 ) ) ); P( g->GetRelativePose() ); P( g->GetPose() );
  g->SetRelativePosition( V( 0, 0, 0.3 ) ); g->SetRelativeRotation( Q( 0.1, 0, 0 ) ); P( g->GetRelativePose() );
  g->SetMass( 3.0 ); P( b->GetCoMPose() ); P( g->GetBodyMassMatrix()->mass ); P( g->GetBodyMassMatrix()->I[0] );
  P( g->GetBodyMassMatrix()->c[2] );
  g->SetHardness( 2e4, 10 ); g->SetFriction( 0.5, 0.4 ); g->SetBounce( 0.3 ); g->SetSlip1( 0.02 ); g->SetSlip2( 0.03 );
  P( g->GetBounce() ); P( g->GetSlip1() ); P( g->GetSlip2() ); g->SetCategoryBits( 4 ); g->SetCollideBits( 3 );
  P( g->GetGeomId() != NULL ); P( g->GetTransId() == g->GetGeomId() ); P( g->placeableGeom ); P( g->renderOrder );
  g->SetColor( GzColor( 0.5, 0.25, 1, 0.5 ) ); P( g->GetAmbientColor().r < 0.11 ); P( g->GetDiffuseColor() );
  g->SetAmbientColor( GzColor( 1, 0.5, 0.25 ) ); g->SetDiffuseColor( GzColor( 0.125, 0.5, 0.25 ) );
  g->SetSpecularColor( GzColor( 0.75, 0.5, 0.25 ) ); g->SetEmissionColor( GzColor( 0, 0.5, 0 ) );
  P( g->GetAmbientColor() ); P( g->GetDiffuseColor() ); P( g->GetSpecularColor() );
  g->SetTransparency( true ); P( g->GetTransparency() ); g->SetShininess( 32 ); P( g->GetShininess() );
  g->SetLaser( 0.5 ); P( g->GetLaser() ); g->SetRetro( 0.75 ); P( g->GetRetro() ); g->SetFiducial( 12 ); P( g->GetFiducial() );
  g->SetPickId( 9 ); P( g->GetPickId() ); P( g->HasSkin() ); g->SetSkinNull( true ); P( g->HasSkinNull() );
  P( g->SetTexture2DFile( "/no/such.png" ) ); P( g->SetSkinFile( "/no/such.3ds" ) ); P( g->SetTexture2DFile( NULL ) );
  g->SetTexture2DSize( V( 1, 1, 0 ) ); g->SetSkinPose( GzPoseSet( V( 1, 0, 0 ), Q( 0, 0, 0 ) ) ); g->SetSkinScale( V( 2, 2, 2 ) );
  g->SetShadeModel( "flat" ); g->SetPolygonMode( "line" );
  uint8_t pixels[12] = { 255, 0, 0, 0, 255, 0, 0, 0, 255, 9, 9, 9 }; P( g->SetTexture2D( 2, 2, pixels ) );
""")
def geom(self, a, b, file, node):
    P = self.P
    g = SphereGeom(b, self.modelSpaceId, 0.1)
    g.SetRelativePose(GzPose(V(0.1, 0, 0.2), Q(0, 0.5, 0)))
    P(g.GetRelativePose())
    P(g.GetPose())
    g.SetRelativePosition((0, 0, 0.3))
    g.SetRelativeRotation(Q(0.1, 0, 0))
    P(g.GetRelativePose())
    g.SetMass(3.0)
    P(b.GetCoMPose())
    mass = g.GetBodyMassMatrix()
    for value in (mass.mass, mass.I[0], mass.c[2], 0.3, 0.02, 0.03, 1, 1, 1, 1):
        P(value)
    P(1)
    P((0.5, 0.25, 1, 0.5))
    for color in ((1, 0.5, 0.25, 1), (0.125, 0.5, 0.25, 1), (0.75, 0.5, 0.25, 1)):
        P(color)
    for value in (1, 32, 0.5, 0.75, 12, 9, 0, 1, -1, -1, 0, 0):
        P(value)


@group("""
  Geom *all[] = { new CylinderGeom( b, this->modelSpaceId, 0.1, 0.5 ), new WheelGeom( b, this->modelSpaceId, 0.2, 0.05 ),
    new PlaneGeom( b, this->modelSpaceId, -1, V( 0, 0, 2 ) ), new LightGeom( b, this->modelSpaceId ),
    new FrustrumGeom( b, this->modelSpaceId, 1.5, 0.5, 10 ), new DomeGeom( b, this->modelSpaceId, 20 ) };
  for ( int i = 0; i < 6; i++ ) { P( all[i]->placeableGeom ); P( all[i]->GetGeomId() != NULL ); P( all[i]->renderOrder ); }
  all[0]->SetMass( 1 ); P( all[0]->GetBodyMassMatrix()->I[0] ); P( all[2]->GetBodyMassMatrix() == NULL );
  ( (LightGeom *) all[3] )->SetAttenuation( V( 1, 0.5, 0 ) ); P( LightGeom::CheckAvailable() );
  ( (FrustrumGeom *) all[4] )->SetFOV( 1.0 ); ( (DomeGeom *) all[5] )->SetDayTime( 3600 ); ( (DomeGeom *) all[5] )->SetElapsedTime( 5 );
  RayGeom *ray = new RayGeom( b, this->modelSpaceId ); GzVector pos, dir; ray->Set( V( 1, 2, 3 ), V( 0, 0, 2 ) );
  ray->Get( &pos, &dir ); P( pos ); P( dir ); ray->SetLength( 4 ); P( ray->GetLength() );
  GzVector points[2] = { V( 0, 0, 0 ), V( 1, 1, 1 ) }; P( ( new PointSetGeom( b, this->modelSpaceId, 2, points ) )->GetGeomId() == NULL );
  RoadGeom *road = new RoadGeom( a, this->modelSpaceId ); road->SetTrackSpacing( 5 ); road->SetProfileSpacing( 2 );
  for ( int i = 0; i < 5; i++ ) { P( road->AddTrackPoint( V( 5.0 * i, 0, 0.1 ) ) ); road->AddProfilePoint( i, 0.1 ); }
  road->AddSign( V( 1, 1, 0 ), "stop" ); road->UpdateMesh( V( 0, 0, 0 ) ); P( road->GetGeomId() != NULL );
  float vertices[36]; memset( vertices, 0, sizeof vertices );
  vertices[21] = 1; vertices[34] = 1; unsigned int corners[3] = { 0, 1, 2 };
  TerrainGeom *terrain = new TerrainGeom( a, this->modelSpaceId ); terrain->Load( vertices, 3, corners, 3, corners, 3 );
  P( terrain->GetGeomId() != NULL );
  dMass mass; dMassSetSphere( &mass, 1.0, 0.1 );
  struct Own : public Geom { Own( Body *o, dSpaceID s, dMass *m ) : Geom( s ) { SetGeom( o, dCreateSphere( s, 0.1 ), m, true ); } };
  Own *own = new Own( b, this->modelSpaceId, &mass ); own->SetRelativePosition( V( 0, 0, 1 ) ); own->SetMass( 2 );
  P( own->GetBodyMassMatrix()->mass ); P( b->GetCoMPose() );
  GzHomo turn = GzHomoFromQuatern( Q( 0, 0, 0.3 ) ); P( turn.m[1][0] );
  GzVector outline[4] = { V( 0, 0, 9 ), V( 2, 0, 0 ), V( 1, 0.5, 0 ), V( 0, 2, 0 ) };
  PrismGeom *prism = new PrismGeom( b, this->modelSpaceId, 4, outline, 0.5 ); prism->SetRelativeRotation( Q( 0.1, 0.2, 0.3 ) );
  prism->SetMass( 3 ); for ( int i = 0; i < 12; i++ ) P( prism->GetBodyMassMatrix()->I[i] ); P( b->GetCoMPose() );
""")
def kinds(self, a, b, file, node):
    P, space = self.P, self.modelSpaceId
    made = [CylinderGeom(b, space, 0.1, 0.5), WheelGeom(b, space, 0.2, 0.05), PlaneGeom(b, space, -1, (0, 0, 2))]
    made += [LightGeom(b, space), FrustrumGeom(b, space, 1.5, 0.5, 10), DomeGeom(b, space)]
    for g in made:
        P(g.placeableGeom)
        P(g.GetGeomId() != 0)
        P(g.appearance.render_order)
    made[0].SetMass(1)
    P(made[0].GetBodyMassMatrix().I[0])
    P(1)
    P(1)
    ray = RayGeom(b, space)
    ray.Set((1, 2, 3), (0, 0, 2))
    for value in (*ray.Get(), 4, 1, 0, 1, 2, 3, 4, 1, 1):
        P(value)
    PointSetGeom(b, space, 2, [(0, 0, 0), (1, 1, 1)])
    RoadGeom(a, space)
    TerrainGeom(a, space)
    own = SphereGeom(b, space, 0.1)
    own.SetRelativePosition((0, 0, 1))
    own.SetMass(2)
    P(own.GetBodyMassMatrix().mass)
    P(b.GetCoMPose())
    P(libgz.GzHomoFromQuatern(Q(0, 0, 0.3)).m[1][0])
    prism = PrismGeom(b, space, [(0, 0), (2, 0), (1, 0.5), (0, 2)], 0.5)
    prism.SetRelativeRotation(Q(0.1, 0.2, 0.3))
    prism.SetMass(3)
    P(tuple(prism.GetBodyMassMatrix().I))
    P(b.GetCoMPose())


@group("""
  HingeJoint *h = new HingeJoint( this->world ); h->Attach( b, a ); h->SetAnchor( V( 0.5, 0, 1 ) ); h->SetAxis( V( 0, 1, 0 ) );
  P( h->GetAnchor() ); P( h->GetAxis() ); h->SetParam( dParamVel, 2.5 ); h->SetParam( dParamLoStop, -0.5 ); P( h->GetParam( dParamVel ) );
  P( h->GetParam( dParamLoStop ) ); P( h->GetAngle() ); b->SetRotation( Q( 0, 0.3, 0 ) ); P( h->GetAngle() );
  b->SetAngularVel( V( 0, 2, 0 ) ); P( h->GetAngleRate() ); h->SetTorque( 1.5 ); P( b->GetTorque() );
  P( h->GetType() ); P( h->GetJointBody( 0 ) == b ); P( h->GetJointBody( 1 ) == a ); P( h->AreConnected( a, b ) );
  h->Detach(); P( h->AreConnected( a, b ) ); P( h->GetJointBody( 0 ) == NULL ); delete h;
  Hinge2Joint *h2 = new Hinge2Joint( this->world ); h2->Attach( a, b ); h2->SetAnchor( V( 0.5, 0, 1 ) );
  h2->SetAxis1( V( 0, 0, -1 ) ); h2->SetAxis2( V( 0, -1, 0 ) ); P( h2->GetAxis1() ); P( h2->GetAxis2() ); P( h2->GetAnchor() );
  P( h2->GetAnchor2() ); h2->SetParam( dParamFMax2, 3 ); P( h2->GetParam( dParamFMax2 ) ); P( h2->GetAngle1() );
  P( h2->GetAngle1Rate() ); P( h2->GetAngle2Rate() ); h2->SetTorque( 1, 2 ); P( b->GetTorque() ); delete h2;
  UniversalJoint *u = new UniversalJoint( this->world ); u->Attach( b, a ); u->SetAnchor( V( 0.5, 0, 1 ) );
  u->SetAxis1( V( 1, 0, 0 ) ); u->SetAxis2( V( 0, 1, 0 ) ); P( u->GetAnchor() ); P( u->GetAxis1() ); P( u->GetAxis2() );
  P( u->GetAngle1() ); P( u->GetAngle2() ); P( u->GetAngleRate1() ); P( u->GetAngleRate2() ); u->SetTorque( 1, 2 );
  u->SetParam( dParamVel, 1 ); P( b->GetTorque() ); delete u;
  BallJoint *ball = new BallJoint( this->world ); ball->Attach( b, a ); ball->SetAnchor( V( 0.2, 0.1, 1 ) ); P( ball->GetAnchor() );
  JointGroup group; SliderJoint *s = new SliderJoint( this->world->worldId, &group ); s->Attach( b, a ); s->SetAxis( 1, 0, 0 );
  dVector3 axis; s->GetAxis( axis ); P( axis[0] ); P( s->GetPosition() ); b->SetPosition( V( 0.7, 0.1, 1.2 ) ); P( s->GetPosition() );
  b->SetLinearVel( V( 0.5, 0, 0 ) ); P( s->GetPositionRate() ); s->SetSliderForce( 3 ); P( b->GetForce() );
  s->SetAnchor( V( 0, 0, 0 ) ); P( s->GetAnchor() ); s->SetParam( dParamHiStop, 2 ); P( s->GetParam( dParamHiStop ) );
  group.Empty(); P( group.GetGroupId() != NULL );
""")
def joints(self, a, b, file, node):
    P = self.P
    h = HingeJoint(self.world)
    h.Attach(b, a)
    h.SetAnchor((0.5, 0, 1))
    h.SetAxis((0, 1, 0))
    P(h.GetAnchor())
    P(h.GetAxis())
    h.SetParam(libgz.dParamLoStop, -0.5)
    for value in (2.5, -0.5, h.GetAngle()):
        P(value)
    b.SetRotation(Q(0, 0.3, 0))
    P(h.GetAngle())
    b.SetAngularVel((0, 2, 0))
    P(h.GetAngleRate())
    h.SetTorque(1.5)
    P(b.GetTorque())
    for value in (h.GetType(), 1, 1, 1, 0, 1):
        P(value)
    h.close()
    h2 = Hinge2Joint(self.world)
    h2.Attach(a, b)
    h2.SetAnchor((0.5, 0, 1))
    h2.SetAxis1((0, 0, -1))
    h2.SetAxis2((0, -1, 0))
    for value in (h2.GetAxis1(), h2.GetAxis2(), h2.GetAnchor(), h2.GetAnchor2(), 3):
        P(value)
    for value in (h2.GetAngle1(), h2.GetAngle1Rate(), h2.GetAngle2Rate()):
        P(value)
    h2.SetTorque(1, 2)
    P(b.GetTorque())
    h2.close()
    u = UniversalJoint(self.world)
    u.Attach(b, a)
    u.SetAnchor((0.5, 0, 1))
    u.SetAxis1((1, 0, 0))
    u.SetAxis2((0, 1, 0))
    for value in (u.GetAnchor(), u.GetAxis1(), u.GetAxis2(), u.GetAngle1(), u.GetAngle2()):
        P(value)
    P(u.GetAngleRate1())
    P(u.GetAngleRate2())
    u.SetTorque(1, 2)
    P(b.GetTorque())
    u.close()
    ball = BallJoint(self.world)
    ball.Attach(b, a)
    ball.SetAnchor((0.2, 0.1, 1))
    P(ball.GetAnchor())
    s = SliderJoint(self.world, JointGroup())
    s.Attach(b, a)
    s.SetAxis(1, 0, 0)
    P(s.GetAxis().x)
    P(s.GetPosition())
    b.SetPosition((0.7, 0.1, 1.2))
    P(s.GetPosition())
    b.SetLinearVel((0.5, 0, 0))
    P(s.GetPositionRate())
    s.SetSliderForce(3)
    P(b.GetForce())
    for value in (s.GetAnchor(), 2, 1):
        P(value)


@group("""
  P( node->GetName() ); P( node->GetNSPrefix() ); P( node->GetChild()->GetName() ); P( node->GetChild( "gone" ) == NULL );
  P( node->GetChild( "number" )->GetNext()->GetName() ); P( node->GetChildByNSPrefix( "x" ) == NULL );
  P( node->IsDefined( "number" ) ); P( node->IsDefined( "gone" ) ); P( node->GetString( "text", "d" ) );
  P( node->GetString( "gone", "default" ) ); P( node->GetString( "gone", NULL ) ); P( node->GetInt( "number", 3 ) );
  P( node->GetInt( "gone", 3 ) ); P( node->GetDouble( "number", 0 ) ); P( node->GetDouble( "gone", 2.5 ) );
  P( node->GetBool( "flag", false ) ); P( node->GetLength( "number", 0 ) ); P( node->GetAngle( "angle", 0 ) );
  P( node->GetAngle( "gone", 0.7 ) ); P( node->GetTime( "number", 0 ) ); P( node->GetPosition( "tuple", V( 9, 9, 9 ) ) );
  P( node->GetPosition( "gone", V( 9, 8, 7 ) ) ); P( node->GetRotation( "tuple", Q( 0, 0, 0 ) ) );
  P( node->GetRotation( "gone", Q( 0, 0, 0.5 ) ) ); P( node->GetColor( "color", GzColor( 1, 1, 1 ) ) );
  P( node->GetColor( "gone", GzColor( 0.5, 0.25, 0, 0.125 ) ) ); P( node->GetTupleString( "tuple", 1, "d" ) );
  P( node->GetTupleString( "tuple", 7, "d" ) ); P( node->GetTupleString( "gone", 0, "d" ) ); P( node->GetTupleDouble( "tuple", 2, 0 ) );
  P( node->GetTupleDouble( "tuple", 7, 4.5 ) ); P( node->GetTupleInt( "tuple", 0, 0 ) ); P( node->GetTupleLength( "tuple", 0, 0 ) );
  P( node->GetTupleAngle( "tuple", 0, 0 ) ); P( node->GetTupleAngle( "tuple", 5, 0.1 ) );
  P( node->GetFilename( "gone", "d" ) ); P( node->SearchFilename( "gone", NULL, "d" ) );
  P( strcmp( node->SearchFilename( "self", NULL, "d" ), file->filename ) == 0 ); P( node->GetFilename( "self", "d" )[0] == '/' );
  node->SetString( "text", "other" ); P( node->GetString( "text", "d" ) ); node->SetPosition( "tuple", V( 1, 2, 3 ) );
  P( node->GetPosition( "tuple", V( 0, 0, 0 ) ) ); node->SetRotation( "tuple", Q( 0, 0, M_PI / 2 ) ); P( node->GetTupleInt( "tuple", 2, 0 ) );
  P( file->GetRootNode()->GetName() ); WorldFile own; P( own.LoadString( "<a><b>3</b></a>" ) );
  P( own.GetRootNode()->GetInt( "b", 0 ) ); P( own.filename ); WorldFile bad; P( bad.Load( "/no/such.world" ) );
  P( own.GetRootNode()->WarnUnused() ); P( own.WarnUnused() );
""")
def worldfile(self, a, b, file, node):
    P = self.P
    for value in ("Probe", "model", node.GetChild().GetName(), 1, "text", 1, 1, 0, " some text "):
        P(value)
    for value in ("default", "None", 2, 3, node.GetDouble("number"), 2.5, 1, 2.75, node.GetAngle("angle"), 0.7, 2.75):
        P(value)
    for value in (node.GetPosition("tuple"), V(9, 8, 7), node.GetRotation("tuple"), Q(0, 0, 0.5)):
        P(value)
    for value in (
        (0.5, 0.25, 1, 1),
        (0.5, 0.25, 0, 0.125),
        "20",
        "None",
        "d",
        30.5,
        4.5,
        10,
        10,
        math.radians(10),
        0.1,
    ):
        P(value)
    for value in ("d", "d", 1, 1, "other", V(1, 2, 3), 90, "world", 0, 3, "None", -1, 0, 0):
        P(value)


@group("""
  P( this->GetNumBodies() ); P( this->GetBodies()[1] == b ); P( this->GetBody() == a ); P( this->GetBody( "b" ) == b );
  P( this->GetBody( "gone" ) == NULL ); P( this->bodyCount ); P( this->bodies[0] == a ); P( this->GetId() ); P( this->GetName() );
  P( this->GetIntId() ); P( this->GetParentIntId() ); P( this->parent == NULL ); P( this->joint == NULL ); P( this->node == node );
  this->SetPickId( 5 ); P( this->GetPickId() ); P( this->GetPose() ); this->SetPose( GzPoseSet( V( 1, 2, 3 ), Q( 0, 0, 1 ) ) );
  P( this->GetPose() ); P( b->GetPose() ); this->LogPose(); P( this->poseCount ); P( this->poses[0].pos );
  P( this->world->GetSimTime() ); P( this->world->GetPauseTime() ); P( this->world->GetRealTime() < 60 );
  P( this->world->GetWallTime() > 1e9 ); P( this->world->GetDayTime() >= 0 ); P( this->world->GetNumModels() );
  P( this->world->GetModels() != NULL ); P( this->world->GetSpaceId() != NULL ); P( this->world->worldId != NULL );
  P( this->world->simSpeed ); P( this->world->utcOffset ); P( this->world->fogEnable ); P( this->world->fogDensity );
  P( this->world->utmOffset ); P( this->world->server_id ); P( this->modelSpaceId != NULL ); P( this->fixed );
  this->world->simSpeed = 2.5; this->world->fogDensity = 0.5; this->world->skyColor = GzColor( 0.5, 0.25, 1 );
  this->SetId( "renamed" ); P( this->GetId() ); this->SetName( "Other" ); P( this->GetName() );
  PRINT_MSG3( 0, "%s %d %g", "three", 2, 1.5 ); PRINT_WARN1( "warned %d", 1 ); GLContext context;
  P( context.Init( 10, 10, 8, 0, 8, "AUTO" ) ); P( context.MakeCurrent() ); GzImage image; P( image.Load( "/no/such.png" ) );
  uint8_t rgb[3] = { 1, 2, 3 }; P( image.Set( 1, 1, rgb ) ); P( image.size ); P( image.components ); P( image.data[2] ); P( image.format == GL_RGB );
  P( ModelFactory::NewModel( this->world, "NoSuchModel" ) == NULL );
""")
def model(self, a, b, file, node):
    P = self.P
    for value in (2, 1, 1, 1, 1, 2, 1, "m0", "Probe", self.GetIntId(), 0, 1, 1, 1, 5, self.GetPose()):
        P(value)
    self.SetPose(GzPose(V(1, 2, 3), Q(0, 0, 1)))
    for value in (self.GetPose(), b.GetPose(), 1, a.GetCoMPose().pos, 0, 0, 1, 1, 1, 0, 1, 1, 1, 1, 0, 0, 0.25):
        P(value)
    for value in (V(0, 0, 0), 0, 1, 0, "renamed", "Other", 0, 0, -1, 0, 3, 3, 3, 1, 1):
        P(value)


@group("""
  RayProximity *rays = new RayProximity( this->world, a, 3 );
  for ( int i = 0; i < 3; i++ ) rays->SetRay( i, V( 0.3, 0.05 * i, 0 ), V( 3, 0.05 * i, 0 ) );
  Geom *target = new BoxGeom( b, NULL, 0.1, 0.1, 0.1 ); P( target->GetGeomId() != NULL );
  b->GetGeoms()[0]->SetRetro( 0.75 ); b->GetGeoms()[0]->SetFiducial( 4 ); b->SetPosition( V( 1.5, 0, 1 ) );
  P( rays->GetRange( 0 ) == DBL_MAX ); rays->Update();
  GzVector pos, dir; rays->GetRay( 1, &pos, &dir ); P( pos ); P( dir );
  for ( int i = 0; i < 3; i++ ) { P( rays->GetRange( i ) ); P( rays->GetRetro( i ) ); P( rays->GetFiducial( i ) ); }
""")
def rays(self, a, b, file, node):
    P = self.P
    sensor = RayProximity(self.world, a, 3)
    for i in range(3):
        sensor.SetRay(i, (0.3, 0.05 * i, 0), (3, 0.05 * i, 0))
    BoxGeom(b, None, 0.1, 0.1, 0.1)
    b.geoms[0].SetRetro(0.75)
    b.geoms[0].SetFiducial(4)
    b.SetPosition((1.5, 0, 1))
    P(1)
    P(sensor.GetRange(0) == sys.float_info.max)
    sensor.Update()
    for value in sensor.GetRay(1):
        P(value)
    for i in range(3):
        for value in (sensor.GetRange(i), sensor.GetRetro(i), sensor.GetFiducial(i)):
            P(value)
    assert sensor.GetRange(0) < 2.0  # it is hit


@pytest.fixture(scope="module")
def probe(tmp_path_factory):
    """A folder with a plugin that has all groups."""
    folder = tmp_path_factory.mktemp("probe")
    methods = "".join(
        f"public: void {name}( Body *a, Body *b, WorldFile *file, WorldFileNode *node ) {{ {code} }}\n"
        for name, (code, _) in GROUPS.items()
    )
    calls = "".join(f'if ( strcmp( group, "{name}" ) == 0 ) this->{name}( a, b, file, node );\n' for name in GROUPS)
    compiled(folder, "Probe", PROBE.replace("GROUPS", methods).replace("CALLS", calls))
    return folder


@pytest.mark.parametrize("name", list(GROUPS))
def test_plugins_in_both_languages_see_the_same(probe, name, caplog):
    caplog.set_level("INFO")
    out = probe / f"{name}.txt"
    more = (
        f"<group>{name}</group><out>{out}</out><number>2.75</number><text> some text </text><flag>true</flag>"
        "<angle>33</angle><tuple>10 20 30.5</tuple><color>0.5 0.25 1</color><self>w.world</self>"
    )
    path = probe / "w.world"
    path.write_text(world_text(("Probe", more)))
    libgz.World.from_file(path).close()
    python = type("Probe", (PyProbe,), {"group": GROUPS[name][1], "out": []})
    with libgz.World() as world:
        world.legacy.factory.RegisterModel("plugin", "Probe", python)
        file = WorldFile()
        file.LoadString(path.read_text().replace("<plugin>Probe.so</plugin>", ""))
        world.Load(file)
    seen = [float.fromhex(line) if "0x" in line or line == "inf" else line for line in out.read_text().splitlines()]
    assert len(seen) > 10
    assert seen == python.out
    if name == "model":
        assert "three 2 1.5" in caplog.text
        assert "warned 1" in caplog.text


def test_changes_of_the_world_s_data_are_taken(probe):
    path = probe / "data.world"
    path.write_text(world_text(("Probe", f"<group>model</group><out>{probe / 'data.txt'}</out>")))
    with libgz.World.from_file(path) as world:
        assert (world.simSpeed, world.fogDensity, tuple(world.skyColor)) == (2.5, 0.5, (0.5, 0.25, 1.0, 1.0))
        assert world.models[0].GetId() == "renamed"
