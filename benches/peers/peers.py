"""Solves the problems with other solvers on command, a line each.

src/peers/child.rs has the format.

    python3 peers.py problems.json
"""

import signal
import sys
import time

import numba

import systems
import with_diffsol
import with_heyoka
import with_numba
import with_scipy

# A solver that takes longer than this, in seconds, to compile and run once has failed.
TIME_LIMIT = 60
PEERS = (with_scipy, with_numba, with_heyoka, with_diffsol)


def answer(*cells):
    print(*cells, sep=",", flush=True)


def prepare(problem, calls):
    system = systems.make_compiled(problem, numba.njit)
    for peer in PEERS:
        for solver, setting, tolerance, build in peer.curves(problem, system):
            signal.alarm(TIME_LIMIT)
            try:
                call, compiled = build()
                begin = time.perf_counter()
                events = call()
                first = time.perf_counter() - begin
                # What a solver does only in its first run is compilation too.
                compiled += max(first - seconds(call, 0.0), 0.0)
            # A solver that fails gets a note in its row, and the others go on.
            except Exception as error:
                reason = " ".join(f"failed: {type(error).__name__}: {error}".split())[:200]
                answer("cannot", solver, setting, repr(tolerance), reason)
                continue
            finally:
                signal.alarm(0)
            text = ";".join(f"{kind}@{float(t)!r}" for kind, t in events)
            answer("curve", len(calls), solver, setting, repr(tolerance), f"{compiled:.6g}", text)
            calls.append(call)


def seconds(call, batch):
    count, begin = 0, time.perf_counter()
    while True:
        call()
        count += 1
        spent = time.perf_counter() - begin
        if spent >= batch:
            return spent / count


def late(_signal, _frame):
    raise TimeoutError(f"not done after {TIME_LIMIT} s")


def main():
    signal.signal(signal.SIGALRM, late)
    problems, calls = systems.load(sys.argv[1]), []
    versions = [pair for peer in PEERS for pair in peer.VERSIONS]
    for line in sys.stdin:
        command, *arguments = line.split()
        if command == "prepare":
            for package, number in versions:
                answer("version", package, number)
            versions = []
            prepare(problems[arguments[0]], calls)
        elif command == "time":
            index = int(arguments[0])
            answer("seconds", index, repr(seconds(calls[index], float(arguments[1]))))
        answer("done")


if __name__ == "__main__":
    main()
