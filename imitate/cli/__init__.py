"""The command line: a file per verb. One place owns streams and exit codes."""


def main() -> None:
    """Entry point."""
    raise SystemExit("no verbs yet")
