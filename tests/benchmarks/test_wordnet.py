"""The table of words that WordNet explains: how it is made, and that it fits the words that matching knows."""

from pathlib import Path

from benchmarks.wordnet import HEADS, explain, read_senses
from roomkin.stages.matching.text_encoders.lexical import KNOWN, MEANINGS, split_words

NOUNS = """\
  1 notice
00000001 06 n 01 chair 0 000 | a seat
00000002 06 n 02 rocker 0 rocking_chair 0 001 @ 00000001 n 0000 | it rocks
00000003 18 n 01 rocker 0 000 | a musician
00000004 06 n 01 rock_music 0 001 @ 00000003 n 0000 | not a thing
00000005 06 n 01 deck_chair 0 001 @ 00000001 n 0000 | its last word says it
"""
INDEX = """\
  1 notice
chair n 1 1 @ 1 0 00000001
deck_chair n 1 1 @ 1 0 00000005
rocker n 2 1 @ 2 0 00000003 00000002
rocking_chair n 1 1 @ 1 0 00000002
rock_music n 1 1 @ 1 0 00000004
"""


def test_words_are_explained_by_the_nearest_head_above_their_sense_as_a_thing(tmp_path: Path) -> None:
    (tmp_path / "data.noun").write_text(NOUNS)
    (tmp_path / "index.noun").write_text(INDEX)
    assert explain(*read_senses(tmp_path), {"chair": ["chair"]}) == {"chair": ["rocker"]}


def test_every_head_of_the_table_is_a_known_word_and_its_words_are_not() -> None:
    assert len(MEANINGS) > 500
    heads = {split_words(head)[-1] for head in MEANINGS.values()}
    assert heads <= KNOWN and not KNOWN & MEANINGS.keys()
    assert set(MEANINGS.values()) == HEADS.keys()
