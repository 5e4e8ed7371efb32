"""The command line: a table of commands."""

import os

# Threads that wait for their next loop sleep. By default they spin, on cores where the other
# surface is flattened and pictures are drawn. The models of the sections need no plugins, which
# are sought among all that is installed. Libraries read these when they are loaded.
os.environ.setdefault("OMP_WAIT_POLICY", "passive")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")

from shapemorph.cli.main import main
