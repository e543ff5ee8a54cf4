"""Build the sdist and the wheel into dist/ and check what is in them: `python -m tools.check_dist`.

Needs a git checkout, whose files are the ones to ship, and the libraries of the extra `dist`.
"""

from __future__ import annotations

import email
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import zipfile
from email.message import Message
from pathlib import Path

ROOT = Path(__file__).parents[1]
DIST = ROOT / "dist"
NOT_SHIPPED = (".ci/", ".github/", ".readthedocs.yaml")
"""Tracked files that only the repository needs."""

RECORDS = {"METADATA", "RECORD", "WHEEL", "entry_points.txt", "licenses/LICENSE"}
"""What a wheel holds besides the package."""

RUNTIME = {"numpy", "scipy", "numba", "mpmath", "matplotlib", "sympy"}


def main() -> int:
    """Build, check, and print what is wrong; return 1 if anything is."""
    tracked = set(_output("git", "ls-files").splitlines())
    version = re.findall(r'__version__ = "(.+)"', (ROOT / "floquetrod/_util/version.py").read_text(encoding="utf-8"))[0]
    os.environ["SOURCE_DATE_EPOCH"] = _output("git", "log", "-1", "--format=%ct").strip()
    shutil.rmtree(DIST, ignore_errors=True)
    _build(DIST)  # the sdist, and the wheel from the sdist
    sdist, wheel = DIST / f"floquetrod-{version}.tar.gz", DIST / f"floquetrod-{version}-py3-none-any.whl"
    faults = [f"dist holds no {path.name}" for path in (sdist, wheel) if not path.exists()]
    if not faults:
        faults = sdist_faults(sdist, tracked) + wheel_faults(wheel, tracked) + metadata_faults(metadata(wheel), version)
        with tempfile.TemporaryDirectory() as folder:
            _build(Path(folder), "--sdist", "--wheel")  # both from the tree
            for path in (sdist, wheel):
                if (Path(folder) / path.name).read_bytes() != path.read_bytes():
                    faults.append(f"{path.name} differs when it is built again, from the tree")
        if subprocess.run([sys.executable, "-m", "twine", "check", "--strict", sdist, wheel], check=False).returncode:
            faults.append("twine finds faults in the metadata")
    for fault in faults:
        print(fault, file=sys.stderr)
    if not faults:
        print(f"{sdist.name}: {sdist.stat().st_size / 1e6:.1f} MB; {wheel.name}: {wheel.stat().st_size / 1e6:.1f} MB")
    return 1 if faults else 0


def sdist_faults(sdist: Path, tracked: set[str]) -> list[str]:
    """Return what the sdist lacks of the tracked files, and what it holds besides."""
    with tarfile.open(sdist) as archive:
        found = {name.split("/", 1)[1] for name in archive.getnames() if "/" in name} - {"PKG-INFO"}
    wanted = {name for name in tracked if not name.startswith(NOT_SHIPPED)}
    return _differences(sdist.name, found, wanted)


def wheel_faults(wheel: Path, tracked: set[str]) -> list[str]:
    """Return what the wheel lacks of the package and its records, and what it holds besides."""
    with zipfile.ZipFile(wheel) as archive:
        found = set(archive.namelist())
    name, version = wheel.name.split("-")[:2]
    wanted = {name for name in tracked if name.startswith("floquetrod/")}
    return _differences(wheel.name, found, wanted | {f"{name}-{version}.dist-info/{record}" for record in RECORDS})


def _differences(name: str, found: set[str], wanted: set[str]) -> list[str]:
    lacking = [f"{name} lacks {path}" for path in sorted(wanted - found)]
    return lacking + [f"{name} holds {path}, which git does not track" for path in sorted(found - wanted)]


def metadata(wheel: Path) -> Message:
    """Return the metadata of a wheel."""
    name, version = wheel.name.split("-")[:2]
    with zipfile.ZipFile(wheel) as archive:
        return email.message_from_bytes(archive.read(f"{name}-{version}.dist-info/METADATA"))


def metadata_faults(about: Message, version: str) -> list[str]:
    """Return what is wrong with the metadata: version, dependencies, the links of the description."""
    faults = []
    if about["Version"] != version:
        faults.append(f"the metadata give version {about['Version']}, the package {version}")
    needed = [each for each in about.get_all("Requires-Dist", []) if "extra ==" not in each]
    names = {re.split(r"[^\w.-]", each)[0] for each in needed}
    if names != RUNTIME:
        faults.append(f"the package needs {', '.join(sorted(names))}; allowed are {', '.join(sorted(RUNTIME))}")
    if about["License-File"] != "LICENSE":
        faults.append("the metadata name no licence file")
    payload = about.get_payload(decode=True)
    text = payload.decode() if isinstance(payload, bytes) else ""
    if len(text) < 500:
        faults.append("the description is not the README")
    prose = re.sub(r"^```.*?^```|`[^`]*`", "", text, flags=re.DOTALL | re.MULTILINE)
    faults += [
        f"the description links to {target}, which an index does not have"
        for target in re.findall(r"\]\(([^)\s]*)", prose)
        if not target.startswith(("https://", "#"))
    ]
    return faults


def _build(folder: Path, *what: str) -> None:
    command = [sys.executable, "-m", "build", "--outdir", str(folder), *what, str(ROOT)]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    if run.returncode:
        raise SystemExit(f"{run.stdout}{run.stderr}\nthe build failed")


def _output(*command: str) -> str:
    return subprocess.run(command, capture_output=True, text=True, check=True, cwd=ROOT).stdout


if __name__ == "__main__":
    sys.exit(main())
