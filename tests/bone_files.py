"""A COLLADA file of two bones, for tests: an arm along x, of four vertices on each bone, whose second bone turns."""

import numpy as np

SQUARE = np.array([[0.0, -0.1, -0.1], [0.0, 0.1, -0.1], [0.0, 0.1, 0.1], [0.0, -0.1, 0.1]])


def _text(values):
    return " ".join(repr(float(value)) for value in np.ravel(values))


def _source(name, values):
    return f'<source id="{name}"><float_array id="{name}-a">{_text(values)}</float_array></source>'


def two_bones(unit=1.0, armature="", target="elbow/turn.ANGLE", angles=(0.0, 90.0), skin=True, names="shoulder elbow"):
    """The text of the file; lengths in it are in `unit`, the elbow is at 1 m, and turns about z within 2 s."""
    s = 1.0 / unit
    vertices = np.concatenate([SQUARE + np.array((x, 0.0, 0.0)) for x in (0.0, 1.0, 2.0)]) * s
    faces = [(0, 1, 5), (0, 5, 4), (4, 5, 9), (4, 9, 8), (2, 3, 7), (6, 10, 11)]
    elbow = np.eye(4)
    elbow[0, 3] = -1.0 * s
    controller = f"""<library_controllers><controller id="ctl"><skin source="#mesh">
      {_source("binds", np.stack([np.eye(4), elbow]))}{_source("weights", [1.0, 0.5])}
      <source id="joints"><Name_array>{names}</Name_array></source>
      <joints><input semantic="JOINT" source="#joints"/><input semantic="INV_BIND_MATRIX" source="#binds"/></joints>
      <vertex_weights count="12"><input semantic="JOINT" source="#joints" offset="0"/>
        <input semantic="WEIGHT" source="#weights" offset="1"/>
        <vcount>1 1 1 1 2 2 2 2 1 1 1 1</vcount>
        <v>{"0 0 " * 4}{"0 1 1 1 " * 4}{"1 0 " * 4}</v></vertex_weights></skin></controller></library_controllers>"""
    instance = (
        '<node id="arm"><instance_controller url="#ctl"><skeleton>#shoulder</skeleton></instance_controller></node>'
    )
    times, turns = _source("times", [0.0, 2.0]), _source("turns", angles)
    return f"""<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset><unit meter="{unit}"/></asset>
  <library_geometries><geometry id="mesh"><mesh>{_source("points", vertices)}
    <vertices id="verts"><input semantic="POSITION" source="#points"/></vertices>
    <triangles count="{len(faces)}"><input semantic="VERTEX" source="#verts" offset="0"/>
      <p>{" ".join(str(i) for face in faces for i in face)}</p></triangles></mesh></geometry></library_geometries>
  {controller if skin else ""}
  <library_animations><animation>{times}{turns}<sampler id="s"><input semantic="INPUT" source="#times"/>
    <input semantic="OUTPUT" source="#turns"/></sampler><channel source="#s" target="{target}"/></animation>
  </library_animations>
  <library_visual_scenes><visual_scene id="scene"><node id="armature">{armature}
    <node id="shoulder" sid="shoulder" type="JOINT"><translate sid="place">0 0 0</translate>
      <node id="elbow" sid="elbow" type="JOINT"><translate sid="place">{s} 0 0</translate>
        <rotate sid="turn">0 0 1 0</rotate></node></node></node>{instance if skin else ""}
  </visual_scene></library_visual_scenes>
</COLLADA>
"""
