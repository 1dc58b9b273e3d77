"""Around the commands: full devices, terminals of few letters, and an end from outside."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import tvclin as tv
from tests.turns import usual
from tvclin import plots

FULL = Path("/dev/full")
SLOW = """
import os, sys, time
from tvclin.cli.app import main
os.fsync = lambda handle: (print("writing", flush=True), time.sleep(600))
sys.argv = ["tvclin", "init", sys.argv[1]]
main()
"""


def run(*arguments: str, **options) -> subprocess.CompletedProcess:
    return subprocess.run([sys.executable, "-m", "tvclin", *arguments], check=False, **options)


@pytest.mark.skipif(not FULL.exists(), reason="a device of Linux")
@pytest.mark.parametrize(
    "arguments",
    usual([["--help"], ["--version"], ["study", "--help"], ["poles", "configuration-i"]], 1, 3),
)
def test_a_full_device_is_one_sentence(arguments) -> None:
    with FULL.open("w") as full:
        done = run(*arguments, stdout=full, stderr=subprocess.PIPE, text=True)
    assert done.stderr == "Error: a file cannot be used: No space left on device\n"
    assert done.returncode == 2


@pytest.mark.thorough
def test_a_terminal_of_ascii_has_a_question_mark_for_what_it_lacks() -> None:
    environment = os.environ | {"PYTHONIOENCODING": "ascii"}
    done = run(
        "study", "configuration-i", "--more", env=environment, capture_output=True, text=True
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert "kg m?" in done.stdout


@pytest.mark.thorough
@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_a_command_that_is_told_to_end_leaves_nothing_half_written(tmp_path) -> None:
    file = tmp_path / "my.toml"
    with subprocess.Popen(
        [sys.executable, "-c", SLOW, str(file)], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as begun:
        assert begun.stdout.readline() == b"writing\n"
        assert len(list(tmp_path.iterdir())) == 1
        begun.send_signal(signal.SIGTERM)
        assert begun.wait(60) == 128 + signal.SIGTERM
        assert begun.stderr.read() == b""
    assert not list(tmp_path.iterdir())


@pytest.mark.thorough
@pytest.mark.parametrize("kind", usual(["png", "pdf", "svg"], 0))
def test_a_figure_on_a_full_disk_is_one_sentence(tmp_path, kind, monkeypatch) -> None:
    resource = pytest.importorskip("resource")
    # Else what is first imported here leaves its bytecode cut short.
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    plot = plots.boundary_chart([0.5, 1.0], (1.0,))
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
    try:
        with pytest.raises(tv.InputError, match=f"x.{kind} cannot be written: "):
            plots.save_figure(plot, tmp_path / f"x.{kind}")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert not list(tmp_path.iterdir())
