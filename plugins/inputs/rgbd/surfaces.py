"""Which labels mean floor, wall or nothing to place, in the words of data sets and of several languages.

Of ADE20K ("floor, flooring"), COCO's stuff ("wall-brick", "floor-other-merged"), NYU and ScanNet; and as people write
("left wall", "wall behind the sofa"). A `floor lamp`, a `wall cabinet` and a `rug` are things.
"""

import re
import unicodedata
from typing import Literal

Surface = Literal["floor", "wall", "nothing", ""]  # "": a thing

# Everyday words, written by hand, small. What is a thing elsewhere (床: floor or bed; Decke: ceiling or blanket) is
# left out: `doubt_surfaces` sees by its shape what no word tells.
FLOOR = """floor flooring floorboard floorboards ground carpet carpeting parquet linoleum laminate pavement
boden fußboden parkett sol plancher carrelage suelo piso pavimento chao soalho vloer gulv golv lattia podłoga podlaha
podea padlo zemin doseme lantai pod пол підлога падлога под πατωμα δαπεδο أرضية רצפה फर्श พื้น
地板 地面 地砖 地磚 床面 フロア 바닥"""
WALL = """wall wallpaper
wand wande mauer mur cloison pared muro parete pareti parede muri muur vagg væg vegg seina sciana stena zed perete fal
duvar dinding tembok tuong siena zid стена стіна сцяна τοιχος
جدار حائط קיר دیوار दीवार ผนัง กำแพง 墙 墙壁 墙面 墙体 牆 牆壁 牆面 壁 壁面 벽 벽면"""
NOTHING = """background ceiling unknown unlabeled unlabelled void sky
zimmerdecke hintergrund plafond techo soffitto teto sufit strop katto tavan потолок стеля 天井 天花板 背景 천장"""
# Behind the word: COCO's kinds of stuff, sides and numbers.
KINDS = """other merged stuff brick concrete marble panel panels plastic stone tile tiles tiled wood wooden
left right back front rear side north south east west main"""
BEFORE = """of with in behind at on by under near beside above next von aus mit hinter im de del della des du di
da do das avec en con van met"""  # what follows is another thing

Words = frozenset[str]


def _plain(text: str) -> str:
    """In small letters, without accents, in one Unicode form."""
    letters = unicodedata.normalize("NFKD", unicodedata.normalize("NFKC", text).casefold())
    return unicodedata.normalize("NFC", "".join(one for one in letters if not 0x300 <= ord(one) < 0x370))


def _words(text: str) -> Words:
    return frozenset(_plain(text).split())


SURFACES: dict[Surface, Words] = {"floor": _words(FLOOR), "wall": _words(WALL), "nothing": _words(NOTHING)}
_KINDS, _BEFORE = _words(KINDS), _words(BEFORE)
_ENGLISH = _words(" ".join(words.splitlines()[0] for words in (FLOOR, WALL, NOTHING)))


def surface_of(label: str) -> Surface:
    """What surface a label means, by the first of its synonyms; "": it means a thing."""
    first = re.split(r"[,;/|(:]", _plain(label))[0]
    words = [word for word in re.split(r"[\s\d_.'-]+", first) if word]
    if not words:
        return "" if label.strip("_ ") else "nothing"
    cut = next((k for k, word in enumerate(words) if k and word in _BEFORE), len(words))
    words = words[:cut]
    while len(words) > 1 and words[-1] in _KINDS:
        words.pop()
    for surface, known in SURFACES.items():
        heads = {words[-1], words[-1].removesuffix("s"), *({words[0]} - _ENGLISH)}  # "mur blanc", but "wall cabinet"
        if heads & known:
            return surface
    return ""
