"""The certified clip, compiled: see `symrt.gamut.clipping`."""
