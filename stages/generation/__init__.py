"""Stage `generation`: simulated scenes made of digital cousins (paper 2.1, A.3, A.7).

A line of steps over placed things, each saying what it changed: turn (`turning`), size (`sizing`), mount (`mounting`)
and choose, each cousin by itself; then carry (`stacking`), separate (`collisions`), doubt (`doubts`), settle
(`settling`).
"""
