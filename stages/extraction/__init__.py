"""Stage `extraction`: from an image to objects in the floor frame (paper 2.1, A.2, A.7).

A source gives image, depth, masks and captions as an `AnnotatedImage`; every step after that is the same wherever
they came from.
"""
