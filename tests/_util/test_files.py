"""Files: whole or not there, checked before work, kept as their owners want them, and refused when damaged."""

from __future__ import annotations

import errno
import fcntl
import os
import stat
import subprocess
import sys
import tracemalloc
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod import cli
from floquetrod._util import sealed_files
from floquetrod._util.sealed_files import atomic_file, writable
from floquetrod.ensembles.runs import Runs
from floquetrod.ensembles.variables import Variable
from floquetrod.equations.system_files import read_system
from tests.conftest import DEEP, depth
from tests.damages import damaged, sealed, shuffled, unpacked
from tests.seams import Forbidden, Tuned

ROD = fr.Rod.nitinol()
FCR = ROD.critical_force
LOAD = fr.AxialLoad(0.2 * FCR, 0.2 * FCR, 150.0)


def write(path: Path, content: bytes) -> None:
    with atomic_file(path) as file:
        file.write(content)


def left_over(folder: Path) -> list[Path]:
    return [path for path in folder.iterdir() if path.name.endswith(".part")]


def small_map(growth: bool = True) -> fr.Chart:
    return fr.stability_map(
        ROD, mean=(0.0, 1.1 * FCR, 12), amplitude=0.2 * FCR, frequency=(20.0, 200.0, 17), growth=growth
    )


def short_run(checkpoint: Path | None = None) -> fr.Simulation:
    return fr.simulate(ROD, LOAD, duration=1e-3, segments=40, frames=3, checkpoint=checkpoint)


STEADY = ["--rod", "nitinol", "--amplitude", "0.2Fcr"]
MAP = ["map", *STEADY, "--mean", "0:1Fcr", "--frequency", "20:200", "--points", "9x8"]
RUN = ["simulate", *STEADY, "--mean", "0.2Fcr", "--frequency", "150", "--segments", "40", "--duration", "1ms"]
RUN += ["--frames", "3"]

# Every way to write a file: the function writes something to the path it is given.
WRITERS: dict[str, tuple[str, Callable[[Path], object]]] = {
    "chart": ("a.npz", lambda path: small_map().save(path)),
    "simulation": ("a.npz", lambda path: short_run().save(path)),
    "checkpoint": ("a.ckpt", short_run),
    "map": ("a.png", lambda path: cli.main([*MAP, "--pixels", "--out", str(path)])),
    "animation": ("a.gif", lambda path: cli.main([*RUN, "--out", str(path)])),
}


@pytest.fixture(autouse=True)
def no_window(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MPLBACKEND", "Agg")


@pytest.fixture(params=[pytest.param(name, marks=[pytest.mark.slow] * (name == "animation")) for name in WRITERS])
def writer(request: pytest.FixtureRequest) -> tuple[str, Callable[[Path], object]]:
    return WRITERS[request.param]


@pytest.mark.slow
def test_a_new_file_has_the_permissions_of_any_new_file(
    tmp_path: Path, writer: tuple[str, Callable[[Path], object]], monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "plain").touch()
    monkeypatch.delattr(os, "umask")  # it belongs to the whole process, and its other threads
    name, save = writer
    save(tmp_path / name)
    assert (tmp_path / name).stat().st_mode == (tmp_path / "plain").stat().st_mode
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(["plain", name])


@pytest.mark.slow
def test_permissions_and_links_are_kept(tmp_path: Path, writer: tuple[str, Callable[[Path], object]]) -> None:
    name, save = writer
    (tmp_path / "elsewhere").mkdir()
    real = tmp_path / "elsewhere" / f"real{Path(name).suffix}"
    (tmp_path / name).symlink_to(real)  # to nothing, yet
    save(tmp_path / name)
    first = real.read_bytes()
    for mode in (0o640, 0o600)[: depth(2, 1)]:
        real.chmod(mode)
        save(tmp_path / name)
        assert (tmp_path / name).readlink() == real
        assert stat.S_IMODE(real.stat().st_mode) == mode
    assert len(real.read_bytes()) > len(first) // 2
    assert not left_over(tmp_path)
    assert not left_over(real.parent)


def test_nobody_reads_in_the_part_what_they_may_not_read_in_the_file(tmp_path: Path) -> None:
    path = tmp_path / "secret"
    path.touch(0o600)
    with atomic_file(path) as file:
        assert stat.S_IMODE(os.fstat(file.fileno()).st_mode) == 0o600


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EIO, errno.EDQUOT, errno.EACCES])
@pytest.mark.parametrize("call", ["fsync", "replace"])
def test_a_save_that_fails_leaves_the_old_file_and_nothing_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, call: str, number: int
) -> None:
    path = tmp_path / "a.npz"
    small_map().save(path)
    before = path.read_bytes()

    def fail(*_: object) -> None:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(os if call == "fsync" else Path, call, fail)
    with pytest.raises(OSError, match=os.strerror(number)):
        small_map(growth=False).save(path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_it_is_on_the_disk_before_it_takes_its_place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, seen = tmp_path / "a", []
    path.write_bytes(b"old")
    flush = os.fsync

    def note(handle: int) -> None:
        flush(handle)
        kind = "folder" if stat.S_ISDIR(os.fstat(handle).st_mode) else os.pread(handle, 9, 0)
        seen.append((kind, path.read_bytes()))

    monkeypatch.setattr(os, "fsync", note)
    write(path, b"new")
    assert seen == [(b"new", b"old"), ("folder", b"new")]


def test_parts_of_the_dead_are_removed_and_those_of_the_living_are_not(tmp_path: Path) -> None:
    dead = tmp_path / ".floquetrod-0123456789abcdef.part"
    foreign = tmp_path / ".floquetrod-notes.part"
    dead.write_bytes(b"half")
    foreign.write_bytes(b"somebody else's")
    with atomic_file(tmp_path / "one") as one:
        one.write(b"1")
        assert not dead.exists()
        (living,) = set(left_over(tmp_path)) - {foreign}
        write(tmp_path / "two", b"2")  # in this process: as from another thread
        target = str(tmp_path / "x")
        script = f"from floquetrod._util import sealed_files\nsealed_files.writable(sealed_files.Path({target!r}))"
        subprocess.run([sys.executable, "-c", script], check=True, cwd=Path(__file__).parents[2])
        assert living.exists()
    assert (tmp_path / "one").read_bytes() == b"1"
    assert left_over(tmp_path) == [foreign]


def test_a_part_that_was_taken_for_abandoned_is_begun_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Between making a part and locking it another process may come and remove it."""
    real, taken = fcntl.flock, []

    def slow(handle: int, how: int) -> None:
        if len(taken) < 3:
            taken.extend(left_over(tmp_path))
            for part in left_over(tmp_path):
                part.unlink()
        real(handle, how)

    monkeypatch.setattr(fcntl, "flock", slow)
    write(tmp_path / "a", b"whole")
    assert len(taken) == 3
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


def test_where_files_cannot_be_locked_nothing_is_removed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    part = tmp_path / ".floquetrod-0123456789abcdef.part"
    part.touch()

    def unable(*_: object) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(fcntl, "flock", unable)
    write(tmp_path / "a", b"whole")
    assert part.exists()
    assert (tmp_path / "a").read_bytes() == b"whole"


def impossible(folder: Path) -> dict[str, Path]:
    """Return paths that cannot be written, by what is said of them."""
    (folder / "file").touch()
    (folder / "loop").symlink_to(folder / "loop")
    os.mkfifo(folder / "pipe")
    return {
        "there is no folder '.*no' to write a.npz to": folder / "no" / "a.npz",
        "there is no folder '.*file' to write a.npz to": folder / "file" / "a.npz",
        "is a folder; name a file in it": folder,
        "full is a device or a pipe": Path("/dev/full"),
        "null is a device or a pipe": Path("/dev/null"),
        "pipe is a device or a pipe": folder / "pipe",
        "loop cannot be written: Too many levels": folder / "loop",
        "cannot be written: File name too long": folder / ("long" * 100),
        "null byte": folder / "a\0b",
        "proc/a.npz cannot be written": Path("/proc/a.npz"),
    }


def test_a_path_is_checked_before_there_is_anything_to_write(tmp_path: Path) -> None:
    for message, path in impossible(tmp_path).items():
        with pytest.raises(ValueError, match=message):
            writable(path)
        with pytest.raises(ValueError, match=message):
            short_run(path)
    assert Path("/dev/null").is_char_device()


def test_what_is_write_protected_is_not_replaced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "kept"
    path.touch(0o444)
    monkeypatch.setattr(os, "access", lambda path, how: bool(Path(path).stat().st_mode & how << 6))  # no administrator
    with pytest.raises(ValueError, match="kept is write-protected; change its permissions"):
        writable(path)


@pytest.mark.parametrize("command", ["map", "simulate", "studies"])
def test_the_terminal_checks_before_it_computes(
    tmp_path: Path, command: str, capsys: pytest.CaptureFixture[str], forbidden: Forbidden
) -> None:
    from studies import __main__, reproduction

    forbidden(fr, "stability_map")
    forbidden(fr.SimulationProblem, "_run")
    forbidden(reproduction.figures, "figure_2")
    where = tmp_path / "report.html"
    where.mkdir()
    (tmp_path / "a.npz").mkdir()
    lines = {
        "map": [*MAP, "--out", str(tmp_path / "a.npz")],
        "simulate": [*RUN, "--out", str(tmp_path / "a.npz")],
        "studies": ["--quick", "--out", str(tmp_path)],
    }
    assert (__main__ if command == "studies" else cli).main(lines[command]) == 2
    assert "is a folder" in capsys.readouterr().err


# Damage


@pytest.fixture(scope="module")
def kinds(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[bytes, Callable[[Path], Any], Any]]:
    """For each kind of file: its bytes, how it is read, and what that returns."""
    folder = tmp_path_factory.mktemp("kinds")
    chart, verdicts, run = small_map(), small_map(growth=False), short_run(folder / "run.ckpt")
    return {
        "chart": (chart.save(folder / "chart").read_bytes(), fr.Chart.load, chart),
        "verdicts": (verdicts.save(folder / "verdicts").read_bytes(), fr.Chart.load, verdicts),
        "simulation": (run.save(folder / "run").read_bytes(), fr.Simulation.load, run),
        "checkpoint": ((folder / "run.ckpt").read_bytes(), short_run, run),
    }


def attack(
    kinds: dict[str, tuple[bytes, Callable[[Path], Any], Any]],
    path: Path,
    rng: np.random.Generator,
    count: int,
    *,
    forged: bool,
) -> int:
    """Damage files ``count`` times; return how many load all the same, as those do that an accident left whole."""
    loaded, wholes = 0, {whole: (load, expected) for whole, load, expected in kinds.values()}
    for turn in range(count):
        whole = list(wholes)[turn % len(wholes)]
        others = [other for other in wholes if other != whole]
        content = (shuffled if rng.random() < 0.3 else damaged)(whole, others, rng)
        path.write_bytes(sealed(content) if forged else content)
        result = read(wholes[whole][0], path)
        if result is not None and not forged:
            assert content in wholes, "damaged, and yet it loaded"
            assert result == wholes[content][1]
        loaded += result is not None
    return loaded


def read(load: Callable[[Path], Any], path: Path) -> Any:
    """Return what is read from a file, None where it is refused as it should be."""
    try:
        return load(path)
    except ValueError:
        return None


def test_damaged_files_raise_value_errors(kinds: Any, tmp_path: Path, rng: np.random.Generator) -> None:
    assert attack(kinds, tmp_path / "file", rng, 400, forged=False) < 20


@pytest.mark.slow
def test_forged_files_raise_value_errors_if_anything(kinds: Any, tmp_path: Path, rng: np.random.Generator) -> None:
    """A seal that fits lets damage through to zip, numpy and JSON, and to the checks of every field."""
    attack(kinds, tmp_path / "file", rng, depth(400, 150), forged=True)


@pytest.mark.slow
def test_thousands_of_damaged_files(kinds: Any, tmp_path: Path, rng: np.random.Generator) -> None:
    assert attack(kinds, tmp_path / "file", rng, 5000, forged=False) < 250
    attack(kinds, tmp_path / "file", rng, 5000, forged=True)


@pytest.mark.slow
@pytest.mark.parametrize("part", [0.2, pytest.param(1.0, marks=pytest.mark.slow)])
def test_no_byte_of_a_chart_can_change(kinds: Any, tmp_path: Path, rng: np.random.Generator, part: float) -> None:
    whole, load, _ = kinds["chart"]
    path = tmp_path / "chart.npz"
    for at in rng.choice(len(whole), int(part * len(whole)), replace=False):
        content = bytearray(whole)
        content[at] ^= 1 << int(rng.integers(8))
        path.write_bytes(content)
        with pytest.raises(ValueError, match="is not a chart that can be read"):
            load(path)


def test_the_same_content_makes_the_same_file_which_numpy_reads(tmp_path: Path) -> None:
    chart = small_map()
    one, two = chart.save(tmp_path / "one.npz"), small_map().save(tmp_path / "two.npz")
    assert one.read_bytes() == two.read_bytes()
    with np.load(one, allow_pickle=False) as file:
        assert np.array_equal(file["stable"], chart.stable)


def forge(path: Path, **changes: Any) -> None:
    """Write a chart with other entries of its description, or other arrays, under a seal that fits."""
    meta, arrays = unpacked(small_map().save(path))
    for name, value in changes.items():
        target: dict[str, Any] = meta if name in meta and not isinstance(value, np.ndarray) else arrays
        target[name] = value
    sealed_files.write_npz(path, meta, arrays, compress=True)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"format": "floquetrod chart 1"}, "another kind or version"),
        ({"format": "floquetrod chart 2"}, "another kind or version"),
        ({"stable": np.ones((12, 16), bool)}, "stable is an array of bool and shape"),
        ({"stable": np.ones((12, 17))}, "stable is an array of float64"),
        ({"growth_rate": np.zeros((12, 17), complex)}, "growth_rate is an array of complex128"),
        ({"first_mode": np.zeros((12, 17))}, "first_mode is an array of float64"),
        ({"x": [1, 2, 3]}, "axis x is"),
        ({"x": ["a", "b"]}, "axis x is"),
        ({"growth_tolerance": "0"}, "growth_tolerance is '0'"),
        ({"growth_tolerance": float("nan")}, "growth_tolerance is nan"),
        ({"growth_tolerance": -1.0}, "growth_tolerance is -1"),
        ({"undecided": True}, "undecided is True"),
        ({"undecided": 205}, "undecided 205"),
        ({"undecided": 10**400}, "undecided 1000"),
        ({"subject": {}}, "it has no 'kind'"),
        ({"subject": {"kind": "rod", "fixed": [["mean", "1", "N"]]}}, "subject is"),
        ({"subject": []}, "subject is"),
        ({"version": None}, "version is None"),
        ({"criterion": 5}, "criterion is 5"),
    ],
)
def test_every_field_of_a_chart_is_checked(tmp_path: Path, changes: dict[str, Any], message: str) -> None:
    path = tmp_path / "chart.npz"
    forge(path, **changes)
    with pytest.raises(ValueError, match=f"is not a chart that can be read: .*{message}"):
        fr.Chart.load(path)


@pytest.mark.slow
def test_every_field_of_a_simulation_is_checked(tmp_path: Path) -> None:
    path = short_run().save(tmp_path / "run.npz")
    meta, arrays = unpacked(path)
    bad = {name: array[:-1] for name, array in arrays.items()} | {
        "positions": np.full_like(arrays["positions"], np.nan)
    }
    for name, array in bad.items():
        sealed_files.write_npz(path, meta, {**arrays, name: array}, compress=True)
        with pytest.raises(ValueError, match="is not a simulation that can be read"):
            fr.Simulation.load(path)
    values = {
        "ended": "buckled",
        "seconds": -1.0,
        "version": 2,
        "step_limit": "me",
        "steps_per_frame": 0,
    }
    problem = {
        "frames": 3.0,
        "segments": True,
        "friction": -1.0,
        "duration": "1",
        "time_step": 0,
        "extra": 1,
        "rod": {},
    }
    for changed in [meta | {name: value} for name, value in values.items()] + [
        *(meta | {"ended": value} for value in ("interrupted", "at rest", "by itself", 1)),
        *(meta | {"problem": meta["problem"] | {name: value}} for name, value in problem.items()),
    ]:
        sealed_files.write_npz(path, changed, arrays, compress=True)
        with pytest.raises(ValueError, match="is not a simulation that can be read"):
            fr.Simulation.load(path)
    sealed_files.write_npz(path, meta, arrays, compress=True)
    assert fr.Simulation.load(path) == short_run()


def bomb(path: Path, header: str, content: bytes) -> None:
    """Write a sealed archive one member of which begins with this header."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.comment = bytes(sealed_files._SEALED)
        text = header.encode() + b"\n"
        archive.writestr("stable.npy", b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text + content)
    path.write_bytes(sealed(path.read_bytes()))


@pytest.mark.parametrize(
    "header",
    [
        "{'descr': '<f8', 'fortran_order': False, 'shape': (1099511627776,)}",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (-1, -8)}",
        "{'descr': '<U1000000000', 'fortran_order': False, 'shape': (3,)}",
        "{'descr': '|O', 'fortran_order': False, 'shape': (3,)}",
        "{'descr': '|V0', 'fortran_order': False, 'shape': (1099511627776,)}",
        "{'descr': " + "(" * 500 + ")" * 500 + "}",
        "nonsense",
    ],
)
def test_headers_that_claim_terabytes_take_no_memory(tmp_path: Path, header: str) -> None:
    path = tmp_path / "chart.npz"
    bomb(path, header, bytes(64))
    tracemalloc.start()
    with pytest.raises(ValueError, match="is not a chart that can be read"):
        fr.Chart.load(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 10_000_000


def test_files_that_unfold_beyond_measure_are_refused(tmp_path: Path, tuned: Tuned) -> None:
    path = tmp_path / "chart.npz"
    with path.open("wb") as file:
        file.truncate(sealed_files._LARGEST + 1)
    with pytest.raises(ValueError, match=r"it has 8,589,934,593 bytes, at most"):
        fr.Chart.load(path)
    tuned(bytes_of_a_sealed_file=1 << 20)
    bomb(path, "{'descr': '|b1', 'fortran_order': False, 'shape': (4000000,)}", bytes(4_000_000))
    assert path.stat().st_size < 10_000
    with pytest.raises(ValueError, match="it holds more than 1,048,576 bytes"):
        fr.Chart.load(path)
    with pytest.raises(ValueError, match="at most 1,048,576 are written and read"):
        sealed_files.write_npz(path, {}, {"a": np.zeros(200_000)}, compress=True)


@pytest.mark.parametrize("path", ["/dev/zero", "/dev", "/dev/absent"])
def test_what_is_no_file_is_not_read(path: str) -> None:
    with pytest.raises(ValueError, match="is not a chart that can be read"):
        fr.Chart.load(path)


@pytest.mark.parametrize(
    ("read", "kind"),
    [
        (fr.Rod.from_toml, ".toml"),
        (fr.Milling.from_toml, ".toml"),
        (fr.Study.from_toml, ".toml"),
        (fr.WellPath.from_csv, ".csv"),
        (fr.ForceRecord.from_csv, ".csv"),
        (fr.Simulation.load, ".npz"),
        (fr.Chart.load, ".npz"),
        (Runs.load, ".npz"),
        (read_system, ".toml"),
        (read_system, ".npz"),
    ],
)
def test_a_pipe_is_refused_at_once(read: Callable[[Path], Any], kind: str, tmp_path: Path) -> None:
    pipe = tmp_path / f"pipe{kind}"
    os.mkfifo(pipe)
    with pytest.raises(ValueError, match="a folder or a device, or a pipe; name a file"):
        read(pipe)


@pytest.mark.parametrize(
    "code",
    [
        "\x1b[31m",
        "\u202e",
        *(pytest.param(code, marks=pytest.mark.slow) for code in ("\x1b]0;title\x07", "\r", "\x9b2J", "\x7f")),
    ],
)
def test_names_of_files_are_printable_in_the_terminal(
    code: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    if not DEEP:  # pictures take seconds
        monkeypatch.setattr("floquetrod.plotting.chart_plot.save_figure", lambda drawn, path: path)
    name, examples = f"a{code}b", Path(__file__).parents[2] / "floquetrod/examples"
    Path(f"{name}.csv").write_bytes((examples / "survey.csv").read_bytes())
    Path(f"{name}.toml").write_text("length = 3", encoding="utf-8")
    reach = ["reach", "--rod", str(examples / "tubing.toml"), "--friction", "0.3", "--depths", "300m"]
    load = ["--mean", "0", "--amplitude", "0", "--frequency", "1"]
    for words, status in (
        ([*reach, "--well", f"no{name}.csv"], 2),
        ([*reach, "--well", f"{name}.toml"], 2),
        (["check", *load, "--rod", f"{name}.toml"], 2),
        (["check", "--system", f"{name}.toml"], 2),
        (["lobes", f"{name}.toml"], 2),
        (["ensemble", f"{name}.toml"], 2),
        (["check", *load, "--rod", "nitinol", "--force", f"{name}.csv"], 2),
        ([*reach, "--well", f"{name}.csv", "--out", f"{name}.png"], 0),
    ):
        assert cli.main(words) == status
        said = "".join(capsys.readouterr())
        assert code not in said
        assert code == "\r" or code.encode("unicode_escape").decode()[:4] in said  # white space is one space


ZEROS = "{'descr': '<f8', 'fortran_order': False, 'shape': (12500000,)}"
"""Header of 100 MB of zeros, which a hundred kilobytes unfold to."""


def bombs(path: Path) -> dict[str, Callable[[], object]]:
    """Write archives with members that unfold to 40 MB and do not fit the others; return who reads them."""
    zeros = np.zeros(5_000_000)

    def forge(saved: Path, *names: str) -> None:
        meta, arrays = unpacked(saved)
        for name in names:
            place = path / f"{saved.stem} {name}.npz"
            sealed_files.write_npz(place, meta, {**arrays, name: zeros}, compress=True)

    forge(small_map().save(path / "chart.npz"), "stable", "x", "growth_rate")
    forge(short_run().save(path / "run.npz"), "time", "positions")
    kick = Variable(("kick",), np.ones(3), {})
    forge(Runs({"a": kick, "b": kick}, {"kick": kick}, {}).save(path / "runs.npz"), "variables.b", "coords.kick")
    np.savez_compressed(path / "system.npz", stiffness=np.eye(2), cosines=zeros)
    np.savez_compressed(path / "batch.npz", stiffness=np.zeros((500_000, 3, 3)))
    readers: dict[str, Callable[[], object]] = {}
    for file in path.glob("* *.npz"):
        load = {"chart": fr.Chart.load, "run": fr.Simulation.load, "runs": Runs.load}[file.name.split()[0]]
        readers[file.name] = lambda load=load, file=file: load(file)  # type: ignore[misc]
    for name in ("system.npz", "batch.npz"):
        readers[name] = lambda name=name: read_system(path / name)  # type: ignore[misc]
    return readers


@pytest.mark.slow
def test_archives_that_unfold_to_what_does_not_fit_take_no_memory(tmp_path: Path) -> None:
    """Shapes are compared before anything is read, by every reader of such files."""
    readers = bombs(tmp_path)
    assert len(readers) == 9
    for name, load in readers.items():
        tracemalloc.start()
        with pytest.raises(ValueError, match=r"be read"):
            load()
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert peak < 20_000_000, name


def test_a_directory_that_claims_more_than_the_file_can_hold_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "chart.npz"
    bomb(path, ZEROS, bytes(64))
    content = bytearray(path.read_bytes())
    at = content.rindex(b"PK\x01\x02")
    content[at + 24 : at + 28] = (1 << 30).to_bytes(4, "little")  # the size of the member, in the directory
    path.write_bytes(sealed(bytes(content)))
    with pytest.raises(ValueError, match=r"stable\.npy claims more than a file of \d+ bytes can hold"):
        fr.Chart.load(path)


def test_a_closed_folder_is_named_and_nothing_is_left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run, opened = short_run(), os.open

    def closed(path: Any, flags: int, *mode: int, **options: Any) -> int:
        if flags & os.O_CREAT:
            raise PermissionError(errno.EACCES, "Permission denied", str(path))
        return opened(path, flags, *mode, **options)

    with monkeypatch.context() as patched:
        patched.setattr(os, "open", closed)
        with pytest.raises(ValueError, match=r"path must be in a folder that can be written, got .*Permission denied"):
            run.save(tmp_path / "run.npz")
    (tmp_path / "file").write_text("")
    for place in (tmp_path / "none" / "run.npz", tmp_path / "file" / "run.npz", tmp_path):
        with pytest.raises(ValueError, match=r"there is no folder|is a folder"):
            run.save(place)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
