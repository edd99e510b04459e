"""Rays against shapes, compiled (step 1): what the records' own modules tell in NumPy, to the same bits.

All kernels are asked alike: ``kernel(*constants, origin, direction, left, low, any_hit, index, distance, shape,
primitive, doubtful)``.  Rays that meet the shape beyond `low` and before their ``distance`` get its crossing, and
`index` as their ``shape``; with `any_hit`, a ray that has a shape already is not asked again.  Rays that only rationals
can decide are left as they are and listed in `doubtful`, whose length is the answer: NumPy's code takes them.

A kernel is a few loops over all rays without a branch in them, which a processor does several rays at a time.  Between
them nan says that a ray's crossing is still open.
"""
