"""What `stages.doctor` says of a machine that lacks something."""

import pytest

from stages import doctor


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
    assert outcome.fix.endswith(f"bash {script}")
    assert (doctor.ROOT / script).is_file() and doctor.MENDS[check][1] == script.removeprefix("envs/")
