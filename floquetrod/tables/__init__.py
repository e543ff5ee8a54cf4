"""Tables as instruments, loggers and offices write them: text with a preamble and headings, logs, sheets."""
