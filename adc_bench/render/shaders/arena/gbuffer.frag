#version 450
// One pass over light that was computed once per scenario:
//   colour = gamma(exposure * irradiance * albedo), and a second picture of label ids.
// How a material's slots are read (adc_bench/render/scene.py fills them):
//   base colour texture   metallic 0: albedo in rgb; metallic 1: red = tone of the base colour, green = share of paint,
//                         blue = where paint wears off, alpha = where dust lies
//   ior, transmission roughness   how much of the wear, of the dust
//   base colour           albedo, or the tone's colour; emission: the paint's colour
//   emission texture      irradiance (or, where there is no base colour texture, radiance at exposure 1)
//   roughness             label id / 255
// The exposure comes in as the scene's ambient light.

layout(set = 2, binding = 0) uniform MaterialBuffer {
  vec4 emission;
  vec4 baseColor;
  float fresnel;
  float roughness;
  float metallic;
  float transmission;
  float ior;
  float transmissionRoughness;
  int textureMask;
  int padding1;
  vec4 textureTransforms[6];
} materialBuffer;

layout(set = 2, binding = 1) uniform sampler2D colorTexture;
layout(set = 2, binding = 2) uniform sampler2D roughnessTexture;
layout(set = 2, binding = 3) uniform sampler2D normalTexture;
layout(set = 2, binding = 4) uniform sampler2D metallicTexture;
layout(set = 2, binding = 5) uniform sampler2D emissionTexture;

struct PointLight {
  vec4 position;
  vec4 emission;
};

struct DirectionalLight {
  vec4 direction;
  vec4 emission;
};

struct SpotLight {
  vec4 position;
  vec4 direction;
  vec4 emission;
};

layout(set = 3, binding = 0) uniform SceneBuffer {
  vec4 ambientLight;
  DirectionalLight directionalLights[3];
  SpotLight spotLights[10];
  PointLight pointLights[10];
  SpotLight texturedLights[1];
} sceneBuffer;

layout(location = 0) in vec2 inUV;
layout(location = 0) out vec4 outColor;
layout(location = 1) out vec4 outLabel;

const vec3 DUST = vec3(0.21, 0.20, 0.18);

vec3 albedo() {
  if ((materialBuffer.textureMask & 1) == 0) {
    return materialBuffer.baseColor.rgb;
  }
  vec4 texel = texture(colorTexture, inUV);
  if (materialBuffer.metallic < 0.5) {
    return texel.rgb * materialBuffer.baseColor.rgb;
  }
  float paint = texel.g * (1 - materialBuffer.ior * texel.b);
  vec3 clean = mix(materialBuffer.baseColor.rgb * texel.r, materialBuffer.emission.rgb, paint);
  return mix(clean, DUST, materialBuffer.transmissionRoughness * texel.a);
}

void main() {
  vec3 light = (materialBuffer.textureMask & 16) != 0 ? texture(emissionTexture, inUV).rgb : vec3(1);
  vec3 exposed = sceneBuffer.ambientLight.rgb * light * albedo();
  outColor = vec4(pow(clamp(exposed, 0.0, 1.0), vec3(1.0 / 2.2)), 1);
  outLabel = vec4(materialBuffer.roughness, 0, 0, 1);
}
