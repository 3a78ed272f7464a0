"""Frames, cameras, boxes, planes and clouds in numpy; no simulator, no network.

Conventions of the whole project: metres, radians, quaternions wxyz, z up in the world and floor
frames, OpenCV camera frame (x right, y down, z forward), transforms named `target_from_source`
(4x4, acting on column vectors), points as rows of (N, 3) arrays.
"""
