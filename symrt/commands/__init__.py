"""What the command line's words stand for, and one thin function a command; `symrt.cli` assembles them.

Nothing slow is imported here before a command needs it, so that ``symrt --help`` answers at once.
"""
