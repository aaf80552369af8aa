"""Numba kernels: floats and arrays in, floats and arrays out.

Nothing here knows scenarios, units or files, and nothing here validates:
callers have done that.  Every kernel releases the interpreter lock, so that
threads over realizations or over sweep points run in parallel.
"""
