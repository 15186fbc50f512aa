"""The command line: a command reads its options, makes one call and prints. Heavy imports stay inside the functions."""
