"""The samples of docs/contracts.md are files that the checks take, of every kind."""

import json
import re
from pathlib import Path

from stages.contracts.__main__ import main as check
from stages.contracts.kinds import KINDS
from tests.packages import needs
from tests.unit.contract_files import FILES
from tests.unit.contract_samples import DOCS, HEADING, section


@needs("films", "in_scene")
def test_the_docs_show_the_files_that_the_tests_check(tmp_path: Path) -> None:
    text = DOCS.read_text(encoding="utf-8")
    assert HEADING + text.partition(HEADING)[2] == section(tmp_path), "python -m tests.unit.contract_samples"
    assert re.findall(r"^### (\w+)$", text.partition(HEADING)[2], re.MULTILINE) == list(FILES)
    assert set(FILES) == set(KINDS)
    for kind, name in FILES.items():
        assert check([kind, str(tmp_path / name)]) == 0


def test_a_sample_copied_from_the_docs_is_a_valid_file(tmp_path: Path) -> None:
    section(tmp_path)
    text = DOCS.read_text(encoding="utf-8").partition(HEADING)[2]
    copied = re.findall(r"^### (\w+)\n\n`[^`]+\.json`\n\n```json\n(.*?)```", text, re.MULTILINE | re.DOTALL)
    assert len(copied) > 12
    for kind, content in ((kind, content) for kind, content in copied if kind in FILES):
        path = tmp_path / FILES[kind]
        assert json.loads(path.read_text()) == json.loads(content)
        path.write_text(content)
        assert check([kind, str(path)]) == 0
