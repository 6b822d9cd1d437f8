"""Make the pages of `results/real` again: `python -m benchmarks.real_recordings [NAME ...]`.

The recordings are looked for in the folder that the environment variable EXPDESIGN_RECORDINGS names, or in
`../shared/recordings`. With names only those pages are made, and the summary's other rows stay.
"""

import json
import math
import subprocess
import sys
import time
from pathlib import Path

from benchmarks.real_recordings.page import page
from benchmarks.real_recordings.sets import CASES, VARIABLE, Case, folder
from benchmarks.real_recordings.transfer import transfer
from benchmarks.real_recordings.unmarked import form, unmarked

from expdesign.chain.recordings.reader import read_recordings
from expdesign.diagnosis.diagnose import diagnose
from expdesign.estimation.identify import identify
from expdesign.mechanics.robots.robot_file import read_robot

ROOT = Path(__file__).resolve().parents[2]
OUT = ROOT / "results" / "real"


def run(case: Case, root: Path) -> dict[str, object]:
    """Identify and diagnose one file, write its page, and return its row of the summary."""
    place = root / case.folder
    robot = read_robot(place / case.robot)
    recordings = read_recordings(place / f"{case.file}.csv", robot)
    identified = identify(robot, recordings)
    start = time.process_time()
    result = diagnose(robot, recordings, report=lambda text: print(f"{case.name}: {text}", file=sys.stderr))
    seconds = time.process_time() - start
    others = [transfer(result, place / f"{other}.csv") for other in case.others]
    text = page(case, identified, result, others, place / "README.md")
    (OUT / f"{case.name}.html").write_text(text, encoding="utf-8")
    alone = unmarked(robot, recordings, result)
    stable = result.stability
    return {
        "name": case.name,
        "rows": len(recordings),
        "verdict": result.verdict,
        "before": result.errors.test_before,
        "after": result.errors.test_after,
        "target": case.target,
        "known": case.known,
        "effects": "; ".join(
            f"{f.physics} at {f.component}" + (f" ({form(f)})" if f.variant else "") for f in result.findings
        ),
        "coverage": result.errors.coverage if math.isfinite(result.errors.coverage) else None,
        "stable": None if stable is None else stable.same,
        "unmarked_verdict": alone.verdict,
        "unmarked_after": alone.after,
        "common": alone.common,
        "different": alone.different,
        "seconds": seconds,
        "state": _state(),
    }


def _state() -> str:
    """The last commit of the package, which made the page."""
    command = ["git", "log", "-1", "--format=%h", "--", "src"]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False).stdout.strip() or "unknown"


def summary(rows: list[dict[str, object]]) -> str:
    """The README of the pages."""
    lines = [
        "# Recordings of real machines",
        "",
        "Made by `python -m benchmarks.real_recordings`; the recordings lie beside the project (environment",
        f"variable `{VARIABLE}`, or `../shared/recordings`), belong to others, and are not part of it. Each page names",
        "source and licence. **The rows and pages of the `jaibot` sets are derived from data under CC BY-NC-SA 3.0",
        "(copyright Hilti, Hilti-Research on GitHub) and are under that licence**; those of `tiago` are derived from",
        "data under Apache 2.0.",
        "",
        "Held-out errors are in standard deviations as the recordings state them (1 is the noise). CPU is of",
        "`diagnose` on one core. The state is the last commit of the package when the page was made.",
        "",
        "Best known: of any model known before, see `benchmarks/real_recordings/sets.py`.",
        "",
        "| file | rows | verdict | base model | now | target | best known | physics | CPU, s | state |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    lines += [
        f"| [{row['name']}]({row['name']}.html) | {row['rows']} | {row['verdict']} | {row['before']:.3g} | "
        f"{row['after']:.3g} | {_number(row.get('target'))} | {_number(row.get('known'))} | "
        f"{row['effects'] or 'none'} | {row['seconds']:.0f} | {row.get('state', 'unknown')} |"
        for row in rows
    ]
    lines += [
        "",
        "## How far names and intervals can be relied on",
        "",
        "Coverage: share of held-out readings within their predicted 95 % intervals. Refits: share of refits, each",
        "without a tenth of the rows, that name the same (– where only laws were added). Fitted rows alone: the same",
        "diagnosis of a file without the rows marked `test`, judged on those, with the number of effects in common",
        "with the one above and of those that only one of the two has.",
        "",
        "| file | coverage | refits that name the same | fitted rows alone: verdict | now | in common | in one only |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    lines += [
        f"| {row['name']} | {_share(row.get('coverage'))} | {_share(row.get('stable'))} | "
        f"{row.get('unmarked_verdict', '–')} | {_number(row.get('unmarked_after'))} | {row.get('common', '–')} | "
        f"{row.get('different', '–')} |"
        for row in rows
    ]
    notes = OUT / "notes.md"
    if notes.is_file():
        lines += ["", notes.read_text(encoding="utf-8").rstrip()]
    return "\n".join(lines) + "\n"


def _number(value: object) -> str:
    return f"{value:.3g}" if isinstance(value, float) else "–"


def _share(value: object) -> str:
    return f"{100.0 * value:.0f} %" if isinstance(value, float) else "–"


def main(names: list[str]) -> int:
    """Make the pages; returns the exit code."""
    root = folder()
    if not root.is_dir():
        print(f"there are no recordings in {root}: set {VARIABLE}", file=sys.stderr)
        return 2
    OUT.mkdir(parents=True, exist_ok=True)
    store = OUT / "summary.json"
    for case in CASES:
        if names and case.name not in names:
            continue
        row = run(case, root)
        # Read anew: another process may have made other pages meanwhile.
        known = {r["name"]: r for r in json.loads(store.read_text(encoding="utf-8"))} if store.is_file() else {}
        known[case.name] = row
        rows = [known[case.name] for case in CASES if case.name in known]
        store.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
        (OUT / "README.md").write_text(summary(rows), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
