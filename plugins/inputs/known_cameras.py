"""Cameras known by name: values of `camera` of an input and of `from-rgbd --camera`."""

FIELD_OF_VIEW = 5, 135  # degrees over a picture's width: least and largest that are believed

# Fields of view of color cameras in degrees, width and height, by their makers. Pictures that are narrower than the
# sensor are taken to be cut at the sides, wider ones above and below.
FIELDS_OF_VIEW = {
    "azure_kinect": (90.0, 74.3),
    "kinect_v1": (62.0, 48.6),
    "kinect_v2": (84.1, 53.8),
    "realsense_d415": (69.4, 42.5),
    "realsense_d435": (69.4, 42.5),
    "realsense_d455": (90.0, 65.0),
    "realsense_l515": (70.0, 43.0),
    "xtion": (58.0, 45.0),
}
