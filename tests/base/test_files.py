"""Files: results are written to the path that is given, and what no real file holds is not read."""

import os
import subprocess
import sys
from pathlib import Path
from time import process_time

import pytest

import tvclin as tv
from tvclin.base.files import read_text, tables_of, write_text
from tvclin.vehicle.vehicle_file import template

POSIX = pytest.mark.skipif(os.name != "posix", reason="links, modes and pipes of POSIX")


@POSIX
def test_a_link_stays_a_link_and_what_it_leads_to_is_written(tmp_path):
    real = tmp_path / "elsewhere" / "real.csv"
    real.parent.mkdir()
    link, missing = tmp_path / "link.csv", tmp_path / "missing.csv"
    link.symlink_to(real)
    missing.symlink_to(Path("elsewhere") / "new.csv")
    real.write_text("old")
    write_text(link, "new")
    write_text(missing, "first")
    assert link.is_symlink()
    assert missing.is_symlink()
    assert (real.read_text(), (real.parent / "new.csv").read_text()) == ("new", "first")
    assert {file.name for file in real.parent.iterdir()} == {"real.csv", "new.csv"}


@POSIX
def test_a_link_to_itself_is_refused(tmp_path):
    one, other = tmp_path / "one", tmp_path / "other"
    one.symlink_to(other)
    other.symlink_to(one)
    with pytest.raises(tv.InputError, match="one is a link that leads back to itself"):
        write_text(one, "text")
    assert one.is_symlink()
    assert len(list(tmp_path.iterdir())) == 2


@POSIX
@pytest.mark.parametrize("mode", [0o600, 0o640, 0o755])
def test_a_file_keeps_its_mode(tmp_path, mode):
    file = tmp_path / "private.html"
    file.write_text("old")
    file.chmod(mode)
    write_text(file, "new")
    assert (file.read_text(), file.stat().st_mode & 0o7777) == ("new", mode)


@POSIX
def test_a_new_file_has_the_mode_that_the_user_gives_new_files(tmp_path):
    before = os.umask(0o027)
    try:
        write_text(tmp_path / "new", "text")
    finally:
        os.umask(before)
    assert (tmp_path / "new").stat().st_mode & 0o7777 == 0o640


def test_what_takes_the_place_of_a_file_is_on_the_disk_before(tmp_path, monkeypatch):
    file, seen = tmp_path / "manifest.json", []
    file.write_text("old")
    really = os.fsync

    def fsync(handle):
        seen.append((file.read_text(), os.fstat(handle).st_size))
        really(handle)

    monkeypatch.setattr(os, "fsync", fsync)
    write_text(file, "a whole new text")
    assert seen == [("old", 16)]


@POSIX
@pytest.mark.parametrize("kind", ["pipe", "device"])
def test_what_may_never_end_is_not_read(tmp_path, kind):
    file = tmp_path / "sounding.csv"
    os.mkfifo(file) if kind == "pipe" else file.symlink_to("/dev/zero")
    begun = process_time()
    for read in (tv.read_sounding, tv.load_vehicle, tv.load_study, tv.load_schedule):
        with pytest.raises(tv.InputError, match="is not an ordinary file"):
            read(file)
    assert process_time() - begun < 5.0


@POSIX
@pytest.mark.parametrize("piped", [True, False])
def test_standard_input_is_read(tmp_path, piped):
    file = tmp_path / "my.toml"
    file.write_text(template())
    code = "import tvclin as tv; print(tv.load_vehicle('/dev/stdin') == tv.load_vehicle(%r))"
    with file.open() as given:
        done = subprocess.run(
            [sys.executable, "-c", code % str(file)],
            capture_output=True,
            text=True,
            check=True,
            **({"input": template()} if piped else {"stdin": given}),
        )
    assert done.stdout == "True\n"


def test_a_text_of_more_than_100_mb_is_told_so(tmp_path):
    file = tmp_path / "large.csv"
    with file.open("wb") as made:
        made.truncate(100_000_001)
    with pytest.raises(tv.InputError, match=r"large\.csv has more than 100 MB; name a sounding"):
        read_text(file, "a sounding")


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_a_line_of_more_than_a_million_letters_is_told_so(tmp_path, end):
    file = tmp_path / "long.csv"
    some, most = "1,2,3" + end, "x" * 1_000_000
    file.write_text(400_000 * some + most + end + some, newline="")
    assert len(read_text(file, "a table")) > 3_000_000
    file.write_text(400_000 * some + most + "x" + end + some, newline="")
    line = 1 if end == "\r" else 400_001
    with pytest.raises(tv.InputError, match=rf"long\.csv, line {line}: it has more than 1000000"):
        read_text(file, "a table")


@pytest.mark.parametrize(
    "text",
    [
        "\n".join(f"[{'a.' * 2000}b{i}]" for i in range(900)),
        "a." * 400_000 + "b = 1",
        "x = {" + "a . " * 100_000 + "b = 1}",
        'x = {"a".' + '"a,=" . ' * 100_000 + "b = 1}",
    ],
    ids=["headers", "key", "inline", "quoted"],
)
def test_keys_of_thousands_of_dots_are_refused_at_once(text):
    begun = process_time()
    with pytest.raises(tv.InputError, match="is nested more than 8 levels deep"):
        tables_of(text, "my.toml")
    assert process_time() - begun < 20.0


def test_dots_of_numbers_comments_and_words_are_no_levels():
    text = "# " + "." * 300 + "\nx = [" + "0.5, " * 300 + ']\ny = "1.2.3.4.5.6.7.8.9.10"\n'
    assert tables_of(text, "my.toml") == {"x": [0.5] * 300, "y": "1.2.3.4.5.6.7.8.9.10"}


def test_tables_of_more_than_four_million_letters_are_told_so():
    with pytest.raises(tv.InputError, match=r"my\.toml has more than 4 million letters"):
        tables_of("x = 1 # y\n" * 400_001, "my.toml")
