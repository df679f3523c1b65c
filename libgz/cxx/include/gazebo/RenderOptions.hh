/* What cameras render. License: Apache License 2.0. */

#ifndef LIBGZ_RENDEROPTIONS_HH
#define LIBGZ_RENDEROPTIONS_HH

#include "Vector.hh"

/// What a camera renders.
struct RenderOptions
{
  bool displayBBox;
  bool displayAxes;
  bool displayCoM;
  bool displaySkins;
  bool displayRays;
  bool displayFrustrums;
  bool displayMaterials;
  bool displayTextures;
  int polygonMode; // GL_LINE or GL_FILL
  int shadeModel; // GL_FLAT or GL_SMOOTH
  int cameraIndex;
  GzPose cameraPose;
  double farClip; // [m]
};

/// The options of a new camera.
inline void libgz_default_options( RenderOptions *options )
{
  options->displayBBox = options->displayAxes = options->displayCoM = options->displaySkins = false;
  options->displayRays = options->displayFrustrums = false;
  options->displayMaterials = options->displayTextures = true;
  options->polygonMode = GL_FILL;
  options->shadeModel = GL_SMOOTH;
  options->cameraIndex = 0;
  options->cameraPose.pos = GzVectorZero();
  options->cameraPose.rot = GzQuaternIdent();
  options->farClip = 0.0;
}

#endif
