"""The command line: the same verbs as the library, one thin function a command."""
