// Outline: lines around what is selected or under the pointer, over everything that is in front of it.

import {
  Color,
  Group,
  Mesh,
  MeshBasicMaterial,
  OrthographicCamera,
  PlaneGeometry,
  Scene,
  ShaderMaterial,
  SkinnedMesh,
  UnsignedByteType,
  Vector2,
  WebGLRenderTarget,
} from "three";

/** @typedef {import("libgz/bodies.js").Bodies} Bodies */

const FRAGMENT = `
uniform sampler2D mask;
uniform vec2 texel;
uniform vec3 chosen, pointed;
varying vec2 at;
void main() {
  vec2 here = texture2D(mask, at).rg, most = vec2(0.0);
  for (int i = 0; i < 8; i++) {
    float angle = 0.785398 * float(i);
    vec2 step = vec2(cos(angle), sin(angle)) * texel;
    most = max(most, max(texture2D(mask, at + 2.0 * step).rg, 0.85 * texture2D(mask, at + step).rg));
  }
  vec2 edge = clamp(most - here, 0.0, 1.0);
  float alpha = max(edge.r, 0.75 * edge.g);
  if (alpha < 0.02) discard;
  gl_FragColor = vec4(edge.r >= 0.75 * edge.g ? chosen : pointed, alpha);
  #include <colorspace_fragment>
}`;

/** Outlines shapes. */
export class Outline {
  /** @param {Bodies} bodies @param {import("libgz/skins.js").Skins} skins */
  constructor(bodies, skins) {
    this.bodies = bodies;
    this.skins = skins;
    this._scene = new Scene();
    this._meshes = new Group();
    this._scene.add(this._meshes);
    this._chosen = new MeshBasicMaterial({ color: new Color(1, 0, 0), side: 2 });
    this._pointed = new MeshBasicMaterial({ color: new Color(0, 1, 0), side: 2 });
    for (const material of [this._chosen, this._pointed]) material.toneMapped = false;
    this._target = new WebGLRenderTarget(1, 1, { type: UnsignedByteType, samples: 0 });
    this.uniforms = {
      mask: { value: this._target.texture },
      texel: { value: new Vector2() },
      chosen: { value: new Color(0x4c8dff) },
      pointed: { value: new Color(0xffffff) },
    };
    this._quad = new Mesh(
      new PlaneGeometry(2, 2),
      new ShaderMaterial({
        uniforms: this.uniforms,
        vertexShader: "varying vec2 at; void main() { at = uv; gl_Position = vec4(position.xy, 0.0, 1.0); }",
        fragmentShader: FRAGMENT,
        transparent: true,
        depthTest: false,
        depthWrite: false,
        toneMapped: false,
      }),
    );
    this._quad.frustumCulled = false;
    this._final = new Scene();
    this._final.add(this._quad);
    this._flat = new OrthographicCamera();
  }

  /**
   * What is outlined from now on.
   * @param {Iterable<number>} chosen entities
   * @param {Iterable<number>} pointed entities
   * @param {(instance: import("libgz/bodies.js").Instance) => boolean} within whether a shape of them counts
   */
  set(chosen, pointed, within = () => true) {
    this._meshes.clear();
    const selected = new Set(chosen);
    for (const [numbers, material] of /** @type {[Iterable<number>, MeshBasicMaterial][]} */ ([
      [selected, this._chosen],
      [[...pointed].filter((number) => !selected.has(number)), this._pointed],
    ])) {
      for (const number of numbers) {
        for (const instance of this.bodies.of.get(number) ?? []) {
          if (instance.ground || (material === this._chosen && !within(instance))) continue;
          const mesh = new Mesh(instance.batch.geometry, material);
          mesh.matrixAutoUpdate = false;
          mesh.frustumCulled = false;
          mesh.userData.instance = instance;
          this._meshes.add(mesh);
        }
        for (const skin of this.skins.skins) {
          if (skin.entity !== number) continue;
          const mesh = new SkinnedMesh(skin.mesh.geometry, material);
          mesh.frustumCulled = false;
          mesh.bind(skin.mesh.skeleton, skin.mesh.bindMatrix);
          this._meshes.add(mesh);
        }
      }
    }
  }

  /** @param {import("three").WebGLRenderer} renderer @param {import("three").Camera} camera */
  render(renderer, camera) {
    if (!this._meshes.children.length) return;
    const size = renderer.getDrawingBufferSize(new Vector2());
    if (size.x !== this._target.width || size.y !== this._target.height) this._target.setSize(size.x, size.y);
    const ratio = renderer.getPixelRatio();
    this.uniforms.texel.value.set(Math.max(ratio, 0.75) / size.x, Math.max(ratio, 0.75) / size.y);
    for (const { userData, matrix } of this._meshes.children) {
      if (userData.instance) this.bodies.matrix(userData.instance, matrix);
    }
    const { autoClear } = renderer, color = renderer.getClearColor(new Color()), alpha = renderer.getClearAlpha();
    renderer.setRenderTarget(this._target);
    renderer.setClearColor(0x000000, 0);
    renderer.autoClear = true;
    renderer.render(this._scene, camera);
    renderer.setRenderTarget(null);
    renderer.autoClear = false;
    renderer.render(this._final, this._flat);
    renderer.autoClear = autoClear;
    renderer.setClearColor(color, alpha);
  }
}
