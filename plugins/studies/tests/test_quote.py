"""README and guides quote the figures of docs/results as they are."""

import shutil
from pathlib import Path

import pytest

from roomkin.plugins.studies.quote import FORMS, quote, read_row, run
from tests.refusals import refused

ROOT = Path(__file__).resolve().parents[3]
PAGE = "a\n\n| row | x (cm) | y |\n|---|---|---|\n"
PAGE += "| one | 4.5 ± 3<br>[3.7, 5.3] | 57/63 |\n| two | 50 [33, 66] | 35 % [1, 2] |\n"


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    shutil.copy(ROOT / "README.md", tmp_path)
    shutil.copytree(ROOT / "docs", tmp_path / "docs", ignore=shutil.ignore_patterns("*.webp", "*.xz"))
    return tmp_path


def test_pages_quote_what_the_results_say(copy: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run(root=copy)
    assert capsys.readouterr().out == "", "run `roomkin studies quote`"


def test_a_result_that_changes_is_quoted_anew(copy: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = (copy / "README.md").read_text()
    result = copy / "docs/results/table2.md"
    changed = result.read_text().replace("| 63/63 | 57/63 | 4.5 ±", "| 62/63 | 58/63 | 3.9 ±")
    result.write_text(changed)
    run(root=copy)
    after = (copy / "README.md").read_text()
    assert after != before and "| 62 of 63 | 3.9 cm off" in after and "| 58 of 63 (" in after
    assert (
        capsys.readouterr().out
        == "README.md: from docs/results/table2.md\ndocs/reproduce.md: from docs/results/table2.md\n"
    )
    (copy / "README.md").write_text(after.replace("cm off", "cm away"))
    with refused("E-QUOTE", "README.md from docs/results/table2.md", "0 times"):
        run(root=copy)


def test_cells_are_found_by_row_and_column() -> None:
    assert read_row(PAGE, "| two |")["x (cm)"] == "50 [33, 66]"
    with pytest.raises(ValueError, match="no row"):
        read_row(PAGE, "| three |")
    text = "it is {x (cm):count} cm {x (cm):range}, {y:of}."
    assert (
        quote("so it is 9 cm [1, 2], 3 of 4.", text, read_row(PAGE, "| one |"))
        == "so it is 4.5 cm [3.7, 5.3], 57 of 63."
    )


@pytest.mark.parametrize(
    ("form", "cell", "said"),
    [(None, "+24 points [12, 36]", "+24 points [12, 36]"), ("%", "50 [33, 66]", "50 % [33, 66]"),
     ("count", "36/63", "36"), ("rate", "35 % [23, 48]", "35 %")],
)  # fmt: skip
def test_forms(form: str | None, cell: str, said: str) -> None:
    assert FORMS[form](cell) == said
