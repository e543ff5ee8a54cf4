"""What a release consists of: one version, six dependencies, extras with reasons, files that ship, checks."""

from __future__ import annotations

import ast
import codecs
import gzip
import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from email.message import Message
from fnmatch import fnmatch
from pathlib import Path

import pytest

import floquetrod
from tools.check_dist import NOT_SHIPPED, RECORDS, RUNTIME, metadata_faults, sdist_faults, wheel_faults

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
PROJECT = tomllib.loads(TEXT)
VERSION = floquetrod.__version__


def read(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


def tracked() -> list[str]:
    """Return the files git tracks; a copy that is no checkout skips."""
    git = shutil.which("git")
    if git is None or not (ROOT / ".git").exists():
        pytest.skip("not a git checkout")
    return subprocess.run([git, "ls-files"], capture_output=True, text=True, check=True, cwd=ROOT).stdout.splitlines()


def name_of(requirement: str) -> str:
    return re.split(r"[^\w.-]", requirement)[0]


# --- the version ---


def test_the_version_is_one() -> None:
    top = re.search(r"^## \[(.+?)\](?: - (.+))?$", read("CHANGELOG.md"), re.MULTILINE)
    assert top is not None
    assert top[1] == VERSION
    assert re.fullmatch(r"unreleased|\d{4}-\d\d-\d\d", top[2])
    assert re.findall(r"^version: (.+)$", read("CITATION.cff"), re.MULTILINE) == [VERSION]
    released = re.findall(r"^date-released: (.+)$", read("CITATION.cff"), re.MULTILINE)
    assert released == ([] if top[2] == "unreleased" else [top[2]])
    assert PROJECT["tool"]["hatch"]["version"]["path"] == "floquetrod/_util/version.py"
    assert f'__version__ = "{VERSION}"' in read("floquetrod/_util/version.py")


# --- what is needed ---


def test_six_dependencies_and_no_more() -> None:
    needed = PROJECT["project"]["dependencies"]
    assert {name_of(each) for each in needed} == RUNTIME
    assert all(re.fullmatch(r"[\w-]+>=[\d.]+,<\d+", each) for each in needed), "each has both bounds"


def test_the_oldest_releases_tried_are_the_lowest_allowed() -> None:
    lowest = {name_of(each): re.findall(r">=([\d.]+)", each)[0] for each in PROJECT["project"]["dependencies"]}
    pins = re.findall(r"^([\w-]+)==([\d.]+)(?:; python_version < .*)?$", read("constraints-oldest.txt"), re.MULTILINE)
    tried = dict(pins)
    assert {name: tried[name].removesuffix(".0") for name in lowest} == lowest


def test_every_extra_says_what_it_is_for() -> None:
    block = TEXT.split("[project.optional-dependencies]")[1].split("\n[")[0]
    for extra in PROJECT["project"]["optional-dependencies"]:
        assert re.search(rf"^# .+\n{extra} = ", block, re.MULTILINE), f"no comment before {extra}"


def test_every_extra_named_in_a_message_exists() -> None:
    extras = PROJECT["project"]["optional-dependencies"]
    for path in sorted((ROOT / "floquetrod").rglob("*.py")):
        for named in re.findall(r"floquetrod\[(\w[\w-]*)\]", path.read_text(encoding="utf-8")):
            assert named in extras, path


def test_what_needs_xarray_says_which_extra_has_it(monkeypatch: pytest.MonkeyPatch) -> None:
    chart = floquetrod.chart(floquetrod.Mathieu, over={"alpha": [0.1, 0.2], "beta": [-0.3, -0.2]})
    monkeypatch.setitem(sys.modules, "xarray", None)
    for asked in (chart.to_xarray, chart.bands.to_xarray):
        with pytest.raises(ImportError, match=r"needs xarray: pip install floquetrod\[xarray\]"):
            asked()


def test_every_pinned_tool_is_pinned_once() -> None:
    pins = [line.split("==")[0].lower() for line in read("constraints.txt").splitlines() if "==" in line]
    assert len(pins) == len(set(pins))
    listed = {pin.replace("_", "-") for pin in pins}
    for extra, wanted in PROJECT["project"]["optional-dependencies"].items():
        assert {name_of(each) for each in wanted} <= listed | {"floquetrod"}, extra


# --- what old numba does not compile ---


def test_kernels_are_written_in_what_the_lowest_numba_compiles() -> None:
    texts = {path: path.read_text(encoding="utf-8") for path in sorted((ROOT / "floquetrod").rglob("*.py"))}
    kernels = {path: text for path, text in texts.items() if "\n@kernel" in text}
    assert len(kernels) > 25
    for path, text in kernels.items():
        for node in ast.walk(ast.parse(text)):
            written = ast.unparse(node) if isinstance(node, ast.Attribute | ast.Call) else ""
            assert written != "math.log2", f"{path.name}: np.log2 compiles with numba 0.59"
            assert not re.match(r"float\('", written), f"{path.name}: math.nan compiles with numba 0.59"


# --- what ships ---


def test_the_sdist_takes_every_tracked_file() -> None:
    patterns = PROJECT["tool"]["hatch"]["build"]["targets"]["sdist"]["include"]
    always = {".gitignore", "LICENSE", "pyproject.toml"}  # hatchling adds these
    for name in tracked():
        taken = any(fnmatch(f"/{name}", pattern) or f"/{name}".startswith(f"{pattern}/") for pattern in patterns)
        assert taken or name in always or name.startswith(NOT_SHIPPED), name


def test_no_file_names_a_machine_or_a_registry_host() -> None:
    folders = "|".join(("opt", "root", "work", "home/[a-z]+", "Users/[A-Za-z]+", "mnt", "srv"))
    paths = re.compile(rf"(?<![\w.~\-/\]])/(?:{folders})/[\w.]")
    hosts = re.compile("|".join(rf"{name}\.{end}" for name, end in (("pypi", "org"), ("pythonhosted", "org"))))
    for name in tracked():
        path = ROOT / name
        if path.suffix in {".png", ".npz", ".zip"} or not path.exists():
            continue
        content = gzip.decompress(path.read_bytes()) if path.suffix == ".gz" else path.read_bytes()
        text = content.decode("utf-16" if content.startswith(codecs.BOM_UTF16_LE) else "utf-8")
        assert not paths.search(text), (name, paths.search(text))
        assert not hosts.search(text), name


# --- the checks bite ---


def make_wheel(folder: Path, *names: str) -> Path:
    path = folder / f"floquetrod-{VERSION}-py3-none-any.whl"
    with zipfile.ZipFile(path, "w") as archive:
        for name in names:
            archive.writestr(name, "")
    return path


def test_faults_of_a_wheel_are_found(tmp_path: Path) -> None:
    records = [f"floquetrod-{VERSION}.dist-info/{record}" for record in sorted(RECORDS)]
    files = {"floquetrod/__init__.py", "floquetrod/py.typed", "studies/__init__.py", "tests/project/test_release.py"}
    assert wheel_faults(make_wheel(tmp_path, *records, "floquetrod/__init__.py", "floquetrod/py.typed"), files) == []
    extra = ["tests/project/test_release.py", "studies/__init__.py", "floquetrod/__pycache__/a.nbc"]
    faults = wheel_faults(make_wheel(tmp_path, *records[:-1], "floquetrod/__init__.py", *extra), files)
    assert [fault.partition(" ")[2] for fault in faults] == [
        f"lacks {records[-1]}",
        "lacks floquetrod/py.typed",
        "holds floquetrod/__pycache__/a.nbc, which git does not track",
        "holds studies/__init__.py, which git does not track",
        "holds tests/project/test_release.py, which git does not track",
    ]


def test_faults_of_an_sdist_are_found(tmp_path: Path) -> None:
    path = tmp_path / f"floquetrod-{VERSION}.tar.gz"
    with tarfile.open(path, "w:gz") as archive:
        for name in ("PKG-INFO", "README.md", "scratch.py"):
            archive.add(ROOT / "LICENSE", f"floquetrod-{VERSION}/{name}")
    found = sdist_faults(path, {"README.md", "docs/picture.png", ".ci/run"})
    assert [fault.partition(" ")[2] for fault in found] == [
        "lacks docs/picture.png",
        "holds scratch.py, which git does not track",
    ]


def about(**changed: str) -> Message:
    """Return metadata without a fault but for what is changed."""
    message = Message()
    fields = {"Version": VERSION, "License-File": "LICENSE"} | changed
    message.set_payload(fields.pop("description", "Words. " * 100 + "[a paper](https://doi.org/10.1115/1.4031710)"))
    for name, value in fields.items():
        message[name.replace("_", "-")] = value
    for name in sorted(RUNTIME):
        message["Requires-Dist"] = f"{name}>=1"
    message["Requires-Dist"] = "zarr; extra == 'ensemble'"
    return message


def test_faults_of_the_metadata_are_found() -> None:
    assert metadata_faults(about(), VERSION) == []
    assert "give version 0.0" in metadata_faults(about(Version="0.0"), VERSION)[0]
    assert "allowed are" in metadata_faults(about(Requires_Dist="tqdm>=4"), VERSION)[0]
    assert "links to docs/a.md" in metadata_faults(about(description="Words. " * 100 + "[a](docs/a.md)"), VERSION)[0]
    assert "is not the README" in metadata_faults(about(description="Words."), VERSION)[0]


def test_the_description_has_no_picture_and_no_link_beside_the_readme() -> None:
    text = read("README.md")
    for change in PROJECT["tool"]["hatch"]["metadata"]["hooks"]["fancy-pypi-readme"]["substitutions"]:
        text = re.sub(change["pattern"], change["replacement"], text)
    message = about(description=text)
    assert metadata_faults(message, VERSION) == []
    assert "](https://" in text, "links elsewhere stay"
