#version 450
// One pass over light that was computed once per scenario:
//   colour = gamma(exposure * irradiance * albedo), and a second picture of label ids.
// How a material's slots are read (adc_bench/render/materials.py fills them):
//   base colour texture   metallic 0: albedo in rgb; metallic 1: red = tone of the base colour, green = share of paint,
//                         blue = where paint wears off, alpha = where dust lies
//   base colour           albedo, or the tone's colour; emission: the paint's colour
//   ior, transmission roughness   how much of the wear, of the dust
//   emission texture      irradiance (or, where there is no base colour texture, radiance at exposure 1);
//                         on the floor alpha = the floodlights' share, elsewhere label id / 255 of each texel
//   roughness             label id / 255 of the whole, added to that
//   transmission          1 on the floor: the robot's shadow falls here, and the hall shows in it
//   specular              the floor's gloss; roughness texture: the hall as seen from the floor
// The exposure comes in as the scene's ambient light; point lights carry the robot, the floodlights and the hall.

layout(set = 0, binding = 0) uniform CameraBuffer {
  mat4 viewMatrix;
  mat4 projectionMatrix;
  mat4 viewMatrixInverse;
  mat4 projectionMatrixInverse;
  float width;
  float height;
} cameraBuffer;

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
layout(location = 1) in vec2 inWorld;
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

// How long the way up to a floodlight runs through a box (half size, about the robot's `centre`) between two heights.
float run(vec2 place, vec2 inverse, vec2 centre, vec2 halfSize, float low, float high) {
  vec2 middle = (centre - place) * inverse;
  vec2 reach = abs(halfSize * inverse);
  float enter = max(max(middle.x - reach.x, middle.y - reach.y), low);
  return min(min(middle.x + reach.x, middle.y + reach.y), high) - enter;
}

// The share of the light that the robot leaves on the floor; `flooded` is the floodlights' share of it.
float besideRobot(float flooded) {
  vec4 robot = vec4(sceneBuffer.pointLights[0].position.xyz, 0);       // x, y, half length
  vec3 turn = sceneBuffer.pointLights[0].emission.rgb;                 // cosine, sine, half width
  vec2 away = inWorld - robot.xy;
  vec2 place = vec2(turn.x * away.x + turn.y * away.y, turn.x * away.y - turn.y * away.x);
  vec2 halfSize = vec2(robot.z, turn.z);
  float seen = 0;
  for (int k = 1; k < 3; ++k) {
    vec3 flood = sceneBuffer.pointLights[k].position.xyz;              // 1 / way per height along x, y; weight
    float hull = run(place, flood.xy, vec2(0), halfSize, 0.0, 0.22);
    float mast = run(place, flood.xy, vec2(0.03, 0), vec2(0.03), 0.2, 0.72);
    seen += flood.z * (1 - clamp(max(hull * 40, mast * 20), 0.0, 1.0));
  }
  float gap = clamp(1 - length(max(abs(place) - halfSize, vec2(0))) * 8, 0.0, 1.0);
  return flooded * seen + (1 - flooded) * (1 - 0.6 * gap * gap);
}

// The hall mirrored in a floor with a clear coat: where the mirrored ray leaves the hall, in a small picture of it.
vec3 mirrored() {
  vec3 eye = cameraBuffer.viewMatrixInverse[3].xyz;
  vec3 ray = vec3(inWorld - eye.xy, max(eye.z, 0.01));
  vec3 hall = sceneBuffer.pointLights[1].emission.rgb;                 // half length, half width, height
  vec2 walls = (hall.xy - sign(ray.xy) * inWorld) / max(abs(ray.xy), vec2(1e-4));
  vec3 hit = vec3(inWorld, 0) + ray * min(min(walls.x, walls.y), hall.z / ray.z);
  vec2 at = hit.xy / (length(hit) + hit.z) * 0.5 + 0.5;
  float off = 1 - ray.z * inversesqrt(dot(ray, ray));
  float off2 = off * off;
  return texture(roughnessTexture, at).rgb * (0.04 + 0.96 * off2 * off2 * off);
}

void main() {
  vec4 light = (materialBuffer.textureMask & 16) != 0 ? texture(emissionTexture, inUV) : vec4(1);
  vec3 radiance = light.rgb * albedo();
  if (materialBuffer.transmission > 0.5) {
    float shade = besideRobot(light.a);
    float open = clamp(light.g * sceneBuffer.pointLights[2].emission.r, 0.0, 1.0);
    radiance = radiance * shade + mirrored() * (materialBuffer.fresnel * open);
  }
  vec3 exposed = sceneBuffer.ambientLight.rgb * radiance;
  outColor = vec4(pow(clamp(exposed, 0.0, 1.0), vec3(1.0 / 2.2)), 1);
  bool isPiecewise = (materialBuffer.textureMask & 16) != 0 && materialBuffer.transmission < 0.5;
  outLabel = vec4(materialBuffer.roughness + (isPiecewise ? light.a : 0), 0, 0, 1);
}
