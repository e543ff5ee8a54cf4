"""Kernels that execute pages are forked from a process that has done what is in `preloaded`: three seconds less a page.

Each starts as a new one does, with the environment and the folder that Jupyter gives it, and in a session of its own.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
from multiprocessing import forkserver
from pathlib import Path
from typing import TYPE_CHECKING, Any
from unittest import mock

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

    import sphinx.application

INLINE = "module://matplotlib_inline.backend_inline"


class Forked:
    """A kernel, as what of `subprocess.Popen` Jupyter asks for."""

    stdin = stdout = stderr = None

    def __init__(self, command: list[str], cwd: str, env: dict[str, str]) -> None:
        context = multiprocessing.get_context("forkserver")
        here, there = context.Pipe(duplex=False)
        self.process = context.Process(target=serve, args=(there, command, cwd, env))
        self.process.start()
        here.recv()  # Jupyter asks for its session at once
        self.pid = self.process.pid

    def poll(self) -> int | None:
        """Return the exit status, None while it runs."""
        return self.process.exitcode

    def wait(self) -> int | None:
        """Wait for its end."""
        self.process.join()
        return self.process.exitcode

    def send_signal(self, number: int) -> None:
        """Send it a signal."""
        os.kill(self.process.ident or 0, number)

    def terminate(self) -> None:
        """Ask it to end."""
        self.process.terminate()

    def kill(self) -> None:
        """End it."""
        self.process.kill()


def serve(started: Connection, command: list[str], cwd: str, env: dict[str, str]) -> None:
    """Be the kernel that a command line starts: python, options, -m, ipykernel_launcher and its arguments."""
    from ipykernel.kernelapp import IPKernelApp

    os.setsid()
    started.send(True)
    os.environ.clear()
    os.environ.update(env)
    os.chdir(cwd)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    # The default of this option was read from the environment when ipykernel was imported.
    parent = f"--IPKernelApp.parent_handle={env['JPY_PARENT_PID']}"
    IPKernelApp.launch_instance([*command[command.index("-m") + 2 :], parent])


def launch(cmd: list[str], *, env: dict[str, str], cwd: str, **_: Any) -> Forked:
    """Start a kernel, as `jupyter_client.launcher.launch_kernel` does; the first starts the process they come from."""
    # As kernels set the backend before matplotlib is imported.
    paths = {"PYTHONPATH": str(Path(__file__).parent), "PYDEVD_DISABLE_FILE_VALIDATION": "1"}
    with mock.patch.dict(os.environ, MPLBACKEND=INLINE, **paths):
        forkserver.ensure_running()
    return Forked(cmd, cwd, {**env, "JPY_PARENT_PID": str(os.getpid())})


def setup(app: sphinx.application.Sphinx) -> dict[str, bool]:
    """Let kernels be started so."""
    from jupyter_client.provisioning import local_provisioner

    if "forkserver" in multiprocessing.get_all_start_methods():
        forkserver.set_forkserver_preload(["preloaded"])
        local_provisioner.launch_kernel = launch  # type: ignore[assignment]
    return {"parallel_read_safe": True}
