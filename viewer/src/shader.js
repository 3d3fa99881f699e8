// The shader of faces: colour by mode, light from the camera's side, sides of elements as thin lines.
import * as THREE from 'three';

export const MODE = { plain: 0, tint: 1, ramp: 2 };

const VERTEX = /* glsl */ `
  #include <clipping_planes_pars_vertex>
  attribute vec3 bary;
  attribute vec4 tint;
  attribute float value;
  attribute float kept;
  attribute vec3 middle;
  uniform float shrink;
  varying vec3 vNormal;
  varying vec3 vEye;
  varying vec3 vBary;
  varying vec4 vTint;
  varying float vValue;
  varying float vKept;
  void main() {
    vec3 place = mix(middle, position, shrink);
    vec4 mvPosition = modelViewMatrix * vec4(place, 1.0);
    vNormal = normalMatrix * normal;
    vEye = mvPosition.xyz;
    vBary = bary;
    vTint = tint;
    vValue = value;
    vKept = kept;
    gl_Position = projectionMatrix * mvPosition;
    #include <clipping_planes_vertex>
  }`;

const FRAGMENT = /* glsl */ `
  #include <clipping_planes_pars_fragment>
  uniform int mode;
  uniform vec3 plain;
  uniform vec3 missing;
  uniform vec3 invalid;
  uniform vec3 line;
  uniform vec3 inside;
  uniform float lines;
  uniform float ratio;
  uniform float opacity;
  uniform bool flatFaces;
  uniform bool hasInvalid;
  uniform bool filtered;
  uniform vec2 range;
  uniform vec2 keep;
  uniform sampler2D ramp;
  varying vec3 vNormal;
  varying vec3 vEye;
  varying vec3 vBary;
  varying vec4 vTint;
  varying float vValue;
  varying float vKept;

  vec3 albedo() {
    if (mode == 0) return plain;
    if (mode == 1) return vTint.rgb;
    if (isnan(vValue) || isinf(vValue)) return missing;
    if (hasInvalid && vValue <= 0.0) return invalid;
    float place = clamp((vValue - range.x) / (range.y - range.x), 0.0, 1.0);
    return texture2D(ramp, vec2((place * 255.0 + 0.5) / 256.0, 0.5)).rgb;
  }

  // How much of a pixel the nearest side of the element covers; sides vanish where elements are as small as pixels.
  float side() {
    vec3 pixel = fwidth(vBary) + 1e-6;
    vec3 near = smoothstep(vec3(0.15), vec3(1.05), vBary / (pixel * ratio));
    float size = max(pixel.x, max(pixel.y, pixel.z));
    return (1.0 - min(near.x, min(near.y, near.z))) * (1.0 - smoothstep(0.06, 0.36, size));
  }

  void main() {
    #include <clipping_planes_fragment>
    if (filtered && !(vKept >= keep.x && vKept <= keep.y)) discard;
    vec3 facing = normalize(cross(dFdx(vEye), dFdy(vEye)));
    vec3 n = flatFaces || dot(vNormal, vNormal) < 1e-6 ? facing : normalize(vNormal);
    if (dot(n, facing) < 0.0) n = -n;
    vec3 color = albedo();
    color *= color;
    if (!gl_FrontFacing) color = mix(color, inside * inside, 0.72);
    float key = max(dot(n, normalize(vec3(-0.35, 0.55, 0.76))), 0.0);
    float fill = max(dot(n, normalize(vec3(0.65, -0.2, 0.5))), 0.0);
    float light = 0.50 + 0.44 * key + 0.14 * fill + 0.05 * n.y;
    color = sqrt(color * light);
    color = mix(color, line, lines * side());
    gl_FragColor = vec4(color, opacity);
  }`;

export function faceMaterial() {
  const color = () => ({ value: new THREE.Vector3() });
  return new THREE.ShaderMaterial({
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    side: THREE.DoubleSide,
    clipping: true,
    polygonOffset: true,
    polygonOffsetFactor: 1.5,
    polygonOffsetUnits: 2,
    uniforms: {
      mode: { value: 0 }, ramp: { value: null }, range: { value: new THREE.Vector2(0, 1) },
      keep: { value: new THREE.Vector2() }, filtered: { value: false }, lines: { value: 0.5 }, ratio: { value: Math.min(2, window.devicePixelRatio || 1) }, opacity: { value: 1 },
      flatFaces: { value: false }, hasInvalid: { value: false }, shrink: { value: 1 },
      plain: color(), missing: color(), invalid: color(), line: color(), inside: color(),
    },
  });
}
