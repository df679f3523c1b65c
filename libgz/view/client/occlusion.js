// Occlusion: darkens where surfaces meet, such as below a wheel or in a corner, from the depths of what is seen.

import {
  CustomBlending,
  DepthTexture,
  DstColorFactor,
  Matrix4,
  Mesh,
  MeshBasicMaterial,
  NearestFilter,
  NoBlending,
  OrthographicCamera,
  PlaneGeometry,
  Scene,
  ShaderMaterial,
  Vector2,
  WebGLRenderTarget,
  ZeroFactor,
} from "three";

const VERTEX = `
varying vec2 at;
void main() {
  at = uv;
  gl_Position = vec4(position.xy, 0.0, 1.0);
}`;
// Points on a spiral around each pixel: those that rise above its surface, and are near it, hide a part of the sky.
const FRAGMENT = `
uniform sampler2D depths;
uniform vec2 texel;
uniform mat4 unproject;
uniform float reach, scale;
varying vec2 at;
vec3 place(vec2 where) {
  vec4 point = unproject * vec4(2.0 * vec3(where, texture2D(depths, where).x) - 1.0, 1.0);
  return point.xyz / point.w;
}
void main() {
  gl_FragColor = vec4(1.0);
  if (texture2D(depths, at).x >= 1.0) return;
  vec3 here = place(at);
  float pixels = min(reach * scale / -here.z, 80.0);
  if (pixels < 2.0) return;
  vec3 left = here - place(at - vec2(texel.x, 0.0)), right = place(at + vec2(texel.x, 0.0)) - here;
  vec3 below = here - place(at - vec2(0.0, texel.y)), above = place(at + vec2(0.0, texel.y)) - here;
  vec3 across = abs(left.z) < abs(right.z) ? left : right, upwards = abs(below.z) < abs(above.z) ? below : above;
  vec3 normal = normalize(cross(across, upwards));
  float angle = 6.2831853 * fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))), hidden = 0.0;
  for (int i = 0; i < 16; i++) {
    float share = (float(i) + 0.5) / 16.0;
    angle += 2.3999632;
    vec3 away = place(at + share * pixels * texel * vec2(cos(angle), sin(angle))) - here;
    float far = length(away), rise = dot(away, normal) - 0.004 * -here.z;
    hidden += max(rise, 0.0) / (far + 1e-4) * max(1.0 - far / reach, 0.0);
  }
  gl_FragColor.r = clamp(1.0 - 0.24 * hidden, 0.25, 1.0);
}`;
const BLUR = `
uniform sampler2D shades, depths;
uniform vec2 texel;
varying vec2 at;
void main() {
  float here = texture2D(depths, at).x, sum = 0.0, weights = 0.0;
  for (int i = -2; i < 2; i++) {
    for (int j = -2; j < 2; j++) {
      vec2 where = at + texel * (vec2(float(i), float(j)) + 0.5);
      float weight = exp(-abs(texture2D(depths, where).x - here) * 4000.0) + 1e-3;
      sum += weight * texture2D(shades, where).r;
      weights += weight;
    }
  }
  gl_FragColor = vec4(vec3(sum / weights), 1.0);
}`;

/** Darkens an image that has been rendered. */
export class Occlusion {
  constructor() {
    this._depths = new WebGLRenderTarget(1, 1, { depthTexture: new DepthTexture(1, 1), minFilter: NearestFilter, magFilter: NearestFilter });
    this._shades = new WebGLRenderTarget(1, 1, { minFilter: NearestFilter, magFilter: NearestFilter, depthBuffer: false });
    this._plain = new MeshBasicMaterial({ colorWrite: false, side: 2 });
    const depths = { value: this._depths.depthTexture }, texel = { value: new Vector2() };
    this.uniforms = { depths, texel, unproject: { value: new Matrix4() }, reach: { value: 1 }, scale: { value: 1 } };
    const common = { vertexShader: VERTEX, depthTest: false, depthWrite: false, toneMapped: false };
    this._shade = new ShaderMaterial({ ...common, fragmentShader: FRAGMENT, uniforms: this.uniforms, blending: NoBlending });
    this._blur = new ShaderMaterial({
      ...common,
      fragmentShader: BLUR,
      uniforms: { shades: { value: this._shades.texture }, depths, texel },
      transparent: true,
      blending: CustomBlending,
      blendSrc: DstColorFactor,
      blendDst: ZeroFactor,
    });
    this._quad = new Mesh(new PlaneGeometry(2, 2), this._blur);
    this._quad.frustumCulled = false;
    this._scene = new Scene();
    this._scene.add(this._quad);
    this._flat = new OrthographicCamera();
  }

  /**
   * Darken the image on the canvas.
   * @param {import("three").WebGLRenderer} renderer
   * @param {Scene} scene
   * @param {import("three").PerspectiveCamera} camera
   * @param {import("three").Object3D[]} solid groups of what hides light; nothing else does
   * @param {number} reach [m] how far from what is near
   */
  render(renderer, scene, camera, solid, reach) {
    const size = renderer.getDrawingBufferSize(new Vector2()).multiplyScalar(0.5).ceil();
    this._depths.setSize(size.x, size.y);
    this._shades.setSize(size.x, size.y);
    this.uniforms.texel.value.set(1 / size.x, 1 / size.y);
    this.uniforms.unproject.value.copy(camera.projectionMatrixInverse);
    this.uniforms.reach.value = reach;
    this.uniforms.scale.value = 0.5 * size.y * camera.projectionMatrix.elements[5];
    const hidden = scene.children.filter((child) => child.visible && !solid.includes(child));
    for (const group of solid) {
      for (const child of group.children) {
        const { material } = /** @type {Mesh} */ (child);
        if (child.visible && /** @type {any} */ (material)?.transparent) hidden.push(child);
      }
    }
    for (const one of hidden) one.visible = false;
    const { autoClear, shadowMap } = renderer, { background, fog, environment } = scene, fresh = shadowMap.needsUpdate;
    Object.assign(scene, { overrideMaterial: this._plain, background: null, fog: null, environment: null });
    shadowMap.needsUpdate = false;
    renderer.setRenderTarget(this._depths);
    renderer.clear();
    renderer.render(scene, camera);
    Object.assign(scene, { overrideMaterial: null, background, fog, environment });
    shadowMap.needsUpdate = fresh;
    for (const one of hidden) one.visible = true;
    this._quad.material = this._shade;
    renderer.setRenderTarget(this._shades);
    renderer.render(this._scene, this._flat);
    this._quad.material = this._blur;
    renderer.setRenderTarget(null);
    renderer.autoClear = false;
    renderer.render(this._scene, this._flat);
    renderer.autoClear = autoClear;
  }
}
