"""symrt: a symbolic spectral ray tracer.

A scene is rendered once, with every light and material left free as symbols, and then answers without rendering again.
The public names are grouped by the five steps of the method; each loads on first use.
"""

__version__ = "0.1.0"
