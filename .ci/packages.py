"""Build the wheel and the sdist, install them into empty environments, and use what is there.

    python .ci/packages.py [environment ...]

The environments are `sdist`, `none` (no extra), each extra by its name, and `lowest`: exactly the
lowest versions that pyproject.toml allows, in which a part of the tests is run as well. A feature
whose extra is not there must say so in one sentence that names the extra, with exit code 2.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
DRY = "TVCLIN_HOME" not in os.environ
HOME = os.environ.setdefault("TVCLIN_HOME", "https://forge.example/tvclin")
"""The address of the repository, which hatch_build.py fills in; a made-up one in a dry run."""
EXTRAS = [name for name in PROJECT["project"]["optional-dependencies"] if name != "all"]
DOCTEST = PROJECT["tool"]["pytest"]["ini_options"]["doctest_optionflags"]
ALWAYS = (
    "--version",
    "doctor",
    "study configuration-i --limit-deg 0.45",
    "ascent configuration-i --every 20",
    "fly configuration-i",
    "init --campaign my.toml",
)
FEATURES = {
    "campaign": "disperse my.toml -o results",
    "report": "report configuration-i",
    "sixdof": "fly configuration-i --engine sixdof",
}
TESTS = (
    "boundary/test_limit",
    "linear/test_modes",
    "linear/test_response",
    "plots/test_figures",
    "cli/test_commands",
)


def main() -> None:
    """Try the environments that are named, or all."""
    chosen = sys.argv[1:] or ["sdist", "none", *EXTRAS, "lowest"]
    with tempfile.TemporaryDirectory() as folder:
        wheel, sdist = built(Path(folder))
        for name in chosen:
            where = Path(folder) / name
            extra = f"[{name}]" if name in EXTRAS else ""
            source = sdist if name == "sdist" else wheel
            wanted = lowest() if name == "lowest" else []
            python = environment(where, f"tvclin{extra} @ {source.as_uri()}", *wanted)
            use(python, where, name)
            if name == "lowest":
                files = [str(ROOT / "tests" / f"{one}.py") for one in TESTS]
                calm = ["-W", "ignore::DeprecationWarning"]  # of old packages about new ones
                run(python, "-m", "pytest", "-q", *calm, *files, where=ROOT)
            print(f"{name}: good", flush=True)
            shutil.rmtree(where)


def built(folder: Path) -> tuple[Path, Path]:
    """The wheel, made from the sdist, and the sdist."""
    python = environment(folder / "build", "build")
    run(python, "-m", "build", "--outdir", str(folder / "dist"), str(ROOT), where=folder)
    return next(folder.glob("dist/*.whl")), next(folder.glob("dist/*.tar.gz"))


def lowest() -> list[str]:
    """The lowest versions of what is needed, and what the tests need."""
    needed = [one.replace(">=", "==") for one in PROJECT["project"]["dependencies"]]
    return [*needed, "pytest", "hypothesis", "mpmath", "sympy"]


def environment(folder: Path, *packages: str) -> Path:
    """An empty environment with these packages; its Python."""
    venv.create(folder, with_pip=True)
    python = folder / "bin" / "python"
    run(python, "-m", "pip", "install", "--quiet", *packages, where=folder)
    return python


def use(python: Path, folder: Path, extra: str) -> None:
    """Run README's lines, the commands that must always work, and those that may need an extra."""
    flags = [word for name in DOCTEST for word in ("-o", name)]
    run(python, "-m", "doctest", *flags, str(ROOT / "README.md"), where=folder)
    for words in ALWAYS:
        run(python, "-m", "tvclin", *words.split(), where=folder)
    for needed, words in FEATURES.items():
        found = tried(python, "-m", "tvclin", *words.split(), where=folder)
        said = re.search(rf"^Error: [^\n]*tvclin\[{needed}\]", found.stderr, re.MULTILINE)
        works = found.returncode in (0, 1)  # also where another extra brings what is needed
        named = extra != needed and found.returncode == 2 and said
        if not (works or named) or "Traceback" in found.stderr:
            sys.exit(f"{extra}: tvclin {words}: exit code {found.returncode}\n{found.stderr}")


def run(python: Path, *words: str, where: Path) -> None:
    """Run Python; end here where it fails."""
    found = tried(python, *words, where=where)
    if found.returncode:
        sys.exit(f"{' '.join(words)}: exit code {found.returncode}\n{found.stdout}{found.stderr}")


def tried(python: Path, *words: str, where: Path) -> subprocess.CompletedProcess[str]:
    """Run Python, and return what came of it."""
    command = [python, *words]
    return subprocess.run(command, cwd=where, capture_output=True, text=True, check=False)


if __name__ == "__main__":
    main()
