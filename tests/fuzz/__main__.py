"""Run attacks from fresh or given seeds, each in a process of its own, and print what they found."""

from __future__ import annotations

import argparse
import json
import os
import secrets
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait

from tests.fuzz.core import ATTACKS, Tally, load, run

_LONGEST = 1800.0  # seconds that one attack may take from one seed: beyond, it hangs


def main(argv: list[str] | None = None) -> int:
    """Run what was asked for; the exit status is 1 when something failed and 130 after Ctrl-C."""
    options = _parser().parse_args(argv)
    # A job in the background inherits that Ctrl-C is ignored: attacks send it, and what was found is printed after it.
    if threading.current_thread() is threading.main_thread() and signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    attacks = options.only or list(ATTACKS)
    if options.case is not None or options.record:
        return _here(attacks[0], options)
    first = secrets.randbits(31) if options.seed is None else options.seed
    print(f"attacks: {', '.join(attacks)}; seeds from {first}", flush=True)
    return Campaign(attacks, options.cases).run(first, options.seeds, options.minutes, options.workers)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    parser.add_argument("--only", action="append", choices=ATTACKS, help="an attack; repeatable (default: all)")
    parser.add_argument("--seed", type=int, help="the first seed (default: a fresh one)")
    parser.add_argument("--seeds", type=int, default=1, help="how many seeds (default 1)")
    parser.add_argument("--minutes", type=float, help="go on with further seeds until the time is up")
    parser.add_argument("--workers", type=int, default=1, help="attacks that run at the same time (default 1)")
    parser.add_argument("--cases", type=int, help="cases from each seed (default: what an attack names)")
    parser.add_argument("--case", type=int, help="run this case alone, as a failure names it")
    parser.add_argument("--record", action="store_true", help="one attack and seed here, a line of JSON for each case")
    return parser


def _here(attack: str, options: argparse.Namespace) -> int:
    """Run cases in this process."""
    if options.seed is None:
        raise SystemExit("--seed must be given with --case and --record: it says which numbers are drawn")
    cases = (
        range(options.cases or load(attack).CASES) if options.case is None else range(options.case, options.case + 1)
    )
    failed = False
    for tally in run(attack, options.seed, cases):
        failed |= bool(tally.failures)
        if options.record:
            print(json.dumps([tally.answers, tally.seconds, tally.failures]), flush=True)
        else:
            print(f"case {options.case}: {tally.answers} answers, {tally.seconds:.2f} s")
            print("\n".join(tally.failures) or "held")
    return int(failed)


class Campaign:
    """Attacks under way, and their tallies."""

    def __init__(self, attacks: list[str], cases: int | None) -> None:
        """Begin with nothing found."""
        self.attacks, self.cases = attacks, cases
        self.tallies = {name: Tally(name) for name in attacks}
        self.processes: set[subprocess.Popen[str]] = set()
        self.stopped = False

    def run(self, first: int, seeds: int, minutes: float | None, workers: int) -> int:
        """Run attack by attack, seed by seed; print the table whatever ends it."""
        started = time.monotonic()
        status = 0
        with ThreadPoolExecutor(workers) as pool:
            running: set[Future[None]] = set()
            try:
                seed = first
                while self._goes_on(seed - first, seeds, started, minutes):
                    for attack in self.attacks:
                        if len(running) >= workers:
                            done, running = wait(running, return_when=FIRST_COMPLETED)
                            for task in done:
                                task.result()
                        running.add(pool.submit(self.one, attack, seed))
                    seed += 1
                for task in running:
                    task.result()
            except KeyboardInterrupt:
                status = 130
                self._stop()
        print(self.table(), flush=True)
        return status or int(any(tally.failures for tally in self.tallies.values()))

    def _goes_on(self, done: int, seeds: int, started: float, minutes: float | None) -> bool:
        if minutes is None:
            return done < seeds
        return time.monotonic() - started < 60.0 * minutes

    def one(self, attack: str, seed: int) -> None:
        """Run one attack from one seed in a process of its own: a hang or a crash is a failure like others."""
        if self.stopped:
            return
        command = [sys.executable, "-m", "tests.fuzz", "--record", "--only", attack, "--seed", str(seed)]
        command += [] if self.cases is None else ["--cases", str(self.cases)]
        tally = self.tallies[attack]
        before = tally.cases, tally.answers, len(tally.failures)
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, start_new_session=True)
        self.processes.add(process)
        alarm = threading.Timer(_LONGEST, process.kill)
        alarm.start()
        cases = 0
        for line in process.stdout or ():
            answers, seconds, failures = json.loads(line)
            tally.add(Tally(attack, 1, answers, seconds, failures))
            cases += 1
            for failure in failures:
                print(failure, flush=True)
        status = process.wait()
        if process.stdout is not None:
            process.stdout.close()
        alarm.cancel()
        told = status == 1 and len(tally.failures) > before[2]  # without a failure 1 is Python's own, of an exception
        if status != 0 and not told and not self.stopped:
            line = f"python -m tests.fuzz --only {attack} --seed {seed} --case {cases}  # ended with status {status}"
            tally.add(Tally(attack, 1, 0, 0.0, [line]))
            print(line, flush=True)
        self.processes.discard(process)
        now = tally.cases, tally.answers, len(tally.failures)
        made = [after - old for after, old in zip(now, before, strict=True)]
        print(f"{attack}, seed {seed}: {made[0]} cases, {made[1]} answers, {made[2]} failures", flush=True)

    def _stop(self) -> None:
        """End the processes; what they found so far is in the tallies."""
        self.stopped = True
        for process in list(self.processes):
            os.killpg(process.pid, signal.SIGKILL)

    def table(self) -> str:
        """Return the summary."""
        lines = ["", f"{'attack':<12}{'cases':>9}{'answers':>12}{'failures':>10}{'seconds':>10}"]
        for tally in self.tallies.values():
            counts = f"{tally.cases:>9,}{tally.answers:>12,}{len(tally.failures):>10}{tally.seconds:>10.1f}"
            lines.append(f"{tally.attack:<12}{counts}")
        return "\n".join(lines)


if __name__ == "__main__":
    raise SystemExit(main())
