"""Compares B2P2's model with pinocchio: builds and runs compare.cpp, which prints a table.

Needs cargo, a C++ compiler and two packages of Python: pin and cmeel-eigen (examples/README.md).
"""

import os
import pathlib
import subprocess
import sys

FOLDER = pathlib.Path(__file__).resolve().parent
ROOT = FOLDER.parent.parent
INSTALL = "pip install pin==4.1.0 cmeel-eigen==3.4.1"
COMPILER = os.environ.get("CXX", "c++")
# Those of pinocchio's own build files.
DEFINITIONS = [
    "PINOCCHIO_ENABLE_TEMPLATE_INSTANTIATION",
    "BOOST_MPL_LIMIT_LIST_SIZE=30",
    "BOOST_MPL_CFG_NO_PREPROCESSED_HEADERS",
    "NDEBUG",
]


def prefix() -> pathlib.Path:
    """Folder in which the packages put headers and libraries."""
    for folder in map(pathlib.Path, sys.path):
        found = folder / "cmeel.prefix"
        if not (found / "include/pinocchio").is_dir():
            continue
        if not (found / "include/eigen3").is_dir():
            sys.exit(f"compare.py: the package cmeel-eigen is missing: {INSTALL}")
        return found
    sys.exit(f"compare.py: the package pin (pinocchio) is missing: {INSTALL}")


def run(*command: object) -> None:
    """Runs a command in the checkout; ends the program if it fails."""
    try:
        code = subprocess.run([str(word) for word in command], cwd=ROOT).returncode
    except FileNotFoundError:
        sys.exit(f"compare.py: {command[0]} is missing")
    if code != 0:
        sys.exit(code)


def main() -> None:
    installed = prefix()
    target = ROOT / "target"
    program = target / "compare-with-pinocchio"
    run(
        *("cargo", "build", "--locked", "--release", "-p", "tautrack", "--example", "model"),
        *("--target-dir", target),
    )
    print("compiling compare.cpp takes about a minute", file=sys.stderr)
    run(
        COMPILER,
        "-std=c++17",
        "-O3",
        *(f"-D{name}" for name in DEFINITIONS),
        *("-isystem", installed / "include", "-isystem", installed / "include/eigen3"),
        FOLDER / "compare.cpp",
        target / "release/examples/libmodel.a",
        *("-L", installed / "lib", f"-Wl,-rpath,{installed / 'lib'}", "-lpinocchio_default"),
        *("-o", program),
    )
    run(program)


if __name__ == "__main__":
    main()
