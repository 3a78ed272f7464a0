"""URDFs as other people write them: a small cabinet, and a kitchen cabinet with textures and package:// meshes."""

from pathlib import Path

import numpy as np
import trimesh
from PIL import Image

CABINET = """<robot name="cabinet">
  <material name="oak"><color rgba="0.5 0.3 0.1 1"/></material>
  <link name="body">
    <inertial><mass value="12"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
    <visual><origin xyz="0 0 0.4"/><geometry><box size="0.4 0.6 0.8"/></geometry><material name="oak"/></visual>
  </link>
  <link name="door">
    <visual><origin xyz="0.01 -0.29 0"/><geometry><box size="0.02 0.58 0.7"/></geometry></visual></link>
  <link name="door_knob"><visual><geometry><sphere radius="0.02"/></geometry></visual></link>
  <link name="tray"><visual><origin rpy="0 0 1.5707963"/><geometry><box size="0.2 0.1 0.05"/></geometry></visual></link>
  <joint name="hinge" type="revolute"><parent link="body"/><child link="door"/><origin xyz="0.2 0.3 0.4"/>
    <axis xyz="0 0 -1"/><limit lower="-1.5" upper="0" effort="1" velocity="1"/></joint>
  <joint name="knob" type="fixed"><parent link="door"/><child link="door_knob"/><origin xyz="0.03 -0.5 0"/></joint>
  <joint name="slide" type="prismatic"><parent link="body"/><child link="tray"/>
    <origin xyz="0 0 0.9" rpy="0 0 1.5707963"/><axis xyz="0 -1 0"/>
    <limit lower="0" upper="0.2" effort="1" velocity="1"/></joint>
</robot>"""


def write_cabinet(folder: Path, text: str = CABINET) -> Path:
    """The cabinet in a user's folder; returns the URDF."""
    path = folder / "bottom_cabinet" / "Oak 1" / "cab.urdf"
    path.parent.mkdir(parents=True)
    path.write_text(text)
    return path


def textured_box(extents: tuple[float, float, float], folder: Path, name: str) -> None:
    """A box as OBJ with a texture, `<name>.obj`, `<name>.mtl` and `<name>.png`."""
    mesh = trimesh.creation.box(extents)
    picture = Image.fromarray(np.full((4, 4, 3), (180, 90, 40), np.uint8))
    uv = np.random.default_rng(0).random((len(mesh.vertices), 2))
    mesh.visual = trimesh.visual.TextureVisuals(uv=uv, image=picture)
    folder.mkdir(parents=True, exist_ok=True)
    text, files = trimesh.exchange.obj.export_obj(mesh, return_texture=True, mtl_name=f"{name}.mtl")
    (folder / f"{name}.obj").write_text(text)
    for file, content in files.items():
        (folder / file).write_bytes(content)


def write_kitchen(root: Path) -> Path:
    """A package as a robotics course ships it: kitchen/urdf/kitchen.urdf, meshes by package:// beside it.

    Two doors whose handles are links of their own, hinged left and right, and two drawers that slide along -x of a
    frame turned by half a turn.
    """
    meshes = root / "kitchen" / "meshes"
    textured_box((0.6, 0.76, 0.78), meshes, "body")
    textured_box((0.02, 0.36, 0.5), meshes, "door")
    textured_box((0.02, 0.36, 0.2), meshes, "drawer")

    def link(name: str, mesh: str, xyz: str) -> str:
        geometry = f'<geometry><mesh filename="package://kitchen/meshes/{mesh}.obj"/></geometry>'
        shapes = "".join(f'<{tag}><origin xyz="{xyz}"/>{geometry}</{tag}>' for tag in ("visual", "collision"))
        return f'<link name="{name}">{shapes}</link>'

    bar = '<visual><geometry><cylinder radius="0.006" length="0.12"/></geometry></visual>'
    text = [link("body", "body", "0 0 0.39")]
    for side, y in (("left", 1), ("right", -1)):
        text += [link(f"door_{side}", "door", f"0.01 {-0.18 * y} 0"), f'<link name="door_{side}_handle">{bar}</link>']
        text += [link(f"drawer_{side}", "drawer", "-0.01 0 0"), f'<link name="drawer_{side}_nob">{bar}</link>']
        limits = 'lower="0" upper="1.57"' if y < 0 else 'lower="-1.57" upper="0"'
        text.append(
            f'<joint name="door_{side}_joint" type="revolute"><parent link="body"/><child link="door_{side}"/>'
            f'<origin xyz="0.3 {0.37 * y} 0.26"/><axis xyz="0 0 -1"/><limit {limits} effort="1" velocity="1"/></joint>'
            f'<joint name="door_{side}_bolt" type="fixed"><parent link="door_{side}"/>'
            f'<child link="door_{side}_handle"/><origin xyz="0.05 {-0.3 * y} 0.1"/></joint>'
            f'<joint name="drawer_{side}_joint" type="prismatic"><parent link="body"/><child link="drawer_{side}"/>'
            f'<origin xyz="0.3 {0.19 * y} 0.64" rpy="0 0 3.14159265"/><axis xyz="-1 0 0"/>'
            '<limit lower="0" upper="0.4" effort="1" velocity="1"/></joint>'
            f'<joint name="drawer_{side}_bolt" type="fixed"><parent link="drawer_{side}"/>'
            f'<child link="drawer_{side}_nob"/><origin xyz="-0.05 0 0"/></joint>'
        )
    urdf = root / "kitchen" / "urdf" / "kitchen.urdf"
    urdf.parent.mkdir(parents=True)
    urdf.write_text(f'<robot name="kitchen">{"".join(text)}</robot>')
    return urdf
