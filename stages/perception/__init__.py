"""From a picture to an input folder: camera, ground and walls, outlines, names, boxes (paper 2.1, A.2 first half)."""
