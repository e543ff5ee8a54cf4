"""The explorer: window, browser, notebook."""
