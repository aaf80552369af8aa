"""The door for files: what is none, what is packed, what is damaged, what is a bomb."""

import bz2
import gzip
import lzma
import os
import tarfile
import zipfile
from pathlib import Path

import pytest

from mcsim.errors import InputError
from mcsim.files import open_bytes, open_lines, read_text, readable

TEXT = b"t [s],gx [rad/s]\n" + b"0.01,1\n" * 1000
PACKERS = [(".gz", gzip.compress), (".xz", lzma.compress), (".bz2", bz2.compress)]


def content(path):
    with open_bytes(Path(path)) as file:
        return file.read()


def refusal(path):
    with pytest.raises(InputError) as error:
        content(path)
    assert "\n" not in str(error.value)
    return str(error.value)


def test_what_is_no_regular_file_is_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "loop").symlink_to("loop")
    assert "is a pipe" in refusal(tmp_path / "pipe")
    assert "is a directory" in refusal(tmp_path)
    assert "is a device" in refusal("/dev/zero")
    assert "no such file" in refusal(tmp_path / "none")
    assert "symbolic links" in refusal(tmp_path / "loop")
    assert "cannot be read" in refusal("a" * 300)
    assert "cannot be read" in refusal("a\0b")
    with pytest.raises(InputError, match="is a pipe"):
        read_text(tmp_path / "pipe", 1000, "scenario file")


@pytest.mark.parametrize(("ending", "pack"), PACKERS)
def test_packed_files_are_known_by_their_content(tmp_path, ending, pack):
    packed = pack(TEXT)
    for name in (f"log.csv{ending}", "log.csv"):
        (tmp_path / name).write_bytes(packed)
        assert content(tmp_path / name) == TEXT
    named = tmp_path / f"other.csv{ending}"
    named.write_bytes(packed[: len(packed) // 2])
    assert "Compressed file ended" in refusal(named)
    named.write_bytes(packed[:30] + b"damage" + packed[36:])
    assert "cannot be read" in refusal(named)
    named.write_bytes(b"plain text")
    assert "name it other.csv" in refusal(named)


@pytest.mark.slow
@pytest.mark.parametrize(("ending", "pack"), PACKERS[:2])
def test_bombs_are_refused_before_they_are_unpacked(tmp_path, ending, pack):
    bomb = tmp_path / f"bomb.csv{ending}"
    bomb.write_bytes(pack(b"0,0\n" * (20 << 20)))
    read = []
    with pytest.raises(InputError, match="more than 100 times its size"):
        read_blocks(bomb, read)
    # Control: what is read before the refusal is 64 MiB of 80.
    assert 0 < sum(read) <= 64 << 20


def read_blocks(path, read):
    with open_bytes(path) as file:
        while block := file.read(1 << 16):
            read.append(len(block))


def test_archives_and_foreign_formats_are_named(tmp_path):
    (tmp_path / "a.csv").write_bytes(TEXT)
    with tarfile.open(tmp_path / "a.tar.gz", "w:gz") as archive:
        archive.add(tmp_path / "a.csv")
    with zipfile.ZipFile(tmp_path / "a.zip", "w") as archive:
        archive.write(tmp_path / "a.csv")
    assert "a tar archive; unpack it" in refusal(tmp_path / "a.tar.gz")
    assert "zip archive" in refusal(tmp_path / "a.zip")
    (tmp_path / "a.xlsx").write_bytes((tmp_path / "a.zip").read_bytes())
    assert "save its table as CSV" in refusal(tmp_path / "a.xlsx")
    (tmp_path / "b.csv").write_bytes(b"PAR1" + bytes(99))
    assert "Parquet" in refusal(tmp_path / "b.csv")


def test_sizes_are_judged_before_reading(tmp_path):
    with (tmp_path / "sparse.csv").open("wb") as file:
        file.truncate(3 << 30)
    assert "larger than 2 GiB" in refusal(tmp_path / "sparse.csv")
    with pytest.raises(InputError, match="larger than 1 KiB; not a scenario file"):
        read_text(tmp_path / "sparse.csv", 1 << 10, "scenario file")


@pytest.mark.parametrize(
    ("encoding", "name"),
    [("utf-8", "utf-8"), ("utf-8-sig", "utf-8"), ("utf-16", "utf-16-le"),
     ("utf-16-be", "utf-16-be"), ("utf-32", "utf-32-le"),
     ("latin-1", "cp1252"), ("cp1252", "cp1252")],
)  # fmt: skip
def test_encodings_are_known(tmp_path, encoding, name):
    text = "time [s],yaw rate [°/s]\r\n0,1\r\n" * 20
    (tmp_path / "a.csv").write_bytes(text.encode(encoding))
    with open_lines(tmp_path / "a.csv") as (file, found):
        assert file.read() == text.replace("\r\n", "\n")
    assert found == name


def test_whatever_a_reader_raises_ends_in_one_sentence(tmp_path):
    path = tmp_path / "a.bag"
    for error in (KeyError("x"), RecursionError(), MemoryError(), EOFError("two\nlines")):
        with pytest.raises(InputError, match=r"a\.bag: cannot be read") as caught, readable(path):
            raise error
        assert "\n" not in str(caught.value)
    with pytest.raises(InputError, match="mine"), readable(path):
        raise InputError("mine")
