"""The suite, in folders as in the package; beside them the whole: agreement, the public face, the repository."""
