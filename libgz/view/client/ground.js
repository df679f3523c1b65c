// Ground: a grid of 0.1 m to 100 m on the level of the ground and on hills, which fades with distance, and the world's axes.

import { Color, DoubleSide, Group, InstancedMesh, Mesh, PlaneGeometry, ShaderMaterial, Vector3 } from "three";

const VERTEX = `
varying vec3 place;
uniform vec3 eye;
uniform float level, reach;
void main() {
#ifdef USE_INSTANCING
  place = (modelMatrix * instanceMatrix * vec4(position, 1.0)).xyz;
#else
  place = vec3(eye.xy + reach * position.xy, level);
#endif
  gl_Position = projectionMatrix * viewMatrix * vec4(place, 1.0);
}`;
const FRAGMENT = `
varying vec3 place;
uniform vec3 eye, ink;
uniform float reach, ratio;
float lines(vec2 where, float cell, float width) {
  vec2 scaled = where / cell, slope = fwidth(scaled);
  vec2 apart = abs(fract(scaled - 0.5) - 0.5) / max(slope, 1e-6);
  vec2 strength = (1.0 - smoothstep(ratio * width - 0.5, ratio * width + 0.5, apart)) * (1.0 - smoothstep(0.1, 0.4, slope));
  return max(strength.x, strength.y);
}
void main() {
  vec2 at = place.xy;
  float away = distance(place, eye);
  float fade = 1.0 - smoothstep(0.15 * reach, 0.95 * reach, away);
  if (fade <= 0.0) discard;
  float alpha = 0.36 * lines(at, 10.0, 0.9);
  if (reach > 600.0) alpha = max(alpha, 0.36 * lines(at, 100.0, 0.9));
  if (away < 90.0) alpha = max(alpha, 0.24 * lines(at, 1.0, 0.75) * (1.0 - smoothstep(25.0, 90.0, away)));
  if (away < 9.0) alpha = max(alpha, 0.10 * lines(at, 0.1, 0.6) * (1.0 - smoothstep(3.0, 9.0, away)));
  vec3 color = ink;
  vec2 axis = 1.0 - smoothstep(ratio * 1.1 - 0.5, ratio * 1.1 + 0.5, abs(at) / max(fwidth(at), vec2(1e-6)));
  if (axis.y > 0.0) { color = mix(color, vec3(0.62, 0.05, 0.06), axis.y); alpha = max(alpha, 0.85 * axis.y); }
  if (axis.x > 0.0) { color = mix(color, vec3(0.05, 0.40, 0.10), axis.x); alpha = max(alpha, 0.85 * axis.x); }
  alpha *= fade * min(0.5 + 0.5 * ratio, 1.0); // lines of large pixels are wide
  if (alpha < 0.004) discard;
  gl_FragColor = vec4(color, alpha);
  #include <colorspace_fragment>
}`;

/** Shows the grid. */
export class Ground {
  constructor() {
    this.uniforms = {
      eye: { value: new Vector3() },
      ink: { value: new Color() },
      level: { value: 0 },
      reach: { value: 100 },
      ratio: { value: 1 },
    };
    const material = new ShaderMaterial({
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      uniforms: this.uniforms,
      transparent: true,
      depthWrite: false,
      toneMapped: false,
      side: DoubleSide,
      polygonOffset: true,
      polygonOffsetFactor: -2,
      polygonOffsetUnits: -4,
    });
    this.mesh = new Mesh(new PlaneGeometry(2, 2), material);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = 1; // before what can be seen through
    this.mesh.raycast = () => {};
    /** The grid on hills. */
    this.relief = new Group();
  }

  /** Cover hills, too. @param {InstancedMesh[]} hills */
  cover(hills) {
    this.relief.clear();
    for (const { geometry, count, instanceMatrix } of hills) {
      const over = new InstancedMesh(geometry, /** @type {ShaderMaterial} */ (this.mesh.material), count);
      over.instanceMatrix = instanceMatrix;
      over.frustumCulled = false;
      over.renderOrder = 1;
      this.relief.add(over);
    }
  }

  /** @param {"light" | "dark"} theme @param {number} level [m] */
  show(theme, level) {
    this.uniforms.ink.value.set(theme === "dark" ? 0xdfe8f5 : 0x0c1422);
    this.uniforms.level.value = level;
  }

  /** Spread around the eye. @param {Vector3} eye @param {number} ratio of pixels */
  follow(eye, ratio) {
    this.uniforms.ratio.value = ratio;
    this.uniforms.eye.value.copy(eye);
    this.uniforms.reach.value = Math.max(60, 12 * Math.abs(eye.z - this.uniforms.level.value));
  }
}
