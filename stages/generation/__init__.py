"""Stage `generation`: simulated scenes made of digital cousins (paper 2.1, A.3, A.7).

One function per step: yaw and extents of each asset from its view and its cloud (`pose`, `sizing`),
walls, supports and heights (`mounting`, `support`), pushes (`collisions`), and a physics check (`settling`).
"""
