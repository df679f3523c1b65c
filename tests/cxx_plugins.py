"""C++ plugins for tests: compiled as `libgz cxx build` does."""

import shutil

import pytest

import libgz
from libgz.cxx import build

HAS_COMPILER = shutil.which("c++") is not None or shutil.which("g++") is not None
needs_cxx = pytest.mark.skipif(not HAS_COMPILER, reason="no C++ compiler is installed")

HEADERS = """
#include <gazebo.h>
#include <gazebo/World.hh>
#include <gazebo/WorldFile.hh>
#include <gazebo/ModelFactory.hh>
#include <gazebo/Body.hh>
#include <gazebo/BoxGeom.hh>
#include <gazebo/SphereGeom.hh>
#include <gazebo/HingeJoint.hh>
"""
MODEL = (
    HEADERS
    + """
class NAME : public Model
{
  public: NAME( World *world ) : Model( world ), body( NULL ), steps( 0 ) {}
  public: virtual ~NAME() { delete this->body; }
  public: int Load( WorldFile *file, WorldFileNode *node )
    {
      this->body = new Body( this->world );
      Geom *geom = new SphereGeom( this->body, this->modelSpaceId, 0.1 );
      geom->SetMass( 1.0 );
      this->AddBody( this->body, true );
      LOAD
      return 0;
    }
  public: int Init( WorldFile *file, WorldFileNode *node ) { INIT return 0; }
  public: int Fini() { FINI return 0; }
  public: void Update( double step ) { this->steps++; UPDATE }
  public: Body *body;
  public: int steps;
};
GZ_REGISTER_PLUGIN( "NAME", NAME )
"""
)


def source(name="Tester", load="", init="", fini="", update=""):
    """The source of a model: a sphere, with code of its own in its methods."""
    text = MODEL.replace("NAME", name).replace("LOAD", load).replace("INIT", init)
    return text.replace("FINI", fini).replace("UPDATE", update)


def compiled(folder, name="Tester", text=None, **code):
    """Compile a plugin into a folder; its path."""
    path = folder / f"{name}.cc"
    path.write_text(source(name, **code) if text is None else text)
    errors = build.build([path], folder / f"{name}.so", debug=True)
    assert not errors, "\n".join(map(str, errors))
    return folder / f"{name}.so"


def world_text(*models):
    """A worldfile of models, given as `name` or as `(name, elements)`, each with its plugin and the id m0, m1 ..."""
    elements = []
    for i, model in enumerate(models):
        name, more = model if isinstance(model, tuple) else (model, "")
        elements.append(f"<model:{name}><id>m{i}</id><plugin>{name}.so</plugin>{more}</model:{name}>")
    return f"<gz:world xmlns:gz='g' xmlns:model='m'>{''.join(elements)}</gz:world>"


def load(folder, *models, **options):
    """A world of such models, whose plugins are in a folder."""
    path = folder / "w.world"
    path.write_text(world_text(*models))
    return libgz.World.from_file(path, **options)
