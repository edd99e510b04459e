"""The command line: one thin function a command, and the meaning of its words; `symrt.cli` assembles them.

Nothing slow is imported here before a command needs it, so that ``symrt --help`` answers at once.
"""
