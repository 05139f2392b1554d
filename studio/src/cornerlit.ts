// Tools that are lit at their corners: graphics without a card take longer to light their pixels than to draw all else of a frame.

import { Color, type Mesh, type MeshStandardMaterial, type Object3D, ShaderMaterial, UniformsLib, UniformsUtils } from "three";

/** Light of a rough surface with a thin gloss: Lambert, and the lobe of Trowbridge and Reitz (GGX) with Schlick's reflectance. */
const VERTEX = `
  #include <common>
  #include <lights_pars_begin>
  #include <clipping_planes_pars_vertex>
  uniform vec3 diffuse;
  uniform float roughness, metalness;
  varying vec3 colour;

  vec3 gloss(vec3 to, vec3 eye, vec3 outwards) {
    vec3 half_ = normalize(to + eye);
    float wide = roughness * roughness;
    float narrow = wide * wide;
    float toLight = saturate(dot(outwards, to)), toEye = saturate(dot(outwards, eye)), toHalf = saturate(dot(outwards, half_));
    float seen = toLight * sqrt(narrow + (1.0 - narrow) * toEye * toEye) + toEye * sqrt(narrow + (1.0 - narrow) * toLight * toLight);
    float spread = toHalf * toHalf * (narrow - 1.0) + 1.0;
    vec3 straight = mix(vec3(0.04), diffuse, metalness);
    vec3 reflected = straight + (1.0 - straight) * pow(1.0 - saturate(dot(eye, half_)), 5.0);
    return reflected * (0.5 / max(seen, EPSILON)) * narrow * RECIPROCAL_PI / (spread * spread);
  }

  void main() {
    #include <begin_vertex>
    #include <project_vertex>
    #include <clipping_planes_vertex>
    vec3 outwards = normalize(normalMatrix * normal);
    #ifdef FLIP_SIDED
      outwards = -outwards;
    #endif
    vec3 matt = diffuse * (1.0 - metalness) * RECIPROCAL_PI;
    vec3 eye = normalize(-mvPosition.xyz);
    vec3 around = ambientLightColor;
    for (int at = 0; at < NUM_HEMI_LIGHTS; at += 1) around += getHemisphereLightIrradiance(hemisphereLights[at], outwards);
    colour = around * matt;
    for (int at = 0; at < NUM_DIR_LIGHTS; at += 1) {
      vec3 to = directionalLights[at].direction;
      colour += saturate(dot(outwards, to)) * directionalLights[at].color * (matt + gloss(to, eye, outwards));
    }
  }`;

const FRAGMENT = `
  #include <clipping_planes_pars_fragment>
  uniform float opacity;
  varying vec3 colour;
  void main() {
    #include <clipping_planes_fragment>
    gl_FragColor = vec4(colour, opacity);
    #include <colorspace_fragment>
  }`;

/** Looks as another material does, lit at the corners of triangles alone. */
class CornerLit extends ShaderMaterial {
  constructor({ color, opacity, roughness, metalness, side, transparent, depthWrite }: MeshStandardMaterial) {
    const own = { diffuse: { value: color.clone() }, opacity: { value: opacity }, roughness: { value: roughness }, metalness: { value: metalness } };
    super({
      uniforms: UniformsUtils.merge([UniformsLib.lights, own]),
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      lights: true,
      clipping: true,
      side,
      transparent,
      depthWrite,
    });
  }

  get color(): Color {
    return this.uniforms.diffuse!.value as Color;
  }
}

/** Lights everything in an object at its corners. */
export function lightCorners(object: Object3D): void {
  object.traverse((one) => {
    const { material } = one as Partial<Mesh>;
    if (!material) return;
    (one as Mesh).material = new CornerLit(material as MeshStandardMaterial);
    (material as MeshStandardMaterial).dispose();
  });
}
