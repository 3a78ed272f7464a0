"""Shaders for the policy's cameras: positions and entities alone.

SAPIEN's `minimal` shaders also compute a lit color that no policy sees, which takes three times as long on a CPU.
"""

import hashlib

import sapien
from mani_skill.render import PREBUILT_SHADER_CONFIGS, ShaderConfig

from roomkin.stages.simulation.shaders import cache_folder, keep

PICTURE = "PositionSegmentation"
FORMAT = "r16g16b16a16sint"  # millimetres in the camera's frame (x right, y up, z backward) and the entity's id

VERTEX = """#version 450
layout(set = 0, binding = 0) uniform CameraBuffer {
  mat4 viewMatrix;
  mat4 projectionMatrix;
  mat4 viewMatrixInverse;
  mat4 projectionMatrixInverse;
  float width;
  float height;
} cameraBuffer;

layout(set = 1, binding = 0) uniform ObjectTransformBuffer {
  mat4 modelMatrix;
} objectTransformBuffer;

layout(set = 1, binding = 1) uniform ObjectDataBuffer {
  uvec4 segmentation;
  float transparency;
  int shadeFlat;
} objectDataBuffer;

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 uv;
layout(location = 3) in vec3 tangent;
layout(location = 4) in vec3 bitangent;

layout(location = 0) out vec3 seenAt;
layout(location = 1) out flat uint entity;

void main() {
  vec4 seen = cameraBuffer.viewMatrix * objectTransformBuffer.modelMatrix * vec4(position, 1);
  seenAt = seen.xyz;
  entity = objectDataBuffer.segmentation[1];
  gl_Position = cameraBuffer.projectionMatrix * seen;
}
"""

# SAPIEN wants every pack to know the lights of a scene.
FRAGMENT = """#version 450
struct PointLight { vec4 position; vec4 emission; };
struct DirectionalLight { vec4 direction; vec4 emission; };
struct SpotLight { vec4 position; vec4 direction; vec4 emission; };

layout(set = 2, binding = 0) uniform SceneBuffer {
  vec4 ambientLight;
  DirectionalLight directionalLights[3];
  SpotLight spotLights[10];
  PointLight pointLights[10];
  SpotLight texturedLights[1];
} sceneBuffer;

layout(location = 0) in vec3 seenAt;
layout(location = 1) in flat uint entity;

layout(location = 0) out ivec4 outPositionSegmentation;

void main() {
  outPositionSegmentation = ivec4(ivec3(seenAt * 1000), entity);
}
"""


def depth_shaders() -> ShaderConfig:
    """ManiSkill's config of these shaders. SAPIEN has one picture format per process, and each camera takes the one
    that is set when it is made: ask for the config just before."""
    sapien.render.set_picture_format(PICTURE, FORMAT)
    minimal = PREBUILT_SHADER_CONFIGS["minimal"]
    digest = hashlib.sha256(f"{VERTEX}\0{FRAGMENT}".encode()).hexdigest()[:16]
    folder = keep(cache_folder() / f"shaders-{digest}", {"gbuffer.vert": VERTEX, "gbuffer.frag": FRAGMENT})
    return ShaderConfig(
        shader_pack=str(folder),
        texture_names={PICTURE: minimal.texture_names[PICTURE]},
        texture_transforms={PICTURE: minimal.texture_transforms[PICTURE]},
    )
