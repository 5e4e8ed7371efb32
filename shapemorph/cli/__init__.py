"""The command line: a table of commands."""

import os

# Threads that wait for their next loop sleep. By default they spin, on cores where the other
# surface is flattened and pictures are drawn. Libraries read both when they are loaded.
os.environ.setdefault("OMP_WAIT_POLICY", "passive")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from shapemorph.cli.main import main
