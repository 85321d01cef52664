"""`python -m geodesic_ivp` is the program itself, where the folder of its script is not on the PATH."""

import subprocess
import sys

from ._program import program

sys.exit(subprocess.call([str(program()), *sys.argv[1:]]))
