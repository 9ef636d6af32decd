"""Times of NumPy's sort of packed (key, number) words, of the same from keys to keys and numbers, and of its argsort, beside those of `benches/sort.rs`, by turns on the same machine.

    python3 -m venv venv && venv/bin/pip install numpy
    venv/bin/python benches/peers/numpy_sort.py [COMMAND ...]

COMMAND runs the bench, by default `cargo bench --quiet --bench sort --`; what it times is put to it as its last argument.
NumPy 2 sorts both with AVX-512 where the processor has it, in one thread. The words are as random as the bench's keys:
32 bits of key, 32 bits of number. Ratios are to the sort of packed words; the argsort is not stable.
"""

import re
import statistics
import subprocess
import sys
import time

import numpy as np

ROUNDS = 7
SORTS = 5
POWERS = (16, 18, 20)


def numpy_time(work, argument):
    """Median milliseconds of work on a copy."""
    times = []
    for _ in range(SORTS):
        copy = argument.copy()
        start = time.perf_counter()
        work(copy)
        times.append(1e3 * (time.perf_counter() - start))
    return statistics.median(times)


def sorted_pairs(keys):
    """What the sorts of the bench do: keys in order, and the number of each; words are packed and taken apart here."""
    numbers = np.arange(len(keys), dtype=np.uint64)
    words = keys.astype(np.uint64) << np.uint64(32) | numbers
    words.sort()
    return (words >> np.uint64(32)).astype(np.uint32), words.astype(np.uint32)


def bench_times(command, power):
    """Median milliseconds of each row."""
    output = subprocess.run([*command, f"2^{power}"], check=True, capture_output=True, text=True).stdout
    rows = re.findall(rf"^(.*): 2\^{power}\s+([\d.]+)", output, re.MULTILINE)
    return {name: float(median) for name, median in rows}


def main():
    command = sys.argv[1:] or ["cargo", "bench", "--quiet", "--bench", "sort", "--"]
    random = np.random.default_rng(1)
    print(f"NumPy {np.__version__}\n{'':<24} {'median ms':>9} {'min':>8} {'max':>8} {'over NumPy':>11}")
    for power in POWERS:
        count = 1 << power
        keys = random.integers(0, 1 << 32, count, dtype=np.uint64)
        packed = keys << np.uint64(32) | np.arange(count, dtype=np.uint64)
        rounds = []
        for _ in range(ROUNDS):
            own = {
                "NumPy": numpy_time(np.ndarray.sort, packed),
                "NumPy, from keys": numpy_time(sorted_pairs, keys.astype(np.uint32)),
                "NumPy, argsort": numpy_time(np.argsort, keys.astype(np.uint32)),
            }
            rounds.append({**own, **bench_times(command, power)})
        for name in rounds[0]:
            times = [row[name] for row in rounds]
            ratio = statistics.median(row[name] / row["NumPy"] for row in rounds)
            label = f"{name}: 2^{power}"
            print(f"{label:<24} {statistics.median(times):9.2f} {min(times):8.2f} {max(times):8.2f} {ratio:11.3f}")


main()
