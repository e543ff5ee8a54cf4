"""The repository: layers, words, site, examples in prose, release, the suite itself."""
