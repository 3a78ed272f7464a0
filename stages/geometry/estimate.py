"""How the points of a surface lie, as a depth camera has them."""

TRIM = 0.005  # share of an exact cloud's points left out at either end of an extent; half of A.7's; chosen
BIN = 0.005  # metres: width of a bin of coordinates; chosen
SPREAD = 0.015  # metres by which points of a face spread without noise (panels, handles); chosen
REACH = 3.0  # standard deviations of noise: 99.7 % of the points of a face lie within
PROMINENT = 2.0  # times the mean density of points, from which on there is a face; chosen
