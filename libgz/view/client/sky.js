// Sky: what is behind everything: the world's background, sky or tone map, its horizon, and fog.

import { BackSide, Color, Fog, FogExp2, Mesh, PMREMGenerator, Scene, ShaderMaterial, SphereGeometry, Vector3 } from "three";
import { columnOf } from "libgz/assets.js";
import { toned } from "libgz/materials.js";

/** @typedef {import("libgz/assets.js").Assets} Assets */

const PLAIN = [[0.7, 0.7, 0.7], [0.7, 0.7, 0.9]]; // the backgrounds of worlds that name none, of both eras
const THEMES = {
  light: { zenith: new Color(0x8fb4de), horizon: new Color(0xe9eff5), below: new Color(0xc9cfd6) },
  dark: { zenith: new Color(0x12151b), horizon: new Color(0x3b4453), below: new Color(0x20242c) },
};
const DUSK = 0.22; // how much of a world's colours the dark theme leaves
const WHITE = new Color(0xffffff);

const VERTEX = `
varying vec3 direction;
void main() {
  direction = position;
  gl_Position = (projectionMatrix * mat4(mat3(viewMatrix)) * vec4(position, 1.0)).xyww;
}`;
const FRAGMENT = `
varying vec3 direction;
uniform vec3 zenith, horizon, below, sun, glow;
float noise(vec2 at) { return fract(52.9829189 * fract(dot(at, vec2(0.06711056, 0.00583715)))); }
void main() {
  vec3 d = normalize(direction);
  vec3 color = d.z > 0.0 ? mix(horizon, zenith, pow(d.z, 0.55)) : mix(horizon, below, smoothstep(0.0, 0.25, -d.z));
  float near = max(dot(d, sun), 0.0);
  color += glow * (0.18 * pow(near, 12.0) + 0.35 * pow(near, 220.0) + 3.0 * smoothstep(0.9993, 0.9997, near));
  gl_FragColor = vec4(color, 1.0);
  #include <colorspace_fragment>
  gl_FragColor.rgb += (noise(gl_FragCoord.xy) - 0.5) / 255.0;
}`;

/** Shows the sky. */
export class Sky {
  constructor() {
    this.horizon = new Color();
    this.zenith = new Color();
    this.uniforms = {
      zenith: { value: new Color() },
      horizon: { value: new Color() },
      below: { value: new Color() },
      glow: { value: new Color(0, 0, 0) },
      sun: { value: new Vector3(0, 0, 1) },
    };
    const material = new ShaderMaterial({
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      uniforms: this.uniforms,
      side: BackSide,
      depthWrite: false,
      toneMapped: false,
    });
    this.mesh = new Mesh(new SphereGeometry(1, 32, 24), material);
    this.mesh.frustumCulled = false;
    this.mesh.raycast = () => {};
    /** @type {import("three").WebGLRenderTarget | null} */
    this._reflection = null;
    this.mesh.renderOrder = 1000; // where nothing else was rendered
    /** @type {Fog | null} */
    this._haze = null;
  }

  /**
   * Show the sky of a scene; returns its fog.
   * @param {any} scene of the world, or null
   * @param {Assets} assets
   * @param {"light" | "dark"} theme
   */
  show(scene, assets, theme) {
    const { zenith, horizon, below, glow } = this.uniforms;
    const background = scene ? scene.background.slice(0, 3) : PLAIN[0];
    const plain = PLAIN.some((one) => one.every((part, i) => Math.abs(part - background[i]) < 0.01));
    const map = scene?.sky ? assets.texture(scene.sky.texture) : null;
    glow.value.setRGB(0, 0, 0);
    if (scene?.sky && map) {
      const tones = columnOf(map, (scene.sky.time_of_day ?? 43200) / 86400);
      toned(tones[0], zenith.value);
      toned(tones[tones.length - 1], horizon.value);
      below.value.copy(horizon.value).multiplyScalar(0.7);
      glow.value.setRGB(1, 0.92, 0.78).multiplyScalar(horizon.value.r);
    } else if (plain) {
      const colors = THEMES[theme];
      zenith.value.copy(colors.zenith);
      horizon.value.copy(colors.horizon);
      below.value.copy(colors.below);
    } else {
      toned(background, zenith.value);
      horizon.value.copy(zenith.value).lerp(WHITE, 0.55);
      below.value.copy(zenith.value).multiplyScalar(0.75);
      if (Math.max(...background) < 0.15) {
        horizon.value.copy(zenith.value).multiplyScalar(1.6); // night stays night
      } else if (theme === "dark") {
        for (const { value } of [zenith, horizon, below]) value.multiplyScalar(DUSK);
      }
    }
    const fog = scene?.fog ?? null;
    if (fog) {
      toned(fog.color, horizon.value);
      zenith.value.lerp(horizon.value, 0.7);
      below.value.copy(horizon.value);
    }
    this.horizon.copy(horizon.value);
    this.zenith.copy(zenith.value);
    this._haze = fog ? null : new Fog(horizon.value); // the ground ends in haze, not at an edge
    if (this._haze) return this._haze;
    const density = Math.max(fog.density, 1e-6);
    if (fog.kind === "linear") return new Fog(horizon.value, fog.start ?? 0, Math.max(fog.end ?? 100, (fog.start ?? 0) + 0.01));
    return fog.kind === "exp2" ? new FogExp2(horizon.value, density) : new Fog(horizon.value, 0.1 / density, 2.5 / density);
  }

  /**
   * An image of the sky that fine materials reflect.
   * @param {import("three").WebGLRenderer} renderer
   */
  reflection(renderer) {
    const { parent } = this.mesh, alone = new Scene();
    alone.add(this.mesh);
    const generator = new PMREMGenerator(renderer);
    const target = generator.fromScene(alone, 0.02);
    generator.dispose();
    parent?.add(this.mesh);
    this._reflection?.dispose();
    this._reflection = target;
    return target.texture;
  }

  /** Let haze begin behind what is looked at. @param {number} distance of it [m] */
  reach(distance) {
    if (this._haze) Object.assign(this._haze, { near: 20 + 4 * distance, far: 150 + 40 * distance });
  }

  /** Where the sun is seen, if the sky has one. @param {Vector3} towards */
  turn(towards) {
    this.uniforms.sun.value.copy(towards).normalize();
  }
}
