"""Runs the shards of the clearance suite on the computers of a Ray cluster.

    pip install ray
    python3 examples/python/shards.py --shards 8 --runs 400 --seed 1
    cargo demo --merge target/demo/shards

Each computer needs a checkout at the same path. `ray.init` joins the cluster of RAY_ADDRESS; without
one it starts `--workers` workers on this computer. The results come back through Ray, so the
computers need no common folder.
"""

import argparse
import pathlib
import subprocess

import ray

ROOT = pathlib.Path(__file__).resolve().parents[2]


@ray.remote(num_cpus=1, max_retries=2)
def shard(command, index, count, runs, seed):
    """Returns the results of one shard: a line of JSON for each run."""
    options = ["--suite", "clearance", "--json", "--runs", str(runs), "--seed", str(seed)]
    options += ["--shard", f"{index}/{count}", "--out", f"target/demo/shard-{index}"]
    done = subprocess.run(command + options, cwd=ROOT, capture_output=True, text=True, check=False)
    lines = done.stdout.splitlines(keepends=True)
    expected = len(range(index - 1, runs, count))
    if len(lines) != expected:
        raise RuntimeError(f"{len(lines)} of {expected} runs: {done.stderr}")
    return "".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--shards", type=int, default=8)
    parser.add_argument("--runs", type=int, default=400)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "target/demo/shards")
    parser.add_argument("--demo", default="cargo demo", help="command that runs the demo")
    args = parser.parse_args()
    try:
        ray.init(address="auto")
    except ConnectionError:
        ray.init(num_cpus=args.workers)
    args.out.mkdir(parents=True, exist_ok=True)
    command = args.demo.split()
    jobs = {
        shard.remote(command, index, args.shards, args.runs, args.seed): index
        for index in range(1, args.shards + 1)
    }
    waiting = list(jobs)
    while waiting:
        [job], waiting = ray.wait(waiting)
        index = jobs[job]
        name = f"seed-{args.seed}-shard-{index}-of-{args.shards}.jsonl"
        (args.out / name).write_text(ray.get(job), encoding="utf-8")
        print(f"shard {index} of {args.shards}: {args.out / name}", flush=True)


if __name__ == "__main__":
    main()
