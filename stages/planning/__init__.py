"""Motion planning: which motions of the hand the arm can follow without touching anything (paper A.4).

`path.py` makes paths of the hand, `handle_grasp.py` ways to hold a handle, `rollout.py` tries candidates out through
the IK that executes actions, `clearance.py` measures the room around the arm, `articulation.py` plans to move a joint.
"""
