"""Random and mutated command lines: exit status 0, 1, 2, 3 or 130, errors on one line, never a traceback.

Some run in processes of their own, whose standard streams may be closed or full: an answer that is lost is an error.
"""

from __future__ import annotations

import contextlib
import io
import json
import shlex
import subprocess
import sys

import numpy as np

from floquetrod import cli
from tests.fuzz.calls import folder, table
from tests.fuzz.core import Found, TookTooLong, limit, told

CASES = 400
QUICK = 25

STATUSES = {0, 1, 2, 3, 130}

LINES = (
    "check --rod nitinol --mean 0.2Fcr --amplitude 0.2Fcr --frequency 150",
    "check --rod rod.toml --mean 0.34N --amplitude 0.3N --frequency 24Hz --growth-tolerance 0.7 --json",
    "check --rod nitinol --mean 0.8Fcr --amplitude 0.7Fcr --frequency 150 --friction 0.1 --kick 50mm/s --modes 7,8",
    "ranges --rod nitinol --amplitude 0.2Fcr --frequency 150 --mean 0:1.2Fcr --growth-tolerance 0.1",
    "ranges --rod nitinol --mean 0.34Fcr --amplitude 0.2Fcr --frequency 20Hz:60Hz --growth-tolerance 0.05 --json",
    "ranges --rod rod.toml --mean 0.3N --frequency 24Hz --amplitude 0:1N --damping-rate 1",
    "map --rod nitinol --amplitude 0.2Fcr --mean 0:1.1Fcr --frequency 20:200 --points 6x5 --out map.npz",
    "map --rod nitinol --frequency 150 --mean 0:1.1Fcr --amplitude 0:0.5Fcr --growth --points 4x4 --out map.npz --json",
    "map --rod nitinol --amplitude 0.7Fcr --mean 0:1Fcr --frequency 50:200 --mu 0.1 --kick 50mm/s --points 3x3 "
    "--out map.npz",
    "check --system system.toml",
    "check --system system.toml --method segmented --json",
    "check --system system.npz --exit-code",
    "check --system family.toml --set omega=2.5 --set epsilon=0.3 --json",
    "compare --alpha 0.5 --beta -0.25 --damping 0.1 --waveform square",
    "compare --alpha 0.5 --beta -0.25 --json",
    "simulate --rod nitinol --mean 0.2Fcr --amplitude 0.2Fcr --frequency 150 --duration 5ms --segments 40 --frames 4",
    "simulate --rod nitinol --mean 0.8Fcr --amplitude 0.7Fcr --frequency 150 --duration 5ms --segments 60 --mu 0.1 "
    "--kick 8:50mm/s --frames 3 --out run.npz --json",
    "ensemble study.toml",
    "ensemble study.toml --store runs.npz --resume --confidence 0.9 --json",
    "explore --rod nitinol --mean 0.3 --amplitude 0.3 --frequency 24Hz --out explorer.png",
    "example",
    "example my_rod.toml survey.csv --out tried --overwrite --json",
    "--version",
    "--help",
)
"""Lines that are answered at once."""

STREAMS = {"": False, "2>&-": False, "2>&- <&-": False, ">&-": True, ">&- 2>&-": True}
if sys.platform == "linux":
    STREAMS |= {"2>/dev/full": False, ">/dev/full": True}
elif sys.platform == "win32":
    STREAMS = {"": False}
"""Redirections of the shell, and whether the answer is lost with them."""

TOKENS = (
    "",
    " ",
    "-",
    "--",
    "x",
    "nan",
    "inf",
    "-inf",
    "1e400",
    "-1",
    "0",
    "0Hz",
    "1e-300",
    "5e-324N",
    "1e300N",
    "9" * 400,
    "0:0",
    "1:0Fcr",
    "0:20Hz",
    ":",
    "1:2:3",
    "0.2fcr",
    "50 mm/s",
    "1e9lbf",
    "٣",
    "1,2",
    "1-99999999999",
    "7-3",
    "0x10",
    "10x",
    "1x1",
    "2x3",
    "/",
    ".",
    "no/such/folder/f.npz",
    "f.exe",
    "chart.npz",
    "rod.toml",
    "nitinol",
    "system.toml",
    "system.npz",
    "study.toml",
    "--store",
    "runs.npz",
    "runs.zarr",
    "1/2",
    "--part",
    "--resume",
    "--over",
    "kick,seed",
    "kick,kick",
    "bad_system.toml",
    "family.toml",
    "--set",
    "omega=2.5",
    "omega=",
    "=1",
    "zeta=1:2",
    "epsilon=1e400",
    "--system",
    "--method",
    "half_period",
    "spectral",
    "A:6",
    "E",
    "8:50mm/s",
    "8:",
    "--json",
    "--mu",
    "--friction",
    "0.1",
    "--kick",
    "50mm/s",
    "--growth",
    "--growth-tolerance",
    "--damping-rate",
    "--modes",
    "--paper-criterion",
    "exact",
    "--exit-code",
    "--unit",
    "Hz",
    "--help",
    "--help-all",
    "\x00",
    "\n",
    "\udcff",
    "{}",
    "%s",
    "é€",
)


def check(rng: np.random.Generator) -> Found:
    """Run one line in this process, one in forty in a process of its own."""
    line = mutate(shlex.split(str(rng.choice(LINES))), rng)
    table()  # files that lines name
    with contextlib.chdir(folder()):
        if rng.random() < 0.025 and not any("\x00" in word or "\udcff" in word for word in line):
            streams = str(rng.choice(list(STREAMS)))
            done = _apart(line, streams)
            wrong = _judge_lost(*done, streams) if streams else _judge(*done, line)
        else:
            wrong = _judge(*here(line), line)
    return Found(1, [f"floquetrod {shlex.join(line)!r}: {what}" for what in wrong])


def mutate(words: list[str], rng: np.random.Generator) -> list[str]:
    """Return the line with none to three words replaced, dropped, doubled, inserted or exchanged."""
    words = list(words)
    for _ in range(int(rng.integers(4))):
        at = int(rng.integers(1, len(words) + 1)) if words else 0
        what = int(rng.integers(5))
        if what == 0 or at >= len(words):
            words.insert(at, str(rng.choice(TOKENS)))
        elif what in (1, 2):
            words[at] = str(rng.choice(TOKENS))
        elif what == 3:
            words.insert(at, words[at])
        else:
            del words[at]
    return words


def here(words: list[str]) -> tuple[int | None, str, str]:
    """Run the command in this process; return status, output and errors, None where it would have run on."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            with limit():
                status: int | None = cli.main(words)
        except SystemExit as end:
            status = 0 if end.code is None else int(end.code)
        except TookTooLong as error:
            if words[0] != "simulate":  # which says how far it is, and may be interrupted
                raise TookTooLong(f"floquetrod {shlex.join(words)!r}: {error}") from None
            status = None
        except Exception as error:
            return -1, out.getvalue(), told(error)
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")
    return status, out.getvalue(), err.getvalue()


def _apart(words: list[str], streams: str) -> tuple[int, str, str]:
    command = [sys.executable, "-m", "floquetrod", *words]
    if streams:
        command = ["sh", "-c", f'exec "$@" {streams}', "sh", *command]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    return done.returncode, done.stdout, done.stderr


def _judge_lost(status: int, out: str, err: str, streams: str) -> list[str]:
    """Judge a command that cannot write to some of its streams."""
    wrong = [f"{streams}: traceback: {err[-300:]!r}"] if "Traceback" in out + err else []
    if status not in ({2} if STREAMS[streams] else STATUSES):
        wrong.append(f"{streams}: exit status {status}: {err[-300:]!r}")
    return wrong


def _judge(status: int | None, out: str, err: str, words: list[str]) -> list[str]:
    if status is None:
        return []
    wrong = []
    if status not in STATUSES:
        wrong.append(f"exit status {status}: {err[-300:]!r}")
    if "Traceback" in out + err:
        wrong.append(f"traceback: {err[-300:]!r}")
    if status == 2 and (
        err.count("floquetrod: error:") != 1 or not err.rstrip("\n").split("\n")[-1].startswith("floq")
    ):
        wrong.append(f"no error on one line: {err[-300:]!r}")
    if status == 0 and "--json" in words and not {"--help", "--help-all"} & set(words) and out.startswith("{"):
        wrong += _strict(out)
    return wrong


def _strict(text: str) -> list[str]:
    def refuse(name: str) -> float:
        raise ValueError(f"{name} is not JSON")

    try:
        json.loads(text, parse_constant=refuse)
    except ValueError as error:
        return [f"output is not strict JSON: {error}"]
    return []
