"""Motion planning: which motions of the hand the arm can follow without touching anything (paper A.4).

`clearance.py` makes paths of the hand and measures the room around the arm, `rollout.py` tries candidates out through
the IK that executes actions, `articulation.py` has ways to hold a handle and plans to move its joint.
"""
