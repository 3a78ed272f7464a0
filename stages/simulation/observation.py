"""What the policy sees (paper B.3): proprioception and one cloud of object and finger points, robot base frame.

Its cameras render positions and entities alone: SAPIEN's `minimal` shaders compute a lit color as well, which takes
three times as long on a CPU.
"""

import hashlib
from functools import cache

import numpy as np
import sapien
import trimesh
from mani_skill.render import PREBUILT_SHADER_CONFIGS, ShaderConfig
from numpy.typing import NDArray

from roomkin.stages.geometry.clouds import farthest_points
from roomkin.stages.geometry.frames import OPENGL, SAPIEN_FROM_OPENCV, quaternion_from_matrix
from roomkin.stages.simulation.kinematics import Array
from roomkin.stages.simulation.rendering import cache_folder, keep

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


Float = NDArray[np.float32]

OVERSAMPLED = 5  # times the points asked for: pixels kept before farthest point sampling, whose time grows with them
# Camera axes of SAPIEN's position image (x right, y up, z backward) in its camera pose (x forward, y left, z up).
CAMERA_FROM_IMAGE = SAPIEN_FROM_OPENCV @ OPENGL[:3, :3]
# (center, extents) of the finger's collision boxes that lie furthest out, in its own frame; y towards the other finger
FINGER_BOXES = (((0.0, 0.0076, 0.0453), (0.0175, 0.0152, 0.0185)), ((0.0, 0.0159, 0.0284), (0.0175, 0.007, 0.0235)))
FINGER_OFFSET = 0.0584 - 0.1034  # finger frame along the approach axis, seen from the tool center point


def object_points(
    image: NDArray[np.int16], shown: NDArray[np.int16], base_from_camera: Array, low: Array, high: Array
) -> Float:
    """Points (N, 3) of the shown pixels inside the workspace box, in the base frame.

    Args:
        image: (H, W, 4) SAPIEN `PositionSegmentation`: position in millimetres, then the entity id.
        shown: entity ids of what the cloud shows; everything else (robot, background) is masked out.
        base_from_camera: (4, 4) camera pose, x forward.
        low, high: (3,) corners of the workspace.
    """
    points = image[np.isin(image[..., 3], shown, kind="table")][:, :3].astype(np.float32) * 1e-3
    base_from_image = base_from_camera[:3, :3] @ CAMERA_FROM_IMAGE
    points = points @ base_from_image.T.astype(np.float32) + base_from_camera[:3, 3].astype(np.float32)
    return points[((points > low) & (points < high)).all(axis=1)]


def thin_points(points: Float, most: int) -> Float:
    """At most `most` of the points (N, 3), at an even stride, which keeps the density of the pictures."""
    if len(points) <= most:
        return points
    return points[np.linspace(0, len(points) - 1, most).astype(int)]


@cache
def finger_surface(count: int) -> tuple[Array, Array]:
    """Points on the left and right finger, in the frame of the tool center point with the gripper closed."""
    rng = np.random.default_rng(0)
    boxes = []
    for center, extents in FINGER_BOXES:
        box = trimesh.creation.box(extents)
        if center[1] > 0.01:  # the diagonal part leans outwards by 30 degrees
            box.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 6, [1, 0, 0]))
        boxes.append(box.apply_translation(center))
    mesh = trimesh.util.concatenate(boxes)
    surface, _ = trimesh.sample.sample_surface(mesh, count - count // 2, seed=rng)
    left = np.add(surface, (0.0, 0.0, FINGER_OFFSET))
    return left, (left * [1.0, -1.0, 1.0])[: count // 2]


def finger_points(tcp: Array, fingers: Array, count: int) -> Float:
    """(count, 3) precomputed finger points placed by forward kinematics; `tcp` (4, 4), `fingers` (2,) metres."""
    left, right = finger_surface(count)
    local = np.concatenate([np.add(left, (0.0, fingers[0], 0.0)), np.subtract(right, (0.0, fingers[1], 0.0))])
    return (local @ tcp[:3, :3].T + tcp[:3, 3]).astype(np.float32)


def unify_cloud(scene: Float, fingers: Float, points: int) -> Float:
    """(points, 4): farthest points of the union with flag 0, then all finger points with flag 1.

    Sampling sees scene and fingers as one cloud (paper B.3); as the share of the fingers is fixed, what it takes of the
    scene is then thinned evenly, by as many as it took too few of the fingers.
    """
    cloud = np.zeros((points, 4), np.float32)
    visible = points - len(fingers)
    scene = thin_points(scene, OVERSAMPLED * visible)
    if len(scene) > visible:
        union = np.zeros((len(fingers) + len(scene), 4), np.float32)
        union[: len(fingers), :3], union[: len(fingers), 3], union[len(fingers) :, :3] = fingers, 1.0, scene
        chosen = farthest_points(union, points)
        scene = thin_points(chosen[chosen[:, 3] == 0, :3], visible)
    cloud[:visible, :3] = farthest_points(scene, visible)
    cloud[visible:, :3] = fingers
    cloud[visible:, 3] = 1.0
    return cloud


def proprioception(tcp: Array, fingers: Array, rest: Array) -> Float:
    """(9,) end-effector position, quaternion wxyz, finger joints, in the base frame.

    Of the two quaternions of an orientation the one nearer to `rest` (4,) is taken, so that the value has no jumps
    within the workspace.
    """
    quaternion = quaternion_from_matrix(tcp[:3, :3])
    if quaternion @ rest < 0:
        quaternion = -quaternion
    return np.concatenate([tcp[:3, 3], quaternion, fingers]).astype(np.float32)
