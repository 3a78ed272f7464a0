"""Finds the points of a handle in a cloud, without labels: those that lie before the plane of the front.

Not in the paper: a policy whose cloud flags the handle goes by it, others go by the borders of the front
(docs/policies.md). Torch alone is imported: an exported policy carries this file.

Clouds (B, P, 4) are x, y, z in metres in the robot base frame and a flag: 0 scene, 1 finger, -1 handle (flagged here).
"""

import torch
from torch import Tensor

# Chosen; what they find is counted in docs/results/policies.md.
ANCHORS = 16  # points, spread over the cloud, whose pairs are the hypotheses of the front's plane
ON_PLANE = 0.006  # metres: a point this near to the plane lies in it
BEFORE_PLANE = 0.008  # metres: a point this far before the plane is of the handle
THIN = 0.02  # metres: largest deviation of a handle's points along their thinnest axis
CHUNK = 128  # clouds at once, for memory
UNIT = 0.1  # metres that count as 1 in `offsets_to_handle`


def segment_handles(clouds: Tensor) -> tuple[Tensor, Tensor]:
    """The clouds with flag -1 on the handle's points, and the front's upright planes.

    A plane (B, 3) is its unit normal (x, y), which points to the robot, and offset: n_x x + n_y y = offset. Zeros: a
    cloud without a front. Of the upright planes through two of `ANCHORS` points the one with most points within
    `ON_PLANE` is refined by least squares. The points before it must be thin one way, or it is not that of the front.
    """
    parts = [_segment(part) for part in clouds.split(CHUNK)]
    return torch.cat([cloud for cloud, _ in parts]), torch.cat([plane for _, plane in parts])


def _segment(clouds: Tensor) -> tuple[Tensor, Tensor]:
    xyz, scene = clouds[..., :3].float(), clouds[..., 3] == 0
    planes = find_front_planes(xyz[..., :2], scene)
    handle = scene & (_measure_before(xyz[..., :2], planes) > BEFORE_PLANE) & planes.any(-1, keepdim=True)
    weight = handle.float()[..., None]
    count = weight.sum(1).clamp_min(1)
    middle = (xyz * weight).sum(1) / count
    centerd = (xyz - middle[:, None]) * weight
    spread = torch.linalg.eigvalsh(centerd.mT @ centerd / count[..., None])[:, 0]
    handle &= (spread < THIN**2)[:, None]
    flags = torch.where(handle, -1.0, clouds[..., 3])
    return torch.cat([clouds[..., :3], flags[..., None].to(clouds.dtype)], dim=-1), planes


def find_front_planes(xy: Tensor, scene: Tensor) -> Tensor:
    """Planes (B, 3) as of `segment_handles`: lines from above through points (B, P, 2) where `scene` holds."""
    order = scene.int().argsort(dim=1, descending=True, stable=True)
    count = scene.sum(1)
    steps = torch.linspace(0, 1, ANCHORS, device=xy.device)
    picked = order.gather(1, (steps * (count - 1).clamp_min(0)[:, None]).long())
    anchors = xy.gather(1, picked[..., None].expand(-1, -1, 2))
    first, second = torch.triu_indices(ANCHORS, ANCHORS, 1, device=xy.device)
    along = anchors[:, second] - anchors[:, first]
    normals = torch.stack([-along[..., 1], along[..., 0]], dim=-1)
    lengths = normals.norm(dim=-1, keepdim=True)
    normals = normals / lengths.clamp_min(1e-6)
    offsets = (normals * anchors[:, first]).sum(-1)
    inside = ((xy @ normals.mT - offsets[:, None]).abs() < ON_PLANE) & scene[..., None] & (lengths.mT > ON_PLANE)
    best = inside.sum(1).argmax(1)
    rows = torch.arange(len(xy), device=xy.device)
    planes = torch.cat([normals[rows, best], offsets[rows, best, None]], dim=1)
    for _ in range(2):  # refined, a plane has better inliers, which give a better plane
        weight = ((_measure_before(xy, planes).abs() < ON_PLANE) & scene).float()[..., None]
        total = weight.sum(1).clamp_min(1)
        middle = (xy * weight).sum(1) / total
        x, y = ((xy - middle[:, None]) * weight).unbind(-1)
        angle = 0.5 * torch.atan2(2 * (x * y).sum(1), (x * x - y * y).sum(1))
        normal = torch.stack([-angle.sin(), angle.cos()], dim=1)
        planes = torch.cat([normal, (normal * middle).sum(1, keepdim=True)], dim=1)
    planes = torch.where(planes[:, 2:] > 0, -planes, planes)  # the robot, at the origin, is before it
    return planes * (count > 2)[:, None]


def _measure_before(xy: Tensor, planes: Tensor) -> Tensor:
    """Distances (B, P) of points (B, P, 2) before planes (B, 3), metres."""
    return (xy * planes[:, None, :2]).sum(-1) - planes[:, None, 2]


def find_handle_middles(clouds: Tensor) -> Tensor:
    """Middle (x, y, z) of the box of the flagged points, and how many they are; clouds (..., P, 4) give (..., 4)."""
    xyz, marked = clouds[..., :3], clouds[..., 3:] == -1
    low, high = (torch.where(marked, xyz, sign * torch.inf) for sign in (1, -1))
    middle = torch.where(marked.any(-2), (low.amin(-2) + high.amax(-2)) / 2, 0.0)
    return torch.cat([middle, marked.sum(-2).to(xyz.dtype)], dim=-1)


def offsets_to_handle(seen: Tensor, hand: Tensor) -> Tensor:
    """From the hand (..., T, 3) to the handle at every step, in tenths of metres, and 1; zeros where none was seen yet.

    `seen` (..., T, 4) as of `find_handle_middles`. The fingers hide a small handle when they come near, so at each step
    it is where most of its points were seen up to now.
    """
    steps = torch.arange(seen.shape[-2], device=seen.device)
    best = (seen[..., 3] * len(steps) + steps).cummax(-1).indices  # of equals the latest
    then = seen.gather(-2, best[..., None].expand_as(seen))
    known = (then[..., 3:] > 0).to(seen.dtype)
    return torch.cat([(then[..., :3] - hand) / UNIT * known, known], dim=-1)
