"""Shading: a GLSL program that computes light at each pixel, with shadows; see `shadows`.

The program reads materials, lights and fog where OpenGL keeps them, so that it renders the same display lists. Only
textures differ: a material without one has a white one.
"""

from __future__ import annotations

import ctypes
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import LibraryError
from libgz.rendering.gl import Constant
from libgz.rendering.shadows import FIRST_UNIT, MAPS, SIZE, Fit
from libgz.rendering.shot import Shot
from libgz.rendering.tape import Tape

__all__ = ["Shading"]

FOGS = ("none", "linear", "exp", "exp2")
NO_RANGE = 1e30  # [m]
LIGHTS = 8  # the most of a shot
UNIFORMS = (
    b"image",
    *(f"{name}_map".encode() for name in MAPS),
    b"into",
    b"texel",
    b"step",
    b"reach",
    b"up",
    b"bounce",
)

VERTEX = """
varying vec3 place, normal;  // in the eye frame

void main() {
    gl_Position = ftransform();
    place = (gl_ModelViewMatrix * gl_Vertex).xyz;
    normal = gl_NormalMatrix * gl_Normal;
    gl_TexCoord[0] = gl_TextureMatrix[0] * gl_MultiTexCoord0;
}
"""

FRAGMENT = """
varying vec3 place, normal;
uniform sampler2D image;
uniform sampler2DShadow sun_near_map, sun_far_map, lamp_near_map, lamp_far_map;
uniform mat4 into[4];     // from the eye frame into the maps, 0 to 1
uniform float texel[4];   // [m] where w is 1; 0 for a map that is not used
uniform float step;       // of a map
uniform float reach[8];   // [m] of the lights
uniform vec3 up;
uniform float bounce;     // light that comes from other bodies, 0 to 1

// The share of light that arrives: the mean of 16 places around, of which those in the middle count most.
float light_at(sampler2DShadow map, vec4 at) {
    float sum = 0.0;
    vec3 middle = at.xyz / at.w;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            float weight = (i == 0 || i == 3 ? 1.0 : 3.0) * (j == 0 || j == 3 ? 1.0 : 3.0);
            vec2 away = 1.5 * step * vec2(float(i) - 1.5, float(j) - 1.5);
            sum += weight * shadow2D(map, middle + vec3(away, 0.0)).r;
        }
    return sum / 64.0;
}

// A point seen from a map, moved off its surface so that this does not shade itself.
vec4 seen(int map, vec3 n, float facing) {
    vec4 at = into[map] * vec4(place, 1.0);
    float off = texel[map] * at.w * (1.0 + 3.5 * sqrt(max(1.0 - facing * facing, 0.0)));
    return into[map] * vec4(place + off * n, 1.0);
}

bool inside(vec4 at) {
    vec2 p = at.xy / at.w;
    float rim = 4.0 * step;
    return at.w > 0.0 && p.x > rim && p.y > rim && p.x < 1.0 - rim && p.y < 1.0 - rim;
}

// The share of light that arrives: by the map for what is near if that shows it, else by the one for all.
float arriving(sampler2DShadow near, sampler2DShadow far, int first, vec3 n, float facing) {
    if (texel[first] > 0.0) {
        vec4 at = seen(first, n, facing);
        if (inside(at)) return light_at(near, at);
    }
    if (texel[first + 1] > 0.0) {
        vec4 at = seen(first + 1, n, facing);
        if (inside(at)) return light_at(far, at);
    }
    return 1.0;
}

void main() {
    vec3 n = SMOOTH ? normalize(normal) : normalize(cross(dFdx(place), dFdy(place)));
    vec3 back = -normalize(place);
    if (SMOOTH ? !gl_FrontFacing : dot(n, back) < 0.0) n = -n;

    // Light from everywhere: more from the sky than from the ground, and never nothing in a world with light.
    vec3 everywhere = gl_LightModel.ambient.rgb;
    vec3 direct = vec3(0.0), shine = vec3(0.0);
    for (int i = 0; i < COUNT; i++) {
        vec3 way = gl_LightSource[i].position.xyz;
        float fade = 1.0;
        if (gl_LightSource[i].position.w != 0.0) {
            way -= place;
            float d = length(way);
            fade = d > reach[i] ? 0.0 : 1.0 / (gl_LightSource[i].constantAttenuation
                + gl_LightSource[i].linearAttenuation * d + gl_LightSource[i].quadraticAttenuation * d * d);
        }
        way = normalize(way);
        if (gl_LightSource[i].spotCutoff <= 90.0) {
            float within = dot(-way, normalize(gl_LightSource[i].spotDirection));
            float cut = gl_LightSource[i].spotCosCutoff;
            fade *= smoothstep(cut, mix(cut, 1.0, 0.06), within)
                * pow(max(within, 0.0), gl_LightSource[i].spotExponent);
        }
        everywhere += fade * gl_LightSource[i].ambient.rgb;
        float facing = dot(n, way);
        if (facing > 0.0 && fade > 0.0) {
            if (i == SUN) fade *= arriving(sun_near_map, sun_far_map, 0, n, facing);
            if (i == LAMP) fade *= arriving(lamp_near_map, lamp_far_map, 2, n, facing);
            facing *= smoothstep(0.02, 0.35, facing);  // where round shapes shade themselves, their corners show
            direct += fade * facing * gl_LightSource[i].diffuse.rgb;
            float exponent = gl_FrontMaterial.shininess < 1.0 ? 24.0 : gl_FrontMaterial.shininess;
            float share = pow(max(dot(n, normalize(way + back)), 0.0), exponent);
            shine += fade * share * gl_LightSource[i].specular.rgb;
        }
    }
    float height = 0.5 + 0.5 * dot(n, up);
    vec3 own = gl_FrontMaterial.ambient.rgb, color = gl_FrontMaterial.diffuse.rgb;
    vec3 fill = mix(0.6, 1.1, height) * everywhere * max(own, 0.35 * color) + bounce * mix(0.16, 0.26, height) * color;
    vec4 texture = texture2D(image, gl_TexCoord[0].st);
    vec3 sum = gl_FrontMaterial.emission.rgb + fill + direct * color;
    vec3 result = sum * texture.rgb + shine * gl_FrontMaterial.specular.rgb;
    // Above 0.7 ever less is added, so that bright textures keep their details.
    vec3 above = max(result - 0.7, 0.0);
    result = min(result, 0.7) + 0.3 * (1.0 - exp(-above / 0.3));

    float distance = abs(place.z), clear = 1.0;
    if (FOG == 1) clear = (gl_Fog.end - distance) * gl_Fog.scale;
    if (FOG == 2) clear = exp(-gl_Fog.density * distance);
    if (FOG == 3) clear = exp(-gl_Fog.density * gl_Fog.density * distance * distance);
    result = mix(gl_Fog.color.rgb, min(result, 1.0), clamp(clear, 0.0, 1.0));
    gl_FragColor = vec4(result, gl_FrontMaterial.diffuse.a * texture.a);
}
"""


class Program(NamedTuple):
    """A linked program, and where its uniforms are."""

    number: int
    places: dict[bytes, int]


class Shading:
    """The programs of one context, one for each kind of shot.

    Raises:
        LibraryError: this OpenGL cannot compile them.
    """

    def __init__(self, gl: Tape) -> None:
        self.gl = gl
        self._programs: dict[tuple[tuple[str, int], ...], Program] = {}
        self._program((("COUNT", 1), ("SUN", 0), ("LAMP", -1), ("FOG", 0), ("SMOOTH", 1)))

    def _program(self, constants: tuple[tuple[str, int], ...]) -> Program:
        """The program with these constants; with them known, Mesa's takes half the time."""
        found = self._programs.get(constants)
        if found is None:
            found = self._programs[constants] = self._compile(constants)
        return found

    def _compile(self, constants: tuple[tuple[str, int], ...]) -> Program:
        gl = self.gl
        number = int(gl.glCreateProgram())
        head = "#version 120\n" + "".join(f"#define {name} {value}\n" for name, value in constants)
        head = head.replace("SMOOTH 1", "SMOOTH true").replace("SMOOTH 0", "SMOOTH false")
        for kind, source in ((Constant.VERTEX_SHADER, VERTEX), (Constant.FRAGMENT_SHADER, FRAGMENT)):
            shader = gl.glCreateShader(kind)
            text = ctypes.c_char_p((head + source).encode())
            gl.glShaderSource(shader, 1, ctypes.byref(text), None)
            gl.glCompileShader(shader)
            _require(shader, gl.glGetShaderiv, gl.glGetShaderInfoLog, Constant.COMPILE_STATUS)
            gl.glAttachShader(number, shader)
            gl.glDeleteShader(shader)
        gl.glLinkProgram(number)
        _require(number, gl.glGetProgramiv, gl.glGetProgramInfoLog, Constant.LINK_STATUS)
        places = {name: int(gl.glGetUniformLocation(number, name)) for name in UNIFORMS}
        gl.glUseProgram(number)
        gl.glUniform1i(places[b"image"], 0)
        for i, name in enumerate(MAPS):
            gl.glUniform1i(places[f"{name}_map".encode()], FIRST_UNIT + i)
        gl.glUniform1f(places[b"step"], 1.0 / SIZE)
        gl.glUseProgram(0)
        return Program(number, places)

    def begin(
        self,
        shot: Shot,
        eye: NDArray[np.float64],
        casting: tuple[int | None, int | None],
        fits: list[Fit | None],
    ) -> None:
        """Use the program for a shot from now on.

        Args:
            shot: what is rendered.
            eye: from the world into the eye frame, shape (4, 4).
            casting, fits: what `ShadowMaps.render` returned.
        """
        gl, back = self.gl, np.linalg.inv(eye)
        # A map without casters is not read.
        sun = casting[0] if fits[0] is not None else None
        lamp = casting[1] if fits[2] is not None else None
        constants = (
            ("COUNT", len(shot.lights)),
            ("SUN", -1 if sun is None else sun),
            ("LAMP", -1 if lamp is None else lamp),
            ("FOG", FOGS.index("none" if shot.fog is None else shot.fog.kind)),
            ("SMOOTH", int(shot.view.options.shadeSmooth)),
        )
        number, places = self._program(constants)
        half = np.array(((0.5, 0, 0, 0.5), (0, 0.5, 0, 0.5), (0, 0, 0.5, 0.5), (0, 0, 0, 1.0)))
        into = [np.eye(4) if fit is None else half @ fit.matrix @ back for fit in fits]
        matrices = np.ascontiguousarray([matrix.T for matrix in into], dtype=np.float32)
        texels = np.array([0.0 if fit is None else fit.texel for fit in fits], dtype=np.float32)
        reach = np.full(LIGHTS, NO_RANGE, dtype=np.float32)
        for i, light in enumerate(shot.lights):
            reach[i] = min(light.range, NO_RANGE)
        gl.glUseProgram(number)
        gl.glUniformMatrix4fv(places[b"into"], len(fits), 0, matrices)
        gl.glUniform1fv(places[b"texel"], len(fits), texels)
        gl.glUniform1fv(places[b"reach"], LIGHTS, reach)
        gl.glUniform3f(places[b"up"], *eye[:3, 2].tolist())
        gl.glUniform1f(places[b"bounce"], _bounce(shot))

    def end(self) -> None:
        """Let OpenGL compute light at vertices again."""
        self.gl.glUseProgram(0)


def _bounce(shot: Shot) -> float:
    """How much light bodies reflect onto others, 0 to 1: none in the dark, and little where spots only shine."""
    sources = [shot.ambient, *(light.ambient for light in shot.lights)]
    sources += [light.diffuse for light in shot.lights if light.kind != "spot"]
    return min(sum(max(tuple(color)[:3]) for color in sources), 1.0)


def _require(number: int, get: Any, text: Any, what: int) -> None:
    done, message = ctypes.c_int(), ctypes.create_string_buffer(2000)
    get(number, what, ctypes.byref(done))
    if not done.value:
        text(number, len(message), None, message)
        raise LibraryError(f"this OpenGL does not compile the shader: {message.value.decode(errors='replace')}")
