"""What `roomkin.plugins.ops.doctor` says of a machine that lacks something."""

from pathlib import Path

import pytest

from roomkin.plugins.ops import doctor


@pytest.mark.parametrize(
    ("check", "probe", "script"),
    [
        (doctor.check_vulkan, "VULKAN_PROBE", "envs/vulkan.sh"),
        (doctor.check_open3d, "OPEN3D_PROBE", "envs/open3d.sh"),
    ],
)
def test_what_is_missing_is_named_with_the_command_that_mends_it(
    check: doctor.Mendable, probe: str, script: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(doctor, probe, "raise OSError('libGL.so.1: cannot open shared object file')")
    outcome = check()
    assert not outcome.good and outcome.needed and outcome.found
    assert outcome.fix.endswith(f"bash {doctor.ROOT / script}")
    assert (doctor.ROOT / script).is_file() and doctor.MENDS[check][1] == script.removeprefix("envs/")


def test_weights_for_pictures_are_named_with_their_size(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (outcome,) = (one for one in doctor.check_weights() if one.name == "networks")
    assert not outcome.good and not outcome.needed and "detector, segmenter, depth_anything" in outcome.found
    assert "roomkin perception fetch --networks" in outcome.found
    for name in ("grounding_dino", "sam2", "depth_anything_v2"):
        (tmp_path / "weights" / name).mkdir(parents=True)
        with (tmp_path / "weights" / name / "model.safetensors").open("wb") as file:
            file.truncate(900_000_000)  # sparse
    (outcome,) = (one for one in doctor.check_weights() if one.name == "networks")
    assert outcome.good and "segmenter 0.9 GB" in outcome.found and "fetch" not in outcome.found


def test_the_files_of_weights_that_lack_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("roomkin.stages.config.weights.is_there", lambda *_: False)
    (outcome,) = (one for one in doctor.check_weights() if one.name == "weights")
    assert not outcome.good and "mobile_sam.pt" in outcome.found and "roomkin perception fetch" in outcome.found
