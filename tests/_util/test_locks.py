"""Locks on files: of parts, of one owner at a time, gone with their process, whatever it left."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from floquetrod._util.locks import Lock

pytestmark = pytest.mark.skipif(
    sys.platform != "linux", reason="elsewhere locks belong to the process, or there are none"
)


def assert_free(path: Path, part: range, *, remove: bool) -> None:
    Lock(path, part, remove=remove).release()


@pytest.mark.parametrize("remove", [False, True])
def test_one_has_a_lock_at_a_time(remove: bool, tmp_path: Path) -> None:
    path = tmp_path / "lock"
    first = Lock(path, range(1), remove=remove)
    for _ in range(2):
        with pytest.raises(BlockingIOError):
            Lock(path, range(1), remove=remove)
    first.release()
    first.release()
    assert path.exists() is not remove
    assert_free(path, range(1), remove=remove)


def test_parts_that_do_not_overlap_are_locked_at_once(tmp_path: Path) -> None:
    path = tmp_path / "lock"
    held = [Lock(path, range(start, start + 3), remove=False) for start in (0, 3, 9)]
    for part in (range(2, 3), range(5, 8), range(8, 10), range(100)):
        with pytest.raises(BlockingIOError):
            Lock(path, part, remove=False)
    assert_free(path, range(6, 9), remove=False)
    held[1].release()
    assert_free(path, range(3, 9), remove=False)
    with pytest.raises(BlockingIOError):
        Lock(path, range(1), remove=False)


@pytest.mark.parametrize("remove", [pytest.param(False, marks=pytest.mark.slow), True])
def test_a_killed_process_has_no_lock(remove: bool, tmp_path: Path) -> None:
    path = tmp_path / "lock"
    body = (
        "import sys\nfrom pathlib import Path\nfrom floquetrod._util.locks import Lock\n"
        f"lock = Lock(Path(sys.argv[1]), range(1), remove={remove})\nprint('held', flush=True)\nsys.stdin.read()"
    )
    with subprocess.Popen([sys.executable, "-c", body, str(path)], stdin=-1, stdout=-1, text=True) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == "held\n"
        other.send_signal(signal.SIGSTOP)
        with pytest.raises(BlockingIOError):
            Lock(path, range(1), remove=remove)
        other.kill()
    assert path.exists()
    assert_free(path, range(1), remove=remove)


@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
def test_a_forked_process_does_not_keep_its_parents_lock(tmp_path: Path) -> None:
    """As workers of a pool that outlive a parent that was killed."""
    path = tmp_path / "lock"
    ready, tell = os.pipe()
    parent = os.fork()
    if not parent:
        lock = Lock(path, range(1), remove=False)
        child = os.fork()
        if child:
            os.write(tell, f"{child}\n".encode())
            signal.pause()
        else:
            del lock
            signal.pause()
        os._exit(0)
    child = int(os.read(ready, 20))
    try:
        with pytest.raises(BlockingIOError):
            Lock(path, range(1), remove=False)
        os.kill(parent, signal.SIGKILL)
        os.waitpid(parent, 0)
        assert_free(path, range(1), remove=False)
    finally:
        os.kill(child, signal.SIGKILL)


def test_a_lock_on_a_file_that_was_removed_is_taken_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What another process opens just before its owner removes it."""
    path, opened = tmp_path / "lock", os.open
    first = Lock(path, range(1), remove=True)

    def late(name: Path, *arguments: int) -> int:
        handle = opened(name, *arguments)
        first.release()
        return handle

    monkeypatch.setattr(os, "open", late)
    second = Lock(path, range(1), remove=True)
    assert path.exists()
    with pytest.raises(BlockingIOError):
        Lock(path, range(1), remove=True)
    second.release()


def test_what_cannot_be_opened_is_an_error_of_another_kind(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        Lock(tmp_path / "no" / "lock", range(1), remove=True)
