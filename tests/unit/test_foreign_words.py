"""Categories by words of other languages."""

from collections import Counter

import pytest

from roomkin.stages.contracts.categories import WORDS, category_in, foreign_words, known_categories
from roomkin.stages.contracts.category import find_category
from roomkin.stages.contracts.errors import list_plain_words, plain_letters

CHAIRS = """Stuhl Stühle chaise chaises silla sillas sedia sedie cadeira cadeiras stoel stoelen stolar tuoli tuolit
krzesło krzesła židle scaun scaune szék székek stolica stolice sandalye kursi ghế стул стулья стілець крэсла
καρέκλα καρέκλες كرسي الكراسي כיסא כיסאות صندلی कुर्सी कुर्सियाँ เก้าอี้ 椅子 椅 いす 의자"""
TABLES = """Tisch Tische tavolo tavoli mesa mesas tafel pöytä pöydät stoły stůl masă mese asztal asztalok masa masalar
meja стол столы стіл столи маса τραπέζι طاولة שולחן میز मेज โต๊ะ 桌子 テーブル 테이블 식탁"""


@pytest.mark.parametrize(("category", "words"), [("chair", CHAIRS), ("table", TABLES)])
def test_everyday_words_of_thirty_languages(category: str, words: str) -> None:
    assert {word: category_in(word) for word in words.split()} == dict.fromkeys(words.split(), category)


@pytest.mark.parametrize(
    ("name", "category"),
    [
        ("Bürostuhl_02", "chair"),  # joined words, and numbers
        ("Küchenstühle", "chair"),
        ("SchreibTisch", "desk"),
        ("红色椅子", "chair"),
        ("식탁의자", "chair"),
        ("lampe_de_table", "table_lamp"),  # what follows is another thing
        ("table de chevet", "nightstand"),
        ("mesa de comedor", "table"),
        ("Tisch mit Stuhl", "table"),
        ("chaise en bois", "chair"),
        ("холодильник 2", "fridge"),
        ("buzdolabı", "fridge"),
        ("Schränke", "bottom_cabinet"),
        ("chair", "chair"),
        ("study_table", "table"),
        ("microlit", None),  # no joined word: it only ends like one
        ("stol", None),  # a chair in Swedish, a table in Croatian
        ("bord", None),
        ("Tisch Stuhl", None),  # two things
        ("vegetable", None),
        ("banana", None),
        ("", None),
        ("🪑", None),
    ],
)
def test_names_of_files_and_folders(name: str, category: str | None) -> None:
    assert category_in(name) == category


def test_no_word_means_two_things_or_an_english_one() -> None:
    lines = [line.split(":") for line in WORDS.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    meant = {(plain_letters(word).replace("_", ""), category) for category, words in lines for word in words.split()}
    assert [word for word, count in Counter(word for word, _ in meant).items() if count > 1] == []
    assert {category for _, category in meant} <= known_categories().keys()
    english = {word: find_category(word, known_categories(), like=True) for word in foreign_words() if word.isascii()}
    assert {word for word, found in english.items() if found and found.name != foreign_words()[word]} == set()


def test_plain_letters() -> None:
    assert [plain_letters(word) for word in ("Łóżka", "Größe", "væg", "Đèn", "ｶﾞﾗｽ", "कुर्सी")] == [
        "lozka", "grosse", "vaeg", "den", "ガラス", "कुर्सी",
    ]  # fmt: skip
    assert list_plain_words("BüroStuhl-2 (कुर्सी)") == ["buro", "stuhl", "कुर्सी"]
