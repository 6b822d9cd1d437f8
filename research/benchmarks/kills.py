"""Commands that are killed, and disks that are full: `python -m research.benchmarks.kills [--kills 100] [--disks 20]`.

A command is ended after a random share of the time that it takes, by Ctrl-C, SIGTERM or SIGKILL in turn. Then the same
command is run to its end in the same folder. Counted is what a user would find: a result that is there in part, a
scratch folder that stays after the next command (one of this minute is spared, so it is made older), a next command
that fails. `run` keeps its plans before they are bounded: these alone are no half of a result. Full disks are file
systems in memory (`mount -t tmpfs`, which needs the rights of root) of a random size below what the results need.
"""

import argparse
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

COMMANDS = {
    "run": ("mine/config.yaml", "--out", "OUT"),
    "identify": ("mine/robot.yaml", "recordings.csv", "--targets", "mine/config.yaml", "--out", "OUT"),
    "diagnose": ("mine/robot.yaml", "recordings.csv", "--out", "OUT"),
}
COMPLETE = {
    "run": {"pareto.csv", "plan.csv", "plans.csv", "report.html", "run.json"},
    "identify": {"identification.json", "model.yaml", "report.html"},
    "diagnose": {"diagnosis.json", "model.yaml", "report.html"},
}
PLANS = {"pareto.csv", "plan.csv"}
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGKILL)


def started(name: str, out: Path, folder: Path) -> subprocess.Popen[bytes]:
    arguments = [str(out) if part == "OUT" else part for part in COMMANDS[name]]
    command = [sys.executable, "-m", "expdesign", name, *arguments, "--force"]
    return subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)


def ended(name: str, out: Path, folder: Path) -> int:
    process = started(name, out, folder)
    process.communicate()
    return process.returncode


def done(*arguments: str, folder: Path) -> None:
    command = [sys.executable, "-m", "expdesign", *arguments]
    subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def prepared(folder: Path) -> dict[str, float]:
    """A configuration and recordings; how long each command takes (s)."""
    done("new", "hexapod", "--out", "mine", folder=folder)
    config = folder / "mine" / "config.yaml"
    text = config.read_text(encoding="utf-8")
    config.write_text(text.replace("optimiser: {", "optimiser: {generations: 3, ", 1), encoding="utf-8")
    seconds = {}
    for name in COMMANDS:
        if name == "identify":
            done("simulate", "mine/config.yaml", "first-run/plan.csv", "--out", "recordings.csv", folder=folder)
        begun = time.monotonic()
        assert ended(name, folder / f"first-{name}", folder) == 0
        seconds[name] = time.monotonic() - begun
    return seconds


def faults(name: str, out: Path, before: Path) -> list[str]:
    """What is wrong of what an ended command left."""
    found = []
    there = {path.name for path in out.iterdir() if not path.name.startswith(".")} if out.exists() else set()
    if there and not there >= COMPLETE[name] and not (name == "run" and there == PLANS):
        found.append(f"half a folder: {', '.join(sorted(there))}")
    if out.exists() and before.exists():
        empty = [path.name for path in out.iterdir() if path.is_file() and path.stat().st_size == 0]
        found += [f"empty: {', '.join(empty)}"] if empty else []
    return found


def _scratches(folder: Path) -> list[Path]:
    return [path for path in folder.iterdir() if path.name.startswith(".") and path.is_dir()]


def killed(repetitions: int, folder: Path, draw: random.Random) -> Counter[str]:
    """What was found after so many kills, by what it is."""
    seconds, found = prepared(folder), Counter[str]()
    for index in range(repetitions):
        name, how = list(COMMANDS)[index % len(COMMANDS)], SIGNALS[(index // len(COMMANDS)) % len(SIGNALS)]
        out = folder / f"out-{index}"
        if index % 2:  # half of them into a folder that is there
            shutil.copytree(folder / f"first-{name}", out)
        process = started(name, out, folder)
        time.sleep(draw.uniform(0.05, 1.0) * seconds[name])
        process.send_signal(how)
        process.communicate(timeout=120)
        found.update(f"{how.name}, {name}: {fault}" for fault in faults(name, out, folder / f"first-{name}"))
        for scratch in _scratches(folder):
            os.utime(scratch, (0.0, 0.0))
        if ended(name, out, folder) != 0:
            found[f"{how.name}, {name}: the next command failed"] += 1
        for scratch in _scratches(folder):
            found[f"{how.name}, {name}: left behind {scratch.name}"] += 1
            shutil.rmtree(scratch)
        shutil.rmtree(out, ignore_errors=True)
    return found


def full_disks(repetitions: int, folder: Path, draw: random.Random) -> Counter[str]:
    """What was found on so many full disks."""
    found = Counter[str]()
    for index in range(repetitions):
        name = list(COMMANDS)[index % len(COMMANDS)]
        needed = sum(path.stat().st_size for path in (folder / f"first-{name}").iterdir() if path.is_file())
        disk = folder / f"disk-{index}"
        disk.mkdir()
        size = int(draw.uniform(0.02, 0.95) * needed)
        subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(disk)], check=True)
        try:
            process = started(name, disk / "out", folder)
            said = process.communicate()[1].decode()
            if process.returncode != 2:
                found[f"{name}: exit {process.returncode} on a full disk"] += 1
            if "Complete and kept" not in said:  # `run` keeps the files that had room, and says which
                found.update(f"{name}: {fault}" for fault in faults(name, disk / "out", folder))
            left = [path.name for path in disk.iterdir() if path.name.startswith(".")]
            found.update(f"{name}: left behind {each.split('-')[0]}" for each in left)
        finally:
            subprocess.run(["umount", str(disk)], check=True)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--disks", type=int, default=20)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        draw = random.Random(1)
        for what, found, count in (
            ("kills", killed(options.kills, Path(name), draw), options.kills),
            ("full disks", full_disks(options.disks, Path(name), draw), options.disks),
        ):
            print(f"{count} {what}: {sum(found.values())} faults")
            for fault, times in found.most_common():
                print(f"  {times} × {fault}")


if __name__ == "__main__":
    main()
