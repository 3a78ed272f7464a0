"""Stage `extraction`: from an image to objects in the floor frame (paper 2.1, A.2, A.7).

A provider (`IMPLEMENTATIONS`) gives image, depth, masks and captions as an `AnnotatedImage`; every
step after that is the same wherever they came from.
"""

IMPLEMENTATIONS = {"simulator": "stages.extraction.simulator"}  # name -> module with `observe`
