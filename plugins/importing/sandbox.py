"""Files of others: in the user's folder alone, in a process of its own that stops nothing else; their names."""

import gc
import json
import multiprocessing
import re
import resource
import signal
import stat
import unicodedata
from collections.abc import Callable, Iterable
from itertools import chain, count
from multiprocessing.connection import Connection
from pathlib import Path

from roomkin.stages.contracts.arrays import MAX_BYTES
from roomkin.stages.contracts.categories import known_categories
from roomkin.stages.contracts.category import by_joined_name, split_words
from roomkin.stages.contracts.errors import InputError, explain, file_missing, plain_letters
from roomkin.stages.contracts.files import MAX_TEXT


def check_inside(path: Path, folder: Path) -> None:
    """Refuse what is no file of the user's folder, before anybody opens it.

    Raises:
        InputError: it is not there, leads out of the folder, or is a pipe, a device or the like.
    """
    try:
        outside, kind = not path.resolve().is_relative_to(folder.resolve()), path.stat().st_mode
    except FileNotFoundError:
        raise file_missing(path) from None
    except (OSError, RuntimeError, ValueError) as error:  # links in a circle, among others
        raise InputError(path, f"cannot be read ({explain(error)}).", code="E-FILE-UNREADABLE") from None
    if outside:
        raise InputError(path, f"is a link out of {folder.name}/.", "copy it inside", code="E-FILE-OUTSIDE")
    if not stat.S_ISREG(kind):  # nobody may ever write to a pipe, and a device has no end
        raise InputError(path, "is no file that can be read.", code="E-FILE-UNREADABLE")


def is_inside(path: Path, folder: Path) -> bool:
    """Whether it is a file of the user's folder, which may be opened."""
    try:
        check_inside(path, folder)
    except InputError:
        return False
    return True


def read_inside(path: Path, folder: Path, most: int = MAX_BYTES) -> bytes:
    """The bytes of a file of the user's folder.

    Raises:
        InputError: as `check_inside`, or it is larger than `most` bytes, or cannot be read.
    """
    check_inside(path, folder)
    try:
        if path.stat().st_size > most:
            raise InputError(path, f"is larger than {most / 1e6:g} MB.", code="E-FILE-LARGE")
        return path.read_bytes()
    except OSError as error:
        raise InputError(path, f"cannot be read ({explain(error)}).", code="E-FILE-UNREADABLE") from None


def read_text_inside(path: Path, folder: Path) -> bytes:
    """What is in a file of text of the user's folder; nothing if it cannot be read: the import reports it."""
    try:
        return read_inside(path, folder, MAX_TEXT)
    except InputError:
        return b""


FORK = multiprocessing.get_context("fork")
SECONDS = 150  # of CPU time; a mesh of 1.3 million triangles takes 35
WAIT = 2 * SECONDS  # by the clock
MEGABYTES = 3000  # beyond what this process has
SIMPLER = "a file with fewer parts or triangles"


def run_in_fork(path: Path, work: Callable[[], str]) -> str:
    """What `work` returns about a model's file, done in a fork of this process.

    Raises:
        InputError: it raised one, took more than the limits, or crashed.
    """
    answer, ours = FORK.Pipe(duplex=False)
    child = FORK.Process(target=_work, args=(path, work, ours))
    child.start()
    ours.close()
    try:
        reply = answer.recv_bytes()
    except (EOFError, OSError):  # it ended without one
        reply = b""
    child.join()
    status = child.exitcode
    if status in (-signal.SIGXCPU, -signal.SIGALRM):
        seconds = SECONDS if status == -signal.SIGXCPU else WAIT
        raise InputError(path, f"takes more than {seconds} s to read.", SIMPLER, code="E-MODEL-TIME")
    if status != 0 or not reply:
        what = f"crashes what reads it, or takes more than {MEGABYTES} MB of memory ({_name(status)})."
        raise InputError(path, what, SIMPLER, code="E-MODEL-CRASH")
    error, text = json.loads(reply)
    if error is not None:
        where, what, fix, kind = error
        raise InputError(where, what, fix, code=kind)
    return str(text)


def _work(path: Path, work: Callable[[], str], ours: Connection) -> None:
    """The work of the child process.

    What its parent left to be collected stays: at its end some of it waits for threads that a fork does not have.
    """
    gc.freeze()
    _limit()
    try:
        reply = json.dumps([None, work()])
    except InputError as error:
        reply = _encode_error(error)
    except MemoryError:
        what = f"takes more than {MEGABYTES} MB of memory to read."
        reply = _encode_error(InputError(path, what, SIMPLER, code="E-MODEL-MEMORY"))
    ours.send_bytes(reply.encode())


def _encode_error(error: InputError) -> str:
    return json.dumps([(error.where, error.what, error.fix, error.code), ""])


def _limit() -> None:
    """Let this process take so much more time and memory; where the system does not tell what it has, only time."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    seconds = int(used.ru_utime + used.ru_stime) + SECONDS
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.setitimer(signal.ITIMER_REAL, WAIT)
    status = Path("/proc/self/status")
    if status.exists():
        held = next(int(line.split()[1]) for line in status.read_text().splitlines() if line.startswith("VmData"))
        limit = held * 1024 + MEGABYTES * 2**20
        resource.setrlimit(resource.RLIMIT_DATA, (limit, limit))


def _name(status: int | None) -> str:
    """How a process ended."""
    return signal.Signals(-status).name if status and status < 0 else f"exit status {status}"


COMMON = {  # words that say nothing of what a model is
    "asset", "base", "collision", "data", "description", "export", "glb", "main", "mesh", "meshes", "misc", "mjcf",
    "mobility", "model", "obj", "object", "other", "output", "result", "robot", "scene", "textured", "urdf", "visual",
    "xacro", "xml",
}  # fmt: skip

SOUNDS = str.maketrans(
    dict(
        zip(
            "абвгдезиклмнопрстуфхыэіґαβγδεζηικλμνοπρσςτυφω",
            "abvgdeziklmnoprstufhyeigavgdeziiklmnoprsstyfo",
            strict=True,
        )
    )
    | {"ж": "zh", "ц": "ts", "ч": "ch", "ш": "sh", "щ": "shch", "ъ": "", "ь": "", "ю": "yu", "я": "ya", "є": "ye"}
    | {"θ": "th", "ξ": "x", "χ": "ch", "ψ": "ps"}
)  # letters of Cyrillic and Greek


def is_common(name: str) -> bool:
    """Whether a name consists of words that any model could have (`assets`, `mesh_obj`)."""
    words = split_words(name)
    return bool(words) and all(word in COMMON or word.removesuffix("s") in COMMON for word in words)


def strip_name(name: str) -> str:
    """A name without leading numbers and trailing common words: `011_banana_mesh` is banana."""
    kept = re.sub(r"^[\W\d_]+", "", name)
    while (shorter := re.sub(r"[\W\d_]+[A-Za-z]+$", "", kept)) != kept and is_common(kept[len(shorter) :]):
        kept = shorter
    return kept or name


def name_model(path: Path, folder: Path, alone: bool) -> str:
    """The folder's name if the model is alone in it, else that of the file or of the nearest folder that tells."""
    above = [place.name for place in path.parents if place.is_relative_to(folder)]
    names = [*([folder.name] if alone else []), path.stem, *above, folder.parent.name]
    return next((name for name in names if not is_common(name)), folder.name)


def read_category(model: Path, folder: Path) -> str | None:
    """What meta.json in a model's folder says that it is, in the library's words; None: it does not."""
    try:
        category = json.loads(read_text_inside(model / "meta.json", folder)).get("model_cat")
    except (ValueError, AttributeError, RecursionError):
        return None
    if not isinstance(category, str) or not category.strip():
        return None
    known = by_joined_name(known_categories()).get(category.lower())
    return known.name if known else re.sub(r"(?<=[a-z])(?=[A-Z])", "_", category)


def snake_case(text: str) -> str:
    """Lower-case letters, digits and underscores; letters of other scripts as they sound, or by their number."""
    latin = "".join(map(_spell, plain_letters(text).translate(SOUNDS)))
    return re.sub(r"[^a-z0-9]+", "_", latin).strip("_") or "model"


def _spell(letter: str) -> str:
    """A letter of any script in Latin ones: か is ka, 椅 is u6905."""
    if letter.isascii() or unicodedata.category(letter)[0] not in "LMN":
        return letter
    name = unicodedata.name(letter, "")
    return f"u{ord(letter):x}" if "IDEOGRAPH" in name or not name else name.split()[-1].lower()


def number_names(names: Iterable[str], taken: Iterable[str]) -> list[str]:
    """The names, with _2, _3, ... after those that are there already."""
    used, result = set(taken), []
    for name in names:
        free = next(one for one in chain([name], (f"{name}_{number}" for number in count(2))) if one not in used)
        used.add(free)
        result.append(free)
    return result
