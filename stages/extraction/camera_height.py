"""Whether a camera is as high over the floor as people hold one."""

from stages.contracts.doubt import DoubtKind

LOWEST, HIGHEST = DoubtKind.CAMERA_HEIGHT.bounds
# What makes a camera seem higher, or lower, than it is, and by what its height is to be multiplied then.
TOO_HIGH = {"depth in feet": 0.3048, "intrinsics of half the picture's size": 0.5, "depth in decimetres": 0.1}
TOO_LOW = {"depth in centimetres, taken for millimetres": 10.0, "intrinsics of twice the picture's size": 2.0}


def doubt_height(height: float) -> str:
    """A warning about a camera's height over the floor, metres, and which mistakes make such a height; empty: none.

    Depth of 8 bits has steps of no known size: it is named wherever the camera is too low.
    """
    if LOWEST <= height <= HIGHEST:
        return ""
    causes = TOO_HIGH if height > HIGHEST else TOO_LOW
    found = [f"{name} ({height * by:.2f} m)" for name, by in causes.items() if LOWEST <= height * by <= HIGHEST]
    found += ["depth of 8 bits, whose steps are no millimetres"] if height < LOWEST else []
    why = f" if it is not, these would make it so: {', '.join(found)}" if found else ""
    return f"the camera is {height:.2f} m above the floor: is that so?{why}"
