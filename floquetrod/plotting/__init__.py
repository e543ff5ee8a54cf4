"""The one package that knows matplotlib: a module for each kind of picture."""
