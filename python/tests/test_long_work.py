"""Long work: Ctrl-C, progress, processes, memory, defects."""

import fcntl
import multiprocessing
import os
import pickle
import pty
import struct
import subprocess
import sys
import termios
import textwrap
import threading
import time
import types

import numpy as np
import pytest
import stickslip as ss
from stickslip import _arguments, _core, _results


def bistable(workers=-1, **more):
    x = ss.state("x")
    starts = np.linspace(-2, 2, 40).reshape(-1, 1)
    return ss.basins_of_attraction(ss.System({x: x - x**3}), starts, workers=workers, **more)


def in_child(workers):
    return bistable(workers).reached.tolist()


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_processes_do_not_hang(method):
    wanted = in_child(2)
    with multiprocessing.get_context(method).Pool(1) as pool:
        assert pool.map_async(in_child, [2]).get(timeout=120) == [wanted]


LONG = """
import signal, threading, time, numpy as np, stickslip as ss
# A shell in the background makes its children ignore the signal.
signal.signal(signal.SIGINT, signal.default_int_handler)
x, y = ss.states("x y")
p, q = ss.parameters(p=1.0, q=1.0)
system = ss.System({x: y, y: -p * x * x * x + 0.01 * q * np.cos(ss.t)}, period=2 * np.pi)
ring = ss.System({x: x * (p - x * x - y * y) - y, y: y * (p - x * x - y * y) + x})
sent = []
def interrupt():
    time.sleep(0.7)
    sent.append(time.perf_counter())
    signal.raise_signal(signal.SIGINT)
threading.Thread(target=interrupt).start()
try:
    WORK
    print("it ended by itself")
except KeyboardInterrupt as stop:
    print(time.perf_counter() - sent[0])
    part = stop.partial
    print(CHECK)
"""

ENDLESS = "(0, 1e9), [1, 0]"
LONG_WORK = [
    (f"ss.solve_ivp(system, {ENDLESS}, t_eval=[1.0])", "part.t[0] == 1 and part.status == -1"),
    (
        f"ss.solve_ivp(system, {ENDLESS}, events=[x - 9, x, y])",
        "part.t[-1] > 10 and [len(one) > 2 for one in part.t_events] == [False, True, True] "
        "and abs(part.t_events[2][-1] - part.t[-1]) < 10",
    ),
    (f"ss.solve_ivp(system, {ENDLESS}, dense_output=True)", "part.sol.t_max == part.t[-1] > 10"),
    (
        "ss.ensemble(system, [[1, 0], [0.5, 0]], (0, 1e9), [1.0, 1e9])",
        "part.status.tolist() == [-1, -1] and (part.t_end > 10).all() "
        "and np.isfinite(part.y[:, :, 0]).all() and np.isnan(part.y[:, :, 1]).all()",
    ),
    (
        "ss.ensemble(system, [1, 0], (0, 1e9), [1.0], reduce=len, parameters={p: [1, 2]})",
        "part.reduced.size == 0 and part.status.tolist() == [-1, -1]",
    ),
    ("ss.lyapunov_spectrum(system, [1, 0], duration=1e8)", "part is None"),
    ("ss.periodic_orbit(system, [1, 0], transient=1e8)", "part is None"),
    (
        "ss.basins_of_attraction(system, np.linspace(-1, 1, 1000).reshape(500, 2), longest=1e7)",
        "(part.reached == -1).any() and part.reached.shape == (500,)",
    ),
    (
        "ss.bifurcation_diagram(system, p, np.linspace(1, 2, 10**6), [1, 0], longest=20.0)",
        "0 < len(part.parameter) == len(part.points)",
    ),
    ("ss.poincare_map(system, y, [1, 0], returns=10**9)", "len(part.t) > 10"),
    (
        "ss.continuation(ring, p, (0.5, 2), [1, 0], transient=10, step=1e-5, most_points=10**6)",
        "len(part.parameter) > 1",
    ),
    (
        "ss.lyapunov_from_data(np.sin(0.05 * np.arange(1e5)) + np.sin(0.07 * np.arange(1e5)))",
        "part is None",
    ),
    (
        "ss.parameter_map(system, (p, np.linspace(1, 2, 30)), ('q', [1, 2]), [1, 0], longest=1e7)",
        "(part.kind == '').any() and part.kind.shape == (2, 30)",
    ),
]


@pytest.mark.parametrize(("work", "check"), LONG_WORK)
def test_ctrl_c_ends_work_soon_and_keeps_what_was_found(work, check):
    run = [sys.executable, "-c", LONG.replace("WORK", work).replace("CHECK", check)]
    done = subprocess.run(run, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    time, is_kept = done.stdout.split()
    assert float(time) < 0.2 and is_kept == "True"


def test_other_threads_run_meanwhile():
    """They could not, if a run kept the interpreter's lock."""
    x, v = ss.states("x v")
    counted, is_over = 0, threading.Event()

    def count():
        nonlocal counted
        while not is_over.wait(0.001):
            counted += 1

    thread = threading.Thread(target=count)
    thread.start()
    begin = time.perf_counter()
    ss.solve_ivp(ss.System({x: v, v: -(x**3)}), (0, 1e5), [1, 0], t_eval=[])
    span, seen = time.perf_counter() - begin, counted
    is_over.set()
    thread.join()
    assert span > 0.2 and seen > 100 * span


def test_an_interruption_can_be_pickled_and_is_one_of_the_keyboard():
    stop = pickle.loads(pickle.dumps(ss.Interrupted("interrupted", [1, 2])))
    assert isinstance(stop, KeyboardInterrupt) and stop.partial == [1, 2]


def test_another_signal_raises_what_its_handler_raises():
    code = """
    import signal, stickslip as ss
    def handler(*of):
        raise TimeoutError("too long")
    signal.signal(signal.SIGALRM, handler)
    signal.setitimer(signal.ITIMER_REAL, 0.3)
    x, v = ss.states("x v")
    try:
        ss.solve_ivp(ss.System({x: v, v: -x}), (0, 1e9), [1, 0], t_eval=[])
    except TimeoutError as error:
        print(error)
    """
    run = [sys.executable, "-c", textwrap.dedent(code)]
    done = subprocess.run(run, capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout == "too long\n"


PROGRESS = """
import sys
if NO_TQDM:
    sys.modules["tqdm"] = sys.modules["tqdm.auto"] = None
import numpy as np, stickslip as ss
x, v = ss.states("x v")
system = ss.System({x: v, v: -x**3 + 0.01 * np.cos(ss.t)}, period=2 * np.pi)
starts = np.random.default_rng(1).uniform(-1, 1, (12, 2))
ss.basins_of_attraction(system, starts, longest=3000, progress=SHOWN, workers=1)
"""


def on_terminal(code):
    """Capture the output of a program to a terminal."""
    leader, follower = pty.openpty()
    # Of no width nothing is drawn.
    fcntl.ioctl(follower, termios.TIOCSWINSZ, struct.pack("4H", 24, 100, 0, 0))
    run = [sys.executable, "-c", code]
    with subprocess.Popen(run, stdout=follower, stderr=follower, close_fds=True) as done:
        os.close(follower)
        written = b""
        while True:
            try:
                part = os.read(leader, 4096)
            except OSError:
                break
            if not part:
                break
            written += part
    os.close(leader)
    assert done.returncode == 0, written
    return written.decode()


@pytest.mark.parametrize("no_tqdm", [True, False])
def test_progress_is_shown_on_a_terminal_only(no_tqdm):
    code = PROGRESS.replace("NO_TQDM", str(no_tqdm))
    written = on_terminal(code.replace("SHOWN", "True"))
    assert "basins_of_attraction" in written and "12/12" in written, written
    assert on_terminal(code.replace("SHOWN", "False")) == ""
    run = [sys.executable, "-c", code.replace("SHOWN", "True")]
    done = subprocess.run(run, capture_output=True, text=True, check=True)
    assert done.stdout == done.stderr == ""


def test_one_bar_of_tqdm_is_drawn_as_the_place_demands(monkeypatch):
    """tqdm.auto chooses between a terminal's bar and a notebook's."""
    bars = []

    class Bar:
        def __init__(self, **options):
            self.n, self.is_closed, self.options = 0, False, options
            bars.append(self)

        def update(self, more):
            self.n += more

        def close(self):
            self.is_closed = True

    monkeypatch.setitem(sys.modules, "tqdm.auto", types.SimpleNamespace(tqdm=Bar))
    bistable(progress=True)
    (bar,) = bars
    assert bar.n == bar.options["total"] == 40 and bar.is_closed
    # In a notebook None shows it; elsewhere it hides it where there is no terminal.
    assert bar.options["disable"] is None


def test_an_error_in_a_report_ends_the_work():
    x = ss.state("x")
    system = ss.System({x: np.cos(ss.t)}, period=2 * np.pi)

    def report(at):
        raise RuntimeError(f"it is at {at}")

    until, times, made = (1e9, np.inf), np.empty(0), _arguments.settings({})
    found = _core.solve(system._core, (0.0, [0.0]), until, [], times, False, made, None, [], report)
    assert "it is at" in str(found["raised"])


def test_memory_does_not_grow_with_the_length_of_a_run():
    code = """
    import resource, stickslip as ss
    x, v = ss.states("x v")
    system = ss.System({x: v, v: -x**3})
    sizes = []
    for t_end in (1e3, 1e5):
        ss.solve_ivp(system, (0, t_end), [1, 0], t_eval=[1.0], events=[ss.event(x - 9)])
        sizes.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
    print(sizes[1] - sizes[0])
    """
    run = [sys.executable, "-c", textwrap.dedent(code)]
    done = subprocess.run(run, capture_output=True, text=True, check=True, timeout=120)
    # Kibibytes, for a hundred thousand steps.
    assert int(done.stdout) < 2048


def test_a_panic_of_the_engine_is_an_internal_error():
    with pytest.raises(ss.InternalError, match="a defect of stickslip: on purpose"):
        _results.call_engine(_core._unwind)
