"""What a model tells of its file's axes."""

from pathlib import Path

from plugins.importing.evidence import collect_evidence
from plugins.importing.tests.test_fronts import box, joint
from stages.articulated.urdf_reader import read_urdf


def test_buttons_say_nothing_of_what_is_up(tmp_path: Path) -> None:
    """A drawer that slides along y, so z is up; three wide pads that lift a little, and a knob."""
    parts = {"drawer": box("0.5 0.4 0.2"), **{f"button_{n}": box("0.18 0.3 0.02") for n in range(3)}}
    text = f'<link name="body">{box("0.6 0.5 0.8")}</link><link name="knob">{box("0.03 0.03 0.03")}</link>'
    text += "".join(f'<link name="{name}">{part}</link>' for name, part in parts.items())
    text += joint("slide", "prismatic", "drawer", "0 1 0", 0.3, "0 0.1 0")
    text += "".join(
        joint(f"press_{n}", "prismatic", f"button_{n}", "0 0 1", 0.004, f"{0.2 * n - 0.2} 0 0.4") for n in range(3)
    )
    text += joint("turn", "revolute", "knob", "0 1 0", 0.05, "0 0.25 0.3")
    (tmp_path / "a.urdf").write_text(f'<robot name="r">{text}</robot>')
    told = collect_evidence(read_urdf(tmp_path / "a.urdf", tmp_path))
    assert len(told.slides) == 1 and not told.hinges and told.find_up("chest_of_drawers").axis == "+z"
