"""What a file was made of."""

import zipfile
from pathlib import Path

import numpy as np

from roomkin.stages.config.code import record_provenance
from roomkin.stages.config.generation import GenerationConfig

COMMAND = "roomkin.stages.generation.generate"


def test_each_of_what_a_file_is_made_of_changes_its_own_digest(tmp_path: Path) -> None:
    file = tmp_path / "a.json"
    file.write_text("{}")
    first = record_provenance(COMMAND, GenerationConfig(), [file], seed=3)
    assert first == record_provenance(COMMAND, GenerationConfig(), [file], seed=3) and first.seed == 3
    other = record_provenance(COMMAND, GenerationConfig(ranks=3), [file])
    assert other.options != first.options and (other.inputs, other.code) == (first.inputs, first.code)
    file.write_text("[]")
    assert record_provenance(COMMAND, GenerationConfig(), [file]).inputs != first.inputs
    assert record_provenance("roomkin.stages.matching.match", GenerationConfig(), [file]).code != first.code


def test_arrays_are_known_by_their_values_not_by_the_header_of_their_archive(tmp_path: Path) -> None:
    one, two = tmp_path / "1.npz", tmp_path / "2.npz"
    np.savez(one, depth=np.arange(5))
    with zipfile.ZipFile(one) as stored, zipfile.ZipFile(two, "w", zipfile.ZIP_DEFLATED) as packed:
        packed.writestr("depth.npy", stored.read("depth.npy"))
    assert one.read_bytes() != two.read_bytes()
    assert (
        record_provenance(COMMAND, GenerationConfig(), [one]).inputs
        == record_provenance(COMMAND, GenerationConfig(), [two]).inputs
    )
