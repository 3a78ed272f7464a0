"""Stage `matching`: nearest categories, models and orientations of every object (paper A.6, A.7, B.1)."""
