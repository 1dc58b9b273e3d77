"""``python -m tvclin`` is the command line."""

from tvclin.cli.app import main

main()
