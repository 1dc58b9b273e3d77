"""Build the files of a release into `dist/`, check them, and say what is left for a person.

    [TVCLIN_HOME=address of the repository] python .ci/release.py

Without the address this is a dry run: everything is built and checked with one that is made up, and
what a release must not have is told and is no error.
"""

import email
import hashlib
import re
import shutil
import sys
import tarfile
import tempfile
from pathlib import Path
from subprocess import check_output

from packages import DRY, HOME, ROOT, built, environment, run, use

BY_HAND = """
What is left for a person:
1. Put what stands under "Unreleased" in CHANGELOG.md under {version}, with the date; commit.
2. On that commit: make test-all, make docs, make packages.
3. Tag it v{version} and push the tag: links of the long description lead to its files.
4. make release TVCLIN_HOME=..., with the address of the repository.
5. Upload wheel and sdist (twine upload), and tell SHA256SUMS in the notes of the release.
6. Write the next version into tvclin/__init__.py and CITATION.cff.
"""


def main() -> None:
    """Build, check, and tell."""
    version = found(r'^__version__ = "(.+?)"$', "tvclin/__init__.py")
    missing = unfinished(version)
    for one in missing:
        print(f"Not yet: {one}.", flush=True)
    if missing and not DRY:
        sys.exit(1)
    target = ROOT / "dist"
    shutil.rmtree(target, ignore_errors=True)
    with tempfile.TemporaryDirectory() as folder:
        wheel, sdist = built(Path(folder))
        python = environment(Path(folder) / "checks", "twine", "readme-renderer[md]")
        run(python, "-m", "twine", "check", "--strict", str(wheel), str(sdist), where=ROOT)
        print(f"{check_links(python, sdist, version)} links lead to files of the sdist", flush=True)
        use(environment(Path(folder) / "none", str(wheel)), Path(folder) / "none", "none")
        shutil.copytree(wheel.parent, target)
    files = sorted(target.iterdir())
    sums = [f"{hashlib.sha256(one.read_bytes()).hexdigest()}  {one.name}" for one in files]
    (target / "SHA256SUMS").write_text("\n".join(sums) + "\n")
    print("In dist:", *sums, BY_HAND.format(version=version), sep="\n")
    if DRY:
        print("This was a dry run: the addresses in dist are made up. Upload nothing of it.")


def unfinished(version: str) -> list[str]:
    """What there is that a release must not have."""
    cited = found(r'^version: "(.+?)"$', "CITATION.cff")
    told = found(rf"^## ({version}\b)", "CHANGELOG.md")
    waiting = found(r"^## Unreleased\n(.*?)(?=^## )", "CHANGELOG.md").strip()
    conditions = {
        "CITATION.cff has another version": cited != version,
        f"CHANGELOG.md does not tell of {version}": not told,
        "CHANGELOG.md has lines under Unreleased": waiting,
        "files are not committed": check_output(["git", "status", "--porcelain"], cwd=ROOT),
    }
    return [one for one, so in conditions.items() if so]


def found(pattern: str, name: str) -> str:
    """What a pattern finds first in a file of the repository, or nothing."""
    text = (ROOT / name).read_text(encoding="utf-8")
    first = re.search(pattern, text, re.MULTILINE | re.DOTALL)
    return first[1] if first else ""


def check_links(python: Path, sdist: Path, version: str) -> int:
    """Render the long description of an sdist, and find a file for each link into the repository.

    Returns
    -------
    int
        How many such links there are.
    """
    root = sdist.name.removesuffix(".tar.gz")
    with tarfile.open(sdist) as files:
        names = [Path(one).relative_to(root) for one in files.getnames()]
        told = email.message_from_binary_file(files.extractfile(f"{root}/PKG-INFO"))
    page = sdist.with_name("page.md")
    page.write_bytes(told.get_payload(decode=True))
    html = check_output([python, "-m", "readme_renderer", page], text=True)
    page.unlink()
    links = re.findall(r'(?:href|src)="(?!#)([^"#]+)', html)
    links += [one.partition(", ")[2] for one in told.get_all("Project-URL")]
    there = {*names, *(folder for one in names for folder in one.parents)}
    into = re.compile(rf"{re.escape(HOME)}/(?:blob|raw)/v{re.escape(version)}/(.+)")
    paths = [match[1] for match in map(into.fullmatch, links) if match]
    dead = [one for one in links if not one.startswith("https://")]
    dead += [one for one in paths if Path(one) not in there]
    if dead or len(paths) < 15:
        sys.exit(f"of {len(paths)} links into the repository these lead nowhere: {dead}")
    return len(paths)


if __name__ == "__main__":
    main()
