#!/usr/bin/env python3
"""Mutation tests of the numerical core: changes one operator or one function at a time and asks whether a test fails.

    scripts/mutants/run.py FOLDER [--only TEXT] [--sample SHARE] [--most SECONDS] [--workers N]

A build for every mutant would take days. So the project is copied to FOLDER and rewritten. One build holds all mutants;
the environment variable MUTANT switches one on. FOLDER keeps what is done: a second call goes on where the first ended,
and with a larger `--most` it goes on with the survivors.

1. The last commit is copied, rewritten, and built. Mutants that do not compile are left out (`left-out`).
2. Every test runs alone, which gives its time and the mutants that it reaches (`tests.json`).
3. For every mutant, the tests that reach it run, the quickest first, until one fails (`results.tsv`). A test that takes
   five times as long as without the mutant fails.

It prints the counts of every module, and the survivors (`survived` or `unreached` in `results.tsv`) that
`scripts/mutants/explained.toml` does not explain. If all mutants were asked for, so are explanations that fit none.
"""

import argparse
import collections
import concurrent.futures
import fnmatch
import itertools
import json
import os
import pathlib
import random
import re
import resource
import select
import signal
import subprocess
import threading
import time
import tomllib

ROOT = pathlib.Path(__file__).resolve().parents[2]
MODULES = "action diagnostics errors geometry study solve metric sbp lobatto".split()
TARGETS = ["--lib", *"--test numerics --test scenes --test world_lines --test case_scenes --test cli".split()]
# Without this level tests would be far slower; with the one of the program the build would be.
PROFILE = "{ opt-level = 1, codegen-units = 16 }"
PACKAGES = {
    "geodesic-ivp": "src",
    "geodesic-ivp-engine": "crates/engine/src",
    "geodesic-ivp-critical-point": "crates/critical-point/src",
}
MEMORY, FILE = 6 << 30, 1 << 30


def cargo(folder, *arguments):
    """The messages of cargo, and whether it succeeded."""
    command = ["cargo", *arguments, "--release", "--message-format", "json"]
    done = subprocess.run(command, cwd=folder / "tree", capture_output=True, text=True)
    return [json.loads(line) for line in done.stdout.splitlines() if line[:1] == "{"], done.returncode == 0, done.stderr


def blamed(tree, message):
    """The mutants that an error of the compiler is about: the last ones before it."""
    for span in message["spans"]:
        before = (tree / span["file_name"]).read_bytes()[: span["byte_start"]]
        if span["is_primary"] and (numbers := re.findall(rb"mutant::on\((\d+)\)", before)):
            yield numbers[-1].decode()


def rewritten(folder):
    """Writes the tree with all mutants, and their list."""
    tree, left_out = folder / "tree", folder / "left-out"
    tree.mkdir(parents=True, exist_ok=True)
    subprocess.run(f"git -C '{ROOT}' archive HEAD | tar x -C '{tree}'", shell=True, check=True)
    manifest = (tree / "Cargo.toml").read_text()
    manifest = re.sub(r"geodesic-ivp[\w-]* = \{ opt-level.*\n", "", manifest)
    profiles = "".join(f"{package} = {PROFILE}\n" for package in PACKAGES)
    manifest = manifest.replace("[profile.release.package]\n", f"[profile.release.package]\n{profiles}")
    manifest = re.sub(r"\[workspace\.lints\.\w+\]\n(.+\n)*", "", manifest)
    (tree / "Cargo.toml").write_text(manifest + '[workspace.lints.rust]\nwarnings = "allow"\n')
    folders = [tree / source / module for source in PACKAGES.values() for module in MODULES]
    paths = [path.relative_to(tree) for folder in folders for path in sorted(folder.glob("**/*.rs"))]
    files = [str(path) for path in paths if "tests" not in path.with_suffix("").parts]
    left_out.touch()
    target = folder / "rewriter"
    program = ["cargo", "run", "--release", "--quiet", "--target-dir", target, "--", tree, left_out, *files]
    listed = subprocess.run(program, cwd=ROOT / "scripts/mutants", capture_output=True, text=True, check=True).stdout
    (folder / "mutants.tsv").write_text(listed)


def build(folder):
    """The test programs."""
    while True:
        rewritten(folder)
        messages, is_built, printed = cargo(folder, "check", "--lib")
        if is_built:
            break
        errors = [it["message"] for it in messages if it.get("message", {}).get("level") == "error"]
        numbers = {number for error in errors for number in blamed(folder / "tree", error)}
        if not numbers:
            raise SystemExit(printed)
        with (folder / "left-out").open("a") as file:
            file.writelines(f"{number}\n" for number in numbers)
    messages, is_built, printed = cargo(folder, "test", "--no-run", *TARGETS)
    if not is_built:
        raise SystemExit(printed)
    return [it["executable"] for it in messages if it.get("profile", {}).get("test") and it["executable"]]


def failure(folder, program, names, seconds, **environment):
    """Runs tests of one program until one fails. What failed, or None."""
    command = [program, "--exact", "--test-threads=1", *names]
    environment |= {"RAYON_NUM_THREADS": "1", "TMPDIR": str(folder / "tmp"), "PROPTEST_MAX_SHRINK_ITERS": "0"}
    environment |= {"PROPTEST_DISABLE_FAILURE_PERSISTENCE": "true"}
    run = subprocess.Popen(
        command,
        cwd=folder / "tree",
        env=os.environ | environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    resource.prlimit(run.pid, resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.prlimit(run.pid, resource.RLIMIT_FSIZE, (FILE, FILE))
    printed, end = b"", time.monotonic() + seconds
    try:
        while select.select([run.stdout], [], [], max(0.0, end - time.monotonic()))[0]:
            if not (more := os.read(run.stdout.fileno(), 65536)):
                return None if run.wait() == 0 else "crash of one of " + " ".join(names)
            printed += more
            if failed := re.search(rb"^test (\S+)(?: - should panic)? \.\.\. FAILED", printed, re.MULTILINE):
                return failed[1].decode()
        return "time limit of one of " + " ".join(names)
    finally:
        try:
            os.killpg(run.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        run.stdout.close()
        run.wait()


def measured(folder, programs, workers):
    """For every test, its program, its time and the mutants that it reaches."""

    def one(program, name):
        log = folder / "tmp" / f"{pathlib.Path(program).name}-{name.replace(':', '.')}"
        log.unlink(missing_ok=True)
        if failed := failure(folder, program, [name], 600, MUTANT_COVER=str(log)):
            print(f"left out, as it fails without a mutant: {failed}", flush=True)
            return None
        start = time.monotonic()
        failure(folder, program, [name], 600)
        seconds = time.monotonic() - start
        reached = sorted({int(line) for line in log.read_text().split()}) if log.exists() else []
        return {"program": program, "name": name, "seconds": seconds, "reached": reached}

    tests = []
    for program in programs:
        listed = subprocess.run([program, "--list"], capture_output=True, text=True, check=True).stdout
        tests += [(program, line.removesuffix(": test")) for line in listed.splitlines() if line.endswith(": test")]
    with concurrent.futures.ThreadPoolExecutor(workers) as pool:
        return [test for test in pool.map(lambda test: one(*test), tests) if test]


class Judge:
    """Runs tests on mutants, first those that have killed mutants nearby."""

    def __init__(self, folder, tests, most):
        self.folder, self.most, self.lock = folder, most, threading.Lock()
        self.kills = collections.defaultdict(collections.Counter)
        self.reaching = collections.defaultdict(list)
        for test in sorted(tests, key=lambda test: test["seconds"]):
            for number in test["reached"]:
                self.reaching[number].append(test)

    def groups(self, file, tests, least):
        """Tests of one program each, in an order that kills soon."""
        with self.lock:
            known = dict(self.kills[file].most_common(6))
        tests = [test for test, before in zip(tests, sums(tests)) if least <= before < self.most]
        first = [test for test in tests if test["name"] in known and test["seconds"] < max(1.0, 0.5 * self.most)]
        yield from ([test] for test in sorted(first, key=lambda test: -known[test["name"]]))
        budget, group = 0.1, []
        for test in (test for test in tests if test not in first):
            group.append(test)
            if sum(test["seconds"] for test in group) > budget:
                yield from by_program(group)
                budget, group = 2.0 * budget, []
        yield from by_program(group)

    def verdict(self, number, file, least):
        """What becomes of a mutant that has survived `least` seconds of tests, and the test that kills it."""
        if not self.reaching[number]:
            return "unreached", ""
        for group in self.groups(file, self.reaching[number], least):
            limit = 5.0 * sum(test["seconds"] for test in group) + 2.0
            names = [test["name"] for test in group]
            if failed := failure(self.folder, group[0]["program"], names, limit, MUTANT=str(number)):
                with self.lock:
                    self.kills[file][failed] += 1
                return "killed", failed
        return "survived", ""


def sums(tests):
    """The seconds of a test and of those before it."""
    return itertools.accumulate(test["seconds"] for test in tests)


def by_program(tests):
    groups = collections.defaultdict(list)
    for test in tests:
        groups[test["program"]].append(test)
    return groups.values()


def counts(results):
    """Prints a line for every module."""
    table = collections.defaultdict(collections.Counter)
    for (file, *_), (verdict, *_) in results:
        table[file.split("src/", 1)[1].split("/")[0]][verdict] += 1
    print(f"{'module':12} {'mutants':>8} {'reached':>8} {'killed':>8} {'survived':>8}")
    for module, row in table.items():
        total = sum(row.values())
        print(f"{module:12} {total:8} {total - row['unreached']:8} {row['killed']:8} {row['survived']:8}")


def fits(pattern, place):
    """Whether a mutant is meant: `FILE FUNCTION TEXT`, with * in the first two; TEXT is of the change or the code."""
    parts = pattern.split(None, 2)
    file, function, text = parts + ["*", ""][len(parts) - 1 :]
    names = fnmatch.fnmatchcase(place[0], file) and fnmatch.fnmatchcase(place[3], function)
    return names and any(text in part for part in place[4:])


def unexplained(survivors, is_all):
    """Prints the survivors that no explanation fits, and the explanations that fit no survivor."""
    groups = tomllib.loads((ROOT / "scripts/mutants/explained.toml").read_text())["explained"]
    used, left = set(), []
    for place in survivors:
        found = {
            pattern
            for group in groups
            for pattern in group["mutants"]
            if fits(pattern, place) and not any(fits(other, place) for other in group.get("but", []))
        }
        used |= found
        if not found:
            left.append(place)
    print(f"{len(survivors)} survived, {len(left)} of them without an explanation")
    for file, line, _, function, *what in left:
        print(f"{file}:{line}", function, *what, sep="  ")
    for pattern in [pattern for group in groups for pattern in group["mutants"] if is_all and pattern not in used]:
        print("explains nothing:", pattern)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--only", default="", metavar="TEXT", help="mutants with this in file, function or change")
    parser.add_argument("--sample", type=float, default=1.0, metavar="SHARE", help="a random share of them")
    parser.add_argument("--most", type=float, default=20.0, metavar="SECONDS", help="of tests for one mutant")
    parser.add_argument("--workers", type=int, default=2, metavar="N")
    arguments = parser.parse_args()
    folder = arguments.folder.resolve()
    (folder / "tmp").mkdir(parents=True, exist_ok=True)
    if not (saved := folder / "tests.json").exists():
        saved.write_text(json.dumps(measured(folder, build(folder), arguments.workers)))
    judge = Judge(folder, json.loads(saved.read_text()), arguments.most)

    mutants, done, journal = {}, {}, folder / "results.tsv"
    for line in (folder / "mutants.tsv").read_text().splitlines():
        number, *place = line.split("\t")
        mutants[int(number)] = place
    for line in journal.read_text().splitlines() if journal.exists() else []:
        number, verdict, test, seconds, *_ = line.split("\t")
        done[int(number)] = verdict, test, float(seconds)
    asked = [number for number, place in mutants.items() if arguments.only in " ".join(place)]
    asked = random.Random(1).sample(asked, round(arguments.sample * len(asked)))

    def one(number):
        before, _, seconds = done.get(number, ("survived", "", 0.0))
        if before == "survived" and seconds < arguments.most:
            file = mutants[number][0]
            done[number] = *judge.verdict(number, file, seconds), arguments.most
            with judge.lock, journal.open("a") as results:
                print(number, *done[number], *mutants[number], sep="\t", file=results)

    with concurrent.futures.ThreadPoolExecutor(arguments.workers) as pool:
        list(pool.map(one, asked))
    counts([(mutants[number], done[number]) for number in asked])
    survivors = [mutants[number] for number in asked if done[number][0] != "killed"]
    unexplained(survivors, len(asked) == len(mutants))


if __name__ == "__main__":
    main()
