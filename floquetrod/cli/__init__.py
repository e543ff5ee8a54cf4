"""The terminal."""

from floquetrod.cli.main import main as main
