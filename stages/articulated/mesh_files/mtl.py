"""MTL, the materials of OBJ files: color with transparency, one picture and where it lies."""

import re
from dataclasses import dataclass, field

PLAIN = ("ka", "ks", "ns")  # which trimesh reads as they are
ARGUMENTS = {"-s": 3, "-o": 3, "-t": 3, "-mm": 2}  # of a picture's options, at most; one of all others
BLACK = 1e-3


@dataclass
class Material:
    """A material. color: linear. picture: a file's name. scale, offset: of its coordinates (u, v)."""

    name: str
    color: tuple[float, ...] | None = None
    opacity: float = 1.0
    picture: str = ""
    scale: tuple[float, float] = (1.0, 1.0)
    offset: tuple[float, float] = (0.0, 0.0)
    others: list[str] = field(default_factory=list)

    def text(self) -> str:
        """The material as trimesh reads it."""
        color = (1.0, 1.0, 1.0) if self.color is None and self.picture else self.color
        lines = [f"newmtl {self.name}", *self.others]
        if color is not None:
            alpha = () if self.opacity == 1.0 else (self.opacity,)
            lines.append(f"Kd {' '.join(f'{value:g}' for value in (*color, *alpha))}")
        if self.picture:
            lines.append(f"map_Kd {self.picture}")
        return "\n".join(lines) + "\n"


def materials_in(text: str, file: str) -> tuple[dict[str, Material], list[str]]:
    """The materials of a library by name, and what of it is not read or taken otherwise, a line each."""
    materials, lines, masks = dict[str, Material](), list[str](), list[str]()
    material = None
    for line in text.splitlines():
        key, rest = [*line.split(None, 1), "", ""][:2]
        key, rest = key.lower(), rest.strip()
        if key == "newmtl":
            material = materials[rest] = Material(rest)
        elif material is None:
            continue
        elif key in PLAIN:
            material.others.append(f"{key} {rest}")
        elif key == "kd":
            material.color = _color(rest)
        elif key in ("d", "tr"):
            share = _color(rest.removeprefix("-halo"))
            if share:
                material.opacity = share[0] if key == "d" else 1 - share[0]
        elif key == "map_kd":
            _read_picture(material, rest)
        elif key == "map_d":
            masks.append(material.name)
    for one in materials.values():
        if one.opacity <= 0:  # programs that mean the opposite: nobody draws what cannot be seen
            one.opacity = 1.0
        if one.picture and one.color is not None and max(one.color) < BLACK:
            one.color = None
            lines.append(f"{file}: '{one.name}' would paint its picture black: its color is not used")
    if masks:
        lines.append(f"{file}: pictures of transparency (map_d of {', '.join(masks[:3])}) are not read")
    return materials, lines


def _color(text: str) -> tuple[float, ...] | None:
    """The first numbers of a text, three at most; None: there are none, as of a spectral curve."""
    values = []
    for word in text.split()[:3]:
        try:
            values.append(min(max(float(word), 0.0), 1.0))
        except ValueError:
            break
    return tuple(values * 3 if len(values) == 1 else values) or None


def _read_picture(material: Material, text: str) -> None:
    """The picture's name behind its options; those that scale and move it."""
    words = text.split()
    while words and re.fullmatch(r"-[a-z]+", words[0]):
        option, words = words[0], words[1:]
        numbers = list[float]()
        for word in words[: ARGUMENTS.get(option, 1)]:
            try:
                numbers.append(float(word))
            except ValueError:
                break
        taken = len(numbers) if option in ARGUMENTS else 1
        words = words[taken:]
        if option in ("-s", "-o") and numbers:
            usual = 1.0 if option == "-s" else 0.0
            pair = (numbers[0], numbers[1] if len(numbers) > 1 else usual)
            material.scale, material.offset = (pair, material.offset) if option == "-s" else (material.scale, pair)
    material.picture = " ".join(words)
