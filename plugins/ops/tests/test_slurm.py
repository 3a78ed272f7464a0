"""Jobs that a killed workflow left in SLURM's queue, with a queue that is a file."""

from pathlib import Path

import pytest

from roomkin.plugins.ops import guard as slurm

RUN = "8c6d3c6e-2f53-4a44-9f0a-0d5a9d5f5d11"
SQUEUE = "#!/bin/sh\ncat queue\n"
SCANCEL = '#!/bin/sh\necho "$@" >> cancelled\n: > queue\n'


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A workflow's folder and a SLURM of two shell scripts."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", f"{tmp_path}:/usr/bin:/bin")
    for name, text in (("squeue", SQUEUE), ("scancel", SCANCEL)):
        (tmp_path / name).write_text(text)
        (tmp_path / name).chmod(0o755)
    (tmp_path / slurm.LOGS).mkdir(parents=True)
    return tmp_path


def test_jobs_of_this_folder_are_cancelled_and_no_others(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    jobs = [("1", RUN, folder), ("2_[1-3]", f"mine_{RUN}", folder), ("3", RUN, "/elsewhere"), ("4", "my job", folder)]
    (folder / "queue").write_text("".join("|".join(map(str, job)) + "\n" for job in jobs))
    slurm.cancel_left_over(folder)
    assert (folder / "cancelled").read_text() == "1 2_[1-3]\n"
    assert "cancelling SLURM jobs that a killed run left here: 1 2_[1-3]" in capsys.readouterr().err


def test_jobs_that_do_not_end_are_told(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(slurm, "PATIENCE", 0.0)
    (folder / "scancel").write_text("#!/bin/sh\n")
    (folder / "queue").write_text(f"7|{RUN}|{folder}\n")
    slurm.cancel_left_over(folder)
    assert "SLURM jobs 7 do not end" in capsys.readouterr().err


def test_slurm_is_not_asked_where_it_was_never_used(folder: Path) -> None:
    (folder / slurm.LOGS).rmdir()
    (folder / "queue").write_text(f"7|{RUN}|{folder}\n")
    slurm.cancel_left_over(folder)
    assert not (folder / "cancelled").exists()
